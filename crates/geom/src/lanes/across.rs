//! Reductions from eight lanes to one number.

use super::{F8, Lanes, V8};
use wide::f32x4;

/// For each of four vectors, the sum of its lanes. Adds lanes i and i + 4 first, then i and i + 2.
#[inline(always)]
pub fn sums<L: Lanes>([a, b, c, d]: [F8<L>; 4]) -> [f32; 4] {
    let ([a, b], [c, d]) = ([a.halves(), b.halves()], [c.halves(), d.halves()]);
    let [a, b, c, d] = f32x4::transpose([a[0] + a[1], b[0] + b[1], c[0] + c[1], d[0] + d[1]]);
    ((a + c) + (b + d)).to_array()
}

macro_rules! extreme {
    ($name:ident, $operation:ident, $what:literal) => {
        #[doc = $what]
        #[inline(always)]
        pub fn $name<L: Lanes>([x, y, z]: V8<L>) -> [f32; 3] {
            let ([x, u], [y, v], [z, w]) = (x.halves(), y.halves(), z.halves());
            let (x, y, z) = (x.$operation(u), y.$operation(v), z.$operation(w));
            let [a, b, c, d] = f32x4::transpose([x, y, z, z]);
            let [x, y, z, _] = a.$operation(b).$operation(c.$operation(d)).to_array();
            [x, y, z]
        }
    };
}
extreme!(
    least,
    fast_min,
    "The least number of each column; none of them is NaN."
);
extreme!(
    greatest,
    fast_max,
    "The greatest number of each column; none of them is NaN."
);
