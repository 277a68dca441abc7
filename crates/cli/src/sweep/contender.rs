//! Who is compared: the orders of the engine, what is derived from them, and which of them the plots show.

use punctual::intersection::{Intersection, Order};
use punctual::{Pose, Query, Tree};

/// An order of the engine.
#[derive(Clone, Copy)]
pub struct Contender {
    pub name: &'static str,
    pub order: Order,
}

/// The default first, plain depth-first second.
pub const CONTENDERS: [Contender; 3] = [
    Contender {
        name: "penetration",
        order: Order::Penetration,
    },
    Contender {
        name: DEPTH_FIRST,
        order: Order::DepthFirst,
    },
    Contender {
        name: "low-alpha",
        order: Order::LowAlpha,
    },
];

pub const DEFAULT: &str = CONTENDERS[0].name;
pub const DEPTH_FIRST: &str = "depth-first";

/// The default with what it remembers of the pose before: a warm start where poses are frames of a motion.
pub const WARM: &str = "warm";

/// A plain exact query of which nothing is known until it returns: depth-first, cut off by the budget.
pub const CUT_OFF: &str = "cut-off";

/// Whose room for missed contacts is measured.
pub const CERTIFIED: [&str; 2] = [DEFAULT, DEPTH_FIRST];

/// The best order, which knows the truth.
pub const ORACLE: &str = "oracle";

impl Contender {
    pub fn query<'t>(&self, a: &'t Tree, b: &'t Tree, pose: Pose) -> Query<'t, Intersection> {
        Query::intersection(a, b, pose).order(self.order)
    }
}

/// A line of the plots.
#[derive(Clone, Copy)]
pub struct Curve {
    /// Its name in tables and figures.
    pub order: &'static str,
    /// What readers are told that it is.
    pub label: &'static str,
    pub dashed: bool,
}

/// What every plot compares; one line more is one more of these.
pub const CURVES: [Curve; 4] = [
    Curve {
        order: DEFAULT,
        label: "this library",
        dashed: false,
    },
    Curve {
        order: DEPTH_FIRST,
        label: "depth-first",
        dashed: false,
    },
    Curve {
        order: CUT_OFF,
        label: "plain query, cut off",
        dashed: true,
    },
    Curve {
        order: ORACLE,
        label: "best order (knows the truth)",
        dashed: true,
    },
];

/// The name of an order in words.
pub fn label(order: &'static str) -> &'static str {
    match order {
        WARM => "this library, with memory",
        "low-alpha" => "low alpha first (the paper's)",
        _ => CURVES
            .iter()
            .find(|curve| curve.order == order)
            .map_or(order, |curve| curve.label),
    }
}
