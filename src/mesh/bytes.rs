//! A mesh as little-endian bytes, for the file format of a tree.

use super::vertices::Vertices;
use super::{Mesh, MeshError};
use alloc::vec::Vec;

/// Bytes of a triangle's three indices.
pub(crate) const TRIANGLE_BYTES: usize = 12;

impl Mesh {
    /// Appends the exact vertices, 4 or 8 bytes per coordinate, then the indices of the triangles.
    pub(crate) fn write(&self, bytes: &mut Vec<u8>) {
        match &self.vertices {
            Vertices::F32(v) => bytes.extend(v.as_flattened().iter().flat_map(|x| x.to_le_bytes())),
            Vertices::F64(v) => bytes.extend(v.as_flattened().iter().flat_map(|x| x.to_le_bytes())),
        }
        let indices = self.triangles.as_flattened().iter();
        bytes.extend(indices.flat_map(|i| i.to_le_bytes()));
    }

    /// Reads a mesh from bytes of [`write`](Self::write): vertices with 8 (`is_f64`) or 4 bytes per
    /// coordinate, and triangles; `None` for a cloud.
    pub(crate) fn read(
        vertices: &[u8],
        is_f64: bool,
        triangles: Option<&[u8]>,
    ) -> Result<Self, MeshError> {
        let vertices = if is_f64 {
            Vertices::F64(triples(vertices, f64::from_le_bytes).collect())
        } else {
            Vertices::F32(triples(vertices, f32::from_le_bytes).collect())
        };
        match triangles {
            Some(triangles) => {
                Self::checked(vertices, triples(triangles, u32::from_le_bytes).collect())
            }
            None => Self::cloud(vertices),
        }
    }
}

/// Splits bytes into triples of numbers of `N` bytes each.
fn triples<const N: usize, T>(
    bytes: &[u8],
    number: impl Fn([u8; N]) -> T,
) -> impl Iterator<Item = [T; 3]> {
    bytes
        .as_chunks::<N>()
        .0
        .as_chunks::<3>()
        .0
        .iter()
        .map(move |&three| three.map(&number))
}
