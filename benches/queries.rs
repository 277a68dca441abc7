//! Criterion benches of everything that is on the way of a query, on generated meshes. Each answer is checked before it is
//! timed: `cargo bench -p punctual-benches --bench queries`.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use punctual::geom::triangles_intersect;
use punctual::glam::{DMat3, DVec3};
use punctual::intersection::Order;
use punctual::{Answer, Budget, Mode, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes};

/// A knot and a ball of rising resolution, overlapping.
fn pair(step: u32) -> (Tree, Tree) {
    (
        Tree::new(shapes::torus_knot(2, 3, 0.2, 48 << step)),
        Tree::new(shapes::icosphere(3 + step)),
    )
}

fn pose() -> Pose {
    let turn = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(0.7);
    Pose::new(turn, DVec3::new(1.9, 0.4, 0.1)).expect("a rotation")
}

/// The number of intersecting pairs, by every triangle against every other whose boxes meet.
fn brute_force(a: &Tree, b: &Tree, pose: &Pose) -> u64 {
    let bounds = |[p, q, r]: &[DVec3; 3]| (p.min(*q).min(*r), p.max(*q).max(*r));
    let moved: Vec<_> = (0..b.mesh().len())
        .map(|j| b.mesh().triangle(j).map(|v| pose.transform_point(v)))
        .collect();
    let of_b: Vec<_> = moved.iter().map(bounds).collect();
    let count = |i: usize| {
        let t = a.mesh().triangle(i);
        let (low, high) = bounds(&t);
        let near = |j: &usize| of_b[*j].0.cmple(high).all() && of_b[*j].1.cmpge(low).all();
        (0..moved.len())
            .filter(near)
            .filter(|&j| triangles_intersect(&t, &moved[j]))
            .count() as u64
    };
    (0..a.mesh().len()).map(count).sum()
}

fn build(c: &mut Criterion) {
    let mut group = c.benchmark_group("build");
    for step in 0..3 {
        let mesh = shapes::icosphere(3 + step);
        assert_eq!(Tree::new(mesh.clone()).validate(), Ok(()));
        group.bench_function(BenchmarkId::from_parameter(mesh.len()), |bench| {
            bench.iter_with_setup(|| mesh.clone(), |mesh| black_box(Tree::new(mesh)));
        });
    }
}

fn refit(c: &mut Criterion) {
    for step in 0..3 {
        let mut tree = Tree::new(shapes::icosphere(3 + step));
        let vertices: Vec<DVec3> = (0..tree.mesh().vertex_count())
            .map(|i| tree.mesh().vertex(i) * DVec3::new(1.0, 1.1, 0.9))
            .collect();
        tree.refit_f64(&vertices).expect("finite vertices");
        assert_eq!(tree.validate(), Ok(()));
        c.bench_function(&format!("refit/{}", tree.mesh().len()), |bench| {
            bench.iter(|| tree.refit_f64(&vertices))
        });
    }
}

fn finished(c: &mut Criterion) {
    let mut workspace = Workspace::new();
    for step in 0..3 {
        let (a, b) = pair(step);
        let size = a.mesh().len() + b.mesh().len();
        let truth = brute_force(&a, &b, &pose());
        for (name, mode, found) in [
            ("finished any", Mode::Any, 1),
            ("finished all", Mode::All, truth),
        ] {
            let query = Query::intersection(&a, &b, pose()).mode(mode);
            let outcome = query.run(&mut workspace, Budget::unlimited());
            assert!(outcome.stats.found == found && found > 0);
            c.bench_function(&format!("{name}/{size}"), |bench| {
                bench.iter(|| query.run(&mut workspace, Budget::unlimited()));
            });
        }
    }
}

fn budgeted(c: &mut Criterion) {
    let mut workspace = Workspace::new();
    let (a, b) = pair(2);
    let truth = brute_force(&a, &b, &pose());
    let query = Query::all_pairs(&a, &b, pose());
    let sound = |outcome: &Answer<Verdict>| {
        outcome.stats.found <= truth && !matches!(outcome.value, Verdict::Separated)
    };
    for us in [5, 20, 100] {
        let budget = Budget::time(Duration::from_micros(us));
        assert!(sound(&query.run(&mut workspace, budget)));
        c.bench_function(&format!("budget of time/{us} us"), |bench| {
            bench.iter(|| query.run(&mut workspace, budget))
        });
    }
    for work in [5_000, 20_000, 60_000] {
        let outcome = query.run(&mut workspace, Budget::work(work));
        assert!(sound(&outcome) && outcome.stop == StopReason::WorkLimit);
        c.bench_function(&format!("budget of work/{work}"), |bench| {
            bench.iter(|| query.run(&mut workspace, Budget::work(work)));
        });
    }
}

/// What a prediction costs, and what an answer's `remaining` and a whole estimate cost of a query
/// stopped half way.
fn prediction(c: &mut Criterion) {
    let mut workspace = Workspace::new();
    let (a, b) = pair(2);
    let query = Query::all_pairs(&a, &b, pose());
    let whole = query.run(&mut workspace, Budget::unlimited()).stats.work;
    let foretold = query.predict(None).bv_tests;
    assert!(foretold.p10 <= foretold.p90 && foretold.p90 >= 1.0);
    c.bench_function("prediction/before", |bench| {
        bench.iter(|| query.predict(None))
    });
    let half = query.run(&mut workspace, Budget::work(whole / 2));
    assert_eq!(half.stop, StopReason::WorkLimit);
    c.bench_function("prediction/remaining half way", |bench| {
        bench.iter(|| query.remaining(&workspace, None))
    });
    c.bench_function("prediction/estimate half way", |bench| {
        bench.iter(|| query.estimate(&workspace, None))
    });
}

/// The same finished query by the simplest rival, and in each order.
fn queue(c: &mut Criterion) {
    let mut workspace = Workspace::new();
    let (a, b) = pair(1);
    let truth = brute_force(&a, &b, &pose());
    let query = Query::all_pairs(&a, &b, pose());
    let variants = [
        ("plain", query.plain()),
        ("default", query),
        ("low alpha", query.order(Order::LowAlpha)),
        ("depth first", query.order(Order::DepthFirst)),
    ];
    for (name, query) in variants {
        let budget = Budget::work(u64::MAX);
        assert_eq!(query.run(&mut workspace, budget).stats.found, truth);
        c.bench_function(&format!("queue/{name}"), |bench| {
            bench.iter(|| query.run(&mut workspace, budget))
        });
    }
}

fn triangles(c: &mut Criterion) {
    let flat = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let cases = [
        (
            "crossing",
            [
                DVec3::new(0.2, 0.2, -1.0),
                DVec3::new(0.3, 0.2, 1.0),
                DVec3::new(0.2, 0.3, 1.0),
            ],
            true,
        ),
        (
            "apart",
            [
                DVec3::new(0.2, 0.2, 0.5),
                DVec3::new(0.3, 0.2, 1.0),
                DVec3::new(0.2, 0.3, 1.0),
            ],
            false,
        ),
        (
            "coplanar",
            [
                DVec3::new(0.2, 0.2, 0.0),
                DVec3::new(1.3, 0.2, 0.0),
                DVec3::new(0.2, 1.3, 0.0),
            ],
            true,
        ),
        (
            "touching",
            [
                DVec3::new(0.0, 0.0, 0.0),
                DVec3::new(-1.0, 0.0, 1.0),
                DVec3::new(0.0, -1.0, 1.0),
            ],
            true,
        ),
    ];
    for (name, other, truth) in cases {
        assert_eq!(triangles_intersect(&flat, &other), truth);
        c.bench_function(&format!("exact triangle test/{name}"), |bench| {
            bench.iter(|| triangles_intersect(black_box(&flat), black_box(&other)));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    targets = build, refit, finished, budgeted, queue, prediction, triangles
}
criterion_main!(benches);
