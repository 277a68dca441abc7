//! A scene against a naive model: all pairs of bodies, each asked with all the time it wants.

mod apart;
mod both;
mod broad_phase;
mod changes;
#[path = "../../../../tests/common/mod.rs"]
mod common;
mod compounds;
mod contacts;
mod degradation;
mod distances;
mod estimates;
mod events;
#[path = "../../../../tests/common/exact_distance.rs"]
mod exact_distance;
mod groups;
mod lock_step;
mod motions;
mod named;
mod promises;
mod queries;
mod rays;
mod recording;
mod refusals;
mod solids;
mod stride;
mod thickened;
mod waits;
mod world;

use std::sync::Arc;
use std::time::Duration;

use common::check;
use common::random::{Family, Random, soup};
use events::Ledger;
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DQuat, DVec3, Vec3};
use punctual::{Budget, BuildOptions, Mode, Motion, Pose, Query, Tree, Verdict, Workspace, shapes};
use punctual_scene::{
    Body, BodyId, BodyKind, Filter, PairReport, Reach, Report, Scene, SceneError,
};

fn trees() -> Vec<Arc<Tree>> {
    let mut random = Random::new(5);
    let meshes = [
        shapes::icosphere(2),
        shapes::torus(0.8, 0.2, 16),
        shapes::cuboid(Vec3::new(0.9, 0.5, 0.2), 3),
        shapes::gear(9, 2),
        soup(Family::Degenerate, 40, &mut random),
        soup(Family::Uniform, 0, &mut random),
        soup(Family::Double, 60, &mut random),
    ];
    // Every other one knows its extremes.
    let options = |at: usize| BuildOptions::default().extremes(at.is_multiple_of(2));
    meshes
        .into_iter()
        .enumerate()
        .map(|(at, mesh)| Arc::new(Tree::with_options(mesh, &options(at))))
        .collect()
}

fn pose(reach: f64, random: &mut Random) -> Pose {
    Pose::new(random.rotation(), reach * random.vector()).unwrap()
}

/// A small step from a pose.
fn nudged(from: &Pose, random: &mut Random) -> Pose {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(0.1 * random.vector()));
    let place = from.translation() + 0.1 * random.vector();
    Pose::new(turn * *from.rotation(), place).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::new(x, y, z)).unwrap()
}

fn ball(detail: u32) -> Arc<Tree> {
    Arc::new(Tree::new(shapes::icosphere(detail)))
}

fn moving(scene: &mut Scene, tree: &Arc<Tree>, pose: Pose) -> BodyId {
    scene.insert(Body::moving(Arc::clone(tree), pose)).unwrap()
}

fn fixed(scene: &mut Scene, tree: &Arc<Tree>, pose: Pose) -> BodyId {
    scene.insert(Body::fixed(Arc::clone(tree), pose)).unwrap()
}

#[track_caller]
fn put(scene: &mut Scene, body: BodyId, pose: Pose) {
    scene.set_pose(body, pose).unwrap();
}

#[track_caller]
fn sweep(scene: &mut Scene, body: BodyId, motion: Motion) {
    scene.set_motion(body, motion).unwrap();
}

/// A frame without a budget.
fn whole_frame(scene: &mut Scene) -> &Report {
    detect(scene, Budget::unlimited())
}

fn detect(scene: &mut Scene, budget: Budget) -> &Report {
    scene.detect(budget.clock(&ManualClock::new()))
}

/// The bodies as a plain list.
#[derive(Default)]
struct Model {
    bodies: Vec<(BodyId, Body)>,
    removed: Vec<BodyId>,
}

impl Model {
    fn may_meet(x: &Body, y: &Body) -> bool {
        let (a, b) = (x.filter, y.filter);
        let moving = x.kind == BodyKind::Moving || y.kind == BodyKind::Moving;
        moving && a.groups & b.mask != 0 && b.groups & a.mask != 0
    }

    /// The pairs that intersect, ascending: the body of the lower index stays where it is.
    fn truth(&self, workspace: &mut Workspace) -> Vec<(usize, usize, u64)> {
        let mut pairs = Vec::new();
        for (i, (id, x)) in self.bodies.iter().enumerate() {
            for (other, y) in &self.bodies[i + 1..] {
                let mut both = [(id, x), (other, y)];
                both.sort_by_key(|(id, _)| **id);
                let [(a, x), (b, y)] = both;
                if Self::may_meet(x, y) {
                    let b_in_a = x.pose.inverse().unwrap().compose(&y.pose).unwrap();
                    let query = Query::all_pairs(&x.tree, &y.tree, b_in_a);
                    let said = check::run(&query, workspace, Budget::unlimited());
                    if said.stats.found > 0 {
                        pairs.push((a.index(), b.index(), said.stats.found));
                    }
                }
            }
        }
        pairs.sort_unstable();
        pairs
    }
}

/// One random change of the scene and its model.
fn change(scene: &mut Scene, model: &mut Model, trees: &[Arc<Tree>], random: &mut Random) {
    let tree = Arc::clone(&trees[random.below(trees.len())]);
    let filter = Filter::new(1 << random.below(3), (random.bits() as u32) | 1);
    if model.bodies.is_empty() || (model.bodies.len() < 40 && random.below(6) == 0) {
        let make = if random.below(4) == 0 {
            Body::fixed
        } else {
            Body::moving
        };
        let body = make(tree, pose(2.5, random));
        let body = if random.below(2) == 0 {
            body.filter(filter)
        } else {
            body
        };
        let id = scene.insert(body.clone()).unwrap();
        assert!(!model.removed.contains(&id), "{id} was in use before");
        return model.bodies.push((id, body));
    }
    let at = random.below(model.bodies.len());
    let (id, body) = &mut model.bodies[at];
    let id = *id;
    match random.below(12) {
        0 => {
            scene.remove(id).unwrap();
            model.bodies.swap_remove(at);
            model.removed.push(id);
        }
        1 => {
            match random.below(2) {
                0 => scene.set_tree(id, Arc::clone(&tree)).unwrap(),
                _ => *scene.tree_mut(id).unwrap() = Tree::clone(&tree),
            }
            body.tree = tree;
        }
        2 => {
            scene.set_filter(id, filter).unwrap();
            body.filter = filter;
        }
        3 => scene.set_importance(id, random.signed() as f32).unwrap(),
        change => {
            let near = nudged(&body.pose, random);
            body.pose = if change == 4 { pose(2.5, random) } else { near };
            put(scene, id, body.pose);
        }
    }
}

/// The triangles of a verdict meet, or are as far apart as it says, and that is within the margins. Up to the rounding
/// of the
/// relative pose, which a motion takes otherwise.
#[track_caller]
fn assert_witness(scene: &Scene, pair: &PairReport) {
    let [a, b] = [pair.a, pair.b].map(|id| scene.body(id).unwrap());
    let Some([x, y]) = pair.verdict.witness() else {
        return;
    };
    let b_in_a = a.pose.inverse().unwrap().compose(&b.pose).unwrap();
    let of_a = a.tree.mesh().triangle(x as usize);
    let of_b = b.tree.mesh().triangle(y as usize);
    let of_b = of_b.map(|corner| b_in_a.transform_point(corner));
    let [x, y] = [a, b].map(|body| body.pose.translation().abs().max_element());
    let rounding = 1e-12 * (1.0 + x + y);
    let truth = exact_distance::Distance::of(&of_a, &of_b).rounded();
    match pair.verdict {
        Verdict::Within { distance, .. } => {
            assert!(
                0.0 < distance && distance <= a.margin + b.margin,
                "{pair:?}"
            );
            assert!(
                truth > 0.0 && (distance - truth).abs() <= rounding,
                "{truth} {pair:?}"
            );
        }
        _ => assert!(truth <= rounding, "{truth} {pair:?}"),
    }
}

type Met = [(usize, usize, u64)];

/// How many triangles of a pair meet.
fn found(truth: &Met, pair: &PairReport) -> u64 {
    let key = (pair.a.index(), pair.b.index());
    let known = truth.iter().find(|&&(a, b, _)| (a, b) == key);
    known.map_or(0, |&(.., found)| found)
}

/// Every verdict is true and every missing pair is apart; the counts are right.
#[track_caller]
fn assert_sound(report: &Report, truth: &Met, complete: bool) {
    let mut decided = 0;
    for pair in &report.pairs {
        let found = found(truth, pair);
        match pair.verdict {
            Verdict::Separated => assert_eq!(found, 0, "{pair:?} is not apart"),
            Verdict::Undecided => assert!(pair.age > 0 && !complete, "{pair:?}"),
            _ => assert!(found >= pair.found && pair.found > 0, "{pair:?}"),
        }
        assert!(pair.complete || !complete);
        assert_eq!(pair.age == 0, pair.verdict != Verdict::Undecided);
        decided += usize::from(pair.verdict != Verdict::Undecided);
    }
    assert_eq!(decided, report.decided);
    let oldest = report.pairs.iter().map(|pair| pair.age).max();
    assert_eq!(report.worst_age, oldest.unwrap_or(0));
    assert!(report.is_whole() || !complete);
    // No pair was lost by the broad phase.
    let listed = |key| {
        report
            .pairs
            .iter()
            .any(|pair| (pair.a.index(), pair.b.index()) == key)
    };
    assert!(!report.is_whole() || truth.iter().all(|&(a, b, _)| listed((a, b))));
    let is_within = |pair: &&PairReport| matches!(pair.verdict, Verdict::Within { .. });
    let within = report.pairs.iter().filter(is_within).count();
    assert_eq!(report.intersecting, report.intersecting_pairs().count());
    assert_eq!(report.within, within);
    assert_eq!(report.intersecting + within, report.meeting_pairs().count());
    assert!(!complete || report.intersecting + within == truth.len());
}

fn run_against_model(mode: Mode, reach: Reach, seed: u64, budget: impl Fn(&mut Random) -> Budget) {
    let trees = trees();
    let (mut scene, mut model) = (Scene::new(), Model::default());
    scene.set_mode(mode);
    scene.set_reach(reach);
    scene.track_contacts();
    let (mut random, mut workspace) = (Random::new(seed), Workspace::new());
    let (mut ledger, mut cut, mut met) = (Ledger::default(), false, 0);
    for _ in 0..150 {
        for _ in 0..random.below(25) {
            change(&mut scene, &mut model, &trees, &mut random);
        }
        assert_eq!(scene.len(), model.bodies.len());
        met += rays::check(&mut scene, &model, &mut random, &mut workspace);
        let truth = model.truth(&mut workspace);
        let budget = budget(&mut random);
        let is_free = budget == Budget::unlimited();
        let report = detect(&mut scene, budget);
        cut |= !is_free;
        assert_sound(report, &truth, is_free);
        ledger.check(report, &model, &truth, is_free);
        for pair in report
            .pairs
            .iter()
            .filter(|pair| pair.complete && mode == Mode::All)
        {
            assert_eq!(pair.found, found(&truth, pair));
        }
        for &body in &model.removed {
            assert_eq!(
                scene.body(body).unwrap_err(),
                SceneError::NoSuchBody { body }
            );
        }
        assert_eq!(scene.bodies().count(), model.bodies.len());
        assert_certificates(&scene, &truth);
        met += rays::check(&mut scene, &model, &mut random, &mut workspace);
    }
    assert!(met > 50, "{met} rays hit something");
    let [began, persist, undecided, ended] = ledger.told;
    assert!(
        began > 10 && persist > 10 && ended > 10,
        "{:?}",
        ledger.told
    );
    assert_eq!(undecided > 10, cut, "{:?}", ledger.told);
}

#[track_caller]
fn assert_certificates(scene: &Scene, truth: &Met) {
    for pair in &scene.report().pairs {
        let certificate = scene.certificate(pair.b, pair.a).unwrap();
        assert!(certificate.upper_bound >= found(truth, pair), "{pair:?}");
        let extent = certificate.largest_extent;
        assert!(extent >= 0.0 && extent.is_finite());
    }
}

#[test]
fn without_a_budget_it_equals_all_pairs() {
    run_against_model(Mode::Any, Reach::Here, 1, |_| Budget::unlimited());
    run_against_model(Mode::All, Reach::Here, 2, |_| Budget::unlimited());
    run_against_model(Mode::Any, Reach::Swept, 3, |_| Budget::unlimited());
}

#[test]
fn within_budgets_nothing_that_it_says_is_false() {
    let any = |random: &mut Random| match random.below(4) {
        0 => Budget::unlimited(),
        _ => Budget::work(1 << (9 + random.below(10))),
    };
    run_against_model(Mode::Any, Reach::Here, 4, any);
    run_against_model(Mode::All, Reach::Here, 5, any);
    run_against_model(Mode::Any, Reach::Swept, 6, any);
}

/// The id as a number says it, which every scene takes for its own: for scenes to which the same is done.
fn anywhere(id: BodyId) -> BodyId {
    BodyId::from_bits(id.to_bits())
}

/// Spheres in a row, each overlapping its neighbours' boxes, turning and swinging.
fn row(scene: &mut Scene, bodies: usize) -> Vec<BodyId> {
    let options = BuildOptions::default().extremes(true);
    let mesh = shapes::torus_knot(2, 3, 0.1, 48);
    let knot = Arc::new(Tree::with_options(mesh, &options));
    let swinging = (0..bodies).map(|i| moving(scene, &knot, swing(i, 0)));
    swinging.collect()
}

/// All bodies of a row are where they are in a frame.
fn swing_all(scene: &mut Scene, ids: &[BodyId], frame: usize) {
    for (body, &id) in ids.iter().enumerate() {
        put(scene, id, swing(body, frame));
    }
}

fn swing(body: usize, frame: usize) -> Pose {
    let time = 0.05 * frame as f64 + body as f64;
    let turn = DMat3::from_rotation_y(time) * DMat3::from_rotation_x(0.7 * time);
    let place = DVec3::new(1.7 * body as f64, 0.3 * time.sin(), 0.2 * time.cos());
    Pose::new(turn, place).unwrap()
}

/// K = 2 ⌈C/R⌉ + 1 frames, R = B/8, for bodies that move all the time and for bodies at rest.
#[test]
fn no_pair_waits_longer_than_promised_and_no_budget_is_passed() {
    const BODIES: usize = 40;
    let (busy, calm) = ([400_000, 1_000_000, 2_000_000], [6_000, 20_000, 200_000]);
    for (moves, budgets) in [(true, busy), (false, calm)] {
        // What all pairs take, at most, without a budget.
        let mut free = Scene::new();
        let ids = row(&mut free, BODIES);
        let (mut cost, mut dearest) = (0, 0);
        for frame in 0..60 {
            for (body, &id) in ids.iter().enumerate().filter(|_| moves) {
                free.set_pose(id, swing(body, frame)).unwrap();
            }
            let work = detect(&mut free, Budget::unlimited()).work;
            cost = cost.max(work);
            dearest = dearest.max(work / BODIES as u64 * 4);
        }
        for budget in budgets {
            let share = budget / 8;
            assert!(!moves || dearest <= share, "{dearest}");
            // What is expected of a pair can be twice what it takes.
            let frames = 2 * (2 * cost).div_ceil(share) + 1;
            let mut scene = Scene::new();
            let ids = row(&mut scene, BODIES);
            let mut worst = 0;
            for frame in 0..(frames + 60).min(600) as usize {
                for (body, &id) in ids.iter().enumerate().filter(|_| moves) {
                    scene.set_pose(id, swing(body, frame)).unwrap();
                }
                let report = detect(&mut scene, Budget::work(budget));
                assert!(report.work <= budget, "{} of {budget}", report.work);
                worst = worst.max(report.worst_age);
            }
            assert!(worst <= frames, "{worst} frames, promised are {frames}");
            if !moves {
                // At rest, all is known in the end.
                assert_eq!(scene.report().decided, scene.report().pairs.len());
            }
        }
    }
}

/// However little a frame has, what rests is decided in the end, whatever was known of it before.
#[test]
fn bodies_at_rest_are_decided_within_the_smallest_budgets() {
    for budget in [700, 1_500, 4_000, 9_000] {
        let mut scene = Scene::new();
        let ids = row(&mut scene, 12);
        for place in 0..8 {
            swing_all(&mut scene, &ids, 7 * place);
            let decided = |_: &usize| detect(&mut scene, Budget::work(budget)).undecided() == 0;
            assert!((0..4000).find(decided).is_some(), "{budget} {place}");
        }
    }
}

#[test]
fn bodies_at_rest_cost_nothing() {
    let mut scene = Scene::new();
    let ids = row(&mut scene, 20);
    let first = whole_frame(&mut scene).clone();
    assert!(first.work > 0 && first.intersecting > 0);
    let second = detect(&mut scene, Budget::work(0)).clone();
    assert_eq!((second.work, second.decided), (0, first.decided));
    assert_eq!(second.pairs, first.pairs);
    scene.set_pose(ids[3], swing(3, 1)).unwrap();
    let third = whole_frame(&mut scene);
    assert!(third.work > 0 && third.work < first.work / 2);
}

#[test]
fn important_pairs_are_decided_first() {
    let (mut free, mut scene) = (Scene::new(), Scene::new());
    let important = |body: usize| body % 40 == 7;
    row(&mut free, 200);
    let ids: Vec<_> = row(&mut scene, 200).into_iter().map(anywhere).collect();
    for (body, &id) in ids.iter().enumerate() {
        let importance = if important(body) { 1.0 } else { 0.0 };
        scene.set_importance(id, importance).unwrap();
    }
    for frame in 1..100 {
        swing_all(&mut scene, &ids, frame);
        swing_all(&mut free, &ids, frame);
        let half = detect(&mut free, Budget::unlimited()).work / 2;
        let report = detect(&mut scene, Budget::work(half));
        let is_decided = |pair: &PairReport| {
            let is_important = important(pair.a.index()) || important(pair.b.index());
            pair.verdict != Verdict::Undecided || !is_important
        };
        assert!(report.pairs.iter().all(is_decided), "frame {frame}");
        assert!(report.undecided() > 0 || report.work < half, "{frame}");
    }
}

#[test]
fn a_deadline_ends_the_frame() {
    let mut scene = Scene::new();
    let ids = row(&mut scene, 60);
    for frame in 0..50 {
        swing_all(&mut scene, &ids, frame);
        // Each look at the clock takes 2 us of 100, and each of 16 batches looks once.
        let clock = ManualClock::ticking(Duration::from_micros(2));
        let report = scene.detect(Budget::time(Duration::from_micros(100)).clock(&clock));
        let elapsed = report.elapsed.unwrap();
        assert!(elapsed < Duration::from_micros(150), "{elapsed:?}");
    }
}

#[test]
fn a_body_that_passes_through_between_two_frames_is_reported_on_its_way() {
    let ball = ball(1);
    let at = |x: f64| at(x, 0.0, 0.0);
    for (reach, expected) in [(Reach::Here, 0), (Reach::Swept, 1)] {
        let mut scene = Scene::new();
        scene.set_reach(reach);
        fixed(&mut scene, &ball, at(0.0));
        let bullet = moving(&mut scene, &ball, at(-10.0));
        assert_eq!(whole_frame(&mut scene).pairs.len(), 0);
        scene.set_pose(bullet, at(10.0)).unwrap();
        assert_eq!(whole_frame(&mut scene).pairs.len(), expected);
        // It rests now.
        assert_eq!(whole_frame(&mut scene).pairs.len(), 0);
    }
}

#[test]
fn what_is_refused_names_the_body_and_changes_nothing() {
    let (ball, mut scene) = (ball(1), Scene::new());
    let body = moving(&mut scene, &ball, Pose::IDENTITY);
    let shear = DVec3::new(5e-4, 1.0, 0.0);
    let sheared = Pose::from_axes(DVec3::X, shear, DVec3::Z, DVec3::ZERO).unwrap();
    let error = scene.set_pose(body, sheared).unwrap_err();
    assert!(matches!(error, SceneError::NotARotation { body: it, .. } if it == body));
    assert!(
        error.to_string().starts_with("body 0 (generation 0):"),
        "{error}"
    );
    let error = scene.set_pose(body, at(0.0, 1e300, 0.0)).unwrap_err();
    assert_eq!(error, SceneError::TooFar { body, axis: 1 });
    let error = scene.set_importance(body, f32::NAN).unwrap_err();
    assert_eq!(error, SceneError::ImportanceNotANumber { body });
    assert!(scene.insert(Body::moving(ball, sheared)).is_err());
    assert_eq!(
        (scene.len(), scene.body(body).unwrap().pose),
        (1, Pose::IDENTITY)
    );
    scene.remove(body).unwrap();
    assert_eq!(
        scene.remove(body).unwrap_err(),
        SceneError::NoSuchBody { body }
    );
    assert!(whole_frame(&mut scene).pairs.is_empty());
}

/// Poses as far from rotations and as far out as a scene takes them: every two have a relative pose.
#[test]
fn poses_at_the_edge_of_what_is_accepted() {
    let ball = ball(0);
    let mut random = Random::new(9);
    let mut scene = Scene::new();
    for i in 0..40 {
        let mut stretch = DMat3::IDENTITY * (1.0 + 4.9e-5 * random.signed().signum());
        stretch.y_axis.x = 4e-5 * random.signed();
        let out = [2f64.powi(989), 1.0][i % 2] * random.vector();
        let pose = Pose::new(random.rotation() * stretch, out).unwrap();
        let _ = scene.insert(Body::moving(Arc::clone(&ball), pose));
    }
    assert!(scene.len() > 20);
    let report = whole_frame(&mut scene);
    assert_eq!(report.decided, report.pairs.len());
}

#[cfg(feature = "parallel")]
#[test]
fn the_same_report_on_any_number_of_threads() {
    let play = |threads: usize, budget: Budget| {
        let mut scene = Scene::new();
        scene.track_contacts();
        scene.use_threads(threads).unwrap();
        let ids = row(&mut scene, 80);
        let mut reports = Vec::new();
        for frame in 0..40 {
            for (body, &id) in ids.iter().enumerate().filter(|(body, _)| body % 5 != 0) {
                scene.set_pose(id, swing(body, frame)).unwrap();
            }
            // A frame without a budget leaves nothing behind that depends on the threads.
            let is_free = frame % 8 == 3;
            let report = scene.detect([budget, Budget::unlimited()][usize::from(is_free)]);
            let told = (report.pairs.clone(), report.contacts.clone());
            reports.push((told, report.work, report.bv_tests));
        }
        reports
    };
    for budget in [
        Budget::work(50_000),
        Budget::work(300_000),
        Budget::work(2_000_000),
        Budget::unlimited(),
    ] {
        let alone = play(1, budget);
        for threads in [2, 3, 7] {
            assert_eq!(play(threads, budget), alone, "{threads} {budget:?}");
        }
    }
}
