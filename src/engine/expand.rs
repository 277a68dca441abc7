//! Replaces a node pair by the pairs of its children that are of interest: that may overlap or be
//! close.
//!
//! The boxes of the two nodes are compared first, in the orientations of both, and slim ones on
//! their edge axes. Then the larger node is opened, or both if their sizes are similar. Triangles
//! of a leaf paired with a smaller inner node stay together: up to eight of them descend the
//! tree as one pair, with an active mask of those still of interest.

use super::boxes::edge_axes;
use super::boxes::relative_pose::{RelativePose, Views};
use super::boxes::{Extents, Facing, Slabs, StoredExtents, Triangles};
use super::frontier::Pair;
use super::outcome::Stats;
use crate::model::cost::{WORK_PER_CLOSE_TEST, WORK_PER_EDGE_TEST};
use crate::tree::{Leaf, Node, Points, Tree, WIDTH};
use punctual_geom::bits;
use punctual_geom::lanes::{F8, Kernel, Lanes, all, per_lane, per_part};
use punctual_geom::triangle::batch::Rows;

/// The keys of pairs of children: entry `[i][j]` is for child `i` of the opened node and child `j`
/// of the other, and so is bit `8 i + j` of a mask of pairs.
pub(crate) type Keys = [[f32; WIDTH]; WIDTH];

/// Buffers for opening pairs of two trees.
#[derive(Default)]
pub(crate) struct Scratch {
    keys: Keys,
    leaves: [MadeLeaf; 2],
}

/// The leaf of a cloud that was made last, with its number: successive pairs often share a leaf.
pub(crate) type MadeLeaf = Option<(u32, Leaf)>;

/// The key of a bit of a mask of pairs.
#[inline(always)]
pub(crate) fn key_of(keys: &Keys, bit: usize) -> f32 {
    keys.as_flattened()[bit % (WIDTH * WIDTH)]
}

/// The measure of a question: it compares pairs of boxes, selects those of interest, and assigns
/// keys to them.
pub(crate) trait Measure {
    /// True if the question is overlap alone. Then edge axes can separate boxes, and keys are
    /// depths.
    const IS_OVERLAP: bool = false;

    /// True if the test of all pairs of children is compiled once, because it is large and called
    /// from several places. It then also stops early, which needs an unpredictable branch.
    const IS_LARGE: bool = false;

    /// Work of opening a pair, and of each BV test.
    const WORK: [u64; 2];

    /// The comparison of two boxes along the axes of one node.
    type Along<L: Lanes>: Copy;

    /// True if a pair is of interest by the own boxes of both nodes. A child first passes the test
    /// along its parent's axes; this test is along its own axes.
    fn own(&mut self, nodes: [&Node; 2], views: &Views, relative: &RelativePose) -> bool;

    /// True if the pair is of interest only because of the margins of `f32`.
    #[inline(always)]
    fn is_in_doubt(&self) -> bool {
        false
    }

    /// True if `f64` shows that a pair in doubt is of no interest.
    #[inline(always)]
    fn is_parted(&mut self, _nodes: [&Node; 2], _views: &Views, _relation: &RelativePose) -> bool {
        false
    }

    /// The children of node `k` of two.
    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: &Facing, k: usize) -> Extents<L> {
        let boxes = facing.children(lanes, k);
        Extents {
            own: boxes.slabs(),
            seen: boxes.seen(lanes, facing.views[k]).slabs(),
            ahead: F8::splat(lanes, 0.0),
        }
    }

    /// The own box of node `k` of two, eight times.
    #[inline(always)]
    fn own_box<L: Lanes>(&self, lanes: L, facing: &Facing, k: usize) -> Extents<L> {
        let ((center, half), view) = (facing.own(k), facing.views[k]);
        Extents {
            own: Slabs::of_box(lanes, center, half),
            seen: Slabs::of_box(lanes, view.point(center), view.half(half)),
            ahead: F8::splat(lanes, 0.0),
        }
    }

    /// Compares boxes of the second node with boxes of the opened one, lane by lane.
    fn compare<L: Lanes>(&self, lanes: L, other: &Slabs<L>, opened: &Slabs<L>) -> Self::Along<L>;

    /// The keys of boxes from the comparisons along the axes of both nodes, and from the sum of
    /// their ends along one more direction.
    fn key<L: Lanes>(
        &self,
        lanes: L,
        in_opened: Self::Along<L>,
        in_other: Self::Along<L>,
        ahead: F8<L>,
    ) -> F8<L>;

    /// Mask of the lanes with keys of interest.
    fn hits<L: Lanes>(&self, lanes: L, keys: F8<L>) -> u32;

    /// The least number of triangle pairs for which [`Measure::refine`] pays, and its work.
    const REFINED: Option<(u32, u64)> = None;

    /// Drops, from the triangle pairs `hits` of two leaves whose boxes are of interest, those that
    /// are not.
    #[inline(always)]
    fn refine<L: Lanes>(
        &self,
        _lanes: L,
        hits: u64,
        _rows: [[&Rows; WIDTH]; 2],
        _keys: &Keys,
    ) -> u64 {
        hits
    }

    /// Tests the active children of two nodes against each other.
    #[inline(always)]
    fn both<L: Lanes>(&self, lanes: L, facing: &Facing, active: [u32; 2], keys: &mut Keys) -> u64
    where
        Self: Sized,
    {
        eight_by_eight(lanes, self, facing, active, keys)
    }

    /// Tests the active triangles of a leaf, the opened node, against the children of the other
    /// node. By default only their boxes.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: &Facing,
        active: u32,
        _triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64
    where
        Self: Sized,
    {
        eight_by_eight(lanes, self, facing, [active, facing.nodes[1].valid()], keys)
    }
}

/// The triangles of two leaves.
pub(crate) type LeafRows<'t> = [[&'t Rows; WIDTH]; 2];

/// Receives the children of an opened pair.
pub(crate) trait Sink {
    /// The counts of the run.
    fn stats(&mut self) -> &mut Stats;

    /// Receives node pairs, one for each bit of `hits`. `child` makes the pair of a bit.
    #[inline(always)]
    fn pairs(&mut self, hits: u64, keys: &Keys, child: impl Fn(u32) -> Pair) {
        for bit in bits(hits) {
            self.place(child(bit as u32), || key_of(keys, bit));
        }
    }

    /// Receives a node pair, such as the active triangles of a leaf and a child of the other
    /// side.
    fn place(&mut self, pair: Pair, key: impl FnOnce() -> f32);

    /// Receives the triangle pairs `first + [i, j]` for the bits `8 i + j` of `hits`, in tree
    /// order. `rows` returns the triangles of both leaves.
    fn triangles<'t, L: Lanes>(
        &mut self,
        lanes: L,
        hits: u64,
        key: impl Fn(usize) -> f32,
        first: [u32; 2],
        rows: impl FnOnce() -> LeafRows<'t>,
    );
}

/// Replaces a pair by the pairs of children that are of interest. `POINTS` as in
/// [`super::traversal::Traversal`].
#[inline(always)]
pub(crate) fn expand<const POINTS: bool, L: Lanes, M: Measure>(
    lanes: L,
    pair: Pair,
    [tree_a, tree_b]: [&Tree; 2],
    relative: &RelativePose,
    measure: &mut M,
    scratch: &mut Scratch,
    sink: &mut impl Sink,
) {
    let (keys, [leaf_a, leaf_b]) = (&mut scratch.keys, &mut scratch.leaves);
    let ([ia, ib], active, scale) = (pair.nodes, pair.active, relative.scale);
    // The pair with a child in place of the node of A, or of B. All children of that child are
    // active.
    let with_child = move |is_a: bool, child: u32, active: [u8; 2]| {
        let (nodes, active) = if is_a {
            ([child, ib], [u8::MAX, active[1]])
        } else {
            ([ia, child], [active[0], u8::MAX])
        };
        Pair { nodes, active }
    };
    let (a, points_a) = node::<POINTS, L>(lanes, tree_a, ia, leaf_a);
    let (b, points_b) = node::<POINTS, L>(lanes, tree_b, ib, leaf_b);
    let views = Views::between(a, b, relative);
    if !measure.own([a, b], &views, relative)
        || measure.is_in_doubt() && {
            sink.stats().work += WORK_PER_CLOSE_TEST;
            measure.is_parted([a, b], &views, relative)
        }
        || M::IS_OVERLAP && edge_axes::are_slim(a, b) && {
            sink.stats().work += WORK_PER_EDGE_TEST;
            edge_axes::part(a, b, &views.of_b, relative)
        }
    {
        return count::<M>(sink.stats(), 1);
    }
    // Kept in memory: the kernels broadcast single entries, which is slow from registers.
    let views = core::hint::black_box(&views);
    let valid = [
        u32::from(active[0]) & a.valid(),
        u32::from(active[1]) & b.valid(),
    ];
    let first = [a.first_child, b.first_child];
    let of_a = Facing {
        nodes: [a, b],
        views: [&views.of_a, &views.of_b],
        scales: [1.0, scale],
        is_a: true,
    };
    let of_b = Facing {
        nodes: [b, a],
        views: [&views.of_b, &views.of_a],
        scales: [scale, 1.0],
        is_a: false,
    };
    match which(a, b, scale) {
        Open::Both => {
            let tests = valid[0].count_ones() * valid[1].count_ones() + 1;
            count::<M>(sink.stats(), tests);
            let hits = measure.both(lanes, &of_a, valid, keys);
            let key = |bit| key_of(keys, bit);
            if a.is_leaf {
                let mut hits = hits;
                let rows = || [rows(tree_a, points_a, a), rows(tree_b, points_b, b)];
                if let Some((_, work)) = M::REFINED.filter(|(many, _)| hits.count_ones() >= *many) {
                    sink.stats().work += work;
                    hits = measure.refine(lanes, hits, rows(), keys);
                }
                sink.triangles(lanes, hits, key, first, rows);
            } else {
                sink.pairs(hits, keys, |bit| {
                    Pair::new(first[0] + bit / 8, first[1] + bit % 8)
                });
            }
        }
        Open::One { is_a } => {
            let facing = if is_a { &of_a } else { &of_b };
            let opened = facing.nodes[0];
            count::<M>(sink.stats(), u32::from(opened.children) + 1);
            let (children, other) = (
                measure.children(lanes, facing, 0),
                measure.own_box(lanes, facing, 1),
            );
            let near = key(lanes, measure, &children, &other);
            near.put(&mut keys[0]);
            let hits = measure.hits(lanes, near) & opened.valid();
            sink.pairs(hits.into(), keys, |i| {
                with_child(is_a, opened.first_child + i, active)
            });
        }
        Open::Triangles { is_a } => {
            let (facing, tree, points, of_one) = if is_a {
                (&of_a, tree_a, points_a, valid[0])
            } else {
                (&of_b, tree_b, points_b, valid[1])
            };
            let [one, other] = facing.nodes;
            let tests = of_one.count_ones() * u32::from(other.children) + 1;
            count::<M>(sink.stats(), tests);
            let triangles = || Triangles {
                rows: rows(tree, points, one),
                view: views.triangles(is_a, other, relative),
                rotation_error: relative.rotation_error,
            };
            let hits = measure.triangles(lanes, facing, of_one, triangles, keys);
            let child = |j, active| with_child(!is_a, other.first_child + j, [active; 2]);
            leaves::<M>(hits, of_one, keys, sink, child);
        }
    }
}

/// Counts the BV tests of a pair that is opened.
#[inline(always)]
fn count<M: Measure>(stats: &mut Stats, bv_tests: u32) {
    let [opening, test] = M::WORK;
    stats.bv_tests += u64::from(bv_tests);
    stats.work += opening + test * u64::from(bv_tests);
}

/// The keys of pairs of boxes, lane by lane.
#[inline(always)]
pub(crate) fn key<L: Lanes, M: Measure>(
    lanes: L,
    measure: &M,
    opened: &Extents<L>,
    other: &Extents<L>,
) -> F8<L> {
    measure.key(
        lanes,
        measure.compare(lanes, &other.seen, &opened.own),
        measure.compare(lanes, &other.own, &opened.seen),
        other.ahead + opened.ahead,
    )
}

/// Tests the active children of two nodes against each other.
#[inline(always)]
fn eight_by_eight<L: Lanes, M: Measure>(
    lanes: L,
    measure: &M,
    facing: &Facing,
    active: [u32; 2],
    keys: &mut Keys,
) -> u64 {
    let test = EightByEight {
        measure,
        facing,
        active,
        keys,
    };
    if M::IS_LARGE {
        lanes.run(test)
    } else {
        test.run(lanes)
    }
}

struct EightByEight<'k, M> {
    measure: &'k M,
    facing: &'k Facing<'k>,
    active: [u32; 2],
    keys: &'k mut Keys,
}

impl<M: Measure> Kernel for EightByEight<'_, M> {
    type Output = u64;

    /// First each side's children against the other's own box, along the axes of the latter; then
    /// the pairs of those left.
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> u64 {
        let Self {
            measure,
            facing,
            keys,
            ..
        } = self;
        let [mut active_x, mut active_y] = self.active;
        let (x, y) = (
            measure.children(lanes, facing, 0),
            measure.children(lanes, facing, 1),
        );
        let (own_x, own_y) = (
            measure.own_box(lanes, facing, 0),
            measure.own_box(lanes, facing, 1),
        );
        let in_x = measure.compare(lanes, &y.seen, &own_x.own);
        active_y &= measure.hits(lanes, measure.key(lanes, in_x, in_x, y.ahead + own_x.ahead));
        // Without whole registers, an unpredictable branch costs more than it saves.
        if (M::IS_LARGE || !L::IS_WHOLE) && active_y == 0 {
            return 0;
        }
        let in_y = measure.compare(lanes, &own_y.own, &x.seen);
        active_x &= measure.hits(lanes, measure.key(lanes, in_y, in_y, own_y.ahead + x.ahead));
        let (x, y) = (StoredExtents::of(&x), StoredExtents::of(&y));
        let mut pairs = 0;
        per_part!(lanes: L, part => {
            let active_y = active_y & all(part);
            let mut active_x = if L::IS_WHOLE || active_y != 0 { active_x } else { 0 };
            let y = y.load(part);
            while active_x != 0 {
                let i = active_x.trailing_zeros() as usize % WIDTH;
                active_x &= active_x - 1;
                let near = key(part, measure, &x.at(part, i), &y);
                near.put(&mut keys[i]);
                pairs |= u64::from(measure.hits(part, near) & active_y) << (WIDTH * i);
            }
        });
        pairs
    }
}

/// The child, a column, that a single triangle penetrates most: a hit is most likely there.
#[inline(always)]
fn deepest(mut columns: u32, depths: &[f32; WIDTH]) -> usize {
    let mut deepest = columns.trailing_zeros() as usize % WIDTH;
    while columns != 0 {
        let column = columns.trailing_zeros() as usize % WIDTH;
        columns &= columns - 1;
        // A select, not a branch, because the comparison is unpredictable.
        deepest = if depths[column] > depths[deepest] {
            column
        } else {
            deepest
        };
    }
    deepest
}

/// Passes on the active triangles of a leaf, the `active` rows of `hits`, with each child of the
/// other side, a column. The pair passed last is visited next.
#[inline(always)]
fn leaves<M: Measure>(
    hits: u64,
    active: u32,
    keys: &Keys,
    sink: &mut impl Sink,
    pair: impl Fn(u32, u8) -> Pair,
) {
    if M::IS_OVERLAP && active.is_power_of_two() {
        if hits == 0 {
            return;
        }
        let row = active.trailing_zeros() as usize % WIDTH;
        let columns = (hits >> (WIDTH * row)) as u32;
        let last = deepest(columns, &keys[row]);
        for column in bits(columns & !(1 << last)) {
            sink.place(pair(column as u32, active as u8), || keys[row][column]);
        }
        return sink.place(pair(last as u32, active as u8), || keys[row][last]);
    }
    for (column, active) in transposed(hits).to_le_bytes().into_iter().enumerate() {
        if active != 0 {
            sink.place(pair(column as u32, active), || {
                bits(active)
                    .map(|row| keys[row % WIDTH][column])
                    .fold(f32::INFINITY, f32::min)
            });
        }
    }
}

/// The side of a pair that is opened.
enum Open {
    Both,
    /// Opens the children of one side.
    One {
        is_a: bool,
    },
    /// Opens the triangles of a leaf, against the children of the other side.
    Triangles {
        is_a: bool,
    },
}

/// The larger of two inner nodes is opened alone if it is more than this many times larger than the
/// other.
const LARGER: f32 = 3.0;

#[inline(always)]
fn which(a: &Node, b: &Node, scale: f32) -> Open {
    let (size_a, size_b) = (a.size, b.size * scale);
    match (a.is_leaf, b.is_leaf) {
        (true, true) => Open::Both,
        (true, false) if size_a > size_b => Open::Triangles { is_a: true },
        (true, false) => Open::One { is_a: false },
        (false, true) if size_b > size_a => Open::Triangles { is_a: false },
        (false, true) => Open::One { is_a: true },
        (false, false) if size_a > LARGER * size_b => Open::One { is_a: true },
        (false, false) if size_b > LARGER * size_a => Open::One { is_a: false },
        (false, false) => Open::Both,
    }
}

/// A node, and its points if it is a leaf of a cloud. Makes that leaf unless it is the last one
/// made.
#[inline(always)]
pub(crate) fn node<'t, const POINTS: bool, L: Lanes>(
    lanes: L,
    tree: &'t Tree,
    number: u32,
    made: &'t mut MadeLeaf,
) -> (&'t Node, Option<&'t Points>) {
    if !POINTS || (number as usize) < tree.nodes().len() {
        return (&tree.nodes()[number as usize], None);
    }
    let is_made = matches!(made, Some((made, _)) if *made == number);
    if !is_made {
        *made = Some((number, tree.leaf(lanes, number)));
    }
    let (_, leaf) = made.as_ref().expect("the leaf is made");
    (&leaf.node, Some(&leaf.points))
}

/// The triangles of a leaf, or its `points` in a cloud; the last one is repeated if there are fewer
/// than eight. Not a loop, whose end would be unpredictable.
#[inline(always)]
pub(crate) fn rows<'t>(
    tree: &'t Tree,
    points: Option<&'t Points>,
    leaf: &Node,
) -> [&'t Rows; WIDTH] {
    if let Some(points) = points {
        return per_lane!(i => &points[i].0);
    }
    let triangles = &tree.triangles()[leaf.triangle_range()];
    let last = triangles.len() - 1;
    per_lane!(i => &triangles[last.min(i)].0)
}

/// Transposes an 8 x 8 bit matrix: moves bit `8 i + j` to `8 j + i`, by swapping blocks of 1, 2 and
/// 4 across the diagonal.
#[inline(always)]
fn transposed(mut bits: u64) -> u64 {
    for (shift, mask) in [
        (7, 0x00aa_00aa_00aa_00aa),
        (14, 0x0000_cccc_0000_cccc),
        (28, 0x0000_0000_f0f0_f0f0),
    ] {
        let moved = (bits ^ (bits >> shift)) & mask;
        bits ^= moved ^ (moved << shift);
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::transposed;

    #[test]
    fn transposing_moves_each_bit_across_the_diagonal() {
        for i in 0..8 {
            for j in 0..8 {
                assert_eq!(transposed(1 << (8 * i + j)), 1 << (8 * j + i));
            }
        }
        assert_eq!(
            transposed(transposed(0x0123_4567_89ab_cdef)),
            0x0123_4567_89ab_cdef
        );
    }
}
