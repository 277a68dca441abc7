//! SIMD types of eight `f32` or eight `f64`. All kernels are written with them.
//!
//! A kernel is written once, over [`F8`] and [`D8`], and compiled twice: for AVX2, chosen at run
//! time, and for pairs of 4-lane vectors (SSE2, NEON or plain arrays, depending on the target).
//! Every operation is one IEEE operation per lane and nothing is ever fused, so both give the same
//! bits.
//!
//! The token `L` proves that the machine supports the instruction set of the kernel, so this module
//! needs no `unsafe`.

mod across;
#[cfg(target_arch = "x86_64")]
mod avx2;
mod four;
mod portable;

pub use across::{greatest, least, sums};
#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;
pub use four::{D4, D8};
pub use portable::Portable;

use core::ops::{Add, Div, Mul, Neg, Sub};
use wide::f32x4;

/// Expands to `[e(i), e(j), ..]` for the listed numbers. This is a macro because the compiler would
/// not compile a closure for the instruction set of the surrounding kernel.
#[macro_export]
macro_rules! unrolled {
    ($k:ident in [$($i:literal),*] => $e:expr) => {
        [$({
            let $k = $i;
            $e
        }),*]
    };
}
pub use unrolled;

/// `[e(0), e(1), e(2)]`.
#[macro_export]
macro_rules! per_axis {
    ($k:ident => $e:expr) => {
        $crate::unrolled!($k in [0, 1, 2] => $e)
    };
}
pub use per_axis;

/// `[e(0), .., e(7)]`.
#[macro_export]
macro_rules! per_lane {
    ($k:ident => $e:expr) => {
        $crate::unrolled!($k in [0, 1, 2, 3, 4, 5, 6, 7] => $e)
    };
}
pub use per_lane;

/// Runs an expression on each register of `lanes: L` in turn. If eight lanes take two registers, a
/// kernel has more live values than the machine has registers; one half at a time needs fewer.
#[macro_export]
macro_rules! per_part {
    ($lanes:ident: $L:ident, $part:ident => $e:expr) => {{
        let (low, high) = $lanes.parts();
        {
            let $part = low;
            $e;
        }
        if !$L::IS_WHOLE {
            let $part = high;
            $e;
        }
    }};
}
pub use per_part;

/// An instruction set: the operations behind [`F8`] and [`D8`].
pub trait Lanes: Copy {
    /// True if eight `f32` fit one register; false if they take two.
    const IS_WHOLE: bool;
    /// Bit mask of the lanes that this token covers, out of eight.
    const ALL: u32;
    /// Eight `f32`, or eight all-ones or all-zeros masks.
    type F: Copy;
    /// Token for the lower register, or for the only one.
    type Low: Lanes;
    /// Token for the upper register.
    type High: Lanes;
    /// Four `f64`.
    type Q: Copy;

    /// Runs `kernel` compiled for this instruction set. All functions it calls must be
    /// `#[inline(always)]`.
    fn run<K: Kernel>(self, kernel: K) -> K::Output;

    /// Tokens for the two registers; with one register, its token twice.
    fn parts(self) -> (Self::Low, Self::High);

    /// Returns `x`. If eight lanes need more registers than the machine has, it also forces the
    /// compiler to read `x` from memory where it is used. Otherwise the compiler would move `x` to
    /// registers and spill it again.
    fn settled<T>(x: &T) -> &T;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, x: &[f32; 8]) -> Self::F;
    fn read(self, x: &[f32x4; 2]) -> Self::F;
    fn put(self, x: Self::F, to: &mut [f32; 8]);
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
    /// Joins two vectors of four to one of eight; `halves` is the inverse.
    fn join(self, low: f32x4, high: f32x4) -> Self::F;
    fn halves(self, x: Self::F) -> [f32x4; 2];
    /// Broadcasts entry `k` of each half to all lanes of that half.
    fn spread(self, x: Self::F, k: usize) -> Self::F;
    /// Transposes the 4 x 4 matrix in each half separately.
    fn transpose(self, rows: [Self::F; 4]) -> [Self::F; 4];
    /// Concatenates the first three entries of four rows, in each half separately.
    fn pack(self, rows: [Self::F; 4]) -> [Self::F; 3];

    fn widen(self, x: f32x4) -> Self::Q;
    fn narrow(self, x: Self::Q) -> f32x4;
    fn load_q(self, x: &[f64; 4]) -> Self::Q;
    fn store_q(self, x: Self::Q) -> [f64; 4];
    fn add_q(self, a: Self::Q, b: Self::Q) -> Self::Q;
    fn sub_q(self, a: Self::Q, b: Self::Q) -> Self::Q;
    fn mul_q(self, a: Self::Q, b: Self::Q) -> Self::Q;
    fn div_q(self, a: Self::Q, b: Self::Q) -> Self::Q;
    fn sqrt_q(self, a: Self::Q) -> Self::Q;
    fn less_q(self, a: Self::Q, b: Self::Q) -> Self::Q;
    fn and_q(self, a: Self::Q, b: Self::Q) -> Self::Q;
    fn or_q(self, a: Self::Q, b: Self::Q) -> Self::Q;
    fn abs_q(self, a: Self::Q) -> Self::Q;
    fn mask_q(self, a: Self::Q) -> u32;
    fn max_q(self, a: Self::Q, b: Self::Q) -> Self::Q;
    fn min_q(self, a: Self::Q, b: Self::Q) -> Self::Q;
    fn turn_q(self, a: Self::Q) -> Self::Q;
    fn spread_q(self, a: Self::Q, k: usize) -> Self::Q;
    fn select_q(self, mask: Self::Q, a: Self::Q, b: Self::Q) -> Self::Q;
}

/// Bit mask of the lanes that the token covers, out of eight.
#[inline(always)]
pub fn all<L: Lanes>(_lanes: L) -> u32 {
    L::ALL
}

/// A function to be compiled for each instruction set.
pub trait Kernel {
    /// The result type.
    type Output;
    /// The code for the instruction set of the token `lanes`.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Eight `f32` of the instruction set `L`.
#[derive(Clone, Copy)]
pub struct F8<L: Lanes>(L::F, L);

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
    /// Loads from two aligned halves, which SSE instructions accept as memory operands.
    #[inline(always)]
    pub fn read(lanes: L, x: &[f32x4; 2]) -> Self {
        Self(lanes.read(x), lanes)
    }
    #[inline(always)]
    pub fn put(self, to: &mut [f32; 8]) {
        self.1.put(self.0, to);
    }
    #[inline(always)]
    pub fn store(self) -> [f32; 8] {
        let mut to = [0.0; 8];
        self.put(&mut to);
        to
    }
    /// `a` where this mask is all ones, `b` where it is all zeros.
    #[inline(always)]
    pub fn select(self, a: Self, b: Self) -> Self {
        Self(self.1.select(self.0, a.0, b.0), self.1)
    }
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.1.sqrt(self.0), self.1)
    }
    #[inline(always)]
    pub fn join(lanes: L, low: f32x4, high: f32x4) -> Self {
        Self(lanes.join(low, high), lanes)
    }
    /// `x` in both halves.
    #[inline(always)]
    pub fn twice(lanes: L, x: f32x4) -> Self {
        Self::join(lanes, x, x)
    }
    #[inline(always)]
    pub fn halves(self) -> [f32x4; 2] {
        self.1.halves(self.0)
    }
    /// Broadcasts entry `k` of each half to all lanes of that half.
    #[inline(always)]
    pub fn spread(self, k: usize) -> Self {
        Self(self.1.spread(self.0, k), self.1)
    }
    /// Transposes the 4 x 4 matrix in each half separately.
    #[inline(always)]
    pub fn transposed([x, y, z, w]: [Self; 4]) -> [Self; 4] {
        let lanes = x.1;
        let columns = lanes.transpose([x.0, y.0, z.0, w.0]);
        unrolled!(k in [0, 1, 2, 3] => Self(columns[k], lanes))
    }
    /// Concatenates the first three entries of four rows, in each half separately.
    #[inline(always)]
    pub fn packed([x, y, z, w]: [Self; 4]) -> [Self; 3] {
        let rows = x.1.pack([x.0, y.0, z.0, w.0]);
        per_axis!(k => Self(rows[k], x.1))
    }
    /// Transposes eight rows of four to four columns of eight.
    #[inline(always)]
    pub fn columns(lanes: L, rows: [&[f32; 4]; 8]) -> [Self; 4] {
        let [a, b, c, d, e, f, g, h] = per_lane!(i => f32x4::new(*rows[i]));
        let (x, y) = (Self::join(lanes, a, e), Self::join(lanes, b, f));
        Self::transposed([x, y, Self::join(lanes, c, g), Self::join(lanes, d, h)])
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
pub(crate) use operators;
operators!(F8: Add add add, Sub sub sub, Mul mul mul, Div div div);

/// Operations that [`F8`] and [`D4`] share; lanes hold numbers or masks.
#[allow(clippy::inline_always)]
pub trait Column:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    fn max(self, other: Self) -> Self;
    fn min(self, other: Self) -> Self;
    /// All ones where `self < other`, zeros elsewhere; a comparison with NaN is false.
    fn less(self, other: Self) -> Self;
    fn and(self, other: Self) -> Self;
    fn or(self, other: Self) -> Self;
    /// One bit per lane, lane 0 lowest: the lane's sign bit. It is set for a mask of all ones.
    fn mask(self) -> u32;
    fn times(self, x: f32) -> Self;
    fn abs(self) -> Self;
}

macro_rules! columns {
    ($type:ident, $number:ty: $($name:ident $call:ident),*; $abs:ident, $mask:ident) => {
        impl<L: Lanes> Neg for $type<L> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                self.times(-1.0)
            }
        }
        #[allow(clippy::inline_always)]
        impl<L: Lanes> Column for $type<L> {
            $(#[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.1.$call(self.0, other.0), self.1)
            })*
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.1.$abs(self.0), self.1)
            }
            #[inline(always)]
            fn mask(self) -> u32 {
                self.1.$mask(self.0)
            }
            #[inline(always)]
            fn times(self, x: f32) -> Self {
                self * Self::splat(self.1, <$number>::from(x))
            }
        }
    };
}
pub(crate) use columns;
columns!(F8, f32: max max, min min, less less, and and, or or; abs, mask);

/// Three columns: the components of eight vectors.
pub type V8<L> = [F8<L>; 3];

#[inline(always)]
pub fn add<N: Column>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    per_axis!(k => a[k] + b[k])
}

#[inline(always)]
pub fn sub<N: Column>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    per_axis!(k => a[k] - b[k])
}

#[inline(always)]
pub fn scaled<N: Column>(a: [N; 3], factor: N) -> [N; 3] {
    per_axis!(k => a[k] * factor)
}

#[inline(always)]
pub fn dot<N: Copy + Add<Output = N> + Mul<Output = N>>(a: [N; 3], b: [N; 3]) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub fn cross<N: Copy + Sub<Output = N> + Mul<Output = N>>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The instruction sets the library is compiled for.
#[derive(Clone, Copy, Debug)]
pub enum Instructions {
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    Portable(Portable),
}

impl Instructions {
    pub const PORTABLE: Self = Self::Portable(Portable {});

    /// The best set that this machine supports.
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
