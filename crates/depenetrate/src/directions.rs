//! Directions in which a push is likely to separate two surfaces: some from the intersection curve,
//! then some spread over the sphere.

use super::blocked::unit;
use arrayvec::ArrayVec;
use glam::{DMat3, DVec3};
use punctual_geom::triangle_segment;

/// Work of adding a segment.
pub(super) const WORK_PER_SEGMENT: u64 = 600;

/// Sums over the segments in which triangles intersect. Lengths are in units of `size`, points
/// relative to `origin`, so that products stay within the range of `f64`.
#[derive(Debug)]
pub(super) struct Segments {
    origin: DVec3,
    size: f64,
    /// Sums over the segments, weighted by length: the normals of A minus those of B, and the
    /// normals of B.
    difference: DVec3,
    of_b: DVec3,
    /// Twice the vector area of the curves. Closed curves need no linking for it.
    area: DVec3,
    /// Sum of `u u^T` over the directions `u` of the segments, weighted by length.
    spread: DMat3,
    /// Box around the segments.
    min: DVec3,
    max: DVec3,
}

impl Segments {
    pub fn new(origin: DVec3, size: f64) -> Self {
        let (zero, spread) = (DVec3::ZERO, DMat3::ZERO);
        let (min, max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        Self {
            origin,
            size,
            difference: zero,
            of_b: zero,
            area: zero,
            spread,
            min,
            max,
        }
    }

    /// Adds the segment in which a triangle of A intersects one of B.
    pub fn add(&mut self, a: &[DVec3; 3], b: &[DVec3; 3]) {
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
        self.difference += (of_a - of_b) * length;
        self.of_b += of_b * length;
        self.area += p.cross(q);
        let along = unit(q - p);
        self.spread += DMat3::from_cols(along * along.x, along * along.y, along * along.z) * length;
        self.min = self.min.min(p).min(q);
        self.max = self.max.max(p).max(q);
    }

    /// Unit vectors, the most promising first.
    pub fn directions(&self) -> ArrayVec<DVec3, 4> {
        let axis = least_axis(self.spread);
        let axis = if axis.dot(self.difference) < 0.0 {
            -axis
        } else {
            axis
        };
        let likely = [self.difference, self.area, axis, -self.of_b].map(unit);
        likely
            .into_iter()
            .filter(|direction| *direction != DVec3::ZERO)
            .collect()
    }

    /// The middle of the box of the segments.
    pub fn middle(&self) -> DVec3 {
        self.origin + (self.min + self.max) * (0.5 * self.size)
    }

    /// Length of the box of the segments along a direction.
    pub fn extent(&self, direction: DVec3) -> f64 {
        let extent = direction.abs().dot(self.max - self.min) * self.size;
        if extent > 0.0 { extent } else { 0.0 }
    }
}

/// The unit normal by the right-hand rule; 0 for a triangle without area.
fn normal(t: &[DVec3; 3]) -> DVec3 {
    unit(unit(t[1] - t[0]).cross(unit(t[2] - t[0])))
}

/// Eigenvector of the least eigenvalue of a positive semidefinite symmetric matrix: powers of the
/// adjugate converge to it.
fn least_axis(m: DMat3) -> DVec3 {
    let DMat3 {
        x_axis: x,
        y_axis: y,
        z_axis: z,
    } = m;
    let mut power = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    for _ in 0..6 {
        let trace = power.x_axis.x + power.y_axis.y + power.z_axis.z;
        if trace <= 0.0 {
            return DVec3::ZERO;
        }
        power *= trace.recip();
        power = power * power;
    }
    let columns = [power.x_axis, power.y_axis, power.z_axis];
    let longest = columns
        .into_iter()
        .max_by(|p, q| p.length_squared().total_cmp(&q.length_squared()));
    longest.map_or(DVec3::ZERO, unit)
}

/// 42 directions over the sphere: the corners of a regular icosahedron and the midpoints of its
/// edges, 31 to 36 degrees apart.
pub(super) fn all_around() -> [DVec3; 42] {
    const PHI: f64 = 1.618_033_988_749_895;
    const SEEDS: [[f64; 3]; 7] = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, PHI],
        [0.0, 1.0, -PHI],
        [1.0, PHI, PHI * PHI],
        [1.0, PHI, -PHI * PHI],
        [1.0, -PHI, PHI * PHI],
        [1.0, -PHI, -PHI * PHI],
    ];
    core::array::from_fn(|i| {
        let [x, y, z] = SEEDS[i / 6];
        let turned = [[x, y, z], [y, z, x], [z, x, y]][i % 3];
        unit(DVec3::from_array(turned)) * if i % 6 < 3 { 1.0 } else { -1.0 }
    })
}
