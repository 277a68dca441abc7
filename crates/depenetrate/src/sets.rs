//! Convex sets of translations of B at which the bodies meet: two triangles, or balls.
//!
//! A triangle `t` of A meets a triangle `u` of B moved by `v` if and only if `v` is in `{p - q: p
//! in t, q in u}`. This is a polytope with at most 22 faces: parallel to `t`, to `u`, or to an edge
//! of each.
//!
//! Two points, of which one or both are centers of balls inside of their bodies, give a ball of
//! translations: the bodies meet wherever the two balls overlap.

use super::convex::Polytope;
use super::cover::{Cone, Rays};
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Reverse;
use glam::DVec3;
use punctual_geom::triangles_intersect;

pub(super) type Triangle = [DVec3; 3];

/// Capacities.
const PAIRS: usize = 512;
const POINTS: usize = 64;
const BALLS: usize = 1024;
pub(super) const CONES: usize = 4096;

/// Work to compare the box of a set with a point, and to intersect a set with rays.
pub(super) const WORK_PER_BOX: u64 = 4;
pub(super) const WORK_PER_SET: u64 = 80;

/// Once this work is done, no more pairs are intersected with a direction; and the maximum work of
/// intersecting them.
const MOST_WORK: u64 = PAIRS as u64 * WORK_PER_BOX + 11 * WORK_PER_SET;
pub(super) const WORK_TO_LEAVE: u64 = MOST_WORK + WORK_PER_SET;

/// A convex set of translations of B at which the bodies meet.
pub(super) trait Convex {
    /// The lengths at which a ray from 0 enters and leaves the set, up to rounding. NaN if it
    /// misses.
    fn along(&self, ray: DVec3) -> [f64; 2];

    /// True if the set holds a translation, up to rounding.
    fn may_hold(&self, translation: DVec3) -> bool;

    /// True if it is proven that the set holds a translation, up to a rounding per coordinate.
    fn holds(&self, translation: DVec3) -> bool;

    /// Translations longer than this are not known to be in the set.
    fn longest(&self) -> f64 {
        f64::INFINITY
    }
}

/// A plane that bounds a set: its unit normal, which points out of the set, and its distance from
/// 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub normal: DVec3,
    offset: f64,
}

impl Face {
    /// How far a translation is beyond the plane.
    pub fn beyond(&self, translation: DVec3) -> f64 {
        self.normal.dot(translation) - self.offset
    }
}

/// Two triangles, and the translations of B at which they meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    corners: [Triangle; 2],
    /// For each pair of parallel faces the normal, of any length, and the offsets of both faces
    /// along it. Zero if there is no such pair.
    slabs: [(DVec3, f64, f64); 11],
}

impl Pair {
    /// `b` is the triangle of B before any translation.
    pub fn new([a, b]: [Triangle; 2]) -> Self {
        // With edges up to length 1, their products stay within the range of `f64`.
        let [e, f] = [a, b].map(|t| {
            let edges = [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
            let longest = edges.iter().fold(f64::MIN_POSITIVE, |most, edge| {
                edge.abs().max_element().max(most)
            });
            edges.map(|edge| edge / longest)
        });
        let slab = |i: usize| {
            let normal = match i {
                0 => e[0].cross(e[1]),
                1 => f[0].cross(f[1]),
                _ => e[(i - 2) / 3].cross(f[(i - 2) % 3]),
            };
            let [[p, q, r], [s, t, u]] = [a, b].map(|t| t.map(|p| normal.dot(p - a[0])));
            let (least, most) = (p.min(q).min(r), p.max(q).max(r));
            (normal, least - s.max(t).max(u), most - s.min(t).min(u))
        };
        Self {
            corners: [a, b],
            slabs: core::array::from_fn(slab),
        }
    }

    /// A box around the translations at which they meet.
    fn bounds(&self) -> [DVec3; 2] {
        let [a, b] = self.corners;
        let least = |t: Triangle| t[0].min(t[1]).min(t[2]);
        let most = |t: Triangle| t[0].max(t[1]).max(t[2]);
        [least(a) - most(b), most(a) - least(b)]
    }

    /// The face that a translation is farthest beyond.
    pub fn face(&self, translation: DVec3) -> Option<Face> {
        let faces = self.slabs.iter().flat_map(|&(normal, least, most)| {
            let length = normal.length();
            let [up, down] = [(1.0, most), (-1.0, -least)].map(|(sign, offset)| Face {
                normal: normal * (sign / length),
                offset: offset / length,
            });
            [up, down].into_iter().filter(move |_| length > 0.0)
        });
        let beyond = |face: &Face| face.beyond(translation);
        faces.max_by(|f, g| beyond(f).total_cmp(&beyond(g)))
    }

    /// Half the edge of a cube around 0 in which they meet, up to rounding.
    pub fn margin(&self) -> f64 {
        let margin = |&(normal, least, most): &(DVec3, f64, f64)| {
            let length = normal.abs().element_sum();
            (length > 0.0).then(|| most.min(-least) / length)
        };
        let margin = self.slabs.iter().filter_map(margin).reduce(f64::min);
        margin.unwrap_or(0.0)
    }

    /// True if it is proven that they meet at all translations in a cube around 0, once its edges
    /// are shorter by four roundings.
    pub fn fills_cube(&self, half: f64) -> bool {
        (0..8).all(|i| {
            let sign = |axis: usize| if i >> axis & 1 == 0 { half } else { -half };
            self.holds(DVec3::new(sign(0), sign(1), sign(2)))
        })
    }
}

impl Convex for Pair {
    fn along(&self, ray: DVec3) -> [f64; 2] {
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for &(normal, least, most) in &self.slabs {
            let speed = normal.dot(ray);
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

    fn may_hold(&self, translation: DVec3) -> bool {
        self.slabs.iter().all(|&(normal, least, most)| {
            let offset = normal.dot(translation);
            least <= offset && offset <= most
        })
    }

    fn holds(&self, translation: DVec3) -> bool {
        let [a, b] = &self.corners;
        triangles_intersect(a, &b.map(|p| p + translation))
    }
}

/// A point of a body. It has a ball around it that is inside of the body; or it is on the surface,
/// and the radius is 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub of_b: bool,
    /// In A's frame, before B is moved.
    pub place: DVec3,
    pub radius: f64,
}

/// Translations nearer to `center` than `radius`, of which those longer than `longest` are not
/// known to be blocked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub center: DVec3,
    pub radius: f64,
    pub longest: f64,
}

impl Convex for Ball {
    fn along(&self, ray: DVec3) -> [f64; 2] {
        let center = self.center / self.radius;
        // Roots of |x ray - center| = 1.
        let (square, half) = (ray.length_squared(), ray.dot(center));
        let root = libm::sqrt(half * half + square * (1.0 - center.length_squared()));
        [half - root, half + root].map(|x| x / square * self.radius)
    }

    fn may_hold(&self, translation: DVec3) -> bool {
        (translation - self.center).length_squared() < self.radius * self.radius
    }

    fn holds(&self, translation: DVec3) -> bool {
        punctual_geom::length(translation - self.center) < self.radius * (1.0 - 1e-12)
    }

    fn longest(&self) -> f64 {
        self.longest
    }
}

/// All sets that are known. The latest take the place of the oldest.
#[derive(Debug)]
pub(super) struct Sets {
    pairs: Vec<Pair>,
    /// For each pair the triangles, and a box around the translations.
    outlines: Vec<([u32; 2], [DVec3; 2])>,
    next_pair: usize,
    points: Vec<Point>,
    next_point: usize,
    balls: Vec<Ball>,
    next_ball: usize,
    /// The cones that the sets advance.
    pub cones: Vec<Cone>,
    /// The cones that wait, least radius first: the bits of the radius, and the index.
    pub open: BinaryHeap<Reverse<(u64, usize)>>,
    pub polytope: Polytope,
}

impl Sets {
    pub fn new() -> Self {
        Self {
            pairs: Vec::with_capacity(PAIRS),
            outlines: Vec::with_capacity(PAIRS),
            next_pair: 0,
            points: Vec::with_capacity(POINTS),
            next_point: 0,
            balls: Vec::with_capacity(BALLS),
            next_ball: 0,
            cones: Vec::with_capacity(CONES),
            open: BinaryHeap::with_capacity(CONES),
            polytope: Polytope::new(),
        }
    }

    pub fn clear(&mut self) {
        self.pairs.clear();
        self.outlines.clear();
        self.points.clear();
        self.balls.clear();
        self.cones.clear();
        self.open.clear();
        self.polytope.clear();
        (self.next_pair, self.next_point, self.next_ball) = (0, 0, 0);
    }

    pub fn len(&self) -> usize {
        self.pairs.len() + self.balls.len()
    }

    pub fn get(&self, index: usize) -> &dyn Convex {
        match self.pairs.get(index) {
            Some(pair) => pair,
            None => &self.balls[index - self.pairs.len()],
        }
    }

    /// The corners of the triangles of A (of B) in all pairs.
    pub fn corners(&self, of_b: bool) -> impl Iterator<Item = DVec3> {
        let corners = move |pair: &Pair| pair.corners[usize::from(of_b)];
        self.pairs.iter().flat_map(corners)
    }

    /// False if a set is known not to hold all inner points of a cone.
    pub fn may_hold(&self, index: usize, rays: &Rays, [least, most]: [DVec3; 2]) -> bool {
        let outline = self.outlines.get(index);
        outline.is_none_or(|(_, [from, to])| (from.cmple(least) & to.cmpge(most)).all())
            && self.get(index).may_hold(rays.first())
    }

    pub fn add_pair(&mut self, id: [u32; 2], pair: Pair) {
        if !self.outlines.iter().any(|&(known, _)| known == id) {
            let mut oldest = self.next_pair;
            put(&mut self.outlines, &mut oldest, (id, pair.bounds()));
            put(&mut self.pairs, &mut self.next_pair, pair);
        }
    }

    /// Adds a point, and those of its balls with points of the other body that `keeps` accepts.
    /// `longest`: the length of a push up to which a point inside A proves that the bodies meet,
    /// and the length up to which a point inside B does.
    pub fn add_point(
        &mut self,
        point: Point,
        rounding: f64,
        longest: [f64; 2],
        mut keeps: impl FnMut(&Ball) -> bool,
    ) {
        let is_known = |known: &Point| known.of_b == point.of_b && known.place == point.place;
        if self.points.iter().any(is_known) {
            return;
        }
        for other in self.points.iter().filter(|other| other.of_b != point.of_b) {
            let [a, b] = if point.of_b {
                [other, &point]
            } else {
                [&point, other]
            };
            let of = [(a, longest[0]), (b, longest[1])];
            let of = of.into_iter().filter(|(point, _)| point.radius > 0.0);
            let ball = Ball {
                center: a.place - b.place,
                radius: a.radius + b.radius - 16.0 * rounding,
                longest: of.fold(f64::INFINITY, |least, (_, longest)| least.min(longest)),
            };
            if a.radius.max(b.radius) > 0.0 && ball.radius > 0.0 && keeps(&ball) {
                put(&mut self.balls, &mut self.next_ball, ball);
            }
        }
        put(&mut self.points, &mut self.next_point, point);
    }

    /// A length, at least `from`, below which a push in this direction stays in known pairs, up to
    /// rounding; the pair that it leaves there; and the work done.
    pub fn free_from(&self, direction: DVec3, from: f64) -> (f64, Option<&Pair>, u64) {
        let (mut length, mut work) = (from, self.pairs.len() as u64 * WORK_PER_BOX);
        let mut last = None;
        for (pair, (_, [least, most])) in self.pairs.iter().zip(&self.outlines) {
            let push = direction * length;
            if work < MOST_WORK && (least.cmple(push) & push.cmple(*most)).all() {
                work += WORK_PER_SET;
                let [enter, leave] = pair.along(direction);
                if enter <= length && length < leave && leave < f64::INFINITY {
                    (length, last) = (leave, Some(pair));
                }
            }
        }
        (length, last, work)
    }
}

/// Adds an element, in the place of the oldest if there is no room.
fn put<T>(all: &mut Vec<T>, oldest: &mut usize, element: T) {
    if all.len() < all.capacity() {
        all.push(element);
    } else {
        all[*oldest] = element;
        *oldest = (*oldest + 1) % all.len();
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

    fn triangle(random: &mut Random) -> Triangle {
        let mut next = || (random.bits() % 2001) as f64 / 1000.0 - 1.0;
        [(); 3].map(|()| DVec3::new(next(), next(), next()))
    }

    #[test]
    fn a_pair_is_left_where_the_triangles_part() {
        let (mut random, mut met) = (Random::new(5), 0);
        for _ in 0..2000 {
            let pair = Pair::new([triangle(&mut random), triangle(&mut random)]);
            let direction = unit(triangle(&mut random)[0]);
            let [enter, leave] = pair.along(direction);
            let meets = enter <= 0.0 && 0.0 <= leave;
            assert_eq!(meets, pair.holds(DVec3::ZERO), "{pair:?}");
            assert_eq!(meets, pair.may_hold(DVec3::ZERO), "{pair:?}");
            if meets && leave > 0.0 {
                met += 1;
                let holds = |length: f64| pair.holds(direction * length);
                assert!(holds(leave * (1.0 - 1e-9)) && !holds(leave * (1.0 + 1e-9)));
            }
        }
        assert!(met > 100, "{met}");
    }
}
