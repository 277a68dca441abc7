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

use cpu_time::ThreadTime;
use punctual::glam::{DQuat, DVec3};
use punctual::{Budget, shapes};
use punctual_depenetrate::PenetrationWorkspace;
use punctual_scene::{BodyContact, BodyId, ContactPhase};
use world::{Pile, SIZE, Shape};

const BODIES: usize = 300;
const FRAMES: usize = 600;
const BUDGET: Duration = Duration::from_millis(1);
/// Frames between two bullets, and between two lines of the table.
const SECOND: usize = 60;

fn play(out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let mut pile = Pile::new(&Shape::built_in(), BODIES)?;
    let gate = pile.insert_box([4.0, 4.0, 0.25], DVec3::Z * 16.0, |body| body.sensor())?;
    let shape = Shape::new(&shapes::icosphere(2), 0.5 * SIZE).ok_or("a ball is a solid")?;
    let muzzle = DVec3::Z * 18.0;
    let bullet = pile.insert(&shape, muzzle, DQuat::IDENTITY)?;
    pile.scene.track_contacts();
    let (mut held, mut slowed, mut passed, mut late) = (0, 0, [0; 2], Vec::new());
    writeln!(
        out,
        "second  lost  pairs with contacts, known as they are  bodies held, slowed"
    )?;
    for frame in 0..FRAMES {
        if frame % SECOND == 0 {
            let ball = &mut pile.bodies[bullet];
            (ball.position, ball.velocity) = (muzzle, DVec3::Z * -20.0);
        }
        pile.place()?;
        let start = ThreadTime::now();
        let report = pile.scene.detect(Budget::time(BUDGET));
        late.push(start.elapsed().saturating_sub(BUDGET));
        for (count, phase) in passed
            .iter_mut()
            .zip([ContactPhase::Began, ContactPhase::Ended])
        {
            let at_gate = |contact: &&BodyContact| is_of(contact, gate) && contact.phase == phase;
            *count += report.contacts.iter().filter(at_gate).count();
        }
        let known = pile.advance()?;
        (held, slowed) = (held + known.held, slowed + known.slowed);
        if frame % SECOND == SECOND - 1 {
            let (second, lost, touching) = ((frame + 1) / SECOND, pile.lost(), known.touching);
            write!(
                out,
                "{second:>6}  {lost:>4}  {touching:>19}, {:>17}",
                known.fresh
            )?;
            writeln!(out, "  {:>11}, {:>6}", known.held, known.slowed)?;
        }
    }
    pile.place()?;
    late.sort_unstable();
    let depths = pile.depths(&mut PenetrationWorkspace::default())?;
    let deepest = 100.0 * depths.last().unwrap_or(&0.0);
    let share = |count: usize| 100.0 * count as f64 / (FRAMES * (BODIES + 1)) as f64;
    writeln!(
        out,
        "\n{} of {BODIES} bodies were lost. The deepest overlap at the end is {deepest:.1} % of a body.",
        pile.lost()
    )?;
    writeln!(
        out,
        "For want of time bodies were held in {:.0} % of all frames, and slowed down in {:.0} %.",
        share(held),
        share(slowed)
    )?;
    writeln!(
        out,
        "99 of 100 frames passed their budget of {BUDGET:?} by at most {:.1?} of processor time.",
        late[FRAMES * 99 / 100]
    )?;
    writeln!(
        out,
        "{} bodies came to the sensor, {} left it.",
        passed[0], passed[1]
    )?;
    if pile.lost() > 0 {
        Err("bodies fell through".into())
    } else {
        Ok(())
    }
}

fn is_of(contact: &BodyContact, id: BodyId) -> bool {
    contact.a == id || contact.b == id
}

fn main() -> Result<(), Box<dyn Error>> {
    common::write(play)
}
