//! Robots in their cells, with exact truth beside the repository; passes without it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use punctual::{Budget, Pose};
use punctual_robot::{
    Checker, ClearanceOptions, Collision, EdgeAnswer, EdgeOptions, Model, Shape, UrdfOptions,
};

const UNLIMITED: Budget = Budget::unlimited();

struct Robot {
    folder: PathBuf,
    checker: Checker,
    configs: Vec<Vec<f64>>,
}

fn robots() -> Vec<Robot> {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/robots");
    let folders = std::fs::read_dir(shared).into_iter().flatten().flatten();
    folders.map(|folder| robot(folder.path())).collect()
}

fn robot(folder: PathBuf) -> Robot {
    let options = UrdfOptions::default().srdf(folder.join("robot.srdf"));
    let model = Model::from_urdf(folder.join("robot.urdf"), &options).unwrap();
    let mut checker = Checker::new(Arc::new(model));
    // In the order of the table, so that ids are its numbers.
    for row in rows(&folder.join("environment.csv")) {
        let [name, file] = [0, 1].map(|column| row.split(',').nth(column).unwrap().to_owned());
        let mesh = punctual_io::load(&folder.join(file)).unwrap().mesh;
        checker
            .add(&name, Pose::IDENTITY, Shape::mesh(mesh))
            .unwrap();
    }
    let configs = numbers(&folder.join("configs.csv"));
    Robot {
        folder,
        checker,
        configs,
    }
}

fn rows(file: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(file).unwrap();
    text.lines().skip(1).map(str::to_owned).collect()
}

fn numbers(file: &Path) -> Vec<Vec<f64>> {
    let row = |row: &String| {
        row.split(',')
            .map(|x| x.parse().unwrap_or(f64::NAN))
            .collect()
    };
    rows(file).iter().map(row).collect()
}

#[test]
fn links_are_where_the_table_says() {
    for robot in robots() {
        use std::io::Read;
        let file = std::fs::File::open(robot.folder.join("poses.csv.gz")).unwrap();
        let mut text = String::new();
        flate2::read::GzDecoder::new(file)
            .read_to_string(&mut text)
            .unwrap();
        let model = robot.checker.model();
        let names: Vec<&str> = model.link_names().collect();
        for line in text.lines().skip(1) {
            let fields: Vec<&str> = line.split(',').collect();
            let config: usize = fields[0].parse().unwrap();
            let poses = model.link_poses(&robot.configs[config]).unwrap();
            let link = names.iter().position(|name| *name == fields[1]).unwrap();
            let want = fields[2..].iter().map(|x| x.parse::<f64>().unwrap());
            for (found, want) in poses[link].to_row_major().into_iter().zip(want) {
                assert!((found - want).abs() < 1e-14, "{line}: {found}");
            }
        }
    }
}

#[test]
fn the_pairs_asked_are_those_of_the_table() {
    for robot in robots() {
        let mut found: Vec<_> = robot
            .checker
            .pairs()
            .map(|pair| pair.map(|id| id.number()))
            .collect();
        let mut want: Vec<_> = (numbers(&robot.folder.join("pairs.csv")).iter())
            .map(|row| [row[0] as u32, row[1] as u32])
            .collect();
        found.sort_unstable();
        want.sort_unstable();
        assert_eq!(found, want);
    }
}

#[test]
fn no_label_is_wrong() {
    for mut robot in robots() {
        let labels = numbers(&robot.folder.join("labels.csv"));
        let mut pairs = Vec::new();
        let all = robot.configs.concat();
        let batch = robot.checker.collide_batch(&all, UNLIMITED, 2).unwrap();
        let cut = robot
            .checker
            .collide_batch(&all, Budget::work(4_000), 2)
            .unwrap();
        let mut undecided = 0;
        for (i, label) in labels.iter().enumerate() {
            let meets = label[1] == 1.0;
            let q = &robot.configs[i];
            let one = robot.checker.collide(q, UNLIMITED).unwrap();
            for found in [one, batch[i]] {
                assert_eq!(found.value != Collision::Free, meets, "{i}");
            }
            match cut[i].value {
                Collision::Undecided => undecided += 1,
                value => assert_eq!(value != Collision::Free, meets),
            }
            let _ = robot.checker.collide_all(q, UNLIMITED, &mut pairs).unwrap();
            assert_eq!(pairs.len() as f64, label[3], "{:?} {i}", robot.folder);
        }
        assert!(undecided > 0 && undecided < labels.len());
    }
}

#[test]
fn clearance_is_that_of_the_table() {
    for mut robot in robots() {
        for row in numbers(&robot.folder.join("clearance.csv")) {
            let q = &robot.configs[row[0] as usize];
            for tolerance in [1e-9, 1e-4] {
                let options = ClearanceOptions::default().tolerance(tolerance);
                let found = robot
                    .checker
                    .clearance(q, &options, UNLIMITED)
                    .unwrap()
                    .value;
                assert!(found.low <= row[2] && row[1] <= found.high, "{row:?}");
                assert!(found.high - found.low <= tolerance * 1.001, "{row:?}");
            }
        }
    }
}

#[test]
fn no_edge_is_contradicted() {
    for mut robot in robots() {
        let n = robot.configs[0].len();
        let text = rows(&robot.folder.join("edges.csv"));
        for (row, text) in numbers(&robot.folder.join("edges.csv")).iter().zip(text) {
            let is_free = text.split(',').nth(2 * n + 2) == Some("free");
            let [low, high] = [row[2 * n + 3], row[2 * n + 4]];
            for options in [EdgeOptions::any(), EdgeOptions::first()] {
                let (from, to) = (&row[1..=n], &row[n + 1..=2 * n]);
                let found = robot
                    .checker
                    .edge(from, to, &options, UNLIMITED)
                    .unwrap()
                    .value;
                let answer = if is_free {
                    EdgeAnswer::Free
                } else {
                    EdgeAnswer::Contact
                };
                assert_eq!(found.answer, answer, "{:?} {text}", robot.folder);
                let at = found.touching_at.unwrap_or(1.0);
                assert!(found.free_until <= high && low <= at, "{found:?} {text}");
                if options.first {
                    assert!((at - high).abs() < 1e-5, "{found:?} {text}");
                }
            }
        }
    }
}
