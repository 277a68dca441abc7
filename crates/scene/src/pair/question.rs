//! The question of a pair. A pair has one question at a time; it is begun, resumed and answered
//! here.

use super::bounds::{Bounds, Proof, Times};
use super::spent::Spent;
use crate::ask::distance_requests::DistanceRequest;
use crate::body::{Bodies, Placed, margins, radii, thickness};
use crate::cost::{LEAST_DISTANCE_WORK, LEAST_WORK};
use crate::id::PairKey;
use punctual::Answer as Answered;
use punctual::contacts::{ManifoldBounds, Manifolds};
use punctual::distance::{self, Distance};
use punctual::engine::{self, Ask, Deadline};
use punctual::impact::{Impact, TimeOfImpact};
use punctual::intersection::{Intersection, Operand};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::prediction::MAX_STEP_WORK;
use punctual::{Mode, PairMemory, Query, StopReason, Verdict, Workspace};
use punctual_geom::Pose;

/// Relative tolerance of distances that are looked ahead: `low` is at least four fifths of `high`.
const LOOK_AHEAD_TOLERANCE: f64 = 0.2;

/// The question of a pair. An equal question resumes a stopped run.
#[allow(
    clippy::large_enum_variant,
    reason = "it is made anew for each turn, on the stack"
)]
pub(crate) enum Question<'t> {
    /// Do the surfaces meet, and where?
    Meet(Query<'t, Intersection>),
    /// The distance of the thickened surfaces, or only whether they meet.
    Distance(Query<'t, Distance>),
    /// The time of impact.
    Motion(Query<'t, Impact>),
    /// The contacts, and the radii of the trees.
    Contacts(Query<'t, Manifolds>, f64),
}

/// The results so far after a call.
pub(crate) struct Answer {
    pub stop: StopReason,
    pub verdict: Verdict,
    /// Intersecting pairs of triangles.
    pub found: u64,
    pub proof: Option<Proof>,
    /// Lower bound of the distance of contacts not found; and the nearest one found: its triangles
    /// and their distance, without radii.
    pub missing: f64,
    pub nearest: Option<([u32; 2], f64)>,
}

impl Answer {
    /// The answer from bounds: the bodies meet now if the upper bound is 0, and do not if the lower
    /// bound is positive. `distance` is that of the witness, without margins.
    fn bounded(stop: StopReason, proof: Proof, distance: f64) -> Self {
        let (low, high, triangles) = proof.parts();
        let verdict = match triangles {
            Some(witness) if high == 0.0 => Verdict::of_witness(witness, distance),
            _ if low > 0.0 => Verdict::Separated,
            _ => Verdict::Undecided,
        };
        Self {
            stop,
            verdict,
            found: u64::from(high == 0.0),
            proof: Some(proof),
            missing: 0.0,
            nearest: None,
        }
    }

    fn of_distance(
        query: &Query<'_, Distance>,
        Answered { value, stop, .. }: &Answered<distance::Bounds>,
        workspace: &Workspace,
    ) -> Self {
        let is_over = stop.is_final();
        let bounds = Bounds {
            low: value.low,
            high: value.high,
            triangles: value.nearest.map(|nearest| nearest.triangles),
            below: if is_over {
                query.ceiling_in(workspace)
            } else {
                0.0
            },
            ..Bounds::NOTHING
        };
        let proof = Proof::Distance(bounds);
        let mut answer = Self::bounded(*stop, proof, query.witness_distance(workspace));
        answer.contain(value.within);
        if is_over && value.high > 0.0 && query.decides_contact() {
            answer.verdict = Verdict::Separated;
        }
        answer
    }

    fn of_impact(
        query: &Query<'_, Impact>,
        Answered { value, stop, .. }: &Answered<TimeOfImpact>,
        workspace: &Workspace,
    ) -> Self {
        let proof = Proof::Impact(Times::new(value, stop.is_final()));
        let mut answer = Self::bounded(*stop, proof, query.witness_distance(workspace));
        answer.contain(value.within);
        answer
    }

    /// `radii` are those of the trees.
    fn of_contacts(
        query: &Query<'_, Manifolds>,
        &Answered { value, stop, .. }: &Answered<ManifoldBounds>,
        radii: f64,
    ) -> Self {
        let of_cores = |(triangles, apart): ([u32; 2], f64)| (triangles, apart + radii);
        let within = value.nearest.filter(|&(_, apart)| query.is_within(apart));
        let verdict = match within.map(of_cores) {
            Some((triangles, distance)) => Verdict::of_witness(triangles, distance),
            None if stop.is_final() && value.nearest.is_none() => Verdict::Separated,
            None => Verdict::Undecided,
        };
        // Whether one is inside the other is found out last.
        let is_open = !stop.is_final() && query.may_contain();
        let mut answer = Self {
            stop,
            verdict,
            found: u64::from(within.is_some()),
            proof: None,
            missing: if is_open { 0.0 } else { value.low },
            nearest: value.nearest.map(of_cores),
        };
        answer.contain(value.within);
        answer
    }

    /// Sets the verdict if one body is inside the other. No triangles prove that.
    fn contain(&mut self, within: Option<Operand>) {
        if let Some(inner) = within {
            (self.verdict, self.found) = (Verdict::Contained { inner }, 0);
        }
    }
}

impl<'t> Question<'t> {
    /// The question of a pair of bodies, with the second at a pose in the frame of the first.
    /// `mode` is that of the scene.
    #[inline(always)]
    pub fn new(
        bodies: &Bodies,
        key: PairKey,
        [a, b]: [&'t Placed; 2],
        b_in_a: Pose,
        mode: Mode,
    ) -> Self {
        let special = if bodies.is_special(key) {
            Self::special(bodies, key, [a, b], b_in_a)
        } else {
            None
        };
        special.unwrap_or_else(|| {
            Self::Meet(Query::intersection(&a.body.tree, &b.body.tree, b_in_a).mode(mode))
        })
    }

    /// The question other than an intersection; `None` if there is none.
    #[cold]
    fn special(
        bodies: &Bodies,
        key: PairKey,
        [a, b]: [&'t Placed; 2],
        b_in_a: Pose,
    ) -> Option<Self> {
        let trees = [&*a.body.tree, &*b.body.tree];
        let margins = [a.body.margin, b.body.margin];
        let distance = Query::distance(trees[0], trees[1], b_in_a).margins(margins);
        match bodies.distance_requests.wanted(key) {
            Some(DistanceRequest {
                tolerance, ceiling, ..
            }) => Some(Self::Distance(
                distance.absolute_tolerance(tolerance).below(ceiling),
            )),
            None if bodies.is_moving(key) => Some(Self::motion([a, b])),
            None if thickness([a, b]) > 0.0 => Some(Self::Distance(distance.closer_than(0.0))),
            None => None,
        }
    }

    /// The time of impact of the bodies of a pair.
    #[cold]
    pub fn motion(pair: [&'t Placed; 2]) -> Self {
        let trees = pair.map(|placed| &*placed.body.tree);
        let query = Query::impact_of_both(trees, pair.map(Placed::motion));
        Self::Motion(query.margins(pair.map(|placed| placed.body.margin)))
    }

    /// Are the bodies of a pair closer than `limit`?
    #[cold]
    pub fn apart([a, b]: [&'t Placed; 2], b_in_a: Pose, limit: f64) -> Self {
        let query = Query::distance(&a.body.tree, &b.body.tree, b_in_a);
        Self::Distance(
            query
                .margins([a.body.margin, b.body.margin])
                .closer_than(limit),
        )
    }

    /// The distance of the bodies of a pair, up to a limit, as a fraction of it.
    #[cold]
    pub fn look_ahead([a, b]: [&'t Placed; 2], b_in_a: Pose, limit: f64) -> Self {
        let query = Query::distance(&a.body.tree, &b.body.tree, b_in_a);
        let query = query.margins([a.body.margin, b.body.margin]).below(limit);
        Self::Distance(query.relative_tolerance(LOOK_AHEAD_TOLERANCE))
    }

    /// The contacts of the bodies of a pair.
    #[cold]
    pub fn contacts(pair @ [a, b]: [&'t Placed; 2], b_in_a: Pose) -> Self {
        let query = Query::manifolds(&a.body.tree, &b.body.tree, b_in_a);
        Self::Contacts(query.skin(margins(pair)), radii(pair))
    }

    #[inline]
    pub fn least_work(&self) -> u64 {
        match self {
            Self::Meet(_) => LEAST_WORK,
            Self::Distance(_) | Self::Motion(_) | Self::Contacts(..) => LEAST_DISTANCE_WORK,
        }
    }

    /// [`Question::advance`] for callers that do not need a copy of their own.
    #[inline(never)]
    pub fn go_on(
        &self,
        workspace: &mut Workspace,
        memory: &mut PairMemory,
        deadline: &mut Deadline,
        to_the_end: bool,
    ) -> (Answer, Spent) {
        self.advance(workspace, Some(memory), deadline, to_the_end)
    }

    /// Continues the stopped run of this question that the workspace holds, or begins one, until it
    /// is over or the deadline stops it. Also returns the work of earlier calls of the run.
    /// `to_the_end`: a run that begins is expected to finish.
    ///
    /// Whether two bodies meet is searched from the roots: the latest witness was tested before, or
    /// rarely holds, and what lies near it was measured to delay the search.
    #[inline(always)]
    pub fn advance(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
        to_the_end: bool,
    ) -> (Answer, Spent) {
        match self {
            Self::Meet(query) => {
                let before = if query.is_stopped_in(workspace) {
                    Spent::of(workspace)
                } else {
                    query.begin_task(to_the_end, workspace);
                    Spent::default()
                };
                let (stop, verdict) = if query.may_contain() {
                    let answer = query.spend(workspace, memory, deadline);
                    (answer.stop, answer.value)
                } else {
                    let stop = query.search(workspace, memory, deadline);
                    (stop, workspace.verdict(stop))
                };
                let answer = Answer {
                    stop,
                    verdict,
                    found: workspace.found(),
                    proof: None,
                    missing: 0.0,
                    nearest: None,
                };
                (answer, before)
            }
            Self::Distance(query) => {
                let (found, before) = bound(query, workspace, memory, deadline);
                (Answer::of_distance(query, &found, workspace), before)
            }
            Self::Motion(query) => {
                let (found, before) = bound(query, workspace, memory, deadline);
                (Answer::of_impact(query, &found, workspace), before)
            }
            Self::Contacts(query, radii) => {
                let (found, before) = bound(query, workspace, None, deadline);
                (Answer::of_contacts(query, &found, *radii), before)
            }
        }
    }
}

/// Continues or begins a query whose answers are bounds, and whose steps are longer. Also returns
/// the work of earlier calls of the run.
fn bound<Q: engine::Question>(
    query: &Query<'_, Q>,
    workspace: &mut Workspace,
    memory: Option<&mut PairMemory>,
    deadline: &mut Deadline,
) -> (Answered<Q::Value>, Spent)
where
    for<'q> Query<'q, Q>: Ask<Q>,
{
    deadline.leave(MAX_DISTANCE_STEP_WORK);
    let (answer, before) = query.go_on(workspace, memory, deadline);
    deadline.leave(MAX_STEP_WORK);
    let (work, bv_tests) = (before.work, before.bv_tests);
    (answer, Spent { work, bv_tests })
}
