//! Orders of visits.

use super::queue::BUCKETS;
use super::views::{Relation, Views};
use crate::tree::{Node, xyz};
use core::fmt;
use core::str::FromStr;
use punctual_geom::UnknownName;
use punctual_geom::lanes::per_axis;
use punctual_geom::random::Random;

/// Decides which node pair of the front is visited next. All orders give the same finished answer;
/// they differ in what is known when a budget ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Order {
    /// Deepest penetration of the boxes first: the least over the six face axes, relative to the
    /// sizes of the nodes. The default: it costs almost nothing, and finds intersections earliest
    /// in time (`docs/benchmarks.md`).
    #[default]
    Penetration,
    /// Lowest product of the two diminishing factors `alpha` first, as the paper proposes.
    LowAlpha,
    /// Largest relative volume of the boxes' overlap first.
    OverlapVolume,
    /// Depth-first, without a queue: least overhead.
    DepthFirst,
    /// Level by level.
    BreadthFirst,
    /// Random, with this seed.
    Random(u64),
}

const NAMES: [&str; 6] = [
    "penetration",
    "low-alpha",
    "overlap-volume",
    "depth-first",
    "breadth-first",
    "random(SEED)",
];

/// Includes the seed: `random(7)`.
impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [
            penetration,
            low_alpha,
            overlap_volume,
            depth_first,
            breadth_first,
            _,
        ] = NAMES;
        f.pad(match self {
            Self::Penetration => penetration,
            Self::LowAlpha => low_alpha,
            Self::OverlapVolume => overlap_volume,
            Self::DepthFirst => depth_first,
            Self::BreadthFirst => breadth_first,
            Self::Random(seed) => return write!(f, "random({seed})"),
        })
    }
}

impl FromStr for Order {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let plain = [
            Self::Penetration,
            Self::LowAlpha,
            Self::OverlapVolume,
            Self::DepthFirst,
            Self::BreadthFirst,
        ];
        let seed = || {
            name.strip_prefix("random(")?
                .strip_suffix(')')?
                .parse()
                .ok()
        };
        let named = NAMES
            .iter()
            .position(|&known| known == name)
            .and_then(|at| plain.get(at).copied());
        named
            .or_else(|| seed().map(Self::Random))
            .ok_or_else(|| UnknownName::new(name, &NAMES))
    }
}

/// Volume of the overlap of the boxes of two nodes over that of the smaller box, on the axes of A's
/// node; within 0..=1.
pub(super) fn overlap_volume(a: &Node, b: &Node, relation: &Relation) -> f32 {
    let view = Views::between(a, b, relation).of_b;
    let (center, half) = (
        view.point(b.own_center * relation.scale),
        view.half(b.own_half * relation.scale),
    );
    let [distance, a, b] = [(center - a.own_center).abs(), a.own_half, half].map(xyz);
    // Slightly above 0, so that products over the axes distinguish flat boxes.
    let shares: [f32; 3] = per_axis!(k => {
        let (least, slack) = (2.0 * a[k].min(b[k]), 1e-3 * (a[k] + b[k]) + 1e-9);
        ((a[k] + b[k] - distance[k]).clamp(0.0, least) + slack) / (least + slack)
    });
    shares.iter().product()
}

/// The depth of an overlap is at most about a sixth of the sum of the sizes, so the relative depth
/// times this is within 0..=1.
const DEPTHS: f32 = 6.0;

impl Order {
    /// The bucket of a pair, and whether it goes first there (or last). `depth` is the overlap
    /// depth of its boxes over the sum of their sizes, `alpha` the product of the two diminishing
    /// factors.
    pub(super) fn bucket(
        self,
        overlap_volume: impl FnOnce() -> f32,
        depth: f32,
        alpha: impl FnOnce() -> f32,
        random: &mut Random,
    ) -> (usize, bool) {
        let step = |x: f32, steps: usize| ((x * steps as f32) as usize).min(steps - 1);
        match self {
            Self::DepthFirst => (0, true),
            Self::BreadthFirst => (0, false),
            Self::Penetration => (step(1.0 - DEPTHS * depth, BUCKETS), true),
            Self::OverlapVolume => (step(-libm::log2f(overlap_volume()) / 32.0, BUCKETS), true),
            Self::LowAlpha => (step(alpha(), BUCKETS), true),
            Self::Random(_) => ((random.bits() >> 57) as usize, true),
        }
    }
}

const _: () = assert!(BUCKETS == 1 << 7);
