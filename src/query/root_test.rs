//! The root test of two surfaces: how far apart they are at least, by the boxes below their roots.
//!
//! Most pairs of a scene are apart, and half of these already by these boxes. To begin a query,
//! which asks nothing else first, takes longer than to compare them. The bound is that of
//! [`gaps`](super::gaps) along the best single axis. `O(1)`: 64 box tests.

use super::boxes::Boxes;
use super::views::{Relation, Views};
use super::workspace::Workspace;
use crate::math::lanes::{Column, F8, Kernel, Lanes};
use crate::math::{Pose, bits};
use crate::tree::{Node, Tree};

/// A lower bound of the distance of two meshes, in their unit of length; 0 if these boxes do not
/// part them.
pub(crate) fn distance([a, b]: [&Tree; 2], b_in_a: &Pose, workspace: &Workspace) -> f64 {
    let (Some(x), Some(y)) = (a.nodes().first(), b.nodes().first()) else {
        return 0.0;
    };
    let relation = Relation::new(a, b, b_in_a);
    let depth = workspace.instructions.run(RootTest {
        a: x,
        b: y,
        relation: &relation,
    });
    // Axes that are not quite orthonormal shrink its square by no more than this.
    if depth < 0.0 {
        f64::from(-depth) * relation.unit * f64::from(relation.shrink)
    } else {
        0.0
    }
}

/// How deep the children of two nodes overlap, in A's units, at most; negative if all are apart.
struct RootTest<'g> {
    a: &'g Node,
    b: &'g Node,
    relation: &'g Relation,
}

impl Kernel for RootTest<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> f32 {
        let Self { a, b, relation } = self;
        let views = Views::between(a, b, relation);
        let (of_a, of_b) = (
            Boxes::children(lanes, a, 1.0),
            Boxes::children(lanes, b, relation.scale),
        );
        let (own_a, seen_a) = (
            of_a.slabs().store(),
            of_a.seen(lanes, &views.of_a).slabs().store(),
        );
        let (own_b, seen_b) = (of_b.slabs(), of_b.seen(lanes, &views.of_b).slabs());
        // Lanes of B without a child hold the middle of its box, which only makes the bound lower.
        let mut deepest = F8::splat(lanes, f32::NEG_INFINITY);
        for i in bits(a.valid()) {
            deepest = deepest.max(
                seen_b
                    .depth_at(lanes, &own_a, i)
                    .min(own_b.depth_at(lanes, &seen_a, i)),
            );
        }
        deepest
            .store()
            .into_iter()
            .fold(f32::NEG_INFINITY, f32::max)
    }
}
