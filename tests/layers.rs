//! Who may import whom inside the library, and that no files of a folder import each other in a circle. What the crates
//! around
//! the library may see, Cargo enforces.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Each module and what it may import.
const ARROWS: [(&str, &[&str]); 11] = [
    ("math", &[]),
    ("names", &[]),
    ("mesh", &["math"]),
    ("tree", &["math", "names", "mesh"]),
    ("triangle", &["math"]),
    ("contact", &["math", "mesh", "tree", "triangle"]),
    ("model", &["math"]),
    (
        "query",
        &[
            "math", "names", "mesh", "tree", "triangle", "contact", "model",
        ],
    ),
    ("push_out", &["math", "tree", "triangle", "model", "query"]),
    (
        "scene",
        &[
            "math", "names", "mesh", "tree", "triangle", "contact", "model", "query",
        ],
    ),
    ("internals", &["math", "model", "query"]),
];

/// The sources of a module.
fn files(module: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("src")
        .join(module);
    let (mut folders, mut files) = (vec![folder.clone()], vec![folder.with_extension("rs")]);
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(folder)
            .into_iter()
            .flatten()
            .map(|entry| entry.unwrap().path());
        let (more, sources): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
        folders.extend(more);
        files.extend(sources);
    }
    files.retain(|file| file.is_file());
    files
}

/// The code of a file; comments and unit tests are no code.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap();
    let code = text
        .split("#[cfg(test)]\nmod tests {")
        .next()
        .unwrap_or_default();
    code.lines()
        .flat_map(|line| line.split("//").next())
        .flat_map(|line| [line, "\n"])
        .collect()
}

/// The paths that follow `prefix` in the code of a file, without what is in braces.
fn imports(file: &Path, prefix: &str) -> BTreeSet<String> {
    let of_path = |c: &char| c.is_alphanumeric() || "_:".contains(*c);
    code(file)
        .split(prefix)
        .skip(1)
        .map(|rest| rest.chars().take_while(of_path).collect())
        .collect()
}

#[test]
fn every_import_follows_an_arrow() {
    let mut seen = 0;
    for (module, allowed) in ARROWS {
        for file in files(module) {
            for path in imports(&file, "crate::") {
                let import = path.split("::").next().unwrap();
                if import == module || ARROWS.iter().all(|(other, _)| *other != import) {
                    continue;
                }
                assert!(
                    allowed.contains(&import),
                    "{} must not import {import}",
                    file.display()
                );
                seen += 1;
            }
        }
    }
    assert!(seen > 50, "{seen} imports: are they still found?");
}

/// The path of a file as a module: `::broad::sort` for `src/scene/broad/sort.rs`, empty for `src/scene/mod.rs`.
fn path_of(module: &str, file: &Path) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("src")
        .join(module);
    let Ok(inside) = file
        .with_extension("")
        .strip_prefix(root)
        .map(Path::to_owned)
    else {
        return String::new();
    };
    let names = inside
        .iter()
        .map(|name| name.to_str().unwrap())
        .filter(|name| *name != "mod");
    names.flat_map(|name| ["::", name]).collect()
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut seen = 0;
    for (module, _) in ARROWS {
        let files: BTreeMap<String, PathBuf> = files(module)
            .into_iter()
            .map(|file| (path_of(module, &file), file))
            .collect();
        let mut left = BTreeMap::new();
        for (path, file) in files.iter().filter(|(path, _)| !path.is_empty()) {
            let above = path.rsplit_once("::").unwrap().0;
            let inside = if file.ends_with("mod.rs") {
                imports(file, "\nuse ")
            } else {
                BTreeSet::new()
            };
            let all = (imports(file, " super::")
                .into_iter()
                .map(|name| format!("{above}::{name}")))
            .chain(imports(file, &format!("crate::{module}")))
            .chain(inside.into_iter().map(|name| format!("{path}::{name}")));
            // The longest beginning that is a file; the head of its own folder may be used by any file.
            let ends = |import: &str| {
                import
                    .match_indices("::")
                    .map(|(at, _)| at)
                    .chain([import.len()])
                    .collect::<Vec<_>>()
            };
            let file = |import: String| {
                ends(&import)
                    .into_iter()
                    .rev()
                    .map(|end| import[..end].to_owned())
                    .find(|name| files.contains_key(name))
            };
            let imports: BTreeSet<String> = all
                .flat_map(file)
                .filter(|name| name != path && name != above)
                .collect();
            seen += imports.len();
            left.insert(path.clone(), imports);
        }
        // Take away what imports nothing that is left; a circle cannot be taken away.
        let mut before = usize::MAX;
        while left.len() < before {
            before = left.len();
            let names: BTreeSet<String> = left.keys().cloned().collect();
            left.retain(|_, imports| imports.iter().any(|import| names.contains(import)));
        }
        assert!(
            left.is_empty(),
            "{module}: these import each other in a circle: {left:#?}"
        );
    }
    assert!(seen > 200, "{seen} imports: are they still found?");
}
