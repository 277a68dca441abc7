//! The cost function: what counts cost in time.

use super::constants::NANOSECONDS;

/// What a query does, in numbers; expected values may be fractions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counts {
    /// `N_v`, box overlap tests.
    pub bv_tests: f64,
    /// `N_p`, triangle pairs tested.
    pub triangle_tests: f64,
    /// `N_u`, boxes brought up to date.
    pub box_updates: f64,
}

impl Counts {
    /// What was done since these counts.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        Self {
            bv_tests: self.bv_tests - before.bv_tests,
            triangle_tests: self.triangle_tests - before.triangle_tests,
            box_updates: self.box_updates - before.box_updates,
        }
    }
}

/// `T = N_v C_v + N_p C_p + N_u C_u + C_i`; all costs in one unit of time, the caller's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CostModel {
    /// `C_v`, one box overlap test.
    pub bv_test: f64,
    /// `C_p`, one triangle pair.
    pub triangle_test: f64,
    /// `C_u`, one box update.
    pub box_update: f64,
    /// `C_i`, the set-up of one query.
    pub setup: f64,
}

impl Default for CostModel {
    /// As measured where the other constants of the model were fitted, in nanoseconds.
    fn default() -> Self {
        let [bv_test, triangle_test, box_update, setup] = NANOSECONDS;
        Self { bv_test, triangle_test, box_update, setup }
    }
}

impl CostModel {
    /// The time of a query that does this.
    pub fn time(&self, counts: &Counts) -> f64 {
        counts.bv_tests * self.bv_test
            + counts.triangle_tests * self.triangle_test
            + counts.box_updates * self.box_update
            + self.setup
    }

    /// The costs after a query that did this and took so long: all of them are moved by a part of the ratio between that and
    /// what was expected. A ratio beyond 4 counts as 4, since a machine is also busy with other things.
    #[must_use]
    pub fn learned(&self, counts: &Counts, time: f64) -> Self {
        let ratio = (time / self.time(counts)).clamp(0.25, 4.0);
        if ratio.is_nan() {
            return *self;
        }
        let factor = libm::pow(ratio, 0.125);
        Self {
            bv_test: self.bv_test * factor,
            triangle_test: self.triangle_test * factor,
            box_update: self.box_update * factor,
            setup: self.setup * factor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_count_has_its_own_cost() {
        let costs = CostModel { bv_test: 2.0, triangle_test: 30.0, box_update: 500.0, setup: 7000.0 };
        let counts = Counts { bv_tests: 1.5, triangle_tests: 2.0, box_updates: 3.0 };
        assert_eq!(costs.time(&Counts::default()), 7000.0);
        assert_eq!(costs.time(&counts), 3.0 + 60.0 + 1500.0 + 7000.0);
    }
}
