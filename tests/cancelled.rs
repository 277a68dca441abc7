//! A clock can cancel calls, whatever their budget: they end within some millions of units of work, and what they know
//! then is
//! true. Without a cancellation nothing changes.

use std::cell::Cell;
use std::sync::Arc;
use std::time::Duration;

use punctual::clock::SystemClock;
use punctual::glam::{DMat3, DVec3};
use punctual::{
    Budget, Clock, Mesh, Mode, Motion, Pose, Query, Ray, StopReason, Tree, Verdict, Workspace,
    shapes,
};
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
use punctual_scene::{Body, Scene};

/// Work that is done at most between two looks, and the last steps.
const LOOKS_AFTER: u64 = 2 << 20;

/// Cancels at the given look.
struct Canceller {
    looks: Cell<u32>,
    at: u32,
}

impl Canceller {
    fn at(at: u32) -> Self {
        Self {
            looks: Cell::new(0),
            at,
        }
    }
}

impl Clock for Canceller {
    fn now(&self) -> Duration {
        SystemClock::default().now()
    }

    fn is_cancelled(&self) -> bool {
        self.looks.set(self.looks.get() + 1);
        self.looks.get() >= self.at
    }
}

const BUDGETS: [Budget; 3] = [
    Budget::unlimited(),
    Budget::time(Duration::from_secs(3600)),
    Budget::work(u64::MAX / 4),
];

#[test]
fn a_cancelled_query_ends_soon_and_is_resumed_to_the_same_end() {
    let (mut workspace, mut whole) = (Workspace::new(), Workspace::new());
    let tree = Tree::new(shapes::icosphere(6));
    let query = Query::intersection(&tree, &tree, Pose::IDENTITY).mode(Mode::All);
    let run = |workspace: &mut Workspace,
               mut outcome: punctual::Answer<punctual::Verdict>,
               budget,
               found: &mut Vec<[u32; 2]>| {
        found.extend(workspace.drain_pairs());
        while outcome.stop != StopReason::Finished {
            outcome = query.resume(workspace, budget).unwrap();
            found.extend(workspace.drain_pairs());
        }
        outcome
    };
    for budget in BUDGETS {
        let mut all = Vec::new();
        let first = query.run(&mut whole, budget);
        let expected = run(&mut whole, first, budget, &mut all);
        all.sort_unstable();
        assert!(expected.stats.work > 8 * LOOKS_AFTER);
        for at in [1, 2] {
            let mut found = Vec::new();
            let stopped = query.run(&mut workspace, budget.clock(&Canceller::at(at)));
            assert_eq!(stopped.stop, StopReason::Cancelled);
            assert!(
                stopped.stats.work < u64::from(at) * LOOKS_AFTER,
                "{budget:?}: {}",
                stopped.stats.work
            );
            assert!(matches!(stopped.value, Verdict::Intersecting { .. }));
            let ended = run(&mut workspace, stopped, budget, &mut found);
            found.sort_unstable();
            assert!(ended.stats.found == expected.stats.found && found == all);
        }
    }
}

#[test]
fn every_question_can_be_cancelled() {
    let mesh = shapes::icosphere(6);
    let doubled = (0..mesh.vertex_count()).map(|vertex| (2.0 * mesh.vertex(vertex)).to_array());
    let larger = Tree::new(Mesh::from_f64(doubled, mesh.triangles().iter().copied()).unwrap());
    let (tree, mut workspace) = (Tree::new(mesh), Workspace::new());
    for budget in BUDGETS {
        let clock = Canceller::at(1);
        let ends_soon = |stop: StopReason, work: u64| {
            assert_eq!(stop, StopReason::Cancelled);
            assert!(work < LOOKS_AFTER, "{budget:?}: {work}");
        };

        let query = Query::distance(&tree, &larger, Pose::IDENTITY).absolute_tolerance(0.0);
        let distance = query.run(&mut workspace, budget.clock(&clock));
        ends_soon(distance.stop, distance.stats.work);
        assert!(distance.value.low <= 1.0 && 0.98 <= distance.value.high);

        let contacts = Query::contacts(&tree, &tree, Pose::IDENTITY).margin(0.1);
        let contacts = contacts.run(&mut workspace, budget.clock(&clock));
        ends_soon(contacts.stop, contacts.stats.work);
        assert!(contacts.value.low <= 0.1);

        let turn = Motion::turning(Pose::IDENTITY, DVec3::ZERO, DVec3::Z, DVec3::ZERO).unwrap();
        let motion = Query::impact(&tree, &larger, turn)
            .margins([0.4, 0.4])
            .tolerance(0.0)
            .time_tolerance(0.0);
        let passage = motion.run(&mut workspace, budget.clock(&clock));
        ends_soon(passage.stop, passage.stats.work);
        assert!(passage.value.upper.is_none() && passage.value.lower < 1.0);

        let deep = Pose::new(DMat3::IDENTITY, DVec3::new(0.2, 0.1, 0.3)).unwrap();
        let push = PenetrationQuery::new(&tree, &tree, deep)
            .run(&mut PenetrationWorkspace::new(), budget.clock(&clock));
        ends_soon(push.stop, push.stats.work);

        let ray = Ray::new([0.1, 0.2, 3.0], [0.0, 0.0, -1.0]).unwrap();
        let rays = vec![ray; 20_000];
        let cast = Query::rays(&tree, &rays).run(&mut workspace, budget.clock(&clock));
        ends_soon(cast.stop, cast.stats.work);
        let hits = workspace.first_hits();
        assert!(0 < cast.value && cast.value == hits.len());
        assert!(hits.iter().all(|hit| *hit == hits[0] && hit.is_some()));
    }
}

#[test]
fn a_cancelled_frame_is_followed_by_a_whole_one() {
    let tree = Arc::new(Tree::new(shapes::icosphere(5)));
    for budget in BUDGETS {
        let scene = || {
            let mut scene = Scene::new();
            scene.set_mode(Mode::All);
            for at in 0..6 {
                let pose =
                    Pose::new(DMat3::IDENTITY, DVec3::new(0.01 * f64::from(at), 0.0, 0.0)).unwrap();
                scene.insert(Body::moving(Arc::clone(&tree), pose)).unwrap();
            }
            scene
        };
        let (mut plain, mut cancelled) = (scene(), scene());
        let report = cancelled.detect(budget.clock(&Canceller::at(1)));
        assert!(report.work < 2 * LOOKS_AFTER, "{budget:?}: {}", report.work);
        let found = |report: &punctual_scene::Report| {
            report.pairs.iter().map(|pair| pair.found).sum::<u64>()
        };
        let first = found(report);
        let whole = plain.detect(budget);
        assert!(whole.is_whole() && whole.pairs.len() == 15);
        let again = cancelled.detect(budget);
        assert!(again.is_whole() && again.pairs.len() == 15 && again.undecided() == 0);
        assert!(first < found(whole) && found(again) == found(whole));
    }
}
