//! Axis-aligned boxes in f64: closed sets, empty if `min` exceeds `max` along an axis.

use glam::DVec3;

/// An axis-aligned bounding box: the closed set of points between `min` and `max`.
///
/// Unit and frame are those of the enclosed points.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Aabb {
    /// Smallest coordinate per axis.
    pub min: DVec3,
    /// Largest coordinate per axis.
    pub max: DVec3,
}

impl Aabb {
    /// The box without points: the neutral element of [`union`](Self::union). It intersects
    /// nothing.
    pub const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The box between two corners; empty if `min` exceeds `max` along an axis.
    pub const fn new(min: DVec3, max: DVec3) -> Self {
        Self { min, max }
    }

    /// The smallest box around all points. No point may be NaN. [`EMPTY`](Self::EMPTY) without
    /// points.
    pub fn from_points(points: impl IntoIterator<Item: Into<[f64; 3]>>) -> Self {
        let points = points
            .into_iter()
            .map(|point| DVec3::from_array(point.into()));
        points.fold(Self::EMPTY, |aabb, point| Self {
            min: aabb.min.min(point),
            max: aabb.max.max(point),
        })
    }

    /// The smallest box around both boxes.
    #[inline]
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The points that lie in both boxes.
    #[inline]
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// The center of the box, rounded; NaN if the box is empty.
    #[inline]
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// The edge length per axis, rounded. An axis along which the box is empty has length 0.
    #[inline]
    pub fn extents(&self) -> DVec3 {
        (self.max - self.min).max(DVec3::ZERO)
    }

    /// True if the box contains no point. A box around one point is not empty.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// True if the boxes share a point; touching counts. An empty box shares none.
    #[inline]
    pub fn intersects(&self, other: &Self) -> bool {
        let common = self.intersection(other);
        // No branches: they would be hard to predict.
        let below = common.min.cmple(common.max);
        below.x & below.y & below.z
    }

    /// True if the point lies in the box or on its boundary.
    #[inline]
    pub fn contains(&self, point: impl Into<[f64; 3]>) -> bool {
        let point = DVec3::from_array(point.into());
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }
}
