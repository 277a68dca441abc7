//! Axis-aligned boxes in f64: closed sets, empty when `min` exceeds `max`.

use glam::DVec3;

/// An axis-aligned bounding box: the closed set of points between `min` and `max`.
///
/// Unit and frame are those of the points it was made from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Aabb {
    /// Smallest coordinate per axis.
    pub min: DVec3,
    /// Largest coordinate per axis.
    pub max: DVec3,
}

impl Aabb {
    /// The box of no points: neutral in [`union`](Self::union), meets nothing.
    pub const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The box between two corners; empty if `min` exceeds `max` along an axis.
    pub const fn new(min: DVec3, max: DVec3) -> Self {
        Self { min, max }
    }

    /// The smallest box around all points, which must not be NaN; [`EMPTY`](Self::EMPTY) without points.
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

    /// The middle of the box, rounded; NaN when the box is empty.
    #[inline]
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// The full edge length per axis, rounded; zero when the box is empty.
    #[inline]
    pub fn extents(&self) -> DVec3 {
        (self.max - self.min).max(DVec3::ZERO)
    }

    /// Whether the box holds no point. A box around one point is not empty.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether the boxes share a point; touching counts. An empty box shares none.
    #[inline]
    pub fn intersects(&self, other: &Self) -> bool {
        let common = self.intersection(other);
        // Without branches: which way one would go is hard to foretell.
        let below = common.min.cmple(common.max);
        below.x & below.y & below.z
    }

    /// Whether the point lies in the box or on its border.
    #[inline]
    pub fn contains(&self, point: impl Into<[f64; 3]>) -> bool {
        let point = DVec3::from_array(point.into());
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }
}
