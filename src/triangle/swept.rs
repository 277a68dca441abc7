//! When do two triangles meet on the way? Times before which they certainly do not.
//!
//! B goes along straight lines. On any direction the projections of the two triangles overlap from one time to another; on
//! several, from the latest beginning to the earliest end. With the normals of both and the nine products of their edges this
//! is when they meet, unless they are coplanar or degenerate. What B may leave its line by is added to the projections, as is
//! all rounding, so no direction makes the answer false: `docs/numerics.md`, "Motion".
//!
//! - [`windows`]: eight pairs at a time in `f32`.
//! - [`Swept`]: one pair in `f64`.

use super::batch::{Placement, Rows, Transposed, UNDERFLOW};
use super::distance::Pair;
use crate::math::lanes::{Column, F8, Lanes, V8, add, cross, dot, per_axis, sub};
use crate::math::tolerance::ROUNDING;
use crate::math::{larger, largest, smaller};
use glam::DVec3;

/// How B goes through a piece of time, from -1/2 to 1/2 with the place that it is given in the middle: lengths in A's units. A
/// point at `y` has the velocity `shift + turn x y` there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glide {
    pub shift: [f32; 3],
    pub turn: [f32; 3],
    /// What a part of B may leave its line by, for each unit of its radius, and besides.
    pub spin: f32,
    pub bulge: f32,
}

/// Slower projections count as this fast; what that makes of them is covered by [`UNDERFLOW`].
pub(crate) const LEAST_SPEED: f32 = 1e-37;

/// When `a[i]` and `b[i]` may meet first, for the eight lanes, and those that may before `cut`, a bit each.
#[inline(always)]
pub(crate) fn windows<L: Lanes>(
    lanes: L,
    a: [&Rows; 8],
    b: [&Rows; 8],
    placement: &Placement,
    glide: &Glide,
    cut: f32,
) -> ([f32; 8], u32) {
    let first = Transposed::new(lanes, a).first;
    let pair = Gliding::new(lanes, Pair::new(lanes, a, b, placement), first, glide);
    let (p, f) = (pair.of.p, pair.of.f);
    let all = [F8::splat(lanes, -1e30), F8::splat(lanes, 1e30)];
    let mut window = pair.on(lanes, cross(f[0], f[1]), pair.on(lanes, cross(p[0], p[1]), all));
    let (p, f) = ([p[0], p[1], sub(p[1], p[0])], [f[0], f[1], sub(f[1], f[0])]);
    let mut i = 0;
    while i < 3 {
        if alive(lanes, window, cut).1 == 0 {
            return ([f32::INFINITY; 8], 0);
        }
        let mut j = 0;
        while j < 3 {
            window = pair.on(lanes, cross(p[i], f[j]), window);
            j += 1;
        }
        i += 1;
    }
    let (enter, alive) = alive(lanes, window, cut);
    (enter.store(), alive)
}

/// When windows begin, rounded down, and those that are not empty and begin before `cut`.
#[inline(always)]
fn alive<L: Lanes>(lanes: L, [enter, leave]: [F8<L>; 2], cut: f32) -> (F8<L>, u32) {
    let (begin, slop) = (F8::splat(lanes, -0.5), F8::splat(lanes, 8.0 * ROUNDING));
    let (enter, leave) = (enter - slop, leave + slop);
    // Where one of them is no number nothing is known.
    (enter, !leave.less(enter.max(begin)).or(F8::splat(lanes, cut).less(enter)).mask() & 0xff)
}

/// Eight pairs, of which those of B move.
struct Gliding<L: Lanes> {
    of: Pair<L>,
    velocity: V8<L>,
}

impl<L: Lanes> Gliding<L> {
    #[inline(always)]
    fn new(lanes: L, mut of: Pair<L>, first: V8<L>, glide: &Glide) -> Self {
        let mut velocity = per_axis!(k => F8::splat(lanes, glide.shift[k]));
        let mut error = F8::splat(lanes, glide.bulge);
        if glide.spin > 0.0 {
            let at = per_axis!(k => of.q[k] + first[k]);
            let turn = per_axis!(k => F8::splat(lanes, glide.turn[k]));
            let radius = dot(of.f[0], of.f[0]).max(dot(of.f[1], of.f[1])).sqrt();
            let speed = sum(turn) * sum(at);
            velocity = add(velocity, cross(turn, at));
            error = error + radius * F8::splat(lanes, glide.spin * 1.001) + speed * F8::splat(lanes, 32.0 * ROUNDING);
        }
        of.error = per_axis!(k => {
            of.error[k] + error + F8::splat(lanes, glide.shift[k].abs() * (4.0 * ROUNDING))
        });
        Self { of, velocity }
    }

    /// What is left of a window on the direction `n`, whatever its length.
    #[inline(always)]
    fn on(&self, lanes: L, n: V8<L>, [enter, leave]: [F8<L>; 2]) -> [F8<L>; 2] {
        let zero = F8::splat(lanes, 0.0);
        let Pair { p, q, f, error } = self.of;
        let (a1, a2) = (dot(p[0], n), dot(p[1], n));
        let (b0, b1, b2) = (dot(q, n), dot(f[0], n), dot(f[1], n));
        let (a_low, a_high) = (zero.min(a1).min(a2), zero.max(a1).max(a2));
        let (b_low, b_high) = (zero.min(b1).min(b2), zero.max(b1).max(b2));
        let sums = (a_high - a_low) + (b_high - b_low) + b0.abs();
        let error = dot(per_axis!(k => n[k].abs()), error)
            + sums * F8::splat(lanes, 4.0 * ROUNDING)
            + F8::splat(lanes, UNDERFLOW);
        let (low, high) = (a_low - (b0 + b_high) - error, a_high - (b0 + b_low) + error);
        let speed = dot(self.velocity, n);
        let inverse = F8::splat(lanes, 1.0) / speed.abs().max(F8::splat(lanes, LEAST_SPEED));
        let back = speed.less(zero);
        let (first, last) = (back.select(-high, low), back.select(-low, high));
        [enter.max(first * inverse), leave.min(last * inverse)]
    }
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
    /// By how much the corners may be off their lines, thickness included.
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
    pub fn new(a: &[DVec3; 3], b: &[DVec3; 3], velocities: [DVec3; 3], error: f64, half: f64) -> Self {
        let origin = a[0];
        let of = |triangle: &[DVec3; 3]| triangle.map(|corner| corner - origin);
        let reach = |[x, y, z]: [DVec3; 3]| x.abs().max(y.abs()).max(z.abs());
        let (a, b) = (of(a), of(b));
        let reach = (reach(a) + reach(b) + reach(velocities) * half) * (8.0 * f64::EPSILON);
        let is_straight = velocities[1..].iter().all(|velocity| *velocity == velocities[0]);
        Self { a, b, velocities, error, reach, half, is_straight }
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
        let (mut below, mut above) = (NEVER, NEVER);
        for (corner, velocity) in self.b.iter().zip(&self.velocities) {
            let (at, speed) = (corner.dot(n), velocity.dot(n));
            below = hull(below, self.until(high - at, speed));
            above = hull(above, self.until(at - low, -speed));
        }
        let (enter, leave) = (enter.max(below[0]).max(above[0]), leave.min(below[1]).min(above[1]));
        window(enter, leave)
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
