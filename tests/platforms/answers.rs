//! One hash of each kind of answer: every platform gives the same. Without `std`, so that any can compute them.

use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::fmt::{Debug, Write};
use punctual::glam::{DMat3, DVec3};
use punctual::{
    Body, Budget, BuildOptions, ContactQuery, DistanceQuery, Mesh, Mode, Motion, MotionQuery,
    PairMemory, Patches, Pose, PushOutQuery, Query, Ray, RayBatch, RayMode, RayQuery, Scene,
    Subtree, Tree, Workspace, shapes,
};

const ENOUGH: Budget = Budget::work(1 << 40);

/// FNV-1a. The text of a number tells its bits.
struct Hash(u64);

impl Write for Hash {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}

impl Hash {
    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// Lines of a name and a hash.
struct Answers {
    lines: String,
    case: &'static str,
}

impl Answers {
    fn tell(&mut self, what: &str, answer: impl Debug) {
        self.tell_bytes(what, format!("{answer:?}").as_bytes());
    }

    fn tell_bytes(&mut self, what: &str, bytes: &[u8]) {
        let mut hash = Hash(0xcbf2_9ce4_8422_2325);
        hash.bytes(bytes);
        self.lines += &format!("{} {what} {:016x}\n", self.case, hash.0);
    }
}

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

/// Lines `case question hash`; queries run in workspaces like this one.
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
        answers.tell("tree", tree.stats());
        let mut nodes: Vec<Subtree> = tree.root().into_iter().collect();
        let mut boxes = Vec::new();
        while let Some(node) = nodes.pop() {
            boxes.push((
                node.half_extents(),
                node.rotation(),
                node.alpha(),
                node.self_cost(),
                node.profile(),
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

fn ask(answers: &mut Answers, [a, b]: [&Tree; 2], pose: Pose, mut workspace: Workspace) {
    let mut memory = PairMemory::new();
    let any = Query::new(a, b, pose);
    answers.tell("any", any.run(&mut workspace, ENOUGH));
    let all = Query::new(a, b, pose).mode(Mode::All);
    answers.tell("predict", (any.predict(None), all.predict(None)));
    let cut = all.run(&mut workspace, Budget::work(1_500));
    answers.tell("cut", (cut, workspace.pairs()));
    let certificate = all.certificate(&workspace).expect("of this query");
    answers.tell(
        "certificate",
        (
            certificate.upper_bound(),
            certificate.boxes().collect::<Vec<_>>(),
        ),
    );
    answers.tell("estimate", all.estimate(&workspace, None));
    let whole = all.run_with_memory(&mut workspace, &mut memory, ENOUGH);
    answers.tell("all", (whole, workspace.pairs()));
    answers.tell(
        "again",
        any.run_with_memory(&mut workspace, &mut memory, ENOUGH),
    );

    let distance = DistanceQuery::new(a, b, pose);
    answers.tell(
        "distance-cut",
        distance.run(&mut workspace, Budget::work(2_500)),
    );
    answers.tell(
        "distance-estimate",
        (distance.predict(None), distance.estimate(&workspace, None)),
    );
    answers.tell("distance", distance.run(&mut workspace, ENOUGH));

    let contacts = ContactQuery::new(a, b, pose).margin(0.02);
    let found = contacts.run(&mut workspace, ENOUGH);
    answers.tell(
        "contacts",
        (found, workspace.contacts().collect::<Vec<_>>()),
    );
    let mut patches = Patches::new();
    patches.update(a, b, workspace.contacts());
    answers.tell("patches", patches.as_slice());

    let push = PushOutQuery::new(a, b, pose)
        .query_limit(12)
        .run(&mut workspace, Budget::work(300_000));
    answers.tell("push-out", push);

    let start = pose.translation() * 3.0 + DVec3::new(0.1, 0.0, 4.0);
    let start = Pose::new(pose.rotation(), start).expect("the same rotation");
    let velocity = pose.translation() - start.translation();
    let motion = Motion::turning(start, velocity, [0.3, 0.8, -0.4], start.translation())
        .expect("small numbers");
    let query = MotionQuery::new(a, b, motion).tolerance(1e-3);
    answers.tell(
        "motion-cut",
        query.run(&mut workspace, Budget::work(20_000)),
    );
    answers.tell("motion", query.run(&mut workspace, Budget::work(200_000)));

    let place = |i: u32| {
        pose.transform_point(DVec3::new(f64::from(i % 7), f64::from(i % 5), 9.0) * 0.3 - 0.6)
    };
    let rays: Vec<Ray> = (0..40)
        .filter_map(|i| Ray::new(place(i), DVec3::splat(0.07) - place(3 * i)).ok())
        .collect();
    let mut hits = [None; 40];
    let done = RayBatch::new(a, &rays).run(&mut workspace, &mut hits, ENOUGH);
    answers.tell("rays", (done, hits));
    let through = Ray::segment([-5.0, 0.01, 0.02], [5.0, -0.01, 0.03]).expect("two points");
    let cast = RayQuery::new(a, through)
        .mode(RayMode::All)
        .run(&mut workspace, ENOUGH);
    answers.tell("all-hits", (cast, workspace.ray_hits()));
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
