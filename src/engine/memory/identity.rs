//! Ids of manifolds and their points: a point inherits the id of the nearest point of the frame
//! before, as seen from A or from B.
//!
//! A point that slides stays at its place on one of the bodies; one that rolls moves a little on
//! both. So the nearer of both places counts.

use crate::query::manifolds::manifold::{Manifold, ManifoldPoint};
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual_geom::Pose;

/// The points of the frame before, and those of this one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ManifoldMemory {
    known: Vec<Fixed>,
    now: Vec<Fixed>,
    /// The next id of a point, and of a manifold: before this frame, and after it.
    next: [[u64; 2]; 2],
}

/// A point of a manifold, fixed to both bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixed {
    /// Id of the point.
    pub id: u64,
    /// Id of its manifold.
    pub manifold: u64,
    /// The point on A in A's frame, and the point on B in B's frame.
    pub places: [DVec3; 2],
}

impl Fixed {
    /// The smaller of the distances between the places on A and on B.
    fn distance(&self, other: &Self) -> f64 {
        let apart = |side: usize| (self.places[side] - other.places[side]).length();
        apart(0).min(apart(1))
    }
}

/// Gives each point the id of the nearest of at most 128 points of the frame before, within
/// `reach`. Each manifold gets the id that the manifold of its first point had. In `now`, the
/// points of a manifold follow one another, with its number in place of its id. New ids are
/// `fresh(0)` for points, `fresh(1)` for manifolds. Returns a bit for each point of the frame
/// before whose id was passed on.
pub fn inherit(
    now: &mut [Fixed],
    before: &[Fixed],
    reach: f64,
    mut fresh: impl FnMut(usize) -> u64,
) -> u128 {
    let (mut passed_on, mut last) = (0_u128, None);
    for at in 0..now.len() {
        let (done, rest) = now.split_at_mut(at);
        let point = &mut rest[0];
        let nearest = (0..before.len())
            .filter(|&k| passed_on >> k & 1 == 0)
            .map(|k| (point.distance(&before[k]), k))
            .filter(|(apart, _)| *apart <= reach)
            .min_by(|(x, _), (y, _)| x.total_cmp(y));
        let same = nearest.map(|(_, k)| {
            passed_on |= 1 << k;
            before[k]
        });
        point.id = same.map_or_else(|| fresh(0), |same| same.id);
        let number = point.manifold;
        point.manifold = match last {
            Some((of, id)) if of == number => id,
            _ => {
                let is_free = |id: &u64| done.iter().all(|other| other.manifold != *id);
                let known = same.map(|same| same.manifold).filter(is_free);
                known.unwrap_or_else(|| fresh(1))
            }
        };
        last = Some((number, point.manifold));
    }
    passed_on
}

/// Maximum number of points of a frame that are matched and remembered, the deepest manifolds
/// first. So the match takes bounded time.
const KNOWN: usize = 128;

/// A point inherits an id from within this fraction of the size of the smaller mesh.
const REACH: f64 = 0.05;

/// The points of the frame before, for a query.
#[derive(Clone, Copy)]
pub(crate) struct Before<'m> {
    known: &'m [Fixed],
    /// Maps A's frame to B's.
    pub to_b: &'m Pose,
    reach: f64,
}

impl<'m> Before<'m> {
    /// `to_b` maps A's frame to B's, `size` is that of the smaller mesh.
    pub fn new(memory: Option<&'m ManifoldMemory>, to_b: &'m Pose, size: f64) -> Self {
        Self {
            known: memory.map_or(&[], |memory| &memory.known),
            to_b,
            reach: REACH * size,
        }
    }

    fn seen(&self, point: &ManifoldPoint, manifold: u64) -> Fixed {
        let [on_a, on_b] = point.points;
        Fixed {
            id: 0,
            manifold,
            places: [on_a, self.to_b.transform_point(on_b)],
        }
    }

    /// The mask of the candidates that continue points of the frame before: the nearest to each
    /// point.
    pub fn stay(&self, candidates: &[ManifoldPoint]) -> u32 {
        if self.known.is_empty() {
            return 0;
        }
        let seen: ArrayVec<Fixed, 24> = candidates
            .iter()
            .take(24)
            .map(|point| self.seen(point, 0))
            .collect();
        let nearest = |known: &Fixed| {
            let distances = seen.iter().map(|point| point.distance(known)).enumerate();
            let best = distances.min_by(|(_, x), (_, y)| x.total_cmp(y))?;
            (best.1 <= self.reach).then_some(1 << best.0)
        };
        self.known
            .iter()
            .filter_map(nearest)
            .fold(0, |all, bit| all | bit)
    }
}

impl ManifoldMemory {
    /// Begins a frame: the points assigned last become those of the frame before.
    pub fn begin(&mut self) {
        self.known.clone_from(&self.now);
        self.next[0] = self.next[1];
    }

    /// Gives ids to the points and manifolds, and remembers the points. `to_b` and `size` are those
    /// of [`Before::new`]. Unless all manifolds are known (`is_final`), points that were not found
    /// again are remembered too. May be called again in a frame.
    pub fn assign(&mut self, manifolds: &mut [Manifold], to_b: &Pose, size: f64, is_final: bool) {
        let Self {
            known,
            now,
            next: [first, next],
        } = self;
        let before = Before {
            known,
            to_b,
            reach: REACH * size,
        };
        now.clear();
        for (number, manifold) in (0..).zip(&*manifolds) {
            let points = manifold.points.iter().take(KNOWN - now.len());
            now.extend(points.map(|point| before.seen(point, number)));
        }
        *next = *first;
        let mut fresh = |kind: usize| {
            next[kind] += 1;
            next[kind] - 1
        };
        let passed_on = inherit(now, known, before.reach, &mut fresh);
        let mut remembered = now.iter();
        for manifold in manifolds {
            let first = remembered.as_slice().first();
            manifold.id = first.map_or_else(|| fresh(1), |point| point.manifold);
            for point in &mut manifold.points {
                point.id = remembered.next().map_or_else(|| fresh(0), |point| point.id);
            }
        }
        if !is_final {
            let left = (0..known.len()).filter(|&k| passed_on >> k & 1 == 0);
            let room = KNOWN - now.len();
            now.extend(left.map(|k| known[k]).take(room));
        }
    }
}
