//! Polygons into triangles, none of which leaves its polygon.
//!
//! A polygon is looked at along the axis that its normal is nearest to, in which its area is largest, so that its
//! coordinates stay as they are and every decision is exact (crate `robust`). Where the fan of triangles around the first
//! corner fills it, as it does if the polygon is convex, it is that fan. Else ears are cut off: corners at which the
//! outline turns inwards, with the triangle to both neighbours. Each of these triangles has the polygon's sense of
//! rotation, and together they have its outline, so that every point is in as many of them as the polygon winds around it:
//! none outside. So where all ears can be cut off, the result is right. Of an outline that crosses itself some part
//! winds
//! the other way round; what is left of it when no ear is found becomes a fan, which the caller is told. A polygon that
//! is not
//! flat is filled as it looks along the axis.
//!
//! A fan takes `O(n)`. Ears take `O(n log n)` if few corners are near one another along the longer axis, and at most `O(n)`
//! tests a corner; there is a limit to that, beyond which what is left becomes a fan too.

use robust::{Coord, orient2d};

/// Adds the triangles of the polygon with these corners, two fewer than corners; tells what is out of order, if
/// anything is.
pub(crate) fn fill(
    corners: &[u32],
    vertices: &[[f64; 3]],
    triangles: &mut Vec<[u32; 3]>,
) -> Option<&'static str> {
    if corners.len() < 3 {
        return Some("face of fewer than 3 corners passed over");
    }
    let fan = corners
        .windows(2)
        .skip(1)
        .map(|edge| [corners[0], edge[0], edge[1]]);
    if corners.len() == 3 {
        triangles.extend(fan);
        return None;
    }
    let mut points: Vec<[f64; 3]> = corners
        .iter()
        .map(|&corner| vertices[corner as usize])
        .collect();
    let largest = points
        .as_flattened()
        .iter()
        .fold(0.0, |largest: f64, x| largest.max(x.abs()));
    // A number that is none is for the mesh to complain of, with its line.
    if largest == 0.0 || !points.as_flattened().iter().all(|x| x.is_finite()) {
        triangles.extend(fan);
        return None;
    }
    // By a power of two, so that products neither overflow nor vanish.
    let scale = power_of_two_below(largest);
    points
        .as_flattened_mut()
        .iter_mut()
        .for_each(|x| *x /= scale);
    let areas = [0, 1, 2].map(|axis| area(&points, axis));
    let axis = (0..3)
        .max_by(|&i, &j| areas[i].abs().total_cmp(&areas[j].abs()))
        .unwrap_or(0);
    let seen = along(&points, axis);
    if fan_fills(&seen) || (0..3).all(|axis| is_line(&along(&points, axis))) {
        triangles.extend(fan);
        return None;
    }
    let sense = areas[axis].signum();
    let cut = Outline::new(&seen, sense).cut();
    let (ears, oddity) = match cut
        .or_else(|rest| Outline::new(&seen, -sense).cut().map_err(|_| rest))
    {
        Ok(ears) => (ears, None),
        Err(ears) => (
            ears,
            Some(
                "polygon that crosses itself, or has too many corners, filled with some diagonals",
            ),
        ),
    };
    triangles.extend(
        ears.into_iter()
            .map(|triangle| triangle.map(|i| corners[i])),
    );
    oddity
}

/// The triangles of a strip, all with the sense of rotation of the first. Those with two corners in one place join
/// parts of the
/// strip, and are none.
pub(crate) fn strip(corners: &[u32], vertices: &[[f64; 3]], triangles: &mut Vec<[u32; 3]>) {
    let turned = corners
        .windows(3)
        .zip(0..)
        .map(|(w, i)| [w[0], w[1 + i % 2], w[2 - i % 2]]);
    let is_triangle = |[a, b, c]: &[u32; 3]| {
        let [p, q, r] = [a, b, c].map(|&corner| vertices[corner as usize]);
        p != q && q != r && r != p
    };
    triangles.extend(turned.filter(is_triangle));
}

fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.max(f64::MIN_POSITIVE).to_bits() & f64::INFINITY.to_bits())
}

/// Twice the area inside as it looks against an axis, positive if the polygon runs counter-clockwise; about.
fn area(points: &[[f64; 3]], axis: usize) -> f64 {
    let from = |p: [f64; 3], k: usize| p[k % 3] - points[0][k % 3];
    let twice = points.windows(2).map(|edge| {
        let [p, q] = [edge[0], edge[1]];
        from(p, axis + 1) * from(q, axis + 2) - from(p, axis + 2) * from(q, axis + 1)
    });
    twice.sum()
}

/// The points as they look against an axis, right-handed.
fn along(points: &[[f64; 3]], axis: usize) -> Vec<[f64; 2]> {
    points
        .iter()
        .map(|point| [point[(axis + 1) % 3], point[(axis + 2) % 3]])
        .collect()
}

/// Positive where `a`, `b`, `c` turn left, 0 on a line; the sign is exact.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}

/// Whether a point on the line through `p` and `q` lies between them, and is neither.
fn lies_between(point: [f64; 2], p: [f64; 2], q: [f64; 2]) -> bool {
    (0..2).any(|k| (p[k] < point[k] && point[k] < q[k]) || (q[k] < point[k] && point[k] < p[k]))
}

fn is_line(points: &[[f64; 2]]) -> bool {
    let second = points.iter().find(|&&point| point != points[0]);
    second.is_none_or(|&second| {
        points
            .iter()
            .all(|&point| turn(points[0], second, point) == 0.0)
    })
}

/// Whether the fan around the first corner fills a polygon that is no line: the other corners lie on one side of the first edge
/// and turn around the first corner in one direction, so that its triangles lie side by side.
fn fan_fills(points: &[[f64; 2]]) -> bool {
    let center = points[0];
    let is_center = |point: &&[f64; 2]| **point == center;
    let before = points.iter().take_while(is_center).count();
    let after = points.iter().rev().take_while(is_center).count();
    let Some(others) = points
        .get(before..points.len() - after)
        .filter(|others| !others.contains(&center))
    else {
        return false;
    };
    let first = others[0];
    let Some(side) = others
        .iter()
        .map(|&point| turn(center, first, point))
        .find(|&side| side != 0.0)
    else {
        return false;
    };
    let agrees = |turn: f64| turn * side.signum() >= 0.0;
    others.windows(2).all(|edge| {
        let [p, q] = [edge[0], edge[1]];
        let around = turn(center, p, q);
        let passes_center = around == 0.0 && lies_between(center, p, q);
        agrees(around) && agrees(turn(center, first, q)) && !passes_center
    })
}

/// Tests allowed for each corner of a polygon: enough for any with 4,000 corners, and for most with more. The worst polygons
/// take 50 us a corner.
const TESTS: usize = 1 << 12;

/// What is left of a polygon while ears are cut off.
struct Outline<'p> {
    points: &'p [[f64; 2]],
    /// 1 if it runs counter-clockwise, else -1.
    sense: f64,
    /// The corners before and after each that is left.
    neighbors: Vec<[usize; 2]>,
    is_left: Vec<bool>,
    /// These corners, and some that are cut off, in the order of their places along `axis`.
    order: Vec<usize>,
    axis: usize,
    tests: usize,
}

impl<'p> Outline<'p> {
    fn new(points: &'p [[f64; 2]], sense: f64) -> Self {
        let n = points.len();
        let extent = |k: usize| {
            let (low, high) = points
                .iter()
                .fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[k]), h.max(p[k])));
            high - low
        };
        let axis = usize::from(extent(1) > extent(0));
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_unstable_by(|&i, &j| points[i][axis].total_cmp(&points[j][axis]));
        let neighbors = (0..n).map(|i| [(i + n - 1) % n, (i + 1) % n]).collect();
        Self {
            points,
            sense,
            neighbors,
            is_left: vec![true; n],
            order,
            axis,
            tests: 0,
        }
    }

    /// Cuts off one ear after the other. Where there is none before the end, the triangles are those ears and a fan.
    fn cut(mut self) -> Result<Vec<[usize; 3]>, Vec<[usize; 3]>> {
        let mut triangles = Vec::with_capacity(self.points.len() - 2);
        let (mut corner, mut left, mut in_vain) = (0, self.points.len(), 0);
        while left > 2 {
            let [before, after] = self.neighbors[corner];
            if self.is_ear(before, corner, after) {
                triangles.push([before, corner, after]);
                self.is_left[corner] = false;
                self.neighbors[before][1] = after;
                self.neighbors[after][0] = before;
                (corner, left, in_vain) = (before, left - 1, 0);
                if self.order.len() > 2 * left {
                    self.order.retain(|&i| self.is_left[i]);
                }
            } else {
                (corner, in_vain) = (after, in_vain + 1);
            }
            if in_vain > left || self.tests > TESTS * self.points.len() {
                let mut second = self.neighbors[corner][1];
                let mut third = self.neighbors[second][1];
                while third != corner {
                    triangles.push([corner, second, third]);
                    (second, third) = (third, self.neighbors[third][1]);
                }
                return Err(triangles);
            }
        }
        Ok(triangles)
    }

    /// Whether the outline turns inwards at a corner, and no other corner lies in the triangle or on its third side. Where the
    /// outline goes back on itself or stands still, the triangle is a line of the outline.
    fn is_ear(&mut self, before: usize, corner: usize, after: usize) -> bool {
        let [p, q, r] = [before, corner, after].map(|i| self.points[i]);
        let turned = self.sense * turn(p, q, r);
        if turned <= 0.0 {
            return turned == 0.0 && !lies_between(q, p, r);
        }
        let along = [p, q, r].map(|point| point[self.axis]);
        let low = along[0].min(along[1]).min(along[2]);
        let high = along[0].max(along[1]).max(along[2]);
        let place = |i: usize| self.points[i][self.axis];
        let first = self.order.partition_point(|&i| place(i) < low);
        let near = self.order[first..]
            .iter()
            .take_while(|&&i| place(i) <= high);
        let is_inside = |x: [f64; 2]| {
            let left_of = |from, to| self.sense * turn(from, to, x);
            left_of(p, q) > 0.0 && left_of(q, r) > 0.0 && left_of(r, p) >= 0.0 && x != p && x != r
        };
        let mut tests = 0;
        let is_free = near
            .inspect(|_| tests += 1)
            .all(|&i| !self.is_left[i] || !is_inside(self.points[i]));
        self.tests += tests;
        is_free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangles of a polygon on its own vertices.
    fn filled(points: &[[f64; 3]]) -> Result<Vec<[u32; 3]>, &'static str> {
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        let mut triangles = Vec::new();
        fill(&corners, points, &mut triangles).map_or(Ok(triangles), Err)
    }

    fn flat(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
        points.iter().map(|&[x, y]| [x, y, 0.0]).collect()
    }

    fn area_in_xy(points: &[[f64; 3]]) -> f64 {
        area(points, 2)
    }

    /// By the rule of even and odd crossings of a ray.
    fn is_inside(points: &[[f64; 3]], [x, y]: [f64; 2]) -> bool {
        let ends = points.iter().zip(points.iter().cycle().skip(1));
        let crossed = |p: &[f64; 3], q: &[f64; 3]| {
            (p[1] > y) != (q[1] > y) && x < p[0] + (q[0] - p[0]) * (y - p[1]) / (q[1] - p[1])
        };
        ends.filter(|(p, q)| crossed(p, q)).count() % 2 == 1
    }

    /// All triangles are of the polygon's sense and inside it, and have its area in sum; returns how many they are.
    #[track_caller]
    fn assert_filled(points: &[[f64; 3]]) -> usize {
        let triangles = filled(points).unwrap();
        let whole = area_in_xy(points);
        let mut sum = 0.0;
        for triangle in &triangles {
            let corners = triangle.map(|i| points[i as usize]);
            let part = area_in_xy(&corners);
            assert!(
                part * whole >= 0.0,
                "{points:?}: {triangle:?} is turned over"
            );
            sum += part;
            if part.abs() > 1e-9 * whole.abs() {
                let center = [0, 1].map(|k| corners.iter().map(|p| p[k]).sum::<f64>() / 3.0);
                assert!(
                    is_inside(points, center),
                    "{points:?}: {triangle:?} is outside"
                );
            }
        }
        assert!(
            (sum / whole - 1.0).abs() < 1e-9,
            "{points:?}: {sum} of {whole}"
        );
        triangles.len()
    }

    /// The polygon is told to be out of order; its triangles are as many as those of others, and none of its corners is
    /// lost.
    #[track_caller]
    fn assert_some_diagonals(points: &[[f64; 3]]) {
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        let mut triangles = Vec::new();
        assert!(
            fill(&corners, points, &mut triangles).is_some(),
            "{points:?}"
        );
        assert_eq!(triangles.len(), points.len() - 2);
        let mut used = triangles.concat();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used, corners);
    }

    const ARROW: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, -1.0], [1.0, 0.0], [4.0, 1.0]];

    #[test]
    fn convex_polygons_are_fans() {
        let circle: Vec<_> = (0..9)
            .map(|i| f64::from(i).sin_cos())
            .map(|(y, x)| [x, y, 0.0])
            .collect();
        let turned: Vec<_> = circle[..6]
            .iter()
            .map(|&[x, y, _]| [0.3, x, y + 0.1 * x])
            .collect();
        for points in [&circle[..6], &turned] {
            assert_eq!(
                filled(points),
                Ok(vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
            );
        }
        // A fan does for this one too, and so does it for corners on a side, repeated ones, and a line.
        assert_eq!(filled(&flat(&ARROW)).unwrap()[0], [0, 1, 2]);
        let square = flat(&[
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 0.0],
            [2.0, 2.0],
            [0.0, 2.0],
            [0.0, 0.0],
        ]);
        assert_eq!(filled(&square).unwrap().len(), 5);
        let line = [0.0, 3.0, 1.0, 2.0].map(|t| [t, 2.0 * t, -t]);
        assert_eq!(filled(&line).unwrap(), [[0, 1, 2], [0, 2, 3]]);
        // A warped quad is one of two folded pairs of triangles.
        assert_eq!(
            filled(&[[0.0; 3], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.1]])
                .unwrap()
                .len(),
            2
        );
    }

    #[test]
    fn concave_polygons_are_not_left() {
        let u = [
            [0., 0.],
            [3., 0.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [1., 1.],
            [1., 3.],
            [0., 3.],
        ];
        // With corners on the sides of the gap, which are none of the outline's turns.
        let gap = [
            [0., 0.],
            [4., 0.],
            [4., 3.],
            [3., 3.],
            [3., 2.],
            [3., 1.],
            [2., 1.],
            [1., 1.],
            [1., 3.],
            [0., 3.],
        ];
        for shape in [&ARROW[..], &u, &gap] {
            for start in 0..shape.len() {
                let mut points = flat(shape);
                points.rotate_left(start);
                assert_eq!(assert_filled(&points), points.len() - 2);
                points.reverse();
                assert_eq!(assert_filled(&points), points.len() - 2);
            }
        }
        // The same in another plane and of any size.
        for scale in [1e-300, 1.0, 1e300] {
            let points: Vec<_> = u
                .iter()
                .rev()
                .map(|&[x, y]| [scale * x, scale * y, scale * (x + 2.0 * y)])
                .collect();
            let mut steep: Vec<_> = points.iter().map(|&[x, y, z]| [z, x, y]).collect();
            for _ in 0..2 {
                let places: Vec<_> = filled(&steep).unwrap().into_iter().flatten().collect();
                assert!(
                    places.len() == 18 && (0..8).all(|corner| places.contains(&corner)),
                    "{scale}"
                );
                steep.rotate_left(3);
            }
        }
    }

    #[test]
    fn random_polygons_are_not_left() {
        let mut random = oorandom::Rand64::new(1);
        for _ in 0..2000 {
            let n = random.rand_range(4..40);
            let corner = |i: u64| {
                let (sin, cos) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
                let radius = 0.05 + random.rand_float();
                // Of few bits, so that corners lie on one line now and then.
                [radius * cos, radius * sin, 0.0].map(|x| (32.0 * x).round() / 32.0)
            };
            let mut points: Vec<_> = (0..n).map(corner).collect();
            points.dedup();
            // Rounding may have brought corners of one direction out of order.
            if filled(&points).is_ok() {
                // Fewer where it touches itself.
                assert!(assert_filled(&points) <= points.len() - 2);
            } else {
                assert!(n > 16, "{points:?}");
            }
        }
    }

    #[test]
    fn holes_that_a_cut_joins_to_the_outline_stay_open() {
        let outer = [[0., 0.], [9., 0.], [9., 9.], [0., 9.], [0., 0.]];
        let inner = [[3., 3.], [3., 6.], [6., 6.], [6., 3.], [3., 3.]];
        let points = flat(&[&outer[..], &inner].concat());
        for start in 0..points.len() {
            let mut points = points.clone();
            points.rotate_left(start);
            assert_eq!(assert_filled(&points), points.len() - 2);
        }
    }

    #[test]
    fn crossing_polygons_are_filled_with_some_diagonals() {
        let star = (0..5)
            .map(|i| (f64::from(i) * 0.8 * std::f64::consts::PI).sin_cos())
            .map(|(y, x)| [x, y])
            .collect();
        let cases: [Vec<[f64; 2]>; 4] = [
            vec![[0., 0.], [2., 2.], [2., 0.], [0., 2.]],
            vec![[0., 0.], [2., 2.], [3., 0.], [0., 1.]],
            star,
            // Two loops of opposite sense that share a corner.
            vec![[0., 0.], [1., 0.], [1., 1.], [0., 0.], [-1., 0.], [-1., 1.]],
        ];
        for points in cases {
            for start in 0..points.len() {
                let mut points = flat(&points);
                points.rotate_left(start);
                assert_some_diagonals(&points);
            }
        }
    }

    #[test]
    fn a_polygon_that_goes_there_and_back_is_lines() {
        let lines = flat(&[[0., 0.], [1., 0.], [1., 1.], [1., 0.]]);
        for start in 0..4 {
            let mut points = lines.clone();
            points.rotate_left(start);
            let triangles = filled(&points).unwrap();
            let corners: Vec<u32> = triangles.iter().flatten().copied().collect();
            assert!(
                (0..4).all(|corner| corners.contains(&corner)),
                "{triangles:?}"
            );
            assert!(
                triangles
                    .iter()
                    .all(|t| area_in_xy(&t.map(|i| points[i as usize])) == 0.0),
                "{triangles:?}"
            );
        }
    }

    /// Combs and a spiral: what a careless algorithm takes a second for each thousand corners of.
    #[test]
    fn long_polygons_take_no_long_time() {
        let comb = |n: u32, ragged: f64| {
            let length = move |i: u32| if i.is_multiple_of(2) { 0.0 } else { 1e4 } + ragged * f64::from(i % 7);
            let teeth = (0..n).map(move |i| [f64::from(i), length(i)]);
            teeth
                .chain([[f64::from(n), -1.0], [0.0, -1.0]])
                .collect::<Vec<_>>()
        };
        let arm = |width: f64| {
            (0..4000)
                .map(move |i| 0.01 * f64::from(i))
                .map(move |t| [(t + width) * t.cos(), (t + width) * t.sin()])
        };
        let spiral = arm(1.0).chain(arm(3.0).rev()).collect();
        for points in [comb(3000, 0.0), comb(30_000, 1.0), spiral] {
            assert_eq!(filled(&flat(&points)).unwrap().len(), points.len() - 2);
        }
        assert_some_diagonals(&flat(&comb(20_000, 0.0)));
    }
}
