//! What the readers make of files that hold a mesh, however odd.

mod write;

use std::time::{Duration, Instant};

use punctual::glam::{DVec3, Vec3};
use punctual::shapes::{cuboid, icosphere};
use punctual::{Budget, Mesh, Pose, Query, Tree, Verdict, Workspace};
use punctual_io::{Axis, Format, ReadOptions, load, read, read_with};

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                   endsolid a\n";
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[track_caller]
fn accepted(format: Format, content: impl AsRef<[u8]>) -> Mesh {
    let content = content.as_ref();
    let loaded = read(content, format)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(content)));
    assert_eq!(loaded.notices, [], "{}", String::from_utf8_lossy(content));
    loaded.mesh
}

fn corners(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    (0..mesh.len()).map(|i| mesh.triangle(i)).collect()
}

#[test]
fn all_formats_give_the_same_triangles() {
    for mesh in [icosphere(2), cuboid(Vec3::splat(0.75), 2)] {
        for (name, bytes) in write::all_formats(&mesh) {
            let format = Format::of(name.as_ref()).unwrap();
            assert_eq!(corners(&accepted(format, &bytes)), corners(&mesh), "{name}");
            assert_eq!(corners(&read(&bytes, None).unwrap().mesh), corners(&mesh));
        }
    }
}

#[test]
fn odd_but_valid_files_are_read() {
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    let cases: [(Format, String, usize); 45] = [
        (Format::Obj, "v nan 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4".into(), 1),
        (Format::Obj, format!("f 1 2 3\n{SQUARE}"), 1),
        (Format::Obj, format!("{SQUARE}f 1 2 3 4\n"), 2),
        (Format::Obj, format!("{SQUARE}f -4/1/1 -3//2 -2/3 -1\n"), 2),
        (Format::Obj, format!("{SQUARE}f\t1/\t2/1/ 3//\n"), 1),
        (Format::Obj, format!("\u{feff}mtllib C:\\\n# a \\\n{}f 1 \\\r\n 2 3\r\n", SQUARE.replace('\n', "\r\n")), 1),
        (Format::Obj, format!("o x\nvn 0 0 1\nvt 0 0\ns off\n{SQUARE}v 0 0 1 1 0.5 0.5 0.5\ng\nf 1 2 5\n"), 1),
        (Format::Obj, "v +1. -.5 .25\nv 1E0 1e-400 0 0.1 0.2 0.3\nv 0 1 0 1\nf 1 2 3\nf 1 1 2\n".into(), 2),
        (Format::Obj, format!("{SQUARE}f 1 2 3{}\n", " 4".repeat(100_000)), 100_001),
        (Format::Stl, STL.to_uppercase().replace('\n', "\r\n"), 1),
        (Format::Stl, STL.replace('\n', " "), 1),
        (Format::Stl, format!("{} {}", STL, STL).replace('\n', "\t"), 2),
        (Format::Stl, format!("\n {STL}\n\n{STL}"), 2),
        (Format::Stl, STL.replace("solid a", "solid a facet of my solid"), 1),
        (Format::Stl, STL.replace("0 0 1", "-nan(ind) nan 1e99").replace("solid a", "solid"), 1),
        (Format::Ply, format!("{PLY}{points}3 0 1 2\n\n"), 1),
        (Format::Ply, format!("{PLY}\n{}  3  0 1 2", points.replace(' ', "\t")), 1),
        (Format::Ply, PLY.replace("indices", "index").replace('\n', "\r\n") + points + "4 0 1 2 1\n", 2),
        (Format::Ply, format!("{PLY}{}3 0 1 2\n", "1. -.5 .25\n+1e0 1E+1 -0\n1e-999 .5e1 -1.\n"), 1),
        // Faces before vertices, and elements and lists that nobody needs.
        (
            Format::Ply,
            "ply\nformat ascii 1.0\nobj_info x\nelement face 1\nproperty list int uint vertex_index\nproperty list \
             uchar float uv\nelement edge 1\nproperty int a\nproperty list char char b\nelement none 2\nelement vertex 3\n\
             property char x\nproperty uchar red\nproperty float32 y\nproperty int16 z\nend_header\n3 2 0 1 2 .5 .5\n7 0\n\
             -1 255 .5 0\n1 0 0 0\n0 0 1 0\n"
                .replace("element none 2\n", ""),
            1,
        ),
        (Format::Ply, format!("{PLY}{points}3 0 1 2\n").replace("comment", "obj_info"), 1),
        // Byte order marks, and the line ends of old computers.
        (Format::Obj, format!("\u{feff}{SQUARE}f 1 2 3 4\n").replace('\n', "\r"), 2),
        (Format::Stl, format!("\u{feff}{STL}").replace('\n', "\r"), 1),
        (Format::Ply, format!("\u{feff}{PLY}{points}3 0 1 2\n"), 1),
        (Format::Ply, format!("{PLY}{points}3 0 1 2\n").replace('\n', "\r"), 1),
        (Format::Off, format!("\u{feff}OFF\n3 1\n{points}3 0 1 2\n").replace('\n', "\r"), 1),
        // A name that looks like a facet, and a normal without numbers.
        (Format::Stl, STL.replace("solid a", "solid facet normal bracket"), 1),
        (Format::Stl, STL.replace("normal 0 0 1", "normal"), 1),
        // Indices of textures and normals are not looked at.
        (Format::Obj, format!("{SQUARE}f 1/x 2/1/1/1 3//\n"), 1),
        // Keywords of OFF say what follows the coordinates, and may be missing or stuck to the counts.
        (Format::Off, format!("# a square\nCNOFF 4 1 0\n{}4 0 1 3 2 255 0 0\n", points.replace('\n', " 1 2 3\n") + "1 1 0\n"), 2),
        (Format::Off, format!("OFF3 1 0\n{points}3 0 1 2 # red\n"), 1),
        (Format::Off, format!("3 1 0\n\n{points}\n3 0 1 2"), 1),
        // To OFF, line ends are blanks: faces, vertices and counts over several lines, or several on one.
        (Format::Off, format!("OFF\n3 2 0\n{points}3 0 1\n2\n3\n2 1 # the second\n\n0\n"), 2),
        (Format::Off, format!("OFF\r\n3 2 0\r\n{points}3 0 1\r\n2 255 0 0\r\n3 2 1 0 0 255 0\r\n"), 2),
        (Format::Off, format!("OFF\n3 1\n0\n{}3 0 1 2\n", points.replace(' ', "\n")), 1),
        (Format::Off, format!("OFF\n3\n1\n0\n{points}3 0 1 2\n"), 1),
        (Format::Off, format!("OFF 3 1 0 {points}3 0 1 2\n").replace('\n', " "), 1),
        (Format::Off, format!("OFF\n3 2 0\n{}\n3 0 1 2 3 2 1 0\n", points.replace('\n', " ")), 2),
        (Format::Off, format!("NOFF\n3 1 0\n{}\n3 0 1 2\n", points.replace('\n', " 0 0 1 ")), 1),
        (Format::Off, format!("COFF\n3 1 0\n{}\n3 0 1 2\n", points.replace('\n', " 1 0 0 1 ")), 1),
        (Format::Off, format!("COFF\n3 1 0\n{}\n3 0 1 2\n", points.replace('\n', " 255 0 0 ")), 1),
        (Format::Off, format!("STCNOFF\n3 1 0\n{}\n3 0 1 2\n", points.replace('\n', " 0 0 1 1 0 0 1 .5 .5 ")), 1),
        (Format::Off, format!("COFF\n3 2 0\n{}3 0\n1 2\n3 2 1 0\n", points.replace('\n', " 255 0 0 255\n")), 2),
        (Format::Off, format!("off\n# counts\n 3 1 0 # no edges\n{points}3 0 1 2\n"), 1),
        (Format::Ply, format!("{PLY}{points}3 0 1 2\n").replace("format", "comment \u{e9}\ncomment\nformat"), 1),
    ];
    for (format, content, count) in cases {
        assert_eq!(accepted(format, &content).len(), count, "{content}");
    }
    let not_utf8 = [b"# \xff\xfe\ng \xe9\n", SQUARE.as_bytes(), b"f 1 2 3\n"].concat();
    assert_eq!(accepted(Format::Obj, not_utf8).len(), 1);
    let not_utf8 = [b"solid \xff\xfe\n", &STL.as_bytes()[8..]].concat();
    assert_eq!(accepted(Format::Stl, not_utf8).len(), 1);
}

/// Windows programs write text in UTF-16.
#[test]
fn text_may_be_utf_16() {
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    let files = [
        (Format::Obj, format!("{SQUARE}f 1 2 3\n")),
        (Format::Stl, STL.to_owned()),
        (Format::Ply, format!("{PLY}{points}3 0 1 2\n")),
        (Format::Off, format!("OFF\n3 1 0\n{points}3 0 1 2\n")),
    ];
    for (format, text) in files {
        let wide = |bytes: fn(u16) -> [u8; 2]| {
            format!("\u{feff}{text}")
                .encode_utf16()
                .flat_map(bytes)
                .collect::<Vec<u8>>()
        };
        for bytes in [wide(u16::to_le_bytes), wide(u16::to_be_bytes)] {
            assert_eq!(accepted(format, &bytes).len(), 1, "{text}");
            assert_eq!(read(&bytes, None).unwrap().mesh.len(), 1, "{text}");
        }
    }
}

#[test]
fn packed_files_are_unpacked() {
    let folder = std::env::temp_dir().join(format!("punctual-io-{}-packed", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mesh = icosphere(1);
    for (name, bytes) in write::all_formats(&mesh) {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut packed, &bytes).unwrap();
        let packed = packed.finish().unwrap();
        let file = folder.join(format!("{name}.GZ"));
        std::fs::write(&file, &packed).unwrap();
        assert_eq!(corners(&load(&file).unwrap().mesh), corners(&mesh));
        assert_eq!(corners(&read(&packed, None).unwrap().mesh), corners(&mesh));
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Old computers end lines by a carriage return, after which a binary body may begin with a line feed.
#[test]
fn binary_bodies_begin_after_the_line_end_of_the_header() {
    let mesh = icosphere(1);
    for (_, bytes) in write::all_formats(&mesh)
        .into_iter()
        .filter(|(name, _)| ["little.ply", "big.Ply"].contains(name))
    {
        let end = bytes
            .windows(11)
            .position(|window| window == b"end_header\n")
            .unwrap()
            + 11;
        for line_end in ["\r", "\r\n"] {
            let header = String::from_utf8(bytes[..end].to_vec())
                .unwrap()
                .replace('\n', line_end);
            // The colour, which is first, is a line feed.
            let mut body = bytes[end..].to_vec();
            body[0] = b'\n';
            let bytes = [header.as_bytes(), &body].concat();
            assert_eq!(corners(&accepted(Format::Ply, bytes)), corners(&mesh));
        }
    }
}

#[test]
fn meshes_are_scaled_and_turned() {
    let obj = format!("{SQUARE}v 1 2 3\nf 1 2 5\n");
    let corner = |options: &ReadOptions| {
        read_with(obj.as_bytes(), None, options)
            .unwrap()
            .mesh
            .triangle(0)[2]
    };
    let with = |up: Axis, scale: f64| ReadOptions::default().up(up).scale(scale);
    assert_eq!(corner(&ReadOptions::default()), DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(corner(&with(Axis::Z, 0.1)), DVec3::new(0.1, 0.2, 0.1 * 3.0));
    assert_eq!(corner(&with(Axis::Y, 1.0)), DVec3::new(1.0, -3.0, 2.0));
    assert_eq!(corner(&with(Axis::X, 2.0)), DVec3::new(-6.0, 4.0, 2.0));
    // Turned, not mirrored.
    for up in [Axis::X, Axis::Y, Axis::Z] {
        let [x, y, z] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|[x, y, z]| {
            let obj = format!("v {x} {y} {z}\nv 0 0 0\nf 1 2 2\n");
            read_with(obj.as_bytes(), None, &with(up, 1.0))
                .unwrap()
                .mesh
                .triangle(0)[0]
        });
        assert_eq!(x.cross(y), z, "{up:?}");
    }
    // Mirrored: the normal is mirrored as a surface is, and looks outwards as before.
    let cube = read_with(obj.as_bytes(), None, &ReadOptions::default())
        .unwrap()
        .mesh;
    for factors in [[-2.0, 1.0, 0.5], [-1.0; 3], [3.0, -1.0, -1.0]] {
        let options = ReadOptions::default().scale_axes(factors);
        let mesh = read_with(obj.as_bytes(), None, &options).unwrap().mesh;
        assert_eq!(mesh, cube.scaled_by(factors).unwrap());
    }
    for scale in [0.0, f64::NAN, f64::INFINITY] {
        let error = read_with(obj.as_bytes(), None, &with(Axis::Z, scale))
            .unwrap_err()
            .to_string();
        assert!(error.contains("must be finite and not 0"), "{error}");
    }
}

#[test]
fn numbers_mean_what_they_mean_in_c() {
    let of = |numbers: &str| {
        accepted(
            Format::Ply,
            format!("{PLY}{numbers}\n0 0 0\n1 1 1\n3 0 1 2\n"),
        )
        .triangle(0)[0]
    };
    for (numbers, expected) in [
        (".25 1. -.5", [0.25, 1.0, -0.5]),
        ("+.5e1 1.e-1 -0", [5.0, 0.1, 0.0]),
        ("1E2 00.5 4.9e-324", [100.0, 0.5, 5e-324]),
        (
            "0.1000000000000000055 123456789012345678 1e-999",
            [0.1, 123_456_789_012_345_680.0, 0.0],
        ),
    ] {
        assert_eq!(of(numbers).to_array(), expected, "{numbers}");
    }
}

/// f32 would make one plane of the two.
#[test]
fn coordinates_reach_the_last_bit() {
    for z in ["0.1", "0.1000000000000000055", "0.10000000000000002"] {
        let obj = accepted(
            Format::Obj,
            format!("v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf 1 2 3\n"),
        );
        let ply = accepted(
            Format::Ply,
            format!("{PLY}0 0 {z}\n1 0 {z}\n0 1 {z}\n3 0 1 2\n"),
        );
        assert_eq!(corners(&obj), corners(&ply));
        assert_eq!(obj.triangle(0)[0].z, z.parse::<f64>().unwrap());
    }
}

fn meets(a: &Mesh, b: &Mesh) -> bool {
    let (a, b) = (Tree::new(a.clone()), Tree::new(b.clone()));
    let outcome =
        Query::intersection(&a, &b, Pose::IDENTITY).run(&mut Workspace::new(), Budget::unlimited());
    matches!(outcome.value, Verdict::Intersecting { .. })
}

/// An L, of which a fan around the first corner would fill the inner corner too.
#[test]
fn a_concave_polygon_has_no_contact_in_empty_space() {
    let points = [[2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [0, 0]];
    let obj: String = points.map(|[x, y]| format!("v {x} {y} 0\n")).concat() + "f 1 2 3 4 5 6\n";
    let ply =
        PLY.replace("vertex 3", "vertex 6") + &points.map(|[x, y]| format!("{x} {y} 0\n")).concat();
    let shapes = [
        accepted(Format::Obj, &obj),
        accepted(Format::Ply, ply + "6 0 1 2 3 4 5\n"),
    ];
    let needle = |x: f64, y: f64| {
        Mesh::from_f64([[x, y, -1.0], [x, y, 1.0], [x + 0.01, y, 1.0]], [[0, 1, 2]]).unwrap()
    };
    for shape in shapes {
        assert_eq!(shape.len(), 4);
        for (x, y, expected) in [
            (0.5, 0.5, true),
            (1.7, 0.7, true),
            (0.7, 1.7, true),
            (1.2, 1.2, false),
            (1.4, 1.1, false),
        ] {
            assert_eq!(meets(&shape, &needle(x, y)), expected, "{x} {y}");
        }
    }
}

/// The square of the length of a line would be minutes.
#[test]
fn long_lines_take_no_longer_than_many() {
    let facet =
        "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet ";
    let start = Instant::now();
    let mesh = accepted(
        Format::Stl,
        format!("solid one line {}endsolid one line", facet.repeat(100_000)),
    );
    assert_eq!(mesh.len(), 100_000);
    let names = "endsolid ".to_owned() + &"solid ".repeat(1_000_000);
    assert_eq!(
        accepted(Format::Stl, format!("solid a {facet}{names}")).len(),
        1
    );
    let spread = "f 1 2 3".to_owned() + &" \\\n 3".repeat(300_000);
    assert_eq!(
        accepted(Format::Obj, format!("{SQUARE}{spread}\n")).len(),
        300_001
    );
    assert!(
        start.elapsed() < Duration::from_secs(20),
        "{:?}",
        start.elapsed()
    );
}

#[cfg(unix)]
#[test]
fn file_names_may_be_any_bytes() {
    use std::os::unix::ffi::OsStrExt;
    let name = format!("punctual-io-{}-", std::process::id());
    let name = [name.as_bytes(), b"\xff.obj"].concat();
    let file = std::env::temp_dir().join(std::ffi::OsStr::from_bytes(&name));
    if std::fs::write(&file, format!("{SQUARE}f 1 2 3 4\n")).is_err() {
        return; // Not on every file system.
    }
    let mesh = load(&file).map(|loaded| loaded.mesh.len());
    std::fs::remove_file(&file).unwrap();
    assert_eq!(mesh, Ok(2));
}

/// Triangles keep the order of the file, which names them in every answer.
#[test]
fn polygons_among_triangles_keep_the_order() {
    let mesh = accepted(
        Format::Obj,
        format!("{SQUARE}v 0 0 1\nf 1 2 5\nf 1 2 3 4\nf 2 3 5\n"),
    );
    assert_eq!(
        mesh.triangles(),
        [[0, 1, 4], [0, 1, 2], [0, 2, 3], [1, 2, 4]]
    );
}
