//! Points and solids: a tree and points in; which are inside, and how far from the surface, out.

use crate::arrays::{array, find_room, room};
use crate::budget::{punctual_budget, punctual_clock};
use crate::estimate::{punctual_remaining, tell};
use crate::handle::get;
use crate::outcome::{punctual_stats, punctual_stop_reason};
use crate::pose::punctual_point;
use crate::query::answer;
use crate::status::Fault;
use crate::tree::punctual_tree;
use crate::verbs::{calls, types};
use crate::workspace::punctual_workspace;
use punctual::Query;
use punctual::points::{AtPoints, PointBounds};

types! {
    /// Whether a point is inside a solid, or on its surface.
    enum punctual_inside from bool {
        /// Not known: the budget ended first, or the winding number of an open solid is 1/2 to its
        /// error.
        Undecided = 0,
        /// It is.
        Yes = 1,
        /// It is not.
        No = 2,
    }
}

types! {
    /// What is proven about a point and a solid.
    plain punctual_point_bounds {
        /// How often the surface winds around the point: a whole number, exactly, if the solid is
        /// closed. On the surface that of the points just beside it. NaN if it is not known.
        winding: f64,
        /// Bound of its error: 0 for closed solids, infinite if it is not known.
        error: f64,
        /// The signed distance, negative inside, is within `low` and `high`, if it was asked for;
        /// else both are 0, and they are infinite for an empty mesh.
        low: f64,
        /// See `low`.
        high: f64,
        /// The nearest point of the surface that was found, if distances were asked for.
        nearest: punctual_point,
        /// The triangle that has it, id of the input mesh; PUNCTUAL_NO_TRIANGLE without one.
        triangle: u32,
        /// Inside: the winding number is at least 1, of an open solid above 1/2, or the point is on
        /// the surface.
        inside: punctual_inside,
        /// 1 if the point is on the surface, exactly; else 0.
        is_on_surface: u32,
        /// Not used; 0.
        reserved: u32,
    }

    /// The answer for many points; what is known of each is in the caller's array.
    told punctual_points_outcome(done) from (outcome: punctual::Answer<usize>) {
        /// The first so many points are done and their bounds are written.
        done: usize = outcome.value,
        /// Why it returned.
        stop: punctual_stop_reason = outcome.stop.into(),
        /// What it has done for all points.
        stats: punctual_stats = outcome.stats.into(),
    }
}

calls! {
    /// Asks about `count` points, in the frame of the tree's mesh, one after the other within one
    /// budget, and writes what is known of those that are done to `bounds`, which has room for all.
    /// `measures`: 0 for winding numbers only, else distances too. The first call for so many
    /// points in a workspace makes room for them, about 100 bytes each. It does not lock or panic.
    /// `clock` may be null: the clock of the system.
    ///
    /// Fails with NULL, BAD_ARGUMENT if the tree was not built as a solid or for a point that is
    /// not finite, which it names, OUT_OF_MEMORY or POISONED before it has begun.
    unsafe fn punctual_points_run(
        tree: Option<&punctual_tree>, points: *const punctual_point, count: usize, measures: u32,
        workspace: Option<&mut punctual_workspace>, budget: punctual_budget,
        clock: Option<&punctual_clock>, bounds: *mut punctual_point_bounds,
        outcome: *mut punctual_points_outcome
    ) {
        let asked = Asked { tree, points, count, measures: measures != 0, resumes: false };
        // SAFETY: the contract of the header for arrays and clocks.
        unsafe { asked.spend(workspace, budget, clock, bounds, outcome) }
    }

    /// Goes on with the stopped run that the workspace holds, with a fresh budget; the points must
    /// be what they were. What is known of all points that are done is written, those of earlier
    /// calls again.
    ///
    /// Fails as `punctual_points_run`, and with NOT_RESUMABLE if the last run in this workspace was
    /// not of these points or is complete.
    unsafe fn punctual_points_resume(
        tree: Option<&punctual_tree>, points: *const punctual_point, count: usize, measures: u32,
        workspace: Option<&mut punctual_workspace>, budget: punctual_budget,
        clock: Option<&punctual_clock>, bounds: *mut punctual_point_bounds,
        outcome: *mut punctual_points_outcome
    ) {
        let asked = Asked { tree, points, count, measures: measures != 0, resumes: true };
        // SAFETY: the contract of the header for arrays and clocks.
        unsafe { asked.spend(workspace, budget, clock, bounds, outcome) }
    }

    /// What the last run about these points in the workspace has still to do. Takes time linear in
    /// the points, which it checks.
    ///
    /// Fails as `punctual_points_run`, and with NOT_RESUMABLE if the last run in this workspace was
    /// not of these points.
    unsafe fn punctual_points_remaining(
        tree: Option<&punctual_tree>, points: *const punctual_point, count: usize, measures: u32,
        workspace: Option<&punctual_workspace>, remaining: *mut punctual_remaining
    ) {
        // SAFETY: the contract of the header for structs and arrays; a point is three numbers.
        unsafe {
            let points = array(points.cast::<[f64; 3]>(), count, "points")?;
            let query = query(tree, points, measures != 0)?;
            tell(&query, workspace, None, remaining)
        }
    }
}

fn query<'t>(
    tree: Option<&'t punctual_tree>,
    points: &'t [[f64; 3]],
    measures: bool,
) -> Result<Query<'t, AtPoints<'t>>, Fault> {
    let tree = get(tree, "tree")?;
    Ok(if measures {
        Query::signed_distances(tree, points)?
    } else {
        Query::windings(tree, points)?
    })
}

struct Asked<'t> {
    tree: Option<&'t punctual_tree>,
    points: *const punctual_point,
    count: usize,
    measures: bool,
    resumes: bool,
}

impl Asked<'_> {
    /// # Safety
    /// The contract of the header for the points, the bounds and the clock.
    unsafe fn spend(
        self,
        workspace: Option<&mut punctual_workspace>,
        budget: punctual_budget,
        clock: Option<&punctual_clock>,
        bounds: *mut punctual_point_bounds,
        outcome: *mut punctual_points_outcome,
    ) -> Result<(), Fault> {
        // SAFETY: the caller's promise; a point is three numbers.
        let (points, written) = unsafe {
            (
                array(self.points.cast::<[f64; 3]>(), self.count, "points")?,
                room(bounds, self.count, "bounds")?,
            )
        };
        let query = query(self.tree, points, self.measures)?;
        // SAFETY: the caller's promise.
        unsafe {
            answer(
                workspace,
                None,
                budget,
                clock,
                outcome,
                |workspace, _, budget| {
                    if self.count > workspace.points().len() {
                        find_room([(self.count, size_of::<PointBounds>())])?;
                    }
                    let answer = if self.resumes {
                        query.resume(workspace, budget)?
                    } else {
                        query.run(workspace, budget)
                    };
                    for (place, bounds) in written.iter_mut().zip(workspace.points()) {
                        place.write(self.told(bounds));
                    }
                    Ok(answer)
                },
            )
        }
    }

    fn told(&self, bounds: &PointBounds) -> punctual_point_bounds {
        let nothing = if self.measures { f64::INFINITY } else { 0.0 };
        let distance = bounds.distance;
        punctual_point_bounds {
            winding: bounds.winding.unwrap_or(f64::NAN),
            error: bounds.error,
            low: distance.map_or(nothing, |distance| distance.low),
            high: distance.map_or(nothing, |distance| distance.high),
            nearest: distance
                .map(|distance| distance.point)
                .unwrap_or_default()
                .into(),
            triangle: distance.map_or(crate::PUNCTUAL_NO_TRIANGLE, |distance| distance.triangle),
            inside: bounds.inside.into(),
            is_on_surface: bounds.is_on_surface.into(),
            reserved: 0,
        }
    }
}
