//! From the vertices of a mesh to unit coordinates, two triangles at a time.

use super::unit::{Triangle, Unit};
use crate::math::lanes::{D8, F8, Instructions, Kernel, Lanes, per_axis, unrolled};
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
        let (twos, rest) = triangles.as_chunks_mut();
        let (ids, ids_rest) = ids.as_chunks();
        for (two, &ids) in twos.iter_mut().zip(ids) {
            *two = place_two(lanes, &unit, vertices, corners, ids);
        }
        if let ([triangle], &[id]) = (rest, ids_rest) {
            [*triangle, _] = place_two(lanes, &unit, vertices, corners, [id; 2]);
        }
    }
}

/// The triangles with the numbers `ids`. A vertex is three lanes of four.
#[inline(always)]
fn place_two<L: Lanes, V: Vertex>(
    lanes: L,
    unit: &Unit,
    vertices: &[V],
    corners: &[[u32; 3]],
    [id, other]: [u32; 2],
) -> [Triangle; 2] {
    let [x, y, z] = unit.origin.to_array();
    let origin = D8::load(lanes, &[x, y, z, 0.0, x, y, z, 0.0]);
    let scale = D8::splat(lanes, unit.scale());
    let (one, other) = (&corners[id as usize], &corners[other as usize]);
    let [a, b, c] = per_axis!(j => (V::two(lanes, vertices, [one[j] as usize, other[j] as usize]) - origin) * scale);
    let p = a.narrow();
    let (e, f) = ((b - a).narrow().store(), (c - a).narrow().store());
    let (p, rest) = (p.store(), (a - p.widen()).narrow().store());
    unrolled!(i in [0, 4] => Triangle([
        [p[i], p[i + 1], p[i + 2], e[i]],
        [e[i + 1], e[i + 2], f[i], f[i + 1]],
        [f[i + 2], rest[i], rest[i + 1], rest[i + 2]],
    ]))
}

/// A vertex as the mesh stores it.
trait Vertex: Copy {
    /// Two of `vertices`, each with a zero behind it.
    fn two<L: Lanes>(lanes: L, vertices: &[Self], numbers: [usize; 2]) -> D8<L>;
}

impl Vertex for [f32; 3] {
    #[inline(always)]
    fn two<L: Lanes>(lanes: L, vertices: &[Self], [one, other]: [usize; 2]) -> D8<L> {
        let ([a, b, c], [d, e, f]) = (vertices[one], vertices[other]);
        F8::load(lanes, &[a, b, c, 0.0, d, e, f, 0.0]).widen()
    }
}

impl Vertex for [f64; 3] {
    #[inline(always)]
    fn two<L: Lanes>(lanes: L, vertices: &[Self], [one, other]: [usize; 2]) -> D8<L> {
        let ([a, b, c], [d, e, f]) = (vertices[one], vertices[other]);
        D8::load(lanes, &[a, b, c, 0.0, d, e, f, 0.0])
    }
}
