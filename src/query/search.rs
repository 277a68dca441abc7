//! The state of a distance query: triangle pairs that wait, and what is proven of all that is left.

use super::boxes::Keys;
use super::halves::Halves;
use super::interval::Interval;
use super::queue::{BUCKETS, Front, Pair};
use crate::math::bits;
use crate::tree::WIDTH;
use crate::triangle::distance::Features;
use alloc::boxed::Box;
use arrayvec::ArrayVec;

/// Factor of half extents with which a dive guesses.
pub(super) const DIVE: f32 = 0.4;

/// Most triangle pairs that are put off; the others are tested when they are met.
const PUT_OFF: usize = 1024;

/// A triangle pair (tree order) and what is proven of its distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounded {
    pub pair: [u32; 2],
    /// A's units; of a motion, a time.
    pub low: f32,
    /// The features that this test found closest.
    pub closest: Features,
}

impl Bounded {
    /// A pair of which nothing is known.
    pub const fn unknown(pair: [u32; 2]) -> Self {
        Self {
            pair,
            low: 0.0,
            closest: Features::ANY,
        }
    }
}

/// A triangle pair (tree order) that waits for its first test.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waiting {
    pub pair: [u32; 2],
    /// That of its boxes, as node pairs have one: of a distance, its square.
    pub key: f32,
}

/// Pairs whose closest points are computed together.
pub(super) const TOGETHER: usize = 4;

/// The state of a distance query in a workspace.
#[derive(Clone, Debug)]
pub(super) struct Search {
    pub interval: Interval,
    /// Whether a query has begun since all was cleared.
    is_used: bool,
    /// Whether it has only dived so far.
    pub is_diving: bool,
    /// Where the dive goes on.
    pub dive: Option<Pair>,
    /// Triangle pairs that wait for the `f32` test.
    pub waiting: ArrayVec<Waiting, { WIDTH * (WIDTH + 1) }>,
    /// Pairs that may be the closest after that test; the most likely is the last.
    pub proposed: ArrayVec<Bounded, WIDTH>,
    /// Pairs within the margin of a contact query, until there are enough.
    pub linked: ArrayVec<Bounded, { TOGETHER + WIDTH }>,
    pub put_off: Box<ArrayVec<Bounded, PUT_OFF>>,
    /// The least key of pairs that were dropped when their turn came. Its root is taken once, at
    /// the end of a call.
    pub dropped: f32,
    pub halves: Halves,
    /// The bits of a key that make the first bucket.
    first_bucket: Option<u32>,
}

impl Search {
    pub fn new() -> Self {
        Self {
            interval: Interval::nothing(),
            is_used: false,
            is_diving: false,
            dive: None,
            waiting: ArrayVec::new_const(),
            proposed: ArrayVec::new_const(),
            linked: ArrayVec::new_const(),
            put_off: Box::default(),
            dropped: f32::INFINITY,
            halves: Halves::NEVER,
            first_bucket: None,
        }
    }

    pub fn clear(&mut self) {
        if !self.is_used {
            return;
        }
        self.is_used = false;
        (self.interval, self.halves, self.first_bucket) =
            (Interval::nothing(), Halves::NEVER, None);
        self.dropped = f32::INFINITY;
        self.drop_all();
    }

    /// Drops the dive and all pairs.
    pub fn drop_all(&mut self) {
        (self.is_diving, self.dive) = (false, None);
        self.waiting.clear();
        self.proposed.clear();
        self.linked.clear();
        self.put_off.clear();
    }

    /// Begins with a triangle pair that is likely to be close, or else with a dive.
    pub fn begin(&mut self, interval: Interval, guess: Option<[u32; 2]>) {
        (self.interval, self.is_used) = (interval, true);
        match guess {
            Some(pair) => self.proposed.push(Bounded::unknown(pair)),
            // With a limit there is something to compare with already.
            None if interval.has_limit() => {}
            None => (self.is_diving, self.dive) = (true, Some(Pair::new(0, 0))),
        }
    }

    /// Begins with a triangle pair, if one is known, and without a dive.
    pub fn begin_pairs(&mut self, known: Option<Bounded>) {
        self.clear();
        self.is_used = true;
        self.proposed.extend(known);
    }

    /// Triangle pairs `first + [i, j]` for the bits `8 i + j` of `hits` wait for the `f32` test.
    #[inline(always)]
    pub fn wait(&mut self, hits: u64, first: [u32; 2], key: impl Fn(usize) -> f32) {
        for bit in bits(hits) {
            let pair = [first[0] + bit as u32 / 8, first[1] + bit as u32 % 8];
            self.waiting.push(Waiting {
                pair,
                key: key(bit),
            });
        }
    }

    /// Up to eight waiting pairs with keys below `cut`, these keys, and how many they are; the
    /// first pair fills the places left. The keys of the others go to `dropped`.
    #[inline(always)]
    pub fn pop_batch(
        &mut self,
        cut: f32,
        mut dropped: impl FnMut(f32),
    ) -> ([[u32; 2]; WIDTH], [f32; WIDTH], usize) {
        let (mut pairs, mut keys) = ([[0; 2]; WIDTH], [0.0; WIDTH]);
        let mut count = 0;
        while count < WIDTH
            && let Some(left) = self.waiting.pop()
        {
            if left.key < cut {
                (pairs[count], keys[count]) = (left.pair, left.key);
                count += 1;
            } else {
                dropped(left.key);
            }
        }
        for i in count..WIDTH {
            pairs[i] = pairs[0];
        }
        (pairs, keys, count)
    }

    /// Whether enough triangle pairs wait for a test to be worth a batch.
    #[inline(always)]
    pub fn is_due(&self) -> bool {
        !self.proposed.is_empty() || self.waiting.len() >= WIDTH || self.linked.len() >= TOGETHER
    }

    /// Whether closest points should be computed next.
    #[inline(always)]
    pub fn is_linked(&self) -> bool {
        self.linked.len() >= TOGETHER || !self.linked.is_empty() && self.waiting.is_empty()
    }

    /// Whether no dive and no triangle pair is left.
    pub fn is_done(&self) -> bool {
        !self.is_diving && self.pairs().next().is_none()
    }

    /// All triangle pairs that are left.
    pub fn pairs(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let bounded = self
            .proposed
            .iter()
            .chain(&*self.put_off)
            .chain(&self.linked);
        let waiting = self.waiting.iter().map(|left| left.pair);
        waiting.chain(bounded.map(|left| left.pair))
    }

    /// Tells the interval what is proven of all pairs that are left, with A's unit of this length;
    /// of the pair at hand, if there is one, `at_hand`.
    pub fn bound(&mut self, front: &Front, at_hand: f32, unit: f64) {
        let nodes = match front.least_bucket() {
            _ if self.is_diving => 0.0,
            None => f32::INFINITY,
            Some(bucket) => root(self.least_key(bucket)),
        };
        // Also for an empty mesh, where nothing was begun.
        self.is_used = true;
        let waiting = self.waiting.iter().map(|left| root(left.key));
        let others = self
            .proposed
            .iter()
            .chain(&*self.put_off)
            .chain(&self.linked)
            .map(|left| left.low);
        // Of pairs that are left there is more to come. Those that were dropped stay what they are,
        // no closer than the cut: so their root is not rounded to `f32`.
        let dropped = libm::sqrt(f64::from(self.dropped)) * (1.0 - f64::EPSILON);
        self.interval.raise(
            f64::from(waiting.chain(others).fold(nodes.min(at_hand), f32::min)).min(dropped) * unit,
        );
    }

    /// The bucket of a key: eight for each factor of two, so that bounds differ by 4 to 6 percent.
    /// The last but few hold what is as far as the first upper bound.
    pub fn bucket(&mut self, key: f32, cut: f32) -> usize {
        let bits = key.to_bits() >> BUCKET_BITS;
        let first = *self
            .first_bucket
            .get_or_insert((cut.to_bits() >> BUCKET_BITS).saturating_sub(BUCKETS as u32 - 2));
        (bits.saturating_sub(first) as usize).min(BUCKETS - 1)
    }

    fn least_key(&self, bucket: usize) -> f32 {
        let first = self.first_bucket.unwrap_or(0);
        if bucket == 0 {
            0.0
        } else {
            f32::from_bits((first + bucket as u32) << BUCKET_BITS)
        }
    }
}

/// Bits of a key that do not matter for its bucket.
const BUCKET_BITS: u32 = 20;

/// The least key of a column, the triangles of a cluster that are of interest with one child.
#[inline(always)]
pub(super) fn least_key(keys: &Keys, pair: &Pair, column: usize) -> f32 {
    let alive = pair.alive[0] & pair.alive[1];
    let least = (0..WIDTH)
        .filter(|row| alive >> row & 1 != 0)
        .map(|row| keys[row][column]);
    least.fold(f32::INFINITY, f32::min)
}

/// The distance that a key stands for, rounded down.
pub(super) fn root(key: f32) -> f32 {
    libm::sqrtf(key.max(0.0)) * (1.0 - f32::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use crate::query::interval::Tolerance;
    use crate::triangle::distance::Closest;
    use glam::DVec3;

    /// With no tolerance a search ends when all that is left was dropped: then both bounds are one,
    /// as none is below the cut.
    #[test]
    fn what_was_dropped_at_the_cut_is_no_closer_than_that() {
        let mut random = Random::new(1);
        for _ in 0..1000 {
            let (high, unit) = (
                random.between(1e-3, 1e3),
                f64::exp2(random.between(-9.0, 9.0).floor()),
            );
            let mut search = Search::new();
            search.interval = Interval::new(
                Tolerance {
                    absolute: 0.0,
                    relative: 0.0,
                },
                0.0,
                f64::INFINITY,
            );
            let points = [DVec3::ZERO, DVec3::X * high];
            search.interval.settle(
                [0; 2],
                &Closest {
                    points,
                    direction: -DVec3::X,
                    low: high,
                    high,
                    is_tight: true,
                },
            );
            search.dropped = search.interval.square_cut(unit);
            search.bound(&Front::new(1), f32::INFINITY, unit);
            assert_eq!(search.interval.low(), high);
        }
    }
}
