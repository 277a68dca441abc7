//! The folder is the architecture: who may import whom, and that no files import each other in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Each module and what it may import.
const ARROWS: [(&str, &[&str]); 9] = [
    ("math", &[]),
    ("names", &[]),
    ("mesh", &["math"]),
    ("tree", &["math", "names", "mesh"]),
    ("triangle", &["math"]),
    ("model", &["math"]),
    ("query", &["math", "names", "mesh", "tree", "triangle", "model"]),
    ("scene", &["math", "names", "mesh", "tree", "triangle", "model", "query"]),
    ("internals", &["math", "model"]),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The code of a file, without comments and unit tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// The names that follow `prefix`, one or several in braces.
fn names_after(code: &str, prefix: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for rest in code.split(prefix).skip(1) {
        let list = rest.strip_prefix('{').map_or(&rest[..rest.len().min(60)], |list| list.split("};").next().unwrap());
        let parts = list.split(',').take(if rest.starts_with('{') { usize::MAX } else { 1 });
        for part in parts {
            let name: String = part.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            names.insert(name);
        }
    }
    names
}

#[test]
fn every_import_follows_an_arrow() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let modules: Vec<&str> = ARROWS.iter().map(|(module, _)| *module).collect();
    let mut files = Vec::new();
    sources(&root, &mut files);
    let mut seen = 0;
    for file in &files {
        let inside = file.strip_prefix(&root).unwrap();
        let module = inside.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs");
        let Some((_, allowed)) = ARROWS.iter().find(|(name, _)| *name == module) else {
            assert_eq!(module, "lib", "not a known module");
            continue;
        };
        for import in names_after(&code(file), "crate::").iter().filter(|name| modules.contains(&name.as_str())) {
            assert!(import == module || allowed.contains(&import.as_str()), "{inside:?} must not import {import}");
            seen += usize::from(import != module);
        }
    }
    assert!(seen > 50, "{seen} imports: are they still found?");
}

/// Files of one folder, and which of the others each imports.
#[test]
fn no_files_import_each_other_in_a_circle() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (module, _) in ARROWS.iter().filter(|(module, _)| root.join(module).is_dir() && *module != "tree") {
        let mut imports: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for entry in fs::read_dir(root.join(module)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            if path.is_file() && name != "mod" {
                imports.insert(name, names_after(&code(&path), "super::"));
            }
        }
        // Take away what imports nothing that is left; a circle cannot be taken away.
        loop {
            let left: BTreeSet<String> = imports.keys().cloned().collect();
            let free =
                |(file, of): &(&String, &BTreeSet<String>)| of.iter().all(|name| name == *file || !left.contains(name));
            let done: Vec<String> = imports.iter().filter(free).map(|(file, _)| file.clone()).collect();
            if done.is_empty() {
                break;
            }
            done.iter().for_each(|file| drop(imports.remove(file)));
        }
        assert!(imports.is_empty(), "{module}: {:?} import each other in a circle", imports.keys());
    }
}
