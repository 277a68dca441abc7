//! Files out of order that are read all the same: what was passed over is told in one line each.

#[allow(dead_code, reason = "only some formats are used here")]
mod write;

use punctual::shapes::icosphere;
use punctual_io::{Format, Loaded, Place, load, read};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                   endsolid a\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const OFF: &str = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn by_name(name: &str) -> Vec<u8> {
    let formats = write::all_formats(&icosphere(0));
    formats
        .into_iter()
        .find(|(format, _)| *format == name)
        .unwrap()
        .1
}

/// The triangles, and the notices as texts.
fn told(format: Format, content: &[u8]) -> (usize, Vec<String>) {
    let loaded = read(content, format)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(content)));
    (
        loaded.mesh.len(),
        loaded.notices.iter().map(ToString::to_string).collect(),
    )
}

#[test]
fn text_that_is_out_of_order_is_read_with_a_notice() {
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
    let cases: [(Format, String, usize, &[&str]); 22] = [
        (
            Format::Obj,
            format!("{OBJ}m_mode 0\nm_mode 1\n"),
            1,
            &["line 5: unknown statement `m_mode` passed over (2 times)"],
        ),
        (
            Format::Obj,
            format!("{OBJ}surf 0 1\n"),
            1,
            &["line 5: unknown statement `surf` passed over"],
        ),
        (
            Format::Obj,
            format!("{OBJ}f\nf 1\nf 1 2\n"),
            1,
            &["line 5: face of fewer than 3 corners passed over (3 times)"],
        ),
        (
            Format::Obj,
            format!("{OBJ}\u{1a}"),
            1,
            &["1 bytes of padding after the text passed over"],
        ),
        (
            Format::Obj,
            format!("{OBJ}\0\0\u{1a}\r\n"),
            1,
            &["3 bytes of padding after the text passed over"],
        ),
        (
            Format::Obj,
            OBJ.trim_end().to_owned() + "\0\0",
            1,
            &["2 bytes of padding after the text passed over"],
        ),
        (
            Format::Obj,
            format!("{OBJ}\u{1b}[31m\n"),
            1,
            &["line 5: unknown statement `\\u{1b}[31m` passed over"],
        ),
        (
            Format::Obj,
            format!("l 1 2\n{OBJ}p 1\nl 2 3\n"),
            1,
            &[
                "line 1: `l` passed over: it has no triangles (2 times)",
                "line 6: `p` passed over: it has no triangles",
            ],
        ),
        (
            Format::Obj,
            format!("{OBJ}v 0 0 0 1 1 1 1 1\nv 0 0 0 red\n"),
            1,
            &["line 5: fields after the coordinates of a vertex passed over (2 times)"],
        ),
        (
            Format::Stl,
            STL.replace("solid a\nf", "solid a\n color .5 .5 .5\nf"),
            1,
            &["line 2: unknown statement `color` passed over"],
        ),
        (
            Format::Stl,
            STL.replace("endloop", "attribute 7 7\nendloop\nend of loop"),
            1,
            &[
                "line 7: unknown statement `attribute` passed over",
                "line 9: unknown statement `end` passed over",
            ],
        ),
        (
            Format::Stl,
            format!("{STL}{}", "\0".repeat(32)),
            1,
            &["32 bytes of padding after the text passed over"],
        ),
        (
            Format::Stl,
            format!("{STL}made by a program\n{STL}"),
            2,
            &["line 10: unknown statement `made` passed over"],
        ),
        (
            Format::Stl,
            STL.replace("endsolid a\n", ""),
            1,
            &["line 8: the file ends without `endsolid`"],
        ),
        (
            Format::Stl,
            STL.replace("endloop", "vertex 0 .5 0\nendloop"),
            2,
            &["line 2: facet of more than 3 corners filled as a polygon"],
        ),
        (
            Format::Stl,
            STL.replace("endsolid", &format!("{facet}endloop\nendfacet\nendsolid")),
            1,
            &["line 9: face of fewer than 3 corners passed over"],
        ),
        (
            Format::Ply,
            PLY.replace("1 0 0\n", "1 0 0 9\n"),
            1,
            &["line 11: more values than properties; the last are passed over"],
        ),
        (
            Format::Ply,
            PLY.replace("face 1", "face 2") + "2 0 1\n",
            1,
            &["line 14: face of fewer than 3 corners passed over"],
        ),
        (
            Format::Ply,
            format!("{PLY}junk"),
            1,
            &["4 bytes after what the header announces passed over"],
        ),
        (
            Format::Ply,
            PLY.replace("element face", "texture a.png\nelement face"),
            1,
            &["line 7: unknown statement `texture` in the header passed over"],
        ),
        (
            Format::Off,
            format!("{OFF}3 0 1 2\n\n1\n"),
            1,
            &["line 7: lines after the last face passed over"],
        ),
        (
            Format::Off,
            OFF.replace("3 1 0", "3 2 0") + "2 0 1\n",
            1,
            &["line 7: face of fewer than 3 corners passed over"],
        ),
    ];
    for (format, content, triangles, notices) in cases {
        let notices: Vec<String> = notices.iter().map(|&notice| notice.to_owned()).collect();
        assert_eq!(told(format, content.as_bytes()), (triangles, notices));
    }
}

#[test]
fn bytes_that_are_too_many_or_uncounted_are_told() {
    let stl = by_name("binary.STL");
    let more = |name: &str| [by_name(name), vec![7, 7]].concat();
    assert_eq!(
        told(Format::Stl, &more("binary.STL")),
        (
            20,
            vec!["byte 1084: 2 bytes after the last triangle passed over".into()]
        )
    );
    for count in [0, u32::MAX] {
        let mut uncounted = stl.clone();
        uncounted[80..84].copy_from_slice(&count.to_le_bytes());
        let what =
            "byte 80: the header leaves the number of triangles open; the file has room for 20";
        assert_eq!(told(Format::Stl, &uncounted), (20, vec![what.into()]));
        uncounted.push(0);
        let rest = "byte 1084: 1 bytes after the last triangle passed over";
        assert_eq!(
            told(Format::Stl, &uncounted),
            (20, vec![what.into(), rest.into()])
        );
    }
    for name in ["little.ply", "big.Ply"] {
        let what = format!(
            "byte {}: 2 bytes after what the header announces passed over",
            by_name(name).len()
        );
        assert_eq!(told(Format::Ply, &more(name)), (20, vec![what]));
    }
    let what = format!(
        "byte {}: 2 bytes after the end passed over",
        by_name("sphere.glb").len()
    );
    assert_eq!(told(Format::Gltf, &more("sphere.glb")), (20, vec![what]));
}

#[test]
fn polygons_that_cross_themselves_are_filled_with_a_notice() {
    let sliver = "v 0 0 0\nv 0.35 0.8 -0.11\nv 0.28 0.51 -0.07\nv -0.01 -0.23 -0.24\nv 9 0 0\nv 9 9 0\nf 1 2 3 4\nf 1 5 6\n";
    let star = "v 0 3 0\nv 2 -3 0\nv -3 1 0\nv 3 1 0\nv -2 -3 0\nf 1 2 3 4 5\n";
    for (obj, line, triangles) in [(sliver, 7, 3), (star, 6, 3)] {
        let (count, notices) = told(Format::Obj, obj.as_bytes());
        assert_eq!((count, notices.len()), (triangles, 1), "{notices:?}");
        assert!(
            notices[0].starts_with(&format!("line {line}: polygon that crosses itself")),
            "{notices:?}"
        );
    }
}

#[test]
fn strips_are_triangles_of_one_side() {
    let strip = |strip: &str| {
        let header = PLY
            .split("0 0 0")
            .next()
            .unwrap()
            .replace("vertex 3", "vertex 5");
        let header = header
            .replace("face 1", "tristrips 1")
            .replace("uchar int", "int int");
        let points = "0 0 0\n2 0 0\n0 2 0\n2 2 0\n0 4 0\n";
        let loaded = read(format!("{header}{points}{strip}\n").as_bytes(), Format::Ply).unwrap();
        assert_eq!(loaded.notices, []);
        loaded.mesh.triangles().to_vec()
    };
    assert_eq!(strip("5 0 1 2 3 4"), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    // The second begins anew.
    assert_eq!(
        strip("8 0 1 2 3 -1 2 3 4"),
        [[0, 1, 2], [1, 3, 2], [2, 3, 4]]
    );
    // Two parts joined by triangles without area, which are no surface between them.
    assert_eq!(strip("9 0 1 2 2 2 2 2 3 4"), [[0, 1, 2], [2, 3, 4]]);
}

/// A damaged file may have a million kinds of statements.
#[test]
fn notices_are_few() {
    let text: String = (0..1000).map(|i| format!("x{i} 0\n")).collect();
    let Loaded { notices, .. } = read(format!("{OBJ}{text}").as_bytes(), Format::Obj).unwrap();
    assert_eq!(
        notices.iter().map(|notice| notice.count).sum::<usize>(),
        1000
    );
    assert!(notices.len() < 20, "{}", notices.len());
}

#[test]
fn notices_name_file_and_place() {
    let folder = std::env::temp_dir().join(format!("punctual-io-{}-notices", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("a.obj");
    std::fs::write(&file, format!("{OBJ}f 1 2\n")).unwrap();
    let Loaded { notices, .. } = load(&file).unwrap();
    assert_eq!(notices[0].place, Some(Place::Line(5)));
    let text = notices[0].in_file("a.obj".as_ref());
    assert_eq!(text, "a.obj:5: face of fewer than 3 corners passed over");
    std::fs::remove_dir_all(&folder).unwrap();
}
