//! A page that shows the last frame of a scene.

use punctual_scene::Scene;
use punctual_view::{Frame, Known, Shown, View, count, fact};

/// Bodies at their poses, what the last report says of them, and where they touch.
pub fn page(scene: &Scene) -> View {
    let report = scene.report();
    let shown = scene.bodies().map(|(id, body)| Shown {
        index: id.index(),
        name: match scene.name(id) {
            "" => format!("body {}", id.index()),
            name => name.to_owned(),
        },
        body,
    });
    let bodies: Vec<_> = shown.collect();
    let poses: Vec<_> = bodies.iter().map(|shown| shown.body.pose).collect();
    let found = report.pairs.iter().filter_map(|pair| {
        let poses = [
            &scene.body(pair.a).ok()?.pose,
            &scene.body(pair.b).ok()?.pose,
        ];
        Some((scene.contacts(pair.a, pair.b).ok()?, poses))
    });
    let contacts: Vec<_> = found
        .flat_map(|(found, poses)| found.points.iter().map(move |point| point.at(poses)))
        .map(|point| [point.points[1], point.normal])
        .collect();
    let known = Known::of(report);
    let facts = vec![
        fact("Bodies", count(bodies.len() as u64)),
        fact("Work", count(report.work)),
    ];
    let number = usize::try_from(report.frame).unwrap_or(usize::MAX);
    let frame = Frame {
        number,
        poses: &poses,
        known: &known,
        contacts: &contacts,
        facts,
    };
    punctual_view::scene("Which bodies meet".to_owned(), &bodies, &[frame])
}
