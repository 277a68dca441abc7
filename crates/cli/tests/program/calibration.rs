//! `punctual pair --calibration FILE`: what one run learns is there in the next, and a damaged file is none.

use crate::run::Folder;
use crate::spheres;
use punctual::prediction::Calibration;

const CUT: &str = "pair a.obj b.obj poses.txt --budget-work 300";

fn probabilities(folder: &Folder, options: &str) -> Vec<f64> {
    let answer = folder.ok(&format!("{CUT} {options}"));
    answer
        .rows()
        .iter()
        .map(|row| row.probability.unwrap())
        .collect()
}

fn read(folder: &Folder) -> Calibration {
    serde_json::from_str(&folder.read("c.json")).unwrap()
}

#[test]
fn a_learned_calibration_is_used_by_the_next_run() {
    let (folder, truth) = spheres();
    let told = probabilities(&folder, "");
    let undecided: Vec<usize> = (0..told.len())
        .filter(|&pose| told[pose] > 0.0 && told[pose] < 1.0)
        .collect();
    assert!(undecided.len() >= 2, "{told:?}");
    let first = probabilities(&folder, "--calibration c.json");
    // Nothing was known before.
    assert_eq!(first[undecided[0]], told[undecided[0]]);
    let learned = read(&folder);
    assert_ne!(learned, Calibration::default());
    // The same by hand, from what was told; the columns have four digits.
    let mut by_hand = Calibration::default();
    for &pose in &undecided {
        assert!(
            (first[pose] - by_hand.apply(told[pose])).abs() < 2e-4,
            "{first:?}"
        );
        by_hand.learn(told[pose], truth[pose] > 0);
    }
    assert!(
        (by_hand.offset() - learned.offset()).abs() < 1e-3
            && (by_hand.slope() - learned.slope()).abs() < 1e-3
    );
    for _ in 0..20 {
        let _ = probabilities(&folder, "--calibration c.json");
    }
    let taught = probabilities(&folder, "--calibration c.json");
    let error = |said: &[f64]| {
        undecided
            .iter()
            .map(|&i| (said[i] - f64::from(u8::from(truth[i] > 0))).powi(2))
            .sum::<f64>()
    };
    assert!(error(&taught) < error(&told), "{told:?}");
    for (said, told) in taught
        .iter()
        .zip(&told)
        .filter(|(_, told)| **told == 0.0 || **told == 1.0)
    {
        assert_eq!(said, told, "what is decided is certain");
    }
    // Nothing but the file is left behind.
    let names = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name());
    let mut names: Vec<_> = names.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["a.obj", "b.obj", "c.json", "poses.txt"]);
}

#[test]
fn learning_changes_no_answer_and_no_count() {
    let (folder, _) = spheres();
    for mode in ["any", "all"] {
        let plain = folder.run(&format!("{CUT} --mode {mode} --memory")).rows();
        let learning = folder
            .run(&format!(
                "{CUT} --mode {mode} --memory --reps 2 --calibration {mode}.json"
            ))
            .rows();
        for (plain, mut learning) in plain.into_iter().zip(learning) {
            learning.probability = plain.probability;
            assert_eq!(plain, learning);
        }
    }
}

#[test]
fn a_run_without_a_budget_learns_nothing() {
    let (folder, _) = spheres();
    assert_eq!(
        folder
            .run("pair a.obj b.obj poses.txt --calibration c.json")
            .status,
        0
    );
    assert_eq!(read(&folder), Calibration::default());
}

#[test]
fn a_damaged_file_is_refused_and_stays_as_it_is() {
    let (folder, _) = spheres();
    let good = r#"{"offset":0.5,"slope":1.5,"evidence":[3.0,1.0,4.0]}"#;
    folder.write("c.json", good);
    assert_ne!(
        probabilities(&folder, "--calibration c.json"),
        probabilities(&folder, "")
    );
    let damaged = [
        ("", "c.json:1: column 0: EOF"),
        (&good[..20], "c.json:1: column 20: EOF"),
        ("{\n\"offset\": x}", "c.json:2: column 11: expected value"),
        (
            &good.replace("0.5", "null"),
            "c.json:1: column 14: invalid type: null, expected f64",
        ),
        (
            &good.replace("0.5", "9"),
            "c.json: offset 9.0 is out of range",
        ),
        (&good.replace("1.5", "-1.5"), "slope -1.5 is out of range"),
        (
            &good.replace("1.5", "1e999"),
            "c.json:1: column 27: number out of range",
        ),
        (
            &good.replace("4.0", "0.0"),
            "evidence[1] 1.0 is out of range",
        ),
        (&good.replace("slope", "slop"), "unknown field `slop`"),
        ("\u{feff}", "c.json:1: column 1: "),
    ];
    for (text, what) in damaged {
        folder.write("c.json", text);
        folder.refused(&format!("{CUT} --calibration c.json"), &[what]);
        assert_eq!(folder.read("c.json"), text);
    }
    folder.write("c.json", [b'{', 0xff, 0xfe]);
    folder.refused(
        &format!("{CUT} --calibration c.json"),
        &["c.json:1: column 2: "],
    );
    folder.refused(&format!("{CUT} --calibration ."), &[".: "]);
    let lost = folder.run(&format!("{CUT} --calibration no/c.json"));
    // The answers are there all the same.
    assert_eq!((lost.status, lost.rows().len()), (2, 5));
    lost.tells("no/c.json: ");
}
