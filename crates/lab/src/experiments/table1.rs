//! Table 1: how `N_v` grows with `n`, by the product of the alphas.

use crate::fit::PowerLaw;
use crate::paper::{self, Growth};

use super::Lab;
use super::sample::{Rule, Setting};
use crate::report::{
    Axis, Block, Chart, Failure, Lead, Section, Series, Shape, Table, Verdict, short,
};

/// One of the paper's rows each, and how deep trees can be counted in reasonable time.
const PRODUCTS: [(&str, f64, u32); 5] = [
    ("0.2", 0.2, 13),
    ("1/4", 0.25, 13),
    ("sqrt(1/8)", 0.353_553_390_593_273_8, 13),
    ("3/4", 0.75, 11),
    ("1", 1.0, 9),
];
/// The exponent is that of the last doublings: the first ones are still dominated by the sum's beginning.
const LAST: usize = 4;
const FIRST_DEPTH: u32 = 3;

pub fn run(lab: &Lab) -> Result<Section, Failure> {
    let settings: Vec<(f64, u32)> = PRODUCTS
        .iter()
        .flat_map(|&(_, product, deepest)| {
            let deepest = deepest.min(lab.choose(13, 9));
            (FIRST_DEPTH..=deepest).map(move |depth| (product, depth))
        })
        .collect();
    let counts = lab.all(&settings, |&(product, depth)| {
        let setting = Setting {
            alpha: [product.cbrt(); 3],
            depth,
            rule: Rule::Random,
            delta: None,
        };
        setting.mean(&lab.effort(), u64::from(depth))
    });
    let (mut csv, mut table, mut series, mut worst) = (Vec::new(), Vec::new(), Vec::new(), 0f64);
    for (i, &(name, product, _)) in PRODUCTS.iter().enumerate() {
        let points: Vec<[f64; 2]> = settings
            .iter()
            .zip(&counts)
            .filter(|(setting, _)| setting.0 == product)
            .map(|(setting, mean)| [f64::from(setting.1).exp2(), mean.value])
            .collect();
        csv.extend(points.iter().map(|&[n, visits]| {
            let model = paper::eq11([product.cbrt(); 3], n.log2() as u32);
            vec![
                product.to_string(),
                n.to_string(),
                visits.to_string(),
                model.to_string(),
            ]
        }));
        let last = &points[points.len() - LAST..];
        let exponent = PowerLaw::fit(last).map_or(f64::NAN, |law| law.exponent());
        // What the finite sum itself gives over the same sizes.
        let sum = |&[n, _]: &[f64; 2]| [n, paper::eq11([product.cbrt(); 3], n.log2() as u32)];
        let expected = PowerLaw::fit(&last.iter().map(sum).collect::<Vec<_>>())
            .map_or(f64::NAN, |law| law.exponent());
        worst = worst.max((exponent - expected).abs());
        let growth = match Growth::of(product) {
            Growth::Constant => "O(1)".to_owned(),
            Growth::Logarithmic => "O(lg n)".to_owned(),
            Growth::Power(exponent) => format!("O(n^{exponent:.2})"),
        };
        table.push(vec![
            name.to_owned(),
            growth,
            format!("{expected:.2}"),
            format!("{exponent:.2}"),
            short(last[LAST - 1][1]),
        ]);
        series.push(Series::new("", i, Shape::Points(points.clone())));
        series.push(Series::new(
            format!("product {name}"),
            i,
            Shape::Line(points.iter().map(sum).collect()),
        ));
    }
    lab.csv("table1", "alpha_product,n,visits,eq11", &csv)?;
    let chart = Chart {
        title: "Table 1: artificial trees (points) and the paper's sum (lines)".to_owned(),
        x: Axis::log("leaves n"),
        y: Axis::log("N_v"),
        series,
    };
    let header = [
        "product of alphas",
        "paper",
        "exponent of the sum",
        "exponent measured",
        "N_v at the largest n",
    ];
    Ok(Section {
        id: "table1".to_owned(),
        title: "Table 1: classes of growth".to_owned(),
        lead: Lead::Claim(
            "The product of the alphas decides: N_v is O(1) below 1/4, O(lg n) at 1/4, O(n^0.5) at sqrt(1/8), \
                O(n^1.58) at 3/4, O(n^2) at 1. (The first row is printed as 1/4 and must read < 1/4.)"
                .to_owned(),
            if worst < lab.choose(0.1, 0.4) { Verdict::Holds } else { Verdict::DoesNotHold },
        ),
        measured: format!(
            "Exponents over the last {LAST} sizes are within {worst:.2} of those of the paper's sum over the same sizes."
        ),
        blocks: vec![lab.plot("table1", &chart)?, Block::Table(Table::new(header, table))],
    })
}
