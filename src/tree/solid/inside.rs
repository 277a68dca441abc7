//! The winding number of a surface about a point, by counting what a ray crosses.
//!
//! The ray goes along that axis on which it leaves the mesh's box soonest. A crossing from the back
//! counts 1, one from the front -1. Triangles that `f32` leaves in doubt are decided exactly, and
//! there are no ties ([`punctual_geom::triangle::crossing`]). So the count is exact for closed
//! surfaces.

use super::local_ray::LocalRay;
use crate::tree::{MAX_HEIGHT, Node, Tree, WIDTH};
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual_geom::lanes::{Instructions, Kernel, Lanes, per_lane};
use punctual_geom::triangle::crossing::{Crossing, Heading, crossing};
use punctual_geom::triangle::ray::batch::candidates;
use punctual_geom::{Pose, Ray, bits, largest};

/// A ray from a point, to be counted along.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe {
    pub point: DVec3,
    pub heading: Heading,
    /// True if the point is outside of the mesh's box. Then the ray meets nothing.
    pub is_outside: bool,
    local_ray: LocalRay,
}

/// The crossings of a ray, and whether a triangle holds its origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Hits of backs minus hits of fronts. Triangles that hold the origin do not count. So for a
    /// closed surface this is the winding number just ahead of the origin.
    pub winding: i32,
    /// True if a triangle holds the origin.
    pub is_on_surface: bool,
    /// A triangle (tree order) that holds the origin, if there is one.
    pub touched: u32,
}

impl Count {
    /// True if the point is in a closed solid, or on its surface.
    pub fn is_inside(self) -> bool {
        self.winding > 0 || self.is_on_surface
    }
}

impl Probe {
    /// The state before the first point.
    pub const NONE: Self = Self {
        point: DVec3::ZERO,
        heading: Heading {
            axis: 0,
            is_negative: false,
        },
        is_outside: true,
        local_ray: LocalRay::BLIND,
    };

    /// A ray from `point`, along the axis on which it leaves the mesh's box soonest.
    #[inline(always)]
    pub fn new(tree: &Tree, point: DVec3) -> Self {
        let bounds = tree.mesh.aabb();
        // A difference is negative if and only if its exact value is.
        let ways = [bounds.max - point, point - bounds.min];
        let (mut heading, mut least) = (Self::NONE.heading, f64::INFINITY);
        for axis in 0..3 {
            for (way, is_negative) in ways.iter().zip([false, true]) {
                if way[axis] < least {
                    (heading, least) = (Heading { axis, is_negative }, way[axis]);
                }
            }
        }
        let is_outside = !(0.0..f64::INFINITY).contains(&least);
        let local_ray = match Ray::new(point, heading.vector()) {
            Ok(ray) if !is_outside => LocalRay::new(&tree.unit, &ray),
            _ => LocalRay::BLIND,
        };
        Self {
            point,
            heading,
            is_outside,
            local_ray,
        }
    }

    /// The mask of the children of a node that the ray may enter.
    #[inline(always)]
    pub fn enter<L: Lanes>(&self, lanes: L, node: &Node) -> u32 {
        self.local_ray.enter(lanes, node, 0.0).1
    }

    /// Masks of the triangles of a leaf that the ray certainly leaves through, that it certainly
    /// enters through, and of those in doubt, among those whose boxes it may enter.
    #[inline(always)]
    pub fn sort<L: Lanes>(&self, lanes: L, tree: &Tree, leaf: &Node, entered: u32) -> [u32; 3] {
        let triangles = &tree.triangles[leaf.triangle_range()];
        let last = triangles.len() - 1;
        let rows = per_lane!(i => &triangles[last.min(i)].0);
        let limits = [self.local_ray.from, self.local_ray.to];
        let found = candidates(lanes, rows, &self.local_ray.unit_ray, limits);
        let chosen = found.may_meet & entered;
        let [leaves, enters] = [found.back, found.front].map(|faces| faces & found.after & chosen);
        [leaves, enters, chosen & !(leaves | enters)]
    }

    /// A ray from a point in the frame of A, among the triangles of B at its pose. The axis is one
    /// of A. For the boxes it is seen from B's mesh; exact tests take the corners in A's frame.
    pub fn posed(tree: &Tree, b_in_a: &Pose, point: DVec3) -> Self {
        // Not the transpose: a pose need not be quite orthonormal, and is used as given.
        let inverse = b_in_a.rotation().inverse();
        let seen = inverse * (point - b_in_a.translation());
        let (unit, bounds) = (&tree.unit, tree.mesh.aabb());
        let sizes = [point, b_in_a.translation(), bounds.min, bounds.max];
        let size: f64 = sizes.map(|v| largest(v.abs())).iter().sum();
        let position_error = POSED_ROUNDING * size;
        let (back, ahead) = (seen - bounds.min, bounds.max - seen);
        let near = Self::new(tree, seen.clamp(bounds.min, bounds.max));
        // The axis of A that is nearest to the one on which the ray leaves B's box soonest.
        let along = *b_in_a.rotation() * near.heading.vector();
        let axis = (0..3).fold(0, |best, axis| {
            if along[axis].abs() > along[best].abs() {
                axis
            } else {
                best
            }
        });
        let heading = Heading {
            axis,
            is_negative: along[axis] < 0.0,
        };
        let is_outside = !(back.min(ahead).cmpge(DVec3::splat(-position_error)).all());
        let local_ray = match Ray::new(seen, inverse * heading.vector()) {
            Ok(ray) if !is_outside => {
                LocalRay::new(unit, &ray).widened(position_error * unit.scale())
            }
            _ => LocalRay::BLIND,
        };
        Self {
            point,
            heading,
            is_outside,
            local_ray,
        }
    }

    /// The probe for surfaces whose corners are off by up to `reach`, in the length unit of the
    /// mesh.
    pub fn widened(self, tree: &Tree, reach: f64) -> Self {
        let local_ray = if self.is_outside {
            self.local_ray
        } else {
            self.local_ray.widened(reach * tree.unit.scale())
        };
        Self { local_ray, ..self }
    }

    /// Counts a triangle (tree order) with these corners exactly.
    pub fn examine(&self, corners: &[DVec3; 3], triangle: u32, count: &mut Count) {
        match crossing(self.point, self.heading, corners) {
            Crossing::Missed => {}
            Crossing::Origin => (count.is_on_surface, count.touched) = (true, triangle),
            Crossing::Leaves => count.winding += 1,
            Crossing::Enters => count.winding -= 1,
        }
    }
}

/// Rounding of a point seen from B, of corners at the pose, and of the direction, relative to the
/// sum of the sizes of all: `docs/numerics.md`.
const POSED_ROUNDING: f64 = 512.0 * f64::EPSILON;

/// Counts the triangles of which `counts` is true along a ray from `point`. `O(n)` at worst.
pub fn crossings(tree: &Tree, point: DVec3, counts: impl Fn(u32) -> bool) -> Count {
    let corners = |triangle| tree.corners(triangle);
    walk(tree, Probe::new(tree, point), counts, corners)
}

/// Counts the triangles along a ray. Those in doubt have these corners, no farther from their own
/// than the ray is widened.
pub(crate) fn crossings_of(
    tree: &Tree,
    probe: Probe,
    corners: impl FnMut(u32) -> [DVec3; 3],
) -> Count {
    walk(tree, probe, |_| true, corners)
}

fn walk(
    tree: &Tree,
    probe: Probe,
    counts: impl Fn(u32) -> bool,
    corners: impl FnMut(u32) -> [DVec3; 3],
) -> Count {
    if probe.is_outside || tree.is_cloud() {
        return Count::default();
    }
    Instructions::detect().run(Walk {
        tree,
        probe,
        counts,
        corners,
    })
}

/// The winding number of a closed solid about a point. Meaningless if it has open edges.
pub fn inside(tree: &Tree, point: DVec3) -> Count {
    crossings(tree, point, |_| true)
}

struct Walk<'t, F, C> {
    tree: &'t Tree,
    probe: Probe,
    counts: F,
    corners: C,
}

/// Most nodes that wait while one is open.
const ROOM: usize = MAX_HEIGHT * (WIDTH - 1) + 1;

impl<F: Fn(u32) -> bool, C: FnMut(u32) -> [DVec3; 3]> Kernel for Walk<'_, F, C> {
    type Output = Count;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Count {
        let Self {
            tree,
            probe,
            counts,
            mut corners,
        } = self;
        let (mut waiting, mut sum) = (ArrayVec::<u32, ROOM>::new(), Count::default());
        waiting.push(0);
        while let Some(index) = waiting.pop() {
            let node = &tree.nodes[index as usize];
            let entered = probe.enter(lanes, node);
            let child = |i: usize| node.first_child + i as u32;
            if !node.is_leaf {
                waiting.extend(bits(entered).map(child));
                continue;
            }
            let chosen = |mask: u32| bits(mask).map(child).filter(|&triangle| counts(triangle));
            let [leaves, enters, in_doubt] = probe.sort(lanes, tree, node, entered);
            sum.winding += chosen(leaves).count() as i32 - chosen(enters).count() as i32;
            chosen(in_doubt)
                .for_each(|triangle| probe.examine(&corners(triangle), triangle, &mut sum));
        }
        sum
    }
}
