//! `punctual distance` from outside: its columns, its messages, and meshes that are hard to read or to tell apart.

use std::path::Path;

use punctual::glam::{DVec3, Vec3};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::shapes::{cuboid, icosphere};

use crate::files::{Truth, truth};
use crate::run::{Answer, Folder, IDENTITY};
use crate::write;

const HEADER: &str = "pose,low,high,triangle_a,triangle_b,ax,ay,az,bx,by,bz,closer,ns,stop,work";

/// One row of the output.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    low: f64,
    high: f64,
    /// The closest triangles found, and their closest points.
    nearest: Option<([usize; 2], [DVec3; 2])>,
    closer: String,
    stop: String,
    work: u64,
}

impl Row {
    fn new(fields: &[&str]) -> Self {
        let number = |i: usize| fields[i].parse::<f64>().unwrap();
        let point = |i: usize| DVec3::new(number(i), number(i + 1), number(i + 2));
        let (low, high) = (number(0), number(1));
        let is_found = fields[2..10].iter().any(|field| !field.is_empty());
        assert!(is_found || high.is_infinite(), "{fields:?}");
        let nearest = is_found.then(|| {
            let triangles = [fields[2], fields[3]].map(|id| id.parse().unwrap());
            (triangles, [point(4), point(7)])
        });
        let closer = fields[10];
        assert!(0.0 <= low && low <= high, "{fields:?}");
        assert!(
            ["", "yes", "no", "undecided"].contains(&closer),
            "{fields:?}"
        );
        fields[11].parse::<u64>().unwrap();
        Self {
            low,
            high,
            nearest,
            closer: closer.into(),
            stop: fields[12].into(),
            work: fields[13].parse().unwrap(),
        }
    }
}

fn rows(answer: &Answer) -> Vec<Option<Row>> {
    let rows = answer.table(HEADER).into_iter();
    rows.map(|row| row.map(|fields| Row::new(&fields)))
        .collect()
}

/// Cubes of edge 2: in each other, touching, one apart, and once more after a line that holds no pose.
fn cubes() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&cuboid(Vec3::ONE, 3)));
    folder.write("b.obj", write::obj(&cuboid(Vec3::ONE, 2)));
    let at = |x: f64| format!("1 0 0 {x} 0 1 0 0 0 0 1 0\n");
    let [within, touching, apart] = [0.5, 2.0, 3.0].map(at);
    let poses = format!("{within}# next touch\n{touching}{apart}1 0 0\n{apart}");
    folder.write("poses.txt", poses);
    folder
}

/// The rows of all poses but the bad one.
fn ask(folder: &Folder, options: &str) -> [Row; 4] {
    let answer = folder.run(&format!("distance a.obj b.obj poses.txt {options}"));
    assert_eq!(answer.status, 1, "{options}: {}", answer.err);
    answer.tells("poses.txt:5: pose 3: ");
    assert_eq!(answer.err.lines().count(), 1);
    let rows = rows(&answer);
    let are_some = rows.iter().map(Option::is_some);
    assert!(are_some.eq([true, true, true, false, true]));
    let rows: Vec<Row> = rows.into_iter().flatten().collect();
    rows.try_into().unwrap()
}

#[test]
fn distances_points_and_margins_of_cubes() {
    let folder = cubes();
    for options in [
        "",
        "--mode exact",
        "--rel 0",
        "--rel 0.2",
        "--abs 0.1",
        "--memory --reps 3",
        "--portable",
    ] {
        let [within, touching, apart, again] = ask(&folder, options);
        for row in [&within, &touching] {
            assert_eq!(
                (row.low, row.high, row.stop.as_str()),
                (0.0, 0.0, "finished"),
                "{options}: {row:?}"
            );
        }
        // One point of both, on a face of each.
        let on_faces =
            |p: DVec3, x: f64| ((p - DVec3::X * x).abs().max_element() - 1.0).abs() < 1e-12;
        for (row, x) in [(within, 0.5), (touching, 2.0)] {
            let (_, [p, q]) = row.nearest.unwrap();
            assert!(p == q && on_faces(p, 0.0) && on_faces(p, x), "{options}");
        }
        for row in [&apart, &again] {
            let width = if options.contains("0.") { 0.2 } else { 1e-5 };
            assert!(
                1.0 - width <= row.low && row.low <= 1.0 && (1.0..1.0 + 1e-14).contains(&row.high),
                "{options}: {row:?}"
            );
            let (_, [p, q]) = row.nearest.unwrap();
            assert_eq!((p.x, q), (1.0, p + DVec3::X), "{options}");
            assert_eq!((row.closer.as_str(), row.stop.as_str()), ("", "finished"));
        }
    }
    // Whether they meet is of no matter.
    for row in ask(&folder, "--abs 3 --leave-contact-open") {
        assert!(
            row.low == 0.0 && row.high <= 3.0 && row.stop == "finished",
            "{row:?}"
        );
    }
    // Each surface takes the margin.
    let [_, touching, apart, _] = ask(&folder, "--margin 0.25 --mode exact");
    assert!(
        touching.high == 0.0 && (apart.low - 0.5).abs() < 1e-14 && (apart.high - 0.5).abs() < 1e-14,
        "{apart:?}"
    );
    assert_eq!(apart.nearest.unwrap().1.map(|point| point.x), [1.25, 1.75]);
    let [.., row] = ask(&folder, "--margin 0.6 --mode exact");
    assert_eq!((row.low, row.high), (0.0, 0.0));
}

#[test]
fn closer_than_is_answered_and_budgets_are_kept() {
    let folder = cubes();
    for (options, answers) in [
        ("--closer-than 0.999999", ["yes", "yes", "no", "no"]),
        ("--closer-than 1.000001", ["yes"; 4]),
        ("--closer-than 0", ["yes", "yes", "no", "no"]),
        (
            "--closer-than 0.49 --margin 0.25 --memory",
            ["yes", "yes", "no", "no"],
        ),
        ("--closer-than 0.51 --margin 0.25 --memory", ["yes"; 4]),
        ("--closer-than 1 --budget-work 0", ["undecided"; 4]),
        ("--budget-work 0", [""; 4]),
    ] {
        let rows = ask(&folder, options);
        assert_eq!(rows.each_ref().map(|row| row.closer.as_str()), answers);
        if options.ends_with("--budget-work 0") {
            for row in &rows {
                assert!(row.stop == "work-limit" && row.nearest.is_none(), "{row:?}");
                assert_eq!((row.low, row.high), (0.0, f64::INFINITY));
                assert!(row.work <= MAX_DISTANCE_STEP_WORK, "{row:?}");
            }
        }
    }
    let [.., whole] = ask(&folder, "--mode exact");
    // That bounds hold after every step is a test of the library.
    for budget in (0..whole.work).step_by(whole.work as usize / 16) {
        let command = format!("--mode exact --budget-work {budget}");
        let [.., row] = ask(&folder, &command);
        assert!(
            row.low <= 1.0 && 1.0 <= row.high && row.work <= budget + MAX_DISTANCE_STEP_WORK,
            "{row:?}"
        );
        assert_eq!(row, ask(&folder, &command)[3]);
    }
    assert!(
        ask(&folder, "--budget-us 0")
            .iter()
            .all(|row| row.stop == "deadline")
    );
}

#[test]
fn a_surface_inside_another_is_apart() {
    let folder = Folder::new();
    folder.write("b.obj", write::obj(&icosphere(0)));
    folder.write("a.obj", write::obj(&cuboid(Vec3::splat(3.0), 3)));
    folder.write("poses.txt", IDENTITY);
    let row = rows(&folder.run("distance b.obj a.obj poses.txt --mode exact"))[0]
        .clone()
        .unwrap();
    assert!(
        row.low > 2.0 && row.high < 2.2 && row.high - row.low < 1e-14,
        "{row:?}"
    );
}

#[test]
fn bad_options_are_refused_and_all_are_named() {
    let folder = cubes();
    let options = "--mode --rel --abs --leave-contact-open --closer-than --reps --budget-us --budget-work --portable --memory --margin";
    folder.help_names("distance", options);
    for option in ["--rel", "--abs", "--closer-than", "--margin"] {
        for bad in ["-1", "nan", "inf", "x"] {
            folder.refused(
                &format!("distance a.obj b.obj poses.txt {option} {bad}"),
                &[option, "must be"],
            );
        }
    }
    folder.refuses(
        "distance a.obj b.obj poses.txt",
        &[
            ("--mode any", "--mode"),
            ("--mode exact --rel 1", "--rel"),
            ("--abs 1 --closer-than 1", "--abs"),
            ("--leave-contact-open", "--abs"),
            ("--budget-us 1 --budget-work 1", "--budget-us"),
            ("--reps 0", "--reps"),
        ],
    );
    folder.refuses(
        "distance a.obj",
        &[
            ("none.obj poses.txt", "none.obj:"),
            ("a.obj poses", "poses:"),
        ],
    );
    folder.write("broken.obj", "v 0 0 0\nv 1 0\n");
    folder.refused("distance a.obj broken.obj poses.txt", &["broken.obj:2: "]);
}

/// The fixtures say where surfaces meet: there and only there the distance is 0.
#[test]
fn hard_cases_are_zero_where_they_meet() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let shared = root.join("../shared/hardcases/meshes");
    let mut answered = 0;
    let folders = [root.join("tests/fixtures/meshes"), shared];
    let folders = folders.iter().filter(|folder| folder.is_dir());
    let cases = folders.flat_map(|folder| std::fs::read_dir(folder).unwrap());
    for case in cases.map(|case| case.unwrap().path()) {
        let files = ["a.obj", "b.obj", "poses.txt"].map(|file| case.join(file));
        let truth = truth(&case.join("truth.csv"));
        for options in [
            "",
            "--mode exact",
            "--rel 1e-3",
            "--memory",
            "--budget-work 2000",
        ] {
            let here = Folder::new();
            let mut command = here.command(&format!("distance {options}"));
            let answer = Answer::new(&command.args(&files).output().unwrap());
            if answer.status == 2 {
                answer.assert_refused(&[".obj"]);
                continue;
            }
            let rows = rows(&answer);
            assert_eq!(rows.len(), truth.len());
            for (row, truth) in rows.iter().zip(&truth) {
                let (Some(row), Truth::Pairs(pairs)) = (row, truth) else {
                    continue;
                };
                let name = format!("{} {options}: {row:?}", case.display());
                assert!(row.high > 0.0 || *pairs > 0, "{name}");
                assert!(row.low == 0.0 || *pairs == 0, "{name}");
                if !options.contains("budget") {
                    assert_eq!(row.high == 0.0, *pairs > 0, "{name}");
                    assert!(row.stop == "finished" && row.nearest.is_some(), "{name}");
                }
                answered += 1;
            }
        }
    }
    assert!(answered > 100, "{answered}");
}

/// A cube in a larger one: apart as surfaces, at distance 0 as solids.
#[test]
fn solids_that_hold_each_other_are_not_apart() {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&cuboid(Vec3::splat(2.0), 1)));
    folder.write("b.obj", write::obj(&cuboid(Vec3::splat(0.5), 1)));
    let beside = "1 0 0 4 0 1 0 0 0 0 1 0\n";
    folder.write("poses.txt", format!("{IDENTITY}\n{beside}no pose\n"));
    let surfaces = rows(&folder.run("distance a.obj b.obj poses.txt"));
    assert!((surfaces[0].as_ref().unwrap().high - 1.5).abs() < 1e-5);
    for options in ["", "--closer-than 1"] {
        let solids = folder.run(&format!("distance a.obj b.obj poses.txt --solid {options}"));
        let told: Vec<&str> = solids.lines(&format!("{HEADER},within")).collect();
        assert!(
            told[0].starts_with("0,0,0,") && told[0].ends_with(",b"),
            "{told:?}"
        );
        assert!(
            told[1].starts_with("1,1.") && told[1].ends_with(','),
            "{told:?}"
        );
        assert!(told[2].ends_with(",0,error,0,"), "{told:?}");
    }
    let turned = folder.run("distance b.obj a.obj poses.txt --solid");
    assert!(
        turned.out.lines().nth(2).unwrap().ends_with(",a"),
        "{}",
        turned.out
    );
}
