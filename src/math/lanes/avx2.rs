//! Eight lanes of AVX2.

use super::{Kernel, Lanes};
use core::arch::x86_64::{__m128, __m256, __m256d};
use pulp::{NullaryFnOnce, cast};

/// AVX2; a value exists only where the machine has it.
pub(crate) use pulp::x86::V3 as Avx2;

const LESS_ORDERED_QUIET: i32 = 17;

struct Vectorized<K>(Avx2, K);

impl<K: Kernel> NullaryFnOnce for Vectorized<K> {
    type Output = K::Output;
    #[inline(always)]
    fn call(self) -> K::Output {
        self.1.run(self.0)
    }
}

#[inline(always)]
fn halves(avx2: Avx2, low: &[f32; 4], high: &[f32; 4]) -> __m256 {
    let (low, high): (__m128, __m128) = (cast(*low), cast(*high));
    avx2.avx._mm256_insertf128_ps::<1>(avx2.avx._mm256_castps128_ps256(low), high)
}

/// Operations on two vectors.
macro_rules! lanewise {
    ($($name:ident $intrinsic:ident),*; $($name_d:ident $intrinsic_d:ident),*) => {
        $(#[inline(always)]
        fn $name(self, a: __m256, b: __m256) -> __m256 {
            self.avx.$intrinsic(a, b)
        })*
        $(#[inline(always)]
        fn $name_d(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
            [self.avx.$intrinsic_d(a[0], b[0]), self.avx.$intrinsic_d(a[1], b[1])]
        })*
    };
}

impl Lanes for Avx2 {
    const IS_WHOLE: bool = true;
    type F = __m256;
    type D = [__m256d; 2];

    lanewise!(add _mm256_add_ps, sub _mm256_sub_ps, mul _mm256_mul_ps, div _mm256_div_ps, max _mm256_max_ps, min _mm256_min_ps,
        and _mm256_and_ps, or _mm256_or_ps; add_d _mm256_add_pd, sub_d _mm256_sub_pd, mul_d _mm256_mul_pd, div_d _mm256_div_pd,
        max_d _mm256_max_pd, min_d _mm256_min_pd, and_d _mm256_and_pd, or_d _mm256_or_pd);

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> K::Output {
        self.vectorize(Vectorized(self, kernel))
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
    fn store(self, x: __m256) -> [f32; 8] {
        cast(x)
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
    fn transpose(self, r: [&[f32; 4]; 8]) -> [__m256; 4] {
        let avx = self.avx;
        let (r0, r1) = (halves(self, r[0], r[4]), halves(self, r[1], r[5]));
        let (r2, r3) = (halves(self, r[2], r[6]), halves(self, r[3], r[7]));
        let (a, b) = (avx._mm256_unpacklo_ps(r0, r1), avx._mm256_unpackhi_ps(r0, r1));
        let (c, d) = (avx._mm256_unpacklo_ps(r2, r3), avx._mm256_unpackhi_ps(r2, r3));
        [
            avx._mm256_shuffle_ps::<0b01_00_01_00>(a, c),
            avx._mm256_shuffle_ps::<0b11_10_11_10>(a, c),
            avx._mm256_shuffle_ps::<0b01_00_01_00>(b, d),
            avx._mm256_shuffle_ps::<0b11_10_11_10>(b, d),
        ]
    }
    #[inline(always)]
    fn rows(self, [x, y, z, w]: [__m256; 4]) -> [[f32; 4]; 8] {
        let avx = self.avx;
        let (a, b) = (avx._mm256_unpacklo_ps(x, y), avx._mm256_unpackhi_ps(x, y));
        let (c, d) = (avx._mm256_unpacklo_ps(z, w), avx._mm256_unpackhi_ps(z, w));
        let [r0, r4]: [[f32; 4]; 2] = cast(avx._mm256_shuffle_ps::<0b01_00_01_00>(a, c));
        let [r1, r5]: [[f32; 4]; 2] = cast(avx._mm256_shuffle_ps::<0b11_10_11_10>(a, c));
        let [r2, r6]: [[f32; 4]; 2] = cast(avx._mm256_shuffle_ps::<0b01_00_01_00>(b, d));
        let [r3, r7]: [[f32; 4]; 2] = cast(avx._mm256_shuffle_ps::<0b11_10_11_10>(b, d));
        [r0, r1, r2, r3, r4, r5, r6, r7]
    }
    #[inline(always)]
    fn splat_d(self, x: f64) -> [__m256d; 2] {
        [self.avx._mm256_set1_pd(x); 2]
    }
    #[inline(always)]
    fn load_d(self, x: &[f64; 8]) -> [__m256d; 2] {
        cast(*x)
    }
    #[inline(always)]
    fn store_d(self, x: [__m256d; 2]) -> [f64; 8] {
        cast(x)
    }
    #[inline(always)]
    fn widen(self, x: __m256) -> [__m256d; 2] {
        let (low, high) = (self.avx._mm256_castps256_ps128(x), self.avx._mm256_extractf128_ps::<1>(x));
        [self.avx._mm256_cvtps_pd(low), self.avx._mm256_cvtps_pd(high)]
    }
    #[inline(always)]
    fn narrow(self, x: [__m256d; 2]) -> __m256 {
        let (low, high) = (self.avx._mm256_cvtpd_ps(x[0]), self.avx._mm256_cvtpd_ps(x[1]));
        self.avx._mm256_insertf128_ps::<1>(self.avx._mm256_castps128_ps256(low), high)
    }
    #[inline(always)]
    fn less_d(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        let avx = self.avx;
        [avx._mm256_cmp_pd::<LESS_ORDERED_QUIET>(a[0], b[0]), avx._mm256_cmp_pd::<LESS_ORDERED_QUIET>(a[1], b[1])]
    }
    #[inline(always)]
    fn abs_d(self, a: [__m256d; 2]) -> [__m256d; 2] {
        let sign = self.avx._mm256_set1_pd(-0.0);
        [self.avx._mm256_andnot_pd(sign, a[0]), self.avx._mm256_andnot_pd(sign, a[1])]
    }
    #[inline(always)]
    fn mask_d(self, a: [__m256d; 2]) -> u32 {
        (self.avx._mm256_movemask_pd(a[0]) | self.avx._mm256_movemask_pd(a[1]) << 4) as u32
    }
}
