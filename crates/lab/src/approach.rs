//! Poses of one mesh on its way to another.

use crate::artificial::Random;
use crate::report::Failure;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::{Budget, Mesh, Motion, Pose, Query, Tree, Verdict, Workspace};
use std::io::Write;

/// A mesh that comes towards another one, each time turned anew and on another line.
pub struct Approach<'t> {
    a: &'t Tree,
    b: &'t Tree,
    random: Random,
    workspace: Workspace,
}

/// A turn of B, and the line on which the middle of its box moves: from a point against the direction, which has length
/// 1.
#[derive(Clone, Copy)]
pub struct Line {
    /// The turn of B.
    pub turn: DMat3,
    /// Where the middle of its box goes.
    pub target: DVec3,
    /// Against which it moves; of length 1.
    pub direction: DVec3,
}

impl<'t> Approach<'t> {
    /// With the random numbers of a seed.
    pub fn new(a: &'t Tree, b: &'t Tree, seed: u64) -> Self {
        Self {
            a,
            b,
            random: Random::new(seed),
            workspace: Workspace::new(),
        }
    }

    /// What offsets are measured by: the box diagonal of the smaller mesh.
    pub fn unit(&self) -> f64 {
        diagonal(self.a.mesh()).min(diagonal(self.b.mesh()))
    }

    /// From so far away the boxes do not overlap.
    pub fn reach(&self) -> f64 {
        diagonal(self.a.mesh()) + diagonal(self.b.mesh())
    }

    /// The middle of the box of A.
    pub fn middle_of_a(&self) -> DVec3 {
        middle(self.a.mesh())
    }

    /// A number from 0 to 1.
    pub fn fraction(&mut self) -> f64 {
        self.random.fraction()
    }

    /// A point in the box of A.
    pub fn point_in_a(&mut self) -> DVec3 {
        let (low, high) = (self.a.mesh().aabb().min, self.a.mesh().aabb().max);
        low + (high - low) * DVec3::from_array([(); 3].map(|()| self.fraction()))
    }

    /// Every direction is as likely as any other.
    pub fn direction(&mut self) -> DVec3 {
        let (angle, z) = (
            self.random.fraction() * std::f64::consts::TAU,
            2.0 * self.random.fraction() - 1.0,
        );
        let side = (1.0 - z * z).sqrt();
        DVec3::new(side * angle.cos(), side * angle.sin(), z)
    }

    /// Every turn is as likely as any other.
    pub fn turn(&mut self) -> DMat3 {
        turn([(); 3].map(|()| self.fraction()))
    }

    /// The pose on a line with the middle of B's box so far before the target.
    pub fn at(&self, line: &Line, distance: f64) -> Result<Pose, Failure> {
        let origin = line.target - line.turn * middle(self.b.mesh());
        Ok(Pose::new(line.turn, origin + line.direction * distance)?)
    }

    /// How far before the target B first touches A when it comes from a distance; none if it passes.
    pub fn first_touch(&mut self, line: &Line, from: f64) -> Result<Option<f64>, Failure> {
        let path = from + self.reach();
        let motion = Motion::straight(self.at(line, from)?, -line.direction * path)?;
        let found =
            Query::impact(self.a, self.b, motion).run(&mut self.workspace, Budget::unlimited());
        Ok(found.value.upper.map(|time| from - time * path))
    }

    /// Whether the meshes are apart at a pose.
    pub fn is_free(&mut self, pose: Pose) -> bool {
        let outcome =
            Query::intersection(self.a, self.b, pose).run(&mut self.workspace, Budget::unlimited());
        outcome.value == Verdict::Separated
    }
}

/// A rotation for each point of the unit cube, all equally dense (K. Shoemake, "Uniform random
/// rotations", 1992).
pub fn turn([share, first, second]: [f64; 3]) -> DMat3 {
    let [(s, c), (t, d)] = [first, second].map(|part| (part * std::f64::consts::TAU).sin_cos());
    let (near, far) = ((1.0 - share).sqrt(), share.sqrt());
    DMat3::from_quat(DQuat::from_xyzw(near * s, near * c, far * t, far * d))
}

fn middle(mesh: &Mesh) -> DVec3 {
    mesh.aabb().center()
}

/// The diagonal of a mesh's box; 0 without vertices.
pub fn diagonal(mesh: &Mesh) -> f64 {
    mesh.aabb().extents().length()
}

/// Offsets for [`contact`] with which `punctual poses` and `punctual sweep` make poses.
pub const OFFSETS: [f64; 7] = [-5.0, -2.0, -0.5, -0.1, 0.1, 0.5, 2.0];

/// Lines in a row that may pass A before the search is given up.
const MOST_MISSES: usize = 1000;

/// Poses at random, at which the balls around the boxes overlap.
pub fn random(approach: &mut Approach, count: usize) -> Result<Vec<Pose>, Failure> {
    let mut pose = || {
        let line = Line {
            turn: approach.turn(),
            target: approach.middle_of_a(),
            direction: approach.direction(),
        };
        // The cube root makes all places in a ball equally likely.
        let distance = 0.5 * approach.reach() * approach.fraction().cbrt();
        approach.at(&line, distance)
    };
    (0..count).map(|_| pose()).collect()
}

/// Poses around the first touch of lines towards A: one for each line and offset, which is in percent
/// of the box diagonal of the smaller mesh, before the touch. `inside`: lines begin within the box of A,
/// where B is free.
///
/// # Errors
/// If B touches A on none of many lines in a row.
pub fn contact(
    approach: &mut Approach,
    count: usize,
    inside: bool,
    offsets: &[f64],
) -> Result<Vec<Pose>, Failure> {
    let (mut poses, mut misses) = (Vec::with_capacity(count), 0);
    while poses.len() < count {
        let line = Line {
            turn: approach.turn(),
            target: approach.point_in_a(),
            direction: approach.direction(),
        };
        let from = if inside { 0.0 } else { 2.0 * approach.reach() };
        let starts_free = !inside || approach.is_free(approach.at(&line, from)?);
        let Some(touch) = starts_free
            .then(|| approach.first_touch(&line, from))
            .transpose()?
            .flatten()
        else {
            misses += 1;
            if misses > MOST_MISSES {
                return Err(format!("B touches A on none of {misses} lines in a row").into());
            }
            continue;
        };
        misses = 0;
        for offset in offsets.iter().take(count - poses.len()) {
            let distance = touch + 0.01 * offset * approach.unit();
            poses.push(approach.at(&line, distance)?);
        }
    }
    Ok(poses)
}

/// Writes a line of a list of poses.
pub fn print(pose: &Pose, out: &mut impl Write) -> Result<(), Failure> {
    Ok(writeln!(
        out,
        "{}",
        pose.to_row_major()
            .map(|number| number.to_string())
            .join(" ")
    )?)
}
