//! A cover of translations: cones around 0 whose inner part known sets fill.
//!
//! A cone is spanned by three unit vectors. It keeps a radius below which all its translations are
//! known to be blocked. One convex set advances it: a set that contains six points, three on the
//! rays of the cone just inside of the radius and three farther out, contains their hull, and so
//! the cone's part between them. Since the far points may lie at different lengths, a flat face of
//! a set bounds a cone exactly, however wide the cone is.
//!
//! All points are tested on a slightly wider cone, so that roundings of translations and vertices
//! leave no gap between neighboring cones. Proof in `docs/numerics.md`, "Penetration".

use super::sets::{Convex, unit};
use glam::DVec3;

/// Least widening of a cone before its points are tested, relative to its size.
const WIDENING: f64 = 1.0 / 65536.0;

/// Largest widening. A cone that needs more is not advanced: `f64` does not resolve its radius.
const MOST_WIDENING: f64 = 0.25;

/// Allowance for the directions of a cone, which are rounded each time that it is split.
const DIRECTION_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A length computed from a set is shortened by this before it is proven.
const SHORTENING: f64 = 1e-10;

/// Maximum number of times that an octant is split.
const LEVELS: u8 = 12;

/// The advance of a cone by a set: the new radius, and how far out the set reaches along each ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Advance {
    pub radius: f64,
    reach: [f64; 3],
}

/// Translations `t` in the cone over a spherical triangle with `|t| < radius` are blocked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    pub radius: f64,
    pub directions: [DVec3; 3],
    /// Distance from 0 of the plane through the directions, and the radius of the circle that lies
    /// within their triangle.
    plane: f64,
    inradius: f64,
    level: u8,
}

impl Cone {
    fn new(radius: f64, directions: [DVec3; 3]) -> Self {
        let [p, q, r] = directions;
        let normal = (q - p).cross(r - p);
        let length = normal.length();
        let around = (q - p).length() + (r - q).length() + (p - r).length();
        Self {
            radius,
            directions,
            plane: normal.dot(p).abs() / length,
            inradius: length / around,
            level: 0,
        }
    }

    /// Cones that fill space, of this radius: the octants, each split once.
    pub fn all_around(radius: f64) -> [Self; 32] {
        core::array::from_fn(|i| {
            let sign = |axis: usize| if i >> axis & 1 == 0 { 1.0 } else { -1.0 };
            let axes = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
            Self::new(radius, axes).parts()[i / 8]
        })
    }

    /// The unit vector in its middle.
    pub fn middle(&self) -> DVec3 {
        unit(self.directions[0] + self.directions[1] + self.directions[2])
    }

    /// Four cones that fill it; `None` if they would be too narrow.
    pub fn split(&self) -> Option<[Self; 4]> {
        (self.level < LEVELS).then(|| self.parts())
    }

    fn parts(&self) -> [Self; 4] {
        let [x, y, z] = self.directions;
        let (xy, yz, zx) = (unit(x + y), unit(y + z), unit(z + x));
        [[x, xy, zx], [xy, y, yz], [zx, yz, z], [xy, yz, zx]].map(|directions| Self {
            level: self.level + 1,
            ..Self::new(self.radius, directions)
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
            cone: *self,
            along,
            inner,
            rounding,
        })
    }
}

/// The three rays of a cone, slightly widened, and the points on them that a set has to contain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays {
    cone: Cone,
    along: [DVec3; 3],
    /// Distance of the inner points from 0.
    inner: f64,
    rounding: f64,
}

impl Rays {
    /// A box around the inner points.
    pub fn bounds(&self) -> [DVec3; 2] {
        let [p, q, r] = self.along.map(|ray| ray * self.inner);
        [p.min(q).min(r), p.max(q).max(r)]
    }

    /// One of the inner points.
    pub fn first(&self) -> DVec3 {
        self.along[0] * self.inner
    }

    /// The advance by a set, not proven yet. `None` if it does not exceed the radius `known`.
    pub fn advance_by(&self, set: &dyn Convex, known: f64) -> Option<Advance> {
        let mut reach = [0.0; 3];
        for (reach, &ray) in reach.iter_mut().zip(&self.along) {
            let [enter, leave] = set.along(ray);
            if !(enter <= self.inner && leave > known) {
                return None;
            }
            *reach = leave;
        }
        let advance = self.advance(reach)?;
        let radius = advance.radius.min(set.longest());
        (radius > known).then_some(Advance { radius, ..advance })
    }

    pub fn proves(&self, advance: &Advance, set: &dyn Convex) -> bool {
        let mut ends = self.along.iter().zip(&advance.reach);
        self.along.iter().all(|&ray| set.holds(ray * self.inner))
            && ends.all(|(&ray, &reach)| set.holds(ray * reach))
    }

    /// The new radius of a cone whose rays a convex set contains up to these lengths.
    fn advance(&self, reach: [f64; 3]) -> Option<Advance> {
        let [p, q, r] = reach;
        let (least, most) = (p.min(q).min(r), p.max(q).max(r));
        if !(least > self.cone.radius && most < f64::INFINITY) {
            return None;
        }
        let [p, q, r]: [DVec3; 3] = core::array::from_fn(|i| self.along[i] * (reach[i] / least));
        let normal = (q - p).cross(r - p);
        let area = normal.length();
        // The normal of a steeper plane is too inexact.
        let oblique = if most - least < 8.0 * least * self.cone.inradius {
            least * (normal.dot(p).abs() / area)
        } else {
            0.0
        };
        let straight = least * self.cone.plane;
        let (radius, reach) = if oblique > straight {
            (oblique, reach)
        } else {
            (straight, [least; 3])
        };
        let radius = radius * (1.0 - 4.0 * SHORTENING) - 8.0 * self.rounding;
        let reach = reach.map(|length| length * (1.0 - SHORTENING));
        (radius > self.cone.radius).then_some(Advance { radius, reach })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sets::{Ball, Pair};
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
            let whole = Cone::all_around(0.0);
            let mut cone = *whole.iter().find(|cone| is_in(cone, direction)).unwrap();
            assert!(cone.plane > 0.79);
            while let Some(parts) = cone.split() {
                cone = *parts.iter().find(|part| is_in(part, direction)).unwrap();
                assert!(cone.plane > 0.79 && cone.inradius > 0.0);
            }
            assert!(cone.level == LEVELS && cone.plane > 1.0 - 1e-6);
        }
    }

    /// Up to the new radius the set holds all translations of the cone.
    fn advanced(cone: &Cone, set: &dyn Convex, random: &mut Random) -> Option<f64> {
        let rays = cone.rays(1e-15).unwrap();
        let advance = rays.advance_by(set, cone.radius)?;
        if !rays.proves(&advance, set) {
            return None;
        }
        for _ in 0..20 {
            let shares = [(); 3].map(|()| random.fraction() + 1e-300);
            let direction = unit((0..3).map(|i| cone.directions[i] * shares[i]).sum());
            let length = random.between(cone.radius, advance.radius);
            assert!(set.holds(direction * length), "{cone:?} {direction:?}");
        }
        Some(advance.radius)
    }

    #[test]
    fn a_set_advances_a_cone_as_far_as_it_reaches() {
        let mut random = Random::new(7);
        let (mut by_pair, mut near, mut by_ball) = (0, 0, 0);
        for _ in 0..20_000 {
            let cone = Cone::all_around(0.0)[random.bits() as usize % 32];
            let triangle = |random: &mut Random| [(); 3].map(|()| vector(random));
            let pair = Pair::new([triangle(&mut random), triangle(&mut random)]);
            let radius = 0.9 * pair.margin();
            let cone = Cone { radius, ..cone };
            if radius > 0.01
                && pair.fills_cube(radius)
                && let Some(reached) = advanced(&cone, &pair, &mut random)
            {
                // Somewhere just beyond they part.
                let parts = |d: &DVec3| !pair.holds(d.normalize() * (1.3 * reached));
                by_pair += 1;
                near += usize::from(cone.directions.iter().any(parts));
            }
            let ball = Ball {
                center: vector(&mut random) * 0.5,
                radius: random.between(0.3, 1.0),
                longest: [0.4, f64::INFINITY][random.bits() as usize % 2],
            };
            let radius = random.between(0.01, 0.3);
            let reached = advanced(&Cone { radius, ..cone }, &ball, &mut random);
            assert!(reached.is_none_or(|reached| reached <= ball.longest));
            by_ball += usize::from(reached.is_some());
        }
        assert!(by_pair > 300 && 2 * near > by_pair, "{by_pair} {near}");
        assert!(by_ball > 500, "{by_ball}");
    }

    /// Where roundings are as large as the radius, nothing is claimed.
    #[test]
    fn a_cone_that_is_not_resolved_is_not_advanced() {
        let [cone, ..] = Cone::all_around(1e-12);
        assert!(cone.rays(1e-15).is_some() && cone.rays(1e-13).is_none());
    }
}
