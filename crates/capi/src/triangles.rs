//! Two triangles.

use crate::status::{Fault, door, given, punctual_status};
use core::mem::MaybeUninit;
use punctual::glam::DVec3;

/// 2^1000, the largest coordinate of a mesh.
const COORDINATE_LIMIT: f64 = f64::from_bits((1023 + 1000) << 52);

/// Three corners, each x, y, z.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_triangle {
    /// Corner by corner.
    pub corners: [[f64; 3]; 3],
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

/// Whether two closed triangles share at least one point, exactly for the given coordinates. Touching is intersecting; a
/// degenerate triangle is the segment or point that it is.
///
/// Fails with BAD_ARGUMENT if a coordinate is not finite or exceeds 2^1000.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_triangles_intersect(
    a: punctual_triangle,
    b: punctual_triangle,
    intersect: Option<&mut MaybeUninit<bool>>,
) -> punctual_status {
    door("punctual_triangles_intersect", || {
        let intersect = given(intersect, "intersect")?;
        let (a, b) = (a.check("a coordinate of a")?, b.check("a coordinate of b")?);
        intersect.write(punctual::triangles_intersect(&a, &b));
        Ok(())
    })
}
