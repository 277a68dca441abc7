//! Bounds of the distance between two closed triangles. They hold no matter which features were
//! taken for the closest.
//!
//! The distance of two triangles is the distance of their closest features: two edges (a corner is
//! the end of one), or a corner and a face. Computing these is ill-conditioned for slivers, nearly
//! parallel edges and triangles that nearly touch. So the features only *propose* a pair of points
//! and a direction.
//! - Upper bound: the distance of the points plus their rounding.
//! - Lower bound: the gap between the projections of the two triangles on the direction, minus the
//!   rounding of the projections, divided by the length of the direction. It holds for every
//!   direction; a bad direction only makes it small.
//!
//! The difference of the closest points is a poor direction: it loses all its digits where the
//! triangles nearly touch. For a face, its normal is better. For edges, it is better to subtract
//! from the difference its components along the edges that have their point inside. With these
//! directions, nine tenths of a gap of 1e-4 times the size of the triangles are proven in `f32`.
//!
//! - [`distances`]: eight pairs at a time in `f32`, from the triangles of two trees.
//! - [`Around`]: a point and eight triangles in `f32`, both bounds.
//! - [`closest`]: one pair in `f64`, with the points.
//! - [`closest_to_point`]: a triangle and a point in `f64`.
//!
//! `docs/numerics.md` derives all error bounds. Every routine takes constant time.

mod around;
mod batch;
mod exhaustive;
mod pair;
mod point;

pub use around::Around;
pub use batch::Pair;
pub use batch::{Distances, Places, distances};
pub use exhaustive::closest_or_meeting;
use pair::clamped;
pub use pair::{Closest, closest};
pub use point::closest_to_point;
