//! Children of a node as the 8 x 8 test takes them: by how far they reach.

use super::{Boxes, View};
use crate::math::lanes::{Column, F8, Lanes, V8, per_axis};
use crate::tree::Node;
use wide::f32x4;

/// Eight boxes by how far they reach along three axes, and how far against them. Boxes overlap by
/// the least sum of what they reach towards each other: sums, unlike differences, can be left in
/// the register of either.
pub(super) struct Reach<L: Lanes> {
    along: V8<L>,
    against: V8<L>,
}

/// Those of eight boxes, to be read one at a time: along, against.
pub(super) type Reaches = [[[f32; 8]; 3]; 2];

impl<L: Lanes> Reach<L> {
    /// Nothing stored yet: of boxes along their own axes, and as the other side sees them.
    pub const NONE: [Reaches; 2] = [[[[0.0; 8]; 3]; 2]; 2];

    /// Stores the children of a node along its own axes and as the other side sees them, and tells
    /// which are apart there from the given box. `REREAD` is for a scale of 1: to read them anew
    /// for each axis takes less than to keep them.
    #[inline(always)]
    pub fn children<const REREAD: bool>(
        lanes: L,
        (node, view, scale): (&Node, &View, f32),
        (center, half): (f32x4, f32x4),
        [own, seen]: &mut [Reaches; 2],
    ) -> u32 {
        let (along, against) = (half + center, half - center);
        let mut boxes = Boxes::children(lanes, node, scale);
        per_axis!(k => Reach::put(boxes.center[k], boxes.half[k], own, k));
        let [x, y, z] = per_axis!(k => {
            if REREAD {
                boxes = Boxes::children(lanes, L::settled(node), scale);
            }
            let (center, half) = boxes.seen_along(lanes, view, k);
            let [far, near] = Reach::put(center, half, seen, k);
            (F8::splat(lanes, against.as_array()[k]) + far).min(F8::splat(lanes, along.as_array()[k]) + near)
        });
        x.min(y).min(z).mask()
    }

    /// Stores how far boxes reach along axis `k`, and against it.
    #[inline(always)]
    fn put(center: F8<L>, half: F8<L>, [along, against]: &mut Reaches, k: usize) -> [F8<L>; 2] {
        let reach = [center + half, half - center];
        reach[0].put(&mut along[k]);
        reach[1].put(&mut against[k]);
        reach
    }

    #[inline(always)]
    pub fn load(lanes: L, [along, against]: &Reaches) -> Self {
        Self {
            along: per_axis!(k => F8::load(lanes, &along[k])),
            against: per_axis!(k => F8::load(lanes, &against[k])),
        }
    }

    /// How deep each lane overlaps box `i` of those that were stored; negative where they are
    /// apart.
    #[inline(always)]
    pub fn overlap_at(&self, lanes: L, [along, against]: &Reaches, i: usize) -> F8<L> {
        let [x, y, z] = per_axis!(k => {
            let (along, against) = (F8::splat(lanes, along[k][i]), F8::splat(lanes, against[k][i]));
            (against + self.along[k]).min(along + self.against[k])
        });
        x.min(y).min(z)
    }
}
