//! The one loop over node pairs, its stop rule and its guarantee.
//!
//! Every question ([`Visitor`]) about node pairs runs through [`traverse`], with and without a
//! budget, in every order: intersection ([`meeting`]), distance and contacts ([`nearest`]), time of
//! impact ([`motion`]), ray casts ([`ray`]), points ([`point`]) and containment ([`contained`]).
//! Two questions have a loop of their own beside it, under the same deadline. Manifolds step
//! through the overlaps after the contacts ([`overlaps`]). A motion ([`motion`]) goes from substep
//! to substep, and skips those that its bounds prove free.
//!
//! Each iteration does one step of bounded work: it tests triangle pairs, or opens a node pair of
//! the frontier ([`expand`]). Before each step the deadline may end the call. Everything not done
//! by then is still in the buffers:
//!
//! **Guarantee.** At every moment each pair of triangles that matters to the question has been
//! taken into account, or waits, or is in doubt, or lies under a pair of the frontier. So empty
//! buffers prove that nothing was missed. A stopped run can bound what may be missing and continue
//! later as if it had never stopped.
//!
//! [`contained`]: crate::query::points::contained
//! [`expand`]: super::expand
//! [`meeting`]: crate::query::intersection::meeting
//! [`motion`]: crate::query::motion
//! [`nearest`]: crate::query::distance::nearest
//! [`overlaps`]: crate::query::manifolds::overlaps
//! [`point`]: crate::query::points
//! [`ray`]: crate::query::rays

use super::boxes::{RelativePose, flushing};
use super::deadline::Deadline;
use super::expand::Scratch;
use super::frontier::{Origin, Pair};
use super::outcome::StopReason;
use super::strategy::Strategy;
use super::triangles::corners::Corners;
use super::workspace::Workspace;
use crate::tree::Tree;
use punctual_geom::Pose;
use punctual_geom::lanes::{Kernel, Lanes};

/// One call of a query that asks `Q`. `POINTS` is true if one of the trees is that of a cloud,
/// whose leaves are not stored: all code is compiled once more for them, so that meshes pay
/// nothing.
pub(crate) struct Traversal<'q, 'c, Q, const POINTS: bool = false> {
    pub question: Q,
    pub a: &'q Tree,
    pub b: &'q Tree,
    pub b_in_a: &'q Pose,
    pub strategy: Strategy,
    pub relative: &'q RelativePose,
    pub workspace: &'q mut Workspace,
    pub deadline: &'q mut Deadline<'c>,
    /// Where the current pair comes from.
    pub origin: Origin,
    /// The factor from the depths of its children to their keys, if the pair is from the queue.
    pub share: f32,
}

/// The operations that a question supplies to the loop.
pub(crate) trait Visitor {
    /// True if the loop must check whether flushing of denormal numbers matters for the trees and
    /// the pose.
    const ASKS_OF_FLUSHING: bool = true;

    /// Takes the next pair to open.
    fn next_pair(&mut self) -> Option<(Pair, Origin)>;

    /// Replaces the pair by those pairs of its children that matter. Drops it if it no longer
    /// matters.
    fn open<L: Lanes>(&mut self, lanes: L, pair: Pair, scratch: &mut Scratch);

    /// True if triangle pairs wait for a test: a full batch, or `any` at all.
    fn waits(&self, any: bool) -> bool;

    /// Does one step of tests. Returns a reason if the run ends with it.
    fn test<L: Lanes>(&mut self, lanes: L) -> Option<StopReason>;
}

/// Continues the run in the workspace, which asks `question`, until it is over or the deadline
/// stops it.
pub(crate) fn traverse<'q, 'c, Q>(
    question: Q,
    trees: [&'q Tree; 2],
    b_in_a: &'q Pose,
    relative: &'q RelativePose,
    workspace: &'q mut Workspace,
    deadline: &'q mut Deadline<'c>,
) -> StopReason
where
    Traversal<'q, 'c, Q, false>: Visitor,
    Traversal<'q, 'c, Q, true>: Visitor,
{
    if trees[0].is_cloud() || trees[1].is_cloud() {
        traverse_of::<Q, true>(question, trees, b_in_a, relative, workspace, deadline)
    } else {
        traverse_of::<Q, false>(question, trees, b_in_a, relative, workspace, deadline)
    }
}

/// [`traverse`] for trees of which one is that of a cloud (`POINTS`), or none.
pub(crate) fn traverse_of<'q, 'c, Q, const POINTS: bool>(
    question: Q,
    [a, b]: [&'q Tree; 2],
    b_in_a: &'q Pose,
    relative: &'q RelativePose,
    workspace: &'q mut Workspace,
    deadline: &'q mut Deadline<'c>,
) -> StopReason
where
    Traversal<'q, 'c, Q, POINTS>: Visitor,
{
    if Traversal::<Q, POINTS>::ASKS_OF_FLUSHING && flushing::matters(a, b, b_in_a) {
        workspace.run.stopped = true;
        return StopReason::FlushedToZero;
    }
    workspace.corners.iter_mut().for_each(Corners::clear);
    deadline.begin(workspace.run.stats.work);
    let mut traversal = Traversal::<Q, POINTS> {
        question,
        a,
        b,
        b_in_a,
        strategy: workspace.run.strategy,
        relative,
        workspace,
        deadline,
        origin: Origin::Stack,
        share: 0.0,
    };
    let stop = traversal.workspace.instructions.run(&mut traversal);
    let Traversal {
        workspace,
        deadline,
        ..
    } = traversal;
    deadline.end(workspace.run.stats.work);
    workspace.run.stopped = !stop.is_final();
    stop
}

impl<'q, 'c, Q, const POINTS: bool> Kernel for &mut Traversal<'q, 'c, Q, POINTS>
where
    Traversal<'q, 'c, Q, POINTS>: Visitor,
{
    type Output = StopReason;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> StopReason {
        let mut scratch = Scratch::default();
        loop {
            if let Some(reason) = self.deadline.stop(self.workspace.run.stats.work) {
                return if self.workspace.is_done() {
                    StopReason::Finished
                } else {
                    reason
                };
            }
            if self.workspace.testing {
                if let Some(reason) = self.test(lanes) {
                    return reason;
                }
            } else if let Some((pair, origin)) = self.next_pair() {
                self.origin = origin;
                self.open(lanes, pair, &mut scratch);
                self.workspace.testing = self.waits(false);
            } else if self.waits(true) {
                self.workspace.testing = true;
            } else {
                return StopReason::Finished;
            }
        }
    }
}
