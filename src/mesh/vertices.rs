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
        self.replace(vertices.len(), |i| vertices[i].into().map(f64::from), |_| true)
    }

    /// The same with f64 vertices. Allocates only to go over from f32 to f64.
    pub(crate) fn set_vertices_f64<V: Copy + Into<[f64; 3]>>(&mut self, vertices: &[V]) -> Result<(), MeshError> {
        let is_exact = |i: usize| vertices[i].into().into_iter().all(is_f32_exact);
        self.replace(vertices.len(), |i| vertices[i].into(), is_exact)
    }

    /// Replaces all vertices by `count` new ones; `is_exact` tells of each whether f32 keeps every bit of it.
    fn replace(
        &mut self,
        count: usize,
        new: impl Fn(usize) -> [f64; 3],
        is_exact: impl Fn(usize) -> bool,
    ) -> Result<(), MeshError> {
        self.check_new(count, |i| DVec3::from_array(new(i)))?;
        let stays = !self.is_f32() || (0..count).all(&is_exact) || self.in_use().all(&is_exact);
        match &mut self.vertices {
            Vertices::F32(old) if stays => (0..).zip(old).for_each(|(i, old)| *old = new(i).map(|x| x as f32)),
            Vertices::F32(_) => self.vertices = Vertices::F64((0..count).map(new).collect()),
            Vertices::F64(old) => (0..).zip(old).for_each(|(i, old)| *old = new(i)),
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
        // A vertex that is not used may hold anything.
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
