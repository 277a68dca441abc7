//! The curve of degradation: what short budgets of work leave of a frame, beside a plain loop that
//! remembers nothing.

use std::f64::consts::TAU;
use std::sync::Arc;

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};
use punctual_scene::{Body, BodyId, Scene};

use crate::common::check;
use crate::detect;

const BODIES: usize = 150;
/// Frames before the shares are counted, and all frames.
const START: usize = 15;
const FRAMES: usize = 60;

/// Bodies of five shapes that drift and turn within a ball, 60 frames a second.
struct Crowd {
    scene: Scene,
    ids: Vec<BodyId>,
}

fn pose(body: usize, frame: usize) -> Pose {
    let (time, body) = (frame as f64 / 60.0, body as f64);
    let radius = 7.0 * (0.618 * body).fract().cbrt();
    let angle = 2.4 * body + 0.5 * time;
    let height = radius * (1.3 * body + 0.4 * time).sin();
    let around = (radius * radius - height * height).max(0.0).sqrt();
    let turn =
        DMat3::from_rotation_z(body + time) * DMat3::from_rotation_x(TAU * body + 0.7 * time);
    Pose::new(
        turn,
        DVec3::new(around * angle.cos(), around * angle.sin(), height),
    )
    .unwrap()
}

impl Crowd {
    fn new() -> Self {
        let meshes = [
            shapes::torus_knot(2, 3, 0.2, 48),
            shapes::gear(11, 3),
            shapes::icosphere(3),
            shapes::torus(0.9, 0.25, 24),
            shapes::height_field(12, 7),
        ];
        let trees = meshes.map(|mesh| Arc::new(Tree::new(mesh)));
        let mut scene = Scene::new();
        let body = |body| Body::moving(Arc::clone(&trees[body % trees.len()]), pose(body, 0));
        let ids = (0..BODIES).map(|number| scene.insert(body(number)).unwrap());
        let ids = ids.collect();
        Self { scene, ids }
    }

    fn go(&mut self, frame: usize) {
        let poses = self.ids.iter().enumerate();
        let poses = poses.map(|(body, &id)| (id, pose(body, frame)));
        self.scene.set_poses(poses).unwrap();
    }
}

/// Counts over the frames after the start.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    found: usize,
    decided: usize,
    work: u64,
}

/// The boxes sorted along x, then a query after another of the pairs whose boxes overlap, until the
/// work is done.
fn plain_loop(scene: &Scene, workspace: &mut Workspace, limit: u64, counts: &mut Counts) {
    let bodies = scene.bodies().map(|(_, body)| body);
    let mut bodies: Vec<_> = bodies
        .map(|body| (body.tree.aabb_at(&body.pose), body))
        .collect();
    bodies.sort_by(|(x, _), (y, _)| x.min.x.total_cmp(&y.min.x));
    let mut left = limit;
    for (index, (bounds, a)) in bodies.iter().enumerate() {
        let near = bodies[index + 1..]
            .iter()
            .take_while(|(other, _)| other.min.x <= bounds.max.x);
        for (_, b) in near.filter(|(other, _)| other.intersects(bounds)) {
            let b_in_a = a.pose.inverse().unwrap().compose(&b.pose).unwrap();
            let query = Query::intersection(&a.tree, &b.tree, b_in_a);
            let answer = check::run(&query, workspace, Budget::work(left));
            let work = answer.stats.work;
            left = left.saturating_sub(work);
            counts.work += work;
            counts.found += usize::from(answer.value.meets());
            counts.decided += usize::from(answer.value != Verdict::Undecided);
        }
    }
}

/// What the scene and the plain loop find within `limit` in each frame.
fn play(limit: u64) -> [Counts; 2] {
    let (mut crowd, mut workspace) = (Crowd::new(), Workspace::new());
    let mut counts = [Counts::default(); 2];
    for frame in 0..FRAMES {
        crowd.go(frame);
        let report = detect(&mut crowd.scene, Budget::work(limit));
        if frame >= START {
            counts[0].found += report.intersecting;
            counts[0].decided += report.decided;
            counts[0].work += report.work;
            plain_loop(&crowd.scene, &mut workspace, limit, &mut counts[1]);
        }
    }
    counts
}

/// Budgets in percent of the plain loop's work for a whole frame, and the least shares of the
/// contacts that are found and of the pairs that are decided.
const FLOORS: [(u64, [f64; 2]); 5] = [
    (5, [0.19, 0.082]),
    (10, [0.37, 0.16]),
    (20, [0.66, 0.3]),
    (40, [0.93, 0.51]),
    (80, [0.995, 0.97]),
];

#[test]
fn a_frame_degrades_slowly_and_finds_and_decides_more_than_a_plain_loop() {
    let whole = play(u64::MAX);
    assert_eq!(whole.map(|counts| counts.found), [whole[0].found; 2]);
    assert_eq!(whole.map(|counts| counts.decided), [whole[0].decided; 2]);
    let work = whole[1].work / (FRAMES - START) as u64;
    let mut before = [0.0; 2];
    for (percent, floors) in FLOORS {
        let [scene, plain] = play(work * percent / 100).map(|Counts { found, decided, .. }| {
            [
                found as f64 / whole[0].found as f64,
                decided as f64 / whole[0].decided as f64,
            ]
        });
        for (what, name) in ["contacts found", "pairs decided"].into_iter().enumerate() {
            let told = format!(
                "{name} at {percent} %: {:.3} (plain loop {:.3})",
                scene[what], plain[what]
            );
            assert!(scene[what] >= floors[what], "{told} {}", floors[what]);
            assert!(
                scene[what] > plain[what] && scene[what] > before[what],
                "{told}"
            );
        }
        before = scene;
    }
}
