//! What the model costs: `cargo bench -p punctual-benches --bench model`.
//!
//! Queries of 8,000 to 12,000 BV tests between built-in shapes, the least times of interleaved repetitions, means over poses:
//! the query itself, the same with a time budget, that with the choice of the regime and what the memory learns, and the two
//! questions.

use std::hint::black_box;
use std::time::{Duration, Instant};

use punctual::clock::SystemClock;
use punctual::glam::{DMat3, DVec3};
use punctual::intersection::Intersection;
use punctual::{Budget, PairMemory, Pose, Query, Tree, Workspace, shapes};

const REPETITIONS: usize = 200;

fn main() {
    let pairs = [
        (
            Tree::new(shapes::icosphere(6)),
            Tree::new(shapes::torus(1.0, 0.3, 160)),
        ),
        (
            Tree::new(shapes::torus_knot(2, 3, 0.1, 512)),
            Tree::new(shapes::gear(20, 3)),
        ),
    ];
    println!(
        "nanoseconds   poses  BV tests  query  with a time budget  and model and memory  predict  estimate half way"
    );
    for (a, b) in &pairs {
        let mut sums = [0.0; 6];
        let mut poses = 0;
        for pose in (0..4000).map(along) {
            if let Some(times) = measure(&Query::all_pairs(a, b, pose)) {
                sums = std::array::from_fn(|i| sums[i] + times[i]);
                poses += 1;
            }
            if poses == 40 {
                break;
            }
        }
        let [tests, query, clock, budgeted, predict, estimate] =
            sums.map(|sum| sum / f64::from(poses));
        println!(
            "{poses:19} {tests:9.0} {query:6.0} {clock:19.0} {budgeted:21.0} {predict:8.0} {estimate:18.0}   (model and memory {:+.1} %)",
            100.0 * (budgeted / clock - 1.0)
        );
    }
}

fn along(i: u32) -> Pose {
    let turn = DMat3::from_rotation_z(f64::from(i)) * DMat3::from_rotation_x(0.37 * f64::from(i));
    Pose::new(turn, DVec3::new(0.0007 * f64::from(i), 0.1, 0.2))
        .expect("a rotation and a shift are a pose")
}

/// BV tests, and the least times of everything; `None` if the query is of another size.
fn measure(query: &Query<Intersection>) -> Option<[f64; 6]> {
    let clock = SystemClock::default();
    let [mut workspace, mut half] = [Workspace::new(), Workspace::new()];
    let stats = query.run(&mut workspace, Budget::unlimited()).stats;
    if !(8_000..12_000).contains(&stats.bv_tests) {
        return None;
    }
    let _ = query.run(&mut half, Budget::work(stats.work / 2));
    let mut least = [f64::INFINITY; 5];
    // The same search and the same looks at the clock, without model and memory.
    let plain = query.plain();
    let lasting = Budget::time(Duration::from_secs(1));
    for _ in 0..REPETITIONS {
        time(&mut least[0], || {
            query.run(&mut workspace, Budget::unlimited().clock(&clock))
        });
        time(&mut least[1], || {
            plain.run(&mut workspace, lasting.clock(&clock))
        });
        // A memory without witnesses: the same search.
        let mut blank = PairMemory::new();
        time(&mut least[2], || {
            query
                .with_memory(&mut blank)
                .run(&mut workspace, lasting.clock(&clock))
        });
        time(&mut least[3], || query.predict(None));
        time(&mut least[4], || query.estimate(&half, None));
    }
    let [query, clock, budgeted, predict, estimate] = least;
    Some([
        stats.bv_tests as f64,
        query,
        clock,
        budgeted,
        predict,
        estimate,
    ])
}

fn time<T>(least: &mut f64, run: impl FnOnce() -> T) {
    let start = Instant::now();
    let result = run();
    let elapsed = start.elapsed().as_nanos() as f64;
    black_box(&result);
    *least = least.min(elapsed);
}
