//! Writes `include/punctual.h` from `crates/capi/src` behind its macros, or with `--check` tells whether it is current.
//!
//! `cargo run --manifest-path tools/c_header/Cargo.toml [-- --check]`

use cbindgen::{Builder, Config, DocumentationStyle, Language, RenameRule};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::{env, error::Error, fs, iter};

/// The sections of the header, each with the sources that it is made of. What a section needs stands in those before
/// it.
const SECTIONS: [(&str, &[&str]); 18] = [
    ("Errors, and the version", &["status"]),
    ("Points, boxes and poses", &["pose"]),
    ("Meshes", &["mesh", "shapes"]),
    ("Trees", &["tree", "tree_shapes"]),
    ("Two triangles", &["triangles"]),
    ("Budgets and clocks", &["budget"]),
    (
        "Workspaces, and memory from frame to frame",
        &["workspace", "memory"],
    ),
    ("What answers have in common", &["outcome"]),
    (
        "Intersection: do two surfaces meet?",
        &["query", "estimate", "self_intersection"],
    ),
    ("Distance: how far apart are they?", &["distance"]),
    (
        "Contacts: where do they touch?",
        &["contacts", "manifolds", "near_points"],
    ),
    ("Motion: until when are they free?", &["motion"]),
    (
        "Penetration: how deep are they, and what parts them?",
        &["penetration"],
    ),
    ("Rays: what do they hit?", &["rays"]),
    ("Points: are they inside a solid?", &["points"]),
    (
        "Scenes: many bodies, one budget a frame",
        &[
            "body",
            "scene",
            "scene_answers",
            "scene_groups",
            "scene_shapes",
        ],
    ),
    ("Robots: is a motion free?", &["robot", "robot_motion"]),
    ("Calibration: probabilities that learn", &["calibration"]),
];

/// The width of a line.
const WIDTH: usize = 120;

/// Enumerations that are passed as numbers, since C may pass any.
const NUMBERS: [&str; 10] = [
    "punctual_format",
    "punctual_effort",
    "punctual_solid",
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
        documentation_style: DocumentationStyle::Doxy,
        line_length: WIDTH,
        ..Config::default()
    };
    config.enumeration.rename_variants = RenameRule::QualifiedScreamingSnakeCase;
    config.export.include = NUMBERS.map(String::from).to_vec();
    let mut sources = Vec::new();
    for (section, (_, names)) in SECTIONS.iter().enumerate() {
        for name in *names {
            let path = root.join("crates/capi/src").join(name).with_extension("rs");
            sources.push((section, fs::read_to_string(&path)?));
        }
    }
    let expanded = expand(&root)?;
    let mut generated = Vec::new();
    let builder = Builder::new().with_config(config).with_src(expanded);
    builder.generate()?.write(&mut generated);
    let new = arrange(&String::from_utf8(generated)?, &sources, version)?.into_bytes();

    let path = root.join("include/punctual.h");
    if env::args().nth(1).as_deref() != Some("--check") {
        fs::write(path, new)?;
    } else if fs::read(path).ok() != Some(new) {
        eprintln!(
            "include/punctual.h is not current: cargo run --manifest-path tools/c_header/Cargo.toml"
        );
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}

/// A file with the source of the interface as it is behind its macros, which write most functions.
fn expand(root: &Path) -> Result<PathBuf, Box<dyn Error>> {
    // Of its own, since build scripts of other crates heed the variable.
    let target = root.join("target/c_header");
    let mut cargo = Command::new("cargo");
    cargo.current_dir(root).env("CARGO_TARGET_DIR", &target);
    // Stable compilers print what macros became only if told so.
    cargo.env("RUSTC_BOOTSTRAP", "1");
    cargo.args(["rustc", "--quiet", "--package=punctual-capi", "--lib"]);
    cargo.args(["--profile=check", "--", "-Zunpretty=expanded"]);
    let output = cargo.stderr(Stdio::inherit()).output()?;
    if !output.status.success() {
        return Err("the interface does not compile".into());
    }
    let path = target.join("expanded.rs");
    fs::write(&path, output.stdout)?;
    Ok(path)
}

/// That of the library.
fn version(manifest: &str) -> Result<&str, &'static str> {
    let mut lines = manifest.lines();
    let line = lines
        .find_map(|line| line.strip_prefix("version = \""))
        .ok_or("Cargo.toml has no version")?;
    Ok(line.trim_end_matches('"'))
}

/// The header: what was generated, by sections.
fn arrange(generated: &str, sources: &[(usize, String)], version: &str) -> Result<String, String> {
    let mut sections = vec![String::new(); SECTIONS.len()];
    // Each item begins with its comment.
    for item in generated
        .split("\n\n/**")
        .skip(usize::from(!generated.starts_with("/**")))
    {
        // Around all of them, they stand around the whole.
        let item = item.replace(
            "#ifdef __cplusplus\nextern \"C\" {\n#endif // __cplusplus",
            "",
        );
        let item = item.replace(
            "#ifdef __cplusplus\n}  // extern \"C\"\n#endif  // __cplusplus",
            "",
        );
        let item = format!("/**{}", item.trim_start_matches("/**").trim_end());
        let name = name(&item).ok_or_else(|| format!("an item without a name: {item}"))?;
        let defines = |source: &str| source.lines().any(|line| introduces(line, name));
        let source = sources.iter().find(|(_, source)| defines(source));
        let (section, _) = source.ok_or_else(|| format!("no source defines {name}"))?;
        sections[*section] += &format!("{}\n\n", with_constructor(&item, name)?);
    }

    let mut contents = String::new();
    let mut body = String::new();
    for ((number, (title, _)), section) in (1..).zip(&SECTIONS).zip(&sections) {
        if section.is_empty() {
            return Err(format!("nothing in the section {title}"));
        }
        contents += &format!(" * {number:>4}. {title}\n");
        let rule = "-".repeat(WIDTH - 4);
        body += &format!("/* {rule}\n * {number}. {title}\n * {rule} */\n\n{section}");
    }
    let head = include_str!("head.txt")
        .replace(" * @CONTENTS@\n", &contents)
        .replace("@VERSION@", version);
    Ok(format!(
        "{head}\n{body}#ifdef __cplusplus\n}} // extern \"C\"\n#endif\n\n#endif /* PUNCTUAL_H */\n"
    ))
}

/// Whether a line of the source introduces the name: words, and then the name.
fn introduces(line: &str, name: &str) -> bool {
    let words = |text: &str| {
        text.chars()
            .all(|c| c.is_lowercase() || " \"C_".contains(c))
    };
    line.match_indices(name).any(|(at, _)| {
        let ends = !line[at + name.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_');
        ends && line[..at].ends_with(' ') && words(&line[..at])
    })
}

/// What an item declares.
fn name(item: &str) -> Option<&str> {
    let code = item.split_once("*/")?.1;
    let at = code
        .find("PUNCTUAL_")
        .into_iter()
        .chain(code.find("punctual_"))
        .min()?;
    let word = |at: usize| {
        code[at..]
            .split(|c: char| !(c.is_alphanumeric() || c == '_'))
            .next()
    };
    // The name of a function stands behind its type.
    let call = code
        .find('(')
        .filter(|_| !code.trim_start().starts_with(['#', 'e', 't']));
    word(call.map_or(Some(at), |call| {
        code[..call].rfind([' ', '*']).map(|at| at + 1)
    })?)
}

/// The declaration of an `_init`, and the function that makes the struct with it: of the size that the caller knows.
fn with_constructor(item: &str, name: &str) -> Result<String, String> {
    let Some(stem) = name.strip_suffix("_init") else {
        return Ok(item.into());
    };
    let (comment, code) = item.split_once("*/").unwrap_or_default();
    let inside = code
        .split_once('(')
        .and_then(|(_, rest)| rest.rsplit_once(')'))
        .ok_or(name)?
        .0;
    let arguments: Vec<&str> = inside.split(',').map(str::trim).collect();
    let [place, _, given @ ..] = &arguments[..] else {
        return Err(format!("{name} has no size"));
    };
    let named = |argument: &&str| {
        argument
            .rsplit([' ', '*'])
            .next()
            .unwrap_or_default()
            .to_string()
    };
    let (kind, made) = (stem, named(place));
    let new = format!(
        "{stem}_{}",
        if given.is_empty() { "default" } else { "new" }
    );
    let passed: String = given
        .iter()
        .map(|argument| format!(", {}", named(argument)))
        .collect();
    let head = format!("PUNCTUAL_INLINE {kind} {new}(");
    let parameters = if given.is_empty() {
        "void".into()
    } else {
        given.join(", ")
    };
    let one_line = head.len() + parameters.len() + 3 <= WIDTH;
    let indent: String = iter::once('\n')
        .chain(iter::repeat_n(' ', head.len()))
        .collect();
    let parameters = if one_line {
        parameters
    } else {
        given.join(&format!(",{indent}"))
    };
    Ok(format!(
        "/**\n * What `{new}` calls: writes as many bytes as the caller's struct has.\n */{code}\n\n{comment}*/\n\
         {head}{parameters}) {{\n  {kind} {made};\n  {name}(&{made}, sizeof {made}{passed});\n  return {made};\n}}"
    ))
}
