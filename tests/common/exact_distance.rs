//! An independent judge of distances: the square as a fraction of whole numbers of any size, by cases over the features.
//! The unit tests of the library use it too, so it takes corners as anything that is three numbers.
#![allow(
    dead_code,
    reason = "each test file is a crate of its own and uses a part"
)]

use std::array::from_fn;
use std::cmp::Ordering;

use num_bigint::{BigInt, Sign};

type Vector = [BigInt; 3];

/// The distance of two closed triangles, degenerate or not: `sqrt(numerator / denominator) 2^(shift - 1074)`.
#[derive(Clone)]
pub struct Distance {
    numerator: BigInt,
    denominator: BigInt,
    shift: u64,
}

impl Distance {
    /// Coordinates must be finite.
    pub fn of<P: Copy + Into<[f64; 3]>>(a: &[P; 3], b: &[P; 3]) -> Self {
        let [mut a, mut b] = [a, b].map(|t| t.map(|corner| corner.into().map(whole)));
        let all = || a.iter().chain(&b).flatten();
        let shift = all().filter_map(BigInt::trailing_zeros).min().unwrap_or(0);
        for coordinate in a.iter_mut().chain(&mut b).flatten() {
            *coordinate >>= shift;
        }
        let mut least = Self {
            numerator: square(&minus(&a[0], &b[0])),
            denominator: BigInt::from(1),
            shift,
        };
        least.or_faces(&a, &b);
        least.or_faces(&b, &a);
        for i in 0..3 {
            for j in 0..3 {
                least.or_edges([&a[i], &a[(i + 1) % 3]], [&b[j], &b[(j + 1) % 3]]);
            }
        }
        least
    }

    pub fn is_zero(&self) -> bool {
        self.numerator == BigInt::ZERO
    }

    /// How a bound, not negative, compares to the distance.
    pub fn order_of(&self, bound: f64) -> Ordering {
        self.order_of_sum(&[bound])
    }

    /// How the exact sum of such numbers compares to the distance.
    pub fn order_of_sum(&self, terms: &[f64]) -> Ordering {
        assert!(terms.iter().all(|term| *term >= 0.0));
        let bound: BigInt = terms.iter().copied().map(whole).sum();
        (&bound * &bound * &self.denominator).cmp(&(&self.numerator << (2 * self.shift)))
    }

    /// Whether it is less than another one.
    pub fn is_less(&self, other: &Self) -> bool {
        let square =
            |of: &Self, times: &Self| (&of.numerator * &times.denominator) << (2 * of.shift);
        square(self, other) < square(other, self)
    }

    /// The distance, rounded a few times.
    pub fn rounded(&self) -> f64 {
        if self.is_zero() {
            return 0.0;
        }
        // A quotient of about 100 bits.
        let bits = |number: &BigInt| i64::try_from(number.bits()).unwrap();
        let up = (bits(&self.denominator) - bits(&self.numerator) + 100) / 2 * 2;
        let quotient = match u64::try_from(up) {
            Ok(up) => (&self.numerator << up) / &self.denominator,
            Err(_) => &self.numerator / (&self.denominator << up.unsigned_abs()),
        };
        let quotient = u128::try_from(quotient).unwrap() as f64;
        // In two steps, neither of which leaves the range before the end.
        let power = i64::try_from(self.shift).unwrap() - 1074 - up / 2;
        let [half, rest] = [power / 2, power - power / 2].map(|exponent| (exponent as f64).exp2());
        quotient.sqrt() * half * rest
    }

    fn or(&mut self, numerator: BigInt, denominator: BigInt) {
        if &numerator * &self.denominator < &self.numerator * &denominator {
            (self.numerator, self.denominator) = (numerator, denominator);
        }
    }

    /// The corners of `other` over a proper triangle, and its edges through it.
    fn or_faces(&mut self, face: &[Vector; 3], other: &[Vector; 3]) {
        let (x, y) = (minus(&face[1], &face[0]), minus(&face[2], &face[0]));
        let normal = cross(&x, &y);
        let area = square(&normal);
        if area == BigInt::ZERO {
            return;
        }
        let heights: [BigInt; 3] = from_fn(|i| dot(&normal, &minus(&other[i], &face[0])));
        for (corner, height) in other.iter().zip(&heights) {
            let from = minus(corner, &face[0]);
            let (s, t) = (
                dot(&cross(&y, &normal), &from),
                dot(&cross(&normal, &x), &from),
            );
            if s >= BigInt::ZERO && t >= BigInt::ZERO && s + t <= area {
                self.or(height * height, area.clone());
            }
        }
        for i in 0..3 {
            let (start, end) = (&other[i], &other[(i + 1) % 3]);
            let step = minus(end, start);
            let sides: [Sign; 3] = from_fn(|j| {
                let (from, to) = (minus(&face[j], start), minus(&face[(j + 1) % 3], start));
                dot(&step, &cross(&from, &to)).sign()
            });
            let is_through = (&heights[i] * &heights[(i + 1) % 3]).sign() == Sign::Minus;
            if is_through && sides[0] == sides[1] && sides[1] == sides[2] {
                self.or(BigInt::ZERO, BigInt::from(1));
            }
        }
    }

    fn or_edges(&mut self, [a, a_end]: [&Vector; 2], [b, b_end]: [&Vector; 2]) {
        self.or_corner(a, [b, b_end]);
        self.or_corner(b, [a, a_end]);
        let (d, e, from) = (minus(a_end, a), minus(b_end, b), minus(b, a));
        let across = cross(&d, &e);
        let area = square(&across);
        let s = dot(&cross(&from, &e), &across);
        let t = dot(&cross(&from, &d), &across);
        let is_inside = |x: &BigInt| *x > BigInt::ZERO && *x < area;
        if is_inside(&s) && is_inside(&t) {
            let height = dot(&from, &across);
            self.or(&height * &height, area);
        }
    }

    fn or_corner(&mut self, corner: &Vector, [start, end]: [&Vector; 2]) {
        self.or(square(&minus(corner, start)), BigInt::from(1));
        let (step, from) = (minus(end, start), minus(corner, start));
        let (along, length) = (dot(&step, &from), square(&step));
        if along > BigInt::ZERO && along < length {
            self.or(square(&cross(&step, &from)), length);
        }
    }
}

/// In units of 2^-1074.
fn whole(x: f64) -> BigInt {
    assert!(x.is_finite());
    let bits = x.abs().to_bits();
    let exponent = (bits >> 52).max(1);
    let mantissa = bits - ((exponent - 1) << 52);
    let size = BigInt::from(mantissa) << (exponent - 1);
    if x < 0.0 { -size } else { size }
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    from_fn(|k| &a[k] - &b[k])
}

fn dot(a: &Vector, b: &Vector) -> BigInt {
    (0..3).map(|k| &a[k] * &b[k]).sum()
}

fn square(a: &Vector) -> BigInt {
    dot(a, a)
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        &a[i] * &b[j] - &a[j] * &b[i]
    })
}
