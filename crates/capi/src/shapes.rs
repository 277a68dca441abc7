//! Generated meshes.

use crate::mesh::punctual_mesh;
use crate::verbs::calls;
use punctual::glam::Vec3;
use punctual::shapes;

calls! {
    /// A sphere of radius 1 around the origin, `20 * 4^subdivisions` triangles; at most 12
    /// subdivisions. As for all shapes, arguments that are out of range are moved into it, and the
    /// same arguments give the same mesh.
    make punctual_shape_icosphere(subdivisions: u32) -> mesh: punctual_mesh =
        shapes::icosphere(subdivisions);

    /// A box around the origin of these half extents, 1e-6 to 1e6; each face is a grid of `cells`
    /// by `cells` squares, 1 to 8192: `12 * cells^2` triangles.
    make punctual_shape_cuboid(half_x: f32, half_y: f32, half_z: f32, cells: u32)
        -> mesh: punctual_mesh = shapes::cuboid(Vec3::new(half_x, half_y, half_z), cells);

    /// A torus around the z axis: a tube of radius `minor`, 0.01 to 0.99 times `major`, along a
    /// circle of radius `major`, 1e-6 to 1e6; `2 * resolution * max(3, resolution / 2)` triangles,
    /// `resolution` 3 to 16384.
    make punctual_shape_torus(major: f32, minor: f32, resolution: u32) -> mesh: punctual_mesh =
        shapes::torus(major, minor, resolution);

    /// A tube of radius `tube`, 0.01 to 0.3, along a knot that winds `p` times around the z axis
    /// while it winds `q` times around the tube of a torus of radii 2/3 and 1/3; `2 * resolution *
    /// max(3, resolution / 8)` triangles.
    make punctual_shape_torus_knot(
        p: u32, q: u32, tube: f32, resolution: u32
    ) -> mesh: punctual_mesh = shapes::torus_knot(p, q, tube, resolution);

    /// A spur gear of outer radius 1 and thickness 0.3 around the z axis, `32 * teeth *
    /// resolution^2` triangles; `teeth` is 3 to 4096, `resolution` 1 to 64.
    make punctual_shape_gear(teeth: u32, resolution: u32) -> mesh: punctual_mesh =
        shapes::gear(teeth, resolution);

    /// Hills over the square from -1 to 1 in x and y, an open surface of `2 * resolution^2`
    /// triangles. Each seed has its own.
    make punctual_shape_height_field(resolution: u32, seed: u64) -> mesh: punctual_mesh =
        shapes::height_field(resolution, seed);
}
