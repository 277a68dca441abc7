//! Bounds on what a stopped motion query has not reached: where B's parts are during the times in
//! which they may meet A first.

use super::relative_motion::RelativeMotion;
use super::state::MotionState;
use crate::engine::options::MotionOptions;
use crate::tree::Tree;
use glam::DVec3;
use punctual_geom::{Aabb, Pose};

/// The rest of a motion: from the time until which it is free to the time of the contact found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ahead<'m> {
    relative_motion: RelativeMotion<'m>,
    margin: f64,
    /// The current substep.
    substep: u32,
    from: f64,
    until: f64,
}

impl<'m> Ahead<'m> {
    pub fn new([a, b]: [&Tree; 2], options: &'m MotionOptions, state: &MotionState) -> Self {
        let (relative_motion, margin) = (
            RelativeMotion::new(a, b, options.of_a.as_ref(), &options.of_b),
            options.margin,
        );
        let until = state.contact().map_or(1.0, |contact| contact.time);
        Self {
            relative_motion,
            margin,
            substep: state.substep,
            from: state.free_until(),
            until,
        }
    }

    /// The substeps after the current one in which the meshes may meet first.
    pub fn later(self, trees: [&Tree; 2]) -> impl Iterator<Item = u32> {
        let later = self.substep.saturating_add(1)..self.relative_motion.substeps;
        later
            .map(move |i| (i, self.relative_motion.substep(i)))
            .filter_map(move |(i, substep)| {
                (substep.begin < self.until
                    && !self.relative_motion.is_clear(&substep, trees, self.margin))
                .then_some(i)
            })
    }

    /// A box around a part of B during a substep (by default the current one), margins included.
    /// `at` returns the box of the part at a pose.
    pub fn swept(&self, substep: Option<u32>, at: impl FnOnce(&Pose) -> Aabb) -> Aabb {
        let substep = self
            .relative_motion
            .substep(substep.unwrap_or(self.substep));
        let bounds = at(&self.relative_motion.pose(substep.middle));
        let (center, half) = (bounds.center(), bounds.extents() * 0.5);
        let ends = [self.from.max(substep.begin), self.until.min(substep.end)]
            .map(|time| time - substep.middle);
        let longest = ends[0].abs().max(ends[1].abs());
        // As in `docs/numerics.md`, "Motion": the points of the part move like its middle, up to
        // this.
        let off = longest * self.relative_motion.spin * half.length()
            + self.relative_motion.bend(longest);
        let off = off * (1.0 + 1e-9) + 4.0 * self.relative_motion.rounding + self.margin;
        let velocity = self.relative_motion.twist(substep.middle).at(center);
        let way = Aabb::from_points(ends.map(|time| center + velocity * time));
        Aabb {
            min: way.min - half - DVec3::splat(off),
            max: way.max + half + DVec3::splat(off),
        }
    }
}
