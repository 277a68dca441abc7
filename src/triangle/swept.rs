//! When do two triangles meet on the way? Times before which they certainly do not.
//!
//! The corners of B go along straight lines. On any direction the projections of the two triangles overlap from one time to
//! another; on several, from the latest beginning to the earliest end. With the normals of both and the nine products of their
//! edges this is when they meet, unless they are coplanar or degenerate. Where B turns these directions turn with it: else long
//! edges that pass close by would seem to meet. What B may leave its lines by is added to the projections, as is all rounding, so
//! no direction makes the answer false: `docs/numerics.md`, "Motion".
//!
//! - [`windows`]: eight pairs at a time in `f32`, or one pair at eight times.
//! - [`Swept`]: one pair in `f64`.

mod batch;
mod pair;

pub(crate) use batch::windows;
pub(crate) use pair::Swept;

/// How B goes through a piece of time, from -1/2 to 1/2 with the place that it is given in the middle: lengths in A's units. A
/// point at `y` has the velocity `shift + turn x y` there. The fourth component of vectors is 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glide {
    pub shift: [f32; 4],
    pub turn: [f32; 4],
    /// It has the acceleration `pull + change x y + turn x (turn x y)`.
    pub pull: [f32; 4],
    pub change: [f32; 4],
    /// By how much a component of `turn` may differ at other times of the piece; 0 if `change` is.
    pub wobble: f32,
    /// Of how many radians B turns in half of the piece, at most.
    pub spin: f32,
    /// What B may be off besides.
    pub bulge: f32,
    /// Whether directions turn with B: of use where it goes little besides.
    pub swings: bool,
}

impl Glide {
    /// B stands still.
    pub const NONE: Self = Self {
        shift: [0.0; 4],
        turn: [0.0; 4],
        pull: [0.0; 4],
        change: [0.0; 4],
        wobble: 0.0,
        spin: 0.0,
        bulge: 0.0,
        swings: false,
    };
}
