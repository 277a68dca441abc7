//! Tests whether two closed triangles share a point. Exact for all finite `f64` coordinates,
//! including denormals and mixed scales.
//!
//! The decision is a case distinction on exact [`sign`]s. First come the sides of the corners
//! relative to the other plane, then two volumes if the planes differ, or separating lines if they
//! do not. A degenerate triangle is the hull of its three points: a segment or a point.
//!
//! Cost: `docs/performance.md`. It is bounded for all coordinates, and nothing is allocated.

pub mod crossing;
pub(super) mod line;
mod segment;
pub(super) mod shared;
mod sign;
mod sum;

use core::array::from_fn;

use glam::DVec3;
pub use segment::segment;
use sign::Signs;
pub(super) use sign::{LARGEST_EXTENT, PADDING};

type Triangle = [DVec3; 3];

/// True if the closed triangles `a` and `b` share a point. All coordinates must be finite.
pub fn intersects(a: &Triangle, b: &Triangle) -> bool {
    let Some(pair) = Pair::with_boxes_that_meet(a, b) else {
        return false;
    };
    if a.iter().any(|p| b.contains(p)) {
        return true;
    }
    pair.meet(&pair.position())
}

/// The side of a plane on which a point lies: see [`super::side_of_plane`].
pub fn side_of_plane(t: &Triangle, point: DVec3) -> i8 {
    let [p, q, r] = *t;
    let extent = p.max(q).max(r).max(point) - p.min(q).min(r).min(point);
    Signs::within(extent).side(*t, point)
}

/// True if all three points are strictly on one side.
fn is_strict(sides: [i8; 3]) -> bool {
    sides == [1; 3] || sides == [-1; 3]
}

/// Position of two triangles relative to each other's planes.
enum Position<'a> {
    /// One triangle is strictly on one side of the other's plane.
    Apart,
    /// The triangles lie in different planes, and neither is strictly on one side of the other's
    /// plane.
    Crossing { a_sides: [i8; 3], b_sides: [i8; 3] },
    /// A segment and a face. `sides` are the sides of the segment's three points relative to the
    /// plane of the face. They are not all 0, and not all 1 or all -1.
    Piercing {
        segment: &'a Triangle,
        sides: [i8; 3],
        face: &'a Triangle,
    },
    /// The six points lie in one plane, or both triangles are segments.
    Coplanar,
}

/// Two triangles whose boxes meet.
struct Pair<'a> {
    a: &'a Triangle,
    b: &'a Triangle,
    /// Size of the box around both.
    extent: DVec3,
    signs: Signs,
}

impl<'a> Pair<'a> {
    fn with_boxes_that_meet(a: &'a Triangle, b: &'a Triangle) -> Option<Self> {
        let (a_min, a_max) = (a[0].min(a[1]).min(a[2]), a[0].max(a[1]).max(a[2]));
        let (b_min, b_max) = (b[0].min(b[1]).min(b[2]), b[0].max(b[1]).max(b[2]));
        let meet = (a_min.cmple(b_max) & b_min.cmple(a_max)).all();
        let extent = a_max.max(b_max) - a_min.min(b_min);
        meet.then(|| Self {
            a,
            b,
            extent,
            signs: Signs::within(extent),
        })
    }

    fn meet(&self, position: &Position) -> bool {
        match *position {
            Position::Apart => false,
            Position::Crossing { a_sides, b_sides } => self.crossing_meet(a_sides, b_sides),
            Position::Piercing {
                segment,
                sides,
                face,
            } => self.segment_meets(segment, sides, face),
            Position::Coplanar => self.coplanar_meet(),
        }
    }

    fn position(&self) -> Position<'a> {
        let Self {
            a,
            b,
            extent,
            ref signs,
        } = *self;
        if extent.min_element() == 0.0 {
            return Position::Coplanar;
        }
        let a_sides = signs.sides(b, a);
        if is_strict(a_sides) {
            return Position::Apart;
        }
        let b_sides = signs.sides(a, b);
        if is_strict(b_sides) {
            return Position::Apart;
        }
        match (a_sides == [0; 3], b_sides == [0; 3]) {
            (false, false) => Position::Crossing { a_sides, b_sides },
            // `b` spans a plane, because `a` has sides of it. If `a` spanned one too, `b` would lie
            // in it, the planes would be the same, and `a` would have no sides. So `a` is a
            // segment, and not in the plane of `b`.
            (false, true) => Position::Piercing {
                segment: a,
                sides: a_sides,
                face: b,
            },
            (true, false) => Position::Piercing {
                segment: b,
                sides: b_sides,
                face: a,
            },
            (true, true) => Position::Coplanar,
        }
    }

    /// Decides two proper triangles in different planes, neither strictly on one side of the other.
    ///
    /// Each meets the other's plane, so the planes share a line L, directed by `d = n_a x n_b`. Let
    /// P be the corner of `a` that is alone on one side of plane B, and orient B so that this side
    /// is above. Likewise let R be the corner of `b` that is alone above plane A. Edges PQ and PQ'
    /// of `a` = PQQ' cross L at k and k', edges RS and RS' of `b` = RSS' at i and i'. Then
    /// - `a` covers [k', k] of L in the direction d, because `(k' - k) . d` is `|k' - k|^2` times a
    ///   number <= 0; `b` covers [i, i'], because for `b` the normals swap roles, which reverses d;
    /// - the volume `det(Q - P, R - P, S - P) = det(Q - P, i - k, S - R)` is the step from k to i
    ///   along d, times `((Q - P) . n_b) ((S - R) . n_a)`, which is positive because both edges go
    ///   down: its sign orders i and k.
    ///
    /// So they meet if and only if i <= k and k' <= i'.
    fn crossing_meet(&self, a_sides: [i8; 3], b_sides: [i8; 3]) -> bool {
        let (p, a_above) = lone_corner(a_sides);
        let (r, b_above) = lone_corner(b_sides);
        let [p, q, q_last] = turned(self.a, p, b_above);
        let [r, s, s_last] = turned(self.b, r, a_above);
        self.signs.side([p, q, r], s) <= 0 && self.signs.side([p, q_last, r], s_last) >= 0
    }

    /// Decides a segment `s` (a degenerate triangle) outside the plane of the proper triangle `t`.
    /// The points of `s` have these `sides`, and not all are strictly on one side. The line of `s`
    /// crosses the plane in one point. That point is in `t` if the line does not pass two edges of
    /// `t` on different sides.
    fn segment_meets(&self, s: &Triangle, sides: [i8; 3], t: &Triangle) -> bool {
        let [p, q] = crossing_edge(s, sides);
        let passes: [i8; 3] = from_fn(|i| self.signs.side([p, q, t[i]], t[(i + 1) % 3]));
        !(passes.contains(&1) && passes.contains(&-1))
    }

    /// Decides six points in one plane, or two segments.
    ///
    /// A projection along an axis is injective on a plane if it maps any area in the plane to a
    /// nonzero area. If neither triangle has an area along any axis, both are segments or points.
    /// They are apart if skew. Otherwise they lie in one plane, and the projection along at least
    /// one axis is injective on it. A projection never separates what meets, so they meet if and
    /// only if they do along all axes.
    fn coplanar_meet(&self) -> bool {
        let Pair {
            a,
            b,
            extent,
            signs,
        } = self;
        let thin = (0..3)
            .find(|&axis| extent[axis] == extent.min_element())
            .unwrap_or(0);
        for axis in [thin, (thin + 1) % 3, (thin + 2) % 3] {
            let (a_turn, b_turn) = (signs.turn(axis, a), signs.turn(axis, b));
            if a_turn != 0 || b_turn != 0 {
                return !self.separates(axis, a, a_turn, b) && !self.separates(axis, b, b_turn, a);
            }
        }
        let skew =
            |i: usize| signs.side([a[i / 3], a[(i / 3 + 1) % 3], b[i % 3]], b[(i + 1) % 3]) != 0;
        !(0..9).any(skew)
            && (0..3).all(|axis| !self.separates(axis, a, 0, b) && !self.separates(axis, b, 0, a))
    }

    /// True if all of `t`, projected along `axis`, is strictly on the outer side of an edge of `s`.
    /// `turn` is the orientation of `s`.
    ///
    /// Two closed convex sets in a plane are apart in two cases only. In the first, the line along
    /// an edge of one of them separates them: every edge of their Minkowski difference is parallel
    /// to an edge of one of them, and both sides of a segment are outer sides. In the second, both
    /// lie on one line and their boxes are apart. The second case does not occur here, because the
    /// boxes meet.
    fn separates(&self, axis: usize, s: &Triangle, turn: i8, t: &Triangle) -> bool {
        (0..3).any(|i| {
            let side = |p: DVec3| self.signs.turn(axis, &[s[i], s[(i + 1) % 3], p]);
            let first = side(t[0]);
            first != 0 && first != turn && side(t[1]) == first && side(t[2]) == first
        })
    }
}

/// Two corners on different sides. The sides must not be equal for all three corners.
fn crossing_edge(s: &Triangle, sides: [i8; 3]) -> [DVec3; 2] {
    [s[0], if sides[0] == sides[1] { s[2] } else { s[1] }]
}

/// The corner that is alone on its side of a plane, and the side that counts as above: 1 or -1. The
/// sides of the corners must not be all 1, all -1 or all 0. A corner in the plane is taken only if
/// both others are strictly on one side; it counts as opposite to them.
fn lone_corner(sides: [i8; 3]) -> (usize, i8) {
    let others = |i: usize| [sides[(i + 1) % 3], sides[(i + 2) % 3]];
    let lone = (0..3).find(|&i| sides[i] != 0 && !others(i).contains(&sides[i]));
    let zero = || (0..3).find(|&i| sides[i] == 0).unwrap_or(0);
    lone.map_or_else(|| (zero(), -others(zero())[0]), |i| (i, sides[i]))
}

/// The triangle from its corner `first` on, in reverse order if `direction` is negative.
fn turned(t: &Triangle, first: usize, direction: i8) -> Triangle {
    let [q, r] = [t[(first + 1) % 3], t[(first + 2) % 3]];
    if direction < 0 {
        [t[first], r, q]
    } else {
        [t[first], q, r]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lone_corners() {
        assert_eq!(lone_corner([1, -1, -1]), (0, 1));
        assert_eq!(lone_corner([1, 1, -1]), (2, -1));
        assert_eq!(lone_corner([0, 0, -1]), (2, -1));
        assert_eq!(lone_corner([1, 0, 1]), (1, -1));
        assert_eq!(lone_corner([-1, -1, 0]), (2, 1));
        assert_eq!(lone_corner([0, 1, -1]), (1, 1));
    }
}
