//! The node pairs that a complete run opens, for studies of the order of visits. They are the same
//! in every order.

use super::probe::Children;
use crate::engine::boxes::RelativePose;
use crate::engine::frontier::Pair;
use crate::tree::Tree;
use alloc::vec::Vec;
use punctual_geom::lanes::{Instructions, Kernel, Lanes};
use punctual_geom::{Pose, bits};

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
    if a.nodes().is_empty() || b.nodes().is_empty() {
        return Vec::new();
    }
    Instructions::detect().run(Recorder([a, b], &RelativePose::new(a, b, b_in_a)))
}

struct Recorder<'r>([&'r Tree; 2], &'r RelativePose);

impl Kernel for Recorder<'_> {
    type Output = Vec<OpenedPair>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Vec<OpenedPair> {
        let Self(trees, relative) = self;
        // Pairs to open, each with the index of its parent.
        let mut frontier = alloc::vec![(Pair::new(0, 0), 0)];
        let mut opened = Vec::new();
        while let Some((pair, parent)) = frontier.pop() {
            let mut children = Children::default();
            children.open(lanes, pair, trees, relative);
            let (hits, first) = children.triangles;
            let id = |side: usize, i: usize| trees[side].ids()[first[side] as usize + i];
            frontier.extend(children.pairs.into_iter().map(|pair| (pair, opened.len())));
            opened.push(OpenedPair {
                parent,
                bv_tests: children.stats.bv_tests as u32,
                work: children.stats.work,
                triangle_pairs: bits(hits)
                    .map(|bit| [id(0, bit / 8), id(1, bit % 8)])
                    .collect(),
            });
        }
        opened
    }
}
