//! Where two surfaces meet they do so along a curve: from a pair of triangles that meet to the next one, without a test.
//!
//! An edge of one triangle certainly crosses the other triangle, the face. So does that edge as a part of the neighbor behind
//! it, which therefore meets the face too, along a segment that begins at the edge. The new corner of the neighbor is above
//! or below the plane of the face, and so one of its two other edges spans that plane.
//! - If that edge passes inside of all three edges of the face, it crosses the face, and the curve goes on behind it.
//! - If it passes outside of one, the segment leaves the face across that one, which therefore crosses the neighbor: the two
//!   change roles.
//! - If it passes outside of two, it is the one that has the segment between its ends: the side on which their common corner
//!   is of the neighbor's plane tells.
//!
//! All is computed in `f64` from the vertices as they are, and only what is certain counts; `docs/numerics.md` has the bounds
//! and the proof.

use super::exact::{LARGEST, PADDING};
use crate::math::lanes::{D4, Lanes, per_axis};
use core::hint::select_unpredictable;

/// A vector; the last number is not used.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Point([f64; 4]);

impl Point {
    const ORIGIN: Self = Self([0.0; 4]);
}

/// An edge of the triangle on one side that certainly crosses the triangle on the other.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    /// Of the triangles on both sides; there is no fourth, but so indices need no checks.
    corners: [[Point; 4]; 2],
    /// The same, axis by axis.
    columns: [[[f64; 4]; 3]; 2],
    /// The normal of the face.
    normal: Point,
    /// By how much a height or a volume may be off.
    error: f64,
    /// Whose edge it is.
    side: usize,
    /// Which of its corners are the ends of the edge, on the side of the face to which its normal points, and on the other.
    above: usize,
    below: usize,
}

/// The number after it of 0, 1, 2.
const NEXT: [usize; 4] = [1, 2, 0, 0];

/// For the edges of a face that a line passes outside of, one or two, a bit each: the first of them.
const FIRST: [usize; 8] = [0, 0, 1, 0, 2, 2, 1, 0];

/// Relative rounding of one `f64` operation: 2^-53.
const ROUNDING: f64 = f64::EPSILON / 2.0;

impl Curve {
    pub const NOWHERE: Self = Self {
        corners: [[Point::ORIGIN; 4]; 2],
        columns: [[[0.0; 4]; 3]; 2],
        normal: Point::ORIGIN,
        error: 0.0,
        side: 0,
        above: 0,
        below: 0,
    };

    /// Begins at an edge, between corners `edge` and `edge + 1` of one side, that certainly crosses the triangle on the other.
    /// No two points of the two surfaces, where they meet, are farther apart along an axis than `size`. False if it is not
    /// certain how it goes on.
    #[inline(always)]
    pub fn begin<L: Lanes>(&mut self, corners: [[D4<L>; 3]; 2], side: usize, edge: usize, size: f64) -> bool {
        let size = size + PADDING;
        self.error = if size < LARGEST { 80.0 * ROUNDING * size * size * size } else { f64::INFINITY };
        for (side, corners) in corners.into_iter().enumerate() {
            for (i, corner) in corners.into_iter().enumerate() {
                self.set(side, i, corner);
            }
        }
        let (start, end) = (edge, NEXT[edge & 3]);
        let face = (side & 1) ^ 1;
        self.see(corners[face]);
        let of_start = self.height(face, corners[side & 1][start % 3]);
        let of_end = self.height(face, corners[side & 1][end % 3]);
        self.side = side;
        (self.above, self.below) = if of_start > 0.0 { (start, end) } else { (end, start) };
        self.is_certain(of_start) && self.is_certain(of_end) && (of_start > 0.0) != (of_end > 0.0)
    }

    /// Whether the sign of a height is.
    #[inline(always)]
    fn is_certain(&self, height: f64) -> bool {
        height.abs() > self.error
    }

    /// The side whose edge it is.
    #[inline(always)]
    pub fn side(&self) -> usize {
        self.side & 1
    }

    /// The corner that is not on the edge: it gives way to that of the neighbor.
    #[inline(always)]
    pub fn apex(&self) -> usize {
        3 - self.above - self.below
    }

    /// Goes on into the neighbor behind the edge, which has this corner in place of the apex. False if it is not certain where
    /// the curve leaves it.
    #[inline(always)]
    pub fn advance<L: Lanes>(&mut self, lanes: L, corner: D4<L>) -> bool {
        let (side, face) = (self.side & 1, (self.side & 1) ^ 1);
        let (above, below, apex) = (self.above, self.below, self.apex());
        self.set(side, apex, corner);
        let height = self.height(face, corner);
        if !self.is_certain(height) {
            return false;
        }
        // Chosen, not branched: what cannot be guessed.
        let is_up = height > 0.0;
        self.above = select_unpredictable(is_up, apex, above);
        self.below = select_unpredictable(is_up, below, apex);
        let [inside, outside] = self.passes(corner, is_up);
        if inside | outside != 0b111 {
            return false;
        }
        outside == 0 || self.turn(lanes, [above, below], outside)
    }

    /// Leaves the face across one of its edges, `outside` of which the neighbor's line passes; both change roles. The edge
    /// through which the curve came is `above` and `below`.
    #[inline(always)]
    fn turn<L: Lanes>(&mut self, lanes: L, [above, below]: [usize; 2], outside: u32) -> bool {
        let (side, face) = (self.side & 1, (self.side & 1) ^ 1);
        self.see(per_axis!(i => D4::load(lanes, &self.corners[side][i].0)));
        // Seen along the curve, the edge it came through points down; so this tells which way the normal points.
        let is_even = NEXT[above & 3] == below;
        let mut edge = FIRST[outside as usize & 7];
        if !outside.is_power_of_two() {
            let between = NEXT[edge & 3];
            let height = self.height(side, D4::load(lanes, &self.corners[face][between & 3].0));
            if !self.is_certain(height) {
                return false;
            }
            edge = select_unpredictable((height > 0.0) == is_even, between, edge);
        }
        let end = NEXT[edge & 3];
        self.above = select_unpredictable(is_even, edge, end);
        self.below = select_unpredictable(is_even, end, edge);
        self.side = face;
        true
    }

    #[inline(always)]
    fn set<L: Lanes>(&mut self, side: usize, corner: usize, point: D4<L>) {
        let point = point.store();
        self.corners[side & 1][corner & 3] = Point(point);
        per_axis!(k => self.columns[side & 1][k][corner & 3] = point[k]);
    }

    /// Makes a triangle the face.
    #[inline(always)]
    fn see<L: Lanes>(&mut self, [p, q, r]: [D4<L>; 3]) {
        let (u, v) = (q - p, r - p);
        let (x, y) = (u * v.turned(), u.turned() * v);
        self.normal = Point((x - y).turned().store());
    }

    /// How high a point is above the face, which is the triangle on this side, times the length of the normal.
    #[inline(always)]
    fn height<L: Lanes>(&self, face: usize, point: D4<L>) -> f64 {
        let lanes = point.lanes();
        let from_face = point - D4::load(lanes, &self.corners[face & 1][0].0);
        (from_face * D4::load(lanes, &self.normal.0)).sum()
    }

    /// Which edges of the face, a bit each, the line of the edge certainly passes inside, and outside. One of its ends is the
    /// latest corner, and which one it is matters as late as possible.
    #[inline(always)]
    fn passes<L: Lanes>(&self, corner: D4<L>, is_above: bool) -> [u32; 2] {
        let (lanes, point) = (corner.lanes(), corner.store());
        let (side, face) = (self.side & 1, (self.side & 1) ^ 1);
        let r = per_axis!(k => D4::load(lanes, &self.columns[face][k]) - D4::splat(lanes, point[k]));
        let next = per_axis!(k => r[k].turned());
        let [x, y, z] =
            [r[1] * next[2] - r[2] * next[1], r[2] * next[0] - r[0] * next[2], r[0] * next[1] - r[1] * next[0]];
        let other = &self.corners[side][select_unpredictable(is_above, self.below, self.above) & 3];
        let edge = per_axis!(k => D4::splat(lanes, point[k]) - D4::splat(lanes, other.0[k]));
        let volume = edge[0] * x + edge[1] * y + edge[2] * z;
        let (up, down) = (D4::splat(lanes, self.error).less(volume), volume.less(D4::splat(lanes, -self.error)));
        [select_unpredictable(is_above, up, down) & 0b111, select_unpredictable(is_above, down, up) & 0b111]
    }
}
