//! A mesh of one triangle against another mesh: the triangle is placed in the other mesh once, and no node of its own is opened.
//!
//! Each node of the other mesh is opened along the triangle's plane, its three sides and the axes of the node. Along the
//! triangle's own directions it is known in `f64`, so however large it is, there it is no less exact than the mesh. The proof of
//! the margins is in `docs/numerics.md`, "A lone triangle".

use super::boxes::Boxes;
use super::queue::Pair;
use super::triangle_pairs::rows;
use super::views::{rounding, transposed};
use crate::math::lanes::{Column, D4, F8, Kernel, Lanes, cross, dot, per_axis, scaled};
use crate::math::tolerance::ROUNDING;
use crate::math::{Pose, larger, smaller};
use crate::tree::{Node, Tree, Unit, WIDTH, power_of_two};
use crate::triangle::batch::{Crossings, LEAST_EDGE_SLOP, Rows, Verdicts};
use crate::triangle::lone::{NORMAL, Placed, Prism};
use glam::{DMat3, DVec3};
use wide::f32x4;

/// A triangle in the unit coordinates of the other mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lone<'t> {
    /// All ones in the place of the other mesh.
    places: [u32; 2],
    pub other: &'t Tree,
    /// Its corners, the first one twice, by component.
    corners: [f32x4; 3],
    /// Whether it is tested along the axes of nodes; of one that passes all of the other mesh only the plane is of interest.
    has_box: bool,
    /// Whether it is tested along its normal.
    has_normal: bool,
    prism: Prism,
    /// What the test on the axes of a node must allow for.
    margin: f32,
    placed: Placed,
}

/// Beyond this no coordinate of the other mesh lies.
const FAR: f64 = 8.0;

/// Coordinates of the triangle from which on it is not looked at.
const LIMIT: f64 = (1u64 << 40) as f64;

/// The sides of a triangle part few boxes if none is longer.
const SHORT: f64 = 0.25;

/// Then neither does its normal.
const TINY: f64 = 1.0 / 32.0;

/// Sides farther out part none, however inexact: the other mesh reaches no farther than the root of 3.
const COVERED: f64 = 3.0;

/// Brings the triangle of the mesh that has only one into the coordinates of the other.
pub(super) struct Placing<'t> {
    pub trees: [&'t Tree; 2],
    pub b_in_a: &'t Pose,
}

/// Vectors to a length of 1 or a little less, or far less if they are too short for that.
#[inline(always)]
fn units<L: Lanes>(lanes: L, vectors: [D4<L>; 3]) -> [D4<L>; 3] {
    let factor = dot(vectors, vectors)
        .max(D4::splat(lanes, 1e-280))
        .inverse_root();
    scaled(vectors, factor)
}

/// Not beyond what the other mesh reaches.
#[inline(always)]
fn cut_off<L: Lanes>(lanes: L, ends: D4<L>) -> D4<L> {
    ends.max(D4::splat(lanes, -FAR)).min(D4::splat(lanes, FAR))
}

impl<'t> Placing<'t> {
    /// Its corners in unit coordinates of the other mesh, the first one twice.
    #[inline(always)]
    fn corners<L: Lanes>(&self, lanes: L, is_a: bool, lone: &Tree, other: &Unit) -> [D4<L>; 3] {
        let [p, q, r] = lone.mesh().triangle(0);
        let translation = self.b_in_a.translation();
        let (rotation, before, after) = if is_a {
            (self.b_in_a.rotation().inverse(), translation, DVec3::ZERO)
        } else {
            (*self.b_in_a.rotation(), DVec3::ZERO, translation)
        };
        let DMat3 {
            x_axis: x,
            y_axis: y,
            z_axis: z,
        } = rotation;
        let [a, b, c] = per_axis!(k => D4::load(lanes, &[p[k], q[k], r[k], p[k]]) - D4::splat(lanes, before[k]));
        per_axis!(k => {
            let turned = D4::splat(lanes, x[k]) * a + D4::splat(lanes, y[k]) * b + D4::splat(lanes, z[k]) * c;
            let placed = turned + D4::splat(lanes, after[k]);
            (placed - D4::splat(lanes, other.origin[k])) * D4::splat(lanes, other.scale())
        })
    }
}

impl<'t> Kernel for Placing<'t> {
    type Output = Lone<'t>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Lone<'t> {
        let [a, b] = self.trees;
        let is_a = a.mesh().len() == 1;
        let (lone, other) = if is_a { (a, b) } else { (b, a) };
        let places = if is_a { [0, u32::MAX] } else { [u32::MAX, 0] };
        let corners = self.corners(lanes, is_a, lone, other.unit());
        let edge_slop =
            8.0 * rounding(other.unit(), lone.unit(), self.b_in_a) * other.unit().scale();
        let slop = edge_slop + power_of_two(-43);
        let [x, y, z] = corners;
        let [p, q, r, _] = x
            .max(y)
            .max(z)
            .max(D4::splat(lanes, 0.0) - x.min(y).min(z))
            .store();
        let size = larger(p, larger(q, r));
        if !(size < LIMIT && slop < 1.0) {
            return Lone::blind(places, other);
        }
        // The side after each corner.
        let sides = per_axis!(k => corners[k].turned() - corners[k]);
        let squares = dot(sides, sides);
        let [p, q, r, _] = squares.store();
        let longest = larger(p, larger(q, r));
        let prism = prism(lanes, corners, sides, squares, longest, slop);
        let edges = per_axis!(k => sides[k].store());
        Lone {
            places,
            other,
            corners: per_axis!(k => corners[k].narrow()),
            has_box: !prism.is_whole || prism.has_sides,
            has_normal: longest > TINY * TINY,
            prism,
            margin: (f64::from(ROUNDING) * (32.0 + 16.0 * size) + slop) as f32,
            placed: Placed {
                first: per_axis!(k => corners[k].store()[0]),
                edges: [
                    per_axis!(k => edges[k][0] as f32),
                    per_axis!(k => -edges[k][2] as f32),
                ],
                slop: slop as f32,
                edge_slop: edge_slop as f32 * (2.0 / ROUNDING) + LEAST_EDGE_SLOP,
            },
        }
    }
}

/// The room above and below a triangle with these corners, and the sides and their squares after each of them.
#[inline(always)]
fn prism<L: Lanes>(
    lanes: L,
    corners: [D4<L>; 3],
    sides: [D4<L>; 3],
    squares: D4<L>,
    longest: f64,
    slop: f64,
) -> Prism {
    let slack = 128.0 * f64::from(ROUNDING) + slop;
    let (mut normal, mut middle, mut room, mut is_whole) = ([0.0; 3], 0.0, 0.0, false);
    let (mut across, mut ends, mut has_sides) = ([f32x4::ZERO; 3], f32x4::ZERO, false);
    if longest > TINY * TINY {
        // From each side and the next one.
        let normals = cross(sides, per_axis!(k => sides[k].turned()));
        let least = D4::splat(lanes, 1e-12) * squares * squares.turned();
        is_whole = longest > SHORT * SHORT && least.less(dot(normals, normals)).mask() & 7 == 7;
        normal = per_axis!(k => units(lanes, normals)[k].store()[0]);
        let along = dot(per_axis!(k => D4::splat(lanes, normal[k])), corners);
        let [p, q, r, _] = cut_off(lanes, along).store();
        let (low, high) = (smaller(p, smaller(q, r)), larger(p, larger(q, r)));
        (middle, room) = ((low + high) * 0.5, (high - low) * 0.5);
        if is_whole {
            let directions = units(lanes, cross(sides, normals));
            let next = per_axis!(k => corners[k].turned());
            let last = per_axis!(k => next[k].turned());
            let high = dot(directions, corners)
                .max(dot(directions, next))
                .max(dot(directions, last));
            has_sides = D4::splat(lanes, COVERED).less(high).mask() & 7 != 7;
            ends = (cut_off(lanes, high) + D4::splat(lanes, slack)).narrow();
            across = per_axis!(k => directions[k].narrow());
        }
    }
    let with_normal = |[x, y, z, _]: [f32; 4], w: f64| [x, y, z, w as f32];
    Prism {
        directions: per_axis!(k => with_normal(across[k].to_array(), normal[k])),
        middle: middle as f32,
        reach: with_normal(ends.to_array(), room + slack),
        slack: (2.0 * slack) as f32,
        has_sides,
        is_whole,
    }
}

impl<'t> Lone<'t> {
    /// If one of the meshes is a single triangle, and the other is not.
    #[inline(always)]
    pub fn is_one([a, b]: [&Tree; 2]) -> bool {
        (a.mesh().len() == 1) != (b.mesh().len() == 1)
    }

    /// For what `f32` cannot hold: all boxes are met.
    #[cold]
    fn blind(places: [u32; 2], other: &'t Tree) -> Self {
        Self {
            places,
            other,
            corners: [f32x4::ZERO; 3],
            has_box: false,
            has_normal: false,
            prism: Prism::NONE,
            margin: 0.0,
            placed: Placed {
                first: [0.0; 3],
                edges: [[0.0; 3]; 2],
                slop: 1e6,
                edge_slop: 1e6,
            },
        }
    }

    /// Whether it is A.
    #[inline(always)]
    pub fn is_a(&self) -> bool {
        self.places[0] == 0
    }

    /// What a pair has of the other mesh; the triangle and its node have the number 0.
    #[inline(always)]
    pub fn other_of(&self, pair: Pair) -> u32 {
        pair.nodes[0] | pair.nodes[1]
    }

    /// The numbers of the triangle and of something of the other mesh, in their places.
    #[inline(always)]
    pub fn with(&self, other: u32) -> [u32; 2] {
        self.places.map(|place| other & place)
    }

    /// The pair with a node.
    #[inline(always)]
    pub fn pair(&self, node: u32) -> Pair {
        let [a, b] = self.with(node);
        Pair::new(a, b)
    }

    /// How deep the children's boxes reach into the triangle, the least over all directions; negative where they are apart, or
    /// there is none.
    #[inline(always)]
    pub fn depths<L: Lanes>(&self, lanes: L, node: &Node) -> F8<L> {
        let vectors =
            per_axis!(k => F8::join(lanes, f32x4::new(self.prism.directions[k]), self.corners[k]));
        let seen = per_axis!(k => {
            dot(per_axis!(i => F8::splat(lanes, node.rows[i].as_array()[k])), vectors).halves()
        });
        let boxes = Boxes::children(lanes, node, 1.0);
        let mut depth = F8::load(lanes, &PRESENT[usize::from(node.children).min(WIDTH)]);
        if self.has_normal {
            let directions = per_axis!(k => seen[k][0]);
            depth = depth.min(self.depth_along(lanes, NORMAL, &directions, &boxes));
            if self.prism.has_sides {
                let [x, y, z] = per_axis!(i => self.depth_along(lanes, i, &directions, &boxes));
                depth = depth.min(x.min(y).min(z));
            }
        }
        if self.has_box {
            let [p, q, r] = transposed(per_axis!(k => seen[k][1]));
            let (low, high) = (p.fast_min(q).fast_min(r), p.fast_max(q).fast_max(r));
            let margin = F8::splat(lanes, self.margin);
            let [x, y, z] = per_axis!(k => {
                let (center, half) = (boxes.center[k], boxes.half[k] + margin);
                let below = center + half - F8::splat(lanes, low.as_array()[k]);
                below.min(F8::splat(lanes, high.as_array()[k]) - (center - half))
            });
            depth = depth.min(x.min(y).min(z));
        }
        depth
    }

    /// The same along one of its directions, as seen along the axes of the boxes.
    #[inline(always)]
    fn depth_along<L: Lanes>(
        &self,
        lanes: L,
        i: usize,
        directions: &[f32x4; 3],
        boxes: &Boxes<L>,
    ) -> F8<L> {
        let axis = per_axis!(k => F8::splat(lanes, directions[k].as_array()[i]));
        let reach =
            dot(per_axis!(k => axis[k].abs()), boxes.half) + F8::splat(lanes, self.prism.reach[i]);
        let [x, y, z] = per_axis!(k => axis[k] * boxes.center[k]);
        let at = if i == NORMAL {
            ((x - F8::splat(lanes, self.prism.middle)) + (y + z)).abs()
        } else {
            x + (y + z)
        };
        reach - at
    }

    /// The other triangles of eight pairs.
    #[inline(always)]
    pub fn rows(&self, pairs: [[u32; 2]; WIDTH]) -> [&'t Rows; WIDTH] {
        rows(self.other, pairs, usize::from(self.is_a()))
    }

    /// Tests it against eight triangles; tells the crossings of hits, if they are wanted.
    #[inline(always)]
    pub fn test<L: Lanes>(
        &self,
        lanes: L,
        rows: [&Rows; WIDTH],
        mut crossings: Option<&mut Crossings>,
    ) -> Verdicts {
        let mut verdicts = Verdicts::NONE;
        if self.prism.is_whole && crossings.is_none() {
            verdicts.add(self.prism.test(lanes, rows));
            if verdicts.doubt == 0 {
                return verdicts;
            }
        }
        verdicts.add(self.placed.test(lanes, rows, crossings.as_deref_mut()));
        if let Some(crossings) = crossings
            && self.is_a()
        {
            crossings.exchange();
        }
        verdicts
    }
}

/// Above all depths for each child that there is, below 0 for others.
const PRESENT: [[f32; WIDTH]; WIDTH + 1] = {
    let mut present = [[-1.0; WIDTH]; WIDTH + 1];
    let mut count = 0;
    while count <= WIDTH {
        let mut lane = 0;
        while lane < count {
            present[count][lane] = f32::MAX;
            lane += 1;
        }
        count += 1;
    }
    present
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Instructions;

    struct Unit([f64; 3]);

    impl Kernel for Unit {
        type Output = DVec3;

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> DVec3 {
            per_axis!(k => units(lanes, per_axis!(i => D4::splat(lanes, self.0[i])))[k].store()[k])
                .into()
        }
    }

    #[test]
    fn directions_have_a_length_of_1_or_a_little_less() {
        for i in 0..4000 {
            let length = libm::exp2(f64::from(i) * 0.05 - 120.0);
            let [x, y, z] = [[1.0, 0.0, 0.0], [-0.48, 0.6, 0.64], [0.0, 0.8, -0.6]][i as usize % 3];
            let vector = [x * length, y * length, z * length];
            let unit = Instructions::detect().run(Unit(vector));
            assert!(
                (0.93..=1.0).contains(&unit.length()),
                "{length}: {}",
                unit.length()
            );
            assert_eq!(unit, Instructions::PORTABLE.run(Unit(vector)));
        }
        for vector in [[0.0; 3], [1e-200, 0.0, -1e-300], [5e-324; 3], [1e-140; 3]] {
            assert!(
                Instructions::detect().run(Unit(vector)).length() <= 1.0,
                "{vector:?}"
            );
        }
    }
}
