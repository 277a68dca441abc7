//! All pairs of shapes that are near each other, with gradients of their distances.

use punctual::Budget;
use std::cmp::Reverse;

use punctual::StopReason;
use punctual::clock::ClockedBudget;
use punctual::glam::DVec3;

use crate::call::Call;
use crate::checker::Outcome;
use crate::clearance::{bound, counts, unordered};
use crate::order::BOX_WORK;
use crate::{Checker, ClearanceOptions, RobotError, ShapeId};

/// A pair of shapes that are near each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NearPair {
    /// The shapes, the lower id first.
    pub pair: [ShapeId; 2],
    /// Proven lower bound of their distance above their margin, in metres.
    pub low: f64,
    /// Proven upper bound.
    pub high: f64,
    /// Their closest points, in the world. The origin if one shape holds the other.
    pub points: [DVec3; 2],
    /// Unit vector from the first of them to the second; 0 if they are one point.
    pub normal: DVec3,
}

/// The pairs of a configuration that are near each other, by ascending ids.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct NearPairs {
    /// The pairs.
    pub pairs: Vec<NearPair>,
    /// The gradient of each pair's distance, a row of joints for each (m/rad or m/m): how fast its
    /// closest points come apart along the normal if a joint moves. Of points that touch it is 0.
    /// Where several points are closest, it is that of those in [`NearPair::points`].
    pub gradients: Vec<f64>,
}

impl NearPairs {
    /// The gradient of one pair, by its index.
    pub fn gradient(&self, pair: usize) -> &[f64] {
        let width = self.gradients.len() / self.pairs.len().max(1);
        &self.gradients[pair * width..][..width]
    }
}

impl Checker {
    /// Lists all pairs whose distance exceeds their margin by at most `within` metres (NaN counts
    /// as 0), each with bounds of that distance, its closest points and a gradient: for
    /// optimisation, model-predictive control and barrier functions. They replace the content of
    /// `found`.
    ///
    /// **Guarantee.** The value is a proven lower bound of the distance above the margin of each
    /// pair that is not listed: `within` at least, if the call is finished. The pairs with the
    /// least bounds are measured first. A listed pair may be beyond by the tolerance.
    ///
    /// # Errors
    /// [`RobotError::Length`], [`RobotError::JointValue`].
    pub fn near_pairs<'c>(
        &mut self,
        configuration: &[f64],
        within: f64,
        options: &ClearanceOptions,
        budget: impl Into<ClockedBudget<'c>>,
        found: &mut NearPairs,
    ) -> Result<Outcome<f64>, RobotError> {
        let call = self.begin(configuration, budget.into())?;
        Ok(call.near_pairs(configuration, within, options, found))
    }

    /// [`Checker::near_pairs`] for many configurations, as [`Checker::collide_batch`].
    ///
    /// # Errors
    /// Those of [`Checker::collide_batch`].
    pub fn near_pairs_batch(
        &mut self,
        configurations: &[f64],
        within: f64,
        options: &ClearanceOptions,
        budget: Budget,
        threads: usize,
    ) -> Result<Vec<(Outcome<f64>, NearPairs)>, RobotError> {
        let (rows, width) = self.model().rows(configurations)?;
        Ok(self.batch(rows, budget, threads, |call, row| {
            let mut found = NearPairs::default();
            let row = &configurations[row * width..][..width];
            (call.near_pairs(row, within, options, &mut found), found)
        }))
    }
}

impl Call<'_, '_> {
    fn near_pairs(
        mut self,
        configuration: &[f64],
        within: f64,
        options: &ClearanceOptions,
        found: &mut NearPairs,
    ) -> Outcome<f64> {
        found.pairs.clear();
        found.gradients.clear();
        let within = if within.is_nan() { 0.0 } else { within };
        let ceiling = within + 1e-12 * within.abs() + 2.0 * options.tolerance.max(0.0);
        let mut bounds = std::mem::take(&mut self.room.bounds);
        bounds.clear();
        let mut least = -self.world.reach();
        let mut list = || -> Result<(), StopReason> {
            self.put(configuration, 0.0)?;
            for number in 0..self.world.pairs.len() as u32 {
                let (pair, placement) = (&self.world.pairs[number as usize], &self.room.placement);
                let gap = placement.sphere_gap(pair).max(-placement.margin(pair));
                if gap <= within && counts(self.world, number, options.scope) {
                    bounds.push(bound(gap, number, false));
                }
            }
            least = within;
            while let Some(&Reverse((gap, number, by_boxes))) = bounds.peek() {
                let gap = unordered(gap);
                if !by_boxes {
                    self.deadline.pay(BOX_WORK)?;
                    let (pair, shapes, b_in_a) = self.pair(number);
                    let gap = gap.max(self.room.placement.box_gap(pair, shapes, &b_in_a));
                    bounds.pop();
                    if gap <= within {
                        bounds.push(bound(gap, number, true));
                    }
                    continue;
                }
                // A bound within the tolerance of the ceiling may end a query.
                let (measured, end) = self.measure(number, options.tolerance, ceiling);
                end?;
                bounds.pop();
                if measured.low <= within && measured.high < f64::INFINITY {
                    let [a, b] = measured.points;
                    let (_, shapes, _) = self.pair(number);
                    found.pairs.push(NearPair {
                        pair: self.world.ids_of(number),
                        low: measured.low,
                        high: measured.high + shapes[0].band + shapes[1].band,
                        points: [a, b],
                        normal: (b - a).normalize_or_zero(),
                    });
                }
            }
            Ok(())
        };
        let end = list();
        let left = bounds.peek().map(|bound| unordered(bound.0.0));
        let least = least.min(left.unwrap_or(f64::INFINITY));
        self.room.bounds = bounds;
        let (NearPairs { pairs, gradients }, width) = (found, configuration.len());
        pairs.sort_unstable_by_key(|near| near.pair);
        gradients.resize(pairs.len() * width, 0.0);
        for (near, row) in pairs.iter().zip(gradients.chunks_mut(width.max(1))) {
            for (i, sign) in [-1.0, 1.0].into_iter().enumerate() {
                let (along, placement) = (sign * near.normal, &self.room.placement);
                if let Some(shape) = self.world.index(near.pair[i]) {
                    placement.add_gradient(self.world, shape, near.points[i], along, row);
                }
            }
        }
        self.outcome(least, end)
    }
}
