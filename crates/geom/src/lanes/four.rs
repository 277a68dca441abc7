//! Four lanes of `f64`, and eight as two times four.

use super::{Column, F8, Lanes, columns, operators};
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Four `f64` of the instruction set `L`, for work on one pair at a time.
#[derive(Clone, Copy)]
pub struct D4<L: Lanes>(L::Q, L);

#[allow(clippy::inline_always)]
impl<L: Lanes> D4<L> {
    #[inline(always)]
    pub fn splat(lanes: L, x: f64) -> Self {
        Self(lanes.load_q(&[x; 4]), lanes)
    }
    #[inline(always)]
    pub fn load(lanes: L, x: &[f64; 4]) -> Self {
        Self(lanes.load_q(x), lanes)
    }
    #[inline(always)]
    pub fn lanes(self) -> L {
        self.1
    }
    #[inline(always)]
    pub fn store(self) -> [f64; 4] {
        self.1.store_q(self.0)
    }
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.1.sqrt_q(self.0), self.1)
    }
    /// Permutes the lanes to 1, 2, 0 and 3.
    #[inline(always)]
    pub fn turned(self) -> Self {
        Self(self.1.turn_q(self.0), self.1)
    }
    /// Broadcasts lane `k` to all lanes.
    #[inline(always)]
    pub fn spread(self, k: usize) -> Self {
        Self(self.1.spread_q(self.0, k), self.1)
    }
    /// `a` where this mask is all ones, `b` where it is all zeros.
    #[inline(always)]
    pub fn select(self, a: Self, b: Self) -> Self {
        Self(self.1.select_q(self.0, a.0, b.0), self.1)
    }
}

operators!(D4: Add add add_q, Sub sub sub_q, Mul mul mul_q, Div div div_q);
columns!(D4, f64: max max_q, min min_q, less less_q, and and_q, or or_q; abs_q, mask_q);

/// Eight `f64` of the instruction set `L`. With a token for one half of the lanes, it is that half
/// twice.
#[derive(Clone, Copy)]
pub struct D8<L: Lanes>([D4<L>; 2]);

#[allow(clippy::inline_always)]
impl<L: Lanes> D8<L> {
    #[inline(always)]
    pub fn splat(lanes: L, x: f64) -> Self {
        Self([D4::splat(lanes, x); 2])
    }
    #[inline(always)]
    pub fn load(lanes: L, [low, high]: [[f64; 4]; 2]) -> Self {
        Self([D4::load(lanes, &low), D4::load(lanes, &high)])
    }
    #[inline(always)]
    pub fn widen(lanes: L, x: F8<L>) -> Self {
        let [low, high] = x.halves();
        Self([D4(lanes.widen(low), lanes), D4(lanes.widen(high), lanes)])
    }
    #[inline(always)]
    pub fn narrow(self) -> F8<L> {
        let Self([D4(low, lanes), D4(high, _)]) = self;
        F8::join(lanes, lanes.narrow(low), lanes.narrow(high))
    }
}

macro_rules! by_halves {
    ($($trait:ident $verb:ident),*) => { $(
        impl<L: Lanes> $trait for D8<L> {
            type Output = Self;
            #[inline(always)]
            fn $verb(self, other: Self) -> Self {
                let (Self([a, b]), Self([c, d])) = (self, other);
                Self([a.$verb(c), b.$verb(d)])
            }
        }
    )* };
}
by_halves!(Add add, Sub sub, Mul mul);
