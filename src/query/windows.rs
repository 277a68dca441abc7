//! When boxes meet on the way: lower bounds of times, eight at a time.
//!
//! A box of B that goes along a straight line overlaps one of A, on an axis, from one time to another; on six axes, from the
//! latest such beginning to the earliest end. All is in A's units, with the views and margins of the overlap test, and with
//! the length of the piece of motion as unit of time, from -1/2 to 1/2; the proof is in `docs/numerics.md`, "Motion".

use super::boxes::{BoxTest, Boxes, Facing, Keys, Triangles, splat};
use super::course::{Course, Piece};
use super::views::{Relation, Views, cross};
use crate::math::lanes::{F8, Kernel, Lanes, V8, add, per_axis, sub};
use crate::math::tolerance::ROUNDING;
use crate::tree::{Node, WIDTH, xyz};
use crate::triangle::swept::Glide;
use glam::DVec3;
use wide::f32x4;

/// When the piece begins.
pub(super) const BEGIN: f32 = -0.5;

/// Times are rounded by no more than this.
const SLOP: f32 = 8.0 * ROUNDING;

/// A piece of motion as `f32` sees it, in A's unit coordinates.
pub(super) fn glide(course: &Course, piece: &Piece, relation: &Relation, origin: DVec3, margin: f64) -> Glide {
    let (length, unit) = (piece.length(), relation.unit);
    let (shift, turn) = (piece.twist.at(origin) * (length / unit), piece.twist.turn * length);
    let bulge = (course.bend(length / 2.0) + course.rounding + margin) / unit;
    if shift.abs().max_element().max(bulge) < 1e6 {
        Glide {
            shift: shift.as_vec3().to_array(),
            turn: turn.as_vec3().to_array(),
            spin: (course.spin * length * 0.5) as f32 * 1.001,
            bulge: bulge as f32 * 1.001 + 1e-20,
        }
    } else {
        // Beyond `f32`: everything may meet at any time.
        Glide { shift: [0.0; 3], turn: [0.0; 3], spin: 0.0, bulge: 1e15 }
    }
}

/// Whether boxes meet before `cut`. Keys are lower bounds of the times when they do.
pub(super) struct Windows {
    /// From this time on pairs are of no interest.
    pub cut: f32,
    /// The key of the pair at hand; its children's are no less.
    pub least: f32,
    skew: f32,
    shift: f32x4,
    turn: f32x4,
    spin: f32,
    bulge: f32,
    /// In the orientations of the nodes at hand.
    in_a: Drift,
    in_b: Drift,
}

/// How B passes, along the axes of a node.
#[derive(Clone, Copy)]
struct Drift {
    /// Minus one over the velocity.
    inverse: [f32; 3],
    margin: f32,
}

impl Drift {
    const NONE: Self = Self { inverse: [0.0; 3], margin: 0.0 };

    fn new(velocity: f32x4, margin: f32) -> Self {
        let velocity = xyz(velocity);
        let length = velocity[0].abs() + velocity[1].abs() + velocity[2].abs();
        // What is slower than this counts as this fast.
        let least = length * 1e-6 + 1e-20;
        let inverse = velocity.map(|v| if v < 0.0 { 1.0 / (-v).max(least) } else { -1.0 / v.max(least) });
        Self { inverse, margin: margin + least }
    }

    /// When boxes with centres that are `apart` and sums of half extents `reach` overlap.
    #[inline(always)]
    fn window<L: Lanes>(&self, lanes: L, apart: V8<L>, reach: V8<L>, sign: f32) -> [F8<L>; 2] {
        let margin = F8::splat(lanes, self.margin);
        let ends = per_axis!(k => {
            let inverse = F8::splat(lanes, self.inverse[k] * sign);
            let (middle, half) = (apart[k] * inverse, (reach[k] + margin) * inverse.abs());
            [middle - half, middle + half]
        });
        let enter = ends[0][0].max(ends[1][0]).max(ends[2][0]);
        let leave = ends[0][1].min(ends[1][1]).min(ends[2][1]);
        [enter, leave]
    }

    /// The same for a single pair.
    #[inline(always)]
    fn window_one(&self, apart: f32x4, reach: f32x4) -> [f32; 2] {
        let [x, y, z] = self.inverse;
        let inverse = f32x4::new([x, y, z, 0.0]);
        let (middle, half) = (apart * inverse, (reach + f32x4::splat(self.margin)) * inverse.abs());
        let ([a, b, c], [d, e, f]) = (xyz(middle - half), xyz(middle + half));
        [a.max(b).max(c), d.min(e).min(f)]
    }
}

impl Windows {
    pub fn new(cut: f32, glide: &Glide, relation: &Relation) -> Self {
        let [shift, turn] = [glide.shift, glide.turn].map(|[x, y, z]| f32x4::new([x, y, z, 0.0]));
        let (least, skew) = (f32::NEG_INFINITY, relation.skew);
        let (spin, bulge) = (glide.spin, glide.bulge);
        Self { cut, least, skew, shift, turn, spin, bulge, in_a: Drift::NONE, in_b: Drift::NONE }
    }

    /// The time from which on boxes may meet, infinite if they do not.
    #[inline(always)]
    fn key<L: Lanes>(&self, lanes: L, [enter, leave]: [F8<L>; 2]) -> F8<L> {
        let (enter, leave) = (enter - F8::splat(lanes, SLOP), leave + F8::splat(lanes, SLOP));
        let gone = leave.less(enter.max(F8::splat(lanes, BEGIN)));
        gone.select(F8::splat(lanes, f32::INFINITY), enter.max(F8::splat(lanes, self.least)))
    }

    /// The same after comparisons along the axes of both.
    #[inline(always)]
    fn key_of_both<L: Lanes>(&self, lanes: L, [of_x, of_y]: [[F8<L>; 2]; 2]) -> F8<L> {
        self.key(lanes, [of_x[0].max(of_y[0]), of_x[1].min(of_y[1])])
    }

    #[inline(always)]
    fn soon<L: Lanes>(&self, lanes: L, keys: F8<L>) -> u32 {
        keys.less(F8::splat(lanes, self.cut)).mask()
    }

    /// What B does in the orientation of the opened node, and in that of the other; the sign that makes it so for the latter's
    /// boxes against the former's.
    #[inline(always)]
    fn drifts(&self, is_a: bool) -> (&Drift, &Drift, f32) {
        if is_a { (&self.in_a, &self.in_b, 1.0) } else { (&self.in_b, &self.in_a, -1.0) }
    }
}

/// The length of a vector that is not negative, or more: `sqrt(m^2 + r) <= m + r / 2 m`.
fn longer(v: f32x4) -> f32 {
    let [x, y, z] = xyz(v);
    let largest = x.max(y).max(z);
    let rest = x * x + y * y + z * z - largest * largest;
    (largest + rest / (2.0 * largest + 1e-30)) * 1.000_001
}

fn sum(a: f32x4) -> f32 {
    let [x, y, z] = xyz(a.abs());
    x + y + z
}

impl BoxTest for Windows {
    const IS_OVERLAP: bool = false;

    #[inline(always)]
    fn own(&mut self, a: &Node, b: &Node, views: &Views, scale: f32) -> bool {
        let scale = f32x4::splat(scale);
        let (a_center, a_half) = (a.own_center, a.own_half);
        let (b_center, b_half) = (b.own_center * scale, b.own_half * scale);
        let seen = views.of_b.point(b_center);
        let (shift, _) = views.direction(a, self.shift);
        let (turn, _) = views.direction(a, self.turn);
        let velocity = shift + cross(turn, seen);
        let radius = longer(b_half);
        let speed = sum(shift) + sum(turn) * sum(seen);
        let margin = self.spin * radius + self.bulge + (self.skew + 32.0 * ROUNDING) * speed;
        self.in_a = Drift::new(velocity, margin + views.of_b.margin.as_array()[0]);
        self.in_b = Drift::new(views.of_a.vector(velocity), margin + views.of_a.margin.as_array()[0]);
        let of_a = self.in_a.window_one(seen - a_center, views.of_b.half(b_half) + a_half);
        let of_b = self.in_b.window_one(b_center - views.of_a.point(a_center), views.of_a.half(a_half) + b_half);
        let (enter, leave) = (of_a[0].max(of_b[0]) - SLOP, of_a[1].min(of_b[1]) + SLOP);
        if leave < enter.max(BEGIN) {
            return false;
        }
        self.least = self.least.max(enter);
        self.least < self.cut
    }

    #[inline(always)]
    fn both<L: Lanes>(&self, lanes: L, facing: Facing, alive: [u32; 2], keys: &mut Keys) -> u64 {
        lanes.run(Both { windows: self, facing, alive, keys })
    }

    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: Facing, keys: &mut Keys) -> u32 {
        let Facing { nodes: [opened, _], views: [of_opened, of_other], scales, is_a } = facing;
        let (in_opened, in_other, sign) = self.drifts(is_a);
        let children = Boxes::children(lanes, opened, scales[0]);
        let (center, half) = facing.other();
        let apart = sub(splat(lanes, of_other.point(center)), children.center);
        let of_opened_axes =
            in_opened.window(lanes, apart, add(children.half, splat(lanes, of_other.half(half))), sign);
        let seen = children.seen(lanes, of_opened);
        let apart = sub(splat(lanes, center), seen.center);
        let of_other_axes = in_other.window(lanes, apart, add(seen.half, splat(lanes, half)), sign);
        let key = self.key_of_both(lanes, [of_opened_axes, of_other_axes]);
        keys[0] = key.store();
        self.soon(lanes, key) & opened.valid()
    }

    /// By their boxes.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: u32,
        _triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64 {
        self.both(lanes, facing, [alive, facing.nodes[1].valid()], keys)
    }
}

/// The given children of two nodes. Compiled once, as it is large and asked for in several places.
struct Both<'k> {
    windows: &'k Windows,
    facing: Facing<'k>,
    alive: [u32; 2],
    keys: &'k mut Keys,
}

impl Kernel for Both<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> u64 {
        let Self { windows, facing, alive: [alive_x, alive_y], keys } = self;
        let Facing { nodes: [x, y], views: [of_x, of_y], scales, is_a } = facing;
        let (in_x, in_y, sign) = windows.drifts(is_a);
        let y_rows = Boxes::children(lanes, y, scales[1]);
        let y_in_x = y_rows.seen(lanes, of_y);
        let scale = f32x4::splat(scales[0]);
        let (center, half) = (splat(lanes, x.own_center * scale), splat(lanes, x.own_half * scale));
        let window = in_x.window(lanes, sub(y_in_x.center, center), add(y_in_x.half, half), sign);
        let alive_y = alive_y & windows.soon(lanes, windows.key(lanes, window));
        if alive_y == 0 {
            return 0;
        }
        let x_rows = Boxes::children(lanes, x, scales[0]);
        let x_in_y = x_rows.seen(lanes, of_x);
        let (center, half) = facing.other();
        let (center, half) = (splat(lanes, center), splat(lanes, half));
        let window = in_y.window(lanes, sub(center, x_in_y.center), add(x_in_y.half, half), sign);
        let mut alive_x = alive_x & windows.soon(lanes, windows.key(lanes, window));
        let (x_rows, x_in_y) = (x_rows.store(), x_in_y.store());
        let mut pairs = 0;
        while alive_x != 0 {
            let i = alive_x.trailing_zeros() as usize;
            alive_x &= alive_x - 1;
            let [center, half] = x_rows.at(lanes, i);
            let of_x_axes = in_x.window(lanes, sub(y_in_x.center, center), add(y_in_x.half, half), sign);
            let [center, half] = x_in_y.at(lanes, i);
            let of_y_axes = in_y.window(lanes, sub(y_rows.center, center), add(y_rows.half, half), sign);
            let key = windows.key_of_both(lanes, [of_x_axes, of_y_axes]);
            keys[i] = key.store();
            pairs |= u64::from(windows.soon(lanes, key) & alive_y) << (WIDTH * i);
        }
        pairs
    }
}

/// Eight boxes by centres and half extents, to be read one at a time.
struct Stored([[[f32; 8]; 3]; 2]);

impl Stored {
    #[inline(always)]
    fn at<L: Lanes>(&self, lanes: L, i: usize) -> [V8<L>; 2] {
        let [center, half] = &self.0;
        [per_axis!(k => F8::splat(lanes, center[k][i])), per_axis!(k => F8::splat(lanes, half[k][i]))]
    }
}

impl<L: Lanes> Boxes<L> {
    #[inline(always)]
    fn store(&self) -> Stored {
        Stored([per_axis!(k => self.center[k].store()), per_axis!(k => self.half[k].store())])
    }
}
