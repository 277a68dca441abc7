//! Which components of a solid are convex, up to a slack that is proven.
//!
//! Let all faces of a closed component turn their backs to a point `o`, and let the winding number
//! about `o` be 1. Then each ray from `o` meets the component once. Its gauge `g` is 1 on the
//! surface and linear on the cone over each face: `g(x) = y_f (x - o)`. The component is convex if
//! and only if `g` is. `docs/numerics.md`, "Convex components", bounds by how much it is not.

use super::inside;
use super::{Solidity, ends, position};
use crate::tree::Tree;
use alloc::boxed::Box;
use alloc::vec::Vec;
use glam::DVec3;
use punctual_geom::triangle::side_of_plane;

/// A convex component of a solid: its hull `K`, and how far its inside falls short of that.
#[derive(Clone, Debug, PartialEq)]
pub struct Convex {
    /// The vertices, in the mesh's coordinates.
    pub corners: Box<[DVec3]>,
    /// A point inside.
    pub center: DVec3,
    /// Upper bound of the distance of a vertex from the center.
    pub radius: f64,
    /// Lower bound of the distance of a face from the center.
    pub inradius: f64,
    /// `K`, shrunk about the center by this share, is inside of the component. 0 if no edge is
    /// concave.
    pub slack: f64,
}

/// A component with more slack does not count as convex.
const MOST_SLACK: f64 = 1e-3;

/// Maximum number of pairs of a face and a vertex that are compared to bound the slack.
const MOST_PAIRS: usize = 1 << 22;

/// Rounding of a coordinate relative to the center, in units.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A value and a bound of its error.
type Bounded = [f64; 2];

/// `det(u, v, w)` of vectors whose coordinates are known up to `ROUNDING`.
fn determinant([u, v, w]: [DVec3; 3]) -> Bounded {
    let [p, q, r] = [u, v, w].map(|x| x.abs().element_sum() + ROUNDING);
    [u.cross(v).dot(w), 8.0 * ROUNDING * (p * q + q * r + r * p)]
}

/// The state of a component while its triangles are checked.
#[derive(Clone)]
struct Candidate {
    is_convex: bool,
    center: DVec3,
    radius: f64,
    inradius: f64,
    /// Sum of the slopes that concave edges take from the gauge.
    fall: f64,
    /// Vertex indices.
    corners: Vec<u32>,
    /// Edges without a known neighbor: the positions of their ends, the lower one first, and three
    /// times the triangle plus the index of the edge in it.
    loose: Vec<([[u64; 3]; 2], u32)>,
}

/// The convex components of a solid, by index.
pub(crate) fn convex(tree: &Tree, solid: &Solidity) -> Box<[Option<Convex>]> {
    let of = |triangle: usize| solid.component_of(triangle as u32) as usize;
    let candidate = |one: &super::Component| Candidate {
        is_convex: one.is_closed(),
        center: DVec3::ZERO,
        radius: 0.0,
        inradius: f64::INFINITY,
        fall: 0.0,
        corners: Vec::new(),
        loose: Vec::new(),
    };
    let mut all: Vec<Candidate> = solid.components().iter().map(candidate).collect();
    for (triangle, vertices) in tree.corners.iter().enumerate() {
        let one = of(triangle);
        let share = 1.0 / (3.0 * solid.components()[one].triangles as f64);
        let sum: DVec3 = vertices
            .iter()
            .map(|&vertex| vertex_point(tree, vertex))
            .sum();
        all[one].center += share * sum;
    }
    for triangle in 0..tree.corners.len() {
        let one = &mut all[of(triangle)];
        one.is_convex = one.is_convex && one.add(tree, triangle as u32).is_some();
    }
    for one in all.iter_mut().filter(|one| one.is_convex) {
        one.is_convex = one.join(tree).is_some();
    }
    let mut last_of = alloc::vec![u32::MAX; tree.mesh.vertex_count()];
    for (triangle, vertices) in tree.corners.iter().enumerate() {
        let index = of(triangle);
        if all[index].is_convex {
            for &vertex in vertices {
                let last = core::mem::replace(&mut last_of[vertex as usize], index as u32);
                all[index]
                    .corners
                    .extend((last != index as u32).then_some(vertex));
            }
        }
    }
    let finish = |(index, one): (usize, &Candidate)| one.finish(tree, solid, index);
    all.iter().enumerate().map(finish).collect()
}

impl Candidate {
    /// The corners of a triangle relative to the center, and a lower bound of six times the volume
    /// of the tetrahedron they form with it.
    fn cone(&self, tree: &Tree, triangle: u32) -> ([DVec3; 3], f64) {
        let corners = tree
            .corners(triangle)
            .map(|p| tree.unit.point(p) - self.center);
        let [volume, error] = determinant(corners);
        (corners, volume - error)
    }

    /// Takes a triangle into account. `None` if the component is not convex.
    fn add(&mut self, tree: &Tree, triangle: u32) -> Option<()> {
        let ([p, q, r], volume) = self.cone(tree, triangle);
        let area = (q - p).cross(r - p).length();
        self.inradius = self.inradius.min(volume / (area + 64.0 * ROUNDING));
        for corner in [p, q, r] {
            self.radius = self.radius.max(corner.length());
        }
        for k in 0..3 {
            let edge = 3 * triangle + k as u32;
            match tree.across(triangle, k) {
                Some(next) if next > triangle => {
                    let apex = tree.vertices_of(triangle)[(k + 2) % 3];
                    self.bend(tree, edge, next, tree.vertex_across(triangle, apex, next))?;
                }
                Some(_) => {}
                None => {
                    let mut at = ends(tree, edge).map(|vertex| position(&tree.mesh, vertex));
                    at.sort_unstable();
                    self.loose.push((at, edge));
                }
            }
        }
        (volume > 0.0 && self.inradius > 0.0).then_some(())
    }

    /// Takes the loose edges into account, two by two. `None` if the component is not convex.
    fn join(&mut self, tree: &Tree) -> Option<()> {
        let mut loose = core::mem::take(&mut self.loose);
        loose.sort_unstable();
        for pair in loose.chunk_by(|(one, _), (other, _)| one == other) {
            let &[(_, edge), (_, other)] = pair else {
                return None;
            };
            let (next, k) = (other / 3, other as usize % 3);
            self.bend(tree, edge, next, tree.vertices_of(next)[(k + 2) % 3])?;
        }
        Some(())
    }

    /// Takes an edge into account, the triangle behind it, and the corner of that which is not on
    /// the edge. `None` if the component is not convex.
    fn bend(&mut self, tree: &Tree, edge: u32, next: u32, apex: u32) -> Option<()> {
        let (corners @ [p, q, r], volume) = self.cone(tree, edge / 3);
        let excess = excess(corners, vertex_point(tree, apex) - self.center);
        // Rounding leaves edges between small faces in doubt.
        let is_concave = || {
            let apex = tree.mesh.vertex(apex as usize);
            side_of_plane(&tree.corners(edge / 3), apex) > 0
        };
        if excess > 0.0 && is_concave() {
            let (_, beside) = self.cone(tree, next);
            let [from, to] = [[p, q], [q, r], [r, p]][edge as usize % 3];
            let share = excess / volume;
            if !(volume > 0.0 && share <= MOST_SLACK && beside > 0.0) {
                return None;
            }
            self.fall += share * (from.cross(to).length() + 16.0 * ROUNDING) / beside;
        }
        Some(())
    }

    fn finish(&self, tree: &Tree, solid: &Solidity, index: usize) -> Option<Convex> {
        let is_own = |triangle: &u32| solid.component_of(*triangle) as usize == index;
        let length = tree.unit.length();
        let center = tree.unit.origin + self.center * length;
        let shift = (tree.unit.point(center) - self.center).length() + 4.0 * ROUNDING;
        if !(self.is_convex && shift < self.inradius)
            || inside::crossings(tree, center, |triangle| is_own(&triangle)).winding != 1
        {
            return None;
        }
        let mut slack = 2.0 * self.radius * self.fall;
        let triangles = solid.components()[index].triangles;
        if slack > 0.0 && triangles * self.corners.len() <= MOST_PAIRS {
            let faces = (0..tree.corners.len() as u32).filter(is_own);
            let most = faces.map(|triangle| {
                let (corners, volume) = self.cone(tree, triangle);
                let points = self
                    .corners
                    .iter()
                    .map(|&vertex| vertex_point(tree, vertex));
                let excesses = points.map(|p| excess(corners, p - self.center));
                excesses.fold(0.0, f64::max) / volume
            });
            slack = most.fold(0.0, f64::max).min(slack);
        }
        (slack <= MOST_SLACK).then(|| Convex {
            corners: self
                .corners
                .iter()
                .map(|&vertex| tree.mesh.vertex(vertex as usize))
                .collect(),
            center,
            radius: self.radius * length * (1.0 + 1e-12),
            inradius: self.inradius * length * (1.0 - 1e-12),
            slack,
        })
    }
}

/// A vertex in units.
fn vertex_point(tree: &Tree, vertex: u32) -> DVec3 {
    tree.unit.point(tree.mesh.vertex(vertex as usize))
}

/// Six times the volume by which a point is beyond a triangle: an upper bound.
fn excess([p, q, r]: [DVec3; 3], point: DVec3) -> f64 {
    let [beyond, error] = determinant([q - p, r - p, point - p]);
    beyond + error
}
