//! Triangles of a leaf seen from a node of the other side: their boxes and their planes.

use super::relative_pose::{self, View};
use super::{Boxes, Slabs, Stored, Triangles};
use crate::tree::xyz;
use punctual_geom::lanes::{Column, F8, Lanes, cross, dot, per_axis};
use punctual_geom::triangle::batch::{LEAST_EDGE_ERROR, Rows, Transposed, UNDERFLOW, largest};
use wide::f32x4;

/// Eight triangles, stored for access one at a time.
#[derive(Default)]
pub struct Planes {
    boxes: Stored,
    corner: [[f32; 8]; 3],
    normal: [[f32; 8]; 3],
    reach: [[f32; 8]; 3],
    normal_error: [f32; 8],
    plane_error: [f32; 8],
}

impl Planes {
    #[inline(always)]
    pub fn new<L: Lanes>(lanes: L, triangles: &Triangles) -> Self {
        let mut planes = Self::default();
        planes.put(lanes, triangles);
        planes
    }

    #[inline(always)]
    pub fn put<L: Lanes>(
        &mut self,
        lanes: L,
        Triangles {
            rows,
            view,
            rotation_error,
        }: &Triangles,
    ) {
        let of = Transposed::new(lanes, *rows);
        let axes = per_axis!(k => per_axis!(j => F8::splat(lanes, view.columns[j].as_array()[k])));
        let p =
            per_axis!(k => dot(axes[k], of.first) + F8::splat(lanes, view.origin.as_array()[k]));
        let e = per_axis!(k => dot(axes[k], of.edge1));
        let f = per_axis!(k => dot(axes[k], of.edge2));
        let (zero, margin) = (
            F8::splat(lanes, 0.0),
            F8::splat(lanes, view.margin.as_array()[0]),
        );
        let normal = cross(e, f);
        let least = F8::splat(lanes, LEAST_EDGE_ERROR);
        let normal_error =
            (largest(e) + least) * (largest(f) + least) * F8::splat(lanes, *rotation_error);
        let size = per_axis!(k => normal[k].abs());
        let plane_error = margin
            * (size[0] + size[1] + size[2] + normal_error * F8::splat(lanes, 4.0))
            + F8::splat(lanes, UNDERFLOW);
        per_axis!(k => (p[k] + zero.max(e[k]).max(f[k]) + margin).put(&mut self.boxes.along[k]));
        per_axis!(k => (margin - (p[k] + zero.min(e[k]).min(f[k]))).put(&mut self.boxes.against[k]));
        per_axis!(k => p[k].put(&mut self.corner[k]));
        per_axis!(k => normal[k].put(&mut self.normal[k]));
        per_axis!(k => (size[k] + normal_error).put(&mut self.reach[k]));
        normal_error.put(&mut self.normal_error);
        plane_error.put(&mut self.plane_error);
    }

    #[inline(always)]
    pub fn at(&self, i: usize) -> Plane {
        Plane {
            along: per_axis!(k => self.boxes.along[k][i]),
            against: per_axis!(k => self.boxes.against[k][i]),
            corner: per_axis!(k => self.corner[k][i]),
            normal: per_axis!(k => self.normal[k][i]),
            reach: per_axis!(k => self.reach[k][i]),
            normal_error: self.normal_error[i],
            plane_error: self.plane_error[i],
        }
    }
}

/// A triangle seen from a node of the other side: its box and its plane.
#[derive(Debug, PartialEq)]
pub struct Plane {
    /// The ends of its box, as in [`Slabs`].
    pub along: [f32; 3],
    pub against: [f32; 3],
    pub corner: [f32; 3],
    pub normal: [f32; 3],
    /// `|n_k|` plus the error bound of the normal.
    pub reach: [f32; 3],
    pub normal_error: f32,
    pub plane_error: f32,
}

impl Plane {
    /// Computes the plane of one triangle, bit for bit as [`Planes`] does for eight.
    #[inline(always)]
    pub fn new([first, second, third]: &Rows, view: &View, rotation_error: f32) -> Self {
        let (margin, zero) = (view.margin, f32x4::ZERO);
        let p = view.point(f32x4::new([first[0], first[1], first[2], 0.0]));
        let e = view.vector(f32x4::new([first[3], second[0], second[1], 0.0]));
        let f = view.vector(f32x4::new([second[2], second[3], third[0], 0.0]));
        let normal = relative_pose::cross(e, f);
        let longest = |v: f32x4| {
            let [x, y, z] = xyz(v.abs());
            x.max(y).max(z)
        };
        let normal_error =
            (longest(e) + LEAST_EDGE_ERROR) * (longest(f) + LEAST_EDGE_ERROR) * rotation_error;
        let size = normal.abs();
        let [x, y, z] = xyz(size);
        Self {
            along: xyz(p + zero.fast_max(e).fast_max(f) + margin),
            against: xyz(margin - (p + zero.fast_min(e).fast_min(f))),
            corner: xyz(p),
            normal: xyz(normal),
            reach: xyz(size + f32x4::splat(normal_error)),
            normal_error,
            plane_error: margin.as_array()[0] * (x + y + z + normal_error * 4.0) + UNDERFLOW,
        }
    }

    /// Overlap depth of its box with the boxes, and by how much they extend across its plane, times
    /// the length of `n`; negative means a gap. The latter is `|n| . h - |n . (c - p)|`, plus all
    /// errors of `n` (relative to the edges) and of `p`.
    #[inline(always)]
    pub fn depths<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>, slabs: &Slabs<L>) -> [F8<L>; 2] {
        let [distance, reach] = self.across(lanes, boxes);
        [
            slabs.depth(&Slabs::of(lanes, self.along, self.against)),
            reach - distance.abs(),
        ]
    }

    /// Signed distance of the centres of boxes from the plane, and how far the boxes extend towards
    /// it, both times the length of `n`.
    #[inline(always)]
    pub fn across<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>) -> [F8<L>; 2] {
        let from_corner = per_axis!(k => boxes.center[k] - F8::splat(lanes, self.corner[k]));
        let distance = dot(
            per_axis!(k => F8::splat(lanes, self.normal[k])),
            from_corner,
        );
        let reach = dot(per_axis!(k => F8::splat(lanes, self.reach[k])), boxes.half)
            + (from_corner[0].abs() + from_corner[1].abs() + from_corner[2].abs())
                * F8::splat(lanes, self.normal_error)
            + F8::splat(lanes, self.plane_error);
        [distance, reach]
    }

    /// Upper bound of the length of `n`.
    #[inline(always)]
    pub fn length(&self) -> f32 {
        let [x, y, z] = self.reach;
        x + y + z + UNDERFLOW
    }
}
