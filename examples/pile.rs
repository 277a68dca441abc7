//! Rings, gears and knots fall into a bin: 300 bodies, and one millisecond of each frame to find
//! their contacts. Once a second a bullet comes from above, and a sensor counts what flies past.
//!
//! The contacts of all bodies take many times as long, so each frame knows some pairs as they are
//! and others as they were. A body moves only as far as what is known of its surroundings allows: if
//! time is short the pile is in slow motion, but nothing falls through anything.
//!
//! `cargo run --release --example pile`

mod common;
#[path = "../crates/cli/src/pile/solver.rs"]
mod solver;
#[allow(dead_code, reason = "`punctual pile` uses the rest")]
#[path = "../crates/cli/src/pile/world.rs"]
mod world;

use std::error::Error;
use std::io::Write;
use std::time::Duration;

use punctual::glam::{DQuat, DVec3};
use punctual::{Budget, shapes};
use punctual_depenetrate::PenetrationWorkspace;
use punctual_scene::{Body, BodyContact, ContactPhase};
use world::{Pile, SIZE, SKIN, Shape};

const BODIES: usize = 300;
const FRAMES: usize = 600;
const BUDGET: Duration = Duration::from_millis(1);
/// Frames between two bullets, and between two lines of the table.
const SECOND: usize = 60;

fn play(out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let mut pile = Pile::new(&Shape::built_in()?, BODIES, SKIN)?;
    // More important than any body that waits to be looked at, so that no bullet passes unseen.
    let sensor = |body: Body| body.sensor().importance(2.0);
    let gate = pile.insert_box([4.0, 4.0, 0.25], DVec3::Z * 16.0, sensor)?;
    let shape = Shape::new(&shapes::icosphere(2), 0.5 * SIZE)?;
    let muzzle = DVec3::Z * 18.0;
    let bullet = pile.insert(&shape, muzzle, DQuat::IDENTITY)?;
    pile.scene.track_contacts();
    let (mut came, mut left) = (0, 0);
    writeln!(
        out,
        "second  lost  touching, of them known as they are  held, slowed"
    )?;
    for frame in 0..FRAMES {
        if frame % SECOND == 0 {
            let ball = &mut pile.bodies[bullet];
            (ball.position, ball.velocity) = (muzzle, DVec3::Z * -20.0);
        }
        pile.place()?;
        let report = pile.scene.detect(Budget::time(BUDGET));
        let at_gate = |event: &&BodyContact| event.a == gate || event.b == gate;
        for event in report.contacts.iter().filter(at_gate) {
            came += usize::from(event.phase == ContactPhase::Began);
            left += usize::from(event.phase == ContactPhase::Ended);
        }
        let known = pile.advance()?;
        if frame % SECOND == SECOND - 1 {
            let (second, lost, touching) = ((frame + 1) / SECOND, pile.lost(), known.touching);
            write!(
                out,
                "{second:>6} {lost:>5} {touching:>9} {:>26}",
                known.fresh
            )?;
            writeln!(out, " {:>6} {:>7}", known.held, known.slowed)?;
        }
    }
    pile.place()?;
    let depths = pile.depths(&mut PenetrationWorkspace::default())?;
    let deepest = 100.0 * depths.last().unwrap_or(&0.0);
    let lost = pile.lost();
    writeln!(
        out,
        "\n{lost} of {BODIES} bodies were lost. The deepest overlap is {deepest:.1} % of a body."
    )?;
    writeln!(out, "{came} bodies came to the sensor, {left} left it.")?;
    if lost > 0 {
        return Err("bodies fell through".into());
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    common::write(play)
}
