//! The state of a distance query: triangle pairs that wait, and the bound proven for everything
//! left.

use super::halves::Halves;
use super::interval::Interval;
use crate::engine::frontier::{BUCKETS, Frontier, Pair};
use crate::engine::workspace::Workspace;
use crate::tree::{Tree, WIDTH};
use alloc::boxed::Box;
use arrayvec::ArrayVec;
use punctual_geom::bits;

/// Factor of half extents in a dive, which only guesses.
pub(crate) const DIVE: f32 = 0.4;

/// Maximum number of triangle pairs that are put off; further pairs are tested when they are found.
const PUT_OFF: usize = 1024;

/// A triangle pair (tree order) and the proven lower bound of its distance or time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounded {
    pub pair: [u32; 2],
    /// Distance: its length in A's units. Motion: the time in lengths of the substep, from -1/2.
    pub low: f32,
}

impl Bounded {
    /// A pair of which nothing is known.
    pub const fn unknown(pair: [u32; 2]) -> Self {
        Self { pair, low: 0.0 }
    }
}

/// A triangle pair (tree order) that waits for its first test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waiting {
    pub pair: [u32; 2],
    /// The key of the boxes of both triangles, as for node pairs: in a distance query, a lower
    /// bound of the squared distance.
    pub key: f32,
}

/// The state of a distance query in a workspace.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    pub interval: Interval,
    /// True if a query has begun since the last clearing.
    is_used: bool,
    /// True during the dive.
    pub is_diving: bool,
    /// The node pair at which the dive continues.
    pub dive: Option<Pair>,
    /// Triangle pairs that wait for the `f32` test.
    pub waiting: ArrayVec<Waiting, { WIDTH * (WIDTH + 1) }>,
    /// Pairs that may be the closest according to that test; the last is the most likely.
    pub proposed: ArrayVec<Bounded, WIDTH>,
    pub put_off: Box<ArrayVec<Bounded, PUT_OFF>>,
    /// The least key of pairs that were dropped when they were popped. Its root is computed once,
    /// at the end of a call.
    pub dropped: f32,
    pub halves: Halves,
    /// If a body is lone ([`Lone`](super::lone::Lone)), true if it is A. The pairs of the frontier
    /// are nodes of the other tree, with keys.
    pub lone: Option<bool>,
    /// The number of waiting pairs that are tested together; fewer wait on.
    pub batch: usize,
    /// The upper bits of a key that map to the first bucket.
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
            put_off: Box::default(),
            dropped: f32::INFINITY,
            halves: Halves::NEVER,
            lone: None,
            batch: WIDTH,
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
        (self.lone, self.batch) = (None, WIDTH);
        self.dropped = f32::INFINITY;
        self.drop_all();
    }

    /// Drops the dive and all pairs.
    pub fn drop_all(&mut self) {
        (self.is_diving, self.dive) = (false, None);
        self.waiting.clear();
        self.proposed.clear();
        self.put_off.clear();
    }

    /// Starts a query with a triangle pair that is probably close, or else with a dive.
    pub fn begin(&mut self, interval: Interval, guess: Option<[u32; 2]>) {
        (self.interval, self.is_used) = (interval, true);
        match guess {
            Some(pair) => self.proposed.push(Bounded::unknown(pair)),
            // With a limit there is already an upper bound to compare with.
            None if interval.has_limit() => {}
            None => (self.is_diving, self.dive) = (true, Some(Pair::new(0, 0))),
        }
    }

    /// Searches beside a lone body. It needs no dive, because its first nodes are opened as in a
    /// dive. The triangles of a leaf are tested at once.
    pub fn beside(&mut self, is_a: bool) {
        (self.lone, self.batch) = (Some(is_a), 1);
        (self.is_diving, self.dive) = (false, None);
    }

    /// A pair of the frontier as nodes of both trees.
    pub fn nodes(&self, pair: Pair) -> Pair {
        match self.lone {
            Some(true) => Pair::new(0, pair.nodes[0]),
            Some(false) => Pair::new(pair.nodes[0], 0),
            None => pair,
        }
    }

    /// Starts a query with a triangle pair, if one is known, and without a dive.
    pub fn begin_pairs(&mut self, known: Option<Bounded>) {
        self.clear();
        self.is_used = true;
        self.proposed.extend(known);
    }

    /// The pass for a separating plane of a query without a distance.
    pub fn halves(&mut self, [a, b]: [&Tree; 2]) -> &mut Halves {
        if !self.is_used {
            (self.halves, self.is_used) = (Halves::of(a, b), true);
        }
        &mut self.halves
    }

    /// Adds the triangle pairs `first + [i, j]` for the bits `8 i + j` of `hits`, to wait for the
    /// `f32` test.
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

    /// Takes up to eight waiting pairs with keys below `cut`. Returns the pairs, their keys and
    /// their number; the first pair fills the other lanes. Pairs with larger keys are removed, and
    /// their keys go to `dropped`.
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

    /// True if enough triangle pairs wait for a batch.
    #[inline(always)]
    pub fn is_due(&self) -> bool {
        !self.proposed.is_empty() || self.waiting.len() >= self.batch
    }

    /// True if no dive and no triangle pair is left.
    pub fn is_done(&self) -> bool {
        !self.is_diving && self.pairs().next().is_none()
    }

    /// All triangle pairs that are left.
    pub fn pairs(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let bounded = self.proposed.iter().chain(&*self.put_off);
        let waiting = self.waiting.iter().map(|left| left.pair);
        waiting.chain(bounded.map(|left| left.pair))
    }

    /// Raises the lower bound of the interval from everything that is left. `current` is the bound
    /// of the current node pair, if there is one. `unit` is the length of A's unit.
    pub fn bound(&mut self, frontier: &Frontier, current: f32, unit: f64) {
        let nodes = match frontier.least_bucket() {
            _ if self.is_diving => 0.0,
            _ if self.lone.is_some() => {
                let keys = frontier.stack().map(|pair| pair.key());
                root(keys.fold(f32::INFINITY, f32::min))
            }
            None => f32::INFINITY,
            Some(bucket) => root(self.least_key(bucket)),
        };
        // Set also for an empty mesh, for which no query was started.
        self.is_used = true;
        let waiting = self.waiting.iter().map(|left| root(left.key));
        let others = self.proposed.iter().chain(&*self.put_off);
        let others = others.map(|left| left.low);
        // Waiting pairs will be refined, so bounds rounded to `f32` suffice for them. Dropped pairs
        // keep their bound, which must not fall below the cut by rounding.
        let dropped = libm::sqrt(f64::from(self.dropped)) * (1.0 - f64::EPSILON);
        self.interval.raise(
            f64::from(waiting.chain(others).fold(nodes.min(current), f32::min)).min(dropped) * unit,
        );
    }

    /// The bucket of a key: eight for each factor of two, so that bounds differ by 4 to 6 percent.
    /// The last but one holds the first upper bound.
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

/// Lower bits of a key that do not affect its bucket.
const BUCKET_BITS: u32 = 20;

/// The distance of a key, rounded down.
pub(crate) fn root(key: f32) -> f32 {
    libm::sqrtf(key.max(0.0)) * (1.0 - f32::EPSILON)
}

impl Workspace {
    /// [`Search::bound`] of the distance query.
    pub(crate) fn bound(&mut self, current: f32, unit: f64) {
        self.state.distance.bound(&self.frontier, current, unit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use punctual_geom::random::Random;
    use punctual_geom::triangle::distance::Closest;

    /// Without a tolerance, a search ends when everything left was dropped. Then both bounds are
    /// equal, because none is below the cut.
    #[test]
    fn what_was_dropped_at_the_cut_is_no_closer_than_that() {
        let mut random = Random::new(1);
        for _ in 0..1000 {
            let (high, unit) = (
                random.between(1e-3, 1e3),
                f64::exp2(random.between(-9.0, 9.0).floor()),
            );
            let mut search = Search::new();
            search.interval = Interval::nothing();
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
            search.bound(&Frontier::new(1), f32::INFINITY, unit);
            assert_eq!(search.interval.low(), high);
        }
    }
}
