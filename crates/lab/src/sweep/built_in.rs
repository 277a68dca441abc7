//! Cases that need no files: generated shapes approach each other at random, up to predefined offsets from the first touch.

use crate::report::Failure;
use punctual::glam::Vec3;
use punctual::{Mesh, Pose, Tree, shapes};

use super::case::Case;
use crate::approach::{Approach, Line};

/// Distances past the first touch, in the box diagonal of the smaller mesh.
const OFFSETS: [f64; 7] = [-0.05, -0.02, -0.01, -0.001, 0.001, 0.01, 0.05];

/// Makes a case when it is its turn.
type Maker = Box<dyn FnOnce() -> Result<Case, Failure>>;

pub fn cases(quick: bool) -> Vec<Maker> {
    let fine = u32::from(!quick);
    let lines = if quick { 4 } else { 12 };
    let make = |name: &'static str, seed: u64, a: fn(u32) -> Mesh, b: fn(u32) -> Mesh| -> Maker {
        Box::new(move || {
            let (a, b) = (a(fine), b(fine));
            let poses = near_contact(&Tree::new(a.clone()), &Tree::new(b.clone()), lines, seed)?;
            Ok(Case::new(name, a, b, poses))
        })
    };
    let gear = |fine: u32| shapes::gear(12, 2 + 2 * fine);
    let knot = |fine: u32| shapes::torus_knot(2, 3, 0.2, 48 << fine);
    vec![
        make("knot_sphere", 1, knot, |fine| shapes::icosphere(3 + fine)),
        make("gear_gear", 2, |fine| shapes::gear(16, 2 + 2 * fine), gear),
        make(
            "torus_torus",
            3,
            |fine| shapes::torus(1.0, 0.2, 40 << fine),
            |fine| shapes::torus(0.8, 0.3, 40 << fine),
        ),
        make(
            "plate_knot",
            4,
            |fine| shapes::cuboid(Vec3::new(1.0, 0.8, 0.02), 12 << fine),
            knot,
        ),
        make(
            "hills_gear",
            5,
            |fine| shapes::height_field(32 << fine, 1),
            gear,
        ),
        make(
            "hills_hills",
            6,
            |fine| shapes::height_field(32 << fine, 2),
            |fine| shapes::height_field(32 << fine, 3),
        ),
    ]
}

/// Poses on random lines towards A: one for each offset from the first touch of each approach, turned at random.
fn near_contact(a: &Tree, b: &Tree, lines: u64, seed: u64) -> Result<Vec<Pose>, Failure> {
    let mut approach = Approach::new(a, b, seed);
    let mut poses = Vec::new();
    for _ in 0..lines {
        let line = Line {
            turn: approach.turn(),
            target: approach.middle_of_a(),
            direction: approach.direction(),
        };
        if let Some(touch) = approach.first_touch(&line, approach.reach())? {
            for offset in OFFSETS {
                poses.push(approach.at(&line, touch + offset * approach.unit())?);
            }
        }
    }
    Ok(poses)
}
