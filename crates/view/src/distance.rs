//! A query of a distance: the closest points found, and where closer ones may be.

use punctual::distance::{Bounds, Distance};
use punctual::{Aabb, Answer, Budget, Pose, Query, ResumeError, Stats, StopReason, Workspace};
use serde_json::{Value, json};

use crate::ladder::{Stepwise, climb};
use crate::stage::{OPEN_BOXES, Stage, fact, length, placed, tests};
use crate::{Bodies, View};

/// A page for a query of these bodies at this pose, which was answered so.
pub fn distance(
    bodies: &Bodies,
    query: Query<Distance>,
    pose: &Pose,
    answer: &Answer<Bounds>,
) -> Result<View, ResumeError> {
    let [a, b] = bodies.trees;
    let mut stage = Stage::new(placed(a, &Pose::IDENTITY).union(&placed(b, pose)));
    let placed = stage.bodies(bodies, pose);
    let [near, met] = [0; 2].map(|_| stage.arrays.add());
    let mut steps = Steps {
        bodies,
        query,
        workspace: Workspace::new(),
        placed,
        near,
        met,
    };
    let steps = climb(&mut steps, &mut stage, answer)?;
    let layers = [
        ("met", "their triangles"),
        ("near", "closest points found"),
        ("box", OPEN_BOXES),
    ];
    Ok(View::of_query(
        "How far two meshes are apart",
        bodies,
        &layers,
        stage,
        steps,
    ))
}

struct Steps<'t> {
    bodies: &'t Bodies<'t>,
    query: Query<'t, Distance>,
    workspace: Workspace,
    placed: [[usize; 2]; 2],
    /// Arrays of segments and of triangles.
    near: usize,
    met: usize,
}

impl Stepwise for Steps<'_> {
    type Answer = Answer<Bounds>;

    fn begin(&mut self, until: u64) -> Result<Answer<Bounds>, ResumeError> {
        Ok(self.query.run(&mut self.workspace, Budget::work(until)))
    }

    fn resume(
        &mut self,
        stopped: &Answer<Bounds>,
        until: u64,
    ) -> Result<Answer<Bounds>, ResumeError> {
        self.query.resume(
            &mut self.workspace,
            Budget::work(until - stopped.stats.work),
        )
    }

    fn reached(answer: &Answer<Bounds>) -> (StopReason, Stats) {
        (answer.stop, answer.stats)
    }

    fn look(&mut self, found: &Answer<Bounds>, stage: &mut Stage) -> Result<Value, ResumeError> {
        let certificate = self.query.certificate(&self.workspace)?;
        let (boxes, open, remark) = stage.open_boxes(&certificate);
        let likely = self.query.estimate(&self.workspace, None)?.distance;
        let [least, most] = [likely.p10, likely.p90];
        let likely = if most.is_finite() {
            format!("{} to {}", length(least), length(most))
        } else {
            "not known yet".into()
        };
        let mut facts = vec![
            fact("Proven: at least", length(found.value.low)),
            fact("Proven: at most", length(found.value.high)),
            fact("Likely, 80 of 100", likely),
        ];
        if let Some(closer) = found.value.closer {
            facts.push(fact(
                "As close as asked for",
                if closer { "yes" } else { "no" },
            ));
        }
        facts.extend(open);
        facts.extend(tests(&found.stats));
        let mut surfaces = stage.both(&self.placed);
        let mut step = json!({ "facts": facts, "remarks": Vec::from_iter(remark), "boxes": boxes });
        if let Some(nearest) = &found.value.nearest {
            for side in [0, 1] {
                let [mesh, pose] = self.placed[side];
                let triangle = [nearest.triangles[side]];
                let range = stage.triangles(self.met, self.bodies.trees[side], triangle);
                surfaces.push(json!(["met", mesh, pose, range]));
            }
            let [p, q] = nearest.points;
            step["lines"] = json!([["near", stage.segments(self.near, [[p, q], [p, p], [q, q]])]]);
            step["label"] = json!([stage.point(0.5 * p + 0.5 * q), length(found.value.high)]);
            step["focus"] = stage.focus(&Aabb::from_points([p, q]));
        }
        step["surfaces"] = surfaces.into();
        Ok(step)
    }
}
