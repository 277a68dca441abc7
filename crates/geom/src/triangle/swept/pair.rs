//! One pair in `f64`.

use crate::{larger, largest, smaller};
use core::array;
use glam::DVec3;

/// A pair of triangles in `f64`. The corners of the second move, each along its own straight line.
#[derive(Clone, Debug)]
pub struct Swept {
    /// Both triangles relative to the first corner of A.
    a: [DVec3; 3],
    b: [DVec3; 3],
    velocities: [DVec3; 3],
    /// Deviations of B's corners from their lines at the ends of the time, and the largest
    /// magnitude of these deviations per axis.
    bends: [DVec3; 3],
    most_bent: DVec3,
    /// Upper bound of the other errors of the corners' positions, plus the thickness of the
    /// surfaces.
    error: f64,
    /// Per axis, the sum of the largest magnitudes: of A's corners, B's corners, the displacement
    /// of B in half of the time, and the deviations.
    reach: DVec3,
    half: f64,
    /// True if all corners have the same velocity.
    is_straight: bool,
}

/// Start and end of the time in which two triangles may meet.
pub type Window = [f64; 2];

/// Largest magnitude per axis.
fn most([x, y, z]: [DVec3; 3]) -> DVec3 {
    x.abs().max(y.abs()).max(z.abs())
}

/// The edges of a triangle, or the velocities of its edges.
fn edges([x, y, z]: &[DVec3; 3]) -> [DVec3; 3] {
    [*y - *x, *z - *x, *z - *y]
}

impl Swept {
    /// A motion during times from `-half` to `half`. The triangles are given at time 0.
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
        let (a, b, most_bent) = (of(a), of(b), most(bends));
        let reach = most(a) + most(b) + most(velocities) * half + most_bent;
        let is_straight = velocities[1..]
            .iter()
            .all(|velocity| *velocity == velocities[0])
            && bends == [DVec3::ZERO; 3];
        Self {
            a,
            b,
            velocities,
            bends,
            most_bent,
            error,
            reach,
            half,
            is_straight,
        }
    }

    /// Window in which the triangles may meet; `None` if they never do. Tests the directions of
    /// both normals and of the cross products of edges; these turn with B. Stops once the window
    /// starts at `latest` or later. If the planes are nearly parallel, these directions hardly
    /// separate triangles within the planes. Then it also tests the directions in the planes that
    /// are perpendicular to an edge.
    pub fn window(&self, latest: f64) -> Option<Window> {
        let (of_a, of_b, turns) = (edges(&self.a), edges(&self.b), edges(&self.velocities));
        let size = largest(most(of_a).max(most(of_b)));
        // Approximate amount that the turn of a direction adds to projections.
        let turned = if self.is_straight {
            0.0
        } else {
            0.5 * size * largest(most(turns)) * largest(self.reach) * self.half
        };
        let [m, n] = [&of_a, &of_b].map(|edges| edges[0].cross(edges[1]));
        let turn_of_n = || turns[0].cross(of_b[1]) + of_b[0].cross(turns[1]);
        let mut window = self.on(m, [-self.half, self.half])?;
        if window[0] < latest {
            window = self.on_turning_with_b(n, turn_of_n, turned, window)?;
        }
        for d in of_a {
            for j in 0..3 {
                if window[0] >= latest {
                    return Some(window);
                }
                window =
                    self.on_turning_with_b(d.cross(of_b[j]), || d.cross(turns[j]), turned, window)?;
            }
        }
        if m.cross(n).length_squared() < PARALLEL * m.length_squared() * n.length_squared() {
            for (d, (e, turn)) in of_a.into_iter().zip(of_b.into_iter().zip(turns)) {
                window = self.on(m.cross(d), window)?;
                let turn = || turn_of_n().cross(e) + n.cross(turn);
                window = self.on_turning_with_b(n.cross(e), turn, turned * size, window)?;
            }
        }
        Some(window)
    }

    /// Narrows a window by the direction `n` of any length.
    pub fn on(&self, n: DVec3, window: Window) -> Option<Window> {
        self.on_turning_with_b(n, || DVec3::ZERO, 0.0, window)
    }

    /// Narrows a window by a direction that is `n` at time 0 and changes by `turn` per unit of
    /// time. This change adds about `turned` to projections.
    fn on_turning_with_b(
        &self,
        n: DVec3,
        turn: impl FnOnce() -> DVec3,
        turned: f64,
        window: Window,
    ) -> Option<Window> {
        let largest = largest(n.abs());
        if !(largest > 0.0 && largest < f64::INFINITY) {
            return Some(window);
        }
        let inverse = 1.0 / largest;
        let n = n * inverse;
        if self.is_straight {
            self.on_straight(n, window)
        } else {
            self.on_turning(n, || turn() * inverse, turned * inverse, window)
        }
    }

    /// Error bound of projections on `n`, whose squared length is `square`; `None` if it is not
    /// finite.
    #[inline(always)]
    fn error_on(&self, n: DVec3, square: f64) -> Option<f64> {
        let error = n.abs().dot(self.reach) * ROUNDINGS
            + self.error * libm::sqrt(square) * (1.0 + 1e-14)
            + f64::MIN_POSITIVE;
        error.is_finite().then_some(error)
    }

    /// Narrows a window if all corners have the same velocity.
    #[inline(always)]
    fn on_straight(&self, n: DVec3, [enter, leave]: Window) -> Option<Window> {
        let Some(error) = self.error_on(n, n.dot(n)) else {
            return Some([enter, leave]);
        };
        let [[x, y, z], [u, v, w]] = [&self.a, &self.b].map(|of| of.map(|corner| corner.dot(n)));
        let first = smaller(smaller(x, y), z) - error - larger(larger(u, v), w);
        let last = larger(larger(x, y), z) + error - smaller(smaller(u, v), w);
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
        some_window(larger(enter, first), smaller(leave, last))
    }

    #[inline(always)]
    fn on_turning(
        &self,
        n: DVec3,
        turn: impl FnOnce() -> DVec3,
        turned: f64,
        [enter, leave]: Window,
    ) -> Option<Window> {
        let (square, half) = (n.dot(n), self.half);
        let Some(error) = self.error_on(n, square) else {
            return Some([enter, leave]);
        };
        let [of_a, of_b, speeds, bends] = [&self.a, &self.b, &self.velocities, &self.bends]
            .map(|of| of.map(|vector| vector.dot(n)));
        let [x, y, z] = of_a;
        let (low, high) = (
            smaller(smaller(x, y), z) - error,
            larger(larger(x, y), z) + error,
        );
        let stays = |room: f64, j: usize| room - turned >= speeds[j].abs() * half;
        let is_below = |j: usize| stays(high - of_b[j] - smaller(bends[j], 0.0), j);
        let is_above = |j: usize| stays(of_b[j] - low + larger(bends[j], 0.0), j);
        if (0..3).any(is_below) && (0..3).any(is_above) {
            // The usual case: the projections overlap during all of the time, for the fixed
            // direction and for the one that turns.
            return Some([enter, leave]);
        }
        let turn = turn();
        // Perpendicular to `n`, so that its length changes little.
        let turn = turn - n * (turn.dot(n) / square);
        let square = square + (2.0 * turn.dot(n).abs() + turn.dot(turn) * half) * half;
        let Some(error) = self.error_on(n, square) else {
            return Some([enter, leave]);
        };
        let error = error + turn.abs().dot(self.reach * ROUNDINGS + self.most_bent) * half;
        let speeds_of_a = self.a.map(|corner| corner.dot(turn));
        let speeds_of_b: [f64; 3] = array::from_fn(|j| speeds[j] + self.b[j].dot(turn));
        let bends: [f64; 3] =
            array::from_fn(|j| bends[j] + self.velocities[j].dot(turn) * (half * half));
        // The triangles can meet only while some corner of B is below one of A and some corner of B
        // is above one of A.
        let below = self.while_any(|i, j| {
            (
                of_a[i] - of_b[j] + error - smaller(bends[j], 0.0),
                speeds_of_b[j] - speeds_of_a[i],
            )
        });
        let above = self.while_any(|i, j| {
            (
                of_b[j] - of_a[i] + error + larger(bends[j], 0.0),
                speeds_of_a[i] - speeds_of_b[j],
            )
        });
        some_window(
            enter.max(below[0]).max(above[0]),
            leave.min(below[1]).min(above[1]),
        )
    }

    /// Hull of the times `t` at which `room >= speed t` for one of nine pairs of corners. `thing`
    /// gives room and speed of a pair.
    fn while_any(&self, thing: impl Fn(usize, usize) -> (f64, f64)) -> Window {
        let half = self.half;
        let things = (0..9).map(|k| thing(k / 3, k % 3));
        if things
            .clone()
            .any(|(room, speed)| room >= speed.abs() * half)
        {
            return [-half, half];
        }
        things.fold(NEVER, |window, (room, speed)| {
            hull(window, self.until(room, speed))
        })
    }

    /// Times `t` at which `room >= speed t`.
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
        if window[0] <= window[1] {
            window
        } else {
            NEVER
        }
    }
}

/// Squared sine of the angle up to which planes count as nearly parallel.
const PARALLEL: f64 = 0.01;

/// Relative rounding of sums of projections.
const ROUNDINGS: f64 = 8.0 * f64::EPSILON;

const NEVER: Window = [f64::INFINITY, f64::NEG_INFINITY];

fn some_window(enter: f64, leave: f64) -> Option<Window> {
    (enter <= leave).then_some([enter, leave])
}

/// The smallest window that contains both.
fn hull(one: Window, other: Window) -> Window {
    [one[0].min(other[0]), one[1].max(other[1])]
}
