//! The motions with known times of contact beside the repository, where they are.

use punctual::{Motion, Pose, Query, StopReason, Tree, Workspace};

use crate::common::files::{Soup, folders, shared, text, value};
use crate::judge::{ENOUGH, run};

/// What is left of the distance at the listed times, over the radius of A.
const GAP: f64 = 1e-9;

#[test]
fn no_contact_of_the_listed_motions_is_missed() {
    let Some(folder) = shared("meshes/sweeps") else {
        return;
    };
    let mut workspace = Workspace::new();
    for case in folders(&folder, "") {
        let listed = text(&case.join("case.txt"));
        let [a, b] = ["a", "b"].map(|key| case.join(value(&listed, key).unwrap()));
        let [a, b] = [a, b].map(|file| Tree::new(Soup::read(&file).mesh().unwrap()));
        let truth = text(&case.join("truth_sweep.csv"));
        let sweeps = text(&case.join("sweeps.txt"));
        let mut hits = 0;
        for (line, known) in sweeps.lines().zip(truth.lines().skip(1)) {
            let numbers: Vec<f64> = line
                .split_whitespace()
                .map(|word| word.parse().unwrap())
                .collect();
            let [start @ .., x, y, z] = &numbers[..] else {
                panic!("{line}")
            };
            let start = Pose::from_row_major(start.try_into().unwrap()).unwrap();
            let motion = Motion::straight(start, [*x, *y, *z]).unwrap();
            let said = run(&Query::impact(&a, &b, motion), &mut workspace, ENOUGH);
            assert_eq!(said.stop, StopReason::Finished);
            let [_, hit, time, _] = known.split(',').collect::<Vec<_>>()[..] else {
                panic!("{known}")
            };
            assert_eq!(said.value.upper.is_some(), hit == "1", "{known}: {said:?}");
            if let Some(touching) = said.value.upper {
                let time: f64 = time.parse().unwrap();
                let close = 100.0 * GAP * a.unit_length() / motion.velocity().length();
                assert!(
                    said.value.lower <= time + close && time <= touching,
                    "{known}: {said:?}"
                );
                assert!(
                    (touching - said.value.lower) * motion.velocity().length()
                        < 3e-6 * (a.unit_length() + b.unit_length())
                );
                hits += 1;
            } else {
                assert!(said.value.lower >= 1.0, "{known}: {said:?}");
            }
        }
        println!("{}: {hits} contacts", case.display());
    }
}
