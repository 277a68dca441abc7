//! Figure 6: `N_v` against `n` for several delta.

use crate::delta::{AxisTable, exact_visits};
use crate::paper;

use super::sample::{Rule, Setting};
use super::{Lab, exponent, leaves};
use crate::report::{Axis, Block, Chart, Failure, Section, Series, Shape, Table};

const ALPHAS: [f64; 3] = [0.6, 0.7, 0.8];
const DELTAS: [f64; 6] = [0.1, 0.2, 0.4, 0.6, 0.8, 0.9];
/// From here on the exponent of Eq 11 shows at the sizes that are counted.
const DEEP: f64 = 0.4;
const LAST: usize = 5;
/// Depths at which exponents are computed by the exact recursion; the last stands for the limit.
const LEVELS: [u32; 4] = [9, 13, 20, 40];
const CELLS: usize = 4096;

/// Exponents of `N_v` at rising depths, a row for each alpha and delta, and how far the last are from the limit.
fn asymptote() -> (Table, f64) {
    let (mut rows, mut worst) = (Vec::new(), 0f64);
    for alpha in ALPHAS {
        let limit = f64::max(0.0, (4.0 * alpha * alpha * alpha).log2());
        let tables = LEVELS.map(|depth| AxisTable::new(alpha, depth, CELLS));
        for delta in DELTAS {
            let exponents = tables.each_ref().map(|table| table.exponent(alpha, delta));
            worst = worst.max((exponents[LEVELS.len() - 1] - limit).abs());
            let mut row = vec![alpha.to_string(), delta.to_string()];
            row.extend(exponents.map(|exponent| format!("{exponent:.3}")));
            row.push(format!("{limit:.3}"));
            rows.push(row);
        }
    }
    let header = ["alpha".to_owned(), "delta".to_owned()].into_iter();
    let header = header
        .chain(LEVELS.map(|depth| format!("n = 2^{depth}")))
        .chain(["Eq 11, in the limit".to_owned()]);
    (Table::new(header, rows), worst)
}

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
    let csv = settings.iter().zip(&means);
    let csv = csv.map(|(&(alpha, delta, depth), &mean)| {
        let eq11 = paper::eq11([alpha; 3], depth);
        let exact = exact_visits([alpha; 3], delta, depth);
        [alpha, delta, leaves(depth), mean, eq11, exact]
    });
    lab.csv("figure6", "alpha,delta,n,random_corners,eq11,exact", csv)?;

    let (mut blocks, mut rows, mut worst) = (Vec::new(), Vec::new(), [0f64; 2]);
    let exponent = |points: &[[f64; 2]]| exponent(points, LAST);
    for alpha in ALPHAS {
        let of_depth = |visits: &dyn Fn(u32) -> f64| -> Vec<[f64; 2]> {
            depths
                .iter()
                .map(|&depth| [leaves(depth), visits(depth)])
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
            let points: Vec<[f64; 2]> = at.map(|(s, mean)| [leaves(s.2), *mean]).collect();
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
    let (table, from_limit) = asymptote();
    blocks.push(Block::Text(
        "Exponents from n / 2 to n, by the exact recursion of the delta model:".to_owned(),
    ));
    blocks.push(Block::Table(table));
    let [shallow, deep] = worst;
    Ok(Section::claims(
        "figure6",
        "Figure 6: growth at a given delta",
        (
            "Asymptotically, N_v depends on delta only to a minor extent: at any delta it grows with the exponent of Eq 11.",
            (from_limit < 0.01).into(),
        ),
        format!(
            "At n = 2^{} the exact exponents are within {from_limit:.3} of the limit of Eq 11, at every alpha and delta. At \
             the sizes counted they are within {deep:.2} of those of Eq 11 from delta = {DEEP} on, and up to {shallow:.2} \
             off below: the corner that overlaps runs out of boxes.",
            LEVELS[LEVELS.len() - 1]
        ),
        blocks,
    ))
}
