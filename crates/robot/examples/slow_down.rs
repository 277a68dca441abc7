//! An arm with seven joints that sweeps towards a post, proves in each millisecond more of its way,
//! and goes no faster than it can stop where its way is proven:
//! `slow_down [ROBOT.urdf [ROBOT.srdf]]`.
//!
//! The budget of a cycle is 200 us. What it does not prove counts as not free, so a busy machine
//! makes the arm slower, never unsafe.

use std::error::Error;
use std::time::{Duration, Instant};

use punctual::{Budget, Pose, glam::DMat3};
use punctual_robot::{
    Checker, ClearanceOptions, Collision, Horizon, Margin, Model, Shape, Trajectory, UrdfOptions,
    braking_time,
};

const CYCLE: f64 = 0.001;

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

    // The arm stops 5 mm before anything, and where it is not proven free.
    checker.set_margin(Margin::All, 0.005)?;
    // The first joint turns at 1 rad/s, the others hold the arm stretched out and bent.
    let mut q: Vec<f64> = [-0.5, 1.2, 0.3, 0.4, 0.0, 0.2, 0.0].into();
    q.resize(joints, 0.0);
    if let Collision::Contact(pair) = checker.collide(&q, Budget::unlimited())?.value {
        let names = pair.map(|id| checker.name(id).unwrap_or_default());
        return Err(format!("{} meet at the start", names.join(" and ")).into());
    }
    let velocity: Vec<f64> = (0..joints).map(|i| f64::from(i == 0)).collect();
    let mut plan = Trajectory::default();
    plan.push(3.0, &[&q, &velocity])?;
    let braking = braking_time(&velocity, &vec![10.0; joints]);
    let mut horizon = Horizon::new(CYCLE, braking)?;
    let (mut new, mut speed, mut late) = (Some(&plan), 0f64, 0);
    for cycle in 0..3_000 {
        let start = Instant::now();
        let budget = Budget::time(Duration::from_micros(200));
        let ahead = horizon.step(&mut checker, new.take(), budget)?.value;
        late += u32::from(start.elapsed() > Duration::from_micros(250));
        speed = ahead.speed;
        if cycle % 250 == 0 {
            let free_for = ahead.free_until - ahead.time;
            println!("{cycle:4} ms: {speed:.3} of the speed, free for {free_for:.3} s");
        }
        q = plan.at(ahead.time);
    }
    let options = ClearanceOptions::default();
    let rest = checker.clearance(&q, &options, Budget::unlimited())?.value;
    let verdict = checker.collide(&q, Budget::unlimited())?.value;
    let gap = rest.low * 1e3;
    println!("at rest at {:.3} rad, {gap:.2} mm above its margin", q[0]);
    println!("{late} of 3000 cycles took more than 250 us, as the system has other work too");
    assert!(verdict == Collision::Free);
    // The arm of this folder comes to the post.
    assert!(file.is_some() || (speed < 0.05 && gap < 10.0));
    Ok(())
}
