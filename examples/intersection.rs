//! Do two meshes intersect, as far as 50 microseconds tell?

use std::error::Error;
use std::time::Duration;

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};

fn main() -> Result<(), Box<dyn Error>> {
    let knot = Tree::new(shapes::torus_knot(2, 3, 0.2, 128));
    let gear = Tree::new(shapes::gear(17, 6));
    println!("{} and {} triangles", knot.mesh().len(), gear.mesh().len());

    let mut workspace = Workspace::new();
    for step in 0..8 {
        let x = 3.5 - 0.4 * f64::from(step);
        let gear_in_knot = Pose::new(DMat3::IDENTITY, DVec3::new(x, 0.0, 0.0))?;
        let query = Query::intersection(&knot, &gear, gear_in_knot);
        let outcome = query.run(&mut workspace, Budget::time(Duration::from_micros(50)));
        match outcome.value {
            Verdict::Separated => println!("gear at {x:.1}: no contact"),
            Verdict::Undecided => {
                let estimate = query.estimate(&workspace, None)?;
                println!(
                    "gear at {x:.1}: contact with probability {:.2}",
                    estimate.probability
                );
            }
            meeting => {
                let [a, b] = meeting
                    .witness()
                    .expect("surfaces that meet have a witness");
                println!("gear at {x:.1}: triangle {a} of the knot meets {b} of the gear");
            }
        }
    }
    Ok(())
}
