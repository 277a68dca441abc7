//! Whatever stops a query, and wherever: what was found is true, what is missing is as far as was said and lies where the
//! certificate says, and it goes on as if it had never stopped.

use std::time::Duration;

use punctual::clock::ManualClock;
use punctual::contacts::{Contact, ContactBounds, Contacts};
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::{Answer, Budget, Mesh, Pose, Query, StopReason, Tree, Workspace, shapes};

use crate::common::random::{Drift, Family, Random, pose_about, soup};
use crate::common::steps::assert_step;
use crate::finished::moved;
use crate::truth::{ENOUGH, Truth, listed, resume, run};

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
    let linked = Pose::new(DMat3::from_rotation_x(1.57), DVec3::new(1.0, 0.0, 0.0)).unwrap();
    let far_pose = pose_about(Family::FarOffset.center(), 0.5, Drift::None, &mut random);
    let (ring, box_of) = (
        || shapes::torus(1.0, 0.15, 12),
        |cells| shapes::cuboid(Vec3::ONE, cells),
    );
    let case = |name, a: Mesh, b: Mesh, pose: Pose, margin| {
        let (a, b) = (Tree::new(a), Tree::new(b));
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
    let mut soup = |family, count| soup(family, count, &mut random);
    vec![
        case("linked rings", ring(), ring(), linked, 0.7),
        case("crossing rings", ring(), ring(), moved(0.4, 0.1, 0.05), 0.0),
        case(
            "rings close by",
            ring(),
            ring(),
            moved(0.0, 0.0, 0.33),
            0.08,
        ),
        case(
            "spheres apart",
            shapes::icosphere(1),
            shapes::icosphere(2),
            moved(9.0, 1.0, 0.0),
            1.0,
        ),
        case(
            "spheres near",
            shapes::icosphere(1),
            shapes::icosphere(2),
            moved(1.9, 0.6, 0.0),
            0.2,
        ),
        case(
            "flush boxes",
            box_of(3),
            box_of(3),
            moved(2.0, 0.5, 0.25),
            1e-3,
        ),
        case(
            "degenerate soups",
            soup(Family::Degenerate, 40),
            soup(Family::Degenerate, 40),
            turned,
            0.02,
        ),
        case(
            "f64 soups far away",
            soup(Family::FarOffset, 30),
            soup(Family::FarOffset, 30),
            far_pose,
            0.05,
        ),
        case(
            "denormal soups",
            soup(Family::Denormal, 12),
            soup(Family::Denormal, 12),
            Pose::IDENTITY,
            1e-322,
        ),
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
    assert!(
        set.len() as u64 <= certificate.upper_bound(),
        "{}",
        case.name
    );
    let boxes: Vec<_> = certificate.boxes().collect();
    for missing in set
        .iter()
        .filter(|contact| !found.contains(contact) && contact.distance <= case.margin)
    {
        let middle = 0.5 * (missing.points[0] + missing.points[1]);
        let is_known =
            |open: &punctual::Aabb| open.min.cmple(middle).all() && middle.cmple(open.max).all();
        assert!(boxes.iter().any(is_known), "{}: {missing:?}", case.name);
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
        assert_eq!(
            (said.stop, said.stats.found, said.value.low),
            (StopReason::WorkLimit, 0, 0.0)
        );
        let (mut steps, mut bound) = (0, u64::MAX);
        while said.stop != StopReason::Finished {
            assert_eq!(said.stop, StopReason::WorkLimit);
            let part = listed(&workspace);
            assert!(
                part.iter().all(|contact| set.contains(contact))
                    && said.stats.found == part.len() as u64
            );
            case.truth.assert_missing(&set, &part, said.value.low);
            let now = case.query().certificate(&workspace).unwrap().upper_bound();
            assert!(
                set.len() as u64 <= now && now <= bound,
                "{}: {bound}, then {now}",
                case.name
            );
            bound = now;
            if steps % 16 == 0 {
                assert_named(&case, &workspace, &set);
            }
            let next = resume(&case.query(), &mut workspace, Budget::work(1));
            assert!(
                said.value.low <= next.value.low,
                "{}: {said:?} {next:?}",
                case.name
            );
            assert_step(next.stats.work - said.stats.work, 1, MAX_DISTANCE_STEP_WORK);
            (said, steps) = (next, steps + 1);
        }
        assert_eq!((said, listed(&workspace)), (finished, set), "{}", case.name);
        assert_eq!(
            case.query().certificate(&workspace).unwrap().open_pairs(),
            0
        );
    }
    assert!(contacts > 500, "{contacts} contacts");
}

/// Long before the end something is known about what is missing.
#[test]
fn the_bound_rises_on_the_way() {
    let sphere = Tree::new(shapes::icosphere(4));
    let query = Query::contacts(&sphere, &sphere, moved(2.05, 0.0, 0.0)).margin(0.15);
    let (finished, set) = whole(&query);
    let mut workspace = Workspace::new();
    let half = run(
        &query,
        &mut workspace,
        Budget::work(finished.stats.work / 2),
    );
    assert!(half.value.low > 0.05, "{half:?}");
    let near = set
        .iter()
        .filter(|contact| contact.distance < half.value.low)
        .count();
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
                assert_eq!(
                    resume(&query, &mut workspace, ENOUGH),
                    said,
                    "nothing happens before it is drained"
                );
                all.extend(workspace.drain_contacts());
                assert_eq!(workspace.contacts().len(), 0);
                said = resume(&query, &mut workspace, ENOUGH);
            }
            all.extend(workspace.drain_contacts());
            all.sort_by(|x, y| {
                x.distance
                    .total_cmp(&y.distance)
                    .then(x.triangles.cmp(&y.triangles))
            });
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
    let (finished, set) = whole(&case.query());
    assert_eq!(
        (
            resume(&case.query(), &mut workspace, ENOUGH),
            listed(&workspace)
        ),
        (finished, set)
    );
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
                    let _ = resume(&case.query(), &mut workspace, ENOUGH);
                    assert_eq!(listed(&workspace), set, "{}", case.name);
                    workspace = clone.clone();
                    let _ = resume(&case.query(), &mut clone, ENOUGH);
                    assert_eq!(listed(&clone), set, "{}", case.name);
                }
                case.truth
                    .assert_missing(&set, &listed(&workspace), said.value.low);
                let budget = Budget::work([1, 300, 5_000][random.below(3)]);
                said = resume(&case.query(), &mut workspace, budget);
            }
            assert_eq!(
                (said.stop, listed(&workspace)),
                (StopReason::Finished, set),
                "{}",
                case.name
            );
            assert!(capacity < 4096 || said == finished, "{}", case.name);
        }
    }
}

/// The clock ticks once a look, so a budget of k ticks ends at look k.
#[test]
fn budgets_of_time_are_sound_and_kept() {
    let tick = Duration::from_micros(1);
    let mut workspace = Workspace::new();
    for mut case in cases() {
        let (_, set) = whole(&case.query());
        let query = Query::contacts(&case.a, &case.b, case.pose).margin(case.margin);
        for ticks in (0u32..).map(|i| i * i) {
            let (clock, time) = (ManualClock::ticking(tick), tick * ticks);
            let said = query.run(
                &mut workspace,
                Budget::time(time).poll_interval(64).clock(&clock),
            );
            case.truth
                .assert_missing(&set, &listed(&workspace), said.value.low);
            let most_per_look = 64.max(time.as_nanos() as u64) + MAX_DISTANCE_STEP_WORK;
            assert!(
                said.stats.work <= u64::from(ticks + 1) * most_per_look,
                "{said:?}"
            );
            if said.stop == StopReason::Finished {
                break;
            }
            assert!(said.stop == StopReason::Deadline && said.stats.elapsed.unwrap() >= time);
        }
        assert_eq!(listed(&workspace), set, "{}", case.name);
    }
}

/// One workspace for all kinds of questions: none goes on with a run of another, nor leaves anything behind.
#[test]
fn contacts_distances_and_intersections_in_turn() {
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    for case in cases() {
        let query = case.query();
        let (finished, set) = whole(&query);
        let distance = Query::distance(&case.a, &case.b, case.pose).closer_than(case.margin);
        let meets = Query::all_pairs(&case.a, &case.b, case.pose);
        let alone = distance.run(&mut Workspace::new(), ENOUGH.clock(&clock));
        let strangers = [query.margin(0.123), query.contact_limit(7)];
        let _ = run(&query, &mut workspace, Budget::work(0));
        assert!(
            strangers
                .iter()
                .all(|other| other.resume(&mut workspace, ENOUGH.clock(&clock)).is_err())
        );
        assert!(
            strangers
                .iter()
                .all(|other| other.certificate(&workspace).is_err())
        );
        assert!(
            distance
                .resume(&mut workspace, ENOUGH.clock(&clock))
                .is_err()
        );
        assert!(meets.resume(&mut workspace, ENOUGH.clock(&clock)).is_err());
        assert_eq!(resume(&query, &mut workspace, ENOUGH), finished);
        assert!(
            query.resume(&mut workspace, ENOUGH.clock(&clock)).is_err(),
            "it is complete"
        );
        assert_eq!(
            distance.run(&mut workspace, ENOUGH.clock(&clock)),
            alone,
            "{}",
            case.name
        );
        assert_eq!(workspace.contacts().len(), 0);
        let outcome = meets.run(&mut workspace, ENOUGH.clock(&clock));
        let touching = set.iter().filter(|contact| contact.distance == 0.0).count();
        assert_eq!(outcome.stats.found, touching as u64, "{}", case.name);
        assert_eq!(
            (run(&query, &mut workspace, ENOUGH), listed(&workspace)),
            (finished, set),
            "{}",
            case.name
        );
    }
}
