//! Scanned and CAD meshes near, in and out of contact, against exact truth, if the data is beside the repository.
//!
//! By default some poses of each case; `PUNCTUAL_ALL_CASES=1` takes all of them.

mod common;

use std::collections::HashMap;

use common::check::{ENOUGH, run_to_end};
use common::files::{self, Soup, Truth};
use common::{MODES, ORDERS};
use punctual::{Mode, Pose, Query, StopReason, Tree, Verdict, Workspace};

/// Without the variable every ninth pose is asked: prime to the 7 or 10 offsets of an approach, so all of them are.
const STRIDE: usize = 9;

fn assert_kind(kind: &str) {
    let Some(shared) = files::shared("meshes") else {
        return;
    };
    let cases = files::folders(&shared.join("cases"), kind);
    assert!(!cases.is_empty(), "no case of kind {kind}");
    let mut workspace = Workspace::new();
    let all = std::env::var_os("PUNCTUAL_ALL_CASES").is_some_and(|value| value == "1");
    let stride = if all { 1 } else { STRIDE };
    for folder in cases {
        println!("{}", folder.display());
        let case = files::text(&folder.join("case.txt"));
        let mut trees = HashMap::new();
        let names = ["a", "b"].map(|key| files::value(&case, key).unwrap());
        for name in names {
            let mesh = || Soup::read(&folder.join(name)).mesh().unwrap();
            trees.entry(name).or_insert_with(|| Tree::new(mesh()));
        }
        let [a, b] = names.map(|name| &trees[name]);
        let poses = files::poses(&folder.join("poses.txt"));
        let truths = files::truth(&folder.join("truth.csv"));
        assert_eq!(poses.len(), truths.len());
        for (pose, truth) in poses.into_iter().zip(truths).step_by(stride) {
            let Truth::Pairs(pairs) = truth else {
                panic!("an invalid pose")
            };
            assert_answers(a, b, pose.unwrap(), pairs, &mut workspace);
        }
    }
}

fn assert_answers(a: &Tree, b: &Tree, pose: Pose, pairs: u64, workspace: &mut Workspace) {
    for mode in MODES {
        for order in ORDERS {
            let query = Query::intersection(a, b, pose).mode(mode).order(order);
            let (outcome, found) = run_to_end(&query, workspace, ENOUGH);
            let at = || format!("{mode:?} {order:?} {:?}", pose.to_row_major());
            match outcome.value {
                Verdict::Intersecting { .. } => assert!(pairs > 0, "false hit, {}", at()),
                Verdict::Separated => assert!(pairs == 0, "missed {pairs}, {}", at()),
                Verdict::Within { .. } => panic!("a query without margins"),
                Verdict::Contained { .. } => panic!("surfaces contain nothing"),
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
