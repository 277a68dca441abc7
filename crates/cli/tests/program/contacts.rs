//! `punctual contacts` from outside: its columns, its rows and its messages.

use punctual::glam::{DVec3, Vec3};
use punctual::shapes::cuboid;

use crate::run::{Answer, Folder, IDENTITY};
use crate::write;

const HEADER: &str =
    "pose,kind,patch,triangle_a,triangle_b,ax,ay,az,bx,by,bz,nx,ny,nz,distance,low,ns,stop";

/// One row of the output; what is empty is `None`, or no number.
#[derive(Clone, Debug)]
struct Row {
    pose: usize,
    kind: String,
    patch: Option<u64>,
    triangles: Option<[usize; 2]>,
    points: [DVec3; 2],
    normal: DVec3,
    distance: f64,
    low: f64,
    stop: String,
}

fn rows(answer: &Answer) -> Vec<Row> {
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), HEADER.split(',').count(), "{line}");
        let number = |i: usize| fields[i].parse::<f64>().unwrap_or(f64::NAN);
        let point = |i: usize| DVec3::new(number(i), number(i + 1), number(i + 2));
        fields[16].parse::<u64>().unwrap();
        let ids = [fields[3], fields[4]].map(|id| id.parse().ok());
        Row {
            pose: fields[0].parse().unwrap(),
            kind: fields[1].into(),
            patch: fields[2].parse().ok(),
            triangles: ids[0].zip(ids[1]).map(|(a, b)| [a, b]),
            points: [point(5), point(8)],
            normal: point(11),
            distance: number(14),
            low: number(15),
            stop: fields[17].into(),
        }
    };
    answer.lines(HEADER).map(row).collect()
}

/// Cubes of edge 2: touching, a little apart, no pose, far apart, and a little apart again.
fn cubes() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&cuboid(Vec3::ONE, 2)));
    folder.write("b.obj", write::obj(&cuboid(Vec3::ONE, 2)));
    let at = |x: f64| format!("1 0 0 {x} 0 1 0 0.25 0 0 1 0\n");
    folder.write(
        "poses.txt",
        format!("{}{}1 0 0\n{}{}", at(2.0), at(2.01), at(9.0), at(2.01)),
    );
    folder
}

fn of(rows: &[Row], pose: usize, kind: &str) -> Vec<Row> {
    rows.iter()
        .filter(|row| (row.pose, row.kind.as_str()) == (pose, kind))
        .cloned()
        .collect()
}

#[test]
fn contacts_and_patches_of_cubes() {
    let folder = cubes();
    for options in [
        "",
        "--reps 3",
        "--portable",
        "--memory",
        "--budget-work 100000000",
    ] {
        let answer = folder.run(&format!(
            "contacts a.obj b.obj poses.txt --margin 0.02 {options}"
        ));
        assert_eq!(answer.status, 1, "{}", answer.err);
        answer.tells("poses.txt:3: pose 2: ");
        assert_eq!(answer.err.lines().count(), 1);
        let rows = rows(&answer);
        for pose in [0, 1, 4] {
            let (contacts, patches) = (of(&rows, pose, "contact"), of(&rows, pose, "patch"));
            assert!(
                contacts.len() > 8 && contacts.is_sorted_by(|x, y| x.distance <= y.distance),
                "{rows:?}"
            );
            // Faces that touch are one piece, as those that are apart.
            assert_eq!(patches.len(), 1);
            for patch in &patches {
                assert!((patch.normal - DVec3::NEG_X).length() < 1e-9);
                assert!(patch.triangles.is_none() && patch.low == f64::INFINITY);
                assert!((patch.points[0].y - 0.125).abs() < 1e-9, "{patch:?}");
            }
            for row in &contacts {
                assert_eq!((row.low, row.stop.as_str()), (f64::INFINITY, "finished"));
                assert!(patches.iter().any(|patch| patch.patch == row.patch));
                assert!(row.triangles.is_some() && (row.normal.length() - 1.0).abs() < 1e-12);
                let [p, q] = row.points;
                let is_apart = row.distance > 0.0;
                assert!(
                    !is_apart || (p.distance(q) - row.distance).abs() < 1e-12,
                    "{row:?}"
                );
                assert!(
                    is_apart || (p.x - 1.0).abs() < 1e-12 && (q.x - 1.0).abs() < 1e-12,
                    "{row:?}"
                );
            }
            let least = if pose == 0 {
                0.0..=0.0
            } else {
                0.01..=0.01 + 1e-12
            };
            assert!(
                least.contains(&contacts[0].distance)
                    || (contacts[0].distance - 0.01).abs() < 1e-12
            );
            assert!((patches[0].distance - contacts[0].distance).abs() < 1e-12);
        }
        assert_eq!(of(&rows, 2, "")[0].stop, "error");
        let far = of(&rows, 3, "none");
        assert!(far.len() == 1 && far[0].low == f64::INFINITY && far[0].patch.is_none());
        // Numbers of patches go on only with a memory, and the body was away in between.
        let ids = [0, 1, 4].map(|pose| of(&rows, pose, "patch").pop().unwrap().patch.unwrap());
        let lasting = if options == "--memory" {
            [0, 0, 1]
        } else {
            [0, 0, 0]
        };
        assert_eq!(ids, lasting);
    }
}

#[test]
fn budgets_and_limits_end_a_query() {
    let folder = cubes();
    let run = |options: &str| {
        rows(&folder.run(&format!(
            "contacts a.obj b.obj poses.txt --margin 0.02 {options}"
        )))
    };
    let cut = run("--budget-work 0");
    for pose in [0, 1, 3, 4] {
        let none = of(&cut, pose, "none");
        assert_eq!(
            (none.len(), none[0].low, none[0].stop.as_str()),
            (1, 0.0, "work-limit")
        );
    }
    let few = run("--max 3");
    for pose in [0, 1, 4] {
        let contacts = of(&few, pose, "contact");
        assert!(
            contacts.len() == 3
                && contacts
                    .iter()
                    .all(|row| row.stop == "pairs-full" && row.low < 0.02)
        );
    }
    let timed = run("--budget-us 1000000");
    assert!(
        timed
            .iter()
            .all(|row| row.stop == "finished" || row.stop == "error")
    );
}

/// More contacts than there is room for at first.
#[test]
fn more_contacts_than_the_workspace_holds_are_all_printed() {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&cuboid(Vec3::ONE, 3)));
    folder.write("poses.txt", IDENTITY);
    let rows = rows(&folder.run("contacts a.obj a.obj poses.txt --margin 100"));
    assert_eq!(
        of(&rows, 0, "contact").len(),
        cuboid(Vec3::ONE, 3).len().pow(2)
    );
}

#[test]
fn bad_options_of_contacts_are_refused() {
    let folder = cubes();
    folder.refuses(
        "contacts a.obj b.obj poses.txt",
        &[
            ("--margin -1", "--margin must be"),
            ("--margin nan", "--margin must be"),
            ("--margin inf", "--margin must be"),
            ("--margin x", "--margin must be"),
            ("--max 0", "--max"),
            ("--reps 0", "--reps"),
            ("--budget-us 1 --budget-work 1", "cannot be used"),
        ],
    );
    folder.refuses("contacts a.obj", &[("none.obj poses.txt", "none.obj:")]);
}

#[test]
fn pushes_of_cubes() {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&cuboid(Vec3::ONE, 2)));
    folder.write("b.obj", write::obj(&cuboid(Vec3::ONE, 2)));
    folder.write(
        "poses.txt",
        "1 0 0 1.9 0 1 0 .25 0 0 1 0\n1 0 0 9 0 1 0 0 0 0 1 0\n",
    );
    let push = |options: &str| {
        let answer = folder.ok(&format!("contacts a.obj b.obj poses.txt --push {options}"));
        let rows = rows(&answer);
        [0, 1]
            .map(|pose| of(&rows, pose, "push").try_into().unwrap())
            .map(|[row]: [Row; 1]| row)
    };
    for options in [
        "",
        "--reps 2",
        "--portable --memory",
        "--budget-work 100000000",
    ] {
        let [meets, apart] = push(options);
        assert!(
            (0.1..0.1 + 1e-6).contains(&meets.distance)
                && (meets.normal - DVec3::X).length() < 1e-6,
            "{meets:?}"
        );
        assert_eq!((apart.distance, apart.normal), (0.0, DVec3::X));
        for row in [meets, apart] {
            assert!(
                row.stop == "finished"
                    && row.patch.is_none()
                    && row.triangles.is_none()
                    && row.low.is_nan()
            );
        }
    }
    let [cut, _] = push("--budget-work 0");
    assert!(
        cut.stop == "work-limit" && cut.distance.is_nan() && cut.normal.is_nan(),
        "{cut:?}"
    );
}

#[test]
fn contacts_of_solids_print_their_overlaps() {
    let folder = Folder::new();
    folder.write(
        "floor.obj",
        write::obj(&cuboid(Vec3::new(5.0, 5.0, 1.0), 1)),
    );
    folder.write("crate.obj", write::obj(&cuboid(Vec3::ONE, 2)));
    let at = |z: f64| format!("1 0 0 0.5 0 1 0 0.25 0 0 1 {z}\n");
    folder.write(
        "poses.txt",
        format!("{}1 0 0\n{}{}", at(1.75), at(2.01), at(1.5)),
    );
    for options in ["", "--reps 2", "--margin 0.02", "--budget-work 100000000"] {
        let answer = folder.run(&format!(
            "contacts floor.obj crate.obj poses.txt --solid --memory {options}"
        ));
        let rows = rows(&answer);
        for (pose, depth) in [(0, 0.25), (3, 0.5)] {
            let overlaps = of(&rows, pose, "overlap");
            assert_eq!(overlaps.len(), 4, "{options}");
            for row in &overlaps {
                assert!((row.distance + depth).abs() < 1e-9, "{options}: {row:?}");
                assert!((row.normal + DVec3::Z).length() < 1e-9, "{options}");
                let between = row.points[0] - row.points[1];
                assert!((between - row.distance * row.normal).length() < 1e-9);
                assert!(row.patch == overlaps[0].patch && row.stop == "finished");
                assert!(row.low == f64::INFINITY && row.triangles.is_none());
            }
            assert!(!of(&rows, pose, "contact").is_empty());
        }
        assert!(of(&rows, 2, "overlap").is_empty(), "{options}");
    }
    let without = folder.run("contacts floor.obj crate.obj poses.txt");
    assert!(rows(&without).iter().all(|row| row.kind != "overlap"));

    folder.write("pebble.obj", write::obj(&cuboid(Vec3::splat(0.1), 1)));
    folder.write("poses.txt", format!("{}{}", at(0.5), at(1.2)));
    for (meshes, inner) in [("floor.obj pebble.obj", "b"), ("pebble.obj floor.obj", "a")] {
        let answer = folder.run(&format!("contacts {meshes} poses.txt --solid"));
        let lines: Vec<&str> = answer
            .out
            .lines()
            .filter(|l| l.contains("contained"))
            .collect();
        let [line] = lines[..] else {
            panic!("{lines:?}")
        };
        assert!(line.starts_with(&format!("0,contained,{inner},")), "{line}");
        assert_eq!(line.split(',').count(), 18, "{line}");
    }
    let without = folder.run("contacts floor.obj pebble.obj poses.txt");
    assert!(!without.out.contains("contained"));
}
