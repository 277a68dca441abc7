//! Eight lanes of `f32` (and of `f64`), the only vocabulary of the kernels.
//!
//! A kernel is written once, over [`F8`] and [`D8`], and compiled twice: for AVX2, chosen at run time, and for pairs
//! of 4-lane vectors (SSE2, NEON or plain arrays, whatever the target has). Every operation is one IEEE operation a
//! lane and nothing is ever fused, so both give the same bits. The token `L` proves that the machine has what the
//! kernel was compiled for, which is why no `unsafe` is needed here.

mod across;

pub(crate) use across::{greatest, least, sums};

use core::ops::{Add, Div, Mul, Neg, Sub};

/// An instruction set: the operations behind [`F8`] and [`D8`].
pub(crate) trait Lanes: Copy {
    /// Eight `f32`, or eight all-ones or all-zeros masks.
    type F: Copy;
    /// Eight `f64`.
    type D: Copy;

    /// Runs `kernel` compiled for this instruction set; it must be `#[inline(always)]` all the way down.
    fn run<K: Kernel>(self, kernel: K) -> K::Output;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, x: &[f32; 8]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; 8];
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    fn sqrt(self, a: Self::F) -> Self::F;
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    fn less(self, a: Self::F, b: Self::F) -> Self::F;
    fn and(self, a: Self::F, b: Self::F) -> Self::F;
    fn or(self, a: Self::F, b: Self::F) -> Self::F;
    fn select(self, mask: Self::F, a: Self::F, b: Self::F) -> Self::F;
    fn mask(self, a: Self::F) -> u32;
    /// Eight rows of four to four columns of eight.
    fn transpose(self, rows: [&[f32; 4]; 8]) -> [Self::F; 4];
    /// Four columns of eight to eight rows of four.
    fn rows(self, columns: [Self::F; 4]) -> [[f32; 4]; 8];

    fn splat_d(self, x: f64) -> Self::D;
    fn load_d(self, x: &[f64; 8]) -> Self::D;
    fn widen(self, x: Self::F) -> Self::D;
    fn narrow(self, x: Self::D) -> Self::F;
    fn add_d(self, a: Self::D, b: Self::D) -> Self::D;
    fn sub_d(self, a: Self::D, b: Self::D) -> Self::D;
    fn mul_d(self, a: Self::D, b: Self::D) -> Self::D;
}

/// A piece of code to be compiled for an instruction set.
pub(crate) trait Kernel {
    /// What it returns.
    type Output;
    /// The code, for the set that `lanes` stands for.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Eight `f32` of the instruction set `L`.
#[derive(Clone, Copy)]
pub(crate) struct F8<L: Lanes>(L::F, L);

/// Eight `f64` of the instruction set `L`.
#[derive(Clone, Copy)]
pub(crate) struct D8<L: Lanes>(L::D, L);

#[allow(clippy::inline_always)]
impl<L: Lanes> F8<L> {
    #[inline(always)]
    pub fn splat(lanes: L, x: f32) -> Self {
        Self(lanes.splat(x), lanes)
    }
    #[inline(always)]
    pub fn load(lanes: L, x: &[f32; 8]) -> Self {
        Self(lanes.load(x), lanes)
    }
    #[inline(always)]
    pub fn store(self) -> [f32; 8] {
        self.1.store(self.0)
    }
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(self.1.max(self.0, other.0), self.1)
    }
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(self.1.min(self.0, other.0), self.1)
    }
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.1.abs(self.0), self.1)
    }
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.1.sqrt(self.0), self.1)
    }
    /// All ones where `self < other`; never where one of them is no number.
    #[inline(always)]
    pub fn less(self, other: Self) -> Self {
        Self(self.1.less(self.0, other.0), self.1)
    }
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self(self.1.and(self.0, other.0), self.1)
    }
    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        Self(self.1.or(self.0, other.0), self.1)
    }
    /// `a` where this mask is all ones, `b` where it is all zeros.
    #[inline(always)]
    pub fn select(self, a: Self, b: Self) -> Self {
        Self(self.1.select(self.0, a.0, b.0), self.1)
    }
    /// The sign of each lane, or whether it is all ones: one bit a lane, lane 0 lowest.
    #[inline(always)]
    pub fn mask(self) -> u32 {
        self.1.mask(self.0)
    }
    #[inline(always)]
    pub fn transpose(lanes: L, rows: [&[f32; 4]; 8]) -> [Self; 4] {
        let [x, y, z, w] = lanes.transpose(rows);
        [Self(x, lanes), Self(y, lanes), Self(z, lanes), Self(w, lanes)]
    }
    #[inline(always)]
    pub fn rows([x, y, z, w]: [Self; 4]) -> [[f32; 4]; 8] {
        x.1.rows([x.0, y.0, z.0, w.0])
    }
    #[inline(always)]
    pub fn widen(self) -> D8<L> {
        D8(self.1.widen(self.0), self.1)
    }
}

#[allow(clippy::inline_always)]
impl<L: Lanes> D8<L> {
    #[inline(always)]
    pub fn splat(lanes: L, x: f64) -> Self {
        Self(lanes.splat_d(x), lanes)
    }
    #[inline(always)]
    pub fn load(lanes: L, x: &[f64; 8]) -> Self {
        Self(lanes.load_d(x), lanes)
    }
    #[inline(always)]
    pub fn narrow(self) -> F8<L> {
        F8(self.1.narrow(self.0), self.1)
    }
}

macro_rules! operators {
    ($type:ident: $($trait:ident $verb:ident $call:ident),*) => { $(
        impl<L: Lanes> $trait for $type<L> {
            type Output = Self;
            #[inline(always)]
            fn $verb(self, other: Self) -> Self {
                Self(self.1.$call(self.0, other.0), self.1)
            }
        }
    )* };
}
operators!(F8: Add add add, Sub sub sub, Mul mul mul, Div div div);
operators!(D8: Add add add_d, Sub sub sub_d, Mul mul mul_d);

impl<L: Lanes> Neg for F8<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::splat(self.1, 0.0) - self
    }
}

/// `[e(0), e(1), e(2)]`. A closure would not be compiled for the instruction set of the kernel around it.
macro_rules! per_axis {
    ($k:ident => $e:expr) => {
        [
            {
                let $k = 0;
                $e
            },
            {
                let $k = 1;
                $e
            },
            {
                let $k = 2;
                $e
            },
        ]
    };
}
pub(crate) use per_axis;

/// Three columns: eight vectors.
pub(crate) type V8<L> = [F8<L>; 3];

#[inline(always)]
pub(crate) fn dot<L: Lanes>(a: V8<L>, b: V8<L>) -> F8<L> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross<L: Lanes>(a: V8<L>, b: V8<L>) -> V8<L> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The instruction sets there are; which one a machine has is asked once.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Instructions {
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    Portable(Portable),
}

impl Instructions {
    pub const PORTABLE: Self = Self::Portable(Portable);

    /// The best that this machine has.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = Avx2::try_new() {
            return Self::Avx2(avx2);
        }
        Self::PORTABLE
    }

    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(avx2) => avx2.run(kernel),
            Self::Portable(portable) => portable.run(kernel),
        }
    }
}

/// Pairs of 4-lane vectors: SSE2, NEON or plain arrays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

mod portable {
    use super::{Kernel, Lanes, Portable};
    use wide::{f32x4, f64x2};

    type F = [f32x4; 2];
    type D = [f64x2; 4];

    #[inline(always)]
    fn zip<T: Copy, const N: usize>(a: [T; N], b: [T; N], f: impl Fn(T, T) -> T) -> [T; N] {
        core::array::from_fn(|i| f(a[i], b[i]))
    }

    #[inline(always)]
    fn transpose4(rows: [&[f32; 4]; 4]) -> [f32x4; 4] {
        core::array::from_fn(|i| f32x4::new([rows[0][i], rows[1][i], rows[2][i], rows[3][i]]))
    }

    impl Lanes for Portable {
        type F = F;
        type D = D;

        #[inline(always)]
        fn run<K: Kernel>(self, kernel: K) -> K::Output {
            kernel.run(self)
        }
        #[inline(always)]
        fn splat(self, x: f32) -> F {
            [f32x4::splat(x); 2]
        }
        #[inline(always)]
        fn load(self, x: &[f32; 8]) -> F {
            [f32x4::new([x[0], x[1], x[2], x[3]]), f32x4::new([x[4], x[5], x[6], x[7]])]
        }
        #[inline(always)]
        fn store(self, x: F) -> [f32; 8] {
            let [[a, b, c, d], [e, f, g, h]] = x.map(f32x4::to_array);
            [a, b, c, d, e, f, g, h]
        }
        #[inline(always)]
        fn add(self, a: F, b: F) -> F {
            zip(a, b, |a, b| a + b)
        }
        #[inline(always)]
        fn sub(self, a: F, b: F) -> F {
            zip(a, b, |a, b| a - b)
        }
        #[inline(always)]
        fn mul(self, a: F, b: F) -> F {
            zip(a, b, |a, b| a * b)
        }
        #[inline(always)]
        fn div(self, a: F, b: F) -> F {
            zip(a, b, |a, b| a / b)
        }
        #[inline(always)]
        fn sqrt(self, a: F) -> F {
            a.map(f32x4::sqrt)
        }
        #[inline(always)]
        fn max(self, a: F, b: F) -> F {
            zip(a, b, f32x4::fast_max)
        }
        #[inline(always)]
        fn min(self, a: F, b: F) -> F {
            zip(a, b, f32x4::fast_min)
        }
        #[inline(always)]
        fn abs(self, a: F) -> F {
            a.map(f32x4::abs)
        }
        #[inline(always)]
        fn less(self, a: F, b: F) -> F {
            zip(a, b, |a, b| a.simd_lt(b))
        }
        #[inline(always)]
        fn and(self, a: F, b: F) -> F {
            zip(a, b, |a, b| a & b)
        }
        #[inline(always)]
        fn or(self, a: F, b: F) -> F {
            zip(a, b, |a, b| a | b)
        }
        #[inline(always)]
        fn select(self, mask: F, a: F, b: F) -> F {
            [mask[0].select(a[0], b[0]), mask[1].select(a[1], b[1])]
        }
        #[inline(always)]
        fn mask(self, a: F) -> u32 {
            a[0].to_bitmask() | a[1].to_bitmask() << 4
        }
        #[inline(always)]
        fn transpose(self, r: [&[f32; 4]; 8]) -> [F; 4] {
            let low = transpose4([r[0], r[1], r[2], r[3]]);
            let high = transpose4([r[4], r[5], r[6], r[7]]);
            core::array::from_fn(|i| [low[i], high[i]])
        }
        #[inline(always)]
        fn rows(self, columns: [F; 4]) -> [[f32; 4]; 8] {
            let half = |i: usize| f32x4::transpose(columns.map(|column| column[i])).map(f32x4::to_array);
            let ([a, b, c, d], [e, f, g, h]) = (half(0), half(1));
            [a, b, c, d, e, f, g, h]
        }
        #[inline(always)]
        fn splat_d(self, x: f64) -> D {
            [f64x2::splat(x); 4]
        }
        #[inline(always)]
        fn load_d(self, x: &[f64; 8]) -> D {
            core::array::from_fn(|i| f64x2::new([x[2 * i], x[2 * i + 1]]))
        }
        #[inline(always)]
        fn widen(self, x: F) -> D {
            let x = self.store(x).map(f64::from);
            core::array::from_fn(|i| f64x2::new([x[2 * i], x[2 * i + 1]]))
        }
        #[inline(always)]
        fn narrow(self, x: D) -> F {
            let [[a, b], [c, d], [e, f], [g, h]] = x.map(f64x2::to_array);
            self.load(&[a, b, c, d, e, f, g, h].map(|x| x as f32))
        }
        #[inline(always)]
        fn add_d(self, a: D, b: D) -> D {
            zip(a, b, |a, b| a + b)
        }
        #[inline(always)]
        fn sub_d(self, a: D, b: D) -> D {
            zip(a, b, |a, b| a - b)
        }
        #[inline(always)]
        fn mul_d(self, a: D, b: D) -> D {
            zip(a, b, |a, b| a * b)
        }
    }
}

/// AVX2; a value exists only where the machine has it.
#[cfg(target_arch = "x86_64")]
pub(crate) use pulp::x86::V3 as Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Avx2, Kernel, Lanes};
    use core::arch::x86_64::{__m128, __m256, __m256d};
    use pulp::{NullaryFnOnce, cast};

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

    impl Lanes for Avx2 {
        type F = __m256;
        type D = [__m256d; 2];

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
        fn add(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_add_ps(a, b)
        }
        #[inline(always)]
        fn sub(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_sub_ps(a, b)
        }
        #[inline(always)]
        fn mul(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_mul_ps(a, b)
        }
        #[inline(always)]
        fn div(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_div_ps(a, b)
        }
        #[inline(always)]
        fn sqrt(self, a: __m256) -> __m256 {
            self.avx._mm256_sqrt_ps(a)
        }
        #[inline(always)]
        fn max(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_max_ps(a, b)
        }
        #[inline(always)]
        fn min(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_min_ps(a, b)
        }
        #[inline(always)]
        fn abs(self, a: __m256) -> __m256 {
            self.avx._mm256_andnot_ps(self.avx._mm256_set1_ps(-0.0), a)
        }
        #[inline(always)]
        fn less(self, a: __m256, b: __m256) -> __m256 {
            const LESS_ORDERED_QUIET: i32 = 17;
            self.avx._mm256_cmp_ps::<LESS_ORDERED_QUIET>(a, b)
        }
        #[inline(always)]
        fn and(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_and_ps(a, b)
        }
        #[inline(always)]
        fn or(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_or_ps(a, b)
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
        fn add_d(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
            [self.avx._mm256_add_pd(a[0], b[0]), self.avx._mm256_add_pd(a[1], b[1])]
        }
        #[inline(always)]
        fn sub_d(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
            [self.avx._mm256_sub_pd(a[0], b[0]), self.avx._mm256_sub_pd(a[1], b[1])]
        }
        #[inline(always)]
        fn mul_d(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
            [self.avx._mm256_mul_pd(a[0], b[0]), self.avx._mm256_mul_pd(a[1], b[1])]
        }
    }
}
