//! An arm with seven joints that sweeps towards a post, asks in each millisecond how long it would
//! stay free, and goes no faster than it can stop in that time:
//! `slow_down [ROBOT.urdf [ROBOT.srdf]]`.
//!
//! The budget of a cycle is 200 us. What it does not prove counts as not free, so a busy machine
//! makes the arm slower, never unsafe.

use std::error::Error;
use std::time::{Duration, Instant};

use punctual::{Budget, Pose, glam::DMat3};
use punctual_robot::{
    Checker, ClearanceOptions, Collision, Model, Shape, UrdfOptions, braking_time, safe_speed,
};

const CYCLE: f64 = 0.001;
const HORIZON: f64 = 0.2;

fn main() -> Result<(), Box<dyn Error>> {
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/arm7.urdf");
    let file = std::env::args().nth(1);
    let mut options = UrdfOptions::default();
    options.srdf = std::env::args().nth(2).map(Into::into);
    let model = Model::from_urdf(file.as_deref().unwrap_or(own), &options)?;
    let joints = model.joint_names().len();
    let mut checker = Checker::new(model.into());
    let place = Pose::new(DMat3::IDENTITY, [0.35, 0.45, 0.5])?;
    checker.add("post", place, Shape::cylinder(0.05, 1.0)?)?;

    // The first joint turns at 1 rad/s, the others hold the arm stretched out and bent.
    let mut q: Vec<f64> = [-0.5, 1.2, 0.3, 0.4, 0.0, 0.2, 0.0].into();
    q.resize(joints, 0.0);
    if let Collision::Contact(pair) = checker.collide(&q, Budget::unlimited())?.value {
        let names = pair.map(|id| checker.name(id).unwrap_or_default());
        return Err(format!("{} meet at the start", names.join(" and ")).into());
    }
    let velocity: Vec<f64> = (0..joints).map(|i| f64::from(i == 0)).collect();
    let braking = braking_time(&velocity, &vec![10.0; joints]);
    // The share of the speed, and how long the arm is proven free from now on.
    let (mut speed, mut free_for, mut late) = (0f64, 0f64, 0);
    for cycle in 0..3_000 {
        let start = Instant::now();
        let budget = Budget::time(Duration::from_micros(200));
        let ahead = checker.horizon(&q, &velocity, HORIZON, budget)?.value;
        late += u32::from(start.elapsed() > Duration::from_micros(250));
        // What was proven before remains true, so the arm can always brake as it planned.
        free_for = ahead.free_until.max(free_for);
        let change = CYCLE / braking;
        let allowed = safe_speed(free_for, CYCLE, braking);
        speed = (speed + change).min(allowed.max(speed - change));
        if cycle % 250 == 0 {
            println!("{cycle:4} ms: {speed:.3} of the speed, free for {free_for:.3} s");
        }
        for (q, v) in q.iter_mut().zip(&velocity) {
            *q += speed * v * CYCLE;
        }
        free_for = (free_for - speed * CYCLE).max(0.0);
    }
    let options = ClearanceOptions::default();
    let rest = checker.clearance(&q, &options, Budget::unlimited())?.value;
    let verdict = checker.collide(&q, Budget::unlimited())?.value;
    let gap = rest.low * 1e3;
    println!("at rest at {:.3} rad, {gap:.2} mm before contact", q[0]);
    println!("{late} of 3000 cycles took more than 250 us, as the system has other work too");
    assert!(verdict == Collision::Free);
    // The arm of this folder comes to the post.
    assert!(file.is_some() || (speed < 0.05 && gap < 10.0));
    Ok(())
}
