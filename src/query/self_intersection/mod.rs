//! Self-intersection: the question, and how a run of it begins and continues. The traversal of its
//! node pairs is in [`own_pairs`].

mod own_pairs;

use crate::engine::boxes::RelativePose;
use crate::engine::certificate::Place;
use crate::engine::deadline::{Budget, Deadline};
use crate::engine::frontier::Pair;
use crate::engine::memory::PairMemory;
use crate::engine::options::{Mode, Options};
use crate::engine::outcome::{StopReason, Verdict};
use crate::engine::question::{Ask, Certify, Query, Question};
use crate::engine::strategy::Strategy;
use crate::engine::traversal::traverse;
use crate::engine::triangles::PATIENCE;
use crate::engine::workspace::{Asked, Key, Workspace};
use crate::model::cost::{WORK_PER_EXPANSION, WORK_PER_TRIANGLE_TEST};
use crate::model::prediction::Quantiles;
use crate::tree::Tree;
use alloc::vec::Vec;
use own_pairs::OwnPairs;
use punctual_geom::Pose;

/// Asks whether, or where, a surface intersects itself ([`Query::self_intersections`]).
#[derive(Clone, Copy, Debug)]
pub struct SelfIntersection {
    options: Options,
}

impl Question for SelfIntersection {
    /// The pairs of triangles found are in [`Workspace::pairs`], each once, the lower id first.
    type Value = Verdict;
}

impl<'t> Query<'t, SelfIntersection> {
    /// Asks for all pairs of triangles of a mesh that intersect beyond what they share:
    /// [`geom::triangles_intersect_beyond_shared`](crate::geom::triangles_intersect_beyond_shared).
    /// After a [refit](Tree::refit) these are the self-contacts of the deformed mesh.
    ///
    /// - Triangles without a common corner count if they share a point.
    /// - With one common corner, if they share another point.
    /// - With a common edge, if they are coplanar and on the same side of it.
    /// - A triangle that is there twice counts.
    ///
    /// Corners are common if their positions are equal, whatever their indices: STL files, and
    /// seams of textures, repeat vertices. So parts of a mesh that touch in a corner which both
    /// have do not count there. A degenerate triangle is the hull of its corners.
    ///
    /// Exact, with the guarantee of [`Query::all_pairs`]: a stopped run can be resumed, and bounded
    /// by a certificate. About linear in the triangles.
    ///
    /// ```
    /// use punctual::{Budget, Query, Tree, Verdict, Workspace, shapes};
    /// let tree = Tree::new(shapes::torus_knot(2, 3, 0.2, 24));
    /// let mut workspace = Workspace::new();
    /// let answer = Query::self_intersections(&tree).run(&mut workspace, Budget::unlimited());
    /// assert_eq!(answer.value, Verdict::Separated);
    /// let thick = Tree::new(shapes::torus_knot(2, 3, 0.7, 24));
    /// let answer = Query::self_intersections(&thick).run(&mut workspace, Budget::unlimited());
    /// assert_eq!(workspace.pairs().len() as u64, answer.stats.found);
    /// assert!(answer.stats.found > 0);
    /// ```
    #[must_use]
    pub fn self_intersections(tree: &'t Tree) -> Self {
        let options = Options {
            mode: Mode::All,
            ..Options::DEFAULT
        };
        Self::of([tree; 2], SelfIntersection { options })
    }

    /// Sets whether to find any pair, or all.
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
}

impl Tree {
    /// All pairs of triangles of the mesh that intersect beyond what they share, sorted: those of
    /// [`Query::self_intersections`], without a budget.
    #[must_use]
    pub fn self_intersections(&self) -> Vec<[u32; 2]> {
        let (query, mut workspace) = (Query::self_intersections(self), Workspace::new());
        let mut answer = Ok(query.run(&mut workspace, Budget::unlimited()));
        let mut pairs = Vec::new();
        while let Ok(part) = answer {
            pairs.extend(workspace.drain_pairs());
            answer = match part.stop {
                StopReason::PairsFull => query.resume(&mut workspace, Budget::unlimited()),
                _ => break,
            };
        }
        pairs.sort_unstable();
        pairs
    }
}

/// Units of work of a triangle: the median of 23 meshes of 11,000 to 256,000 triangles, which take
/// 409 to 1,245.
const WORK_PER_TRIANGLE: f64 = 670.0;

impl Ask<SelfIntersection> for Query<'_, SelfIntersection> {
    fn key(&self) -> Key {
        let asked = Asked::SelfIntersection(self.asked.options);
        Key::new([self.a; 2], Pose::IDENTITY, asked)
    }

    fn begin(&self, workspace: &mut Workspace, _: Option<&PairMemory>, _: Budget) {
        workspace.clear();
        let batch = match self.asked.options.mode {
            Mode::Any => Strategy::NONE.batch,
            Mode::All => PATIENCE,
        };
        let strategy = Strategy {
            batch,
            ..Strategy::NONE
        };
        workspace.run.begin(self.key(), strategy);
        if !self.a.nodes().is_empty() {
            workspace.frontier.push(Pair::new(0, 0));
        }
    }

    fn advance(
        &self,
        workspace: &mut Workspace,
        _: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let pose = &Pose::IDENTITY;
        let relative = RelativePose::new(self.a, self.a, pose);
        let question = OwnPairs::new(&self.asked.options);
        let trees = [self.a; 2];
        traverse(question, trees, pose, &relative, workspace, deadline)
    }

    fn answer(&self, workspace: &Workspace, stop: StopReason) -> Verdict {
        workspace.verdict(stop)
    }

    /// Counts a node paired with itself as the work of its triangles, another pair as some
    /// openings.
    fn left(&self, workspace: &Workspace, _: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        let work = |pair: Pair| match pair.nodes {
            [x, y] if x == y => WORK_PER_TRIANGLE * f64::from(self.a.nodes()[x as usize].triangles),
            _ => 8.0 * WORK_PER_EXPANSION as f64,
        };
        let waiting = WORK_PER_TRIANGLE_TEST as f64 * workspace.triangle_pairs().count() as f64;
        let p50 = workspace.frontier.iter().map(work).sum::<f64>() + waiting.max(1.0);
        let (p10, p90) = (0.6 * p50, 1.7 * p50);
        (Quantiles { p10, p50, p90 }, None)
    }
}

impl Certify<SelfIntersection> for Query<'_, SelfIntersection> {
    fn place(&self, _: &Workspace) -> Place<'_> {
        Place::Still(&Pose::IDENTITY, 0.0)
    }
}
