//! A proven distance, and what remains of it after B has moved.

use crate::tree::Tree;
use punctual_geom::tolerance::UNDERFLOW;
use punctual_geom::{Pose, largest, length};

/// A lower bound of the distance of two surfaces at one pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clearance {
    /// Identities: a refitted tree counts as another surface.
    trees: [usize; 2],
    b_in_a: Pose,
    distance: f64,
}

/// Rounding added to the displacement of a point, relative to the magnitudes of its coordinates and
/// of both translations. Each of a point's two positions takes less than 8 roundings, and the bound
/// on the displacement between them less than 16.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Clearance {
    /// Matches no trees.
    pub const NOTHING: Self = Self {
        trees: [usize::MAX; 2],
        b_in_a: Pose::IDENTITY,
        distance: 0.0,
    };

    pub fn new(a: &Tree, b: &Tree, b_in_a: &Pose, distance: f64) -> Self {
        Self {
            trees: [a.identity(), b.identity()],
            b_in_a: *b_in_a,
            distance,
        }
    }

    /// Lower bound of the distance of these surfaces at another pose: the longest displacement of a
    /// point of B is subtracted. Nothing is known if it is 0 or negative.
    pub fn at(&self, a: &Tree, b: &Tree, b_in_a: &Pose) -> f64 {
        let are_same = self.trees == [a.identity(), b.identity()];
        if are_same {
            self.distance - displacement(b, &self.b_in_a, b_in_a)
        } else {
            0.0
        }
    }
}

/// Upper bound of the displacement of a mesh's points from one pose to another. `D` is the
/// difference of the rotations and `d` that of the translations. A point `c + h` moves by `D c + d
/// + D h`, where `c` is the middle of the mesh's box and `h` is within its half extents.
#[inline]
pub fn displacement(mesh: &Tree, from: &Pose, to: &Pose) -> f64 {
    let bounds = mesh.mesh().aabb();
    let (min, max) = (bounds.min * 0.5, bounds.max * 0.5);
    let (middle, half) = (min + max, max - min);
    let turn = *to.rotation() - *from.rotation();
    let shift = turn * middle + (to.translation() - from.translation());
    let spread =
        turn.x_axis.abs() * half.x + turn.y_axis.abs() * half.y + turn.z_axis.abs() * half.z;
    let [start, end] = [from.translation(), to.translation()];
    let magnitude: f64 = [min, max, start, end]
        .map(|v| largest(v.abs()))
        .iter()
        .sum();
    length(shift.abs() + spread) + ROUNDING * magnitude + UNDERFLOW
}
