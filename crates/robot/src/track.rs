//! How obstacles move by themselves: along a known way, within a reach.

use punctual::Pose;
use punctual::glam::{DQuat, DVec3};
use smallvec::{SmallVec, smallvec};

use crate::error::refuse;
use crate::model::{LARGEST, prefixed};
use crate::transform::{Transform, from_pose, rotation_about, to_pose};
use crate::{Checker, RobotError, ShapeId};

/// The way of an obstacle in the world, over time in seconds, and how far it may be from it.
///
/// Time 0 is now: the time of labels and clearances, and of the beginning of edges
/// ([`EdgeOptions::start`](crate::EdgeOptions::start)). Before its first pose an obstacle stands
/// still, and after its last one unless it has a velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    pieces: SmallVec<[Piece; 1]>,
    /// Radius of the ball in which each point of the obstacle is, now, and its growth, in m/s.
    reach: [f64; 2],
}

/// A steady motion from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    begin: f64,
    place: Transform,
    velocity: DVec3,
    /// Unit axis and angular speed.
    axis: DVec3,
    turning: f64,
}

impl Piece {
    fn new(begin: f64, pose: &Pose, velocity: DVec3, turning: DVec3) -> Result<Self, RobotError> {
        let is_fine = |v: DVec3| v.to_array().iter().all(|x| x.abs() <= LARGEST);
        if !(begin.abs() <= LARGEST && is_fine(velocity) && is_fine(turning)) {
            let what = format!("velocity {velocity}, angular {turning}, from {begin} s");
            return refuse(format!("{what}, allowed is {LARGEST:e}"));
        }
        Ok(Self {
            begin,
            place: from_pose(pose)?,
            velocity,
            axis: turning.normalize_or(DVec3::Z),
            turning: turning.length(),
        })
    }

    fn at(&self, time: f64) -> Transform {
        let passed = (time - self.begin).max(0.0);
        let Transform {
            matrix3,
            translation,
        } = self.place;
        let turned = match self.turning {
            0.0 => matrix3,
            turning => rotation_about(self.axis, turning * passed) * matrix3,
        };
        Transform::from_mat3_translation(turned, translation + self.velocity * passed)
    }
}

impl Track {
    /// Moves from a pose at time 0 with a velocity (m/s), and turns about its origin with an
    /// angular velocity (rad/s), both in the frame of the world.
    ///
    /// # Errors
    /// [`RobotError::Model`]: a pose that is no rotation up to 1e-6, numbers that are not finite or
    /// larger than [`LARGEST`].
    pub fn velocity(pose: &Pose, linear: [f64; 3], angular: [f64; 3]) -> Result<Self, RobotError> {
        let piece = Piece::new(0.0, pose, linear.into(), angular.into());
        let pieces = smallvec![piece.map_err(|error| prefixed("track", error))?];
        let reach = [0.0; 2];
        Ok(Self { pieces, reach })
    }

    /// Moves through poses at ascending times (s). Between two of them velocity and angular
    /// velocity are constant; it takes the shorter way round.
    ///
    /// # Errors
    /// Those of [`Track::velocity`], with the number of the pose; none at all, or times that do not
    /// ascend.
    pub fn poses(poses: &[(f64, Pose)]) -> Result<Self, RobotError> {
        let piece = |(i, &(begin, pose)): (usize, &(f64, Pose))| {
            let mut velocities = [DVec3::ZERO; 2];
            if let Some(&(end, next)) = poses.get(i + 1) {
                if end.partial_cmp(&begin) != Some(std::cmp::Ordering::Greater) {
                    return refuse(format!("{end} s follows {begin} s"));
                }
                let [from, to] = [from_pose(&pose)?, from_pose(&next)?];
                let turn = DQuat::from_mat3(&(to.matrix3 * from.matrix3.transpose()));
                let turn = if turn.w < 0.0 { -turn } else { turn };
                let way = to.translation - from.translation;
                velocities = [way, turn.to_scaled_axis()].map(|v| v / (end - begin));
            }
            Piece::new(begin, &pose, velocities[0], velocities[1])
        };
        let piece = |at: (usize, &(f64, Pose))| {
            piece(at).map_err(|error| prefixed(&format!("track: pose {}", at.0), error))
        };
        if poses.is_empty() {
            return refuse("track: no pose");
        }
        let pieces = poses
            .iter()
            .enumerate()
            .map(piece)
            .collect::<Result<_, _>>();
        let reach = [0.0; 2];
        pieces.map(|pieces| Self { pieces, reach })
    }

    /// Each point of the obstacle may be this far (m) from where the track has it at time 0, and
    /// farther by `speed` (m/s) with time. Contacts anywhere within this reach count.
    ///
    /// # Errors
    /// [`RobotError::Model`] for numbers that are negative, NaN or larger than [`LARGEST`].
    pub fn reach(self, radius: f64, speed: f64) -> Result<Self, RobotError> {
        let reach = [radius, speed];
        if reach.iter().all(|x| (0.0..=LARGEST).contains(x)) {
            return Ok(Self { reach, ..self });
        }
        let allowed = format!("allowed is 0 to {LARGEST:e}");
        refuse(format!("track: reach {radius} m, {speed} m/s, {allowed}"))
    }

    /// Where the obstacle is at a time: answers are exact for these poses.
    pub fn pose(&self, time: f64) -> Pose {
        to_pose(&self.at(time))
    }

    /// How far its points may be from there, in metres.
    pub fn reach_at(&self, time: f64) -> f64 {
        self.reach[0] + self.reach[1] * time.max(0.0)
    }

    pub(crate) fn at(&self, time: f64) -> Transform {
        let at = self.pieces.partition_point(|piece| piece.begin <= time);
        self.pieces[at.max(1) - 1].at(time)
    }

    /// An upper bound of the decrease of a distance within half an interval of time, by the motion
    /// of the obstacle and the growth of its reach. No point of it is farther than `radius` from
    /// its origin.
    pub(crate) fn way(&self, middle: f64, half: f64, radius: f64) -> f64 {
        let first = self.pieces.partition_point(|p| p.begin <= middle - half);
        let pieces = self.pieces[first.max(1) - 1..].iter();
        let met = pieces.take_while(|piece| piece.begin <= middle + half);
        let speed = met.map(|piece| piece.velocity.length() + piece.turning * radius);
        let fastest = speed.fold(0.0, f64::max) + self.reach[1];
        fastest * half * (1.0 + 1e-9)
    }
}

impl Checker {
    /// Makes an obstacle in the world move by itself along a track, or changes its track. Its
    /// motion counts in edges, paths, trajectories and horizons; labels and clearances are of time
    /// 0. It is not checked against links that stand still in the world, nor other obstacles.
    /// [`Checker::move_to`] ends its motion.
    ///
    /// Complexity: the first track of an obstacle lists all pairs anew; a later one lists none, for
    /// a controller that sets a new one in each cycle.
    ///
    /// # Errors
    /// [`RobotError::NoObstacle`]; [`RobotError::Model`] if it is attached to a link.
    pub fn move_along(&mut self, id: ShapeId, track: Track) -> Result<(), RobotError> {
        let at = self.world.obstacle(id)?;
        if self.world.is_attached(at) {
            let name = &self.world.shapes[at].name;
            return refuse(format!("obstacle {name}: is attached to a link"));
        }
        if self.world.set_track(at, Some(track)) {
            self.renew();
        }
        self.room.begin();
        Ok(())
    }
}
