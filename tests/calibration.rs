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
        (
            logistic(logit),
            random.unit() < logistic(offset + slope * logit),
        )
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
    for probability in (0..10_000)
        .map(|_| random.unit())
        .chain(TOLD[4..14].iter().copied())
    {
        assert_eq!(
            Calibration::default().apply(probability).to_bits(),
            probability.to_bits()
        );
    }
}

#[test]
fn what_was_told_as_certain_stays_so_and_teaches_nothing() {
    let mut calibration = learned(&moments(100, [1.0, 2.0], &mut Random::new(2)));
    let before = calibration;
    for (certain, end) in [
        (0.0, 0.0),
        (-1.0, 0.0),
        (1.0, 1.0),
        (2.0, 1.0),
        (f64::INFINITY, 1.0),
    ] {
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
            let at = |logit: f64| {
                calibration.apply(logistic(logit)) - logistic(bias[0] + bias[1] * logit)
            };
            [-2.5, -1.0, 0.0, 1.0, 2.5]
                .map(|logit| at(logit).abs())
                .into_iter()
                .sum::<f64>()
                / 5.0
        };
        let mean = |count: usize, random: &mut Random| {
            (0..20)
                .map(|_| error(&learned(&moments(count, bias, random))))
                .sum::<f64>()
                / 20.0
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
            assert!(
                (calibration.apply(probability) - probability).abs() < 0.12,
                "{calibration:?}"
            );
        }
    }
}

#[test]
fn what_changed_is_followed() {
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
    let corrected = TOLD[3..14]
        .iter()
        .map(|&told| calibration.apply(told))
        .collect::<Vec<_>>();
    assert!(corrected.is_sorted(), "{corrected:?} {calibration:?}");
    assert!(
        corrected[2..10].iter().all(|p| *p > 0.0 && *p < 1.0),
        "{corrected:?} {calibration:?}"
    );
    assert!(
        TOLD.iter()
            .all(|&told| (0.0..=1.0).contains(&calibration.apply(told))),
        "{calibration:?}"
    );
}

#[test]
fn no_lesson_makes_it_unsound() {
    let mut random = Random::new(7);
    for lesson in 0..400 {
        let mut calibration = Calibration::default();
        // Always the same, always wrong, by turns, or anything.
        for moment in 0..500_usize {
            let told = if lesson < 64 {
                TOLD[lesson % 16]
            } else {
                TOLD[random.below(16)]
            };
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
    let bits = [
        calibration.offset(),
        calibration.slope(),
        calibration.apply(0.3),
    ]
    .map(f64::to_bits);
    assert_eq!(
        bits,
        [
            0x3fce_6076_006e_dbb5,
            0x3fc0_0000_0000_0000,
            0x3fe1_0cbb_e544_d15a
        ],
        "{bits:#x?}"
    );
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
        let whole = query
            .mode(Mode::All)
            .run(&mut workspace, Budget::unlimited().clock(&clock));
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
fn what_an_estimate_proves_is_told_as_zero() {
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
        println!(
            "{count} moments: Brier {:.3} before, {:.3} after",
            raw / f64::from(count),
            corrected / f64::from(count)
        );
        assert!(count > 100 && corrected < raw, "{count}: {raw} {corrected}");
    }
}

/// Two rows of knots that meet or nearly do.
fn crowd() -> (Scene, Vec<BodyId>) {
    let tree = Arc::new(Tree::new(shapes::torus_knot(2, 3, 0.2, 128)));
    let mut scene = Scene::new();
    let mut insert = || {
        scene
            .insert(Body::moving(Arc::clone(&tree), Pose::IDENTITY))
            .unwrap()
    };
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
        let center = DVec3::new(
            2.4 * (body % 6) as f64,
            2.2 * (body / 6) as f64,
            0.3 * (body as f64 + time).sin(),
        );
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
        scene
            .detect(Budget::work(3_000).clock(&ManualClock::new()))
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
    for (fresh, taught) in
        play(&mut fresh, &ids, 0..300, 20)
            .iter()
            .zip(play(&mut taught, &ids, 0..300, 20))
    {
        for (fresh, taught) in fresh.iter().zip(&taught) {
            assert_eq!(
                (fresh.verdict, fresh.age, fresh.found),
                (taught.verdict, taught.age, taught.found)
            );
            corrected += usize::from(fresh.probability != taught.probability);
        }
    }
    assert!(corrected > 0);
}

#[test]
fn what_was_told_before_bodies_moved_teaches_a_scene_nothing() {
    let (mut scene, ids) = crowd();
    let told = play(&mut scene, &ids, 0..100, 1);
    assert!(
        told.iter()
            .flatten()
            .any(|pair| pair.verdict == Verdict::Undecided)
    );
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
    println!(
        "{count} moments: Brier {:.3} before, {:.3} after",
        raw / f64::from(count),
        corrected / f64::from(count)
    );
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
