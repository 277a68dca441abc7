//! COLLADA: nodes move what they show, and what is out of order is named with its line.

use punctual::glam::DVec3;
use punctual_io::{Format, ReadOptions, read, read_with};

/// A square and a triangle on the plane z = 0, in a scene whose content is given.
fn document(scene: &str) -> String {
    format!(
        r##"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimetre" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="flat"><mesh>
<source id="points"><float_array id="numbers" count="15">0 0 0 100 0 0 100 100 0 0 100 0 200 0 0</float_array>
<technique_common><accessor source="#numbers" count="5" stride="3"/></technique_common></source>
<vertices id="vertices"><input semantic="POSITION" source="#points"/></vertices>
<polylist count="2"><input semantic="VERTEX" source="#vertices" offset="1"/><input semantic="NORMAL" source="#points" offset="0"/>
<vcount>4 3</vcount><p>9 0 9 1 9 2 9 3 9 1 9 4 9 2</p></polylist>
</mesh></geometry></library_geometries>
<library_nodes><node id="part"><instance_geometry url="#flat"/></node></library_nodes>
<library_visual_scenes><visual_scene id="all">{scene}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#all"/></scene>
</COLLADA>"##
    )
}

const SHOWN: &str = r##"<instance_geometry url="#flat"/>"##;

fn triangles(scene: &str) -> Vec<[DVec3; 3]> {
    let mesh = read(document(scene).as_bytes(), None).unwrap().mesh;
    (0..mesh.len()).map(|i| mesh.triangle(i)).collect()
}

#[test]
fn nodes_move_what_they_show_and_units_are_metres() {
    let flat = triangles(&format!("<node>{SHOWN}</node>"));
    assert_eq!(flat.len(), 3);
    assert_eq!(
        flat[2],
        [DVec3::X, 2.0 * DVec3::X, DVec3::new(1.0, 1.0, 0.0)]
    );
    // Twice, by other ways: the outer transform is applied last.
    let moved = "<translate>0 0 300</translate><rotate>0 0 1 90</rotate><scale>2 1 -1</scale>";
    let matrix = "<matrix>0 -1 0 0 2 0 0 0 0 0 -1 300 0 0 0 1</matrix>";
    let inner = r##"<node><instance_node url="#part"/></node>"##;
    let both = triangles(&format!(
        "<node>{moved}{inner}</node><node>{matrix}{SHOWN}</node>"
    ));
    assert_eq!(both.len(), 6);
    for (i, triangle) in both.iter().enumerate() {
        // A mirror turns the triangle over.
        let [a, b, c] = flat[i % 3];
        for (found, p) in triangle.iter().zip([a, c, b]) {
            let want = DVec3::new(-p.y, 2.0 * p.x, 3.0 - p.z);
            assert!(found.distance(want) < 1e-15, "{found} {want}");
        }
    }
}

#[test]
fn strips_fans_and_polygons_are_read_and_lines_passed_over() {
    let whole = document(&format!("<node>{SHOWN}</node>"));
    let begin = whole.find("<polylist").unwrap();
    let end = whole.find("</polylist>").unwrap() + "</polylist>".len();
    let input = r##"<input semantic="VERTEX" source="#vertices" offset="0"/>"##;
    for (kind, lists, count) in [
        ("triangles", "<p>0 1 2 0 2 3</p>", 2),
        ("polygons", "<p>0 1 2 3</p><p>1 4 2</p>", 3),
        ("tristrips", "<p>0 1 3 2</p>", 2),
        ("trifans", "<p>0 1 2 3</p><p>1 4 2</p>", 3),
    ] {
        let primitive = format!("<{kind}>{input}{lists}</{kind}><lines>{input}<p>0 1</p></lines>");
        let text = [&whole[..begin], &primitive, &whole[end..]].concat();
        let loaded = read(text.as_bytes(), Format::Collada).unwrap();
        assert_eq!(loaded.mesh.len(), count, "{kind}");
        assert_eq!(loaded.notices[0].to_string(), "line 8: lines passed over");
    }
}

#[test]
fn a_convex_mesh_is_read_and_the_hull_of_another_is_refused() {
    let whole = document(&format!("<node>{SHOWN}</node>"));
    let convex = whole
        .replace("<mesh>", "<convex_mesh>")
        .replace("</mesh>", "</convex_mesh>");
    let [mesh, convex] =
        [whole, convex].map(|text| read(text.as_bytes(), Format::Collada).unwrap().mesh);
    assert_eq!((convex.len(), convex.triangles()), (3, mesh.triangles()));
    let hull = r##"<geometry id="hull"><convex_mesh convex_hull_of="#flat"/></geometry>"##;
    let whole = document(&format!("<node>{}</node>", SHOWN.replace("flat", "hull")));
    let whole = whole.replace(
        "</library_geometries>",
        &format!("{hull}</library_geometries>"),
    );
    let error = read(whole.as_bytes(), Format::Collada)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("needs COLLADA's convex_mesh with convex_hull_of"),
        "{error}"
    );
}

#[test]
fn a_declaration_behind_blanks_or_comments_is_read() {
    let whole = document(&format!("<node>{SHOWN}</node>"));
    for before in ["\n\n", "<!-- made\nby hand -->"] {
        let late = format!("{before}{whole}");
        assert_eq!(
            read(late.as_bytes(), Format::Collada).unwrap().mesh.len(),
            3
        );
        let fault = late.replace("0.01", "0");
        let error = read(fault.as_bytes(), Format::Collada)
            .unwrap_err()
            .to_string();
        let line = 2 + before.matches('\n').count();
        assert!(
            error.starts_with(&format!("line {line}: the unit")),
            "{error}"
        );
    }
}

#[test]
fn faults_name_the_line() {
    let whole = document(&format!("<node>{SHOWN}</node>"));
    let with = |from: &str, to: &str| whole.replace(from, to);
    let within = |depth: usize| {
        format!(
            "{}{SHOWN}{}",
            "<node>".repeat(depth),
            "</node>".repeat(depth)
        )
    };
    let cases: [(String, &str); 19] = [
        ("<COLLADA".into(), "line 1: "),
        (
            "<sdf/>".into(),
            "line 1: the outermost element is not `COLLADA`",
        ),
        (with("0.01", "0"), "line 2: the unit has no length above 0"),
        (
            with("url=\"#flat\"", "url=\"#other\""),
            "`#other` is not in this file",
        ),
        (
            with("url=\"#flat\"", "url=\"a.dae#flat\""),
            "`a.dae#flat` is not in this file",
        ),
        (
            with("url=\"#flat\"", ""),
            "`instance_geometry` without `url`",
        ),
        (
            with("200 0 0", "200 zero 0"),
            "line 5: \"zero\" is not a number",
        ),
        (with("200 0 0", "nan 0 0"), "vertex 4 is not finite"),
        (
            with("stride=\"3\"", "stride=\"2\""),
            "line 6: positions that are not three numbers each",
        ),
        (
            with("stride=\"3\"", "stride=\"x\""),
            "line 6: stride and offset",
        ),
        (with("9 4", "9 5"), "line 9: a vertex that there is not"),
        (with("9 4", "9"), "line 9: "),
        (
            with("4 3</vcount>", "4 4</vcount>"),
            "line 9: ends before the last polygon",
        ),
        (
            with("\"VERTEX\"", "\"TEXCOORD\""),
            "line 8: no input VERTEX",
        ),
        (
            with(SHOWN, "<matrix>1 2 3</matrix>"),
            "line 12: must have 16 numbers",
        ),
        (
            with(SHOWN, "<skew>1 2 3</skew>"),
            "needs COLLADA's skew, which is not supported",
        ),
        (
            with(SHOWN, "<instance_controller url=\"#flat\"/>"),
            "needs COLLADA's instance_controller",
        ),
        (with(SHOWN, ""), "no triangles in it"),
        (
            document(&within(200)),
            "line 12: too many nodes within nodes",
        ),
    ];
    for (text, expected) in cases {
        let message = read(text.as_bytes(), Format::Collada)
            .unwrap_err()
            .to_string();
        assert!(message.contains(expected), "{expected} {message}");
    }
    // A node that shows itself, and parts that are shown again and again.
    let part = r##"<node id="part">"##;
    let circle = document("").replace(part, &format!("{part}<instance_node url=\"#part\"/>"));
    let circle = circle.replace("url=\"#all\"", "url=\"#part\"");
    let options = ReadOptions::default().limits(punctual_io::Limits::new(100_000, 100_000));
    let many = document(&format!("<node>{}</node>", SHOWN.repeat(10)));
    let twice = |url: &str| format!("<instance_node url=\"#{url}\"/>").repeat(60);
    let levels: String = (0..4)
        .map(|i| format!("<node id=\"n{}\">{}</node>", i + 1, twice(&format!("n{i}"))))
        .collect();
    let levels = format!("<node id=\"n0\">{SHOWN}</node>{levels}");
    let many = many.replace("<library_nodes>", &format!("<library_nodes>{levels}"));
    let many = many.replace("url=\"#all\"", "url=\"#n4\"");
    for (text, expected) in [(circle, "nodes within nodes"), (many, "too")] {
        let error = read_with(text.as_bytes(), Format::Collada, &options).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    let deep = document(&within(200_000));
    assert!(read(deep.as_bytes(), Format::Collada).is_err());
}
