//! Point clouds: every question, against brute force in exact arithmetic and against a mesh of
//! triangles without extent, wherever it is stopped, with the cloud on either side.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/distance.rs"]
mod distance;
#[path = "../common/exact_distance.rs"]
mod exact_distance;

mod depth;
mod files;
mod near;
mod window;

use common::check::{assert_certificate, assert_complete, assert_sound, sorted};
use common::random::Random;
use common::reference::{self, all_pairs};
use common::{MODES, ORDERS};
use distance::{Question, Truth};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::rays::RayMode;
use punctual::{
    Aabb, Budget, Mesh, MeshError, Motion, PairMemory, Pose, Query, Ray, StopReason, Tree, Verdict,
    Workspace, shapes,
};

const ENOUGH: Budget = Budget::work(1_000_000_000);

/// What a test calls a cloud: points, and the tree of as many triangles without extent.
pub struct Cloud {
    tree: Tree,
    mesh: Tree,
}

impl Cloud {
    pub fn new(points: &[DVec3]) -> Self {
        let cloud = Mesh::from_points_f64(points.iter().copied()).unwrap();
        let tree = match points.len() % 2 {
            0 => Tree::from_points_f64(points.iter().copied()).unwrap(),
            _ => Tree::new(cloud),
        };
        assert_eq!(tree.validate(), Ok(()));
        assert_eq!(tree.mesh().len(), points.len());
        let corners = (0..points.len() as u32).map(|i| [i; 3]);
        let mesh = Tree::new(Mesh::from_f64(points.iter().copied(), corners).unwrap());
        Self { tree, mesh }
    }
}

/// Clouds about the surface of `mesh`: some points on it exactly, others near, in all numbers from
/// one to some blocks; equal ones, and points on a line and on a grid.
fn clouds(mesh: &Mesh, random: &mut Random) -> Vec<Vec<DVec3>> {
    let mut found = Vec::new();
    for count in [1, 2, 7, 8, 9, 16, 17, 63, 65, 200, 1000] {
        let some = |random: &mut Random| {
            let [a, b, c] = mesh.triangle(random.below(mesh.len()));
            let near = a.lerp(b, random.unit()).lerp(c, random.unit());
            match random.below(4) {
                0 => a,
                1 => near,
                _ => near + random.vector() * 0.1,
            }
        };
        found.push((0..count).map(|_| some(random)).collect());
    }
    let point = mesh.triangle(0)[0];
    found.push(vec![point; 100]);
    found.push((0..100).map(|i| point * (0.02 * f64::from(i))).collect());
    let cell = |i: i32| f64::from(i) * 0.25 - 1.0;
    let cells = (0..9).flat_map(|x| (0..9).flat_map(move |y| (0..9).map(move |z| [x, y, z])));
    found.push(cells.map(|at| DVec3::from_array(at.map(cell))).collect());
    found
}

/// Calls `check` with all pairs of operands of which at least one is a cloud, and with the same
/// pairs of meshes.
fn each(mut check: impl FnMut([&Tree; 2], [&Tree; 2], Pose)) {
    let mut random = Random::new(66);
    let mesh = Tree::new(shapes::torus_knot(2, 3, 0.2, 6));
    let all = clouds(mesh.mesh(), &mut random);
    let all: Vec<_> = all.iter().map(|points| Cloud::new(points)).collect();
    for (i, cloud) in all.iter().enumerate() {
        let near = Pose::new(random.rotation(), random.vector() * 0.1).unwrap();
        for pose in [Pose::IDENTITY, near] {
            check([&cloud.tree, &mesh], [&cloud.mesh, &mesh], pose);
            check([&mesh, &cloud.tree], [&mesh, &cloud.mesh], pose);
            let other = &all[(i + 1) % all.len()];
            check([&cloud.tree, &other.tree], [&cloud.mesh, &other.mesh], pose);
        }
        let same = Pose::IDENTITY;
        check([&cloud.tree, &cloud.tree], [&cloud.mesh, &cloud.mesh], same);
    }
}

/// Runs a query in one go and stopped again and again; both end alike.
macro_rules! stopped {
    ($query:expr, $workspace:expr, $step:expr) => {{
        let (query, clock) = ($query, &ManualClock::new());
        let whole = query.run($workspace, ENOUGH.clock(clock));
        let mut other = Workspace::new();
        let mut part = query.run(&mut other, Budget::work($step).clock(clock));
        while let Ok(next) = query.resume(&mut other, Budget::work($step).clock(clock)) {
            part = next;
            if part.stop == StopReason::PairsFull {
                break;
            }
        }
        assert_eq!(format!("{:?}", part.value), format!("{:?}", whole.value));
        assert_eq!((part.stop, part.stats.work), (whole.stop, whole.stats.work));
        (whole, other)
    }};
}

#[test]
fn pairs_are_those_of_brute_force_wherever_a_query_stops() {
    let (workspace, clock) = (&mut Workspace::new(), ManualClock::new());
    each(|[a, b], _, pose| {
        let truth = all_pairs(a.mesh(), b.mesh(), &pose);
        for (mode, order) in MODES.into_iter().flat_map(|m| ORDERS.map(|o| (m, o))) {
            let query = Query::intersection(a, b, pose).mode(mode).order(order);
            for budget in [ENOUGH, Budget::unlimited()] {
                let said = query.run(workspace, budget.clock(&clock));
                assert_complete(mode, &said, workspace.pairs(), &truth);
            }
            for step in [0, 1, 40, 333] {
                let said = query.run(workspace, Budget::work(step).clock(&clock));
                assert_sound(&said, workspace.pairs(), &truth);
                let open = query.certificate(workspace).unwrap();
                if said.stop.is_final() {
                    continue;
                }
                assert_certificate(&open, &said, truth.len());
            }
            let (whole, other) = stopped!(query, workspace, 37);
            assert_complete(mode, &whole, workspace.pairs(), &truth);
            assert_eq!(sorted(other.pairs()), sorted(workspace.pairs()));
        }
        let mut memory = PairMemory::new();
        for _ in 0..3 {
            let query = Query::intersection(a, b, pose);
            let said = query
                .with_memory(&mut memory)
                .run(workspace, ENOUGH.clock(&clock));
            assert_eq!(said.value.meets(), !truth.is_empty());
        }
    });
}

#[test]
fn distances_hold_the_exact_one() {
    let workspace = &mut Workspace::new();
    each(|[a, b], _, pose| {
        let mut truth = Truth::new(a, b, &pose);
        for asked in [
            Question::default(),
            Question::EXACT,
            Question::closer_than(0.05),
        ] {
            let query = asked.query(a, b, pose);
            for step in [0, 1, 100, 3000] {
                let said = distance::run(&query, workspace, Budget::work(step));
                truth.assert_sound(&asked, &said);
            }
            let (whole, _) = stopped!(&query, workspace, 150);
            truth.assert_complete(&asked, &whole);
        }
    });
}

#[test]
fn contacts_are_all_pairs_within_the_margin() {
    let workspace = &mut Workspace::new();
    each(|[a, b], [x, y], pose| {
        if a.mesh().len() * b.mesh().len() > 300_000 {
            return;
        }
        let margin = 0.03;
        let list = |workspace: &Workspace| {
            let of = |c: &punctual::contacts::Contact| (c.triangles, c.distance);
            let mut list: Vec<_> = workspace.contacts().map(of).collect();
            list.sort_by_key(|contact| contact.0);
            list
        };
        let mut other = Workspace::new();
        let query = Query::contacts(a, b, pose).margin(margin);
        let (whole, parts) = stopped!(query, workspace, 500);
        if whole.stop == StopReason::PairsFull {
            return;
        }
        let found = list(workspace);
        assert_eq!(list(&parts), found);
        let same = Query::contacts(x, y, pose).margin(margin);
        let as_mesh = same.run(&mut other, ENOUGH.clock(&ManualClock::new()));
        assert_eq!(whole.stats.found, as_mesh.stats.found);
        for (one, same) in found.iter().zip(list(&other)) {
            assert_eq!(one.0, same.0);
            assert!((one.1 - same.1).abs() < 1e-12, "{one:?}, {same:?}");
        }
    });
}

#[test]
fn motions_meet_when_triangles_without_extent_do() {
    let workspace = &mut Workspace::new();
    each(|[a, b], [x, y], pose| {
        let start = Pose::new(*pose.rotation(), pose.translation() + DVec3::X * 4.0).unwrap();
        let motion = Motion::straight(start, [-5.0, 0.02, 0.01]).unwrap();
        let (whole, _) = stopped!(Query::impact(a, b, motion), workspace, 1000);
        let mut other = Workspace::new();
        let said = Query::impact(x, y, motion).run(&mut other, ENOUGH.clock(&ManualClock::new()));
        let (one, same) = (whole.value, said.value);
        let last = |t: &punctual::impact::TimeOfImpact| t.upper.unwrap_or(1.0) + 1e-6;
        assert!(one.lower <= last(&same) && same.lower <= last(&one));
        if let (Some(upper), Some([i, j])) = (one.upper, one.triangles) {
            let at = Query::impact(a, b, motion).pose(upper);
            let corners = b.mesh().triangle(j as usize).map(|v| at.transform_point(v));
            let first = a.mesh().triangle(i as usize);
            assert!(punctual::geom::triangles_intersect(&first, &corners));
        }
    });
}

#[test]
fn manifolds_tell_what_those_of_triangles_tell() {
    let workspace = &mut Workspace::new();
    each(|[a, b], [x, y], pose| {
        if a.mesh().len() * b.mesh().len() > 300_000 {
            return;
        }
        let query = Query::manifolds(a, b, pose).skin(0.02);
        let (whole, _) = stopped!(query, workspace, 700);
        let mut other = Workspace::new();
        let same = Query::manifolds(x, y, pose).skin(0.02);
        let same = same.run(&mut other, ENOUGH.clock(&ManualClock::new()));
        assert_eq!(whole.value.meets, same.value.meets);
        let distance = |bounds: &punctual::contacts::ManifoldBounds| bounds.nearest.map(|n| n.1);
        let [one, two] = [&whole.value, &same.value].map(distance);
        assert_eq!(one.is_some(), two.is_some());
        if let (Some(one), Some(two)) = (one, two) {
            assert!((one - two).abs() <= 1e-3 * one.max(two) + 1e-9, "{one}");
        }
    });
}

#[test]
fn a_ray_hits_what_it_hits_of_triangles_without_extent() {
    let workspace = &mut Workspace::new();
    each(|[a, _], [x, _], _| {
        let mut random = Random::new(7);
        for _ in 0..8 {
            let target = a.mesh().triangle(random.below(a.mesh().len()))[0];
            let way = random.vector();
            for ray in [
                Ray::new(target - way, way).unwrap(),
                Ray::new(target - DVec3::X, DVec3::X).unwrap(),
            ] {
                for mode in [RayMode::Nearest, RayMode::Any, RayMode::All] {
                    let (said, _) = stopped!(Query::ray(a, ray).mode(mode), workspace, 20);
                    let hits: Vec<_> = workspace.ray_hits().to_vec();
                    let mut other = Workspace::new();
                    let same = Query::ray(x, ray).mode(mode);
                    let same = same.run(&mut other, ENOUGH.clock(&ManualClock::new()));
                    assert_eq!(said.value.hit.is_some(), same.value.hit.is_some());
                    assert_eq!(hits.len(), other.ray_hits().len());
                }
            }
        }
    });
}

#[test]
fn points_that_do_not_exist_or_are_not_numbers() {
    let none = Tree::from_points([[0.0_f32; 3]; 0]).unwrap();
    assert_eq!(none.validate(), Ok(()));
    let ball = Tree::new(shapes::icosphere(2));
    let workspace = &mut Workspace::new();
    let said = Query::distance(&none, &ball, Pose::IDENTITY).run(workspace, ENOUGH);
    assert_eq!(said.value.low, f64::INFINITY);
    let said = Query::intersection(&ball, &none, Pose::IDENTITY).run(workspace, ENOUGH);
    assert_eq!(said.value, Verdict::Separated);
    let points = [[0.0, 1.0, 2.0], [0.0, f32::NAN, 2.0]];
    let (vertex, axis) = (1, 1);
    assert_eq!(
        Tree::from_points(points).unwrap_err(),
        MeshError::NotFinite { vertex, axis }
    );
    assert_eq!(
        Tree::from_points_f64([[0.0, 1e302, 2.0]]).unwrap_err(),
        MeshError::TooLarge { vertex: 0, axis }
    );
    assert!(Query::winding(&none, [0.0; 3]).is_err());
}

#[test]
fn a_tree_of_normal_effort_takes_less_work_and_answers_the_same() {
    let mut random = Random::new(660);
    let ball = Tree::new(shapes::icosphere(4));
    let points: Vec<_> = (0..20_000)
        .map(|_| (random.vector() * DVec3::new(3.0, 3.0, 0.01)).to_array())
        .collect();
    let fast = Tree::from_points_f64(points.iter().copied()).unwrap();
    let normal = Tree::new(Mesh::from_points_f64(points.iter().copied()).unwrap());
    let (workspace, mut work) = (&mut Workspace::new(), [0; 2]);
    for _ in 0..50 {
        let pose = Pose::new(DMat3::IDENTITY, random.vector() * 3.0).unwrap();
        let found = [&fast, &normal].map(|cloud| {
            let query = Query::distance(cloud, &ball, pose).absolute_tolerance(0.0);
            query.run(workspace, ENOUGH)
        });
        assert!((found[0].value.high - found[1].value.high).abs() < 1e-12);
        work = [0, 1].map(|i| work[i] + found[i].stats.work);
    }
    assert!(work[1] < work[0], "{work:?}");
}

#[test]
fn clouds_far_from_the_origin_and_of_equal_points() {
    let workspace = &mut Workspace::new();
    let ball = Tree::new(shapes::icosphere(3));
    let mut random = Random::new(3);
    for far in [0.0, 1e3, 1e9, 1e15] {
        let points: Vec<_> = (0..300)
            .map(|_| random.vector() + DVec3::splat(far))
            .collect();
        let cloud = Cloud::new(&points);
        let pose = Pose::new(random.rotation(), DVec3::splat(far) + random.vector()).unwrap();
        let mut truth = Truth::new(&cloud.tree, &ball, &pose);
        let said = Question::EXACT.query(&cloud.tree, &ball, pose);
        truth.assert_complete(&Question::EXACT, &distance::run(&said, workspace, ENOUGH));
        let pairs = all_pairs(cloud.tree.mesh(), ball.mesh(), &pose);
        let query = Query::all_pairs(&cloud.tree, &ball, pose);
        let said = query.run(workspace, ENOUGH);
        assert_complete(punctual::Mode::All, &said, workspace.pairs(), &pairs);
    }
    let one = DVec3::new(0.1, 0.2, 0.3);
    let equal = Tree::new(Mesh::from_points_f64(vec![one; 100_000]).unwrap());
    assert_eq!(equal.validate(), Ok(()));
    let query = Query::distance(&equal, &ball, Pose::IDENTITY).absolute_tolerance(0.0);
    let alone = Tree::from_points_f64([one]).unwrap();
    let [many, one] = [query.run(workspace, ENOUGH), {
        let query = Query::distance(&alone, &ball, Pose::IDENTITY).absolute_tolerance(0.0);
        query.run(workspace, ENOUGH)
    }];
    assert_eq!(
        [many.value.low, many.value.high],
        [one.value.low, one.value.high]
    );
    let itself = Query::intersection(&equal, &equal, Pose::IDENTITY).run(workspace, ENOUGH);
    assert!(itself.value.meets());
}

#[test]
fn moved_and_scaled_clouds_answer_as_new_ones() {
    let workspace = &mut Workspace::new();
    let (mut random, ball) = (Random::new(11), Tree::new(shapes::icosphere(3)));
    let points: Vec<_> = (0..777).map(|_| random.vector()).collect();
    let mut tree = Tree::from_points_f64(points.iter().copied()).unwrap();
    let before = tree.identity();
    for scale in [0.5, 2.0, -1.0] {
        let moved: Vec<_> = (0..777).map(|_| random.vector() * scale).collect();
        let scaled = Tree::from_points_f64(moved.iter().map(|p| *p / scale)).unwrap();
        let scaled = scaled.scaled([scale; 3]).unwrap();
        tree.refit_f64(&moved).unwrap();
        assert_eq!((tree.validate(), scaled.validate()), (Ok(()), Ok(())));
        assert_ne!(tree.identity(), before);
        assert_eq!(tree.mesh().aabb(), Aabb::from_points(moved.iter().copied()));
        let truth = all_pairs(tree.mesh(), ball.mesh(), &Pose::IDENTITY);
        let query = Query::all_pairs(&tree, &ball, Pose::IDENTITY);
        assert_complete(
            punctual::Mode::All,
            &query.run(workspace, ENOUGH),
            workspace.pairs(),
            &truth,
        );
        for tree in [&tree, &scaled] {
            let mut truth = Truth::new(tree, &ball, &Pose::IDENTITY);
            let said = Question::EXACT.query(tree, &ball, Pose::IDENTITY);
            truth.assert_complete(&Question::EXACT, &distance::run(&said, workspace, ENOUGH));
        }
    }
    let given = 3;
    let vertices = 777;
    assert_eq!(
        tree.refit(&[[0.0_f32; 3]; 3]),
        Err(MeshError::VertexCount { given, vertices })
    );
}

#[test]
fn a_cloud_takes_few_bytes_and_says_what_it_holds() {
    let mut random = Random::new(5);
    let points: Vec<_> = (0..50_001).map(|_| random.vector().as_vec3()).collect();
    let tree = Tree::from_points(points.iter().map(|p| p.to_array())).unwrap();
    let stats = tree.stats();
    assert_eq!((stats.triangles, stats.leaves), (50_001, 6251));
    assert!(stats.bytes() < 32 * 50_001, "{}", stats.bytes());
    let root = tree.root().unwrap();
    assert_eq!(
        (root.triangle_count(), root.triangles().count()),
        (50_001, 50_001)
    );
    for subtree in tree.subtrees() {
        assert!(subtree.alpha_product() <= 1.0 && subtree.children().count() <= 8);
    }
    let (copy, center) = tree.mesh().centered();
    assert!(copy.is_cloud() && copy.vertex(7) == tree.mesh().vertex(7) - center);
}

/// Random points, and some vertices of a ball, moved by quarters, which a ball moved as far holds
/// exactly.
fn about_ball(ball: &Mesh, count: usize) -> Vec<DVec3> {
    let mut random = Random::new(21);
    let mut points: Vec<_> = (0..count).map(|_| random.vector()).collect();
    for quarters in 0..5 {
        let vertex = ball.triangle(random.below(ball.len()))[0];
        points.push(vertex + DVec3::X * (0.25 * f64::from(quarters)));
    }
    points
}

#[test]
fn a_scene_says_of_clouds_what_brute_force_says() {
    use punctual_scene::{Body, Scene};
    use std::sync::Arc;
    let ball = Arc::new(Tree::new(shapes::icosphere(2)));
    let points = about_ball(ball.mesh(), 40);
    let cloud = Arc::new(Tree::from_points_f64(points).unwrap());
    let mut scene = Scene::new();
    let fixed = Body::fixed(Arc::clone(&cloud), Pose::IDENTITY);
    scene.insert(fixed).unwrap();
    let moving = Body::moving(Arc::clone(&ball), Pose::IDENTITY);
    let id = scene.insert(moving).unwrap();
    let mut counts = [0; 3];
    for i in 0..64 {
        let shift = DVec3::X * (f64::from(i % 32) * 0.0625);
        let pose = Pose::new(DMat3::IDENTITY, shift).unwrap();
        let margin = [0.0, 0.01][i as usize / 32];
        scene.set_pose(id, pose).unwrap();
        scene.set_margin(id, margin).unwrap();
        let meets = !all_pairs(cloud.mesh(), ball.mesh(), &pose).is_empty();
        let truth = near::truth(&cloud, &ball, &pose);
        let least = truth
            .iter()
            .map(|near| near.1)
            .fold(f64::INFINITY, f64::min);
        let report = scene.detect(ENOUGH.clock(&ManualClock::new()));
        let said = report.pairs.first().map(|pair| pair.verdict);
        let said = said.unwrap_or(Verdict::Separated);
        assert_ne!(said, Verdict::Undecided);
        assert_eq!(said.meets(), meets || least <= margin, "{i}");
        counts[usize::from(said.meets()) + usize::from(meets)] += 1;
    }
    assert!(counts.iter().all(|&count| count > 5), "{counts:?}");
}

#[test]
fn a_push_takes_a_ball_off_all_points() {
    use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
    let ball = Tree::new(shapes::icosphere(2));
    let cloud = Tree::from_points_f64(about_ball(ball.mesh(), 300)).unwrap();
    let mut workspace = PenetrationWorkspace::new();
    let mut met = 0;
    for i in 0..16 {
        let shift = DVec3::X * (f64::from(i) * 0.0625);
        let pose = Pose::new(DMat3::IDENTITY, shift).unwrap();
        let query = PenetrationQuery::new(&cloud, &ball, pose);
        let clock = &ManualClock::new();
        let said = query
            .run(&mut workspace, Budget::work(3_000_000).clock(clock))
            .value;
        if all_pairs(cloud.mesh(), ball.mesh(), &pose).is_empty() {
            assert_eq!((said.low, said.high), (0.0, 0.0), "{i}");
            continue;
        }
        met += 1;
        // A point is taken off a surface by any small push.
        assert!(said.low <= 1e-9, "{said:?}");
        assert!(said.high.is_finite(), "{said:?}");
        assert!(all_pairs(cloud.mesh(), ball.mesh(), &said.b_in_a).is_empty());
        let way = (said.b_in_a.translation() - shift).length();
        assert!((way - said.high).abs() < 1e-9, "{said:?}");
    }
    assert!(met >= 4, "{met}");
}
