//! Distances of triangles: both kernels against exact arithmetic.

use core::array::from_fn;
use core::cmp::Ordering;

use exact_distance::Distance;
use glam::{DMat3, DVec3};
use pairs::HardPair;
use punctual_geom::lanes::{Instructions, Kernel, Lanes};
use punctual_geom::random::Random;
use punctual_geom::triangle::batch::{Placement, Rows};
use punctual_geom::triangle::distance::{
    Closest, Distances, closest, closest_or_meeting, distances,
};

#[path = "../../../tests/common/exact_distance.rs"]
mod exact_distance;
#[path = "../../../tests/common/pairs.rs"]
mod pairs;

type Triangle = [DVec3; 3];

fn vector(random: &mut Random) -> DVec3 {
    DVec3::from_array(from_fn(|_| random.between(-1.0, 1.0)))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    Generic,
    /// Small whole coordinates.
    Whole,
    /// Nearly in parallel planes.
    Sheets,
    /// A corner of one triangle lies on an edge or corner of the other.
    Touching,
    /// A corner is close to a face, or another feature to another, down to 2^-60.
    Near,
    /// 1e-12 and 1e-6 wide.
    Slivers,
    NearSlivers,
    /// Segments and points.
    Degenerate,
    /// Coordinates of 1e-320 and of 2^1000.
    Tiny,
    Huge,
    /// 1e8 from the origin.
    Far,
    /// One triangle is smaller by a factor of down to 2^-60.
    Unequal,
    /// The least and the largest numbers together.
    Magnitudes,
}

impl Family {
    const ALL: [Self; 13] = [
        Self::Generic,
        Self::Whole,
        Self::Sheets,
        Self::Touching,
        Self::Near,
        Self::Slivers,
        Self::NearSlivers,
        Self::Degenerate,
        Self::Tiny,
        Self::Huge,
        Self::Far,
        Self::Unequal,
        Self::Magnitudes,
    ];

    fn pair(self, round: usize, random: &mut Random) -> [Triangle; 2] {
        let small = f64::exp2(-random.between(0.0, 60.0));
        let [a, b]: [Triangle; 2] = from_fn(|_| from_fn(|_| vector(random)));
        let offset = vector(random) * 2.0;
        let apart = b.map(|x| x + offset);
        let needle = |[start, end, third]: Triangle, width: f64| {
            [start, end, start.lerp(end, 0.3) + third * width]
        };
        match self {
            Self::Generic => [a, apart],
            Self::Whole => [a, b].map(|t| t.map(|x| (x * 3.0).round())),
            Self::Sheets => {
                let turn = DMat3::from_rotation_x(1.0) * DMat3::from_rotation_z(0.7);
                let tilt = [0.0, f64::exp2(-random.between(0.0, 60.0))][round % 2];
                let flat = |x: DVec3| DVec3::new(x.x, x.y, x.z * tilt);
                [
                    a.map(|x| turn * flat(x)),
                    b.map(|x| turn * (flat(x) + DVec3::Z * small)),
                ]
            }
            Self::Touching => {
                let weight = [1.0, 0.5, 0.25][round / 3 % 3];
                let mut b = b;
                b[round % 3] = a[0] * weight + a[1] * (1.0 - weight);
                [a, b]
            }
            Self::Near if round.is_multiple_of(2) => {
                moved_close([a, b.map(|x| x * 0.3 + a[0].cross(a[1]) * 3.0)], small)
            }
            Self::Near => moved_close([a, apart], small),
            Self::Slivers => [needle(a, 1e-12), needle(apart, 1e-12)],
            Self::NearSlivers => moved_close(
                [needle(a, 1e-6), needle(apart, [1e-10, 1.0][round % 2])],
                small,
            ),
            Self::Degenerate => {
                let flat_a = [[a[0]; 3], [a[0], a[1], a[round % 2]], a];
                let flat_b = [
                    [b[0], b[1], (b[0] + b[1]) * 0.5],
                    [b[0]; 3],
                    b,
                    [b[0], b[1], b[1]],
                ];
                [flat_a[round % 3], flat_b[round / 3 % 4]]
            }
            Self::Tiny => [a, b].map(|t| t.map(|x| x * 1e-320)),
            Self::Huge => [a, apart].map(|t| t.map(|x| x * f64::exp2(1000.0))),
            Self::Far => {
                let far = vector(random) * 1e8;
                moved_close([a, apart], small).map(|t| t.map(|x| x + far))
            }
            Self::Unequal => [a, b.map(|x| x * small + offset)],
            Self::Magnitudes => {
                let values = [
                    0.0, 5e-324, -5e-324, 1.0, -1.0, 1e-160, -1e-160, 4e301, -4e301, 2.7e300,
                ];
                from_fn(|_| {
                    from_fn(|_| {
                        DVec3::from_array(from_fn(|_| {
                            values[random.bits() as usize % values.len()]
                        }))
                    })
                })
            }
        }
    }
}

/// Moves the second triangle towards the first until their distance is about `distance`.
fn moved_close([a, b]: [Triangle; 2], distance: f64) -> [Triangle; 2] {
    let found = closest(&a, &b);
    let step = found.direction * (found.low - distance);
    [a, b.map(|x| x + step)]
}

/// Largest coordinate relative to the first corner of `a`.
fn size([a, b]: &[Triangle; 2]) -> f64 {
    a.iter()
        .chain(b)
        .map(|x| (*x - a[0]).abs().max_element())
        .fold(0.0, f64::max)
}

#[track_caller]
fn assert_bounds(found: &Closest, exact: &Distance) {
    assert_ne!(exact.order_of(found.low), Ordering::Greater, "{found:?}");
    assert_ne!(exact.order_of(found.high), Ordering::Less, "{found:?}");
}

/// Errors of both bounds, relative to the size; `None` where `low` must be 0 and `high` may have
/// any value.
fn slack(pair: &[Triangle; 2]) -> Option<[f64; 2]> {
    let (found, exact) = (
        closest_or_meeting(&pair[0], &pair[1]),
        Distance::of(&pair[0], &pair[1]),
    );
    assert_bounds(&found, &exact);
    assert!(found.is_tight || exact.is_zero(), "{found:?}");
    let distance = exact.rounded();
    (!exact.is_zero())
        .then(|| [distance - found.low, found.high - distance].map(|slack| slack / size(pair)))
}

#[test]
fn bounds_hold_and_are_tight() {
    for family in Family::ALL {
        let mut random = Random::new(1);
        for round in 0..300 {
            let [a, b] = family.pair(round, &mut random);
            for pair in [[a, b], [b, a]] {
                let Some([low, high]) = slack(&pair) else {
                    continue;
                };
                // Denormal numbers have only a few bits.
                if family != Family::Tiny {
                    assert!(low < 2e-14 && high < 5e-15, "{family:?}");
                }
            }
        }
    }
}

/// The exhaustive search needs no first result: one of its candidates is the closest for every
/// pair.
#[test]
fn every_feature_is_enough() {
    let none = Closest {
        points: [DVec3::ZERO; 2],
        direction: DVec3::ZERO,
        low: 0.0,
        high: f64::INFINITY,
        is_tight: false,
    };
    for family in Family::ALL {
        let mut random = Random::new(7);
        for round in 0..400 {
            let [a, b] = family.pair(round, &mut random);
            for (a, b) in [(a, b), (b, a)] {
                let exact = Distance::of(&a, &b);
                let found = none.of_apart(&a, &b);
                if !exact.is_zero() {
                    assert_bounds(&found, &exact);
                    assert!(found.is_tight, "{family:?} {found:?} {a:?} {b:?}");
                }
            }
        }
    }
}

/// The reported points are close to the triangles, and as far apart as reported. Each point is
/// tested as a triangle of three equal corners.
#[test]
fn points_lie_on_the_triangles() {
    for family in [
        Family::Generic,
        Family::Near,
        Family::NearSlivers,
        Family::Degenerate,
        Family::Far,
        Family::Huge,
    ] {
        let mut random = Random::new(2);
        for round in 0..200 {
            let pair = family.pair(round, &mut random);
            let found = closest(&pair[0], &pair[1]);
            let rounding = 1e-15 * (size(&pair) + pair[0][0].abs().max_element());
            for (point, triangle) in found.points.iter().zip(&pair) {
                let off = Distance::of(&[*point; 3], triangle);
                assert_ne!(off.order_of(3.0 * rounding), Ordering::Less, "{family:?}");
            }
            // Halved, because the square of the largest coordinates overflows.
            let length = 2.0
                * (found.points[0] * 0.5 - found.points[1] * 0.5)
                    .abs()
                    .max_element();
            assert!(length <= found.high + rounding, "{family:?} {found:?}");
        }
    }
}

fn corners(pair: &HardPair) -> [Triangle; 2] {
    pair.triangles.map(|triangle| triangle.map(DVec3::from))
}

/// The distances in the file come from another source, so this also tests the reference.
fn check_pairs(pairs: &[HardPair]) {
    for pair in pairs {
        let (
            HardPair {
                meet,
                family,
                margin,
                ..
            },
            [a, b],
        ) = (pair, corners(pair));
        let exact = Distance::of(&a, &b);
        assert_bounds(&closest(&a, &b), &exact);
        assert_bounds(&closest(&b, &a), &exact);
        assert_eq!(exact.is_zero(), *meet, "{family} {a:?} {b:?}");
        // Denormal distances have fewer digits.
        let distance = exact.rounded();
        let is_same = (margin - distance).abs() <= 1e-3 * distance;
        assert!(*meet || is_same || distance < 1e-300, "{family}");
    }
}

#[test]
fn hard_pairs_of_every_family() {
    let pairs = pairs::fixture();
    check_pairs(&pairs);
    assert_eq!(pairs.len(), 658);
}

#[test]
fn all_hard_pairs() {
    let Some(pairs) = pairs::all() else { return };
    check_pairs(&pairs);
    assert_eq!(pairs.len(), 48_100);
}

struct Batch<'r>([&'r Rows; 8], [&'r Rows; 8], &'r Placement);

impl Kernel for Batch<'_> {
    type Output = Distances;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Distances {
        distances(lanes, self.0, self.1, self.2)
    }
}

/// Rows with edges of the given length; `first` is at most 1.
fn rows(length: f64, random: &mut Random) -> Rows {
    let mut number = |scale: f64| (scale * random.between(-1.0, 1.0)) as f32;
    let [x, y, z] = from_fn(|_| number(1.0));
    let [e0, e1, e2, f0, f1, f2] = from_fn(|_| number(length));
    [
        [x, y, z, e0],
        [e1, e2, f0, f1],
        [f2, number(1e-8), number(1e-8), number(1e-8)],
    ]
}

const PLACEMENT: Placement = Placement {
    linear: [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]],
    translation: [0.5, -0.25, 0.125],
    rotation: [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]],
    position_error: 1e-12,
    edge_error: 3e-8,
};

#[test]
fn all_instruction_sets_give_the_same_bits() {
    let mut random = Random::new(3);
    for round in 0..2000 {
        let length = [1.0, 1e-2, 1e-5, 0.0][round % 4];
        let [a, b]: [[Rows; 8]; 2] = from_fn(|_| from_fn(|_| rows(length, &mut random)));
        let batch = || Batch(a.each_ref(), b.each_ref(), &PLACEMENT);
        let [fast, portable] =
            [Instructions::detect(), Instructions::PORTABLE].map(|set| set.run(batch()));
        assert_eq!(
            [fast.low, fast.about].map(|x| x.map(f32::to_bits)),
            [portable.low, portable.about].map(|x| x.map(f32::to_bits))
        );
        assert!(fast.about.iter().all(|about| about.is_finite()));
    }
}

/// NaN, infinities and numbers out of range prove nothing.
#[test]
fn nonsense_proves_nothing() {
    let mut random = Random::new(4);
    for round in 0..2000 {
        let [a, b]: [[Rows; 8]; 2] = from_fn(|_| from_fn(|_| rows(1.0, &mut random)));
        let mut bad = [a, b];
        let nonsense = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            -f32::MAX,
        ][round % 5];
        // Any entry but the residual, which is known to be small.
        let (lane, place) = (round / 2 % 8, round / 16 % 9);
        bad[round % 2][lane].as_flattened_mut()[place] = nonsense;
        for set in [Instructions::detect(), Instructions::PORTABLE] {
            let low = set
                .run(Batch(bad[0].each_ref(), bad[1].each_ref(), &PLACEMENT))
                .low;
            let is_far = nonsense.is_finite() && place < 3;
            // The first corners are at most 2 sqrt 3 + 1 apart.
            let at_most = if !nonsense.is_finite() {
                0.0
            } else if is_far {
                f32::MAX
            } else {
                5.0
            };
            assert!(low[lane] <= at_most, "{low:?} {bad:?}");
            let fine = set.run(Batch(a.each_ref(), b.each_ref(), &PLACEMENT)).low;
            assert!((0..8).all(|other| other == lane || low[other] == fine[other]));
        }
    }
}
