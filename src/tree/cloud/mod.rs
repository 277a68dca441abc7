//! Trees of point clouds. The leaves are blocks of eight points that are near each other, and are
//! not stored: a query makes the leaf of a block when it opens it.
//!
//! Points are sorted along a Hilbert curve, or halved again and again, and cut into blocks; a binary
//! SAH tree over the blocks is collapsed as for a mesh. Its nodes have the axes of the cloud. Node numbers from the number
//! of stored nodes on are those of the blocks. A point is a triangle without extent, so every
//! question that can be asked about a mesh has the same proofs for a cloud.

pub(crate) mod hilbert;
pub(crate) mod window;

use crate::mesh::{Mesh, MeshError, Vertices};
use crate::tree::build::binary;
use crate::tree::build::collapse::Plan;
use crate::tree::build::eight::present;
use crate::tree::build::orientation::Orientation;
use crate::tree::fit::Extent;
use crate::tree::fit::alpha::log_alpha;
use crate::tree::fit::profile::{Levels, Profiles};
use crate::tree::fit::update::{keep, set_own};
use crate::tree::fork::Pieces;
use crate::tree::options::Effort;
use crate::tree::solid::extremes::Extremes;
use crate::tree::validate::TreeFault;
use crate::tree::wide::{Node, WIDTH};
use crate::tree::{Tree, TreeFileError, Triangle, Unit, next_identity, power_of_two};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::Range;
use glam::{DVec3, Vec3};
use punctual_geom::lanes::{F8, Instructions, Kernel, Lanes, per_lane};

/// The ranges of the blocks' points in tree order: eight points in each block, but fewer in one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Blocks {
    /// The block that is not full.
    pub partial: u32,
    /// Number of points that it lacks.
    missing: u32,
    points: u32,
}

impl Blocks {
    /// The blocks of this many points, of which `partial` is not full.
    pub fn new(points: usize, partial: u32) -> Self {
        let count = points.div_ceil(WIDTH);
        Self {
            partial,
            missing: (count * WIDTH - points) as u32,
            points: points as u32,
        }
    }

    pub fn count(self) -> usize {
        (self.points as usize).div_ceil(WIDTH)
    }

    fn start(self, block: u32) -> u32 {
        block * WIDTH as u32
            - if block > self.partial {
                self.missing
            } else {
                0
            }
    }

    pub fn range(self, block: u32) -> Range<u32> {
        self.start(block)..self.start(block + 1)
    }

    /// Turns nodes over blocks into nodes over their points.
    pub fn put_below(self, nodes: &mut [Node]) {
        let count = nodes.len() as u32;
        for node in nodes {
            let (first, end) = (node.first_triangle, node.first_triangle + node.triangles);
            node.first_triangle = self.start(first);
            node.triangles = self.start(end).min(self.points) - node.first_triangle;
            if node.is_leaf {
                (node.is_leaf, node.first_child) = (false, count + first);
            }
        }
    }

    /// The block of a point (tree order).
    pub fn of(self, point: u32) -> u32 {
        let is_behind = point >= self.start(self.partial + 1);
        (point + if is_behind { self.missing } else { 0 }) / WIDTH as u32
    }
}

/// Eight points as the fast filters read triangles.
pub(crate) type Points = [Triangle; WIDTH];

/// The leaf of a block, and its points as the fast filters read triangles. The last point is
/// repeated if there are fewer than eight.
pub(crate) struct Leaf {
    pub node: Node,
    pub points: Points,
}

/// The node with a number: stored, or made from its block in `leaf`, a variable that has no value
/// yet.
macro_rules! node {
    ($tree:expr, $number:expr, $leaf:ident) => {
        match $tree.nodes().get($number as usize) {
            Some(node) => node,
            None => {
                $leaf = $tree.made_leaf($number);
                &$leaf.node
            }
        }
    };
}
pub(crate) use node;

impl Unit {
    /// A point in unit coordinates, as a triangle without extent.
    #[inline(always)]
    fn place_point(&self, point: DVec3) -> Triangle {
        let exact = self.point(point);
        let [x, y, z] = exact.as_vec3().to_array();
        let [u, v, w] = (exact - exact.as_vec3().as_dvec3()).as_vec3().to_array();
        Triangle([[x, y, z, 0.0], [0.0; 4], [0.0, u, v, w]])
    }

    /// The box around points. Its ends are those of their ends, because the map is monotone.
    #[inline(always)]
    pub(crate) fn extent(&self, points: impl Iterator<Item = [f32; 3]>) -> Extent {
        let mut ends = Extent::EMPTY;
        points.for_each(|point| ends.add(point.into()));
        ends.map(|end| self.point(end.as_dvec3()).as_vec3a())
    }
}

impl Tree {
    /// Builds the tree of a point cloud ([`Mesh::from_points`]), with [`Effort::Fast`]: for points
    /// that are soon replaced. [`new`](Self::new) takes two to four times as long, and queries of
    /// its tree about two thirds of the time.
    ///
    /// Takes about 30 bytes a point. `O(n log n)`, on one thread.
    ///
    /// ```
    /// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
    /// let cloud = Tree::from_points([[0.0, 0.0, 3.0], [1.0, 0.0, 2.0]])?;
    /// let ball = Tree::new(shapes::icosphere(3));
    /// let query = Query::distance(&cloud, &ball, Pose::IDENTITY);
    /// let found = query.run(&mut Workspace::new(), Budget::unlimited()).value;
    /// assert!(1.2 < found.low && found.high < 1.3);
    /// # Ok::<(), punctual::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Mesh::from_points`].
    pub fn from_points(points: impl IntoIterator<Item: Into<[f32; 3]>>) -> Result<Self, MeshError> {
        Mesh::from_points(points).map(|mesh| Self::of_cloud(mesh, Effort::Fast))
    }

    /// Builds the tree of a point cloud of f64 points ([`Mesh::from_points_f64`]), as
    /// [`from_points`](Self::from_points).
    ///
    /// # Errors
    /// As [`Mesh::from_points_f64`].
    pub fn from_points_f64(
        points: impl IntoIterator<Item: Into<[f64; 3]>>,
    ) -> Result<Self, MeshError> {
        Mesh::from_points_f64(points).map(|mesh| Self::of_cloud(mesh, Effort::Fast))
    }

    /// True for the tree of a point cloud.
    #[inline]
    pub fn is_cloud(&self) -> bool {
        self.mesh.is_cloud()
    }

    pub(crate) fn of_cloud(mesh: Mesh, effort: Effort) -> Self {
        let unit = Unit::of(&mesh);
        let sorted = match effort {
            Effort::Fast => sorted(&mesh, &unit),
            Effort::Normal => halved(&mesh, &unit),
        };
        let last = sorted.len().div_ceil(WIDTH).saturating_sub(1) as u32;
        let (nodes, order, boxes) = nodes_above(&mesh, &unit, &sorted, effort);
        let partial = order.iter().position(|&block| block == last);
        let blocks = Blocks::new(sorted.len(), partial.unwrap_or(0) as u32);
        let points_of = |&block: &u32| {
            let first = block as usize * WIDTH;
            &sorted[first..sorted.len().min(first + WIDTH)]
        };
        let mut ids = Vec::with_capacity(sorted.len());
        order
            .iter()
            .for_each(|block| ids.extend_from_slice(points_of(block)));
        let boxes = order.iter().map(|&block| boxes[block as usize]).collect();
        Self::of_blocks(mesh, nodes, blocks, ids.into(), Some(boxes))
    }

    /// The tree of a cloud from what its file states.
    pub(crate) fn of_file(
        mesh: Mesh,
        nodes: Box<[Node]>,
        partial: u64,
        ids: Box<[u32]>,
    ) -> Result<Self, TreeFileError> {
        let turned = nodes.iter().position(|node| node.orientation != 0);
        if let Some(node) = turned {
            return Err(TreeFault::Orientation(node).into());
        }
        if partial > 0 && partial >= ids.len().div_ceil(WIDTH) as u64 {
            return Err(TreeFault::Children(0).into());
        }
        let blocks = Blocks::new(ids.len(), partial as u32);
        Ok(Self::of_blocks(mesh, nodes, blocks, ids, None))
    }

    /// Completes the tree of a cloud from nodes over its blocks, still without boxes, and the boxes
    /// of the blocks, if they are known.
    fn of_blocks(
        mesh: Mesh,
        mut nodes: Box<[Node]>,
        blocks: Blocks,
        ids: Box<[u32]>,
        boxes: Option<Vec<Extent>>,
    ) -> Self {
        blocks.put_below(&mut nodes);
        let profiles = Profiles::room(&mut nodes);
        let (unit, identity) = (Unit::of(&mesh), next_identity());
        let mut tree = Self {
            mesh,
            unit,
            nodes,
            blocks,
            triangles: Box::default(),
            corners: Box::default(),
            ids,
            profiles,
            neighbors: Box::default(),
            extremes: Extremes::default(),
            solid: None,
            built_cost: 0.0,
            radius: 0.0,
            identity,
            lineage: identity,
        };
        tree.fit_cloud(boxes.as_deref());
        tree.built_cost = tree.profiles.cost;
        debug_assert_eq!(tree.validate(), Ok(()));
        tree
    }

    /// The points of a block, in tree order.
    pub(crate) fn block(&self, node: u32) -> Range<u32> {
        self.blocks.range(node - self.nodes.len() as u32)
    }

    /// Number of blocks of a cloud.
    pub(crate) fn block_count(&self) -> usize {
        self.blocks.count()
    }

    /// The block of a node number, if it is that of a block.
    #[inline(always)]
    pub(crate) fn block_of(&self, node: u32) -> Option<usize> {
        (node as usize).checked_sub(self.nodes.len())
    }

    /// The block of a point (tree order), and its place there.
    pub(crate) fn place_in_block(&self, point: u32) -> (usize, u32) {
        let block = self.blocks.of(point);
        (block as usize, point - self.blocks.start(block))
    }

    /// Computes all boxes and profiles of a cloud. The boxes of the blocks may be known. `O(n)`,
    /// and allocates nothing.
    pub(crate) fn fit_cloud(&mut self, boxes: Option<&[Extent]>) {
        let mut nodes = core::mem::take(&mut self.nodes);
        let mut profiles = core::mem::take(&mut self.profiles);
        Instructions::detect().run(Fit {
            numbers: 0..nodes.len(),
            nodes: &mut nodes,
            profiles: &mut profiles,
            extent: |block| boxes.map_or_else(|| self.extent(block as u32), |boxes| boxes[block]),
        });
        profiles.end(&mut nodes);
        (self.nodes, self.profiles) = (nodes, profiles);
    }

    /// [`leaf`](Self::leaf), apart from code for stored nodes.
    #[cold]
    #[inline(never)]
    pub(crate) fn made_leaf(&self, number: u32) -> Leaf {
        Instructions::detect().run(Make(self, number))
    }

    /// Number of points or triangles below the active children of a node.
    pub(crate) fn count_below(&self, number: u32, active: u8) -> u32 {
        let of_leaf = |children: usize| (u32::from(active) & ((1 << children) - 1)).count_ones();
        match self.nodes.get(number as usize) {
            Some(node) if node.is_leaf => of_leaf(node.children.into()),
            Some(node) => node.triangles,
            None => of_leaf(self.block(number).len()),
        }
    }

    /// The first point of the block of a point (both in tree order).
    #[cold]
    #[inline(never)]
    pub(crate) fn first_of_block(&self, point: u32) -> u32 {
        self.blocks.start(self.blocks.of(point))
    }

    #[inline(always)]
    pub(crate) fn leaf<L: Lanes>(&self, lanes: L, number: u32) -> Leaf {
        let range = self.block(number);
        let last = range.end - 1;
        let points = self.points(per_lane!(i => last.min(range.start + i as u32)));
        let count = range.end - range.start;
        let levels = LEVELS[count as usize % LEVELS.len()];
        let rows = per_lane!(i => &points[i].0[0]);
        let [x, y, z, _] = F8::columns(lanes, rows);
        let own = Extent::of([x, y, z]);
        let exists = present(lanes, count as usize);
        let mut node = Node {
            first_child: range.start,
            first_triangle: range.start,
            triangles: count,
            children: count as u8,
            is_leaf: true,
            height: 1,
            levels,
            center: [x, y, z].map(|x| (x * exists).halves()),
            self_cost: (count * count) as f32,
            ..Node::default()
        };
        node.set_orientation(&Orientation::IDENTITY);
        set_own(&mut node, &own);
        node.log_alpha = log_alpha(Vec3::ZERO, node.extent(), levels);
        Leaf { node, points }
    }

    /// Points (tree order) as the fast filters read triangles.
    #[inline(always)]
    pub(crate) fn points(&self, numbers: [u32; WIDTH]) -> Points {
        let (unit, ids) = (&self.unit, &self.ids);
        match self.mesh.vertices() {
            Vertices::F32(points) => per_lane!(i => {
                let [x, y, z] = points[ids[numbers[i] as usize] as usize];
                unit.place_point(DVec3::new(x.into(), y.into(), z.into()))
            }),
            Vertices::F64(points) => per_lane!(i => {
                unit.place_point(points[ids[numbers[i] as usize] as usize].into())
            }),
        }
    }
}

/// log2 of the numbers of points in a block.
const LEVELS: [f32; WIDTH + 1] = [
    0.0,
    0.0,
    1.0,
    1.584_962_5,
    2.0,
    2.321_928,
    2.584_962_6,
    2.807_355,
    3.0,
];

/// The ids of the points, halved across their longest extent, and each half again, down to blocks;
/// in a block in input order.
fn halved(mesh: &Mesh, unit: &Unit) -> Vec<u32> {
    let point = |id: usize| (unit.point(mesh.vertex(id)).as_vec3(), id as u32);
    let mut points: Vec<_> = (0..mesh.len()).map(point).collect();
    halve(&mut points);
    points.iter().map(|&(_, id)| id).collect()
}

fn halve(points: &mut [(Vec3, u32)]) {
    if points.len() <= WIDTH {
        return points.sort_unstable_by_key(|&(_, id)| id);
    }
    let (min, max) = points.iter().fold(
        (Vec3::INFINITY, Vec3::NEG_INFINITY),
        |(min, max), (p, _)| (min.min(*p), max.max(*p)),
    );
    let axis = (max - min).max_position();
    let middle = points.len().div_ceil(WIDTH) / 2 * WIDTH;
    // No two compare as equal, so the halves do not depend on how they are found.
    points.select_nth_unstable_by(middle, |(p, i), (q, j)| {
        p[axis].total_cmp(&q[axis]).then(i.cmp(j))
    });
    let (left, right) = points.split_at_mut(middle);
    halve(left);
    halve(right);
}

/// The ids of the points along a Hilbert curve with 2^10 cells an axis; in one cell in input order.
fn sorted(mesh: &Mesh, unit: &Unit) -> Vec<u32> {
    let mut sort = Sort::default();
    sort.keyed.reserve_exact(mesh.len());
    // From -1..=1 to the nearest of the cells, in the low bits of a sum with 2^52.
    let half = f64::from(CELLS - 1) * 0.5;
    let cell = |point: DVec3| {
        let cell = unit.point(point) * half + half;
        cell.to_array()
            .map(|x| (x + power_of_two(52)).to_bits() as u32 % CELLS)
    };
    match mesh.vertices() {
        Vertices::F32(points) => sort.push(points, |p| cell(Vec3::from(p).as_dvec3())),
        Vertices::F64(points) => sort.push(points, |p| cell(p.into())),
    }
    while !sort.advance(mesh.len()) {}
    sort.keyed.iter().map(|&(_, id)| id).collect()
}

/// Number of cells along an axis.
pub(crate) const CELLS: u32 = 1 << hilbert::BITS;

/// Sorts points by the places of their cells along a Hilbert curve; in one cell in their order. A
/// radix sort that may stop anywhere.
#[derive(Clone, Debug)]
pub(crate) struct Sort {
    /// Places and ids.
    pub keyed: Vec<(u32, u32)>,
    other: Vec<(u32, u32)>,
    /// For each pass and digit: the number of its points, then the place of its next point.
    counts: [[u32; CELLS as usize]; 3],
    pass: usize,
    /// The next point of the pass.
    at: usize,
}

impl Default for Sort {
    fn default() -> Self {
        Self {
            keyed: Vec::new(),
            other: Vec::new(),
            counts: [[0; CELLS as usize]; 3],
            pass: 0,
            at: 0,
        }
    }
}

impl Sort {
    pub fn clear(&mut self) {
        self.keyed.clear();
        self.counts = [[0; CELLS as usize]; 3];
        (self.pass, self.at) = (0, 0);
    }

    /// Appends points.
    #[inline(always)]
    pub fn push<P: Copy>(&mut self, points: &[P], cell: impl Fn(P) -> [u32; 3]) {
        // In two loops, because the first one compiles to vectors.
        for sixteen in points.chunks(16) {
            let mut codes = [0; 16];
            for (code, &point) in codes.iter_mut().zip(sixteen) {
                let [x, y, z] = cell(point).map(spread);
                *code = x | y << 1 | z << 2;
            }
            for code in codes.into_iter().take(sixteen.len()) {
                let place = hilbert::place(code);
                for (pass, counts) in self.counts.iter_mut().enumerate() {
                    counts[digit(place, pass)] += 1;
                }
                self.keyed.push((place, self.keyed.len() as u32));
            }
        }
    }

    /// Moves up to `most` points; true if they are sorted.
    pub fn advance(&mut self, most: usize) -> bool {
        let Self {
            keyed,
            other,
            pass,
            at,
            ..
        } = self;
        let Some(counts) = self.counts.get_mut(*pass) else {
            return true;
        };
        if *at == 0 {
            other.resize(keyed.len(), (0, 0));
            let mut next = 0;
            for count in &mut *counts {
                next += core::mem::replace(count, next);
            }
        }
        let end = keyed.len().min(at.saturating_add(most));
        let (digits, to) = (*pass, &mut other[..]);
        for &(place, id) in &keyed[*at..end] {
            let next = &mut counts[digit(place, digits)];
            to[*next as usize] = (place, id);
            *next += 1;
        }
        *at = end;
        if end == keyed.len() {
            core::mem::swap(keyed, other);
            (*pass, *at) = (*pass + 1, 0);
        }
        false
    }
}

#[inline(always)]
fn digit(place: u32, pass: usize) -> usize {
    (place >> (hilbert::BITS as usize * pass)) as usize % CELLS as usize
}

/// Moves bit `i` of ten to bit `3 i`.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Nodes over the blocks of eight of `sorted` points, still without boxes, and the order of the
/// blocks in them. Also the boxes of the blocks, in the order of the points.
fn nodes_above(
    mesh: &Mesh,
    unit: &Unit,
    sorted: &[u32],
    effort: Effort,
) -> (Box<[Node]>, Vec<u32>, Vec<Extent>) {
    let boxes = sorted.chunks(WIDTH).map(|ids| extent(mesh, unit, ids));
    let boxes: Vec<_> = boxes.collect();
    let bounds = boxes.iter().zip(0..);
    let bounds = bounds.map(|(extent, block)| extent.bounds(block));
    let tree = binary::over(bounds.collect(), effort, Pieces::ONE);
    let plan = Plan::of(&tree, &Orientation::IDENTITY);
    (plan.nodes, tree.order, boxes)
}

struct Make<'t>(&'t Tree, u32);

impl Kernel for Make<'_> {
    type Output = Leaf;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Leaf {
        self.0.leaf(lanes, self.1)
    }
}

/// Computes boxes and profiles of some nodes of a cloud, bottom-up as [`update`](crate::tree::fit::update):
/// of `numbers`, once those behind them are done. `extent` gives the box of a block.
pub(crate) struct Fit<'n, E> {
    pub nodes: &'n mut [Node],
    pub profiles: &'n mut Profiles,
    pub numbers: Range<usize>,
    pub extent: E,
}

impl<E: Fn(usize) -> Extent> Kernel for Fit<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self {
            nodes, profiles, ..
        } = self;
        let count = nodes.len();
        for number in self.numbers.rev() {
            let Some((node, later)) = nodes[number..].split_first_mut() else {
                continue;
            };
            let first = node.first_child as usize;
            let (mut own, mut area) = (Extent::EMPTY, 0.0);
            for lane in (0..usize::from(node.children)).rev() {
                let child = first + lane;
                let extent = if child < count {
                    let child = &mut later[child - number - 1];
                    let ends = Extent::kept_in(child);
                    area += child.size;
                    set_own(child, &ends);
                    ends
                } else {
                    (self.extent)(child - count)
                };
                let (center, half) = (extent.center(), extent.half());
                for k in 0..3 {
                    node.center[k][lane / 4].as_mut_array()[lane % 4] = center[k];
                    node.half[k][lane / 4].as_mut_array()[lane % 4] = half[k];
                }
                own = own.union(extent);
            }
            let mut levels = Levels {
                levels: &mut profiles.levels,
                first: 0,
            };
            let half = own.half().to_array();
            area += if first < count {
                let children = &later[first - number - 1..][..usize::from(node.children)];
                levels.measure(lanes, node, half, children)
            } else {
                levels.measure_blocks(lanes, node, half)
            };
            keep(node, &own, area);
        }
    }
}

impl Tree {
    /// The box around the points of a block.
    #[inline(always)]
    fn extent(&self, block: u32) -> Extent {
        let Range { start, end } = self.blocks.range(block);
        extent(
            &self.mesh,
            &self.unit,
            &self.ids[start as usize..end as usize],
        )
    }
}

/// The box around some points.
#[inline(always)]
fn extent(mesh: &Mesh, unit: &Unit, ids: &[u32]) -> Extent {
    match mesh.vertices() {
        Vertices::F32(points) => unit.extent(ids.iter().map(|&id| points[id as usize])),
        Vertices::F64(points) => {
            let ends = ids.iter().map(|&id| unit.point(points[id as usize].into()));
            ends.fold(Extent::EMPTY, |mut extent, point| {
                extent.add(point.as_vec3a());
                extent
            })
        }
    }
}
