//! `punctual sweep` and `punctual compare`.

use std::collections::BTreeSet;

use punctual::shapes::{cuboid, torus_knot};

use crate::run::Folder;
use crate::write;

const FILES: [&str; 20] = [
    "index.html",
    "summary.json",
    "sweep.csv",
    "distance.csv",
    "distance.svg",
    "distance-near.svg",
    "distance-time.svg",
    "distance-near-time.svg",
    "any.svg",
    "all.svg",
    "coverage.svg",
    "any-time.svg",
    "all-time.svg",
    "late.svg",
    "overview.svg",
    "volume-left.svg",
    "cases/gear_gear-work.svg",
    "cases/gear_gear-all-time.svg",
    "cases/gear_gear-distance.svg",
    "truth/knot_sphere.csv",
];

/// The part of a summary that holds figures of work, as it is written.
fn work(summary: &str) -> &str {
    &summary[summary.find("\"work\"").unwrap()..]
}

#[test]
fn a_sweep_is_never_wrong_and_its_work_is_repeatable() {
    let folder = Folder::new();
    let first = folder.ok("sweep --builtin --quick --out one");
    first.prints("wrong: 0\n");
    for file in FILES {
        assert!(
            folder
                .path()
                .join("one")
                .join(file)
                .metadata()
                .unwrap()
                .len()
                > 100,
            "{file}"
        );
    }
    assert_eq!(folder.run("sweep --builtin --quick --out two").status, 0);
    let [one, two] = ["one", "two"].map(|name| folder.read(&format!("{name}/summary.json")));
    assert_eq!(work(&one), work(&two));
    assert!(work(&one).contains("\"wrong\": 0.0"));
    let rows = |name: &str| -> Vec<String> {
        let table = folder.read(&format!("{name}/sweep.csv"));
        table
            .lines()
            .filter(|line| line.contains(",work_percent,"))
            .map(str::to_owned)
            .collect()
    };
    assert_eq!(rows("one"), rows("two"));
    assert!(rows("one").len() > 1000);
    let page = folder.read("one/index.html");
    assert!(!page.contains("<script"));
    // Verdicts are on the three guarantees, and on nothing else.
    assert_eq!(page.matches("<h3>Verdict</h3>").count(), 3);
    assert_eq!(page.matches("verdict yes").count(), 2 * 3);
    // Fourteen plots of all cases, seven of each of the six.
    assert_eq!(page.matches("<svg").count(), 14 + 7 * 6);
    no_order_is_ahead_of_the_best(&one);
    bounds_close_in(&folder.read("one/distance.csv"));

    let compared = folder.run("compare one/summary.json two/summary.json");
    assert_eq!(compared.status, 0);
    assert!(!compared.out.contains(",work,"), "{}", compared.out);
    folder.write(
        "other.json",
        one.replace("\"wrong\": 0.0", "\"wrong\": 3.0"),
    );
    let changed = folder.run("compare one/summary.json other.json");
    changed.prints("wrong,work,0.0000,3.0000,+3.0000");
}

fn figure(summary: &str, name: &str) -> f64 {
    let rest = &summary[summary.find(&format!("\"{name}\": ")).expect(name) + name.len() + 4..];
    rest[..rest.find([',', '\n']).unwrap()].parse().unwrap()
}

/// Lower bounds only rise and upper ones only fall with the work, and with all of a depth-first query it is finished.
fn bounds_close_in(table: &str) {
    let mut before = [0.0, 0.0, f64::INFINITY, f64::INFINITY, 0.0, 0.0];
    let mut lines = 0;
    for line in table.lines().filter(|line| line.contains(",work_percent,")) {
        let fields: Vec<&str> = line.split(',').collect();
        let numbers: Vec<f64> = fields[5..]
            .iter()
            .map(|field| field.parse().unwrap())
            .collect();
        if fields[3] == "1" {
            before = [0.0, 0.0, f64::INFINITY, f64::INFINITY, 0.0, 0.0];
        }
        for (i, (now, before)) in numbers.iter().zip(before).enumerate() {
            assert!(
                if i == 2 || i == 3 {
                    *now <= before
                } else {
                    *now >= before
                },
                "{line}"
            );
        }
        assert!(
            fields[4].parse::<u32>().unwrap() > 0 && numbers[1] <= 1.0 && numbers[2] >= 1.0,
            "{line}"
        );
        assert!(
            fields[3] != "100" || fields[1] != "depth-first" || numbers[4..] == [1.0, 1.0],
            "{line}"
        );
        before.copy_from_slice(&numbers);
        lines += 1;
    }
    assert_eq!(lines, 6 * 3 * 9);
}

/// The best order has found at least the pairs of every other by each budget, and a first contact as often. For all pairs the
/// library follows curves in each order, and so it is no order of visits.
fn no_order_is_ahead_of_the_best(summary: &str) {
    let figure = |name: &str| figure(summary, name);
    for percent in [1, 2, 5, 10, 20, 30, 50, 70, 100] {
        for what in ["any", "recall"] {
            let best = figure(&format!("{what}@{percent}% oracle"));
            let orders = [
                "depth-first",
                "cut-off",
                "penetration",
                "low-alpha",
                "stack",
            ];
            let marches = |order: &&str| what == "recall" && orders[2..].contains(order);
            for order in orders.iter().filter(|order| !marches(order)) {
                let reached = figure(&format!("{what}@{percent}% {order}"));
                assert!(reached <= best, "{what} {percent} {order} {reached} {best}");
            }
        }
    }
}

#[test]
fn a_broken_guarantee_is_told() {
    let (folder, _) = crate::spheres();
    std::fs::create_dir(folder.path().join("case")).unwrap();
    for name in ["a.obj", "b.obj", "poses.txt"] {
        folder.write(&format!("case/{name}"), folder.read(name));
    }
    assert_eq!(folder.run("sweep case --quick --out report").status, 0);
    // A truth with one pair too many: no certificate may leave it out.
    let truth = folder.read("report/truth/case.csv");
    folder.write(
        "report/truth/case.csv",
        truth.replace("# end", "4,0,0\n# end"),
    );
    let answer = folder.run("sweep case --quick --out report");
    assert_eq!(answer.status, 1);
    answer.tells("case pose 4");
    answer.tells("at most 0 pairs");
    let page = folder.read("report/index.html");
    // Wrong answers and false bounds.
    assert_eq!(page.matches("verdict no").count(), 2 * 2);
}

#[test]
fn a_truth_that_differs_is_noticed() {
    let folder = Folder::new();
    let case = folder.path().join("case");
    std::fs::create_dir(&case).unwrap();
    for name in ["case/a.obj", "case/b.obj"] {
        folder.write(name, crate::write::obj(&punctual::shapes::icosphere(2)));
    }
    folder.write(
        "case/poses.txt",
        "1 0 0 0.9 0 1 0 0 0 0 1 0\n1 0 0 5 0 1 0 0 0 0 1 0\n",
    );
    folder.write("case/truth.csv", "pose,hit,pairs\n0,1,1\n1,0,0\n");
    let answer = folder.run("sweep case --quick --out report");
    assert_eq!(answer.status, 1);
    answer.tells("case pose 0");
    answer.tells("truth.csv has 1");
    // The cached truth is used, and a false one is noticed.
    folder.write("case/truth.csv", "pose,hit,pairs\n");
    folder.refused("sweep case --quick --out report", &["truth.csv"]);
    std::fs::remove_file(case.join("truth.csv")).unwrap();
    let cached = folder.read("report/truth/case.csv");
    let lines: Vec<&str> = cached.lines().collect();
    folder.write(
        "report/truth/case.csv",
        [&lines[..1], &lines[2..]].concat().join("\n") + "\n",
    );
    let answer = folder.run("sweep case --quick --out report");
    assert_eq!(answer.status, 1);
    answer.tells("wrong");
}

/// Two cubes of edge 2, one apart along x, and in contact.
fn cubes() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path().join("case")).unwrap();
    for name in ["case/a.obj", "case/b.obj"] {
        folder.write(
            name,
            crate::write::obj(&punctual::shapes::cuboid([1.0; 3], 4)),
        );
    }
    folder.write(
        "case/poses.txt",
        "1 0 0 3 0 1 0 0 0 0 1 0\n1 0 0 1.5 0 1 0 0 0 0 1 0\n",
    );
    folder.write("case/truth_distance.csv", "pose,distance\n0,1\n1,0\n");
    folder
}

#[test]
fn distances_are_compared_with_the_truth() {
    let folder = cubes();
    folder.ok("sweep case --quick --distance-only --out report");
    let summary = folder.read("report/summary.json");
    for goal in [
        "upper bound within 10 % of the distance",
        "bounds within 10 % of each other",
    ] {
        let reached = ["nearest-first", "depth-first", "told"]
            .map(|order| figure(&summary, &format!("{goal}: work {order}")));
        assert!(
            reached.iter().all(|share| *share > 0.0 && *share < 1.5),
            "{goal}: {reached:?}"
        );
    }
    let page = folder.read("report/index.html");
    // Of all cases and of this one.
    assert_eq!(page.matches("<svg").count(), 4 + 4);
    assert!(!page.contains("Which triangles meet?"));
    for wrong in ["0,1.01\n1,0", "0,0.99\n1,0", "0,1\n1,0.001"] {
        folder.write(
            "case/truth_distance.csv",
            format!("pose,distance\n{wrong}\n"),
        );
        let answer = folder.run("sweep case --quick --distance-only --out report");
        assert_eq!(answer.status, 1);
        answer.tells("case pose ");
        answer.tells("apart");
        assert!(folder.read("report/index.html").contains("verdict no"));
    }
    folder.write("case/truth_distance.csv", "pose,distance\n0,far\n1,0\n");
    folder.refused(
        "sweep case --quick --out report",
        &["truth_distance.csv:2", "distance"],
    );
}

#[test]
fn times_of_other_libraries_are_shown_beside_ours() {
    let folder = cubes();
    let rows = "case,peer,pose,distance,ns,bv_tests,tri_tests\n# case=case peer=theirs\n\
        case,theirs,0,1,432100,-1,-1\ncase,theirs,0,1,654300,-1,-1\ncase,theirs,1,0,98765000,-1,-1\nelse,theirs,0,1,1,-1,-1\n";
    folder.write("times.csv", rows);
    let sweep = "sweep case --quick --distance-only --out report --peer-times times.csv";
    assert_eq!(folder.run(sweep).status, 0);
    let page = folder.read("report/index.html");
    // Of all cases and of this one, over time; the least time, and only where the meshes are apart.
    assert_eq!(page.matches("theirs has its answer").count(), 4);
    assert!(page.contains("<td>432 / 432</td>") && !page.contains("98765"));
    for bad in [
        "case,theirs,x,1,5",
        "case,theirs,0,1",
        "case,theirs,0,1,-5",
        "case,theirs,0,1,nan",
    ] {
        folder.write("times.csv", format!("case,peer,pose,distance,ns\n{bad}\n"));
        folder.refused(sweep, &["times.csv:2"]);
    }
    folder.refused(
        "sweep case --out report --peer-times none.csv",
        &["none.csv"],
    );
}

/// A report without poses in contact, or without poses apart, or of one pose, has no figure that is not a number.
#[test]
fn unmeasured_figures_are_explained_in_words() {
    let folder = cubes();
    let [apart, touching] = ["1 0 0 3 0 1 0 0 0 0 1 0\n", "1 0 0 1.5 0 1 0 0 0 0 1 0\n"];
    std::fs::remove_file(folder.path().join("case/truth_distance.csv")).unwrap();
    for (poses, said) in [(apart, "meet at no pose"), (touching, "meet at every pose")] {
        folder.write("case/poses.txt", poses);
        let _ = std::fs::remove_dir_all(folder.path().join("report"));
        let answer = folder.ok("sweep case --quick --out report");
        assert!(
            answer.out.contains(said) && !answer.out.contains("NaN"),
            "{}",
            answer.out
        );
        let page = folder.read("report/index.html");
        assert!(!page.contains("NaN"), "{said}");
        assert!(page.contains("1 case of two meshes, 1 pose,"), "{said}");
    }
}

/// Above 1 more work, below 1 less.
#[test]
fn the_first_contact_is_told_as_a_share_of_depth_first() {
    let folder = cubes();
    let answer = folder.run("sweep case --quick --out report");
    let share = answer.out.lines().find_map(|line| {
        line.strip_prefix("first contact found with ")?
            .split_once(' ')
    });
    let share: f64 = share.expect(&answer.out).0.parse().unwrap();
    let gain = figure(
        &folder.read("report/summary.json"),
        "first hit over depth-first penetration work",
    );
    assert!((share - 1.0 / gain).abs() < 0.005 + 1e-9, "{share} {gain}");
}

#[test]
fn orders_and_budgets_can_be_chosen() {
    let folder = cubes();
    let choice = "--orders low-alpha --work-percent 40,10,40 --time-us 7";
    let answer = folder.ok(&format!("sweep case --quick --out report {choice}"));
    answer.prints("detected with 10 % of the work");
    let table = folder.read("report/sweep.csv");
    let column = |i: usize| {
        table
            .lines()
            .skip(1)
            .map(|line| line.split(',').nth(i).unwrap())
            .collect::<BTreeSet<_>>()
    };
    let orders = [
        "cut-off",
        "depth-first",
        "low-alpha",
        "oracle",
        "penetration",
        "warm",
    ];
    assert_eq!(column(2).into_iter().collect::<Vec<_>>(), orders);
    assert_eq!(column(5).into_iter().collect::<Vec<_>>(), ["10", "40", "7"]);
    for bad in [
        "--orders deepest",
        "--orders depth-first",
        "--work-percent 0",
        "--work-percent 101",
        "--time-us 0",
    ] {
        let option = bad.split_once(' ').unwrap().0;
        folder.refused(&format!("sweep case --quick --out report {bad}"), &[option]);
    }
}

/// One command leads from two meshes to the page. Its first picture tells what is known when the time is up.
#[test]
fn two_meshes_are_a_case() {
    let folder = Folder::new();
    folder.write("knot.obj", write::obj(&torus_knot(2, 3, 0.2, 24)));
    folder.write("cube.obj", write::obj(&cuboid([0.5, 0.4, 0.3], 3)));
    folder.ok("sweep knot.obj cube.obj --quick --out one");
    let page = folder.read("one/index.html");
    assert!(page.contains("1 case of two meshes, 32 poses,"), "{page}");
    assert!(page.contains("The poses of two mesh files were made:"));
    let first = page.find("<svg").unwrap();
    let heading = page[..first].rfind("What is known when the time is up?");
    assert!(heading.is_some());
    let picture = &page[first..first + page[first..].find("</svg>").unwrap()];
    for what in ["contact detected", "pairs found", "distance within 10 %"] {
        for order in ["this library", "depth-first"] {
            assert!(picture.contains(&format!("{what}: {order}")), "{what}");
        }
    }
    // Of each line the same number of poses meets, those past the touch.
    let poses = folder.read("one/knot_cube_poses.txt");
    let answers = folder.run("pair knot.obj cube.obj one/knot_cube_poses.txt");
    let met = answers
        .out
        .lines()
        .skip(2)
        .take(28)
        .filter(|row| row.contains("intersecting"));
    assert!((12..=16).contains(&met.count()), "{}", answers.out);
    assert_eq!(
        folder
            .run("sweep knot.obj cube.obj --quick --distance-only --out two")
            .status,
        0
    );
    assert_eq!(folder.read("two/knot_cube_poses.txt"), poses);
    for (meshes, named) in [
        (
            "knot.obj",
            "knot.obj: a mesh file must be followed by another",
        ),
        (
            "knot.obj one",
            "knot.obj: a mesh file must be followed by another",
        ),
        ("knot.obj none.obj", "none.obj: No such file"),
        ("none.obj knot.obj", "none.obj: No such file"),
    ] {
        let refused = folder.run(&format!("sweep {meshes} --quick --out three"));
        refused.assert_refused(&[named]);
    }
}

#[test]
fn bad_cases_are_refused() {
    let folder = Folder::new();
    folder.refused("sweep nowhere --out report", &["nowhere"]);
    folder.refused("sweep --out report", &["CASE_DIR"]);
    folder.write("bad.json", "{}");
    folder.refused("compare bad.json bad.json", &["bad.json", "work"]);
}
