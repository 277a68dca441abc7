//! `punctual sweep` and `punctual compare`.

use crate::run::Folder;

const FILES: [&str; 12] = [
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
    assert!(page.contains("<svg") && !page.contains("<script"));

    let compared = folder.run("compare one/summary.json two/summary.json");
    assert_eq!(compared.status, 0);
    assert!(!compared.out.contains(",work,"), "{}", compared.out);
    folder.write("other.json", one.replace("\"wrong\": 0.0", "\"wrong\": 3.0"));
    let changed = folder.run("compare one/summary.json other.json");
    assert!(changed.out.contains("wrong,work,0.0000,3.0000,+3.0000"), "{}", changed.out);
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
