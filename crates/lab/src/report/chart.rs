//! Charts: lines, points, bands, intervals and columns between two axes.

use super::frame::{self, Frame, LEFT, ROW, WIDTH, polyline};
use super::palette::SERIES;
use super::{Axis, Draw};

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
    color: usize,
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

impl Shape {
    /// A line through points, dashed or not.
    pub fn line(points: Vec<[f64; 2]>, is_dashed: bool) -> Self {
        if is_dashed {
            Self::Dashed(points)
        } else {
            Self::Line(points)
        }
    }
}

impl Series {
    /// Series with the same `color` number look alike; there are eight.
    pub fn new(name: impl Into<String>, color: usize, shape: Shape) -> Self {
        Self {
            name: name.into(),
            color: color % SERIES,
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

    fn svg(&self, frame: &Frame) -> String {
        let nearest = |x, y| frame.nearest_place(x, y);
        match &self.shape {
            Shape::Line(points) | Shape::Dashed(points) => {
                // What is outside the frame parts a line.
                let places: Vec<_> = points.iter().map(|&[x, y]| frame.place(x, y)).collect();
                let pieces = places.split(Option::is_none);
                let pieces = pieces.map(|piece| piece.iter().flatten().copied().collect());
                pieces.map(|piece: Vec<_>| self.outline(&piece)).collect()
            }
            Shape::Points(points) => {
                let places = points.iter().filter_map(|&[x, y]| frame.place(x, y));
                places.map(|place| self.dot(place)).collect()
            }
            Shape::Band(bars) => {
                let low = bars.iter().filter_map(|&[x, low, _]| nearest(x, low));
                let high = bars
                    .iter()
                    .rev()
                    .filter_map(|&[x, _, high]| nearest(x, high));
                self.outline(&low.chain(high).collect::<Vec<_>>())
            }
            Shape::Intervals(bars) => bars
                .iter()
                .filter_map(|&[x, low, high]| Some([nearest(x, low)?, nearest(x, high)?]))
                .map(|ends| self.outline(&ends))
                .collect(),
            Shape::Columns(columns) => columns
                .iter()
                .filter_map(|&[l, r, height]| Some([nearest(l, height)?, nearest(r, height)?]))
                .map(|[l, r]| self.outline(&[l, r, [r[0], frame.bottom()], [l[0], frame.bottom()]]))
                .collect(),
        }
    }

    /// A sample of it for the legend, 24 units wide.
    fn key(&self, x: f64, y: f64) -> String {
        let (middle, right) = (x + 12.0, x + 24.0);
        match &self.shape {
            Shape::Line(_) | Shape::Dashed(_) => self.outline(&[[x, y], [right, y]]),
            Shape::Points(_) => self.dot([middle, y]),
            Shape::Intervals(_) => self.outline(&[[middle, y - 7.0], [middle, y + 7.0]]),
            Shape::Band(_) | Shape::Columns(_) => {
                let (top, bottom) = (y - 6.0, y + 6.0);
                self.outline(&[[x, top], [right, top], [right, bottom], [x, bottom]])
            }
        }
    }

    fn outline(&self, points: &[[f64; 2]]) -> String {
        let look = match self.shape {
            Shape::Dashed(_) => "line dashed",
            Shape::Band(_) => "band",
            Shape::Columns(_) => "column",
            _ => "line",
        };
        polyline(&format!("s{} {look}", self.color), points)
    }

    fn dot(&self, [x, y]: [f64; 2]) -> String {
        let color = self.color;
        format!("<circle class=\"s{color} dot\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\"/>\n")
    }
}

/// About the width of a text, units.
fn text_width(text: &str) -> f64 {
    7.5 * text.chars().count() as f64
}

impl Draw for Chart {
    fn svg(&self) -> String {
        let below_title = frame::below_title(&self.title);
        let (mut drawn, mut x, mut row) = (String::new(), LEFT, 0.0);
        for series in self.series.iter().filter(|series| !series.name.is_empty()) {
            let width = 24.0 + 6.0 + text_width(&series.name) + 18.0;
            if x > LEFT && x + width > WIDTH {
                (x, row) = (LEFT, row + 1.0);
            }
            let y = below_title + 4.0 + ROW * row;
            drawn += &series.key(x, y - 1.5);
            drawn += &frame::text("", [x + 30.0, y], &series.name);
            x += width;
        }
        let rows = if x > LEFT { row + 1.0 } else { 0.0 };
        let corners: Vec<[f64; 2]> = self.series.iter().flat_map(Series::corners).collect();
        let frame = Frame {
            x: &self.x,
            y: &self.y,
            x_span: self.x.span(corners.iter().map(|corner| corner[0])),
            y_span: self.y.span(corners.iter().map(|corner| corner[1])),
            right: WIDTH - 20.0,
            top: below_title + ROW * rows,
        };
        drawn.extend(self.series.iter().map(|series| series.svg(&frame)));
        frame.picture(&self.title, &drawn)
    }
}
