//! Where B lies in A: once for a query, and once more for the frames of every two nodes.

use crate::math::Pose;
use crate::math::pose::rotation_deviation;
use crate::math::tolerance::ROUNDING;
use crate::tree::{Node, Tree, power_of_two};
use crate::triangle::batch::{EDGE_SLOP, Placement};
use glam::{DVec3, Mat3, Vec3};

/// B's place in A, in the unit coordinates of both, with bounds on all rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Relation {
    rotation: Mat3,
    /// Length of B's unit in A's: a power of two.
    pub scale: f32,
    translation: Vec3,
    /// What a box test of two nodes must allow for, in A's units and in B's.
    pub margin: [f32; 2],
    /// The same for a direction, of either side, relative to its length.
    pub skew: f32,
    pub triangles: Placement,
}

/// Ratios of the units of two meshes beyond which every box counts as overlapping: products of three lengths must stay
/// within the range of `f32`.
const LARGEST_SCALE: i32 = 30;

impl Relation {
    pub fn new(a: &Tree, b: &Tree, b_in_a: &Pose) -> Self {
        let (ua, ub) = (a.unit(), b.unit());
        let exponent = ub.exponent - ua.exponent;
        let per_unit = power_of_two(-ua.exponent);
        let translation = (b_in_a.transform_point(ub.origin) - ua.origin) * per_unit;
        // Rounding of the pose as it is defined (DESIGN: v' = R v + t in f64) and of the line above, and twice that.
        let reach = |v: DVec3| v.abs().max_element();
        let magnitude = reach(ua.origin) + 6.0 * reach(ub.origin) + reach(b_in_a.translation()) + 8.0 * ub.length();
        let scale = power_of_two(exponent.clamp(-1000, 1000));
        let slop = (magnitude * f64::EPSILON * 8.0) * per_unit + (1.0 + scale) * power_of_two(-43) + 1e-20;
        let deviation = rotation_deviation(b_in_a.rotation());

        let distance = translation.length();
        let u = f64::from(ROUNDING);
        let margin_a = u * (32.0 + 192.0 * scale + 32.0 * distance) + slop;
        let margin_b = (u * (192.0 + 32.0 * scale + 32.0 * distance) + slop) / scale + 8.0 * deviation;
        if exponent.abs() > LARGEST_SCALE || !(margin_a < 1e6 && margin_b < 1e6) {
            return Self::BLIND;
        }
        let rows = b_in_a.rotation().transpose();
        let linear = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| (row * scale).to_array());
        Self {
            rotation: b_in_a.rotation().as_mat3(),
            scale: scale as f32,
            translation: translation.as_vec3(),
            margin: [margin_a as f32, margin_b as f32],
            skew: 64.0 * ROUNDING + 8.0 * deviation as f32,
            triangles: Placement {
                linear,
                translation: translation.to_array(),
                slop: slop as f32,
                edge_slop: 8.0 * EDGE_SLOP * scale as f32,
            },
        }
    }

    /// For what `f32` cannot hold: every box overlaps and every triangle pair is in doubt.
    const BLIND: Self = Self {
        rotation: Mat3::ZERO,
        scale: 1.0,
        translation: Vec3::ZERO,
        margin: [1e6; 2],
        skew: 1.0,
        triangles: Placement { linear: [[0.0; 3]; 3], translation: [0.0; 3], slop: 1e6, edge_slop: 1e6 },
    };
}

/// The map between the frames of a node of A and one of B, `x = to_a y + offset` and `y = to_b (x - offset)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    ids: [u32; 2],
    pub to_a: [[f32; 3]; 3],
    pub to_b: [[f32; 3]; 3],
    pub offset: [f32; 3],
}

impl Frames {
    /// No frames yet: the first call of [`Frames::update`] computes them.
    pub const UNKNOWN: Self = Self { ids: [u32::MAX; 2], to_a: [[0.0; 3]; 3], to_b: [[0.0; 3]; 3], offset: [0.0; 3] };

    /// Makes these the frames of `a` and `b`; `None` stands for the mesh's own.
    #[inline(always)]
    pub fn update(&mut self, a: Option<&Node>, b: Option<&Node>, relation: &Relation) {
        let ids = [a, b].map(|node| node.map_or(0, |node| node.frame));
        if ids != self.ids {
            *self = Self::between(a, b, relation, ids);
        }
    }

    #[inline(always)]
    fn between(a: Option<&Node>, b: Option<&Node>, relation: &Relation, ids: [u32; 2]) -> Self {
        let (mut m, mut offset) = (relation.rotation, relation.translation);
        if let Some(b) = b {
            m *= b.rotation;
        }
        if let Some(a) = a {
            let to_frame = a.rotation.transpose();
            m = to_frame * m;
            offset = to_frame * offset;
        }
        let rows = |m: Mat3| m.transpose().to_cols_array_2d();
        Self {
            ids,
            to_a: rows(m * relation.scale),
            to_b: rows(m.transpose() * (1.0 / relation.scale)),
            offset: offset.to_array(),
        }
    }
}
