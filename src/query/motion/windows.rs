//! Times at which moving boxes meet: lower bounds, eight at a time.
//!
//! A box of B that moves along a straight line overlaps a box of A, on an axis, during one time
//! interval; on six axes, from the latest start to the earliest end. Triangles and boxes are also
//! compared along the triangles' normals. All is in A's units, with the views and margins of the
//! overlap test. The unit of time is the length of the piece, from -1/2 to 1/2. The proof is in
//! `docs/numerics.md`, "Motion".

use super::course::{Course, Piece};
use crate::query::boxes::{
    BoxTest, Boxes, Facing, Keys, Plane, Planes, Slabs, Stored, Triangles, splat,
};
use crate::query::edge_axes;
use crate::query::views::{Relation, View, Views, cross, yzx, zxy};
use crate::tree::{Node, WIDTH, xyz};
use glam::DVec3;
use punctual_geom::bits;
use punctual_geom::lanes::{Column, F8, Kernel, Lanes, add, dot, per_axis, sub};
use punctual_geom::tolerance::ROUNDING;
use punctual_geom::triangle::swept::Glide;
use wide::f32x4;

/// The begin of the piece.
pub(super) const BEGIN: f32 = -0.5;

/// Bound on the rounding of times.
pub(super) const SLOP: f32 = 8.0 * ROUNDING;

/// Half a unit of time, plus 1 percent for matrices that are not exactly rotations.
const HALF_A_PIECE: f32 = 0.505;

/// Least speed of a projection. The allowance for underflow covers the difference.
const LEAST_SPEED: f32 = 1e-37;

/// A piece of motion in `f32`, in A's unit coordinates.
pub(super) fn glide(
    course: &Course,
    piece: &Piece,
    relation: &Relation,
    origin: DVec3,
    margin: f64,
) -> Glide {
    let (length, unit) = (piece.length(), relation.unit);
    let twist = course.twist(piece.middle);
    let velocity = twist.at(origin) * (length / unit);
    let pull = twist.acceleration(origin) * (length * length / unit);
    let (turn, change) = (twist.turn * length, twist.change * (length * length));
    let bulge = (course.bend_besides(length / 2.0) + course.rounding + margin) / unit;
    let vector = |v: DVec3| v.as_vec3().extend(0.0).to_array();
    if bulge < 1e6 && velocity.abs().max(pull.abs()).max_element() < 1e6 {
        Glide {
            shift: vector(velocity),
            turn: vector(turn),
            pull: vector(pull),
            change: vector(change),
            wobble: (course.wobble * length * length * 0.5) as f32 * 1.01,
            spin: (course.spin * length * 0.5) as f32 * 1.001,
            bulge: bulge as f32 * 1.001 + 1e-20,
            swings: piece.is_on_the_spot,
        }
    } else {
        // Beyond the range of `f32`, or NaN: everything may meet at any time.
        Glide {
            bulge: 1e15,
            ..Glide::NONE
        }
    }
}

/// Selects boxes that meet before `cut`. Keys are lower bounds of the times at which they meet.
pub(super) struct Windows<'g> {
    /// Pairs with this time or a later one are of no interest.
    cut: f32,
    /// The key of the current pair; its children's keys are not less.
    pub least: f32,
    skew: f32,
    glide: &'g Glide,
    /// The drift of B in the orientations of the current nodes.
    in_a: Drift,
    in_b: Drift,
}

/// The motion of B along the axes of a node. Positions divided by the velocity are times: with the
/// ends of boxes scaled to times, two boxes meet from the difference of two ends to the difference
/// of the two others.
#[derive(Clone, Copy)]
struct Drift {
    /// Minus one over the velocity, and one over the speed.
    inverse: f32x4,
    size: f32x4,
    /// The margins as times.
    extra: f32x4,
    velocity: f32x4,
    /// The position error of B plus the margin of the overlap test.
    pub margin: f32x4,
}

impl Drift {
    const NONE: Self = Self {
        inverse: f32x4::ZERO,
        size: f32x4::ZERO,
        extra: f32x4::ZERO,
        velocity: f32x4::ZERO,
        margin: f32x4::ZERO,
    };

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
            extra: size * margin + f32x4::splat(SLOP),
            velocity,
            margin,
        }
    }

    /// The ends of boxes as times. `sign` is -1 if the boxes are of B, which meet boxes of A.
    #[inline(always)]
    fn ends<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>, sign: f32) -> Slabs<L> {
        let (inverse, size) = (self.inverse * f32x4::splat(sign), self.size);
        let Boxes { center, half } = boxes;
        Boxes {
            center: per_axis!(k => center[k] * F8::splat(lanes, inverse.as_array()[k])),
            half: per_axis!(k => half[k] * F8::splat(lanes, size.as_array()[k])),
        }
        .slabs()
    }

    /// The ends of boxes as times, widened by the margins.
    #[inline(always)]
    fn wide_ends<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>, sign: f32) -> Slabs<L> {
        let Slabs { low, high } = self.ends(lanes, boxes, sign);
        let extra = splat(lanes, self.extra);
        Slabs {
            low: sub(low, extra),
            high: add(high, extra),
        }
    }

    /// The ends of a single box as times, eight times.
    #[inline(always)]
    fn ends_of_one<L: Lanes>(
        &self,
        lanes: L,
        (center, half): (f32x4, f32x4),
        extra: f32x4,
        sign: f32,
    ) -> Slabs<L> {
        let (center, half) = (
            center * self.inverse * f32x4::splat(sign),
            half * self.size + extra,
        );
        Slabs {
            low: splat(lanes, center - half),
            high: splat(lanes, center + half),
        }
    }

    /// The ends of a triangle's box as times, eight times.
    #[inline(always)]
    fn ends_of_triangle<L: Lanes>(&self, lanes: L, plane: &Plane, sign: f32) -> Slabs<L> {
        let inverse = self.inverse * f32x4::splat(sign);
        let [u, v] = [plane.low, plane.high].map(|[x, y, z]| f32x4::new([x, y, z, 0.0]) * inverse);
        Slabs {
            low: splat(lanes, u.fast_min(v)),
            high: splat(lanes, u.fast_max(v)),
        }
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
        let margin =
            x.abs() * p + y.abs() * q + z.abs() * r + plane.blur * (2.0 * (p + q + r) + speed);
        let slack = plane.slack + margin + least;
        let from_corner = per_axis!(k => boxes.center[k] - F8::splat(lanes, plane.corner[k]));
        let distance = dot(
            per_axis!(k => F8::splat(lanes, plane.normal[k])),
            from_corner,
        );
        let reach = dot(per_axis!(k => F8::splat(lanes, plane.reach[k])), boxes.half)
            + (from_corner[0].abs() + from_corner[1].abs() + from_corner[2].abs())
                * F8::splat(lanes, plane.blur)
            + F8::splat(lanes, slack);
        let middle = distance * F8::splat(lanes, inverse);
        let half = reach * F8::splat(lanes, size) + F8::splat(lanes, SLOP);
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

/// Time interval in which two boxes overlap. Their ends on each axis are given as times:
/// coordinates divided by the relative speed on that axis.
#[inline(always)]
fn between<L: Lanes>(other: &Slabs<L>, opened: &Slabs<L>) -> [F8<L>; 2] {
    let [x, y, z] = per_axis!(k => other.low[k] - opened.high[k]);
    let [u, v, w] = per_axis!(k => other.high[k] - opened.low[k]);
    [x.max(y).max(z), u.min(v).min(w)]
}

/// The motion of a part of B, as seen from one node.
struct Way {
    velocity: f32x4,
    turn: f32x4,
    /// The bend of its path until the piece ends.
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
    pub fn new(cut: f32, least: f32, glide: &'g Glide, relation: &Relation) -> Self {
        Self {
            cut,
            least,
            skew: relation.skew,
            glide,
            in_a: Drift::NONE,
            in_b: Drift::NONE,
        }
    }

    /// The motion of a part of B at `place`, as seen from A's node.
    #[inline(always)]
    fn way(&self, a: &Node, views: &Views, place: f32x4) -> Way {
        let Glide {
            spin,
            wobble,
            bulge,
            ..
        } = *self.glide;
        let seen = |v: [f32; 4]| views.direction(a, f32x4::new(v)).0;
        let shift = seen(self.glide.shift);
        let mut way = Way {
            velocity: shift,
            turn: f32x4::ZERO,
            bend: f32x4::ZERO,
            margin: bulge,
        };
        let mut speed = sum(shift);
        if spin > 0.0 {
            way.turn = seen(self.glide.turn);
            let turned = cross(way.turn, place);
            way.velocity += turned;
            let pull = seen(self.glide.pull);
            let mut acceleration = pull + cross(way.turn, turned);
            if wobble > 0.0 {
                acceleration += cross(seen(self.glide.change), place);
            }
            // In half a unit of time, half of its square is an eighth; plus 1 percent.
            way.bend = acceleration * f32x4::splat(0.12625);
            speed += sum(way.turn) * sum(place) + sum(pull);
        }
        way.margin += (self.skew + 32.0 * ROUNDING) * speed;
        way
    }

    /// The drift of a box with these half extents, if directions are off by `skew`.
    #[inline(always)]
    fn drift(&self, way: &Way, half: f32x4, margin: f32x4, skew: f32) -> Drift {
        let mut margin = margin + f32x4::splat(way.margin);
        if self.glide.spin > 0.0 {
            let off = self.off(way.turn, self.glide.wobble + skew * sum(way.turn), half);
            margin += off + way.bend.abs() + f32x4::splat(skew * sum(way.bend));
        }
        Drift::new(way.velocity, margin)
    }

    /// Bound on the distance of points within the half extents from the lines that they would
    /// follow with the velocity of their middle.
    #[inline(always)]
    fn off(&self, turn: f32x4, wobble: f32, half: f32x4) -> f32x4 {
        let turn = turn.abs() + f32x4::splat(wobble);
        let way = yzx(turn) * zxy(half) + zxy(turn) * yzx(half);
        way * f32x4::splat(HALF_A_PIECE) + f32x4::splat(sum(way) * self.glide.spin * 0.25)
    }

    /// The time from which on boxes may meet; infinite if they do not.
    #[inline(always)]
    fn key<L: Lanes>(&self, lanes: L, [enter, leave]: [F8<L>; 2]) -> F8<L> {
        let gone = leave.less(enter.max(F8::splat(lanes, BEGIN)));
        gone.select(
            F8::splat(lanes, f32::INFINITY),
            enter.max(F8::splat(lanes, self.least)),
        )
    }

    /// [`Windows::key`] from the comparisons along the axes of both nodes.
    #[inline(always)]
    fn key_of_both<L: Lanes>(&self, lanes: L, [of_x, of_y]: [[F8<L>; 2]; 2]) -> F8<L> {
        self.key(lanes, [of_x[0].max(of_y[0]), of_x[1].min(of_y[1])])
    }

    #[inline(always)]
    fn soon<L: Lanes>(&self, lanes: L, keys: F8<L>) -> u32 {
        keys.less(F8::splat(lanes, self.cut)).mask()
    }

    /// The drift in the orientation of the opened node, the drift in that of the other, and the
    /// sign for boxes of the latter against those of the former.
    #[inline(always)]
    fn drifts(&self, is_a: bool) -> (&Drift, &Drift, f32) {
        if is_a {
            (&self.in_a, &self.in_b, 1.0)
        } else {
            (&self.in_b, &self.in_a, -1.0)
        }
    }
}

pub(super) fn sum(a: f32x4) -> f32 {
    let [x, y, z] = xyz(a.abs());
    x + y + z
}

impl BoxTest for Windows<'_> {
    const IS_OVERLAP: bool = false;

    #[inline(always)]
    fn own<L: Lanes>(&mut self, _lanes: L, a: &Node, b: &Node, views: &Views, scale: f32) -> bool {
        let scale = f32x4::splat(scale);
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
        // Directions are off by the skew of their sum, which may appear shorter by up to the root
        // of 3.
        self.in_b = self.drift(
            &way.seen(&views.of_a),
            b_half,
            views.of_a.margin,
            2.0 * self.skew,
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
                self.skew,
                (self.in_a.velocity, self.in_a.margin),
            );
            (enter, leave) = (enter.max(of_edges[0] - SLOP), leave.min(of_edges[1] + SLOP));
            if leave < enter.max(BEGIN) {
                return false;
            }
        }
        self.least = self.least.max(enter);
        self.least < self.cut
    }

    #[inline(always)]
    fn both<L: Lanes>(&self, lanes: L, facing: Facing, alive: [u32; 2], keys: &mut Keys) -> u64 {
        lanes.run(Both {
            windows: self,
            facing,
            alive,
            keys,
        })
    }

    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: Facing, keys: &mut Keys) -> u32 {
        let Facing {
            nodes: [opened, _],
            views: [of_opened, of_other],
            scales,
            is_a,
        } = facing;
        let (in_opened, in_other, sign) = self.drifts(is_a);
        let children = Boxes::children(lanes, opened, scales[0]);
        let (center, half) = facing.other();
        let other = (of_other.point(center), of_other.half(half));
        let other = in_opened.ends_of_one(lanes, other, in_opened.extra, sign);
        let of_opened_axes = between(&other, &in_opened.ends(lanes, &children, sign));
        let other = in_other.ends_of_one(lanes, (center, half), in_other.extra, sign);
        let of_other_axes = between(
            &other,
            &in_other.ends(lanes, &children.seen(lanes, of_opened), sign),
        );
        let key = self.key_of_both(lanes, [of_opened_axes, of_other_axes]);
        keys[0] = key.store();
        self.soon(lanes, key) & opened.valid()
    }

    /// Tests the triangles' boxes along the axes of the other node, and their planes.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: u32,
        triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64 {
        let triangles = triangles();
        let (_, drift, sign) = self.drifts(facing.is_a);
        let node = facing.nodes[1];
        let boxes = Boxes::children(lanes, node, facing.scales[1]);
        let ends = drift.wide_ends(lanes, &boxes, sign);
        let planes = if alive.is_power_of_two() {
            None
        } else {
            Some(Planes::new(lanes, &triangles))
        };
        let mut pairs = 0;
        for i in bits(alive).map(|i| i % WIDTH) {
            let plane = match &planes {
                Some(planes) => planes.at(i),
                None => Plane::new(triangles.rows[i], &triangles.view, triangles.skew),
            };
            let of_axes = between(&ends, &drift.ends_of_triangle(lanes, &plane, sign));
            if self.soon(lanes, self.key(lanes, of_axes)) & node.valid() == 0 {
                continue;
            }
            let key = self.key_of_both(
                lanes,
                [of_axes, drift.through_plane(lanes, &plane, &boxes, sign)],
            );
            keys[i] = key.store();
            pairs |= u64::from(self.soon(lanes, key) & node.valid()) << (WIDTH * i);
        }
        pairs
    }
}

/// The active children of two nodes. Compiled once, because it is large and called from several
/// places.
struct Both<'k> {
    windows: &'k Windows<'k>,
    facing: Facing<'k>,
    alive: [u32; 2],
    keys: &'k mut Keys,
}

impl Kernel for Both<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> u64 {
        let Self {
            windows,
            facing,
            alive: [alive_x, alive_y],
            keys,
        } = self;
        let Facing {
            nodes: [x, y],
            views: [of_x, of_y],
            scales,
            is_a,
        } = facing;
        let (in_x, in_y, sign) = windows.drifts(is_a);
        let y_rows = Boxes::children(lanes, y, scales[1]);
        let y_in_x = in_x.wide_ends(lanes, &y_rows.seen(lanes, of_y), sign);
        let scale = f32x4::splat(scales[0]);
        let own = in_x.ends_of_one(
            lanes,
            (x.own_center * scale, x.own_half * scale),
            f32x4::ZERO,
            sign,
        );
        let alive_y = alive_y & windows.soon(lanes, windows.key(lanes, between(&y_in_x, &own)));
        if alive_y == 0 {
            return 0;
        }
        let x_rows = Boxes::children(lanes, x, scales[0]);
        let x_in_y = in_y.ends(lanes, &x_rows.seen(lanes, of_x), sign);
        let own = in_y.ends_of_one(lanes, facing.other(), in_y.extra, sign);
        let alive_x = alive_x & windows.soon(lanes, windows.key(lanes, between(&own, &x_in_y)));
        let (x_in_x, x_in_y) = (in_x.ends(lanes, &x_rows, sign).store(), x_in_y.store());
        let y_in_y = in_y.wide_ends(lanes, &y_rows, sign);
        let mut pairs = 0;
        for i in bits(alive_x) {
            let of_x_axes = between(&y_in_x, &x_in_x.at(lanes, i));
            let of_y_axes = between(&y_in_y, &x_in_y.at(lanes, i));
            let key = windows.key_of_both(lanes, [of_x_axes, of_y_axes]);
            keys[i] = key.store();
            pairs |= u64::from(windows.soon(lanes, key) & alive_y) << (WIDTH * i);
        }
        pairs
    }
}

impl Stored {
    /// Box `i`, eight times.
    #[inline(always)]
    fn at<L: Lanes>(&self, lanes: L, i: usize) -> Slabs<L> {
        Slabs {
            low: per_axis!(k => F8::splat(lanes, self.low[k][i])),
            high: per_axis!(k => F8::splat(lanes, self.high[k][i])),
        }
    }
}
