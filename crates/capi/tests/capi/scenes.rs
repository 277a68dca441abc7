//! Scenes: bodies, frames, reports and certificates.

use std::mem::MaybeUninit;
use std::sync::Arc;

use super::call::*;
use super::queries::told;
use super::scene_answers::all;
use super::surfaces::vertex_of;
use ::punctual_scene::{Body, BodyId, Filter, PairReport, Reach, Scene};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::Calibration;
use punctual::{Budget, Mode, Pose, Tree, shapes};
use punctual_capi::{punctual_status as Status, *};

/// A scene in C and the same in Rust, of twelve knots; two are fixed.
struct Both {
    scene: Box<punctual_scene>,
    native: Scene,
    ids: Vec<(punctual_body_id, BodyId)>,
    ours: Box<punctual_tree>,
    theirs: Arc<Tree>,
}

fn place(i: u32, frame: u32) -> Pose {
    let turn = DMat3::from_rotation_z(f64::from(i + frame) * 0.3);
    Pose::new(
        turn,
        DVec3::new(
            0.9 * f64::from(i % 4),
            f64::from(i / 4) + 0.02 * f64::from(frame),
            0.0,
        ),
    )
    .unwrap()
}

impl Both {
    fn new() -> Self {
        let (ours, theirs) = (
            tree_of(&knot()),
            Arc::new(Tree::new(shapes::torus_knot(2, 3, 0.2, 96))),
        );
        let mut scene = owned(|scene| {
            punctual_scene_new(
                punctual_mode::All as u32,
                punctual_reach::Swept as u32,
                scene,
            )
        });
        let mut native = Scene::new();
        native.set_mode(Mode::All);
        native.set_reach(Reach::Swept);
        assert_eq!(punctual_scene_use_threads(Some(&mut scene), 2), Status::Ok);
        assert_eq!(punctual_scene_reserve(Some(&mut scene), 12, 30), Status::Ok);
        native.reserve(12, 30);
        let mut ids = Vec::new();
        for i in 0..12 {
            let mut body = punctual_body_new(Some(&ours), raw(&place(i, 0)));
            (body.kind, body.importance) = (u32::from(i < 2), i as f32);
            let id = made(|id| unsafe {
                punctual_scene_insert(Some(&mut scene), asked(Some(&body)), id)
            });
            let body = if i < 2 { Body::fixed } else { Body::moving };
            ids.push((
                id,
                native
                    .insert(body(Arc::clone(&theirs), place(i, 0)).importance(i as f32))
                    .unwrap(),
            ));
            assert_eq!(id.index as usize, ids[ids.len() - 1].1.index());
        }
        Self {
            scene,
            native,
            ids,
            ours,
            theirs,
        }
    }

    fn move_on(&mut self, frame: u32) {
        for (i, &(id, native_id)) in (0..).zip(&self.ids).skip(2) {
            let pose = place(i, frame);
            works(punctual_scene_set_pose(
                Some(&mut self.scene),
                id,
                raw(&pose),
            ));
            self.native.set_pose(native_id, pose).unwrap();
        }
    }

    /// The vertices of a knot as it was built.
    fn vertices(&self) -> impl Iterator<Item = DVec3> {
        (0..self.theirs.mesh().vertex_count()).map(|i| self.theirs.mesh().vertex(i))
    }

    fn refit_f32(&mut self) {
        let (id, native_id) = self.ids[3];
        let narrow: Vec<[f32; 3]> = self
            .vertices()
            .map(|vertex| (vertex.as_vec3() * 1.25).to_array())
            .collect();
        // SAFETY: as long as said.
        let status = unsafe {
            punctual_scene_refit_f32(
                Some(&mut self.scene),
                id,
                narrow.as_ptr().cast(),
                narrow.len(),
            )
        };
        assert_eq!(status, Status::Ok);
        self.native
            .tree_mut(native_id)
            .unwrap()
            .refit(&narrow)
            .unwrap();
    }

    fn refit_f64(&mut self) {
        let (id, native_id) = self.ids[3];
        let wide: Vec<[f64; 3]> = self
            .vertices()
            .map(|vertex| (vertex / 3.0).to_array())
            .collect();
        // SAFETY: as long as said.
        let status = unsafe {
            punctual_scene_refit_f64(Some(&mut self.scene), id, wide.as_ptr().cast(), wide.len())
        };
        assert_eq!(status, Status::Ok);
        self.native
            .tree_mut(native_id)
            .unwrap()
            .refit_f64(&wide)
            .unwrap();
        let shared = owned(|tree| punctual_scene_tree(Some(&self.scene), id, tree));
        assert_eq!(
            vertex_of(&shared, 5),
            self.native.body(native_id).unwrap().tree.mesh().vertex(5)
        );
    }

    fn set(&mut self, frame: u32) {
        let ((third, native_third), (fourth, native_fourth)) = (self.ids[3], self.ids[4]);
        works(punctual_scene_set_tree(
            Some(&mut self.scene),
            third,
            Some(&self.ours),
        ));
        self.native
            .set_tree(native_third, Arc::clone(&self.theirs))
            .unwrap();
        works(punctual_scene_set_filter(
            Some(&mut self.scene),
            fourth,
            2,
            6,
        ));
        self.native
            .set_filter(native_fourth, Filter::new(2, 6))
            .unwrap();
        works(punctual_scene_set_importance(
            Some(&mut self.scene),
            fourth,
            9.0,
        ));
        self.native.set_importance(native_fourth, 9.0).unwrap();
        let body =
            made(|body| unsafe { punctual_scene_body(Some(&self.scene), fourth, slot(body)) });
        assert_eq!(
            (body.groups, body.mask, body.importance, body.kind),
            (2, 6, 9.0, 0)
        );
        assert!(body.tree.is_none() && body.pose == raw(&place(4, frame)));
    }

    fn remove(&mut self) {
        let (id, native_id) = self.ids.remove(5);
        assert_eq!(punctual_scene_remove(Some(&mut self.scene), id), Status::Ok);
        self.native.remove(native_id).unwrap();
    }

    /// A frame; the number of pairs that it leaves undecided.
    fn detect(&mut self, budget: punctual_budget, native_budget: Budget) -> usize {
        let report = made(|report| detect(Some(&mut self.scene), budget, report));
        let expected = self.native.detect(native_budget.clock(&ManualClock::new()));
        assert_eq!(
            (report.frame, report.decided, report.intersecting),
            (expected.frame, expected.decided, expected.intersecting)
        );
        assert_eq!(
            (report.complete, report.worst_age),
            (expected.complete, expected.worst_age)
        );
        assert_eq!(
            (report.work, report.bv_tests, report.elapsed),
            (expected.work, expected.bv_tests, -1)
        );
        let missed = (
            report.unplaced,
            report.unpaired,
            report.unlisted,
            report.is_full,
        );
        assert_eq!(
            missed,
            (
                expected.unplaced,
                expected.unpaired,
                expected.unlisted,
                expected.is_full
            )
        );
        let undecided = expected.undecided();
        assert_eq!(report.broad_phase_work, expected.broad_phase_work);
        let scene = Some(&*self.scene);
        let size = size_of::<punctual_pair_report>();
        // SAFETY: there is room for as many as said.
        let pairs = all(|array, room, count| unsafe {
            punctual_scene_pairs(scene, array, size, room, count)
        });
        assert_eq!(
            (pairs.len(), report.pair_count),
            (expected.pairs.len(), pairs.len())
        );
        for (pair, expected) in pairs.iter().zip(&self.native.report().pairs) {
            self.same(pair, expected);
        }
        // SAFETY: of the size that it says.
        let again = made(|report| unsafe { punctual_scene_report(scene, slot(report)) });
        assert_eq!((again.frame, again.work), (report.frame, report.work));
        for &(id, native_id) in &self.ids {
            let known = made(|known| punctual_scene_partners_known(scene, id, known));
            assert_eq!(known, self.native.partners_known(native_id).unwrap());
        }
        undecided
    }

    fn same(&self, pair: &punctual_pair_report, expected: &PairReport) {
        assert_eq!(
            [pair.a.index as usize, pair.b.index as usize],
            [expected.a.index(), expected.b.index()]
        );
        let numbers = |found, complete, probability: f64, recall: f64, age| {
            (
                found,
                complete,
                probability.to_bits(),
                recall.to_bits(),
                age,
            )
        };
        assert_eq!(
            numbers(
                pair.found,
                pair.complete,
                pair.probability,
                pair.recall,
                pair.age
            ),
            numbers(
                expected.found,
                expected.complete,
                expected.probability,
                expected.recall,
                expected.age
            )
        );
        assert_eq!(
            (pair.verdict, [pair.witness.a, pair.witness.b]),
            told(expected.verdict)
        );
        let mut listed = MaybeUninit::uninit();
        let again = made(|again| unsafe {
            punctual_scene_pair(
                Some(&self.scene),
                pair.b,
                pair.a,
                row(again),
                size_of::<punctual_pair_report>(),
                Some(&mut listed),
            )
        });
        // SAFETY: written by the call.
        assert!(again == *pair && unsafe { listed.assume_init() });
        let open = made(|open| unsafe {
            punctual_scene_certificate(Some(&self.scene), pair.a, pair.b, slot(open))
        });
        let certificate = self.native.certificate(expected.a, expected.b).unwrap();
        assert_eq!(
            (open.upper_bound, open.largest_extent),
            (certificate.upper_bound, certificate.largest_extent)
        );
    }
}

/// Bodies that move, are refitted, filtered and removed: every report, pair and certificate is that of Rust.
#[test]
fn scenes_answer_as_in_rust() {
    let mut both = Both::new();
    let mut undecided = 0;
    for frame in 0..24 {
        both.move_on(frame);
        match frame {
            4 => both.refit_f32(),
            8 => both.refit_f64(),
            12 => both.set(frame),
            16 => both.remove(),
            _ => {}
        }
        let work = [u64::MAX, 30_000, 300_000][frame as usize % 3];
        undecided += both.detect(punctual_budget_work(work), Budget::work(work));
    }
    assert!(undecided > 0, "no budget was too small");

    let Both { scene, ids, .. } = both;
    let mut listed = vec![NOBODY; 11];
    // SAFETY: there is room for eleven.
    let count = made(|count| unsafe {
        punctual_scene_bodies(Some(&scene), listed.as_mut_ptr(), 11, count)
    });
    assert_eq!(count, 11);
    assert!(listed.iter().eq(ids.iter().map(|(id, _)| id)));
    let (mut pair, mut is_listed) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    let status = unsafe {
        punctual_scene_pair(
            Some(&scene),
            ids[0].0,
            ids[1].0,
            row(Some(&mut pair)),
            size_of::<punctual_pair_report>(),
            Some(&mut is_listed),
        )
    };
    // SAFETY: written by the call.
    assert!(
        status == Status::Ok && !unsafe { is_listed.assume_init() },
        "two fixed bodies are no pair"
    );
    punctual_scene_free(Some(scene));
}

/// What a scene is asked changes from one frame to the next; what it has learned goes on in another.
#[test]
fn settings_and_calibrations_are_those_of_rust() {
    let mut both = Both::new();
    assert!(both.detect(punctual_budget_work(30_000), Budget::work(30_000)) > 0);
    works(punctual_scene_set_mode(
        Some(&mut both.scene),
        punctual_mode::Any as u32,
    ));
    works(punctual_scene_set_reach(
        Some(&mut both.scene),
        punctual_reach::Here as u32,
    ));
    works(punctual_scene_set_max_pairs(Some(&mut both.scene), 5));
    both.native.set_mode(Mode::Any);
    both.native.set_reach(Reach::Here);
    both.native.set_max_pairs(5);
    let mut learned = Calibration::default();
    let mut calibration = punctual_calibration_default();
    assert_eq!(calibration, learned.into());
    for moment in 0..40 {
        let told = 0.1 + 0.02 * f64::from(moment);
        learned.learn(told, moment % 3 == 0);
        // SAFETY: here and below, of the size that it says.
        let status = unsafe {
            punctual_calibration_learn(&raw mut calibration, told, u32::from(moment % 3 == 0))
        };
        assert_eq!(status, Status::Ok);
    }
    assert_eq!(calibration, learned.into());
    let corrected =
        made(|out| unsafe { punctual_calibration_apply(&raw const calibration, 0.4, out) });
    assert_eq!(corrected, learned.apply(0.4));
    let status =
        unsafe { punctual_scene_set_calibration(Some(&mut both.scene), &raw const calibration) };
    assert_eq!(status, Status::Ok);
    both.native.set_calibration(learned);
    for frame in 0..12 {
        both.move_on(frame);
        both.detect(punctual_budget_work(30_000), Budget::work(30_000));
        let kept = made(|out| unsafe { punctual_scene_calibration(Some(&both.scene), slot(out)) });
        assert_eq!(kept, both.native.calibration().into());
    }
    let wrong = punctual_calibration {
        slope: 9.0,
        ..calibration
    };
    let text = "punctual_scene_set_calibration: calibration has numbers that cannot be learned";
    refuses! {
        punctual_scene_set_calibration(Some(&mut both.scene), &raw const wrong) => BadArgument text;
        punctual_scene_set_mode(None, 0) => null "scene";
        punctual_scene_set_reach(None, 0) => null "scene";
        punctual_scene_set_max_pairs(None, 0) => null "scene";
        punctual_scene_partners_known(Some(&both.scene), NOBODY, None) => null "known";
        punctual_scene_calibration(Some(&both.scene), slot(None)) => null "calibration";
        punctual_calibration_learn(slot(None), 0.5, 1) => null "calibration";
        punctual_calibration_apply(asked(None), 0.5, None) => null "corrected";
    }
}
