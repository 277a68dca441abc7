//! The invariants of a tree, checked one by one; for tests and debug builds.

use super::{MAX_HEIGHT, Node, Tree};
use crate::math::tolerance::BOX_ROUNDING;
use core::fmt;
use core::ops::Range;
use glam::{DVec3, Vec3};

/// What is wrong with a tree, and with which node or triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TreeFault {
    /// The clusters do not hold every triangle of the mesh exactly once; the first triangle (input id) at fault.
    Triangle(u32),
    /// The children of this node do not follow one another or do not make up its triangles.
    Children(usize),
    /// A triangle leaves the box of this node, or of one of its children.
    Outside(usize),
    /// The orientation of this node is not a rotation.
    Orientation(usize),
    /// This node lies deeper than a query can follow.
    Depth(usize),
    /// The profile or an alpha of this node is out of its range.
    Profile(usize),
}

impl fmt::Display for TreeFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Triangle(id) => write!(f, "triangle {id} is not in exactly one cluster"),
            Self::Children(node) => write!(f, "the children of node {node} do not make up its triangles"),
            Self::Outside(node) => write!(f, "a triangle leaves a box of node {node}"),
            Self::Orientation(node) => write!(f, "the orientation of node {node} is not a rotation"),
            Self::Depth(node) => write!(f, "node {node} lies too deep"),
            Self::Profile(node) => write!(f, "the profile of node {node} is out of range"),
        }
    }
}

impl core::error::Error for TreeFault {}

pub(super) fn validate(tree: &Tree) -> Result<(), TreeFault> {
    each_once(&tree.ids, tree.mesh.len())?;
    for index in 0..tree.nodes.len() {
        children(tree, index)?;
        boxes(tree, index)?;
        profile(tree, index)?;
    }
    Ok(())
}

/// Whether `ids` are all numbers below `triangles` in some order.
pub(super) fn each_once(ids: &[u32], triangles: usize) -> Result<(), TreeFault> {
    let mut missing = alloc::vec![true; triangles];
    for &id in ids {
        match missing.get_mut(id as usize) {
            Some(missing) if *missing => *missing = false,
            _ => return Err(TreeFault::Triangle(id)),
        }
    }
    missing.iter().position(|&missing| missing).map_or(Ok(()), |id| Err(TreeFault::Triangle(id as u32)))
}

/// The triangles, in tree order, of child `i` of `node`.
fn child_range(tree: &Tree, node: &Node, i: usize) -> Range<usize> {
    let child = node.first_child as usize + i;
    if node.is_cluster { child..child + 1 } else { tree.nodes[child].triangle_range() }
}

fn children(tree: &Tree, index: usize) -> Result<(), TreeFault> {
    let node = &tree.nodes[index];
    let mut next = node.triangle_range().start;
    for i in 0..usize::from(node.children) {
        let range = child_range(tree, node, i);
        if range.start != next || range.is_empty() {
            return Err(TreeFault::Children(index));
        }
        next = range.end;
    }
    if next != node.triangle_range().end || node.children == 0 { Err(TreeFault::Children(index)) } else { Ok(()) }
}

fn boxes(tree: &Tree, index: usize) -> Result<(), TreeFault> {
    let node = &tree.nodes[index];
    if !node.orientation().is_orthonormal() {
        return Err(TreeFault::Orientation(index));
    }
    if usize::from(node.depth) >= MAX_HEIGHT {
        return Err(TreeFault::Depth(index));
    }
    let to_axes = node.rotation().transpose().as_dmat3();
    for i in 0..usize::from(node.children) {
        let lane = |boxes: &[[f32; 8]; 3]| Vec3::from_array([0, 1, 2].map(|k| boxes[k][i])).as_dvec3();
        for triangle in child_range(tree, node, i) {
            for x in tree.mesh.triangle(tree.ids[triangle] as usize) {
                let x = to_axes * ((x - tree.unit.origin) / tree.unit.length());
                let inside = |center: DVec3, half: DVec3| {
                    (x - center).abs().cmple(half + DVec3::splat(f64::from(BOX_ROUNDING))).all()
                };
                let center = Vec3::from(super::xyz(node.own_center)).as_dvec3();
                let own = inside(center, node.extent().as_dvec3());
                if !own || !inside(lane(&node.center), lane(&node.half)) {
                    return Err(TreeFault::Outside(index));
                }
            }
        }
    }
    Ok(())
}

fn profile(tree: &Tree, index: usize) -> Result<(), TreeFault> {
    let subtree = super::Subtree { tree, index };
    let levels = subtree.profile();
    let sane = |level: &super::LevelProfile| {
        level.nodes >= 1.0 && level.half_extent.cmpge(Vec3::ZERO).all() && level.variance.cmpge(Vec3::ZERO).all()
    };
    let alpha = subtree.alpha();
    let in_range = alpha.cmpge(Vec3::ZERO).all() && alpha.cmple(Vec3::ONE).all();
    let counted = levels[0].nodes == f32::from(subtree.node().children);
    if in_range && counted && levels.iter().all(sane) { Ok(()) } else { Err(TreeFault::Profile(index)) }
}
