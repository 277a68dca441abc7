//! The exact truth of a case: every intersecting pair of every pose, and the regions of contact they lie in.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use crate::report::{Failure, write};
use crate::traversal::complete;
use punctual::{Pose, Query, Workspace};

use super::case::Case;

/// Edge of a region: a cell of a grid over A, in the box diagonal of the smaller mesh.
const REGION: f64 = 0.05;

/// What is true at a pose.
pub struct Truth {
    /// Sorted.
    pub pairs: Vec<[u32; 2]>,
    /// For each pair the number of its region, of `regions`.
    pub region: Vec<u32>,
    pub regions: usize,
}

/// The truth of all poses: from the file, if that is of this very case, else computed and written there.
pub fn of_case(case: &Case, file: &Path) -> Result<Vec<Truth>, Failure> {
    let header = format!("# {:016x} pose,a,b", case.fingerprint());
    let pairs = match read(file, &header, case.poses.len()) {
        Some(pairs) => pairs,
        None => {
            let mut workspace = Workspace::with_capacity(0, 1 << 16);
            let pairs: Vec<_> = case
                .poses
                .iter()
                .map(|pose| compute(case, *pose, &mut workspace))
                .collect();
            let mut text = header + "\n";
            for (pose, pairs) in pairs.iter().enumerate() {
                for [a, b] in pairs {
                    writeln!(text, "{pose},{a},{b}")?;
                }
            }
            write(file, text + "# end\n")?;
            pairs
        }
    };
    Ok(case
        .poses
        .iter()
        .zip(pairs)
        .map(|(pose, pairs)| locate(case, pose, pairs))
        .collect())
}

fn read(file: &Path, header: &str, poses: usize) -> Option<Vec<Vec<[u32; 2]>>> {
    let text = std::fs::read_to_string(file).ok()?;
    let lines = text.strip_prefix(header)?.strip_suffix("# end\n")?;
    let mut pairs = vec![Vec::new(); poses];
    for line in lines.lines().skip(1) {
        let mut numbers = line.split(',').map(|number| number.parse::<u32>().ok());
        let pose = numbers.next()??;
        pairs
            .get_mut(pose as usize)?
            .push([numbers.next()??, numbers.next()??]);
    }
    Some(pairs)
}

fn compute(case: &Case, pose: Pose, workspace: &mut Workspace) -> Vec<[u32; 2]> {
    let mut pairs = Vec::new();
    let query = Query::all_pairs(&case.a, &case.b, pose);
    let _ = complete(&query, workspace, |pair| pairs.push(pair));
    pairs.sort_unstable();
    pairs
}

/// Each pair lies where the boxes of its triangles overlap.
fn locate(case: &Case, pose: &Pose, pairs: Vec<[u32; 2]>) -> Truth {
    let edge = (REGION * case.size()).max(f64::MIN_POSITIVE);
    let mut numbers = HashMap::new();
    let region = pairs.iter().map(|&pair| {
        let middle = super::open::meeting(case, pose, pair).center();
        let next = numbers.len() as u32;
        *numbers
            .entry((middle / edge).floor().to_array().map(|x| x as i64))
            .or_insert(next)
    });
    let region = region.collect();
    Truth {
        pairs,
        region,
        regions: numbers.len(),
    }
}
