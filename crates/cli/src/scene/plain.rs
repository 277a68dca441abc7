//! The simplest rival of a scene: boxes sorted along x, then one query after another where two overlap. Nothing is
//! remembered.

use punctual::{Budget, Clock, Query, Verdict, Workspace};
use punctual_lab::report::Failure;
use punctual_scene::{BodyKind, Scene};

use super::play::FrameRow;

/// Decides pairs of bodies until the budget ends. Counts only those that it came to.
pub fn detect(
    scene: &Scene,
    workspace: &mut Workspace,
    budget: Budget,
    clock: &dyn Clock,
) -> Result<FrameRow, Failure> {
    let (start, mut row) = (clock.now(), FrameRow::default());
    let bodies = scene.bodies().map(|(_, body)| body);
    let mut bodies: Vec<_> = bodies
        .map(|body| (body.tree.aabb_at(&body.pose), body))
        .collect();
    bodies.sort_unstable_by(|(a, _), (b, _)| a.min.x.total_cmp(&b.min.x));
    for (index, (bounds, a)) in bodies.iter().enumerate() {
        let to_a = a.pose.inverse()?;
        let others = bodies[index + 1..].iter();
        let near = others.take_while(|(other, _)| other.min.x <= bounds.max.x);
        for (_, b) in near.filter(|(other, _)| other.intersects(bounds)) {
            if [a.kind, b.kind] == [BodyKind::Fixed; 2] {
                continue;
            }
            let left = match (budget.time_limit(), budget.work_limit()) {
                (Some(limit), _) => Budget::time((start + limit).saturating_sub(clock.now())),
                (None, Some(limit)) => Budget::work(limit.saturating_sub(row.work)),
                (None, None) => budget,
            };
            let query = Query::intersection(&a.tree, &b.tree, to_a.compose(&b.pose)?);
            let answer = query.run(workspace, left.clock(clock));
            row.broad_pairs += 1;
            row.bv_tests += answer.stats.bv_tests;
            row.work += answer.stats.work;
            if answer.value == Verdict::Undecided {
                return Ok(row);
            }
            row.decided += 1;
            row.hits += usize::from(answer.value.meets());
        }
    }
    Ok(row)
}
