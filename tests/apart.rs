//! Bounds found without a query are never above the true distance: the [`root_test`], and planes
//! ([`SeparatingPlane`]).

mod common;

use common::random::Random;
use punctual::clock::ManualClock;
use punctual::engine::{SeparatingPlane, root_test};
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, BuildOptions, Mesh, Pose, Query, Tree, Verdict, Workspace, shapes};

/// A lower bound of the distance of two meshes, from one of the two tests.
type Bound = fn([&Tree; 2], &Pose, &Workspace) -> f64;

const BOUNDS: [Bound; 2] = [root_test::distance, |trees, pose, workspace| {
    let (low, tried) = SeparatingPlane::default().distance(trees, pose, 16, workspace);
    assert!(tried <= 16);
    low
}];

fn tree(mesh: Mesh) -> Tree {
    Tree::with_options(mesh, &BuildOptions::default().extremes(true))
}

/// A unit vector.
fn direction(random: &mut Random) -> DVec3 {
    random.vector().try_normalize().unwrap_or(DVec3::X)
}

/// Returns the bound, after assertions: it is at most the distance of the meshes, and 0 if they
/// intersect, also with A and B exchanged; the portable kernels give the same bits.
fn proven(bound: Bound, a: &Tree, b: &Tree, pose: &Pose) -> f64 {
    let (clock, mut workspace) = (ManualClock::new(), Workspace::new());
    let met = Query::intersection(a, b, *pose)
        .run(&mut workspace, Budget::unlimited().clock(&clock))
        .value;
    let distance =
        Query::distance(a, b, *pose).run(&mut workspace, Budget::unlimited().clock(&clock));
    let check = |low: f64| {
        assert!(low <= distance.value.high, "{low:e} {distance:?}");
        assert!(low == 0.0 || met == Verdict::Separated, "{low:e} {met:?}");
        low
    };
    check(bound([b, a], &pose.inverse().unwrap(), &workspace));
    let low = check(bound([a, b], pose, &workspace));
    workspace.use_portable_kernels();
    assert_eq!(low, bound([a, b], pose, &workspace));
    low
}

fn all_shapes() -> [Tree; 6] {
    let mesh = |corners: &[[f64; 3]]| {
        let triangles = (0..corners.len() as u32)
            .step_by(3)
            .map(|i| [i, i + 1, i + 2]);
        Mesh::from_f64(corners.to_vec(), triangles).unwrap()
    };
    let triangle = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    // A point and a segment.
    let degenerate = mesh(&[
        [0.3, 0.2, 0.1],
        [0.3, 0.2, 0.1],
        [0.3, 0.2, 0.1],
        [-1.0, 0.0, 0.0],
        [0.0; 3],
        [1.0, 0.0, 0.0],
    ]);
    [
        shapes::icosphere(2),
        shapes::torus(1.0, 0.3, 24),
        shapes::cuboid([1.0; 3], 2),
        shapes::gear(9, 2),
        triangle,
        degenerate,
    ]
    .map(tree)
}

#[test]
fn no_more_is_proven_than_is_true() {
    let (random, shapes) = (&mut Random::new(1), all_shapes());
    let (mut apart, mut tried) = ([0; 2], 0);
    for a in &shapes {
        for b in &shapes {
            for _ in 0..40 {
                let away = 4.0 * random.unit() * direction(random);
                let drift = [0.0, 1e-6, 3e-4][random.below(3)];
                let rotation_error =
                    DMat3::from_cols_array(&core::array::from_fn(|_| drift * random.signed()));
                let pose = Pose::new(random.rotation() * (DMat3::IDENTITY + rotation_error), away)
                    .unwrap();
                tried += 1;
                for (bound, apart) in BOUNDS.into_iter().zip(&mut apart) {
                    *apart += usize::from(proven(bound, a, b, &pose) > 0.0);
                }
            }
        }
    }
    assert!(
        apart.into_iter().all(|apart| apart > tried / 3),
        "{apart:?} of {tried}"
    );
}

#[test]
fn touching_surfaces_are_not_apart() {
    let random = &mut Random::new(2);
    let cube = tree(shapes::cuboid([1.0; 3], 2));
    for gap in [0.0, f64::MIN_POSITIVE, 1e-16, 1e-12, 1e-8, 1e-6, 1e-3] {
        for turn in [
            DMat3::IDENTITY,
            DMat3::from_rotation_y(core::f64::consts::FRAC_PI_4),
            random.rotation(),
        ] {
            // Face to face, edge to face, and corner to face: the rearmost corner touches the
            // middle of a face.
            let corner = -turn.transpose().x_axis.signum();
            let pose = Pose::new(turn, DVec3::new(1.0 + gap, 0.0, 0.0) - turn * corner).unwrap();
            for bound in BOUNDS {
                let low = proven(bound, &cube, &cube, &pose);
                assert!(low <= gap + 1e-15 && (gap < 1e-3 || low > 0.0), "{gap:e}");
            }
        }
    }
}

#[test]
fn separation_is_told_at_any_size_and_distance_from_the_origin() {
    let random = &mut Random::new(3);
    for scale in [1e-200, 1e-30, 1.0, 1e30, 1e200] {
        for offset in [0.0, 1e3, 1e7, 1e15] {
            let away = |v: [f32; 3]| (DVec3::from(v.map(f64::from)) + offset) * scale;
            let ball = shapes::icosphere(2);
            let vertices: Vec<_> = (0..ball.vertex_count())
                .map(|i| ball.vertex(i).as_vec3().to_array())
                .collect();
            let moved = Mesh::from_f64(
                vertices.iter().map(|&v| away(v)),
                ball.triangles().iter().copied(),
            )
            .unwrap();
            let (a, b) = (tree(moved.clone()), tree(moved));
            for distance in [0.0, 1.0, 1.9, 2.1, 4.0, 1e6] {
                let shift = distance * scale * direction(random);
                for bound in BOUNDS {
                    let low = proven(bound, &a, &b, &Pose::new(DMat3::IDENTITY, shift).unwrap());
                    assert!(offset > 1e3 || distance < 4.0 || low > 0.0, "{scale:e}");
                }
            }
        }
    }
}

#[test]
fn incomparable_units_and_empty_meshes_prove_nothing() {
    let ball = tree(shapes::icosphere(1));
    let speck = tree(
        Mesh::from_f64(
            [[0.0; 3], [1e-30, 0.0, 0.0], [0.0, 1e-30, 0.0]],
            [[0, 1, 2]],
        )
        .unwrap(),
    );
    let nothing = tree(Mesh::new([] as [[f32; 3]; 0], []).unwrap());
    let pose = Pose::new(DMat3::IDENTITY, DVec3::new(5.0, 0.0, 0.0)).unwrap();
    for (bound, other) in BOUNDS
        .into_iter()
        .flat_map(|bound| [(bound, &speck), (bound, &nothing)])
    {
        assert_eq!(proven(bound, &ball, other, &pose), 0.0);
    }
}

/// Convex bodies at any angle and this far apart, along their shortest connection.
#[test]
fn a_plane_parts_what_is_convex_and_all_but_touches() {
    let random = &mut Random::new(4);
    let shapes = [
        shapes::icosphere(3),
        shapes::cuboid([1.0, 0.4, 0.7], 3),
        shapes::icosphere(0),
    ]
    .map(tree);
    let (clock, mut workspace) = (ManualClock::new(), Workspace::new());
    for gap in [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
        let (mut parted, mut tried) = (0, 0);
        for (a, b) in shapes
            .iter()
            .flat_map(|a| shapes.iter().map(move |b| (a, b)))
        {
            for _ in 0..20 {
                let (turn, away) = (random.rotation(), 4.0 * direction(random));
                let pose = Pose::new(turn, away).unwrap();
                let distance = Query::distance(a, b, pose)
                    .run(&mut workspace, Budget::unlimited().clock(&clock));
                let [p, q] = distance.value.nearest.unwrap().points;
                let pose =
                    Pose::new(turn, away + (p - q) * (1.0 - gap / distance.value.high)).unwrap();
                tried += 1;
                parted += usize::from(proven(BOUNDS[1], a, b, &pose) > 0.0);
            }
        }
        // Where rounding exceeds the gap, a query has to decide.
        let all = if gap < 1e-4 { 0 } else { tried - tried / 20 };
        assert!(parted >= all, "{gap:e}: {parted} of {tried}");
    }
}

/// No plane separates a ball from a ring around it, although they are separated. A plane of a mesh
/// whose corners have moved proves nothing either.
#[test]
fn no_plane_is_found_between_surfaces_that_none_separates() {
    let (mut ball, ring) = (
        tree(shapes::icosphere(2)),
        tree(shapes::torus(2.0, 0.3, 24)),
    );
    let (pose, workspace) = (Pose::IDENTITY, &Workspace::new());
    let mut separating_plane = SeparatingPlane::default();
    for _ in 0..100 {
        assert_eq!(
            separating_plane
                .distance([&ball, &ring], &pose, 16, workspace)
                .0,
            0.0
        );
    }
    let aside = Pose::new(DMat3::IDENTITY, DVec3::new(4.0, 0.0, 0.0)).unwrap();
    assert!(
        separating_plane
            .distance([&ball, &ring], &aside, 8, workspace)
            .0
            > 0.0
    );
    let wider: Vec<_> = (0..ball.mesh().vertex_count())
        .map(|i| (ball.mesh().vertex(i) * 2.0).as_vec3().to_array())
        .collect();
    ball.refit(&wider).unwrap();
    assert_eq!(
        separating_plane.distance([&ball, &ring], &aside, 8, workspace),
        (0.0, 0)
    );
}
