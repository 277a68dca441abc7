//! What is drawn for points and segments with a radius: balls, capsules, and the specks of a cloud.

use punctual::glam::DVec3;
use punctual::{Mesh, Tree, shapes};

/// So many are drawn as balls, as specks, and all others as tetrahedra.
const FEW: usize = 50;
const MANY: usize = 20_000;

/// The surface that is drawn around each element of a tree, of radius 1; of a tree with another element than points and
/// segments none, it is drawn as it is.
pub fn around(tree: &Tree) -> Option<Mesh> {
    let mesh = tree.mesh();
    let is_thin = |i| matches!(mesh.triangle(i), [a, b, c] if a == b || b == c || c == a);
    let is_thick = tree.radius() > 0.0 && (0..mesh.len()).all(is_thin);
    if !mesh.is_cloud() && !is_thick {
        return None;
    }
    match mesh.len() {
        count if count <= FEW => Some(shapes::icosphere(3)),
        count if count <= MANY => Some(shapes::icosphere(0)),
        _ => {
            let s = 0.6f32;
            let corners = [[s, s, s], [s, -s, -s], [-s, s, -s], [-s, -s, s]];
            Mesh::new(corners, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]).ok()
        }
    }
}

/// The vertices around the elements of a tree, each at the end of the element that is nearer to it.
pub fn vertices(tree: &Tree, around: &Mesh, radius: f64) -> Vec<DVec3> {
    let unit: Vec<DVec3> = (0..around.vertex_count())
        .map(|i| around.vertex(i))
        .collect();
    let element = |i| {
        let [a, b, c] = tree.mesh().triangle(i);
        let end = if b == a { c } else { b };
        let at = move |&v: &DVec3| (if v.dot(end - a) > 0.0 { end } else { a }) + radius * v;
        unit.iter().map(at)
    };
    (0..tree.mesh().len()).flat_map(element).collect()
}

/// The triangles around some elements.
pub fn triangles(around: &Mesh, ids: impl IntoIterator<Item = u32>) -> Vec<[u32; 3]> {
    let count = around.vertex_count() as u32;
    let moved = |id: u32| {
        around
            .triangles()
            .iter()
            .map(move |t| t.map(|i| id * count + i))
    };
    ids.into_iter().flat_map(moved).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_segments_are_drawn_at_their_radius() {
        let points: Vec<[f32; 3]> = (0..20_500).map(|i| [i as f32, 0.0, 0.0]).collect();
        let cloud = |count: usize| Tree::from_points(points[..count].iter().copied()).unwrap();
        let capsule = Tree::capsule(0.25, 2.0).unwrap();
        for tree in [
            Tree::ball(0.5).unwrap(),
            capsule,
            cloud(3),
            cloud(99),
            cloud(20_500),
        ] {
            let around = around(&tree).unwrap();
            let (count, len) = (around.vertex_count(), tree.mesh().len());
            let drawn = vertices(&tree, &around, 0.25);
            assert_eq!(drawn.len(), len * count);
            for (i, v) in drawn.iter().enumerate() {
                let [a, b, c] = tree.mesh().triangle(i / count);
                let near = [a, b, c]
                    .map(|p| p.distance(*v))
                    .into_iter()
                    .fold(f64::MAX, f64::min);
                assert!((0.2..0.2601).contains(&near), "{near}");
            }
            let last = triangles(&around, [len as u32 - 1]);
            assert_eq!(last.len(), around.len());
            let used = last.as_flattened().iter().map(|&i| i as usize / count);
            assert!({ used }.all(|element| element == len - 1));
        }
        assert!(around(&Tree::cuboid([1.0; 3]).unwrap()).is_none());
        assert!(around(&Tree::rounded_cuboid([1.0; 3], 0.1).unwrap()).is_none());
        let long = vertices(
            &Tree::capsule(0.25, 2.0).unwrap(),
            &shapes::icosphere(3),
            0.25,
        );
        let top = long.iter().map(|v| v.z).fold(0.0, f64::max);
        assert!((top - 1.25).abs() < 1e-6);
    }
}
