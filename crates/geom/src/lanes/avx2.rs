//! Eight lanes of AVX2.

use super::{Kernel, Lanes};
use core::arch::x86_64::{__m128, __m256, __m256d, __m256i};
use pulp::{NullaryFnOnce, cast};
use wide::f32x4;

/// AVX2; a value of this type exists only on machines that have it.
pub use pulp::x86::V3 as Avx2;

const LESS_ORDERED_QUIET: i32 = 17;

struct Vectorized<K>(Avx2, K);

impl<K: Kernel> NullaryFnOnce for Vectorized<K> {
    type Output = K::Output;
    #[inline(always)]
    fn call(self) -> K::Output {
        self.1.run(self.0)
    }
}

/// Operations on two vectors.
macro_rules! lanewise {
    ($($name:ident $intrinsic:ident),*; $($name_q:ident $intrinsic_q:ident),*) => {
        $(#[inline(always)]
        fn $name(self, a: __m256, b: __m256) -> __m256 {
            self.avx.$intrinsic(a, b)
        })*
        $(#[inline(always)]
        fn $name_q(self, a: __m256d, b: __m256d) -> __m256d {
            self.avx.$intrinsic_q(a, b)
        })*
    };
}

impl Lanes for Avx2 {
    const IS_WHOLE: bool = true;
    const ALL: u32 = 0xff;
    type F = __m256;
    type Low = Self;
    type High = Self;
    type Q = __m256d;

    lanewise!(add _mm256_add_ps, sub _mm256_sub_ps, mul _mm256_mul_ps, div _mm256_div_ps, max _mm256_max_ps, min _mm256_min_ps,
        and _mm256_and_ps, or _mm256_or_ps;
        add_q _mm256_add_pd, sub_q _mm256_sub_pd, mul_q _mm256_mul_pd, div_q _mm256_div_pd, and_q _mm256_and_pd, or_q _mm256_or_pd,
        max_q _mm256_max_pd, min_q _mm256_min_pd);

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> K::Output {
        self.vectorize(Vectorized(self, kernel))
    }
    #[inline(always)]
    fn parts(self) -> (Self, Self) {
        (self, self)
    }
    #[inline(always)]
    fn settled<T>(x: &T) -> &T {
        x
    }
    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        self.avx._mm256_set1_ps(x)
    }
    #[inline(always)]
    fn load(self, x: &[f32; 8]) -> __m256 {
        cast(*x)
    }
    #[inline(always)]
    fn read(self, x: &[f32x4; 2]) -> __m256 {
        cast(*x)
    }
    #[inline(always)]
    fn put(self, x: __m256, to: &mut [f32; 8]) {
        *to = cast(x);
    }
    #[inline(always)]
    fn sqrt(self, a: __m256) -> __m256 {
        self.avx._mm256_sqrt_ps(a)
    }
    #[inline(always)]
    fn abs(self, a: __m256) -> __m256 {
        self.avx._mm256_andnot_ps(self.avx._mm256_set1_ps(-0.0), a)
    }
    #[inline(always)]
    fn less(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_cmp_ps::<LESS_ORDERED_QUIET>(a, b)
    }
    #[inline(always)]
    fn select(self, mask: __m256, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_blendv_ps(b, a, mask)
    }
    #[inline(always)]
    fn mask(self, a: __m256) -> u32 {
        self.avx._mm256_movemask_ps(a) as u32
    }
    #[inline(always)]
    fn join(self, low: f32x4, high: f32x4) -> __m256 {
        let (low, high): (__m128, __m128) = (cast(low), cast(high));
        self.avx
            ._mm256_insertf128_ps::<1>(self.avx._mm256_castps128_ps256(low), high)
    }
    #[inline(always)]
    fn halves(self, x: __m256) -> [f32x4; 2] {
        cast(x)
    }
    #[inline(always)]
    fn spread(self, x: __m256, k: usize) -> __m256 {
        match k {
            0 => self.avx._mm256_permute_ps::<0b00_00_00_00>(x),
            1 => self.avx._mm256_permute_ps::<0b01_01_01_01>(x),
            2 => self.avx._mm256_permute_ps::<0b10_10_10_10>(x),
            _ => self.avx._mm256_permute_ps::<0b11_11_11_11>(x),
        }
    }
    #[inline(always)]
    fn transpose(self, [x, y, z, w]: [__m256; 4]) -> [__m256; 4] {
        let avx = self.avx;
        let (a, b) = (avx._mm256_unpacklo_ps(x, y), avx._mm256_unpackhi_ps(x, y));
        let (c, d) = (avx._mm256_unpacklo_ps(z, w), avx._mm256_unpackhi_ps(z, w));
        [
            avx._mm256_shuffle_ps::<0b01_00_01_00>(a, c),
            avx._mm256_shuffle_ps::<0b11_10_11_10>(a, c),
            avx._mm256_shuffle_ps::<0b01_00_01_00>(b, d),
            avx._mm256_shuffle_ps::<0b11_10_11_10>(b, d),
        ]
    }
    #[inline(always)]
    fn pack(self, [x, y, z, w]: [__m256; 4]) -> [__m256; 3] {
        let avx = self.avx;
        [
            avx._mm256_blend_ps::<0b1000_1000>(x, avx._mm256_permute_ps::<0b00_00_00_00>(y)),
            avx._mm256_shuffle_ps::<0b01_00_10_01>(y, z),
            avx._mm256_blend_ps::<0b0001_0001>(
                avx._mm256_permute_ps::<0b10_01_00_00>(w),
                avx._mm256_permute_ps::<0b10_10_10_10>(z),
            ),
        ]
    }
    #[inline(always)]
    fn widen(self, x: f32x4) -> __m256d {
        self.avx._mm256_cvtps_pd(cast(x))
    }
    #[inline(always)]
    fn narrow(self, x: __m256d) -> f32x4 {
        cast(self.avx._mm256_cvtpd_ps(x))
    }
    #[inline(always)]
    fn load_q(self, x: &[f64; 4]) -> __m256d {
        cast(*x)
    }
    #[inline(always)]
    fn store_q(self, x: __m256d) -> [f64; 4] {
        cast(x)
    }
    #[inline(always)]
    fn sqrt_q(self, a: __m256d) -> __m256d {
        self.avx._mm256_sqrt_pd(a)
    }
    #[inline(always)]
    fn less_q(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_cmp_pd::<LESS_ORDERED_QUIET>(a, b)
    }
    #[inline(always)]
    fn abs_q(self, a: __m256d) -> __m256d {
        self.avx._mm256_andnot_pd(self.avx._mm256_set1_pd(-0.0), a)
    }
    #[inline(always)]
    fn mask_q(self, a: __m256d) -> u32 {
        self.avx._mm256_movemask_pd(a) as u32
    }
    #[inline(always)]
    fn turn_q(self, a: __m256d) -> __m256d {
        self.avx2._mm256_permute4x64_pd::<0b11_00_10_01>(a)
    }
    #[inline(always)]
    fn spread_q(self, a: __m256d, k: usize) -> __m256d {
        match k {
            0 => self.avx2._mm256_permute4x64_pd::<0b00_00_00_00>(a),
            1 => self.avx2._mm256_permute4x64_pd::<0b01_01_01_01>(a),
            2 => self.avx2._mm256_permute4x64_pd::<0b10_10_10_10>(a),
            _ => self.avx2._mm256_permute4x64_pd::<0b11_11_11_11>(a),
        }
    }
    #[inline(always)]
    fn select_q(self, mask: __m256d, a: __m256d, b: __m256d) -> __m256d {
        // Blends bytes: the compiler would turn a stored blend of `f64` into a masked store, and
        // the next load would have to wait for it.
        let [mask, a, b]: [__m256i; 3] = [cast(mask), cast(a), cast(b)];
        cast(self.avx2._mm256_blendv_epi8(b, a, mask))
    }
}
