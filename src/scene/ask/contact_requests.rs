//! The pairs of bodies whose contacts are asked for.

use crate::scene::id::{PairKey, bodies_of};
use alloc::vec::Vec;

#[derive(Clone, Debug, Default)]
pub(crate) struct ContactRequests {
    /// Whether all that meet are.
    pub all: bool,
    /// Others, ascending.
    chosen: Vec<PairKey>,
}

impl ContactRequests {
    #[inline]
    pub fn any(&self) -> bool {
        self.all || !self.chosen.is_empty()
    }

    #[inline]
    pub fn has(&self, key: PairKey) -> bool {
        self.all || self.chosen.binary_search(&key).is_ok()
    }

    pub fn insert(&mut self, key: PairKey) {
        if let Err(at) = self.chosen.binary_search(&key) {
            self.chosen.insert(at, key);
        }
    }

    pub fn remove(&mut self, key: PairKey) {
        if let Ok(at) = self.chosen.binary_search(&key) {
            self.chosen.remove(at);
        }
    }

    pub fn forget(&mut self, body: u32) {
        self.chosen.retain(|&key| !bodies_of(key).contains(&body));
    }
}
