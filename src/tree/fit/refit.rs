//! Refits a tree to new vertices of the same triangles: nodes and orientations stay; boxes and
//! profiles are recomputed.

use super::update::update;
use crate::mesh::MeshError;
use crate::tree::fork::Pieces;
use crate::tree::solid::Solid;
use crate::tree::solid::extremes::Extremes;
use crate::tree::{Tree, Unit, next_identity};

impl Tree {
    /// Moves the vertices of the mesh, which keeps its triangles: for meshes that deform.
    ///
    /// Queries stay exact for any motion. Only their speed depends on how well the old tree suits
    /// the new shape; see [`degradation`](Self::degradation). `vertices` are all vertices of the
    /// mesh, in its order and length unit.
    ///
    /// Takes `O(n)` time, a small part of a build, and allocates nothing. For a solid, its
    /// components, open edges and volumes are computed anew; that allocates, and triangles are not
    /// reversed. Queries that were stopped before cannot be resumed.
    ///
    /// # Errors
    /// [`MeshError::VertexCount`] if the number of vertices differs from the mesh's. Otherwise the
    /// errors of [`crate::Mesh::new`], for the first vertex in use that is not finite. The tree is
    /// then unchanged.
    ///
    /// ```
    /// use punctual::{Tree, shapes};
    /// let mut tree = Tree::new(shapes::icosphere(3));
    /// let moved: Vec<[f32; 3]> = (0..tree.mesh().vertex_count())
    ///     .map(|i| (tree.mesh().vertex(i).as_vec3() * 2.0).into())
    ///     .collect();
    /// tree.refit(&moved)?;
    /// assert_eq!(tree.degradation(), 1.0);
    /// # Ok::<(), punctual::MeshError>(())
    /// ```
    pub fn refit<V: Copy + Into<[f32; 3]>>(&mut self, vertices: &[V]) -> Result<(), MeshError> {
        self.mesh.set_vertices(vertices)?;
        self.follow_mesh();
        Ok(())
    }

    /// [`refit`](Self::refit) with f64 vertices. Allocates only once: if the mesh was stored as f32
    /// and the new vertices need f64.
    ///
    /// # Errors
    /// As [`refit`](Self::refit), and [`MeshError::TooLarge`] as for [`crate::Mesh::from_f64`].
    pub fn refit_f64<V: Copy + Into<[f64; 3]>>(&mut self, vertices: &[V]) -> Result<(), MeshError> {
        self.mesh.set_vertices_f64(vertices)?;
        self.follow_mesh();
        Ok(())
    }

    /// Factor by which the boxes have become looser since the build: the SAH cost divided by that
    /// after the build.
    ///
    /// The SAH cost is the sum of the surface areas of all boxes divided by that of the root, which
    /// is the expected number of boxes that a random query visits. The factor is 1 after a build,
    /// and stays 1 after uniform scalings and after rigid motions along the axes. `O(1)`.
    ///
    /// A query takes about its square root as long as in a new tree: within 1.5 times of that were
    /// 67 % (any), 87 % (all pairs) and 82 % (distances) of 168 deformations of eight meshes
    /// (`docs/performance.md`). It says too much where neighboring vertices move apart at random, so
    /// that no tree has small boxes. A build takes as long as seven to ten refits. It pays once the
    /// queries since the last one have lost as much: `(1 - 1 / degradation.sqrt()) * their time`.
    pub fn degradation(&self) -> f32 {
        if self.built_cost > 0.0 {
            self.profiles.cost / self.built_cost
        } else {
            1.0
        }
    }

    pub(crate) fn follow_mesh(&mut self) {
        self.unit = Unit::of(&self.mesh);
        if self.is_cloud() {
            self.fit_cloud(None);
        } else {
            self.unit
                .place(&self.mesh, &self.corners, &mut self.triangles);
            update(
                &mut self.nodes,
                &self.triangles,
                &mut self.profiles,
                &[],
                Pieces::ONE,
            );
        }
        self.extremes = Extremes::default();
        if self.solid.is_some() {
            self.make_solid(Solid::Keep);
        }
        // A query stopped with the old boxes must not continue with the new ones.
        self.identity = next_identity();
        debug_assert_eq!(self.validate(), Ok(()));
    }
}
