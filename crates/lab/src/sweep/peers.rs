//! Times of other libraries, from a file.

use std::collections::BTreeMap;
use std::path::Path;

use crate::report::{self, Failure};

/// For each case and each peer the microseconds that a finished distance query took, by pose.
pub type PeerTimes = BTreeMap<String, BTreeMap<String, BTreeMap<usize, f64>>>;

/// Reads lines `case,peer,pose,distance,ns` with a header; lines that begin with `#` are skipped, further columns ignored.
/// Of a pose that is there more than once the least time counts.
pub fn read(file: &Path) -> Result<PeerTimes, Failure> {
    let text = report::read(file)?;
    let mut times = PeerTimes::new();
    let lines = text
        .lines()
        .zip(1..)
        .filter(|(line, _)| !line.is_empty() && !line.starts_with('#'));
    for (line, number) in
        lines.skip_while(|(line, _)| line.starts_with("case,peer,pose,distance,ns"))
    {
        let fields: Vec<&str> = line.split(',').collect();
        let entry = || {
            Some((
                fields.get(2)?.parse().ok()?,
                fields.get(4)?.parse::<f64>().ok().filter(|ns| *ns >= 0.0)?,
            ))
        };
        let (pose, ns) = entry().ok_or_else(|| {
            format!(
                "{}:{number}: not case,peer,pose,distance,ns",
                file.display()
            )
        })?;
        let of_case = times.entry(fields[0].to_owned()).or_default();
        let time = of_case
            .entry(fields[1].to_owned())
            .or_default()
            .entry(pose)
            .or_insert(f64::INFINITY);
        *time = time.min(ns / 1e3);
    }
    Ok(times)
}
