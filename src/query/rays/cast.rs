//! Ray cast: how the traversal handles nodes and triangles.
//!
//! There is no second tree. The key of a node is the parameter at which the ray enters its box
//! ([`Pair::keyed`]). Nodes are finished depth-first, of siblings the one entered first; nodes
//! entered after the nearest hit are dropped. Triangles of a leaf are tested in `f32` together.
//! Those that this test cannot exclude are tested in `f64`, one at a time, and exactly if in doubt.
//!
//! The rays of a batch are cast one after another in the same run.

use super::state::{Candidate, RayHit, RayMode};
use crate::engine::expand::{self, Scratch};
use crate::engine::frontier::{Origin, Pair};
use crate::engine::outcome::StopReason;
use crate::engine::traversal::{Traversal, Visitor};
use crate::model::cost::{
    MAX_STEP_WORK, WORK_PER_CLOSEST_POINTS, WORK_PER_EXACT_TEST, WORK_PER_LOOKUP,
    WORK_PER_POINT_TRIANGLE, WORK_PER_RAY, WORK_PER_RAY_NODE, WORK_PER_RAY_TEST,
    WORK_PER_RAY_TRIANGLE,
};
use crate::tree::WIDTH;
use punctual_geom::Ray;
use punctual_geom::bits;
use punctual_geom::lanes::Lanes;
use punctual_geom::triangle::ray::ball::{BallStep, MovingBall};
use punctual_geom::triangle::ray::batch::candidates;
use punctual_geom::triangle::ray::{Aim, Side};

/// The question what rays hit.
pub(super) struct Cast<'q> {
    mode: RayMode,
    /// The current ray and those after it.
    rays: &'q [Ray],
}

impl<'q> Cast<'q> {
    /// Continues with the first of `rays`, which must not be empty.
    pub fn new(rays: &'q [Ray], mode: RayMode) -> Self {
        Self { mode, rays }
    }
}

/// The node that a ray enters first.
pub(super) const ROOT: Pair = Pair::keyed(0, 0.0);

/// Maximum number of nodes opened in one step, each a child of the previous one.
const NODES_PER_STEP: u64 = 3;

/// Steps of a ball towards a triangle in one step of a query.
const BALL_STEPS: u64 = 2;

const _: () = assert!(MAX_STEP_WORK >= WORK_PER_RAY_TEST + BALL_STEPS * WORK_PER_POINT_TRIANGLE);
const _: () = assert!(
    MAX_STEP_WORK
        >= WORK_PER_RAY + NODES_PER_STEP * WORK_PER_RAY_NODE + WIDTH as u64 * WORK_PER_RAY_TRIANGLE
);

impl<const POINTS: bool> Visitor for Traversal<'_, '_, Cast<'_>, POINTS> {
    const ASKS_OF_FLUSHING: bool = false;

    #[inline(always)]
    fn next_pair(&mut self) -> Option<(Pair, Origin)> {
        match self.workspace.frontier.pop_stack() {
            Some(pair) => Some((pair, Origin::Stack)),
            None => self.next_ray(),
        }
    }

    /// Continues with the child entered first, some nodes at a time.
    #[inline(always)]
    fn open<L: Lanes>(&mut self, lanes: L, mut pair: Pair, _: &mut Scratch) {
        if pair.nodes[0] == ROOT.nodes[0] {
            self.workspace.run.stats.work += WORK_PER_RAY;
        }
        let mut left = NODES_PER_STEP;
        loop {
            left -= 1;
            match self.visit(lanes, pair) {
                None => return,
                Some(next) if left > 0 => pair = next,
                Some(next) => {
                    self.workspace.frontier.push(next);
                    return;
                }
            }
        }
    }

    #[inline(always)]
    fn waits(&self, _any: bool) -> bool {
        !self.workspace.state.rays.candidates.is_empty()
    }

    #[inline(always)]
    fn test<L: Lanes>(&mut self, _lanes: L) -> Option<StopReason> {
        let state = &mut self.workspace.state.rays;
        if self.question.mode == RayMode::All && state.hits.len() == state.hits.capacity() {
            return Some(StopReason::PairsFull);
        }
        let candidate = state.candidates.pop();
        self.workspace.testing = !self.workspace.state.rays.candidates.is_empty();
        candidate
            .filter(|candidate| candidate.enter <= self.workspace.state.rays.local_ray.to)
            .and_then(|candidate| self.examine(candidate))
    }
}

impl<const POINTS: bool> Traversal<'_, '_, Cast<'_>, POINTS> {
    /// Replaces a node by its children that the ray enters, or by the triangles that it may hit.
    /// Returns the child entered first; the others are on the stack.
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, lanes: L, pair: Pair) -> Option<Pair> {
        let (index, entry) = (pair.nodes[0], pair.key());
        if entry > self.workspace.state.rays.local_ray.to {
            self.workspace.run.stats.work += WORK_PER_LOOKUP;
            return None;
        }
        let mut leaf = None;
        let (node, points) = expand::node::<POINTS, L>(lanes, self.a, index, &mut leaf);
        let local_ray = &self.workspace.state.rays.local_ray;
        let (enter, entered) = local_ray.enter(lanes, node, entry);
        let stats = &mut self.workspace.run.stats;
        stats.bv_tests += u64::from(node.children);
        stats.work += WORK_PER_RAY_NODE;
        if entered == 0 {
            return None;
        }
        if !node.is_leaf {
            let (nodes, frontier) = (self.a.nodes(), &mut self.workspace.frontier);
            return Some(frontier.push_nearest(nodes, node.first_child, entered, &enter));
        }
        let count = u64::from(node.children);
        stats.primitive_tests += count;
        stats.work += WORK_PER_RAY_TRIANGLE * count;
        if self.workspace.state.rays.radius > 0.0 {
            for lane in bits(entered) {
                self.workspace.state.rays.candidates.push(Candidate {
                    triangle: node.first_child + lane as u32,
                    enter: enter[lane],
                    faces: None,
                    free_until: 0.0,
                });
            }
            return None;
        }
        let found = candidates(
            lanes,
            expand::rows(self.a, points, node),
            &local_ray.unit_ray,
            [local_ray.from, local_ray.to],
        );
        for lane in bits(found.may_meet & entered) {
            let (triangle, faces) = (node.first_child + lane as u32, found.faces(lane));
            self.workspace.state.rays.candidates.push(Candidate {
                triangle,
                enter: enter[lane],
                faces,
                free_until: 0.0,
            });
        }
        None
    }

    /// Tests a triangle in `f64`.
    #[inline(always)]
    fn examine(
        &mut self,
        candidate @ Candidate {
            triangle, faces, ..
        }: Candidate,
    ) -> Option<StopReason> {
        if self.workspace.state.rays.radius > 0.0 {
            self.approach(candidate);
            return None;
        }
        let id = self.a.ids()[triangle as usize];
        let (found, was_exact) =
            Aim::new(&self.question.rays[0]).hit(&self.a.mesh().triangle(id as usize), faces);
        let stats = &mut self.workspace.run.stats;
        stats.work += WORK_PER_RAY_TEST;
        if was_exact {
            stats.exact_tests += 1;
            stats.work += WORK_PER_EXACT_TEST;
            self.deadline.allow_for_long_step();
        }
        if let Some((t, side)) = found {
            self.report(id, t, side);
        }
        None
    }

    /// Moves a ball along the ray towards a triangle, some steps at a time.
    #[cold]
    fn approach(&mut self, mut candidate: Candidate) {
        let ray = &self.question.rays[0];
        let state = &mut self.workspace.state.rays;
        let id = self.a.ids()[candidate.triangle as usize];
        let corners = self.a.corners(candidate.triangle);
        let ball = MovingBall::new(ray, state.radius);
        let stats = &mut self.workspace.run.stats;
        stats.work += WORK_PER_RAY_TEST;
        for _ in 0..BALL_STEPS {
            let (step, was_long) = ball.step(&corners, candidate.free_until);
            stats.work += WORK_PER_POINT_TRIANGLE;
            if was_long {
                stats.work += WORK_PER_CLOSEST_POINTS;
                self.deadline.allow_for_long_step();
            }
            match step {
                BallStep::Misses => return,
                BallStep::FreeUntil(length) => candidate.free_until = length,
                BallStep::Touches(t, side) => {
                    let [t_min, t_max] = ray.limits();
                    if t_min <= t && t <= t_max {
                        self.report(id, t, side);
                    }
                    return;
                }
            }
        }
        state.candidates.push(candidate);
        self.workspace.testing = true;
    }

    /// Takes a hit.
    #[inline(always)]
    fn report(&mut self, id: u32, t: f64, side: Side) {
        let hit = RayHit {
            triangle: id,
            t,
            side,
        };
        let workspace = &mut *self.workspace;
        workspace.run.stats.found += 1;
        let state = &mut workspace.state.rays;
        if state.hit.is_none_or(|before| hit.is_before(&before)) {
            state.hit = Some(hit);
        }
        match self.question.mode {
            RayMode::Nearest => state.local_ray.cut(t),
            RayMode::All => state.hits.push(hit),
            RayMode::Any => {
                state.candidates.clear();
                workspace.frontier.clear();
                workspace.testing = false;
            }
        }
    }

    /// Continues with the next ray of the batch, if there is one.
    #[inline(always)]
    fn next_ray(&mut self) -> Option<(Pair, Origin)> {
        let rays = &mut self.question.rays;
        let rest = rays.get(1..).filter(|rest| !rest.is_empty())?;
        let state = &mut self.workspace.state.rays;
        // Copies field by field, as the hit was stored: a load that spans several recent stores
        // would wait until all of them are in the cache.
        state.first_hits.push(None);
        let answer = state.first_hits.last_mut()?;
        if let Some(RayHit { triangle, t, side }) = state.hit {
            *answer = Some(RayHit { triangle, t, side });
            state.hit = None;
        }
        (state.done, state.after) = (state.done + 1, rest.len() - 1);
        (state.local_ray).follow(self.a.unit(), &rest[0], state.radius);
        *rays = rest;
        Some((ROOT, Origin::Stack))
    }
}

#[cfg(test)]
mod tests {
    use crate::engine::expand;
    use crate::mesh::shapes;
    use crate::tree::solid::local_ray::LocalRay;
    use crate::tree::{Node, Tree};
    use glam::DVec3;
    use punctual_geom::Ray;
    use punctual_geom::lanes::{Instructions, Kernel, Lanes};
    use punctual_geom::random::Random;
    use punctual_geom::triangle::ray::batch::{Candidates, candidates};
    use robust::{Coord3D, orient3d};

    struct Leaf<'r>(&'r Tree, &'r Node, &'r LocalRay);

    impl Kernel for Leaf<'_> {
        type Output = Candidates;

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Candidates {
            let Self(tree, node, local_ray) = self;
            candidates(
                lanes,
                expand::rows(tree, None, node),
                &local_ray.unit_ray,
                [local_ray.from, local_ray.to],
            )
        }
    }

    /// The sides on which the line from `origin` to `target` passes the edges of a triangle.
    fn exact_sides([origin, target]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> [i8; 3] {
        let point = |v: DVec3| Coord3D {
            x: v.x,
            y: v.y,
            z: v.z,
        };
        let determinant = |p, q| orient3d(point(target), point(p), point(q), point(origin));
        [determinant(a, b), determinant(b, c), determinant(c, a)]
            .map(|x| i8::from(x > 0.0) - i8::from(x < 0.0))
    }

    /// Segments past points of edges, from near and far, offset by all amounts between certain and
    /// in doubt.
    #[test]
    fn sides_that_are_certain_are_the_exact_ones() {
        let mut random = Random::new(7);
        let tree = Tree::new(shapes::torus_knot(2, 3, 0.2, 30));
        let (mut certain, mut in_doubt) = (0, 0);
        for node in tree.nodes().iter().filter(|node| node.is_leaf) {
            let corners = |lane: u32| {
                tree.mesh()
                    .triangle(tree.ids()[(node.first_child + lane) as usize] as usize)
            };
            for (far, power) in [0.1, 1.0, 1e3, 1e7]
                .into_iter()
                .flat_map(|far| (1..30).map(move |power| (far, power)))
            {
                let mut vector =
                    || DVec3::from_array([(); 3].map(|()| random.fraction() * 2.0 - 1.0));
                let [a, b, _] = corners(0);
                let (origin, off) = (a + vector() * far, vector());
                let target = a.lerp(b, off.x * 0.5 + 0.5) + off * 0.5_f64.powi(power);
                let local_ray = LocalRay::new(
                    tree.unit(),
                    &Ray::segment(origin, target).expect("another point"),
                );
                for instructions in [Instructions::detect(), Instructions::PORTABLE] {
                    let found = instructions.run(Leaf(&tree, node, &local_ray));
                    for lane in 0..node.children.into() {
                        let exact = exact_sides([origin, target], corners(lane));
                        match found.faces(lane as usize) {
                            Some(faces) => assert_eq!(exact, [faces; 3], "{origin}, {target}"),
                            None => in_doubt += u32::from(exact == [1; 3] || exact == [-1; 3]),
                        }
                        certain += u32::from(found.faces(lane as usize).is_some());
                    }
                }
            }
        }
        assert!(
            certain > 5_000 && in_doubt > 5_000,
            "{certain} certain, {in_doubt} in doubt"
        );
    }
}
