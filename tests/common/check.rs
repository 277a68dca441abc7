//! What must be true of every outcome, wherever the query stopped.

use punctual::intersection::Intersection;
use punctual::{Answer, Budget, Certificate, Mode, Query, StopReason, Verdict, Workspace};

#[allow(
    unused_imports,
    reason = "each test file is a crate of its own and uses a part"
)]
pub use super::ask::{ENOUGH, resume, run, run_with_memory};

/// Runs to the end, emptying the pair buffer as often as it fills: the last outcome and all pairs.
pub fn run_to_end(
    query: &Query<Intersection>,
    workspace: &mut Workspace,
    budget: Budget,
) -> (Answer<Verdict>, Vec<[u32; 2]>) {
    let mut outcome = run(query, workspace, budget);
    let mut pairs = Vec::new();
    while outcome.stop == StopReason::PairsFull {
        let before = pairs.len();
        pairs.extend(workspace.drain_pairs());
        assert!(pairs.len() > before, "full without a pair: no progress");
        outcome = resume(query, workspace, budget);
    }
    pairs.extend(workspace.drain_pairs());
    (outcome, pairs)
}

/// `pairs` in ascending order.
pub fn sorted(pairs: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let mut pairs = pairs.to_vec();
    pairs.sort_unstable();
    pairs
}

/// No false verdict, no false pair, no pair twice, honest counts. `truth` is ascending.
#[track_caller]
pub fn assert_sound(outcome: &Answer<Verdict>, pairs: &[[u32; 2]], truth: &[[u32; 2]]) {
    let known = |pair: &[u32; 2]| truth.binary_search(pair).is_ok();
    if let Some(false_pair) = pairs.iter().find(|pair| !known(pair)) {
        panic!("{false_pair:?} do not intersect");
    }
    let ascending = sorted(pairs);
    // A pair was reported twice.
    assert!(ascending.windows(2).all(|two| two[0] != two[1]));
    // Count of found pairs.
    assert_eq!(outcome.stats.found, pairs.len() as u64);
    match outcome.value {
        Verdict::Intersecting { witness } => assert!(known(&witness), "false witness {witness:?}"),
        Verdict::Within { .. } => panic!("a query without margins"),
        Verdict::Contained { .. } => panic!("surfaces contain nothing"),
        Verdict::Separated => {
            assert!(truth.is_empty(), "false Separated, truth {}", truth.len());
            assert_eq!(outcome.stop, StopReason::Finished);
        }
        Verdict::Undecided => {
            assert!(pairs.is_empty(), "Undecided with a proof at hand");
            let stopped = matches!(outcome.stop, StopReason::Deadline | StopReason::WorkLimit);
            assert!(stopped, "Undecided, but {:?}", outcome.stop);
        }
    }
}

/// A run that nothing stopped: the whole truth in `All`, one true pair in `Any`.
#[track_caller]
pub fn assert_complete(
    mode: Mode,
    outcome: &Answer<Verdict>,
    pairs: &[[u32; 2]],
    truth: &[[u32; 2]],
) {
    assert_sound(outcome, pairs, truth);
    let hit = matches!(outcome.value, Verdict::Intersecting { .. });
    assert_eq!(hit, !truth.is_empty(), "{:?}", outcome.value);
    match mode {
        Mode::Any if hit => assert_eq!(outcome.stop, StopReason::FirstHit),
        _ => assert_eq!(outcome.stop, StopReason::Finished),
    }
    if mode == Mode::All {
        assert_eq!(sorted(pairs), truth, "pairs");
    }
}

/// The bound holds and the boxes are as large as said.
#[track_caller]
pub fn assert_certificate(certificate: &Certificate, outcome: &Answer<Verdict>, truth: usize) {
    let bound = certificate.upper_bound();
    assert!(bound >= truth as u64, "bound {bound} below truth {truth}");
    assert!(bound >= outcome.stats.found);
    let largest = certificate
        .boxes()
        .map(|open| open.extents().max_element())
        .fold(0.0, f64::max);
    assert!(largest <= certificate.largest_extent(), "{largest}");
    if outcome.stop == StopReason::Finished {
        assert_eq!(bound, outcome.stats.found, "finished, so nothing is open");
        assert_eq!(certificate.open_pairs(), 0);
        assert_eq!(certificate.boxes().count(), 0);
    }
}
