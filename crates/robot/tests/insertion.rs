//! A peg in a hole that is barely wider, and a box that slides along a board: edges cost by their
//! length, not by the gap, and claim nothing that labels contradict.

mod cell;

use std::f64::consts::PI;

use cell::{UNLIMITED, at, random};
use punctual::{Budget, Mesh, Pose, StopReason};
use punctual_robot::{
    Checker, Collision, Description, EdgeAnswer, EdgeOptions, Joint, JointKind, Link, Model, Shape,
};

/// A tool that slides along x, y and z and then turns about x, y and z.
fn tool(shape: Shape) -> Checker {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let name = |i: usize| format!("link{i}");
    let link = |i: usize| Link {
        name: name(i),
        shapes: if i == 6 {
            vec![(Pose::IDENTITY, shape.clone())]
        } else {
            vec![]
        },
    };
    let joint = |i: usize| Joint {
        name: format!("joint{i}"),
        kind: if i < 3 {
            JointKind::Prismatic
        } else {
            JointKind::Continuous
        },
        parent: name(i),
        child: name(i + 1),
        origin: Pose::IDENTITY,
        axis: axes[i % 3],
        limits: None,
        mimic: None,
    };
    let robot = Description {
        links: (0..7).map(link).collect(),
        joints: (0..6).map(joint).collect(),
        ..Description::default()
    };
    Checker::new(Model::new(&robot).unwrap().into())
}

/// A tube along z of 100 mm, whose inner sides are this far from the axis.
fn tube(inner: f64) -> Mesh {
    let n = 32;
    let corner = |i: u32| {
        let (s, c) = (2.0 * PI * f64::from(i / 4) / f64::from(n)).sin_cos();
        let r = if i & 1 > 0 {
            0.02
        } else {
            inner / (PI / f64::from(n)).cos()
        };
        [r * c, r * s, if i & 2 > 0 { 0.05 } else { -0.05 }]
    };
    let strips = [[0, 2, 4, 6], [1, 5, 3, 7], [0, 4, 1, 5], [2, 3, 6, 7]];
    let quads = |i: u32| strips.map(|quad| quad.map(|k| 4 * ((i + k / 4) % n) + k % 4));
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [b, d, c]];
    let triangles = (0..n).flat_map(quads).flat_map(halves);
    Mesh::from_f64((0..4 * n).map(corner), triangles).unwrap()
}

#[test]
fn a_straight_edge_along_a_surface_costs_by_its_length() {
    let mut checker = tool(Shape::cuboid([0.02, 0.02, 0.02]).unwrap());
    let board = Shape::cuboid([1.0, 1.0, 0.02]).unwrap();
    checker.add("board", at(0.0, 0.0, -0.01), board).unwrap();
    let mut work = |gap: f64, turn: f64| {
        let from = [-0.05, 0.02, 0.01 + gap, 0.0, 0.0, 0.3];
        let to = [0.05, -0.01, 0.01 + gap, 0.0, 0.0, 0.3 + turn];
        let options = EdgeOptions::any();
        let edge = checker.edge(&from, &to, &options, UNLIMITED).unwrap();
        let expected = if gap > 0.0 {
            EdgeAnswer::Free
        } else {
            EdgeAnswer::Contact
        };
        assert_eq!(edge.value.answer, expected);
        edge.work
    };
    let widest = work(1e-3, 0.0);
    // Halving alone takes 10 times as much for a tenth of the gap.
    for gap in [1e-4, 1e-5, 1e-6, 0.0] {
        assert!(work(gap, 0.0) < 2 * widest, "{gap}");
    }
    // While the box turns, it takes the square root of that.
    let ratio = work(1e-6, 0.1) as f64 / work(1e-5, 0.1) as f64;
    assert!(ratio < 5.0, "{ratio}");
}

#[test]
fn claims_about_a_peg_in_its_hole_are_those_of_labels_at_any_stop() {
    let mut checker = tool(Shape::cylinder(0.01, 0.1).unwrap());
    let hole = 0.01 / (PI / 128.0).cos() + 1e-4;
    checker
        .add("tube", Pose::IDENTITY, Shape::mesh(tube(hole)))
        .unwrap();
    let (mut random, mut free, mut touching, mut stopped) = (random(8), 0, 0, 0);
    for row in 0..40 {
        let mut end = || {
            let mut within = |most: f64| most * (2.0 * random() - 1.0);
            let off = [within(1e-4), within(1e-4), within(0.1)];
            let turned = [within(1e-3), within(1e-3), within(3.0)];
            [off, turned].concat()
        };
        let (from, to) = (end(), end());
        for options in [EdgeOptions::any(), EdgeOptions::first()] {
            let whole = checker.edge(&from, &to, &options, UNLIMITED).unwrap();
            let whole = whole.value;
            let mut cut = checker.edge(&from, &to, &options, Budget::work(0)).unwrap();
            while cut.stop != StopReason::Finished {
                assert!(cut.value.free_until <= whole.free_until);
                stopped += 1;
                cut = checker.resume_edge(Budget::work(10_000)).unwrap();
            }
            assert_eq!(cut.value, whole);
            free += u32::from(whole.answer == EdgeAnswer::Free);
            touching += u32::from(whole.answer == EdgeAnswer::Contact);
            let mut label = |time: f64| {
                let q: Vec<f64> = from
                    .iter()
                    .zip(&to)
                    .map(|(a, b)| a + time * (b - a))
                    .collect();
                checker.collide(&q, UNLIMITED).unwrap().value
            };
            if let Some(time) = whole.touching_at {
                assert_ne!(label(time), Collision::Free, "row {row}");
            }
            for sample in 0..60 {
                let time = f64::from(sample) / 59.0 * whole.free_until;
                if time < whole.free_until || whole.answer == EdgeAnswer::Free {
                    assert_eq!(label(time), Collision::Free, "row {row} at {time}");
                }
            }
        }
    }
    assert!(free > 5 && touching > 30 && stopped > 300, "{free}");
}
