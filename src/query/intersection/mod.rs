//! Intersection of two surfaces, any or all pairs: the question, and how a run of it begins and
//! continues.
//!
//! The traversal of its node pairs is in [`meeting`].

pub(crate) mod estimate;
mod follow;
pub(crate) mod known;
pub(crate) mod leaf;
mod measure;
pub(crate) mod meeting;
#[cfg(feature = "internals")]
pub(crate) mod opened;
mod probe;
pub(crate) mod state;
pub(crate) mod trace;
mod within;

use crate::engine::boxes::RelativePose;
use crate::engine::certificate::Place;
use crate::engine::deadline::{Budget, Deadline};
use crate::engine::frontier::Pair;
use crate::engine::frontier::order::Order;
use crate::engine::memory::{Before, PairMemory, WITNESSES};
use crate::engine::options::{Mode, Options};
use crate::engine::outcome::{StopReason, Verdict};
use crate::engine::question::{Ask, Certify, Query, Question, Remembers};
use crate::engine::strategy::{Plan, Strategy, WarmStart};
use crate::engine::traversal::traverse;
use crate::engine::workspace::{Asked, Containment, Key, Workspace};
use crate::model::confidence::DEFAULT_PRIOR;
use crate::model::cost::Counts;
use crate::model::prediction::Quantiles;
use crate::tree::{Tree, WIDTH};
use meeting::Meeting;
use punctual_geom::{Pose, nanoseconds};

/// Asks whether, or where, two surfaces intersect at a pose ([`Query::intersection`],
/// [`Query::all_pairs`]).
///
/// **Guarantee.** At every moment each intersecting pair of triangles has been reported, or is kept
/// in the workspace as a triangle pair still to be tested, or lies under a node pair still to be
/// opened. So the answer is `Separated` only when nothing is left. A stopped query can bound what
/// it may have missed ([`Query::certificate`]), and it can continue later as if it had never
/// stopped ([`Query::resume`]). A full queue changes only the order of visits, and a full pair
/// buffer is a stop reason; neither loses an answer.
///
/// ```
/// use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};
/// let (a, b) = (Tree::new(shapes::icosphere(4)), Tree::new(shapes::torus(1.0, 0.3, 64)));
/// let mut workspace = Workspace::new();
/// let query = Query::intersection(&a, &b, Pose::IDENTITY);
/// let answer = query.run(&mut workspace, Budget::work(20_000));
/// match answer.value {
///     // `Within` is what a scene says of bodies with margins.
///     Verdict::Intersecting { witness } | Verdict::Within { witness, .. } => {
///         println!("triangles {witness:?} meet")
///     }
///     // For solids only.
///     Verdict::Contained { inner } => println!("{inner} is inside the other"),
///     Verdict::Separated => println!("no contact"),
///     Verdict::Undecided => println!("not known yet"),
/// }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Intersection {
    pub(crate) b_in_a: Pose,
    pub(crate) options: Options,
    pub(crate) prior: f64,
}

impl Question for Intersection {
    /// The pairs of triangles found are in [`Workspace::pairs`].
    type Value = Verdict;
}

impl Remembers for Intersection {}

impl<'t> Query<'t, Intersection> {
    /// Asks whether the surfaces of `a` and `b` intersect, where `b_in_a` maps B's coordinates into
    /// A's. It stops at the first pair of triangles that intersect.
    ///
    /// If both trees are solids ([`crate::BuildOptions::solid`]) and their surfaces do not meet, it
    /// also asks whether a component of one is inside the other, if that is closed:
    /// [`Verdict::Contained`]. That takes a ray for each component, if its first vertex is in the
    /// other mesh's box.
    #[must_use]
    pub fn intersection(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        let asked = Intersection {
            b_in_a,
            options: Options {
                reach: a.radius() + b.radius(),
                ..Options::DEFAULT
            },
            prior: DEFAULT_PRIOR,
        };
        Self::of([a, b], asked)
    }

    /// Asks for all pairs of triangles that intersect. They stay in the workspace
    /// ([`Workspace::pairs`]).
    #[must_use]
    pub fn all_pairs(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        Self::intersection(a, b, b_in_a).mode(Mode::All)
    }

    /// Sets whether to find any intersection, or all.
    #[must_use]
    pub fn mode(mut self, mode: Mode) -> Self {
        self.asked.options.mode = mode;
        self
    }

    /// Stops with [`StopReason::PairsFull`] when this many pairs are in the workspace. By default,
    /// when the workspace is full.
    #[must_use]
    pub fn pair_limit(mut self, pairs: usize) -> Self {
        self.asked.options.pair_limit = pairs.max(1);
        self
    }

    /// The prior: the share of poses with an intersection among all poses queried, 0 to 1. It
    /// shifts the probability of [`Query::estimate`]. By default, and with NaN, the share in the
    /// poses for which the model was fitted, [`DEFAULT_PRIOR`](crate::prediction::DEFAULT_PRIOR).
    #[must_use]
    pub fn prior(mut self, share: f64) -> Self {
        self.asked.prior = if share.is_nan() { DEFAULT_PRIOR } else { share };
        self
    }

    /// For experiments: the order of visits of a query that a budget may cut. The default is
    /// penetration, which finds most before a budget ends (`docs/benchmarks.md`).
    #[must_use]
    pub fn order(mut self, order: Order) -> Self {
        self.asked.options.order = order;
        self
    }

    /// For comparisons: the simplest traversal. It uses a stack, and no queue, ranks of siblings,
    /// traced curves or remembered triangles. The order has no effect then.
    #[must_use]
    pub fn plain(mut self) -> Self {
        self.asked.options.is_plain = true;
        self
    }

    /// Asks about the cores of trees with a radius.
    #[doc(hidden)]
    #[must_use]
    pub fn cores(mut self) -> Self {
        self.asked.options.reach = 0.0;
        self
    }

    /// Prepares the workspace for a run within a larger task, which runs to its end (`complete`) or
    /// may be cut. It begins at the roots, whatever is remembered.
    ///
    /// Triangle batches are full; small budgets of scenes then find more.
    #[doc(hidden)]
    #[inline]
    pub fn begin_task(&self, complete: bool, workspace: &mut Workspace) {
        let options = &self.asked.options;
        let strategy = Strategy {
            batch: WIDTH,
            ..Plan::of(options.mode, !complete).strategy(options)
        };
        self.begin_as(strategy, workspace, None);
    }

    /// Prepares the workspace for a run from the roots.
    #[inline(always)]
    fn begin_as(&self, strategy: Strategy, workspace: &mut Workspace, memory: Option<&PairMemory>) {
        if self.asked.options.reach > 0.0 {
            return self.begin_within(workspace, memory);
        }
        workspace.clear();
        workspace.run.begin(self.key(), strategy);
        let remembered = memory
            .filter(|memory| memory.last_verdict() != Some(false) && memory.is_of(self.a, self.b));
        let witnesses = remembered.map_or(&[][..], PairMemory::witnesses);
        match strategy.warm_start {
            WarmStart::None => {}
            WarmStart::Paths => {
                let known = &mut workspace.state.intersection.witnesses;
                known.extend(witnesses.iter().copied());
            }
            WarmStart::Witnesses => {
                // Queued like other triangle pairs, so they are tested first.
                let latest = &witnesses[..witnesses.len().min(WITNESSES)];
                for &pair in latest {
                    workspace.waiting.push(pair);
                }
                workspace.testing = !workspace.waiting.is_empty();
            }
        }
        let are_apart =
            memory.is_some_and(|memory| memory.clearance(self.a, self.b, &self.asked.b_in_a) > 0.0);
        if are_apart || self.a.nodes().is_empty() || self.b.nodes().is_empty() {
            return;
        }
        let paths = (1u32 << workspace.state.intersection.witnesses.len()) - 1;
        if workspace.frontier.follow(Pair::new(0, 0), paths as u16) {
            // The root is on a path.
        } else if strategy.queue.is_some() {
            workspace
                .frontier
                .rank_all(1, &[[0.0; WIDTH]; WIDTH], 0.0, |_| Pair::new(0, 0));
        } else {
            // Built in place: a copy as one piece would wait until its parts are in the cache.
            workspace.frontier.push(Pair::new(0, 0));
        }
        // Triangles near the last hit are likely to meet, so they are visited first.
        if let (WarmStart::Witnesses, Some(&[x, y])) = (strategy.warm_start, witnesses.first()) {
            let (x, y) = (self.a.nodes_above(x), self.b.nodes_above(y));
            workspace.frontier.push(Pair::new(x[0], y[0]));
            workspace.frontier.push(Pair::new(x[1], y[1]));
        }
    }

    /// Continues the run in the workspace until it is over or the deadline stops it.
    #[doc(hidden)]
    #[inline(always)]
    pub fn search(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let before = Before {
            resumed: workspace.run.stopped,
            decided: workspace.run.witness.is_some(),
        };
        let relative = RelativePose::new(self.a, self.b, &self.asked.b_in_a);
        let question = Meeting {
            options: &self.asked.options,
        };
        let (trees, b_in_a) = ([self.a, self.b], &self.asked.b_in_a);
        let stop = if self.asked.options.reach > 0.0 {
            self.search_within(&relative, workspace, deadline)
        } else {
            traverse(question, trees, b_in_a, &relative, workspace, deadline)
        };
        if stop == StopReason::FlushedToZero {
            return stop;
        }
        if let Some(memory) = memory {
            memory.bind(self.a, self.b);
            memory.remember(self.asked.options.mode, stop, workspace, before);
            self.teach(memory, workspace, stop.is_final());
        }
        stop
    }
}

impl Ask<Intersection> for Query<'_, Intersection> {
    fn key(&self) -> Key {
        let asked = Asked::Intersection(self.asked.options);
        Key::new([self.a, self.b], self.asked.b_in_a, asked)
    }

    fn begin(&self, workspace: &mut Workspace, memory: Option<&PairMemory>, budget: Budget) {
        let fits = |limit| self.fits(limit, memory, &workspace.cost_model);
        let plan = Plan::within(budget, self.asked.options.mode, fits);
        let strategy = plan.strategy(&self.asked.options);
        self.begin_as(strategy, workspace, memory);
    }

    /// Also updates the cost model from the time taken.
    fn advance(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let before = if workspace.run.stopped {
            workspace.run.stats.counts()
        } else {
            Counts::default()
        };
        let stop = if workspace.run.containment == Containment::Open {
            self.search(workspace, memory, deadline)
        } else {
            StopReason::Finished
        };
        let are_apart = stop == StopReason::Finished && workspace.run.stats.found == 0;
        let stop = if are_apart && self.may_contain() {
            self.ask_containment(&self.asked.b_in_a, workspace, deadline)
        } else {
            stop
        };
        if let Some(elapsed) = deadline.elapsed() {
            let done = workspace.run.stats.counts().since(&before);
            workspace.cost_model = workspace.cost_model.learned(&done, nanoseconds(elapsed));
        }
        stop
    }

    fn answer(&self, workspace: &Workspace, stop: StopReason) -> Verdict {
        match workspace.run.containment.inner() {
            Some(inner) => Verdict::Contained { inner },
            None => workspace.verdict(stop),
        }
    }

    fn left(&self, workspace: &Workspace, memory: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        self.estimate(workspace, memory).map_or_else(
            |_| Default::default(),
            |estimate| (estimate.remaining.work, Some(estimate.probability)),
        )
    }
}

impl Certify<Intersection> for Query<'_, Intersection> {
    fn place(&self, _: &Workspace) -> Place<'_> {
        Place::Still(&self.asked.b_in_a, self.asked.options.reach)
    }
}
