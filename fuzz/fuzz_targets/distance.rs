//! Any few triangles at any pose, asked anything about their distance: bounds are true at every stop and only close in, the
//! end is exact, and the same however the way there was cut.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::{Budget, ManualClock, Mesh, PairMemory, Pose, StopReason, Tree, Workspace};
use punctual_fuzz::distance::{ENOUGH, Question, Truth, run, run_with_memory};
use punctual_fuzz::{Numbers, moved};

fn tree(bytes: &mut Unstructured) -> Result<Option<Tree>> {
    let numbers = Numbers::arbitrary(bytes)?;
    let vertices = (0..bytes.int_in_range(1..=9)?).map(|_| numbers.point(bytes)).collect::<Result<Vec<_>>>()?;
    let last = vertices.len() as u32 - 1;
    let mut index = || bytes.int_in_range(0..=last);
    let mut triangles = Vec::new();
    for _ in 0..12 {
        triangles.push([index()?, index()?, index()?]);
    }
    triangles.truncate(bytes.int_in_range(1..=12)?);
    Ok(Mesh::from_f64(vertices, triangles).ok().map(Tree::new))
}

fn pose(bytes: &mut Unstructured) -> Result<Pose> {
    let [x, y, z] = Numbers::Fraction.point(bytes)?;
    let turn = if bytes.arbitrary()? { DQuat::IDENTITY } else { DQuat::from_xyzw(x, y, z, 0.7).normalize() };
    let mut turn = DMat3::from_quat(turn).to_cols_array();
    // Not quite a rotation.
    turn[bytes.int_in_range(0..=8)?] += if bytes.arbitrary()? { 2e-4 } else { 0.0 };
    let place = Numbers::arbitrary(bytes)?.point(bytes)?;
    Ok(Pose::new(DMat3::from_cols_array(&turn), DVec3::from_array(place)).unwrap_or(Pose::IDENTITY))
}

/// A length that is 0, of the size of the distance, or any.
fn length(truth: &Truth, bytes: &mut Unstructured) -> Result<f64> {
    let part = f64::from(bytes.arbitrary::<u16>()?) / 32768.0;
    Ok(match bytes.int_in_range(0..=3)? {
        0 => 0.0,
        1 => part * truth.distance(),
        2 => moved(truth.distance(), bytes.int_in_range(-3..=3)?).max(0.0),
        _ => Numbers::arbitrary(bytes)?.read(bytes)?.abs().min(1e300),
    })
}

fn question(truth: &Truth, bytes: &mut Unstructured) -> Result<Question> {
    let mut asked = Question::default();
    if bytes.arbitrary()? {
        asked.absolute = Some(length(truth, bytes)?);
    }
    if bytes.ratio(1, 4)? {
        asked.relative = length(truth, bytes)?;
    }
    if bytes.ratio(1, 3)? {
        asked.margins = [length(truth, bytes)?, length(truth, bytes)?];
    }
    if bytes.arbitrary()? {
        asked.closer_than = Some(length(truth, bytes)?);
    }
    Ok(asked)
}

fn ask(bytes: &mut Unstructured) -> Result<()> {
    let (Some(a), Some(b)) = (tree(bytes)?, tree(bytes)?) else { return Ok(()) };
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
        while said.stop == StopReason::WorkLimit {
            truth.assert_sound(&asked, &said);
            let resumed = query.resume_with(&mut workspace, Some(&mut memory), Budget::work(work.max(1)), &clock);
            let more = resumed.expect("the workspace holds a stopped run");
            assert!(said.low <= more.low && more.high <= said.high, "{said:?} {more:?}");
            said = more;
        }
        truth.assert_complete(&asked, &said);
        assert_eq!(run_with_memory(&query, &mut workspace, &mut copy, ENOUGH), said);
        truth.assert_complete(&asked, &run(&query, &mut workspace, ENOUGH));
    }
    Ok(())
}

fuzz_target!(|bytes: &[u8]| {
    let _ = ask(&mut Unstructured::new(bytes));
});
