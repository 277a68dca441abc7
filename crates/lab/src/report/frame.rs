//! The frame of a plot: title, axes with ticks and grid, and the map from values to places. Lengths
//! are in units of the picture, which a page shows as pixels.

use std::ops::Range;

use punctual_view::escape;

use super::Axis;
use super::palette::style;

/// Width of a picture. On a telephone, 400 pixels wide, text is then 12 pixels high.
pub(super) const WIDTH: f64 = 480.0;

/// Height of the plot itself.
pub(super) const HEIGHT: f64 = 260.0;

/// From line to line.
pub(super) const ROW: f64 = 22.0;

/// Room that the labels of the y axis and of the x axis need.
pub(super) const LEFT: f64 = 76.0;
const BELOW: f64 = 56.0;

/// Where the plot is, and what it shows (places on the axes).
pub(super) struct Frame<'a> {
    pub x: &'a Axis,
    pub y: &'a Axis,
    pub x_span: Range<f64>,
    pub y_span: Range<f64>,
    pub right: f64,
    pub top: f64,
}

/// A line through points, or the area within them, as the class says.
pub(super) fn polyline(class: &str, points: &[[f64; 2]]) -> String {
    let points: Vec<_> = points
        .iter()
        .map(|[x, y]| format!("{x:.1},{y:.1}"))
        .collect();
    format!(
        "<polyline class=\"{class}\" points=\"{}\"/>\n",
        points.join(" ")
    )
}

/// Text, centred in height, at a place: from there on, about it for `middle`, up to it for `end`.
pub(super) fn text(class: &str, [x, y]: [f64; 2], text: &str) -> String {
    let (y, text) = (y + 5.0, escape(text));
    format!("<text class=\"ink {class}\" x=\"{x:.1}\" y=\"{y:.1}\">{text}</text>\n")
}

/// The title, wrapped at blanks.
fn title_lines(text: &str) -> Vec<String> {
    let room = ((WIDTH - 24.0) / 9.0) as usize;
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= room => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Where what stands below the title begins.
pub(super) fn below_title(text: &str) -> f64 {
    22.0 + ROW * title_lines(text).len() as f64
}

impl Frame<'_> {
    /// The place of a value in the picture; `None` outside the frame.
    pub fn place(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let (x, y) = (self.x.place(x), self.y.place(y));
        let is_inside = |place: f64, span: &Range<f64>| place >= span.start && place <= span.end;
        (is_inside(x, &self.x_span) && is_inside(y, &self.y_span))
            .then(|| [self.across(x), self.down(y)])
    }

    /// That of the nearest value within the frame; `None` for a value without a place.
    pub fn nearest_place(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let (x, y) = (self.x.place(x), self.y.place(y));
        let into = |place: f64, span: &Range<f64>| place.clamp(span.start, span.end);
        let is_known = !x.is_nan() && !y.is_nan();
        is_known.then(|| {
            [
                self.across(into(x, &self.x_span)),
                self.down(into(y, &self.y_span)),
            ]
        })
    }

    pub fn bottom(&self) -> f64 {
        self.top + HEIGHT
    }

    fn across(&self, place: f64) -> f64 {
        let share = (place - self.x_span.start) / (self.x_span.end - self.x_span.start);
        LEFT + share * (self.right - LEFT)
    }

    fn down(&self, place: f64) -> f64 {
        let share = (place - self.y_span.start) / (self.y_span.end - self.y_span.start);
        self.bottom() - share * HEIGHT
    }

    /// The whole picture: title, grid, ticks, labels and border, and what is drawn above them.
    pub fn picture(&self, title: &str, drawn: &str) -> String {
        let (top, bottom) = (self.top, self.bottom());
        let (width, height) = (WIDTH, bottom + BELOW);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {width} {height}\">\n\
             {}\n<rect class=\"paper dot\" width=\"100%\" height=\"100%\"/>\n",
            style()
        );
        for (row, line) in title_lines(title).iter().enumerate() {
            svg += &text("title", [12.0, 18.0 + ROW * row as f64], line);
        }
        for tick in self.x.ticks(&self.x_span) {
            let x = self.across(tick);
            svg += &polyline("grid line thin", &[[x, top], [x, bottom + 4.0]]);
            svg += &text("middle", [x, bottom + 16.0], &self.x.tick_label(tick));
        }
        for tick in self.y.ticks(&self.y_span) {
            let y = self.down(tick);
            svg += &polyline("grid line thin", &[[LEFT - 4.0, y], [self.right, y]]);
            svg += &text("end", [LEFT - 7.0, y], &self.y.tick_label(tick));
        }
        let middle = [(LEFT + self.right) / 2.0, bottom + BELOW - 14.0];
        svg += &text("middle", middle, &self.x.label);
        let beside = text("middle", [0.0, 0.0], &self.y.label);
        let middle = (top + bottom) / 2.0;
        svg += &format!("<g transform=\"translate(14 {middle:.1}) rotate(-90)\">{beside}</g>\n");
        svg += drawn;
        let [left, right] = [LEFT, self.right];
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        svg += &polyline("ink line thin", &[&corners[..], &corners[..1]].concat());
        svg + "</svg>\n"
    }
}
