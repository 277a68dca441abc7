//! Trees.

use crate::arrays::{array, list};
use crate::handle::{change, get};
use crate::mesh::punctual_mesh;
use crate::pose::punctual_point;
use crate::sized::{place, read};
use crate::status::{Fault, given, value_of};
use crate::verbs::{calls, handles, inits, lists, types};
use core::mem::MaybeUninit;
use punctual::tree::{Effort, Solid};
use punctual::{BuildOptions, Tree};
use std::sync::Arc;

handles! {
    /// The bounding volume tree of one mesh. Any number of threads may read it and query it, as
    /// long as none refits or frees it.
    punctual_tree(Arc<Tree>);

    /// Frees a tree; null is fine. Scenes keep what they share.
    punctual_tree_free(tree);
}

types! {
    /// How much time a build may take to make queries faster.
    enum punctual_effort {
        /// For meshes that change or are asked about only a few times.
        Fast = 0,
        /// The default.
        Normal = 1,
    }

    /// How a tree is built. Begin with `punctual_build_options_default()`.
    asked punctual_build_options(effort) {
        /// A `punctual_effort`.
        effort: u32 = punctual_effort::Normal as u32,
        /// Whether boxes may be turned to where they are smallest: 0 or not 0.
        frames: u32 = BuildOptions::default().orientations.into(),
        /// Whether to keep the corners that may be the farthest along a direction: 0 or not 0. In a
        /// scene, convex bodies that are close are then told apart by a plane, without a search,
        /// until a refit. Takes a third to the whole of the build's time more.
        extremes: u32 = BuildOptions::default().extremes.into(),
        /// Most threads to build in; more than one only for large meshes. The tree is the same, to
        /// the bit.
        threads: usize = BuildOptions::default().threads,
        /// A `punctual_solid`: what the mesh bounds.
        solid: usize = punctual_solid::No as usize,
    }

    /// What a mesh bounds. Rooms, terrain and shells bound nothing.
    enum punctual_solid {
        /// A surface without an inside; the default.
        No = 0,
        /// A solid, oriented as its triangles are.
        Keep = 1,
        /// A solid of which parts that are inside out are reversed: the second and third corner of
        /// their triangles change places.
        Flip = 2,
    }

    /// Numbers that describe a tree.
    told punctual_tree_facts(bytes) {
        /// How much looser the boxes have become since the build, by refits: the SAH cost now over
        /// that after the build, no unit. Queries take about its square root as long as in a new tree.
        degradation: f32,
        /// Triangles of the mesh.
        triangles: usize,
        /// Nodes, leaves included.
        nodes: usize,
        /// Nodes whose children are triangles.
        leaves: usize,
        /// Levels of nodes; 0 for an empty mesh.
        depth: usize,
        /// Memory on the heap, the mesh included.
        bytes: usize,
        /// A length that goes with the size of the mesh; default tolerances are stated in it.
        unit_length: f64,
    }

    /// One level of a tree.
    row punctual_tree_level(nodes) {
        /// Nodes on it.
        nodes: u32,
        /// Mean alpha of their subtrees per axis of their frames: the factor by which boxes shrink
        /// on a binary level, 0 to 1.
        alpha: [f32; 3],
        /// Mean number of binary levels of their subtrees: log2 of their triangles.
        levels: f32,
    }
}

inits! {
    /// Boxes that may be turned, normal effort, one thread.
    punctual_build_options_init(options: punctual_build_options) {}
}

calls! {
    /// Builds the tree of a mesh, of which it keeps a copy. `options` may be null: the defaults.
    /// Takes `n log n` time.
    ///
    /// Fails with BAD_ARGUMENT if `options->effort` or `options->solid` is unknown.
    unsafe make punctual_tree_new(
        mesh: Option<&punctual_mesh>, options: *const punctual_build_options
    ) -> tree: punctual_tree = {
        let punctual_mesh(mesh) = given(mesh, "mesh")?;
        let options = match options.is_null() {
            true => punctual_build_options::default(),
            // SAFETY: the contract of the header for structs.
            false => unsafe { read(options, "options") }?,
        };
        Tree::with_options(mesh.clone(), &build_options(&options)?)
    };
}

fn build_options(options: &punctual_build_options) -> Result<BuildOptions, Fault> {
    let effort = value_of(
        options.effort,
        "options->effort",
        &[Effort::Fast, Effort::Normal],
    )?;
    let mut chosen = BuildOptions::default();
    (chosen.effort, chosen.orientations, chosen.threads) =
        (effort, options.frames != 0, options.threads);
    let solid = value_of(
        u32::try_from(options.solid).unwrap_or(u32::MAX),
        "options->solid",
        &[Solid::No, Solid::Keep, Solid::Flip],
    )?;
    Ok(chosen.extremes(options.extremes != 0).solid(solid))
}

types! {
    /// Mass properties of a solid of density 1.
    plain punctual_mass_properties {
        /// In the mesh's unit of length cubed.
        volume: f64,
        /// The centre of mass, in the coordinates of the mesh.
        center: punctual_point,
        /// The inertia tensor about the centre of mass, for the axes of the mesh: row by row; it is
        /// symmetric.
        inertia: [f64; 9],
    }
}

calls! {
    /// The tree as bytes for `punctual_tree_from_bytes`, on any machine: as many as `capacity`
    /// allows are written to `bytes`, and how many there are to `count`. They are the caller's. For
    /// a closed mesh of floats they are about 30 a triangle. Takes linear time and allocates; with
    /// a capacity of 0, where `bytes` may be null, it only counts, and allocates nothing.
    unsafe fn punctual_tree_to_bytes(
        tree: Option<&punctual_tree>, bytes: *mut u8, capacity: usize,
        count: Option<&mut MaybeUninit<usize>>
    ) {
        let (tree, count) = (get(tree, "tree")?, given(count, "count")?);
        if capacity == 0 {
            count.write(tree.bytes_len());
            return Ok(());
        }
        // SAFETY: the contract of the header for arrays.
        unsafe { list(bytes, capacity, "bytes", count, tree.to_bytes().into_iter()) }
    }

    /// The tree that `punctual_tree_to_bytes` was called on, of which the bytes are not needed any
    /// more: its queries do the same, to the bit. Takes a part of the time of a build.
    ///
    /// Fails with BAD_FILE if the bytes are no tree, are of another version of the format, or were
    /// changed, cut or extended. Whatever they are, it takes no memory out of proportion to their
    /// number, and the tree that it makes gives true answers about the mesh that they hold.
    unsafe make punctual_tree_from_bytes(bytes: *const u8, count: usize) -> tree: punctual_tree = {
        // SAFETY: the contract of the header for arrays.
        Tree::from_bytes(unsafe { array(bytes, count, "bytes") }?)?
    };
}

calls! {
    /// Moves the vertices of the mesh, which keeps its triangles: all of them, `3 * vertex_count`
    /// coordinates in the order of the mesh. Queries stay exact. Takes linear time, a small part of
    /// a build, and allocates nothing, unless a scene shares the tree: the scene then keeps the old
    /// one (see `punctual_scene_refit_f32`). Stopped queries cannot be resumed afterwards.
    ///
    /// Fails with BAD_MESH if their number is another or a coordinate in use is not finite; the
    /// tree is unchanged then.
    unsafe fn punctual_tree_refit_f32(
        tree: Option<&mut punctual_tree>, vertices: *const f32, vertex_count: usize
    ) {
        // SAFETY: the contract of the header for arrays.
        let vertices = unsafe { array(vertices.cast::<[f32; 3]>(), vertex_count, "vertices") }?;
        change(tree, "tree", |tree| Ok(Arc::make_mut(tree).refit(vertices)?))
    }

    /// Like `punctual_tree_refit_f32`. Allocates only once, if the mesh was stored as float and
    /// needs double now.
    unsafe fn punctual_tree_refit_f64(
        tree: Option<&mut punctual_tree>, vertices: *const f64, vertex_count: usize
    ) {
        // SAFETY: the contract of the header for arrays.
        let vertices = unsafe { array(vertices.cast::<[f64; 3]>(), vertex_count, "vertices") }?;
        change(tree, "tree", |tree| Ok(Arc::make_mut(tree).refit_f64(vertices)?))
    }

    /// A copy of the mesh of a tree, as it is now.
    make punctual_tree_mesh(tree: Option<&punctual_tree>) -> mesh: punctual_mesh =
        get(tree, "tree")?.mesh().clone();

    /// Describes a tree. Takes linear time and allocates.
    unsafe fn punctual_tree_describe(
        tree: Option<&punctual_tree>, facts: *mut punctual_tree_facts
    ) {
        let tree = get(tree, "tree")?;
        // SAFETY: the contract of the header for structs.
        let facts = unsafe { place(facts, "facts") }?;
        let stats = tree.stats();
        facts.write(punctual_tree_facts {
            size: punctual_tree_facts::SIZE,
            triangles: stats.triangles,
            nodes: stats.nodes,
            leaves: stats.leaves,
            depth: stats.depth,
            bytes: stats.bytes(),
            unit_length: tree.unit_length(),
            degradation: tree.degradation(),
        });
        Ok(())
    }

    /// Computes the mass properties of a closed solid (`punctual_build_options.solid`). Takes
    /// linear time and allocates.
    ///
    /// Fails with BAD_MESH if the tree is no solid, has open edges, is inside out, or has no
    /// volume.
    fn punctual_tree_mass_properties(
        tree: Option<&punctual_tree>, mass: Option<&mut MaybeUninit<punctual_mass_properties>>
    ) {
        let tree = get(tree, "tree")?;
        let found = tree.mass_properties()?;
        given(mass, "mass")?.write(punctual_mass_properties {
            volume: found.volume,
            center: found.center.into(),
            inertia: found.inertia.to_cols_array(),
        });
        Ok(())
    }

    /// Checks that every triangle is in one leaf and inside every box above it. Takes linear time
    /// and allocates.
    ///
    /// Fails with BAD_TREE if not, which no tree that was built here does.
    fn punctual_tree_validate(tree: Option<&punctual_tree>) {
        Ok(get(tree, "tree")?.validate()?)
    }
}

lists! {
    /// Describes the levels of a tree, the root's first. Takes linear time and allocates.
    rows punctual_tree_levels(tree: punctual_tree) -> levels: punctual_tree_level, levels_size =
        {
            let stats = tree.stats();
            (0..stats.depth).map(move |level| punctual_tree_level {
                nodes: stats.nodes_per_level[level] as u32,
                alpha: stats.alpha_per_level[level].to_array(),
                levels: stats.levels_per_level[level],
            })
        };

    /// The alphas of all nodes of a tree, as stored at build and refit: the product over the three
    /// axes, 0 to 1. The root's first, each node before those below it.
    list punctual_tree_node_alphas(tree: punctual_tree) -> alphas: f32 =
        tree.subtrees().map(|subtree| subtree.alpha_product());
}
