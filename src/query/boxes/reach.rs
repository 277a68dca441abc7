//! Children of a node as the 8 x 8 test takes them: by how far they reach.

use super::{Boxes, View};
use crate::math::lanes::{Column, F8, Lanes, V8, per_axis};
use crate::tree::{Node, xyz};
use wide::f32x4;

/// Eight boxes by how far they reach along three axes, and how far against them. Boxes overlap by the least sum of what they
/// reach towards each other: sums, unlike differences, can be left in the register of either.
pub(super) struct Reach<L: Lanes> {
    along: V8<L>,
    against: V8<L>,
}

/// Those of eight boxes, to be read one at a time: along, against.
pub(super) type Reaches = [[[f32; 8]; 3]; 2];

impl<L: Lanes> Reach<L> {
    /// The children of a node along its own axes and as the other side sees them, and which are apart there from the given box.
    #[inline(always)]
    pub fn children(lanes: L, node: (&Node, &View, f32), other: (f32x4, f32x4)) -> (u32, [Reaches; 2]) {
        let ((node, view, scale), (center, half)) = (node, other);
        let boxes = Boxes::children(lanes, node, scale);
        let seen = Reach::of(&boxes.seen(lanes, view));
        let apart = seen.overlap(lanes, xyz(half + center), xyz(half - center)).mask();
        (apart, [Reach::of(&boxes).store(), seen.store()])
    }

    #[inline(always)]
    fn of(boxes: &Boxes<L>) -> Self {
        Self {
            along: per_axis!(k => boxes.center[k] + boxes.half[k]),
            against: per_axis!(k => boxes.half[k] - boxes.center[k]),
        }
    }

    /// How deep each lane overlaps a box that reaches so far; negative where they are apart.
    #[inline(always)]
    fn overlap(&self, lanes: L, along: [f32; 3], against: [f32; 3]) -> F8<L> {
        let [x, y, z] = per_axis!(k => {
            (F8::splat(lanes, against[k]) + self.along[k]).min(F8::splat(lanes, along[k]) + self.against[k])
        });
        x.min(y).min(z)
    }

    #[inline(always)]
    fn store(&self) -> Reaches {
        [per_axis!(k => self.along[k].store()), per_axis!(k => self.against[k].store())]
    }

    #[inline(always)]
    pub fn load(lanes: L, [along, against]: &Reaches) -> Self {
        Self {
            along: per_axis!(k => F8::load(lanes, &along[k])),
            against: per_axis!(k => F8::load(lanes, &against[k])),
        }
    }

    /// [`Self::overlap`] with box `i` of those that were stored.
    #[inline(always)]
    pub fn overlap_at(&self, lanes: L, [along, against]: &Reaches, i: usize) -> F8<L> {
        self.overlap(lanes, per_axis!(k => along[k][i]), per_axis!(k => against[k][i]))
    }
}
