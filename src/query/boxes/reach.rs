//! Children of a node in the form of the 8 x 8 test: their extents along each axis, in both
//! directions.

use super::{Boxes, View};
use crate::tree::Node;
use punctual_geom::lanes::{Column, F8, Lanes, V8, per_axis};
use wide::f32x4;

/// Eight boxes by their upper ends along three axes, and the negatives of their lower ends. The
/// overlap of two boxes is the least sum of the extents towards each other. Sums, unlike
/// differences, can stay in the register of either operand.
pub(super) struct Reach<L: Lanes> {
    along: V8<L>,
    against: V8<L>,
}

/// Upper ends, and negated lower ends, of eight boxes, stored for access one at a time.
pub(super) type Reaches = [[[f32; 8]; 3]; 2];

impl<L: Lanes> Reach<L> {
    /// Empty storage: for boxes along their own axes, and as seen from the other side.
    pub const NONE: [Reaches; 2] = [[[[0.0; 8]; 3]; 2]; 2];

    /// Stores the children of a node along their own axes and as seen from the other side. Returns
    /// the mask of those separated there from the given box. `REREAD` is for a scale of 1:
    /// reloading the children for each axis costs less than keeping them.
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

    /// Stores the extents of boxes along axis `k`, in both directions.
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

    /// Overlap depth of every lane with stored box `i`; negative means a gap.
    #[inline(always)]
    pub fn overlap_at(&self, lanes: L, [along, against]: &Reaches, i: usize) -> F8<L> {
        let [x, y, z] = per_axis!(k => {
            let (along, against) = (F8::splat(lanes, along[k][i]), F8::splat(lanes, against[k][i]));
            (against + self.along[k]).min(along + self.against[k])
        });
        x.min(y).min(z)
    }
}
