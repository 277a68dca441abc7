//! Eight triangles in lanes, stored by component.

use crate::tree::unit::Triangle;
use crate::tree::wide::WIDTH;
use punctual_geom::lanes::{Column, F8, Lanes, V8, per_axis, per_lane};
use punctual_geom::triangle::batch::Transposed;

/// Eight triangles, one per lane.
#[derive(Clone, Copy)]
pub(crate) struct Eight<L: Lanes> {
    /// First corners.
    pub first: V8<L>,
    /// Vectors from there to the second and the third corners.
    pub edges: [V8<L>; 2],
}

impl<L: Lanes> Eight<L> {
    #[inline(always)]
    pub fn of(lanes: L, triangles: [&Triangle; WIDTH]) -> Self {
        let of = Transposed::new(lanes, per_lane!(i => &triangles[i].0));
        Self {
            first: of.first,
            edges: [of.edge1, of.edge2],
        }
    }

    /// Loads one to eight triangles. The last one fills the remaining lanes.
    #[inline(always)]
    pub fn of_few(lanes: L, triangles: &[Triangle]) -> Self {
        let last = triangles.len() - 1;
        Self::of(lanes, per_lane!(i => &triangles[last.min(i)]))
    }

    /// Loads the triangles with these indices.
    #[inline(always)]
    pub fn of_numbers(lanes: L, triangles: &[Triangle], numbers: [u32; WIDTH]) -> Self {
        Self::of(lanes, per_lane!(i => &triangles[numbers[i] as usize]))
    }

    #[inline(always)]
    pub fn of_chunk(lanes: L, chunk: &[Triangle; WIDTH]) -> Self {
        Self::of(lanes, per_lane!(i => &chunk[i]))
    }

    /// The corners, off by at most 2^-22.
    #[inline(always)]
    pub fn corners(&self) -> [V8<L>; 3] {
        let Self {
            first: p,
            edges: [e, f],
        } = *self;
        [p, per_axis!(k => p[k] + e[k]), per_axis!(k => p[k] + f[k])]
    }
}

/// 1 in the first `count` lanes, 0 in the others.
#[inline(always)]
pub(crate) fn present<L: Lanes>(lanes: L, count: usize) -> F8<L> {
    const NUMBERS: [f32; WIDTH] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    F8::load(lanes, &NUMBERS)
        .less(F8::splat(lanes, count as f32))
        .and(F8::splat(lanes, 1.0))
}
