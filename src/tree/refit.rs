//! New vertices for the same triangles: nodes and orientations stay; boxes and profiles are computed anew.

use super::extremes::Extremes;
use super::fork::Pieces;
use super::update::update;
use super::{Tree, Unit, next_identity};
use crate::mesh::MeshError;

impl Tree {
    /// Moves the vertices of the mesh, which keeps its triangles: for meshes that deform.
    ///
    /// Queries stay exact whatever the motion; only their speed depends on how well the old tree suits the new shape, see
    /// [`degradation`](Self::degradation). `vertices` are all vertices of the mesh, in its order and length unit. Takes
    /// `O(n)` time, a small part of a build, and allocates nothing. Results of queries that were stopped
    /// cannot be resumed afterwards.
    ///
    /// # Errors
    /// [`MeshError::VertexCount`] for another number of vertices than the mesh has, and as [`crate::Mesh::new`] for the
    /// first vertex in use that is not finite. The tree is unchanged then.
    ///
    /// ```
    /// use punctual::{Tree, shapes};
    /// let mut tree = Tree::new(shapes::icosphere(3));
    /// let moved: Vec<[f32; 3]> =
    ///     (0..tree.mesh().vertex_count()).map(|i| (tree.mesh().vertex(i).as_vec3() * 2.0).into()).collect();
    /// tree.refit(&moved)?;
    /// assert_eq!(tree.degradation(), 1.0);
    /// # Ok::<(), punctual::MeshError>(())
    /// ```
    pub fn refit<V: Copy + Into<[f32; 3]>>(&mut self, vertices: &[V]) -> Result<(), MeshError> {
        self.mesh.set_vertices(vertices)?;
        self.follow_mesh();
        Ok(())
    }

    /// [`refit`](Self::refit) with f64 vertices. Allocates only once, if the mesh was stored as f32 and the new vertices
    /// need f64.
    ///
    /// # Errors
    /// As [`refit`](Self::refit), and [`MeshError::TooLarge`] as for [`crate::Mesh::from_f64`].
    pub fn refit_f64<V: Copy + Into<[f64; 3]>>(&mut self, vertices: &[V]) -> Result<(), MeshError> {
        self.mesh.set_vertices_f64(vertices)?;
        self.follow_mesh();
        Ok(())
    }

    /// How much looser the boxes have become since the tree was built: the SAH cost now over that after the build.
    ///
    /// The SAH cost is the summed surface area of all boxes over that of the root, what a random query expects to visit. 1
    /// after a build and after rigid motions along the axes and scalings. In `O(1)`.
    pub fn degradation(&self) -> f32 {
        if self.built_cost > 0.0 {
            self.profiles.cost / self.built_cost
        } else {
            1.0
        }
    }

    fn follow_mesh(&mut self) {
        self.unit = Unit::of(&self.mesh);
        self.unit
            .place(&self.mesh, &self.corners, &mut self.triangles);
        update(
            &mut self.nodes,
            &self.triangles,
            &mut self.profiles,
            &[],
            Pieces::ONE,
        );
        self.extremes = Extremes::default();
        // A stopped query of the old boxes may not go on among the new ones.
        self.identity = next_identity();
        debug_assert_eq!(self.validate(), Ok(()));
    }
}
