//! The root test: a lower bound of the distance of two surfaces, from the boxes below their roots.
//!
//! Most pairs of a scene are separated, and these boxes show it for half of them. Comparing them
//! takes less time than starting a query, which tests nothing else first. The bound is that of
//! `gaps` along the best single axis. `O(1)`: 64 box tests.

use crate::engine::boxes::flushing;
use crate::engine::boxes::overlap::Overlap;
use crate::engine::boxes::relative_pose::{RelativePose, Views};
use crate::engine::boxes::{Facing, StoredExtents};
use crate::engine::expand::{self, Measure};
use crate::engine::workspace::Workspace;
use crate::tree::{Node, Tree};
use punctual_geom::lanes::{Column, F8, Kernel, Lanes};
use punctual_geom::{Pose, bits};

/// A lower bound of the distance of two meshes, in their length unit; 0 if these boxes do not
/// separate them.
pub fn distance([a, b]: [&Tree; 2], b_in_a: &Pose, workspace: &Workspace) -> f64 {
    let (Some(x), Some(y)) = (a.nodes().first(), b.nodes().first()) else {
        return 0.0;
    };
    if flushing::matters(a, b, b_in_a) {
        return 0.0;
    }
    let relative = RelativePose::new(a, b, b_in_a);
    let depth = workspace.instructions.run(RootTest {
        a: x,
        b: y,
        relative: &relative,
    });
    // Axes that are not exactly orthonormal shrink its square by at most this factor.
    if depth < 0.0 {
        f64::from(-depth) * relative.unit * f64::from(relative.shrink)
    } else {
        0.0
    }
}

/// Computes the largest overlap depth of a child of each node, in A's units; negative if all are
/// separated.
struct RootTest<'g> {
    a: &'g Node,
    b: &'g Node,
    relative: &'g RelativePose,
}

impl Kernel for RootTest<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> f32 {
        let Self { a, b, relative } = self;
        let views = Views::between(a, b, relative);
        let facing = Facing {
            nodes: [a, b],
            views: [&views.of_a, &views.of_b],
            scales: [1.0, relative.scale],
            is_a: true,
        };
        let measure = Overlap::default();
        let x = StoredExtents::of(&measure.children(lanes, &facing, 0));
        let y = measure.children(lanes, &facing, 1);
        // Lanes of B without a child hold the middle of its box, which can only lower the bound.
        let mut deepest = F8::splat(lanes, f32::NEG_INFINITY);
        for i in bits(a.valid()) {
            deepest = deepest.max(expand::key(lanes, &measure, &x.at(lanes, i), &y));
        }
        deepest
            .store()
            .into_iter()
            .fold(f32::NEG_INFINITY, f32::max)
    }
}
