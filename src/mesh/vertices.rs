//! Storage, validation and replacement of the vertices of a mesh.

use super::survey::{Survey, survey};
use super::{Mesh, MeshError};
use alloc::boxed::Box;
use alloc::vec::Vec;
use glam::DVec3;
use punctual_geom::{Aabb, denormals::Number, tolerance::COORDINATE_LIMIT};

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
}

/// A coordinate type in which vertices can be stored.
trait Kept: Number {
    /// Stores all vertices. Allocates only if those stored before have the other precision.
    fn keep(vertices: &mut Vertices, new: impl Iterator<Item = [Self; 3]>);
}

macro_rules! kept {
    ($float:ident, $kind:ident) => {
        impl Kept for $float {
            #[inline(always)]
            fn keep(vertices: &mut Vertices, new: impl Iterator<Item = [Self; 3]>) {
                match vertices {
                    Vertices::$kind(old) => {
                        old.iter_mut().zip(new).for_each(|(old, new)| *old = new)
                    }
                    _ => *vertices = Vertices::$kind(new.collect()),
                }
            }
        }
    };
}
kept!(f32, F32);
kept!(f64, F64);

impl Mesh {
    /// Replaces all vertices. On an error nothing changes. Allocates nothing.
    pub(crate) fn set_vertices<V: Copy + Into<[f32; 3]>>(
        &mut self,
        vertices: &[V],
    ) -> Result<(), MeshError> {
        if self.is_f32() {
            self.replace(vertices, V::into)
        } else {
            self.replace(vertices, |vertex| vertex.into().map(f64::from))
        }
    }

    /// Replaces all vertices by f64 vertices. Allocates only to change from f32 to f64 storage.
    pub(crate) fn set_vertices_f64<V: Copy + Into<[f64; 3]>>(
        &mut self,
        vertices: &[V],
    ) -> Result<(), MeshError> {
        let is_exact = |vertex: &V| (*vertex).into().into_iter().all(is_f32_exact);
        let in_use = || self.in_use().all(|i| vertices.get(i).is_some_and(is_exact));
        if self.is_f32() && (vertices.iter().all(is_exact) || in_use()) {
            self.replace(vertices, |vertex| vertex.into().map(|x| x as f32))
        } else {
            self.replace(vertices, V::into)
        }
    }

    fn replace<V: Copy, N: Kept>(
        &mut self,
        vertices: &[V],
        of: impl Fn(V) -> [N; 3] + Copy,
    ) -> Result<(), MeshError> {
        if vertices.len() != self.vertices.len() {
            return Err(MeshError::VertexCount {
                given: vertices.len(),
                vertices: self.vertices.len(),
            });
        }
        let survey = survey(vertices, of);
        // Unused vertices may hold any value, so check only those in use.
        if !survey.is_good {
            self.in_use().try_for_each(|i| {
                check_vertex(i, DVec3::from_array(of(vertices[i]).map(Into::into)))
            })?;
        }
        N::keep(
            &mut self.vertices,
            vertices.iter().map(|&vertex| of(vertex)),
        );
        self.note(&survey);
        Ok(())
    }

    /// Finds the smallest box around all vertices in use, and the least magnitude of a coordinate.
    /// Returns false if a vertex, in use or not, is not finite or too large.
    pub(super) fn measure(&mut self) -> bool {
        let survey = match &self.vertices {
            Vertices::F32(v) => survey(v, |vertex| vertex),
            Vertices::F64(v) => survey(v, |vertex| vertex),
        };
        self.note(&survey);
        survey.is_good
    }

    /// Refuses the first point that is not finite or too large.
    pub(crate) fn check_points<V: Copy + Into<[f32; 3]>>(points: &[V]) -> Result<(), MeshError> {
        if survey(points, V::into).is_good {
            return Ok(());
        }
        let vertex = |point: V| DVec3::from_array(point.into().map(f64::from));
        (0..points.len()).try_for_each(|i| check_vertex(i, vertex(points[i])))
    }

    /// Takes the f32 points of a cloud; none are left.
    pub(crate) fn take_points(&mut self) -> Vec<[f32; 3]> {
        match core::mem::replace(&mut self.vertices, Vertices::F32(Box::default())) {
            Vertices::F32(points) => points.into_vec(),
            Vertices::F64(_) => Vec::new(),
        }
    }

    /// Replaces the points of a cloud by points of a good survey.
    pub(crate) fn set_points(&mut self, points: Vec<[f32; 3]>, survey: &Survey) {
        self.vertices = Vertices::F32(points.into());
        self.note(survey);
    }

    fn note(&mut self, survey: &Survey) {
        self.least_exponent = survey.least_exponent;
        self.aabb = if self.all_in_use {
            survey.aabb
        } else {
            Aabb::from_points(self.in_use().map(|i| self.vertices.get(i)))
        };
    }

    /// Indices of the vertices that triangles use, in the order of the triangles, with repetitions;
    /// of all points of a cloud.
    pub(super) fn in_use(&self) -> impl Iterator<Item = usize> + use<'_> {
        let points = if self.is_cloud {
            self.vertices.len()
        } else {
            0
        };
        let corners = self.triangles.as_flattened().iter().map(|&i| i as usize);
        corners.chain(0..points)
    }
}

pub(super) fn check_vertex(vertex: usize, position: DVec3) -> Result<(), MeshError> {
    match (0..3).find(|&axis| position[axis].is_nan() || position[axis].abs() > COORDINATE_LIMIT) {
        None => Ok(()),
        Some(axis) if position[axis].is_finite() => Err(MeshError::TooLarge { vertex, axis }),
        Some(axis) => Err(MeshError::NotFinite { vertex, axis }),
    }
}

/// Compared by bits, because the sign of a zero is kept too.
pub(super) fn is_f32_exact(coordinate: f64) -> bool {
    f64::from(coordinate as f32).to_bits() == coordinate.to_bits()
}

/// True if triangles use every vertex.
pub(super) fn all_in_use(vertices: usize, triangles: &[[u32; 3]]) -> bool {
    let mut used = alloc::vec![false; vertices];
    triangles
        .as_flattened()
        .iter()
        .for_each(|&i| used[i as usize] = true);
    used.into_iter().all(|used| used)
}
