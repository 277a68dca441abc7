//! A small solver of rigid bodies: soft contacts and friction, in substeps.
//!
//! In each substep bodies fall, contacts push them apart by impulses along their normals, bodies
//! advance, and the contacts are solved again without what pushed overlapping bodies apart, so that
//! pushing leaves no speed behind. Impulses start from those that the contact with the same ids had
//! in the frame before.
//!
//! What is known of contacts limits how far a body may move ([`RigidBody::limit`]). A body that may
//! not move at all is held: for this frame it is as heavy as the ground.

use std::collections::HashMap;

use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::tree::SolidError;
use punctual::{Pose, PoseError, Tree};

/// Seconds of a frame.
pub const FRAME: f64 = 1.0 / 60.0;
const SUBSTEPS: usize = 8;
const SUBSTEP: f64 = FRAME / SUBSTEPS as f64;
const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.81);
const FRICTION: f64 = 0.6;
/// Contacts are damped springs: oscillations per second, and damping relative to the critical one.
const STIFFNESS: f64 = 120.0;
const DAMPING: f64 = 10.0;
/// Overlapping bodies part no faster than this, in lengths per second.
const FASTEST_PUSH: f64 = 3.0;
/// Share of its spin that a body loses per second.
const SPIN_LOSS: f64 = 1.2;

/// Mass, centre and inertia of a solid of density 1, and its size.
#[derive(Clone, Copy, Debug)]
pub struct Mass {
    pub mass: f64,
    pub centre: DVec3,
    /// About the centre.
    pub inertia: DMat3,
    /// Largest distance of a point of the surface from the centre.
    pub radius: f64,
    /// The smallest extent of the box around the mesh.
    pub thickness: f64,
}

impl Mass {
    pub fn of(tree: &Tree) -> Result<Self, SolidError> {
        let (found, mesh) = (tree.mass_properties()?, tree.mesh());
        let radius = (0..mesh.vertex_count())
            .map(|i| mesh.vertex(i).distance(found.center))
            .fold(0.0, f64::max);
        Ok(Self {
            mass: found.volume,
            centre: found.center,
            inertia: found.inertia,
            radius,
            thickness: mesh.aabb().extents().min_element(),
        })
    }
}

/// A rigid body.
#[derive(Clone, Debug)]
pub struct RigidBody {
    /// The centre of mass in the mesh, and in the scene.
    centre: DVec3,
    pub position: DVec3,
    pub turn: DQuat,
    pub velocity: DVec3,
    pub spin: DVec3,
    pub radius: f64,
    pub thickness: f64,
    /// 0 for a fixed body.
    inverse_mass: f64,
    inverse_inertia: DMat3,
    /// No point of its surface may move farther than this in the next frame.
    pub limit: f64,
    /// True if it was slowed down to its limit in the last frame, or held.
    pub is_slowed: bool,
    /// Where it was before it moved last; and true if it goes back there.
    before: (DVec3, DQuat),
    pub goes_back: bool,
    /// Inverse mass, and inverse inertia in the scene, in this frame: 0 if it is held.
    mobility: f64,
    turning: DMat3,
}

impl RigidBody {
    /// A body at rest. `position` is that of its centre of mass.
    pub fn moving(mass: &Mass, position: DVec3, turn: DQuat) -> Self {
        Self {
            centre: mass.centre,
            position,
            turn,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            radius: mass.radius,
            thickness: mass.thickness,
            inverse_mass: 1.0 / mass.mass,
            inverse_inertia: mass.inertia.inverse(),
            limit: f64::INFINITY,
            is_slowed: false,
            before: (position, turn),
            goes_back: false,
            mobility: 0.0,
            turning: DMat3::ZERO,
        }
    }

    /// A body that never moves. `position` is that of the origin of its mesh.
    pub fn fixed(position: DVec3) -> Self {
        Self {
            centre: DVec3::ZERO,
            position,
            turn: DQuat::IDENTITY,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            radius: 0.0,
            thickness: f64::INFINITY,
            inverse_mass: 0.0,
            inverse_inertia: DMat3::ZERO,
            limit: 0.0,
            is_slowed: false,
            before: (position, DQuat::IDENTITY),
            goes_back: false,
            mobility: 0.0,
            turning: DMat3::ZERO,
        }
    }

    pub fn is_fixed(&self) -> bool {
        self.inverse_mass == 0.0
    }

    /// Maps the coordinates of its mesh to those of the scene.
    pub fn pose(&self) -> Result<Pose, PoseError> {
        let turn = DMat3::from_quat(self.turn);
        Pose::new(turn, self.position - turn * self.centre)
    }

    /// Upper bound of the speed of all points of its surface.
    pub fn speed(&self) -> f64 {
        self.velocity.length() + self.spin.length() * self.radius
    }

    /// How far its surface may move in the next frame if nothing stops it.
    pub fn stride(&self) -> f64 {
        if self.is_fixed() {
            return 0.0;
        }
        FRAME * (self.speed() + FRAME * GRAVITY.length())
    }

    fn begin(&mut self) {
        let is_held = self.limit <= 0.0;
        self.is_slowed = is_held;
        self.mobility = if is_held { 0.0 } else { self.inverse_mass };
        let turn = DMat3::from_quat(self.turn);
        self.turning = if is_held {
            DMat3::ZERO
        } else {
            turn * self.inverse_inertia * turn.transpose()
        };
        if is_held {
            (self.velocity, self.spin) = (DVec3::ZERO, DVec3::ZERO);
        } else {
            self.before = (self.position, self.turn);
        }
    }

    fn fall(&mut self) {
        if self.mobility > 0.0 {
            self.velocity += SUBSTEP * GRAVITY;
            self.spin *= 1.0 - SPIN_LOSS * SUBSTEP;
        }
    }

    /// Slows it down to its limit.
    fn slow_down(&mut self) {
        let most = self.limit / FRAME;
        let speed = self.speed();
        if speed > most {
            self.is_slowed = true;
            let share = most / speed;
            (self.velocity, self.spin) = (self.velocity * share, self.spin * share);
        }
    }

    fn advance(&mut self) {
        self.position += SUBSTEP * self.velocity;
        self.turn = (DQuat::from_scaled_axis(SUBSTEP * self.spin) * self.turn).normalize();
    }

    fn velocity_at(&self, arm: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(arm)
    }

    fn push(&mut self, impulse: DVec3, arm: DVec3) {
        self.velocity += self.mobility * impulse;
        self.spin += self.turning * arm.cross(impulse);
    }

    /// Speed that a unit impulse at `arm` along a unit vector gives to that point.
    fn give(&self, arm: DVec3, along: DVec3) -> f64 {
        let turned = (self.turning * arm.cross(along)).cross(arm);
        self.mobility + turned.dot(along)
    }
}

/// Names a contact from frame to frame: its bodies, by index, and the id of its point.
pub type ContactKey = ([usize; 2], u64);

/// A point at which body A is pushed away from body B, along the normal.
#[derive(Clone, Debug)]
pub struct Contact {
    key: ContactKey,
    /// Offsets from the centres, in the frames of the bodies; and in the scene, in this substep.
    places: [DVec3; 2],
    arms: [DVec3; 2],
    normal: DVec3,
    /// The gap less what the places alone tell of it.
    offset: f64,
    mass: f64,
    impulse: f64,
    friction: DVec3,
}

impl Contact {
    /// A contact of `key`'s bodies at two points of the scene. `gap` is how far the bodies may
    /// approach along the normal, from B to A; negative if they are too close.
    pub fn new(
        key: ContactKey,
        points: [DVec3; 2],
        normal: DVec3,
        gap: f64,
        bodies: &[RigidBody],
    ) -> Self {
        let place = |i: usize| {
            let body = &bodies[key.0[i]];
            body.turn.inverse() * (points[i] - body.position)
        };
        Self {
            key,
            places: [place(0), place(1)],
            arms: [DVec3::ZERO; 2],
            normal,
            offset: gap - (points[0] - points[1]).dot(normal),
            mass: 0.0,
            impulse: 0.0,
            friction: DVec3::ZERO,
        }
    }

    fn begin(&mut self, bodies: &[RigidBody]) {
        self.arms = [0, 1].map(|i| bodies[self.key.0[i]].turn * self.places[i]);
        self.mass = self.mass_along(bodies, self.normal);
    }

    /// Effective mass along a unit vector; 0 if both bodies are held.
    fn mass_along(&self, bodies: &[RigidBody], along: DVec3) -> f64 {
        let give: f64 = (0..2)
            .map(|i| bodies[self.key.0[i]].give(self.arms[i], along))
            .sum();
        if give > 0.0 { 1.0 / give } else { 0.0 }
    }

    fn gap(&self, bodies: &[RigidBody]) -> f64 {
        let [a, b] = [0, 1].map(|i| bodies[self.key.0[i]].position + self.arms[i]);
        (a - b).dot(self.normal) + self.offset
    }

    fn velocity(&self, bodies: &[RigidBody]) -> DVec3 {
        let [a, b] = [0, 1].map(|i| bodies[self.key.0[i]].velocity_at(self.arms[i]));
        a - b
    }

    fn push(&self, bodies: &mut [RigidBody], impulse: DVec3) {
        bodies[self.key.0[0]].push(impulse, self.arms[0]);
        bodies[self.key.0[1]].push(-impulse, self.arms[1]);
    }

    /// One impulse along the normal, then one of friction across it. `pushes`: bodies that are too
    /// close are pushed apart, softly.
    fn solve(&mut self, bodies: &mut [RigidBody], pushes: bool) {
        let gap = self.gap(bodies);
        let (wanted, hardness, memory) = if gap > 0.0 {
            (-gap / SUBSTEP, 1.0, 0.0)
        } else if pushes {
            let omega = std::f64::consts::TAU * STIFFNESS;
            let [a, b] = [
                2.0 * DAMPING + SUBSTEP * omega,
                SUBSTEP * omega * (2.0 * DAMPING + SUBSTEP * omega),
            ];
            let part = (-gap * omega / a).min(FASTEST_PUSH);
            (part, b / (1.0 + b), 1.0 / (1.0 + b))
        } else {
            (0.0, 1.0, 0.0)
        };
        let missing = wanted - self.velocity(bodies).dot(self.normal);
        let before = self.impulse;
        self.impulse = (before * (1.0 - memory) + missing * self.mass * hardness).max(0.0);
        self.push(bodies, (self.impulse - before) * self.normal);

        let sliding = self.velocity(bodies).reject_from_normalized(self.normal);
        let before = self.friction;
        if let Some(along) = sliding.try_normalize() {
            let wanted = before - sliding * self.mass_along(bodies, along);
            self.friction = wanted.clamp_length_max(FRICTION * self.impulse);
            self.push(bodies, self.friction - before);
        }
    }
}

/// The contacts of the last frame, and what they pushed with.
#[derive(Debug, Default)]
pub struct Solver {
    impulses: HashMap<ContactKey, (f64, DVec3)>,
}

impl Solver {
    /// Moves the bodies by a frame.
    pub fn step(&mut self, bodies: &mut [RigidBody], contacts: &mut [Contact]) {
        bodies.iter_mut().for_each(RigidBody::begin);
        for contact in &mut *contacts {
            if let Some((impulse, friction)) = self.impulses.get(&contact.key) {
                contact.impulse = *impulse;
                contact.friction = friction.reject_from_normalized(contact.normal);
            }
        }
        for _ in 0..SUBSTEPS {
            bodies.iter_mut().for_each(RigidBody::fall);
            for contact in &mut *contacts {
                contact.begin(bodies);
                contact.push(bodies, contact.impulse * contact.normal + contact.friction);
            }
            contacts
                .iter_mut()
                .for_each(|contact| contact.solve(bodies, true));
            for body in &mut *bodies {
                body.slow_down();
                body.advance();
            }
            contacts
                .iter_mut()
                .for_each(|contact| contact.solve(bodies, false));
        }
        for body in bodies.iter_mut().filter(|body| body.goes_back) {
            (body.position, body.turn) = body.before;
        }
        self.impulses.clear();
        let known = contacts
            .iter()
            .map(|contact| (contact.key, (contact.impulse, contact.friction)));
        self.impulses.extend(known);
    }
}
