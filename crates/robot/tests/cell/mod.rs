//! An arm with every kind of joint and shape, in its cell.

#![allow(dead_code)] // Each test uses its part.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
use punctual_robot::{
    Checker, Clearance, ClearanceOptions, Collision, Joint, JointKind, Link, Model, Shape, ShapeId,
    UrdfOptions,
};

pub const UNLIMITED: Budget = Budget::unlimited();

pub fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(name)
}

/// Read once: the tests run at the same time.
pub fn arm() -> Arc<Model> {
    static ARM: OnceLock<Arc<Model>> = OnceLock::new();
    Arc::clone(ARM.get_or_init(|| read_arm("surfaces", &UrdfOptions::default())))
}

pub fn read_arm(of: &str, options: &UrdfOptions) -> Arc<Model> {
    // The package is named `arm`, the folder is not.
    let packages = folder(of);
    std::fs::create_dir_all(packages.join("arm")).unwrap();
    std::fs::copy(file("wedge.obj"), packages.join("arm/wedge.obj")).unwrap();
    let options = options.clone().srdf(file("arm.srdf")).packages(&packages);
    let model = Model::from_urdf(file("arm.urdf"), &options).unwrap();
    std::fs::remove_dir_all(packages).unwrap();
    Arc::new(model)
}

/// A folder of this run alone.
pub fn folder(of: &str) -> PathBuf {
    std::env::temp_dir().join(format!("punctual-{of}-{}", std::process::id()))
}

pub fn sphere(radius: f64) -> Shape {
    Shape::sphere(radius).unwrap()
}

pub fn cuboid(size: [f64; 3]) -> Shape {
    Shape::cuboid(size).unwrap()
}

pub fn collide(checker: &mut Checker, q: &[f64]) -> Collision {
    checker.collide(q, UNLIMITED).unwrap().value
}

pub fn clearance(checker: &mut Checker, q: &[f64]) -> Clearance {
    let options = ClearanceOptions::default();
    checker.clearance(q, &options, UNLIMITED).unwrap().value
}

/// The configuration at a share of the way.
pub fn between(from: &[f64], to: &[f64], t: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a + t * (b - a)).collect()
}

/// The first of so many steps of the line at which something meets.
pub fn first_contact(checker: &mut Checker, [from, to]: [&[f64]; 2], steps: u32) -> Option<f64> {
    let mut shares = (0..=steps).map(|i| f64::from(i) / f64::from(steps));
    shares.find(|&t| collide(checker, &between(from, to, t)) != Collision::Free)
}

pub fn link(name: &str, shapes: Vec<(Pose, Shape)>) -> Link {
    let name = name.into();
    Link { name, shapes }
}

pub fn joint(name: &str, kind: JointKind, [parent, child]: [&str; 2], axis: [f64; 3]) -> Joint {
    Joint {
        name: name.into(),
        kind,
        parent: parent.into(),
        child: child.into(),
        origin: Pose::IDENTITY,
        axis,
        limits: None,
        mimic: None,
    }
}

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, [x, y, z]).unwrap()
}

/// The arm among a board, a ball, a post and a torus, with a box in its hand.
pub fn cell() -> Checker {
    let mut checker = Checker::new(arm());
    let torus = Shape::mesh(shapes::torus(0.3, 0.08, 24));
    let mut add = |name, place, shape| checker.add(name, place, shape).unwrap();
    add("board", at(0.9, 0.0, 0.4), cuboid([0.6, 0.6, 0.05]));
    add("ball", at(-0.7, 0.3, 0.9), sphere(0.2));
    add(
        "post",
        at(0.0, -0.7, 0.5),
        Shape::cylinder(0.08, 1.0).unwrap(),
    );
    add("ring", at(0.2, 0.8, 1.0), torus);
    let (load, place) = (cuboid([0.02, 0.02, 0.2]), at(0.0, 0.0, 0.12));
    checker
        .attach("load", "palm", place, load, &["left"])
        .unwrap();
    checker
}

/// Numbers from 0 to 1.
pub fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

pub fn configurations(count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = random(seed);
    let mut row = || {
        let mut within = |low: f64, high: f64| low + (high - low) * random();
        [(-3.0, 3.0), (-2.0, 2.0), (-2.5, 2.5), (0.0, 0.1)]
            .map(|(low, high)| within(low, high))
            .into()
    };
    (0..count).map(|_| row()).collect()
}

/// The shapes of the cell, as trees with a margin, and each shape's pose.
pub fn shapes_of(checker: &Checker, q: &[f64]) -> Vec<(ShapeId, Tree, f64, Pose)> {
    let arm = checker.model();
    let poses = arm.link_poses(q).unwrap();
    let link = |name: &str| poses[arm.link_names().position(|link| link == name).unwrap()];
    let wedge = punctual_io::load(&file("wedge.obj")).unwrap().mesh;
    let wedge = |scale: DVec3| {
        let vertices = (0..wedge.vertex_count()).map(|i| (wedge.vertex(i) * scale).to_array());
        let mesh = punctual::Mesh::from_f64(vertices, wedge.triangles().iter().copied());
        Tree::new(mesh.unwrap())
    };
    let boxed = |size: [f64; 3]| Tree::new(shapes::cuboid(size.map(|s| (s / 2.0) as f32), 1));
    let point = || Tree::new(punctual::Mesh::from_f64([[0.0; 3]], [[0; 3]]).unwrap());
    let of = |name: &str, tree, margin, frame: Pose, pose: Pose| {
        let id = checker.find(name).unwrap();
        (id, tree, margin, frame.compose(&pose).unwrap())
    };
    let world = Pose::IDENTITY;
    let (upper, board) = (boxed([0.1, 0.1, 0.5]), boxed([0.6, 0.6, 0.05]));
    let (fore, right) = (
        wedge(DVec3::new(0.05, 0.05, 0.25)),
        wedge(DVec3::new(0.02, -0.02, 0.02)),
    );
    let ring = Tree::new(shapes::torus(0.3, 0.08, 24));
    let (load, in_hand) = (boxed([0.02, 0.02, 0.2]), at(0.0, 0.0, 0.12));
    vec![
        of("upper", upper, 0.0, link("upper"), at(0.0, 0.0, 0.3)),
        of("fore", fore, 0.0, link("fore"), at(0.0, 0.0, 0.25)),
        of("left", point(), 0.03, link("left"), world),
        of("right", right, 0.0, link("right"), world),
        of("board", board, 0.0, world, at(0.9, 0.0, 0.4)),
        of("ball", point(), 0.2, world, at(-0.7, 0.3, 0.9)),
        of("ring", ring, 0.0, world, at(0.2, 0.8, 1.0)),
        of("load", load, 0.0, link("palm"), in_hand),
    ]
}

/// Bounds of the distance of the surfaces of each pair that is asked, without base and post, whose
/// cylinders are polygons here and there.
pub fn surfaces(checker: &Checker, q: &[f64]) -> Vec<([ShapeId; 2], f64)> {
    let shapes = shapes_of(checker, q);
    let mut workspace = Workspace::new();
    let mut found = Vec::new();
    for pair in checker.pairs() {
        let get = |id| shapes.iter().find(|shape| shape.0 == id);
        let (Some(a), Some(b)) = (get(pair[0]), get(pair[1])) else {
            continue;
        };
        let b_in_a = a.3.inverse().unwrap().compose(&b.3).unwrap();
        let query = Query::distance(&a.1, &b.1, b_in_a)
            .margins([a.2, b.2])
            .absolute_tolerance(0.0);
        found.push((pair, query.run(&mut workspace, UNLIMITED).value.high));
    }
    found
}
