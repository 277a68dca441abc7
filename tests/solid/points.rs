//! Winding numbers and signed distances of points, against exact arithmetic and full sums.

use crate::common::random::Random;
use crate::common::steps::assert_step;
use crate::meshes::{union, unwelded, with_triangles};
use crate::truth::{assert_sound, distance, full_sum, winding};
use punctual::glam::{DVec3, Vec3};
use punctual::points::{PointBounds, PointError};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::rays::RayMode;
use punctual::tree::Solid;
use punctual::{
    Answer, Budget, BuildOptions, Mesh, Query, Ray, StopReason, Tree, Workspace, shapes,
};

fn solid(mesh: &Mesh) -> Tree {
    Tree::with_options(mesh.clone(), &BuildOptions::default().solid(Solid::Keep))
}

fn ask(tree: &Tree, point: DVec3, workspace: &mut Workspace) -> PointBounds {
    let answer: Answer<PointBounds> = Query::signed_distance(tree, point)
        .unwrap()
        .run(workspace, Budget::unlimited());
    assert_eq!(answer.stop, StopReason::Finished);
    answer.value
}

/// Points in and about a mesh, on its vertices, edges and faces, and beside them.
fn points(mesh: &Mesh, count: usize, random: &mut Random) -> Vec<DVec3> {
    let bounds = mesh.aabb();
    let (middle, reach) = (
        0.5 * bounds.min + 0.5 * bounds.max,
        0.6 * (bounds.max - bounds.min),
    );
    let size = reach.max_element();
    (0..count)
        .map(|i| {
            let [a, b, c] = mesh.triangle(random.below(mesh.len()));
            let near = match i % 8 {
                0 => a,
                1 => 0.5 * (a + b),
                2 => (a + b + c) / 3.0,
                3 => a + (b - a) * random.unit(),
                // In line with a vertex, along an axis.
                4 => {
                    let mut point = middle + reach * random.vector();
                    let axis = random.below(3);
                    point[axis] = a[axis];
                    point[(axis + 1) % 3] = a[(axis + 1) % 3];
                    point
                }
                // In the plane of a face, or nearly.
                5 => a + (b - a) * (2.0 * random.signed()) + (c - a) * random.signed(),
                _ => middle + reach * random.vector(),
            };
            match i / 8 % 3 {
                0 => near,
                1 => near + random.vector() * (1e-12 * size),
                _ => near + random.vector() * (1e-3 * size * random.unit()),
            }
        })
        .collect()
}

/// Closed meshes: with cavities, parts in parts, an edge and a vertex of four triangles and more, surfaces twice and
/// through each other, degenerate triangles, and inside out.
fn closed() -> Vec<Mesh> {
    let (cube, ball) = (shapes::cuboid(Vec3::ONE, 2), shapes::icosphere(1));
    let mut twice = ball.triangles().to_vec();
    twice.extend_from_slice(ball.triangles());
    let mut degenerate = ball.triangles().to_vec();
    degenerate.extend([[0, 0, 5], [3, 9, 3], [7, 7, 7]]);
    let parts = union(&[
        (&cube, 1.0, DVec3::ZERO),
        (&ball, -0.9, DVec3::ZERO),
        (&ball, 0.5, DVec3::splat(0.01)),
    ]);
    let edge = union(&[
        (&cube, 1.0, DVec3::ZERO),
        (&cube, 1.0, DVec3::new(2.0, 2.0, 0.0)),
        (&cube, 1.0, DVec3::new(-2.0, -2.0, -2.0)),
    ]);
    let through = union(&[
        (&ball, 1.0, DVec3::ZERO),
        (&ball, 1.0, DVec3::X),
        (&ball, -1.0, DVec3::Y),
        (&cube, 0.7, DVec3::ZERO),
    ]);
    vec![
        shapes::icosphere(2),
        unwelded(&shapes::torus_knot(2, 3, 0.2, 12)),
        with_triangles(&ball, twice),
        with_triangles(&ball, degenerate),
        with_triangles(&ball, ball.triangles().iter().map(|&[a, b, c]| [a, c, b])),
        shapes::gear(7, 1),
        parts,
        edge,
        through,
        cube,
    ]
}

#[test]
fn winding_numbers_of_closed_meshes_are_exact_and_points_on_the_surface_are_told() {
    let mut random = Random::new(1);
    let (mut workspace, mut on_surface, mut inside) = (Workspace::new(), 0, 0);
    for mesh in closed() {
        let tree = solid(&mesh);
        assert!(tree.solid().unwrap().is_closed());
        for point in points(&mesh, 240, &mut random) {
            let said = ask(&tree, point, &mut workspace);
            let truth = winding(&mesh, point, &mut random);
            assert_sound(&said, truth, None);
            assert!(said.inside.is_some() && said.error == 0.0 && said.winding.is_some());
            on_surface += usize::from(truth.is_none());
            inside += usize::from(truth.is_some_and(|winding| winding > 0));
        }
    }
    assert!(on_surface > 200 && inside > 500, "{on_surface} {inside}");
}

#[test]
fn far_tiny_and_huge_meshes_are_exact_too() {
    let mut random = Random::new(2);
    let mut workspace = Workspace::new();
    let ball = shapes::icosphere(1);
    for (scale, offset) in [
        (1.0, 1e9),
        (1e-3, 1e12),
        (1e-300, 0.0),
        (1e-310, 0.0),
        (1e-310, 1e-300),
        (5e-323, 0.0),
        (1e300, 0.0),
        (1e300, 5e300),
        (1.0, 1e300),
    ] {
        let mesh = union(&[(&ball, scale, DVec3::splat(offset))]);
        let tree = solid(&mesh);
        for point in points(&mesh, 48, &mut random) {
            let said = ask(&tree, point, &mut workspace);
            let away = distance(&mesh, point);
            assert_sound(&said, winding(&mesh, point, &mut random), Some(&away));
        }
    }
}

#[test]
fn coordinates_of_all_sizes_in_one_mesh() {
    let mut random = Random::new(3);
    let mut workspace = Workspace::new();
    let ball = shapes::icosphere(1);
    // Each vertex has its own exponents, the signs of the coordinates stay.
    for _ in 0..12 {
        let vertices: Vec<[f64; 3]> = (0..ball.vertex_count())
            .map(|i| {
                let vertex = ball.vertex(i).to_array();
                vertex.map(|x| x * (600.0 * random.signed()).exp2())
            })
            .collect();
        let mesh = Mesh::from_f64(vertices, ball.triangles().iter().copied()).unwrap();
        let tree = solid(&mesh);
        for i in 0..24 {
            let [a, b, c] = mesh.triangle(random.below(mesh.len()));
            let point = match i % 4 {
                0 => 0.5 * (a + b),
                1 => 0.5 * (a - c),
                _ => random.vector() * (600.0 * random.signed()).exp2(),
            };
            let said = ask(&tree, point, &mut workspace);
            let away = distance(&mesh, point);
            assert_sound(&said, winding(&mesh, point, &mut random), Some(&away));
        }
    }
}

/// Meshes with open edges: some triangles missing, cut in half, some turned, one alone.
fn open(random: &mut Random) -> Vec<Mesh> {
    let mut meshes = vec![shapes::height_field(8, 1)];
    for mesh in [
        shapes::icosphere(3),
        shapes::torus_knot(2, 3, 0.2, 30),
        shapes::gear(9, 2),
    ] {
        let all = mesh.triangles().to_vec();
        let mut few = all.clone();
        few.retain(|_| random.unit() > 0.02);
        let mut turned = all.clone();
        turned.iter_mut().for_each(|t| {
            if random.unit() < 0.02 {
                t.swap(0, 1);
            }
        });
        let half = all[..all.len() / 2].to_vec();
        for triangles in [few, turned, half, vec![all[0]]] {
            meshes.push(with_triangles(&mesh, triangles));
        }
    }
    meshes
}

#[test]
fn winding_numbers_of_open_meshes_are_the_full_sum() {
    let mut random = Random::new(4);
    let mut workspace = Workspace::new();
    let (mut worst, mut inside) = (0.0_f64, 0);
    for mesh in open(&mut random) {
        for mesh in [unwelded(&mesh), mesh] {
            let tree = solid(&mesh);
            let open_edges = tree.solid().unwrap().open_edges();
            assert!(open_edges > 0);
            let bounds = mesh.aabb();
            let (middle, size) = (0.5 * (bounds.min + bounds.max), bounds.max - bounds.min);
            for i in 0..200 {
                let reach = [0.5, 0.55, 3.0, 1e4][i % 4];
                let point = middle + size * reach * random.vector();
                let said = ask(&tree, point, &mut workspace);
                let sum = full_sum(&mesh, point);
                let found = said.winding.unwrap();
                worst = worst.max((found - sum).abs());
                assert!((found - sum).abs() <= said.error + 1e-12, "{point}");
                assert!(said.error < 1e-9, "{}", said.error);
                assert!(said.inside == Some(sum > 0.5) || (sum - 0.5).abs() < 1e-9);
                inside += usize::from(sum > 0.5);
                // In line with the end of an open edge, along every axis, from both sides.
                let vertex = mesh.triangle(random.below(mesh.len()))[i % 3];
                let mut beside = vertex;
                beside[i % 3] += size[i % 3] * random.signed();
                let said = ask(&tree, beside, &mut workspace);
                let (found, sum) = (said.winding.unwrap(), full_sum(&mesh, beside));
                assert!(
                    said.is_on_surface || (found - sum).abs() <= said.error + 1e-11,
                    "{beside}: {found}, the sum is {sum}"
                );
            }
        }
    }
    assert!(worst < 1e-12 && inside > 200, "{worst}, {inside} inside");
}

#[test]
fn a_missing_face_is_half_open_at_its_middle() {
    let cube = shapes::cuboid(Vec3::ONE, 1);
    let is_top = |t: &[u32; 3]| t.iter().all(|&i| cube.vertex(i as usize).z > 0.5);
    let mesh = with_triangles(
        &cube,
        cube.triangles().iter().copied().filter(|t| !is_top(t)),
    );
    let tree = solid(&mesh);
    let mut workspace = Workspace::new();
    let mut at = |z: f64| ask(&tree, DVec3::new(0.0, 0.0, z), &mut workspace);
    assert_eq!((at(0.9).inside, at(1.1).inside), (Some(true), Some(false)));
    let middle = at(1.0);
    assert!((middle.winding.unwrap() - 0.5).abs() <= middle.error);
    // Inside or not cannot be said there, so the distance has both signs.
    assert_eq!(middle.inside, None);
    let away = middle.distance.unwrap();
    assert!(away.low == -away.high && (away.high - 1.0).abs() < 1e-12);
}

#[test]
fn signed_distances_are_true_and_tight() {
    let mut random = Random::new(5);
    let mut workspace = Workspace::new();
    for mesh in closed() {
        let tree = solid(&mesh);
        let size = (mesh.aabb().max - mesh.aabb().min).length();
        let mut all = points(&mesh, 24, &mut random);
        for far in [1e1, 1e3, 1e6, 1e12, 1e100] {
            all.push(random.vector() * far);
            all.push(DVec3::Z * far);
        }
        for point in all {
            let said = ask(&tree, point, &mut workspace);
            let away = distance(&mesh, point);
            assert_sound(&said, winding(&mesh, point, &mut random), Some(&away));
            let found = said.distance.unwrap();
            let reach = size + away.rounded();
            assert!(found.high - found.low <= 2e-13 * reach, "{point}");
            let nearest = mesh.triangle(found.triangle as usize);
            assert!((found.point - point).length() <= away.rounded() + 1e-12 * reach);
            let off = crate::exact_distance::Distance::of(&nearest, &[found.point; 3]);
            assert!(off.rounded() <= 1e-12 * reach);
        }
    }
}

/// All that an answer says but its time.
fn said(answer: &Answer<PointBounds>) -> (PointBounds, StopReason, u64) {
    (answer.value, answer.stop, answer.stats.work)
}

#[test]
fn at_every_stop_bounds_are_true_and_a_resumed_query_ends_with_the_same_bits() {
    let mut random = Random::new(6);
    let mut meshes = closed();
    meshes.push(with_triangles(
        &shapes::icosphere(2),
        shapes::icosphere(2).triangles()[9..].iter().copied(),
    ));
    for mesh in meshes {
        let tree = solid(&mesh);
        for point in points(&mesh, 12, &mut random) {
            let away = distance(&mesh, point);
            let is_closed = tree.solid().unwrap().is_closed();
            let truth = is_closed.then(|| winding(&mesh, point, &mut random));
            let query = Query::signed_distance(&tree, point).unwrap();
            let (mut whole, mut parts) = (Workspace::new(), Workspace::new());
            let end = query.run(&mut whole, Budget::unlimited());
            for step in [1, 150, 700] {
                let mut answer = query.run(&mut parts, Budget::work(step));
                let mut stops = 0;
                while answer.stop == StopReason::WorkLimit {
                    if let Some(truth) = truth {
                        assert_sound(&answer.value, truth, Some(&away));
                    } else {
                        let now = answer.value;
                        assert!(now.inside.is_none() || now.inside == end.value.inside);
                        let (now, last) = (now.distance.unwrap(), end.value.distance.unwrap());
                        assert!(now.low <= last.low && last.high <= now.high);
                    }
                    let before = answer.stats.work;
                    answer = query.resume(&mut parts, Budget::work(step)).unwrap();
                    assert_step(answer.stats.work - before, step, MAX_DISTANCE_STEP_WORK);
                    stops += 1;
                }
                assert!(stops > 0 || step > 150);
                assert_eq!(said(&answer), said(&end));
            }
            assert!(query.resume(&mut parts, Budget::unlimited()).is_err());
        }
    }
}

#[test]
fn a_batch_says_what_single_queries_say_however_it_is_cut() {
    let mut random = Random::new(7);
    let half = shapes::icosphere(3);
    let half = with_triangles(&half, half.triangles()[..700].iter().copied());
    for mesh in [shapes::gear(9, 2), half] {
        let tree = solid(&mesh);
        let mut portable = Workspace::new();
        portable.use_portable_kernels();
        let mut workspace = Workspace::new();
        let all: Vec<[f64; 3]> = points(&mesh, 100, &mut random)
            .into_iter()
            .map(Into::into)
            .collect();
        let singles: Vec<PointBounds> = all
            .iter()
            .map(|&point| ask(&tree, point.into(), &mut portable))
            .collect();
        let batch = Query::signed_distances(&tree, &all).unwrap();
        let mut answer = batch.run(&mut workspace, Budget::work(3000));
        while answer.stop != StopReason::Finished {
            assert_eq!(answer.value, workspace.points().len());
            assert_eq!(workspace.points(), &singles[..answer.value]);
            answer = batch.resume(&mut workspace, Budget::work(3000)).unwrap();
        }
        assert_eq!(answer.value, 100);
        assert_eq!(workspace.points(), singles);
        let windings = Query::windings(&tree, &all).unwrap();
        assert_eq!(windings.run(&mut workspace, Budget::unlimited()).value, 100);
        for (found, single) in workspace.points().iter().zip(&singles) {
            assert!(found.distance.is_none());
            let found = (
                found.winding,
                found.error,
                found.inside,
                found.is_on_surface,
            );
            let single = (
                single.winding,
                single.error,
                single.inside,
                single.is_on_surface,
            );
            assert_eq!(found, single);
        }
    }
}

/// Its origin is in the solid as a point is, and its hits are those of other rays, at every stop.
#[test]
fn a_ray_says_whether_it_starts_inside() {
    let (mut workspace, mut random) = (Workspace::new(), Random::new(9));
    let mut stopped = 0;
    for mesh in closed().into_iter().chain(open(&mut random)) {
        let tree = solid(&mesh);
        let surface = Tree::new(mesh.clone());
        for point in points(&mesh, 24, &mut random) {
            let inside = ask(&tree, point, &mut workspace).inside;
            let ray = Ray::new(point, random.vector()).unwrap();
            for mode in [RayMode::Nearest, RayMode::Any, RayMode::All] {
                let plain = Query::ray(&tree, ray).mode(mode);
                let whole = plain.run(&mut workspace, Budget::unlimited());
                assert_eq!(whole.value.starts_inside, None);
                assert!(
                    plain
                        .solid(true)
                        .resume(&mut workspace, Budget::work(1))
                        .is_err()
                );
                let query = plain.solid(true);
                let mut cut = query.run(&mut workspace, Budget::work(1));
                assert!(plain.resume(&mut workspace, Budget::work(1)).is_err());
                while cut.stop == StopReason::WorkLimit {
                    stopped += 1;
                    let free = whole.value.hit.map_or(f64::INFINITY, |hit| hit.t);
                    assert!(mode != RayMode::Nearest || cut.value.free_until <= free);
                    assert!(
                        cut.value
                            .starts_inside
                            .is_none_or(|said| Some(said) == inside)
                    );
                    cut = query.resume(&mut workspace, Budget::work(200)).unwrap();
                }
                assert_eq!(cut.value.starts_inside, inside, "{point}");
                assert_eq!(cut.stop, whole.stop);
                if mode != RayMode::Any {
                    assert_eq!(
                        (cut.value.hit, cut.value.free_until),
                        (whole.value.hit, whole.value.free_until)
                    );
                }
            }
            let other = Query::ray(&surface, ray).solid(true);
            let other = other.run(&mut workspace, Budget::unlimited());
            assert_eq!(other.value.starts_inside, None);
        }
    }
    assert!(stopped > 1000, "{stopped}");
}

#[test]
fn refusals_name_the_place() {
    let surface = Tree::new(shapes::icosphere(1));
    let error = Query::winding(&surface, [0.0; 3]).err();
    assert_eq!(error, Some(PointError::NotSolid));
    let tree = solid(&shapes::icosphere(1));
    let points = [[0.0; 3], [0.0, f64::NAN, 0.0]];
    let error = Query::windings(&tree, &points).err();
    assert_eq!(error, Some(PointError::NotFinite { point: 1, axis: 1 }));
    assert!(error.unwrap().to_string().contains("point 1"));
    let error = Query::signed_distance(&tree, [0.0, 0.0, -1e302]).err();
    assert_eq!(error, Some(PointError::TooLarge { point: 0, axis: 2 }));
}

#[test]
fn an_empty_solid_holds_no_point() {
    let tree = solid(&Mesh::new([[0.0_f32; 3]], []).unwrap());
    let said = ask(&tree, DVec3::ZERO, &mut Workspace::new());
    assert_eq!(
        (said.winding, said.inside, said.distance),
        (Some(0.0), Some(false), None)
    );
    let none: [[f64; 3]; 0] = [];
    let answer = Query::windings(&tree, &none)
        .unwrap()
        .run(&mut Workspace::new(), Budget::unlimited());
    assert_eq!((answer.value, answer.stop), (0, StopReason::Finished));
}
