//! A node of the wide tree: up to eight children and an orientation.

use super::build::orientation::Orientation;
use core::ops::Range;
use glam::{Mat3, Mat3A, Vec3};
use wide::f32x4;

/// Maximum number of children of a node.
pub(crate) const WIDTH: usize = 8;

/// Maximum number of levels of nodes: [`super::build::binary`] keeps trees of 2^30 triangles to
/// a depth of 70.
pub(crate) const MAX_HEIGHT: usize = 71;

/// A node of the wide tree, five cache lines. Its children are adjacent: nodes, or the triangles of
/// a leaf.
///
/// Boxes are stored as center and half extent along the node's own axes, in unit coordinates.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// The children's boxes by axis, in halves ([`punctual_geom::lanes::F8::read`]).
    pub center: [[f32x4; 2]; 3],
    pub half: [[f32x4; 2]; 3],
    /// The orientation as a matrix, row by row. Its columns are the axes of the boxes, in unit
    /// coordinates of the mesh.
    pub rows: [f32x4; 3],
    /// Index of the first child: a node, or a triangle of a leaf.
    pub first_child: u32,
    /// Triangles of the subtree: `first_triangle..first_triangle + triangles`, in tree order.
    pub first_triangle: u32,
    pub triangles: u32,
    /// Number of children.
    pub children: u8,
    pub is_leaf: bool,
    /// Number of steps below the root.
    pub depth: u8,
    /// Number of levels of boxes below this node.
    pub height: u8,
    /// Center and half extent of the box around the whole subtree.
    pub own_center: f32x4,
    pub own_half: f32x4,
    /// Square root of the surface area of that box.
    pub size: f32,
    /// Id of the orientation: equal ids mean equal orientations, 0 means the axes of the mesh.
    pub orientation: u32,
    /// Index of the first level of the profile.
    pub profile: u32,
    /// Expected BV tests of this subtree against a copy of itself ([`super::fit::profile`]).
    pub self_cost: f32,
    /// log2 of the product of the three diminishing factors `alpha` ([`super::fit::alpha`]): from
    /// one binary level to the next, volumes shrink by this power of two. 0 if nothing shrinks.
    pub log_alpha: f32,
    /// Number of binary levels below this node: log2 of its triangles.
    pub levels: f32,
    /// Middle extent of the own box divided by the longest; 1 for a point.
    pub slimness: f32,
}

const _: () = assert!(size_of::<Node>() == 320);

/// Lane `i` of eight.
#[inline(always)]
pub(crate) fn lane(v: &[f32x4; 2], i: usize) -> f32 {
    v[i / 4].as_array()[i % 4]
}

/// The first three lanes.
#[inline(always)]
pub(crate) fn xyz(v: f32x4) -> [f32; 3] {
    let [x, y, z, _] = v.to_array();
    [x, y, z]
}

impl Node {
    /// Bit mask of the children that exist.
    #[inline(always)]
    pub fn valid(&self) -> u32 {
        (1 << self.children) - 1
    }

    pub fn rotation(&self) -> Mat3 {
        Mat3::from_cols_array_2d(&self.rows.map(xyz)).transpose()
    }

    /// Half extents of the own box.
    pub fn extent(&self) -> Vec3 {
        xyz(self.own_half).into()
    }

    /// The triangles of the subtree, in tree order.
    pub fn triangle_range(&self) -> Range<usize> {
        self.first_triangle as usize..(self.first_triangle + self.triangles) as usize
    }

    /// Indices of the children: nodes, or triangles of a leaf.
    #[inline(always)]
    pub(super) fn child_range(&self) -> Range<usize> {
        self.first_child as usize..self.first_child as usize + usize::from(self.children)
    }

    /// Indices of the children of an inner node; none for a leaf.
    pub(super) fn nodes_below(&self) -> Range<usize> {
        if self.is_leaf {
            0..0
        } else {
            self.child_range()
        }
    }

    /// The columns of the rotation.
    #[inline(always)]
    pub(super) fn axes(&self) -> Mat3A {
        let [x, y, z] = self.rows;
        Mat3A::from_cols(xyz(x).into(), xyz(y).into(), xyz(z).into()).transpose()
    }

    pub(super) fn orientation(&self) -> Orientation {
        Orientation {
            rotation: self.axes(),
            id: self.orientation,
        }
    }

    pub(super) fn set_orientation(&mut self, orientation: &Orientation) {
        let m = orientation.rotation.transpose();
        self.rows =
            [m.x_axis, m.y_axis, m.z_axis].map(|axis| f32x4::new(axis.extend(0.0).to_array()));
        self.orientation = orientation.id;
    }
}
