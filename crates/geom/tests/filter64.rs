//! The filter of triangle pairs in `f64` against the exact test.

use glam::DVec3;
use punctual_geom::lanes::{Instructions, Lanes, Portable};
use punctual_geom::random::Random;
use punctual_geom::triangle::filter64::{Columns, Filter64};
use punctual_geom::triangles_intersect;

/// 2^300, the largest extent for which the filter claims anything.
const LARGEST_EXTENT: f64 = f64::from_bits((1023 + 300) << 52);

/// Triangles with corners on a grid. Some corners are moved by less than `f32` can resolve. So
/// the pairs share corners and planes, touch, or nearly touch.
fn pairs(random: &mut Random, size: f64) -> [[[DVec3; 3]; 8]; 2] {
    let mut number =
        || (random.bits() % 5) as f64 + [0.0, 0.0, 1e-9, -1e-13][random.bits() as usize % 4];
    core::array::from_fn(|_| {
        core::array::from_fn(|_| {
            core::array::from_fn(|_| DVec3::new(number(), number(), number()) * size)
        })
    })
}

#[test]
fn certain_answers_are_true_and_the_same_on_all_machines() {
    let mut random = Random::new(1);
    let (mut certain, mut all) = ([0; 2], 0);
    let scales = [
        1.0,
        1e-3,
        LARGEST_EXTENT / 4.0,
        LARGEST_EXTENT,
        LARGEST_EXTENT * LARGEST_EXTENT,
        f64::MIN_POSITIVE,
    ];
    for round in 0..20_000 {
        let [of_a, of_b] = pairs(&mut random, scales[round % scales.len()]);
        let (mut a, mut b) = (Columns::ZERO, Columns::ZERO);
        for lane in 0..8 {
            a.set(lane, &of_a[lane]);
            b.set(lane, &of_b[lane]);
        }
        let filter = || Filter64 {
            a: &a,
            b: &b,
            count: 8,
        };
        let verdicts = Instructions::detect().run(filter());
        assert_eq!(verdicts, Portable {}.run(filter()));
        for lane in 0..8 {
            let (hit, doubt) = (
                verdicts.hit >> lane & 1 != 0,
                verdicts.doubt >> lane & 1 != 0,
            );
            assert!(!(hit && doubt));
            if !doubt {
                assert_eq!(hit, triangles_intersect(&of_a[lane], &of_b[lane]));
                certain[usize::from(hit)] += 1;
            }
            all += 1;
        }
    }
    assert!(
        certain.iter().all(|&count| count > all / 100),
        "{certain:?} of {all}"
    );
}
