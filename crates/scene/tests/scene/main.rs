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
use punctual::{Budget, BuildOptions, Mode, Pose, Query, Tree, Verdict, Workspace, shapes};
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
    Pose::new(
        turn * *from.rotation(),
        from.translation() + 0.1 * random.vector(),
    )
    .unwrap()
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
                let ((a, x), (b, y)) = if id < other {
                    ((id, x), (other, y))
                } else {
                    ((other, y), (id, x))
                };
                if Self::may_meet(x, y) {
                    let b_in_a = x.pose.inverse().unwrap().compose(&y.pose).unwrap();
                    let query = Query::all_pairs(&x.tree, &y.tree, b_in_a);
                    let found = check::run(&query, workspace, Budget::unlimited())
                        .stats
                        .found;
                    if found > 0 {
                        pairs.push((a.index(), b.index(), found));
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
        let place = pose(2.5, random);
        let body = if random.below(4) == 0 {
            Body::fixed(tree, place)
        } else {
            Body::moving(tree, place)
        };
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
    let (id, body) = model.bodies[at].clone();
    let rebuilt = |body: &Body, tree: Arc<Tree>, pose: Pose, filter: Filter| match body.kind {
        BodyKind::Fixed => Body::fixed(tree, pose).filter(filter),
        BodyKind::Moving => Body::moving(tree, pose).filter(filter),
    };
    let (own_tree, own_pose, own_filter) = (Arc::clone(&body.tree), body.pose, body.filter);
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
            model.bodies[at].1 = rebuilt(&body, tree, own_pose, own_filter);
        }
        2 => {
            scene.set_filter(id, filter).unwrap();
            model.bodies[at].1 = rebuilt(&body, own_tree, own_pose, filter);
        }
        3 => scene.set_importance(id, random.signed() as f32).unwrap(),
        4 => {
            let far = pose(2.5, random);
            scene.set_pose(id, far).unwrap();
            model.bodies[at].1 = rebuilt(&body, own_tree, far, own_filter);
        }
        _ => {
            let near = nudged(&own_pose, random);
            scene.set_pose(id, near).unwrap();
            model.bodies[at].1 = rebuilt(&body, own_tree, near, own_filter);
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
    let of_b = b
        .tree
        .mesh()
        .triangle(y as usize)
        .map(|corner| b_in_a.transform_point(corner));
    let far = a.pose.translation().abs().max_element() + b.pose.translation().abs().max_element();
    let (truth, rounding) = (
        exact_distance::Distance::of(&of_a, &of_b).rounded(),
        1e-12 * (1.0 + far),
    );
    match pair.verdict {
        Verdict::Within { distance, .. } => {
            assert!(
                distance > 0.0 && distance <= a.margin + b.margin,
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

/// Every verdict is true and every missing pair is apart; the counts are right.
#[track_caller]
fn assert_sound(report: &Report, truth: &[(usize, usize, u64)], complete: bool) {
    let mut decided = 0;
    for pair in &report.pairs {
        let key = (pair.a.index(), pair.b.index());
        let found = truth
            .iter()
            .find(|&&(a, b, _)| (a, b) == key)
            .map_or(0, |&(.., found)| found);
        match pair.verdict {
            Verdict::Intersecting { .. } | Verdict::Within { .. } | Verdict::Contained { .. } => {
                assert!(found >= pair.found && pair.found > 0, "{key:?} {pair:?}");
            }
            Verdict::Separated => assert_eq!(found, 0, "{key:?} is not apart"),
            Verdict::Undecided => assert!(pair.age > 0 && !complete, "{key:?}"),
        }
        assert!(pair.complete || !complete);
        assert_eq!(pair.age == 0, pair.verdict != Verdict::Undecided);
        decided += usize::from(pair.verdict != Verdict::Undecided);
    }
    assert_eq!(decided, report.decided);
    assert_eq!(
        report.worst_age,
        report.pairs.iter().map(|pair| pair.age).max().unwrap_or(0)
    );
    let listed = |key: (usize, usize)| {
        report
            .pairs
            .iter()
            .any(|pair| (pair.a.index(), pair.b.index()) == key)
    };
    assert!(report.is_whole() || !complete);
    let lost = || truth.iter().any(|&(a, b, _)| !listed((a, b)));
    // A pair was lost by the broad phase.
    assert!(!report.is_whole() || !lost());
    assert_eq!(report.intersecting, report.intersecting_pairs().count());
    let within = report
        .pairs
        .iter()
        .filter(|pair| matches!(pair.verdict, Verdict::Within { .. }))
        .count();
    assert_eq!(
        (report.within, report.intersecting + within),
        (within, report.meeting_pairs().count())
    );
    assert!(!complete || report.intersecting + within == truth.len());
}

fn run_against_model(mode: Mode, reach: Reach, seed: u64, budget: impl Fn(&mut Random) -> Budget) {
    let trees = trees();
    let (mut scene, mut model) = (Scene::new(), Model::default());
    scene.set_mode(mode);
    scene.set_reach(reach);
    let (mut random, mut workspace, mut ledger) =
        (Random::new(seed), Workspace::new(), Ledger::default());
    scene.track_contacts();
    let (mut cut, mut met) = (false, 0);
    for _ in 0..150 {
        for _ in 0..random.below(25) {
            change(&mut scene, &mut model, &trees, &mut random);
        }
        assert_eq!(scene.len(), model.bodies.len());
        met += rays::check(&mut scene, &model, &mut random, &mut workspace);
        let truth = model.truth(&mut workspace);
        let budget = budget(&mut random);
        let report = detect(&mut scene, budget);
        cut |= budget != Budget::unlimited();
        assert_sound(report, &truth, budget == Budget::unlimited());
        ledger.check(report, &model, &truth, budget == Budget::unlimited());
        if mode == Mode::All {
            let found = |key| {
                truth
                    .iter()
                    .find(|&&(a, b, _)| (a, b) == key)
                    .map_or(0, |&(.., found)| found)
            };
            let complete = report.pairs.iter().filter(|pair| pair.complete);
            assert!(
                complete
                    .into_iter()
                    .all(|pair| pair.found == found((pair.a.index(), pair.b.index())))
            );
        }
        for &id in &model.removed {
            assert_eq!(
                scene.body(id).unwrap_err(),
                SceneError::NoSuchBody { body: id }
            );
        }
        assert!(scene.bodies().count() == model.bodies.len());
        assert_certificates(&scene, &truth);
        met += rays::check(&mut scene, &model, &mut random, &mut workspace);
    }
    assert!(met > 50, "{met} rays hit something");
    let [began, persist, undecided, ended] = ledger.told;
    assert!(
        began > 10 && persist > 10 && ended > 10 && (undecided > 10) == cut,
        "{:?}",
        ledger.told
    );
}

#[track_caller]
fn assert_certificates(scene: &Scene, truth: &[(usize, usize, u64)]) {
    for pair in &scene.report().pairs {
        let certificate = scene.certificate(pair.b, pair.a).unwrap();
        let found = truth
            .iter()
            .find(|&&(a, b, _)| (a, b) == (pair.a.index(), pair.b.index()));
        assert!(
            certificate.upper_bound >= found.map_or(0, |&(.., found)| found),
            "{pair:?} {certificate:?}"
        );
        assert!(certificate.largest_extent >= 0.0 && certificate.largest_extent.is_finite());
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
    let knot = Arc::new(Tree::with_options(
        shapes::torus_knot(2, 3, 0.1, 48),
        &options,
    ));
    (0..bodies)
        .map(|i| {
            scene
                .insert(Body::moving(Arc::clone(&knot), swing(i, 0)))
                .unwrap()
        })
        .collect()
}

fn swing(body: usize, frame: usize) -> Pose {
    let time = 0.05 * frame as f64 + body as f64;
    let turn = DMat3::from_rotation_y(time) * DMat3::from_rotation_x(0.7 * time);
    Pose::new(
        turn,
        DVec3::new(1.7 * body as f64, 0.3 * time.sin(), 0.2 * time.cos()),
    )
    .unwrap()
}

/// K = 2 ⌈C/R⌉ + 1 frames, R = B/8, for bodies that move all the time and for bodies at rest.
#[test]
fn no_pair_waits_longer_than_promised_and_no_budget_is_passed() {
    const BODIES: usize = 40;
    for (moves, budgets) in [
        (true, [400_000, 1_000_000, 2_000_000]),
        (false, [6_000, 20_000, 200_000]),
    ] {
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
fn what_rests_is_decided_within_the_smallest_budgets() {
    for budget in [700, 1_500, 4_000, 9_000] {
        let mut scene = Scene::new();
        let ids = row(&mut scene, 12);
        for place in 0..8 {
            for (body, &id) in ids.iter().enumerate() {
                scene.set_pose(id, swing(body, 7 * place)).unwrap();
            }
            let decided = |_: &usize| detect(&mut scene, Budget::work(budget)).undecided() == 0;
            assert!((0..4000).find(decided).is_some(), "{budget} {place}");
        }
    }
}

#[test]
fn what_rests_costs_nothing() {
    let mut scene = Scene::new();
    let ids = row(&mut scene, 20);
    let first = detect(&mut scene, Budget::unlimited()).clone();
    assert!(first.work > 0 && first.intersecting > 0);
    let second = detect(&mut scene, Budget::work(0)).clone();
    assert_eq!((second.work, second.decided), (0, first.decided));
    assert_eq!(second.pairs, first.pairs);
    scene.set_pose(ids[3], swing(3, 1)).unwrap();
    let third = detect(&mut scene, Budget::unlimited());
    assert!(third.work > 0 && third.work < first.work / 2);
}

#[test]
fn important_pairs_are_decided_first() {
    let (mut free, mut scene) = (Scene::new(), Scene::new());
    let important = |body: usize| body % 40 == 7;
    row(&mut free, 200);
    let ids: Vec<_> = row(&mut scene, 200).into_iter().map(anywhere).collect();
    for (body, &id) in ids.iter().enumerate() {
        scene
            .set_importance(id, if important(body) { 1.0 } else { 0.0 })
            .unwrap();
    }
    for frame in 1..100 {
        for (body, &id) in ids.iter().enumerate() {
            scene.set_pose(id, swing(body, frame)).unwrap();
            free.set_pose(id, swing(body, frame)).unwrap();
        }
        let half = detect(&mut free, Budget::unlimited()).work / 2;
        let report = detect(&mut scene, Budget::work(half));
        let mut pairs = report
            .pairs
            .iter()
            .filter(|pair| important(pair.a.index()) || important(pair.b.index()));
        assert!(
            pairs.all(|pair| pair.verdict != Verdict::Undecided),
            "frame {frame}"
        );
        assert!(report.undecided() > 0 || report.work < half, "{frame}");
    }
}

#[test]
fn a_deadline_ends_the_frame() {
    let mut scene = Scene::new();
    let ids = row(&mut scene, 60);
    for frame in 0..50 {
        for (body, &id) in ids.iter().enumerate() {
            scene.set_pose(id, swing(body, frame)).unwrap();
        }
        // Each look at the clock takes 2 us of 100, and each of 16 batches looks once.
        let clock = ManualClock::ticking(Duration::from_micros(2));
        let report = scene.detect(Budget::time(Duration::from_micros(100)).clock(&clock));
        let elapsed = report.elapsed.unwrap();
        assert!(elapsed < Duration::from_micros(150), "{elapsed:?}");
    }
}

#[test]
fn a_body_that_passes_through_between_two_frames_is_reported_on_its_way() {
    let ball = Arc::new(Tree::new(shapes::icosphere(1)));
    let at = |x: f64| Pose::new(DMat3::IDENTITY, DVec3::new(x, 0.0, 0.0)).unwrap();
    for (reach, expected) in [(Reach::Here, 0), (Reach::Swept, 1)] {
        let mut scene = Scene::new();
        scene.set_reach(reach);
        scene
            .insert(Body::fixed(Arc::clone(&ball), at(0.0)))
            .unwrap();
        let bullet = scene
            .insert(Body::moving(Arc::clone(&ball), at(-10.0)))
            .unwrap();
        assert_eq!(detect(&mut scene, Budget::unlimited()).pairs.len(), 0);
        scene.set_pose(bullet, at(10.0)).unwrap();
        assert_eq!(
            detect(&mut scene, Budget::unlimited()).pairs.len(),
            expected
        );
        // It rests now.
        assert_eq!(detect(&mut scene, Budget::unlimited()).pairs.len(), 0);
    }
}

#[test]
fn what_is_refused_names_the_body_and_changes_nothing() {
    let ball = Arc::new(Tree::new(shapes::icosphere(1)));
    let mut scene = Scene::new();
    let id = scene
        .insert(Body::moving(Arc::clone(&ball), Pose::IDENTITY))
        .unwrap();
    let sheared =
        Pose::from_axes(DVec3::X, DVec3::new(5e-4, 1.0, 0.0), DVec3::Z, DVec3::ZERO).unwrap();
    let error = scene.set_pose(id, sheared).unwrap_err();
    assert!(
        matches!(error, SceneError::NotARotation { body, .. } if body == id),
        "{error}"
    );
    let far = Pose::new(DMat3::IDENTITY, DVec3::new(0.0, 1e300, 0.0)).unwrap();
    assert_eq!(
        scene.set_pose(id, far).unwrap_err(),
        SceneError::TooFar { body: id, axis: 1 }
    );
    assert_eq!(
        error.to_string().split(':').next(),
        Some("body 0 (generation 0)")
    );
    let importance = scene.set_importance(id, f32::NAN).unwrap_err();
    assert_eq!(importance, SceneError::ImportanceNotANumber { body: id });
    assert!(scene.insert(Body::moving(ball, sheared)).is_err());
    assert_eq!(
        (scene.len(), scene.body(id).unwrap().pose),
        (1, Pose::IDENTITY)
    );
    scene.remove(id).unwrap();
    assert_eq!(
        scene.remove(id).unwrap_err(),
        SceneError::NoSuchBody { body: id }
    );
    assert!(detect(&mut scene, Budget::unlimited()).pairs.is_empty());
}

/// Poses as far from rotations and as far out as a scene takes them: every two have a relative pose.
#[test]
fn poses_at_the_edge_of_what_is_accepted() {
    let ball = Arc::new(Tree::new(shapes::icosphere(0)));
    let mut random = Random::new(9);
    let mut scene = Scene::new();
    for i in 0..40 {
        let mut stretch = DMat3::IDENTITY * (1.0 + 4.9e-5 * random.signed().signum());
        stretch.y_axis.x = 4e-5 * random.signed();
        let out = if i % 2 == 0 {
            2f64.powi(989) * random.vector()
        } else {
            random.vector()
        };
        let _ = scene.insert(Body::moving(
            Arc::clone(&ball),
            Pose::new(random.rotation() * stretch, out).unwrap(),
        ));
    }
    assert!(scene.len() > 20);
    let report = detect(&mut scene, Budget::unlimited());
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
            let budget = if frame % 8 == 3 {
                Budget::unlimited()
            } else {
                budget
            };
            let Report {
                pairs,
                contacts,
                work,
                bv_tests,
                ..
            } = scene.detect(budget).clone();
            reports.push((pairs, contacts, work, bv_tests));
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
