//! Traces the curve along which two surfaces meet, from one pair of triangles to the next, without
//! intersection tests.
//!
//! An edge of one triangle certainly crosses the other triangle, the face. That edge also belongs
//! to the neighbor behind it. So the neighbor meets the face too, along a segment that begins at
//! the edge. The new corner of the neighbor is above or below the plane of the face, so one of its
//! two other edges crosses that plane.
//! - If that edge passes inside all three edges of the face, it crosses the face, and the curve
//!   continues behind it.
//! - If it passes outside one edge of the face, the segment leaves the face across that edge, which
//!   therefore crosses the neighbor. The two triangles change roles.
//! - If it passes outside two edges of the face, the segment leaves across one of these. The corner
//!   that both edges share lies on one side of the neighbor's plane; this side determines which
//!   edge it is.
//!
//! All values are computed in `f64` from the exact vertices, and only certain signs count.
//! `docs/numerics.md` has the bounds and the proof. The case cannot be predicted, so the code does
//! not branch: it computes all cases and selects the result from tables.

use super::exact::{LARGEST_EXTENT, PADDING};
use crate::lanes::{Column, D4, Lanes, cross, dot, per_axis, unrolled};
use core::hint::select_unpredictable;
use glam::DVec3;

/// A number for each corner of a triangle; the last entry is unused.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Row([f64; 4]);

/// A triangle, stored by axis.
#[derive(Clone, Debug)]
struct Side {
    corners: [Row; 3],
    /// A normal, repeated for each corner.
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

/// Two triangles, and an edge of one that certainly crosses the other.
#[derive(Clone, Debug)]
pub struct Curve {
    sides: [Side; 2],
    /// Error bound of every height and volume.
    error: f64,
    /// Index of the triangle that has the edge.
    side: usize,
    edge: Edge,
}

/// An edge that crosses a plane, as three corners of its triangle, two bits each: the end above the
/// plane, the end below it, and the apex, which is not on the edge. Bit 6 is set if the edge is
/// even: the triangle's corner after the end above is the end below.
#[derive(Clone, Copy, Debug)]
pub struct Edge(u8);

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

/// Lane mask of each corner.
const CORNER: [Row; 4] = {
    const ALL: f64 = f64::from_bits(u64::MAX);
    [
        Row([ALL, 0.0, 0.0, 0.0]),
        Row([0.0, ALL, 0.0, 0.0]),
        Row([0.0, 0.0, ALL, 0.0]),
        Row([0.0; 4]),
    ]
};

/// The other edge of the triangle that crosses the plane. First index: the known edge. Second
/// index: 1 if the apex is above the plane, else 0.
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

/// The edge of the face through which the curve leaves it. First index: 1 if the edge through which
/// the curve came is even, else 0. Second index: the edges that the neighbor's line passes outside
/// of, one bit each for 01, 12 and 20. Third index: the corners of the face on the negative side of
/// the neighbor's plane, one bit each.
const LEAVING: [[[Edge; 8]; 8]; 2] = {
    let mut leaving = [[[Edge(0); 8]; 8]; 2];
    let mut i = 0;
    while i < 2 * 64 {
        let (is_even, outside, below) = (i >> 6, i >> 3 & 7, i & 7);
        // `first` is the only edge, or the first of two adjacent edges. `between` is the corner
        // after it, which both share.
        let first = [0, 0, 1, 0, 2, 2, 1, 0][outside];
        let between = (first + 1) % 3;
        let edge = if outside.count_ones() == 2 && below >> between & 1 == 0 {
            between
        } else {
            first
        };
        // Seen along the curve, the edge through which it came points down. That determines the
        // direction around the corners.
        let ends = [edge, (edge + 1) % 3];
        leaving[is_even][outside][below] = Edge::new(ends[1 - is_even], ends[is_even]);
        i += 1;
    }
    leaving
};

/// [`Side::turn`] of the neighbor behind an edge. Index 1 if the edge is even, else 0.
static TURN: [f64; 2] = [-1.0, 1.0];

/// The corner that two edges share, as a bit mask. The index has the bits of both edges. 0 for any
/// other number of edges.
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

    /// Sets both triangles. `size` is an upper bound, along each axis, of the distance between any
    /// two points of the two surfaces where they meet.
    #[inline(always)]
    pub fn place<L: Lanes>(&mut self, corners: [[D4<L>; 3]; 2], size: f64) {
        let size = size + PADDING;
        self.error = if size < LARGEST_EXTENT {
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

    /// Begins at the edge between corners `edge` and `edge + 1` of `side`. This edge certainly
    /// crosses the triangle on the other side. Call [`place`](Self::place) before. Returns false if
    /// the continuation is uncertain.
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

    /// Mask: the sign of `x` is certain.
    #[inline(always)]
    fn certain<L: Lanes>(&self, x: D4<L>) -> D4<L> {
        D4::splat(x.lanes(), self.error).less(x.abs())
    }

    /// The side that has the edge, and the edge. The neighbor behind the edge has a new corner in
    /// place of the apex.
    #[inline(always)]
    pub fn crosses(&self) -> (usize, Edge) {
        (self.side & 1, self.edge)
    }

    /// Continues into the neighbor behind the edge. `corner` is the neighbor's corner that is not
    /// on the edge. Returns false if it is uncertain where the curve leaves the neighbor.
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
        // The two other edges of the neighbor. `up` leads from the edge's end below to the corner,
        // `down` from the corner to the end above.
        let down = per_axis!(k => D4::splat(lanes, side.corners[k].0[edge.above()]) - corner[k]);
        let up = per_axis!(k => corner[k] - D4::splat(lanes, side.corners[k].0[edge.below()]));
        let from_corner = per_axis!(k => of_face[k] - corner[k]);
        // Height of the face above the corner.
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
