//! The answers to every question about real meshes and recorded scenes, as hashes that a change of
//! the code must not move.
//!
//! A line of `tests/fixtures/golden_*.txt` is `case question hash`: the hash covers verdicts, pairs,
//! bounds, points, counts and work. The data lies beside the repository. Without it nothing is
//! compared here, and `tests/platforms` compares answers about built-in meshes. After a change that
//! is meant to give other answers, `PUNCTUAL_BLESS=1 cargo test --test golden` writes the files
//! anew, and `git diff` shows which questions it moved.

extern crate alloc;

mod common;
#[path = "platforms/questions.rs"]
mod questions;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use common::files::{self, Soup, number};
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::{Budget, Mode, Pose, Tree, Workspace};
use punctual_scene::{Body, Scene};
use questions::{Answers, Frozen};

/// Of each case this many poses, evenly over its list.
const POSES: usize = 3;
/// Larger meshes take too long without a release build.
const MOST_TRIANGLES: usize = 20_000;
const FRAMES: usize = 60;

#[test]
fn answers_about_real_meshes_are_the_golden_ones() {
    let Some(folder) = files::shared("meshes/cases") else {
        return;
    };
    let mut lines = String::new();
    for case in files::folders(&folder, "") {
        lines += &answers_of_case(&case);
    }
    compare("meshes", &lines);
}

fn answers_of_case(folder: &Path) -> String {
    let case = files::text(&folder.join("case.txt"));
    let [a, b] = ["a", "b"].map(|key| {
        let name = files::value(&case, key).unwrap();
        Soup::read(&folder.join(name))
    });
    let name = folder.file_name().unwrap().to_str().unwrap();
    let mut answers = Answers {
        lines: String::new(),
        case: name,
    };
    if a.triangles.len().max(b.triangles.len()) <= MOST_TRIANGLES {
        let [a, b] = [a, b].map(|soup| Tree::new(soup.mesh().unwrap()));
        answers.tell("trees", [&a, &b].map(|tree| Frozen(tree.stats())));
        let poses: Vec<Pose> = files::poses(&folder.join("poses.txt"))
            .into_iter()
            .flatten()
            .collect();
        for i in 0..POSES.min(poses.len()) {
            let pose = poses[i * poses.len() / POSES];
            questions::ask(&mut answers, [&a, &b], pose, Workspace::new());
        }
    }
    answers.lines
}

#[test]
fn answers_of_recorded_scenes_are_the_golden_ones() {
    let Some(folder) = files::shared("meshes/scenes") else {
        return;
    };
    let mut lines = String::new();
    for name in ["pile200", "robots16"] {
        lines += &answers_of_scene(&folder.join(name), name);
    }
    compare("scenes", &lines);
}

fn answers_of_scene(folder: &Path, name: &str) -> String {
    let mut meshes: BTreeMap<String, Arc<Tree>> = BTreeMap::new();
    let mut bodies = Vec::new();
    for line in files::text(&folder.join("scene.txt")).lines() {
        match *line.split_whitespace().collect::<Vec<_>>() {
            ["mesh", id, path] => {
                let mesh = Soup::read(&folder.join(path)).mesh().unwrap();
                meshes.insert(id.to_owned(), Arc::new(Tree::new(mesh)));
            }
            ["body", _, mesh, kind, ..] => {
                bodies.push((Arc::clone(&meshes[mesh]), kind == "static"))
            }
            _ => {}
        }
    }
    let frames = frames(&files::text(&folder.join("poses.csv")), bodies.len());
    let mut answers = Answers {
        lines: String::new(),
        case: name,
    };
    for (question, mode, budget, contacts) in [
        ("any-cut", Mode::Any, Budget::work(20_000), false),
        ("any", Mode::Any, Budget::unlimited(), false),
        ("all", Mode::All, Budget::unlimited(), false),
        ("contacts-cut", Mode::Any, Budget::work(100_000), true),
    ] {
        let mut scene = Scene::new();
        scene.set_mode(mode);
        if contacts {
            scene.find_contacts();
            scene.track_contacts();
        }
        let ids: Vec<_> = std::iter::zip(&bodies, &frames[0])
            .map(|((tree, fixed), pose)| {
                let tree = Arc::clone(tree);
                let make = if *fixed { Body::fixed } else { Body::moving };
                scene.insert(make(tree, *pose)).unwrap()
            })
            .collect();
        for frame in &frames {
            for (id, pose) in std::iter::zip(&ids, frame) {
                scene.set_pose(*id, *pose).unwrap();
            }
            // As reports were when the answers were frozen: what was added since is 0 for surfaces,
            // and what scenes tell when they are asked was empty.
            let report = format!("{:?}", scene.detect(budget))
                .replace(", contained: 0", "")
                .replace(
                    "group_distances: []",
                    "distances: [], group_distances: [], passages: []",
                );
            answers.tell_bytes(question, report.as_bytes());
        }
    }
    answers.lines
}

/// The first poses of all bodies, frame by frame.
fn frames(csv: &str, bodies: usize) -> Vec<Vec<Pose>> {
    let poses: Vec<Pose> = csv
        .lines()
        .skip(1)
        .take(FRAMES * bodies)
        .map(|line| {
            let [_, _, x, y, z, qw, qx, qy, qz] = line
                .split(',')
                .map(number)
                .collect::<Vec<f64>>()
                .try_into()
                .expect("nine columns");
            let rotation = DMat3::from_quat(DQuat::from_xyzw(qx, qy, qz, qw).normalize());
            Pose::new(rotation, DVec3::new(x, y, z)).unwrap()
        })
        .collect();
    poses.chunks(bodies).map(<[Pose]>::to_vec).collect()
}

/// Compares lines with those of the same cases in the file, or writes them there.
fn compare(name: &str, lines: &str) {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/fixtures/golden_{name}.txt"));
    if std::env::var_os("PUNCTUAL_BLESS").is_some() {
        std::fs::write(&path, lines).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap();
    let differ: Vec<_> = std::iter::zip(lines.lines(), golden.lines())
        .filter(|(ours, theirs)| ours != theirs)
        .collect();
    assert!(differ.is_empty(), "ours, and the golden ones: {differ:#?}");
    assert_eq!(lines.lines().count(), golden.lines().count());
}
