//! Triangles of one surface, which share corners: whether they meet beyond what they share.
//!
//! Corners are shared if their positions are equal. Two triangles meet beyond what they share if
//! all three corners are shared, or if a common point is outside the hull of the shared corners.

use super::sign::Signs;
use super::{Triangle, intersects};
use arrayvec::ArrayVec;
use glam::DVec3;

type Points = ArrayVec<DVec3, 3>;

/// Whether two triangles meet beyond what they share, exactly.
pub fn intersects_beyond_shared(a: &Triangle, b: &Triangle) -> bool {
    let (a, b) = (distinct(a), distinct(b));
    let (shared, of_a): (Points, Points) = a.into_iter().partition(|p| b.contains(p));
    let of_b: Points = b.into_iter().filter(|p| !shared.contains(p)).collect();
    match (&*shared, &*of_a, &*of_b) {
        ([], ..) => intersects(&hull(&of_a), &hull(&of_b)),
        ([p], [_, ..], [_, ..]) => meet_beyond_corner(*p, &of_a, &of_b),
        ([p, q], [r], [s]) => meet_beyond_edge([*p, *q], *r, *s),
        ([_, _, _], ..) => true,
        // One triangle is within what they share.
        _ => false,
    }
}

fn distinct(corners: &Triangle) -> Points {
    let mut points = Points::new();
    for &corner in corners {
        if !points.contains(&corner) {
            points.push(corner);
        }
    }
    points
}

/// One to three points as a triangle.
fn hull(points: &[DVec3]) -> Triangle {
    [0, 1, 2].map(|i| points[i.min(points.len() - 1)])
}

/// Two triangles that share the corner `p` only. `a` and `b` are their other corners.
///
/// Take a common point besides `p`, and the last common point on the ray from `p` through it. There
/// the ray leaves one of the triangles, so the point is on the side opposite to `p`. If that side
/// does not contain `p`, any common point on it is beyond `p`. If it does, the triangle is two
/// segments from `p`.
fn meet_beyond_corner(p: DVec3, a: &[DVec3], b: &[DVec3]) -> bool {
    for (side, other) in [(a, b), (b, a)] {
        if let [q, r] = *side
            && intersects(&[p; 3], &[q, r, r])
        {
            return meet_beyond_corner(p, &[q], other) || meet_beyond_corner(p, &[r], other);
        }
    }
    let whole = |side: &[DVec3]| [p, side[0], side[side.len() - 1]];
    intersects(&hull(a), &whole(b)) || intersects(&hull(b), &whole(a))
}

/// Two triangles that share an edge only. `r` and `s` are their other corners.
///
/// Triangles with an area meet beyond the edge if they are coplanar and on the same side of it. A
/// segment meets a triangle with an area in the edge only, because it lies on the edge's line. Two
/// segments meet beyond the edge if both extend it at the same end.
fn meet_beyond_edge([p, q]: [DVec3; 2], r: DVec3, s: DVec3) -> bool {
    let signs = Signs::within(p.max(q).max(r).max(s) - p.min(q).min(r).min(s));
    if signs.side([p, q, r], s) != 0 {
        return false;
    }
    let turns = [0, 1, 2].map(|axis| [r, s].map(|apex| signs.turn(axis, &[p, q, apex])));
    if let Some([r, s]) = turns.iter().find(|turns| !turns.contains(&0)) {
        return r == s;
    }
    let axis = (0..3).find(|&k| p[k] != q[k]).unwrap_or(0);
    let end = |x: DVec3| {
        i8::from(x[axis] > p[axis].max(q[axis])) - i8::from(x[axis] < p[axis].min(q[axis]))
    };
    turns == [[0; 2]; 3] && end(r) == end(s) && end(r) != 0
}
