//! What is known of a distance: bounds that only ever close in, and which pairs can still matter.

use crate::triangle::distance::Closest;

/// When bounds are close enough: `high - low <= absolute`, or `high <= (1 + relative) low`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tolerance {
    pub absolute: f64,
    pub relative: f64,
}

/// Bounds of the distance of two surfaces, in the length unit of the meshes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    tolerance: Tolerance,
    /// By how much both surfaces together are thickened.
    margin: f64,
    /// If finite, all that is asked is whether the thickened surfaces are closer than this.
    limit: f64,
    /// Distances beyond this are not told apart.
    ceiling: f64,
    /// An upper bound that is enough whatever lies below it; 0: only contact is.
    enough: f64,
    low: f64,
    high: f64,
    /// Pairs at least this far apart do not matter any more.
    cut: f64,
    /// The least lower bound of all pairs that are done with: looked at in `f64`, or too far apart
    /// to matter.
    done: f64,
    /// The closest pair found (tree order).
    nearest: Option<([u32; 2], Closest)>,
}

impl Interval {
    /// Nothing is known yet. `limit` is infinite if the distance itself is asked for.
    pub fn new(tolerance: Tolerance, margin: f64, limit: f64) -> Self {
        let [cut, high, done] = [f64::INFINITY; 3];
        let (ceiling, enough) = (f64::INFINITY, 0.0);
        let mut interval = Self {
            tolerance,
            margin,
            limit,
            ceiling,
            enough,
            low: 0.0,
            high,
            cut,
            done,
            nearest: None,
        };
        interval.cut = interval.cut_now();
        interval
    }

    /// Does not tell distances of the thickened surfaces apart that are greater than this. Whether
    /// they meet is still asked.
    pub fn below(mut self, ceiling: f64) -> Self {
        self.ceiling = ceiling;
        self.cut = self.cut_now();
        self
    }

    /// Leaves open whether surfaces meet that are no farther apart than the absolute tolerance, if
    /// the distance is asked for.
    pub fn leaving_contact_open(self) -> Self {
        let Self {
            tolerance: Tolerance { absolute, .. },
            margin,
            ..
        } = self;
        // Less than the tolerance, for what rounding takes when the margins are subtracted.
        let enough = (absolute - 4.0 * f64::EPSILON * (absolute + 2.0 * margin)).max(0.0);
        Self {
            enough: if self.has_limit() { 0.0 } else { enough },
            ..self
        }
    }

    pub fn ceiling(&self) -> f64 {
        self.ceiling
    }

    /// Before the first query, and where one of the meshes is empty.
    pub fn nothing() -> Self {
        Self::new(
            Tolerance {
                absolute: 0.0,
                relative: 0.0,
            },
            0.0,
            f64::INFINITY,
        )
    }

    /// Takes note of a lower bound that is known of all pairs; returns whether that decides all
    /// that is asked.
    pub fn know(&mut self, low: f64) -> bool {
        self.low = self.low.max(low);
        let is_enough = low >= self.cut;
        if is_enough {
            self.pass(low);
        }
        is_enough
    }

    /// No surface is closer than this, nor is the distance more than `high`; both without margins.
    pub fn low(&self) -> f64 {
        self.low
    }

    pub fn high(&self) -> f64 {
        self.high
    }

    pub fn nearest(&self) -> Option<([u32; 2], Closest)> {
        self.nearest
    }

    /// Whether all that is asked is if the surfaces are closer than a limit.
    pub fn has_limit(&self) -> bool {
        self.limit < f64::INFINITY
    }

    fn cut_now(&self) -> f64 {
        let Self {
            tolerance,
            margin,
            limit,
            ceiling,
            high,
            ..
        } = *self;
        // More than the limit, so that what is proven then is too; also if that is 0.
        let beyond =
            |limit: f64| ((limit + margin) * (1.0 + 4.0 * f64::EPSILON)).max(f64::MIN_POSITIVE);
        if self.has_limit() {
            return beyond(limit);
        }
        let apart = (high - margin).min(ceiling);
        let mut enough =
            margin + (apart - tolerance.absolute).min(apart / (1.0 + tolerance.relative));
        if margin > 0.0 {
            // For what rounding takes when the margins are subtracted.
            enough = (enough + 4.0 * f64::EPSILON * (enough + margin)).min(high);
        }
        // Whether the surfaces meet is no question of tolerance.
        enough.max(if ceiling < f64::INFINITY || margin > 0.0 {
            beyond(0.0)
        } else {
            0.0
        })
    }

    /// Its square, not less, in units of this length. Never so small that a pair that may meet
    /// would not matter.
    pub fn square_cut(&self, unit: f64) -> f32 {
        let cut = self.cut / unit;
        ((cut * cut * (1.0 + f64::from(f32::EPSILON))) as f32).max(1e-36)
    }

    /// Whether the thickened surfaces meet.
    pub fn touches(&self) -> bool {
        self.high <= self.margin
    }

    /// Whether nothing that is left could change the answer: the thickened surfaces meet, or are
    /// closer than the limit, or than is told apart.
    pub fn is_decided(&self) -> bool {
        self.high <= self.margin + self.enough
            || self.has_limit() && self.high <= self.limit + self.margin
    }

    /// Whether a pair that is at least this far apart matters. One that may meet always does:
    /// whether surfaces meet is no question of tolerance.
    pub fn matters(&self, low: f64) -> bool {
        low < self.cut || low == 0.0
    }

    /// Takes note of what `f64` says of a pair.
    pub fn settle(&mut self, pair: [u32; 2], found: &Closest) {
        self.pass(found.low);
        if found.high < self.high {
            self.high = found.high;
            self.cut = self.cut_now();
            self.nearest = Some((pair, *found));
        }
    }

    /// Takes note that pairs at least this far apart are done with.
    #[inline(always)]
    pub fn pass(&mut self, low: f64) {
        self.done = self.done.min(low);
    }

    /// The same of whatever is too far apart to matter now.
    #[inline(always)]
    pub fn pass_rest(&mut self) {
        self.pass(self.cut);
    }

    /// Takes note that no pair that is left is closer than this.
    ///
    /// Bounds of pairs only grow when they are replaced by their children or done with, so at the
    /// end of a query this is no less than what was known on the way.
    pub fn raise(&mut self, left: f64) {
        self.low = self.low.max(left.min(self.done));
    }
}
