//! The robot: links, joints, shapes, and where they are for joint values.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use punctual::Pose;
use punctual::glam::{DMat3, DVec3};

use crate::transform::{Transform, rotation_about};
use crate::{RobotError, Shape};

/// Largest joint value, factor or length (m), so that squares of all that follows are finite.
pub(crate) const LARGEST: f64 = 1e30;

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
    /// Lower and upper limit, in radians or metres. Only told to callers, never enforced.
    pub limits: Option<[f64; 2]>,
    /// The joint that it follows, if any.
    pub mimic: Option<Mimic>,
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
    /// Pairs of links never asked. Links of one rigid body are never asked either.
    pub allowed: Vec<[String; 2]>,
    /// Nor are links that are joined by one moving joint, with all that fixed joints hold to them.
    pub allows_neighbours: bool,
}

/// A robot: immutable, to be shared between threads in an [`Arc`].
///
/// The root link stands still at the origin of the world. A *configuration* has one value for each
/// joint that moves and is no mimic, in the order of [`Model::joint_names`].
#[derive(Debug)]
pub struct Model {
    name: String,
    joint_names: Vec<String>,
    limits: Vec<Option<[f64; 2]>>,
    links: Vec<PlacedLink>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) shapes: Vec<PlacedShape>,
    /// Pairs of link numbers never asked, the lower one first.
    pub(crate) allowed: BTreeSet<[u32; 2]>,
    pub(crate) notices: Vec<String>,
}

#[derive(Debug)]
struct PlacedLink {
    name: String,
    body: u32,
    in_body: Transform,
}

/// A shape that is part of a rigid body.
#[derive(Clone, Debug)]
pub(crate) struct PlacedShape {
    pub name: Arc<str>,
    /// Number of the link; `None` for obstacles, attached ones too.
    pub link: Option<u32>,
    /// Links that an attached obstacle may touch.
    pub touches: Vec<u32>,
    pub body: u32,
    /// Frame of the link, or of the world, in the body; and of the shape in the body.
    pub frame: Transform,
    pub in_body: Transform,
    pub shape: Shape,
}

/// A rigid body behind a moving joint; the first one is the world, which holds the root.
#[derive(Debug)]
pub(crate) struct Body {
    pub parent: u32,
    /// Frame of the joint in the frame of the parent body.
    pub origin: Transform,
    pub motion: Motion,
    /// Number of the joint value, and the value of this joint: `multiplier * value + offset`.
    pub value: u32,
    pub multiplier: f64,
    pub offset: f64,
    /// The moving joints from the root to this one, by their bodies; the world has none.
    pub chain: Vec<u32>,
}

/// How a body moves with its joint's value, along or about a unit axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    Turn(DVec3),
    Slide(DVec3),
}

impl Motion {
    fn at(self, value: f64) -> Transform {
        match self {
            Self::Turn(axis) => Transform {
                r: rotation_about(axis, value),
                t: DVec3::ZERO,
            },
            Self::Slide(axis) => Transform {
                r: DMat3::IDENTITY,
                t: axis * value,
            },
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
        let Description {
            links: given,
            joints,
            ..
        } = description;
        let numbers = numbered("link", given.iter().map(|link| link.name.as_str()))?;
        let joint_numbers = numbered("joint", joints.iter().map(|joint| joint.name.as_str()))?;
        let link = |name: &str, of: &str| {
            let found = numbers.get(name).copied();
            found.ok_or_else(|| RobotError::model(format!("{of}: there is no link {name}")))
        };
        // The joint that holds each link.
        let mut holder: Vec<Option<usize>> = vec![None; given.len()];
        for (number, joint) in joints.iter().enumerate() {
            let of = format!("joint {}", joint.name);
            link(&joint.parent, &of)?;
            let child = link(&joint.child, &of)?;
            if let Some(other) = holder[child].replace(number) {
                return Err(RobotError::model(format!(
                    "{of}: its child {} is held by joint {} already",
                    joint.child, joints[other].name
                )));
            }
        }
        let mut roots = (0..given.len()).filter(|&i| holder[i].is_none());
        let root = roots
            .next()
            .ok_or_else(|| RobotError::model("no root: each link is the child of a joint"))?;
        if let Some(second) = roots.next() {
            return Err(RobotError::model(format!(
                "links {} and {} are not connected: each is the child of no joint",
                given[root].name, given[second].name
            )));
        }
        let values = Values::new(joints, &joint_numbers)?;

        let mut bodies = vec![Body {
            parent: 0,
            origin: Transform::IDENTITY,
            motion: Motion::Slide(DVec3::X),
            value: 0,
            multiplier: 0.0,
            offset: 0.0,
            chain: Vec::new(),
        }];
        let mut places = vec![None; given.len()];
        places[root] = Some((0, Transform::IDENTITY));
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); given.len()];
        for (number, joint) in joints.iter().enumerate() {
            children[link(&joint.parent, "")?].push(number);
        }
        // Depth first, so that parents come before children, in the order of the joints.
        let mut open: Vec<usize> = children[root].iter().rev().copied().collect();
        while let Some(number) = open.pop() {
            let joint = &joints[number];
            let fail = |error| prefixed(&format!("joint {}", joint.name), error);
            let (parent, child) = (link(&joint.parent, "")?, link(&joint.child, "")?);
            let Some((body, in_body)) = places[parent] else {
                continue;
            };
            let origin = in_body.then(&Transform::from_pose(&joint.origin).map_err(fail)?);
            let motion = motion(joint).map_err(fail)?;
            let Value {
                value,
                multiplier,
                offset,
            } = values.of[number];
            places[child] = Some(match (motion, value) {
                (None, _) => (body, origin),
                // Follows a fixed joint: stands still at its offset.
                (Some(motion), None) => (body, origin.then(&motion.at(offset))),
                (Some(motion), Some(value)) => {
                    let number = bodies.len() as u32;
                    let mut chain = bodies[body as usize].chain.clone();
                    chain.push(number);
                    bodies.push(Body {
                        parent: body,
                        origin,
                        motion,
                        value,
                        multiplier,
                        offset,
                        chain,
                    });
                    (number, Transform::IDENTITY)
                }
            });
            open.extend(children[child].iter().rev());
        }
        let mut links = Vec::new();
        let mut shapes = Vec::new();
        for (number, link) in given.iter().enumerate() {
            let of = format!("link {}", link.name);
            let (body, in_body) = places[number].ok_or_else(|| {
                RobotError::model(format!(
                    "{of}: not connected to the root, by joints in a circle"
                ))
            })?;
            for (i, (pose, shape)) in link.shapes.iter().enumerate() {
                let pose = Transform::from_pose(pose).map_err(|error| prefixed(&of, error))?;
                if shape.inner().radius > LARGEST {
                    return Err(RobotError::model(format!("{of}: larger than {LARGEST:e}")));
                }
                let name = match link.shapes.len() {
                    1 => link.name.clone(),
                    _ => format!("{}:{i}", link.name),
                };
                shapes.push(PlacedShape {
                    name: name.into(),
                    link: Some(number as u32),
                    touches: Vec::new(),
                    body,
                    frame: in_body,
                    in_body: in_body.then(&pose),
                    shape: shape.clone(),
                });
            }
            links.push(PlacedLink {
                name: link.name.clone(),
                body,
                in_body,
            });
        }
        let mut allowed = BTreeSet::new();
        for [a, b] in &description.allowed {
            let pair = [link(a, "allowed pair")?, link(b, "allowed pair")?];
            allowed.insert(sorted(pair.map(|i| i as u32)));
        }
        for (a, x) in (0..).zip(&links) {
            let parent = bodies[x.body as usize].parent;
            let near = (0..)
                .zip(&links)
                .filter(|(_, y)| x.body != 0 && y.body == parent);
            if description.allows_neighbours {
                allowed.extend(near.map(|(b, _)| sorted([a, b])));
            }
        }
        Ok(Self {
            name: description.name.clone(),
            joint_names: values.names,
            limits: values.limits,
            links,
            bodies,
            shapes,
            allowed,
            notices: Vec::new(),
        })
    }

    /// Name of the robot.
    pub fn name(&self) -> &str {
        &self.name
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
        self.links.iter().map(|link| link.name.as_str())
    }

    /// What was passed over to read the robot, such as allowed pairs of links that it does not
    /// have.
    pub fn notices(&self) -> &[String] {
        &self.notices
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
        let place = |link: &PlacedLink| bodies[link.body as usize].then(&link.in_body).pose();
        Ok(self.links.iter().map(place).collect())
    }

    pub(crate) fn link_number(&self, name: &str) -> Result<u32, RobotError> {
        let found = self.links.iter().position(|link| link.name == name);
        let found = found.ok_or_else(|| RobotError::model(format!("there is no link {name}")));
        Ok(found? as u32)
    }

    /// Body of a link, and the frame of the link in it.
    pub(crate) fn place_of(&self, link: u32) -> (u32, Transform) {
        let link = &self.links[link as usize];
        (link.body, link.in_body)
    }

    /// Refuses configurations of the wrong length and values that are not finite or too large.
    pub(crate) fn check(&self, configuration: &[f64]) -> Result<(), RobotError> {
        self.check_rows(configuration, 1)
    }

    /// The same for `rows` configurations, one after the other.
    pub(crate) fn check_rows(&self, values: &[f64], rows: usize) -> Result<(), RobotError> {
        let expected = self.joint_names.len();
        if values.len() != expected * rows {
            let found = values.len().checked_div(rows).unwrap_or(values.len());
            return Err(RobotError::Length { expected, found });
        }
        match values.iter().position(|v| v.is_nan() || v.abs() > LARGEST) {
            None => Ok(()),
            Some(at) => Err(RobotError::JointValue {
                row: at / expected,
                joint: self.joint_names[at % expected].clone(),
            }),
        }
    }

    #[inline]
    pub(crate) fn place_bodies(&self, configuration: &[f64], out: &mut [Transform]) {
        for i in 1..self.bodies.len() {
            let body = &self.bodies[i];
            let value = body.multiplier * configuration[body.value as usize] + body.offset;
            let parent = out[body.parent as usize];
            let joint = parent.then(&body.origin);
            out[i] = match body.motion {
                Motion::Turn(axis) => Transform {
                    r: joint.r * rotation_about(axis, value),
                    t: joint.t,
                },
                Motion::Slide(axis) => Transform {
                    r: joint.r,
                    t: joint.t + joint.r * (axis * value),
                },
            };
        }
    }
}

/// The lower one first.
pub(crate) fn sorted<T: Ord>([a, b]: [T; 2]) -> [T; 2] {
    if a <= b { [a, b] } else { [b, a] }
}

pub(crate) fn prefixed(place: &str, error: RobotError) -> RobotError {
    match error {
        RobotError::Model(what) => RobotError::Model(format!("{place}: {what}")),
        other => other,
    }
}

/// Numbers by names; an error if a name occurs twice.
fn numbered<'n>(
    what: &str,
    names: impl Iterator<Item = &'n str>,
) -> Result<HashMap<&'n str, usize>, RobotError> {
    let mut numbers = HashMap::new();
    for (number, name) in names.enumerate() {
        if numbers.insert(name, number).is_some() {
            return Err(RobotError::model(format!("two {what}s are named {name}")));
        }
    }
    Ok(numbers)
}

/// The motion of a joint along or about its unit axis; `None` if it is fixed.
fn motion(joint: &Joint) -> Result<Option<Motion>, RobotError> {
    if joint.kind == JointKind::Fixed {
        return Ok(None);
    }
    let axis = DVec3::from_array(joint.axis);
    let length = axis.length();
    if !(length > 0.0 && length.is_finite()) {
        return Err(RobotError::model(format!(
            "axis {:?}, must have a direction",
            joint.axis
        )));
    }
    let axis = axis / length;
    Ok(Some(match joint.kind {
        JointKind::Prismatic => Motion::Slide(axis),
        _ => Motion::Turn(axis),
    }))
}

/// The value of a joint: `multiplier * configuration[value] + offset`; constant without `value`.
#[derive(Clone, Copy)]
struct Value {
    value: Option<u32>,
    multiplier: f64,
    offset: f64,
}

/// Values of all joints, and the joints that make a configuration.
struct Values {
    of: Vec<Value>,
    names: Vec<String>,
    limits: Vec<Option<[f64; 2]>>,
}

impl Values {
    fn new(joints: &[Joint], numbers: &HashMap<&str, usize>) -> Result<Self, RobotError> {
        let (mut names, mut limits) = (Vec::new(), Vec::new());
        let mut own = vec![None; joints.len()];
        for (number, joint) in joints.iter().enumerate() {
            if joint.kind != JointKind::Fixed && joint.mimic.is_none() {
                own[number] = Some(names.len() as u32);
                names.push(joint.name.clone());
                limits.push(joint.limits);
            }
        }
        let follow = |number: usize| {
            let (mut at, mut multiplier, mut offset) = (number, 1.0, 0.0);
            for _ in 0..=joints.len() {
                // A mimic tag on a fixed joint moves nothing.
                let mimic = match &joints[at].mimic {
                    Some(mimic) if joints[at].kind != JointKind::Fixed => mimic,
                    _ => {
                        return Ok(Value {
                            value: own[at],
                            multiplier,
                            offset,
                        });
                    }
                };
                offset += multiplier * mimic.offset;
                multiplier *= mimic.multiplier;
                if !(offset.abs() <= LARGEST && multiplier.abs() <= LARGEST) {
                    let what = format!("joint {}: mimic of more than {LARGEST}", joints[at].name);
                    return Err(RobotError::model(what));
                }
                at = *numbers.get(mimic.joint.as_str()).ok_or_else(|| {
                    RobotError::model(format!(
                        "joint {}: mimics {}, which there is not",
                        joints[at].name, mimic.joint
                    ))
                })?;
            }
            let what = format!("joint {}: mimics itself", joints[number].name);
            Err(RobotError::model(what))
        };
        let of = (0..joints.len()).map(follow).collect::<Result<_, _>>()?;
        Ok(Self { of, names, limits })
    }
}
