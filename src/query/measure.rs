//! Measures the costs on this machine with a few timed queries.

use super::budget::{Budget, Clock};
use super::options::Mode;
use super::question::Query;
use super::workspace::Workspace;
use crate::mesh::shapes;
use crate::model::cost::{CostModel, Counts};
use crate::model::least_squares::least_squares;
use crate::tree::Tree;
use alloc::vec::Vec;
use core::time::Duration;
use glam::{DMat3, DVec3};
use punctual_geom::{Pose, nanoseconds};

/// Number of poses, and of repetitions of each query; the shortest time counts.
const POSES: u32 = 24;
const REPETITIONS: usize = 12;

/// Weight that pulls the ratios of the costs towards those of the default model.
const PULL: f64 = 2.0;

impl CostModel {
    /// Measures the costs on this machine with the system clock, in nanoseconds, by queries of two
    /// built-in shapes, in cache. Takes a few milliseconds. Returns the default model if the system
    /// has no clock ([`Budget::time`]).
    pub fn measure() -> Self {
        Self::measure_with(&crate::query::SYSTEM)
    }

    /// [`CostModel::measure`] with another clock. Returns the default model if the clock stands
    /// still.
    pub fn measure_with(clock: &dyn Clock) -> Self {
        let (a, b) = (
            Tree::new(shapes::icosphere(3)),
            Tree::new(shapes::torus(1.0, 0.3, 24)),
        );
        let mut workspace = Workspace::with_capacity(0, 1 << 14);
        let (mut features, mut times) = (Vec::new(), Vec::new());
        for i in 0..POSES {
            let translation = DVec3::new(2.4 * f64::from(i) / f64::from(POSES), 0.3, 0.2);
            let Ok(pose) = Pose::new(DMat3::from_rotation_y(f64::from(i)), translation) else {
                continue;
            };
            for mode in [Mode::Any, Mode::All] {
                let query = Query::intersection(&a, &b, pose).mode(mode);
                let (mut least, mut counts) = (Duration::MAX, Counts::default());
                for _ in 0..REPETITIONS {
                    let start = clock.now();
                    let outcome = query.run(&mut workspace, Budget::unlimited().clock(clock));
                    least = least.min(clock.now().saturating_sub(start));
                    counts = core::hint::black_box(outcome).stats.counts();
                }
                features.push([
                    counts.bv_tests,
                    counts.triangle_tests,
                    counts.box_updates,
                    1.0,
                ]);
                times.push(nanoseconds(least));
            }
        }
        Self::fitted(&features, &times)
    }

    /// Approximate time of a [`Tree::refit`] of this tree, within a factor of two or three: `N_u
    /// C_u`, where `N_u` is the number of boxes of all its nodes and triangles. `O(1)`.
    pub fn refit_time(&self, tree: &Tree) -> f64 {
        (tree.nodes().len() + tree.triangles().len()) as f64 * self.box_update
    }

    /// The costs that fit the times best, by relative error. Poorly determined costs stay near
    /// those of the default model, scaled by one common factor.
    fn fitted(features: &[[f64; 4]], times: &[f64]) -> Self {
        let default = Self::default();
        let known = [
            default.bv_test,
            default.triangle_test,
            default.box_update,
            default.setup,
        ];
        let expected = features
            .iter()
            .map(|x| x.iter().zip(known).map(|(x, c)| x * c).sum::<f64>());
        let mut ratios: Vec<f64> = times
            .iter()
            .zip(expected)
            .map(|(time, expected)| time / expected)
            .collect();
        ratios.sort_unstable_by(f64::total_cmp);
        let Some(&factor) = ratios
            .get(ratios.len() / 2)
            .filter(|factor| factor.is_finite() && **factor > 0.0)
        else {
            return default;
        };
        let mut x: Vec<[f64; 4]> = features.to_vec();
        let mut y = times.to_vec();
        let mut weights: Vec<f64> = times
            .iter()
            .map(|time| 1.0 / (time * time).max(1.0))
            .collect();
        for (k, cost) in known.into_iter().enumerate() {
            let mut row = [0.0; 4];
            row[k] = 1.0;
            x.push(row);
            y.push(factor * cost);
            weights.push(PULL / (factor * cost * factor * cost));
        }
        let fitted = least_squares(&x, &y, &weights);
        Self::new(core::array::from_fn(|k| {
            fitted[k].max(0.1 * factor * known[k])
        }))
    }
}
