//! For every direction, the few corners of a mesh that may be the farthest along it.
//!
//! A grid of cells on a cube sorts the directions: each direction leaves the cube through one cell.
//! A corner is left out of a cell if another corner reaches at least as far along the four
//! directions to the corners of the cell. Then it reaches at least as far along all directions of
//! the cell, because they lie between these four. `docs/numerics.md`, "A plane between two
//! surfaces", derives the effect of rounding.

use crate::mesh::Mesh;
use crate::tree::unit::Unit;
use alloc::boxed::Box;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use punctual_geom::bits;
use punctual_geom::lanes::{Column, F8, Lanes, dot, greatest, per_axis};
use wide::f32x4;

/// Number of cells along each side of a cube face: a power of two.
const SIDE: usize = 4;
const CELLS: usize = 6 * SIDE * SIDE;

/// The corners of the mesh that each cell keeps, in blocks of eight.
#[derive(Clone, Debug, Default)]
pub(crate) struct Extremes {
    /// Index of the first block of each cell, then the number of blocks.
    first: Box<[u32]>,
    blocks: Box<[Block]>,
}

/// A point in unit coordinates.
type Point = [f32; 3];

/// Eight corners in unit coordinates, by component. If there are fewer, the last one fills the
/// rest.
type Block = [[f32; 8]; 3];

impl Extremes {
    /// Extremes of the vertices of triangles. Empty if a cell has so many corners that a look-up
    /// would take long. `O(n)`.
    pub fn of(mesh: &Mesh, unit: &Unit, corners: &[[u32; 3]]) -> Self {
        let mut is_used = alloc::vec![false; mesh.vertex_count()];
        corners
            .iter()
            .flatten()
            .for_each(|&vertex| is_used[vertex as usize] = true);
        let used = is_used.iter().zip(0..).filter(|(is_used, _)| **is_used);
        Self::new(
            &used
                .map(|(_, vertex)| unit.point(mesh.vertex(vertex)).as_vec3().to_array())
                .collect::<Vec<_>>(),
        )
    }

    fn new(points: &[Point]) -> Self {
        if points.is_empty() {
            return Self::default();
        }
        let mut cells = [const { Vec::new() }; CELLS];
        (0..6).for_each(|face| {
            Part {
                face,
                low: [0; 2],
                side: SIDE,
            }
            .fill(points, &mut cells)
        });
        if cells.iter().any(|cell| cell.len() > MANY) {
            return Self::default();
        }
        let (mut first, mut blocks) = (Vec::with_capacity(CELLS + 1), Vec::new());
        for cell in &cells {
            first.push(blocks.len() as u32);
            blocks.extend(cell.chunks(8).map(|points| -> Block {
                per_axis!(k => core::array::from_fn(|i| points[i.min(points.len() - 1)][k]))
            }));
        }
        first.push(blocks.len() as u32);
        Self {
            first: first.into(),
            blocks: blocks.into(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.first) + size_of_val(&*self.blocks)
    }

    /// The largest dot product of `direction` and a corner of the mesh, and a corner that has it.
    /// The extremes must not be empty.
    #[inline(always)]
    pub fn farthest<L: Lanes>(&self, lanes: L, direction: [f32; 3]) -> (f32, Point) {
        let cell = cell(direction);
        let blocks = &self.blocks[self.first[cell] as usize..self.first[cell + 1] as usize];
        let along = per_axis!(k => F8::splat(lanes, direction[k]));
        let mut best = F8::splat(lanes, f32::NEG_INFINITY);
        let mut which = F8::splat(lanes, 0.0);
        for (number, block) in blocks.iter().enumerate() {
            let reach = dot(along, per_axis!(k => F8::load(lanes, &block[k])));
            which = best
                .less(reach)
                .select(F8::splat(lanes, number as f32), which);
            best = best.max(reach);
        }
        let [reach, ..] = greatest([best; 3]);
        let lane = best.less(F8::splat(lanes, reach)).mask().trailing_ones() as usize % 8;
        (
            reach,
            blocks[which.store()[lane] as usize].map(|component| component[lane]),
        )
    }
}

#[inline(always)]
fn cell(direction: [f32; 3]) -> usize {
    let [x, y, z] = direction.map(f32::abs);
    let axis = if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    };
    let face = 2 * axis + usize::from(direction[axis] < 0.0);
    let per = 1.0 / direction[axis].abs();
    let at =
        |k: usize| (((direction[k % 3] * per + 1.0) * (SIDE as f32 / 2.0)) as usize).min(SIDE - 1);
    (face * SIDE + at(axis + 1)) * SIDE + at(axis + 2)
}

/// A square of cells on a face of the cube.
#[derive(Clone, Copy)]
struct Part {
    face: usize,
    low: [usize; 2],
    side: usize,
}

impl Part {
    /// Selects the points for the cells of this square.
    fn fill(self, points: &[Point], cells: &mut [Vec<Point>; CELLS]) {
        let Self {
            face,
            low: [u, v],
            side,
        } = self;
        let kept = self.maximal(points);
        let half = side / 2;
        if half == 0 {
            cells[(face * SIDE + u) * SIDE + v] = kept;
            return;
        }
        for low in [[u, v], [u, v + half], [u + half, v], [u + half, v + half]] {
            Self {
                low,
                side: half,
                ..self
            }
            .fill(&kept, cells);
        }
    }

    /// Directions to the corners of the square, to the middles of its sides and to its center, in
    /// rows of three. Their largest component is 1.
    fn directions(self) -> [[[f32; 3]; 3]; 3] {
        let axis = self.face / 2;
        let at = |low: usize, i: usize| (2 * low + i * self.side) as f32 / SIDE as f32 - 1.0;
        core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let mut direction = [if self.face.is_multiple_of(2) {
                    1.0
                } else {
                    -1.0
                }; 3];
                direction[(axis + 1) % 3] = at(self.low[0], i);
                direction[(axis + 2) % 3] = at(self.low[1], j);
                direction
            })
        })
    }

    /// Keeps the farthest points along these nine directions. Keeps every other point too, unless
    /// one of the farthest reaches at least as far along the directions to all four corners of the
    /// square. For a single cell, few more points than necessary remain.
    fn maximal(self, points: &[Point]) -> Vec<Point> {
        let [[a, ab, b], [ac, middle, bd], [c, cd, d]] = self.directions();
        let edges = columns([a, b, c, d]);
        let all = [columns([middle; 4]), edges, columns([ab, ac, bd, cd])];
        let (mut best, mut farthest) = ([f32x4::splat(f32::NEG_INFINITY); 3], [[0; 4]; 3]);
        for (point, number) in points.iter().zip(0..) {
            for k in 0..3 {
                let along = reach(&all[k], point);
                let better = along.simd_gt(best[k]).to_bitmask();
                if better != 0 {
                    best[k] = best[k].fast_max(along);
                    bits(better).for_each(|i| farthest[k][i] = number);
                }
            }
        }
        let mut rivals = ArrayVec::<usize, 12>::new();
        for number in farthest.into_iter().flatten() {
            if !rivals.contains(&number) {
                rivals.push(number);
            }
        }
        let mut kept: Vec<Point> = rivals.iter().map(|&rival| points[rival]).collect();
        let rivals: ArrayVec<f32x4, 12> = kept.iter().map(|rival| reach(&edges, rival)).collect();
        // The rivals are kept already. This drops them, because each reaches as far as itself.
        kept.extend(points.iter().filter(|point| {
            let along = reach(&edges, point);
            !rivals.iter().any(|farther| farther.simd_ge(along).all())
        }));
        if self.side == 1 && kept.len() > FEW {
            kept = thinned(kept, &edges);
        }
        kept
    }
}

/// A cell with more corners than `FEW` is thinned: each corner is compared with at most `MANY`
/// others. If a cell then keeps more than `MANY`, the tree keeps no extremes at all.
const FEW: usize = 16;
const MANY: usize = 1024;

/// Drops each point for which one of the first `MANY` kept points reaches at least as far along all
/// four directions.
fn thinned(points: Vec<Point>, directions: &[f32x4; 3]) -> Vec<Point> {
    let mut all: Vec<_> = points
        .into_iter()
        .map(|point| (reach(directions, &point), point))
        .collect();
    all.sort_by(|(x, _), (y, _)| y.reduce_add().total_cmp(&x.reduce_add()));
    let mut kept: Vec<(f32x4, Point)> = Vec::new();
    for (along, point) in all {
        if !kept
            .iter()
            .take(MANY)
            .any(|(farther, _)| farther.simd_ge(along).all())
        {
            kept.push((along, point));
        }
    }
    kept.into_iter().map(|(_, point)| point).collect()
}

/// Four directions by component.
fn columns(four: [[f32; 3]; 4]) -> [f32x4; 3] {
    per_axis!(k => f32x4::new(four.map(|direction| direction[k])))
}

/// Dot products of a point and four directions.
#[inline(always)]
fn reach(directions: &[f32x4; 3], point: &Point) -> f32x4 {
    dot(*directions, per_axis!(k => f32x4::splat(point[k])))
}

#[cfg(test)]
mod tests {
    use crate::mesh::{Mesh, shapes};
    use crate::tree::{BuildOptions, Tree};
    use alloc::vec::Vec;
    use glam::Vec3;
    use punctual_geom::lanes::Portable;
    use punctual_geom::random::Random;
    use punctual_geom::tolerance::ROUNDING;

    /// Directions anywhere, on the grid, and next to it. Their largest component is 1.
    fn directions(random: &mut Random) -> Vec<[f32; 3]> {
        let mut all: Vec<[f32; 3]> = (0..2000)
            .map(|_| core::array::from_fn(|_| random.between(-1.0, 1.0) as f32))
            .collect();
        for i in 0..9 * 9 * 9 {
            let on_grid = [i % 9, i / 9 % 9, i / 81].map(|k| k as f32 / 4.0 - 1.0);
            all.extend(
                [1.0, 1.0 + f32::EPSILON, 1.0 - f32::EPSILON]
                    .map(|by| [on_grid[0], on_grid[1] * by, on_grid[2]]),
            );
        }
        all.retain(|direction| *direction != [0.0; 3]);
        all.iter()
            .map(|&direction| {
                (Vec3::from(direction) / Vec3::from(direction).abs().max_element()).to_array()
            })
            .collect()
    }

    /// A disk with all vertices on its rim, so that many of them may be the farthest along
    /// directions near its axis.
    fn disk(vertices: u32) -> Mesh {
        let rim = (0..vertices).map(|i| {
            let angle = core::f32::consts::TAU * i as f32 / vertices as f32;
            [libm::cosf(angle), libm::sinf(angle), 0.0]
        });
        Mesh::new(rim, (1..vertices - 1).map(|i| [0, i, i + 1])).unwrap()
    }

    #[test]
    fn no_vertex_is_farther_along_any_direction_than_is_kept() {
        let random = &mut Random::new(7);
        let mut points = || core::array::from_fn(|_| random.between(-1.0, 1.0) as f32);
        let cloud: Vec<[f32; 3]> = (0..3000).map(|_| points()).collect();
        let soup = |triangles: u32| {
            let vertices = cloud.iter().copied().take(3 * triangles as usize);
            Mesh::new(
                vertices,
                (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]),
            )
            .unwrap()
        };
        let point = Mesh::new([[3.0f32, 2.0, 1.0]], [[0; 3]]).unwrap();
        let shapes = [
            shapes::icosphere(4),
            shapes::torus_knot(2, 3, 0.2, 48),
            shapes::cuboid([1.0, 0.2, 0.5], 3),
        ];
        let meshes = shapes
            .into_iter()
            .chain([soup(1000), soup(1), disk(1000), point]);
        let mut directions = directions(&mut Random::new(8));
        for mesh in meshes {
            let tree = Tree::with_options(mesh, &BuildOptions::default().extremes(true));
            let (mesh, extremes) = (tree.mesh(), tree.extremes());
            let points: Vec<_> = (0..mesh.vertex_count())
                .map(|i| tree.unit().point(mesh.vertex(i)))
                .collect();
            for &direction in &directions {
                let along = |point: glam::DVec3| Vec3::from(direction).as_dvec3().dot(point);
                let truth = points
                    .iter()
                    .map(|&point| along(point))
                    .fold(f64::NEG_INFINITY, f64::max);
                let (reach, corner) = extremes.farthest(Portable {}, direction);
                let off = [f64::from(reach), along(Vec3::from(corner).as_dvec3())]
                    .map(|found| (found - truth).abs());
                assert!(
                    off.iter().all(|&off| off <= f64::from(96.0 * ROUNDING)),
                    "{direction:?} {off:?}"
                );
            }
            let kept = extremes.blocks.len() * 8;
            assert!(kept <= 96 * (mesh.vertex_count() + 7) && extremes.first.len() == 97);
            directions.rotate_left(1);
        }
    }

    /// Small meshes have one block in each cell. In large round meshes, few corners are in several
    /// cells.
    #[test]
    fn few_corners_are_kept() {
        for (subdivisions, most) in [(1, 96), (3, 300), (5, 2000)] {
            let tree = Tree::with_options(
                shapes::icosphere(subdivisions),
                &BuildOptions::default().extremes(true),
            );
            let blocks = tree.extremes().blocks.len();
            assert!((96..=most).contains(&blocks), "{blocks}");
        }
        assert!(
            Tree::with_options(disk(10_000), &BuildOptions::default().extremes(true))
                .extremes()
                .is_empty()
        );
    }
}
