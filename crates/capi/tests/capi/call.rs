//! Calls as C makes them, and handles to call with.

use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use punctual::glam::{DQuat, DVec3};
use punctual::tree::Solid;
use punctual::{BuildOptions, PairMemory, Pose, Tree, Workspace, shapes};
use punctual_capi::{punctual_status as Status, *};

pub fn last_error() -> String {
    // SAFETY: the text ends with a zero byte and is copied before the next call.
    unsafe { CStr::from_ptr(punctual_last_error()) }
        .to_str()
        .unwrap()
        .into()
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

#[track_caller]
pub fn works(status: Status) {
    assert_eq!(status, Status::Ok, "{}", last_error());
}

/// A struct of the caller's as C passes it.
pub fn asked<'p, T: 'p>(question: impl Into<Option<&'p T>>) -> *const T {
    question.into().map_or(null(), |question| question)
}

/// A place of the size of a struct that begins with it.
pub fn slot<T>(out: Option<&mut MaybeUninit<T>>) -> *mut T {
    out.map_or(null_mut(), |out| {
        // SAFETY: the struct is longer than its size.
        unsafe { out.as_mut_ptr().cast::<u32>().write(size_of::<T>() as u32) };
        out.as_mut_ptr()
    })
}

/// A place for one of what comes in arrays.
pub fn row<T>(out: Option<&mut MaybeUninit<T>>) -> *mut T {
    out.map_or(null_mut(), MaybeUninit::as_mut_ptr)
}

/// A struct as it is by default or as it is made, of the size that it has here.
fn begun<T>(init: impl FnOnce(*mut T, usize)) -> T {
    let mut made = MaybeUninit::uninit();
    init(made.as_mut_ptr(), size_of::<T>());
    // SAFETY: such a call writes as many bytes as it is told.
    unsafe { made.assume_init() }
}

/// What the header makes of each `_init`.
macro_rules! constructors {
    ($($new:ident($init:ident: $($argument:ident: $type:ty),*) -> $made:ty;)*) => {
        $(#[allow(clippy::extra_unused_lifetimes, reason = "only some of them borrow")]
        pub fn $new<'t>($($argument: $type),*) -> $made {
            // SAFETY: the place is as large as said.
            begun(|place, size| unsafe { $init(place, size, $($argument),*) })
        })*
    };
}

type Shape<'t> = Option<&'t punctual_tree>;

constructors! {
    punctual_build_options_default(punctual_build_options_init:) -> punctual_build_options;
    punctual_calibration_default(punctual_calibration_init:) -> punctual_calibration;
    punctual_query_new(punctual_query_init: a: Shape<'t>, b: Shape<'t>, pose: punctual_pose) -> punctual_query<'t>;
    punctual_distance_query_new(punctual_distance_query_init: a: Shape<'t>, b: Shape<'t>, pose: punctual_pose)
        -> punctual_distance_query<'t>;
    punctual_contact_query_new(punctual_contact_query_init: a: Shape<'t>, b: Shape<'t>, pose: punctual_pose)
        -> punctual_contact_query<'t>;
    punctual_near_points_query_new(punctual_near_points_query_init: a: Shape<'t>, b: Shape<'t>, pose: punctual_pose)
        -> punctual_near_points_query<'t>;
    punctual_manifold_query_new(punctual_manifold_query_init: a: Shape<'t>, b: Shape<'t>, pose: punctual_pose)
        -> punctual_manifold_query<'t>;
    punctual_penetration_query_new(punctual_penetration_query_init: a: Shape<'t>, b: Shape<'t>, pose: punctual_pose)
        -> punctual_penetration_query<'t>;
    punctual_motion_query_new(punctual_motion_query_init: a: Shape<'t>, b: Shape<'t>, motion: punctual_motion)
        -> punctual_motion_query<'t>;
    punctual_self_query_new(punctual_self_query_init: tree: Shape<'t>) -> punctual_self_query<'t>;
    punctual_ray_query_new(punctual_ray_query_init: tree: Shape<'t>, ray: punctual_ray) -> punctual_ray_query<'t>;
    punctual_ray_batch_new(punctual_ray_batch_init: tree: Shape<'t>, rays: *const punctual_ray, count: usize)
        -> punctual_ray_batch<'t>;
    punctual_body_new(punctual_body_init: tree: Shape<'t>, pose: punctual_pose) -> punctual_body<'t>;
    punctual_scene_shape_new(punctual_scene_shape_init: tree: Shape<'t>, motion: punctual_motion)
        -> punctual_scene_shape<'t>;
    punctual_scene_ray_new(punctual_scene_ray_init: ray: punctual_ray) -> punctual_scene_ray;
}

/// A handle.
#[track_caller]
pub fn owned<T>(call: impl FnOnce(Option<&mut MaybeUninit<Option<Box<T>>>>) -> Status) -> Box<T> {
    made(call).expect("a call that succeeds makes a handle")
}

/// Runs a question in C and in Rust within so much work, and resumes both to the end; compares the answers at each stop.
/// How often they stopped.
macro_rules! to_the_end {
    ($run:ident, $resume:ident, $query:expr, $native:expr, $work:expr, $workspace:ident, $other:ident
        $(, $memory:ident, $remembered:ident)?; $compare:expr) => {{
        let (query, native) = (&$query, $native);
        #[allow(unused_mut, reason = "some count")]
        let mut compare = $compare;
        let (ours, theirs) = (punctual_budget_work($work), punctual::Budget::work($work));
        // SAFETY: here and below, structs of the sizes that they say, and no clock of the caller's.
        let mut said = made(|out| unsafe {
            $run(asked(query), Some(&mut $workspace), $(Some(&mut $memory),)? ours, None, slot(out))
        });
        let mut told = native$(.with_memory(&mut $remembered))?.run(&mut $other, theirs);
        let mut stops = 0;
        loop {
            compare(&said, &told, &mut $workspace, &mut $other);
            assert_eq!(format!("{:?}", said.stop), format!("{:?}", told.stop));
            if matches!(told.stop, punctual::StopReason::Finished | punctual::StopReason::FirstHit) {
                break;
            }
            stops += 1;
            said = made(|out| unsafe {
                $resume(asked(query), Some(&mut $workspace), $(Some(&mut $memory),)? ours, None, slot(out))
            });
            told = native$(.with_memory(&mut $remembered))?.resume(&mut $other, theirs).unwrap();
        }
        let mut out = std::mem::MaybeUninit::uninit();
        let out = slot(Some(&mut out));
        let status = unsafe {
            $resume(asked(query), Some(&mut $workspace), $(Some(&mut $memory),)? ours, None, out)
        };
        assert_eq!(status, punctual_status::NotResumable);
        stops
    }};
}
pub(crate) use to_the_end;

/// Compares a certificate and its boxes with those of Rust.
macro_rules! same_certificate {
    ($certificate:ident, $boxes:ident, $query:expr, $workspace:expr, $expected:expr) => {{
        let (query, workspace, expected) = (asked($query), Some(&*$workspace), $expected);
        // SAFETY: here and below, structs of the sizes that they say, and room for three boxes.
        let told = made(|out| unsafe { $certificate(query, workspace, slot(out)) });
        let nowhere = punctual_aabb {
            min: NO_POINT,
            max: NO_POINT,
        };
        let mut boxes = [nowhere; 3];
        let count = made(|out| unsafe { $boxes(query, workspace, boxes.as_mut_ptr(), 3, out) });
        assert_eq!(count, expected.boxes().count());
        assert!(
            boxes
                .into_iter()
                .zip(expected.boxes())
                .all(|(ours, theirs)| ours == theirs.into())
        );
        assert_eq!(told, expected.into());
    }};
}
pub(crate) use same_certificate;

/// A table of calls that are refused, a row each: `call(...) => null "what";`, `call(...) => Status "text";`, or without a text.
macro_rules! refuses {
    ($($call:ident($($argument:expr),* $(,)?) => $kind:ident $($text:expr)?;)*) => {$({
        #[allow(unused_unsafe, reason = "only some take pointers")]
        // SAFETY: pointers are null, or good for the call; what is too long is refused before it is read.
        let status = unsafe { $call($($argument),*) };
        let text: &[String] = &[$(($text).to_string())?];
        crate::call::is_refused(stringify!($call), status, stringify!($kind), text);
    })*};
}
pub(crate) use refuses;

#[track_caller]
pub fn is_refused(call: &str, status: Status, kind: &str, text: &[String]) {
    let told = last_error();
    let name = if call.starts_with("punctual_") {
        call
    } else {
        "punctual_"
    };
    if kind != "null" {
        assert_eq!(format!("{status:?}"), kind, "{call}: {told}");
        assert!(text.iter().all(|text| told == *text), "{call}: {told}");
        return;
    }
    assert_eq!(status, Status::Null, "{call}: {told}");
    let end = format!(": {} is null", text[0]);
    assert!(
        told.starts_with(name) && told.ends_with(&end),
        "{call}: {told}"
    );
}

pub fn knot() -> Box<punctual_mesh> {
    owned(|mesh| punctual_shape_torus_knot(2, 3, 0.2, 96, mesh))
}

pub fn tree_of(mesh: &punctual_mesh) -> Box<punctual_tree> {
    owned(|tree| unsafe { punctual_tree_new(Some(mesh), asked(None), tree) })
}

/// The tree of a knot in C and in Rust.
pub fn knots() -> (Box<punctual_tree>, Tree) {
    (
        tree_of(&knot()),
        Tree::new(shapes::torus_knot(2, 3, 0.2, 96)),
    )
}

/// The same as solids.
pub fn solid_knots() -> (Box<punctual_tree>, Tree) {
    let options = BuildOptions::default().solid(Solid::Keep);
    let theirs = Tree::with_options(shapes::torus_knot(2, 3, 0.2, 96), &options);
    (solid_of(&knot()), theirs)
}

pub fn workspaces() -> (Box<punctual_workspace>, Workspace) {
    (owned(|out| punctual_workspace_new(out)), Workspace::new())
}

pub fn memories() -> (Box<punctual_memory>, PairMemory) {
    (owned(|out| punctual_memory_new(out)), PairMemory::new())
}

/// The tree of a mesh that is a solid.
pub fn solid_of(mesh: &punctual_mesh) -> Box<punctual_tree> {
    let options = punctual_build_options {
        solid: punctual_solid::Keep as usize,
        ..Default::default()
    };
    // SAFETY: the options are one.
    owned(|tree| unsafe { punctual_tree_new(Some(mesh), asked(Some(&options)), tree) })
}

/// A query without memory, by the clock of the system.
pub fn run(
    query: &punctual_query,
    workspace: Option<&mut punctual_workspace>,
    budget: punctual_budget,
    outcome: Option<&mut MaybeUninit<punctual_outcome>>,
) -> Status {
    // SAFETY: no clock of the caller's.
    unsafe {
        punctual_query_run(
            asked(Some(query)),
            workspace,
            None,
            budget,
            None,
            slot(outcome),
        )
    }
}

/// A frame by the clock of the system.
pub fn detect(
    scene: Option<&mut punctual_scene>,
    budget: punctual_budget,
    report: Option<&mut MaybeUninit<punctual_report>>,
) -> Status {
    // SAFETY: no clock of the caller's.
    unsafe { punctual_scene_detect(scene, budget, None, slot(report)) }
}

pub fn tilted() -> Pose {
    Pose::from_quat(
        DQuat::from_xyzw(0.1, -0.7, 0.3, 0.4),
        DVec3::new(0.4, 0.3, 0.2),
    )
    .unwrap()
}

pub fn raw(pose: &Pose) -> punctual_pose {
    punctual_pose {
        m: pose.to_row_major(),
    }
}

/// A body id that no scene has given out.
pub const NOBODY: punctual_body_id = punctual_body_id {
    index: 7,
    generation: 3,
    scene: 0,
};

pub const NO_POINT: punctual_point = punctual_point {
    x: 0.0,
    y: 0.0,
    z: 0.0,
};
