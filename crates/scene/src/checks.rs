//! Checks of a body before the scene accepts it.

use super::body::Body;
use super::error::SceneError;
use super::id::BodyId;
use punctual_geom::tolerance::{COORDINATE_LIMIT, SCENE_REACH, SCENE_ROTATION_TOLERANCE};
use punctual_geom::{Motion, Pose, rotation_deviation};

/// Checks a body. Returns its importance.
pub(super) fn body(id: BodyId, body: &Body) -> Result<f32, SceneError> {
    pose(id, &body.pose)?;
    let importance = importance(id, body.importance)?;
    length(id, body.margin)?;
    Ok(importance)
}

/// Checks the poses of a body at the begin and the end of a motion.
pub(super) fn motion(body: BodyId, motion: &Motion) -> Result<(), SceneError> {
    pose(body, &motion.start())?;
    pose(body, &motion.pose(1.0))
}

/// Checks that a body at `pose` has a relative pose with any other of the scene.
#[inline]
pub(super) fn pose(body: BodyId, pose: &Pose) -> Result<(), SceneError> {
    let deviation = rotation_deviation(pose.rotation());
    if deviation > SCENE_ROTATION_TOLERANCE {
        return Err(SceneError::NotARotation { body, deviation });
    }
    match (0..3).find(|&axis| pose.translation()[axis].abs() > SCENE_REACH) {
        Some(axis) => Err(SceneError::TooFar { body, axis }),
        None => Ok(()),
    }
}

pub(super) fn importance(body: BodyId, importance: f32) -> Result<f32, SceneError> {
    // Adding 0.0 makes -0.0 positive, so that the bits have the order of the numbers.
    if importance.is_nan() {
        Err(SceneError::ImportanceNotANumber { body })
    } else {
        Ok(importance + 0.0)
    }
}

pub(super) fn length(body: BodyId, length: f64) -> Result<f64, SceneError> {
    if (0.0..=COORDINATE_LIMIT).contains(&length) {
        Ok(length)
    } else {
        Err(SceneError::NotALength { body, length })
    }
}

pub(super) fn look_ahead(length: f64) -> Result<f64, SceneError> {
    if (0.0..=COORDINATE_LIMIT).contains(&length) {
        Ok(length)
    } else {
        Err(SceneError::LookAheadNotALength { length })
    }
}

/// Checks the numbers of a shape that is not in the scene.
pub(super) fn shape(on_way: &Motion, margin: f64) -> Result<(), SceneError> {
    let nobody = BodyId::from_bits(0);
    let fault = match motion(nobody, on_way).and(length(nobody, margin)) {
        Ok(_) => return Ok(()),
        Err(SceneError::NotARotation { .. }) => "its matrix is too far from a rotation",
        Err(SceneError::TooFar { .. }) => "its translation exceeds 2^990",
        Err(_) => "its margin is not from 0 to 2^1000",
    };
    Err(SceneError::NoShape { fault })
}
