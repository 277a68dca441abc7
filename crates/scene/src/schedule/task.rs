//! A pair's work in this frame: its forecast, rank and question.

use super::forecast::Forecast;
use super::known::Known;
use super::pairs::Pairs;
use crate::ask::TurnKind;
use crate::body::margins;
use crate::id::{PairKey, bodies_of};
use crate::pair::frame::Frame;
use crate::pair::state::{PairState, Turn};

/// The need for contacts of which nothing is known: displacement of the bodies, in skins.
const MOST_NEED: f64 = 1000.0;

/// A pair that was not finished when the frame began.
#[derive(Debug)]
pub(crate) struct Task {
    pub key: PairKey,
    /// Its index in the report, and its index in the list of known pairs.
    pub listed: u32,
    pub place: u32,
    /// Expected work, median.
    pub median: u32,
    /// Sort key: by importance, then by expected gain per work, both descending.
    pub rank: u64,
    /// The batch that holds its stopped run.
    pub home: Option<u8>,
    pub kind: TurnKind,
    /// True if it may be the closest of a group.
    pub measures: bool,
    /// True if its reported probabilities can now be compared with the verdict.
    pub teaches: bool,
    /// True if it is neither in a batch nor finished.
    pub open: bool,
}

impl Task {
    /// Its turn in a batch, as the task `index` of the frame.
    pub fn assign(&mut self, index: u32, pairs: &mut Pairs, frame: &Frame) -> Turn {
        self.open = false;
        let mut turn = pairs.take(self.place as usize, frame.number);
        if self.kind == TurnKind::Contacts && turn.state.touch.is_none() {
            turn.state.touch = Some(pairs.touches.lend());
        }
        Turn {
            index,
            median: self.median,
            kind: self.kind,
            next: Some(self.kind),
            ..turn
        }
    }

    /// Changes its question.
    #[cold]
    pub fn ask(&mut self, kind: TurnKind, frame: &Frame, turn: &Turn) {
        let state = Some(&*turn.state);
        let (forecast, rank) = outlook(frame, &turn.known, state, kind, None, true);
        (self.kind, self.median, self.rank) = (kind, forecast.median, rank);
    }
}

/// The forecast and rank of a question; trivial if `expects` is false. `state`: the state of the
/// pair, which only special questions need. `nearness`, for a pair that
/// may be the closest of two groups: 1 if it meets, 0 if it is at the upper bound of their
/// distance.
#[inline(always)]
pub(crate) fn outlook(
    frame: &Frame,
    known: &Known,
    state: Option<&PairState>,
    kind: TurnKind,
    nearness: Option<f32>,
    expects: bool,
) -> (Forecast, u64) {
    if !expects {
        return (Forecast::EQUAL, 0);
    }
    let key = known.key;
    let [x, y] = frame.bodies.facts_of(key);
    let special = x.is_special | y.is_special;
    // A distance takes about four times as long.
    let scale = if special { 2.0 } else { 1.0 };
    let sizes = [scale * x.size, scale * y.size];
    let forecast = match kind {
        TurnKind::Contacts => {
            let skin = frame.bodies.pair(key).map_or(0.0, margins);
            // A part of the contacts may be of little use.
            let touch = state.and_then(|state| state.touch.as_ref());
            let whole = touch.filter(|touch| touch.completed >= touch.since);
            let drift = whole.map_or(f64::INFINITY, |touch| {
                frame.bodies.drift(key, touch, frame.number)
            });
            let touch = touch.map(|touch| &**touch);
            Forecast::of_contacts(touch, sizes, (drift / skin).min(MOST_NEED) as f32)
        }
        TurnKind::Meet | TurnKind::Motion => {
            let part = frame.bodies.common_part(bodies_of(key)).unwrap_or(0.0);
            let age = (frame.number - frame.decided(known.since(frame.number))) as f32;
            Forecast::new(known, age, sizes, part)
        }
    };
    let urgency = if special && kind != TurnKind::Contacts {
        nearness.or_else(|| state?.urgency())
    } else {
        None
    };
    let importance = x.importance.max(y.importance) + frame.bodies.weight(key, kind);
    (
        forecast,
        rank(
            importance,
            urgency.map_or(forecast.gain, |urgency| 1.0 + urgency),
        ),
    )
}

/// Sort key: by importance, then by gain, which is not negative, both descending.
pub(crate) fn rank(importance: f32, gain: f32) -> u64 {
    let bits = importance.to_bits();
    let ascending = if bits >> 31 == 1 {
        !bits
    } else {
        bits | 1 << 31
    };
    u64::from(!ascending) << 32 | u64::from(!gain.to_bits())
}
