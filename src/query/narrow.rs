//! Certificates that say more: what a stopped run left open is looked at again, the largest boxes first.
//!
//! It is the same traversal with another key, in another workspace. The run itself stays as it is, and goes on later as if
//! nobody had looked.

use super::budget::{Budget, ManualClock};
use super::certificate::{Certificate, Place};
use super::contacts::ContactQuery;
use super::distance::DistanceQuery;
use super::intersection::Intersection;
use super::nearest::Distance;
use super::options::{Mode, Options};
use super::order::bucket_by_room;
use super::queue::Pair;
use super::strategy::Marching;
use super::traversal::{Question, Traversal};
use super::views::Relation;
use super::workspace::{ResumeError, Workspace};
use super::{Deadline, Query};
use crate::tree::Tree;

impl Query<'_> {
    /// [`Query::certificate`] after so many units of work that open the largest of its boxes: the more, the less room is left
    /// and the lower its upper bound. The run in `workspace` stays as it is and can be resumed as ever; the work is done in
    /// `aside`, whatever that held before.
    ///
    /// Of intersections that it comes across the certificate has the boxes of the triangles, since the query has not found
    /// them. It takes time linear in the open pairs to begin with, then that of the work (`docs/benchmarks.md` has what that
    /// is worth). Open node pairs for which the queue of `aside` has no room stay as they are: a workspace as large as the
    /// query's will do. It does not allocate.
    ///
    /// ```
    /// use punctual::{Budget, Mode, Pose, Query, Tree, Workspace, shapes};
    /// let (a, b) = (Tree::new(shapes::icosphere(5)), Tree::new(shapes::torus(1.0, 0.3, 64)));
    /// let (mut workspace, mut aside) = (Workspace::new(), Workspace::new());
    /// let query = Query::new(&a, &b, Pose::IDENTITY).mode(Mode::All);
    /// let _ = query.run(&mut workspace, Budget::work(20_000));
    /// let plain = query.certificate(&workspace)?.upper_bound();
    /// let narrowed = query.narrowed_certificate(&workspace, &mut aside, 10_000)?;
    /// assert!(narrowed.upper_bound() < plain);
    /// # Ok::<(), punctual::ResumeError>(())
    /// ```
    ///
    /// # Errors
    /// If the last run in `workspace` was not of these trees, this pose and these options.
    pub fn narrowed_certificate<'w>(
        &'w self,
        workspace: &'w Workspace,
        aside: &'w mut Workspace,
        work: u64,
    ) -> Result<Certificate<'w>, ResumeError> {
        let options = Options {
            mode: Mode::All,
            pair_limit: usize::MAX,
            ..self.options
        };
        Ok(self
            .certificate(workspace)?
            .narrow(aside, work, |_| Intersection { options: &options }))
    }
}

impl DistanceQuery<'_> {
    /// [`DistanceQuery::certificate`] after so many units of work that open the largest of its boxes: the more, the less room
    /// is left for what is closer than the upper bound by more than the tolerance. That bound and the run in `workspace` stay
    /// as they are, as with [`Query::narrowed_certificate`]. Before there is an upper bound, or a limit, it says no more than
    /// the certificate.
    ///
    /// # Errors
    /// If the last run in `workspace` was not of these trees, this pose and these options.
    pub fn narrowed_certificate<'w>(
        &'w self,
        workspace: &'w Workspace,
        aside: &'w mut Workspace,
        work: u64,
    ) -> Result<Certificate<'w>, ResumeError> {
        let question = |relation: &Relation| Distance::new(relation, &workspace.search.interval);
        Ok(self.certificate(workspace)?.narrow(aside, work, question))
    }
}

impl ContactQuery<'_> {
    /// [`ContactQuery::certificate`] after so many units of work that open the largest of its boxes: as
    /// [`Query::narrowed_certificate`].
    ///
    /// # Errors
    /// If the last run in `workspace` was not of these trees, this pose and these options.
    pub fn narrowed_certificate<'w>(
        &'w self,
        workspace: &'w Workspace,
        aside: &'w mut Workspace,
        work: u64,
    ) -> Result<Certificate<'w>, ResumeError> {
        let certificate = self.certificate(workspace)?;
        Ok(if self.options.margin > 0.0 {
            certificate.narrow(aside, work, |relation| {
                Distance::new(relation, &workspace.search.interval)
            })
        } else {
            let options = Options {
                mode: Mode::All,
                ..Options::DEFAULT
            };
            certificate.narrow(aside, work, |_| Intersection { options: &options })
        })
    }
}

impl<'w> Certificate<'w> {
    /// The same after so much work on the question, the largest boxes first.
    fn narrow<Q>(
        self,
        aside: &'w mut Workspace,
        work: u64,
        question: impl FnOnce(&Relation) -> Q,
    ) -> Self
    where
        for<'q, 'c> Traversal<'q, 'c, Q>: Question,
    {
        // Boxes of a motion cover all of the way, and its pieces are no node pairs.
        let Place::Still(b_in_a, reach) = self.place else {
            return self;
        };
        let run = self.workspace;
        aside.take_over(run, [self.a, self.b]);
        let relation = Relation::new(self.a, self.b, b_in_a);
        let clock = ManualClock::new();
        let mut deadline = Deadline::of(Budget::work(work), &clock);
        if reach > 0.0 {
            aside.contacts.begin(reach, usize::MAX);
        }
        let question = question(&relation);
        let mut traversal = Traversal::new(
            question,
            [self.a, self.b],
            b_in_a,
            &relation,
            aside,
            &mut deadline,
        );
        let reach = (reach / relation.unit) as f32;
        let taken = traversal.queue_first(run.open_nodes(), reach);
        let _ = traversal.advance();
        // Nobody can resume it: a part of the pairs is in the other workspace.
        aside.run.key = None;
        self.narrowed(aside, taken)
    }
}

impl<Q> Traversal<'_, '_, Q> {
    /// Queues as many of these pairs as there is room for, and returns how many.
    fn queue_first(&mut self, pairs: impl Iterator<Item = Pair>, reach: f32) -> usize {
        let room = self.workspace.front.room();
        pairs
            .take(room)
            .map(|pair| self.queue_by_room(pair, 0.0, reach))
            .count()
    }

    /// Queues a pair by the room in which its boxes are within `reach` of one another, A's units.
    // Seldom asked for, and so out of the loop.
    #[cold]
    #[inline(never)]
    pub(super) fn queue_by_room(&mut self, pair: Pair, key: f32, reach: f32) {
        let (a, b) = (
            &self.a.nodes()[pair.nodes[0] as usize],
            &self.b.nodes()[pair.nodes[1] as usize],
        );
        let bucket = bucket_by_room(a, b, self.relation, reach);
        self.workspace.front.queue(pair, key, bucket, true);
    }
}

impl Workspace {
    /// Begins with what another run has found and left open, except its node pairs.
    fn take_over(&mut self, run: &Self, trees: [&Tree; 2]) {
        self.clear();
        if let Some(key) = run.run.key {
            self.run.begin(key, run.run.strategy.narrowing());
        }
        self.run.found = run.run.found;
        self.waiting.copy_from(&run.waiting);
        self.doubtful.clone_from(&run.doubtful);
        self.march.known.copy_from(&run.march.known);
        (self.march.followed, self.march.passed) = (run.march.followed, run.march.passed);
        if self.run.strategy.march == Marching::Over {
            self.drop_known(trees);
        }
        self.search.copy_from(&run.search);
        self.testing = self.waiting.is_full() || !self.doubtful.is_empty() || self.search.is_due();
    }
}
