//! Robots.
#![deny(missing_docs)]
#![forbid(unsafe_code)]
#![allow(missing_docs)]

mod batch;
mod checker;
mod clearance;
mod edge;
mod error;
mod model;
mod near;
mod order;
mod placement;
mod search;
mod shape;
mod transform;
#[cfg(feature = "urdf")]
mod urdf;
mod world;

pub use checker::{Checker, Collision, Outcome};
pub use clearance::{Clearance, ClearanceOptions, Scope};
pub use edge::{Edge, EdgeAnswer, EdgeOptions};
pub use error::RobotError;
pub use model::{Description, Joint, JointKind, Link, Mimic, Model};
pub use shape::{CYLINDER_SIDES, Shape};
#[cfg(feature = "urdf")]
pub use urdf::UrdfOptions;
pub use world::ShapeId;
