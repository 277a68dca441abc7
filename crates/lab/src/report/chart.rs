//! Charts: lines, points, bands, intervals and columns between two axes.

use plotters::prelude::*;

use super::frame::{self, Canvas, Frame, ROW, WIDTH, pixels, point};
use super::palette::SERIES;
use super::{Axis, Draw, Failure, PIXELS};

/// A chart with a legend above it.
pub struct Chart {
    /// What stands above it.
    pub title: String,
    /// The axis below.
    pub x: Axis,
    /// The axis to the left.
    pub y: Axis,
    /// What is drawn, the first at the bottom.
    pub series: Vec<Series>,
}

/// Some points of one colour; without a name they are not in the legend. What is outside a fixed range is not drawn.
pub struct Series {
    name: String,
    color: RGBColor,
    shape: Shape,
}

/// How points are drawn; `x` first.
pub enum Shape {
    /// A line through the points.
    Line(Vec<[f64; 2]>),
    /// A dashed line through the points.
    Dashed(Vec<[f64; 2]>),
    /// A dot each.
    Points(Vec<[f64; 2]>),
    /// `[x, low, high]`: an area.
    Band(Vec<[f64; 3]>),
    /// `[x, low, high]`: a bar each.
    Intervals(Vec<[f64; 3]>),
    /// `[left, right, height]`: columns that stand on the axis.
    Columns(Vec<[f64; 3]>),
}

impl Series {
    /// Series with the same `color` number look alike; there are eight.
    pub fn new(name: impl Into<String>, color: usize, shape: Shape) -> Self {
        Self {
            name: name.into(),
            color: SERIES[color % SERIES.len()].light,
            shape,
        }
    }

    fn corners(&self) -> Vec<[f64; 2]> {
        match &self.shape {
            Shape::Line(points) | Shape::Dashed(points) | Shape::Points(points) => points.clone(),
            Shape::Band(bars) | Shape::Intervals(bars) => bars
                .iter()
                .flat_map(|&[x, low, high]| [[x, low], [x, high]])
                .collect(),
            Shape::Columns(columns) => columns
                .iter()
                .flat_map(|&[l, r, height]| [[l, height], [r, height]])
                .collect(),
        }
    }

    fn draw<DB: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &Canvas<DB>,
        frame: &Frame,
    ) -> Result<(), Failure> {
        match &self.shape {
            Shape::Line(points) => {
                for piece in pieces(points, frame) {
                    canvas.draw(&PathElement::new(piece, self.stroke()))?;
                }
            }
            Shape::Dashed(points) => {
                for dash in pieces(points, frame).iter().flat_map(|piece| dashes(piece)) {
                    canvas.draw(&PathElement::new(dash, self.stroke()))?;
                }
            }
            Shape::Points(points) => {
                for pixel in points.iter().filter_map(|&[x, y]| frame.pixel(x, y)) {
                    canvas.draw(&Circle::new(pixel, pixels(3.5), self.color.filled()))?;
                }
            }
            Shape::Band(bars) => {
                let low = bars
                    .iter()
                    .filter_map(|&[x, low, _]| frame.nearest_pixel(x, low));
                let high = bars
                    .iter()
                    .rev()
                    .filter_map(|&[x, _, high]| frame.nearest_pixel(x, high));
                canvas.draw(&Polygon::new(
                    low.chain(high).collect::<Vec<_>>(),
                    self.color.mix(0.2),
                ))?;
            }
            Shape::Intervals(bars) => {
                for &[x, low, high] in bars {
                    let ends = [frame.nearest_pixel(x, low), frame.nearest_pixel(x, high)];
                    let bar: Vec<_> = ends.into_iter().flatten().collect();
                    canvas.draw(&PathElement::new(bar, self.stroke()))?;
                }
            }
            Shape::Columns(columns) => {
                for &[left, right, height] in columns {
                    let corners = [
                        frame.nearest_pixel(left, height),
                        frame.nearest_pixel(right, height),
                    ];
                    if let [Some(from), Some((x, _))] = corners {
                        canvas.draw(&Rectangle::new(
                            [from, (x, pixels(frame.bottom))],
                            self.color.mix(0.6).filled(),
                        ))?;
                    }
                }
            }
        }
        Ok(())
    }

    /// A sample of it for the legend, 24 units wide.
    fn draw_key<DB: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &Canvas<DB>,
        x: f64,
        y: f64,
    ) -> Result<(), Failure> {
        let (left, right) = (point(x, y), point(x + 24.0, y));
        match &self.shape {
            Shape::Line(_) => canvas.draw(&PathElement::new([left, right], self.stroke()))?,
            Shape::Dashed(_) => {
                for dash in dashes(&[left, right]) {
                    canvas.draw(&PathElement::new(dash, self.stroke()))?;
                }
            }
            Shape::Points(_) => {
                canvas.draw(&Circle::new(
                    point(x + 12.0, y),
                    pixels(3.5),
                    self.color.filled(),
                ))?;
            }
            Shape::Intervals(_) => {
                canvas.draw(&PathElement::new(
                    [point(x + 12.0, y - 7.0), point(x + 12.0, y + 7.0)],
                    self.stroke(),
                ))?;
            }
            Shape::Band(_) | Shape::Columns(_) => {
                let corners = [point(x, y - 6.0), point(x + 24.0, y + 6.0)];
                canvas.draw(&Rectangle::new(corners, self.color.mix(0.4).filled()))?;
            }
        }
        Ok(())
    }

    fn stroke(&self) -> ShapeStyle {
        self.color.stroke_width(2 * PIXELS)
    }
}

/// The parts of a line that are within the frame.
fn pieces(points: &[[f64; 2]], frame: &Frame) -> Vec<Vec<(i32, i32)>> {
    let pixels: Vec<_> = points.iter().map(|&[x, y]| frame.pixel(x, y)).collect();
    pixels
        .split(Option::is_none)
        .map(|piece| piece.iter().flatten().copied().collect())
        .collect()
}

/// A line cut into dashes.
fn dashes(line: &[(i32, i32)]) -> Vec<Vec<(i32, i32)>> {
    let (on, off) = (f64::from(pixels(7.0)), f64::from(pixels(5.0)));
    let mut dashes = Vec::new();
    // How far into the pattern the next stretch begins.
    let mut phase = 0.0;
    for ends in line.windows(2) {
        let [from, to] = [ends[0], ends[1]].map(|(x, y)| (f64::from(x), f64::from(y)));
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        let at = |s: f64| {
            let t = (s / length).clamp(0.0, 1.0);
            (
                (from.0 + (to.0 - from.0) * t).round() as i32,
                (from.1 + (to.1 - from.1) * t).round() as i32,
            )
        };
        let mut start = -phase;
        while start < length {
            if start + on > 0.0 {
                dashes.push(vec![at(start), at(start + on)]);
            }
            start += on + off;
        }
        phase = (length + phase) % (on + off);
    }
    dashes
}

/// Height of the plot itself, units.
const HEIGHT: f64 = 260.0;

impl Chart {
    /// The named series with their places in the legend: left end and row.
    fn legend(&self) -> Vec<(&Series, f64, usize)> {
        let (mut x, mut row) = (frame::LEFT, 0);
        let mut legend = Vec::new();
        for series in self.series.iter().filter(|series| !series.name.is_empty()) {
            let width = 24.0 + 6.0 + frame::text_width(&series.name) + 18.0;
            if x > frame::LEFT && x + width > WIDTH {
                (x, row) = (frame::LEFT, row + 1);
            }
            legend.push((series, x, row));
            x += width;
        }
        legend
    }

    fn top(&self) -> f64 {
        let rows = self.legend().last().map_or(0, |(.., row)| row + 1);
        frame::below_title(&self.title) + ROW * rows as f64
    }
}

impl Draw for Chart {
    fn size(&self) -> (u32, u32) {
        (WIDTH as u32, (self.top() + HEIGHT + frame::BELOW) as u32)
    }

    fn draw<DB: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &Canvas<DB>,
    ) -> Result<(), Failure> {
        frame::title(canvas, &self.title)?;
        for (series, x, row) in self.legend() {
            let y = frame::below_title(&self.title) + 4.0 + ROW * row as f64;
            series.draw_key(canvas, x, y - 1.5)?;
            frame::text(canvas, &series.name, x + 30.0, y)?;
        }
        let corners: Vec<[f64; 2]> = self.series.iter().flat_map(Series::corners).collect();
        let frame = Frame {
            x: &self.x,
            y: &self.y,
            x_span: self.x.span(corners.iter().map(|corner| corner[0])),
            y_span: self.y.span(corners.iter().map(|corner| corner[1])),
            left: frame::LEFT,
            right: WIDTH - 20.0,
            top: self.top(),
            bottom: self.top() + HEIGHT,
        };
        frame.draw(canvas)?;
        self.series
            .iter()
            .try_for_each(|series| series.draw(canvas, &frame))
    }
}
