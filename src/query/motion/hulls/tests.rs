//! Pairs of triangles constructed to meet at a known time: the tests of boxes and of triangles find
//! each pair, with a time no later than that.

use super::*;
use crate::query::expand::{Sink, expand};
use crate::query::motion::relative_motion::{RelativeMotion, Substep};
use crate::query::motion::windows::glide;
use crate::query::outcome::Stats;
use crate::query::queue::Pair;
use crate::query::triangle_pairs::rows;
use crate::tree::Tree;
use crate::{Mesh, shapes};
use glam::{DMat3, DVec3};
use punctual_geom::lanes::{Instructions, Kernel};
use punctual_geom::random::Random;
use punctual_geom::triangle::batch::Placement;
use punctual_geom::triangle::swept::{Glide, Swept, windows};
use punctual_geom::{Motion, Pose};

/// The pairs that replace a pair, with keys.
#[derive(Default)]
struct Found {
    stats: Stats,
    pairs: Vec<(Pair, f32)>,
    triangles: Vec<([u32; 2], f32)>,
}

impl Sink for Found {
    fn stats(&mut self) -> &mut Stats {
        &mut self.stats
    }

    fn place(&mut self, pair: Pair, key: impl FnOnce() -> f32) {
        self.pairs.push((pair, key()));
    }

    fn triangles(&mut self, hits: u64, key: impl Fn(usize) -> f32, first: [u32; 2]) {
        let pair = |bit| [first[0] + bit as u32 / 8, first[1] + bit as u32 % 8];
        self.triangles
            .extend(bits(hits).map(|bit| (pair(bit), key(bit))));
    }
}

/// Two triangles that meet at `time`, in lengths of the substep from its middle.
struct Meeting<'t> {
    trees: [&'t Tree; 2],
    relative: &'t RelativePose,
    span: &'t Span,
    triangles: [u32; 2],
    time: f32,
}

impl Kernel for &Meeting<'_> {
    type Output = bool;

    /// True if the pair is found below the roots, and no node pair on the way has a later time.
    fn run<L: Lanes>(self, lanes: L) -> bool {
        let holds = |side: usize, pair: &Pair| {
            let (node, i) = (
                &self.trees[side].nodes()[pair.nodes[side] as usize],
                self.triangles[side],
            );
            let is_alive =
                || !node.is_leaf || pair.active[side] >> (i - node.first_triangle) & 1 != 0;
            node.triangle_range().contains(&(i as usize)) && is_alive()
        };
        let (mut pair, mut key) = (Pair::new(0, 0), f32::NEG_INFINITY);
        loop {
            let (mut found, mut views) = (Found::default(), Views::NONE);
            let mut hulls = Hulls::new(0.6, key, self.span, &mut views);
            let keys = &mut [[0.0; WIDTH]; WIDTH];
            expand(
                lanes,
                pair,
                self.trees,
                self.relative,
                &mut hulls,
                keys,
                &mut found,
            );
            if let Some((_, key)) = found
                .triangles
                .iter()
                .find(|found| found.0 == self.triangles)
            {
                return *key <= self.time;
            }
            match found
                .pairs
                .iter()
                .find(|(pair, _)| holds(0, pair) && holds(1, pair))
            {
                Some(next) if next.1 <= self.time => (pair, key) = *next,
                _ => return false,
            }
        }
    }
}

/// The times at which two triangles may meet, in `f32`: eight times the same pair.
struct InLanes<'t> {
    trees: [&'t Tree; 2],
    placement: &'t Placement,
    glide: &'t Glide,
    pair: [u32; 2],
    spread: bool,
}

impl Kernel for &InLanes<'_> {
    type Output = ([f32; 8], u32);

    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let [a, b] = [0, 1].map(|side| rows(self.trees[side], [self.pair; WIDTH], side));
        windows(lanes, a, b, self.placement, self.glide, 0.6, self.spread)
    }
}

/// Checks the result for two triangles that meet at a time: in `f32` for the whole substep and for
/// its eighths, and in `f64`.
fn check_triangles(
    trees: [&Tree; 2],
    relative_motion: &RelativeMotion,
    substep: &Substep,
    pair: [u32; 2],
    time: f64,
) {
    let [a, b] = trees;
    let relative = RelativePose::new(a, b, &relative_motion.pose(substep.middle));
    let (local, all) = (
        substep.local(time),
        glide(relative_motion, substep, &relative, a.unit().origin, 0.0),
    );
    for (swings, spread) in [(true, false), (true, true), (false, false), (false, true)] {
        let glide = &Glide { swings, ..all };
        let said = InLanes {
            trees,
            placement: &relative.triangles,
            glide,
            pair,
            spread,
        };
        let part = if spread {
            ((local + 0.5) * 8.0) as usize
        } else {
            0
        }
        .min(7);
        for instructions in [Instructions::detect(), Instructions::PORTABLE] {
            let (enter, active) = instructions.run(&said);
            assert!(
                active >> part & 1 != 0 && enter[part] <= local,
                "{swings} {spread}: {local} {enter:?} {active:b}"
            );
        }
    }
    let corners = |side: usize| {
        trees[side]
            .mesh()
            .triangle(trees[side].ids()[pair[side] as usize] as usize)
    };
    for span in [1.0, 0.1, 1e-3] {
        // From before the time to after it.
        let (half, middle) = (
            span / 2.0,
            (time + span / 3.0).clamp(span / 2.0, 1.0 - span / 2.0),
        );
        let (twist, pose) = (relative_motion.twist(middle), relative_motion.pose(middle));
        let of_b = corners(1).map(|corner| pose.transform_point(corner));
        let error = relative_motion.bend_besides(half) + 2.0 * relative_motion.rounding;
        let (velocities, bends) = (
            of_b.map(|corner| twist.at(corner)),
            relative_motion.bends(&twist, &of_b, half),
        );
        let window =
            Swept::new(&corners(0), &of_b, velocities, bends, error, half).window(f64::INFINITY);
        let holds = |[enter, leave]: [f64; 2]| enter <= time - middle && time - middle <= leave;
        assert!(
            window.is_some_and(holds),
            "{span}: {time} {middle} {window:?}"
        );
    }
}

/// A vertex is at a point of the other mesh at some time of a motion on the spot.
#[test]
fn what_meets_in_a_span_is_found_and_not_taken_for_later() {
    let meshes = || {
        let corners = [[0.5, 0.4, 0.1], [-0.6, 0.3, 0.0], [0.0, -0.7, 0.2]];
        let triangle = Mesh::from_f64(corners, [[0, 1, 2]]).unwrap();
        [
            shapes::cuboid([0.9, 0.6, 0.02], 5),
            shapes::gear(9, 2),
            shapes::torus_knot(2, 3, 0.2, 24),
            triangle,
        ]
    };
    let tree = |mesh: &Mesh, size: f64| {
        let vertices = (0..mesh.vertex_count()).map(|i| mesh.vertex(i) * size);
        Tree::new(Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap())
    };
    let trees = [1.0, 0.1, 20.0].map(|size| meshes().map(|mesh| tree(&mesh, size)));
    let mut random = Random::new(21);
    let (mut met, mut lost_without) = (0, 0);
    for round in 0..6_000 {
        let [a, b] = [0, round % 3].map(|size| &trees[size][random.bits() as usize % 4]);
        let size = a.unit_length() + b.unit_length();
        let angle = [0.064, 0.02, 1e-4][round / 3 % 3];
        let time = random.fraction();
        let triangles = [a, b].map(|tree| random.bits() as u32 % tree.mesh().len() as u32);
        let corners = |tree: &Tree, i: u32| tree.mesh().triangle(tree.ids()[i as usize] as usize);
        let [of_a, of_b] = [corners(a, triangles[0]), corners(b, triangles[1])];
        let middle = |[p, q, r]: [DVec3; 3]| (p + q + r) / 3.0;
        let normal = |[p, q, r]: [DVec3; 3]| (q - p).cross(r - p).normalize();
        let kind = random.bits() % 3;
        let mut vector =
            |size: f64| DVec3::from_array([(); 3].map(|()| random.between(-size, size)));
        let start = DMat3::from_axis_angle(vector(1.0).normalize(), vector(3.0).x);
        let across = |normal: DVec3, axis: DVec3| axis.cross(normal).normalize();
        let axis = match kind {
            0 => vector(1.0).normalize(),
            1 => across(normal(of_a), vector(1.0)),
            _ => across(start * normal(of_b), vector(1.0)),
        };
        let turned = DMat3::from_axis_angle(axis, angle * time);
        let (at, of_b, from_axis) = match kind {
            0 => (of_a[0], of_b[0], vector(size)),
            1 => (middle(of_a), of_b[0], normal(of_a) * vector(size).x),
            _ => (
                of_a[0],
                middle(of_b),
                turned * start * normal(of_b) * vector(size).x,
            ),
        };
        // The last kinds move like a pendulum, lowest where it meets the other triangle, or like a
        // wheel, which rolls there.
        let velocity = axis.cross(from_axis) * (-angle * [0.0, 0.4, 1.0][round / 9 % 3]);
        let arm = turned.transpose() * from_axis - start * of_b;
        let place = at - from_axis - velocity * time + arm;
        let motion =
            Motion::with_arm(Pose::unchecked(start, place), velocity, axis * angle, arm).unwrap();
        let relative_motion = RelativeMotion::new(a, b, None, &motion);
        let substep = relative_motion.substep(0);
        if relative_motion.substeps != 1 || !substep.is_on_the_spot {
            continue;
        }
        let until = random.between(time, 1.0);
        let relative = RelativePose::new(a, b, &substep.pose);
        let setting = Setting {
            trees: [a, b],
            relative_motion: &relative_motion,
            substep: &substep,
            relative: &relative,
            margin: 0.0,
        };
        let mut span = Span::new(&setting, until).unwrap();
        for instructions in [Instructions::detect(), Instructions::PORTABLE] {
            let meeting = Meeting {
                trees: [a, b],
                relative: &relative,
                span: &span,
                triangles,
                time: substep.local(time),
            };
            assert!(
                instructions.run(&meeting),
                "round {round}: they meet at {time}"
            );
        }
        check_triangles([a, b], &relative_motion, &substep, triangles, time);
        met += 1;
        (span.turn, span.arc_error) = (0.0, 0.0);
        let straight = Meeting {
            trees: [a, b],
            relative: &relative,
            span: &span,
            triangles,
            time: substep.local(time),
        };
        lost_without += usize::from(!Instructions::PORTABLE.run(&straight));
    }
    assert!(
        met > 3_000 && lost_without > met / 100,
        "{lost_without} of {met} would be lost if ways were straight"
    );
}
