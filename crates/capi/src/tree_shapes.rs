//! Trees of point clouds and of shapes.

use crate::arrays::array;
use crate::distance::finite;
use crate::handle::get;
use crate::status::Fault;
use crate::tree::punctual_tree;
use crate::verbs::{calls, types};
use punctual::{DepthCamera, Tree};
use std::sync::Arc;

fn thick(tree: Tree, radius: f64) -> Result<Tree, Fault> {
    finite(radius, "radius")?;
    (tree.with_radius(radius)).map_err(|_| Fault::Number("radius", radius))
}

types! {
    /// A pinhole camera of depth images. Rows go from top to bottom, and so does `y`; `x` goes to
    /// the right and `z` forward.
    plain punctual_depth_camera {
        /// Pixels of a row.
        width: usize,
        /// Rows.
        height: usize,
        /// Focal lengths `fx`, `fy` in pixels; negative ones mirror.
        focal: [f64; 2],
        /// Where the axis of the camera passes, `cx`, `cy` in pixels: the centre of the first pixel
        /// is at 0, 0.
        center: [f64; 2],
        /// The length of one unit of depth: 0.001 for millimetres and points in metres, 1 if both
        /// are in one unit.
        scale: f64,
    }
}

impl From<Tree> for punctual_tree {
    fn from(tree: Tree) -> Self {
        Arc::new(tree).into()
    }
}

calls! {
    /// Builds the tree of a point cloud, of `3 * count` coordinates, or of equal balls of this
    /// radius. It is asked as that of a mesh is; where answers name triangles, they name points.
    /// Takes some .1 us a point.
    ///
    /// Fails with BAD_MESH if a coordinate is not finite; the text names the point as a vertex.
    /// Fails with BAD_ARGUMENT if the radius is negative or not finite.
    unsafe make punctual_tree_from_points_f32(points: *const f32, count: usize, radius: f64)
        -> tree: punctual_tree = {
            // SAFETY: the contract of the header for arrays.
            let points = unsafe { array(points.cast::<[f32; 3]>(), count, "points") }?;
            thick(Tree::from_points(points.iter().copied())?, radius)?
        };

    /// Like `punctual_tree_from_points_f32`.
    unsafe make punctual_tree_from_points_f64(points: *const f64, count: usize, radius: f64)
        -> tree: punctual_tree = {
            // SAFETY: the contract of the header for arrays.
            let points = unsafe { array(points.cast::<[f64; 3]>(), count, "points") }?;
            thick(Tree::from_points_f64(points.iter().copied())?, radius)?
        };

    /// Builds the cloud of a depth image of `count` depths, row by row: pixel `(i, j)` of depth `d`
    /// is the point `(d (i - cx) / fx, d (j - cy) / fy, d)`, times the scale, in the frame of the
    /// camera. Pixels without a depth, 0, negative, infinite or NaN, are passed over, so the ids of
    /// points are not those of pixels. `radius` is as of `punctual_tree_from_points_f32`.
    ///
    /// Fails with BAD_ARGUMENT if a number of the camera is not finite, a focal length is 0 or the
    /// scale not above 0, there are more or fewer depths than pixels, or for the radius.
    unsafe make punctual_tree_from_depth(
        camera: punctual_depth_camera, depths: *const f32, count: usize, radius: f64
    ) -> tree: punctual_tree = {
        // SAFETY: the contract of the header for arrays.
        let depths = unsafe { array(depths, count, "depths") }?;
        let mut points = Vec::new();
        points.try_reserve_exact(count).map_err(|_| Fault::OutOfMemory)?;
        let punctual_depth_camera { width, height, focal, center, scale } = camera;
        let camera = DepthCamera { size: [width, height], focal, center, scale };
        camera.points(depths, &mut points)?;
        thick(Tree::from_points(points)?, radius)?
    };

    /// A copy of a tree, thickened by a ball of this radius: all questions are about the points no
    /// farther than that from its triangles, or points. It is in place of an earlier radius.
    ///
    /// Fails with BAD_ARGUMENT if the radius is negative or not finite.
    make punctual_tree_with_radius(tree: Option<&punctual_tree>, radius: f64)
        -> thickened: punctual_tree = thick(Tree::clone(get(tree, "tree")?), radius)?;

    /// A ball around the origin: a point with a radius. As of all shapes, lengths are 1e-150 to
    /// 1e150; others fail with BAD_ARGUMENT, and the text names them.
    make punctual_tree_ball(radius: f64) -> tree: punctual_tree = Tree::ball(radius)?;

    /// All points no farther than `radius` from a segment of this length along z, around the
    /// origin. The length may be 0.
    make punctual_tree_capsule(radius: f64, length: f64) -> tree: punctual_tree =
        Tree::capsule(radius, length)?;

    /// A solid box around the origin with these lengths, which are at least twice the radius of its
    /// rounded edges. The radius may be 0.
    make punctual_tree_box(x: f64, y: f64, z: f64, radius: f64) -> tree: punctual_tree =
        Tree::rounded_cuboid([x, y, z], radius)?;

    /// A solid cylinder along z, around the origin: a prism of 128 sides, which holds the true one
    /// and is within 3.02e-4 of the radius of it.
    make punctual_tree_cylinder(radius: f64, length: f64) -> tree: punctual_tree =
        Tree::cylinder(radius, length)?;

    /// A solid cone along z: its base is at `-length / 2`, its tip at `length / 2`. A pyramid of
    /// 128 sides, as a cylinder is a prism.
    make punctual_tree_cone(radius: f64, length: f64) -> tree: punctual_tree =
        Tree::cone(radius, length)?;

    /// The convex hull of points, of `3 * count` coordinates: a solid; exact.
    ///
    /// Fails with BAD_MESH if a coordinate is not finite, or if the points lie in one plane.
    unsafe make punctual_tree_hull(points: *const f64, count: usize) -> tree: punctual_tree = {
        // SAFETY: the contract of the header for arrays.
        let points = unsafe { array(points.cast::<[f64; 3]>(), count, "points") }?;
        Tree::hull(points.iter().copied())?
    };

    /// The surface over a grid, which faces +z: `count` heights in `columns` columns, row by row.
    /// Height `i` is that of vertex `i`, at `x = step_x * (i % columns)`, `y = step_y * (i /
    /// columns)`.
    ///
    /// Fails with BAD_ARGUMENT unless there are two whole rows and columns or more, and with
    /// BAD_MESH if a height is not finite.
    unsafe make punctual_tree_height_field(
        heights: *const f64, count: usize, columns: usize, step_x: f64, step_y: f64
    ) -> tree: punctual_tree = {
        // SAFETY: the contract of the header for arrays.
        let heights = unsafe { array(heights, count, "heights") }?.iter().copied();
        Tree::height_field(heights, columns, [step_x, step_y])?
    };
}
