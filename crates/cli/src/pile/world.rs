//! A pile: bodies that fall into a bin, with contacts as far as a scene found them in time.
//!
//! In each frame the scene learns the poses ([`Pile::place`]), finds contacts within its budget
//! ([`Scene::detect`]), and the solver moves the bodies ([`Pile::advance`]).
//!
//! **Bodies in doubt.** The scene tells how far each body may move before it could sink into another
//! one, where no contact holds it, by more than [`SINK`] ([`Scene::may_move`]). So none falls through
//! another, however little time there is: then the pile is in slow motion.
//!
//! **Who waits goes first.** The importance of a body is the share of its motion that it must not
//! make. So the scene spends its time on the pairs that hold bodies up, and on others if some is
//! left.
//!
//! **Thin bodies.** A body wholly inside another has no contacts. So a body sinks in by no more than
//! its thickness, and one that the scene finds inside another goes back to where it was before.

use std::error::Error;
use std::f64::consts::TAU;
use std::sync::Arc;

use punctual::glam::{DQuat, DVec3};
use punctual::tree::Solid;
use punctual::{Aabb, Budget, BuildOptions, Mesh, Tree, Verdict, shapes};
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
use punctual_scene::{Body, BodyId, BodyKind, Scene};

use super::solver::{Contact, Mass, RigidBody, Solver};

/// All bodies have this size: the diagonal of the box around them.
pub const SIZE: f64 = 1.0;
/// Distance within which two bodies have contacts where time is short, and at which they rest.
pub const SKIN: f64 = 0.005 * SIZE;
const REST: f64 = 0.0025 * SIZE;
/// How deep bodies may sink into each other unseen.
const SINK: f64 = 0.05 * SIZE;
/// How far a body may move in a frame.
const STRIDE: f64 = 0.15 * SIZE;
/// Thickness of the walls.
const WALL: f64 = 0.2 * SIZE;
/// Distances between the middles of bodies at the start.
const SPACING: DVec3 = DVec3::new(1.12 * SIZE, 1.12 * SIZE, 1.04 * SIZE);

/// A shape of bodies: its tree and its mass.
pub struct Shape {
    tree: Arc<Tree>,
    mass: Mass,
}

impl Shape {
    /// The solid that a mesh bounds, scaled to a size.
    pub fn new(mesh: &Mesh, size: f64) -> Result<Self, Box<dyn Error>> {
        let (bounds, triangles) = (mesh.aabb(), mesh.triangles().iter().copied());
        let scale = size / bounds.extents().length();
        let vertices = (0..mesh.vertex_count()).map(|i| (mesh.vertex(i) - bounds.center()) * scale);
        let tree = Arc::new(solid(Mesh::from_f64(vertices, triangles)?));
        let mass = Mass::of(&tree)?;
        Ok(Self { tree, mass })
    }

    /// Shapes that are not convex: a ring, a gear, a knot.
    pub fn built_in() -> Result<Vec<Self>, Box<dyn Error>> {
        let meshes = [
            shapes::torus(1.0, 0.4, 20),
            shapes::gear(11, 2),
            shapes::torus_knot(2, 3, 0.45, 40),
        ];
        meshes.iter().map(|mesh| Self::new(mesh, SIZE)).collect()
    }
}

fn solid(mesh: Mesh) -> Tree {
    Tree::with_options(mesh, &BuildOptions::default().solid(Solid::Flip))
}

/// The number of a sequence that fills the unit cube evenly: multiples of powers of the root of
/// x^4 = x + 1.
fn spread(number: usize) -> DVec3 {
    const STEPS: DVec3 = DVec3::new(
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_2,
        0.549_700_477_901_970_5,
    );
    (STEPS * number as f64).fract()
}

/// A rotation for each point of the unit cube, all equally dense (K. Shoemake, "Uniform random
/// rotations", 1992).
fn turn(point: DVec3) -> DQuat {
    let [(sin_y, cos_y), (sin_z, cos_z)] = [point.y, point.z].map(|part| (TAU * part).sin_cos());
    let (inner, outer) = ((1.0 - point.x).sqrt(), point.x.sqrt());
    DQuat::from_xyzw(inner * sin_y, inner * cos_y, outer * sin_z, outer * cos_z).normalize()
}

/// What a frame knew, and what it did with that.
#[derive(Clone, Copy, Debug, Default)]
pub struct Frame {
    /// Pairs of bodies with contacts; those whose contacts are of this frame; and the manifolds.
    pub touching: usize,
    pub fresh: usize,
    pub manifolds: usize,
    /// Bodies that did not move, or less far than they would have, for want of knowledge.
    pub held: usize,
    pub slowed: usize,
}

/// Bodies in a bin.
pub struct Pile {
    pub scene: Scene,
    /// Of each body, by its index.
    ids: Vec<BodyId>,
    pub bodies: Vec<RigidBody>,
    solver: Solver,
    contacts: Vec<Contact>,
    /// Half of the room inside of the walls.
    half_width: f64,
    skin: f64,
}

impl Pile {
    /// So many bodies of these shapes, in turn, in layers above a bin that they fill. Bodies closer than
    /// `skin` have contacts.
    pub fn new(shapes: &[Shape], count: usize, skin: f64) -> Result<Self, Box<dyn Error>> {
        let row = (count as f64 / 2.4).cbrt().round().max(1.0) as usize;
        let layers = count.div_ceil(row * row);
        let half_width = 0.5 * SPACING.x * row as f64 + WALL;
        let mut pile = Self {
            scene: Scene::new(),
            ids: Vec::new(),
            bodies: Vec::new(),
            solver: Solver::default(),
            contacts: Vec::new(),
            half_width,
            skin,
        };
        pile.scene.find_contacts();
        pile.build_bin(0.5 * (0.25 * layers as f64 + 1.0) * SIZE)?;
        for i in 0..count {
            let at = [i % row, i / row % row, i / (row * row)].map(|k| k as f64);
            let middle = 0.5 * (row as f64 - 1.0);
            let at = DVec3::new(at[0] - middle, at[1] - middle, at[2] + 0.67) * SPACING;
            let spread = spread(i);
            let noise = 0.02 * SIZE * (spread - 0.5);
            pile.insert(&shapes[i % shapes.len()], at + noise, turn(spread))?;
        }
        Ok(pile)
    }

    /// A floor and four walls, whose tops are twice `half_height` above it.
    fn build_bin(&mut self, half_height: f64) -> Result<(), Box<dyn Error>> {
        let (inner, wall) = (self.half_width, 0.5 * WALL);
        let outer = inner + WALL;
        self.insert_fixed([outer, outer, wall], DVec3::new(0.0, 0.0, -wall))?;
        for side in [-1.0, 1.0] {
            let at = side * (inner + wall);
            self.insert_fixed([wall, outer, half_height], DVec3::new(at, 0.0, half_height))?;
            self.insert_fixed([inner, wall, half_height], DVec3::new(0.0, at, half_height))?;
        }
        Ok(())
    }

    fn insert_fixed(&mut self, half_extents: [f64; 3], at: DVec3) -> Result<(), Box<dyn Error>> {
        self.insert_box(half_extents, at, |body| body)?;
        Ok(())
    }

    /// Adds a fixed box, made by `with`: a sensor, for example.
    pub fn insert_box(
        &mut self,
        half_extents: [f64; 3],
        at: DVec3,
        with: impl FnOnce(Body) -> Body,
    ) -> Result<BodyId, Box<dyn Error>> {
        let tree = solid(shapes::cuboid(half_extents.map(|x| x as f32), 4));
        let body = RigidBody::fixed(at);
        let id = self
            .scene
            .insert(with(Body::fixed(Arc::new(tree), body.pose()?)))?;
        self.ids.push(id);
        self.bodies.push(body);
        Ok(id)
    }

    /// Adds a body at rest, with the middle of its box at `at`. Returns its index.
    pub fn insert(
        &mut self,
        shape: &Shape,
        at: DVec3,
        turn: DQuat,
    ) -> Result<usize, Box<dyn Error>> {
        let body = RigidBody::moving(&shape.mass, at + turn * shape.mass.centre, turn);
        let moving = Body::moving(Arc::clone(&shape.tree), body.pose()?).margin(0.5 * self.skin);
        self.ids.push(self.scene.insert(moving)?);
        self.bodies.push(body);
        Ok(self.bodies.len() - 1)
    }

    /// Tells the scene where the bodies are. [`Scene::detect`] comes next.
    pub fn place(&mut self) -> Result<(), Box<dyn Error>> {
        for (&id, body) in self.ids.iter().zip(&self.bodies) {
            self.scene.set_pose(id, body.pose()?)?;
        }
        Ok(())
    }

    /// Moves the bodies by a frame, with what [`Scene::detect`] found.
    pub fn advance(&mut self) -> Result<Frame, Box<dyn Error>> {
        let mut frame = self.gather()?;
        self.rank()?;
        self.solver.step(&mut self.bodies, &mut self.contacts);
        let slowed = self.bodies.iter().filter(|body| body.is_slowed);
        for body in slowed {
            *(if body.limit > 0.0 {
                &mut frame.slowed
            } else {
                &mut frame.held
            }) += 1;
        }
        Ok(frame)
    }

    /// The contacts of all pairs, and how far each body may move.
    fn gather(&mut self) -> Result<Frame, Box<dyn Error>> {
        let mut frame = Frame::default();
        self.contacts.clear();
        for (id, body) in self.ids.iter().zip(&mut self.bodies) {
            body.limit = (self.scene).may_move(*id, STRIDE, SINK.min(body.thickness))?;
            body.goes_back = false;
        }
        for pair in &self.scene.report().pairs {
            let indices = [pair.a.index(), pair.b.index()];
            let [a, b] = [self.scene.body(pair.a)?, self.scene.body(pair.b)?];
            if a.is_sensor || b.is_sensor {
                continue;
            }
            let poses = [&a.pose, &b.pose];
            let found = self.scene.contacts(pair.a, pair.b)?;
            let mut manifold = None;
            for point in found.points {
                let now = point.at(poses);
                // A pin through a plate has no normal: it is pushed out at some speed.
                let (normal, gap) = if now.normal == DVec3::ZERO {
                    let [a, b] = indices.map(|i| self.bodies[i].position);
                    ((a - b).normalize_or(DVec3::Z), -SINK)
                } else {
                    (now.normal, now.distance - REST)
                };
                let key = (indices, point.id);
                let contact = Contact::new(key, now.points, normal, gap, &self.bodies);
                self.contacts.push(contact);
                frame.manifolds +=
                    usize::from(manifold.replace(point.manifold) != Some(point.manifold));
            }
            if !found.points.is_empty() {
                frame.touching += 1;
                frame.fresh += usize::from(found.age == 0);
            }
            if matches!(pair.verdict, Verdict::Contained { .. }) {
                for i in indices {
                    self.bodies[i].goes_back = true;
                }
            }
        }
        Ok(frame)
    }

    /// The more of its motion a body must not make, the sooner the scene looks at its pairs.
    fn rank(&mut self) -> Result<(), Box<dyn Error>> {
        let moving = self.ids.iter().zip(&self.bodies);
        for (&id, body) in moving.filter(|(_, body)| !body.is_fixed()) {
            let importance = (1.0 - body.limit / body.stride()).max(0.0) as f32;
            if self.scene.body(id)?.importance != importance {
                self.scene.set_importance(id, importance)?;
            }
        }
        Ok(())
    }

    /// True if a body is outside of the bin.
    fn is_lost(&self, body: &RigidBody) -> bool {
        let outer = self.half_width + WALL;
        let is_inside =
            body.position.truncate().abs().max_element() < outer && body.position.z > -WALL;
        !is_inside && !body.is_fixed()
    }

    /// The shortest pushes found that part two bodies, ascending: of all pairs whose surfaces
    /// intersect, as shares of [`SIZE`]. Each is proven by exact queries; no budget limits them.
    pub fn depths(&self, workspace: &mut PenetrationWorkspace) -> Result<Vec<f64>, Box<dyn Error>> {
        let is_solid = |body: &&Body| !body.is_sensor;
        let bodies: Vec<&Body> = self
            .scene
            .bodies()
            .map(|(_, body)| body)
            .filter(is_solid)
            .collect();
        let boxes: Vec<Aabb> = bodies
            .iter()
            .map(|body| body.tree.aabb_at(&body.pose))
            .collect();
        let mut depths = Vec::new();
        for (i, a) in bodies.iter().enumerate() {
            for (j, b) in bodies.iter().enumerate().skip(i + 1) {
                if b.kind == BodyKind::Fixed && a.kind == BodyKind::Fixed
                    || !boxes[i].intersects(&boxes[j])
                {
                    continue;
                }
                let b_in_a = a.pose.inverse()?.compose(&b.pose)?;
                let query = PenetrationQuery::new(&a.tree, &b.tree, b_in_a).push_only(true);
                let found = query.run(workspace, Budget::unlimited()).value;
                depths.extend(found.direction.map(|_| found.high / SIZE));
            }
        }
        depths.sort_unstable_by(f64::total_cmp);
        Ok(depths)
    }

    /// Speeds of the bodies that move, ascending: that of the centre, and half of the spin.
    pub fn speeds(&self) -> Vec<f64> {
        let moving = self.bodies.iter().filter(|body| !body.is_fixed());
        let mut speeds: Vec<f64> = moving
            .map(|body| body.velocity.length() + 0.5 * SIZE * body.spin.length())
            .collect();
        speeds.sort_unstable_by(f64::total_cmp);
        speeds
    }

    /// Number of bodies outside of the bin.
    pub fn lost(&self) -> usize {
        self.bodies.iter().filter(|body| self.is_lost(body)).count()
    }
}
