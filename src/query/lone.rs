//! A mesh of one triangle against another mesh: the triangle is placed in the other mesh once, and no node of its own is opened.
//!
//! Each node of the other mesh is opened along the triangle's plane, its three sides and the axes of the node. Along the
//! triangle's own directions it is known in `f64`, so however large it is, there it is no less exact than the mesh. The proof of
//! the margins is in `docs/numerics.md`, "A lone triangle".

use super::boxes::Boxes;
use super::expand::{self, Sink};
use super::queue::Pair;
use super::triangle_pairs::rows;
use super::views::{rounding, transposed};
use crate::math::lanes::{Column, F8, Lanes, dot, per_axis};
use crate::math::tolerance::ROUNDING;
use crate::math::{Pose, larger, largest, smaller};
use crate::tree::{Node, Tree, WIDTH, power_of_two};
use crate::triangle::batch::{Crossings, LEAST_EDGE_SLOP, Verdicts};
use crate::triangle::lone::{Placed, Prism};
use glam::DVec3;
use wide::f32x4;

/// A triangle in the unit coordinates of the other mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lone {
    /// Whether it is A.
    is_a: bool,
    /// After its directions come its corners, the last one twice.
    prism: Prism,
    /// Whether its sides are looked at, or its plane only.
    has_sides: bool,
    /// What the test on the axes of a node must allow for.
    margin: f32,
    placed: Placed,
}

/// Beyond this no coordinate of the other mesh lies.
const FAR: f64 = 8.0;

/// Coordinates of the triangle from which on it is not looked at.
const LIMIT: f64 = (1u64 << 40) as f64;

/// The sides of a triangle with shorter edges part few boxes.
const SHORT: f64 = 0.25;

/// The vector with length 1, or 0 if it is too short for that.
#[inline(always)]
fn unit(v: DVec3) -> DVec3 {
    let square = v.length_squared();
    if square > 1e-280 { v * (1.0 / libm::sqrt(square)) } else { DVec3::ZERO }
}

/// The least and the greatest of the corners along a direction, as far as the other mesh reaches.
#[inline(always)]
fn ends(direction: DVec3, [p, q, r]: [DVec3; 3]) -> [f64; 2] {
    let (x, y, z) = (direction.dot(p), direction.dot(q), direction.dot(r));
    [smaller(x, smaller(y, z)), larger(x, larger(y, z))].map(|end| smaller(larger(end, -FAR), FAR))
}

/// The room above and below a triangle, and whether its sides are worth a look.
#[inline(always)]
fn prism(corners: [DVec3; 3], slop: f64) -> (Prism, bool) {
    let [p, q, r] = corners;
    let (e, f) = (q - p, r - p);
    let normal = e.cross(f);
    let is_flat = normal.length_squared() <= 1e-12 * e.length_squared() * f.length_squared();
    let has_sides = largest(e.abs()) > SHORT && !is_flat;
    let slack = 128.0 * f64::from(ROUNDING) + slop;
    let mut directions = [unit(normal), DVec3::ZERO, DVec3::ZERO, DVec3::ZERO];
    let [low, high] = ends(directions[0], corners);
    let mut reach = [((high - low) * 0.5 + slack) as f32; 4];
    if has_sides {
        for (i, side) in [e, r - q, -f].into_iter().enumerate() {
            directions[i + 1] = unit(side.cross(normal));
            reach[i + 1] = (ends(directions[i + 1], corners)[1] + slack) as f32;
        }
    }
    let [n, x, y, z] = directions;
    let all = [n, x, y, z, p, q, r, r];
    let vectors = per_axis!(k => all.map(|v| v[k] as f32));
    (Prism { vectors, middle: ((low + high) * 0.5) as f32, reach, slack: (2.0 * slack) as f32 }, has_sides)
}

impl Lone {
    /// If one of the meshes is a single triangle, and the other is not.
    #[inline(always)]
    pub fn is_one([a, b]: [&Tree; 2]) -> bool {
        (a.mesh().len() == 1) != (b.mesh().len() == 1)
    }

    /// The triangle of the mesh that has only one.
    pub fn new([a, b]: [&Tree; 2], b_in_a: &Pose) -> Self {
        let is_a = a.mesh().len() == 1;
        let (lone, mesh) = if is_a { (a, b.unit()) } else { (b, a.unit()) };
        let corners = lone.mesh().triangle(0);
        let [p, q, r] = if is_a {
            let back = b_in_a.rotation().inverse();
            corners.map(|x| mesh.point(back * (x - b_in_a.translation())))
        } else {
            corners.map(|x| mesh.point(b_in_a.transform_point(x)))
        };
        let edge_slop = 8.0 * rounding(mesh, lone.unit(), b_in_a) / mesh.length();
        let slop = edge_slop + power_of_two(-43);
        let size = larger(largest(p.abs()), larger(largest(q.abs()), largest(r.abs())));
        if !(size < LIMIT && slop < 1.0) {
            return Self { is_a, ..Self::BLIND };
        }
        let (prism, has_sides) = prism([p, q, r], slop);
        Self {
            is_a,
            prism,
            has_sides,
            margin: (f64::from(ROUNDING) * (32.0 + 16.0 * size) + slop) as f32,
            placed: Placed {
                first: p.to_array(),
                edges: [q - p, r - p].map(|edge| edge.as_vec3().to_array()),
                slop: slop as f32,
                edge_slop: edge_slop as f32 * (2.0 / ROUNDING) + LEAST_EDGE_SLOP,
            },
        }
    }

    /// For what `f32` cannot hold: all boxes are met.
    const BLIND: Self = Self {
        is_a: false,
        prism: Prism { vectors: [[0.0; 8]; 3], middle: 0.0, reach: [FAR as f32; 4], slack: 0.0 },
        has_sides: false,
        margin: 1e6,
        placed: Placed { first: [0.0; 3], edges: [[0.0; 3]; 2], slop: 1e6, edge_slop: 1e6 },
    };

    /// How deep the children's boxes reach into the triangle, the least over all directions; negative where they are apart.
    #[inline(always)]
    fn depths<L: Lanes>(&self, lanes: L, node: &Node) -> F8<L> {
        let vectors = per_axis!(k => F8::load(lanes, &self.prism.vectors[k]));
        let seen = per_axis!(k => {
            dot(per_axis!(i => F8::splat(lanes, node.rows[i].as_array()[k])), vectors).halves()
        });
        let [p, q, r] = transposed(per_axis!(k => seen[k][1]));
        let (low, high) = (p.fast_min(q).fast_min(r), p.fast_max(q).fast_max(r));
        let (middle, reach) = ((low + high) * f32x4::HALF, (high - low) * f32x4::HALF + f32x4::splat(self.margin));
        let boxes = Boxes::children(lanes, node, 1.0);
        let [x, y, z] = per_axis!(k => {
            let reach = boxes.half[k] + F8::splat(lanes, reach.as_array()[k]);
            reach - (boxes.center[k] - F8::splat(lanes, middle.as_array()[k])).abs()
        });
        let mut depth = x.min(y).min(z);
        for i in 0..if self.has_sides { 4 } else { 1 } {
            let axis = per_axis!(k => F8::splat(lanes, seen[k][0].as_array()[i]));
            let (at, half) = (dot(axis, boxes.center), dot(per_axis!(k => axis[k].abs()), boxes.half));
            let at = if i == 0 { (at - F8::splat(lanes, self.prism.middle)).abs() } else { at };
            depth = depth.min(half + F8::splat(lanes, self.prism.reach[i]) - at);
        }
        depth
    }

    /// Replaces a pair by those with the children that the triangle may meet.
    #[inline(always)]
    pub fn open<L: Lanes>(&self, lanes: L, pair: Pair, trees: [&Tree; 2], sink: &mut impl Sink) {
        let side = usize::from(self.is_a);
        let at = pair.nodes[side];
        let node = &trees[side].nodes()[at as usize];
        sink.count(usize::from(node.depth) + 1, u32::from(node.children));
        let depths = self.depths(lanes, node);
        depths.put(&mut sink.keys()[0]);
        let hits = u64::from(!depths.mask() & node.valid());
        let first = node.first_child;
        if node.is_cluster {
            if self.is_a {
                sink.triangles(hits, [0, first]);
            } else {
                sink.triangles(expand::transposed(hits), [first, 0]);
            }
        } else if self.is_a {
            sink.pairs(hits, |i| Pair::new(0, first + i));
        } else {
            sink.pairs(hits, |i| Pair::new(first + i, 0));
        }
    }

    /// Tests it against the triangles of eight pairs; tells the crossings of hits, if they are wanted.
    #[inline(always)]
    pub fn test<L: Lanes>(
        &self,
        lanes: L,
        trees: [&Tree; 2],
        pairs: [[u32; 2]; WIDTH],
        mut crossings: Option<&mut Crossings>,
    ) -> Verdicts {
        let side = usize::from(self.is_a);
        let rows = rows(trees[side], pairs, side);
        let mut verdicts = Verdicts::NONE;
        if self.has_sides && crossings.is_none() {
            verdicts.add(self.prism.test(lanes, rows));
            if verdicts.doubt == 0 {
                return verdicts;
            }
        }
        verdicts.add(self.placed.test(lanes, rows, crossings.as_deref_mut()));
        if let Some(crossings) = crossings
            && self.is_a
        {
            crossings.exchange();
        }
        verdicts
    }
}
