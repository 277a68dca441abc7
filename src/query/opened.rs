//! The node pairs that a complete run opens, for studies of the order of visits. They are the same
//! in every order.

use super::boxes::{Keys, Overlap};
use super::expand::{Sink, expand};
use super::queue::Pair;
use super::views::Relation;
use crate::model::cost::opening_work;
use crate::tree::{Tree, WIDTH};
use alloc::vec::Vec;
use punctual_geom::Pose;
use punctual_geom::lanes::{Instructions, Kernel, Lanes};

/// An opened node pair.
#[derive(Clone, Debug, Default)]
pub struct OpenedPair {
    /// Index of the parent pair. The first pair, that of the roots, is its own parent.
    pub parent: usize,
    /// BV tests made.
    pub bv_tests: u32,
    /// Work of opening the pair, without triangle tests.
    pub work: u64,
    /// The triangle pairs left to test, ids of the input meshes.
    pub triangle_pairs: Vec<[u32; 2]>,
}

/// All node pairs opened by a run that finds all intersections, parents before their children; none
/// if a mesh is empty.
pub fn opened_pairs(a: &Tree, b: &Tree, b_in_a: &Pose) -> Vec<OpenedPair> {
    let (relation, opened) = (Relation::new(a, b, b_in_a), Vec::new());
    let mut recorder = Recorder {
        trees: [a, b],
        relation: &relation,
        keys: [[0.0; WIDTH]; WIDTH],
        front: Vec::new(),
        opened,
    };
    if !a.nodes().is_empty() && !b.nodes().is_empty() {
        recorder.front.push((Pair::new(0, 0), 0));
    }
    Instructions::detect().run(&mut recorder);
    recorder.opened
}

struct Recorder<'r> {
    trees: [&'r Tree; 2],
    relation: &'r Relation,
    keys: Keys,
    /// Pairs to open, each with the index of its parent.
    front: Vec<(Pair, usize)>,
    /// The last entry is being opened.
    opened: Vec<OpenedPair>,
}

impl Kernel for &mut Recorder<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        while let Some((pair, parent)) = self.front.pop() {
            self.opened.push(OpenedPair {
                parent,
                ..OpenedPair::default()
            });
            expand(
                lanes,
                pair,
                self.trees,
                self.relation,
                &mut Overlap::new(self.relation),
                self,
            );
        }
    }
}

impl Sink for Recorder<'_> {
    fn count(&mut self, _level: usize, bv_tests: u32) {
        if let Some(pair) = self.opened.last_mut() {
            pair.bv_tests += bv_tests;
            pair.work += opening_work(bv_tests);
        }
    }

    fn spend(&mut self, work: u64) {
        if let Some(pair) = self.opened.last_mut() {
            pair.work += work;
        }
    }

    fn keys(&mut self) -> &mut Keys {
        &mut self.keys
    }

    fn pairs(&mut self, hits: u64, child: impl Fn(u32) -> Pair) {
        (0..64)
            .filter(|bit| hits >> bit & 1 == 1)
            .for_each(|bit| self.cluster(child(bit), 0));
    }

    fn cluster(&mut self, pair: Pair, _column: usize) {
        self.front.push((pair, self.opened.len() - 1));
    }

    fn triangles(&mut self, hits: u64, first: [u32; 2]) {
        let [a, b] = self.trees;
        let pairs = (0..64).filter(|bit| hits >> bit & 1 == 1).map(|bit| {
            [
                a.ids()[(first[0] + bit / 8) as usize],
                b.ids()[(first[1] + bit % 8) as usize],
            ]
        });
        if let Some(pair) = self.opened.last_mut() {
            pair.triangle_pairs.extend(pairs);
        }
    }
}
