//! A mesh against itself: the pairs are those of exact brute force, at every stop, whatever is shared.

mod common;

use std::sync::LazyLock;

use common::check::ENOUGH;
use common::random::Random;
use punctual::geom::{triangles_intersect, triangles_intersect_beyond_shared};
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::MAX_STEP_WORK;
use punctual::{
    Aabb, Budget, BuildOptions, Mesh, Mode, Pose, Query, Ray, StopReason, Tree, Verdict, Workspace,
    shapes,
};

/// Corners in small whole numbers, of which f64 has exact products.
type Whole = [DVec3; 3];

/// A point with a common denominator above 0.
type Fraction = (DVec3, f64);

fn edges(t: &Whole) -> [[DVec3; 2]; 3] {
    [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]
}

/// By the extreme points of the common part, in whole numbers.
fn truth(a: &Whole, b: &Whole) -> bool {
    let mut shared: Vec<DVec3> = a.iter().copied().filter(|p| b.contains(p)).collect();
    shared.dedup();
    if shared.len() > 2 && shared[0] == shared[2] {
        shared.pop();
    }
    let is_shared = |&(x, n): &Fraction| match *shared {
        [p] => x == p * n,
        [p, q] => {
            let (d, e) = (x - p * n, q - p);
            d.cross(e) == DVec3::ZERO && (0.0..=n * e.dot(e)).contains(&d.dot(e))
        }
        _ => false,
    };
    shared.len() == 3 || !extremes(a, b).iter().all(is_shared)
}

fn extremes(a: &Whole, b: &Whole) -> Vec<Fraction> {
    let mut found = Vec::new();
    let [of_a, of_b] = [a, b].map(|t| Aabb::from_points(*t));
    if of_a.intersection(&of_b).is_empty() {
        return found;
    }
    for (one, other) in [(a, b), (b, a)] {
        let inside = |p: &&DVec3| triangles_intersect(&[**p; 3], other);
        found.extend(one.iter().filter(inside).map(|&p| (p, 1.0)));
        let normal = (other[1] - other[0]).cross(other[2] - other[0]);
        for [p, q] in edges(one) {
            let (d, mut n) = (q - p, normal.dot(q - p));
            let mut t = normal.dot(other[0] - p);
            if n < 0.0 {
                (n, t) = (-n, -t);
            }
            let x = p * n + d * t;
            let inner = |[r, s]: [DVec3; 2]| normal.dot((s - r).cross(x - r * n)) >= 0.0;
            if n != 0.0 && (0.0..=n).contains(&t) && edges(other).into_iter().all(inner) {
                found.push((x, n));
            }
        }
    }
    for [p, q] in edges(a) {
        for [r, s] in edges(b) {
            let (d, e) = (q - p, s - r);
            let c = d.cross(e);
            let n = c.dot(c);
            let [t, u] = [e, d].map(|v| (r - p).cross(v).dot(c));
            let both = (0.0..=n).contains(&t) && (0.0..=n).contains(&u);
            if n != 0.0 && (r - p).dot(c) == 0.0 && both {
                found.push((p * n + d * t, n));
            }
        }
    }
    found
}

fn point(random: &mut Random, side: usize) -> DVec3 {
    let mut coordinate = || random.below(side) as f64;
    DVec3::new(coordinate(), coordinate(), coordinate())
}

/// On a small grid corners are shared, triangles are degenerate, coplanar and the same.
#[test]
fn two_triangles_meet_beyond_what_they_share_as_whole_numbers_say() {
    let mut random = Random::new(8);
    let mut counts = [[0; 2]; 4];
    for round in 0..40_000 {
        let side = [2, 3, 3, 5, 9][round % 5];
        let a = [0; 3].map(|_| point(&mut random, side));
        let mut b = [0; 3].map(|_| point(&mut random, side));
        // Often an edge or a corner.
        for corner in 0..random.below(4).min(2) {
            b[corner] = a[(corner + random.below(3)) % 3];
        }
        let expected = truth(&a, &b);
        let shared = a.iter().filter(|p| b.contains(p)).count();
        counts[shared][usize::from(expected)] += 1;
        for k in 0..3 {
            let turned = [a[k], a[(k + 2) % 3], a[(k + 1) % 3]];
            assert_eq!(triangles_intersect_beyond_shared(&turned, &b), expected);
            assert_eq!(triangles_intersect_beyond_shared(&b, &turned), expected);
        }
    }
    assert!(
        counts
            .as_flattened()
            .iter()
            .all(|&n| n > 100 || n == counts[3][0]),
        "{counts:?}"
    );
}

type Map = fn(DVec3) -> DVec3;

/// Vertices on a grid, and the map to where they are: exact in f64, and it keeps what meets.
struct Case {
    name: &'static str,
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    pairs: Vec<[u32; 2]>,
    place: Map,
}

fn pairs(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let corners = |t: &[u32; 3]| t.map(|i| vertices[i as usize]);
    let mut pairs = Vec::new();
    for (i, a) in triangles.iter().enumerate() {
        for (j, b) in triangles.iter().enumerate().skip(i + 1) {
            if truth(&corners(a), &corners(b)) {
                pairs.push([i as u32, j as u32]);
            }
        }
    }
    pairs
}

impl Case {
    /// With shared vertices, or without any.
    fn mesh(&self, welded: bool) -> Mesh {
        let place = |p: &DVec3| (self.place)(*p);
        if welded {
            return Mesh::from_f64(
                self.vertices.iter().map(place),
                self.triangles.iter().copied(),
            )
            .unwrap();
        }
        let corners = self.triangles.iter().flatten();
        let vertices = corners.map(|&i| place(&self.vertices[i as usize]));
        let triangles = (0..self.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        Mesh::from_f64(vertices, triangles).unwrap()
    }
}

fn sheet(side: u32, height: impl Fn(u32, u32) -> DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let at = |x: u32, y: u32| y * (side + 1) + x;
    let vertices = (0..=side).flat_map(|y| (0..=side).map(move |x| (x, y)));
    let cells = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    let two = |(x, y)| {
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        [[a, b, c], [a, c, d]]
    };
    let vertices = vertices.map(|(x, y)| height(x, y)).collect();
    (vertices, cells.flat_map(two).collect())
}

static CASES: LazyLock<Vec<Case>> = LazyLock::new(cases);

fn cases() -> Vec<Case> {
    let places: [(&str, Map); 5] = [
        ("here", |p| p),
        ("far away", |p| p + DVec3::new(1e12, -3e11, 7e11)),
        ("slivers", |p| {
            p * DVec3::new(1.0, 2f64.powi(-30), 2f64.powi(-10))
        }),
        ("dust", |p| p * 2f64.powi(-500)),
        ("huge", |p| p * 2f64.powi(900)),
    ];
    let mut random = Random::new(66);
    let mut cases = Vec::new();
    let mut add = |(vertices, triangles): (Vec<DVec3>, Vec<[u32; 3]>)| {
        let pairs = pairs(&vertices, &triangles);
        for (name, place) in places {
            let (vertices, triangles, pairs) = (vertices.clone(), triangles.clone(), pairs.clone());
            cases.push(Case {
                name,
                vertices,
                triangles,
                pairs,
                place,
            });
        }
    };
    // Soups with duplicate and degenerate triangles, of few vertices and of many.
    for (side, vertices, triangles) in [(3, 12, 60), (5, 40, 120), (9, 200, 150)] {
        let vertices: Vec<_> = (0..vertices).map(|_| point(&mut random, side)).collect();
        let mut corner = || random.below(vertices.len()) as u32;
        let mut triangles: Vec<_> = (0..triangles)
            .map(|_| [corner(), corner(), corner()])
            .collect();
        triangles.extend_from_within(..10);
        add((vertices, triangles));
    }
    // A wavy sheet, a flat one, one folded flat upon itself, one folded sharply.
    let at = |x: u32, y: u32, z: u32| DVec3::new(x.into(), y.into(), z.into());
    add(sheet(12, |x, y| at(x, y, x * x * y % 5)));
    add(sheet(10, |x, y| at(x, y, 0)));
    add(sheet(10, |x, y| at(x.min(10 - x), y, 0)));
    add(sheet(10, |x, y| at(x.min(10 - x), y, u32::from(x > 5))));
    // Two sheets through each other.
    let (mut vertices, mut triangles) = sheet(8, |x, y| at(2 * x, 2 * y, 3));
    let (more, others) = sheet(8, |x, y| at(2 * x, 5, y));
    let first = vertices.len() as u32;
    vertices.extend(more);
    triangles.extend(others.iter().map(|t| t.map(|i| i + first)));
    add((vertices, triangles));
    cases
}

fn sorted(workspace: &Workspace) -> Vec<[u32; 2]> {
    let mut pairs = workspace.pairs().to_vec();
    pairs.sort_unstable();
    pairs
}

#[test]
fn nasty_meshes_have_the_pairs_of_brute_force() {
    let (mut workspace, mut found) = (Workspace::new(), 0);
    for case in &*CASES {
        let expected = &case.pairs;
        found += expected.len();
        for welded in [true, false] {
            for options in [BuildOptions::default(), BuildOptions::fast_build()] {
                let tree = Tree::with_options(case.mesh(welded), &options);
                let query = Query::self_intersections(&tree);
                let answer = query.run(&mut workspace, ENOUGH);
                assert_eq!(sorted(&workspace), *expected, "{} {welded}", case.name);
                assert_eq!(answer.stop, StopReason::Finished);
                assert_eq!(answer.stats.found, expected.len() as u64);
                let any = query.mode(Mode::Any).run(&mut workspace, ENOUGH);
                match any.value {
                    Verdict::Intersecting { witness } => assert!(expected.contains(&witness)),
                    verdict => assert!(verdict == Verdict::Separated && expected.is_empty()),
                }
            }
        }
    }
    assert!(found > 20_000, "{found}");
}

/// Two triangles that share a corner or an edge, and are 1 to 1e-17 of their size from another
/// common point, or past it: of all shapes, slivers too. The fast filters must not lose a meeting.
#[test]
fn neighbors_that_almost_meet_beyond_what_they_share_are_told_apart() {
    let (mut random, mut workspace) = (Random::new(31), Workspace::new());
    let mut portable = Workspace::new();
    portable.use_portable_kernels();
    let mut counts = [[0; 2]; 2];
    for round in 0..40_000 {
        let [corner, p, q, r] = [0; 4].map(|_| random.vector());
        let thin = 10f64.powf(-4.0 * random.unit());
        let [p, q] = [p, p + (q - p) * thin];
        let inside = p.lerp(q, random.unit()) * (0.2 + 0.8 * random.unit());
        let gap = r * (random.signed() * 10f64.powf(-17.0 * random.unit()));
        let is_edge = round % 2 == 0;
        let (s, t) = if is_edge {
            (p, inside + gap)
        } else {
            (inside + gap, r)
        };
        let mut vertices = vec![corner, corner + p, corner + q, corner + t];
        if !is_edge {
            vertices.push(corner + s);
        }
        let other = if is_edge { [0, 1, 3] } else { [0, 4, 3] };
        let turn = |t: [u32; 3], by: usize| [t[by % 3], t[(by + 1) % 3], t[(by + 2) % 3]];
        let flip = |t: [u32; 3], by: usize| if by < 3 { t } else { [t[1], t[0], t[2]] };
        let (x, y) = (random.below(6), random.below(6));
        let triangles = [flip(turn([0, 1, 2], x), x), flip(turn(other, y), y)];
        let [a, b] = triangles.map(|t| t.map(|i| vertices[i as usize]));
        let expected = triangles_intersect_beyond_shared(&a, &b);
        let tree = Tree::new(Mesh::from_f64(vertices, triangles).unwrap());
        let query = Query::self_intersections(&tree);
        let answer = query.run(&mut workspace, ENOUGH);
        assert_eq!(answer.stats.found > 0, expected, "{a:?} {b:?}");
        let stats = query.run(&mut portable, ENOUGH).stats;
        assert_eq!(
            [answer.stats.exact_tests, answer.stats.work],
            [stats.exact_tests, stats.work]
        );
        counts[usize::from(is_edge)][usize::from(expected)] += 1;
    }
    assert!(counts[0].iter().all(|&n| n > 1000), "{counts:?}");
    // Edges meet beyond it only if they are coplanar, to the last bit.
    assert!(counts[1][0] > 1000, "{counts:?}");
}

/// Stops after every budget of the first and a sample of the others, resumed to the end, in one
/// workspace that was used by another question.
#[test]
fn stopped_runs_claim_nothing_false_and_end_in_the_same_pairs() {
    let (mut workspace, mut fresh) = (Workspace::new(), Workspace::new());
    let other = Tree::new(shapes::torus(1.0, 0.3, 12));
    for case in CASES.iter().step_by(4) {
        let expected = &case.pairs;
        let tree = Tree::new(case.mesh(true));
        let query = Query::self_intersections(&tree);
        let whole = query.run(&mut fresh, ENOUGH);
        let budgets =
            (0..20).chain((20..whole.stats.work).step_by(1 + whole.stats.work as usize / 20));
        for budget in budgets {
            let pose = Pose::new(DMat3::IDENTITY, DVec3::X * 0.5).unwrap();
            match budget % 3 {
                0 => {
                    _ = Query::all_pairs(&other, &other, pose)
                        .run(&mut workspace, Budget::work(900))
                }
                1 => {
                    _ = Query::distance(&other, &other, pose).run(&mut workspace, Budget::work(900))
                }
                _ => {
                    let ray = Ray::new([-3.0, 0.1, 0.2], [1.0, 0.0, 0.0]).unwrap();
                    _ = Query::ray(&other, ray).run(&mut workspace, Budget::work(100));
                }
            }
            let mut answer = query.run(&mut workspace, Budget::work(budget));
            let mut calls = 0;
            while answer.stop != StopReason::Finished {
                let most = budget + calls * (budget + 97) + (calls + 1) * MAX_STEP_WORK;
                assert!(answer.stats.work <= most);
                assert!(answer.value != Verdict::Separated);
                assert!(
                    workspace
                        .pairs()
                        .iter()
                        .all(|pair| expected.binary_search(pair).is_ok())
                );
                let certificate = query.certificate(&workspace).unwrap();
                assert!(certificate.upper_bound() >= expected.len() as u64);
                assert!(certificate.open_pairs() > 0);
                let left = query.remaining(&workspace, None).unwrap();
                assert!(left.work.p50 > 0.0 && left.work.p10 <= left.work.p90);
                answer = query
                    .resume(&mut workspace, Budget::work(budget + 97))
                    .unwrap();
                calls += 1;
            }
            assert_eq!(
                (answer.value, answer.stats.work),
                (whole.value, whole.stats.work)
            );
            assert_eq!(workspace.pairs(), fresh.pairs());
            assert!(query.resume(&mut workspace, ENOUGH).is_err());
        }
    }
}

#[test]
fn a_full_workspace_is_drained_and_resumed() {
    let case = &CASES[1];
    let (tree, expected) = (Tree::new(case.mesh(true)), case.pairs.clone());
    let mut workspace = Workspace::with_capacity(0, 7);
    for query in [
        Query::self_intersections(&tree),
        Query::self_intersections(&tree).pair_limit(3),
    ] {
        let mut answer = query.run(&mut workspace, ENOUGH);
        let mut pairs: Vec<_> = workspace.drain_pairs().collect();
        while answer.stop == StopReason::PairsFull {
            answer = query.resume(&mut workspace, ENOUGH).unwrap();
            assert!(workspace.pairs().len() <= 7);
            pairs.extend(workspace.drain_pairs());
        }
        pairs.sort_unstable();
        assert_eq!(pairs, expected);
        assert_eq!(answer.stats.found, expected.len() as u64);
    }
    assert_eq!(tree.self_intersections(), expected);
}

#[test]
fn a_deformed_mesh_meets_itself_after_its_refit() {
    let mesh = shapes::torus_knot(2, 3, 0.2, 32);
    let rest: Vec<DVec3> = (0..mesh.vertex_count()).map(|i| mesh.vertex(i)).collect();
    let mut tree = Tree::new(mesh);
    let mut workspace = Workspace::new();
    let answer = Query::self_intersections(&tree).run(&mut workspace, ENOUGH);
    assert_eq!(answer.value, Verdict::Separated);
    let flat: Vec<DVec3> = rest
        .iter()
        .map(|v| *v * DVec3::new(1.0, 1.0, 1e-3))
        .collect();
    let squeezed: Vec<DVec3> = rest.iter().map(|v| *v / (0.3 + v.length())).collect();
    for moved in [flat, squeezed] {
        tree.refit_f64(&moved).unwrap();
        let answer = Query::self_intersections(&tree).run(&mut workspace, ENOUGH);
        let pairs = sorted(&workspace);
        let mesh = tree.mesh();
        let mut expected = Vec::new();
        for i in 0..mesh.len() {
            for j in i + 1..mesh.len() {
                if triangles_intersect_beyond_shared(&mesh.triangle(i), &mesh.triangle(j)) {
                    expected.push([i as u32, j as u32]);
                }
            }
        }
        assert_eq!(
            (answer.stats.found as usize, pairs),
            (expected.len(), expected)
        );
    }
    let empty = Tree::new(Mesh::new([[0.0f32; 3]; 0], []).unwrap());
    let answer = Query::self_intersections(&empty).run(&mut workspace, ENOUGH);
    assert_eq!(answer.value, Verdict::Separated);
}
