//! One pair in `f64`: closest points and both bounds.

use crate::{larger, largest};
use glam::DVec3;

type Triangle = [DVec3; 3];

/// Bounds of the distance of two triangles: `low <= distance <= high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The closest points found, one of `a` and one of `b`, rounded.
    pub points: [DVec3; 2],
    /// Unit vector from `b` to `a` along which the triangles are at least `low` apart; zero if
    /// nothing is proven.
    pub direction: DVec3,
    pub low: f64,
    pub high: f64,
    /// True if `high - low` is within the bound of [`Closest::of_apart`].
    pub is_tight: bool,
}

impl Closest {
    /// The result for triangles that meet in the segment with these ends. Both points are its
    /// middle.
    pub fn meeting([start, end]: [DVec3; 2]) -> Self {
        let points = [0.5 * start + 0.5 * end; 2];
        Self {
            points,
            direction: DVec3::ZERO,
            low: 0.0,
            high: 0.0,
            is_tight: true,
        }
    }
}

/// Largest difference of the two bounds, relative to the reach of the pair.
pub(super) const TIGHT: f64 = 64.0 * f64::EPSILON;

/// Closest points of two closed triangles, with bounds of their distance that hold for all finite
/// coordinates up to 2^1003.
///
/// If the triangles meet, `low` is 0 and `high` may have any value.
/// [`super::super::triangles_intersect`] decides whether they meet. If they are apart, the bounds
/// are usually tight; [`Closest::of_apart`] always makes them tight.
// Not inlined: inlined into a kernel and thus compiled for AVX2, it takes three times as long.
#[inline(never)]
pub fn closest(a: &Triangle, b: &Triangle) -> Closest {
    let pair = Pair::new(a, b);
    let found = pair.closest_features();
    let high = pair.high(found.points);
    let (low, direction) = pair.low(found.direction);
    let points = found.points.map(|point| pair.origin + point * pair.unit);
    Closest {
        points,
        direction,
        low,
        high,
        is_tight: pair.is_tight(low, high),
    }
}

/// Two triangles relative to the first corner of `a`, in a unit of length that is a power of two.
/// The largest coordinate is between 1 and 2, or as close to that as `f64` allows.
pub(super) struct Pair {
    pub a: Triangle,
    pub b: Triangle,
    pub origin: DVec3,
    pub unit: f64,
    /// Per axis: the largest magnitude of a coordinate of `a`, plus that of `b`.
    reach: DVec3,
}

impl Pair {
    pub fn new(a: &Triangle, b: &Triangle) -> Self {
        let origin = a[0];
        let (p1, p2) = (a[1] - origin, a[2] - origin);
        let (q0, q1, q2) = (b[0] - origin, b[1] - origin, b[2] - origin);
        let reach_a = larger_components(p1.abs(), p2.abs());
        let reach_b = larger_components(larger_components(q0.abs(), q1.abs()), q2.abs());
        let size = larger(largest(reach_a), largest(reach_b));
        // Exponent field of the largest coordinate; for a denormal one, that of the least normal
        // number.
        let exponent = (size.to_bits() >> 52).max(1);
        let (scale, unit) = (
            f64::from_bits((2046 - exponent) << 52),
            f64::from_bits(exponent << 52),
        );
        let (a, b) = (
            [DVec3::ZERO, p1 * scale, p2 * scale],
            [q0 * scale, q1 * scale, q2 * scale],
        );
        Self {
            a,
            b,
            origin,
            unit,
            reach: (reach_a + reach_b) * scale,
        }
    }

    /// Upper bound of the distance, proven by two points, one of each triangle.
    pub fn high(&self, points: [DVec3; 2]) -> f64 {
        let length = (points[0] - points[1]).length();
        let rounding = f64::EPSILON * self.reach.length();
        let high = (length + 3.01 * rounding) * (1.0 + 3.0 * f64::EPSILON) * self.unit;
        high.max(f64::MIN_POSITIVE)
    }

    /// Lower bound of the distance, proven by the direction `n`, and the unit vector along `n` that
    /// points from `b` to `a`.
    pub fn low(&self, n: DVec3) -> (f64, DVec3) {
        let (gap, direction) = self.gap(n);
        let low = gap * self.unit;
        // The unit is a power of two, so a value above the least normal number is not rounded.
        (if low > f64::MIN_POSITIVE { low } else { 0.0 }, direction)
    }

    pub fn is_tight(&self, low: f64, high: f64) -> bool {
        high - low <= TIGHT * self.reach.length() * self.unit + 2.0 * f64::MIN_POSITIVE
    }

    fn closest_features(&self) -> Features {
        let mut best = Features {
            square: f64::INFINITY,
            points: [DVec3::ZERO; 2],
            direction: DVec3::ZERO,
        };
        // For most pairs, the closest features are the edges that face the other triangle; next
        // come corners and faces.
        let to_b = (self.b[0] + self.b[1] + self.b[2]) - (self.a[0] + self.a[1] + self.a[2]);
        if self.or_facing_edges(&mut best, to_b)
            || best.or_face(&self.a, &self.b, |foot, corner| [foot, corner])
            || best.or_face(&self.b, &self.a, |foot, corner| [corner, foot])
        {
            return best;
        }
        let to_b = best.points[1] - best.points[0];
        if self.or_facing_edges(&mut best, to_b) {
            return best;
        }
        let of_b = [
            Edge::new(&self.b, 0),
            Edge::new(&self.b, 1),
            Edge::new(&self.b, 2),
        ];
        for i in 0..3 {
            let d = Edge::new(&self.a, i);
            for e in &of_b {
                if best.or_edges(&d, e) {
                    return best;
                }
            }
        }
        best
    }

    /// Tests the two edges that face the other triangle. `to_b` is the direction from `a` to `b`.
    fn or_facing_edges(&self, best: &mut Features, to_b: DVec3) -> bool {
        best.or_edges(&Edge::facing(&self.a, to_b), &Edge::facing(&self.b, -to_b))
    }

    /// Proven gap between the projections on a line along `n`, which may have any length, and the
    /// unit vector along `n` that points from `b` to `a`. Both are zero if no gap is proven.
    fn gap(&self, n: DVec3) -> (f64, DVec3) {
        let n = n * (1.0 / largest(n.abs()));
        let (a_low, a_high) = range(&self.a, n);
        let (b_low, b_high) = range(&self.b, n);
        let (above, below) = (a_low - b_high, b_low - a_high);
        let error = 2.01 * f64::EPSILON * n.abs().dot(self.reach) + 1e-300;
        let gap = larger(above, below) - error;
        // Also false for NaN, which a zero direction gives.
        if gap > 0.0 {
            let inverse = 1.0 / n.length();
            let towards_a = if above > below { inverse } else { -inverse };
            (gap * inverse * (1.0 - 4.0 * f64::EPSILON), n * towards_a)
        } else {
            (0.0, DVec3::ZERO)
        }
    }
}

fn larger_components(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z))
}

/// Least and largest projection of the corners on `n`.
fn range(t: &Triangle, n: DVec3) -> (f64, f64) {
    let (x, y, z) = (t[0].dot(n), t[1].dot(n), t[2].dot(n));
    let (low, high) = if x < y { (x, y) } else { (y, x) };
    (if z < low { z } else { low }, larger(z, high))
}

/// Clamps `x` to 0..=1; NaN becomes 0.
pub(super) fn clamped(x: f64) -> f64 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}

/// The closest features found: points of `a` and `b`, their squared distance, and the direction
/// between the features.
struct Features {
    square: f64,
    points: [DVec3; 2],
    direction: DVec3,
}

/// An edge, and the position of the triangle's third corner.
struct Edge {
    start: DVec3,
    end: DVec3,
    step: DVec3,
    /// `1 / |step|^2`.
    inverse: f64,
    /// Vector from the start to the corner that is not on the edge.
    aside: DVec3,
}

/// Index of the next corner.
const NEXT: [usize; 3] = [1, 2, 0];

impl Edge {
    /// The edge opposite the corner that is farthest back.
    fn facing(t: &Triangle, forward: DVec3) -> Self {
        let (x, y, z) = (t[0].dot(forward), t[1].dot(forward), t[2].dot(forward));
        let (back, least) = if y < x { (1, y) } else { (0, x) };
        Self::new(t, NEXT[if z < least { 2 } else { back }])
    }

    /// The edge from a corner to the next.
    fn new(t: &Triangle, corner: usize) -> Self {
        let (start, end) = (t[corner], t[NEXT[corner]]);
        let step = end - start;
        Self {
            start,
            end,
            step,
            inverse: 1.0 / step.length_squared(),
            aside: t[NEXT[NEXT[corner]]] - start,
        }
    }

    fn point(&self, s: f64) -> DVec3 {
        self.start * (1.0 - s) + self.end * s
    }

    /// Parameters of the closest points of this edge and another. Solves for the lines and clamps
    /// to this edge. Projects that point on the other edge and clamps it, then projects back on
    /// this edge and clamps again.
    fn parameters(&self, other: &Self) -> [f64; 2] {
        let (d, e, from) = (self.step, other.step, self.start - other.start);
        let (d_e, d_from, e_from) = (d.dot(e), d.dot(from), e.dot(from) * other.inverse);
        let ratio = d_e * other.inverse;
        // Squared sine of the angle.
        let sine = 1.0 - d_e * ratio * self.inverse;
        let s = if sine < 1e-4 {
            let across = d.cross(e);
            e.cross(from).dot(across) / across.length_squared()
        } else {
            (d_e * e_from - d_from) * self.inverse / sine
        };
        let t = clamped(ratio * clamped(s) + e_from);
        [clamped((d_e * t - d_from) * self.inverse), t]
    }

    /// Separating direction of two edges. Their closest points have these parameters and differ by
    /// `between`. The direction is perpendicular to each edge that has its point inside. The flag
    /// is true if the direction is exact even where the edges nearly meet.
    fn direction(&self, other: &Self, parameters: [f64; 2], between: DVec3) -> (DVec3, bool) {
        let (d, e) = (self.step, other.step);
        let is_inside = |s: f64| s > 0.0 && s < 1.0;
        let (d_inside, e_inside) = (is_inside(parameters[0]), is_inside(parameters[1]));
        if d_inside && e_inside {
            let across = d.cross(e);
            if across.length_squared() * self.inverse * other.inverse > PARALLEL {
                return (across, true);
            }
        }
        let along = |edge: &Self| edge.step * (between.dot(edge.step) * edge.inverse);
        let direction = match (d_inside, e_inside) {
            (true, _) => between - along(self),
            (_, true) => between - along(other),
            _ => between,
        };
        (direction, false)
    }
}

impl Features {
    /// Tests a face against the corners of the other triangle. Only the corner closest to the
    /// face's plane can be the closest point: from every other corner, the distance to the face
    /// decreases on the way to it. Returns true if all corners are on one side and the foot is
    /// inside the face: then the best features are certainly the closest of all.
    fn or_face(
        &mut self,
        face: &Triangle,
        other: &Triangle,
        in_order: impl Fn(DVec3, DVec3) -> [DVec3; 2],
    ) -> bool {
        let (x, y) = (face[1] - face[0], face[2] - face[0]);
        let normal = x.cross(y);
        let heights = other.map(|corner| normal.dot(corner - face[0]));
        let lower = |i: usize, j: usize| {
            if heights[j].abs() < heights[i].abs() {
                j
            } else {
                i
            }
        };
        let corner = other[lower(lower(0, 1), 2)];
        let (mut s, mut t, mut foot, area) = (0.0, 0.0, face[0], normal.length_squared());
        // A second pass corrects the first foot. On a sliver, the error of the first is as many
        // roundings as the sliver is longer than wide.
        for _ in 0..2 {
            s += y.cross(normal).dot(corner - foot) / area;
            t += normal.cross(x).dot(corner - foot) / area;
            let is_inside = s > 0.0 && t > 0.0 && s + t < 1.0;
            if !is_inside {
                return false;
            }
            foot = face[0] * (1.0 - s - t) + face[1] * s + face[2] * t;
        }
        let square = (corner - foot).length_squared();
        if square < self.square {
            *self = Self {
                square,
                points: in_order(foot, corner),
                direction: normal,
            };
        }
        heights.iter().all(|height| *height > 0.0) || heights.iter().all(|height| *height < 0.0)
    }

    /// Tests two edges. Returns true if they are certainly the closest features of all. This is so
    /// if the planes through their closest points, perpendicular to the direction, also separate
    /// the third corners.
    fn or_edges(&mut self, d: &Edge, e: &Edge) -> bool {
        let [s, t] = d.parameters(e);
        let (on_d, on_e) = (d.step * s, e.step * t);
        let between = d.start - e.start + on_d - on_e;
        let square = between.length_squared();
        if square < self.square {
            let (direction, is_exact) = d.direction(e, [s, t], between);
            *self = Self {
                square,
                points: [d.point(s), e.point(t)],
                direction,
            };
            let towards_a = if direction.dot(between) > 0.0 {
                direction
            } else {
                -direction
            };
            return (is_exact || square > NEAR)
                && towards_a.dot(d.aside - on_d) >= 0.0
                && towards_a.dot(e.aside - on_e) <= 0.0;
        }
        false
    }
}

/// Squared distance (in the squared unit of the pair) below which the difference of two points is
/// too inexact to decide on which side of a plane a corner lies.
const NEAR: f64 = 1e-6;

/// Squared sine below which two edges have no perpendicular direction.
const PARALLEL: f64 = 1e-12;
