//! Whether the triangles that met last still do, or those next to them: the cheapest question, asked of eight pairs at once.

use super::state::PairState;
use crate::math::lanes::Instructions;
use crate::math::{Pose, bits};
use crate::scene::body::Bodies;
use crate::scene::id::PairKey;
use crate::tree::Tree;
use crate::triangle::again::{Again, Columns};
use crate::triangle::batch::Verdicts;
use crate::triangle::triangles_intersect;
use arrayvec::ArrayVec;
use glam::DVec3;

/// Pairs that are tested at once.
const LANES: usize = 8;

/// How many of the latest witnesses of a pair are tested, one after the other.
pub(crate) const WITNESSES: usize = 2;

/// A pair whose witness is tested.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tested {
    pub place: usize,
    pub key: PairKey,
    /// Which of its latest witnesses, and its triangles.
    pub number: usize,
    pub witness: [u32; 2],
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
pub(crate) struct Retest {
    waiting: ArrayVec<Tested, LANES>,
    columns: [Columns; 2],
    instructions: Instructions,
}

impl Retest {
    pub fn new() -> Self {
        Self { waiting: ArrayVec::new(), columns: [Columns::ZERO, Columns::ZERO], instructions: Instructions::detect() }
    }

    /// Adds one of the latest witnesses of a pair, if there is such a one.
    #[inline]
    pub fn add(&mut self, [place, number]: [usize; 2], key: PairKey, state: &PairState, bodies: &Bodies) -> bool {
        let Some([a, b]) = bodies.pair(key) else { return false };
        let (b_in_a, trees) = (a.relative(b), [&*a.body.tree, &*b.body.tree]);
        let Some(witness) = state.memory.witness(number, trees, &b_in_a) else { return false };
        let lane = self.waiting.len();
        let [of_a, of_b] = corners(trees, witness, &b_in_a);
        self.columns[0].set(lane, &of_a);
        self.columns[1].set(lane, &of_b);
        self.waiting.push(Tested { place, key, number, witness: ids(trees, witness) });
        true
    }

    pub fn is_full(&self) -> bool {
        self.waiting.is_full()
    }

    /// How many wait.
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Tests all that wait; which of them meet, a bit each.
    pub fn run(&mut self) -> (ArrayVec<Tested, LANES>, u32) {
        let hits = test(self.instructions, &self.columns, self.waiting.len());
        (core::mem::take(&mut self.waiting), hits)
    }

    /// Of what lies next to the latest witness of a pair, a triangle of it with one behind an edge of the other, two that
    /// meet. Their ids; and the memory knows them from now on. None may wait.
    pub fn beside(&mut self, key: PairKey, state: &mut PairState, bodies: &Bodies) -> Option<[u32; 2]> {
        let [a, b] = bodies.pair(key)?;
        let (b_in_a, trees) = (a.relative(b), [&*a.body.tree, &*b.body.tree]);
        let latest = state.memory.witness(0, trees, &b_in_a)?;
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
        let hits = test(self.instructions, &self.columns, next.len());
        let found = *next.get(hits.trailing_zeros() as usize)?;
        state.memory.found(found);
        Some(ids(trees, found))
    }
}

/// Which of the first `count` pairs of triangles meet, a bit each.
fn test(instructions: Instructions, [a, b]: &[Columns; 2], count: usize) -> u32 {
    let Verdicts { hit, doubt } = instructions.run(Again { a, b, count, crossings: None });
    let wanted = (1 << count) - 1;
    let in_doubt = bits(doubt & wanted).filter(|&lane| triangles_intersect(&a.get(lane), &b.get(lane)));
    in_doubt.fold(hit & wanted, |hits, lane| hits | 1 << lane)
}
