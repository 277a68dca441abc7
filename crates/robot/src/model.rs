//! The robot: links, joints, shapes, and where they are for joint values.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use punctual::Pose;
use punctual::glam::DVec3;
use smallvec::SmallVec;

use crate::error::refuse;
use crate::trajectory::Move;
use crate::transform::{Transform, from_pose, rotation_about, to_pose};
use crate::{RobotError, Shape, ShapeId, Trajectory};

/// Largest absolute joint value, factor or length (m): squares of all that follows are finite.
pub const LARGEST: f64 = 1e30;

/// How a joint moves its child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum JointKind {
    /// Not at all.
    Fixed,
    /// Turns about the axis within limits; the value is in radians.
    Revolute,
    /// Turns about the axis without limits; the value is in radians.
    Continuous,
    /// Slides along the axis; the value is in metres.
    Prismatic,
}

/// A joint whose value follows another one: `multiplier * value + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Mimic {
    /// Name of the other joint, which may be a mimic itself. A fixed joint has the value 0.
    pub joint: String,
    /// Factor.
    pub multiplier: f64,
    /// Summand, in radians or metres.
    pub offset: f64,
}

/// A joint between two links.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Its name, which no other joint has.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Name of the link nearer to the root.
    pub parent: String,
    /// Name of the link that it moves.
    pub child: String,
    /// Frame of the joint in the frame of the parent; also that of the child at the value 0.
    pub origin: Pose,
    /// Axis in the frame of the joint, of any length but 0.
    pub axis: [f64; 3],
    /// Lower and upper limit, in radians or metres. Reported to callers, never enforced.
    pub limits: Option<[f64; 2]>,
    /// The joint that it follows, if any.
    pub mimic: Option<Mimic>,
}

impl Joint {
    /// True if its value is part of a configuration: it moves, and follows no other one.
    pub fn moves_alone(&self) -> bool {
        self.kind != JointKind::Fixed && self.mimic.is_none()
    }
}

/// A link and its collision shapes, each at a pose in the frame of the link.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name, which no other link has.
    pub name: String,
    /// Shapes.
    pub shapes: Vec<(Pose, Shape)>,
}

/// A robot as plain data.
#[derive(Clone, Debug, Default)]
pub struct Description {
    /// Name of the robot.
    pub name: String,
    /// Links in any order. One of them is the child of no joint: the root.
    pub links: Vec<Link>,
    /// Joints in any order.
    pub joints: Vec<Joint>,
    /// Pairs of links that are never checked. Links of one rigid body are never checked either.
    pub allowed: Vec<[String; 2]>,
    /// True if links that one moving joint joins are not checked, nor the links that fixed joints
    /// hold to them.
    pub allows_neighbours: bool,
}

/// A robot: immutable, to be shared between threads in an [`Arc`].
///
/// The root link stands still at the origin of the world. A *configuration* has one value for each
/// joint that moves and is no mimic, in the order of [`Model::joint_names`].
#[derive(Debug)]
pub struct Model {
    description: Description,
    joint_names: Vec<String>,
    limits: Vec<Option<[f64; 2]>>,
    /// The body of each link, and the frame of the link in that body.
    pub(crate) links: Vec<(u32, Transform)>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) shapes: Vec<PlacedShape>,
    /// Pairs of link numbers that are never checked, the lower one first.
    pub(crate) allowed: BTreeSet<[u32; 2]>,
    pub(crate) notices: Vec<String>,
}

/// A shape that is part of a rigid body.
#[derive(Clone, Debug)]
pub(crate) struct PlacedShape {
    pub id: ShapeId,
    pub name: Arc<str>,
    /// Number of the link; `None` for obstacles, attached ones too.
    pub link: Option<u32>,
    /// Links that an attached obstacle may touch.
    pub touches: SmallVec<[u32; 4]>,
    /// Margins that it adds to all its pairs, and to those with obstacles.
    pub margins: [f64; 2],
    pub body: u32,
    /// Frame of the link, or of the world, in the body; and of the shape in the body.
    pub frame: Transform,
    pub in_body: Transform,
    pub shape: Shape,
}

impl PlacedShape {
    /// A shape at a pose in the frame of a link or of the world. That frame is fixed to a body.
    pub fn new(
        id: ShapeId,
        name: String,
        link: Option<u32>,
        (body, frame): (u32, Transform),
        pose: &Pose,
        shape: Shape,
    ) -> Result<Self, RobotError> {
        if shape.inner().radius > LARGEST {
            return refuse(format!("larger than {LARGEST:e}"));
        }
        Ok(Self {
            id,
            name: name.into(),
            link,
            touches: SmallVec::new(),
            margins: [0.0; 2],
            body,
            frame,
            in_body: frame * from_pose(pose)?,
            shape,
        })
    }
}

/// A rigid body behind a moving joint; the first one is the world, which holds the root.
#[derive(Debug)]
pub(crate) struct Body {
    pub parent: u32,
    /// Frame of the joint in the frame of the parent body.
    pub origin: Transform,
    pub motion: Motion,
    pub value: Value,
    /// The moving joints from the root to this one, by their bodies; the world has none.
    pub chain: SmallVec<[u32; 8]>,
}

/// The value of a joint: `multiplier * configuration[of] + offset`; without `of` the offset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Value {
    of: Option<usize>,
    multiplier: f64,
    offset: f64,
}

impl Value {
    const NONE: Self = Self {
        of: None,
        multiplier: 1.0,
        offset: 0.0,
    };

    /// Follows mimics up to a joint of `own`, which make a configuration, or to a fixed one.
    fn of(
        joint: &Joint,
        own: &[&Joint],
        joints: &[Joint],
        numbers: &HashMap<&str, usize>,
    ) -> Result<Self, RobotError> {
        let (mut at, mut value) = (joint, Self::NONE);
        for _ in 0..=joints.len() {
            // A mimic tag on a fixed joint moves nothing.
            let Some(mimic) = at.mimic.as_ref().filter(|_| at.kind != JointKind::Fixed) else {
                value.of = own.iter().position(|joint| joint.name == at.name);
                return Ok(value);
            };
            value.offset += value.multiplier * mimic.offset;
            value.multiplier *= mimic.multiplier;
            if !(value.offset.abs() <= LARGEST && value.multiplier.abs() <= LARGEST) {
                return refuse(format!("mimic of more than {LARGEST}"));
            }
            let Some(&other) = numbers.get(&*mimic.joint) else {
                return refuse(format!("mimics {}, which there is not", mimic.joint));
            };
            at = &joints[other];
        }
        refuse("mimics itself")
    }

    fn at(&self, configuration: &[f64]) -> f64 {
        self.change(configuration) + self.offset
    }

    /// The motion of the value, from the motions of the joints of a configuration.
    pub fn motion(&self, of_joint: impl Fn(usize) -> Move) -> Move {
        let Move { way, size, bend } = self.of.map_or(Move::default(), of_joint);
        Move {
            way: self.multiplier * way,
            size: self.multiplier.abs() * size,
            bend: self.multiplier.abs() * bend,
        }
    }

    /// The joint of the configuration that it follows, and by which factor.
    pub fn joint(&self) -> Option<(usize, f64)> {
        self.of.map(|of| (of, self.multiplier))
    }

    /// How much the value changes with a change of the configuration.
    fn change(&self, of_configuration: &[f64]) -> f64 {
        let of = self.of.and_then(|of| of_configuration.get(of));
        of.map_or(0.0, |value| self.multiplier * value)
    }
}

/// How a body moves with its joint's value, along or about a unit axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    Turn(DVec3),
    Slide(DVec3),
}

impl Motion {
    /// `None` for a fixed joint.
    fn of(joint: &Joint) -> Result<Option<Self>, RobotError> {
        let axis = DVec3::from_array(joint.axis);
        let length = axis.length();
        match joint.kind {
            JointKind::Fixed => Ok(None),
            _ if !(length > 0.0 && length.is_finite()) => {
                refuse(format!("axis {:?}, must have a direction", joint.axis))
            }
            JointKind::Prismatic => Ok(Some(Self::Slide(axis / length))),
            _ => Ok(Some(Self::Turn(axis / length))),
        }
    }

    fn at(self, value: f64) -> Transform {
        match self {
            Self::Turn(axis) => Transform::from_mat3(rotation_about(axis, value)),
            Self::Slide(axis) => Transform::from_translation(axis * value),
        }
    }
}

impl Model {
    /// A robot from plain data.
    ///
    /// # Errors
    /// [`RobotError::Model`], which names the link or joint: names that are missing or occur twice,
    /// no root or several, a circle of joints or mimics, an axis of length 0, a pose that is no
    /// rotation up to 1e-6, numbers that are not finite.
    pub fn new(description: &Description) -> Result<Self, RobotError> {
        let (given, joints) = (&description.links, &description.joints);
        let numbers = numbered("link", given.iter().map(|link| &*link.name))?;
        let joint_numbers = numbered("joint", joints.iter().map(|joint| &*joint.name))?;
        let link = |name: &str, of: &str| match numbers.get(name) {
            Some(number) => Ok(*number),
            None => refuse(format!("{of}: there is no link {name}")),
        };
        // The joint that holds each link, and those that it holds.
        let mut holder: Vec<Option<&Joint>> = vec![None; given.len()];
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); given.len()];
        for (number, joint) in joints.iter().enumerate() {
            let Joint { name, child, .. } = joint;
            let of = format!("joint {name}");
            children[link(&joint.parent, &of)?].push(number);
            if let Some(other) = holder[link(child, &of)?].replace(joint) {
                let other = &other.name;
                return refuse(format!(
                    "{of}: its child {child} is held by joint {other} already"
                ));
            }
        }
        let mut roots = (0..given.len()).filter(|&i| holder[i].is_none());
        let root = match [roots.next(), roots.next()] {
            [Some(root), None] => root,
            [Some(a), Some(b)] => {
                let [a, b] = [a, b].map(|i| &given[i].name);
                let what = format!("links {a} and {b} are not connected");
                return refuse(format!("{what}: each is the child of no joint"));
            }
            _ => return refuse("no root: there is no link that is the child of no joint"),
        };
        let own: Vec<&Joint> = joints.iter().filter(|joint| joint.moves_alone()).collect();
        let mut bodies = vec![Body {
            parent: 0,
            origin: Transform::IDENTITY,
            motion: Motion::Slide(DVec3::X),
            value: Value::NONE,
            chain: SmallVec::new(),
        }];
        let mut places = vec![None; given.len()];
        places[root] = Some((0, Transform::IDENTITY));
        // Depth first, so that parents come before children, in the order of the joints.
        let mut open: Vec<usize> = children[root].iter().rev().copied().collect();
        while let Some(number) = open.pop() {
            let joint = &joints[number];
            let fail = |error| prefixed(&format!("joint {}", joint.name), error);
            let (parent, child) = (link(&joint.parent, "")?, link(&joint.child, "")?);
            let Some((body, in_body)) = places[parent] else {
                continue;
            };
            let origin = in_body * from_pose(&joint.origin).map_err(fail)?;
            let value = Value::of(joint, &own, joints, &joint_numbers).map_err(fail)?;
            places[child] = Some(match Motion::of(joint).map_err(fail)? {
                None => (body, origin),
                // A mimic of a fixed joint stands still at its offset.
                Some(motion) if value.of.is_none() => (body, origin * motion.at(value.offset)),
                Some(motion) => {
                    let number = bodies.len() as u32;
                    let mut chain = bodies[body as usize].chain.clone();
                    chain.push(number);
                    bodies.push(Body {
                        parent: body,
                        origin,
                        motion,
                        value,
                        chain,
                    });
                    (number, Transform::IDENTITY)
                }
            });
            open.extend(children[child].iter().rev());
        }
        let (mut links, mut shapes) = (Vec::new(), Vec::new());
        for ((number, link), place) in (0..).zip(given).zip(places) {
            let of = format!("link {}", link.name);
            let Some((body, in_body)) = place else {
                return refuse(format!(
                    "{of}: not connected to the root, by joints in a circle"
                ));
            };
            for (i, (pose, shape)) in link.shapes.iter().enumerate() {
                let name = match link.shapes.len() {
                    1 => link.name.clone(),
                    _ => format!("{}:{i}", link.name),
                };
                let (id, place) = (ShapeId(shapes.len() as u32), (body, in_body));
                let placed = PlacedShape::new(id, name, Some(number), place, pose, shape.clone());
                shapes.push(placed.map_err(|error| prefixed(&of, error))?);
            }
            links.push((body, in_body));
        }
        let mut allowed = BTreeSet::new();
        for [a, b] in &description.allowed {
            let pair = [link(a, "allowed pair")?, link(b, "allowed pair")?];
            allowed.insert(sorted(pair.map(|i| i as u32)));
        }
        Ok(Self {
            description: description.clone(),
            joint_names: own.iter().map(|joint| joint.name.clone()).collect(),
            limits: own.iter().map(|joint| joint.limits).collect(),
            links,
            bodies,
            shapes,
            allowed,
            notices: Vec::new(),
        })
    }

    /// Name of the robot.
    pub fn name(&self) -> &str {
        &self.description.name
    }

    /// What the robot was made from: its joints, also the fixed ones and the mimics, and its
    /// shapes.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Names of the joints whose values make a configuration: those that move and are no mimics, in
    /// the order of the description.
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }

    /// Limits of these joints, in radians or metres; `None` without limits.
    pub fn joint_limits(&self) -> &[Option<[f64; 2]>] {
        &self.limits
    }

    /// Names of the links, in the order of the description.
    pub fn link_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.description.links.iter().map(|link| &*link.name)
    }

    /// Parts of the files that were ignored, such as allowed pairs of links that the robot does not
    /// have.
    pub fn notices(&self) -> &[String] {
        &self.notices
    }

    /// True if this is the name of a shape, or of its link.
    pub(crate) fn is_named(&self, shape: &PlacedShape, name: &str) -> bool {
        let links = &self.description().links;
        let is_link = |link: u32| links[link as usize].name == name;
        *shape.name == *name || shape.link.is_some_and(is_link)
    }

    /// Poses of all links in the world for a configuration.
    ///
    /// Transforms are products in f64 from the root on: `parent * origin * motion`, where the
    /// motion is Rodrigues' formula or a translation along the axis.
    ///
    /// # Errors
    /// [`RobotError::Length`], [`RobotError::JointValue`].
    pub fn link_poses(&self, configuration: &[f64]) -> Result<Vec<Pose>, RobotError> {
        self.check(configuration)?;
        let mut bodies = vec![Transform::IDENTITY; self.bodies.len()];
        self.place_bodies(configuration, &mut bodies);
        let place =
            |&(body, in_body): &(u32, Transform)| to_pose(&(bodies[body as usize] * in_body));
        Ok(self.links.iter().map(place).collect())
    }

    pub(crate) fn link_number(&self, name: &str) -> Result<u32, RobotError> {
        match self.link_names().position(|link| link == name) {
            Some(number) => Ok(number as u32),
            None => refuse(format!("there is no link {name}")),
        }
    }

    /// Refuses values that are not one valid configuration.
    pub(crate) fn check(&self, configuration: &[f64]) -> Result<(), RobotError> {
        let (expected, found) = (self.joint_names.len(), configuration.len());
        if found != expected {
            return Err(RobotError::Length { expected, found });
        }
        self.rows(configuration).map(drop)
    }

    /// Refuses a motion of another robot, or without a piece.
    pub(crate) fn check_motion(&self, motion: &Trajectory) -> Result<(), RobotError> {
        let (expected, found) = (self.joint_names.len(), motion.width());
        if motion.pieces().is_empty() || motion.seconds() > LARGEST {
            return refuse("a trajectory of no piece, or beyond all times");
        }
        match found == expected {
            true => Ok(()),
            false => Err(RobotError::Length { expected, found }),
        }
    }

    /// The number of configurations that lie one after the other, and their length.
    pub(crate) fn rows(&self, values: &[f64]) -> Result<(usize, usize), RobotError> {
        let expected = self.joint_names.len();
        let rows = values.len().checked_div(expected).unwrap_or(1);
        let found = values.len() - rows * expected;
        if found > 0 {
            return Err(RobotError::Length { expected, found });
        }
        match values.iter().position(|v| v.is_nan() || v.abs() > LARGEST) {
            None => Ok((rows, expected)),
            Some(at) => Err(RobotError::JointValue {
                row: at / expected,
                joint: self.joint_names[at % expected].clone(),
            }),
        }
    }

    #[inline]
    pub(crate) fn place_bodies(&self, configuration: &[f64], out: &mut [Transform]) {
        for (i, body) in self.bodies.iter().enumerate().skip(1) {
            let motion = body.motion.at(body.value.at(configuration));
            out[i] = out[body.parent as usize] * body.origin * motion;
        }
    }
}

/// Sorts two values, the lower one first.
pub(crate) fn sorted<T: Ord>([a, b]: [T; 2]) -> [T; 2] {
    if a <= b { [a, b] } else { [b, a] }
}

pub(crate) fn prefixed(place: &str, mut error: RobotError) -> RobotError {
    if let RobotError::Model(what) | RobotError::File { what, .. } = &mut error {
        *what = format!("{place}: {what}");
    }
    error
}

/// Numbers by names; an error if a name occurs twice.
fn numbered<'n>(
    what: &str,
    names: impl Iterator<Item = &'n str>,
) -> Result<HashMap<&'n str, usize>, RobotError> {
    let mut numbers = HashMap::new();
    for (number, name) in names.enumerate() {
        if numbers.insert(name, number).is_some() {
            return refuse(format!("two {what}s are named {name}"));
        }
    }
    Ok(numbers)
}
