//! Who may import whom inside the library, and that no files of a folder import each other in a circle. What the crates around
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
    ("query", &["math", "names", "mesh", "tree", "triangle", "contact", "model"]),
    ("push_out", &["math", "tree", "triangle", "model", "query"]),
    ("scene", &["math", "names", "mesh", "tree", "triangle", "contact", "model", "query"]),
    ("internals", &["math", "model", "query"]),
];

/// The sources of a module.
fn files(module: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(module);
    let (mut folders, mut files) = (vec![folder.clone()], vec![folder.with_extension("rs")]);
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
        let (more, sources): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
        folders.extend(more);
        files.extend(sources);
    }
    files.retain(|file| file.is_file());
    files
}

/// The names that follow `prefix` in the code, one or several in braces; comments and unit tests are no code.
fn imports(file: &Path, prefix: &str) -> BTreeSet<String> {
    let text = fs::read_to_string(file).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let code: String = code.lines().flat_map(|line| line.split("//").next()).collect();
    let name = |part: &str| part.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let names = |rest: &str| match rest.strip_prefix('{') {
        Some(list) => list.split('}').next().unwrap_or_default().split(',').map(name).collect(),
        None => vec![name(rest)],
    };
    code.split(prefix).skip(1).flat_map(names).collect()
}

#[test]
fn every_import_follows_an_arrow() {
    let mut seen = 0;
    for (module, allowed) in ARROWS {
        for file in files(module) {
            let of_modules = |name: &String| ARROWS.iter().any(|(other, _)| other == name && name != module);
            for import in imports(&file, "crate::").into_iter().filter(of_modules) {
                assert!(allowed.contains(&import.as_str()), "{} must not import {import}", file.display());
                seen += 1;
            }
        }
    }
    assert!(seen > 50, "{seen} imports: are they still found?");
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    for (module, _) in ARROWS {
        let stem = |file: &PathBuf| file.file_stem().unwrap().to_str().unwrap().to_owned();
        let alone = files(module).into_iter().filter(|file| file.with_file_name("mod.rs").is_file());
        let mut left: BTreeMap<_, _> = alone.map(|file| (stem(&file), imports(&file, "super::"))).collect();
        left.remove("mod");
        // Take away what imports nothing that is left; a circle cannot be taken away.
        let mut before = usize::MAX;
        while left.len() < before {
            before = left.len();
            let names: BTreeSet<String> = left.keys().cloned().collect();
            left.retain(|file, imports| imports.iter().any(|import| import != file && names.contains(import)));
        }
        assert!(left.is_empty(), "{module}: {:?} import each other in a circle", left.keys());
    }
}
