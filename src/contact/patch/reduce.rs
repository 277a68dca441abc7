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
    let origin = contacts[0].points[0];
    let place = |i: u32| {
        let from = 0.5 * (contacts[i as usize].points[0] - origin) + 0.5 * (contacts[i as usize].points[1] - origin);
        DVec2::new(x.dot(from), y.dot(from))
    };
    let mut chosen: SmallVec<[u32; 4]> = smallvec![0];
    let all = 0..contacts.len() as u32;
    let Some((second, farthest)) = largest(all.clone().map(|i| place(i).distance(place(0)))) else { return chosen };
    if limit > 1 && farthest > 0.0 {
        chosen.push(second);
    }
    // Corners of the polygon, counterclockwise once there are three.
    let mut polygon = chosen.clone();
    while polygon.len() > 1 && chosen.len() < limit {
        let gain = |i: u32| outside(&polygon, place(i), place);
        let Some((next, (area, at))) = all
            .clone()
            .map(|i| (i, gain(i)))
            .reduce(|best, other| if other.1.0 > best.1.0 { other } else { best })
            .filter(|(_, (area, _))| *area > ROUNDING * farthest * farthest)
        else {
            break;
        };
        debug_assert!(area.is_finite());
        chosen.push(next);
        polygon.insert(at, next);
    }
    chosen
}

/// Areas below this, relative to the square of the extent, are rounding.
const ROUNDING: f64 = 1e-12;

/// The first of the largest values, and which it is.
fn largest(values: impl Iterator<Item = f64>) -> Option<(u32, f64)> {
    (0..).zip(values).reduce(|best, other| if other.1 > best.1 { other } else { best })
}

/// The largest triangle of a point with an edge of the polygon that it is outside of, twice its area, and where in the list of
/// corners the point belongs. The two edges of a polygon of two corners run both ways.
fn outside(polygon: &[u32], point: DVec2, place: impl Fn(u32) -> DVec2) -> (f64, usize) {
    let edges = (0..polygon.len()).map(|i| {
        let (from, to) = (place(polygon[i]), place(polygon[(i + 1) % polygon.len()]));
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
