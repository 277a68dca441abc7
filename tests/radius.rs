//! Trees with a radius: every question about thickened surfaces, against closed forms, against
//! margins and cores, and stopped anywhere.

use punctual::distance::Bounds;
use punctual::engine::{Ask, Question};
use punctual::geom::random::Random;
use punctual::geom::triangle::distance::closest_or_meeting;
use punctual::geom::triangles_intersect;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::impact::TimeOfImpact;
use punctual::points::PointBounds;
use punctual::rays::RayMode;
use punctual::tree::{Solid, SolidError, TreeFileError};
use punctual::{
    Answer, Budget, BuildOptions, Mesh, MeshError, Motion, PairMemory, Pose, Query, Ray,
    StopReason, Tree, Verdict, Workspace, shapes,
};

/// Relative error that all answers may have.
const CLOSE: f64 = 1e-12;

fn vector(random: &mut Random, size: f64) -> DVec3 {
    let [x, y, z] = [(); 3].map(|()| random.between(-size, size));
    DVec3::new(x, y, z)
}

fn pose(random: &mut Random, size: f64) -> Pose {
    let turn = DQuat::from_scaled_axis(vector(random, 3.0));
    Pose::new(DMat3::from_quat(turn), vector(random, size)).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, [x, y, z]).unwrap()
}

fn core(points: [DVec3; 3]) -> Tree {
    let solid = BuildOptions::default().solid(Solid::Keep);
    let mesh = Mesh::from_f64(points.map(|p| p.to_array()), [[0, 1, 2]]).unwrap();
    Tree::with_options(mesh, &solid)
}

fn ball(radius: f64) -> Tree {
    core([DVec3::ZERO; 3]).with_radius(radius).unwrap()
}

fn capsule(half: f64, radius: f64) -> Tree {
    let end = DVec3::Z * half;
    core([-end, end, end]).with_radius(radius).unwrap()
}

fn mesh(mesh: Mesh, radius: f64) -> Tree {
    let options = BuildOptions::default().solid(Solid::Keep);
    Tree::with_options(mesh, &options)
        .with_radius(radius)
        .unwrap()
}

/// Points on a torus knot, as balls.
fn cloud(radius: f64) -> Tree {
    let knot = shapes::torus_knot(2, 3, 0.2, 24);
    let points = (0..knot.vertex_count()).map(|i| knot.vertex(i).to_array());
    let tree = Tree::from_points_f64(points).unwrap();
    tree.with_radius(radius).unwrap()
}

/// All kinds: ball, capsule, triangle, box, rounded mesh, plain mesh, cloud of balls.
fn kinds() -> Vec<Tree> {
    let triangle = core([DVec3::X, DVec3::Y, DVec3::new(-1.0, -1.0, 0.3)]);
    vec![
        ball(0.6),
        capsule(0.8, 0.3),
        triangle.with_radius(0.2).unwrap(),
        mesh(shapes::cuboid([0.5, 0.25, 0.375], 1), 0.15),
        mesh(shapes::torus(0.8, 0.3, 24), 0.1),
        mesh(shapes::icosphere(3), 0.0),
        cloud(0.05),
    ]
}

/// The answer of one uninterrupted run.
fn whole<'t, Q: Question>(query: &Query<'t, Q>, workspace: &mut Workspace) -> Q::Value
where
    Query<'t, Q>: Ask<Q>,
{
    query.run(workspace, Budget::unlimited()).value
}

/// The answer of an uninterrupted run, after one that is stopped again and again gave the same.
/// `check` sees what is told at each stop.
fn run<Q: Question>(
    query: &Query<'_, Q>,
    workspace: &mut Workspace,
    random: &mut Random,
    same: impl Fn(&Q::Value, &Q::Value) -> bool,
    check: impl Fn(&Q::Value),
) -> Answer<Q::Value>
where
    for<'t> Query<'t, Q>: Ask<Q>,
    Q::Value: PartialEq + std::fmt::Debug,
{
    let step = |random: &mut Random| Budget::work(random.between(0.0, 900.0) as u64);
    let mut part = query.run(workspace, step(random));
    while !part.stop.is_final() {
        check(&part.value);
        assert_ne!(part.stop, StopReason::PairsFull);
        part = query.resume(workspace, step(random)).unwrap();
    }
    let whole = query.run(workspace, Budget::unlimited());
    assert!(same(&part.value, &whole.value), "{part:?} {whole:?}");
    assert_eq!(part.stop, whole.stop);
    check(&whole.value);
    whole
}

/// What stops have proven may raise the lower bound of a distance by roundings.
fn same_bounds(x: &Bounds, y: &Bounds) -> bool {
    let is_close = (x.low - y.low).abs() <= CLOSE * (1.0 + x.high);
    is_close && (x.high, x.nearest, x.within) == (y.high, y.nearest, y.within)
}

/// A run that was stopped may have come to another pair first.
fn same_verdict(x: &Verdict, y: &Verdict) -> bool {
    x.meets() == y.meets() && (x.meets() || x == y)
}

/// The distance of two segments, by the ends and the pair of inner points.
fn segments([p, q]: [DVec3; 2], [r, s]: [DVec3; 2]) -> f64 {
    let to = |x: DVec3, a: DVec3, b: DVec3| {
        let t = ((x - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        (x - a.lerp(b, t)).length()
    };
    let ends = [to(p, r, s), to(q, r, s), to(r, p, q), to(s, p, q)];
    let least = ends.into_iter().fold(f64::INFINITY, f64::min);
    let (u, v, w) = (q - p, s - r, p - r);
    let (a, b, c, d, e) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let whole = a * c - b * b;
    let (x, y) = ((b * e - c * d) / whole, (a * e - b * d) / whole);
    if (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y) {
        least.min((w + u * x - v * y).length())
    } else {
        least
    }
}

#[test]
fn balls_and_capsules_are_as_far_apart_as_closed_forms_say() {
    let (mut random, mut workspace) = (Random::new(1), Workspace::new());
    let (mut apart, mut meet) = (0, 0);
    for i in 0..2_000 {
        // Every fourth pair is far from the origin, every fifth large.
        let size = if i % 5 == 0 { 1e6 } else { 1.0 };
        let far = if i % 4 == 0 { 1e5 * size } else { 0.0 };
        let offset = DVec3::splat(far);
        let ends = [(); 4].map(|()| vector(&mut random, size));
        let radii = [(); 2].map(|()| random.between(0.0, size));
        let tree = |from: DVec3, to: DVec3, radius: f64| {
            let tree = core([from + offset, to + offset, to + offset]);
            tree.with_radius(radius).unwrap()
        };
        let is_ball = [i % 2 == 0, i % 3 == 0];
        let end = |k: usize| ends[if is_ball[k / 2] { k / 2 * 2 } else { k }];
        let [a, b] = [0, 1].map(|k| tree(end(2 * k), end(2 * k + 1), radii[k]));
        let cores = match is_ball {
            [true, true] => (ends[0] - ends[2]).length(),
            [true, false] => segments([ends[2], ends[3]], [ends[0], ends[0] + 1e-300]),
            [false, true] => segments([ends[0], ends[1]], [ends[2], ends[2] + 1e-300]),
            _ => segments([ends[0], ends[1]], [ends[2], ends[3]]),
        };
        let truth = cores - radii[0] - radii[1];
        let error = CLOSE * (size + far);
        let query = Query::distance(&a, &b, Pose::IDENTITY).absolute_tolerance(0.0);
        let found = run(&query, &mut workspace, &mut random, same_bounds, |bounds| {
            assert!(bounds.low - error <= truth.max(0.0) && truth.max(0.0) <= bounds.high + error);
        });
        let bounds = found.value;
        assert!(bounds.high - bounds.low <= 2.0 * error, "{bounds:?}");
        let query = Query::intersection(&a, &b, Pose::IDENTITY);
        let verdict = run(&query, &mut workspace, &mut random, same_verdict, |_| ()).value;
        assert!(verdict.meets() || truth > -error, "{truth}");
        assert!(!verdict.meets() || truth < error, "{truth}");
        assert!(verdict.meets() || verdict == Verdict::Separated);
        let query = Query::contacts(&a, &b, Pose::IDENTITY).margin(0.1 * size);
        let _ = whole(&query, &mut workspace);
        if let Some(contact) = workspace.contacts().next() {
            assert!((contact.distance - truth).abs() <= 2.0 * error);
            let between = contact.points[0] - contact.points[1];
            let apart = contact.normal * contact.distance;
            assert!((between - apart).length() <= 10.0 * error, "{contact:?}");
        } else {
            assert!(truth > 0.1 * size - error);
        }
        (meet, apart) = (
            meet + u32::from(verdict.meets()),
            apart + u32::from(!verdict.meets()),
        );
    }
    assert!(apart > 200 && meet > 200, "{apart} apart, {meet} meet");
}

#[test]
fn every_pair_of_kinds_is_thickened_in_every_question() {
    let (mut random, mut workspace) = (Random::new(2), Workspace::new());
    workspace.reserve_contacts(1 << 16);
    let kinds = kinds();
    let (mut found_any, mut found_all) = (0, 0);
    for a in &kinds {
        for b in &kinds {
            let radii = a.radius() + b.radius();
            let [bare_a, bare_b] = [a, b].map(|tree| tree.clone().with_radius(0.0).unwrap());
            for _ in 0..12 {
                let pose = pose(&mut random, 1.6);
                let truth = Query::distance(&bare_a, &bare_b, pose).absolute_tolerance(0.0);
                let truth = whole(&truth.surfaces(), &mut workspace);
                let [low, high] = [truth.low, truth.high].map(|bound| bound - radii);
                let query = Query::distance(a, b, pose)
                    .absolute_tolerance(1e-9)
                    .surfaces();
                assert!(!query.may_contain());
                let answer = run(&query, &mut workspace, &mut random, same_bounds, |bounds| {
                    assert!(bounds.low <= high.max(0.0) + CLOSE);
                    assert!(bounds.high >= low.max(0.0) - CLOSE);
                });
                assert!(answer.value.high - answer.value.low <= 2e-9);

                let query = Query::intersection(a, b, pose).surfaces();
                let verdict = run(&query, &mut workspace, &mut random, same_verdict, |_| ()).value;
                if verdict.meets() {
                    assert!(low <= CLOSE, "{low}");
                    found_any += 1;
                } else {
                    assert!(verdict == Verdict::Separated && high > -CLOSE, "{high}");
                }
                let certificate = query.certificate(&workspace).unwrap();
                assert!(verdict.meets() || certificate.open_pairs() == 0);

                // All pairs, against the contacts of the bare cores.
                let query = Query::all_pairs(a, b, pose).surfaces();
                let all = query.run(&mut workspace, Budget::unlimited());
                assert_eq!(all.stop, StopReason::Finished);
                assert_eq!(all.value.meets(), verdict.meets());
                let mut pairs = workspace.pairs().to_vec();
                pairs.sort_unstable();
                let mut parts = Vec::new();
                let mut part = query.pair_limit(3).run(&mut workspace, Budget::work(700));
                loop {
                    parts.extend(workspace.drain_pairs());
                    if part.stop.is_final() {
                        break;
                    }
                    let limited = query.pair_limit(3);
                    part = limited.resume(&mut workspace, Budget::work(700)).unwrap();
                }
                parts.sort_unstable();
                assert!(parts == pairs, "{} {}", parts.len(), pairs.len());
                let query = Query::contacts(&bare_a, &bare_b, pose).margin(radii);
                let _ = whole(&query, &mut workspace);
                let mut near: Vec<_> = workspace.contacts().map(|one| one.triangles).collect();
                near.sort_unstable();
                assert!(near == pairs, "near {} pairs {}", near.len(), pairs.len());
                found_all += pairs.len();

                // Contacts within a margin, against those of the cores within more.
                let query = Query::contacts(&bare_a, &bare_b, pose).margin(radii + 0.05);
                let _ = whole(&query, &mut workspace);
                let bare: Vec<_> = workspace.contacts().copied().collect();
                let query = Query::contacts(a, b, pose).margin(0.05);
                let _ = whole(&query, &mut workspace);
                assert_eq!(workspace.contacts().len(), bare.len());
                let mut last = f64::NEG_INFINITY;
                for contact in workspace.contacts() {
                    let of_core = bare.iter().find(|one| one.triangles == contact.triangles);
                    let of_core = of_core.unwrap();
                    assert!((contact.distance - of_core.distance + radii).abs() < CLOSE);
                    assert!(contact.distance >= last && query.is_within(contact));
                    last = contact.distance;
                    let [p, q] = of_core.points;
                    let [p, q] = [p - contact.points[0], contact.points[1] - q];
                    assert!((p - contact.normal * a.radius()).length() < CLOSE);
                    assert!((q - contact.normal * b.radius()).length() < CLOSE);
                }
            }
        }
    }
    assert!(found_any > 60 && found_all > 2_000, "{found_any}");
}

#[test]
fn margins_add_to_radii() {
    let mut workspace = Workspace::new();
    let (a, b) = (ball(1.0), capsule(1.0, 0.5));
    let pose = at(3.0, 0.0, 0.5);
    for (margins, truth) in [([0.0; 2], 1.5), ([0.25, 0.5], 0.75), ([2.0, 0.0], 0.0)] {
        let query = Query::distance(&a, &b, pose).margins(margins);
        let found = whole(&query, &mut workspace);
        assert!(found.low <= truth && truth <= found.high && found.high - found.low < 1e-5);
    }
    let nearest = Query::distance(&a, &b, pose).run(&mut workspace, Budget::unlimited());
    let [p, q] = nearest.value.nearest.unwrap().points;
    assert!((p - DVec3::X).length() < 1e-6 && (q - DVec3::X * 2.5).length() < 1e-6);
}

#[test]
fn without_a_radius_no_bit_differs() {
    let (mut random, mut workspace) = (Random::new(4), Workspace::new());
    let [a, b] = [shapes::torus(1.0, 0.4, 24), shapes::gear(9, 2)].map(Tree::new);
    let same = a.clone().with_radius(0.0).unwrap();
    assert_eq!(a.identity(), same.identity());
    let thick = a.clone().with_radius(0.5).unwrap();
    let back = thick.with_radius(0.0).unwrap();
    assert_ne!(a.identity(), back.identity());
    assert_eq!(a.lineage(), back.lineage());
    for _ in 0..40 {
        let pose = pose(&mut random, 1.5);
        let mut told = [&a, &back].map(|tree| {
            let distance = Query::distance(tree, &b, pose).run(&mut workspace, Budget::unlimited());
            let pairs = Query::all_pairs(tree, &b, pose).run(&mut workspace, Budget::unlimited());
            let contacts = Query::contacts(tree, &b, pose).margin(0.01);
            let _ = whole(&contacts, &mut workspace);
            let contacts: Vec<_> = workspace.contacts().copied().collect();
            format!("{distance:?} {pairs:?} {contacts:?}")
        });
        let [one, other] = &mut told;
        assert_eq!(one, other);
    }
}

#[test]
fn balls_and_capsules_are_as_far_from_meshes_as_all_triangles_say() {
    let (mut random, mut workspace) = (Random::new(8), Workspace::new());
    let meshes = [
        shapes::torus_knot(2, 3, 0.1, 48),
        shapes::gear(9, 2),
        shapes::height_field(20, 3),
    ];
    let trees = meshes.map(Tree::new);
    let (mut meets, mut open) = (0, 0);
    for i in 0..300 {
        let tree = &trees[i % 3];
        let (radius, half) = (random.between(0.0, 0.3), random.between(0.0, 1.0));
        let half = [0.0, half, 30.0 * half][i / 3 % 3];
        let lone = capsule(half, radius);
        // Some are too far for the walk of one tree.
        let far = [1.0, 2.0, 60.0][i / 9 % 3];
        let pose = pose(&mut random, far);
        let is_a = i % 2 == 0;
        let [a, b] = if is_a { [&lone, tree] } else { [tree, &lone] };
        let corners = |tree: &Tree, id: usize, is_b: bool| {
            let place = |p| if is_b { pose.transform_point(p) } else { p };
            tree.mesh().triangle(id).map(place)
        };
        let core = corners(&lone, 0, !is_a);
        let gap = |id| {
            let corners = corners(tree, id, is_a);
            if triangles_intersect(&corners, &core) {
                return 0.0;
            }
            closest_or_meeting(&corners, &core).high
        };
        let gaps: Vec<f64> = (0..tree.mesh().len()).map(gap).collect();
        let core_gap = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        let truth = (core_gap - radius).max(0.0);
        let close = CLOSE * (1.0 + far);
        let query = Query::distance(a, b, pose).absolute_tolerance(0.0);
        let mut bound = u64::MAX;
        let mut part = query.run(&mut workspace, Budget::work(0));
        while !part.stop.is_final() {
            let certificate = query.certificate(&workspace).unwrap();
            assert!(certificate.upper_bound() <= bound);
            bound = certificate.upper_bound();
            open += usize::from(certificate.boxes().count() > 1);
            part = query.resume(&mut workspace, Budget::work(60)).unwrap();
        }
        let found = run(&query, &mut workspace, &mut random, same_bounds, |found| {
            assert!(found.low <= truth + close && truth <= found.high + close);
        });
        assert!(found.value.high - found.value.low <= close);
        assert!(same_bounds(&found.value, &part.value));
        let query = Query::intersection(a, b, pose);
        let found = run(&query, &mut workspace, &mut random, same_verdict, |_| ());
        if (core_gap - radius).abs() > close {
            assert_eq!(found.value.meets(), core_gap < radius, "{i}");
            meets += usize::from(core_gap < radius);
        }
        let query = Query::all_pairs(a, b, pose);
        let _ = run(&query, &mut workspace, &mut random, same_verdict, |_| ());
        let listed = workspace.pairs().len();
        let [least, most] =
            [-close, close].map(|close| gaps.iter().filter(|gap| **gap <= radius + close).count());
        assert!((least..=most).contains(&listed), "{i}");
    }
    assert!(meets > 40 && open > 300, "{meets} {open}");
}

#[test]
fn exact_touches_meet_and_huge_radii_are_accepted() {
    let mut workspace = Workspace::new();
    let mut meets = |a: &Tree, b: &Tree, pose: Pose| {
        let query = Query::intersection(a, b, pose);
        whole(&query, &mut workspace).meets()
    };
    assert!(meets(&ball(1.0), &ball(0.5), at(1.5, 0.0, 0.0)));
    assert!(meets(&ball(0.25), &ball(0.5), at(0.0, 0.75, 0.0)));
    assert!(!meets(&ball(0.25), &ball(0.5), at(0.0, 0.75 + 1e-12, 0.0)));
    let cube = mesh(shapes::cuboid([1.0; 3], 1), 0.0);
    assert!(meets(&cube, &ball(0.5), at(1.5, 0.2, 0.3)));
    assert!(!meets(&cube, &ball(0.5), at(1.5 + 1e-12, 0.2, 0.3)));
    // Inside the solid, or the core inside the radius.
    assert!(meets(&cube, &ball(0.01), at(0.1, 0.2, 0.3)));
    assert!(meets(&ball(9.0), &cube, at(1.0, 2.0, 3.0)));
    for radius in [1e20, 1e100, 2f64.powi(1000)] {
        assert!(
            meets(&ball(radius), &cube, at(0.9 * radius, 0.0, 0.0)),
            "{radius}"
        );
        assert!(meets(&ball(1.0), &cube, at(0.0, 0.0, 1.5)));
        let far = at(2f64.powi(1000), 2f64.powi(1000), 0.0);
        assert!(!meets(&ball(radius), &cube, far), "{radius}");
    }
}

#[test]
fn thickened_bodies_meet_on_the_way_when_closed_forms_say() {
    let (mut random, mut workspace) = (Random::new(5), Workspace::new());
    let (mut hits, mut free) = (0, 0);
    for _ in 0..500 {
        let start = vector(&mut random, 3.0);
        let way = vector(&mut random, 2.0) - 2.0 * start;
        let [r, s] = [(); 2].map(|()| random.between(0.1, 1.0));
        let (a, b) = (ball(r), ball(s));
        let motion = Motion::straight(Pose::new(DMat3::IDENTITY, start).unwrap(), way).unwrap();
        let query = Query::impact(&a, &b, motion).tolerance(1e-7);
        let square = way.length_squared();
        let (along, sum) = (-start.dot(way) / square, r + s);
        let least = (start + way * along.clamp(0.0, 1.0)).length();
        let root = along * along - (start.length_squared() - sum * sum) / square;
        let enters = along - root.max(0.0).sqrt();
        let truth = if start.length() <= sum { 0.0 } else { enters };
        let check = |found: &TimeOfImpact| assert!(least > sum || found.lower <= truth + 1e-9);
        let found = run(&query, &mut workspace, &mut random, PartialEq::eq, check).value;
        if least < sum * (1.0 - 1e-3) {
            let upper = found.upper.expect("they meet");
            assert!(
                found.lower <= truth + 1e-9 && upper >= truth - 1e-9,
                "{found:?} {truth}"
            );
            assert!((upper - found.lower) * square.sqrt() <= 1.1e-7);
            hits += 1;
        } else if least > sum * (1.0 + 1e-3) {
            assert!(found.lower == 1.0 && found.upper.is_none());
            free += 1;
        }
    }
    assert!(hits > 50 && free > 50, "{hits}, {free}");
}

#[test]
fn rays_enter_balls_capsules_and_rounded_meshes() {
    let (mut random, mut workspace) = (Random::new(6), Workspace::new());
    let kinds = kinds();
    let mut hits = 0;
    let thick = kinds.iter().filter(|tree| tree.radius() > 0.0);
    for (i, tree) in thick.enumerate() {
        for k in 0..200 {
            // Some from afar.
            let far = if k % 4 == 0 { 1e4 } else { 3.0 };
            let origin = vector(&mut random, far);
            let target = vector(&mut random, 1.0);
            let ray = Ray::new(origin, (target - origin) * random.between(0.1, 3.0)).unwrap();
            let query = Query::ray(tree, ray);
            let found = run(&query, &mut workspace, &mut random, PartialEq::eq, |_| ()).value;
            let bare = tree.clone().with_radius(0.0).unwrap();
            let gap = |workspace: &mut Workspace, t: f64| {
                let place = ball(0.0);
                let at = Pose::new(DMat3::IDENTITY, ray.at(t)).unwrap();
                let query = Query::distance(&bare, &place, at).absolute_tolerance(0.0);
                let found = query.surfaces().run(workspace, Budget::unlimited()).value;
                found.high - tree.radius()
            };
            let beyond = 2.0 * far / ray.direction().length();
            let end = found.hit.map_or(beyond, |hit| hit.t);
            // Nowhere before is the ray within the radius.
            for j in (0..40).take_while(|_| end > 0.0) {
                let t = end * f64::from(j) / 40.0;
                assert!(gap(&mut workspace, t) > -1e-11 * far, "{i} {k} {j}");
            }
            if let Some(hit) = found.hit {
                hits += 1;
                let off = gap(&mut workspace, hit.t);
                assert!(off.abs() < 1e-11 * far || hit.t == 0.0 && off < 0.0, "{i}");
                assert_eq!(found.free_until, hit.t);
                let any = Query::ray(tree, ray).mode(RayMode::Any);
                assert!(whole(&any, &mut workspace).hit.is_some());
                let all = Query::ray(tree, ray).mode(RayMode::All);
                let _ = whole(&all, &mut workspace);
                let first = workspace.ray_hits().iter().map(|hit| hit.t);
                assert_eq!(first.fold(f64::INFINITY, f64::min), hit.t);
                let short = ray.within(0.0, hit.t * 0.99 - 1e-300);
                let cut = Query::ray(tree, short).run(&mut workspace, Budget::unlimited());
                assert!(cut.value.hit.is_none() || hit.t == 0.0);
            }
            let rays = [ray, ray];
            let _ = Query::rays(tree, &rays).run(&mut workspace, Budget::unlimited());
            assert_eq!(workspace.first_hits(), [found.hit; 2]);
        }
    }
    assert!(hits > 300, "{hits}");
}

#[test]
fn points_are_inside_by_the_core_or_the_radius() {
    let (mut random, mut workspace) = (Random::new(7), Workspace::new());
    let (mut inside, mut outside) = (0, 0);
    let cube = mesh(shapes::cuboid([0.5, 0.25, 0.375], 1), 0.25);
    for (tree, half) in [
        (ball(0.6), DVec3::ZERO),
        (cube, DVec3::new(0.5, 0.25, 0.375)),
    ] {
        let mut point = || vector(&mut random, 1.0).to_array();
        let points: Vec<[f64; 3]> = (0..300).map(|_| point()).collect();
        for &point in &points {
            let q = DVec3::from_array(point).abs() - half;
            let core = q.max(DVec3::ZERO).length() + q.max_element().min(0.0);
            let truth = core - tree.radius();
            let query = Query::signed_distance(&tree, point).unwrap();
            let check = |found: &PointBounds| {
                let distance = found.distance.unwrap();
                assert!(distance.low <= truth + CLOSE, "{found:?} {truth}");
                assert!(truth <= distance.high + CLOSE, "{found:?} {truth}");
                assert!(found.inside != Some(true) || truth < CLOSE);
                assert!(found.inside != Some(false) || truth > -CLOSE);
            };
            let found = run(&query, &mut workspace, &mut random, PartialEq::eq, check);
            assert_eq!(found.value.inside, Some(truth <= 0.0));
            let distance = found.value.distance.unwrap();
            assert!(distance.high - distance.low < CLOSE);
            outside += u32::from(truth > 0.0);
            inside += u32::from(truth <= 0.0);
            let query = Query::winding(&tree, point).unwrap();
            let winding = whole(&query, &mut workspace);
            assert_eq!(winding.inside, Some(truth <= 0.0));
            let ray = Ray::new(point, [1.0, 0.0, 0.0]).unwrap();
            let cast = Query::ray(&tree, ray).solid(true);
            let cast = run(&cast, &mut workspace, &mut random, PartialEq::eq, |_| ()).value;
            assert_eq!(cast.starts_inside, Some(truth <= 0.0));
        }
        let done = Query::windings(&tree, &points).unwrap();
        assert_eq!(whole(&done, &mut workspace), points.len());
        assert_eq!(workspace.points().len(), points.len());
    }
    assert!(inside > 60 && outside > 60, "{inside}, {outside}");
}

#[test]
fn a_ball_on_a_table_has_one_point_of_contact() {
    let mut workspace = Workspace::new();
    let table = mesh(shapes::cuboid([5.0, 5.0, 1.0], 8), 0.0);
    let rounded = mesh(shapes::cuboid([5.0, 5.0, 0.5], 8), 0.5);
    for (tree, name) in [(&table, "table"), (&rounded, "rounded table")] {
        for height in [1.505, 1.5, 1.45] {
            let (ball, pose) = (ball(0.5), at(0.31, 0.77, height));
            let query = Query::manifolds(tree, &ball, pose).skin(0.01);
            let found = whole(&query, &mut workspace);
            assert!(found.low == f64::INFINITY);
            let manifold = &workspace.manifolds()[0];
            let point = &manifold.points()[0];
            let counts = (workspace.manifolds().len(), manifold.points().len());
            assert_eq!(counts, (1, 1), "{name}: {manifold:?}");
            assert!((point.distance - (height - 1.5)).abs() < 1e-9, "{point:?}");
            assert!((point.normal + DVec3::Z).length() < 1e-9);
            assert!((point.points[0] - DVec3::new(0.31, 0.77, 1.0)).length() < 1e-9);
            assert!((point.points[1].z - (height - 0.5)).abs() < 1e-9);
            assert_eq!(manifold.is_overlap, height < 1.5);
            assert!(height == 1.5 || found.meets == (height < 1.5));
        }
    }
    // A capsule lies on a line.
    let turned = DMat3::from_cols(DVec3::Z, DVec3::Y, -DVec3::X);
    let pose = Pose::new(turned, [0.2, 0.1, 1.495]).unwrap();
    let lying = capsule(1.0, 0.5);
    let query = Query::manifolds(&table, &lying, pose).skin(0.01);
    let _ = whole(&query, &mut workspace);
    let manifold = &workspace.manifolds()[0];
    let counts = (workspace.manifolds().len(), manifold.points().len());
    assert_eq!(counts, (1, 2), "{manifold:?}");
    assert!((manifold.distance + 0.005).abs() < 1e-9);
}

#[test]
fn a_memory_serves_trees_with_a_radius() {
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let (a, b) = (mesh(shapes::torus(1.0, 0.3, 32), 0.1), ball(0.4));
    for i in 0..60 {
        let pose = at(2.5 - 0.04 * f64::from(i), 0.1, 0.2);
        let query = Query::intersection(&a, &b, pose);
        let plain = whole(&query, &mut workspace);
        let known = query.with_memory(&mut memory);
        let known = known.run(&mut workspace, Budget::unlimited()).value;
        assert_eq!(plain.meets(), known.meets(), "{i}");
        let distance = Query::distance(&a, &b, pose);
        let plain = whole(&distance, &mut workspace);
        let known = distance.with_memory(&mut memory);
        let known = known.run(&mut workspace, Budget::unlimited()).value;
        assert!(known.low <= plain.high && plain.low <= known.high);
        let left = query.predict(Some(&memory)).work;
        assert!(0.0 < left.p50 && left.p50 <= left.p90);
        let _ = query.run(&mut workspace, Budget::work(50));
        let estimate = query.estimate(&workspace, None).unwrap();
        assert!((0.0..=1.0).contains(&estimate.probability));
        assert!((0.0..=1.0).contains(&estimate.recall));
    }
}

#[test]
fn clones_refits_scalings_and_files_keep_the_radius() {
    let tree = mesh(shapes::cuboid([1.0, 2.0, 3.0], 2), 0.25);
    assert_eq!(tree.clone().radius(), 0.25);
    let mut moved = tree.clone();
    let vertices = (0..tree.mesh().vertex_count()).map(|i| tree.mesh().vertex(i) + DVec3::X);
    moved.refit_f64(&vertices.collect::<Vec<_>>()).unwrap();
    assert_eq!(moved.radius(), 0.25);
    assert_eq!(tree.scaled([2.0; 3]).unwrap().radius(), 0.5);
    assert_eq!(tree.scaled([-1.0, 1.0, 1.0]).unwrap().radius(), 0.25);
    let factors = [1.0, 2.0, 1.0];
    let fault = tree.scaled(factors).unwrap_err();
    assert_eq!(fault, MeshError::Radius { factors });
    let bytes = tree.to_bytes();
    assert_eq!(bytes.len(), tree.bytes_len());
    let loaded = Tree::from_bytes(&bytes).unwrap();
    assert_eq!((loaded.radius(), loaded.stats()), (0.25, tree.stats()));
    assert!(tree.validate().is_ok());
    let plain = tree.clone().with_radius(0.0).unwrap().to_bytes();
    assert_eq!(plain[8], 2);
    assert_eq!(bytes[8], 3);
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut bytes = bytes.clone();
        let end = bytes.len() - 4;
        bytes[end - 8..end].copy_from_slice(&f64::to_le_bytes(radius));
        let checksum = crc32fast::hash(&bytes[..end]).to_le_bytes();
        bytes[end..].copy_from_slice(&checksum);
        let fault = Tree::from_bytes(&bytes).unwrap_err();
        assert!(matches!(fault, TreeFileError::Radius(_)), "{fault}");
    }
    for radius in [-1.0, f64::NAN, f64::INFINITY, 2f64.powi(1001)] {
        let fault = tree.clone().with_radius(radius).unwrap_err();
        let text = "radius is negative, too large or no number";
        assert_eq!(fault.to_string(), text);
    }
    let fault = tree.mass_properties().unwrap_err();
    assert_eq!(fault, SolidError::Thickened { radius: 0.25 });
    let bounds = tree.aabb_at(&Pose::IDENTITY);
    let wanted = DVec3::new(1.25, 2.25, 3.25);
    assert!((bounds.max - wanted).abs().max_element() < 1e-4 && bounds.max.cmpge(wanted).all());
}
