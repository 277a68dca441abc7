//! Equation 11 where it must hold: the mean over uniform offsets along all axes.

use crate::paper;
use crate::statistics::range;

use super::sample::{Rule, Setting};
use super::{Lab, leaves};
use crate::report::{self, Axis, Chart, Failure, Section, Series, Shape};

const ALPHAS: [f64; 4] = [0.6, 0.7, 0.8, 0.9];

pub fn run(lab: &Lab) -> Result<Section, Failure> {
    let depths = 3..=lab.choose(13, 8);
    let settings: Vec<Setting> = [Rule::Random, Rule::Fixed]
        .into_iter()
        .flat_map(|rule| ALPHAS.map(|alpha| (rule, alpha)))
        .flat_map(|(rule, alpha)| {
            depths.clone().map(move |depth| Setting {
                alpha: [alpha; 3],
                depth,
                rule,
                delta: None,
            })
        })
        .collect();
    let ratios = lab.all(&settings, |setting| {
        let mean = setting.mean(&lab.effort(), u64::from(setting.depth));
        let model = paper::eq11(setting.alpha, setting.depth);
        (mean.value / model, mean.error / model)
    });
    let of = |rule: Rule| {
        let all = settings.iter().zip(&ratios);
        all.filter(move |(setting, _)| setting.rule == rule)
    };
    let rows = settings
        .iter()
        .zip(&ratios)
        .map(|(setting, (ratio, error))| {
            let rule = match setting.rule {
                Rule::Fixed => "fixed",
                Rule::Random => "random",
            };
            let numbers = [setting.alpha[0], leaves(setting.depth), *ratio, *error];
            let numbers = numbers.map(|x| x.to_string());
            std::iter::once(rule.to_owned()).chain(numbers).collect()
        });
    let header = "corners,alpha,n,measured_over_eq11,standard_error";
    report::write_csv(lab.folder, "equation11", header, &rows.collect::<Vec<_>>())?;
    let mut series = Vec::new();
    for (i, alpha) in ALPHAS.into_iter().enumerate() {
        let at = of(Rule::Random).filter(|(setting, _)| setting.alpha[0] == alpha);
        let (mut bars, mut points) = (Vec::new(), Vec::new());
        for (setting, (ratio, error)) in at {
            let n = leaves(setting.depth) * (1.0 + 0.04 * (i as f64 - 1.5));
            bars.push([n, ratio - 2.0 * error, ratio + 2.0 * error]);
            points.push([n, *ratio]);
        }
        series.push(Series::new("", i, Shape::Intervals(bars)));
        let name = format!("alpha {alpha}");
        series.push(Series::new(name, i, Shape::Points(points)));
    }
    let chart = Chart {
        title: "Measured over Eq 11, uniform offsets, random corners (bars: 2 standard errors)"
            .to_owned(),
        x: Axis::log("leaves n"),
        y: Axis::linear("N_v / Eq 11"),
        series,
    };
    let [random, fixed] = [Rule::Random, Rule::Fixed].map(|rule| range(of(rule).map(|(_, r)| r.0)));
    let misses = of(Rule::Random)
        .filter(|(_, (ratio, error))| (ratio - 1.0).abs() > 3.0 * error)
        .count();
    let all = of(Rule::Random).count();
    Ok(Section::claims(
        "equation11",
        "Eq 11: the mean over all placements",
        (
            "N_v is at most the sum of (4 alpha_x alpha_y alpha_z)^l over the levels l.",
            (misses * 20 <= all).into(),
        ),
        format!(
            "For the mean over all placements at which the roots meet it is an equality, whatever the corners. Measured over \
             predicted: {:.2} to {:.2} with random corners ({misses} of {all} means are more than 3 standard errors off), {:.2} \
             to {:.2} with fixed corners, where few deep overlaps of two diagonals make up the mean.",
            random[0], random[1], fixed[0], fixed[1]
        ),
        vec![lab.plot("equation11", &chart)?],
    ))
}
