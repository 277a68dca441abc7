//! What it costs to know that a frame is free, beside a query at one pose: `cargo bench -p punctual-benches --bench motion -- [FOLDER..]`.
//!
//! A folder holds two meshes `a.obj` and `b.obj` and `poses.txt`, of B in A, 12 numbers a line. Each pose to the next is a
//! motion (a screw). All motions are played, then all poses (`any`), over and over in one run, and of each the least time
//! counts; so neither finds caches and branch predictors as the same queries have left them. Ratios are of free motions to the
//! mean of the queries at both their ends. Without folders a ball goes around a knot.

mod case;

use std::hint::black_box;
use std::time::{Duration, Instant};

use case::Case;
use punctual::{Budget, Query, Workspace};

/// Times that everything is played.
const SWEEPS: usize = 15;

fn measure(case: &Case) {
    let [a, b] = &case.trees;
    let motions = case.motions();
    let mut workspace = Workspace::new();
    let mut least = [
        vec![f64::INFINITY; motions.len()],
        vec![f64::INFINITY; case.poses.len()],
    ];
    let mut is_free = vec![false; motions.len()];
    let us = |time: Duration| time.as_secs_f64() * 1e6;
    for _ in 0..SWEEPS {
        for (i, &motion) in motions.iter().enumerate() {
            let start = Instant::now();
            let found = Query::impact(a, b, motion).run(&mut workspace, Budget::unlimited());
            least[0][i] = least[0][i].min(us(start.elapsed()));
            is_free[i] = found.value.lower == 1.0 && found.value.upper.is_none();
        }
        for (i, &pose) in case.poses.iter().enumerate() {
            let start = Instant::now();
            let found = Query::intersection(a, b, pose).run(&mut workspace, Budget::unlimited());
            least[1][i] = least[1][i].min(us(start.elapsed()));
            let _ = black_box(found);
        }
    }
    let [of_motions, of_poses] = &least;
    let pairs: Vec<[f64; 2]> = (0..motions.len())
        .filter(|&i| is_free[i])
        .map(|i| [of_motions[i], (of_poses[i] + of_poses[i + 1]) / 2.0])
        .collect();
    let frames = pairs.len() as f64;
    let [motion, query] = [0, 1].map(|k| pairs.iter().map(|times| times[k]).sum::<f64>() / frames);
    let ratios: Vec<f64> = pairs.iter().map(|[motion, query]| motion / query).collect();
    let worst = ratios.iter().copied().fold(0.0, f64::max);
    println!(
        "{:<36} {frames:>6} {motion:>9.2} {query:>9.2} {:>8.2} {:>8.2} {worst:>8.1}",
        case.name,
        motion / query,
        ratios.iter().sum::<f64>() / frames,
    );
}

fn main() {
    let folders: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    println!(
        "{:<36} {:>6} {:>9} {:>9} {:>8} {:>8} {:>8}",
        "", "free", "motion us", "any us", "ratio", "frames", "worst"
    );
    if folders.is_empty() {
        measure(&Case::ball_and_knot());
    }
    for folder in &folders {
        measure(&Case::read(folder));
    }
}
