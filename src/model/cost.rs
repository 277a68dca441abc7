//! What things cost: in units of work, which are the same everywhere, and in time, which is the machine's.
//!
//! Everything that the library assumes about cost stands here. The weights of work were fitted so that work is proportional
//! to time within about 20 % (`docs/performance.md`); a default [`CostModel`] is those weights at
//! 0.36 ns a unit.

/// Work of opening one node pair, besides its BV tests.
///
/// One unit of work is the time that one more BV test adds to an opened pair, about 0.36 ns. The weights are part of what a
/// budget of work means.
pub const WORK_PER_EXPANSION: u64 = 84;

/// Work of opening one node pair with so many BV tests.
pub(crate) const fn opening_work(bv_tests: u32) -> u64 {
    WORK_PER_EXPANSION + bv_tests as u64
}

/// Work of comparing the boxes of a slim node pair on their nine edge axes too, once they overlap on the face axes.
pub const WORK_PER_EDGE_TEST: u64 = 20;

/// Work of comparing the boxes of a node pair in `f64`, where only the margins of `f32` keep them together.
pub(crate) const WORK_PER_CLOSE_TEST: u64 = 170;

/// Work of one triangle test in the fast filter.
pub const WORK_PER_TRIANGLE_TEST: u64 = 44;

/// Work of one exact triangle test, on average.
pub const WORK_PER_EXACT_TEST: u64 = 200;

/// Work of a lower bound of the distance of two triangles in `f32`, and of their closest points in `f64`. The few pairs
/// that are
/// asked by all of their features, and the segment of surfaces that meet, which ends a query, take some times that.
pub(crate) const WORK_PER_DISTANCE_TEST: u64 = 130;
pub(crate) const WORK_PER_CLOSEST_POINTS: u64 = 700;

/// The same of closest points of which the features are known: of one of four pairs, and of one alone.
pub(crate) const WORK_PER_FEATURES: u64 = 100;
pub(crate) const WORK_PER_FEATURES_ALONE: u64 = 300;

/// Work of opening a node pair of a motion, besides its BV tests; of one of these; and of comparing two triangles that move in
/// `f32`.
pub(crate) const WORK_PER_SWEPT_EXPANSION: u64 = 180;
pub(crate) const WORK_PER_SWEPT_TEST: u64 = 4;
pub(crate) const WORK_PER_WINDOW_TEST: u64 = 48;

/// Work of passing over a piece of a motion in which the meshes are too far apart.
pub(crate) const WORK_PER_PIECE: u64 = 300;

/// Work of a step in which a pair of moving triangles is followed in `f64`.
pub(crate) const WORK_PER_WINDOW: u64 = 600;

/// Work of the segment in which two triangles meet, on average; the most is some times that.
pub(crate) const WORK_PER_SEGMENT: u64 = 700;

/// Work of adding a contact to the list.
pub(crate) const WORK_PER_CONTACT: u64 = 100;

/// Work of finding out what is known of a pair of clusters.
pub(crate) const WORK_PER_LOOKUP: u64 = 10;

/// Work of getting ready to follow a curve, or its other end too, and of finding the next pair along it.
pub(crate) const WORK_PER_MARCH: u64 = 100;
pub(crate) const WORK_PER_MARCH_BESIDE: u64 = 30;
pub(crate) const WORK_PER_MARCH_STEP: u64 = 70;

/// Work of making a ray ready, of testing it against the children of a node, of each triangle of a cluster in `f32`, and of a
/// triangle in `f64`.
pub(crate) const WORK_PER_RAY: u64 = 100;
pub(crate) const WORK_PER_RAY_NODE: u64 = 40;
pub(crate) const WORK_PER_RAY_TRIANGLE: u64 = 8;
pub(crate) const WORK_PER_RAY_TEST: u64 = 100;

const _: () = assert!(MAX_STEP_WORK >= WORK_PER_RAY_TEST + WORK_PER_EXACT_TEST);

/// The most work that is done between two looks at the budget: a batch of eight triangle tests.
pub const MAX_STEP_WORK: u64 = 8 * WORK_PER_TRIANGLE_TEST;

/// The same for queries of distance, contacts and motion: a batch of eight lower bounds.
pub const MAX_DISTANCE_STEP_WORK: u64 = 8 * WORK_PER_DISTANCE_TEST;

const _: () = assert!(
    MAX_DISTANCE_STEP_WORK >= WORK_PER_CLOSEST_POINTS + WORK_PER_EXACT_TEST + WORK_PER_CONTACT
        && MAX_DISTANCE_STEP_WORK >= WORK_PER_FEATURES_ALONE + WORK_PER_CLOSEST_POINTS
        && MAX_DISTANCE_STEP_WORK >= 4 * (WORK_PER_FEATURES + WORK_PER_CONTACT)
        && MAX_DISTANCE_STEP_WORK >= WORK_PER_WINDOW
        && MAX_DISTANCE_STEP_WORK
            >= WORK_PER_SWEPT_EXPANSION + 65 * WORK_PER_SWEPT_TEST + WORK_PER_EDGE_TEST
        && MAX_DISTANCE_STEP_WORK >= 8 * WORK_PER_WINDOW_TEST
);

const _: () = assert!(WORK_PER_SEGMENT <= WORK_PER_CLOSEST_POINTS);

const _: () = assert!(
    MAX_STEP_WORK >= WORK_PER_EXPANSION + WORK_PER_CLOSE_TEST + WORK_PER_EDGE_TEST + 65
        && MAX_STEP_WORK >= WORK_PER_EXACT_TEST
);

/// Work that counts for setting up the query of a pair in a scene, about what it takes.
pub(crate) const WORK_PER_QUERY: u64 = 250;

/// Work that counts for the root test of a pair in a scene.
pub(crate) const WORK_PER_ROOT_TEST: u64 = 100;

/// Work that counts for a plane between the bodies of such a pair.
pub(crate) const WORK_PER_PLANE: u64 = 350;

/// Work that counts for testing the last witness of a pair in a scene, set-up included.
pub(crate) const WORK_PER_WITNESS: u64 = 120;

/// The same for testing what lies next to it: six pairs as a rule.
pub(crate) const WORK_PER_NEIGHBORS: u64 = 320;

/// The least that is of use to a pair in a scene: a query and one step.
pub(crate) const LEAST_WORK: u64 = WORK_PER_QUERY + MAX_STEP_WORK;

/// The same of a distance.
pub(crate) const LEAST_DISTANCE_WORK: u64 = WORK_PER_QUERY + MAX_DISTANCE_STEP_WORK;

/// Work of bringing a contact into a patch and of choosing points for it, about what it takes.
pub(crate) const WORK_PER_PATCHED_CONTACT: u64 = 1200;

/// Contacts that there is room to patch after every query of contacts in a scene.
pub(crate) const LEAST_PATCHED: u64 = 2;

/// The least that is of use to a pair in a scene which asks for contacts.
pub(crate) const LEAST_CONTACT_WORK: u64 =
    LEAST_DISTANCE_WORK + LEAST_PATCHED * WORK_PER_PATCHED_CONTACT;

/// Work that takes as long as planning another round of a scene's frame, for each pair.
pub(crate) const WORK_PER_PLANNED_PAIR: u64 = 15;

/// Work that the broad phase of a scene's frame may do beyond the budget of work: about 24 us, so that a small budget is for
/// queries, and a large one is not passed by much.
pub(crate) const BROAD_PHASE_WORK: u64 = 1 << 16;

/// Work in the broad phase of a scene, about what each takes: the box of a body, or of its way; a fat AABB that is replaced; a
/// body in each level of a tree that is built; an inner node that is refitted; a node pair that is opened in the search; a key
/// in each pass of a sort; a pair that is copied to the next list; one that is looked at, and one that gets into the report.
pub(crate) const WORK_PER_BOX: u64 = 120;
pub(crate) const WORK_PER_SWEPT_BOX: u64 = 400;
pub(crate) const WORK_PER_NEW_PLACE: u64 = 150;
pub(crate) const WORK_PER_BUILT_LEVEL: u64 = 20;
pub(crate) const WORK_PER_REFIT: u64 = 30;
pub(crate) const WORK_PER_SEARCH: u64 = 30;
pub(crate) const WORK_PER_SORTED_KEY: u64 = 15;
pub(crate) const WORK_PER_MERGED_PAIR: u64 = 10;
pub(crate) const WORK_PER_PAIR_APART: u64 = 15;
pub(crate) const WORK_PER_LISTED_PAIR: u64 = 80;

/// Work of listing a pair that was found to meet before the broad phase.
pub(crate) const WORK_PER_FOUND_PAIR: u64 = 25;

/// Work of making room for a pair, and for its contacts.
pub(crate) const WORK_PER_STATE: u64 = 600;
pub(crate) const WORK_PER_TOUCH: u64 = 3000;

/// Nanoseconds of a unit of work, the median over 8,373 queries (`docs/performance.md`).
pub(crate) const TYPICAL_UNIT: f64 = 0.36;

/// Upper bound on the nanoseconds of a unit of work, as far as a machine allows one: eight times what is usual. With 1 ns,
/// large trees out of cache were 5 us late in one call of a hundred.
pub(crate) const SLOWEST_UNIT: f64 = 3.0;

/// The same, relative to the mean of a call.
pub(crate) const SLOWEST_TO_MEAN: f64 = 8.0;

/// How much slower the first units of a call may be: code and memory that were not in use come from far.
pub(crate) const FIRST_TO_SLOWEST: u64 = 8;

/// Work that takes as long at the slowest unit as the one step whose time differs a hundredfold, an exact triangle test: 3.1 us
/// at most, of the 48,100 hard pairs of the tests.
pub(crate) const LONGEST_STEP: u64 = 3_000;

/// Both for a part of a call that may end a little late, as long as the call does not.
pub(crate) const SLOW_UNIT_OF_A_PART: f64 = 1.0;
pub(crate) const SLOW_TO_MEAN_OF_A_PART: f64 = 2.0;

/// Nanoseconds of setting up a query, as measured by [`CostModel::measure`].
const TYPICAL_SETUP: f64 = 61.0;

/// What a query does, in numbers; expected values may be fractions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counts {
    /// `N_v`, box overlap tests.
    pub bv_tests: f64,
    /// `N_p`, triangle pairs tested.
    pub triangle_tests: f64,
    /// `N_u`, boxes brought up to date: in a rigid query the frames of an opened node pair, so node pairs opened.
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

    /// The same in units of work, exact tests aside.
    pub fn work(&self) -> f64 {
        self.bv_tests
            + self.triangle_tests * WORK_PER_TRIANGLE_TEST as f64
            + self.box_updates * WORK_PER_EXPANSION as f64
    }
}

/// `T = N_v C_v + N_p C_p + N_u C_u + C_i`, the paper's cost function; all costs in one unit of time, the caller's.
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
    /// In nanoseconds, as measured on one machine: the weights of work at 0.36 ns a unit, and 61 ns to set up a query.
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
    /// From `C_v`, `C_p`, `C_u`, `C_i`.
    #[must_use]
    pub const fn new([bv_test, triangle_test, box_update, setup]: [f64; 4]) -> Self {
        Self {
            bv_test,
            triangle_test,
            box_update,
            setup,
        }
    }

    /// The time of a query that does this.
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

    /// The costs after a query that did this and took so long: all of them are moved by a part of the ratio between that and
    /// what was expected. A ratio beyond 4 counts as 4, since a machine is also busy with other things.
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
