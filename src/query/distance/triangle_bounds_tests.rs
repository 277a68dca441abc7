//! The distance bounds of triangles of two trees, against exact distances of their meshes.

use core::array::from_fn;
use core::cmp::Ordering;
use std::vec::Vec;

use super::closest_pairs::CLOSE;
use crate::engine::boxes::RelativePose;
use crate::mesh::Mesh;
use crate::tree::{BuildOptions, Tree, WIDTH};
use glam::{DMat3, DQuat, DVec3};
use punctual_geom::Pose;
use punctual_geom::lanes::{F8, Instructions, Kernel, Lanes};
use punctual_geom::random::Random;
use punctual_geom::triangle::distance::{Around, Distances, closest, distances};

#[path = "../../../tests/common/exact_distance.rs"]
mod exact_distance;
use exact_distance::Distance;

struct Batch<'q>([&'q Tree; 2], &'q RelativePose, [[usize; WIDTH]; 2]);

impl Kernel for Batch<'_> {
    type Output = Distances;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Distances {
        let Self([a, b], relative, [i, j]) = self;
        let (a, b) = (
            i.map(|i| &a.triangles()[i].0),
            j.map(|j| &b.triangles()[j].0),
        );
        distances(lanes, a, b, &relative.triangles)
    }
}

fn vector(random: &mut Random) -> DVec3 {
    DVec3::from_array(from_fn(|_| random.between(-1.0, 1.0)))
}

/// Random triangles around a point, of which each has one corner out of proportion.
#[derive(Clone, Copy)]
struct Soup {
    center: DVec3,
    reach: f64,
    /// Size of a triangle, relative to the reach.
    size: f64,
    /// Width of a triangle, relative to its length.
    width: f64,
}

impl Soup {
    fn of_round(round: usize, reach: f64, random: &mut Random) -> Self {
        Self {
            center: vector(random) * [0.0, 1.0, 1e3, 1e8][round % 4] * reach,
            reach,
            size: [0.3, 1e-2, 1e-4, 1e-6][round / 4 % 4],
            width: [1.0, 1.0, 1e-4, 0.0][round / 16 % 4],
        }
    }

    fn tree(self, random: &mut Random) -> Tree {
        let mut corners = Vec::new();
        for _ in 0..64 {
            let (middle, start, end) = (
                vector(random),
                vector(random) * self.size,
                vector(random) * self.size,
            );
            let third =
                start.lerp(end, random.fraction()) + vector(random) * (self.size * self.width);
            corners.extend(
                [start, end, third].map(|corner| self.center + (middle + corner) * self.reach),
            );
        }
        let triangles = (0..64).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
        Tree::with_options(
            Mesh::from_f64(corners, triangles).unwrap(),
            &BuildOptions::default(),
        )
    }
}

/// A rotation with errors of up to `drift` per entry, about the centre of `b`, which is placed near
/// that of `a`.
fn pose(a: &Soup, b: &Soup, drift: f64, random: &mut Random) -> Pose {
    let [x, y, z, w] = from_fn(|_| random.between(-1.0, 1.0));
    let mut rotation = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w + 1e-3).normalize());
    for _ in 0..3 {
        let (column, row) = (random.bits() as usize % 3, random.bits() as usize % 3);
        rotation.col_mut(column)[row] += 0.15 * drift * random.between(-1.0, 1.0);
    }
    let shift = vector(random) * 1.5 * a.reach.max(b.reach);
    Pose::new(rotation, a.center - rotation * b.center + shift).unwrap()
}

/// The mesh triangle of row `i` of a tree.
fn corners(tree: &Tree, i: usize) -> [DVec3; 3] {
    tree.mesh().triangle(tree.ids()[i] as usize)
}

/// Checks eight pairs. The pose places the first pair at a distance of about `gap`.
fn check(a: &Tree, b: &Tree, pose: Pose, gap: f64, random: &mut Random) -> [[f64; 2]; WIDTH] {
    let pairs: [[usize; WIDTH]; 2] = from_fn(|_| from_fn(|_| random.bits() as usize % 64));
    let place = |pose: &Pose, j: usize| corners(b, j).map(|v| pose.transform_point(v));
    let near = closest(&corners(a, pairs[0][0]), &place(&pose, pairs[1][0]));
    let translation = pose.translation() + near.direction * (near.low - gap);
    let pose = Pose::new(*pose.rotation(), translation).unwrap();

    let relative = RelativePose::new(a, b, &pose);
    let [fast, portable] = [Instructions::detect(), Instructions::PORTABLE]
        .map(|set| set.run(Batch([a, b], &relative, pairs)));
    assert_eq!(fast.low.map(f32::to_bits), portable.low.map(f32::to_bits));
    from_fn(|lane| {
        let (i, j) = (pairs[0][lane], pairs[1][lane]);
        let exact = Distance::of(&corners(a, i), &place(&pose, j));
        let low = f64::from(fast.low[lane]) * a.unit().length();
        assert_ne!(
            exact.order_of(low),
            Ordering::Greater,
            "{low:e}, not {:e}: {pose:?}",
            exact.rounded()
        );
        // A direction that proves nearly all of the distance is within 5 degrees of the normal.
        let found = closest(&corners(a, i), &place(&pose, j));
        let is_close = low > 0.0 && fast.low[lane] >= CLOSE * fast.about[lane];
        if is_close && found.low > 0.9999 * found.high {
            let direction = DVec3::from(fast.direction.map(|of_axis| f64::from(of_axis[lane])));
            let cosine = direction.normalize().dot(found.direction);
            assert!(cosine > 0.996, "{cosine}: {pose:?}");
        }
        // The closest features are at the reported places; a face has none.
        let triangles = [corners(a, i), place(&pose, j)];
        let [p, q] = from_fn(|side| {
            let places = &fast.places[side];
            let [from, to] = *[[0, 1], [0, 2], [1, 2]].get(places.edge[lane] as usize)?;
            let ends = [from, to].map(|corner: usize| triangles[side][corner]);
            Some(ends[0].lerp(ends[1], f64::from(places.along[lane])))
        });
        if let (true, Some(p), Some(q)) = (is_close, p, q) {
            assert!((p - q).length() <= 1.01 * found.high, "{pose:?}");
        }
        [low, exact.rounded()]
    })
}

#[test]
fn no_distance_is_below_its_bound() {
    let mut random = Random::new(1);
    let mut proven = 0;
    for round in 0..1200 {
        let mut soup = |reach: f64| Soup::of_round(round, reach, &mut random);
        // The last ratio is beyond the range in which `f32` proves anything.
        let ratio = f64::exp2([0.0, 3.0, -10.0, 20.0, -29.0, 29.0, 40.0][round / 3 % 7]);
        let (a, b) = (soup(1.0), soup(ratio));
        let (tree_a, tree_b) = (a.tree(&mut random), b.tree(&mut random));
        let pose = pose(&a, &b, [0.0, 1e-7, 1e-3][round % 3], &mut random);
        let gap = f64::exp2(-random.between(0.0, 40.0)) * a.size.min(b.size * ratio);
        proven += check(&tree_a, &tree_b, pose, gap, &mut random)
            .iter()
            .filter(|[low, _]| *low > 0.0)
            .count();
    }
    assert!(proven > 3000, "{proven}");
}

/// Nearly all of the distance is proven for meshes near the origin, down to gaps of 1e-4 of the
/// size of the triangles.
#[test]
fn bounds_are_tight_where_numbers_are_good() {
    let mut random = Random::new(2);
    for round in 0..400 {
        let soup = Soup {
            center: vector(&mut random) * 3.0,
            reach: 1.0,
            size: 0.02,
            width: 1.0,
        };
        let (a, b) = (soup.tree(&mut random), soup.tree(&mut random));
        let gap = 0.02 * [1.0, 1e-2, 1e-3, 1e-4][round % 4];
        let lanes = check(
            &a,
            &b,
            pose(&soup, &soup, 0.0, &mut random),
            gap,
            &mut random,
        );
        for (lane, [low, distance]) in lanes.into_iter().enumerate() {
            let share = if lane > 0 {
                0.999
            } else {
                [0.999, 0.998, 0.99, 0.9][round % 4]
            };
            assert!(
                low >= share * distance || distance == 0.0,
                "{low:e} {distance:e} {round} {lane}"
            );
        }
    }
}

/// The bounds of eight points of a cloud around eight triangles.
struct Near<'q>([&'q Tree; 2], &'q RelativePose, [[usize; WIDTH]; 2]);

impl Kernel for Near<'_> {
    type Output = [[[f32; WIDTH]; 2]; WIDTH];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let Self([cloud, b], relative, [i, j]) = self;
        let points = cloud.points(i.map(|i| i as u32));
        let triangles = j.map(|j| &b.triangles()[j].0);
        let around = Around::new(lanes, &points[0].0, triangles, &relative.triangles);
        let bounds = |point: &crate::tree::Triangle| {
            let at =
                |rows: &[[f32; 4]; 3], k: usize| f64::from(rows[0][k]) + f64::from(rows[2][k + 1]);
            let to = from_fn(|k| (at(&point.0, k) - at(&points[0].0, k)) as f32);
            around.bounds(lanes, to).map(F8::store)
        };
        points.each_ref().map(bounds)
    }
}

#[test]
fn points_are_between_their_bounds() {
    let mut random = Random::new(3);
    let mut proven = 0;
    for round in 0..900 {
        let mut soup = |reach: f64| Soup::of_round(round, reach, &mut random);
        let ratio = f64::exp2([0.0, 3.0, -10.0, 20.0, -29.0, 29.0, 40.0][round / 3 % 7]);
        let (a, b) = (soup(1.0), soup(ratio));
        let tree = b.tree(&mut random);
        let drift = [0.0, 1e-7, 1e-3][round % 3];
        let pose = pose(&a, &b, drift, &mut random);
        // Some points are near triangles, on all scales, so that no bound is only large.
        let points = (0..64).map(|_| {
            let [p, q, r] = corners(&tree, random.bits() as usize % 64);
            let on = p.lerp(q, random.fraction()).lerp(r, random.fraction());
            let off = b.reach * f64::exp2(-random.between(0.0, 40.0));
            pose.transform_point(on) + vector(&mut random) * off
        });
        let points: Vec<_> = points.collect();
        let cloud = Tree::from_points_f64(points.iter().copied()).unwrap();
        let relative = RelativePose::new(&cloud, &tree, &pose);
        let first = random.bits() as usize % 8 * 8;
        let chosen = [
            from_fn(|i| first + i),
            from_fn(|_| random.bits() as usize % 64),
        ];
        let [fast, portable] = [Instructions::detect(), Instructions::PORTABLE]
            .map(|set| set.run(Near([&cloud, &tree], &relative, chosen)));
        let bits = |bounds: &[[[f32; WIDTH]; 2]; WIDTH]| {
            bounds.map(|of_point| of_point.map(|bound| bound.map(f32::to_bits)))
        };
        assert_eq!(bits(&fast), bits(&portable));
        for (i, of_point) in fast.iter().enumerate() {
            let point = corners(&cloud, chosen[0][i]);
            for lane in 0..WIDTH {
                let triangle = corners(&tree, chosen[1][lane]).map(|v| pose.transform_point(v));
                let exact = Distance::of(&point, &triangle);
                let [low, high] = of_point.map(|bound| f64::from(bound[lane]));
                let [low, high] = [low, high].map(|bound| bound * relative.unit);
                assert_ne!(exact.order_of(low), Ordering::Greater, "{low:e} {round}");
                if high.is_finite() && relative.shrink > 0.0 {
                    assert_ne!(exact.order_of(high), Ordering::Less, "{high:e} {round}");
                    proven += u32::from(high - low < 1e-4 * high);
                }
            }
        }
    }
    assert!(proven > 30_000, "{proven}");
}
