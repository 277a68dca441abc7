//! The winding number of a surface about a point, by counting what a ray crosses.
//!
//! The ray goes along that axis on which it leaves the mesh's box soonest. A crossing from the back
//! counts 1, one from the front -1. Triangles that `f32` leaves in doubt are decided exactly, and
//! there are no ties ([`crate::triangle::crossing`]). So the count is exact for closed surfaces.

use super::beam::Beam;
use super::{MAX_HEIGHT, Node, Tree, WIDTH};
use crate::math::lanes::{Instructions, Kernel, Lanes, per_lane};
use crate::math::{Ray, bits};
use crate::triangle::crossing::{Crossing, Heading, crossing};
use crate::triangle::ray::batch::candidates;
use arrayvec::ArrayVec;
use glam::DVec3;

/// A ray from a point, to be counted along.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe {
    pub point: DVec3,
    pub heading: Heading,
    pub beam: Beam,
}

/// What the ray crosses, and whether a triangle holds its origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Count {
    /// Hits of backs minus hits of fronts. Triangles that hold the origin do not count. So for a
    /// closed surface this is the winding number just ahead of the origin.
    pub winding: i32,
    pub is_on_surface: bool,
}

impl Count {
    /// True if the point is in a closed solid, or on its surface.
    pub fn is_inside(self) -> bool {
        self.winding > 0 || self.is_on_surface
    }

    pub fn add(&mut self, other: Self) {
        self.winding += other.winding;
        self.is_on_surface |= other.is_on_surface;
    }
}

impl Probe {
    /// A ray from `point`; `None` if it is outside of the mesh's box.
    pub fn new(tree: &Tree, point: DVec3) -> Option<Self> {
        let bounds = tree.mesh.aabb();
        let (back, ahead) = (point - bounds.min, bounds.max - point);
        // A difference is negative if and only if its exact value is.
        if !(back.min(ahead).cmpge(DVec3::ZERO).all()) {
            return None;
        }
        let (mut heading, mut least) = (
            Heading {
                axis: 0,
                is_negative: false,
            },
            f64::INFINITY,
        );
        for axis in 0..3 {
            for (is_negative, way) in [(false, ahead[axis]), (true, back[axis])] {
                if way < least {
                    (heading, least) = (Heading { axis, is_negative }, way);
                }
            }
        }
        let beam = match Ray::new(point, heading.vector()) {
            Ok(ray) => Beam::new(&tree.unit, &ray),
            Err(_) => Beam::BLIND,
        };
        Some(Self {
            point,
            heading,
            beam,
        })
    }

    /// The mask of the children of a node that the ray may enter.
    #[inline(always)]
    pub fn enter<L: Lanes>(&self, lanes: L, node: &Node) -> u32 {
        self.beam.enter(lanes, node, 0.0).1
    }

    /// Counts those of the triangles of a cluster that the ray may enter and that `counts` is true
    /// of. The second value is the number of exact tests.
    #[inline(always)]
    pub fn count<L: Lanes>(
        &self,
        lanes: L,
        tree: &Tree,
        cluster: &Node,
        entered: u32,
        counts: impl Fn(u32) -> bool,
    ) -> (Count, u32) {
        let triangles = &tree.triangles[cluster.triangle_range()];
        let last = triangles.len() - 1;
        let rows = per_lane!(i => &triangles[last.min(i)].0);
        let found = candidates(
            lanes,
            rows,
            &self.beam.shaft,
            [self.beam.from, self.beam.to],
        );
        let chosen = bits(found.may_meet & entered)
            .filter(|&lane| counts(cluster.first_child + lane as u32))
            .fold(0, |chosen, lane| chosen | 1 << lane);
        let (leaves, enters) = (found.back & found.after, found.front & found.after);
        let mut count = Count {
            winding: (leaves & chosen).count_ones() as i32 - (enters & chosen).count_ones() as i32,
            is_on_surface: false,
        };
        let in_doubt = chosen & !(leaves | enters);
        for lane in bits(in_doubt) {
            let corners = tree.corners(cluster.first_child + lane as u32);
            match crossing(self.point, self.heading, &corners) {
                Crossing::Missed => {}
                Crossing::Origin => count.is_on_surface = true,
                Crossing::Leaves => count.winding += 1,
                Crossing::Enters => count.winding -= 1,
            }
        }
        (count, in_doubt.count_ones())
    }
}

/// Counts the triangles of which `counts` is true along a ray from `point`. `O(n)` at worst.
pub(crate) fn crossings(tree: &Tree, point: DVec3, counts: impl Fn(u32) -> bool) -> Count {
    match Probe::new(tree, point) {
        None => Count::default(),
        Some(probe) => Instructions::detect().run(Walk {
            tree,
            probe,
            counts,
        }),
    }
}

/// The winding number of a closed solid about a point. Meaningless if it has open edges.
pub(crate) fn inside(tree: &Tree, point: DVec3) -> Count {
    crossings(tree, point, |_| true)
}

struct Walk<'t, F> {
    tree: &'t Tree,
    probe: Probe,
    counts: F,
}

/// Most nodes that wait while one is open.
const ROOM: usize = MAX_HEIGHT * (WIDTH - 1) + 1;

impl<F: Fn(u32) -> bool> Kernel for Walk<'_, F> {
    type Output = Count;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Count {
        let Self {
            tree,
            probe,
            counts,
        } = self;
        let (mut waiting, mut sum) = (ArrayVec::<u32, ROOM>::new(), Count::default());
        waiting.push(0);
        while let Some(index) = waiting.pop() {
            let node = &tree.nodes[index as usize];
            let entered = probe.enter(lanes, node);
            if node.is_cluster {
                sum.add(probe.count(lanes, tree, node, entered, &counts).0);
            } else {
                waiting.extend(bits(entered).map(|child| node.first_child + child as u32));
            }
        }
        sum
    }
}
