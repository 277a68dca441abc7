//! Meshes, trees, poses and triangles.

use std::ffi::CString;
use std::mem::MaybeUninit;

use super::call::*;
use punctual::glam::{DVec3, Vec3};
use punctual::{BuildOptions, Mesh, Tree, shapes};
use punctual_capi::{punctual_status as Status, *};
use punctual_io::Format;

/// Every built-in shape, in C and in Rust.
fn all_shapes() -> [(Box<punctual_mesh>, Mesh); 6] {
    [
        (
            owned(|mesh| punctual_shape_icosphere(2, mesh)),
            shapes::icosphere(2),
        ),
        (
            owned(|mesh| punctual_shape_cuboid(1.0, 2.0, 3.0, 4, mesh)),
            shapes::cuboid(Vec3::new(1.0, 2.0, 3.0), 4),
        ),
        (
            owned(|mesh| punctual_shape_torus(1.0, 0.3, 16, mesh)),
            shapes::torus(1.0, 0.3, 16),
        ),
        (knot(), shapes::torus_knot(2, 3, 0.2, 96)),
        (
            owned(|mesh| punctual_shape_gear(9, 2, mesh)),
            shapes::gear(9, 2),
        ),
        (
            owned(|mesh| punctual_shape_height_field(8, 3, mesh)),
            shapes::height_field(8, 3),
        ),
    ]
}

/// Their trees, built with options that are not the default.
fn all_trees() -> [(Box<punctual_tree>, Tree); 6] {
    let options = punctual_build_options {
        effort: punctual_effort::Fast as u32,
        frames: 0,
        extremes: 1,
        threads: 2,
        ..Default::default()
    };
    let mut fast = BuildOptions::fast_build().extremes(true);
    fast.orientations = false;
    all_shapes().map(|(mesh, native)| {
        (
            owned(|tree| unsafe { punctual_tree_new(Some(&mesh), asked(Some(&options)), tree) }),
            Tree::with_options(native, &fast),
        )
    })
}

#[test]
fn meshes_are_those_of_rust() {
    for (mesh, native) in all_shapes() {
        let facts = made(|facts| unsafe { punctual_mesh_describe(Some(&mesh), slot(facts)) });
        assert_eq!(
            (facts.triangles, facts.vertices, facts.bytes),
            (native.len(), native.vertex_count(), native.bytes())
        );
        assert_eq!(
            [facts.bounds.min.x, facts.bounds.max.z],
            [native.aabb().min.x, native.aabb().max.z]
        );
        let last =
            made(|vertex| punctual_mesh_vertex(Some(&mesh), native.vertex_count() - 1, vertex));
        assert_eq!(
            DVec3::new(last.x, last.y, last.z),
            native.vertex(native.vertex_count() - 1)
        );
        let indices = made(|indices| punctual_mesh_indices(Some(&mesh), indices));
        // SAFETY: three for each triangle of a mesh that is still there.
        let indices = unsafe { std::slice::from_raw_parts(indices, 3 * native.len()) };
        assert_eq!(indices, native.triangles().as_flattened());
    }
}

#[test]
fn files_are_read_as_in_rust() {
    let folder = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/fixtures/meshes/parallel_plates/"
    );
    let file = CString::new(folder.to_owned() + "a.obj").unwrap();
    // SAFETY: a text that is still there.
    let mesh = owned(|mesh| unsafe { punctual_mesh_read(file.as_ptr(), mesh) });
    let native = punctual_io::load(file.to_str().unwrap().as_ref())
        .unwrap()
        .mesh;
    let bytes = std::fs::read(file.to_str().unwrap()).unwrap();
    let read = |bytes: &[u8], format: u32, mesh: Option<&mut MaybeUninit<_>>| {
        // SAFETY: as long as said.
        unsafe { punctual_mesh_read_bytes(bytes.as_ptr(), bytes.len(), format, mesh) }
    };
    let same = owned(|mesh| read(&bytes, punctual_format::Obj as u32, mesh));
    for mesh in [mesh, same] {
        let facts = made(|facts| unsafe { punctual_mesh_describe(Some(&mesh), slot(facts)) });
        assert_eq!(
            (facts.triangles, facts.vertices),
            (native.len(), native.vertex_count())
        );
        let last =
            made(|vertex| punctual_mesh_vertex(Some(&mesh), native.vertex_count() - 1, vertex));
        assert_eq!(
            DVec3::new(last.x, last.y, last.z),
            native.vertex(native.vertex_count() - 1)
        );
    }
    let mut place = MaybeUninit::uninit();
    let text = "punctual_mesh_read_bytes: format has no value 6";
    refuses! {
        read(&bytes, 6, Some(&mut place)) => BadArgument text;
    }
    for (format, bytes) in [
        (0, &b"v 0 0 0\nf 1 2 3\n"[..]),
        (1, b"solid"),
        (2, b"ply\n"),
        (3, b"glTF"),
        (4, b"OFF"),
        (5, b"<COLLADA/>"),
    ] {
        let formats = [
            Format::Obj,
            Format::Stl,
            Format::Ply,
            Format::Gltf,
            Format::Off,
            Format::Collada,
        ];
        let error = punctual_io::read(bytes, formats[format as usize]).unwrap_err();
        refuses! {
            read(bytes, format, Some(&mut place))
                => BadFile &format!("punctual_mesh_read_bytes: {error}");
        }
    }
    for (path, status, text) in [
        (c"nowhere.obj", Status::BadFile, "nowhere.obj: "),
        (
            c"mesh.step",
            Status::BadFile,
            "mesh.step: no mesh format by its extension",
        ),
        (c"\xff.obj", Status::BadArgument, "path is not UTF-8"),
    ] {
        // SAFETY: a text.
        assert_eq!(
            unsafe { punctual_mesh_read(path.as_ptr(), Some(&mut place)) },
            status
        );
        let said = last_error();
        assert!(
            said.starts_with(&format!("punctual_mesh_read: {text}")),
            "{said}"
        );
    }
}

#[test]
fn trees_are_those_of_rust() {
    for (tree, native) in all_trees() {
        let (facts, stats) = (
            made(|facts| unsafe { punctual_tree_describe(Some(&tree), slot(facts)) }),
            native.stats(),
        );
        assert_eq!(
            [facts.triangles, facts.nodes, facts.leaves],
            [stats.triangles, stats.nodes, stats.leaves]
        );
        assert_eq!(
            (facts.depth, facts.bytes, facts.degradation),
            (stats.depth, stats.bytes(), 1.0)
        );
        assert_eq!(facts.unit_length, native.unit_length());
        assert_eq!(punctual_tree_validate(Some(&tree)), Status::Ok);
        let mut levels = vec![
            punctual_tree_level {
                nodes: 0,
                alpha: [0.0; 3],
                levels: 0.0,
            };
            stats.depth
        ];
        // SAFETY: there is room for as many as said.
        let count = made(|count| unsafe {
            punctual_tree_levels(
                Some(&tree),
                levels.as_mut_ptr(),
                size_of::<punctual_tree_level>(),
                stats.depth,
                count,
            )
        });
        assert_eq!(count, stats.depth);
        for (i, level) in levels.iter().enumerate() {
            assert_eq!(level.nodes as usize, stats.nodes_per_level[i]);
            assert_eq!(level.alpha, stats.alpha_per_level[i].to_array());
            assert_eq!(level.levels, stats.levels_per_level[i]);
        }
        let mut alphas = vec![0.0; stats.nodes];
        // SAFETY: the same.
        let count = made(|count| unsafe {
            punctual_tree_node_alphas(Some(&tree), alphas.as_mut_ptr(), stats.nodes, count)
        });
        assert_eq!(count, stats.nodes);
        assert!(
            native
                .subtrees()
                .map(|node| node.alpha_product())
                .eq(alphas)
        );
    }
}

#[test]
fn refitted_trees_are_those_of_rust() {
    for (mut tree, mut native) in all_trees() {
        let moved = |factor: f64| {
            (0..facts_of(&tree).vertices)
                .map(|i| vertex_of(&tree, i) * factor)
                .collect::<Vec<_>>()
        };
        let (twice, thrice) = (moved(2.0), moved(1.0 / 3.0));
        let narrow: Vec<[f32; 3]> = twice.iter().map(|v| v.as_vec3().to_array()).collect();
        let wide: Vec<[f64; 3]> = thrice.iter().map(|v| v.to_array()).collect();
        // SAFETY: as long as said.
        let status = unsafe {
            punctual_tree_refit_f32(Some(&mut tree), narrow.as_ptr().cast(), narrow.len())
        };
        assert_eq!(status, Status::Ok);
        native.refit(&narrow).unwrap();
        // SAFETY: as long as said.
        let status =
            unsafe { punctual_tree_refit_f64(Some(&mut tree), wide.as_ptr().cast(), wide.len()) };
        assert_eq!(status, Status::Ok);
        native.refit_f64(&wide).unwrap();
        assert_eq!(facts_of(&tree).is_f32, native.mesh().is_f32());
        assert_eq!(vertex_of(&tree, 0), native.mesh().vertex(0));
        let facts = made(|facts| unsafe { punctual_tree_describe(Some(&tree), slot(facts)) });
        assert_eq!(facts.degradation, native.degradation());
    }
}

#[test]
fn poses_are_those_of_rust() {
    let place = punctual_point {
        x: 0.4,
        y: 0.3,
        z: 0.2,
    };
    let pose = made(|pose| punctual_pose_from_quaternion(0.1, -0.7, 0.3, 0.4, place, pose));
    assert_eq!(pose, raw(&tilted()));
    assert_eq!(
        made(|out| punctual_pose_inverse(pose, out)),
        raw(&tilted().inverse().unwrap())
    );
    assert_eq!(
        made(|out| punctual_pose_compose(pose, pose, out)),
        raw(&tilted().compose(&tilted()).unwrap())
    );
}

fn facts_of(tree: &punctual_tree) -> punctual_mesh_facts {
    let mesh = owned(|mesh| punctual_tree_mesh(Some(tree), mesh));
    made(|facts| unsafe { punctual_mesh_describe(Some(&mesh), slot(facts)) })
}

pub fn vertex_of(tree: &punctual_tree, index: usize) -> DVec3 {
    let mesh = owned(|mesh| punctual_tree_mesh(Some(tree), mesh));
    let point = made(|vertex| punctual_mesh_vertex(Some(&mesh), index, vertex));
    DVec3::new(point.x, point.y, point.z)
}

fn bytes_of(tree: &punctual_tree, capacity: usize) -> (Vec<u8>, usize) {
    let mut bytes = vec![0xa5; capacity];
    // SAFETY: there is room for as many as said.
    let count = made(|count| unsafe {
        punctual_tree_to_bytes(Some(tree), bytes.as_mut_ptr(), capacity, count)
    });
    (bytes, count)
}

fn load(bytes: &[u8], tree: Option<&mut MaybeUninit<Option<Box<punctual_tree>>>>) -> Status {
    // SAFETY: as long as said.
    unsafe { punctual_tree_from_bytes(bytes.as_ptr(), bytes.len(), tree) }
}

#[test]
fn the_bytes_of_trees_are_those_of_rust() {
    let ours = tree_of(&knot());
    let native = Tree::new(shapes::torus_knot(2, 3, 0.2, 96));
    let file = native.to_bytes();
    let (written, count) = bytes_of(&ours, file.len());
    assert!(written == file && count == file.len());
    let (start, count) = bytes_of(&ours, 100);
    assert!(start == file[..100] && count == file.len());
    let (rest, count) = bytes_of(&ours, file.len() + 1);
    // Nothing is written beyond the last.
    assert!(rest.ends_with(&[0xa5]) && count == file.len());

    let loaded = owned(|tree| load(&file, tree));
    assert_eq!(bytes_of(&loaded, file.len()).0, file);
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let mut answer = |tree: &punctual_tree| {
        let mut query = punctual_query_new(Some(tree), Some(tree), raw(&tilted()));
        query.mode = punctual_mode::All as u32;
        made(|outcome| {
            run(
                &query,
                Some(&mut workspace),
                punctual_budget_work(u64::MAX),
                outcome,
            )
        })
    };
    assert_eq!(answer(&loaded), answer(&ours));
}

#[test]
fn damaged_bytes_are_refused_as_in_rust() {
    let file = Tree::new(shapes::torus_knot(2, 3, 0.2, 96)).to_bytes();
    let refused = |bytes: &[u8], text: &str| {
        let mut place = MaybeUninit::new(None);
        refuses! {
            load(bytes, Some(&mut place)) => BadFile &format!("punctual_tree_from_bytes: {text}");
        }
        // SAFETY: it had a value, which a call that fails leaves.
        assert!(unsafe { place.assume_init() }.is_none());
    };
    let mut damaged = file.clone();
    damaged[200] ^= 4;
    for bytes in [&damaged[..], &file[..60], &[], b"a letter"] {
        refused(bytes, &Tree::from_bytes(bytes).unwrap_err().to_string());
    }
    refused(
        b"a letter",
        "these bytes are not a tree: they do not begin with PUNCTREE",
    );
    refused(&[], "the tree should have 52 bytes, but has 0");
}

#[test]
fn triangles_meet_as_in_rust() {
    let a = punctual_triangle {
        corners: [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    for (z, expected) in [(0.0, true), (5e-324, false)] {
        let b = punctual_triangle {
            corners: a.corners.map(|[x, y, _]| [x + 1.0, y, z]),
        };
        assert_eq!(
            made(|intersect| punctual_triangles_intersect(a, b, intersect)),
            expected
        );
        let mut segment = MaybeUninit::new(punctual_segment {
            from: NO_POINT,
            to: NO_POINT,
        });
        assert_eq!(
            made(|meet| punctual_triangle_segment(a, b, Some(&mut segment), meet)),
            expected
        );
        let native = punctual::geom::triangle_segment(
            &a.corners.map(punctual::glam::DVec3::from_array),
            &b.corners.map(punctual::glam::DVec3::from_array),
        );
        let [from, to] = native.unwrap_or_default().map(punctual_point::from);
        // SAFETY: it was initialised.
        assert_eq!(
            unsafe { segment.assume_init() },
            punctual_segment { from, to }
        );
    }
}
