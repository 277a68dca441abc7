//! The program `punctual`, from outside: its output, its messages, its exit status.

mod calibration;
mod cases;
mod contacts;
mod damage;
mod depth;
mod distance;
#[allow(dead_code, reason = "the library's tests use the rest")]
#[path = "../../../../tests/common/files.rs"]
mod files;
mod inside;
mod motion;
mod paper;
mod pile;
mod poses;
mod rays;
mod robot;
mod run;
mod scene;
mod shapes;
mod sweep;
mod view;
#[path = "../../../io/tests/write/mod.rs"]
mod write;

use std::io::Write;
use std::process::Stdio;

use punctual::prediction::MAX_STEP_WORK;
use punctual::shapes::{cuboid, icosphere};
use run::{Answer, Folder, IDENTITY};

const ORDERS: [&str; 3] = ["penetration", "low-alpha", "depth-first"];

/// Two spheres, and poses from coincident over touching to apart.
fn spheres() -> (Folder, Vec<u64>) {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&icosphere(2)));
    folder.write("b.obj", write::obj(&icosphere(1)));
    let shifts = [0.0, 0.5, 1.5, 2.0, 2.5];
    let pose = |x: &f64| format!("1 0 0 {x} 0 1 0 0 0 0 1 0 # {x}\n");
    let poses: String = shifts.iter().map(pose).collect();
    folder.write("poses.txt", format!("# B from left to right\n\n{poses}"));
    let (a, b) = (icosphere(2), icosphere(1));
    let brute_force = |x: &f64| {
        let shift = punctual::glam::DVec3::new(*x, 0.0, 0.0);
        let moved = (0..b.len()).map(|j| b.triangle(j).map(|v| v + shift));
        let moved: Vec<_> = moved.collect();
        let count = |i: usize| {
            let meets = |t: &&_| punctual::geom::triangles_intersect(&a.triangle(i), t);
            moved.iter().filter(meets).count()
        };
        (0..a.len()).map(count).sum::<usize>() as u64
    };
    (folder, shifts.iter().map(brute_force).collect())
}

#[test]
fn pair_counts_what_brute_force_counts() {
    let (folder, truth) = spheres();
    let all = folder.ok("pair a.obj b.obj poses.txt --mode all --reps 3");
    let found: Vec<_> = all.rows().iter().map(|row| row.pairs as u64).collect();
    assert_eq!(found, truth);
    assert!(truth[1] > 0 && truth[4] == 0);
    for row in all.rows() {
        assert_eq!((&*row.stop, row.upper_bound), ("finished", row.pairs));
    }
    let any = folder.run("pair a.obj b.obj poses.txt").rows();
    for (row, truth) in any.iter().zip(truth) {
        assert_eq!((row.hit == "1", row.pairs), (truth > 0, -1));
        assert_eq!(row.stop, if truth > 0 { "first-hit" } else { "finished" });
        assert!(row.upper_bound >= truth as i64);
    }
}

#[test]
fn every_order_and_budget_is_sound() {
    let (folder, truth) = spheres();
    let budgets = [
        "--budget-work 0",
        "--budget-work 999",
        "--budget-us 0",
        "--budget-us 2.5",
    ];
    for order in ORDERS {
        for rest in ["", "--memory"].into_iter().chain(budgets) {
            for mode in ["any", "all"] {
                let options = format!("--mode {mode} --order {order} {rest}");
                let answer = folder.run(&format!("pair a.obj b.obj poses.txt --reps 2 {options}"));
                assert_eq!(answer.status, 0, "{options}: {}", answer.err);
                for (row, &truth) in answer.rows().iter().zip(&truth) {
                    let stopped = row.stop == "deadline" || row.stop == "work-limit";
                    assert!(truth > 0 || row.hit == "0", "{options}: {row:?}");
                    assert!(truth == 0 || row.verdict != "separated", "{options}");
                    assert!(row.upper_bound >= truth as i64, "{options}: {row:?}");
                    assert!(stopped || row.verdict != "undecided", "{options}: {row:?}");
                    assert!(row.pairs <= truth as i64, "{options}: {row:?}");
                    assert!(
                        mode == "any" || stopped || row.pairs == truth as i64,
                        "{options}: {row:?}"
                    );
                    assert!(!stopped || rest.contains("budget"), "{options}: {row:?}");
                }
            }
        }
    }
}

#[test]
fn every_work_budget_is_kept_and_repeatable() {
    let (folder, _) = spheres();
    let limit = u64::MAX;
    let command = "pair a.obj b.obj poses.txt --mode all --budget-work";
    let run = |budget: u64| folder.run(&format!("{command} {budget}")).rows();
    let full = run(limit)[1].work;
    for budget in (0..full - MAX_STEP_WORK).step_by((full / 10).max(1) as usize) {
        let rows = run(budget);
        assert_eq!(rows, run(budget));
        assert_eq!(rows[1].stop, "work-limit");
        assert!(rows[1].work <= budget + MAX_STEP_WORK);
    }
}

#[test]
fn pair_tells_what_it_expects_and_how_sure_it_is() {
    let (folder, truth) = spheres();
    for mode in ["any", "all"] {
        let pair = format!("pair a.obj b.obj poses.txt --mode {mode}");
        let tell = |rest: &str| folder.run(&format!("{pair} {rest}")).rows();
        for (row, truth) in tell("").iter().zip(&truth) {
            let hit = f64::from(u8::from(*truth > 0));
            assert_eq!((row.remaining, row.probability), (Some(0.0), Some(hit)));
            assert_eq!(row.recall, (mode == "all").then_some(1.0));
        }
        let [low, usual, high] =
            ["0.01", "0.5", "0.99"].map(|p| tell(&format!("--budget-work 99 --prior {p}")));
        let mut undecided = 0;
        for ((low, usual), high) in low.iter().zip(&usual).zip(&high) {
            if low.verdict != "undecided" {
                continue;
            }
            undecided += 1;
            assert!(low.probability < usual.probability, "{low:?} {usual:?}");
            assert!(usual.probability < high.probability, "{usual:?} {high:?}");
            assert!(usual.remaining > Some(0.0), "{usual:?}");
            assert!(
                usual.predicted.is_some_and(|[p50, p90]| p50 <= p90),
                "{usual:?}"
            );
            assert_eq!(usual.recall, (mode == "all").then_some(0.0));
        }
        assert!(undecided >= 2, "{undecided}");
    }
    for prior in ["-0.1", "1.1", "nan", "x"] {
        folder.refused(
            &format!("pair a.obj b.obj poses.txt --prior {prior}"),
            &["--prior"],
        );
    }
}

#[test]
fn pairs_out_lists_the_pairs_sorted() {
    let (folder, truth) = spheres();
    let bad = format!("nan {}{}", &IDENTITY[1..], folder.read("poses.txt"));
    folder.write("bad.txt", bad);
    let answer = folder.run("pair a.obj b.obj bad.txt --mode all --reps 2 --pairs-out pairs.csv");
    assert_eq!(answer.status, 1);
    let number = |field: &str| field.parse::<usize>().unwrap();
    let text = folder.read("pairs.csv");
    let lines = text
        .lines()
        .map(|line| line.split(',').map(number).collect());
    let lines: Vec<Vec<usize>> = lines.collect();
    assert!(lines.is_sorted() && lines.iter().all(|line| line.len() == 3));
    for (pose, truth) in truth.into_iter().enumerate() {
        let of_pose = lines.iter().filter(|line| line[0] == pose + 1);
        assert_eq!(of_pose.count() as u64, truth);
    }
    folder.refused(
        "pair a.obj b.obj poses.txt --pairs-out x.csv",
        &["--mode all"],
    );
    folder.refused(
        "pair a.obj b.obj poses.txt --mode all --pairs-out no/x.csv",
        &["no/x.csv"],
    );
}

/// Two fans around one apex: every triangle meets every other.
#[test]
fn more_pairs_than_the_workspace_holds_are_all_counted() {
    let n: usize = 1050;
    let folder = Folder::new();
    let mut fan = String::from("v 0 0 0\n");
    for i in 0..n {
        let (z, first) = (i % 7, 2 * i + 2);
        fan += &format!("v {i} 1 {z}\nv {i} 2 {z}\nf 1 {first} {}\n", first + 1);
    }
    folder.write("fan.obj", fan);
    folder.write("poses.txt", IDENTITY);
    let limit = u64::MAX;
    let command =
        "pair fan.obj fan.obj poses.txt --mode all --memory --pairs-out pairs.csv --budget-work";
    let row = &folder.run(&format!("{command} {limit}")).rows()[0];
    let told = (row.pairs as usize, row.upper_bound as usize, &*row.stop);
    assert_eq!(told, (n * n, n * n, "finished"));
    assert_eq!(folder.read("pairs.csv").lines().count(), n * n);
    let budget = row.work - 2 * MAX_STEP_WORK;
    let part = &folder.run(&format!("{command} {budget}")).rows()[0];
    assert_eq!(part.stop, "work-limit");
    assert!(part.pairs > 1 << 20 && part.pairs < row.pairs && part.upper_bound >= row.pairs);
}

#[test]
fn bad_poses_are_error_rows_and_the_others_go_on() {
    let (folder, truth) = spheres();
    let good = "1 0 0 0.5 0 1 0 0 0 0 1 0";
    let bad = [
        "1 0 0 nan 0 1 0 0 0 0 1 0",
        "1 0 0 -inf 0 1 0 0 0 0 1 0",
        "2 0 0 0 0 2 0 0 0 0 2 0",
        "-1 0 0 0 0 1 0 0 0 0 1 0",
        "1 0 0 1e308 0 1 0 0 0 0 1 0",
        "1 0 0 0 0 1 0 0 0 0 1",
        "1 0 0 0 0 1 0 0 0 0 1 0 0",
        "1 0 0 0 0 1 0 0 0 0 1 1,5",
    ];
    let poses = format!("{good}\n# next are bad\n{}\n{good}\n", bad.join("\n"));
    folder.write("poses.txt", poses);
    let answer = folder.run("pair a.obj b.obj poses.txt --mode all --memory");
    assert_eq!(answer.status, 1);
    let rows = answer.rows();
    assert_eq!(rows.len(), bad.len() + 2);
    for row in [&rows[0], &rows[bad.len() + 1]] {
        assert_eq!(row.pairs as u64, truth[1]);
    }
    let mut of_bad = rows[1..=bad.len()].iter();
    assert!(of_bad.all(|row| row.is_error() && row.pairs == -1));
    for i in 0..bad.len() {
        let place = format!("poses.txt:{}: pose {}: ", i + 3, i + 1);
        answer.tells(&place);
    }
}

#[test]
fn all_formats_give_the_same_answers() {
    let folder = Folder::new();
    folder.write("box.obj", write::obj(&cuboid([0.75; 3], 2)));
    let others = "0 -1 0 0.25 1 0 0 0.125 0 0 1 0\n1 0 0 5 0 1 0 0 0 0 1 0\n";
    folder.write("poses.txt", format!("{IDENTITY}{others}"));
    let mesh = icosphere(2);
    let mut answers = Vec::new();
    for (name, bytes) in write::all_formats(&mesh) {
        folder.write(name, bytes);
        for pair in [format!("{name} box.obj"), format!("box.obj {name}")] {
            let answer = folder.run(&format!("pair {pair} poses.txt --mode all"));
            assert_eq!(answer.status, 0, "{name}: {}", answer.err);
            let rows = answer.rows().into_iter();
            answers.push((
                name,
                rows.map(|row| (row.hit, row.pairs)).collect::<Vec<_>>(),
            ));
        }
    }
    for [first, second] in answers.as_chunks::<2>().0 {
        assert_eq!((&first.1, &second.1), (&answers[0].1, &answers[1].1));
    }
    assert!(answers[0].1[0].1 > 0 && answers[0].1[2].1 == 0);
}

/// `-` is a mesh in any format on standard input, for every command that takes meshes.
#[test]
fn meshes_may_come_from_standard_input() {
    let (folder, truth) = spheres();
    let piped = folder.run_with_input("pair - b.obj poses.txt --mode all", &folder.read("a.obj"));
    assert_eq!((piped.status, piped.err.as_str()), (0, ""));
    let rows = piped.rows();
    assert!(rows.iter().map(|row| row.pairs as u64).eq(truth));
    folder.write("sweeps.txt", "1 0 0 5 0 1 0 0 0 0 1 0 -10 0 0\n");
    folder.write("rays.txt", "5 0 0 -1 0 0\n");
    for command in [
        "info -",
        "distance a.obj - poses.txt",
        "contacts - a.obj poses.txt",
        "motion - a.obj sweeps.txt",
        "rays - rays.txt",
    ] {
        let answer = folder.run_with_input(command, &folder.read("b.obj"));
        assert_eq!((answer.status, answer.err.as_str()), (0, ""), "{command}");
    }
    let formats = write::all_formats(&icosphere(2)).into_iter();
    for (name, bytes) in formats.filter(|(_, bytes)| bytes.is_ascii()) {
        let answer = folder.run_with_input("info -", &String::from_utf8(bytes).unwrap());
        assert!(answer.out.contains(" 320\n"), "{name}: {}", answer.err);
    }
    folder
        .run_with_input("pair - - poses.txt", &folder.read("a.obj"))
        .assert_refused(&["-: ", "can be read once"]);
    folder
        .run_with_input("info -", "what is this\n")
        .assert_refused(&["-: no mesh format by its content"]);
}

#[test]
fn meshes_are_scaled_and_turned() {
    let folder = Folder::new();
    // In millimetres, y up: a floor, and a post that stands on it.
    let floor = "v -1000 0 -1000\nv 1000 0 -1000\nv 0 0 2000\nf 1 2 3\n";
    folder.write("floor.obj", floor);
    folder.write("post.obj", "v 0 0 0\nv 10 0 0\nv 0 3000 0\nf 1 2 3\n");
    let poses = [0.5, 0.0, -0.5].map(|z| format!("1 0 0 0 0 1 0 0 0 0 1 {z}\n"));
    folder.write("poses.txt", poses.concat());
    let column = |command: &str, at: usize| {
        let out = folder.ok(command).out;
        let rows = out
            .lines()
            .skip(2)
            .map(|row| row.split(',').nth(at).unwrap().parse());
        rows.collect::<Result<Vec<f64>, _>>().unwrap()
    };
    let in_metres = "--scale 0.001 --up y";
    let distance = "distance floor.obj post.obj poses.txt";
    let low = column(&format!("{distance} {in_metres} --mode exact"), 1);
    assert!(
        low.iter().map(|x| (1e9 * x).round()).eq([5e8, 0.0, 0.0]),
        "{low:?}"
    );
    // Where z is up, the floor is a wall through the post's foot.
    assert_eq!(column(distance, 1), [0.0; 3]);
    folder.write("sweeps.txt", "1 0 0 0 0 1 0 0 0 0 1 1 0 0 -2\n");
    folder.write("rays.txt", "0.01 0.01 9 0 0 -1\n");
    let motion = "motion floor.obj post.obj sweeps.txt --tolerance 0";
    let until = column(&format!("{motion} {in_metres}"), 1)[0];
    assert!((until - 0.5).abs() < 1e-9, "{until}");
    assert_eq!(
        column(&format!("rays floor.obj rays.txt {in_metres}"), 2),
        [9.0]
    );
    for scale in ["0", "1,2", "1,0,1", "nan", "inf", "x"] {
        folder.refused(
            &format!("info post.obj --scale {scale}"),
            &["--scale", "must be"],
        );
    }
    folder.refused("info post.obj --up w", &["--up"]);
}

#[test]
fn triangles_answers_line_by_line() {
    let folder = Folder::new();
    let a = "0 0 0 1 0 0 0 1 0";
    let lines = format!(
        "# pairs\n1 1 family -0.0 {a} 1 0 0 2 0 0 2 1 0\n\n{a} 0 0 1 1 0 1 0 1 1 # above\n{a}\n\
         0 0 x 1e0 {a} 0 0 nan 1 0 1 0 1 1\n{a} 0 0 5e-324 1 0 1 0 1 1\n{a} 0 0 0 1e-320 0 0 0 1 x\n{a} {a}"
    );
    folder.write("pairs.txt", &lines);
    let answer = folder.run("triangles pairs.txt");
    assert_eq!(
        (answer.status, answer.out.as_str()),
        (1, "1\n0\nerror\nerror\n0\nerror\n1\n")
    );
    for line in [5, 6, 8] {
        answer.tells(&format!("pairs.txt:{line}: "));
    }
    assert_eq!(answer.err.lines().count(), 3);
    let piped = folder.run_with_input("triangles -", &format!("{a} {a}\n"));
    assert_eq!((piped.status, &*piped.out, &*piped.err), (0, "1\n", ""));
    folder.refused("triangles none.txt", &["none.txt: "]);
}

#[test]
fn info_prints_a_table_for_each_mesh() {
    let (folder, _) = spheres();
    folder.write("fine.obj", "v 0 0 0.1\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let answer = folder.ok("info a.obj fine.obj");
    let tables: Vec<&str> = answer.out.split("\n\n").collect();
    assert_eq!(tables.len(), 2);
    let field = |table: &str, name: &str| {
        let mut lines = table.lines();
        let line = lines.find(|line| line.trim_start().starts_with(name));
        let line = line.unwrap_or_else(|| panic!("no {name}: {table}"));
        line.split_whitespace().last().unwrap().to_owned()
    };
    assert!(tables[0].starts_with("a.obj\n"));
    assert_eq!(field(tables[0], "triangles"), "320");
    assert_eq!(field(tables[0], "self-pairs"), "0");
    assert!(field(tables[0], "bytes/triangle").parse::<f64>().unwrap() > 0.0);
    assert!(field(tables[0], "build ms").parse::<f64>().unwrap() >= 0.0);
    let alpha: f64 = field(tables[0], "0 ").parse().unwrap();
    assert!(alpha > 0.0 && alpha < 1.0, "{}", tables[0]);
    assert_eq!(field(tables[1], "triangles"), "1");
    assert_eq!(field(tables[0], "coordinates"), "f32");
    assert_eq!(field(tables[1], "coordinates"), "f64");
    folder.refused("info none.stl", &["none.stl: "]);
}

#[test]
fn help_names_every_option_and_bad_options_are_refused() {
    let folder = Folder::new();
    let options = "--mode --reps --budget-us --budget-work --order --memory --prior --calibration --pairs-out";
    folder.help_names("pair", options);
    for command in ["triangles", "info"] {
        assert_eq!(folder.run(&format!("{command} --help")).status, 0);
    }
    let version = concat!("punctual ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(folder.run("--version").out, version);
    for bad in [
        "",
        "info",
        "pair",
        "pair a b c --reps 0",
        "pair a b c --order best",
        "pair a b c --budget-us -1",
        "pair a b c --budget-us nan",
        "pair a b c --budget-us 1 --budget-work 1",
    ] {
        folder.refused(bad, &[]);
    }
}

#[test]
fn closed_pipe_is_no_failure() {
    let folder = Folder::new();
    let mut command = folder.command("triangles -");
    let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let lines = "0 0 0 1 0 0 0 1 0 0 0 0 1 0 0 0 1 0\n".repeat(20_000);
    // The program may stop reading at any moment, so a failed write is fine.
    let _ = child.stdin.take().unwrap().write_all(lines.as_bytes());
    let answer = Answer::new(&child.wait_with_output().unwrap());
    assert_eq!((answer.status, answer.err.as_str()), (0, ""));
}
