//! Unit coordinates, in which a tree stores its boxes and the triangles of the fast filter.
//!
//! `u = (x - origin) * 2^-exponent` moves the mesh's box to the origin and scales its longest half
//! extent into `[1/2, 1)`. So `f32` serves tiny and huge meshes and meshes far from their origin
//! alike. The scaling is by a power of two and so loses nothing; the shift is rounded in `f64`. The
//! exact stage never sees these coordinates.

use crate::mesh::Mesh;
use glam::DVec3;

/// The map from mesh to unit coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// Center of the mesh's box, in mesh coordinates.
    pub origin: DVec3,
    /// log2 of the length of one unit.
    pub exponent: i32,
    /// True if the mesh is a single point. Then all unit coordinates are 0, and the unit may have
    /// any length.
    pub is_point: bool,
}

/// A triangle as the fast filter reads it: the first corner and the edges to the other two, in unit
/// coordinates.
///
/// Twelve numbers in three rows of four: `first` (x, y, z), `edge1`, `edge2`, and `rest`, the
/// residual of rounding the first corner. `first + rest` is off by at most 2^-47, an edge by 2^-24
/// of its length plus 2^-52.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(crate) struct Triangle(pub [[f32; 4]; 3]);

const _: () = assert!(size_of::<Triangle>() == 48);

impl Unit {
    pub fn of(mesh: &Mesh) -> Self {
        if mesh.is_empty() {
            return Self {
                origin: DVec3::ZERO,
                exponent: 0,
                is_point: true,
            };
        }
        let bounds = mesh.aabb();
        // Halves first, because the sum of two finite corners may overflow.
        let origin = bounds.min * 0.5 + bounds.max * 0.5;
        let reach = (bounds.max - origin).max(origin - bounds.min).max_element();
        // A point has no extent of its own. Its distance from the origin is the scale of its
        // rounding.
        let scale = if reach > 0.0 {
            reach
        } else {
            origin.abs().max_element()
        };
        Self {
            origin,
            exponent: exponent_above(scale).clamp(-1000, 1010),
            is_point: reach == 0.0,
        }
    }

    /// The exponents of the units of two meshes. If one mesh is a point, it gets the exponent of
    /// the other, so that products of lengths stay within `f32`.
    pub fn exponents([a, b]: [&Self; 2]) -> [i32; 2] {
        match (a.is_point, b.is_point) {
            (_, true) => [a.exponent; 2],
            (true, false) => [b.exponent; 2],
            (false, false) => [a.exponent, b.exponent],
        }
    }

    /// Length of one unit, in mesh coordinates.
    pub fn length(&self) -> f64 {
        power_of_two(self.exponent)
    }

    /// Converts a point to unit coordinates.
    #[inline]
    pub fn point(&self, x: DVec3) -> DVec3 {
        (x - self.origin) * self.scale()
    }

    /// Factor from distances in the mesh to distances in unit coordinates.
    pub(crate) fn scale(&self) -> f64 {
        power_of_two(-self.exponent)
    }
}

/// Least `e` with `x < 2^e`, for a positive finite normal `x`; -1022 for a denormal one.
fn exponent_above(x: f64) -> i32 {
    ((x.to_bits() >> 52) & 0x7ff) as i32 - 1022
}

/// `2^e` for `|e| <= 1020`.
pub(crate) fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((e + 1023) as u64) << 52)
}
