//! What must be true of an answer, by exact tests of all pairs of triangles at many times.

use punctual::{
    Budget, ManualClock, Motion, MotionQuery, PairMemory, Passage, StopReason, Tree, Workspace,
};
use punctual::{Pose, triangles_intersect};

use crate::random::Random;

pub const ENOUGH: Budget = Budget::work(u64::MAX / 2);

/// By no clock, so that it runs without that of the system too.
pub fn run(query: &MotionQuery, workspace: &mut Workspace, budget: Budget) -> Passage {
    query.run_with(workspace, None, budget, &ManualClock::new())
}

pub fn run_with_memory(
    query: &MotionQuery,
    workspace: &mut Workspace,
    memory: &mut PairMemory,
    budget: Budget,
) -> Passage {
    query.run_with(workspace, Some(memory), budget, &ManualClock::new())
}

pub fn resume(query: &MotionQuery, workspace: &mut Workspace, budget: Budget) -> Passage {
    query
        .resume_with(workspace, None, budget, &ManualClock::new())
        .unwrap()
}

/// Whether any two triangles meet.
pub fn meet(a: &Tree, b: &Tree, pose: &Pose) -> bool {
    let triangles = |tree: &Tree| {
        (0..tree.mesh().len())
            .map(|i| tree.mesh().triangle(i))
            .collect::<Vec<_>>()
    };
    let of_b: Vec<_> = triangles(b)
        .into_iter()
        .map(|t| t.map(|v| pose.transform_point(v)))
        .collect();
    triangles(a)
        .iter()
        .any(|a| of_b.iter().any(|b| triangles_intersect(a, b)))
}

/// A motion of two small meshes, and some of the times at which they meet.
pub struct Truth<'t> {
    pub a: &'t Tree,
    pub b: &'t Tree,
    pub query: MotionQuery<'t>,
    /// The earliest time known at which they meet.
    meets_at: f64,
}

impl<'t> Truth<'t> {
    pub fn new(a: &'t Tree, b: &'t Tree, motion: Motion) -> Self {
        Self::of(MotionQuery::new(a, b, motion), a, b)
    }

    /// Looks at evenly spaced times.
    pub fn of(query: MotionQuery<'t>, a: &'t Tree, b: &'t Tree) -> Self {
        let times = (0..=24).map(|i| f64::from(i) / 24.0);
        let meets_at = times
            .filter(|&time| meet(a, b, &query.pose(time)))
            .fold(f64::INFINITY, f64::min);
        Self {
            a,
            b,
            query,
            meets_at,
        }
    }

    pub fn starts_in_contact(&self) -> bool {
        self.meets_at == 0.0
    }

    /// What holds of every answer.
    #[track_caller]
    pub fn assert_sound(&self, said: &Passage) {
        assert!((0.0..=1.0).contains(&said.free_until), "{said:?}");
        assert!(
            said.free_until <= self.meets_at,
            "they meet at {}: {said:?}",
            self.meets_at
        );
        assert_eq!(said.touching_at.is_some(), said.triangles.is_some());
        if let (Some(time), Some([a, b])) = (said.touching_at, said.triangles) {
            assert!(said.free_until <= time && time <= 1.0, "{said:?}");
            let pose = self.query.pose(time);
            let of_b = self
                .b
                .mesh()
                .triangle(b as usize)
                .map(|v| pose.transform_point(v));
            assert!(
                triangles_intersect(&self.a.mesh().triangle(a as usize), &of_b),
                "{said:?}"
            );
        }
    }

    /// What holds of the answer of a finished query besides: whether it found a contact, after times drawn at random.
    #[track_caller]
    pub fn assert_complete(&mut self, said: &Passage, random: &mut Random) -> bool {
        assert_eq!(said.stop, StopReason::Finished, "{said:?}");
        // Close to the end of what is free, and anywhere in it.
        let close = (1..6).map(|i| said.free_until * (1.0 - (-6.0 * f64::from(i)).exp()));
        let times: Vec<f64> = close
            .chain((0..6).map(|_| random.unit() * said.free_until))
            .collect();
        for time in times {
            if time < said.free_until && meet(self.a, self.b, &self.query.pose(time)) {
                self.meets_at = self.meets_at.min(time);
            }
        }
        self.assert_sound(said);
        assert_eq!(
            said.touching_at == Some(0.0),
            self.starts_in_contact(),
            "{said:?}"
        );
        assert!(
            said.touching_at.is_some() || self.meets_at == f64::INFINITY || said.free_until < 1.0,
            "{said:?}"
        );
        said.touching_at.is_some()
    }
}
