//! Generated meshes for examples, tests and benchmarks.
//!
//! All but [`height_field`] are closed: every edge belongs to two triangles that traverse it in
//! opposite directions, and triangles are counter-clockwise seen from outside. Equal arguments give
//! equal meshes.
//!
//! No argument panics. An argument out of range, NaN included, is moved into range. No triangle is
//! degenerate.

use alloc::{collections::BTreeMap, vec::Vec};
use core::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Mesh, Vertices};
use punctual_geom::random::Random;

/// Between these lengths, areas and volumes are normal numbers in f32 too.
const MIN_SIZE: f64 = 1e-6;
const MAX_SIZE: f64 = 1e6;

/// A sphere of radius 1 around the origin: an icosahedron whose triangles are split in four,
/// `subdivisions` times. Has `20 * 4^subdivisions` triangles; `subdivisions` is at most 12.
pub fn icosphere(subdivisions: u32) -> Mesh {
    const GOLDEN: f64 = 1.618_033_988_749_895;
    let mut vertices = Vec::new();
    for (a, b) in [
        (1.0, GOLDEN),
        (-1.0, GOLDEN),
        (1.0, -GOLDEN),
        (-1.0, -GOLDEN),
    ] {
        let corners = [
            DVec3::new(0.0, a, b),
            DVec3::new(b, 0.0, a),
            DVec3::new(a, b, 0.0),
        ];
        vertices.extend(corners.map(DVec3::normalize));
    }
    let mut triangles = ICOSAHEDRON.to_vec();
    for _ in 0..subdivisions.min(12) {
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        let split = |[a, b, c]: [u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    generated(vertices, triangles)
}

/// All triples of corners at mutual distance 2, facing outward; corners are in the order of
/// [`icosphere`].
#[rustfmt::skip]
const ICOSAHEDRON: [[u32; 3]; 20] = [
    [0, 1, 2], [0, 3, 1], [0, 2, 5], [0, 7, 3], [0, 5, 7],
    [1, 4, 2], [1, 3, 8], [1, 8, 4], [2, 4, 6], [2, 6, 5],
    [3, 7, 11], [3, 11, 8], [4, 9, 6], [4, 8, 9], [5, 6, 10],
    [5, 10, 7], [6, 9, 10], [7, 10, 11], [8, 11, 9], [9, 11, 10],
];

/// A box around the origin; each face is a grid of `cells` by `cells` squares. Has `12 * cells^2`
/// triangles; `cells` is 1 to 8192, each half extent (along x, y, z) 1e-6 to 1e6.
pub fn cuboid(half_extents: impl Into<[f32; 3]>, cells: u32) -> Mesh {
    let cells = cells.clamp(1, 8192);
    let half = DVec3::from_array(half_extents.into().map(|h| within(h, MIN_SIZE, MAX_SIZE)));
    let (mut vertices, mut triangles, mut ids) = (Vec::new(), Vec::new(), BTreeMap::new());
    let mut vertex = |lattice: [u32; 3]| {
        *ids.entry(lattice).or_insert_with(|| {
            let unit = lattice.map(|k| 2.0 * f64::from(k) / f64::from(cells) - 1.0);
            vertices.push(half * DVec3::from_array(unit));
            vertices.len() as u32 - 1
        })
    };
    for face in 0..6 {
        let (axis, far) = (face / 2, face % 2);
        // Swapping the two directions of the face flips its triangles.
        let (u, v) = ((axis + 2 - far) % 3, (axis + 1 + far) % 3);
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let quad = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                let mut lattice = [far as u32 * cells; 3];
                (lattice[u], lattice[v]) = (i + di, j + dj);
                vertex(lattice)
            });
            triangles.extend(halves(quad));
        }
    }
    generated(vertices, triangles)
}

/// A torus around the z axis: a tube of radius `minor` along a circle of radius `major`.
///
/// With `resolution` segments along the circle and `resolution / 2` around the tube, each at least
/// 3, it has `2 * resolution * max(3, resolution / 2)` triangles. `resolution` is 3 to 16384,
/// `major` 1e-6 to 1e6, `minor` 0.01 to 0.99 times `major`.
pub fn torus(major: f32, minor: f32, resolution: u32) -> Mesh {
    let major = within(major, MIN_SIZE, MAX_SIZE);
    let minor = within(minor, 0.01 * major, 0.99 * major);
    let resolution = resolution.clamp(3, 16384);
    let sides = (resolution / 2).max(3);
    closed_grid(resolution, sides, |i, j| {
        let (along, around) = (turn(i, resolution), turn(j, sides));
        let out = along * (major + minor * around.x);
        out.extend(minor * around.y)
    })
}

/// A tube along a knot that winds `p` times around the z axis while it winds `q` times around the
/// tube of a torus.
///
/// The knot lies on the torus of radii 2/3 and 1/3. Its tube has radius `tube`, 0.01 to 0.3, and
/// intersects itself where strands are closer than its diameter. `p` and `q` are 1 to 64; a common
/// divisor is divided out. With `resolution` segments along the knot and `resolution / 8` around
/// the tube, at least 3, it has `2 * resolution * max(3, resolution / 8)` triangles. `resolution`
/// is `8 * (p + q)` to 16384.
pub fn torus_knot(p: u32, q: u32, tube: f32, resolution: u32) -> Mesh {
    let (p, q) = (p.clamp(1, 64), q.clamp(1, 64));
    let divisor = (1..=p)
        .rev()
        .find(|d| p % d == 0 && q % d == 0)
        .unwrap_or(1);
    let (p, q) = (p / divisor, q / divisor);
    let tube = within(tube, 0.01, 0.3);
    let resolution = resolution.clamp(8 * (p + q), 16384);
    let sides = (resolution / 8).max(3);
    closed_grid(resolution, sides, |i, j| {
        let (long, short) = (turn(i * p, resolution), turn(i * q, resolution));
        let around = turn(j, sides);
        // The frame comes from the torus on which the knot lies, so no twist accumulates and the
        // ends meet.
        let normal = (long * short.x).extend(short.y);
        let along_p = long.perp().extend(0.0);
        let along_q = (long * -short.y).extend(short.x);
        let center = (long * 2.0).extend(0.0) / 3.0 + normal / 3.0;
        let (speed_p, speed_q) = (f64::from(p) * (2.0 + short.x), f64::from(q));
        let sideways = (along_q * speed_p - along_p * speed_q).normalize();
        center + (normal * around.x + sideways * around.y) * tube
    })
}

/// A spur gear around the z axis: outer radius 1, thickness 0.3, bore radius 0.3, teeth with
/// straight flanks.
///
/// The profile of a tooth has four straight pieces (root, flank, tip, flank). The cross section of
/// the ring has four sides (rim, top, bore, bottom). Each piece and each side has `resolution`
/// segments: `32 * teeth * resolution^2` triangles. `teeth` is 3 to 4096, `resolution` 1 to 64.
pub fn gear(teeth: u32, resolution: u32) -> Mesh {
    const THICKNESS: f64 = 0.3;
    const BORE: f64 = 0.3;
    let (teeth, resolution) = (teeth.clamp(3, 4096), resolution.clamp(1, 64));
    let root = gear_root(teeth);
    let corner = |k: u32| {
        let fraction = [0.0, 0.3, 0.5, 0.8][k as usize % 4] + f64::from(k / 4);
        let radius = if k % 4 < 2 { root } else { 1.0 };
        DVec2::from_angle(TAU * fraction / f64::from(teeth)) * radius
    };
    let fraction = |k: u32| f64::from(k % resolution) / f64::from(resolution);
    closed_grid(4 * teeth * resolution, 4 * resolution, |i, j| {
        let piece = i / resolution;
        let rim = corner(piece).lerp(corner((piece + 1) % (4 * teeth)), fraction(i));
        let bore = rim.normalize() * BORE;
        let (side, s) = (j / resolution, fraction(j));
        let (point, height) = match side {
            0 => (rim, s - 0.5),
            1 => (rim.lerp(bore, s), 0.5),
            2 => (bore, 0.5 - s),
            _ => (bore.lerp(rim, s), -0.5),
        };
        point.extend(height * THICKNESS)
    })
}

/// Root radius of a gear with the usual tooth depth of 2.25 modules, at least 0.5 to stay clear of
/// the bore.
fn gear_root(teeth: u32) -> f64 {
    let module = 2.0 / f64::from(teeth + 2);
    (1.0 - 2.25 * module).max(0.5)
}

/// Smooth hills over the square from -1 to 1 in x and y, facing +z; heights are within -0.5 and
/// 0.5.
///
/// An open surface of `2 * resolution^2` triangles; `resolution` is 1 to 16384. Each `seed` gives
/// its own hills.
pub fn height_field(resolution: u32, seed: u64) -> Mesh {
    const WAVES: u64 = 8;
    let resolution = resolution.clamp(1, 16384);
    let mut random = Random::new(seed);
    let waves: Vec<_> = (0..WAVES)
        .map(|k| {
            let direction = DVec2::from_angle(random.fraction() * TAU);
            (direction * (k + 1) as f64, random.fraction() * TAU)
        })
        .collect();
    let coordinate = |i: u32| 2.0 * f64::from(i) / f64::from(resolution) - 1.0;
    let corners = (0..=resolution).flat_map(|i| (0..=resolution).map(move |j| (i, j)));
    let vertices = corners.map(|(i, j)| {
        let point = DVec2::new(coordinate(i), coordinate(j));
        let wave = |(k, phase): &(DVec2, f64)| DVec2::from_angle(k.dot(point) + phase).y;
        let height: f64 = waves.iter().map(wave).sum();
        point.extend(height * 0.5 / WAVES as f64)
    });
    let row = resolution + 1;
    let cells = (0..resolution).flat_map(|i| (0..resolution).map(move |j| i * row + j));
    let triangles = cells.flat_map(|c| halves([c, c + row, c + row + 1, c + 1]));
    generated(vertices, triangles)
}

/// A grid of `columns` by `rows` cells closed in both directions, like the surface of a torus.
fn closed_grid(columns: u32, rows: u32, point: impl Fn(u32, u32) -> DVec3) -> Mesh {
    let grid = || (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
    let vertices = grid().map(|(i, j)| point(i, j));
    let id = |i: u32, j: u32| (i % columns) * rows + j % rows;
    let triangles =
        grid().flat_map(|(i, j)| halves([id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]));
    generated(vertices, triangles)
}

fn halves([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

fn generated(
    vertices: impl IntoIterator<Item = DVec3>,
    triangles: impl IntoIterator<Item = [u32; 3]>,
) -> Mesh {
    let vertices = vertices
        .into_iter()
        .map(|v| v.as_vec3().to_array())
        .collect();
    Mesh::trusted(Vertices::F32(vertices), triangles.into_iter().collect())
}

/// The unit vector after `k` of `n` equal steps around the circle.
fn turn(k: u32, n: u32) -> DVec2 {
    DVec2::from_angle(TAU * f64::from(k % n) / f64::from(n))
}

/// Clamps `value` to the range; NaN becomes `min`, unlike with `clamp`.
fn within(value: f32, min: f64, max: f64) -> f64 {
    f64::from(value).max(min).min(max)
}
