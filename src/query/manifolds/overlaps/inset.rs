//! Body B drawn in: each face moves inward by a length above all rounding and below all that
//! matters.
//!
//! Faces that lie in one plane, and edges and corners that lie on a surface, have no curves of
//! their own and no side. Drawn in, coincident faces part: those that face each other are apart,
//! those that look the same way have B's behind A's. So touching bodies are apart, bodies that are
//! sunk beside flush sides have one curve, and nothing depends on the rounding of a pose. Only
//! manifolds are made from it; whether the surfaces meet is decided on B itself.

use super::Marks;
use crate::query::contacts::contact::face_normal;
use crate::query::manifolds::manifold::{Shape, around};
use crate::tree::solid::inside::{Probe, crossings_of};
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use glam::{DMat3, DVec3};
use punctual_geom::{Pose, largest};

/// Distance by which a face moves, relative to the largest coordinate: 2^-42, a thousand roundings.
const STEP: f64 = 2.273_736_754_432_320_6e-13;

/// A vertex moves by less than this many steps.
const REACH: f64 = 5.0;

/// A part of the step, in a direction along which few meshes have edges or faces: so edges within
/// one plane part too.
const ASIDE: DVec3 = DVec3::new(0.577 / 64.0, 0.701 / 64.0, -0.413 / 64.0);

/// Cosine of the angle up to which two faces have one normal.
const ONE_NORMAL: f64 = 1.0 - 1e-6;

/// The longest way of a vertex, in steps, by which its faces move by one step.
const LONGEST: f64 = 4.5;

/// B drawn in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inset {
    /// Distance by which a face moves.
    pub step: f64,
    /// The index of a vertex of B in `offsets`.
    known: Marks,
    /// The ways of vertices: the vectors by which they move, in A's frame.
    offsets: Vec<DVec3>,
}

impl Inset {
    /// An upper bound of the length of a vertex's way.
    pub fn reach(&self) -> f64 {
        REACH * self.step
    }

    pub fn begin(&mut self, shape: Shape) {
        self.step = step(shape);
        self.offsets.clear();
    }

    pub fn reserve(&mut self, vertices: usize) {
        super::reserve(&mut self.known.values, vertices);
        super::reserve(&mut self.offsets, vertices);
    }

    /// Finds the way of one corner of a triangle of B (tree order) that has none yet. False if all
    /// have theirs.
    pub fn learn(&mut self, shape: Shape, triangle: u32) -> bool {
        let tree = shape.trees[1];
        if self.offsets.is_empty() {
            let vertices = tree.mesh().vertex_count();
            self.known.begin(vertices, vertices);
        }
        let mut vertices = tree.vertices_of(triangle).into_iter();
        let Some(vertex) = vertices.find(|&vertex| self.known.get(vertex).is_none()) else {
            return false;
        };
        let way = *shape.b_in_a.rotation() * inward(shape, triangle, vertex) + ASIDE;
        self.known.set(vertex, self.offsets.len() as u32);
        self.offsets.push(self.step * way);
        true
    }

    /// The way of a vertex of B, in A's frame. Zero as long as it is unknown: then no triangle
    /// around it is as near to A as it would be drawn in.
    fn offset(&self, vertex: u32) -> DVec3 {
        let mut known = Some(vertex).filter(|_| !self.offsets.is_empty());
        known = known.and_then(|vertex| self.known.get(vertex));
        known.map_or(DVec3::ZERO, |known| self.offsets[known as usize])
    }

    /// A vertex of one side, in A's frame: of B drawn in.
    pub fn place(&self, shape: Shape, side: usize, vertex: u32) -> DVec3 {
        let place = shape.place(side, vertex);
        if side == 0 {
            place
        } else {
            place + self.offset(vertex)
        }
    }

    /// The corners of a triangle (tree order) of B drawn in, in A's frame, and their ways.
    pub fn corners(&self, shape: Shape, triangle: u32) -> [[DVec3; 3]; 2] {
        let vertices = shape.trees[1].vertices_of(triangle);
        let ways = vertices.map(|vertex| self.offset(vertex));
        let [p, q, r] = shape.corners(1, triangle);
        [[p + ways[0], q + ways[1], r + ways[2]], ways]
    }

    /// True if a point of A is inside B drawn in, which is closed.
    pub fn holds(&self, shape: Shape, to_b: &Pose, point: DVec3) -> bool {
        let tree = shape.trees[1];
        let point = to_b.transform_point(point);
        let probe = Probe::new(tree, point).widened(tree, self.reach());
        let drawn_in = |triangle| {
            let (vertices, corners) = (tree.vertices_of(triangle), tree.corners(triangle));
            [0, 1, 2].map(|i| {
                let way = self.offset(vertices[i]);
                corners[i] + *to_b.rotation() * way
            })
        };
        crossings_of(tree, probe, drawn_in).is_inside()
    }
}

/// Distance by which the faces of B move.
fn step(shape: Shape) -> f64 {
    if shape.trees.iter().any(|tree| tree.nodes().is_empty()) {
        return 0.0;
    }
    let [of_a, of_b] = shape.trees.map(|tree| {
        let bounds = tree.mesh().aabb();
        largest(bounds.min.abs().max(bounds.max.abs()))
    });
    STEP * of_a.max(largest(shape.b_in_a.translation().abs()) + 2.0 * of_b)
}

/// An upper bound of the length of the way of a vertex of B.
pub(crate) fn reach(shape: Shape) -> f64 {
    REACH * step(shape)
}

/// The way of a vertex of B by which its faces move inward by one step, in B's frame: exact if they
/// have up to three normals, else about so.
fn inward(shape: Shape, triangle: u32, vertex: u32) -> DVec3 {
    let tree = shape.trees[1];
    let (mut normals, mut sum, mut more) = (ArrayVec::<DVec3, 3>::new(), DVec3::ZERO, false);
    let mut add = |triangle: u32| {
        if let Some(normal) = face_normal(&tree.corners(triangle)) {
            sum += normal;
            if normals.iter().all(|known| known.dot(normal) < ONE_NORMAL) {
                more |= normals.try_push(normal).is_err();
            }
        }
        false
    };
    add(triangle);
    around(tree, triangle, vertex, add);
    let way = match normals[..] {
        _ if more => DVec3::NAN,
        [m] => m,
        [m, n] => (m + n) / (1.0 + m.dot(n)),
        [m, n, o] => {
            let across = DMat3::from_cols(n.cross(o), o.cross(m), m.cross(n));
            across * DVec3::ONE / m.dot(across.x_axis)
        }
        _ => DVec3::ZERO,
    };
    // Also false for NaN.
    if way.length_squared() <= LONGEST * LONGEST {
        -way
    } else {
        -sum.normalize_or_zero()
    }
}
