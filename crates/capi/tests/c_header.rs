//! The C header, its C++ wrapper and its test in C have every function of the interface. What the functions do is tested by
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

/// Names that begin with `punctual_` and are followed by `(`, outside comments.
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
            if line[at + name.len()..].starts_with(['(', '<']) {
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

/// The functions that the library exports, from `pub` to the end of their arguments.
fn signatures() -> Vec<String> {
    let source = read_all("crates/capi/src");
    source
        .split("#[unsafe(no_mangle)]")
        .skip(1)
        .map(|item| item.split(['{', ';']).next().unwrap().into())
        .collect()
}

/// Their names.
fn exported() -> BTreeSet<String> {
    let name = |signature: &String| {
        signature
            .split("fn ")
            .nth(1)
            .unwrap()
            .split(['(', '<'])
            .next()
            .unwrap()
            .into()
    };
    signatures().iter().map(name).collect()
}

/// Of an `_init` the function of the header that calls it.
fn constructor(name: &str, header: &BTreeSet<String>) -> Option<String> {
    let stem = name.strip_suffix("_init")?;
    ["_new", "_default"]
        .map(|end| format!("{stem}{end}"))
        .into_iter()
        .find(|name| header.contains(name))
}

/// What callers call: an `_init` as the header does for them.
fn callable() -> BTreeSet<String> {
    let header = calls(&read("include/punctual.h"));
    exported()
        .into_iter()
        .map(|name| constructor(&name, &header).unwrap_or(name))
        .collect()
}

#[test]
fn the_header_declares_every_function() {
    let (exported, header) = (exported(), calls(&read("include/punctual.h")));
    assert!(
        exported.len() > 50,
        "only {} functions: is this the source?",
        exported.len()
    );
    let constructors = exported
        .iter()
        .filter_map(|name| constructor(name, &header));
    let all = exported.iter().cloned().chain(constructors).collect();
    assert_eq!(
        header, all,
        "cargo run --manifest-path tools/c_header/Cargo.toml"
    );
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
    for signature in signatures() {
        let trusts = [": *const", ": *mut", "Option<&punctual_clock>"]
            .iter()
            .any(|kind| signature.contains(kind));
        assert_eq!(
            signature.contains("pub unsafe extern"),
            trusts,
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
