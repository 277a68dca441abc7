//! Work that a frame charges besides that of queries, in units of
//! [`Budget::work`](punctual::Budget::work).

use punctual::prediction::{MAX_DISTANCE_STEP_WORK, MAX_STEP_WORK};

/// Work charged for setting up the query of a pair; about what it takes.
pub const WORK_PER_QUERY: u64 = 250;

/// Work charged for the root test of a pair.
pub const WORK_PER_ROOT_TEST: u64 = 100;

/// Work charged for a plane between the bodies of a pair.
pub const WORK_PER_PLANE: u64 = 350;

/// Work charged for testing the last witness of a pair, including the set-up.
pub const WORK_PER_WITNESS: u64 = 120;

/// Work charged for testing the neighbors of the last witness: usually six pairs.
pub const WORK_PER_NEIGHBORS: u64 = 320;

/// Least work that is useful to a pair: a query and one step.
pub const LEAST_WORK: u64 = WORK_PER_QUERY + MAX_STEP_WORK;

/// Least work that is useful to a query of a pair for its distance, motion or contacts.
pub const LEAST_DISTANCE_WORK: u64 = WORK_PER_QUERY + MAX_DISTANCE_STEP_WORK;

/// Work per pair that takes as long as planning another round of a frame.
pub const WORK_PER_PLANNED_PAIR: u64 = 15;

/// Work that the broad phase of a frame may do beyond the budget of work, about 24 us. So a
/// small budget is left for queries, and a large one is not exceeded by much.
pub const BROAD_PHASE_WORK: u64 = 1 << 16;

/// Work in the broad phase, about what each operation takes: computing the box of a body, or its
/// swept box; replacing a fat AABB; inserting a body in each level of a tree that is built;
/// refitting an inner node; opening a node pair in the search; moving a key in each pass of a sort;
/// copying a pair to the next list; passing over a known pair; checking a pair; and adding a pair
/// to the report.
pub const WORK_PER_BOX: u64 = 120;
pub const WORK_PER_SWEPT_BOX: u64 = 400;
pub const WORK_PER_NEW_PLACE: u64 = 150;
pub const WORK_PER_BUILT_LEVEL: u64 = 20;
pub const WORK_PER_REFIT: u64 = 30;
pub const WORK_PER_SEARCH: u64 = 30;
pub const WORK_PER_SORTED_KEY: u64 = 15;
pub const WORK_PER_MERGED_PAIR: u64 = 10;
pub const WORK_PER_KNOWN_PAIR: u64 = 2;
pub const WORK_PER_PAIR_APART: u64 = 15;
pub const WORK_PER_LISTED_PAIR: u64 = 80;

/// Work of checking a pair of groups that is apart, and of listing another one.
pub const WORK_PER_PAIR_OF_GROUPS_APART: u64 = 60;
pub const WORK_PER_PAIR_OF_GROUPS: u64 = 300;

/// Work of keeping a pair in the report, and in its order, for another frame.
pub const WORK_PER_KEPT_PAIR: u64 = 3;

/// Work of reading the findings of a task about groups.
pub const WORK_PER_REPORTED_PAIR: u64 = 300;

/// Work of listing a pair that was found to meet before the broad phase.
pub const WORK_PER_FOUND_PAIR: u64 = 25;

/// Work of making room for a pair, and for its contacts.
pub const WORK_PER_STATE: u64 = 600;
pub const WORK_PER_TOUCH: u64 = 3000;
