//! Figure 5: `N_v` against `n`, the mean over delta = 0 ... 0.9, against Eq 11.

use crate::delta::exact_visits;
use crate::paper;
use crate::statistics::range;

use super::sample::{Mean, Rule, Setting};
use super::{Lab, exponent, leaves};
use crate::report::{Axis, Block, Chart, Failure, Section, Series, Shape, Table, short};

const ALPHAS: [f64; 2] = [0.7, 0.9];
const LAST: usize = 5;

fn deltas() -> impl Iterator<Item = f64> {
    (0..10).map(|i| f64::from(i) / 10.0)
}

/// The mean over all deltas, each with a mean over lateral offsets.
fn mean_over_deltas(lab: &Lab, alpha: f64, depth: u32, rule: Rule) -> Mean {
    let at = |delta: f64| {
        let setting = Setting {
            alpha: [alpha; 3],
            depth,
            rule,
            delta: Some(delta),
        };
        setting.mean(&lab.effort(), u64::from(depth))
    };
    let means: Vec<Mean> = deltas().map(at).collect();
    let squares: f64 = means.iter().map(|mean| mean.error * mean.error).sum();
    Mean {
        value: means.iter().map(|mean| mean.value).sum::<f64>() / 10.0,
        error: squares.sqrt() / 10.0,
    }
}

pub fn run(lab: &Lab) -> Result<Section, Failure> {
    let depths: Vec<u32> = (1..=lab.choose(13, 9)).collect();
    let settings: Vec<(f64, Rule, u32)> = ALPHAS
        .iter()
        .flat_map(|&alpha| [(alpha, Rule::Random), (alpha, Rule::Fixed)])
        .flat_map(|(alpha, rule)| depths.iter().map(move |&depth| (alpha, rule, depth)))
        .collect();
    let means = lab.all(&settings, |&(alpha, rule, depth)| {
        mean_over_deltas(lab, alpha, depth, rule)
    });
    let within = |(&(alpha, _, depth), mean): (&(f64, Rule, u32), &Mean)| {
        mean.value <= paper::eq11([alpha; 3], depth) + 3.0 * mean.error
    };
    let bounded = settings.iter().zip(&means).all(within);

    let (mut csv, mut series, mut table, mut words) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (i, (alpha, means)) in ALPHAS
        .into_iter()
        .zip(means.chunks(2 * depths.len()))
        .enumerate()
    {
        let (random, fixed) = means.split_at(depths.len());
        let values = |of: &dyn Fn(usize) -> f64| {
            let points = depths.iter().enumerate();
            let points = points.map(|(k, &depth)| [leaves(depth), of(k)]);
            points.collect::<Vec<[f64; 2]>>()
        };
        let exact = |k: usize| {
            let visits = deltas().map(|delta| exact_visits([alpha; 3], delta, depths[k]));
            visits.sum::<f64>() / 10.0
        };
        let curves = [
            values(&|k| random[k].value),
            values(&|k| fixed[k].value),
            values(&|k| paper::eq11([alpha; 3], depths[k])),
            values(&exact),
        ];
        let [random, fixed, eq11, exact] = &curves;
        csv.extend((0..depths.len()).map(|k| {
            let [random, fixed, eq11, exact] = curves.each_ref().map(|curve| curve[k][1]);
            [alpha, leaves(depths[k]), random, fixed, eq11, exact]
        }));
        let exponents = [eq11, random, fixed].map(|curve| exponent(curve, LAST));
        let last = depths.len() - 1;
        let ratios = [random, fixed].map(|curve| curve[last][1] / eq11[last][1]);
        let row = [alpha].into_iter().chain(exponents).chain(ratios);
        let row: Vec<String> = row.map(short).collect();
        words.push(format!(
            "alpha {}: exponent {} against {}, N_v / Eq 11 = {}",
            row[0], row[2], row[1], row[4]
        ));
        table.push(row);
        let name = |what: &str| format!("{what}, alpha {alpha}");
        let color = 2 * i;
        series.extend([
            Series::new(name("random corners"), color, Shape::Points(random.clone())),
            Series::new(
                name("fixed corners"),
                color + 1,
                Shape::Points(fixed.clone()),
            ),
            Series::new(name("Eq 11"), color, Shape::Line(eq11.clone())),
            Series::new(name("exact"), color, Shape::Dashed(exact.clone())),
        ]);
    }
    let [least, most] = range(csv.iter().map(|[_, _, random, _, _, exact]| random / exact));
    let header = "alpha,n,random_corners,fixed_corners,eq11,exact";
    lab.csv("figure5", header, csv)?;
    let chart = Chart {
        title: "Figure 5: mean over delta = 0, 0.1 ... 0.9".to_owned(),
        x: Axis::log("leaves n"),
        y: Axis::log("N_v"),
        series,
    };
    let header = [
        "alpha",
        "exponent of Eq 11",
        "random corners",
        "fixed corners",
        "N_v / Eq 11, random, largest n",
        "N_v / Eq 11, fixed, largest n",
    ];
    Ok(Section::claims(
        "figure5",
        "Figure 5: mean over delta",
        (
            "Averaged over delta = 0 ... 0.9, Eq 11 is an upper bound and has the right growth.",
            bounded.into(),
        ),
        format!(
            "{}. Measured over the exact mean of our delta model: {least:.2} to {most:.2}.",
            words.join("; ")
        ),
        vec![
            lab.plot("figure5", &chart)?,
            Block::Table(Table::new(header, table)),
        ],
    ))
}
