//! Calls as C makes them, and handles to call with.

use std::ffi::CStr;
use std::mem::MaybeUninit;

use punctual::Pose;
use punctual::glam::{DQuat, DVec3};
use punctual_capi::{punctual_status as Status, *};

pub fn last_error() -> String {
    // SAFETY: the text ends with a zero byte and is copied before the next call.
    unsafe { CStr::from_ptr(punctual_last_error()) }.to_str().unwrap().into()
}

/// What a call writes, if it succeeds.
#[track_caller]
pub fn made<T>(call: impl FnOnce(Option<&mut MaybeUninit<T>>) -> Status) -> T {
    let mut out = MaybeUninit::uninit();
    let status = call(Some(&mut out));
    assert_eq!(status, Status::Ok, "{}", last_error());
    // SAFETY: a call that succeeds has written its output.
    unsafe { out.assume_init() }
}

/// A handle.
#[track_caller]
pub fn owned<T>(call: impl FnOnce(Option<&mut MaybeUninit<Option<Box<T>>>>) -> Status) -> Box<T> {
    made(call).expect("a call that succeeds makes a handle")
}

#[track_caller]
pub fn fails(status: Status, expected: Status, text: &str) {
    assert_eq!((status, last_error().as_str()), (expected, text));
}

#[track_caller]
pub fn null_is_seen(status: Status, what: &str) {
    assert_eq!(status, Status::Null);
    let text = last_error();
    assert!(text.starts_with("punctual_") && text.ends_with(&format!(": {what} is null")), "{text}");
}

pub fn knot() -> Box<punctual_mesh> {
    owned(|mesh| punctual_shape_torus_knot(2, 3, 0.2, 96, mesh))
}

pub fn tree_of(mesh: &punctual_mesh) -> Box<punctual_tree> {
    owned(|tree| punctual_tree_new(Some(mesh), None, tree))
}

/// A query without memory, by the clock of the system.
pub fn run(
    query: &punctual_query,
    workspace: Option<&mut punctual_workspace>,
    budget: punctual_budget,
    outcome: Option<&mut MaybeUninit<punctual_outcome>>,
) -> Status {
    // SAFETY: no clock of the caller's.
    unsafe { punctual_query_run(Some(query), workspace, None, budget, None, outcome) }
}

/// A frame by the clock of the system.
pub fn detect(
    scene: Option<&mut punctual_scene>,
    budget: punctual_budget,
    report: Option<&mut MaybeUninit<punctual_report>>,
) -> Status {
    // SAFETY: no clock of the caller's.
    unsafe { punctual_scene_detect(scene, budget, None, report) }
}

pub fn tilted() -> Pose {
    Pose::from_quat(DQuat::from_xyzw(0.1, -0.7, 0.3, 0.4), DVec3::new(0.4, 0.3, 0.2)).unwrap()
}

pub fn raw(pose: &Pose) -> punctual_pose {
    punctual_pose { m: pose.to_row_major() }
}

/// A body id that no scene has given out.
pub const NOBODY: punctual_body_id = punctual_body_id { index: 7, generation: 3, scene: 0 };

pub const NO_POINT: punctual_point = punctual_point { x: 0.0, y: 0.0, z: 0.0 };
