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

/// Median, 99 % quantile and maximum.
fn quantiles(times: impl Iterator<Item = Duration>) -> [Duration; 3] {
    let mut times: Vec<Duration> = times.collect();
    times.sort_unstable();
    let last = times.len().saturating_sub(1);
    [last / 2, (last * 99).div_ceil(100), last].map(|at| times.get(at).copied().unwrap_or_default())
}

pub fn print(out: &mut impl Write, rows: &[FrameRow], truth: bool) -> io::Result<()> {
    let sum = |count: fn(&FrameRow) -> usize| rows.iter().map(count).sum::<usize>();
    for (name, times) in [
        ("wall", quantiles(rows.iter().map(|row| row.wall))),
        ("cpu", quantiles(rows.iter().map(|row| row.cpu))),
        ("overrun", quantiles(rows.iter().map(FrameRow::overrun))),
    ] {
        let ms = |time: Duration| format!("{:.4}", time.as_secs_f64() * 1e3);
        let [median, p99, max] = times.map(ms);
        writeln!(out, "# {name} median_ms={median} p99_ms={p99} max_ms={max}")?;
    }
    let (frames, decided) = (rows.len(), sum(|row| row.decided) as f64);
    let decided = decided / sum(|row| row.broad_pairs).max(1) as f64;
    let worst_age = rows.iter().map(|row| row.worst_age).max().unwrap_or(0);
    writeln!(
        out,
        "# frames={frames} decided={decided:.5} worst_age={worst_age}"
    )?;
    let answers = rows.iter().map(|row| row.answers);
    let Counts {
        touching: [told, all],
        distances: [measured, proven],
        passages: [moved, free, touching],
        events: [began, ended],
        rays: [cast, hit],
    } = answers.fold(Counts::default(), |sum, of_row| sum + of_row);
    if told > 0 {
        let hits = sum(|row| row.hits);
        writeln!(out, "# contacts pairs={told} complete={all} hits={hits}")?;
    }
    if measured > 0 {
        writeln!(out, "# distances asked={measured} proven={proven}")?;
    }
    if moved > 0 {
        writeln!(
            out,
            "# passages asked={moved} free={free} touching={touching}"
        )?;
    }
    if began > 0 {
        writeln!(out, "# events began={began} ended={ended}")?;
    }
    if cast > 0 {
        writeln!(out, "# rays cast={cast} hit={hit}")?;
    }
    if truth {
        let [hits, found] = [sum(|row| row.true_hits), sum(|row| row.true_found)];
        let (share, wrong) = (found as f64 / hits.max(1) as f64, sum(|row| row.wrong));
        writeln!(
            out,
            "# truth hits={hits} found={found} share={share:.5} wrong={wrong}"
        )?;
    }
    Ok(())
}
