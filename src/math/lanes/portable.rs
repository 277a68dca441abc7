//! Eight lanes as pairs of 4-lane vectors.

use super::{Kernel, Lanes};
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};
use wide::{f32x4, f64x2};

/// SSE2, NEON or plain arrays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

type F = [f32x4; 2];
type D = [f64x2; 4];

#[inline(always)]
fn zip<T: Copy, const N: usize>(a: [T; N], b: [T; N], f: impl Fn(T, T) -> T) -> [T; N] {
    core::array::from_fn(|i| f(a[i], b[i]))
}

/// Operations on two vectors.
macro_rules! lanewise {
    ($($name:ident $type:ident $operation:expr),*) => { $(
        #[inline(always)]
        fn $name(self, a: $type, b: $type) -> $type {
            zip(a, b, $operation)
        }
    )* };
}

impl Lanes for Portable {
    const IS_WHOLE: bool = false;
    type F = F;
    type D = D;

    lanewise!(add F Add::add, sub F Sub::sub, mul F Mul::mul, div F Div::div, max F f32x4::fast_max, min F f32x4::fast_min,
        and F BitAnd::bitand, or F BitOr::bitor, less F |a, b| a.simd_lt(b), add_d D Add::add, sub_d D Sub::sub, mul_d D Mul::mul,
        div_d D Div::div, max_d D f64x2::fast_max, min_d D f64x2::fast_min, and_d D BitAnd::bitand, or_d D BitOr::bitor,
        less_d D |a, b| a.simd_lt(b));

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> K::Output {
        // Compiled once, as for other sets, wherever it is called from.
        #[inline(never)]
        fn once<K: Kernel>(lanes: Portable, kernel: K) -> K::Output {
            kernel.run(lanes)
        }
        once(self, kernel)
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
    fn sqrt(self, a: F) -> F {
        a.map(f32x4::sqrt)
    }
    #[inline(always)]
    fn abs(self, a: F) -> F {
        a.map(f32x4::abs)
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
    fn join(self, low: f32x4, high: f32x4) -> F {
        [low, high]
    }
    #[inline(always)]
    fn halves(self, x: F) -> [f32x4; 2] {
        x
    }
    #[inline(always)]
    fn spread(self, x: F, k: usize) -> F {
        x.map(|half| f32x4::splat(half.as_array()[k % 4]))
    }
    #[inline(always)]
    fn transpose(self, rows: [F; 4]) -> [F; 4] {
        let [low, high] = [0, 1].map(|half| f32x4::transpose(rows.map(|row| row[half])));
        core::array::from_fn(|i| [low[i], high[i]])
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
    fn store_d(self, x: D) -> [f64; 8] {
        let [[a, b], [c, d], [e, f], [g, h]] = x.map(f64x2::to_array);
        [a, b, c, d, e, f, g, h]
    }
    #[inline(always)]
    fn widen(self, x: F) -> D {
        let x = self.store(x).map(f64::from);
        core::array::from_fn(|i| f64x2::new([x[2 * i], x[2 * i + 1]]))
    }
    #[inline(always)]
    fn abs_d(self, a: D) -> D {
        a.map(f64x2::abs)
    }
    #[inline(always)]
    fn mask_d(self, a: D) -> u32 {
        a[0].to_bitmask() | a[1].to_bitmask() << 2 | a[2].to_bitmask() << 4 | a[3].to_bitmask() << 6
    }
    #[inline(always)]
    fn narrow(self, x: D) -> F {
        let [[a, b], [c, d], [e, f], [g, h]] = x.map(f64x2::to_array);
        self.load(&[a, b, c, d, e, f, g, h].map(|x| x as f32))
    }
}
