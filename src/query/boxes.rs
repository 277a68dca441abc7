//! The box tests: eight boxes at a time, on the six face axes.
//!
//! A box with centre `c` and half extents `h` lies, seen from the orientation of a node of the
//! other side ([`View`]), within `M c + t ± (|M| h + m)`; `m` covers every rounding and is proven
//! in `docs/numerics.md`. So no overlap is ever lost, and a box kept in vain only costs time. The
//! other nine axes: [`edge_axes`](super::edge_axes). All is in A's units.

mod planes;
mod reach;

use super::close_boxes;
use super::views::{Relation, View, Views};
use crate::math::lanes::{Column, F8, Lanes, V8, all, dot, per_axis, per_part};
use crate::tree::{Node, WIDTH, xyz};
use crate::triangle::batch::Rows;
pub(super) use planes::{Plane, Planes};
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

    /// With half extents times `factor`.
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

    /// The boxes around these along the axes of the other side.
    #[inline(always)]
    pub(super) fn seen(&self, lanes: L, view: &View) -> Self {
        let seen = per_axis!(k => self.seen_along(lanes, view, k));
        Self {
            center: per_axis!(k => seen[k].0),
            half: per_axis!(k => seen[k].1),
        }
    }

    /// Their centres and half extents along an axis of the other side.
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

/// Eight boxes by their ends on three axes.
#[derive(Clone, Copy)]
pub(super) struct Slabs<L: Lanes> {
    pub low: V8<L>,
    pub high: V8<L>,
}

impl<L: Lanes> Slabs<L> {
    /// [`depth`](Self::depth) with lane `i` of the stored boxes.
    #[inline(always)]
    pub(super) fn depth_at(&self, lanes: L, other: &Stored, i: usize) -> F8<L> {
        self.depth(
            lanes,
            per_axis!(k => other.low[k][i]),
            per_axis!(k => other.high[k][i]),
        )
    }

    /// How deep each lane overlaps the given box, the least over the axes; negative where they are
    /// apart.
    #[inline(always)]
    pub(super) fn depth(&self, lanes: L, low: [f32; 3], high: [f32; 3]) -> F8<L> {
        let [x, y, z] = per_axis!(k => {
            let below = self.high[k] - F8::splat(lanes, low[k]);
            below.min(F8::splat(lanes, high[k]) - self.low[k])
        });
        x.min(y).min(z)
    }

    /// How far each lane lies from the given box, axis by axis; negative where they overlap.
    #[inline(always)]
    pub(super) fn gaps(&self, lanes: L, low: [f32; 3], high: [f32; 3]) -> V8<L> {
        per_axis!(k => (F8::splat(lanes, low[k]) - self.high[k]).max(self.low[k] - F8::splat(lanes, high[k])))
    }

    /// The same for lane `i` of the stored boxes.
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

/// Eight boxes, to be read one at a time.
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

/// The ends, on three axes, of a box given by centre and half extents.
#[inline(always)]
pub(super) fn ends(center: f32x4, half: f32x4) -> ([f32; 3], [f32; 3]) {
    (xyz(center - half), xyz(center + half))
}

/// The same vector eight times.
#[inline(always)]
pub(super) fn splat<L: Lanes>(lanes: L, v: f32x4) -> V8<L> {
    per_axis!(k => F8::splat(lanes, v.as_array()[k]))
}

/// Two nodes, the first of which is opened, each with its view from the other and the length of its
/// unit in A's.
#[derive(Clone, Copy)]
pub(super) struct Facing<'n> {
    pub nodes: [&'n Node; 2],
    pub views: [&'n View; 2],
    pub scales: [f32; 2],
    /// Whether the first is of A.
    pub is_a: bool,
}

impl Facing<'_> {
    /// The own box of the other node: centre and half extents, A's units.
    #[inline(always)]
    pub(super) fn other(&self) -> (f32x4, f32x4) {
        let scale = f32x4::splat(self.scales[1]);
        (
            self.nodes[1].own_center * scale,
            self.nodes[1].own_half * scale,
        )
    }
}

/// What the box tests say of each pair of children that is of interest.
pub(super) type Keys = [[f32; WIDTH]; WIDTH];

/// A question in terms of boxes: which pairs of children are of interest, and how much. Bit `8 i +
/// j` of an answer stands for child `i` of the opened node and child `j` of the other, and so does
/// entry `[i][j]` of the keys.
pub(super) trait BoxTest {
    /// Whether overlap alone is asked: then edge axes part, and keys are depths.
    const IS_OVERLAP: bool;

    /// Whether kernels read the views that they are given.
    const READS_VIEWS: bool = true;

    /// Whether two clusters are opened as other nodes are.
    const OPENS_CLUSTERS_ALIKE: bool = Self::IS_OVERLAP;

    /// How both nodes see one another.
    #[inline(always)]
    fn views<L: Lanes>(&mut self, _lanes: L, a: &Node, b: &Node, relation: &Relation) -> Views {
        Views::between(a, b, relation)
    }

    /// Whether a pair is of interest, by the own boxes of both nodes. A child first passes the test
    /// along its parent's axes; this one is along its own.
    fn own<L: Lanes>(&mut self, lanes: L, a: &Node, b: &Node, views: &Views, scale: f32) -> bool;

    /// Whether it is so by the margins of `f32` alone.
    #[inline(always)]
    fn is_in_doubt(&self) -> bool {
        false
    }

    /// Whether a pair in doubt is of no interest, as `f64` tells.
    #[inline(always)]
    fn is_parted(&mut self, _a: &Node, _b: &Node, _views: &Views, _relation: &Relation) -> bool {
        false
    }

    /// The given children of both nodes.
    fn both<L: Lanes>(&self, lanes: L, facing: Facing, alive: [u32; 2], keys: &mut Keys) -> u64;

    /// The given triangles of two clusters.
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

    /// The children of the opened node against the box of the other; the first row of keys.
    fn children<L: Lanes>(&self, lanes: L, facing: Facing, keys: &mut Keys) -> u32;

    /// The given triangles of a cluster, the opened node, against the children of the other one.
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: u32,
        triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64;
}

/// Triangles of a cluster, and how they are seen from the other node.
pub(super) struct Triangles<'t> {
    pub rows: [&'t Rows; WIDTH],
    pub view: View,
    pub skew: f32,
}

/// Whether boxes overlap, on the six face axes; keys tell how deep.
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
        // One branch for both: neither can be guessed.
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
        // Else a branch that cannot be guessed costs more than it saves.
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

    /// On the three axes of the boxes and on the triangles' normals; keys for a single triangle
    /// only.
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
