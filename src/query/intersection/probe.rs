//! A probe: the summary of a frontier after its costliest pairs have been opened on trial.
//!
//! The cost of a pair is hard to predict from the pair, and easy from one level below. So the
//! costliest pairs are replaced by the pairs of their children that may meet, a few times, and the
//! rest is summed up. The probe does not change the query.

use crate::engine::boxes::overlap::Overlap;
use crate::engine::boxes::relative_pose::{RelativePose, Views};
use crate::engine::expand::{LeafRows, Scratch, Sink, expand};
use crate::engine::frontier::Pair;
use crate::engine::outcome::Stats;
use crate::model::frontier::FrontierSummary;
use crate::model::visits::pair_cost;
use crate::tree::{Node, Tree, WIDTH, node, xyz};
use arrayvec::ArrayVec;
use core::mem;
use punctual_geom::lanes::{Instructions, Kernel, Lanes};
use wide::f32x4;

/// Maximum number of pairs that can be opened; further pairs are only counted.
const ROOM: usize = 64;

/// Effort of opening a pair, besides one unit for each of its children; a unit is about 30 ns.
const PER_OPENING: usize = 2;

/// A frontier whose costliest pairs are opened one after the other.
pub(crate) struct Probe<'q> {
    trees: [&'q Tree; 2],
    relative: &'q RelativePose,
    /// Pairs that can be opened, and the cost of each.
    pairs: ArrayVec<Open, ROOM>,
    costs: ArrayVec<f32, ROOM>,
    /// Effort left.
    effort: usize,
    /// Returns true while there is time for another opening.
    goes_on: &'q dyn Fn() -> bool,
    summary: FrontierSummary,
}

/// An open pair, and the penetration and crossing of its boxes.
#[derive(Clone, Copy)]
struct Open {
    pair: Pair,
    penetration: f32,
    crossing: f32,
}

impl<'q> Probe<'q> {
    pub fn new(
        trees: [&'q Tree; 2],
        relative: &'q RelativePose,
        summary: FrontierSummary,
        goes_on: &'q dyn Fn() -> bool,
    ) -> Self {
        Self {
            trees,
            relative,
            pairs: ArrayVec::new(),
            costs: ArrayVec::new(),
            effort: 0,
            goes_on,
            summary,
        }
    }

    /// Adds a pair that may meet.
    #[inline(always)]
    pub fn add(&mut self, pair: Pair) {
        self.effort = self.effort.saturating_sub(1);
        let (leaf_a, leaf_b);
        let a = node!(self.trees[0], pair.nodes[0], leaf_a);
        let b = node!(self.trees[1], pair.nodes[1], leaf_b);
        let (penetration, crossing) = overlap(a, b, self.relative);
        let cost = pair_cost([a.self_cost, b.self_cost], penetration);
        let open = Open {
            pair,
            penetration,
            crossing,
        };
        if self.pairs.is_full() {
            self.sum_up(cost, open);
        } else {
            self.pairs.push(open);
            self.costs.push(cost);
        }
    }

    #[inline(always)]
    fn sum_up(&mut self, cost: f32, open: Open) {
        let (cost, penetration) = (f64::from(cost), f64::from(open.penetration));
        let summary = &mut self.summary;
        summary.node_pairs += 1.0;
        summary.cost += cost;
        summary.largest = summary.largest.max(cost);
        summary.deepest = summary.deepest.max(penetration);
        summary.depth += cost * penetration;
        summary.crossing = summary.crossing.max(open.crossing.into());
    }

    /// Opens the costliest pairs, as long as effort and time last, and sums up what is left.
    pub fn finish(mut self, instructions: Instructions, effort: usize) -> FrontierSummary {
        self.effort = effort;
        instructions.run(&mut self);
        for (cost, open) in mem::take(&mut self.costs)
            .into_iter()
            .zip(mem::take(&mut self.pairs))
        {
            self.sum_up(cost, open);
        }
        self.summary
    }
}

impl Kernel for &mut Probe<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let mut children = Children::default();
        while !self.pairs.is_empty() && self.effort > 0 && (self.goes_on)() {
            self.effort = self.effort.saturating_sub(PER_OPENING);
            let mut costliest = 0;
            for i in 1..self.costs.len() {
                if self.costs[i] > self.costs[costliest] {
                    costliest = i;
                }
            }
            self.costs.swap_remove(costliest);
            let pair = self.pairs.swap_remove(costliest).pair;
            children.open(lanes, pair, self.trees, self.relative);
            let (hits, _) = children.triangles;
            self.summary.triangle_pairs += f64::from(hits.count_ones());
            children.pairs.drain(..).for_each(|pair| self.add(pair));
        }
        self.summary.probed += children.stats.bv_tests as f64;
    }
}

/// The children that replace pairs in a run that finds all intersections.
#[derive(Default)]
pub(crate) struct Children {
    /// The work of opening all pairs.
    pub stats: Stats,
    pub pairs: ArrayVec<Pair, { WIDTH * WIDTH }>,
    /// The triangle pairs of the last: bit `8 i + j` stands for `first + [i, j]`, in tree order.
    pub triangles: (u64, [u32; 2]),
}

impl Children {
    /// Opens a pair. There must be no pairs of another left.
    #[inline(always)]
    pub fn open<L: Lanes>(
        &mut self,
        lanes: L,
        pair: Pair,
        trees: [&Tree; 2],
        relative: &RelativePose,
    ) {
        self.triangles.0 = 0;
        let (overlap, scratch) = (&mut Overlap::default(), &mut Scratch::default());
        expand::<true, _, _>(lanes, pair, trees, relative, overlap, scratch, self);
    }
}

impl Sink for Children {
    #[inline(always)]
    fn stats(&mut self) -> &mut Stats {
        &mut self.stats
    }

    #[inline(always)]
    fn place(&mut self, pair: Pair, _depth: impl FnOnce() -> f32) {
        self.pairs.push(pair);
    }

    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &mut self,
        _: L,
        hits: u64,
        _depth: impl Fn(usize) -> f32,
        first: [u32; 2],
        _: impl FnOnce() -> LeafRows<'t>,
    ) {
        self.triangles = (hits, first);
    }
}

/// Relative penetration and crossing of two boxes. Penetration is the least `(s - |d|) / s` over
/// the six face axes. Crossing is the largest `(e - f - |d|) / s`, where `f` is the half extent of
/// the box whose own axis it is, and `e` that of the other. `s = e + f`, and `d` is the offset of
/// the centres.
#[inline(always)]
fn overlap(a: &Node, b: &Node, relative: &RelativePose) -> (f32, f32) {
    let views = Views::between(a, b, relative);
    let scale = f32x4::splat(relative.scale);
    let (center, half) = (b.own_center * scale, b.own_half * scale);
    let in_a = shares(
        views.of_b.point(center),
        views.of_b.half(half),
        a.own_center,
        a.own_half,
    );
    let in_b = shares(
        views.of_a.point(a.own_center),
        views.of_a.half(a.own_half),
        center,
        half,
    );
    let [x, y, z] = xyz(in_a.0.fast_min(in_b.0));
    let [u, v, w] = xyz(in_a.1.fast_max(in_b.1));
    (x.min(y).min(z).max(0.0), u.max(v).max(w))
}

/// Penetration and crossing on three axes. The margin in `reach` keeps the sum above 0.
#[inline(always)]
fn shares(seen: f32x4, reach: f32x4, center: f32x4, half: f32x4) -> (f32x4, f32x4) {
    let (sum, distance) = (reach + half, (seen - center).abs());
    ((sum - distance) / sum, (reach - distance - half) / sum)
}
