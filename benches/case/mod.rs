//! Two bodies and where one goes, for benches that play motions.

use std::fs::read_to_string;
use std::path::Path;

use punctual::glam::{DMat3, DVec3};
use punctual::{Motion, Pose, Tree, shapes};

/// Two bodies, and where B goes.
pub struct Case {
    pub name: String,
    pub trees: [Tree; 2],
    pub poses: Vec<Pose>,
}

impl Case {
    /// A folder with two meshes `a.obj` and `b.obj` and `poses.txt`, of B in A, 12 numbers a line.
    pub fn read(folder: &str) -> Self {
        let folder = Path::new(folder);
        let load =
            |file| punctual_io::load(&folder.join(file)).unwrap_or_else(|error| panic!("{error}"));
        let tree = |file| Tree::new(load(file).mesh);
        let list = folder.join("poses.txt");
        let text =
            read_to_string(&list).unwrap_or_else(|error| panic!("{}: {error}", list.display()));
        let lines = text
            .lines()
            .filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
        let pose = |line: &str| {
            let numbers: Vec<f64> = line
                .split_whitespace()
                .map(|number| number.parse().expect("a number"))
                .collect();
            Pose::from_row_major(numbers.try_into().expect("12 numbers")).expect("a pose")
        };
        let name = folder
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Self {
            name,
            trees: ["a.obj", "b.obj"].map(tree),
            poses: lines.map(pose).collect(),
        }
    }

    /// A ball that goes around a knot.
    pub fn ball_and_knot() -> Self {
        let trees = [
            Tree::new(shapes::torus_knot(2, 3, 0.2, 192)),
            Tree::new(shapes::icosphere(4)),
        ];
        let pose = |i: i32| {
            let angle = 0.02 * f64::from(i);
            let place = DMat3::from_rotation_z(angle) * DVec3::new(2.0, 0.0, 0.4);
            Pose::new(DMat3::from_rotation_y(3.0 * angle), place).expect("a rotation")
        };
        Self {
            name: "ball around a knot".into(),
            trees,
            poses: (0..=300).map(pose).collect(),
        }
    }

    /// The motion from each pose to the next, a screw.
    pub fn motions(&self) -> Vec<Motion> {
        self.poses
            .windows(2)
            .map(|ends| Motion::screw(ends[0], ends[1]).expect("a motion"))
            .collect()
    }
}
