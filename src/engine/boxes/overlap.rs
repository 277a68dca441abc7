//! The measure of the intersection: overlap of boxes on the six face axes.
//!
//! The head of [`boxes`](super) states the margins. The other nine axes are in
//! [`edge_axes`](super::edge_axes).

use super::close_boxes;
use super::relative_pose::{RelativePose, Views};
use super::{Boxes, Facing, Plane, Planes, Slabs, Stored, Triangles};
use crate::engine::expand::{Keys, Measure};
use crate::model::cost::WORK_PER_EXPANSION;
use crate::tree::{Node, WIDTH};
use punctual_geom::lanes::{Column, F8, Lanes, all, per_axis, per_part};
use wide::f32x4;

/// Overlap of boxes; keys are depths.
#[derive(Default)]
pub(crate) struct Overlap {
    in_doubt: bool,
}

impl Measure for Overlap {
    const IS_OVERLAP: bool = true;
    const WORK: [u64; 2] = [WORK_PER_EXPANSION, 1];

    type Along<L: Lanes> = F8<L>;

    #[inline(always)]
    fn own(&mut self, [a, b]: [&Node; 2], views: &Views, relative: &RelativePose) -> bool {
        let scale = f32x4::splat(relative.scale);
        let a = (a.own_center, a.own_half);
        let b = (b.own_center * scale, b.own_half * scale);
        let (in_a, in_b) = (views.of_b.gaps(b, a), views.of_a.gaps(a, b));
        // One branch for both views, because neither branch is predictable.
        self.in_doubt = relative.least_gap.simd_lt(in_a.fast_max(in_b)).any();
        !(self.in_doubt
            && (views.of_b.margin.simd_lt(in_a) | views.of_a.margin.simd_lt(in_b)).any())
    }

    #[inline(always)]
    fn is_in_doubt(&self) -> bool {
        self.in_doubt
    }

    #[inline(always)]
    fn is_parted(&mut self, [a, b]: [&Node; 2], views: &Views, relative: &RelativePose) -> bool {
        close_boxes::gap(a, b, views, relative) > 0.0
    }

    #[inline(always)]
    fn compare<L: Lanes>(&self, _lanes: L, other: &Slabs<L>, opened: &Slabs<L>) -> F8<L> {
        other.depth(opened)
    }

    #[inline(always)]
    fn key<L: Lanes>(&self, _: L, in_opened: F8<L>, in_other: F8<L>, _: F8<L>) -> F8<L> {
        in_opened.min(in_other)
    }

    #[inline(always)]
    fn hits<L: Lanes>(&self, _lanes: L, keys: F8<L>) -> u32 {
        !keys.mask() & 0xff
    }

    /// Repeats the loop of the driver: through the driver `any` and `all` took 2.6 % more
    /// instructions.
    #[inline(always)]
    fn both<L: Lanes>(
        &self,
        lanes: L,
        facing: &Facing,
        [mut active_a, active_b]: [u32; 2],
        keys: &mut Keys,
    ) -> u64 {
        let (mut a, mut b) = ([Stored::default(); 2], [Stored::default(); 2]);
        active_a &= !stored::<_, true>(lanes, facing, 0, &mut a);
        // Without whole registers, an unpredictable branch costs more than it saves.
        if !L::IS_WHOLE && active_a == 0 {
            return 0;
        }
        let active_b = active_b & !stored::<_, false>(lanes, facing, 1, &mut b);
        let mut pairs = 0;
        per_part!(lanes: L, part => {
            let active_b = active_b & all(part);
            let mut active_a = if L::IS_WHOLE || active_b != 0 { active_a } else { 0 };
            let (own, seen) = (b[0].load(part), b[1].load(part));
            while active_a != 0 {
                let i = active_a.trailing_zeros() as usize % WIDTH;
                active_a &= active_a - 1;
                let depth = seen.depth(&a[0].at(part, i)).min(own.depth(&a[1].at(part, i)));
                depth.put(&mut keys[i]);
                pairs |= u64::from(!depth.mask() & active_b) << (WIDTH * i);
            }
        });
        pairs
    }

    /// Tests on the three axes of the boxes and on the triangles' normals. Writes keys only for a
    /// single triangle.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: &Facing,
        active: u32,
        triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64 {
        let (triangles, node) = (triangles(), facing.nodes[1]);
        // A single triangle needs one plane, not eight.
        if active.is_power_of_two() {
            let i = active.trailing_zeros() as usize % WIDTH;
            let plane = Plane::new(triangles.rows[i], &triangles.view, triangles.rotation_error);
            let boxes = facing.children(lanes, 1);
            let [in_box, through_plane] = plane.depths(lanes, &boxes, &boxes.slabs());
            let depth = in_box.min(through_plane * F8::splat(lanes, 1.0 / plane.length()));
            keys[i] = depth.store();
            return u64::from(!depth.mask() & node.valid()) << (WIDTH * i);
        }
        let mut planes = Planes::default();
        per_part!(lanes: L, part => {
            if L::IS_WHOLE || active & all(part) != 0 {
                planes.put(part, &triangles);
            }
        });
        let mut pairs = 0;
        per_part!(lanes: L, part => {
            let valid = node.valid() & all(part);
            let mut active = if L::IS_WHOLE || valid != 0 { active } else { 0 };
            let boxes = facing.children(part, 1);
            let slabs = boxes.slabs();
            while active != 0 {
                let i = active.trailing_zeros() as usize;
                active &= active - 1;
                let [in_box, through_plane] = planes.at(i).depths(part, &boxes, &slabs);
                let apart = in_box.mask() | through_plane.mask();
                pairs |= u64::from(!apart & valid) << (WIDTH * i);
            }
        });
        pairs
    }
}

/// Stores the children of node `k` of two along their own axes and as seen from the other. Returns
/// the mask of those separated there from the own box of the other. `REREAD` is for a scale of 1:
/// reloading the children for each axis costs less than keeping them.
#[inline(always)]
fn stored<L: Lanes, const REREAD: bool>(
    lanes: L,
    facing: &Facing,
    k: usize,
    [own, seen]: &mut [Stored; 2],
) -> u32 {
    let (center, half) = facing.own(1 - k);
    let (along, against) = (half + center, half - center);
    let mut boxes = facing.children(lanes, k);
    own.put(&boxes.slabs());
    let [x, y, z] = per_axis!(i => {
        if REREAD {
            boxes = Boxes::children(lanes, L::settled(facing.nodes[k]), facing.scales[k]);
        }
        let (center, half) = boxes.seen_along(lanes, facing.views[k], i);
        let [far, near] = [center + half, half - center];
        far.put(&mut seen.along[i]);
        near.put(&mut seen.against[i]);
        (F8::splat(lanes, against.as_array()[i]) + far).min(F8::splat(lanes, along.as_array()[i]) + near)
    });
    x.min(y).min(z).mask()
}
