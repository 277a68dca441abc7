//! Heat maps: a value for each cell of a grid, by colour, with the colours' scale beside it.

use super::frame::{self, Frame, HEIGHT, WIDTH, polyline};
use super::{Axis, Draw};

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

/// Steps of the colours' scale, and the room for it beside the map, units.
const STEPS: usize = 60;
const SCALE: f64 = 100.0;

/// A rectangle in the colour of a share: dark blue over green to light yellow, even in lightness, so
/// that it survives a grey print.
fn shaded([x, y]: [f64; 2], [width, height]: [f64; 2], share: f64) -> String {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 201.0, 98.0],
        [253.0, 231.0, 37.0],
    ];
    let place = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let below = (place as usize).min(STOPS.len() - 2);
    let [red, green, blue] = [0, 1, 2].map(|k| {
        let (from, to) = (STOPS[below][k], STOPS[below + 1][k]);
        (from + (to - from) * (place - below as f64)) as u8
    });
    format!(
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
         fill=\"#{red:02x}{green:02x}{blue:02x}\"/>\n"
    )
}

impl Draw for HeatMap {
    fn svg(&self) -> String {
        let span = |axis: &Axis, edges: &[f64]| match edges {
            [first, .., last] => axis.place(*first)..axis.place(*last),
            _ => 0.0..1.0,
        };
        let frame = Frame {
            x: &self.x,
            y: &self.y,
            x_span: span(&self.x, &self.x_edges),
            y_span: span(&self.y, &self.y_edges),
            right: WIDTH - SCALE,
            top: frame::below_title(&self.title),
        };
        let colors = self.color.span(self.values.iter().copied());
        let share = |place: f64| (place - colors.start) / (colors.end - colors.start);
        let mut drawn = String::new();
        let columns = self.x_edges.len().saturating_sub(1).max(1);
        for (row, values) in self.values.chunks(columns).enumerate() {
            for (column, &value) in values.iter().enumerate() {
                let corner =
                    |i: usize| frame.nearest_place(self.x_edges[column + i], self.y_edges[row + i]);
                if let [Some([x, bottom]), Some([right, y])] = [corner(0), corner(1)] {
                    let share = share(self.color.place(value));
                    drawn += &shaded([x, y], [right - x, bottom - y], share);
                }
            }
        }
        let (left, step) = (frame.right + 24.0, HEIGHT / STEPS as f64);
        for i in 0..STEPS {
            let top = frame.bottom() - (i + 1) as f64 * step;
            let share = (i as f64 + 0.5) / STEPS as f64;
            // They overlap, so that no rounding shows between them.
            drawn += &shaded([left, top], [20.0, 1.2 * step], share);
        }
        for tick in self.color.ticks(&colors) {
            let y = frame.bottom() - share(tick) * HEIGHT;
            drawn += &polyline("ink line thin", &[[left + 20.0, y], [left + 25.0, y]]);
            drawn += &frame::text("", [left + 29.0, y], &self.color.tick_label(tick));
        }
        drawn += &frame::text("", [left - 8.0, frame.bottom() + 22.0], &self.color.label);
        frame.picture(&self.title, &drawn)
    }
}
