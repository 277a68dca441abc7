//! Lanes made of 4-lane vectors: eight lanes as two of them, or four as one.

use super::{Kernel, Lanes};
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};
use wide::{f32x4, f64x2};

/// `N` vectors of four lanes (SSE2, NEON or plain arrays). Their first lane is lane `AT` of eight.
#[derive(Clone, Copy, Debug)]
pub struct Quads<const N: usize, const AT: usize> {}

/// All eight lanes.
pub type Portable = Quads<2, 0>;

type F<const N: usize> = [f32x4; N];
type Q = [f64x2; 2];

#[inline(always)]
fn zip<T: Copy, const N: usize>(a: [T; N], b: [T; N], f: impl Fn(T, T) -> T) -> [T; N] {
    core::array::from_fn(|i| f(a[i], b[i]))
}

/// The square root of each lane. Uses `libm` on targets without a hardware instruction and without
/// `std`, because `wide` is wrong for denormal numbers there.
#[inline(always)]
fn root(x: f64x2) -> f64x2 {
    let is_right = cfg!(any(
        feature = "std",
        target_feature = "sse2",
        target_feature = "simd128",
        all(target_feature = "neon", target_arch = "aarch64")
    ));
    if is_right {
        x.sqrt()
    } else {
        f64x2::new(x.to_array().map(libm::sqrt))
    }
}

/// Operations on two vectors.
macro_rules! lanewise {
    ($($name:ident $operation:expr),*; $($name_q:ident $operation_q:expr),*) => {
        $(#[inline(always)]
        fn $name(self, a: F<N>, b: F<N>) -> F<N> {
            zip(a, b, $operation)
        })*
        $(#[inline(always)]
        fn $name_q(self, a: Q, b: Q) -> Q {
            zip(a, b, $operation_q)
        })*
    };
}

impl<const N: usize, const AT: usize> Lanes for Quads<N, AT> {
    const IS_WHOLE: bool = N == 1;
    const ALL: u32 = ((1 << (4 * N)) - 1) << AT;
    type F = F<N>;
    type Q = Q;
    type Low = Quads<1, 0>;
    type High = Quads<1, 4>;

    lanewise!(add Add::add, sub Sub::sub, mul Mul::mul, div Div::div, max f32x4::fast_max, min f32x4::fast_min,
        and BitAnd::bitand, or BitOr::bitor, less |a, b| a.simd_lt(b);
        add_q Add::add, sub_q Sub::sub, mul_q Mul::mul, div_q Div::div, max_q f64x2::fast_max,
        min_q f64x2::fast_min, and_q BitAnd::bitand, or_q BitOr::bitor, less_q |a, b| a.simd_lt(b));

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> K::Output {
        // Not inlined, so that the kernel is compiled once and not at each call. The kernels of the
        // other sets are not inlined either.
        #[inline(never)]
        fn once<L: Lanes, K: Kernel>(lanes: L, kernel: K) -> K::Output {
            kernel.run(lanes)
        }
        once(self, kernel)
    }
    #[inline(always)]
    fn parts(self) -> (Self::Low, Self::High) {
        (Quads {}, Quads {})
    }
    #[inline(always)]
    fn settled<T>(x: &T) -> &T {
        core::hint::black_box(x)
    }
    #[inline(always)]
    fn splat(self, x: f32) -> F<N> {
        [f32x4::splat(x); N]
    }
    #[inline(always)]
    fn load(self, x: &[f32; 8]) -> F<N> {
        core::array::from_fn(|i| f32x4::new(core::array::from_fn(|k| x[AT + 4 * i + k])))
    }
    #[inline(always)]
    fn read(self, x: &[f32x4; 2]) -> F<N> {
        core::array::from_fn(|i| x[AT / 4 + i])
    }
    #[inline(always)]
    fn put(self, x: F<N>, to: &mut [f32; 8]) {
        for (i, x) in x.into_iter().enumerate() {
            to[AT + 4 * i..][..4].copy_from_slice(x.as_array());
        }
    }
    #[inline(always)]
    fn sqrt(self, a: F<N>) -> F<N> {
        a.map(f32x4::sqrt)
    }
    #[inline(always)]
    fn abs(self, a: F<N>) -> F<N> {
        a.map(f32x4::abs)
    }
    #[inline(always)]
    fn select(self, mask: F<N>, a: F<N>, b: F<N>) -> F<N> {
        core::array::from_fn(|i| mask[i].select(a[i], b[i]))
    }
    #[inline(always)]
    fn mask(self, a: F<N>) -> u32 {
        (0..N).fold(0, |bits, i| bits | a[i].to_bitmask() << (AT + 4 * i))
    }
    #[inline(always)]
    fn join(self, low: f32x4, high: f32x4) -> F<N> {
        core::array::from_fn(|i| [low, high][AT / 4 + i])
    }
    #[inline(always)]
    fn halves(self, x: F<N>) -> [f32x4; 2] {
        [x[0], x[N - 1]]
    }
    #[inline(always)]
    fn spread(self, x: F<N>, k: usize) -> F<N> {
        x.map(|half| f32x4::splat(half.as_array()[k % 4]))
    }
    #[inline(always)]
    fn transpose(self, rows: [F<N>; 4]) -> [F<N>; 4] {
        let halves: [_; N] =
            core::array::from_fn(|half| f32x4::transpose(rows.map(|row| row[half])));
        core::array::from_fn(|i| halves.map(|columns| columns[i]))
    }
    #[inline(always)]
    fn pack(self, rows: [F<N>; 4]) -> [F<N>; 3] {
        let halves: [_; N] = core::array::from_fn(|half| {
            let [[a, b, c, _], [d, e, f, _], [g, h, i, _], [j, k, l, _]] =
                rows.map(|row| row[half].to_array());
            [
                f32x4::new([a, b, c, d]),
                f32x4::new([e, f, g, h]),
                f32x4::new([i, j, k, l]),
            ]
        });
        core::array::from_fn(|i| halves.map(|packed| packed[i]))
    }
    #[inline(always)]
    fn widen(self, x: f32x4) -> Q {
        self.load_q(&x.to_array().map(f64::from))
    }
    #[inline(always)]
    fn narrow(self, x: Q) -> f32x4 {
        f32x4::new(self.store_q(x).map(|x| x as f32))
    }
    #[inline(always)]
    fn load_q(self, x: &[f64; 4]) -> Q {
        [f64x2::new([x[0], x[1]]), f64x2::new([x[2], x[3]])]
    }
    #[inline(always)]
    fn store_q(self, x: Q) -> [f64; 4] {
        let [[a, b], [c, d]] = x.map(f64x2::to_array);
        [a, b, c, d]
    }
    #[inline(always)]
    fn sqrt_q(self, a: Q) -> Q {
        a.map(root)
    }
    #[inline(always)]
    fn abs_q(self, a: Q) -> Q {
        a.map(f64x2::abs)
    }
    #[inline(always)]
    fn mask_q(self, a: Q) -> u32 {
        a[0].to_bitmask() | a[1].to_bitmask() << 2
    }
    #[inline(always)]
    fn turn_q(self, a: Q) -> Q {
        let [x, y, z, w] = self.store_q(a);
        self.load_q(&[y, z, x, w])
    }
    #[inline(always)]
    fn spread_q(self, a: Q, k: usize) -> Q {
        [f64x2::splat(self.store_q(a)[k % 4]); 2]
    }
    #[inline(always)]
    fn select_q(self, mask: Q, a: Q, b: Q) -> Q {
        [mask[0].select(a[0], b[0]), mask[1].select(a[1], b[1])]
    }
}
