//! Every tolerance and limit on numbers in the library, each with unit, meaning and reason.

/// Largest accepted entry of `|RᵀR − I|` (no unit) for a matrix `R` to pass as a rotation.
///
/// A pose is used as given, so this is no accuracy promise: it lets pass what drifts in f32 or after
/// thousands of products, and stops scales, shears and transposed layouts, which are mistakes.
pub(crate) const ROTATION_TOLERANCE: f64 = 1e-3;

/// Largest accepted magnitude of a vertex coordinate or a translation (length unit of the mesh): 2^1000.
///
/// Sums of a few such values, as poses, boxes and differences make them, stay far below overflow at
/// 2^1024, so no infinity or NaN arises behind the doors.
pub(crate) const COORDINATE_LIMIT: f64 = f64::from_bits((1023 + 1000) << 52);

/// Largest accepted entry of `|RᵀR − I|` (no unit) for the pose of a body in a scene.
///
/// A relative pose is the product of an inverse and a pose. Where each is within 1e-4, so by its spectral norm within 3e-4,
/// the product is within (1 + 3e-4)(1 + 3.1e-4) − 1 < 6.2e-4, which is within [`ROTATION_TOLERANCE`]: every two bodies of a
/// scene have a relative pose.
pub(crate) const SCENE_ROTATION_TOLERANCE: f64 = 1e-4;

/// Largest accepted magnitude of the translation of a body in a scene or in motion (length unit of the scene): 2^990, so that
/// relative translations stay within [`COORDINATE_LIMIT`].
pub(crate) const SCENE_REACH: f64 = f64::from_bits((1023 + 990) << 52);

/// What is added to bounds in f64 for underflow (any length unit): a thousand times the least normal number, more than some
/// operations lose, flushed to zero or not.
pub(crate) const UNDERFLOW: f64 = 1024.0 * f64::MIN_POSITIVE;

/// Relative rounding of one f32 operation: 2^-24.
pub(crate) const ROUNDING: f32 = f32::EPSILON / 2.0;

/// Most that a corner of a triangle may leave a box of its tree (unit coordinates, where the mesh reaches to 1): 16
/// roundings, for the corner (3), its rotation into the frame (3 sums of at most sqrt 3), and the box's own centre and
/// half extent (4 more). Proof in `docs/numerics.md`.
pub(crate) const BOX_ROUNDING: f32 = 16.0 * ROUNDING;

/// Most that a corner of a triangle may leave a box of its tree once the box is turned back into the mesh's axes (unit
/// coordinates): [`BOX_ROUNDING`], and 21 roundings because a stored frame is not quite orthonormal, with room to spare.
pub(crate) const FRAME_ROUNDING: f32 = 64.0 * ROUNDING;
