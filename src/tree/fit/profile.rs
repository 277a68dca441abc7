//! The profile of a subtree, level by level: the input of the cost model
//! ([`visits`](crate::model::visits)).
//!
//! All values are measured along the axes of the subtree's root: a box with half extents `e` and
//! axes `Q` counts as `|Q| e`. Levels are merged bottom-up from those of the children, one child
//! per lane, in `O(nodes * height)`.

use super::alpha::log_alpha;
use crate::model::visits::{Level, visits};
use crate::tree::wide::Node;
use alloc::boxed::Box;
use core::ops::Range;
use glam::{Vec3, Vec3A};
use punctual_geom::lanes::{Column, F8, Lanes, V8, dot, per_axis, per_lane, sums};

/// The boxes of one level of a subtree, counted down from its root. Values are along the axes of
/// the root, in unit coordinates.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct LevelProfile {
    /// Number of boxes.
    pub nodes: f32,
    /// Mean half extent of the boxes.
    pub half_extent: Vec3,
}

impl LevelProfile {
    /// Profile of the level of `node`'s children, whose boxes have the half extents `half`, and the
    /// sum of their surface areas. Missing boxes have half extents of zero.
    #[inline(always)]
    fn of_children<L: Lanes>(node: &Node, half: &V8<L>) -> (Self, f32) {
        let [x, y, z] = *half;
        let [hx, hy, hz, area] = sums([x, y, z, x * y + y * z + z * x]);
        let level = Self::of_sums(node.children.into(), [hx, hy, hz]);
        (level, 8.0 * area)
    }

    /// A level from the sum of the half extents of its `nodes` boxes.
    #[inline(always)]
    fn of_sums(nodes: f32, half: [f32; 3]) -> Self {
        Self {
            nodes,
            half_extent: (Vec3A::from(half) * (1.0 / nodes)).into(),
        }
    }
}

/// The profiles of all subtrees: node `i` has levels `nodes[i].profile..`, as many as its height,
/// and one more for its triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Profiles {
    pub levels: Box<[LevelProfile]>,
    /// SAH cost: the sum of the surface areas of all boxes, including those of triangles, divided
    /// by the surface area of the root's box; 0 if the root has no area.
    pub cost: f32,
}

impl Profiles {
    /// Makes room for the profiles of `nodes`, which are not measured yet. Writes `height` and
    /// `profile` into the nodes.
    pub fn room(nodes: &mut [Node]) -> Self {
        let mut levels = 0;
        for index in (0..nodes.len()).rev() {
            let (node, later) = nodes[index..]
                .split_first_mut()
                .expect("index is within the nodes");
            let below = node.nodes_below();
            // Leaves of points are not stored.
            let of_points = u8::from(below.start > index + later.len());
            let below = later.get(below.start.saturating_sub(index + 1)..);
            let count = node.nodes_below().len() * usize::from(of_points == 0);
            let below = &below.unwrap_or_default()[..count];
            node.height = 1 + below
                .iter()
                .map(|child| child.height)
                .max()
                .unwrap_or(of_points);
            node.profile = levels as u32;
            node.levels = libm::log2f(node.triangles as f32);
            levels += usize::from(node.height) + 1;
        }
        Self {
            levels: alloc::vec![LevelProfile::default(); levels].into(),
            cost: 0.0,
        }
    }

    /// Range of the levels that belong to `nodes`, which are adjacent.
    pub fn range(nodes: &[Node]) -> Range<usize> {
        let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else {
            return 0..0;
        };
        last.profile as usize..first.profile as usize + usize::from(first.height) + 1
    }

    /// The levels of boxes below a node, and then all its triangles as one level, whatever their
    /// depth.
    pub fn of(&self, node: &Node) -> (&[LevelProfile], &LevelProfile) {
        let levels = &self.levels[node.profile as usize..];
        let (levels, triangles) = levels.split_at(node.height.into());
        (levels, &triangles[0])
    }
}

/// The levels of some subtrees, from number `first` on.
pub(crate) struct Levels<'l> {
    pub levels: &'l mut [LevelProfile],
    pub first: usize,
}

impl Levels<'_> {
    /// Measures a leaf. The boxes of its triangles have the half extents `half`. Returns the sum of
    /// their surface areas.
    #[inline(always)]
    pub fn measure_leaf<L: Lanes>(&mut self, node: &mut Node, half: &V8<L>) -> f32 {
        let (level, area) = LevelProfile::of_children(node, half);
        let at = node.profile as usize - self.first;
        self.levels[at..at + 2].fill(level);
        node.log_alpha = log_alpha(level.half_extent, node.extent(), node.levels);
        node.self_cost = level.nodes * level.nodes;
        area
    }

    /// Measures a node of a cloud whose children are blocks. Returns the sum of the surface areas
    /// of their boxes.
    #[inline(always)]
    pub fn measure_blocks<L: Lanes>(
        &mut self,
        lanes: L,
        node: &mut Node,
        own_half: [f32; 3],
    ) -> f32 {
        let half = per_axis!(k => F8::read(lanes, &node.half[k]));
        let (level, area) = LevelProfile::of_children(node, &half);
        let points = LevelProfile::of_sums(node.triangles as f32, [0.0; 3]);
        let at = node.profile as usize - self.first;
        self.levels[at..at + 3].copy_from_slice(&[level, points, points]);
        node.log_alpha = log_alpha(Vec3::ZERO, own_half.into(), node.levels);
        node.self_cost = self_cost(own_half, &self.levels[at..at + 2]);
        area
    }

    /// Measures an inner node whose own half extents are given. Its `children` must be measured
    /// before. Returns the sum of the surface areas of their boxes.
    #[inline(always)]
    pub fn measure<L: Lanes>(
        &mut self,
        lanes: L,
        node: &mut Node,
        own_half: [f32; 3],
        children: &[Node],
    ) -> f32 {
        // The levels of the nodes below precede those of this node.
        let (below, levels) = self.levels.split_at_mut(node.profile as usize - self.first);
        let (levels, triangles) = levels.split_at_mut(node.height.into());
        let half = per_axis!(k => F8::read(lanes, &node.half[k]));
        let (first, area) = LevelProfile::of_children(node, &half);
        levels[0] = first;
        let siblings = Siblings::of(lanes, node, children);
        for (depth, level) in levels[1..].iter_mut().enumerate() {
            let of = |child: &Node| (depth < child.height.into()).then_some(depth);
            *level = siblings.level(lanes, of, below, self.first);
        }
        let of = |child: &Node| Some(child.height.into());
        triangles[0] = siblings.level(lanes, of, below, self.first);
        node.log_alpha = log_alpha(triangles[0].half_extent, own_half.into(), node.levels);
        node.self_cost = self_cost(own_half, levels);
        area
    }
}

/// The children of a node, one per lane.
struct Siblings<'n, L: Lanes> {
    children: &'n [Node],
    /// Magnitudes of the rotation from the axes of each child to those of the node, row by row.
    absolute: [V8<L>; 3],
}

impl<'n, L: Lanes> Siblings<'n, L> {
    #[inline(always)]
    fn of(lanes: L, node: &Node, children: &'n [Node]) -> Self {
        let last = children.len() - 1;
        let rows = per_axis!(k => {
            let [x, y, z, _] = F8::columns(lanes, per_lane!(i => children[i.min(last)].rows[k].as_array()));
            [x, y, z]
        });
        let (zero, one) = (F8::splat(lanes, 0.0), F8::splat(lanes, 1.0));
        let identity = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        let other = per_lane!(i => f32::from(u8::from(children[i.min(last)].orientation != node.orientation)));
        let turned = zero.less(F8::load(lanes, &other));
        let absolute = per_axis!(i => {
            let axis = per_axis!(k => F8::splat(lanes, node.rows[k].as_array()[i]));
            let row = per_axis!(j => dot(axis, per_axis!(k => rows[k][j])).abs());
            per_axis!(j => turned.select(row[j], identity[i][j]))
        });
        Self { children, absolute }
    }

    /// Merges one level of the profile of each child: level `of(child)`, if it has one. `all`
    /// contains their levels, from number `first` on.
    #[inline(always)]
    fn level(
        &self,
        lanes: L,
        of: impl Fn(&Node) -> Option<usize>,
        all: &[LevelProfile],
        first: usize,
    ) -> LevelProfile {
        let rows = per_lane!(i => match self.children.get(i).and_then(|child| Some((child, of(child)?))) {
            Some((child, level)) => {
                let LevelProfile { nodes, half_extent: h } = all[child.profile as usize + level - first];
                [h.x, h.y, h.z, nodes]
            }
            _ => [0.0; 4],
        });
        let [x, y, z, n] = F8::columns(lanes, per_lane!(i => &rows[i]));
        let [x, y, z] = per_axis!(k => dot(self.absolute[k], [x, y, z]) * n);
        let [x, y, z, n] = sums([x, y, z, n]);
        LevelProfile::of_sums(n, [x, y, z])
    }
}

/// [`visits`] of a subtree with half extents `own`. The mean of the products of the extents is
/// replaced by the product of their means.
#[inline(always)]
fn self_cost(own: [f32; 3], levels: &[LevelProfile]) -> f32 {
    visits(levels.iter().map(|level| Level {
        boxes: level.nodes,
        shrinkage: per_axis!(k => if own[k] > 0.0 { (level.half_extent[k] / own[k]).min(1.0) } else { 1.0 }),
    }))
}
