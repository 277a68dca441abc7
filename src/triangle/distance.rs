//! How far apart are two closed triangles? Bounds that hold whatever was found closest.
//!
//! Two triangles are as far apart as their closest features are: two edges (a corner is the end of one), or a corner and a
//! face. Computing these is ill-conditioned for slivers, near parallel edges and triangles that nearly touch. So the
//! features only *propose*: a pair of points, whose distance is an upper bound once the rounding of the points is added, and
//! a direction. What is proven from below comes from the direction alone: the gap between the projections of the two
//! triangles on it, less the rounding of the projections, over its length. No direction makes that false; a bad one only
//! makes it small.
//!
//! The best direction is known better than the difference of the closest points, which loses all its digits where the
//! triangles nearly touch: the normal of the face, or the difference less its components along the edges that the points
//! lie inside of. With it nine tenths of a gap of 1e-4 of the size of the triangles are proven in `f32`.
//!
//! - [`distances`]: eight pairs at a time in `f32`, from the triangles of two trees.
//! - [`Four`]: four pairs in `f64`, with the points, if the features that `f32` has found are the closest.
//! - [`closest`]: one pair in `f64`, with the points.
//!
//! All error bounds are derived in `docs/numerics.md`. All take constant time.

mod batch;
#[cfg(all(test, feature = "std"))]
#[path = "../../tests/common/exact_distance.rs"]
pub(crate) mod exact_distance;
mod exhaustive;
mod four;
mod pair;
#[cfg(all(test, feature = "std"))]
#[path = "../../tests/common/pairs.rs"]
mod pairs;
#[cfg(all(test, feature = "std"))]
mod tests;

pub(in crate::triangle) use batch::Pair;
pub(crate) use batch::{Chosen, Distances, distances};
pub(crate) use exhaustive::closest_or_meeting;
#[cfg(all(test, feature = "std"))]
pub(crate) use four::Face;
pub(crate) use four::{Features, Four};
pub(crate) use pair::{Closest, closest};
