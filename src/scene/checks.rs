//! What is checked of a body before the scene takes it.

use super::body::Body;
use super::error::SceneError;
use super::id::BodyId;
use crate::math::tolerance::{COORDINATE_LIMIT, SCENE_REACH, SCENE_ROTATION_TOLERANCE};
use crate::math::{Motion, Pose, rotation_deviation};

/// Checks a body; gives the inverse of its pose, and its importance.
pub(super) fn body(id: BodyId, body: &Body) -> Result<(Pose, f32), SceneError> {
    let inverse = inverse(id, &body.pose)?;
    let importance = importance(id, body.importance)?;
    length(id, body.margin)?;
    Ok((inverse, importance))
}

/// Checks that a body can be where a motion begins and ends; gives the inverse of its start.
pub(super) fn motion(body: BodyId, motion: &Motion) -> Result<Pose, SceneError> {
    let inverse_of_start = inverse(body, &motion.start())?;
    inverse(body, &motion.pose(1.0))?;
    Ok(inverse_of_start)
}

/// Checks that a body at `pose` has a relative pose with any other of the scene; gives the inverse.
pub(super) fn inverse(body: BodyId, pose: &Pose) -> Result<Pose, SceneError> {
    let deviation = rotation_deviation(pose.rotation());
    if deviation > SCENE_ROTATION_TOLERANCE {
        return Err(SceneError::NotARotation { body, deviation });
    }
    let too_far = |pose: &Pose| (0..3).find(|&axis| pose.translation()[axis].abs() > SCENE_REACH);
    if let Some(axis) = too_far(pose) {
        return Err(SceneError::TooFar { body, axis });
    }
    Ok(pose.inverse_unchecked())
}

pub(super) fn importance(body: BodyId, importance: f32) -> Result<f32, SceneError> {
    // One zero, so that the bits give the order.
    if importance.is_nan() { Err(SceneError::ImportanceNotANumber { body }) } else { Ok(importance + 0.0) }
}

pub(super) fn length(body: BodyId, length: f64) -> Result<f64, SceneError> {
    if (0.0..=COORDINATE_LIMIT).contains(&length) { Ok(length) } else { Err(SceneError::NotALength { body, length }) }
}
