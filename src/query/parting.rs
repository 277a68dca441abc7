//! A plane between two surfaces: how far apart they are at least, by how far each reaches along one
//! direction.
//!
//! However many boxes overlap where two bodies touch or all but touch, if both are convex there, as
//! most parts of robots and most things that lie on one another are, a plane parts them. To try one
//! takes the corner of each that is the farthest along a direction
//! ([`Extremes`](crate::tree::Extremes)); where these overlap, they say which way to turn the next
//! (GJK). The direction is kept for the next frame, in which it mostly parts them again. The proof
//! is in `docs/numerics.md`, "A plane between two surfaces".

use super::views::Relation;
use super::workspace::Workspace;
use crate::math::Pose;
use crate::math::lanes::{Kernel, Lanes};
use crate::math::tolerance::ROUNDING;
use crate::tree::{Tree, xyz};
use arrayvec::ArrayVec;
use glam::{DVec3, Vec3};
use wide::f32x4;

/// The direction across the last plane, from A to B, in A's frame and of length 1; 0 if there was
/// none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Parting([f32; 3]);

impl Parting {
    /// A lower bound of the distance of two meshes that keep their extremes, in their unit of
    /// length; and how many planes were tried, beginning with the last one. If none of so many
    /// parts them, it is 0. `O(1)` in the mean: a few dozen corners a plane.
    pub fn distance(
        &mut self,
        trees: [&Tree; 2],
        b_in_a: &Pose,
        most: u32,
        workspace: &Workspace,
    ) -> (f64, u32) {
        let [a, b] = trees;
        if !a.has_extremes() || !b.has_extremes() {
            return (0.0, 0);
        }
        let relation = &Relation::new(a, b, b_in_a);
        if *self == Self::default() {
            self.0 = relation
                .middle()
                .try_normalize()
                .unwrap_or(DVec3::X)
                .as_vec3()
                .to_array();
        }
        let (gap, tried) = workspace.instructions.run(Search {
            trees,
            relation,
            most,
            direction: &mut self.0,
        });
        (f64::from(gap / LONGEST) * relation.unit, tried)
    }
}

/// No direction is longer.
const LONGEST: f32 = 1.000_01;

/// How much farther a corner may reach that is not among the extremes, in unit coordinates.
const LEFT_OUT: f32 = 96.0 * ROUNDING;

struct Search<'s> {
    trees: [&'s Tree; 2],
    relation: &'s Relation,
    most: u32,
    direction: &'s mut [f32; 3],
}

impl Kernel for Search<'_> {
    type Output = (f32, u32);

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> (f32, u32) {
        let Self {
            trees: [a, b],
            relation,
            most,
            direction,
        } = self;
        let (linear, middle) = (relation.linear(), relation.middle());
        let [in_a, in_b] = relation.place.margin.map(|margin| margin.as_array()[0]);
        let margin = in_a.min(in_b) + LEFT_OUT * (1.0 + relation.scale);
        let mut simplex = Simplex::default();
        for tried in 1..=most {
            let [x, y, z] = *direction;
            let (of_b, place) = relation.of_b(f32x4::new([x, y, z, 0.0]));
            let (end_a, p) = a.extremes().farthest(lanes, *direction);
            let (end_b, q) = b.extremes().farthest(lanes, xyz(-of_b));
            let gap = place - end_a - end_b - margin;
            if gap > 0.0 {
                return (gap, tried);
            }
            let nearest = simplex.add(
                (linear * Vec3::from(q).as_dvec3() + middle - Vec3::from(p).as_dvec3()).as_vec3(),
            );
            let Some(next) = nearest.and_then(Vec3::try_normalize) else {
                return (0.0, tried);
            };
            *direction = next.to_array();
        }
        (0.0, most)
    }
}

/// Ways from corners of A to corners of B, of which the nearest to the origin of all that lie
/// between them is sought (Gilbert, Johnson, Keerthi, "A fast procedure for computing the distance
/// between complex objects in three-dimensional space", 1988).
#[derive(Default)]
struct Simplex(ArrayVec<Vec3, 4>);

impl Simplex {
    /// Adds one, and leaves only those that the nearest is between. `None` if that is the origin,
    /// or it was known.
    #[inline(always)]
    fn add(&mut self, new: Vec3) -> Option<Vec3> {
        if self.0.contains(&new) || self.holds_the_origin(new) {
            return None;
        }
        let (mut nearest, mut kept, mut least) = (new, [None; 2], new.length_squared());
        let mut try_it = |point: Vec3, of: [Option<Vec3>; 2]| {
            if point.length_squared() < least {
                (nearest, kept, least) = (point, of, point.length_squared());
            }
        };
        for (i, &x) in self.0.iter().enumerate() {
            let edge = x - new;
            let foot = |from: Vec3| from - edge * (from.dot(edge) / edge.length_squared());
            if new.dot(edge) < 0.0 && x.dot(edge) > 0.0 {
                // Twice: what is much shorter than the edge is not quite across it the first time.
                try_it(foot(foot(new)), [Some(x), None]);
            }
            for &y in &self.0[i + 1..] {
                let other = y - new;
                let normal = edge.cross(other);
                let size = normal.length_squared();
                let [s, t] = [other.cross(new), new.cross(edge)].map(|part| part.dot(normal));
                if s > 0.0 && t > 0.0 && s + t < size {
                    try_it(normal * (new.dot(normal) / size), [Some(x), Some(y)]);
                }
            }
        }
        self.0 = kept.into_iter().flatten().chain([new]).collect();
        Some(nearest)
    }

    /// Whether it lies between four.
    fn holds_the_origin(&self, new: Vec3) -> bool {
        let [x, y, z] = self.0[..] else { return false };
        let whole = (x - new).dot((y - new).cross(z - new));
        let parts = [
            new.dot(z.cross(y)),
            new.dot(x.cross(z)),
            new.dot(y.cross(x)),
            x.dot(y.cross(z)),
        ];
        parts.iter().all(|part| part * whole > 0.0)
    }
}
