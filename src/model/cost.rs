//! The cost function: what counts cost in time.

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

/// `T = N_v C_v + N_p C_p + N_u C_u + C_i`; all costs in one unit of time, the caller's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CostFunction {
    /// `C_v`, one box overlap test.
    pub bv_test: f64,
    /// `C_p`, one triangle pair.
    pub triangle_test: f64,
    /// `C_u`, one box update.
    pub box_update: f64,
    /// `C_i`, the set-up of one query.
    pub setup: f64,
}

impl CostFunction {
    /// The time of a query that does this.
    pub fn time(&self, counts: &Counts) -> f64 {
        counts.bv_tests * self.bv_test
            + counts.triangle_tests * self.triangle_test
            + counts.box_updates * self.box_update
            + self.setup
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_count_has_its_own_cost() {
        let costs = CostFunction { bv_test: 2.0, triangle_test: 30.0, box_update: 500.0, setup: 7000.0 };
        let counts = Counts { bv_tests: 1.5, triangle_tests: 2.0, box_updates: 3.0 };
        assert_eq!(costs.time(&Counts::default()), 7000.0);
        assert_eq!(costs.time(&counts), 3.0 + 60.0 + 1500.0 + 7000.0);
    }
}
