//! A few contacts that stand for a patch: the nearest, and those that span most of its area.

use crate::contact::Contact;
use glam::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};

/// Which of these contacts, nearest first, stand for all: at most `limit`, at least one.
///
/// Seen along the normal: the first, the one farthest from it, and then always the one that adds most to the area of
/// the polygon of those before. Of equal ones the first is taken, and none that adds less than a rounding.
pub(super) fn points(contacts: &[Contact], normal: DVec3, limit: usize) -> SmallVec<[u32; 4]> {
    let (x, y) = normal.any_orthonormal_pair();
    let middle = |contact: &Contact| 0.5 * contact.points[0] + 0.5 * contact.points[1];
    let from_first = |contact: &Contact| middle(contact) - middle(&contacts[0]);
    let reach = contacts.iter().map(|contact| from_first(contact).abs().max_element()).fold(0.0, f64::max);
    // In a unit of which no square is too large or too small.
    let places = || contacts.iter().map(|contact| from_first(contact) / reach).map(|v| DVec2::new(x.dot(v), y.dot(v)));
    let mut chosen: SmallVec<[u32; 4]> = smallvec![0];
    // Corners of the polygon, counterclockwise once there are three.
    let mut polygon: SmallVec<[DVec2; 4]> = smallvec![DVec2::ZERO];
    while chosen.len() < limit && reach > 0.0 {
        let gains =
            places().map(|place| if chosen.len() == 1 { (place.length(), 1) } else { outside(&polygon, place) });
        let best = (0..).zip(gains).reduce(|best, other| if other.1.0 > best.1.0 { other } else { best });
        let Some((next, (_, at))) = best.filter(|(_, (gain, _))| *gain > ROUNDING) else { break };
        chosen.push(next);
        polygon.extend(places().nth(next as usize));
        polygon[at..].rotate_right(1);
    }
    chosen
}

/// What adds less than this, relative to the extent or its square, is rounding.
const ROUNDING: f64 = 1e-12;

/// The largest triangle of a point with an edge of the polygon that it is outside of, twice its area, and where in the list of
/// corners the point belongs. The two edges of a polygon of two corners run both ways.
fn outside(polygon: &[DVec2], point: DVec2) -> (f64, usize) {
    let edges = (0..polygon.len()).map(|i| {
        let (from, to) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        ((point - from).perp_dot(to - from), i + 1)
    });
    edges.fold((0.0, 0), |best, other| if other.0 > best.0 { other } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn at(x: f64, y: f64) -> Contact {
        Contact {
            triangles: [0; 2],
            points: [DVec3::new(x, y, 0.0), DVec3::new(x, y, -0.1)],
            normal: DVec3::Z,
            distance: 0.1,
            segment: None,
        }
    }

    #[test]
    fn the_nearest_and_the_corners_of_a_square() {
        let mut contacts: Vec<_> = (0..49).map(|i| at(f64::from(i % 7), f64::from(i / 7))).collect();
        // The nearest is in the middle.
        contacts.swap(0, 24);
        let mut chosen = points(&contacts, DVec3::Z, 5);
        assert_eq!(chosen[0], 0);
        chosen.sort_unstable();
        assert_eq!(chosen[..], [0, 6, 24, 42, 48], "index 24 holds what was first: a corner");
        for limit in 1..5 {
            assert_eq!(points(&contacts, DVec3::Z, limit).len(), limit);
        }
    }

    #[test]
    fn a_line_has_two_ends_and_a_point_is_alone() {
        let line: Vec<_> = (0..9).map(|i| at(0.1 * f64::from(i), 0.3 * f64::from(i))).collect();
        assert_eq!(points(&line, DVec3::Z, 4)[..], [0, 8]);
        assert_eq!(points(&[at(1.0, 2.0); 3], DVec3::Z, 4)[..], [0]);
    }
}
