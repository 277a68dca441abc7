//! Manifolds of bodies with faces, edges and corners in one place: touching, flush and sunk contact
//! have one foot with its true corners, depth and area, whatever the gap.

#[path = "common/steps.rs"]
mod steps;

use oorandom::Rand64;
use punctual::contacts::{Manifold, ManifoldBounds};
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::intersection::Operand;
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::tree::Solid;
use punctual::{
    Answer, Budget, BuildOptions, Mesh, PairMemory, Pose, Query, StopReason, Tree, Verdict,
    Workspace, shapes,
};
use steps::assert_step;

fn solid(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Tree {
    let mesh = Mesh::from_f64(vertices, triangles).unwrap();
    Tree::with_options(mesh, &BuildOptions::default().solid(Solid::Keep))
}

/// A body that stands on z = 0: a prism over unit squares of the plane, each in `cells`^2 parts, and
/// `cells` parts high.
struct Prism {
    squares: Vec<[i32; 2]>,
    height: f64,
}

impl Prism {
    fn cuboid([x, y]: [i32; 2], height: f64) -> Self {
        let squares = (0..x * y).map(|i| [i % x, i / x]).collect();
        Self { squares, height }
    }

    /// Three squares around a corner, turned by quarters.
    fn ell(quarters: usize) -> Self {
        let turned = |square: [i32; 2]| (0..quarters).fold(square, |[x, y], _| [-y - 1, x]);
        let squares = [[0, 0], [1, 0], [0, 1]].map(turned).into();
        let height = 1.0;
        Self { squares, height }
    }

    fn tree(&self, cells: i32, place: impl Fn(DVec3) -> DVec3) -> Tree {
        let mut vertices: Vec<DVec3> = Vec::new();
        let mut known = std::collections::BTreeMap::new();
        let mut vertex = |at: [i32; 3]| {
            *known.entry(at).or_insert_with(|| {
                let [x, y, z] = at.map(|c| f64::from(c) / f64::from(cells));
                vertices.push(place(DVec3::new(x, y, z * self.height)));
                vertices.len() as u32 - 1
            })
        };
        let mut triangles = Vec::new();
        let mut face = |corners: [[i32; 3]; 4]| {
            let [p, q, r, s] = corners.map(&mut vertex);
            triangles.extend([[p, q, r], [p, r, s]]);
        };
        for &[x, y] in &self.squares {
            for (i, j) in (0..cells * cells).map(|k| (k % cells, k / cells)) {
                let (u, v) = (x * cells + i, y * cells + j);
                let around = [[u, v], [u + 1, v], [u + 1, v + 1], [u, v + 1]];
                face(around.map(|[u, v]| [u, v, cells]));
                face([0, 3, 2, 1].map(|k: usize| [around[k][0], around[k][1], 0]));
                for (k, [dx, dy]) in [[0, -1], [1, 0], [0, 1], [-1, 0]].into_iter().enumerate() {
                    let beyond = [(u + dx).div_euclid(cells), (v + dy).div_euclid(cells)];
                    if self.squares.contains(&beyond) {
                        continue;
                    }
                    let ([a, b], [c, d]) = (around[k], around[(k + 1) % 4]);
                    for w in 0..cells {
                        face([[a, b, w], [c, d, w], [c, d, w + 1], [a, b, w + 1]]);
                    }
                }
            }
        }
        solid(vertices, triangles)
    }
}

/// Where two bodies are, and how they are turned and scaled.
#[derive(Clone, Copy)]
struct Frame {
    rotation: DMat3,
    size: f64,
    away: DVec3,
}

impl Frame {
    fn of(random: &mut Rand64, turned: bool, size: f64, far: f64) -> Self {
        let mut part = || random.rand_float() - 0.5;
        let turn = DQuat::from_xyzw(part(), part(), part(), 0.4).normalize();
        let rotation = if turned {
            DMat3::from_quat(turn)
        } else {
            DMat3::IDENTITY
        };
        let away = rotation * DVec3::new(1.0, 0.3, -0.7) * (far * size);
        Self {
            rotation,
            size,
            away,
        }
    }

    fn place(&self, point: DVec3) -> DVec3 {
        self.rotation * point * self.size + self.away
    }

    /// The manifolds of A in this frame and of B, moved by `offset`.
    fn ask(
        &self,
        [a, b]: [&Prism; 2],
        cells: [i32; 2],
        offset: DVec3,
        skin: f64,
    ) -> (Answer<ManifoldBounds>, Vec<Manifold>) {
        let (a, b) = (
            a.tree(cells[0], |point| self.place(point)),
            b.tree(cells[1], |point| point * self.size),
        );
        let pose = Pose::new(self.rotation, self.place(offset)).unwrap();
        let mut workspace = Workspace::new();
        let query = Query::manifolds(&a, &b, pose).skin(skin * self.size);
        let answer = query.run(&mut workspace, Budget::unlimited());
        let surfaces = Query::intersection(&a, &b, pose).surfaces();
        let meets = surfaces
            .run(&mut Workspace::new(), Budget::unlimited())
            .value;
        let meets = matches!(meets, Verdict::Intersecting { .. });
        let found = workspace.manifolds().to_vec();
        assert_eq!(answer.value.meets, meets);
        assert!(
            meets || found.iter().all(|one| !one.is_overlap),
            "{found:?}"
        );
        let mut cut = query.run(&mut workspace, Budget::work(0));
        while cut.stop == StopReason::WorkLimit {
            let before = cut.stats.work;
            cut = query.resume(&mut workspace, Budget::work(1)).unwrap();
            assert_step(cut.stats.work - before, 1, MAX_DISTANCE_STEP_WORK);
        }
        assert_eq!(
            (cut.value, cut.stats.work),
            (answer.value, answer.stats.work)
        );
        assert_eq!(workspace.manifolds(), found);
        (answer, found)
    }

    /// The normal in the frame of the bodies, the area in their unit, and the points of A with their
    /// distances.
    fn seen(&self, one: &Manifold) -> (DVec3, f64, Vec<(DVec3, f64)>) {
        let back = self.rotation.transpose();
        let points = one.points().iter().map(|point| {
            let place = back * (point.points[0] - self.away) / self.size;
            (place, point.distance / self.size)
        });
        (
            back * one.normal,
            one.area / (self.size * self.size),
            points.collect(),
        )
    }
}

const GAPS: [f64; 15] = [
    0.0, 1e-3, -1e-3, 1e-5, -1e-5, 1e-7, -1e-7, 1e-9, -1e-9, 1e-11, -1e-11, 1e-13, -1e-13, 1e-15,
    -1e-15,
];

/// Asserts that there is one foot, from `low` to `high` in the plane `height`.
fn assert_one_foot(frame: Frame, found: &[Manifold], [low, high]: [DVec3; 2], gap: f64, far: f64) {
    let [foot] = found else {
        panic!("one foot: {found:?}")
    };
    let (normal, area, points) = frame.seen(foot);
    let size = high - low;
    assert!((normal + DVec3::Z).length() < 1e-9, "{normal}");
    assert!((area - size.x * size.y).abs() < 1e-6, "{area}, not {size}");
    assert_eq!(points.len(), 4, "{points:?}");
    let rounding = 1e-11 + 1e-12 * far;
    for [x, y] in [
        [low.x, low.y],
        [low.x, high.y],
        [high.x, low.y],
        [high.x, high.y],
    ] {
        let corner = DVec3::new(x, y, low.z);
        let near = |(place, _): &&(DVec3, f64)| (*place - corner).length() < 1e-6 + gap.abs();
        let (_, distance) = points.iter().find(near).expect("a point at each corner");
        assert!(
            (distance - gap).abs() < rounding + 1e-6 * gap.abs(),
            "{distance} {gap}"
        );
    }
}

#[test]
fn boxes_with_flush_sides_have_one_foot_with_four_true_corners_at_every_gap() {
    let mut random = Rand64::new(62);
    let mut below = |n: u64| random.rand_range(0..n) as i32;
    let mut trials = Vec::new();
    for trial in 0..240 {
        let [a, b] = [(); 2].map(|()| [below(3) + 1, below(3) + 1]);
        let at = [0, 1].map(|k| below((a[k] + b[k] - 1) as u64) - b[k] + 1);
        let aside = [0.0, 0.0, 1e-12, 1e-9, 1e-6, 1e-3][below(6) as usize];
        trials.push((trial, a, b, at, aside, [below(2) + 1, below(3) + 1]));
    }
    for (trial, a, b, at, aside, cells) in trials {
        let (size, far) = [
            (1.0, 0.0),
            (1.0, 0.0),
            (1.0, 1e4),
            (1e-6, 0.0),
            (1e7, 0.0),
            (1.0, 1e6),
        ][trial % 6];
        let frame = Frame::of(&mut random, trial % 2 == 1, size, far);
        // Far from the origin smaller gaps are rounding.
        let gap = GAPS[trial % 15];
        let gap = if gap.abs() < 1e-14 * far { 0.0 } else { gap };
        let offset = DVec3::new(
            f64::from(at[0]) + aside,
            f64::from(at[1]) + 0.5 * aside,
            2.0 + gap,
        );
        let low = offset.max(DVec3::ZERO);
        let [xa, ya] = a.map(f64::from);
        let [xb, yb] = b.map(f64::from);
        let high = DVec3::new(xa.min(offset.x + xb), ya.min(offset.y + yb), 2.0);
        let skin = if gap > 0.0 {
            0.005
        } else {
            [0.0, 0.005][trial / 2 % 2]
        };
        let bodies = [&Prism::cuboid(a, 2.0), &Prism::cuboid(b, 2.0)];
        let (_, found) = frame.ask(bodies, cells, offset, skin);
        assert_one_foot(frame, &found, [low.with_z(2.0), high], gap, far);
    }
}

#[test]
fn courses_of_bricks_stand_on_each_other_with_one_foot_a_pair() {
    let mut random = Rand64::new(7);
    let brick = Prism::cuboid([2, 1], 1.0);
    for gap in [0.0, -1e-3, -1e-6, 1e-6, 1e-3] {
        for (course, shift) in [(1, 1.0), (1, -1.0), (1, 0.0), (2, 1.0), (20, -1.0)] {
            let base = f64::from(course - 1) * (1.0 + gap);
            let mut frame = Frame::of(&mut random, course % 2 == 0, 1.0, 0.0);
            frame.away = frame.rotation * DVec3::new(0.0, 0.0, base);
            let offset = DVec3::new(shift, 0.0, 1.0 + gap);
            let (_, found) = frame.ask([&brick; 2], [1, 2], offset, 0.005);
            let (low, high) = (f64::max(shift, 0.0), f64::min(shift, 0.0) + 2.0);
            let foot = [DVec3::new(low, 0.0, 1.0), DVec3::new(high, 1.0, 1.0)];
            assert_one_foot(frame, &found, foot, gap, 0.0);
        }
    }
}

/// The number of pieces of a set of squares that are joined by sides.
fn pieces(mut squares: Vec<[i32; 2]>) -> usize {
    let mut pieces = 0;
    while let Some(first) = squares.pop() {
        pieces += 1;
        let mut open = vec![first];
        while let Some([x, y]) = open.pop() {
            let is_beside = |&[u, v]: &[i32; 2]| (u - x).abs() + (v - y).abs() == 1;
            open.extend(squares.extract_if(.., |square| is_beside(square)));
        }
    }
    pieces
}

#[test]
fn feet_that_are_not_convex_have_their_own_area() {
    let mut random = Rand64::new(5);
    let mut several = 0;
    let others = [0, 1, 2, 3].map(Prism::ell).into_iter();
    let others: Vec<_> = others.chain([Prism::cuboid([2, 1], 1.0)]).collect();
    let places = (0..16).map(|k| [k % 4 - 1, k / 4 - 1]);
    let cases = places.flat_map(|place| others.iter().map(move |b| (place, b)));
    let gaps = GAPS.iter().cycle();
    for (trial, (([x, y], b), &gap)) in cases.cycle().zip(gaps).enumerate().take(480) {
        let a = Prism::ell(0);
        let moved = b.squares.iter().map(|[u, v]| [u + x, v + y]);
        let common: Vec<_> = moved.filter(|square| a.squares.contains(square)).collect();
        if common.is_empty() {
            continue;
        }
        let (area, feet) = (common.len() as f64, pieces(common));
        several += usize::from(feet > 1);
        let frame = Frame::of(&mut random, trial % 2 == 1, 1.0, 0.0);
        let offset = DVec3::new(x.into(), y.into(), 1.0 + gap);
        let cells = [trial as i32 / 3 % 2 + 1, trial as i32 / 7 % 2 + 1];
        let (_, found) = frame.ask([&a, b], cells, offset, 0.005);
        let is_down = |one: &&Manifold| frame.seen(one).0.z < -0.9;
        let down: Vec<_> = found.iter().filter(is_down).collect();
        let told: f64 = down.iter().map(|one| one.area).sum();
        assert!((told - area).abs() < 1e-6, "{trial}");
        // Apart, all feet that look one way are one manifold.
        let expected = if gap < -1e-11 { feet } else { 1 };
        assert!(gap.abs() < 1e-11 || down.len() == expected, "{trial}");
        for one in down {
            let (normal, _, points) = frame.seen(one);
            assert!(
                (normal + DVec3::Z).length() < 1e-9 && points.len() == 4,
                "{trial}: {one:?}"
            );
            for (_, distance) in points {
                assert!(
                    (distance - gap).abs() < 1e-11 + 1e-6 * gap.abs(),
                    "{distance} {gap}"
                );
            }
        }
    }
    assert!(several > 0);
}

/// A prism over a regular polygon with a radius of 1, from z = 0 to z = 1.
fn regular_prism(sides: u32, turn: f64) -> Tree {
    let corner = |i: u32| {
        let angle = turn + std::f64::consts::TAU * f64::from(i % sides) / f64::from(sides);
        DVec3::new(angle.cos(), angle.sin(), f64::from(i / sides))
    };
    let walls = (0..sides).flat_map(|i| {
        let j = (i + 1) % sides;
        [[i, j, j + sides], [i, j + sides, i + sides]]
    });
    let ends = (1..sides - 1).flat_map(|i| [[0, i + 1, i], [sides, sides + i, sides + i + 1]]);
    solid(
        (0..2 * sides).map(corner).collect(),
        walls.chain(ends).collect(),
    )
}

#[test]
fn prisms_on_plates_and_over_their_edges_have_the_area_and_depth_of_their_foot() {
    let plate = Prism::cuboid([3, 3], 1.0).tree(2, |point| point);
    let mut workspace = Workspace::new();
    for (trial, &gap) in GAPS.iter().cycle().enumerate().take(150) {
        let sides = [3, 6, 8][trial % 3];
        let is_over_edge = trial / 3 % 2 == 1;
        // Over the edge the half of an even polygon stands on the plate.
        let sides = if is_over_edge { 6 } else { sides };
        let prism = regular_prism(sides, 0.1 * (trial % 7) as f64);
        let middle = DVec3::new(if is_over_edge { 3.0 } else { 1.5 }, 1.5, 1.0 + gap);
        let pose = Pose::new(DMat3::IDENTITY, middle).unwrap();
        let query = Query::manifolds(&plate, &prism, pose).skin(0.005);
        let answer = query.run(&mut workspace, Budget::unlimited());
        assert!(answer.stop.is_final());
        let [foot] = workspace.manifolds() else {
            panic!("{trial} gap {gap:e}: {:?}", workspace.manifolds())
        };
        let angle = std::f64::consts::TAU / f64::from(sides);
        let area = 0.5 * f64::from(sides) * angle.sin() * if is_over_edge { 0.5 } else { 1.0 };
        assert!((foot.area - area).abs() < 1e-6, "{trial}");
        assert!((foot.normal + DVec3::Z).length() < 1e-9, "{foot:?}");
        assert!(foot.points().len() == sides.min(4) as usize, "{trial}");
        let is_at = |distance: f64| (distance - gap).abs() < 1e-11 + 1e-6 * gap.abs();
        assert!(
            foot.points().iter().all(|point| is_at(point.distance)),
            "{gap:e}: {foot:?}"
        );
    }
}

#[test]
fn a_box_beside_two_walls_has_a_foot_on_each() {
    let mut random = Rand64::new(8);
    for (trial, gap) in [1e-3, 1e-6, 1e-9, 0.0]
        .into_iter()
        .cycle()
        .enumerate()
        .take(24)
    {
        let frame = Frame::of(&mut random, trial % 2 == 1, 1.0, 0.0);
        let (walls, cube) = (Prism::ell(0), Prism::cuboid([1, 1], 1.0));
        let cells = [trial as i32 / 4 % 2 + 1, trial as i32 / 8 % 2 + 1];
        let offset = DVec3::new(1.0 + gap, 1.0 + gap, 0.0);
        let (_, found) = frame.ask([&walls, &cube], cells, offset, 0.005);
        assert_eq!(found.len(), 2, "gap {gap:e}: {found:?}");
        for one in &found {
            let (normal, area, points) = frame.seen(one);
            let is_along = normal.x.abs() > 1.0 - 1e-9 || normal.y.abs() > 1.0 - 1e-9;
            assert!(is_along && (area - 1.0).abs() < 0.01, "{one:?}");
            assert!(
                points
                    .iter()
                    .all(|(_, distance)| (distance - gap).abs() < 1e-11)
            );
        }
    }
}

/// Manifolds of cubes with an edge of 1, from the corner 0.
fn cubes(frame: Frame, offset: [f64; 3]) -> (Answer<ManifoldBounds>, Vec<Manifold>) {
    let cube = Prism::cuboid([1, 1], 1.0);
    frame.ask([&cube; 2], [1, 1], offset.into(), 0.01)
}

#[test]
fn corners_edges_and_bodies_in_one_place() {
    let mut random = Rand64::new(3);
    for turned in [false, true] {
        let frame = Frame::of(&mut random, turned, 1.0, 0.0);
        // Corner on corner.
        let (_, found) = cubes(frame, [1.0; 3]);
        let [corner] = &found[..] else {
            panic!("{found:?}")
        };
        let (normal, _, points) = frame.seen(corner);
        assert!(
            (normal + DVec3::ONE.normalize()).length() < 0.03,
            "{normal}"
        );
        assert!(points.len() == 1 && points[0].1.abs() < 1e-11, "{points:?}");
        // Edge on edge, whole and half.
        for shift in [0.0, 0.5] {
            let (_, found) = cubes(frame, [1.0, shift, 1.0]);
            let [edge] = &found[..] else {
                panic!("{found:?}")
            };
            let (normal, _, points) = frame.seen(edge);
            let across = DVec3::new(1.0, 0.0, 1.0).normalize();
            assert!((normal + across).length() < 0.03, "{normal}");
            let low = points.iter().map(|(p, _)| p.y).fold(1.0, f64::min);
            let high = points.iter().map(|(p, _)| p.y).fold(0.0, f64::max);
            assert!(points.len() == 2, "{points:?}");
            assert!(
                (low - shift).abs() < 1e-6 && (high - 1.0).abs() < 1e-6,
                "{points:?}"
            );
        }
        // One place: no direction parts them.
        let (answer, found) = cubes(frame, [0.0; 3]);
        assert!(found.is_empty() && answer.value.meets, "{found:?}");
        assert_eq!(answer.value.within, Some(Operand::B));
        // Half sunk.
        let (_, found) = cubes(frame, [0.0, 0.0, 0.5]);
        assert!(found.len() == 1 && found[0].is_overlap, "{found:?}");
        let (normal, area, points) = frame.seen(&found[0]);
        assert!((normal + DVec3::Z).length() < 1e-9 && (area - 1.0).abs() < 1e-9);
        assert!(points.len() == 4 && points.iter().all(|(_, d)| (d + 0.5).abs() < 1e-9));
    }
}

#[test]
fn a_foot_is_one_manifold_on_the_way_through_the_gap_of_nothing() {
    let mut random = Rand64::new(11);
    for turned in [false, true] {
        let frame = Frame::of(&mut random, turned, 1.0, 0.0);
        for i in -60..=60 {
            let gap = f64::from(i) / 60.0;
            let gap = 1e-3 * gap * gap * gap * gap * gap;
            let (_, found) = cubes(frame, [0.0, 0.0, 1.0 + gap]);
            let foot = [DVec3::Z, DVec3::ONE];
            assert_one_foot(frame, &found, foot, gap, 0.0);
        }
    }
}

#[test]
fn surfaces_proven_apart_have_no_overlap() {
    let keep = BuildOptions::default().solid(Solid::Keep);
    let ball = Tree::with_options(shapes::icosphere(2), &keep);
    let mut workspace = Workspace::new();
    let mut apart = 0;
    for (k, far) in (0..600).map(|k| (k, [0.0, 1e4, 1e6][k % 3])) {
        let x = k as f64 * 0.618;
        let turn = DQuat::from_xyzw(x.sin(), (1.3 * x).cos(), (0.7 * x).sin(), 0.3).normalize();
        let rotation = DMat3::from_quat(turn);
        let shift = DVec3::new(far, far * 0.3, -far);
        let cube = shapes::cuboid([1.0; 3], 1);
        let vertices = (0..8).map(|i| cube.vertex(i) + shift).collect();
        let cube = solid(vertices, cube.triangles().to_vec());
        let bounds = cube.mesh().aabb();
        let lowest = (0..ball.mesh().vertex_count()).map(|i| (rotation * ball.mesh().vertex(i)).z);
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        let gap = [0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12][k % 6] * (1.0 + far);
        let aside = DVec3::new(0.3 * x.sin(), 0.3 * x.cos(), 0.0);
        let place = (bounds.center() + aside).with_z(bounds.max.z - lowest + gap);
        let pose = Pose::new(rotation, place).unwrap();
        let query = Query::manifolds(&cube, &ball, pose).skin(0.01);
        let answer = query.run(&mut workspace, Budget::unlimited()).value;
        let found = workspace.manifolds();
        assert!(!found.is_empty(), "{k}");
        apart += usize::from(!answer.meets);
        assert!(
            answer.meets || found.iter().all(|one| !one.is_overlap),
            "{k}: {found:?}"
        );
    }
    assert!(apart > 100, "{apart}");
}

#[test]
fn points_keep_their_ids_while_a_stack_settles() {
    let cube = Prism::cuboid([1, 1], 1.0);
    for cells in [1, 3] {
        let (a, b) = (cube.tree(cells, |point| point), cube.tree(1, |point| point));
        let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
        let mut known: Option<(u64, Vec<u64>)> = None;
        for frame in 0..80 {
            let t = f64::from(frame);
            let fades = (-0.06 * t).exp();
            // It comes down from the skin, swings about the rest and ends sunk by 1e-5, tilted by
            // less and less.
            let height = 1.0 - 1e-5 + 4e-3 * fades * (0.4 * t).cos();
            let tilt = DVec3::new((0.7 * t).sin(), (0.5 * t).cos(), 0.0) * (5e-4 * fades);
            let middle = DVec3::new(0.5, 0.5, 0.0);
            let rotation = DMat3::from_quat(DQuat::from_scaled_axis(tilt));
            let place = middle - rotation * middle + DVec3::Z * height;
            let pose = Pose::new(rotation, place).unwrap();
            let query = Query::manifolds(&a, &b, pose).skin(0.01);
            let answer = query
                .with_memory(&mut memory)
                .run(&mut workspace, Budget::unlimited());
            assert!(answer.stop.is_final());
            let [foot] = workspace.manifolds() else {
                panic!("{frame}: {:?}", workspace.manifolds())
            };
            let mut ids: Vec<u64> = foot.points().iter().map(|point| point.id).collect();
            ids.sort_unstable();
            assert_eq!(ids.len(), 4, "{frame}: {foot:?}");
            let now = (foot.id, ids);
            assert_eq!(known.get_or_insert_with(|| now.clone()), &now, "{frame}");
        }
    }
}
