//! Two triangles.

use crate::pose::punctual_point;
use crate::status::{Fault, given};
use crate::verbs::{calls, types};
use core::mem::MaybeUninit;
use punctual::glam::DVec3;

/// 2^1000, the largest coordinate of a mesh.
const COORDINATE_LIMIT: f64 = f64::from_bits((1023 + 1000) << 52);

types! {
    /// Three corners, each x, y, z.
    plain punctual_triangle {
        /// Corner by corner.
        corners: [[f64; 3]; 3],
    }

    /// Two points and what is between them.
    plain punctual_segment {
        /// One end.
        from: punctual_point,
        /// The other one.
        to: punctual_point,
    }
}

impl punctual_triangle {
    fn check(&self, what: &'static str) -> Result<[DVec3; 3], Fault> {
        let bad = |c: &&f64| c.is_nan() || c.abs() > COORDINATE_LIMIT;
        match self.corners.as_flattened().iter().find(bad) {
            Some(&coordinate) => Err(Fault::Number(what, coordinate)),
            None => Ok(self.corners.map(DVec3::from_array)),
        }
    }
}

calls! {
    /// Whether two closed triangles share at least one point, exactly for the given coordinates.
    /// Touching is intersecting; a degenerate triangle is the segment or point that it is.
    ///
    /// Fails with BAD_ARGUMENT if a coordinate is not finite or exceeds 2^1000.
    fn punctual_triangles_intersect(
        a: punctual_triangle, b: punctual_triangle, intersect: Option<&mut MaybeUninit<bool>>
    ) {
        let intersect = given(intersect, "intersect")?;
        let (a, b) = (a.check("a coordinate of a")?, b.check("a coordinate of b")?);
        intersect.write(punctual::geom::triangles_intersect(&a, &b));
        Ok(())
    }

    /// The segment in which two closed triangles meet. `meet` says whether they do; if not,
    /// `segment`, two points, is left alone. Of triangles that touch in a point both ends are that
    /// point; of triangles in one plane it is the longest segment in both. Ends are within 1e-12
    /// times the largest coordinate of both triangles.
    ///
    /// Fails with BAD_ARGUMENT if a coordinate is not finite or exceeds 2^1000.
    fn punctual_triangle_segment(
        a: punctual_triangle, b: punctual_triangle,
        segment: Option<&mut MaybeUninit<punctual_segment>>, meet: Option<&mut MaybeUninit<bool>>
    ) {
        let (segment, meet) = (given(segment, "segment")?, given(meet, "meet")?);
        let (a, b) = (a.check("a coordinate of a")?, b.check("a coordinate of b")?);
        let found = punctual::geom::triangle_segment(&a, &b);
        meet.write(found.is_some());
        found.map(|[from, to]| {
            segment.write(punctual_segment {
                from: from.into(),
                to: to.into(),
            })
        });
        Ok(())
    }
}
