//! Criterion benches of distance queries on generated meshes, the mean over poses that take turns, so that no query finds its
//! own tracks in the caches. Each answer is checked before it is timed: `cargo bench -p punctual-benches --bench distance`.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use punctual::distance::Distance;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, PairMemory, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes};

const POSES: u32 = 16;

/// A knot and a ball of rising resolution.
fn pair(step: u32) -> (Tree, Tree) {
    (
        Tree::new(shapes::torus_knot(2, 3, 0.2, 48 << step)),
        Tree::new(shapes::icosphere(3 + step)),
    )
}

fn turn(i: u32) -> DMat3 {
    let angle = f64::from(i);
    DMat3::from_rotation_z(0.3 + angle) * DMat3::from_rotation_x(0.7 * angle)
}

fn exact<'t>(a: &'t Tree, b: &'t Tree, pose: Pose) -> Query<'t, Distance> {
    Query::distance(a, b, pose).absolute_tolerance(0.0)
}

/// Poses around A, as far apart as told. B comes along the line of the closest points, by no more than its distance.
fn apart(a: &Tree, b: &Tree, distance: f64) -> Vec<Pose> {
    let mut workspace = Workspace::new();
    let mut at = |i: u32| {
        let mut middle = turn(5 * i) * DVec3::new(9.0, 0.0, 0.0);
        loop {
            let pose = Pose::new(turn(i), middle).expect("a rotation");
            let found = exact(a, b, pose).run(&mut workspace, Budget::unlimited());
            if found.value.high < 1.001 * distance {
                assert!(found.value.low > 0.999 * distance);
                return pose;
            }
            let [p, q] = found.value.nearest.expect("a finished query").points;
            middle -= (q - p).normalize() * (found.value.high - distance);
        }
    };
    (0..POSES).map(&mut at).collect()
}

/// Poses at which the surfaces meet.
fn touching() -> Vec<Pose> {
    (0..POSES)
        .map(|i| Pose::new(turn(i), DVec3::new(1.9, 0.4, 0.1)).expect("a rotation"))
        .collect()
}

/// Near, far and touching, with the distance.
fn places(a: &Tree, b: &Tree) -> [(&'static str, Vec<Pose>, f64); 3] {
    [
        ("near", apart(a, b, 0.03), 0.03),
        ("far", apart(a, b, 3.0), 3.0),
        ("touching", touching(), 0.0),
    ]
}

fn finished(c: &mut Criterion) {
    let mut workspace = Workspace::new();
    for step in 0..3 {
        let (a, b) = pair(step);
        let size = a.mesh().len() + b.mesh().len();
        for (name, poses, distance) in places(&a, &b) {
            for &pose in &poses {
                let found = Query::distance(&a, &b, pose).run(&mut workspace, Budget::unlimited());
                assert!(
                    found.value.low <= 1.001 * distance && 0.999 * distance <= found.value.high
                );
                assert_eq!(found.stop, StopReason::Finished);
                let meet =
                    Query::intersection(&a, &b, pose).run(&mut workspace, Budget::unlimited());
                assert_eq!(
                    matches!(meet.value, Verdict::Intersecting { .. }),
                    found.value.high == 0.0
                );
            }
            let mut poses = poses.iter().cycle();
            c.bench_function(&format!("distance/{name}/{size}"), |bench| {
                bench.iter(|| {
                    let pose = *poses.next().expect("a cycle");
                    Query::distance(&a, &b, pose).run(&mut workspace, Budget::unlimited())
                });
            });
        }
    }
}

/// How much of the time a tolerance of 1 % saves, and the end of all tolerance costs.
fn tolerances(c: &mut Criterion) {
    let mut workspace = Workspace::new();
    let mut group = c.benchmark_group("distance, tolerance");
    let (a, b) = pair(2);
    let poses = apart(&a, &b, 0.3);
    for (name, share) in [("exact", 0.0), ("0.01", 0.01), ("0.1", 0.1)] {
        let query = |pose| exact(&a, &b, pose).relative_tolerance(share);
        for &pose in &poses {
            let found = query(pose).run(&mut workspace, Budget::unlimited());
            assert!(found.value.high <= (1.0 + share) * found.value.low * (1.0 + 1e-13));
        }
        let mut poses = poses.iter().cycle();
        group.bench_function(BenchmarkId::from_parameter(name), |bench| {
            bench.iter(|| {
                query(*poses.next().expect("a cycle")).run(&mut workspace, Budget::unlimited())
            });
        });
    }
}

fn closer_than(c: &mut Criterion) {
    let mut workspace = Workspace::new();
    let mut group = c.benchmark_group("closer than");
    let (a, b) = pair(2);
    for (name, distance) in [("near", 0.03), ("far", 3.0)] {
        let poses = apart(&a, &b, distance);
        for (share, answer) in [(0.9, false), (1.1, true)] {
            let query = |pose| Query::distance(&a, &b, pose).closer_than(share * distance);
            for &pose in &poses {
                assert_eq!(
                    query(pose)
                        .run(&mut workspace, Budget::unlimited())
                        .value
                        .closer,
                    Some(answer)
                );
            }
            let mut poses = poses.iter().cycle();
            group.bench_function(format!("{share} of the distance/{name}"), |bench| {
                bench.iter(|| {
                    query(*poses.next().expect("a cycle")).run(&mut workspace, Budget::unlimited())
                });
            });
        }
    }
}

/// A ball that goes round the knot, there and back, cold and with what the frame before knew.
fn path(c: &mut Criterion) {
    let mut workspace = Workspace::new();
    let (a, b) = pair(2);
    let frame = |i: i32| {
        let angle = 0.01 * f64::from(i.abs());
        let turn = DMat3::from_rotation_z(angle);
        Pose::new(turn, turn * DVec3::new(4.5, 0.0, 0.5)).expect("a rotation")
    };
    let poses: Vec<Pose> = (-100..100).map(frame).collect();
    let mut memory = PairMemory::new();
    for &pose in &poses {
        let query = exact(&a, &b, pose);
        let cold = query.run(&mut workspace, Budget::unlimited());
        let warm = query
            .with_memory(&mut memory)
            .run(&mut workspace, Budget::unlimited());
        assert!(
            cold.value.low > 0.0
                && warm.value.low <= cold.value.high
                && cold.value.low <= warm.value.high
        );
    }
    let mut frames = poses.iter().cycle();
    c.bench_function("distance on a path/cold", |bench| {
        bench.iter(|| {
            let pose = *frames.next().expect("a cycle");
            Query::distance(&a, &b, pose).run(&mut workspace, Budget::unlimited())
        });
    });
    c.bench_function("distance on a path/warm", |bench| {
        bench.iter(|| {
            let query = Query::distance(&a, &b, *frames.next().expect("a cycle"));
            query
                .with_memory(&mut memory)
                .run(&mut workspace, Budget::unlimited())
        });
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    targets = finished, tolerances, closer_than, path
}
criterion_main!(benches);
