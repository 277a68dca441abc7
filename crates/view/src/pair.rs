//! A query of intersections: the triangles that meet, and where others may.

use std::collections::HashSet;

use punctual::intersection::Intersection;
use punctual::{
    Aabb, Answer, Budget, Mode, Pose, Query, ResumeError, Stats, StopReason, Verdict, Workspace,
};
use serde_json::{Value, json};

use crate::ladder::{Stepwise, climb};
use crate::stage::{OPEN_BOXES, Stage, count, fact, length, percent, placed, tests};
use crate::{Bodies, View};

/// Node pairs that wait in the queue, as in `Workspace::new`, and found pairs that a workspace holds before they are taken out.
const CAPACITY: [usize; 2] = [4096, 1 << 16];

/// Times what was found, beyond which an upper bound of it says nothing.
const FAR: u64 = 100;

/// A page for a query of these bodies at this pose, which was answered so.
pub fn pair(
    bodies: &Bodies,
    query: Query<Intersection>,
    pose: &Pose,
    mode: Mode,
    answer: &Answer<Verdict>,
) -> Result<View, ResumeError> {
    let [a, b] = bodies.trees;
    let mut stage = Stage::new(placed(a, &Pose::IDENTITY).union(&placed(b, pose)));
    let placed = stage.bodies(bodies, pose);
    let arrays = [0; 2].map(|_| stage.arrays.add());
    let [queue, found] = CAPACITY;
    let workspace = Workspace::with_capacity(queue, found);
    let (found, met, around) = (Vec::new(), Default::default(), Aabb::EMPTY);
    let mut steps = Steps {
        bodies,
        query,
        pose,
        mode,
        workspace,
        found,
        met,
        around,
        placed,
        arrays,
    };
    let steps = climb(&mut steps, &mut stage, answer)?;
    let layers = [("met", "triangles that meet"), ("box", OPEN_BOXES)];
    Ok(View::of_query(
        "Where two meshes meet",
        bodies,
        &layers,
        stage,
        steps,
    ))
}

struct Steps<'t> {
    bodies: &'t Bodies<'t>,
    query: Query<'t, Intersection>,
    pose: &'t Pose,
    mode: Mode,
    workspace: Workspace,
    /// Pairs that have not been looked at.
    found: Vec<[u32; 2]>,
    /// The triangles of A and of B that are known to meet others, and the arrays that have them, in the order of discovery.
    met: [HashSet<u32>; 2],
    arrays: [usize; 2],
    around: Aabb,
    placed: [[usize; 2]; 2],
}

impl Steps<'_> {
    /// Takes out what was found, and goes on where there was no more room for it.
    fn collect(
        &mut self,
        mut outcome: Answer<Verdict>,
        until: u64,
    ) -> Result<Answer<Verdict>, ResumeError> {
        loop {
            self.found.extend(self.workspace.drain_pairs());
            if outcome.stop != StopReason::PairsFull {
                return Ok(outcome);
            }
            outcome = self.query.resume(
                &mut self.workspace,
                Budget::work(until - outcome.stats.work),
            )?;
        }
    }

    /// Draws the triangles found since the last look, and returns the ranges of all so far.
    fn draw_met(&mut self, stage: &mut Stage) -> Vec<Value> {
        let found = std::mem::take(&mut self.found);
        let sides = [Pose::IDENTITY, *self.pose];
        let mut surfaces = Vec::new();
        for (side, pose) in sides.iter().enumerate() {
            let tree = self.bodies.trees[side];
            let new: Vec<u32> = found
                .iter()
                .map(|pair| pair[side])
                .filter(|&id| self.met[side].insert(id))
                .collect();
            let corners = new
                .iter()
                .flat_map(|&id| tree.mesh().triangle(id as usize))
                .map(|p| pose.transform_point(p));
            self.around = self.around.union(&Aabb::from_points(corners));
            stage.triangles(self.arrays[side], tree, new);
            let [mesh, pose] = self.placed[side];
            surfaces.push(json!([
                "met",
                mesh,
                pose,
                stage.arrays.so_far(self.arrays[side])
            ]));
        }
        surfaces
    }
}

impl Stepwise for Steps<'_> {
    type Answer = Answer<Verdict>;

    fn begin(&mut self, until: u64) -> Result<Answer<Verdict>, ResumeError> {
        self.found.clear();
        let outcome = self.query.run(&mut self.workspace, Budget::work(until));
        self.collect(outcome, until)
    }

    fn resume(
        &mut self,
        stopped: &Answer<Verdict>,
        until: u64,
    ) -> Result<Answer<Verdict>, ResumeError> {
        let outcome = self.query.resume(
            &mut self.workspace,
            Budget::work(until - stopped.stats.work),
        )?;
        self.collect(outcome, until)
    }

    fn reached(answer: &Answer<Verdict>) -> (StopReason, Stats) {
        (answer.stop, answer.stats)
    }

    fn look(&mut self, outcome: &Answer<Verdict>, stage: &mut Stage) -> Result<Value, ResumeError> {
        let certificate = self.query.certificate(&self.workspace)?;
        let most = certificate.upper_bound();
        let estimate = self.query.estimate(&self.workspace, None)?;
        let (boxes, open, remark) = stage.open_boxes(&certificate);
        let (mut facts, mut remarks) = (
            vec![fact("Verdict", outcome.value.name())],
            Vec::from_iter(remark),
        );
        if outcome.value == Verdict::Undecided {
            facts.push(fact("Probability to meet", percent(estimate.probability)));
        }
        if self.mode == Mode::All {
            let bound = "Pairs, at most";
            if most > FAR * outcome.stats.found.max(1) {
                remarks.push(fact(bound, "says nothing yet"));
            }
            // Of none, any share may be found.
            let share = if outcome.stats.found == 0 && most > 0 {
                "none found yet".into()
            } else {
                percent(estimate.recall)
            };
            facts.extend([
                fact("Pairs found", count(outcome.stats.found)),
                fact(bound, count(most)),
                fact("Share found, expected", share),
            ]);
        }
        facts.extend(open);
        facts.push(fact(
            "Longest of their edges",
            length(certificate.largest_extent()),
        ));
        facts.extend(tests(&outcome.stats));
        let mut surfaces = stage.both(&self.placed);
        surfaces.extend(self.draw_met(stage));
        Ok(json!({
            "facts": facts, "remarks": remarks, "surfaces": surfaces, "boxes": boxes, "focus": stage.focus(&self.around),
        }))
    }
}
