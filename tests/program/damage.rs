//! Files that hold no mesh: every message names the file and, where there are lines, the line. And files that look
//! odd but do hold one.

use crate::run::{Folder, IDENTITY};
use crate::write;
use punctual::shapes::icosphere;

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                   endsolid a\n";

/// The message about a mesh file that must be refused, by both subcommands that read meshes.
fn message(name: &str, content: &[u8]) -> String {
    let folder = Folder::new();
    folder.write(name, content);
    folder.write("good.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("poses.txt", IDENTITY);
    for meshes in [format!("{name} good.obj"), format!("good.obj {name}")] {
        folder.run(&format!("pair {meshes} poses.txt")).assert_refused(&[name]);
    }
    let answer = folder.run(&format!("info {name}"));
    answer.assert_refused(&[]);
    assert_eq!(answer.err.lines().count(), 1, "{}", answer.err);
    answer.err
}

#[test]
fn text_formats_name_the_line() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let cases: [(&str, String, &str); 21] = [
        ("a.obj", "v 0 0 0\nv 1 0 zero\n".into(), "a.obj:2: `zero` is no number"),
        ("a.obj", "v 0 0 0\r\nv 1 0\r\n".into(), "a.obj:2: vertex of 2 coordinates"),
        ("a.obj", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r".into(), "a.obj:1: "),
        ("a.obj", format!("{obj}f 1 2 4\n"), "a.obj:4: vertex index 4 is out of range: 3 vertices"),
        ("a.obj", format!("f 1 2 4\n{obj}"), "a.obj:1: vertex index 4 is out of range: 3 vertices"),
        ("a.obj", format!("{obj}f 1 2 -4\n"), "a.obj:4: vertex index -4 is out of range"),
        ("a.obj", format!("{obj}f 0 1 2\n"), "a.obj:4: vertex index 0 is out of range"),
        ("a.obj", format!("{obj}f 1 2 99999999999\n"), "a.obj:4: vertex index 99999999999 is out of range"),
        ("a.obj", format!("{obj}f 1 2 -9223372036854775808\n"), "a.obj:4: vertex index -9223372036854775808 is"),
        ("a.obj", format!("{obj}f 1 2 x/1\n"), "a.obj:4: `x/1` is no vertex index"),
        ("a.obj", format!("{obj}f 1 \\\n 2\n"), "a.obj:4: face of 2 corners"),
        ("a.obj", format!("{obj}#\nsurf 0 1 0 1\n"), "a.obj:5: unknown statement `surf`"),
        (
            "a.obj",
            format!("v 9 9 9\n{obj}v 0 nan 0\nf 2 3 4\nf 2 3 5\n"),
            "a.obj:5: vertex 4 is not finite along axis 1",
        ),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1e999\nf 1 2 3\n".into(), "a.obj:3: vertex 2 is not finite along axis 2"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 1e308 0 0\nf 1 2 3\n".into(), "a.obj:3: vertex 2 exceeds 2^1000 along axis 0"),
        ("a.stl", STL.replace("1 0 0", "1 0 x"), "a.stl:5: "),
        ("a.stl", format!("{STL}\n{}", STL.replace("endloop", "endlop")), "a.stl:17: "),
        ("a.stl", format!("{STL}facet"), "a.stl:10: expected `solid`"),
        ("a.ply", format!("{PLY}0 0 0\n1 0 0\n0 one 0\n3 0 1 2\n"), "a.ply:12: "),
        ("a.ply", format!("{PLY}0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "a.ply:13: vertex index 3 is out of range"),
        ("a.ply", format!("{PLY}0 0 0\n1 0 0\n1e999 1 0\n3 0 1 2\n"), "a.ply:12: vertex 2 is not finite"),
    ];
    for (name, content, expected) in cases {
        let message = message(name, content.as_bytes());
        assert!(message.contains(expected), "`{expected}` is not in: {message}");
    }
}

#[test]
fn other_faults_name_the_file() {
    let nan = f32::NAN.to_le_bytes();
    let mut stl = vec![0; 84 + 50];
    stl[80] = 1;
    stl[84 + 12..84 + 16].copy_from_slice(&nan);
    let cut = |format: &str| {
        let formats = write::all_formats(&icosphere(0));
        let (_, bytes) = formats.into_iter().find(|(name, _)| *name == format).unwrap();
        bytes[..bytes.len() - 1].to_vec()
    };
    let cases: [(&str, Vec<u8>, &str); 13] = [
        ("a.stl", stl, "vertex 0 is not finite along axis 0 (counted from 0, in use by triangle 0)"),
        ("a.stl", cut("binary.STL"), "binary STL of 20 triangles has 1084 bytes, this file has 1083"),
        ("a.stl", Vec::new(), "0 bytes"),
        ("a.ply", cut("little.ply"), "end of file"),
        ("a.ply", cut("big.Ply"), "end of file"),
        ("a.ply", PLY.replace("face 1", "face 99999999999999").into(), "do not fit"),
        ("a.ply", PLY.replace("double z", "double w").into(), "x, y and z"),
        ("a.ply", PLY.replace("face", "tristrips").into(), "`face`"),
        ("a.glb", cut("sphere.glb"), "a.glb: "),
        ("a.glb", b"glTF\x02\0\0\0\0\0\0\0".to_vec(), "header is damaged"),
        ("a.glb", write::pack_glb(r#"{"asset":{"version":"2.0"}}"#, &[]), "no scene"),
        ("a.gltf", Vec::new(), ".glb"),
        ("a.off", Vec::new(), ".obj, .stl, .ply or .glb"),
    ];
    for (name, content, expected) in cases {
        let message = message(name, &content);
        assert!(message.contains(expected), "`{expected}` is not in: {message}");
    }
    let folder = Folder::new();
    folder.write("a.obj", "");
    folder.run("pair a.obj none.obj poses.txt").assert_refused(&["none.obj: "]);
    folder.run("pair a.obj a.obj poses.txt").assert_refused(&["poses.txt: "]);
}

#[test]
fn glb_outside_its_buffer_or_its_tree_is_refused() {
    let document = |accessor: &str, node: &str, attribute: &str| {
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{node}}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":{attribute}}}}}]}}],"buffers":[{{"byteLength":36}}],
            "accessors":[{{"bufferView":0,"type":"VEC3","min":[0,0,0],"max":[1,1,1]{accessor}}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}]}}"#
        );
        write::pack_glb(&json, &[0; 36])
    };
    let good = r#","componentType":5126,"count":3"#;
    let cases = [
        (document(r#","componentType":5126,"count":4"#, "", "0"), "outside"),
        (document(r#","componentType":5126,"count":18446744073709551615"#, "", "0"), "outside"),
        (document(&format!(r#"{good},"byteOffset":18446744073709551615"#), "", "0"), "outside"),
        (document(r#","componentType":5123,"count":3"#, "", "0"), "three f32"),
        (document(good, r#","children":[0]"#, "0"), "no tree"),
        (document(good, r#","translation":[1e999,0,0]"#, "0"), "a.glb: "),
        (document(good, "", "1"), "accessor 1 does not exist"),
    ];
    for (bytes, expected) in cases {
        let message = message("a.glb", &bytes);
        assert!(message.contains(expected), "`{expected}` is not in: {message}");
    }
}

#[test]
fn truncated_and_changed_files_never_panic() {
    let folder = Folder::new();
    for (name, bytes) in write::all_formats(&icosphere(0)) {
        for (step, at) in (0..bytes.len()).step_by(bytes.len() / 40).enumerate() {
            folder.write(name, &bytes[..at]);
            let cut = folder.run(&format!("info {name}"));
            let mut changed = bytes.clone();
            changed[at] ^= 1 << (step % 8);
            folder.write(name, changed);
            for answer in [cut, folder.run(&format!("info {name}"))] {
                assert!(answer.status == 0 || answer.status == 2);
                assert!(answer.status == 0 || answer.err.contains(name), "{}", answer.err);
            }
        }
    }
}

/// Files of one triangle, or of a square where said, and how many triangles they must give.
#[test]
fn odd_but_valid_files_are_read() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    let cases: [(&str, String, &str); 13] = [
        ("a.obj", String::new(), "0"),
        ("a.obj", "v 0 0 0\nv 1 0 0\n".into(), "0"),
        ("a.obj", "v nan 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4".into(), "1"),
        ("a.obj", format!("{square}f 1 2 3 4\n"), "2"),
        ("a.obj", format!("{square}f -4/1/1 -3//2 -2/3 -1\n"), "2"),
        ("a.obj", format!("\u{feff}mtllib C:\\\n# a \\\n{}f 1 \\\r\n 2 3\r\n", square.replace('\n', "\r\n")), "1"),
        ("a.obj", format!("o x\nvn 0 0 1\nvt 0 0\ns off\n{square}v 0 0 1 1 0.5 0.5 0.5\ng\nl 1 2\nf 1 2 5\n"), "1"),
        ("a.stl", STL.to_uppercase().replace('\n', "\r\n"), "1"),
        ("a.stl", format!("{STL}\n\n{STL}"), "2"),
        ("a.stl", "solid nothing\nendsolid nothing\n".into(), "0"),
        ("a.ply", format!("{PLY}{points}3 0 1 2\n\n"), "1"),
        ("a.ply", PLY.replace("face 1", "face 0") + points, "0"),
        ("a.ply", PLY.replace("indices", "index").replace('\n', "\r\n") + points + "4 0 1 2 1\n", "2"),
    ];
    for (name, content, count) in cases {
        let folder = Folder::new();
        folder.write(name, &content);
        let answer = folder.run(&format!("info {name}"));
        assert_eq!(answer.status, 0, "{}{content}", answer.err);
        let line = answer.out.lines().find(|line| line.trim_start().starts_with("triangles")).unwrap();
        assert_eq!(line.split_whitespace().last(), Some(count), "{content}");
    }
}

/// f32 would make one plane of the two.
#[test]
fn coordinates_reach_the_last_bit() {
    let folder = Folder::new();
    folder.write("poses.txt", IDENTITY);
    let obj = |z: &str| format!("v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf 1 2 3\n");
    let ply = |z: &str| format!("{PLY}0 0 {z}\n1 0 {z}\n0 1 {z}\n3 0 1 2\n");
    for (z, hit) in [("0.1", "1"), ("0.1000000000000000055", "1"), ("0.10000000000000002", "0")] {
        folder.write("a.obj", obj("0.1"));
        folder.write("b.obj", obj(z));
        folder.write("b.ply", ply(z));
        for b in ["b.obj", "b.ply"] {
            assert_eq!(folder.run(&format!("pair a.obj {b} poses.txt")).rows()[0].hit, hit, "{z}");
        }
    }
}
