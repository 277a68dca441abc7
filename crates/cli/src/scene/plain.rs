//! The simplest rival of a scene: boxes sorted along x, then one query after another where two overlap. Nothing is
//! remembered.

use punctual::{Budget, Clock, Query, Workspace};
use punctual_lab::report::Failure;
use punctual_scene::{BodyKind, Scene};

use super::play::FrameRow;

/// Pairs between two looks at the clock, which take longer than the shortest queries.
const PAIRS_PER_LOOK: usize = 8;

/// Decides pairs of bodies until the budget ends, and counts only those.
pub fn detect(
    scene: &Scene,
    workspace: &mut Workspace,
    budget: Budget,
    clock: &dyn Clock,
) -> Result<FrameRow, Failure> {
    let end = budget.time_limit().map(|limit| clock.now() + limit);
    let mut row = FrameRow::default();
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
            let looks = row.decided.is_multiple_of(PAIRS_PER_LOOK);
            let is_late = looks && end.is_some_and(|end| clock.now() >= end);
            if is_late || budget.work_limit().is_some_and(|limit| row.work >= limit) {
                row.broad_pairs += 1;
                return Ok(row);
            }
            let query = Query::intersection(&a.tree, &b.tree, to_a.compose(&b.pose)?);
            let answer = query.run(workspace, Budget::unlimited());
            row.broad_pairs += 1;
            row.decided += 1;
            row.hits += usize::from(answer.value.meets());
            row.bv_tests += answer.stats.bv_tests;
            row.work += answer.stats.work;
        }
    }
    Ok(row)
}
