//! Meshes against distances that were computed elsewhere: a few cases that are always here (in rational arithmetic, as
//! quadratic programs over the faces), and scanned and CAD meshes, if the data is beside the repository.

use std::collections::HashMap;
use std::path::Path;

use punctual::distance::Bounds;
use punctual::{Answer, PairMemory, Pose, StopReason, Tree, Workspace};

use crate::common::ask::{answer, run_in_pieces};
use crate::common::files::{self, Soup};
use crate::distance::{ENOUGH, Question, run_with_memory};

/// Without the variable every so many poses are asked: prime to the offsets of an approach, so all of them are.
const STRIDE: usize = 13;

/// The distances of the poses, in order.
fn distances(path: &Path) -> Vec<f64> {
    let text = files::text(path);
    let row = |(count, line): (usize, &str)| {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[0], count.to_string(), "{}", path.display());
        fields[1].parse().expect("a distance")
    };
    let mut lines = text.lines();
    let header = lines.next().expect("a header");
    assert!(header.starts_with("pose,distance,"));
    lines.enumerate().map(row).collect()
}

/// Bounds of a distance that is known up to its rounding.
#[track_caller]
fn assert_near(said: &Answer<Bounds>, distance: f64, rounding: f64) {
    let Bounds { low, high, .. } = said.value;
    assert!(low <= distance + rounding, "{said:?}, is {distance:e}");
    assert!(distance <= high + rounding, "{said:?}, is {distance:e}");
    assert!(high > 0.0 || distance == 0.0, "{said:?}");
    assert!(low == 0.0 || distance > 0.0, "{said:?}");
}

fn assert_pose(a: &Tree, b: &Tree, pose: Pose, distance: f64, memory: &mut PairMemory) {
    let mut workspace = Workspace::new();
    let [of_a, of_b] = [a, b].map(|tree| tree.mesh().aabb().extents().max_element());
    let size = of_a + of_b + distance;
    let rounding = 1e-13 * size;
    for relative in [0.0, 1e-2] {
        let asked = Question {
            relative,
            ..Question::default()
        };
        let (query, mut budget) = (asked.query(a, b, pose), 1_000);
        let mut pieces = || {
            budget *= 2;
            budget
        };
        let cut = run_in_pieces(&query, &mut workspace, &mut pieces, |said, _| {
            assert_near(said, distance, rounding);
        });
        let with_memory = run_with_memory(&query, &mut workspace, memory, ENOUGH);
        for said in [cut, with_memory] {
            assert_near(&said, distance, rounding);
            let Bounds { low, high, .. } = said.value;
            assert_eq!(said.stop, StopReason::Finished);
            assert_eq!(high == 0.0, distance == 0.0, "{said:?}");
            let tolerance = (relative * low).max(1e-6 * size) + rounding;
            assert!(high - low <= tolerance, "{said:?}");
        }
    }
    for share in [0.5, 0.9, 1.1] {
        let said = answer(&Question::closer_than(share * distance).query(a, b, pose));
        assert_near(&said, distance, rounding);
        let is_right = said.value.closer == Some(share > 1.0 || distance == 0.0);
        assert!(is_right || distance < 20.0 * rounding, "{share} {said:?}");
    }
}

fn assert_case(folder: &Path, stride: usize) {
    println!("{}", folder.display());
    let case = files::text(&folder.join("case.txt"));
    let mut trees = HashMap::new();
    let names = [("a", "a.obj"), ("b", "b.obj")]
        .map(|(key, file)| files::value(&case, key).unwrap_or(file));
    for name in names {
        trees
            .entry(name)
            .or_insert_with(|| Tree::new(Soup::read(&folder.join(name)).mesh().unwrap()));
    }
    let [a, b] = names.map(|name| &trees[name]);
    let poses = files::poses(&folder.join("poses.txt"));
    let truths = distances(&folder.join("truth_distance.csv"));
    assert_eq!(poses.len(), truths.len());
    let mut memory = PairMemory::new();
    for (pose, distance) in poses.into_iter().zip(truths).step_by(stride) {
        assert_pose(a, b, pose.unwrap(), distance, &mut memory);
    }
}

#[test]
fn cases_of_this_repository() {
    let parent = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/meshes");
    for name in [
        "all_degenerate_both",
        "single_triangle",
        "single_vs_mesh",
        "touch_vertex",
    ] {
        assert_case(&parent.join(name), 1);
    }
}

fn assert_kind(kind: &str) {
    let Some(shared) = files::shared("meshes/cases") else {
        return;
    };
    let mut cases = files::folders(&shared, kind);
    cases.retain(|folder| {
        ["", ".gz"]
            .iter()
            .any(|end| folder.join(format!("truth_distance.csv{end}")).is_file())
    });
    assert!(!cases.is_empty(), "no case of kind {kind}");
    let all = std::env::var_os("PUNCTUAL_ALL_CASES").is_some_and(|value| value == "1");
    for folder in cases {
        assert_case(&folder, if all { 1 } else { STRIDE });
    }
}

macro_rules! kinds {
    ($($name:ident: $prefix:literal,)*) => {
        $(#[test] fn $name() { assert_kind($prefix); })*
    };
}

kinds! {
    clear_of_each_other: "clear_",
    near_contact: "contact_",
    grazing: "graze_",
    tilted_in_the_file: "tilted_",
    at_depths_of_overlap: "delta_",
    along_paths: "path_",
}
