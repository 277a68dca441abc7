//! Whether the triangles that met last still do, or those next to them: the cheapest question, asked of eight pairs at once.

use super::state::PairState;
use crate::math::lanes::Instructions;
use crate::math::{Pose, bits};
use crate::model::cost::{WORK_PER_NEIGHBORS, WORK_PER_WITNESS};
use crate::query::Deadline;
use crate::scene::body::Bodies;
use crate::scene::id::PairKey;
use crate::tree::Tree;
use crate::triangle::again::{Again, Columns};
use crate::triangle::batch::Verdicts;
use crate::triangle::triangles_intersect;
use alloc::boxed::Box;
use arrayvec::ArrayVec;
use core::mem;
use glam::DVec3;

/// Pairs that are tested at once.
pub(crate) const LANES: usize = 8;

/// How many of the latest witnesses of a pair are tested, one after the other.
pub(crate) const WITNESSES: usize = 2;

/// A pair that met, in a batch of tests. All that is needed to deal and to collect it is here.
#[derive(Clone, Debug)]
pub(crate) struct Test {
    pub state: Box<PairState>,
    pub key: PairKey,
    /// Its place among the known pairs.
    pub place: u32,
    pub outcome: Outcome,
}

/// What came of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// There was no time for it.
    Untested,
    Lost,
    /// These triangles meet (ids).
    Met([u32; 2]),
}

impl Test {
    fn end(&mut self, witness: Option<[u32; 2]>, frame: u64) {
        self.state.note_test(witness, frame);
        self.outcome = witness.map_or(Outcome::Lost, Outcome::Met);
    }
}

/// What is in a lane.
#[derive(Clone, Copy, Debug)]
struct Tested {
    /// The pair, by its place in the batch.
    at: usize,
    /// Which of its latest witnesses, and its triangles.
    number: usize,
    witness: [u32; 2],
}

/// The corners of two triangles (tree order), in A's frame.
#[inline]
fn corners([a, b]: [&Tree; 2], [x, y]: [u32; 2], b_in_a: &Pose) -> [[DVec3; 3]; 2] {
    let [p, q, r] = b.corners(y);
    [a.corners(x), [b_in_a.transform_point(p), b_in_a.transform_point(q), b_in_a.transform_point(r)]]
}

/// Their ids.
#[inline]
fn ids([a, b]: [&Tree; 2], [x, y]: [u32; 2]) -> [u32; 2] {
    [a.ids()[x as usize], b.ids()[y as usize]]
}

/// Pairs that wait for their test.
pub(crate) struct Retest<'b> {
    bodies: &'b Bodies,
    frame: u64,
    waiting: ArrayVec<Tested, LANES>,
    columns: [Columns; 2],
    instructions: Instructions,
}

impl<'b> Retest<'b> {
    pub fn new(bodies: &'b Bodies, frame: u64) -> Self {
        let (columns, instructions) = ([Columns::ZERO, Columns::ZERO], Instructions::detect());
        Self { bodies, frame, waiting: ArrayVec::new(), columns, instructions }
    }

    /// Tests the latest witnesses of pairs, as far as the deadline allows.
    pub fn latest(&mut self, tests: &mut [Test], deadline: &mut Deadline) {
        let mut next = 0;
        loop {
            while next < tests.len() && !self.waiting.is_full() && deadline.has_room(WORK_PER_WITNESS) {
                deadline.spend(WORK_PER_WITNESS);
                if !self.add([next, 0], &tests[next]) {
                    tests[next].outcome = Outcome::Lost;
                }
                next += 1;
            }
            let hits = meeting(self.instructions, &self.columns, self.waiting.len());
            let tested = mem::take(&mut self.waiting);
            if tested.is_empty() {
                break;
            }
            for (lane, Tested { at, number, witness }) in tested.into_iter().enumerate() {
                let tested = &mut tests[at];
                if hits >> lane & 1 != 0 {
                    tested.end(Some(witness), self.frame);
                } else if number + 1 == WITNESSES || !self.add([at, number + 1], tested) {
                    tested.end(None, self.frame);
                }
            }
        }
    }

    /// Tests what lies next to the latest witnesses of pairs, as far as the deadline allows.
    pub fn beside(&mut self, tests: &mut [Test], deadline: &mut Deadline) {
        for test in tests {
            if !deadline.has_room(WORK_PER_NEIGHBORS) {
                break;
            }
            deadline.spend(WORK_PER_NEIGHBORS);
            match self.meets_beside(test) {
                None => test.outcome = Outcome::Lost,
                met => test.end(met, self.frame),
            }
        }
    }

    /// Adds one of the latest witnesses of a pair, if there is such a one.
    #[inline]
    fn add(&mut self, [at, number]: [usize; 2], test: &Test) -> bool {
        let Some([a, b]) = self.bodies.pair(test.key) else { return false };
        let (b_in_a, trees) = (a.relative(b), [&*a.body.tree, &*b.body.tree]);
        let Some(witness) = test.state.memory.witness(number, trees, &b_in_a) else { return false };
        let lane = self.waiting.len();
        let [of_a, of_b] = corners(trees, witness, &b_in_a);
        self.columns[0].set(lane, &of_a);
        self.columns[1].set(lane, &of_b);
        self.waiting.push(Tested { at, number, witness: ids(trees, witness) });
        true
    }

    /// Of what lies next to the latest witness of a pair, a triangle of it with one behind an edge of the other, two that
    /// meet. Their ids; and the memory knows them from now on.
    fn meets_beside(&mut self, test: &mut Test) -> Option<[u32; 2]> {
        let [a, b] = self.bodies.pair(test.key)?;
        let (b_in_a, trees) = (a.relative(b), [&*a.body.tree, &*b.body.tree]);
        let latest = test.state.memory.witness(0, trees, &b_in_a)?;
        for (columns, corners) in self.columns.iter_mut().zip(&corners(trees, latest, &b_in_a)) {
            columns.fill(corners);
        }
        let mut next = ArrayVec::<_, LANES>::new();
        for (side, tree) in trees.into_iter().enumerate() {
            let Some(neighbors) = tree.neighbors().get(latest[side] as usize) else { continue };
            for (edge, across) in neighbors.across.iter().enumerate().filter(|(_, across)| !across.is_nothing()) {
                let vertex = tree.mesh().vertices().get(across.vertex as usize);
                let vertex = if side == 0 { vertex } else { b_in_a.transform_point(vertex) };
                // The corner that is not on the edge.
                self.columns[side].set_corner(next.len(), (edge + 2) % 3, vertex);
                let mut pair = latest;
                pair[side] = across.triangle();
                next.push(pair);
            }
        }
        let hits = meeting(self.instructions, &self.columns, next.len());
        let found = *next.get(hits.trailing_zeros() as usize)?;
        test.state.memory.found(found);
        Some(ids(trees, found))
    }
}

/// Which of the first `count` pairs of triangles meet, a bit each.
fn meeting(instructions: Instructions, [a, b]: &[Columns; 2], count: usize) -> u32 {
    let Verdicts { hit, doubt } = instructions.run(Again { a, b, count, crossings: None });
    let wanted = (1 << count) - 1;
    let in_doubt = bits(doubt & wanted).filter(|&lane| triangles_intersect(&a.get(lane), &b.get(lane)));
    in_doubt.fold(hit & wanted, |hits, lane| hits | 1 << lane)
}
