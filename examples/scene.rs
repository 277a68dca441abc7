//! Which of 100 gears touch? 60,000 units of work a frame.

use std::error::Error;
use std::sync::Arc;

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Tree, shapes};
use punctual_scene::{Body, ContactPhase, Scene};

fn main() -> Result<(), Box<dyn Error>> {
    let gear = Arc::new(Tree::new(shapes::gear(17, 6)));
    let mut scene = Scene::new();
    scene.track_contacts();
    let bodies = (0..100)
        .map(|_| scene.insert(Body::moving(Arc::clone(&gear), Pose::IDENTITY)))
        .collect::<Result<Vec<_>, _>>()?;

    for frame in 0..60 {
        let time = f64::from(frame) / 60.0;
        for (i, &id) in bodies.iter().enumerate() {
            let (column, row) = ((i % 10) as f64, (i / 10) as f64);
            let place = DVec3::new(1.9 * column, 1.9 * row, (column + row + time).sin());
            scene.set_pose(
                id,
                Pose::new(DMat3::from_rotation_z(time + i as f64), place)?,
            )?;
        }
        let report = scene.detect(Budget::work(60_000));
        let count = |phase| report.contacts.iter().filter(|c| c.phase == phase).count();
        if frame % 10 == 0 {
            let (touch, undecided) = (report.intersecting, report.undecided());
            let (began, ended) = (count(ContactPhase::Began), count(ContactPhase::Ended));
            println!(
                "frame {frame}: {touch} pairs touch, {undecided} are undecided; {began} contacts began, {ended} ended"
            );
        }
    }
    Ok(())
}
