//! A tool moves down on a part. It slows down with the proven clearance and stops at a limit.
//!
//! Each cycle asks two questions. May the tool move at all? Only if it is proven to be farther away
//! than the limit and one more step. How fast? In proportion to the lower bound of the distance,
//! which is true wherever the query stopped. So a controller with too little time is slow, but
//! never too close.

mod common;

use std::error::Error;
use std::io::Write;

use punctual::distance::{Bounds, Distance};
use punctual::glam::{DMat3, DVec3};
use punctual::{Answer, Budget, PairMemory, Pose, PoseError, Query, Tree, Workspace, shapes};

/// The tool may come no closer than this (m).
const LIMIT: f64 = 0.05;
/// Length of a cycle (s), and the highest speed (m/s).
const CYCLE: f64 = 0.004;
const FASTEST: f64 = 0.5;
/// Time to the limit at the present speed (s): the speed is chosen so that it is never less.
const BRAKING: f64 = 0.2;
/// The query for the distance between the part and a tool at this height.
fn distance<'t>(
    part: &'t Tree,
    tool: &'t Tree,
    height: f64,
) -> Result<Query<'t, Distance>, PoseError> {
    let pose = Pose::new(DMat3::from_rotation_x(0.4), DVec3::new(0.3, 0.2, height))?;
    Ok(Query::distance(part, tool, pose).relative_tolerance(0.02))
}

/// The end of a drive. `is_near` is true if the limit was proven to be near.
struct End {
    seconds: f64,
    height: f64,
    is_near: bool,
}

/// Drives the tool down until it stops. Calls `watch` with the time, the distance and the speed of
/// each cycle.
fn drive(
    [part, tool]: [&Tree; 2],
    budget: Budget,
    mut watch: impl FnMut(f64, &Answer<Bounds>, f64) -> Result<(), Box<dyn Error>>,
) -> Result<End, Box<dyn Error>> {
    // All memory is allocated here, none in the loop.
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let (mut seconds, mut height) = (0.0, 3.0);
    loop {
        let query = distance(part, tool, height)?;
        let near = query.closer_than(LIMIT + FASTEST * CYCLE);
        let near = near
            .with_memory(&mut memory)
            .run(&mut workspace, budget)
            .value
            .closer;
        let found = query.with_memory(&mut memory).run(&mut workspace, budget);
        // What is not decided counts as near.
        let is_free = near == Some(false);
        let speed = if is_free {
            FASTEST.min((found.value.low - LIMIT) / BRAKING).max(0.0)
        } else {
            0.0
        };
        watch(seconds, &found, speed)?;
        if speed == 0.0 {
            return Ok(End {
                seconds,
                height,
                is_near: near == Some(true),
            });
        }
        height -= speed * CYCLE;
        seconds += CYCLE;
    }
}

fn tell(out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let part = Tree::new(shapes::gear(17, 8));
    let tool = Tree::new(shapes::torus_knot(2, 3, 0.2, 128));
    let trees = [&part, &tool];
    writeln!(
        out,
        "part: {} triangles, tool: {} triangles",
        part.mesh().len(),
        tool.mesh().len()
    )?;
    writeln!(out, "\n  time   distance is proven to be   may go at")?;
    let mut cycles = 0;
    drive(trees, Budget::work(500_000), |seconds, found, speed| {
        if cycles % 40 == 0 || speed == 0.0 {
            writeln!(
                out,
                "{seconds:>6.3} s   {:>7.4} to {:>7.4} m   {speed:>7.3} m/s",
                found.value.low, found.value.high
            )?;
        }
        cycles += 1;
        Ok(())
    })?;

    writeln!(
        out,
        "\nThe same with less and less work for each question, down to a thousandth:"
    )?;
    writeln!(
        out,
        "   work   stopped after   since it is          exact distance"
    )?;
    for work in [500_000, 100_000, 20_000, 10_000, 7_000, 500] {
        let End {
            seconds,
            height,
            is_near,
        } = drive(trees, Budget::work(work), |_, _, _| Ok(()))?;
        let exact = distance(&part, &tool, height)?.relative_tolerance(0.0);
        let exact = exact.run(&mut Workspace::new(), Budget::unlimited());
        assert!(exact.value.low >= LIMIT);
        let reason = if is_near {
            "at the limit"
        } else {
            "not proven free"
        };
        writeln!(
            out,
            "{work:>7} {seconds:>13.3} s   {reason:<17} {:>15.4} m",
            exact.value.high
        )?;
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    common::write(tell)
}
