//! Cache of placed triangle corners in `f64`. Where surfaces coincide, the pairs of two leaves
//! are tested one after the other and use the same corners.

use crate::tree::{Tree, WIDTH};
use glam::DVec3;
use punctual_geom::Pose;

/// The corners of the last triangles, one for each position in a leaf.
#[derive(Clone, Debug)]
pub(crate) struct Corners {
    /// In tree order.
    triangles: [u32; WIDTH],
    corners: [[DVec3; 3]; WIDTH],
}

impl Corners {
    const NONE: u32 = u32::MAX;

    pub const EMPTY: Self = Self {
        triangles: [Self::NONE; WIDTH],
        corners: [[DVec3::ZERO; 3]; WIDTH],
    };

    /// Clears the cache. Call it whenever the tree or the pose may have changed.
    pub fn clear(&mut self) {
        self.triangles = [Self::NONE; WIDTH];
    }

    /// The corners of a triangle (tree order), mapped by `place`.
    #[inline]
    pub fn of(
        &mut self,
        tree: &Tree,
        triangle: u32,
        place: impl Fn(DVec3) -> DVec3,
    ) -> &[DVec3; 3] {
        let slot = triangle as usize % WIDTH;
        if self.triangles[slot] != triangle {
            let [p, q, r] = tree.corners(triangle);
            self.corners[slot] = [place(p), place(q), place(r)];
            self.triangles[slot] = triangle;
        }
        &self.corners[slot]
    }

    /// The corners of a triangle pair (tree order), in A's frame.
    #[inline]
    pub fn of_pair<'c>(
        [of_a, of_b]: &'c mut [Self; 2],
        [a, b]: [&Tree; 2],
        b_in_a: &Pose,
        pair: [u32; 2],
    ) -> [&'c [DVec3; 3]; 2] {
        [
            of_a.of(a, pair[0], |v| v),
            of_b.of(b, pair[1], |v| b_in_a.transform_point(v)),
        ]
    }
}
