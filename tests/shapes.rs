//! The generated shapes: watertight, of the documented size and count, and good meshes for any argument.

use punctual::glam::{DVec2, DVec3, Vec3};
use punctual::{Mesh, shapes::*};
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

fn vertices(mesh: &Mesh) -> impl Iterator<Item = DVec3> {
    (0..mesh.vertex_count()).map(|i| mesh.vertex(i))
}

fn closed_shapes(level: u32) -> [(Mesh, usize); 6] {
    let n = level as usize;
    let around = (4 * n).max(3);
    let along = (32 * n).max(40);
    [
        (icosphere(level), 20 << (2 * n)),
        (
            cuboid(Vec3::new(0.5, 1e-6, 1e6), level),
            12 * n.max(1).pow(2),
        ),
        (
            torus(1.0, 0.25, 4 * level),
            2 * around * (around / 2).max(3),
        ),
        (
            torus_knot(2, 3, 0.1, 32 * level),
            2 * along * (along / 8).max(3),
        ),
        (gear(12, level), 32 * 12 * n.max(1).pow(2)),
        (gear(level, 2), 32 * n.max(3) * 4),
    ]
}

fn assert_no_degenerate_triangle(mesh: &Mesh) {
    for i in 0..mesh.len() {
        let [a, b, c] = mesh.triangle(i);
        assert!((b - a).cross(c - a).length() > 0.0, "triangle {i}");
    }
}

fn volume(mesh: &Mesh) -> f64 {
    let corners = (0..mesh.len()).map(|i| mesh.triangle(i));
    corners.map(|[a, b, c]| a.dot(b.cross(c))).sum::<f64>() / 6.0
}

fn assert_close(found: f64, exact: f64, relative: f64) {
    assert!((found / exact - 1.0).abs() < relative, "{found} {exact}");
}

#[test]
fn closed_shapes_are_watertight_and_have_the_documented_count() {
    for (mesh, count) in (0..6).flat_map(closed_shapes) {
        assert_eq!(mesh.len(), count);
        let corners = mesh.triangles().iter();
        let edges: Vec<_> = corners
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .collect();
        let once: BTreeSet<_> = edges.iter().copied().collect();
        assert_eq!(once.len(), edges.len());
        assert!(edges.iter().all(|&(a, b)| once.contains(&(b, a))));
        let used: BTreeSet<_> = mesh.triangles().as_flattened().iter().collect();
        assert_eq!(used.len(), mesh.vertex_count());
        let positions =
            (0..mesh.vertex_count()).map(|i| mesh.vertex(i).to_array().map(f64::to_bits));
        assert_eq!(
            positions.collect::<BTreeSet<_>>().len(),
            mesh.vertex_count()
        );
        assert_no_degenerate_triangle(&mesh);
        assert!(volume(&mesh) > 0.0);
    }
}

#[test]
fn volumes_match_the_formulas() {
    assert_close(volume(&icosphere(5)), 4.0 / 3.0 * PI, 2e-3);
    assert_close(volume(&cuboid(Vec3::new(0.5, 2.0, 3.0), 7)), 24.0, 1e-6);
    assert_close(
        volume(&torus(2.0, 0.5, 200)),
        2.0 * PI * PI * 2.0 * 0.25,
        2e-3,
    );
    let pitch = TAU / 12.0;
    let root: f64 = 1.0 - 2.25 * 2.0 / 14.0;
    let land = (0.3 * pitch).sin() * (root * root + 1.0);
    let flanks = (0.2 * pitch).sin() * 2.0 * root;
    let gear_area = 12.0 * 0.5 * (land + flanks) - PI * 0.09;
    assert_close(volume(&gear(12, 8)), 0.3 * gear_area, 1e-3);
}

#[test]
fn the_knot_is_a_tube_of_even_radius_with_outer_radius_about_one() {
    let (p, q, n) = (2.0, 3.0, 1000);
    // Pappus: the volume of a tube is its section times the length of its centre line.
    let speed =
        |i: u32| (p * (2.0 + (3.0 * f64::from(i) * TAU / f64::from(n)).cos())).hypot(q) / 3.0;
    let length = (0..n).map(speed).sum::<f64>() * TAU / f64::from(n);
    let knot = torus_knot(2, 3, 0.1, n);
    assert_close(volume(&knot), PI * 0.01 * length, 2e-3);
    assert_close(knot.aabb().max.x, 1.1, 1e-3);
}

#[test]
fn a_common_divisor_gives_the_same_knot() {
    assert_eq!(torus_knot(4, 6, 0.1, 64), torus_knot(2, 3, 0.1, 64));
    assert_eq!(torus_knot(3, 3, 0.1, 64), torus_knot(1, 1, 0.1, 64));
}

#[test]
fn round_shapes_have_their_radii() {
    let sphere = icosphere(3);
    let on_sphere = |i| (sphere.vertex(i).length() - 1.0).abs() < 1e-7;
    assert!((0..sphere.vertex_count()).all(on_sphere));
    let gear = gear(9, 3);
    let radii = (0..gear.vertex_count()).map(|i| gear.vertex(i).truncate().length());
    let (min, max) = radii.fold((2.0f64, 0.0f64), |(a, b), r| (a.min(r), b.max(r)));
    assert!((min - 0.3).abs() < 1e-6 && (max - 1.0).abs() < 1e-6);
    assert!((gear.aabb().extents().z - 0.3).abs() < 1e-6);
}

#[test]
fn height_fields_face_up_and_differ_by_seed() {
    let field = height_field(9, 1);
    assert_eq!((field.len(), field.vertex_count()), (162, 100));
    for i in 0..field.len() {
        let [a, b, c] = field.triangle(i);
        assert!((b - a).cross(c - a).z > 0.0);
    }
    let aabb = field.aabb();
    assert_eq!(
        (aabb.min.truncate(), aabb.max.truncate()),
        (-DVec2::ONE, DVec2::ONE)
    );
    assert!(aabb.min.z >= -0.5 && aabb.max.z <= 0.5 && aabb.extents().z > 0.05);
    assert_ne!(field, height_field(9, 2));
}

#[test]
fn the_same_arguments_give_the_same_mesh() {
    for ((first, _), (second, _)) in closed_shapes(3).iter().zip(&closed_shapes(3)) {
        assert_eq!(first, second);
    }
    assert_eq!(height_field(5, 7), height_field(5, 7));
}

#[test]
fn no_argument_panics_or_makes_a_bad_mesh() {
    for odd in [
        f32::NAN,
        f32::INFINITY,
        -1.0,
        0.0,
        f32::MAX,
        f32::from_bits(1),
    ] {
        for mesh in [
            cuboid(Vec3::splat(odd), 0),
            torus(odd, 1.0, 0),
            torus(1.0, odd, 0),
            torus_knot(0, u32::MAX, odd, 0),
            gear(0, 0),
            height_field(0, u64::MAX),
        ] {
            assert!(Mesh::from_f64(vertices(&mesh), mesh.triangles().iter().copied()).is_ok());
            assert_no_degenerate_triangle(&mesh);
        }
    }
}

#[test]
fn extreme_but_accepted_shapes_have_no_degenerate_triangle() {
    for mesh in [
        torus(1.0, 0.0, 700),
        torus(1.0, 2.0, 700),
        torus_knot(64, 63, 0.3, 0),
        gear(4096, 2),
    ] {
        assert_no_degenerate_triangle(&mesh);
    }
}
