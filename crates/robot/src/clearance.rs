//! Bounds how far the robot is from contact.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use punctual::StopReason;
use punctual::clock::ClockedBudget;
use punctual::glam::DVec3;

use crate::call::Call;
use crate::checker::Outcome;
use crate::order::BOX_WORK;
use crate::world::World;
use crate::{Checker, RobotError, ShapeId};

/// The pairs of shapes that count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Scope {
    /// All pairs that are checked.
    #[default]
    All,
    /// Pairs of the robot's own shapes, attached obstacles included.
    Robot,
    /// Pairs of a shape of the robot, or attached to it, and an obstacle that stands still.
    Obstacles,
    /// Pairs with this shape.
    Shape(ShapeId),
}

/// Options of a question for the clearance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ClearanceOptions {
    /// Width of the bounds, in metres: by default 1e-6. 0 means as close as f64 can resolve.
    pub tolerance: f64,
    /// The pairs that count.
    pub scope: Scope,
}

impl Default for ClearanceOptions {
    fn default() -> Self {
        Self {
            tolerance: 1e-6,
            scope: Scope::All,
        }
    }
}

impl ClearanceOptions {
    /// Sets the tolerance, in metres. NaN and negative values count as 0.
    #[must_use]
    pub fn tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// Sets the pairs that count.
    #[must_use]
    pub fn scope(self, scope: Scope) -> Self {
        Self { scope, ..self }
    }
}

/// The least distance of all pairs above their margins, within bounds: it is negative within a
/// margin. Without margins it is the least distance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Clearance {
    /// Proven lower bound, in metres: no pair's distance exceeds its margin by less. Infinite if no
    /// pair counts.
    pub low: f64,
    /// Proven upper bound, in metres: that of `pair`. Infinite if no pair was measured yet. For
    /// cylinders, their bands ([`Shape::band`](crate::Shape::band)) are added to the tolerance.
    pub high: f64,
    /// The closest pair found, the lower id first.
    pub pair: Option<[ShapeId; 2]>,
    /// Its closest points, in the world. The origin if one shape holds the other, or none was
    /// found.
    pub points: [DVec3; 2],
    /// Unit vector from the first of them to the second; 0 if they are one point.
    pub normal: DVec3,
}

impl Clearance {
    const UNKNOWN: Self = Self {
        low: 0.0,
        high: f64::INFINITY,
        pair: None,
        points: [DVec3::ZERO; 2],
        normal: DVec3::ZERO,
    };
}

/// The pairs that are still to be measured, the nearest first: a lower bound of the distance above
/// the margin as ordered bits, the pair, and true if boxes gave the bound.
pub(crate) type Bounds = BinaryHeap<Reverse<(i64, u32, bool)>>;

pub(crate) fn bound(gap: f64, number: u32, by_boxes: bool) -> Reverse<(i64, u32, bool)> {
    Reverse((ordered(gap), number, by_boxes))
}

/// The bits of a number, such that greater numbers have greater bits.
fn ordered(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    if bits < 0 { bits ^ i64::MAX } else { bits }
}

pub(crate) fn unordered(bits: i64) -> f64 {
    f64::from_bits((if bits < 0 { bits ^ i64::MAX } else { bits }) as u64)
}

/// A distance minus a margin, rounded if it is not exact.
fn above(distance: f64, margin: f64, round: fn(f64) -> f64) -> f64 {
    let left = distance - margin;
    let is_exact = margin == 0.0 || distance == 0.0;
    if is_exact { left } else { round(left) }
}

impl Checker {
    /// Bounds the least distance of all pairs of shapes at a configuration.
    ///
    /// **Guarantee.** `low` and `high` are proven, wherever the call stops. If it is finished, they
    /// are as close as the tolerance asks. 0 or less means contact; -margin that surfaces meet.
    ///
    /// # Errors
    /// [`RobotError::Length`], [`RobotError::JointValue`].
    pub fn clearance<'c>(
        &mut self,
        configuration: &[f64],
        options: &ClearanceOptions,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Outcome<Clearance>, RobotError> {
        let call = self.begin(configuration, budget.into())?;
        Ok(call.clearance(configuration, options))
    }
}

impl Call<'_, '_> {
    pub fn clearance(
        mut self,
        configuration: &[f64],
        options: &ClearanceOptions,
    ) -> Outcome<Clearance> {
        let low = -self.world.reach();
        let mut found = Clearance {
            low,
            ..Clearance::UNKNOWN
        };
        let mut bounds = std::mem::take(&mut self.room.bounds);
        let end = self.put(configuration, 0.0).and_then(|()| {
            bounds.clear();
            for number in 0..self.world.pairs.len() as u32 {
                if counts(self.world, number, options.scope) {
                    let pair = &self.world.pairs[number as usize];
                    let placement = &self.room.placement;
                    let gap = placement.sphere_gap(pair).max(-placement.margin(pair));
                    bounds.push(bound(gap, number, false));
                }
            }
            found.low = f64::INFINITY;
            let end = self.nearest(&mut bounds, options.tolerance, &mut found);
            // An unmeasured pair may be as near as the least bound.
            let left = bounds.peek().map(|bound| unordered(bound.0.0));
            found.low = found.low.min(left.unwrap_or(f64::INFINITY));
            end
        });
        self.room.bounds = bounds;
        self.outcome(found, end)
    }

    /// Measures pairs, the nearest by their bounds first, until no other can be nearer. A pair that
    /// is not done stays in the heap.
    fn nearest(
        &mut self,
        bounds: &mut Bounds,
        tolerance: f64,
        found: &mut Clearance,
    ) -> Result<(), StopReason> {
        // The least upper bound, before bands are added.
        let mut least = f64::INFINITY;
        while let Some(&Reverse((gap, number, by_boxes))) = bounds.peek() {
            let gap = unordered(gap);
            if gap >= least {
                break;
            }
            let (pair, shapes, b_in_a) = self.pair(number);
            if !by_boxes {
                self.deadline.pay(BOX_WORK)?;
                let gap = gap.max(self.room.placement.box_gap(pair, shapes, &b_in_a));
                bounds.pop();
                bounds.push(bound(gap, number, true));
                continue;
            }
            let band = shapes[0].band + shapes[1].band;
            let (measured, end) = self.measure(number, tolerance, least);
            if measured.high < least {
                least = measured.high;
                found.pair = Some(self.world.ids_of(number));
                found.points = measured.points;
                found.normal = (found.points[1] - found.points[0]).normalize_or_zero();
            }
            found.high = found.high.min(measured.high + band);
            end?;
            found.low = found.low.min(measured.low);
            bounds.pop();
        }
        Ok(())
    }

    /// Measures the distance of a pair above its margin, as far as it is less than `least`.
    pub fn measure(
        &mut self,
        number: u32,
        tolerance: f64,
        least: f64,
    ) -> (Measured, Result<(), StopReason>) {
        let (pair, shapes, b_in_a) = self.pair(number);
        let margin = self.room.placement.margin(pair);
        let mut found = Measured {
            low: -margin,
            high: -margin,
            points: [DVec3::ZERO; 2],
        };
        if self.holds_part(shapes, &b_in_a) {
            return (found, Ok(()));
        }
        let ceiling = least + margin;
        let (measured, end) = self.distance(number, |query| {
            query.absolute_tolerance(tolerance).below(ceiling)
        });
        found.low = above(measured.low, margin, f64::next_down);
        found.high = above(measured.high, margin, f64::next_up);
        if let Some(nearest) = measured.nearest {
            let place = self.room.placement.shape(self.world, pair.a);
            found.points = nearest.points.map(|p| place.transform_point3(p));
            if pair.a > pair.b {
                found.points.swap(0, 1);
            }
        }
        (found, end)
    }
}

/// The distance of one pair above its margin, and its closest points in the world: that of the
/// lower id first. Both are the origin if one shape holds the other.
pub(crate) struct Measured {
    pub low: f64,
    pub high: f64,
    pub points: [DVec3; 2],
}

pub(crate) fn counts(world: &World, number: u32, scope: Scope) -> bool {
    let a = world.pairs[number as usize].a as usize;
    let with_obstacle = world.shapes[a].body == 0 && a >= world.model.shapes.len();
    match scope {
        Scope::All => true,
        Scope::Robot => !with_obstacle,
        Scope::Obstacles => with_obstacle,
        Scope::Shape(id) => world.ids_of(number).contains(&id),
    }
}
