//! One solid in another: verdicts, distances and motions, against brute force.

use crate::common::random::Random;
use crate::common::reference::all_pairs;
use crate::meshes::{union, with_triangles};
use crate::truth::winding;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::intersection::Operand;
use punctual::tree::Solid;
use punctual::{
    Budget, BuildOptions, Mesh, Motion, PairMemory, Pose, Query, StopReason, Tree, Verdict,
    Workspace, shapes,
};

fn solid(mesh: &Mesh) -> Tree {
    Tree::with_options(mesh.clone(), &BuildOptions::default().solid(Solid::Keep))
}

fn posed(mesh: &Mesh, pose: &Pose) -> Mesh {
    let vertices = (0..mesh.vertex_count()).map(|i| pose.transform_point(mesh.vertex(i)));
    Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap()
}

/// Which bodies have a vertex inside the other, by exact rays.
fn inner(a: &Mesh, b: &Mesh, pose: &Pose, random: &mut Random) -> [bool; 2] {
    let placed = posed(b, pose);
    let mut holds = |outer: &Mesh, inner: &Mesh| {
        (0..inner.vertex_count())
            .step_by(5)
            .any(|i| winding(outer, inner.vertex(i), random) >= Some(1))
    };
    [holds(&placed, a), holds(a, &placed)]
}

fn bodies() -> Vec<Mesh> {
    let (ball, cube) = (shapes::icosphere(1), shapes::cuboid(Vec3::ONE, 1));
    vec![
        ball.clone(),
        cube.clone(),
        shapes::torus(1.0, 0.4, 12),
        // A shell, and a ball in it.
        union(&[
            (&ball, 1.0, DVec3::ZERO),
            (&ball, -0.8, DVec3::ZERO),
            (&ball, 0.1, DVec3::ZERO),
        ]),
        // Two that are apart.
        union(&[(&ball, 0.3, DVec3::X), (&cube, 0.2, -DVec3::X)]),
    ]
}

fn pose(random: &mut Random, reach: f64, offset: f64) -> Pose {
    let place = random.vector() * reach + offset;
    Pose::new(random.rotation(), place).unwrap()
}

#[test]
fn a_body_inside_another_is_contained_and_no_other() {
    let mut random = Random::new(11);
    let (mut workspace, mut counts) = (Workspace::new(), [0; 4]);
    let meshes = bodies();
    for (i, a) in meshes.iter().enumerate() {
        for (j, b) in meshes.iter().enumerate() {
            for k in 0..6 {
                let scale = [0.2, 0.05, 1.0, 4.0][k % 4];
                let offset = [0.0, 1e6][k % 2];
                let b = union(&[(b, scale, DVec3::ZERO)]);
                let a = union(&[(a, 1.0, DVec3::splat(offset))]);
                let pose = pose(&mut random, 1.3, offset);
                let meet = !all_pairs(&a, &b, &pose).is_empty();
                let truth = inner(&a, &b, &pose, &mut random);
                let trees = [solid(&a), solid(&b)];
                let query = Query::intersection(&trees[0], &trees[1], pose);
                let answer = query.run(&mut workspace, Budget::unlimited());
                match answer.value {
                    Verdict::Intersecting { .. } => assert!(meet),
                    Verdict::Contained { inner } => {
                        assert!(!meet && answer.value.meets());
                        assert!(truth[usize::from(inner == Operand::B)], "{i} {j} {k}");
                    }
                    Verdict::Separated => assert!(!meet && truth == [false; 2], "{i} {j} {k}"),
                    verdict => panic!("{verdict}"),
                }
                counts[usize::from(meet) + 2 * usize::from(truth != [false; 2])] += 1;
                // The surfaces alone do not know of it.
                let surfaces = query.surfaces().run(&mut workspace, Budget::unlimited());
                assert_eq!(surfaces.value.meets(), meet);
            }
        }
    }
    // Surfaces that meet where no vertex is inside are rare.
    assert!([0, 2, 3].iter().all(|&i| counts[i] >= 15), "{counts:?}");
}

/// No manifold can tell of a body that meets no surface, so the answer does, at every stop.
#[test]
fn a_query_for_manifolds_names_the_body_inside() {
    let [room, ball] = [
        solid(&shapes::cuboid(Vec3::splat(4.0), 2)),
        solid(&shapes::icosphere(2)),
    ];
    let (mut whole, mut parts) = (Workspace::new(), Workspace::new());
    for (x, within) in [(0.0, true), (2.99, true), (3.5, false), (5.005, false)] {
        let pose = Pose::new(DMat3::IDENTITY, DVec3::X * x).unwrap();
        for (a, b, pose, inner) in [
            (&room, &ball, pose, Operand::B),
            (&ball, &room, pose.inverse().unwrap(), Operand::A),
        ] {
            let query = Query::manifolds(a, b, pose).skin(0.02);
            let answer = query.run(&mut whole, Budget::unlimited());
            let truth = within.then_some(inner);
            assert_eq!((answer.value.within, answer.value.meets), (truth, x == 3.5));
            assert_eq!(whole.manifolds().is_empty(), within);
            let mut part = query.run(&mut parts, Budget::work(1));
            while !part.stop.is_final() {
                assert!(part.value.within.is_none() || part.value.within == truth);
                part = query.resume(&mut parts, Budget::work(1)).unwrap();
            }
            assert_eq!(part.value, answer.value);
            let surfaces = query.surfaces().run(&mut parts, Budget::unlimited());
            assert_eq!(surfaces.value.within, None);
        }
    }
}

#[test]
fn a_pose_that_is_not_quite_a_rotation_is_used_as_given() {
    let mut random = Random::new(12);
    let mut workspace = Workspace::new();
    let (shell, ball) = (shapes::icosphere(2), shapes::icosphere(1));
    let mut contained = 0;
    for _ in 0..12 {
        // A ball that fills the shell but for less than the pose is off.
        let outer = union(&[(&shell, 1.0, DVec3::splat(3.0))]);
        let inner = union(&[(&shell, 0.9995, DVec3::ZERO)]);
        let drift = DMat3::from_diagonal(DVec3::ONE + random.vector() * 4e-4);
        let pose = Pose::new(drift, DVec3::splat(3.0)).unwrap();
        for [a, b] in [[&outer, &inner], [&ball, &outer]] {
            let (a, b) = (solid(a), solid(b));
            let answer = Query::intersection(&a, &b, pose).run(&mut workspace, Budget::unlimited());
            let meet = !all_pairs(a.mesh(), b.mesh(), &pose).is_empty();
            assert_eq!(matches!(answer.value, Verdict::Intersecting { .. }), meet);
            if !meet {
                let truth = self::inner(a.mesh(), b.mesh(), &pose, &mut random);
                assert_eq!(answer.value.meets(), truth != [false; 2]);
                contained += usize::from(answer.value.meets());
            }
        }
    }
    assert!(contained > 2, "{contained}");
}

#[test]
fn surfaces_and_open_meshes_contain_nothing() {
    let ball = shapes::icosphere(2);
    let small = union(&[(&ball, 0.1, DVec3::ZERO)]);
    let open = with_triangles(&ball, ball.triangles()[1..].iter().copied());
    let mut workspace = Workspace::new();
    for [a, b] in [
        [Tree::new(ball.clone()), solid(&small)],
        [solid(&ball), Tree::new(small.clone())],
        [solid(&open), solid(&small)],
    ] {
        let (budget, pose) = (Budget::unlimited(), Pose::IDENTITY);
        let answer = Query::intersection(&a, &b, pose).run(&mut workspace, budget);
        assert_eq!(answer.value, Verdict::Separated);
        let answer = Query::distance(&a, &b, pose).run(&mut workspace, budget);
        assert!(answer.value.low > 0.5 && answer.value.within.is_none());
    }
}

#[test]
fn at_every_stop_verdicts_distances_and_times_are_true() {
    let mut random = Random::new(13);
    let (mut whole, mut parts) = (Workspace::new(), Workspace::new());
    let meshes = bodies();
    let mut seen = [0; 2];
    for a in &meshes {
        for b in &meshes {
            for k in 0..3 {
                let b = union(&[(b, [0.2, 0.05, 1.0][k], DVec3::ZERO)]);
                let pose = pose(&mut random, 0.9, 0.0);
                let truth = inner(a, &b, &pose, &mut random);
                let meet = !all_pairs(a, &b, &pose).is_empty();
                let touch = meet || truth != [false; 2];
                let (a, b) = (solid(a), solid(&b));

                let query = Query::intersection(&a, &b, pose);
                let end = query.run(&mut whole, Budget::unlimited());
                let mut answer = query.run(&mut parts, Budget::work(200));
                while answer.stop == StopReason::WorkLimit {
                    assert!(!answer.value.meets() || touch);
                    assert!(answer.value != Verdict::Separated);
                    answer = query.resume(&mut parts, Budget::work(200)).unwrap();
                }
                // The order of visits depends on the budget, and with it the witness.
                assert_eq!(answer.value.name(), end.value.name());
                assert_eq!(answer.value.meets(), touch);

                let query = Query::distance(&a, &b, pose);
                let end = query.run(&mut whole, Budget::unlimited());
                let mut answer = query.run(&mut parts, Budget::work(200));
                while answer.stop == StopReason::WorkLimit {
                    assert!(
                        answer.value.low <= end.value.low && end.value.high <= answer.value.high
                    );
                    answer = query.resume(&mut parts, Budget::work(200)).unwrap();
                }
                assert_eq!(
                    (answer.value, answer.stats.work),
                    (end.value, end.stats.work)
                );
                assert_eq!(end.value.high == 0.0, touch, "{:?}", end.value);
                assert!(end.value.within.is_none() || touch);
                if !touch {
                    let surfaces = query.surfaces().run(&mut whole, Budget::unlimited());
                    assert_eq!(surfaces.value, end.value);
                }

                let motion = Motion::straight(pose, DVec3::X * 3.0).unwrap();
                let query = Query::impact(&a, &b, motion);
                let end = query.run(&mut whole, Budget::unlimited());
                let mut answer = query.run(&mut parts, Budget::work(200));
                while answer.stop == StopReason::WorkLimit {
                    assert!(answer.value.lower <= end.value.upper.unwrap_or(1.0));
                    assert!(
                        answer
                            .value
                            .upper
                            .is_none_or(|upper| upper >= end.value.lower)
                    );
                    answer = query.resume(&mut parts, Budget::work(200)).unwrap();
                }
                assert_eq!(
                    (answer.value, answer.stats.work),
                    (end.value, end.stats.work)
                );
                assert_eq!(end.value.upper == Some(0.0), touch, "{:?}", end.value);
                seen[usize::from(touch && !meet)] += 1;
            }
        }
    }
    assert!(seen.iter().all(|&count| count >= 10), "{seen:?}");
}

#[test]
fn a_needle_that_starts_in_a_wall_is_in_contact_at_0() {
    let wall = solid(&shapes::cuboid(Vec3::new(1.0, 9.0, 9.0), 3));
    let needle = solid(&shapes::cuboid(Vec3::new(0.2, 0.01, 0.01), 1));
    let motion = Motion::straight(Pose::IDENTITY, DVec3::X * 9.0).unwrap();
    let found = Query::impact(&wall, &needle, motion)
        .run(&mut Workspace::new(), Budget::unlimited())
        .value;
    assert_eq!((found.lower, found.upper), (0.0, Some(0.0)));
    assert_eq!((found.within, found.triangles), (Some(Operand::B), None));
}

#[test]
fn a_memory_changes_no_verdict() {
    let mut random = Random::new(14);
    let (a, b) = (
        solid(&bodies()[3]),
        solid(&union(&[(&shapes::icosphere(1), 0.05, DVec3::ZERO)])),
    );
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let mut verdicts = std::collections::BTreeMap::new();
    let mut place = DVec3::new(0.15, 0.3, 0.0);
    for frame in 0..400 {
        place = (place + random.vector() * 0.05).clamp(DVec3::splat(-1.2), DVec3::splat(1.2));
        let pose = Pose::new(DMat3::IDENTITY, place).unwrap();
        let query = Query::intersection(&a, &b, pose);
        if frame % 3 == 0 {
            // Proves a clearance.
            let _ = Query::distance(&a, &b, pose)
                .surfaces()
                .with_memory(&mut memory)
                .run(&mut workspace, Budget::unlimited());
        }
        let fresh = query.run(&mut workspace, Budget::unlimited()).value;
        let used = query
            .with_memory(&mut memory)
            .run(&mut workspace, Budget::unlimited())
            .value;
        assert_eq!(fresh.name(), used.name());
        *verdicts.entry(used.name()).or_insert(0) += 1;
    }
    assert!(
        verdicts.len() == 3 && verdicts.values().all(|&count| count > 5),
        "{verdicts:?}"
    );
}

#[test]
fn contained_verdicts_name_the_inner_body() {
    for inner in [Operand::A, Operand::B] {
        let verdict = Verdict::Contained { inner };
        assert_eq!(verdict.to_string(), format!("contained({inner})"));
        assert_eq!(verdict.name(), "contained");
    }
}
