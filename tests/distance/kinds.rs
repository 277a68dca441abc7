//! Single pairs of triangles of every kind that is hard to tell apart, against exact distances: what a finished answer
//! says
//! is true, and as tight as is promised, whatever their shape.
//!
//! `PUNCTUAL_PAIRS=10000000` takes so many pairs of each kind (a few hundred otherwise), and tells how far it is;
//! `PUNCTUAL_KIND=name` only one kind, `PUNCTUAL_SEED=n` others. A pair that fails is printed as the bits of its
//! coordinates.

use std::array::from_fn;
use std::cell::OnceCell;
use std::cmp::Ordering;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use punctual::distance::Bounds;
use punctual::glam::{DMat3, DVec3};
use punctual::{Answer, Mesh, Motion, Pose, Query, StopReason, Tree, Workspace};

use crate::bracket::{Bracket, bracket};
use crate::common::meshes;
use crate::common::random::{Drift, Random, pose_about};
use crate::distance::{ENOUGH, answer, run};
use crate::exact_distance::Distance;

type Triangle = [DVec3; 3];

/// Of so many pairs the points of one are judged, which takes longer than all else.
const POINTS: u64 = 16;

/// A triangle of A, and one of B before the pose brings it to A's frame.
#[derive(Clone, Copy, Debug)]
struct Given {
    a: Triangle,
    b: Triangle,
    /// Whether the corners are exact in `f32`.
    is_single: [bool; 2],
    pose: Pose,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    FatSingle,
    FatDouble,
    /// 1e-1 to 1e-300 of their length wide, the third corner anywhere along it.
    Slivers,
    /// The same, but for rounding in one direction.
    ParallelSlivers,
    /// A sliver and a fat triangle.
    SliverAndFat,
    /// Two corners next to each other.
    Needles,
    /// Exactly collinear in `f32`, turned by a pose.
    CollinearTurned,
    /// Collinear up to the rounding of `f64`.
    Collinear,
    /// Points and segments against anything.
    Points,
    /// A corner 0, or 1e-17 to 1e-6, off a point of the other triangle.
    CornerNear,
    /// The same of a point inside both triangles: they meet as a rule.
    Crossing,
    /// In one plane, up to the rounding of a pose.
    Coplanar,
    /// In planes 1e-17 to 1 apart, edges parallel.
    Parallel,
    /// One or two corners in common.
    Shared,
    /// Whole coordinates.
    Whole,
    /// Coordinates from the least denormal to 1e-300.
    Denormal,
    /// Coordinates up to 2^1000.
    Huge,
    /// 1e3 to 1e12 from the origin.
    Far,
    /// One 1e-1 to 1e-300 of the other.
    Unequal,
    /// Every exponent in one pair.
    Mixed,
}

impl Kind {
    const ALL: [Self; 20] = [
        Self::FatSingle,
        Self::FatDouble,
        Self::Slivers,
        Self::ParallelSlivers,
        Self::SliverAndFat,
        Self::Needles,
        Self::CollinearTurned,
        Self::Collinear,
        Self::Points,
        Self::CornerNear,
        Self::Crossing,
        Self::Coplanar,
        Self::Parallel,
        Self::Shared,
        Self::Whole,
        Self::Denormal,
        Self::Huge,
        Self::Far,
        Self::Unequal,
        Self::Mixed,
    ];

    fn pair(self, random: &mut Random) -> Given {
        let [a, b]: [Triangle; 2] = from_fn(|_| corners(random));
        let still = DMat3::IDENTITY;
        match self {
            Self::FatSingle => {
                let [a, b] = [a, b].map(|t| t.map(|corner| corner.as_vec3().as_dvec3()));
                let given = near(a, b, turn(random), random);
                given.single([true; 2])
            }
            Self::FatDouble => near(a, b, turn(random), random),
            Self::Slivers => {
                let [a, b] = [a, b].map(|t| sliver(t, width(random), random));
                near(a, b, turn(random), random)
            }
            Self::ParallelSlivers => {
                let a = sliver(a, width(random), random);
                let way = random.vector();
                let b = a.map(|corner| corner + way + width(random) * random.vector());
                near(a, b, still, random)
            }
            Self::SliverAndFat => {
                let b = sliver(b, width(random), random);
                near(a, b, turn(random), random)
            }
            Self::Needles => {
                let needle = |t: Triangle, random: &mut Random| {
                    let mut t = [t[0], t[1], t[1] + width(random) * random.vector()];
                    t.rotate_left(random.below(3));
                    t
                };
                let b = either(random, |_| b, |random| needle(b, random));
                near(needle(a, random), b, turn(random), random)
            }
            Self::CollinearTurned => {
                let [x, b] = from_fn(|_| collinear(random));
                let (a, is_single) = either(random, |_| (a, false), |_| (x, true));
                let given = near(a, b, turn(random), random);
                given.single([is_single, true])
            }
            Self::Collinear => {
                let flat = |t: Triangle, random: &mut Random| {
                    [t[0], t[1], t[0].lerp(t[1], 1.5 * random.signed())]
                };
                let a = either(random, |_| a, |random| flat(a, random));
                near(a, flat(b, random), turn(random), random)
            }
            Self::Points => {
                let [a, b] = [a, b].map(|t| match random.below(4) {
                    0 => [t[0]; 3],
                    1 => [t[0], t[0], t[1]],
                    2 => [t[0], t[1], t[0]],
                    _ => t,
                });
                near(a, b, turn(random), random)
            }
            Self::CornerNear => {
                let mut b = b;
                b[random.below(3)] = point_of(&a, random) + offset(random);
                placed(a, b, random)
            }
            Self::Crossing => {
                let way = point_of(&a, random) - point_of(&b, random) + offset(random);
                placed(a, b.map(|corner| corner + way), random)
            }
            Self::Coplanar => {
                let [a, b] = [a, b].map(flat);
                let turn = DMat3::from_rotation_z(random.signed());
                let rotation = random.rotation();
                let [x, y] = [a, b].map(|t| t.map(|v| rotation * v));
                let turned = |random: &mut Random| near(a, b, turn, random);
                either(random, turned, |random| near(x, y, still, random))
            }
            Self::Parallel => {
                let rotation = random.rotation();
                let b = flat([a[0], a[1], either(random, |_| a[2], |_| b[2])]);
                let along = DVec3::new(random.signed(), random.signed(), 0.0);
                let way = along + DVec3::Z * gap(random);
                let a = flat(a).map(|v| rotation * v);
                placed(a, b.map(|v| rotation * (v + way)), random)
            }
            Self::Shared => {
                let b = [a[1], either(random, |_| a[0], |_| b[1]), b[2]];
                let nudge = either(random, |_| DVec3::ZERO, offset);
                placed(a, b.map(|corner| corner + nudge), random)
            }
            Self::Whole => {
                let [a, b] = [a, b].map(|t| t.map(|corner| (2.0 * corner).round()));
                let rotation = either(random, |_| still, Random::rotation);
                let pose = Pose::new(rotation, a[0]).unwrap();
                Given::new(a, b, pose).single([true; 2])
            }
            Self::Denormal => {
                let scale = 10_f64.powf(-300.0 - 23.5 * random.unit());
                near(a, b, still, random).scaled(scale)
            }
            Self::Huge => {
                let scale = f64::exp2(990.0 * random.unit());
                let [a, b] = [a, b].map(|t| sliver(t, either(random, |_| 1.0, width), random));
                near(a, b, still, random).scaled(scale)
            }
            Self::Far => {
                let far = random.vector() * 10_f64.powf(3.0 + 9.0 * random.unit());
                let [a, b] = [a, b].map(|t| sliver(t, either(random, |_| 1.0, width), random));
                near(a, b, turn(random), random).moved(far)
            }
            Self::Unequal => {
                let factor = width(random);
                near(a, b.map(|corner| corner * factor), turn(random), random)
            }
            Self::Mixed => {
                let mut number =
                    || random.signed() * f64::exp2(-800.0 * random.unit() * random.unit());
                let [a, b] = from_fn(|_| from_fn(|_| DVec3::from_array(from_fn(|_| number()))));
                placed(a, b, random)
            }
        }
    }
}

/// One of two, by the toss of a coin.
fn either<T>(
    random: &mut Random,
    one: impl FnOnce(&mut Random) -> T,
    other: impl FnOnce(&mut Random) -> T,
) -> T {
    match random.below(2) {
        0 => one(random),
        _ => other(random),
    }
}

fn flat(t: Triangle) -> Triangle {
    t.map(|corner| DVec3::new(corner.x, corner.y, 0.0))
}

fn corners(random: &mut Random) -> Triangle {
    from_fn(|_| random.vector())
}

fn turn(random: &mut Random) -> DMat3 {
    if random.below(4) == 0 {
        DMat3::IDENTITY
    } else {
        random.rotation()
    }
}

/// 1e-1 to 1e-20 mostly, at times down to 1e-300.
fn width(random: &mut Random) -> f64 {
    let decades = if random.below(8) == 0 { 300.0 } else { 20.0 };
    10_f64.powf(-1.0 - (decades - 1.0) * random.unit())
}

/// 0 or 1e-17 to 1.
fn gap(random: &mut Random) -> f64 {
    if random.below(8) == 0 {
        0.0
    } else {
        10_f64.powf(-17.0 * random.unit())
    }
}

/// 0, or 1e-17 to 1e-6 long.
fn offset(random: &mut Random) -> DVec3 {
    let length = match random.below(8) {
        0 => 0.0,
        1..4 => 10_f64.powf(-17.0 + 2.0 * random.unit()),
        _ => 10_f64.powf(-16.0 + 10.0 * random.unit()),
    };
    random.vector() * length
}

fn sliver([start, end, third]: Triangle, width: f64, random: &mut Random) -> Triangle {
    // Anywhere along it, and at times a little beyond an end.
    let mut t = [
        start,
        end,
        start.lerp(end, 1.3 * random.unit() - 0.15) + third * width,
    ];
    t.rotate_left(random.below(3));
    t
}

/// Exactly so in `f32`.
fn collinear(random: &mut Random) -> Triangle {
    let whole = |random: &mut Random| (random.vector() * 256.0).round() / 256.0;
    let (start, step) = (whole(random), whole(random));
    from_fn(|_| start + step * ((random.unit() * 256.0).round() / 256.0))
}

/// A corner, or a point of an edge or inside, rounded.
fn point_of(t: &Triangle, random: &mut Random) -> DVec3 {
    let (mut s, mut u) = (random.unit(), random.unit());
    if s + u > 1.0 {
        (s, u) = (1.0 - s, 1.0 - u);
    }
    match random.below(4) {
        0 => t[random.below(3)],
        1 => t[1].lerp(t[2], s),
        _ => t[0] * (1.0 - s - u) + t[1] * s + t[2] * u,
    }
}

/// B's triangle comes with a point near one of A's, or anywhere.
fn near(a: Triangle, b: Triangle, rotation: DMat3, random: &mut Random) -> Given {
    let mut together = || point_of(&a, random) - rotation * point_of(&b, random);
    let together = together();
    let way = match random.below(4) {
        0 => 2.0 * random.vector(),
        1 => together + 0.3 * random.vector(),
        _ => together + offset(random),
    };
    Given::new(a, b, Pose::new(rotation, way).unwrap())
}

/// B's triangle is where it is, or turned there and back.
fn placed(a: Triangle, b: Triangle, random: &mut Random) -> Given {
    if random.below(2) == 0 {
        return Given::new(a, b, Pose::IDENTITY);
    }
    let pose = pose_about(DVec3::ZERO, 1.0, Drift::None, random);
    let back = pose.inverse().unwrap();
    Given::new(a, b.map(|corner| back.transform_point(corner)), pose)
}

impl Given {
    fn new(a: Triangle, b: Triangle, pose: Pose) -> Self {
        Self {
            a,
            b,
            is_single: [false; 2],
            pose,
        }
    }

    fn single(self, is_single: [bool; 2]) -> Self {
        Self { is_single, ..self }
    }

    fn scaled(mut self, factor: f64) -> Self {
        let way = self.pose.translation() * factor;
        self.pose = Pose::new(*self.pose.rotation(), way).unwrap();
        self.a = self.a.map(|v| v * factor);
        self.b = self.b.map(|v| v * factor);
        self
    }

    fn moved(mut self, far: DVec3) -> Self {
        let way = self.pose.translation() + far;
        self.pose = Pose::new(*self.pose.rotation(), way).unwrap();
        self.a = self.a.map(|v| v + far);
        self
    }

    /// The coordinates of both triangles, the columns of the rotation and the translation.
    fn bits(&self) -> [Vec<u64>; 3] {
        let DMat3 {
            x_axis,
            y_axis,
            z_axis,
        } = *self.pose.rotation();
        let pose = [x_axis, y_axis, z_axis, self.pose.translation()];
        let bits = |v: &DVec3| v.to_array().map(f64::to_bits);
        [&self.a[..], &self.b, &pose].map(|all| all.iter().flat_map(bits).collect())
    }

    /// Asked in all ways, and the other way round; what is true of it, and by which share of the bound the ends differ.
    #[track_caller]
    fn check(&self, workspace: &mut Workspace, round: u64) -> (Truth, f64) {
        let truth = Truth::of(
            self.a,
            self.b.map(|corner| self.pose.transform_point(corner)),
        );
        let trees = [
            mesh(&self.a, self.is_single[0]),
            mesh(&self.b, self.is_single[1]),
        ];
        let first = truth.check([&trees[0], &trees[1]], self.pose, workspace, round);
        // The other way round without a pose, whose inverse is rounded.
        let other = [mesh(&truth.b, false), mesh(&truth.a, self.is_single[0])];
        let turned = Truth {
            a: truth.b,
            b: truth.a,
            ..truth
        };
        let second = turned.check([&other[0], &other[1]], Pose::IDENTITY, workspace, round);
        (turned, first.max(second))
    }
}

fn mesh(t: &Triangle, is_single: bool) -> Tree {
    if !is_single {
        return meshes::one(*t);
    }
    let single = t.map(|corner| corner.as_vec3());
    Tree::new(Mesh::new(single, [[0, 1, 2]]).unwrap())
}

/// All that is true of a pair.
struct Truth {
    a: Triangle,
    b: Triangle,
    /// What is known quickly.
    bracket: Option<Bracket>,
    exact: OnceCell<Distance>,
    /// What finished bounds differ by at most if no tolerance is asked for: see `docs/numerics.md`.
    bound: f64,
    /// How far points are off the triangles at most.
    rounding: f64,
}

impl Truth {
    fn of(a: Triangle, b: Triangle) -> Self {
        let all = || a.iter().chain(&b);
        let low = all().copied().reduce(DVec3::min).unwrap();
        let high = all().copied().reduce(DVec3::max).unwrap();
        let largest = all().map(|v| v.abs().max_element()).fold(0.0, f64::max);
        let part = (high - low) / (2.0 * largest.max(f64::MIN_POSITIVE));
        let diagonal = 2.0 * largest * part.length();
        let bound = 3e-14 * diagonal + 2.0 * f64::MIN_POSITIVE;
        let rounding = 3e-15 * diagonal + 3e-16 * largest + 2.0 * f64::MIN_POSITIVE;
        Self {
            a,
            b,
            bracket: bracket(&a, &b),
            exact: OnceCell::new(),
            bound,
            rounding,
        }
    }

    fn exact(&self) -> &Distance {
        let exact = || Distance::of(&self.a, &self.b);
        self.exact.get_or_init(exact)
    }

    fn meet(&self) -> bool {
        match self.bracket {
            Some(bracket) if bracket.low > 0.0 || bracket.meet => bracket.meet,
            _ => self.exact().is_zero(),
        }
    }

    /// Off by less than a hundredth of the bound.
    fn distance(&self) -> f64 {
        match self.bracket {
            _ if self.meet() => 0.0,
            Some(Bracket { low, high, .. }) if high - low < 0.01 * self.bound => 0.5 * (low + high),
            _ => self.exact().rounded(),
        }
    }

    #[track_caller]
    fn assert_bounds(&self, low: f64, high: f64) {
        let is_told = |known: Bracket| match known.meet {
            true => low == 0.0,
            false => low <= known.low && known.high <= high,
        };
        if self.bracket.is_some_and(is_told) {
            return;
        }
        let exact = self.exact();
        let is_below = exact.order_of(low) != Ordering::Greater;
        assert!(is_below, "{low:e} is not below {:e}", exact.rounded());
        let is_above = exact.order_of(high) != Ordering::Less;
        assert!(is_above, "{high:e} is not above {:e}", exact.rounded());
    }

    /// The points are where they are said to be; those of triangles that meet are one.
    fn assert_points(&self, said: &Answer<Bounds>) {
        let [p, q] = said.value.nearest.unwrap().points;
        let meet = said.value.high == 0.0;
        let rounding = match meet {
            true => self.largest() * 1e-12 + 2.0 * f64::MIN_POSITIVE,
            false => self.rounding,
        };
        for (point, triangle) in [(p, &self.a), (q, &self.b)] {
            let off = Distance::of(&[point; 3], triangle);
            let is_on = off.order_of(rounding) != Ordering::Less;
            assert!(is_on, "{:e} > {rounding:e} off", off.rounded());
        }
        assert!(!meet || p == q, "they are apart");
        let apart = Distance::of(&[p; 3], &[q; 3]);
        let most = [said.value.high, 2.0 * self.rounding];
        let is_close = apart.order_of_sum(&most) != Ordering::Less;
        assert!(is_close, "{:e}", apart.rounded());
    }

    fn largest(&self) -> f64 {
        let all = self.a.iter().chain(&self.b);
        all.map(|v| v.abs().max_element()).fold(0.0, f64::max)
    }

    fn check(&self, [a, b]: [&Tree; 2], pose: Pose, workspace: &mut Workspace, round: u64) -> f64 {
        let query = Query::distance(a, b, pose);
        let exact = run(&query.absolute_tolerance(0.0), workspace, ENOUGH);
        let Bounds { low, high, .. } = exact.value;
        self.assert_bounds(low, high);
        assert_eq!(exact.stop, StopReason::Finished);
        assert_eq!(high == 0.0, self.meet(), "{exact:?}");
        assert!(high - low <= self.bound, "{exact:?} {:e}", self.distance());
        let [p, q] = exact.value.nearest.unwrap().points;
        assert!(p == q || high > 0.0, "{p} {q}");
        if round.is_multiple_of(POINTS) {
            self.assert_points(&exact);
        }
        let said = run(&query, workspace, ENOUGH).value;
        self.assert_bounds(said.low, said.high);
        let tolerance = 1e-6 * a.unit_length().max(b.unit_length());
        let tolerance = tolerance.max(1.01e-5 * said.low);
        assert!(said.high - said.low <= tolerance + self.bound, "{said:?}");

        let distance = self.distance();
        let [closer, farther] = [-1.5, 1.5].map(|times| distance + times * self.bound);
        let limits = [(closer, false), (farther, true)];
        for (limit, is_closer) in [(0.7 * distance, false), (1.4 * distance, true)]
            .into_iter()
            .chain(limits)
        {
            let is_told = limit <= closer && distance > 0.0 || limit >= farther;
            if limit >= 0.0 && is_told {
                let said = run(&query.closer_than(limit), workspace, ENOUGH);
                assert_eq!(said.value.closer, Some(is_closer), "{limit:e}: {said:?}");
            }
            if limit > 0.0 && is_told {
                let contacts = Query::contacts(a, b, pose).margin(limit);
                let found = run(&contacts, workspace, ENOUGH);
                assert_eq!(found.stop, StopReason::Finished);
                let listed: Vec<f64> = workspace.contacts().map(|one| one.distance).collect();
                assert_eq!(listed.len(), usize::from(is_closer), "{limit:e}");
                for said in listed {
                    self.assert_bounds(0.0, said);
                    assert!(said <= distance + self.bound, "{said:e}, is {distance:e}");
                    assert_eq!(said == 0.0, self.meet());
                }
            }
        }
        for shares in [[0.2, 0.3], [0.0, 1.1]] {
            let margins = shares.map(|share| share * distance + self.bound);
            let exact = query.margins(margins).absolute_tolerance(0.0);
            let said = run(&exact, workspace, ENOUGH).value;
            let left = (distance - margins[0] - margins[1]).max(0.0);
            let [p, q] = said.nearest.unwrap().points;
            assert!(p == q || !self.meet(), "{margins:?} {p} {q}");
            assert!(
                said.low <= left + self.bound,
                "{margins:?} {said:?} {left:e}"
            );
            assert!(
                left <= said.high + self.bound,
                "{margins:?} {said:?} {left:e}"
            );
            assert!(
                said.high - said.low <= 2.0 * self.bound,
                "{margins:?} {said:?}"
            );
        }
        // At rest, with a margin that is just enough.
        if round.is_multiple_of(8) && self.largest() < 1e150 && self.bound > 1e-150 {
            let motion = Motion::straight(pose, DVec3::ZERO).unwrap();
            let query = Query::impact(a, b, motion).margins([farther, 0.0]);
            assert_eq!(answer(&query).value.upper, Some(0.0), "{farther:e}");
        }
        (high - low) / self.bound
    }
}

fn check(kind: Kind, count: u64, seed: u64) {
    let mut random = Random::new(seed + kind as u64);
    let mut workspace = Workspace::new();
    let (mut meet, mut worst) = (0, 0.0_f64);
    for round in 0..count {
        let given = kind.pair(&mut random);
        let checked = catch_unwind(AssertUnwindSafe(|| given.check(&mut workspace, round)));
        let (truth, slack) = checked.unwrap_or_else(|panic| {
            eprintln!("{kind:?}, pair {round} of seed {seed}: {:?}", given.bits());
            resume_unwind(panic)
        });
        match truth.meet() {
            true => meet += 1,
            false => worst = worst.max(slack),
        }
        if (round + 1) % 100_000 == 0 {
            eprintln!("{kind:?}: {round} pairs, {meet} meet, at most {worst:.3} of the bound");
        }
    }
    println!("{kind:?}: {count} pairs, {meet} meet, at most {worst:.3} of the bound");
}

#[test]
fn pairs_of_every_kind() {
    let number = |name: &str, default: u64| {
        std::env::var(name).map_or(default, |text| text.parse().expect("a number"))
    };
    let only = std::env::var("PUNCTUAL_KIND").ok();
    let is_asked = |kind: &Kind| {
        only.as_ref()
            .is_none_or(|only| *only == format!("{kind:?}"))
    };
    for kind in Kind::ALL.into_iter().filter(is_asked) {
        check(
            kind,
            number("PUNCTUAL_PAIRS", 300),
            number("PUNCTUAL_SEED", 1),
        );
    }
}

/// Corners exactly on a line in `f32`, the middle one of which a turn brings to a corner of the other triangle.
#[test]
fn a_turned_collinear_triangle_next_to_a_corner() {
    let b = [
        DVec3::new(-0.58984375, -0.359375, 0.8623046875),
        DVec3::new(-0.593505859375, -0.81988525390625, 0.464508056640625),
        DVec3::new(-0.59765625, -1.341796875, 0.013671875),
    ];
    let a = [
        [0x3fa69ecc80e37027, 0x3fd18b95875269c5, 0x3fef517e0ac4c045],
        [0x3fd5768623d6f38d, 0xbfb16b3741b4313c, 0x3ff207b61acdb0b8],
        [0xbfe6e9834616e020, 0xbfe371c22eabc0dc, 0x3ff99d7b10f70d40],
    ];
    let a = a.map(|bits: [u64; 3]| DVec3::from(bits.map(f64::from_bits)));
    let rows = [
        0x3fcc79ca87c73d68,
        0x3fe12ab723f39880,
        0xbfea0ce28356960a,
        0x3feeeb08024f5382,
        0x3fdeab27534a908d,
        0xbfe931e7f4d20214,
        0xbfd8d349cd0c3b4d,
        0xbfb8c17c128134e0,
        0xbfeb2b62d2c3fb26,
        0xbfd3719210acbc0f,
        0xbfdba9a49db90b24,
        0x3fd3dcf94533ee08,
    ];
    let pose = Pose::from_row_major(rows.map(f64::from_bits)).unwrap();
    let given = Given::new(a, b, pose).single([false, true]);
    let distance = given.check(&mut Workspace::new(), 0).0.exact().rounded();
    assert!((1.7e-16..1.9e-16).contains(&distance), "{distance:e}");
}
/// Corners that are close to each other, of two triangles that are not thin.
#[test]
fn corners_of_fat_triangles_next_to_each_other() {
    let a = [
        DVec3::new(0.08499717404212614, -0.7366376403842906, 0.4830052568381127),
        DVec3::new(0.8197737875077429, -0.05062981734247023, 0.5395150332421873),
        DVec3::new(0.8161280541337551, 0.1994198233605871, 0.8157079352219775),
    ];
    let b = [
        DVec3::new(0.5032937468566071, 0.6352139631492795, -0.8172321480545566),
        DVec3::new(0.8197736144344467, -0.050629616311782, 0.5395148431161055),
        DVec3::new(-0.814366144298144, 0.8188817013839709, -0.24902878878852727),
    ];
    let given = Given::new(a, b, Pose::IDENTITY);
    let distance = given.check(&mut Workspace::new(), 0).0.exact().rounded();
    assert!((3.2e-7..3.3e-7).contains(&distance), "{distance:e}");
}
