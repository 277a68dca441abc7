//! Data of a body that its pairs need.

use punctual_geom::Aabb;

/// Data that the list of pairs reads of each body, in random order, in one cache line: its box, its
/// displacement ([`super::pair::travel`]), and its generation.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Spot {
    /// Empty for a body that is absent or not placed yet.
    pub bounds: Aabb,
    /// Upper bound of the displacement of every point of its mesh, summed over all moves since
    /// `remade`, including rounding.
    pub gone: f64,
    /// The last frame, low bits, in which it was changed other than by a move.
    pub remade: u32,
    /// The generation of its id.
    pub generation: u32,
}

const _: () = assert!(size_of::<Spot>() == 64);

impl Spot {
    /// The data of a body that is not placed yet.
    pub const NOWHERE: Self = Self {
        bounds: Aabb::EMPTY,
        gone: 0.0,
        remade: 0,
        generation: 0,
    };
}
