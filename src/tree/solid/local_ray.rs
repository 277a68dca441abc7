//! A ray in the unit coordinates of a tree, and the boxes that it enters.
//!
//! Local parameters start where the ray approaches the mesh. Their unit is the length of a
//! direction whose largest component is between 1 and 2. So all numbers are near 1, wherever the
//! ray begins. The margin of the boxes covers all rounding: `docs/numerics.md`, "Rays".

use crate::tree::{Node, Unit, WIDTH, power_of_two};
use glam::DVec3;
use punctual_geom::Ray;
use punctual_geom::lanes::{Column, F8, Lanes, per_axis};
use punctual_geom::tolerance::ROUNDING;
use punctual_geom::triangle::ray::Aim;
use punctual_geom::triangle::ray::batch::{LARGEST_PARAMETER, UnitRay};
use wide::f32x4;

/// A ray near a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalRay {
    pub unit_ray: UnitRay,
    /// Only hits between these local parameters matter.
    pub from: f32,
    pub to: f32,
    /// The parameter of the ray is `(entry + local) unit`; `unit` is 0 if everything is in doubt.
    pub entry: f64,
    pub unit: f64,
    /// Error bound of local parameters.
    pub t_error: f64,
    pub margin: f32,
}

/// Roundings of coordinates and boxes (`docs/numerics.md`).
const MARGIN: f32 = 128.0 * ROUNDING;

/// An origin within this distance of the middle of the mesh, along every axis, is used unchanged.
const NEAR: f64 = 2.0;

/// How far the mesh may extend beyond the cube from -1 to 1, including rounding.
const CUBE_MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// Largest error of an origin for which `f32` is useful.
const LARGEST_POSITION_ERROR: f64 = 0.01;

/// Largest radius in units for which `f32` is useful.
const LARGEST_RADIUS: f64 = 1e6;

/// Covers the rounding of a radius to `f32`.
const THICKER: f64 = 1.0 + 1e-6;

/// Least component of a direction.
const LEAST_COMPONENT: f32 = ROUNDING / 64.0;

impl Default for LocalRay {
    fn default() -> Self {
        Self::BLIND
    }
}

impl LocalRay {
    #[inline(always)]
    pub fn new(unit: &Unit, ray: &Ray) -> Self {
        Self::near(unit, ray, 0.0)
    }

    /// The local ray for boxes that are thickened by a radius, in the length unit of the mesh.
    #[inline(always)]
    pub fn near(unit: &Unit, ray: &Ray, radius: f64) -> Self {
        let mut local_ray = Self::BLIND;
        local_ray.follow(unit, ray, radius);
        local_ray
    }

    /// Makes this the local ray of another ray, for boxes thickened by a radius. In place, because
    /// returning one of two cases takes thirty more instructions.
    #[inline(always)]
    pub fn follow(&mut self, unit: &Unit, ray: &Ray, radius: f64) {
        let radius = radius * unit.scale();
        let aim = Aim::new(ray);
        let exponent = unit.exponent - aim.exponent;
        let (origin, direction) = (unit.point(ray.origin()), aim.direction);
        let reach = largest_size(origin);
        let position_error = 8.0 * f64::EPSILON * reach;
        if !(aim.is_plain()
            && exponent.abs() <= 1000
            && position_error <= LARGEST_POSITION_ERROR
            && radius <= LARGEST_RADIUS)
        {
            *self = Self::BLIND;
            return;
        }
        let (unit, per_unit) = (power_of_two(exponent), power_of_two(-exponent));
        let [t_min, t_max] = ray.limits();
        let end = if ray.is_segment() && t_max > 1.0 {
            per_unit
        } else {
            t_max * per_unit
        };
        let (mut entry, mut last) = (0.0, end);
        if reach > NEAR {
            // If a component is 0 and the origin is in a plane of the cube, these are NaN and
            // change nothing.
            let side = DVec3::splat(1.0 + CUBE_MARGIN + 2.0 * position_error + radius * THICKER);
            let inverse = 1.0 / direction;
            let (one, other) = ((-side - origin) * inverse, (side - origin) * inverse);
            entry = later(
                later(later(entry, one.x, other.x), one.y, other.y),
                one.z,
                other.z,
            );
            last = earlier(
                earlier(earlier(last, one.x, other.x), one.y, other.y),
                one.z,
                other.z,
            );
        }
        // All lengths grow with the radius, and so do their roundings.
        let grown = 1.0 + radius;
        let t_error = (1e-6 + 4e-11 * (entry + reach + 4.0)) * grown;
        let largest = LARGEST_PARAMETER * grown as f32;
        let left = last - entry + t_error;
        self.unit_ray.origin = (origin + direction * entry).as_vec3().to_array();
        self.unit_ray.direction = direction.as_vec3().to_array();
        self.unit_ray.position_error = position_error as f32;
        self.from = ((t_min * per_unit - entry - t_error) as f32).clamp(0.0, largest);
        let left = left as f32;
        self.to = if left > 0.0 { left.min(largest) } else { -1.0 };
        (self.entry, self.unit, self.t_error) = (entry, unit, t_error);
        self.margin = (MARGIN + position_error as f32) * grown as f32 + (radius * THICKER) as f32;
    }

    /// A local ray that also covers rays whose origin and direction are off by `position_error`
    /// units.
    pub fn widened(mut self, position_error: f64) -> Self {
        // Parameters are less than 4.
        let position_error = 4.0 * position_error;
        if position_error.is_nan() || position_error > LARGEST_POSITION_ERROR {
            return Self::BLIND;
        }
        self.unit_ray.position_error += position_error as f32;
        self.margin += position_error as f32;
        self.from = 0.0;
        self
    }

    /// For rays out of the range of `f32`: enters every box at once, and every triangle is in
    /// doubt.
    pub const BLIND: Self = Self {
        unit_ray: UnitRay {
            origin: [0.0; 3],
            direction: [1.0; 3],
            position_error: 1e30,
        },
        from: 0.0,
        to: LARGEST_PARAMETER,
        entry: 0.0,
        unit: 0.0,
        t_error: 0.0,
        margin: 1e30,
    };

    /// Lower bound of the ray parameter of hits at or after a local parameter.
    pub fn t(&self, local: f32) -> f64 {
        ((self.entry + f64::from(local) - self.t_error) * self.unit).max(0.0)
    }

    /// From here on, nothing after a hit with this parameter matters.
    #[inline(always)]
    pub fn cut(&mut self, t: f64) {
        if self.unit > 0.0 {
            self.to = self
                .to
                .min((t / self.unit - self.entry + self.t_error) as f32);
        }
    }

    /// The origin, and one over the direction, along the axes of a node's boxes.
    #[inline(always)]
    fn seen(&self, node: &Node) -> [f32x4; 2] {
        let seen = |v: [f32; 3]| {
            let [x, y, z] = per_axis!(k => node.rows[k] * f32x4::splat(v[k]));
            x + y + z
        };
        let direction = seen(self.unit_ray.direction);
        let sizes = direction.abs().fast_max(f32x4::splat(LEAST_COMPONENT));
        [
            seen(self.unit_ray.origin),
            (f32x4::splat(1.0) / sizes).flip_signs(direction),
        ]
    }

    /// The local parameters at which the ray enters the boxes of a node's children, not less than
    /// `entry`, and the mask of those that it enters before `to`.
    #[inline(always)]
    pub fn enter<L: Lanes>(&self, lanes: L, node: &Node, entry: f32) -> ([f32; WIDTH], u32) {
        let [origin, inverse] = self.seen(node);
        let margin = F8::splat(lanes, self.margin);
        let spans = per_axis!(k => {
            let inverse = F8::splat(lanes, inverse.as_array()[k]);
            let middle = (F8::read(lanes, &node.center[k]) - F8::splat(lanes, origin.as_array()[k])) * inverse;
            let half = (F8::read(lanes, &node.half[k]) + margin) * inverse.abs();
            [middle - half, middle + half]
        });
        let enter = spans[0][0]
            .max(spans[1][0])
            .max(spans[2][0])
            .max(F8::splat(lanes, entry.max(self.from)));
        let leave = spans[0][1]
            .min(spans[1][1])
            .min(spans[2][1])
            .min(F8::splat(lanes, self.to));
        (enter.store(), !leave.less(enter).mask() & node.valid())
    }
}

/// The largest absolute value of a component. Compares bits, which are ordered like positive
/// numbers: for other comparisons the compiler generates branches that are hard to predict.
#[inline(always)]
fn largest_size(v: DVec3) -> f64 {
    let [x, y, z] = v.abs().to_array().map(f64::to_bits);
    f64::from_bits(x.max(y).max(z))
}

/// The smaller of two parameters if it is greater than `first`, else `first`: the last of several
/// entries.
#[inline(always)]
fn later(first: f64, one: f64, other: f64) -> f64 {
    let enter = if one < other { one } else { other };
    if enter > first { enter } else { first }
}

/// The greater of two parameters if it is less than `last`, else `last`: the first of several
/// exits.
#[inline(always)]
fn earlier(last: f64, one: f64, other: f64) -> f64 {
    let leave = if one > other { one } else { other };
    if leave < last { leave } else { last }
}
