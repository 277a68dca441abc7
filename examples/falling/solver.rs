//! Rigid bodies and a solver of contact points: impulses along the normals, one point after the
//! other, repeated until none is too close; and friction across them.

use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::{Pose, PoseError, Tree};

/// Seconds of a frame.
pub const STEP: f64 = 1.0 / 60.0;
const GRAVITY: f64 = 9.81;
const FRICTION: f64 = 0.6;
/// Allowed overlap with the skin. In each frame a share of any overlap beyond it is corrected.
const SLOP: f64 = 0.001;
const PART: f64 = 0.2;
/// Largest distance at which a point counts as the one of the frame before.
const SAME: f64 = 0.1;

pub struct Body {
    pub tree: Tree,
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
    pub fn new(tree: Tree, position: DVec3, turn: DQuat) -> Self {
        let size = tree.mesh().aabb().extents();
        let (radius, inverse_mass, squares) = (
            0.5 * size.length(),
            1.0 / size.element_product(),
            size * size,
        );
        let inverse_inertia = 12.0 * inverse_mass / (DVec3::splat(squares.element_sum()) - squares);
        let (velocity, spin) = (DVec3::ZERO, DVec3::ZERO);
        Self {
            tree,
            radius,
            inverse_mass,
            inverse_inertia,
            position,
            turn,
            velocity,
            spin,
        }
    }

    pub fn fixed(tree: Tree, position: DVec3) -> Self {
        Self {
            inverse_mass: 0.0,
            inverse_inertia: DVec3::ZERO,
            ..Self::new(tree, position, DQuat::IDENTITY)
        }
    }

    pub fn pose(&self) -> Result<Pose, PoseError> {
        Pose::new(DMat3::from_quat(self.turn), self.position)
    }

    pub fn pose_in(&self, other: &Self) -> Result<Pose, PoseError> {
        other.pose()?.inverse()?.compose(&self.pose()?)
    }

    /// Speed at which it may approach another body, at any point.
    pub fn closing_speed(&self, other: &Self) -> f64 {
        let turning = |body: &Self| body.spin.length() * body.radius;
        self.velocity.distance(other.velocity) + turning(self) + turning(other)
    }

    pub fn is_far_from(&self, other: &Self, margin: f64) -> bool {
        self.position.distance(other.position) > self.radius + other.radius + margin
    }

    /// Largest speed of any of its points.
    pub fn fastest(&self) -> f64 {
        self.velocity.length() + self.spin.length() * self.radius
    }

    /// Energy of its motion and its height.
    pub fn energy(&self) -> f64 {
        if self.inverse_mass == 0.0 {
            return 0.0;
        }
        let spin = self.turn.inverse() * self.spin;
        let moving = 0.5 * self.velocity.length_squared() + GRAVITY * self.position.z;
        moving / self.inverse_mass + 0.5 * (spin * spin / self.inverse_inertia).element_sum()
    }

    pub fn fall(&mut self) {
        if self.inverse_mass > 0.0 {
            self.velocity.z -= GRAVITY * STEP;
        }
    }

    pub fn advance(&mut self) {
        self.position += STEP * self.velocity;
        self.turn = (DQuat::from_scaled_axis(STEP * self.spin) * self.turn).normalize();
        // Rolling friction.
        self.spin *= 0.985;
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

/// A point at which body A is pushed away from body B, along the normal.
pub struct Point {
    bodies: [usize; 2],
    patch: u64,
    /// Offsets from the middles of the bodies.
    arms: [DVec3; 2],
    normal: DVec3,
    /// Least allowed speed along the normal.
    least: f64,
    impulse: f64,
    friction: DVec3,
}

impl Point {
    /// `room` is how far the bodies may approach; negative if the bodies are too close.
    pub fn new(bodies: [usize; 2], patch: u64, arms: [DVec3; 2], normal: DVec3, room: f64) -> Self {
        let room = if room < 0.0 {
            PART * (room + SLOP).min(0.0)
        } else {
            room
        };
        Self {
            bodies,
            patch,
            arms,
            normal,
            least: -room / STEP,
            impulse: 0.0,
            friction: DVec3::ZERO,
        }
    }

    /// True if it is about the same point as one of the frame before.
    pub fn is(&self, before: &Self) -> bool {
        (self.bodies, self.patch) == (before.bodies, before.patch)
            && self.arms[1].distance(before.arms[1]) < SAME
    }

    /// Starts with the impulses of the frame before.
    pub fn start_from(&mut self, before: &Self, bodies: &mut [Body]) {
        (self.impulse, self.friction) = (before.impulse, before.friction.reject_from(self.normal));
        self.push(bodies, self.impulse * self.normal + self.friction);
    }

    /// Gives A enough speed along the normal, and reduces the speed across by as much as friction
    /// can.
    pub fn solve(&mut self, bodies: &mut [Body]) {
        let before = self.impulse;
        let missing = self.least - self.speed(bodies).dot(self.normal);
        self.impulse = (before + missing * self.mass(bodies, self.normal)).max(0.0);
        self.push(bodies, (self.impulse - before) * self.normal);

        let sliding = self.speed(bodies).reject_from(self.normal);
        if let Some(along) = sliding.try_normalize() {
            let before = self.friction;
            let wanted = before - sliding * self.mass(bodies, along);
            self.friction = wanted.clamp_length_max(FRICTION * self.impulse);
            self.push(bodies, self.friction - before);
        }
    }

    /// Velocity of A relative to B at this point.
    fn speed(&self, bodies: &[Body]) -> DVec3 {
        let [a, b] = self.bodies;
        bodies[a].velocity_at(self.arms[0]) - bodies[b].velocity_at(self.arms[1])
    }

    fn push(&self, bodies: &mut [Body], impulse: DVec3) {
        let [a, b] = self.bodies;
        bodies[a].push(impulse, self.arms[0]);
        bodies[b].push(-impulse, self.arms[1]);
    }

    /// Effective mass along a unit vector.
    fn mass(&self, bodies: &[Body], along: DVec3) -> f64 {
        let inverse = |i: usize| {
            let (body, arm) = (&bodies[self.bodies[i]], self.arms[i]);
            body.inverse_mass + body.turned(arm.cross(along)).cross(arm).dot(along)
        };
        1.0 / (inverse(0) + inverse(1))
    }
}
