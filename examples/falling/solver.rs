//! Rigid bodies, and a solver of contact points: impulses along the normals, one point after the
//! other, in substeps, with friction across them.
//!
//! Manifolds are found once a frame. Within the frame a point keeps its normal and its places on
//! both bodies, so its distance follows from their motion.

use punctual::contacts::ManifoldPoint;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::{Pose, PoseError, Tree};
use std::f64::consts::TAU;
use std::rc::Rc;

/// Seconds of a frame.
pub const STEP: f64 = 1.0 / 60.0;
const SUBSTEPS: usize = 8;
const SUBSTEP: f64 = STEP / SUBSTEPS as f64;
const GRAVITY: f64 = 9.81;
const FRICTION: f64 = 0.6;
/// Distance at which bodies rest, in metres.
pub const SKIN: f64 = 0.005;
/// Points this much closer than that are not pushed away.
pub const SLOP: f64 = 0.001;
/// What is closer is pushed away like by an overdamped spring: its cycles a second, its damping
/// ratio, and the largest speed of the push.
const CYCLES: f64 = 120.0;
const DAMPING: f64 = 10.0;
const PUSH: f64 = 2.0;
/// Share of the spin that is left after a second.
const SPIN_LEFT: f64 = 0.3;

pub struct Body {
    pub tree: Rc<Tree>,
    /// Radius of a ball around `position` that holds the body.
    radius: f64,
    /// Inverse mass, and inverse inertia about the axes of the body; 0 for a fixed body.
    inverse_mass: f64,
    inverse_inertia: DVec3,
    pub position: DVec3,
    pub turn: DQuat,
    velocity: DVec3,
    spin: DVec3,
}

impl Body {
    /// A body at rest with the mass and the inertia of its box.
    pub fn new(tree: Rc<Tree>, position: DVec3, turn: DQuat) -> Self {
        let size = tree.mesh().aabb().extents();
        let (inverse_mass, squares) = (1.0 / size.element_product(), size * size);
        Self {
            tree,
            radius: 0.5 * size.length(),
            inverse_mass,
            inverse_inertia: 12.0 * inverse_mass / (DVec3::splat(squares.element_sum()) - squares),
            position,
            turn,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
        }
    }

    pub fn fixed(tree: Rc<Tree>, position: DVec3) -> Self {
        Self {
            inverse_mass: 0.0,
            inverse_inertia: DVec3::ZERO,
            ..Self::new(tree, position, DQuat::IDENTITY)
        }
    }

    pub fn is_fixed(&self) -> bool {
        self.inverse_mass == 0.0
    }

    pub fn pose(&self) -> Result<Pose, PoseError> {
        Pose::new(DMat3::from_quat(self.turn), self.position)
    }

    pub fn pose_in(&self, other: &Self) -> Result<Pose, PoseError> {
        other.pose()?.inverse()?.compose(&self.pose()?)
    }

    /// Distance by which it may approach another body within a frame, at any point.
    pub fn approach(&self, other: &Self) -> f64 {
        let turning = |body: &Self| body.spin.length() * body.radius;
        STEP * (self.velocity.distance(other.velocity) + turning(self) + turning(other))
    }

    pub fn is_far_from(&self, other: &Self, margin: f64) -> bool {
        self.position.distance(other.position) > self.radius + other.radius + margin
    }

    /// Largest speed of any of its points.
    pub fn fastest(&self) -> f64 {
        self.velocity.length() + self.spin.length() * self.radius
    }

    fn fall(&mut self) {
        if !self.is_fixed() {
            self.velocity.z -= GRAVITY * SUBSTEP;
            self.spin *= SPIN_LEFT.powf(SUBSTEP);
        }
    }

    fn advance(&mut self) {
        self.position += SUBSTEP * self.velocity;
        self.turn = (DQuat::from_scaled_axis(SUBSTEP * self.spin) * self.turn).normalize();
    }

    fn velocity_at(&self, arm: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(arm)
    }

    /// Change of spin by an angular impulse.
    fn turned(&self, impulse: DVec3) -> DVec3 {
        self.turn * (self.inverse_inertia * (self.turn.inverse() * impulse))
    }

    fn push(&mut self, impulse: DVec3, arm: DVec3) {
        self.velocity += self.inverse_mass * impulse;
        self.spin += self.turned(arm.cross(impulse));
    }
}

/// What a point passes on to the next frame.
#[derive(Clone, Copy, Default)]
pub struct Impulse {
    along: f64,
    across: DVec3,
}

/// A point at which body A is pushed away from body B, along the normal.
pub struct Point {
    bodies: [usize; 2],
    /// The id of the point of the manifold.
    pub id: u64,
    /// Offsets from the middles of the bodies, in their own frames.
    places: [DVec3; 2],
    normal: DVec3,
    /// Distance less that along the normal between the places.
    rest: f64,
    pub impulse: Impulse,
}

impl Point {
    /// `point` is in the frame of the first body.
    pub fn new(
        bodies: &[Body],
        pair: [usize; 2],
        point: &ManifoldPoint,
        known: Option<&Impulse>,
    ) -> Self {
        let [a, b] = pair.map(|i| &bodies[i]);
        let ends = point.points.map(|end| a.turn * end + a.position);
        let normal = a.turn * point.normal;
        let mut impulse = known.copied().unwrap_or_default();
        impulse.across = impulse.across.reject_from(normal);
        Self {
            bodies: pair,
            id: point.id,
            places: [
                a.turn.inverse() * (ends[0] - a.position),
                b.turn.inverse() * (ends[1] - b.position),
            ],
            normal,
            rest: point.distance - (ends[0] - ends[1]).dot(normal) - SKIN,
            impulse,
        }
    }

    pub fn pair(&self) -> [usize; 2] {
        self.bodies
    }

    fn arms(&self, bodies: &[Body]) -> [DVec3; 2] {
        [0, 1].map(|side| bodies[self.bodies[side]].turn * self.places[side])
    }

    /// Gives A enough speed along the normal, and reduces the speed across by as much as friction
    /// can. With `push`, points that are too close part like by a spring.
    fn solve(&mut self, bodies: &mut [Body], push: bool) {
        let arms = self.arms(bodies);
        let [a, b] = self.bodies.map(|i| &bodies[i]);
        let between = a.position + arms[0] - b.position - arms[1];
        let distance = self.rest + between.dot(self.normal);

        let omega = TAU * CYCLES;
        let damping = 2.0 * DAMPING + SUBSTEP * omega;
        let stiff = SUBSTEP * omega * damping;
        let (bias, hardness) = if distance > 0.0 {
            (distance / SUBSTEP, 1.0)
        } else if push {
            let depth = (distance + SLOP).min(0.0);
            ((omega / damping * depth).max(-PUSH), stiff / (1.0 + stiff))
        } else {
            (0.0, 1.0)
        };
        let before = self.impulse.along;
        let missing = -bias - self.speed(bodies, arms).dot(self.normal);
        let change = hardness * missing * self.mass(bodies, arms, self.normal);
        self.impulse.along = (change + hardness * before).max(0.0);
        self.push(bodies, arms, (self.impulse.along - before) * self.normal);

        let sliding = self.speed(bodies, arms).reject_from(self.normal);
        if let Some(along) = sliding.try_normalize() {
            let before = self.impulse.across;
            let wanted = before - sliding * self.mass(bodies, arms, along);
            self.impulse.across = wanted.clamp_length_max(FRICTION * self.impulse.along);
            self.push(bodies, arms, self.impulse.across - before);
        }
    }

    /// Velocity of A relative to B at this point.
    fn speed(&self, bodies: &[Body], arms: [DVec3; 2]) -> DVec3 {
        let [a, b] = self.bodies;
        bodies[a].velocity_at(arms[0]) - bodies[b].velocity_at(arms[1])
    }

    fn push(&self, bodies: &mut [Body], arms: [DVec3; 2], impulse: DVec3) {
        let [a, b] = self.bodies;
        bodies[a].push(impulse, arms[0]);
        bodies[b].push(-impulse, arms[1]);
    }

    /// Effective mass along a unit vector.
    fn mass(&self, bodies: &[Body], arms: [DVec3; 2], along: DVec3) -> f64 {
        let inverse = |side: usize| {
            let (body, arm) = (&bodies[self.bodies[side]], arms[side]);
            body.inverse_mass + body.turned(arm.cross(along)).cross(arm).dot(along)
        };
        1.0 / (inverse(0) + inverse(1))
    }
}

/// Moves the bodies on by a frame.
pub fn advance(bodies: &mut [Body], points: &mut [Point]) {
    for _ in 0..SUBSTEPS {
        bodies.iter_mut().for_each(Body::fall);
        for point in &*points {
            let arms = point.arms(bodies);
            let start = point.impulse.along * point.normal + point.impulse.across;
            point.push(bodies, arms, start);
        }
        points
            .iter_mut()
            .for_each(|point| point.solve(bodies, true));
        bodies.iter_mut().for_each(Body::advance);
        // Without the speed of the push.
        points
            .iter_mut()
            .for_each(|point| point.solve(bodies, false));
    }
}
