//! Ids of manifolds and their points: a point inherits the id of the nearest point of the frame
//! before, as seen from A or from B.
//!
//! A point that slides stays at its place on one of the bodies; one that rolls moves a little on
//! both. So the nearer of both places counts.

use super::Manifold;
use alloc::vec::Vec;
use glam::DVec3;

/// The points of the frame before.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ManifoldMemory {
    known: Vec<Known>,
    now: Vec<Known>,
    links: Vec<Link>,
    /// The next id of a point, and of a manifold.
    next: [u64; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Known {
    /// [`NO_ID`] if it has none yet, or has passed it on.
    id: u64,
    manifold: u64,
    /// The point on A in A's frame, and the point on B in B's frame.
    places: [DVec3; 2],
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

impl ManifoldMemory {
    /// Gives ids to the points and manifolds, the nearest places first, and remembers them. `size`
    /// is that of the smaller mesh; `to_b` maps A's frame to B's. Unless all manifolds are known
    /// (`is_final`), points that were not found again are remembered too.
    pub fn assign(
        &mut self,
        manifolds: &mut [Manifold],
        size: f64,
        to_b: impl Fn(DVec3) -> DVec3,
        is_final: bool,
    ) {
        let Self {
            known,
            now,
            links,
            next,
        } = self;
        now.clear();
        links.clear();
        for (i, manifold) in manifolds.iter().enumerate() {
            let points = manifold.points.iter().map(|point| Known {
                id: NO_ID,
                manifold: i as u64,
                places: [point.points[0], to_b(point.points[1])],
            });
            let room = KNOWN - now.len();
            now.extend(points.take(room));
        }
        for (i, point) in (0..).zip(now.iter()) {
            for (j, before) in (0..).zip(known.iter()) {
                let apart = |side: usize| (point.places[side] - before.places[side]).length();
                let distance = apart(0).min(apart(1));
                if distance <= REACH * size {
                    links.push(Link {
                        distance,
                        now: i,
                        before: j,
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
        let mut fresh = |kind: usize| {
            next[kind] += 1;
            next[kind] - 1
        };
        manifolds
            .iter_mut()
            .for_each(|manifold| manifold.id = NO_ID);
        for &Link { now: i, before, .. } in &*links {
            let (point, before) = (&mut now[i as usize], &mut known[before as usize]);
            if point.id != NO_ID || before.id == NO_ID {
                continue;
            }
            point.id = core::mem::replace(&mut before.id, NO_ID);
            // The nearest point of a manifold decides its id.
            let inherited = before.manifold;
            let is_free = manifolds.iter().all(|manifold| manifold.id != inherited);
            let manifold = &mut manifolds[point.manifold as usize];
            if manifold.id == NO_ID && is_free {
                manifold.id = inherited;
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
            let room = KNOWN - now.len();
            let left = known.iter().filter(|before| before.id != NO_ID);
            now.extend(left.take(room));
        }
        core::mem::swap(known, now);
    }
}
