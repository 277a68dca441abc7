//! The frame of a plot: title, axes with ticks and grid, and the map from values to pixels.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::palette::{GRID, INK};
use super::{Axis, FONT, Failure, PIXELS};

/// A canvas to draw on.
pub(super) type Canvas<DB> = DrawingArea<DB, Shift>;

/// Width of a picture, units. On a telephone, 400 pixels wide, text is then 12 pixels high.
pub(super) const WIDTH: f64 = 480.0;

/// Heights of text, units. SVG text comes out a fifth smaller, by a convention of the plotting crate.
const TITLE: f64 = 20.0;
const TEXT: f64 = 18.0;

/// From line to line, units.
pub(super) const ROW: f64 = 22.0;

/// Where the plot is (units) and what it shows (places on the axes).
pub(super) struct Frame<'a> {
    pub x: &'a Axis,
    pub y: &'a Axis,
    pub x_span: Range<f64>,
    pub y_span: Range<f64>,
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

/// Room that the labels of the y axis and of the x axis need, units.
pub(super) const LEFT: f64 = 76.0;
pub(super) const BELOW: f64 = 56.0;

/// Units to pixels.
pub(super) fn pixels(units: f64) -> i32 {
    (units * f64::from(PIXELS)).round() as i32
}

pub(super) fn point(x: f64, y: f64) -> (i32, i32) {
    (pixels(x), pixels(y))
}

fn style(size: f64, h: HPos, v: VPos) -> TextStyle<'static> {
    let style: TextStyle<'static> = TextStyle::from((FONT, size * f64::from(PIXELS)));
    style.color(&INK.light).pos(Pos::new(h, v))
}

/// Text with its left end at (x, y), units, centred in height.
pub(super) fn text<DB: DrawingBackend<ErrorType: 'static>>(
    canvas: &Canvas<DB>,
    text: &str,
    x: f64,
    y: f64,
) -> Result<(), Failure> {
    Ok(canvas.draw_text(text, &style(TEXT, HPos::Left, VPos::Center), point(x, y))?)
}

/// About the width of a text, units.
pub(super) fn text_width(text: &str) -> f64 {
    0.5 * TEXT * text.chars().count() as f64
}

/// The title, wrapped at blanks.
fn title_lines(text: &str) -> Vec<String> {
    let room = ((WIDTH - 24.0) / (0.45 * TITLE)) as usize;
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

/// Where what stands below the title begins, units.
pub(super) fn below_title(text: &str) -> f64 {
    22.0 + ROW * title_lines(text).len() as f64
}

pub(super) fn title<DB: DrawingBackend<ErrorType: 'static>>(
    canvas: &Canvas<DB>,
    text: &str,
) -> Result<(), Failure> {
    for (row, line) in title_lines(text).iter().enumerate() {
        let at = point(12.0, 18.0 + ROW * row as f64);
        canvas.draw_text(line, &style(TITLE, HPos::Left, VPos::Center), at)?;
    }
    Ok(())
}

impl Frame<'_> {
    /// The pixel of a value; `None` outside the frame.
    pub fn pixel(&self, x: f64, y: f64) -> Option<(i32, i32)> {
        let (x, y) = (self.x.place(x), self.y.place(y));
        let inside = |place: f64, span: &Range<f64>| place >= span.start && place <= span.end;
        (inside(x, &self.x_span) && inside(y, &self.y_span))
            .then(|| point(self.across(x), self.down(y)))
    }

    /// The pixel of the nearest value within the frame; `None` for a value without a place.
    pub fn nearest_pixel(&self, x: f64, y: f64) -> Option<(i32, i32)> {
        let (x, y) = (self.x.place(x), self.y.place(y));
        let into = |place: f64, span: &Range<f64>| place.clamp(span.start, span.end);
        let known = !x.is_nan() && !y.is_nan();
        known.then(|| {
            point(
                self.across(into(x, &self.x_span)),
                self.down(into(y, &self.y_span)),
            )
        })
    }

    fn across(&self, place: f64) -> f64 {
        self.left
            + (place - self.x_span.start) / (self.x_span.end - self.x_span.start)
                * (self.right - self.left)
    }

    fn down(&self, place: f64) -> f64 {
        self.bottom
            - (place - self.y_span.start) / (self.y_span.end - self.y_span.start)
                * (self.bottom - self.top)
    }

    /// Grid, ticks, labels and border.
    pub fn draw<DB: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &Canvas<DB>,
    ) -> Result<(), Failure> {
        let line = |from, to, color: &RGBColor| {
            PathElement::new(vec![from, to], color.stroke_width(PIXELS))
        };
        for tick in self.x.ticks(&self.x_span) {
            let x = self.across(tick);
            canvas.draw(&line(
                point(x, self.top),
                point(x, self.bottom + 4.0),
                &GRID.light,
            ))?;
            let style = style(TEXT, HPos::Center, VPos::Top);
            canvas.draw_text(
                &self.x.tick_label(tick),
                &style,
                point(x, self.bottom + 7.0),
            )?;
        }
        for tick in self.y.ticks(&self.y_span) {
            let y = self.down(tick);
            canvas.draw(&line(
                point(self.left - 4.0, y),
                point(self.right, y),
                &GRID.light,
            ))?;
            let style = style(TEXT, HPos::Right, VPos::Center);
            canvas.draw_text(&self.y.tick_label(tick), &style, point(self.left - 7.0, y))?;
        }
        let below = style(TEXT, HPos::Center, VPos::Bottom);
        let middle = (self.left + self.right) / 2.0;
        canvas.draw_text(
            &self.x.label,
            &below,
            point(middle, self.bottom + BELOW - 6.0),
        )?;
        let beside = style(TEXT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        canvas.draw_text(
            &self.y.label,
            &beside,
            point(6.0, (self.top + self.bottom) / 2.0),
        )?;
        let border = [point(self.left, self.top), point(self.right, self.bottom)];
        Ok(canvas.draw(&Rectangle::new(border, INK.light.stroke_width(PIXELS)))?)
    }
}
