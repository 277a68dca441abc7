//! Axes: linear or logarithmic, with ticks at round numbers.

use std::ops::Range;

/// How values become places.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Scale {
    Linear,
    Log,
}

/// An axis; without `range` it spans what is drawn.
#[derive(Clone)]
pub struct Axis {
    pub(super) label: String,
    pub(super) scale: Scale,
    range: Option<Range<f64>>,
}

impl Axis {
    /// Values at places in proportion to them.
    pub fn linear(label: &str) -> Self {
        Self::new(label, Scale::Linear)
    }

    /// Values at places in proportion to their logarithms; those that are not positive are not drawn.
    pub fn log(label: &str) -> Self {
        Self::new(label, Scale::Log)
    }

    fn new(label: &str, scale: Scale) -> Self {
        Self {
            label: label.to_owned(),
            scale,
            range: None,
        }
    }

    /// From where to where it goes.
    #[must_use]
    pub fn range(self, range: Range<f64>) -> Self {
        Self {
            range: Some(range),
            ..self
        }
    }

    /// The place of a value on the axis, not finite where it has none.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Log => value.log10(),
        }
    }

    fn value(&self, place: f64) -> f64 {
        match self.scale {
            Scale::Linear => place,
            Scale::Log => 10f64.powf(place),
        }
    }

    /// The places from end to end: the range asked for, or what the values need with a little room.
    pub(super) fn span(&self, values: impl Iterator<Item = f64>) -> Range<f64> {
        if let Some(range) = &self.range {
            return self.place(range.start)..self.place(range.end);
        }
        let places = values
            .map(|value| self.place(value))
            .filter(|place| place.is_finite());
        let (low, high) = places.fold((f64::MAX, f64::MIN), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let room = if high > low { 0.04 * (high - low) } else { 0.5 };
        if low > high {
            0.0..1.0
        } else {
            low - room..high + room
        }
    }

    /// The places of about six round values, or of powers of ten.
    pub(super) fn ticks(&self, span: &Range<f64>) -> Vec<f64> {
        let length = span.end - span.start;
        if self.scale == Scale::Log && length < 2.5 {
            let decades = span.start.floor() as i32..=span.end.ceil() as i32;
            let steps: &[f64] = if length < 1.3 {
                &[1.0, 2.0, 3.0, 5.0, 7.0]
            } else {
                &[1.0, 3.0]
            };
            let values =
                decades.flat_map(|d| steps.iter().map(move |s| self.place(s * 10f64.powi(d))));
            return values.filter(|place| span.contains(place)).collect();
        }
        let rough = length / 6.0;
        let decade = 10f64.powf(rough.log10().floor());
        let least = if self.scale == Scale::Log { 1.0 } else { 0.0 };
        let nice = [1.0, 2.0, 5.0, 10.0].map(|s| s * decade);
        let step = nice
            .into_iter()
            .find(|step| *step >= rough * 0.999)
            .unwrap_or(rough)
            .max(least);
        let first = (span.start / step).ceil() as i64;
        let last = (span.end / step + 1e-9).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }

    /// The text at a tick.
    pub(super) fn tick_label(&self, place: f64) -> String {
        let value = self.value(place);
        let (scaled, unit) = match value.abs() {
            v if v >= 0.9995e9 => (value / 1e9, "G"),
            v if v >= 0.9995e6 => (value / 1e6, "M"),
            v if v >= 0.9995e4 => (value / 1e3, "k"),
            _ => (value, ""),
        };
        let text = super::short(scaled);
        let text = if text == "-0" { "0" } else { &text };
        format!("{text}{unit}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, values: Range<f64>) -> Vec<String> {
        let span = axis.span([values.start, values.end].into_iter());
        axis.ticks(&span)
            .into_iter()
            .map(|tick| axis.tick_label(tick))
            .collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(
            labels(&Axis::linear("").range(0.0..1.0), 0.0..0.0),
            ["0", "0.2", "0.4", "0.6", "0.8", "1"]
        );
        assert_eq!(labels(&Axis::linear(""), -13.0..1.5), ["-10", "-5", "0"]);
        assert_eq!(labels(&Axis::log(""), 1.0..2e7), ["1", "100", "10k", "1M"]);
        assert_eq!(
            labels(&Axis::log("").range(100.0..1e4), 1.0..1.0),
            ["100", "300", "1000", "3000"]
        );
    }

    #[test]
    fn nothing_to_draw_still_has_an_axis() {
        for axis in [Axis::linear(""), Axis::log("")] {
            for values in [vec![], vec![f64::NAN], vec![0.0], vec![5.0]] {
                let span = axis.span(values.iter().copied());
                assert!(span.start < span.end && span.start.is_finite() && span.end.is_finite());
                assert!(!axis.ticks(&span).is_empty());
            }
        }
    }
}
