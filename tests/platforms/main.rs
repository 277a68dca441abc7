//! The same bits on every platform: hashes of answers against those of a file, which holds for all of them.
//!
//! `.ci/platforms` runs this test by an emulator for others than the one at hand. After a change that is meant to give
//! other
//! answers, `PUNCTUAL_BLESS=1 cargo test --test platforms` writes the file anew.

extern crate alloc;

mod answers;
mod questions;

use punctual::Workspace;
use std::path::Path;

#[test]
fn answers_are_those_of_all_platforms() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/platforms.txt");
    let mut workspace = Workspace::new();
    let answers = answers::answers(&workspace);
    if std::env::var_os("PUNCTUAL_BLESS").is_some() {
        std::fs::write(&path, &answers).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap();
    assert_same(&answers, &expected);
    workspace.use_portable_kernels();
    assert_same(&answers::answers(&workspace), &expected);
}

fn assert_same(answers: &str, expected: &str) {
    let differ: Vec<_> = answers
        .lines()
        .zip(expected.lines())
        .filter(|(ours, theirs)| ours != theirs)
        .collect();
    assert!(differ.is_empty(), "{differ:#?}");
    assert_eq!(answers.lines().count(), expected.lines().count());
}
