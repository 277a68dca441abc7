//! `punctual pile` from outside: its columns, that it loses no body whatever the budget, and its page.

use punctual::shapes::{cuboid, icosphere};

use crate::run::Folder;
use crate::write;

const HEADER: &str = "frame,lost,deepest,fastest,manifolds,fresh,cpu_ns,overrun_ns";

/// The rows, of which all columns were checked, and the lines that sum up.
fn run(folder: &Folder, arguments: &str) -> (Vec<Vec<String>>, Vec<String>) {
    let answer = folder.run(&format!("pile {arguments}"));
    assert_eq!(answer.status, 0, "{}", answer.err);
    let (sums, rows): (Vec<&str>, Vec<&str>) =
        answer.lines(HEADER).partition(|line| line.starts_with('#'));
    let row = |(i, line): (usize, &&str)| -> Vec<String> {
        let fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        assert_eq!((fields.len(), &fields[0]), (8, &i.to_string()), "{line}");
        assert_eq!(fields[2].is_empty(), (i + 1) % 60 != 0, "{line}");
        for field in fields.iter().filter(|field| !field.is_empty()) {
            assert!(field.parse::<f64>().unwrap() >= 0.0, "{line}");
        }
        assert!(fields[5].parse::<f64>().unwrap() <= 1.0, "{line}");
        fields
    };
    let rows = rows.iter().enumerate().map(row).collect();
    (rows, sums.into_iter().map(str::to_owned).collect())
}

fn column(rows: &[Vec<String>], number: usize) -> Vec<f64> {
    let numbers = rows.iter().map(|row| row[number].parse());
    numbers.map(|number| number.unwrap_or(0.0)).collect()
}

#[test]
fn no_body_is_lost_within_any_budget() {
    let folder = Folder::new();
    for budget in [
        "",
        "--budget-us 1000",
        "--budget-work 1000",
        "--budget-work 100000",
        "--budget-work 1000000",
    ] {
        let (rows, sums) = run(&folder, &format!("--bodies 24 --frames 240 {budget}"));
        assert_eq!((rows.len(), sums.len()), (240, 3), "{budget}");
        assert!(column(&rows, 1).iter().all(|&lost| lost == 0.0), "{budget}");
        let deepest = column(&rows, 2).into_iter().fold(0.0, f64::max);
        // How deep bodies get within a budget of time depends on the machine.
        let is_timed = budget.contains("us");
        assert!(is_timed || deepest < 0.06, "{budget}: {deepest}");
        let overruns = column(&rows, 7);
        assert!(is_timed || overruns.iter().all(|&ns| ns == 0.0), "{budget}");
    }
}

#[test]
fn without_a_budget_the_pile_comes_to_rest_and_nothing_is_held() {
    let (rows, sums) = run(&Folder::new(), "--bodies 12 --frames 480");
    assert!(
        sums[0].starts_with("# bodies held, percent: 0.00;"),
        "{sums:?}"
    );
    assert!(column(&rows[..60], 3).iter().any(|&speed| speed > 1.0));
    let last = column(&rows[420..], 3)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    assert!(last < 0.1, "{last}");
    assert!(column(&rows, 2)[479] < 0.01, "{sums:?}");
    // Something lies on something.
    assert!(column(&rows[479..], 4)[0] >= 12.0);
}

#[test]
fn a_budget_of_work_gives_the_same_pile_on_every_run_and_any_number_of_threads() {
    let folder = Folder::new();
    let of = |threads: u32| {
        let arguments =
            format!("--bodies 16 --frames 120 --budget-work 200000 --threads {threads}");
        let (mut rows, _) = run(&folder, &arguments);
        rows.iter_mut().for_each(|row| row.truncate(6));
        rows
    };
    let rows = of(1);
    assert!(column(&rows, 4).iter().any(|&manifolds| manifolds > 0.0));
    assert_eq!(rows, of(1));
    assert_eq!(rows, of(2));
}

#[test]
fn meshes_of_any_size_fall_and_a_page_shows_it() {
    let folder = Folder::new();
    folder.write("cube.obj", write::obj(&cuboid([40.0, 20.0, 20.0], 2)));
    folder.write("ball.obj", write::obj(&icosphere(2)));
    let (rows, _) = run(
        &folder,
        "cube.obj ball.obj --bodies 5 --frames 90 --view pile.html",
    );
    assert_eq!(rows.len(), 90);
    let page = folder.read("pile.html");
    assert!(page.contains("A pile: what touches what") && page.contains("Frame"));
    assert!(page.len() > 20_000, "{}", page.len());
}

/// The first lies flat in the air: within one frame it could get through the surface of the floor.
#[test]
fn thin_bodies_do_not_get_into_the_floor() {
    let folder = Folder::new();
    folder.write("plate.obj", write::obj(&cuboid([0.7, 0.7, 0.0175], 3)));
    for (budget, most_held) in [("", 1.0), ("--budget-work 20000", 90.0)] {
        let arguments = format!("plate.obj --bodies 9 --frames 120 {budget}");
        let (rows, sums) = run(&folder, &arguments);
        assert!(column(&rows, 1).iter().all(|&lost| lost == 0.0), "{budget}");
        // A body is held while it goes back, and not for good.
        let held = sums[0].split([':', ';']).nth(1).unwrap().trim();
        assert!(held.parse::<f64>().unwrap() < most_held, "{sums:?}");
    }
}

#[test]
fn open_meshes_are_refused_by_name() {
    let folder = Folder::new();
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let answer = folder.run("pile flat.obj --frames 1");
    answer.assert_refused(&["flat.obj", "3 open edges"]);
    let answer = folder.run("pile --frames 1 --threads 2 --clock cpu");
    answer.assert_refused(&["--clock cpu needs --threads 1"]);
}
