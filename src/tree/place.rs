//! From the vertices of a mesh to unit coordinates, eight triangles at a time.

use super::unit::{Triangle, Unit};
use super::wide::WIDTH;
use crate::math::lanes::{D8, F8, Instructions, Kernel, Lanes, per_axis, per_lane};
use crate::mesh::{Mesh, Vertices};
use alloc::boxed::Box;

impl Unit {
    /// The triangles of `mesh` with the numbers `ids`.
    pub fn triangles(self, mesh: &Mesh, ids: &[u32]) -> Box<[Triangle]> {
        let mut triangles = alloc::vec![Triangle([[0.0; 4]; 3]); ids.len()].into_boxed_slice();
        self.place(mesh, ids, &mut triangles);
        triangles
    }

    /// Computes `triangles`, which are those of `mesh` with the numbers `ids`.
    pub fn place(self, mesh: &Mesh, ids: &[u32], triangles: &mut [Triangle]) {
        let (unit, corners, instructions) = (self, mesh.triangles(), Instructions::detect());
        match mesh.vertices() {
            Vertices::F32(vertices) => instructions.run(Place { unit, vertices, corners, ids, triangles }),
            Vertices::F64(vertices) => instructions.run(Place { unit, vertices, corners, ids, triangles }),
        }
    }
}

struct Place<'m, V> {
    unit: Unit,
    vertices: &'m [V],
    corners: &'m [[u32; 3]],
    ids: &'m [u32],
    triangles: &'m mut [Triangle],
}

impl<V: Vertex> Kernel for Place<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { unit, vertices, corners, ids, triangles } = self;
        let (eights, rest) = triangles.as_chunks_mut::<WIDTH>();
        let (ids, ids_rest) = ids.as_chunks::<WIDTH>();
        for (triangles, ids) in eights.iter_mut().zip(ids) {
            *triangles = rows(unit_corners(lanes, &unit, vertices, corners, ids));
        }
        if let Some(last) = ids_rest.len().checked_sub(1) {
            let ids = per_lane!(i => ids_rest[i.min(last)]);
            let triangles: [Triangle; WIDTH] = rows(unit_corners(lanes, &unit, vertices, corners, &ids));
            rest.copy_from_slice(&triangles[..=last]);
        }
    }
}

/// A vertex as the mesh stores it.
pub(super) trait Vertex: Copy {
    /// Eight of `vertices`, component by component.
    fn columns<L: Lanes>(lanes: L, vertices: &[Self], numbers: [u32; WIDTH]) -> [D8<L>; 3];
}

impl Vertex for [f32; 3] {
    #[inline(always)]
    fn columns<L: Lanes>(lanes: L, vertices: &[Self], numbers: [u32; WIDTH]) -> [D8<L>; 3] {
        // One load takes a vertex and a number behind it, which the last one lacks.
        let [x, y, z] = vertices[vertices.len() - 1];
        let last = [x, y, z, 0.0];
        let numbers = per_lane!(i => 3 * numbers[i] as usize);
        let all = vertices.as_flattened();
        let columns = F8::transpose(
            lanes,
            per_lane!(i => all.get(numbers[i]..numbers[i] + 4).and_then(<[f32]>::first_chunk).unwrap_or(&last)),
        );
        per_axis!(k => columns[k].widen())
    }
}

impl Vertex for [f64; 3] {
    #[inline(always)]
    fn columns<L: Lanes>(lanes: L, vertices: &[Self], numbers: [u32; WIDTH]) -> [D8<L>; 3] {
        let rows = per_lane!(i => &vertices[numbers[i] as usize]);
        per_axis!(k => D8::load(lanes, &per_lane!(i => rows[i][k])))
    }
}

/// The corners of the triangles with the numbers `ids`, unit coordinates: `[corner][axis]`.
#[inline(always)]
pub(super) fn unit_corners<L: Lanes, V: Vertex>(
    lanes: L,
    unit: &Unit,
    vertices: &[V],
    corners: &[[u32; 3]],
    ids: &[u32; WIDTH],
) -> [[D8<L>; 3]; 3] {
    let origin = per_axis!(k => D8::splat(lanes, unit.origin[k]));
    let scale = D8::splat(lanes, unit.scale());
    let corners = per_lane!(i => &corners[ids[i] as usize]);
    per_axis!(j => {
        let x = V::columns(lanes, vertices, per_lane!(i => corners[i][j]));
        per_axis!(k => (x[k] - origin[k]) * scale)
    })
}

/// The triangles with these corners, as the fast filter reads them.
#[inline(always)]
fn rows<L: Lanes>([a, b, c]: [[D8<L>; 3]; 3]) -> [Triangle; WIDTH] {
    let p = per_axis!(k => a[k].narrow());
    let (e, f) = (per_axis!(k => (b[k] - a[k]).narrow()), per_axis!(k => (c[k] - a[k]).narrow()));
    let rest = per_axis!(k => (a[k] - p[k].widen()).narrow());
    let first = F8::rows([p[0], p[1], p[2], e[0]]);
    let second = F8::rows([e[1], e[2], f[0], f[1]]);
    let third = F8::rows([f[2], rest[0], rest[1], rest[2]]);
    per_lane!(i => Triangle([first[i], second[i], third[i]]))
}
