//! Do boxes meet in a short span of time? Answered from their positions at its begin and end, eight
//! at a time.
//!
//! In the axes of a node that moves with the axis of rotation, each corner of a box of the other
//! node moves straight from its position at the begin to that at the end, up to a bounded bend. So
//! the box stays in the hull of both positions, and two boxes that meet overlap when one is
//! replaced by its hull. They meet no earlier than the gap between the own boxes at the begin can
//! have closed. This is tighter than [`Windows`](super::windows::Windows) if B turns, but gives no
//! times within the span. The proof is in `docs/numerics.md`, "Motion".

use super::course::{Course, Piece};
use super::windows::{BEGIN, SLOP, sum};
use crate::query::boxes::{BoxTest, Boxes, Facing, Keys, Plane, Planes, Slabs, Triangles, ends};
use crate::query::edge_axes;
use crate::query::views::{Place, Places, Relation, View, Views};
use crate::tree::{Node, Tree, WIDTH, xyz};
use punctual_geom::lanes::{Column, F8, Lanes, V8, dot, per_axis};
use punctual_geom::{bits, larger};
use wide::f32x4;

/// A span of time from the begin of a piece, in which B turns around one axis.
pub(super) struct Span {
    /// Poses of B at the begin and the end.
    places: Places,
    end: Place,
    scale: f32,
    skew: f32,
    /// Length of the span, in lengths of the piece.
    length: f32,
    /// Upper bound of B's turn in the span, radians.
    turn: f32,
    /// Bound on the position error that does not depend on the path: the margin, rounding, and the
    /// motion of the axis across itself.
    bulge: f32,
}

/// Larger turns (radians) bend paths by more than the bounds allow.
const LARGEST_TURN: f64 = 0.25;

impl Span {
    /// The span from the begin of a piece to `until`. `None` if both bodies turn, or beyond the
    /// range of `f32`.
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

/// Selects boxes that meet in a span and before `cut`. Keys are lower bounds of the times at which
/// they meet.
pub(super) struct Hulls<'s> {
    /// Pairs with this time or a later one are of no interest.
    cut: f32,
    /// The key of the current pair; its children's keys are not less.
    pub least: f32,
    span: &'s Span,
    /// The views of the current nodes, at the begin of the span and at its end.
    views: &'s mut Views<[f32; 8]>,
    /// Bound on the bend of paths between the current nodes, plus the position error.
    bulge: f32,
    /// `bulge` plus the margins of the overlap test, in the orientations of A's node and of B's.
    margins: [f32; 2],
    /// True if the own boxes of the current nodes do not meet.
    are_apart: bool,
}

/// Nothing meets before the begin.
const START: f32 = BEGIN - SLOP;

impl<'s> Hulls<'s> {
    #[inline(always)]
    pub fn new(cut: f32, least: f32, span: &'s Span, views: &'s mut Views<[f32; 8]>) -> Self {
        Self {
            cut,
            least,
            span,
            views,
            bulge: 0.0,
            margins: [0.0; 2],
            are_apart: false,
        }
    }

    /// The motion of the children of the opened node, and of those of the other.
    #[inline(always)]
    fn passing(&self, is_a: bool) -> [Passing<'_>; 2] {
        // In memory, as in [`crate::query::expand`].
        let (Views { of_a, of_b }, [in_a, in_b]) =
            (core::hint::black_box(&*self.views), self.margins);
        let (of_a, of_b) = (
            Passing {
                view: of_a,
                margin: in_b,
            },
            Passing {
                view: of_b,
                margin: in_a,
            },
        );
        if is_a { [of_a, of_b] } else { [of_b, of_a] }
    }
}

/// The motion of boxes of a node, as seen from the other node.
struct Passing<'v> {
    view: &'v View<[f32; 8]>,
    margin: f32,
}

impl Passing<'_> {
    /// The hulls of the positions of boxes. Axis by axis, which uses the fewest registers.
    #[inline(always)]
    fn hulls<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>) -> Slabs<L> {
        let [x, y, z] = per_axis!(k => {
            let (begin, end) = (self.along(lanes, boxes, k), self.along(lanes, boxes, 4 + k));
            [begin[0].min(end[0]), begin[1].max(end[1])]
        });
        Slabs {
            low: [x[0], y[0], z[0]],
            high: [x[1], y[1], z[1]],
        }
    }

    /// Ends of boxes along axis `k` at the begin, or with entry `4 + k` at the end.
    #[inline(always)]
    fn along<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>, k: usize) -> [F8<L>; 2] {
        let row = per_axis!(j => F8::splat(lanes, self.view.columns[j][k]));
        let center = dot(row, boxes.center) + F8::splat(lanes, self.view.origin[k]);
        let half = dot(sizes(&row), boxes.half) + F8::splat(lanes, self.margin);
        [center - half, center + half]
    }

    /// The hull of the positions of one box, by its ends.
    #[inline(always)]
    fn hull<L: Lanes>(&self, lanes: L, (center, half): (f32x4, f32x4)) -> ([f32; 3], [f32; 3]) {
        let view = self.view.load(lanes);
        let center = view.point(F8::twice(lanes, center));
        let half = view.size(F8::twice(lanes, half)) + F8::splat(lanes, self.margin);
        let ([a, b], [c, d]) = ((center - half).halves(), (center + half).halves());
        (xyz(a.fast_min(b)), xyz(c.fast_max(d)))
    }
}

impl BoxTest for Hulls<'_> {
    const IS_OVERLAP: bool = false;
    const READS_VIEWS: bool = false;
    const OPENS_CLUSTERS_ALIKE: bool = true;

    /// Includes the test of own boxes: separated boxes need no views.
    #[inline(always)]
    fn views<L: Lanes>(&mut self, lanes: L, a: &Node, b: &Node, _relation: &Relation) -> Views {
        let Span {
            places,
            scale,
            skew,
            length,
            turn,
            bulge,
            ..
        } = self.span;
        let [in_a, in_b] = places.margin;
        let of_b = View::at_both(lanes, a, b, places);
        let of_a = of_b.inverse(lanes, in_b);
        let [way_of_b, way_of_a] = Way::of_both(lanes, [a, b], [&of_b, &of_a], *scale);
        let halves = [a.own_half, b.own_half * f32x4::splat(*scale)];
        let (sizes, way) = (
            [sum(halves[0]), sum(halves[1])],
            longer(way_of_a.way(), way_of_b.way()),
        );
        let (size, apart, views) = (sizes[0] + sizes[1], way_of_b.places, Views { of_a, of_b });
        self.bulge = 0.127 * turn * (way + turn * larger(sizes[0], sizes[1])) + bulge;
        // One branch for both, because neither is predictable.
        self.are_apart = f32x4::splat(self.bulge)
            .simd_lt(way_of_a.gap().fast_max(way_of_b.gap()))
            .any()
            || edge_axes::are_slim(a, b) && {
                let bends =
                    (0.376 + 0.127 * turn) * way + 0.127 * turn * (sum(apart.halves()[0]) + size);
                edge_axes::part_at_both(
                    lanes,
                    halves,
                    apart,
                    &views.of_b,
                    *skew,
                    turn * bends + bulge,
                )
            };
        if !self.are_apart {
            self.margins = [in_a + self.bulge, in_b + self.bulge];
            let time_of_gap = 0.999 * length / (way + turn * size + 2.0 * (in_a + in_b));
            let [x, y, z] = xyz(way_of_a.gap_at_begin().fast_max(way_of_b.gap_at_begin()));
            self.least = larger(
                self.least,
                (larger(larger(x, y), z) - self.bulge) * time_of_gap + START,
            );
            *self.views = views.store();
        }
        views.first()
    }

    #[inline(always)]
    fn own<L: Lanes>(
        &mut self,
        _lanes: L,
        _a: &Node,
        _b: &Node,
        _views: &Views,
        _scale: f32,
    ) -> bool {
        !self.are_apart && self.least < self.cut
    }

    #[inline(always)]
    fn both<L: Lanes>(&self, lanes: L, facing: Facing, alive: [u32; 2], keys: &mut Keys) -> u64 {
        let ([x, y], scales, [alive_x, alive_y]) = (facing.nodes, facing.scales, alive);
        let [of_x, of_y] = self.passing(facing.is_a);
        let y_rows = Boxes::children(lanes, y, scales[1]);
        let y_hull = of_y.hulls(lanes, &y_rows);
        let scale = f32x4::splat(scales[0]);
        let (low, high) = ends(x.own_center * scale, x.own_half * scale);
        let alive_y = alive_y & !y_hull.depth(lanes, low, high).mask();
        // Without whole registers, an unpredictable branch costs more than it saves.
        if !L::IS_WHOLE && alive_y == 0 {
            return 0;
        }
        let x_rows = Boxes::children(lanes, x, scales[0]);
        let x_hull = of_x.hulls(lanes, &x_rows);
        let (center, half) = facing.other();
        let (low, high) = ends(center, half);
        let alive_x = alive_x & !x_hull.depth(lanes, low, high).mask();
        let (x_rows, x_hull) = (x_rows.slabs().store(), x_hull.store());
        let y_rows = y_rows.slabs();
        keys[0][0] = self.least;
        let mut pairs = 0;
        for i in bits(alive_x) {
            let overlap = y_hull
                .depth_at(lanes, &x_rows, i)
                .min(y_rows.depth_at(lanes, &x_hull, i));
            pairs |= u64::from(!overlap.mask() & alive_y) << (WIDTH * i);
        }
        pairs
    }

    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: Facing, keys: &mut Keys) -> u32 {
        let (opened, [of_opened, of_other]) = (facing.nodes[0], self.passing(facing.is_a));
        let children = Boxes::children(lanes, opened, facing.scales[0]);
        let (center, half) = facing.other();
        let (low, high) = of_other.hull(lanes, (center, half));
        let in_opened = children.slabs().depth(lanes, low, high);
        let (low, high) = ends(center, half);
        let hulls = of_opened.hulls(lanes, &children);
        keys[0][0] = self.least;
        !in_opened.min(hulls.depth(lanes, low, high)).mask() & opened.valid()
    }

    /// Tests the triangles' boxes along the axes of the other node, and their planes. All keys are
    /// that of the current pair.
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
        let end = self.views.second();
        let view = if facing.is_a {
            end.triangles_of_a(node, place)
        } else {
            end.triangles_of_b(node, place, self.span.scale)
        };
        let end = Triangles { view, ..begin };
        let boxes = Boxes::children(lanes, node, facing.scales[1]);
        let slabs = boxes.slabs();
        let planes = if alive.is_power_of_two() {
            None
        } else {
            let (mut begin, mut end) = (Planes::new(lanes, &begin), Planes::new(lanes, &end));
            begin.enclose(lanes, &mut end, self.bulge);
            Some((begin, end))
        };
        keys[0][0] = self.least;
        let mut pairs = 0;
        for i in bits(alive).map(|i| i % WIDTH) {
            let (first, last) = match &planes {
                Some((begin, end)) => (begin.at(i), end.at(i)),
                None => {
                    let row = begin.rows[i];
                    let mut first = Plane::new(row, &begin.view, begin.skew);
                    let mut last = Plane::new(row, &end.view, end.skew);
                    first.enclose(&mut last, self.bulge);
                    (first, last)
                }
            };
            let apart = slabs.depth(lanes, first.low, first.high).mask();
            if !apart & node.valid() == 0 {
                continue;
            }
            // The extents of the boxes below the plane and above it.
            let ([d, r], [e, s]) = (first.across(lanes, &boxes), last.across(lanes, &boxes));
            let apart = apart | (r - d).max(s - e).min((r + d).max(s + e)).mask();
            pairs |= u64::from(!apart & node.valid()) << (WIDTH * i);
        }
        pairs
    }
}

/// The motion of the own box of a node, as seen from the other node: the vector between the
/// middles, and the sums of the half extents, each at the begin and at the end.
struct Way<L: Lanes> {
    places: F8<L>,
    halves: F8<L>,
}

impl<L: Lanes> Way<L> {
    /// The motion of B's box, and that of A's.
    #[inline(always)]
    fn of_both(
        lanes: L,
        [a, b]: [&Node; 2],
        [of_b, of_a]: [&View<F8<L>>; 2],
        scale: f32,
    ) -> [Self; 2] {
        let scale = F8::splat(lanes, scale);
        let (a_center, a_half) = (F8::twice(lanes, a.own_center), F8::twice(lanes, a.own_half));
        let (b_center, b_half) = (
            F8::twice(lanes, b.own_center) * scale,
            F8::twice(lanes, b.own_half) * scale,
        );
        let apart = of_b.origin - a_center;
        let scaled = per_axis!(k => of_b.columns[k] * scale);
        // Without this, the compiler spreads entries in registers.
        let [a, b] = core::hint::black_box([a, b]);
        [
            Self {
                places: dot(scaled, each(lanes, &b.own_center)) + apart,
                halves: dot(sizes(&scaled), each(lanes, &b.own_half)) + (a_half + of_b.margin),
            },
            Self {
                places: of_a.vector(apart) + b_center,
                halves: dot(sizes(&of_a.columns), each(lanes, &a.own_half))
                    + (b_half + of_a.margin),
            },
        ]
    }

    #[inline(always)]
    fn way(&self) -> f32x4 {
        let [begin, end] = self.places.halves();
        end - begin
    }

    /// Gap between the boxes along each axis during the span.
    #[inline(always)]
    fn gap(&self) -> f32x4 {
        let ([x, y], [u, v]) = (
            (self.places - self.halves).halves(),
            (self.places + self.halves).halves(),
        );
        x.fast_min(y).fast_max(-u.fast_max(v))
    }

    /// Gap at the begin.
    #[inline(always)]
    fn gap_at_begin(&self) -> f32x4 {
        self.places.halves()[0].abs() - self.halves.halves()[0]
    }
}

/// The entries of a vector, each eight times, spread from memory: spreading from a register takes
/// as long as a product.
#[inline(always)]
fn each<L: Lanes>(lanes: L, v: &f32x4) -> V8<L> {
    per_axis!(k => F8::splat(lanes, v.as_array()[k]))
}

#[inline(always)]
fn sizes<L: Lanes>(columns: &V8<L>) -> V8<L> {
    per_axis!(k => columns[k].abs())
}

/// Upper bound of the length of the longer of two vectors, at most a tenth more: for `x >= y >= z`,
/// `|v| <= x + (y + z) (sqrt2 - 1)`.
#[inline(always)]
fn longer(u: f32x4, v: f32x4) -> f32 {
    let ([a, b, c, _], [d, e, f, _]) = (u.abs().to_array(), v.abs().to_array());
    let (x, y, z) = (
        f32x4::new([a, d, b, e]),
        f32x4::new([b, e, b, e]),
        f32x4::new([c, f, c, f]),
    );
    let lengths =
        x.fast_max(y).fast_max(z) * f32x4::splat(0.586) + (x + y + z) * f32x4::splat(0.4143);
    let [u, v, ..] = lengths.to_array();
    larger(u, v)
}

#[cfg(all(test, feature = "std"))]
mod tests;
