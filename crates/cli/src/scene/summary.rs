//! The figures of a whole recording.

use std::io::{self, Write};
use std::time::Duration;

use super::answers::Counts;
use super::play::FrameRow;

impl FrameRow {
    /// CPU time of the detection beyond its budget.
    pub fn overrun(&self) -> Duration {
        self.detect_cpu
            .saturating_sub(self.limit.unwrap_or(Duration::MAX))
    }
}

/// Sums and quantiles over frames.
pub struct Summary {
    pub wall: [Duration; 3],
    pub cpu: [Duration; 3],
    pub overrun: [Duration; 3],
    pub worst_age: u64,
    pub decided: f64,
    pub true_hits: usize,
    pub true_found: usize,
    pub wrong: usize,
    pub hits: usize,
    pub answers: Counts,
}

impl Summary {
    pub fn of(rows: &[FrameRow]) -> Self {
        let sum = |count: fn(&FrameRow) -> usize| rows.iter().map(count).sum::<usize>();
        Self {
            wall: quantiles(rows.iter().map(|row| row.wall)),
            cpu: quantiles(rows.iter().map(|row| row.cpu)),
            overrun: quantiles(rows.iter().map(FrameRow::overrun)),
            worst_age: rows.iter().map(|row| row.worst_age).max().unwrap_or(0),
            decided: sum(|row| row.decided) as f64 / sum(|row| row.broad_pairs).max(1) as f64,
            true_hits: sum(|row| row.true_hits),
            true_found: sum(|row| row.true_found),
            wrong: sum(|row| row.wrong),
            hits: sum(|row| row.hits),
            answers: rows
                .iter()
                .fold(Counts::default(), |sum, row| sum + row.answers),
        }
    }

    /// Share of the truly intersecting pairs that were reported as such.
    pub fn found(&self) -> f64 {
        self.true_found as f64 / self.true_hits.max(1) as f64
    }
}

/// Median, 99 % quantile and maximum.
fn quantiles(times: impl Iterator<Item = Duration>) -> [Duration; 3] {
    let mut times: Vec<Duration> = times.collect();
    times.sort_unstable();
    let last = times.len().saturating_sub(1);
    [last / 2, (last * 99).div_ceil(100), last].map(|at| times.get(at).copied().unwrap_or_default())
}

pub fn print(out: &mut impl Write, rows: &[FrameRow], truth: bool) -> io::Result<()> {
    let summary = Summary::of(rows);
    let ms = |times: [Duration; 3]| times.map(|time| format!("{:.4}", time.as_secs_f64() * 1e3));
    for (name, times) in [
        ("wall", summary.wall),
        ("cpu", summary.cpu),
        ("overrun", summary.overrun),
    ] {
        let [median, p99, max] = ms(times);
        writeln!(out, "# {name} median_ms={median} p99_ms={p99} max_ms={max}")?;
    }
    writeln!(
        out,
        "# frames={} decided={:.5} worst_age={}",
        rows.len(),
        summary.decided,
        summary.worst_age
    )?;
    let Summary { hits, answers, .. } = summary;
    let Counts {
        touching: [told, all],
        distances,
        passages,
        events,
        rays,
    } = answers;
    if told > 0 {
        writeln!(out, "# contacts pairs={told} complete={all} hits={hits}")?;
    }
    let [asked, proven] = distances;
    if asked > 0 {
        writeln!(out, "# distances asked={asked} proven={proven}")?;
    }
    let [asked, free, touching] = passages;
    if asked > 0 {
        writeln!(
            out,
            "# passages asked={asked} free={free} touching={touching}"
        )?;
    }
    let [began, ended] = events;
    if began > 0 {
        writeln!(out, "# events began={began} ended={ended}")?;
    }
    let [cast, hit] = rays;
    if cast > 0 {
        writeln!(out, "# rays cast={cast} hit={hit}")?;
    }
    if truth {
        let Summary {
            true_hits,
            true_found,
            wrong,
            ..
        } = summary;
        writeln!(
            out,
            "# truth hits={true_hits} found={true_found} share={:.5} wrong={wrong}",
            summary.found()
        )?;
    }
    Ok(())
}
