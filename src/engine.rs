//! The part of the query engine that callers of many queries use, such as `punctual-scene`: one
//! deadline for several queries, tests before a query, and states that it leaves behind.
//!
//! It may change with every version.

pub use crate::contact::{Fixed, inherit};
pub use crate::model::cost::TYPICAL_UNIT;
pub use crate::query::root_test;
pub use crate::query::{
    Ask, Deadline, QueryWithMemory, Question, Remembers, SYSTEM, SeparatingPlane, displacement,
    flushing_matters,
};
pub use crate::sets::{find, unite};
pub use crate::tree::Convex;
pub use crate::tree::inside::{Count, crossings, inside};
