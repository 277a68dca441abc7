//! Tests whether the triangles that met last, or their neighbors, still meet: the cheapest test,
//! for eight pairs at once.

use super::batch::Desk;
use super::state::Turn;
use crate::ask::TurnKind;
use crate::body::{Bodies, Placed, triangle_ids};
use crate::cost::{WORK_PER_NEIGHBORS, WORK_PER_WITNESS};
use crate::id::PairKey;
use arrayvec::ArrayVec;
use core::mem;
use glam::DVec3;
use punctual::engine::{Deadline, flushing_matters};
use punctual::{PairMemory, Tree};
use punctual_geom::lanes::Instructions;
use punctual_geom::triangle::batch::Verdicts;
use punctual_geom::triangle::filter64::{Columns, Filter64};
use punctual_geom::triangles_intersect;
use punctual_geom::{Pose, bits};

/// Pairs tested at once.
pub(crate) const LANES: usize = 8;

/// The neighbors of a lost witness are tested if they met at least this often, and otherwise in one
/// frame of `PER_NEARBY`.
const LEAST_NEARBY: f32 = 0.2;
const PER_NEARBY: u64 = 16;

/// A pair that met, in a batch of tests.
#[derive(Clone, Debug)]
pub(crate) struct Test {
    pub key: PairKey,
    /// Its index in the list of known pairs.
    pub place: u32,
    /// The triangles to test (tree order); after a test that met, the triangles that meet (ids).
    pub witness: [u32; 2],
    pub outcome: Outcome,
}

/// The result of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// There was no time for it.
    Untested,
    Lost,
    Met,
}

impl Test {
    fn end(&mut self, met: Option<[u32; 2]>) {
        self.witness = met.unwrap_or(self.witness);
        self.outcome = if met.is_some() {
            Outcome::Met
        } else {
            Outcome::Lost
        };
    }
}

/// Contents of a lane: a pair, by its index in the batch, and its triangles (ids).
#[derive(Clone, Copy, Debug)]
struct Tested {
    at: usize,
    witness: [u32; 2],
}

/// The corners of two triangles (tree order), in A's frame.
#[inline]
fn corners([a, b]: [&Tree; 2], [x, y]: [u32; 2], b_in_a: &Pose) -> [[DVec3; 3]; 2] {
    let [p, q, r] = b.corners(y);
    [
        a.corners(x),
        [
            b_in_a.transform_point(p),
            b_in_a.transform_point(q),
            b_in_a.transform_point(r),
        ],
    ]
}

/// Pairs that wait for their test.
pub(crate) struct Retest<'b> {
    bodies: &'b Bodies,
    waiting: ArrayVec<Tested, LANES>,
    columns: [Columns; 2],
    instructions: Instructions,
}

impl<'b> Retest<'b> {
    pub fn new(bodies: &'b Bodies) -> Self {
        let (columns, instructions) = ([Columns::ZERO, Columns::ZERO], Instructions::detect());
        Self {
            bodies,
            waiting: ArrayVec::new(),
            columns,
            instructions,
        }
    }

    /// Tests witnesses of pairs, as far as the deadline allows.
    pub fn run(&mut self, tests: &mut [Test], deadline: &mut Deadline) {
        let mut next = 0;
        while next < tests.len() {
            while next < tests.len()
                && !self.waiting.is_full()
                && deadline.has_room(WORK_PER_WITNESS)
            {
                deadline.spend(WORK_PER_WITNESS);
                if self.add(next, &tests[next]).is_none() {
                    tests[next].outcome = Outcome::Lost;
                }
                next += 1;
            }
            if self.waiting.is_empty() {
                break;
            }
            let hits = meeting(self.instructions, &self.columns, self.waiting.len());
            for (lane, Tested { at, witness }) in
                mem::take(&mut self.waiting).into_iter().enumerate()
            {
                tests[at].end((hits >> lane & 1 != 0).then_some(witness));
            }
        }
    }

    /// Puts the witness of a pair into the next lane. `None` if it cannot be tested separately.
    #[inline]
    fn add(&mut self, at: usize, test: &Test) -> Option<()> {
        let [a, b] = self.bodies.pair(test.key)?;
        let (b_in_a, trees) = (a.relative(b), [&*a.body.tree, &*b.body.tree]);
        let witness = triangle_ids([a, b], test.witness)
            .filter(|_| !flushing_matters(trees[0], trees[1], &b_in_a))?;
        let [of_a, of_b] = corners(trees, test.witness, &b_in_a);
        let lane = self.waiting.len();
        self.columns[0].set(lane, &of_a);
        self.columns[1].set(lane, &of_b);
        self.waiting.push(Tested { at, witness });
        Some(())
    }
}

impl Turn {
    /// True if neighbors of the witness that was lost meet. Surfaces usually still meet nearby,
    /// unless they move far in a frame.
    #[inline]
    pub fn meets_beside(&mut self, pair: [&Placed; 2], b_in_a: &Pose, desk: &mut Desk) -> bool {
        let (state, frame) = (&mut *self.state, desk.round.frame);
        let is_new = state.is_lost(frame) && state.pending.work == 0;
        if !is_new || self.kind != TurnKind::Meet || !desk.deadline.has_room(WORK_PER_NEIGHBORS) {
            return false;
        }
        // Tested sometimes even if not expected to meet, because the expectation may be outdated.
        let is_due =
            state.nearby >= LEAST_NEARBY || (frame ^ self.known.key).is_multiple_of(PER_NEARBY);
        let met = if is_due {
            desk.deadline.spend(WORK_PER_NEIGHBORS);
            self.spent.work += WORK_PER_NEIGHBORS;
            let met = beside(pair, b_in_a, &mut state.memory);
            state.learn_nearby(met.is_some());
            met
        } else {
            None
        };
        state.note_test(met, frame);
        met.is_some()
    }
}

/// Tests the neighbors of the latest witness: one of its triangles with the neighbor of the other
/// across an edge. Returns the ids of two that meet, and stores them in the memory.
fn beside(pair: [&Placed; 2], b_in_a: &Pose, memory: &mut PairMemory) -> Option<[u32; 2]> {
    let trees = pair.map(|placed| &*placed.body.tree);
    let latest = memory.witness(0)?;
    triangle_ids(pair, latest).filter(|_| !flushing_matters(trees[0], trees[1], b_in_a))?;
    let mut columns = [Columns::ZERO, Columns::ZERO];
    for (columns, corners) in columns.iter_mut().zip(&corners(trees, latest, b_in_a)) {
        columns.fill(corners);
    }
    let mut next = ArrayVec::<_, LANES>::new();
    for (side, tree) in trees.into_iter().enumerate() {
        let (triangle, corners) = (latest[side], tree.vertices_of(latest[side]));
        for edge in 0..3 {
            let Some(across) = tree.across(triangle, edge) else {
                continue;
            };
            let apex = (edge + 2) % 3;
            let vertex = tree.vertex_across(triangle, corners[apex], across);
            let vertex = tree.mesh().vertex(vertex as usize);
            let vertex = if side == 0 {
                vertex
            } else {
                b_in_a.transform_point(vertex)
            };
            columns[side].set_corner(next.len(), apex, vertex);
            let mut pair = latest;
            pair[side] = across;
            next.push(pair);
        }
    }
    let hits = meeting(Instructions::detect(), &columns, next.len());
    let found = *next.get(hits.trailing_zeros() as usize)?;
    memory.found(found);
    triangle_ids(pair, found)
}

/// Mask of the first `count` pairs of triangles that meet.
fn meeting(instructions: Instructions, [a, b]: &[Columns; 2], count: usize) -> u32 {
    let Verdicts { hit, doubt } = instructions.run(Filter64 { a, b, count });
    let wanted = (1 << count) - 1;
    let in_doubt =
        bits(doubt & wanted).filter(|&lane| triangles_intersect(&a.get(lane), &b.get(lane)));
    in_doubt.fold(hit & wanted, |hits, lane| hits | 1 << lane)
}
