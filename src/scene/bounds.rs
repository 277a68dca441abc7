//! The box of a body in the scene.

use crate::math::tolerance::{FRAME_ROUNDING, ROUNDING};
use crate::math::{Aabb, Pose};
use crate::tree::Tree;
use glam::{DMat3, DVec3};
use wide::f32x8;

/// Rounding that the box of a body allows for, relative to its distance and size.
///
/// What a query decides is decided in the frame of one body. There and back is one inverse and two products of poses, each
/// entry a sum of at most four products: less than 40 roundings of 2^-53, of magnitudes up to three times those used here.
const MARGIN: f64 = 128.0 * f64::EPSILON;

/// Rounding of the boxes of a tree and of their way into the scene, in units of the tree: a coordinate is a sum of three
/// products, of a column of length 1 and a vector of length sqrt 3 at most, so off by 4 sqrt 3 roundings, twice, and the sum
/// of both by 2 sqrt 3 more; all this is less than 18.
const UNIT_MARGIN: f64 = FRAME_ROUNDING as f64 + 32.0 * ROUNDING as f64;

/// The boxes that a body is made of: those of the children of its tree's root, which fit more closely than the root's own
/// when they are turned. Lanes without a child hold the middle of the mesh's box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    center: [f32x8; 3],
    half: [f32x8; 3],
    /// The frame of the boxes in the mesh's.
    frame: DMat3,
    /// The origin of the boxes in the mesh's frame, and the length of their unit there; 0 for an empty mesh.
    origin: DVec3,
    unit: f64,
    /// The middle of the mesh's box, and its half diagonal.
    middle: DVec3,
    radius: f64,
}

impl Extent {
    pub fn of(tree: &Tree) -> Self {
        let Some(root) = tree.nodes().first() else { return Self::NOTHING };
        let bounds = tree.mesh().aabb();
        let (min, max) = (bounds.min * 0.5, bounds.max * 0.5);
        Self {
            center: [f32x8::new(root.center[0]), f32x8::new(root.center[1]), f32x8::new(root.center[2])],
            half: [f32x8::new(root.half[0]), f32x8::new(root.half[1]), f32x8::new(root.half[2])],
            frame: root.rotation().as_dmat3(),
            origin: tree.unit().origin,
            unit: tree.unit().length(),
            middle: min + max,
            radius: (max - min).length(),
        }
    }

    const NOTHING: Self = Self {
        center: [f32x8::ZERO; 3],
        half: [f32x8::ZERO; 3],
        frame: DMat3::IDENTITY,
        origin: DVec3::ZERO,
        unit: 0.0,
        middle: DVec3::ZERO,
        radius: 0.0,
    };

    /// A box, along the axes of the scene, around the mesh at `pose`; empty if the mesh is.
    pub fn at(&self, pose: &Pose) -> Aabb {
        if self.unit == 0.0 {
            return Aabb::EMPTY;
        }
        let rows = (*pose.rotation() * self.frame).transpose();
        let [x, y, z] = [self.along(rows.x_axis), self.along(rows.y_axis), self.along(rows.z_axis)];
        let origin = pose.transform_point(self.origin);
        let magnitude = self.origin.abs().max_element() + pose.translation().abs().max_element() + 4.0 * self.unit;
        let margin = DVec3::splat(MARGIN * magnitude);
        Aabb {
            min: origin + DVec3::new(x[0], y[0], z[0]) * self.unit - margin,
            max: origin + DVec3::new(x[1], y[1], z[1]) * self.unit + margin,
        }
    }

    /// Least and largest coordinate of all boxes along a direction of their frame.
    #[inline]
    fn along(&self, direction: DVec3) -> [f64; 2] {
        let [x, y, z] = [direction.x, direction.y, direction.z].map(|component| f32x8::splat(component as f32));
        let center = self.center[0] * x + self.center[1] * y + self.center[2] * z;
        let half = self.half[0] * x.abs() + self.half[1] * y.abs() + self.half[2] * z.abs();
        let (low, high) = ((center - half).to_array(), (center + half).to_array());
        let less = |x: f32, y: f32| if x < y { x } else { y };
        let more = |x: f32, y: f32| if x > y { x } else { y };
        [f64::from(across(low, less)) - UNIT_MARGIN, f64::from(across(high, more)) + UNIT_MARGIN]
    }

    /// A box around all of the mesh's way from `from` to `to`, if it turns about the middle of its box while that goes
    /// straight.
    pub fn swept(&self, from: &Pose, to: &Pose) -> Aabb {
        let ends = self.at(from).union(&self.at(to));
        if self.unit == 0.0 || from.rotation() == to.rotation() {
            return ends;
        }
        let radius = DVec3::splat(SPHERE * self.radius);
        let way = [from, to].map(|pose| pose.transform_point(self.middle));
        let around = Aabb::from_points(way.into_iter().flat_map(|center| [center - radius, center + radius]));
        around.union(&ends)
    }
}

/// All lanes taken together, by halves.
#[inline(always)]
fn across([a, b, c, d, e, f, g, h]: [f32; 8], both: impl Fn(f32, f32) -> f32) -> f32 {
    both(both(both(a, e), both(b, f)), both(both(c, g), both(d, h)))
}

/// Radius of the sphere around a mesh over the half diagonal of its box: what poses that are not quite rotations may stretch
/// it by, and rounding.
const SPHERE: f64 = 1.001;
