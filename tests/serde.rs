//! What can be written and read with serde comes back the same to the bit; what cannot be is refused by name; and a memory
//! of other trees, or one that somebody made up, does no harm.
#![cfg(feature = "serde")]

mod common;

use std::fmt::Debug;
use std::sync::Arc;
use std::time::Duration;

use common::check::{ENOUGH, run, run_with_memory};
use common::random::{Drift, Random, pose_about};
use common::{MODES, ORDERS};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::{Calibration, CostModel, Counts};
use punctual::tree::{Effort, TreeStats};
use punctual::{
    Budget, BuildOptions, Mode, Motion, PairMemory, Pose, Query, Tree, Verdict, Workspace, shapes,
};
use punctual_scene::{Body, BodyId, Filter, Reach, Scene};
use serde_json::{Value, from_str, json, to_string, to_value};

/// Written and read again, from text.
#[track_caller]
fn again<T: serde::Serialize + serde::de::DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = to_string(value).unwrap();
    assert_eq!(&from_str::<T>(&text).unwrap(), value, "{text}");
}

#[track_caller]
fn error<T: serde::de::DeserializeOwned + Debug>(value: &Value) -> String {
    from_str::<T>(&value.to_string()).unwrap_err().to_string()
}

#[test]
fn options_and_budgets() {
    for options in [
        BuildOptions::default(),
        BuildOptions::default().extremes(true),
        BuildOptions::fast_build().threads(7),
    ] {
        again(&options);
    }
    MODES.iter().for_each(again);
    ORDERS.iter().for_each(again);
    [Reach::Here, Reach::Swept].iter().for_each(again);
    again(&Filter::new(5, u32::MAX));
    let time = Budget::time(Duration::from_nanos(200_001));
    [time, Budget::work(u64::MAX), Budget::unlimited()]
        .iter()
        .for_each(again);
    // What is left out is the default; what does not exist is an error.
    let fast: BuildOptions = from_str(r#"{"effort":"Fast"}"#).unwrap();
    assert_eq!(fast, BuildOptions::fast_build());
    assert_eq!(from_str::<Budget>("{}").unwrap(), Budget::unlimited());
    assert!(error::<BuildOptions>(&json!({ "efort": "Fast" })).contains("unknown field `efort`"));
    assert!(error::<Effort>(&json!("Worst")).contains("unknown variant `Worst`"));
}

#[test]
fn poses_keep_every_bit_and_are_checked() {
    let mut random = Random::new(81);
    for drift in [Drift::None, Drift::Scale, Drift::Shear] {
        let pose = pose_about(DVec3::new(1e8, -1e-300, 0.1), 3.0, drift, &mut random);
        let read: Pose = from_str(&to_string(&pose).unwrap()).unwrap();
        assert_eq!(
            read.to_row_major().map(f64::to_bits),
            pose.to_row_major().map(f64::to_bits)
        );
    }
    assert_eq!(
        to_value(Pose::IDENTITY).unwrap(),
        json!([1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0.])
    );
    let mirror = json!([1., 0., 0., 0., 0., 1., 0., 0., 0., 0., -1., 0.]);
    assert!(error::<Pose>(&mirror).starts_with("matrix is off a rotation by 2e0"));
    let far = json!([1., 0., 0., 0., 0., 1., 0., 1e305, 0., 0., 1., 0.]);
    assert!(error::<Pose>(&far).starts_with("translation along axis 1 exceeds"));
    assert!(error::<Pose>(&json!([1., 0.])).contains("invalid length 2"));
}

#[test]
fn outcomes_certificates_and_the_model() {
    let [a, b] = [shapes::icosphere(3), shapes::torus(1.0, 0.3, 32)].map(Tree::new);
    let mut workspace = Workspace::new();
    let clock = ManualClock::ticking(Duration::from_nanos(1001));
    for mode in MODES {
        for budget in [
            Budget::work(0),
            Budget::work(3_000),
            Budget::time(Duration::from_micros(50)),
            ENOUGH,
        ] {
            let query = Query::intersection(&a, &b, Pose::IDENTITY).mode(mode);
            let outcome = query.run(&mut workspace, budget.clock(&clock));
            again(&outcome);
            let certificate = query.certificate(&workspace).unwrap();
            let written = to_value(certificate).unwrap();
            assert_eq!(written["open_pairs"], json!(certificate.open_pairs()));
            assert_eq!(written["upper_bound"], json!(certificate.upper_bound()));
            let extent = certificate.largest_extent();
            assert_eq!(written["largest_extent"], json!(extent));
            let boxes = serde_json::from_value(written["boxes"].clone());
            let boxes: Vec<punctual::Aabb> = boxes.unwrap();
            assert!(certificate.boxes().eq(boxes));
        }
    }
    for budget in [Budget::work(0), Budget::work(3_000), ENOUGH] {
        let pose = Pose::new(DMat3::IDENTITY, DVec3::X * 4.0).unwrap();
        let query = Query::distance(&a, &b, pose).margins([0.1, 0.0]);
        for query in [query, query.closer_than(1.0)] {
            again(&query.run(&mut workspace, budget.clock(&clock)));
            again(&query.estimate(&workspace, None).unwrap());
        }
        let motion = Motion::turning(pose, [-3.0, 0.0, 0.0], [0.1, 0.2, 1e-9], [0.3; 3]).unwrap();
        let read: Motion = from_str(&to_string(&motion).unwrap()).unwrap();
        assert_eq!(read, motion);
        again(&Query::impact(&a, &b, motion).run(&mut workspace, budget.clock(&clock)));
        let contacts = Query::contacts(&a, &b, pose).margin(3.0);
        again(&contacts.run(&mut workspace, budget.clock(&clock)));
        workspace.contacts().for_each(again);
    }
    let stats: TreeStats = from_str(&to_string(&a.stats()).unwrap()).unwrap();
    assert_eq!(stats, a.stats());
    again(&Counts {
        bv_tests: 0.1,
        triangle_tests: 1e300,
        box_updates: 0.0,
    });
    again(&CostModel::new([0.3, 13.6, 46.0, 1.0 / 3.0]));
}

#[test]
fn reports_of_a_scene() {
    let ball = Arc::new(Tree::new(shapes::icosphere(2)));
    let mut scene = Scene::new();
    let at = |x: f64| Pose::new(DMat3::IDENTITY, DVec3::X * x).unwrap();
    let ids = [0.0, 1.5, 3.3].map(|x| {
        let body = Body::moving(Arc::clone(&ball), at(x));
        scene.insert(body).unwrap()
    });
    for budget in [Budget::work(0), ENOUGH] {
        let report = scene.detect(budget.clock(&ManualClock::new())).clone();
        assert!(!report.pairs.is_empty());
        report.pairs.iter().for_each(again);
        let read: punctual_scene::Report = from_str(&to_string(&report).unwrap()).unwrap();
        assert_eq!(
            (read.pairs, read.decided, read.work),
            (report.pairs, report.decided, report.work)
        );
        again(&scene.certificate(ids[0], ids[1]).unwrap());
    }
    again(&ids[1]);
    scene.set_margin(ids[0], 1.0).unwrap();
    scene.set_pose(ids[1], at(2.5)).unwrap();
    let report = scene.detect(ENOUGH.clock(&ManualClock::new()));
    assert!(report.within > 0, "{report:?}");
    report.pairs.iter().for_each(again);
    // An id that was read is taken by the scene it is of, and says nothing of which that is.
    assert_eq!(to_string(&ids[0]).unwrap(), r#"{"index":0,"generation":0}"#);
    let read: BodyId = from_str(&to_string(&ids[1]).unwrap()).unwrap();
    scene.set_pose(read, at(2.6)).unwrap();
    let measure = scene.measure_groups(&ids[..1], &ids[1..], 0.1).unwrap();
    again(&measure);
    assert_eq!(to_string(&measure).unwrap(), "0");
    scene
        .stop_measuring_groups(from_str(&to_string(&measure).unwrap()).unwrap())
        .unwrap();
}

#[test]
fn verdicts_are_read_as_they_are_written() {
    let within = |distance| Verdict::Within {
        witness: [12, 907],
        distance,
    };
    let met = Verdict::Intersecting {
        witness: [0, u32::MAX],
    };
    for verdict in [
        met,
        within(0.25),
        within(f64::MIN_POSITIVE),
        within(1e300),
        Verdict::Separated,
        Verdict::Undecided,
    ] {
        again(&verdict);
    }
    assert_eq!(within(0.25).to_string(), "within(12, 907, 0.25)");
}

/// A memory that was read serves the pair it was written for, and any other pair cannot be misled by it.
#[test]
fn memory_is_of_use_to_its_pair_and_harmless_to_others() {
    let [a, b] = [shapes::torus_knot(2, 3, 0.2, 32), shapes::gear(11, 2)].map(Tree::new);
    let pose = pose_about(DVec3::ZERO, 0.1, Drift::None, &mut Random::new(82));
    let query = Query::intersection(&a, &b, pose);
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let first = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
    assert!(matches!(first.value, Verdict::Intersecting { .. }));
    let text = to_string(&memory).unwrap();
    let mut read: PairMemory = from_str(&text).unwrap();
    let [used, warm] = [&mut memory, &mut read]
        .map(|memory| run_with_memory(&query, &mut workspace, memory, ENOUGH));
    assert_eq!((warm, &read), (used, &memory));
    // A witness of the last frame saves work.
    assert!(warm.stats.work < first.stats.work);
    // Handed to a smaller pair: what does not exist there is forgotten.
    let small = Tree::new(shapes::icosphere(0));
    let apart = Pose::new(DMat3::IDENTITY, DVec3::X * 9.0).unwrap();
    for pose in [Pose::IDENTITY, apart] {
        let query = Query::intersection(&small, &small, pose);
        let mut read: PairMemory = from_str(&text).unwrap();
        let expected = run(&query, &mut workspace, ENOUGH).value;
        let verdict = run_with_memory(&query, &mut workspace, &mut read, ENOUGH).value;
        assert_eq!(
            verdict == Verdict::Separated,
            expected == Verdict::Separated
        );
    }
}

#[test]
fn a_memory_that_somebody_made_up_changes_no_verdict() {
    let [a, b] = [shapes::icosphere(2), shapes::torus(1.0, 0.3, 16)].map(Tree::new);
    let (mut random, mut workspace) = (Random::new(83), Workspace::new());
    for round in 0..300 {
        let mut triangle = || match random.below(2) {
            0 => random.below(600) as u32,
            _ => random.bits() as u32,
        };
        let mut witnesses: Vec<[u32; 2]> = (0..16).map(|_| [triangle(), triangle()]).collect();
        if round % 4 == 0 {
            witnesses.fill([7, 7]);
        }
        let last_verdict = [None, Some(true), Some(false)][round % 3];
        let made_up = json!({ "witnesses": witnesses, "last_verdict": last_verdict, "frames_undecided": u32::MAX });
        let pose = pose_about(DVec3::ZERO, 2.0, Drift::None, &mut random);
        for mode in [Mode::Any, Mode::All] {
            let mut memory: PairMemory = from_str(&made_up.to_string()).unwrap();
            let query = Query::intersection(&a, &b, pose).mode(mode);
            let expected = run(&query, &mut workspace, ENOUGH);
            for _ in 0..2 {
                let outcome = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
                assert_eq!(outcome.stats.found, expected.stats.found);
                assert_eq!(
                    outcome.value == Verdict::Separated,
                    expected.value == Verdict::Separated
                );
            }
        }
    }
    let clock = ManualClock::new();
    for nearest in [[0, 0], [319, 255], [u32::MAX, 0], [0, u32::MAX], [320, 5]] {
        let text = json!({ "nearest": nearest }).to_string();
        let query = Query::distance(&a, &b, Pose::IDENTITY).closer_than(0.01);
        let expected = query.run(&mut workspace, ENOUGH.clock(&clock));
        for budget in [ENOUGH, Budget::work(1)] {
            let mut memory: PairMemory = from_str(&text).unwrap();
            let said = query
                .with_memory(&mut memory)
                .run(&mut workspace, budget.clock(&clock));
            again(&said);
            assert!(
                said.value.closer == expected.value.closer
                    || said.value.closer.is_none() && budget != ENOUGH
            );
            // One that exists is looked at first.
            let exists =
                (nearest[0] as usize) < a.mesh().len() && (nearest[1] as usize) < b.mesh().len();
            assert!(
                budget == ENOUGH || said.value.nearest.is_some() == exists,
                "{nearest:?} {said:?}"
            );
        }
    }
    let too_many = json!({ "witnesses": vec![[0, 0]; 17] });
    assert!(from_str::<PairMemory>(&too_many.to_string()).is_err());
}

/// What was written by hand is checked as what was computed is.
#[test]
fn a_memory_with_an_impossible_rate_of_changes_is_refused() {
    let text = to_string(&PairMemory::new()).unwrap();
    let with =
        |rate: &str| text.replace("\"change_rate\":null", &format!("\"change_rate\":{rate}"));
    assert_ne!(with("0.5"), text);
    assert_eq!(
        from_str::<PairMemory>(&with("0.5")).unwrap().change_rate(),
        0.5
    );
    for bad in ["-0.1", "1.5", "1e300"] {
        let error = from_str::<PairMemory>(&with(bad)).unwrap_err().to_string();
        assert!(error.contains("change_rate"), "{error}");
    }
}

#[test]
fn a_memory_keeps_what_it_learned_of_predictions_and_an_impossible_factor_is_refused() {
    let [a, b] = [shapes::icosphere(3), shapes::gear(11, 2)].map(Tree::new);
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let mut random = Random::new(85);
    let mut query = || {
        let pose = pose_about(DVec3::ZERO, 0.4, Drift::None, &mut random);
        Query::all_pairs(&a, &b, pose)
    };
    for _ in 0..5 {
        let query = query();
        let _ = query.predict(Some(&memory));
        let _ = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
    }
    let text = to_string(&memory).unwrap();
    let mut read: PairMemory = from_str(&text).unwrap();
    for memory in [&mut memory, &mut read] {
        let _ = run_with_memory(&query(), &mut workspace, memory, Budget::work(0));
    }
    let query = query();
    let told = query.predict(Some(&memory));
    assert_ne!(told, query.predict(None));
    assert_eq!(query.predict(Some(&read)), told);
    let first = text.find("\"told\":[[[").unwrap() + "\"told\":[[[".len();
    let end = first + text[first..].find(',').unwrap();
    let bad = format!("{}{}{}", &text[..first], "99.0", &text[end..]);
    let error = from_str::<PairMemory>(&bad).unwrap_err().to_string();
    assert!(error.contains("factor"), "{error}");
}

#[test]
fn a_calibration_goes_on_where_it_was_and_an_impossible_one_is_refused() {
    let mut random = Random::new(82);
    let mut calibration = Calibration::default();
    again(&calibration);
    // What is told is at times always the same, so that its sums are as far apart as they can be.
    for moment in 0..2000 {
        let told = if moment < 1000 { 0.01 } else { random.unit() };
        calibration.learn(told, random.below(3) == 0);
        if moment % 7 == 0 {
            again(&calibration);
        }
    }
    let value = to_value(calibration).unwrap();
    let set = |field: &str, place: Option<usize>, x: Value| {
        let mut changed = value.clone();
        match place {
            Some(place) => changed[field][place] = x,
            None => changed[field] = x,
        }
        error::<Calibration>(&changed)
    };
    for (field, place, x) in [
        ("offset", None, 8.1),
        ("slope", None, 0.0),
        ("slope", None, -1.0),
        ("evidence", Some(0), -1e-9),
        ("evidence", Some(0), 41.0),
        ("evidence", Some(1), 1e300),
        ("evidence", Some(2), -1.0),
    ] {
        let name = place.map_or(field.to_owned(), |place| format!("{field}[{place}]"));
        let refused = set(field, place, json!(x));
        assert!(
            refused.contains(&format!("{name} {x:?} is out of range")),
            "{refused}"
        );
    }
    assert!(set("offset", None, Value::Null).contains("invalid type: null"));
    assert!(
        error::<Calibration>(&json!({ "offset": 0.0, "slope": 1.0 }))
            .contains("missing field `evidence`")
    );
    let apart = json!({ "offset": 0.0, "slope": 1.0, "evidence": [1.0, 1.1, 1.0] });
    assert!(error::<Calibration>(&apart).contains("evidence[1] 1.1"));
}
