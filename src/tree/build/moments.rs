//! Summaries of the surfaces of up to eight subtrees at a time, one per lane.
//!
//! A summary consists of area, mean, covariance, second moment of the normals, and the largest
//! triangle. The summary of a node follows from those of its children, so all nodes together cost
//! `O(n)`.

use super::eight::{Eight, present};
use crate::tree::unit::Triangle;
use crate::tree::wide::WIDTH;
use punctual_geom::lanes::{F8, Lanes, V8, cross, dot, per_axis, per_lane, sums};

/// A symmetric matrix per lane: xx, yy, zz, xy, xz, yz.
pub(crate) type Symmetric<L> = [F8<L>; 6];

/// `[e(0), .., e(5)]`: a symmetric matrix entry by entry.
macro_rules! per_entry {
    ($k:ident => $e:expr) => {
        punctual_geom::unrolled!($k in [0, 1, 2, 3, 4, 5] => $e)
    };
}
pub(crate) use per_entry;

/// Added to areas, so that they can be divisors.
pub(crate) const TINY: f32 = 1e-30;

/// The summaries in registers. A lane without area is empty.
pub(crate) struct Surfaces<L: Lanes> {
    area: F8<L>,
    mean: V8<L>,
    pub covariance: Symmetric<L>,
    pub normals: Symmetric<L>,
    /// The area of the largest triangle, and the number of that triangle.
    largest_area: F8<L>,
    pub largest: [u32; WIDTH],
}

/// [`Surfaces`] in memory.
#[derive(Clone, Copy, Default)]
#[repr(C, align(32))]
pub(crate) struct Moments {
    area: [f32; WIDTH],
    mean: [[f32; WIDTH]; 3],
    covariance: [[f32; WIDTH]; 6],
    normals: [[f32; WIDTH]; 6],
    largest_area: [f32; WIDTH],
    largest: [u32; WIDTH],
}

impl<L: Lanes> Surfaces<L> {
    /// Summaries of up to eight single triangles. The first has the number `first`.
    #[inline(always)]
    pub fn of_triangles(lanes: L, triangles: &[Triangle], first: usize) -> Self {
        let Eight {
            first: corner,
            edges: [e, f],
        } = Eight::of_few(lanes, triangles);
        let present = present(lanes, triangles.len());
        let normal = cross(e, f);
        // A triangle without area still has a position.
        let area = dot(normal, normal).sqrt() + F8::splat(lanes, TINY);
        let (ee, ff, gg) = (square(e), square(f), square(per_axis!(k => e[k] + f[k])));
        let (third, part, three) = (
            F8::splat(lanes, 1.0 / 3.0),
            F8::splat(lanes, 1.0 / 36.0),
            F8::splat(lanes, 3.0),
        );
        let normals = square(normal);
        let first = first as u32;
        Self {
            area: area * present,
            mean: per_axis!(k => corner[k] + (e[k] + f[k]) * third),
            // (2 e e^T + 2 f f^T - e f^T - f e^T) / 36
            covariance: per_entry!(k => ((ee[k] + ff[k]) * three - gg[k]) * part),
            normals: per_entry!(k => normals[k] * present / area),
            largest_area: area * present,
            largest: per_lane!(i => first + i),
        }
    }

    #[inline(always)]
    pub fn load(lanes: L, moments: &Moments) -> Self {
        Self {
            area: F8::load(lanes, &moments.area),
            mean: per_axis!(k => F8::load(lanes, &moments.mean[k])),
            covariance: per_entry!(k => F8::load(lanes, &moments.covariance[k])),
            normals: per_entry!(k => F8::load(lanes, &moments.normals[k])),
            largest_area: F8::load(lanes, &moments.largest_area),
            largest: moments.largest,
        }
    }
}

impl Moments {
    /// Merges all lanes of `parts` into lane `lane`.
    #[inline(always)]
    pub fn set<L: Lanes>(&mut self, lanes: L, lane: usize, parts: &Surfaces<L>) {
        let w = parts.area;
        let [area, x, y, z] = sums([w, w * parts.mean[0], w * parts.mean[1], w * parts.mean[2]]);
        let scale = 1.0 / area;
        let mean = [x * scale, y * scale, z * scale];
        let apart = square(per_axis!(k => parts.mean[k] - F8::splat(lanes, mean[k])));
        let c = per_entry!(k => (parts.covariance[k] + apart[k]) * w);
        let n = &parts.normals;
        let [xx, yy, zz, xy] = sums([c[0], c[1], c[2], c[3]]);
        let [xz, yz, n0, n1] = sums([c[4], c[5], n[0], n[1]]);
        let [n2, n3, n4, n5] = sums([n[2], n[3], n[4], n[5]]);
        self.area[lane] = area;
        for (column, x) in self.mean.iter_mut().zip(mean) {
            column[lane] = x;
        }
        for (column, x) in self.covariance.iter_mut().zip([xx, yy, zz, xy, xz, yz]) {
            column[lane] = x * scale;
        }
        for (column, x) in self.normals.iter_mut().zip([n0, n1, n2, n3, n4, n5]) {
            column[lane] = x;
        }
        let areas = parts.largest_area.store();
        let mut widest = 0;
        for i in 1..WIDTH {
            if areas[i] > areas[widest] {
                widest = i;
            }
        }
        self.largest_area[lane] = areas[widest];
        self.largest[lane] = parts.largest[widest];
    }
}

#[inline(always)]
pub(crate) fn square<L: Lanes>([x, y, z]: V8<L>) -> Symmetric<L> {
    [x * x, y * y, z * z, x * y, x * z, y * z]
}
