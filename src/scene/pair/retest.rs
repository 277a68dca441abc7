//! Whether the triangles that met last still do: the cheapest question, asked of eight pairs at once.

use super::state::PairState;
use crate::math::lanes::Instructions;
use crate::scene::body::Bodies;
use crate::scene::id::PairKey;
use crate::triangle::again::{Again, Columns};
use crate::triangle::triangles_intersect;
use arrayvec::ArrayVec;

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
        let b_in_a = a.relative(b);
        let [tree_a, tree_b] = [&a.body.tree, &b.body.tree];
        let Some(witness) = state.memory.witness(number, tree_a, tree_b, &b_in_a) else { return false };
        let lane = self.waiting.len();
        let [x, y] = witness.map(|triangle| triangle as usize);
        self.columns[0].set(lane, &tree_a.mesh().triangle(x));
        let [p, q, r] = tree_b.mesh().triangle(y);
        let place_corner = |corner| b_in_a.transform_point(corner);
        self.columns[1].set(lane, &[place_corner(p), place_corner(q), place_corner(r)]);
        self.waiting.push(Tested { place, key, number, witness });
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
        let [a, b] = &self.columns;
        let verdicts = self.instructions.run(Again { a, b, count: self.waiting.len(), crossings: None });
        let mut hits = verdicts.hit;
        for lane in (0..self.waiting.len()).filter(|lane| verdicts.doubt >> lane & 1 != 0) {
            hits |= u32::from(triangles_intersect(&a.get(lane), &b.get(lane))) << lane;
        }
        (core::mem::take(&mut self.waiting), hits)
    }
}
