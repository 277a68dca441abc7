//! Bounding volume trees of meshes.

// A tree is built once, does not change while queries run, and is shared freely between threads.
//
// - `build`: a binned-SAH binary tree over the triangles, its collapse to nodes of up to eight
//   children (`wide`), and an orientation for each node.
// - `fit`: one pass bottom-up that gives every subtree its exact boxes, its alpha per axis and its
//   profile level by level. When vertices move, this pass is repeated.
// - `solid`: the neighbors of each triangle, and on request the components and open edges of a
//   solid, and the corners that may be the farthest along a direction.
// - `cloud`: the tree of a point cloud, over blocks of points.
// - `shapes`: shapes with a formula, made of meshes.
// - `file`: what cannot be recomputed, as bytes: the mesh, the order of the triangles and the
//   orientations.

mod build;
mod cloud;
mod file;
pub(crate) mod fit;
mod fork;
mod options;
mod shapes;
pub(crate) mod solid;
mod unit;
mod validate;
mod wide;

pub use cloud::window::PointWindow;
pub(crate) use cloud::{Leaf, Points, node};
pub use file::TreeFileError;
pub use options::{BuildOptions, Effort};
pub use shapes::{ROUND_BAND, ShapeError};
pub use solid::convex::Convex;
pub(crate) use solid::extremes::Extremes;
pub use solid::mass::MassProperties;
pub use solid::{Component, Solid, SolidError, Solidity};
pub(crate) use unit::{Triangle, Unit, power_of_two};
pub use validate::TreeFault;
pub(crate) use wide::{MAX_HEIGHT, Node, WIDTH, xyz};

use crate::engine::options::OptionError;
use crate::mesh::Mesh;
use alloc::boxed::Box;
use alloc::vec::Vec;
use build::collapse::Plan;
use build::orientation::Orientation;
use build::place::Placed;
use cloud::Blocks;
use core::sync::atomic::{AtomicUsize, Ordering};
use fit::profile::Profiles;
use fork::Pieces;
use glam::{DVec3, Mat3, Vec3};
use punctual_geom::tolerance::COORDINATE_LIMIT;
use solid::adjacency::Neighbors;

/// A mesh with its bounding volume tree.
#[derive(Clone, Debug)]
pub struct Tree {
    mesh: Mesh,
    unit: Unit,
    nodes: Box<[Node]>,
    /// Of a cloud: its leaves, which are not stored.
    blocks: Blocks,
    /// Empty for a cloud, and so are the corners and the neighbors.
    triangles: Box<[Triangle]>,
    /// The vertices of each triangle, in tree order.
    corners: Box<[[u32; 3]]>,
    /// Input id of each triangle, in tree order.
    ids: Box<[u32]>,
    profiles: Profiles,
    /// Neighbors of each triangle, in tree order.
    neighbors: Box<[Neighbors]>,
    /// Empty if they were not requested, and after a refit.
    extremes: Extremes,
    /// `None` if not requested.
    solid: Option<Solidity>,
    /// SAH cost after the build.
    built_cost: f32,
    /// The surface counts as thickened by a ball of this radius.
    radius: f64,
    identity: usize,
    lineage: usize,
}

/// Statistics of a tree. Index 0 of a list is the root's level.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct TreeStats {
    /// Number of triangles of the mesh; of a cloud, number of points.
    pub triangles: usize,
    /// Number of nodes, leaves included; of a cloud without its leaves, which are not stored.
    pub nodes: usize,
    /// Number of nodes whose children are triangles; of a cloud, of blocks of points.
    pub leaves: usize,
    /// Number of levels of nodes; 0 for an empty mesh.
    pub depth: usize,
    /// Number of nodes on each level.
    pub nodes_per_level: Vec<usize>,
    /// Mean alpha of the subtrees on each level, per axis of their boxes.
    pub alpha_per_level: Vec<Vec3>,
    /// Mean number of binary levels of the subtrees on each level: log2 of their triangles.
    pub levels_per_level: Vec<f32>,
    /// Bytes of the nodes.
    pub bytes_nodes: usize,
    /// Bytes of the triangles as the fast filter reads them, of their vertex indices, and of their
    /// ids.
    pub bytes_triangles: usize,
    /// Bytes of the mesh.
    pub bytes_mesh: usize,
    /// Bytes of profiles.
    pub bytes_profiles: usize,
    /// Bytes of the neighbors of triangles.
    pub bytes_neighbors: usize,
    /// Bytes of the corners that may be the farthest along a direction.
    pub bytes_extremes: usize,
    /// Bytes of the components and open edges of a solid, and of the corners of those components
    /// that are convex.
    pub bytes_solid: usize,
}

impl TreeStats {
    /// Sum of all bytes.
    pub fn bytes(&self) -> usize {
        [
            self.bytes_nodes,
            self.bytes_triangles,
            self.bytes_mesh,
            self.bytes_profiles,
            self.bytes_neighbors,
            self.bytes_extremes,
            self.bytes_solid,
        ]
        .into_iter()
        .sum()
    }
}

impl Tree {
    /// Builds the tree of `mesh` with the default options. `O(n log n)`.
    ///
    /// ```
    /// use punctual::{Tree, shapes};
    /// let tree = Tree::new(shapes::icosphere(3));
    /// assert_eq!(tree.root().unwrap().triangle_count(), 1280);
    /// ```
    pub fn new(mesh: Mesh) -> Self {
        Self::with_options(mesh, &BuildOptions::default())
    }

    /// Builds the tree of `mesh`. `O(n log n)`.
    pub fn with_options(mesh: Mesh, options: &BuildOptions) -> Self {
        if mesh.is_cloud() {
            return Self::of_cloud(mesh, options.effort);
        }
        let pieces = Pieces::new(options.threads, mesh.len());
        let unit = Unit::of(&mesh);
        let whole = if options.orientations {
            build::align::align(&unit, &mesh)
        } else {
            Orientation::IDENTITY
        };
        let binary = build::binary::build(&mesh, &unit, &whole, options.effort, pieces);
        let (mut plan, mut placed) = (Plan::default(), Placed::default());
        pieces.join(
            [1, 1],
            |_| plan = Plan::of(&binary, &whole),
            |pieces| placed = Placed::of(&mesh, unit, &binary.order, pieces),
        );
        let parts = plan.parts(pieces);
        if options.orientations && options.effort != Effort::Fast {
            build::assign::choose_orientations(&mut plan, &placed.triangles, &parts, pieces);
        }
        let mut nodes = plan.nodes;
        let mut profiles = Profiles::room(&mut nodes);
        fit::update::update(&mut nodes, &placed.triangles, &mut profiles, &parts, pieces);
        Self::of_nodes(
            mesh,
            unit,
            nodes,
            profiles,
            placed,
            binary.order.into(),
            options,
        )
    }

    /// Completes a tree from finished nodes.
    fn of_nodes(
        mesh: Mesh,
        unit: Unit,
        nodes: Box<[Node]>,
        profiles: Profiles,
        Placed { corners, triangles }: Placed,
        ids: Box<[u32]>,
        options: &BuildOptions,
    ) -> Self {
        let neighbors = solid::adjacency::neighbors(&corners, &nodes);
        let extremes = if options.extremes {
            Extremes::of(&mesh, &unit, &corners)
        } else {
            Extremes::default()
        };
        let (built_cost, identity) = (profiles.cost, next_identity());
        let lineage = identity;
        let mut tree = Self {
            mesh,
            unit,
            nodes,
            blocks: Blocks::default(),
            triangles,
            corners,
            ids,
            profiles,
            neighbors,
            extremes,
            solid: None,
            built_cost,
            radius: 0.0,
            identity,
            lineage,
        };
        tree.make_solid(options.solid);
        debug_assert_eq!(tree.validate(), Ok(()));
        tree
    }

    /// The mesh of the tree, with the vertices of the last refit.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Length of one unit, in the mesh's unit of length. Subtrees give their extents in units.
    pub fn unit_length(&self) -> f64 {
        self.unit.length()
    }

    /// [`unit_length`](Self::unit_length), or 0 for a mesh that is a single point, and the radius.
    pub(crate) fn size(&self) -> f64 {
        let core = if self.unit.is_point {
            0.0
        } else {
            self.unit.length()
        };
        core + self.radius
    }

    /// Thickens the surface by a ball: every question is about the points no farther than `radius`
    /// from the mesh, the *core*. [`Tree::ball`] and [`Tree::capsule`] are a point and a segment.
    /// The default is 0. Clones, refits and files keep it. `O(1)`.
    ///
    /// The radius is in the length unit of the mesh. It adds to the margins of queries and bodies.
    /// [`Query::intersection`](crate::Query::intersection) then is a question about distances: it
    /// may name another pair if it was stopped and resumed.
    ///
    /// ```
    /// use punctual::glam::DMat3;
    /// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
    /// let (ring, ball) = (Tree::new(shapes::torus(1.0, 0.25, 9)), Tree::ball(0.5)?);
    /// let thick = ring.with_radius(0.5)?;
    /// let pose = Pose::new(DMat3::IDENTITY, [3.25, 0.0, 0.0])?;
    /// let query = Query::distance(&thick, &ball, pose);
    /// let found = query.run(&mut Workspace::new(), Budget::unlimited()).value;
    /// assert!(found.low <= 1.0 && 1.0 <= found.high && found.high - found.low < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the radius is negative, NaN or more than 2^1000.
    pub fn with_radius(mut self, radius: f64) -> Result<Self, OptionError> {
        let mut fault = None;
        OptionError::note(&mut fault, "radius", radius, COORDINATE_LIMIT);
        match fault {
            Some(fault) => Err(fault),
            None => {
                if radius != self.radius {
                    (self.radius, self.identity) = (radius, next_identity());
                }
                Ok(self)
            }
        }
    }

    /// The radius of [`Tree::with_radius`].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The whole tree as a subtree; `None` for an empty mesh.
    pub fn root(&self) -> Option<Subtree<'_>> {
        self.nodes.first().map(|_| Subtree {
            tree: self,
            index: 0,
        })
    }

    /// The subtrees of all nodes: the root's first, each before those below it.
    pub fn subtrees(&self) -> impl Iterator<Item = Subtree<'_>> {
        (0..self.nodes.len()).map(|index| Subtree { tree: self, index })
    }

    /// Statistics. `O(nodes)`.
    pub fn stats(&self) -> TreeStats {
        let depth = self
            .nodes
            .first()
            .map_or(0, |root| usize::from(root.height));
        // The leaves of a cloud are not stored.
        let depth = depth - usize::from(self.is_cloud() && depth > 0);
        let mut nodes_per_level = alloc::vec![0; depth];
        let mut alpha_per_level = alloc::vec![Vec3::ZERO; depth];
        let mut levels_per_level = alloc::vec![0.0; depth];
        for node in &self.nodes {
            let level = usize::from(node.depth);
            nodes_per_level[level] += 1;
            alpha_per_level[level] += self.alpha(node);
            levels_per_level[level] += node.levels;
        }
        for (level, &count) in nodes_per_level.iter().enumerate() {
            alpha_per_level[level] /= count as f32;
            levels_per_level[level] /= count as f32;
        }
        TreeStats {
            triangles: self.mesh.len(),
            nodes: self.nodes.len(),
            leaves: if self.is_cloud() {
                self.blocks.count()
            } else {
                self.nodes.iter().filter(|node| node.is_leaf).count()
            },
            depth,
            nodes_per_level,
            alpha_per_level,
            levels_per_level,
            bytes_nodes: size_of_val(&*self.nodes),
            bytes_triangles: size_of_val(&*self.triangles)
                + size_of_val(&*self.corners)
                + size_of_val(&*self.ids),
            bytes_mesh: self.mesh.bytes(),
            bytes_profiles: size_of_val(&*self.profiles.levels),
            bytes_neighbors: size_of_val(&*self.neighbors),
            bytes_extremes: self.extremes.bytes(),
            bytes_solid: self.solid.as_ref().map_or(0, Solidity::bytes),
        }
    }

    /// The diminishing factors of a node, axis by axis.
    fn alpha(&self, node: &Node) -> Vec3 {
        let (_, triangles) = self.profiles.of(node);
        fit::alpha::alpha(triangles.half_extent, node.extent(), node.triangles)
    }

    /// Checks that every triangle is in one leaf and inside every box above it, and that every
    /// profile is consistent. `O(n depth)`.
    ///
    /// # Errors
    /// The first fault found. A tree that was built, refitted or loaded by this library has none.
    pub fn validate(&self) -> Result<(), TreeFault> {
        validate::validate(self)
    }

    pub(crate) fn unit(&self) -> &Unit {
        &self.unit
    }

    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    pub(crate) fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The corners of a triangle (in tree order), as [`Mesh::triangle`] returns them.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        // Written out, because `map` compiles to a call.
        let vertices = self.mesh.vertices();
        let Some(&[a, b, c]) = self.corners.get(triangle as usize) else {
            return [vertices.get(self.ids[triangle as usize] as usize); 3];
        };
        [
            vertices.get(a as usize),
            vertices.get(b as usize),
            vertices.get(c as usize),
        ]
    }

    /// The vertex indices of a triangle (in tree order).
    #[inline(always)]
    pub fn vertices_of(&self, triangle: u32) -> [u32; 3] {
        match self.corners.get(triangle as usize) {
            Some(corners) => *corners,
            // A point of a cloud.
            None => [self.ids[triangle as usize]; 3],
        }
    }

    /// Indices of two nodes: the parent of the leaf that contains a triangle (in tree order),
    /// then that leaf.
    pub(crate) fn nodes_above(&self, triangle: u32) -> [u32; 2] {
        let (mut parent, mut at) = (0, 0);
        while let Some(node) = self.nodes.get(at as usize).filter(|node| !node.is_leaf) {
            let mut children = node.first_child..node.first_child + u32::from(node.children);
            let has = |&child: &u32| match self.nodes.get(child as usize) {
                Some(node) => node.triangle_range().contains(&(triangle as usize)),
                None => self.block(child).contains(&triangle),
            };
            let Some(child) = children.find(has) else {
                break;
            };
            (parent, at) = (at, child);
        }
        [parent, at]
    }

    /// The corners that may be the farthest along a direction.
    pub(crate) fn extremes(&self) -> &Extremes {
        &self.extremes
    }

    /// True if the tree has extremes.
    pub(crate) fn has_extremes(&self) -> bool {
        !self.extremes.is_empty()
    }

    /// Input ids of the triangles, in tree order: leaf by leaf.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// A number that differs between any two trees built or refitted in this process, except
    /// clones.
    pub fn identity(&self) -> usize {
        self.identity
    }

    /// The identity from the build. Trees that share it have the same triangles in the same order.
    pub fn lineage(&self) -> usize {
        self.lineage
    }
}

/// A number that no tree of this process has had.
fn next_identity() -> usize {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// A node of a tree with everything below it.
#[derive(Clone, Copy, Debug)]
pub struct Subtree<'t> {
    tree: &'t Tree,
    index: usize,
}

impl<'t> Subtree<'t> {
    fn node(&self) -> &'t Node {
        &self.tree.nodes[self.index]
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> u32 {
        self.node().triangles
    }

    /// True if the children are single triangles.
    pub fn is_leaf(&self) -> bool {
        self.node().is_leaf
    }

    /// Half extents of the box along its own axes, in unit coordinates.
    pub fn half_extents(&self) -> Vec3 {
        self.node().extent()
    }

    /// Orientation of the box: the columns are its axes, in mesh coordinates.
    pub fn rotation(&self) -> Mat3 {
        self.node().rotation()
    }

    /// Diminishing factor per axis of the box, end to end: the factor by which boxes shrink per
    /// binary level, `(mean triangle extent / own extent)^(1 / log2(triangles))`. Within 0..=1.
    pub fn alpha(&self) -> Vec3 {
        self.tree.alpha(self.node())
    }

    /// The product of the three factors of [`Subtree::alpha`], within 0..=1: the factor by which
    /// volumes of boxes shrink per binary level. Each node stores its logarithm, measured by the
    /// last build or refit, within `2e-4` divided by the levels.
    pub fn alpha_product(&self) -> f32 {
        libm::exp2f(self.node().log_alpha)
    }

    /// Expected BV tests of this subtree against a copy of itself, averaged over all overlapping
    /// placements.
    pub fn self_cost(&self) -> f32 {
        self.node().self_cost
    }

    /// Number of levels of boxes below this node. It is 1 for a leaf: the level of its
    /// triangles.
    pub fn height(&self) -> usize {
        usize::from(self.node().height)
    }

    /// The nodes directly below; none for a leaf.
    pub fn children(&self) -> impl Iterator<Item = Subtree<'t>> + use<'t> {
        let tree = self.tree;
        let (stored, mut nodes) = (tree.nodes.len(), self.node().nodes_below());
        nodes.end = nodes.end.min(stored);
        nodes.map(move |index| Subtree { tree, index })
    }

    /// Ids of the triangles in the input mesh.
    pub fn triangles(&self) -> impl Iterator<Item = u32> + use<'t> {
        self.tree.ids[self.node().triangle_range()].iter().copied()
    }
}
