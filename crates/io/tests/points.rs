//! Points are read as they were written, in every format; a fault is named with its place.

use punctual_io::points::{PointFormat, load_points, read_points};
use punctual_io::{Format, ReadOptions, load_with};

const POINTS: [[f64; 3]; 3] = [[0.5, -1.25, 3.0], [1e-3, 2.0, -7.5], [100.0, 0.0, 0.25]];

fn read(bytes: &[u8], format: PointFormat) -> Result<Vec<[f64; 3]>, String> {
    let read = read_points(bytes, format, &ReadOptions::default());
    read.map(|found| found.points)
        .map_err(|error| error.to_string())
}

fn npy(kind: &str, shape: &str, numbers: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(numbers);
    bytes
}

fn pcd(data: &str, body: &[u8]) -> Vec<u8> {
    let header = "# .PCD v0.7\nVERSION 0.7\nFIELDS rgb x y z\nSIZE 4 8 8 8\nTYPE U F F F\nCOUNT 1 1 1 1\n\
                  WIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\n";
    [header.as_bytes(), format!("DATA {data}\n").as_bytes(), body].concat()
}

fn records() -> Vec<u8> {
    let record = |p: &[f64; 3]| [vec![9; 4], p.map(f64::to_le_bytes).concat()].concat();
    POINTS.iter().flat_map(record).collect()
}

/// The fields one after the other, as literal runs of LZF and one copy.
fn compressed() -> Vec<u8> {
    let axis = |k: usize| POINTS.iter().flat_map(move |p| p[k].to_le_bytes());
    let bytes: Vec<u8> = (0..3).flat_map(axis).collect();
    let mut packed = vec![0, 9, 7 << 5, 2, 0]; // One byte, then eleven of it again.
    for run in bytes.chunks(32) {
        packed.push(run.len() as u8 - 1);
        packed.extend(run);
    }
    let sizes = [packed.len() as u32, 12 + bytes.len() as u32];
    [sizes.map(u32::to_le_bytes).concat(), packed].concat()
}

#[test]
fn points_are_read_as_they_were_written() {
    let text = POINTS.map(|[x, y, z]| format!("{x} {y} {z}\n")).concat();
    let listed = POINTS
        .map(|[x, y, z]| format!("255 {x} {y} {z}\n"))
        .concat();
    let little = POINTS
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect::<Vec<_>>();
    let big = POINTS
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_be_bytes())
        .collect::<Vec<_>>();
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
                       property double z\nend_header\n{text}"
    );
    let obj = POINTS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let cases = [
        ("xyz", PointFormat::Xyz, text.clone().into_bytes()),
        (
            "csv",
            PointFormat::Xyz,
            format!("x;y;z\n{}", text.replace(' ', ";")).into_bytes(),
        ),
        (
            "pts",
            PointFormat::Xyz,
            format!("3\n{}", text.replace('\n', " 17 255\n")).into_bytes(),
        ),
        (
            "comments",
            PointFormat::Xyz,
            format!("# x\n// y\n\n{}", text.replace('\n', " # z\r\n")).into_bytes(),
        ),
        ("npy", PointFormat::Npy, npy("<f8", "(3, 3)", &little)),
        (
            "npy of a grid",
            PointFormat::Npy,
            npy(">f8", "(1, 3, 3)", &big),
        ),
        ("pcd", PointFormat::Pcd, pcd("ascii", listed.as_bytes())),
        ("pcd binary", PointFormat::Pcd, pcd("binary", &records())),
        (
            "pcd compressed",
            PointFormat::Pcd,
            pcd("binary_compressed", &compressed()),
        ),
        ("ply", PointFormat::Mesh(Format::Ply), ply.into_bytes()),
        ("obj", PointFormat::Mesh(Format::Obj), obj.into_bytes()),
    ];
    for (name, format, bytes) in cases {
        assert_eq!(read(&bytes, format), Ok(POINTS.to_vec()), "{name}");
        // Whatever is cut off, it ends.
        for end in 0..bytes.len() {
            let _ = read(&bytes[..end], format);
        }
    }
    let single: Vec<u8> = [0.5_f32, 1.0, 2.0, 9.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let bytes = npy("<f4", "(1, 4)", &single);
    assert_eq!(read(&bytes, PointFormat::Npy), Ok(vec![[0.5, 1.0, 2.0]]));
}

#[test]
fn points_that_are_not_finite_are_passed_over_and_counted() {
    let bytes = b"nan nan nan\n1 2 3\n4 inf 6\n";
    let found = read_points(bytes, PointFormat::Xyz, &ReadOptions::default().scale(2.0)).unwrap();
    assert_eq!(found.points, [[2.0, 4.0, 6.0]]);
    assert_eq!(
        found.notices[0].to_string(),
        "2 points without finite coordinates passed over"
    );
}

#[test]
fn a_scale_that_flattens_is_refused_and_one_too_large_loses_points() {
    let read = |scale: [f64; 3], bytes: &[u8]| {
        let options = ReadOptions::default().scale_axes(scale);
        read_points(bytes, PointFormat::Xyz, &options)
    };
    for wrong in [0.0, f64::NAN, f64::INFINITY] {
        let error = read([1.0, wrong, 1.0], b"1 2 3\n").unwrap_err().to_string();
        let said = format!("scaled: factor {wrong} along axis 1, must be finite and not 0");
        assert_eq!(error, said);
    }
    let found = read([1e300; 3], b"1 2 3\n1e10 0 0\n").unwrap();
    assert_eq!((found.points.len(), found.notices.len()), (1, 1));
}

#[test]
fn faults_of_points_are_named_with_their_place() {
    let faults = [
        (
            PointFormat::Xyz,
            b"".to_vec(),
            "no points in it, 0 without finite coordinates",
        ),
        (
            PointFormat::Xyz,
            b"1 2 3\n1 2\n".to_vec(),
            "line 2: point of 2 coordinates, must be 3",
        ),
        (
            PointFormat::Xyz,
            b"1 2 3\n1 2 x\n".to_vec(),
            "line 2: `x` is no number",
        ),
        (
            PointFormat::Npy,
            b"PK".to_vec(),
            "no NumPy file: it does not begin with \\x93NUMPY",
        ),
        (
            PointFormat::Npy,
            npy("<i4", "(1, 3)", &[0; 12]),
            "byte 10: numbers of kind `<i4`, must be float32 or float64",
        ),
        (
            PointFormat::Npy,
            npy("<f4", "(2, 2)", &[0; 16]),
            "byte 10: shape (2, 2), must be (n, 3), or have more columns or axes",
        ),
        (
            PointFormat::Npy,
            npy("<f4", "(2, 3)", &[0; 16]),
            "byte 70: 16 bytes of numbers, shape (2, 3) of <f4 has others",
        ),
        (
            PointFormat::Npy,
            npy("<f8", "(0, 2305843009213693952)", &[]),
            "no points in it, 0 without finite coordinates",
        ),
        (
            PointFormat::Pcd,
            pcd("binary", &[0; 9]),
            "end of file before the last of 3 points",
        ),
        (
            PointFormat::Pcd,
            pcd("ascii", b"1 2 3 4\n"),
            "line 12: end of file after 1 of 3 points",
        ),
        (
            PointFormat::Pcd,
            pcd("ascii", b"1 2 3 4\n1 2 3\n"),
            "line 13: point of 3 numbers, must be 4",
        ),
        (
            PointFormat::Pcd,
            pcd("zip", b""),
            "needs DATA zip, which is not supported",
        ),
        (
            PointFormat::Pcd,
            b"FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 1\nDATA ascii\n".to_vec(),
            "line 5: no fields x, y and z",
        ),
        (
            PointFormat::Pcd,
            b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS -1\n".to_vec(),
            "line 4: POINTS `-1` is no count",
        ),
    ];
    for (format, bytes, expected) in faults {
        let error = read(&bytes, format).unwrap_err();
        assert!(error.ends_with(expected), "{error}");
    }
    let error = load_points("cloud.zip".as_ref(), &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with("cloud.zip: no format of points by its extension; use one of .xyz"),
        "{error}"
    );
}

#[test]
fn a_file_of_points_is_loaded_as_a_cloud() {
    let file = std::env::temp_dir().join(format!("punctual-{}.xyz", std::process::id()));
    std::fs::write(&file, "1 2 3\n4 5 6\n").unwrap();
    let cloud = load_with(&file, &ReadOptions::default().scale(0.5))
        .unwrap()
        .mesh;
    std::fs::remove_file(&file).unwrap();
    assert!(cloud.is_cloud() && cloud.len() == 2);
    assert_eq!(cloud.vertex(1).to_array(), [2.0, 2.5, 3.0]);
}
