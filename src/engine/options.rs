//! The options of a query.

use super::frontier::order::Order;
use core::fmt;
use punctual_geom::Motion;
use punctual_geom::named;
use punctual_geom::tolerance::COORDINATE_LIMIT;

/// Selects whether a query searches for one intersection or for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Mode {
    /// Asks whether there is an intersection: stops at the first.
    #[default]
    Any,
    /// Every intersecting pair of triangles.
    All,
}

named!(Mode { Any => "any", All => "all" });

/// All options of an intersection query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    pub mode: Mode,
    pub order: Order,
    pub pair_limit: usize,
    /// True for the simplest rival: a stack, nothing ranked, traced or remembered.
    pub is_plain: bool,
    /// Triangles no farther apart than this meet: the sum of the radii of the trees.
    pub reach: f64,
}

impl Options {
    pub const DEFAULT: Self = Self {
        mode: Mode::Any,
        order: Order::Penetration,
        pair_limit: usize::MAX,
        is_plain: false,
        reach: 0.0,
    };
}

/// All options of a contact query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactOptions {
    pub margin: f64,
    /// Maximum number of contacts in the workspace.
    pub limit: usize,
}

/// All options of a distance query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceOptions {
    /// Tolerances as set by the caller; `None` selects the default.
    pub absolute: Option<f64>,
    pub relative: Option<f64>,
    pub margins: [f64; 2],
    /// Infinite unless the query only compares the distance with a limit.
    pub limit: f64,
    /// True if a finished run may leave it open whether surfaces within the tolerance intersect.
    pub leaves_contact_open: bool,
    /// For comparison: keeps all node pairs on one stack.
    pub depth_first: bool,
}

/// All options of a motion query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionOptions {
    /// `None` if A does not move.
    pub of_a: Option<Motion>,
    pub of_b: Motion,
    /// Tolerance as a length, as set by the caller; `None` selects the default. `time` is the
    /// tolerance in time.
    pub length: Option<f64>,
    pub time: f64,
    /// Sum of the margins and radii of both surfaces.
    pub margin: f64,
}

/// An argument of a query is negative, too large or NaN.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct OptionError {
    /// The method that received it, with the index if it takes several numbers.
    pub argument: &'static str,
}

impl OptionError {
    /// Keeps the first argument that is not in `0.0..=most`.
    #[inline]
    pub(crate) fn note(fault: &mut Option<Self>, argument: &'static str, value: f64, most: f64) {
        if !(0.0..=most).contains(&value) {
            fault.get_or_insert(Self { argument });
        }
    }

    /// [`OptionError::note`] for the margins of both surfaces.
    #[inline]
    pub(crate) fn note_margins(fault: &mut Option<Self>, margins: [f64; 2]) {
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

/// The margin in use for a given one: clamped to the range of coordinates; 0 if negative or NaN.
pub(crate) fn thickness(margin: f64) -> f64 {
    if margin > 0.0 {
        margin.min(COORDINATE_LIMIT)
    } else {
        0.0
    }
}
