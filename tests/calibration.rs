//! What a calibration promises: it knows nothing at first, moves to the truth, is never without a number, and is the same
//! everywhere; and a scene learns only from what it knows to be true of the same moment.

mod common;

use std::ops::Range;
use std::sync::Arc;

use common::random::Random;
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::Calibration;
use punctual::{Budget, Mode, Pose, Query, Tree, Verdict, Workspace, shapes};
use punctual_scene::{Body, BodyId, PairReport, Scene};

/// Probabilities and things that are none.
const TOLD: [f64; 16] = [
    f64::NAN,
    f64::NEG_INFINITY,
    -1.0,
    -0.0,
    0.0,
    5e-324,
    1e-9,
    0.02,
    0.3,
    0.5,
    0.7,
    0.98,
    1.0 - f64::EPSILON / 2.0,
    1.0,
    2.0,
    f64::INFINITY,
];

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// Moments of a teller that is off: the logit of the truth is `offset + slope` times what it tells.
fn moments(count: usize, [offset, slope]: [f64; 2], random: &mut Random) -> Vec<(f64, bool)> {
    let mut moment = || {
        let logit = 3.0 * random.signed();
        let truth = logistic(offset + slope * logit);
        (logistic(logit), random.unit() < truth)
    };
    (0..count).map(|_| moment()).collect()
}

fn learned(moments: &[(f64, bool)]) -> Calibration {
    let mut calibration = Calibration::default();
    moments
        .iter()
        .for_each(|&(told, met)| calibration.learn(told, met));
    calibration
}

#[test]
fn a_default_calibration_changes_no_bit() {
    let mut random = Random::new(1);
    let any = (0..10_000).map(|_| random.unit());
    for probability in any.chain(TOLD[4..14].iter().copied()) {
        let applied = Calibration::default().apply(probability);
        assert_eq!(applied.to_bits(), probability.to_bits());
    }
}

#[test]
fn certain_predictions_stay_certain_and_teach_nothing() {
    let mut calibration = learned(&moments(100, [1.0, 2.0], &mut Random::new(2)));
    let before = calibration;
    let infinite = (f64::INFINITY, 1.0);
    for (certain, end) in [(0.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (2.0, 1.0), infinite] {
        assert_eq!(calibration.apply(certain), end);
        for met in [false, true] {
            calibration.learn(certain, met);
        }
    }
    calibration.learn(f64::NAN, true);
    assert_eq!(calibration, before);
}

#[test]
fn learning_moves_a_biased_teller_to_the_truth() {
    for bias in [[1.2, 1.0], [-1.5, 0.5], [0.0, 2.5], [0.5, 0.3]] {
        let mut random = Random::new(3);
        let error = |calibration: &Calibration| {
            let truth = |logit: f64| logistic(bias[0] + bias[1] * logit);
            let off = |logit: f64| (calibration.apply(logistic(logit)) - truth(logit)).abs();
            [-2.5, -1.0, 0.0, 1.0, 2.5]
                .map(off)
                .into_iter()
                .sum::<f64>()
                / 5.0
        };
        let mean = |count: usize, random: &mut Random| {
            let errors = (0..20).map(|_| error(&learned(&moments(count, bias, random))));
            errors.sum::<f64>() / 20.0
        };
        let [untaught, hundred, thousand] = [0, 100, 1000].map(|count| mean(count, &mut random));
        assert!(
            untaught > 0.08 && hundred < 0.06 && thousand < 0.04,
            "{bias:?}: {untaught} {hundred} {thousand}"
        );
    }
}

#[test]
fn an_honest_teller_is_left_about_as_it_is() {
    let mut random = Random::new(4);
    for _ in 0..20 {
        let calibration = learned(&moments(300, [0.0, 1.0], &mut random));
        for probability in [0.1, 0.3, 0.5, 0.7, 0.9] {
            let off = calibration.apply(probability) - probability;
            assert!(off.abs() < 0.12, "{calibration:?}");
        }
    }
}

#[test]
fn a_calibration_follows_a_changed_teller() {
    let mut random = Random::new(5);
    let mut past = moments(5000, [1.5, 1.0], &mut random);
    past.extend(moments(1000, [-1.5, 1.0], &mut random));
    let now = learned(&past).apply(0.5);
    assert!((now - logistic(-1.5)).abs() < 0.06, "{now}");
}

#[test]
fn one_surprise_does_not_outweigh_what_is_known() {
    let mut calibration = learned(&moments(100, [0.0, 1.0], &mut Random::new(6)));
    let before = [0.1, 0.5, 0.9].map(|p| calibration.apply(p));
    calibration.learn(5e-324, true);
    for (before, p) in before.into_iter().zip([0.1, 0.5, 0.9]) {
        assert!((calibration.apply(p) - before).abs() < 0.1, "{before}");
    }
}

/// After any lessons: in order, never NaN, certain only of what was told as certain.
#[track_caller]
fn assert_sound(calibration: &Calibration) {
    assert!(
        calibration.offset().abs() <= 8.0 && (0.125..=8.0).contains(&calibration.slope()),
        "{calibration:?}"
    );
    let corrected = [3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13].map(|i| calibration.apply(TOLD[i]));
    assert!(corrected.is_sorted(), "{corrected:?} {calibration:?}");
    let is_open = |p: &f64| 0.0 < *p && *p < 1.0;
    assert!(corrected[2..10].iter().all(is_open), "{corrected:?}");
    let is_share = |told: &f64| (0.0..=1.0).contains(&calibration.apply(*told));
    assert!(TOLD.iter().all(is_share), "{calibration:?}");
}

#[test]
fn no_lesson_makes_it_unsound() {
    let mut random = Random::new(7);
    for lesson in 0..400 {
        let mut calibration = Calibration::default();
        // Always the same, always wrong, by turns, or anything.
        for moment in 0..500_usize {
            let told = TOLD[if lesson < 64 {
                lesson % 16
            } else {
                random.below(16)
            }];
            let met = match lesson / 16 {
                0 => false,
                1 => true,
                2 => moment % 2 == 0,
                3 => told < 0.5,
                n if n % 3 == 0 => told < 0.5,
                n if n % 3 == 1 => told >= 0.5,
                _ => random.below(2) == 0,
            };
            calibration.learn(told, met);
        }
        assert_sound(&calibration);
    }
}

#[test]
fn the_same_lessons_give_the_same_bits_everywhere() {
    let mut calibration = Calibration::default();
    for moment in 0..1000_u32 {
        calibration.learn(f64::from(moment * 37 % 101) / 101.0, moment * 61 % 89 < 50);
    }
    let told = [
        calibration.offset(),
        calibration.slope(),
        calibration.apply(0.3),
    ];
    let bits = told.map(f64::to_bits);
    let expected = [
        0x3fce_6076_006e_dbb5,
        0x3fc0_0000_0000_0000,
        0x3fe1_0cbb_e544_d15a,
    ];
    assert_eq!(bits, expected, "{bits:#x?}");
}

fn at(x: f64, turn: f64) -> Pose {
    Pose::new(DMat3::from_rotation_y(turn), DVec3::new(x, 0.1, 0.2)).unwrap()
}

/// Undecided moments of two meshes about their first touch: the poses one after the other, with what is told of each.
fn stopped(a: &Tree, b: &Tree, touch: f64) -> Vec<(Vec<f64>, bool)> {
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let mut random = Random::new(8);
    let mut moments = Vec::new();
    for _ in 0..150 {
        let query = Query::intersection(a, b, at(touch + 0.1 * random.signed(), random.unit()));
        let all = query.mode(Mode::All);
        let whole = all.run(&mut workspace, Budget::unlimited().clock(&clock));
        let mut told = Vec::new();
        for percent in [2, 5, 10, 20, 50] {
            let budget = Budget::work(whole.stats.work * percent / 100);
            if query.run(&mut workspace, budget.clock(&clock)).value == Verdict::Undecided {
                told.push(query.estimate(&workspace, None).unwrap().probability);
            }
        }
        moments.push((told, whole.stats.found > 0));
    }
    moments
}

/// Where the look at the front leaves nothing that may meet, the surfaces are apart, and that is told.
#[test]
fn a_proof_of_separation_is_a_probability_of_zero() {
    let [ring, sphere] = [shapes::torus(1.0, 0.2, 64), shapes::icosphere(4)].map(Tree::new);
    let (mut none, mut some) = (0, 0);
    for (a, b, touch) in [
        (&ring, &sphere, 2.2),
        (&ring, &ring, 1.65),
        (&sphere, &sphere, 2.0),
    ] {
        for (told, met) in stopped(a, b, touch) {
            none += told.iter().filter(|told| **told == 0.0).count();
            some += told.iter().filter(|told| **told > 0.0).count();
            assert!(!met || told.iter().all(|told| *told > 0.0), "{told:?}");
        }
    }
    println!("{none} of {} moments are told 0", none + some);
    assert!(none > 50 && some > 50, "{none} {some}");
}

#[test]
fn a_pair_of_parts_is_told_better_once_it_is_known() {
    let [ring, sphere] = [shapes::torus(1.0, 0.2, 64), shapes::icosphere(4)].map(Tree::new);
    for (a, b, touch) in [
        (&ring, &sphere, 2.15),
        (&ring, &ring, 1.6),
        (&sphere, &sphere, 1.95),
    ] {
        let mut calibration = Calibration::default();
        let (mut raw, mut corrected, mut count) = (0.0, 0.0, 0);
        for (pose, (told, met)) in stopped(a, b, touch).into_iter().enumerate() {
            // What is learned of a pose comes after all that was told of it.
            for &told in told.iter().filter(|_| pose >= 50) {
                let square = |p: f64| (p - f64::from(u8::from(met))).powi(2);
                raw += square(told);
                corrected += square(calibration.apply(told));
                count += 1;
            }
            told.iter().for_each(|&told| calibration.learn(told, met));
        }
        println!("{count} moments: squares {raw:.3} before, {corrected:.3} after");
        assert!(count > 100 && corrected < raw, "{count}: {raw} {corrected}");
    }
}

/// Two rows of knots that meet or nearly do.
fn crowd() -> (Scene, Vec<BodyId>) {
    let tree = Arc::new(Tree::new(shapes::torus_knot(2, 3, 0.2, 128)));
    let mut scene = Scene::new();
    let body = Body::moving(tree, Pose::IDENTITY);
    let mut insert = || scene.insert(body.clone()).unwrap();
    // Ids that all scenes of this crowd take for their own.
    let ids = (0..12)
        .map(|_| BodyId::from_bits(insert().to_bits()))
        .collect();
    (scene, ids)
}

/// Puts the knots where they are at that time.
fn place(scene: &mut Scene, ids: &[BodyId], time: f64) {
    for (body, &id) in ids.iter().enumerate() {
        let turn = DMat3::from_rotation_x(body as f64 + 2.0 * time);
        let [x, y] = [body % 6, body / 6].map(|n| n as f64);
        let center = DVec3::new(2.4 * x, 2.2 * y, 0.3 * (body as f64 + time).sin());
        scene
            .set_pose(id, Pose::new(turn, center).unwrap())
            .unwrap();
    }
}

/// What the frames `from..to` of little work say, with the bodies moved in one of `rest` frames.
fn play(
    scene: &mut Scene,
    ids: &[BodyId],
    frames: Range<usize>,
    rest: usize,
) -> Vec<Vec<PairReport>> {
    let detect = |frame: usize| {
        if frame.is_multiple_of(rest) {
            place(scene, ids, (frame / rest) as f64);
        }
        let budget = Budget::work(3_000);
        scene
            .detect(budget.clock(&ManualClock::new()))
            .pairs
            .clone()
    };
    frames.map(detect).collect()
}

#[test]
fn a_scene_learns_from_pairs_that_rest_until_they_are_decided() {
    let (mut scene, ids) = crowd();
    play(&mut scene, &ids, 0..400, 20);
    let calibration = scene.calibration();
    assert_ne!(calibration, Calibration::default());
    // The same frames again: what was learned is in what is told, and changes nothing else.
    let [(mut fresh, _), (mut taught, _)] = [crowd(), crowd()];
    taught.set_calibration(calibration);
    let mut corrected = 0;
    let [fresh, taught] = [&mut fresh, &mut taught].map(|scene| play(scene, &ids, 0..300, 20));
    for (fresh, taught) in fresh.iter().flatten().zip(taught.iter().flatten()) {
        let told = |pair: &PairReport| (pair.verdict, pair.age, pair.found);
        assert_eq!(told(fresh), told(taught));
        corrected += usize::from(fresh.probability != taught.probability);
    }
    assert!(corrected > 0);
}

#[test]
fn predictions_of_bodies_that_moved_teach_a_scene_nothing() {
    let (mut scene, ids) = crowd();
    let told = play(&mut scene, &ids, 0..100, 1);
    let is_open = |pair: &PairReport| pair.verdict == Verdict::Undecided;
    assert!(told.iter().flatten().any(is_open));
    assert_eq!(scene.calibration(), Calibration::default());
}

#[test]
fn a_scene_tells_better_what_it_has_learned() {
    let [(mut learning, ids), (mut untaught, _), (mut complete, _)] = [crowd(), crowd(), crowd()];
    let (mut raw, mut corrected, mut count) = (0.0, 0.0, 0);
    let little = Budget::work(3_000);
    for frame in 0..2000 {
        untaught.set_calibration(Calibration::default());
        let scenes = [
            (&mut learning, little),
            (&mut untaught, little),
            (&mut complete, Budget::unlimited()),
        ];
        let [learning, untaught, truth] = scenes.map(|(scene, budget)| {
            place(scene, &ids, f64::from(frame / 20));
            scene.detect(budget.clock(&ManualClock::new()))
        });
        for ((learning, untaught), truth) in
            learning.pairs.iter().zip(&untaught.pairs).zip(&truth.pairs)
        {
            if learning.probability != untaught.probability {
                raw += (untaught.probability - truth.probability).powi(2);
                corrected += (learning.probability - truth.probability).powi(2);
                count += 1;
            }
        }
    }
    println!("{count} moments: squares {raw:.3} before, {corrected:.3} after");
    assert!(count > 100 && corrected < 0.9 * raw, "{count}");
}

#[cfg(feature = "parallel")]
#[test]
fn a_scene_learns_the_same_on_any_number_of_threads() {
    let run = |threads: usize| {
        let (mut scene, ids) = crowd();
        scene.use_threads(threads).unwrap();
        let mut told = Vec::new();
        for frame in 0..200 {
            if frame % 20 == 0 {
                place(&mut scene, &ids, f64::from(frame / 20));
            }
            told.extend(
                scene
                    .detect(Budget::work(3_000))
                    .pairs
                    .iter()
                    .map(|pair| pair.probability.to_bits()),
            );
        }
        (scene.calibration(), told)
    };
    let one = run(1);
    assert_ne!(one.0, Calibration::default());
    for threads in [2, 4] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}
