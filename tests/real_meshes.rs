//! Scanned and CAD meshes near, in and out of contact, against exact truth, if the data is beside the repository.
//!
//! By default a few small cases and some of their poses; `PUNCTUAL_ALL_CASES=1` takes all of them.

mod common;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use common::check::run_to_end;
use common::files::{self, Soup, Truth};
use common::{MODES, ORDERS};
use punctual::{Budget, Mode, Pose, Query, StopReason, Tree, Verdict, Workspace};

/// Cases of the quick run, each with the stride that picks its poses.
const QUICK: [(&str, usize); 10] = [
    ("coincident_tray", 4),
    ("contact_env_rob", 3),
    ("contact_imu_imu", 7),
    ("contact_tray_stand", 5),
    ("delta_crank1k", 5),
    ("graze_env_rob", 2),
    ("graze_tray_tray", 3),
    ("path_bolt_in_nut", 31),
    ("path_env_rob_sweep", 17),
    ("tilted_env_rob", 5),
];

/// The names of all cases of a kind, or of the quick ones, with their strides.
fn cases(parent: &Path, kind: &str) -> Vec<(PathBuf, usize)> {
    let all = std::env::var_os("PUNCTUAL_ALL_CASES").is_some_and(|value| value == "1");
    let stride = |name: &str| match QUICK.iter().find(|(quick, _)| *quick == name) {
        _ if all => Some(1),
        quick => quick.map(|(_, stride)| *stride),
    };
    let mut cases: Vec<(PathBuf, usize)> = std::fs::read_dir(parent)
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let stride = name.starts_with(kind).then(|| stride(&name))??;
            Some((entry.path(), stride))
        })
        .collect();
    cases.sort();
    cases
}

fn assert_kind(kind: &str) {
    let Some(shared) = files::shared("meshes") else {
        return;
    };
    let cases = cases(&shared.join("cases"), kind);
    assert!(!cases.is_empty(), "no case of kind {kind}");
    let mut workspace = Workspace::new();
    for (folder, stride) in cases {
        println!("{}", folder.display());
        let case = files::text(&folder.join("case.txt"));
        let mut trees = HashMap::new();
        let mut names = ["a", "b"].map(|key| files::value(&case, key).unwrap());
        for name in names {
            let mesh = || Soup::read(&folder.join(name)).mesh().unwrap();
            trees.entry(name).or_insert_with(|| Tree::new(mesh()));
        }
        let [a, b] = names.each_mut().map(|name| &trees[name]);
        let poses = files::poses(&folder.join("poses.txt"));
        let truths = files::truth(&folder.join("truth.csv"));
        assert_eq!(poses.len(), truths.len());
        for (pose, truth) in poses.into_iter().zip(truths).step_by(stride) {
            let Truth::Pairs(pairs) = truth else { panic!("an invalid pose") };
            assert_answers(a, b, pose.unwrap(), pairs, &mut workspace);
        }
    }
}

fn assert_answers(a: &Tree, b: &Tree, pose: Pose, pairs: u64, workspace: &mut Workspace) {
    for mode in MODES {
        for order in ORDERS {
            let query = Query::new(a, b, pose).mode(mode).order(order);
            let (outcome, found) = run_to_end(&query, workspace, Budget::unlimited());
            let at = || format!("{mode:?} {order:?} {:?}", pose.to_row_major());
            match outcome.verdict {
                Verdict::Intersecting { .. } => assert!(pairs > 0, "false hit, {}", at()),
                Verdict::Separated => assert!(pairs == 0, "missed {pairs}, {}", at()),
                Verdict::Undecided => panic!("undecided after {:?}", outcome.stop),
            }
            if mode == Mode::All {
                assert_eq!(outcome.stop, StopReason::Finished);
                assert_eq!(found.len() as u64, pairs, "{}", at());
            }
        }
    }
}

macro_rules! kinds {
    ($($name:ident: $prefix:literal,)*) => {
        $(#[test] fn $name() { assert_kind($prefix); })*
    };
}

kinds! {
    near_contact: "contact_",
    grazing: "graze_",
    tilted_in_the_file: "tilted_",
    at_depths_of_overlap: "delta_",
    coincident: "coincident_",
    along_paths: "path_",
}
