//! The relative motion of B as seen from A, cut into substeps of time in which it is nearly
//! straight.
//!
//! In a substep B is assumed to keep the orientation of the middle of the substep. Each part of B
//! is assumed to move straight, with the velocity that its middle has then. The neglected motion is
//! bounded: `docs/numerics.md`, "Motion".

use crate::tree::Tree;
use glam::DVec3;
use punctual_geom::{Motion, Pose, smaller};

/// Velocity and acceleration of points of B at a time, in A's frame. A point at `y` has the
/// velocity `shift + turn x y` and the acceleration `pull + change x y + turn x (turn x y)`. If
/// both bodies turn, the axis of `turn` moves with A, so it changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twist {
    pub shift: DVec3,
    pub turn: DVec3,
    pub pull: DVec3,
    pub change: DVec3,
}

impl Twist {
    pub fn at(&self, y: DVec3) -> DVec3 {
        self.shift + self.turn.cross(y)
    }

    pub fn acceleration(&self, y: DVec3) -> DVec3 {
        self.pull + self.change.cross(y) + self.turn.cross(self.turn.cross(y))
    }
}

/// The motion of B in A from time 0 to 1, with bounds for all points of B. Lengths in the unit of
/// the meshes.
#[derive(Clone, Copy, Debug)]
pub(super) struct RelativeMotion<'m> {
    of_a: Option<&'m Motion>,
    of_b: &'m Motion,
    /// Upper bound of the angular speed of B relative to A, radians per unit of time.
    pub spin: f64,
    /// Upper bound of the rate of change of a component of B's angular velocity.
    pub turn_error: f64,
    /// Upper bounds of the speed and of the acceleration of B's points.
    pub speed: f64,
    pub acceleration: f64,
    /// Upper bound of the rate of change of their acceleration.
    pub jerk: f64,
    /// Bounds on the position error of a point. `rounding` is per axis; it is infinite if squares
    /// of lengths overflow, and then nothing is claimed. `drift` is per unit of time since the time
    /// of the twist, because A's matrix is not exactly a rotation.
    pub rounding: f64,
    pub drift: f64,
    /// The radii of both meshes about the middles of their boxes; that of B as placed in A.
    radii: [f64; 2],
    pub substeps: u32,
}

/// Longest path of a substep, relative to the sizes of both meshes together.
const WAY: f64 = 16.0;

/// Largest turn of a substep, in radians: `TURN_OF_FAR` of a motion as long as the meshes are
/// large, `TURN` of one that turns no more than in a frame. The latter has fewer substeps, because
/// nearby node pairs are opened again in each. Longer turns are cut finer, because the bend of a
/// substep grows with the square of its turn.
const TURN_OF_FAR: f64 = 0.012;
const TURN: f64 = 0.065;
const MOST_SUBSTEPS: f64 = 4_096.0;

/// Upper limit of the change of acceleration in a substep, times the square of its length, relative
/// to the sizes of both meshes together. It matters to bodies that turn fast together, and slowly
/// relative to each other.
const BEND: f64 = 5e-3;

/// Factor for bounds of lengths, since the matrix of a pose is a rotation within a tolerance
/// only (`Pose::new`).
const STRETCH: f64 = 1.01;

impl<'m> RelativeMotion<'m> {
    pub fn new(a: &Tree, b: &Tree, of_a: Option<&'m Motion>, of_b: &'m Motion) -> Self {
        let [box_a, box_b] = [a, b].map(|tree| {
            let middle = tree.unit().origin;
            (middle, (tree.mesh().aabb().max - middle).length() * STRETCH)
        });
        let middle = of_b.start().transform_point(box_b.0) - of_b.start().translation();
        let (spin_b, length) = (of_b.turn().length(), of_b.velocity().length());
        // From a point of B's axis, and from one of A's, to all points of B and to A's origin.
        let to_middle = of_b.arm() + middle;
        let from_axis = to_middle.length() + box_b.1;
        // Speed of B's points around its axis, wherever along the axis they are.
        let around = of_b.turn().cross(to_middle).length()
            + spin_b * (box_b.1 + 8.0 * f64::EPSILON * from_axis);
        let largest = |v: DVec3| v.abs().max_element();
        let far = |motion: &Motion| {
            let angle = motion.turn().length();
            largest(motion.start().translation())
                + largest(motion.velocity())
                + largest(motion.arm()) * angle * (1.0 + angle)
        };
        let mut seen = Self {
            of_a,
            of_b,
            spin: spin_b,
            turn_error: 0.0,
            speed: length + around,
            acceleration: spin_b * around,
            jerk: spin_b * spin_b * around,
            rounding: far(of_b) + (1.0 + spin_b) * (3.0 * largest(box_b.0) + 2.0 * box_b.1),
            drift: 0.0,
            radii: [box_a.1, box_b.1],
            substeps: 1,
        };
        if let Some(of_a) = of_a {
            let spin_a = of_a.turn().length();
            let arm = of_a.arm().length();
            let way = (of_b.velocity() - of_a.velocity()).length();
            let own = way + around;
            let from_axis_of_a =
                of_b.start().translation() + middle - (of_a.start().translation() - of_a.arm());
            let between = (of_b.start().translation() - of_a.start().translation()).length()
                + arm
                + of_b.arm().length();
            let apart = from_axis + arm + between + way;
            seen.rounding = (seen.rounding + 2.0 * far(of_a) + (1.0 + spin_a) * apart) * 2.0;
            // Speed at which A's turn would carry B's points along.
            let along = of_a.turn().cross(from_axis_of_a).length()
                + spin_a * (box_b.1 + own + 8.0 * f64::EPSILON * seen.rounding);
            let together = spin_a + spin_b;
            seen.spin = (of_b.turn() - of_a.turn()).length() + 4.0 * f64::EPSILON * together;
            seen.turn_error = spin_a * seen.spin;
            seen.speed = own + along;
            seen.acceleration += spin_a * (2.0 * own + along);
            seen.jerk +=
                3.0 * spin_a * spin_b * around + spin_a * spin_a * (2.0 * own + seen.speed);
            seen.drift = 4.0 * of_a.deviation() * (together * apart + seen.acceleration);
        }
        let size = seen.radii[0] + seen.radii[1];
        seen.rounding =
            16.0 * f64::EPSILON * (seen.rounding + largest(box_a.0) + box_a.1) + f64::MIN_POSITIVE;
        seen.spin *= STRETCH;
        seen.speed *= STRETCH;
        seen.acceleration *= STRETCH;
        seen.jerk *= STRETCH;
        let bounds = [seen.spin, seen.turn_error, seen.speed, seen.acceleration];
        let others = [seen.jerk, seen.drift, size];
        if !bounds.iter().chain(&others).all(|bound| bound.is_finite()) {
            seen.rounding = f64::INFINITY;
        }
        seen.substeps = seen.count_substeps(size);
        seen
    }

    /// Number of substeps of a motion of meshes with this total size.
    fn count_substeps(&self, size: f64) -> u32 {
        let (spin, speed) = (self.spin, self.speed);
        // `max` and `min` of `f64` ignore NaN, which occurs if sizes overflow.
        let far = (speed / (size + f64::MIN_POSITIVE)).min(1.0);
        let turn = spin / TURN;
        let substeps = (far * spin / TURN_OF_FAR).max(speed / (WAY * size + f64::MIN_POSITIVE));
        // In each substep A turns by at most a radian.
        let substeps = substeps.max(self.turn_error / spin);
        let bends = self.jerk / (BEND * size + f64::MIN_POSITIVE);
        if turn <= 1.0 && substeps <= 1.0 && bends <= 1.0 {
            return 1;
        }
        let substeps = substeps.max(libm::round(turn * libm::sqrt(turn)));
        let substeps = if bends > 1.0 {
            substeps.max(libm::cbrt(bends))
        } else {
            substeps
        };
        (libm::ceil(substeps.min(MOST_SUBSTEPS)) as u32).max(1)
    }

    /// The pose of B in A.
    pub fn pose(&self, time: f64) -> Pose {
        let b = self.of_b.pose(time);
        match &self.of_a {
            Some(of_a) => of_a.pose(time).inverse_unchecked().compose_unchecked(&b),
            None => b,
        }
    }

    pub fn twist(&self, time: f64) -> Twist {
        // The velocity of a body at a point, which includes that of its axis.
        let velocity = |motion: &Motion, x: DVec3| {
            let on_axis = motion.start().translation() - motion.arm() + motion.velocity() * time;
            motion.velocity() + motion.turn().cross(x - on_axis)
        };
        let (of_b, turn) = (self.of_b, self.of_b.turn());
        let Some(of_a) = &self.of_a else {
            let shift = velocity(of_b, DVec3::ZERO);
            return Twist {
                shift,
                turn,
                pull: turn.cross(shift - of_b.velocity()),
                change: DVec3::ZERO,
            };
        };
        // The velocity of a point of B at A's origin, in the world and then relative to A.
        let (pose, turn_a) = (of_a.pose(time), of_a.turn());
        let [u, v] = [of_b, of_a].map(|motion| velocity(motion, pose.translation()));
        let pull = turn.cross(u - of_b.velocity()) - turn_a.cross((u - of_a.velocity()) + (u - v));
        let to_a = *pose.inverse_unchecked().rotation();
        Twist {
            shift: to_a * (u - v),
            turn: to_a * (turn - turn_a),
            pull: to_a * pull,
            change: to_a * turn.cross(turn_a),
        }
    }

    /// Start time of substep `i`; all substeps have the same length.
    fn begin(&self, i: u32) -> f64 {
        f64::from(i) / f64::from(self.substeps)
    }

    /// The number of the first substep that ends after `time`; for time 1 the number of substeps.
    pub fn substep_at(&self, time: f64) -> u32 {
        let i = (time * f64::from(self.substeps)) as u32;
        if time < 1.0 {
            i.min(self.substeps - 1)
        } else {
            self.substeps
        }
    }

    pub fn substep(&self, i: u32) -> Substep {
        let (begin, end) = (self.begin(i), self.begin(i + 1));
        let middle = begin + (end - begin) / 2.0;
        Substep {
            begin,
            end,
            middle,
            pose: self.pose(middle),
        }
    }

    /// Upper bound of the distance of a point of B from its tangent line at the time of the twist,
    /// within `half` of a unit of time before and after it, apart from rounding.
    pub fn bend(&self, half: f64) -> f64 {
        half * self.drift + 0.5 * self.acceleration * half * half
    }

    /// How far the accelerations at the time of the twist move the corners of a triangle of B off
    /// their tangent lines, `half` of a unit of time later.
    pub fn bends(&self, twist: &Twist, corners: &[DVec3; 3], half: f64) -> [DVec3; 3] {
        if self.spin == 0.0 {
            return [DVec3::ZERO; 3];
        }
        corners.map(|corner| twist.acceleration(corner) * (0.5 * half * half))
    }

    /// Upper bound of the part of the bend that [`Self::bends`] leaves out, apart from rounding.
    pub fn bend_besides(&self, half: f64) -> f64 {
        half * self.drift + self.jerk * half * half * half / 6.0
    }

    /// True if the meshes are too far apart to meet in a substep.
    pub fn is_clear(&self, substep: &Substep, trees: [&Tree; 2], margin: f64) -> bool {
        let [a, b] = trees.map(|tree| tree.unit().origin);
        let apart = (substep.pose.transform_point(b) - a).length_squared();
        let reach =
            self.radii[0] + self.radii[1] + self.speed * (substep.end - substep.middle) + margin;
        let reach = reach + 4.0 * self.rounding;
        apart * (1.0 - 1e-9) > reach * reach
    }
}

/// A substep of the motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Substep {
    pub begin: f64,
    pub end: f64,
    pub middle: f64,
    /// The pose of B in A in the middle.
    pub pose: Pose,
}

impl Substep {
    pub fn length(&self) -> f64 {
        self.end - self.begin
    }

    /// The end of part `i` out of `parts` equal parts, rounded up.
    pub fn end_of_part(&self, i: u32, parts: u32) -> f64 {
        let end =
            self.begin + self.length() * (f64::from(i + 1) / f64::from(parts)) + 4.0 * f64::EPSILON;
        smaller(end, self.end)
    }

    /// A time in lengths of the substep from its middle.
    pub fn local(&self, time: f64) -> f32 {
        ((time - self.middle) / self.length()) as f32
    }

    /// The time of a local lower bound, rounded down.
    pub fn time(&self, local: f32) -> f64 {
        let time = self.middle + f64::from(local) * self.length() - 4.0 * f64::EPSILON;
        time.clamp(self.begin, self.end)
    }
}

/// The setting of a run: a substep of a motion.
#[derive(Clone, Copy)]
pub(super) struct Setting<'q> {
    pub relative_motion: &'q RelativeMotion<'q>,
    pub substep: &'q Substep,
    /// Sum of the margins of both surfaces.
    pub margin: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use punctual_geom::random::Random;

    /// Differences over a short time give velocities and accelerations with a relative error of
    /// 1e-5.
    #[test]
    fn no_vertex_is_faster_or_turns_away_more() {
        let mut random = Random::new(6);
        let mut closest = [0.0_f64; 3];
        for round in 0..300 {
            let mut next =
                |size: f64| DVec3::from_array([(); 3].map(|()| random.between(-size, size)));
            let away = next([0.0, 3.0, 30.0][round % 3]);
            let mesh = shapes::icosphere(0);
            let vertices: Vec<_> = (0..mesh.vertex_count())
                .map(|i| mesh.vertex(i) + away)
                .collect();
            let mesh =
                crate::Mesh::from_f64(vertices.iter().copied(), mesh.triangles().iter().copied())
                    .unwrap();
            let tree = Tree::new(mesh);
            let mut motion = || {
                let start = Pose::unchecked(glam::DMat3::from_rotation_x(next(3.0).x), next(4.0));
                Motion::with_arm(start, next(2.0), next(3.0), next(5.0)).unwrap()
            };
            let (of_a, of_b) = (motion(), motion());
            let relative_motion =
                RelativeMotion::new(&tree, &tree, (round % 2 == 0).then_some(&of_a), &of_b);
            for vertex in vertices {
                let (time, step) = (random.between(0.05, 0.95), 1e-4);
                let [before, now, after] = [time - step, time, time + step]
                    .map(|time| relative_motion.pose(time).transform_point(vertex));
                let velocity = (after - before) / (2.0 * step);
                let acceleration = (after - 2.0 * now + before) / (step * step);
                let twist = relative_motion.twist(time);
                assert!(
                    (velocity - twist.at(now)).length() < 1e-5 * relative_motion.speed,
                    "{velocity} {twist:?}"
                );
                let off = acceleration - twist.acceleration(now);
                assert!(
                    off.length() < 1e-5 * (relative_motion.acceleration + relative_motion.speed),
                    "{acceleration} {off} {twist:?}"
                );
                let later = time + 1e-3;
                let later = relative_motion
                    .twist(later)
                    .acceleration(relative_motion.pose(later).transform_point(vertex));
                let jerk = (later - twist.acceleration(now)) / 1e-3;
                let shares = [
                    velocity.length() / relative_motion.speed,
                    acceleration.length() / relative_motion.acceleration,
                    jerk.length() / relative_motion.jerk,
                ];
                closest = core::array::from_fn(|i| closest[i].max(shares[i]));
            }
        }
        assert!(
            closest.iter().all(|share| (0.7..1.0).contains(share)),
            "{closest:?}"
        );
    }
}
