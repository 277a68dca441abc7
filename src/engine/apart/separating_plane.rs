//! A separating plane between two surfaces: a lower bound of their distance, from how far each
//! extends along one direction.
//!
//! Many boxes overlap where two bodies touch or nearly touch. But if both are convex there, as most
//! parts of robots and most stacked objects are, a plane separates them. To test a direction, take
//! the corner of each body that is farthest along it ([`Extremes`](crate::tree::Extremes)). If the
//! bodies overlap along the direction, these corners determine the next direction (GJK). The
//! direction is kept for the next frame, in which it usually separates the bodies again. The proof
//! is in `docs/numerics.md`, "A plane between two surfaces".

use crate::engine::boxes::{RelativePose, flushing};
use crate::engine::workspace::Workspace;
use crate::tree::{Tree, xyz};
use arrayvec::ArrayVec;
use glam::{DVec3, Vec3};
use punctual_geom::Pose;
use punctual_geom::lanes::{Kernel, Lanes};
use punctual_geom::tolerance::ROUNDING;
use wide::f32x4;

/// Normal of the last plane: unit vector from A to B in A's frame; 0 if there was none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeparatingPlane([f32; 3]);

impl SeparatingPlane {
    /// Returns a lower bound of the distance of two meshes that keep their extremes, in their
    /// length unit, and the number of planes tried, starting with the last one. The bound is 0 if
    /// none of `most` planes separates them. `O(1)` on average: a few dozen corners per plane.
    pub fn distance(
        &mut self,
        trees: [&Tree; 2],
        b_in_a: &Pose,
        most: u32,
        workspace: &Workspace,
    ) -> (f64, u32) {
        let [a, b] = trees;
        if !a.has_extremes() || !b.has_extremes() || flushing::matters(a, b, b_in_a) {
            return (0.0, 0);
        }
        let relative = &RelativePose::new(a, b, b_in_a);
        if *self == Self::default() {
            self.0 = relative
                .middle()
                .try_normalize()
                .unwrap_or(DVec3::X)
                .as_vec3()
                .to_array();
        }
        let (gap, tried) = workspace.instructions.run(Search {
            trees,
            relative,
            most,
            direction: &mut self.0,
        });
        (f64::from(gap / LONGEST) * relative.unit, tried)
    }
}

/// Upper bound of the length of a direction.
const LONGEST: f32 = 1.000_01;

/// Bound on the distance, in unit coordinates, by which a corner extends beyond the extremes.
const LEFT_OUT: f32 = 96.0 * ROUNDING;

struct Search<'s> {
    trees: [&'s Tree; 2],
    relative: &'s RelativePose,
    most: u32,
    direction: &'s mut [f32; 3],
}

impl Kernel for Search<'_> {
    type Output = (f32, u32);

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> (f32, u32) {
        let Self {
            trees: [a, b],
            relative,
            direction,
            ..
        } = self;
        let (linear, middle) = (relative.linear(), relative.middle());
        let [in_a, in_b] = relative.margin.map(|margin| margin.as_array()[0]);
        let margin = in_a.min(in_b) + LEFT_OUT * (1.0 + relative.scale);
        let mut simplex = Simplex::default();
        for tried in 1..=self.most {
            let [x, y, z] = *direction;
            let (of_b, place) = relative.of_b(f32x4::new([x, y, z, 0.0]));
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
        (0.0, self.most)
    }
}

/// Vectors from corners of A to corners of B. The algorithm searches for the point of their convex
/// hull nearest to the origin (Gilbert, Johnson, Keerthi, "A fast procedure for computing the
/// distance between complex objects in three-dimensional space", 1988).
#[derive(Default)]
struct Simplex(ArrayVec<Vec3, 4>);

impl Simplex {
    /// Adds a vector, and keeps only those whose convex hull contains the nearest point. `None` if
    /// that point is the origin, or the vector was known.
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
                // Twice: a vector much shorter than the edge is not orthogonal to it after one
                // step.
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

    /// True if the origin is inside the tetrahedron of the simplex and `new`.
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
