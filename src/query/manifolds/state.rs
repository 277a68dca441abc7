//! What a query for manifolds keeps in its workspace.

use super::manifold::Manifold;
use super::overlaps::{Overlaps, Reduction};
use crate::engine::workspace::Workspace;
use alloc::vec::Vec;

/// The state of a query for manifolds in its workspace.
#[derive(Clone, Debug, Default)]
pub(crate) struct ManifoldState {
    pub reduction: Reduction,
    pub overlaps: Overlaps,
    pub list: Vec<Manifold>,
}

impl ManifoldState {
    #[inline(always)]
    pub fn clear(&mut self) {
        self.reduction.clear();
        self.list.clear();
    }
}

impl Workspace {
    /// The manifolds of the last query, if it was [one](crate::Query::manifolds), the deepest
    /// first. Those of a stopped query are incomplete.
    pub fn manifolds(&self) -> &[Manifold] {
        &self.state.manifolds.list
    }

    /// Reserves room for the manifolds of meshes of at most this many triangles and vertices, with
    /// at most `pairs` pairs of triangles that intersect: 4 bytes for each triangle, 36 for each
    /// vertex, and about 1.9 kB for each pair.
    pub fn reserve_manifolds(&mut self, pairs: usize, triangles: usize, vertices: usize) {
        self.reserve_contacts(pairs);
        self.state.manifolds.reduction.skin.reserve();
        self.state
            .manifolds
            .overlaps
            .reserve_for(pairs, [triangles, vertices]);
        let room = pairs.saturating_sub(self.state.manifolds.list.len());
        self.state.manifolds.list.reserve(room);
    }
}
