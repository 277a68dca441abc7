//! Any few triangles at any pose: no contact is false or lost at any stop, certificates name what is missing, plain and
//! narrowed, manifolds are what their fields say, and a push parts what it says it parts.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::clock::ManualClock;
use punctual::contacts::{Contact, Contacts};
use punctual::{Budget, PairMemory, Pose, Query, StopReason, Tree, Verdict, Workspace};
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
use punctual_fuzz::contacts::{ENOUGH, Truth, listed, resume, run};
use punctual_fuzz::{assert_names, few_triangles, length, pose};

fn whole(query: &Query<Contacts>) -> Vec<Contact> {
    let mut workspace = Workspace::new();
    let _ = run(query, &mut workspace, ENOUGH);
    listed(&workspace)
}

/// A query in pieces, the list drained when it is full.
fn ask(
    a: &Tree,
    b: &Tree,
    pose: Pose,
    truth: &mut Truth,
    bytes: &mut Unstructured,
) -> Result<Vec<Contact>> {
    let margin = length(truth.size, bytes)?;
    let query = Query::contacts(a, b, pose).margin(margin);
    let set = whole(&query);
    truth.assert_complete(margin, &set);
    let limit = usize::from(bytes.arbitrary::<u8>()?);
    let work = u64::from(bytes.arbitrary::<u16>()?) % 8192;
    let mut workspace = Workspace::with_capacity(bytes.int_in_range(0..=64)?, 1);
    let query = query.contact_limit(limit);
    let (mut said, mut found) = (run(&query, &mut workspace, Budget::work(work)), Vec::new());
    while said.stop != StopReason::Finished {
        let known: Vec<_> = found.iter().chain(workspace.contacts()).copied().collect();
        assert_eq!(said.stats.found, known.len() as u64);
        truth.assert_missing(&set, &known, said.value.low);
        let missing: Vec<_> = set
            .iter()
            .filter(|contact| !known.contains(contact))
            .copied()
            .collect();
        assert_names(
            &query.certificate(&workspace).expect("it is stopped"),
            said.stats.found,
            &missing,
        );
        if said.stop == StopReason::PairsFull {
            found.extend(workspace.drain_contacts());
        }
        let next = resume(&query, &mut workspace, Budget::work(work.max(1)));
        assert!(said.value.low <= next.value.low, "{said:?} {next:?}");
        said = next;
    }
    found.extend(workspace.drain_contacts());
    found.sort_by(|x, y| {
        x.distance
            .total_cmp(&y.distance)
            .then(x.triangles.cmp(&y.triangles))
    });
    assert_eq!(found, set);
    Ok(set)
}

fn assert_manifolds(
    a: &Tree,
    b: &Tree,
    pose: Pose,
    size: f64,
    memory: &mut PairMemory,
    bytes: &mut Unstructured,
) -> Result<()> {
    let skin = length(size, bytes)?;
    let query = Query::manifolds(a, b, pose).skin(skin);
    let (clock, mut workspace) = (ManualClock::new(), Workspace::new());
    let work = u64::from(bytes.arbitrary::<u16>()?);
    let _ = query
        .with_memory(memory)
        .run(&mut workspace, Budget::work(work).clock(&clock));
    let mut ids = Vec::new();
    for manifold in workspace.manifolds() {
        let length = manifold.normal.length();
        assert!(
            (length - 1.0).abs() < 1e-12 || length == 0.0,
            "{manifold:?}"
        );
        let points = manifold.points();
        assert!((1..=4).contains(&points.len()) && manifold.area >= 0.0);
        for point in points {
            assert!(point.distance <= skin, "{point:?}");
        }
        ids.push(manifold.id);
    }
    ids.sort_unstable();
    assert!(ids.is_sorted_by(|x, y| x < y), "an id is there twice");
    Ok(())
}

fn assert_push(a: &Tree, b: &Tree, pose: Pose, work: u64) {
    let query = PenetrationQuery::new(a, b, pose).push_only(work % 2 == 0);
    let clock = ManualClock::new();
    let budget = Budget::work(work).clock(&clock);
    let push = query.run(&mut PenetrationWorkspace::new(), budget).value;
    assert!(push.low <= push.high, "{push:?}");
    if let Some(direction) = push.direction {
        assert!(
            (direction.length() - 1.0).abs() < 1e-12 && push.high >= 0.0,
            "{push:?}"
        );
        let there = Query::intersection(a, b, push.b_in_a)
            .run(&mut Workspace::new(), ENOUGH.clock(&ManualClock::new()));
        assert_eq!(there.value, Verdict::Separated, "{push:?}");
    }
}

fn run_all(bytes: &mut Unstructured) -> Result<()> {
    let (Some(a), Some(b)) = (few_triangles(bytes)?, few_triangles(bytes)?) else {
        return Ok(());
    };
    let pose = pose(bytes)?;
    let mut truth = Truth::new(&a, &b, &pose);
    // Of all but equal distances to the corner and to the edge of a sliver either may be taken for the least.
    truth.off_slivers = 1e-8 * truth.size;
    let mut memory = PairMemory::new();
    while !bytes.is_empty() {
        ask(&a, &b, pose, &mut truth, bytes)?;
        assert_manifolds(&a, &b, pose, truth.size, &mut memory, bytes)?;
        assert_push(&a, &b, pose, bytes.arbitrary::<u32>()?.into());
    }
    Ok(())
}

fuzz_target!(|bytes: &[u8]| {
    let _ = run_all(&mut Unstructured::new(bytes));
});
