//! Finished queries against all triangles, one by one, in rational numbers.

use crate::common::random::{Family, Random, soup, soups};
use crate::truth::Line;
use punctual::clock::ManualClock;
use punctual::glam::DVec3;
use punctual::rays::{RayBounds, RayHit, RayMode, Side};
use punctual::{Answer, Budget, Mesh, Query, Ray, StopReason, Tree, Workspace};

pub const ENOUGH: Budget = Budget::work(1 << 40);

pub fn run(tree: &Tree, ray: Ray, mode: RayMode, workspace: &mut Workspace) -> Answer<RayBounds> {
    Query::ray(tree, ray)
        .mode(mode)
        .run(workspace, ENOUGH.clock(&ManualClock::new()))
}

/// Rays to and from corners, edges and middles of triangles, along axes, within planes, and anywhere.
pub fn lines(tree: &Tree, count: usize, random: &mut Random) -> Vec<Line> {
    let mesh = tree.mesh();
    let bounds = mesh.aabb();
    let (middle, size) = (bounds.min * 0.5 + bounds.max * 0.5, bounds.max - bounds.min);
    let place = |random: &mut Random| {
        let [p, q, r] = mesh.triangle(random.below(mesh.len()));
        match random.below(6) {
            0 => p,
            1 => p * 0.5 + q * 0.5,
            2 => p * 0.25 + q * 0.25 + r * 0.5,
            3 => middle + random.vector() * size,
            4 => middle + random.vector() * size * 3.0,
            _ => middle,
        }
    };
    let mut lines = Vec::new();
    while lines.len() < count {
        let (from, to) = (place(random), place(random));
        let [p, q, r] = mesh.triangle(random.below(mesh.len()));
        let axis = DVec3::AXES[random.below(3)] * if random.below(2) == 0 { 1.0 } else { -1.0 };
        let line = match random.below(8) {
            0 => [from, axis],
            1 => [from, axis * size.max_element()],
            // In the plane of a triangle, or along an edge of it.
            2 => [p, q - r],
            3 => [p, q - p],
            4 => [p + (p - q), q - p],
            _ => [from, to - from],
        };
        let is_fine = |v: DVec3| v.is_finite() && v.abs().max_element() <= 1e300;
        if is_fine(line[0]) && is_fine(line[1]) && line[1] != DVec3::ZERO && random.below(3) > 0 {
            lines.push(Line::half_line(line[0], line[1]));
        } else if from != to {
            lines.push(Line::segment(from, to));
        }
    }
    lines
}

/// All modes, kernels and a batch against the truth.
pub fn assert_right(tree: &Tree, lines: &[Line], workspace: &mut Workspace) -> usize {
    let (mut portable, mut count) = (Workspace::with_capacity(0, 0), 0);
    portable.use_portable_kernels();
    let rays: Vec<Ray> = lines.iter().map(|line| line.ray).collect();
    let batch = Query::rays(tree, &rays);
    let done = batch.run(workspace, ENOUGH.clock(&ManualClock::new()));
    assert_eq!((done.value, done.stop), (rays.len(), StopReason::Finished));
    let nearest = workspace.first_hits().to_vec();
    assert_eq!(
        batch.run(&mut portable, ENOUGH.clock(&ManualClock::new())),
        done
    );
    assert_eq!(portable.first_hits(), nearest);
    let _ = batch
        .any()
        .run(workspace, ENOUGH.clock(&ManualClock::new()));
    let any = workspace.first_hits().to_vec();
    for (i, line) in lines.iter().enumerate() {
        let truth = line.all(tree);
        let cast = run(tree, line.ray, RayMode::All, workspace);
        let mut hits: Vec<RayHit> = workspace.ray_hits().to_vec();
        hits.sort_by_key(|hit| hit.triangle);
        let ids = |hits: &[RayHit]| hits.iter().map(|hit| hit.triangle).collect::<Vec<_>>();
        assert_eq!(
            ids(&hits),
            truth.iter().map(|(id, _)| *id).collect::<Vec<_>>(),
            "{:?}",
            line.ray
        );
        assert_eq!(
            (cast.stats.found, cast.value.free_until, cast.stop),
            (hits.len() as u64, f64::INFINITY, StopReason::Finished)
        );
        hits.iter()
            .zip(&truth)
            .for_each(|(hit, (_, t))| line.assert_close(tree, hit, t));
        count += hits.len();

        let first = hits
            .iter()
            .copied()
            .min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        let cast = run(tree, line.ray, RayMode::Nearest, workspace);
        assert_eq!((cast.value.hit, nearest[i]), (first, first));
        assert_eq!(
            cast.value.free_until,
            first.map_or(f64::INFINITY, |hit| hit.t)
        );
        assert_eq!(run(tree, line.ray, RayMode::Nearest, &mut portable), cast);
        let found = run(tree, line.ray, RayMode::Any, workspace);
        assert_eq!(found.value.hit, any[i]);
        assert_eq!(found.value.hit.is_some(), !hits.is_empty());
        assert!(found.value.hit.is_none_or(|hit| hits.contains(&hit)));
        let stop = if hits.is_empty() {
            StopReason::Finished
        } else {
            StopReason::FirstHit
        };
        assert_eq!(found.stop, stop);
    }
    count
}

fn assert_soups(family: Family) {
    let mut random = Random::new(family as u64);
    let mut workspace = Workspace::new();
    let mut count = 0;
    for size in [1, 7, 40] {
        let tree = Tree::new(soup(family, size, &mut random));
        count += assert_right(&tree, &lines(&tree, 30, &mut random), &mut workspace);
    }
    assert!(count > 20, "{count} hits");
}
soups!(assert_soups);

#[test]
fn limits_leave_out_what_is_told_beyond_them() {
    let tree = Tree::new(punctual::shapes::cuboid([1.0, 1.0, 1.0], 2));
    let ray = Ray::new([-3.0, 0.3, 0.4], [2.0, 0.0, 0.0]).unwrap();
    let mut workspace = Workspace::new();
    let mut nearest = |t_min, t_max| {
        let cast = run(
            &tree,
            ray.within(t_min, t_max),
            RayMode::Nearest,
            &mut workspace,
        );
        cast.value.hit.map(|hit| (hit.t, hit.side))
    };
    assert_eq!(nearest(0.0, 9.0), Some((1.0, Side::Front)));
    assert_eq!(nearest(1.0, 1.0), Some((1.0, Side::Front)));
    assert_eq!(nearest(1.1, 9.0), Some((2.0, Side::Back)));
    assert_eq!(nearest(1.1, 1.9), None);
    assert_eq!(nearest(3.0, 1.0), None);
    assert_eq!(nearest(f64::NAN, f64::NAN), Some((1.0, Side::Front)));
    assert_eq!(nearest(-5.0, -1.0), None);
}

#[test]
fn an_empty_mesh_and_no_rays_are_answered() {
    let empty = Tree::new(punctual::Mesh::new([[0.0_f32; 3]; 0], []).unwrap());
    let ray = Ray::new([0.0; 3], [1.0, 0.0, 0.0]).unwrap();
    let mut workspace = Workspace::new();
    for mode in [RayMode::Nearest, RayMode::Any, RayMode::All] {
        let cast = run(&empty, ray, mode, &mut workspace);
        assert_eq!(
            (cast.value.hit, cast.value.free_until, cast.stop),
            (None, f64::INFINITY, StopReason::Finished)
        );
    }
    let done =
        Query::rays(&empty, &[ray, ray]).run(&mut workspace, ENOUGH.clock(&ManualClock::new()));
    assert_eq!((done.value, workspace.first_hits()), (2, &[None; 2][..]));
    let done = Query::rays(&empty, &[]).run(&mut workspace, ENOUGH.clock(&ManualClock::new()));
    assert_eq!((done.value, done.stop), (0, StopReason::Finished));
}

/// The same triangles in units from the least to the largest that a mesh takes, alike along all axes and not: between
/// what
/// `f64` computes and what only exact sums tell.
#[test]
fn meshes_of_any_size() {
    let power = |exponent: i32| {
        if exponent < -1022 {
            f64::from_bits(1)
        } else {
            2f64.powi(exponent)
        }
    };
    let (mut random, mut workspace, mut count) = (Random::new(3), Workspace::new(), 0);
    let scales = [-1074, -700, -340, -301, 0, 298, 310, 345, 400, 512, 990];
    for exponents in scales
        .iter()
        .flat_map(|&e| [[e; 3], [e, e / 2, -e.max(-990)], [0, e, 0]])
    {
        let scale = DVec3::from_array(exponents.map(power));
        let corners: Vec<[f64; 3]> = (0..24)
            .map(|_| {
                (DVec3::from_array([0; 3].map(|_| random.below(9) as f64 - 4.0)) * scale).to_array()
            })
            .collect();
        let mesh = Mesh::from_f64(corners, (0..8).map(|i| [3 * i, 3 * i + 1, 3 * i + 2])).unwrap();
        let tree = Tree::new(mesh);
        let mut lines = lines(&tree, 6, &mut random);
        // From a middle of a triangle out and back, by directions of any length.
        for length in [1.0, 1e-300, 1e-90, 1e90, 1e300] {
            let [a, b, c] = tree.mesh().triangle(random.below(8));
            let (middle, unit) = (
                a * 0.25 + b * 0.25 + c * 0.5,
                scale * (1.0 / scale.max_element()),
            );
            let way = random.vector() * unit * length;
            let origin = middle - way * (scale.max_element() / length);
            if way != DVec3::ZERO && origin.abs().max_element() < power(1000) {
                lines.push(Line::half_line(origin, way));
            }
        }
        count += assert_right(&tree, &lines, &mut workspace);
    }
    assert!(count > 300, "{count} hits");
}

/// Parameters and limits beyond the range of `f64`, and what is proven of a run that was stopped there.
#[test]
fn limits_far_away() {
    let far = 2f64.powi(1000);
    let wall = Mesh::from_f64(
        [[far, -far, -far], [far, far, -far], [far, 0.0, far]],
        [[0, 1, 2]],
    )
    .unwrap();
    let tree = Tree::new(wall);
    let mut workspace = Workspace::new();
    for (length, t) in [
        (1.0, far),
        (2f64.powi(-20), 2f64.powi(1020)),
        (2f64.powi(-30), f64::INFINITY),
        (far, 1.0),
    ] {
        let line = Line::half_line(DVec3::ZERO, DVec3::X * length);
        assert_right(
            &tree,
            &[Line::half_line(DVec3::ZERO, DVec3::X * length)],
            &mut workspace,
        );
        let hit = |ray, workspace: &mut Workspace| {
            run(&tree, ray, RayMode::Nearest, workspace)
                .value
                .hit
                .map(|hit| hit.t)
        };
        assert_eq!(hit(line.ray, &mut workspace), Some(t));
        assert_eq!(hit(line.ray.within(t, t), &mut workspace), Some(t));
        assert_eq!(
            hit(line.ray.within(0.0, t.min(f64::MAX) * 0.5), &mut workspace),
            None
        );
        let none = Query::ray(&tree, line.ray)
            .run(&mut workspace, Budget::work(0).clock(&ManualClock::new()));
        assert!(
            none.stop == StopReason::WorkLimit && none.value.free_until <= t,
            "{none:?}"
        );
    }
}

#[test]
fn directions_and_origins_of_any_size() {
    let tree = Tree::new(punctual::shapes::icosphere(1));
    let mut lines = Vec::new();
    for scale in [5e-324, 1e-200, 1.0, 1e90, 1e300] {
        for far in [1.5, 1e4, 1e11, 1e200] {
            lines.push(Line::half_line(
                DVec3::new(0.1, far, 0.25),
                DVec3::new(0.0, -scale, 0.0),
            ));
            lines.push(Line::half_line(
                DVec3::new(0.1, far, 0.25),
                DVec3::new(0.0, scale, 1e-3 * scale),
            ));
        }
        if scale > 1e-90 {
            lines.push(Line::segment(
                DVec3::new(0.1, 2.0, 0.25),
                DVec3::new(0.2, -scale, 0.1),
            ));
        }
    }
    let count = assert_right(&tree, &lines, &mut Workspace::new());
    assert!(count > 40, "{count} hits");
}
