//! What experiments leave behind: plots as SVG, CSV files, and one HTML page that needs nothing else.

mod axis;
mod chances;
mod chart;
mod frame;
mod heat_map;
mod page;
mod palette;

pub use axis::Axis;
pub use chances::Chances;
pub use chart::{Chart, Series, Shape};
pub use heat_map::HeatMap;
pub use page::{Block, Lead, Page, Section, Table, Verdict};

use std::error::Error;
use std::fs;
use std::path::Path;

/// Why something could not be read or written, in words that name the file.
pub type Failure = Box<dyn Error>;

/// Something that can be drawn.
pub trait Draw {
    /// A whole `<svg>` element, light or dark as the reader prefers.
    fn svg(&self) -> String;
}

/// Writes a drawing as `NAME.svg`, and returns it for a page.
///
/// # Errors
/// If the file cannot be written.
pub fn plot(folder: &Path, name: &str, drawing: &impl Draw) -> Result<Block, Failure> {
    let svg = drawing.svg();
    write(&folder.join(format!("{name}.svg")), &svg)?;
    Ok(Block::Picture(svg))
}

/// Makes the folder that a report goes to.
pub fn create_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()).into())
}

/// Reads a text file; an error names it.
pub fn read(file: &Path) -> Result<String, Failure> {
    fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()).into())
}

/// Writes a file; an error names it.
pub fn write(file: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
    fs::write(file, content).map_err(|error| format!("{}: {error}", file.display()).into())
}

/// Writes a CSV file: a header, and a line for each row. Fields must hold no comma.
pub fn write_csv(
    folder: &Path,
    name: &str,
    header: &str,
    rows: &[Vec<String>],
) -> Result<(), Failure> {
    let file = folder.join(format!("{name}.csv"));
    let lines = std::iter::once(header.to_owned()).chain(rows.iter().map(|row| row.join(",")));
    write(&file, lines.map(|line| line + "\n").collect::<String>())
}

/// A number for people: three significant digits, whole from 1000 on.
pub fn short(value: f64) -> String {
    let digits = if value == 0.0 || !value.is_finite() {
        0.0
    } else {
        value.abs().log10().floor()
    };
    let decimals = (2.0 - digits).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A number for machines, with as many decimals at the most; empty where there is none.
pub fn cell(value: f64, decimals: usize) -> String {
    if value.is_nan() {
        return String::new();
    }
    let text = format!("{value:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn shapes() -> Vec<Series> {
        let points = vec![
            [1.0, 10.0],
            [2.0, 100.0],
            [3.0, -5.0],
            [4.0, f64::NAN],
            [5.0, 1e4],
            [6.0, 2e4],
        ];
        let bars = vec![[1.0, 5.0, 20.0], [3.0, 50.0, 2000.0], [6.0, 1e4, 1e5]];
        let shapes = [
            Shape::Line(points.clone()),
            Shape::Dashed(points.clone()),
            Shape::Points(points),
            Shape::Band(bars.clone()),
            Shape::Intervals(bars),
            Shape::Columns(vec![[1.0, 2.0, 30.0], [2.0, 3.0, 300.0]]),
        ];
        shapes
            .into_iter()
            .enumerate()
            .map(|(i, shape)| Series::new(format!("series {i}"), i, shape))
            .collect()
    }

    fn assert_drawn(drawing: &impl Draw, words: &[&str]) {
        let svg = drawing.svg();
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
        for word in words {
            assert!(svg.contains(word), "no {word}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    #[test]
    fn every_shape_is_drawn_on_every_kind_of_axis() {
        for y in [
            Axis::linear("up"),
            Axis::log("up"),
            Axis::log("up").range(20.0..1000.0),
        ] {
            let chart = Chart {
                title: "All <shapes>".into(),
                x: Axis::linear("along"),
                y,
                series: shapes(),
            };
            assert_drawn(
                &chart,
                &[
                    "along",
                    "All &lt;shapes&gt;",
                    "series 5",
                    "circle",
                    "polyline",
                ],
            );
        }
        let nothing = Chart {
            title: "Nothing".into(),
            x: Axis::log("n"),
            y: Axis::log("N"),
            series: vec![],
        };
        assert_drawn(&nothing, &["Nothing"]);
    }

    #[test]
    fn each_colour_of_a_chart_has_a_dark_counterpart() {
        let svg = Chart {
            title: "Dark".into(),
            x: Axis::linear("x"),
            y: Axis::log("y"),
            series: shapes(),
        }
        .svg();
        let (style, drawn) = svg.split_once("</style>").unwrap();
        let (light, dark) = style
            .split_once("@media(prefers-color-scheme:dark)")
            .unwrap();
        let classes = drawn.split("class=\"").skip(1);
        let colors: BTreeSet<&str> = classes
            .map(|rest| rest.split([' ', '"']).next().unwrap())
            .collect();
        assert!(colors.len() > 6);
        for color in colors {
            let rule = format!(".{color}{{color:#");
            assert!(light.contains(&rule) && dark.contains(&rule), "{color}");
        }
    }

    #[test]
    fn long_titles_are_wrapped() {
        let lines = |title: &str| {
            let chart = Chart {
                title: title.into(),
                x: Axis::linear(""),
                y: Axis::linear(""),
                series: vec![],
            };
            let svg = chart.svg();
            (
                svg.matches("ink title").count(),
                svg.matches("many").count(),
            )
        };
        assert_eq!(lines("Short").0, 1);
        assert_eq!(lines(&"many words ".repeat(9)), (2, 9));
    }

    #[test]
    fn heat_maps_are_drawn() {
        let map = HeatMap {
            title: "Heat".into(),
            x: Axis::linear("delta"),
            y: Axis::linear("alpha"),
            x_edges: vec![0.0, 0.5, 1.0],
            y_edges: vec![0.5, 0.7, 0.9],
            values: vec![1.0, 10.0, 100.0, 0.0],
            color: Axis::log("visits"),
        };
        assert_drawn(&map, &["Heat", "delta", "visits"]);
    }

    #[test]
    fn pages_hold_everything_and_refer_to_nothing() {
        let section = Section {
            id: "one".into(),
            title: "One & only".into(),
            lead: Lead::Claim("a < b".into(), Verdict::DoesNotHold),
            measured: "a > b".into(),
            blocks: vec![
                Block::Details("More & more".into(), vec![Block::Text("inside".into())]),
                Block::Picture("<?xml?><svg></svg>".into()),
                Block::Table(Table::new(["n"], vec![vec!["<1>".into()]])),
                Block::Text("words".into()),
            ],
        };
        let shown = Section {
            id: "two".into(),
            lead: Lead::Shows("c over d".into()),
            blocks: vec![],
            ..section.clone()
        };
        let html = Page {
            title: "T".into(),
            intro: vec!["hello".into()],
            sections: vec![section, shown],
        }
        .html();
        for part in [
            "One &amp; only",
            "a &lt; b",
            "<svg></svg>",
            "&lt;1&gt;",
            "words",
            "href=\"#one\"",
            "<summary>More &amp; more</summary>",
            "inside",
            "c over d",
        ] {
            assert!(html.contains(part), "no {part}");
        }
        // In the contents and at the claim; what is only shown has no verdict.
        assert_eq!(
            (
                html.matches("does not hold").count(),
                html.matches("<h3>Claim</h3>").count()
            ),
            (2, 1)
        );
        assert!(!html.contains("<?xml") && !html.contains("<script") && !html.contains("http"));
    }

    #[test]
    fn numbers_in_tables() {
        let values = [f64::NAN, 0.5, 2.0, 1.0 / 3.0, f64::INFINITY];
        let texts = ["", "0.5", "2", "0.333", "inf"];
        assert_eq!(values.map(|value| cell(value, 3)), texts);
    }

    #[test]
    fn short_numbers() {
        let values = [
            0.0,
            0.001234,
            0.5,
            1.0,
            12.345,
            123.4,
            1234.5,
            -0.25,
            f64::NAN,
        ];
        let texts = [
            "0", "0.00123", "0.5", "1", "12.3", "123", "1234", "-0.25", "NaN",
        ];
        assert_eq!(values.map(short), texts);
    }

    #[test]
    fn files_that_cannot_be_written_are_named() {
        let error = write(Path::new("no/such/folder/x.csv"), "")
            .unwrap_err()
            .to_string();
        assert!(error.contains("no/such/folder/x.csv"), "{error}");
    }
}
