use super::*;
use crate::math::random::Random;
use crate::mesh::{Mesh, shapes};
use crate::query::{Budget, DistanceQuery, ManualClock, Query, Verdict};
use glam::{DMat3, DQuat, DVec3};

fn vector(random: &mut Random) -> DVec3 {
    DVec3::from_array(core::array::from_fn(|_| random.between(-1.0, 1.0)))
}

fn rotation(random: &mut Random) -> DMat3 {
    let axis = vector(random).try_normalize().unwrap_or(DVec3::X);
    DMat3::from_quat(DQuat::from_axis_angle(axis, random.between(-3.0, 3.0)))
}

/// What a glance proves, which is no more than the distance that two triangles have, and nothing where some meet; with both
/// kinds of instructions, from both sides.
fn proven(a: &Tree, b: &Tree, pose: &Pose) -> f64 {
    let (clock, mut workspace) = (ManualClock::new(), Workspace::new());
    let met = Query::new(a, b, *pose).run_with(&mut workspace, None, Budget::unlimited(), &clock).verdict;
    let distance = DistanceQuery::new(a, b, *pose).run_with(&mut workspace, None, Budget::unlimited(), &clock);
    let check = |low: f64| {
        assert!(low <= distance.high, "{low:e} {distance:?}");
        assert!(low == 0.0 || met == Verdict::Separated, "{low:e} {met:?}");
        low
    };
    check(super::distance([b, a], &pose.inverse().unwrap(), &workspace));
    let low = check(super::distance([a, b], pose, &workspace));
    workspace.use_portable_kernels();
    check(super::distance([a, b], pose, &workspace));
    low
}

fn all_shapes() -> [Tree; 6] {
    let mesh = |corners: &[[f64; 3]]| {
        let triangles = (0..corners.len() as u32).step_by(3).map(|i| [i, i + 1, i + 2]);
        Mesh::from_f64(corners.to_vec(), triangles).unwrap()
    };
    let triangle = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    // A point and a segment.
    let degenerate =
        mesh(&[[0.3, 0.2, 0.1], [0.3, 0.2, 0.1], [0.3, 0.2, 0.1], [-1.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0]]);
    [
        shapes::icosphere(2),
        shapes::torus(1.0, 0.3, 24),
        shapes::cuboid([1.0; 3], 2),
        shapes::gear(9, 2),
        triangle,
        degenerate,
    ]
    .map(Tree::new)
}

#[test]
fn no_more_is_proven_than_is_true() {
    let (random, shapes) = (&mut Random::new(1), all_shapes());
    let (mut apart, mut tried) = (0, 0);
    for a in &shapes {
        for b in &shapes {
            for _ in 0..40 {
                let away = random.between(0.0, 4.0) * vector(random).try_normalize().unwrap_or(DVec3::X);
                let drift = [0.0, 1e-6, 3e-4][random.bits() as usize % 3];
                let skew = DMat3::from_cols_array(&core::array::from_fn(|_| drift * random.between(-1.0, 1.0)));
                let pose = Pose::new(rotation(random) * (DMat3::IDENTITY + skew), away).unwrap();
                tried += 1;
                apart += usize::from(proven(a, b, &pose) > 0.0);
            }
        }
    }
    assert!(apart > tried / 3, "{apart} of {tried}");
}

#[test]
fn touching_surfaces_are_not_apart() {
    let random = &mut Random::new(2);
    let cube = Tree::new(shapes::cuboid([1.0; 3], 2));
    for gap in [0.0, f64::MIN_POSITIVE, 1e-16, 1e-12, 1e-8, 1e-6, 1e-3] {
        for turn in [DMat3::IDENTITY, DMat3::from_rotation_y(core::f64::consts::FRAC_PI_4), rotation(random)] {
            // Face to face, edge to face, and corner to face: the corner that is the farthest back, in the middle of a face.
            let corner = -turn.transpose().x_axis.signum();
            let pose = Pose::new(turn, DVec3::new(1.0 + gap, 0.0, 0.0) - turn * corner).unwrap();
            let low = proven(&cube, &cube, &pose);
            assert!(low <= gap + 1e-15 && (gap < 1e-3 || low > 0.0), "{gap:e} {low:e}");
        }
    }
}

#[test]
fn what_is_far_out_large_or_small_is_seen_as_such() {
    let random = &mut Random::new(3);
    for scale in [1e-200, 1e-30, 1.0, 1e30, 1e200] {
        for offset in [0.0, 1e3, 1e7, 1e15] {
            let away = |v: [f32; 3]| (DVec3::from(v.map(f64::from)) + offset) * scale;
            let ball = shapes::icosphere(2);
            let vertices: alloc::vec::Vec<_> =
                (0..ball.vertex_count()).map(|i| ball.vertex(i).as_vec3().to_array()).collect();
            let moved = Mesh::from_f64(vertices.iter().map(|&v| away(v)), ball.triangles().iter().copied()).unwrap();
            let (a, b) = (Tree::new(moved.clone()), Tree::new(moved));
            for distance in [0.0, 1.0, 1.9, 2.1, 4.0, 1e6] {
                let shift = distance * scale * vector(random).try_normalize().unwrap_or(DVec3::X);
                let low = proven(&a, &b, &Pose::new(DMat3::IDENTITY, shift).unwrap());
                assert!(offset > 1e3 || distance < 4.0 || low > 0.0, "{scale:e} {offset:e} {distance}");
            }
        }
    }
}

#[test]
fn of_units_that_do_not_compare_and_of_no_triangles_nothing_is_known() {
    let ball = Tree::new(shapes::icosphere(1));
    let speck = Tree::new(Mesh::from_f64([[0.0; 3], [1e-30, 0.0, 0.0], [0.0, 1e-30, 0.0]], [[0, 1, 2]]).unwrap());
    let nothing = Tree::new(Mesh::new([] as [[f32; 3]; 0], []).unwrap());
    let pose = Pose::new(DMat3::IDENTITY, DVec3::new(5.0, 0.0, 0.0)).unwrap();
    for other in [&speck, &nothing] {
        assert_eq!(proven(&ball, other, &pose), 0.0);
    }
}
