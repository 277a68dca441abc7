//! Bounds of a distance, which only become tighter, and which pairs can still matter.

use punctual_geom::triangle::distance::Closest;

/// Bounds are close enough if `high - low <= absolute`, or `high <= (1 + relative) low`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tolerance {
    pub absolute: f64,
    pub relative: f64,
}

/// Bounds of the distance of two surfaces, in the length unit of the meshes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    tolerance: Tolerance,
    /// Sum of the margins of both surfaces.
    margin: f64,
    /// If finite, the question is only whether the thickened surfaces are closer than this.
    limit: f64,
    /// Distances beyond this are not resolved.
    ceiling: f64,
    /// An upper bound this small suffices, whatever the lower bound. With 0, only contact of the
    /// thickened surfaces suffices.
    enough: f64,
    low: f64,
    high: f64,
    /// Pairs at least this far apart no longer matter.
    cut: f64,
    /// The least lower bound of all pairs that are done: tested in `f64`, or too far apart to
    /// matter.
    done: f64,
    /// The closest pair found (tree order).
    nearest: Option<([u32; 2], Closest)>,
}

impl Interval {
    /// Nothing is known yet. `limit` is infinite if the question is the distance itself.
    pub fn new(tolerance: Tolerance, margin: f64, limit: f64) -> Self {
        let interval = Self {
            tolerance,
            margin,
            limit,
            ceiling: f64::INFINITY,
            enough: 0.0,
            low: 0.0,
            high: f64::INFINITY,
            cut: f64::INFINITY,
            done: f64::INFINITY,
            nearest: None,
        };
        interval.below(f64::INFINITY)
    }

    /// Does not resolve distances of the thickened surfaces above `ceiling`. The query still
    /// decides whether they meet.
    pub fn below(mut self, ceiling: f64) -> Self {
        self.ceiling = ceiling;
        self.cut = self.cut_now();
        self
    }

    /// Leaves it open whether surfaces within the absolute tolerance intersect. No effect with a
    /// limit.
    pub fn leaving_contact_open(self) -> Self {
        let absolute = self.tolerance.absolute;
        // Less than the tolerance, to cover the rounding when the margins are subtracted.
        let enough = absolute - 4.0 * f64::EPSILON * (absolute + 2.0 * self.margin);
        Self {
            enough: if self.has_limit() {
                0.0
            } else {
                enough.max(0.0)
            },
            ..self
        }
    }

    pub fn ceiling(&self) -> f64 {
        self.ceiling
    }

    /// The state before the first query, and for an empty mesh.
    pub fn nothing() -> Self {
        Self::new(Tolerance::default(), 0.0, f64::INFINITY)
    }

    /// Takes a lower bound that holds for all pairs. Returns true if it decides the question.
    pub fn know(&mut self, low: f64) -> bool {
        self.low = self.low.max(low);
        let is_enough = low >= self.cut;
        if is_enough {
            self.pass(low);
        }
        is_enough
    }

    /// Proven bounds without margins: no pair of surface points is closer than `low`, and the
    /// distance is at most `high`.
    pub fn low(&self) -> f64 {
        self.low
    }

    pub fn high(&self) -> f64 {
        self.high
    }

    pub fn nearest(&self) -> Option<([u32; 2], Closest)> {
        self.nearest
    }

    /// True if the question is only whether the surfaces are closer than a limit.
    pub fn has_limit(&self) -> bool {
        self.limit < f64::INFINITY
    }

    fn cut_now(&self) -> f64 {
        let (tolerance, margin, high) = (self.tolerance, self.margin, self.high);
        // More than the limit, so that what is proven at the cut is beyond the limit, also for 0.
        let beyond =
            |limit: f64| ((limit + margin) * (1.0 + 4.0 * f64::EPSILON)).max(f64::MIN_POSITIVE);
        if self.has_limit() {
            return beyond(self.limit);
        }
        let apart = (high - margin).min(self.ceiling);
        let mut enough =
            margin + (apart - tolerance.absolute).min(apart / (1.0 + tolerance.relative));
        if margin > 0.0 {
            // Covers the rounding when the margins are subtracted.
            enough = (enough + 4.0 * f64::EPSILON * (enough + margin)).min(high);
        }
        // The tolerance does not apply to the question whether the surfaces meet.
        enough.max(if self.ceiling < f64::INFINITY || margin > 0.0 {
            beyond(0.0)
        } else {
            0.0
        })
    }

    /// The square of the cut, rounded up, in units of the length `unit`. Never 0, so that a pair
    /// that may intersect still counts.
    pub fn square_cut(&self, unit: f64) -> f32 {
        let cut = self.cut / unit;
        ((cut * cut * (1.0 + f64::from(f32::EPSILON))) as f32).max(1e-36)
    }

    /// True if the thickened surfaces meet.
    pub fn touches(&self) -> bool {
        self.high <= self.margin
    }

    /// True if nothing left could change the answer: the thickened surfaces meet, or `high` is
    /// within what suffices or within the limit.
    pub fn is_decided(&self) -> bool {
        self.high <= self.margin + self.enough
            || self.has_limit() && self.high <= self.limit + self.margin
    }

    /// True if a pair that is at least `low` apart matters. One that may intersect always matters:
    /// the tolerance does not apply to the question whether surfaces meet.
    pub fn matters(&self, low: f64) -> bool {
        low < self.cut || low == 0.0
    }

    /// Takes the result of `f64` for a pair.
    pub fn settle(&mut self, pair: [u32; 2], found: &Closest) {
        self.pass(found.low);
        if found.high < self.high {
            self.high = found.high;
            self.cut = self.cut_now();
            self.nearest = Some((pair, *found));
        }
    }

    /// Records that pairs at least `low` apart are done.
    #[inline(always)]
    pub fn pass(&mut self, low: f64) {
        self.done = self.done.min(low);
    }

    /// Records that all pairs at the cut or beyond are done.
    #[inline(always)]
    pub fn pass_rest(&mut self) {
        self.pass(self.cut);
    }

    /// Raises the lower bound: no pair that is left is closer than `left`.
    ///
    /// Bounds of pairs only grow when the pairs are replaced by their children or done. So the
    /// bound at the end of a query is not less than any bound on the way.
    pub fn raise(&mut self, left: f64) {
        self.low = self.low.max(left.min(self.done));
    }
}
