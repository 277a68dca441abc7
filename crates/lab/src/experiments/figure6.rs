//! Figure 6: `N_v` against `n` for several delta.

use crate::fit::PowerLaw;
use crate::paper;

use super::Lab;
use super::figure5::exact_visits;
use super::sample::{Rule, Setting};
use crate::report::{Axis, Block, Chart, Failure, Lead, Section, Series, Shape, Table, Verdict};

const ALPHAS: [f64; 3] = [0.6, 0.7, 0.8];
const DELTAS: [f64; 6] = [0.1, 0.2, 0.4, 0.6, 0.8, 0.9];
/// From here on the paper's exponent is said to hold.
const DEEP: f64 = 0.4;
const LAST: usize = 5;

pub fn run(lab: &Lab) -> Result<Section, Failure> {
    let depths: Vec<u32> = (1..=lab.choose(13, 9)).collect();
    let settings: Vec<(f64, f64, u32)> = ALPHAS
        .iter()
        .flat_map(|&alpha| DELTAS.iter().map(move |&delta| (alpha, delta)))
        .flat_map(|(alpha, delta)| depths.iter().map(move |&depth| (alpha, delta, depth)))
        .collect();
    let means = lab.all(&settings, |&(alpha, delta, depth)| {
        let setting = Setting {
            alpha: [alpha; 3],
            depth,
            rule: Rule::Random,
            delta: Some(delta),
        };
        setting.mean(&lab.effort(), u64::from(depth)).value
    });
    let csv = settings
        .iter()
        .zip(&means)
        .map(|(&(alpha, delta, depth), &mean)| {
            let (eq11, exact) = (
                paper::eq11([alpha; 3], depth),
                exact_visits([alpha; 3], delta, depth),
            );
            [alpha, delta, f64::from(depth).exp2(), mean, eq11, exact]
                .map(|x| x.to_string())
                .to_vec()
        });
    lab.csv(
        "figure6",
        "alpha,delta,n,random_corners,eq11,exact",
        &csv.collect::<Vec<_>>(),
    )?;

    let (mut blocks, mut rows, mut worst) = (Vec::new(), Vec::new(), [0f64; 2]);
    let exponent = |points: &[[f64; 2]]| {
        PowerLaw::fit(&points[points.len() - LAST..]).map_or(f64::NAN, |law| law.exponent())
    };
    for alpha in ALPHAS {
        let of_depth = |visits: &dyn Fn(u32) -> f64| -> Vec<[f64; 2]> {
            depths
                .iter()
                .map(|&depth| [f64::from(depth).exp2(), visits(depth)])
                .collect()
        };
        let eq11 = of_depth(&|depth| paper::eq11([alpha; 3], depth));
        let mut row = vec![alpha.to_string(), format!("{:.2}", exponent(&eq11))];
        let mut series = Vec::new();
        for (i, delta) in DELTAS.into_iter().enumerate() {
            let at = settings
                .iter()
                .zip(&means)
                .filter(|(s, _)| s.0 == alpha && s.1 == delta);
            let points: Vec<[f64; 2]> =
                at.map(|(s, mean)| [f64::from(s.2).exp2(), *mean]).collect();
            let found = exponent(&points);
            let worst = &mut worst[usize::from(delta >= DEEP)];
            *worst = worst.max((found - exponent(&eq11)).abs());
            row.push(format!("{found:.2}"));
            series.push(Series::new(
                format!("delta {delta}"),
                i,
                Shape::Points(points),
            ));
            series.push(Series::new(
                "",
                i,
                Shape::Line(of_depth(&|depth| exact_visits([alpha; 3], delta, depth))),
            ));
        }
        series.push(Series::new("Eq 11", 6, Shape::Dashed(eq11)));
        rows.push(row);
        let chart = Chart {
            title: format!("Figure 6, alpha = {alpha}: counted (points), delta model (lines)"),
            x: Axis::log("leaves n"),
            y: Axis::log("N_v"),
            series,
        };
        blocks.push(lab.plot(&format!("figure6_alpha{:.0}", alpha * 100.0), &chart)?);
    }
    let header = ["alpha".to_owned(), "Eq 11".to_owned()].into_iter();
    let header = header.chain(DELTAS.map(|delta| format!("delta {delta}")));
    blocks.push(Block::Text(format!(
        "Exponents of n over the last {LAST} sizes:"
    )));
    blocks.push(Block::Table(Table::new(header, rows)));
    let [shallow, deep] = worst;
    Ok(Section {
        id: "figure6".to_owned(),
        title: "Figure 6: growth at a given delta".to_owned(),
        lead: Lead::Claim(
            "At any delta, from 0.4 on at least, N_v grows with the exponent of Eq 11.".to_owned(),
            match (deep < lab.choose(0.15, 0.5), shallow < 0.15) {
                (true, true) => Verdict::Holds,
                (true, false) => Verdict::HoldsInPart,
                _ => Verdict::DoesNotHold,
            },
        ),
        measured: format!(
            "From delta = {DEEP} on exponents are within {deep:.2} of those of Eq 11 over the same sizes; below, up to \
             {shallow:.2} off: the corner that overlaps runs out of boxes."
        ),
        blocks,
    })
}
