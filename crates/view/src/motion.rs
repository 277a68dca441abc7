//! A query of a motion: until when it is proven to be free, and where the meshes meet.

use punctual::impact::{Impact, TimeOfImpact};
use punctual::{Aabb, Answer, Budget, Pose, Query, ResumeError, Stats, StopReason, Workspace};
use serde_json::{Value, json};

use crate::ladder::{Stepwise, climb};
use crate::stage::{Stage, fact, placed, tests};
use crate::{Bodies, View};

/// Equal parts of the motion between the poses that are shown.
const PARTS: usize = 128;

/// A page for a query of these bodies, of which B moves, which was answered so.
pub fn motion(
    bodies: &Bodies,
    query: Query<Impact>,
    answer: &Answer<TimeOfImpact>,
) -> Result<View, ResumeError> {
    let [a, b] = bodies.trees;
    let poses: Vec<Pose> = (0..=PARTS)
        .map(|i| query.pose(i as f64 / PARTS as f64))
        .collect();
    let bounds = poses
        .iter()
        .fold(placed(a, &Pose::IDENTITY), |bounds, pose| {
            bounds.union(&placed(b, pose))
        });
    let mut stage = Stage::new(bounds);
    let placed = stage.bodies(bodies, &poses[0]);
    let times = [placed[1][1]]
        .into_iter()
        .chain(poses[1..].iter().map(|pose| stage.pose(placed[1][0], pose)))
        .collect();
    let met = stage.arrays.add();
    let mut steps = Steps {
        bodies,
        query,
        workspace: Workspace::new(),
        placed,
        met,
    };
    let steps = climb(&mut steps, &mut stage, answer)?;
    let layers = [
        ("start", "B at the start"),
        ("touch", "B where it touches"),
        ("met", "triangles that meet there"),
        ("box", "boxes where they may still meet first"),
    ];
    let view = View::of_query(
        "When two meshes meet on the way",
        bodies,
        &layers,
        stage,
        steps,
    );
    Ok(View {
        times: Some(times),
        ..view
    })
}

struct Steps<'t> {
    bodies: &'t Bodies<'t>,
    query: Query<'t, Impact>,
    workspace: Workspace,
    placed: [[usize; 2]; 2],
    /// The array of triangles that meet.
    met: usize,
}

impl Stepwise for Steps<'_> {
    type Answer = Answer<TimeOfImpact>;

    fn begin(&mut self, until: u64) -> Result<Answer<TimeOfImpact>, ResumeError> {
        Ok(self.query.run(&mut self.workspace, Budget::work(until)))
    }

    fn resume(
        &mut self,
        stopped: &Answer<TimeOfImpact>,
        until: u64,
    ) -> Result<Answer<TimeOfImpact>, ResumeError> {
        self.query.resume(
            &mut self.workspace,
            Budget::work(until - stopped.stats.work),
        )
    }

    fn reached(answer: &Answer<TimeOfImpact>) -> (StopReason, Stats) {
        (answer.stop, answer.stats)
    }

    fn look(
        &mut self,
        passage: &Answer<TimeOfImpact>,
        stage: &mut Stage,
    ) -> Result<Value, ResumeError> {
        let [a, b] = self.placed;
        let mut marks = vec![json!(["start", 0.0, b[1]])];
        let mut surfaces = vec![stage.whole("a", a), stage.whole("start", b)];
        let free = stage.pose(b[0], &self.query.pose(passage.value.lower));
        marks.push(json!(["free until", passage.value.lower, free]));
        // That B is drawn at the time of the other slider is up to the page.
        surfaces.push(stage.whole("b", [b[0], free]));
        let mut focus = Value::Null;
        if let (Some(time), Some(triangles)) = (passage.value.upper, passage.value.triangles) {
            let pose = self.query.pose(time);
            let there = stage.pose(b[0], &pose);
            marks.push(json!(["touching at", time, there]));
            surfaces.push(stage.whole("touch", [b[0], there]));
            let mut around = Aabb::EMPTY;
            for (side, [mesh, placed], pose) in [(0, a, Pose::IDENTITY), (1, [b[0], there], pose)] {
                let tree = self.bodies.trees[side];
                let range = stage.triangles(self.met, tree, [triangles[side]]);
                surfaces.push(json!(["met", mesh, placed, range]));
                let corners = tree.mesh().triangle(triangles[side] as usize);
                around = around.union(&Aabb::from_points(corners.map(|p| pose.transform_point(p))));
            }
            focus = stage.focus(&around);
        }
        let touching = match passage.value.upper {
            Some(time) => format!("{time:.6}"),
            None if passage.value.lower == 1.0 => "never: proven".to_owned(),
            None => "not known".to_owned(),
        };
        let certificate = self.query.certificate(&self.workspace)?;
        let (boxes, open, remark) = stage.open_boxes(&certificate);
        let mut facts = vec![
            fact("Proven free until", format!("{:.6}", passage.value.lower)),
            fact("Proven to touch at", touching),
        ];
        facts.extend(open);
        facts.extend(tests(&passage.stats));
        Ok(
            json!({ "facts": facts, "remarks": Vec::from_iter(remark), "boxes": boxes, "surfaces": surfaces, "marks": marks, "focus": focus }),
        )
    }
}
