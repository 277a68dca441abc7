//! Who is compared: the orders of the engine, and two baselines that are derived.

use punctual::{Order, Pose, Query, Tree};

/// An order of the engine.
#[derive(Clone, Copy)]
pub struct Contender {
    pub name: &'static str,
    pub order: Order,
}

/// The default first, plain depth-first second.
pub const CONTENDERS: [Contender; 6] = [
    Contender { name: "penetration", order: Order::Penetration },
    Contender { name: DEPTH_FIRST, order: Order::DepthFirst },
    Contender { name: "low-alpha", order: Order::LowAlpha },
    Contender { name: "overlap-volume", order: Order::OverlapVolume },
    Contender { name: "breadth-first", order: Order::BreadthFirst },
    Contender { name: "random", order: Order::Random(1) },
];

pub const DEFAULT: &str = CONTENDERS[0].name;
pub const DEPTH_FIRST: &str = "depth-first";

/// The default with what it remembers of the pose before: a warm start where poses are frames of a motion.
pub const WARM: &str = "warm";

/// A plain exact query of which nothing is known until it returns: depth-first, cut off by the budget.
pub const CUT_OFF: &str = "cut-off";

/// A traversal that knows the truth.
pub const ORACLE: &str = "oracle";

impl Contender {
    pub fn query<'t>(&self, a: &'t Tree, b: &'t Tree, pose: Pose) -> Query<'t> {
        Query::new(a, b, pose).order(self.order)
    }
}
