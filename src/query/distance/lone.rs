//! A body of one point or one segment, such as the core of a ball or a capsule, against the boxes
//! of the other tree: lower bounds of distances in `f32`, eight boxes at a time.
//!
//! Only the nodes of the other tree are opened, and only along their own axes: the lone body needs
//! no box. A bound is the largest of three gaps: along the axes of a box, along the line from its
//! middle to the segment, and along the direction between the closest points found. Their proof:
//! `docs/numerics.md`.

use crate::engine::boxes::RelativePose;
use crate::tree::{Node, Tree};
use glam::DVec3;
use punctual_geom::lanes::{Column, F8, Lanes, V8, per_axis};
use punctual_geom::largest;
use punctual_geom::tolerance::ROUNDING;
use punctual_geom::triangle::distance::{Closest, closest_to_point};
use wide::f32x4;

/// A point or a segment, in the unit coordinates of the tree whose boxes it is compared with.
#[derive(Clone, Copy)]
pub(crate) struct Lone {
    /// True if it is A.
    pub is_a: bool,
    pub is_point: bool,
    middle: [f32; 3],
    /// From the middle to an end.
    half: [f32; 3],
    /// Direction from A to B, no longer than 1.
    along: [f32; 3],
    /// 1 over the square of the length of `half`.
    per_square: f32,
    /// Bound of the errors along an axis.
    margin: f32,
    /// Factor from squares to lower bounds of squares in A's units.
    square_unit: f32,
}

/// Roundings of coordinates and boxes, for a point within the tree's box.
const MARGIN: f64 = 128.0 * ROUNDING as f64;

/// Farther away, in units, the errors of boxes along their own axes are too large.
const MOST_REACH: f64 = 16.0;

/// Part of a box's half extents that does not count in a guess.
const WITHIN: f32 = 0.6;

/// Squares below this count as this when they divide.
const LEAST_SQUARE: f32 = 1e-12;

impl Lone {
    /// The lone body of two, if there is one and its bounds are useful.
    pub fn of(trees: [&Tree; 2], relative: &RelativePose) -> Option<Self> {
        let is_a = !is_lone(trees[1]);
        if is_a && !is_lone(trees[0]) || relative.shrink == 0.0 {
            return None;
        }
        let lone = trees[usize::from(!is_a)];
        let (linear, scale) = (relative.linear(), f64::from(relative.scale));
        let [ends @ .., _] = lone.corners(0).map(|corner| {
            let place = lone.unit().point(corner);
            if is_a {
                linear.transpose() * (place - relative.middle()) / (scale * scale)
            } else {
                linear * place + relative.middle()
            }
        });
        let (middle, half) = ((ends[0] + ends[1]) / 2.0, (ends[1] - ends[0]) / 2.0);
        let reach = largest(middle.abs()) + largest(half.abs());
        let unit = if is_a { scale } else { 1.0 };
        let error = f64::from(relative.triangles.position_error) / unit;
        let turned = MARGIN + f64::from(relative.rotation_error);
        // Also false for NaN.
        let is_near = reach <= MOST_REACH;
        is_near.then(|| Self {
            is_a,
            is_point: ends[0] == ends[1],
            middle: middle.as_vec3().to_array(),
            half: half.as_vec3().to_array(),
            along: [0.0; 3],
            per_square: 1.0 / half.length_squared().max(f64::from(LEAST_SQUARE)) as f32,
            margin: (MARGIN + turned * reach + error) as f32,
            square_unit: (unit * unit) as f32 * relative.shrink * relative.shrink,
        })
    }

    /// Takes a direction from A to B, in A's unit coordinates, of length 1 or less.
    pub fn turn(&mut self, relative: &RelativePose, direction: DVec3) {
        let in_tree = if self.is_a {
            relative.linear().transpose() * direction / f64::from(relative.scale)
        } else {
            direction
        };
        self.along = (in_tree * SHORTER).as_vec3().to_array();
    }

    /// Squared lower bounds of the distances of a node's children, in A's units, and the order in
    /// which they are opened: boxes whose middles are near probably hold what is closest.
    #[inline(always)]
    pub fn keys<L: Lanes>(&self, lanes: L, node: &Node) -> (F8<L>, F8<L>) {
        let of = |x: f32| F8::splat(lanes, x);
        let seen = |v: [f32; 3]| {
            let [x, y, z] = per_axis!(k => node.rows[k] * f32x4::splat(v[k]));
            (x + y + z).to_array()
        };
        let (middle, half, along) = (seen(self.middle), seen(self.half), seen(self.along));
        let (zero, margin) = (of(0.0), of(self.margin));
        let offset = per_axis!(k => of(middle[k]) - F8::read(lanes, &node.center[k]));
        let size = per_axis!(k => F8::read(lanes, &node.half[k]) + margin);
        let gaps = per_axis!(k => offset[k].abs() - size[k] - of(half[k].abs()));
        let sum = |[x, y, z]: V8<L>| x * x + y * y + z * z;
        let mut square = sum(per_axis!(k => gaps[k].max(zero)));
        let order = sum(per_axis!(k => (gaps[k] + size[k] * of(WITHIN)).max(zero)));
        if !self.is_point {
            // Along the way from the middle of each box to the segment.
            let dot = |v: V8<L>| v[0] * of(half[0]) + v[1] * of(half[1]) + v[2] * of(half[2]);
            let least = of(-1.0).max((zero - dot(offset)) * of(self.per_square));
            let at = least.min(of(1.0));
            let way = per_axis!(k => offset[k] + at * of(half[k]));
            let [x, y, z] = per_axis!(k => way[k] * offset[k] - way[k].abs() * size[k]);
            let gap = (x + y + z - dot(way).abs()).max(zero);
            square = square.max(gap * gap / sum(way).max(of(LEAST_SQUARE)));
        }
        let towards = if self.is_a { -1.0 } else { 1.0 };
        let [u, v, w] = per_axis!(k => half[k] * along[k]);
        let mut ahead = of(-(u + v + w).abs() - self.margin);
        for k in 0..3 {
            let beyond = offset[k] * of(towards * along[k]);
            ahead = ahead + beyond - size[k] * of(along[k].abs());
        }
        let ahead = ahead.max(zero);
        (square.max(ahead * ahead) * of(self.square_unit), order)
    }
}

impl Lone {
    /// The closest points of two triangles, one of which is a lone point.
    pub fn closest(&self, a: &[DVec3; 3], b: &[DVec3; 3]) -> Option<Closest> {
        if !self.is_a {
            return closest_to_point(a, b[0]);
        }
        let found = closest_to_point(b, a[0])?;
        let [of_b, of_a] = found.points;
        Some(Closest {
            points: [of_a, of_b],
            direction: -found.direction,
            ..found
        })
    }
}

/// Factor of directions, so that rounding makes none longer than 1.
const SHORTER: f64 = 1.0 - 1e-5;

/// True for the tree of one point or segment that is no cloud.
fn is_lone(tree: &Tree) -> bool {
    tree.mesh().len() == 1 && !tree.is_cloud() && {
        let [_, q, r] = tree.corners(0);
        q == r
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use alloc::vec::Vec;
    use glam::{DMat3, DQuat};
    use punctual_geom::Pose;
    use punctual_geom::lanes::{Instructions, Kernel};
    use punctual_geom::random::Random;
    use punctual_geom::triangle::distance::closest_or_meeting;

    struct Keys<'k>(&'k Lone, &'k Node);

    impl Kernel for Keys<'_> {
        type Output = [f32; 8];

        fn run<L: Lanes>(self, lanes: L) -> [f32; 8] {
            self.0.keys(lanes, self.1).0.store()
        }
    }

    /// Triangles of all sizes, and slivers.
    fn soup(random: &mut Random) -> Tree {
        let size = f64::exp2(random.between(-9.0, 9.0).floor());
        let mut vector = |size: f64| [(); 3].map(|()| random.between(-size, size));
        let vertices: Vec<[f64; 3]> = (0..200)
            .flat_map(|i| {
                let (at, u) = (vector(size), vector(0.2 * size));
                let v = if i % 3 == 0 {
                    u.map(|x| x * 1.001)
                } else {
                    vector(0.1 * size)
                };
                let add = |u: [f64; 3]| [0, 1, 2].map(|k| at[k] + u[k]);
                [at, add(u), add(v)]
            })
            .collect();
        Tree::new(
            Mesh::from_f64(vertices, (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2])).unwrap(),
        )
    }

    #[test]
    fn no_triangle_is_closer_than_the_key_of_its_box() {
        let mut random = Random::new(1);
        let (mut near, mut none) = (0, 0);
        for round in 0..400 {
            let tree = soup(&mut random);
            let size = tree.unit_length();
            let mut vector = |size: f64| DVec3::from([(); 3].map(|()| random.between(-size, size)));
            let half = vector(size * [0.0, 0.3, 3.0][round % 3]);
            let ends = [vector(size) - half, vector(0.0) + half];
            let ends = if round % 3 == 0 { [ends[0]; 2] } else { ends };
            let mesh =
                Mesh::from_f64([ends[0].to_array(), ends[1].to_array()], [[0, 1, 1]]).unwrap();
            let segment = Tree::new(mesh);
            let turn = DMat3::from_quat(DQuat::from_scaled_axis(vector(3.0)));
            // Every fourth matrix is not quite a rotation.
            let off = if round % 4 == 0 {
                vector(3e-4)
            } else {
                DVec3::ZERO
            };
            let turn = turn * (DMat3::IDENTITY + DMat3::from_cols(off, off * 0.5, -off));
            let far = size * [1.0, 4.0, 40.0][round / 3 % 3];
            let pose = Pose::new(turn, vector(far)).unwrap();
            let is_a = round % 2 == 0;
            let trees = if is_a {
                [&segment, &tree]
            } else {
                [&tree, &segment]
            };
            let relative = RelativePose::new(trees[0], trees[1], &pose);
            let Some(mut lone) = Lone::of(trees, &relative) else {
                none += 1;
                continue;
            };
            assert_eq!((lone.is_a, lone.is_point), (is_a, round % 3 == 0));
            let place = |p: DVec3, of_a: bool| if of_a { p } else { pose.transform_point(p) };
            let core = segment.corners(0).map(|p| place(p, is_a));
            for _ in 0..3 {
                lone.turn(&relative, vector(1.0).normalize());
                for node in tree.nodes() {
                    let keys = Instructions::detect().run(Keys(&lone, node));
                    for child in 0..u32::from(node.children) {
                        let triangles = if node.is_leaf {
                            let one = (node.first_child + child) as usize;
                            one..one + 1
                        } else {
                            tree.nodes()[(node.first_child + child) as usize].triangle_range()
                        };
                        let low = f64::from(keys[child as usize]).sqrt() * relative.unit;
                        for triangle in triangles {
                            let corners = tree.corners(triangle as u32).map(|p| place(p, !is_a));
                            let found = closest_or_meeting(&corners, &core);
                            assert!(low <= found.high, "{round}: {low} {found:?}");
                            near += usize::from(low > 0.9 * found.high);
                        }
                    }
                }
            }
        }
        assert!(near > 10_000 && (10..200).contains(&none), "{near}, {none}");
    }
}
