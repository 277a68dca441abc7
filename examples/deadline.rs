//! Predicts a query, runs it within a budget, tells what is left and how sure it is, and goes on if
//! that pays.

use std::error::Error;
use std::time::Duration;

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};

fn main() -> Result<(), Box<dyn Error>> {
    let a = Tree::new(shapes::torus_knot(2, 3, 0.2, 256));
    let b = Tree::new(shapes::gear(32, 8));
    let mut workspace = Workspace::new();
    for x in [0.9, 1.9, 2.74, 2.9] {
        let pose = Pose::new(DMat3::from_rotation_y(0.4), DVec3::new(x, 0.3, 0.1))?;
        let query = Query::intersection(&a, &b, pose);
        let work = query.predict(None).work;
        println!(
            "{x}: {:.0} units of work, {:.0} in nine of ten cases",
            work.p50, work.p90
        );

        let mut answer = query.run(&mut workspace, Budget::time(Duration::from_micros(10)));
        if answer.value == Verdict::Undecided {
            let left = query.remaining(&workspace, None)?;
            let (us, sure) = (left.time.p90 / 1e3, left.probability.unwrap_or_default());
            println!("   stopped: {us:.1} us left in nine of ten cases; contact with {sure:.2}");
            // A probable contact is as good as a proven one to this program; a doubtful one is not.
            if sure < 0.9 {
                answer = query.resume(&mut workspace, Budget::work(left.work.p90 as u64))?;
            }
        }
        println!("   {:?} after {} units", answer.value, answer.stats.work);
    }
    Ok(())
}
