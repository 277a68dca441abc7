//! Errors of scenes.

use super::ask::PairQuestion;
use super::id::{BodyId, CompoundId, GroupId, MeasureId};
use core::fmt;
use punctual_geom::RayError;
use punctual_geom::tolerance::SCENE_ROTATION_TOLERANCE;

/// The reason why a scene rejects a call. The scene is then unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneError {
    /// The body was removed, or belongs to another scene.
    NoSuchBody {
        /// The invalid id.
        body: BodyId,
    },
    /// The compound was removed, or belongs to another scene.
    NoSuchCompound {
        /// The invalid id.
        compound: CompoundId,
    },
    /// The group belongs to another scene.
    NoSuchGroup {
        /// The invalid id.
        group: GroupId,
    },
    /// The distance of these groups is no longer measured, or is measured by another scene.
    NoSuchMeasure {
        /// The invalid id.
        measure: MeasureId,
    },
    /// The matrix of the pose is too far from a rotation for a relative pose of two bodies.
    NotARotation {
        /// The body; for an insertion, the id that it would have had.
        body: BodyId,
        /// The largest entry of `|RᵀR − I|`.
        deviation: f64,
    },
    /// The translation of the pose is longer than 2^990 along an axis; or a part of a compound is
    /// as far from the axis of the compound's turn.
    TooFar {
        /// The body; for an insertion, the id that it would have had.
        body: BodyId,
        /// The first such axis: 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// The importance is NaN.
    ImportanceNotANumber {
        /// The body; for an insertion, the id that it would have had.
        body: BodyId,
    },
    /// The margin, or the tolerance of a distance, is negative, NaN, or exceeds 2^1000.
    NotALength {
        /// The body; for an insertion, the id that it would have had.
        body: BodyId,
        /// The rejected value.
        length: f64,
    },
    /// The importance of a question is infinite or NaN.
    QuestionImportanceNotFinite {
        /// The question.
        question: PairQuestion,
    },
    /// The look-ahead is negative, NaN, or exceeds 2^1000.
    LookAheadNotALength {
        /// The rejected value.
        length: f64,
    },
    /// A question about a pair was given the same body twice: distance, contacts, or certificate.
    OneBody {
        /// The body.
        body: BodyId,
    },
    /// The ray cannot be mapped to the coordinates of a body's mesh: it is too long, or too short
    /// for a body so far away.
    NoRay {
        /// The body.
        body: BodyId,
        /// The error of the mapped ray.
        error: RayError,
    },
    /// A shape cannot be asked about ([`crate::SceneShape`]).
    NoShape {
        /// What is wrong with it.
        fault: &'static str,
    },
    /// All 2^32 − 1 ids are in use.
    Full,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchBody { body } => write!(f, "{body} is not in the scene"),
            Self::NoSuchCompound { compound } => write!(f, "{compound} is not in the scene"),
            Self::NoSuchGroup { group } => write!(f, "{group} is not of the scene"),
            Self::NoSuchMeasure { measure } => write!(f, "{measure} is not asked for in the scene"),
            Self::NotARotation { body, deviation } => write!(
                f,
                "{body}: the matrix is off a rotation by {deviation:e}, allowed is {SCENE_ROTATION_TOLERANCE:e}"
            ),
            Self::TooFar { body, axis } => {
                write!(f, "{body}: translation along axis {axis} exceeds 2^990")
            }
            Self::ImportanceNotANumber { body } => {
                write!(f, "{body}: the importance is not a number")
            }
            Self::NotALength { body, length } => {
                write!(f, "{body}: {length} is not a length from 0 to 2^1000")
            }
            Self::QuestionImportanceNotFinite { question } => {
                write!(f, "the importance of the question {question} is not finite")
            }
            Self::LookAheadNotALength { length } => {
                write!(f, "look-ahead: {length} is not a length from 0 to 2^1000")
            }
            Self::OneBody { body } => write!(f, "{body} has no distance from itself"),
            Self::NoRay { body, error } => write!(f, "in the coordinates of {body}, {error}"),
            Self::NoShape { fault } => write!(f, "the shape: {fault}"),
            Self::Full => f.write_str("the scene has no id left"),
        }
    }
}

impl core::error::Error for SceneError {}
