//! The segment in which two triangles meet.
//!
//! Each end is a corner, or the point in which an edge of one triangle crosses the plane of the
//! other. Exact signs decide which corner or edge it is. The position along the edge comes from
//! volumes, which are exact where `f64` is in doubt. So no error is amplified: the ends are off by
//! the rounding of their coordinates, even if the triangles are thin, flat or nearly parallel.

use super::{Pair, Position, Triangle, crossing_edge, intersects, lone_corner, turned};
use arrayvec::ArrayVec;
use glam::DVec3;

/// Largest error of an end along an axis for which `f64` suffices, relative to the largest
/// coordinate. It is less than 1e-12 / sqrt 3.
const TOLERANCE: f64 = 5e-13;

/// The segment in which the closed triangles meet; see [`crate::triangle_segment`].
pub fn segment(a: &Triangle, b: &Triangle) -> Option<[DVec3; 2]> {
    let pair = Pair::with_boxes_that_meet(a, b)?;
    let position = pair.position();
    if !pair.meet(&position) {
        return None;
    }
    let largest = a
        .iter()
        .chain(b)
        .fold(0.0, |largest: f64, p| largest.max(p.abs().max_element()));
    let ends = Ends {
        pair: &pair,
        tolerance: TOLERANCE * largest,
    };
    match position {
        Position::Apart => None,
        Position::Crossing { a_sides, b_sides } => Some(ends.of_crossing(a_sides, b_sides)),
        Position::Piercing {
            segment,
            sides,
            face,
        } => Some([ends.in_plane(face, crossing_edge(segment, sides)); 2]),
        Position::Coplanar => ends.of_chord(),
    }
}

/// Computes the ends for two triangles that meet.
struct Ends<'a> {
    pair: &'a Pair<'a>,
    /// Allowed error of an end along an axis.
    tolerance: f64,
}

impl Ends<'_> {
    /// The start is the later of the points k' and i of [`Pair::crossing_meet`], and the end is the
    /// earlier of k and i'. The signs of volumes order them, as they do there.
    fn of_crossing(&self, a_sides: [i8; 3], b_sides: [i8; 3]) -> [DVec3; 2] {
        let Pair { a, b, signs, .. } = self.pair;
        let (p, a_above) = lone_corner(a_sides);
        let (r, b_above) = lone_corner(b_sides);
        let [p, q, q_last] = turned(a, p, b_above);
        let [r, s, s_last] = turned(b, r, a_above);
        let start = if signs.side([p, q_last, r], s) > 0 {
            self.in_plane(a, [r, s])
        } else {
            self.in_plane(b, [p, q_last])
        };
        let end = if signs.side([p, q, r], s_last) > 0 {
            self.in_plane(b, [p, q])
        } else {
            self.in_plane(a, [r, s_last])
        };
        [start, end]
    }

    /// The point at which an edge crosses the plane of `face`.
    fn in_plane(&self, face: &Triangle, edge: [DVec3; 2]) -> DVec3 {
        between(
            edge,
            self.pair.signs.share_to_plane(face, edge, self.share(edge)),
        )
    }

    /// The tolerance as a fraction of the largest component of the edge.
    fn share(&self, [p, q]: [DVec3; 2]) -> f64 {
        self.tolerance / (q - p).abs().max_element()
    }

    /// The two points of the common polygon that are farthest apart. Corners of this polygon are
    /// the corners of each triangle that lie in the other, and the points where edges cross.
    fn of_chord(&self) -> Option<[DVec3; 2]> {
        let Pair { a, b, extent, .. } = self.pair;
        let mut corners = ArrayVec::<DVec3, 15>::new();
        corners.extend(a.iter().copied().filter(|&p| intersects(&[p; 3], b)));
        corners.extend(b.iter().copied().filter(|&p| intersects(&[p; 3], a)));
        corners.extend((0..9).filter_map(|i| self.crossing(edge(a, i / 3), edge(b, i % 3))));
        let scale = extent.max_element();
        let mut longest = None;
        for (i, &p) in corners.iter().enumerate() {
            for &q in &corners[i..] {
                let length = if scale > 0.0 {
                    ((q - p) / scale).length_squared()
                } else {
                    0.0
                };
                if longest.is_none_or(|(longest, _)| length > longest) {
                    longest = Some((length, [p, q]));
                }
            }
        }
        longest.map(|(_, chord)| chord)
    }

    /// The point at which two edges in one plane cross, if it is inside both. In the projection
    /// along an axis that lies in the plane, all orientations are 0. Along any other axis, they are
    /// those of the plane.
    fn crossing(&self, e: [DVec3; 2], f: [DVec3; 2]) -> Option<DVec3> {
        let signs = &self.pair.signs;
        let crosses = |axis: usize, [p, q]: [DVec3; 2], points: [DVec3; 2]| {
            let [first, last] = points.map(|point| signs.turn(axis, &[p, q, point]));
            first * last < 0
        };
        let axis = (0..3).find(|&axis| crosses(axis, e, f) && crosses(axis, f, e))?;
        Some(between(e, signs.share_to_line(axis, f, e, self.share(e))))
    }
}

fn edge(t: &Triangle, i: usize) -> [DVec3; 2] {
    [t[i], t[(i + 1) % 3]]
}

/// The point at the fraction `share` of a segment, computed from the closer end. So fractions 0 and
/// 1 give the ends.
fn between([p, q]: [DVec3; 2], share: f64) -> DVec3 {
    let point = if share <= 0.5 {
        p + (q - p) * share
    } else {
        q + (p - q) * (1.0 - share)
    };
    point.clamp(p.min(q), p.max(q))
}
