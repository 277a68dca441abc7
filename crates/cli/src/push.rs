//! The lines of kind push of `punctual contacts`: which way, and how far, B has to be moved until it is free.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use punctual::clock::SystemClock;
use punctual::glam::DVec3;
use punctual::{Budget, Pose, Tree};
use punctual_depenetrate::{Penetration, PenetrationQuery, PenetrationWorkspace};

/// What was found at a pose, and the time it took.
pub struct Answer {
    found: punctual::Answer<Penetration>,
    pub time: Duration,
}

impl Answer {
    /// The shortest push found within a budget.
    pub fn of(
        [a, b]: [&Tree; 2],
        pose: &Pose,
        workspace: &mut PenetrationWorkspace,
        budget: Budget,
        clock: &SystemClock,
    ) -> Self {
        let start = Instant::now();
        let query = PenetrationQuery::new(a, b, *pose).push_only(true);
        let found = query.run(workspace, budget.clock(clock));
        Self {
            found,
            time: start.elapsed(),
        }
    }

    /// n is the direction in which B moves, and distance how far; both are empty where the budget ended before a push was
    /// found.
    pub fn print(&self, out: &mut impl Write, pose: usize) -> io::Result<()> {
        let (
            Penetration {
                high, direction, ..
            },
            stop,
        ) = (self.found.value, self.found.stop);
        let n = direction.unwrap_or(DVec3::X);
        let of_push = if high < f64::INFINITY {
            format!("{},{},{},{high}", n.x, n.y, n.z)
        } else {
            ",,,".into()
        };
        writeln!(
            out,
            "{pose},push,,,,,,,,,,{of_push},,{},{stop}",
            self.time.as_nanos()
        )
    }
}
