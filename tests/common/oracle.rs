//! An independent judge of triangle pairs: the question as a linear program, solved in whole numbers of any size.
//!
//! Two closed triangles, degenerate or not, share a point if and only if weights `u, v >= 0` exist with
//! `sum u = 1`, `sum v = 1` and `u1 a1 + u2 a2 + u3 a3 = v1 b1 + v2 b2 + v3 b3`. Phase one of the simplex method
//! decides that without a single case distinction: no planes, no normals, no projections.

use num_bigint::{BigInt, Sign};
use num_rational::BigRational;
use punctual::glam::DVec3;

const WEIGHTS: usize = 6;
const EQUATIONS: usize = 5;
/// Weights, one slack for each equation, right side.
const COLUMNS: usize = WEIGHTS + EQUATIONS + 1;

/// Whether the closed hulls of the points of `a` and of `b` share a point. Coordinates must be finite.
pub fn intersects(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    Tableau::new(a, b).solve()
}

/// The slacks are the first solution; the last row is what their sum loses with each column. All entries share one
/// denominator, so that a pivot needs no fractions: each division leaves no rest (Bareiss, Edmonds).
struct Tableau {
    rows: Vec<Vec<BigInt>>,
    denominator: BigInt,
    /// The column that is solved for in each equation.
    basis: [usize; EQUATIONS],
}

impl Tableau {
    fn new(a: &[DVec3; 3], b: &[DVec3; 3]) -> Self {
        let corners = whole_numbers(a, b);
        let mut rows = vec![vec![BigInt::ZERO; COLUMNS]; EQUATIONS + 1];
        for (weight, corner) in corners.iter().enumerate() {
            let is_b = weight >= 3;
            for (axis, coordinate) in corner.iter().enumerate() {
                rows[axis][weight] = if is_b {
                    -coordinate
                } else {
                    coordinate.clone()
                };
            }
            rows[3 + usize::from(is_b)][weight] = BigInt::from(1);
        }
        for (equation, row) in rows.iter_mut().enumerate().take(EQUATIONS) {
            row[WEIGHTS + equation] = BigInt::from(1);
            row[COLUMNS - 1] = BigInt::from(u8::from(equation >= 3));
        }
        for column in (0..WEIGHTS).chain([COLUMNS - 1]) {
            rows[EQUATIONS][column] = (0..EQUATIONS).map(|equation| &rows[equation][column]).sum();
        }
        Self {
            rows,
            denominator: BigInt::from(1),
            basis: std::array::from_fn(|equation| WEIGHTS + equation),
        }
    }

    /// Whether the slacks can all become zero.
    fn solve(mut self) -> bool {
        // The first column that helps, and ties by the first column that leaves (Bland): no cycles.
        while let Some(column) =
            (0..WEIGHTS).find(|&column| is_positive(&self.rows[EQUATIONS][column]))
        {
            let Some(row) = self.leaving_row(column) else {
                unreachable!("weights are bounded");
            };
            self.pivot(row, column);
        }
        self.rows[EQUATIONS][COLUMNS - 1] == BigInt::ZERO
    }

    /// The equation that first stops the column from growing.
    fn leaving_row(&self, column: usize) -> Option<usize> {
        let candidates = (0..EQUATIONS).filter(|&row| is_positive(&self.rows[row][column]));
        candidates.min_by(|&one, &other| {
            let [one_row, other_row] = [one, other].map(|row| &self.rows[row]);
            let one_ratio = &one_row[COLUMNS - 1] * &other_row[column];
            let other_ratio = &other_row[COLUMNS - 1] * &one_row[column];
            one_ratio
                .cmp(&other_ratio)
                .then(self.basis[one].cmp(&self.basis[other]))
        })
    }

    fn pivot(&mut self, pivot_row: usize, column: usize) {
        let pivots = self.rows[pivot_row].clone();
        let pivot = &pivots[column];
        for (_, row) in self
            .rows
            .iter_mut()
            .enumerate()
            .filter(|&(index, _)| index != pivot_row)
        {
            let factor = row[column].clone();
            for (entry, other) in row.iter_mut().zip(&pivots) {
                *entry = (&*entry * pivot - &factor * other) / &self.denominator;
            }
        }
        self.denominator = pivot.clone();
        self.basis[pivot_row] = column;
    }
}

fn is_positive(number: &BigInt) -> bool {
    number.sign() == Sign::Plus
}

/// All coordinates in units of the coarsest power of two that makes them whole.
fn whole_numbers(a: &[DVec3; 3], b: &[DVec3; 3]) -> Vec<[BigInt; 3]> {
    let least = BigRational::from_integer(BigInt::from(1) << 1074_u32);
    let whole =
        |value: f64| (BigRational::from_float(value).expect("finite") * &least).to_integer();
    let corners: Vec<[BigInt; 3]> = a
        .iter()
        .chain(b)
        .map(|corner| corner.to_array().map(whole))
        .collect();
    let shift = corners
        .iter()
        .flatten()
        .filter_map(BigInt::trailing_zeros)
        .min()
        .unwrap_or(0);
    corners
        .into_iter()
        .map(|corner| corner.map(|coordinate| coordinate >> shift))
        .collect()
}
