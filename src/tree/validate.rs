//! Checks the invariants of a tree, one by one.

use super::build::binary::{CLUSTER, most_depth};
use super::fit::alpha::log_alpha;
use super::fit::profile::LevelProfile;
use super::wide::{WIDTH, lane};
use super::{Node, Tree};
use core::fmt;
use core::ops::Range;
use glam::{DVec3, Vec3};
use punctual_geom::tolerance::BOX_ROUNDING;
use wide::f32x4;

/// The fault of a tree, and the node or triangle that has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TreeFault {
    /// The leaves do not contain every triangle of the mesh exactly once. This is the input id of
    /// the first triangle at fault.
    Triangle(u32),
    /// The children of this node are not contiguous or do not make up its triangles.
    Children(usize),
    /// A triangle extends beyond the box of this node, or of one of its children.
    Outside(usize),
    /// The orientation of this node is not a rotation.
    Orientation(usize),
    /// This node is deeper than any in a tree built of as many triangles.
    Depth(usize),
    /// This node has fewer children, or the leaves below it have fewer triangles, than in a tree
    /// that was built.
    Sparse(usize),
    /// The profile or an alpha of this node is out of its range.
    Profile(usize),
}

impl fmt::Display for TreeFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Triangle(id) => write!(f, "triangle {id} is not in exactly one leaf"),
            Self::Children(node) => write!(
                f,
                "the children of node {node} do not make up its triangles"
            ),
            Self::Outside(node) => write!(f, "a triangle leaves a box of node {node}"),
            Self::Orientation(node) => {
                write!(f, "the orientation of node {node} is not a rotation")
            }
            Self::Depth(node) => write!(f, "node {node} lies too deep"),
            Self::Sparse(node) => write!(f, "node {node} has too few children or triangles"),
            Self::Profile(node) => write!(f, "the profile of node {node} is out of range"),
        }
    }
}

impl core::error::Error for TreeFault {}

pub(super) fn validate(tree: &Tree) -> Result<(), TreeFault> {
    each_once(&tree.ids, tree.mesh.len())?;
    if !tree.is_cloud() {
        dense(&tree.nodes)?;
    }
    for index in 0..tree.nodes.len() {
        children(tree, index)?;
        boxes(tree, index)?;
        profile(tree, index)?;
    }
    Ok(())
}

/// Checks that `ids` are all numbers below `triangles`, in any order.
pub(super) fn each_once(ids: &[u32], triangles: usize) -> Result<(), TreeFault> {
    let mut missing = alloc::vec![true; triangles];
    for &id in ids {
        match missing.get_mut(id as usize) {
            Some(missing) if *missing => *missing = false,
            _ => return Err(TreeFault::Triangle(id)),
        }
    }
    missing
        .iter()
        .position(|&missing| missing)
        .map_or(Ok(()), |id| Err(TreeFault::Triangle(id as u32)))
}

/// Checks that there are no more nodes than a build makes of as many triangles: at most 8 nodes per
/// 7 triangles, and at most 1 inner node per 7 triangles.
///
/// A build splits only nodes of more than [`CLUSTER`] triangles. So an inner node has at least 7
/// more triangles than leaves. A build opens nodes until there are [`WIDTH`] children. So an
/// inner node with fewer has only leaves. Take `t` triangles, `c` leaves, `a` inner nodes that
/// have 8 children and `b` others. Each of these `b` has at least 7 more triangles than leaves,
/// so `c <= t - 7 b`. Every node but the root is a child, so `8 a + 2 b <= a + b + c - 1`. Hence
/// `7 (a + b) < t` and `7 (a + b + c) < 8 t`.
pub(super) fn dense(nodes: &[Node]) -> Result<(), TreeFault> {
    let mut leaves = alloc::vec![1; nodes.len()];
    for (index, node) in nodes
        .iter()
        .enumerate()
        .rev()
        .filter(|(_, node)| !node.is_leaf)
    {
        let children = node.child_range();
        let only_leaves = nodes[children.clone()].iter().all(|child| child.is_leaf);
        leaves[index] = leaves[children.clone()].iter().sum::<usize>();
        if (children.len() < WIDTH && !only_leaves)
            || leaves[index] + CLUSTER > node.triangles as usize + 1
        {
            return Err(TreeFault::Sparse(index));
        }
    }
    Ok(())
}

/// The triangles, in tree order, of child `i` of `node`.
fn child_range(tree: &Tree, node: &Node, i: usize) -> Range<usize> {
    let child = node.first_child as usize + i;
    if node.is_leaf {
        child..child + 1
    } else if let Some(child) = tree.nodes.get(child) {
        child.triangle_range()
    } else {
        let Range { start, end } = tree.block(child as u32);
        start as usize..end as usize
    }
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
    if next != node.triangle_range().end || node.children == 0 {
        Err(TreeFault::Children(index))
    } else {
        Ok(())
    }
}

fn boxes(tree: &Tree, index: usize) -> Result<(), TreeFault> {
    let node = &tree.nodes[index];
    if !node.orientation().is_orthonormal() {
        return Err(TreeFault::Orientation(index));
    }
    if u32::from(node.depth) > most_depth(tree.mesh.len()) {
        return Err(TreeFault::Depth(index));
    }
    let to_axes = node.rotation().transpose().as_dmat3();
    for i in 0..usize::from(node.children) {
        let of_child = |all: &[[f32x4; 2]; 3]| {
            Vec3::from_array([0, 1, 2].map(|k| lane(&all[k], i))).as_dvec3()
        };
        for triangle in child_range(tree, node, i) {
            for x in tree.mesh.triangle(tree.ids[triangle] as usize) {
                let x = to_axes * ((x - tree.unit.origin) / tree.unit.length());
                let inside = |center: DVec3, half: DVec3| {
                    (x - center)
                        .abs()
                        .cmple(half + DVec3::splat(f64::from(BOX_ROUNDING)))
                        .all()
                };
                let center = Vec3::from(super::xyz(node.own_center)).as_dvec3();
                let own = inside(center, node.extent().as_dvec3());
                if !own || !inside(of_child(&node.center), of_child(&node.half)) {
                    return Err(TreeFault::Outside(index));
                }
            }
        }
    }
    Ok(())
}

fn profile(tree: &Tree, index: usize) -> Result<(), TreeFault> {
    let subtree = super::Subtree { tree, index };
    let node = subtree.node();
    let (levels, triangles) = tree.profiles.of(node);
    let sane =
        |level: &LevelProfile| level.nodes >= 1.0 && level.half_extent.cmpge(Vec3::ZERO).all();
    let alpha = subtree.alpha();
    let in_range = alpha.cmpge(Vec3::ZERO).all() && alpha.cmple(Vec3::ONE).all();
    let stored = log_alpha(triangles.half_extent, node.extent(), node.levels) == node.log_alpha;
    let counted = levels[0].nodes == f32::from(node.children);
    if in_range && stored && counted && levels.iter().all(sane) {
        Ok(())
    } else {
        Err(TreeFault::Profile(index))
    }
}
