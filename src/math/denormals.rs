//! Denormal numbers, and processors that take them for zero, as games and audio programs ask theirs to.

use core::hint::black_box;

/// Whether the processor flushes denormal results to zero in this thread, or takes denormal operands for zero.
#[inline]
pub(crate) fn are_flushed() -> bool {
    // Out of sight of the compiler, which would know half of the least normal number, and that it is not zero.
    black_box(f64::MIN_POSITIVE) * 0.5 <= 0.0
}

/// The [`least_exponent`] of numbers among which there is a denormal one, and of those that are all zero.
const DENORMAL: i32 = -2000;
const ALL_ZERO: i32 = 2000;

/// log2 of the least magnitude other than zero, rounded down. By bits, so that flushing does not matter.
pub(crate) fn least_exponent<'x>(numbers: impl IntoIterator<Item = &'x f64>) -> i32 {
    // Zero becomes the largest.
    let least = numbers.into_iter().map(|x| (x.to_bits() << 1).wrapping_sub(1)).min().unwrap_or(u64::MAX);
    if least == u64::MAX { ALL_ZERO } else { exponent(((least + 1) >> 53) as i32, 1023) }
}

/// Whether all numbers are zero or have a [`least_exponent`] of no less than `exponent`, from -1022 to 1023. In a few
/// instructions each, without a branch.
#[inline]
pub(crate) fn none_below<const N: usize>(numbers: &[f64; N], exponent: i32) -> bool {
    let least = ((exponent + 1023) as u64) << 53;
    // Zero becomes the largest.
    numbers.iter().fold(true, |fine, x| fine & ((x.to_bits() << 1).wrapping_sub(1) >= least.wrapping_sub(1)))
}

/// [`least_exponent`] of numbers that are denormal as `f32`, not only as `f64`.
pub(crate) fn least_exponent_f32<'x>(numbers: impl IntoIterator<Item = &'x f32>) -> i32 {
    let least = numbers.into_iter().map(|x| (x.to_bits() << 1).wrapping_sub(1)).min().unwrap_or(u32::MAX);
    if least == u32::MAX { ALL_ZERO } else { exponent(((least + 1) >> 24) as i32, 127) }
}

fn exponent(field: i32, bias: i32) -> i32 {
    if field == 0 { DENORMAL } else { field - bias }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_exponents() {
        assert!(!are_flushed());
        for (numbers, expected) in [
            (&[][..], ALL_ZERO),
            (&[0.0, -0.0], ALL_ZERO),
            (&[1.0, -8.0, 0.0], 0),
            (&[3.0, -0.75], -1),
            (&[f64::NAN, 1e-300], -997),
            (&[1.0, -f64::MIN_POSITIVE], -1022),
            (&[1.0, f64::from_bits(1)], DENORMAL),
            (&[f64::MIN_POSITIVE.next_down()], DENORMAL),
        ] {
            assert_eq!(least_exponent(numbers), expected, "{numbers:?}");
            for exponent in [-1022, -998, -997, -996, -1, 0, 1] {
                let fine = numbers.iter().all(|&x| none_below(&[x], exponent));
                assert_eq!(fine, expected >= exponent, "{numbers:?} {exponent}");
            }
        }
        for (numbers, expected) in [
            (&[][..], ALL_ZERO),
            (&[0.0, -0.0], ALL_ZERO),
            (&[-5.0, 9.0], 2),
            (&[f32::MIN_POSITIVE, f32::MAX], -126),
            (&[1.0, -f32::MIN_POSITIVE.next_down()], DENORMAL),
        ] {
            assert_eq!(least_exponent_f32(numbers), expected, "{numbers:?}");
        }
    }
}
