//! Two groups of bodies whose least distance is asked for, as a frame begins with them.

use crate::scene::id::{MeasureId, PairKey};
use crate::scene::pair::bounds::Bounds;

#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// None: it is asked for no more.
    pub id: Option<MeasureId>,
    /// How many pairs of bodies there are.
    pub pairs: usize,
    /// The closest pair that was found, and what was proven of it, in which frame.
    pub closest: Option<(PairKey, Bounds, u64)>,
    /// Proven for the frame at hand before any query: the groups are no farther apart.
    pub ceiling: f64,
}

impl Group {
    pub const FREE: Self = Self { id: None, pairs: 0, closest: None, ceiling: f64::INFINITY };

    pub fn forget(&mut self, key: PairKey) {
        self.pairs -= 1;
        self.closest = self.closest.filter(|&(closest, ..)| closest != key);
    }
}
