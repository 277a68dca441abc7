//! Lower bounds of the time at which two moving triangles first meet.
//!
//! The corners of B move along straight lines. Along any direction, the projections of the two
//! triangles overlap during one time interval. Along several directions, all overlap from the
//! latest start to the earliest end. If the directions are both normals and the nine cross products
//! of an edge of A and an edge of B, this is the interval in which the triangles meet, unless they
//! are coplanar or degenerate.
//!
//! If B turns, these directions turn with it in `f64`. Otherwise long edges that pass each other
//! closely would seem to meet. The projections are enlarged by the deviation of B from its lines
//! and by all rounding. So no direction makes the answer false: `docs/numerics.md`, "Motion".
//!
//! - [`windows`]: eight pairs at a time in `f32`, or one pair at eight times.
//! - [`Swept`]: one pair in `f64`.

mod batch;
mod pair;

pub use batch::windows;
pub use pair::Swept;

/// Motion of B during a substep, from time -1/2 to 1/2. B's given placement is that of time 0.
/// Lengths are in A's units. A point at `y` has the velocity `shift + turn x y` at time 0. The
/// fourth component of vectors is 0.
#[derive(Clone, Copy, Debug, Default)]
pub struct Glide {
    pub shift: [f32; 4],
    pub turn: [f32; 4],
    /// A point at `y` has the acceleration `pull + change x y + turn x (turn x y)`.
    pub pull: [f32; 4],
    pub change: [f32; 4],
    /// Largest change of a component of `turn` during the substep; 0 if `change` is 0.
    pub turn_error: f32,
    /// Upper bound of the angle by which B turns in half of the substep, in radians.
    pub spin: f32,
    /// Upper bound of any further deviation of B from this motion, in A's units.
    pub arc_error: f32,
}
