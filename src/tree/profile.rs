//! The profile of a subtree, level by level: the input of the cost model.
//!
//! All values are measured along the axes of the subtree's root: a box with half extents `e` and
//! axes `Q` counts as `|Q| e`. Levels are merged bottom-up from those of the children, one child
//! per lane, in `O(nodes * height)`.

use super::eight::present;
use super::wide::{Node, xyz};
use alloc::boxed::Box;
use core::ops::Range;
use glam::{Vec3, Vec3A};
use punctual_geom::lanes::{Column, F8, Lanes, V8, dot, per_axis, per_lane, sums};

/// The boxes of one level of a subtree, counted down from its root. Values are along the axes of
/// the root, in unit coordinates (multiply by [`crate::Tree::unit_length`] for the mesh's).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct LevelProfile {
    /// Number of boxes.
    pub nodes: f32,
    /// Mean half extent of the boxes.
    pub half_extent: Vec3,
    /// Mean center of the boxes.
    pub center: Vec3,
    /// Variance of the boxes' centers.
    pub variance: Vec3,
}

impl LevelProfile {
    const NONE: Self = Self {
        nodes: 0.0,
        half_extent: Vec3::ZERO,
        center: Vec3::ZERO,
        variance: Vec3::ZERO,
    };

    /// Profile of the level of `node`'s children, whose boxes are `center` and `half`, and the sum
    /// of their surface areas.
    #[inline(always)]
    fn of_children<L: Lanes>(
        lanes: L,
        node: &Node,
        center: &V8<L>,
        half: &V8<L>,
        about: [f32; 3],
    ) -> (Self, f32) {
        let present = present(lanes, node.children.into());
        // Missing boxes have half extents of zero, so only the centers are multiplied by the mask.
        let [x, y, z] = *half;
        let [u, v, w] = per_axis!(k => (center[k] - F8::splat(lanes, about[k])) * present);
        let [hx, hy, hz, area] = sums([x, y, z, x * y + y * z + z * x]);
        let [cx, cy, cz, uu] = sums([u, v, w, u * u]);
        let [vv, ww, ..] = sums([v * v, w * w, u, u]);
        (
            Self::of_sums(
                node.children.into(),
                [hx, hy, hz],
                [cx, cy, cz],
                [uu, vv, ww],
                about,
            ),
            8.0 * area,
        )
    }

    /// A level from sums over its `nodes` boxes: of half extents, of centers relative to `about`,
    /// and of the squares of these centers plus the boxes' variances.
    #[inline(always)]
    fn of_sums(
        nodes: f32,
        half: [f32; 3],
        center: [f32; 3],
        squares: [f32; 3],
        about: [f32; 3],
    ) -> Self {
        let scale = 1.0 / nodes;
        let mean = Vec3A::from(center) * scale;
        Self {
            nodes,
            half_extent: (Vec3A::from(half) * scale).into(),
            center: (Vec3A::from(about) + mean).into(),
            variance: (Vec3A::from(squares) * scale - mean * mean)
                .max(Vec3A::ZERO)
                .into(),
        }
    }
}

/// The profiles of all subtrees: node `i` has levels `nodes[i].profile..`.
#[derive(Clone, Debug, Default)]
pub(super) struct Profiles {
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
            let below = if node.is_leaf {
                0..0
            } else {
                node.child_range()
            };
            let below = &later[below.start.saturating_sub(index + 1)..][..below.len()];
            node.height = 1 + below.iter().map(|child| child.height).max().unwrap_or(0);
            node.profile = levels as u32;
            levels += usize::from(node.height);
        }
        Self {
            levels: alloc::vec![LevelProfile::NONE; levels].into(),
            cost: 0.0,
        }
    }

    /// Range of the levels that belong to `nodes`, which are adjacent.
    pub fn range(nodes: &[Node]) -> Range<usize> {
        let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else {
            return 0..0;
        };
        last.profile as usize..first.profile as usize + usize::from(first.height)
    }
}

/// The levels of some subtrees, from number `first` on.
pub(super) struct Levels<'l> {
    pub levels: &'l mut [LevelProfile],
    pub first: usize,
}

impl Levels<'_> {
    /// Measures a leaf. The boxes of its triangles are `center` and `half`. Returns the sum of
    /// their surface areas.
    #[inline(always)]
    pub fn measure_leaf<L: Lanes>(
        &mut self,
        lanes: L,
        node: &mut Node,
        center: &V8<L>,
        half: &V8<L>,
    ) -> f32 {
        let (level, area) =
            LevelProfile::of_children(lanes, node, center, half, xyz(node.own_center));
        self.levels[node.profile as usize - self.first] = level;
        node.leaf = level.half_extent.into();
        node.self_cost = level.nodes * level.nodes;
        area
    }

    /// Measures an inner node whose own box is given. Its `children` must be measured before.
    /// Returns the sum of the surface areas of their boxes.
    #[inline(always)]
    pub fn measure<L: Lanes>(
        &mut self,
        lanes: L,
        node: &mut Node,
        own_center: [f32; 3],
        own_half: [f32; 3],
        children: &[Node],
    ) -> f32 {
        // The levels of the nodes below precede those of this node.
        let (below, levels) = self.levels.split_at_mut(node.profile as usize - self.first);
        let levels = &mut levels[..usize::from(node.height)];
        let center = per_axis!(k => F8::read(lanes, &node.center[k]));
        let half = per_axis!(k => F8::read(lanes, &node.half[k]));
        let (first, area) = LevelProfile::of_children(lanes, node, &center, &half, own_center);
        levels[0] = first;
        let siblings = Siblings::of(lanes, node, children);
        for (depth, level) in levels[1..].iter_mut().enumerate() {
            *level = siblings.level(lanes, depth, below, self.first, own_center);
        }
        node.leaf = siblings.leaf(lanes);
        node.self_cost = self_cost(own_half, levels);
        area
    }
}

/// The children of a node, one per lane.
struct Siblings<'n, L: Lanes> {
    children: &'n [Node],
    /// Rotation from the axes of each child to those of the node, row by row.
    rotation: [V8<L>; 3],
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
        let rotation = per_axis!(i => {
            let axis = per_axis!(k => F8::splat(lanes, node.rows[k].as_array()[i]));
            per_axis!(j => turned.select(dot(axis, per_axis!(k => rows[k][j])), identity[i][j]))
        });
        let absolute = per_axis!(i => per_axis!(j => rotation[i][j].abs()));
        Self {
            children,
            rotation,
            absolute,
        }
    }

    /// Merges level `depth` of the profiles of all children. `all` contains their levels, from
    /// number `first` on. Sums are taken relative to `about`, a point close to the boxes.
    #[inline(always)]
    fn level(
        &self,
        lanes: L,
        depth: usize,
        all: &[LevelProfile],
        first: usize,
        about: [f32; 3],
    ) -> LevelProfile {
        let of_child = per_lane!(i => match self.children.get(i) {
            Some(child) if depth < usize::from(child.height) => &all[child.profile as usize + depth - first],
            _ => &LevelProfile::NONE,
        });
        let rows = per_lane!(i => {
            let LevelProfile { nodes, half_extent: h, center: c, variance: v } = *of_child[i];
            [[nodes, h.x, h.y, h.z], [c.x, c.y, c.z, v.x], [c.z, v.x, v.y, v.z]]
        });
        let [n, hx, hy, hz] = F8::columns(lanes, per_lane!(i => &rows[i][0]));
        let [cx, cy, cz, vx] = F8::columns(lanes, per_lane!(i => &rows[i][1]));
        let [_, _, vy, vz] = F8::columns(lanes, per_lane!(i => &rows[i][2]));
        let half = per_axis!(k => dot(self.absolute[k], [hx, hy, hz]) * n);
        let center =
            per_axis!(k => dot(self.rotation[k], [cx, cy, cz]) - F8::splat(lanes, about[k]));
        let squares = per_axis!(k => {
            let [x, y, z] = self.rotation[k];
            (dot([x * x, y * y, z * z], [vx, vy, vz]) + center[k] * center[k]) * n
        });
        let [nodes, hx, hy, hz] = sums([n, half[0], half[1], half[2]]);
        let [cx, cy, cz, vx] = sums([center[0] * n, center[1] * n, center[2] * n, squares[0]]);
        let [vy, vz, ..] = sums([squares[1], squares[2], n, n]);
        LevelProfile::of_sums(nodes, [hx, hy, hz], [cx, cy, cz], [vx, vy, vz], about)
    }

    /// Mean half extents of the boxes of all triangles.
    #[inline(always)]
    fn leaf(&self, lanes: L) -> [f32; 3] {
        let rows = per_lane!(i => match self.children.get(i) {
            Some(Node { leaf: [x, y, z], triangles, .. }) => [*x, *y, *z, *triangles as f32],
            None => [0.0; 4],
        });
        let [x, y, z, n] = F8::columns(lanes, per_lane!(i => &rows[i]));
        let [x, y, z] = per_axis!(k => dot(self.absolute[k], [x, y, z]) * n);
        let [x, y, z, n] = sums([x, y, z, n]);
        [x / n, y / n, z / n]
    }
}

/// Expected BV tests of a subtree with half extents `own` against a copy of itself, averaged over
/// all overlapping placements: `sum_l n_(l+1)^2 O_l / n_l^2`, `O_l = n_l^2 prod_k e_k(l) / e_k(0)`.
/// Level `l` has `n_l` boxes with half extents `e(l)`; level 0 is the root. The mean of the
/// products is replaced by the product of the means.
#[inline(always)]
fn self_cost(own: [f32; 3], levels: &[LevelProfile]) -> f32 {
    let mut share = 1.0;
    let mut tests = 0.0;
    for level in levels {
        tests += level.nodes * level.nodes * share;
        let [x, y, z] = per_axis!(k => if own[k] > 0.0 { (level.half_extent[k] / own[k]).min(1.0) } else { 1.0 });
        share = x * y * z;
    }
    tests
}
