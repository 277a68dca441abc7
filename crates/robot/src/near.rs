//! The first filter: which pairs of shapes may be near each other, eight moving shapes at a time.

use punctual_geom::lanes::{Column, F8, Instructions, Kernel, Lanes};

use crate::placement::StillBox;
use crate::world::{LANES, World};

/// The slack, relative to the size of what is placed. With `u = 2^-24`, the point in the frame of a
/// box is off by at most 21 u per axis, what of it is beyond the box by 24 u, its length by 49 u.
const SLACK: f64 = 64.0 / (1u32 << 24) as f64;

/// In metres: below this size squares in f32 would underflow, and the filter tells nothing.
const SMALLEST: f64 = 1e-10;

/// The first shape of pairs: a box that stands still, or a sphere that moves.
#[derive(Clone, Copy, Debug)]
struct First {
    shape: u32,
    /// Column of a sphere that moves.
    moving: Option<usize>,
    /// The rows of the rotation into the frame of the box, its centre and half extents; those of a
    /// point for a sphere.
    still: [[f32; 3]; 5],
}

/// Tells of each pair whether it is near.
#[derive(Debug, Default)]
pub(crate) struct Near {
    /// `None` before there is a world.
    instructions: Option<Instructions>,
    /// Spheres of the moving shapes, in lanes: x, y, z and radius.
    spheres: Vec<[[f32; LANES]; 4]>,
    firsts: Vec<First>,
    /// For each shape that is the first of a pair a row of bits, one for each moving shape.
    bits: Vec<u8>,
    slack: f32,
}

impl Near {
    /// For the pairs of the world; `still` gives the boxes of shapes that stand still.
    pub fn new(world: &World, still: impl Fn(u32) -> Option<StillBox>) -> Self {
        let chunks = world.stride() / LANES;
        let mut firsts: Vec<u32> = world.pairs.iter().map(|pair| pair.a).collect();
        firsts.sort_unstable();
        firsts.dedup();
        let first = |shape: u32| {
            let still = still(shape);
            let moving = still.is_none().then(|| world.column(shape));
            let (back, centre, half) = still.unwrap_or_default();
            let [x, y, z] = back.as_mat3().transpose().to_cols_array_2d();
            let still = [x, y, z, centre.as_vec3().into(), half.as_vec3().into()];
            First {
                shape,
                moving,
                still,
            }
        };
        Self {
            instructions: Some(Instructions::detect()),
            spheres: vec![[[0.0; LANES]; 4]; chunks],
            firsts: firsts.into_iter().map(first).collect(),
            bits: vec![0; chunks * world.shapes.len()],
            slack: 0.0,
        }
    }

    /// Places the sphere of a moving shape.
    #[inline]
    pub fn put(&mut self, column: usize, sphere: [f64; 4]) {
        let lanes = &mut self.spheres[column / LANES];
        for (lanes, value) in lanes.iter_mut().zip(sphere) {
            lanes[column % LANES] = value as f32;
        }
    }

    /// Tests all pairs. `size` bounds the coordinates and radii of what is placed.
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
        let (slack, zero) = (splat(self.slack), splat(0.0));
        for first in &self.firsts {
            let row = first.shape as usize * self.spheres.len();
            let [u, v, w, mut c, h] = first.still;
            // A moving shape is the second of its pairs only with those before it.
            let (mut begin, mut radius) = (0, 0.0);
            if let Some(column) = first.moving {
                let [x, y, z, r] = self.spheres[column / LANES].map(|lanes| lanes[column % LANES]);
                (begin, c, radius) = (column / LANES, [x, y, z], r);
            }
            for chunk in begin..self.spheres.len() {
                let [x, y, z, r] = self.spheres[chunk].each_ref().map(|it| F8::load(lanes, it));
                let (x, y, z) = (x - splat(c[0]), y - splat(c[1]), z - splat(c[2]));
                let axes = [(u, h[0]), (v, h[1]), (w, h[2])];
                let squared = axes.map(|(axis, half)| {
                    let along = splat(axis[0]) * x + splat(axis[1]) * y + splat(axis[2]) * z;
                    let beyond = (along.abs() - splat(half)).max(zero);
                    beyond * beyond
                });
                let squared = squared[0] + squared[1] + squared[2];
                let reach = r + splat(radius) + slack;
                // Not a number counts as near.
                self.bits[row + chunk] = !(reach * reach).less(squared).mask() as u8;
            }
        }
    }
}
