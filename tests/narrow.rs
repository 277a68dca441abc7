//! A certificate that is narrowed holds as before all that the query has missed, wherever it was stopped and however much
//! work is spent on it; it says more the more is spent; and the query does not notice.

mod common;

use common::check::{ENOUGH, assert_certificate, resume, run, sorted};
use common::random::{Drift, Random, pose_about};
use common::reference::{Place, all_pairs, place};
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{
    Aabb, Budget, Certificate, Contact, ContactQuery, DistanceQuery, ManualClock, Mesh, Mode, Pose,
    Query, StopReason, Tree, Workspace, shapes,
};

struct Case {
    a: Tree,
    b: Tree,
    pose: Pose,
    truth: Vec<[u32; 2]>,
    places: Vec<Place>,
}

impl Case {
    fn new(a: Mesh, b: Mesh, pose: Pose) -> Self {
        let truth = all_pairs(&a, &b, &pose);
        let places = truth
            .iter()
            .map(|&pair| place(&a, &b, &pose, pair))
            .collect();
        let [a, b] = [a, b].map(Tree::new);
        Self {
            a,
            b,
            pose,
            truth,
            places,
        }
    }

    fn query(&self) -> Query<'_> {
        Query::new(&self.a, &self.b, self.pose).mode(Mode::All)
    }

    /// Every pair that is not among those found lies in a box.
    fn assert_holds(&self, certificate: &Certificate, found: &[[u32; 2]]) {
        let boxes: Vec<Aabb> = certificate.boxes().collect();
        assert!(boxes.len() <= certificate.open_pairs());
        for (pair, place) in self.truth.iter().zip(&self.places) {
            let is_held =
                found.binary_search(pair).is_ok() || boxes.iter().any(|open| place.is_in(open));
            assert!(is_held, "{pair:?} is in no box");
        }
    }
}

/// Curves that march far, open edges, surfaces side by side where all is in doubt, and a lone large triangle.
fn cases() -> Vec<Case> {
    let mut random = Random::new(3);
    let mut pose = || pose_about(DVec3::ZERO, 0.5, Drift::None, &mut random);
    vec![
        Case::new(shapes::icosphere(3), shapes::icosphere(4), pose()),
        Case::new(
            shapes::torus_knot(2, 3, 0.2, 24),
            shapes::torus_knot(3, 2, 0.2, 24),
            pose(),
        ),
        Case::new(
            shapes::height_field(24, 1),
            shapes::height_field(24, 2),
            pose(),
        ),
        Case::new(
            shapes::cuboid(Vec3::ONE, 5),
            shapes::cuboid(Vec3::ONE, 5),
            Pose::IDENTITY,
        ),
        Case::new(
            shapes::cuboid(Vec3::splat(0.7), 1),
            shapes::icosphere(4),
            pose(),
        ),
    ]
}

const WORK: [u64; 7] = [0, 1, 300, 1_000, 5_000, 20_000, u64::MAX];

#[test]
fn whatever_was_missed_is_in_a_box_at_any_stop_after_any_work() {
    let mut random = Random::new(8);
    let mut workspaces =
        [(4096, 65536), (0, 70_000), (5, 20)].map(|(q, f)| Workspace::with_capacity(q, f));
    let mut asides =
        [(4096, 65536), (0, 9), (40, 300)].map(|(q, f)| Workspace::with_capacity(q, f));
    for case in cases() {
        let all = run(&case.query(), &mut workspaces[0], ENOUGH).stats.work;
        for round in 0..60 {
            let query = case
                .query()
                .queue_threshold([0.0, 64.0, 1e9][random.below(3)]);
            let query = if round % 5 == 0 {
                query.mode(Mode::Any)
            } else {
                query
            };
            let (workspace, aside) = (
                &mut workspaces[random.below(3)],
                &mut asides[random.below(3)],
            );
            let outcome = run(
                &query,
                workspace,
                Budget::work((random.unit() * 1.1 * all as f64) as u64),
            );
            let found = sorted(workspace.pairs());
            let mut bound = query.certificate(workspace).unwrap().upper_bound();
            for work in WORK {
                let certificate = query.narrowed_certificate(workspace, aside, work).unwrap();
                assert_certificate(&certificate, &outcome, case.truth.len());
                assert!(certificate.upper_bound() <= bound);
                bound = certificate.upper_bound();
                case.assert_holds(&certificate, &found);
            }
        }
    }
}

#[test]
fn enough_work_leaves_nothing_but_what_meets() {
    for case in cases() {
        let (mut workspace, mut aside) = (Workspace::new(), Workspace::new());
        for share in [0, 3, 6, 9] {
            let query = case.query();
            let all = run(&query, &mut workspace, ENOUGH).stats.work;
            let outcome = run(&query, &mut workspace, Budget::work(all * share / 10));
            let certificate = query
                .narrowed_certificate(&workspace, &mut aside, u64::MAX)
                .unwrap();
            assert_eq!(certificate.upper_bound(), case.truth.len() as u64);
            assert_eq!(
                certificate.open_pairs() as u64 + outcome.found,
                case.truth.len() as u64
            );
        }
    }
}

#[test]
fn nothing_is_done_for_nothing() {
    let (mut workspace, mut aside) = (Workspace::new(), Workspace::new());
    for case in cases() {
        let query = case.query();
        let _ = run(&query, &mut workspace, Budget::work(9_000));
        let plain = query.certificate(&workspace).unwrap();
        let narrowed = query
            .narrowed_certificate(&workspace, &mut aside, 0)
            .unwrap();
        assert_eq!((plain.work(), narrowed.work()), (0, 0));
        assert_eq!(
            (plain.open_pairs(), plain.upper_bound()),
            (narrowed.open_pairs(), narrowed.upper_bound())
        );
        let sum = |certificate: &Certificate| {
            certificate
                .boxes()
                .map(|b| b.extents().element_sum())
                .sum::<f64>()
        };
        assert!((sum(&plain) - sum(&narrowed)).abs() <= 1e-9 * sum(&plain));
    }
}

#[test]
fn the_query_goes_on_as_if_nobody_had_looked() {
    for case in cases() {
        let query = case.query();
        let [mut whole, mut pieces, mut aside, mut portable] = [(); 4].map(|()| Workspace::new());
        portable.use_portable_kernels();
        let expected = run(&query, &mut whole, ENOUGH);
        let mut outcome = run(&query, &mut pieces, Budget::work(1));
        while outcome != expected {
            let told = query
                .narrowed_certificate(&pieces, &mut aside, 2_000)
                .unwrap();
            let again = query
                .narrowed_certificate(&pieces, &mut portable, 2_000)
                .unwrap();
            assert_eq!(
                (told.work(), told.upper_bound()),
                (again.work(), again.upper_bound())
            );
            assert!(told.boxes().eq(again.boxes()));
            outcome = resume(
                &query,
                &mut pieces,
                Budget::work(1 + outcome.stats.work / 3),
            );
        }
        assert_eq!(pieces.pairs(), whole.pairs());
    }
}

#[test]
fn a_little_work_says_much_more() {
    let (mut workspace, mut aside) = (Workspace::new(), Workspace::new());
    for case in cases().iter().take(3) {
        let query = case.query();
        let all = run(&query, &mut workspace, ENOUGH).stats.work;
        let _ = run(&query, &mut workspace, Budget::work(all / 3));
        let room = |certificate: Certificate| {
            certificate
                .boxes()
                .map(|b| b.extents().element_product())
                .sum::<f64>()
        };
        let plain = room(query.certificate(&workspace).unwrap());
        let narrowed = room(
            query
                .narrowed_certificate(&workspace, &mut aside, all / 10)
                .unwrap(),
        );
        assert!(narrowed < 0.4 * plain, "{narrowed} of {plain}");
    }
}

#[test]
fn the_other_workspace_is_nobodys_run() {
    let case = &cases()[0];
    let (query, mut workspace, mut aside) = (case.query(), Workspace::new(), Workspace::new());
    assert!(
        query
            .narrowed_certificate(&workspace, &mut aside, 9)
            .is_err()
    );
    let _ = run(&query, &mut workspace, Budget::work(900));
    assert!(
        query
            .mode(Mode::Any)
            .narrowed_certificate(&workspace, &mut aside, 9)
            .is_err()
    );
    assert!(
        query
            .narrowed_certificate(&workspace, &mut aside, 9)
            .is_ok()
    );
    assert!(query.certificate(&aside).is_err());
}

/// Surfaces at a distance, nearly parallel ones among them, those that meet, and thin ones side by side.
fn places() -> Vec<Case> {
    let mut random = Random::new(5);
    let mut at = |x, y, z| {
        let turned = pose_about(DVec3::ZERO, 0.0, Drift::None, &mut random);
        Pose::new(*turned.rotation(), DVec3::new(x, y, z)).unwrap()
    };
    let above = Pose::new(DMat3::IDENTITY, DVec3::Z * 0.4).unwrap();
    vec![
        Case::new(
            shapes::icosphere(3),
            shapes::icosphere(4),
            at(2.5, 0.3, 0.0),
        ),
        Case::new(
            shapes::torus_knot(2, 3, 0.1, 24),
            shapes::torus_knot(3, 2, 0.1, 24),
            at(0.0, 3.0, 1.0),
        ),
        Case::new(
            shapes::height_field(24, 1),
            shapes::height_field(24, 2),
            above,
        ),
        Case::new(
            shapes::torus(1.0, 0.2, 24),
            shapes::icosphere(3),
            at(0.9, 0.0, 0.0),
        ),
        Case::new(
            shapes::cuboid(Vec3::splat(0.7), 1),
            shapes::icosphere(4),
            at(-1.0, 1.5, 1.2),
        ),
    ]
}

/// All triangle pairs this close.
fn all_within(case: &Case, margin: f64) -> Vec<Contact> {
    let mut workspace = Workspace::new();
    workspace.reserve_contacts(1 << 18);
    let query = ContactQuery::new(&case.a, &case.b, case.pose).margin(margin);
    let said = query.run_with(&mut workspace, ENOUGH, &ManualClock::new());
    assert_eq!(said.stop, StopReason::Finished);
    workspace.contacts().copied().collect()
}

/// Each of them has its middle in a box, and there are no more than the certificate says.
#[track_caller]
fn assert_names(certificate: &Certificate, missing: &[Contact], found: u64) {
    let boxes: Vec<Aabb> = certificate.boxes().collect();
    assert!(boxes.len() <= certificate.open_pairs());
    assert!(missing.len() as u64 + found <= certificate.upper_bound());
    for contact in missing {
        let middle = 0.5 * (contact.points[0] + contact.points[1]);
        let is_in = |open: &Aabb| open.min.cmple(middle).all() && middle.cmple(open.max).all();
        assert!(boxes.iter().any(is_in), "{contact:?} is in no box");
    }
}

fn volume(certificate: &Certificate) -> f64 {
    certificate
        .boxes()
        .map(|open| open.extents().element_product())
        .sum()
}

#[test]
fn nothing_closer_than_a_stopped_distance_is_lost() {
    let (clock, mut random) = (ManualClock::new(), Random::new(9));
    let mut workspace = Workspace::new();
    let mut asides =
        [(4096, 65536), (0, 9), (40, 300)].map(|(q, f)| Workspace::with_capacity(q, f));
    for case in places() {
        let asked = DistanceQuery::new(&case.a, &case.b, case.pose).absolute_tolerance(0.0);
        let all = asked.run_with(&mut workspace, None, ENOUGH, &clock);
        let mut room = [0.0; 2];
        for round in 0..40 {
            let limit = if round % 4 == 3 {
                0.9 * all.low
            } else {
                f64::INFINITY
            };
            let query = asked.closer_than(limit);
            let budget = Budget::work((random.unit() * all.stats.work as f64) as u64);
            let reach = query
                .run_with(&mut workspace, None, budget, &clock)
                .high
                .min(limit);
            if reach == f64::INFINITY {
                continue;
            }
            // Distances that are equal but for their rounding may count as either.
            let closer = all_within(&case, reach * (1.0 - 1e-12));
            let plain = query.certificate(&workspace).unwrap();
            assert_names(&plain, &closer, 0);
            for work in WORK {
                let aside = &mut asides[random.below(3)];
                assert_names(
                    &query.narrowed_certificate(&workspace, aside, work).unwrap(),
                    &closer,
                    0,
                );
            }
            let work = all.stats.work / 4;
            let narrowed = query
                .narrowed_certificate(&workspace, &mut asides[0], work)
                .unwrap();
            room = [room[0] + volume(&plain), room[1] + volume(&narrowed)];
        }
        assert!(room[1] < 0.8 * room[0], "{room:?}");
    }
}

#[test]
fn no_contact_that_a_stopped_query_missed_is_lost() {
    let (clock, mut random) = (ManualClock::new(), Random::new(10));
    let mut workspace = Workspace::new();
    let mut asides =
        [(4096, 65536), (0, 9), (40, 300)].map(|(q, f)| Workspace::with_capacity(q, f));
    for case in places() {
        let asked = DistanceQuery::new(&case.a, &case.b, case.pose);
        let nearest = asked.run_with(&mut workspace, None, ENOUGH, &clock).high;
        for margin in [0.0, nearest + 0.02, nearest + 0.1] {
            let query = ContactQuery::new(&case.a, &case.b, case.pose).margin(margin);
            let set = all_within(&case, margin);
            let all = query.run_with(&mut workspace, ENOUGH, &clock).stats.work;
            for _ in 0..10 {
                let budget = Budget::work((random.unit() * all as f64) as u64);
                let found = query.run_with(&mut workspace, budget, &clock).found;
                let known: Vec<_> = workspace
                    .contacts()
                    .map(|contact| contact.triangles)
                    .collect();
                let missing = set
                    .iter()
                    .filter(|contact| !known.contains(&contact.triangles))
                    .copied();
                let missing: Vec<_> = missing.collect();
                for work in WORK {
                    let aside = &mut asides[random.below(3)];
                    let certificate = query.narrowed_certificate(&workspace, aside, work).unwrap();
                    assert_names(&certificate, &missing, found);
                }
            }
        }
    }
}

#[test]
fn distances_go_on_as_if_nobody_had_looked() {
    let clock = ManualClock::new();
    for case in places() {
        let query = DistanceQuery::new(&case.a, &case.b, case.pose);
        let [mut whole, mut pieces, mut aside, mut portable] = [(); 4].map(|()| Workspace::new());
        portable.use_portable_kernels();
        let expected = query.run_with(&mut whole, None, ENOUGH, &clock);
        let mut said = query.run_with(&mut pieces, None, Budget::work(1), &clock);
        assert!(
            query.certificate(&aside).is_err()
                && query
                    .narrowed_certificate(&aside, &mut portable, 9)
                    .is_err()
        );
        while said.stop != StopReason::Finished {
            let told = query
                .narrowed_certificate(&pieces, &mut aside, 2_000)
                .unwrap();
            let again = query
                .narrowed_certificate(&pieces, &mut portable, 2_000)
                .unwrap();
            assert_eq!(
                (told.work(), told.upper_bound()),
                (again.work(), again.upper_bound())
            );
            assert!(told.boxes().eq(again.boxes()));
            assert!(query.certificate(&aside).is_err());
            let more = Budget::work(1 + said.stats.work / 3);
            said = query.resume_with(&mut pieces, None, more, &clock).unwrap();
        }
        assert_eq!(
            (said.low, said.high, said.nearest),
            (expected.low, expected.high, expected.nearest)
        );
        assert_eq!(said.stats.work, expected.stats.work);
    }
}
