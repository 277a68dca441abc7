//! The state of a ray query: its options, the current ray of a batch, and the hits.

use crate::engine::workspace::Workspace;
use crate::room::Room;
use crate::tree::solid::local_ray::LocalRay;
use arrayvec::ArrayVec;
use punctual_geom::Ray;
use punctual_geom::named;
use punctual_geom::triangle::ray::Side;

/// Selects which hits of a ray a query searches for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RayMode {
    /// The hit with the least `t`; of several with equal `t`, the triangle with the least id.
    #[default]
    Nearest,
    /// Any hit. Stops at the first hit found.
    Any,
    /// All hits, each triangle once.
    All,
}

impl RayMode {
    /// Ray parameter before which no hit is missing. `open` is that parameter for the nodes and
    /// triangles not tested yet.
    pub fn free_until(self, ray: &Ray, hit: Option<RayHit>, open: f64) -> f64 {
        match (self, hit) {
            (Self::All, _) | (_, None) => open,
            (Self::Nearest, Some(hit)) => open.min(hit.t),
            (Self::Any, Some(_)) => ray.limits()[0],
        }
    }
}

named!(RayMode { Nearest => "nearest", Any => "any", All => "all" });

/// A triangle that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct RayHit {
    /// Id of the triangle in the input mesh.
    pub triangle: u32,
    /// The least parameter of a common point, which is `origin + t direction` ([`Ray::at`]). Its
    /// error is at most 1e-11 times the largest coordinate of the triangle relative to the origin,
    /// over the largest component of the direction. It is never negative, at most 1 for a segment,
    /// and infinite beyond the range of `f64`.
    ///
    /// Of a tree with a [radius](crate::Tree::with_radius), the ray enters the thickened triangle
    /// here: it exactly enters one whose radius differs by at most 1e-12 times the sum of that
    /// coordinate and the radius. 0 if the ray starts within.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub t: f64,
    /// The side of the triangle that the ray comes from.
    pub side: Side,
}

impl RayHit {
    /// By `t`, then by id: a total order.
    pub(super) fn is_before(&self, other: &Self) -> bool {
        self.t < other.t || self.t == other.t && self.triangle < other.triangle
    }
}

/// A triangle (tree order) that `f32` could not exclude, and the parameter at which the ray enters
/// its box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub triangle: u32,
    pub enter: f32,
    /// The side on which the line passes all three edges, if `f32` is certain of it.
    pub faces: Option<i8>,
    /// Length along the path of a ball before which it does not touch the triangle.
    pub free_until: f64,
}

/// The state of a ray query in its workspace.
#[derive(Clone, Debug, Default)]
pub(crate) struct RayState {
    pub mode: RayMode,
    /// The radius of the surface.
    pub radius: f64,
    /// True until it is known whether the ray starts inside, if that is asked.
    pub locates: bool,
    /// The current ray of a stopped run; the last of a finished one.
    pub ray: Option<Ray>,
    /// Numbers of rays of the batch before the current one and after it.
    pub done: usize,
    pub after: usize,
    /// The best hit of the current ray so far.
    pub hit: Option<RayHit>,
    pub candidates: ArrayVec<Candidate, 8>,
    /// The current ray in the unit coordinates of the tree.
    pub local_ray: LocalRay,
    /// The hits of [`RayMode::All`], in order of discovery.
    pub hits: Room<RayHit>,
    /// The hits of a batch, one for each ray done.
    pub first_hits: Room<Option<RayHit>>,
}

impl RayState {
    #[inline(always)]
    pub fn clear(&mut self) {
        self.locates = false;
        self.radius = 0.0;
        self.ray = None;
        self.hit = None;
        self.done = 0;
        self.after = 0;
        self.candidates.clear();
        self.hits.clear();
        self.first_hits.clear();
    }
}

impl Workspace {
    /// The hits that the last query found, if it asked for all hits of a ray, without drained ones:
    /// in order of discovery, which is nearly that of `t`.
    pub fn ray_hits(&self) -> &[RayHit] {
        &self.state.rays.hits
    }

    /// The hits that the last query found, if it was one of many rays
    /// ([`Query::rays`](crate::Query::rays)): one for each ray done, in the order of the rays.
    /// `None` for a ray without a hit.
    pub fn first_hits(&self) -> &[Option<RayHit>] {
        &self.state.rays.first_hits
    }

    /// Removes and returns the hits of a ray, so that a query stopped with
    /// [`crate::StopReason::PairsFull`] can be resumed.
    pub fn drain_ray_hits(&mut self) -> impl ExactSizeIterator<Item = RayHit> + '_ {
        self.state.rays.hits.drain(..)
    }

    /// Reserves room for at least `hits` hits of a ray, 24 bytes each, and for a batch of as many
    /// rays, 32 bytes each. The first query for all hits reserves room for 4,096 if there is none.
    /// The first query for a larger batch of rays reserves room for it.
    pub fn reserve_ray_hits(&mut self, hits: usize) {
        self.state.rays.hits.reserve_all(hits);
        self.state.rays.first_hits.reserve_all(hits);
    }
}
