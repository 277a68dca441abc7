//! A quick judge of distances: an interval that certainly holds the distance of two triangles, as narrow as their shape
//! allows.
//!
//! The features are found in plain `f64`; what they prove is computed in pairs of `f64` (about 100 bits), with all
//! rounding
//! allowed for. Where the interval does not tell, there is [`exact_distance`](crate::exact_distance), a hundred times
//! slower.

use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

use punctual::glam::DVec3;

type Triangle = [DVec3; 3];

/// `low <= distance <= high`.
#[derive(Clone, Copy, Debug)]
pub struct Bracket {
    pub low: f64,
    pub high: f64,
    /// Whether an edge certainly goes through the other triangle.
    pub meet: bool,
}

/// The sum of two numbers, the second below the rounding of the first.
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    /// Exact.
    fn difference(a: f64, b: f64) -> Self {
        let sum = a - b;
        let part = sum - a;
        Self(sum, (a - (sum - part)) - (b + part))
    }
}

impl Add for Double {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let Self(sum, rest) = Self::difference(self.0, -other.0);
        let rest = rest + (self.1 + other.1);
        let high = sum + rest;
        Self(high, rest - (high - sum))
    }
}

impl Sub for Double {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + Self(-other.0, -other.1)
    }
}

impl Mul<f64> for Double {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        let product = self.0 * factor;
        let rest = self.0.mul_add(factor, -product) + self.1 * factor;
        let high = product + rest;
        Self(high, rest - (high - product))
    }
}

type Vector = [Double; 3];

fn dot(v: &Vector, n: DVec3) -> f64 {
    let [x, y, z] = n.to_array();
    (v[0] * x + v[1] * y + v[2] * z).0
}

/// A point of a triangle: from a corner by shares of the edges to the next two.
#[derive(Clone, Copy)]
struct Point {
    corner: usize,
    shares: [f64; 2],
}

impl Point {
    fn of(self, t: &[Vector; 3]) -> Vector {
        let [v, x, y] = from_fn(|k| t[(self.corner + k) % 3]);
        from_fn(|k| v[k] + (x[k] - v[k]) * self.shares[0] + (y[k] - v[k]) * self.shares[1])
    }

    fn rounded(self, t: &Triangle) -> DVec3 {
        let [v, x, y] = from_fn(|k| t[(self.corner + k) % 3]);
        v + (x - v) * self.shares[0] + (y - v) * self.shares[1]
    }
}

/// The closest features found.
struct Best {
    square: f64,
    points: [Point; 2],
    direction: DVec3,
}

impl Best {
    fn or(
        &mut self,
        t: &[Triangle; 2],
        points: [Point; 2],
        direction: impl FnOnce(DVec3) -> DVec3,
    ) {
        let between = points[0].rounded(&t[0]) - points[1].rounded(&t[1]);
        if between.length_squared() < self.square {
            *self = Self {
                square: between.length_squared(),
                points,
                direction: direction(between),
            };
        }
    }
}

fn clamped(x: f64) -> f64 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

/// `None` where numbers are too large or small for it.
pub fn bracket(a: &Triangle, b: &Triangle) -> Option<Bracket> {
    let exact = [a, b].map(|t| t.map(|v| from_fn(|k| Double::difference(v[k], a[0][k]))));
    let rounded: [Triangle; 2] =
        exact.map(|t| t.map(|v: Vector| DVec3::from_array(v.map(|x| x.0))));
    let size = rounded
        .iter()
        .flatten()
        .map(|v| v.abs().max_element())
        .fold(0.0, f64::max);
    if !(1e-60..1e60).contains(&size) {
        return None;
    }
    let mut best = Best {
        square: f64::INFINITY,
        points: [Point {
            corner: 0,
            shares: [0.0; 2],
        }; 2],
        direction: DVec3::X,
    };
    for i in 0..3 {
        for j in 0..3 {
            or_edges(&mut best, &rounded, [i, j]);
        }
        or_face(&mut best, &rounded, 0, i);
        or_face(&mut best, &rounded, 1, i);
    }
    let [p, q]: [Vector; 2] = from_fn(|side| best.points[side].of(&exact[side]));
    let between = DVec3::from_array(from_fn(|k| (p[k] - q[k]).0));
    let n = best.direction / best.direction.abs().max_element();
    let [of_a, of_b] = exact.map(|t| t.map(|v| dot(&v, n)));
    let least = |of: [f64; 3]| of[0].min(of[1]).min(of[2]);
    let most = |of: [f64; 3]| of[0].max(of[1]).max(of[2]);
    let gap = (least(of_a) - most(of_b)).max(least(of_b) - most(of_a)) / n.length();
    let slop = 1e-28 * size;
    // No number is no gap.
    let low = if gap > 0.0 {
        (gap * (1.0 - 1e-15) - slop).max(0.0)
    } else {
        0.0
    };
    let meet = [0, 1]
        .iter()
        .any(|&side| is_pierced(&rounded[side], &rounded[1 - side], size));
    Some(Bracket {
        low,
        high: between.length() * (1.0 + 1e-15) + slop,
        meet,
    })
}

fn or_edges(best: &mut Best, t: &[Triangle; 2], [i, j]: [usize; 2]) {
    let [(d0, d), (e0, e)] = [(0, i), (1, j)]
        .map(|(side, i): (usize, usize)| (t[side][i], t[side][(i + 1) % 3] - t[side][i]));
    let (from, across) = (e0 - d0, d.cross(e));
    let s = clamped(from.cross(e).dot(across) / across.length_squared());
    let u = clamped(e.dot(d * s - from) / e.length_squared());
    let s = clamped(d.dot(from + e * u) / d.length_squared());
    let is_inside = |x: f64| x > 0.0 && x < 1.0;
    let points = [
        Point {
            corner: i,
            shares: [s, 0.0],
        },
        Point {
            corner: j,
            shares: [u, 0.0],
        },
    ];
    best.or(t, points, |between| match (is_inside(s), is_inside(u)) {
        (true, true) => across,
        // Across the edge, by cross products: the difference would lose what is small.
        (true, false) => d.cross((e0 + e * u - d0).cross(d)),
        (false, true) => e.cross((d0 + d * s - e0).cross(e)),
        _ => between,
    });
}

/// The face of one side and a corner of the other.
fn or_face(best: &mut Best, t: &[Triangle; 2], side: usize, corner: usize) {
    let [v, x, y] = t[side];
    let (x, y, from) = (x - v, y - v, t[1 - side][corner] - v);
    let normal = x.cross(y);
    let area = normal.length_squared();
    let shares = [
        y.cross(normal).dot(from) / area,
        normal.cross(x).dot(from) / area,
    ];
    if shares[0] >= 0.0 && shares[1] >= 0.0 && shares[0] + shares[1] <= 1.0 - 1e-15 {
        let (foot, corner) = (
            Point { corner: 0, shares },
            Point {
                corner,
                shares: [0.0; 2],
            },
        );
        best.or(
            t,
            if side == 0 {
                [foot, corner]
            } else {
                [corner, foot]
            },
            |_| normal,
        );
    }
}

/// Whether an edge goes through a face, by volumes that are more than their rounding.
fn is_pierced(face: &Triangle, other: &Triangle, size: f64) -> bool {
    let error = 1e-13 * size * size * size;
    let volume = |p: DVec3, q: DVec3, r: DVec3, s: DVec3| (q - p).cross(r - p).dot(s - p);
    (0..3).any(|i| {
        let (p, q) = (other[i], other[(i + 1) % 3]);
        let ends = [p, q].map(|end| volume(face[0], face[1], face[2], end));
        let sides: [f64; 3] = from_fn(|j| volume(p, q, face[j], face[(j + 1) % 3]));
        let is_through =
            ends.iter().all(|end| end.abs() > error) && (ends[0] > 0.0) != (ends[1] > 0.0);
        is_through
            && (sides.iter().all(|side| *side > error) || sides.iter().all(|side| *side < -error))
    })
}
