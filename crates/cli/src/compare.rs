//! `punctual compare`: what differs between two reports of `punctual sweep`.

use std::io::Write;
use std::path::{Path, PathBuf};

use punctual_lab::report::{self, Failure};
use serde_json::{Map, Value};

use crate::Completion;

/// Compare the summaries of two sweeps of the same cases.
///
/// Prints CSV, a line for each figure that differs by more than its noise. Figures of work have no noise: the same program
/// gives the same bits. A figure of time differs if the change exceeds the spread of the rounds in both reports together.
/// Exit status 1 if a figure is in one report only.
#[derive(clap::Args)]
pub struct Args {
    /// summary.json of the earlier sweep.
    old: PathBuf,
    /// summary.json of the later sweep.
    new: PathBuf,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let (old, new) = (load(&args.old)?, load(&args.new)?);
    if old["cases"] != new["cases"] {
        return Err("the two sweeps are of different cases".into());
    }
    let kinds = ["work", "time"].map(|kind| {
        Ok((
            kind,
            figures(&old, kind, &args.old)?,
            figures(&new, kind, &args.new)?,
        ))
    });
    let kinds = kinds.into_iter().collect::<Result<Vec<_>, Failure>>()?;
    if old["machine"] != new["machine"] {
        writeln!(out, "# old: {}\n# new: {}", old["machine"], new["machine"])?;
    }
    writeln!(out, "figure,kind,old,new,change,noise")?;
    let mut completion = Completion::Full;
    let mut changed = 0;
    for (kind, old, new) in kinds {
        let gone = old.keys().filter(|name| !new.contains_key(*name));
        for name in gone.chain(new.keys().filter(|name| !old.contains_key(*name))) {
            writeln!(out, "{name},{kind},,,in one only,")?;
            completion = Completion::Partial;
        }
        for (name, old) in old {
            let Some(new) = new.get(name) else { continue };
            let ((Some(before), noise), (Some(after), more)) = (figure(old), figure(new)) else {
                continue;
            };
            let (change, noise) = (after - before, noise + more);
            if change.abs() > noise {
                changed += 1;
                writeln!(
                    out,
                    "{name},{kind},{before:.4},{after:.4},{change:+.4},{noise:.4}"
                )?;
            }
        }
    }
    writeln!(out, "# {changed} figures differ by more than their noise")?;
    Ok(completion)
}

fn load(file: &Path) -> Result<Value, Failure> {
    let text = report::read(file)?;
    serde_json::from_str(&text).map_err(|error| format!("{}: {error}", file.display()).into())
}

fn figures<'v>(
    summary: &'v Value,
    kind: &str,
    file: &Path,
) -> Result<&'v Map<String, Value>, Failure> {
    summary[kind]
        .as_object()
        .ok_or_else(|| format!("{}: no summary of a sweep: no {kind}", file.display()).into())
}

/// Value and noise; no value where there was nothing to measure.
fn figure(value: &Value) -> (Option<f64>, f64) {
    match value {
        Value::Object(parts) => (
            parts.get("value").and_then(Value::as_f64),
            parts.get("noise").and_then(Value::as_f64).unwrap_or(0.0),
        ),
        number => (number.as_f64(), 0.0),
    }
}
