//! Where a body is, as far as its pairs are concerned.

use super::pair::travel::Travel;
use crate::math::Aabb;

/// The box of a body and how far the body has gone, in one cache line: the list of pairs reads both, of bodies in no order.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Spot {
    /// Empty for a body that is not there, or not placed yet.
    pub bounds: Aabb,
    pub travel: Travel,
}

const _: () = assert!(size_of::<Spot>() == 64);

impl Spot {
    /// Of a body that is not placed yet.
    pub const NOWHERE: Self = Self { bounds: Aabb::EMPTY, travel: Travel::NONE };
}
