//! Questions of every kind, asked without the clock of the system: whole, or in pieces.

use std::time::Duration;

use punctual::clock::ManualClock;
use punctual::engine::{Ask, Question, Remembers};
use punctual::{Answer, Budget, PairMemory, Query, StopReason, Workspace};

/// A budget that no query uses up. Unlike with [`Budget::unlimited`] the query cannot know that, so it goes about its
/// visits as with any other budget, and a run that was stopped ends in the same bits.
pub const ENOUGH: Budget = Budget::work(u64::MAX);

/// One run.
pub fn run<'t, Q: Question>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    budget: Budget,
) -> Answer<Q::Value>
where
    Query<'t, Q>: Ask<Q>,
{
    query.run(workspace, budget.clock(&ManualClock::new()))
}

/// What a query answers that nothing stops, in a workspace of its own.
pub fn answer<'t, Q: Question>(query: &Query<'t, Q>) -> Answer<Q::Value>
where
    Query<'t, Q>: Ask<Q>,
{
    run(query, &mut Workspace::new(), ENOUGH)
}

/// One run with a memory.
pub fn run_with_memory<'t, Q: Remembers>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    memory: &mut PairMemory,
    budget: Budget,
) -> Answer<Q::Value>
where
    Query<'t, Q>: Ask<Q>,
{
    let clock = ManualClock::new();
    query
        .with_memory(memory)
        .run(workspace, budget.clock(&clock))
}

/// One resumption.
#[track_caller]
pub fn resume<'t, Q: Question>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    budget: Budget,
) -> Answer<Q::Value>
where
    Query<'t, Q>: Ask<Q>,
{
    query
        .resume(workspace, budget.clock(&ManualClock::new()))
        .expect("the workspace holds a stopped run")
}

/// Whether a query goes on with the run in the workspace, of which it then changes a copy only.
pub fn resumes<'t, Q: Question>(query: &Query<'t, Q>, workspace: &Workspace) -> bool
where
    Query<'t, Q>: Ask<Q>,
{
    let clock = ManualClock::new();
    let budget = ENOUGH.clock(&clock);
    query.resume(&mut workspace.clone(), budget).is_ok()
}

/// Runs to the end within one of `pieces` after the other, and shows what is known at each stop.
pub fn run_in_pieces<'t, Q: Question>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    mut pieces: impl FnMut() -> u64,
    mut at_stop: impl FnMut(&Answer<Q::Value>, &mut Workspace),
) -> Answer<Q::Value>
where
    Query<'t, Q>: Ask<Q>,
{
    let mut said = run(query, workspace, Budget::work(pieces()));
    while said.stop == StopReason::WorkLimit {
        at_stop(&said, workspace);
        said = resume(query, workspace, Budget::work(pieces()));
    }
    said
}

/// Runs within growing budgets of a clock that ticks at each look, up to one that is enough: a budget of k ticks ends at look
/// k, and between two looks there is little work besides a step. Shows the answers.
#[track_caller]
pub fn assert_time_is_kept<'t, Q: Question>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    step: u64,
    budgets: impl Iterator<Item = u32>,
    mut check: impl FnMut(&Answer<Q::Value>, &mut Workspace, &ManualClock),
) where
    Query<'t, Q>: Ask<Q>,
{
    let tick = Duration::from_micros(1);
    for ticks in budgets {
        let (clock, time) = (ManualClock::ticking(tick), tick * ticks);
        let budget = Budget::time(time).poll_interval(64);
        let said = query.run(workspace, budget.clock(&clock));
        // Looks are as far apart as the time that is left allows.
        let most_per_look = 64.max(time.as_nanos() as u64) + step;
        let work = said.stats.work;
        assert!(work <= u64::from(ticks + 1) * most_per_look, "{work}");
        check(&said, workspace, &clock);
        if said.stop != StopReason::Deadline {
            return;
        }
        assert!(said.stats.elapsed.unwrap() >= time);
    }
}
