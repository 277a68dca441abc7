//! The binary tree of the paper: binned surface-area heuristic over the triangles' boxes, whose axes are the same for the
//! whole mesh ([`super::align::align`]).
//!
//! Its levels carry the paper's alphas; the wide tree is collapsed from it. Splitting goes down to clusters of at most
//! [`CLUSTER`] triangles. `O(n log n)` time, `O(n)` memory; the depth is bounded by `2 log2(n) + 8`, whatever the mesh.

use super::fork::Pieces;
use super::options::Effort;
use super::orientation::Orientation;
use super::unit::Unit;
use super::wide::WIDTH;
use crate::mesh::Mesh;
use alloc::vec::Vec;
use glam::{Vec3A, Vec4, Vec4Swizzles};

/// Most triangles of a cluster, and most children of a wide node.
pub(super) const CLUSTER: usize = WIDTH;

/// One node: triangles `order[first..first + count]`.
pub(super) struct BinaryNode {
    pub first: u32,
    pub count: u32,
    /// Half the surface area of its box.
    pub area: f32,
    /// How far behind this node its right child lies; the left one comes next. 0 for a cluster.
    right: u32,
}

impl BinaryNode {
    pub fn is_cluster(&self) -> bool {
        self.right == 0
    }
}

/// Most steps from the root to a cluster in a tree of so many triangles.
pub(super) fn most_depth(triangles: usize) -> u32 {
    2 * (usize::BITS - triangles.leading_zeros()) + 8
}

/// The tree: `nodes[0]` is the root, `order` the triangle ids in tree order.
pub(super) struct BinaryTree {
    pub nodes: Vec<BinaryNode>,
    pub order: Vec<u32>,
}

impl BinaryTree {
    /// The children of a node that is no cluster.
    pub fn children(&self, node: usize) -> [usize; 2] {
        [node + 1, node + self.nodes[node].right as usize]
    }
}

/// A triangle's box; the unused lane of `min` carries its id, so that a move copies 32 bytes.
#[derive(Clone, Copy)]
pub(super) struct Item {
    min: Vec4,
    max: Vec4,
}

/// Added to ids, which are below 2^30. By themselves they are denormal numbers, for which arithmetic takes many times as long.
const NORMAL: u32 = 1 << 30;

impl Item {
    pub fn new(id: usize, [a, b, c]: [Vec3A; 3]) -> Self {
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        Self { min: min.extend(f32::from_bits(id as u32 + NORMAL)), max: max.extend(0.0) }
    }

    fn id(&self) -> u32 {
        self.min.w.to_bits() - NORMAL
    }

    /// Twice the centre of the box.
    #[inline(always)]
    fn center(&self) -> Vec4 {
        self.min + self.max
    }
}

#[derive(Clone, Copy)]
struct Bounds {
    min: Vec4,
    max: Vec4,
}

impl Bounds {
    const EMPTY: Self = Self { min: Vec4::INFINITY, max: Vec4::NEG_INFINITY };

    #[inline(always)]
    fn union(self, min: Vec4, max: Vec4) -> Self {
        Self { min: self.min.min(min), max: self.max.max(max) }
    }

    /// Half the surface area.
    #[inline(always)]
    fn area(self) -> f32 {
        let e = self.max - self.min;
        let faces = e * e.yzxw();
        faces.x + faces.y + faces.z
    }
}

/// Builds over the triangles' boxes along the axes of `orientation`.
pub(super) fn build(mesh: &Mesh, unit: &Unit, orientation: &Orientation, effort: Effort, pieces: Pieces) -> BinaryTree {
    let to_axes = orientation.rotation.transpose();
    let of_point = unit.of_points();
    let corners = |id: usize| mesh.triangle(id).map(|x| to_axes * of_point(x).as_vec3a());
    let mut items: Vec<Item> = (0..mesh.len()).map(|id| Item::new(id, corners(id))).collect();
    let mut nodes = Vec::with_capacity(items.len() / 2 + 1);
    if !items.is_empty() {
        let depth_left = most_depth(items.len());
        split(effort, &mut items, 0, depth_left, &mut nodes, pieces);
    }
    BinaryTree { nodes, order: items.iter().map(Item::id).collect() }
}

/// Splits `items`, which begin at `first` in tree order, and appends their nodes.
fn split(effort: Effort, items: &mut [Item], first: u32, depth_left: u32, nodes: &mut Vec<BinaryNode>, pieces: Pieces) {
    let mut bounds = Bounds::EMPTY;
    let mut centers = Bounds::EMPTY;
    for item in &*items {
        bounds = bounds.union(item.min, item.max);
        let center = item.center();
        centers = centers.union(center, center);
    }
    let index = nodes.len();
    nodes.push(BinaryNode { first, count: items.len() as u32, area: bounds.area(), right: 0 });
    if items.len() <= CLUSTER {
        return;
    }
    // A tree may lean for a while, but not so long that a balanced rest would no longer fit the depth.
    let balanced = usize::BITS - (items.len() - 1).leading_zeros();
    let middle = if depth_left > balanced { partition(effort, items, centers) } else { None };
    let middle = middle.unwrap_or_else(|| halve(items, centers));
    let (left, right) = items.split_at_mut(middle);
    let (depth_left, second) = (depth_left - 1, first + middle as u32);
    if pieces.count() < 2 {
        split(effort, left, first, depth_left, nodes, pieces);
        nodes[index].right = (nodes.len() - index) as u32;
        split(effort, right, second, depth_left, nodes, pieces);
    } else {
        let mut of_right = Vec::new();
        pieces.join(
            [left.len(), right.len()],
            |pieces| split(effort, left, first, depth_left, nodes, pieces),
            |pieces| split(effort, right, second, depth_left, &mut of_right, pieces),
        );
        nodes[index].right = (nodes.len() - index) as u32;
        nodes.append(&mut of_right);
    }
}

/// Partitions `items` at the cheapest of the bin borders; `None` where no border separates them.
fn partition(effort: Effort, items: &mut [Item], centers: Bounds) -> Option<usize> {
    // Below this many triangles bins cost more than they bring.
    const FEW: usize = 64;
    match (effort, items.len() > FEW) {
        (Effort::Best, true) => partition_in::<64>(items, centers),
        (Effort::Best, false) | (Effort::Normal, true) => partition_in::<16>(items, centers),
        (Effort::Normal, false) | (Effort::Fast, _) => partition_in::<8>(items, centers),
    }
}

/// Partitions at the borders of `N` bins an axis.
fn partition_in<const N: usize>(items: &mut [Item], centers: Bounds) -> Option<usize> {
    let binning = Binning::<N>::new(centers);
    let [on_x, on_y, on_z] = binning.axes;
    let mut bins = [[Bin::EMPTY; N]; 3];
    for item in &*items {
        let [x, y, z] = binning.bins_of(item);
        if on_x {
            bins[0][x].add(item);
        }
        if on_y {
            bins[1][y].add(item);
        }
        if on_z {
            bins[2][z].add(item);
        }
    }
    let mut best = (0, 0, f32::INFINITY);
    for (axis, bins) in bins.iter().enumerate().filter(|&(axis, _)| binning.axes[axis]) {
        let (border, cost) = cheapest_border(bins);
        if cost < best.2 {
            best = (axis, border, cost);
        }
    }
    let (axis, border, cost) = best;
    if cost == f32::INFINITY {
        return None;
    }
    let mut borders = [0.0; 4];
    borders[axis] = border as f32;
    let borders = Vec4::from_array(borders) + Vec4::splat(SHIFT);
    Some(move_to_front(items, |item| binning.shifted(item).cmplt(borders).any()))
}

/// Where the centres fall: bin = (center - origin) * scale, on each axis.
struct Binning<const N: usize> {
    origin: Vec4,
    scale: Vec4,
    /// Whether it pays to look for a border on this axis.
    axes: [bool; 3],
}

impl<const N: usize> Binning<N> {
    fn new(centers: Bounds) -> Self {
        // Splits across a short axis are hardly ever the cheapest, and where they are, they do not pay later.
        const SHORT: f32 = 0.3;
        let extent = (centers.max - centers.min).with_w(0.0);
        let axes = extent.cmpge(Vec4::splat((SHORT * extent.max_element()).max(1e-30)));
        let scale = Vec4::select(axes, N as f32 * 0.9999 / extent, Vec4::ZERO);
        Self { origin: centers.min, scale, axes: [axes.test(0), axes.test(1), axes.test(2)] }
    }

    /// The bins, and [`SHIFT`] added.
    #[inline(always)]
    fn shifted(&self, item: &Item) -> Vec4 {
        (item.center() - self.origin) * self.scale - Vec4::splat(0.5) + Vec4::splat(SHIFT)
    }

    #[inline(always)]
    fn bins_of(&self, item: &Item) -> [usize; 3] {
        let [x, y, z, _] = self.shifted(item).to_array();
        [x.to_bits() as usize % N, y.to_bits() as usize % N, z.to_bits() as usize % N]
    }
}

/// Between 2^23 and 2^24 the last bit of an f32 is worth 1: adding this leaves the nearest whole number in the low bits.
const SHIFT: f32 = 12_582_912.0;

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, count: 0 };

    #[inline(always)]
    fn add(&mut self, item: &Item) {
        self.bounds = self.bounds.union(item.min, item.max);
        self.count += 1;
    }

    #[inline(always)]
    fn merge(&mut self, other: &Self) {
        self.bounds = self.bounds.union(other.bounds.min, other.bounds.max);
        self.count += other.count;
    }

    /// Half surface area times count; infinite if there is nothing inside, so that no border leaves a side empty.
    #[inline(always)]
    fn cost(&self) -> f32 {
        if self.count == 0 { f32::INFINITY } else { self.bounds.area() * self.count as f32 }
    }
}

/// The border between bins with the least sum of costs of both sides, and that sum.
#[inline(always)]
fn cheapest_border<const N: usize>(bins: &[Bin; N]) -> (usize, f32) {
    let mut above = [0.0; N];
    let mut side = Bin::EMPTY;
    for i in (1..N).rev() {
        side.merge(&bins[i]);
        above[i] = side.cost();
    }
    let mut side = Bin::EMPTY;
    let mut best = (0, f32::INFINITY);
    for i in 1..N {
        side.merge(&bins[i - 1]);
        let cost = side.cost() + above[i];
        if cost < best.1 {
            best = (i, cost);
        }
    }
    best
}

/// Reorders `items` so that those that are `left` come first; returns their number. Without branches: which side an
/// item goes to is a coin toss.
#[inline(always)]
fn move_to_front(items: &mut [Item], left: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        let (item, first_right) = (items[i], items[count]);
        items[i] = first_right;
        items[count] = item;
        count += usize::from(left(&item));
    }
    count
}

/// Halves `items` by number along the longest extent of their centres.
fn halve(items: &mut [Item], centers: Bounds) -> usize {
    let extent = (centers.max - centers.min).truncate();
    let axis = extent.max_position();
    let key = |item: &Item| item.center()[axis];
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.id().cmp(&b.id())));
    middle
}
