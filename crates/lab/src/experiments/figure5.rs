//! Figure 5: `N_v` against `n`, the mean over delta = 0 ... 0.9, against Eq 11.

use crate::delta::overlap_probability;
use crate::fit::PowerLaw;
use crate::paper;

use super::Lab;
use super::sample::{Mean, Rule, Setting};
use crate::report::{
    Axis, Block, Chart, Failure, Lead, Section, Series, Shape, Table, Verdict, short,
};

const ALPHAS: [f64; 2] = [0.7, 0.9];
const LAST: usize = 5;

/// `N_v` of artificial trees at `delta`, the exact mean over lateral offsets and random corners, level by level.
pub fn exact_visits(alpha: [f64; 3], delta: f64, depth: u32) -> f64 {
    let lateral = alpha[1] * alpha[2];
    let probability =
        |l: u32| overlap_probability(alpha[0], l, 1.0 - delta) * lateral.powi(l as i32);
    (0..=depth).map(|l| paper::eq1(l, probability(l))).sum()
}

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
    let value = means.iter().map(|mean| mean.value).sum::<f64>() / 10.0;
    Mean {
        value,
        error: means
            .iter()
            .map(|mean| mean.error * mean.error)
            .sum::<f64>()
            .sqrt()
            / 10.0,
    }
}

/// `N_v` for each number of leaves at one alpha.
struct Curves {
    n: Vec<f64>,
    random: Vec<f64>,
    fixed: Vec<f64>,
    eq11: Vec<f64>,
    exact: Vec<f64>,
}

impl Curves {
    fn points(&self, values: &[f64]) -> Vec<[f64; 2]> {
        self.n
            .iter()
            .zip(values)
            .map(|(&n, &value)| [n, value])
            .collect()
    }

    /// The exponent over the last sizes.
    fn exponent(&self, values: &[f64]) -> f64 {
        let points = self.points(values);
        PowerLaw::fit(&points[points.len() - LAST..]).map_or(f64::NAN, |law| law.exponent())
    }

    /// A line of the table: exponents, then how the largest counts compare with Eq 11.
    fn row(&self, alpha: f64) -> Vec<String> {
        let Self {
            random,
            fixed,
            eq11,
            ..
        } = self;
        let last = self.n.len() - 1;
        let exponents = [eq11, random, fixed].map(|values| self.exponent(values));
        let ratios = [random, fixed].map(|values| values[last] / eq11[last]);
        std::iter::once(alpha)
            .chain(exponents)
            .chain(ratios)
            .map(short)
            .collect()
    }

    fn series(&self, alpha: f64, color: usize) -> [Series; 4] {
        [
            Series::new(
                format!("random corners, alpha {alpha}"),
                color,
                Shape::Points(self.points(&self.random)),
            ),
            Series::new(
                format!("fixed corners, alpha {alpha}"),
                color + 1,
                Shape::Points(self.points(&self.fixed)),
            ),
            Series::new(
                format!("Eq 11, alpha {alpha}"),
                color,
                Shape::Line(self.points(&self.eq11)),
            ),
            Series::new(
                format!("exact, alpha {alpha}"),
                color,
                Shape::Dashed(self.points(&self.exact)),
            ),
        ]
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

    let (mut csv, mut series, mut table, mut ratios) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (i, (alpha, means)) in ALPHAS
        .into_iter()
        .zip(means.chunks(2 * depths.len()))
        .enumerate()
    {
        let (random, fixed) = means.split_at(depths.len());
        let values = |means: &[Mean]| means.iter().map(|mean| mean.value).collect();
        let exact = |depth: u32| {
            deltas()
                .map(|delta| exact_visits([alpha; 3], delta, depth))
                .sum::<f64>()
                / 10.0
        };
        let curves = Curves {
            n: depths
                .iter()
                .map(|&depth| f64::from(depth).exp2())
                .collect(),
            random: values(random),
            fixed: values(fixed),
            eq11: depths
                .iter()
                .map(|&depth| paper::eq11([alpha; 3], depth))
                .collect(),
            exact: depths.iter().map(|&depth| exact(depth)).collect(),
        };
        let Curves {
            n,
            random,
            fixed,
            eq11,
            exact,
        } = &curves;
        for k in 0..n.len() {
            csv.push(
                [alpha, n[k], random[k], fixed[k], eq11[k], exact[k]]
                    .map(|x| x.to_string())
                    .to_vec(),
            );
            ratios.push(random[k] / exact[k]);
        }
        table.push(curves.row(alpha));
        series.extend(curves.series(alpha, 2 * i));
    }
    lab.csv(
        "figure5",
        "alpha,n,random_corners,fixed_corners,eq11,exact",
        &csv,
    )?;
    let chart = Chart {
        title: "Figure 5: mean over delta = 0, 0.1 ... 0.9".to_owned(),
        x: Axis::log("leaves n"),
        y: Axis::log("N_v"),
        series,
    };
    section(lab, &chart, table, &ratios, bounded)
}

fn section(
    lab: &Lab,
    chart: &Chart,
    table: Vec<Vec<String>>,
    ratios: &[f64],
    bounded: bool,
) -> Result<Section, Failure> {
    let words = |row: &Vec<String>| {
        format!(
            "alpha {}: exponent {} against {}, N_v / Eq 11 = {}",
            row[0], row[2], row[1], row[4]
        )
    };
    let header = [
        "alpha",
        "exponent of Eq 11",
        "random corners",
        "fixed corners",
        "N_v / Eq 11, random, largest n",
        "N_v / Eq 11, fixed, largest n",
    ];
    Ok(Section {
        id: "figure5".to_owned(),
        title: "Figure 5: mean over delta".to_owned(),
        lead: Lead::Claim(
            "Averaged over delta = 0 ... 0.9, Eq 11 is an upper bound and has the right growth."
                .to_owned(),
            if bounded {
                Verdict::Holds
            } else {
                Verdict::DoesNotHold
            },
        ),
        measured: format!(
            "{}. Measured over the exact mean of our delta model: {:.2} to {:.2}.",
            table.iter().map(words).collect::<Vec<_>>().join("; "),
            ratios.iter().copied().fold(f64::MAX, f64::min),
            ratios.iter().copied().fold(f64::MIN, f64::max),
        ),
        blocks: vec![
            lab.plot("figure5", chart)?,
            Block::Table(Table::new(header, table)),
        ],
    })
}
