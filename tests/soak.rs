//! One workspace for millions of queries: each says what a fresh one said, and no memory is taken or given back.
//!
//! The long run: `cargo test --release --test soak -- --ignored`.

#[path = "common/allocations.rs"]
mod allocations;
mod common;

use allocations::allocator_calls;
use common::check::{ENOUGH, run, run_with_memory};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::{MODES, ORDERS};
use punctual::glam::{DVec3, Vec3};
use punctual::intersection::Intersection;
use punctual::{Answer, Budget, PairMemory, Query, Tree, Verdict, Workspace, shapes};

/// A query, and what it says in a fresh workspace.
struct Case<'t> {
    trees: [usize; 2],
    query: Query<'t, Intersection>,
    budget: Budget,
    outcome: Answer<Verdict>,
    pairs: u64,
    /// Whether the surfaces meet.
    truth: bool,
}

fn workspace() -> Workspace {
    Workspace::with_capacity(100, 2000)
}

/// A number that depends on all pairs found and their order.
fn mixed(workspace: &Workspace) -> u64 {
    let mix = |sum: u64, pair: &[u32; 2]| {
        (sum ^ u64::from(pair[0]) << 32 ^ u64::from(pair[1])).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ sum >> 29
    };
    workspace.pairs().iter().fold(0, mix)
}

fn cases<'t>(trees: &'t [Tree], random: &mut Random) -> Vec<Case<'t>> {
    let case = |_| {
        let chosen = [random.below(trees.len()), random.below(trees.len())];
        let pose = pose_about(DVec3::ZERO, 1.6, Drift::Shear, random);
        let query = Query::intersection(&trees[chosen[0]], &trees[chosen[1]], pose)
            .mode(MODES[random.below(2)])
            .order(ORDERS[random.below(ORDERS.len())]);
        // A third is cut short, so that the next query finds its rest in the workspace.
        let budget = [
            ENOUGH,
            Budget::unlimited(),
            Budget::work(random.below(3000) as u64),
        ][random.below(3)];
        let mut fresh = workspace();
        let outcome = run(&query, &mut fresh, budget);
        let pairs = mixed(&fresh);
        let truth = run(&query, &mut fresh, ENOUGH).value != Verdict::Separated;
        Case {
            trees: chosen,
            query,
            budget,
            outcome,
            pairs,
            truth,
        }
    };
    (0..5000).map(case).collect()
}

fn soak(queries: usize) {
    let mut random = Random::new(91);
    let trees = [
        shapes::icosphere(2),
        shapes::torus(0.9, 0.2, 24),
        shapes::cuboid(Vec3::new(0.9, 0.5, 0.2), 5),
        shapes::gear(9, 1),
        shapes::torus_knot(2, 3, 0.2, 40),
        soup(Family::Degenerate, 100, &mut random),
        soup(Family::Grid, 50, &mut random),
    ]
    .map(Tree::new);
    let cases = cases(&trees, &mut random);
    let mut workspace = workspace();
    let mut memories = vec![PairMemory::new(); trees.len() * trees.len()];
    let calls = allocator_calls(|| {
        for number in 0..queries {
            let case = &cases[random.below(cases.len())];
            if number % 4 == 3 {
                // A memory may change the way, not the answer.
                let memory = &mut memories[case.trees[0] * trees.len() + case.trees[1]];
                let verdict =
                    run_with_memory(&case.query, &mut workspace, memory, case.budget).value;
                assert!(
                    verdict == Verdict::Undecided || case.truth == (verdict != Verdict::Separated),
                    "{number}"
                );
                continue;
            }
            let outcome = run(&case.query, &mut workspace, case.budget);
            assert!(
                outcome == case.outcome && mixed(&workspace) == case.pairs,
                "{number}: {outcome:?}"
            );
        }
    });
    assert_eq!(calls, 0, "calls to the allocator");
}

#[test]
fn a_hundred_thousand_queries() {
    soak(100_000);
}

#[test]
#[ignore = "takes a minute or two, in release"]
fn ten_million_queries() {
    soak(10_000_000);
}
