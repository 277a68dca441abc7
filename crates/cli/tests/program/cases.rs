//! Mesh cases with exact truth: the few in this repository, and all of them where the folder beside it exists.

use std::path::Path;

use crate::files::{Truth, text, truth, value};
use crate::run::{Answer, Folder, Row};

/// Compares both modes with the truth of a case, where `expect` asks for it.
fn check_case(case: &Path) {
    let name = case.display();
    let expect = text(&case.join("case.txt"));
    let expect = value(&expect, "expect").unwrap();
    let truth = truth(&case.join("truth.csv"));
    for mode in ["any", "all"] {
        let files = ["a.obj", "b.obj", "poses.txt"].map(|file| case.join(file));
        let folder = Folder::new();
        let mut command = folder.command(&format!("pair --mode {mode}"));
        let answer = Answer::new(&command.args(files).output().unwrap());
        if answer.status == 2 {
            assert!(expect.contains("error"), "{name}: {}", answer.err);
            answer.assert_refused(&[".obj"]);
            continue;
        }
        let rows = answer.rows();
        assert_eq!(rows.len(), truth.len(), "{name}");
        assert_eq!(answer.status, i32::from(rows.iter().any(Row::is_error)));
        for (pose, (row, truth)) in rows.iter().zip(&truth).enumerate() {
            let allowed = match truth {
                _ if row.is_error() => expect.contains("error"),
                Truth::Invalid => false,
                Truth::Pairs(pairs) => {
                    let count = if mode == "any" { -1 } else { *pairs as i64 };
                    expect.contains("truth")
                        && (row.hit == "1") == (*pairs > 0)
                        && row.pairs == count
                }
            };
            assert!(allowed, "{name} {pose} {mode} {row:?} {truth:?} {expect}");
        }
    }
}

#[test]
fn hard_cases_are_answered_or_refused_as_expected() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let shared = root.join("../shared/hardcases/meshes");
    for folder in [root.join("tests/fixtures/meshes"), shared]
        .into_iter()
        .filter(|folder| folder.is_dir())
    {
        let mut cases = 0;
        for case in std::fs::read_dir(folder).unwrap() {
            check_case(&case.unwrap().path());
            cases += 1;
        }
        assert!(cases > 0);
    }
}
