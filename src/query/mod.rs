//! The budgeted query: it takes two trees, a question and a budget, and returns an [`Answer`].
//!
//! [`traversal`] has the one loop, the stop rule and the guarantee. The other modules:
//!
//! | what | where |
//! |---|---|
//! | every question: [`Query`] | [`question`] |
//! | intersection, any or all | [`intersection`]; [`meeting`], [`leaf`], [`trace`], [`follow`] |
//! | distance | [`distance`]; [`nearest`], [`closest_pairs`], [`gaps`], [`interval`], [`search`] |
//! | contacts, asked as one of these two | [`contacts`] |
//! | contact manifolds: contacts, reduced; then the overlaps | [`manifolds`]; [`overlaps`] |
//! | time of impact | [`motion`] |
//! | ray casts | [`ray`] |
//! | points and solids; one solid in another | [`point`]; [`contained`] |
//! | the children that replace a node pair, for every question | [`expand`]; [`boxes`], [`overlap`], [`edge_axes`], [`relative_pose`] |
//! | tests without a query | [`root_test`], [`separating_plane`] |
//! | the frontier | [`queue`], by [`order`]; [`triangle_pairs`] |
//! | the choices of a run, and its end | [`options`], [`strategy`]; [`budget`], [`system`], [`deadline`] |
//! | all that changes during a query; what is kept for the next | [`workspace`]; [`memory`], [`clearance`] |
//! | bounds on what a stopped query may have missed | [`certificate`] |
//! | the cost of a query | [`estimate`], [`probe`], [`measure`] |

mod boxes;
mod budget;
mod certificate;
mod clearance;
mod close_boxes;
mod closest_pairs;
mod contacts;
mod contained;
mod corners;
mod deadline;
mod distance;
mod edge_axes;
mod estimate;
mod expand;
mod flushing;
mod follow;
mod gaps;
mod halves;
mod intersection;
mod interval;
mod known;
mod leaf;
mod manifolds;
mod measure;
mod meeting;
mod memory;
mod motion;
mod nearest;
#[cfg(feature = "internals")]
pub(crate) mod opened;
mod options;
mod order;
mod outcome;
mod overlap;
mod overlaps;
mod point;
mod probe;
mod question;
mod queue;
mod ranked;
mod ray;
mod relative_pose;
pub mod root_test;
mod search;
mod separating_plane;
mod strategy;
pub(crate) mod system;
mod told;
mod trace;
mod traversal;
#[cfg(all(test, feature = "std"))]
mod triangle_bounds_tests;
mod triangle_pairs;
mod workspace;

pub use budget::{Budget, Clock, ManualClock};
pub use certificate::Certificate;
pub use clearance::displacement;
pub use contacts::{ContactBounds, Contacts};
pub use contained::Operand;
pub use deadline::Deadline;
pub use distance::{Bounds, Distance, Nearest};
pub use estimate::{DistanceEstimate, Estimate, Prediction};
pub use flushing::matters as flushing_matters;
pub use intersection::Intersection;
pub use manifolds::{ManifoldBounds, Manifolds};
pub use memory::PairMemory;
pub use motion::{Impact, TimeOfImpact};
pub use options::{Mode, OptionError};
pub use order::Order;
pub use outcome::{Answer, Stats, StopReason, Verdict};
pub use overlaps::REGION_LIMIT;
pub use point::{AtPoint, AtPoints, PointBounds, PointError, SignedDistance};
pub use question::{Ask, Query, QueryWithMemory, Question, Remaining, Remembers};
pub use ray::{RayBounds, RayCast, RayHit, RayMode, Rays};
pub use separating_plane::SeparatingPlane;
pub use system::{ClockedBudget, SYSTEM};
pub use workspace::{ResumeError, Workspace};
