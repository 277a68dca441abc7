//! Table 1: how `N_v` grows with `n`, by the product of the alphas.

use crate::paper::{self, Growth};

use super::sample::{Rule, Setting};
use super::{Lab, exponent, leaves};
use crate::report::{Axis, Block, Chart, Failure, Section, Series, Shape, Table, short};

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
    let deepest = lab.choose(13, 9);
    let settings = PRODUCTS.iter().flat_map(|&(_, product, most)| {
        (FIRST_DEPTH..=most.min(deepest)).map(move |depth| (product, depth))
    });
    let settings: Vec<(f64, u32)> = settings.collect();
    let counts = lab.all(&settings, |&(product, depth)| {
        let setting = Setting {
            alpha: [product.cbrt(); 3],
            depth,
            rule: Rule::Random,
            delta: None,
        };
        setting.mean(&lab.effort(), u64::from(depth)).value
    });
    let (mut csv, mut table, mut series, mut worst) = (Vec::new(), Vec::new(), Vec::new(), 0f64);
    for (i, &(name, product, _)) in PRODUCTS.iter().enumerate() {
        let of_product = settings.iter().zip(&counts);
        let of_product = of_product.filter(|(setting, _)| setting.0 == product);
        let (mut counted, mut sums) = (Vec::new(), Vec::new());
        for (&(_, depth), &visits) in of_product {
            // What the finite sum itself gives over the same sizes.
            let sum = paper::eq11([product.cbrt(); 3], depth);
            counted.push([leaves(depth), visits]);
            sums.push([leaves(depth), sum]);
            csv.push([product, leaves(depth), visits, sum]);
        }
        let [measured, expected] = [&counted, &sums].map(|points| exponent(points, LAST));
        worst = worst.max((measured - expected).abs());
        let growth = match Growth::of(product) {
            Growth::Constant => "O(1)".to_owned(),
            Growth::Logarithmic => "O(lg n)".to_owned(),
            Growth::Power(exponent) => format!("O(n^{exponent:.2})"),
        };
        table.push(vec![
            name.to_owned(),
            growth,
            format!("{expected:.2}"),
            format!("{measured:.2}"),
            short(counted[counted.len() - 1][1]),
        ]);
        series.push(Series::new("", i, Shape::Points(counted)));
        series.push(Series::new(format!("product {name}"), i, Shape::Line(sums)));
    }
    lab.csv("table1", "alpha_product,n,visits,eq11", csv)?;
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
    Ok(Section::claims(
        "table1",
        "Table 1: classes of growth",
        (
            "The product of the alphas decides: N_v is O(1) below 1/4, O(lg n) at 1/4, O(n^0.5) at sqrt(1/8), \
             O(n^1.58) at 3/4, O(n^2) at 1. (The first row is printed as 1/4 and must read < 1/4.)",
            (worst < lab.choose(0.1, 0.4)).into(),
        ),
        format!(
            "Exponents over the last {LAST} sizes are within {worst:.2} of those of the paper's sum over the same sizes."
        ),
        vec![
            lab.plot("table1", &chart)?,
            Block::Table(Table::new(header, table)),
        ],
    ))
}
