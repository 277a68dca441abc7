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
//! and the proof. Which of these it is cannot be guessed, so there are no branches between them: all is computed, and tables
//! tell what follows.

use super::exact::{LARGEST, PADDING};
use crate::math::lanes::{Column, D4, Lanes, cross, dot, per_axis, unrolled};
use core::hint::select_unpredictable;
use glam::DVec3;

/// A number for each corner of a triangle; the last one is not used.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Row([f64; 4]);

/// A triangle, axis by axis.
#[derive(Clone, Debug)]
struct Side {
    corners: [Row; 3],
    /// A normal, the same for each corner.
    normal: [Row; 3],
    /// 1 if the corners go around the normal counterclockwise, -1 if clockwise.
    turn: f64,
}

impl Side {
    const ORIGIN: Self = Self {
        corners: [Row([0.0; 4]); 3],
        normal: [Row([0.0; 4]); 3],
        turn: 1.0,
    };
}

#[inline(always)]
fn load<L: Lanes>(lanes: L, rows: &[Row; 3]) -> [D4<L>; 3] {
    per_axis!(k => D4::load(lanes, &rows[k].0))
}

/// An edge of the triangle on one side that certainly crosses the triangle on the other.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    sides: [Side; 2],
    /// By how much a height or a volume may be off.
    error: f64,
    /// Whose edge it is.
    side: usize,
    edge: Edge,
}

/// An edge that crosses a plane. Two bits for each corner of its triangle: the end above the plane, the end below it, and the
/// apex, which is not on the edge; and bit 6 if they follow each other in this order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge(u8);

impl Edge {
    const fn new(above: usize, below: usize) -> Self {
        let is_even = (above + 1) % 3 == below;
        Self((above | below << 2 | (3 - above - below) << 4 | (is_even as usize) << 6) as u8)
    }
    #[inline(always)]
    const fn above(self) -> usize {
        (self.0 & 3) as usize
    }
    #[inline(always)]
    const fn below(self) -> usize {
        (self.0 >> 2 & 3) as usize
    }
    #[inline(always)]
    pub const fn apex(self) -> usize {
        (self.0 >> 4 & 3) as usize
    }
    #[inline(always)]
    const fn is_even(self) -> usize {
        (self.0 >> 6) as usize
    }
}

/// The lane of a corner.
const CORNER: [Row; 4] = {
    const ALL: f64 = f64::from_bits(u64::MAX);
    [
        Row([ALL, 0.0, 0.0, 0.0]),
        Row([0.0, ALL, 0.0, 0.0]),
        Row([0.0, 0.0, ALL, 0.0]),
        Row([0.0; 4]),
    ]
};

/// The other edge that crosses the plane, by the one that does and by whether the apex is above it.
const OTHER: [[Edge; 2]; 128] = {
    let mut other = [[Edge(0); 2]; 128];
    let mut i = 0;
    while i < 6 {
        let (above, below) = (i / 2, (i / 2 + 1 + i % 2) % 3);
        let apex = 3 - above - below;
        other[Edge::new(above, below).0 as usize] =
            [Edge::new(above, apex), Edge::new(apex, below)];
        i += 1;
    }
    other
};

/// The edge of the face through which the curve leaves it: by whether the one that it came through is even, by the edges that
/// the neighbor's line passes outside of (a bit each for 01, 12 and 20), and by the corners of the face that are below the
/// neighbor's normal.
const LEAVING: [[[Edge; 8]; 8]; 2] = {
    let mut leaving = [[[Edge(0); 8]; 8]; 2];
    let mut i = 0;
    while i < 2 * 64 {
        let (is_even, outside, below) = (i >> 6, i >> 3 & 7, i & 7);
        // Of two edges the first, and the corner between them.
        let first = [0, 0, 1, 0, 2, 2, 1, 0][outside];
        let between = (first + 1) % 3;
        let edge = if outside.count_ones() == 2 && below >> between & 1 == 0 {
            between
        } else {
            first
        };
        // Seen along the curve, the edge that it came through points down; so that tells which way the corners go around.
        let ends = [edge, (edge + 1) % 3];
        leaving[is_even][outside][below] = Edge::new(ends[1 - is_even], ends[is_even]);
        i += 1;
    }
    leaving
};

/// [`Side::turn`] by whether the edge is even.
static TURN: [f64; 2] = [-1.0, 1.0];

/// The corner, a bit, between two of the edges that the line passes outside of.
const BETWEEN: [u32; 8] = [0, 0, 0, 0b010, 0, 0b001, 0b100, 0];

/// Relative rounding of one `f64` operation: 2^-53.
const ROUNDING: f64 = f64::EPSILON / 2.0;

impl Curve {
    pub const NOWHERE: Self = Self {
        sides: [Side::ORIGIN; 2],
        error: 0.0,
        side: 0,
        edge: Edge(0),
    };

    /// Places both triangles. No two points of the two surfaces, where they meet, are farther apart along an axis than `size`.
    #[inline(always)]
    pub fn place<L: Lanes>(&mut self, corners: [[D4<L>; 3]; 2], size: f64) {
        let size = size + PADDING;
        self.error = if size < LARGEST {
            80.0 * ROUNDING * size * size * size
        } else {
            f64::INFINITY
        };
        for (to, corners) in self.sides.iter_mut().zip(&corners) {
            let [p, q, r] = per_axis!(i => DVec3::from_slice(&corners[i].store()));
            let normal = (q - p).cross(r - p).to_array();
            to.corners = per_axis!(k => Row([p[k], q[k], r[k], 0.0]));
            to.normal = per_axis!(k => Row([normal[k]; 4]));
            to.turn = 1.0;
        }
    }

    /// Begins where the triangles were placed, at an edge, between corners `edge` and `edge + 1` of one side, that certainly
    /// crosses the triangle on the other. False if it is not certain how it goes on.
    #[inline(always)]
    pub fn begin<L: Lanes>(&mut self, lanes: L, side: usize, edge: usize) -> bool {
        let [side, other] = [side & 1, (side & 1) ^ 1];
        let (of_side, face) = (&self.sides[side].corners, &self.sides[other]);
        let (of_face, normal) = (load(lanes, &face.corners), load(lanes, &face.normal));
        let ends = [edge % 3, (edge + 1) % 3];
        let heights = unrolled!(i in [0, 1] => {
            dot(per_axis!(k => D4::splat(lanes, of_side[k].0[ends[i]]) - of_face[k]), normal)
        });
        let is_down = heights[1].mask() & 1 != 0;
        self.side = side;
        self.edge = if is_down {
            Edge::new(ends[0], ends[1])
        } else {
            Edge::new(ends[1], ends[0])
        };
        self.certain(heights[0])
            .and(self.certain(heights[1]))
            .mask()
            & (heights[0].mask() ^ heights[1].mask())
            & 7
            == 7
    }

    /// Where the sign of a number is certain.
    #[inline(always)]
    fn certain<L: Lanes>(&self, x: D4<L>) -> D4<L> {
        D4::splat(x.lanes(), self.error).less(x.abs())
    }

    /// The side whose edge it is, and the edge, whose apex gives way to the corner of the neighbor.
    #[inline(always)]
    pub fn crosses(&self) -> (usize, Edge) {
        (self.side & 1, self.edge)
    }

    /// Goes on into the neighbor behind the edge, which has this corner in place of the apex. False if it is not certain where
    /// the curve leaves it.
    #[inline(always)]
    pub fn advance<L: Lanes>(
        &mut self,
        lanes: L,
        (at, edge): (usize, Edge),
        corner: D4<L>,
    ) -> bool {
        let corner = per_axis!(k => corner.spread(k));
        let [side, face] = [&self.sides[at & 1], &self.sides[(at & 1) ^ 1]];
        let (of_side, of_face) = (load(lanes, &side.corners), load(lanes, &face.corners));
        // From the end above down to the corner, and from the corner down to the end below.
        let down = per_axis!(k => D4::splat(lanes, side.corners[k].0[edge.above()]) - corner[k]);
        let up = per_axis!(k => corner[k] - D4::splat(lanes, side.corners[k].0[edge.below()]));
        let from_corner = per_axis!(k => of_face[k] - corner[k]);
        // How high the face is above the corner.
        let height = dot(from_corner, load(lanes, &face.normal)) * D4::splat(lanes, face.turn);
        let is_up = height.less(D4::splat(lanes, 0.0));
        let volumes = cross(from_corner, per_axis!(k => from_corner[k].turned()));
        let volumes = is_up.select(dot(up, volumes), dot(down, volumes));
        let normal = cross(up, down);
        let heights = dot(from_corner, normal);
        let is_it = D4::load(lanes, &CORNER[edge.apex()].0);
        let side = &mut self.sides[at & 1];
        side.corners = per_axis!(k => Row(is_it.select(corner[k], of_side[k]).store()));
        side.normal = per_axis!(k => Row(normal[k].store()));
        side.turn = TURN[edge.is_even() & 1];
        let outside = volumes.mask() as usize & 7;
        let is_certain = self.certain(volumes).and(self.certain(height)).mask()
            & (self.certain(heights).mask() | !BETWEEN[outside]);
        let turned = LEAVING[edge.is_even() & 1][outside][heights.mask() as usize & 7];
        let other = OTHER[usize::from(edge.0 & 127)][is_up.mask() as usize & 1];
        self.edge = select_unpredictable(outside == 0, other, turned);
        self.side = at ^ usize::from(outside != 0);
        is_certain & 7 == 7
    }
}
