//! What the pages name is there: files, and the places that links lead to.

use std::collections::HashSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

const FOLDERS: [&str; 2] = ["docs", "docs/guide"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// The pages of the repository but its notebook, which tells of earlier versions.
fn pages() -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = FOLDERS.iter().map(|folder| root().join(folder)).collect();
    folders.push(root());
    let crates = fs::read_dir(root().join("crates")).unwrap();
    folders.extend(crates.map(|entry| entry.unwrap().path()));
    let files = folders
        .iter()
        .flat_map(|folder| fs::read_dir(folder).unwrap());
    let files = files.map(|entry| entry.unwrap().path());
    let is_page = |file: &PathBuf| {
        file.extension().is_some_and(|extension| extension == "md")
            && !file.ends_with("CHANGELOG.md")
    };
    files.filter(is_page).collect()
}

/// All files below a folder, but what is built.
fn files(folder: &Path, found: &mut HashSet<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap();
        if name == "target" || name == ".git" || path.is_symlink() {
        } else if path.is_dir() {
            files(&path, found);
        } else {
            found.insert(path.strip_prefix(root()).unwrap().to_owned());
        }
    }
}

/// The text without blocks of code.
fn prose(page: &str) -> String {
    page.split("```").step_by(2).collect()
}

/// Words between single backticks that look like a file of the repository.
fn named_files(prose: &str) -> impl Iterator<Item = &str> {
    let words = prose.split('`').skip(1).step_by(2);
    words.filter(|word| {
        let is_source = [".rs", ".py", ".md", ".sh", ".h", ".hpp"]
            .iter()
            .any(|end| word.ends_with(end));
        let begins = ["src/", "crates/", "docs/", "tests/", "benches/", ".ci/"];
        let is_path = begins.iter().any(|start| word.starts_with(start));
        (is_source && word.contains('/') || is_path) && !word.contains([' ', '*', '{'])
    })
}

/// Where links of a page lead: those in line, and those by reference.
fn links(prose: &str) -> impl Iterator<Item = &str> {
    let inline = prose
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next());
    let references = prose.lines().filter(|line| line.starts_with('['));
    inline.chain(references.filter_map(|line| Some(line.split_once("]: ")?.1)))
}

fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(normal.pop()),
            part => normal.push(part),
        }
    }
    normal
}

/// The name that a heading has in links.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().chars();
    let kept = kept.filter(|c| c.is_alphanumeric() || "-_ ".contains(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

#[test]
fn files_that_pages_name_are_there() {
    let mut all = HashSet::new();
    files(&root(), &mut all);
    let mut missing = Vec::new();
    for page in pages() {
        let text = prose(&fs::read_to_string(&page).unwrap());
        let folder = page.parent().unwrap();
        for name in named_files(&text) {
            let is_there = root().join(name).exists() || folder.join(name).exists();
            let ends = |file: &PathBuf| file.ends_with(name);
            if !is_there && !all.iter().any(ends) {
                missing.push(format!("{}: {name}", page.display()));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn links_between_pages_lead_somewhere() {
    let mut broken = Vec::new();
    for page in pages() {
        let text = prose(&fs::read_to_string(&page).unwrap());
        for link in links(&text).filter(|link| !link.contains("://")) {
            let (file, place) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() {
                page.clone()
            } else {
                normal(&page.parent().unwrap().join(file))
            };
            let headings = || {
                let target = fs::read_to_string(&target).unwrap_or_default();
                let target = prose(&target);
                let headings = target.lines().filter(|line| line.starts_with('#'));
                headings.map(anchor).collect::<Vec<_>>()
            };
            if !target.exists() || !place.is_empty() && !headings().contains(&place.to_owned()) {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}
