//! Files that hold no mesh: the message names the file and the place, and nothing is printed. What is wrong with them is the
//! business of `punctual-io`.

use crate::run::{Folder, IDENTITY};
use crate::write;
use punctual::shapes::icosphere;

#[test]
fn bad_meshes_are_refused_by_file_and_line() {
    let (_, mut glb) = write::all_formats(&icosphere(0)).pop().unwrap();
    glb.pop();
    let cases: [(&str, Vec<u8>, &str); 6] = [
        (
            "a.obj",
            b"v 0 0 0\nv 1 0 zero\n".to_vec(),
            "punctual: a.obj:2: `zero` is no number\n",
        ),
        ("a.obj", Vec::new(), "punctual: a.obj: no triangles in it\n"),
        (
            "a.stl",
            b"solid a\n\nfacet\n".to_vec(),
            "punctual: a.stl:3: expected `normal`, found the end of the file\n",
        ),
        (
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex x\n".to_vec(),
            "punctual: a.ply:3: `x` is no number of",
        ),
        ("a.glb", glb, "punctual: a.glb: "),
        (
            "a.step",
            Vec::new(),
            "punctual: a.step: no mesh format by its extension; use one of .obj, .stl, .ply, .off, ",
        ),
    ];
    for (name, content, expected) in cases {
        let folder = Folder::new();
        folder.write(name, content);
        folder.write("good.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        folder.write("poses.txt", IDENTITY);
        for command in [
            format!("pair {name} good.obj poses.txt"),
            format!("pair good.obj {name} poses.txt"),
            format!("info {name}"),
        ] {
            let answer = folder.run(&command);
            answer.assert_refused(&[expected]);
            assert_eq!(answer.err.lines().count(), 1, "{}", answer.err);
        }
    }
}

#[test]
fn absent_files_are_named() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.refused("pair a.obj none.obj poses.txt", &["none.obj: "]);
    folder.refused("pair a.obj a.obj poses.txt", &["poses.txt: "]);
}

/// What is passed over is told in one line a kind, and the answer is that of the file without it.
#[test]
fn ignored_parts_of_files_are_reported() {
    let folder = Folder::new();
    folder.write(
        "a.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\nm_mode 0\nm_mode 1\n",
    );
    folder.write("poses.txt", IDENTITY);
    let notices = [
        "line 4: face of fewer than 3 corners passed over",
        "line 6: unknown statement `m_mode` passed over (2 times)",
    ];
    let info = folder.ok("info a.obj");
    let lines: Vec<&str> = info
        .out
        .lines()
        .take(3)
        .map(|line| line.trim_start_matches("  notice ").trim_start())
        .collect();
    assert_eq!(lines, ["a.obj", notices[0], notices[1]]);
    let answer = folder.run("pair a.obj a.obj poses.txt");
    assert_eq!((answer.status, answer.rows()[0].hit.as_str()), (0, "1"));
    let told = notices
        .map(|notice| notice.replace("line ", "punctual: a.obj:") + "\n")
        .concat();
    assert_eq!(answer.err, told.repeat(2));
}
