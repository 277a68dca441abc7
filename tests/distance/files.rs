//! Meshes against distances that were computed elsewhere: a few cases that are always here (in rational arithmetic, as
//! quadratic programs over the faces), and scanned and CAD meshes, if the data is beside the repository.

use std::collections::HashMap;
use std::path::Path;

use punctual::{Budget, PairMemory, Pose, StopReason, Tree, Workspace};

use crate::common::files::{self, Soup};
use crate::distance::{ENOUGH, Question, resume, run, run_with_memory};

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
    assert!(
        lines
            .next()
            .expect("a header")
            .starts_with("pose,distance,")
    );
    lines.enumerate().map(row).collect()
}

/// Bounds of a distance that is known up to its rounding.
#[track_caller]
fn assert_near(said: &punctual::Answer<punctual::distance::Bounds>, distance: f64, rounding: f64) {
    assert!(
        said.value.low <= distance + rounding && distance <= said.value.high + rounding,
        "{said:?}, is {distance:e}"
    );
    assert!(
        said.value.high > 0.0 || distance == 0.0,
        "{said:?}, is {distance:e}"
    );
    assert!(
        said.value.low == 0.0 || distance > 0.0,
        "{said:?}, is {distance:e}"
    );
}

fn assert_pose(
    a: &Tree,
    b: &Tree,
    pose: Pose,
    distance: f64,
    memory: &mut PairMemory,
    workspace: &mut Workspace,
) {
    let size = a.mesh().aabb().extents().max_element()
        + b.mesh().aabb().extents().max_element()
        + distance;
    let rounding = 1e-13 * size;
    for asked in [
        Question::default(),
        Question {
            relative: 1e-2,
            ..Question::default()
        },
    ] {
        let query = asked.query(a, b, pose);
        let mut said = run(&query, workspace, Budget::work(2_000));
        while said.stop == StopReason::WorkLimit {
            assert_near(&said, distance, rounding);
            said = resume(&query, workspace, Budget::work(2 * said.stats.work));
        }
        let with_memory = run_with_memory(&query, workspace, memory, ENOUGH);
        for said in [said, with_memory] {
            assert_near(&said, distance, rounding);
            assert_eq!(
                (said.stop, said.value.high == 0.0),
                (StopReason::Finished, distance == 0.0),
                "{said:?}"
            );
            let tolerance = (asked.relative * said.value.low).max(1e-6 * size) + rounding;
            assert!(
                said.value.high - said.value.low <= tolerance,
                "{said:?}, is {distance:e}"
            );
        }
    }
    for share in [0.5, 0.9, 1.1] {
        let said = run(
            &Question::closer_than(share * distance).query(a, b, pose),
            workspace,
            ENOUGH,
        );
        assert_near(&said, distance, rounding);
        assert!(
            said.value.closer == Some(share > 1.0 || distance == 0.0) || distance < 20.0 * rounding,
            "{share} {said:?}"
        );
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
    let (mut memory, mut workspace) = (PairMemory::new(), Workspace::new());
    for (pose, distance) in poses.into_iter().zip(truths).step_by(stride) {
        assert_pose(a, b, pose.unwrap(), distance, &mut memory, &mut workspace);
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
