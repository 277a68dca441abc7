//! A point and a triangle in `f64`: the closest point, and both bounds.
//!
//! The region of the triangle that is closest (corner, edge, face) proposes a point and a
//! direction. Both bounds follow from them as for [one pair](super::pair). If the region was wrong,
//! the bounds are not tight, and there is no result.

use super::clamped;
use super::pair::{Closest, Pair};
use glam::DVec3;

/// Closest point of a closed triangle to `point`, and `point`, with tight bounds of the distance.
/// `None` where only [`closest_or_meeting`](super::closest_or_meeting) finds them.
#[inline(always)]
pub fn closest_to_point(triangle: &[DVec3; 3], point: DVec3) -> Option<Closest> {
    let pair = Pair::new(triangle, &[point; 3]);
    let to = pair.b[0];
    let (foot, direction) = region(&pair.a, to);
    let high = pair.high([foot, to]);
    let (low, direction) = pair.low(direction);
    pair.is_tight(low, high).then(|| Closest {
        points: [pair.origin + foot * pair.unit, point],
        direction,
        low,
        high,
        is_tight: true,
    })
}

/// The closest point of a triangle, whose first corner is the origin, and the direction between
/// that region and `q`.
#[inline(always)]
fn region([_, b, c]: &[DVec3; 3], q: DVec3) -> (DVec3, DVec3) {
    let (to_b, to_c) = (q - *b, q - *c);
    let [at_a, at_b, at_c] = [q, to_b, to_c].map(|from| [b.dot(from), c.dot(from)]);
    if at_a[0] <= 0.0 && at_a[1] <= 0.0 {
        return (DVec3::ZERO, q);
    }
    if at_b[0] >= 0.0 && at_b[1] <= at_b[0] {
        return (*b, to_b);
    }
    let on_c = at_a[0] * at_b[1] - at_b[0] * at_a[1];
    if on_c <= 0.0 && at_a[0] >= 0.0 && at_b[0] <= 0.0 {
        let foot = *b * clamped(at_a[0] / (at_a[0] - at_b[0]));
        return (foot, across(*b, q - foot));
    }
    if at_c[1] >= 0.0 && at_c[0] <= at_c[1] {
        return (*c, to_c);
    }
    let on_b = at_c[0] * at_a[1] - at_a[0] * at_c[1];
    if on_b <= 0.0 && at_a[1] >= 0.0 && at_c[1] <= 0.0 {
        let foot = *c * clamped(at_a[1] / (at_a[1] - at_c[1]));
        return (foot, across(*c, q - foot));
    }
    let on_a = at_b[0] * at_c[1] - at_c[0] * at_b[1];
    let (towards_c, towards_b) = (at_b[1] - at_b[0], at_c[0] - at_c[1]);
    if on_a <= 0.0 && towards_c >= 0.0 && towards_b >= 0.0 {
        let share = clamped(towards_c / (towards_c + towards_b));
        let foot = *b * (1.0 - share) + *c * share;
        return (foot, across(*c - *b, q - foot));
    }
    let whole = on_a + on_b + on_c;
    let s = clamped(on_b / whole);
    let t = clamped(on_c / whole).min(1.0 - s);
    (*b * s + *c * t, b.cross(*c))
}

/// A vector without its component along an edge.
fn across(edge: DVec3, vector: DVec3) -> DVec3 {
    vector - edge * (vector.dot(edge) / edge.length_squared())
}
