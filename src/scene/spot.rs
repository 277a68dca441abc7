//! Where a body is, as far as its pairs are concerned.

use crate::math::Aabb;

/// What the list of pairs reads of each body, of bodies in no order, in one cache line: its box,
/// how far it has gone ([`super::pair::travel`]), and which it is.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Spot {
    /// Empty for a body that is not there, or not placed yet.
    pub bounds: Aabb,
    /// A bound on the way of every point of its mesh, of all moves since `remade` together, with
    /// what rounding may add.
    pub gone: f64,
    /// The last frame, its low bits, in which it was changed other than by a move.
    pub remade: u32,
    /// The generation of its id.
    pub generation: u32,
}

const _: () = assert!(size_of::<Spot>() == 64);

impl Spot {
    /// Of a body that is not placed yet.
    pub const NOWHERE: Self = Self {
        bounds: Aabb::EMPTY,
        gone: 0.0,
        remade: 0,
        generation: 0,
    };
}
