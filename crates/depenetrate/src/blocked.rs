//! Translations of B for which two known triangles intersect: a pool of convex sets that a push has
//! to leave.
//!
//! A triangle `t` of A intersects a triangle `u` of B moved by `v` if and only if `v` is in `{p -
//! q: p in t, q in u}`. This is a polytope with at most 22 faces: parallel to `t`, to `u`, or to an
//! edge of each. So for every direction a few dot products give a length below which the surfaces
//! intersect. The pool keeps triangle pairs that blocked a push, and saves queries whose answer
//! they imply. It only ever saves queries: rounding in a degenerate pair may miss a shorter push,
//! but never affects a proof.

use arrayvec::ArrayVec;
use glam::DVec3;

/// Capacity of the pool.
pub(super) const ROOM: usize = 16;

/// Work to add a pair, and to evaluate one.
pub(super) const WORK_PER_ADDED: u64 = 500;
const WORK_PER_ASKED: u64 = 120;

/// The translations for which one pair of triangles intersects.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blocked {
    /// For each pair of parallel faces the normal, of any length, and the offsets of both faces
    /// along it. Zero if there is no such pair.
    slabs: [(DVec3, f64, f64); 11],
}

impl Blocked {
    pub fn of(a: &[DVec3; 3], b: &[DVec3; 3]) -> Self {
        let [mut e, mut f] = [a, b].map(|t| [t[1] - t[0], t[2] - t[1], t[0] - t[2]]);
        // With edges up to length 1, their products stay within the range of `f64`.
        let longest = |edges: &[DVec3; 3]| {
            edges
                .iter()
                .fold(f64::MIN_POSITIVE, |m, edge| edge.abs().max_element().max(m))
        };
        for edges in [&mut e, &mut f] {
            let longest = longest(edges);
            edges.iter_mut().for_each(|edge| *edge /= longest);
        }
        let slab = |i: usize| {
            let normal = match i {
                0 => e[0].cross(e[1]),
                1 => f[0].cross(f[1]),
                _ => e[(i - 2) / 3].cross(f[(i - 2) % 3]),
            };
            let [[p, q, r], [s, t, u]] = [a, b].map(|t| t.map(|p| normal.dot(p - a[0])));
            (
                normal,
                p.min(q).min(r) - s.max(t).max(u),
                p.max(q).max(r) - s.min(t).min(u),
            )
        };
        Self {
            slabs: core::array::from_fn(slab),
        }
    }

    /// True if the triangles meet at a translation, up to rounding.
    pub fn holds(&self, translation: DVec3) -> bool {
        self.slabs.iter().all(|&(normal, least, most)| {
            let offset = normal.dot(translation);
            least <= offset && offset <= most
        })
    }

    /// Half the edge of a cube around 0 in which they meet, up to rounding.
    pub fn margin(&self) -> f64 {
        let margin = |&(normal, least, most): &(DVec3, f64, f64)| {
            let length = normal.abs().element_sum();
            if length > 0.0 {
                most.min(-least) / length
            } else {
                f64::INFINITY
            }
        };
        self.slabs.iter().map(margin).fold(f64::INFINITY, f64::min)
    }

    /// The lengths at which a push in this direction enters and leaves the polytope.
    pub fn along(&self, direction: DVec3) -> [f64; 2] {
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for &(normal, least, most) in &self.slabs {
            let speed = normal.dot(direction);
            if speed != 0.0 {
                let per_speed = 1.0 / speed;
                let (near, far) = if speed > 0.0 {
                    (least, most)
                } else {
                    (most, least)
                };
                let (first, last) = (near * per_speed, far * per_speed);
                enter = if first > enter { first } else { enter };
                leave = if last < leave { last } else { leave };
            }
        }
        [enter, leave]
    }
}

/// The latest [`ROOM`] pairs.
#[derive(Debug, Default)]
pub(super) struct Pool {
    pairs: ArrayVec<Blocked, ROOM>,
    /// The slot that the next pair overwrites once the pool is full.
    next: usize,
}

impl Pool {
    /// Adds a triangle of A and one of B, the latter before the push.
    pub fn add(&mut self, a: &[DVec3; 3], b: &[DVec3; 3]) {
        let pair = Blocked::of(a, b);
        if self.pairs.try_push(pair).is_err() {
            self.pairs[self.next] = pair;
            self.next = (self.next + 1) % ROOM;
        }
    }

    /// Maximum work of [`Pool::free_from`].
    pub fn work(&self) -> u64 {
        self.pairs.len() as u64 * WORK_PER_ASKED
    }

    /// Returns a length, at least `from`, below which a push in this direction intersects some pair
    /// of the pool, up to rounding, and the work done. Stops as soon as the length reaches
    /// `enough`.
    pub fn free_from(&mut self, direction: DVec3, from: f64, enough: f64) -> (f64, u64) {
        let mut length = from;
        for i in 0..self.pairs.len() {
            let [enter, leave] = self.pairs[i].along(direction);
            if enter <= length && length < leave && leave < f64::INFINITY {
                length = leave;
                if length >= enough {
                    // A pair that blocks far moves to the front, to be evaluated sooner next time.
                    self.pairs.swap(i, i / 2);
                    return (length, (i as u64 + 1) * WORK_PER_ASKED);
                }
            }
        }
        (length, self.work())
    }
}

/// Normalizes a vector of any length; 0 if it has no direction.
pub(super) fn unit(v: DVec3) -> DVec3 {
    let largest = v.abs().max_element();
    if largest > 0.0 && largest < f64::INFINITY {
        (v / largest).normalize()
    } else {
        DVec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use punctual_geom::random::Random;
    use punctual_geom::triangles_intersect;

    fn blocked(a: &[DVec3; 3], b: &[DVec3; 3], direction: DVec3) -> f64 {
        let mut pool = Pool::default();
        pool.add(a, b);
        pool.free_from(direction, 0.0, f64::INFINITY).0
    }

    #[test]
    fn a_pair_is_left_where_the_triangles_part() {
        let mut random = Random::new(5);
        let mut next = || (random.bits() % 2001) as f64 / 1000.0 - 1.0;
        let mut vector = || DVec3::new(next(), next(), next());
        let mut met = 0;
        for _ in 0..2000 {
            let (a, b) = (
                [vector(), vector(), vector()],
                [vector(), vector(), vector()],
            );
            let direction = unit(vector());
            let length = blocked(&a, &b, direction);
            let meets = |length: f64| triangles_intersect(&a, &b.map(|p| p + direction * length));
            assert_eq!(length > 0.0, meets(0.0), "{a:?} {b:?}");
            if length > 0.0 {
                met += 1;
                assert!(
                    meets(length * (1.0 - 1e-9)) && !meets(length * (1.0 + 1e-9)),
                    "{a:?} {b:?} {direction:?}"
                );
            }
        }
        assert!(met > 100, "{met}");
    }

    #[test]
    fn segments_and_points_do_no_harm() {
        let a = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let segment = [
            DVec3::new(0.25, 0.25, -1.0),
            DVec3::new(0.25, 0.25, 1.0),
            DVec3::new(0.25, 0.25, 0.0),
        ];
        assert!((blocked(&a, &segment, DVec3::Z) - 1.0).abs() < 1e-12);
        // Two points have no faces, so no length is known to be blocked.
        assert_eq!(blocked(&[DVec3::ONE; 3], &[DVec3::ONE; 3], DVec3::Z), 0.0);
    }
}
