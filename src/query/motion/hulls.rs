//! Whether boxes meet in a short span of time: by where they are when it begins and when it ends, eight at a time.
//!
//! Seen from a node that an axis goes along with, each corner of a box of the other node goes straight from where it is at the
//! begin to where it is at the end, but for what its way bends. So the box stays in the hull of both, and two boxes that meet
//! overlap when one is replaced by its hull; not before the gap between own boxes at the begin can have closed. This is tighter
//! than [`Windows`](super::windows::Windows) where B turns, but sees nothing of what comes and goes within the span. The proof is
//! in `docs/numerics.md`, "Motion".

use super::course::{Course, Piece};
use super::windows::{BEGIN, SLOP, sum};
use crate::math::lanes::{Column, F8, Lanes, per_axis};
use crate::math::{bits, larger, smaller};
use crate::query::boxes::{BoxTest, Boxes, Facing, Keys, Plane, Planes, Slabs, Triangles, ends};
use crate::query::edge_axes;
use crate::query::views::{Place, Relation, View, Views};
use crate::tree::{Node, Tree, WIDTH, xyz};
use wide::f32x4;

/// A span of time from the begin of a piece, in which B goes around one axis.
pub(super) struct Span {
    /// Where B lies at its begin and its end.
    places: Place<[f32; 8]>,
    end: Place,
    scale: f32,
    skew: f32,
    /// How long it is, in lengths of the piece.
    length: f32,
    /// By how many radians B turns, at most.
    turn: f32,
    /// What places may be off whatever way they have gone: by the margin, by rounding, and by what the axis goes across itself.
    bulge: f32,
}

/// Turns beyond this (radians) bend ways by more than is allowed for.
const LARGEST_TURN: f64 = 0.25;

impl Span {
    /// From the begin of a piece to `until`; `None` if both bodies turn, or where `f32` does not reach.
    pub fn new(
        course: &Course,
        [a, b]: [&Tree; 2],
        piece: &Piece,
        relation: &Relation,
        until: f64,
        margin: f64,
    ) -> Option<Self> {
        course.of_axis()?;
        let time = until - piece.begin;
        let turn = course.spin * time;
        let end = relation.place_at(a, b, &course.pose(until));
        let slip = course.slip() * time * turn * (0.375 + 0.125 * turn);
        let bulge = (slip + 2.0 * course.rounding + margin) / relation.unit;
        (turn < LARGEST_TURN && bulge < 1e6).then(|| Self {
            places: relation.place.and(&end),
            end,
            scale: relation.scale,
            skew: relation.skew,
            length: (time / piece.length()) as f32,
            turn: turn as f32 * 1.001,
            bulge: bulge as f32 * 1.001 + 1e-20,
        })
    }
}

/// Whether boxes meet in a span and before `cut`. Keys are lower bounds of the times when they do.
pub(super) struct Hulls<'s> {
    /// From this time on pairs are of no interest.
    cut: f32,
    /// The key of the pair at hand; its children's are no less.
    pub least: f32,
    span: &'s Span,
    /// Of the nodes at hand, at the end of the span.
    end: Views,
    /// By how much ways bend between them, and what places are off.
    bulge: f32,
    /// The same and the margins of the overlap test, in the orientations of A's node and of B's.
    margins: [f32; 2],
}

/// Nothing meets before the begin.
const START: f32 = BEGIN - SLOP;

impl<'s> Hulls<'s> {
    #[inline(always)]
    pub fn new(cut: f32, least: f32, span: &'s Span) -> Self {
        Self { cut, least, span, end: Views::NONE, bulge: 0.0, margins: [0.0; 2] }
    }

    /// The views of the opened node and of the other, at the end.
    #[inline(always)]
    fn views(&self, is_a: bool) -> [&View; 2] {
        let Views { of_a, of_b } = &self.end;
        if is_a { [of_a, of_b] } else { [of_b, of_a] }
    }

    /// The margins in the orientations of the opened node and of the other.
    #[inline(always)]
    fn margins(&self, is_a: bool) -> [f32; 2] {
        let [in_a, in_b] = self.margins;
        if is_a { [in_a, in_b] } else { [in_b, in_a] }
    }
}

/// The hulls of the ways of boxes, from a view at the begin to one at the end.
#[inline(always)]
fn hulls<L: Lanes>(lanes: L, boxes: &Boxes<L>, views: [&View; 2], margin: f32) -> Slabs<L> {
    let [begin, end] = views;
    let (begin, end) = (boxes.seen_within(lanes, begin, margin).slabs(), boxes.seen_within(lanes, end, margin).slabs());
    Slabs { low: per_axis!(k => begin.low[k].min(end.low[k])), high: per_axis!(k => begin.high[k].max(end.high[k])) }
}

/// The hull of two boxes by their ends.
#[inline(always)]
fn hull(begin: ([f32; 3], [f32; 3]), end: ([f32; 3], [f32; 3]), bulge: f32) -> ([f32; 3], [f32; 3]) {
    let low = per_axis!(k => smaller(begin.0[k], end.0[k]) - bulge);
    (low, per_axis!(k => larger(begin.1[k], end.1[k]) + bulge))
}

impl BoxTest for Hulls<'_> {
    const IS_OVERLAP: bool = false;
    const OPENS_CLUSTERS_ALIKE: bool = true;

    #[inline(always)]
    fn views<L: Lanes>(&mut self, lanes: L, a: &Node, b: &Node, _relation: &Relation) -> Views {
        let [begin, end] = Views::between_at_both(lanes, a, b, &self.span.places);
        self.end = end;
        begin
    }

    #[inline(always)]
    fn own<L: Lanes>(&mut self, lanes: L, a: &Node, b: &Node, views: &Views, scale: f32) -> bool {
        let Span { skew, length, turn, bulge, .. } = *self.span;
        let scale = f32x4::splat(scale);
        let a_box = (a.own_center, a.own_half);
        let b_box = (b.own_center * scale, b.own_half * scale);
        let of_b = Way::new(lanes, b_box, a_box, [&views.of_b, &self.end.of_b]);
        let of_a = Way::new(lanes, a_box, b_box, [&views.of_a, &self.end.of_a]);
        let way = larger(of_a.length(), of_b.length());
        let sizes = [sum(a_box.1), sum(b_box.1)];
        self.bulge = 0.127 * turn * (way + turn * larger(sizes[0], sizes[1])) + bulge;
        // One branch for both: neither can be guessed.
        if (of_a.apart(self.bulge) | of_b.apart(self.bulge)).any() {
            return false;
        }
        let size = sizes[0] + sizes[1];
        if edge_axes::are_slim(a, b) {
            let bends = (0.376 + 0.127 * turn) * way + 0.127 * turn * (sum(of_b.from_other) + size);
            let views = [&views.of_b, &self.end.of_b];
            if edge_axes::part_at_both(a, b_box, views, skew, turn * bends + bulge) {
                return false;
            }
        }
        let [in_a, in_b] =
            [views.of_b.margin.fast_max(self.end.of_b.margin), views.of_a.margin.fast_max(self.end.of_a.margin)]
                .map(|margin| margin.as_array()[0]);
        self.margins = [in_a + self.bulge, in_b + self.bulge];
        let time_of_gap = 0.999 * length / (way + turn * size + 2.0 * (in_a + in_b));
        let [x, y, z] = xyz(of_a.gap.fast_max(of_b.gap));
        self.least = self.least.max((x.max(y).max(z) - self.bulge) * time_of_gap + START);
        self.least < self.cut
    }

    #[inline(always)]
    fn both<L: Lanes>(&self, lanes: L, facing: Facing, alive: [u32; 2], keys: &mut Keys) -> u64 {
        let Facing { nodes: [x, y], views: [of_x, of_y], scales, is_a } = facing;
        let ([end_of_x, end_of_y], [in_x, in_y]) = (self.views(is_a), self.margins(is_a));
        let [alive_x, alive_y] = alive;
        let y_rows = Boxes::children(lanes, y, scales[1]);
        let y_hull = hulls(lanes, &y_rows, [of_y, end_of_y], in_x);
        let scale = f32x4::splat(scales[0]);
        let (low, high) = ends(x.own_center * scale, x.own_half * scale);
        let alive_y = alive_y & !y_hull.gap(lanes, low, high).mask();
        if alive_y == 0 {
            return 0;
        }
        let x_rows = Boxes::children(lanes, x, scales[0]);
        let x_hull = hulls(lanes, &x_rows, [of_x, end_of_x], in_y);
        let (center, half) = facing.other();
        let (low, high) = ends(center, half);
        let alive_x = alive_x & !x_hull.gap(lanes, low, high).mask();
        let (x_rows, x_hull) = (x_rows.slabs().store(), x_hull.store());
        let y_rows = y_rows.slabs();
        keys[0][0] = self.least;
        let mut pairs = 0;
        for i in bits(alive_x) {
            let overlap = y_hull.gap_at(lanes, &x_rows, i).min(y_rows.gap_at(lanes, &x_hull, i));
            pairs |= u64::from(!overlap.mask() & alive_y) << (WIDTH * i);
        }
        pairs
    }

    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: Facing, keys: &mut Keys) -> u32 {
        let Facing { nodes: [opened, _], views: [of_opened, of_other], scales, is_a } = facing;
        let ([end_of_opened, end_of_other], [in_opened, in_other]) = (self.views(is_a), self.margins(is_a));
        let children = Boxes::children(lanes, opened, scales[0]);
        let (center, half) = facing.other();
        let [begin, end] = [of_other, end_of_other].map(|view| {
            let half = View { margin: f32x4::splat(in_opened), ..*view }.half(half);
            ends(view.point(center), half)
        });
        let (low, high) = hull(begin, end, 0.0);
        let in_opened = children.slabs().gap(lanes, low, high);
        let (low, high) = ends(center, half);
        let hull = hulls(lanes, &children, [of_opened, end_of_opened], in_other);
        keys[0][0] = self.least;
        !in_opened.min(hull.gap(lanes, low, high)).mask() & opened.valid()
    }

    /// By the triangles' boxes along the axes of the other node, and by their planes; no later than the pair at hand.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: u32,
        triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64 {
        let begin = triangles();
        let (node, place) = (facing.nodes[1], &self.span.end);
        let view = if facing.is_a {
            self.end.triangles_of_a(node, place)
        } else {
            self.end.triangles_of_b(node, place, self.span.scale)
        };
        let end = Triangles { view, ..begin };
        let boxes = Boxes::children(lanes, node, facing.scales[1]);
        let slabs = boxes.slabs();
        let planes =
            if alive.is_power_of_two() { None } else { Some((Planes::new(lanes, &begin), Planes::new(lanes, &end))) };
        keys[0][0] = self.least;
        let mut pairs = 0;
        for i in bits(alive).map(|i| i % WIDTH) {
            let (first, last) = match &planes {
                Some((begin, end)) => (begin.at(i), end.at(i)),
                None => {
                    let row = begin.rows[i];
                    (Plane::new(row, &begin.view, begin.skew), Plane::new(row, &end.view, end.skew))
                }
            };
            let (low, high) = hull((first.low, first.high), (last.low, last.high), self.bulge);
            let apart = slabs.gap(lanes, low, high).mask();
            if !apart & node.valid() == 0 {
                continue;
            }
            let bulge = F8::splat(lanes, self.bulge * larger(first.length(), last.length()));
            let ([d, r], [e, s]) = (first.across(lanes, &boxes), last.across(lanes, &boxes));
            let above = bulge.less((d - r).min(e - s));
            let apart = apart | above.or(((d + r).max(e + s) + bulge).less(F8::splat(lanes, 0.0))).mask();
            pairs |= u64::from(!apart & node.valid()) << (WIDTH * i);
        }
        pairs
    }
}

/// How the own box of a node goes, as the other node sees it.
struct Way {
    /// From the middle of the other node's box to its own at the begin, and from there to where it is at the end.
    from_other: f32x4,
    way: f32x4,
    /// How far the boxes are apart at the begin.
    gap: f32x4,
    /// Where the hull of its ways ends, less the ends of the other box.
    above: f32x4,
    below: f32x4,
}

impl Way {
    #[inline(always)]
    fn new<L: Lanes>(lanes: L, own: (f32x4, f32x4), other: (f32x4, f32x4), [begin, end]: [&View; 2]) -> Self {
        let views = begin.and(lanes, end);
        let places = views.point(F8::twice(lanes, own.0)) - F8::twice(lanes, other.0);
        let halves = views.half(F8::twice(lanes, own.1)) + F8::twice(lanes, other.1);
        let [from_other, last] = places.halves();
        let ([x, y], [u, v]) = ((places - halves).halves(), (places + halves).halves());
        Self {
            from_other,
            way: last - from_other,
            gap: from_other.abs() - halves.halves()[0],
            above: x.fast_min(y),
            below: u.fast_max(v),
        }
    }

    /// How far it goes, or up to a tenth more: for `x >= y >= z`, `|v| <= x + (y + z) (sqrt2 - 1)`.
    #[inline(always)]
    fn length(&self) -> f32 {
        let [x, y, z] = xyz(self.way.abs());
        0.586 * larger(x, larger(y, z)) + 0.4143 * (x + y + z)
    }

    /// The axes on which both boxes stay apart.
    #[inline(always)]
    fn apart(&self, bulge: f32) -> f32x4 {
        let bulge = f32x4::splat(bulge);
        bulge.simd_lt(self.above) | self.below.simd_lt(f32x4::ZERO - bulge)
    }
}

#[cfg(all(test, feature = "std"))]
mod tests;
