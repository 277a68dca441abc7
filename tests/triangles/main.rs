//! Two triangles: the answer is exact for every input, whichever comes first and wherever its corners begin.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/exact_distance.rs"]
mod exact_distance;
#[path = "../common/oracle.rs"]
mod oracle;
#[path = "../common/pairs.rs"]
mod pairs;
mod segments;

use std::array::from_fn;

use common::random::Random;
use pairs::HardPair;
use punctual::geom::triangles_intersect;
use punctual::glam::DVec3;

type Triangle = [DVec3; 3];

const TINY: f64 = f64::from_bits(1);
/// 2^1001.
const HUGE: f64 = f64::from_bits((1023 + 1001) << 52);

/// The six orders of a triangle's corners.
const TURNS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [1, 0, 2],
    [0, 2, 1],
    [2, 1, 0],
];

/// Asks in all 72 ways.
#[track_caller]
fn assert_pair(a: &Triangle, b: &Triangle, expected: bool) {
    for turned_a in TURNS.map(|turn| turn.map(|corner| a[corner])) {
        for turned_b in TURNS.map(|turn| turn.map(|corner| b[corner])) {
            assert_eq!(triangles_intersect(&turned_a, &turned_b), expected);
            assert_eq!(triangles_intersect(&turned_b, &turned_a), expected);
        }
    }
}

fn corners(pair: &HardPair) -> [Triangle; 2] {
    pair.triangles.map(|triangle| triangle.map(DVec3::from))
}

#[test]
fn hard_pairs_of_every_family() {
    let mut families = Vec::new();
    for pair in pairs::fixture() {
        let [a, b] = corners(&pair);
        assert_pair(&a, &b, pair.meet);
        families.push(pair.family);
    }
    assert_eq!(families.len(), 658);
    families.dedup();
    assert_eq!(families.len(), 47);
}

/// The truth in the file comes from elsewhere, so this tests the oracle.
#[test]
fn the_oracle_knows_the_hard_pairs() {
    for pair in pairs::fixture() {
        let [a, b] = corners(&pair);
        assert_eq!(oracle::intersects(&a, &b), pair.meet, "{a:?} {b:?}");
    }
}

#[test]
fn all_hard_pairs() {
    let Some(all) = pairs::all() else { return };
    for pair in &all {
        let [a, b] = corners(pair);
        assert_pair(&a, &b, pair.meet);
    }
    assert_eq!(all.len(), 48_100);
}

/// A triangle with coordinates of few values: many points, segments, common planes, touching edges and corners.
fn from_values(values: &[f64], random: &mut Random) -> Triangle {
    from_fn(|_| DVec3::from_array(from_fn(|_| values[random.below(values.len())])))
}

const WHOLE: [f64; 7] = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0];

/// Makes a pair with whole coordinates worse: a common plane of each direction, segments.
fn flatten(round: usize, corners: &mut [Triangle; 2]) {
    for triangle in corners {
        for corner in triangle.iter_mut() {
            match round % 6 {
                0 => corner.z = corner.x - corner.y,
                1 => corner[round % 3] = corner[(round + 1) % 3],
                2 | 3 => corner[round % 3] = 1.0,
                _ => {}
            }
        }
        if round % 6 > 2 && round.is_multiple_of(2) {
            triangle[2] = triangle[round % 4 / 2];
        }
    }
}

/// Against the oracle, and again after an affine map by powers of two that rounds nothing and so changes nothing.
#[test]
fn small_whole_numbers() {
    let mut random = Random::new(1);
    let mut hits = [0, 0];
    for round in 0..9000 {
        let reach = 1 + round % 7 / 2 % 3;
        let mut corners = from_fn(|_| from_values(&WHOLE[3 - reach..=3 + reach], &mut random));
        flatten(round, &mut corners);
        let [a, b] = corners;
        let expected = oracle::intersects(&a, &b);
        hits[usize::from(expected)] += 1;
        assert_pair(&a, &b, expected);
        for scale in [
            [TINY; 3],
            [HUGE; 3],
            [HUGE, TINY, 1.0],
            [1.0 / HUGE, 1.0, TINY],
        ] {
            let [a, b] =
                [a, b].map(|triangle| triangle.map(|corner| corner * DVec3::from_array(scale)));
            assert_eq!(triangles_intersect(&a, &b), expected, "{a:?} {b:?}");
        }
    }
    assert!(hits.iter().all(|&count| count > 1000), "{hits:?}");
}

/// One triangle may hold the largest coordinate, another the least.
#[test]
fn all_magnitudes_at_once() {
    let least = [0.0, TINY, -TINY, 3.0 * TINY, 1.0, -1.0, 1.0 + f64::EPSILON];
    let largest = [
        0.0,
        -TINY,
        1.0,
        -1.0,
        1e-160,
        -1e-160,
        4.0 * HUGE,
        -4.0 * HUGE,
        2.7 * HUGE,
    ];
    let mut random = Random::new(2);
    let mut hits = [0, 0];
    for round in 0..3000 {
        let values = if round % 2 == 0 {
            &least[..]
        } else {
            &largest[..]
        };
        let [a, b] = from_fn(|_| from_values(values, &mut random));
        let expected = oracle::intersects(&a, &b);
        hits[usize::from(expected)] += 1;
        assert_pair(&a, &b, expected);
    }
    assert!(hits.iter().all(|&count| count > 300), "{hits:?}");
}

/// A corner, edge or all of one triangle is put on the other and rounded: the last bits decide.
fn rounded_contact(round: usize, random: &mut Random) -> [Triangle; 2] {
    let offset = [0.0, 1.0, 30.0, 1e6][round % 4] * random.vector();
    let [a, mut b]: [Triangle; 2] = from_fn(|_| from_fn(|_| offset + random.vector()));
    let is_flat = round.is_multiple_of(5);
    for corner in b.iter_mut().take(1 + round % 3) {
        let [u, v, w] = from_fn(|_| 1.2 + random.signed());
        // In a common plane, edges must meet for the last bits to matter.
        let w = if is_flat { 0.0 } else { w };
        *corner = (u * a[0] + v * a[1] + w * a[2]) / (u + v + w);
    }
    let axis = round / 5 % 3;
    let flat = |corner: DVec3| {
        if is_flat {
            DVec3::from_array(from_fn(|i| if i == axis { 1.0 } else { corner[i] }))
        } else {
            corner
        }
    };
    [a, b].map(|triangle| triangle.map(flat))
}

/// Against the oracle, and again where products of coordinates overflow or underflow.
#[test]
fn contacts_rounded_to_the_last_bit() {
    let mut random = Random::new(3);
    let mut hits = [0, 0];
    for round in 0..6000 {
        let [a, b] = rounded_contact(round, &mut random);
        let expected = oracle::intersects(&a, &b);
        hits[usize::from(expected)] += 1;
        assert_pair(&a, &b, expected);
        for exponent in (300..550).step_by(7) {
            let power = f64::from_bits((1023 + exponent) << 52);
            for scale in [power, 1.0 / power] {
                let [a, b] = [a, b].map(|triangle| triangle.map(|corner| corner * scale));
                assert_eq!(triangles_intersect(&a, &b), expected, "{a:?} {b:?}");
            }
        }
    }
    assert!(hits.iter().all(|&count| count > 600), "{hits:?}");
}

fn triangle(points: [[f64; 3]; 3]) -> Triangle {
    points.map(DVec3::from_array)
}

#[test]
fn one_denormal_decides() {
    let floor = triangle([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]);
    for (height, expected) in [(TINY, false), (0.0, true), (-TINY, true)] {
        let needle = triangle([[0.0, 0.0, height], [0.5, 0.0, 1.0], [0.0, 0.5, 1.0]]);
        assert_eq!(triangles_intersect(&floor, &needle), expected, "{height:e}");
        assert_eq!(triangles_intersect(&needle, &floor), expected, "{height:e}");
    }
    for (x, expected) in [(1.0, true), (1.0 + f64::EPSILON, false)] {
        let beside = triangle([[x, -1.0, -0.5], [x, -1.0, 0.5], [2.0, -2.0, 0.0]]);
        assert_eq!(triangles_intersect(&floor, &beside), expected, "{x:e}");
    }
}

#[test]
fn segments_and_points() {
    let segment = |p: [f64; 3], q: [f64; 3]| triangle([p, q, from_fn(|i| 0.5 * (p[i] + q[i]))]);
    let point = |p: [f64; 3]| triangle([p; 3]);
    let x = segment([-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]);
    assert!(triangles_intersect(
        &x,
        &segment([0.0, -2.0, 0.0], [0.0, 2.0, 0.0])
    ));
    assert!(triangles_intersect(
        &x,
        &segment([2.0, 0.0, 0.0], [3.0, 0.0, 0.0])
    ));
    assert!(!triangles_intersect(
        &x,
        &segment([2.5, 0.0, 0.0], [3.0, 0.0, 0.0])
    ));
    assert!(triangles_intersect(&x, &point([1.5, 0.0, 0.0])));
    assert!(!triangles_intersect(&x, &point([1.5, TINY, 0.0])));
    let skew = segment([-2.0, 0.0, -TINY], [2.0, 0.0, TINY]);
    assert!(!triangles_intersect(
        &skew,
        &segment([0.0, -2.0, TINY], [0.0, 2.0, TINY])
    ));
    let diagonal = segment([-1.0; 3], [1.0; 3]);
    assert!(triangles_intersect(&diagonal, &point([0.1; 3])));
    assert!(!triangles_intersect(&diagonal, &point([0.1, 0.1, 0.2])));
    let roof = triangle([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!(triangles_intersect(&roof, &diagonal));
    assert!(triangles_intersect(&roof, &point([0.25, 0.25, 0.5])));
    assert!(!triangles_intersect(
        &roof,
        &point([0.25, 0.25, 0.5 + f64::EPSILON])
    ));
}
