//! Orders the pairs by their learned chance of contact per cost.
//!
//! The order decides which contact is found first and how fast, never whether there is one.

use crate::world::World;

/// What is known of a pair whose spheres met.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Fact {
    pub asked: u64,
    pub met: u64,
    pub work: u64,
}

impl Fact {
    pub fn add(&mut self, other: &Self) {
        self.asked += other.asked;
        self.met += other.met;
        self.work += other.work;
    }

    /// Chance of contact per unit of work. The prior is .02 contacts in one test. The work includes
    /// placing the pair and testing its boxes.
    fn chance(&self) -> f64 {
        let asked = self.asked as f64 + 1.0;
        let chance = (self.met as f64 + 0.02) / asked;
        chance / (self.work as f64 / asked + BOX_WORK as f64)
    }
}

/// Work of a test of two boxes, in units of a query's work.
pub(crate) const BOX_WORK: u64 = 100;

/// Largest and least number of configurations between two sorts.
const LONGEST: u64 = 1 << 14;
const SHORTEST: u64 = 32;

/// The pairs in the order in which they are tested.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sorted {
    pub pairs: Vec<u32>,
    /// The place of the pair of each slot in this order, `u32::MAX` where there is none.
    pub ranks: Vec<u32>,
}

/// The order, with what was learned.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// Its ranks are valid after [`Order::count`].
    pub sorted: Sorted,
    pub facts: Vec<Fact>,
    is_ranked: bool,
    /// Room to sort in.
    keys: Vec<u64>,
    /// Number of configurations seen, and the number at which the pairs are sorted next.
    seen: u64,
    due: u64,
}

impl Order {
    pub fn new(world: &World) -> Self {
        let mut order = Self {
            due: SHORTEST,
            ..Self::default()
        };
        order.extend(world);
        order
    }

    /// Takes over the pairs that were added behind the known ones.
    pub fn extend(&mut self, world: &World) {
        let (known, now) = (self.facts.len() as u32, world.pairs.len());
        self.sorted.pairs.extend(known..now as u32);
        self.facts.resize(now, Fact::default());
        self.keys.clear();
        self.keys.reserve(now);
        self.is_ranked = false;
    }

    /// Takes over the new numbers of the pairs, `u32::MAX` for one that is gone.
    pub fn keep(&mut self, numbers: &[u32]) {
        self.sorted.pairs.retain_mut(|pair| {
            *pair = numbers[*pair as usize];
            *pair != u32::MAX
        });
        self.is_ranked = false;
        let mut kept = numbers.iter().map(|&number| number != u32::MAX);
        self.facts.retain(|_| kept.next() == Some(true));
    }

    /// Number of configurations until the next sort.
    pub fn until_due(&self) -> u64 {
        self.due - self.seen
    }

    /// Counts configurations whose facts were added. Sorts the pairs if that is due, and ranks them
    /// if they have changed.
    pub fn count(&mut self, configurations: u64, world: &World) {
        let Sorted { pairs, ranks } = &mut self.sorted;
        self.seen += configurations;
        if self.seen >= self.due {
            self.due = self.seen + self.seen.clamp(SHORTEST, LONGEST);
            // The bits of numbers that are not negative are ordered as the numbers are.
            let key = |pair: &u32| {
                let chance = self.facts[*pair as usize].chance() as f32;
                u64::from(!chance.to_bits()) << 32 | u64::from(*pair)
            };
            self.keys.clear();
            self.keys.extend(pairs.iter().map(key));
            self.keys.sort_unstable();
            pairs.clear();
            pairs.extend(self.keys.iter().map(|&key| key as u32));
            self.is_ranked = false;
        }
        if !self.is_ranked {
            ranks.clear();
            ranks.resize(world.shapes.len() * world.stride(), u32::MAX);
            for (rank, &pair) in (0..).zip(&*pairs) {
                ranks[world.pairs[pair as usize].slot as usize] = rank;
            }
            self.is_ranked = true;
        }
    }
}
