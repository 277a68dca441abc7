//! What one frame tells the next about a pair of meshes.

use super::clearance::Clearance;
use super::interval::Interval;
use super::options::Mode;
use super::outcome::{StopReason, Verdict};
use super::queue::PATHS;
use super::workspace::Workspace;
use crate::math::Pose;
use crate::model::confidence::History;
use crate::tree::Tree;
use alloc::boxed::Box;
use arrayvec::ArrayVec;

/// Most witnesses of [`Mode::Any`] that are remembered, and tested before anything else: a batch.
pub(super) const WITNESSES: usize = 8;

/// Frames over which the rate of changes is averaged.
const FRAMES_OF_RATE: f64 = 20.0;

/// What a query looked for whose work is remembered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Sought {
    Distance,
    Motion,
}

/// What was known before a call.
#[derive(Clone, Copy)]
pub(super) struct Before {
    /// Whether the call went on with a stopped run.
    pub resumed: bool,
    /// Whether the surfaces were known to meet.
    pub decided: bool,
}

/// Memory of one pair of trees between frames, owned by the caller and passed in.
///
/// [`Mode::Any`] first tests the last eight witnesses, and then looks near the latest.
/// [`Mode::All`], if a budget may stop it and in the default order, first goes down to where up to
/// sixteen triangle pairs met in the frame before, spread over all of them, and then to what lies
/// beside these paths, the nearest first.
///
/// A fresh memory and a used one may differ in speed and in what an unfinished query finds, never
/// in a decided verdict. Used with another pair of trees it forgets everything; refitted trees
/// count as the same. A deserialized memory (feature `serde`) binds to the first pair of trees it
/// is used with. Using it with another pair is safe, but does not help.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct PairMemory {
    /// Identities of trees mean nothing in another run of the program.
    #[cfg_attr(feature = "serde", serde(skip))]
    trees: Option<[usize; 2]>,
    /// Triangle pairs in tree order that met: of [`Mode::Any`] the latest first, of [`Mode::All`]
    /// some from all over the last frame that found any.
    witnesses: ArrayVec<[u32; 2], PATHS>,
    /// The triangle pair (tree order) that was closest.
    nearest: Option<[u32; 2]>,
    /// What distance queries have proven, as of one pose. `None` in scenes, which have many
    /// memories and no use for it.
    #[cfg_attr(feature = "serde", serde(skip))]
    clearance: Option<Box<Clearance>>,
    last_verdict: Option<bool>,
    last_bv_tests: Option<(Mode, u64)>,
    /// Work of the last finished query of the distance or of a motion.
    last_work: Option<(Sought, u64)>,
    frames_undecided: u32,
    #[cfg_attr(feature = "serde", serde(deserialize_with = "rate"))]
    change_rate: Option<f64>,
}

/// A deserialized rate, refused unless it is one.
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
            ..Self::without_clearance()
        }
    }
}

impl PairMemory {
    /// Knows nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Knows nothing, and will know no clearance.
    #[doc(hidden)]
    pub fn without_clearance() -> Self {
        Self {
            trees: None,
            witnesses: ArrayVec::new(),
            nearest: None,
            clearance: None,
            last_verdict: None,
            last_bv_tests: None,
            last_work: None,
            frames_undecided: 0,
            change_rate: None,
        }
    }

    /// Whether the surfaces met when it was last decided; `None` if it never was.
    pub fn last_verdict(&self) -> Option<bool> {
        self.last_verdict
    }

    /// BV tests of the last query that ran to its end; `None` if none did.
    pub fn last_bv_tests(&self) -> Option<u64> {
        self.last_bv_tests.map(|(_, bv_tests)| bv_tests)
    }

    /// The same, if that query was of this mode.
    pub(super) fn last_bv_tests_of(&self, mode: Mode) -> Option<u64> {
        self.last_bv_tests
            .filter(|(of, _)| *of == mode)
            .map(|(_, bv_tests)| bv_tests)
    }

    /// Work of the last finished query of the distance or of a motion of this pair; `None` if it
    /// was not of that kind.
    pub(super) fn last_work_of(&self, sought: Sought, a: &Tree, b: &Tree) -> Option<u64> {
        let of_pair = self.last_work.filter(|_| self.is_of(a, b));
        of_pair
            .filter(|(of, _)| *of == sought)
            .map(|(_, work)| work)
    }

    /// Frames since it was last decided.
    pub fn frames_undecided(&self) -> u32 {
        self.frames_undecided
    }

    /// How often the verdict changes from one decided frame to the next, 0 to 1: a mean over about
    /// the last 20, at first 1 in 8.
    pub fn change_rate(&self) -> f64 {
        self.change_rate.unwrap_or(0.125)
    }

    /// What the confidence goes by; `None` if the pair was never decided.
    pub fn history(&self) -> Option<History> {
        let Self {
            last_verdict,
            frames_undecided,
            ..
        } = *self;
        last_verdict.map(|met| History {
            met,
            frames_undecided,
            change_rate: self.change_rate(),
        })
    }

    pub(super) fn is_of(&self, a: &Tree, b: &Tree) -> bool {
        self.trees == Some([a.lineage(), b.lineage()])
    }

    /// One of the latest witnesses, in tree order.
    #[inline]
    pub(crate) fn witness(&self, number: usize) -> Option<[u32; 2]> {
        self.witnesses.get(number).copied()
    }

    /// Takes note that a triangle pair (tree order) that was tested by itself meets: it is the
    /// latest witness.
    pub(crate) fn found(&mut self, pair: [u32; 2]) {
        self.witnesses.retain(|witness| *witness != pair);
        self.witnesses.truncate(WITNESSES - 1);
        self.witnesses.insert(0, pair);
    }

    /// Makes it the memory of this pair, and forgets what it knew of another.
    pub(super) fn bind(&mut self, a: &Tree, b: &Tree) {
        let trees = Some([a.lineage(), b.lineage()]);
        if self.trees.is_none() {
            self.trees = trees;
            let exists = |tree: &Tree, triangle: u32| (triangle as usize) < tree.mesh().len();
            self.witnesses
                .retain(|&mut [x, y]| exists(a, x) && exists(b, y));
            self.nearest = self.nearest.filter(|&[x, y]| exists(a, x) && exists(b, y));
        } else if self.trees != trees {
            // The clearance knows its trees itself.
            *self = Self {
                trees,
                clearance: self.clearance.take(),
                ..Self::without_clearance()
            };
        }
    }

    /// Triangle pairs of the bound pair, in tree order.
    pub(super) fn witnesses(&self) -> &[[u32; 2]] {
        &self.witnesses
    }

    /// A triangle pair (tree order) that is likely to be close.
    pub(super) fn nearest(&self, a: &Tree, b: &Tree) -> Option<[u32; 2]> {
        if self.is_of(a, b) { self.nearest } else { None }
    }

    /// Proven: how far apart the surfaces are at least at this pose, in the length unit of the
    /// meshes, as far as distance queries with this memory have shown it of these trees
    /// ([`Query::with_memory`], finished or stopped): what they proved, less the longest way of a
    /// point of B since then. 0 if nothing is known. Costs some 50 operations.
    ///
    /// While it is more than 0, [`Query`](crate::Query) with this memory answers `Separated` at
    /// once, and [`Query::impact`](crate::Query::impact) begins with the time until B can have gone
    /// so far.
    ///
    /// [`Query::with_memory`]: crate::Query::with_memory
    pub fn clearance(&self, a: &Tree, b: &Tree, b_in_a: &Pose) -> f64 {
        self.clearance
            .as_ref()
            .map_or(0.0, |known| known.at(a, b, b_in_a).max(0.0))
    }

    /// After a call of a distance query at a pose; `work` is that of the whole query, if
    /// predictions can go by it.
    pub(super) fn remember_distance(
        &mut self,
        [a, b]: [&Tree; 2],
        b_in_a: &Pose,
        interval: &Interval,
        work: Option<u64>,
    ) {
        // The memory may be another one than when the run began.
        self.bind(a, b);
        if let Some(known) = &mut self.clearance
            && interval.low() > known.at(a, b, b_in_a).max(0.0)
        {
            **known = Clearance::new(a, b, b_in_a, interval.low());
        }
        self.nearest = interval.nearest().map(|(pair, _)| pair).or(self.nearest);
        self.remember_work(Sought::Distance, work);
    }

    /// After a call of a motion query; `work` is that of the whole query, if it is finished.
    pub(super) fn remember_motion(
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

    /// What the clearance answered says nothing about the work of a search.
    fn remember_work(&mut self, sought: Sought, work: Option<u64>) {
        let searched = work.filter(|&work| work > 0);
        self.last_work = searched.map(|work| (sought, work)).or(self.last_work);
    }

    /// After a call that ended for this reason. One that resumed a stopped run belongs to the same
    /// frame.
    pub(super) fn remember(
        &mut self,
        mode: Mode,
        stop: StopReason,
        workspace: &Workspace,
        before: Before,
    ) {
        let (run, found) = (&workspace.run, workspace.sample.pairs());
        if !found.is_empty() {
            // What a stopped query has not come to may still be where it was.
            let kept = match mode {
                Mode::Any => WITNESSES.saturating_sub(found.len()),
                Mode::All if stop == StopReason::Finished => 0,
                Mode::All => PATHS - found.len(),
            };
            let known = self.witnesses.iter().filter(|known| !found.contains(known));
            self.witnesses = found.iter().chain(known.take(kept)).copied().collect();
        }
        let was_known = run.stats.found == 0 && run.stats.bv_tests_of_levels() == 0;
        if stop.is_final() && !was_known {
            self.last_bv_tests = Some((mode, run.stats.bv_tests_of_levels()));
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
