//! A scene: frame by frame, which bodies meet others, and of which that is not known.

use std::collections::HashMap;
use std::sync::Arc;

use punctual::glam::DVec3;
use punctual::{Aabb, Body, BodyKind, Pose, Report, Verdict};
use serde_json::json;

use crate::View;
use crate::stage::{Fact, NORMAL, Stage, placed};

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
    /// Lines of the table.
    pub facts: Vec<Fact>,
}

/// What a frame tells of bodies, by their indices.
#[derive(Clone, Debug, Default)]
pub struct Known {
    pairs: Vec<([usize; 2], Verdict)>,
    /// Whether bodies that are in no pair together are known not to meet.
    is_whole: bool,
}

impl Known {
    /// What this report says.
    pub fn of(report: &Report) -> Self {
        let pairs = report.pairs.iter().map(|pair| ([pair.a.index(), pair.b.index()], pair.verdict));
        Self { pairs: pairs.collect(), is_whole: report.is_whole() }
    }
}

/// Of so many frames, each that is shown is so many after the one before.
pub fn stride(frames: usize) -> usize {
    frames.div_ceil(MOST_FRAMES).max(1)
}

/// A page for bodies, each with its index, and what was reported of them.
pub fn scene(title: String, bodies: &[(usize, &Body)], frames: &[Frame]) -> View {
    let lying = |frame: &Frame, i: usize| placed(bodies[i].1.tree.mesh(), &frame.poses[i]);
    let all = frames.iter().flat_map(|frame| (0..bodies.len()).map(move |i| lying(frame, i)));
    let mut stage = Stage::new(all.fold(Aabb::EMPTY, |bounds, body| bounds.union(&body)));
    let mut known = HashMap::new();
    let meshes: Vec<usize> = bodies
        .iter()
        .map(|(_, body)| *known.entry(Arc::as_ptr(&body.tree)).or_insert_with(|| stage.mesh(body.tree.mesh())))
        .collect();
    let drawn = stage.arrays.add();
    let steps = frames.iter().map(|frame| {
        let layers = layers(bodies, frame.known);
        let draw = |i: usize| {
            let pose = stage.pose(meshes[i], &frame.poses[i]);
            stage.whole(layers[i], [meshes[i], pose])
        };
        let surfaces: Vec<_> = (0..bodies.len()).map(draw).collect();
        let met = (0..bodies.len()).filter(|&i| ["b", "within"].contains(&layers[i]));
        let around = met.fold(Aabb::EMPTY, |around, i| around.union(&lying(frame, i)));
        let long = NORMAL * stage.radius();
        let normals = frame.contacts.iter().map(|&[point, normal]| [point, point + long * normal]);
        let lines = [("normal", stage.segments(drawn, normals))];
        let (name, focus) = (frame.number.to_string(), stage.focus(&around));
        json!({ "name": name, "facts": frame.facts, "surfaces": surfaces, "lines": lines, "focus": focus })
    });
    let steps = steps.collect();
    let key = [
        ("a", "meets no other: proven"),
        ("b", "meets another: proven"),
        ("within", "within the margins of another: proven"),
        ("doubt", "not known"),
        ("fixed", "fixed bodies"),
        ("normal", "normals where bodies touch"),
    ];
    let has_contacts = frames.iter().any(|frame| !frame.contacts.is_empty());
    let has_margins = bodies.iter().any(|(_, body)| body.margin > 0.0);
    let is_drawn = |layer| match layer {
        "within" => has_margins,
        "normal" => has_contacts,
        _ => true,
    };
    let key = key.iter().filter(|(layer, _)| is_drawn(*layer)).map(|&(layer, text)| (layer, text.to_owned())).collect();
    View { title, key, stage, steps, start: 0, slider: "Frame", times: None }
}

/// The layer of each body: what is known of all its pairs together.
fn layers(bodies: &[(usize, &Body)], known: &Known) -> Vec<&'static str> {
    let alone = if known.is_whole { "a" } else { "doubt" };
    let mut layers: Vec<_> =
        bodies.iter().map(|(_, body)| if body.kind == BodyKind::Fixed { "fixed" } else { alone }).collect();
    let places: HashMap<usize, usize> = bodies.iter().enumerate().map(|(place, (index, _))| (*index, place)).collect();
    for (pair, verdict) in &known.pairs {
        for body in pair.iter().filter_map(|index| places.get(index).copied()) {
            layers[body] = match (verdict, layers[body]) {
                (Verdict::Separated, layer) | (_, layer @ ("fixed" | "b")) => layer,
                (Verdict::Intersecting { .. }, _) => "b",
                (Verdict::Within { .. }, _) | (_, "within") => "within",
                (Verdict::Undecided, _) => "doubt",
            };
        }
    }
    layers
}
