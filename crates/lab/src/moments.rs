//! Expected overlaps averaged over all placements: exact, for any boxes.
//!
//! Let the roots A and B be moved against one another, unturned, uniformly over all offsets at which they meet. Along
//! axis k that range has the length `A_k + B_k` (full extents), and boxes `i` and `j` within them meet on a part of it of
//! length `a_ik + b_jk`. The axes are independent, so that the expected number of overlapping pairs of a level is
//!
//! `E[O_l] = sum_{i,j} prod_k (a_ik + b_jk) / prod_k (A_k + B_k)`.
//!
//! Neither a constant alpha nor independence of the boxes is assumed. With extents `A_k alpha_k^l` and `2^l` boxes on each
//! side it is the term `4^l prod_k alpha_k^l` of the paper's Eq 11. The product of sums opens into 8 terms, so that the
//! double sum over pairs becomes 8 products of sums over boxes: the moments.

use punctual::glam::DVec3;

/// The moments of the boxes of one level: entry `m` sums, over the boxes, the product of the extents along the axes whose
/// bits are set in `m` (bit 0 for x). Entry 0 counts the boxes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments(pub [f64; 8]);

impl Moments {
    /// The moments of boxes with these extents, half or full, but of one kind everywhere. `O(boxes)`.
    pub fn of(extents: impl IntoIterator<Item = DVec3>) -> Self {
        let mut sums = [0.0; 8];
        for e in extents {
            let products = [
                1.0,
                e.x,
                e.y,
                e.x * e.y,
                e.z,
                e.x * e.z,
                e.y * e.z,
                e.x * e.y * e.z,
            ];
            for (sum, product) in sums.iter_mut().zip(products) {
                *sum += product;
            }
        }
        Self(sums)
    }

    /// The moments of the boxes of both.
    pub fn merged(&self, other: &Self) -> Self {
        let mut sums = self.0;
        for (sum, more) in sums.iter_mut().zip(other.0) {
            *sum += more;
        }
        Self(sums)
    }

    /// `E[O_l]`, the expected number of overlapping pairs of a box of `self` and one of `other`, averaged over all
    /// placements in which roots of the given extents meet. The roots must contain the boxes and be no points.
    pub fn expected_overlaps(&self, other: &Self, root: DVec3, other_root: DVec3) -> f64 {
        let pairs: f64 = (0..8).map(|m| self.0[m] * other.0[7 - m]).sum();
        let range = root + other_root;
        pairs / (range.x * range.y * range.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper;
    use punctual::internals::Random;

    /// Boxes within the box of half extent 1 around the origin: (centre, half extent).
    fn boxes(count: usize, seed: u64) -> Vec<(DVec3, DVec3)> {
        let mut random = Random::new(seed);
        let mut vector = |high: f64| DVec3::from_array([(); 3].map(|()| random.between(0.0, high)));
        (0..count)
            .map(|_| {
                let half = vector(0.5);
                (vector(2.0) * (1.0 - half) - (1.0 - half), half)
            })
            .collect()
    }

    fn moments(boxes: &[(DVec3, DVec3)]) -> Moments {
        Moments::of(boxes.iter().map(|b| b.1))
    }

    #[test]
    fn eight_moments_are_the_double_sum() {
        let (a, b) = (boxes(13, 1), boxes(7, 2));
        let pairs = a
            .iter()
            .flat_map(|a| b.iter().map(move |b| (a.1 + b.1).element_product()));
        let double_sum = pairs.sum::<f64>() / 8.0;
        let fast = moments(&a).expected_overlaps(&moments(&b), DVec3::ONE, DVec3::ONE);
        assert!((fast / double_sum - 1.0).abs() < 1e-12);
        let (head, tail) = a.split_at(5);
        let merged = moments(head).merged(&moments(tail));
        assert!(
            merged
                .0
                .iter()
                .zip(moments(&a).0)
                .all(|(m, n)| (m / n - 1.0).abs() < 1e-12)
        );
    }

    #[test]
    fn placements_drawn_at_random_agree() {
        let (a, b) = (boxes(20, 3), boxes(20, 4));
        let expected = moments(&a).expected_overlaps(&moments(&b), DVec3::ONE, DVec3::ONE);
        let mut random = Random::new(5);
        let placements = 20_000;
        let mut overlaps = 0;
        for _ in 0..placements {
            let offset = DVec3::from_array([(); 3].map(|()| random.between(-2.0, 2.0)));
            let meets = |a: &(DVec3, DVec3), b: &(DVec3, DVec3)| {
                (b.0 + offset - a.0).abs().cmple(a.1 + b.1).all()
            };
            overlaps += a
                .iter()
                .map(|a| b.iter().filter(|b| meets(a, b)).count())
                .sum::<usize>();
        }
        let mean = overlaps as f64 / f64::from(placements);
        assert!(
            (mean / expected - 1.0).abs() < 0.03,
            "{mean} is not {expected}"
        );
    }

    #[test]
    fn constant_alpha_gives_the_terms_of_equation_11() {
        let (alpha, root) = (DVec3::new(0.6, 0.8, 0.9), DVec3::new(1.0, 2.0, 3.0));
        let level = |l: i32| Moments::of((0..1 << l).map(|_| root * alpha.powf(f64::from(l))));
        let sum: f64 = (0..=6)
            .map(|l| level(l).expected_overlaps(&level(l), root, root))
            .sum();
        assert!((sum / paper::eq11(alpha.to_array(), 6) - 1.0).abs() < 1e-12);
    }
}
