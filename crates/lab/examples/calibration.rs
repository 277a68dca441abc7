//! How well probabilities are told before and after a calibration has learned from each pair of parts: the table of
//! `docs/model.md`.
//!
//! `cargo run --release -p punctual-lab --example calibration -- CASE...` with case folders (a.*, b.*, poses.txt).
//!
//! Queries for any intersection are stopped at [`PERCENT`] of the work of the complete query for all, as in `punctual sweep`.
//! Each case is gone through budget by budget, and what is told is learned at once, as `punctual pair --calibration` does it;
//! and pose by pose, in [`ORDERS`] random orders, where a pose is learned after all that is told of it. Scored is what is told
//! once [`TAUGHT`] moments have been learned.

use std::path::Path;

use punctual::clock::ManualClock;
use punctual::internals::Random;
use punctual::prediction::Calibration;
use punctual::{Budget, Mode, Query, Tree, Verdict, Workspace};
use punctual_lab::files;
use punctual_lab::report::{Chances, Failure};
use punctual_lab::traversal::complete;

const PERCENT: [u64; 8] = [1, 2, 5, 10, 20, 30, 50, 70];
const TAUGHT: usize = 100;
const ORDERS: u64 = 10;

/// What was told of a pose at each budget, if it was undecided, and whether the surfaces meet there.
struct Pose {
    told: [Option<f64>; PERCENT.len()],
    met: bool,
}

fn poses(folder: &Path) -> Result<Vec<Pose>, Failure> {
    let [a, b] = [files::mesh(folder, "a")?, files::mesh(folder, "b")?].map(Tree::new);
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let mut poses = Vec::new();
    for pose in files::poses(&folder.join("poses.txt"))?
        .into_iter()
        .filter_map(|listed| listed.entry.ok())
    {
        let query = Query::intersection(&a, &b, pose);
        let all = query.mode(Mode::All);
        let whole = complete(&all, &mut workspace, drop);
        let mut told = [None; PERCENT.len()];
        for (told, percent) in told.iter_mut().zip(PERCENT) {
            let budget = Budget::work(whole.stats.work * percent / 100);
            if query.run(&mut workspace, budget.clock(&clock)).value == Verdict::Undecided {
                *told = Some(query.estimate(&workspace, None)?.probability);
            }
        }
        poses.push(Pose {
            told,
            met: whole.stats.found > 0,
        });
    }
    Ok(poses)
}

/// Goes through moments in turn, those of a group before any of them is learned: what is told once enough has been learned,
/// by the model and corrected.
fn play(groups: impl Iterator<Item = Vec<(f64, bool)>>) -> [Chances; 2] {
    let (mut calibration, mut learned) = (Calibration::default(), 0);
    let [mut raw, mut corrected] = [Chances::default(), Chances::default()];
    for group in groups {
        for &(told, met) in group.iter().skip(TAUGHT.saturating_sub(learned)) {
            raw.0.push((told, met));
            corrected.0.push((calibration.apply(told), met));
        }
        group
            .iter()
            .for_each(|&(told, met)| calibration.learn(told, met));
        learned += group.len();
    }
    [raw, corrected]
}

/// Budget by budget, each moment learned at once.
fn by_budget(poses: &[Pose]) -> [Chances; 2] {
    let at = |i: usize| {
        poses
            .iter()
            .filter_map(move |pose| Some(vec![(pose.told[i]?, pose.met)]))
    };
    play((0..PERCENT.len()).flat_map(at))
}

/// Pose by pose, in an order of its own.
fn by_pose(poses: &[Pose], seed: u64) -> [Chances; 2] {
    let mut random = Random::new(seed);
    let mut order: Vec<(f64, &Pose)> = poses.iter().map(|pose| (random.fraction(), pose)).collect();
    order.sort_by(|x, y| x.0.total_cmp(&y.0));
    play(order.iter().map(|(_, pose)| {
        pose.told
            .iter()
            .flatten()
            .map(|&told| (told, pose.met))
            .collect()
    }))
}

/// Columns of the table, each of one order: as told and corrected, budget by budget and pose by pose.
type Columns = [Chances; 4];

fn columns(poses: &[Pose], seed: u64) -> Columns {
    let ([a, b], [c, d]) = (by_budget(poses), by_pose(poses, seed));
    [a, b, c, d]
}

/// ECE and Brier score of each column, means over the orders.
fn scores(orders: &[Columns]) -> [[f64; 2]; 4] {
    let mean = |score: &dyn Fn(&Columns) -> f64| {
        orders.iter().map(score).sum::<f64>() / orders.len() as f64
    };
    [0, 1, 2, 3].map(|i| {
        [
            mean(&|of| of[i].calibration_error()),
            mean(&|of| of[i].brier()),
        ]
    })
}

fn row(name: &str, moments: usize, scores: [[f64; 2]; 4]) -> String {
    let text = scores
        .map(|[ece, brier]| format!("{ece:.3} / {brier:.3}"))
        .join(" | ");
    format!("| {name} | {moments} | {text} |")
}

fn main() -> Result<(), Failure> {
    println!(
        "| case: ECE / Brier | moments | by budget: told | corrected | by pose: told | corrected |"
    );
    println!("|---|---|---|---|---|---|");
    // For each order, what was told of all cases.
    let mut together: Vec<Columns> = (0..ORDERS).map(|_| Columns::default()).collect();
    let mut errors: Vec<[f64; 4]> = Vec::new();
    let mut total = 0;
    for folder in std::env::args().skip(1) {
        let folder = Path::new(&folder);
        let poses = poses(folder)?;
        let moments = poses.iter().flat_map(|pose| pose.told).flatten().count();
        if moments <= TAUGHT {
            return Err(format!("{}: only {moments} undecided moments", folder.display()).into());
        }
        let orders: Vec<Columns> = (0..ORDERS).map(|seed| columns(&poses, seed)).collect();
        let scores = scores(&orders);
        println!(
            "{}",
            row(
                &folder.file_name().unwrap_or_default().to_string_lossy(),
                moments,
                scores
            )
        );
        errors.push(scores.map(|[ece, _]| ece));
        total += moments;
        for (all, of) in together
            .iter_mut()
            .flatten()
            .zip(orders.into_iter().flatten())
        {
            all.0.extend(of.0);
        }
    }
    println!(
        "{}",
        row("**all moments together**", total, scores(&together))
    );
    let of = |i: usize| errors.iter().map(move |errors| errors[i]);
    let mean = [0, 1, 2, 3].map(|i| format!("{:.3}", of(i).sum::<f64>() / errors.len() as f64));
    let worst = [0, 1, 2, 3].map(|i| format!("{:.3}", of(i).fold(0.0, f64::max)));
    println!("| **ECE of single cases: mean** | | {} |", mean.join(" | "));
    println!(
        "| **ECE of single cases: worst** | | {} |",
        worst.join(" | ")
    );
    Ok(())
}
