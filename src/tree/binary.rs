//! The binary tree of the paper: binned surface-area heuristic over the triangles' boxes, in one frame for the whole mesh
//! ([`super::frame::align`]).
//!
//! Its levels carry the paper's alphas; the wide tree is collapsed from it. Splitting goes down to clusters of at most
//! [`CLUSTER`] triangles. `O(n log n)` time, `O(n)` memory; the depth is bounded by `2 log2(n) + 8`, whatever the mesh.

use super::unit::Corners;
use alloc::vec::Vec;
use glam::{Vec3, Vec4};

/// Most triangles of a cluster, and most children of a wide node.
pub(super) const CLUSTER: usize = 8;

/// One node: triangles `order[first..first + count]`; `children` are `None` for a cluster.
pub(super) struct BinaryNode {
    pub first: u32,
    pub count: u32,
    pub area: f32,
    pub children: Option<[u32; 2]>,
}

/// The tree: `nodes[0]` is the root, `order` the triangle ids in tree order.
pub(super) struct BinaryTree {
    pub nodes: Vec<BinaryNode>,
    pub order: Vec<u32>,
}

/// A triangle's box; the unused lane of `min` carries its id, so that a swap moves 32 bytes.
#[derive(Clone, Copy)]
struct Item {
    min: Vec4,
    max: Vec4,
}

impl Item {
    fn new(id: usize, corners: &Corners) -> Self {
        let [a, b, c] = corners.0;
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        Self { min: min.extend(f32::from_bits(id as u32)), max: max.extend(0.0) }
    }

    fn id(&self) -> u32 {
        self.min.w.to_bits()
    }

    /// Twice the centre of the box.
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

    fn union(self, min: Vec4, max: Vec4) -> Self {
        Self { min: self.min.min(min), max: self.max.max(max) }
    }

    /// Half the surface area.
    fn area(self) -> f32 {
        let e = self.max - self.min;
        e.x * e.y + e.y * e.z + e.z * e.x
    }
}

/// Builds over the triangles' corners, in unit coordinates or turned.
pub(super) fn build(corners: &[Corners]) -> BinaryTree {
    let mut items: Vec<Item> = corners.iter().enumerate().map(|(id, c)| Item::new(id, c)).collect();
    let mut nodes = Vec::with_capacity(items.len() / 2 + 1);
    if !items.is_empty() {
        let depth_left = 2 * (usize::BITS - items.len().leading_zeros()) + 8;
        split(&mut items, 0, depth_left, &mut nodes);
    }
    BinaryTree { nodes, order: items.iter().map(Item::id).collect() }
}

/// Splits `items`, which begin at `first` in tree order, and returns the index of their node.
fn split(items: &mut [Item], first: u32, depth_left: u32, nodes: &mut Vec<BinaryNode>) -> u32 {
    let index = nodes.len() as u32;
    let mut bounds = Bounds::EMPTY;
    let mut centers = Bounds::EMPTY;
    for item in &*items {
        bounds = bounds.union(item.min, item.max);
        centers = centers.union(item.center(), item.center());
    }
    nodes.push(BinaryNode { first, count: items.len() as u32, area: bounds.area(), children: None });
    if items.len() > CLUSTER {
        // A tree may lean for a while, but not so long that a balanced rest would no longer fit the depth.
        let balanced = usize::BITS - (items.len() - 1).leading_zeros();
        let middle = if depth_left > balanced { partition(items, centers) } else { None };
        let middle = middle.unwrap_or_else(|| halve(items, centers));
        let (left, right) = items.split_at_mut(middle);
        let left = split(left, first, depth_left - 1, nodes);
        let right = split(right, first + middle as u32, depth_left - 1, nodes);
        nodes[index as usize].children = Some([left, right]);
    }
    index
}

const BINS: usize = 16;

/// Where the centres of `bounds` fall: bin = (center - origin) * scale.
struct Binning {
    origin: Vec4,
    scale: Vec4,
    bins: usize,
}

impl Binning {
    fn new(centers: Bounds, count: usize) -> Self {
        let bins = if count > 32 { BINS } else { BINS / 2 };
        let extent = (centers.max - centers.min).truncate();
        // An axis without extent puts everything into bin 0 and so is never split.
        let scale = Vec3::select(extent.cmpgt(Vec3::splat(1e-30)), bins as f32 * 0.9999 / extent, Vec3::ZERO);
        Self { origin: centers.min, scale: scale.extend(0.0), bins }
    }

    fn bins_of(&self, item: &Item) -> [usize; 3] {
        let bin = (item.center() - self.origin) * self.scale;
        [bin.x, bin.y, bin.z].map(|b| (b as usize).min(self.bins - 1))
    }
}

/// Partitions `items` at the cheapest of the bin borders; `None` where no border separates them.
fn partition(items: &mut [Item], centers: Bounds) -> Option<usize> {
    let binning = Binning::new(centers, items.len());
    let mut bins = [[(Bounds::EMPTY, 0u32); BINS]; 3];
    for item in &*items {
        for (axis, bin) in binning.bins_of(item).into_iter().enumerate() {
            let (bounds, count) = &mut bins[axis][bin];
            *bounds = bounds.union(item.min, item.max);
            *count += 1;
        }
    }
    let (axis, border, _) = (0..3)
        .filter_map(|axis| cheapest_border(&bins[axis][..binning.bins]).map(|(border, cost)| (axis, border, cost)))
        .min_by(|a, b| a.2.total_cmp(&b.2))?;
    Some(move_to_front(items, |item| binning.bins_of(item)[axis] < border))
}

/// The border between bins with the least sum of area times count, among those with triangles on both sides.
fn cheapest_border(bins: &[(Bounds, u32)]) -> Option<(usize, f32)> {
    let mut above = [(0.0, 0); BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for i in (1..bins.len()).rev() {
        bounds = bounds.union(bins[i].0.min, bins[i].0.max);
        count += bins[i].1;
        above[i] = (bounds.area() * count as f32, count);
    }
    let (mut bounds, mut count, mut best) = (Bounds::EMPTY, 0, None);
    for i in 1..bins.len() {
        bounds = bounds.union(bins[i - 1].0.min, bins[i - 1].0.max);
        count += bins[i - 1].1;
        if count == 0 || above[i].1 == 0 {
            continue;
        }
        let cost = bounds.area() * count as f32 + above[i].0;
        if best.is_none_or(|(_, least)| cost < least) {
            best = Some((i, cost));
        }
    }
    best
}

/// Reorders `items` so that those that are `left` come first; returns their number.
fn move_to_front(items: &mut [Item], left: impl Fn(&Item) -> bool) -> usize {
    let (mut i, mut j) = (0, items.len());
    while i < j {
        if left(&items[i]) {
            i += 1;
        } else {
            j -= 1;
            items.swap(i, j);
        }
    }
    i
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
