//! The reference: every triangle of A against every triangle of B, no tree, no order, no budget.

use punctual::geom::triangles_intersect;
use punctual::glam::DVec3;
use punctual::{Aabb, Mesh, Pose};

/// The triangles of a mesh after a pose, in index order.
pub fn posed_triangles(mesh: &Mesh, pose: &Pose) -> Vec<[DVec3; 3]> {
    let posed = |index| {
        mesh.triangle(index)
            .map(|corner| pose.transform_point(corner))
    };
    (0..mesh.len()).map(posed).collect()
}

/// All intersecting pairs `[triangle of A, triangle of B]` in ascending order.
///
/// Triangles whose boxes are apart are skipped: those comparisons are exact.
pub fn all_pairs(a: &Mesh, b: &Mesh, b_in_a: &Pose) -> Vec<[u32; 2]> {
    let with_boxes = |triangles: Vec<[DVec3; 3]>| -> Vec<([DVec3; 3], Aabb)> {
        let boxed = |triangle| (triangle, Aabb::from_points(triangle));
        triangles.into_iter().map(boxed).collect()
    };
    let a_triangles = with_boxes((0..a.len()).map(|i| a.triangle(i)).collect());
    let b_triangles = with_boxes(posed_triangles(b, b_in_a));
    let mut pairs = Vec::new();
    for (i, (triangle_a, box_a)) in (0u32..).zip(&a_triangles) {
        for (j, (triangle_b, box_b)) in (0u32..).zip(&b_triangles) {
            if apart(box_a, box_b) {
                continue;
            }
            if triangles_intersect(triangle_a, triangle_b) {
                pairs.push([i, j]);
            }
        }
    }
    pairs
}

/// Written out here so that the reference does not lean on the library's own box test.
fn apart(a: &Aabb, b: &Aabb) -> bool {
    a.min.cmpgt(b.max).any() || b.min.cmpgt(a.max).any()
}

/// Where the two triangles of a pair meet, as far as rounding lets us say.
pub struct Place {
    /// The overlap of the two triangles' boxes.
    overlap: Aabb,
    /// Points of the intersection: where an edge of one clearly crosses the other.
    points: Vec<DVec3>,
}

/// The place of an intersecting pair, in A's frame.
pub fn place(a: &Mesh, b: &Mesh, b_in_a: &Pose, [i, j]: [u32; 2]) -> Place {
    let first = a.triangle(i as usize);
    let second = b
        .triangle(j as usize)
        .map(|corner| b_in_a.transform_point(corner));
    let (box_a, box_b) = (Aabb::from_points(first), Aabb::from_points(second));
    let mut points: Vec<DVec3> = edges(&first)
        .filter_map(|edge| crossing(edge, &second))
        .collect();
    points.extend(edges(&second).filter_map(|edge| crossing(edge, &first)));
    let overlap = box_a.intersection(&box_b);
    Place { overlap, points }
}

impl Place {
    /// Whether one box holds all of it; the points with room for their own rounding.
    pub fn is_in(&self, open: &Aabb) -> bool {
        let room = 1e-12 * (open.min.abs().max(open.max.abs()).max_element());
        let holds = |point: &DVec3| {
            point.cmpge(open.min - room).all() && point.cmple(open.max + room).all()
        };
        !apart(&self.overlap, open) && self.points.iter().all(holds)
    }
}

fn edges(triangle: &[DVec3; 3]) -> impl Iterator<Item = [DVec3; 2]> {
    (0..3).map(|i| [triangle[i], triangle[(i + 1) % 3]])
}

/// Only crossings well inside the triangle: those are accurate.
fn crossing([start, end]: [DVec3; 2], triangle: &[DVec3; 3]) -> Option<DVec3> {
    let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    let (from, to) = (
        normal.dot(start - triangle[0]),
        normal.dot(end - triangle[0]),
    );
    if from * to >= 0.0 || (from - to).abs() < 1e-3 * normal.length() * (end - start).length() {
        return None;
    }
    let point = start + from / (from - to) * (end - start);
    let inside = edges(triangle)
        .all(|[p, q]| (q - p).cross(point - p).dot(normal) > 1e-3 * normal.length_squared());
    inside.then_some(point)
}
