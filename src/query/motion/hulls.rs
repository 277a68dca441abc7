//! Do boxes meet in a short span of time? Answered from their positions at its begin and end, eight
//! at a time.
//!
//! In the axes of a node that moves with the axis of rotation, each corner of a box of the other
//! node moves straight from its position at the begin to that at the end, up to a bounded bend. So
//! the box stays in the hull of both positions, and two boxes that meet overlap when one is
//! replaced by its hull. They meet no earlier than the gap between the own boxes at the begin can
//! have closed. This is tighter than [`Windows`](super::windows::Windows) if B turns, but gives no
//! times within the span. The proof is in `docs/numerics.md`, "Motion".

use super::relative_motion::Setting;
use super::windows::{BEGIN, SLOP, sum};
use crate::model::cost::{WORK_PER_SWEPT_EXPANSION, WORK_PER_SWEPT_TEST};
use crate::query::boxes::{Boxes, Extents, Facing, Planes, Slabs, Triangles};
use crate::query::edge_axes;
use crate::query::expand::{Keys, Measure};
use crate::query::relative_pose::{Place, Places, RelativePose, View, Views};
use crate::tree::{Node, WIDTH, xyz};
use punctual_geom::lanes::{Column, F8, Lanes, V8, dot, per_axis};
use punctual_geom::{bits, larger};
use wide::f32x4;

/// A span of time from the begin of a substep, in which B turns around one axis.
pub(super) struct Span {
    /// Poses of B at the begin and the end.
    places: Places,
    end: Place,
    scale: f32,
    rotation_error: f32,
    /// Length of the span, in lengths of the substep.
    length: f32,
    /// Upper bound of B's turn in the span, radians.
    turn: f32,
    /// Bound on the position error that does not depend on the path: the margin, rounding, and the
    /// motion of the axis across itself.
    arc_error: f32,
}

/// Larger turns (radians) bend paths by more than the bounds allow.
const LARGEST_TURN: f64 = 0.25;

impl Span {
    /// The span from the begin of a substep to `until`. `None` if both bodies turn, or beyond the
    /// range of `f32`.
    pub fn new(setting: &Setting, until: f64) -> Option<Self> {
        let Setting {
            trees,
            relative_motion,
            substep,
            relative,
            margin,
        } = *setting;
        relative_motion.of_axis()?;
        let time = until - substep.begin;
        let turn = relative_motion.spin * time;
        let end = relative.place_at(trees, &relative_motion.pose(until));
        let slip = relative_motion.slip() * time * turn * (0.375 + 0.125 * turn);
        let arc_error = (slip + 2.0 * relative_motion.rounding + margin) / relative.unit;
        (turn < LARGEST_TURN && arc_error < 1e6).then(|| Self {
            places: relative.place.and(&end),
            end,
            scale: relative.scale,
            rotation_error: relative.rotation_error,
            length: (time / substep.length()) as f32,
            turn: turn as f32 * 1.001,
            arc_error: arc_error as f32 * 1.001 + 1e-20,
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
    arc_error: f32,
    /// `arc_error` plus the margins of the overlap test, in the orientations of A's node and of
    /// B's.
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
            arc_error: 0.0,
            margins: [0.0; 2],
            are_apart: false,
        }
    }

    /// The motion of boxes of a node of A, or of B.
    #[inline(always)]
    fn passing(&self, of_a: bool) -> Passing<'_> {
        // In memory, as in [`crate::query::expand`].
        let views = core::hint::black_box(&*self.views);
        let (view, margin) = if of_a {
            (&views.of_a, self.margins[1])
        } else {
            (&views.of_b, self.margins[0])
        };
        Passing { view, margin }
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
            [begin[0].max(end[0]), begin[1].max(end[1])]
        });
        Slabs {
            along: [x[0], y[0], z[0]],
            against: [x[1], y[1], z[1]],
        }
    }

    /// Ends of boxes, as in [`Slabs`], along axis `k` at the begin, or with entry `4 + k` at the
    /// end.
    #[inline(always)]
    fn along<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>, k: usize) -> [F8<L>; 2] {
        let row = per_axis!(j => F8::splat(lanes, self.view.columns[j][k]));
        let center = dot(row, boxes.center) + F8::splat(lanes, self.view.origin[k]);
        let half = dot(sizes(&row), boxes.half) + F8::splat(lanes, self.margin);
        [center + half, half - center]
    }

    /// The hull of the positions of one box, by its ends.
    #[inline(always)]
    fn hull<L: Lanes>(&self, lanes: L, (center, half): (f32x4, f32x4)) -> Slabs<L> {
        let view = self.view.load(lanes);
        let center = view.point(F8::twice(lanes, center));
        let half = view.size(F8::twice(lanes, half)) + F8::splat(lanes, self.margin);
        let ([a, b], [c, d]) = ((center + half).halves(), (half - center).halves());
        Slabs::of(lanes, xyz(a.fast_max(b)), xyz(c.fast_max(d)))
    }
}

impl Measure for Hulls<'_> {
    const READS_VIEWS: bool = false;
    const WORK: [u64; 2] = [WORK_PER_SWEPT_EXPANSION, WORK_PER_SWEPT_TEST];

    type Along<L: Lanes> = F8<L>;

    /// Includes the test of own boxes: separated boxes need no views.
    #[inline(always)]
    fn views<L: Lanes>(&mut self, lanes: L, a: &Node, b: &Node, _relation: &RelativePose) -> Views {
        let span = self.span;
        let (turn, arc_error) = (span.turn, span.arc_error);
        let [in_a, in_b] = span.places.margin;
        let of_b = View::at_both(lanes, a, b, &span.places);
        let of_a = of_b.inverse(lanes, in_b);
        let [way_of_b, way_of_a] = Way::of_both(lanes, [a, b], [&of_b, &of_a], span.scale);
        let halves = [a.own_half, b.own_half * f32x4::splat(span.scale)];
        let (sizes, way) = (
            [sum(halves[0]), sum(halves[1])],
            longer(way_of_a.way(), way_of_b.way()),
        );
        let (size, apart, views) = (sizes[0] + sizes[1], way_of_b.places, Views { of_a, of_b });
        self.arc_error = 0.127 * turn * (way + turn * larger(sizes[0], sizes[1])) + arc_error;
        // One branch for both, because neither is predictable.
        self.are_apart = f32x4::splat(self.arc_error)
            .simd_lt(way_of_a.gap().fast_max(way_of_b.gap()))
            .any()
            || edge_axes::are_slim(a, b) && {
                let bends =
                    (0.376 + 0.127 * turn) * way + 0.127 * turn * (sum(apart.halves()[0]) + size);
                let margin = turn * bends + arc_error;
                edge_axes::part_at_both(
                    lanes,
                    halves,
                    apart,
                    &views.of_b,
                    span.rotation_error,
                    margin,
                )
            };
        if !self.are_apart {
            self.margins = [in_a + self.arc_error, in_b + self.arc_error];
            let time_of_gap = 0.999 * span.length / (way + turn * size + 2.0 * (in_a + in_b));
            let [x, y, z] = xyz(way_of_a.gap_at_begin().fast_max(way_of_b.gap_at_begin()));
            self.least = larger(
                self.least,
                (larger(larger(x, y), z) - self.arc_error) * time_of_gap + START,
            );
            *self.views = views.store();
        }
        views.first()
    }

    #[inline(always)]
    fn own(&mut self, _: [&Node; 2], _: &Views, _: &RelativePose) -> bool {
        !self.are_apart && self.least < self.cut
    }

    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: &Facing, k: usize) -> Extents<L> {
        let boxes = facing.children(lanes, k);
        Extents {
            own: boxes.slabs(),
            seen: self.passing(facing.is_of_a(k)).hulls(lanes, &boxes),
            ahead: F8::splat(lanes, 0.0),
        }
    }

    #[inline(always)]
    fn own_box<L: Lanes>(&self, lanes: L, facing: &Facing, k: usize) -> Extents<L> {
        let (center, half) = facing.own(k);
        Extents {
            own: Slabs::of_box(lanes, center, half),
            seen: self.passing(facing.is_of_a(k)).hull(lanes, (center, half)),
            ahead: F8::splat(lanes, 0.0),
        }
    }

    #[inline(always)]
    fn compare<L: Lanes>(&self, _: L, other: &Slabs<L>, opened: &Slabs<L>) -> F8<L> {
        other.depth(opened)
    }

    /// The overlap depth, which serves only to select.
    #[inline(always)]
    fn key<L: Lanes>(&self, _: L, in_opened: F8<L>, in_other: F8<L>, _: F8<L>) -> F8<L> {
        in_opened.min(in_other)
    }

    #[inline(always)]
    fn hits<L: Lanes>(&self, _: L, keys: F8<L>) -> u32 {
        !keys.mask() & 0xff
    }

    #[inline(always)]
    fn common_key(&self) -> Option<f32> {
        Some(self.least)
    }

    /// Tests the triangles' boxes along the axes of the other node, and their planes.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: &Facing,
        active: u32,
        triangles: impl FnOnce() -> Triangles<'t>,
        _: &mut Keys,
    ) -> u64 {
        let begin = triangles();
        let (node, span) = (facing.nodes[1], self.span);
        let view = (self.views.second()).triangles(facing.is_a, node, &span.end, span.scale);
        let end = Triangles { view, ..begin };
        let boxes = facing.children(lanes, 1);
        let slabs = boxes.slabs();
        let (mut begin, mut end) = (Planes::new(lanes, &begin), Planes::new(lanes, &end));
        begin.enclose(lanes, &mut end, self.arc_error);
        let mut pairs = 0;
        for i in bits(active).map(|i| i % WIDTH) {
            let (first, last) = (begin.at(i), end.at(i));
            let box_of = Slabs::of(lanes, first.along, first.against);
            let apart = slabs.depth(&box_of).mask();
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
