//! glTF documents: how often parts are used, where nodes put them, and what is refused.

#[allow(dead_code, reason = "only the packing of a document is used here")]
mod write;

use punctual::glam::DVec3;
use punctual_io::{Format, Limits, Loaded, ReadError, ReadOptions, load, read, read_with};

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

fn with_node(node: &str) -> Result<Loaded, ReadError> {
    let node = format!(r#"{{"mesh":0{node}}}"#);
    read(
        &document(&node, r#"{"attributes":{"POSITION":0}}"#, GOOD),
        Format::Gltf,
    )
}

#[track_caller]
fn assert_refused(result: Result<Loaded, ReadError>, expected: &str) {
    let message = result.expect_err("no mesh").to_string();
    assert!(message.contains(expected), "{expected} {message}");
}

#[test]
fn nodes_move_their_meshes() {
    let corner = |node: &str| with_node(node).unwrap().mesh.triangle(0)[1];
    assert_eq!(corner(""), DVec3::X);
    assert_eq!(
        corner(r#","translation":[1,2,3],"scale":[4,1,1]"#),
        DVec3::new(5.0, 2.0, 3.0)
    );
    assert_eq!(
        corner(r#","rotation":[0,0,2,0]"#),
        DVec3::new(-1.0, 0.0, 0.0)
    );
    assert_eq!(
        corner(r#","matrix":[0,1,0,0,-1,0,0,0,0,0,1,0,5,6,7,1]"#),
        DVec3::new(5.0, 7.0, 7.0)
    );
}

#[test]
fn a_matrix_that_is_no_affine_map_is_refused() {
    for row in [
        ["1", "0", "0", "1"],
        ["0", "0", "0.5", "1"],
        ["0", "0", "0", "2"],
        ["0", "0", "0", "0"],
    ] {
        let [x, y, z, w] = row;
        let matrix = format!(r#","matrix":[1,0,0,{x},0,1,0,{y},0,0,1,{z},0,0,0,{w}]"#);
        assert_refused(with_node(&matrix), "node 0: its matrix is no affine map");
    }
    assert_refused(
        with_node(r#","rotation":[0,0,0,0]"#),
        "node 0: its transform is not finite",
    );
    assert_refused(
        with_node(r#","scale":[3e38,1,1],"translation":[1e999,0,0]"#),
        "",
    );
}

#[test]
fn what_is_outside_the_buffer_or_no_triangle_is_refused() {
    let primitive = r#"{"attributes":{"POSITION":0}}"#;
    let cases = [
        (
            primitive,
            r#""componentType":5126,"count":4"#,
            "node 0: mesh 0, primitive 0: accessor 0: reaches outside",
        ),
        (
            primitive,
            r#""componentType":5126,"count":18446744073709551615"#,
            "outside",
        ),
        (
            primitive,
            &format!(r#"{GOOD},"byteOffset":18446744073709551615"#),
            "outside",
        ),
        (
            primitive,
            r#""componentType":5124,"count":3"#,
            "accessor 0: 5124 is no type of numbers",
        ),
        (
            primitive,
            r#""componentType":5126,"count":2"#,
            "no triangles in it; incomplete triangle",
        ),
        (
            primitive,
            r#""componentType":5126,"count":0"#,
            "no triangles",
        ),
        (
            r#"{"attributes":{"POSITION":0},"mode":0}"#,
            GOOD,
            "no triangles",
        ),
        (
            r#"{"attributes":{"POSITION":1}}"#,
            GOOD,
            "accessor 1 does not exist",
        ),
        (
            r#"{"attributes":{"POSITION":0},"indices":0}"#,
            GOOD,
            "accessor 0: its type is `VEC3`, must have 1 numbers",
        ),
        (
            r#"{"attributes":{}}"#,
            GOOD,
            "no triangles in it; primitive without POSITION",
        ),
    ];
    for (primitive, accessor, expected) in cases {
        assert_refused(
            read(
                &document(r#"{"mesh":0}"#, primitive, accessor),
                Format::Gltf,
            ),
            expected,
        );
    }
    for node in [r#","children":[0]"#, r#","children":[7]"#, r#","skin":0"#] {
        assert_refused(with_node(node), "");
    }
    let packed = |json: &str| read(&write::pack_glb(json, &[]), Format::Gltf);
    assert_refused(packed(r#"{"asset":{"version":"2.0"}}"#), "no scene");
    assert_refused(packed("{"), "");
    assert_refused(packed(&"[".repeat(100_000)), "");
    assert_refused(
        read(b"glTF\x02\0\0\0\0\0\0\0", Format::Gltf),
        "header is damaged",
    );
    assert_refused(
        read(
            b"glTF\x02\0\0\0\xff\xff\xff\xff\xff\xff\xff\x7fJSON{}",
            Format::Gltf,
        ),
        "",
    );
}

#[test]
fn nodes_that_form_no_tree_are_refused() {
    let primitive = r#"{"attributes":{"POSITION":0}}"#;
    for nodes in [
        r#"{"children":[1]},{"children":[0]}"#,
        r#"{"children":[1,1]},{"mesh":0},{"mesh":0}"#,
        r#"{"children":[1,2]},{"children":[3]},{"children":[3]},{"mesh":0}"#,
    ] {
        assert_refused(
            read(&document(nodes, primitive, GOOD), Format::Gltf),
            "there twice",
        );
    }
    // A chain of any length is a tree.
    let chain: Vec<String> = (1..5000)
        .map(|child| format!(r#"{{"children":[{child}],"translation":[0,0,1]}}"#))
        .collect();
    let mesh = read(
        &document(&(chain.join(",") + r#",{"mesh":0}"#), primitive, GOOD),
        Format::Gltf,
    )
    .unwrap()
    .mesh;
    assert_eq!(mesh.triangle(0)[0], DVec3::new(0.0, 0.0, 4999.0));
}

/// 500 primitives and 2,000 nodes in 80 KB are a million triangles, and with larger meshes more than a machine holds.
#[test]
fn meshes_used_again_and_again_have_a_limit() {
    let scene = |primitives: usize, nodes: usize, primitive: &str| {
        let children: Vec<String> = (1..=nodes).map(|child| child.to_string()).collect();
        let nodes = format!(
            r#"{{"children":[{}]}}{}"#,
            children.join(","),
            r#",{"mesh":0}"#.repeat(nodes)
        );
        document(&nodes, &vec![primitive; primitives].join(","), GOOD)
    };
    let plain = r#"{"attributes":{"POSITION":0}}"#;
    let file = scene(500, 2000, plain);
    let limits =
        |vertices, triangles| ReadOptions::default().limits(Limits::new(vertices, triangles));
    let within = |vertices, triangles| read_with(&file, Format::Gltf, &limits(vertices, triangles));
    let count = |result: Result<Loaded, ReadError>| result.map(|loaded| loaded.mesh.len());
    assert_eq!(count(read(&file, Format::Gltf)), Ok(1_000_000));
    assert_eq!(count(within(3_000_000, 1_000_000)), Ok(1_000_000));
    assert_refused(within(2_999_999, 1_000_000), "more than 2999999 vertices");
    assert_refused(
        within(3_000_000, 999_999),
        "node 2000: mesh 0, primitive 499: more than 999999 triangles",
    );
    // What the file holds without repetition is within any limits.
    assert_eq!(
        count(read_with(&scene(1, 1, plain), Format::Gltf, &limits(0, 0))),
        Ok(1)
    );
    assert_refused(
        read(&scene(5000, 2000, plain), Format::Gltf),
        "more than 16777216 vertices",
    );
    // Nor nor that most of them are no triangles.
    assert_refused(
        read(
            &scene(20_000, 2000, r#"{"attributes":{"POSITION":0},"mode":1}"#),
            Format::Gltf,
        ),
        "primitives",
    );
}

/// A document of these members, and a buffer of these bytes, as text with a data URI.
fn text(members: &str, bytes: &[u8]) -> String {
    let data = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, bytes);
    let length = bytes.len();
    format!(
        r#"{{"asset":{{"version":"2.0"}},{members},
        "buffers":[{{"byteLength":{length},"uri":"data:application/gltf-buffer;base64,{data}"}}]}}"#
    )
}

const SCENE: &str = r#""scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}]"#;

#[track_caller]
fn corners(result: Result<Loaded, ReadError>) -> Vec<[[f64; 3]; 3]> {
    let Loaded { mesh, notices, .. } = result.unwrap();
    assert_eq!(notices, []);
    (0..mesh.len())
        .map(|i| mesh.triangle(i).map(|corner| corner.to_array()))
        .collect()
}

const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn required_extensions_are_refused_where_they_hold_triangles() {
    let with = |extension: &str, at_node: &str, at_primitive: &str| {
        let members = format!(
            r#""extensionsUsed":["{extension}"],"extensionsRequired":["{extension}"],
            "scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{at_node}}}],"meshes":[{{"primitives":[
            {{"attributes":{{"POSITION":0}}{at_primitive}}}]}}],"materials":[{{"extensions":{{"{extension}":{{}}}}}}],
            "accessors":[{{"bufferView":0,"type":"VEC3",{GOOD}}}],"bufferViews":[{{"buffer":0,"byteLength":36}}]"#
        );
        read(
            text(
                &members,
                &TRIANGLE
                    .as_flattened()
                    .iter()
                    .flat_map(|&x| (x as f32).to_le_bytes())
                    .collect::<Vec<_>>(),
            )
            .as_bytes(),
            Format::Gltf,
        )
    };
    // Bounds of positions are missing too, which nobody needs.
    for name in [
        "KHR_texture_transform",
        "KHR_materials_unlit",
        "EXT_texture_webp",
        "ACME_sounds",
    ] {
        assert_eq!(corners(with(name, "", "")), [TRIANGLE], "{name}");
    }
    let at = |name: &str| format!(r#","extensions":{{"{name}":{{}}}}"#);
    for name in [
        "KHR_lights_punctual",
        "KHR_node_visibility",
        "EXT_mesh_features",
        "KHR_materials_variants",
    ] {
        assert_eq!(corners(with(name, &at(name), &at(name))), [TRIANGLE]);
    }
    for name in ["KHR_draco_mesh_compression", "ACME_cloth"] {
        let error = with(name, "", &at(name)).unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("needs {name}, which is not supported")),
            "{error}"
        );
    }
    assert_refused(
        with("ACME_cloth", &at("ACME_cloth"), ""),
        "needs ACME_cloth, which is not supported",
    );
}

#[test]
fn packed_data_without_a_fallback_is_refused_by_the_name_of_the_packing() {
    let primitive = r#""extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}"#;
    let draco = format!(
        r#"{SCENE},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},{primitive}}}]}}],
        "accessors":[{{"componentType":5126,"count":3,"type":"VEC3"}}]"#
    );
    let meshopt = format!(
        r#"{SCENE},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"type":"VEC3",{GOOD}}}],
        "bufferViews":[{{"buffer":1,"byteLength":36,"extensions":{{"EXT_meshopt_compression":{{"buffer":0}}}}}}]"#
    );
    for (members, name) in [
        (draco, "KHR_draco_mesh_compression"),
        (meshopt, "EXT_meshopt_compression"),
    ] {
        let text =
            text(&members, &[0; 36]).replace(r#""buffers":["#, r#""buffers":[{"byteLength":36},"#);
        let text = text.replace(r#""buffer":1"#, r#""buffer":0"#);
        let error = read(text.as_bytes(), Format::Gltf).unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("needs {name}, which is not supported (")),
            "{error}"
        );
    }
}

/// Fronts stay fronts: the triangle looks along +z before and after.
#[test]
fn nodes_that_mirror_turn_triangles_over() {
    let normal = |node: &str| {
        let mesh = with_node(node).unwrap().mesh;
        let [p, q, r] = mesh.triangle(0);
        (q - p).cross(r - p)
    };
    assert_eq!(normal(r#","scale":[2,1,1]"#), DVec3::new(0.0, 0.0, 2.0));
    assert_eq!(normal(r#","scale":[-2,1,1]"#), DVec3::new(0.0, 0.0, 2.0));
    assert_eq!(normal(r#","scale":[-1,-1,1]"#), DVec3::Z);
    assert_eq!(
        normal(r#","matrix":[0,1,0,0,1,0,0,0,0,0,1,0,0,0,0,1]"#),
        DVec3::Z
    );
    assert_eq!(normal(r#","scale":[1,1,-1]"#), DVec3::NEG_Z);
    let parents = document(
        r#"{"children":[1],"scale":[-1,1,1]},{"mesh":0,"scale":[1,-1,1]}"#,
        r#"{"attributes":{"POSITION":0}}"#,
        GOOD,
    );
    let [p, q, r] = read(&parents, Format::Gltf).unwrap().mesh.triangle(0);
    assert_eq!((q - p).cross(r - p), DVec3::Z);
}

#[test]
fn instances_are_placed_one_by_one() {
    let floats = |values: &[f32]| {
        values
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let mut bytes = floats(
        &TRIANGLE
            .as_flattened()
            .iter()
            .map(|&x| x as f32)
            .collect::<Vec<_>>(),
    );
    bytes.extend(floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 2.0]));
    bytes.extend(floats(&[1.0, 1.0, 1.0, -1.0, 3.0, 1.0]));
    // A half turn around z, as shares of 127.
    bytes.extend([0i8, 0, 127, 0, 0, 0, 0, 127].map(|x| x as u8));
    let members = r#""extensionsRequired":["EXT_mesh_gpu_instancing"],"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0,"translation":[10,0,0],"extensions":{"EXT_mesh_gpu_instancing":
        {"attributes":{"TRANSLATION":1,"SCALE":2,"ROTATION":3,"_ID":7}}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"type":"VEC3","componentType":5126,"count":3},
        {"bufferView":1,"type":"VEC3","componentType":5126,"count":2},
        {"bufferView":1,"byteOffset":24,"type":"VEC3","componentType":5126,"count":2},
        {"bufferView":2,"type":"VEC4","componentType":5120,"normalized":true,"count":2}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":48},
        {"buffer":0,"byteOffset":84,"byteLength":8}]"#;
    let expected = [
        [[10.0, 0.0, 1.0], [9.0, 0.0, 1.0], [10.0, -1.0, 1.0]],
        // Mirrored, so that the last two corners change places.
        [[10.0, 0.0, 2.0], [10.0, 3.0, 2.0], [9.0, 0.0, 2.0]],
    ];
    let found = corners(read(text(members, &bytes).as_bytes(), Format::Gltf));
    assert_eq!(found.len(), 2);
    for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
        assert!(
            DVec3::from_array(*found).distance(DVec3::from_array(*expected)) < 1e-12,
            "{found:?} {expected:?}"
        );
    }
    let uneven = text(members, &bytes).replace(r#""count":2}],"#, r#""count":1}],"#);
    assert_refused(
        read(uneven.as_bytes(), Format::Gltf),
        "its instances have different lengths",
    );
}

#[test]
fn positions_may_be_packed_in_many_ways() {
    let read = |accessor: &str, view: &str, bytes: &[u8]| {
        let members = format!(
            r#"{SCENE},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "accessors":[{{"bufferView":0,"type":"VEC3","count":3,{accessor}}}],"bufferViews":[{{"buffer":0,{view}}},
            {{"buffer":0,"byteOffset":40,"byteLength":20}}]"#
        );
        corners(read(text(&members, bytes).as_bytes(), Format::Gltf))[0]
    };
    let bytes = |numbers: [i8; 12]| numbers.map(|x| x as u8).to_vec();
    // With a byte between vertices, as stride 4 demands.
    let packed = bytes([0, 0, 0, 9, 127, -128, 64, 9, -127, 1, 0, 9]);
    let stride = r#""byteLength":12,"byteStride":4"#;
    assert_eq!(
        read(r#""componentType":5120"#, stride, &packed),
        [[0.0; 3], [127.0, -128.0, 64.0], [-127.0, 1.0, 0.0]]
    );
    assert_eq!(
        read(r#""componentType":5120,"normalized":true"#, stride, &packed),
        [
            [0.0; 3],
            [1.0, -1.0, 64.0 / 127.0],
            [-1.0, 1.0 / 127.0, 0.0]
        ]
    );
    assert_eq!(
        read(r#""componentType":5121,"normalized":true"#, stride, &packed),
        [
            [0.0; 3],
            [127.0 / 255.0, 128.0 / 255.0, 64.0 / 255.0],
            [129.0 / 255.0, 1.0 / 255.0, 0.0]
        ]
    );
    let wide: Vec<u8> = [0u16, 1, 65535, 3, 4, 5, 6, 7, 8]
        .into_iter()
        .flat_map(u16::to_le_bytes)
        .collect();
    let view = r#""byteLength":18"#;
    assert_eq!(
        read(r#""componentType":5123"#, view, &wide),
        [[0.0, 1.0, 65535.0], [3.0, 4.0, 5.0], [6.0, 7.0, 8.0]]
    );
    assert_eq!(
        read(r#""componentType":5122,"normalized":true"#, view, &wide),
        [[0.0, 1.0, -1.0], [3.0, 4.0, 5.0], [6.0, 7.0, 8.0]].map(|v| v.map(|x: f64| if x < 0.0 {
            -1.0 / 32767.0
        } else {
            x / 32767.0
        }))
    );
    // Sparse: vertex 2 is another.
    let mut sparse: Vec<u8> = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 9.0, 9.0, 9.0]
        .into_iter()
        .flat_map(f32::to_le_bytes)
        .collect();
    sparse.resize(40, 0);
    sparse.extend(2u16.to_le_bytes());
    sparse.resize(44, 0);
    sparse.extend([0.0f32, 1.0, 0.0].into_iter().flat_map(f32::to_le_bytes));
    sparse.resize(60, 0);
    let replaced = r#""componentType":5126,"sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},
        "values":{"bufferView":1,"byteOffset":4}}"#;
    assert_eq!(read(replaced, r#""byteLength":36"#, &sparse), TRIANGLE);
}

/// An accessor without bytes is all zeros, and may say that it has any number of them.
#[test]
fn accessors_without_bytes_have_a_limit() {
    let members = |count: &str| {
        format!(
            r#"{SCENE},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"type":"VEC3","componentType":5126,"count":{count}}}]"#
        )
    };
    let read = |count: &str| read(text(&members(count), &[]).as_bytes(), Format::Gltf);
    assert_eq!(corners(read("3")), [[[0.0; 3]; 3]]);
    assert_refused(read("18446744073709551615"), "accessor 0: ");
    assert_refused(
        read("10000000"),
        "accessor 0: 10000000 elements without bytes are too many",
    );
}

#[test]
fn strips_and_fans_are_triangles_of_one_side() {
    let points: Vec<u8> = [[0.0f32, 0.0], [2.0, 0.0], [0.0, 2.0], [2.0, 2.0]]
        .into_iter()
        .flat_map(|[x, y]| [x, y, 0.0])
        .flat_map(f32::to_le_bytes)
        .collect();
    let triangles = |mode: u32| {
        let members = format!(
            r#"{SCENE},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":{mode}}}]}}],
            "accessors":[{{"bufferView":0,"type":"VEC3","componentType":5126,"count":4}}],
            "bufferViews":[{{"buffer":0,"byteLength":48}}]"#
        );
        read(text(&members, &points).as_bytes(), Format::Gltf)
            .unwrap()
            .mesh
            .triangles()
            .to_vec()
    };
    assert_eq!(triangles(5), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(triangles(6), [[0, 1, 2], [0, 2, 3]]);
}

/// A chain of two joints, the second of which is turned by a quarter; and a morph.
#[test]
fn skins_and_morphs_pose_the_mesh() {
    let mut bytes: Vec<u8> = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0]
        .into_iter()
        .flat_map(f32::to_le_bytes)
        .collect();
    bytes.extend([0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0]);
    bytes.extend(
        [
            1.0f32, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0,
        ]
        .into_iter()
        .flat_map(f32::to_le_bytes),
    );
    let identity = [
        1.0f32, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    ];
    let mut back = identity;
    back[12] = -1.0;
    bytes.extend(
        [identity, back]
            .as_flattened()
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    bytes.extend(
        [0.0f32, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
            .into_iter()
            .flat_map(f32::to_le_bytes),
    );
    let members = |node: &str, weights: &str| {
        format!(
            r#""scenes":[{{"nodes":[0,1]}}],"nodes":[{{"mesh":0,"translation":[50,0,0]{node}}},{{"children":[2]}},
        {{"translation":[1,0,0],"rotation":[0,0,0.7071067811865476,0.7071067811865476]}}],
        "skins":[{{"joints":[1,2],"inverseBindMatrices":3}}],"meshes":[{{"weights":[{weights}],"primitives":
        [{{"attributes":{{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}},"targets":[{{"POSITION":4}}]}}]}}],
        "accessors":[{{"bufferView":0,"type":"VEC3","componentType":5126,"count":3}},
        {{"bufferView":0,"byteOffset":36,"type":"VEC4","componentType":5121,"count":3}},
        {{"bufferView":0,"byteOffset":48,"type":"VEC4","componentType":5126,"count":3}},
        {{"bufferView":0,"byteOffset":96,"type":"MAT4","componentType":5126,"count":2}},
        {{"bufferView":0,"byteOffset":224,"type":"VEC3","componentType":5126,"count":3}}],
        "bufferViews":[{{"buffer":0,"byteLength":260}}]"#
        )
    };
    let read = |node: &str, weights: &str| {
        corners(read(
            text(&members(node, weights), &bytes).as_bytes(),
            Format::Gltf,
        ))[0]
    };
    let close = |found: [[f64; 3]; 3], expected: [[f64; 3]; 3]| {
        let far = found
            .as_flattened()
            .iter()
            .zip(expected.as_flattened())
            .any(|(x, y)| (x - y).abs() > 1e-12);
        assert!(!far, "{found:?} {expected:?}");
    };
    close(
        read("", "0"),
        [[50.0, 0.0, 0.0], [51.0, 0.0, 0.0], [52.0, 0.0, 0.0]],
    );
    close(
        read("", "0.25"),
        [[50.0, 0.0, 1.0], [51.0, 0.0, 0.0], [52.0, 0.0, 0.0]],
    );
    // The node of a skinned mesh does not move it.
    close(
        read(r#","skin":0"#, "0"),
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
    );
    close(
        read(r#","skin":0,"weights":[0.5]"#, "0"),
        [[0.0, 0.0, 2.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
    );
}

#[test]
fn buffers_lie_beside_the_document() {
    let folder = std::env::temp_dir().join(format!("punctual-io-{}-gltf", std::process::id()));
    std::fs::create_dir_all(folder.join("sub")).unwrap();
    let bytes: Vec<u8> = TRIANGLE
        .as_flattened()
        .iter()
        .flat_map(|&x| (x as f32).to_le_bytes())
        .collect();
    let members = format!(
        r#"{SCENE},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"type":"VEC3",{GOOD}}}],"bufferViews":[{{"buffer":0,"byteLength":36}}]"#
    );
    let document = |uri: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},{members},"buffers":[{{"uri":"{uri}","byteLength":36}}]}}"#
        )
    };
    let load = |uri: &str| {
        let file = folder.join("a.gltf");
        std::fs::write(&file, format!("\u{feff}{}\r\n", document(uri))).unwrap();
        load(&file)
    };
    std::fs::write(folder.join("sub").join("b c.bin"), &bytes).unwrap();
    std::fs::write(folder.join("short.bin"), &bytes[..35]).unwrap();
    std::fs::write(
        folder.join("lfs.bin"),
        "version https://git-lfs.github.com/spec/v1\n",
    )
    .unwrap();
    for uri in ["sub/b%20c.bin", "sub/b c.bin", "./sub/../sub/b%20c.bin"] {
        assert_eq!(
            load(uri)
                .unwrap()
                .mesh
                .triangle(0)
                .map(|corner| corner.to_array()),
            TRIANGLE
        );
    }
    for (uri, expected) in [
        ("none.bin", "none.bin: "),
        ("sub", "no file"),
        ("short.bin", "reaches outside"),
        ("lfs.bin", "a Git LFS pointer"),
        (
            "https://example.org/a.bin",
            "a.gltf: needs a file that is named by a full address, which is not supported",
        ),
        (
            "data:application/octet-stream;base64,?",
            "its data URI is no base64",
        ),
    ] {
        let error = load(uri).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    assert_refused(
        read(document("sub/b%20c.bin").as_bytes(), None),
        "the folder of the document is not known",
    );
    let options = ReadOptions::default().folder(&folder);
    assert_eq!(
        corners(read_with(
            document("sub/b%20c.bin").as_bytes(),
            None,
            &options
        )),
        [TRIANGLE]
    );
    // A large file may not be named again and again.
    let mut little = ReadOptions::default().folder(&folder);
    little.limits.unpacked = 71;
    let twice = document("sub/b%20c.bin").replace(
        r#""buffers":["#,
        r#""buffers":[{"uri":"./sub/b c.bin","byteLength":36},"#,
    );
    let twice = twice.replace(
        r#""attributes":{"POSITION":0}"#,
        r#""attributes":{"POSITION":0},"targets":[{"POSITION":1}]"#,
    );
    let twice = twice.replace(r#""meshes":[{"#, r#""meshes":[{"weights":[1],"#);
    let twice = twice.replace(
        r#""accessors":["#,
        &format!(r#""accessors":[{{"bufferView":1,"type":"VEC3",{GOOD}}},"#),
    );
    let twice = twice.replace(
        r#""bufferViews":["#,
        r#""bufferViews":[{"buffer":1,"byteLength":36},"#,
    );
    assert_refused(
        read_with(twice.as_bytes(), None, &little),
        "buffers of more than 71 bytes",
    );
    little.limits.unpacked = 72;
    assert_eq!(
        corners(read_with(twice.as_bytes(), None, &little)),
        [TRIANGLE.map(|corner| corner.map(|x| 2.0 * x))]
    );
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn elements_left_out_of_a_document_are_told() {
    let told = |members: &str| {
        let bytes: Vec<u8> = TRIANGLE
            .as_flattened()
            .iter()
            .flat_map(|&x| (x as f32).to_le_bytes())
            .collect();
        let members = format!(
            r#"{members},"accessors":[{{"bufferView":0,"type":"VEC3",{GOOD}}},
            {{"bufferView":0,"type":"VEC3","componentType":5126,"count":2}}],"bufferViews":[{{"buffer":0,"byteLength":36}}]"#
        );
        let Loaded { mesh, notices, .. } =
            read(text(&members, &bytes).as_bytes(), Format::Gltf).unwrap();
        (
            mesh.len(),
            notices
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join("; "),
        )
    };
    let plain = r#"{"attributes":{"POSITION":0}}"#;
    let meshes = |more: &str| format!(r#""meshes":[{{"primitives":[{plain}{more}]}}]"#);
    let lines = r#",{"attributes":{"POSITION":0},"mode":1}"#;
    let what = "points or lines of a primitive passed over (2 times)";
    assert_eq!(
        told(&format!("{SCENE},{}", meshes(&lines.repeat(2)))),
        (1, what.into())
    );
    let what = "incomplete triangle at the end of a primitive passed over";
    assert_eq!(
        told(&format!(
            "{SCENE},{}",
            meshes(r#",{"attributes":{"POSITION":1}}"#)
        )),
        (1, what.into())
    );
    let what = "primitive without POSITION passed over";
    assert_eq!(
        told(&format!("{SCENE},{}", meshes(r#",{"attributes":{}}"#))),
        (1, what.into())
    );
    let scenes =
        r#""scene":1,"scenes":[{"nodes":[0]},{"nodes":[1,0]}],"nodes":[{"mesh":0},{"mesh":0}]"#;
    assert_eq!(
        told(&format!("{scenes},{}", meshes(""))),
        (2, "1 scenes other than scene 1 passed over".into())
    );
    let nodes = r#""nodes":[{"mesh":0},{"mesh":0,"children":[0]}]"#;
    assert_eq!(
        told(&format!("{nodes},{}", meshes(""))),
        (2, "the file has no scene; all its nodes are read".into())
    );
}

#[test]
fn the_first_version_is_refused_by_name() {
    let old = r#"{"asset":{"version":"1.0"},"accessors":{"a":{}},"scene":"s"}"#;
    assert_refused(
        read(old.as_bytes(), Format::Gltf),
        "needs glTF 1, which is not supported",
    );
    assert_refused(
        read(b"glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0", Format::Gltf),
        "needs glTF 1, which",
    );
}
