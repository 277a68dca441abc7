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

/// The pairs in the order in which they are tested, with what was learned.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    pub pairs: Vec<u32>,
    pub facts: Vec<Fact>,
    /// Number of configurations seen, and the number at which the pairs are sorted next.
    seen: u64,
    due: u64,
}

impl Order {
    pub fn new(world: &World) -> Self {
        Self {
            pairs: (0..world.pairs.len() as u32).collect(),
            facts: vec![Fact::default(); world.pairs.len()],
            seen: 0,
            due: SHORTEST,
        }
    }

    /// Takes over the pairs that were added behind the known ones.
    pub fn extend(&mut self, world: &World) {
        let (known, now) = (self.pairs.len() as u32, world.pairs.len());
        self.pairs.extend(known..now as u32);
        self.facts.resize(now, Fact::default());
    }

    /// Takes over the new numbers of the pairs, `u32::MAX` for one that is gone.
    pub fn keep(&mut self, numbers: &[u32]) {
        self.pairs.retain_mut(|pair| {
            *pair = numbers[*pair as usize];
            *pair != u32::MAX
        });
        let mut kept = numbers.iter().map(|&number| number != u32::MAX);
        self.facts.retain(|_| kept.next() == Some(true));
    }

    /// Number of configurations until the next sort.
    pub fn until_due(&self) -> u64 {
        self.due - self.seen
    }

    /// Counts configurations whose facts were added, and sorts the pairs if that is due.
    pub fn count(&mut self, configurations: u64) {
        self.seen += configurations;
        if self.seen >= self.due {
            self.due = self.seen + self.seen.clamp(SHORTEST, LONGEST);
            let chance = |&pair: &u32| self.facts[pair as usize].chance();
            self.pairs
                .sort_unstable_by(|p, q| chance(q).total_cmp(&chance(p)).then(p.cmp(q)));
        }
    }
}
