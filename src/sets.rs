//! Disjoint sets of numbers: union-find over a list of parents, where a root is its own parent.
//!
//! The root of a set is its least number.

/// Returns the root of the set of `i`, and halves the path to it.
pub fn find(parents: &mut [u32], mut i: u32) -> u32 {
    while parents[i as usize] != i {
        let above = parents[parents[i as usize] as usize];
        parents[i as usize] = above;
        i = above;
    }
    i
}

/// Unites the sets of `i` and `j`.
pub fn unite(parents: &mut [u32], i: u32, j: u32) {
    let (i, j) = (find(parents, i), find(parents, j));
    parents[i.max(j) as usize] = i.min(j);
}
