//! Once its buffers have grown to the size of the scene, a frame touches no allocator, on any of its threads: bodies that
//! move, meet, part, rest, come and go, with and without budgets. And none does within the room that was asked for.
//!
//! All in one test, since the calls of all threads are counted.

#[path = "../../../tests/common/allocations.rs"]
mod allocations;
#[path = "../../../tests/common/random.rs"]
#[allow(dead_code, reason = "each test file uses a part")]
mod random;

use std::sync::Arc;
use std::time::Duration;

use allocations::{allocator_calls_of_all_threads, held};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::tree::Solid;
use punctual::{Budget, BuildOptions, Mode, Motion, Pose, Ray, Tree, shapes};
use punctual_scene::{Body, BodyId, Filter, Reach, Scene, SceneRay, SceneShape};
use random::Random;

const BODIES: usize = 60;
/// Frames to grow in, and frames that are counted.
const WARM_UP: usize = 100;
const FRAMES: usize = 900;

/// Bodies that fly about in a cube and come back from its walls.
struct World {
    scene: Scene,
    ids: Vec<BodyId>,
    places: Vec<DVec3>,
    speeds: Vec<DVec3>,
    tree: Arc<Tree>,
    random: Random,
}

/// Half the edge of the cube; the bodies have a radius of 1.
const WALL: f64 = 4.0;

impl World {
    fn new(scene: Scene) -> Self {
        let tree = Arc::new(Tree::new(shapes::icosphere(1)));
        let mut random = Random::new(11);
        let places = (0..BODIES).map(|_| WALL * random.vector()).collect();
        let speeds = (0..BODIES).map(|_| 0.2 * random.vector()).collect();
        let mut world = Self {
            scene,
            ids: Vec::with_capacity(BODIES),
            places,
            speeds,
            tree,
            random,
        };
        for body in 0..BODIES {
            let placed = world.body(body);
            world.ids.push(world.scene.insert(placed).unwrap());
        }
        world
    }

    fn pose(&self, body: usize) -> Pose {
        Pose::new(DMat3::IDENTITY, self.places[body]).unwrap()
    }

    fn body(&self, body: usize) -> Body {
        let make = if body.is_multiple_of(5) {
            Body::fixed
        } else {
            Body::moving
        };
        make(Arc::clone(&self.tree), self.pose(body))
    }

    fn step(&mut self, body: usize) {
        let (place, speed) = (&mut self.places[body], &mut self.speeds[body]);
        for axis in 0..3 {
            if (place[axis] + speed[axis]).abs() > WALL {
                speed[axis] = -speed[axis];
            }
        }
        *place += *speed;
        let pose = self.pose(body);
        self.scene.set_pose(self.ids[body], pose).unwrap();
    }

    fn fly(&mut self) {
        (0..BODIES).for_each(|body| self.step(body));
    }
}

fn fly(world: &mut World, _: usize) {
    world.fly();
}

/// Most bodies rest, most of the time.
fn rest(world: &mut World, frame: usize) {
    if frame % 200 > 150 {
        world.fly();
    } else {
        let some = world.random.below(BODIES);
        world.step(some);
    }
}

/// All draw together and part again, in 60 frames.
fn breathe(world: &mut World, frame: usize) {
    let breath = 1.0 + (frame as f64 * std::f64::consts::TAU / 60.0).sin();
    for body in 0..BODIES {
        let speed = world.speeds[body];
        world.places[body] = 20.0 * speed * breath;
        let pose = world.pose(body);
        world.scene.set_pose(world.ids[body], pose).unwrap();
    }
}

/// Two bodies go in each frame, and others come in elsewhere.
fn come_and_go(world: &mut World, frame: usize) {
    world.fly();
    for body in [2 * frame % BODIES, (2 * frame + 1) % BODIES] {
        world.scene.remove(world.ids[body]).unwrap();
        world.places[body] = WALL * world.random.vector();
        let placed = world.body(body);
        world.ids[body] = world.scene.insert(placed).unwrap();
    }
}

/// Some bodies are somewhere else in each frame, in some frames all.
fn teleport(world: &mut World, frame: usize) {
    let count = if frame % 50 == 49 { BODIES } else { 5 };
    for _ in 0..count {
        let body = world.random.below(BODIES);
        world.places[body] = WALL * world.random.vector();
        world.step(body);
    }
}

/// Other bodies may meet in each frame.
fn refilter(world: &mut World, _: usize) {
    world.fly();
    for _ in 0..10 {
        let (body, groups) = (world.random.below(BODIES), 1 << world.random.below(3));
        world
            .scene
            .set_filter(world.ids[body], Filter::new(groups, 3 | groups))
            .unwrap();
        world
            .scene
            .set_importance(world.ids[body], groups as f32)
            .unwrap();
    }
}

/// Bodies fly through one another, and their contacts are told.
fn touch(world: &mut World, frame: usize) {
    if frame == 0 {
        world.scene.find_contacts();
    }
    world.fly();
    let [a, b] = [0, 1].map(|_| world.ids[world.random.below(BODIES)]);
    let _ = world.scene.contacts(a, b);
}

/// A compound of six turns among them.
fn turn(world: &mut World, frame: usize) {
    if frame == 0 {
        let parts: Vec<_> = (0..6).map(|body| world.body(body)).collect();
        let compound = world.scene.insert_compound(Pose::IDENTITY, parts).unwrap();
        world.ids.extend(world.scene.parts(compound).unwrap());
    }
    world.fly();
    let compound = world.scene.compound_of(world.ids[BODIES]).unwrap().unwrap();
    let turn = DMat3::from_rotation_z(0.1 * frame as f64);
    world
        .scene
        .set_compound_pose(compound, Pose::new(turn, DVec3::ZERO).unwrap())
        .unwrap();
}

/// The distances of groups are asked for.
fn measure(world: &mut World, frame: usize) {
    if frame == 0 {
        world.scene.reserve(BODIES, BODIES * BODIES);
        let (x, y) = world.ids.split_at(10);
        let _ = world.scene.measure_groups(x, y, 1e-3).unwrap();
        let _ = world.scene.measure_groups(&y[..5], x, 0.0).unwrap();
    }
    world.fly();
}

/// The other question, and the other boxes, from time to time.
fn ask_otherwise(world: &mut World, frame: usize) {
    world.fly();
    world.scene.set_mode(if frame % 40 < 20 {
        Mode::Any
    } else {
        Mode::All
    });
    world.scene.set_reach(if frame % 60 < 30 {
        Reach::Here
    } else {
        Reach::Swept
    });
}

struct Configuration {
    name: &'static str,
    mode: Mode,
    reach: Reach,
    budgets: &'static [Budget],
    threads: usize,
    play: fn(&mut World, usize),
}

const UNLIMITED: &[Budget] = &[Budget::unlimited()];
const WORK: &[Budget] = &[Budget::work(20_000)];
const LITTLE: &[Budget] = &[Budget::work(602), Budget::work(3_000)];
const TIME: &[Budget] = &[
    Budget::time(Duration::from_micros(5)),
    Budget::time(Duration::from_millis(2)),
];
const MIXED: &[Budget] = &[
    Budget::unlimited(),
    Budget::work(20_000),
    Budget::work(200_000),
    Budget::time(Duration::from_micros(50)),
];

fn configurations() -> [Configuration; 21] {
    let new = |name, mode, reach, budgets, threads, play| Configuration {
        name,
        mode,
        reach,
        budgets,
        threads,
        play,
    };
    let (any, all, here, swept) = (Mode::Any, Mode::All, Reach::Here, Reach::Swept);
    [
        new("any, unlimited", any, here, UNLIMITED, 1, fly),
        new("all, unlimited", all, here, UNLIMITED, 1, fly),
        new("any, work", any, here, WORK, 1, fly),
        new("all, little work", all, here, LITTLE, 1, fly),
        new("any, time", any, here, TIME, 1, fly),
        new("all, mixed budgets", all, here, MIXED, 1, fly),
        new("swept", any, swept, WORK, 1, fly),
        new("rest", any, here, WORK, 1, rest),
        new("breathe", all, here, MIXED, 1, breathe),
        new("come and go", any, here, MIXED, 1, come_and_go),
        new("teleport", any, swept, WORK, 1, teleport),
        new("refilter", any, here, WORK, 1, refilter),
        new("ask otherwise", any, here, MIXED, 1, ask_otherwise),
        new("two threads", any, here, WORK, 2, fly),
        new("a compound", any, here, WORK, 1, turn),
        new("groups", any, here, WORK, 1, measure),
        new("groups, mixed budgets", all, here, MIXED, 1, measure),
        new("groups on two threads", any, here, MIXED, 2, measure),
        new("contacts", any, here, MIXED, 1, touch),
        new("contacts of all", all, here, WORK, 1, touch),
        new("contacts on two threads", any, here, MIXED, 2, touch),
    ]
}

#[test]
fn no_frame_after_the_hundredth_allocates() {
    no_frame_allocates_within_the_room_asked_for();
    let mut faults = Vec::new();
    for Configuration {
        name,
        mode,
        reach,
        budgets,
        threads,
        play,
    } in configurations()
    {
        let mut world = World::new(Scene::new());
        world.scene.set_mode(mode);
        world.scene.set_reach(reach);
        world.scene.track_contacts();
        #[cfg(feature = "parallel")]
        world.scene.use_threads(threads).unwrap();
        let clock = ManualClock::ticking(Duration::from_nanos(700));
        let ray = Ray::new([-2.0 * WALL, 0.1, 0.2], [1.0, 0.05, 0.0]).unwrap();
        let (mut meets, mut undecided) = (0, 0);
        let mut frame = |number: usize| {
            play(&mut world, number);
            let budget = budgets[number % budgets.len()];
            ask_between_frames(
                &mut world.scene,
                &SceneRay::new(ray),
                (budget, &clock),
                true,
            );
            let report = match threads {
                #[cfg(feature = "parallel")]
                2.. => world.scene.detect(budget),
                _ => world.scene.detect(budget.clock(&clock)),
            };
            (meets, undecided) = (meets + report.intersecting, undecided + report.undecided());
        };
        (0..WARM_UP).for_each(&mut frame);
        let mut late = Vec::with_capacity(FRAMES);
        for number in WARM_UP..WARM_UP + FRAMES {
            let calls = allocator_calls_of_all_threads(|| frame(number));
            if calls > 0 {
                late.push((number, calls));
            }
        }
        assert!(
            meets > 0 && (undecided > 0 || budgets == UNLIMITED),
            "{name}: {meets} meet, {undecided} undecided"
        );
        if !late.is_empty() {
            faults.push((name, late));
        }
    }
    assert!(faults.is_empty(), "{faults:?}");
}

/// Every question that may be asked between frames; or only those about rays.
fn ask_between_frames(
    scene: &mut Scene,
    ray: &SceneRay,
    (budget, clock): (Budget, &ManualClock),
    asks_shapes: bool,
) {
    let _ = scene.cast(ray, budget.clock(clock)).unwrap();
    let _ = scene.cast_rays(&[*ray; 20], budget.clock(clock)).unwrap();
    if !asks_shapes {
        return;
    }
    let ball = SceneShape::point([-2.0 * WALL, 0.1, 0.2])
        .unwrap()
        .margin(0.5);
    let ball = ball.along([4.0 * WALL, 0.1, 0.0]).unwrap();
    let _ = scene.cast_shape(&ball, budget.clock(clock)).unwrap();
    let _ = scene
        .closest(&ball, f64::INFINITY, budget.clock(clock))
        .unwrap();
    let all = ball.margin(2.5 * WALL);
    let _ = scene.overlap(&all, Mode::All, budget.clock(clock)).unwrap();
}

fn no_frame_allocates_within_the_room_asked_for() {
    let grown = |bodies, pairs| {
        let mut scene = Scene::new();
        held(|| scene.reserve(bodies, pairs)).1 as f64 / 1e4
    };
    let [body, pair] = [grown(10_000, 0), grown(0, 10_000)];
    assert!(
        (700.0..870.0).contains(&body) && (700.0..985.0).contains(&pair),
        "{body} bytes a body, {pair} a pair"
    );
    let mut world = World::new(Scene::new());
    world.scene.track_contacts();
    // So much room that without being asked for it would be that of the largest scenes.
    world.scene.reserve(BODIES, 10_000);
    let mut most = 0;
    let calls = allocator_calls_of_all_threads(|| {
        for frame in 0..100 {
            breathe(&mut world, frame);
            let report = world
                .scene
                .detect(Budget::work(20_000).clock(&ManualClock::new()));
            most = most.max(report.pairs.len() + report.unlisted);
        }
    });
    assert!(most > 1_000, "{most} pairs at most");
    assert_eq!(calls, 0);
    let asked: [(&str, Ask); 11] = [
        ("whether they meet", |_| ()),
        ("distances", ask_distances),
        ("motions", |_| ()),
        ("contacts", |world| world.scene.find_contacts()),
        ("contacts of a larger mesh", |world| {
            world.scene.find_contacts();
            let larger = Arc::new(Tree::new(shapes::icosphere(5)));
            world.scene.set_tree(world.ids[0], larger).unwrap();
        }),
        ("groups", ask_groups),
        ("whether solids meet", |world| make_solid(world, 0.0)),
        ("contacts of solids", |world| {
            make_solid(world, 0.1);
            world.scene.find_contacts();
            world.scene.set_look_ahead(1.0).unwrap();
        }),
        ("distances of solids", |world| {
            make_solid(world, 0.1);
            ask_distances(world);
            ask_groups(world);
        }),
        ("motions of solids", |world| make_solid(world, 0.1)),
        ("all", |world| {
            world.scene.find_contacts();
            ask_distances(world);
            ask_groups(world);
        }),
    ];
    let mut faults = Vec::new();
    for (question, ask) in asked {
        for threads in [1, 3] {
            for asks_first in [false, true] {
                let late = frames_that_allocate(question, ask, threads, asks_first);
                if !late.is_empty() {
                    faults.push((question, threads, asks_first, late));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults:?}");
}

/// Asks something of all frames.
type Ask = fn(&mut World);

/// Makes all bodies solids with a margin, and the first one so large that it contains others.
fn make_solid(world: &mut World, margin: f64) {
    let solid = BuildOptions::default().solid(Solid::Keep);
    let meshes = [shapes::cuboid([WALL as f32; 3], 2), shapes::icosphere(1)];
    let [room, ball] = meshes.map(|mesh| Arc::new(Tree::with_options(mesh, &solid)));
    for (at, &id) in world.ids.iter().enumerate() {
        let tree = if at == 0 { &room } else { &ball };
        world.scene.set_tree(id, Arc::clone(tree)).unwrap();
        world.scene.set_margin(id, margin).unwrap();
    }
}

fn ask_distances(world: &mut World) {
    for (i, &a) in world.ids[..12].iter().enumerate() {
        world.ids[..i]
            .iter()
            .for_each(|&b| world.scene.measure(a, b, 1e-3).unwrap());
    }
}

fn ask_groups(world: &mut World) {
    let (x, y) = world.ids.split_at(10);
    let _ = world.scene.measure_groups(x, y, 1e-3).unwrap();
    let _ = world.scene.measure_groups(x, x, 1e-3).unwrap();
}

/// Of a scene that was asked for room, from its first frame on: those that allocate, and how often. `asks_first`: what
/// is asked is
/// so before the room is.
fn frames_that_allocate(
    question: &str,
    ask: Ask,
    threads: usize,
    asks_first: bool,
) -> Vec<(usize, u64)> {
    let mut world = World::new(Scene::new());
    world.scene.track_contacts();
    #[cfg(feature = "parallel")]
    world.scene.use_threads(threads).unwrap();
    if asks_first {
        ask(&mut world);
    }
    world.scene.reserve(BODIES, BODIES * (BODIES - 1) / 2);
    if !asks_first {
        ask(&mut world);
    }
    let moves = question.contains("motions") || question == "all";
    let clock = ManualClock::ticking(Duration::from_nanos(700));
    let ray = SceneRay::new(Ray::new([-2.0 * WALL, 0.1, 0.2], [1.0, 0.05, 0.0]).unwrap());
    // The answers of a batch get their room with the first of its size.
    ask_between_frames(&mut world.scene, &ray, (Budget::unlimited(), &clock), false);
    let (mut late, mut passages, mut contained) = (Vec::with_capacity(64), 0, 0);
    for frame in 0..12 {
        breathe(&mut world, frame);
        if moves {
            for body in 0..BODIES {
                let motion = Motion::straight(world.pose(body), 3.0 * world.speeds[body]).unwrap();
                world.scene.set_motion(world.ids[body], motion).unwrap();
            }
        }
        let budget = MIXED[frame % MIXED.len()];
        let calls = allocator_calls_of_all_threads(|| {
            ask_between_frames(&mut world.scene, &ray, (budget, &clock), false);
            match threads {
                #[cfg(feature = "parallel")]
                2.. => _ = world.scene.detect(budget),
                _ => _ = world.scene.detect(budget.clock(&clock)),
            }
            for &id in &world.ids {
                world.scene.may_move(id, 1.0, 0.01).unwrap();
            }
        });
        passages += world.scene.passages().count();
        contained += world.scene.report().contained;
        if calls > 0 {
            late.push((frame, calls));
        }
    }
    assert_eq!(passages > 0, moves);
    assert_eq!(contained > 0, question.contains("solids"), "{question}");
    late
}
