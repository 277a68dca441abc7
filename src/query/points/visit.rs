//! Points among the nodes and triangles of one tree: a ray that is counted along, the boundary of
//! an open surface, and the nearest triangle; one after the other for each point.
//!
//! As in ray casts, nodes have keys ([`Pair::keyed`]), used for the nearest triangle only. Nodes
//! are finished depth-first.

use super::near::Near;
use super::rim::{Turn, Viewer};
use super::state::Phase;
use super::{PointBounds, SignedDistance};
use crate::engine::expand::Scratch;
use crate::engine::frontier::{Origin, Pair};
use crate::engine::outcome::StopReason;
use crate::engine::traversal::{Traversal, Visitor};
use crate::engine::workspace::Workspace;
use crate::model::cost::{
    MAX_DISTANCE_STEP_WORK, MAX_STEP_WORK, WORK_PER_CLOSEST_POINTS, WORK_PER_EXACT_TEST,
    WORK_PER_LOOKUP, WORK_PER_OPEN_EDGE, WORK_PER_POINT, WORK_PER_POINT_TRIANGLE,
    WORK_PER_RAY_NODE, WORK_PER_RAY_TRIANGLE,
};
use crate::tree::solid::inside::{Count, Probe};
use crate::tree::{Node, Solidity, Tree, WIDTH};
use glam::DVec3;
use punctual_geom::bits;
use punctual_geom::lanes::Lanes;

/// The question where points are.
pub(crate) struct Locate<'q> {
    pub source: Source<'q>,
}

/// Where the points come from.
#[derive(Clone, Copy)]
pub(crate) enum Source<'q> {
    /// The points left at the begin of the call, in the frame of the tree.
    Points(&'q [[f64; 3]]),
    /// A vertex of each component of the other body of a pair, whose pose is that of the traversal.
    /// Ends with the first that is inside.
    Samples {
        inner: &'q Tree,
        /// True if the points are of B, and the tree is A's.
        is_b: bool,
    },
}

const ROOT: Pair = Pair::keyed(0, 0.0);

/// Maximum number of nodes opened in one step.
const NODES_PER_STEP: u32 = 3;

/// Number of vertices and edges of a boundary that are visited in one step, four and four.
const EDGES_PER_STEP: usize = 32;

const _: () = assert!(
    MAX_STEP_WORK
        >= WORK_PER_POINT
            + NODES_PER_STEP as u64 * WORK_PER_RAY_NODE
            + WIDTH as u64 * WORK_PER_RAY_TRIANGLE
        && MAX_DISTANCE_STEP_WORK >= WORK_PER_POINT_TRIANGLE + WORK_PER_CLOSEST_POINTS
        && MAX_STEP_WORK >= EDGES_PER_STEP as u64 * WORK_PER_OPEN_EDGE + WORK_PER_POINT
);

impl Visitor for Traversal<'_, '_, Locate<'_>> {
    const ASKS_OF_FLUSHING: bool = false;

    #[inline(always)]
    fn next_pair(&mut self) -> Option<(Pair, Origin)> {
        let next = match self.question.source {
            Source::Points(_) => self.workspace.frontier.pop_stack(),
            Source::Samples { .. } => {
                let node = self.workspace.state.points.stack.pop();
                node.map(|node| Pair::new(node, 0))
            }
        };
        if let Some(pair) = next {
            return Some((pair, Origin::Stack));
        }
        // A boundary is visited by tests; all else begins with the root.
        self.next_phase().then_some((ROOT, Origin::Stack))
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, lanes: L, mut pair: Pair, _: &mut Scratch) {
        for _ in 0..NODES_PER_STEP {
            let next = match self.workspace.state.points.phase {
                Phase::Ray => self.follow(lanes, pair),
                _ => self.approach(lanes, pair),
            };
            match next {
                None => return,
                Some(next) => pair = next,
            }
        }
        self.wait(pair);
    }

    #[inline(always)]
    fn waits(&self, any: bool) -> bool {
        !self.workspace.state.points.uncertain.is_empty()
            || any
                && matches!(self.workspace.state.points.phase, Phase::Rim { done } if done < self.rim_len())
    }

    #[inline(always)]
    fn test<L: Lanes>(&mut self, lanes: L) -> Option<StopReason> {
        match self.workspace.state.points.phase {
            Phase::Rim { done } => self.look(lanes, done),
            Phase::Ray => self.examine(),
            _ => self.settle(),
        }
        self.workspace.testing = self.waits(false);
        None
    }
}

impl Traversal<'_, '_, Locate<'_>> {
    /// Number of vertices and edges of the boundary.
    fn rim_len(&self) -> usize {
        let rim = self.a.solid().map(|solid| solid.rim());
        rim.map_or(0, |(vertices, edges)| vertices.len() + edges.len())
    }

    /// Begins what comes next, when nothing is left of the current phase. Returns true if that
    /// begins with the root.
    #[inline(always)]
    fn next_phase(&mut self) -> bool {
        let rim = self.rim_len();
        let state = &mut self.workspace.state.points;
        match state.phase {
            Phase::Idle => false,
            Phase::Start => {
                self.start();
                true
            }
            Phase::Ray if rim > 0 => {
                state.turn = Turn::NONE;
                state.phase = Phase::Rim { done: 0 };
                false
            }
            Phase::Rim { done } if done < rim => false,
            Phase::Ray | Phase::Rim { .. } => {
                let (turned, error) = match state.phase {
                    Phase::Ray => (0.0, 0.0),
                    _ => state.turn.winding(),
                };
                state.winding = Some((f64::from(state.count.winding) - turned, error));
                let is_apart = !state.count.is_on_surface && !self.a.nodes().is_empty();
                if state.measures && is_apart {
                    state.near = Near::new(self.a, state.point);
                    state.phase = Phase::Near;
                    self.workspace.run.stats.work += WORK_PER_POINT_TRIANGLE;
                    return true;
                }
                self.finish()
            }
            Phase::Near => self.finish(),
        }
    }

    /// Ends with the current point. Returns true if there is another; it is begun.
    fn finish(&mut self) -> bool {
        let bounds = self.workspace.point_bounds(self.a, true);
        let state = &mut self.workspace.state.points;
        state.left -= 1;
        match self.question.source {
            Source::Points(_) => state.found.push(bounds),
            Source::Samples { .. } if bounds.inside == Some(true) && !bounds.is_on_surface => {
                (state.is_within, state.left) = (true, 0);
            }
            Source::Samples { .. } => {}
        }
        if state.left == 0 {
            state.phase = Phase::Idle;
            return false;
        }
        self.start();
        true
    }

    /// Begins with the next point.
    #[inline(always)]
    fn start(&mut self) {
        let state = &mut self.workspace.state.points;
        state.probe = match self.question.source {
            Source::Points(points) => {
                let point = points[points.len() - state.left];
                Probe::new(self.a, DVec3::from_array(point))
            }
            Source::Samples { inner, is_b } => {
                let components = inner.solid().map_or(&[][..], Solidity::components);
                let component = &components[components.len() - state.left];
                let [corner, ..] = inner.mesh().triangle(component.first_triangle as usize);
                if is_b {
                    Probe::new(self.a, self.b_in_a.transform_point(corner))
                } else {
                    Probe::posed(self.a, self.b_in_a, corner)
                }
            }
        };
        state.point = state.probe.point;
        (state.count, state.winding) = (Count::default(), None);
        state.phase = Phase::Ray;
        self.workspace.run.stats.work += WORK_PER_POINT;
    }

    /// Puts a node on the stack.
    #[inline(always)]
    fn wait(&mut self, pair: Pair) {
        match self.question.source {
            Source::Points(_) => {
                self.workspace.frontier.push(pair);
            }
            Source::Samples { .. } => self.workspace.state.points.stack.push(pair.nodes[0]),
        }
    }

    /// Replaces a node by its children that the ray enters. Returns one of them; the others are on
    /// the stack.
    #[inline(always)]
    fn follow<L: Lanes>(&mut self, lanes: L, pair: Pair) -> Option<Pair> {
        let probe = &self.workspace.state.points.probe;
        if probe.is_outside {
            self.workspace.run.stats.work += WORK_PER_LOOKUP;
            return None;
        }
        let node = &self.a.nodes()[pair.nodes[0] as usize];
        let entered = probe.enter(lanes, node);
        let sorted =
            (node.is_leaf && entered != 0).then(|| probe.sort(lanes, self.a, node, entered));
        self.workspace.count_node(node);
        let child = |i: usize| node.first_child + i as u32;
        if let Some([leaves, enters, in_doubt]) = sorted {
            self.workspace.state.points.count.winding +=
                leaves.count_ones() as i32 - enters.count_ones() as i32;
            let uncertain = &mut self.workspace.state.points.uncertain;
            bits(in_doubt).for_each(|i| uncertain.push([child(i), 0]));
            return None;
        }
        let mut entered = bits(if node.is_leaf { 0 } else { entered });
        let first = entered.next();
        entered.for_each(|i| self.wait(Pair::new(child(i), 0)));
        first.map(|i| Pair::new(child(i), 0))
    }

    /// Counts a triangle that `f32` left in doubt.
    #[inline(always)]
    fn examine(&mut self) {
        let Some([triangle, _]) = self.workspace.state.points.uncertain.pop() else {
            return;
        };
        let state = &mut self.workspace.state.points;
        let corners = self.a.corners(triangle);
        let corners = match self.question.source {
            // The tree is B's, and the point is in A's frame.
            Source::Samples { is_b: false, .. } => {
                corners.map(|corner| self.b_in_a.transform_point(corner))
            }
            _ => corners,
        };
        state.probe.examine(&corners, triangle, &mut state.count);
        let stats = &mut self.workspace.run.stats;
        stats.exact_tests += 1;
        stats.work += WORK_PER_EXACT_TEST;
        self.deadline.allow_for_long_step();
    }

    /// Looks at some vertices or edges of the boundary.
    #[inline(always)]
    fn look<L: Lanes>(&mut self, lanes: L, done: usize) {
        let Some(solid) = self.a.solid() else {
            return;
        };
        let ((rim, edges), mesh) = (solid.rim(), self.a.mesh());
        let state = &mut self.workspace.state.points;
        let viewer = Viewer::new(mesh, state.point, state.probe.heading);
        let count = if done < rim.len() {
            let some = &rim[done..rim.len().min(done + EDGES_PER_STEP)];
            if done == 0 {
                state.seen.clear();
            }
            for four in some.chunks(4) {
                let vertex = |i: usize| mesh.vertex(four[i.min(four.len() - 1)] as usize);
                let seen = viewer.see(lanes, [vertex(0), vertex(1), vertex(2), vertex(3)]);
                state.seen.extend_from_slice(&seen[..four.len()]);
            }
            some.len()
        } else {
            let first = done - rim.len();
            let some = &edges[first..edges.len().min(first + EDGES_PER_STEP)];
            for four in some.chunks(4) {
                viewer.turn(lanes, &mut state.turn, four, &state.seen, |ends| {
                    ends.map(|i| mesh.vertex(rim[i as usize] as usize))
                });
            }
            some.len()
        };
        state.phase = Phase::Rim { done: done + count };
        self.workspace.run.stats.work += count as u64 * WORK_PER_OPEN_EDGE;
    }

    /// Replaces a node by its children that may hold the nearest triangle. Returns the nearest
    /// child; the others are on the stack.
    #[inline(always)]
    fn approach<L: Lanes>(&mut self, lanes: L, pair: Pair) -> Option<Pair> {
        let near = &self.workspace.state.points.near;
        if pair.key() >= near.cut {
            self.workspace.run.stats.work += WORK_PER_LOOKUP;
            return None;
        }
        let node = &self.a.nodes()[pair.nodes[0] as usize];
        let (keys, chosen) = near.keys(lanes, node);
        self.workspace.count_node(node);
        if chosen == 0 {
            return None;
        }
        if !node.is_leaf {
            return Some(self.workspace.frontier.push_nearest(
                self.a.nodes(),
                node.first_child,
                chosen,
                &keys,
            ));
        }
        let uncertain = &mut self.workspace.state.points.uncertain;
        bits(chosen).for_each(|i| {
            uncertain.push([node.first_child + i as u32, keys[i % WIDTH].to_bits()]);
        });
        // The nearest last. Keys are positive, so their bits are ordered as they are.
        uncertain.sort_unstable_by_key(|&[triangle, key]| core::cmp::Reverse([key, triangle]));
        None
    }

    /// Tests the nearest of the triangles that wait.
    #[inline(always)]
    fn settle(&mut self) {
        let Some([triangle, key]) = self.workspace.state.points.uncertain.pop() else {
            return;
        };
        let state = &mut self.workspace.state.points;
        if f32::from_bits(key) >= state.near.cut {
            self.workspace.run.stats.work += WORK_PER_LOOKUP;
            return;
        }
        let was_long = state.near.settle(self.a, state.point, triangle);
        let stats = &mut self.workspace.run.stats;
        stats.work += WORK_PER_POINT_TRIANGLE;
        if was_long {
            stats.work += WORK_PER_CLOSEST_POINTS;
            self.deadline.allow_for_long_step();
        }
    }
}

impl PointBounds {
    /// Turns the bounds of a core into those of the solid thickened by `radius`.
    fn thicken(&mut self, radius: f64, is_finished: bool) {
        let Some(distance) = &mut self.distance else {
            return;
        };
        let rounding = |bound: f64| f64::EPSILON * (bound.abs() + radius);
        let (low, high) = (distance.low, distance.high);
        distance.low = low - radius - rounding(low);
        distance.high = high - radius + rounding(high);
        if self.inside != Some(true) {
            let is_known = self.inside.is_some();
            self.inside = if distance.high <= 0.0 {
                Some(true)
            } else if is_known && distance.low > 0.0 {
                Some(false)
            } else if is_known && is_finished {
                Some(true)
            } else {
                None
            };
        }
    }
}

impl Workspace {
    #[inline(always)]
    fn count_node(&mut self, node: &Node) {
        let stats = &mut self.run.stats;
        stats.bv_tests += u64::from(node.children);
        stats.work += WORK_PER_RAY_NODE;
        if node.is_leaf {
            stats.primitive_tests += u64::from(node.children);
            stats.work += WORK_PER_RAY_TRIANGLE * u64::from(node.children);
        }
    }

    /// Bounds for the current point.
    pub(super) fn point_bounds(&self, tree: &Tree, is_finished: bool) -> PointBounds {
        let state = &self.state.points;
        let mut bounds = PointBounds {
            winding: state.winding.map(|(winding, _)| winding),
            error: state.winding.map_or(f64::INFINITY, |(_, error)| error),
            inside: None,
            is_on_surface: state.count.is_on_surface,
            distance: None,
        };
        bounds.inside = match state.winding {
            _ if bounds.is_on_surface => Some(true),
            Some((winding, error)) if (winding - 0.5).abs() > error => Some(winding > 0.5),
            _ => None,
        };
        if !state.measures || tree.nodes().is_empty() {
            return bounds;
        }
        let id = |triangle: u32| tree.ids()[triangle as usize];
        bounds.distance = Some(if bounds.is_on_surface {
            SignedDistance {
                low: 0.0,
                high: 0.0,
                triangle: id(state.count.touched),
                point: state.point,
            }
        } else {
            let (near, low) = match state.phase {
                Phase::Near if is_finished => (state.near, state.near.finished()),
                Phase::Near => {
                    let open = self.frontier.iter().map(|pair| pair.key());
                    let uncertain = state.uncertain.iter().map(|left| f32::from_bits(left[1]));
                    let least = open.chain(uncertain).fold(f32::INFINITY, f32::min);
                    (state.near, state.near.low(tree, least))
                }
                _ => (Near::new(tree, state.point), 0.0),
            };
            let (triangle, point) = near.nearest;
            let [low, high] = match bounds.inside {
                Some(false) => [low, near.high],
                Some(true) => [-near.high, -low],
                None => [-near.high, near.high],
            };
            SignedDistance {
                low,
                high,
                triangle: id(triangle),
                point,
            }
        });
        if tree.radius() > 0.0 {
            bounds.thicken(tree.radius(), is_finished);
        }
        bounds
    }
}
