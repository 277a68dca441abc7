//! `punctual inside` from outside: its columns, its messages, points that are known.

use punctual::shapes::cuboid;

use crate::run::Folder;
use crate::write;

const HEADER: &str = "point,winding,inside,low,high,ns,stop";

fn cube(scale: f64) -> Folder {
    let folder = Folder::new();
    let mut mesh = String::from_utf8(write::obj(&cuboid([1.0; 3], 2))).unwrap();
    if scale < 0.0 {
        // Mirrored, and so inside out.
        mesh = mesh
            .lines()
            .map(|line| match line.strip_prefix("v ") {
                Some(rest) => {
                    let (x, rest) = rest.split_once(' ').unwrap();
                    format!("v {} {rest}\n", -x.parse::<f64>().unwrap())
                }
                None => format!("{line}\n"),
            })
            .collect();
    }
    folder.write("a.obj", mesh);
    let lines = [
        "0 0 0.25 # inside",
        "0 3 0",
        "1 0.5 0.5",
        "1 2",
        "1e400 0 0",
        "1 1 1",
    ];
    folder.write("points.txt", lines.join("\n"));
    folder
}

/// What the lines say but for the time, and what the program complains of.
fn said(folder: &Folder, options: &str) -> (Vec<String>, String) {
    let answer = folder.run(&format!("inside a.obj points.txt {options}"));
    assert_eq!(answer.status, 1, "{options}: {}", answer.err);
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        assert!(
            fields.len() == 7 && fields[5].parse::<u64>().is_ok(),
            "{line}"
        );
        [1, 2, 3, 4, 6].map(|i: usize| fields[i]).join(",")
    };
    (answer.lines(HEADER).map(row).collect(), answer.err)
}

#[test]
fn points_of_a_cube() {
    for options in ["", "--reps 2", "--portable", "--flip"] {
        let (rows, err) = said(&cube(1.0), options);
        assert!(err.contains("points.txt:4: point 3") && err.contains("points.txt:5: point 4"));
        assert!(!err.contains("inside out"));
        let near = |row: &str, start: &str, bounds: f64| {
            let fields: Vec<&str> = row.split(',').collect();
            assert!(
                row.starts_with(start) && row.ends_with(",finished"),
                "{row}"
            );
            let [low, high] = [2, 3].map(|i| fields[i].parse::<f64>().unwrap());
            assert!(
                low <= bounds && bounds <= high && high - low < 1e-12,
                "{row}"
            );
        };
        near(&rows[0], "1,yes,", -0.75);
        near(&rows[1], "0,no,", 2.0);
        assert!(rows[2].ends_with(",yes,0,0,finished"), "{}", rows[2]);
        assert_eq!(rows[3..5], [",,,,error", ",,,,error"]);
        assert!(rows[5].ends_with(",yes,0,0,finished"), "{}", rows[5]);
    }
}

#[test]
fn inside_out_components_are_named_or_reversed() {
    let folder = cube(-1.0);
    let (rows, err) = said(&folder, "");
    assert!(
        err.contains("a.obj: the part of triangle 0 is inside out"),
        "{err}"
    );
    assert!(rows[0].starts_with("-1,no,"), "{}", rows[0]);
    let (rows, err) = said(&folder, "--flip");
    assert!(!err.contains("inside out"));
    assert!(rows[0].starts_with("1,yes,"), "{}", rows[0]);
}

#[test]
fn a_budget_leaves_points_undecided_and_bounds_true() {
    let folder = cube(1.0);
    let (rows, _) = said(&folder, "--budget-work 1");
    let fields: Vec<&str> = rows[0].split(',').collect();
    assert_eq!(
        (fields[0], fields[1], fields[4]),
        ("nan", "undecided", "work-limit")
    );
    let [low, high] = [2, 3].map(|i| fields[i].parse::<f64>().unwrap());
    assert!(low <= -0.75 && high >= 0.75);
    let (rows, _) = said(&folder, "--budget-us 1000000");
    assert!(rows[0].ends_with(",finished"));
}
