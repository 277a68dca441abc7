//! `punctual depth` from outside: its columns, known depths, budgets and messages.

use punctual::shapes::{cuboid, icosphere};

use crate::run::{Folder, IDENTITY};
use crate::write;

const HEADER: &str = "pose,low,high,nx,ny,nz,ns,stop,work";

/// `low` and `high`, the direction, `stop` and the work.
type Row = ([f64; 2], Option<[f64; 3]>, String, u64);

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("cube.obj", write::obj(&cuboid([1.0; 3], 2)));
    folder.write("small.obj", write::obj(&cuboid([0.125; 3], 1)));
    folder.write("ball.obj", write::obj(&icosphere(3)));
    folder
}

fn at(x: f64, y: f64, z: f64) -> String {
    format!("1 0 0 {x} 0 1 0 {y} 0 0 1 {z}\n")
}

/// The rows; none for a line that holds no pose.
fn rows(folder: &Folder, arguments: &str, status: i32) -> Vec<Option<Row>> {
    let answer = folder.run(&format!("depth {arguments}"));
    assert_eq!(answer.status, status, "{}", answer.err);
    let row = |fields: Vec<&str>| {
        let number = |i: usize| fields[i].parse::<f64>().unwrap();
        assert!(number(5) > 0.0, "{fields:?}");
        let direction = (!fields[2].is_empty()).then(|| [2, 3, 4].map(number));
        let bounds = [number(0), number(1)];
        assert!(0.0 <= bounds[0] && bounds[0] <= bounds[1], "{fields:?}");
        (
            bounds,
            direction,
            fields[6].to_owned(),
            fields[7].parse().unwrap(),
        )
    };
    let rows = answer.table(HEADER).into_iter();
    rows.map(|fields| fields.map(row)).collect()
}

#[test]
fn known_depths_lie_within_and_the_push_is_a_unit_vector() {
    let folder = folder();
    folder.write("poses.txt", at(1.75, 0.25, 0.5) + &at(0.25, -1.5, 0.125));
    for options in ["", "--solid"] {
        let arguments = format!("cube.obj cube.obj poses.txt --budget-work 10000000 {options}");
        for (row, depth) in rows(&folder, &arguments, 0).into_iter().zip([0.25, 0.5]) {
            let ([low, high], direction, stop, _) = row.unwrap();
            assert!(low <= depth && depth <= high && high < 1.01 * low, "{low}");
            let [x, y, z] = direction.unwrap();
            assert!((x * x + y * y + z * z - 1.0).abs() < 1e-12);
            assert_eq!(stop, "finished");
        }
    }
}

#[test]
fn a_mesh_in_a_mesh_penetrates_it_if_it_is_solid() {
    let folder = folder();
    folder.write("poses.txt", IDENTITY.to_owned() + &at(5.0, 0.0, 0.0));
    let surfaces = rows(&folder, "cube.obj small.obj poses.txt", 0);
    let solids = "cube.obj small.obj poses.txt --solid --budget-work 3000000";
    let solids = rows(&folder, solids, 0);
    for row in surfaces.iter().chain(&solids[1..]) {
        let (bounds, direction, stop, _) = row.as_ref().unwrap();
        assert_eq!(
            (*bounds, direction, stop.as_str()),
            ([0.0; 2], &None, "finished")
        );
    }
    let ([low, high], ..) = solids[0].clone().unwrap();
    assert!(0.0 < low && low <= 1.125 && 1.125 <= high, "{low} {high}");
}

#[test]
fn budgets_end_it_and_more_of_it_tells_more() {
    let folder = folder();
    folder.write("poses.txt", at(1.5, 0.25, 0.125));
    let mut before = [0.0, f64::INFINITY];
    for work in [0, 1000, 30_000, 300_000, 3_000_000] {
        let arguments = format!("ball.obj ball.obj poses.txt --budget-work {work}");
        let first = rows(&folder, &arguments, 0);
        let again = rows(&folder, &format!("{arguments} --reps 3"), 0);
        assert_eq!(first, again);
        let ([low, high], direction, stop, spent) = first[0].clone().unwrap();
        assert!(before[0] <= low && high <= before[1], "{low} {high}");
        assert_eq!(direction.is_some(), high < f64::INFINITY);
        assert!(stop == "finished" || stop == "work-limit" && spent <= work + 4096);
        before = [low, high];
    }
    assert!(before[1] < 0.5 && before[0] > 0.4, "{before:?}");
    let rough = rows(&folder, "ball.obj ball.obj poses.txt --rel 0.5", 0);
    let ([low, high], _, stop, _) = rough[0].clone().unwrap();
    assert!(high <= 1.5 * low && stop == "finished", "{low} {high}");
    let timed = rows(&folder, "ball.obj ball.obj poses.txt --budget-us 50", 0);
    assert!(timed[0].is_some());
}

#[test]
fn a_line_that_holds_no_pose_is_an_error() {
    let folder = folder();
    folder.write("poses.txt", at(1.5, 0.0, 0.0) + "2 0 0 0 0 2 0 0 0 0 2 0\n");
    let found = rows(&folder, "cube.obj ball.obj poses.txt --budget-work 1000", 1);
    assert!(found[0].is_some() && found[1].is_none());
    folder.refused("depth cube.obj ball.obj poses.txt --rel -1", &["--rel"]);
}

#[test]
fn a_limit_asks_only_whether_they_penetrate_deeper() {
    let folder = folder();
    folder.write(
        "poses.txt",
        at(1.75, 0.25, 0.5) + "2 0 0 0 0 2 0 0 0 0 2 0\n",
    );
    for (limit, answer) in [("0.2", "yes"), ("0.25001", "no"), ("0", "yes")] {
        let arguments = format!("depth cube.obj cube.obj poses.txt --solid --deeper-than {limit}");
        let said = folder.run(&arguments);
        assert_eq!(said.status, 1, "{}", said.err);
        let rows: Vec<&str> = said.lines(&format!("{HEADER},deeper")).collect();
        assert!(rows[0].ends_with(&format!(",{answer}")), "{rows:?}");
        assert_eq!(rows[1], "1,,,,,,0,error,0,");
    }
    let budget = "depth cube.obj cube.obj poses.txt --deeper-than 0.2 --budget-work 0";
    assert!(folder.run(budget).out.contains(",work-limit,0,undecided\n"));
    let rough = rows(&folder, "cube.obj cube.obj poses.txt --abs 3", 1);
    let ([low, high], ..) = rough[0].clone().unwrap();
    assert!(low <= 0.25 && 0.25 <= high && high <= low + 3.0, "{low}");
    folder.refused(
        "depth cube.obj cube.obj poses.txt --deeper-than -1",
        &["--deeper-than"],
    );
}
