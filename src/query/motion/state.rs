//! The state of a motion query: how far the motion is proven to be free, and the earliest contact
//! found.

use super::course::Piece;
use crate::query::options::MotionOptions;
use crate::query::queue::{BUCKETS, Front};
use crate::query::search::Search;
use crate::query::views::Views;

/// A triangle pair (tree order) that is followed through time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Followed {
    pub pair: [u32; 2],
    /// It does not meet before, nor, in this piece, after.
    pub from: f64,
    pub until: f64,
    /// Over how much time it is looked at next, and how long after `from` a contact is looked for.
    pub span: f64,
    pub longest: f64,
    pub phase: Phase,
    /// Steps since the last time at which it could not be told whether it meets, and how many such
    /// times there were.
    pub steps: u32,
    pub doubts: i32,
}

impl Followed {
    /// A pair that may meet between two times, to be looked at over a span of time.
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

/// What is asked of a pair next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// When it may meet, by the normals and edges of its triangles.
    Window,
    /// The same by the direction in which the triangles are closest: where they are coplanar or
    /// degenerate, or turn.
    Direction,
    /// Whether it meets at one of the [`MOMENTS`], by number.
    Contact(usize),
}

/// At which parts of the time in which a contact is looked for: the first if that is the start of
/// the motion, the second, and where neither shows a contact nor any direction that there is none,
/// the others, before this time is given up.
pub(super) const MOMENTS: [f64; 4] = [0.0, 1.0, 1.0 / 2.0, 1.0 / 16.0];

/// A proven contact: the surfaces meet at this time, where these triangles (tree order) do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    pub time: f64,
    pub pair: [u32; 2],
    /// Proven: these are no farther apart then. 0 only if they intersect.
    pub distance: f64,
}

/// What is known of a motion, times from 0 to 1.
#[derive(Clone, Debug)]
pub(crate) struct MotionState {
    /// What was asked.
    pub options: Option<MotionOptions>,
    /// The piece of the motion at hand.
    pub piece: u32,
    /// Half of how much later than `free_until` a contact may be.
    tolerance: f64,
    free_until: f64,
    /// The earliest time at which triangles may meet that are done with: they meet then, or later
    /// than matters, or `f64` cannot tell.
    done: f64,
    contact: Option<Contact>,
    pub followed: Option<Followed>,
    /// How the two nodes at hand see one another, where the box test needs it in memory.
    pub(super) views: Views<[f32; 8]>,
}

impl MotionState {
    /// Nothing is known yet.
    pub const NOTHING: Self = Self {
        options: None,
        piece: 0,
        tolerance: 0.0,
        free_until: 0.0,
        done: f64::INFINITY,
        contact: None,
        followed: None,
        views: Views::NONE,
    };

    /// Begins with a time before which there is no contact.
    pub fn begin(&mut self, options: &MotionOptions, tolerance: f64, free_until: f64) {
        // Not as a whole: it is large, and most of it need not be written.
        let Self {
            options: asked,
            piece,
            tolerance: half,
            free_until: free,
            done,
            contact,
            followed,
            ..
        } = self;
        (*asked, *piece, *half, *free) = (Some(*options), 0, tolerance, free_until);
        (*done, *contact, *followed) = (f64::INFINITY, None, None);
    }

    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    pub fn contact(&self) -> Option<Contact> {
        self.contact
    }

    /// No contact before.
    pub fn free_until(&self) -> f64 {
        self.free_until
    }

    /// What is free until then does not matter any more.
    pub fn cut(&self) -> f64 {
        self.contact.map_or(f64::INFINITY, |contact| {
            (contact.time - 2.0 * self.tolerance).max(0.0)
        })
    }

    /// Whether a pair matters that does not meet before `from`. Whether surfaces meet at the start
    /// is no question of tolerance.
    pub fn matters(&self, from: f64) -> bool {
        from < self.cut() || from <= 0.0
    }

    /// Whether nothing that is left could change the answer: the surfaces meet at the start.
    pub fn is_decided(&self) -> bool {
        self.contact.is_some_and(|contact| contact.time <= 0.0)
    }

    pub fn touch(&mut self, contact: Contact) {
        if self.contact.is_none_or(|known| contact.time < known.time) {
            self.contact = Some(contact);
        }
    }

    /// Takes note that triangles that do not meet before this time are done with.
    #[inline(always)]
    pub fn pass(&mut self, time: f64) {
        self.done = self.done.min(time);
    }

    /// Takes note that all pieces are done.
    pub fn end(&mut self) {
        self.free_until = self.free_until.max(self.done.min(1.0));
    }

    /// Takes note of what is proven when so much of a piece is left; of the node pair at hand, if
    /// there is one, `at_hand`.
    pub(super) fn bound(&mut self, front: &Front, search: &Search, piece: &Piece, at_hand: f32) {
        let nodes = match front.least_bucket() {
            None => f32::INFINITY,
            Some(bucket) => least_key(bucket),
        };
        let waiting = search.waiting.iter().map(|left| left.key);
        let pairs = waiting.chain(search.proposed.iter().map(|left| left.low));
        let left = piece.time(pairs.fold(nodes.min(at_hand), f32::min));
        let followed = self
            .followed
            .as_ref()
            .map_or(f64::INFINITY, |followed| followed.from);
        self.free_until = self.free_until.max(left.min(followed).min(self.done));
    }
}

/// The bucket of a time in lengths of the piece: the first one is for what may meet at its begin.
pub(super) fn bucket(key: f32) -> usize {
    let steps = (key + 0.5) * (BUCKETS - 2) as f32;
    // Conversions to `i32` take fewer instructions than those to `usize`.
    1 + (steps as i32).clamp(0, BUCKETS as i32 - 2) as usize
}

/// The least time of a bucket.
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
