//! Bounds of one pair in `f64` from all of its features. Used for pairs on which the search for the
//! closest features failed.
//!
//! The distance of two disjoint triangles is that of a corner and a face, of two edges, of a corner
//! and an edge, or of two corners. These are 42 candidates, and one of them is the true one. Each
//! proposes two points and a direction. The best upper bound and the best lower bound are kept,
//! whichever candidates they come from. So it does not matter which candidate is the closest. It
//! only matters that the points and the direction of the true one are right up to a few roundings
//! *of the extent of the pair*, for all shapes. That takes two measures:
//!
//! - Corners are rounded to a grid of 2^-58 in the unit of the pair. This moves them by far less
//!   than a rounding, and makes cross products of their differences exact in 128-bit integers. So
//!   directions are right for all thin triangles and nearly parallel edges.
//! - A point in a face is found along its longest edge first and then across it, so that no error
//!   is divided by the width.
//!
//! Takes constant time, about ten times that of [`closest`]. The bound is derived in
//! `docs/numerics.md`.

use super::pair::{Closest, Pair, clamped, closest};
use crate::triangle::triangles_intersect;
use glam::DVec3;

impl Closest {
    /// Tightens the bounds of two triangles that are known not to meet. `a` and `b` are their
    /// corners. Then `high - low` is no more than [`TIGHT`](super::pair::TIGHT) times the reach of
    /// the pair, or than 2^-1021, for all shapes.
    ///
    /// The reach is the length of a vector. Its component along an axis is the largest coordinate
    /// of A's corners plus the largest of B's, as magnitudes relative to the first corner of A.
    #[inline]
    pub fn of_apart(self, a: &[DVec3; 3], b: &[DVec3; 3]) -> Self {
        if self.is_tight {
            self
        } else {
            by_all_features(&Pair::new(a, b), self)
        }
    }
}

/// [`closest`] with tight bounds, unless the triangles meet.
pub fn closest_or_meeting(a: &[DVec3; 3], b: &[DVec3; 3]) -> Closest {
    let found = closest(a, b);
    if found.is_tight || triangles_intersect(a, b) {
        found
    } else {
        found.of_apart(a, b)
    }
}

/// A corner on the grid, or the difference of two.
#[derive(Clone, Copy)]
struct Whole([i64; 3]);

/// 2^58. In the unit of the pair, coordinates are below 2. On the grid, differences are below 2^60,
/// and cross products below 2^121.
const GRID: f64 = (1_u64 << 58) as f64;

impl Whole {
    fn new(v: DVec3) -> Self {
        Self((v * GRID).to_array().map(|x| x as i64))
    }

    /// The vector from `other` to this point.
    fn from(self, other: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        Self([x - u, y - v, z - w])
    }

    /// Rounds each component once.
    fn rounded(self) -> DVec3 {
        DVec3::from_array(self.0.map(|x| x as f64))
    }

    /// The cross product, computed exactly; then each component is rounded once.
    fn cross(self, other: Self) -> DVec3 {
        let ([x, y, z], [u, v, w]) = (self.0.map(i128::from), other.0.map(i128::from));
        DVec3::new(
            (y * w - z * v) as f64,
            (z * u - x * w) as f64,
            (x * v - y * u) as f64,
        )
    }
}

/// Index of the next corner.
const NEXT: [usize; 3] = [1, 2, 0];

/// An edge; its length may be 0.
struct Edge {
    corners: [usize; 2],
    start: Whole,
    step: Whole,
    /// The difference of the ends, rounded.
    along: DVec3,
    square: f64,
}

/// A triangle with its corners on the grid.
struct Shape<'t> {
    corners: &'t [DVec3; 3],
    on_grid: [Whole; 3],
    edges: [Edge; 3],
}

impl<'t> Shape<'t> {
    fn new(corners: &'t [DVec3; 3]) -> Self {
        let on_grid = corners.map(Whole::new);
        let edges = [0, 1, 2].map(|i| {
            let (start, step) = (on_grid[i], on_grid[NEXT[i]].from(on_grid[i]));
            let along = step.rounded();
            Edge {
                corners: [i, NEXT[i]],
                start,
                step,
                along,
                square: along.length_squared(),
            }
        });
        Self {
            corners,
            on_grid,
            edges,
        }
    }

    fn longest_edge(&self) -> &Edge {
        let [first, others @ ..] = &self.edges;
        others
            .iter()
            .fold(first, |x, y| if x.square < y.square { y } else { x })
    }

    fn on_edge(&self, edge: &Edge, s: f64) -> DVec3 {
        let [start, end] = edge.corners.map(|i| self.corners[i]);
        start * (1.0 - s) + end * s
    }
}

/// Improves the bounds of two triangles that do not meet until they are tight.
#[cold]
#[inline(never)]
fn by_all_features(pair: &Pair, found: Closest) -> Closest {
    let shapes = [Shape::new(&pair.a), Shape::new(&pair.b)];
    let mut best = Best { pair, found };
    let _ = best.or_faces(&shapes) || best.or_edges(&shapes) || best.or_corners(&shapes);
    best.found
}

struct Best<'p> {
    pair: &'p Pair,
    found: Closest,
}

/// Returns the point of A, then that of B. `first` belongs to the triangle with index `side`,
/// `second` to the other.
fn in_order(side: usize, first: DVec3, second: DVec3) -> [DVec3; 2] {
    if side == 0 {
        [first, second]
    } else {
        [second, first]
    }
}

impl Best<'_> {
    /// Improves the upper bound by two points, which are relative to the first corner of A. Returns
    /// true if both bounds are now tight.
    fn or_points(&mut self, points: [DVec3; 2]) -> bool {
        let high = self.pair.high(points);
        if high < self.found.high {
            (self.found.high, self.found.points) = (
                high,
                points.map(|point| self.pair.origin + point * self.pair.unit),
            );
        }
        self.is_tight()
    }

    /// Improves the lower bound by the direction `n`. Returns true if both bounds are now tight.
    fn or_direction(&mut self, n: DVec3) -> bool {
        let (low, direction) = self.pair.low(n);
        if low > self.found.low {
            (self.found.low, self.found.direction) = (low, direction);
        }
        self.is_tight()
    }

    fn is_tight(&mut self) -> bool {
        self.found.is_tight = self.pair.is_tight(self.found.low, self.found.high);
        self.found.is_tight
    }

    /// Tests each face with the corners of the other triangle. If the foot of a corner lies outside
    /// the face, it is moved into the face.
    fn or_faces(&mut self, shapes: &[Shape; 2]) -> bool {
        for side in 0..2 {
            let (face, other) = (&shapes[side], &shapes[1 - side]);
            let base = face.longest_edge();
            let [start, end] = base.corners;
            let apex = NEXT[end];
            let rise = face.on_grid[apex].from(base.start);
            let normal = base.step.cross(rise);
            // Component of the third corner across the base, and its position along the base.
            let across = normal.cross(base.along) / base.square;
            let (height, middle) = (
                across.length_squared(),
                base.along.dot(rise.rounded()) / base.square,
            );
            if self.or_direction(normal) {
                return true;
            }
            for corner in 0..3 {
                let from = other.on_grid[corner].from(base.start).rounded();
                let t = clamped(from.dot(across) / height);
                let s = clamped(from.dot(base.along) / base.square - t * middle);
                let s = if s < 1.0 - t { s } else { 1.0 - t };
                let foot = face.corners[start] * (1.0 - s - t)
                    + face.corners[end] * s
                    + face.corners[apex] * t;
                if self.or_points(in_order(side, foot, other.corners[corner])) {
                    return true;
                }
            }
        }
        false
    }

    /// Tests each pair of edges for closest points inside both.
    fn or_edges(&mut self, [a, b]: &[Shape; 2]) -> bool {
        for d in &a.edges {
            for e in &b.edges {
                let from = e.start.from(d.start);
                let (normal, moment, from) =
                    (d.step.cross(e.step), from.cross(e.step), from.rounded());
                let s = clamped(moment.dot(normal) / normal.length_squared());
                let t = clamped(e.along.dot(d.along * s - from) / e.square);
                let s = clamped(d.along.dot(from + e.along * t) / d.square);
                if self.or_points([a.on_edge(d, s), b.on_edge(e, t)]) || self.or_direction(normal) {
                    return true;
                }
            }
        }
        false
    }

    /// Tests each corner with the edges and the corners of the other triangle.
    fn or_corners(&mut self, shapes: &[Shape; 2]) -> bool {
        for side in 0..2 {
            let (shape, other) = (&shapes[side], &shapes[1 - side]);
            for edge in &shape.edges {
                for (corner, on_grid) in other.corners.iter().zip(&other.on_grid) {
                    let from = on_grid.from(edge.start);
                    let s = clamped(from.rounded().dot(edge.along) / edge.square);
                    let across = edge.along.cross(from.cross(edge.step));
                    if self.or_points(in_order(side, shape.on_edge(edge, s), *corner))
                        || self.or_direction(across)
                        || self.or_direction(from.rounded())
                    {
                        return true;
                    }
                }
            }
        }
        false
    }
}
