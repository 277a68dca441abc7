//! When do two triangles meet on the way? Times before which they certainly do not.
//!
//! The corners of B go along straight lines. On any direction the projections of the two triangles overlap from one time to
//! another; on several, from the latest beginning to the earliest end. With the normals of both and the nine products of their
//! edges this is when they meet, unless they are coplanar or degenerate. What B may leave its lines by is added to the
//! projections, as is all rounding, so no direction makes the answer false: `docs/numerics.md`, "Motion".
//!
//! - [`windows`]: eight pairs at a time in `f32`, or one pair at eight times.
//! - [`Swept`]: one pair in `f64`.

use super::batch::{Placement, Rows, Transposed, UNDERFLOW};
use super::distance::Pair;
use crate::math::lanes::{Column, F8, Lanes, V8, add, cross, dot, per_axis, sub};
use crate::math::tolerance::ROUNDING;
use crate::math::{larger, largest, smaller};
use core::array;
use glam::DVec3;

/// How B goes through a piece of time, from -1/2 to 1/2 with the place that it is given in the middle: lengths in A's units. A
/// point at `y` has the velocity `shift + turn x y` there. The fourth component of vectors is 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glide {
    pub shift: [f32; 4],
    pub turn: [f32; 4],
    /// It has the acceleration `pull + change x y + turn x (turn x y)`.
    pub pull: [f32; 4],
    pub change: [f32; 4],
    /// By how much a component of `turn` may differ at other times of the piece; 0 if `change` is.
    pub wobble: f32,
    /// Of how many radians B turns in half of the piece, at most.
    pub spin: f32,
    /// What B may be off besides.
    pub bulge: f32,
}

impl Glide {
    /// B stands still.
    pub const NONE: Self =
        Self { shift: [0.0; 4], turn: [0.0; 4], pull: [0.0; 4], change: [0.0; 4], wobble: 0.0, spin: 0.0, bulge: 0.0 };
}

/// When `a[i]` and `b[i]` may meet first, for the eight lanes, and those that may before `cut`, a bit each. If they are `spread`,
/// all lanes hold one pair, and each is for an eighth of the time.
#[inline(always)]
pub(crate) fn windows<L: Lanes>(
    lanes: L,
    a: [&Rows; 8],
    b: [&Rows; 8],
    placement: &Placement,
    glide: &Glide,
    cut: f32,
    spread: bool,
) -> ([f32; 8], u32) {
    let first = Transposed::new(lanes, a).first;
    let mut pair = Gliding::new(lanes, Pair::new(lanes, a, b, placement), first, glide);
    if spread {
        pair.spread(lanes);
    }
    let (p, f) = (pair.of.p, pair.of.f);
    let all = [F8::splat(lanes, -0.5), F8::splat(lanes, 0.5)];
    let mut window = pair.on(lanes, cross(f[0], f[1]), pair.on(lanes, cross(p[0], p[1]), all));
    let (p, f) = ([p[0], p[1], sub(p[1], p[0])], [f[0], f[1], sub(f[1], f[0])]);
    let mut i = 0;
    while i < 3 {
        if pair.alive(lanes, window, cut).1 == 0 {
            return ([f32::INFINITY; 8], 0);
        }
        let mut j = 0;
        while j < 3 {
            window = pair.on(lanes, cross(p[i], f[j]), window);
            j += 1;
        }
        i += 1;
    }
    let (enter, alive) = pair.alive(lanes, window, cut);
    (enter.store(), alive)
}

/// Eight pairs, of which those of B move.
struct Gliding<L: Lanes> {
    of: Pair<L>,
    /// The way of each corner of B in half of the time, and what its line bends by then.
    ways: [V8<L>; 3],
    bend: V8<L>,
    /// A quarter of the acceleration in the whole of the time.
    acceleration: V8<L>,
    /// The time that it is about, in pieces: its middle and its length.
    middle: F8<L>,
    length: F8<L>,
}

impl<L: Lanes> Gliding<L> {
    #[inline(always)]
    fn new(lanes: L, mut of: Pair<L>, first: V8<L>, glide: &Glide) -> Self {
        let half = F8::splat(lanes, 0.5);
        let mut way = per_axis!(k => F8::splat(lanes, 0.5 * glide.shift[k]));
        let mut error = F8::splat(lanes, glide.bulge);
        let zero = F8::splat(lanes, 0.0);
        let (mut ways, mut acceleration) = ([way; 3], [zero; 3]);
        if glide.spin > 0.0 {
            let at = per_axis!(k => of.q[k] + first[k]);
            let turn = per_axis!(k => F8::splat(lanes, glide.turn[k]) * half);
            let turned = cross(turn, at);
            acceleration = add(per_axis!(k => F8::splat(lanes, 0.25 * glide.pull[k])), cross(turn, turned));
            if glide.wobble > 0.0 {
                let change = per_axis!(k => F8::splat(lanes, 0.25 * glide.change[k]));
                acceleration = add(acceleration, cross(change, at));
            }
            let size = per_axis!(k => of.f[0][k].abs().max(of.f[1][k].abs()));
            way = add(way, turned);
            ways = [way, add(way, cross(turn, of.f[0])), add(way, cross(turn, of.f[1]))];
            error = error
                + sum(turn) * sum(size) * F8::splat(lanes, 0.5 * glide.spin)
                + sum(size) * F8::splat(lanes, 0.25 * glide.wobble)
                + sum(turn) * sum(at) * F8::splat(lanes, 64.0 * ROUNDING);
        }
        of.error = per_axis!(k => {
            of.error[k] + error + F8::splat(lanes, (glide.shift[k].abs() + glide.pull[k].abs()) * (4.0 * ROUNDING))
        });
        let bend = per_axis!(k => acceleration[k] * F8::splat(lanes, 0.505));
        Self { of, ways, bend, acceleration, middle: zero, length: F8::splat(lanes, 1.0) }
    }

    /// Each lane for an eighth of the time.
    #[inline(always)]
    fn spread(&mut self, lanes: L) {
        let middle = F8::load(lanes, &[-0.4375, -0.3125, -0.1875, -0.0625, 0.0625, 0.1875, 0.3125, 0.4375]);
        let (twice, eighth) = (middle + middle, F8::splat(lanes, 0.125));
        let change = per_axis!(k => self.acceleration[k] * middle);
        let way = per_axis!(k => (self.ways[0][k] + change[k]) * twice);
        let rounding = per_axis!(k => {
            let edges = self.of.f[0][k].abs().max(self.of.f[1][k].abs());
            (self.of.q[k].abs() + edges + self.ways[0][k].abs() + change[k].abs()) * F8::splat(lanes, 8.0 * ROUNDING)
        });
        self.of.error = add(self.of.error, rounding);
        self.of.q = add(self.of.q, way);
        let turned = [sub(self.ways[1], self.ways[0]), sub(self.ways[2], self.ways[0])];
        for (edge, turned) in self.of.f.iter_mut().zip(turned) {
            *edge = add(*edge, per_axis!(k => turned[k] * twice));
        }
        let quarter = F8::splat(lanes, 0.25);
        self.ways = per_axis!(j => per_axis!(k => self.ways[j][k] * eighth + change[k] * quarter));
        self.bend = per_axis!(k => self.bend[k] * (eighth * eighth));
        (self.middle, self.length) = (middle, eighth);
    }

    /// When windows begin, rounded down, and those that are not empty and begin before `cut`.
    #[inline(always)]
    fn alive(&self, lanes: L, [enter, leave]: [F8<L>; 2], cut: f32) -> (F8<L>, u32) {
        let slop = F8::splat(lanes, 8.0 * ROUNDING);
        let from = self.middle + enter * self.length - slop;
        // Where one of them is no number nothing is known.
        let gone = (leave + slop).less(enter - slop).or(F8::splat(lanes, cut).less(from));
        (from, !gone.mask() & 0xff)
    }

    /// What is left of a window on the direction `n`, whatever its length.
    #[inline(always)]
    fn on(&self, lanes: L, n: V8<L>, [enter, leave]: [F8<L>; 2]) -> [F8<L>; 2] {
        let (zero, half) = (F8::splat(lanes, 0.0), F8::splat(lanes, 0.5));
        let Pair { p, q, f, error } = self.of;
        let (a1, a2) = (dot(p[0], n), dot(p[1], n));
        let (b0, f1, f2) = (dot(q, n), dot(f[0], n), dot(f[1], n));
        let (a_low, a_high) = (zero.min(a1).min(a2), zero.max(a1).max(a2));
        let sums = (a_high - a_low) + f1.abs() + f2.abs() + b0.abs();
        let error = dot(per_axis!(k => n[k].abs()), error)
            + sums * F8::splat(lanes, 4.0 * ROUNDING)
            + F8::splat(lanes, UNDERFLOW);
        let bend = dot(self.bend, n);
        let (low, high) = (a_low - error - bend.max(zero), a_high + error - bend.min(zero));
        let ([x, y, z], [b1, b2]) = (per_axis!(j => dot(self.ways[j], n)), [b0 + f1, b0 + f2]);
        // How far B is above A, and below, when the piece begins and when it ends: in between it is no less than in proportion.
        let [above, below] = gaps([b0 - x, b1 - y, b2 - z], low, high);
        let [above_then, below_then] = gaps([b0 + x, b1 + y, b2 + z], low, high);
        let first = below.less(above);
        let (begin, then) = (above.max(below), first.select(above_then, below_then));
        let last = below_then.less(above_then);
        let (end, before) = (above_then.max(below_then), last.select(above, below));
        let (apart, parting) = (zero.less(begin), zero.less(end));
        let from = apart.select(begin / (begin - then), zero) - half;
        let until = half - parting.select(end / (end - before), zero);
        let never = apart.and(zero.less(then));
        [never.select(F8::splat(lanes, f32::INFINITY), enter.max(from)), leave.min(until)]
    }
}

/// How far corners are above `high`, and below `low`.
#[inline(always)]
fn gaps<N: Column>([x, y, z]: [N; 3], low: N, high: N) -> [N; 2] {
    [x.min(y).min(z) - high, low - x.max(y).max(z)]
}

#[inline(always)]
fn sum<L: Lanes>([x, y, z]: V8<L>) -> F8<L> {
    x.abs() + y.abs() + z.abs()
}

/// A pair of triangles in `f64`, of which the corners of the second move, each along its own straight line.
#[derive(Clone, Debug)]
pub(crate) struct Swept {
    /// Both relative to the first corner of A.
    a: [DVec3; 3],
    b: [DVec3; 3],
    velocities: [DVec3; 3],
    /// By what their lines bend at the ends of the time.
    bends: [DVec3; 3],
    /// By how much the corners may be off besides, thickness included.
    error: f64,
    /// The largest coordinates of both, and of the way, with the factor of their rounding.
    reach: DVec3,
    half: f64,
    /// Whether all corners have the same velocity.
    is_straight: bool,
}

/// From when to when two triangles may meet.
pub(crate) type Window = [f64; 2];

impl Swept {
    /// For times from `-half` to `half`; at time 0 it is where it is given.
    pub fn new(
        a: &[DVec3; 3],
        b: &[DVec3; 3],
        velocities: [DVec3; 3],
        bends: [DVec3; 3],
        error: f64,
        half: f64,
    ) -> Self {
        let origin = a[0];
        let of = |triangle: &[DVec3; 3]| triangle.map(|corner| corner - origin);
        let reach = |[x, y, z]: [DVec3; 3]| x.abs().max(y.abs()).max(z.abs());
        let (a, b) = (of(a), of(b));
        let reach = (reach(a) + reach(b) + reach(velocities) * half + reach(bends)) * (8.0 * f64::EPSILON);
        let is_straight =
            velocities[1..].iter().all(|velocity| *velocity == velocities[0]) && bends == [DVec3::ZERO; 3];
        Self { a, b, velocities, bends, error, reach, half, is_straight }
    }

    /// When they may meet by the normals of both and the products of their edges; `None`: never. Once that is not before `latest`
    /// the rest of them is left out.
    pub fn window(&self, latest: f64) -> Option<Window> {
        let edges = |[x, y, z]: &[DVec3; 3]| [*y - *x, *z - *x, *z - *y];
        let (of_a, of_b) = (edges(&self.a), edges(&self.b));
        let mut window = self.on(of_a[0].cross(of_a[1]), [-self.half, self.half])?;
        if window[0] < latest {
            window = self.on(of_b[0].cross(of_b[1]), window)?;
        }
        for d in of_a {
            for e in of_b {
                if window[0] >= latest {
                    return Some(window);
                }
                window = self.on(d.cross(e), window)?;
            }
        }
        Some(window)
    }

    /// What is left of a window on the direction `n`, whatever its length.
    pub fn on(&self, n: DVec3, [enter, leave]: Window) -> Option<Window> {
        let largest = largest(n.abs());
        if !(largest > 0.0 && largest < f64::INFINITY) {
            return Some([enter, leave]);
        }
        let n = n / largest;
        let [x, y, z] = self.a.map(|corner| corner.dot(n));
        let error = n.abs().dot(self.reach) + self.error * n.length() * (1.0 + 1e-14) + f64::MIN_POSITIVE;
        if !error.is_finite() {
            return Some([enter, leave]);
        }
        let (low, high) = (smaller(smaller(x, y), z) - error, larger(larger(x, y), z) + error);
        if self.is_straight {
            let [u, v, w] = self.b.map(|corner| corner.dot(n));
            let (first, last) = (low - larger(larger(u, v), w), high - smaller(smaller(u, v), w));
            let speed = self.velocities[0].dot(n);
            let [first, last] = if speed > 0.0 {
                [first / speed, last / speed]
            } else if speed < 0.0 {
                [last / speed, first / speed]
            } else if first <= 0.0 && last >= 0.0 {
                [enter, leave]
            } else {
                NEVER
            };
            return window(larger(enter, first), smaller(leave, last));
        }
        // As long as a corner of B is below the highest of A, and one above the lowest.
        let [at, speeds, bends] = [&self.b, &self.velocities, &self.bends].map(|of| of.map(|v| v.dot(n)));
        let below = self.while_any(array::from_fn(|i| high - at[i] - smaller(bends[i], 0.0)), speeds);
        let above = self.while_any(array::from_fn(|i| at[i] - low + larger(bends[i], 0.0)), speeds.map(|speed| -speed));
        let (enter, leave) = (enter.max(below[0]).max(above[0]), leave.min(below[1]).min(above[1]));
        window(enter, leave)
    }

    /// When one of three things that move with these speeds has not gone farther than its room: mostly all the time.
    fn while_any(&self, rooms: [f64; 3], speeds: [f64; 3]) -> Window {
        let half = self.half;
        if (0..3).any(|i| rooms[i] >= speeds[i].abs() * half) {
            return [-half, half];
        }
        (0..3).fold(NEVER, |window, i| hull(window, self.until(rooms[i], speeds[i])))
    }

    /// When something that moves with this speed has not gone farther than `room`.
    fn until(&self, room: f64, speed: f64) -> Window {
        let half = self.half;
        let window = if speed > 0.0 {
            [-half, half.min(room / speed)]
        } else if speed < 0.0 {
            [(room / speed).max(-half), half]
        } else if room >= 0.0 {
            [-half, half]
        } else {
            NEVER
        };
        if window[0] <= window[1] { window } else { NEVER }
    }
}

const NEVER: Window = [f64::INFINITY, f64::NEG_INFINITY];

fn window(enter: f64, leave: f64) -> Option<Window> {
    (enter <= leave).then_some([enter, leave])
}

/// The window around two.
fn hull(one: Window, other: Window) -> Window {
    [one[0].min(other[0]), one[1].max(other[1])]
}
