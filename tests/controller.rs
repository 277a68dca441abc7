//! The cycle of `examples/controller` touches no allocator, whatever it finds.
#![cfg(feature = "std")]

#[path = "common/allocations.rs"]
mod allocations;
#[path = "../examples/controller/arms.rs"]
mod arms;

use std::time::Duration;

use allocations::allocator_calls;
use arms::Arms;
use punctual::{Budget, Verdict};

/// Once along the path for each budget: contacts, and triangle pairs that were left open.
fn drive(arms: &mut Arms) -> (usize, u64) {
    let (mut contacts, mut open) = (0, 0);
    for budget in [
        Budget::time(Duration::from_micros(200)),
        Budget::work(2_000),
        Budget::work(20_000),
    ] {
        for cycle in 0..1000 {
            arms.place(0.01 * f64::from(cycle)).unwrap();
            contacts += arms.scene.detect(budget).intersecting;
            let report = arms.scene.report();
            for pair in report
                .pairs
                .iter()
                .filter(|pair| pair.verdict == Verdict::Undecided)
            {
                open += arms.scene.certificate(pair.a, pair.b).unwrap().upper_bound;
            }
        }
    }
    (contacts, open)
}

#[test]
fn a_cycle_does_not_allocate() {
    let mut arms = Arms::new().unwrap();
    // So that buffers have their size.
    drive(&mut arms);
    let mut met = (0, 0);
    assert_eq!(allocator_calls(|| met = drive(&mut arms)), 0);
    let (contacts, open) = met;
    assert!(contacts > 0 && open > 0, "{contacts} contacts, {open} open");
}
