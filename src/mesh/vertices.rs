//! The vertices of a mesh: how they are kept, checked and replaced.

use super::{Mesh, MeshError};
use crate::math::{Aabb, denormals, tolerance::COORDINATE_LIMIT};
use alloc::boxed::Box;
use glam::DVec3;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Vertices {
    F32(Box<[[f32; 3]]>),
    F64(Box<[[f64; 3]]>),
}

impl Vertices {
    #[inline]
    pub fn len(&self) -> usize {
        match self {
            Self::F32(v) => v.len(),
            Self::F64(v) => v.len(),
        }
    }

    #[inline]
    pub fn get(&self, i: usize) -> DVec3 {
        match self {
            Self::F32(v) => glam::Vec3::from_array(v[i]).as_dvec3(),
            Self::F64(v) => DVec3::from_array(v[i]),
        }
    }

    fn least_exponent(&self) -> i32 {
        match self {
            Self::F32(v) => denormals::least_exponent_f32(v.as_flattened()),
            Self::F64(v) => denormals::least_exponent(v.as_flattened()),
        }
    }
}

impl Mesh {
    /// Replaces all vertices; on an error nothing has changed. Allocates nothing.
    pub(crate) fn set_vertices<V: Copy + Into<[f32; 3]>>(&mut self, vertices: &[V]) -> Result<(), MeshError> {
        let new = |i: usize| DVec3::from_array(vertices[i].into().map(f64::from));
        self.check_new(vertices.len(), new)?;
        match &mut self.vertices {
            Vertices::F32(old) => old.iter_mut().zip(vertices).for_each(|(old, &new)| *old = new.into()),
            Vertices::F64(old) => {
                old.iter_mut().zip(vertices).for_each(|(old, &new)| *old = new.into().map(f64::from));
            }
        }
        self.measure();
        Ok(())
    }

    /// The same with f64 vertices. Allocates only to go over from f32 to f64.
    pub(crate) fn set_vertices_f64<V: Copy + Into<[f64; 3]>>(&mut self, vertices: &[V]) -> Result<(), MeshError> {
        let new = |i: usize| DVec3::from_array(vertices[i].into());
        self.check_new(vertices.len(), new)?;
        let exact = |vertex: DVec3| vertex.to_array().into_iter().all(is_f32_exact);
        let stays =
            !self.is_f32() || (0..vertices.len()).all(|i| exact(new(i))) || self.in_use().all(|i| exact(new(i)));
        match &mut self.vertices {
            Vertices::F32(old) if stays => {
                old.iter_mut().zip(vertices).for_each(|(old, &new)| *old = new.into().map(|x| x as f32));
            }
            Vertices::F64(old) => old.iter_mut().zip(vertices).for_each(|(old, &new)| *old = new.into()),
            Vertices::F32(_) => self.vertices = Vertices::F64(vertices.iter().map(|&new| new.into()).collect()),
        }
        self.measure();
        Ok(())
    }

    /// Takes note of the smallest box around all vertices in use, and of the least coordinate of any.
    pub(super) fn measure(&mut self) {
        let points = &self.vertices;
        self.aabb = if self.all_in_use {
            Aabb::from_points((0..points.len()).map(|i| points.get(i)))
        } else {
            Aabb::from_points(self.in_use().map(|i| points.get(i)))
        };
        self.least_exponent = points.least_exponent();
    }

    /// The vertices that triangles use, in their order, most of them several times.
    fn in_use(&self) -> impl Iterator<Item = usize> + use<'_> {
        self.triangles.as_flattened().iter().map(|&i| i as usize)
    }

    fn check_new(&self, count: usize, new: impl Fn(usize) -> DVec3) -> Result<(), MeshError> {
        let vertices = self.vertices.len();
        if count != vertices {
            return Err(MeshError::VertexCount { given: count, vertices });
        }
        // A fault in a vertex that is not used is none.
        let good = |i: usize| new(i).abs().cmple(DVec3::splat(COORDINATE_LIMIT)).all();
        if (0..count).all(good) { Ok(()) } else { self.in_use().try_for_each(|i| check_vertex(i, new(i))) }
    }
}

pub(super) fn check_vertex(vertex: usize, position: DVec3) -> Result<(), MeshError> {
    for axis in 0..3 {
        if !position[axis].is_finite() {
            return Err(MeshError::NotFinite { vertex, axis });
        }
        if position[axis].abs() > COORDINATE_LIMIT {
            return Err(MeshError::TooLarge { vertex, axis });
        }
    }
    Ok(())
}

/// Compared by bits, because the sign of a zero is kept too.
pub(super) fn is_f32_exact(coordinate: f64) -> bool {
    f64::from(coordinate as f32).to_bits() == coordinate.to_bits()
}

/// Whether triangles use every vertex.
pub(super) fn all_in_use(vertices: usize, triangles: &[[u32; 3]]) -> bool {
    let mut used = alloc::vec![false; vertices];
    triangles.as_flattened().iter().for_each(|&i| used[i as usize] = true);
    used.into_iter().all(|used| used)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, -3.0], [7.0, 7.0, 7.0]];
    const NAN: [f32; 3] = [0.0, f32::NAN, 0.0];

    /// The last vertex is not used.
    fn mesh() -> Mesh {
        Mesh::new(CORNERS, [[0, 1, 2]]).unwrap()
    }

    #[test]
    fn new_vertices_are_those_of_a_new_mesh() {
        let moved = CORNERS.map(|v| v.map(|x| 2.0 * x - 1.0));
        for triangles in [&[[0, 1, 2]][..], &[[0, 1, 2], [1, 2, 3]]] {
            let mut mesh = Mesh::new(CORNERS, triangles.iter().copied()).unwrap();
            mesh.set_vertices(&moved).unwrap();
            assert_eq!(mesh, Mesh::new(moved, triangles.iter().copied()).unwrap());
            mesh.set_vertices_f64(&CORNERS.map(|v| v.map(f64::from))).unwrap();
            assert_eq!(mesh, Mesh::new(CORNERS, triangles.iter().copied()).unwrap());
        }
    }

    #[test]
    fn a_wrong_count_or_a_bad_vertex_in_use_is_named_and_changes_nothing() {
        let mut mesh = mesh();
        let error = mesh.set_vertices(&CORNERS[..3]).unwrap_err();
        assert_eq!(error, MeshError::VertexCount { given: 3, vertices: 4 });
        let bad = [CORNERS[0], CORNERS[1], NAN, NAN];
        assert_eq!(mesh.set_vertices(&bad), Err(MeshError::NotFinite { vertex: 2, axis: 1 }));
        let large = [[0.0; 3], [0.0, 0.0, 2.0 * COORDINATE_LIMIT], [0.0; 3], [0.0; 3]];
        assert_eq!(mesh.set_vertices_f64(&large), Err(MeshError::TooLarge { vertex: 1, axis: 2 }));
        assert_eq!(mesh, self::mesh());
    }

    #[test]
    fn unused_vertices_may_hold_anything() {
        let mut mesh = mesh();
        mesh.set_vertices(&[CORNERS[0], CORNERS[1], CORNERS[1], NAN]).unwrap();
        assert_eq!(mesh.aabb(), Aabb { min: DVec3::ZERO, max: DVec3::X });
    }

    #[test]
    fn vertices_that_need_f64_get_it() {
        let mut mesh = mesh();
        let tenth = CORNERS.map(|v| v.map(|x| f64::from(x) * 0.1));
        mesh.set_vertices_f64(&tenth).unwrap();
        assert!(!mesh.is_f32());
        assert_eq!(mesh.vertex(2).to_array(), tenth[2]);
        mesh.set_vertices(&CORNERS).unwrap();
        assert_eq!(mesh.vertex(2), DVec3::new(0.0, 2.0, -3.0));
    }
}
