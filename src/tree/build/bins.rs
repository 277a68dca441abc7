//! Splits triangles by the binned surface-area heuristic over their boxes.

use crate::tree::options::Effort;
use crate::tree::wide::WIDTH;
use glam::Vec4;
use punctual_geom::lanes::{Column, F8, Kernel, Lanes, least, per_lane};
use wide::f32x4;

/// A box as eight numbers: the negated least coordinates, the triangle's id, the greatest
/// coordinates, and 0. So the box around two boxes is one maximum, and moving a box with its id
/// copies 32 bytes.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Bounds([f32; WIDTH]);

/// Added to ids, which are below 2^30. Without it they would be denormal numbers, for which
/// arithmetic takes many times as long.
const NORMAL: u32 = 1 << 30;

impl Bounds {
    pub const EMPTY: Self = Self([f32::NEG_INFINITY; WIDTH]);

    #[inline(always)]
    pub fn new(id: u32, [x, y, z]: [f32; 3], [u, v, w]: [f32; 3]) -> Self {
        Self([-x, -y, -z, f32::from_bits(id + NORMAL), u, v, w, 0.0])
    }

    pub fn id(&self) -> u32 {
        self.0[3].to_bits() - NORMAL
    }

    /// Twice the center.
    #[inline(always)]
    pub fn center(&self) -> Vec4 {
        let [x, y, z, id, u, v, w, zero] = self.0;
        Vec4::new(u, v, w, zero) - Vec4::new(x, y, z, id)
    }
}

/// Least and greatest centers of boxes.
#[derive(Clone, Copy)]
pub(crate) struct Centers {
    pub min: Vec4,
    pub max: Vec4,
}

impl Centers {
    pub const NONE: Self = Self {
        min: Vec4::INFINITY,
        max: Vec4::NEG_INFINITY,
    };

    #[inline(always)]
    pub fn and(self, item: &Bounds) -> Self {
        let center = item.center();
        Self {
            min: self.min.min(center),
            max: self.max.max(center),
        }
    }
}

/// Splits `items` at the cheapest border between bins, if `effort` is given: items left of the
/// border come first. Returns half the surface area of the box around all items, and the number of
/// items left of the border; `None` if there is no border.
pub(crate) struct Part<'i> {
    pub items: &'i mut [Bounds],
    pub effort: Option<Effort>,
}

impl Kernel for Part<'_> {
    type Output = (f32, Option<usize>);

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> (f32, Option<usize>) {
        // Up to this number of triangles, fewer bins are used: more bins would cost more than they
        // gain.
        const FEW: usize = 64;
        let Self { items, effort } = self;
        let (mut bounds, mut centers) = (F8::load(lanes, &Bounds::EMPTY.0), Centers::NONE);
        for item in &*items {
            bounds = bounds.max(F8::load(lanes, &item.0));
            centers = centers.and(item);
        }
        let [x, y, z, _] = extent(bounds).to_array();
        let middle = match (effort, items.len() > FEW) {
            (Some(Effort::Normal), true) => part::<L, 16>(lanes, items, centers),
            (Some(_), _) => part::<L, 8>(lanes, items, centers),
            (None, _) => None,
        };
        (x * y + y * z + z * x, middle)
    }
}

/// Splits `items` at a border of `N` bins per axis.
#[inline(always)]
fn part<L: Lanes, const N: usize>(
    lanes: L,
    items: &mut [Bounds],
    centers: Centers,
) -> Option<usize> {
    let binning = Binning::<N>::of(centers);
    let mut bins = [[Bounds::EMPTY; N]; 3];
    // Counts are exact up to 2^24 triangles per bin. Beyond, only the quality of the border
    // suffers.
    let mut counts = [[0.0; N]; 3];
    for item in &*items {
        let (bounds, at) = (F8::load(lanes, &item.0), binning.bins(item));
        for k in 0..3 {
            if binning.axes[k] {
                let bin = &mut bins[k][at[k]].0;
                bounds.max(F8::load(lanes, bin)).put(bin);
                counts[k][at[k]] += 1.0;
            }
        }
    }
    let mut costs = [[f32::INFINITY; N]; 3];
    let mut lowest = [F8::splat(lanes, f32::INFINITY); 3];
    let mut sides = [[[0.0; 4]; N]; 2];
    for k in 0..3 {
        if binning.axes[k] {
            lowest[k] = border_costs(lanes, &bins[k], &counts[k], &mut sides, &mut costs[k]);
        }
    }
    let lowest = least(lowest);
    let mut axis = 0;
    for k in 1..3 {
        if lowest[k] < lowest[axis] {
            axis = k;
        }
    }
    if lowest[axis] == f32::INFINITY {
        return None;
    }
    let mut borders = [0.0; 4];
    borders[axis] = costs[axis].iter().position(|&cost| cost == lowest[axis])? as f32;
    Some(move_to_front(
        items,
        &binning,
        Vec4::from_array(borders) + Vec4::splat(SHIFT),
    ))
}

/// Assigns centers to bins: bin = (center - origin) * scale, on each axis.
struct Binning<const N: usize> {
    origin: Vec4,
    scale: Vec4,
    /// True for the axes on which it pays to look for a border.
    axes: [bool; 3],
}

/// Between 2^23 and 2^24 the last bit of an f32 is worth 1. So adding this leaves the nearest
/// integer in the low bits.
const SHIFT: f32 = 12_582_912.0;

impl<const N: usize> Binning<N> {
    #[inline(always)]
    fn of(Centers { min, max }: Centers) -> Self {
        // Axes shorter than this fraction of the longest one are skipped. Splits across them are
        // rarely the cheapest, and even if they are, the rest of the tree does not gain.
        const SHORT: f32 = 0.3;
        let extent = (max - min).with_w(0.0);
        let axes = extent.cmpge(Vec4::splat((SHORT * extent.max_element()).max(1e-30)));
        let scale = Vec4::select(axes, N as f32 * 0.9999 / extent, Vec4::ZERO);
        Self {
            origin: min,
            scale,
            axes: [axes.test(0), axes.test(1), axes.test(2)],
        }
    }

    /// The bins, plus [`SHIFT`].
    #[inline(always)]
    fn shifted(&self, item: &Bounds) -> Vec4 {
        (item.center() - self.origin) * self.scale - Vec4::splat(0.5) + Vec4::splat(SHIFT)
    }

    #[inline(always)]
    fn bins(&self, item: &Bounds) -> [usize; 3] {
        let [x, y, z, _] = self.shifted(item).to_array();
        [
            x.to_bits() as usize % N,
            y.to_bits() as usize % N,
            z.to_bits() as usize % N,
        ]
    }
}

/// The extent along each axis.
#[inline(always)]
fn extent<L: Lanes>(bounds: F8<L>) -> f32x4 {
    let [minus_min, max] = bounds.halves();
    max + minus_min
}

/// Costs of splitting between bins `i - 1` and `i`, for each `i`. Returns their minimum, spread
/// over lanes. `left` and `right` are buffers for the sides; their entry 0 is 0.
#[inline(always)]
fn border_costs<L: Lanes, const N: usize>(
    lanes: L,
    bins: &[Bounds; N],
    counts: &[f32; N],
    [left, right]: &mut [[[f32; 4]; N]; 2],
    costs: &mut [f32; N],
) -> F8<L> {
    let (mut bounds, mut count) = (F8::load(lanes, &Bounds::EMPTY.0), 0.0);
    for i in 1..N {
        (bounds, count) = (
            bounds.max(F8::load(lanes, &bins[i - 1].0)),
            count + counts[i - 1],
        );
        left[i] = side(bounds, count);
    }
    (bounds, count) = (F8::load(lanes, &Bounds::EMPTY.0), 0.0);
    for i in (1..N).rev() {
        (bounds, count) = (bounds.max(F8::load(lanes, &bins[i].0)), count + counts[i]);
        right[i] = side(bounds, count);
    }
    let mut lowest = F8::splat(lanes, f32::INFINITY);
    let (left, right) = (left.as_chunks().0, right.as_chunks().0);
    for ((left, right), costs) in left.iter().zip(right).zip(costs.as_chunks_mut().0) {
        let cost = side_costs(lanes, left) + side_costs(lanes, right);
        cost.put(costs);
        lowest = lowest.min(cost);
    }
    lowest
}

/// Extent of one side of a border, and its number of triangles.
#[inline(always)]
fn side<L: Lanes>(bounds: F8<L>, count: f32) -> [f32; 4] {
    let [x, y, z, _] = extent(bounds).to_array();
    [x, y, z, count]
}

/// Half surface area times count. Infinite for an empty side, so that no border leaves a side
/// empty.
#[inline(always)]
fn side_costs<L: Lanes>(lanes: L, sides: &[[f32; 4]; WIDTH]) -> F8<L> {
    let [x, y, z, count] = F8::columns(lanes, per_lane!(i => &sides[i]));
    let cost = (x * y + y * z + z * x) * count;
    F8::splat(lanes, 0.0)
        .less(count)
        .select(cost, F8::splat(lanes, f32::INFINITY))
}

/// Reorders `items` so that those left of `borders` come first; returns their number. There are no
/// branches, because the side of an item cannot be predicted.
#[inline(always)]
fn move_to_front<const N: usize>(
    items: &mut [Bounds],
    binning: &Binning<N>,
    borders: Vec4,
) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        let (item, first_right) = (items[i], items[count]);
        items[i] = first_right;
        items[count] = item;
        count += usize::from(binning.shifted(&item).cmplt(borders).any());
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use punctual_geom::lanes::{Instructions, Portable};
    use punctual_geom::random::Random;

    /// Random boxes, half of them near one end.
    fn items(count: u32) -> Vec<Bounds> {
        let mut random = Random::new(count.into());
        (0..count)
            .map(|id| {
                let near = if id % 2 == 0 { 0.1 } else { 1.0 };
                let min = [1.0, 0.5, 0.1].map(|size| (near * size * random.fraction()) as f32);
                Bounds::new(id, min, min.map(|x| x + 0.01 * random.fraction() as f32))
            })
            .collect()
    }

    #[test]
    fn all_instruction_sets_part_alike_and_lose_nothing() {
        for effort in [Effort::Fast, Effort::Normal] {
            for count in [9, 64, 65, 1000] {
                let (mut one, mut other) = (items(count), items(count));
                let parted = Instructions::detect().run(Part {
                    items: &mut one,
                    effort: Some(effort),
                });
                assert_eq!(
                    parted,
                    Part {
                        items: &mut other,
                        effort: Some(effort)
                    }
                    .run(Portable {})
                );
                let ids = |items: &[Bounds]| items.iter().map(Bounds::id).collect::<Vec<_>>();
                assert_eq!(ids(&one), ids(&other));
                let mut all = ids(&one);
                all.sort_unstable();
                assert!(all.into_iter().eq(0..count));
                let (area, middle) = parted;
                let middle = middle.unwrap();
                let of = |items: &mut [Bounds]| {
                    Part {
                        items,
                        effort: None,
                    }
                    .run(Portable {})
                    .0 * items.len() as f32
                };
                let (left, right) = one.split_at_mut(middle);
                assert!(0 < middle && of(left) + of(right) < 0.9 * area * count as f32);
            }
        }
    }

    #[test]
    fn boxes_in_one_place_are_not_parted() {
        let mut items: Vec<_> = (0..20)
            .map(|id| Bounds::new(id, [0.5; 3], [0.75; 3]))
            .collect();
        let (area, middle) = Part {
            items: &mut items,
            effort: Some(Effort::Normal),
        }
        .run(Portable {});
        assert_eq!((area, middle), (3.0 * 0.25 * 0.25, None));
    }
}
