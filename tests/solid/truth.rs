//! Judges of points, independent of the library: rays in whole numbers of any size, sums of solid angles, and distances as
//! fractions.

use crate::common::random::Random;
use crate::exact_distance::Distance;
use num_bigint::BigInt;
use punctual::Mesh;
use punctual::glam::DVec3;
use punctual::points::{PointBounds, SignedDistance};
use std::cmp::Ordering;
use std::f64::consts::PI;

/// A number in units of the least denormal one.
fn whole(x: f64) -> BigInt {
    let bits = x.to_bits();
    let biased = (bits >> 52 & 0x7ff) as i64;
    let mantissa = (bits & ((1 << 52) - 1)) | u64::from(biased != 0) << 52;
    let magnitude = BigInt::from(mantissa) << (biased.max(1) - 1) as usize;
    if bits >> 63 == 1 {
        -magnitude
    } else {
        magnitude
    }
}

type Vector = [BigInt; 3];

fn sign(x: &BigInt) -> i32 {
    i32::from(*x > BigInt::ZERO) - i32::from(*x < BigInt::ZERO)
}

fn determinant([a, b, c]: [&Vector; 3]) -> BigInt {
    let minor = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
    &a[0] * minor(1, 2) + &a[1] * minor(2, 0) + &a[2] * minor(0, 1)
}

/// The exact winding number of a closed mesh about a point; `None` if the point is on the surface.
pub fn winding(mesh: &Mesh, point: DVec3, random: &mut Random) -> Option<i32> {
    if (0..mesh.len()).any(|i| holds(&mesh.triangle(i), point)) {
        return None;
    }
    let vertices: Vec<Vector> = (0..mesh.vertex_count())
        .map(|i| {
            let vertex = mesh.vertex(i);
            [0, 1, 2].map(|k| whole(vertex[k]) - whole(point[k]))
        })
        .collect();
    'cast: loop {
        let direction = [(); 3].map(|()| BigInt::from(random.bits() as i64 >> 20));
        let mut sum = 0;
        for &corners in mesh.triangles() {
            let [a, b, c] = corners.map(|i| &vertices[i as usize]);
            let volume = sign(&determinant([a, b, c]));
            if volume == 0 {
                continue;
            }
            let sides =
                [[a, b], [b, c], [c, a]].map(|[p, r]| sign(&determinant([&direction, p, r])));
            if sides.contains(&0) {
                continue 'cast;
            }
            if sides == [volume; 3] {
                sum += volume;
            }
        }
        return Some(sum);
    }
}

/// True if a closed triangle holds a point, exactly.
pub fn holds(triangle: &[DVec3; 3], point: DVec3) -> bool {
    let [a, b, c] = triangle;
    let apart = point.cmplt(a.min(*b).min(*c)).any() || point.cmpgt(a.max(*b).max(*c)).any();
    !apart && Distance::of(triangle, &[point; 3]).is_zero()
}

/// The solid angle of a mesh over 4 pi, by the sum over all triangles.
pub fn full_sum(mesh: &Mesh, point: DVec3) -> f64 {
    let (mut sum, mut rest) = (0.0, 0.0);
    for i in 0..mesh.len() {
        let [a, b, c] = mesh.triangle(i).map(|corner| corner - point);
        let [x, y, z] = [a, b, c].map(DVec3::length);
        let above = a.dot(b.cross(c));
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        let angle = above.atan2(below) / (2.0 * PI) - rest;
        let next: f64 = sum + angle;
        rest = (next - sum) - angle;
        sum = next;
    }
    sum
}

/// The exact distance of a point from a mesh.
pub fn distance(mesh: &Mesh, point: DVec3) -> Distance {
    let all = (0..mesh.len()).map(|i| Distance::of(&mesh.triangle(i), &[point; 3]));
    all.reduce(|least, other| if other.is_less(&least) { other } else { least })
        .expect("triangles")
}

/// Panics unless what is said of a point of a closed mesh is true. `truth`: the winding number, or `None` on the surface.
pub fn assert_sound(said: &PointBounds, truth: Option<i32>, away: Option<&Distance>) {
    match truth {
        Some(winding) => {
            assert!(!said.is_on_surface, "{said:?}");
            assert!(
                said.inside.is_none_or(|inside| inside == (winding >= 1)),
                "{said:?}"
            );
            assert!(
                said.winding.is_none_or(|found| found == f64::from(winding)),
                "{said:?}"
            );
        }
        None => {
            assert!(said.inside.is_none_or(|inside| inside), "{said:?}");
            assert_eq!(said.is_on_surface, said.inside.is_some());
        }
    }
    let (Some(SignedDistance { low, high, .. }), Some(away)) = (said.distance, away) else {
        return;
    };
    let inside = truth.is_some_and(|winding| winding >= 1);
    // The distance is at most a bound, and at least one.
    let below = |bound: f64| bound >= 0.0 && away.order_of(bound) != Ordering::Less;
    let above = |bound: f64| bound <= 0.0 || away.order_of(bound) != Ordering::Greater;
    let is_true = if inside {
        below(-low) && above(-high)
    } else {
        below(high) && above(low)
    };
    assert!(is_true && low <= high, "{low} {high} {}", away.rounded());
}
