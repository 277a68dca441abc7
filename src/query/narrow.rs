//! Certificates that say more: what a stopped run left open is looked at again, the largest boxes first.
//!
//! It is the same traversal with another key, in another workspace. The run itself stays as it is, and goes on later as if
//! nobody had looked.

use super::budget::{Budget, ManualClock};
use super::certificate::Certificate;
use super::intersection::Intersection;
use super::options::{Mode, Options};
use super::queue::Pair;
use super::strategy::Strategy;
use super::traversal::Traversal;
use super::views::Relation;
use super::workspace::{ResumeError, Workspace};
use super::{Deadline, Query};

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
        workspace.run.holds(&self.key())?;
        aside.clear();
        aside.run.begin(self.key(), Strategy::narrowing(workspace.run.strategy.march));
        aside.take_over(workspace);
        let options = Options { mode: Mode::All, pair_limit: usize::MAX, ..self.options };
        let (trees, relation) = ([self.a, self.b], Relation::new(self.a, self.b, &self.b_in_a));
        let clock = ManualClock::new();
        let mut deadline = Deadline::of(Budget::work(work), options.poll_interval, &clock);
        let question = Intersection { options: &options };
        let mut traversal = Traversal::new(question, trees, &self.b_in_a, &relation, aside, &mut deadline);
        let taken = traversal.queue_first(workspace.open_nodes());
        let _ = traversal.advance();
        // It is nobody's run: a part of the pairs is in the other workspace.
        aside.run.key = None;
        Ok(Certificate::new(trees, &self.b_in_a, aside, 0.0).narrowed(workspace, taken))
    }
}

impl Traversal<'_, '_, Intersection<'_>> {
    /// Queues as many of these pairs as there is room for; how many.
    fn queue_first(&mut self, pairs: impl Iterator<Item = Pair>) -> usize {
        let room = self.workspace.front.room();
        pairs.take(room).map(|pair| self.queue_by_room(pair)).count()
    }
}

impl Workspace {
    /// Begins with all that another run has left open, but for node pairs, and with what it found.
    fn take_over(&mut self, run: &Self) {
        self.run.found = run.run.found;
        self.waiting.copy_from(&run.waiting);
        self.doubtful.clone_from(&run.doubtful);
        self.testing = self.waiting.is_full() || !self.doubtful.is_empty();
        self.march.copy_visits(&run.march);
    }
}
