//! One triangle against eight others at a time, in the coordinates of the others.

use super::batch::{
    Bounds, Crossings, EDGE_SLOP, Range, Rows, Transposed, UNDERFLOW, Verdicts, certain, largest,
};
use crate::math::lanes::{Column, D8, F8, Lanes, dot, per_axis, per_part};
use crate::math::tolerance::ROUNDING;

/// A triangle that is the same in all eight pairs, in the coordinates of the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub first: [f64; 3],
    pub edges: [[f32; 3]; 2],
    /// Bound on the error of a corner of either, beyond its rounding.
    pub slop: f32,
    /// The same for its edges, over [`ROUNDING`].
    pub edge_slop: f32,
}

impl Placed {
    /// Tests it against the eight triangles.
    #[inline(always)]
    #[allow(clippy::needless_option_as_deref)]
    pub fn test<L: Lanes>(
        &self,
        lanes: L,
        others: [&Rows; 8],
        mut crossings: Option<&mut Crossings>,
    ) -> Verdicts {
        let mut verdicts = Verdicts::NONE;
        per_part!(lanes: L, part => {
            verdicts.add(self.test_part(part, others, crossings.as_deref_mut()));
        });
        verdicts
    }

    #[inline(always)]
    fn test_part<L: Lanes>(
        &self,
        lanes: L,
        others: [&Rows; 8],
        crossings: Option<&mut Crossings>,
    ) -> Verdicts {
        let others = Transposed::new(lanes, others);
        let corner = others.corner();
        let q = per_axis!(k => (D8::splat(lanes, self.first[k]) - corner[k]).narrow());
        let (p1, p2) = (others.edge1, others.edge2);
        let [f1, f2] = self
            .edges
            .map(|edge| per_axis!(k => F8::splat(lanes, edge[k])));
        let sizes = [
            largest(p1).max(largest(p2)) + F8::splat(lanes, EDGE_SLOP),
            largest(f1).max(largest(f2)) + F8::splat(lanes, self.edge_slop),
            largest(q) + F8::splat(lanes, self.slop * (1.0 / ROUNDING)),
        ];
        let bounds = Bounds::new(sizes, ROUNDING, F8::splat(lanes, UNDERFLOW));
        certain([p1, p2], [f1, f2], q, &bounds, crossings)
    }
}

/// The room above and below a triangle, between planes through its sides. What it says does not depend on how large the triangle
/// is, where the bounds of [`Placed`] grow with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prism {
    /// By component: the directions outward across the sides and the normal, of length 1 or a little less.
    pub directions: [[f32; 4]; 3],
    /// The middle of the triangle along its normal.
    pub middle: f32,
    /// How far it may reach outward across its sides, and from the middle along its normal.
    pub reach: [f32; 4],
    /// How much less it certainly reaches.
    pub slack: f32,
    /// Whether some of the other mesh may be beyond a side.
    pub has_sides: bool,
    /// Whether the triangle is no sliver: then what passes through the room passes through it.
    pub is_whole: bool,
}

/// The place of the normal among the directions.
pub(crate) const NORMAL: usize = 3;

impl Prism {
    pub const NONE: Self = Self {
        directions: [[0.0; 4]; 3],
        middle: 0.0,
        reach: [0.0; 4],
        slack: 0.0,
        has_sides: false,
        is_whole: false,
    };

    /// Triangles that certainly pass through the triangle because they are in its room and on both sides of its plane, and those
    /// that are certainly beyond its plane or one of its sides.
    #[inline(always)]
    pub fn test<L: Lanes>(&self, lanes: L, others: [&Rows; 8]) -> Verdicts {
        let mut verdicts = Verdicts::NONE;
        per_part!(lanes: L, part => {
            let Transposed { first, edge1, edge2, .. } = Transposed::new(part, others);
            let corners = [first, per_axis!(k => first[k] + edge1[k]), per_axis!(k => first[k] + edge2[k])];
            let reach = F8::splat(part, self.reach[NORMAL]);
            let along = self.along(part, NORMAL, &corners);
            let middle = F8::splat(part, self.middle);
            let along = Range { low: along.low - middle, high: along.high - middle };
            let (mut hit, mut miss) = (along.mixed(reach), along.same(reach));
            if self.has_sides {
                let [x, y, z] = per_axis!(i => {
                    let across = self.along(part, i, &corners);
                    let reach = F8::splat(part, self.reach[i]);
                    (across.high.less(reach - F8::splat(part, self.slack)), reach.less(across.low))
                });
                hit = hit.and(x.0).and(y.0).and(z.0);
                miss = miss.or(x.1).or(y.1).or(z.1);
            }
            verdicts.add(Verdicts { hit: hit.mask(), doubt: !(hit.mask() | miss.mask()) & 0xff });
        });
        verdicts
    }

    #[inline(always)]
    fn along<L: Lanes>(&self, lanes: L, i: usize, corners: &[[F8<L>; 3]; 3]) -> Range<F8<L>> {
        let direction = per_axis!(k => F8::splat(lanes, self.directions[k][i]));
        Range::of(per_axis!(j => dot(direction, corners[j])))
    }
}
