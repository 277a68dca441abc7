//! Where two triangles meet: both ends are in both triangles, and nothing that they share lies beyond.

use std::array::from_fn;

use super::common::random::Random;
use super::exact_distance::Distance;
use super::{TINY, Triangle, corners, flatten, from_values, pairs, rounded_contact};
use punctual::geom::{triangle_segment, triangles_intersect};
use punctual::glam::DVec3;

fn largest(a: &Triangle, b: &Triangle) -> f64 {
    a.iter()
        .chain(b)
        .fold(0.0, |largest, p| p.abs().max_element().max(largest))
}

fn edges(t: &Triangle) -> [Triangle; 3] {
    from_fn(|i| [t[i], t[(i + 1) % 3], t[i]])
}

/// 1e-12 of the largest coordinate, rounded up.
fn tolerance(a: &Triangle, b: &Triangle) -> f64 {
    1e-12 * largest(a, b) + 2.0 * TINY
}

#[track_caller]
fn assert_near(p: DVec3, t: &Triangle, tolerance: f64) {
    let distance = Distance::of(&[p; 3], t);
    assert!(distance.order_of(tolerance).is_ge(), "{p:?} {t:?}");
}

/// The ends are judged exactly.
#[track_caller]
fn segment(a: &Triangle, b: &Triangle) -> Option<[DVec3; 2]> {
    let segment = triangle_segment(a, b);
    assert_eq!(segment.is_some(), triangles_intersect(a, b), "{a:?} {b:?}");
    for end in segment.into_iter().flatten() {
        assert_near(end, a, tolerance(a, b));
        assert_near(end, b, tolerance(a, b));
    }
    segment
}

/// The points at which an edge of one meets the other span all that both share.
#[track_caller]
fn assert_segment(a: &Triangle, b: &Triangle) -> Option<[DVec3; 2]> {
    let whole = segment(a, b);
    let unit = largest(a, b);
    let parts = edges(a).map(|edge| triangle_segment(&edge, b)).into_iter();
    let parts = parts
        .chain(edges(b).map(|edge| triangle_segment(a, &edge)))
        .flatten();
    let span = |[p, q]: [DVec3; 2]| {
        if unit > 0.0 {
            (q / unit - p / unit).length()
        } else {
            0.0
        }
    };
    for part in parts {
        let [start, end] = whole.expect("what meets an edge meets the triangle");
        if is_flat(a, b) {
            assert!(span(part) <= span([start, end]) + 2e-12, "{a:?} {b:?}");
        } else {
            part.iter()
                .for_each(|&p| assert_near(p, &[start, end, end], 2.0 * tolerance(a, b)));
        }
    }
    whole
}

/// Whether all edges are in one plane or cross: then the triangles may share more than a segment.
fn is_flat(a: &Triangle, b: &Triangle) -> bool {
    let from = |p: DVec3| p / largest(a, b) - a[0] / largest(a, b);
    let points: Vec<DVec3> = a.iter().chain(b).map(|&p| from(p)).collect();
    let volume = |i: usize, j: usize, k: usize| points[i].cross(points[j]).dot(points[k]).abs();
    (0..6).all(|i| (0..6).all(|j| (0..6).all(|k| volume(i, j, k) < 1e-9)))
}

#[test]
fn both_ends_are_in_both_triangles_of_hard_pairs() {
    for pair in pairs::fixture() {
        let [a, b] = corners(&pair);
        for turn in 0..3 {
            let turned: Triangle = from_fn(|i| b[(i + turn) % 3]);
            assert_segment(&a, &turned);
            assert_segment(&[turned[1], turned[0], turned[2]], &a);
        }
    }
}

/// Every eighth, or all with `PUNCTUAL_ALL_CASES=1`.
#[test]
fn both_ends_are_in_both_triangles_of_all_hard_pairs() {
    let step = if std::env::var_os("PUNCTUAL_ALL_CASES").is_some_and(|value| value == "1") {
        1
    } else {
        8
    };
    for pair in pairs::all().into_iter().flatten().step_by(step) {
        let [a, b] = corners(&pair);
        assert_eq!(segment(&a, &b).is_some(), pair.meet, "{a:?} {b:?}");
    }
}

#[test]
fn segments_of_few_coordinates() {
    let mut random = Random::new(11);
    let values = [-2.0, -1.0, 0.0, 1.0, 3.0];
    for round in 0..1500 {
        let mut corners = from_fn(|_| from_values(&values, &mut random));
        flatten(round, &mut corners);
        let [a, b] = corners;
        assert_segment(&a, &b);
        // Powers of two round nothing; a chord is the longest in another unit of length too.
        for scale in [2f64.powi(1000), 2f64.powi(-1010)] {
            let scaled = [a, b].map(|t| t.map(|p| p * scale));
            let expected = triangle_segment(&a, &b).map(|ends| ends.map(|p| p * scale));
            let found = triangle_segment(&scaled[0], &scaled[1]);
            let near = |p: DVec3, q: DVec3| (p - q).abs().max_element() <= 1e-12 * scale;
            let same = expected
                .zip(found)
                .map(|([p, q], [r, s])| near(p, r) && near(q, s));
            assert_eq!(same, expected.map(|_| true), "{a:?} {b:?} {scale:e}");
        }
    }
}

#[test]
fn segments_of_all_magnitudes() {
    let values = [
        0.0,
        TINY,
        -3.0 * TINY,
        1.0,
        -1.0,
        1e-160,
        1e300,
        -2e300,
        1.0 + f64::EPSILON,
    ];
    let mut random = Random::new(12);
    for _ in 0..1500 {
        let [a, b] = from_fn(|_| from_values(&values, &mut random));
        segment(&a, &b);
    }
}

#[test]
fn segments_of_contacts_rounded_to_the_last_bit() {
    let mut random = Random::new(13);
    for round in 0..1500 {
        let [a, b] = rounded_contact(round, &mut random);
        segment(&a, &b);
    }
}

/// Long and thin, all but parallel, crossing somewhere.
#[test]
fn segments_of_needles() {
    let mut random = Random::new(14);
    let mut met = 0;
    for round in 0..1500 {
        let thin = 10f64.powi(-(round % 14));
        let [a, b]: [Triangle; 2] = from_fn(|_| {
            let along = DVec3::X + thin * random.vector();
            [-along, along, along + thin * random.vector()]
                .map(|p| p + 0.1 * thin * random.vector())
        });
        met += usize::from(segment(&a, &b).is_some());
    }
    assert!(met > 150, "{met}");
}

#[test]
fn a_copy_shares_its_longest_edge() {
    let t = [
        DVec3::ZERO,
        DVec3::new(3.0, 1.0, 2.0),
        DVec3::new(0.5, 0.25, 7.0),
    ];
    assert_eq!(triangle_segment(&t, &t), Some([t[0], t[2]]));
    let point = [t[1]; 3];
    assert_eq!(triangle_segment(&point, &point), Some([t[1]; 2]));
    assert_eq!(triangle_segment(&point, &t), Some([t[1]; 2]));
    assert_eq!(
        triangle_segment(&t, &t.map(|p| p + DVec3::splat(9.0))),
        None
    );
}
