//! Directions in which a push is likely to separate two surfaces, from the curves in which they
//! meet.

use super::sets::{Triangle, unit};
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual_geom::triangle_segment;

/// Work of adding a segment.
pub(super) const WORK_PER_SEGMENT: u64 = 600;

/// Sums over the segments in which triangles meet. Lengths are in units of `size`, points relative
/// to `origin`, so that products stay within the range of `f64`.
#[derive(Debug)]
pub(super) struct Segments {
    origin: DVec3,
    size: f64,
    /// Sums of the normals of A and of B, weighted by the lengths of the segments.
    normals: [DVec3; 2],
    /// Twice the vector area of the curves. For closed curves the order of the segments does not
    /// matter.
    area: DVec3,
}

impl Segments {
    pub fn new(origin: DVec3, size: f64) -> Self {
        Self {
            origin,
            size,
            normals: [DVec3::ZERO; 2],
            area: DVec3::ZERO,
        }
    }

    /// Adds the segment in which a triangle of A meets one of B.
    pub fn add(&mut self, [a, b]: &[Triangle; 2]) {
        let Some(ends) = triangle_segment(a, b) else {
            return;
        };
        let (of_a, of_b) = (normal(a), normal(b));
        let mut ends = ends.map(|end| (end - self.origin) / self.size);
        // This direction makes the segments of closed surfaces follow one another.
        if (ends[1] - ends[0]).dot(of_a.cross(of_b)) < 0.0 {
            ends.reverse();
        }
        let [p, q] = ends;
        let length = (q - p).length();
        self.normals[0] += of_a * length;
        self.normals[1] += of_b * length;
        self.area += p.cross(q);
    }

    /// Unit vectors, the most promising first.
    pub fn directions(&self) -> ArrayVec<DVec3, 4> {
        let [of_a, of_b] = self.normals;
        let likely = [of_a - of_b, self.area, -of_b, of_a].map(unit);
        let is_direction = |direction: &DVec3| *direction != DVec3::ZERO;
        likely.into_iter().filter(is_direction).collect()
    }
}

/// The unit normal by the right-hand rule; 0 for a triangle without area.
pub(super) fn normal(t: &Triangle) -> DVec3 {
    unit(unit(t[1] - t[0]).cross(unit(t[2] - t[0])))
}
