//! `punctual triangles`: the exact test of two closed triangles, a line at a time.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::PathBuf;

use punctual::geom::triangles_intersect;
use punctual::glam::DVec3;
use punctual_io::FileError;
use punctual_io::text::{fields, numbers, shorten};

use crate::{Completion, complain};

const NUMBERS: usize = 18;

/// Test pairs of triangles, exactly.
///
/// Triangles are closed: sharing one point is intersecting. A degenerate triangle is the hull of its three points.
/// Prints a line for each pair: 1 if the triangles share a point, 0 if not, `error` if the line holds no pair of
/// triangles with finite coordinates of at most 2^1003; the reason is then on standard error, and the exit status is 1.
#[derive(clap::Args)]
pub struct Args {
    /// Pairs, one a line, or - for standard input.
    ///
    /// The last 18 fields of a line are the corners x y z of the first and of the second triangle; fields before them
    /// are ignored, `#` begins a comment, blank lines are skipped.
    file: PathBuf,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Box<dyn std::error::Error>> {
    let file = &args.file;
    let mut source: Box<dyn BufRead> = if file.as_os_str() == "-" {
        Box::new(io::stdin().lock())
    } else {
        let opened = File::open(file).map_err(|error| FileError::from_io(file, &error))?;
        Box::new(BufReader::new(opened))
    };
    let mut completion = Completion::Full;
    let mut bytes = Vec::new();
    for line in 1.. {
        bytes.clear();
        let length = source
            .read_until(b'\n', &mut bytes)
            .map_err(|error| FileError::from_io(file, &error))?;
        if length == 0 {
            break;
        }
        let text = String::from_utf8_lossy(&bytes);
        let fields = fields(&text);
        if fields.is_empty() {
            continue;
        }
        match parse(&fields) {
            Ok([a, b]) => writeln!(out, "{}", u8::from(triangles_intersect(&a, &b)))?,
            Err(what) => {
                complain(&FileError::at_line(file, line, what));
                writeln!(out, "error")?;
                completion = Completion::Partial;
            }
        }
    }
    Ok(completion)
}

fn parse(fields: &[&str]) -> Result<[[DVec3; 3]; 2], String> {
    let last = fields.len().saturating_sub(NUMBERS);
    let n: [f64; NUMBERS] = numbers(&fields[last..])?;
    // The exact test promises nothing beyond this, nor for NaN.
    let limit = 2f64.powi(1003);
    if let Some(at) = n
        .iter()
        .position(|number| number.is_nan() || number.abs() > limit)
    {
        return Err(format!(
            "`{}` is not finite or exceeds 2^1003",
            shorten(fields[last + at])
        ));
    }
    let corner = |i: usize| DVec3::new(n[i], n[i + 1], n[i + 2]);
    Ok([
        [corner(0), corner(3), corner(6)],
        [corner(9), corner(12), corner(15)],
    ])
}
