//! Frames of a motion, all intersections: where triangles met in the frame before is looked at first, and nothing else changes.

mod common;

use common::check::{
    ENOUGH, assert_certificate, assert_complete, assert_sound, run, run_with_memory, sorted,
};
use common::reference::{Place, all_pairs, place};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::intersection::Intersection;
use punctual::{Budget, Mesh, Mode, PairMemory, Pose, Query, StopReason, Tree, Workspace, shapes};

/// A gear rolls in the teeth of another, and out of them.
struct Motion {
    a: Tree,
    b: Tree,
    poses: Vec<Pose>,
}

impl Motion {
    fn small() -> Self {
        Self::of([shapes::gear(20, 4), shapes::gear(12, 3)], 0.93, 0.02)
    }

    /// Radians a frame.
    fn of(meshes: [Mesh; 2], depth: f64, speed: f64) -> Self {
        let [a, b] = meshes.map(Tree::new);
        let reach = 0.5 * (a.mesh().aabb().extents().x + b.mesh().aabb().extents().x);
        let pose = |frame: usize| {
            let turn = DMat3::from_rotation_z(speed * frame as f64) * DMat3::from_rotation_x(0.01);
            Pose::new(
                turn,
                DVec3::new(reach * (depth + 0.15 * speed * frame as f64), 0.01, 0.02),
            )
            .unwrap()
        };
        Self {
            a,
            b,
            poses: (0..24).map(pose).collect(),
        }
    }

    fn query(&self, frame: usize) -> Query<'_, Intersection> {
        Query::all_pairs(&self.a, &self.b, self.poses[frame])
    }

    fn truth(&self, frame: usize) -> Vec<[u32; 2]> {
        all_pairs(self.a.mesh(), self.b.mesh(), &self.poses[frame])
    }
}

#[test]
fn at_every_stop_nothing_is_false_lost_or_reported_twice() {
    let motion = Motion::small();
    let truths: Vec<_> = (0..motion.poses.len())
        .map(|frame| motion.truth(frame))
        .collect();
    let (mut colliding, mut partial) = (0, 0);
    for queue in [0, 3, 4096] {
        let mut workspace = Workspace::with_capacity(queue, 65_536);
        let mut memory = PairMemory::new();
        for (frame, truth) in truths.iter().enumerate() {
            let query = motion.query(frame);
            let places: Vec<Place> = truth
                .iter()
                .map(|&pair| place(motion.a.mesh(), motion.b.mesh(), &motion.poses[frame], pair))
                .collect();
            let mut known = memory.clone();
            let full = run_with_memory(&query, &mut workspace, &mut known, ENOUGH);
            let pairs = workspace.pairs().to_vec();
            assert_complete(Mode::All, &full, &pairs, truth);
            colliding += usize::from(!truth.is_empty());
            for budget in (0..full.stats.work).step_by(full.stats.work as usize / 17 + 1) {
                let mut known = memory.clone();
                let outcome =
                    run_with_memory(&query, &mut workspace, &mut known, Budget::work(budget));
                assert_sound(&outcome, workspace.pairs(), truth);
                assert!(pairs.starts_with(workspace.pairs()), "budget {budget}");
                let certificate = query.certificate(&workspace).unwrap();
                assert_certificate(&certificate, &outcome, truth.len());
                let (found, open) = (
                    sorted(workspace.pairs()),
                    certificate.boxes().collect::<Vec<_>>(),
                );
                for (pair, place) in truth.iter().zip(&places) {
                    let named = open.iter().any(|open| place.is_in(open))
                        || found.binary_search(pair).is_ok();
                    assert!(named, "{pair:?} is in no box, budget {budget}");
                }
                partial += usize::from(found.len() < truth.len());
            }
            memory = known;
        }
    }
    assert!(colliding > 50 && partial > 400, "{colliding} {partial}");
}

/// What is remembered of a stopped query is that it found something somewhere.
#[test]
fn slices_end_in_the_same_bits_and_starved_memories_do_no_harm() {
    let motion = Motion::small();
    let (mut whole, mut sliced) = (Workspace::new(), Workspace::new());
    let (mut memory, mut starved) = (PairMemory::new(), PairMemory::new());
    for frame in 0..motion.poses.len() {
        let (query, truth) = (motion.query(frame), motion.truth(frame));
        let mut copy = memory.clone();
        let full = run_with_memory(&query, &mut whole, &mut memory, ENOUGH);
        for slice in [1, 700] {
            let mut known = copy.clone();
            let mut outcome = run_with_memory(&query, &mut sliced, &mut known, Budget::work(slice));
            while outcome.stop == StopReason::WorkLimit {
                let (budget, clock) = (Budget::work(slice), ManualClock::new());
                outcome = query
                    .with_memory(&mut known)
                    .resume(&mut sliced, budget.clock(&clock))
                    .unwrap();
            }
            assert_eq!((outcome, sliced.pairs()), (full, whole.pairs()));
            assert_eq!(known, memory);
        }
        copy = starved.clone();
        let outcome = run_with_memory(&query, &mut sliced, &mut starved, Budget::work(1_000));
        assert_sound(&outcome, sliced.pairs(), &truth);
        let outcome = run_with_memory(&query, &mut sliced, &mut copy, ENOUGH);
        assert_complete(Mode::All, &outcome, sliced.pairs(), &truth);
    }
}

/// A fifth of the work finds more, and a complete query takes about as much work.
#[test]
fn more_is_found_early_than_without_a_memory() {
    let motion = Motion::of(
        [
            shapes::torus_knot(2, 3, 0.2, 128),
            shapes::torus_knot(3, 2, 0.2, 128),
        ],
        0.95,
        0.002,
    );
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let (mut cold, mut warm, mut work) = (0.0, 0.0, [0, 0]);
    for frame in 0..motion.poses.len() {
        let query = motion.query(frame);
        let full = run(&query, &mut workspace, ENOUGH);
        let (fifth, all) = (
            Budget::work(full.stats.work / 5),
            full.stats.found.max(1) as f64,
        );
        if frame > 0 {
            let mut share = |memory: &mut PairMemory| {
                run_with_memory(&query, &mut workspace, memory, fifth)
                    .stats
                    .found as f64
                    / all
            };
            cold += share(&mut PairMemory::new());
            warm += share(&mut memory.clone());
        }
        let remembered = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
        work = [work[0] + full.stats.work, work[1] + remembered.stats.work];
    }
    println!("recall at 20 %, sum over the frames: {cold:.2} without, {warm:.2} with");
    assert!(warm > cold, "{warm} with, {cold} without");
    let ratio = work[1] as f64 / work[0] as f64;
    assert!((0.95..1.05).contains(&ratio), "{ratio}");
}

/// Orders that were asked for are kept, and what nothing cuts has nothing to find first.
#[test]
fn plain_and_complete_queries_go_as_without_a_memory() {
    let motion = Motion::small();
    let mut workspace = Workspace::new();
    for (is_plain, budget) in [(true, ENOUGH), (false, Budget::unlimited())] {
        let mut memory = PairMemory::new();
        for frame in 0..3 {
            let query = motion.query(frame);
            let query = if is_plain { query.plain() } else { query };
            let plain = run(&query, &mut workspace, budget);
            let pairs = workspace.pairs().to_vec();
            assert!(!pairs.is_empty());
            assert_eq!(
                run_with_memory(&query, &mut workspace, &mut memory, budget),
                plain
            );
            assert_eq!(workspace.pairs(), pairs);
        }
    }
}
