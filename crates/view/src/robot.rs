//! A robot: at each of some configurations how far its links are from contact, and sliders that move its joints.

use std::collections::{BTreeSet, HashMap};
use std::f64::consts::PI;

use punctual::glam::DVec3;
use punctual::{Aabb, Budget, Pose};
use punctual_robot::{
    Checker, Clearance, ClearanceOptions, Description, Joint, JointKind, RobotError, Scope, Shape,
    ShapeId,
};
use serde_json::{Value, json};

use crate::stage::{Fact, Stage, count, fact, length, placed, round_length};
use crate::{Up, View};

/// Limits of what is far and near, over the longest extent of all that is shown, rounded.
const FAR: f64 = 0.05;
const NEAR: f64 = 0.01;

/// Width of the bounds of a clearance, over the longest extent.
const TOLERANCE: f64 = 1e-6;

/// An obstacle of the checker, at its pose in the world, or in the frame of a link.
pub struct Obstacle<'o> {
    /// Its number.
    pub id: ShapeId,
    /// The link that it is attached to, if any.
    pub link: Option<&'o str>,
    /// Where it is.
    pub pose: Pose,
    /// What it is.
    pub shape: Shape,
}

/// A shape that is drawn.
struct Drawn {
    id: ShapeId,
    link: Option<usize>,
    pose: Pose,
    shape: Shape,
}

impl Drawn {
    fn new(id: ShapeId, link: Option<usize>, pose: Pose, shape: &Shape) -> Self {
        let shape = shape.clone();
        Self {
            id,
            link,
            pose,
            shape,
        }
    }

    fn at(&self, links: &[Pose]) -> Pose {
        self.link
            .map_or(self.pose, |link| links[link].compose_unchecked(&self.pose))
    }
}

/// What is known of one configuration.
struct Known {
    met: Vec<[ShapeId; 2]>,
    /// True if `met` has all pairs that meet.
    is_whole: bool,
    /// Of the whole robot.
    clearance: Clearance,
    /// Proven lower bounds of the clearance of each shape that is part of a link.
    each: Vec<f64>,
}

/// A page for a robot among obstacles at configurations, each with its number. Each question about a
/// configuration has the budget: which pairs meet, and how far the robot and each of its shapes are
/// from contact.
///
/// # Errors
/// [`RobotError::Length`], [`RobotError::JointValue`].
pub fn robot(
    title: String,
    checker: &mut Checker,
    obstacles: &[Obstacle],
    configurations: &[(usize, &[f64])],
    budget: Budget,
) -> Result<View, RobotError> {
    let model = checker.model().clone();
    let description = model.description();
    let number = |name: &str| model.link_names().position(|link| link == name);
    let own = description.links.iter().enumerate();
    let own = own.flat_map(|(i, link)| {
        link.shapes
            .iter()
            .map(move |(pose, shape)| (i, pose, shape))
    });
    let own = own.zip(0..).filter_map(|((link, pose, shape), id)| {
        Some(Drawn::new(checker.id(id)?, Some(link), *pose, shape))
    });
    let others = obstacles.iter();
    let others = others.map(|o| Drawn::new(o.id, o.link.and_then(number), o.pose, &o.shape));
    let mut drawn: Vec<Drawn> = own.chain(others).collect();
    // The page places those of links.
    drawn.sort_by_key(|drawn| drawn.link.is_none());
    let places: HashMap<_, _> = drawn
        .iter()
        .zip(0..)
        .map(|(drawn, i)| (drawn.id, i))
        .collect();

    let links = configurations.iter().map(|(_, q)| model.link_poses(q));
    let links = links.collect::<Result<Vec<_>, _>>()?;
    let boxes = links.iter().flat_map(|links| {
        drawn
            .iter()
            .map(|d| placed(d.shape.surface(), &d.at(links)))
    });
    let bounds = boxes.fold(Aabb::EMPTY, |bounds, one| bounds.union(&one));
    let mut stage = Stage::new(bounds);
    let longest = 2.0 * stage.radius();
    let [far, near] = [FAR, NEAR].map(|share| round_length(share * longest));
    let meshes = drawn.iter().map(|drawn| stage.mesh(drawn.shape.surface()));
    let meshes: Vec<usize> = meshes.collect();
    let [segments, listed] = [0; 2].map(|_| stage.arrays.add());

    let moving = drawn.iter().take_while(|drawn| drawn.link.is_some());
    let moving: Vec<ShapeId> = moving.map(|drawn| drawn.id).collect();
    let (mut steps, mut told) = (Vec::new(), BTreeSet::from(["unasked", "near"]));
    for ((number, q), links) in configurations.iter().zip(&links) {
        let known = ask(checker, q, &moving, TOLERANCE * longest, budget)?;
        let met = known.met.iter().flatten().filter_map(|id| places.get(id));
        let met: Vec<u32> = met.copied().collect();
        let layer = |i: usize| match known.each.get(i) {
            _ if met.contains(&(i as u32)) => "b",
            None => "fixed",
            Some(&low) if low >= far => "a",
            Some(&low) if low >= near => "mid",
            Some(&low) if low > 0.0 => "close",
            Some(_) => "doubt",
        };
        let surface = |(i, drawn): (usize, &Drawn)| {
            let pose = stage.pose(meshes[i], &drawn.at(links));
            stage.whole(layer(i), [meshes[i], pose])
        };
        let surfaces: Vec<_> = drawn.iter().enumerate().map(surface).collect();
        told.extend((0..drawn.len()).map(layer));
        let around = met.iter().map(|&i| &drawn[i as usize]);
        let around = around.map(|drawn| placed(drawn.shape.surface(), &drawn.at(links)));
        let around = around.fold(Aabb::EMPTY, |all, one| all.union(&one));
        let nearest = known.clearance.points;
        let nearest = (nearest[0] != nearest[1]).then_some(nearest);
        steps.push(json!({
            "name": number.to_string(), "facts": facts(checker, &known), "surfaces": surfaces,
            "values": q, "lines": [["near", stage.segments(segments, nearest)]],
            "pairs": [stage.arrays.extend(listed, met)],
            "focus": stage.focus(&around),
        }));
    }
    let key = [
        ("a", format!("no closer than {far} m to others: proven")),
        ("mid", format!("no closer than {near} m: proven")),
        ("close", "closer, not in contact: proven".into()),
        ("b", "meets another: proven".into()),
        ("doubt", "not known".into()),
        ("unasked", "moved by hand: not asked".into()),
        ("fixed", "obstacles".into()),
        ("near", "between the closest points".into()),
    ];
    let key = key.into_iter().filter(|(layer, _)| told.contains(layer));
    let robot = mechanism(
        &stage,
        description,
        configurations,
        drawn.iter().zip(&meshes),
    );
    let name = |drawn: &Drawn| checker.name(drawn.id).unwrap_or_default().to_owned();
    Ok(View {
        title,
        key: key.collect(),
        steps,
        start: 0,
        slider: "Configuration",
        times: None,
        names: Some(drawn.iter().map(name).collect()),
        robot: Some(robot),
        up: Up::Z,
        stage,
    })
}

fn ask(
    checker: &mut Checker,
    q: &[f64],
    moving: &[ShapeId],
    tolerance: f64,
    budget: Budget,
) -> Result<Known, RobotError> {
    let mut met = Vec::new();
    let is_whole = checker.collide_all(q, budget, &mut met)?.stop.is_final();
    let mut clearance = |scope| {
        let options = ClearanceOptions::default();
        let options = options.tolerance(tolerance).scope(scope);
        Ok::<_, RobotError>(checker.clearance(q, &options, budget)?.value)
    };
    Ok(Known {
        met,
        is_whole,
        clearance: clearance(Scope::All)?,
        each: moving
            .iter()
            .map(|&id| Ok(clearance(Scope::Shape(id))?.low))
            .collect::<Result<_, RobotError>>()?,
    })
}

fn facts(checker: &Checker, known: &Known) -> Vec<Fact> {
    let Clearance {
        low, high, pair, ..
    } = known.clearance;
    let metres = |bound: f64| match bound.is_finite() {
        true => format!("{} m", length(bound)),
        false => length(bound),
    };
    let closest = pair.map(|pair| pair.map(|id| checker.name(id).unwrap_or_default()));
    vec![
        fact("Clearance, at least", metres(low)),
        fact("Clearance, at most", metres(high)),
        fact(
            "Closest pair",
            closest.map_or("none".into(), |pair| pair.join(" and ")),
        ),
        match known.is_whole {
            true => fact("Pairs that meet", count(known.met.len() as u64)),
            false => fact("Pairs that meet, at least", count(known.met.len() as u64)),
        },
    ]
}

/// What the page needs to place links: joints, the ranges of their values, and shapes of links. Lengths
/// are over the radius of the stage.
fn mechanism<'d>(
    stage: &Stage,
    description: &Description,
    configurations: &[(usize, &[f64])],
    drawn: impl Iterator<Item = (&'d Drawn, &'d usize)>,
) -> Value {
    let Description { links, joints, .. } = description;
    let joint = |joint: &Joint| {
        let axis = DVec3::from_array(joint.axis).normalize_or_zero();
        let (kind, axis) = match joint.kind {
            JointKind::Fixed => ("fixed", axis),
            JointKind::Prismatic => ("slide", axis / stage.radius()),
            _ => ("turn", axis),
        };
        let mimic = joint.mimic.as_ref();
        json!({
            "name": joint.name, "kind": kind, "parent": joint.parent, "child": joint.child,
            "origin": stage.rows(&joint.origin, DVec3::ZERO), "axis": axis.to_array(),
            "mimic": mimic.map(|mimic| json!([mimic.joint, mimic.multiplier, mimic.offset])),
        })
    };
    let movable = joints.iter().filter(|joint| joint.moves_alone());
    let range = |(i, joint): (usize, &Joint)| {
        let [mut low, mut high] = joint.limits.unwrap_or_default();
        if low >= high {
            [low, high] = match joint.kind {
                JointKind::Prismatic => [-stage.radius(), stage.radius()],
                _ => [-PI, PI],
            };
        }
        let values = configurations.iter().map(|(_, q)| q[i]);
        let [low, high] = values.fold([low, high], |[low, high], q| [low.min(q), high.max(q)]);
        json!([joint.name, low, high])
    };
    let shape = |(drawn, &mesh): (&Drawn, &usize)| {
        let link = drawn.link?;
        let rows = stage.rows(&drawn.pose, stage.middle_of(mesh));
        Some(json!([links[link].name, rows]))
    };
    json!({
        "joints": joints.iter().map(joint).collect::<Vec<_>>(),
        "ranges": movable.enumerate().map(range).collect::<Vec<_>>(),
        "shapes": drawn.filter_map(shape).collect::<Vec<_>>(),
        "origin": stage.point(DVec3::ZERO),
    })
}
