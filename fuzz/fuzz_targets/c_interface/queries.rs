//! Workspaces, memories and queries.

use super::World;
use super::call::{Call, any, asked as raw, begun};
use super::surfaces::{Grown, pose};
use libfuzzer_sys::arbitrary::{Result, Unstructured};
use punctual_capi::{punctual_status as Status, *};
use punctual_fuzz::reference;
use std::ffi::c_void;
use std::slice;

/// A workspace, and what the last run in it was.
pub struct Desk {
    pub workspace: Box<punctual_workspace>,
    run: Option<Run>,
}

/// A run, and all that it found.
struct Run {
    question: Question,
    outcome: punctual_outcome,
    drained: Vec<[u32; 2]>,
    truth: Vec<[u32; 2]>,
}

/// What must be the same for a query to be resumed.
#[derive(Clone, Copy, PartialEq)]
struct Question {
    versions: [u64; 2],
    b_in_a: punctual_pose,
    mode: u32,
    order: u32,
    pair_limit: usize,
}

/// What is asked: the trees by their places.
#[derive(Clone, Copy)]
struct Ask {
    trees: [usize; 2],
    query: punctual_query<'static>,
}

/// Moves by the context's second number whenever it is asked.
unsafe extern "C" fn tick(context: *mut c_void) -> u64 {
    // SAFETY: the context of `clock`.
    let [now, step] = unsafe { &mut *context.cast::<[u64; 2]>() };
    *now = now.saturating_add(*step);
    *now
}

/// A clock of the caller's, or now and then one without a function; none is the system's.
pub fn clock(
    call: &mut Call,
    bytes: &mut Unstructured,
    context: &mut [u64; 2],
) -> Result<Option<punctual_clock>> {
    if bytes.arbitrary()? {
        return Ok(None);
    }
    *context = [
        0,
        if bytes.arbitrary()? {
            300
        } else {
            bytes.arbitrary()?
        },
    ];
    let now = call.given(bytes, tick as unsafe extern "C" fn(*mut c_void) -> u64)?;
    Ok(Some(punctual_clock {
        now,
        context: std::ptr::from_mut(context).cast(),
    }))
}

/// A budget, and whether it is enough for anything.
pub fn budget(call: &mut Call, bytes: &mut Unstructured) -> Result<(punctual_budget, bool)> {
    let limit = if bytes.ratio(1, 8)? {
        bytes.arbitrary()?
    } else {
        bytes.int_in_range(0..=5000)?
    };
    let kind = call.value(bytes, 3)?;
    let poll_interval = if bytes.ratio(1, 8)? {
        bytes.arbitrary()?
    } else {
        PUNCTUAL_MAX_STEP_WORK
    };
    Ok((
        punctual_budget {
            limit,
            kind,
            poll_interval,
        },
        kind == punctual_budget_kind::Unlimited as u32,
    ))
}

/// One call of a query, or of what a query needs.
pub fn play(world: &mut World, bytes: &mut Unstructured) -> Result<()> {
    if world.desks.is_empty() || (world.desks.len() < 3 && bytes.ratio(1, 8)?) {
        furnish(world, bytes)?;
    }
    if world.memories.len() < 2 {
        let made = Call::default().own(bytes, |out| punctual_memory_new(out))?;
        world.memories.extend(made);
    }
    let Some(desk) = any(bytes, &world.desks)? else {
        return Ok(());
    };
    match bytes.int_in_range(0..=15)? {
        0 => {
            let desk = world.desks.swap_remove(desk);
            punctual_workspace_free(Some(desk.workspace));
        }
        1 => {
            let mut call = Call::default();
            let workspace = call.given(bytes, &mut *world.desks[desk].workspace)?;
            call.judge(punctual_workspace_use_portable_kernels(workspace));
        }
        2 => remember(world, bytes)?,
        3..=5 => drain(&mut world.desks[desk], bytes)?,
        6..=9 => ask(world, desk, bytes)?,
        10..=12 => again(world, desk, bytes)?,
        _ => left(world, desk, bytes)?,
    }
    Ok(())
}

fn furnish(world: &mut World, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let mut capacity = || {
        let huge = bytes.ratio(1, 64)?;
        call.fault(huge, Status::OutOfMemory);
        if huge {
            Ok(usize::MAX / bytes.int_in_range(1..=16)?)
        } else {
            bytes.int_in_range(0..=64)
        }
    };
    let (queue, pairs) = (capacity()?, capacity()?);
    let made = call.own(bytes, |out| {
        punctual_workspace_with_capacity(queue, pairs, out)
    })?;
    world.desks.extend(made.map(|workspace| Desk {
        workspace,
        run: None,
    }));
    Ok(())
}

fn remember(world: &mut World, bytes: &mut Unstructured) -> Result<()> {
    let Some(at) = any(bytes, &world.memories)? else {
        return Ok(());
    };
    let mut call = Call::default();
    let memory = call.given(bytes, &*world.memories[at])?;
    if let Some(facts) = call.fill(bytes, |out| unsafe {
        punctual_memory_describe(memory, out)
    })? {
        assert!((-1..=1).contains(&facts.last_verdict) && facts.last_bv_tests >= -1);
    }
    if bytes.arbitrary()? {
        let mut call = Call::default();
        let mut cost = || {
            if bytes.ratio(1, 16)? {
                Ok(f64::from_bits(bytes.arbitrary()?))
            } else {
                Ok(f64::from(bytes.arbitrary::<u8>()?))
            }
        };
        let costs = punctual_cost_model {
            size: size_of::<punctual_cost_model>() as u32,
            bv_test: cost()?,
            triangle_test: cost()?,
            box_update: cost()?,
            setup: cost()?,
        };
        let numbers = [
            costs.bv_test,
            costs.triangle_test,
            costs.box_update,
            costs.setup,
        ];
        call.fault(
            numbers.iter().any(|cost| !cost.is_finite()),
            Status::BadArgument,
        );
        let Some(desk) = world.desks.first_mut() else {
            return Ok(());
        };
        let workspace = call.given(bytes, &mut *desk.workspace)?;
        // SAFETY: of the size that it says.
        call.judge(unsafe { punctual_workspace_set_cost_model(workspace, &costs) });
    } else if bytes.ratio(1, 4)? {
        punctual_memory_free(Some(world.memories.swap_remove(at)));
    }
    Ok(())
}

/// The pairs in the workspace: true ones, each once, as many as the run says.
fn pairs(desk: &Desk, bytes: &mut Unstructured) -> Result<Option<Vec<[u32; 2]>>> {
    let mut call = Call::default();
    let workspace = call.given(bytes, &*desk.workspace)?;
    let mut first = std::mem::MaybeUninit::uninit();
    let place = call.given(bytes, &mut first)?;
    let Some(count) = call.make(bytes, |out| punctual_workspace_pairs(workspace, place, out))?
    else {
        return Ok(None);
    };
    // SAFETY: a call that succeeds has written its outputs, and the workspace is not used meanwhile.
    let pairs = unsafe { slice::from_raw_parts(first.assume_init(), count) };
    let pairs: Vec<[u32; 2]> = pairs.iter().map(|pair| [pair.a, pair.b]).collect();
    let Some(run) = &desk.run else {
        assert!(pairs.is_empty(), "pairs without a query");
        return Ok(Some(pairs));
    };
    let mut all = [&run.drained[..], &pairs[..]].concat();
    all.sort_unstable();
    assert!(
        all.windows(2).all(|two| two[0] != two[1]),
        "a pair was found twice"
    );
    assert!(
        all.iter().all(|pair| run.truth.binary_search(pair).is_ok()),
        "a false pair"
    );
    assert_eq!(run.outcome.found, all.len() as u64);
    if run.outcome.stop == punctual_stop_reason::Finished
        && run.question.mode == punctual_mode::All as u32
    {
        assert_eq!(all, run.truth);
    }
    Ok(Some(pairs))
}

fn drain(desk: &mut Desk, bytes: &mut Unstructured) -> Result<()> {
    let Some(found) = pairs(desk, bytes)? else {
        return Ok(());
    };
    let mut call = Call::default();
    let workspace = call.given(bytes, &mut *desk.workspace)?;
    if call.judge(punctual_workspace_drain_pairs(workspace))
        && let Some(run) = &mut desk.run
    {
        run.drained.extend(found);
    }
    pairs(desk, bytes).map(drop)
}

fn new_query(b_in_a: punctual_pose) -> punctual_query<'static> {
    // SAFETY: the place is as large as said.
    begun(|place, size| unsafe { punctual_query_init(place, size, None, None, b_in_a) })
}

/// A query between any two trees, with any options.
fn question(world: &World, call: &mut Call, bytes: &mut Unstructured) -> Result<Option<Ask>> {
    let (Some(a), Some(b)) = (any(bytes, &world.trees)?, any(bytes, &world.trees)?) else {
        return Ok(None);
    };
    let (b_in_a, valid) = pose(bytes)?;
    call.fault(valid.is_none(), Status::BadPose);
    let mut query = new_query(b_in_a);
    (query.mode, query.order) = (call.value(bytes, 2)?, call.value(bytes, 3)?);
    if bytes.arbitrary()? {
        query.pair_limit = if bytes.arbitrary()? {
            bytes.int_in_range(0..=4)?
        } else {
            bytes.arbitrary()?
        };
        query.prior = if bytes.ratio(1, 4)? {
            f64::from_bits(bytes.arbitrary()?)
        } else {
            0.5
        };
    }
    call.fault(query.prior.is_nan(), Status::BadArgument);
    Ok(Some(Ask {
        trees: [a, b],
        query,
    }))
}

impl Ask {
    fn of(&self, trees: &[Grown]) -> Question {
        let query = &self.query;
        Question {
            versions: self.trees.map(|at| trees[at].shape.version),
            b_in_a: query.b_in_a,
            mode: query.mode,
            order: query.order,
            pair_limit: query.pair_limit.max(1),
        }
    }

    /// With its trees, or now and then without one.
    fn with<'t>(
        &self,
        trees: &'t [Grown],
        call: &mut Call,
        bytes: &mut Unstructured,
    ) -> Result<punctual_query<'t>> {
        let [a, b] = self.trees.map(|at| &*trees[at].handle);
        Ok(punctual_query {
            a: call.given(bytes, a)?,
            b: call.given(bytes, b)?,
            ..self.query
        })
    }
}

fn ask(world: &mut World, desk: usize, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let Some(asked) = question(world, &mut call, bytes)? else {
        return super::surfaces::grow(world, bytes);
    };
    start(world, desk, &asked, call, bytes, false)
}

/// The question that the workspace holds, if its trees are there; or now and then another.
fn held(
    world: &World,
    desk: usize,
    call: &mut Call,
    bytes: &mut Unstructured,
) -> Result<Option<Ask>> {
    let Some(run) = world.desks[desk]
        .run
        .as_ref()
        .filter(|_| !bytes.ratio(1, 8).unwrap_or(false))
    else {
        return question(world, call, bytes);
    };
    let place = |version| {
        world
            .trees
            .iter()
            .position(|tree| tree.shape.version == version)
    };
    let [Some(a), Some(b)] = run.question.versions.map(place) else {
        return question(world, call, bytes);
    };
    let mut query = new_query(run.question.b_in_a);
    (query.mode, query.order) = (run.question.mode, run.question.order);
    query.pair_limit = run.question.pair_limit;
    Ok(Some(Ask {
        trees: [a, b],
        query,
    }))
}

fn again(world: &mut World, desk: usize, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let Some(asked) = held(world, desk, &mut call, bytes)? else {
        return Ok(());
    };
    let question = asked.of(&world.trees);
    let run = world.desks[desk]
        .run
        .as_ref()
        .filter(|run| run.question == question);
    let complete = [
        punctual_stop_reason::Finished,
        punctual_stop_reason::FirstHit,
    ];
    call.fault(
        run.is_none_or(|run| complete.contains(&run.outcome.stop)),
        Status::NotResumable,
    );
    start(world, desk, &asked, call, bytes, true)
}

fn start(
    world: &mut World,
    desk: usize,
    asked: &Ask,
    mut call: Call,
    bytes: &mut Unstructured,
    resume: bool,
) -> Result<()> {
    let World {
        trees,
        desks,
        memories,
        ..
    } = world;
    let desk = &mut desks[desk];
    let query = asked.with(trees, &mut call, bytes)?;
    let mut context = [0; 2];
    let clock = clock(&mut call, bytes, &mut context)?;
    let (budget, unlimited) = budget(&mut call, bytes)?;
    let memory = if bytes.arbitrary()? {
        memories.last_mut().map(|memory| &mut **memory)
    } else {
        None
    };
    let query = call.given(bytes, &query)?;
    let workspace = call.given(bytes, &mut *desk.workspace)?;
    let run = if resume {
        punctual_query_resume
    } else {
        punctual_query_run
    };
    // SAFETY: `context` outlives the call.
    let Some(outcome) = call.fill(bytes, |out| unsafe {
        run(raw(query), workspace, memory, budget, clock.as_ref(), out)
    })?
    else {
        // The workspace is as it was.
        return pairs(desk, bytes).map(drop);
    };
    let last = if resume { desk.run.take() } else { None };
    let (drained, truth) = last.map_or_else(
        || {
            let [a, b] = asked.trees.map(|at| &trees[at].shape.mesh);
            let b_in_a =
                punctual::Pose::from_row_major(asked.query.b_in_a.m).expect("the call took it");
            (Vec::new(), reference::all_pairs(a, b, &b_in_a))
        },
        |run| (run.drained, run.truth),
    );
    let witness = [outcome.witness.a, outcome.witness.b];
    match outcome.verdict {
        punctual_verdict::Within => panic!("a query without margins"),
        punctual_verdict::Contained => panic!("trees of surfaces"),
        punctual_verdict::Intersecting => {
            assert!(truth.binary_search(&witness).is_ok(), "a false witness")
        }
        punctual_verdict::Separated => assert!(truth.is_empty() && witness == [0; 2], "they meet"),
        punctual_verdict::Undecided => assert!(!unlimited && outcome.found == 0),
    }
    let full = outcome.stop == punctual_stop_reason::PairsFull;
    assert!(!unlimited || full || outcome.verdict as u32 == if truth.is_empty() { 2 } else { 1 });
    desk.run = Some(Run {
        question: asked.of(trees),
        outcome,
        drained,
        truth,
    });
    pairs(desk, bytes).map(drop)
}

/// What is open, and what is expected of it.
fn left(world: &World, desk: usize, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let Some(asked) = held(world, desk, &mut call, bytes)? else {
        return Ok(());
    };
    let World {
        trees,
        desks,
        memories,
        ..
    } = world;
    let memory = if bytes.arbitrary()? {
        memories.last().map(|memory| &**memory)
    } else {
        None
    };
    let desk = &desks[desk];
    let query = asked.with(trees, &mut call, bytes)?;
    let query = call.given(bytes, &query)?;
    if bytes.ratio(1, 4)? {
        if let Some(expected) = call.make(bytes, |out| unsafe {
            punctual_query_predict(raw(query), memory, out)
        })? {
            assert_ordered(&expected);
        }
        return Ok(());
    }
    let run = desk
        .run
        .as_ref()
        .filter(|run| run.question == asked.of(trees));
    call.fault(run.is_none(), Status::NotResumable);
    let workspace = call.given(bytes, &*desk.workspace)?;
    if bytes.ratio(1, 3)? {
        let Some(said) = call.fill(bytes, |out| unsafe {
            punctual_query_estimate(raw(query), workspace, memory, out)
        })?
        else {
            return Ok(());
        };
        assert_ordered(&said.remaining);
        let run = run.expect("the call took it");
        assert!(
            (0.0..=1.0).contains(&said.probability) && (0.0..=1.0).contains(&said.recall),
            "{said:?}"
        );
        match run.outcome.verdict {
            punctual_verdict::Intersecting
            | punctual_verdict::Within
            | punctual_verdict::Contained => {
                assert_eq!(said.probability, 1.0)
            }
            punctual_verdict::Separated => assert_eq!(said.probability, 0.0),
            punctual_verdict::Undecided => {}
        }
        return Ok(());
    }
    let Some(open) = call.fill(bytes, |out| unsafe {
        punctual_query_certificate(raw(query), workspace, out)
    })?
    else {
        return Ok(());
    };
    let run = run.expect("the call took it");
    assert!(open.upper_bound >= run.truth.len() as u64 && open.upper_bound >= run.outcome.found);
    if run.outcome.stop == punctual_stop_reason::Finished {
        assert_eq!((open.open_pairs, open.upper_bound), (0, run.outcome.found));
    }
    let mut call = Call::default();
    let mut boxes = Vec::<punctual_aabb>::with_capacity(bytes.int_in_range(0..=40)?);
    let (first, capacity) = call.array(bytes, boxes.as_mut_ptr(), boxes.capacity())?;
    // SAFETY: there is room for as many as said, or it is refused.
    let count = call.make(bytes, |out| unsafe {
        punctual_query_open_boxes(raw(query), workspace, first, capacity, out)
    })?;
    let Some(count) = count else { return Ok(()) };
    assert!(count <= open.open_pairs);
    // SAFETY: as many were written as there is room for.
    unsafe { boxes.set_len(count.min(capacity)) };
    for punctual_aabb { min, max } in boxes {
        let longest = (max.x - min.x).max(max.y - min.y).max(max.z - min.z);
        assert!(
            longest <= open.largest_extent,
            "{longest} is longer than {}",
            open.largest_extent
        );
    }
    Ok(())
}

fn assert_ordered(said: &punctual_prediction) {
    for each in [said.bv_tests, said.triangle_tests, said.work] {
        assert!(
            0.0 <= each.p10 && each.p10 <= each.p50 && each.p50 <= each.p90,
            "{said:?}"
        );
    }
}
