//! What one frame tells the next about a pair of meshes.

use super::outcome::{Outcome, StopReason, Verdict};
use crate::math::Pose;
use crate::tree::Tree;
use crate::triangle::triangles_intersect;
use arrayvec::ArrayVec;

/// Most witnesses that are remembered.
pub(super) const WITNESSES: usize = 8;

/// How many of them [`PairMemory::recheck`] tests.
const RECHECKED: usize = 2;

/// Memory of one pair of trees between frames, owned by the caller and passed in.
///
/// A fresh memory and a used one may differ in speed and in what an unfinished query finds, never in a decided verdict.
/// Handed to another pair of trees it forgets everything. Read with the feature `serde` it belongs to the first pair of
/// trees that it is handed to; if that is not the pair it was written for, it is of no use and does no harm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct PairMemory {
    /// Identities of trees mean nothing in another run of the program.
    #[cfg_attr(feature = "serde", serde(skip))]
    trees: Option<[usize; 2]>,
    /// Triangle pairs in tree order that met in the last frame that found any, most recent first.
    witnesses: ArrayVec<[u32; 2], WITNESSES>,
    last_verdict: Option<bool>,
    last_bv_tests: Option<u64>,
    frames_undecided: u32,
}

impl PairMemory {
    /// Knows nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether the surfaces met when it was last decided; `None` if it never was.
    pub fn last_verdict(&self) -> Option<bool> {
        self.last_verdict
    }

    /// BV tests of the last query that ran to its end; `None` if none did.
    pub fn last_bv_tests(&self) -> Option<u64> {
        self.last_bv_tests
    }

    /// Frames since it was last decided.
    pub fn frames_undecided(&self) -> u32 {
        self.frames_undecided
    }

    /// Tests the latest witnesses one by one, exactly: the first that still meets, ids of the input meshes. Costs a
    /// fraction of a query.
    pub(crate) fn recheck(&self, a: &Tree, b: &Tree, b_in_a: &Pose) -> Option<[u32; 2]> {
        let known = self.trees == Some([a.identity(), b.identity()]);
        let latest = self.witnesses.iter().take(if known { RECHECKED } else { 0 });
        latest.map(|&[x, y]| [a.ids()[x as usize], b.ids()[y as usize]]).find(|&[x, y]| {
            let of_a = a.mesh().triangle(x as usize);
            let of_b = b.mesh().triangle(y as usize).map(|v| b_in_a.transform_point(v));
            triangles_intersect(&of_a, &of_b)
        })
    }

    pub(super) fn witnesses(&mut self, a: &Tree, b: &Tree) -> &[[u32; 2]] {
        let trees = Some([a.identity(), b.identity()]);
        if self.trees.is_none() {
            self.trees = trees;
            let exists = |tree: &Tree, triangle: u32| (triangle as usize) < tree.mesh().len();
            self.witnesses.retain(|&mut [x, y]| exists(a, x) && exists(b, y));
        } else if self.trees != trees {
            *self = Self { trees, ..Self::default() };
        }
        &self.witnesses
    }

    pub(super) fn remember(&mut self, outcome: &Outcome, witness: Option<[u32; 2]>) {
        if let Some(witness) = witness {
            self.witnesses.retain(|known| *known != witness);
            self.witnesses.truncate(WITNESSES - 1);
            self.witnesses.insert(0, witness);
        }
        if outcome.stop == StopReason::Finished || outcome.stop == StopReason::FirstHit {
            self.last_bv_tests = Some(outcome.stats.bv_tests);
        }
        self.frames_undecided = self.frames_undecided.saturating_add(1);
        if outcome.verdict != Verdict::Undecided {
            self.last_verdict = Some(outcome.verdict != Verdict::Separated);
            self.frames_undecided = 0;
        }
    }
}
