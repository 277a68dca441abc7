//! Trees of shapes: against closed forms within their bands, hulls by exact signs, what is refused.

use punctual::geom::random::Random;
use punctual::geom::triangle::side_of_plane;
use punctual::glam::{DMat3, DQuat, DVec2, DVec3};
use punctual::tree::{ROUND_BAND, ShapeError};
use punctual::{Budget, MeshError, Pose, Query, Tree, Workspace, shapes};

type Formula = Box<dyn Fn(DVec3) -> f64>;

fn vector(random: &mut Random, size: f64) -> DVec3 {
    let [x, y, z] = [(); 3].map(|()| random.between(-size, size));
    DVec3::new(x, y, z)
}

fn to_cuboid(p: DVec3, half: DVec3) -> f64 {
    let q = p.abs() - half;
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

/// Signed distance of a convex polygon of the half plane of a radius and z, turned about z: the
/// corners are in clockwise order, the first and the last on the axis.
fn to_turned(p: DVec3, corners: &[DVec2]) -> f64 {
    let p = DVec2::new(p.truncate().length(), p.z);
    let (mut gap, mut is_inside) = (f64::INFINITY, true);
    for ends in corners.windows(2) {
        let (way, from) = (ends[1] - ends[0], p - ends[0]);
        let foot = (from.dot(way) / way.length_squared()).clamp(0.0, 1.0);
        gap = gap.min((from - way * foot).length());
        is_inside &= way.perp_dot(from) <= 0.0;
    }
    if is_inside { -gap } else { gap }
}

/// Each kind of solid, its signed distance, and how far its tree may reach beyond it.
fn kinds(random: &mut Random) -> Vec<(&'static str, Tree, Formula, f64)> {
    let size = 2f64.powi(random.between(-20.0, 20.0) as i32);
    let [r, l, x, y, z] = [(); 5].map(|()| size * random.between(0.2, 2.0));
    let sides = DVec3::new(x, y, z);
    let small = random.between(0.0, 0.5) * sides.min_element();
    let (core, half) = (sides / 2.0 - small, l / 2.0);
    let ends = [DVec2::new(0.0, half), DVec2::new(0.0, -half)];
    let [top, low] = [half, -half].map(|z| DVec2::new(r, z));
    let (cylinder, cone) = ([ends[0], top, low, ends[1]], [ends[0], low, ends[1]]);
    let band = ROUND_BAND * r;
    let to_segment = move |p: DVec3| (p - DVec3::Z * p.z.clamp(-half, half)).length() - r;
    vec![
        (
            "ball",
            Tree::ball(r).unwrap(),
            Box::new(move |p: DVec3| p.length() - r),
            0.0,
        ),
        (
            "capsule",
            Tree::capsule(r, l).unwrap(),
            Box::new(to_segment),
            0.0,
        ),
        (
            "box",
            Tree::cuboid(sides).unwrap(),
            Box::new(move |p| to_cuboid(p, sides / 2.0)),
            0.0,
        ),
        (
            "rounded box",
            Tree::rounded_cuboid(sides, small).unwrap(),
            Box::new(move |p| to_cuboid(p, core) - small),
            0.0,
        ),
        (
            "cylinder",
            Tree::cylinder(r, l).unwrap(),
            Box::new(move |p| to_turned(p, &cylinder)),
            band,
        ),
        (
            "cone",
            Tree::cone(r, l).unwrap(),
            Box::new(move |p| to_turned(p, &cone)),
            band,
        ),
    ]
}

#[test]
fn shapes_are_where_their_formulas_say() {
    let (mut random, mut workspace) = (Random::new(1), Workspace::new());
    let [mut inside, mut outside] = [0; 2];
    for _ in 0..40 {
        for (name, tree, formula, band) in kinds(&mut random) {
            assert!(tree.validate().is_ok());
            let size = tree.aabb_at(&Pose::IDENTITY).max.max_element();
            for _ in 0..40 {
                let point = vector(&mut random, 1.2 * size);
                let query = Query::signed_distance(&tree, point).unwrap();
                let found = query.run(&mut workspace, Budget::unlimited()).value;
                let (truth, found) = (formula(point), found.distance.unwrap());
                let close = 1e-11 * size;
                // Inside a thickened core, the depth told may be too small.
                let is_rough = truth < 0.0 && tree.radius() > 0.0;
                assert!(found.low <= truth + close, "{name} {found:?} {truth}");
                assert!(found.high >= truth - band - close, "{name}");
                assert!(is_rough || found.high <= truth + close, "{name}");
                *(if truth < 0.0 {
                    &mut inside
                } else {
                    &mut outside
                }) += 1;
            }
        }
    }
    assert!(inside > 1_000 && outside > 1_000, "{inside} {outside}");
}

#[test]
fn prisms_and_pyramids_hold_the_true_shape() {
    for (r, l) in [(1.0, 2.0), (1e-150, 1e150), (1e150, 1e-150), (0.3, 7e9)] {
        for tree in [Tree::cylinder(r, l).unwrap(), Tree::cone(r, l).unwrap()] {
            let solid = tree.solid().unwrap();
            assert!(solid.is_closed() && solid.components().len() == 1);
            assert!(!solid.components()[0].inside_out);
            let mesh = tree.mesh();
            for triangle in 0..mesh.len() {
                let [a, b, c] = mesh.triangle(triangle);
                for p in [a, b, c] {
                    assert!(p.truncate().length() <= r * (1.0 + ROUND_BAND));
                    assert!(p.z.abs() == l / 2.0);
                }
                // The line where the wall meets the plane of the base passes the circle.
                let low: Vec<DVec3> = [a, b, c].into_iter().filter(|p| p.z < 0.0).collect();
                if let [p, q] = low[..] {
                    let (p, q) = (p.truncate() / r, q.truncate() / r);
                    assert!(p.perp_dot(q).abs() / (q - p).length() >= 1.0);
                }
            }
        }
    }
}

/// A closed convex surface of points that were given, and no point above a face.
fn check_hull(points: &[DVec3]) -> Tree {
    let tree = Tree::hull(points.iter().copied()).unwrap();
    let solid = tree.solid().unwrap();
    assert!(solid.is_closed() && solid.components().len() == 1);
    assert!(!solid.components()[0].inside_out);
    let mesh = tree.mesh();
    for face in 0..mesh.len() {
        let corners = mesh.triangle(face);
        assert!(corners.iter().all(|corner| points.contains(corner)));
        assert!(
            points
                .iter()
                .all(|&point| side_of_plane(&corners, point) <= 0)
        );
        // Not degenerate: some point is strictly below.
        assert!(
            points
                .iter()
                .any(|&point| side_of_plane(&corners, point) < 0)
        );
    }
    tree
}

#[test]
fn hulls_are_exact() {
    let mut random = Random::new(2);
    let lattice = |n: u32| {
        let at = move |i: u32| [i % n, i / n % n, i / n / n].map(f64::from);
        (0..n * n * n).map(move |i| DVec3::from_array(at(i)))
    };
    // Many points in each plane and on each edge, in any order, some twice.
    for round in 0..20 {
        let mut points: Vec<DVec3> = lattice(4).chain(lattice(2)).collect();
        for i in (1..points.len()).rev() {
            points.swap(i, random.between(0.0, i as f64 + 1.0) as usize);
        }
        let turn = DMat3::from_quat(DQuat::from_scaled_axis(vector(&mut random, 3.0)));
        let tree = check_hull(&points);
        assert_eq!(tree.mass_properties().unwrap().volume, 27.0, "{round}");
        // Rounded, the planes are only almost ones.
        let turned: Vec<DVec3> = points.iter().map(|&p| turn * p).collect();
        let tree = check_hull(&turned);
        assert!((tree.mass_properties().unwrap().volume - 27.0).abs() < 1e-12);
    }
    for size in [1e-300, 1.0, 1e300] {
        for count in [4, 5, 8, 32, 500] {
            let ball = |_| vector(&mut random, 1.0).normalize() * size;
            check_hull(&(0..count).map(ball).collect::<Vec<_>>());
        }
    }
    // A cap so flat that it is one only by the last bits.
    let cap = |i: u32| {
        let (x, y) = (f64::from(i % 9), f64::from(i / 9));
        DVec3::new(x, y, 1.0 - f64::EPSILON * (x * x + y * y))
    };
    let cap: Vec<DVec3> = (0..81).map(cap).chain([DVec3::ZERO]).collect();
    check_hull(&cap);
    // A hull of its own hull.
    let torus = shapes::torus(1.0, 0.3, 24);
    let points: Vec<DVec3> = (0..torus.vertex_count()).map(|i| torus.vertex(i)).collect();
    let hull = check_hull(&points);
    let again = check_hull(
        &(0..hull.mesh().vertex_count())
            .map(|i| hull.mesh().vertex(i))
            .collect::<Vec<_>>(),
    );
    assert_eq!(hull.mesh().aabb(), again.mesh().aabb());
    assert!(hull.mesh().vertex_count() < torus.vertex_count());
}

#[test]
fn height_fields_have_their_heights() {
    let mut workspace = Workspace::new();
    let (columns, rows) = (7, 5);
    let heights: Vec<f32> = (0..columns * rows).map(|i| (i * i % 11) as f32).collect();
    let field = Tree::height_field(heights.iter().copied(), columns, [0.5, 2.0]).unwrap();
    let mesh = field.mesh();
    assert_eq!((mesh.vertex_count(), mesh.len()), (35, 2 * 6 * 4));
    assert!(field.solid().is_none());
    for (i, &height) in heights.iter().enumerate() {
        let wanted = [
            0.5 * (i % 7) as f64,
            2.0 * (i / 7) as f64,
            f64::from(height),
        ];
        assert_eq!(mesh.vertex(i).to_array(), wanted);
    }
    for triangle in 0..mesh.len() {
        let [a, b, c] = mesh.triangle(triangle);
        assert!((b - a).cross(c - a).z > 0.0);
    }
    // A ball above a top.
    let ball = Tree::ball(0.25).unwrap();
    let top = mesh.vertex(8);
    assert_eq!(top.z, 9.0);
    for (gap, meets) in [(0.0, true), (1e-9, false)] {
        let pose = Pose::new(DMat3::IDENTITY, top + DVec3::Z * (0.25 + gap)).unwrap();
        let query = Query::intersection(&field, &ball, pose);
        let found = query.run(&mut workspace, Budget::unlimited()).value;
        assert_eq!(found.meets(), meets);
    }
}

#[test]
fn what_is_wrong_is_named() {
    let told = |result: Result<Tree, ShapeError>| result.unwrap_err().to_string();
    let nan = f64::NAN;
    for (result, text) in [
        (Tree::ball(0.0), "radius is 0.0, must be 1e-150 to 1e150"),
        (Tree::ball(nan), "radius is NaN, must be 1e-150 to 1e150"),
        (
            Tree::capsule(1e-151, 1.0),
            "radius is 1e-151, must be 1e-150 to 1e150",
        ),
        (
            Tree::capsule(1.0, -1.0),
            "length is -1.0, must be 0.0 to 1e150",
        ),
        (
            Tree::cuboid([1.0, 0.0, 1.0]),
            "size[1] is 0.0, must be 1e-150 to 1e150",
        ),
        (
            Tree::rounded_cuboid([1.0, 3.0, 2.0], 0.75),
            "radius is 0.75, must be 0.0 to 0.5",
        ),
        (
            Tree::rounded_cuboid([nan; 3], 0.75),
            "size[0] is NaN, must be 1e-150 to 1e150",
        ),
        (
            Tree::cylinder(1.0, f64::INFINITY),
            "length is inf, must be 1e-150 to 1e150",
        ),
        (
            Tree::cone(-2.0, 1.0),
            "radius is -2.0, must be 1e-150 to 1e150",
        ),
        (
            Tree::hull([[0.0; 3]; 0]),
            "the 0 points of the hull lie in one plane",
        ),
        (
            Tree::hull([[1.0; 3]; 9]),
            "the 9 points of the hull lie in one plane",
        ),
        (
            Tree::hull([[0.0; 3], [1.0; 3], [3.0; 3], [7.0; 3]]),
            "the 4 points of the hull lie in one plane",
        ),
        (
            Tree::hull([
                [0.1, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 0.0, 3.0],
                [0.0, 0.0, -7.0],
            ]),
            "the 4 points of the hull lie in one plane",
        ),
        (
            Tree::hull([[0.0; 3], [1.0, nan, 0.0]]),
            "vertex 1 is not finite along axis 1",
        ),
        (
            Tree::height_field([0.0; 9], 4, [1.0; 2]),
            "9 heights in 4 columns, must be two whole rows and columns or more",
        ),
        (
            Tree::height_field([0.0; 0], 0, [1.0; 2]),
            "0 heights in 0 columns, must be two whole rows and columns or more",
        ),
        (
            Tree::height_field([0.0; 4], 1, [1.0; 2]),
            "4 heights in 1 columns, must be two whole rows and columns or more",
        ),
        (
            Tree::height_field([0.0; 4], 2, [1.0, 0.0]),
            "spacing[1] is 0.0, must be 1e-150 to 1e150",
        ),
        (
            Tree::height_field([0.0, 0.0, nan, 0.0], 2, [1.0; 2]),
            "vertex 2 is not finite along axis 2",
        ),
    ] {
        assert_eq!(told(result), text);
    }
    let fault = Tree::height_field([0.0, 1e302, 0.0, 0.0], 2, [1.0; 2]).unwrap_err();
    let named = MeshError::TooLarge { vertex: 1, axis: 2 };
    assert_eq!(fault, ShapeError::Mesh(named));
    // A box of no size but its radius is a ball.
    let ball = Tree::rounded_cuboid([1.0; 3], 0.5).unwrap();
    assert_eq!((ball.radius(), ball.mesh().aabb().max), (0.5, DVec3::ZERO));
    assert!(Tree::capsule(1.0, 0.0).is_ok() && Tree::rounded_cuboid([1.0; 3], 0.0).is_ok());
}
