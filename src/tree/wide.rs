//! The wide tree: the binary tree collapsed to nodes of up to eight children, each with a frame of its own.

use super::BuildOptions;
use super::binary::{BinaryTree, CLUSTER};
use super::frame::{self, Extent, Frame};
use super::unit::Triangle;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::ops::Range;
use glam::{Mat3, Vec3};
use wide::f32x4;

/// Children of a node.
pub(crate) const WIDTH: usize = 8;

/// A node of the wide tree, five cache lines. Its children lie one after the other: nodes, or the triangles of a cluster.
///
/// Boxes are centre and half extent in the node's frame, unit coordinates.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// The children's boxes, axis by axis.
    pub center: [[f32; WIDTH]; 3],
    pub half: [[f32; WIDTH]; 3],
    /// The node's own box.
    pub own_center: f32x4,
    pub own_half: f32x4,
    /// Columns are the axes of the frame, unit coordinates of the mesh.
    pub rotation: [f32x4; 3],
    /// Square root of the surface area of the own box.
    pub size: f32,
    /// Equal ids mean equal frames; 0 is the mesh's own.
    pub frame: u32,
    /// First child: a node, or a triangle of a cluster.
    pub first_child: u32,
    /// Triangles of the subtree: `first_triangle..first_triangle + triangles`, in tree order.
    pub first_triangle: u32,
    pub triangles: u32,
    /// First level of the profile.
    pub profile: u32,
    /// Expected BV tests of this subtree against its like ([`super::profile`]).
    pub visits: f32,
    /// End to end alpha, product of the axes.
    pub alpha: f32,
    /// Number of children.
    pub children: u8,
    pub is_cluster: bool,
    /// Steps below the root.
    pub depth: u8,
    /// Levels below this node.
    pub height: u8,
}

const _: () = assert!(size_of::<Node>() == 320);

/// The first three lanes.
pub(crate) fn xyz(v: f32x4) -> [f32; 3] {
    let [x, y, z, _] = v.to_array();
    [x, y, z]
}

impl Node {
    /// One bit for each child that there is.
    #[inline(always)]
    pub fn valid(&self) -> u32 {
        (1 << self.children) - 1
    }

    pub fn rotation(&self) -> Mat3 {
        Mat3::from_cols_array_2d(&self.rotation.map(xyz))
    }

    /// Half extents of the own box.
    pub fn extent(&self) -> Vec3 {
        xyz(self.own_half).into()
    }

    /// The triangles of the subtree, in tree order.
    pub fn triangle_range(&self) -> Range<usize> {
        self.first_triangle as usize..(self.first_triangle + self.triangles) as usize
    }

    fn set_child(&mut self, lane: usize, extent: &Extent) {
        let (center, half) = (extent.center(), extent.half());
        for k in 0..3 {
            self.center[k][lane] = center[k];
            self.half[k][lane] = half[k];
        }
    }

    /// Computes all boxes anew in the node's frame. `children` are the triangle ranges of the children.
    pub fn fit(&mut self, children: &[Range<usize>], triangles: &[Triangle]) {
        let to_frame = glam::Mat3A::from(self.rotation()).transpose();
        let mut own = Extent::EMPTY;
        for (lane, child) in children.iter().enumerate() {
            let extent = Extent::of(&triangles[child.clone()], &to_frame);
            self.set_child(lane, &extent);
            own = own.union(extent);
        }
        self.own_center = f32x4::new(own.center().extend(0.0).to_array());
        self.own_half = f32x4::new(own.half().extend(0.0).to_array());
        self.size = libm::sqrtf(2.0 * own.area());
    }
}

/// Collapses `binary` over `triangles` (tree order). The root is node 0; there is none for an empty mesh.
pub(super) fn collapse(binary: &BinaryTree, triangles: &[Triangle], options: &BuildOptions) -> Vec<Node> {
    let mut builder = Builder { binary, triangles, options, nodes: Vec::new(), frames: 1 };
    if !binary.nodes.is_empty() {
        builder.nodes.reserve(triangles.len() / 4 + 1);
        builder.nodes.push(EMPTY);
        builder.fill(0, 0, 0, Frame::IDENTITY);
    }
    builder.nodes
}

const EMPTY: Node = Node {
    center: [[0.0; WIDTH]; 3],
    half: [[0.0; WIDTH]; 3],
    own_center: f32x4::ZERO,
    own_half: f32x4::ZERO,
    rotation: [f32x4::ZERO; 3],
    size: 0.0,
    frame: 0,
    first_child: 0,
    first_triangle: 0,
    triangles: 0,
    profile: 0,
    visits: 0.0,
    alpha: 1.0,
    children: 0,
    is_cluster: false,
    depth: 0,
    height: 0,
};

struct Builder<'b> {
    binary: &'b BinaryTree,
    triangles: &'b [Triangle],
    options: &'b BuildOptions,
    nodes: Vec<Node>,
    frames: u32,
}

impl Builder<'_> {
    /// Makes the wide node `index` of the binary subtree `root`, and all below it.
    fn fill(&mut self, index: usize, root: u32, depth: u8, parent: Frame) {
        let below = self.children(root);
        let subtree = &self.binary.nodes[root as usize];
        let is_cluster = subtree.children.is_none();
        let ranges: ArrayVec<Range<usize>, WIDTH> = if is_cluster {
            (subtree.first..subtree.first + subtree.count).map(|t| t as usize..t as usize + 1).collect()
        } else {
            below.iter().map(|&child| self.range(child)).collect()
        };
        let frame = if self.options.frames {
            frame::choose(parent, &ranges, self.triangles, self.frames)
        } else {
            Frame::IDENTITY
        };
        self.frames += u32::from(frame.id == self.frames);
        let first_child = if is_cluster { subtree.first } else { self.nodes.len() as u32 };
        let mut node = Node {
            rotation: [frame.rotation.x_axis, frame.rotation.y_axis, frame.rotation.z_axis]
                .map(|x| f32x4::new(x.extend(0.0).to_array())),
            frame: frame.id,
            first_child,
            first_triangle: subtree.first,
            triangles: subtree.count,
            children: ranges.len() as u8,
            is_cluster,
            depth,
            ..EMPTY
        };
        node.fit(&ranges, self.triangles);
        self.nodes[index] = node;
        if !is_cluster {
            self.nodes.extend(below.iter().map(|_| EMPTY));
            for (i, &child) in below.iter().enumerate() {
                self.fill(first_child as usize + i, child, depth + 1, frame);
            }
        }
    }

    fn range(&self, binary: u32) -> Range<usize> {
        let node = &self.binary.nodes[binary as usize];
        node.first as usize..(node.first + node.count) as usize
    }

    /// Up to eight descendants of `root`: the one with the largest box is opened until there are eight, or only clusters.
    fn children(&self, root: u32) -> ArrayVec<u32, WIDTH> {
        let nodes = &self.binary.nodes;
        let mut below = ArrayVec::new();
        below.push(root);
        while below.len() < WIDTH {
            let openable = (0..below.len()).filter(|&i| nodes[below[i] as usize].children.is_some());
            let area = |i: usize| nodes[below[i] as usize].area;
            let Some(widest) = openable.max_by(|&i, &j| area(i).total_cmp(&area(j))) else { break };
            let Some([left, right]) = nodes[below[widest] as usize].children else { break };
            below[widest] = left;
            // Beside its sibling, so that the triangles of a wide node stay in one piece and in order.
            below.insert(widest + 1, right);
        }
        below
    }
}

const _: () = assert!(CLUSTER == WIDTH);
