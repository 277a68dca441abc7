//! What it costs to know that a frame is free, beside a query at one pose: `cargo bench -p punctual-benches --bench motion -- [FOLDER..]`.
//!
//! A folder holds two meshes `a.obj` and `b.obj` and `poses.txt`, of B in A, 12 numbers a line. Each pose to the next is a
//! motion (a screw). All motions are played, then all poses (`any`), over and over in one run, and of each the least time
//! counts; so neither finds caches and branch predictors as the same queries have left them. Ratios are of free motions to the
//! mean of the queries at both their ends. Without folders a ball goes around a knot.

use std::fs::read_to_string;
use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Motion, MotionQuery, Pose, Query, Tree, Workspace, shapes};

/// Times that everything is played.
const SWEEPS: usize = 15;

/// Two bodies, and where B goes.
struct Case {
    name: String,
    trees: [Tree; 2],
    poses: Vec<Pose>,
}

impl Case {
    fn read(folder: &str) -> Self {
        let folder = Path::new(folder);
        let tree = |file| Tree::new(punctual_io::load(&folder.join(file)).unwrap_or_else(|error| panic!("{error}")));
        let list = folder.join("poses.txt");
        let text = read_to_string(&list).unwrap_or_else(|error| panic!("{}: {error}", list.display()));
        let lines = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
        let pose = |line: &str| {
            let numbers: Vec<f64> = line.split_whitespace().map(|number| number.parse().expect("a number")).collect();
            Pose::from_row_major(numbers.try_into().expect("12 numbers")).expect("a pose")
        };
        let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Self { name, trees: ["a.obj", "b.obj"].map(tree), poses: lines.map(pose).collect() }
    }

    fn ball_and_knot() -> Self {
        let trees = [Tree::new(shapes::torus_knot(2, 3, 0.2, 192)), Tree::new(shapes::icosphere(4))];
        let pose = |i: i32| {
            let angle = 0.02 * f64::from(i);
            let place = DMat3::from_rotation_z(angle) * DVec3::new(2.0, 0.0, 0.4);
            Pose::new(DMat3::from_rotation_y(3.0 * angle), place).expect("a rotation")
        };
        Self { name: "ball around a knot".into(), trees, poses: (0..=300).map(pose).collect() }
    }

    fn measure(&self) {
        let [a, b] = &self.trees;
        let screw = |ends: &[Pose]| Motion::screw(ends[0], ends[1]).expect("a motion");
        let motions: Vec<Motion> = self.poses.windows(2).map(screw).collect();
        let mut workspace = Workspace::new();
        let mut least = [vec![f64::INFINITY; motions.len()], vec![f64::INFINITY; self.poses.len()]];
        let mut is_free = vec![false; motions.len()];
        let us = |time: Duration| time.as_secs_f64() * 1e6;
        for _ in 0..SWEEPS {
            for (i, &motion) in motions.iter().enumerate() {
                let start = Instant::now();
                let found = MotionQuery::new(a, b, motion).run(&mut workspace, Budget::unlimited());
                least[0][i] = least[0][i].min(us(start.elapsed()));
                is_free[i] = found.free_until == 1.0 && found.touching_at.is_none();
            }
            for (i, &pose) in self.poses.iter().enumerate() {
                let start = Instant::now();
                let found = Query::new(a, b, pose).run(&mut workspace, Budget::unlimited());
                least[1][i] = least[1][i].min(us(start.elapsed()));
                let _ = black_box(found);
            }
        }
        let [of_motions, of_poses] = &least;
        let pairs: Vec<[f64; 2]> = (0..motions.len())
            .filter(|&i| is_free[i])
            .map(|i| [of_motions[i], (of_poses[i] + of_poses[i + 1]) / 2.0])
            .collect();
        let frames = pairs.len() as f64;
        let [motion, query] = [0, 1].map(|k| pairs.iter().map(|times| times[k]).sum::<f64>() / frames);
        let ratios: Vec<f64> = pairs.iter().map(|[motion, query]| motion / query).collect();
        let worst = ratios.iter().copied().fold(0.0, f64::max);
        println!(
            "{:<36} {frames:>6} {motion:>9.2} {query:>9.2} {:>8.2} {:>8.2} {worst:>8.1}",
            self.name,
            motion / query,
            ratios.iter().sum::<f64>() / frames,
        );
    }
}

fn main() {
    let folders: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    println!(
        "{:<36} {:>6} {:>9} {:>9} {:>8} {:>8} {:>8}",
        "", "free", "motion us", "any us", "ratio", "frames", "worst"
    );
    if folders.is_empty() {
        Case::ball_and_knot().measure();
    }
    for folder in &folders {
        Case::read(folder).measure();
    }
}
