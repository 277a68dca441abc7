//! The layers of the source: questions (`src/query`) stand on what they share (`src/engine`).

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The only files of the engine that name a question: the workspace holds the states of all
/// questions, a certificate the substeps of a motion left, a memory the ids of manifolds.
const UPWARDS: [&str; 3] = ["certificate.rs", "identity.rs", "workspace.rs"];

/// Maximum number of modules in one folder.
const WIDEST: usize = 15;

fn modules(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder of the repository");
    entries
        .map(|entry| entry.expect("an entry").path())
        .collect()
}

/// Calls `see` with each source file below a folder, and checks the width of each folder.
fn walk(folder: &Path, see: &mut impl FnMut(&Path)) {
    let modules = modules(folder);
    let names: BTreeSet<_> = modules.iter().map(|path| path.with_extension("")).collect();
    assert!(
        names.len() <= WIDEST,
        "{} has {} modules",
        folder.display(),
        names.len()
    );
    for path in modules {
        if path.is_dir() {
            walk(&path, see)
        } else {
            see(&path)
        }
    }
}

#[test]
fn folders_are_narrow_and_the_engine_names_no_question() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut upwards = BTreeSet::new();
    walk(&source.join("engine"), &mut |file| {
        let text = fs::read_to_string(file).expect("a text");
        let mut code = text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        if code.any(|line| line.contains("crate::query")) {
            let name = file.file_name().expect("a name").to_string_lossy();
            upwards.insert(name.into_owned());
        }
    });
    walk(&source.join("query"), &mut |_| {});
    assert_eq!(upwards, BTreeSet::from(UPWARDS.map(String::from)));
}
