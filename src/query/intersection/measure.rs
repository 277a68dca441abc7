//! Measures the costs on this machine with a few timed queries.

use crate::engine::deadline::budget::{Budget, Clock};
use crate::engine::options::Mode;
use crate::engine::question::Query;
use crate::engine::workspace::Workspace;
use crate::mesh::shapes;
use crate::model::cost::CostModel;
use crate::tree::Tree;
use alloc::vec::Vec;
use core::time::Duration;
use glam::{DMat3, DVec3};
use punctual_geom::{Pose, nanoseconds};

/// Number of poses, and of repetitions of each query; the shortest time counts.
const POSES: u32 = 24;
const REPETITIONS: usize = 12;

impl CostModel {
    /// Measures the costs on this machine with the system clock, in nanoseconds, by queries of two
    /// built-in shapes, in cache: the default model times the median ratio of measured to expected
    /// times. Takes a few milliseconds. Returns the default model if the system has no clock
    /// ([`Budget::time`]).
    pub fn measure() -> Self {
        Self::measure_with(&crate::engine::SYSTEM)
    }

    /// [`CostModel::measure`] with another clock. Returns the default model if the clock stands
    /// still.
    pub fn measure_with(clock: &dyn Clock) -> Self {
        let (a, b) = (
            Tree::new(shapes::icosphere(3)),
            Tree::new(shapes::torus(1.0, 0.3, 24)),
        );
        let mut workspace = Workspace::with_capacity(0, 1 << 14);
        let (default, mut ratios) = (Self::default(), Vec::new());
        for i in 0..POSES {
            let translation = DVec3::new(2.4 * f64::from(i) / f64::from(POSES), 0.3, 0.2);
            let Ok(pose) = Pose::new(DMat3::from_rotation_y(f64::from(i)), translation) else {
                continue;
            };
            for mode in [Mode::Any, Mode::All] {
                let query = Query::intersection(&a, &b, pose).mode(mode);
                let (mut least, mut expected) = (Duration::MAX, 0.0);
                for _ in 0..REPETITIONS {
                    let start = clock.now();
                    let answer = query.run(&mut workspace, Budget::unlimited().clock(clock));
                    least = least.min(clock.now().saturating_sub(start));
                    expected = default.time(&core::hint::black_box(answer).stats.counts());
                }
                ratios.push(nanoseconds(least) / expected);
            }
        }
        ratios.sort_unstable_by(f64::total_cmp);
        let median = ratios.get(ratios.len() / 2).filter(|ratio| **ratio > 0.0);
        median.map_or(default, |ratio| default.scaled(*ratio))
    }

    /// Approximate time of a [`Tree::refit`] of this tree, within a factor of two or three: `N_u
    /// C_u`, where `N_u` is the number of boxes of all its nodes and triangles. `O(1)`.
    pub fn refit_time(&self, tree: &Tree) -> f64 {
        (tree.nodes().len() + tree.triangles().len()) as f64 * self.box_update
    }
}
