//! Figure 7: the distribution of `N_v` over delta and alpha.

use crate::paper;

use super::sample::{Rule, Setting};
use super::{Lab, leaves};
use crate::report::{Axis, Failure, HeatMap, Section};
use crate::statistics::range;

/// Cells of 0.05 by 0.1, named by their middles.
const ALPHAS: [f64; 9] = [0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9];
const DELTAS: [f64; 10] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

fn edges(middles: &[f64]) -> Vec<f64> {
    let half = (middles[1] - middles[0]) / 2.0;
    std::iter::once(middles[0] - half)
        .chain(middles.iter().map(|middle| middle + half))
        .collect()
}

/// Largest and least of some numbers, apart.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let [low, high] = range(values);
    high - low
}

pub fn run(lab: &Lab) -> Result<Section, Failure> {
    let depths = lab.choose([9, 13], [7, 9]);
    let settings: Vec<(u32, f64, f64)> = depths
        .iter()
        .flat_map(|&depth| {
            ALPHAS
                .iter()
                .flat_map(move |&alpha| DELTAS.map(|delta| (depth, alpha, delta)))
        })
        .collect();
    let means = lab.all(&settings, |&(depth, alpha, delta)| {
        let setting = Setting {
            alpha: [alpha; 3],
            depth,
            rule: Rule::Random,
            delta: Some(delta),
        };
        setting.mean(&lab.effort(), 7).value
    });
    let csv = settings.iter().zip(&means);
    let csv = csv.map(|(&(depth, alpha, delta), &mean)| {
        let ratio = (mean / paper::eq11([alpha; 3], depth)).log2();
        [leaves(depth), alpha, delta, mean, ratio]
    });
    lab.csv("figure7", "n,alpha,delta,visits,log2_visits_over_eq11", csv)?;
    let mut blocks = Vec::new();
    for (depth, values) in depths
        .into_iter()
        .zip(means.chunks(ALPHAS.len() * DELTAS.len()))
    {
        let map = HeatMap {
            title: format!("Figure 7: N_v at n = {}", 1 << depth),
            x: Axis::linear("delta"),
            y: Axis::linear("alpha"),
            x_edges: edges(&DELTAS),
            y_edges: edges(&ALPHAS),
            values: values.to_vec(),
            color: Axis::log("N_v"),
        };
        blocks.push(lab.plot(&format!("figure7_n{}", 1 << depth), &map)?);
    }
    let deepest = depths[1];
    let n = 1 << deepest;
    // log2 of the counts of the larger trees, a row for each alpha.
    let logs: Vec<f64> = means[ALPHAS.len() * DELTAS.len()..]
        .iter()
        .map(|mean| mean.log2())
        .collect();
    let row = |alpha: usize| {
        logs[alpha * DELTAS.len()..(alpha + 1) * DELTAS.len()]
            .iter()
            .copied()
    };
    let at_80 = 6;
    let over_delta = spread(row(at_80).skip(1));
    let from_eq11 =
        |i: usize| logs[at_80 * DELTAS.len() + i] - paper::eq11([ALPHAS[at_80]; 3], deepest).log2();
    let over_alpha = spread((0..ALPHAS.len()).map(|alpha| logs[alpha * DELTAS.len() + 4]));
    Ok(Section::shows(
        "figure7",
        "Figure 7: delta and alpha",
        format!(
            "How N_v is distributed over alpha and delta, at n = {} and n = {n}.",
            1 << depths[0]
        ),
        format!(
            "At n = {n} and alpha = 0.8, N_v changes by a factor of 2^{over_delta:.1} from delta = 0.1 to 0.9; \
             log2(N_v / Eq 11) runs from {:.1} to {:.1}. At delta = 0.4 it changes by 2^{over_alpha:.1} from alpha = 0.5 to \
             0.9.",
            from_eq11(1),
            from_eq11(9),
        ),
        blocks,
    ))
}
