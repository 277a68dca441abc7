//! Robots among obstacles: which configurations collide, how near contact is, for how long a motion
//! is free.

use crate::arrays::{array, fill, list, path, room, text};
use crate::budget::{punctual_budget, punctual_clock};
use crate::distance::finite;
use crate::handle::{change, get};
use crate::outcome::punctual_stop_reason;
use crate::pose::{punctual_point, punctual_pose};
use crate::robot_motion::punctual_trajectory;
use crate::sized::{Place, Sized32, fill_rows, place};
use crate::status::{Fault, given};
use crate::tree::punctual_tree;
use crate::verbs::{calls, handles, types};
use ::punctual_robot::{
    Checker, Clearance, ClearanceOptions, Collision, Edge, EdgeAnswer, EdgeOptions, Margin, Model,
    NearPair, NearPairs, Outcome, RobotError, Shape, ShapeId, Track, UrdfOptions, braking_time,
    safe_speed,
};
use core::ffi::c_char;
use core::mem::MaybeUninit;
use punctual::clock::ClockedBudget;
use std::sync::Arc;

/// No shape of a robot.
pub const PUNCTUAL_NO_SHAPE: u32 = u32::MAX;

handles! {
    /// A robot among obstacles, with all that one thread needs to ask about it. Lengths are in
    /// metres, angles in radians. A configuration has a number for each joint that moves and
    /// follows no other, in the order of the URDF file.
    punctual_robot(Checker);

    /// Frees a robot; null is fine.
    punctual_robot_free(robot);
}

types! {
    /// What is known of a configuration or a motion.
    enum punctual_robot_verdict from EdgeAnswer {
        /// The budget ended first, or shapes come too near to be told apart.
        Undecided = 0,
        /// Proven: no two shapes meet.
        Free = 1,
        /// Proven: two shapes meet.
        Contact = 2,
    }

    /// Whether a configuration collides.
    told punctual_robot_collision(stop) from (found: Outcome<Collision>) {
        /// The answer.
        verdict: punctual_robot_verdict = said(found.value).0,
        /// The shapes that meet, or PUNCTUAL_NO_SHAPE twice.
        shapes: [u32; 2] = said(found.value).1,
        /// Why the call returned.
        stop: punctual_stop_reason = found.stop.into(),
        /// Units of work done.
        work: u64 = found.work,
    }

    /// The least distance of all pairs of shapes: `low <= distance <= high`, in metres, whenever it
    /// stopped.
    told punctual_robot_clearance(normal) from (found: Outcome<Clearance>) {
        /// Why the call returned.
        stop: punctual_stop_reason = found.stop.into(),
        /// Proven; infinite if no pair is asked.
        low: f64 = found.value.low,
        /// Proven; infinite if nothing was measured yet.
        high: f64 = found.value.high,
        /// The closest shapes found, or PUNCTUAL_NO_SHAPE twice.
        shapes: [u32; 2] = numbers(found.value.pair),
        /// Their closest points, in the world; the origin if one holds the other.
        points: [punctual_point; 2] = found.value.points.map(Into::into),
        /// The unit vector from the first of them to the second; 0 if they are one point.
        normal: punctual_point = found.value.normal.into(),
        /// Units of work done.
        work: u64 = found.work,
    }

    /// A pair of shapes that are near each other: `low <= what is left of their distance above
    /// their margin <= high`, in metres.
    row punctual_robot_near_pair(normal) from (near: NearPair) {
        /// The shapes, the lower one first.
        shapes: [u32; 2] = numbers(Some(near.pair)),
        /// Proven.
        low: f64 = near.low,
        /// Proven.
        high: f64 = near.high,
        /// Their closest points, in the world; the origin if one holds the other.
        points: [punctual_point; 2] = near.points.map(Into::into),
        /// The unit vector from the first of them to the second; 0 if they are one point.
        normal: punctual_point = near.normal.into(),
    }

    /// What `punctual_robot_near_pairs` found.
    told punctual_robot_near(work) {
        /// Why the call returned.
        stop: punctual_stop_reason,
        /// Number of pairs.
        count: usize,
        /// Proven: no less is left of the pairs that were not found; `within` at least, unless the
        /// budget ended first.
        beyond: f64,
        /// Units of work done.
        work: u64,
    }

    /// What is known of a motion. Times are shares of an edge (0 to 1), or seconds of a horizon.
    told punctual_robot_motion(stop) from (found: Outcome<Edge>) {
        /// The answer for all of the motion.
        verdict: punctual_robot_verdict = found.value.answer.into(),
        /// Proven: no contact before.
        free_until: f64 = found.value.free_until,
        /// Proven: contact then; infinite if none was found.
        touching_at: f64 = found.value.touching_at.unwrap_or(f64::INFINITY),
        /// The shapes that meet then, or PUNCTUAL_NO_SHAPE twice.
        shapes: [u32; 2] = numbers(found.value.pair),
        /// Why the call returned.
        stop: punctual_stop_reason = found.stop.into(),
        /// Units of work done.
        work: u64 = found.work,
    }
}

calls! {
    /// Reads a robot from a URDF file. `srdf` may be null, or names the file whose disabled pairs
    /// of links are not asked; without it, links joined by one moving joint are not. `packages` may
    /// be null, or names a folder in which `package://` names are sought, before those above the
    /// URDF file. With `solids` other than 0 closed meshes are solids: what is inside them
    /// collides. What is not heeded in the files, `punctual_robot_notices` tells.
    ///
    /// Fails with BAD_FILE; the text names the file, the line, and the link or joint.
    unsafe make punctual_robot_from_urdf(
        urdf: *const c_char, srdf: *const c_char, packages: *const c_char, solids: u32
    ) -> robot: punctual_robot = {
        let mut options = UrdfOptions::default();
        options.solids = solids != 0;
        // SAFETY: the contract of the header for texts.
        let urdf = unsafe {
            if !srdf.is_null() {
                options.srdf = Some(path(srdf, "srdf")?.into());
            }
            if !packages.is_null() {
                options.packages.push(path(packages, "packages")?.into());
            }
            path(urdf, "urdf")
        }?;
        Checker::new(Arc::new(Model::from_urdf(urdf, &options)?))
    };
}

calls! {
    /// The number of values of a configuration.
    fn punctual_robot_joints(
        robot: Option<&punctual_robot>, joints: Option<&mut MaybeUninit<usize>>
    ) {
        let robot = get(robot, "robot")?;
        given(joints, "joints")?.write(robot.model().joint_names().len());
        Ok(())
    }

    /// The name of a joint of the configuration, by its index there; written as that of a shape
    /// (`punctual_robot_shape_name`).
    ///
    /// Fails with BAD_ARGUMENT if there is no such joint.
    unsafe fn punctual_robot_joint_name(
        robot: Option<&punctual_robot>, joint: usize, name: *mut c_char, capacity: usize,
        length: Option<&mut MaybeUninit<usize>>
    ) {
        let names = get(robot, "robot")?.model().joint_names();
        let found = names.get(joint).ok_or(Fault::Index("joint", joint, names.len()))?;
        // SAFETY: the contract of the header for arrays.
        unsafe { tell(found, name, capacity, "name", length) }
    }

    /// The limits of a joint of the configuration, in radians or metres; infinite without. They are
    /// not enforced.
    ///
    /// Fails with BAD_ARGUMENT if there is no such joint.
    fn punctual_robot_joint_limits(
        robot: Option<&punctual_robot>, joint: usize, lower: Option<&mut MaybeUninit<f64>>,
        upper: Option<&mut MaybeUninit<f64>>
    ) {
        let limits = get(robot, "robot")?.model().joint_limits();
        let found = limits.get(joint).ok_or(Fault::Index("joint", joint, limits.len()))?;
        let [low, high] = found.unwrap_or([-f64::INFINITY, f64::INFINITY]);
        let (lower, upper) = (given(lower, "lower")?, given(upper, "upper")?);
        lower.write(low);
        upper.write(high);
        Ok(())
    }

    /// The name of a link, by its index in the URDF file; written as that of a shape.
    ///
    /// Fails with BAD_ARGUMENT if there is no such link.
    unsafe fn punctual_robot_link_name(
        robot: Option<&punctual_robot>, link: usize, name: *mut c_char, capacity: usize,
        length: Option<&mut MaybeUninit<usize>>
    ) {
        let mut names = get(robot, "robot")?.model().link_names();
        let count = names.len();
        let found = names.nth(link).ok_or(Fault::Index("link", link, count))?;
        // SAFETY: the contract of the header for arrays.
        unsafe { tell(found, name, capacity, "name", length) }
    }

    /// Where the links are in the world at a configuration, in the order of the URDF file. As many
    /// as `capacity` allows are written to `poses`, and how many there are to `count`. Allocates.
    ///
    /// Fails as `punctual_robot_collide`.
    unsafe fn punctual_robot_link_poses(
        robot: Option<&punctual_robot>, values: *const f64, joints: usize,
        poses: *mut punctual_pose, capacity: usize, count: Option<&mut MaybeUninit<usize>>
    ) {
        let (robot, count) = (get(robot, "robot")?, given(count, "count")?);
        // SAFETY: the contract of the header for arrays.
        unsafe {
            let found = robot.model().link_poses(array(values, joints, "values")?)?;
            list(poses, capacity, "poses", count, found.iter())
        }
    }

    /// The name of a shape: that of its link or of the obstacle, as UTF-8 that ends with a zero
    /// byte. As much as `capacity` allows is written to `name`; its whole length, without the zero
    /// byte, to `length`.
    ///
    /// Fails with BAD_ARGUMENT if there is no such shape.
    unsafe fn punctual_robot_shape_name(
        robot: Option<&punctual_robot>, shape: u32, name: *mut c_char, capacity: usize,
        length: Option<&mut MaybeUninit<usize>>
    ) {
        let robot = get(robot, "robot")?;
        let found = robot.id(shape).and_then(|id| robot.name(id));
        let found = found.ok_or(RobotError::NoObstacle)?;
        // SAFETY: the contract of the header for arrays.
        unsafe { tell(found, name, capacity, "name", length) }
    }

    /// What the files of a robot say that is not heeded, a line each: pairs of links that the robot
    /// does not have, elements that are passed over, open meshes that were to be solids. Empty for
    /// most. As much as `capacity` allows is written to `notices`, and ends with a zero byte; its
    /// whole length, without the zero byte, to `length`.
    unsafe fn punctual_robot_notices(
        robot: Option<&punctual_robot>, notices: *mut c_char, capacity: usize,
        length: Option<&mut MaybeUninit<usize>>
    ) {
        let robot = get(robot, "robot")?;
        let lines = robot.model().notices().join("\n");
        // SAFETY: the contract of the header for arrays.
        unsafe { tell(&lines, notices, capacity, "notices", length) }
    }
}

/// Writes a text, as much of it as there is room for, with a zero byte at its end, and the length
/// of all of it.
///
/// # Safety
/// `out` is null or points to room for `capacity` bytes that nothing else uses during the call.
unsafe fn tell(
    text: &str,
    out: *mut c_char,
    capacity: usize,
    what: &'static str,
    length: Option<&mut MaybeUninit<usize>>,
) -> Result<(), Fault> {
    // SAFETY: the caller's promise.
    let room = unsafe { room(out, capacity, what) }?;
    let length = given(length, "length")?;
    let bytes = &text.as_bytes()[..text.len().min(capacity.saturating_sub(1))];
    for (place, byte) in room.iter_mut().zip(bytes.iter().chain([&0])) {
        place.write(*byte as c_char);
    }
    length.write(text.len());
    Ok(())
}

calls! {
    /// Adds an obstacle, which shares the tree: a solid if it was built as one and is closed, else
    /// a surface. With `link` null it stands at a pose in the world; otherwise it moves with that
    /// link, at a pose in the frame of the link, and is not asked with it, nor, in either case,
    /// with the `may_touch_count` links whose names are in `may_touch`. Its number is written to
    /// `shape`.
    ///
    /// Fails with BAD_POSE if the pose is off a rotation by more than 1e-6, and with BAD_ARGUMENT
    /// if there is no such link.
    unsafe fn punctual_robot_add(
        robot: Option<&mut punctual_robot>, name: *const c_char, tree: Option<&punctual_tree>,
        pose: punctual_pose, link: *const c_char, may_touch: *const *const c_char,
        may_touch_count: usize, shape: Option<&mut MaybeUninit<u32>>
    ) {
        // SAFETY: the contract of the header for texts and arrays.
        let (name, may_touch) = unsafe {
            let names = array(may_touch, may_touch_count, "may_touch")?.iter();
            let names = names.map(|&link| text(link, "may_touch"));
            (text(name, "name")?, names.collect::<Result<Vec<_>, _>>()?)
        };
        let tree = Arc::clone(get(tree, "tree")?);
        let (solid, pose, shape) = (Shape::tree(tree), pose.check()?, given(shape, "shape")?);
        let link = match link.is_null() {
            true => None,
            // SAFETY: the contract of the header for texts.
            false => Some(unsafe { text(link, "link") }?),
        };
        change(robot, "robot", |robot| {
            let id = robot.attach(name, link, pose, solid, &may_touch)?;
            shape.write(id.number());
            Ok(())
        })
    }

    /// Moves an obstacle to another pose, in the frame in which it was added.
    ///
    /// Fails with BAD_ARGUMENT if there is no such obstacle, and as `punctual_robot_add`.
    change punctual_robot_move(robot: punctual_robot, shape: u32, pose: punctual_pose) =
        robot.move_to(obstacle(robot, shape)?, pose.check()?)?;

    /// Removes an obstacle.
    ///
    /// Fails with BAD_ARGUMENT if there is no such obstacle.
    change punctual_robot_remove(robot: punctual_robot, shape: u32) =
        robot.remove(obstacle(robot, shape)?)?;

    /// Makes an obstacle in the world move by itself, from a pose at time 0 on: with a linear
    /// velocity (m/s), and turning about its origin with an angular one (rad/s), both in the frame
    /// of the world. Each of its points may be `reach` metres from there, and farther by
    /// `reach_speed` (m/s) with time. It counts in edges and horizons, which begin at time 0;
    /// collisions and clearances are of time 0. `punctual_robot_move` ends its motion.
    ///
    /// Fails with BAD_ARGUMENT if there is no such obstacle, it is attached to a link, or a number
    /// is not finite, and with BAD_POSE.
    change punctual_robot_move_along(
        robot: punctual_robot, shape: u32, pose: punctual_pose, linear: punctual_point,
        angular: punctual_point, reach: f64, reach_speed: f64
    ) = {
        let track = Track::velocity(&pose.check()?, linear.numbers(), angular.numbers())?;
        let track = track.reach(reach, reach_speed)?;
        robot.move_along(obstacle(robot, shape)?, track)?
    };

    /// Sets how far apart shapes must be, in metres: 0 at first. Shapes that are no farther apart
    /// count as in contact; a clearance is what is left above the margin. With `name` null it is
    /// for all pairs; else for those of this link or obstacle, in addition. With `other` too, for
    /// pairs of these two, in place of all others. With `padding` other than 0 and a name, for
    /// pairs of this link, or of what is attached to it, and obstacles in the world, in addition.
    ///
    /// Fails with BAD_ARGUMENT if there is no link or obstacle of a name, the margin is negative,
    /// NaN or more than 1e30, or `other` comes without `name`, or with `padding`.
    unsafe fn punctual_robot_set_margin(
        robot: Option<&mut punctual_robot>, margin: f64, name: *const c_char, other: *const c_char,
        padding: u32
    ) {
        let optional = |pointer: *const c_char, what| match pointer.is_null() {
            true => Ok(None),
            // SAFETY: the contract of the header for texts.
            false => unsafe { text(pointer, what) }.map(Some),
        };
        let of = match (optional(name, "name")?, optional(other, "other")?, padding) {
            (None, None, 0) => Margin::All,
            (Some(name), None, 0) => Margin::Of(name),
            (Some(name), None, _) => Margin::Padding(name),
            (Some(name), Some(other), 0) => Margin::Pair(name, other),
            (None, ..) => return Err(Fault::Null("name")),
            (_, Some(_), padding) => return Err(Fault::Value("padding of two names", padding)),
        };
        change(robot, "robot", |robot| Ok(robot.set_margin(of, margin)?))
    }

    /// Tells whether two links or obstacles may touch: pairs that may (not 0) are not checked. What
    /// was told last of a pair counts, before what the files and `punctual_robot_add` say; pairs
    /// that never move relative to each other stay unchecked. Lists all pairs anew.
    ///
    /// Fails with BAD_ARGUMENT if there is no link or obstacle of a name.
    unsafe fn punctual_robot_allow(
        robot: Option<&mut punctual_robot>, x: *const c_char, y: *const c_char, may_touch: u32
    ) {
        // SAFETY: the contract of the header for texts.
        let names = unsafe { [text(x, "x")?, text(y, "y")?] };
        change(robot, "robot", |robot| Ok(robot.allow(names, may_touch != 0)?))
    }

    /// Whether a configuration of `joints` values collides, within a budget; `clock` may be null:
    /// the clock of the system. It does not lock or panic, and allocates nothing but room for more
    /// pairs or intervals than ever before.
    ///
    /// Fails with BAD_ARGUMENT if the robot has another number of joint values, or one is not
    /// finite.
    unsafe fn punctual_robot_collide(
        robot: Option<&mut punctual_robot>, values: *const f64, joints: usize,
        budget: punctual_budget, clock: Option<&punctual_clock>,
        collision: *mut punctual_robot_collision
    ) {
        // SAFETY: the contract of the header for arrays, structs and clocks.
        unsafe {
            let (values, out) = (array(values, joints, "values")?, place(collision, "collision")?);
            ask(robot, budget, clock, out, |robot, budget| robot.collide(values, budget))
        }
    }

    /// All pairs of shapes that meet, by ascending numbers: two numbers a pair, as many pairs as
    /// `capacity` allows to `shapes`, which has room for `2 * capacity` numbers, and how many there
    /// are to `count`. All of them, unless the budget ends. Allocates.
    ///
    /// Fails as `punctual_robot_collide`.
    unsafe fn punctual_robot_collide_all(
        robot: Option<&mut punctual_robot>, values: *const f64, joints: usize,
        budget: punctual_budget, clock: Option<&punctual_clock>, shapes: *mut u32, capacity: usize,
        count: Option<&mut MaybeUninit<usize>>, collision: *mut punctual_robot_collision
    ) {
        let (count, mut pairs) = (given(count, "count")?, Vec::new());
        // SAFETY: the contract of the header for arrays, structs and clocks.
        unsafe {
            let (values, out) = (array(values, joints, "values")?, place(collision, "collision")?);
            let found = spend(robot, budget, clock, |robot, budget| {
                robot.collide_all(values, budget, &mut pairs)
            })?;
            let numbers = pairs.iter().map(|pair| numbers(Some(*pair)));
            list(shapes.cast::<[u32; 2]>(), capacity, "shapes", count, numbers)?;
            out.write(found.into());
        }
        Ok(())
    }

    /// The least distance of all pairs of shapes at a configuration: bounds that are `tolerance`
    /// metres apart, unless the budget ends.
    ///
    /// Fails as `punctual_robot_collide`, and with BAD_ARGUMENT if the tolerance is negative or not
    /// finite.
    unsafe fn punctual_robot_measure(
        robot: Option<&mut punctual_robot>, values: *const f64, joints: usize, tolerance: f64,
        budget: punctual_budget, clock: Option<&punctual_clock>,
        clearance: *mut punctual_robot_clearance
    ) {
        finite(tolerance, "tolerance")?;
        let options = ClearanceOptions::default().tolerance(tolerance);
        // SAFETY: the contract of the header for arrays, structs and clocks.
        unsafe {
            let (values, out) = (array(values, joints, "values")?, place(clearance, "clearance")?);
            ask(robot, budget, clock, out, |robot, budget| {
                robot.clearance(values, &options, budget)
            })
        }
    }

    /// All pairs of shapes of which no more than `within` metres is left above their margin, by
    /// ascending numbers, each with bounds that are `tolerance` metres apart, unless the budget
    /// ends. As many as `capacity` allows are written to `pairs`, and how many there are to
    /// `near->count`. `gradients` may be null, or has room for `capacity * joints` numbers: how the
    /// distance of each pair changes with each joint, in m/rad or m/m; 0 of points that touch.
    /// Allocates.
    ///
    /// Fails as `punctual_robot_measure`, and with BAD_ARGUMENT if `within` is negative or not
    /// finite.
    unsafe fn punctual_robot_near_pairs(
        robot: Option<&mut punctual_robot>, values: *const f64, joints: usize, within: f64,
        tolerance: f64, budget: punctual_budget, clock: Option<&punctual_clock>,
        pairs: *mut punctual_robot_near_pair, pair_size: usize, gradients: *mut f64,
        capacity: usize, near: *mut punctual_robot_near
    ) {
        finite(within, "within")?;
        finite(tolerance, "tolerance")?;
        let options = ClearanceOptions::default().tolerance(tolerance);
        let mut found = NearPairs::default();
        // SAFETY: the contract of the header for arrays, structs and clocks.
        unsafe {
            let (values, out) = (array(values, joints, "values")?, place(near, "near")?);
            let outcome = spend(robot, budget, clock, |robot, budget| {
                robot.near_pairs(values, within, &options, budget, &mut found)
            })?;
            let rows = found.pairs.iter().copied();
            let count = fill_rows(pairs, pair_size, capacity, "pairs", rows)?;
            if !gradients.is_null() {
                let room = capacity.saturating_mul(joints);
                fill(gradients, room, "gradients", found.gradients.iter().copied())?;
            }
            out.write(punctual_robot_near {
                size: punctual_robot_near::SIZE,
                stop: outcome.stop.into(),
                count,
                beyond: outcome.value,
                work: outcome.work,
            });
        }
        Ok(())
    }

    /// Whether the straight line in joint space between two configurations is free: proven for all
    /// of it, not at samples. With `first` other than 0 the first contact is sought, not any.
    ///
    /// Fails as `punctual_robot_collide`.
    unsafe fn punctual_robot_edge(
        robot: Option<&mut punctual_robot>, from: *const f64, to: *const f64, joints: usize,
        first: u32, budget: punctual_budget, clock: Option<&punctual_clock>,
        motion: *mut punctual_robot_motion
    ) {
        let options = edge_options(first);
        // SAFETY: the contract of the header for arrays, structs and clocks.
        unsafe {
            let (from, to) = (array(from, joints, "from")?, array(to, joints, "to")?);
            let out = place(motion, "motion")?;
            ask(robot, budget, clock, out, |robot, budget| robot.edge(from, to, &options, budget))
        }
    }

    /// Whether a path is free: the straight lines from each of `count` configurations, one after the
    /// other in `knots`, to the next one. Times count the lines. Otherwise as
    /// `punctual_robot_edge`.
    ///
    /// Fails as `punctual_robot_collide`, and with BAD_ARGUMENT for fewer than two configurations.
    unsafe fn punctual_robot_path(
        robot: Option<&mut punctual_robot>, knots: *const f64, count: usize, joints: usize,
        first: u32, budget: punctual_budget, clock: Option<&punctual_clock>,
        motion: *mut punctual_robot_motion
    ) {
        let options = edge_options(first);
        let length = count.checked_mul(joints).ok_or(Fault::Array("knots"))?;
        // SAFETY: the contract of the header for arrays, structs and clocks.
        unsafe {
            let (knots, out) = (array(knots, length, "knots")?, place(motion, "motion")?);
            ask(robot, budget, clock, out, |robot, budget| {
                let (expected, found) = (robot.model().joint_names().len(), joints);
                if expected != found {
                    return Err(RobotError::Length { expected, found });
                }
                robot.path(knots, &options, budget)
            })
        }
    }

    /// Whether a motion along polynomials of time is free, as `punctual_robot_edge` for a line;
    /// times are in seconds. Pieces need not join; both ends of each count. Goes on by
    /// `punctual_robot_edge_resume`.
    ///
    /// Fails with BAD_ARGUMENT if it has another number of joints, or no piece.
    unsafe fn punctual_robot_follow(
        robot: Option<&mut punctual_robot>, trajectory: Option<&punctual_trajectory>, first: u32,
        budget: punctual_budget, clock: Option<&punctual_clock>, motion: *mut punctual_robot_motion
    ) {
        let trajectory = get(trajectory, "trajectory")?;
        let options = edge_options(first);
        // SAFETY: the contract of the header for structs and clocks.
        unsafe {
            let out = place(motion, "motion")?;
            ask(robot, budget, clock, out, |robot, budget| {
                robot.trajectory(trajectory, &options, budget)
            })
        }
    }

    /// Continues the last edge, which its budget has stopped. However it is cut into pieces by work
    /// budgets, the answer at the end is that of one uninterrupted call.
    ///
    /// Fails with NOT_RESUMABLE if it is done, or another question was asked or an obstacle changed
    /// since.
    unsafe fn punctual_robot_edge_resume(
        robot: Option<&mut punctual_robot>, budget: punctual_budget, clock: Option<&punctual_clock>,
        motion: *mut punctual_robot_motion
    ) {
        // SAFETY: the contract of the header for structs and clocks.
        unsafe {
            let out = place(motion, "motion")?;
            ask(robot, budget, clock, out, |robot, budget| robot.resume_edge(budget))
        }
    }

    /// For how long the robot is free if its joints go on at this velocity (rad/s or m/s), at most
    /// for `seconds`. The near future is proven first, so a budget that ends early leaves a shorter
    /// `free_until`.
    ///
    /// Fails as `punctual_robot_collide`.
    unsafe fn punctual_robot_horizon(
        robot: Option<&mut punctual_robot>, values: *const f64, velocity: *const f64, joints: usize,
        seconds: f64, budget: punctual_budget, clock: Option<&punctual_clock>,
        motion: *mut punctual_robot_motion
    ) {
        finite(seconds, "seconds")?;
        // SAFETY: the contract of the header for arrays, structs and clocks.
        unsafe {
            let values = array(values, joints, "values")?;
            let velocity = array(velocity, joints, "velocity")?;
            let out = place(motion, "motion")?;
            ask(robot, budget, clock, out, |robot, budget| {
                robot.horizon(values, velocity, seconds, budget)
            })
        }
    }

    /// The seconds in which joints with these velocities stop, all in proportion, so that they stay
    /// on their straight line, if each can decelerate so much (rad/s^2 or m/s^2).
    ///
    /// Fails with NULL.
    unsafe fn punctual_robot_braking_time(
        velocity: *const f64, decelerations: *const f64, joints: usize,
        seconds: Option<&mut MaybeUninit<f64>>
    ) {
        // SAFETY: the contract of the header for arrays.
        let [velocity, decelerations] = unsafe {
            [array(velocity, joints, "velocity")?, array(decelerations, joints, "decelerations")?]
        };
        given(seconds, "seconds")?.write(braking_time(velocity, decelerations));
        Ok(())
    }
}

/// The largest share of the speed (0 to 1) with which a robot that is proven free for `free_until`
/// seconds may go on for `cycle` seconds, and then still stop in time. `braking` is the time in
/// which it stops from the full speed, at a constant deceleration.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_robot_safe_speed(free_until: f64, cycle: f64, braking: f64) -> f64 {
    safe_speed(free_until, cycle, braking)
}

/// Asks within a budget, and writes the answer.
///
/// # Safety
/// That of [`punctual_budget::spend`].
unsafe fn ask<T, W: Sized32 + From<Outcome<T>>>(
    robot: Option<&mut punctual_robot>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    out: Place<W>,
    ask: impl FnOnce(&mut Checker, ClockedBudget<'_>) -> Result<Outcome<T>, RobotError>,
) -> Result<(), Fault> {
    // SAFETY: the caller's promise.
    out.write(unsafe { spend(robot, budget, clock, ask) }?.into());
    Ok(())
}

/// Asks within a budget.
///
/// # Safety
/// That of [`punctual_budget::spend`].
pub(crate) unsafe fn spend<T>(
    robot: Option<&mut punctual_robot>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    ask: impl FnOnce(&mut Checker, ClockedBudget<'_>) -> Result<T, RobotError>,
) -> Result<T, Fault> {
    let spend = |budget: ClockedBudget<'_>| change(robot, "robot", |robot| Ok(ask(robot, budget)?));
    // SAFETY: the caller's promise.
    unsafe { budget.spend(clock, spend) }
}

fn edge_options(first: u32) -> EdgeOptions {
    match first {
        0 => EdgeOptions::any(),
        _ => EdgeOptions::first(),
    }
}

/// The shape of this number.
fn obstacle(robot: &Checker, shape: u32) -> Result<ShapeId, RobotError> {
    robot.id(shape).ok_or(RobotError::NoObstacle)
}

/// The verdict of a configuration, and its shapes.
fn said(found: Collision) -> (punctual_robot_verdict, [u32; 2]) {
    match found {
        Collision::Free => (punctual_robot_verdict::Free, numbers(None)),
        Collision::Contact(pair) => (punctual_robot_verdict::Contact, numbers(Some(pair))),
        Collision::Undecided => (punctual_robot_verdict::Undecided, numbers(None)),
    }
}

fn numbers(pair: Option<[ShapeId; 2]>) -> [u32; 2] {
    pair.map_or([PUNCTUAL_NO_SHAPE; 2], |pair| pair.map(ShapeId::number))
}
