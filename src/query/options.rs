//! What a query is asked to do.

use super::order::Order;
use crate::math::Motion;
use crate::math::tolerance::COORDINATE_LIMIT;
use crate::names::named;
use core::fmt;

/// What a query looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Mode {
    /// Whether there is an intersection: stops at the first.
    #[default]
    Any,
    /// Every intersecting pair of triangles.
    All,
}

named!(Mode { Any => "any", All => "all" });

/// Everything about a query that is a choice of the caller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    pub mode: Mode,
    pub order: Order,
    pub pair_limit: usize,
    pub queue_threshold: Option<f32>,
}

impl Options {
    pub const DEFAULT: Self = Self {
        mode: Mode::Any,
        order: Order::Penetration,
        pair_limit: usize::MAX,
        queue_threshold: None,
    };
}

/// The same of a contact query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactOptions {
    pub margin: f64,
    /// Most contacts in the workspace.
    pub limit: usize,
}

/// The same of a distance query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceOptions {
    /// As asked for; `None`: by default.
    pub absolute: Option<f64>,
    pub relative: Option<f64>,
    pub margins: [f64; 2],
    /// Infinite if the distance itself is asked for.
    pub limit: f64,
    /// Whether a finished run may leave open if surfaces meet that are within the tolerance.
    pub leaves_contact_open: bool,
    /// For comparison: one stack for all node pairs.
    pub depth_first: bool,
}

/// The same of a motion query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionOptions {
    /// `None`: A does not move.
    pub of_a: Option<Motion>,
    pub of_b: Motion,
    /// Tolerance as a length, as asked for; `None`: by default. And in time.
    pub length: Option<f64>,
    pub time: f64,
    /// Of both surfaces together.
    pub margin: f64,
}

/// An argument of a query is negative, larger than what it may be, or no number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct OptionError {
    /// The method that it was given to, with the index of one of several numbers.
    pub argument: &'static str,
}

impl OptionError {
    /// Keeps the first argument that is not in `0.0..=most`.
    #[inline]
    pub(super) fn note(fault: &mut Option<Self>, argument: &'static str, value: f64, most: f64) {
        if !(0.0..=most).contains(&value) {
            fault.get_or_insert(Self { argument });
        }
    }

    /// The same for margins of both surfaces.
    #[inline]
    pub(super) fn note_margins(fault: &mut Option<Self>, margins: [f64; 2]) {
        for (margin, argument) in margins.into_iter().zip(["margins[0]", "margins[1]"]) {
            Self::note(fault, argument, margin, COORDINATE_LIMIT);
        }
    }
}

impl fmt::Display for OptionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is negative, too large or no number", self.argument)
    }
}

impl core::error::Error for OptionError {}

/// By how much a surface is thickened, of what was asked for.
pub(super) fn thickness(margin: f64) -> f64 {
    if margin > 0.0 {
        margin.min(COORDINATE_LIMIT)
    } else {
        0.0
    }
}
