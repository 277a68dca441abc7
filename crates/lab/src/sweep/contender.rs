//! Who is compared: the orders of the engine, what is derived from them, and which of them the plots show.

use punctual::intersection::{Intersection, Order};
use punctual::{Pose, Query, Tree};

/// An order of the engine, or its simplest rival.
#[derive(Clone, Copy)]
pub struct Contender {
    pub name: &'static str,
    /// None: depth-first and nothing else, without traced curves or small batches.
    pub order: Option<Order>,
}

/// The default first, plain depth-first second. The others run in the default's plan, and differ from
/// it by the order alone.
pub const CONTENDERS: [Contender; 4] = [
    contender("penetration", Some(Order::Penetration)),
    contender(DEPTH_FIRST, None),
    contender(LOW_ALPHA, Some(Order::LowAlpha)),
    contender("stack", Some(Order::DepthFirst)),
];

const fn contender(name: &'static str, order: Option<Order>) -> Contender {
    Contender { name, order }
}

pub const DEFAULT: &str = CONTENDERS[0].name;
pub const DEPTH_FIRST: &str = "depth-first";
pub const LOW_ALPHA: &str = "low-alpha";

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
        let query = Query::intersection(a, b, pose);
        match self.order {
            Some(order) => query.order(order),
            None => query.plain(),
        }
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
    curve(DEFAULT, "this library", false),
    curve(DEPTH_FIRST, "depth-first", false),
    curve(CUT_OFF, "plain query, cut off", true),
    curve(ORACLE, "best order (knows the truth)", true),
];

const fn curve(order: &'static str, label: &'static str, dashed: bool) -> Curve {
    Curve {
        order,
        label,
        dashed,
    }
}

/// The name of an order in words.
pub fn label(order: &'static str) -> &'static str {
    match order {
        WARM => "this library, with memory",
        LOW_ALPHA => "low alpha first (the paper's), else as this library",
        "stack" => "the last found first, else as this library",
        _ => CURVES
            .iter()
            .find(|curve| curve.order == order)
            .map_or(order, |curve| curve.label),
    }
}
