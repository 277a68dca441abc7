//! Containment: is one solid inside the other, although their surfaces do not meet?
//!
//! Where surfaces do not meet, each component of a solid is inside the other or outside as a whole,
//! so one vertex of each decides. A vertex inside proves that the solids meet whether or not their
//! surfaces do. The vertices are points of [`points`](super), asked within the run of the pair.
//!
//! Only closed solids contain something. A vertex outside of the other mesh's box takes no ray.

use super::{Locate, Source, begin_samples};
use crate::engine::boxes::{RelativePose, flushing};
use crate::engine::deadline::Deadline;
use crate::engine::outcome::{Operand, StopReason};
use crate::engine::question::Query;
use crate::engine::traversal::traverse_of;
use crate::engine::workspace::{Containment, Workspace};
use crate::tree::Tree;
use core::mem;
use punctual_geom::Pose;

impl<Q> Query<'_, Q> {
    /// Asks about the surfaces only, also if both trees are solids: a body inside the other then
    /// does not meet it.
    #[must_use]
    pub fn surfaces(mut self) -> Self {
        self.solids = false;
        self
    }

    /// True if one body may contain the other.
    #[must_use]
    pub fn may_contain(&self) -> bool {
        self.solids && (may_hold(self.a, self.b) || may_hold(self.b, self.a))
    }

    /// True unless it is known in the run that neither body has a vertex inside the other.
    pub(crate) fn is_open_in(&self, workspace: &Workspace) -> bool {
        self.may_contain() && workspace.run.containment != Containment::Known(None)
    }

    /// Finds out first whether one body has a vertex inside the other. Returns the reason to stop,
    /// if one has or the deadline came before.
    pub(crate) fn containment_first(
        &self,
        b_in_a: impl FnOnce() -> Pose,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Option<StopReason> {
        if !self.is_open_in(workspace) {
            return None;
        }
        let stop = self.ask_containment(&b_in_a(), workspace, deadline);
        self.is_open_in(workspace).then_some(stop)
    }

    /// Continues to find out whether one body has a vertex inside the other. The frontier of the
    /// run keeps its pairs.
    #[cold]
    pub(crate) fn ask_containment(
        &self,
        b_in_a: &Pose,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> StopReason {
        if flushing::matters(self.a, self.b, b_in_a) {
            workspace.run.stopped = true;
            return StopReason::FlushedToZero;
        }
        loop {
            let (inner, next) = match workspace.run.containment {
                Containment::Open => {
                    workspace.run.containment = Containment::Asking(Operand::B);
                    begin_samples(workspace, [self.a, self.b]);
                    continue;
                }
                Containment::Known(_) => return StopReason::Finished,
                Containment::Asking(Operand::B) => (self.b, Containment::Asking(Operand::A)),
                Containment::Asking(Operand::A) => (self.a, Containment::Known(None)),
            };
            let is_b = workspace.run.containment == Containment::Asking(Operand::B);
            let outer = if is_b { self.a } else { self.b };
            let source = Source::Samples { inner, is_b };
            let tests = mem::replace(
                &mut workspace.testing,
                !workspace.state.points.uncertain.is_empty(),
            );
            let question = Locate { source };
            let trees = [outer; 2];
            let stop = traverse_of::<_, false>(
                question,
                trees,
                b_in_a,
                &RelativePose::BLIND,
                workspace,
                deadline,
            );
            workspace.testing = tests;
            if !stop.is_final() {
                return stop;
            }
            if workspace.state.points.is_within {
                let inner = if is_b { Operand::B } else { Operand::A };
                workspace.run.containment = Containment::Known(Some(inner));
            } else {
                workspace.run.containment = next;
                if is_b {
                    begin_samples(workspace, [self.b, self.a]);
                }
            }
        }
    }
}

/// Least number of triangles that bound a volume.
const LEAST_TRIANGLES: usize = 4;

/// True if the first tree can contain the second.
pub(crate) fn may_hold(outer: &Tree, inner: &Tree) -> bool {
    let is_closed = outer.solid().is_some_and(|solid| solid.is_closed());
    is_closed && inner.solid().is_some() && outer.mesh().len() >= LEAST_TRIANGLES
}
