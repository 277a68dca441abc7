//! What all questions share: the loop over node pairs, the frontier, boxes, deadlines, memory. For
//! callers of many queries, such as `punctual-scene`, it is also the face of the query engine:
//! [`Ask`] prepares and continues a run by hand, one [`Deadline`] lasts for several queries,
//! [`root_test`] and [`SeparatingPlane`] prove surfaces apart without a query, and [`inherit`]
//! hands ids on from frame to frame. It may change with every version.
//!
//! # Notation
//!
//! | word | meaning |
//! |---|---|
//! | A, B | the two bodies. Lengths, points and normals are in A's frame; `b_in_a` maps B's coordinates into it |
//! | tree order | the triangles of a tree in the order of its leaves. Inside the engine triangles have these numbers, in answers those of the input mesh |
//! | pair | a node of A and a node of B, with the children of each that are still of interest. For rays and points: a node and a key |
//! | to open | to replace a pair by those pairs of its children that matter to the question |
//! | frontier | the pairs still to be opened. What is not decided lies below them |
//! | key | a number by which the frontier orders pairs: depth of overlap, least distance, time of entry |
//! | unit of work | the time of one more box test. All steps are counted in it, with weights that are the same on every machine |
//! | step | what is done between two looks at the deadline: at most [`MAX_STEP_WORK`] units |
//! | N_v, N_p | numbers of box tests and of triangle tests of a query |
//! | levels | log2 of the triangles below a node: the height of a binary tree over them |
//! | alpha | the factor by which boxes of a subtree shrink from one binary level to the next, for each axis or as a product |
//! | run | a query from its start to its end, over as many calls as its budgets make of it |
//!
//! [`MAX_STEP_WORK`]: crate::prediction::MAX_STEP_WORK

pub mod apart;
pub(crate) mod boxes;
pub(crate) mod certificate;
pub(crate) mod deadline;
pub(crate) mod expand;
pub(crate) mod frontier;
pub(crate) mod memory;
pub(crate) mod options;
pub(crate) mod outcome;
pub(crate) mod question;
pub(crate) mod strategy;
pub(crate) mod traversal;
pub(crate) mod triangles;
pub(crate) mod workspace;

pub use crate::model::cost::TYPICAL_UNIT;
pub use crate::sets::{find, unite};
pub use crate::tree::Convex;
pub use crate::tree::solid::inside::{Count, crossings, inside};
pub use apart::root_test;
pub use apart::separating_plane::SeparatingPlane;
pub use boxes::flushing::matters as flushing_matters;
pub use deadline::Deadline;
pub use deadline::system::SYSTEM;
pub use memory::clearance::displacement;
pub use memory::identity::{Fixed, inherit};
pub use question::{Ask, QueryWithMemory, Question, Remembers};
