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

use punctual::clock::ManualClock;
use punctual::distance::Bounds;
use punctual::glam::{DMat3, DVec3};
use punctual::{Answer, Mesh, Motion, Pose, Query, StopReason, Tree, Workspace};

use crate::bracket::{Bracket, bracket};
use crate::common::random::{Drift, Random, pose_about};
use crate::distance::{ENOUGH, run};
use crate::exact_distance;

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
        match self {
            Self::FatSingle => near(single(a), single(b), [true; 2], turn(random), random),
            Self::FatDouble => near(a, b, [false; 2], turn(random), random),
            Self::Slivers => {
                let [x, y] = from_fn(|_| width(random));
                near(
                    sliver(a, x, random),
                    sliver(b, y, random),
                    [false; 2],
                    turn(random),
                    random,
                )
            }
            Self::ParallelSlivers => {
                let x = sliver(a, width(random), random);
                let way = random.vector();
                let y = x.map(|corner| corner + way + width(random) * random.vector());
                near(x, y, [false; 2], DMat3::IDENTITY, random)
            }
            Self::SliverAndFat => near(
                a,
                sliver(b, width(random), random),
                [false; 2],
                turn(random),
                random,
            ),
            Self::Needles => {
                let needle = |t: Triangle, random: &mut Random| {
                    let mut t = [t[0], t[1], t[1] + width(random) * random.vector()];
                    t.rotate_left(random.below(3));
                    t
                };
                let other = if random.below(2) == 0 {
                    b
                } else {
                    needle(b, random)
                };
                near(needle(a, random), other, [false; 2], turn(random), random)
            }
            Self::CollinearTurned => {
                let [x, y] = from_fn(|_| collinear(random));
                let (a, is_single) = if random.below(2) == 0 {
                    (a, false)
                } else {
                    (x, true)
                };
                near(a, y, [is_single, true], turn(random), random)
            }
            Self::Collinear => {
                let flat = |t: Triangle, random: &mut Random| {
                    [t[0], t[1], t[0].lerp(t[1], 1.5 * random.signed())]
                };
                let a = if random.below(2) == 0 {
                    a
                } else {
                    flat(a, random)
                };
                near(a, flat(b, random), [false; 2], turn(random), random)
            }
            Self::Points => {
                let flat = |t: Triangle, random: &mut Random| match random.below(4) {
                    0 => [t[0]; 3],
                    1 => [t[0], t[0], t[1]],
                    2 => [t[0], t[1], t[0]],
                    _ => t,
                };
                near(
                    flat(a, random),
                    flat(b, random),
                    [false; 2],
                    turn(random),
                    random,
                )
            }
            Self::CornerNear => {
                let mut b = b;
                let corner = random.below(3);
                b[corner] = point_of(&a, random) + offset(random);
                placed(a, b, DMat3::IDENTITY, random)
            }
            Self::Crossing => {
                let way = point_of(&a, random) - point_of(&b, random) + offset(random);
                placed(a, b.map(|corner| corner + way), DMat3::IDENTITY, random)
            }
            Self::Coplanar => {
                let flat = |t: Triangle| t.map(|corner| DVec3::new(corner.x, corner.y, 0.0));
                let (a, b) = (flat(a), flat(b));
                if random.below(2) == 0 {
                    near(
                        a,
                        b,
                        [false; 2],
                        DMat3::from_rotation_z(random.signed()),
                        random,
                    )
                } else {
                    let rotation = random.rotation();
                    near(
                        a.map(|v| rotation * v),
                        b.map(|v| rotation * v),
                        [false; 2],
                        DMat3::IDENTITY,
                        random,
                    )
                }
            }
            Self::Parallel => {
                let rotation = random.rotation();
                let b = [a[0], a[1], if random.below(2) == 0 { a[2] } else { b[2] }];
                let along = DVec3::new(random.signed(), random.signed(), 0.0);
                let b = b.map(|corner| DVec3::new(corner.x, corner.y, 0.0) + along);
                let a = a.map(|corner| DVec3::new(corner.x, corner.y, 0.0));
                let up = DVec3::Z * gap(random);
                placed(
                    a.map(|v| rotation * v),
                    b.map(|v| rotation * (v + up)),
                    DMat3::IDENTITY,
                    random,
                )
            }
            Self::Shared => {
                let mut b = b;
                (b[0], b[1]) = (a[1], if random.below(2) == 0 { a[0] } else { b[1] });
                let nudge = if random.below(2) == 0 {
                    DVec3::ZERO
                } else {
                    offset(random)
                };
                placed(a, b.map(|corner| corner + nudge), DMat3::IDENTITY, random)
            }
            Self::Whole => {
                let whole = |t: Triangle| t.map(|corner| (2.0 * corner).round());
                let rotation = if random.below(2) == 0 {
                    DMat3::IDENTITY
                } else {
                    random.rotation()
                };
                Given {
                    a: whole(a),
                    b: whole(b),
                    is_single: [true; 2],
                    pose: Pose::new(rotation, whole(a)[0]).unwrap(),
                }
            }
            Self::Denormal => {
                let scale = 10_f64.powf(-300.0 - 23.5 * random.unit());
                near(a, b, [false; 2], DMat3::IDENTITY, random).scaled(scale)
            }
            Self::Huge => {
                let scale = f64::exp2(990.0 * random.unit());
                let [x, y] = from_fn(|_| {
                    if random.below(2) == 0 {
                        1.0
                    } else {
                        width(random)
                    }
                });
                near(
                    sliver(a, x, random),
                    sliver(b, y, random),
                    [false; 2],
                    DMat3::IDENTITY,
                    random,
                )
                .scaled(scale)
            }
            Self::Far => {
                let far = random.vector() * 10_f64.powf(3.0 + 9.0 * random.unit());
                let [x, y] = from_fn(|_| {
                    if random.below(2) == 0 {
                        1.0
                    } else {
                        width(random)
                    }
                });
                near(
                    sliver(a, x, random),
                    sliver(b, y, random),
                    [false; 2],
                    turn(random),
                    random,
                )
                .moved(far)
            }
            Self::Unequal => {
                let factor = width(random);
                near(
                    a,
                    b.map(|corner| corner * factor),
                    [false; 2],
                    turn(random),
                    random,
                )
            }
            Self::Mixed => {
                let number = |random: &mut Random| {
                    random.signed() * f64::exp2(-40.0 * random.unit() * random.unit() * 20.0)
                };
                let [a, b] =
                    from_fn(|_| from_fn(|_| DVec3::from_array(from_fn(|_| number(random)))));
                placed(a, b, DMat3::IDENTITY, random)
            }
        }
    }
}

fn corners(random: &mut Random) -> Triangle {
    from_fn(|_| random.vector())
}

fn single(t: Triangle) -> Triangle {
    t.map(|corner| corner.as_vec3().as_dvec3())
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
fn near(
    a: Triangle,
    b: Triangle,
    is_single: [bool; 2],
    rotation: DMat3,
    random: &mut Random,
) -> Given {
    let way = match random.below(4) {
        0 => 2.0 * random.vector(),
        1 => point_of(&a, random) - rotation * point_of(&b, random) + 0.3 * random.vector(),
        _ => point_of(&a, random) - rotation * point_of(&b, random) + offset(random),
    };
    Given {
        a,
        b,
        is_single,
        pose: Pose::new(rotation, way).unwrap(),
    }
}

/// B's triangle is where it is, or turned there and back.
fn placed(a: Triangle, b: Triangle, rotation: DMat3, random: &mut Random) -> Given {
    if random.below(2) == 0 {
        return Given {
            a,
            b,
            is_single: [false; 2],
            pose: Pose::new(rotation, DVec3::ZERO).unwrap(),
        };
    }
    let pose = pose_about(DVec3::ZERO, 1.0, Drift::None, random);
    let back = pose.inverse().unwrap();
    Given {
        a,
        b: b.map(|corner| back.transform_point(corner)),
        is_single: [false; 2],
        pose,
    }
}

impl Given {
    fn scaled(self, factor: f64) -> Self {
        let pose = Pose::new(*self.pose.rotation(), self.pose.translation() * factor).unwrap();
        Self {
            a: self.a.map(|v| v * factor),
            b: self.b.map(|v| v * factor),
            pose,
            ..self
        }
    }

    fn moved(self, far: DVec3) -> Self {
        let pose = Pose::new(*self.pose.rotation(), self.pose.translation() + far).unwrap();
        Self {
            a: self.a.map(|v| v + far),
            pose,
            ..self
        }
    }

    fn bits(&self) -> [Vec<u64>; 3] {
        let of = |vectors: &[DVec3]| {
            vectors
                .iter()
                .flat_map(|v| v.to_array().map(f64::to_bits))
                .collect()
        };
        let rotation = self.pose.rotation();
        [
            of(&self.a),
            of(&self.b),
            of(&[
                rotation.x_axis,
                rotation.y_axis,
                rotation.z_axis,
                self.pose.translation(),
            ]),
        ]
    }
}

fn mesh(t: &Triangle, is_single: bool) -> Tree {
    let of_one = [[0, 1, 2]];
    let single = t.map(|corner| corner.as_vec3());
    let mesh = if is_single {
        Mesh::new(single, of_one)
    } else {
        Mesh::from_f64(*t, of_one)
    };
    Tree::new(mesh.unwrap())
}

/// All that is true of a pair.
struct Truth {
    a: Triangle,
    b: Triangle,
    /// What is known quickly.
    bracket: Option<Bracket>,
    exact: OnceCell<exact_distance::Distance>,
    /// What finished bounds differ by at most if no tolerance is asked for: see `docs/numerics.md`.
    bound: f64,
    /// How far points are off the triangles at most.
    rounding: f64,
}

impl Truth {
    fn of(a: Triangle, b: Triangle) -> Self {
        let all = || a.iter().chain(&b);
        let (low, high) = (
            all().copied().reduce(DVec3::min).unwrap(),
            all().copied().reduce(DVec3::max).unwrap(),
        );
        let largest = all().map(|v| v.abs().max_element()).fold(0.0, f64::max);
        let diagonal =
            2.0 * largest * ((high - low) / (2.0 * largest.max(f64::MIN_POSITIVE))).length();
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

    fn exact(&self) -> &exact_distance::Distance {
        self.exact
            .get_or_init(|| exact_distance::Distance::of(&self.a, &self.b))
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
        let is_told = |Bracket {
                           low: least,
                           high: most,
                           meet,
                       }| {
            if meet {
                low == 0.0
            } else {
                low <= least && most <= high
            }
        };
        if self.bracket.is_some_and(is_told) {
            return;
        }
        let exact = self.exact();
        assert!(
            exact.order_of(low) != Ordering::Greater,
            "{low:e} is not below {:e}",
            exact.rounded()
        );
        assert!(
            exact.order_of(high) != Ordering::Less,
            "{high:e} is not above {:e}",
            exact.rounded()
        );
    }

    /// The points are where they are said to be; those of triangles that meet are one.
    fn assert_points(&self, said: &Answer<Bounds>) {
        let points = said.value.nearest.unwrap().points;
        let rounding = if said.value.high == 0.0 {
            self.largest() * 1e-12 + 2.0 * f64::MIN_POSITIVE
        } else {
            self.rounding
        };
        for (point, triangle) in points.iter().zip([&self.a, &self.b]) {
            let off = exact_distance::Distance::of(&[*point; 3], triangle);
            assert_ne!(
                off.order_of(rounding),
                Ordering::Less,
                "{:e} > {rounding:e} off",
                off.rounded()
            );
        }
        if said.value.high == 0.0 {
            assert_eq!(points[0], points[1], "they are apart");
            let off = exact_distance::Distance::of(&[points[0]; 3], &self.b);
            assert_ne!(
                off.order_of(rounding),
                Ordering::Less,
                "{:e} > {rounding:e} off",
                off.rounded()
            );
        } else {
            let apart = exact_distance::Distance::of(&[points[0]; 3], &[points[1]; 3]);
            assert_ne!(
                apart.order_of_sum(&[said.value.high, 2.0 * self.rounding]),
                Ordering::Less,
                "{:e}",
                apart.rounded()
            );
        }
    }

    fn largest(&self) -> f64 {
        self.a
            .iter()
            .chain(&self.b)
            .map(|v| v.abs().max_element())
            .fold(0.0, f64::max)
    }

    fn check(&self, [a, b]: [&Tree; 2], pose: Pose, workspace: &mut Workspace, round: u64) -> f64 {
        let query = Query::distance(a, b, pose);
        let exact = run(&query.absolute_tolerance(0.0), workspace, ENOUGH);
        self.assert_bounds(exact.value.low, exact.value.high);
        assert_eq!(
            (exact.stop, exact.value.high == 0.0),
            (StopReason::Finished, self.meet()),
            "{exact:?}"
        );
        assert!(
            exact.value.high - exact.value.low <= self.bound,
            "{exact:?} {:e}",
            self.distance()
        );
        let [p, q] = exact.value.nearest.unwrap().points;
        assert!(p == q || exact.value.high > 0.0, "{p} {q}");
        if round.is_multiple_of(POINTS) {
            self.assert_points(&exact);
        }
        let said = run(&query, workspace, ENOUGH);
        self.assert_bounds(said.value.low, said.value.high);
        let tolerance = 1e-6 * a.unit_length().max(b.unit_length());
        assert!(
            said.value.high - said.value.low
                <= tolerance.max(1.01e-5 * said.value.low) + self.bound,
            "{said:?}"
        );

        let distance = self.distance();
        let [closer, farther] = [distance - 1.5 * self.bound, distance + 1.5 * self.bound];
        for (limit, answer) in [
            (closer, false),
            (farther, true),
            (0.7 * distance, false),
            (1.4 * distance, true),
        ] {
            let is_told = limit <= closer && distance > 0.0 || limit >= farther;
            if limit >= 0.0 && is_told {
                let said = run(&query.closer_than(limit), workspace, ENOUGH);
                assert_eq!(
                    said.value.closer,
                    Some(answer),
                    "{limit:e}: {said:?}, is {distance:e}"
                );
            }
            if limit > 0.0 && is_told {
                let found = Query::contacts(a, b, pose)
                    .margin(limit)
                    .run(workspace, ENOUGH.clock(&ManualClock::new()));
                let found = (
                    found.stop,
                    workspace
                        .contacts()
                        .map(|contact| contact.distance)
                        .collect::<Vec<_>>(),
                );
                assert_eq!(
                    (found.0, found.1.len()),
                    (StopReason::Finished, usize::from(answer)),
                    "{limit:e}: {found:?}"
                );
                if let [said] = found.1[..] {
                    self.assert_bounds(0.0, said);
                    assert!(
                        said <= distance + self.bound && (said == 0.0) == self.meet(),
                        "{said:e}, is {distance:e}"
                    );
                }
            }
        }
        for [share, rest] in [[0.2, 0.3], [0.0, 1.1]] {
            let margins = [share * distance + self.bound, rest * distance + self.bound];
            let said = run(
                &query.margins(margins).absolute_tolerance(0.0),
                workspace,
                ENOUGH,
            );
            let left = (distance - margins[0] - margins[1]).max(0.0);
            let [p, q] = said.value.nearest.unwrap().points;
            assert!(p == q || !self.meet(), "{margins:?} {p} {q}");
            assert!(
                said.value.low <= left + self.bound && left <= said.value.high + self.bound,
                "{margins:?} {said:?} {left:e}"
            );
            assert!(
                said.value.high - said.value.low <= 2.0 * self.bound,
                "{margins:?} {said:?} {left:e}"
            );
        }
        // At rest, with a margin that is just enough and one that is not.
        if round.is_multiple_of(8) && self.largest() < 1e150 && self.bound > 1e-150 {
            let motion = Motion::straight(pose, DVec3::ZERO).unwrap();
            let query = |margin: f64| Query::impact(a, b, motion).margins([margin, 0.0]);
            let said = query(farther).run(workspace, ENOUGH.clock(&ManualClock::new()));
            assert_eq!(said.value.upper, Some(0.0), "{farther:e}: {said:?}");
        }
        (exact.value.high - exact.value.low) / self.bound
    }
}

fn check(kind: Kind, count: u64, seed: u64) {
    let mut random = Random::new(seed + kind as u64);
    let mut workspace = Workspace::new();
    let (mut meet, mut worst) = (0, 0.0_f64);
    for round in 0..count {
        let given = kind.pair(&mut random);
        let Given {
            a,
            b,
            is_single,
            pose,
        } = given;
        let checked = catch_unwind(AssertUnwindSafe(|| {
            let truth = Truth::of(a, b.map(|corner| pose.transform_point(corner)));
            let trees = [mesh(&a, is_single[0]), mesh(&b, is_single[1])];
            let first = truth.check([&trees[0], &trees[1]], pose, &mut workspace, round);
            // The other way round without a pose, whose inverse is rounded.
            let other = [mesh(&truth.b, false), mesh(&truth.a, is_single[0])];
            let turned = Truth {
                a: truth.b,
                b: truth.a,
                ..truth
            };
            let second = turned.check(
                [&other[0], &other[1]],
                Pose::IDENTITY,
                &mut workspace,
                round,
            );
            (
                turned.meet(),
                if turned.meet() {
                    0.0
                } else {
                    first.max(second)
                },
            )
        }));
        match checked {
            Ok((is_meeting, slack)) => {
                meet += u64::from(is_meeting);
                worst = worst.max(slack);
            }
            Err(panic) => {
                eprintln!("{kind:?}, pair {round} of seed {seed}: {:?}", given.bits());
                resume_unwind(panic);
            }
        }
        if (round + 1) % 100_000 == 0 {
            eprintln!(
                "{kind:?}: {} pairs, {meet} meet, at most {worst:.3} of the bound",
                round + 1
            );
        }
    }
    println!("{kind:?}: {count} pairs, {meet} meet, at most {worst:.3} of the bound");
}

#[test]
fn pairs_of_every_kind() {
    let number = |name: &str| {
        std::env::var(name)
            .ok()
            .map(|text| text.parse::<u64>().expect("a number"))
    };
    let only = std::env::var("PUNCTUAL_KIND").ok();
    for kind in Kind::ALL {
        if only
            .as_ref()
            .is_none_or(|only| *only == format!("{kind:?}"))
        {
            check(
                kind,
                number("PUNCTUAL_PAIRS").unwrap_or(300),
                number("PUNCTUAL_SEED").unwrap_or(1),
            );
        }
    }
}

/// A pair is asked about in all ways; how far apart the triangles are.
#[track_caller]
fn check_one(a: Triangle, is_single: [bool; 2], b: Triangle, pose: Pose) -> f64 {
    let mut workspace = Workspace::new();
    let truth = Truth::of(a, b.map(|corner| pose.transform_point(corner)));
    let trees = [mesh(&a, is_single[0]), mesh(&b, is_single[1])];
    truth.check([&trees[0], &trees[1]], pose, &mut workspace, 0);
    let other = [mesh(&truth.b, false), mesh(&truth.a, is_single[0])];
    let turned = Truth {
        a: truth.b,
        b: truth.a,
        ..truth
    };
    turned.check([&other[0], &other[1]], Pose::IDENTITY, &mut workspace, 0);
    turned.exact().rounded()
}

/// Corners exactly on a line in `f32`, the middle one of which a turn brings to a corner of the other triangle.
#[test]
fn a_turned_collinear_triangle_next_to_a_corner() {
    let vector =
        |[x, y, z]: [u64; 3]| DVec3::new(f64::from_bits(x), f64::from_bits(y), f64::from_bits(z));
    let b = [
        DVec3::new(-0.58984375, -0.359375, 0.8623046875),
        DVec3::new(-0.593505859375, -0.81988525390625, 0.464508056640625),
        DVec3::new(-0.59765625, -1.341796875, 0.013671875),
    ];
    let a = [
        [
            4586527871696334887,
            4598610168858700229,
            4606990545611702341,
        ],
        [
            4599712912927814541,
            13812939417191723324,
            4607753847468568760,
        ],
        [
            13827996455913578528,
            13827020359778156764,
            4609888845481577792,
        ],
    ];
    let rows = [
        [
            4597183230406770024,
            4603007260219906176,
            13828879772800161290,
            4606877888477614978,
        ],
        [
            4602304054608695437,
            13828639003132428820,
            13824031370139941709,
            13815004595589559520,
        ],
        [
            13829194784214088486,
            13822516553489103887,
            13824830005629750052,
            4599262607641406984,
        ],
    ];
    let pose = Pose::from_row_major(
        rows.as_flattened()
            .iter()
            .map(|bits| f64::from_bits(*bits))
            .collect::<Vec<_>>()
            .try_into()
            .unwrap(),
    );
    let distance = check_one(a.map(vector), [false, true], b, pose.unwrap());
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
    let distance = check_one(a, [false; 2], b, Pose::IDENTITY);
    assert!((3.2e-7..3.3e-7).contains(&distance), "{distance:e}");
}
