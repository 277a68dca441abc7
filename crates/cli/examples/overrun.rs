//! Processor time of frames beyond their budget, whatever is asked of a scene: the table of `docs/scene.md`.
//!
//! `cargo run --release -p punctual-cli --example overrun [-- FRAMES]`
//!
//! The budget is measured by the processor time of the thread, so that other programs do not count. For each question and
//! budget: median, 99th percentile and maximum over all frames but the first ten, and the maximum over the first ten, in
//! microseconds. The look at the clock itself takes a fraction of a microsecond.

use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use cpu_time::ThreadTime;
use punctual::clock::Clock;
use punctual::glam::{DMat3, DVec3};
use punctual::internals::Random;
use punctual::{Budget, Pose, Tree, shapes};
use punctual_scene::{Body, BodyId, Scene};

const BUDGETS_US: [u64; 3] = [200, 500, 2000];
const FIRST: usize = 10;

struct ProcessorClock(ThreadTime);

impl Clock for ProcessorClock {
    fn now(&self) -> Duration {
        self.0.elapsed()
    }
}

/// Bodies that wander in a cube, about three within reach of each. Room is reserved.
struct World {
    scene: Scene,
    bodies: Vec<(BodyId, DVec3)>,
    random: Random,
}

impl World {
    fn new(count: usize, margin: f64) -> Result<Self, Box<dyn Error>> {
        let tree = Arc::new(Tree::new(shapes::icosphere(3)));
        let mut world = Self {
            scene: Scene::new(),
            bodies: Vec::new(),
            random: Random::new(54),
        };
        world.scene.reserve(count, 16 * count);
        let width = 2.2 * (count as f64).cbrt();
        for _ in 0..count {
            let at = world.cube(width);
            let body = Body::moving(Arc::clone(&tree), place(at)?).margin(margin);
            world.bodies.push((world.scene.insert(body)?, at));
        }
        Ok(world)
    }

    fn cube(&mut self, width: f64) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| self.random.between(0.0, width)))
    }

    /// Moves one body in `part`.
    fn wander(&mut self, part: usize) -> Result<(), Box<dyn Error>> {
        for i in (0..self.bodies.len()).step_by(part) {
            let step = self.cube(0.1) - 0.05;
            let (id, at) = &mut self.bodies[i];
            *at += step;
            self.scene.set_pose(*id, place(*at)?)?;
        }
        Ok(())
    }
}

fn place(at: DVec3) -> Result<Pose, Box<dyn Error>> {
    Ok(Pose::new(DMat3::IDENTITY, at)?)
}

type Ask = fn(&mut World) -> Result<(), Box<dyn Error>>;

fn nothing(_: &mut World) -> Result<(), Box<dyn Error>> {
    Ok(())
}

fn contacts(world: &mut World) -> Result<(), Box<dyn Error>> {
    world.scene.find_contacts();
    Ok(())
}

fn all_pairs(world: &mut World) -> Result<(), Box<dyn Error>> {
    for i in 0..world.bodies.len() {
        for j in i + 1..world.bodies.len() {
            let [x, y] = [world.bodies[i].0, world.bodies[j].0];
            world.scene.measure(x, y, 1e-3)?;
        }
    }
    Ok(())
}

fn halves(world: &mut World) -> Result<(), Box<dyn Error>> {
    let ids: Vec<BodyId> = world.bodies.iter().map(|(id, _)| *id).collect();
    let (x, y) = ids.split_at(ids.len() / 2);
    world.scene.measure_groups(x, y, 1e-3)?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let frames = std::env::args()
        .nth(1)
        .map_or(Ok(300), |count| count.parse())?;
    // The question, the number of bodies, their margin, and which part of them moves in a frame.
    let questions: [(&str, usize, f64, usize, Ask); 6] = [
        ("contact of 50,000 bodies", 50_000, 0.0, 10, nothing),
        ("contact of 2,000 bodies", 2000, 0.0, 1, nothing),
        (
            "contact points of 50,000 bodies",
            50_000,
            0.02,
            10,
            contacts,
        ),
        ("contact points of 1,000 bodies", 1000, 0.02, 1, contacts),
        ("distances of 4,950 pairs", 100, 0.0, 1, all_pairs),
        ("distance of groups, 902,500 pairs", 1900, 0.0, 1, halves),
    ];
    println!("question,budget_us,median,p99,max,max_of_first");
    for (name, count, margin, part, ask) in questions {
        for budget in BUDGETS_US {
            let mut world = World::new(count, margin)?;
            ask(&mut world)?;
            let mut late = Vec::new();
            for _ in 0..frames {
                world.wander(part)?;
                let clock = ProcessorClock(ThreadTime::now());
                let limit = Duration::from_micros(budget);
                world.scene.detect(Budget::time(limit).clock(&clock));
                late.push(1e6 * (clock.now().as_secs_f64() - limit.as_secs_f64()));
            }
            let first = late
                .drain(..FIRST.min(frames))
                .fold(f64::NEG_INFINITY, f64::max);
            late.sort_unstable_by(f64::total_cmp);
            let share = |share: f64| late[((late.len() - 1) as f64 * share) as usize];
            println!(
                "{name:?},{budget},{:.1},{:.1},{:.1},{first:.1}",
                share(0.5),
                share(0.99),
                share(1.0)
            );
        }
    }
    Ok(())
}
