//! Contacts that begin, persist and end, against the truth of each frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::{Model, ball, detect, moving, whole_frame};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Tree, Verdict, shapes};
use punctual_scene::{Body, BodyId, ContactPhase, Filter, Report, Scene};

/// The contacts told so far, with the frames in which they began.
#[derive(Default)]
pub struct Ledger {
    open: BTreeMap<[BodyId; 2], u64>,
    /// How many were told, by phase.
    pub told: [usize; 4],
}

impl Ledger {
    /// Checks what a frame tells. `complete`: it had no budget.
    #[track_caller]
    pub fn check(
        &mut self,
        report: &Report,
        model: &Model,
        truth: &[(usize, usize, u64)],
        complete: bool,
    ) {
        let touch = |[a, b]: [BodyId; 2]| {
            truth
                .iter()
                .any(|&(x, y, _)| (x, y) == (a.index(), b.index()))
        };
        let exists = |id: BodyId| model.bodies.iter().any(|&(other, _)| other == id);
        let order = |contact: &punctual_scene::BodyContact| (contact.a.index(), contact.b.index());
        assert!(report.contacts.is_sorted_by_key(order));
        let mut before = std::mem::take(&mut self.open);
        for contact in &report.contacts {
            let pair = [contact.a, contact.b];
            let there = pair.into_iter().all(exists);
            let since = match contact.phase {
                ContactPhase::Began => {
                    assert!(
                        there && touch(pair) && !before.contains_key(&pair),
                        "{contact:?}"
                    );
                    report.frame
                }
                phase => {
                    let since = before
                        .remove(&pair)
                        .unwrap_or_else(|| panic!("{contact:?} never began"));
                    match phase {
                        ContactPhase::Persists => assert!(there && touch(pair), "{contact:?}"),
                        ContactPhase::Ended => assert!(!there || !touch(pair), "{contact:?}"),
                        _ => assert!(
                            report
                                .pair(pair[0], pair[1])
                                .is_none_or(|pair| pair.age > 0),
                            "{contact:?}"
                        ),
                    }
                    since
                }
            };
            assert_eq!(contact.age, report.frame - since);
            if contact.phase != ContactPhase::Ended {
                self.open.insert(pair, since);
            }
            self.told[contact.phase as usize] += 1;
        }
        assert!(before.is_empty(), "forgotten: {before:?}");
        let is_open = |pair: &punctual_scene::PairReport| self.open.contains_key(&[pair.a, pair.b]);
        assert!(report.intersecting_pairs().all(is_open));
        assert!(!complete || self.open.len() == truth.len());
    }
}

fn at(x: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::X * x).unwrap()
}

/// A ring and a ball that have been told to touch.
fn touching() -> (Scene, [BodyId; 2]) {
    let mut scene = Scene::new();
    let bodies = [
        (shapes::torus(2.0, 0.3, 32), 0.0),
        (shapes::icosphere(2), 1.5),
    ];
    let pair = bodies.map(|(mesh, x)| {
        scene
            .insert(Body::moving(Arc::new(Tree::new(mesh)), at(x)))
            .unwrap()
    });
    scene.track_contacts();
    let began = whole_frame(&mut scene).contacts[0];
    assert_eq!(
        ([began.a, began.b], began.phase, began.age),
        (pair, ContactPhase::Began, 0)
    );
    (scene, pair)
}

#[track_caller]
fn assert_phase(scene: &mut Scene, budget: Budget, expected: &[(ContactPhase, u64)]) {
    let told: Vec<_> = detect(scene, budget)
        .contacts
        .iter()
        .map(|contact| (contact.phase, contact.age))
        .collect();
    assert_eq!(told, expected);
}

#[test]
fn an_undecided_pair_keeps_its_contact_until_the_end_is_proven() {
    let (mut scene, [_, b]) = touching();
    assert_phase(&mut scene, Budget::work(0), &[(ContactPhase::Persists, 1)]);
    // In the middle of the ring, where the boxes overlap and the surfaces are apart. But there is no budget to see that.
    scene.set_pose(b, at(0.0)).unwrap();
    assert_phase(&mut scene, Budget::work(0), &[(ContactPhase::Undecided, 2)]);
    assert_eq!(scene.report().pairs[0].verdict, Verdict::Undecided);
    assert_phase(&mut scene, Budget::unlimited(), &[(ContactPhase::Ended, 3)]);
    assert_phase(&mut scene, Budget::unlimited(), &[]);
}

#[test]
fn contacts_end_with_their_bodies_and_filters() {
    let (mut scene, [a, b]) = touching();
    let body = scene.remove(b).unwrap();
    // Another body in the same slot: a contact of its own.
    let other = scene.insert(body).unwrap();
    assert_eq!(other.index(), b.index());
    assert_phase(
        &mut scene,
        Budget::unlimited(),
        &[(ContactPhase::Ended, 1), (ContactPhase::Began, 0)],
    );
    assert_eq!(
        scene
            .report()
            .contacts
            .iter()
            .map(|contact| contact.b)
            .collect::<Vec<_>>(),
        [b, other]
    );
    scene.set_filter(a, Filter::new(1, 0)).unwrap();
    assert_phase(&mut scene, Budget::work(0), &[(ContactPhase::Ended, 1)]);
}

#[test]
fn nothing_is_told_that_was_not_asked_for() {
    let ball = ball(2);
    let mut scene = Scene::new();
    for x in [0.0, 0.4] {
        moving(&mut scene, &ball, at(x));
    }
    let report = scene.detect(Budget::unlimited().clock(&ManualClock::new()));
    assert_eq!((report.intersecting, report.contacts.len()), (1, 0));
}
