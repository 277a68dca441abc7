//! Where a ray along an axis crosses a triangle, exactly and without ties.
//!
//! The ray starts at a point `q` and goes along `d = (s, e, e^2)`: the axis with its sign `s`, then
//! the axes after it in cyclic order, for an `e > 0` that is smaller than any number that occurs.
//! On which side it passes the edge from `p` to `r` is the sign of `d . ((p - q) x (r - q))`, which
//! is the sign of the first component that is not zero. All three are zero only if `q` is on the
//! line through `p` and `r`. So the ray meets no edge and no corner of a triangle that does not
//! hold `q`: it crosses the triangle inside, or misses it, and nothing has to be cast again.

use super::sign::Signs;
use glam::DVec3;

/// A direction along a coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heading {
    pub axis: usize,
    pub is_negative: bool,
}

impl Heading {
    /// The unit vector.
    pub fn vector(self) -> DVec3 {
        let mut vector = DVec3::ZERO;
        vector[self.axis] = if self.is_negative { -1.0 } else { 1.0 };
        vector
    }
}

/// How a ray crosses a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossing {
    Missed,
    /// The triangle holds the origin.
    Origin,
    /// The ray leaves through the front: it hits the back.
    Leaves,
    Enters,
}

/// The signs of determinants of some points and `q`.
fn signs<const N: usize>(q: DVec3, points: &[DVec3; N]) -> Signs {
    let (mut min, mut max) = (q, q);
    for &point in points {
        (min, max) = (min.min(point), max.max(point));
    }
    Signs::within(max - min)
}

/// The side on which the line passes the edge from `p` to `r`: 1 if it turns counterclockwise about
/// the direction, 0 only if `q` is on the line through `p` and `r`.
pub fn side(q: DVec3, heading: Heading, ends: [DVec3; 2]) -> i8 {
    side_with(&signs(q, &ends), q, heading, ends)
}

fn side_with(signs: &Signs, q: DVec3, heading: Heading, [p, r]: [DVec3; 2]) -> i8 {
    let turn = |axis: usize| signs.turn(axis % 3, &[q, p, r]);
    let first = turn(heading.axis);
    if first != 0 {
        return if heading.is_negative { -first } else { first };
    }
    match turn(heading.axis + 1) {
        0 => turn(heading.axis + 2),
        second => second,
    }
}

/// How the ray from `q` crosses a triangle.
#[cold]
pub fn crossing(q: DVec3, heading: Heading, corners: &[DVec3; 3]) -> Crossing {
    let signs = signs(q, corners);
    let [a, b, c] = *corners;
    // The side to which the normal points.
    let above = signs.side(*corners, q);
    if above == 0 {
        return if holds(&signs, q, corners) {
            Crossing::Origin
        } else {
            Crossing::Missed
        };
    }
    let passes = |ends| side_with(&signs, q, heading, ends) == -above;
    if passes([a, b]) && passes([b, c]) && passes([c, a]) {
        if above < 0 {
            Crossing::Leaves
        } else {
            Crossing::Enters
        }
    } else {
        Crossing::Missed
    }
}

/// True if a triangle holds a point in its plane. A degenerate one is the hull of its corners.
fn holds(signs: &Signs, q: DVec3, &[a, b, c]: &[DVec3; 3]) -> bool {
    let mut is_on_line = true;
    for axis in 0..3 {
        let turns = [[a, b], [b, c], [c, a]].map(|[p, r]| signs.turn(axis, &[q, p, r]));
        if turns.contains(&1) && turns.contains(&-1) {
            return false;
        }
        is_on_line &= turns == [0; 3];
    }
    // A point that is on one line with all corners must be between them.
    !is_on_line || q.cmpge(a.min(b).min(c)).all() && q.cmple(a.max(b).max(c)).all()
}
