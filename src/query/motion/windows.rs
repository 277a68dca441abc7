//! Times at which moving boxes meet: lower bounds, eight at a time.
//!
//! A box of B that moves along a straight line overlaps a box of A, on an axis, during one time
//! interval; on six axes, from the latest start to the earliest end. Triangles and boxes are also
//! compared along the triangles' normals. All is in A's units, with the views and margins of the
//! overlap test. The unit of time is the length of the substep, from -1/2 to 1/2. The proof is in
//! `docs/numerics.md`, "Motion".

use super::relative_motion::Setting;
use crate::engine::boxes::edge_axes;
use crate::engine::boxes::relative_pose::{Entries, RelativePose, View, Views, cross};
use crate::engine::boxes::{Boxes, Extents, Facing, Plane, Planes, Slabs, Triangles, splat};
use crate::engine::expand::{Keys, Measure};
use crate::model::cost::{WORK_PER_SWEPT_EXPANSION, WORK_PER_SWEPT_TEST};
use crate::tree::{Node, WIDTH, xyz};
use glam::DVec3;
use punctual_geom::bits;
use punctual_geom::lanes::{Column, F8, Lanes, add, per_axis};
use punctual_geom::tolerance::ROUNDING;
use punctual_geom::triangle::swept::Glide;
use wide::f32x4;

/// The begin of the substep.
pub(super) const BEGIN: f32 = -0.5;

/// Bound on the rounding of times.
const TIME_ERROR: f32 = 8.0 * ROUNDING;

/// Half a unit of time, plus 1 percent for matrices that are not exactly rotations.
const HALF_A_SUBSTEP: f32 = 0.505;

/// Slower projections count as this fast. The allowance for underflow covers the error.
const LEAST_SPEED: f32 = 1e-37;

/// A substep of motion in `f32`, in A's unit coordinates.
pub(super) fn glide(setting: &Setting, relative: &RelativePose, origin: DVec3) -> Glide {
    let Setting {
        relative_motion,
        substep,
        margin,
    } = *setting;
    let (length, unit) = (substep.length(), relative.unit);
    let twist = relative_motion.twist(substep.middle);
    let velocity = twist.at(origin) * (length / unit);
    let pull = twist.acceleration(origin) * (length * length / unit);
    let (turn, change) = (twist.turn * length, twist.change * (length * length));
    let arc_error =
        (relative_motion.bend_besides(length / 2.0) + relative_motion.rounding + margin) / unit;
    let vector = |v: DVec3| v.as_vec3().extend(0.0).to_array();
    if arc_error < 1e6 && velocity.abs().max(pull.abs()).max_element() < 1e6 {
        Glide {
            shift: vector(velocity),
            turn: vector(turn),
            pull: vector(pull),
            change: vector(change),
            turn_error: (relative_motion.turn_error * length * length * 0.5) as f32 * 1.01,
            spin: (relative_motion.spin * length * 0.5) as f32 * 1.001,
            arc_error: arc_error as f32 * 1.001 + 1e-20,
        }
    } else {
        // Beyond the range of `f32`, or NaN: everything may meet at any time.
        Glide {
            arc_error: 1e15,
            ..Glide::default()
        }
    }
}

/// Selects boxes that meet before `cut`. Keys are lower bounds of the times at which they meet.
pub(super) struct Windows<'g> {
    /// Pairs with this time or a later one are of no interest.
    cut: f32,
    /// The key of the current pair; its children's keys are not less.
    pub least: f32,
    rotation_error: f32,
    glide: &'g Glide,
    /// The drift of B in the orientations of the current nodes.
    in_a: Drift,
    in_b: Drift,
}

/// The motion of B along the axes of a node. Positions divided by the velocity are times. With box
/// ends as times, two boxes meet from the difference of one pair of ends until that of the other
/// pair.
#[derive(Clone, Copy, Default)]
struct Drift {
    /// Per axis: -1 over the velocity, and 1 over the speed.
    inverse: f32x4,
    size: f32x4,
    /// The margins divided by the speed: times.
    extra: f32x4,
    velocity: f32x4,
    /// The position error of B plus the margin of the overlap test.
    pub margin: f32x4,
}

impl Drift {
    #[inline(always)]
    fn new(velocity: f32x4, margin: f32x4) -> Self {
        // Lower limit of the speed along an axis.
        let least = sum(velocity) * 1e-6 + 1e-20;
        let size = f32x4::ONE / velocity.abs().fast_max(f32x4::splat(least));
        let inverse = velocity
            .simd_lt(f32x4::ZERO)
            .select(size, f32x4::ZERO - size);
        let margin = margin + f32x4::splat(least);
        Self {
            inverse,
            size,
            extra: size * margin + f32x4::splat(TIME_ERROR),
            velocity,
            margin,
        }
    }

    /// The ends of boxes as times, widened by `extra`. `sign` is -1 if the boxes are of B, which
    /// meet boxes of A.
    #[inline(always)]
    fn ends<L: Lanes>(
        &self,
        lanes: L,
        boxes: &Boxes<L>,
        extra: Option<f32x4>,
        sign: f32,
    ) -> Slabs<L> {
        let (inverse, size) = (self.inverse * f32x4::splat(sign), self.size);
        let slabs = Boxes {
            center: per_axis!(k => boxes.center[k] * F8::splat(lanes, inverse.as_array()[k])),
            half: per_axis!(k => boxes.half[k] * F8::splat(lanes, size.as_array()[k])),
        }
        .slabs();
        let Some(extra) = extra.map(|extra| splat(lanes, extra)) else {
            return slabs;
        };
        Slabs {
            along: add(slabs.along, extra),
            against: add(slabs.against, extra),
        }
    }

    /// [`Drift::ends`] of a single box, eight times.
    #[inline(always)]
    fn ends_of_one<L: Lanes>(
        &self,
        lanes: L,
        (center, half): (f32x4, f32x4),
        extra: Option<f32x4>,
        sign: f32,
    ) -> Slabs<L> {
        let center = center * self.inverse * f32x4::splat(sign);
        Slabs::of_box(
            lanes,
            center,
            half * self.size + extra.unwrap_or(f32x4::ZERO),
        )
    }

    /// The ends of a triangle's box as times, eight times.
    #[inline(always)]
    fn ends_of_triangle<L: Lanes>(&self, lanes: L, plane: &Plane, sign: f32) -> Slabs<L> {
        let inverse = self.inverse * f32x4::splat(sign);
        let [u, v] =
            [plane.along, plane.against].map(|[x, y, z]| f32x4::new([x, y, z, 0.0]) * inverse);
        Slabs::of(lanes, xyz(u.fast_max(-v)), xyz(v.fast_max(-u)))
    }

    /// Time interval in which boxes reach across the plane of a triangle.
    #[inline(always)]
    fn through_plane<L: Lanes>(
        &self,
        lanes: L,
        plane: &Plane,
        boxes: &Boxes<L>,
        sign: f32,
    ) -> [F8<L>; 2] {
        let ([x, y, z], [u, v, w], [p, q, r]) =
            (plane.normal, xyz(self.velocity), xyz(self.margin));
        let (length, speed) = (x.abs() + y.abs() + z.abs(), u.abs() + v.abs() + w.abs());
        let along = (x * u + y * v + z * w) * sign;
        let least = length * speed * 1e-6 + LEAST_SPEED;
        let size = 1.0 / along.abs().max(least);
        let inverse = if along < 0.0 { size } else { -size };
        let margin = x.abs() * p
            + y.abs() * q
            + z.abs() * r
            + plane.normal_error * (2.0 * (p + q + r) + speed);
        let plane_error = plane.plane_error + margin + least;
        let [distance, reach] = Plane {
            plane_error,
            ..*plane
        }
        .across(lanes, boxes);
        let middle = distance * F8::splat(lanes, inverse);
        let half = reach * F8::splat(lanes, size) + F8::splat(lanes, TIME_ERROR);
        [middle - half, middle + half]
    }

    /// Time interval in which two boxes overlap whose centres are `apart` and whose half extents
    /// sum to `reach`.
    #[inline(always)]
    fn window(&self, apart: f32x4, reach: f32x4) -> [f32; 2] {
        let (middle, half) = (apart * self.inverse, reach * self.size + self.extra);
        let ([a, b, c], [d, e, f]) = (xyz(middle - half), xyz(middle + half));
        [a.max(b).max(c), d.min(e).min(f)]
    }
}

/// The motion of a part of B, as seen from one node.
struct Way {
    velocity: f32x4,
    turn: f32x4,
    /// The bend of its path until the substep ends.
    bend: f32x4,
    /// Bound on the error of the path.
    margin: f32,
}

impl Way {
    /// The motion as seen from the other node.
    #[inline(always)]
    fn seen(&self, view: &View) -> Self {
        let [velocity, turn, bend] = [self.velocity, self.turn, self.bend].map(|v| view.vector(v));
        Self {
            velocity,
            turn,
            bend,
            margin: self.margin,
        }
    }
}

impl<'g> Windows<'g> {
    #[inline(always)]
    pub fn new(cut: f32, least: f32, glide: &'g Glide, relative: &RelativePose) -> Self {
        Self {
            cut,
            least,
            rotation_error: relative.rotation_error,
            glide,
            in_a: Drift::default(),
            in_b: Drift::default(),
        }
    }

    /// The motion of a part of B at `place`, as seen from A's node.
    #[inline(always)]
    fn way(&self, a: &Node, views: &Views, place: f32x4) -> Way {
        let seen = |v: [f32; 4]| views.direction(a, f32x4::new(v)).0;
        let shift = seen(self.glide.shift);
        let mut way = Way {
            velocity: shift,
            turn: f32x4::ZERO,
            bend: f32x4::ZERO,
            margin: self.glide.arc_error,
        };
        let mut speed = sum(shift);
        if self.glide.spin > 0.0 {
            way.turn = seen(self.glide.turn);
            let turned = cross(way.turn, place);
            way.velocity += turned;
            let pull = seen(self.glide.pull);
            let mut acceleration = pull + cross(way.turn, turned);
            if self.glide.turn_error > 0.0 {
                acceleration += cross(seen(self.glide.change), place);
            }
            // In half a unit of time, half of its square is an eighth; plus 1 percent.
            way.bend = acceleration * f32x4::splat(0.12625);
            speed += sum(way.turn) * sum(place) + sum(pull);
        }
        way.margin += (self.rotation_error + 32.0 * ROUNDING) * speed;
        way
    }

    /// The drift of a box with these half extents, if directions are off by `rotation_error`.
    #[inline(always)]
    fn drift(&self, way: &Way, half: f32x4, margin: f32x4, rotation_error: f32) -> Drift {
        let mut margin = margin + f32x4::splat(way.margin);
        if self.glide.spin > 0.0 {
            let off = self.off(
                way.turn,
                self.glide.turn_error + rotation_error * sum(way.turn),
                half,
            );
            margin += off + way.bend.abs() + f32x4::splat(rotation_error * sum(way.bend));
        }
        Drift::new(way.velocity, margin)
    }

    /// Bound on the distance of points within the half extents from the lines that they would
    /// follow with the velocity of their middle.
    #[inline(always)]
    fn off(&self, turn: f32x4, turn_error: f32, half: f32x4) -> f32x4 {
        let turn = turn.abs() + f32x4::splat(turn_error);
        let way = turn.yzx() * half.zxy() + turn.zxy() * half.yzx();
        way * f32x4::splat(HALF_A_SUBSTEP) + f32x4::splat(sum(way) * self.glide.spin * 0.25)
    }

    /// The drifts in the orientation of the opened node, and in that of the other node; and 1 if
    /// the opened node is A's, else -1.
    #[inline(always)]
    fn drifts(&self, facing: &Facing) -> ([&Drift; 2], f32) {
        if facing.is_a {
            ([&self.in_a, &self.in_b], 1.0)
        } else {
            ([&self.in_b, &self.in_a], -1.0)
        }
    }
}

fn sum(a: f32x4) -> f32 {
    let [x, y, z] = xyz(a.abs());
    x + y + z
}

impl Measure for Windows<'_> {
    const IS_LARGE: bool = true;
    const WORK: [u64; 2] = [WORK_PER_SWEPT_EXPANSION, WORK_PER_SWEPT_TEST];

    type Along<L: Lanes> = [F8<L>; 2];

    #[inline(always)]
    fn own(&mut self, [a, b]: [&Node; 2], views: &Views, relative: &RelativePose) -> bool {
        let scale = f32x4::splat(relative.scale);
        let (a_center, a_half) = (a.own_center, a.own_half);
        let (b_center, b_half) = (b.own_center * scale, b.own_half * scale);
        let seen = views.of_b.point(b_center);
        let half = views.of_b.half(b_half);
        let way = self.way(a, views, seen);
        self.in_a = self.drift(&way, half, views.of_b.margin, 0.0);
        let [mut enter, mut leave] = self.in_a.window(seen - a_center, half + a_half);
        if leave < enter.max(BEGIN) || enter >= self.cut {
            return false;
        }
        // Directions are off by the rotation error times the sum of their components. Seen from B,
        // this sum may be less by a factor of up to the root of 3, which the 2 covers.
        self.in_b = self.drift(
            &way.seen(&views.of_a),
            b_half,
            views.of_a.margin,
            2.0 * self.rotation_error,
        );
        let of_b = self.in_b.window(
            b_center - views.of_a.point(a_center),
            views.of_a.half(a_half) + b_half,
        );
        (enter, leave) = (enter.max(of_b[0]), leave.min(of_b[1]));
        if leave < enter.max(BEGIN) || enter >= self.cut {
            return false;
        }
        if edge_axes::are_slim(a, b) {
            let of_edges = edge_axes::window(
                a,
                (b_center, b_half),
                &views.of_b,
                self.rotation_error,
                (self.in_a.velocity, self.in_a.margin),
            );
            (enter, leave) = (
                enter.max(of_edges[0] - TIME_ERROR),
                leave.min(of_edges[1] + TIME_ERROR),
            );
            if leave < enter.max(BEGIN) {
                return false;
            }
        }
        self.least = self.least.max(enter);
        self.least < self.cut
    }

    /// Ends of the children's boxes as times. Those of the other node are widened by the margins.
    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: &Facing, k: usize) -> Extents<L> {
        let (drifts, sign) = self.drifts(facing);
        let (own, seen, boxes) = (drifts[k], drifts[1 - k], facing.children(lanes, k));
        let extra = |drift: &Drift| (k == 1).then_some(drift.extra);
        Extents {
            own: own.ends(lanes, &boxes, extra(own), sign),
            seen: seen.ends(
                lanes,
                &boxes.seen(lanes, facing.views[k]),
                extra(seen),
                sign,
            ),
            ahead: F8::splat(lanes, 0.0),
        }
    }

    #[inline(always)]
    fn own_box<L: Lanes>(&self, lanes: L, facing: &Facing, k: usize) -> Extents<L> {
        let (drifts, sign) = self.drifts(facing);
        let (own, seen, view) = (drifts[k], drifts[1 - k], facing.views[k]);
        let (center, half) = facing.own(k);
        let extra = |drift: &Drift| (k == 1).then_some(drift.extra);
        let there = (view.point(center), view.half(half));
        Extents {
            own: own.ends_of_one(lanes, (center, half), extra(own), sign),
            seen: seen.ends_of_one(lanes, there, extra(seen), sign),
            ahead: F8::splat(lanes, 0.0),
        }
    }

    /// The time interval in which the boxes overlap. Their ends on each axis are times:
    /// coordinates divided by the relative speed on that axis.
    #[inline(always)]
    fn compare<L: Lanes>(&self, _: L, other: &Slabs<L>, opened: &Slabs<L>) -> [F8<L>; 2] {
        let [x, y, z] = per_axis!(k => other.against[k] + opened.along[k]);
        let [u, v, w] = per_axis!(k => other.along[k] + opened.against[k]);
        [-x.min(y).min(z), u.min(v).min(w)]
    }

    /// The time from which on boxes may meet; infinite if they do not.
    #[inline(always)]
    fn key<L: Lanes>(&self, lanes: L, of_x: [F8<L>; 2], of_y: [F8<L>; 2], _: F8<L>) -> F8<L> {
        let (enter, leave) = (of_x[0].max(of_y[0]), of_x[1].min(of_y[1]));
        let gone = leave.less(enter.max(F8::splat(lanes, BEGIN)));
        gone.select(
            F8::splat(lanes, f32::INFINITY),
            enter.max(F8::splat(lanes, self.least)),
        )
    }

    #[inline(always)]
    fn hits<L: Lanes>(&self, lanes: L, keys: F8<L>) -> u32 {
        keys.less(F8::splat(lanes, self.cut)).mask()
    }

    /// Tests the triangles' boxes along the axes of the other node, and their planes.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: &Facing,
        active: u32,
        triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64 {
        let triangles = triangles();
        let ([_, drift], sign) = self.drifts(facing);
        let (node, boxes) = (facing.nodes[1], facing.children(lanes, 1));
        let ends = drift.ends(lanes, &boxes, Some(drift.extra), sign);
        let (planes, mut pairs) = (Planes::new(lanes, &triangles), 0);
        for i in bits(active).map(|i| i % WIDTH) {
            let plane = planes.at(i);
            let box_of = drift.ends_of_triangle(lanes, &plane, sign);
            let of_axes = self.compare(lanes, &ends, &box_of);
            let key = self.key(lanes, of_axes, of_axes, of_axes[0]);
            if self.hits(lanes, key) & node.valid() == 0 {
                continue;
            }
            let of_plane = drift.through_plane(lanes, &plane, &boxes, sign);
            let key = self.key(lanes, of_axes, of_plane, of_axes[0]);
            keys[i] = key.store();
            pairs |= u64::from(self.hits(lanes, key) & node.valid()) << (WIDTH * i);
        }
        pairs
    }
}
