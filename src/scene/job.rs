//! One pair in one frame: what is expected of it, and what became of it.

use super::forecast::Forecast;
use super::id::PairKey;
use super::state::Turn;

/// A pair that was not at its end when the frame began.
#[derive(Debug)]
pub(super) struct Job {
    pub key: PairKey,
    /// Its place in the report, and that among the known pairs.
    pub listed: u32,
    pub place: u32,
    pub forecast: Forecast,
    /// Sorts by importance, then by the chance of finding an intersection per expected work, both descending.
    pub rank: u64,
    /// The batch that holds its stopped run.
    pub home: Option<u8>,
    /// Whether its last witness is likely to decide it, and has not been tested yet.
    pub witnessed: bool,
    /// Whether it is neither in a batch nor at its end.
    pub open: bool,
}

impl Job {
    /// Work that it is expected to take, median.
    pub fn median(&self) -> u64 {
        self.forecast.median.into()
    }

    /// Its turn in a batch, as the job `index` of the frame. `is_blank`: whether the state is new.
    pub fn dealt(&mut self, index: u32, is_blank: bool) -> Turn {
        self.open = false;
        let Self { key, witnessed, .. } = *self;
        Turn { key, index, median: self.median(), witnessed, is_blank, ..Turn::NONE }
    }
}

/// Sorts by importance, then by gain, not negative, both descending.
pub(super) fn rank(importance: f32, gain: f32) -> u64 {
    let bits = importance.to_bits();
    let ascending = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    u64::from(!ascending) << 32 | u64::from(!gain.to_bits())
}
