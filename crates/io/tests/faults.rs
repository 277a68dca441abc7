//! What holds no mesh: every message names the place, and nothing panics.

mod write;

use punctual::shapes::icosphere;
use punctual_io::{Format, Place, ReadOptions, load, read, read_with};

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                   endsolid a\n";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[track_caller]
fn refused(format: Format, content: &[u8]) -> String {
    match read(content, format) {
        Ok(loaded) => panic!(
            "{} triangles in {}",
            loaded.mesh.len(),
            String::from_utf8_lossy(content)
        ),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn assert_refused(format: Format, content: impl AsRef<[u8]>, expected: &str) {
    let message = refused(format, content.as_ref());
    assert!(message.contains(expected), "{expected} {message}");
    assert_eq!(message.lines().count(), 1, "{message}");
}

#[test]
fn obj_faults_name_the_line() {
    let cases: [(String, &str); 21] = [
        (
            "v 0 0 0\nv 1 0 zero\n".into(),
            "line 2: `zero` is no number",
        ),
        (
            "v 0 0 0\r\nv 1 0\r\n".into(),
            "line 2: vertex of 2 coordinates",
        ),
        (
            "v 0 0 0\rv 1 0\rv 0 1 0\rf 1 2 3\r".into(),
            "line 2: vertex of 2 coordinates",
        ),
        (
            format!("{OBJ}f 1 2 4\n"),
            "line 4: vertex index 4 is out of range: 3 vertices",
        ),
        (
            format!("f 1 2 4\n{OBJ}"),
            "line 1: vertex index 4 is out of range: 3 vertices",
        ),
        (
            format!("{OBJ}f 1 2 -4\n"),
            "line 4: vertex index -4 is out of range: 3 vertices above",
        ),
        (
            format!("f -1 -2 -3\n{OBJ}"),
            "line 1: vertex index -1 is out of range: 0 vertices above",
        ),
        (
            format!("{OBJ}f 0 1 2\n"),
            "line 4: vertex index 0 is out of range",
        ),
        (
            format!("{OBJ}f 1 2 99999999999\n"),
            "line 4: vertex index 99999999999 is out of range",
        ),
        (
            format!("{OBJ}f 1 2 4294967297\n"),
            "line 4: vertex index 4294967297 is out of range",
        ),
        (
            format!("{OBJ}f 1 2 -9223372036854775808\n"),
            "line 4: vertex index -9223372036854775808 is",
        ),
        (
            format!("{OBJ}f 1 2 99999999999999999999\n"),
            "line 4: `99999999999999999999` is no vertex index",
        ),
        (
            format!("{OBJ}f 1 2 x/1\n"),
            "line 4: `x/1` is no vertex index",
        ),
        (
            format!("{OBJ}f 1 2 /3\n"),
            "line 4: `/3` is no vertex index",
        ),
        (
            format!("{OBJ}f 1 \\\n 2\n"),
            "no triangles in it; line 4: face of fewer than 3 corners",
        ),
        (
            format!("{OBJ}#\nsurf 0 1 0 1\n"),
            "needs free-form geometry, which is not supported",
        ),
        (
            format!("{OBJ}\n\u{1b}[31m\n"),
            "no triangles in it; line 5: unknown statement `\\u{1b}[31m`",
        ),
        (
            format!("v 9 9 9\n{OBJ}v 0 nan 0\nf 2 3 4\nf 2 3 5\n"),
            "line 5: vertex 4 is not finite along axis 1",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 0 1e999\nf 1 2 3\n".into(),
            "line 3: vertex 2 is not finite along axis 2",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 1e308 0 0\nf 1 2 3\n".into(),
            "line 3: vertex 2 exceeds 2^1000 along axis 0",
        ),
        (
            format!("{OBJ}{}\n", "x".repeat(1 << 20)),
            "no triangles in it; line 4: unknown statement `xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx`",
        ),
    ];
    for (content, expected) in cases {
        assert_refused(Format::Obj, content, expected);
    }
}

#[test]
fn stl_faults_name_the_line_or_the_byte() {
    let mut binary = vec![0; 84 + 2 * 50];
    binary[80] = 2;
    binary[84 + 50 + 16..84 + 50 + 20].copy_from_slice(&f32::NAN.to_le_bytes());
    let cases: [(Vec<u8>, &str); 13] = [
        (
            STL.replace("1 0 0", "1 0 x").into(),
            "line 5: `x` is no number",
        ),
        (
            STL.replace("1 0 0", "1 0").into(),
            "line 6: `vertex` is no number",
        ),
        (
            STL.replace("1 0 0", "1 0 nan").into(),
            "line 5: vertex 1 is not finite along axis 2",
        ),
        (
            STL.replace("1 0 0", "1 0 1e39").into(),
            "line 5: vertex 1 is not finite along axis 2",
        ),
        (
            format!("{STL}\n{}", STL.replace("endloop", "endlop")).into(),
            "line 18: expected `vertex`, found `endfacet`",
        ),
        (
            format!("{STL}facet").into(),
            "line 10: expected `normal`, found the end of the file",
        ),
        (
            STL[..STL.len() - 20].into(),
            "line 7: expected `endfacet`, found the end of the file",
        ),
        (
            STL.replace("facet normal 0 0 1", "facet").into(),
            "line 3: expected `normal`, found `outer`",
        ),
        (
            binary,
            "byte 146: vertex 1 is not finite along axis 1 (counted from 0, in use by triangle 1)",
        ),
        (
            cut("binary.STL"),
            "binary STL of 20 triangles has 1084 bytes, this file has 1083",
        ),
        (Vec::new(), "with 0 bytes"),
        (b"solid\0".to_vec(), "with 6 bytes"),
        (b"v 0 0 0\n".to_vec(), "with 8 bytes"),
    ];
    for (content, expected) in cases {
        assert_refused(Format::Stl, content, expected);
    }
}

#[test]
fn ply_faults_name_the_line_or_the_byte() {
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    let full = format!("{PLY}{points}3 0 1 2\n");
    let cases: [(String, &str); 26] = [
        (
            full.replace("1 0 0\n", "1 one 0\n"),
            "line 11: `one` is no number",
        ),
        (
            full.replace("1 0 0\n", "1 0\n"),
            "line 11: fewer values than properties",
        ),
        (
            full.replace("1 0 0\n", "0x1p0 0 0\n"),
            "line 11: `0x1p0` is no number",
        ),
        (
            full.replace("1 0 0\n", "1e999 0 0\n"),
            "line 11: vertex 1 is not finite",
        ),
        (
            full.replace("3 0 1 2", "3 0 1 3"),
            "line 13: vertex index 3 is out of range: 3 vertices",
        ),
        (
            full.replace("3 0 1 2", "3 0 1 -1"),
            "line 13: vertex index -1 is out of range",
        ),
        (
            full.replace("3 0 1 2", "3 0 1 1.5"),
            "line 13: `1.5` is no whole number",
        ),
        (
            full.replace("3 0 1 2", "-3 0 1 2"),
            "line 13: a list of -3 values",
        ),
        (
            full.replace("3 0 1 2", "2 0 1"),
            "no triangles in it; line 13: face of fewer than 3 corners",
        ),
        (
            full.replace("3 0 1 2", "4 0 1 2"),
            "line 13: fewer values than properties",
        ),
        (
            full.replace("3 0 1 2\n", ""),
            "line 12: end of file before the last `face`",
        ),
        (
            full.replace("vertex 3", "vertex -3"),
            "line 3: `-3` is no number of elements",
        ),
        (
            full.replace("vertex 3", "vertex"),
            "line 3: `element vertex` is no statement",
        ),
        (
            full.replace("vertex 3", "vertex 3.0"),
            "line 3: `3.0` is no number of elements",
        ),
        (
            full.replace("face 1", "face 99999999999999"),
            "line 9: 99999999999999 elements `face` do not fit",
        ),
        (
            full.replace("face 1", "face 99999999999999999999999"),
            "line 7: `99999999999999999999999` is no number",
        ),
        (
            full.replace("double z", "double w"),
            "line 9: element `vertex` must have the properties x, y and z",
        ),
        (
            full.replace("double z", "list int double z"),
            "line 9: element `vertex` must have",
        ),
        (
            full.replace("double z", "double x"),
            "line 6: property `x` a second time",
        ),
        (
            full.replace("double z", "quad z"),
            "line 6: property `z` is of no type",
        ),
        (
            full.replace("list uchar int", "list float int"),
            "line 8: property `vertex_indices` is of no type",
        ),
        (
            full.replace("list uchar int", "list uchar float"),
            "line 9: `vertex_indices` must be a list of whole numbers",
        ),
        (
            full.replace("element face", "element strips"),
            "line 9: the file has no element `face`",
        ),
        (
            full.replace("element face", "element range_grid"),
            "line 9: needs range grids, which is not supported",
        ),
        (
            full.replace("element face", "element vertex"),
            "line 7: element `vertex` a second time",
        ),
        (
            full.replace("ply\n", ""),
            "line 1: the first line of a PLY file must be `ply`",
        ),
    ];
    for (content, expected) in cases {
        assert_refused(Format::Ply, content, expected);
    }
    assert_refused(
        Format::Ply,
        "ply\nformat ascii 1.0\n",
        "its header has no end",
    );
    assert_refused(
        Format::Ply,
        "ply\nend_header\n",
        "line 2: the header names no format",
    );
    assert_refused(
        Format::Ply,
        cut("little.ply"),
        "end of file within an element",
    );
    let mut whole = cut("big.Ply");
    whole.push(0xff);
    // The last face is of a byte and four times three of indices.
    let last = whole.len() - 13;
    whole[last + 1..].fill(0xff);
    assert_refused(
        Format::Ply,
        &whole,
        &format!("byte {last}: vertex index -1 is out of range"),
    );
    whole[last] = 0xff;
    assert_refused(
        Format::Ply,
        &whole,
        &format!("byte {last}: end of file within an element"),
    );
}

#[test]
fn off_faults_name_the_line() {
    let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let cases: [(String, &str); 14] = [
        (
            off.replace("OFF", "FOO"),
            "line 1: `FOO` is no number of vertices or faces",
        ),
        (
            off.replace("3 1 0", "3"),
            "line 2: must be the numbers of vertices and faces",
        ),
        (
            off.replace("3 1 0", "9999 1 0"),
            "line 2: 9999 vertices or faces do not fit into",
        ),
        (
            off.replace("3 1 0", "3 18446744073709551616 0"),
            "line 2: `18446744073709551616` is no number of",
        ),
        (
            off.replace("1 0 0", "1 0"),
            "line 4: vertex of 2 coordinates",
        ),
        (
            off.replace("1 0 0", "1 zero 0"),
            "line 4: `zero` is no number",
        ),
        (
            off.replace("1 0 0", "1 nan 0"),
            "line 4: vertex 1 is not finite along axis 1",
        ),
        (
            off.replace("3 0 1 2", "3 0 1"),
            "line 6: fewer indices than the face has corners",
        ),
        (
            off.replace("3 0 1 2", "3 0 1 3"),
            "line 6: vertex index 3 is out of range: 3 vertices",
        ),
        (
            off.replace("3 0 1 2", "3 0 1 -1"),
            "line 6: `-1` is no vertex index",
        ),
        (
            off.replace("3 1 0", "3 2 0"),
            "end of file before the last face",
        ),
        (
            off.replace("3 1 0", "7 1 0"),
            "end of file before the last vertex",
        ),
        (
            off.replace("OFF", "OFF BINARY"),
            "needs binary OFF, which is not supported",
        ),
        (
            off.replace("OFF", "4OFF"),
            "needs OFF of more than 3 dimensions, which is not supported",
        ),
    ];
    for (content, expected) in cases {
        assert_refused(Format::Off, content, expected);
    }
}

/// What is not supported is said first, whatever the format is.
#[test]
fn what_git_left_in_the_place_of_a_file_is_told() {
    let pointer = format!(
        "version https://git-lfs.github.com/spec/v1\noid sha256:{}\nsize 684\n",
        "0".repeat(64)
    );
    for format in [
        Format::Obj,
        Format::Stl,
        Format::Ply,
        Format::Off,
        Format::Gltf,
        Format::Collada,
    ] {
        let error = read(pointer.as_bytes(), format).unwrap_err().to_string();
        assert!(error.starts_with("a Git LFS pointer"), "{error}");
    }
    assert!(
        read(pointer.as_bytes(), None)
            .is_err_and(|error| error.to_string().starts_with("a Git LFS pointer"))
    );
}

#[test]
fn damaged_and_endless_packed_files_are_refused() {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::Write::write_all(&mut packed, &[b' '; 1 << 20]).unwrap();
    let packed = packed.finish().unwrap();
    let mut options = ReadOptions::default();
    options.limits.unpacked = 1000;
    let error = read_with(&packed, Format::Obj, &options)
        .unwrap_err()
        .to_string();
    assert!(error.contains("gzip of more than 1000 bytes"), "{error}");
    assert_refused(Format::Obj, &packed, "no triangles");
    assert_refused(Format::Obj, &packed[..packed.len() - 9], "damaged gzip");
}

/// A file of this format that lacks its last byte.
fn cut(name: &str) -> Vec<u8> {
    let formats = write::all_formats(&icosphere(0));
    let (_, mut bytes) = formats
        .into_iter()
        .find(|(format, _)| *format == name)
        .unwrap();
    bytes.pop();
    bytes
}

#[test]
fn a_file_without_a_triangle_is_refused() {
    let empty_glb = write::pack_glb(
        r#"{"asset":{"version":"2.0"},"nodes":[{}],"scenes":[{"nodes":[0]}]}"#,
        &[],
    );
    let no_face = PLY.replace("face 1", "face 0") + "0 0 0\n1 0 0\n0 1 0\n";
    let mut no_facet = vec![0; 84];
    no_facet[..5].copy_from_slice(b"solid");
    let cases: [(Format, Vec<u8>); 10] = [
        (Format::Obj, Vec::new()),
        (Format::Obj, OBJ.into()),
        (Format::Obj, format!("{OBJ}l 1 2\np 1\n").into()),
        (Format::Obj, b"# nothing\r\n\r\n".to_vec()),
        (Format::Stl, b"solid nothing\nendsolid nothing\n".to_vec()),
        (Format::Stl, no_facet),
        (Format::Ply, no_face.into()),
        (
            Format::Ply,
            PLY.replace("face 1", "face 0")
                .replace("vertex 3", "vertex 0")
                .into(),
        ),
        (Format::Gltf, empty_glb),
        (Format::Off, b"OFF\n0 0 0\n".to_vec()),
    ];
    for (format, content) in cases {
        assert_refused(format, &content, "no triangles");
    }
    assert_refused(Format::Ply, [], "PLY");
    assert_refused(Format::Gltf, [], "line 1: invalid glTF: EOF");
}

#[test]
fn errors_name_the_file_and_know_the_place() {
    let folder = std::env::temp_dir().join(format!("punctual-io-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, content: &[u8]| {
        std::fs::write(folder.join(name), content).unwrap();
        load(&folder.join(name)).unwrap_err()
    };
    let error = write("a.obj", b"v 0 0\n");
    assert!(
        error
            .to_string()
            .ends_with("a.obj:1: vertex of 2 coordinates, must be 3"),
        "{error}"
    );
    assert_eq!(
        (error.place(), error.file()),
        (Some(Place::Line(1)), folder.join("a.obj").as_path())
    );
    let mut stl = vec![0; 84 + 50];
    stl[80] = 1;
    stl[84 + 12..84 + 16].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let error = write("a.STL", &stl);
    assert!(
        error
            .to_string()
            .contains("a.STL: byte 96: vertex 0 is not finite"),
        "{error}"
    );
    assert_eq!(error.place(), Some(Place::Byte(96)));
    for (name, expected) in [
        ("a.step", ".obj, .stl, .ply, .off"),
        ("a", ".obj, .stl"),
        ("a.gz", ".obj, .stl"),
    ] {
        let error = write(name, b"");
        assert!(
            error.to_string().contains(&format!("{name}: "))
                && error.to_string().contains(expected),
            "{error}"
        );
        assert_eq!(error.place(), None);
    }
    let error = load(&folder.join("none.obj")).unwrap_err();
    assert!(error.to_string().contains("none.obj: "), "{error}");
    assert_eq!(error.kind(), Some(std::io::ErrorKind::NotFound));
    assert_eq!(write("a.obj", b"v 0 0\n").kind(), None);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn truncated_and_changed_files_never_panic() {
    let mut random = oorandom::Rand64::new(1);
    for (name, bytes) in write::all_formats(&icosphere(0)) {
        let format = Format::of(name.as_ref()).unwrap();
        let (mut read_as_before, mut refused) = (0, 0);
        for at in 0..bytes.len() {
            let _ = read(&bytes[..at], format);
            let _ = read(&bytes[..at], None);
            let mut changed = bytes.clone();
            for _ in 0..=random.rand_range(0..3) {
                changed[at] = random.rand_u64() as u8;
            }
            match read(&changed, format) {
                Ok(_) => read_as_before += 1,
                Err(_) => refused += 1,
            }
        }
        assert!(read_as_before > 0 && refused > 0, "{name}");
    }
}
