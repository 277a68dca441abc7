//! Contact manifolds: what a solver needs of a pair of bodies, at most four points for each piece
//! of contact, with signed distances and ids that last from frame to frame.
//!
//! [`skin`] reduces pairs of triangles that are apart while a query lists them. The overlaps of
//! sunk surfaces are computed by the query. A [`PairMemory`](crate::PairMemory) carries ids over to
//! the next frame.

mod skin;

use crate::engine::memory::identity::Before;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual_geom::bits;
pub(crate) use skin::{SAME, Shape, Skin, around, falls_beside};
use wide::f64x4;

/// Maximum number of points of a manifold.
const POINTS: usize = 4;

/// A piece of contact: points that share a direction of contact. Lengths are in the unit of the
/// meshes, vectors in A's frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Manifold {
    /// Constant from frame to frame while the manifold keeps a point
    /// ([`Query::with_memory`](crate::Query::with_memory)). Without a memory, its index.
    pub id: u64,
    /// Unit vector from B to A: moving A along it separates this piece.
    ///
    /// If the surfaces are apart, the normal of the nearest point. For an overlap, minus the area
    /// vector of the region of A's surface that is inside B, normalized: the direction in which the
    /// volume of the overlap shrinks the fastest. If the overlap is bounded by a flat face within 7
    /// degrees of it, the normal of that face. Zero if the piece has no normal: if the
    /// vectors of its contact curves cancel out, as for a pin through a plate, or a curve is open.
    pub normal: DVec3,
    /// The least signed distance found; minus the depth if it is negative.
    pub distance: f64,
    /// Area projected along the normal: of the region inside the other surface, and of the parts of
    /// faces that face each other within 45 degrees, no farther apart than the skin.
    pub area: f64,
    /// Middle of that area; the middle of the points if there is none.
    pub centroid: DVec3,
    /// True if the surfaces are sunk into each other in this piece. False if they are apart or only
    /// touch: if they are sunk by no more than about 1e-12 times the largest coordinate.
    pub is_overlap: bool,
    /// True if all of the piece was examined. False if the region of an overlap has more than
    /// [`REGION_LIMIT`](crate::contacts::REGION_LIMIT) triangles: then the depth is a lower bound.
    pub is_whole: bool,
    pub(crate) points: ArrayVec<ManifoldPoint, POINTS>,
}

/// A point of a [`Manifold`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ManifoldPoint {
    /// Constant from frame to frame while the point stays near its place on A or on B.
    pub id: u64,
    /// The point on A and the point on B, in A's frame. Their difference is `distance` times the
    /// normal, up to rounding.
    pub points: [DVec3; 2],
    /// Unit vector from B to A at this point. In an overlap, the normal of the manifold.
    pub normal: DVec3,
    /// Signed distance along the normal: negative if the surfaces are sunk into each other.
    pub distance: f64,
}

impl Manifold {
    /// Its points: at least one, at most four. The first has the least distance, up to rounding;
    /// with a memory, up to a thousandth of the extent, so that points do not change with every
    /// small motion.
    #[must_use]
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points
    }

    /// Turns a manifold of the cores into that of surfaces with these radii.
    pub(crate) fn thicken(&mut self, radii: [f64; 2]) {
        let [of_a, of_b] = radii;
        if of_a + of_b == 0.0 {
            return;
        }
        for point in &mut self.points {
            point.points[0] -= point.normal * of_a;
            point.points[1] += point.normal * of_b;
            point.distance -= of_a + of_b;
        }
        self.centroid += self.normal * (0.5 * (of_b - of_a));
        self.distance -= of_a + of_b;
        self.is_overlap |= self.distance < 0.0;
    }

    /// Makes a manifold of at most four of these candidates, which stand for all of them.
    pub(crate) fn of(
        normal: DVec3,
        candidates: &[ManifoldPoint],
        tilt: f64,
        before: Before,
    ) -> Self {
        let chosen = choose(normal, candidates, tilt, before.stay(candidates));
        let points: ArrayVec<_, POINTS> = chosen.into_iter().map(|i| candidates[i]).collect();
        let distances = candidates.iter().map(|point| point.distance);
        let distance = distances.reduce(f64::min).unwrap_or(0.0);
        let count = points.len().max(1) as f64;
        let centroid = points
            .iter()
            .map(|point| point.middle() / count)
            .sum::<DVec3>();
        Self {
            id: 0,
            normal,
            distance,
            area: 0.0,
            centroid,
            is_overlap: false,
            is_whole: true,
            points,
        }
    }
}

impl ManifoldPoint {
    pub(crate) fn new(points: [DVec3; 2], normal: DVec3, distance: f64) -> Self {
        Self {
            id: 0,
            points,
            normal,
            distance,
        }
    }

    pub(crate) fn middle(&self) -> DVec3 {
        0.5 * self.points[0] + 0.5 * self.points[1]
    }
}

/// Numbers manifolds and points in their order.
pub(crate) fn number(manifolds: &mut [Manifold]) {
    let mut points = 0;
    for (id, manifold) in (0..).zip(manifolds) {
        manifold.id = id;
        for point in &mut manifold.points {
            point.id = points;
            points += 1;
        }
    }
}

/// Two unit vectors across a normal, turned so that the eight directions between them are not those
/// of the edges of a box, which tie.
pub(crate) fn frame(normal: DVec3) -> [DVec3; 2] {
    const TURN: [f64; 2] = [0.932_327_345_606_034_2, 0.361_615_431_964_962_4];
    let (x, y) = normal.any_orthonormal_pair();
    [x * TURN[0] + y * TURN[1], y * TURN[0] - x * TURN[1]]
}

/// The farthest of points along eight directions, and one value for each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Octagon<T> {
    /// Components of four axes across a normal; with their opposites they are eight directions.
    axes: [f64x4; 3],
    /// Along the axes, and along their opposites; minus infinity without points.
    reach: [f64x4; 2],
    values: [[T; 4]; 2],
}

impl<T: Copy> Octagon<T> {
    /// No points. `value` stands for those that are missing.
    pub fn new(normal: DVec3, value: T) -> Self {
        let ([x, y], half) = (frame(normal), core::f64::consts::FRAC_1_SQRT_2);
        let axes = [x, (x + y) * half, y, (y - x) * half];
        Self {
            axes: [0, 1, 2].map(|k| f64x4::new(axes.map(|axis| axis[k]))),
            reach: [f64x4::splat(f64::NEG_INFINITY); 2],
            values: [[value; 4]; 2],
        }
    }

    #[inline(always)]
    fn along(&self, place: DVec3) -> f64x4 {
        self.axes[0] * place.x + self.axes[1] * place.y + self.axes[2] * place.z
    }

    /// Takes a point with its value, which counts as farther by `bonus`.
    #[inline]
    pub fn insert(&mut self, place: DVec3, bonus: f64, value: T) {
        let along = self.along(place);
        for (side, along) in [along + bonus, -along + bonus].into_iter().enumerate() {
            let is_farther = along.simd_gt(self.reach[side]);
            self.reach[side] = is_farther.select(along, self.reach[side]);
            for k in bits(is_farther.to_bitmask()) {
                self.values[side][k % 4] = value;
            }
        }
    }

    /// True if a point with this bonus may be farther than the others. The point is in the first
    /// triangle and, seen along the normal, within `shift` of the second.
    #[inline(always)]
    pub fn may_gain(&self, [a, b]: [&[DVec3; 3]; 2], bonus: f64, shift: f64) -> bool {
        let range = |corners: &[DVec3; 3]| {
            let [x, y, z] = corners.map(|corner| self.along(corner));
            [x.fast_min(y).fast_min(z), x.fast_max(y).fast_max(z)]
        };
        let ([a_low, a_high], [b_low, b_high]) = (range(a), range(b));
        let ahead = a_high.fast_min(b_high + shift) + bonus;
        let behind = -a_low.fast_max(b_low - shift) + bonus;
        (ahead.simd_gt(self.reach[0]) | behind.simd_gt(self.reach[1])).any()
    }

    /// The values found, each once for each direction.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        let reach = self.reach.iter().flat_map(|reach| reach.as_array());
        let known = reach.zip(self.values.as_flattened());
        known
            .filter(|(reach, _)| **reach > f64::NEG_INFINITY)
            .map(|(_, value)| value)
    }
}

/// Distances that differ by less than this, relative to the extent, count as equal.
const ROUNDING: f64 = 1e-9;

/// Points this close, relative to the extent and to their coordinates, count as one: where edges
/// cross, each pair of triangles beside them finds the same point, up to rounding.
const ONE_PLACE: [f64; 2] = [1e-6, 1e-9];

/// A candidate that stays from the frame before counts as the deepest if it is less deep by no more
/// than this, relative to the extent.
const EVEN: f64 = 1e-3;

/// Factor of the gain of a candidate that stays from the frame before.
const STAY: f64 = 1.5;

/// The indices of at most four of these points: the one with the least distance, then those that
/// keep the bodies apart where the chosen ones do not. Of those whose distances differ by rounding,
/// the one farthest from the middle; of equal ones the first. Those that `stay` (bits) are
/// preferred, so that the choice does not change with small motions.
///
/// While the chosen points stay apart, a body that turns by at most `tilt` (radians) sinks in at a
/// point `p` by no more than `tilt |p - q| + d(q) - d(p)`, where `q` is the nearest point of the
/// polygon chosen and `d` the distance. The point with the largest bound is next.
pub(crate) fn choose(
    normal: DVec3,
    candidates: &[ManifoldPoint],
    tilt: f64,
    stay: u32,
) -> ArrayVec<usize, POINTS> {
    let [x, y] = frame(normal);
    let Some(first) = candidates.first() else {
        return ArrayVec::new();
    };
    let lift = |point: &ManifoldPoint| {
        let v = point.middle() - first.middle();
        DVec3::new(v.dot(x), v.dot(y), point.distance)
    };
    let reach = |point: &ManifoldPoint| lift(point).truncate().length();
    let extent = candidates.iter().map(reach).fold(0.0, f64::max);
    let least = candidates
        .iter()
        .map(|point| point.distance)
        .fold(f64::INFINITY, f64::min);
    let stays = |i: usize| stay.checked_shr(i as u32).is_some_and(|bits| bits & 1 != 0);
    let all = || candidates.iter().enumerate();
    let mut even = all().filter(|&(i, point)| stays(i) && point.distance <= least + EVEN * extent);
    let deep = all().filter(|(_, point)| point.distance <= least + ROUNDING * extent);
    let middle = candidates.iter().map(lift).sum::<DVec3>() / candidates.len() as f64;
    let outermost = deep.fold((0, -1.0), |best, (i, point)| {
        let out = (lift(point) - middle).truncate().length();
        if out > best.1 + ROUNDING * extent {
            (i, out)
        } else {
            best
        }
    });
    let deepest = even.next().map_or(outermost.0, |(i, _)| i);
    let mut chosen: ArrayVec<usize, POINTS> = [deepest].into_iter().collect();
    let mut corners: ArrayVec<DVec3, POINTS> = [lift(&candidates[deepest])].into_iter().collect();
    let least_gain = tilt * (ONE_PLACE[0] * extent + ONE_PLACE[1] * first.middle().length());
    while chosen.len() < POINTS {
        let (mut most, mut best) = (least_gain, None);
        for (i, point) in all() {
            let gain = if stays(i) { STAY } else { 1.0 } * sinks(&corners, lift(point), tilt);
            if gain > most {
                (most, best) = (gain, Some(i));
            }
        }
        let Some(best) = best else {
            break;
        };
        chosen.push(best);
        corners.push(lift(&candidates[best]));
    }
    chosen
}

/// The bound of [`choose`] for a point over the plane of a manifold, `z` its distance, and a
/// polygon of at most three corners.
fn sinks(corners: &[DVec3], point: DVec3, tilt: f64) -> f64 {
    let p = point.truncate();
    if let [a, b, c] = *corners {
        let turn = |u: DVec3, v: DVec3| (u.truncate() - p).perp_dot(v.truncate() - p);
        let parts = DVec3::new(turn(b, c), turn(c, a), turn(a, b));
        if parts.cmpge(DVec3::ZERO).all() || parts.cmple(DVec3::ZERO).all() {
            let height = parts.dot(DVec3::new(a.z, b.z, c.z)) / parts.element_sum();
            if height.is_finite() {
                return height - point.z;
            }
        }
    }
    let count = corners.len();
    let bounds = (0..count).map(|i| {
        let (from, to) = (corners[i], corners[(i + 1) % count]);
        let along = (to - from).truncate();
        let share = along.dot(p - from.truncate()) / along.length_squared();
        let nearest = if share.is_finite() {
            from.lerp(to, share.clamp(0.0, 1.0))
        } else {
            from
        };
        tilt * (p - nearest.truncate()).length() + nearest.z - point.z
    });
    bounds.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, distance: f64) -> ManifoldPoint {
        let place = DVec3::new(x, y, 0.0);
        ManifoldPoint::new([place; 2], DVec3::Z, distance)
    }

    #[test]
    fn the_deepest_and_those_that_span_most() {
        let grid: Vec<_> = (0..49)
            .map(|i| (f64::from(i % 7), f64::from(i / 7)))
            .map(|(x, y)| at(x, y, if (x, y) == (0.0, 0.0) { -0.2 } else { -0.1 }))
            .collect();
        let chosen = choose(DVec3::Z, &grid, 1.0, 0);
        assert_eq!(chosen.len(), 4);
        assert_eq!(grid[chosen[0]].distance, -0.2);
        for corner in [[0.0, 0.0], [6.0, 0.0], [0.0, 6.0], [6.0, 6.0]] {
            let is_it = |&i: &usize| grid[i].points[0].truncate().to_array() == corner;
            assert!(chosen.iter().any(is_it), "{corner:?} in {chosen:?}");
        }
        let line: Vec<_> = (0..9)
            .map(|i| at(f64::from(i), 2.0 * f64::from(i), 0.1))
            .collect();
        assert_eq!(choose(DVec3::Z, &line, 1.0, 0).len(), 2);
        assert_eq!(choose(DVec3::Z, &[at(1.0, 1.0, 0.0); 3], 1.0, 0).len(), 1);
        assert_eq!(choose(DVec3::Z, &[], 1.0, 0).len(), 0);
    }
}
