//! Pairs of triangles with exact truth: the fixture, and all of them if they lie beside the repository. The unit tests of the
//! library use it too, so corners are arrays.
#![allow(
    dead_code,
    reason = "each test file is a crate of its own and uses a part"
)]

use std::array::from_fn;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::string::String;
use std::vec::Vec;

/// A line of a pairs file.
pub struct HardPair {
    pub meet: bool,
    pub family: String,
    /// The distance with four digits, if they do not meet.
    pub margin: f64,
    pub triangles: [[[f64; 3]; 3]; 2],
}

pub fn fixture() -> Vec<HardPair> {
    read("tests/fixtures/pairs.txt.gz").expect("the fixture is there")
}

pub fn all() -> Option<Vec<HardPair>> {
    let path = "../shared/hardcases/pairs/pairs.txt.gz";
    let pairs = read(path);
    if pairs.is_none() {
        std::println!("skipped: no {path}");
    }
    pairs
}

fn read(path: &str) -> Option<Vec<HardPair>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .ancestors()
        .find_map(|folder| File::open(folder.join(path)).ok())?;
    let mut text = String::new();
    flate2::read::GzDecoder::new(file)
        .read_to_string(&mut text)
        .unwrap();
    Some(
        text.lines()
            .filter(|line| !line.starts_with('#'))
            .map(parse)
            .collect(),
    )
}

fn parse(line: &str) -> HardPair {
    let fields: Vec<&str> = line.split(' ').collect();
    let numbers: Vec<f64> = fields[3..]
        .iter()
        .map(|field| field.parse().expect("a number"))
        .collect();
    assert_eq!(numbers.len(), 19, "{line}");
    let triangles = from_fn(|t| from_fn(|corner| from_fn(|k| numbers[1 + 9 * t + 3 * corner + k])));
    HardPair {
        meet: fields[0] == "1",
        family: fields[2].into(),
        margin: numbers[0],
        triangles,
    }
}
