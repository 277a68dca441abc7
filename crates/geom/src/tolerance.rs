//! Every tolerance and limit on numbers in the library, each with unit, meaning and reason.

/// Largest accepted entry of `|RᵀR − I|` (no unit) for a matrix `R` to pass as a rotation.
///
/// A pose is used as given, so this limit promises no accuracy. It accepts matrices that drifted in
/// f32 or after thousands of products. It refuses scales, shears and transposed layouts, which are
/// mistakes.
pub const ROTATION_TOLERANCE: f64 = 1e-3;

/// Largest accepted magnitude of a vertex coordinate or a translation (length unit of the mesh):
/// 2^1000.
///
/// Poses, boxes and differences are sums of a few such values. They stay far below overflow at
/// 2^1024, so none of them gives infinity or NaN.
pub const COORDINATE_LIMIT: f64 = f64::from_bits((1023 + 1000) << 52);

/// Largest accepted entry of `|RᵀR − I|` (no unit) for the pose of a body in a scene.
///
/// A relative pose is the product of an inverse and a pose. If each is within 1e-4, so by its
/// spectral norm within 3e-4, the product is within (1 + 3e-4)(1 + 3.1e-4) − 1 < 6.2e-4. That is
/// within [`ROTATION_TOLERANCE`], so any two bodies of a scene have a relative pose.
pub const SCENE_ROTATION_TOLERANCE: f64 = 1e-4;

/// Largest accepted magnitude of the translation of a body in a scene or in motion (length unit of
/// the scene): 2^990. It keeps relative translations within [`COORDINATE_LIMIT`].
pub const SCENE_REACH: f64 = f64::from_bits((1023 + 990) << 52);

/// Underflow term of error bounds in f64 (any length unit): about a thousand times the least normal
/// number. This exceeds the loss of a few operations, with or without flush to zero.
pub const UNDERFLOW: f64 = 1024.0 * f64::MIN_POSITIVE;

/// Relative rounding of one f32 operation: 2^-24.
pub const ROUNDING: f32 = f32::EPSILON / 2.0;

/// Largest distance by which a corner of a triangle may lie outside a box of its tree (unit
/// coordinates, where the mesh reaches to 1): 16 roundings, for the corner (3), its rotation into
/// the frame (3 sums of at most sqrt 3), and the box's own center and half extent (4 more). Proof
/// in `docs/numerics.md`.
pub const BOX_ROUNDING: f32 = 16.0 * ROUNDING;

/// Largest distance by which a corner of a triangle may lie outside a box of its tree once the box
/// is rotated back into the mesh's axes (unit coordinates). [`BOX_ROUNDING`], plus 21 roundings
/// because a stored frame is not quite orthonormal, plus a margin.
pub const FRAME_ROUNDING: f32 = 64.0 * ROUNDING;
