//! The C++ wrapper and the tests in C and Rust have every function of the header. What the functions do is tested by
//! `capi.rs` and, through the C compiler, by `.ci/c`, which also makes the header anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn read(file: &str) -> String {
    fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .join(file),
    )
    .unwrap()
}

/// Names that begin with `punctual_` and are called, or handed to a macro that calls them; outside comments.
fn calls(source: &str) -> BTreeSet<String> {
    let code = source
        .lines()
        .filter(|line| !line.trim_start().starts_with(['*', '/']));
    let mut names = BTreeSet::new();
    for line in code {
        for (at, _) in line.match_indices("punctual_") {
            let name: String = line[at..]
                .chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            if line[at + name.len()..].starts_with(['(', '<', ',']) {
                names.insert(name);
            }
        }
    }
    names
}

/// All files of a folder, one after the other.
fn read_all(folder: &str) -> String {
    let files = fs::read_dir(
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .join(folder),
    )
    .unwrap();
    files
        .map(|file| fs::read_to_string(file.unwrap().path()).unwrap())
        .collect()
}

/// What callers call: the functions of the header, but an `_init` by the function there that calls it.
fn callable() -> BTreeSet<String> {
    let header = calls(&read("include/punctual.h"));
    assert!(header.len() > 150, "{}", header.len());
    header
        .into_iter()
        .filter(|name| !name.ends_with("_init"))
        .collect()
}

#[test]
fn every_function_is_called_from_c() {
    let called = calls(
        &["calls", "rays", "robots", "scene_calls", "versions"]
            .map(|file| read(&format!("crates/capi/tests/c/{file}.c")))
            .concat(),
    );
    assert_eq!(callable().difference(&called).collect::<Vec<_>>(), [""; 0]);
}

#[test]
fn every_function_is_called_from_rust() {
    let called = calls(&(read("crates/capi/tests/capi.rs") + &read_all("crates/capi/tests/capi")));
    assert_eq!(callable().difference(&called).collect::<Vec<_>>(), [""; 0]);
}

#[test]
fn every_function_is_wrapped_for_cpp() {
    let wrapper = read("include/punctual.hpp");
    // Most are passed by name.
    let missing = |name: &&String| {
        !["(", ")", ",", ">"]
            .iter()
            .any(|end| wrapper.contains(&format!("{name}{end}")))
    };
    let but = ["punctual_version"].map(String::from);
    assert_eq!(
        callable().iter().filter(missing).collect::<Vec<_>>(),
        but.iter().collect::<Vec<_>>()
    );
}

/// What a caller in Rust must promise, it promises by `unsafe`: an array is as long as said, a clock can be called.
#[test]
fn functions_that_trust_the_caller_are_unsafe() {
    let source = read_all("crates/capi/src");
    let introductions = ["fn", "make", "change"].map(|word| format!(" {word} punctual_"));
    let found = introductions
        .iter()
        .flat_map(|word| source.match_indices(word.as_str()));
    for (at, _) in found {
        let signature = source[at..].split(['{', '=']).next().unwrap();
        let trusts = [": *const", ": *mut", "Option<&punctual_clock>"];
        assert_eq!(
            source[..at]
                .trim_end_matches(" extern \"C\"")
                .ends_with("unsafe"),
            trusts.iter().any(|kind| signature.contains(kind)),
            "{signature}"
        );
    }
}

#[test]
fn the_header_has_the_version_of_the_library() {
    let line = format!("#define PUNCTUAL_VERSION \"{}\"", env!("CARGO_PKG_VERSION"));
    assert!(
        read("include/punctual.h")
            .lines()
            .any(|found| found == line),
        "no line {line}"
    );
}
