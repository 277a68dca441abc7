//! Expected visits at a given offset, from a profile of each level: the delta model for real trees.
//!
//! Take the centres of the boxes of a level as independent along each axis, and their extents as all alike. A box of A
//! (half extent `e_A`, centre with mean `m_A` and variance `v_A`) and one of B, turned by `R` and moved by `c`, meet along
//! axis k if the difference of their centres, with mean `mu = c + R m_B - m_A` and variance `v_A + (R o R) v_B`, is within
//! `h = e_A + |R| e_B`. So the expected number of overlapping pairs is
//!
//! `O_l = n_A n_B prod_k [F_k(h_k - mu_k) - F_k(-h_k - mu_k)]`
//!
//! with `F` the distribution of the difference less its mean ([`Centers`]). `R o R` has the squares of the entries of `R`,
//! `|R|` their magnitudes. What goes in: [`LevelShape`]s in one unit of length; what comes out: counts.

use std::f64::consts::FRAC_1_SQRT_2;

use punctual::glam::{DMat3, DVec3};

/// The boxes of one level of a tree, in the frame of its root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelShape {
    /// Number of boxes.
    pub count: f64,
    /// Their mean half extent.
    pub half_extent: DVec3,
    /// Mean of their centres.
    pub center: DVec3,
    /// Variance of their centres.
    pub variance: DVec3,
}

/// How the centres of a level are thought to be distributed along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Centers {
    /// Normal, and so is their difference: two error functions an axis.
    Normal,
    /// Uniform over an interval, which ends as boxes within a root do; their difference has a trapezoid for a density.
    /// Cheaper, and nearer to what trees of meshes visit (`punctual paper` measures both).
    Uniform,
}

/// `O_l`: expected overlapping pairs of a box of `a` and one of `b`, where `b`'s frame has the axes `rotation` and the
/// origin `offset` in `a`'s. Between 0 and `a.count * b.count`.
pub fn overlapping_pairs(
    a: &LevelShape,
    b: &LevelShape,
    rotation: &DMat3,
    offset: DVec3,
    centers: Centers,
) -> f64 {
    let squares = DMat3::from_cols_array(&rotation.to_cols_array().map(|x| x * x));
    let half = a.half_extent + rotation.abs() * b.half_extent;
    let mean = (offset + *rotation * b.center - a.center).abs();
    let (of_a, of_b) = (a.variance, squares * b.variance);
    let axis = |k: usize| {
        // Both arguments in the lower tail, where the distributions lose no digits.
        let (high, low) = (half[k] - mean[k], -half[k] - mean[k]);
        if of_a[k] + of_b[k] <= 0.0 {
            return f64::from(high >= 0.0);
        }
        match centers {
            Centers::Normal => {
                let s = libm::sqrt(of_a[k] + of_b[k]);
                normal_cdf(high / s) - normal_cdf(low / s)
            }
            Centers::Uniform => {
                // A uniform distribution of variance v reaches sqrt(3 v) to either side of its mean.
                let reach = [of_a[k], of_b[k]].map(|variance| libm::sqrt(3.0 * variance));
                trapezoid_cdf(high, reach) - trapezoid_cdf(low, reach)
            }
        }
    };
    a.count * b.count * axis(0) * axis(1) * axis(2)
}

/// `Phi(x)`, the standard normal distribution function.
fn normal_cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x * FRAC_1_SQRT_2)
}

/// Distribution function of the sum of two independent numbers, uniform over `-p..p` and `-q..q`, not both 0:
/// `((x + p + q)^2 - (x + p - q)^2 - (x - p + q)^2 + (x - p - q)^2) / (8 p q)`, with the squares of positive terms only.
fn trapezoid_cdf(x: f64, reach: [f64; 2]) -> f64 {
    let (p, q) = (reach[0].max(reach[1]), reach[0].min(reach[1]));
    // The narrow one hardly matters, and dividing by it would cost all digits.
    if q < 1e-6 * p {
        return ((x + p) / (2.0 * p)).clamp(0.0, 1.0);
    }
    let square = |x: f64| if x > 0.0 { x * x } else { 0.0 };
    let sum = square(x + p + q) - square(x + p - q) - square(x - p + q) + square(x - p - q);
    (sum / (8.0 * p * q)).clamp(0.0, 1.0)
}

/// Variance along an axis of the centres on level `l` of the paper's artificial tree, whose root has the full extent
/// `extent`: `s^2 = extent^2 (1 - alpha) / (1 + alpha) / 4 * (1 - alpha^(2l))`.
///
/// A child is `extent alpha^j (1 - alpha) / 2` away from its parent of level `j`, to one side or the other; the variances
/// of the steps add up to a geometric sum.
pub fn artificial_variance(extent: f64, alpha: f64, level: u32) -> f64 {
    let limit = extent * extent * (1.0 - alpha) / (1.0 + alpha) / 4.0;
    limit * (1.0 - libm::pow(alpha, 2.0 * f64::from(level)))
}

/// The level `l` of an artificial tree whose root has extent 1 and its centre in the origin.
pub fn artificial_level(alpha: [f64; 3], level: u32) -> LevelShape {
    LevelShape {
        count: libm::exp2(f64::from(level)),
        half_extent: DVec3::from_array(alpha.map(|alpha| 0.5 * libm::pow(alpha, f64::from(level)))),
        center: DVec3::ZERO,
        variance: DVec3::from_array(alpha.map(|alpha| artificial_variance(1.0, alpha, level))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::artificial::{ArtificialTree, Corners};
    use crate::traversal::BinaryNode;
    use punctual::internals::Random;

    #[test]
    fn the_closed_variance_is_the_recursive_sum() {
        for (extent, alpha) in [(1.0, 0.5), (3.0, 0.8), (0.1, 0.99), (2.0, 0.0)] {
            let step = |j: u32| extent * f64::powi(alpha, j as i32) * (1.0 - alpha) / 2.0;
            for level in 0..12 {
                let sum: f64 = (0..level).map(|j| step(j) * step(j)).sum();
                let closed = artificial_variance(extent, alpha, level);
                assert!(
                    (closed - sum).abs() < 1e-12 * extent * extent,
                    "{extent} {alpha} {level}"
                );
            }
        }
    }

    #[test]
    fn an_artificial_level_is_what_the_tree_has() {
        let (alpha, level) = ([0.6, 0.8, 0.9], 10);
        let shape = artificial_level(alpha, level);
        let mut random = Random::new(1);
        let (mut squares, trees) = (DVec3::ZERO, 40.0);
        for _ in 0..trees as usize {
            let tree = ArtificialTree {
                alpha,
                depth: level,
                corners: Corners::Random(random.bits()),
            };
            let mut nodes = vec![tree.root_at([0.0; 3])];
            for _ in 0..level {
                nodes = nodes
                    .iter()
                    .flat_map(|node| node.children().unwrap())
                    .collect();
            }
            assert_eq!(nodes.len() as f64, shape.count);
            assert!(
                (DVec3::from_array(nodes[9].extent()) * 0.5).abs_diff_eq(shape.half_extent, 1e-15)
            );
            squares += nodes
                .iter()
                .map(|node| DVec3::from_array(node.center()).powf(2.0))
                .sum::<DVec3>();
        }
        let variance = squares / shape.count / trees;
        assert!(
            (variance / shape.variance - 1.0).abs().max_element() < 0.1,
            "{variance} is not {}",
            shape.variance
        );
    }

    /// The centre of a box drawn from a level, in its own frame.
    fn center(shape: &LevelShape, centers: Centers, random: &mut Random) -> DVec3 {
        let mut standard = || match centers {
            Centers::Normal => (0..12).map(|_| random.fraction()).sum::<f64>() - 6.0,
            Centers::Uniform => random.between(-1.0, 1.0) * f64::sqrt(3.0),
        };
        shape.center + DVec3::new(standard(), standard(), standard()) * shape.variance.powf(0.5)
    }

    const A: LevelShape = LevelShape {
        count: 500.0,
        half_extent: DVec3::new(0.1, 0.3, 0.2),
        center: DVec3::new(0.2, 0.0, -0.3),
        variance: DVec3::new(0.5, 0.1, 0.3),
    };

    fn assert_boxes_meet_as_predicted(
        a: &LevelShape,
        b: &LevelShape,
        rotation: DMat3,
        centers: Centers,
    ) {
        let mut random = Random::new(3);
        for offset in [
            DVec3::ZERO,
            DVec3::new(-0.4, -0.5, 0.3),
            DVec3::new(0.6, -0.9, -0.4),
        ] {
            let expected = overlapping_pairs(a, b, &rotation, offset, centers);
            let half = a.half_extent + rotation.abs() * b.half_extent;
            let draws = 200_000;
            let mut meets = || {
                let (x, y) = (
                    center(a, centers, &mut random),
                    center(b, centers, &mut random),
                );
                (rotation * y + offset - x).abs().cmple(half).all()
            };
            let share = (0..draws).filter(|_| meets()).count() as f64 / f64::from(draws);
            let found = share * a.count * b.count;
            assert!(
                (found / expected - 1.0).abs() < 0.1,
                "{centers:?} {offset}: {found} is not {expected}"
            );
        }
    }

    #[test]
    fn boxes_drawn_at_random_meet_as_often_as_predicted() {
        // Turned by a right angle, axes stay independent, whatever the distribution.
        let b = LevelShape {
            center: DVec3::X,
            variance: DVec3::new(0.1, 0.4, 0.2),
            ..A
        };
        let quarter = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
        for centers in [Centers::Normal, Centers::Uniform] {
            assert_boxes_meet_as_predicted(&A, &b, quarter, centers);
        }
        // A round normal distribution stays one when it is turned.
        let round = LevelShape {
            variance: DVec3::splat(0.2),
            ..b
        };
        let rotation = DMat3::from_rotation_z(0.7) * DMat3::from_rotation_x(-0.4);
        assert_boxes_meet_as_predicted(&A, &round, rotation, Centers::Normal);
    }

    #[test]
    fn the_normal_distribution_is_that_of_the_tables() {
        assert_eq!(normal_cdf(0.0), 0.5);
        for (x, p) in [
            (1.0, 0.841_344_746_068_542_9),
            (-1.281_551_565_544_6, 0.1),
            (3.0, 0.998_650_101_968_369_9),
        ] {
            assert!((normal_cdf(x) - p).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn the_trapezoid_by_hand() {
        // Two intervals alike: a triangle.
        let triangle = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|x| trapezoid_cdf(x, [1.0, 1.0]));
        assert_eq!(triangle, [0.0, 0.0, 0.125, 0.5, 0.875, 1.0, 1.0]);
        // One is a point: a ramp, to which narrow ones come near.
        for q in [0.0, 1e-7, 1e-5] {
            assert!((trapezoid_cdf(0.5, [q, 2.0]) - 0.625).abs() < 1e-6);
        }
    }

    #[test]
    fn boxes_without_spread_meet_or_do_not() {
        let point = LevelShape {
            count: 8.0,
            half_extent: DVec3::ONE,
            center: DVec3::ZERO,
            variance: DVec3::ZERO,
        };
        for centers in [Centers::Normal, Centers::Uniform] {
            let at =
                |x: f64| overlapping_pairs(&point, &point, &DMat3::IDENTITY, DVec3::X * x, centers);
            assert_eq!([at(0.0), at(2.0), at(2.1)], [64.0, 64.0, 0.0]);
        }
    }
}
