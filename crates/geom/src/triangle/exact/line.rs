//! Exact tests of a ray or a segment against a triangle: the side on which it passes an edge, the
//! point at which it meets the plane, and the points that both share if they lie in one plane. Used
//! only where `f64` is in doubt ([`crate::triangle::ray`]).

use super::sum::{Sum, Term, determinant, on_grid};
use crate::Ray;
use arrayvec::ArrayVec;
use core::array::from_fn;
use glam::DVec3;

/// Points of a ray and of a triangle on one grid: the origin, the base and the target of the
/// direction, and the three corners.
pub struct Line {
    points: [[Term; 3]; 6],
    width: u32,
    is_segment: bool,
}

/// A difference of two points, by index: the first minus the second.
type Row = [usize; 2];

const ORIGIN: usize = 0;
/// The end of a segment. For a ray, the target of the direction.
const END: usize = 2;
const DIRECTION: Row = [END, 1];

/// Index of a corner.
const fn corner(i: usize) -> usize {
    3 + i % 3
}

/// Rows of the determinant that is the dot product of the difference `first` and the triangle's
/// normal. The line meets the plane at the parameter `above / along`; both are such determinants.
const fn rows(first: Row) -> [Row; 3] {
    [first, [corner(1), corner(0)], [corner(2), corner(0)]]
}

/// A point of the line at the parameter `t`. `after_origin` is 1 after the origin, -1 before it and
/// 0 at it. `after_end` compares with the end of a segment likewise.
struct Point {
    after_origin: i8,
    after_end: i8,
    t: f64,
}

impl Point {
    /// The parameter of point `p` is `measure` from the origin to `p`, divided by `measure` of the
    /// direction.
    fn new(measure: impl Fn(Row) -> Sum, p: usize) -> Self {
        let (above, along) = (measure([p, ORIGIN]), measure(DIRECTION));
        let sign = along.sign();
        let after_end = measure([p, END]).sign() * sign;
        Self {
            after_origin: above.sign() * sign,
            after_end,
            t: above.quotient(&along),
        }
    }
}

impl Line {
    pub fn new(ray: &Ray, [a, b, c]: &[DVec3; 3]) -> Self {
        let [base, target] = ray.exact_direction();
        let (points, width) =
            on_grid([ray.origin(), base, target, *a, *b, *c].map(|p| p.to_array()));
        Self {
            points,
            width,
            is_segment: ray.is_segment(),
        }
    }

    /// The side on which the line passes the edge from corner `i` to the next: the sign of
    /// `det(d, p - o, q - o)`.
    pub fn side(&self, i: usize) -> i8 {
        self.volume([DIRECTION, [corner(i), ORIGIN], [corner(i + 1), ORIGIN]])
            .sign()
    }

    /// Sign of the distance from the origin to the plane, along the normal.
    pub fn above(&self) -> i8 {
        self.volume(rows([corner(0), ORIGIN])).sign()
    }

    /// Sign of the distance from the end of a segment to the plane, along the normal.
    pub fn above_end(&self) -> i8 {
        self.volume(rows([corner(0), END])).sign()
    }

    /// Parameter at which the line meets the plane. The line is not parallel to the plane.
    pub fn t(&self) -> f64 {
        self.volume(rows([corner(0), ORIGIN]))
            .quotient(&self.volume(rows(DIRECTION)))
    }

    /// The least parameter of a common point, if there is one. The line must lie in one plane with
    /// the triangle, or with the segment or point to which the triangle degenerates:
    /// [`side`](Self::side) is 0 for all edges.
    ///
    /// The projection along an axis is injective on that plane if not all orientations about the
    /// line vanish. If they vanish for all axes, the triangle is a part of the line.
    pub fn t_in_plane(&self) -> Option<f64> {
        let along = (0..3).find(|&axis| self.determinant([DIRECTION], [axis]).sign() != 0)?;
        let turns =
            |axis: usize| from_fn(|i| self.area(axis, [DIRECTION, [corner(i), ORIGIN]]).sign());
        let (axis, turns): (usize, [i8; 3]) = (0..3)
            .map(|axis| (axis, turns(axis)))
            .find(|(_, turns)| *turns != [0; 3])
            .unwrap_or((0, [0; 3]));
        let mut ends = ArrayVec::<Point, 6>::new();
        for i in 0..3 {
            let (p, edge) = (corner(i), [corner(i + 1), corner(i)]);
            if turns[i] == 0 {
                ends.push(Point::new(|first| self.determinant([first], [along]), p));
            }
            if turns[i] * turns[(i + 1) % 3] < 0 {
                ends.push(Point::new(|first| self.area(axis, [first, edge]), p));
            }
        }
        let is_before = !self.is_segment || ends.iter().any(|point| point.after_end <= 0);
        if !is_before || ends.iter().all(|point| point.after_origin < 0) {
            return None;
        }
        if ends.iter().any(|point| point.after_origin <= 0) {
            return Some(0.0);
        }
        ends.iter().map(|point| point.t).reduce(f64::min)
    }

    fn volume(&self, rows: [Row; 3]) -> Sum {
        self.determinant(rows, [0, 1, 2])
    }

    /// The area that two differences span, projected along an axis.
    fn area(&self, axis: usize, rows: [Row; 2]) -> Sum {
        self.determinant(rows, [(axis + 1) % 3, (axis + 2) % 3])
    }

    fn determinant<const D: usize>(&self, rows: [Row; D], axes: [usize; D]) -> Sum {
        let point = |i: usize| &self.points[i][..];
        determinant(rows.map(|row| row.map(point)), axes, self.width)
    }
}
