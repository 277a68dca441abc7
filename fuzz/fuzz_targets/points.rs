//! Files of points of any bytes: refused, or points with finite coordinates.

#![no_main]

use libfuzzer_sys::fuzz_target;
use punctual_io::points::{PointFormat, read_points};
use punctual_io::{Format, ReadOptions};

fuzz_target!(|data: &[u8]| {
    let Some((&format, bytes)) = data.split_first() else {
        return;
    };
    let formats = [
        PointFormat::Xyz,
        PointFormat::Pcd,
        PointFormat::Npy,
        PointFormat::Mesh(Format::Ply),
    ];
    match read_points(
        bytes,
        formats[usize::from(format % 4)],
        &ReadOptions::default(),
    ) {
        Ok(found) => {
            assert!(!found.points.is_empty());
            assert!(found.points.as_flattened().iter().all(|x| x.is_finite()));
        }
        Err(error) => assert!(error.to_string().len() < 10_000),
    }
});
