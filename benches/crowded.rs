//! Scenes with more to do than a frame can: `cargo bench -p punctual-benches --bench crowded`.
//!
//! Balls of radius 1, all of them in one place, at rest or moving, or 5 units of volume to a ball. Printed is how much CPU time
//! frames take beyond their budgets (p99 and worst over the frames, each by the median of its plays, and p99 of all), and how
//! many pairs a frame decides.

use std::sync::Arc;
use std::time::Duration;

use cpu_time::ThreadTime;
use oorandom::Rand64;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Tree, shapes};
use punctual_scene::{Body, Scene};

const PLAYS: usize = 5;
const FRAMES: usize = 300;

fn at(place: DVec3) -> Pose {
    Pose::new(DMat3::IDENTITY, place).expect("a shift is a pose")
}

/// One play: microseconds beyond the budget of each frame, and the pairs that all of them decided.
fn play(bodies: usize, wall: f64, speed: f64, budget: Duration) -> (Vec<f64>, usize) {
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
            scene.set_pose(*id, at(*place)).expect("it is in the scene");
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
    println!("us of CPU time past the budget   p99   worst   p99 of all   pairs decided a frame");
    let crowds = [
        ("2,000 in one place, at rest", 2_000, 0.0, 0.0),
        ("2,000 in one place, moving", 2_000, 0.1, 0.01),
        ("10,000 moving", 10_000, 0.5 * 200_000_f64.cbrt(), 0.02),
        ("50,000 moving", 50_000, 0.5 * 1_000_000_f64.cbrt(), 0.02),
    ];
    for budget in [200, 1_000].map(Duration::from_micros) {
        for (name, bodies, wall, speed) in crowds {
            let plays: Vec<_> = (0..PLAYS)
                .map(|_| play(bodies, wall, speed, budget))
                .collect();
            let by_median =
                |frame: usize| quantile(plays.iter().map(|(late, _)| late[frame]).collect(), 0.5);
            let frames: Vec<f64> = (0..FRAMES).map(by_median).collect();
            let worst = frames.iter().copied().fold(0.0, f64::max);
            let all = plays
                .iter()
                .flat_map(|(late, _)| late.iter().copied())
                .collect();
            let decided =
                plays.iter().map(|&(_, decided)| decided).sum::<usize>() / (PLAYS * FRAMES);
            let [p99, of_all] = [frames, all].map(|values| quantile(values, 0.99));
            println!(
                "{name:<28} {budget:>6.1?} {p99:>5.1} {worst:>7.1} {of_all:>12.1} {decided:>23}"
            );
        }
    }
}
