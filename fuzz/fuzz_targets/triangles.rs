//! Any two finite triangles: the exact test agrees with the oracle, in whatever order it is asked.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::geom::triangles_intersect;
use punctual::glam::DVec3;
use punctual_fuzz::{Numbers, moved, oracle};

type Triangle = [DVec3; 3];

const TURNS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [1, 0, 2],
    [0, 2, 1],
    [2, 1, 0],
];

fn point(numbers: Numbers, bytes: &mut Unstructured) -> Result<DVec3> {
    // 2^1003 is the largest coordinate allowed; what is larger, infinite or NaN becomes less than 2.
    let in_range = |value: f64| match value {
        value if value.abs() <= f64::from_bits((1023 + 1003) << 52) => value,
        value => f64::from_bits(value.to_bits() & !(0x7ff << 52) | 1023 << 52),
    };
    Ok(DVec3::from_array(numbers.point(bytes)?.map(in_range)))
}

fn triangle(numbers: Numbers, bytes: &mut Unstructured) -> Result<Triangle> {
    Ok([
        point(numbers, bytes)?,
        point(numbers, bytes)?,
        point(numbers, bytes)?,
    ])
}

/// A point of the triangle's plane by small whole weights, then moved by a few units in the last place.
fn near(triangle: &Triangle, bytes: &mut Unstructured) -> Result<DVec3> {
    let mut weight = || Ok(f64::from(bytes.int_in_range(-1..=5_i8)?));
    let [u, v, w] = [weight()?, weight()?, weight()?];
    let sum = if u + v + w == 0.0 { 1.0 } else { u + v + w };
    let mut near = u / sum * triangle[0] + v / sum * triangle[1] + w / sum * triangle[2];
    for axis in 0..3 {
        near[axis] = moved(near[axis], bytes.int_in_range(-2..=2)?);
    }
    Ok(if near.is_finite() { near } else { triangle[0] })
}

/// Multiplies each axis by a power of two, if all of them stay finite.
fn scale(pair: &mut [Triangle; 2], bytes: &mut Unstructured) -> Result<()> {
    for axis in 0..3 {
        let power = f64::from_bits(u64::from(bytes.int_in_range(1..=2026_u16)?) << 52);
        let fits =
            |corner: &DVec3| (corner[axis] * power).abs() <= f64::from_bits((1023 + 1003) << 52);
        if pair.as_flattened().iter().all(fits) {
            pair.as_flattened_mut()
                .iter_mut()
                .for_each(|corner| corner[axis] *= power);
        }
    }
    Ok(())
}

fn pair(bytes: &mut Unstructured) -> Result<[Triangle; 2]> {
    let numbers = Numbers::arbitrary(bytes)?;
    let a = triangle(numbers, bytes)?;
    let mut b = triangle(numbers, bytes)?;
    for corner in &mut b[..bytes.int_in_range(0..=3)?] {
        *corner = near(&a, bytes)?;
    }
    let mut pair = [a, b];
    if bytes.ratio(1, 4)? {
        scale(&mut pair, bytes)?;
    }
    Ok(pair)
}

fuzz_target!(|bytes: &[u8]| {
    let Ok([a, b]) = pair(&mut Unstructured::new(bytes)) else {
        return;
    };
    let expected = oracle::intersects(&a, &b);
    for turned_a in TURNS.map(|turn| turn.map(|corner| a[corner])) {
        for turned_b in TURNS.map(|turn| turn.map(|corner| b[corner])) {
            assert_eq!(
                triangles_intersect(&turned_a, &turned_b),
                expected,
                "{turned_a:?} {turned_b:?}"
            );
            assert_eq!(
                triangles_intersect(&turned_b, &turned_a),
                expected,
                "{turned_b:?} {turned_a:?}"
            );
        }
    }
});
