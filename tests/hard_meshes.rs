//! Mesh cases made to be hard, with exact truth: flush faces, coincident meshes, degenerate triangles, huge and tiny
//! coordinates, invalid input. A few live in `fixtures/meshes`; the rest, if present, beside the repository.

mod common;

use std::path::Path;

use common::check::{self, ENOUGH, assert_complete, run, run_to_end};
use common::files::{self, Soup, Truth};
use common::reference::all_pairs;
use common::steps::assert_step;
use common::{MODES, ORDERS};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DQuat, DVec3, Mat3, Vec3};
use punctual::prediction::MAX_STEP_WORK;
use punctual::{Budget, Mesh, Pose, PoseError, Query, StopReason, Tree, Verdict, Workspace};

/// Cases where the case file also allows an error, but this library promises an answer.
const ANSWERED: [&str; 4] = [
    "empty_both",
    "empty_mesh",
    "vertex_nan_unused",
    "vertices_no_triangles",
];

fn assert_case(folder: &Path, workspace: &mut Workspace) {
    println!("{}", folder.display());
    let name = folder.file_name().unwrap().to_str().unwrap();
    let case = files::text(&folder.join("case.txt"));
    let expect = files::value(&case, "expect").unwrap();
    let error_allowed = expect != "truth" && !ANSWERED.contains(&name);
    let [a, b] = ["a.obj", "b.obj"].map(|file| Soup::read(&folder.join(file)));
    let poses = files::poses(&folder.join("poses.txt"));
    let truths = files::truth(&folder.join("truth.csv"));
    assert_eq!(poses.len(), truths.len());
    let trees = a
        .mesh()
        .and_then(|a| Ok([Tree::new(a), Tree::new(b.mesh()?)]));
    for (pose, truth) in poses.iter().zip(&truths) {
        match (&trees, pose, *truth) {
            (Ok([a, b]), Ok(pose), Truth::Pairs(pairs)) if expect != "error" => {
                assert_answers(a, b, *pose, pairs, workspace);
            }
            (Ok(_), Ok(_), _) => panic!("{name}: an error is due, got an answer"),
            (Err(error), _, _) => assert!(error_allowed, "{name}: {error}"),
            (_, Err(error), _) => assert!(error_allowed, "{name}: {error}"),
        }
    }
    if expect == "truth" {
        let [a, b] = [a, b].map(|soup| Tree::new(soup.rounded_mesh().unwrap()));
        let truths = files::truth(&folder.join("truth_f32v.csv"));
        for (pose, truth) in poses.into_iter().zip(truths) {
            let Truth::Pairs(pairs) = truth else { continue };
            assert_answers(&a, &b, pose.unwrap(), pairs, workspace);
        }
    }
}

/// The right number of pairs, and they are the right pairs, in every mode and order.
fn assert_answers(a: &Tree, b: &Tree, pose: Pose, pairs: u64, workspace: &mut Workspace) {
    let truth = all_pairs(a.mesh(), b.mesh(), &pose);
    assert_eq!(truth.len() as u64, pairs, "brute force");
    for mode in MODES {
        for order in ORDERS {
            let query = Query::intersection(a, b, pose).mode(mode).order(order);
            for (query, budget) in [(query, Budget::unlimited()), (query, ENOUGH)] {
                let (outcome, found) = run_to_end(&query, workspace, budget);
                assert_complete(mode, &outcome, &found, &truth);
            }
        }
    }
}

#[test]
fn cases_of_this_repository() {
    let parent = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/meshes");
    let folders = files::folders(&parent, "");
    assert_eq!(folders.len(), 11);
    for folder in folders {
        assert_case(&folder, &mut Workspace::new());
    }
}

#[test]
fn cases_beside_the_repository() {
    let Some(parent) = files::shared("hardcases/meshes") else {
        return;
    };
    let folders = files::folders(&parent, "");
    assert_eq!(folders.len(), 30);
    let mut workspace = Workspace::new();
    for folder in folders {
        assert_case(&folder, &mut workspace);
    }
}

fn identity_with(entry: usize, value: f64) -> [f64; 12] {
    let mut rows = Pose::IDENTITY.to_row_major();
    rows[entry] = value;
    rows
}

/// Each entry in turn: what is not finite is named, never taken for "no contact".
#[test]
fn a_pose_that_is_not_finite_is_an_error() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for entry in 0..12 {
            let error = Pose::from_row_major(identity_with(entry, bad)).unwrap_err();
            assert!(matches!(error, PoseError::NotFinite { entry: at } if at == entry));
        }
        let [x, y, z] = DMat3::IDENTITY.to_cols_array_2d().map(DVec3::from_array);
        assert!(Pose::from_axes(x, y * bad, z, DVec3::ZERO).is_err());
        assert!(Pose::from_quat(DQuat::from_xyzw(0.0, bad, 0.0, 1.0), DVec3::ZERO).is_err());
        assert!(Pose::from_quat(DQuat::IDENTITY, DVec3::splat(bad)).is_err());
    }
    let infinite = Vec3::new(0.0, f32::INFINITY, 0.0);
    assert!(Pose::from_f32(Mat3::IDENTITY, infinite).is_err());
}

#[test]
fn a_pose_that_is_not_a_rotation_is_an_error() {
    let stretched = |by: f64| DMat3::from_diagonal(DVec3::new(1.0, by, 1.0));
    let sheared = |by: f64| DMat3::from_cols(DVec3::X, DVec3::new(by, 1.0, 0.0), DVec3::Z);
    let refused = [
        DMat3::ZERO,
        DMat3::from_diagonal(DVec3::NEG_ONE),
        DMat3::from_diagonal(DVec3::new(1e200, 1.0, 1.0)),
        stretched(0.0),
        stretched(-1.0),
        stretched(2.0),
        stretched(1.000_51),
        stretched(0.999_49),
        sheared(0.5),
        sheared(1.01e-3),
    ];
    for matrix in refused {
        let error = Pose::new(matrix, DVec3::ZERO).unwrap_err();
        assert!(matches!(error, PoseError::NotARotation { .. }), "{matrix}");
    }
    for matrix in [stretched(1.000_49), stretched(0.999_51), sheared(0.99e-3)] {
        let pose = Pose::new(matrix, DVec3::ZERO).unwrap();
        assert_eq!(*pose.rotation(), matrix, "taken as given");
    }
    let nothing = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let error = Pose::from_quat(nothing, DVec3::ZERO).unwrap_err();
    assert!(matches!(error, PoseError::BadQuaternion));
}

/// The farthest translation that is taken works; the next is refused and says which axis.
#[test]
fn a_pose_too_far_away_is_an_error() {
    let limit = f64::exp2(1000.0);
    for (entry, axis) in [(3, 0), (7, 1), (11, 2)] {
        let beyond = Pose::from_row_major(identity_with(entry, -limit.next_up()));
        assert!(matches!(beyond, Err(PoseError::TooFar { axis: at }) if at == axis));
        let pose = Pose::from_row_major(identity_with(entry, limit)).unwrap();
        let sphere = Tree::new(punctual::shapes::icosphere(1));
        let query = Query::intersection(&sphere, &sphere, pose);
        let outcome = run(&query, &mut Workspace::new(), Budget::unlimited());
        assert_eq!(outcome.value, Verdict::Separated);
    }
}

/// A square of `2 count^2` triangles in the plane z = 0.
fn sheet(count: u16) -> Tree {
    let at = |i: u16| f32::from(i) / f32::from(count) - 0.5;
    let row = u32::from(count) + 1;
    let corners = (0..=count).flat_map(|i| (0..=count).map(move |j| [at(i), at(j), 0.0]));
    let quads = (0..u32::from(count))
        .flat_map(|i| (0..u32::from(count)).map(move |j| row * i + j))
        .flat_map(|i| [[i, i + row, i + 1], [i + 1, i + row, i + row + 1]]);
    Tree::new(Mesh::new(corners.collect::<Vec<_>>(), quads.collect::<Vec<_>>()).unwrap())
}

/// All pairs of triangles one above the other are in doubt; a plane tells. The two ways to ask cost
/// about the same.
#[test]
fn parallel_sheets_are_told_apart_as_soon_as_their_distance() {
    let tree = sheet(100);
    let mut workspace = Workspace::new();
    for (gap, turn) in [(1e-9, 0.0), (-1e-9, 0.0), (1e-12, 0.3)] {
        let axes = DMat3::from_rotation_z(turn);
        let pose = Pose::new(axes, DVec3::new(0.01, 0.02, gap)).unwrap();
        let distance = Query::distance(&tree, &tree, pose)
            .run(&mut workspace, ENOUGH.clock(&ManualClock::new()));
        for mode in MODES {
            let query = Query::intersection(&tree, &tree, pose).mode(mode);
            let whole = run(&query, &mut workspace, ENOUGH);
            assert_eq!(whole.value, Verdict::Separated);
            assert!(whole.stats.work < 2 * distance.stats.work, "{mode:?}");
            // Cut anywhere, also within the pass over the vertices.
            let mut said = run(
                &query,
                &mut workspace,
                Budget::work(whole.stats.work - 2_000),
            );
            while said.stop == StopReason::WorkLimit {
                assert_eq!(said.value, Verdict::Undecided);
                let before = said.stats.work;
                said = check::resume(&query, &mut workspace, Budget::work(1));
                assert_step(said.stats.work - before, 1, MAX_STEP_WORK);
            }
            assert_eq!(said, whole);
        }
    }
    let touching = Query::intersection(&tree, &tree, Pose::IDENTITY);
    assert!(run(&touching, &mut workspace, ENOUGH).value.meets());
}
