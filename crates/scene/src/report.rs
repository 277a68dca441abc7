//! The report of a frame.

use super::id::{BodyId, MeasureId};
use super::pair::spent::Spent;
use super::pair::state::Standing;
use alloc::vec::Vec;
use core::time::Duration;
use punctual::Verdict;
use punctual::prediction::Estimate;
use punctual_geom::named;

/// The result for two bodies whose boxes overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairReport {
    /// The body with the lower index: A of the pair.
    pub a: BodyId,
    /// The other one.
    pub b: BodyId,
    /// States whether their surfaces, thickened by their [margins](crate::Body::margin), meet in
    /// this frame.
    pub verdict: Verdict,
    /// Intersecting pairs of triangles found. In [`punctual::Mode::Any`], and for bodies with
    /// margins, at most 1: the witness.
    pub found: u64,
    /// True if nothing is left to find. In [`punctual::Mode::Any`] the pair is decided, and its
    /// distance and its time of impact are known if they are requested. In [`punctual::Mode::All`]
    /// all intersections have been found. A complete pair can be undecided: if rounding hides
    /// whether bodies with margins meet, or whether moving bodies meet at the start.
    pub complete: bool,
    /// Probability that the surfaces meet: 1 or 0 if that is decided, whatever else is open; 0.5 if
    /// the pair is complete but undecided. Otherwise, for a pair whose query was stopped, it is
    /// that of [`punctual::Query::estimate`], corrected by [`crate::Scene::calibration`]. For a
    /// pair without a turn, or in frames of less than 1 ms, it comes from the pair's history and
    /// the overlap of the boxes.
    pub probability: f64,
    /// Expected share of the intersecting pairs of triangles that was found: 1 if `complete`, 0 if
    /// nothing was found. Otherwise, for a stopped query, it is that of
    /// [`punctual::Query::estimate`], or else the share of its expected work that is done.
    pub recall: f64,
    /// Frames since the pair was decided: 0 if in this one. A pair that was never decided counts
    /// from the frame before its boxes met.
    pub age: u64,
}

/// The distance of two bodies: [`crate::Scene::measure`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairDistance {
    /// The body with the lower index.
    pub a: BodyId,
    /// The other one.
    pub b: BodyId,
    /// Proven lower bound: no point of one surface was closer to the other. 0 if nothing is known.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub low: f64,
    /// Proven upper bound: the distance of `triangles`. 0 only if the surfaces met; infinite if
    /// nothing is known.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub high: f64,
    /// The closest triangles found: ids of the meshes of `a` and of `b`.
    pub triangles: Option<[u32; 2]>,
    /// Frames since this was proven: 0 if it holds for the poses of this frame. If nothing is
    /// known, the number of frames so far.
    pub age: u64,
}

/// The least distance between two groups of bodies: [`crate::Scene::measure_groups`]. It holds for
/// the poses of this frame, whatever the budget reached.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct GroupDistance {
    /// The id of the groups.
    pub id: MeasureId,
    /// Proven lower bound: no point of one group is closer to the other. 0 if nothing is known, or
    /// if not all of their pairs were listed ([`Report::unlisted`]). Infinite if no two of their
    /// bodies may meet.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub low: f64,
    /// Proven upper bound of the distance. 0 only if bodies of the groups met; infinite if nothing
    /// is known.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub high: f64,
    /// The bodies that prove `high`, the lower index first. `None` if `high` is a bound from boxes.
    pub bodies: Option<[BodyId; 2]>,
    /// Their closest triangles found, at most `high` apart: ids of their meshes.
    pub triangles: Option<[u32; 2]>,
    /// Number of pairs of bodies that may be closer or must still be measured. If 0, `high - low`
    /// is within the tolerance.
    pub open: usize,
}

/// Time of impact of two bodies, of which one or both move: [`crate::Scene::set_motion`]. Times
/// range from 0, this frame, to 1, the end of their motions. If their distance is
/// [measured](crate::Scene::measure) too, [`PairDistance`] is that at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairPassage {
    /// The body with the lower index.
    pub a: BodyId,
    /// The other one.
    pub b: BodyId,
    /// Proven: the bodies meet at no time before. If it is 1 and `touching_at` is `None`, they are
    /// free to the end. 0 if the budget did not reach the pair.
    pub free_until: f64,
    /// Proven: the bodies meet at this time. `None` if no contact was found (yet).
    pub touching_at: Option<f64>,
    /// The triangles that meet at `touching_at`: ids of the meshes of `a` and of `b`.
    pub triangles: Option<[u32; 2]>,
}

/// State of a contact of two bodies in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactPhase {
    /// The bodies are proven to touch in this frame, and had no contact before.
    Began,
    /// The bodies are proven to touch again.
    Persists,
    /// The bodies touched when that was last decided, and this frame has not decided it.
    Undecided,
    /// The bodies are proven separated, or one was removed, or they may no longer meet
    /// ([`crate::Filter`]), or both are [fixed](crate::BodyKind::Fixed) and their distance is no
    /// longer measured.
    Ended,
}

named!(ContactPhase { Began => "began", Persists => "persists", Undecided => "undecided", Ended => "ended" });

/// A contact of two bodies: [`crate::Scene::track_contacts`]. They touch as long as their [verdict
/// meets](Verdict::meets), margins included.
///
/// A contact begins and ends in frames that prove it. For an undecided pair the last proven state
/// is reported. So between two frames that decided it, bodies may have separated and met again
/// unnoticed, and a shorter contact is not reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BodyContact {
    /// The body with the lower index.
    pub a: BodyId,
    /// The other one.
    pub b: BodyId,
    /// The state in this frame.
    pub phase: ContactPhase,
    /// Frames since it began: 0 in the frame in which it began.
    pub age: u64,
}

/// The results of [`crate::Scene::detect`] for a frame.
///
/// If it [is whole](Report::is_whole), [`Report::pairs`] has every pair of bodies that may meet and
/// whose boxes overlap; all others are apart. Otherwise the budget ended in the broad phase, or
/// there is no room for all pairs. If [`Report::unlisted`] is 0, the list still has all pairs of
/// two bodies whose partners are [known](crate::Scene::partners_known).
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Report {
    /// Number of frames so far, including this one.
    pub frame: u64,
    /// Pairs of bodies that may meet and whose boxes overlap, or whose
    /// [distance](crate::Scene::measure) is measured, or that may be the closest of two
    /// [groups](crate::Scene::measure_groups). Ascending by index, as far as they are known and
    /// listed.
    pub pairs: Vec<PairReport>,
    /// The [measured](crate::Scene::measure_groups) distances of groups.
    pub group_distances: Vec<GroupDistance>,
    /// The contacts of bodies, ascending by index; of equal indices, that of a removed body first.
    /// Empty unless [tracked](crate::Scene::track_contacts). Contacts of a removed body end in the
    /// next frame, with its own id.
    pub contacts: Vec<BodyContact>,
    /// Number of pairs in `pairs` decided in this frame.
    pub decided: usize,
    /// Number of pairs in `pairs` proven to intersect: [`Verdict::Intersecting`].
    pub intersecting: usize,
    /// Number of pairs in `pairs` proven to be within their margins: [`Verdict::Within`]. They do
    /// not count as intersecting.
    #[cfg_attr(feature = "serde", serde(default))]
    pub within: usize,
    /// Number of pairs in `pairs` proven to be one inside the other, or partly so:
    /// [`Verdict::Contained`].
    #[cfg_attr(feature = "serde", serde(default))]
    pub contained: usize,
    /// Number of complete pairs in `pairs`.
    pub complete: usize,
    /// The largest age of a pair in `pairs`.
    pub worst_age: u64,
    /// Bodies that changed or were removed and whose boxes are outdated. The next frames place
    /// them.
    pub unplaced: usize,
    /// Bodies with possibly unknown partners: they moved or were removed, and the search for pairs
    /// is unfinished.
    pub unpaired: usize,
    /// Known pairs that were not listed: they are not in `pairs`, and count as undecided. Their
    /// bodies are near each other; their boxes may overlap.
    pub unlisted: usize,
    /// True if pairs were left out because the [maximum number](crate::Scene::set_max_pairs) was
    /// reached. Their bodies count as unpaired.
    pub is_full: bool,
    /// Work of the queries ([`punctual::Budget::work`]), plus 250 units for each query begun.
    /// Excludes the broad phase.
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
        self.group_distances.clear();
        (self.decided, self.complete) = (0, 0);
        (self.intersecting, self.within, self.contained) = (0, 0, 0);
        (self.work, self.bv_tests, self.worst_age) = (0, 0, 0);
    }

    /// Begins a frame that keeps the pairs, because nothing has changed.
    pub(super) fn go_on(&mut self) {
        (self.work, self.bv_tests, self.worst_age) = (0, 0, 0);
        for pair in &mut self.pairs {
            pair.age += u64::from(pair.verdict == Verdict::Undecided);
        }
    }

    /// Adds a pair that is not complete when the frame begins, and was decided `age` frames before.
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

    /// Adds a complete pair, which was decided `age` frames before.
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

    #[inline(always)]
    fn count(&mut self, verdict: Verdict) {
        self.decided += usize::from(verdict != Verdict::Undecided);
        self.intersecting += usize::from(matches!(verdict, Verdict::Intersecting { .. }));
        self.within += usize::from(matches!(verdict, Verdict::Within { .. }));
        self.contained += usize::from(matches!(verdict, Verdict::Contained { .. }));
    }

    pub(super) fn spend(&mut self, spent: Spent) {
        self.work += spent.work;
        self.bv_tests += spent.bv_tests;
    }

    /// Stores the result of a pair, and its work and BV tests.
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
            (pair.verdict, pair.found, pair.age, pair.recall) = (verdict, found, 0, recall);
            pair.probability = f64::from(u8::from(verdict.meets()));
        } else if complete {
            pair.probability = 0.5;
        }
        self.complete += usize::from(complete && !pair.complete);
        pair.complete |= complete;
        if pair.complete {
            pair.recall = 1.0;
        }
        if is_news {
            self.count(verdict);
        }
    }

    /// Stores the estimate for a stopped query; proven results stay.
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

    /// True if a frame without changes would give the same report.
    pub(super) fn is_final(&self) -> bool {
        let all = self.pairs.len();
        self.is_whole()
            && !self.is_full
            && (self.decided, self.complete) == (all, all)
            && self.group_distances.iter().all(|group| group.open == 0)
    }

    /// Number of known pairs that are not decided.
    pub fn undecided(&self) -> usize {
        self.pairs.len() - self.decided + self.unlisted
    }

    /// True if the broad phase is finished, so that all pairs of bodies that may meet and whose
    /// boxes overlap are in `pairs`.
    pub fn is_whole(&self) -> bool {
        (self.unplaced, self.unpaired, self.unlisted) == (0, 0, 0)
    }

    /// The report of two bodies; `None` if they are not in [`Report::pairs`] together. Ids of
    /// another scene with the same history of changes are valid here too.
    pub fn pair(&self, x: BodyId, y: BodyId) -> Option<&PairReport> {
        let pair = (x.min(y), x.max(y));
        let at = self
            .pairs
            .binary_search_by_key(&pair, |pair| (pair.a, pair.b));
        self.pairs.get(at.ok()?)
    }

    /// The pairs proven to meet, thickened by their margins: those that intersect, those within
    /// their margins, and solids inside others.
    pub fn meeting_pairs(&self) -> impl Iterator<Item = &PairReport> {
        self.pairs.iter().filter(|pair| pair.verdict.meets())
    }

    /// The pairs proven to intersect.
    pub fn intersecting_pairs(&self) -> impl Iterator<Item = &PairReport> {
        self.pairs
            .iter()
            .filter(|pair| matches!(pair.verdict, Verdict::Intersecting { .. }))
    }
}
