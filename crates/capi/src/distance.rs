//! Distance queries: two trees, a pose and tolerances in; proven bounds and the closest points out.

use crate::handle::get;
use crate::memory::{known, punctual_memory};
use crate::outcome::{punctual_quantiles, punctual_stats, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::trees;
use crate::sized::{place, read};
use crate::status::Fault;
use crate::tree::punctual_tree;
use crate::verbs::{calls, inits, question, types};
use crate::workspace::{punctual_triangle_pair, punctual_workspace};
use punctual::distance::{Bounds, Distance};
use punctual::glam::DVec3;
use punctual::{Answer, Query};

types! {
    /// Whether two surfaces are no farther apart than the `closer_than` of a query.
    enum punctual_closer from bool {
        /// Not known: the budget ended first, it was not asked, or the distance is the limit up to
        /// the rounding of numbers as large as the meshes.
        Undecided = 0,
        /// Proven: they are no farther apart.
        Yes = 1,
        /// Proven: they are farther apart.
        No = 2,
    }

    /// The question how far apart two surfaces are: 0 if they meet. Plain data, made by
    /// `punctual_distance_query_new`, one for each pose; it borrows the trees. To resume a query or
    /// to ask for its certificate, all of it must be what it was. Lengths are in the unit of the
    /// meshes.
    asked punctual_distance_query<'t>(b_in_a) {
        /// Whether the query is done as soon as `high` is no more than `absolute_tolerance`, even
        /// if it is open then whether the surfaces meet: 0 (the default) or not 0.
        leave_contact_open: u32 = 0,
        /// Tree A.
        a: Option<&'t punctual_tree> = None,
        /// Tree B; it may be the same.
        b: Option<&'t punctual_tree> = None,
        /// Brings coordinates of B into those of A.
        b_in_a: punctual_pose = punctual_pose::IDENTITY,
        /// Done as soon as `high - low` is no more than this length; 0: as close as double can
        /// tell. -1 by default, as any negative number: a millionth of half the longest extent of
        /// the larger mesh, roughly. Whether the surfaces meet is decided with any tolerance,
        /// unless `leave_contact_open`.
        absolute_tolerance: f64 = -1.0,
        /// Done also as soon as `high <= (1 + relative_tolerance) low`. 0 by default; with a
        /// negative `absolute_tolerance` that is 1e-5 for meshes that are more than 64 times their
        /// size apart.
        relative_tolerance: f64 = 0.0,
        /// By how much each surface is thickened, A's first: a point becomes a ball, a segment a
        /// capsule. The distance is that of the thickened surfaces. 0 by default.
        margins: [f64; 2] = [0.0; 2],
        /// Ask only whether the surfaces are no farther apart than this length: done as soon as
        /// that is known, in a fraction of the time. Infinity by default: the distance itself is
        /// asked for.
        closer_than: f64 = f64::INFINITY,
    }

    /// The answer of a distance query, wherever it stopped: `low <= distance <= high`, in the
    /// length unit of the meshes.
    told punctual_distance(stop) from (found: Answer<Bounds>) {
        /// Proven: the surfaces are nowhere closer. Infinite if one of the meshes is empty.
        low: f64 = found.value.low,
        /// Proven: the distance of the two points, but for rounding. 0 only if the surfaces meet;
        /// infinite if nothing was found yet.
        high: f64 = found.value.high,
        /// The answer to `closer_than`.
        closer: punctual_closer = found.value.closer.into(),
        /// Why the query returned.
        stop: punctual_stop_reason = found.stop.into(),
        /// Whether triangles were found at all; if not, they and the points are zeros.
        has_nearest: bool = found.value.nearest.is_some(),
        /// The closest triangles found.
        nearest: punctual_triangle_pair =
            found.value.nearest.map_or([0; 2], |near| near.triangles).into(),
        /// Their closest points, A's first, both in A's frame; moved towards each other by the
        /// margins. If the triangles meet, both are one point, whatever the margins: the middle of
        /// the segment in which the triangles do.
        points: [punctual_point; 2] =
            found.value.nearest.map_or([DVec3::ZERO; 2], |near| near.points).map(Into::into),
        /// What it has done.
        stats: punctual_stats = found.stats.into(),
    }
}

inits! {
    /// The question how far apart `a` and `b` are, with the default options. Checked when it is
    /// run.
    punctual_distance_query_init(
        query: punctual_distance_query<'t>,
        a: Option<&'t punctual_tree>, b: Option<&'t punctual_tree>, b_in_a: punctual_pose
    ) { a, b, b_in_a }
}

question! {
    punctual_distance_query(punctual_workspace, memory) -> punctual_distance {
        /// Runs a distance query within a budget. It does not allocate, lock or panic. `memory` may
        /// be null: what it knows of the frame before makes the answer faster.
        ///
        /// Under a time budget it returns at most one poll interval of work late, under a work
        /// budget at most PUNCTUAL_MAX_DISTANCE_STEP_WORK units later.
        run punctual_distance_query_run;

        /// Its bounds are no worse than before; however it is cut into pieces by work budgets, the
        /// outcome at the end is that of one uninterrupted run.
        resume punctual_distance_query_resume;

        /// Where the last run of this query in the workspace may have missed what is closer than
        /// its `high` by more than the tolerance.
        certificate punctual_distance_query_certificate;

        /// Two points that are closer than `high` by more than the tolerance have their middle in
        /// one of them. They reach as far as `high` beyond the surfaces, and are infinite where
        /// nothing was found yet.
        open_boxes punctual_distance_query_open_boxes;

        /// A rough guess: nine of ten queries are within a factor of 6.5 of the median.
        predict punctual_distance_query_predict;

        remaining punctual_distance_query_remaining;
    }
}

types! {
    /// What can be said of a stopped distance query. Not proven: only the bounds and the
    /// certificate are.
    told punctual_distance_estimate(remaining) {
        /// Units of work that the query has still to do.
        remaining: punctual_quantiles,
        /// The distance: within what is proven, and infinite above where nothing was found yet.
        distance: punctual_quantiles,
    }
}

calls! {
    /// What the last run of this query in the workspace leaves open, given what is remembered of
    /// the pair; `memory` may be null. Takes constant time and allocates nothing.
    ///
    /// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
    unsafe fn punctual_distance_query_estimate(
        query: *const punctual_distance_query<'_>, workspace: Option<&punctual_workspace>,
        memory: Option<&punctual_memory>, estimate: *mut punctual_distance_estimate
    ) {
        // SAFETY: the contract of the header for structs.
        let query = unsafe { read(query, "query") }?.check()?;
        // SAFETY: the same.
        let estimate = unsafe { place(estimate, "estimate") }?;
        let said = query.estimate(get(workspace, "workspace")?, known(memory)?)?;
        let (remaining, distance) = (said.remaining.into(), said.distance.into());
        estimate.write(punctual_distance_estimate {
            size: punctual_distance_estimate::SIZE,
            remaining,
            distance,
        });
        Ok(())
    }
}

impl<'t> punctual_distance_query<'t> {
    fn check(self) -> Result<Query<'t, Distance>, Fault> {
        let [a, b] = trees(self.a, self.b)?;
        finite_or_default(self.absolute_tolerance, "query->absolute_tolerance")?;
        finite(self.relative_tolerance, "query->relative_tolerance")?;
        not_negative(self.closer_than, "query->closer_than")?;
        check_margins(self.margins)?;
        let query = Query::distance(a, b, self.b_in_a.check()?);
        let query = match self.absolute_tolerance {
            ..0.0 => query,
            length => query.absolute_tolerance(length),
        };
        let query = match self.relative_tolerance {
            0.0 => query,
            share => query.relative_tolerance(share),
        };
        let query = query.margins(self.margins).closer_than(self.closer_than);
        Ok(query.leave_contact_open(self.leave_contact_open != 0))
    }
}

pub(crate) fn check_margins(margins: [f64; 2]) -> Result<(), Fault> {
    for (margin, what) in margins
        .into_iter()
        .zip(["query->margins[0]", "query->margins[1]"])
    {
        finite(margin, what)?;
    }
    Ok(())
}

/// What is negative stands for the default.
pub(crate) fn finite_or_default(value: f64, what: &'static str) -> Result<(), Fault> {
    if value < f64::INFINITY {
        Ok(())
    } else {
        Err(Fault::Number(what, value))
    }
}

pub(crate) fn finite(value: f64, what: &'static str) -> Result<(), Fault> {
    not_negative(value, what)?;
    finite_or_default(value, what)
}

pub(crate) fn not_negative(value: f64, what: &'static str) -> Result<(), Fault> {
    if value >= 0.0 {
        Ok(())
    } else {
        Err(Fault::Negative(what, value))
    }
}
