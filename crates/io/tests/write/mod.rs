//! The same surface in every format the program reads.

use std::fmt::Write;

use base64::Engine;
use punctual::Mesh;

/// File name and content, one for each format and encoding.
pub fn all_formats(mesh: &Mesh) -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("sphere.obj", obj(mesh)),
        ("ascii.stl", ascii_stl(mesh)),
        ("binary.STL", binary_stl(mesh)),
        ("ascii.ply", ply(mesh, "ascii")),
        ("little.ply", ply(mesh, "binary_little_endian")),
        ("big.Ply", ply(mesh, "binary_big_endian")),
        ("sphere.off", off(mesh)),
        ("text.gltf", gltf(mesh)),
        ("sphere.DAE", collada(mesh)),
        ("sphere.glb", glb(mesh)),
    ]
}

fn vertices(mesh: &Mesh) -> impl Iterator<Item = [f32; 3]> {
    (0..mesh.vertex_count()).map(|i| mesh.vertex(i).as_vec3().to_array())
}

fn triangles(mesh: &Mesh) -> impl Iterator<Item = [[f32; 3]; 3]> {
    (0..mesh.len()).map(|i| mesh.triangle(i).map(|corner| corner.as_vec3().to_array()))
}

fn floats(values: &[f32]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

pub fn obj(mesh: &Mesh) -> Vec<u8> {
    let mut text = String::new();
    // As f64: the shortest text of an f32 is another f64.
    for [x, y, z] in vertices(mesh).map(|v| v.map(f64::from)) {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for [a, b, c] in mesh.triangles() {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    text.into_bytes()
}

fn collada(mesh: &Mesh) -> Vec<u8> {
    let points = vertices(mesh)
        .flatten()
        .map(|x| format!("{} ", f64::from(x)));
    let corners = mesh
        .triangles()
        .as_flattened()
        .iter()
        .map(|i| format!("{i} "));
    let (points, corners): (String, String) = (points.collect(), corners.collect());
    format!(
        "<?xml version=\"1.0\"?><COLLADA><library_geometries><geometry id=\"g\"><mesh><source id=\"p\">\
         <float_array id=\"f\">{points}</float_array><technique_common><accessor source=\"#f\" stride=\"3\"/>\
         </technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\
         <triangles><input semantic=\"VERTEX\" offset=\"0\" source=\"#v\"/><p>{corners}</p></triangles></mesh>\
         </geometry></library_geometries><library_visual_scenes><visual_scene><node>\
         <instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes></COLLADA>"
    )
    .into_bytes()
}

fn ascii_stl(mesh: &Mesh) -> Vec<u8> {
    let mut text = String::from("solid\n");
    for corners in triangles(mesh) {
        text.push_str("  facet normal nan nan nan\n    outer loop\n");
        for [x, y, z] in corners {
            writeln!(text, "      vertex {x} {y} {z}").unwrap();
        }
        text.push_str("    endloop\n  endfacet\n");
    }
    text.push_str("endsolid\n");
    text.into_bytes()
}

/// With a header that looks like ASCII, as many programs write it.
fn binary_stl(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = format!("{:<80}", "solid written by a program").into_bytes();
    bytes.extend(u32::try_from(mesh.len()).unwrap().to_le_bytes());
    for corners in triangles(mesh) {
        bytes.extend(floats(&[0.0; 3]));
        bytes.extend(floats(corners.as_flattened()));
        bytes.extend([0, 0]);
    }
    bytes
}

fn ply(mesh: &Mesh, format: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment a sphere\nelement vertex {}\nproperty uchar red\n\
         property float x\nproperty float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        mesh.vertex_count(),
        mesh.len()
    )
    .into_bytes();
    for v in vertices(mesh) {
        match format {
            "ascii" => bytes.extend(format!("255 {} {} {}\n", v[0], v[1], v[2]).bytes()),
            "binary_little_endian" => bytes.extend([255].into_iter().chain(floats(&v))),
            _ => bytes.extend(
                [255]
                    .into_iter()
                    .chain(v.into_iter().flat_map(f32::to_be_bytes)),
            ),
        }
    }
    for t in mesh.triangles() {
        match format {
            "ascii" => bytes.extend(format!("3 {} {} {}\n", t[0], t[1], t[2]).bytes()),
            "binary_little_endian" => bytes.extend(
                [3].into_iter()
                    .chain(t.iter().flat_map(|i| i.to_le_bytes())),
            ),
            _ => bytes.extend(
                [3].into_iter()
                    .chain(t.iter().flat_map(|i| i.to_be_bytes())),
            ),
        }
    }
    bytes
}

fn off(mesh: &Mesh) -> Vec<u8> {
    let mut text = format!("OFF\n{} {} 0\n", mesh.vertex_count(), mesh.len());
    for [x, y, z] in vertices(mesh).map(|v| v.map(f64::from)) {
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    for [a, b, c] in mesh.triangles() {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

fn glb(mesh: &Mesh) -> Vec<u8> {
    let (json, buffer) = document(mesh, "");
    pack_glb(&json, &buffer)
}

/// JSON text with the buffer in it.
fn gltf(mesh: &Mesh) -> Vec<u8> {
    let (_, buffer) = document(mesh, "");
    let data = base64::engine::general_purpose::STANDARD.encode(buffer);
    document(
        mesh,
        &format!(r#","uri":"data:application/octet-stream;base64,{data}""#),
    )
    .0
    .into_bytes()
}

/// The file holds the sphere moved and halved; two nodes bring it back.
fn document(mesh: &Mesh, address: &str) -> (String, Vec<u8>) {
    let mut buffer = Vec::new();
    for [x, y, z] in vertices(mesh) {
        // Turned by a quarter around z, then halved: both exact.
        buffer.extend(floats(&[y / 2.0, -x / 2.0, z / 2.0]));
    }
    let indices_at = buffer.len();
    for t in mesh.triangles() {
        buffer.extend(t.iter().flat_map(|i| i.to_le_bytes()));
    }
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[1]}}],
        "nodes":[{{"mesh":0,"scale":[2,2,2]}},{{"children":[0],"matrix":[0,1,0,0,-1,0,0,0,0,0,1,0,0,0,0,1]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]}},
        {{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{indices_at}}},
        {{"buffer":0,"byteOffset":{indices_at},"byteLength":{}}}],"buffers":[{{"byteLength":{}{address}}}]}}"#,
        mesh.vertex_count(),
        3 * mesh.len(),
        buffer.len() - indices_at,
        buffer.len()
    );
    (json, buffer)
}

pub fn pack_glb(json: &str, buffer: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(word(28 + json.len() + buffer.len()));
    bytes.extend(word(json.len()).into_iter().chain(*b"JSON").chain(json));
    bytes.extend(
        word(buffer.len())
            .into_iter()
            .chain(*b"BIN\0")
            .chain(buffer.iter().copied()),
    );
    bytes
}
