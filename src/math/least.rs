//! The least magnitudes that the library computes with. Smaller numbers become zero at input. So no
//! result is denormal, and answers do not depend on whether the processor flushes denormal numbers
//! to zero (`docs/numerics.md`).

use glam::DVec3;

/// Least nonzero magnitude of an `f64` input, both for lengths and for entries of a rotation:
/// 2^-300.
pub(crate) const LEAST: f64 = f64::from_bits((1023 - 300) << 52);

/// A floating-point number of a precision that meshes use.
pub(crate) trait Number: Copy + PartialOrd + Into<f64> {
    type Bits: Copy + Ord;
    const INFINITY: Self;
    const NEG_INFINITY: Self;
    const NO_BITS: Self::Bits;

    /// Replaces a number below the least magnitude by zero of its sign.
    fn snapped(self) -> Self;
    /// Twice the bits of the magnitude. The order of these bits is the order of the magnitudes, and
    /// NaN is largest.
    fn magnitude(self) -> Self::Bits;
    /// The inverse of [`magnitude`](Self::magnitude), without the sign.
    fn of_magnitude(bits: Self::Bits) -> Self;
}

macro_rules! number {
    ($float:ident, $bits:ident, $least:expr) => {
        impl Number for $float {
            type Bits = $bits;
            const INFINITY: Self = Self::INFINITY;
            const NEG_INFINITY: Self = Self::NEG_INFINITY;
            const NO_BITS: $bits = 0;

            #[inline(always)]
            fn snapped(self) -> Self {
                if self.abs() < $least {
                    Self::copysign(0.0, self)
                } else {
                    self
                }
            }
            #[inline(always)]
            fn magnitude(self) -> $bits {
                self.to_bits() << 1
            }
            fn of_magnitude(bits: $bits) -> Self {
                Self::from_bits(bits >> 1)
            }
        }
    };
}
number!(f32, u32, f32::MIN_POSITIVE);
number!(f64, u64, LEAST);

/// Replaces components smaller than [`LEAST`] by zeros of their sign.
#[inline(always)]
pub(crate) fn snapped(v: DVec3) -> DVec3 {
    DVec3::from_array(v.to_array().map(Number::snapped))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_become_zero_of_their_sign() {
        for small in [0.0, 5e-324, 1e-310, 1e-91, LEAST.next_down()] {
            assert_eq!(small.snapped().to_bits(), 0);
            assert_eq!((-small).snapped().to_bits(), 1 << 63);
        }
        for large in [LEAST, 1.0, f64::MAX, f64::INFINITY] {
            assert_eq!([large.snapped(), (-large).snapped()], [large, -large]);
        }
        assert!(f64::NAN.snapped().is_nan() && f32::NAN.snapped().is_nan());
        assert_eq!(f32::MIN_POSITIVE.snapped(), f32::MIN_POSITIVE);
        assert_eq!(
            (-f32::MIN_POSITIVE.next_down()).snapped().to_bits(),
            1 << 31
        );
    }
}
