//! No ray passes between the triangles of a closed surface.

use crate::common::random::Random;
use punctual::clock::ManualClock;
use punctual::glam::DVec3;
use punctual::rays::RayMode;
use punctual::{Budget, Mesh, Query, Ray, Tree, Workspace, shapes};

/// Rays from points inside and outside to every corner and to the middle of every edge.
fn assert_watertight(mesh: Mesh, inside: DVec3, outside: DVec3) {
    let tree = Tree::new(mesh);
    let mesh = tree.mesh();
    let mut targets = Vec::new();
    for id in 0..mesh.len() {
        let [p, q, r] = mesh.triangle(id);
        targets.extend([p, (p + q) * 0.5, (q + r) * 0.5, q * 0.3 + r * 0.7]);
    }
    // From inside, every ray hits. From outside, those do whose line comes by the point inside, and those to a corner.
    let from_inside = targets
        .iter()
        .map(|&x| Ray::new(inside, x - inside).unwrap());
    let segments = (0..mesh.len()).map(|id| Ray::segment(outside, mesh.triangle(id)[0]).unwrap());
    let through = targets
        .iter()
        .map(|&x| Ray::segment(inside + (inside - x) * 4.0, x + (x - inside) * 4.0).unwrap());
    let rays: Vec<Ray> = from_inside.chain(segments).chain(through).collect();
    let mut workspace = Workspace::new();
    let (budget, clock) = (Budget::unlimited(), ManualClock::new());
    let _ = Query::rays(&tree, &rays).run(&mut workspace, budget.clock(&clock));
    let hits = workspace.first_hits().to_vec();
    let _ = Query::rays(&tree, &rays)
        .any()
        .run(&mut workspace, budget.clock(&clock));
    for (ray, (hit, any)) in rays.iter().zip(hits.iter().zip(workspace.first_hits())) {
        assert!(hit.is_some() && any.is_some(), "{ray:?}");
    }
}

#[test]
fn closed_surfaces_let_no_ray_out() {
    assert_watertight(
        shapes::icosphere(4),
        DVec3::new(0.1, -0.2, 0.05),
        DVec3::new(3.0, 1.0, 2.0),
    );
    assert_watertight(shapes::icosphere(3), DVec3::ZERO, DVec3::new(0.0, 0.0, 9.0));
    assert_watertight(
        shapes::cuboid([1.0, 0.5, 0.25], 6),
        DVec3::ZERO,
        DVec3::new(5.0, 0.5, 0.25),
    );
    assert_watertight(
        shapes::torus(1.0, 0.3, 40),
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(0.0, 0.0, 3.0),
    );
}

/// Along the axes through the corners of a cube, and within its faces.
#[test]
fn rays_within_faces_and_along_edges_hit() {
    let tree = Tree::new(shapes::cuboid([1.0; 3], 4));
    let mut workspace = Workspace::new();
    let mut random = Random::new(3);
    for axis in 0..3 {
        for step in 0..=8 {
            let place = [-1.0, -0.5, 0.0, 0.3, 1.0];
            let mut origin = [
                place[random.below(5)],
                place[random.below(5)],
                place[random.below(5)],
            ];
            origin[(axis + 1) % 3] = f64::from(step) / 4.0 - 1.0;
            origin[axis] = -4.0;
            let mut direction = [0.0; 3];
            direction[axis] = 1.0;
            let ray = Ray::new(origin, direction).unwrap();
            let cast = Query::ray(&tree, ray).mode(RayMode::All).run(
                &mut workspace,
                Budget::unlimited().clock(&ManualClock::new()),
            );
            assert_eq!(cast.value.hit.map(|hit| hit.t), Some(3.0), "{ray:?}");
            assert!(workspace.ray_hits().iter().any(|hit| hit.t <= 5.0) && cast.stats.found >= 2);
        }
    }
}
