//! Costs of operations: in units of work, which are the same everywhere, and in time, which depends
//! on the machine.
//!
//! All assumptions of the library about costs are in this module. The weights of work were fitted
//! so that work is proportional to time within about 20 % (`docs/performance.md`). A default
//! [`CostModel`] is those weights at 0.36 ns per unit.

/// Work of opening one node pair, without its BV tests.
///
/// One unit of work is the time that one more BV test adds to an opened pair, about 0.36 ns. The
/// weights define the meaning of a budget of work.
pub const WORK_PER_EXPANSION: u64 = 84;

/// Additional work of comparing the boxes of a slim node pair on their nine edge axes. They are
/// compared on these axes only if they overlap on the face axes.
pub const WORK_PER_EDGE_TEST: u64 = 20;

/// Work of comparing the boxes of a node pair in `f64`, if they overlap only within the margins of
/// `f32`.
pub(crate) const WORK_PER_CLOSE_TEST: u64 = 170;

/// Work of comparing the triangles of two leaves along their normals.
pub(crate) const WORK_PER_LEAVES: u64 = 120;

/// Work of one triangle test in the fast filter.
pub const WORK_PER_TRIANGLE_TEST: u64 = 44;

/// Work of one exact triangle test, on average.
pub const WORK_PER_EXACT_TEST: u64 = 200;

/// Work of a lower bound of the distance of two triangles in `f32`, and of their closest points in
/// `f64`. Two rare cases take several times as much: a pair that is tested by all of its features,
/// and the segment of two surfaces that meet. That segment ends a query.
pub(crate) const WORK_PER_DISTANCE_TEST: u64 = 130;
pub(crate) const WORK_PER_CLOSEST_POINTS: u64 = 700;

/// Work of opening a node pair of a motion, without its BV tests; of one of these tests; and of
/// comparing two moving triangles in `f32`.
pub(crate) const WORK_PER_SWEPT_EXPANSION: u64 = 180;
pub(crate) const WORK_PER_SWEPT_TEST: u64 = 4;
pub(crate) const WORK_PER_WINDOW_TEST: u64 = 48;

/// Work of skipping a substep of a motion in which the meshes are too far apart.
pub(crate) const WORK_PER_SUBSTEP: u64 = 300;

/// Work of computing, in `f64`, the time in which two moving triangles may meet during one step.
pub(crate) const WORK_PER_WINDOW: u64 = 600;

/// Average work of the segment in which two triangles meet. The maximum is several times as much.
pub(crate) const WORK_PER_SEGMENT: u64 = 700;

/// Work of adding a contact to the list.
pub(crate) const WORK_PER_CONTACT: u64 = 100;

/// Work of adding the common area of two triangles to a manifold, and of finding how far one vertex
/// is drawn in.
pub(crate) const WORK_PER_AREA: u64 = 300;
pub(crate) const WORK_PER_WAY: u64 = 400;

/// Work of one pass over a pair of triangles of a contact curve, and over a triangle inside the
/// other surface.
pub(crate) const WORK_PER_CURVE_PAIR: u64 = 150;
pub(crate) const WORK_PER_REGION_TRIANGLE: u64 = 100;

/// Work of discarding a pair that needs neither opening nor a test, and of looking up a pair of
/// leaves in a table.
pub(crate) const WORK_PER_LOOKUP: u64 = 10;

/// Work of preparing to trace a curve, of also preparing to trace it in the other direction, and of
/// finding the next pair along it.
pub(crate) const WORK_PER_TRACE: u64 = 100;
pub(crate) const WORK_PER_TRACE_BESIDE: u64 = 30;
pub(crate) const WORK_PER_TRACE_STEP: u64 = 70;

/// Work of preparing a ray, of testing it against the children of a node, of testing it against
/// each triangle of a leaf in `f32`, and of testing it against a triangle in `f64`.
pub(crate) const WORK_PER_RAY: u64 = 100;
pub(crate) const WORK_PER_RAY_NODE: u64 = 40;
pub(crate) const WORK_PER_RAY_TRIANGLE: u64 = 8;
pub(crate) const WORK_PER_RAY_TEST: u64 = 100;

const _: () = assert!(MAX_STEP_WORK >= WORK_PER_RAY_TEST + WORK_PER_EXACT_TEST);

/// Work of bounding the distances of a point of a cloud and eight triangles in `f32`.
pub(crate) const WORK_PER_POINT_AROUND: u64 = 70;

/// Work of preparing a point, of testing it against a triangle in `f64`, and of a vertex or an edge
/// of the boundary of an open solid. Nodes cost as for rays.
pub(crate) const WORK_PER_POINT: u64 = 150;
pub(crate) const WORK_PER_POINT_TRIANGLE: u64 = 120;
pub(crate) const WORK_PER_OPEN_EDGE: u64 = 6;

/// Maximum work between two checks of the budget: a batch of eight triangle tests.
pub const MAX_STEP_WORK: u64 = 8 * WORK_PER_TRIANGLE_TEST;

/// Maximum work between two checks of the budget in queries of distances, signed ones too,
/// contacts, manifolds and motions: a batch of eight lower bounds.
pub const MAX_DISTANCE_STEP_WORK: u64 = 8 * WORK_PER_DISTANCE_TEST;

const _: () = assert!(
    MAX_DISTANCE_STEP_WORK >= WORK_PER_CLOSEST_POINTS + WORK_PER_EXACT_TEST + WORK_PER_CONTACT
        && MAX_DISTANCE_STEP_WORK >= WORK_PER_WINDOW
        && MAX_DISTANCE_STEP_WORK
            >= WORK_PER_SWEPT_EXPANSION + 65 * WORK_PER_SWEPT_TEST + WORK_PER_EDGE_TEST
        && MAX_DISTANCE_STEP_WORK
            >= WORK_PER_EXPANSION + WORK_PER_CLOSE_TEST + 65 * 2 + WORK_PER_LEAVES
        && MAX_DISTANCE_STEP_WORK >= 8 * WORK_PER_WINDOW_TEST
        && MAX_DISTANCE_STEP_WORK
            >= WORK_PER_EXPANSION + WORK_PER_CLOSE_TEST + 65 * 2 + 8 * WORK_PER_POINT_AROUND
);

const _: () = assert!(WORK_PER_SEGMENT <= WORK_PER_CLOSEST_POINTS);

const _: () = assert!(
    MAX_STEP_WORK >= WORK_PER_EXPANSION + WORK_PER_CLOSE_TEST + WORK_PER_EDGE_TEST + 65
        && MAX_STEP_WORK >= WORK_PER_EXACT_TEST
);

/// Nanoseconds per unit of work, the median over 8,373 queries (`docs/performance.md`).
pub const TYPICAL_UNIT: f64 = 0.36;

/// Assumed upper bound of the nanoseconds per unit of work: eight times the typical value. No
/// machine guarantees such a bound. With 1 ns, one call in a hundred ended 5 us late if the trees
/// were large and not in the cache.
pub(crate) const SLOWEST_UNIT: f64 = 3.0;

/// Assumed upper bound of the time per unit of work, relative to the mean of the call so far.
pub(crate) const SLOWEST_TO_MEAN: f64 = 8.0;

/// Factor by which the first units of a call may be slower than the upper bound: their code and
/// data may not be in the cache.
pub(crate) const FIRST_TO_SLOWEST: u64 = 8;

/// Work reserved for an exact triangle test, the one step whose time varies a hundredfold. Of the
/// 48,100 hard pairs of the tests, the slowest took 3.1 us.
pub(crate) const LONGEST_STEP: u64 = 3_000;

/// [`SLOWEST_UNIT`] and [`SLOWEST_TO_MEAN`] for a part of a call. A part may end a little late,
/// because the call as a whole still ends in time.
pub(crate) const SLOW_UNIT_OF_A_PART: f64 = 1.0;
pub(crate) const SLOW_TO_MEAN_OF_A_PART: f64 = 2.0;

/// Nanoseconds to set up a query, as measured on one machine.
const TYPICAL_SETUP: f64 = 61.0;

/// Operation counts of a query; expected values may be fractions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counts {
    /// `N_v`, box overlap tests.
    pub bv_tests: f64,
    /// `N_p`, triangle pairs tested.
    pub triangle_tests: f64,
    /// `N_u`, updated boxes. A rigid query updates the frames of each opened node pair, so this
    /// counts opened node pairs.
    pub box_updates: f64,
}

impl Counts {
    /// These counts minus earlier ones.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        Self {
            bv_tests: self.bv_tests - before.bv_tests,
            triangle_tests: self.triangle_tests - before.triangle_tests,
            box_updates: self.box_updates - before.box_updates,
        }
    }

    /// These counts in units of work, without exact tests.
    pub fn work(&self) -> f64 {
        self.bv_tests
            + self.triangle_tests * WORK_PER_TRIANGLE_TEST as f64
            + self.box_updates * WORK_PER_EXPANSION as f64
    }
}

/// `T = N_v C_v + N_p C_p + N_u C_u + C_i`, the paper's cost function. All costs are in one unit of
/// time, chosen by the caller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
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
    /// In nanoseconds, as measured on one machine: the weights of work at 0.36 ns a unit, and 61 ns
    /// to set up a query.
    fn default() -> Self {
        Self::new([
            1.0,
            WORK_PER_TRIANGLE_TEST as f64,
            WORK_PER_EXPANSION as f64,
            TYPICAL_SETUP / TYPICAL_UNIT,
        ])
        .scaled(TYPICAL_UNIT)
    }
}

impl CostModel {
    /// A model from `C_v`, `C_p`, `C_u`, `C_i`.
    #[must_use]
    pub const fn new([bv_test, triangle_test, box_update, setup]: [f64; 4]) -> Self {
        Self {
            bv_test,
            triangle_test,
            box_update,
            setup,
        }
    }

    /// The time of a query with these counts.
    pub fn time(&self, counts: &Counts) -> f64 {
        counts.bv_tests * self.bv_test
            + counts.triangle_tests * self.triangle_test
            + counts.box_updates * self.box_update
            + self.setup
    }

    /// All costs times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self::new(
            [
                self.bv_test,
                self.triangle_test,
                self.box_update,
                self.setup,
            ]
            .map(|cost| cost * factor),
        )
    }

    /// The costs after a query with these counts that took this time. All costs are multiplied by
    /// the eighth root of the ratio between measured and expected time. The ratio is limited to 1/4
    /// to 4, because a machine is also busy with other things.
    #[must_use]
    pub fn learned(&self, counts: &Counts, time: f64) -> Self {
        let ratio = (time / self.time(counts)).clamp(0.25, 4.0);
        if ratio.is_nan() {
            *self
        } else {
            self.scaled(libm::sqrt(libm::sqrt(libm::sqrt(ratio))))
        }
    }
}
