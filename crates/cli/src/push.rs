//! The lines of kind push of `punctual contacts`: which way, and how far, B has to be moved until it is free.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use punctual::clock::SystemClock;
use punctual::{Budget, Pose, Tree, Workspace};
use punctual_depenetrate::{PushOut, PushOutQuery};

/// What was found at a pose, and the time it took.
pub struct Answer {
    found: PushOut,
    pub time: Duration,
}

impl Answer {
    /// The shortest push found within a budget.
    pub fn of(
        [a, b]: [&Tree; 2],
        pose: &Pose,
        workspace: &mut Workspace,
        budget: Budget,
        clock: &SystemClock,
    ) -> Self {
        let start = Instant::now();
        let found = PushOutQuery::new(a, b, *pose).run(workspace, budget.clock(clock));
        Self {
            found,
            time: start.elapsed(),
        }
    }

    /// n is the direction in which B moves, and distance how far; both are empty where the budget ended before a push was
    /// found.
    pub fn print(&self, out: &mut impl Write, pose: usize) -> io::Result<()> {
        let PushOut { push, stop, .. } = self.found;
        let of_push = push.map(|push| {
            let n = push.direction;
            format!("{},{},{},{}", n.x, n.y, n.z, push.distance)
        });
        let of_push = of_push.unwrap_or_else(|| ",,,".into());
        writeln!(
            out,
            "{pose},push,,,,,,,,,,{of_push},,{},{stop}",
            self.time.as_nanos()
        )
    }
}
