//! `punctual sweep` and `punctual compare`.

use crate::run::Folder;

const FILES: [&str; 16] = [
    "index.html",
    "summary.json",
    "sweep.csv",
    "any.svg",
    "any.png",
    "all.svg",
    "all.png",
    "coverage.png",
    "any-time.svg",
    "all-time.svg",
    "late.svg",
    "overview.svg",
    "volume-left.svg",
    "cases/gear_gear-work.svg",
    "cases/gear_gear-all-time.svg",
    "truth/knot_sphere.csv",
];

/// The part of a summary that holds figures of work, as it is written.
fn work(summary: &str) -> &str {
    &summary[summary.find("\"work\"").unwrap()..]
}

#[test]
fn a_sweep_is_never_wrong_and_its_work_is_repeatable() {
    let folder = Folder::new();
    let first = folder.run("sweep --builtin --quick --out one");
    assert_eq!((first.status, first.err.as_str()), (0, ""));
    assert!(first.out.contains("wrong: 0\n"), "{}", first.out);
    for file in FILES {
        assert!(folder.path().join("one").join(file).metadata().unwrap().len() > 100, "{file}");
    }
    assert_eq!(folder.run("sweep --builtin --quick --out two").status, 0);
    let [one, two] = ["one", "two"].map(|name| folder.read(&format!("{name}/summary.json")));
    assert_eq!(work(&one), work(&two));
    assert!(work(&one).contains("\"wrong\": 0.0"));
    let rows = |name: &str| -> Vec<String> {
        let table = folder.read(&format!("{name}/sweep.csv"));
        table.lines().filter(|line| line.contains(",work_percent,")).map(str::to_owned).collect()
    };
    assert_eq!(rows("one"), rows("two"));
    assert!(rows("one").len() > 1000);
    let page = folder.read("one/index.html");
    assert!(!page.contains("<script"));
    // Verdicts are on the three guarantees, and on nothing else.
    assert_eq!(page.matches("<h3>Verdict</h3>").count(), 3);
    assert_eq!(page.matches("verdict yes").count(), 2 * 3);
    // Nine plots of all cases, three of each of the six.
    assert_eq!(page.matches("<svg").count(), 9 + 3 * 6);
    no_order_is_ahead_of_the_best(&one);

    let compared = folder.run("compare one/summary.json two/summary.json");
    assert_eq!(compared.status, 0);
    assert!(!compared.out.contains(",work,"), "{}", compared.out);
    folder.write("other.json", one.replace("\"wrong\": 0.0", "\"wrong\": 3.0"));
    let changed = folder.run("compare one/summary.json other.json");
    assert!(changed.out.contains("wrong,work,0.0000,3.0000,+3.0000"), "{}", changed.out);
}

/// The best order has found at least the pairs of every other by each budget, and a first contact as often.
fn no_order_is_ahead_of_the_best(summary: &str) {
    let figure = |name: &str| {
        let rest = &summary[summary.find(&format!("\"{name}\": ")).expect(name) + name.len() + 4..];
        rest[..rest.find([',', '\n']).unwrap()].parse::<f64>().unwrap()
    };
    for percent in [1, 2, 5, 10, 20, 30, 50, 70, 100] {
        for what in ["any", "recall"] {
            let best = figure(&format!("{what}@{percent}% oracle"));
            for order in
                ["penetration", "depth-first", "low-alpha", "overlap-volume", "breadth-first", "random", "cut-off"]
            {
                let reached = figure(&format!("{what}@{percent}% {order}"));
                assert!(reached <= best, "{what}@{percent}% {order}: {reached} > {best}");
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
    folder.write("report/truth/case.csv", truth.replace("# end", "4,0,0\n# end"));
    let answer = folder.run("sweep case --quick --out report");
    assert_eq!(answer.status, 1);
    assert!(answer.err.contains("case pose 4") && answer.err.contains("at most 0 pairs"), "{}", answer.err);
    let page = folder.read("report/index.html");
    assert_eq!(page.matches("verdict no").count(), 2 * 2, "wrong answers and false bounds");
}

#[test]
fn a_truth_that_differs_is_noticed() {
    let folder = Folder::new();
    let case = folder.path().join("case");
    std::fs::create_dir(&case).unwrap();
    for name in ["case/a.obj", "case/b.obj"] {
        folder.write(name, crate::write::obj(&punctual::shapes::icosphere(2)));
    }
    folder.write("case/poses.txt", "1 0 0 0.9 0 1 0 0 0 0 1 0\n1 0 0 5 0 1 0 0 0 0 1 0\n");
    folder.write("case/truth.csv", "pose,hit,pairs\n0,1,1\n1,0,0\n");
    let answer = folder.run("sweep case --quick --out report");
    assert_eq!(answer.status, 1);
    assert!(answer.err.contains("case pose 0") && answer.err.contains("truth.csv has 1"), "{}", answer.err);
    // The cached truth is used, and a false one is noticed.
    folder.write("case/truth.csv", "pose,hit,pairs\n");
    folder.run("sweep case --quick --out report").assert_refused(&["truth.csv"]);
    std::fs::remove_file(case.join("truth.csv")).unwrap();
    let cached = folder.read("report/truth/case.csv");
    let lines: Vec<&str> = cached.lines().collect();
    folder.write("report/truth/case.csv", [&lines[..1], &lines[2..]].concat().join("\n") + "\n");
    let answer = folder.run("sweep case --quick --out report");
    assert_eq!(answer.status, 1);
    assert!(answer.err.contains("wrong"), "{}", answer.err);
}

#[test]
fn bad_cases_are_refused() {
    let folder = Folder::new();
    folder.run("sweep nowhere --out report").assert_refused(&["nowhere"]);
    folder.run("sweep --out report").assert_refused(&["CASE_DIR"]);
    folder.write("bad.json", "{}");
    folder.run("compare bad.json bad.json").assert_refused(&["bad.json", "work"]);
}
