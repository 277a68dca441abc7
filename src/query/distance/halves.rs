//! A separating plane across the closest points found, or along a triangle in doubt.
//!
//! If many triangles are at nearly equal distance, as in nested or parallel sheets, boxes cannot
//! distinguish them, and a search tests all their pairs: quadratic. If the surfaces lie on two
//! sides of a slab across the line between the closest points, one pass over all vertices ends the
//! search. So it does for a search of intersections, along the normal of a triangle in doubt; there
//! the work is that of exact tests. The pass starts once the search has done [`WORK_BEFORE`] units
//! for each vertex, so that it adds next to nothing, and again whenever that work has doubled.

use crate::model::cost::MAX_STEP_WORK;
use crate::tree::Tree;
use glam::DVec3;
use punctual_geom::Pose;

/// A pass over all vertices, a few at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Halves {
    /// The work at which the pass starts.
    due: u64,
    /// Number of vertices done, those of A first.
    looked: usize,
    /// Unit vector from A to B.
    direction: DVec3,
    /// Upper end of A along the direction, and lower end of B.
    ends: [f64; 2],
}

/// The pass starts after this many units of work per vertex.
const WORK_BEFORE: u64 = 16;

/// Vertices per step, and per unit of work.
const STEP: usize = 1024;
const PER_WORK: u64 = 8;
const _: () = assert!(STEP as u64 / PER_WORK <= MAX_STEP_WORK);

/// Rounding of a position along the direction, relative to the largest coordinates of both meshes
/// and of the translation: of the placed vertices, and of the sums here.
const ROUNDINGS: f64 = 64.0 * f64::EPSILON;

impl Halves {
    pub const NEVER: Self = Self {
        due: u64::MAX,
        looked: 0,
        direction: DVec3::ZERO,
        ends: [0.0; 2],
    };

    pub fn of(a: &Tree, b: &Tree) -> Self {
        Self {
            due: WORK_BEFORE * (a.mesh().vertex_count() + b.mesh().vertex_count()) as u64,
            ..Self::NEVER
        }
    }

    #[inline(always)]
    pub fn is_due(&self, work: u64) -> bool {
        work >= self.due
    }

    /// Continues the pass by some vertices, or begins it along the direction `towards` B; `work` is
    /// the work of the query so far. Returns the work of this step and, at the end of the pass, a
    /// lower bound of the distance, if it is more than 0.
    pub fn look(
        &mut self,
        [a, b]: [&Tree; 2],
        b_in_a: &Pose,
        towards: impl FnOnce() -> DVec3,
        work: u64,
    ) -> (u64, Option<f64>) {
        let [count_of_a, count_of_b] = [a, b].map(|tree| tree.mesh().vertex_count());
        if self.looked == 0 {
            self.direction = towards().normalize_or_zero();
            self.ends = [f64::NEG_INFINITY, f64::INFINITY];
        }
        let along = self.direction;
        let along_b = b_in_a.rotation().transpose() * along;
        let until = (self.looked + STEP).min(count_of_a + count_of_b);
        for i in self.looked..until.min(count_of_a) {
            self.ends[0] = self.ends[0].max(along.dot(a.mesh().vertex(i)));
        }
        for i in self.looked.max(count_of_a)..until.max(count_of_a) {
            self.ends[1] = self.ends[1].min(along_b.dot(b.mesh().vertex(i - count_of_a)));
        }
        let taken = ((until - self.looked) as u64).div_ceil(PER_WORK);
        self.looked = until;
        if until < count_of_a + count_of_b {
            return (taken, None);
        }
        (self.looked, self.due) = (0, 2 * work);
        let largest = |tree: &Tree| {
            let bounds = tree.mesh().aabb();
            bounds.min.abs().max(bounds.max.abs()).max_element()
        };
        let shift = b_in_a.translation();
        let error =
            ROUNDINGS * (largest(a) + largest(b) + shift.abs().max_element()) + f64::MIN_POSITIVE;
        let gap =
            (self.ends[1] - self.ends[0] + along.dot(shift) - error) * (1.0 - 4.0 * f64::EPSILON);
        // NaN proves nothing.
        (
            taken,
            Some(gap).filter(|gap| *gap > 0.0 && *gap < f64::INFINITY),
        )
    }
}
