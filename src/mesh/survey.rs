//! A single pass over all vertices: checks them, and finds the box around them and the least
//! magnitude of a coordinate.

use punctual_geom::denormals::Number;
use punctual_geom::lanes::{Instructions, Kernel, Lanes, per_lane};
use punctual_geom::{Aabb, tolerance::COORDINATE_LIMIT};

#[derive(Clone, Debug)]
pub(crate) struct Survey {
    /// True if no coordinate exceeds the limit or is NaN.
    pub is_good: bool,
    /// Box around all points; valid only if `is_good`.
    pub aabb: Aabb,
    /// See [`super::Mesh::least_exponent`].
    pub least_exponent: i32,
}

impl Survey {
    /// Adds the survey of other points.
    pub fn add(&mut self, other: &Self) {
        self.is_good &= other.is_good;
        self.aabb = self.aabb.union(&other.aabb);
        self.least_exponent = self.least_exponent.min(other.least_exponent);
    }
}

/// Surveys the points to which `of` maps `vertices`.
pub(crate) fn survey<V: Copy, N: Number>(vertices: &[V], of: impl Fn(V) -> [N; 3]) -> Survey {
    Instructions::detect().run(Look { vertices, of })
}

struct Look<'v, V, F> {
    vertices: &'v [V],
    of: F,
}

impl<V: Copy, N: Number, F: Fn(V) -> [N; 3]> Kernel for Look<'_, V, F> {
    type Output = Survey;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> Survey {
        let mut seen = Seen {
            min: [N::INFINITY; 24],
            max: [N::NEG_INFINITY; 24],
            least: [N::ALL_BITS; 24],
            greatest: [N::NO_BITS; 24],
        };
        let (eights, rest) = self.vertices.as_chunks::<8>();
        for eight in eights {
            seen.note(per_lane!(i => (self.of)(eight[i])));
        }
        if let Some(last) = rest.len().checked_sub(1) {
            seen.note(per_lane!(i => (self.of)(rest[last.min(i)])));
        }
        seen.survey()
    }
}

/// Extremes of coordinates and of their magnitudes. Takes eight vertices at a time, one
/// coordinate per lane: three full registers of f32.
struct Seen<N: Number> {
    min: [N; 24],
    max: [N; 24],
    least: [N::Bits; 24],
    greatest: [N::Bits; 24],
}

impl<N: Number> Seen<N> {
    #[inline(always)]
    fn note(&mut self, vertices: [[N; 3]; 8]) {
        for (k, &x) in vertices.as_flattened().iter().enumerate() {
            self.min[k] = if x < self.min[k] { x } else { self.min[k] };
            self.max[k] = if self.max[k] < x { x } else { self.max[k] };
            self.least[k] = self.least[k].min(x.rank());
            self.greatest[k] = self.greatest[k].max(x.magnitude());
        }
    }

    fn survey(self) -> Survey {
        let points = |numbers: [N; 24]| per_lane!(i => [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]].map(Into::into));
        let greatest = self.greatest.into_iter().max().map(N::of_magnitude);
        let least = self.least.into_iter().min().unwrap_or(N::ALL_BITS);
        Survey {
            is_good: greatest.is_none_or(|greatest| greatest.into() <= COORDINATE_LIMIT),
            aabb: Aabb {
                min: Aabb::from_points(points(self.min)).min,
                max: Aabb::from_points(points(self.max)).max,
            },
            least_exponent: N::exponent(least),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// Compares with a scalar loop, for whole groups of eight vertices and for incomplete ones.
    #[test]
    fn a_survey_sees_every_coordinate() {
        for count in 0..=17 {
            for (place, odd) in [f64::NAN, f64::NEG_INFINITY, -1e302, 5e-324, 0.0, -7.5]
                .into_iter()
                .enumerate()
            {
                let mut vertices: Vec<[f64; 3]> = (0..count)
                    .map(|i| [f64::from(i) - 4.0, 0.25, -2.0 - f64::from(i)])
                    .collect();
                if let Some(x) = vertices.as_flattened_mut().iter_mut().nth_back(place) {
                    *x = odd;
                }
                let numbers = vertices.as_flattened();
                let found = survey(&vertices, |vertex| vertex);
                let is_good = numbers.iter().all(|x| x.abs() <= COORDINATE_LIMIT);
                assert_eq!(found.is_good, is_good, "{vertices:?}");
                let least = numbers.iter().map(|x| x.rank()).min();
                assert_eq!(
                    found.least_exponent,
                    f64::exponent(least.unwrap_or(u64::MAX))
                );
                if is_good {
                    assert_eq!(found.aabb, Aabb::from_points(vertices.iter().copied()));
                }
                let narrow: Vec<[f32; 3]> = vertices
                    .iter()
                    .map(|vertex| vertex.map(|x| x as f32))
                    .collect();
                assert_eq!(
                    survey(&narrow, |vertex| vertex).is_good,
                    narrow.as_flattened().iter().all(|x| x.is_finite())
                );
            }
        }
    }
}
