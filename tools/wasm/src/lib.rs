//! What `tests/platforms` asks, for a WebAssembly runtime: see `run.mjs`.

extern crate alloc;

#[path = "../../../tests/platforms/answers.rs"]
mod answers;
#[path = "../../../tests/platforms/questions.rs"]
mod questions;

use punctual::{Budget, Pose, Query, StopReason, Tree, Workspace, shapes};
use std::time::Duration;

/// Where the hashes are in memory, after their length in bytes as four bytes.
#[unsafe(no_mangle)]
pub extern "C" fn answers() -> *const u8 {
    let text = answers::answers(&Workspace::new());
    let bytes = [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    Vec::leak(bytes).as_ptr()
}

/// Whether a call that is handed no clock does nothing with a budget of time, and goes on with one of work.
#[unsafe(no_mangle)]
pub extern "C" fn has_no_time() -> bool {
    let ball = Tree::new(shapes::icosphere(3));
    let query = Query::intersection(&ball, &ball, Pose::IDENTITY);
    let mut workspace = Workspace::new();
    let stopped = query.run(&mut workspace, Budget::time(Duration::from_secs(1)));
    let whole = query.resume(&mut workspace, Budget::work(1 << 40));
    stopped.stop == StopReason::Deadline
        && stopped.stats.work == 0
        && whole.is_ok_and(|whole| whole.stats.found == 1)
}
