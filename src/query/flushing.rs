//! When a processor that takes denormal numbers for zero could make an answer false.

use crate::math::{Pose, denormals};
use crate::tree::Tree;

/// Exponents below which flushing could be noticed: of coordinates, translations and their products, and of the length of a
/// unit. The proof is in `docs/numerics.md`.
const LEAST: i32 = -960;
const LEAST_UNIT: i32 = -900;

/// Whether numbers of this query are so small that flushing matters, and denormal numbers are flushed here. Asked in this
/// order, since to find out the latter takes longer: a denormal result costs a hundred times an ordinary one.
pub(super) fn matters(a: &Tree, b: &Tree, b_in_a: &Pose) -> bool {
    !is_far_from_denormal(a, b, b_in_a) && denormals::are_flushed()
}

#[inline]
fn is_far_from_denormal(a: &Tree, b: &Tree, b_in_a: &Pose) -> bool {
    let [of_a, of_b] = [a, b].map(|tree| tree.mesh().least_exponent());
    let (rotation, translation) = (b_in_a.rotation().to_cols_array(), b_in_a.translation().to_array());
    let units = [a, b].map(|tree| tree.unit().exponent);
    of_a.min(of_b) >= LEAST
        && units[0].min(units[1]) >= LEAST_UNIT
        && denormals::none_below(&translation, LEAST)
        && denormals::none_below(&rotation, LEAST - of_b.min(0))
}
