//! A query touches no allocator: in any mode and order, with and without memory, finished, stopped, resumed, with
//! full buffers, through the exact stage, and while its certificate is read; of distances, contacts and pushes as of
//! intersections. Nor does a refit.

#[path = "common/allocations.rs"]
mod allocations;
mod common;

use std::hint::black_box;
use std::time::Duration;

use allocations::allocator_calls;
use common::meshes::{ball, cube, placed};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::{MODES, ORDERS};
use punctual::clock::ManualClock;
use punctual::contacts::Contacts;
use punctual::engine::{Ask, Remembers};
use punctual::glam::{DVec3, Vec3};
use punctual::rays::RayMode;
use punctual::tree::{PointWindow, Solid};
use punctual::{
    Budget, BuildOptions, Mesh, Motion, PairMemory, Pose, Query, Ray, StopReason, Tree, Workspace,
    shapes,
};
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};

#[test]
fn the_counter_counts() {
    assert_eq!(allocator_calls(|| drop(black_box(Box::new(1u8)))), 2);
    assert_eq!(allocator_calls(|| ()), 0);
}

/// Everything a caller can do with a query inside a frame; `look` with what is known at each stop.
fn use_query<'t, Q: Remembers>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    mut memory: Option<&mut PairMemory>,
    look: impl Fn(&mut Workspace, Option<&PairMemory>),
) where
    Query<'t, Q>: Ask<Q>,
{
    let clock = ManualClock::ticking(Duration::from_micros(1));
    let budgets = [
        Budget::work(60),
        Budget::work(5_000),
        Budget::time(Duration::from_micros(3)),
        Budget::work(50_000),
    ];
    for budget in [Budget::work(0), Budget::unlimited()]
        .into_iter()
        .chain(budgets)
    {
        let known = query.with_memory(memory.as_deref_mut());
        let mut said = known.run(workspace, budget.clock(&clock));
        for more in budgets.iter().cycle() {
            look(workspace, memory.as_deref());
            if said.stop.is_final() {
                break;
            }
            let _ = black_box(query.remaining(workspace, memory.as_deref()));
            if said.stop == StopReason::PairsFull {
                drop(black_box(workspace.drain_pairs()));
            }
            let known = query.with_memory(memory.as_deref_mut());
            said = known.resume(workspace, more.clock(&clock)).unwrap();
        }
        let _ = black_box(said);
    }
}

/// Calls without a memory, with one that is new, and with one that was used.
fn calls_of<'t, Q: Remembers>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    look: impl Fn(&mut Workspace, Option<&PairMemory>),
) -> u64
where
    Query<'t, Q>: Ask<Q>,
{
    let mut memory = PairMemory::new();
    allocator_calls(|| {
        use_query(query, workspace, None, &look);
        use_query(query, workspace, Some(&mut memory), &look);
        use_query(query, workspace, Some(&mut memory), &look);
    })
}

#[test]
fn queries_for_manifolds_do_not_allocate_once_their_buffers_have_grown() {
    let (a, b) = (ball(3), Tree::new(shapes::torus(1.0, 0.3, 40)));
    let mut random = Random::new(3);
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    for _ in 0..5 {
        let pose = placed(random.rotation(), 0.5 * random.vector());
        for skin in [0.0, 0.02] {
            let query = Query::manifolds(&a, &b, pose).skin(skin);
            let [_, calls] = [(); 2].map(|()| {
                let (held, memory) = (&mut workspace, Some(&mut memory));
                allocator_calls(|| use_query(&query, held, memory, |_, _| ()))
            });
            assert_eq!(calls, 0, "skin {skin}");
            assert!(!workspace.manifolds().is_empty());
        }
    }
}

/// The same of a contact query, in a workspace that has room.
fn use_contacts(query: &Query<Contacts>, workspace: &mut Workspace) {
    let clock = ManualClock::ticking(Duration::from_micros(1));
    for budget in [
        Budget::work(0),
        Budget::work(2_000),
        Budget::time(Duration::from_micros(3)),
        Budget::unlimited(),
    ] {
        let mut said = query.run(workspace, budget.clock(&clock));
        while said.stop != StopReason::Finished {
            black_box(query.certificate(workspace).unwrap().boxes().count());
            black_box(workspace.contacts().count());
            if said.stop == StopReason::PairsFull {
                drop(black_box(workspace.drain_contacts()));
            }
            let more = Budget::work(50_000).clock(&clock);
            said = query.resume(workspace, more).unwrap();
        }
        black_box(workspace.contacts().count());
    }
}

#[track_caller]
fn assert_no_calls(a: &Tree, b: &Tree, pose: Pose) {
    for (capacity, pairs) in [(4096, 4096), (0, 1), (3, 5)] {
        let mut workspace = Workspace::with_capacity(capacity, pairs);
        for (mode, order) in MODES
            .iter()
            .flat_map(|mode| ORDERS.map(|order| (*mode, order)))
        {
            let query = Query::intersection(a, b, pose).mode(mode).order(order);
            for query in [query, query.plain(), query.pair_limit(3)] {
                let calls = calls_of(&query, &mut workspace, |workspace, _| {
                    let certificate = query.certificate(workspace).unwrap();
                    black_box((certificate.upper_bound(), certificate.largest_extent()));
                    black_box(certificate.boxes().count());
                    black_box(workspace.pairs());
                });
                assert_eq!(calls, 0, "{mode:?} {order:?}");
            }
        }
        let query = Query::distance(a, b, pose);
        for query in [
            query,
            query.absolute_tolerance(0.0),
            query.margins([0.1, 0.2]),
            query.closer_than(0.5),
        ] {
            let calls = calls_of(&query, &mut workspace, |workspace, memory| {
                black_box(query.predict(memory));
                let _ = black_box(query.estimate(workspace, memory));
                black_box(query.certificate(workspace).unwrap().boxes().count());
            });
            assert_eq!(calls, 0, "{query:?}");
        }
        let far = Motion::turning(pose, [3.0, 0.1, 0.2], [0.1, 0.2, 0.3], [0.0; 3]).unwrap();
        let back = Motion::straight(far.pose(1.0), [-3.0, 0.0, 0.0]).unwrap();
        for motion in [far, back] {
            let query = Query::impact(a, b, motion);
            let calls = calls_of(&query, &mut workspace, |_, _| ());
            assert_eq!(calls, 0, "{motion:?}");
        }
        workspace.reserve_contacts(64);
        let query = Query::contacts(a, b, pose);
        let near = query.margin(0.01);
        for query in [query, near, near.contact_limit(3)] {
            let calls = allocator_calls(|| use_contacts(&query, &mut workspace));
            assert_eq!(calls, 0, "{query:?}");
        }
    }
}

#[test]
fn shapes_in_contact_and_apart() {
    let knot = Tree::new(shapes::torus_knot(2, 3, 0.2, 24));
    let gear = Tree::new(shapes::gear(11, 3));
    let mut random = Random::new(3);
    for reach in [0.3, 1.0, 30.0] {
        let pose = pose_about(DVec3::ZERO, reach, Drift::Scale, &mut random);
        assert_no_calls(&knot, &gear, pose);
    }
}

/// Coplanar, degenerate and f64 triangles reach the exact stage, which must not allocate either.
#[test]
fn pairs_that_need_the_exact_stage() {
    let mut random = Random::new(8);
    for family in [
        Family::Grid,
        Family::Degenerate,
        Family::FarOffset,
        Family::Denormal,
        Family::Enormous,
    ] {
        let a = Tree::new(soup(family, 25, &mut random));
        let b = Tree::new(soup(family, 25, &mut random));
        assert_no_calls(&a, &b, Pose::IDENTITY);
    }
    let cube = cube(2);
    assert_no_calls(&cube, &cube, Pose::IDENTITY);
    let query = Query::all_pairs(&cube, &cube, Pose::IDENTITY);
    let outcome = common::check::run(&query, &mut Workspace::new(), Budget::unlimited());
    // The exact stage was not reached.
    assert!(outcome.stats.exact_tests > 0);
}

#[test]
fn penetrations() {
    let options = BuildOptions::default().solid(Solid::Keep);
    let [knot, gear] = [shapes::torus_knot(2, 3, 0.2, 32), shapes::gear(12, 3)]
        .map(|mesh| Tree::with_options(mesh, &options));
    let (mut workspace, clock) = (
        PenetrationWorkspace::new(),
        ManualClock::ticking(Duration::from_micros(1)),
    );
    for ([a, b], solid) in [
        ([&knot, &gear], false),
        ([&knot, &gear], true),
        ([&knot, &knot], true),
    ] {
        let query = PenetrationQuery::new(a, b, Pose::IDENTITY).solid(solid);
        let query = query.push_only(a.identity() == b.identity());
        for budget in [
            Budget::work(20_000),
            Budget::time(Duration::from_micros(90)),
            Budget::work(3_000_000),
        ] {
            let calls = allocator_calls(|| {
                let _ = black_box(query.run(&mut workspace, budget.clock(&clock)));
                let _ = black_box(query.resume(&mut workspace, budget.clock(&clock)));
            });
            assert_eq!(calls, 0, "{query:?}");
        }
    }
}

/// Room for hits is made once, or beforehand.
#[test]
fn rays() {
    let (tree, clock) = (
        Tree::new(soup(Family::Degenerate, 300, &mut Random::new(5))),
        ManualClock::new(),
    );
    let rays = [[1.0, 0.0, 0.0], [0.0, 0.3, -1.0]]
        .map(|direction| Ray::new([-0.2, 0.1, 0.0], direction).unwrap());
    let mut workspace = Workspace::with_capacity(1, 1);
    workspace.reserve_ray_hits(1);
    let _ = Query::rays(&tree, &rays).run(&mut workspace, Budget::work(0).clock(&clock));
    let calls = allocator_calls(|| {
        for mode in [RayMode::Nearest, RayMode::Any, RayMode::All] {
            let query = Query::ray(&tree, rays[0]).mode(mode);
            let mut cast = query.run(&mut workspace, Budget::work(0).clock(&clock));
            while !matches!(cast.stop, StopReason::Finished | StopReason::FirstHit) {
                drop(workspace.drain_ray_hits());
                cast = query
                    .resume(&mut workspace, Budget::work(300).clock(&clock))
                    .unwrap();
            }
        }
        let _ = Query::rays(&tree, &rays).run(&mut workspace, Budget::unlimited().clock(&clock));
    });
    assert_eq!(calls, 0);
}

/// Of a closed and of an open solid, and one solid in another, after the first of each.
#[test]
fn points_and_solids() {
    let options = BuildOptions::default().solid(Solid::Keep);
    let ball = shapes::icosphere(3);
    let vertices = || (0..ball.vertex_count()).map(|i| ball.vertex(i));
    let open = Mesh::from_f64(vertices(), ball.triangles()[9..].iter().copied()).unwrap();
    let small = Mesh::from_f64(
        vertices().map(|x| x * 0.1),
        ball.triangles().iter().copied(),
    );
    let small = Tree::with_options(small.unwrap(), &options);
    let points: Vec<[f64; 3]> = (0..50).map(|i| [0.05 * f64::from(i), 0.1, 0.2]).collect();
    for mesh in [ball.clone(), open] {
        let tree = Tree::with_options(mesh, &options);
        let mut workspace = Workspace::new();
        let batch = Query::signed_distances(&tree, &points).unwrap();
        let _ = batch.run(&mut workspace, Budget::work(0));
        let query = Query::intersection(&tree, &small, Pose::IDENTITY);
        let _ = query.run(&mut workspace, Budget::unlimited());
        let calls = allocator_calls(|| {
            let _ = batch.run(&mut workspace, Budget::work(5_000));
            let _ = batch.resume(&mut workspace, Budget::unlimited());
            for &point in &points {
                let query = Query::winding(&tree, point).unwrap();
                let _ = query.run(&mut workspace, Budget::unlimited());
            }
            let query = Query::intersection(&tree, &small, Pose::IDENTITY);
            let _ = query.run(&mut workspace, Budget::unlimited());
            let query = Query::distance(&tree, &small, Pose::IDENTITY);
            let _ = query.run(&mut workspace, Budget::unlimited());
        });
        assert_eq!(calls, 0);
    }
}

#[test]
fn empty_meshes() {
    let empty = Tree::new(soup(Family::Uniform, 0, &mut Random::new(0)));
    let sphere = ball(1);
    assert_no_calls(&empty, &sphere, Pose::IDENTITY);
}

/// A deforming mesh is refitted in the same frame as it is queried.
#[test]
fn refit() {
    for family in [Family::Uniform, Family::Double] {
        let mut tree = Tree::new(soup(family, 500, &mut Random::new(6)));
        let vertices: Vec<DVec3> = (0..tree.mesh().vertex_count())
            .map(|i| tree.mesh().vertex(i))
            .collect();
        let narrow: Vec<Vec3> = vertices.iter().map(|v| v.as_vec3() * 1.25).collect();
        // In a debug build the tree is validated, which allocates.
        let validation = allocator_calls(|| tree.validate().unwrap());
        let allowed = if cfg!(debug_assertions) {
            validation
        } else {
            0
        };
        assert_eq!(allocator_calls(|| tree.refit(&narrow).unwrap()), allowed);
        assert_eq!(
            allocator_calls(|| tree.refit_f64(&vertices).unwrap()),
            allowed
        );
        assert_eq!(allocator_calls(|| _ = black_box(tree.degradation())), 0);
    }
}

#[cfg(feature = "std")]
#[test]
fn the_system_clock() {
    let sphere = Tree::new(shapes::icosphere(3));
    let query = Query::all_pairs(&sphere, &sphere, Pose::IDENTITY);
    let mut workspace = Workspace::new();
    let calls = allocator_calls(|| {
        let budget = Budget::time(Duration::from_micros(20));
        let outcome = query.run(&mut workspace, budget);
        if outcome.stop == StopReason::Deadline {
            let _ = black_box(query.resume(&mut workspace, Budget::unlimited()));
        }
    });
    assert_eq!(calls, 0);
}

/// A full window takes the memory of the tree before the last.
#[test]
fn a_full_window() {
    let mut random = Random::new(8);
    let mut window = PointWindow::new(1000, 4.0).unwrap();
    for number in 0..20 {
        let points: Vec<Vec3> = (0..100).map(|_| random.vector().as_vec3()).collect();
        let validation = allocator_calls(|| window.tree().validate().unwrap());
        let calls = allocator_calls(|| {
            window.insert(&points).unwrap();
            assert!(!window.advance(Budget::work(9000)));
            assert!(window.advance(Budget::unlimited()));
        });
        let allowed = if cfg!(debug_assertions) {
            validation
        } else {
            0
        };
        assert!(number < 12 || calls == allowed, "{number}: {calls}");
    }
}
