//! Whether, or where, two surfaces meet: the question, and how a run of it begins and goes on.
//!
//! What the traversal does with its node pairs is in [`meeting`](super::meeting).

use super::budget::Budget;
use super::certificate::Place;
use super::meeting::Meeting;
use super::memory::{Before, PairMemory, WITNESSES};
use super::options::{Mode, Options};
use super::order::Order;
use super::outcome::{StopReason, Verdict};
use super::queue::Pair;
use super::strategy::{Plan, Strategy, WarmStart};
use super::traversal::Traversal;
use super::views::Relation;
use super::workspace::{Asked, Key, Workspace};
use super::{Ask, Deadline, Query, Question, Remembers};
use crate::math::{Pose, nanoseconds};
use crate::model::confidence::DEFAULT_PRIOR;
use crate::model::cost::Counts;
use crate::tree::{Tree, WIDTH};

/// The question whether, or where, two surfaces meet at a pose ([`Query::intersection`],
/// [`Query::all_pairs`]).
///
/// **Guarantee.** At every moment each intersecting pair of triangles has been reported, or is kept
/// in the workspace as a triangle pair still to be tested, or lies under a node pair still to be
/// opened. So `Separated` is said only when nothing is left, a stopped query can name what it may
/// have missed ([`Query::certificate`]), and it can go on later as if it had never stopped
/// ([`Query::resume`]). A full queue costs order, a full pair buffer is a stop reason; neither
/// costs an answer.
///
/// ```
/// use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};
/// let (a, b) = (Tree::new(shapes::icosphere(4)), Tree::new(shapes::torus(1.0, 0.3, 64)));
/// let mut workspace = Workspace::new();
/// let answer = Query::intersection(&a, &b, Pose::IDENTITY).run(&mut workspace, Budget::work(20_000));
/// match answer.value {
///     // `Within` is what a scene says of bodies with margins.
///     Verdict::Intersecting { witness } | Verdict::Within { witness, .. } => println!("triangles {witness:?} meet"),
///     Verdict::Separated => println!("no contact"),
///     Verdict::Undecided => println!("not known yet"),
/// }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Intersection {
    pub(super) b_in_a: Pose,
    pub(super) options: Options,
    pub(super) prior: f64,
}

impl Question for Intersection {
    /// [`Workspace::pairs`] has the pairs of triangles that were found.
    type Value = Verdict;
}

impl Remembers for Intersection {}

impl<'t> Query<'t, Intersection> {
    /// Asks whether the surfaces of `a` and `b` meet, where `b_in_a` brings B's coordinates into
    /// A's. It stops at the first pair of triangles that intersect.
    #[must_use]
    pub fn intersection(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        Self::of(
            [a, b],
            Intersection {
                b_in_a,
                options: Options::DEFAULT,
                prior: DEFAULT_PRIOR,
            },
        )
    }

    /// Asks for all pairs of triangles that intersect; they stay in the workspace
    /// ([`Workspace::pairs`]).
    #[must_use]
    pub fn all_pairs(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        Self::intersection(a, b, b_in_a).mode(Mode::All)
    }

    /// Any intersection, or all of them.
    #[must_use]
    pub fn mode(mut self, mode: Mode) -> Self {
        self.asked.options.mode = mode;
        self
    }

    /// Stop with [`StopReason::PairsFull`] when this many pairs are in the workspace; by default,
    /// when it is full.
    #[must_use]
    pub fn pair_limit(mut self, pairs: usize) -> Self {
        self.asked.options.pair_limit = pairs.max(1);
        self
    }

    /// The share of poses with an intersection among those that are asked about, 0 to 1; it shifts
    /// the probability of [`Query::estimate`]. By default that of the poses for which the model was
    /// fitted, [`DEFAULT_PRIOR`](crate::DEFAULT_PRIOR), as with NaN.
    #[must_use]
    pub fn prior(mut self, share: f64) -> Self {
        self.asked.prior = if share.is_nan() { DEFAULT_PRIOR } else { share };
        self
    }

    /// For experiments: the order of visits; penetration by default, which finds most before a
    /// budget ends (`docs/benchmarks.md`).
    #[must_use]
    pub fn order(mut self, order: Order) -> Self {
        self.asked.options.order = order;
        self
    }

    /// For experiments: node pairs of which fewer BV tests than this are expected are finished
    /// depth-first at once instead of being queued. 0 (and NaN) queues every node pair, infinity
    /// none. By default 48 in the default order and 128 in others, and infinity for [`Mode::Any`]
    /// in the default order: a stack with the deepest of siblings on top finds the first hit sooner
    /// than the queue (`docs/benchmarks.md`). In the default order it matters only where a budget
    /// may cut the run.
    #[must_use]
    pub fn queue_threshold(mut self, bv_tests: f32) -> Self {
        // The larger of NaN and 0 is 0.
        self.asked.options.queue_threshold = Some(bv_tests.max(0.0));
        self
    }

    /// The strategy of a run in a larger task, which goes to its end (`complete`) or may be cut:
    /// with full batches, with which small budgets of scenes find more.
    pub(crate) fn strategy(&self, complete: bool) -> Strategy {
        let options = &self.asked.options;
        Strategy {
            batch: WIDTH,
            ..Plan::of(options.mode, !complete).strategy(options)
        }
    }

    /// Prepares the workspace for a run from the roots, where so many of the latest witnesses were
    /// tested already and do not meet.
    #[inline(always)]
    pub(crate) fn begin_as(
        &self,
        strategy: Strategy,
        refuted: usize,
        workspace: &mut Workspace,
        memory: Option<&PairMemory>,
    ) {
        workspace.clear();
        workspace.run.begin(self.key(), strategy);
        let remembered = memory
            .filter(|memory| memory.last_verdict() != Some(false) && memory.is_of(self.a, self.b));
        let witnesses = remembered.map_or(&[][..], PairMemory::witnesses);
        match strategy.warm_start {
            WarmStart::None => {}
            WarmStart::Paths => workspace.witnesses.extend(witnesses.iter().copied()),
            WarmStart::Witnesses => {
                // They wait like any other triangle pairs, and so are tested first.
                let latest = &witnesses[..witnesses.len().min(WITNESSES)];
                workspace
                    .waiting
                    .extend(&latest[refuted.min(latest.len())..]);
                workspace.testing = workspace.waiting.len() > 0;
            }
        }
        let are_apart =
            memory.is_some_and(|memory| memory.clearance(self.a, self.b, &self.asked.b_in_a) > 0.0);
        if are_apart || self.a.nodes().is_empty() || self.b.nodes().is_empty() {
            return;
        }
        let paths = (1u32 << workspace.witnesses.len()) - 1;
        if workspace.front.follow(Pair::new(0, 0), paths as u16) {
            // The first of the paths.
        } else if strategy.queues() {
            workspace.front.queue(Pair::new(0, 0), 0.0, 0, true);
        } else {
            // Made where it is stored: copied in one piece, it would have to wait until the pieces
            // are in the cache.
            workspace.front.push(Pair::new(0, 0));
        }
        // Where triangles met last, others near them are likely to meet now: they are visited
        // first.
        if let (WarmStart::Witnesses, Some(&[x, y])) = (strategy.warm_start, witnesses.first()) {
            let (x, y) = (self.a.nodes_above(x), self.b.nodes_above(y));
            workspace.front.push(Pair::new(x[0], y[0]));
            workspace.front.push(Pair::new(x[1], y[1]));
        }
    }

    /// Goes on with the run in the workspace until it is over or the deadline stops it.
    #[inline(always)]
    pub(crate) fn search(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let before = Before {
            resumed: workspace.run.stopped,
            decided: workspace.run.witness.is_some(),
        };
        let relation = Relation::new(self.a, self.b, &self.asked.b_in_a);
        let question = Meeting {
            options: &self.asked.options,
        };
        let stop = Traversal::new(
            question,
            [self.a, self.b],
            &self.asked.b_in_a,
            &relation,
            workspace,
            deadline,
        )
        .advance();
        if let Some(memory) = memory {
            memory.bind(self.a, self.b);
            memory.remember(self.asked.options.mode, stop, workspace, before);
        }
        stop
    }
}

impl Ask for Query<'_, Intersection> {
    type Value = Verdict;

    fn key(&self) -> Key {
        Key::new(
            [self.a, self.b],
            self.asked.b_in_a,
            Asked::Intersection(self.asked.options),
        )
    }

    fn begin(&self, workspace: &mut Workspace, memory: Option<&PairMemory>, budget: Budget) {
        let fits = |limit| self.fits(limit, memory, &workspace.cost_model);
        let plan = Plan::within(budget, self.asked.options.mode, fits);
        let strategy = plan.strategy(&self.asked.options);
        self.begin_as(strategy, 0, workspace, memory);
    }

    /// Also learns what the work costs.
    fn advance(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let before = if workspace.run.stopped {
            workspace.counts()
        } else {
            Counts::default()
        };
        let stop = self.search(workspace, memory, deadline);
        if let Some(elapsed) = deadline.elapsed() {
            let done = workspace.counts().since(&before);
            workspace.cost_model = workspace.cost_model.learned(&done, nanoseconds(elapsed));
        }
        stop
    }

    fn answer(&self, workspace: &Workspace, stop: StopReason) -> Verdict {
        workspace.verdict(stop)
    }

    fn place(&self, _: &Workspace) -> Place<'_> {
        Place::Still(&self.asked.b_in_a, 0.0)
    }
}
