//! The C interface: opaque handles, plain structs, a status from every call that can fail. No logic
//! of its own.
//!
//! `include/punctual.h` is generated from these files behind their macros, and their comments are
//! its comments; `docs/c.md` is the guide. `verbs` has what the functions of all questions are made
//! of. Pointers come in as `Option<&T>`, `Option<&mut T>` and
//! `Option<Box<T>>`, which have the layout of a pointer that may be null, so that only arrays,
//! texts, the caller's clock, and structs that may be shorter than here (`sized`) need code that
//! the compiler cannot check. `status::door` stands in each call that does any work: no panic
//! leaves it, every fault becomes a status and a text.
//!
//! # Safety
//! The functions that take arrays, texts, a clock or structs that begin with their size are
//! `unsafe`. Such a struct is null or has as many bytes as it says. An array is null with a length
//! of 0, or has as many elements as its length says, which nothing else writes to during the call;
//! a text ends with a zero byte. The function of a clock may be called with its context as long as
//! the call lasts, on the same thread, and does not unwind.

#![deny(missing_docs)]
#![allow(non_camel_case_types, reason = "the names of the header")]
#![allow(
    clippy::missing_safety_doc,
    reason = "the contract is the same for all: above, and in the head of the header"
)]
#![deny(clippy::undocumented_unsafe_blocks)]

mod arrays;
mod body;
mod budget;
mod calibration;
mod contacts;
mod distance;
mod estimate;
mod handle;
mod manifolds;
mod memory;
mod mesh;
mod motion;
mod near_points;
mod outcome;
mod penetration;
mod points;
mod pose;
mod query;
mod rays;
mod robot;
mod robot_motion;
mod scene;
mod scene_answers;
mod scene_groups;
mod scene_shapes;
mod self_intersection;
mod shapes;
mod sized;
mod status;
mod tree;
mod tree_shapes;
mod triangles;
mod verbs;
mod workspace;

pub use body::*;
pub use budget::*;
pub use calibration::*;
pub use contacts::*;
pub use distance::*;
pub use estimate::*;
pub use manifolds::*;
pub use memory::*;
pub use mesh::*;
pub use motion::*;
pub use near_points::*;
pub use outcome::*;
pub use penetration::*;
pub use points::*;
pub use pose::*;
pub use query::*;
pub use rays::*;
pub use robot::*;
pub use robot_motion::*;
pub use scene::*;
pub use scene_answers::*;
pub use scene_groups::*;
pub use scene_shapes::*;
pub use self_intersection::*;
pub use shapes::*;
pub use status::{punctual_last_error, punctual_status, punctual_version};
pub use tree::*;
pub use tree_shapes::*;
pub use triangles::*;
pub use workspace::*;
