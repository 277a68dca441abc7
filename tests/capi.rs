//! The C interface, called as C calls it: every null pointer, length and number that is refused, with status and text; and
//! the answers of the Rust interface, field by field.
#![cfg(feature = "capi")]

#[path = "common/allocations.rs"]
mod allocations;
mod common;

use std::ffi::{CStr, c_void};
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use std::time::Duration;

use allocations::allocator_calls;
use common::{MODES, ORDERS};
use punctual::capi::*;
use punctual::glam::{DMat3, DQuat, DVec3, Vec3};
use punctual::{
    Body, Budget, BuildOptions, CostModel, Filter, ManualClock, Mode, Order, PairMemory, Pose, Query, Reach, Scene,
    StopReason, Tree, Verdict, Workspace, shapes,
};
use std::sync::Arc;

type Status = punctual_status;

fn last_error() -> String {
    // SAFETY: the text ends with a zero byte and is copied before the next call.
    unsafe { CStr::from_ptr(punctual_last_error()) }.to_str().unwrap().into()
}

/// What a call writes, if it succeeds.
#[track_caller]
fn made<T>(call: impl FnOnce(Option<&mut MaybeUninit<T>>) -> Status) -> T {
    let mut out = MaybeUninit::uninit();
    let status = call(Some(&mut out));
    assert_eq!(status, Status::Ok, "{}", last_error());
    // SAFETY: a call that succeeds has written its output.
    unsafe { out.assume_init() }
}

/// A handle.
#[track_caller]
fn owned<T>(call: impl FnOnce(Option<&mut MaybeUninit<Option<Box<T>>>>) -> Status) -> Box<T> {
    made(call).expect("a call that succeeds makes a handle")
}

#[track_caller]
fn fails(status: Status, expected: Status, text: &str) {
    assert_eq!((status, last_error().as_str()), (expected, text));
}

#[track_caller]
fn null_is_seen(status: Status, what: &str) {
    assert_eq!(status, Status::Null);
    let text = last_error();
    assert!(text.starts_with("punctual_") && text.ends_with(&format!(": {what} is null")), "{text}");
}

fn knot() -> Box<punctual_mesh> {
    owned(|mesh| punctual_shape_torus_knot(2, 3, 0.2, 96, mesh))
}

fn tree_of(mesh: &punctual_mesh) -> Box<punctual_tree> {
    owned(|tree| punctual_tree_new(Some(mesh), None, tree))
}

fn tilted() -> Pose {
    Pose::from_quat(DQuat::from_xyzw(0.1, -0.7, 0.3, 0.4), DVec3::new(0.4, 0.3, 0.2)).unwrap()
}

fn raw(pose: &Pose) -> punctual_pose {
    punctual_pose { m: pose.to_row_major() }
}

/// A body id that no scene has given out.
const NOBODY: punctual_body_id = punctual_body_id { index: 7, generation: 3 };

const NO_POINT: punctual_point = punctual_point { x: 0.0, y: 0.0, z: 0.0 };

#[test]
fn null_is_refused_by_name() {
    let mesh = knot();
    let tree = tree_of(&mesh);
    let pose = punctual_pose_identity();
    let triangle = punctual_triangle { corners: [[0.0; 3]; 3] };
    let (vertices, corners) = ([0.0; 3], [0; 3]);
    let handle = "the place for the new handle";
    // SAFETY: null or as long as said.
    unsafe {
        null_is_seen(punctual_mesh_new_f32(null(), 1, corners.as_ptr(), 1, None), "vertices");
        null_is_seen(punctual_mesh_new_f32([0.0; 3].as_ptr(), 1, null(), 1, None), "triangles");
        null_is_seen(punctual_mesh_new_f32([0.0; 3].as_ptr(), 1, corners.as_ptr(), 1, None), handle);
        null_is_seen(punctual_mesh_new_f64(null(), 1, corners.as_ptr(), 1, None), "vertices");
        null_is_seen(punctual_mesh_new_f64(vertices.as_ptr(), 1, null(), 1, None), "triangles");
        null_is_seen(punctual_mesh_new_f64(vertices.as_ptr(), 1, corners.as_ptr(), 1, None), handle);
        null_is_seen(punctual_tree_refit_f32(None, null(), 0), "tree");
        null_is_seen(punctual_tree_refit_f32(None, null(), 1), "vertices");
        null_is_seen(punctual_tree_refit_f64(None, null(), 0), "tree");
        null_is_seen(punctual_tree_refit_f64(None, null(), 1), "vertices");
        null_is_seen(punctual_tree_to_bytes(None, null_mut(), 0, None), "tree");
        null_is_seen(punctual_tree_to_bytes(Some(&tree), null_mut(), 0, None), "count");
        null_is_seen(punctual_tree_to_bytes(Some(&tree), null_mut(), 1, Some(&mut MaybeUninit::uninit())), "bytes");
        null_is_seen(punctual_tree_from_bytes(null(), 1, None), "bytes");
        null_is_seen(punctual_tree_from_bytes(null(), 0, None), handle);
        null_is_seen(punctual_tree_levels(None, null_mut(), 0, None), "tree");
        null_is_seen(punctual_tree_levels(Some(&tree), null_mut(), 0, None), "count");
        let mut count = MaybeUninit::uninit();
        null_is_seen(punctual_tree_levels(Some(&tree), null_mut(), 1, Some(&mut count)), "levels");
    }
    null_is_seen(punctual_mesh_describe(None, None), "mesh");
    null_is_seen(punctual_mesh_describe(Some(&mesh), None), "facts");
    null_is_seen(punctual_mesh_indices(None, None), "mesh");
    null_is_seen(punctual_mesh_indices(Some(&mesh), None), "indices");
    null_is_seen(punctual_mesh_vertex(None, 0, None), "mesh");
    null_is_seen(punctual_mesh_vertex(Some(&mesh), 0, None), "vertex");
    null_is_seen(punctual_shape_icosphere(0, None), handle);
    null_is_seen(punctual_shape_cuboid(1.0, 1.0, 1.0, 1, None), handle);
    null_is_seen(punctual_shape_torus(1.0, 0.3, 3, None), handle);
    null_is_seen(punctual_shape_torus_knot(2, 3, 0.1, 40, None), handle);
    null_is_seen(punctual_shape_gear(3, 1, None), handle);
    null_is_seen(punctual_shape_height_field(1, 1, None), handle);
    null_is_seen(punctual_pose_from_quaternion(0.0, 0.0, 0.0, 1.0, NO_POINT, None), "pose");
    null_is_seen(punctual_pose_compose(pose, pose, None), "pose");
    null_is_seen(punctual_pose_inverse(pose, None), "pose");
    null_is_seen(punctual_triangles_intersect(triangle, triangle, None), "intersect");
    null_is_seen(punctual_tree_new(None, None, None), "mesh");
    null_is_seen(punctual_tree_new(Some(&mesh), None, None), handle);
    null_is_seen(punctual_tree_mesh(None, None), "tree");
    null_is_seen(punctual_tree_mesh(Some(&tree), None), handle);
    null_is_seen(punctual_tree_describe(None, None), "tree");
    null_is_seen(punctual_tree_describe(Some(&tree), None), "facts");
    null_is_seen(punctual_tree_validate(None), "tree");
    null_is_seen(punctual_workspace_new(None), handle);
    null_is_seen(punctual_workspace_with_capacity(1, 1, None), handle);
    null_is_seen(punctual_workspace_use_portable_kernels(None), "workspace");
    null_is_seen(punctual_workspace_pairs(None, None, None), "workspace");
    null_is_seen(punctual_workspace_drain_pairs(None), "workspace");
    null_is_seen(punctual_memory_new(None), handle);
    null_is_seen(punctual_memory_describe(None, None), "memory");
    punctual_mesh_free(None);
    punctual_tree_free(None);
    punctual_workspace_free(None);
    punctual_memory_free(None);
    punctual_scene_free(None);
    punctual_mesh_free(Some(mesh));
    punctual_tree_free(Some(tree));
}

#[test]
fn null_is_refused_by_queries() {
    let tree = tree_of(&knot());
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let memory = owned(|out| punctual_memory_new(out));
    let budget = punctual_budget_unlimited();
    let query = punctual_query_new(Some(&tree), Some(&tree), punctual_pose_identity());
    let (no_a, no_b) = (punctual_query { a: None, ..query }, punctual_query { b: None, ..query });
    let no_clock = punctual_clock { now: None, context: null_mut() };
    let mut out = MaybeUninit::uninit();
    null_is_seen(punctual_query_run(None, None, None, budget, None, None), "query");
    null_is_seen(punctual_query_run(Some(&no_a), None, None, budget, None, None), "query->a");
    null_is_seen(punctual_query_run(Some(&no_b), None, None, budget, None, None), "query->b");
    null_is_seen(punctual_query_run(Some(&query), None, None, budget, None, None), "outcome");
    null_is_seen(punctual_query_run(Some(&query), None, None, budget, None, Some(&mut out)), "workspace");
    let status = punctual_query_run(Some(&query), Some(&mut workspace), None, budget, Some(&no_clock), Some(&mut out));
    null_is_seen(status, "clock->now");
    null_is_seen(punctual_query_resume(None, None, None, budget, None, None), "query");
    null_is_seen(punctual_query_certificate(None, None, None), "query");
    null_is_seen(punctual_query_certificate(Some(&query), None, None), "certificate");
    null_is_seen(punctual_query_certificate(Some(&query), None, Some(&mut MaybeUninit::uninit())), "workspace");
    // SAFETY: nothing but null.
    unsafe {
        null_is_seen(punctual_query_open_boxes(None, None, null_mut(), 0, None), "query");
        null_is_seen(punctual_query_open_boxes(Some(&query), None, null_mut(), 0, None), "count");
        let count = &mut MaybeUninit::uninit();
        null_is_seen(punctual_query_open_boxes(Some(&query), None, null_mut(), 0, Some(count)), "workspace");
        made(|outcome| {
            punctual_query_run(Some(&query), Some(&mut workspace), None, punctual_budget_work(0), None, outcome)
        });
        null_is_seen(punctual_query_open_boxes(Some(&query), Some(&workspace), null_mut(), 1, Some(count)), "boxes");
    }
    null_is_seen(punctual_query_predict(None, None, None), "query");
    null_is_seen(punctual_query_predict(Some(&query), None, None), "prediction");
    null_is_seen(punctual_query_estimate(None, None, None, None), "query");
    null_is_seen(punctual_query_estimate(Some(&query), None, None, None), "estimate");
    null_is_seen(punctual_query_estimate(Some(&query), None, None, Some(&mut MaybeUninit::uninit())), "workspace");
    let costs = punctual_cost_model { bv_test: 1.0, triangle_test: 1.0, box_update: 1.0, setup: 1.0 };
    null_is_seen(punctual_memory_set_cost_model(None, costs), "memory");
    let costs = punctual_cost_model { setup: f64::NAN, ..costs };
    let text = "punctual_memory_set_cost_model: a cost is NaN, which is not finite or too large";
    fails(punctual_memory_set_cost_model(None, costs), Status::BadArgument, text);
    null_is_seen(punctual_workspace_pairs(Some(&workspace), None, None), "pairs");
    null_is_seen(punctual_workspace_pairs(Some(&workspace), Some(&mut MaybeUninit::uninit()), None), "count");
    null_is_seen(punctual_memory_describe(Some(&memory), None), "facts");
}

#[test]
fn null_and_strangers_are_refused_by_scenes() {
    let tree = tree_of(&knot());
    let mut scene = owned(|scene| punctual_scene_new(0, 0, scene));
    let pose = punctual_pose_identity();
    let body = punctual_body_new(Some(&tree), pose);
    let budget = punctual_budget_unlimited();
    null_is_seen(punctual_scene_new(0, 0, None), "the place for the new handle");
    null_is_seen(punctual_scene_use_threads(None, 1), "scene");
    null_is_seen(punctual_scene_insert(None, None, None), "body");
    null_is_seen(punctual_scene_insert(None, Some(&body), None), "id");
    null_is_seen(punctual_scene_insert(None, Some(&body), Some(&mut MaybeUninit::uninit())), "scene");
    let without = punctual_body { tree: None, ..body };
    null_is_seen(punctual_scene_insert(Some(&mut scene), Some(&without), None), "body->tree");
    null_is_seen(punctual_scene_remove(None, NOBODY), "scene");
    null_is_seen(punctual_scene_body(None, NOBODY, None), "body");
    null_is_seen(punctual_scene_body(None, NOBODY, Some(&mut MaybeUninit::uninit())), "scene");
    null_is_seen(punctual_scene_tree(None, NOBODY, None), "scene");
    null_is_seen(punctual_scene_set_pose(None, NOBODY, pose), "scene");
    null_is_seen(punctual_scene_set_tree(None, NOBODY, None), "tree");
    null_is_seen(punctual_scene_set_filter(None, NOBODY, 1, 1), "scene");
    null_is_seen(punctual_scene_set_importance(None, NOBODY, 1.0), "scene");
    null_is_seen(punctual_scene_detect(None, budget, None, None), "scene");
    let no_clock = punctual_clock { now: None, context: null_mut() };
    null_is_seen(punctual_scene_detect(Some(&mut scene), budget, Some(&no_clock), None), "clock->now");
    null_is_seen(punctual_scene_report(None, None), "scene");
    null_is_seen(punctual_scene_report(Some(&scene), None), "report");
    null_is_seen(punctual_scene_pair(None, NOBODY, NOBODY, None, None), "scene");
    null_is_seen(punctual_scene_pair(Some(&scene), NOBODY, NOBODY, None, None), "pair");
    let mut pair = MaybeUninit::uninit();
    null_is_seen(punctual_scene_pair(Some(&scene), NOBODY, NOBODY, Some(&mut pair), None), "listed");
    null_is_seen(punctual_scene_certificate(None, NOBODY, NOBODY, None), "scene");
    null_is_seen(punctual_scene_certificate(Some(&scene), NOBODY, NOBODY, None), "certificate");
    // SAFETY: nothing but null.
    unsafe {
        null_is_seen(punctual_scene_refit_f32(None, NOBODY, null(), 0), "scene");
        null_is_seen(punctual_scene_refit_f32(None, NOBODY, null(), 1), "vertices");
        null_is_seen(punctual_scene_refit_f64(None, NOBODY, null(), 0), "scene");
        null_is_seen(punctual_scene_refit_f64(None, NOBODY, null(), 1), "vertices");
        null_is_seen(punctual_scene_bodies(None, null_mut(), 0, None), "scene");
        null_is_seen(punctual_scene_bodies(Some(&scene), null_mut(), 0, None), "count");
    }

    let calls: [(&str, Status); 10] = [
        ("remove", punctual_scene_remove(Some(&mut scene), NOBODY)),
        ("body", punctual_scene_body(Some(&scene), NOBODY, Some(&mut MaybeUninit::uninit()))),
        ("tree", punctual_scene_tree(Some(&scene), NOBODY, Some(&mut MaybeUninit::uninit()))),
        ("set_pose", punctual_scene_set_pose(Some(&mut scene), NOBODY, pose)),
        ("set_tree", punctual_scene_set_tree(Some(&mut scene), NOBODY, Some(&tree))),
        ("set_filter", punctual_scene_set_filter(Some(&mut scene), NOBODY, 1, 1)),
        ("set_importance", punctual_scene_set_importance(Some(&mut scene), NOBODY, 1.0)),
        // SAFETY: no vertices.
        ("refit", unsafe { punctual_scene_refit_f32(Some(&mut scene), NOBODY, null(), 0) }),
        ("pair", punctual_scene_pair(Some(&scene), NOBODY, NOBODY, Some(&mut pair), Some(&mut MaybeUninit::uninit()))),
        ("certificate", punctual_scene_certificate(Some(&scene), NOBODY, NOBODY, Some(&mut MaybeUninit::uninit()))),
    ];
    for (name, status) in calls {
        assert_eq!(status, Status::NoSuchBody, "{name}");
    }
    assert!(last_error().ends_with("body 7 (generation 3) is not in the scene"));
}

#[test]
fn numbers_out_of_range_are_named() {
    let mesh = knot();
    let tree = tree_of(&mesh);
    let (vertices, corners) = ([0.0f64; 4], [0u32; 6]);
    let mut place = MaybeUninit::uninit();
    // SAFETY: what is too long or odd is refused before it is read.
    unsafe {
        let status = punctual_mesh_new_f64(vertices.as_ptr(), usize::MAX / 8, corners.as_ptr(), 1, Some(&mut place));
        let text = "punctual_mesh_new_f64: vertices is longer than memory or not aligned";
        fails(status, Status::BadArgument, text);
        let odd = vertices.as_ptr().cast::<u8>().add(1).cast();
        fails(punctual_mesh_new_f64(odd, 1, corners.as_ptr(), 1, Some(&mut place)), Status::BadArgument, text);
        let nan = [f32::NAN; 3];
        let status = punctual_mesh_new_f32(nan.as_ptr(), 1, corners.as_ptr(), 1, Some(&mut place));
        fails(status, Status::BadMesh, "punctual_mesh_new_f32: vertex 0 is not finite along axis 0");
    }
    let options = punctual_build_options { effort: 3, ..punctual_build_options_default() };
    let status = punctual_tree_new(Some(&mesh), Some(&options), Some(&mut MaybeUninit::uninit()));
    fails(status, Status::BadArgument, "punctual_tree_new: options->effort has no value 3");
    for (queue, pairs) in [(usize::MAX, 1), (1, usize::MAX), (usize::MAX / 32, usize::MAX / 16)] {
        let status = punctual_workspace_with_capacity(queue, pairs, Some(&mut MaybeUninit::uninit()));
        fails(status, Status::OutOfMemory, "punctual_workspace_with_capacity: there is not that much memory");
    }
    let triangle = |x| punctual_triangle { corners: [[0.0; 3], [0.0, x, 0.0], [0.0; 3]] };
    for (x, text) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (2.0 * 2f64.powi(1000), "2143")] {
        let status = punctual_triangles_intersect(triangle(0.0), triangle(x), Some(&mut MaybeUninit::uninit()));
        assert_eq!(status, Status::BadArgument);
        let start = format!("punctual_triangles_intersect: a coordinate of b is {text}");
        assert!(last_error().starts_with(&start), "{}", last_error());
    }
    let status = punctual_pose_from_quaternion(0.0, 0.0, 0.0, 0.0, NO_POINT, Some(&mut MaybeUninit::uninit()));
    fails(status, Status::BadPose, "punctual_pose_from_quaternion: quaternion is zero or not finite");

    let mut workspace = owned(|out| punctual_workspace_new(out));
    let query = punctual_query_new(Some(&tree), Some(&tree), punctual_pose_identity());
    let mut run = |query: punctual_query, budget| {
        let out = &mut MaybeUninit::uninit();
        punctual_query_run(Some(&query), Some(&mut workspace), None, budget, None, Some(out))
    };
    let unlimited = punctual_budget_unlimited();
    let name = "punctual_query_run";
    fails(
        run(punctual_query { mode: 2, ..query }, unlimited),
        Status::BadArgument,
        &format!("{name}: query->mode has no value 2"),
    );
    fails(
        run(punctual_query { order: 6, ..query }, unlimited),
        Status::BadArgument,
        &format!("{name}: query->order has no value 6"),
    );
    let status = run(punctual_query { grain: f32::NAN, ..query }, unlimited);
    fails(status, Status::BadArgument, &format!("{name}: query->grain is NaN, which is not finite or too large"));
    let odd = punctual_budget { kind: 3, ..unlimited };
    fails(run(query, odd), Status::BadArgument, &format!("{name}: budget.kind has no value 3"));
    let mut b_in_a = punctual_pose_identity();
    b_in_a.m[7] = f64::INFINITY;
    let status = run(punctual_query { b_in_a, ..query }, unlimited);
    fails(status, Status::BadPose, &format!("{name}: entry 7 of the pose [R|t], row by row, is not finite"));

    fails(punctual_scene_new(2, 0, None), Status::BadArgument, "punctual_scene_new: mode has no value 2");
    fails(punctual_scene_new(0, 2, None), Status::BadArgument, "punctual_scene_new: reach has no value 2");
    let mut scene = owned(|scene| punctual_scene_new(0, 0, scene));
    let status = punctual_scene_use_threads(Some(&mut scene), 2000);
    fails(status, Status::BadArgument, "punctual_scene_use_threads: threads is 2000, possible are 1024");
    let body = punctual_body_new(Some(&tree), punctual_pose_identity());
    let mut insert = |body| punctual_scene_insert(Some(&mut scene), Some(&body), Some(&mut MaybeUninit::uninit()));
    let name = "punctual_scene_insert";
    let status = insert(punctual_body { kind: 2, ..body });
    fails(status, Status::BadArgument, &format!("{name}: body->kind has no value 2"));
    let status = insert(punctual_body { importance: f32::NAN, ..body });
    fails(status, Status::BadArgument, &format!("{name}: body 0 (generation 0): the importance is not a number"));
    b_in_a.m[7] = 2f64.powi(995);
    let status = insert(punctual_body { pose: b_in_a, ..body });
    fails(status, Status::BadPose, &format!("{name}: body 0 (generation 0): translation along axis 1 exceeds 2^990"));
    assert_eq!(made(|report| punctual_scene_detect(Some(&mut scene), unlimited, None, report)).pair_count, 0);
}

fn same(ours: &punctual_outcome, theirs: &punctual::Outcome) {
    let (verdict, witness) = match theirs.verdict {
        Verdict::Undecided => (punctual_verdict::Undecided, [0; 2]),
        Verdict::Separated => (punctual_verdict::Separated, [0; 2]),
        Verdict::Intersecting { witness } => (punctual_verdict::Intersecting, witness),
    };
    let stop = match theirs.stop {
        StopReason::Finished => punctual_stop_reason::Finished,
        StopReason::FirstHit => punctual_stop_reason::FirstHit,
        StopReason::Deadline => punctual_stop_reason::Deadline,
        StopReason::WorkLimit => punctual_stop_reason::WorkLimit,
        StopReason::PairsFull => punctual_stop_reason::PairsFull,
    };
    assert_eq!(
        (ours.verdict, [ours.witness.a, ours.witness.b], ours.stop, ours.found),
        (verdict, witness, stop, theirs.found)
    );
    let (x, y) = (ours.stats, theirs.stats);
    assert_eq!([x.bv_tests, x.primitive_tests, x.exact_tests], [y.bv_tests, y.primitive_tests, y.exact_tests]);
    assert_eq!((x.work, x.queue_peak, x.bv_tests_per_level), (y.work, y.queue_peak, y.bv_tests_per_level));
    assert_eq!(x.elapsed, y.elapsed.map_or(-1, |time| time.as_nanos() as i64));
}

/// The number that stands for each order in C.
fn number(order: Order) -> (u32, u64) {
    match order {
        Order::Penetration => (0, 0),
        Order::LowAlpha => (1, 0),
        Order::OverlapVolume => (2, 0),
        Order::DepthFirst => (3, 0),
        Order::BreadthFirst => (4, 0),
        Order::Random(seed) => (5, seed),
        _ => unreachable!(),
    }
}

unsafe extern "C" fn tick(context: *mut c_void) -> u64 {
    // SAFETY: the context is a number that nobody else uses.
    let now = unsafe { &mut *context.cast::<u64>() };
    *now += 700;
    *now
}

/// Every mode, order, budget and option, stopped and resumed: the outcome, the pairs, the certificate and the memory are those
/// of Rust.
#[test]
fn queries_answer_as_in_rust() {
    let (ours, theirs) = (tree_of(&knot()), Tree::new(shapes::torus_knot(2, 3, 0.2, 96)));
    let pose = tilted();
    let mut workspace = owned(|workspace| punctual_workspace_with_capacity(32, 40, workspace));
    let mut other = Workspace::with_capacity(32, 40);
    for (mode, order) in MODES.into_iter().flat_map(|mode| ORDERS.map(|order| (mode, order))) {
        let (number, seed) = number(order);
        let mode_number = u32::from(mode == Mode::All);
        let mut query = punctual_query_new(Some(&ours), Some(&ours), raw(&pose));
        (query.mode, query.order, query.seed) = (mode_number, number, seed);
        (query.pair_limit, query.poll_interval, query.grain, query.prior) = (30, 1000, 64.0, 0.2);
        let native = Query::new(&theirs, &theirs, pose).mode(mode).order(order);
        let native = native.pair_limit(30).poll_interval(1000).grain(64.0).prior(0.2);
        let budgets = [
            (punctual_budget_work(3_000), Budget::work(3_000)),
            (punctual_budget_time(5_000), Budget::time(Duration::from_nanos(5_000))),
            (punctual_budget_unlimited(), Budget::unlimited()),
        ];
        let (mut memory, mut remembered) = (owned(|out| punctual_memory_new(out)), PairMemory::new());
        let [bv_test, triangle_test, box_update, setup] = [0.5, 8.0, 30.0, 200.0];
        let costs = punctual_cost_model { bv_test, triangle_test, box_update, setup };
        assert_eq!(punctual_memory_set_cost_model(Some(&mut memory), costs), Status::Ok);
        remembered.set_cost_model(CostModel { bv_test, triangle_test, box_update, setup });
        for (budget, native_budget) in budgets {
            let mut time = 0u64;
            let clock = punctual_clock { now: Some(tick), context: (&raw mut time).cast() };
            let native_clock = ManualClock::ticking(Duration::from_nanos(700));
            let mut outcome = made(|outcome| {
                let memory = Some(&mut *memory);
                punctual_query_run(Some(&query), Some(&mut workspace), memory, budget, Some(&clock), outcome)
            });
            let mut expected = native.run_with(&mut other, Some(&mut remembered), native_budget, &native_clock);
            loop {
                same(&outcome, &expected);
                let (mut pairs, mut count) = (MaybeUninit::uninit(), MaybeUninit::uninit());
                let status = punctual_workspace_pairs(Some(&workspace), Some(&mut pairs), Some(&mut count));
                assert_eq!(status, Status::Ok);
                // SAFETY: written, and not used again meanwhile.
                let pairs = unsafe { std::slice::from_raw_parts(pairs.assume_init(), count.assume_init()) };
                assert!(pairs.iter().map(|pair| [pair.a, pair.b]).eq(other.pairs().iter().copied()));

                let open = made(|open| punctual_query_certificate(Some(&query), Some(&workspace), open));
                let certificate = native.certificate(&other).unwrap();
                assert_eq!((open.open_pairs, open.upper_bound), (certificate.open_pairs(), certificate.upper_bound()));
                assert_eq!(open.largest_extent, certificate.largest_extent());
                let mut boxes = vec![punctual_aabb { min: NO_POINT, max: NO_POINT }; 3];
                let count = made(|count| {
                    // SAFETY: there is room for three.
                    unsafe { punctual_query_open_boxes(Some(&query), Some(&workspace), boxes.as_mut_ptr(), 3, count) }
                });
                assert_eq!(count, open.open_pairs);
                for (ours, theirs) in boxes.iter().zip(certificate.boxes()) {
                    assert_eq!([ours.min.x, ours.max.z], [theirs.min.x, theirs.max.z]);
                }

                let prediction = made(|out| punctual_query_predict(Some(&query), Some(&memory), out));
                let estimate = made(|out| punctual_query_estimate(Some(&query), Some(&workspace), Some(&memory), out));
                let expectation = native.predict(Some(&remembered));
                let left = native.estimate(&other, Some(&remembered)).unwrap();
                assert_eq!([estimate.probability, estimate.recall], [left.probability, left.recall]);
                for (ours, theirs) in [(prediction, expectation), (estimate.remaining, left.remaining)] {
                    assert_eq!(
                        [ours.bv_tests.p10, ours.triangle_tests.p50],
                        [theirs.bv_tests.p10, theirs.triangle_tests.p50]
                    );
                    assert_eq!([ours.work.p90, ours.time.p50], [theirs.work.p90, theirs.time_ns.p50]);
                }

                let facts = made(|facts| punctual_memory_describe(Some(&memory), facts));
                assert_eq!(facts.last_verdict, remembered.last_verdict().map_or(-1, i32::from));
                assert_eq!(facts.last_bv_tests, remembered.last_bv_tests().map_or(-1, |tests| tests as i64));
                assert_eq!(facts.frames_undecided, remembered.frames_undecided());

                if matches!(expected.stop, StopReason::Finished | StopReason::FirstHit) {
                    break;
                }
                assert_eq!(punctual_workspace_drain_pairs(Some(&mut workspace)), Status::Ok);
                drop(other.drain_pairs());
                let native_clock = ManualClock::ticking(Duration::from_nanos(700));
                outcome = made(|outcome| {
                    let memory = Some(&mut *memory);
                    punctual_query_resume(Some(&query), Some(&mut workspace), memory, budget, Some(&clock), outcome)
                });
                expected = native.resume_with(&mut other, Some(&mut remembered), native_budget, &native_clock).unwrap();
            }
            let status = punctual_query_resume(
                Some(&query),
                Some(&mut workspace),
                None,
                budget,
                None,
                Some(&mut MaybeUninit::uninit()),
            );
            let text =
                "punctual_query_resume: the workspace does not hold a run of this query (same trees, pose and options)";
            fails(status, Status::NotResumable, text);
        }
    }
}

#[test]
fn the_portable_kernels_give_the_same_bits() {
    let tree = tree_of(&knot());
    let mut query = punctual_query_new(Some(&tree), Some(&tree), raw(&tilted()));
    query.mode = punctual_mode::All as u32;
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let mut run = || {
        let unlimited = punctual_budget_unlimited();
        made(|outcome| punctual_query_run(Some(&query), Some(&mut workspace), None, unlimited, None, outcome))
    };
    let fast = run();
    assert_eq!(punctual_workspace_use_portable_kernels(Some(&mut workspace)), Status::Ok);
    let mut run = || {
        let unlimited = punctual_budget_unlimited();
        made(|outcome| punctual_query_run(Some(&query), Some(&mut workspace), None, unlimited, None, outcome))
    };
    assert_eq!(run(), fast);
}

#[test]
fn meshes_trees_and_poses_are_those_of_rust() {
    let natives = [
        (owned(|mesh| punctual_shape_icosphere(2, mesh)), shapes::icosphere(2)),
        (owned(|mesh| punctual_shape_cuboid(1.0, 2.0, 3.0, 4, mesh)), shapes::cuboid(Vec3::new(1.0, 2.0, 3.0), 4)),
        (owned(|mesh| punctual_shape_torus(1.0, 0.3, 16, mesh)), shapes::torus(1.0, 0.3, 16)),
        (knot(), shapes::torus_knot(2, 3, 0.2, 96)),
        (owned(|mesh| punctual_shape_gear(9, 2, mesh)), shapes::gear(9, 2)),
        (owned(|mesh| punctual_shape_height_field(8, 3, mesh)), shapes::height_field(8, 3)),
    ];
    for (mesh, native) in natives {
        let facts = made(|facts| punctual_mesh_describe(Some(&mesh), facts));
        assert_eq!(
            (facts.triangles, facts.vertices, facts.bytes),
            (native.len(), native.vertex_count(), native.bytes())
        );
        assert_eq!([facts.bounds.min.x, facts.bounds.max.z], [native.aabb().min.x, native.aabb().max.z]);
        let last = made(|vertex| punctual_mesh_vertex(Some(&mesh), native.vertex_count() - 1, vertex));
        assert_eq!(DVec3::new(last.x, last.y, last.z), native.vertex(native.vertex_count() - 1));
        let indices = made(|indices| punctual_mesh_indices(Some(&mesh), indices));
        // SAFETY: three for each triangle of a mesh that is still there.
        let indices = unsafe { std::slice::from_raw_parts(indices, 3 * native.len()) };
        assert_eq!(indices, native.triangles().as_flattened());

        let options = punctual_build_options { effort: punctual_effort::Fast as u32, frames: 0, threads: 2 };
        let tree = owned(|tree| punctual_tree_new(Some(&mesh), Some(&options), tree));
        let mut fast = BuildOptions::fast_build();
        fast.frames = false;
        let mut native = Tree::with_options(native, &fast);
        let (facts, stats) = (made(|facts| punctual_tree_describe(Some(&tree), facts)), native.stats());
        assert_eq!([facts.triangles, facts.nodes, facts.clusters], [stats.triangles, stats.nodes, stats.clusters]);
        assert_eq!((facts.depth, facts.bytes, facts.degradation), (stats.depth, stats.bytes(), 1.0));
        assert_eq!(punctual_tree_validate(Some(&tree)), Status::Ok);
        let mut levels = vec![punctual_tree_level { nodes: 0, alpha: [0.0; 3] }; stats.depth];
        // SAFETY: there is room for as many as said.
        let count = made(|count| unsafe { punctual_tree_levels(Some(&tree), levels.as_mut_ptr(), stats.depth, count) });
        assert_eq!(count, stats.depth);
        for (level, (&nodes, alpha)) in levels.iter().zip(stats.nodes_per_level.iter().zip(&stats.alpha_per_level)) {
            assert_eq!((level.nodes, level.alpha), (nodes, alpha.to_array()));
        }

        let mut tree = tree;
        let moved =
            |factor: f64| (0..facts_of(&tree).vertices).map(|i| stats_vertex(&tree, i) * factor).collect::<Vec<_>>();
        let (twice, thrice) = (moved(2.0), moved(1.0 / 3.0));
        let narrow: Vec<[f32; 3]> = twice.iter().map(|v| v.as_vec3().to_array()).collect();
        let wide: Vec<[f64; 3]> = thrice.iter().map(|v| v.to_array()).collect();
        // SAFETY: as long as said.
        let status = unsafe { punctual_tree_refit_f32(Some(&mut tree), narrow.as_ptr().cast(), narrow.len()) };
        assert_eq!(status, Status::Ok);
        native.refit(&narrow).unwrap();
        // SAFETY: as long as said.
        let status = unsafe { punctual_tree_refit_f64(Some(&mut tree), wide.as_ptr().cast(), wide.len()) };
        assert_eq!(status, Status::Ok);
        native.refit_f64(&wide).unwrap();
        assert_eq!(facts_of(&tree).is_f32, native.mesh().is_f32());
        assert_eq!(stats_vertex(&tree, 0), native.mesh().vertex(0));
        let facts = made(|facts| punctual_tree_describe(Some(&tree), facts));
        assert_eq!(facts.degradation, native.degradation());
    }

    let place = punctual_point { x: 0.4, y: 0.3, z: 0.2 };
    let pose = made(|pose| punctual_pose_from_quaternion(0.1, -0.7, 0.3, 0.4, place, pose));
    assert_eq!(pose, raw(&tilted()));
    assert_eq!(made(|out| punctual_pose_inverse(pose, out)), raw(&tilted().inverse().unwrap()));
    assert_eq!(made(|out| punctual_pose_compose(pose, pose, out)), raw(&tilted().compose(&tilted()).unwrap()));
}

fn bytes_of(tree: &punctual_tree, capacity: usize) -> (Vec<u8>, usize) {
    let mut bytes = vec![0xa5; capacity];
    // SAFETY: there is room for as many as said.
    let count = made(|count| unsafe { punctual_tree_to_bytes(Some(tree), bytes.as_mut_ptr(), capacity, count) });
    (bytes, count)
}

#[test]
fn the_bytes_of_trees_are_those_of_rust_and_damaged_ones_are_refused() {
    let ours = tree_of(&knot());
    let native = Tree::new(shapes::torus_knot(2, 3, 0.2, 96));
    let file = native.to_bytes();
    let (written, count) = bytes_of(&ours, file.len());
    assert!(written == file && count == file.len());
    let (start, count) = bytes_of(&ours, 100);
    assert!(start == file[..100] && count == file.len());
    let (rest, count) = bytes_of(&ours, file.len() + 1);
    assert!(rest.ends_with(&[0xa5]) && count == file.len(), "nothing is written beyond the last");

    fn load(bytes: &[u8], tree: Option<&mut MaybeUninit<Option<Box<punctual_tree>>>>) -> Status {
        // SAFETY: as long as said.
        unsafe { punctual_tree_from_bytes(bytes.as_ptr(), bytes.len(), tree) }
    }
    let loaded = owned(|tree| load(&file, tree));
    assert_eq!(bytes_of(&loaded, file.len()).0, file);
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let mut answer = |tree: &punctual_tree| {
        let mut query = punctual_query_new(Some(tree), Some(tree), raw(&tilted()));
        query.mode = punctual_mode::All as u32;
        let enough = punctual_budget_work(u64::MAX);
        made(|outcome| punctual_query_run(Some(&query), Some(&mut workspace), None, enough, None, outcome))
    };
    assert_eq!(answer(&loaded), answer(&ours));

    let refused = |bytes: &[u8], text: &str| {
        let mut place = MaybeUninit::new(None);
        fails(load(bytes, Some(&mut place)), Status::BadFile, &format!("punctual_tree_from_bytes: {text}"));
        // SAFETY: it had a value, which a call that fails leaves.
        assert!(unsafe { place.assume_init() }.is_none());
    };
    let mut damaged = file.clone();
    damaged[200] ^= 4;
    for bytes in [&damaged[..], &file[..60], &[], b"a letter"] {
        refused(bytes, &Tree::from_bytes(bytes).unwrap_err().to_string());
    }
    refused(b"a letter", "these bytes are no tree: they do not begin with PUNCTREE");
    refused(&[], "the tree should have 52 bytes, but has 0");
}

fn facts_of(tree: &punctual_tree) -> punctual_mesh_facts {
    let mesh = owned(|mesh| punctual_tree_mesh(Some(tree), mesh));
    made(|facts| punctual_mesh_describe(Some(&mesh), facts))
}

fn stats_vertex(tree: &punctual_tree, index: usize) -> DVec3 {
    let mesh = owned(|mesh| punctual_tree_mesh(Some(tree), mesh));
    let point = made(|vertex| punctual_mesh_vertex(Some(&mesh), index, vertex));
    DVec3::new(point.x, point.y, point.z)
}

/// Bodies that move, are refitted, filtered and removed: every report, pair and certificate is that of Rust.
#[test]
fn scenes_answer_as_in_rust() {
    let (ours, theirs) = (tree_of(&knot()), Arc::new(Tree::new(shapes::torus_knot(2, 3, 0.2, 96))));
    let place = |i: u32, frame: u32| {
        let turn = DMat3::from_rotation_z(f64::from(i + frame) * 0.3);
        Pose::new(turn, DVec3::new(0.9 * f64::from(i % 4), f64::from(i / 4) + 0.02 * f64::from(frame), 0.0)).unwrap()
    };
    let mut scene = owned(|scene| punctual_scene_new(punctual_mode::All as u32, punctual_reach::Way as u32, scene));
    let mut native = Scene::new().mode(Mode::All).reach(Reach::Way);
    assert_eq!(punctual_scene_use_threads(Some(&mut scene), 2), Status::Ok);
    let mut ids = Vec::new();
    for i in 0..12 {
        let mut body = punctual_body_new(Some(&ours), raw(&place(i, 0)));
        (body.kind, body.importance) = (u32::from(i < 2), i as f32);
        let id = made(|id| punctual_scene_insert(Some(&mut scene), Some(&body), id));
        let body = if i < 2 { Body::fixed } else { Body::moving };
        ids.push((id, native.insert(body(Arc::clone(&theirs), place(i, 0)).with_importance(i as f32)).unwrap()));
        assert_eq!(id.index as usize, ids[ids.len() - 1].1.index());
    }
    let narrow: Vec<[f32; 3]> =
        (0..theirs.mesh().vertex_count()).map(|i| (theirs.mesh().vertex(i).as_vec3() * 1.25).to_array()).collect();
    let wide: Vec<[f64; 3]> =
        (0..theirs.mesh().vertex_count()).map(|i| (theirs.mesh().vertex(i) / 3.0).to_array()).collect();
    let mut undecided = 0;
    for frame in 0..24 {
        for (i, &(id, native_id)) in (0..).zip(&ids).skip(2) {
            let pose = place(i, frame);
            assert_eq!(punctual_scene_set_pose(Some(&mut scene), id, raw(&pose)), Status::Ok);
            native.set_pose(native_id, pose).unwrap();
        }
        let (id, native_id) = ids[3];
        match frame {
            4 => {
                // SAFETY: as long as said.
                let status =
                    unsafe { punctual_scene_refit_f32(Some(&mut scene), id, narrow.as_ptr().cast(), narrow.len()) };
                assert_eq!(status, Status::Ok);
                native.tree_mut(native_id).unwrap().refit(&narrow).unwrap();
            }
            8 => {
                // SAFETY: as long as said.
                let status =
                    unsafe { punctual_scene_refit_f64(Some(&mut scene), id, wide.as_ptr().cast(), wide.len()) };
                assert_eq!(status, Status::Ok);
                native.tree_mut(native_id).unwrap().refit_f64(&wide).unwrap();
                let shared = owned(|tree| punctual_scene_tree(Some(&scene), id, tree));
                assert_eq!(stats_vertex(&shared, 5), native.body(native_id).unwrap().tree().mesh().vertex(5));
            }
            12 => {
                assert_eq!(punctual_scene_set_tree(Some(&mut scene), id, Some(&ours)), Status::Ok);
                native.set_tree(native_id, Arc::clone(&theirs)).unwrap();
                assert_eq!(punctual_scene_set_filter(Some(&mut scene), ids[4].0, 2, 6), Status::Ok);
                native.set_filter(ids[4].1, Filter { groups: 2, mask: 6 }).unwrap();
                assert_eq!(punctual_scene_set_importance(Some(&mut scene), ids[4].0, 9.0), Status::Ok);
                native.set_importance(ids[4].1, 9.0).unwrap();
                let body = made(|body| punctual_scene_body(Some(&scene), ids[4].0, body));
                assert_eq!((body.groups, body.mask, body.importance, body.kind), (2, 6, 9.0, 0));
                assert!(body.tree.is_none() && body.pose == raw(&place(4, frame)));
            }
            16 => {
                let (id, native_id) = ids.remove(5);
                assert_eq!(punctual_scene_remove(Some(&mut scene), id), Status::Ok);
                native.remove(native_id).unwrap();
            }
            _ => {}
        }
        let (budget, native_budget) = match frame % 3 {
            0 => (punctual_budget_work(u64::MAX), Budget::work(u64::MAX)),
            1 => (punctual_budget_work(30_000), Budget::work(30_000)),
            _ => (punctual_budget_work(300_000), Budget::work(300_000)),
        };
        let report = made(|report| punctual_scene_detect(Some(&mut scene), budget, None, report));
        let expected = native.detect_with(native_budget, &ManualClock::new());
        assert_eq!(
            (report.frame, report.decided, report.intersecting),
            (expected.frame, expected.decided, expected.intersecting)
        );
        assert_eq!((report.complete, report.worst_age), (expected.complete, expected.worst_age));
        assert_eq!((report.work, report.bv_tests, report.elapsed), (expected.work, expected.bv_tests, -1));
        undecided += expected.undecided();
        // SAFETY: the scene is not used meanwhile but to be read.
        let pairs = unsafe { std::slice::from_raw_parts(report.pairs, report.pair_count) };
        assert_eq!(pairs.len(), expected.pairs.len());
        for (pair, expected) in pairs.iter().zip(&native.report().pairs) {
            assert_eq!([pair.a.index as usize, pair.b.index as usize], [expected.a.index(), expected.b.index()]);
            let told = |found, complete, probability: f64, recall: f64, age| {
                (found, complete, probability.to_bits(), recall.to_bits(), age)
            };
            assert_eq!(
                told(pair.found, pair.complete, pair.probability, pair.recall, pair.age),
                told(expected.found, expected.complete, expected.probability, expected.recall, expected.age)
            );
            let verdict = match expected.verdict {
                Verdict::Undecided => (punctual_verdict::Undecided, [0; 2]),
                Verdict::Separated => (punctual_verdict::Separated, [0; 2]),
                Verdict::Intersecting { witness } => (punctual_verdict::Intersecting, witness),
            };
            assert_eq!((pair.verdict, [pair.witness.a, pair.witness.b]), verdict);
            let mut listed = MaybeUninit::uninit();
            let again = made(|again| punctual_scene_pair(Some(&scene), pair.b, pair.a, again, Some(&mut listed)));
            // SAFETY: written by the call.
            assert!(again == *pair && unsafe { listed.assume_init() });
            let open = made(|open| punctual_scene_certificate(Some(&scene), pair.a, pair.b, open));
            let certificate = native.certificate(expected.a, expected.b).unwrap();
            assert_eq!((open.upper_bound, open.largest_extent), (certificate.upper_bound, certificate.largest_extent));
        }
        assert_eq!(made(|report| punctual_scene_report(Some(&scene), report)).pairs, report.pairs);
    }
    assert!(undecided > 0, "no budget was too small");
    let mut listed = vec![NOBODY; 11];
    // SAFETY: there is room for eleven.
    let count = made(|count| unsafe { punctual_scene_bodies(Some(&scene), listed.as_mut_ptr(), 11, count) });
    assert_eq!(count, 11);
    assert!(listed.iter().eq(ids.iter().map(|(id, _)| id)));
    let (mut pair, mut is_listed) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    let status = punctual_scene_pair(Some(&scene), ids[0].0, ids[1].0, Some(&mut pair), Some(&mut is_listed));
    // SAFETY: written by the call.
    assert!(status == Status::Ok && !unsafe { is_listed.assume_init() }, "two fixed bodies are no pair");
    punctual_scene_free(Some(scene));
}

#[test]
fn triangles_meet_as_in_rust() {
    let a = punctual_triangle { corners: [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
    for (z, expected) in [(0.0, true), (5e-324, false)] {
        let b = punctual_triangle { corners: a.corners.map(|[x, y, _]| [x + 1.0, y, z]) };
        assert_eq!(made(|intersect| punctual_triangles_intersect(a, b, intersect)), expected);
    }
}

#[test]
fn a_cycle_does_not_allocate_even_if_it_fails() {
    let tree = tree_of(&knot());
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let mut memory = owned(|out| punctual_memory_new(out));
    let mut broken = raw(&tilted());
    broken.m[0] = f64::NAN;
    let calls = allocator_calls(|| {
        for budget in [punctual_budget_time(20_000), punctual_budget_work(5_000), punctual_budget_unlimited()] {
            for (pose, works) in [(raw(&tilted()), true), (broken, false)] {
                let query = punctual_query_new(Some(&tree), Some(&tree), pose);
                let (workspace, memory) = (Some(&mut *workspace), Some(&mut *memory));
                let out = &mut MaybeUninit::uninit();
                let status = punctual_query_run(Some(&query), workspace, memory, budget, None, Some(out));
                assert_eq!(status == Status::Ok, works);
            }
        }
    });
    assert_eq!(calls, 0);
}

#[test]
fn each_thread_has_its_own_last_error() {
    null_is_seen(punctual_tree_validate(None), "tree");
    std::thread::spawn(|| assert_eq!(last_error(), "")).join().unwrap();
    assert_eq!(last_error(), "punctual_tree_validate: tree is null");
    // SAFETY: the text ends with a zero byte.
    let version = unsafe { CStr::from_ptr(punctual_version()) };
    assert_eq!(version.to_str().unwrap(), env!("CARGO_PKG_VERSION"));
}

/// Handles may go from thread to thread, and be read by several.
#[test]
fn handles_may_change_threads() {
    fn send_and_sync<T: Send + Sync>() {}
    send_and_sync::<punctual_mesh>();
    send_and_sync::<punctual_tree>();
    send_and_sync::<punctual_workspace>();
    send_and_sync::<punctual_memory>();
    send_and_sync::<punctual_scene>();
}
