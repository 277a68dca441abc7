//! Contact-curve tracing: follows curves from one triangle pair to the next
//! ([`trace`](super::trace)).
//!
//! Two ends are traced alternately, because each step waits for results of the step before.

use super::known::Added;
use super::meeting::Meeting;
use super::state::IntersectionState;
use super::trace::{Place, Trace, first, place};
use crate::engine::traversal::Traversal;
use crate::engine::triangles::ids;
use crate::engine::workspace::Workspace;
use crate::mesh::Vertices;
use crate::model::cost::{
    MAX_STEP_WORK, WORK_PER_LOOKUP, WORK_PER_TRACE, WORK_PER_TRACE_BESIDE, WORK_PER_TRACE_STEP,
};
use crate::tree::Tree;
use punctual_geom::lanes::{D4, Kernel, Lanes, per_axis};

/// Pairs along curves found in one step of the loop.
const STEPS: usize = 4;

const _: () = assert!(STEPS as u64 * WORK_PER_TRACE_STEP <= MAX_STEP_WORK);

/// A tracing step of the loop, compiled separately because it is rare.
struct TraceOn<'t, 'q, 'c, 'o, const POINTS: bool>(&'t mut Traversal<'q, 'c, Meeting<'o>, POINTS>);

impl<const POINTS: bool> Kernel for TraceOn<'_, '_, '_, '_, POINTS> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        self.0.trace(lanes);
    }
}

impl<const POINTS: bool> Traversal<'_, '_, Meeting<'_>, POINTS> {
    /// Traces the waiting curves a little.
    #[inline(always)]
    pub(crate) fn trace_on<L: Lanes>(&mut self, lanes: L) {
        let before = self.workspace.run.stats.work;
        lanes.run(TraceOn(self));
        self.workspace.state.intersection.trace.work += self.workspace.run.stats.work - before;
    }

    /// Starts curves at the latest hit if an end is free; else advances the active ends by a few
    /// pairs.
    #[inline(always)]
    fn trace<L: Lanes>(&mut self, lanes: L) {
        let Trace { hits, ends, .. } = &self.workspace.state.intersection.trace;
        if !(ends[0].follows && ends[1].follows || hits.is_empty()) {
            return self.begin_trace(lanes);
        }
        let mut at = usize::from(!ends[0].follows);
        let other = usize::from(ends[0].follows && ends[1].follows);
        for _ in 0..self.room().min(STEPS) {
            if !self.trace_step(lanes, at & 1) {
                self.workspace.state.intersection.trace.ends[at & 1].follows = false;
                break;
            }
            at ^= other;
        }
    }

    /// Starts a curve for each free end, at an edge of the latest hit beyond which the pair is
    /// unknown.
    #[inline(always)]
    fn begin_trace<L: Lanes>(&mut self, lanes: L) {
        let Some((pair, mut crossings)) = self.workspace.state.intersection.trace.hits.pop() else {
            return;
        };
        let mut placed = None;
        for free in 0..2 {
            if self.workspace.state.intersection.trace.ends[free].follows {
                continue;
            }
            let Some((side, edge)) = self.next_edge(pair, &mut crossings) else {
                return;
            };
            if let Some(placed) = placed.replace(free) {
                self.workspace.run.stats.work += WORK_PER_TRACE_BESIDE;
                self.workspace.state.intersection.trace.ends[free] =
                    self.workspace.state.intersection.trace.ends[placed].clone();
            } else {
                self.workspace.run.stats.work += WORK_PER_TRACE;
                self.place_end(lanes, free, pair);
            }
            let end = &mut self.workspace.state.intersection.trace.ends[free];
            end.follows = end.curve.begin(lanes, side, edge);
        }
        if crossings != 0 {
            let trace = &mut self.workspace.state.intersection.trace;
            let _ = trace.hits.try_push((pair, crossings));
        }
    }

    /// Places an end at a pair.
    #[inline(always)]
    fn place_end<L: Lanes>(&mut self, lanes: L, end: usize, pair: [u32; 2]) {
        let (trees, trace) = (
            [self.a, self.b],
            &mut self.workspace.state.intersection.trace,
        );
        trace.places[1] = place(self.b_in_a);
        let [of_a, of_b] =
            trees.map(|tree| (tree.mesh().aabb().max - tree.mesh().aabb().min).length());
        let mut corners = [[D4::splat(lanes, 0.0); 3]; 2];
        let end = &mut trace.ends[end & 1];
        for side in 0..2 {
            let (tree, triangle) = (trees[side], pair[side]);
            let (vertices, all) = (tree.vertices_of(triangle), tree.mesh().vertices());
            corners[side] = per_axis!(i => vertex(lanes, all, vertices[i], &trace.places[side]));
            end.at[side] = Place { triangle, vertices };
        }
        end.curve.place(corners, 1.01 * (of_a + of_b));
    }

    /// Takes the next crossing edge of a pair beyond which the pair of triangles is not known yet.
    /// Earlier ones are dropped.
    #[inline(always)]
    fn next_edge(&mut self, pair: [u32; 2], crossings: &mut u32) -> Option<(usize, usize)> {
        let trees = [self.a, self.b];
        while *crossings != 0 {
            let edge = crossings.trailing_zeros() as usize;
            *crossings &= *crossings - 1;
            self.workspace.run.stats.work += WORK_PER_LOOKUP;
            let (side, edge) = (usize::from(edge >= 3), edge % 3);
            let Some(across) = trees[side].across(pair[side], edge) else {
                continue;
            };
            let mut next = pair;
            next[side] = across;
            let known = &self.workspace.state.intersection.trace.known;
            if !known.has(first(trees, next), next) {
                return Some((side, edge));
            }
        }
        None
    }

    /// Moves an end to the next pair and reports it. False if the curve ends.
    #[inline(always)]
    fn trace_step<L: Lanes>(&mut self, lanes: L, at: usize) -> bool {
        let trees = [self.a, self.b];
        let Workspace { run, state, .. } = &mut *self.workspace;
        let IntersectionState {
            trace,
            found,
            sample,
            ..
        } = &mut state.intersection;
        let end = &mut trace.ends[at];
        let (side, edge) = end.curve.crosses();
        run.stats.work += WORK_PER_TRACE_STEP;
        let Some(new) = end.at[side].cross(trees[side], edge.apex()) else {
            return false;
        };
        let pair = [end.at[0].triangle, end.at[1].triangle];
        let added = trace.known.add(first(trees, pair), pair);
        if added != Added::New {
            if added == Added::NoRoom {
                trace.stop();
            }
            return false;
        }
        sample.note(pair, run.stats.found);
        run.stats.found += 1;
        trace.followed += 1;
        found.push(ids(trees, pair));
        let corner = vertex(
            lanes,
            trees[side].mesh().vertices(),
            new,
            &trace.places[side],
        );
        end.curve.advance(lanes, (side, edge), corner)
    }
}

impl Workspace {
    /// Removes, from the triangle pairs that wait or are in doubt, those that are known.
    pub(crate) fn drop_known(&mut self, trees: [&Tree; 2]) {
        let trace = &mut self.state.intersection.trace;
        let mut is_new = |&mut pair: &mut [u32; 2]| {
            let is_known = trace.knows(trees, pair);
            trace.passed += u64::from(is_known);
            !is_known
        };
        self.waiting.retain(&mut is_new);
        self.uncertain.retain(is_new);
    }
}

/// A vertex in A's frame. Has the bits of `Pose::transform_point`, except for the sign of a zero.
#[inline(always)]
fn vertex<L: Lanes>(lanes: L, vertices: &Vertices, index: u32, place: &[[f64; 4]; 4]) -> D4<L> {
    let [x, y, z] = match vertices {
        Vertices::F32(vertices) => vertices[index as usize].map(f64::from),
        Vertices::F64(vertices) => vertices[index as usize],
    };
    let [x, y, z] = [
        D4::splat(lanes, x),
        D4::splat(lanes, y),
        D4::splat(lanes, z),
    ];
    let [of_x, of_y, of_z, origin] = place;
    let sum = D4::load(lanes, of_x) * x + D4::load(lanes, of_y) * y + D4::load(lanes, of_z) * z;
    sum + D4::load(lanes, origin)
}
