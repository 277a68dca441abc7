//! A scene: frame by frame, which bodies meet others, and of which that is not known.

use std::collections::HashMap;
use std::sync::Arc;

use punctual::glam::DVec3;
use punctual::{Aabb, Pose, Verdict};
use punctual_scene::{Body, BodyKind, Report};
use serde_json::json;

use crate::stage::{Fact, NORMAL, Stage, count, fact, placed};
use crate::up::{self, Guess};
use crate::{Up, View};

/// Frames that are shown, at equal distances.
const MOST_FRAMES: usize = 120;

/// A frame: its number, a pose for each body, what is known of them, and the lines of the table.
pub struct Frame<'r> {
    /// Counted from 0.
    pub number: usize,
    /// Of each body, in the scene.
    pub poses: &'r [Pose],
    /// What was reported.
    pub known: &'r Known,
    /// Points where bodies touch, and the normals there.
    pub contacts: &'r [[DVec3; 2]],
    /// Lines of the table, after those of what is known.
    pub facts: Vec<Fact>,
}

/// A body that is shown.
pub struct Shown<'b> {
    /// Its index in reports.
    pub index: usize,
    /// What it is called.
    pub name: String,
    /// What it is.
    pub body: &'b Body,
}

/// What a frame tells of bodies, by their indices.
#[derive(Clone, Debug, Default)]
pub struct Known {
    pairs: Vec<([usize; 2], Verdict)>,
    /// Pairs that are not among them, though known.
    unlisted: usize,
    /// Bodies that not all partners are known of.
    unpaired: usize,
}

impl Known {
    /// What this report says.
    pub fn of(report: &Report) -> Self {
        let pairs = report
            .pairs
            .iter()
            .map(|pair| ([pair.a.index(), pair.b.index()], pair.verdict));
        let unpaired = report.unplaced + report.unpaired;
        Self {
            pairs: pairs.collect(),
            unlisted: report.unlisted,
            unpaired,
        }
    }

    /// Whether bodies that are in no pair together are known not to meet.
    fn is_whole(&self) -> bool {
        (self.unlisted, self.unpaired) == (0, 0)
    }

    /// The pairs that intersect, those within their margins, and those of which it is not known, by the places of their
    /// bodies.
    fn told(&self, places: &HashMap<usize, usize>) -> [Vec<[usize; 2]>; 3] {
        let mut pairs = [const { Vec::new() }; 3];
        for ([a, b], verdict) in &self.pairs {
            let (Some(&a), Some(&b)) = (places.get(a), places.get(b)) else {
                continue;
            };
            match verdict {
                Verdict::Intersecting { .. } | Verdict::Contained { .. } => pairs[0].push([a, b]),
                Verdict::Within { .. } => pairs[1].push([a, b]),
                Verdict::Undecided => pairs[2].push([a, b]),
                Verdict::Separated => {}
            }
        }
        pairs
    }

    fn facts(&self, [meeting, open]: [usize; 2]) -> [Fact; 4] {
        let lines = [
            (
                "Pairs of boxes that overlap",
                self.pairs.len() + self.unlisted,
            ),
            ("Of these, meeting", meeting),
            ("Not known", open + self.unlisted),
            ("Bodies not placed or not paired", self.unpaired),
        ];
        lines.map(|(name, number)| fact(name, count(number as u64)))
    }
}

/// Of so many frames, each that is shown is so many after the one before.
pub fn stride(frames: usize) -> usize {
    frames.div_ceil(MOST_FRAMES).max(1)
}

/// A page for bodies, and what was reported of them.
pub fn scene(title: String, bodies: &[Shown], frames: &[Frame]) -> View {
    let lying = |frame: &Frame, i: usize| placed(&bodies[i].body.tree, &frame.poses[i]);
    let all = frames
        .iter()
        .flat_map(|frame| (0..bodies.len()).map(move |i| lying(frame, i)));
    let mut stage = Stage::new(all.fold(Aabb::EMPTY, |bounds, body| bounds.union(&body)));
    stage.up = guess_up(bodies, frames);
    let mut known = HashMap::new();
    let mut mesh = |body: &Body| {
        *known
            .entry(Arc::as_ptr(&body.tree))
            .or_insert_with(|| stage.mesh(&body.tree))
    };
    let meshes: Vec<usize> = bodies.iter().map(|shown| mesh(shown.body)).collect();
    let places: HashMap<usize, usize> = bodies
        .iter()
        .enumerate()
        .map(|(place, shown)| (shown.index, place))
        .collect();
    let [drawn, listed] = [0; 2].map(|_| stage.arrays.add());
    let steps = frames.iter().map(|frame| {
        let [intersecting, within, open] = frame.known.told(&places);
        let layers = layers(bodies, frame.known.is_whole(), [&open, &within, &intersecting]);
        let meeting = [intersecting, within].concat();
        let draw = |i: usize| {
            let pose = stage.pose(meshes[i], &frame.poses[i]);
            stage.whole(layers[i], [meshes[i], pose])
        };
        let surfaces: Vec<_> = (0..bodies.len()).map(draw).collect();
        let met = (0..bodies.len()).filter(|&i| ["b", "within"].contains(&layers[i]));
        let around = met.fold(Aabb::EMPTY, |around, i| around.union(&lying(frame, i)));
        let long = NORMAL * stage.radius();
        let normals = frame.contacts.iter().map(|&[point, normal]| [point, point + long * normal]);
        let mut lines = vec![("normal", stage.segments(drawn, normals))];
        if !open.is_empty() {
            let between = open.iter().map(|pair| pair.map(|i| lying(frame, i).center()));
            lines.push(("open", stage.segments(drawn, between)));
        }
        let pairs =
            [&meeting, &open].map(|pairs| stage.arrays.extend(listed, pairs.iter().flatten().map(|&i| i as u32)));
        let facts: Vec<_> =
            frame.known.facts([meeting.len(), open.len()]).iter().chain(&frame.facts).cloned().collect();
        let (name, focus) = (frame.number.to_string(), stage.focus(&around));
        json!({ "name": name, "facts": facts, "surfaces": surfaces, "lines": lines, "pairs": pairs, "focus": focus })
    });
    let steps = steps.collect();
    let has_margins = bodies.iter().any(|shown| shown.body.margin > 0.0);
    let has_open = frames
        .iter()
        .flat_map(|frame| &frame.known.pairs)
        .any(|(_, verdict)| *verdict == Verdict::Undecided);
    let key = [
        ("a", "meets no other: proven", true),
        ("b", "meets another: proven", true),
        (
            "within",
            "within the margins of another: proven",
            has_margins,
        ),
        ("doubt", "not known", true),
        ("fixed", "fixed bodies", true),
        (
            "open",
            "lines between bodies of which it is not known",
            has_open,
        ),
        (
            "normal",
            "normals where bodies touch",
            frames.iter().any(|frame| !frame.contacts.is_empty()),
        ),
    ];
    let key = key
        .iter()
        .filter(|line| line.2)
        .map(|&(layer, text, _)| (layer, text.to_owned()))
        .collect();
    let names = Some(bodies.iter().map(|shown| shown.name.clone()).collect());
    View {
        title,
        key,
        stage,
        steps,
        start: 0,
        slider: "Frame",
        times: None,
        names,
        robot: None,
        up: Up::Guess,
    }
}

fn guess_up(bodies: &[Shown], frames: &[Frame]) -> Guess {
    let poses = frames.first().map_or(&[][..], |frame| frame.poses);
    let has_fixed = bodies
        .iter()
        .any(|shown| shown.body.kind == BodyKind::Fixed);
    let standing = bodies
        .iter()
        .zip(poses)
        .filter(|(shown, _)| !has_fixed || shown.body.kind == BodyKind::Fixed);
    let standing: Vec<_> = standing
        .map(|(shown, pose)| (shown.body.tree.mesh(), pose))
        .collect();
    up::guess(bodies.iter().map(|shown| &*shown.name), &standing)
}

/// The layer of each body: what is known of all its pairs together.
fn layers(bodies: &[Shown], is_whole: bool, pairs: [&[[usize; 2]]; 3]) -> Vec<&'static str> {
    let alone = if is_whole { "a" } else { "doubt" };
    let mut layers = vec![alone; bodies.len()];
    // What is told of one pair hides what is told of another by those before.
    for (layer, pairs) in ["doubt", "within", "b"].into_iter().zip(pairs) {
        pairs.iter().flatten().for_each(|&i| layers[i] = layer);
    }
    let fixed = (0..bodies.len()).filter(|&i| bodies[i].body.kind == BodyKind::Fixed);
    fixed.for_each(|i| layers[i] = "fixed");
    layers
}
