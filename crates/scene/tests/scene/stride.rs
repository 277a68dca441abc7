//! How far bodies may move: whatever the budget, none sinks into another unseen.

use super::*;
use crate::{ball, whole_frame};

const SINK: f64 = 0.03;
const STRIDE: f64 = 0.4;
const HALF: [f64; 3] = [0.5, 0.4, 0.6];

fn at(place: DVec3) -> Pose {
    Pose::new(DMat3::IDENTITY, place).unwrap()
}

/// Boxes that fly towards the origin, where a fixed one stands, and cross each other's ways.
struct Crowd {
    scene: Scene,
    ids: Vec<BodyId>,
    places: Vec<DVec3>,
    random: Random,
}

impl Crowd {
    fn new() -> Self {
        let tree = Arc::new(Tree::new(shapes::cuboid(HALF.map(|x| x as f32), 2)));
        let mut crowd = Self {
            scene: Scene::new(),
            ids: Vec::new(),
            places: Vec::new(),
            random: Random::new(3),
        };
        crowd.scene.find_contacts();
        for i in 0..28 {
            let cell = [i % 3, i / 3 % 3, i / 9].map(|k| f64::from(k) - 1.0);
            let place = if i == 27 {
                DVec3::ZERO
            } else {
                1.5 * DVec3::from(cell)
            };
            let place = if i == 13 { DVec3::Z * 9.0 } else { place };
            let body = match i {
                27 => Body::fixed(Arc::clone(&tree), at(place)),
                _ => Body::moving(Arc::clone(&tree), at(place)).margin(0.01),
            };
            crowd.ids.push(crowd.scene.insert(body).unwrap());
            crowd.places.push(place);
        }
        crowd
    }

    /// A displacement of a body that no known contact point forbids.
    fn wish(&mut self, body: usize) -> DVec3 {
        let home = -self.places[body].normalize_or_zero();
        let mut wish = STRIDE * (home + self.random.vector()).normalize_or_zero();
        for _ in 0..40 {
            for other in (0..self.ids.len()).filter(|&other| other != body) {
                let [a, b] = [body.min(other), body.max(other)];
                let poses = [a, b].map(|i| at(self.places[i]));
                let found = self.scene.contacts(self.ids[a], self.ids[b]).unwrap();
                for point in found.points {
                    let now = point.at([&poses[0], &poses[1]]);
                    let away = if body == a { now.normal } else { -now.normal };
                    let too_close = -wish.dot(away) - 0.5 * now.distance.max(0.0);
                    wish += too_close.max(0.0) * away;
                }
            }
        }
        wish
    }

    /// Moves all bodies once. `asks`: no farther than they may.
    fn advance(&mut self, asks: bool) {
        // The last body is fixed.
        let moves = (0..self.ids.len() - 1).map(|body| {
            let wish = self.wish(body);
            let length = wish.length();
            let may = self.scene.may_move(self.ids[body], length, SINK).unwrap();
            assert!((0.0..=length).contains(&may));
            match asks && length > 0.0 {
                true => wish * (may / length),
                false => wish,
            }
        });
        let moves = Vec::from_iter(moves);
        for (body, moved) in moves.into_iter().enumerate() {
            self.places[body] += moved;
            self.scene
                .set_pose(self.ids[body], at(self.places[body]))
                .unwrap();
        }
    }

    /// How deep any two boxes are in each other.
    fn deepest(&self) -> f64 {
        let pairs = (0..self.places.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
        let depth = |[a, b]: [usize; 2]| {
            let apart = (self.places[a] - self.places[b]).abs();
            (2.0 * DVec3::from(HALF) - apart).min_element()
        };
        pairs.map(depth).fold(f64::NEG_INFINITY, f64::max)
    }
}

#[test]
fn bodies_that_move_as_far_as_they_may_sink_in_no_deeper_whatever_the_budget() {
    let budgets = [
        Budget::work(0),
        Budget::work(1_000),
        Budget::work(8_000),
        Budget::work(60_000),
        Budget::time(Duration::from_nanos(1)),
        Budget::time(Duration::from_micros(30)),
        Budget::unlimited(),
    ];
    let play = |budget: Budget, asks: bool| {
        let mut crowd = Crowd::new();
        let (mut deepest, mut way) = (f64::NEG_INFINITY, 0.0);
        for frame in 0..60 {
            crowd.scene.detect(budget);
            // Now and then a second step without a look.
            for _ in 0..=usize::from(frame % 5 == 0) {
                let before = crowd.places.clone();
                crowd.advance(asks);
                let moved = crowd.places.iter().zip(before);
                way += moved.map(|(now, then)| now.distance(then)).sum::<f64>();
                deepest = deepest.max(crowd.deepest());
            }
        }
        (deepest, way)
    };
    for budget in budgets {
        let (deepest, way) = play(budget, true);
        eprintln!("{budget:?}: {deepest} {way}");
        assert!(deepest <= SINK * (1.0 + 1e-9), "{budget:?}: {deepest}");
        if budget == Budget::unlimited() {
            assert!(way > 40.0 && deepest > -0.02, "{way} {deepest}");
        }
    }
    assert!(play(Budget::work(8_000), false).0 > 3.0 * SINK);
}

#[test]
fn only_bodies_whose_contacts_are_requested_hold_a_body_back() {
    let ball = ball(2);
    let ball = |x: f64| Body::moving(Arc::clone(&ball), at(DVec3::X * x)).margin(0.01);
    let may = |scene: &mut Scene, id| scene.may_move(id, 1.0, 0.0).unwrap();
    let mut scene = Scene::new();
    let [a, b] = [0.0, 1.5].map(|x| scene.insert(ball(x)).unwrap());
    assert_eq!(may(&mut scene, a), 1.0, "no contacts are requested");
    scene.find_contacts();
    assert_eq!(may(&mut scene, a), 0.0, "nothing is known");
    whole_frame(&mut scene);
    // All contacts have points: free up to the skin of both, and each body has half of it.
    assert!(!scene.contacts(a, b).unwrap().points.is_empty());
    assert!((may(&mut scene, a) - 0.01).abs() < 1e-9);
    // The one that moves uses up what both had, to the last; then it may sink in.
    scene.set_pose(b, at(DVec3::X * 1.49)).unwrap();
    assert!((may(&mut scene, a) - 0.005).abs() < 1e-9);
    scene.set_pose(b, at(DVec3::X * 1.47)).unwrap();
    assert_eq!(may(&mut scene, a), 0.0);
    assert!((scene.may_move(a, 1.0, 0.03).unwrap() - 0.01).abs() < 1e-9);
    // A gap of boxes is enough.
    let far = scene.insert(ball(5.0)).unwrap();
    let free = may(&mut scene, far);
    assert!((0.7..0.77).contains(&free), "half of 5 - 1.47 - 2: {free}");
    // Sensors, and what may not meet, do not count.
    let sensor = scene.insert(ball(5.1).sensor()).unwrap();
    assert_eq!(may(&mut scene, far), free);
    assert_eq!(may(&mut scene, sensor), 1.0);
    scene.ignore(a, b, true).unwrap();
    assert_eq!(may(&mut scene, a), 1.0);
    for wrong in [-1.0, f64::NAN] {
        assert_eq!(scene.may_move(far, wrong, 0.0).unwrap(), 0.0);
    }
    assert_eq!(scene.may_move(far, 1.0, f64::NAN).unwrap(), 0.0);
    // A negative one is a distance to keep.
    let keeps = scene.may_move(far, 1.0, -1.0).unwrap();
    assert!((free - keeps - 0.5).abs() < 1e-9);
    scene.remove(far).unwrap();
    let refused = scene.may_move(far, 1.0, 0.0);
    assert_eq!(refused, Err(SceneError::NoSuchBody { body: far }));
}
