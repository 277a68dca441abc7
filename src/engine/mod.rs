//! The part of the query engine that callers of many queries use, such as `punctual-scene`: one
//! deadline for several queries, tests before a query, and states that it leaves behind.
//!
//! It may change with every version.

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
pub use crate::tree::inside::{Count, crossings, inside};
pub use apart::root_test;
pub use apart::separating_plane::SeparatingPlane;
pub use boxes::flushing::matters as flushing_matters;
pub use deadline::Deadline;
pub use deadline::system::SYSTEM;
pub use memory::clearance::displacement;
pub use memory::identity::{Fixed, inherit};
pub use question::{Ask, QueryWithMemory, Question, Remembers};
