//! A scene: frame by frame, which bodies meet others, and of which that is not known.

use std::collections::HashMap;
use std::sync::Arc;

use punctual::{Aabb, Body, BodyKind, PairReport, Pose, Verdict};
use serde_json::json;

use crate::View;
use crate::stage::{Fact, Stage, placed};

/// Frames that are shown, at equal distances.
const MOST_FRAMES: usize = 120;

/// A frame: its number, a pose for each body, the pairs whose boxes overlap, and the lines of the table.
pub struct Frame<'r> {
    /// Counted from 0.
    pub number: usize,
    /// Of each body, in the scene.
    pub poses: &'r [Pose],
    /// Reported of this frame; bodies are named by their place in the list.
    pub pairs: &'r [PairReport],
    /// Lines of the table.
    pub facts: Vec<Fact>,
}

/// Of so many frames, each that is shown is so many after the one before.
pub fn stride(frames: usize) -> usize {
    frames.div_ceil(MOST_FRAMES).max(1)
}

/// A page for bodies and what was reported of them.
pub fn scene(title: String, bodies: &[Body], frames: &[Frame]) -> View {
    let lying = |frame: &Frame, i: usize| placed(bodies[i].tree.mesh(), &frame.poses[i]);
    let all = frames.iter().flat_map(|frame| (0..bodies.len()).map(move |i| lying(frame, i)));
    let mut stage = Stage::new(all.fold(Aabb::EMPTY, |bounds, body| bounds.union(&body)));
    let mut known = HashMap::new();
    let meshes: Vec<usize> = bodies
        .iter()
        .map(|body| *known.entry(Arc::as_ptr(&body.tree)).or_insert_with(|| stage.mesh(body.tree.mesh())))
        .collect();
    let steps = frames.iter().map(|frame| {
        let layers = layers(bodies, frame.pairs);
        let draw = |i: usize| {
            let pose = stage.pose(meshes[i], &frame.poses[i]);
            stage.whole(layers[i], [meshes[i], pose])
        };
        let surfaces: Vec<_> = (0..bodies.len()).map(draw).collect();
        let met = (0..bodies.len()).filter(|&i| layers[i] == "b");
        let around = met.fold(Aabb::EMPTY, |around, i| around.union(&lying(frame, i)));
        let (name, focus) = (frame.number.to_string(), stage.focus(&around));
        json!({ "name": name, "facts": frame.facts, "surfaces": surfaces, "focus": focus })
    });
    let steps = steps.collect();
    let key = [
        ("a", "meets no other: proven"),
        ("b", "meets another: proven"),
        ("doubt", "not known"),
        ("fixed", "fixed bodies"),
    ];
    let key = key.map(|(layer, text)| (layer, text.to_owned())).to_vec();
    View { title, key, stage, steps, start: 0, slider: "Frame", times: None }
}

/// The layer of each body: what is known of all its pairs together.
fn layers(bodies: &[Body], pairs: &[PairReport]) -> Vec<&'static str> {
    let mut layers: Vec<_> =
        bodies.iter().map(|body| if body.kind == BodyKind::Fixed { "fixed" } else { "a" }).collect();
    for pair in pairs {
        for body in [pair.a, pair.b].map(|id| id.index()) {
            layers[body] = match (pair.verdict, layers[body]) {
                (Verdict::Separated, layer) | (_, layer @ ("fixed" | "b")) => layer,
                (Verdict::Intersecting { .. }, _) => "b",
                (Verdict::Undecided, _) => "doubt",
            };
        }
    }
    layers
}
