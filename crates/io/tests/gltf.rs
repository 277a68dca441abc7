//! glTF documents: how often parts are used, where nodes put them, and what is refused.

#[allow(dead_code, reason = "only the packing of a document is used here")]
mod write;

use punctual::Mesh;
use punctual::glam::DVec3;
use punctual_io::{Format, Limits, ReadError, read, read_within};

const GOOD: &str = r#""componentType":5126,"count":3"#;

/// A document of these nodes, the first of which is in the scene, with a mesh 0 of these primitives and a triangle for buffer.
fn document(nodes: &str, primitives: &str, accessor: &str) -> Vec<u8> {
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{primitives}]}}],"buffers":[{{"byteLength":36}}],
        "accessors":[{{"bufferView":0,"type":"VEC3","min":[0,0,0],"max":[1,1,1],{accessor}}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}]}}"#
    );
    let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    write::pack_glb(&json, &corners.map(f32::to_le_bytes).concat())
}

fn with_node(node: &str) -> Result<Mesh, ReadError> {
    let node = format!(r#"{{"mesh":0{node}}}"#);
    read(&document(&node, r#"{"attributes":{"POSITION":0}}"#, GOOD), Format::Glb)
}

#[track_caller]
fn assert_refused(result: Result<Mesh, ReadError>, expected: &str) {
    let message = result.expect_err("no mesh").to_string();
    assert!(message.contains(expected), "`{expected}` is not in: {message}");
}

#[test]
fn nodes_move_their_meshes() {
    let corner = |node: &str| with_node(node).unwrap().triangle(0)[1];
    assert_eq!(corner(""), DVec3::X);
    assert_eq!(corner(r#","translation":[1,2,3],"scale":[4,1,1]"#), DVec3::new(5.0, 2.0, 3.0));
    assert_eq!(corner(r#","rotation":[0,0,2,0]"#), DVec3::new(-1.0, 0.0, 0.0));
    assert_eq!(corner(r#","matrix":[0,1,0,0,-1,0,0,0,0,0,1,0,5,6,7,1]"#), DVec3::new(5.0, 7.0, 7.0));
}

#[test]
fn a_matrix_that_is_no_affine_map_is_refused() {
    for row in [["1", "0", "0", "1"], ["0", "0", "0.5", "1"], ["0", "0", "0", "2"], ["0", "0", "0", "0"]] {
        let [x, y, z, w] = row;
        let matrix = format!(r#","matrix":[1,0,0,{x},0,1,0,{y},0,0,1,{z},0,0,0,{w}]"#);
        assert_refused(with_node(&matrix), "node 0: its matrix is no affine map");
    }
    assert_refused(with_node(r#","rotation":[0,0,0,0]"#), "node 0: its transform is not finite");
    assert_refused(with_node(r#","scale":[3e38,1,1],"translation":[1e999,0,0]"#), "");
}

#[test]
fn what_is_outside_the_buffer_or_no_triangle_is_refused() {
    let primitive = r#"{"attributes":{"POSITION":0}}"#;
    let cases = [
        (primitive, r#""componentType":5126,"count":4"#, "node 0: mesh 0, primitive 0: accessor 0 reaches outside"),
        (primitive, r#""componentType":5126,"count":18446744073709551615"#, "outside"),
        (primitive, &format!(r#"{GOOD},"byteOffset":18446744073709551615"#), "outside"),
        (primitive, r#""componentType":5123,"count":3"#, "three f32"),
        (primitive, r#""componentType":5126,"count":2"#, "2 corners are no triangles"),
        (primitive, r#""componentType":5126,"count":0"#, "no triangles"),
        (r#"{"attributes":{"POSITION":0},"mode":0}"#, GOOD, "no triangles"),
        (r#"{"attributes":{"POSITION":1}}"#, GOOD, "accessor 1 does not exist"),
        (r#"{"attributes":{"POSITION":0},"indices":0}"#, GOOD, "vertex indices must be"),
        (r#"{"attributes":{}}"#, GOOD, ""),
    ];
    for (primitive, accessor, expected) in cases {
        assert_refused(read(&document(r#"{"mesh":0}"#, primitive, accessor), Format::Glb), expected);
    }
    for node in [r#","children":[0]"#, r#","children":[7]"#, r#","skin":0"#, r#","weights":[0.5]"#] {
        assert_refused(with_node(node), "");
    }
    let packed = |json: &str| read(&write::pack_glb(json, &[]), Format::Glb);
    assert_refused(packed(r#"{"asset":{"version":"2.0"}}"#), "no scene");
    assert_refused(packed("{"), "");
    assert_refused(packed(&"[".repeat(100_000)), "");
    assert_refused(read(b"glTF\x02\0\0\0\0\0\0\0", Format::Glb), "header is damaged");
    assert_refused(read(b"glTF\x02\0\0\0\xff\xff\xff\xff\xff\xff\xff\x7fJSON{}", Format::Glb), "");
}

#[test]
fn nodes_that_form_no_tree_are_refused() {
    let primitive = r#"{"attributes":{"POSITION":0}}"#;
    for nodes in [
        r#"{"children":[1]},{"children":[0]}"#,
        r#"{"children":[1,1]},{"mesh":0},{"mesh":0}"#,
        r#"{"children":[1,2]},{"children":[3]},{"children":[3]},{"mesh":0}"#,
    ] {
        assert_refused(read(&document(nodes, primitive, GOOD), Format::Glb), "there twice");
    }
    // A chain of any length is a tree.
    let chain: Vec<String> =
        (1..5000).map(|child| format!(r#"{{"children":[{child}],"translation":[0,0,1]}}"#)).collect();
    let mesh = read(&document(&(chain.join(",") + r#",{"mesh":0}"#), primitive, GOOD), Format::Glb).unwrap();
    assert_eq!(mesh.triangle(0)[0], DVec3::new(0.0, 0.0, 4999.0));
}

/// 500 primitives and 2,000 nodes in 80 KB are a million triangles, and with larger meshes more than a machine holds.
#[test]
fn meshes_used_again_and_again_have_a_limit() {
    let scene = |primitives: usize, nodes: usize, primitive: &str| {
        let children: Vec<String> = (1..=nodes).map(|child| child.to_string()).collect();
        let nodes = format!(r#"{{"children":[{}]}}{}"#, children.join(","), r#",{"mesh":0}"#.repeat(nodes));
        document(&nodes, &vec![primitive; primitives].join(","), GOOD)
    };
    let plain = r#"{"attributes":{"POSITION":0}}"#;
    let file = scene(500, 2000, plain);
    let within = |vertices, triangles| read_within(&file, Format::Glb, &Limits::new(vertices, triangles));
    assert_eq!(read(&file, Format::Glb).map(|mesh| mesh.len()), Ok(1_000_000));
    assert_eq!(within(3_000_000, 1_000_000).map(|mesh| mesh.len()), Ok(1_000_000));
    assert_refused(within(2_999_999, 1_000_000), "more than 2999999 vertices");
    assert_refused(within(3_000_000, 999_999), "node 2000: mesh 0, primitive 499: more than 999999 triangles");
    // What the file holds without repetition is within any limits.
    let once = read_within(&scene(1, 1, plain), Format::Glb, &Limits::new(0, 0));
    assert_eq!(once.map(|mesh| mesh.len()), Ok(1));
    assert_refused(read(&scene(5000, 2000, plain), Format::Glb), "more than 16777216 vertices");
    // Nor does it help that most of them are no triangles.
    assert_refused(read(&scene(20_000, 2000, r#"{"attributes":{"POSITION":0},"mode":1}"#), Format::Glb), "primitives");
}
