//! From the vertices of a mesh to unit coordinates, eight triangles at a time.

use super::unit::{Triangle, Unit};
use super::wide::WIDTH;
use crate::math::lanes::{D8, F8, Instructions, Kernel, Lanes, per_axis};
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
            let ids = core::array::from_fn(|i| ids_rest[i.min(last)]);
            let triangles: [Triangle; WIDTH] = rows(unit_corners(lanes, &unit, vertices, corners, &ids));
            rest.copy_from_slice(&triangles[..=last]);
        }
    }
}

/// A vertex as the mesh stores it.
pub(super) trait Vertex: Copy {
    /// Eight of them, component by component.
    fn columns<L: Lanes>(lanes: L, vertices: [&Self; WIDTH]) -> [D8<L>; 3];
}

impl Vertex for [f32; 3] {
    #[inline(always)]
    fn columns<L: Lanes>(lanes: L, [a, b, c, d, e, f, g, h]: [&Self; WIDTH]) -> [D8<L>; 3] {
        macro_rules! row {
            ($x:ident) => {
                &[$x[0], $x[1], $x[2], 0.0]
            };
        }
        let rows = [row!(a), row!(b), row!(c), row!(d), row!(e), row!(f), row!(g), row!(h)];
        let columns = F8::transpose(lanes, rows);
        per_axis!(k => columns[k].widen())
    }
}

impl Vertex for [f64; 3] {
    #[inline(always)]
    fn columns<L: Lanes>(lanes: L, [a, b, c, d, e, f, g, h]: [&Self; WIDTH]) -> [D8<L>; 3] {
        per_axis!(k => D8::load(lanes, &[a[k], b[k], c[k], d[k], e[k], f[k], g[k], h[k]]))
    }
}

/// The corners of the triangles with the numbers `ids`, unit coordinates: `[corner][axis]`.
#[inline(always)]
pub(super) fn unit_corners<L: Lanes, V: Vertex>(
    lanes: L,
    unit: &Unit,
    vertices: &[V],
    corners: &[[u32; 3]],
    [a, b, c, d, e, f, g, h]: &[u32; WIDTH],
) -> [[D8<L>; 3]; 3] {
    let origin = per_axis!(k => D8::splat(lanes, unit.origin[k]));
    let scale = D8::splat(lanes, unit.scale());
    macro_rules! vertex {
        ($id:ident, $corner:ident) => {
            &vertices[corners[*$id as usize][$corner] as usize]
        };
    }
    per_axis!(i => {
        let (a, b, c, d) = (vertex!(a, i), vertex!(b, i), vertex!(c, i), vertex!(d, i));
        let (e, f, g, h) = (vertex!(e, i), vertex!(f, i), vertex!(g, i), vertex!(h, i));
        let x = V::columns(lanes, [a, b, c, d, e, f, g, h]);
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
    macro_rules! triangles {
        ($($i:literal),*) => { [$(Triangle([first[$i], second[$i], third[$i]])),*] };
    }
    triangles!(0, 1, 2, 3, 4, 5, 6, 7)
}
