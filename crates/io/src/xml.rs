//! What readers of XML share: elements, attributes and numbers, with the line of what is wrong.

use std::collections::HashMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};

use crate::ReadError;
use crate::text::{decode, without_late_declaration};

/// A fault of a file, which is not named.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The line, counted from 1, if the fault has one place.
    pub line: Option<u32>,
    /// What is wrong.
    pub what: String,
    /// Why the system did not open a file; `None` if the content is at fault.
    pub kind: Option<ErrorKind>,
}

impl Fault {
    /// A fault of an element.
    pub fn at(node: Node<'_, '_>, what: impl Into<String>) -> Self {
        Self {
            line: Some(line(node)),
            what: what.into(),
            kind: None,
        }
    }
}

impl From<Fault> for ReadError {
    fn from(Fault { line, what, .. }: Fault) -> Self {
        match line {
            Some(line) => Self::at_line(line as usize, what),
            None => Self::new(what),
        }
    }
}

/// Reads a file, of which something is made.
///
/// # Errors
/// If the file cannot be opened, is no XML, or what is made of it fails.
pub fn read<T, E: From<Fault>>(
    file: &Path,
    make: impl FnOnce(Node<'_, '_>) -> Result<T, E>,
) -> Result<T, E> {
    let bytes = fs::read(file).map_err(|error| Fault {
        line: None,
        what: error.to_string(),
        kind: Some(error.kind()),
    })?;
    let text = decode(&bytes);
    let text = without_late_declaration(&text);
    let document = Document::parse(&text).map_err(|error| Fault {
        line: Some(error.pos().row),
        what: error.to_string(),
        kind: None,
    })?;
    make(document.root_element())
}

/// The line of an element, counted from 1.
pub fn line(node: Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

/// The first child of this name.
pub fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|node| node.has_tag_name(name))
}

/// An attribute.
///
/// # Errors
/// If it is missing.
pub fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, Fault> {
    let missing = || {
        Fault::at(
            node,
            format!("`{}` without `{name}`", node.tag_name().name()),
        )
    };
    node.attribute(name).map(str::trim).ok_or_else(missing)
}

/// Largest number that an attribute may have.
const LARGEST: f64 = 1e30;

/// The numbers of an attribute, or their defaults if it is missing.
///
/// # Errors
/// If it is missing and has no defaults; for other numbers than asked, or one beyond 1e30.
pub fn numbers<const N: usize>(
    node: Node<'_, '_>,
    name: &str,
    missing: Option<[f64; N]>,
) -> Result<[f64; N], Fault> {
    if let (None, Some(missing)) = (node.attribute(name), missing) {
        return Ok(missing);
    }
    let text = attribute(node, name)?;
    let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    let fits = |numbers: &[f64; N]| numbers.iter().all(|x| x.abs() <= LARGEST);
    numbers.filter(fits).ok_or_else(|| {
        let must = format!("must be {N} numbers of at most {LARGEST:e}");
        Fault::at(node, format!("`{name}` is \"{text}\", {must}"))
    })
}

/// The number of an attribute, or its default if it is missing.
///
/// # Errors
/// Those of [`numbers`].
pub fn number(node: Node<'_, '_>, name: &str, missing: Option<f64>) -> Result<f64, Fault> {
    numbers(node, name, missing.map(|number| [number])).map(|[number]| number)
}

/// The elements that were passed over, with their lines.
#[derive(Debug, Default)]
pub struct Notices(Vec<(u32, String)>);

impl Notices {
    /// Notes something about an element.
    pub fn add(&mut self, node: Node<'_, '_>, what: String) {
        self.0.push((line(node), what));
    }

    /// Notes children that are not known, the first of each kind. `of` names their parent.
    pub fn pass_over(&mut self, parent: Node<'_, '_>, of: &str, is_known: impl Fn(&str) -> bool) {
        let place = parent.tag_name().name();
        for node in parent.children().filter(Node::is_element) {
            let tag = node.tag_name().name();
            let what = format!("`{tag}` in a `{place}` is passed over");
            if !is_known(tag) && !self.0.iter().any(|(_, told)| told.ends_with(&what)) {
                self.add(node, format!("{of}{what}"));
            }
        }
    }

    /// A line for each, which begins with the file.
    pub fn of_file(self, file: &Path) -> impl Iterator<Item = String> {
        let told = |(line, what)| format!("{}:{line}: {what}", file.display());
        self.0.into_iter().map(told)
    }
}

/// Levels of folders in which packages are sought by their `package.xml`.
const DEEPEST: usize = 5;

/// The files that a file of a robot names.
#[derive(Debug)]
pub struct Packages<'o> {
    folder: &'o Path,
    folders: &'o [PathBuf],
    /// The folders of packages that were sought by their `package.xml`.
    named: HashMap<String, Vec<PathBuf>>,
}

impl<'o> Packages<'o> {
    /// Those named by a file in a folder, with other folders in which packages are sought.
    pub fn new(folder: &'o Path, folders: &'o [PathBuf]) -> Self {
        let named = HashMap::new();
        Self {
            folder,
            folders,
            named,
        }
    }

    /// The file of a name: a path below the folder of the file that has the name, or a URL. In
    /// `package://arm/hand.stl` the package is a folder in which there is `arm/hand.stl`, or one
    /// named `arm` with `hand.stl`: one of the other folders, the folder of the file, or one above
    /// it. Then comes each folder whose `package.xml` has the name `arm`.
    ///
    /// # Errors
    /// If there is no such package.
    pub fn find(&mut self, name: &str) -> Result<PathBuf, Fault> {
        let mut kinds = ["package://", "model://"].iter();
        let Some(path) = kinds.find_map(|kind| name.strip_prefix(kind)) else {
            let path = name.strip_prefix("file://").unwrap_or(name);
            return Ok(self.folder.join(path));
        };
        let (package, rest) = path.split_once('/').unwrap_or(("", path));
        let folder = fs::canonicalize(self.folder).unwrap_or(self.folder.to_owned());
        let packages = self.folders.iter().map(PathBuf::as_path);
        let path = path.trim_start_matches('/');
        for folder in packages.chain(folder.ancestors()) {
            let is_package = folder.file_name().is_some_and(|name| name == package);
            let within = is_package.then(|| folder.join(rest));
            let mut files = [folder.join(path)].into_iter().chain(within);
            if let Some(file) = files.find(|file| file.is_file()) {
                return Ok(file);
            }
        }
        let named = self.named.entry(package.to_owned()).or_insert_with(|| {
            let mut found = Vec::new();
            for folder in self.folders {
                add_packages(package, folder, DEEPEST, &mut found);
            }
            for folder in folder.ancestors() {
                add_packages(package, folder, 1, &mut found);
            }
            found
        });
        let mut files = named.iter().map(|folder| folder.join(rest));
        files.find(|file| file.is_file()).ok_or_else(|| {
            let sought = "not found in the package folders, nor in those above the URDF file";
            let what = format!("mesh {name}: {sought}, by folder or package.xml");
            let (line, kind) = (None, Some(ErrorKind::NotFound));
            Fault { line, what, kind }
        })
    }
}

/// Adds the folders whose `package.xml` has this name, down to some levels below a folder. As in
/// ROS, there are no packages within packages.
fn add_packages(package: &str, folder: &Path, levels: usize, found: &mut Vec<PathBuf>) {
    let name = |root: Node<'_, '_>| {
        let name = child(root, "name").and_then(|name| name.text());
        Ok::<_, Fault>(name.map(|name| name.trim().to_owned()))
    };
    let file = folder.join("package.xml");
    match read(&file, name) {
        Ok(name) if name.as_deref() == Some(package) => return found.push(folder.to_owned()),
        Err(Fault { kind: Some(_), .. }) => {}
        _ => return,
    }
    let Some(below) = levels.checked_sub(1) else {
        return;
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut folders: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    folders.retain(|path| path.is_dir());
    folders.sort_unstable();
    for folder in folders {
        add_packages(package, &folder, below, found);
    }
}
