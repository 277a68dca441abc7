//! Contacts: pairs of triangles that meet or are close, with their points and normals.
//!
//! A [`Contact`] describes one pair of triangles. [`list`](super::list) keeps the contacts of a
//! query, nearest first. [`manifold`](crate::query::manifolds::manifold) is what a solver needs of
//! them.

use glam::DVec3;
use punctual_geom::triangle::distance::Closest;

/// A triangle of A and one of B that intersect or are close. All vectors are in A's frame and
/// rounded. Lengths are in the length unit of the meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Contact {
    /// Triangle of A, triangle of B: ids of the input meshes.
    pub triangles: [u32; 2],
    /// Their closest points, of A and of B. For triangles that intersect, both are the middle of
    /// the segment. Of trees with a [radius](crate::Tree::with_radius), each is moved to the
    /// thickened surface, along the normal towards the other.
    pub points: [DVec3; 2],
    /// Unit vector from B to A: moving A along it separates A from B.
    ///
    /// For separated triangles it is the direction of least distance, if `f64` can resolve it. For
    /// triangles that intersect it is the direction of `n - m`, where `m` is the unit normal of A's
    /// triangle and `n` that of B's, each by the right-hand rule, so that it points out of meshes
    /// whose normals do. If `m` and `n` are equal, it is `n`. A triangle without area has no
    /// normal; if neither triangle has one, the direction is the x axis.
    pub normal: DVec3,
    /// Proven upper bound of the distance. The true distance is smaller by at most 4e-14 times the
    /// diagonal of the box around both triangles, whatever their shape. 0 only if they intersect.
    /// Of trees with a [radius](crate::Tree::with_radius), that of the triangles minus the radii:
    /// negative where the thickened surfaces are sunk into each other.
    pub distance: f64,
    /// The segment in which the triangles intersect:
    /// [`triangle_segment`](crate::geom::triangle_segment), directed along the cross product of the
    /// normals of A's triangle and of B's. So if both surfaces are closed, each segment begins
    /// where another ends. `None` if the triangles are separated.
    pub segment: Option<[DVec3; 2]>,
}

impl Contact {
    /// The contact of triangles with these corners that intersect in a segment.
    pub(crate) fn touching(
        triangles: [u32; 2],
        corners: [&[DVec3; 3]; 2],
        segment: [DVec3; 2],
    ) -> Self {
        let normals @ [of_a, of_b] = corners.map(face_normal);
        let (segment, _) = directed(segment, normals);
        Self {
            triangles,
            points: [0.5 * segment[0] + 0.5 * segment[1]; 2],
            normal: separating_plane(of_a, of_b),
            distance: 0.0,
            segment: Some(segment),
        }
    }

    /// The contact of separated triangles with these corners. If `found` has no direction, the
    /// points or the triangles' normals give the contact normal.
    pub(crate) fn apart(triangles: [u32; 2], [a, b]: [&[DVec3; 3]; 2], found: &Closest) -> Self {
        let Closest {
            points,
            direction,
            high,
            ..
        } = *found;
        let between = || {
            unit(points[0] - points[1])
                .unwrap_or_else(|| separating_plane(face_normal(a), face_normal(b)))
        };
        let normal = if direction == DVec3::ZERO {
            between()
        } else {
            direction
        };
        Self {
            triangles,
            points,
            normal,
            distance: high,
            segment: None,
        }
    }

    /// The contact of surfaces with these radii from that of their cores.
    pub(crate) fn thickened(mut self, [of_a, of_b]: [f64; 2]) -> Self {
        if of_a + of_b > 0.0 {
            self.points[0] -= self.normal * of_a;
            self.points[1] += self.normal * of_b;
            self.distance -= of_a + of_b;
        }
        self
    }
}

/// Contact normal of two faces that intersect, from their normals `a` and `b`.
fn separating_plane(a: Option<DVec3>, b: Option<DVec3>) -> DVec3 {
    let difference = b.unwrap_or(DVec3::ZERO) - a.unwrap_or(DVec3::ZERO);
    unit(difference).or(b).unwrap_or(DVec3::X)
}

/// The unit normal of a triangle. `None` if `f64` cannot resolve its area.
pub(crate) fn face_normal([p, q, r]: &[DVec3; 3]) -> Option<DVec3> {
    let (x, y) = (*q - *p, *r - *p);
    common_unit(x.cross(y)).or_else(|| unit(unit(x)?.cross(unit(y)?)))
}

/// A segment directed along the cross product of two unit normals, and this product.
pub(crate) fn directed(
    [start, end]: [DVec3; 2],
    normals: [Option<DVec3>; 2],
) -> ([DVec3; 2], DVec3) {
    let [m, n] = normals.map(Option::unwrap_or_default);
    let across = m.cross(n);
    if (end - start).dot(across) < 0.0 {
        ([end, start], across)
    } else {
        ([start, end], across)
    }
}

/// Normalizes a vector of any finite length. `None` if it is zero.
fn unit(v: DVec3) -> Option<DVec3> {
    common_unit(v).or_else(|| {
        let largest = v.abs().max_element();
        (largest > 0.0).then(|| (v / largest).normalize())
    })
}

/// Normalizes a vector whose squared length neither overflows nor loses digits. `None` for other
/// lengths.
fn common_unit(v: DVec3) -> Option<DVec3> {
    let square = v.length_squared();
    (1e-200..=1e200).contains(&square).then(|| v.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_of_every_length_have_a_direction() {
        for length in [5e-324, 1e-300, 1.0, 1e300] {
            assert_eq!(unit(DVec3::new(0.0, -length, 0.0)), Some(DVec3::NEG_Y));
            let two = unit(DVec3::new(length, 0.0, length)).unwrap();
            assert!(
                (two - DVec3::new(0.5, 0.0, 0.5) * 2.0_f64.sqrt()).length() < 1e-15,
                "{two}"
            );
        }
        assert_eq!(unit(DVec3::ZERO), None);
    }

    #[test]
    fn faces_part_along_the_difference_of_their_normals() {
        let [up, down] = [DVec3::Z, DVec3::NEG_Z].map(Some);
        assert_eq!(separating_plane(down, up), DVec3::Z);
        assert_eq!(separating_plane(up, down), DVec3::NEG_Z);
        assert_eq!(separating_plane(up, up), DVec3::Z);
        assert_eq!(separating_plane(None, down), DVec3::NEG_Z);
        assert_eq!(separating_plane(up, None), DVec3::NEG_Z);
        assert_eq!(separating_plane(None, None), DVec3::X);
        assert_eq!(
            face_normal(&[DVec3::ZERO, DVec3::X * 1e-200, DVec3::Y * 1e200]),
            Some(DVec3::Z)
        );
        assert_eq!(face_normal(&[DVec3::ZERO, DVec3::X, DVec3::X * 3.0]), None);
    }
}
