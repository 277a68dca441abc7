//! How far apart boxes are at least: lower bounds of distances, eight at a time.
//!
//! Two boxes that are `x, y, z` apart along the axes of one of them are at least `sqrt(x^2 + y^2 + z^2)` apart, where
//! negative gaps count as 0; the axes of the other give a second bound. All is in A's units, with the views and margins of
//! the overlap test; the proof is in `docs/numerics.md`, "Distances of boxes".

use super::boxes::{BoxTest, Boxes, Facing, Keys, Triangles, ends};
use super::views::{View, Views};
use crate::math::lanes::{F8, Lanes, V8};
use crate::tree::{Node, xyz};
use wide::f32x4;

/// Whether boxes are closer than `cut`. Keys are squared lower bounds of distances, or minus the depth of the overlap.
pub(super) struct Gaps {
    /// Squared distance from which on pairs are of no interest.
    pub cut: f32,
    /// The square of a gap is multiplied with this, which covers its rounding and axes that are not quite orthonormal.
    pub shrink: f32,
    /// Factor of half extents: 1 for bounds, less for guesses.
    pub swell: f32,
    /// The key of the pair at hand; its children's are no less. Negative infinity where boxes overlap.
    pub least: f32,
}

/// Squared length of the gaps along three axes, and the largest gap.
#[inline(always)]
fn measure<L: Lanes>(lanes: L, [x, y, z]: V8<L>) -> [F8<L>; 2] {
    let zero = F8::splat(lanes, 0.0);
    let (u, v, w) = (x.max(zero), y.max(zero), z.max(zero));
    [u * u + v * v + w * w, x.max(y).max(z)]
}

/// The same for a single pair of boxes; `seen` is along the axes of `other`.
#[inline(always)]
fn measure_one(seen: (f32x4, f32x4), other: (f32x4, f32x4), view: &View) -> [f32; 2] {
    let gaps = (view.point(seen.0) - other.0).abs() - (view.half(seen.1) + other.1);
    let [[x, y, z], [u, v, w]] = [gaps, gaps.fast_max(f32x4::ZERO)].map(xyz);
    [u * u + v * v + w * w, x.max(y).max(z)]
}

impl Gaps {
    /// The keys of boxes that were measured along the axes of both sides.
    #[inline(always)]
    fn keys<L: Lanes>(&self, lanes: L, [square, gap]: [F8<L>; 2], [other_square, other_gap]: [F8<L>; 2]) -> F8<L> {
        let (square, gap) = (square.max(other_square), gap.max(other_gap));
        let key = square * F8::splat(lanes, self.shrink) + gap.min(F8::splat(lanes, 0.0));
        key.max(F8::splat(lanes, self.least))
    }

    /// The lanes with keys below the cut.
    #[inline(always)]
    fn near<L: Lanes>(&self, lanes: L, keys: F8<L>) -> u32 {
        keys.less(F8::splat(lanes, self.cut)).mask()
    }

    #[inline(always)]
    fn boxes<L: Lanes>(&self, lanes: L, node: &Node, scale: f32) -> Boxes<L> {
        Boxes::children(lanes, node, scale).swollen(lanes, self.swell)
    }
}

impl BoxTest for Gaps {
    #[inline(always)]
    fn own(&mut self, a: &Node, b: &Node, views: &Views, scale: f32) -> bool {
        if self.swell < 1.0 {
            return true;
        }
        let scale = f32x4::splat(scale);
        let a = (a.own_center, a.own_half);
        let b = (b.own_center * scale, b.own_half * scale);
        let ([square, gap], [other_square, other_gap]) =
            (measure_one(b, a, &views.of_b), measure_one(a, b, &views.of_a));
        let key = square.max(other_square) * self.shrink;
        if gap.max(other_gap) > 0.0 {
            self.least = self.least.max(key);
        }
        self.least < self.cut
    }

    #[inline(always)]
    fn both<L: Lanes>(&self, lanes: L, facing: Facing, [alive_a, alive_b]: [u32; 2], keys: &mut Keys) -> u64 {
        let Facing { nodes: [a, b], views: [of_a, of_b], scales } = facing;
        let b_rows = self.boxes(lanes, b, scales[1]);
        let b_in_a = b_rows.seen(lanes, of_b);
        let scale = f32x4::splat(scales[0]);
        let (low, high) = ends(a.own_center * scale, a.own_half * scale);
        let measured = measure(lanes, b_in_a.gaps(lanes, low, high));
        let alive_b = alive_b & self.near(lanes, self.keys(lanes, measured, measured));
        if alive_b == 0 {
            return 0;
        }
        let a_rows = self.boxes(lanes, a, scales[0]);
        let a_in_b = a_rows.seen(lanes, of_a);
        let (center, half) = facing.other();
        let (low, high) = ends(center, half);
        let measured = measure(lanes, a_in_b.gaps(lanes, low, high));
        let mut alive_a = alive_a & self.near(lanes, self.keys(lanes, measured, measured));
        let (a_rows, a_in_b) = (a_rows.slabs().store(), a_in_b.store());
        let b_rows = b_rows.slabs();
        let mut pairs = 0;
        while alive_a != 0 {
            let i = alive_a.trailing_zeros() as usize;
            alive_a &= alive_a - 1;
            let in_a = measure(lanes, b_in_a.gaps_at(lanes, &a_rows, i));
            let in_b = measure(lanes, b_rows.gaps_at(lanes, &a_in_b, i));
            let near = self.keys(lanes, in_a, in_b);
            keys[i] = near.store();
            pairs |= u64::from(self.near(lanes, near) & alive_b) << (8 * i);
        }
        pairs
    }

    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: Facing, keys: &mut Keys) -> u32 {
        let Facing { nodes: [opened, _], views: [of_opened, of_other], scales } = facing;
        let children = self.boxes(lanes, opened, scales[0]);
        let (center, half) = facing.other();
        let half = half * f32x4::splat(self.swell);
        let (low, high) = ends(of_other.point(center), of_other.half(half));
        let in_opened = measure(lanes, children.slabs().gaps(lanes, low, high));
        let (low, high) = ends(center, half);
        let in_other = measure(lanes, children.seen(lanes, of_opened).gaps(lanes, low, high));
        let near = self.keys(lanes, in_opened, in_other);
        keys[0] = near.store();
        self.near(lanes, near) & opened.valid()
    }

    /// By their boxes.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: u32,
        _triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64 {
        self.both(lanes, facing, [alive, facing.nodes[1].valid()], keys)
    }
}
