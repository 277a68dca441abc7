//! What a frame says.

use super::id::{BodyId, MeasureId};
use super::pair::spent::Spent;
use super::pair::state::Standing;
use crate::names::named;
use crate::query::{Estimate, Verdict};
use alloc::vec::Vec;
use core::time::Duration;

/// What is known about two bodies whose boxes overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairReport {
    /// The body of the lower index: A of the pair.
    pub a: BodyId,
    /// The other one.
    pub b: BodyId,
    /// Whether their surfaces meet, thickened by their [margins](crate::Body::margin), in this
    /// frame.
    pub verdict: Verdict,
    /// Intersecting pairs of triangles found; at most 1 in [`crate::Mode::Any`], and of bodies with
    /// margins, whose witness counts.
    pub found: u64,
    /// Whether nothing is left to find: decided, in [`crate::Mode::Any`], and its distance or
    /// motion known, if that is asked for; in [`crate::Mode::All`], all have been found. Undecided
    /// all the same if rounding hides whether bodies with margins meet, or bodies in motion at its
    /// start.
    pub complete: bool,
    /// Probability that the surfaces meet: 1 or 0 if that is decided, whatever else is open, 0.5 if
    /// the pair is complete all the same. Otherwise by [`crate::Query::estimate`] for a pair whose
    /// query was stopped, corrected by [`crate::Scene::calibration`], and by what is remembered and
    /// what the boxes have in common for one that had no turn, or in frames of less than 1 ms.
    pub probability: f64,
    /// Expected share of the intersecting pairs of triangles that was found: 1 if `complete`, 0 if
    /// nothing was found, and between them otherwise: by [`crate::Query::estimate`] for a query
    /// that was stopped, or else the share of its expected work that is done.
    pub recall: f64,
    /// Frames since it was decided: 0 if it was in this one. A pair that never was counts from the
    /// frame before its boxes met.
    pub age: u64,
}

/// What is known of the distance of two bodies: [`crate::Scene::measure`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairDistance {
    /// The body of the lower index.
    pub a: BodyId,
    /// The other one.
    pub b: BodyId,
    /// Proven: no point of one surface was closer to the other; 0 if nothing is known.
    #[cfg_attr(feature = "serde", serde(with = "crate::math::bound"))]
    pub low: f64,
    /// Proven: the distance of `triangles`, and 0 only if the surfaces met; infinite if nothing is
    /// known.
    #[cfg_attr(feature = "serde", serde(with = "crate::math::bound"))]
    pub high: f64,
    /// The closest triangles that were found: ids of the meshes of `a` and of `b`.
    pub triangles: Option<[u32; 2]>,
    /// Frames since this was proven: 0 if it holds for the bodies where they are in this frame. As
    /// many as there were if nothing is known.
    pub age: u64,
}

/// What is known of the least distance between two groups of bodies:
/// [`crate::Scene::measure_groups`]. It holds for the bodies where they are in this frame, whatever
/// the budget reached.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct GroupDistance {
    /// Of which groups.
    pub id: MeasureId,
    /// Proven: no point of one group is closer to the other; 0 if nothing is known, or if not all
    /// of their pairs were looked at ([`Report::unlisted`]), and infinite if no two of their bodies
    /// may meet.
    #[cfg_attr(feature = "serde", serde(with = "crate::math::bound"))]
    pub low: f64,
    /// Proven: the groups are no farther apart, and 0 only if bodies of them met; infinite if
    /// nothing is known.
    #[cfg_attr(feature = "serde", serde(with = "crate::math::bound"))]
    pub high: f64,
    /// The bodies that prove `high`, the lower index first. `None`: it is that of boxes.
    pub bodies: Option<[BodyId; 2]>,
    /// Their closest triangles that were found, no more than `high` apart: ids of their meshes.
    pub triangles: Option<[u32; 2]>,
    /// How many pairs of bodies may still be closer, or are to be measured. 0: `high - low` is
    /// within the tolerance.
    pub open: usize,
}

/// Until when two bodies are apart, of which one or both move: [`crate::Scene::set_motion`]. Times
/// from 0, this frame, to 1, the end of their motions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairPassage {
    /// The body of the lower index.
    pub a: BodyId,
    /// The other one.
    pub b: BodyId,
    /// Proven: they meet at no time before; 1 without `touching_at`: they are free to the end. 0 if
    /// the budget did not reach the pair.
    pub free_until: f64,
    /// Proven: they meet at this time. `None`: no contact was found (yet).
    pub touching_at: Option<f64>,
    /// The triangles that meet then: ids of the meshes of `a` and of `b`.
    pub triangles: Option<[u32; 2]>,
}

/// What becomes of a contact of two bodies in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactPhase {
    /// They are proven to touch in this frame, and were not known to before.
    Began,
    /// They are proven to touch again.
    Persists,
    /// They touched when it was last decided, and this frame has not decided it.
    Undecided,
    /// They are proven to be apart, or one was removed, or they may not meet any more
    /// ([`crate::Filter`]), or both are [fixed](crate::BodyKind::Fixed) and their distance is asked
    /// for no more.
    Ended,
}

named!(ContactPhase { Began => "began", Persists => "persists", Undecided => "undecided", Ended => "ended" });

/// A contact of two bodies: [`crate::Scene::track_contacts`]. They touch as long as their [verdict
/// meets](Verdict::meets), margins included.
///
/// It begins and ends in frames that prove it: of a pair that is undecided nothing is told but what
/// was proven last. So between two frames that decided it, bodies may have parted and met again
/// unseen, and a contact shorter than that is not told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BodyContact {
    /// The body of the lower index.
    pub a: BodyId,
    /// The other one.
    pub b: BodyId,
    /// What becomes of it in this frame.
    pub phase: ContactPhase,
    /// Frames since it began: 0 in the frame in which it did.
    pub age: u64,
}

/// What [`crate::Scene::detect`] found in a frame.
///
/// If it [is whole](Report::is_whole), bodies that are not in [`Report::pairs`] together, and may
/// meet, do not: their boxes are apart. Otherwise the budget ended in the broad phase, or there is
/// no room for all pairs; then this is so for two bodies whose partners are
/// [known](crate::Scene::partners_known) if [`Report::unlisted`] is 0.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Report {
    /// Frames so far, this one included.
    pub frame: u64,
    /// All pairs of bodies that may meet and whose boxes overlap, or whose
    /// [distance](crate::Scene::measure) is asked for, or that may be the closest of two
    /// [groups](crate::Scene::measure_groups); ascending by index, as far as they are known and
    /// listed.
    pub pairs: Vec<PairReport>,
    /// The distances that are [asked for](crate::Scene::measure), ascending by index, whether their
    /// pairs had a turn or not.
    pub distances: Vec<PairDistance>,
    /// The distances of groups that are [asked for](crate::Scene::measure_groups).
    pub group_distances: Vec<GroupDistance>,
    /// The pairs of `pairs` of which one or both bodies have a [motion](crate::Scene::set_motion),
    /// and whose distance is not asked for. Bodies that are not in `pairs` together, and may meet,
    /// do not meet on their way if the report [is whole](Report::is_whole).
    pub passages: Vec<PairPassage>,
    /// The contacts of bodies, ascending by index; of one index, that of a removed body first.
    /// Empty unless [asked for](crate::Scene::track_contacts). Contacts of a removed body end in
    /// the next frame, under its own id.
    pub contacts: Vec<BodyContact>,
    /// How many of `pairs` are decided in this frame.
    pub decided: usize,
    /// How many of `pairs` are proven to intersect: [`Verdict::Intersecting`].
    pub intersecting: usize,
    /// How many of `pairs` are proven to come within their margins: [`Verdict::Within`]. They are
    /// not among the intersecting ones.
    #[cfg_attr(feature = "serde", serde(default))]
    pub within: usize,
    /// How many of `pairs` are complete.
    pub complete: usize,
    /// The largest age of a pair in `pairs`.
    pub worst_age: u64,
    /// Bodies that changed or were removed and whose boxes are not up to date: the next frames
    /// place them.
    pub unplaced: usize,
    /// Bodies that not all partners are known of: they moved on or were removed, and the search for
    /// pairs is not at its end.
    pub unpaired: usize,
    /// Known pairs that were not looked at: they are not in `pairs`, and count as undecided. Their
    /// bodies are near each other; their boxes may overlap.
    pub unlisted: usize,
    /// Whether pairs were left out because there are [as many as there may
    /// be](crate::Scene::set_max_pairs). Their bodies are among the unpaired ones.
    pub is_full: bool,
    /// Work done: that of the queries ([`crate::Budget::work`]) and 250 for each that was begun.
    /// Not the broad phase.
    pub work: u64,
    /// Work of the broad phase: placing bodies, finding pairs and listing them.
    pub broad_phase_work: u64,
    /// BV tests of the queries.
    pub bv_tests: u64,
    /// Time of the frame; measured only under a time budget.
    pub elapsed: Option<Duration>,
}

impl Report {
    pub(super) fn begin(&mut self) {
        self.pairs.clear();
        self.distances.clear();
        self.group_distances.clear();
        self.passages.clear();
        (self.decided, self.intersecting, self.within, self.complete) = (0, 0, 0, 0);
        (self.work, self.bv_tests, self.worst_age) = (0, 0, 0);
    }

    /// Adds a pair that is not complete when the frame begins, and was decided so many frames
    /// before.
    #[inline(always)]
    pub(super) fn push_open(&mut self, [a, b]: [BodyId; 2], probability: f32, age: u64) {
        let (verdict, probability) = (Verdict::Undecided, f64::from(probability));
        self.pairs.push(PairReport {
            a,
            b,
            verdict,
            found: 0,
            complete: false,
            probability,
            recall: 0.0,
            age,
        });
    }

    /// Adds a pair of which nothing is left to find, and that was decided so many frames before.
    #[inline(always)]
    pub(super) fn push_complete(
        &mut self,
        [a, b]: [BodyId; 2],
        verdict: Verdict,
        found: u64,
        age: u64,
    ) {
        let probability = if verdict == Verdict::Undecided {
            0.5
        } else {
            f64::from(u8::from(verdict.meets()))
        };
        self.pairs.push(PairReport {
            a,
            b,
            verdict,
            found,
            complete: true,
            probability,
            recall: 1.0,
            age,
        });
        self.count(verdict);
        self.complete += 1;
    }

    /// Counts a pair that is decided.
    #[inline(always)]
    fn count(&mut self, verdict: Verdict) {
        self.decided += usize::from(verdict != Verdict::Undecided);
        self.intersecting += usize::from(matches!(verdict, Verdict::Intersecting { .. }));
        self.within += usize::from(matches!(verdict, Verdict::Within { .. }));
    }

    /// Counts what was spent.
    pub(super) fn spend(&mut self, spent: Spent) {
        self.work += spent.work;
        self.bv_tests += spent.bv_tests;
    }

    /// Takes note of what became of a pair, and of the work and BV tests for it.
    pub(super) fn note(&mut self, place: usize, standing: Standing, spent: Spent) {
        self.spend(spent);
        let Standing {
            verdict,
            found,
            complete,
            recall,
        } = standing;
        let pair = &mut self.pairs[place];
        let is_news = verdict != Verdict::Undecided && pair.verdict == Verdict::Undecided;
        if verdict != Verdict::Undecided {
            (pair.verdict, pair.found, pair.age) = (verdict, found, 0);
            pair.probability = f64::from(u8::from(verdict.meets()));
        } else if complete {
            pair.probability = 0.5;
        }
        self.complete += usize::from(complete && !pair.complete);
        pair.complete |= complete;
        pair.recall = if pair.complete { 1.0 } else { recall };
        if is_news {
            self.count(verdict);
        }
    }

    /// Takes note of what is estimated of a stopped query; what is proven of the pair stays.
    pub(super) fn estimate(&mut self, place: usize, estimate: &Estimate) {
        let pair = &mut self.pairs[place];
        if pair.verdict == Verdict::Undecided && !pair.complete {
            pair.probability = estimate.probability;
        }
        if pair.found > 0 && !pair.complete && estimate.recall > 0.0 {
            pair.recall = estimate.recall.min(1.0 - f64::EPSILON);
        }
    }

    pub(super) fn finish(&mut self) {
        if self.decided < self.pairs.len() {
            self.worst_age = self.pairs.iter().map(|pair| pair.age).max().unwrap_or(0);
        }
    }

    /// Whether it would be the same in a frame in which nothing has changed.
    pub(super) fn is_final(&self) -> bool {
        let asks_more = !(self.distances.is_empty()
            && self.group_distances.is_empty()
            && self.passages.is_empty());
        let all = self.pairs.len();
        self.is_whole()
            && !self.is_full
            && (self.decided, self.complete) == (all, all)
            && !asks_more
    }

    /// How many known pairs are not decided.
    pub fn undecided(&self) -> usize {
        self.pairs.len() - self.decided + self.unlisted
    }

    /// Whether the broad phase came to its end, so that all pairs of bodies that may meet and whose
    /// boxes overlap are in `pairs`.
    pub fn is_whole(&self) -> bool {
        (self.unplaced, self.unpaired, self.unlisted) == (0, 0, 0)
    }

    /// What it says about two bodies; `None` if they are not in [`Report::pairs`] together. A
    /// report is data: ids of another scene to which the same was done name the same here.
    pub fn pair(&self, x: BodyId, y: BodyId) -> Option<&PairReport> {
        let (a, b) = if x.index() < y.index() {
            (x, y)
        } else {
            (y, x)
        };
        let at = self
            .pairs
            .binary_search_by_key(&(a.index(), b.index()), |pair| {
                (pair.a.index(), pair.b.index())
            });
        self.pairs
            .get(at.ok()?)
            .filter(|pair| pair.a == a && pair.b == b)
    }

    /// The pairs that are proven to meet, thickened by their margins: those that intersect, and
    /// those that come within.
    pub fn meeting_pairs(&self) -> impl Iterator<Item = &PairReport> {
        self.pairs.iter().filter(|pair| pair.verdict.meets())
    }

    /// The pairs that are proven to intersect.
    pub fn intersecting_pairs(&self) -> impl Iterator<Item = &PairReport> {
        self.pairs
            .iter()
            .filter(|pair| matches!(pair.verdict, Verdict::Intersecting { .. }))
    }
}
