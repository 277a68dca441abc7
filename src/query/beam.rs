//! A ray in the unit coordinates of a tree, and which boxes it enters.
//!
//! Parameters count here from where the ray comes to the mesh, in the length of a direction whose largest component is within 1
//! and 2. So all numbers are near 1, wherever the ray begins. A bound on all rounding is in the margin of the boxes:
//! `docs/numerics.md`, "Rays".

use super::views::{times, transposed};
use crate::math::lanes::{F8, Lanes, per_axis};
use crate::math::tolerance::ROUNDING;
use crate::tree::{Node, Unit, WIDTH, power_of_two, xyz};
use crate::triangle::ray::Aim;
use crate::triangle::ray::batch::{LARGEST_PARAMETER, Shaft};
use glam::DVec3;
use wide::f32x4;

/// A ray near a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    pub shaft: Shaft,
    /// Nothing before this parameter matters, and nothing after the other.
    pub from: f32,
    pub to: f32,
    /// The parameter of the ray where this one counts from, and what one of its units is of this one; both in units of the mesh.
    entry: f64,
    unit: f64,
    /// How well a parameter that is told is known here.
    slack: f64,
    margin: f32,
    /// As seen from the boxes of nodes with this orientation: the origin, and one over the direction.
    orientation: u32,
    origin: [f32; 3],
    inverse: [f32; 3],
}

/// Roundings of coordinates and boxes (`docs/numerics.md`).
const MARGIN: f32 = 96.0 * ROUNDING;

/// How far the mesh may leave the cube from -1 to 1, with room for rounding.
const CUBE_MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// The most that an origin may be off for `f32` to be of use.
const LARGEST_SLOP: f64 = 0.01;

/// The least component of a direction.
const LEAST_COMPONENT: f32 = ROUNDING / 64.0;

impl Beam {
    #[inline]
    pub fn new(unit: &Unit, aim: &Aim) -> Self {
        let exponent = unit.exponent - aim.exponent;
        let (origin, direction) = (unit.point(aim.ray().origin()), aim.direction);
        let reach = origin.abs().max_element();
        let slop = 8.0 * f64::EPSILON * reach;
        if !(aim.is_plain() && exponent.abs() <= 1000 && slop <= LARGEST_SLOP) {
            return Self::BLIND;
        }
        // A component of 0 makes these infinite; where it makes no number of them, the other one tells.
        let side = 1.0 + CUBE_MARGIN + 2.0 * slop;
        let (near, far) = ((DVec3::splat(-side) - origin) / direction, (DVec3::splat(side) - origin) / direction);
        let first = near.x.min(far.x).max(near.y.min(far.y)).max(near.z.min(far.z));
        let last = near.x.max(far.x).min(near.y.max(far.y)).min(near.z.max(far.z));
        let entry = first.max(0.0);
        let mut beam = Self {
            shaft: Shaft {
                origin: (origin + direction * entry).as_vec3().to_array(),
                direction: direction.as_vec3().to_array(),
                slop: slop as f32,
            },
            from: 0.0,
            to: LARGEST_PARAMETER,
            entry,
            unit: power_of_two(exponent),
            slack: 1e-6 + 4e-11 * (entry + reach + 4.0),
            margin: MARGIN + slop as f32,
            ..Self::BLIND
        };
        let [t_min, t_max] = aim.ray().limits();
        let t_max = if aim.ray().is_segment() { t_max.min(1.0) } else { t_max };
        let last = last.min(t_max / beam.unit) - entry + beam.slack;
        beam.to = if last >= 0.0 { last.min(f64::from(LARGEST_PARAMETER)) as f32 } else { -1.0 };
        beam.from = ((t_min / beam.unit - entry - beam.slack) as f32).clamp(0.0, LARGEST_PARAMETER);
        beam.turn([f32x4::ZERO; 3], 0);
        beam
    }

    /// For what `f32` cannot hold: every box is entered at once and every triangle is in doubt.
    const BLIND: Self = Self {
        shaft: Shaft { origin: [0.0; 3], direction: [1.0; 3], slop: 1e30 },
        from: 0.0,
        to: LARGEST_PARAMETER,
        entry: 0.0,
        unit: 0.0,
        slack: 0.0,
        margin: 1e30,
        orientation: 0,
        origin: [0.0; 3],
        inverse: [1.0; 3],
    };

    /// The parameter of the ray that is certainly not after one here.
    pub fn t(&self, local: f32) -> f64 {
        ((self.entry + f64::from(local) - self.slack) * self.unit).max(0.0)
    }

    /// From now on nothing after a hit with this parameter matters.
    #[inline(always)]
    pub fn cut(&mut self, t: f64) {
        if self.unit > 0.0 {
            self.to = self.to.min((t / self.unit - self.entry + self.slack) as f32);
        }
    }

    #[inline(always)]
    fn turn(&mut self, rotation: [f32x4; 3], orientation: u32) {
        if self.unit == 0.0 {
            return;
        }
        let Shaft { origin: [x, y, z], direction: [u, v, w], .. } = self.shaft;
        let (mut origin, mut direction) = (f32x4::new([x, y, z, 0.0]), f32x4::new([u, v, w, 1.0]));
        if orientation != 0 {
            let rows = transposed(rotation);
            (origin, direction) = (times(&rows, origin), times(&rows, direction));
        }
        let sizes = direction.abs().fast_max(f32x4::splat(LEAST_COMPONENT));
        let (sizes, direction) = ((f32x4::splat(1.0) / sizes).to_array(), direction.to_array());
        self.origin = xyz(origin);
        self.inverse = per_axis!(k => sizes[k].copysign(direction[k]));
        self.orientation = orientation;
    }

    /// Where it enters the boxes of a node's children, no earlier than the node, and which of them it enters before `to`, a bit
    /// for each.
    #[inline(always)]
    pub fn enter<L: Lanes>(&mut self, lanes: L, node: &Node, entry: f32) -> ([f32; WIDTH], u32) {
        if node.orientation != self.orientation {
            self.turn(node.rotation, node.orientation);
        }
        let margin = F8::splat(lanes, self.margin);
        let spans = per_axis!(k => {
            let inverse = F8::splat(lanes, self.inverse[k]);
            let middle = (F8::load(lanes, &node.center[k]) - F8::splat(lanes, self.origin[k])) * inverse;
            let half = (F8::load(lanes, &node.half[k]) + margin) * inverse.abs();
            [middle - half, middle + half]
        });
        let enter = spans[0][0].max(spans[1][0]).max(spans[2][0]).max(F8::splat(lanes, entry.max(self.from)));
        let leave = spans[0][1].min(spans[1][1]).min(spans[2][1]).min(F8::splat(lanes, self.to));
        (enter.store(), !leave.less(enter).mask() & node.valid())
    }
}
