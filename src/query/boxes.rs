//! The box tests: eight boxes at a time, on the six face axes.
//!
//! A box with centre `c` and half extents `h` lies, seen from a frame of the other side ([`View`]), within
//! `M c + t ± (|M| h + m)`; `m` covers every rounding and is proven in `docs/numerics.md`. So no overlap is ever lost, and
//! a box kept in vain only costs time. The nine edge axes would cost more than they save.

use super::frames::{Frames, View};
use crate::math::lanes::{F8, Lanes, V8, dot, per_axis};
use crate::tree::{Node, WIDTH, xyz};
use wide::f32x4;

/// Eight boxes by their ends on three axes.
#[derive(Clone, Copy)]
struct Slabs<L: Lanes> {
    low: V8<L>,
    high: V8<L>,
}

impl<L: Lanes> Slabs<L> {
    #[inline(always)]
    fn around(center: V8<L>, half: V8<L>) -> Self {
        Self { low: per_axis!(k => center[k] - half[k]), high: per_axis!(k => center[k] + half[k]) }
    }

    /// The children of `node` in its own frame.
    #[inline(always)]
    fn children(lanes: L, node: &Node) -> Self {
        Self::around(load(lanes, &node.center), load(lanes, &node.half))
    }

    /// The children of `node` seen from the other side.
    #[inline(always)]
    fn seen(lanes: L, node: &Node, view: &View) -> Self {
        let (center, half) = (load(lanes, &node.center), load(lanes, &node.half));
        let center = per_axis!(k => {
            dot(per_axis!(j => F8::splat(lanes, view.columns[j].as_array()[k])), center) + F8::splat(lanes, view.offset.as_array()[k])
        });
        let half = per_axis!(k => {
            dot(per_axis!(j => F8::splat(lanes, view.absolute[j].as_array()[k])), half) + F8::splat(lanes, view.margin)
        });
        Self::around(center, half)
    }

    /// How deep each lane overlaps the given box, the least over the axes; negative where they are apart.
    #[inline(always)]
    fn depth(&self, lanes: L, low: [f32; 3], high: [f32; 3]) -> F8<L> {
        let [x, y, z] = per_axis!(k => {
            let below = self.high[k] - F8::splat(lanes, low[k]);
            below.min(F8::splat(lanes, high[k]) - self.low[k])
        });
        x.min(y).min(z)
    }

    /// The same for lane `i` of the stored boxes.
    #[inline(always)]
    fn depth_at(&self, lanes: L, other: &Stored, i: usize) -> F8<L> {
        self.depth(lanes, per_axis!(k => other.low[k][i]), per_axis!(k => other.high[k][i]))
    }

    #[inline(always)]
    fn store(&self) -> Stored {
        Stored { low: per_axis!(k => self.low[k].store()), high: per_axis!(k => self.high[k].store()) }
    }
}

/// Eight boxes, to be read one at a time.
struct Stored {
    low: [[f32; 8]; 3],
    high: [[f32; 8]; 3],
}

#[inline(always)]
fn load<L: Lanes>(lanes: L, columns: &[[f32; WIDTH]; 3]) -> V8<L> {
    per_axis!(k => F8::load(lanes, &columns[k]))
}

/// The ends, on three axes, of a box given by centre and half extents.
#[inline(always)]
fn ends(center: f32x4, half: f32x4) -> ([f32; 3], [f32; 3]) {
    (xyz(center - half), xyz(center + half))
}

/// Whether the box of `seen`, from the frame of `other`, is apart from that of `other`.
#[inline(always)]
fn own_apart(seen: &Node, other: &Node, view: &View) -> bool {
    let distance = view.point(&seen.own_center) - other.own_center;
    let reach = view.half(&seen.own_half) + other.own_half;
    reach.simd_lt(distance.abs()).any()
}

/// Whether the boxes of two nodes may meet. A child passes the test in its parent's frame first; this one is in its own.
#[inline(always)]
pub(super) fn own(a: &Node, b: &Node, frames: &Frames) -> bool {
    !own_apart(b, a, &frames.of_b) && !own_apart(a, b, &frames.of_a)
}

/// How deep the boxes of each pair of children overlap, written by the tests for those that may meet. They are compared
/// with one another only, so the unit is that of one side.
pub(super) type Depths = [[f32; WIDTH]; WIDTH];

/// The children of `a` against those of `b`: bit `8 i + j` is set where child `i` of `a` may meet child `j` of `b`.
#[inline(always)]
pub(super) fn both<L: Lanes>(lanes: L, a: &Node, b: &Node, frames: &Frames, scale: f32, depths: &mut Depths) -> u64 {
    let b_in_a = Slabs::seen(lanes, b, &frames.of_b);
    let (low, high) = ends(a.own_center, a.own_half);
    let alive_b = !b_in_a.depth(lanes, low, high).mask() & b.valid();
    if alive_b == 0 {
        return 0;
    }
    let a_in_b = Slabs::seen(lanes, a, &frames.of_a);
    let (low, high) = ends(b.own_center, b.own_half);
    let mut alive_a = !a_in_b.depth(lanes, low, high).mask() & a.valid();
    let a_rows = Slabs::children(lanes, a).store();
    let a_in_b = a_in_b.store();
    let b_rows = Slabs::children(lanes, b);
    let scale = F8::splat(lanes, scale);
    let mut pairs = 0;
    while alive_a != 0 {
        let i = alive_a.trailing_zeros() as usize;
        alive_a &= alive_a - 1;
        let depth = b_in_a.depth_at(lanes, &a_rows, i).min(b_rows.depth_at(lanes, &a_in_b, i) * scale);
        depths[i] = depth.store();
        pairs |= u64::from(!depth.mask() & alive_b) << (WIDTH * i);
    }
    pairs
}

/// The children of `opened` against the box of `other`: bit `i` is set where child `i` may meet it.
///
/// `of_opened` is the view of what is on the side of `opened` from the frame of `other`, `of_other` the reverse; `scale` is
/// the length of a unit of `opened` in that of `other`.
#[inline(always)]
pub(super) fn children<L: Lanes>(
    lanes: L,
    opened: &Node,
    other: &Node,
    [of_opened, of_other]: [&View; 2],
    scale: f32,
    depths: &mut Depths,
) -> u64 {
    let (low, high) = ends(of_other.point(&other.own_center), of_other.half(&other.own_half));
    let depth = Slabs::children(lanes, opened).depth(lanes, low, high) * F8::splat(lanes, scale);
    let (low, high) = ends(other.own_center, other.own_half);
    let depth = depth.min(Slabs::seen(lanes, opened, of_opened).depth(lanes, low, high));
    depths[0] = depth.store();
    u64::from(!depth.mask() & opened.valid())
}

/// The children of `node` against a triangle of the other side, on the three axes of the boxes and on the triangle's
/// normal.
#[inline(always)]
pub(super) fn children_and_triangle<L: Lanes>(
    lanes: L,
    node: &Node,
    triangle: &[[f32; 4]; 3],
    view: &View,
    skew: f32,
    depths: &mut Depths,
) -> u64 {
    let [[x, y, z, ex], [ey, ez, fx, fy], [fz, ..]] = *triangle;
    let corner = f32x4::new([x, y, z, 0.0]);
    let (e, f) = (f32x4::new([ex, ey, ez, 0.0]), f32x4::new([fx, fy, fz, 0.0]));
    let [p, e, f] = [view.point(&corner), view.direction(&e), view.direction(&f)].map(f32x4::to_array);
    let margin = view.margin;
    let low = per_axis!(k => p[k] + 0f32.min(e[k]).min(f[k]) - margin);
    let high = per_axis!(k => p[k] + 0f32.max(e[k]).max(f[k]) + margin);
    let depth = Slabs::children(lanes, node).depth(lanes, low, high);
    depths[0] = depth.store();

    // |n . (c - p)| > |n| . h, with all errors of n (relative to the edges) and of p on the right-hand side.
    let (center, half) = (load(lanes, &node.center), load(lanes, &node.half));
    let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    let blur = skew * longest(&e) * longest(&f);
    let from_first = per_axis!(k => center[k] - F8::splat(lanes, p[k]));
    let distance = dot(per_axis!(k => F8::splat(lanes, normal[k])), from_first).abs();
    let normal = per_axis!(k => normal[k].abs());
    let slack = margin * (normal[0] + normal[1] + normal[2] + 4.0 * blur) + 1e-36;
    let reach = dot(per_axis!(k => F8::splat(lanes, normal[k] + blur)), half)
        + (from_first[0].abs() + from_first[1].abs() + from_first[2].abs()) * F8::splat(lanes, blur)
        + F8::splat(lanes, slack);
    u64::from(!(depth.mask() | reach.less(distance).mask()) & node.valid())
}

#[inline(always)]
fn longest(v: &[f32; 4]) -> f32 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}
