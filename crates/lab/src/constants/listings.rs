//! Queries for contacts and manifolds, stopped on the way: what the model sees, and what came of it.

use punctual::clock::ManualClock;
use punctual::engine::{Ask, Question};
use punctual::internals::Listing;
use punctual::{Budget, Query, StopReason, Workspace};

use super::cases::Case;
use super::sample::{STOPS, THINNED};

/// Margins and skins that are asked about, relative to A's size.
const MARGINS: [f64; 2] = [0.0, 0.01];

/// Room for contacts; queries that find more are left out.
const ROOM: usize = 1 << 17;

/// One in so many poses is asked about.
const THINNED_POSES: usize = 3;

/// A query at one moment, and its end.
pub struct Moment {
    /// The case it is of, by number.
    pub case: usize,
    /// The share of its own work after which it was stopped; 0 before it began.
    pub stop: f64,
    pub listing: Listing,
    /// Work of the whole query.
    pub total: f64,
    pub is_manifold: bool,
}

/// Some poses of a case, with all margins, at all moments.
pub fn moments(number: usize, case: &Case) -> Vec<Moment> {
    let mut workspace = Workspace::new();
    workspace.reserve_contacts(ROOM);
    let mut moments = Vec::new();
    let thinned = if case.is_motion {
        THINNED
    } else {
        THINNED_POSES
    };
    for &pose in case.poses.iter().step_by(thinned) {
        for margin in MARGINS.map(|share| share * case.a.unit_length()) {
            let contacts = Query::contacts(&case.a, &case.b, pose).margin(margin);
            let manifolds = Query::manifolds(&case.a, &case.b, pose).skin(margin);
            let mut add = |stop, listing, total, is_manifold| {
                moments.push(Moment {
                    case: number,
                    stop,
                    listing,
                    total,
                    is_manifold,
                });
            };
            sample(&contacts, &mut workspace, |stop, listing, total| {
                add(stop, listing, total, false);
            });
            sample(&manifolds, &mut workspace, |stop, listing, total| {
                add(stop, listing, total, true);
            });
        }
    }
    moments
}

fn sample<'t, Q: Question>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    mut add: impl FnMut(f64, Listing, f64),
) where
    Query<'t, Q>: Ask<Q>,
{
    let clock = ManualClock::new();
    let whole = query.run(workspace, Budget::unlimited().clock(&clock));
    if !whole.stop.is_final() {
        return;
    }
    let total = whole.stats.work as f64;
    for stop in [0.0].into_iter().chain(STOPS) {
        let budget = Budget::work((stop * total) as u64);
        let answer = query.run(workspace, budget.clock(&clock));
        if answer.stop == StopReason::WorkLimit {
            add(stop, query.listing(workspace), total);
        }
    }
}
