//! What a question about the points near a surface keeps in the workspace.

use crate::engine::workspace::Workspace;
use crate::room::Room;
use alloc::vec::Vec;
use punctual_geom::bits;

/// Room that the first query reserves in a workspace without any.
const DEFAULT_ROOM: usize = 4096;

/// The points found, and marks of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct NearPoints {
    /// Ids, in order of discovery.
    found: Room<u32>,
    /// Of each block, the points that were found.
    pub marks: Vec<u8>,
    /// The blocks with marks.
    marked: Room<u32>,
    limit: usize,
}

impl NearPoints {
    /// Removes all points and marks, in time linear in the marked blocks.
    pub fn clear(&mut self) {
        self.found.clear();
        for block in self.marked.drain(..) {
            self.marks[block as usize] = 0;
        }
    }

    /// Prepares for a cloud of this many blocks.
    pub fn begin(&mut self, blocks: usize, limit: usize) {
        self.limit = limit;
        if self.found.capacity() == 0 {
            self.found.reserve_all(DEFAULT_ROOM);
        }
        if self.marks.len() < blocks {
            self.marks.resize(blocks, 0);
            self.marked.reserve_all(blocks);
        }
    }

    /// Number of points that can be added.
    pub fn room(&self) -> usize {
        let most = self.limit.min(self.found.capacity());
        most.saturating_sub(self.found.len())
    }

    /// Marks points of a block that have no mark, and lists them.
    #[inline(always)]
    pub fn mark(&mut self, block: usize, points: u8, id: impl Fn(usize) -> u32) {
        if self.marks[block] == 0 {
            self.marked.push(block as u32);
        }
        self.marks[block] |= points;
        self.found.extend(bits(points).map(id));
    }
}

impl Workspace {
    /// The points that the last query found, if it was [`crate::Query::points_within`], without
    /// drained ones: ids of the cloud, in order of discovery.
    pub fn near_points(&self) -> &[u32] {
        &self.state.near_points.found
    }

    /// Removes and returns these points, so that a query stopped with
    /// [`crate::StopReason::PairsFull`] can be resumed.
    pub fn drain_near_points(&mut self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.state.near_points.found.drain(..)
    }

    /// Reserves room for at least this many points of [`crate::Query::points_within`]. If there is
    /// no room at all, the first query reserves room for 4,096. After more room is reserved, a
    /// query stopped with [`crate::StopReason::PairsFull`] can be resumed without draining.
    pub fn reserve_near_points(&mut self, points: usize) {
        self.state.near_points.found.reserve_all(points);
    }
}
