//! Every null pointer, length and number that is refused, with status and text.

use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use super::call::*;
use punctual_capi::{punctual_status as Status, *};

const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const HANDLE: &str = "the place for the new handle";

#[test]
fn null_is_refused_by_meshes_poses_and_triangles() {
    let mesh = knot();
    let pose = punctual_pose_identity();
    let triangle = punctual_triangle {
        corners: [[0.0; 3]; 3],
    };
    let (singles, doubles, corners) = ([0.0_f32; 3], [0.0_f64; 3], [0; 3]);
    let (narrow, wide, corner) = (singles.as_ptr(), doubles.as_ptr(), corners.as_ptr());
    refuses! {
        punctual_mesh_new_f32(null(), 1, corner, 1, None) => null "vertices";
        punctual_mesh_new_f32(narrow, 1, null(), 1, None) => null "triangles";
        punctual_mesh_new_f32(narrow, 1, corner, 1, None) => null HANDLE;
        punctual_mesh_new_f64(null(), 1, corner, 1, None) => null "vertices";
        punctual_mesh_new_f64(wide, 1, null(), 1, None) => null "triangles";
        punctual_mesh_new_f64(wide, 1, corner, 1, None) => null HANDLE;
    }
    refuses! {
        punctual_mesh_describe(None, slot(None)) => null "mesh";
        punctual_mesh_describe(Some(&mesh), slot(None)) => null "facts";
        punctual_mesh_indices(None, None) => null "mesh";
        punctual_mesh_indices(Some(&mesh), None) => null "indices";
        punctual_mesh_vertex(None, 0, None) => null "mesh";
        punctual_mesh_vertex(Some(&mesh), 0, None) => null "vertex";
        punctual_shape_icosphere(0, None) => null HANDLE;
        punctual_shape_cuboid(1.0, 1.0, 1.0, 1, None) => null HANDLE;
        punctual_shape_torus(1.0, 0.3, 3, None) => null HANDLE;
        punctual_shape_torus_knot(2, 3, 0.1, 40, None) => null HANDLE;
        punctual_shape_gear(3, 1, None) => null HANDLE;
        punctual_shape_height_field(1, 1, None) => null HANDLE;
        punctual_pose_from_quaternion(0.0, 0.0, 0.0, 1.0, NO_POINT, None) => null "pose";
        punctual_pose_compose(pose, pose, None) => null "pose";
        punctual_pose_inverse(pose, None) => null "pose";
        punctual_triangles_intersect(triangle, triangle, None) => null "intersect";
    }
}

#[test]
fn null_is_refused_by_trees() {
    let mesh = knot();
    let tree = tree_of(&mesh);
    let (nowhere, size) = (null_mut(), size_of::<punctual_tree_level>());
    let (mut count, mut other) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    refuses! {
        punctual_tree_refit_f32(None, null(), 0) => null "tree";
        punctual_tree_refit_f32(None, null(), 1) => null "vertices";
        punctual_tree_refit_f64(None, null(), 0) => null "tree";
        punctual_tree_refit_f64(None, null(), 1) => null "vertices";
        punctual_tree_to_bytes(None, null_mut(), 0, None) => null "tree";
        punctual_tree_to_bytes(Some(&tree), null_mut(), 0, None) => null "count";
        punctual_tree_to_bytes(Some(&tree), null_mut(), 1, Some(&mut other)) => null "bytes";
        punctual_mesh_read(null(), None) => null "path";
        punctual_mesh_read_bytes(null(), 1, 0, None) => null "bytes";
        punctual_mesh_read_bytes(OBJ.as_ptr(), OBJ.len(), 0, None) => null HANDLE;
        punctual_tree_from_bytes(null(), 1, None) => null "bytes";
        punctual_tree_levels(None, nowhere, size, 0, None) => null "tree";
        punctual_tree_levels(Some(&tree), nowhere, size, 0, None) => null "count";
        punctual_tree_levels(Some(&tree), nowhere, size, 1, Some(&mut count)) => null "levels";
    }
    refuses! {
        punctual_tree_new(None, asked(None), None) => null "mesh";
        punctual_tree_new(Some(&mesh), asked(None), None) => null HANDLE;
        punctual_tree_mesh(None, None) => null "tree";
        punctual_tree_mesh(Some(&tree), None) => null HANDLE;
        punctual_tree_describe(None, slot(None)) => null "tree";
        punctual_tree_describe(Some(&tree), slot(None)) => null "facts";
        punctual_tree_validate(None) => null "tree";
        punctual_tree_mass_properties(None, None) => null "tree";
        punctual_tree_mass_properties(Some(&tree), None)
            => BadMesh "punctual_tree_mass_properties: the tree was not built as a solid, see `BuildOptions::solid`";
    }
}

#[test]
fn null_is_refused_by_workspaces_and_memories() {
    let workspace = owned(|out| punctual_workspace_new(out));
    let memory = owned(|out| punctual_memory_new(out));
    refuses! {
        punctual_workspace_new(None) => null HANDLE;
        punctual_workspace_with_capacity(1, 1, None) => null HANDLE;
        punctual_workspace_use_portable_kernels(None) => null "workspace";
        punctual_workspace_pairs(None, None, None) => null "workspace";
        punctual_workspace_pairs(Some(&workspace), None, None) => null "pairs";
        punctual_workspace_pairs(Some(&workspace), Some(&mut MaybeUninit::uninit()), None)
            => null "count";
        punctual_workspace_drain_pairs(None) => null "workspace";
        punctual_memory_new(None) => null HANDLE;
        punctual_memory_describe(None, slot(None)) => null "memory";
        punctual_memory_describe(Some(&memory), slot(None)) => null "facts";
    }
    let costs = punctual_cost_model {
        bv_test: 1.0,
        ..Default::default()
    };
    refuses! {
        punctual_workspace_set_cost_model(None, asked(&costs)) => null "workspace";
    }
    let costs = punctual_cost_model {
        setup: f64::NAN,
        ..costs
    };
    refuses! {
        punctual_workspace_cost_model(Some(&workspace), slot(None)) => null "costs";
    }
    let text = "punctual_workspace_set_cost_model: a cost is NaN, which is not finite or too large";
    refuses! {
        punctual_workspace_set_cost_model(None, asked(&costs)) => BadArgument text;
    }
}

#[test]
fn null_may_be_freed() {
    punctual_mesh_free(None);
    punctual_tree_free(None);
    punctual_workspace_free(None);
    punctual_memory_free(None);
    punctual_scene_free(None);
    let mesh = knot();
    let tree = tree_of(&mesh);
    punctual_mesh_free(Some(mesh));
    punctual_tree_free(Some(tree));
}

#[test]
fn null_is_refused_by_queries() {
    let tree = tree_of(&knot());
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let budget = punctual_budget_unlimited();
    let query = punctual_query_new(Some(&tree), Some(&tree), punctual_pose_identity());
    let (no_a, no_b) = (
        punctual_query { a: None, ..query },
        punctual_query { b: None, ..query },
    );
    let no_clock = punctual_clock {
        now: None,
        context: null_mut(),
    };
    let mut out = MaybeUninit::uninit();
    refuses! {
        run(&no_a, None, budget, None) => null "query->a";
        run(&no_b, None, budget, None) => null "query->b";
        run(&query, None, budget, None) => null "outcome";
        run(&query, None, budget, Some(&mut out)) => null "workspace";
        punctual_query_certificate(asked(None), None, slot(None)) => null "query";
        punctual_query_certificate(asked(Some(&query)), None, slot(None)) => null "certificate";
        punctual_query_certificate(asked(Some(&query)), None, slot(Some(&mut MaybeUninit::uninit())))
            => null "workspace";
    }
    refuses! {
        punctual_query_run(asked(None), None, None, budget, None, slot(None)) => null "query";
    }
    let (workspace_there, clock) = (Some(&mut *workspace), Some(&no_clock));
    refuses! {
        punctual_query_run(asked(Some(&query)), workspace_there, None, budget, clock, slot(Some(&mut out)))
            => null "clock->now";
        punctual_query_resume(asked(None), None, None, budget, None, slot(None))
            => null "query";
        punctual_query_open_boxes(asked(None), None, null_mut(), 0, None) => null "query";
        punctual_query_open_boxes(asked(Some(&query)), None, null_mut(), 0, None)
            => null "count";
    }
    let count = &mut MaybeUninit::uninit();
    refuses! {
        punctual_query_open_boxes(asked(Some(&query)), None, null_mut(), 0, Some(count))
            => null "workspace";
    }
    made(|outcome| {
        run(
            &query,
            Some(&mut workspace),
            punctual_budget_work(0),
            outcome,
        )
    });
    refuses! {
        punctual_query_open_boxes(asked(Some(&query)), Some(&workspace), null_mut(), 1, Some(count))
            => null "boxes";
    }
    refuses! {
        punctual_query_predict(asked(None), None, None) => null "query";
        punctual_query_predict(asked(Some(&query)), None, None) => null "prediction";
        punctual_query_estimate(asked(None), None, None, slot(None)) => null "query";
        punctual_query_estimate(asked(Some(&query)), None, None, slot(None)) => null "estimate";
        punctual_query_estimate(asked(Some(&query)), None, None, slot(Some(&mut MaybeUninit::uninit())))
            => null "workspace";
    }
}

#[test]
fn null_is_refused_by_scenes() {
    let tree = tree_of(&knot());
    let mut scene = owned(|scene| punctual_scene_new(0, 0, scene));
    let pose = punctual_pose_identity();
    let body = punctual_body_new(Some(&tree), pose);
    let budget = punctual_budget_unlimited();
    refuses! {
        punctual_scene_new(0, 0, None) => null HANDLE;
        punctual_scene_use_threads(None, 1) => null "scene";
        punctual_scene_reserve(None, 1, 1) => null "scene";
        punctual_scene_insert(None, asked(None), None) => null "body";
        punctual_scene_insert(None, asked(Some(&body)), None) => null "id";
        punctual_scene_insert(None, asked(Some(&body)), Some(&mut MaybeUninit::uninit()))
            => null "scene";
    }
    let without = punctual_body { tree: None, ..body };
    refuses! {
        punctual_scene_insert(Some(&mut scene), asked(Some(&without)), None) => null "body->tree";
        punctual_scene_remove(None, NOBODY) => null "scene";
        punctual_scene_body(None, NOBODY, slot(None)) => null "body";
        punctual_scene_body(None, NOBODY, slot(Some(&mut MaybeUninit::uninit()))) => null "scene";
        punctual_scene_tree(None, NOBODY, None) => null "scene";
        punctual_scene_set_pose(None, NOBODY, pose) => null "scene";
        punctual_scene_set_tree(None, NOBODY, None) => null "scene";
        punctual_scene_set_tree(Some(&mut scene), NOBODY, None) => null "tree";
        punctual_scene_set_filter(None, NOBODY, 1, 1) => null "scene";
        punctual_scene_set_importance(None, NOBODY, 1.0) => null "scene";
        detect(None, budget, None) => null "scene";
        punctual_scene_report(None, slot(None)) => null "scene";
        punctual_scene_report(Some(&scene), slot(None)) => null "report";
        punctual_scene_pair(None, NOBODY, NOBODY, row(None), size_of::<punctual_pair_report>(), None)
            => null "scene";
        punctual_scene_pair(Some(&scene), NOBODY, NOBODY, row(None), size_of::<punctual_pair_report>(), None)
            => null "pair";
    }
    let mut pair = MaybeUninit::uninit();
    refuses! {
        punctual_scene_pair(Some(&scene), NOBODY, NOBODY, row(Some(&mut pair)), size_of::<punctual_pair_report>(), None)
            => null "listed";
        punctual_scene_certificate(None, NOBODY, NOBODY, slot(None)) => null "scene";
        punctual_scene_certificate(Some(&scene), NOBODY, NOBODY, slot(None)) => null "certificate";
    }
    let no_clock = punctual_clock {
        now: None,
        context: null_mut(),
    };
    refuses! {
        punctual_scene_detect(Some(&mut scene), budget, Some(&no_clock), slot(None))
            => null "clock->now";
        punctual_scene_refit_f32(None, NOBODY, null(), 0) => null "scene";
        punctual_scene_refit_f32(None, NOBODY, null(), 1) => null "vertices";
        punctual_scene_refit_f64(None, NOBODY, null(), 0) => null "scene";
        punctual_scene_refit_f64(None, NOBODY, null(), 1) => null "vertices";
        punctual_scene_bodies(None, null_mut(), 0, None) => null "scene";
        punctual_scene_bodies(Some(&scene), null_mut(), 0, None) => null "count";
    }
}

#[test]
fn bodies_that_are_not_there_are_refused() {
    let tree = tree_of(&knot());
    let mut scene = owned(|scene| punctual_scene_new(0, 0, scene));
    let pose = punctual_pose_identity();
    let mut pair = MaybeUninit::uninit();
    let (mut body, mut shape, mut open) = (
        MaybeUninit::uninit(),
        MaybeUninit::uninit(),
        MaybeUninit::uninit(),
    );
    let (size, mut listed) = (size_of::<punctual_pair_report>(), MaybeUninit::uninit());
    let (place, written) = (row(Some(&mut pair)), Some(&mut listed));
    refuses! {
        punctual_scene_remove(Some(&mut scene), NOBODY) => NoSuchBody;
        punctual_scene_body(Some(&scene), NOBODY, slot(Some(&mut body))) => NoSuchBody;
        punctual_scene_tree(Some(&scene), NOBODY, Some(&mut shape)) => NoSuchBody;
        punctual_scene_set_pose(Some(&mut scene), NOBODY, pose) => NoSuchBody;
        punctual_scene_set_tree(Some(&mut scene), NOBODY, Some(&tree)) => NoSuchBody;
        punctual_scene_set_filter(Some(&mut scene), NOBODY, 1, 1) => NoSuchBody;
        punctual_scene_set_importance(Some(&mut scene), NOBODY, 1.0) => NoSuchBody;
        punctual_scene_refit_f32(Some(&mut scene), NOBODY, null(), 0) => NoSuchBody;
        punctual_scene_pair(Some(&scene), NOBODY, NOBODY, place, size, written) => NoSuchBody;
        punctual_scene_certificate(Some(&scene), NOBODY, NOBODY, slot(Some(&mut open)))
            => NoSuchBody;
    }
    assert!(last_error().ends_with("body 7 (generation 3) is not in the scene"));
}

#[test]
fn numbers_out_of_range_are_named_by_meshes_and_trees() {
    let (vertices, corners) = ([0.0f64; 4], [0u32; 6]);
    let mut place = MaybeUninit::uninit();
    let (wide, corner, nan) = (vertices.as_ptr(), corners.as_ptr(), [f32::NAN; 3]);
    // SAFETY: within the array.
    let odd = unsafe { wide.cast::<u8>().add(1).cast() };
    let text = "punctual_mesh_new_f64: vertices is longer than memory or not aligned";
    refuses! {
        punctual_mesh_new_f64(wide, usize::MAX / 8, corner, 1, Some(&mut place))
            => BadArgument text;
        punctual_mesh_new_f64(odd, 1, corner, 1, Some(&mut place)) => BadArgument text;
        punctual_mesh_new_f32(nan.as_ptr(), 1, corner, 1, Some(&mut place))
            => BadMesh "punctual_mesh_new_f32: vertex 0 is not finite along axis 0";
    }
    let options = punctual_build_options {
        effort: 3,
        ..punctual_build_options_default()
    };
    refuses! {
        punctual_tree_new(Some(&knot()), asked(Some(&options)), Some(&mut MaybeUninit::uninit()))
            => BadArgument "punctual_tree_new: options->effort has no value 3";
    }
}

#[test]
fn numbers_out_of_range_are_named_by_workspaces_triangles_and_poses() {
    for (queue, pairs) in [
        (usize::MAX, 1),
        (1, usize::MAX),
        (usize::MAX / 32, usize::MAX / 16),
    ] {
        refuses! {
            punctual_workspace_with_capacity(queue, pairs, Some(&mut MaybeUninit::uninit()))
                => OutOfMemory "punctual_workspace_with_capacity: there is not that much memory";
        }
    }
    let triangle = |x| punctual_triangle {
        corners: [[0.0; 3], [0.0, x, 0.0], [0.0; 3]],
    };
    for (x, text) in [
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (2.0 * 2f64.powi(1000), "2143"),
    ] {
        let mut out = MaybeUninit::uninit();
        refuses! { punctual_triangles_intersect(triangle(0.0), triangle(x), Some(&mut out)) => BadArgument; }
        let start = format!("punctual_triangles_intersect: a coordinate of b is {text}");
        assert!(last_error().starts_with(&start), "{}", last_error());
    }
    refuses! {
        punctual_pose_from_quaternion(0.0, 0.0, 0.0, 0.0, NO_POINT, Some(&mut MaybeUninit::uninit()))
            => BadPose "punctual_pose_from_quaternion: quaternion is zero or not finite";
    }
}

#[test]
fn numbers_out_of_range_are_named_by_queries() {
    let tree = tree_of(&knot());
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let query = punctual_query_new(Some(&tree), Some(&tree), punctual_pose_identity());
    let mut out = MaybeUninit::uninit();
    let mut run =
        |query: punctual_query, budget| run(&query, Some(&mut workspace), budget, Some(&mut out));
    let unlimited = punctual_budget_unlimited();
    let name = "punctual_query_run";
    refuses! {
        run(punctual_query { mode: 2, ..query }, unlimited)
            => BadArgument &format!("{name}: query->mode has no value 2");
        run(punctual_query { order: 3, ..query }, unlimited)
            => BadArgument &format!("{name}: query->order has no value 3");
        run(punctual_query { prior: f64::NAN, ..query }, unlimited)
            => BadArgument &format!("{name}: query->prior is NaN, which is not finite or too large");
    }
    let odd = punctual_budget {
        kind: 3,
        ..unlimited
    };
    refuses! {
        run(query, odd) => BadArgument &format!("{name}: budget.kind has no value 3");
    }
    let mut b_in_a = punctual_pose_identity();
    b_in_a.m[7] = f64::INFINITY;
    refuses! {
        run(punctual_query { b_in_a, ..query }, unlimited)
            => BadPose &format!("{name}: entry 7 of the pose [R|t], row by row, is not finite");
    }
}

#[test]
fn numbers_out_of_range_are_named_by_scenes() {
    let tree = tree_of(&knot());
    refuses! {
        punctual_scene_new(2, 0, None) => BadArgument "punctual_scene_new: mode has no value 2";
        punctual_scene_new(0, 2, None) => BadArgument "punctual_scene_new: reach has no value 2";
    }
    let mut scene = owned(|scene| punctual_scene_new(0, 0, scene));
    for (bodies, pairs) in [(usize::MAX, 0), (0, usize::MAX / 2000), (1 << 50, 1 << 50)] {
        let status = punctual_scene_reserve(Some(&mut scene), bodies, pairs);
        assert_eq!(status, Status::OutOfMemory, "{bodies} {pairs}");
    }
    refuses! {
        punctual_scene_use_threads(Some(&mut scene), 2000)
            => BadArgument "punctual_scene_use_threads: threads is 2000, possible are 1024";
    }
    let body = punctual_body_new(Some(&tree), punctual_pose_identity());
    let mut out = MaybeUninit::uninit();
    let mut insert = |body| unsafe {
        punctual_scene_insert(Some(&mut scene), asked(Some(&body)), Some(&mut out))
    };
    let name = "punctual_scene_insert";
    refuses! {
        insert(punctual_body { kind: 2, ..body })
            => BadArgument &format!("{name}: body->kind has no value 2");
        insert(punctual_body { importance: f32::NAN, ..body })
            => BadArgument &format!("{name}: body 0 (generation 0): the importance is not a number");
    }
    let mut far = punctual_pose_identity();
    far.m[7] = 2f64.powi(995);
    refuses! {
        insert(punctual_body { pose: far, ..body })
            => BadPose &format!("{name}: body 0 (generation 0): translation along axis 1 exceeds 2^990");
    }
    let unlimited = punctual_budget_unlimited();
    let report = made(|report| detect(Some(&mut scene), unlimited, report));
    assert_eq!(report.pair_count, 0);
}
