//! Decides whether a configuration collides.

use std::sync::Arc;
use std::time::Duration;

use punctual::clock::ClockedBudget;
use punctual::engine::Deadline;
use punctual::{Pose, StopReason};

use crate::call::{Call, Counted, Room};
use crate::error::refuse;
use crate::model::{PlacedShape, prefixed, sorted};
use crate::order::Order;
use crate::transform::{Transform, from_pose};
use crate::world::World;
use crate::{Model, RobotError, Shape, ShapeId};

/// The answer of a call. It is true wherever the budget stops the call.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Outcome<T> {
    /// What is proven.
    pub value: T,
    /// The reason why the call returned: [`StopReason::Finished`], or the end of its budget.
    pub stop: StopReason,
    /// Work of the call, in the unit of [`Budget::work`](punctual::Budget::work). Kinematics and
    /// filters count too.
    pub work: u64,
    /// Duration of the call; measured only under a budget of time.
    pub elapsed: Option<Duration>,
}

/// The answer to the question whether a configuration collides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Collision {
    /// Proven: the shapes of each checked pair are farther apart than their margin
    /// ([`Checker::set_margin`]), or do not meet if it is 0.
    Free,
    /// Proven: these shapes meet, or are no farther apart than their margin.
    Contact([ShapeId; 2]),
    /// The budget ended before the answer was known.
    Undecided,
}

/// A robot among obstacles, and what one thread needs to ask about it.
///
/// Answers are for the poses that [`Model::link_poses`] gives, in f64, and exact for these: no
/// sampling, no tolerance, no spheres in place of meshes. Each pair of shapes is checked, except
/// those of one rigid body, of bodies that stand still in the world, and of links that are allowed
/// to touch.
///
/// It learns which pairs meet often and cost little, and tests these first. So the work and the
/// pair that is named depend on the calls before; the rest of a finished answer does not. Lengths
/// are in metres and angles in radians, if those of the model are.
///
/// ```
/// use punctual::{Budget, Pose, glam::DMat3};
/// use punctual_robot::{Checker, Collision, Description, Joint, JointKind, Link, Model, Shape};
/// let shape = |z| Ok::<_, Box<dyn std::error::Error>>(vec![(
///     Pose::new(DMat3::IDENTITY, [0.0, 0.0, z])?, Shape::cuboid([0.1, 0.1, 1.0])?)]);
/// let robot = Description {
///     links: vec![
///         Link { name: "base".into(), shapes: vec![] },
///         Link { name: "arm".into(), shapes: shape(0.5)? },
///     ],
///     joints: vec![Joint {
///         name: "elbow".into(), kind: JointKind::Revolute,
///         parent: "base".into(), child: "arm".into(),
///         origin: Pose::IDENTITY, axis: [0.0, 1.0, 0.0], limits: Some([-1.0, 1.0]), mimic: None,
///     }],
///     ..Description::default()
/// };
/// let mut checker = Checker::new(Model::new(&robot)?.into());
/// let ball = Pose::new(DMat3::IDENTITY, [0.8, 0.0, 0.5])?;
/// let ball = checker.add("ball", ball, Shape::sphere(0.1)?)?;
/// assert_eq!(checker.collide(&[0.0], Budget::unlimited())?.value, Collision::Free);
/// let arm = checker.find("arm").unwrap();
/// let met = checker.collide(&[1.0], Budget::unlimited())?.value;
/// assert_eq!(met, Collision::Contact([arm, ball]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Checker {
    pub(crate) world: World,
    pub(crate) order: Order,
    pub(crate) room: Room,
    /// The rooms of the threads that run batches.
    pub(crate) rooms: Vec<Room>,
    next: u32,
}

/// Another checker with the same obstacles and the same learned order.
impl Clone for Checker {
    fn clone(&self) -> Self {
        Self::with(self.world.clone(), self.order.clone(), self.next)
    }
}

impl Checker {
    /// A robot without obstacles.
    pub fn new(model: Arc<Model>) -> Self {
        let next = model.shapes.len() as u32;
        let world = World::new(model);
        let order = Order::new(&world);
        Self::with(world, order, next)
    }

    fn with(world: World, order: Order, next: u32) -> Self {
        let mut room = Room::default();
        room.sync(&world);
        Self {
            world,
            order,
            room,
            rooms: Vec::new(),
            next,
        }
    }

    /// The robot.
    pub fn model(&self) -> &Arc<Model> {
        &self.world.model
    }

    /// The pairs of shapes that are checked, each with the lower id first.
    pub fn pairs(&self) -> impl ExactSizeIterator<Item = [ShapeId; 2]> {
        (0..self.world.pairs.len() as u32).map(|pair| self.world.ids_of(pair))
    }

    /// Name of a shape: that of its link or of the obstacle, and the number of the shape if the
    /// link has several (`hand:1`). `None` if the obstacle was removed.
    pub fn name(&self, id: ShapeId) -> Option<&str> {
        Some(&self.world.shapes[self.world.index(id)?].name)
    }

    /// The first shape of this name.
    pub fn find(&self, name: &str) -> Option<ShapeId> {
        let mut shapes = self.world.shapes.iter();
        Some(shapes.find(|shape| &*shape.name == name)?.id)
    }

    /// The shape of this number, if there is one.
    pub fn id(&self, number: u32) -> Option<ShapeId> {
        let id = ShapeId(number);
        self.world.index(id).map(|_| id)
    }

    /// Gives the next obstacle this number, unless it was given already: to restore a checker.
    pub fn number_next(&mut self, number: u32) {
        self.next = self.next.max(number);
    }

    /// Adds an obstacle that stands still in the world, at a pose in the world.
    ///
    /// # Errors
    /// If the pose is not a rotation up to 1e-6, or too far away.
    pub fn add(&mut self, name: &str, pose: Pose, shape: Shape) -> Result<ShapeId, RobotError> {
        self.attach(name, None, pose, shape, &[])
    }

    /// Attaches an obstacle to a link, at a pose in the frame of the link. Without a link it stands
    /// still in the world, at a pose in the world. It is checked against all shapes, except those
    /// of its own rigid body and of the links that it may touch.
    ///
    /// # Errors
    /// [`RobotError::Model`], which names the obstacle: if there is no such link, or a link that it
    /// may touch does not exist, or the pose is not a rotation up to 1e-6, or too far away. Nothing
    /// is added then.
    pub fn attach<'l>(
        &mut self,
        name: &str,
        link: impl Into<Option<&'l str>>,
        pose: Pose,
        shape: Shape,
        may_touch: &[&str],
    ) -> Result<ShapeId, RobotError> {
        let (id, model) = (ShapeId(self.next), self.model());
        let placed = || {
            let place = match link.into() {
                Some(link) => model.links[model.link_number(link)? as usize],
                None => (0, Transform::IDENTITY),
            };
            let touches = may_touch.iter().map(|link| model.link_number(link));
            let touches = touches.collect::<Result<_, _>>();
            let touches = touches.map_err(|error| prefixed("may_touch", error))?;
            let placed = PlacedShape::new(id, name.into(), None, place, &pose, shape)?;
            Ok(PlacedShape { touches, ..placed })
        };
        let placed = placed().map_err(|error| prefixed(&format!("obstacle {name}"), error))?;
        self.next += 1;
        self.world.push(placed);
        self.order.extend(&self.world);
        self.room.begin();
        Ok(id)
    }

    /// Moves an obstacle to another pose, in the frame in which it was added or attached: the world
    /// or its link.
    ///
    /// # Errors
    /// [`RobotError::NoObstacle`], and those of [`Checker::add`].
    pub fn move_to(&mut self, id: ShapeId, pose: Pose) -> Result<(), RobotError> {
        let at = self.world.obstacle(id)?;
        let pose = from_pose(&pose)?;
        if self.world.set_track(at, None) {
            self.renew();
        }
        let shape = &mut self.world.shapes[at];
        shape.in_body = shape.frame * pose;
        self.world.change(Some(at));
        self.room.begin();
        Ok(())
    }

    /// Removes an obstacle.
    ///
    /// # Errors
    /// [`RobotError::NoObstacle`].
    pub fn remove(&mut self, id: ShapeId) -> Result<(), RobotError> {
        let at = self.world.obstacle(id)?;
        self.world.set_track(at, None);
        match self.world.remove(at) {
            Some(numbers) => self.order.keep(&numbers),
            None => self.order = Order::new(&self.world),
        }
        self.room.begin();
        Ok(())
    }

    /// Sets whether two links or obstacles may touch: pairs that may are not checked. The last call
    /// for a pair counts, before the description and [`Checker::attach`]. A link stands for all its
    /// shapes. Obstacles that are added later follow the calls for their names; pairs that never
    /// move relative to each other stay unchecked. Lists all pairs anew.
    ///
    /// # Errors
    /// [`RobotError::Model`] if there is no link or obstacle of a name. Nothing is changed then.
    pub fn allow(&mut self, names: [&str; 2], may_touch: bool) -> Result<(), RobotError> {
        if let Some(name) = names.iter().find(|name| !self.world.knows(name)) {
            return refuse(format!("allow: there is no link or obstacle {name}"));
        }
        let names = sorted(names.map(String::from));
        self.world.set_pairs.retain(|set| set.0 != names);
        self.world.set_pairs.push((names, may_touch));
        self.world.pair();
        self.world.change(None);
        self.renew();
        Ok(())
    }

    /// Takes over pairs that were listed anew.
    pub(crate) fn renew(&mut self) {
        self.order = Order::new(&self.world);
        self.room.begin();
    }

    /// Decides whether a configuration collides. Stops at the first pair that meets.
    ///
    /// # Errors
    /// [`RobotError::Length`], [`RobotError::JointValue`].
    pub fn collide<'c>(
        &mut self,
        configuration: &[f64],
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Outcome<Collision>, RobotError> {
        let call = self.begin(configuration, budget.into())?;
        Ok(call.collide(configuration))
    }

    /// Lists all pairs that meet, as far as the budget reaches. They replace the content of
    /// `pairs`, in the order of ids. [`Collision::Free`] and [`Collision::Contact`] mean what they
    /// mean for [`Checker::collide`]. The list is complete if the stop is [`StopReason::Finished`].
    ///
    /// # Errors
    /// Those of [`Checker::collide`].
    pub fn collide_all<'c>(
        &mut self,
        configuration: &[f64],
        budget: impl Into<ClockedBudget<'c>>,
        pairs: &mut Vec<[ShapeId; 2]>,
    ) -> Result<Outcome<Collision>, RobotError> {
        let mut call = self.begin(configuration, budget.into())?;
        pairs.clear();
        let mut find = || {
            call.put(configuration, 0.0)?;
            let mut cursor = 0;
            while let Some(pair) = call.find(&mut cursor)? {
                pairs.push(call.world.ids_of(pair));
                cursor += 1;
            }
            Ok(())
        };
        let end = find();
        pairs.sort_unstable();
        Ok(call.collision(pairs.first(), end))
    }

    /// Begins a call, after a check of its first configuration.
    pub(crate) fn begin<'c>(
        &'c mut self,
        configuration: &[f64],
        budget: ClockedBudget<'c>,
    ) -> Result<Call<'c, 'c>, RobotError> {
        self.world.model.check(configuration)?;
        self.sync(1);
        Ok(self.call(budget))
    }

    /// Takes over what has changed in the world, and counts configurations.
    pub(crate) fn sync(&mut self, configurations: u64) {
        self.order.count(configurations, &self.world);
        self.room.sync(&self.world);
    }

    /// Begins a call that continues with what the last one has left.
    pub(crate) fn call<'c>(&'c mut self, budget: ClockedBudget<'c>) -> Call<'c, 'c> {
        Call {
            world: &self.world,
            order: &self.order.sorted,
            facts: &mut self.order.facts,
            room: &mut self.room,
            deadline: Deadline::of(budget),
            pairs: Counted::All,
        }
    }
}

impl Call<'_, '_> {
    pub fn collide(mut self, configuration: &[f64]) -> Outcome<Collision> {
        let found = self.put(configuration, 0.0);
        let found = found.and_then(|()| self.find(&mut 0));
        let met = found.ok().flatten().map(|pair| self.world.ids_of(pair));
        self.collision(met.as_ref(), found.map(drop))
    }

    fn collision(
        &mut self,
        met: Option<&[ShapeId; 2]>,
        end: Result<(), StopReason>,
    ) -> Outcome<Collision> {
        let value = match (met, end) {
            (Some(&pair), _) => Collision::Contact(pair),
            (None, Ok(())) => Collision::Free,
            (None, Err(_)) => Collision::Undecided,
        };
        self.outcome(value, end)
    }
}
