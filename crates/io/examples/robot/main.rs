//! A robot of a URDF file swings past a post: it slows down with the clearance that is proven, and stops at a limit.
//!
//! In each cycle all pairs of links that may meet, and each link with what stands around, are asked how far apart they are,
//! within one budget for all. The least of the lower bounds is true wherever the queries were stopped, and says how fast the
//! joints may turn. So a controller with too little time is slow, never too close.

mod robot;
mod shapes;

use std::error::Error;
use std::io::Write;
use std::path::Path;

use punctual::{Budget, PairMemory, Pose, PoseError, Query, Tree, Workspace};
use robot::Robot;

/// No link may come closer to another than this (m).
const LIMIT: f64 = 0.02;
/// Length of a cycle (s), and the highest speed of any point of the robot (m/s).
const CYCLE: f64 = 0.002;
const FASTEST: f64 = 0.5;
/// So long before the limit it would be if it kept its speed (s).
const BRAKING: f64 = 0.1;
/// As good as standing still (m/s).
const STOPPED: f64 = 1e-3;

/// Angles at the start and at the goal, from the root on.
const START: [f64; 4] = [-1.3, 0.9, 0.7, 0.0];
const GOAL: [f64; 4] = [1.3, 0.7, 0.9, 3.0];

/// Two links that may meet. The first may be of what stands around, which does not move.
struct Pair<'r> {
    names: [&'r str; 2],
    trees: [&'r Tree; 2],
    links: [Option<usize>; 2],
    memory: PairMemory,
}

fn pairs<'r>(robot: &'r Robot, cell: &'r Robot) -> Vec<Pair<'r>> {
    let pair = |a: &'r Robot, i: usize, j: usize, first: Option<usize>| {
        let ends = [&a.links[i], &robot.links[j]];
        let (names, trees) = (
            ends.map(|link| link.name.as_str()),
            ends.map(|link| &link.tree),
        );
        Pair {
            names,
            trees,
            links: [first, Some(j)],
            memory: PairMemory::new(),
        }
    };
    let of_robot = robot.pairs.iter().map(|&[i, j]| pair(robot, i, j, Some(i)));
    // The first link is what the robot stands on.
    let around = (0..cell.links.len()).flat_map(|i| (1..robot.links.len()).map(move |j| [i, j]));
    of_robot
        .chain(around.map(|[i, j]| pair(cell, i, j, None)))
        .collect()
}

/// The least distance of all pairs that is proven within so much work, to this tolerance if that is enough, and between whom.
fn clearance<'r>(
    pairs: &mut [Pair<'r>],
    poses: &[Pose],
    mut work: u64,
    tolerance: f64,
    workspace: &mut Workspace,
) -> Result<(f64, [&'r str; 2]), PoseError> {
    let (mut least, mut between, mut left) = (f64::INFINITY, [""; 2], pairs.len() as u64);
    for pair in pairs {
        let [a, b] = pair
            .links
            .map(|link| link.map_or(Pose::IDENTITY, |link| poses[link]));
        let query = Query::distance(pair.trees[0], pair.trees[1], a.inverse()?.compose(&b)?);
        let share = Budget::work(work / left);
        let found = query
            .relative_tolerance(tolerance)
            .with_memory(&mut pair.memory)
            .run(workspace, share);
        (work, left) = (work.saturating_sub(found.stats.work), left - 1);
        if found.value.low < least {
            (least, between) = (found.value.low, pair.names);
        }
    }
    Ok((least, between))
}

/// Where a drive ended: the time, the share of the way, and the clearance as it was proven.
struct End {
    seconds: f64,
    share: f64,
    proven: f64,
}

fn angles(share: f64) -> Vec<f64> {
    START
        .iter()
        .zip(GOAL)
        .map(|(&start, goal)| start + share * (goal - start))
        .collect()
}

/// From the start until it stops; `watch` is told the time, the clearance, between whom, and the speed of each cycle.
fn drive(
    robot: &Robot,
    cell: &Robot,
    work: u64,
    mut watch: impl FnMut(f64, f64, [&str; 2], f64) -> Result<(), Box<dyn Error>>,
) -> Result<End, Box<dyn Error>> {
    let (mut pairs, mut workspace) = (pairs(robot, cell), Workspace::new());
    let way = robot.farthest(
        &START
            .iter()
            .zip(GOAL)
            .map(|(start, goal)| goal - start)
            .collect::<Vec<_>>(),
    );
    let (mut seconds, mut share) = (0.0, 0.0);
    loop {
        // Before it moves there is time for a whole look; what this proves is remembered.
        let work = if share > 0.0 { work } else { u64::MAX };
        let (proven, between) = clearance(
            &mut pairs,
            &robot.poses(&angles(share))?,
            work,
            0.1,
            &mut workspace,
        )?;
        let speed = FASTEST.min((proven - LIMIT) / BRAKING).max(0.0);
        watch(seconds, proven, between, speed)?;
        if speed < STOPPED || share >= 1.0 {
            return Ok(End {
                seconds,
                share,
                proven,
            });
        }
        share = (share + speed * CYCLE / way).min(1.0);
        seconds += CYCLE;
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/robot");
    let (robot, cell) = (
        Robot::load(&folder.join("arm.urdf"))?,
        Robot::load(&folder.join("cell.urdf"))?,
    );
    assert_eq!(robot.freedom(), START.len());
    let mut out = std::io::stdout().lock();
    for link in robot.links.iter().chain(&cell.links) {
        writeln!(
            out,
            "{:<10} {:>5} triangles",
            link.name,
            link.tree.mesh().len()
        )?;
    }
    writeln!(
        out,
        "{} pairs of links may meet",
        pairs(&robot, &cell).len()
    )?;
    writeln!(
        out,
        "\n  time   clearance is proven to be      between             may go at"
    )?;
    let mut cycles = 0;
    drive(&robot, &cell, 200_000, |seconds, proven, [a, b], speed| {
        if cycles % 200 == 0 || speed < STOPPED {
            writeln!(
                out,
                "{seconds:>6.3} s   at least {proven:>7.4} m   {a:>12} and {b:<10} {speed:>7.3} m/s"
            )?;
        }
        cycles += 1;
        Ok(())
    })?;

    writeln!(out, "\nThe same with less and less work for each cycle:")?;
    writeln!(
        out,
        "   work   stopped after    of the way   proven      exact clearance"
    )?;
    for work in [
        200_000, 50_000, 40_000, 30_000, 20_000, 10_000, 5_000, 1_000,
    ] {
        let End {
            seconds,
            share,
            proven,
        } = drive(&robot, &cell, work, |_, _, _, _| Ok(()))?;
        let poses = robot.poses(&angles(share))?;
        let (exact, _) = clearance(
            &mut pairs(&robot, &cell),
            &poses,
            u64::MAX,
            0.0,
            &mut Workspace::new(),
        )?;
        assert!(proven <= exact && exact >= LIMIT);
        writeln!(
            out,
            "{work:>7} {seconds:>13.3} s {:>11.1} % {proven:>9.4} {exact:>12.4} m",
            100.0 * share
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_runs() {
        super::main().unwrap();
    }
}
