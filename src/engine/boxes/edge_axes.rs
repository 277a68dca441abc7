//! The nine edge axes of two boxes, the cross products of their edges. They separate slim boxes
//! that overlap on all six face axes.
//!
//! The cross product of an axis of A and one of B, in A's axes, has entries of the latter. So it
//! has no rounding of its own and need not be a unit vector. The proof of the margins is in
//! `docs/numerics.md`, "Edge axes".

use super::relative_pose::{Entries, RelativePose, View};
use crate::tree::{Node, xyz};
use punctual_geom::lanes::per_axis;
use wide::f32x4;

/// Pairs of boxes count as slim if the product of their slimnesses is less than this.
const SLIM: f32 = 0.2;

/// True if the nine axes are likely enough to separate the boxes of two nodes that overlap on the
/// other six.
#[inline(always)]
pub(crate) fn are_slim(a: &Node, b: &Node) -> bool {
    a.slimness * b.slimness < SLIM
}

/// True if an edge axis separates the own boxes of two nodes.
#[inline(always)]
pub(crate) fn part(a: &Node, b: &Node, of_b: &View, relative: &RelativePose) -> bool {
    let scale = f32x4::splat(relative.scale);
    let distance = across(of_b, of_b.point(b.own_center * scale) - a.own_center);
    let half = a.own_half + of_b.margin;
    let reach = reach(
        half,
        b.own_half * scale,
        of_b,
        f32x4::splat(relative.rotation_error),
    );
    let [x, y, z] = per_axis!(j => reach[j].simd_lt(distance[j].abs()));
    (x | y | z).any()
}

/// Time interval in which the own box of a node of A and a box of B may overlap on the edge axes.
/// The box of B moves with this velocity (in the axes of A's node). `margin` bounds its position
/// error and includes the margin of the overlap test.
#[inline(always)]
pub(crate) fn window(
    a: &Node,
    b: (f32x4, f32x4),
    of_b: &View,
    rotation_error: f32,
    (velocity, margin): (f32x4, f32x4),
) -> [f32; 2] {
    let distance = across(of_b, of_b.point(b.0) - a.own_center);
    let reach = reach(a.own_half + margin, b.1, of_b, f32x4::splat(rotation_error));
    let [x, y, z] = xyz(velocity.abs());
    // Lower limit of the speed along an axis.
    let least = f32x4::splat((x + y + z) * 2e-6 + 1e-20);
    let speed = across(of_b, velocity);
    let [x, y, z] = per_axis!(j => {
        let size = f32x4::ONE / speed[j].abs().fast_max(least);
        let inverse = speed[j].simd_lt(f32x4::ZERO).select(size, f32x4::ZERO - size);
        let (middle, half) = (distance[j] * inverse, (reach[j] + least) * size);
        [middle - half, middle + half]
    });
    let (enter, leave) = (
        x[0].fast_max(y[0]).fast_max(z[0]),
        x[1].fast_min(y[1]).fast_min(z[1]),
    );
    let ([u, v, w], [x, y, z]) = (xyz(enter), xyz(leave));
    [u.max(v).max(w), x.min(y).min(z)]
}

/// A vector projected on the axes: lane `k` of entry `j` is for the cross product of axis `k` of A
/// and axis `j` of B.
#[inline(always)]
fn across(of_b: &View, v: f32x4) -> [f32x4; 3] {
    let (v1, v2) = (v.yzx(), v.zxy());
    per_axis!(j => v1 * of_b.columns[j].zxy() - v2 * of_b.columns[j].yzx())
}

/// Sum of the extents of the boxes along the axes, from their half extents and the margin of the
/// view. `rotation_error` bounds the deviation of the columns of the view from orthonormal ones.
#[inline(always)]
fn reach(a: f32x4, b: f32x4, of_b: &View, rotation_error: f32x4) -> [f32x4; 3] {
    let (h1, h2, half) = (a.yzx(), a.zxy(), b + of_b.margin);
    let half = per_axis!(j => half.spread(j));
    let sizes = per_axis!(j => of_b.columns[j].abs() + rotation_error);
    per_axis!(j => {
        let (p, q) = ((j + 1) % 3, (j + 2) % 3);
        let (c1, c2) = (of_b.columns[j].yzx(), of_b.columns[j].zxy());
        h1 * c2.abs() + h2 * c1.abs() + (half[p] * sizes[q] + half[q] * sizes[p])
    })
}

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::*;
    use crate::engine::boxes::relative_pose::Views;
    use crate::mesh::shapes;
    use crate::tree::Tree;
    use glam::{DMat3, DQuat, DVec3};
    use punctual_geom::Pose;
    use punctual_geom::random::Random;

    /// Larger than the rounding of a few `f64` operations on numbers below 8.
    const ROUNDING: f64 = 1e-14;

    /// The own boxes of two nodes that touch at an edge of each, or are `gap` apart there.
    struct Touching {
        a: Node,
        b: Node,
        relative: RelativePose,
    }

    fn direction(random: &mut Random) -> DVec3 {
        let vector = DVec3::from_array(core::array::from_fn(|_| random.between(-1.0, 1.0)));
        vector.try_normalize().unwrap_or(DVec3::X)
    }

    fn rotation(random: &mut Random) -> DMat3 {
        DMat3::from_quat(DQuat::from_axis_angle(
            direction(random),
            random.between(-3.0, 3.0),
        ))
    }

    /// Rounds up to `f32`.
    fn up(x: f64) -> f32 {
        if f64::from(x as f32) < x {
            (x as f32).next_up()
        } else {
            x as f32
        }
    }

    impl Touching {
        /// The common point lies on an edge of each box. The plane through both edges has A on one
        /// side and B on the other.
        fn new(random: &mut Random, trees: [&Tree; 2], gap: f64) -> Self {
            let scale = trees[1].unit_length() / trees[0].unit_length();
            let deviation = [0.0, 1e-6, 3e-4][random.bits() as usize % 3];
            let skewed = DMat3::from_cols_array(&core::array::from_fn(|_| {
                deviation * random.between(-1.0, 1.0)
            }));
            let exact = rotation(random);
            let turn = exact * (DMat3::IDENTITY + skewed);
            let (k, j) = (random.bits() as usize % 3, random.bits() as usize % 3);
            let of_a = rotation(random);
            let of_b = if random.bits().is_multiple_of(2) {
                rotation(random)
            } else {
                // Axis `k` of both is nearly parallel.
                let nearly = libm::pow(10.0, random.between(-9.0, 0.0));
                exact.transpose() * of_a * DMat3::from_axis_angle(direction(random), nearly)
            };
            let (of_a, of_b) = (of_a.as_mat3(), of_b.as_mat3());
            let (axes_a, axes_b) = (of_a.as_dmat3(), turn * of_b.as_dmat3());
            let normal = axes_a.col(k).cross(axes_b.col(j)).normalize_or_zero();
            let (x, y) = (
                0.9 * random.fraction() * direction(random),
                0.9 * random.fraction() * direction(random),
            );
            let translation = (x + normal * gap - turn * y * scale) * trees[0].unit_length();
            let a = boxed(
                random,
                of_a,
                x,
                DVec3::from_array([0, 1, 2].map(|i| axes_a.col(i).dot(normal))),
            );
            let b = boxed(
                random,
                of_b,
                y,
                DVec3::from_array([0, 1, 2].map(|i| -axes_b.col(i).dot(normal))),
            );
            let relative =
                RelativePose::new(trees[0], trees[1], &Pose::new(turn, translation).unwrap());
            Self { a, b, relative }
        }

        fn view(&self) -> View {
            Views::between(&self.a, &self.b, &self.relative).of_b
        }

        fn is_parted(&self) -> bool {
            part(&self.a, &self.b, &self.view(), &self.relative)
        }

        fn is_parted_without(&self, margin: bool, rotation_error: bool) -> bool {
            let mut view = self.view();
            let mut relative = self.relative;
            if margin {
                view.margin = f32x4::ZERO;
            }
            if rotation_error {
                relative.rotation_error = 0.0;
            }
            part(&self.a, &self.b, &view, &relative)
        }
    }

    /// A box that contains `point` near its boundary, whatever the rounding, and extends inward
    /// from there.
    fn boxed(random: &mut Random, axes: glam::Mat3, point: DVec3, outward: DVec3) -> Node {
        let at = axes.as_dmat3().transpose() * point;
        let (mut center, mut half) = ([0.0; 4], [0.0; 4]);
        for i in 0..3 {
            let wanted = if random.bits().is_multiple_of(8) {
                0.0
            } else {
                libm::pow(10.0, random.between(-5.0, -0.5))
            };
            // The axis of the edge: the point may be anywhere on the edge.
            let inward = if outward[i].abs() < 1e-12 {
                random.between(-1.0, 1.0)
            } else {
                -outward[i].signum()
            };
            center[i] = (at[i] + inward * wanted) as f32;
            half[i] = up((at[i] - f64::from(center[i])).abs() + ROUNDING).max(wanted as f32);
        }
        Node {
            own_center: f32x4::new(center),
            own_half: f32x4::new(half),
            rows: [0, 1, 2].map(|i| f32x4::new(axes.row(i).extend(0.0).to_array())),
            ..Node::default()
        }
    }

    fn trees() -> [[Tree; 2]; 3] {
        [1.0, 16.0, 1.0 / 32.0]
            .map(|size| [1.0, size].map(|size: f32| Tree::new(shapes::cuboid([0.99 * size; 3], 1))))
    }

    /// The common point is exact up to the rounding of `f64`, and the boxes leave room for that
    /// rounding.
    #[test]
    fn boxes_with_a_common_point_are_never_parted() {
        let mut random = Random::new(15);
        let (mut without, trees) = ([0; 3], trees());
        for i in 0..60_000 {
            let [a, b] = &trees[i % 3];
            let touching = Touching::new(&mut random, [a, b], 0.0);
            assert!(!touching.is_parted(), "case {i}");
            for (count, (margin, rotation_error)) in
                without
                    .iter_mut()
                    .zip([(true, true), (true, false), (false, true)])
            {
                *count += usize::from(touching.is_parted_without(margin, rotation_error));
            }
        }
        // Both margins are needed.
        assert!(
            without.iter().all(|&count| count > 100),
            "{without:?} of 60,000 lost"
        );
    }

    #[test]
    fn boxes_that_are_apart_at_two_edges_are_parted() {
        let mut random = Random::new(16);
        let (mut parted, trees) = (0, trees());
        for i in 0..3_000 {
            let [a, b] = &trees[i % 3];
            let touching = Touching::new(&mut random, [a, b], 1e-2 * b.unit_length().max(1.0));
            parted += usize::from(touching.is_parted());
        }
        assert!(parted > 2_000, "{parted} of 3,000");
    }
}
