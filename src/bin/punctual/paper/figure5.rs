//! Figure 5: `N_v` against `n`, the mean over delta = 0 ... 0.9, against Eq 11.

use punctual::model::delta::overlap_probability;
use punctual::model::fit::PowerLaw;
use punctual::model::paper;

use super::Lab;
use super::sample::{Mean, Rule, Setting};
use crate::report::{Axis, Block, Chart, Failure, Section, Series, Shape, Table, Verdict, short};

const ALPHAS: [f64; 2] = [0.7, 0.9];
const LAST: usize = 5;

/// `N_v` of artificial trees at `delta`, the exact mean over lateral offsets and random corners, level by level.
pub fn exact_visits(alpha: [f64; 3], delta: f64, depth: u32) -> f64 {
    let lateral = alpha[1] * alpha[2];
    let probability = |l: u32| overlap_probability(alpha[0], l, 1.0 - delta) * lateral.powi(l as i32);
    (0..=depth).map(|l| paper::eq1(l, probability(l))).sum()
}

fn deltas() -> impl Iterator<Item = f64> {
    (0..10).map(|i| f64::from(i) / 10.0)
}

pub fn run(lab: &Lab) -> Result<Section, Failure> {
    let depths: Vec<u32> = (1..=lab.choose(13, 9)).collect();
    let rules = [Rule::Random, Rule::Fixed];
    let settings: Vec<(f64, u32, Rule)> = ALPHAS
        .iter()
        .flat_map(|&alpha| depths.iter().flat_map(move |&depth| rules.map(|rule| (alpha, depth, rule))))
        .collect();
    let means = lab.all(&settings, |&(alpha, depth, rule)| {
        let at = |delta: f64| {
            let setting = Setting { alpha: [alpha; 3], depth, rule, delta: Some(delta) };
            setting.mean(&lab.effort(), u64::from(depth))
        };
        let of_each: Vec<Mean> = deltas().map(at).collect();
        let value = of_each.iter().map(|mean| mean.value).sum::<f64>() / 10.0;
        Mean { value, error: of_each.iter().map(|mean| mean.error * mean.error).sum::<f64>().sqrt() / 10.0 }
    });
    let (mut csv, mut series, mut table, mut ratios) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let bounded = settings
        .iter()
        .zip(&means)
        .all(|(&(alpha, depth, _), mean)| mean.value <= paper::eq11([alpha; 3], depth) + 3.0 * mean.error);
    for (i, alpha) in ALPHAS.into_iter().enumerate() {
        let points = |wanted: Rule| -> Vec<[f64; 2]> {
            let found = settings.iter().zip(&means).filter(|(s, _)| s.0 == alpha && s.2 == wanted);
            found.map(|(s, mean)| [f64::from(s.1).exp2(), mean.value]).collect()
        };
        let of_depth = |visits: &dyn Fn(u32) -> f64| -> Vec<[f64; 2]> {
            depths.iter().map(|&depth| [f64::from(depth).exp2(), visits(depth)]).collect()
        };
        let eq11 = of_depth(&|depth| paper::eq11([alpha; 3], depth));
        let exact = of_depth(&|depth| deltas().map(|delta| exact_visits([alpha; 3], delta, depth)).sum::<f64>() / 10.0);
        let (random, fixed) = (points(Rule::Random), points(Rule::Fixed));
        for i in 0..depths.len() {
            csv.push(
                [alpha, random[i][0], random[i][1], fixed[i][1], eq11[i][1], exact[i][1]]
                    .map(|x| x.to_string())
                    .to_vec(),
            );
            ratios.push(random[i][1] / exact[i][1]);
        }
        let last = depths.len() - 1;
        let exponent =
            |points: &[[f64; 2]]| PowerLaw::fit(&points[points.len() - LAST..]).map_or(f64::NAN, |law| law.exponent());
        table.push(
            [
                alpha,
                exponent(&eq11),
                exponent(&random),
                exponent(&fixed),
                random[last][1] / eq11[last][1],
                fixed[last][1] / eq11[last][1],
            ]
            .map(short)
            .to_vec(),
        );
        series.push(Series::new(format!("random corners, alpha {alpha}"), 2 * i, Shape::Points(random)));
        series.push(Series::new(format!("fixed corners, alpha {alpha}"), 2 * i + 1, Shape::Points(fixed)));
        series.push(Series::new(format!("Eq 11, alpha {alpha}"), 2 * i, Shape::Line(eq11)));
        series.push(Series::new(format!("exact, alpha {alpha}"), 2 * i, Shape::Dashed(exact)));
    }
    lab.csv("figure5", "alpha,n,random_corners,fixed_corners,eq11,exact", &csv)?;
    let chart = Chart {
        title: "Figure 5: mean over delta = 0, 0.1 ... 0.9".to_owned(),
        x: Axis::log("leaves n"),
        y: Axis::log("N_v"),
        series,
    };
    let least = ratios.iter().copied().fold(f64::MAX, f64::min);
    let most = ratios.iter().copied().fold(f64::MIN, f64::max);
    let header = [
        "alpha",
        "exponent of Eq 11",
        "random corners",
        "fixed corners",
        "N_v / Eq 11, random, largest n",
        "N_v / Eq 11, fixed, largest n",
    ];
    let rows: Vec<String> = table
        .iter()
        .map(|row| format!("alpha {}: exponent {} against {}, N_v / Eq 11 = {}", row[0], row[2], row[1], row[4]))
        .collect();
    Ok(Section {
        id: "figure5".to_owned(),
        title: "Figure 5: mean over delta".to_owned(),
        claim: "Averaged over delta = 0 ... 0.9, Eq 11 is an upper bound and has the right growth.".to_owned(),
        measured: format!(
            "{}. Measured over the exact mean of our delta model: {least:.2} to {most:.2}.",
            rows.join("; ")
        ),
        verdict: if bounded { Verdict::Holds } else { Verdict::DoesNotHold },
        blocks: vec![
            lab.plot("figure5", &chart)?,
            Block::Table(Table { header: header.map(str::to_owned).to_vec(), rows: table }),
        ],
    })
}
