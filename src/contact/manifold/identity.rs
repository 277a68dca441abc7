//! Ids of manifolds and their points: a point inherits the id of the nearest point of the frame
//! before, as seen from A or from B.
//!
//! A point that slides stays at its place on one of the bodies; one that rolls moves a little on
//! both. So the nearer of both places counts.

use super::{Manifold, ManifoldPoint};
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual_geom::Pose;

/// The points of the frame before, and those of this one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ManifoldMemory {
    known: Vec<Known>,
    now: Vec<Known>,
    links: Vec<Link>,
    /// The next id of a point, and of a manifold: before this frame, and after it.
    next: [[u64; 2]; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Known {
    /// [`NO_ID`] if it has none yet.
    id: u64,
    manifold: u64,
    /// The point on A in A's frame, and the point on B in B's frame.
    places: [DVec3; 2],
}

impl Known {
    /// Distance from the other place on A or on B, the smaller one.
    fn distance(&self, other: &Self) -> f64 {
        let apart = |side: usize| (self.places[side] - other.places[side]).length();
        apart(0).min(apart(1))
    }
}

/// A point of this frame and one of the frame before that are near each other.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Link {
    distance: f64,
    now: u32,
    before: u32,
}

const NO_ID: u64 = u64::MAX;

/// Maximum number of points of a frame that are matched and remembered, the deepest manifolds
/// first. So the match takes bounded time.
const KNOWN: usize = 128;

/// A point inherits an id from within this fraction of the size of the smaller mesh.
const REACH: f64 = 0.05;

/// What a query knows of the points of the frame before.
#[derive(Clone, Copy)]
pub(crate) struct Before<'m> {
    known: &'m [Known],
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

    fn seen(&self, point: &ManifoldPoint, id: u64, manifold: u64) -> Known {
        let [on_a, on_b] = point.points;
        Known {
            id,
            manifold,
            places: [on_a, self.to_b.transform_point(on_b)],
        }
    }

    /// The candidates that stand for a point of the frame before, as bits: the nearest to each.
    pub fn stay(&self, candidates: &[ManifoldPoint]) -> u32 {
        if self.known.is_empty() {
            return 0;
        }
        let seen: ArrayVec<Known, 24> = candidates
            .iter()
            .take(24)
            .map(|point| self.seen(point, NO_ID, 0))
            .collect();
        let nearest = |known: &Known| {
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
    /// Begins a frame: what was assigned last is the frame before.
    pub fn begin(&mut self) {
        self.known.clone_from(&self.now);
        self.next[0] = self.next[1];
    }

    /// Gives ids to the points and manifolds, the nearest places first, and remembers them. `to_b`
    /// and `size` are those of [`Before::new`]. Unless all manifolds are known (`is_final`), points
    /// that were not found again are remembered too. May be called again in a frame.
    pub fn assign(&mut self, manifolds: &mut [Manifold], to_b: &Pose, size: f64, is_final: bool) {
        let Self {
            known,
            now,
            links,
            next: [first, next],
        } = self;
        let before = Before {
            known,
            to_b,
            reach: REACH * size,
        };
        now.clear();
        links.clear();
        for (i, manifold) in (0..).zip(&*manifolds) {
            let points = manifold.points.iter();
            let room = KNOWN - now.len();
            now.extend(points.take(room).map(|point| before.seen(point, NO_ID, i)));
        }
        for (now, point) in (0..).zip(now.iter()) {
            for (before, other) in (0..).zip(known.iter()) {
                let distance = point.distance(other);
                if distance <= REACH * size {
                    links.push(Link {
                        distance,
                        now,
                        before,
                    });
                }
            }
        }
        let order = |link: &Link| (link.now, link.before);
        links.sort_unstable_by(|x, y| {
            x.distance
                .total_cmp(&y.distance)
                .then(order(x).cmp(&order(y)))
        });
        *next = *first;
        let mut fresh = |kind: usize| {
            next[kind] += 1;
            next[kind] - 1
        };
        manifolds
            .iter_mut()
            .for_each(|manifold| manifold.id = NO_ID);
        let mut passed_on = 0_u128;
        for &Link { now: i, before, .. } in &*links {
            let (point, known) = (&mut now[i as usize], known[before as usize]);
            if point.id != NO_ID || passed_on >> before & 1 != 0 {
                continue;
            }
            passed_on |= 1 << before;
            point.id = known.id;
            // The nearest point of a manifold decides its id.
            let is_free = manifolds
                .iter()
                .all(|manifold| manifold.id != known.manifold);
            let manifold = &mut manifolds[point.manifold as usize];
            if manifold.id == NO_ID && is_free {
                manifold.id = known.manifold;
            }
        }
        let mut remembered = now.iter_mut();
        for manifold in manifolds {
            if manifold.id == NO_ID {
                manifold.id = fresh(1);
            }
            for point in &mut manifold.points {
                match remembered.next() {
                    Some(known) => {
                        if known.id == NO_ID {
                            known.id = fresh(0);
                        }
                        (point.id, known.manifold) = (known.id, manifold.id);
                    }
                    None => point.id = fresh(0),
                }
            }
        }
        if !is_final {
            let left = (0..)
                .zip(known.iter())
                .filter(|(i, _)| passed_on >> i & 1 == 0);
            let room = KNOWN - now.len();
            now.extend(left.map(|(_, known)| *known).take(room));
        }
    }
}
