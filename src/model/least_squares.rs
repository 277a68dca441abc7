//! Linear models of a few features by least squares.
//!
//! Features are arrays of fixed length; lists of features, targets and weights are in step.

/// A symmetric system of equations `matrix w = right`.
#[derive(Clone, Copy)]
struct Normal<const N: usize> {
    matrix: [[f64; N]; N],
    right: [f64; N],
}

impl<const N: usize> Normal<N> {
    const fn new() -> Self {
        Self { matrix: [[0.0; N]; N], right: [0.0; N] }
    }

    fn add(&mut self, x: &[f64; N], y: f64, weight: f64) {
        for i in 0..N {
            for j in 0..N {
                self.matrix[i][j] += weight * x[i] * x[j];
            }
            self.right[i] += weight * x[i] * y;
        }
    }

    /// Elimination with pivots; a part in a billion of the diagonal is added, so that features may depend on one another.
    fn solve(mut self) -> [f64; N] {
        for i in 0..N {
            self.matrix[i][i] += 1e-9 * self.matrix[i][i] + f64::MIN_POSITIVE;
        }
        for i in 0..N {
            let pivot =
                (i..N).max_by(|&j, &k| self.matrix[j][i].abs().total_cmp(&self.matrix[k][i].abs())).unwrap_or(i);
            self.matrix.swap(i, pivot);
            self.right.swap(i, pivot);
            for j in i + 1..N {
                let factor = self.matrix[j][i] / self.matrix[i][i];
                for k in i..N {
                    self.matrix[j][k] -= factor * self.matrix[i][k];
                }
                self.right[j] -= factor * self.right[i];
            }
        }
        let mut w = [0.0; N];
        for i in (0..N).rev() {
            let known: f64 = (i + 1..N).map(|k| self.matrix[i][k] * w[k]).sum();
            w[i] = (self.right[i] - known) / self.matrix[i][i];
        }
        w
    }
}

/// The `w` with the least `sum weight (y - w . x)^2`.
pub fn least_squares<const N: usize>(x: &[[f64; N]], y: &[f64], weights: &[f64]) -> [f64; N] {
    let mut normal = Normal::new();
    for ((x, &y), &weight) in x.iter().zip(y).zip(weights) {
        normal.add(x, y, weight);
    }
    normal.solve()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use alloc::vec::Vec;

    #[test]
    fn the_plane_through_points_is_found() {
        const TRUE: [f64; 3] = [0.5, -1.0, 2.0];
        let mut random = Random::new(1);
        let x: Vec<_> = (0..9).map(|_| [1.0, random.between(-2.0, 2.0), random.fraction()]).collect();
        let y: Vec<_> = x.iter().map(|x| x.iter().zip(TRUE).map(|(x, w)| x * w).sum::<f64>()).collect();
        let w = least_squares(&x, &y, &[1.0; 9]);
        assert!(w.iter().zip(TRUE).all(|(w, e)| (w - e).abs() < 1e-6), "{w:?}");
        // A point of no weight does not count; features may depend on one another.
        let x = [[1.0, 1.0], [2.0, 2.0], [5.0, 0.0]];
        let w = least_squares(&x, &[2.0, 4.0, 99.0], &[1.0, 1.0, 0.0]);
        assert!((w[0] + w[1] - 2.0).abs() < 1e-6, "{w:?}");
    }
}
