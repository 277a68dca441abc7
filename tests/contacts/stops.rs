//! Whatever stops a query, and wherever: what was found is true, what is missing is as far as was said and lies where the
//! certificate says, and it goes on as if it had never stopped.

use punctual::clock::ManualClock;
use punctual::contacts::{Contact, ContactBounds, Contacts};
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::shapes::{icosphere, torus};
use punctual::{Answer, Budget, Mesh, Pose, Query, StopReason, Tree, Workspace, shapes};

use crate::common::ask::{assert_time_is_kept, resumes};
use crate::common::meshes::{at, ball, placed};
use crate::common::random::{Drift, Family, Random, pose_about, soup};
use crate::common::steps::assert_step;
use crate::truth::{ENOUGH, Truth, answer, listed, order, resume, run};

struct Case {
    name: &'static str,
    a: Tree,
    b: Tree,
    pose: Pose,
    margin: f64,
    truth: Truth,
}

impl Case {
    fn query(&self) -> Query<'_, Contacts> {
        Query::contacts(&self.a, &self.b, self.pose).margin(self.margin)
    }
}

/// Small enough to stop after every step, and different in what they reach.
fn cases() -> Vec<Case> {
    let mut random = Random::new(2025);
    let turned = pose_about(DVec3::ZERO, 0.3, Drift::Shear, &mut random);
    let linked = placed(DMat3::from_rotation_x(1.57), [1.0, 0.0, 0.0]);
    let far_pose = pose_about(Family::FarOffset.center(), 0.5, Drift::None, &mut random);
    let case = |name, margin, a: &Mesh, b: &Mesh, pose: Pose| {
        let [a, b] = [a, b].map(|mesh| Tree::new(mesh.clone()));
        let truth = Truth::new(&a, &b, &pose);
        Case {
            name,
            a,
            b,
            pose,
            margin,
            truth,
        }
    };
    let ring = torus(1.0, 0.15, 12);
    let [small, fine, cube] = [icosphere(1), icosphere(2), shapes::cuboid([1.0; 3], 3)];
    let mut soups = |family, count| [(); 2].map(|()| soup(family, count, &mut random));
    let [points, edges] = soups(Family::Degenerate, 40);
    let [here, there] = soups(Family::FarOffset, 30);
    let [least, few] = soups(Family::Denormal, 12);
    let same = Pose::IDENTITY;
    vec![
        case("linked rings", 0.7, &ring, &ring, linked),
        case("crossing rings", 0.0, &ring, &ring, at(0.4, 0.1, 0.05)),
        case("rings close by", 0.08, &ring, &ring, at(0.0, 0.0, 0.33)),
        case("spheres apart", 1.0, &small, &fine, at(9.0, 1.0, 0.0)),
        case("spheres near", 0.2, &small, &fine, at(1.9, 0.6, 0.0)),
        case("flush boxes", 1e-3, &cube, &cube, at(2.0, 0.5, 0.25)),
        case("degenerate soups", 0.02, &points, &edges, turned),
        case("f64 soups far away", 0.05, &here, &there, far_pose),
        case("denormal soups", 1e-322, &least, &few, same),
    ]
}

fn whole(query: &Query<Contacts>) -> (Answer<ContactBounds>, Vec<Contact>) {
    let mut workspace = Workspace::new();
    let said = run(query, &mut workspace, ENOUGH);
    (said, listed(&workspace))
}

/// Every missing contact has its middle in a box of the certificate, and there are no more than it says.
#[track_caller]
fn assert_named(case: &Case, workspace: &Workspace, set: &[Contact]) {
    let query = case.query();
    let certificate = query.certificate(workspace).unwrap();
    let found = listed(workspace);
    let boxes: Vec<_> = certificate.boxes().collect();
    let is_due = |one: &&Contact| !found.contains(one) && one.distance <= case.margin;
    for missing in set.iter().filter(is_due) {
        let middle = 0.5 * (missing.points[0] + missing.points[1]);
        let is_known = boxes.iter().any(|open| open.contains(middle));
        assert!(is_known, "{}: {missing:?}", case.name);
    }
}

#[test]
fn after_every_step_the_set_is_true_and_what_is_missing_is_far() {
    let mut workspace = Workspace::new();
    let mut contacts = 0;
    for mut case in cases() {
        let (finished, set) = whole(&case.query());
        case.truth.assert_complete(case.margin, &set);
        contacts += set.len();
        let mut said = run(&case.query(), &mut workspace, Budget::work(0));
        assert_eq!((said.stats.found, said.value.low), (0, 0.0));
        let (mut steps, mut bound) = (0, u64::MAX);
        while said.stop == StopReason::WorkLimit {
            let part = listed(&workspace);
            assert!(part.iter().all(|contact| set.contains(contact)));
            assert_eq!(said.stats.found, part.len() as u64);
            case.truth.assert_missing(&set, &part, said.value.low);
            let now = case.query().certificate(&workspace).unwrap().upper_bound();
            assert!(set.len() as u64 <= now && now <= bound, "{bound} {now}");
            bound = now;
            if steps % 16 == 0 {
                assert_named(&case, &workspace, &set);
            }
            let next = resume(&case.query(), &mut workspace, Budget::work(1));
            assert!(said.value.low <= next.value.low, "{said:?} {next:?}");
            assert_step(next.stats.work - said.stats.work, 1, MAX_DISTANCE_STEP_WORK);
            (said, steps) = (next, steps + 1);
        }
        assert_eq!((said, listed(&workspace)), (finished, set), "{}", case.name);
        let query = case.query();
        assert_eq!(query.certificate(&workspace).unwrap().open_pairs(), 0);
    }
    assert!(contacts > 500, "{contacts} contacts");
}

/// Long before the end something is known about what is missing.
#[test]
fn the_bound_rises_on_the_way() {
    let sphere = ball(4);
    let query = Query::contacts(&sphere, &sphere, at(2.05, 0.0, 0.0)).margin(0.15);
    let (finished, set) = whole(&query);
    let mut workspace = Workspace::new();
    let budget = Budget::work(finished.stats.work / 2);
    let low = run(&query, &mut workspace, budget).value.low;
    assert!(low > 0.05, "{low}");
    let near = set.iter().filter(|contact| contact.distance < low).count();
    assert!(near > 0 && listed(&workspace)[..near] == set[..near]);
}

/// A full list ends the call; drained and resumed, all lists together are the whole set.
#[test]
fn a_full_list_is_drained_and_the_query_resumed() {
    for limit in [1, 3, 50] {
        let mut workspace = Workspace::new();
        for case in cases() {
            let (finished, set) = whole(&case.query());
            let query = case.query().contact_limit(limit);
            let (mut said, mut all) = (run(&query, &mut workspace, ENOUGH), Vec::new());
            while said.stop == StopReason::PairsFull {
                assert_eq!(workspace.contacts().len(), limit, "{}", case.name);
                // Nothing happens before it is drained.
                assert_eq!(resume(&query, &mut workspace, ENOUGH), said);
                all.extend(workspace.drain_contacts());
                assert_eq!(workspace.contacts().len(), 0);
                said = resume(&query, &mut workspace, ENOUGH);
            }
            all.extend(workspace.drain_contacts());
            all.sort_by(order);
            assert_eq!((said, all), (finished, set), "{}", case.name);
        }
    }
    // Room is made by the first query, and kept.
    let case = cases().swap_remove(0);
    let mut workspace = Workspace::new();
    workspace.reserve_contacts(1);
    let said = run(&case.query(), &mut workspace, ENOUGH);
    assert_eq!(said.stop, StopReason::PairsFull);
    workspace.reserve_contacts(2000);
    let said = resume(&case.query(), &mut workspace, ENOUGH);
    assert_eq!((said, listed(&workspace)), whole(&case.query()));
}

/// Cut anywhere, with any room in the queue, by any kernel; also where a copy of the workspace goes on.
#[test]
fn pieces_of_any_size_end_in_the_same_set() {
    let mut random = Random::new(12);
    for (capacity, is_portable) in [(4096, false), (4096, true), (0, false), (3, true)] {
        let mut workspace = Workspace::with_capacity(capacity, 1);
        if is_portable {
            workspace.use_portable_kernels();
        }
        for mut case in cases() {
            let (finished, set) = whole(&case.query());
            let mut said = run(&case.query(), &mut workspace, Budget::work(700));
            while said.stop == StopReason::WorkLimit {
                if random.below(4) == 0 {
                    let mut clone = workspace.clone();
                    let _ = resume(&case.query(), &mut clone, ENOUGH);
                    assert_eq!(listed(&clone), set, "{}", case.name);
                }
                let part = listed(&workspace);
                case.truth.assert_missing(&set, &part, said.value.low);
                let budget = Budget::work([1, 300, 5_000][random.below(3)]);
                said = resume(&case.query(), &mut workspace, budget);
            }
            assert_eq!((said.stop, listed(&workspace)), (StopReason::Finished, set));
            assert!(capacity < 4096 || said == finished, "{}", case.name);
        }
    }
}

#[test]
fn budgets_of_time_are_sound_and_kept() {
    let mut workspace = Workspace::new();
    for mut case in cases() {
        let (_, set) = whole(&case.query());
        let query = Query::contacts(&case.a, &case.b, case.pose).margin(case.margin);
        let check = |said: &Answer<ContactBounds>, held: &mut Workspace, _: &ManualClock| {
            case.truth
                .assert_missing(&set, &listed(held), said.value.low);
        };
        let budgets = (0..).map(|i| i * i);
        assert_time_is_kept(
            &query,
            &mut workspace,
            MAX_DISTANCE_STEP_WORK,
            budgets,
            check,
        );
        assert_eq!(listed(&workspace), set, "{}", case.name);
    }
}

#[test]
fn only_a_stopped_run_of_the_same_query_resumes() {
    let mut workspace = Workspace::new();
    for case in cases() {
        let query = case.query();
        let _ = run(&query, &mut workspace, Budget::work(0));
        for stranger in [query.margin(0.123), query.contact_limit(7)] {
            assert!(!resumes(&stranger, &workspace));
            assert!(stranger.certificate(&workspace).is_err());
        }
        let distance = Query::distance(&case.a, &case.b, case.pose).closer_than(case.margin);
        let meets = Query::all_pairs(&case.a, &case.b, case.pose);
        assert!(!resumes(&distance, &workspace) && !resumes(&meets, &workspace));
        assert!(resumes(&query, &workspace), "{}", case.name);
        // They agree on what touches.
        let (_, set) = whole(&query);
        let touching = set.iter().filter(|contact| contact.distance == 0.0).count();
        assert_eq!(answer(&meets).stats.found, touching as u64, "{}", case.name);
    }
}
