//! Contact manifolds: the points, bounds and ids of Rust, and what is refused.

use std::ptr::null_mut;

use super::call::*;
use super::queries::same_stats;
use punctual::contacts::ManifoldBounds;
use punctual::{Answer, Query, Workspace};
use punctual_capi::*;

const NO_MANIFOLD_POINT: punctual_manifold_point = punctual_manifold_point {
    id: 0,
    manifold: 0,
    points: [NO_POINT; 2],
    normal: NO_POINT,
    distance: 0.0,
    is_overlap: 0,
    is_whole: 0,
    area: 0.0,
    centroid: NO_POINT,
};

#[test]
fn manifolds_are_those_of_rust() {
    let (ours, theirs) = knots();
    let (mut workspace, mut other) = workspaces();
    let (mut memory, mut expected) = memories();
    let (mut stops, mut points) = (0, 0);
    for skin in [0.0, 0.02] {
        let mut query = punctual_manifold_query_new(Some(&ours), Some(&ours), raw(&tilted()));
        assert_eq!(query.skin, 0.0);
        query.skin = skin;
        let native = Query::manifolds(&theirs, &theirs, tilted()).skin(skin);
        let compare = |said: &punctual_manifolds,
                       told: &Answer<ManifoldBounds>,
                       held: &mut punctual_workspace,
                       other: &mut Workspace| {
            assert_eq!((said.low, said.meets), (told.value.low, told.value.meets));
            assert_eq!(said.found, told.stats.found);
            same_stats(&said.stats, &told.stats);
            let mut room = vec![NO_MANIFOLD_POINT; 400];
            let (place, size) = (room.as_mut_ptr(), size_of::<punctual_manifold_point>());
            // SAFETY: there is room for 400.
            let count = made(|out| unsafe {
                punctual_workspace_manifold_points(Some(held), place, size, 400, out)
            });
            let all = other.manifolds().iter();
            let all: Vec<_> = all
                .flat_map(|one| one.points().iter().map(move |point| (one, point)))
                .collect();
            assert_eq!(count, all.len());
            for (ours, (manifold, point)) in room.iter().zip(&all) {
                let place = |p: punctual_point| [p.x, p.y, p.z];
                assert_eq!((ours.id, ours.manifold), (point.id, manifold.id));
                assert_eq!(ours.points.map(place), point.points.map(|p| p.to_array()));
                assert_eq!(
                    (place(ours.normal), ours.distance, ours.area),
                    (point.normal.to_array(), point.distance, manifold.area)
                );
                assert_eq!(place(ours.centroid), manifold.centroid.to_array());
                assert_eq!(
                    (ours.is_overlap == 1, ours.is_whole == 1),
                    (manifold.is_overlap, manifold.is_whole)
                );
            }
            points += count;
        };
        stops += to_the_end!(
            punctual_manifold_query_run, punctual_manifold_query_resume, query, native, 40_000,
            workspace, other, memory, expected; compare
        );
    }
    assert!(stops > 3 && points > 4, "{stops} stops, {points} points");
}

#[test]
fn bad_questions_for_manifolds_are_refused() {
    let tree = tree_of(&knot());
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let budget = punctual_budget_work(1);
    for (skin, text) in [(-1.0, "-1"), (f64::NAN, "NaN")] {
        let mut query = punctual_manifold_query_new(Some(&tree), Some(&tree), raw(&tilted()));
        query.skin = skin;
        // SAFETY: no clock of the caller's.
        refuses! {
            punctual_manifold_query_run(asked(Some(&query)), Some(&mut workspace), None, budget, None, null_mut())
                => BadArgument &format!("punctual_manifold_query_run: query->skin is {text}, which is negative or no number");
        }
    }
    // SAFETY: null is told.
    refuses! {
        punctual_manifold_query_run(asked(None), Some(&mut workspace), None, budget, None, null_mut())
            => null "query";
    }
}
