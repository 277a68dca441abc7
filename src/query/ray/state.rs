//! The state of a ray query: what was asked, which ray of a batch is its turn, and what it has hit.

use super::beam::Beam;
use crate::math::Ray;
use crate::names::named;
use crate::triangle::ray::Side;
use alloc::vec::Vec;
use arrayvec::ArrayVec;

/// Which of its hits a ray is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RayMode {
    /// The one with the least `t`; of several with the same, the triangle with the least id.
    #[default]
    Nearest,
    /// Any: whether there is one. Stops at the first that is found.
    Any,
    /// All, each triangle once.
    All,
}

impl RayMode {
    /// A parameter of the ray before which there is no hit that was not found; `open`: the same of
    /// what is not looked at yet.
    pub(crate) fn free_until(self, ray: &Ray, hit: Option<RayHit>, open: f64) -> f64 {
        match (self, hit) {
            (Self::All, _) | (_, None) => open,
            (Self::Nearest, Some(hit)) => open.min(hit.t),
            (Self::Any, Some(_)) => ray.limits()[0],
        }
    }
}

named!(Side { Front => "front", Back => "back", Edge => "edge" });
named!(RayMode { Nearest => "nearest", Any => "any", All => "all" });

/// A triangle that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct RayHit {
    /// Id of the input mesh.
    pub triangle: u32,
    /// The least parameter of a common point, which is `origin + t direction` ([`Ray::at`]). It is
    /// off by no more than 1e-11 times the largest coordinate of the triangle seen from the origin,
    /// over the largest component of the direction; never negative, of a segment at most 1, and
    /// infinite beyond the range of `f64`.
    #[cfg_attr(feature = "serde", serde(with = "crate::math::bound"))]
    pub t: f64,
    /// The side that the ray comes from.
    pub side: Side,
}

impl RayHit {
    /// By `t`, then by id: a total order.
    pub(super) fn is_before(&self, other: &Self) -> bool {
        self.t < other.t || self.t == other.t && self.triangle < other.triangle
    }
}

/// A triangle (tree order) that `f32` could not exclude, and where the ray enters its box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Suspect {
    pub triangle: u32,
    pub enter: f32,
    /// On which side the line passes all three edges, where `f32` is certain of that.
    pub faces: Option<i8>,
}

/// What a ray query keeps in its workspace.
#[derive(Clone, Debug)]
pub(crate) struct RayState {
    pub mode: RayMode,
    /// The ray at hand where a run was stopped, and how many of the batch are done, or come after
    /// it.
    pub ray: Option<Ray>,
    pub done: usize,
    pub after: usize,
    /// The first hit of the ray at hand, in the mode's sense.
    pub hit: Option<RayHit>,
    pub suspects: ArrayVec<Suspect, 8>,
    /// The ray at hand in the unit coordinates of the tree.
    pub beam: Beam,
    /// Those of [`RayMode::All`], in order of discovery.
    pub hits: Vec<RayHit>,
    /// Those of a batch, one for each ray.
    pub first_hits: Vec<Option<RayHit>>,
}

impl Default for RayState {
    fn default() -> Self {
        Self {
            mode: RayMode::default(),
            ray: None,
            done: 0,
            after: 0,
            hit: None,
            suspects: ArrayVec::new(),
            beam: Beam::BLIND,
            hits: Vec::new(),
            first_hits: Vec::new(),
        }
    }
}

impl RayState {
    #[inline(always)]
    pub fn clear(&mut self) {
        self.ray = None;
        self.hit = None;
        self.done = 0;
        self.after = 0;
        self.suspects.clear();
        self.hits.clear();
        self.first_hits.clear();
    }

    pub fn reserve(&mut self, hits: usize) {
        self.hits
            .reserve_exact(hits.saturating_sub(self.hits.len()));
    }
}
