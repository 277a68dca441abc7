//! Sixty frames, seven moving bodies, one small time budget a frame for all their pairs.
//!
//! Each pair may use a third of the time that is left, so what one saves the others may use, and some is left for the
//! last; who is first changes from frame to frame. Every verdict is compared with a query that had all the time it wanted.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{
    Budget, Mode, PairMemory, Pose, PoseError, Query, StopReason, SystemClock, Tree, Verdict, Workspace, shapes,
};

const FRAMES: u32 = 60;
const FRAME_BUDGET: Duration = Duration::from_micros(100);

fn trees() -> Vec<Tree> {
    let meshes = [
        shapes::torus_knot(2, 3, 0.1, 256),
        shapes::torus_knot(3, 4, 0.06, 256),
        shapes::gear(23, 4),
        shapes::gear(15, 5),
        shapes::icosphere(5),
        shapes::torus(1.0, 0.2, 96),
        shapes::cuboid(Vec3::new(0.9, 0.5, 0.2), 24),
    ];
    meshes.into_iter().map(Tree::new).collect()
}

/// Bodies follow each other along a loop, each turning about its own axis.
fn pose(body: usize, frame: u32) -> Result<Pose, PoseError> {
    let time = TAU * (f64::from(frame) / f64::from(FRAMES) + 0.15 * body as f64);
    let turn = DMat3::from_rotation_x(time) * DMat3::from_rotation_z(0.4 * body as f64 * time);
    let place = DVec3::new(1.6 * time.cos(), 1.4 * time.sin(), 0.6 * (2.0 * time).sin());
    Pose::new(turn, place)
}

fn main() -> Result<(), PoseError> {
    let trees = trees();
    let mut pairs: Vec<(usize, usize, PairMemory)> =
        (0..trees.len()).flat_map(|a| (a + 1..trees.len()).map(move |b| (a, b, PairMemory::new()))).collect();
    let (mut workspace, mut unhurried) = (Workspace::new(), Workspace::new());
    let clock = SystemClock::default();
    let (mut asked, mut finished, mut wrong, mut slowest) = (0, 0, 0, Duration::ZERO);
    let (mut found, mut exist) = (0, 0);
    println!("{} pairs, {FRAME_BUDGET:?} a frame", pairs.len());
    println!("frame    used  touching  apart  undecided  contacts  stopped early (?: undecided)");

    for frame in 0..FRAMES {
        let (mut spent, mut verdicts, mut contacts) = (Duration::ZERO, [0; 3], 0);
        let mut early = String::new();
        pairs.rotate_left(1);
        for (a, b, memory) in &mut pairs {
            let start = Instant::now();
            let b_in_a = pose(*a, frame)?.inverse()?.compose(&pose(*b, frame)?)?;
            let query = Query::new(&trees[*a], &trees[*b], b_in_a).mode(Mode::All);
            let budget = Budget::time(FRAME_BUDGET.saturating_sub(spent) / 3);
            let outcome = query.run_with(&mut workspace, Some(memory), budget, &clock);
            spent += start.elapsed();

            let truth = query.run(&mut unhurried, Budget::unlimited());
            let touching = matches!(truth.verdict, Verdict::Intersecting { .. });
            let (column, right) = match outcome.verdict {
                Verdict::Intersecting { .. } => (0, touching),
                Verdict::Separated => (1, !touching),
                Verdict::Undecided => (2, true),
            };
            verdicts[column] += 1;
            contacts += outcome.found;
            exist += truth.found;
            wrong += usize::from(!right);
            asked += 1;
            match outcome.stop {
                StopReason::Finished => finished += 1,
                _ => early += &format!(" {a}-{b}{}", if column == 2 { "?" } else { "" }),
            }
        }
        slowest = slowest.max(spent);
        found += contacts;
        let ([touching, apart, undecided], used) = (verdicts, spent.as_micros());
        println!("{frame:>5} {used:>4} us {touching:>9} {apart:>6} {undecided:>10} {contacts:>9} {early}");
    }
    println!("\n{finished} of {asked} queries finished, with {found} of {exist} intersecting pairs of triangles.");
    println!("The slowest frame took {slowest:?}. Verdicts that a query without a budget contradicts: {wrong}.");
    assert_eq!(wrong, 0);
    Ok(())
}
