//! A cover of translations: convex sets of translations of B at which the bodies meet, and the
//! cones around 0 whose inner part these sets fill.
//!
//! A cone is spanned by three unit vectors. It keeps a radius below which all its translations are
//! known to be blocked. One convex set advances it: a set that contains six points, three on the
//! rays of the cone just inside of the radius and three farther out, contains their hull, and so
//! the cone's part between them. Since the far points may lie at different lengths, a flat face of
//! a set bounds a cone exactly, however wide the cone is.
//!
//! All points are tested on a slightly wider cone, so that roundings of translations and vertices
//! leave no gap between neighboring cones. Proof in `docs/numerics.md`, "Penetration".

use super::blocked::{Blocked, unit};
use core::cmp::Ordering;
use glam::DVec3;
use punctual_geom::triangles_intersect;

type Triangle = [DVec3; 3];

/// Least widening of a cone before its points are tested, relative to its size.
const WIDENING: f64 = 1.0 / 65536.0;

/// Largest widening. A cone that needs more is not advanced: `f64` does not resolve its radius.
const MOST_WIDENING: f64 = 0.25;

/// Allowance for the directions of a cone, which are rounded each time that it is split.
const DIRECTION_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A length computed from a set is shortened by this before it is proven.
const SHORTENING: f64 = 1e-10;

/// How often a cone is split at most.
const LEVELS: u8 = 12;

/// Two triangles, and the translations of B at which they meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    blocked: Blocked,
    pub corners: [Triangle; 2],
}

/// Translations nearer to `center` than `radius`, of which those longer than `longest` are not
/// known to be blocked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub center: DVec3,
    pub radius: f64,
    pub longest: f64,
}

/// What a set gives a cone: the new radius, and how far out the set reaches along each of its rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Advance {
    pub radius: f64,
    reach: [f64; 3],
}

impl Pair {
    /// `b` is the triangle of B before any translation.
    pub fn new([a, b]: [Triangle; 2]) -> Self {
        Self {
            blocked: Blocked::of(&a, &b),
            corners: [a, b],
        }
    }

    /// A box around the translations at which they meet.
    pub fn bounds(&self) -> [DVec3; 2] {
        let [a, b] = self.corners;
        let least = |t: Triangle| t[0].min(t[1]).min(t[2]);
        let most = |t: Triangle| t[0].max(t[1]).max(t[2]);
        [least(a) - most(b), most(a) - least(b)]
    }

    /// Half the edge of a cube around 0 in which they meet, up to rounding.
    pub fn margin(&self) -> f64 {
        let margin = self.blocked.margin();
        if margin < f64::INFINITY { margin } else { 0.0 }
    }

    /// True if it is proven that they meet at a translation, up to `rounding` per coordinate.
    fn meet(&self, translation: DVec3) -> bool {
        let [a, b] = &self.corners;
        triangles_intersect(a, &b.map(|p| p + translation))
    }

    /// True if it is proven that they meet at all translations in a cube around 0, once its edges
    /// are shorter by four roundings.
    pub fn fills_cube(&self, half: f64) -> bool {
        (0..8).all(|i| {
            let sign = |axis: usize| if i >> axis & 1 == 0 { half } else { -half };
            self.meet(DVec3::new(sign(0), sign(1), sign(2)))
        })
    }
}

/// Translations `t` in the cone over a spherical triangle with `|t| < radius` are blocked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    pub radius: f64,
    pub directions: [DVec3; 3],
    /// Distance of the plane through the directions from 0, and the radius of the circle in them.
    pub plane: f64,
    pub inradius: f64,
    pub level: u8,
    /// The pair that advanced it last.
    pub hint: u16,
    /// A number of its own, so that cones are totally ordered.
    pub number: u32,
}

impl Cone {
    fn new(directions: [DVec3; 3]) -> Self {
        let [p, q, r] = directions;
        let normal = (q - p).cross(r - p);
        let length = normal.length();
        let around = (q - p).length() + (r - q).length() + (p - r).length();
        Self {
            radius: 0.0,
            directions,
            plane: normal.dot(p).abs() / length,
            inradius: length / around,
            level: 0,
            hint: 0,
            number: 0,
        }
    }

    /// Twenty cones that fill space: those over the faces of an icosahedron.
    pub fn all_around() -> [Self; 20] {
        const PHI: f64 = 1.618_033_988_749_895;
        let corner = |i: usize| {
            let (s, t) = (
                if i & 1 == 0 { 1.0 } else { -1.0 },
                if i & 2 == 0 { PHI } else { -PHI },
            );
            unit(match i / 4 {
                0 => DVec3::new(0.0, s, t),
                1 => DVec3::new(s, t, 0.0),
                _ => DVec3::new(t, 0.0, s),
            })
        };
        // Corner numbers of the faces.
        const FACES: [[usize; 3]; 20] = [
            [0, 1, 8],
            [0, 1, 10],
            [0, 4, 5],
            [0, 4, 8],
            [0, 5, 10],
            [1, 6, 7],
            [1, 6, 8],
            [1, 7, 10],
            [2, 3, 9],
            [2, 3, 11],
            [2, 4, 5],
            [2, 4, 9],
            [2, 5, 11],
            [3, 6, 7],
            [3, 6, 9],
            [3, 7, 11],
            [4, 8, 9],
            [5, 10, 11],
            [6, 8, 9],
            [7, 10, 11],
        ];
        FACES.map(|face| Self::new(face.map(corner)))
    }

    /// The unit vector in its middle.
    pub fn middle(&self) -> DVec3 {
        unit(self.directions[0] + self.directions[1] + self.directions[2])
    }

    /// Four cones that fill it; `None` if they would be too narrow.
    pub fn split(&self) -> Option<[Self; 4]> {
        let [x, y, z] = self.directions;
        let (xy, yz, zx) = (unit(x + y), unit(y + z), unit(z + x));
        (self.level < LEVELS).then(|| {
            [[x, xy, zx], [xy, y, yz], [zx, yz, z], [xy, yz, zx]].map(|directions| Self {
                radius: self.radius,
                level: self.level + 1,
                hint: self.hint,
                ..Self::new(directions)
            })
        })
    }

    /// The rays of the wider cone on which sets are tested. `None` if `rounding` leaves no room.
    pub fn rays(&self, rounding: f64) -> Option<Rays> {
        let needed = 16.0 * (rounding / self.radius + DIRECTION_ROUNDING) / self.inradius;
        let widening = WIDENING.max(needed);
        let middle = (self.directions[0] + self.directions[1] + self.directions[2]) / 3.0;
        let along = self.directions.map(|d| d + widening * (d - middle));
        let inner = self.radius - 8.0 * rounding;
        (widening <= MOST_WIDENING && inner > 0.0).then_some(Rays {
            along,
            inner,
            plane: self.plane,
            size: self.inradius,
            radius: self.radius,
            rounding,
        })
    }
}

/// The three rays of a cone, slightly widened, with what a set has to contain of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays {
    along: [DVec3; 3],
    /// Length of the inner points.
    inner: f64,
    plane: f64,
    /// Radius of the circle in the flat triangle.
    size: f64,
    radius: f64,
    rounding: f64,
}

impl Rays {
    /// A box around the inner points.
    pub fn bounds(&self) -> [DVec3; 2] {
        let [p, q, r] = self.along.map(|ray| ray * self.inner);
        [p.min(q).min(r), p.max(q).max(r)]
    }

    /// The largest distance of an inner point from `center`.
    pub fn farthest(&self, center: DVec3) -> f64 {
        let far = |ray: &DVec3| punctual_geom::length(*ray * self.inner - center);
        self.along.iter().map(far).fold(0.0, f64::max)
    }

    /// What the pair would give, not proven yet.
    pub fn by_pair(&self, pair: &Pair) -> Option<Advance> {
        let mut reach = [0.0; 3];
        if !self
            .along
            .iter()
            .all(|&ray| pair.blocked.holds(ray * self.inner))
        {
            return None;
        }
        for (reach, &ray) in reach.iter_mut().zip(&self.along) {
            *reach = pair.blocked.along(ray)[1];
        }
        self.advance(reach)
    }

    /// True if the pair gives it.
    pub fn proves(&self, pair: &Pair, advance: &Advance) -> bool {
        let ends = self.along.iter().zip(&advance.reach);
        self.along.iter().all(|&ray| pair.meet(ray * self.inner))
            && ends
                .into_iter()
                .all(|(&ray, &reach)| pair.meet(ray * reach))
    }

    /// What the ball gives.
    pub fn by_ball(&self, ball: &Ball) -> Option<Advance> {
        let center = ball.center / ball.radius;
        let room = 1.0 - center.length_squared();
        let mut reach = [0.0; 3];
        for (reach, ray) in reach.iter_mut().zip(&self.along) {
            // Roots of |x ray - center| = 1.
            let (square, half) = (ray.length_squared(), ray.dot(center));
            let root = libm::sqrt(half * half + square * room);
            let [near, far] = [half - root, half + root].map(|x| x / square * ball.radius);
            // False also for a negative square under the root.
            if !(near < self.inner * (1.0 - SHORTENING) && far > self.radius) {
                return None;
            }
            *reach = far;
        }
        let advance = self.advance(reach)?;
        let radius = advance.radius.min(ball.longest);
        let ends = self.along.iter().zip(&advance.reach);
        let holds =
            |point: DVec3| punctual_geom::length(point - ball.center) < ball.radius * (1.0 - 1e-12);
        let is_held = ends
            .into_iter()
            .all(|(&ray, &reach)| holds(ray * self.inner) && holds(ray * reach));
        (is_held && radius > self.radius).then_some(Advance { radius, ..advance })
    }

    /// The new radius of a cone whose rays a convex set contains up to these lengths.
    fn advance(&self, reach: [f64; 3]) -> Option<Advance> {
        let [p, q, r] = reach;
        let (least, most) = (p.min(q).min(r), p.max(q).max(r));
        if !(least > self.radius && most < f64::INFINITY) {
            return None;
        }
        let [p, q, r]: [DVec3; 3] = core::array::from_fn(|i| self.along[i] * (reach[i] / least));
        let normal = (q - p).cross(r - p);
        let area = normal.length();
        // A steeper plane is not known well enough.
        let oblique = if most - least < 8.0 * least * self.size {
            least * (normal.dot(p).abs() / area)
        } else {
            0.0
        };
        let straight = least * self.plane;
        let (radius, reach) = if oblique > straight {
            (oblique, reach)
        } else {
            (straight, [least; 3])
        };
        let radius = radius * (1.0 - 4.0 * SHORTENING) - 8.0 * self.rounding;
        let reach = reach.map(|length| length * (1.0 - SHORTENING));
        (radius > self.radius).then_some(Advance { radius, reach })
    }
}

impl Ord for Cone {
    /// The one with the least radius is the greatest: the next to advance.
    fn cmp(&self, other: &Self) -> Ordering {
        let radius = other.radius.total_cmp(&self.radius);
        radius.then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for Cone {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cone {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cone {}

#[cfg(test)]
mod tests {
    use super::*;
    use punctual_geom::random::Random;

    fn vector(random: &mut Random) -> DVec3 {
        let mut next = || random.between(-1.0, 1.0);
        DVec3::new(next(), next(), next())
    }

    fn is_in(cone: &Cone, direction: DVec3) -> bool {
        let [p, q, r] = cone.directions;
        let turn = p.dot(q.cross(r)).signum();
        [[p, q], [q, r], [r, p]]
            .into_iter()
            .all(|[x, y]| x.cross(y).dot(direction) * turn >= 0.0)
    }

    #[test]
    fn cones_fill_space_and_their_parts_fill_them() {
        let mut random = Random::new(3);
        for _ in 0..500 {
            let direction = unit(vector(&mut random));
            let whole = Cone::all_around();
            let mut cone = *whole.iter().find(|cone| is_in(cone, direction)).unwrap();
            for level in 1..=LEVELS {
                let parts = cone.split().unwrap();
                cone = *parts.iter().find(|part| is_in(part, direction)).unwrap();
                assert!(cone.level == level && cone.plane > 0.79 && cone.inradius > 0.0);
            }
            assert!(cone.split().is_none() && cone.plane > 1.0 - 1e-6);
        }
    }

    /// Below the new radius all translations of the cone are blocked, and the radius is not much
    /// less than it could be.
    #[test]
    fn a_pair_advances_a_cone_as_far_as_it_meets() {
        let mut random = Random::new(7);
        let (mut advanced, mut near) = (0, 0);
        for _ in 0..20_000 {
            let triangle = |random: &mut Random| [(); 3].map(|()| vector(random));
            let pair = Pair::new([triangle(&mut random), triangle(&mut random)]);
            let margin = 0.9 * pair.margin();
            if margin < 0.01 || !pair.fills_cube(margin) {
                continue;
            }
            let cone = Cone {
                radius: margin,
                ..Cone::all_around()[random.bits() as usize % 20]
            };
            let cone = cone.split().unwrap()[random.bits() as usize % 4];
            let rays = cone.rays(1e-15).unwrap();
            let Some(advance) = rays.by_pair(&pair) else {
                continue;
            };
            assert!(rays.proves(&pair, &advance));
            advanced += 1;
            for _ in 0..20 {
                let shares = [(); 3].map(|()| random.fraction());
                let direction = unit(
                    (0..3)
                        .map(|i| cone.directions[i] * shares[i])
                        .sum::<DVec3>()
                        + DVec3::splat(1e-300),
                );
                let length = advance.radius * random.fraction();
                assert!(
                    pair.meet(direction * length),
                    "{pair:?} {direction:?} {length}"
                );
            }
            // Somewhere just beyond they part.
            let ends = rays
                .along
                .map(|ray| ray * (1.3 * advance.radius / ray.length()));
            near += usize::from(ends.iter().any(|&end| !pair.meet(end)));
        }
        assert!(advanced > 300 && 2 * near > advanced, "{advanced} {near}");
    }

    #[test]
    fn a_ball_advances_a_cone_as_far_as_it_reaches() {
        let mut random = Random::new(9);
        let mut advanced = 0;
        for _ in 0..5000 {
            let ball = Ball {
                center: vector(&mut random) * 0.5,
                radius: random.between(0.3, 1.0),
                longest: if random.bits() & 1 == 0 {
                    f64::INFINITY
                } else {
                    0.4
                },
            };
            let cone = Cone {
                radius: random.between(0.01, 0.3),
                ..Cone::all_around()[random.bits() as usize % 20]
            };
            let Some(advance) = cone.rays(1e-15).unwrap().by_ball(&ball) else {
                continue;
            };
            advanced += 1;
            assert!(advance.radius > cone.radius && advance.radius <= ball.longest);
            for _ in 0..20 {
                let shares = [(); 3].map(|()| random.fraction());
                let direction = unit((0..3).map(|i| cone.directions[i] * shares[i]).sum());
                let length = random.between(cone.radius, advance.radius);
                let distance = (direction * length - ball.center).length();
                assert!(
                    distance < ball.radius,
                    "{ball:?} {cone:?} {direction:?} {length}"
                );
            }
        }
        assert!(advanced > 500, "{advanced}");
    }

    /// Where roundings are as large as the radius, nothing is claimed.
    #[test]
    fn a_cone_that_is_not_resolved_is_not_advanced() {
        let cone = Cone {
            radius: 1e-12,
            ..Cone::all_around()[0]
        };
        assert!(cone.rays(1e-15).is_some() && cone.rays(1e-13).is_none());
    }
}
