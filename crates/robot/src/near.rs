//! The first filter: which pairs of shapes may be near each other, eight moving shapes at a time.
//!
//! Shapes that stand still are grouped by sixteen. They are tested only against the moving shapes
//! that are near the box of their group.

use punctual::glam::{DMat3, DVec3};
use punctual_geom::lanes::{Column, F8, Instructions, Kernel, Lanes};

use crate::placement::StillBox;
use crate::world::{LANES, Pair, World};

/// The slack, relative to the size of what is placed. With `u = 2^-24`, a point in the frame of a
/// box is off by at most 21 u per axis, the part of it beyond the box by 24 u per axis, and the
/// length of that part by 49 u. The sum of radii and margins, each of that size at most, is off by
/// at most 13 u.
const SLACK: f64 = 64.0 / (1u32 << 24) as f64;

/// Below this size, in metres, squares in f32 would underflow, so every pair counts as near.
const SMALLEST: f64 = 1e-10;

/// Shapes that stand still in a group.
const GROUP: usize = 16;

/// The first shape of a pair, in the form that the filter needs.
#[derive(Clone, Copy, Debug)]
enum First {
    /// A box that stands still: the rows of the rotation into its frame, its centre and half
    /// extents.
    Box([[f32; 3]; 5]),
    /// A sphere that moves: its column.
    Sphere(usize),
}

impl From<StillBox> for First {
    fn from((back, centre, half): StillBox) -> Self {
        let [x, y, z] = back.as_mat3().transpose().to_cols_array_2d();
        Self::Box([x, y, z, centre.as_vec3().into(), half.as_vec3().into()])
    }
}

/// The pairs of one first shape, or of a group of them.
#[derive(Clone, Copy, Debug)]
struct Row {
    first: First,
    shape: u32,
    /// The most by which the margin of a pair exceeds the margins in the lanes.
    margin: f32,
}

impl Row {
    fn new(world: &World, pair: &Pair, still: Option<StillBox>) -> Self {
        let sphere = || First::Sphere(world.column(pair.a));
        Self {
            first: still.map_or_else(sphere, First::from),
            shape: pair.a,
            margin: Self::margin(world, pair, still.is_some()),
        }
    }

    fn margin(world: &World, pair: &Pair, is_still: bool) -> f32 {
        let in_lanes = |shape: u32| world.shapes[shape as usize].margins.iter().sum::<f64>();
        let of_first = if is_still { 0.0 } else { in_lanes(pair.a) };
        (pair.margin - in_lanes(pair.b) - of_first) as f32
    }
}

/// Finds the pairs that may be near.
#[derive(Debug, Default)]
pub(crate) struct Near {
    /// `None` before there is a world.
    instructions: Option<Instructions>,
    /// Spheres of the moving shapes, in lanes: x, y, z and radius.
    spheres: Vec<[[f32; LANES]; 4]>,
    moving: Vec<Row>,
    /// Those that stand still, and boxes of each [`GROUP`] of them.
    still: Vec<Row>,
    groups: Vec<Row>,
    /// Room for the row of each shape.
    rows: Vec<Option<Row>>,
}

impl Near {
    /// Takes over the pairs of the world; `still` gives the boxes of shapes that stand still.
    pub fn sync(&mut self, world: &World, still: impl Fn(u32) -> Option<StillBox>) {
        self.instructions.get_or_insert_with(Instructions::detect);
        self.spheres
            .resize(world.stride() / LANES, [[0.0; LANES]; 4]);
        self.rows.resize(world.shapes.len(), None);
        for pair in &world.pairs {
            match &mut self.rows[pair.a as usize] {
                Some(row) => {
                    let is_still = matches!(row.first, First::Box(_));
                    row.margin = row.margin.max(Row::margin(world, pair, is_still));
                }
                row => *row = Some(Row::new(world, pair, still(pair.a))),
            }
        }
        self.still.clear();
        self.moving.clear();
        for row in self.rows.drain(..).flatten() {
            let rows = match row.first {
                First::Box(_) => &mut self.still,
                First::Sphere(_) => &mut self.moving,
            };
            rows.push(row);
        }
        gather(&mut self.still);
        self.groups.clear();
        for group in 0..self.still.len().div_ceil(GROUP) {
            self.regroup(group, &still);
        }
    }

    /// Takes over a shape that was moved, or one that stands still and was added behind the others.
    pub fn update(&mut self, world: &World, shape: u32, still: impl Fn(u32) -> Option<StillBox>) {
        let Some(first) = still(shape).map(First::from) else {
            return;
        };
        let at = self.still.iter().position(|row| row.shape == shape);
        if let Some(at) = at {
            self.still[at].first = first;
        } else {
            let new = world.pairs.iter().rev().take_while(|pair| pair.a == shape);
            let new = new.map(|pair| Row::new(world, pair, still(shape)));
            let Some(row) = new.max_by(|x, y| x.margin.total_cmp(&y.margin)) else {
                return;
            };
            self.still.push(row);
        }
        self.regroup(at.unwrap_or(self.still.len() - 1) / GROUP, still);
    }

    /// Bounds a group, which may be new.
    fn regroup(&mut self, group: usize, still: impl Fn(u32) -> Option<StillBox>) {
        let rows = self.still.chunks(GROUP).nth(group).unwrap_or_default();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (back, centre, half) in rows.iter().filter_map(|row| still(row.shape)) {
            let axes = [back.x_axis, back.y_axis, back.z_axis];
            let half = DVec3::from_array(axes.map(|axis| axis.abs().dot(half)));
            (low, high) = (low.min(centre - half), high.max(centre + half));
        }
        let row = Row {
            first: First::from((DMat3::IDENTITY, (low + high) / 2.0, (high - low) / 2.0)),
            shape: u32::MAX,
            margin: rows.iter().map(|row| row.margin).fold(0.0, f32::max),
        };
        self.groups.resize(self.groups.len().max(group + 1), row);
        self.groups[group] = row;
    }

    /// Places the sphere of a moving shape, thickened by its margins.
    #[inline]
    pub fn put(&mut self, column: usize, sphere: [f64; 4]) {
        let lanes = &mut self.spheres[column / LANES];
        for (lanes, value) in lanes.iter_mut().zip(sphere) {
            lanes[column % LANES] = value as f32;
        }
    }

    /// Sets the bits of pairs that are not proven apart. `ranks` has the bit of the pair of each
    /// slot. `size` bounds the coordinates, radii and margins of what is placed.
    pub fn list(&self, size: f64, ranks: &[u32], found: &mut [u64]) {
        let list = List {
            near: self,
            ranks,
            found,
            slack: (SLACK * size) as f32,
        };
        match self.instructions {
            Some(instructions) if size >= SMALLEST => instructions.run(list),
            _ => {
                for &rank in ranks.iter().filter(|&&rank| rank != u32::MAX) {
                    found[rank as usize / 64] |= 1 << (rank % 64);
                }
            }
        }
    }
}

/// Orders boxes so that neighbours are near each other and alike in size, by halves.
fn gather(rows: &mut [Row]) {
    if rows.len() <= GROUP {
        return;
    }
    let key = |row: &Row, axis: usize| match row.first {
        First::Box([.., centre, half]) => {
            let [x, y, z] = centre;
            [x, y, z, half[0].max(half[1]).max(half[2])][axis]
        }
        First::Sphere(_) => 0.0,
    };
    let spread = |axis: &usize| {
        let keys = || rows.iter().map(|row| key(row, *axis));
        keys().fold(f32::NEG_INFINITY, f32::max) - keys().fold(f32::INFINITY, f32::min)
    };
    let widest = (0..4).max_by(|x, y| spread(x).total_cmp(&spread(y)));
    let (axis, middle) = (
        widest.unwrap_or(0),
        (rows.len() / 2).next_multiple_of(GROUP),
    );
    if middle < rows.len() {
        rows.select_nth_unstable_by(middle, |x, y| key(x, axis).total_cmp(&key(y, axis)));
        let (low, high) = rows.split_at_mut(middle);
        gather(low);
        gather(high);
    }
}

struct List<'l> {
    near: &'l Near,
    ranks: &'l [u32],
    found: &'l mut [u64],
    slack: f32,
}

impl List<'_> {
    /// A bit for each moving shape of a chunk that may be near a box or sphere.
    #[inline(always)]
    fn test<L: Lanes>(&self, lanes: L, row: &Row, chunk: usize) -> u32 {
        let splat = |x| F8::splat(lanes, x);
        let (zero, slack) = (splat(0.0), splat(self.slack + row.margin));
        let spheres = &self.near.spheres;
        let [x, y, z, r] = spheres[chunk].each_ref().map(|row| F8::load(lanes, row));
        let (squared, reach) = match row.first {
            First::Box([u, v, w, c, h]) => {
                let (x, y, z) = (x - splat(c[0]), y - splat(c[1]), z - splat(c[2]));
                let u = splat(u[0]) * x + splat(u[1]) * y + splat(u[2]) * z;
                let v = splat(v[0]) * x + splat(v[1]) * y + splat(v[2]) * z;
                let w = splat(w[0]) * x + splat(w[1]) * y + splat(w[2]) * z;
                let u = (u.abs() - splat(h[0])).max(zero);
                let v = (v.abs() - splat(h[1])).max(zero);
                let w = (w.abs() - splat(h[2])).max(zero);
                (u * u + v * v + w * w, r + slack)
            }
            First::Sphere(column) => {
                let (at, lane) = (&spheres[column / LANES], column % LANES);
                let x = x - splat(at[0][lane]);
                let y = y - splat(at[1][lane]);
                let z = z - splat(at[2][lane]);
                let radii = r + splat(at[3][lane]);
                (x * x + y * y + z * z, radii + slack)
            }
        };
        // NaN counts as near.
        !(reach * reach).less(squared).mask() & 0xFF
    }

    /// Lists the pairs of a shape with the moving shapes of a chunk.
    #[inline(always)]
    fn list<L: Lanes>(&mut self, lanes: L, row: &Row, chunk: usize) {
        let mut bits = self.test(lanes, row, chunk);
        let first = (row.shape as usize * self.near.spheres.len() + chunk) * LANES;
        while bits != 0 {
            let rank = self.ranks[first + bits.trailing_zeros() as usize];
            if rank != u32::MAX {
                self.found[rank as usize / 64] |= 1 << (rank % 64);
            }
            bits &= bits - 1;
        }
    }
}

impl Kernel for List<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let (near, chunks) = (self.near, self.near.spheres.len());
        for row in &near.moving {
            // In a pair of moving shapes, the second comes after the first.
            let First::Sphere(column) = row.first else {
                continue;
            };
            for chunk in column / LANES..chunks {
                self.list(lanes, row, chunk);
            }
        }
        for (group, rows) in near.groups.iter().zip(near.still.chunks(GROUP)) {
            for chunk in 0..chunks {
                if self.test(lanes, group, chunk) != 0 {
                    for row in rows {
                        self.list(lanes, row, chunk);
                    }
                }
            }
        }
    }
}
