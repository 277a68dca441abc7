//! Predicates of two triangles. Intersection: a fast filter that leaves pairs in doubt ([`batch`]),
//! the same filter in `f64` ([`filter64`]), and exact signs ([`exact`]). Distance: proven bounds
//! ([`distance`]).

pub mod batch;
pub mod curve;
pub mod distance;
mod exact;
pub mod filter64;
pub mod ray;
pub mod shared;
pub mod swept;

pub use exact::crossing;

use glam::DVec3;

/// True if two closed triangles share at least one point, exactly for the given coordinates.
///
/// Touching counts as intersecting. A degenerate triangle is the hull of its points. The answer
/// does not depend on the order of the triangles or of their corners. Coordinates must be finite
/// and at most 2^1003 in magnitude; otherwise the answer is meaningless.
///
/// ```
/// use punctual::glam::DVec3;
/// let a = [DVec3::ZERO, DVec3::X, DVec3::Y];
/// assert!(punctual::geom::triangles_intersect(&a, &a.map(|p| p + DVec3::X)));
/// assert!(!punctual::geom::triangles_intersect(&a, &a.map(|p| p + DVec3::Z * 5e-324)));
/// ```
pub fn triangles_intersect(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    exact::intersects(a, b)
}

/// True if two triangles of one surface meet beyond the corners that they share: if all three are
/// shared, or if a common point is outside the hull of the shared ones. Exact for the given
/// coordinates; corners are shared if they are equal.
///
/// So triangles that share nothing meet as by [`triangles_intersect`]; triangles that share an
/// edge, if they are coplanar and on the same side of it. Coordinates as there.
///
/// ```
/// use punctual::glam::DVec3;
/// use punctual::geom::triangles_intersect_beyond_shared as beyond;
/// let a = [DVec3::ZERO, DVec3::X, DVec3::Y];
/// assert!(!beyond(&a, &[DVec3::X, DVec3::Y, DVec3::ONE]));
/// assert!(beyond(&a, &[DVec3::X, DVec3::Y, DVec3::new(0.1, 0.1, 0.0)]));
/// ```
pub fn triangles_intersect_beyond_shared(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    exact::shared::intersects_beyond_shared(a, b)
}

/// The side of the plane of a triangle on which a point lies, exactly: 1 where the normal by the
/// right-hand rule points, 0 in the plane, and where the triangle has no area. Coordinates as for
/// [`triangles_intersect`].
pub fn side_of_plane(t: &[DVec3; 3], point: DVec3) -> i8 {
    exact::side_of_plane(t, point)
}

/// The segment in which two closed triangles meet; `None` if [`triangles_intersect`] is false.
///
/// Each end is close to *both* triangles, for all shapes: within 1e-12 times the largest
/// coordinate, or within 2^-1073 if all coordinates are denormal. This holds because the corner or
/// edge on which an end lies is decided exactly.
///
/// Triangles that touch in a point have a segment of length 0. For coplanar triangles it is the
/// longest segment contained in both. The order of the ends has no meaning.
///
/// Coordinates must be finite and at most 2^1003 in magnitude.
///
/// ```
/// use punctual::glam::DVec3;
/// let floor = [DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 3.0];
/// let wall = [DVec3::new(1.0, 1.0, -1.0), DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 1.0)];
/// let segment = punctual::geom::triangle_segment(&floor, &wall);
/// assert_eq!(segment, Some([DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 0.0, 0.0)]));
/// ```
pub fn triangle_segment(a: &[DVec3; 3], b: &[DVec3; 3]) -> Option<[DVec3; 2]> {
    exact::segment(a, b)
}
