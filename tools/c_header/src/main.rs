//! Writes `include/punctual.h` from `crates/capi/src`, or with `--check` tells whether it is current.
//!
//! `cargo run --manifest-path tools/c_header/Cargo.toml [-- --check]`

use cbindgen::{Builder, Config, DocumentationStyle, Language, RenameRule};
use std::path::Path;
use std::process::ExitCode;
use std::{env, error::Error, fs};

/// In the order of the header.
const SOURCES: [&str; 22] = [
    "status",
    "pose",
    "mesh",
    "shapes",
    "triangles",
    "tree",
    "workspace",
    "memory",
    "clock",
    "query",
    "outcome",
    "distance",
    "motion",
    "estimate",
    "contacts",
    "push_out",
    "rays",
    "patches",
    "body",
    "scene",
    "scene_answers",
    "scene_groups",
];

/// Enumerations that are passed as numbers, since C may pass any.
const NUMBERS: [&str; 9] = [
    "punctual_format",
    "punctual_effort",
    "punctual_mode",
    "punctual_pair_question",
    "punctual_ray_mode",
    "punctual_order",
    "punctual_budget_kind",
    "punctual_body_kind",
    "punctual_reach",
];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let manifest = fs::read_to_string(root.join("Cargo.toml"))?;
    let version = version(&manifest)?;
    let mut config = Config {
        language: Language::C,
        cpp_compat: true,
        usize_is_size_t: true,
        no_includes: true,
        sys_includes: ["stdbool.h", "stddef.h", "stdint.h"].map(String::from).to_vec(),
        include_guard: Some("PUNCTUAL_H".into()),
        documentation_style: DocumentationStyle::Doxy,
        line_length: 120,
        header: Some(include_str!("head.txt").trim_end().into()),
        after_includes: Some(format!("\n/** The version of this header. */\n#define PUNCTUAL_VERSION \"{version}\"")),
        ..Config::default()
    };
    config.enumeration.rename_variants = RenameRule::QualifiedScreamingSnakeCase;
    config.export.include = NUMBERS.map(String::from).to_vec();
    let mut builder = Builder::new().with_config(config);
    for source in SOURCES {
        builder = builder.with_src(root.join("crates/capi/src").join(source).with_extension("rs"));
    }
    let mut new = Vec::new();
    builder.generate()?.write(&mut new);

    let path = root.join("include/punctual.h");
    if env::args().nth(1).as_deref() != Some("--check") {
        fs::write(path, new)?;
    } else if fs::read(path).ok() != Some(new) {
        eprintln!("include/punctual.h is not current: cargo run --manifest-path tools/c_header/Cargo.toml");
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}

/// That of the library.
fn version(manifest: &str) -> Result<&str, &'static str> {
    let mut lines = manifest.lines();
    let line = lines.find_map(|line| line.strip_prefix("version = \"")).ok_or("Cargo.toml has no version")?;
    Ok(line.trim_end_matches('"'))
}
