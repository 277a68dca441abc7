//! Heat maps: a value for each cell of a grid, by colour, with the colours' scale beside it.

use std::ops::Range;

use plotters::prelude::*;

use super::frame::{self, Canvas, Frame, WIDTH, point};
use super::palette::INK;
use super::{Axis, Draw, Failure};

/// Cells between two axes. `values` goes row by row, from the least `y` up, `x_edges.len() - 1` in a row.
pub struct HeatMap {
    /// What stands above it.
    pub title: String,
    /// The axis below.
    pub x: Axis,
    /// The axis to the left.
    pub y: Axis,
    /// Borders between the columns of cells, ascending, both ends included.
    pub x_edges: Vec<f64>,
    /// Borders between the rows of cells, likewise.
    pub y_edges: Vec<f64>,
    /// A value for each cell.
    pub values: Vec<f64>,
    /// What colours stand for; without a range from the least value to the largest.
    pub color: Axis,
}

const STEPS: usize = 60;

/// Height of the map itself, and the room beside it for the colours' scale, units.
const HEIGHT: f64 = 260.0;
const SCALE: f64 = 100.0;

/// Dark blue over green to light yellow: even in lightness, so that it survives a grey print.
fn shade(fraction: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 201.0, 98.0],
        [253.0, 231.0, 37.0],
    ];
    let place = fraction.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let below = (place as usize).min(STOPS.len() - 2);
    let mix = |k: usize| {
        STOPS[below][k] + (STOPS[below + 1][k] - STOPS[below][k]) * (place - below as f64)
    };
    RGBColor(mix(0) as u8, mix(1) as u8, mix(2) as u8)
}

impl HeatMap {
    fn edges_span(axis: &Axis, edges: &[f64]) -> Range<f64> {
        let place = |edge: Option<&f64>| edge.map_or(0.0, |edge| axis.place(*edge));
        place(edges.first())..place(edges.last())
    }
}

impl Draw for HeatMap {
    fn size(&self) -> (u32, u32) {
        (
            WIDTH as u32,
            (frame::below_title(&self.title) + HEIGHT + frame::BELOW) as u32,
        )
    }

    fn draw<DB: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &Canvas<DB>,
    ) -> Result<(), Failure> {
        let top = frame::below_title(&self.title);
        let (bottom, right) = (top + HEIGHT, WIDTH - SCALE);
        let colors = self.color.span(self.values.iter().copied());
        let share =
            |value: f64| (self.color.place(value) - colors.start) / (colors.end - colors.start);
        let frame = Frame {
            x: &self.x,
            y: &self.y,
            x_span: Self::edges_span(&self.x, &self.x_edges),
            y_span: Self::edges_span(&self.y, &self.y_edges),
            left: frame::LEFT,
            right,
            top,
            bottom,
        };
        frame::title(canvas, &self.title)?;
        frame.draw(canvas)?;
        let columns = self.x_edges.len().saturating_sub(1).max(1);
        for (row, values) in self.values.chunks(columns).enumerate() {
            for (column, &value) in values.iter().enumerate() {
                let corner =
                    |i: usize| frame.nearest_pixel(self.x_edges[column + i], self.y_edges[row + i]);
                if let [Some(from), Some(to)] = [corner(0), corner(1)] {
                    canvas.draw(&Rectangle::new([from, to], shade(share(value)).filled()))?;
                }
            }
        }
        self.draw_scale(canvas, &colors, right + 24.0, top, bottom)
    }
}

impl HeatMap {
    fn draw_scale<DB: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &Canvas<DB>,
        colors: &Range<f64>,
        left: f64,
        top: f64,
        bottom: f64,
    ) -> Result<(), Failure> {
        let down = |fraction: f64| bottom - fraction * (bottom - top);
        for step in 0..STEPS {
            let [low, high] = [step, step + 1].map(|i| down(i as f64 / STEPS as f64));
            let color = shade((step as f64 + 0.5) / STEPS as f64).filled();
            canvas.draw(&Rectangle::new(
                [point(left, high), point(left + 20.0, low)],
                color,
            ))?;
        }
        for tick in self.color.ticks(colors) {
            let y = down((tick - colors.start) / (colors.end - colors.start));
            canvas.draw(&PathElement::new(
                [point(left + 20.0, y), point(left + 25.0, y)],
                INK.light.stroke_width(2),
            ))?;
            frame::text(canvas, &self.color.tick_label(tick), left + 29.0, y)?;
        }
        frame::text(canvas, &self.color.label, left - 8.0, bottom + 22.0)
    }
}
