//! Chooses the orientation in which single triangles have the smallest boxes. The binary tree
//! splits along its axes, so that the tree does not depend on the orientation of a part in its
//! file.

use super::axes::{Candidates, Leaf, identity};
use super::moments::{Moments, Surfaces};
use super::orientation::{MESH_ORIENTATION, Orientation};
use super::place::Placed;
use crate::mesh::Mesh;
use crate::tree::fork::Pieces;
use crate::tree::unit::{Triangle, Unit};
use crate::tree::wide::WIDTH;
use alloc::vec::Vec;
use punctual_geom::lanes::{Instructions, Kernel, Lanes};

/// Maximum number of triangles in the sample.
const SAMPLES: usize = 512;

/// The best orientation for the triangles of `mesh`, from a sample of them. `O(1)`.
pub(crate) fn align(unit: &Unit, mesh: &Mesh) -> Orientation {
    if mesh.is_empty() {
        return Orientation::IDENTITY;
    }
    let step = mesh.len().div_ceil(SAMPLES);
    let ids: Vec<u32> = (0..mesh.len() as u32).step_by(step).collect();
    Instructions::detect().run(Align {
        samples: &Placed::of(mesh, *unit, &ids, Pieces::ONE).triangles,
    })
}

struct Align<'t> {
    samples: &'t [Triangle],
}

impl Kernel for Align<'_> {
    type Output = Orientation;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Orientation {
        // The mesh's own axes are kept unless others cost less than this fraction of theirs. A
        // smaller gain is chance.
        const MARGIN: f32 = 0.95;
        let mut parts = self.samples.len().div_ceil(WIDTH);
        let mut merged = alloc::vec![Moments::default(); parts.div_ceil(WIDTH)];
        for (i, chunk) in self.samples.chunks(WIDTH).enumerate() {
            merged[i / WIDTH].set(
                lanes,
                i % WIDTH,
                &Surfaces::of_triangles(lanes, chunk, i * WIDTH),
            );
        }
        while parts > 1 {
            parts = merged.len();
            let mut above = alloc::vec![Moments::default(); parts.div_ceil(WIDTH)];
            for (i, part) in merged.iter().enumerate() {
                above[i / WIDTH].set(lanes, i % WIDTH, &Surfaces::load(lanes, part));
            }
            merged = above;
        }
        let whole = Surfaces::load(lanes, &merged[0]);
        let candidates = Candidates::of(lanes, &whole, self.samples);
        let mut sum = [0.0; 4];
        for chunk in self.samples.chunks(WIDTH) {
            let costs = candidates.costs(lanes, 0, &identity(lanes), &Leaf::of(lanes, chunk));
            for (sum, cost) in sum.iter_mut().zip(costs) {
                *sum += cost;
            }
        }
        sum[0] *= MARGIN;
        candidates
            .best(0, &sum)
            .map_or(Orientation::IDENTITY, |axes| {
                Orientation::of(&axes, MESH_ORIENTATION)
            })
    }
}
