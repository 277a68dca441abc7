//! What a query is asked to do.

use super::order::Order;
use crate::math::Motion;
use crate::math::tolerance::COORDINATE_LIMIT;
use crate::names::named;

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
pub(crate) struct Options {
    pub mode: Mode,
    pub order: Order,
    pub pair_limit: usize,
    pub queue_threshold: Option<f32>,
    pub early: bool,
}

impl Options {
    pub const DEFAULT: Self = Self {
        mode: Mode::Any,
        order: Order::Penetration,
        pair_limit: usize::MAX,
        queue_threshold: None,
        early: false,
    };
}

/// The same of a contact query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ContactOptions {
    pub margin: f64,
    /// Most contacts in the workspace.
    pub limit: usize,
}

/// The same of a distance query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DistanceOptions {
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
pub(super) struct MotionOptions {
    /// `None`: A does not move.
    pub of_a: Option<Motion>,
    pub of_b: Motion,
    /// Tolerance as a length, as asked for; `None`: by default. And in time.
    pub length: Option<f64>,
    pub time: f64,
    /// Of both surfaces together.
    pub margin: f64,
}

/// By how much a surface is thickened, of what was asked for.
pub(super) fn thickness(margin: f64) -> f64 {
    if margin > 0.0 { margin.min(COORDINATE_LIMIT) } else { 0.0 }
}
