//! A page that shows the last frame of a scene.

use punctual::{Report, Scene};
use punctual_view::{Frame, Known, View, count, fact};

/// Bodies at their poses, what the last report says of them, and where they touch.
pub fn page(scene: &Scene) -> View {
    let report = scene.report();
    let bodies: Vec<_> = scene.bodies().map(|(id, body)| (id.index(), body)).collect();
    let poses: Vec<_> = bodies.iter().map(|(_, body)| body.pose).collect();
    let found = report.pairs.iter().filter_map(|pair| scene.contact_points(pair.a, pair.b).ok());
    // Older ones are of bodies where they were.
    let found = found.filter(|found| found.age == 0);
    let contacts: Vec<_> =
        found.flat_map(|found| found.points.iter().map(|point| [point.points[1], point.normal])).collect();
    let (known, facts) = (Known::of(report), facts(report, bodies.len()));
    let number = usize::try_from(report.frame).unwrap_or(usize::MAX);
    let frame = Frame { number, poses: &poses, known: &known, contacts: &contacts, facts };
    punctual_view::scene("Which bodies meet".to_owned(), &bodies, &[frame])
}

fn facts(report: &Report, bodies: usize) -> Vec<(&'static str, String)> {
    let lines = [
        ("Bodies", bodies as u64),
        ("Pairs of boxes that overlap", report.pairs.len() as u64),
        ("Of these, meeting", report.meeting_pairs().count() as u64),
        ("Not known", report.undecided() as u64),
        ("Bodies not placed or not paired", (report.unplaced + report.unpaired) as u64),
        ("Work", report.work),
    ];
    lines.map(|(name, number)| fact(name, count(number))).to_vec()
}
