//! Shapes in scenes, against the queries of all bodies one by one.

use std::sync::Arc;

use crate::common::random::Random;
use crate::{moving, pose, trees, whole_frame};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::tree::Solid;
use punctual::{
    Budget, BuildOptions, Mesh, Mode, Motion, Pose, Query, Ray, StopReason, Tree, Verdict,
    Workspace, shapes,
};
use punctual_scene::{
    Body, BodyId, Closest, Filter, Overlap, Scene, SceneError, SceneRay, SceneShape, ShapeCast,
};

/// A budget by a clock that stands still.
macro_rules! by {
    ($budget:expr) => {
        $budget.clock(&ManualClock::new())
    };
}

/// What a test knows of a scene: its bodies, and which of them an asking body does not see.
struct World {
    scene: Scene,
    asker: BodyId,
    hidden: Vec<BodyId>,
    at: DVec3,
}

/// Hundreds of bodies of all kinds around a place: filtered, with margins, sensors, parts of
/// compounds, removed ones, and some that moved since the last frame.
fn world(at: DVec3, random: &mut Random) -> World {
    let (mut scene, trees) = (Scene::new(), trees());
    let place = |reach: f64, random: &mut Random| {
        let near = pose(reach, random);
        Pose::new(*near.rotation(), at + near.translation()).unwrap()
    };
    let body = |random: &mut Random| {
        let tree = Arc::clone(&trees[random.below(trees.len())]);
        let body = Body::moving(tree, place(10.0, random));
        match random.below(6) {
            0 => body.margin(0.2),
            1 => body.sensor(),
            2 => body.filter(Filter::new(1 << random.below(3), 7)),
            _ => body,
        }
    };
    let ids: Vec<_> = (0..260)
        .map(|_| scene.insert(body(random)).unwrap())
        .collect();
    let mut parts: Vec<_> = (0..5).map(|_| body(random)).collect();
    parts
        .iter_mut()
        .for_each(|part| part.pose = pose(2.0, random));
    let compound = scene.insert_compound(place(9.0, random), parts).unwrap();
    let hidden: Vec<_> = scene.parts(compound).unwrap().collect();
    let asker = hidden[0];
    whole_frame(&mut scene);
    for &id in ids.iter().step_by(9) {
        scene.set_pose(id, place(10.0, random)).unwrap();
    }
    for &id in ids.iter().skip(3).step_by(20) {
        scene.remove(id).unwrap();
    }
    scene.ignore(asker, ids[1], true).unwrap();
    let robot = scene.group("robot");
    let wall = scene.group("wall");
    scene.ignore_groups(robot, wall, true).unwrap();
    scene.set_group(asker, Some(robot)).unwrap();
    scene.set_group(ids[4], Some(wall)).unwrap();
    let hidden = [hidden, vec![ids[1], ids[4]]].concat();
    World {
        scene,
        asker,
        hidden,
        at,
    }
}

/// A shape as a test knows it.
struct Probe {
    tree: Option<Arc<Tree>>,
    motion: Motion,
    margin: f64,
    filter: Filter,
    asker: Option<BodyId>,
}

impl Probe {
    fn any(world: &World, random: &mut Random) -> Self {
        let trees = trees();
        let near = pose(8.0, random);
        let is_point = random.below(4) == 0;
        let start = Pose::new(*near.rotation(), world.at + near.translation()).unwrap();
        let start = if is_point {
            Pose::new(DMat3::IDENTITY, start.translation()).unwrap()
        } else {
            start
        };
        let way = [0.5, 6.0, 20.0][random.below(3)] * random.vector();
        let motion = if random.below(2) == 0 || is_point {
            Motion::straight(start, way).unwrap()
        } else {
            let turn = [0.3, 3.0, 9.0][random.below(3)] * random.vector();
            let point = start.translation() + random.vector();
            Motion::turning(start, way, turn, point).unwrap()
        };
        Self {
            tree: (!is_point).then(|| Arc::clone(&trees[random.below(trees.len())])),
            motion,
            margin: [0.0, 0.3][random.below(2)],
            filter: [Filter::default(), Filter::new(u32::MAX, 3)][random.below(2)],
            asker: [None, Some(world.asker)][random.below(2)],
        }
    }

    fn shape(&self) -> SceneShape<'_> {
        let shape = match &self.tree {
            Some(tree) => SceneShape::moving(tree, self.motion),
            None => SceneShape::point(self.motion.start().translation())
                .unwrap()
                .along(self.motion.velocity())
                .unwrap(),
        };
        let shape = shape.margin(self.margin).filter(self.filter);
        match self.asker {
            Some(asker) => shape.of_body(asker),
            None => shape,
        }
    }
}

/// What is true of all bodies that a shape sees.
struct Truth {
    met: Vec<BodyId>,
    /// Times before which each body is proven not to be met, and at which it is.
    times: Vec<(f64, Option<f64>)>,
    distances: Vec<[f64; 2]>,
}

fn truth(world: &World, probe: &Probe, workspace: &mut Workspace) -> Truth {
    let point = Mesh::new([[0.0f32; 3]; 3], [[0, 1, 2]]).unwrap();
    let point = Tree::with_options(point, &BuildOptions::default().solid(Solid::Keep));
    let tree = probe.tree.as_deref().unwrap_or(&point);
    let mut truth = Truth {
        met: Vec::new(),
        times: Vec::new(),
        distances: Vec::new(),
    };
    for (id, body) in world.scene.bodies() {
        let own = probe
            .asker
            .map(|asker| world.scene.body(asker).unwrap().filter);
        let is_seen = probe.filter.meets(body.filter)
            && own.is_none_or(|own| own.meets(body.filter) && !world.hidden.contains(&id));
        if !is_seen {
            continue;
        }
        let (trees, margins) = ([&*body.tree, tree], [body.margin, probe.margin]);
        let b_in_a = body.pose.inverse().unwrap();
        let b_in_a = b_in_a.compose(&probe.motion.start()).unwrap();
        let distance = Query::distance(trees[0], trees[1], b_in_a).margins(margins);
        let bounds = distance.run(workspace, by!(Budget::unlimited())).value;
        truth.distances.push([bounds.low, bounds.high]);
        let meets = if margins == [0.0; 2] {
            let query = Query::intersection(trees[0], trees[1], b_in_a);
            query.run(workspace, by!(Budget::unlimited())).value.meets()
        } else {
            bounds.high == 0.0
        };
        if meets {
            truth.met.push(id);
        }
        let still = Motion::straight(body.pose, [0.0; 3]).unwrap();
        let query = Query::impact_of_both(trees, [still, probe.motion]).margins(margins);
        let found = query.run(workspace, by!(Budget::unlimited())).value;
        truth.times.push((found.lower, found.upper));
    }
    truth
}

fn least(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(f64::INFINITY, f64::min)
}

fn assert_cast(cast: &ShapeCast, truth: &Truth, is_finished: bool) {
    let lower = least(truth.times.iter().map(|time| time.0));
    let first = least(truth.times.iter().filter_map(|time| time.1));
    assert!(cast.free_until <= first.min(1.0), "{cast:?} {first}");
    assert_eq!(cast.hit.is_some(), cast.touching_at.is_some());
    assert!(
        cast.touching_at.is_none_or(|time| time >= first),
        "{cast:?}"
    );
    if is_finished {
        assert_eq!(cast.touching_at.unwrap_or(f64::INFINITY), first, "{cast:?}");
        assert!(cast.free_until >= lower.min(1.0), "{cast:?} {lower}");
    }
}

fn assert_closest(closest: &Closest, truth: &Truth, within: f64, is_finished: bool) {
    let [low, high] = [0, 1].map(|i| least(truth.distances.iter().map(|both| both[i])));
    // The defaults of the queries, of meshes of at most three units.
    let tolerance = 4e-6 + 2e-5 * high.min(1e300);
    assert!(closest.low <= high && closest.low <= closest.high);
    assert!(closest.high >= low, "{closest:?} {low}");
    assert!(closest.high <= within || closest.hit.is_none());
    if is_finished && high <= within {
        assert!(closest.high <= high + tolerance, "{closest:?} {high}");
    }
    if is_finished {
        let least = low.min(within) - tolerance;
        assert!(closest.low >= least, "{closest:?} {low} {within}");
    }
    if let Some([a, b]) = closest
        .hit
        .filter(|_| closest.high > 0.0)
        .and_then(|hit| hit.points)
    {
        let apart = (a - b).length();
        assert!(
            (apart - closest.high).abs() < 1e-9 * (1.0 + a.length()),
            "{closest:?} {apart}"
        );
        let normal = closest.hit.unwrap().normal;
        assert!(apart < 1e-6 || normal.unwrap().dot(b - a) > 0.999 * apart);
    }
}

fn assert_overlap(overlap: &Overlap, truth: &Truth, mode: Mode) {
    let met: Vec<_> = overlap.met.iter().map(|met| met.body).collect();
    assert!(met.is_sorted() && met.iter().all(|id| truth.met.contains(id)));
    assert!(overlap.met.iter().all(|met| met.verdict.meets()));
    assert!(overlap.undecided.is_sorted());
    if overlap.is_whole {
        let is_named = |id: &BodyId| met.contains(id) || overlap.undecided.contains(id);
        assert!(truth.met.iter().all(is_named), "{overlap:?}");
    }
    if overlap.stop == StopReason::Finished {
        assert!(overlap.is_whole && overlap.undecided.is_empty());
    }
    if overlap.stop == StopReason::FirstHit {
        assert!(mode == Mode::Any && met.len() == 1 && !overlap.is_whole);
    }
}

#[test]
fn shapes_are_answered_like_the_queries_of_all_bodies_one_by_one() {
    let (mut random, mut workspace) = (Random::new(77), Workspace::new());
    let (mut hits, mut met, mut near, mut cut) = (0, 0, 0, [0; 3]);
    for at in [DVec3::ZERO, DVec3::new(3e5, -2e4, 1e6)] {
        let mut world = world(at, &mut random);
        for _ in 0..60 {
            let probe = Probe::any(&world, &mut random);
            let truth = truth(&world, &probe, &mut workspace);
            let (scene, shape) = (&mut world.scene, probe.shape());
            let cast = scene.cast_shape(&shape, by!(Budget::unlimited())).unwrap();
            assert_eq!(cast.stop, StopReason::Finished);
            assert_cast(&cast, &truth, true);
            hits += usize::from(cast.touching_at > Some(0.0));
            let within = [f64::INFINITY, 2.0, 0.3][random.below(3)];
            let closest = scene.closest(&shape, within, by!(Budget::unlimited()));
            let closest = closest.unwrap();
            assert_closest(&closest, &truth, within, true);
            near += usize::from(closest.hit.is_some() && closest.high > 0.0);
            let overlap = scene.overlap(&shape, Mode::All, by!(Budget::unlimited()));
            let overlap = overlap.unwrap();
            assert_overlap(&overlap, &truth, Mode::All);
            assert_eq!(overlap.met.len(), truth.met.len());
            met += overlap.met.len();
            let of_overlap = overlap.work;
            let any = scene.overlap(&shape, Mode::Any, by!(Budget::unlimited()));
            let any = any.unwrap();
            assert_overlap(&any, &truth, Mode::Any);
            assert_eq!(any.met.is_empty(), truth.met.is_empty());

            // Cut short, twice each.
            let budget = |work: u64, random: &mut Random| {
                let work = random.below(work as usize + 1) as u64;
                (work, Budget::work(work))
            };
            let (work, part) = budget(cast.work, &mut random);
            let [one, two] = [(); 2].map(|()| scene.cast_shape(&shape, by!(part)).unwrap());
            assert!(one == two && one.work <= work, "{one:?} {two:?} {work}");
            assert_cast(&one, &truth, one.stop == StopReason::Finished);
            cut[0] += usize::from(one.stop == StopReason::WorkLimit && one.free_until > 0.0);
            let (work, part) = budget(closest.work, &mut random);
            let [one, two] = [(); 2].map(|()| scene.closest(&shape, within, by!(part)).unwrap());
            assert!(one == two && one.work <= work, "{one:?} {two:?} {work}");
            assert_closest(&one, &truth, within, one.stop == StopReason::Finished);
            cut[1] += usize::from(one.stop == StopReason::WorkLimit && one.low > 0.0);
            let (work, part) = budget(of_overlap, &mut random);
            let overlap = scene.overlap(&shape, Mode::All, by!(part)).unwrap();
            assert!(overlap.work <= work);
            assert_overlap(&overlap, &truth, Mode::All);
            cut[2] += usize::from(overlap.is_whole && !overlap.undecided.is_empty());
        }
    }
    assert!(hits > 20 && met > 40 && near > 15, "{hits} {met} {near}");
    assert!(cut.iter().all(|&count| count > 3), "{cut:?}");
}

fn ball() -> Arc<Tree> {
    let options = BuildOptions::default().solid(Solid::Keep);
    Arc::new(Tree::with_options(shapes::icosphere(3), &options))
}

fn at(x: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, [x, 0.0, 0.0]).unwrap()
}

#[test]
fn a_budget_of_nothing_proves_nothing_and_claims_nothing() {
    let mut scene = Scene::new();
    let id = scene.insert(Body::moving(ball(), at(3.0))).unwrap();
    for _ in 0..2 {
        let shape = SceneShape::point([0.0; 3])
            .unwrap()
            .along([9.0, 0.0, 0.0])
            .unwrap();
        let cast = scene.cast_shape(&shape, by!(Budget::work(0))).unwrap();
        // Boxes alone prove something after a frame.
        assert!(cast.free_until <= 2.0 / 9.0 && cast.hit.is_none() && cast.work == 0);
        let closest = scene.closest(&shape, 9.0, by!(Budget::work(0))).unwrap();
        assert!(closest.low <= 2.0 && closest.high == f64::INFINITY && closest.hit.is_none());
        let overlap = scene
            .overlap(&shape.margin(2.5), Mode::All, by!(Budget::work(0)))
            .unwrap();
        assert_eq!(
            (overlap.met.len(), overlap.stop),
            (0, StopReason::WorkLimit)
        );
        assert!(!overlap.is_whole || overlap.undecided == [id]);
        whole_frame(&mut scene);
    }
    let empty = scene.overlap(
        &SceneShape::point([0.0; 3]).unwrap(),
        Mode::All,
        by!(Budget::work(0)),
    );
    assert_eq!(empty.unwrap().work, 0);
}

#[test]
fn a_body_inside_a_solid_meets_it_but_not_its_surface() {
    let (mut scene, small) = (Scene::new(), ball());
    let big = shapes::cuboid([4.0, 4.0, 4.0], 2);
    let solid = BuildOptions::default().solid(Solid::Keep);
    let id = scene.insert(Body::fixed(
        Arc::new(Tree::with_options(big.clone(), &solid)),
        at(0.0),
    ));
    let id = id.unwrap();
    for shape in [
        SceneShape::new(&small, at(0.5)),
        SceneShape::point([0.5, 0.0, 0.0]).unwrap(),
        SceneShape::point([0.5, 0.0, 0.0]).unwrap().margin(0.1),
    ] {
        let overlap = scene
            .overlap(&shape, Mode::All, by!(Budget::unlimited()))
            .unwrap();
        assert_eq!(overlap.met[0].body, id);
        assert!(
            matches!(overlap.met[0].verdict, Verdict::Contained { .. }),
            "{overlap:?}"
        );
        let closest = scene
            .closest(&shape, 9.0, by!(Budget::unlimited()))
            .unwrap();
        assert_eq!(
            (closest.low, closest.high, closest.hit.unwrap().body),
            (0.0, 0.0, id)
        );
        let shape = shape.along([9.0, 0.0, 0.0]).unwrap();
        let cast = scene.cast_shape(&shape, by!(Budget::unlimited())).unwrap();
        assert_eq!((cast.free_until, cast.touching_at), (0.0, Some(0.0)));
    }
    scene.set_tree(id, Arc::new(Tree::new(big))).unwrap();
    let shape = SceneShape::new(&small, at(0.5));
    assert!(
        scene
            .overlap(&shape, Mode::All, by!(Budget::unlimited()))
            .unwrap()
            .met
            .is_empty()
    );
}

#[test]
fn a_shape_of_a_body_sees_what_the_body_may_meet_and_not_itself() {
    let mut scene = Scene::new();
    let [a, b, c] = [0.0, 1.5, 3.0].map(|x| scene.insert(Body::moving(ball(), at(x))).unwrap());
    let tree = ball();
    let shape = SceneShape::new(&tree, at(0.0));
    let seen = |shape: &SceneShape, scene: &mut Scene| {
        let closest = scene
            .closest(shape, f64::INFINITY, by!(Budget::unlimited()))
            .unwrap();
        closest.hit.map(|hit| hit.body)
    };
    assert_eq!(seen(&shape, &mut scene), Some(a));
    assert_eq!(seen(&shape.of_body(a), &mut scene), Some(b));
    scene.ignore(a, b, true).unwrap();
    assert_eq!(seen(&shape.of_body(a), &mut scene), Some(c));
    let (arm, cell) = (scene.group("arm"), scene.group("cell"));
    scene.set_group(a, Some(arm)).unwrap();
    scene.set_group(c, Some(cell)).unwrap();
    assert_eq!(seen(&shape.of_body(a), &mut scene), Some(c));
    scene.ignore_groups(cell, arm, true).unwrap();
    assert_eq!(seen(&shape.of_body(a), &mut scene), None);
    scene.remove(b).unwrap();
    let gone = scene.overlap(&shape.of_body(b), Mode::Any, by!(Budget::unlimited()));
    assert_eq!(gone, Err(SceneError::NoSuchBody { body: b }));
}

#[test]
fn bodies_of_other_groups_are_seen_past_those_that_are_ignored_before_the_first_frame_too() {
    let mut scene = Scene::new();
    let ids = [0.0, 2.5, 5.0].map(|x| scene.insert(Body::moving(ball(), at(x))).unwrap());
    let groups = ["left", "right"].map(|name| scene.group(name));
    for (id, group) in ids.into_iter().zip(groups) {
        scene.set_group(id, Some(group)).unwrap();
    }
    scene.ignore_groups(groups[0], groups[1], true).unwrap();
    let ray = Ray::new([-5.0, 0.2, 0.1], [1.0, 0.0, 0.0]).unwrap();
    let ray = SceneRay::new(ray).of_body(ids[0]);
    for _ in 0..2 {
        let cast = scene.cast(&ray, by!(Budget::unlimited())).unwrap();
        assert_eq!(cast.hit.map(|hit| hit.body), Some(ids[2]));
        whole_frame(&mut scene);
    }
}

#[test]
fn a_shape_with_bad_numbers_is_refused_by_what_is_wrong() {
    let (mut scene, tree) = (Scene::new(), ball());
    let shape = SceneShape::new(&tree, at(0.0));
    let skew = Pose::new(
        DMat3::from_diagonal(DVec3::new(1.0 + 4e-4, 1.0, 1.0)),
        [0.0; 3],
    );
    let far = Motion::straight(at(2f64.powi(989)), [2f64.powi(990), 0.0, 0.0]).unwrap();
    let cases = [
        (shape.margin(-1.0), "margin"),
        (shape.margin(f64::NAN), "margin"),
        (SceneShape::new(&tree, skew.unwrap()), "rotation"),
        (SceneShape::moving(&tree, far), "2^990"),
    ];
    for (shape, what) in cases {
        let error = scene
            .cast_shape(&shape, by!(Budget::unlimited()))
            .unwrap_err();
        assert!(matches!(error, SceneError::NoShape { .. }), "{error}");
        assert!(error.to_string().starts_with("the shape: ") && error.to_string().contains(what));
    }
    for within in [-1.0, f64::NAN] {
        let error = scene
            .closest(&shape, within, by!(Budget::unlimited()))
            .unwrap_err();
        assert!(error.to_string().contains("within"), "{error}");
    }
    assert!(SceneShape::point([f64::NAN, 0.0, 0.0]).is_err());
    let none = scene
        .closest(&shape, f64::INFINITY, by!(Budget::unlimited()))
        .unwrap();
    assert_eq!(
        (none.low, none.high, none.hit),
        (f64::INFINITY, f64::INFINITY, None)
    );
    let empty = Arc::new(Tree::new(Mesh::new([[0.0f32; 3]; 0], []).unwrap()));
    moving(&mut scene, &empty, at(0.0));
    moving(&mut scene, &tree, at(0.5));
    for shape in [
        SceneShape::new(&empty, at(0.0)),
        SceneShape::new(&tree, at(9.0)),
    ] {
        assert!(
            scene
                .overlap(&shape, Mode::All, by!(Budget::unlimited()))
                .unwrap()
                .met
                .is_empty()
        );
    }
}
