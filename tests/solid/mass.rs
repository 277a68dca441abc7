//! Volume, centre of mass and inertia of solids.

use crate::meshes::{union, with_triangles};
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::tree::{MassProperties, Solid, SolidError};
use punctual::{BuildOptions, Mesh, Tree, shapes};
use std::f64::consts::PI;

fn mass(mesh: &Mesh) -> Result<MassProperties, SolidError> {
    let options = BuildOptions::default().solid(Solid::Keep);
    Tree::with_options(mesh.clone(), &options).mass_properties()
}

fn moved(mesh: &Mesh, to: impl Fn(DVec3) -> DVec3) -> Mesh {
    let vertices = (0..mesh.vertex_count()).map(|i| to(mesh.vertex(i)));
    Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap()
}

/// Surface integrals by the divergence theorem, with a rule of four points on each triangle that is
/// exact for cubics.
fn by_surface(mesh: &Mesh, about: DVec3) -> MassProperties {
    let (mut volume, mut first, mut squares, mut products) =
        (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for corners in (0..mesh.len()).map(|i| mesh.triangle(i)) {
        let [p, q, r] = corners.map(|corner| corner - about);
        let area = (q - p).cross(r - p) / 2.0;
        let at = |u: f64, v: f64, w: f64| u * p + v * q + w * r;
        let rule = [
            (-27.0 / 48.0, at(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0)),
            (25.0 / 48.0, at(0.6, 0.2, 0.2)),
            (25.0 / 48.0, at(0.2, 0.6, 0.2)),
            (25.0 / 48.0, at(0.2, 0.2, 0.6)),
        ];
        for (weight, x) in rule {
            let flux = weight * area;
            volume += x.z * flux.z;
            first += x * x * flux / 2.0;
            squares += x * x * x * flux / 3.0;
            // xy, yz, zx.
            products += x * x * DVec3::new(x.y, x.z, x.x) * flux / 2.0;
        }
    }
    let center = first / volume;
    let d = |a: f64, b: f64| a * b * volume;
    let [xx, yy, zz] = [0, 1, 2].map(|i| squares[i] - d(center[i], center[i]));
    let xy = products.x - d(center.x, center.y);
    let yz = products.y - d(center.y, center.z);
    let zx = products.z - d(center.z, center.x);
    let inertia =
        DMat3::from_cols_array(&[yy + zz, -xy, -zx, -xy, zz + xx, -yz, -zx, -yz, xx + yy]);
    let mut found = of(volume, about + center, DVec3::ZERO);
    found.inertia = inertia;
    found
}

/// Largest difference, relative to the size of each.
fn difference(x: &MassProperties, y: &MassProperties, size: f64) -> f64 {
    let volume = (x.volume / y.volume - 1.0).abs();
    let center = x.center.distance(y.center) / size;
    let part = x.inertia - y.inertia;
    let largest = |m: &DMat3| {
        m.to_cols_array()
            .map(f64::abs)
            .into_iter()
            .fold(0.0, f64::max)
    };
    volume.max(center).max(largest(&part) / largest(&y.inertia))
}

/// Expected properties, with the inertia about each axis.
fn of(volume: f64, center: DVec3, principal: DVec3) -> MassProperties {
    let mut found = mass(&shapes::cuboid(Vec3::ONE, 1)).unwrap();
    (found.volume, found.center) = (volume, center);
    found.inertia = DMat3::from_diagonal(principal);
    found
}

#[test]
fn a_box_has_the_mass_properties_of_the_formula_wherever_it_is() {
    let half = DVec3::new(0.5, 1.0, 1.5);
    let square = half * half;
    let exact = DVec3::new(
        square.y + square.z,
        square.z + square.x,
        square.x + square.y,
    ) * 2.0;
    let cuboid = shapes::cuboid(half.as_vec3(), 3);
    let found = mass(&cuboid).unwrap();
    assert!(difference(&found, &of(6.0, DVec3::ZERO, exact), 1.0) < 1e-14);
    let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(1.1);
    for (shift, error) in [(0.0, 1e-14), (1e3, 1e-12), (1e6, 1e-9)] {
        let shift = DVec3::new(shift, -0.5 * shift, 0.1 * shift);
        let found = mass(&moved(&cuboid, |p| turn * p + shift)).unwrap();
        let mut right = of(6.0, shift, exact);
        right.inertia = turn * right.inertia * turn.transpose();
        assert!(difference(&found, &right, 1.0) < error, "{shift}");
    }
}

#[test]
fn balls_and_rings_come_to_the_formula_with_the_square_of_their_edges() {
    let ball = of(4.0 / 3.0 * PI, DVec3::ZERO, DVec3::splat(8.0 / 15.0 * PI));
    let error = |detail| difference(&mass(&shapes::icosphere(detail)).unwrap(), &ball, 1.0);
    for detail in 2..5 {
        let ratio = error(detail) / error(detail + 1);
        assert!((3.8..4.1).contains(&ratio), "{detail}: {ratio}");
    }
    assert!(error(5) < 2e-3);

    let [large, small] = [2.0f64, 0.5];
    let volume = 2.0 * PI * PI * large * small * small;
    let [along, across] =
        [(1.0, 0.75), (0.5, 0.625)].map(|(x, y)| volume * (x * large * large + y * small * small));
    let far = DVec3::new(1e6, -2e6, 3e6);
    let error = |detail| {
        let ring = moved(&shapes::torus(2.0, 0.5, detail), |p| p + far);
        let axes = DVec3::new(across, across, along);
        difference(&mass(&ring).unwrap(), &of(volume, far, axes), 1.0)
    };
    let ratio = error(48) / error(96);
    assert!((3.8..4.2).contains(&ratio) && error(96) < 5e-3, "{ratio}");
}

#[test]
fn another_method_finds_the_same() {
    for (mesh, size) in [
        (shapes::torus_knot(2, 3, 0.45, 40), 1.0),
        (shapes::gear(11, 2), 1.0),
        (shapes::icosphere(3), 1.0),
        (
            moved(&shapes::torus(1.0, 0.3, 24), |p| {
                p * DVec3::new(1e-3, 5.0, 40.0)
            }),
            40.0,
        ),
    ] {
        let found = mass(&mesh).unwrap();
        let other = by_surface(&mesh, mesh.aabb().center());
        let error = difference(&found, &other, size);
        assert!(error < 1e-12, "{error}: {found:?} {other:?}");
    }
}

#[test]
fn parts_add_up_and_cavities_are_taken_off() {
    let cuboid = shapes::cuboid(Vec3::ONE, 2);
    // Two boxes of side 2 and 1, a million apart.
    let both = [(&cuboid, 1.0, DVec3::ZERO), (&cuboid, 0.5, DVec3::X * 1e6)];
    let found = mass(&union(&both)).unwrap();
    let (volume, center) = (9.0, 1e6 / 9.0_f64);
    let across =
        8.0 * center * center + (1e6 - center) * (1e6 - center) + 8.0 * 2.0 / 3.0 + 1.0 / 6.0;
    let right = of(volume, DVec3::X * center, DVec3::new(5.5, across, across));
    assert!(difference(&found, &right, 1e6) < 1e-14);
    assert!((found.inertia.x_axis.x - 5.5).abs() < 1e-4, "{found:?}");

    let both = [
        (&cuboid, 1.0, DVec3::ZERO),
        (&cuboid, -0.5, DVec3::X * 0.25),
    ];
    let found = mass(&union(&both)).unwrap();
    let center = -0.25 / 7.0;
    let about = |x: f64| (x - center).powi(2);
    let across = 16.0 / 3.0 + 8.0 * about(0.0) - 1.0 / 6.0 - about(0.25);
    let axes = DVec3::new(16.0 / 3.0 - 1.0 / 6.0, across, across);
    assert!(difference(&found, &of(7.0, DVec3::X * center, axes), 1.0) < 1e-14);
}

#[test]
fn solids_without_mass_are_refused_by_name() {
    let cuboid = shapes::cuboid(Vec3::ONE, 1);
    assert_eq!(
        Tree::new(cuboid.clone()).mass_properties(),
        Err(SolidError::NotSolid)
    );
    let open = with_triangles(&cuboid, cuboid.triangles()[1..].iter().copied());
    let [p, q, r] = cuboid.triangles()[0];
    let error = mass(&open).unwrap_err();
    let SolidError::Open { edges: 3, edge } = error else {
        panic!("{error}");
    };
    assert!([[q, p], [r, q], [p, r]].contains(&edge), "{error}");
    assert!(
        error
            .to_string()
            .starts_with("the solid has 3 open edges, one from vertex ")
    );
    let reversed = union(&[(&cuboid, -1.0, DVec3::ZERO)]);
    assert!(matches!(mass(&reversed), Err(SolidError::InsideOut { .. })));
    // Two sides of a sheet, tilted; nothing; too large for a tensor.
    let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(1.1);
    let corners = [
        DVec3::ZERO,
        DVec3::X,
        DVec3::new(0.3, 1.0, 0.0),
        DVec3::new(1.0, 1.0, 0.0),
    ];
    let sheet = [[0, 1, 2], [0, 2, 1], [1, 3, 2], [1, 2, 3]];
    let sheet = Mesh::from_f64(corners.map(|p| turn * p + DVec3::splat(7.0)), sheet).unwrap();
    let nothing = Mesh::from_f64([DVec3::ZERO; 0], [[0u32; 3]; 0]).unwrap();
    for mesh in [
        sheet,
        nothing,
        moved(&cuboid, |p| 1e100 * p),
        moved(&cuboid, |p| 1e-120 * p),
    ] {
        let error = mass(&mesh).unwrap_err();
        assert!(matches!(error, SolidError::NoVolume { .. }), "{error}");
    }
}
