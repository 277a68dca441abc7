//! What must be true of an answer, by exact tests of all pairs of triangles at many times.

use punctual::Pose;
use punctual::geom::triangles_intersect;
use punctual::impact::{Impact, TimeOfImpact};
use punctual::{Answer, Motion, Query, StopReason, Tree};

pub use crate::common::ask::{ENOUGH, answer, resume, run, run_with_memory};

use crate::random::Random;

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
    pub query: Query<'t, Impact>,
    /// The earliest time known at which they meet.
    meets_at: f64,
}

impl<'t> Truth<'t> {
    pub fn new(a: &'t Tree, b: &'t Tree, motion: Motion) -> Self {
        Self::of(Query::impact(a, b, motion), a, b)
    }

    /// Looks at evenly spaced times.
    pub fn of(query: Query<'t, Impact>, a: &'t Tree, b: &'t Tree) -> Self {
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
    pub fn assert_sound(&self, said: &Answer<TimeOfImpact>) {
        assert!((0.0..=1.0).contains(&said.value.lower), "{said:?}");
        assert!(said.value.lower <= self.meets_at, "{said:?}");
        assert_eq!(said.value.upper.is_some(), said.value.triangles.is_some());
        if let (Some(time), Some([a, b])) = (said.value.upper, said.value.triangles) {
            assert!(said.value.lower <= time && time <= 1.0, "{said:?}");
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
    pub fn assert_complete(&mut self, said: &Answer<TimeOfImpact>, random: &mut Random) -> bool {
        assert_eq!(said.stop, StopReason::Finished, "{said:?}");
        // Close to the end of what is free, and anywhere in it.
        let close = (1..6).map(|i| said.value.lower * (1.0 - (-6.0 * f64::from(i)).exp()));
        let times: Vec<f64> = close
            .chain((0..6).map(|_| random.unit() * said.value.lower))
            .collect();
        for time in times {
            if time < said.value.lower && meet(self.a, self.b, &self.query.pose(time)) {
                self.meets_at = self.meets_at.min(time);
            }
        }
        self.assert_sound(said);
        assert_eq!(said.value.upper == Some(0.0), self.starts_in_contact());
        assert!(
            said.value.upper.is_some() || self.meets_at == f64::INFINITY || said.value.lower < 1.0,
            "{said:?}"
        );
        said.value.upper.is_some()
    }
}
