//! The pairs of bodies whose distances are asked for.

use crate::scene::id::{PairKey, bodies_of};
use alloc::vec::Vec;

/// Ascending, each with its tolerance.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measured(Vec<(PairKey, f64)>);

impl Measured {
    fn place(&self, key: PairKey) -> Result<usize, usize> {
        self.0.binary_search_by_key(&key, |&(key, _)| key)
    }

    /// The tolerance of a pair, if it is one of them.
    pub fn tolerance(&self, key: PairKey) -> Option<f64> {
        self.place(key).ok().map(|at| self.0[at].1)
    }

    pub fn insert(&mut self, key: PairKey, tolerance: f64) {
        match self.place(key) {
            Ok(at) => self.0[at].1 = tolerance,
            Err(at) => self.0.insert(at, (key, tolerance)),
        }
    }

    pub fn remove(&mut self, key: PairKey) {
        if let Ok(at) = self.place(key) {
            self.0.remove(at);
        }
    }

    /// Forgets a body.
    pub fn forget(&mut self, body: u32) {
        self.0.retain(|&(key, _)| !bodies_of(key).contains(&body));
    }

    /// Whether a body is in one of them.
    pub fn has(&self, body: u32) -> bool {
        self.keys().any(|key| bodies_of(key).contains(&body))
    }

    pub fn keys(&self) -> impl ExactSizeIterator<Item = PairKey> {
        self.0.iter().map(|&(key, _)| key)
    }
}
