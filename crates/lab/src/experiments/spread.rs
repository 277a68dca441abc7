//! How skewed `N_v` is: single queries around the mean that the equations give.

use crate::artificial::Random;
use crate::delta::exact_visits;
use crate::paper;

use super::Lab;
use super::sample::{Rule, Setting, Spread};
use crate::report::{Axis, Chart, Failure, Section, Series, Shape, Verdict, short};
use crate::statistics::{quantile, sorted};

const ALPHA: [f64; 3] = [0.8; 3];

/// `N_v` of single queries at each delta, ascending.
fn single_queries(lab: &Lab, depth: u32, deltas: &[f64]) -> Vec<Vec<f64>> {
    lab.all(deltas, |&delta| {
        let setting = Setting {
            alpha: ALPHA,
            depth,
            rule: Rule::Random,
            delta: Some(delta),
        };
        let mut random = Random::new(9);
        let mut points = Spread::new(&mut random);
        let mut single = |_| {
            let offset = setting.offset(points.next());
            setting.visits(&mut random, offset).total() as f64
        };
        sorted((0..lab.choose(1000, 100)).map(&mut single))
    })
}

fn histogram(values: &[f64]) -> Vec<[f64; 3]> {
    let most = values.iter().copied().fold(1.0, f64::max).log2().ceil() as i32;
    let bin = |i: i32| {
        let (low, high) = (f64::from(i).exp2(), f64::from(i + 1).exp2());
        let count = values.iter().filter(|&&v| v >= low && v < high).count();
        [low, high, count as f64 / values.len() as f64]
    };
    (0..=most).map(bin).collect()
}

pub fn run(lab: &Lab) -> Result<Section, Failure> {
    let depth = lab.choose(13, 8);
    let n = 1 << depth;
    let deltas: Vec<f64> = (1..=20).map(|i| f64::from(i) / 20.0).collect();
    let queries = single_queries(lab, depth, &deltas);
    let quantiles = |p: f64| {
        queries
            .iter()
            .map(|values| quantile(values, p))
            .collect::<Vec<f64>>()
    };
    let (low, median, high) = (quantiles(0.1), quantiles(0.5), quantiles(0.9));
    let exact: Vec<f64> = deltas
        .iter()
        .map(|&delta| exact_visits(ALPHA, delta, depth))
        .collect();
    let rows = (0..deltas.len()).map(|i| [deltas[i], low[i], median[i], high[i], exact[i]]);
    lab.csv("spread", "delta,p10,median,p90,exact_mean", rows)?;

    let along = |values: &[f64]| {
        deltas
            .iter()
            .zip(values)
            .map(|(&delta, &v)| [delta, v])
            .collect::<Vec<[f64; 2]>>()
    };
    let band = (0..deltas.len())
        .map(|i| [deltas[i], low[i], high[i]])
        .collect();
    let over_delta = Chart {
        title: format!("Single queries at alpha = 0.8, n = {n}"),
        x: Axis::linear("delta"),
        y: Axis::log("N_v"),
        series: vec![
            Series::new("10 % to 90 %", 0, Shape::Band(band)),
            Series::new("median", 0, Shape::Line(along(&median))),
            Series::new("mean by the delta model", 1, Shape::Line(along(&exact))),
            Series::new(
                "Eq 11",
                6,
                Shape::Dashed(along(&vec![paper::eq11(ALPHA, depth); deltas.len()])),
            ),
        ],
    };
    let all = sorted(queries.into_iter().flatten());
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let [median, p90, most] = [0.5, 0.9, 1.0].map(|p| quantile(&all, p));
    let bins = histogram(&all);
    let highest = bins.iter().map(|bin| bin[2]).fold(0.0, f64::max);
    let columns = Chart {
        title: "All of these queries, delta = 0.05 ... 1: how many have which N_v".to_owned(),
        x: Axis::log("N_v"),
        y: Axis::linear("share of the queries").range(0.0..1.1 * highest),
        series: vec![Series::new("", 0, Shape::Columns(bins))],
    };
    Ok(Section::claims(
        "spread",
        "What a mean hides",
        (
            "The paper gives a mean and calls it the expected running time.",
            Verdict::HoldsInPart,
        ),
        format!(
            "It is one, but no query is like it: at alpha = 0.8, n = {n}, over delta = 0.05 ... 1, the median N_v is {}, the \
             mean {}, the 90 % quantile {}, the largest {}.",
            short(median),
            short(mean),
            short(p90),
            short(most)
        ),
        vec![
            lab.plot("spread", &over_delta)?,
            lab.plot("spread_histogram", &columns)?,
        ],
    ))
}
