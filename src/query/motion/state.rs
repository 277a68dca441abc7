//! The state of a motion query: the time until which the motion is proven free, and the earliest
//! contact found.

use super::relative_motion::Substep;
use crate::engine::frontier::{BUCKETS, Frontier};
use crate::engine::options::MotionOptions;
use crate::query::distance::search::Search;

/// A triangle pair (tree order) that is traced through time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Followed {
    pub pair: [u32; 2],
    /// The pair does not meet before `from`, nor, in this substep, after `until`.
    pub from: f64,
    pub until: f64,
    /// Length of the next time interval to test, and of the interval after `from` in which a
    /// contact is searched for.
    pub span: f64,
    pub longest: f64,
    pub phase: Phase,
    /// Steps since the last time at which the test was inconclusive, and number of such times.
    pub steps: u32,
    pub doubts: i32,
}

impl Followed {
    /// A pair that may meet between two times, with the length of the first time interval to test.
    pub fn new(pair: [u32; 2], [from, until]: [f64; 2], span: f64) -> Self {
        Self {
            pair,
            from,
            until,
            span,
            longest: 0.0,
            phase: Phase::Window,
            steps: 0,
            doubts: 0,
        }
    }
}

/// The next test of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Finds when the pair may meet, from the normals and edges of its triangles.
    Window,
    /// Finds it from the direction between their closest points: for triangles that are coplanar or
    /// degenerate, or that turn.
    Direction,
    /// Tests whether the pair meets at one of the [`MOMENTS`], given by its index.
    Contact(usize),
}

/// Fractions of the search interval at which contact is tested. 0.0 applies only at the start of
/// the motion, then 1.0. The others follow if these show no contact and no direction separates the
/// triangles; after them the time is given up.
pub(super) const MOMENTS: [f64; 4] = [0.0, 1.0, 1.0 / 2.0, 1.0 / 16.0];

/// A proven contact: the surfaces meet at this time, in these triangles (tree order).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    pub time: f64,
    pub pair: [u32; 2],
    /// Proven upper bound of the distance of the triangles at this time. 0 only if they intersect.
    pub distance: f64,
}

/// The state of a motion; times from 0 to 1.
#[derive(Clone, Debug)]
pub(crate) struct MotionState {
    /// The options of the query.
    pub options: Option<MotionOptions>,
    /// The current substep of the motion.
    pub substep: u32,
    /// Half of the tolerance in time: a contact may be twice this later than `free_until`.
    tolerance: f64,
    free_until: f64,
    /// Lower bound of the times at which the pairs that are done meet. A pair is done once its
    /// contact is found, if it meets too late to matter, or if `f64` cannot decide.
    done: f64,
    contact: Option<Contact>,
    pub followed: Option<Followed>,
}

impl MotionState {
    /// Nothing is known yet.
    pub const NOTHING: Self = Self {
        options: None,
        substep: 0,
        tolerance: 0.0,
        free_until: 0.0,
        done: f64::INFINITY,
        contact: None,
        followed: None,
    };

    /// Starts a motion for which no contact is possible before `free_until`.
    pub fn begin(&mut self, options: &MotionOptions, tolerance: f64, free_until: f64) {
        // Field by field: the state is large, and most of it need not be written.
        (self.options, self.substep) = (Some(*options), 0);
        (self.tolerance, self.free_until) = (tolerance, free_until);
        (self.done, self.contact, self.followed) = (f64::INFINITY, None, None);
    }

    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    pub fn contact(&self) -> Option<Contact> {
        self.contact
    }

    /// There is no contact before this time.
    pub fn free_until(&self) -> f64 {
        self.free_until
    }

    /// A pair that is free until this time no longer matters.
    pub fn cut(&self) -> f64 {
        self.contact.map_or(f64::INFINITY, |contact| {
            (contact.time - 2.0 * self.tolerance).max(0.0)
        })
    }

    /// True if a pair that does not meet before `from` matters. The tolerance does not apply to the
    /// question whether the surfaces meet at the start.
    pub fn matters(&self, from: f64) -> bool {
        from < self.cut() || from <= 0.0
    }

    /// True if nothing left could change the answer: the surfaces meet at the start.
    pub fn is_decided(&self) -> bool {
        self.contact.is_some_and(|contact| contact.time <= 0.0)
    }

    pub fn touch(&mut self, contact: Contact) {
        if self.contact.is_none_or(|known| contact.time < known.time) {
            self.contact = Some(contact);
        }
    }

    /// Records that triangles that do not meet before `time` are done.
    #[inline(always)]
    pub fn pass(&mut self, time: f64) {
        self.done = self.done.min(time);
    }

    /// Records that all substeps are done.
    pub fn end(&mut self) {
        self.free_until = self.free_until.max(self.done.min(1.0));
    }

    /// Raises the lower bound to the least time of the pairs left of a substep. `current` is the
    /// time of the current node pair, if there is one.
    pub(super) fn bound(
        &mut self,
        frontier: &Frontier,
        search: &Search,
        substep: &Substep,
        current: f32,
    ) {
        let nodes = match frontier.least_bucket() {
            None => f32::INFINITY,
            Some(bucket) => least_key(bucket),
        };
        let waiting = search.waiting.iter().map(|left| left.key);
        let pairs = waiting.chain(search.proposed.iter().map(|left| left.low));
        let left = substep.time(pairs.fold(nodes.min(current), f32::min));
        let followed = self
            .followed
            .as_ref()
            .map_or(f64::INFINITY, |followed| followed.from);
        self.free_until = self.free_until.max(left.min(followed).min(self.done));
    }
}

/// The bucket of a time in lengths of the substep. The first bucket is for pairs that may meet at
/// its begin.
pub(super) fn bucket(key: f32) -> usize {
    let steps = (key + 0.5) * (BUCKETS - 2) as f32;
    // Conversions to `i32` need fewer instructions than those to `usize`.
    1 + (steps as i32).clamp(0, BUCKETS as i32 - 2) as usize
}

/// The earliest time of a bucket.
pub(super) fn least_key(bucket: usize) -> f32 {
    if bucket == 0 {
        f32::NEG_INFINITY
    } else {
        (bucket - 1) as f32 / (BUCKETS - 2) as f32 - 0.5 - f32::EPSILON
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_bucket_holds_what_is_before_it() {
        for i in 0..=10_000 {
            let key = i as f32 / 10_000.0 - 0.5;
            let bucket = bucket(key);
            assert!(
                bucket < BUCKETS && least_key(bucket) <= key && key <= least_key(bucket) + 0.01,
                "{key} {bucket}"
            );
        }
    }
}
