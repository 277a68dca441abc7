//! Exact sums of products of `f64` values, over their whole range.
//!
//! A value is an odd integer times a power of two. The integer of a product of three values has at
//! most 159 bits. It is added at its place to an accumulator with a digit for every power that can
//! occur. So the cost depends on the number of products, not on the spread of their exponents.

use core::array::from_fn;
use core::ptr;

/// `mantissa * 2^exponent`, the mantissa odd or zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Term {
    mantissa: i64,
    exponent: i32,
}

impl Term {
    pub const ONE: Self = Self {
        mantissa: 1,
        exponent: 0,
    };

    fn new(value: f64) -> Self {
        let bits = value.to_bits();
        let biased = (bits >> 52) as i32 & 0x7ff;
        let magnitude = (bits & ((1 << 52) - 1)) as i64 | i64::from(biased != 0) << 52;
        let zeros = magnitude.trailing_zeros() % 64;
        let odd = magnitude >> zeros;
        Self {
            mantissa: if bits >> 63 == 1 { -odd } else { odd },
            exponent: biased.max(1) - 1075 + zeros as i32,
        }
    }
}

/// The coordinates as integers, in units of the largest power of two for which all are integers.
/// The width is a number of bits: each integer is below `2^width`. Over all of `f64` it is at most
/// 1024 + 1074.
pub(super) fn on_grid<const D: usize, const N: usize>(
    points: [[f64; D]; N],
) -> ([[Term; D]; N], u32) {
    let mut terms: [[Term; D]; N] = from_fn(|i| from_fn(|j| Term::new(points[i][j])));
    let (mut low, mut high) = (i32::MAX, i32::MIN);
    for term in terms
        .as_flattened()
        .iter()
        .filter(|term| term.mantissa != 0)
    {
        low = low.min(term.exponent);
        high = high.max(term.exponent + 64 - term.mantissa.unsigned_abs().leading_zeros() as i32);
    }
    for term in terms.as_flattened_mut() {
        term.exponent = if term.mantissa == 0 {
            0
        } else {
            term.exponent - low
        };
    }
    (terms, high.saturating_sub(low).max(0) as u32)
}

/// A difference of two points: the first minus the second.
pub(super) type Difference<'p> = [&'p [Term]; 2];

/// The permutations of one, of two and of three numbers; true for odd ones.
const PERMUTATIONS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], false),
    ([1, 0, 2], true),
    ([1, 2, 0], false),
    ([0, 2, 1], true),
    ([2, 0, 1], false),
    ([2, 1, 0], true),
];

/// The determinant of up to three differences of points on a grid of this width, along as many
/// axes.
pub(super) fn determinant<const D: usize>(
    rows: [Difference; D],
    axes: [usize; D],
    width: u32,
) -> Sum {
    let mut sum = Sum::new(width);
    for choice in 0..1_usize << D {
        let points: [&[Term]; D] = from_fn(|i| rows[i][choice >> i & 1]);
        // With one point twice it is 0.
        if (1..D).any(|i| points[..i].iter().any(|other| ptr::eq(*other, points[i]))) {
            continue;
        }
        for &(permutation, is_odd) in &PERMUTATIONS[..[1, 2, 6][D - 1]] {
            let factor = |i: usize| points[i][axes[permutation[i]]];
            let factors = from_fn(|i| if i < D { factor(i) } else { Term::ONE });
            sum.accumulate(factors, is_odd ^ (choice.count_ones() % 2 == 1));
        }
    }
    sum
}

/// A sum of at most 48 products of three terms from a grid, added or subtracted.
pub(super) struct Sum {
    /// The sum of the added products, then the sum of the subtracted ones. The least limb comes
    /// first.
    parts: [[u64; LIMBS]; 2],
    /// Number of limbs that may be in use.
    limbs: usize,
}

const LIMBS: usize = limbs(1024 + 1074);

const TWO_TO_64: f64 = 18_446_744_073_709_551_616.0;

/// A product is below 2^(3 width). Even if all 48 products go to one part, their sum is below 2^(3
/// width + 6).
const fn limbs(width: u32) -> usize {
    (3 * width as usize + 6).div_ceil(64)
}

/// The limbs `top` and `top - 1` of a size, which is all of it but for less than 2^-64.
fn leading(size: &[u64; LIMBS], top: usize) -> f64 {
    size[top] as f64 * TWO_TO_64 + top.checked_sub(1).map_or(0, |i| size[i]) as f64
}

impl Sum {
    pub fn new(width: u32) -> Self {
        Self {
            parts: [[0; LIMBS]; 2],
            limbs: limbs(width),
        }
    }

    /// Adds a product, or subtracts it if `negate`.
    fn accumulate(&mut self, factors: [Term; 3], negate: bool) {
        let negative = factors
            .iter()
            .fold(negate, |negative, term| negative ^ (term.mantissa < 0));
        let [p, q, r] = factors.map(|term| u128::from(term.mantissa.unsigned_abs()));
        let pq = p * q;
        let low = u128::from(pq as u64) * r;
        let high = (pq >> 64) * r + (low >> 64);
        let place = factors
            .iter()
            .map(|term| term.exponent as usize)
            .sum::<usize>();
        let mut limbs = self.parts[usize::from(negative)][place / 64..].iter_mut();
        let mut carry = 0;
        for (digits, limb) in [low as u64, high as u64, (high >> 64) as u64]
            .into_iter()
            .zip(&mut limbs)
        {
            carry += (u128::from(digits) << (place % 64)) + u128::from(*limb);
            *limb = carry as u64;
            carry >>= 64;
        }
        for limb in limbs {
            if carry == 0 {
                break;
            }
            carry += u128::from(*limb);
            *limb = carry as u64;
            carry >>= 64;
        }
    }

    pub fn sign(&self) -> i8 {
        let [added, subtracted] = self
            .parts
            .each_ref()
            .map(|part| part[..self.limbs].iter().rev());
        added.cmp(subtracted) as i8
    }

    /// `|self| / (|self| + |other|)` for sums of equal width that are not both 0. The error is a
    /// few roundings of 1.
    pub fn share_of_sizes(&self, other: &Self) -> f64 {
        let sizes = [self.size(), other.size()];
        let top = (0..self.limbs)
            .rev()
            .find(|&i| sizes.iter().any(|size| size[i] != 0))
            .unwrap_or(0);
        let [size, rest] = sizes.map(|size| leading(&size, top));
        size / (size + rest)
    }

    /// `self / other` for a nonzero `other` of equal width. The error is a few roundings; the
    /// result is infinite beyond the range of `f64`.
    pub fn quotient(&self, other: &Self) -> f64 {
        let [(upper, top), (lower, bottom)] = [self, other].map(|sum| {
            let size = sum.size();
            let top = (1..sum.limbs).rev().find(|&i| size[i] != 0).unwrap_or(0);
            (leading(&size, top), top)
        });
        let size = libm::ldexp(upper / lower, 64 * (top as i32 - bottom as i32));
        if self.sign() == other.sign() {
            size
        } else {
            -size
        }
    }

    fn size(&self) -> [u64; LIMBS] {
        let [added, subtracted] = &self.parts;
        let (large, small) = if self.sign() < 0 {
            (subtracted, added)
        } else {
            (added, subtracted)
        };
        let mut size = [0; LIMBS];
        let mut borrow = false;
        for i in 0..self.limbs {
            let (difference, below) = large[i].overflowing_sub(small[i]);
            let (difference, again) = difference.overflowing_sub(borrow.into());
            size[i] = difference;
            borrow = below | again;
        }
        size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TINY: f64 = f64::from_bits(1);

    #[test]
    fn terms_are_the_value() {
        for value in [
            1.5,
            -3.0,
            1e300,
            f64::MAX,
            f64::MIN_POSITIVE,
            TINY,
            -7.0 * TINY,
            0.0,
            -0.0,
        ] {
            let Term { mantissa, exponent } = Term::new(value);
            assert!(mantissa % 2 != 0 || value == 0.0);
            let power = |exponent: i32| f64::from_bits(((1023 + exponent) as u64) << 52);
            let half = exponent / 2; // the whole power may be out of range
            assert_eq!(
                mantissa as f64 * power(half) * power(exponent - half),
                value
            );
        }
    }

    #[test]
    fn the_grid_is_as_coarse_as_can_be() {
        let (terms, width) = on_grid([[12.0, -8.0, 0.0]]);
        assert_eq!(
            terms[0].map(|term| term.mantissa << term.exponent),
            [3, -2, 0]
        );
        assert_eq!(width, 2);
        assert_eq!(
            on_grid([[0.0, -0.0]]),
            (
                [[Term {
                    mantissa: 0,
                    exponent: 0
                }; 2]],
                0
            )
        );
        assert_eq!(on_grid([[f64::MAX, TINY]]).1, 2098);
    }

    #[test]
    fn carries_run_through_all_limbs() {
        let ([[largest, least]], width) = on_grid([[f64::MAX, TINY]]);
        let mut sum = Sum::new(width);
        for _ in 0..12 {
            sum.accumulate([largest; 3], false);
            sum.accumulate(
                [
                    Term {
                        mantissa: -largest.mantissa,
                        ..largest
                    },
                    largest,
                    largest,
                ],
                true,
            );
        }
        assert_eq!(sum.sign(), 1);
        let mut sum = Sum::new(width);
        sum.accumulate([largest, largest, largest], false);
        sum.accumulate([largest, largest, largest], true);
        assert_eq!(sum.sign(), 0);
        sum.accumulate([least; 3], true);
        assert_eq!(sum.sign(), -1);
    }

    #[test]
    fn sums_may_be_larger_than_products() {
        let ([[largest]], 53) = on_grid([[f64::from_bits(((1023 + 53) << 52) - 1)]]) else {
            panic!("53 bits set")
        };
        let factor = Term {
            exponent: 11,
            ..largest
        };
        let mut sum = Sum::new(64); // a product just fits three limbs
        sum.accumulate([factor; 3], false);
        sum.accumulate([factor; 3], false);
        sum.accumulate([factor; 3], true);
        assert_eq!(sum.sign(), 1);
    }

    #[test]
    fn carry_beyond_the_three_limbs_of_a_product() {
        // 2^192 - 2^63 + 2^63: the second addition carries through two full limbs.
        let power = |exponent| Term {
            mantissa: 1,
            exponent,
        };
        let mut sum = Sum::new(100);
        for exponent in 63..192 {
            sum.accumulate([power(exponent), Term::ONE, Term::ONE], false);
        }
        sum.accumulate([power(63), Term::ONE, Term::ONE], false);
        sum.accumulate([power(192), Term::ONE, Term::ONE], true);
        assert_eq!(sum.sign(), 0);
    }
}
