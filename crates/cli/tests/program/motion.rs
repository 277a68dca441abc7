//! `punctual motion` from outside: its columns, its messages, times that are known.

use punctual::glam::Vec3;
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::shapes::cuboid;

use crate::run::{Answer, Folder};
use crate::write;

const HEADER: &str = "sweep,free_until,touching_at,triangle_a,triangle_b,ns,stop,work";

#[derive(Clone, Debug, PartialEq)]
struct Row {
    free_until: f64,
    touching_at: Option<f64>,
    stop: String,
    work: u64,
}

impl Row {
    fn new(fields: &[&str]) -> Self {
        fields[4].parse::<u64>().unwrap();
        let touching_at = (!fields[1].is_empty()).then(|| fields[1].parse().unwrap());
        let are_named = fields[2..4].iter().all(|id| id.parse::<u32>().is_ok());
        assert_eq!(are_named, touching_at.is_some(), "{fields:?}");
        let row = Self {
            free_until: fields[0].parse().unwrap(),
            touching_at,
            stop: fields[5].into(),
            work: fields[6].parse().unwrap(),
        };
        assert!(
            0.0 <= row.free_until && row.free_until <= row.touching_at.unwrap_or(1.0),
            "{fields:?}"
        );
        row
    }
}

fn rows(answer: &Answer) -> Vec<Option<Row>> {
    let rows = answer.table(HEADER).into_iter();
    rows.map(|row| row.map(|fields| Row::new(&fields)))
        .collect()
}

/// Cubes of edge 2: B comes from the right, starts in contact, stops short, goes on a screw of no turn and of half a turn.
fn cubes() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&cuboid(Vec3::ONE, 3)));
    folder.write("b.obj", write::obj(&cuboid(Vec3::ONE, 2)));
    let at = |x: f64| format!("1 0 0 {x} 0 1 0 0 0 0 1 0");
    let turned = "-1 0 0 4 0 -1 0 0 0 0 1 0";
    let lines = [
        format!("{} -4 0 0", at(4.0)),
        format!("{} -4 0 0 # they touch", at(2.0)),
        format!("{} -1.5 0 0", at(4.0)),
        "1 0 0".into(),
        format!("{} {}", at(4.0), at(0.0)),
        format!("{} {turned}", at(4.0)),
    ];
    folder.write("sweeps.txt", lines.join("\n"));
    folder
}

fn ask(folder: &Folder, options: &str) -> Vec<Row> {
    let answer = folder.run(&format!("motion a.obj b.obj sweeps.txt {options}"));
    assert_eq!(answer.status, 1, "{options}: {}", answer.err);
    answer.tells("sweeps.txt:4: sweep 3: ");
    assert_eq!(answer.err.lines().count(), 1);
    let rows = rows(&answer);
    assert_eq!(
        rows.iter().map(Option::is_some).collect::<Vec<_>>(),
        [true, true, true, false, true, true]
    );
    rows.into_iter().flatten().collect()
}

#[test]
fn times_of_cubes() {
    let folder = cubes();
    for options in [
        "",
        "--tolerance 0",
        "--tolerance 1e-3",
        "--memory --reps 2",
        "--portable",
        "--margin 0.25",
    ] {
        let rows = ask(&folder, options);
        let margin = if options.contains("margin") {
            0.125
        } else {
            0.0
        };
        let tolerance = if options.contains("1e-3") { 1e-3 } else { 4e-6 };
        for (row, time) in [(&rows[0], 0.5 - margin), (&rows[3], 0.5 - margin)] {
            let touching = row.touching_at.unwrap();
            assert!(
                row.free_until <= time && time <= touching + 1e-15,
                "{options}: {row:?}"
            );
            assert!(
                (touching - row.free_until) * 4.0 <= tolerance && row.stop == "finished",
                "{options}: {row:?}"
            );
        }
        assert_eq!((rows[1].free_until, rows[1].touching_at), (0.0, Some(0.0)));
        for free in [&rows[2], &rows[4]] {
            let is_free = (free.free_until, free.touching_at) == (1.0, None);
            assert_eq!(is_free, margin == 0.0 || free == &rows[4], "{options}");
        }
    }
}

#[test]
fn budgets_are_kept() {
    let folder = cubes();
    let whole = ask(&folder, "");
    for budget in [0, 100, 1_000, 3_000] {
        let rows = ask(&folder, &format!("--budget-work {budget}"));
        for (row, whole) in rows.iter().zip(&whole) {
            assert!(
                row.free_until <= whole.free_until && row.work <= budget + MAX_DISTANCE_STEP_WORK,
                "{row:?}"
            );
            assert!(row.stop == "work-limit" || row == whole, "{row:?}");
        }
    }
    assert!(
        ask(&folder, "--budget-us 0")
            .iter()
            .all(|row| row.stop == "deadline" && row.free_until == 0.0)
    );
}

#[test]
fn bad_options_are_refused_and_all_are_named() {
    let folder = cubes();
    let options = "--tolerance --reps --budget-us --budget-work --portable --memory --margin";
    folder.help_names("motion", options);
    folder.refuses(
        "motion a.obj b.obj",
        &[
            ("sweeps.txt --tolerance -1", "--tolerance must be"),
            ("sweeps.txt --tolerance nan", "--tolerance must be"),
            ("sweeps.txt --tolerance inf", "--tolerance must be"),
            ("sweeps.txt --tolerance x", "--tolerance must be"),
            ("none.txt", "none.txt:"),
        ],
    );
    folder.write(
        "bad.txt",
        "1 0 0 0 0 1 0 0 0 0 1 0 1 2 x\n1 0 0 0 0 1 0 0 0 0 1 0 2 0 0 0 0 2 0 0 0 0 2 0\n",
    );
    let answer = folder.run("motion a.obj b.obj bad.txt");
    assert_eq!(answer.status, 1);
    for part in [
        "bad.txt:1: sweep 0: translation: ",
        "bad.txt:2: sweep 1: last pose: ",
    ] {
        answer.tells(part);
    }
}

/// A unit cube on a wall 0.01 thick moves away, along it, and through it; and one that starts apart.
#[test]
fn ignore_start_skips_a_contact_that_the_motion_leaves() {
    let folder = Folder::new();
    folder.write("wall.obj", write::obj(&cuboid([2.0, 2.0, 0.005], 1)));
    folder.write("cube.obj", write::obj(&cuboid(Vec3::splat(0.5), 1)));
    let from = |z: f64, way: &str| format!("1 0 0 0  0 1 0 0  0 0 1 {z}  {way}\n");
    // Sunk by .001, the height of the cube over the wall is .504.
    let motions = [
        from(0.504, "0 0 4"),
        from(0.504, "1 0 0"),
        from(0.504, "0 0 -4"),
        from(1.505, "0 0 -4"),
        from(0.504, "0 0 0.0005"),
        "no motion\n".to_owned(),
        // A quarter of a turn about x, which sinks an edge.
        "1 0 0 0 0 1 0 0 0 0 1 .504  1 0 0 0 0 0 -1 0 0 1 0 .504\n".to_owned(),
    ];
    folder.write("motions.txt", motions.concat());
    let hits = folder.run("motion wall.obj cube.obj motions.txt");
    let begun = |line: &str| line.split(',').nth(2) == Some("0");
    let at_once: Vec<bool> = hits.lines(HEADER).map(begun).collect();
    assert_eq!(at_once, [true, true, true, false, true, false, true]);
    for options in ["", "--solid", "--budget-work 0", "--reps 2"] {
        let answer = folder.run(&format!(
            "motion wall.obj cube.obj motions.txt --ignore-start 0.005 {options}"
        ));
        assert_eq!(answer.status, 1);
        let within = if options == "--solid" { ",within" } else { "" };
        let header = format!("{HEADER}{within},free_from");
        let rows: Vec<Vec<&str>> = answer
            .lines(&header)
            .map(|row| row.split(',').collect())
            .collect();
        let last: Vec<&str> = rows.iter().map(|row| *row.last().unwrap()).collect();
        // Apart after .001 of 4, so at the first power of 2 above .00025.
        let out = (2f64.powi(-11)).to_string();
        assert_eq!(last, [&out, "", "", "0", "", "", ""], "{options}");
        if options == "--budget-work 0" {
            assert_eq!(rows[0][1], out);
            continue;
        }
        assert_eq!([rows[0][1], rows[0][2]], ["1", ""], "{options}");
        assert!(rows[1..3].iter().all(|row| row[2] == "0"), "{options}");
        let touching: f64 = rows[3][2].parse().unwrap();
        assert!((touching - 0.25).abs() < 1e-5, "{options}");
    }
    let bad = folder.run("motion wall.obj cube.obj motions.txt --ignore-start -1");
    bad.assert_refused(&["--ignore-start"]);
}

/// A body in another one is no hit for surfaces, and one at once for solids.
#[test]
fn solids_meet_what_is_inside_them() {
    let folder = Folder::new();
    folder.write("room.obj", write::obj(&cuboid(Vec3::splat(2.0), 1)));
    folder.write("pea.obj", write::obj(&cuboid(Vec3::splat(0.1), 1)));
    folder.write("motions.txt", "1 0 0 0 0 1 0 0 0 0 1 0  4 0 0\nno motion\n");
    let surfaces = folder.run("motion room.obj pea.obj motions.txt");
    let row = rows(&surfaces)[0].clone().unwrap();
    assert!((row.touching_at.unwrap() - 0.475).abs() < 1e-5, "{row:?}");
    let solids = folder.run("motion room.obj pea.obj motions.txt --solid");
    let told: Vec<&str> = solids.lines(&format!("{HEADER},within")).collect();
    assert!(
        told[0].starts_with("0,0,0,,,") && told[0].ends_with(",b"),
        "{told:?}"
    );
    assert!(told[1].ends_with(",error,0,"), "{told:?}");
    let open = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    folder.write("open.obj", open);
    let told = folder
        .run("motion room.obj open.obj motions.txt --solid")
        .err;
    assert!(
        told.contains("open.obj: its open parts are surfaces, it has 3 open edges"),
        "{told}"
    );
}
