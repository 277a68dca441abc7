//! Denormal numbers, and the detection of processors that flush them to zero. Games and audio
//! programs often enable this mode.

use core::hint::black_box;

/// True if the processor, in this thread, flushes denormal results to zero or reads denormal
/// operands as zero.
#[inline]
pub fn are_flushed() -> bool {
    // `black_box` hides the operand from the compiler, which would otherwise evaluate the product
    // itself, without flushing.
    black_box(f64::MIN_POSITIVE) * 0.5 <= 0.0
}

/// Result of [`exponent`](Number::exponent) if one of the numbers is denormal, and if all are zero.
const DENORMAL: i32 = -2000;
const ALL_ZERO: i32 = 2000;

/// A floating-point type seen through its bits, which flushing does not change.
pub trait Number: Copy + PartialOrd + Into<f64> {
    /// Its bits as an integer.
    type Bits: Copy + Ord;
    /// Positive infinity.
    const INFINITY: Self;
    /// Negative infinity.
    const NEG_INFINITY: Self;
    /// All bits 0.
    const NO_BITS: Self::Bits;
    /// All bits 1.
    const ALL_BITS: Self::Bits;

    /// Twice the bits of the magnitude. They are ordered as the magnitudes are; NaN comes last.
    fn magnitude(self) -> Self::Bits;
    /// The inverse of [`magnitude`](Self::magnitude), for numbers that are not negative.
    fn of_magnitude(bits: Self::Bits) -> Self;
    /// [`magnitude`](Self::magnitude) minus 1, wrapping, so that zero comes last.
    fn rank(self) -> Self::Bits;
    /// log2 of the least magnitude among some numbers, zeros excluded, rounded down. `least_rank`
    /// is the least [`rank`](Self::rank) of the numbers.
    fn exponent(least_rank: Self::Bits) -> i32;
}

macro_rules! number {
    ($float:ident, $bits:ident, $bias:literal) => {
        impl Number for $float {
            type Bits = $bits;
            const INFINITY: Self = Self::INFINITY;
            const NEG_INFINITY: Self = Self::NEG_INFINITY;
            const NO_BITS: $bits = 0;
            const ALL_BITS: $bits = $bits::MAX;

            #[inline(always)]
            fn magnitude(self) -> $bits {
                self.to_bits() << 1
            }
            fn of_magnitude(bits: $bits) -> Self {
                Self::from_bits(bits >> 1)
            }
            #[inline(always)]
            fn rank(self) -> $bits {
                self.magnitude().wrapping_sub(1)
            }
            fn exponent(least_rank: $bits) -> i32 {
                if least_rank == $bits::MAX {
                    return ALL_ZERO;
                }
                let field = ((least_rank + 1) >> $float::MANTISSA_DIGITS) as i32;
                if field == 0 { DENORMAL } else { field - $bias }
            }
        }
    };
}
number!(f32, u32, 127);
number!(f64, u64, 1023);

/// True if every number is zero or has a magnitude of at least `2^exponent`. `exponent` is -1022 to
/// 1023. Takes a few instructions per number, without a branch.
#[inline]
pub fn none_below<const N: usize>(numbers: &[f64; N], exponent: i32) -> bool {
    let least = ((exponent + 1023) as u64) << 53;
    numbers
        .iter()
        .fold(true, |fine, x| fine & (x.rank() >= least.wrapping_sub(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn least_exponent<N: Number>(numbers: &[N]) -> i32 {
        N::exponent(
            numbers
                .iter()
                .map(|x| x.rank())
                .min()
                .unwrap_or(N::ALL_BITS),
        )
    }

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
            assert_eq!(least_exponent(numbers), expected, "{numbers:?}");
        }
    }
}
