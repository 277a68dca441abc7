//! What a ray hits, in rational numbers, by solving for it: no signs of volumes, no case of the library's.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use punctual::glam::DVec3;
use punctual::rays::RayHit;
use punctual::{Ray, Tree};

type Number = BigRational;
type Vector = [Number; 3];

/// A line, exactly: points `origin + t direction` for t from 0 to 1, or on and on.
pub struct Line {
    pub ray: Ray,
    origin: Vector,
    direction: Vector,
}

fn exact(v: DVec3) -> Vector {
    v.to_array().map(|x| Number::from_float(x).unwrap())
}

fn sub(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|k| &a[k] - &b[k])
}

fn dot(a: &Vector, b: &Vector) -> Number {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        &a[i] * &b[j] - &a[j] * &b[i]
    })
}

fn is_zero(a: &Vector) -> bool {
    a.iter().all(Zero::is_zero)
}

impl Line {
    pub fn half_line(origin: DVec3, direction: DVec3) -> Self {
        let ray = Ray::new(origin, direction).unwrap();
        Self {
            ray,
            origin: exact(origin),
            direction: exact(direction),
        }
    }

    pub fn segment(from: DVec3, to: DVec3) -> Self {
        let ray = Ray::segment(from, to).unwrap();
        Self {
            ray,
            origin: exact(from),
            direction: sub(&exact(to), &exact(from)),
        }
    }

    /// The least parameter of a point shared with the closed hull of three points.
    pub fn first(&self, corners: [DVec3; 3]) -> Option<Number> {
        let corners = corners.map(exact);
        let [a, b, c] = &corners;
        let normal = cross(&sub(b, a), &sub(c, a));
        let (along, above) = (
            dot(&normal, &self.direction),
            dot(&normal, &sub(a, &self.origin)),
        );
        let span = if is_zero(&normal) {
            self.degenerate(&corners)?
        } else if along.is_zero() {
            if !above.is_zero() {
                return None;
            }
            self.in_plane(&corners, &normal)?
        } else {
            let t = above / along;
            let point: Vector = std::array::from_fn(|k| &self.origin[k] + &t * &self.direction[k]);
            let inside = |p: &Vector, q: &Vector| {
                !dot(&normal, &cross(&sub(q, p), &sub(&point, p))).is_negative()
            };
            if !(inside(a, b) && inside(b, c) && inside(c, a)) {
                return None;
            }
            [t.clone(), t]
        };
        let [first, last] = span;
        let is_late = self.ray.is_segment() && first > Number::from_integer(BigInt::from(1));
        if last.is_negative() || is_late {
            None
        } else {
            Some(first.max(Number::zero()))
        }
    }

    /// From where to where the line is inside the three edges.
    fn in_plane(&self, [a, b, c]: &[Vector; 3], normal: &Vector) -> Option<[Number; 2]> {
        let (mut first, mut last): (Option<Number>, Option<Number>) = (None, None);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let edge = sub(q, p);
            let start = dot(normal, &cross(&edge, &sub(&self.origin, p)));
            let slope = dot(normal, &cross(&edge, &self.direction));
            if slope.is_zero() {
                if start.is_negative() {
                    return None;
                }
            } else if slope.is_positive() {
                let t = -start / slope;
                first = Some(first.map_or(t.clone(), |first| first.max(t)));
            } else {
                let t = -start / slope;
                last = Some(last.map_or(t.clone(), |last| last.min(t)));
            }
        }
        let span = [first.unwrap(), last.unwrap()];
        (span[0] <= span[1]).then_some(span)
    }

    /// The same for three points on one line.
    fn degenerate(&self, corners: &[Vector; 3]) -> Option<[Number; 2]> {
        let order = |a: &&Vector, b: &&Vector| a.as_slice().cmp(b.as_slice());
        let (p, q) = (
            corners.iter().min_by(order).unwrap(),
            corners.iter().max_by(order).unwrap(),
        );
        let (edge, to_p) = (sub(q, p), sub(p, &self.origin));
        let square = dot(&self.direction, &self.direction);
        let across = cross(&self.direction, &edge);
        if is_zero(&across) {
            let t = |x: &Vector| dot(&sub(x, &self.origin), &self.direction) / &square;
            let (t, u) = (t(p), t(q));
            return is_zero(&cross(&to_p, &self.direction))
                .then(|| if t < u { [t, u] } else { [u, t] });
        }
        if !dot(&to_p, &across).is_zero() {
            return None;
        }
        let square = dot(&across, &across);
        let t = dot(&cross(&to_p, &edge), &across) / &square;
        let share = dot(&cross(&to_p, &self.direction), &across) / square;
        let is_inside = !share.is_negative() && share <= Number::from_integer(BigInt::from(1));
        is_inside.then(|| [t.clone(), t])
    }

    /// All triangles of a mesh that are hit, by id, with their exact parameters.
    pub fn all(&self, tree: &Tree) -> Vec<(u32, Number)> {
        let mesh = tree.mesh();
        (0..mesh.len())
            .filter_map(|id| Some((id as u32, self.first(mesh.triangle(id))?)))
            .collect()
    }

    /// That a parameter as it is told is as close to the exact one as is promised.
    pub fn assert_close(&self, tree: &Tree, hit: &RayHit, t: &Number) {
        if hit.t == f64::INFINITY {
            assert!(t.to_f64().is_none_or(f64::is_infinite), "{hit:?}: {t}");
            return;
        }
        let corners = tree
            .mesh()
            .triangle(hit.triangle as usize)
            .map(|corner| sub(&exact(corner), &self.origin));
        let largest = |vectors: &[Vector]| {
            vectors
                .as_flattened()
                .iter()
                .map(Signed::abs)
                .max()
                .unwrap()
        };
        let bound = largest(&corners) / largest(std::slice::from_ref(&self.direction));
        let told = Number::from_float(hit.t).unwrap();
        let error = (&told - t).abs();
        let least = Number::from_float(f64::from_bits(2)).unwrap();
        assert!(
            error <= bound * Number::from_float(1e-11).unwrap() + least,
            "{hit:?}: {t:?}"
        );
        assert!(!told.is_negative() && (!self.ray.is_segment() || hit.t <= 1.0));
    }
}
