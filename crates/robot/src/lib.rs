//! Robots: does a configuration collide, how much clearance does it have, is a motion in joint
//! space free? The answers are exact or proven, within budgets, from queries of the crate
//! `punctual`.
//!
//! A [`Model`] is read from URDF and SRDF files ([`Model::from_urdf`], feature `urdf`, on by
//! default), or made from a [`Description`]. It is immutable and shared. A [`Checker`] is the robot
//! among obstacles; each thread has one, or one checker answers batches on several threads.
//!
//! ```no_run
//! use punctual::{Budget, Pose};
//! use punctual_robot::{Checker, Collision, EdgeAnswer, EdgeOptions, Model, Shape};
//! # #[cfg(feature = "urdf")] {
//! let options = punctual_robot::UrdfOptions::default().srdf("arm.srdf");
//! let mut checker = Checker::new(Model::from_urdf("arm.urdf", &options)?.into());
//! checker.add("table", Pose::IDENTITY, Shape::cuboid([1.0, 1.0, 0.05])?)?;
//! let (from, to) = ([0.0, 0.3, -1.0], [0.5, 0.2, -0.8]);
//! assert_eq!(checker.collide(&from, Budget::unlimited())?.value, Collision::Free);
//! let edge = checker.edge(&from, &to, &EdgeOptions::any(), Budget::unlimited())?.value;
//! assert_eq!(edge.answer, EdgeAnswer::Free);
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Frames and units
//!
//! The root link stands still at the origin of the world. Poses map coordinates of a link, or of an
//! obstacle, to those of the world. Lengths are in metres and angles in radians, as in URDF. A
//! configuration has one number for each joint of [`Model::joint_names`].
//!
//! # Guarantees
//!
//! - **Exact for the poses of [`Model::link_poses`].** Filters only prove shapes apart; the rest is
//!   decided by exact queries. Shapes and what they stand for: [`Shape`].
//! - **Edges are proven**, not sampled ([`Checker::edge`]).
//! - **Budgets.** A call stops at its budget, and its answer is true then. A budget of work may be
//!   exceeded by the work of placing the robot once and filtering its pairs.
//! - **Quiet.** Calls for one configuration or edge do not panic or lock. They allocate only while
//!   they see more intervals or pairs at a time than ever before. [`Checker::move_to`] allocates
//!   only the first time.
//! - **Deterministic.** The same calls give the same bits on one machine, batches on any number of
//!   threads. Sines are those of the platform, so poses may differ in the last bit elsewhere.
//!
//! The guide is `docs/guide/robots.md` of `punctual`.

#![deny(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(doctest, doc = include_str!("../README.md"))]

// A call places the shapes (`placement`) and tests spheres of all pairs at once (`near`). It then
// tests the remaining pairs in the learned order (`order`): boxes, then an exact query (`call`).
// Edges (`edge`) and clearances (`clearance`) use the same steps. A `Horizon` keeps an edge for
// what stands still, with a room of its own, and asks about a short one in each cycle for the rest.

mod batch;
mod call;
mod checker;
mod clearance;
mod edge;
mod error;
mod horizon;
mod margin;
mod model;
mod near;
mod order;
mod pairs;
mod placement;
mod shape;
mod track;
mod trajectory;
mod transform;
#[cfg(feature = "urdf")]
mod urdf;
mod world;

pub use checker::{Checker, Collision, Outcome};
pub use clearance::{Clearance, ClearanceOptions, Scope};
pub use edge::{Edge, EdgeAnswer, EdgeOptions};
pub use error::RobotError;
pub use horizon::{Ahead, Horizon, braking_time, safe_speed};
pub use margin::Margin;
pub use model::{Description, Joint, JointKind, LARGEST, Link, Mimic, Model};
pub use pairs::{NearPair, NearPairs};
pub use shape::Shape;
pub use track::Track;
pub use trajectory::Trajectory;
#[cfg(feature = "urdf")]
pub use urdf::UrdfOptions;
pub use world::ShapeId;
