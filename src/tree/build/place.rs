//! Converts the vertices of a mesh to unit coordinates, two triangles at a time.

use super::bins::Bounds;
use crate::mesh::{Mesh, Vertices};
use crate::tree::fork::Pieces;
use crate::tree::unit::{Triangle, Unit};
use alloc::boxed::Box;
use alloc::vec::Vec;
use glam::Mat3A;
use punctual_geom::lanes::{Column, D8, F8, Instructions, Kernel, Lanes, per_axis, unrolled};
use wide::f32x4;

/// Triangles of a mesh in some order.
#[derive(Default)]
pub(crate) struct Placed {
    /// Vertex indices of the triangles, in this order. A refit reads them sequentially; in the mesh
    /// they would be scattered in memory.
    pub corners: Box<[[u32; 3]]>,
    pub triangles: Box<[Triangle]>,
}

impl Placed {
    /// The triangles of `mesh` with the indices `ids`.
    pub fn of(mesh: &Mesh, unit: Unit, ids: &[u32], pieces: Pieces) -> Self {
        let mut corners = alloc::vec![[0; 3]; ids.len()].into_boxed_slice();
        let mut triangles = alloc::vec![Triangle([[0.0; 4]; 3]); ids.len()].into_boxed_slice();
        let size = pieces.size(ids.len());
        let tasks = ids
            .chunks(size)
            .zip(corners.chunks_mut(size))
            .zip(triangles.chunks_mut(size))
            .collect();
        pieces.each(tasks, |((ids, corners), triangles)| {
            ids.iter()
                .zip(&mut *corners)
                .for_each(|(&id, corners)| *corners = mesh.triangles()[id as usize]);
            unit.place(mesh, corners, triangles);
        });
        Self { corners, triangles }
    }
}

impl Unit {
    /// Computes `triangles` from the vertices of `mesh` with the indices `corners`.
    pub(crate) fn place(self, mesh: &Mesh, corners: &[[u32; 3]], triangles: &mut [Triangle]) {
        Instructions::detect().run(Convert {
            unit: self,
            mesh,
            corners,
            make: Place,
            made: triangles,
        });
    }

    /// The boxes of all triangles of `mesh` along the columns of `axes`.
    pub(crate) fn bounds(self, mesh: &Mesh, axes: Mat3A, pieces: Pieces) -> Vec<Bounds> {
        let mut bounds = alloc::vec![Bounds::EMPTY; mesh.len()];
        let to_axes = axes.transpose();
        let to_axes = [to_axes.x_axis, to_axes.y_axis, to_axes.z_axis]
            .map(|axis| f32x4::new(axis.extend(0.0).to_array()));
        let size = pieces.size(mesh.len());
        let corners = mesh.triangles().chunks(size);
        let tasks = corners.zip(bounds.chunks_mut(size)).enumerate().collect();
        pieces.each(tasks, |(number, (corners, made))| {
            Instructions::detect().run(Convert {
                unit: self,
                mesh,
                corners,
                make: Enclose {
                    to_axes,
                    first: (number * size) as u32,
                },
                made,
            });
        });
        bounds
    }
}

/// Maps each triangle of a mesh with the vertex indices `corners`, two at a time.
struct Convert<'m, M: Make> {
    unit: Unit,
    mesh: &'m Mesh,
    corners: &'m [[u32; 3]],
    make: M,
    made: &'m mut [M::Made],
}

trait Make {
    type Made;
    /// Maps two triangles in unit coordinates. The first has the number `at`.
    fn two<L: Lanes>(&self, lanes: L, corners: [D8<L>; 3], at: usize) -> [Self::Made; 2];
}

impl<M: Make> Kernel for Convert<'_, M> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        match self.mesh.vertices() {
            Vertices::F32(vertices) => self.all(lanes, vertices),
            Vertices::F64(vertices) => self.all(lanes, vertices),
        }
    }
}

impl<M: Make> Convert<'_, M> {
    #[inline(always)]
    fn all<L: Lanes, V: Vertex>(self, lanes: L, vertices: &[V]) {
        let (twos, rest) = self.made.as_chunks_mut();
        let (corners, corners_rest) = self.corners.as_chunks();
        for (at, (two, [one, other])) in twos.iter_mut().zip(corners).enumerate() {
            let points = points(lanes, &self.unit, vertices, [one, other]);
            *two = self.make.two(lanes, points, 2 * at);
        }
        if let ([last], [corners]) = (rest, corners_rest) {
            let points = points(lanes, &self.unit, vertices, [corners; 2]);
            [*last, _] = self.make.two(lanes, points, self.corners.len() - 1);
        }
    }
}

/// The corners of two triangles in unit coordinates. A point takes three lanes of four.
#[inline(always)]
fn points<L: Lanes, V: Vertex>(
    lanes: L,
    unit: &Unit,
    vertices: &[V],
    [one, other]: [&[u32; 3]; 2],
) -> [D8<L>; 3] {
    let [x, y, z] = unit.origin.to_array();
    let origin = D8::load(lanes, [[x, y, z, 0.0]; 2]);
    let scale = D8::splat(lanes, unit.scale());
    per_axis!(j => (V::two(lanes, vertices, [one[j] as usize, other[j] as usize]) - origin) * scale)
}

/// Makes triangles as the fast filter reads them.
struct Place;

impl Make for Place {
    type Made = Triangle;

    #[inline(always)]
    fn two<L: Lanes>(&self, lanes: L, [a, b, c]: [D8<L>; 3], _: usize) -> [Triangle; 2] {
        let first = a.narrow();
        let rows = F8::packed([
            first,
            (b - a).narrow(),
            (c - a).narrow(),
            (a - D8::widen(lanes, first)).narrow(),
        ]);
        let rows = per_axis!(k => rows[k].halves());
        unrolled!(i in [0, 1] => Triangle(per_axis!(k => rows[k][i].to_array())))
    }
}

/// Makes boxes along other axes. The id of the first is `first`.
struct Enclose {
    to_axes: [f32x4; 3],
    first: u32,
}

impl Make for Enclose {
    type Made = Bounds;

    #[inline(always)]
    fn two<L: Lanes>(&self, lanes: L, points: [D8<L>; 3], at: usize) -> [Bounds; 2] {
        let axes = per_axis!(k => F8::twice(lanes, self.to_axes[k]));
        let [a, b, c] = per_axis!(j => {
            let point = points[j].narrow();
            axes[0] * point.spread(0) + axes[1] * point.spread(1) + axes[2] * point.spread(2)
        });
        let (min, max) = (a.min(b).min(c).store(), a.max(b).max(c).store());
        let id = self.first + at as u32;
        unrolled!(i in [0, 4] =>
            Bounds::new(id + i as u32 / 4, [min[i], min[i + 1], min[i + 2]], [max[i], max[i + 1], max[i + 2]]))
    }
}

/// A vertex as the mesh stores it.
trait Vertex: Copy {
    /// Two of `vertices`, each followed by a zero.
    fn two<L: Lanes>(lanes: L, vertices: &[Self], numbers: [usize; 2]) -> D8<L>;
}

impl Vertex for [f32; 3] {
    #[inline(always)]
    fn two<L: Lanes>(lanes: L, vertices: &[Self], [one, other]: [usize; 2]) -> D8<L> {
        let ([a, b, c], [d, e, f]) = (vertices[one], vertices[other]);
        D8::widen(lanes, F8::load(lanes, &[a, b, c, 0.0, d, e, f, 0.0]))
    }
}

impl Vertex for [f64; 3] {
    #[inline(always)]
    fn two<L: Lanes>(lanes: L, vertices: &[Self], [one, other]: [usize; 2]) -> D8<L> {
        let ([a, b, c], [d, e, f]) = (vertices[one], vertices[other]);
        D8::load(lanes, [[a, b, c, 0.0], [d, e, f, 0.0]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// Compares both instruction sets with scalar arithmetic, for even and odd numbers of triangles
    /// and for f32 and f64 vertices.
    #[test]
    fn a_placed_triangle_is_its_first_corner_its_edges_and_what_rounding_left() {
        let narrow = shapes::torus_knot(2, 3, 0.2, 8);
        let wide = Mesh::from_f64(
            (0..narrow.vertex_count()).map(|i| narrow.vertex(i) * 0.1),
            narrow.triangles().iter().copied(),
        );
        for mesh in [narrow, wide.unwrap()] {
            let unit = Unit::of(&mesh);
            for (instructions, count) in [Instructions::detect(), Instructions::PORTABLE]
                .into_iter()
                .flat_map(|set| [7, 8].map(|n| (set, n)))
            {
                let corners = &mesh.triangles()[..count];
                let mut triangles = alloc::vec![Triangle([[0.0; 4]; 3]); count];
                instructions.run(Convert {
                    unit,
                    mesh: &mesh,
                    corners,
                    make: Place,
                    made: &mut triangles,
                });
                for (i, triangle) in triangles.iter().enumerate() {
                    let [a, b, c] = mesh.triangle(i).map(|corner| unit.point(corner));
                    let first = a.as_vec3();
                    let parts = [
                        first,
                        (b - a).as_vec3(),
                        (c - a).as_vec3(),
                        (a - first.as_dvec3()).as_vec3(),
                    ];
                    assert_eq!(
                        triangle.0.as_flattened(),
                        parts.map(|part| part.to_array()).as_flattened()
                    );
                }
            }
        }
    }
}
