//! Scenes with more to do than a frame can: `cargo bench -p punctual-benches --bench crowded [-- PLAYS]` (default 5).
//!
//! Balls of radius 1, all of them in one place, at rest or moving, or 5 units of volume to a ball, and every question that a
//! scene can be asked about them. Printed is how much CPU time frames take beyond their budgets: median, p99 and worst over the
//! frames, each by the median of its plays; p99 of all; and how many pairs a frame decides.

use std::sync::Arc;
use std::time::Duration;

use cpu_time::ThreadTime;
use oorandom::Rand64;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Motion, Pose, Tree, shapes};
use punctual_scene::{Body, BodyId, Scene};

const FRAMES: usize = 300;

#[derive(Clone, Copy, PartialEq)]
enum Question {
    Meet,
    /// Contacts within a skin of .04.
    Contacts,
    /// All distances among the first 100 bodies.
    Distances,
    /// The distance between the first and the last 950.
    Groups,
    /// Times of impact.
    Motions,
    /// All of these.
    All,
}

impl Question {
    fn has(self, part: Self) -> bool {
        self == part || self == Self::All
    }

    /// Asks it of a scene.
    fn ask(self, scene: &mut Scene, ids: &[BodyId]) {
        if self.has(Self::Contacts) {
            scene.find_contacts();
            for &id in ids {
                scene.set_margin(id, 0.02).expect("a length");
            }
        }
        let few = &ids[..100];
        for (at, &x) in few.iter().enumerate().filter(|_| self.has(Self::Distances)) {
            for &y in &few[..at] {
                scene.measure(x, y, 1e-3).expect("two bodies");
            }
        }
        if self.has(Self::Groups) {
            let (x, y) = (&ids[..950], &ids[ids.len() - 950..]);
            scene.measure_groups(x, y, 1e-3).expect("two groups");
        }
    }
}

struct Crowd {
    name: &'static str,
    bodies: usize,
    wall: f64,
    speed: f64,
    question: Question,
}

fn at(place: DVec3) -> Pose {
    Pose::new(DMat3::IDENTITY, place).expect("a shift is a pose")
}

/// One play: microseconds beyond the budget of each frame, and the pairs that all of them decided.
fn play(crowd: &Crowd, budget: Duration) -> (Vec<f64>, usize) {
    let Crowd {
        bodies,
        wall,
        speed,
        question,
        ..
    } = *crowd;
    let ball = Arc::new(Tree::new(shapes::icosphere(2)));
    let mut random = Rand64::new(1);
    let mut vector =
        |scale: f64| scale * DVec3::from_array([(); 3].map(|()| 2.0 * random.rand_float() - 1.0));
    let mut moving: Vec<(DVec3, DVec3)> =
        (0..bodies).map(|_| (vector(wall), vector(speed))).collect();
    let mut scene = Scene::new();
    let insert =
        |(place, _): &(DVec3, DVec3)| scene.insert(Body::moving(Arc::clone(&ball), at(*place)));
    let ids: Vec<_> = moving
        .iter()
        .map(insert)
        .collect::<Result<_, _>>()
        .expect("all are sound");
    question.ask(&mut scene, &ids);
    let (mut late, mut decided) = (Vec::with_capacity(FRAMES), 0);
    for _ in 0..FRAMES {
        let began = ThreadTime::now();
        decided += scene.detect(Budget::time(budget)).decided;
        late.push(1e6 * (began.elapsed().as_secs_f64() - budget.as_secs_f64()).max(0.0));
        for ((place, velocity), id) in moving.iter_mut().zip(&ids) {
            *place += *velocity;
            if place.abs().max_element() > wall {
                *velocity = -*velocity;
            }
            if question.has(Question::Motions) {
                let motion = Motion::straight(at(*place), *velocity).expect("a sound motion");
                scene.set_motion(*id, motion)
            } else {
                scene.set_pose(*id, at(*place))
            }
            .expect("it is in the scene");
        }
    }
    (late, decided)
}

/// The value below which a `part` of all lies.
fn quantile(mut values: Vec<f64>, part: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[(values.len() as f64 * part) as usize]
}

fn main() {
    let plays = std::env::args().find_map(|argument| argument.parse().ok());
    let plays = plays.unwrap_or(5);
    println!("us of CPU time past the budget   median   p99   worst   p99 of all   pairs decided");
    use Question::{All, Contacts, Distances, Groups, Meet, Motions};
    let room = |bodies: usize| 0.5 * (20.0 * bodies as f64).cbrt();
    let crowds = [
        ("2,000 in one place, at rest", 2_000, 0.0, 0.0, Meet),
        ("2,000 in one place", 2_000, 0.1, 0.01, Meet),
        ("10,000", 10_000, room(10_000), 0.02, Meet),
        ("50,000", 50_000, room(50_000), 0.02, Meet),
        ("50,000, contacts", 50_000, room(50_000), 0.02, Contacts),
        (
            "50,000, 4,950 distances",
            50_000,
            room(50_000),
            0.02,
            Distances,
        ),
        ("50,000, groups", 50_000, room(50_000), 0.02, Groups),
        ("50,000, motions", 50_000, room(50_000), 0.02, Motions),
        ("2,000, all questions", 2_000, room(2_000), 0.02, All),
    ];
    for budget in [200, 1_000].map(Duration::from_micros) {
        for (name, bodies, wall, speed, question) in crowds {
            let crowd = Crowd {
                name,
                bodies,
                wall,
                speed,
                question,
            };
            report(&crowd, plays, budget);
        }
    }
}

fn report(crowd: &Crowd, plays: usize, budget: Duration) {
    let results: Vec<_> = (0..plays).map(|_| play(crowd, budget)).collect();
    let by_median =
        |frame: usize| quantile(results.iter().map(|(late, _)| late[frame]).collect(), 0.5);
    let frames: Vec<f64> = (0..FRAMES).map(by_median).collect();
    let worst = frames.iter().copied().fold(0.0, f64::max);
    let all = results.iter().flat_map(|(late, _)| late.iter().copied());
    let of_all = quantile(all.collect(), 0.99);
    let decided = results.iter().map(|&(_, decided)| decided).sum::<usize>() / (plays * FRAMES);
    let [median, p99] = [0.5, 0.99].map(|part| quantile(frames.clone(), part));
    println!(
        "{:<28} {budget:>6.1?} {median:>6.1} {p99:>5.1} {worst:>7.1} {of_all:>12.1} {decided:>12}",
        crowd.name
    );
}
