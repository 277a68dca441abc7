//! The promise of a budget of work.

/// A budget of work is passed by less than a step of at most this work; a budget of nothing is kept.
#[track_caller]
pub fn assert_step(spent: u64, budget: u64, step: u64) {
    assert!(
        spent < budget + step && (budget > 0 || spent == 0),
        "{spent} of {budget}, where a step is at most {step}"
    );
}
