//! State of a pair of meshes that is kept from frame to frame.

pub(crate) mod clearance;
mod corrections;
pub(crate) mod identity;

use crate::engine::frontier::PATHS;
use crate::engine::options::Mode;
use crate::engine::outcome::{StopReason, Verdict};
use crate::engine::workspace::{Key, Workspace};
use crate::model::confidence::History;
use crate::model::prediction::Quantiles;
use crate::tree::Tree;
use alloc::boxed::Box;
use arrayvec::ArrayVec;
use clearance::Clearance;
use corrections::Corrections;
pub(crate) use corrections::Sought;
use identity::ManifoldMemory;
use punctual_geom::Pose;

/// Maximum number of witnesses of [`Mode::Any`] that are remembered and tested before anything
/// else: one batch.
pub(crate) const WITNESSES: usize = 8;

/// Number of frames over which the change rate is averaged.
const FRAMES_OF_RATE: f64 = 20.0;

/// The state before a call.
#[derive(Clone, Copy)]
pub(crate) struct Before {
    /// True if the call resumed a stopped run.
    pub resumed: bool,
    /// True if the surfaces were known to intersect.
    pub decided: bool,
}

/// Memory of one pair of trees between frames, owned by the caller and passed to the query
/// ([`crate::Query::with_memory`]).
///
/// [`Mode::Any`] first tests the last eight witnesses, and then searches near the latest.
/// [`Mode::All`], in the default order and if a budget may stop it, first descends to up to sixteen
/// triangle pairs that intersected in the previous frame, spread over all of them. Then it visits
/// the node pairs next to these paths, the nearest first.
///
/// A fresh memory and a used one may differ in speed and in what an unfinished query finds, never
/// in a decided verdict. If it is used with another pair of trees, it forgets everything; refitted
/// trees count as the same trees. A deserialized memory (feature `serde`) binds to the first pair
/// of trees it is used with. Using it with another pair is safe, but does not help.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct PairMemory {
    /// Not serialized: identities of trees are meaningless in another run of the program.
    #[cfg_attr(feature = "serde", serde(skip))]
    trees: Option<[usize; 2]>,
    /// Triangle pairs in tree order that intersected. For [`Mode::Any`] the latest first. For
    /// [`Mode::All`] a sample of the last frame that found any.
    witnesses: ArrayVec<[u32; 2], PATHS>,
    /// The triangle pair (tree order) that was closest.
    nearest: Option<[u32; 2]>,
    /// The bound that distance queries have proven, for one pose. `None` in scenes, which have many
    /// memories and do not use it.
    #[cfg_attr(feature = "serde", serde(skip))]
    clearance: Option<Box<Clearance>>,
    /// The points of the last manifolds. Ids mean nothing in another run of the program.
    #[cfg_attr(feature = "serde", serde(skip))]
    manifolds: Option<Box<ManifoldMemory>>,
    last_verdict: Option<bool>,
    last_bv_tests: Option<(Mode, u64)>,
    /// Work of the last finished distance or motion query.
    last_work: Option<(Sought, u64)>,
    /// Corrections of predictions for this pair; `None` in scenes, which have many memories and do
    /// not predict.
    #[cfg_attr(feature = "serde", serde(rename = "told"))]
    corrections: Option<Box<Corrections>>,
    frames_undecided: u32,
    #[cfg_attr(feature = "serde", serde(deserialize_with = "rate"))]
    change_rate: Option<f64>,
}

/// Deserializes a rate; an error unless it is within 0 and 1.
#[cfg(feature = "serde")]
fn rate<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    let rate = <Option<f64> as serde::Deserialize>::deserialize(deserializer)?;
    match rate {
        Some(rate) if !(0.0..=1.0).contains(&rate) => Err(serde::de::Error::custom(format_args!(
            "change_rate {rate} is not within 0 and 1"
        ))),
        rate => Ok(rate),
    }
}

impl Default for PairMemory {
    fn default() -> Self {
        Self {
            clearance: Some(Box::new(Clearance::NOTHING)),
            corrections: Some(Box::default()),
            ..Self::without_clearance()
        }
    }
}

impl PairMemory {
    /// An empty memory.
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty memory that stores no clearance and learns nothing of predictions.
    pub fn without_clearance() -> Self {
        Self {
            trees: None,
            witnesses: ArrayVec::new(),
            nearest: None,
            clearance: None,
            manifolds: None,
            last_verdict: None,
            last_bv_tests: None,
            last_work: None,
            corrections: None,
            frames_undecided: 0,
            change_rate: None,
        }
    }

    /// True if the surfaces intersected when the verdict was last decided; `None` if it never was.
    #[inline]
    pub fn last_verdict(&self) -> Option<bool> {
        self.last_verdict
    }

    /// BV tests of the last query that ran to its end; `None` if none did.
    pub fn last_bv_tests(&self) -> Option<u64> {
        self.last_bv_tests.map(|(_, bv_tests)| bv_tests)
    }

    /// BV tests of the last query that ran to its end, if it was of this mode.
    pub(crate) fn last_bv_tests_of(&self, mode: Mode) -> Option<u64> {
        self.last_bv_tests
            .filter(|(of, _)| *of == mode)
            .map(|(_, bv_tests)| bv_tests)
    }

    /// Work of the last finished distance or motion query; `None` if it was of the other kind.
    pub(crate) fn last_work_of(&self, sought: Sought) -> Option<u64> {
        self.last_work
            .filter(|(of, _)| *of == sought)
            .map(|(_, work)| work)
    }

    /// The quantiles of the work left in a query that has done `used`: those of the model,
    /// corrected by earlier predictions for this pair. Until a correction is learned, a prediction
    /// before a query is `after`, which follows from the query before.
    pub(crate) fn predict(
        &self,
        sought: Sought,
        key: &Key,
        used: f64,
        model: Quantiles,
        after: impl FnOnce() -> Option<Quantiles>,
    ) -> Quantiles {
        (self.corrections.as_ref())
            .and_then(|corrections| corrections.predict(sought, key, used, model))
            .or_else(|| (used == 0.0).then(after).flatten())
            .unwrap_or(model)
    }

    /// Learns from a call of a query that has done this much by now.
    pub(crate) fn learn(
        &mut self,
        sought: Sought,
        workspace: &Workspace,
        done: u64,
        is_finished: bool,
    ) {
        if let Some(corrections) = &mut self.corrections {
            corrections.learn(sought, workspace.run.key.as_ref(), done, is_finished);
        }
    }

    /// Number of frames since the verdict was last decided.
    pub fn frames_undecided(&self) -> u32 {
        self.frames_undecided
    }

    /// Probability that the verdict changes from one decided frame to the next: a mean over about
    /// the last 20 frames; initially 1 in 8.
    pub fn change_rate(&self) -> f64 {
        self.change_rate.unwrap_or(0.125)
    }

    /// The history that the confidence model uses; `None` if the pair was never decided.
    pub fn history(&self) -> Option<History> {
        self.last_verdict.map(|met| History {
            met,
            frames_undecided: self.frames_undecided,
            change_rate: self.change_rate(),
        })
    }

    pub(crate) fn is_of(&self, a: &Tree, b: &Tree) -> bool {
        self.trees == Some([a.lineage(), b.lineage()])
    }

    /// One of the latest witnesses, in tree order.
    #[inline]
    pub fn witness(&self, number: usize) -> Option<[u32; 2]> {
        self.witnesses.get(number).copied()
    }

    /// The pair (tree order) that the last distance query found to be closest.
    pub fn closest(&self) -> Option<[u32; 2]> {
        self.nearest
    }

    /// Records a verdict found without this memory: intersecting, with the latest witness (tree
    /// order), or separated.
    pub fn decide(&mut self, witness: Option<[u32; 2]>) {
        (self.last_verdict, self.frames_undecided) = (Some(witness.is_some()), 0);
        if let Some(pair) = witness {
            self.witnesses.retain(|witness| *witness != pair);
            self.witnesses.truncate(WITNESSES - 1);
            self.witnesses.insert(0, pair);
        }
    }

    /// Binds the memory to this pair, and forgets what it stored of another.
    pub(crate) fn bind(&mut self, a: &Tree, b: &Tree) {
        let trees = Some([a.lineage(), b.lineage()]);
        if self.trees.is_none() {
            self.trees = trees;
            let exists = |tree: &Tree, triangle: u32| (triangle as usize) < tree.mesh().len();
            self.witnesses
                .retain(|&mut [x, y]| exists(a, x) && exists(b, y));
            self.nearest = self.nearest.filter(|&[x, y]| exists(a, x) && exists(b, y));
        } else if self.trees != trees {
            // The clearance checks its trees itself.
            let mut corrections = self.corrections.take();
            if let Some(corrections) = &mut corrections {
                **corrections = Corrections::default();
            }
            *self = Self {
                trees,
                clearance: self.clearance.take(),
                corrections,
                ..Self::without_clearance()
            };
        }
    }

    /// The stored witnesses of the bound pair, in tree order.
    pub(crate) fn witnesses(&self) -> &[[u32; 2]] {
        &self.witnesses
    }

    /// A triangle pair (tree order) that is probably close.
    pub(crate) fn nearest(&self, a: &Tree, b: &Tree) -> Option<[u32; 2]> {
        if self.is_of(a, b) { self.nearest } else { None }
    }

    /// Proven lower bound of the distance of these surfaces at this pose, in the length unit of the
    /// meshes. Distance queries with this memory ([`Query::with_memory`], finished or stopped)
    /// prove a bound at their pose; the longest displacement of a point of B since then is
    /// subtracted. 0 if nothing is known. Costs about 50 operations.
    ///
    /// While it is more than 0, an intersection query with this memory answers `Separated` at once,
    /// and [`Query::impact`](crate::Query::impact) starts at the time until which B cannot have
    /// moved that far.
    ///
    /// [`Query::with_memory`]: crate::Query::with_memory
    #[inline]
    pub fn clearance(&self, a: &Tree, b: &Tree, b_in_a: &Pose) -> f64 {
        self.clearance
            .as_ref()
            .map_or(0.0, |known| known.at(a, b, b_in_a).max(0.0))
    }

    /// Updates the memory after a call of a distance query at a pose, which has proven the bound
    /// `low`. `work` is that of the whole query, if predictions can use it.
    pub(crate) fn remember_distance(
        &mut self,
        [a, b]: [&Tree; 2],
        b_in_a: &Pose,
        low: f64,
        nearest: Option<[u32; 2]>,
        work: Option<u64>,
    ) {
        // The memory may differ from the one at the start of the run.
        self.bind(a, b);
        if let Some(known) = &mut self.clearance
            && low > known.at(a, b, b_in_a).max(0.0)
        {
            **known = Clearance::new(a, b, b_in_a, low);
        }
        self.nearest = nearest.or(self.nearest);
        self.remember_work(Sought::Distance, work);
    }

    /// The manifolds of the frame before. `is_new` begins a frame.
    pub(crate) fn manifolds(&mut self, [a, b]: [&Tree; 2], is_new: bool) -> &mut ManifoldMemory {
        self.bind(a, b);
        let known = self.manifolds.get_or_insert_default();
        if is_new {
            known.begin();
        }
        known
    }

    /// Updates the memory after a call of a motion query. `work` is the work of the whole query, or
    /// `None` if the query is not finished.
    pub(crate) fn remember_motion(
        &mut self,
        a: &Tree,
        b: &Tree,
        pair: Option<[u32; 2]>,
        work: Option<u64>,
    ) {
        self.bind(a, b);
        self.nearest = pair.or(self.nearest);
        self.remember_work(Sought::Motion, work);
    }

    /// Ignores 0: a query that the clearance answered does not show the work of a search.
    fn remember_work(&mut self, sought: Sought, work: Option<u64>) {
        let searched = work.filter(|&work| work > 0);
        self.last_work = searched.map(|work| (sought, work)).or(self.last_work);
    }

    /// Updates the memory after a call that ended for this reason. A call that resumed a run
    /// belongs to the same frame.
    pub(crate) fn remember(
        &mut self,
        mode: Mode,
        stop: StopReason,
        workspace: &Workspace,
        before: Before,
    ) {
        let (run, found) = (&workspace.run, workspace.state.intersection.sample.pairs());
        if !found.is_empty() {
            // Witnesses in parts that a stopped query has not reached may still be valid.
            let kept = match mode {
                Mode::Any => WITNESSES.saturating_sub(found.len()),
                Mode::All if stop == StopReason::Finished => 0,
                Mode::All => PATHS - found.len(),
            };
            let known = self.witnesses.iter().filter(|known| !found.contains(known));
            self.witnesses = found.iter().chain(known.take(kept)).copied().collect();
        }
        let was_known = run.stats.found == 0 && run.stats.bv_tests == 0;
        if stop.is_final() && !was_known {
            self.last_bv_tests = Some((mode, run.stats.bv_tests));
        }
        self.frames_undecided = self
            .frames_undecided
            .saturating_add(u32::from(!before.resumed));
        let verdict = run.verdict(stop);
        if verdict != Verdict::Undecided {
            let meet = verdict != Verdict::Separated;
            if let Some(last) = self.last_verdict.filter(|_| !before.decided) {
                let rate = self.change_rate();
                self.change_rate = Some(rate + (f64::from(last != meet) - rate) / FRAMES_OF_RATE);
            }
            self.last_verdict = Some(meet);
            self.frames_undecided = 0;
        }
    }
}
