//! Triangle pairs that wait for the fast filter: a stack with room for everything that one step can
//! add.

use crate::tree::{Tree, WIDTH};
use alloc::boxed::Box;
use punctual_geom::bits;
use punctual_geom::triangle::batch::Rows;

/// Maximum number of triangle pairs that wait before they are tested.
pub(super) const PATIENCE: usize = 128;

/// Room for many leaves with all pairs in doubt; a power of two.
const CAPACITY: usize = 1 << 12;

/// Triangle pairs that one opened node pair can add.
const BLOCK: usize = 64;

/// A stack of triangle pairs, in tree order.
#[derive(Clone, Debug)]
pub(super) struct TrianglePairs {
    pairs: Box<[[u32; 2]; CAPACITY]>,
    len: usize,
}

impl TrianglePairs {
    pub fn new() -> Self {
        Self {
            pairs: Box::new([[0; 2]; CAPACITY]),
            len: 0,
        }
    }

    pub fn len(&self) -> usize {
        self.len
    }

    /// True if the triangle pairs of one more opened node pair may not fit.
    pub fn is_full(&self) -> bool {
        self.len + BLOCK > CAPACITY
    }

    pub fn clear(&mut self) {
        self.len = 0;
    }

    pub fn as_slice(&self) -> &[[u32; 2]] {
        &self.pairs[..self.len]
    }

    /// Adds the pairs `first + [i, j]` for the bits `8 i + j` of `hits`. There must be room.
    #[inline(always)]
    pub fn push_all(&mut self, hits: u64, first: [u32; 2]) {
        debug_assert!(self.len + hits.count_ones() as usize <= CAPACITY);
        let mut len = self.len;
        for bit in bits(hits) {
            // The remainder removes the compiler's bounds check.
            self.pairs[len % CAPACITY] = [first[0] + bit as u32 / 8, first[1] + bit as u32 % 8];
            len += 1;
        }
        self.len = len;
    }

    /// Adds a few pairs to an empty stack.
    pub fn extend(&mut self, pairs: &[[u32; 2]]) {
        for &pair in pairs.iter().take(PATIENCE) {
            self.pairs[self.len] = pair;
            self.len += 1;
        }
    }

    /// Keeps the pairs for which `keep` returns true.
    pub fn retain(&mut self, mut keep: impl FnMut(&[u32; 2]) -> bool) {
        let len = core::mem::take(&mut self.len);
        for i in 0..len {
            let pair = self.pairs[i];
            if keep(&pair) {
                self.pairs[self.len] = pair;
                self.len += 1;
            }
        }
    }

    /// Takes up to eight pairs, at most `limit`, from the top, and fills the other lanes with one
    /// of them.
    #[inline(always)]
    pub fn pop_batch(&mut self, limit: usize) -> ([[u32; 2]; 8], usize) {
        let count = self.len.min(limit).min(8);
        self.len -= count;
        let mut batch = [self.pairs[self.len % CAPACITY]; 8];
        if let Some(eight) = self.pairs[self.len..].first_chunk()
            && count == 8
        {
            batch = *eight;
        } else {
            batch[..count].copy_from_slice(&self.pairs[self.len..][..count]);
        }
        (batch, count)
    }
}

/// The ids in the input meshes of a triangle pair (tree order).
#[inline(always)]
pub(super) fn ids([a, b]: [&Tree; 2], pair: [u32; 2]) -> [u32; 2] {
    [a.ids()[pair[0] as usize], b.ids()[pair[1] as usize]]
}

/// The triangles of one side of eight pairs. Written out, because a closure would not be compiled
/// for the kernel's instruction set.
#[inline(always)]
pub(super) fn rows(
    tree: &Tree,
    [p, q, r, s, t, u, v, w]: [[u32; 2]; WIDTH],
    side: usize,
) -> [&Rows; WIDTH] {
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
