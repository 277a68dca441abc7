//! The same query, stopped by one budget of work after the other.

use punctual::{ResumeError, Stats, StopReason};
use serde_json::{Value, json};

use crate::stage::{Stage, count, percent};

/// What the steps are steps of.
pub const BUDGET: &str = "Budget of work";

/// Steps between no work and all of it.
const RUNGS: u32 = 24;

/// A query that can be stopped and looked at.
pub trait Stepwise {
    type Answer;
    /// Runs it anew, until it has done so much work.
    fn begin(&mut self, until: u64) -> Result<Self::Answer, ResumeError>;
    /// Goes on, until it has done so much work, all that came before included.
    fn resume(&mut self, stopped: &Self::Answer, until: u64) -> Result<Self::Answer, ResumeError>;
    /// Why it stopped, and what it has done.
    fn reached(answer: &Self::Answer) -> (StopReason, Stats);
    /// What is known now: `facts` to be read, and what is to be drawn.
    fn look(&mut self, answer: &Self::Answer, stage: &mut Stage) -> Result<Value, ResumeError>;
}

/// The steps of a query, and the one that knows what `answer` knew.
pub fn climb<Q: Stepwise>(
    query: &mut Q,
    stage: &mut Stage,
    answer: &Q::Answer,
) -> Result<(Vec<Value>, usize), ResumeError> {
    // A memory may have spared a finished answer a part of the work.
    let answered = Some(answer)
        .filter(|answer| goes_on::<Q>(answer))
        .map_or(u64::MAX, |answer| work::<Q>(answer));
    let total = work::<Q>(&query.begin(u64::MAX)?);
    let mut rungs = rungs(total, answered).into_iter();
    let (mut steps, mut start) = (Vec::new(), 0);
    let mut reached = query.begin(0)?;
    loop {
        let (spent, goes_on) = (work::<Q>(&reached), goes_on::<Q>(&reached));
        let mut step = query.look(&reached, stage)?;
        let share = if goes_on {
            spent as f64 / total.max(1) as f64
        } else {
            1.0
        };
        if step["focus"].is_null() {
            step["open"] = stage.focus_on_open();
        }
        step["name"] = json!(format!(
            "{} units, {} of the whole",
            count(spent),
            percent(share)
        ));
        steps.push(step);
        if spent <= answered {
            start = steps.len() - 1;
        }
        if !goes_on {
            return Ok((steps, start));
        }
        reached = query.resume(
            &reached,
            rungs.find(|&rung| rung > spent).unwrap_or(u64::MAX),
        )?;
    }
}

fn work<Q: Stepwise>(answer: &Q::Answer) -> u64 {
    Q::reached(answer).1.work
}

fn goes_on<Q: Stepwise>(answer: &Q::Answer) -> bool {
    matches!(
        Q::reached(answer).0,
        StopReason::WorkLimit | StopReason::Deadline | StopReason::Cancelled
    )
}

/// Budgets in geometric steps, and the one of the answer.
fn rungs(total: u64, answered: u64) -> Vec<u64> {
    let total = total as f64;
    let at = |i: u32| {
        (total
            * (total / 4.0)
                .max(1.0)
                .powf(f64::from(i) / f64::from(RUNGS) - 1.0)) as u64
    };
    let mut rungs: Vec<u64> = (1..RUNGS)
        .map(at)
        .chain([answered])
        .filter(|&rung| rung < total as u64)
        .collect();
    rungs.sort_unstable();
    rungs.dedup();
    rungs
}
