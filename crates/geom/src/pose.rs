//! Rigid poses in f64, used exactly as given.
//!
//! A pose `b_in_a` maps coordinates of B to coordinates of A: `a = R b + t`. Whether two meshes
//! intersect depends on the last bit of the mapped vertices. So the matrix is never
//! orthonormalized, and the order of all roundings is fixed.

use core::fmt;

use glam::{DMat3, DQuat, DVec3, Mat3, Vec3};

use super::larger;
use super::tolerance::{COORDINATE_LIMIT, ROTATION_TOLERANCE};

/// A rotation followed by a translation, both f64: `b_in_a` maps coordinates of B to coordinates of
/// A.
///
/// The rotation matrix is checked: it must not mirror, and no entry of `|RᵀR − I|` may exceed 1e-3.
/// It is then used as given and never made orthonormal.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "[f64; 12]", into = "[f64; 12]"))]
pub struct Pose {
    rotation: DMat3,
    translation: DVec3,
}

/// Reasons why a [`Pose`] is refused.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum PoseError {
    /// An entry is NaN or infinite.
    NotFinite {
        /// The first such entry of the 3 x 4 matrix `[R|t]`, counted row by row from 0.
        entry: usize,
    },
    /// The matrix scales, shears or mirrors.
    NotARotation {
        /// The largest entry of `|RᵀR − I|`; for a determinant d <= 0, at least 1 − d.
        deviation: f64,
    },
    /// The translation exceeds 2^1000 along an axis.
    TooFar {
        /// The first such axis: 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// The quaternion has no direction: its squared length in f64 is zero, subnormal or not finite.
    BadQuaternion,
}

impl fmt::Display for PoseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { entry } => write!(
                f,
                "entry {entry} of the pose [R|t], row by row, is not finite"
            ),
            Self::NotARotation { deviation } => {
                write!(
                    f,
                    "matrix is off a rotation by {deviation:e}, allowed is {ROTATION_TOLERANCE:e}"
                )
            }
            Self::TooFar { axis } => write!(f, "translation along axis {axis} exceeds 2^1000"),
            Self::BadQuaternion => f.write_str("quaternion is zero or not finite"),
        }
    }
}

impl core::error::Error for PoseError {}

impl Pose {
    /// The pose that maps every point to itself.
    pub const IDENTITY: Self = Self {
        rotation: DMat3::IDENTITY,
        translation: DVec3::ZERO,
    };

    /// A pose from a rotation matrix, column by column, and a translation, both kept to the bit.
    /// They may be a `DMat3` and a `DVec3` of any version of glam, or other types that convert to
    /// these arrays.
    ///
    /// ```
    /// use punctual::{Pose, glam::DMat3};
    /// let quarter_turn = DMat3::from_cols_array(&[0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    /// let b_in_a = Pose::new(quarter_turn, [5.0, 0.0, 0.0])?;
    /// assert_eq!(b_in_a.transform_point([1.0, 0.0, 0.0]).to_array(), [5.0, 1.0, 0.0]);
    /// # Ok::<(), punctual::PoseError>(())
    /// ```
    ///
    /// # Errors
    /// [`PoseError::NotFinite`], [`PoseError::TooFar`], [`PoseError::NotARotation`], in this order.
    pub fn new(
        rotation: impl AsRef<[f64; 9]>,
        translation: impl Into<[f64; 3]>,
    ) -> Result<Self, PoseError> {
        let rotation = DMat3::from_cols_array(rotation.as_ref());
        Self::unchecked(rotation, DVec3::from_array(translation.into())).checked()
    }

    fn checked(self) -> Result<Self, PoseError> {
        if let Some(entry) = self.to_row_major().iter().position(|e| !e.is_finite()) {
            return Err(PoseError::NotFinite { entry });
        }
        if let Some(axis) = (0..3).find(|&i| self.translation[i].abs() > COORDINATE_LIMIT) {
            return Err(PoseError::TooFar { axis });
        }
        let deviation = rotation_deviation(&self.rotation);
        if deviation > ROTATION_TOLERANCE {
            return Err(PoseError::NotARotation { deviation });
        }
        Ok(self)
    }

    /// A pose from entries that are known to be valid; does not check them.
    #[inline]
    pub const fn unchecked(rotation: DMat3, translation: DVec3) -> Self {
        Self {
            rotation,
            translation,
        }
    }

    /// A pose from a quaternion `x, y, z, w` and a translation. The quaternion is normalised in f64
    /// first.
    ///
    /// # Errors
    /// [`PoseError::BadQuaternion`], then as [`new`](Self::new).
    pub fn from_quat(
        rotation: impl Into<[f64; 4]>,
        translation: impl Into<[f64; 3]>,
    ) -> Result<Self, PoseError> {
        let rotation = DQuat::from_array(rotation.into());
        if !rotation.length_squared().is_normal() {
            return Err(PoseError::BadQuaternion);
        }
        let unit = rotation / rotation.length();
        Self::new(DMat3::from_quat(unit), translation)
    }

    /// A pose from the images of the three axes, which are the columns of the matrix, and the image
    /// of the origin.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_axes(
        x: impl Into<[f64; 3]>,
        y: impl Into<[f64; 3]>,
        z: impl Into<[f64; 3]>,
        translation: impl Into<[f64; 3]>,
    ) -> Result<Self, PoseError> {
        Self::new(
            DMat3::from_cols_array_2d(&[x.into(), y.into(), z.into()]),
            translation,
        )
    }

    /// A pose from the 3 x 4 matrix `[R|t]`, row by row.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_row_major(m: [f64; 12]) -> Result<Self, PoseError> {
        let column = |j: usize| [m[j], m[4 + j], m[8 + j]];
        Self::from_axes(column(0), column(1), column(2), column(3))
    }

    /// The 3 x 4 matrix `[R|t]`, row by row: the inverse of
    /// [`from_row_major`](Self::from_row_major).
    pub fn to_row_major(&self) -> [f64; 12] {
        let ([x, y, z], t) = (axes(&self.rotation), self.translation);
        [x.x, y.x, z.x, t.x, x.y, y.y, z.y, t.y, x.z, y.z, z.z, t.z]
    }

    /// A pose from f32 values, which f64 represents exactly; the matrix is column by column.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_f32(
        rotation: impl AsRef<[f32; 9]>,
        translation: impl Into<[f32; 3]>,
    ) -> Result<Self, PoseError> {
        let rotation = DMat3::from_cols_array(&rotation.as_ref().map(f64::from));
        Self::new(rotation, translation.into().map(f64::from))
    }

    /// Rotation and translation rounded to f32; a translation outside the range of f32 becomes
    /// infinite.
    pub fn to_f32(&self) -> (Mat3, Vec3) {
        (self.rotation.as_mat3(), self.translation.as_vec3())
    }

    /// The rotation matrix as given.
    #[inline]
    pub fn rotation(&self) -> &DMat3 {
        &self.rotation
    }

    /// The image of the origin.
    #[inline]
    pub fn translation(&self) -> DVec3 {
        self.translation
    }

    /// `self` applied after `inner`, rounded: `b_in_a.compose(&c_in_b)` is `c_in_a`.
    ///
    /// # Errors
    /// As [`new`](Self::new): deviations add up, and so do translations.
    pub fn compose(&self, inner: &Self) -> Result<Self, PoseError> {
        self.compose_unchecked(inner).checked()
    }

    /// [`compose`](Self::compose) for poses whose product is known to be a pose.
    #[inline]
    pub fn compose_unchecked(&self, inner: &Self) -> Self {
        let [x, y, z] = axes(&inner.rotation);
        let rotation = DMat3::from_cols(self.rotate(x), self.rotate(y), self.rotate(z));
        Self {
            rotation,
            translation: self.transform_point(inner.translation),
        }
    }

    /// The inverse map, rounded: `b_in_a.inverse()` is `a_in_b`.
    ///
    /// The matrix is inverted, not transposed, so that an inexact rotation is undone as well.
    ///
    /// # Errors
    /// As [`new`](Self::new), if the pose is close to the limits of what is accepted.
    pub fn inverse(&self) -> Result<Self, PoseError> {
        self.inverse_unchecked().checked()
    }

    /// [`inverse`](Self::inverse) for a pose whose inverse is known to be a pose.
    #[inline]
    pub fn inverse_unchecked(&self) -> Self {
        let [x, y, z] = axes(&self.rotation);
        let determinant = x.dot(y.cross(z));
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let mut inverse = Self {
            rotation: cofactors.transpose() * determinant.recip(),
            translation: DVec3::ZERO,
        };
        inverse.translation = -inverse.rotate(self.translation);
        inverse
    }

    /// The image of a point: per axis `((R_i0*x + R_i1*y) + R_i2*z) + t_i`, each operation rounded
    /// to nearest.
    ///
    /// These values define which meshes intersect. So the order of operations is fixed, and no
    /// multiply-add is fused.
    #[inline]
    pub fn transform_point(&self, point: impl Into<[f64; 3]>) -> DVec3 {
        self.rotate(DVec3::from_array(point.into())) + self.translation
    }

    #[inline]
    pub(super) fn rotate(&self, v: DVec3) -> DVec3 {
        let [x, y, z] = axes(&self.rotation);
        DVec3::new(
            (x.x * v.x + y.x * v.y) + z.x * v.z,
            (x.y * v.x + y.y * v.y) + z.y * v.z,
            (x.z * v.x + y.z * v.y) + z.z * v.z,
        )
    }
}

impl TryFrom<[f64; 12]> for Pose {
    type Error = PoseError;

    /// [`Pose::from_row_major`].
    fn try_from(rows: [f64; 12]) -> Result<Self, PoseError> {
        Self::from_row_major(rows)
    }
}

impl From<Pose> for [f64; 12] {
    /// [`Pose::to_row_major`].
    fn from(pose: Pose) -> Self {
        pose.to_row_major()
    }
}

/// The columns of a matrix.
#[inline(always)]
pub(super) fn axes(m: &DMat3) -> [DVec3; 3] {
    [m.x_axis, m.y_axis, m.z_axis]
}

/// Deviation of a finite matrix from a rotation (no unit): the largest entry of `|RᵀR − I|`. If the
/// determinant is not positive, the result is at least `1 − det R`, because `RᵀR` does not detect a
/// mirror.
#[inline]
pub fn rotation_deviation(rotation: &DMat3) -> f64 {
    let [x, y, z] = axes(rotation);
    let lengths = [x.dot(x) - 1.0, y.dot(y) - 1.0, z.dot(z) - 1.0];
    let angles = [x.dot(y), y.dot(z), z.dot(x)];
    let deviation = lengths
        .iter()
        .chain(&angles)
        .fold(0.0, |max, entry| larger(entry.abs(), max));
    let determinant = x.dot(y.cross(z));
    if determinant <= 0.0 {
        larger(1.0 - determinant, deviation)
    } else {
        deviation
    }
}
