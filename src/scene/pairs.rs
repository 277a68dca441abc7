//! The pairs of bodies: candidates whose wide boxes overlap, and what is kept about those whose boxes do.

use super::body::Bodies;
use super::broad::{Broad, News, overlap};
use super::chain::WORK_PER_WITNESS;
use crate::query::{Outcome, PairMemory, Stats, StopReason, Verdict};
use alloc::boxed::Box;
use alloc::vec::Vec;

/// Two bodies, the lower index in the upper half: pairs are ordered by it.
pub(super) type Key = u64;

pub(super) fn key(a: u32, b: u32) -> Key {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

pub(super) fn bodies(key: Key) -> [u32; 2] {
    [(key >> 32) as u32, key as u32]
}

/// What is kept about two bodies as long as their boxes overlap.
#[derive(Clone, Debug)]
pub(super) struct Track {
    pub memory: PairMemory,
    /// What the last frame that decided it found.
    pub verdict: Verdict,
    pub found: u64,
    /// The last frame that ran it to its end; 0 if none did.
    pub completed: u64,
    /// The last frame that decided it; before, the one before the first.
    pub decided: u64,
    /// The last frame in which its last witnesses were tested and did not meet.
    pub refuted: u64,
    /// Work of the last run to the end; 0 if there was none.
    pub cost: u64,
    /// The same, or more if that is known, where no remembered witness spared the search.
    pub search: u64,
    /// Work and BV tests of the run that is not at its end.
    pub pending: [u64; 2],
}

impl Track {
    /// A pair that is first looked at in `frame`.
    fn new(frame: u64) -> Self {
        Self {
            memory: PairMemory::new(),
            verdict: Verdict::Undecided,
            found: 0,
            completed: 0,
            decided: frame - 1,
            refuted: 0,
            cost: 0,
            search: 0,
            pending: [0; 2],
        }
    }

    /// Takes note of a witness that still meets in `frame`.
    pub fn meets(&mut self, witness: [u32; 2], frame: u64) {
        (self.decided, self.completed, self.cost, self.pending) = (frame, frame, WORK_PER_WITNESS, [0; 2]);
        (self.verdict, self.found) = (Verdict::Intersecting { witness }, 1);
    }

    /// Takes note of a call in `frame`; whether the run is at its end.
    pub fn note(&mut self, outcome: &Outcome, frame: u64) -> bool {
        let Stats { work, bv_tests, .. } = outcome.stats;
        let done = matches!(outcome.stop, StopReason::Finished | StopReason::FirstHit);
        if done {
            (self.completed, self.cost, self.pending) = (frame, work, [0; 2]);
            if bv_tests > 0 {
                self.search = work;
            }
        } else {
            self.search = self.search.max(2 * work);
            self.pending = [work, bv_tests];
        }
        if outcome.verdict != Verdict::Undecided {
            (self.decided, self.verdict, self.found) = (frame, outcome.verdict, outcome.found);
        }
        done
    }
}

const NONE: u32 = u32::MAX;

/// Two bodies whose wide boxes overlap, and where the track of those is whose boxes do; [`NONE`] for the others.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    key: Key,
    slot: u32,
}

/// Two bodies whose boxes overlap, and where their track is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Overlap {
    pub key: Key,
    pub slot: u32,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Pairs {
    /// Ascending.
    candidates: Vec<Candidate>,
    merged: Vec<Candidate>,
    /// A track is away while its pair is run.
    tracks: Vec<Option<Box<Track>>>,
    free: Vec<u32>,
    /// Those of this frame, ascending.
    pub overlaps: Vec<Overlap>,
}

impl Pairs {
    pub fn track(&mut self, slot: u32) -> Option<&mut Track> {
        self.tracks[slot as usize].as_deref_mut()
    }

    /// Takes a track out.
    pub fn take(&mut self, slot: u32) -> Option<Box<Track>> {
        self.tracks[slot as usize].take()
    }

    pub fn put_back(&mut self, slot: u32, track: Box<Track>) {
        self.tracks[slot as usize] = Some(track);
    }

    /// Finds the pairs whose boxes overlap in `frame`.
    pub fn update(&mut self, broad: &mut Broad, bodies: &Bodies, frame: u64) {
        broad.update();
        self.merge(broad, bodies);
        self.overlaps.clear();
        for Candidate { key, slot } in &mut self.candidates {
            let [a, b] = self::bodies(*key);
            if overlap(broad.bounds(a), broad.bounds(b)) {
                if *slot == NONE {
                    *slot = new_track(&mut self.tracks, &mut self.free, frame);
                }
                self.overlaps.push(Overlap { key: *key, slot: *slot });
            } else if *slot != NONE {
                self.free.push(*slot);
                *slot = NONE;
            }
        }
        broad.forget_news();
    }

    /// Replaces the candidates that have a body with news by those found now.
    fn merge(&mut self, broad: &Broad, bodies: &Bodies) {
        if !broad.has_news() {
            return;
        }
        let may_meet = |key: Key| {
            let [a, b] = self::bodies(key);
            bodies.facts(a).may_meet(bodies.facts(b))
        };
        let mut found = broad.found().iter().copied().filter(|&key| may_meet(key)).peekable();
        self.merged.clear();
        for &candidate in &self.candidates {
            while let Some(key) = found.next_if(|&key| key < candidate.key) {
                self.merged.push(Candidate { key, slot: NONE });
            }
            let again = found.next_if_eq(&candidate.key).is_some();
            let [a, b] = self::bodies(candidate.key);
            match broad.news(a).max(broad.news(b)) {
                News::None => self.merged.push(candidate),
                News::Place if again => self.merged.push(candidate),
                news => {
                    if candidate.slot != NONE {
                        self.free.push(candidate.slot);
                    }
                    if again && news == News::Body {
                        self.merged.push(Candidate { key: candidate.key, slot: NONE });
                    }
                }
            }
        }
        self.merged.extend(found.map(|key| Candidate { key, slot: NONE }));
        core::mem::swap(&mut self.candidates, &mut self.merged);
    }
}

/// A place with a new track; those of pairs that are apart are used again.
fn new_track(tracks: &mut Vec<Option<Box<Track>>>, free: &mut Vec<u32>, frame: u64) -> u32 {
    let slot = free.pop().unwrap_or_else(|| {
        tracks.push(None);
        tracks.len() as u32 - 1
    });
    match &mut tracks[slot as usize] {
        Some(track) => **track = Track::new(frame),
        empty => *empty = Some(Box::new(Track::new(frame))),
    }
    slot
}
