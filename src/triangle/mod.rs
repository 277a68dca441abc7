//! Two triangles in, one answer out. Do they meet: a fast filter that is sometimes in doubt ([`batch`]), the same in `f64`
//! ([`again`]), and signs that never are ([`exact`]). How far apart are they: bounds of their distance ([`distance`]).

pub(crate) mod again;
pub(crate) mod batch;
pub(crate) mod curve;
pub(crate) mod distance;
mod exact;
pub(crate) mod ray;
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

/// The segment in which two closed triangles meet; `None` if [`triangles_intersect`] is false.
///
/// Both ends are within 1e-12 times the largest coordinate of *both* triangles (or within 2^-1073, where all coordinates are
/// denormal), whatever their shape: which corner or edge an end lies on is decided exactly. Triangles that touch in a point
/// have a segment of length 0. Of triangles in one plane it is the longest in both. The order of the ends means nothing.
///
/// Coordinates must be finite and at most 2^1003 in magnitude.
///
/// ```
/// use punctual::glam::DVec3;
/// let floor = [DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 3.0];
/// let wall = [DVec3::new(1.0, 1.0, -1.0), DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 1.0)];
/// let segment = punctual::triangle_segment(&floor, &wall);
/// assert_eq!(segment, Some([DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 0.0, 0.0)]));
/// ```
pub fn triangle_segment(a: &[DVec3; 3], b: &[DVec3; 3]) -> Option<[DVec3; 2]> {
    exact::segment(a, b)
}
