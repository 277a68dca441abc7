//! An arm with every kind of joint and shape, in its cell.

#![allow(dead_code)] // Each test uses its part.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
use punctual_robot::{Checker, Model, Shape, ShapeId, UrdfOptions};

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
    let read = || {
        // The package is named `arm`, the folder is not.
        let packages = std::env::temp_dir().join(format!("punctual-{of}-{}", std::process::id()));
        std::fs::create_dir_all(packages.join("arm")).unwrap();
        std::fs::copy(file("wedge.obj"), packages.join("arm/wedge.obj")).unwrap();
        let options = options.clone().srdf(file("arm.srdf")).packages(&packages);
        let model = Model::from_urdf(file("arm.urdf"), &options).unwrap();
        std::fs::remove_dir_all(packages).unwrap();
        Arc::new(model)
    };
    read()
}

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, [x, y, z]).unwrap()
}

/// The arm among a board, a ball, a post and a torus, with a box in its hand.
pub fn cell() -> Checker {
    let mut checker = Checker::new(arm());
    let shape = Shape::cuboid([0.6, 0.6, 0.05]).unwrap();
    checker.add("board", at(0.9, 0.0, 0.4), shape).unwrap();
    checker
        .add("ball", at(-0.7, 0.3, 0.9), Shape::sphere(0.2).unwrap())
        .unwrap();
    checker
        .add(
            "post",
            at(0.0, -0.7, 0.5),
            Shape::cylinder(0.08, 1.0).unwrap(),
        )
        .unwrap();
    let torus = Shape::mesh(shapes::torus(0.3, 0.08, 24));
    checker.add("ring", at(0.2, 0.8, 1.0), torus).unwrap();
    let load = Shape::cuboid([0.02, 0.02, 0.2]).unwrap();
    checker
        .attach("load", "palm", at(0.0, 0.0, 0.12), load, &["left"])
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
        vec![
            within(-3.0, 3.0),
            within(-2.0, 2.0),
            within(-2.5, 2.5),
            within(0.0, 0.1),
        ]
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
    vec![
        of(
            "upper",
            boxed([0.1, 0.1, 0.5]),
            0.0,
            link("upper"),
            at(0.0, 0.0, 0.3),
        ),
        of(
            "fore",
            wedge(DVec3::new(0.05, 0.05, 0.25)),
            0.0,
            link("fore"),
            at(0.0, 0.0, 0.25),
        ),
        of("left", point(), 0.03, link("left"), world),
        of(
            "right",
            wedge(DVec3::new(0.02, -0.02, 0.02)),
            0.0,
            link("right"),
            world,
        ),
        of(
            "board",
            boxed([0.6, 0.6, 0.05]),
            0.0,
            world,
            at(0.9, 0.0, 0.4),
        ),
        of("ball", point(), 0.2, world, at(-0.7, 0.3, 0.9)),
        of(
            "ring",
            Tree::new(shapes::torus(0.3, 0.08, 24)),
            0.0,
            world,
            at(0.2, 0.8, 1.0),
        ),
        of(
            "load",
            boxed([0.02, 0.02, 0.2]),
            0.0,
            link("palm"),
            at(0.0, 0.0, 0.12),
        ),
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
