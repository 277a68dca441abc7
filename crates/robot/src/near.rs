//! The first filter: which pairs of shapes may be near each other, eight moving shapes at a time.

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

/// The first shape of a pair, in the form that the filter needs.
#[derive(Clone, Copy, Debug)]
enum First {
    /// A box that stands still: the rows of the rotation into its frame, its centre and half
    /// extents.
    Box([[f32; 3]; 5]),
    /// A sphere that moves: its column.
    Sphere(usize),
}

impl First {
    fn new(world: &World, shape: u32, still: Option<StillBox>) -> Self {
        match still {
            Some((back, centre, half)) => {
                let [x, y, z] = back.as_mat3().transpose().to_cols_array_2d();
                Self::Box([x, y, z, centre.as_vec3().into(), half.as_vec3().into()])
            }
            None => Self::Sphere(world.column(shape)),
        }
    }
}

/// The pairs of one first shape.
#[derive(Clone, Copy, Debug)]
struct Row {
    shape: u32,
    first: First,
    /// The most by which the margin of a pair is more than what the lanes have of it.
    margin: f32,
}

impl Row {
    /// A shape that is the first of no pair.
    fn empty(shape: u32) -> Self {
        Self {
            shape,
            first: First::Sphere(0),
            margin: f32::NEG_INFINITY,
        }
    }

    fn new(world: &World, pair: &Pair) -> Self {
        let is_moving = world.shapes[pair.a as usize].body != 0;
        let in_lanes = |shape: u32| world.shapes[shape as usize].margins.iter().sum::<f64>();
        let of_first = if is_moving { in_lanes(pair.a) } else { 0.0 };
        Self {
            shape: pair.a,
            first: First::Sphere(0),
            margin: (pair.margin - in_lanes(pair.b) - of_first) as f32,
        }
    }
}

/// Tells of each pair whether it is near.
#[derive(Debug, Default)]
pub(crate) struct Near {
    /// `None` before there is a world.
    instructions: Option<Instructions>,
    /// Spheres of the moving shapes, in lanes: x, y, z and radius.
    spheres: Vec<[[f32; LANES]; 4]>,
    firsts: Vec<Row>,
    /// A row of bits for each shape, with one bit for each moving shape. It is used if the shape is
    /// the first of a pair.
    bits: Vec<u8>,
    slack: f32,
}

impl Near {
    /// Takes over the pairs of the world; `still` gives the boxes of shapes that stand still.
    pub fn sync(&mut self, world: &World, still: impl Fn(u32) -> Option<StillBox>) {
        self.instructions.get_or_insert_with(Instructions::detect);
        self.spheres
            .resize(world.stride() / LANES, [[0.0; LANES]; 4]);
        self.fit(world);
        self.firsts.clear();
        let rows = 0..world.shapes.len() as u32;
        self.firsts.extend(rows.map(Row::empty));
        for pair in &world.pairs {
            let margin = Row::new(world, pair).margin;
            let row = &mut self.firsts[pair.a as usize];
            row.margin = row.margin.max(margin);
        }
        self.firsts.retain(|row| row.margin != f32::NEG_INFINITY);
        for row in &mut self.firsts {
            row.first = First::new(world, row.shape, still(row.shape));
        }
    }

    /// Takes over a shape that was moved, or one that stands still and was added behind the others.
    pub fn update(&mut self, world: &World, shape: u32, still: Option<StillBox>) {
        self.fit(world);
        let first = First::new(world, shape, still);
        match self.firsts.binary_search_by_key(&shape, |row| row.shape) {
            Ok(at) => self.firsts[at].first = first,
            Err(at) => {
                let new = world.pairs.iter().rev().take_while(|pair| pair.a == shape);
                let new = new.map(|pair| Row::new(world, pair));
                if let Some(row) = new.max_by(|x, y| x.margin.total_cmp(&y.margin)) {
                    self.firsts.insert(at, Row { first, ..row });
                }
            }
        }
    }

    /// Makes room for a row of bits for each shape.
    fn fit(&mut self, world: &World) {
        let chunks = world.stride() / LANES;
        self.bits.resize(chunks * world.shapes.len(), 0);
    }

    /// Places the sphere of a moving shape, thickened by its margins.
    #[inline]
    pub fn put(&mut self, column: usize, sphere: [f64; 4]) {
        let lanes = &mut self.spheres[column / LANES];
        for (lanes, value) in lanes.iter_mut().zip(sphere) {
            lanes[column % LANES] = value as f32;
        }
    }

    /// Tests all pairs. `size` bounds the coordinates, radii and margins of what is placed.
    pub fn test(&mut self, size: f64) {
        if size < SMALLEST {
            return self.bits.fill(u8::MAX);
        }
        self.slack = (SLACK * size) as f32;
        if let Some(instructions) = self.instructions {
            instructions.run(self);
        }
    }

    /// False proves that the pair is apart.
    #[inline]
    pub fn is(&self, slot: u32) -> bool {
        self.bits[slot as usize / LANES] >> (slot as usize % LANES) & 1 > 0
    }
}

impl Kernel for &mut Near {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let splat = |x| F8::splat(lanes, x);
        let zero = splat(0.0);
        for &Row {
            shape,
            first,
            margin,
        } in &self.firsts
        {
            let slack = splat(self.slack + margin);
            let row = shape as usize * self.spheres.len();
            // In a pair of moving shapes, the second comes after the first.
            let begin = match first {
                First::Sphere(column) => column / LANES,
                First::Box(_) => 0,
            };
            for chunk in begin..self.spheres.len() {
                let spheres = &self.spheres[chunk];
                let [x, y, z, r] = spheres.each_ref().map(|row| F8::load(lanes, row));
                let (squared, reach) = match first {
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
                        let (at, lane) = (&self.spheres[column / LANES], column % LANES);
                        let x = x - splat(at[0][lane]);
                        let y = y - splat(at[1][lane]);
                        let z = z - splat(at[2][lane]);
                        let radii = r + splat(at[3][lane]);
                        (x * x + y * y + z * z, radii + slack)
                    }
                };
                // NaN counts as near.
                self.bits[row + chunk] = !(reach * reach).less(squared).mask() as u8;
            }
        }
    }
}
