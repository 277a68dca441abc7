//! How B moves seen from A, cut into pieces of time in which it all but goes straight.
//!
//! In a piece B is taken to keep the orientation of the middle of the piece, and each part of it to
//! go along a straight line with the velocity that its own middle has then. What that leaves out is
//! bounded: `docs/numerics.md`, "Motion".

use crate::math::{Motion, Pose, smaller};
use crate::tree::Tree;
use glam::DVec3;

/// How points of B go at a moment, in A's frame: one at `y` has the velocity `shift + turn x y` and
/// the acceleration `pull + change x y + turn x (turn x y)`. Of two bodies that turn the axis of
/// `turn` goes with A, so it changes.
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
pub(super) struct Course<'m> {
    of_a: Option<&'m Motion>,
    of_b: &'m Motion,
    /// Of how many radians B turns against A at most.
    pub spin: f64,
    /// By how much a component of its turn changes in a unit of time, at most.
    pub wobble: f64,
    /// How fast B's points are at most, and their acceleration.
    pub speed: f64,
    pub acceleration: f64,
    /// By how much their acceleration changes in a unit of time, at most.
    pub jerk: f64,
    /// By how much a point may be off where the motion brings it: by rounding, per axis; and, for
    /// each unit of time from the moment of the twist, because A's matrix is no rotation. The
    /// former is infinite where squares of lengths overflow: nothing is claimed then.
    pub rounding: f64,
    pub drift: f64,
    /// The radii of both meshes about the middles of their boxes, the latter of B as it lies in A.
    radii: [f64; 2],
    pub pieces: u32,
}

/// How far a piece goes over the sizes of both meshes together, and what it turns (radians): if the
/// whole motion goes so far as they are large, and if it turns no more and goes no farther than a
/// frame does, since whatever is near is opened in each piece again. Longer turns are cut finer, as
/// what a piece bends grows with its square.
const WAY: f64 = 16.0;
const TURN_OF_FAR: f64 = 0.012;
const TURN: f64 = 0.065;
const MOST_PIECES: f64 = 4_096.0;

/// By how much accelerations change in a piece, times the square of its length, over the same, at
/// most: bodies may turn fast together, and slowly against one another.
const BEND: f64 = 5e-3;

/// How far B goes over the sizes of both meshes together, at most, where it is on the spot; and how
/// much of that is its turn, at least, if it goes farther in the whole motion.
const SPOT: f64 = 0.1;
const TURNING: f64 = 0.25;

/// Matrices pass for rotations that change lengths by 5e-4.
const STRETCH: f64 = 1.01;

impl<'m> Course<'m> {
    pub fn new(a: &Tree, b: &Tree, of_a: Option<&'m Motion>, of_b: &'m Motion) -> Self {
        let [box_a, box_b] = [a, b].map(|tree| {
            let middle = tree.unit().origin;
            (middle, (tree.mesh().aabb().max - middle).length() * STRETCH)
        });
        let middle = of_b.start().transform_point(box_b.0) - of_b.start().translation();
        let (spin_b, length) = (of_b.turn().length(), of_b.velocity().length());
        // From a point of B's axis, and from one of A's: all points of B, and A's origin.
        let to_middle = of_b.arm() + middle;
        let from_axis = to_middle.length() + box_b.1;
        // How fast B's points go around its axis, wherever along it they are.
        let around = of_b.turn().cross(to_middle).length()
            + spin_b * (box_b.1 + 8.0 * f64::EPSILON * from_axis);
        let largest = |v: DVec3| v.abs().max_element();
        let far = |motion: &Motion| {
            let angle = motion.turn().length();
            largest(motion.start().translation())
                + largest(motion.velocity())
                + largest(motion.arm()) * angle * (1.0 + angle)
        };
        let mut course = Self {
            of_a,
            of_b,
            spin: spin_b,
            wobble: 0.0,
            speed: length + around,
            acceleration: spin_b * around,
            jerk: spin_b * spin_b * around,
            rounding: far(of_b) + (1.0 + spin_b) * (3.0 * largest(box_b.0) + 2.0 * box_b.1),
            drift: 0.0,
            radii: [box_a.1, box_b.1],
            pieces: 1,
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
            course.rounding = (course.rounding + 2.0 * far(of_a) + (1.0 + spin_a) * apart) * 2.0;
            // How fast A's turn would take B's points along.
            let along = of_a.turn().cross(from_axis_of_a).length()
                + spin_a * (box_b.1 + own + 8.0 * f64::EPSILON * course.rounding);
            let together = spin_a + spin_b;
            course.spin = (of_b.turn() - of_a.turn()).length() + 4.0 * f64::EPSILON * together;
            course.wobble = spin_a * course.spin;
            course.speed = own + along;
            course.acceleration += spin_a * (2.0 * own + along);
            course.jerk +=
                3.0 * spin_a * spin_b * around + spin_a * spin_a * (2.0 * own + course.speed);
            course.drift = 4.0 * of_a.deviation() * (together * apart + course.acceleration);
        }
        let size = course.radii[0] + course.radii[1];
        course.rounding = 16.0 * f64::EPSILON * (course.rounding + largest(box_a.0) + box_a.1)
            + f64::MIN_POSITIVE;
        let Self {
            spin,
            speed,
            acceleration,
            jerk,
            ..
        } = &mut course;
        for bound in [spin, speed, acceleration, jerk] {
            *bound *= STRETCH;
        }
        let Self {
            spin,
            wobble,
            speed,
            acceleration,
            jerk,
            drift,
            ..
        } = course;
        if ![spin, wobble, speed, acceleration, jerk, drift, size]
            .iter()
            .all(|bound| bound.is_finite())
        {
            course.rounding = f64::INFINITY;
        }
        course.pieces = course.count_pieces(size);
        course
    }

    /// How many pieces the motion of meshes of this size together is cut into.
    fn count_pieces(&self, size: f64) -> u32 {
        let Self {
            spin,
            wobble,
            speed,
            jerk,
            ..
        } = *self;
        // `max` and `min` of `f64` pass over what is no number, as where sizes overflow.
        let far = (speed / (size + f64::MIN_POSITIVE)).min(1.0);
        let turn = spin / TURN;
        let pieces = (far * spin / TURN_OF_FAR).max(speed / (WAY * size + f64::MIN_POSITIVE));
        // In each of them A turns by a radian at most.
        let pieces = pieces.max(wobble / spin);
        let bends = jerk / (BEND * size + f64::MIN_POSITIVE);
        if turn <= 1.0 && pieces <= 1.0 && bends <= 1.0 {
            return 1;
        }
        let pieces = pieces.max(libm::round(turn * libm::sqrt(turn)));
        let pieces = if bends > 1.0 {
            pieces.max(libm::cbrt(bends))
        } else {
            pieces
        };
        (libm::ceil(pieces.min(MOST_PIECES)) as u32).max(1)
    }

    /// B in A.
    pub fn pose(&self, time: f64) -> Pose {
        let b = self.of_b.pose(time);
        match &self.of_a {
            Some(of_a) => of_a.pose(time).inverse_unchecked().compose_unchecked(&b),
            None => b,
        }
    }

    pub fn twist(&self, time: f64) -> Twist {
        // The velocity of a body at a place, and that of its axis.
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
        // Of a point of B at A's origin, in the world and then against A.
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

    /// When piece `i` begins; all pieces are equally long.
    fn begin(&self, i: u32) -> f64 {
        f64::from(i) / f64::from(self.pieces)
    }

    /// The number of the piece that does not end before a time, or of all pieces: of time 1.
    pub fn piece_at(&self, time: f64) -> u32 {
        let i = (time * f64::from(self.pieces)) as u32;
        if time < 1.0 {
            i.min(self.pieces - 1)
        } else {
            self.pieces
        }
    }

    pub fn piece(&self, i: u32) -> Piece {
        let (begin, end) = (self.begin(i), self.begin(i + 1));
        let (middle, length) = (begin + (end - begin) / 2.0, end - begin);
        let Self {
            speed, spin, radii, ..
        } = *self;
        let near = SPOT * (radii[0] + radii[1]);
        let is_on_the_spot = self.of_a.is_none()
            && speed * length < near
            && (spin * radii[1] > TURNING * speed || spin > 0.0 && speed < near);
        let at = if is_on_the_spot { begin } else { middle };
        Piece {
            begin,
            end,
            middle,
            is_on_the_spot,
            at,
            pose: self.pose(at),
        }
    }

    /// By how much a point of B may leave the straight line that it is on at the moment of the
    /// twist, `half` of a unit of time before and after it, rounding aside.
    pub fn bend(&self, half: f64) -> f64 {
        half * self.drift + 0.5 * self.acceleration * half * half
    }

    /// By what corners of a triangle of B leave their lines by their accelerations at that moment.
    pub fn bends(&self, twist: &Twist, corners: &[DVec3; 3], half: f64) -> [DVec3; 3] {
        if self.spin == 0.0 {
            return [DVec3::ZERO; 3];
        }
        corners.map(|corner| twist.acceleration(corner) * (0.5 * half * half))
    }

    /// By how much a point may besides, rounding aside.
    pub fn bend_besides(&self, half: f64) -> f64 {
        half * self.drift + self.jerk * half * half * half / 6.0
    }

    /// The velocity of the axis that all points of B go around; `None`: there is no such axis,
    /// since both bodies move.
    pub fn of_axis(&self) -> Option<DVec3> {
        if self.of_a.is_none() {
            Some(self.of_b.velocity())
        } else {
            None
        }
    }

    /// How fast the axis that all points of B go around goes across itself.
    pub fn slip(&self) -> f64 {
        let across = self.of_b.velocity().cross(self.of_b.turn()).length();
        STRETCH * STRETCH * across / (self.spin + f64::MIN_POSITIVE)
    }

    /// Whether the meshes are too far apart to come together in a piece.
    pub fn is_clear(&self, piece: &Piece, trees: [&Tree; 2], margin: f64) -> bool {
        let [a, b] = trees.map(|tree| tree.unit().origin);
        let apart = (piece.pose.transform_point(b) - a).length_squared();
        let reach = self.radii[0] + self.radii[1] + self.speed * (piece.end - piece.at) + margin;
        let reach = reach + 4.0 * self.rounding;
        apart * (1.0 - 1e-9) > reach * reach
    }
}

/// A piece of the motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub begin: f64,
    pub end: f64,
    pub middle: f64,
    /// Whether B goes little, beside the size of the meshes, and much of that by turning.
    pub is_on_the_spot: bool,
    /// When it is looked at: at its begin if on the spot, else in its middle. Where B lies in A
    /// then.
    pub at: f64,
    pub pose: Pose,
}

impl Piece {
    pub fn length(&self) -> f64 {
        self.end - self.begin
    }

    /// When part `i` of `parts` of the same length ends, rounded up.
    pub fn end_of_part(&self, i: u32, parts: u32) -> f64 {
        let end =
            self.begin + self.length() * (f64::from(i + 1) / f64::from(parts)) + 4.0 * f64::EPSILON;
        smaller(end, self.end)
    }

    /// A time in lengths of the piece from its middle.
    pub fn local(&self, time: f64) -> f32 {
        ((time - self.middle) / self.length()) as f32
    }

    /// The time of such a bound from below, rounded down.
    pub fn time(&self, local: f32) -> f64 {
        let time = self.middle + f64::from(local) * self.length() - 4.0 * f64::EPSILON;
        time.clamp(self.begin, self.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use crate::shapes;

    /// By differences over a short time, which tell velocities and accelerations to 1e-5 of what
    /// they are.
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
            let course = Course::new(&tree, &tree, (round % 2 == 0).then_some(&of_a), &of_b);
            for vertex in vertices {
                let (time, step) = (random.between(0.05, 0.95), 1e-4);
                let [before, now, after] = [time - step, time, time + step]
                    .map(|time| course.pose(time).transform_point(vertex));
                let velocity = (after - before) / (2.0 * step);
                let acceleration = (after - 2.0 * now + before) / (step * step);
                let twist = course.twist(time);
                assert!(
                    (velocity - twist.at(now)).length() < 1e-5 * course.speed,
                    "{velocity} {twist:?}"
                );
                let off = acceleration - twist.acceleration(now);
                assert!(
                    off.length() < 1e-5 * (course.acceleration + course.speed),
                    "{acceleration} {off} {twist:?}"
                );
                let later = time + 1e-3;
                let later = course
                    .twist(later)
                    .acceleration(course.pose(later).transform_point(vertex));
                let jerk = (later - twist.acceleration(now)) / 1e-3;
                let shares = [
                    velocity.length() / course.speed,
                    acceleration.length() / course.acceleration,
                    jerk.length() / course.jerk,
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
