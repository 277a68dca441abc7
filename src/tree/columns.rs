//! Eight triangles, or eight of anything, component by component.

use super::unit::Triangle;
use super::wide::WIDTH;
use wide::{f32x4, f32x8};

/// Eight numbers.
pub(super) type F = f32x8;

/// Eight vectors.
pub(super) type V = [F; 3];

/// Up to eight triangles, one a lane; the lanes left over repeat the first.
pub(super) struct Columns {
    pub first: V,
    pub edges: [V; 2],
    /// 1 where there is a triangle, else 0.
    pub present: F,
}

impl Columns {
    #[inline(always)]
    pub fn of(triangles: &[Triangle]) -> Self {
        let count = triangles.len().min(WIDTH);
        let row = |i: usize, part: usize| f32x4::new(triangles[if i < count { i } else { 0 }].0[part]);
        let part = |part: usize| {
            let low = f32x4::transpose([row(0, part), row(1, part), row(2, part), row(3, part)]);
            let high = f32x4::transpose([row(4, part), row(5, part), row(6, part), row(7, part)]);
            [0, 1, 2, 3].map(|k| join(low[k], high[k]))
        };
        let [px, py, pz, ex] = part(0);
        let [ey, ez, fx, fy] = part(1);
        let [fz, ..] = part(2);
        Self { first: [px, py, pz], edges: [[ex, ey, ez], [fx, fy, fz]], present: F::new(PRESENT[count]) }
    }
}

/// For each count: 1 in as many lanes, then 0.
pub(super) const PRESENT: [[f32; WIDTH]; WIDTH + 1] = {
    let mut present = [[0.0; WIDTH]; WIDTH + 1];
    let mut count = 0;
    while count <= WIDTH {
        let mut i = 0;
        while i < count {
            present[count][i] = 1.0;
            i += 1;
        }
        count += 1;
    }
    present
};

fn join(low: f32x4, high: f32x4) -> F {
    let ([a, b, c, d], [e, f, g, h]) = (low.to_array(), high.to_array());
    F::new([a, b, c, d, e, f, g, h])
}

fn halves(x: F) -> [f32x4; 2] {
    let [a, b, c, d, e, f, g, h] = x.to_array();
    [f32x4::new([a, b, c, d]), f32x4::new([e, f, g, h])]
}

#[inline(always)]
pub(super) fn dot(a: V, b: V) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The sum over the lanes of each of four vectors.
#[inline(always)]
pub(super) fn sums(v: [F; 4]) -> [f32; 4] {
    let [a, b, c, d] = f32x4::transpose(v.map(|x| {
        let [low, high] = halves(x);
        low + high
    }));
    ((a + c) + (b + d)).to_array()
}
