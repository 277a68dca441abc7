//! Any few triangles at any pose, asked anything about their distance: bounds are true at every stop and only close in, the
//! end is exact, and the same however the way there was cut.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::clock::ManualClock;
use punctual::contacts::Contact;
use punctual::{Budget, PairMemory, Pose, Query, StopReason, Tree, Workspace};
use punctual_fuzz::distance::{ENOUGH, Question, Truth, run, run_with_memory};
use punctual_fuzz::{assert_names, contacts, few_triangles, length, pose};

fn question(truth: &Truth, bytes: &mut Unstructured) -> Result<Question> {
    let mut asked = Question::default();
    if bytes.arbitrary()? {
        asked.absolute = Some(length(truth.distance(), bytes)?);
    }
    if bytes.ratio(1, 4)? {
        asked.relative = length(truth.distance(), bytes)?;
    }
    if bytes.ratio(1, 3)? {
        // Thicker ones count as 2^1000.
        let margin = |bytes: &mut Unstructured| Ok(length(truth.distance(), bytes)?.min(1e301));
        asked.margins = [margin(bytes)?, margin(bytes)?];
    }
    if bytes.arbitrary()? {
        asked.closer_than = Some(length(truth.distance(), bytes)?);
    }
    asked.contact_open = bytes.arbitrary()?;
    Ok(asked)
}

/// Those of triangles that are no farther apart than this.
fn contacts_within(a: &Tree, b: &Tree, pose: Pose, margin: f64) -> Vec<Contact> {
    let mut workspace = Workspace::new();
    if (0.0..f64::INFINITY).contains(&margin) {
        let _ = contacts::run(
            &Query::contacts(a, b, pose).margin(margin),
            &mut workspace,
            ENOUGH,
        );
    }
    contacts::listed(&workspace)
}

fn ask(bytes: &mut Unstructured) -> Result<()> {
    let (Some(a), Some(b)) = (few_triangles(bytes)?, few_triangles(bytes)?) else {
        return Ok(());
    };
    let pose = pose(bytes)?;
    let mut truth = Truth::new(&a, &b, &pose);
    let mut workspace = Workspace::with_capacity(bytes.int_in_range(0..=64)?, 1);
    let (mut memory, clock) = (PairMemory::new(), ManualClock::new());
    while !bytes.is_empty() {
        let asked = question(&truth, bytes)?;
        let query = asked.query(&a, &b, pose);
        let work = u64::from(bytes.arbitrary::<u16>()?) % 4096;
        let mut copy = memory.clone();
        let mut said = run_with_memory(&query, &mut workspace, &mut memory, Budget::work(work));
        let mut stops = 0;
        while said.stop == StopReason::WorkLimit {
            truth.assert_sound(&asked, &said);
            // To look through the boxes of a certificate takes far longer than the query.
            if let (Some(tolerance), [0.0, 0.0], 0..16) = (asked.absolute, asked.margins, stops) {
                let reach = match asked.closer_than {
                    Some(limit) => limit.min(said.value.high),
                    None => {
                        (said.value.high - tolerance).min(said.value.high / (1.0 + asked.relative))
                    }
                };
                let closer =
                    contacts_within(&a, &b, pose, reach - 1e-12 * reach - truth.rounding());
                let plain = query
                    .certificate(&workspace)
                    .expect("the workspace holds a stopped run");
                assert_names(&plain, 0, &closer);
            }
            let resumed = query
                .with_memory(&mut memory)
                .resume(&mut workspace, Budget::work(work.max(1)).clock(&clock));
            let more = resumed.expect("the workspace holds a stopped run");
            assert!(
                said.value.low <= more.value.low && more.value.high <= said.value.high,
                "{said:?} {more:?}"
            );
            (said, stops) = (more, stops + 1);
        }
        truth.assert_complete(&asked, &said);
        assert_eq!(
            run_with_memory(&query, &mut workspace, &mut copy, ENOUGH),
            said
        );
        truth.assert_complete(&asked, &run(&query, &mut workspace, ENOUGH));
    }
    Ok(())
}

fuzz_target!(|bytes: &[u8]| {
    let _ = ask(&mut Unstructured::new(bytes));
});
