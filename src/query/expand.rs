//! Replaces a node pair by the pairs of its children that are of interest: that may overlap or be
//! close.
//!
//! The boxes of the two nodes are compared first, in the orientations of both, and slim ones on
//! their edge axes. Then the larger node is opened, or both if their sizes are similar. Triangles
//! of a cluster paired with a smaller inner node stay together: up to eight of them descend the
//! tree as one pair, with an active mask of those still of interest.

use super::boxes::{BoxTest, Facing, Keys, Triangles};
use super::edge_axes;
use super::queue::Pair;
use super::views::{Relation, Views};
use crate::model::cost::{WORK_PER_CLOSE_TEST, WORK_PER_EDGE_TEST};
use crate::tree::{Node, Tree, WIDTH};
use punctual_geom::lanes::{Lanes, per_lane};
use punctual_geom::triangle::batch::Rows;

/// Receives the children of an opened pair.
pub(super) trait Sink {
    /// Counts BV tests on a level of the bounding volume test tree.
    fn count(&mut self, level: usize, bv_tests: u32);

    /// Adds the work of a test on edge axes, or in `f64`.
    #[inline(always)]
    fn spend(&mut self, _work: u64) {}

    /// The table into which box tests write the keys of pairs of children.
    fn keys(&mut self) -> &mut Keys;

    /// Receives node pairs, one for each bit of `hits`. `child` makes the pair of a bit, and entry
    /// `i` of the table is the key of bit `i`.
    fn pairs(&mut self, hits: u64, child: impl Fn(u32) -> Pair);

    /// Receives the active triangles of a cluster, rows of the table, paired with a child of the
    /// other side, a column.
    fn cluster(&mut self, pair: Pair, column: usize);

    /// Receives the triangle pairs `first + [i, j]` for the bits `8 i + j` of `hits`, in tree
    /// order.
    fn triangles(&mut self, hits: u64, first: [u32; 2]);
}

/// Replaces a pair by the pairs of children that are of interest.
#[inline(always)]
pub(super) fn expand<L: Lanes, T: BoxTest>(
    lanes: L,
    Pair {
        nodes: [ia, ib],
        alive,
    }: Pair,
    [tree_a, tree_b]: [&Tree; 2],
    relation: &Relation,
    boxes: &mut T,
    sink: &mut impl Sink,
) {
    // The pair with a child in place of the node of A, or of B. All children of that child are
    // active.
    let with_child = move |is_a: bool, child: u32, alive: [u8; 2]| {
        if is_a {
            Pair {
                nodes: [child, ib],
                alive: [u8::MAX, alive[1]],
            }
        } else {
            Pair {
                nodes: [ia, child],
                alive: [alive[0], u8::MAX],
            }
        }
    };
    let scale = relation.scale;
    let (a, b) = (&tree_a.nodes()[ia as usize], &tree_b.nodes()[ib as usize]);
    let level = usize::from(a.depth) + usize::from(b.depth);
    let views = boxes.views(lanes, a, b, relation);
    if !boxes.own(lanes, a, b, &views, scale)
        || boxes.is_in_doubt() && {
            sink.spend(WORK_PER_CLOSE_TEST);
            boxes.is_parted(a, b, &views, relation)
        }
        || T::IS_OVERLAP && are_parted(a, b, &views, relation, sink)
    {
        return sink.count(level, 1);
    }
    // Kept in memory: the kernels broadcast single entries, which is slow from registers.
    let views = if T::READS_VIEWS {
        core::hint::black_box(&views)
    } else {
        &views
    };
    let valid = [
        u32::from(alive[0]) & a.valid(),
        u32::from(alive[1]) & b.valid(),
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
            sink.count(level + 2, lanes.count(valid[0]) * lanes.count(valid[1]) + 1);
            // One copy of the test where one serves both; two copies make the loop slower.
            let hits = if a.is_cluster && !T::OPENS_CLUSTERS_ALIKE {
                let rows = || [rows(tree_a, a), rows(tree_b, b)];
                boxes.clusters(lanes, of_a, valid, rows, sink.keys())
            } else {
                boxes.both(lanes, of_a, valid, sink.keys())
            };
            if a.is_cluster {
                sink.triangles(hits, first);
            } else {
                sink.pairs(hits, |bit| {
                    Pair::new(first[0] + bit / 8, first[1] + bit % 8)
                });
            }
        }
        Open::One { is_a } => {
            let facing = if is_a { of_a } else { of_b };
            let first = facing.nodes[0].first_child;
            sink.count(level + 1, u32::from(facing.nodes[0].children) + 1);
            let hits = boxes.children(lanes, facing, sink.keys());
            sink.pairs(hits.into(), |i| with_child(is_a, first + i, alive));
        }
        Open::Triangles { is_a } => {
            let (facing, tree, of_one) = if is_a {
                (of_a, tree_a, valid[0])
            } else {
                (of_b, tree_b, valid[1])
            };
            let [one, other] = facing.nodes;
            sink.count(
                level + 2,
                lanes.count(of_one) * u32::from(other.children) + 1,
            );
            let view = || {
                let place = &relation.place;
                if is_a {
                    views.triangles_of_a(b, place)
                } else {
                    views.triangles_of_b(a, place, scale)
                }
            };
            let triangles = || Triangles {
                rows: rows(tree, one),
                view: view(),
                skew: relation.skew,
            };
            let hits = boxes.triangles(lanes, facing, of_one, triangles, sink.keys());
            let first = other.first_child;
            clusters::<T>(hits, of_one, sink, |j, alive| {
                with_child(!is_a, first + j, [alive; 2])
            });
        }
    }
}

/// True if an edge axis separates the boxes of two nodes; tested only if they are slim.
#[inline(always)]
fn are_parted(
    a: &Node,
    b: &Node,
    views: &Views,
    relation: &Relation,
    sink: &mut impl Sink,
) -> bool {
    if !edge_axes::are_slim(a, b) {
        return false;
    }
    sink.spend(WORK_PER_EDGE_TEST);
    edge_axes::part(a, b, &views.of_b, relation)
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

/// Passes on the active triangles of a cluster, the `alive` rows of `hits`, with each child of the
/// other side, a column. The pair passed last is visited next.
#[inline(always)]
fn clusters<T: BoxTest>(
    hits: u64,
    alive: u32,
    sink: &mut impl Sink,
    pair: impl Fn(u32, u8) -> Pair,
) {
    if T::IS_OVERLAP && alive.is_power_of_two() {
        if hits == 0 {
            return;
        }
        let row = alive.trailing_zeros() as usize % WIDTH;
        let mut columns = (hits >> (WIDTH * row)) as u32;
        let last = deepest(columns, &sink.keys()[row]);
        columns &= !(1 << last);
        while columns != 0 {
            let column = columns.trailing_zeros();
            columns &= columns - 1;
            sink.cluster(pair(column, alive as u8), column as usize);
        }
        return sink.cluster(pair(last as u32, alive as u8), last);
    }
    for (column, alive) in transposed(hits).to_le_bytes().into_iter().enumerate() {
        if alive != 0 {
            sink.cluster(pair(column as u32, alive), column);
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
    /// Opens the triangles of a cluster, against the children of the other side.
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
    match (a.is_cluster, b.is_cluster) {
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

/// The triangles of a cluster; the last one is repeated if there are fewer than eight. Not a loop,
/// whose end would be unpredictable.
#[inline(always)]
pub(super) fn rows<'t>(tree: &'t Tree, cluster: &Node) -> [&'t Rows; WIDTH] {
    let triangles = &tree.triangles()[cluster.triangle_range()];
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
