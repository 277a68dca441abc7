//! How long pairs wait under budgets of time that do not suffice for all of them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use crate::common::random::Random;
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Clock, Pose, Tree, shapes};
use punctual_scene::{Body, BodyId, Scene};

/// A clock that goes on with each look at it, as if the work in between took that long.
struct Ticking(ManualClock);

impl Clock for Ticking {
    fn now(&self) -> Duration {
        self.0.advance(Duration::from_nanos(500));
        self.0.now()
    }
}

const KNOTS: usize = 150;
const FRAMES: usize = 240;

/// Knots that fly through a box, the same whoever asks.
struct Swarm {
    scene: Scene,
    ids: Vec<BodyId>,
    knots: Vec<[DVec3; 3]>,
    margin: f64,
}

impl Swarm {
    fn new(margin: f64) -> Self {
        let tree = Arc::new(Tree::new(shapes::torus_knot(2, 3, 0.2, 48)));
        let (mut scene, mut random) = (Scene::new(), Random::new(7));
        let knots = Vec::from_iter((0..KNOTS).map(|_| {
            let place = 7.0 * random.vector();
            [place, 0.02 * random.vector(), 0.05 * random.vector()]
        }));
        let ids = Vec::from_iter(knots.iter().map(|&[place, ..]| {
            let pose = Pose::new(DMat3::IDENTITY, place).unwrap();
            let body = Body::moving(Arc::clone(&tree), pose).margin(margin);
            scene.insert(body).unwrap()
        }));
        Self {
            scene,
            ids,
            knots,
            margin,
        }
    }

    /// Two more that rest and touch, of importance 1.
    fn with_important(mut self) -> (Self, [BodyId; 2]) {
        let tree = Arc::clone(&self.scene.body(self.ids[0]).unwrap().tree);
        let ids = [100.0, 100.3].map(|x| {
            let pose = Pose::new(DMat3::IDENTITY, DVec3::new(x, 0.0, 0.0)).unwrap();
            let body = Body::moving(Arc::clone(&tree), pose).margin(self.margin);
            self.scene.insert(body.importance(1.0)).unwrap()
        });
        (self, ids)
    }

    fn fly(&mut self, frame: usize) {
        for (&id, [place, speed, turn]) in self.ids.iter().zip(&mut self.knots) {
            *place += *speed;
            for axis in 0..3 {
                if place[axis].abs() > 7.0 {
                    speed[axis] = -speed[axis];
                }
            }
            let angles = *turn * frame as f64;
            let turn = DMat3::from_rotation_x(angles.x) * DMat3::from_rotation_y(angles.y);
            let pose = Pose::new(turn, *place).unwrap();
            self.scene.set_pose(id, pose).unwrap();
        }
    }
}

/// The most frames in a row in which a pair of overlapping boxes was not decided, and the shares of
/// the pairs that were decided and of those that meet that were found.
struct Waits {
    worst: BTreeMap<[BodyId; 2], usize>,
    decided: f64,
    found: f64,
}

impl Waits {
    /// Plays `budgeted` within a budget beside a scene without one, whose answers are the truth.
    fn of(mut budgeted: Swarm, mut whole: Swarm, budget: Duration) -> Self {
        let clock = Ticking(ManualClock::new());
        let (mut waits, mut worst) = (BTreeMap::new(), BTreeMap::new());
        let ([mut all, mut decided], [mut meeting, mut found]) = ([0; 2], [0; 2]);
        for frame in 0..FRAMES {
            budgeted.fly(frame);
            whole.fly(frame);
            let truth = whole.scene.detect(Budget::unlimited());
            let report = budgeted.scene.detect(Budget::time(budget).clock(&clock));
            for pair in &report.pairs {
                // Of a body that is not placed yet, the box may be an earlier one.
                let is_near = truth.pair(pair.a, pair.b).is_some();
                let is_known = report.unplaced == 0 || pair.verdict.meets();
                assert!(is_near || !is_known, "frame {frame}: {pair:?}");
            }
            let mut now = BTreeMap::new();
            for pair in &truth.pairs {
                let ids = [pair.a, pair.b];
                let said = report.pair(pair.a, pair.b).map(|said| said.verdict);
                let said = said.filter(|verdict| verdict.name() != "undecided");
                if let Some(said) = said {
                    assert_eq!(said.meets(), pair.verdict.meets(), "frame {frame}: {ids:?}");
                }
                let wait = match said {
                    Some(_) => 0,
                    None => waits.get(&ids).map_or(1, |wait| wait + 1),
                };
                now.insert(ids, wait);
                let most = worst.entry(ids).or_insert(0);
                *most = wait.max(*most);
                all += 1;
                decided += usize::from(said.is_some());
                meeting += usize::from(pair.verdict.meets());
                found += usize::from(said.is_some_and(|verdict| verdict.meets()));
            }
            waits = now;
        }
        Self {
            worst,
            decided: f64::from(decided as u32) / f64::from(all as u32),
            found: f64::from(found as u32) / f64::from(meeting as u32),
        }
    }

    fn longest(&self) -> usize {
        self.worst.values().copied().max().unwrap()
    }
}

fn play(margin: f64, microseconds: u64) -> (Waits, [BodyId; 2]) {
    let [(budgeted, important), (whole, _)] = [(); 2].map(|()| Swarm::new(margin).with_important());
    let budget = Duration::from_micros(microseconds);
    (Waits::of(budgeted, whole, budget), important)
}

#[test]
fn every_pair_has_its_turn_in_frames_that_decide_half_of_the_pairs() {
    for (margin, microseconds) in [(0.0, 45), (0.1, 75)] {
        let (waits, _) = play(margin, microseconds);
        assert!((0.4..0.8).contains(&waits.decided), "{}", waits.decided);
        // They find what meets first.
        assert!(waits.found > waits.decided + 0.2, "{}", waits.found);
        let longest = waits.longest();
        assert!(longest < FRAMES * 2 / 3, "{longest}");
    }
}

#[test]
fn important_bodies_at_rest_do_not_wait_for_others_that_move() {
    for (margin, microseconds) in [(0.0, 10), (0.0, 25), (0.0, 40), (0.1, 25), (0.1, 50)] {
        let (waits, important) = play(margin, microseconds);
        assert!(waits.decided < 0.8, "{}", waits.decided);
        let wait = waits.worst[&important];
        assert!(wait <= 2, "{margin} {microseconds}: {wait}");
    }
}
