//! The pairs of bodies whose contacts are requested.

use crate::id::{PairKey, bodies_of};
use alloc::collections::BTreeSet;

#[derive(Clone, Debug, Default)]
pub(crate) struct ContactRequests {
    /// True if the contacts of all pairs that meet are requested.
    pub all: bool,
    pub chosen: BTreeSet<PairKey>,
}

impl ContactRequests {
    #[inline]
    pub fn any(&self) -> bool {
        self.all || !self.chosen.is_empty()
    }

    #[inline]
    pub fn has(&self, key: PairKey) -> bool {
        self.all || self.chosen.contains(&key)
    }

    pub fn forget(&mut self, body: u32) {
        self.chosen.retain(|&key| !bodies_of(key).contains(&body));
    }
}
