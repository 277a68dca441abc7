//! The folder is the architecture: who may import whom, read from the source.
//!
//! Paths are followed from `crate::` and from every `super::` that reaches the crate root, in `use` lines and in
//! expressions, test modules included. Comments and strings are left out.

use std::fs;
use std::path::{Path, PathBuf};

/// Each module and what it may import. What is not listed does not exist.
const ARROWS: [(&str, &[&str]); 8] = [
    ("math", &[]),
    ("mesh", &["math"]),
    ("tree", &["math", "mesh"]),
    ("triangle", &["math"]),
    ("model", &["math"]),
    ("query", &["math", "mesh", "tree", "triangle", "model"]),
    ("scene", &["math", "mesh", "tree", "triangle", "model", "query"]),
    ("capi", &["math", "mesh", "tree", "triangle", "model", "query", "scene"]),
];

/// Identifiers, `::`, and single other characters.
fn tokens(source: &str) -> Vec<String> {
    let code: Vec<char> = without_comments_and_strings(source).chars().collect();
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < code.len() {
        let start = at;
        at += 1;
        if is_word(code[start]) {
            while at < code.len() && is_word(code[at]) {
                at += 1;
            }
        } else if code[start] == ':' && code.get(at) == Some(&':') {
            at += 1;
        }
        if !code[start].is_whitespace() {
            tokens.push(code[start..at].iter().collect());
        }
    }
    tokens
}

fn without_comments_and_strings(source: &str) -> String {
    let mut code = String::new();
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let skipped = length_without_code(rest);
        if skipped > 0 {
            code.push(' ');
            rest = &rest[skipped..];
        } else {
            code.push(first);
            rest = &rest[first.len_utf8()..];
        }
    }
    code
}

/// The length of the comment, string or character literal that `rest` begins with; 0 if it begins with code.
fn length_without_code(rest: &str) -> usize {
    let through = |end: &str, from: usize| {
        let found = rest[from..].find(end);
        found.map_or(rest.len(), |at| from + at + end.len())
    };
    if rest.starts_with("//") {
        return through("\n", 2);
    }
    if rest.starts_with("/*") {
        return through("*/", 2);
    }
    for (open, close) in [("r#\"", "\"#"), ("r\"", "\"")] {
        if rest.starts_with(open) {
            return through(close, open.len());
        }
    }
    if rest.starts_with('"') {
        let mut escaped = false;
        for (at, c) in rest.char_indices().skip(1) {
            match c {
                '"' if !escaped => return at + 1,
                _ => escaped = c == '\\' && !escaped,
            }
        }
        return rest.len();
    }
    let mut literal = rest.chars();
    match (literal.next(), literal.next(), literal.next()) {
        (Some('\''), Some('\\'), Some(escape)) => through("'", 2 + escape.len_utf8()),
        (Some('\''), Some(c), Some('\'')) => 2 + c.len_utf8(),
        _ => 0,
    }
}

/// The names that follow the crate root, wherever a path of this file starts there or climbs to it.
fn imports_from_root(file: &str, source: &str) -> Vec<String> {
    let home = module_depth(file);
    let tokens = tokens(source);
    let token = |at: usize| tokens.get(at).map_or("", String::as_str);
    let mut inline_modules = Vec::new();
    let mut braces = 0;
    let mut found = Vec::new();
    for at in 0..tokens.len() {
        match token(at) {
            "{" => {
                braces += 1;
                if at >= 2 && token(at - 2) == "mod" {
                    inline_modules.push(braces);
                }
            }
            "}" => {
                inline_modules.retain(|&opened| opened != braces);
                braces -= 1;
            }
            start @ ("crate" | "super") if at == 0 || token(at - 1) != "::" => {
                let depth = home + inline_modules.len();
                let mut next = at + 1;
                let mut climbed = if start == "crate" { depth } else { 1 };
                while token(next) == "::" && token(next + 1) == "super" {
                    climbed += 1;
                    next += 2;
                }
                if climbed >= depth && token(next) == "::" {
                    found.extend(first_names(&tokens[next + 1..]));
                }
            }
            _ => {}
        }
    }
    found
}

/// `a::b` gives a; `{a::b, c::{d, e}}` gives a and c.
fn first_names(tokens: &[String]) -> Vec<String> {
    if tokens.first().is_none_or(|token| token != "{") {
        return tokens.first().cloned().into_iter().collect();
    }
    let mut names = Vec::new();
    let mut depth = 0;
    for pair in tokens.windows(2) {
        match pair[0].as_str() {
            "{" => depth += 1,
            "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            break;
        }
        let starts_item = pair[0] == "," || pair[0] == "{";
        if depth == 1 && starts_item && pair[1] != "}" {
            names.push(pair[1].clone());
        }
    }
    names
}

/// `query/mod.rs` and `capi.rs` are one below the root, `query/queue.rs` two.
fn module_depth(file: &str) -> usize {
    let parts = file.split('/').count();
    if file.ends_with("/mod.rs") { parts - 1 } else { parts }
}

fn top_module(file: &str) -> &str {
    let first = file.split('/').next().unwrap_or(file);
    first.strip_suffix(".rs").unwrap_or(first)
}

/// What is wrong with one file, in words.
fn faults(file: &str, source: &str) -> Vec<String> {
    let module = top_module(file);
    let Some((_, allowed)) = ARROWS.iter().find(|(name, _)| *name == module) else {
        return vec![format!("{file}: `{module}` is not a known module")];
    };
    imports_from_root(file, source)
        .into_iter()
        .filter(|name| name != module && !allowed.contains(&name.as_str()))
        .map(|name| format!("{file}: {module} must not import crate::{name}"))
        .collect()
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

#[test]
fn every_import_follows_an_arrow() {
    let root = src();
    let mut faults_found = Vec::new();
    let mut imports = 0;
    for path in sources(&root) {
        let file = path.strip_prefix(&root).unwrap().to_str().unwrap();
        let file = file.replace('\\', "/");
        // The program is a crate of its own: it sees the library's public face only.
        if file == "lib.rs" || file.starts_with("bin/") {
            continue;
        }
        let source = fs::read_to_string(&path).unwrap();
        imports += imports_from_root(&file, &source).len();
        faults_found.extend(faults(&file, &source));
    }
    assert!(faults_found.is_empty(), "{faults_found:#?}");
    assert!(imports > 10, "only {imports} imports: is this the source?");
}

/// `lib.rs` holds docs, lints, modules and re-exports, and nothing else.
#[test]
fn lib_has_no_logic() {
    let source = fs::read_to_string(src().join("lib.rs")).unwrap();
    assert_eq!(items_with_logic(&source), [""; 0]);
}

fn items_with_logic(source: &str) -> Vec<String> {
    let tokens = tokens(source);
    let mut plain = Vec::new();
    let mut brackets = 0;
    for (at, token) in tokens.iter().enumerate() {
        let next = tokens.get(at + 1).map_or("", String::as_str);
        match token.as_str() {
            "#" if brackets == 0 && (next == "!" || next == "[") => {}
            "!" if brackets == 0 && next == "[" => {}
            "[" => brackets += 1,
            "]" => brackets -= 1,
            other if brackets == 0 => plain.push(other),
            _ => {}
        }
    }
    let is_declaration = |item: &&[&str]| {
        let item = item.strip_prefix(&["pub"]).unwrap_or(item);
        match item {
            ["mod", _] | ["extern", "crate", _] | [] => true,
            ["use", path @ ..] => !path.contains(&"("),
            _ => false,
        }
    };
    plain.split(|&token| token == ";").filter(|item| !is_declaration(item)).map(|item| item.join(" ")).collect()
}

#[test]
fn a_wrong_arrow_is_seen_however_it_is_written() {
    let wrong = [
        ("tree/mod.rs", "use crate::query::Query;"),
        ("tree/wide.rs", "use crate::{math::Aabb, query::{Query, Order}};"),
        ("tree/wide.rs", "fn f() { let a = crate::triangle::exact(); }"),
        ("mesh/mod.rs", "use super::tree::Tree;"),
        ("math/pose.rs", "use super::super::mesh::Mesh;"),
        ("math/pose.rs", "mod tests { use super::super::super::mesh::Mesh; }"),
        ("math/pose.rs", "mod tests { fn f() { let c = '{'; } } use crate::tree::Tree;"),
        ("mesh/mod.rs", "use crate::Pose;"),
        ("model/paper.rs", "use crate::mesh::Mesh;"),
        ("query/mod.rs", "macro_rules! m { () => { $crate::scene::Scene } }"),
        ("helpers/mod.rs", ""),
        ("shortcut.rs", ""),
    ];
    for (file, source) in wrong {
        assert_eq!(faults(file, source).len(), 1, "{file}: {source}");
    }
    let right = [
        ("tree/mod.rs", "use crate::{math::Aabb, mesh::Mesh}; use super::tree::wide;"),
        ("tree/wide.rs", "mod tests { use super::*; use super::super::binary; }"),
        ("math/mod.rs", "// use crate::query::Query;\n/* crate::tree */ /// [`crate::Tree`]\n"),
        ("math/mod.rs", "pub(crate) fn f<'a>(c: &'a str) { g('\"', \"crate::tree\", r\"crate::mesh\"); }"),
        ("query/mod.rs", "use crate::tree::{Tree, node::Node}; use self::queue::Queue;"),
    ];
    for (file, source) in right {
        assert_eq!(faults(file, source), [""; 0], "{source}");
    }
    for logic in ["fn f() {}", "pub mod a { }", "const A: u32 = 1;", "#[test] fn g() {}"] {
        assert_eq!(items_with_logic(logic).len(), 1, "{logic}");
    }
}
