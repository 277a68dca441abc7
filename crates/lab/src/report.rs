//! What experiments leave behind: plots as SVG and PNG, CSV files, and one HTML page that needs nothing else.
//!
//! Text in plots is set in a font that comes with the program, so that a machine without fonts draws the same pictures.

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
use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::{BitMapBackend, DrawingArea, DrawingBackend, IntoDrawingArea, SVGBackend};
use plotters::style::{FontStyle, register_font};

/// Why something could not be read, drawn or written, in words that name the file.
pub type Failure = Box<dyn Error>;

/// Pixels a unit: SVG coordinates of the plotting crate are whole numbers, so pictures are drawn large and shown small.
const PIXELS: u32 = 2;
const FONT: &str = "sans-serif";

/// Something that can be drawn. `E` is the trouble that a canvas makes.
pub trait Draw {
    /// Width and height in units; a page shows a unit as a pixel.
    fn size(&self) -> (u32, u32);

    /// Draws it on a canvas of two pixels a unit.
    ///
    /// # Errors
    /// Those of the canvas.
    fn draw<DB: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &DrawingArea<DB, Shift>,
    ) -> Result<(), Failure>;
}

/// A drawing, rendered.
pub struct Picture {
    /// A whole `<svg>` element, light or dark as the reader prefers.
    pub svg: String,
    png: Vec<u8>,
}

impl Picture {
    /// Draws it as SVG, and as PNG, which is always light.
    ///
    /// # Errors
    /// If the plotting crate cannot draw it.
    pub fn render(drawing: &impl Draw) -> Result<Self, Failure> {
        static REGISTER: Once = Once::new();
        REGISTER.call_once(|| {
            // Refused only if the font were damaged; text then fails to draw, with an error of its own.
            let _ = register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
        });
        let (width, height) = drawing.size();
        let (width, height) = (width * PIXELS, height * PIXELS);
        let mut svg = String::new();
        let canvas = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        paint(drawing, &canvas)?;
        drop(canvas);
        let mut pixels = vec![0; 3 * (width * height) as usize];
        let canvas = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
        paint(drawing, &canvas)?;
        drop(canvas);
        Ok(Self {
            svg: palette::with_dark_mode(&svg),
            png: encode(&pixels, width, height)?,
        })
    }

    /// Writes `NAME.svg` and `NAME.png`.
    pub fn write(&self, folder: &Path, name: &str) -> Result<(), Failure> {
        write(&folder.join(format!("{name}.svg")), &self.svg)?;
        write(&folder.join(format!("{name}.png")), &self.png)
    }
}

fn paint<DB: DrawingBackend<ErrorType: 'static>>(
    drawing: &impl Draw,
    canvas: &DrawingArea<DB, Shift>,
) -> Result<(), Failure> {
    canvas.fill(&palette::PAPER.light)?;
    drawing.draw(canvas)?;
    Ok(canvas.present()?)
}

fn encode(pixels: &[u8], width: u32, height: u32) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
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

#[cfg(test)]
mod tests {
    use super::*;

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
        let picture = Picture::render(drawing).unwrap();
        assert!(picture.svg.contains("<svg") && picture.svg.trim_end().ends_with("</svg>"));
        for word in words {
            assert!(picture.svg.contains(word), "no {word}");
        }
        let mut reader = png::Decoder::new(std::io::Cursor::new(&picture.png))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        // The title stands alone in the uppermost 36 units.
        let title = &pixels[..(3 * 36 * PIXELS * drawing.size().0 * PIXELS) as usize];
        let dark = title
            .chunks(3)
            .filter(|p| p.iter().all(|&c| c < 120))
            .count();
        assert!(dark > 100, "text must show: {dark} dark pixels");
        assert_eq!(picture.png, Picture::render(drawing).unwrap().png);
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
                &["along", "series 5", "polygon", "circle", "polyline"],
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
        let (x, y) = (Axis::linear("x"), Axis::log("y"));
        let svg = Picture::render(&Chart {
            title: "Dark".into(),
            x,
            y,
            series: shapes(),
        })
        .unwrap()
        .svg;
        let (style, drawn) = svg.split_once("</style>").unwrap();
        assert!(style.contains("prefers-color-scheme:dark"));
        let mut colors: Vec<&str> = drawn
            .split('"')
            .filter(|text| text.starts_with('#'))
            .collect();
        colors.sort_unstable();
        colors.dedup();
        assert!(colors.len() > 6);
        for color in colors {
            assert!(style.contains(&format!("[fill=\"{color}\"]")), "{color}");
        }
    }

    #[test]
    fn long_titles_are_wrapped() {
        let chart = |title: &str| Chart {
            title: title.into(),
            x: Axis::linear(""),
            y: Axis::linear(""),
            series: vec![],
        };
        let [short, long] = [chart("Short"), chart(&"many words ".repeat(9))];
        assert!(long.size().1 > short.size().1);
        assert_eq!(
            Picture::render(&long).unwrap().svg.matches("many").count(),
            9
        );
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
