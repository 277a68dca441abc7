//! `punctual paper --quick`: every file is there and whole, and the numbers agree with the model where the claim holds.

use std::collections::BTreeSet;

use crate::run::Folder;
use crate::write;
use punctual::shapes::icosphere;

const PLOTS: [&str; 11] = [
    "table1",
    "equation11",
    "figure4",
    "figure5",
    "figure6_alpha60",
    "figure6_alpha70",
    "figure6_alpha80",
    "figure7_n128",
    "figure7_n512",
    "spread",
    "spread_histogram",
];

/// The numbers of a CSV file by column; words are NaN.
struct Csv {
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Csv {
    fn read(folder: &Folder, name: &str) -> Self {
        let text = folder.read(&format!("report/{name}.csv"));
        let (header, rest) = text.split_once('\n').unwrap();
        let row = |line: &str| {
            line.split(',')
                .map(|field| field.parse().unwrap_or(f64::NAN))
                .collect()
        };
        let csv = Self {
            header: header.split(',').map(String::from).collect(),
            rows: rest.lines().map(row).collect(),
        };
        assert!(
            !csv.rows.is_empty() && csv.rows.iter().all(|row| row.len() == csv.header.len()),
            "{name}"
        );
        csv
    }

    fn get(&self, row: &[f64], column: &str) -> f64 {
        row[self.header.iter().position(|name| name == column).unwrap()]
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn the_quick_report_is_whole_and_agrees_with_the_model() {
    let folder = Folder::new();
    let answer = folder.ok("paper --out report --quick");
    assert_eq!(answer.out.lines().count(), 6);

    let page = folder.read("report/index.html");
    let shown = PLOTS.iter();
    assert_eq!(page.matches("<svg").count(), shown.clone().count());
    assert_eq!(page.matches("</svg>").count(), shown.clone().count());
    for outside in ["<script", "<link", "<img", "src=", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    for name in shown {
        assert!(
            folder
                .read(&format!("report/{name}.svg"))
                .contains("</svg>"),
            "{name}"
        );
    }

    let table1 = Csv::read(&folder, "table1");
    let ratios = table1
        .rows
        .iter()
        .map(|row| table1.get(row, "visits") / table1.get(row, "eq11"));
    assert!(
        ratios.clone().all(|ratio| (0.5..2.0).contains(&ratio)),
        "{:?}",
        ratios.collect::<Vec<_>>()
    );
    let equation11 = Csv::read(&folder, "equation11");
    let deviations = equation11
        .rows
        .iter()
        .map(|row| (equation11.get(row, "measured_over_eq11") - 1.0).abs());
    assert!(median(deviations.collect()) < 0.1);

    let figure6 = Csv::read(&folder, "figure6");
    let errors = figure6.rows.iter().map(|row| {
        let [exact, counted] = ["exact", "random_corners"].map(|name| figure6.get(row, name));
        (exact / counted).log2().abs()
    });
    assert!(median(errors.collect()) < 0.1);

    let shapes: BTreeSet<String> = folder
        .read("report/figure4.csv")
        .lines()
        .skip(1)
        .map(|line| line.split(',').next().unwrap().to_owned())
        .collect();
    assert_eq!(shapes.len(), 6);
}

#[test]
fn the_report_is_the_same_every_time() {
    let folder = Folder::new();
    for level in 0..3 {
        folder.write(&format!("ball_{level}.obj"), write::obj(&icosphere(level)));
    }
    let ladder = "--meshes ball_2.obj,ball_0.obj,ball_1.obj";
    let (one, two) = (
        folder.run(&format!("paper --out one --quick {ladder}")),
        folder.run(&format!("paper --out two --quick {ladder}")),
    );
    assert_eq!((one.status, one.out), (0, two.out));
    assert_eq!(folder.read("one/index.html"), folder.read("two/index.html"));
    let figure4 = folder.read("one/figure4.csv");
    let rungs: Vec<&str> = figure4
        .lines()
        .skip(1)
        .map(|line| line.rsplitn(6, ',').last().unwrap())
        .collect();
    assert_eq!(rungs, ["ball,20", "ball,80", "ball,320"]);
}

#[test]
fn bad_ladders_are_refused() {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&icosphere(0)));
    folder.write("empty.obj", "");
    folder.write("file", "");
    for (meshes, part) in [
        ("a.obj", "two sizes"),
        ("a.obj,a.obj", "two sizes"),
        ("a.obj,empty.obj", "empty.obj"),
        ("a.obj,no.obj", "no.obj"),
    ] {
        folder.refused(
            &format!("paper --out report --quick --meshes {meshes}"),
            &[part],
        );
    }
    folder.refused("paper --quick --out file/report", &["file/report"]);
    folder.refused("paper --quick", &["--out"]);
}
