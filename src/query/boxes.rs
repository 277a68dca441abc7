//! The box tests: eight boxes at a time, on the six face axes.
//!
//! A box with centre `c` and half extents `h`, seen from the orientation of a node of the other
//! side ([`View`]), lies within `M c + t ± (|M| h + m)`. `m` covers every rounding and is proven in
//! `docs/numerics.md`. So no overlap is lost; a box kept needlessly only costs time. The other nine
//! axes are in [`edge_axes`](super::edge_axes). All lengths are in A's units.

mod planes;
mod reach;

use super::close_boxes;
use super::views::{Relation, View, Views};
use crate::tree::{Node, WIDTH, xyz};
pub(super) use planes::{Plane, Planes};
use punctual_geom::lanes::{Column, F8, Lanes, V8, all, dot, per_axis, per_part};
use punctual_geom::triangle::batch::Rows;
use reach::Reach;
use wide::f32x4;

/// Eight boxes by centre and half extents, along the axes of their node.
#[derive(Clone, Copy)]
pub(super) struct Boxes<L: Lanes> {
    pub center: V8<L>,
    pub half: V8<L>,
}

impl<L: Lanes> Boxes<L> {
    /// The children of `node`, whose unit has the length `scale`.
    #[inline(always)]
    pub(super) fn children(lanes: L, node: &Node, scale: f32) -> Self {
        let scale = F8::splat(lanes, scale);
        Self {
            center: per_axis!(k => F8::read(lanes, &node.center[k]) * scale),
            half: per_axis!(k => F8::read(lanes, &node.half[k]) * scale),
        }
    }

    /// Multiplies the half extents by `factor`.
    #[inline(always)]
    pub(super) fn swollen(self, lanes: L, factor: f32) -> Self {
        Self {
            half: per_axis!(k => self.half[k] * F8::splat(lanes, factor)),
            ..self
        }
    }

    #[inline(always)]
    pub(super) fn slabs(&self) -> Slabs<L> {
        Slabs {
            low: per_axis!(k => self.center[k] - self.half[k]),
            high: per_axis!(k => self.center[k] + self.half[k]),
        }
    }

    /// Bounding boxes of these boxes along the axes of the other side.
    #[inline(always)]
    pub(super) fn seen(&self, lanes: L, view: &View) -> Self {
        let seen = per_axis!(k => self.seen_along(lanes, view, k));
        Self {
            center: per_axis!(k => seen[k].0),
            half: per_axis!(k => seen[k].1),
        }
    }

    /// Centres and half extents along an axis of the other side.
    #[inline(always)]
    fn seen_along(&self, lanes: L, view: &View, k: usize) -> (F8<L>, F8<L>) {
        let row = per_axis!(j => F8::splat(lanes, view.columns[j].as_array()[k]));
        let margin = F8::splat(lanes, view.margin.as_array()[0]);
        let center = dot(row, self.center) + F8::splat(lanes, view.origin.as_array()[k]);
        (
            center,
            dot(per_axis!(j => row[j].abs()), self.half) + margin,
        )
    }
}

/// Eight boxes by their lower and upper ends on three axes.
#[derive(Clone, Copy)]
pub(super) struct Slabs<L: Lanes> {
    pub low: V8<L>,
    pub high: V8<L>,
}

impl<L: Lanes> Slabs<L> {
    /// [`depth`](Self::depth) with stored box `i`.
    #[inline(always)]
    pub(super) fn depth_at(&self, lanes: L, other: &Stored, i: usize) -> F8<L> {
        self.depth(
            lanes,
            per_axis!(k => other.low[k][i]),
            per_axis!(k => other.high[k][i]),
        )
    }

    /// Overlap depth of every lane with the given box, the least over the axes; negative means a
    /// gap.
    #[inline(always)]
    pub(super) fn depth(&self, lanes: L, low: [f32; 3], high: [f32; 3]) -> F8<L> {
        let [x, y, z] = per_axis!(k => {
            let below = self.high[k] - F8::splat(lanes, low[k]);
            below.min(F8::splat(lanes, high[k]) - self.low[k])
        });
        x.min(y).min(z)
    }

    /// Gap of every lane to the given box, axis by axis; negative means an overlap.
    #[inline(always)]
    pub(super) fn gaps(&self, lanes: L, low: [f32; 3], high: [f32; 3]) -> V8<L> {
        per_axis!(k => (F8::splat(lanes, low[k]) - self.high[k]).max(self.low[k] - F8::splat(lanes, high[k])))
    }

    /// Gap of every lane to stored box `i`, axis by axis; negative means an overlap.
    #[inline(always)]
    pub(super) fn gaps_at(&self, lanes: L, other: &Stored, i: usize) -> V8<L> {
        self.gaps(
            lanes,
            per_axis!(k => other.low[k][i]),
            per_axis!(k => other.high[k][i]),
        )
    }

    #[inline(always)]
    pub(super) fn store(&self) -> Stored {
        Stored {
            low: per_axis!(k => self.low[k].store()),
            high: per_axis!(k => self.high[k].store()),
        }
    }
}

/// Eight boxes, stored for access one at a time.
pub(super) struct Stored {
    pub low: [[f32; 8]; 3],
    pub high: [[f32; 8]; 3],
}

impl Stored {
    const NONE: Self = Self {
        low: [[0.0; 8]; 3],
        high: [[0.0; 8]; 3],
    };
}

/// Lower and upper ends, on three axes, of a box given by centre and half extents.
#[inline(always)]
pub(super) fn ends(center: f32x4, half: f32x4) -> ([f32; 3], [f32; 3]) {
    (xyz(center - half), xyz(center + half))
}

/// A vector, eight times.
#[inline(always)]
pub(super) fn splat<L: Lanes>(lanes: L, v: f32x4) -> V8<L> {
    per_axis!(k => F8::splat(lanes, v.as_array()[k]))
}

/// Two nodes, of which the first is opened, each with its view from the other and the length of its
/// unit in A's units.
#[derive(Clone, Copy)]
pub(super) struct Facing<'n> {
    pub nodes: [&'n Node; 2],
    pub views: [&'n View; 2],
    pub scales: [f32; 2],
    /// True if the first node is of A.
    pub is_a: bool,
}

impl Facing<'_> {
    /// The own box of the other node: centre and half extents, in A's units.
    #[inline(always)]
    pub(super) fn other(&self) -> (f32x4, f32x4) {
        let scale = f32x4::splat(self.scales[1]);
        (
            self.nodes[1].own_center * scale,
            self.nodes[1].own_half * scale,
        )
    }
}

/// The keys that box tests assign to pairs of children of interest.
pub(super) type Keys = [[f32; WIDTH]; WIDTH];

/// A question in terms of boxes: selects the pairs of children of interest and assigns keys to
/// them. Bit `8 i + j` of a result, and entry `[i][j]` of the keys, stand for child `i` of the
/// opened node and child `j` of the other.
pub(super) trait BoxTest {
    /// True if the question is overlap alone: then edge axes can separate boxes, and keys are
    /// depths.
    const IS_OVERLAP: bool;

    /// True if the kernels read the views that they are given.
    const READS_VIEWS: bool = true;

    /// True if two clusters are opened like other nodes.
    const OPENS_CLUSTERS_ALIKE: bool = Self::IS_OVERLAP;

    /// The map between the orientations of both nodes.
    #[inline(always)]
    fn views<L: Lanes>(&mut self, _lanes: L, a: &Node, b: &Node, relation: &Relation) -> Views {
        Views::between(a, b, relation)
    }

    /// True if a pair is of interest by the own boxes of both nodes. A child first passes the test
    /// along its parent's axes; this test is along its own axes.
    fn own<L: Lanes>(&mut self, lanes: L, a: &Node, b: &Node, views: &Views, scale: f32) -> bool;

    /// True if the pair is of interest only because of the margins of `f32`.
    #[inline(always)]
    fn is_in_doubt(&self) -> bool {
        false
    }

    /// True if `f64` shows that a pair in doubt is of no interest.
    #[inline(always)]
    fn is_parted(&mut self, _a: &Node, _b: &Node, _views: &Views, _relation: &Relation) -> bool {
        false
    }

    /// Tests the active children of both nodes against each other.
    fn both<L: Lanes>(&self, lanes: L, facing: Facing, alive: [u32; 2], keys: &mut Keys) -> u64;

    /// Tests the active triangles of two clusters against each other.
    #[inline(always)]
    fn clusters<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: [u32; 2],
        _rows: impl FnOnce() -> [[&'t Rows; WIDTH]; 2],
        keys: &mut Keys,
    ) -> u64 {
        self.both(lanes, facing, alive, keys)
    }

    /// Tests the children of the opened node against the box of the other. Writes the first row of
    /// keys.
    fn children<L: Lanes>(&self, lanes: L, facing: Facing, keys: &mut Keys) -> u32;

    /// Tests the active triangles of a cluster, the opened node, against the children of the other
    /// node.
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: u32,
        triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64;
}

/// Triangles of a cluster, and their view from the other node.
pub(super) struct Triangles<'t> {
    pub rows: [&'t Rows; WIDTH],
    pub view: View,
    pub skew: f32,
}

/// Overlap of boxes on the six face axes; keys are depths.
pub(super) struct Overlap {
    least_gap: f32x4,
    in_doubt: bool,
}

impl Overlap {
    #[inline(always)]
    pub fn new(relation: &Relation) -> Self {
        Self {
            least_gap: relation.least_gap,
            in_doubt: false,
        }
    }
}

impl BoxTest for Overlap {
    const IS_OVERLAP: bool = true;

    #[inline(always)]
    fn own<L: Lanes>(&mut self, _lanes: L, a: &Node, b: &Node, views: &Views, scale: f32) -> bool {
        let scale = f32x4::splat(scale);
        let a = (a.own_center, a.own_half);
        let b = (b.own_center * scale, b.own_half * scale);
        let (in_a, in_b) = (views.of_b.gaps(b, a), views.of_a.gaps(a, b));
        // One branch for both views, because neither branch is predictable.
        self.in_doubt = self.least_gap.simd_lt(in_a.fast_max(in_b)).any();
        !(self.in_doubt
            && (views.of_b.margin.simd_lt(in_a) | views.of_a.margin.simd_lt(in_b)).any())
    }

    #[inline(always)]
    fn is_in_doubt(&self) -> bool {
        self.in_doubt
    }

    #[inline(always)]
    fn is_parted(&mut self, a: &Node, b: &Node, views: &Views, relation: &Relation) -> bool {
        close_boxes::gap(a, b, views, relation) > 0.0
    }

    #[inline(always)]
    fn both<L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        [mut alive_a, alive_b]: [u32; 2],
        keys: &mut Keys,
    ) -> u64 {
        let Facing {
            nodes: [a, b],
            views: [of_a, of_b],
            scales,
            ..
        } = facing;
        let (center, half) = facing.other();
        let mut reach_a = Reach::<L>::NONE;
        alive_a &=
            !Reach::children::<true>(lanes, (a, of_a, scales[0]), (center, half), &mut reach_a);
        // Without whole registers, an unpredictable branch costs more than it saves.
        if !L::IS_WHOLE && alive_a == 0 {
            return 0;
        }
        let mut reach_b = Reach::<L>::NONE;
        let own_a = (a.own_center, a.own_half);
        let alive_b =
            alive_b & !Reach::children::<false>(lanes, (b, of_b, scales[1]), own_a, &mut reach_b);
        let mut pairs = 0;
        per_part!(lanes: L, part => {
            let alive_b = alive_b & all(part);
            let mut alive_a = if L::IS_WHOLE || alive_b != 0 { alive_a } else { 0 };
            let [own, seen] = [Reach::load(part, &reach_b[0]), Reach::load(part, &reach_b[1])];
            while alive_a != 0 {
                let i = alive_a.trailing_zeros() as usize;
                alive_a &= alive_a - 1;
                let depth = seen.overlap_at(part, &reach_a[0], i).min(own.overlap_at(part, &reach_a[1], i));
                depth.put(&mut keys[i]);
                pairs |= u64::from(!depth.mask() & alive_b) << (WIDTH * i);
            }
        });
        pairs
    }

    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: Facing, keys: &mut Keys) -> u32 {
        let Facing {
            nodes: [opened, _],
            views: [of_opened, of_other],
            scales,
            ..
        } = facing;
        let children = Boxes::children(lanes, opened, scales[0]);
        let (center, half) = facing.other();
        let (low, high) = ends(of_other.point(center), of_other.half(half));
        let depth = children.slabs().depth(lanes, low, high);
        let (low, high) = ends(center, half);
        let depth = depth.min(
            children
                .seen(lanes, of_opened)
                .slabs()
                .depth(lanes, low, high),
        );
        keys[0] = depth.store();
        !depth.mask() & opened.valid()
    }

    /// Tests on the three axes of the boxes and on the triangles' normals. Writes keys only for a
    /// single triangle.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: u32,
        triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64 {
        let triangles = triangles();
        let (node, scale) = (facing.nodes[1], facing.scales[1]);
        if alive.is_power_of_two() {
            let i = alive.trailing_zeros() as usize % WIDTH;
            let plane = Plane::new(triangles.rows[i], &triangles.view, triangles.skew);
            let boxes = Boxes::children(lanes, node, scale);
            let [in_box, through_plane] = plane.depths(lanes, &boxes, &boxes.slabs());
            let depth = in_box.min(through_plane * F8::splat(lanes, 1.0 / plane.length()));
            keys[i] = depth.store();
            return u64::from(!depth.mask() & node.valid()) << (WIDTH * i);
        }
        let mut planes = Planes::NONE;
        per_part!(lanes: L, part => {
            if L::IS_WHOLE || alive & all(part) != 0 {
                planes.put(part, &triangles);
            }
        });
        let mut pairs = 0;
        per_part!(lanes: L, part => {
            let valid = node.valid() & all(part);
            let mut alive = if L::IS_WHOLE || valid != 0 { alive } else { 0 };
            let boxes = Boxes::children(part, node, scale);
            let slabs = boxes.slabs();
            while alive != 0 {
                let i = alive.trailing_zeros() as usize;
                alive &= alive - 1;
                let [in_box, through_plane] = planes.at(i).depths(part, &boxes, &slabs);
                let apart = in_box.mask() | through_plane.mask();
                pairs |= u64::from(!apart & valid) << (WIDTH * i);
            }
        });
        pairs
    }
}

#[cfg(test)]
mod tests;
