//! The pairs of bodies whose contacts are requested.

use crate::filter::Filter;
use crate::id::{PairKey, bodies_of};
use alloc::collections::BTreeSet;
use smallvec::SmallVec;

#[derive(Clone, Debug, Default)]
pub(crate) struct ContactRequests {
    /// Requests by filter: pairs of which one body is in the groups of a filter, and the other in
    /// its mask.
    pub between: SmallVec<[Filter; 4]>,
    pub chosen: BTreeSet<PairKey>,
    /// Distance up to which pairs without contacts are measured.
    pub look_ahead: f64,
}

impl ContactRequests {
    #[inline]
    pub fn any(&self) -> bool {
        !self.between.is_empty() || !self.chosen.is_empty()
    }

    /// True if the contacts of pairs with these filters are requested.
    pub fn has(&self, pair: [Filter; 2]) -> bool {
        let [x, y] = pair.map(|filter| filter.groups);
        let has = |&Filter { groups, mask }: &Filter| {
            x & groups != 0 && y & mask != 0 || y & groups != 0 && x & mask != 0
        };
        self.between.iter().any(has)
    }

    pub fn forget(&mut self, body: u32) {
        self.chosen.retain(|&key| !bodies_of(key).contains(&body));
    }
}
