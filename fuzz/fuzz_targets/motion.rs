//! Any few triangles on any motion: nothing false at any stop, no contact before what is said to be free, and the same however
//! the way there was cut.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::clock::ManualClock;
use punctual::geom::triangles_intersect;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::impact::{Impact, TimeOfImpact};
use punctual::{Answer, Budget, Mesh, Motion, Pose, Query, StopReason, Tree, Workspace};
use punctual_fuzz::Numbers;

fn tree(bytes: &mut Unstructured) -> Result<Option<Tree>> {
    let numbers = Numbers::arbitrary(bytes)?;
    let vertices = (0..bytes.int_in_range(1..=6)?)
        .map(|_| numbers.point(bytes))
        .collect::<Result<Vec<_>>>()?;
    let last = vertices.len() as u32 - 1;
    let mut triangles = Vec::new();
    for _ in 0..bytes.int_in_range(1..=5)? {
        triangles.push([
            bytes.int_in_range(0..=last)?,
            bytes.int_in_range(0..=last)?,
            bytes.int_in_range(0..=last)?,
        ]);
    }
    Ok(Mesh::from_f64(vertices, triangles).ok().map(Tree::new))
}

fn pose(bytes: &mut Unstructured) -> Result<Pose> {
    let [x, y, z] = Numbers::Fraction.point(bytes)?;
    let turn = if bytes.arbitrary()? {
        DQuat::IDENTITY
    } else {
        DQuat::from_xyzw(x, y, z, 0.7).normalize()
    };
    let place = Numbers::arbitrary(bytes)?.point(bytes)?;
    Ok(Pose::new(DMat3::from_quat(turn), DVec3::from_array(place)).unwrap_or(Pose::IDENTITY))
}

fn motion(bytes: &mut Unstructured) -> Result<Motion> {
    let (start, numbers) = (pose(bytes)?, Numbers::arbitrary(bytes)?);
    let still = Motion::straight(start, [0.0; 3]);
    let motion = match bytes.int_in_range(0..=3)? {
        0 => Motion::straight(start, numbers.point(bytes)?),
        1 => Motion::turning(
            start,
            numbers.point(bytes)?,
            Numbers::Whole.point(bytes)?,
            numbers.point(bytes)?,
        ),
        2 => Motion::screw(start, pose(bytes)?),
        // A frame of a body that turns.
        _ => {
            let small = |v: [f64; 3]| v.map(|x| x / 32.0);
            let (velocity, turn) = (
                small(numbers.point(bytes)?),
                small(Numbers::Fraction.point(bytes)?),
            );
            Motion::turning(start, velocity, turn, numbers.point(bytes)?)
        }
    };
    Ok(motion
        .or(still)
        .unwrap_or_else(|_| Motion::straight(Pose::IDENTITY, [0.0; 3]).expect("it stands still")))
}

fn meet(a: &Tree, b: &Tree, pose: &Pose) -> bool {
    let placed = |j| b.mesh().triangle(j).map(|v| pose.transform_point(v));
    (0..a.mesh().len()).any(|i| {
        (0..b.mesh().len()).any(|j| triangles_intersect(&a.mesh().triangle(i), &placed(j)))
    })
}

fn assert_sound(query: &Query<Impact>, [a, b]: [&Tree; 2], said: &Answer<TimeOfImpact>) {
    assert!(
        (0.0..=1.0).contains(&said.value.lower)
            && said.value.upper.is_none_or(|time| time >= said.value.lower)
    );
    for i in 0..16 {
        let time = said.value.lower * f64::from(i) / 16.0;
        assert!(
            time >= said.value.lower || !meet(a, b, &query.pose(time)),
            "they meet at {time}: {said:?}"
        );
    }
    assert!(
        said.value
            .upper
            .is_none_or(|time| meet(a, b, &query.pose(time))),
        "{said:?}"
    );
}

fn ask(bytes: &mut Unstructured) -> Result<()> {
    let (Some(a), Some(b)) = (tree(bytes)?, tree(bytes)?) else {
        return Ok(());
    };
    let mut query = Query::impact(&a, &b, motion(bytes)?);
    if bytes.ratio(1, 4)? {
        query = Query::impact_of_both([&a, &b], [motion(bytes)?, motion(bytes)?]);
    }
    if bytes.ratio(1, 3)? {
        query = query.tolerance(Numbers::arbitrary(bytes)?.read(bytes)?);
    }
    let mut workspace = Workspace::with_capacity(bytes.int_in_range(0..=64)?, 1);
    let (clock, enough) = (ManualClock::new(), Budget::work(20_000_000));
    let whole = query.run(&mut workspace, enough.clock(&clock));
    assert_sound(&query, [&a, &b], &whole);
    if matches!(
        whole.stop,
        StopReason::FlushedToZero | StopReason::WorkLimit
    ) {
        return Ok(());
    }
    let piece = Budget::work(u64::from(bytes.arbitrary::<u16>()?) + whole.stats.work / 64);
    let mut said = query.run(&mut workspace, piece.clock(&clock));
    while said.stop == StopReason::WorkLimit {
        assert_sound(&query, [&a, &b], &said);
        let more = query
            .resume(&mut workspace, piece.clock(&clock))
            .expect("the workspace holds a stopped run");
        assert!(said.value.lower <= more.value.lower, "{said:?} {more:?}");
        said = more;
    }
    assert_eq!(said, whole);
    Ok(())
}

fuzz_target!(|data: &[u8]| {
    let _ = ask(&mut Unstructured::new(data));
});
