//! Two triangles in, one answer out. Do they meet: a fast filter that is sometimes in doubt ([`batch`]), and signs that
//! never are ([`exact`]). How far apart are they: bounds of their distance ([`distance`]).

pub(crate) mod batch;
pub(crate) mod distance;
mod exact;
pub(crate) mod swept;

use glam::DVec3;

/// Whether two closed triangles share at least one point, exactly for the given coordinates.
///
/// Touching is intersecting; a degenerate triangle is the hull of its points. The answer does not change when the
/// triangles are swapped or their corners turned. Coordinates must be finite and at most 2^1003 in magnitude; with others
/// the answer means nothing.
///
/// ```
/// use punctual::glam::DVec3;
/// let a = [DVec3::ZERO, DVec3::X, DVec3::Y];
/// assert!(punctual::triangles_intersect(&a, &a.map(|p| p + DVec3::X)));
/// assert!(!punctual::triangles_intersect(&a, &a.map(|p| p + DVec3::Z * 5e-324)));
/// ```
pub fn triangles_intersect(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    exact::intersects(a, b)
}
