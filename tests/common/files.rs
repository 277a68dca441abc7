//! Readers for the case folders: OBJ (`v` and `f` lines), poses, truth, `key=value` files.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use punctual::{Mesh, MeshError, Pose, PoseError};

/// A folder beside the repository with more data; tests that want it pass without it.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new("shared").join(name);
    let mut above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().skip(1);
    let folder = above.find_map(|above| Some(above.join(&path)).filter(|folder| folder.is_dir()));
    if folder.is_none() {
        println!("skipped: no ../{}", path.display());
    }
    folder
}

/// The folders in `parent` whose names begin with `kind`, sorted.
pub fn folders(parent: &Path, kind: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(parent).unwrap();
    let mut folders: Vec<_> = entries
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.file_name().to_str().unwrap().starts_with(kind))
        .map(|entry| entry.path())
        .collect();
    folders.sort();
    folders
}

/// The text of a file, or of the same file with `.gz` at its end.
pub fn text(path: &Path) -> String {
    if let Ok(text) = fs::read_to_string(path) {
        return text;
    }
    let packed = PathBuf::from(format!("{}.gz", path.display()));
    let file = fs::File::open(&packed)
        .unwrap_or_else(|error| panic!("{} or .gz: {error}", path.display()));
    let mut text = String::new();
    flate2::read::GzDecoder::new(file)
        .read_to_string(&mut text)
        .unwrap();
    text
}

/// The value of `key=value` in a case file.
pub fn value<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    text.lines()
        .find_map(|line| line.strip_prefix(key)?.strip_prefix('='))
}

/// The numbers of an OBJ file, before a mesh has judged them.
pub struct Soup {
    pub vertices: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Soup {
    pub fn read(path: &Path) -> Self {
        let text = text(path);
        let mut soup = Self {
            vertices: Vec::new(),
            triangles: Vec::new(),
        };
        for line in text.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => soup.vertices.push(three(words.map(number))),
                Some("f") => soup.triangles.push(three(words.map(index))),
                _ => {}
            }
        }
        soup
    }

    /// The mesh with every bit of the file.
    pub fn mesh(&self) -> Result<Mesh, MeshError> {
        Mesh::from_f64(
            self.vertices.iter().copied(),
            self.triangles.iter().copied(),
        )
    }

    /// The mesh with its vertices rounded to f32.
    #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
    pub fn rounded_mesh(&self) -> Result<Mesh, MeshError> {
        let rounded = self.vertices.iter().map(|v| v.map(|x| x as f32));
        Mesh::new(rounded, self.triangles.iter().copied())
    }
}

fn three<T: std::fmt::Debug>(items: impl Iterator<Item = T>) -> [T; 3] {
    items.collect::<Vec<T>>().try_into().expect("three numbers")
}

pub fn number(word: &str) -> f64 {
    word.parse().expect("a number")
}

/// OBJ counts from 1.
fn index(word: &str) -> u32 {
    word.parse::<u32>().expect("an index") - 1
}

/// One pose a line, 12 numbers; `#` starts a comment.
pub fn poses(path: &Path) -> Vec<Result<Pose, PoseError>> {
    let numbers = |line: &str| -> [f64; 12] {
        let row: Vec<f64> = line.split_whitespace().map(number).collect();
        row.try_into().expect("12 numbers")
    };
    text(path)
        .lines()
        .map(|line| line.split('#').next().unwrap_or("").trim())
        .filter(|line| !line.is_empty())
        .map(|line| Pose::from_row_major(numbers(line)))
        .collect()
}

/// What a truth file says of one pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    Pairs(u64),
    Invalid,
}

/// One row a pose, in order; columns are found by name.
pub fn truth(path: &Path) -> Vec<Truth> {
    let text = text(path);
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let column = |name: &str| {
        let found = header.iter().position(|&head| head == name);
        found.unwrap_or_else(|| panic!("{}: no column {name}", path.display()))
    };
    let (pose, hit, pairs) = (column("pose"), column("hit"), column("pairs"));
    let row = |(count, line): (usize, &str)| {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[pose], count.to_string(), "{}", path.display());
        if fields[hit] == "invalid" {
            return Truth::Invalid;
        }
        let pairs = fields[pairs].parse().expect("a count");
        assert_eq!(fields[hit], if pairs > 0 { "1" } else { "0" });
        Truth::Pairs(pairs)
    };
    lines.enumerate().map(row).collect()
}
