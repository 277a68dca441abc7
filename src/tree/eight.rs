//! Eight triangles in lanes, component by component.

use super::unit::Triangle;
use super::wide::WIDTH;
use crate::math::lanes::{Column, F8, Lanes, V8, per_axis};

/// Eight triangles, one a lane.
#[derive(Clone, Copy)]
pub(super) struct Eight<L: Lanes> {
    /// First corners.
    pub first: V8<L>,
    /// From there to the second and to the third corners.
    pub edges: [V8<L>; 2],
}

impl<L: Lanes> Eight<L> {
    #[inline(always)]
    pub fn of(lanes: L, [a, b, c, d, e, f, g, h]: [&Triangle; WIDTH]) -> Self {
        macro_rules! part {
            ($i:expr) => {
                F8::columns(lanes, [&a.0[$i], &b.0[$i], &c.0[$i], &d.0[$i], &e.0[$i], &f.0[$i], &g.0[$i], &h.0[$i]])
            };
        }
        let [px, py, pz, ex] = part!(0);
        let [ey, ez, fx, fy] = part!(1);
        let [fz, ..] = part!(2);
        Self { first: [px, py, pz], edges: [[ex, ey, ez], [fx, fy, fz]] }
    }

    /// Of up to eight triangles, at least one; the last again in the lanes that are left over.
    #[inline(always)]
    pub fn of_few(lanes: L, triangles: &[Triangle]) -> Self {
        let last = triangles.len() - 1;
        macro_rules! at {
            ($i:expr) => {
                &triangles[$i.min(last)]
            };
        }
        Self::of(lanes, [at!(0), at!(1), at!(2), at!(3), at!(4), at!(5), at!(6), at!(7)])
    }

    /// Of the triangles with these numbers.
    #[inline(always)]
    pub fn of_numbers(lanes: L, triangles: &[Triangle], [a, b, c, d, e, f, g, h]: [u32; WIDTH]) -> Self {
        macro_rules! at {
            ($i:expr) => {
                &triangles[$i as usize]
            };
        }
        Self::of(lanes, [at!(a), at!(b), at!(c), at!(d), at!(e), at!(f), at!(g), at!(h)])
    }

    #[inline(always)]
    pub fn of_chunk(lanes: L, [a, b, c, d, e, f, g, h]: &[Triangle; WIDTH]) -> Self {
        Self::of(lanes, [a, b, c, d, e, f, g, h])
    }

    /// The corners, off by at most 2^-22.
    #[inline(always)]
    pub fn corners(&self) -> [V8<L>; 3] {
        let Self { first: p, edges: [e, f] } = *self;
        [p, per_axis!(k => p[k] + e[k]), per_axis!(k => p[k] + f[k])]
    }
}

/// 1 in the first `count` lanes, 0 in the others.
#[inline(always)]
pub(super) fn present<L: Lanes>(lanes: L, count: usize) -> F8<L> {
    const NUMBERS: [f32; WIDTH] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    F8::load(lanes, &NUMBERS).less(F8::splat(lanes, count as f32)).and(F8::splat(lanes, 1.0))
}
