//! Shapes and point clouds in place of mesh files.

use crate::run::Folder;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("scan.xyz", "0 0 2\n0.5 0 2\n0 0.25 3 # far\n");
    let shift = |x: f64| format!("1 0 0 {x} 0 1 0 0 0 0 1 0\n");
    folder.write("poses.txt", [0.0, 1.25, 4.0].map(shift).concat());
    folder.write("points.txt", "0 0 0\n0 0 2\n");
    folder.write("rays.txt", "0 0 9 0 0 -1\n");
    let there = shift(4.0);
    folder.write("sweeps.txt", format!("{} -4 0 0\n", there.trim_end()));
    folder
}

/// A column of the rows that follow the header.
fn column(folder: &Folder, call: &str, name: &str) -> Vec<String> {
    let answer = folder.run(call);
    assert!(answer.status == 0 && answer.err.is_empty(), "{call}");
    let mut lines = answer.out.lines().skip_while(|line| line.starts_with('#'));
    let header = lines.next().unwrap();
    let at = header.split(',').position(|column| column == name).unwrap();
    let cell = |line: &str| line.split(',').nth(at).unwrap().to_owned();
    lines.map(cell).collect()
}

#[test]
fn distances_of_shapes_and_clouds() {
    let folder = folder();
    for (operands, distances) in [
        ("ball:0.5 ball:0.25", [0.0, 0.5, 3.25]),
        ("capsule:0.5,4 box:1,1,1", [0.0, 0.25, 3.0]),
        ("cylinder:0.5,1 cone:0.25,1", [0.0, 0.5, 3.25]),
        (
            "scan.xyz ball:0.5",
            [1.5, 0.75f64.hypot(2.0) - 0.5, 3.5f64.hypot(2.0) - 0.5],
        ),
        (
            "thick:0.5,scan.xyz thick:0.5,ball:0.5",
            [1.0, 0.75f64.hypot(2.0) - 1.0, 3.5f64.hypot(2.0) - 1.0],
        ),
    ] {
        let call = format!("distance {operands} poses.txt");
        for (found, distance) in column(&folder, &call, "high").iter().zip(distances) {
            let found: f64 = found.parse().unwrap();
            assert!((found - distance).abs() < 1e-3, "{operands}");
        }
        let call = format!("pair {operands} poses.txt");
        let hits = distances.map(|distance| u8::from(distance == 0.0).to_string());
        assert_eq!(column(&folder, &call, "hit"), hits, "{operands}");
    }
}

#[test]
fn all_questions_take_them() {
    let folder = folder();
    assert_eq!(
        column(&folder, "inside ball:1 points.txt", "inside"),
        ["yes", "no"]
    );
    let t = column(&folder, "rays thick:0.5,scan.xyz rays.txt", "t");
    assert!(
        (t[0].parse::<f64>().unwrap() - 5.566_987).abs() < 1e-5,
        "{t:?}"
    );
    let free = column(&folder, "motion ball:1 ball:1 sweeps.txt", "free_until");
    assert!(
        (free[0].parse::<f64>().unwrap() - 0.5).abs() < 1e-3,
        "{free:?}"
    );
    assert_eq!(folder.run("contacts scan.xyz ball:2.5 poses.txt").status, 0);
    assert_eq!(
        folder
            .run("pair scan.xyz box:1,1,1 poses.txt --view page.html")
            .status,
        0
    );
    assert!(folder.read("page.html").contains("scan.xyz"));
    assert_eq!(folder.run("poses scan.xyz ball:1 --random 3").status, 0);
}

#[test]
fn faults_name_the_operand() {
    let known = "must be ball:R, capsule:R,L, box:X,Y,Z, cylinder:R,L or cone:R,L";
    folder().refuses(
        "distance",
        &[
            ("ball:x ball:1 poses.txt", &format!("ball:x: {known}")),
            ("ball:1 box:1,1 poses.txt", &format!("box:1,1: {known}")),
            ("ball:1 cone:1,-2 poses.txt", "cone:1,-2: length is -2.0"),
            ("thick:1 ball:1 poses.txt", "thick:1: must be thick:R,FILE"),
            (
                "thick:-1,scan.xyz ball:1 poses.txt",
                "thick:-1,scan.xyz: radius",
            ),
            ("thick:1,no.xyz ball:1 poses.txt", "no.xyz:"),
            ("no:1 ball:1 poses.txt", "no:1:"),
        ],
    );
    folder().refuses(
        "inside",
        &[("scan.xyz points.txt", "scan.xyz: points have no inside")],
    );
}
