//! A certificate that is narrowed holds as before all that the query has missed, wherever it was stopped and however much
//! work is spent on it; it says more the more is spent; and the query does not notice.

mod common;

use common::check::{ENOUGH, assert_certificate, resume, run, sorted};
use common::random::{Drift, Random, pose_about};
use common::reference::{Place, all_pairs, place};
use punctual::glam::{DVec3, Vec3};
use punctual::{Aabb, Budget, BuildOptions, Certificate, Mesh, Mode, Pose, Query, Tree, Workspace, shapes};

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
        let places = truth.iter().map(|&pair| place(&a, &b, &pose, pair)).collect();
        let [a, b] = [a, b].map(|mesh| Tree::with_options(mesh, &BuildOptions::default().neighbors(true)));
        Self { a, b, pose, truth, places }
    }

    fn query(&self) -> Query<'_> {
        Query::new(&self.a, &self.b, self.pose).mode(Mode::All)
    }

    /// Every pair that is not among those found lies in a box.
    fn assert_holds(&self, certificate: &Certificate, found: &[[u32; 2]]) {
        let boxes: Vec<Aabb> = certificate.boxes().collect();
        assert!(boxes.len() <= certificate.open_pairs());
        for (pair, place) in self.truth.iter().zip(&self.places) {
            let is_held = found.binary_search(pair).is_ok() || boxes.iter().any(|open| place.is_in(open));
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
        Case::new(shapes::torus_knot(2, 3, 0.2, 24), shapes::torus_knot(3, 2, 0.2, 24), pose()),
        Case::new(shapes::height_field(24, 1), shapes::height_field(24, 2), pose()),
        Case::new(shapes::cuboid(Vec3::ONE, 5), shapes::cuboid(Vec3::ONE, 5), Pose::IDENTITY),
        Case::new(shapes::cuboid(Vec3::splat(0.7), 1), shapes::icosphere(4), pose()),
    ]
}

const WORK: [u64; 7] = [0, 1, 300, 1_000, 5_000, 20_000, u64::MAX];

#[test]
fn whatever_was_missed_is_in_a_box_at_any_stop_after_any_work() {
    let mut random = Random::new(8);
    let mut workspaces = [(4096, 65536), (0, 70_000), (5, 20)].map(|(q, f)| Workspace::with_capacity(q, f));
    let mut asides = [(4096, 65536), (0, 9), (40, 300)].map(|(q, f)| Workspace::with_capacity(q, f));
    for case in cases() {
        let all = run(&case.query(), &mut workspaces[0], ENOUGH).stats.work;
        for round in 0..60 {
            let query = case.query().early(round % 2 == 0).queue_threshold([0.0, 64.0, 1e9][random.below(3)]);
            let query = if round % 5 == 0 { query.mode(Mode::Any) } else { query };
            let (workspace, aside) = (&mut workspaces[random.below(3)], &mut asides[random.below(3)]);
            let outcome = run(&query, workspace, Budget::work((random.unit() * 1.1 * all as f64) as u64));
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
        for (early, share) in [(false, 0), (true, 3), (false, 6), (true, 9)] {
            let query = case.query().early(early);
            let all = run(&query, &mut workspace, ENOUGH).stats.work;
            let outcome = run(&query, &mut workspace, Budget::work(all * share / 10));
            let certificate = query.narrowed_certificate(&workspace, &mut aside, u64::MAX).unwrap();
            assert_eq!(certificate.upper_bound(), case.truth.len() as u64);
            assert_eq!(certificate.open_pairs() as u64 + outcome.found, case.truth.len() as u64);
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
        let narrowed = query.narrowed_certificate(&workspace, &mut aside, 0).unwrap();
        assert_eq!((plain.work(), narrowed.work()), (0, 0));
        assert_eq!((plain.open_pairs(), plain.upper_bound()), (narrowed.open_pairs(), narrowed.upper_bound()));
        let sum = |certificate: &Certificate| certificate.boxes().map(|b| b.extents().element_sum()).sum::<f64>();
        assert!((sum(&plain) - sum(&narrowed)).abs() <= 1e-9 * sum(&plain));
    }
}

#[test]
fn the_query_goes_on_as_if_nobody_had_looked() {
    for case in cases() {
        for early in [false, true] {
            let query = case.query().early(early);
            let [mut whole, mut pieces, mut aside, mut portable] = [(); 4].map(|()| Workspace::new());
            portable.use_portable_kernels();
            let expected = run(&query, &mut whole, ENOUGH);
            let mut outcome = run(&query, &mut pieces, Budget::work(1));
            while outcome != expected {
                let told = query.narrowed_certificate(&pieces, &mut aside, 2_000).unwrap();
                let again = query.narrowed_certificate(&pieces, &mut portable, 2_000).unwrap();
                assert_eq!((told.work(), told.upper_bound()), (again.work(), again.upper_bound()));
                assert!(told.boxes().eq(again.boxes()));
                outcome = resume(&query, &mut pieces, Budget::work(1 + outcome.stats.work / 3));
            }
            assert_eq!(pieces.pairs(), whole.pairs());
        }
    }
}

#[test]
fn a_little_work_says_much_more() {
    let (mut workspace, mut aside) = (Workspace::new(), Workspace::new());
    for case in cases().iter().take(3) {
        let query = case.query();
        let all = run(&query, &mut workspace, ENOUGH).stats.work;
        let _ = run(&query, &mut workspace, Budget::work(all / 3));
        let room = |certificate: Certificate| certificate.boxes().map(|b| b.extents().element_product()).sum::<f64>();
        let plain = room(query.certificate(&workspace).unwrap());
        let narrowed = room(query.narrowed_certificate(&workspace, &mut aside, all / 10).unwrap());
        assert!(narrowed < 0.4 * plain, "{narrowed} of {plain}");
    }
}

#[test]
fn the_other_workspace_is_nobodys_run() {
    let case = &cases()[0];
    let (query, mut workspace, mut aside) = (case.query(), Workspace::new(), Workspace::new());
    assert!(query.narrowed_certificate(&workspace, &mut aside, 9).is_err());
    let _ = run(&query, &mut workspace, Budget::work(900));
    assert!(query.mode(Mode::Any).narrowed_certificate(&workspace, &mut aside, 9).is_err());
    assert!(query.narrowed_certificate(&workspace, &mut aside, 9).is_ok());
    assert!(query.certificate(&aside).is_err());
}
