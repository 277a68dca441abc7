//! Equation 11 where it must hold: the mean over uniform offsets along all axes.

use crate::paper;

use super::Lab;
use super::sample::{Rule, Setting};
use crate::report::{Axis, Chart, Failure, Lead, Section, Series, Shape, Verdict};

const ALPHAS: [f64; 4] = [0.6, 0.7, 0.8, 0.9];

pub fn run(lab: &Lab) -> Result<Section, Failure> {
    let depths = 3..=lab.choose(13, 8);
    let settings: Vec<(Rule, f64, u32)> = [Rule::Random, Rule::Fixed]
        .into_iter()
        .flat_map(|rule| ALPHAS.map(|alpha| (rule, alpha)))
        .flat_map(|(rule, alpha)| depths.clone().map(move |depth| (rule, alpha, depth)))
        .collect();
    let ratios = lab.all(&settings, |&(rule, alpha, depth)| {
        let setting = Setting {
            alpha: [alpha; 3],
            depth,
            rule,
            delta: None,
        };
        let mean = setting.mean(&lab.effort(), u64::from(depth));
        let model = paper::eq11([alpha; 3], depth);
        (mean.value / model, mean.error / model)
    });
    let rows = settings
        .iter()
        .zip(&ratios)
        .map(|(&(rule, alpha, depth), (ratio, error))| {
            let rule = if rule == Rule::Fixed {
                "fixed"
            } else {
                "random"
            };
            vec![
                rule.to_owned(),
                alpha.to_string(),
                f64::from(depth).exp2().to_string(),
                ratio.to_string(),
                error.to_string(),
            ]
        });
    lab.csv(
        "equation11",
        "corners,alpha,n,measured_over_eq11,standard_error",
        &rows.collect::<Vec<_>>(),
    )?;
    let of = |rule: Rule| {
        settings
            .iter()
            .zip(&ratios)
            .filter(move |(setting, _)| setting.0 == rule)
    };
    let range = |rule: Rule| {
        let ratio = || of(rule).map(|(_, &(ratio, _))| ratio);
        (
            ratio().fold(f64::MAX, f64::min),
            ratio().fold(f64::MIN, f64::max),
        )
    };
    let mut series = Vec::new();
    for (i, alpha) in ALPHAS.into_iter().enumerate() {
        let at = || of(Rule::Random).filter(move |(setting, _)| setting.1 == alpha);
        let n = |depth: u32| f64::from(depth).exp2() * (1.0 + 0.04 * (i as f64 - 1.5));
        let bars = at()
            .map(|(s, &(ratio, error))| [n(s.2), ratio - 2.0 * error, ratio + 2.0 * error])
            .collect();
        let points = at().map(|(s, &(ratio, _))| [n(s.2), ratio]).collect();
        series.push(Series::new("", i, Shape::Intervals(bars)));
        series.push(Series::new(
            format!("alpha {alpha}"),
            i,
            Shape::Points(points),
        ));
    }
    let chart = Chart {
        title: "Measured over Eq 11, uniform offsets, random corners (bars: 2 standard errors)"
            .to_owned(),
        x: Axis::log("leaves n"),
        y: Axis::linear("N_v / Eq 11"),
        series,
    };
    let (random, fixed) = (range(Rule::Random), range(Rule::Fixed));
    let misses = of(Rule::Random)
        .filter(|(_, (ratio, error))| (ratio - 1.0).abs() > 3.0 * error)
        .count();
    let all = of(Rule::Random).count();
    Ok(Section {
        id: "equation11".to_owned(),
        title: "Eq 11: the mean over all placements".to_owned(),
        lead: Lead::Claim(
            "N_v is at most the sum of (4 alpha_x alpha_y alpha_z)^l over the levels l.".to_owned(),
            if misses * 20 <= all {
                Verdict::Holds
            } else {
                Verdict::DoesNotHold
            },
        ),
        measured: format!(
            "For the mean over all placements at which the roots meet it is an equality, whatever the corners. Measured over \
             predicted: {:.2} to {:.2} with random corners ({} of {all} means are more than 3 standard errors off), {:.2} \
             to {:.2} with fixed corners, where few deep overlaps of two diagonals make up the mean.",
            random.0, random.1, misses, fixed.0, fixed.1
        ),
        blocks: vec![lab.plot("equation11", &chart)?],
    })
}
