//! One hash of each kind of answer: every platform gives the same. Without `std`, so that any can compute them.

use super::questions::{Answers, ask};
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use punctual::glam::{DMat3, DVec3};
use punctual::tree::Subtree;
use punctual::{Budget, BuildOptions, Mesh, Pose, Tree, Workspace, shapes};
use punctual_scene::{Body, Scene};

/// A rotation by a quaternion that need not have length 1, without functions whose last bit is a matter of the
/// platform.
fn rotation([w, x, y, z]: [f64; 4]) -> DMat3 {
    let square = w * w + x * x + y * y + z * z;
    DMat3::from_cols_array_2d(&[
        [
            w * w + x * x - y * y - z * z,
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ],
        [
            2.0 * (x * y - w * z),
            w * w - x * x + y * y - z * z,
            2.0 * (y * z + w * x),
        ],
        [
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            w * w - x * x - y * y + z * z,
        ],
    ]) * (1.0 / square)
}

/// The same shape with vertices that need `f64`.
fn in_f64(mesh: &Mesh) -> Mesh {
    let vertices: Vec<[f64; 3]> = (0..mesh.len())
        .flat_map(|id| mesh.triangle(id))
        .map(|corner| (corner * (1.0 / 3.0)).to_array())
        .collect();
    let triangles: Vec<[u32; 3]> = (0..mesh.len() as u32)
        .map(|id| [3 * id, 3 * id + 1, 3 * id + 2])
        .collect();
    Mesh::from_f64(vertices, triangles).expect("corners of a mesh")
}

/// The answers about built-in meshes; queries run in workspaces like this one.
pub fn answers(workspace: &Workspace) -> String {
    let mut answers = Answers {
        lines: String::new(),
        case: "",
    };
    let with_all = BuildOptions::default().extremes(true);
    let knot = Arc::new(Tree::with_options(
        shapes::torus_knot(2, 3, 0.2, 12),
        &with_all,
    ));
    let gear = Arc::new(Tree::with_options(shapes::gear(9, 2), &with_all));
    let field = Arc::new(Tree::new(in_f64(&shapes::height_field(20, 3))));
    let ball = Arc::new(Tree::new(in_f64(&shapes::icosphere(2))));
    for (case, tree) in [
        ("knot", &knot),
        ("gear", &gear),
        ("field", &field),
        ("ball", &ball),
    ] {
        answers.case = case;
        answers.tell("tree-fault", tree.validate().err());
        answers.tell("tree", crate::questions::Frozen(tree.stats()));
        let mut nodes: Vec<Subtree> = tree.root().into_iter().collect();
        let mut boxes = Vec::new();
        while let Some(node) = nodes.pop() {
            boxes.push((
                node.half_extents(),
                node.rotation(),
                node.alpha(),
                node.self_cost(),
            ));
            nodes.extend(node.children());
        }
        answers.tell("boxes", boxes);
        let bytes = tree.to_bytes();
        answers.tell_bytes("tree-bytes", &bytes);
        answers.tell(
            "tree-bytes-again",
            Tree::from_bytes(&bytes).map(|read| read.to_bytes() == bytes),
        );
    }
    for (case, a, b, turn, shift) in [
        (
            "knot-gear",
            &knot,
            &gear,
            [3.0, 1.0, -2.0, 0.5],
            [0.4, 0.3, -0.2],
        ),
        (
            "gear-knot-apart",
            &gear,
            &knot,
            [2.0, -1.0, 0.25, 1.0],
            [0.3, -0.2, 3.7],
        ),
        (
            "field-ball",
            &field,
            &ball,
            [5.0, 1.0, 1.0, 3.0],
            [0.05, -0.1, 0.2],
        ),
        (
            "ball-gear",
            &ball,
            &gear,
            [1.0, 0.0, 0.0, 0.0],
            [0.9, 0.2, 0.1],
        ),
    ] {
        answers.case = case;
        let pose = Pose::new(rotation(turn), DVec3::from_array(shift)).expect("a rotation");
        ask(&mut answers, [a, b], pose, workspace.clone());
    }
    answers.case = "scene";
    scene(&mut answers, &[knot, gear, ball]);
    answers.lines
}

/// Some frames of bodies that pass each other.
fn scene(answers: &mut Answers, trees: &[Arc<Tree>]) {
    let mut scene = Scene::new();
    let place = |i: usize, frame: usize| {
        let turn = [4.0, i as f64, frame as f64, 1.0];
        let shift = DVec3::new(
            i as f64 * 0.8 - frame as f64 * 0.1,
            (i % 3) as f64 * 0.5,
            frame as f64 * 0.05,
        );
        Pose::new(rotation(turn), shift).expect("a rotation")
    };
    let bodies: Vec<_> = (0..9)
        .map(|i| {
            scene
                .insert(Body::moving(trees[i % 3].clone(), place(i, 0)))
                .expect("within the limits")
        })
        .collect();
    for frame in 0..3 {
        for (i, body) in bodies.iter().enumerate() {
            scene
                .set_pose(*body, place(i, frame))
                .expect("within the limits");
        }
        answers.tell("frame", scene.detect(Budget::work(8_000)));
    }
}
