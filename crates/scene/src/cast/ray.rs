//! Rays in a scene, and their hits.

use crate::filter::Filter;
use crate::id::BodyId;
use core::time::Duration;
use punctual::StopReason;
use punctual::rays::{RayHit, RayMode};
use punctual_geom::Ray;

/// Asks which body a ray or a segment of the scene hits: [`crate::Scene::cast`].
///
/// ```
/// use punctual::glam::DMat3;
/// use punctual::{Budget, Pose, Ray, Tree, shapes};
/// use punctual::rays::RayMode;
/// use punctual_scene::{Body, Scene, SceneRay};
/// use std::sync::Arc;
///
/// let ball = Arc::new(Tree::new(shapes::icosphere(3)));
/// let mut scene = Scene::new();
/// let mut insert = |x: f64| scene.insert(Body::moving(Arc::clone(&ball), Pose::new(DMat3::IDENTITY, [x, 0.0, 0.0]).unwrap()));
/// let (near, far) = (insert(5.0)?, insert(9.0)?);
///
/// let ray = SceneRay::new(Ray::new([0.0, 0.1, 0.2], [2.0, 0.0, 0.0])?);
/// let hit = scene.cast(&ray, Budget::unlimited())?.hit.expect("both balls are in its way");
/// assert!(hit.body == near && 2.0 < hit.on_body.t && hit.on_body.t < 2.1);
///
/// // All hits, into both balls and out of them.
/// let cast = scene.cast(&ray.mode(RayMode::All), Budget::unlimited())?;
/// assert_eq!((cast.found, scene.ray_hits().iter().filter(|hit| hit.body == far).count()), (4, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[must_use]
pub struct SceneRay {
    pub(crate) ray: Ray,
    pub(crate) mode: RayMode,
    pub(crate) filter: Filter,
}

impl SceneRay {
    /// Asks for the nearest hit of a ray in the coordinates of the scene.
    pub fn new(ray: Ray) -> Self {
        Self {
            ray,
            mode: RayMode::Nearest,
            filter: Filter::default(),
        }
    }

    /// Sets whether to find the nearest hit, any, or all.
    pub fn mode(self, mode: RayMode) -> Self {
        Self { mode, ..self }
    }

    /// Restricts the cast to bodies that a body with this filter may meet; by default all.
    pub fn filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }
}

/// A triangle of a body that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BodyHit {
    /// The body.
    pub body: BodyId,
    /// The triangle, and the ray parameter, which is the same in the scene: [`Ray::at`].
    pub on_body: RayHit,
}

impl BodyHit {
    /// By `t`, then by body, then by triangle: a total order.
    pub(crate) fn is_before(&self, other: &Self) -> bool {
        let key = |hit: &Self| (hit.body.index, hit.on_body.triangle);
        self.on_body.t < other.on_body.t
            || self.on_body.t == other.on_body.t && key(self) < key(other)
    }
}

/// The answer to a [`SceneRay`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct SceneCast {
    /// The nearest hit found; in [`RayMode::Any`] the hit found. If `stop` is
    /// [`StopReason::Finished`], it is the nearest of all hits.
    pub hit: Option<BodyHit>,
    /// Number of triangles found to be hit. In [`RayMode::All`] those of
    /// [`crate::Scene::ray_hits`].
    pub found: u64,
    /// Proven: no missing hit lies before this parameter of the ray. For a known nearest hit, its
    /// own parameter. Infinite if nothing is left to find.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub free_until: f64,
    /// The reason why the call returned. [`StopReason::FlushedToZero`] if flushing could falsify
    /// the answer for one of the bodies.
    pub stop: StopReason,
    /// Work of the call.
    pub work: u64,
    /// Time of the call; measured only under a time budget.
    pub elapsed: Option<Duration>,
}
