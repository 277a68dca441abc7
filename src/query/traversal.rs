//! The one loop over node pairs, its stop rule and its guarantee.
//!
//! Every query runs through [`Traversal::advance`], whatever its question ([`Visitor`]):
//! intersection ([`meeting`]), distance or contacts ([`nearest`]), time of impact ([`motion`]), or
//! ray casts ([`ray`]); with and without a budget, in every order. Each turn does one step of
//! bounded work: it tests triangle pairs, or opens a node pair of the front ([`expand`]). Before
//! each step the deadline may end the call. Everything not done by then is still in the buffers:
//!
//! **Guarantee.** At every moment each pair of triangles that matters to the question has been
//! taken into account, or waits, or is in doubt, or lies under a pair of the front. So empty
//! buffers prove that nothing was missed. A stopped run can bound what may be missing and continue
//! later as if it had never stopped.
//!
//! [`expand`]: super::expand
//! [`meeting`]: super::meeting
//! [`motion`]: super::motion
//! [`nearest`]: super::nearest
//! [`ray`]: super::ray

use super::boxes::Keys;
use super::corners::Corners;
use super::deadline::Deadline;
use super::flushing;
use super::outcome::StopReason;
use super::queue::{Origin, Pair};
use super::strategy::Strategy;
use super::views::Relation;
use super::workspace::Workspace;
use crate::tree::{Tree, WIDTH};
use punctual_geom::Pose;
use punctual_geom::lanes::{Kernel, Lanes};

/// One call of a query that asks `Q`.
pub(super) struct Traversal<'q, 'c, Q> {
    pub question: Q,
    pub a: &'q Tree,
    pub b: &'q Tree,
    pub b_in_a: &'q Pose,
    pub strategy: Strategy,
    pub relation: &'q Relation,
    pub workspace: &'q mut Workspace,
    pub deadline: &'q mut Deadline<'c>,
    pub keys: Keys,
    /// Where the current pair comes from.
    pub origin: Origin,
}

/// The operations that a question supplies to the loop.
pub(super) trait Visitor {
    /// True if the loop must check whether flushing of denormal numbers matters for the trees and
    /// the pose.
    const ASKS_OF_FLUSHING: bool = true;

    /// Takes the next pair to open.
    fn next_pair(&mut self) -> Option<(Pair, Origin)>;

    /// Replaces the pair by those pairs of its children that matter. Drops it if it no longer
    /// matters.
    fn open<L: Lanes>(&mut self, lanes: L, pair: Pair);

    /// True if triangle pairs wait for a test: a full batch, or `any` at all.
    fn waits(&self, any: bool) -> bool;

    /// Does one step of tests. Returns a reason if the run ends with it.
    fn test<L: Lanes>(&mut self, lanes: L) -> Option<StopReason>;
}

impl<'q, 'c, Q> Traversal<'q, 'c, Q>
where
    Traversal<'q, 'c, Q>: Visitor,
{
    /// A call that continues the run in the workspace.
    #[inline(always)]
    pub fn new(
        question: Q,
        [a, b]: [&'q Tree; 2],
        b_in_a: &'q Pose,
        relation: &'q Relation,
        workspace: &'q mut Workspace,
        deadline: &'q mut Deadline<'c>,
    ) -> Self {
        let (strategy, keys, origin) =
            (workspace.run.strategy, [[0.0; WIDTH]; WIDTH], Origin::Stack);
        Self {
            question,
            a,
            b,
            b_in_a,
            strategy,
            relation,
            workspace,
            deadline,
            keys,
            origin,
        }
    }

    /// Continues until the run is over or the deadline stops it.
    pub fn advance(mut self) -> StopReason {
        if Self::ASKS_OF_FLUSHING && flushing::matters(self.a, self.b, self.b_in_a) {
            self.workspace.run.stopped = true;
            return StopReason::FlushedToZero;
        }
        self.workspace.corners.iter_mut().for_each(Corners::clear);
        self.deadline.begin(self.workspace.run.stats.work);
        let stop = self.workspace.instructions.run(&mut self);
        self.deadline.end(self.workspace.run.stats.work);
        self.workspace.run.stopped = !stop.is_final();
        stop
    }
}

impl<'q, 'c, Q> Kernel for &mut Traversal<'q, 'c, Q>
where
    Traversal<'q, 'c, Q>: Visitor,
{
    type Output = StopReason;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> StopReason {
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
                self.open(lanes, pair);
                self.workspace.testing = self.waits(false);
            } else if self.waits(true) {
                self.workspace.testing = true;
            } else {
                return StopReason::Finished;
            }
        }
    }
}
