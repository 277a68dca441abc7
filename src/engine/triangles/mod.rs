//! Triangle pairs that wait for the fast filter: a stack with room for everything that one step can
//! add.

pub(crate) mod corners;

use crate::tree::{Points, Tree, WIDTH};
use arrayvec::ArrayVec;
use punctual_geom::bits;
use punctual_geom::lanes::per_lane;
use punctual_geom::triangle::batch::Rows;

/// Maximum number of triangle pairs that wait before they are tested.
pub(crate) const PATIENCE: usize = 128;

/// Room for many leaves with all pairs in doubt; a power of two.
const CAPACITY: usize = 1 << 12;

/// Triangle pairs that one opened node pair can add.
const BLOCK: usize = 64;

/// A stack of triangle pairs, in tree order.
pub(crate) type TrianglePairs = ArrayVec<[u32; 2], CAPACITY>;

/// True if the triangle pairs of one more opened node pair may not fit.
pub(crate) fn is_full(waiting: &TrianglePairs) -> bool {
    waiting.remaining_capacity() < BLOCK
}

/// Adds the pairs `first + [i, j]` for the bits `8 i + j` of `hits`. There must be room.
#[inline(always)]
pub(crate) fn push_all(waiting: &mut TrianglePairs, hits: u64, first: [u32; 2]) {
    for bit in bits(hits) {
        waiting.push([first[0] + bit as u32 / 8, first[1] + bit as u32 % 8]);
    }
}

/// Takes up to eight pairs, at most `limit`, from the top, and fills the other lanes with one of
/// them.
#[inline(always)]
pub(crate) fn pop_batch(waiting: &mut TrianglePairs, limit: usize) -> ([[u32; 2]; 8], usize) {
    let count = waiting.len().min(limit).min(8);
    let taken = &waiting[waiting.len() - count..];
    let batch = if let Some(eight) = taken.first_chunk() {
        *eight
    } else {
        let mut batch = [taken.first().copied().unwrap_or_default(); 8];
        batch[..count].copy_from_slice(taken);
        batch
    };
    waiting.truncate(waiting.len() - count);
    (batch, count)
}

/// The ids in the input meshes of a triangle pair (tree order).
#[inline(always)]
pub(crate) fn ids([a, b]: [&Tree; 2], pair: [u32; 2]) -> [u32; 2] {
    [a.ids()[pair[0] as usize], b.ids()[pair[1] as usize]]
}

/// The points of one side of eight pairs, if the tree is that of a cloud. `POINTS` as in
/// [`super::traversal::Traversal`].
#[inline(always)]
pub(crate) fn points<const POINTS: bool>(
    tree: &Tree,
    pairs: [[u32; 2]; WIDTH],
    side: usize,
) -> Option<Points> {
    (POINTS && tree.is_cloud()).then(|| tree.points(per_lane!(i => pairs[i][side])))
}

/// The triangles of one side of eight pairs, or its [`points`] in a cloud. Written out, because a
/// closure would not be compiled for the kernel's instruction set.
#[inline(always)]
pub(crate) fn rows<'t>(
    tree: &'t Tree,
    points: &'t Option<Points>,
    [p, q, r, s, t, u, v, w]: [[u32; 2]; WIDTH],
    side: usize,
) -> [&'t Rows; WIDTH] {
    if let Some(points) = points {
        return per_lane!(i => &points[i].0);
    }
    let triangles = tree.triangles();
    macro_rules! row {
        ($pair:ident) => {
            &triangles[$pair[side] as usize].0
        };
    }
    [
        row!(p),
        row!(q),
        row!(r),
        row!(s),
        row!(t),
        row!(u),
        row!(v),
        row!(w),
    ]
}
