//! Bounds on what a stopped motion query has not reached: where B's parts are during the times in
//! which they may meet A first.

use super::course::Course;
use super::state::MotionState;
use crate::query::options::MotionOptions;
use crate::tree::Tree;
use glam::DVec3;
use punctual_geom::{Aabb, Pose};

/// The rest of a motion: from the time until which it is free to the time of the contact found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ahead<'m> {
    course: Course<'m>,
    margin: f64,
    /// The current piece.
    piece: u32,
    from: f64,
    until: f64,
}

impl<'m> Ahead<'m> {
    pub fn new([a, b]: [&Tree; 2], options: &'m MotionOptions, state: &MotionState) -> Self {
        let (course, margin) = (
            Course::new(a, b, options.of_a.as_ref(), &options.of_b),
            options.margin,
        );
        let until = state.contact().map_or(1.0, |contact| contact.time);
        Self {
            course,
            margin,
            piece: state.piece,
            from: state.free_until(),
            until,
        }
    }

    /// The pieces after the current one in which the meshes may meet first.
    pub fn later(self, trees: [&Tree; 2]) -> impl Iterator<Item = u32> {
        let later = self.piece.saturating_add(1)..self.course.pieces;
        later
            .map(move |i| (i, self.course.piece(i)))
            .filter_map(move |(i, piece)| {
                (piece.begin < self.until && !self.course.is_clear(&piece, trees, self.margin))
                    .then_some(i)
            })
    }

    /// A box around a part of B during a piece (by default the current one), margins included. `at`
    /// returns the box of the part at a pose.
    pub fn swept(&self, piece: Option<u32>, at: impl FnOnce(&Pose) -> Aabb) -> Aabb {
        let piece = self.course.piece(piece.unwrap_or(self.piece));
        let bounds = at(&self.course.pose(piece.middle));
        let (center, half) = (bounds.center(), bounds.extents() * 0.5);
        let ends =
            [self.from.max(piece.begin), self.until.min(piece.end)].map(|time| time - piece.middle);
        let longest = ends[0].abs().max(ends[1].abs());
        // As in `docs/numerics.md`, "Motion": the points of the part move like its middle, up to
        // this.
        let off = longest * self.course.spin * half.length() + self.course.bend(longest);
        let off = off * (1.0 + 1e-9) + 4.0 * self.course.rounding + self.margin;
        let velocity = self.course.twist(piece.middle).at(center);
        let way = Aabb::from_points(ends.map(|time| center + velocity * time));
        Aabb {
            min: way.min - half - DVec3::splat(off),
            max: way.max + half + DVec3::splat(off),
        }
    }
}
