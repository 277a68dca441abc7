//! Any sequence of operations on a scene against a plain list of bodies and all pairs of their triangles: every verdict is
//! true, no pair is missing, with enough budget all is decided, and ids of removed bodies stay invalid.
#![no_main]

use std::sync::{Arc, LazyLock};
use std::time::Duration;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DQuat, DVec3, Vec3};
use punctual::{Budget, BuildOptions, Mesh, Mode, Pose, Tree, Verdict, shapes};
use punctual_fuzz::{Numbers, reference};
use punctual_scene::{Body, BodyId, BodyKind, Filter, Reach, Scene, SceneError};

static TREES: LazyLock<Vec<Arc<Tree>>> = LazyLock::new(|| {
    let none = Mesh::new([[0.0f32; 3]; 0], []).expect("sound");
    let lone = Mesh::new(
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[0, 1, 2]],
    )
    .expect("sound");
    let meshes = [
        shapes::icosphere(0),
        shapes::icosphere(1),
        shapes::cuboid(Vec3::new(1.0, 0.5, 0.25), 1),
        lone,
        none,
    ];
    // Some know their extremes.
    let options = |at: usize| BuildOptions::default().extremes(!at.is_multiple_of(3));
    meshes
        .into_iter()
        .enumerate()
        .map(|(at, mesh)| Arc::new(Tree::with_options(mesh, &options(at))))
        .collect()
});

/// The bodies of a scene as a plain list, and the ids that are no longer valid.
struct Model {
    scene: Scene,
    mode: Mode,
    bodies: Vec<(BodyId, Body)>,
    removed: Vec<BodyId>,
}

fn pose(bytes: &mut Unstructured) -> Result<Pose> {
    let numbers = if bytes.ratio(1, 8)? {
        Numbers::arbitrary(bytes)?
    } else {
        Numbers::Fraction
    };
    let [x, y, z] = Numbers::Fraction.point(bytes)?;
    let turn = if bytes.ratio(1, 4)? {
        DQuat::IDENTITY
    } else {
        DQuat::from_xyzw(x, y, z, 0.7).normalize()
    };
    let mut rotation = DMat3::from_quat(turn);
    rotation.x_axis.x += 1e-4 * Numbers::Fraction.read(bytes)?;
    let place = 2.5 * DVec3::from_array(numbers.point(bytes)?);
    Ok(Pose::new(rotation, place).unwrap_or(Pose::IDENTITY))
}

fn filter(bytes: &mut Unstructured) -> Result<Filter> {
    Ok(Filter::new(
        1 << bytes.int_in_range(0..=2)?,
        bytes.int_in_range(0..=7)?,
    ))
}

fn may_meet(x: &Body, y: &Body) -> bool {
    let (a, b) = (x.filter, y.filter);
    let moving = x.kind == BodyKind::Moving || y.kind == BodyKind::Moving;
    moving && a.groups & b.mask != 0 && b.groups & a.mask != 0
}

impl Model {
    /// One operation; what the scene refuses leaves it as it was.
    fn change(&mut self, bytes: &mut Unstructured) -> Result<()> {
        let tree = Arc::clone(bytes.choose(&TREES)?);
        if self.bodies.is_empty() || (self.bodies.len() < 8 && bytes.ratio(1, 3)?) {
            let (place, fixed) = (pose(bytes)?, bytes.ratio(1, 4)?);
            let body = if fixed {
                Body::fixed(tree, place)
            } else {
                Body::moving(tree, place)
            };
            let body = if bytes.arbitrary()? {
                body.filter(filter(bytes)?)
            } else {
                body
            };
            if let Ok(id) = self.scene.insert(body.clone()) {
                assert!(!self.removed.contains(&id), "{id} was in use before");
                self.bodies.push((id, body));
            }
            return Ok(());
        }
        let at = bytes.choose_index(self.bodies.len())?;
        let id = self.bodies[at].0;
        match bytes.int_in_range(0..=9)? {
            0 => {
                self.scene.remove(id).expect("it is in the scene");
                self.bodies.swap_remove(at);
                self.removed.push(id);
            }
            1 => self.scene.set_tree(id, tree).expect("it is in the scene"),
            2 => *self.scene.tree_mut(id).expect("it is in the scene") = Tree::clone(&tree),
            3 => self
                .scene
                .set_filter(id, filter(bytes)?)
                .expect("it is in the scene"),
            4 => {
                let importance = f32::from_bits(bytes.arbitrary()?);
                assert_eq!(
                    self.scene.set_importance(id, importance).is_err(),
                    importance.is_nan()
                );
            }
            5 => {
                let body = self.scene.tree_mut(id).expect("it is in the scene");
                let scale = 1.0 + 0.5 * Numbers::Fraction.read(bytes)?;
                let vertices: Vec<DVec3> = (0..body.mesh().vertex_count())
                    .map(|i| body.mesh().vertex(i) * scale)
                    .collect();
                body.refit_f64(&vertices).expect("finite");
            }
            6 if !self.removed.is_empty() => {
                let gone = *bytes.choose(&self.removed)?;
                let expected = SceneError::NoSuchBody { body: gone };
                assert_eq!(self.scene.set_pose(gone, Pose::IDENTITY), Err(expected));
                assert_eq!(self.scene.certificate(gone, id), Err(expected));
                assert_eq!(self.scene.remove(gone).map(drop), Err(expected));
            }
            _ => _ = self.scene.set_pose(id, pose(bytes)?),
        }
        // The model has what the scene says it has; what it says of contacts is checked against that.
        for (id, body) in &mut self.bodies {
            *body = self.scene.body(*id).expect("it is in the scene").clone();
        }
        Ok(())
    }

    fn detect(&mut self, bytes: &mut Unstructured) -> Result<()> {
        let clock = ManualClock::ticking(Duration::from_nanos(300));
        let budget = match bytes.int_in_range(0..=3)? {
            0 => Budget::work(bytes.int_in_range(0..=3000)?),
            1 => Budget::time(Duration::from_nanos(bytes.int_in_range(0..=20_000)?)),
            2 => Budget::work(0),
            _ => Budget::unlimited(),
        };
        self.scene.detect(budget.clock(&clock));
        let report = self.scene.report();
        assert_eq!(self.scene.len(), self.bodies.len());
        let mut listed = 0;
        for (i, (x, of_x)) in self.bodies.iter().enumerate() {
            for (y, of_y) in &self.bodies[i + 1..] {
                let ((a, of_a), (b, of_b)) = if x < y {
                    ((x, of_x), (y, of_y))
                } else {
                    ((y, of_y), (x, of_x))
                };
                let pair = report.pair(*a, *b);
                listed += usize::from(pair.is_some());
                if !may_meet(of_a, of_b) {
                    assert!(pair.is_none(), "{a} and {b} may not meet");
                    continue;
                }
                let b_in_a = of_a
                    .pose
                    .inverse()
                    .and_then(|inverse| inverse.compose(&of_b.pose));
                let b_in_a = b_in_a.expect("any two bodies have a relative pose");
                let truth = reference::all_pairs(of_a.tree.mesh(), of_b.tree.mesh(), &b_in_a);
                let Some(pair) = pair else {
                    let known = |body| self.scene.partners_known(body).expect("it is in the scene");
                    let is_known = report.unlisted == 0 && known(*a) && known(*b);
                    assert!(
                        !is_known || truth.is_empty(),
                        "{a} and {b} meet and are not listed"
                    );
                    continue;
                };
                assert!(pair.found <= truth.len() as u64);
                match pair.verdict {
                    Verdict::Intersecting { witness } => {
                        assert!(truth.binary_search(&witness).is_ok(), "{a} {b}")
                    }
                    Verdict::Within { .. } => panic!("{a} and {b} have no margins"),
                    Verdict::Contained { .. } => panic!("{a} and {b} are no solids"),
                    Verdict::Separated => assert!(truth.is_empty(), "{a} and {b} meet"),
                    Verdict::Undecided => {
                        assert!(budget != Budget::unlimited(), "{a} and {b} are undecided")
                    }
                }
                if pair.complete && self.mode == Mode::All {
                    assert_eq!(pair.found, truth.len() as u64);
                }
                let bound = self
                    .scene
                    .certificate(*b, *a)
                    .expect("both are in the scene")
                    .upper_bound;
                assert!(
                    bound >= truth.len() as u64 || (pair.complete && bound >= pair.found),
                    "{a} {b}: bound {bound}"
                );
            }
        }
        assert_eq!(
            listed,
            report.pairs.len(),
            "pairs of bodies that are not there"
        );
        Ok(())
    }

    fn play(&mut self, bytes: &mut Unstructured) -> Result<()> {
        while !bytes.is_empty() {
            for _ in 0..bytes.int_in_range(0..=4)? {
                self.change(bytes)?;
            }
            self.detect(bytes)?;
        }
        Ok(())
    }
}

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Unstructured::new(bytes);
    let mode = if bytes.arbitrary().unwrap_or_default() {
        Mode::Any
    } else {
        Mode::All
    };
    let reach = if bytes.arbitrary().unwrap_or_default() {
        Reach::Here
    } else {
        Reach::Swept
    };
    let mut scene = Scene::new();
    scene.set_mode(mode);
    scene.set_reach(reach);
    let _ = Model {
        scene,
        mode,
        bodies: Vec::new(),
        removed: Vec::new(),
    }
    .play(&mut bytes);
});
