//! Finds which of eight triangles a ray certainly misses, in `f32`.
//!
//! Let `e`, `f` be the edges of a triangle and `s` the vector from its first corner to the ray's
//! origin. Let `det = (d x f) . e`, `u = (d x f) . s` and `v = (s x e) . d`. The signs of `u`, `v`
//! and `det - u - v` give the sides on which the line passes the edges. The line meets the plane at
//! `t = (s x e) . f / det`. Each value has an error bound, computed from the largest components of
//! the edges and of `s`; `docs/numerics.md`, "Rays", derives it.

use crate::lanes::{Column, F8, Lanes, V8, cross, dot, per_axis, sub};
use crate::tolerance::ROUNDING;
use crate::triangle::batch::{EDGE_ERROR, Rows, Transposed, UNDERFLOW, largest};

/// A ray in unit coordinates, near the mesh.
#[derive(Clone, Copy, Debug)]
pub struct UnitRay {
    pub origin: [f32; 3],
    /// Its components are below 2 in magnitude.
    pub direction: [f32; 3],
    /// Error bound of the origin beyond its rounding.
    pub position_error: f32,
}

/// Largest parameter that a test may ask for.
pub const LARGEST_PARAMETER: f32 = 4.0;

/// Results for eight triangles, one bit each.
#[derive(Clone, Copy, Debug)]
pub struct Candidates {
    /// The ray may meet the triangle at a parameter within the tested range.
    pub may_meet: u32,
    /// `front`: the line certainly passes all three edges counterclockwise, as seen from
    /// [`super::Side::Front`]. `back`: it certainly passes all three clockwise.
    pub front: u32,
    pub back: u32,
    /// The line certainly meets the plane after the origin, given that it passes all three edges on
    /// one side.
    pub after: u32,
}

impl Candidates {
    /// The side on which the line passes all three edges of a triangle, if it is certain.
    #[inline(always)]
    pub fn faces(&self, lane: usize) -> Option<i8> {
        let [front, back] = [self.front, self.back].map(|bits| bits >> lane & 1);
        (front | back != 0).then(|| back as i8 - front as i8)
    }
}

/// Tests eight triangles for hits at parameters between `from` and `to`.
#[inline(always)]
pub fn candidates<L: Lanes>(
    lanes: L,
    rows: [&Rows; 8],
    ray: &UnitRay,
    [from, to]: [f32; 2],
) -> Candidates {
    let splat = |x: f32| F8::splat(lanes, x);
    let of = Transposed::new(lanes, rows);
    let (e, f) = (of.edge1, of.edge2);
    let d: V8<L> = per_axis!(k => splat(ray.direction[k]));
    let s = sub(per_axis!(k => splat(ray.origin[k])), of.first);
    let (across, turned) = (cross(d, f), cross(s, e));
    let (det, u, v) = (dot(across, e), dot(across, s), dot(turned, d));
    let w = det - u - v;

    let (edge, reach) = (largest(e).max(largest(f)) + splat(EDGE_ERROR), largest(s));
    let error = edge
        * (edge * splat(136.0 * ROUNDING)
            + reach * splat(264.0 * ROUNDING)
            + splat(88.0 * ROUNDING + 26.0 * ray.position_error))
        + splat(UNDERFLOW);
    let (least, most) = (u.min(v).min(w), u.max(v).max(w));
    let is_outside = error.less(most).and(least.less(-error));
    let (front, back) = (error.less(least).mask(), most.less(-error).mask());

    let square = edge * edge;
    let error = square
        * (reach * splat(56.0 * ROUNDING) + splat(600.0 * ROUNDING + 7.0 * ray.position_error))
        + splat(UNDERFLOW);
    let is_back = det.less(splat(0.0));
    let faces = |x: F8<L>| is_back.select(-x, x);
    let (size, above) = (faces(det), faces(dot(turned, f)));
    let (before, beyond) = (splat(from) * size - above, above - splat(to) * size);
    let is_off = error.less(before.max(beyond)).and(error.less(size));
    Candidates {
        may_meet: !is_outside.or(is_off).mask() & 0xff,
        front,
        back,
        after: error.less(above).mask(),
    }
}
