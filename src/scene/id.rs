//! Names of bodies and of pairs of bodies.

use core::fmt;

/// Names a body of one scene for as long as it is in it. The id of a removed body is never valid again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyId {
    pub(super) index: u32,
    pub(super) generation: u32,
}

impl BodyId {
    /// A small number that no other body now in the scene has; those of removed bodies are given out again.
    pub fn index(self) -> usize {
        self.index as usize
    }

    /// All of the id as a number, for other languages: the index in the low half.
    pub fn to_bits(self) -> u64 {
        u64::from(self.generation) << 32 | u64::from(self.index)
    }

    /// The inverse of [`to_bits`](Self::to_bits). Any number will do; a scene knows which of them are ids of its bodies.
    pub fn from_bits(bits: u64) -> Self {
        Self { index: bits as u32, generation: (bits >> 32) as u32 }
    }
}

impl fmt::Display for BodyId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "body {} (generation {})", self.index, self.generation)
    }
}

/// An id that is a number, counted up and never given out again.
macro_rules! numbered {
    ($(#[$docs:meta])* $id:ident, $name:literal) => {
        $(#[$docs])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct $id(pub(super) u64);

        impl $id {
            /// The id as a number, for other languages.
            pub fn to_bits(self) -> u64 {
                self.0
            }

            /// The inverse of [`to_bits`](Self::to_bits). Any number will do; a scene knows which of them are its ids.
            pub fn from_bits(bits: u64) -> Self {
                Self(bits)
            }
        }

        impl fmt::Display for $id {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!($name, " {}"), self.0)
            }
        }
    };
}

numbered!(
    /// Names a compound of one scene ([`crate::Scene::insert_compound`]); that of a removed one is never valid again.
    CompoundId,
    "compound"
);

numbered!(
    /// Names two groups of bodies whose distance is asked for ([`crate::Scene::measure_groups`]), until that ends.
    MeasureId,
    "measure"
);

/// Two bodies by index, the lower one in the upper half: pairs are ordered by it.
pub(super) type PairKey = u64;

pub(super) fn pair_key(a: u32, b: u32) -> PairKey {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

/// The bodies of a pair, the lower index first.
pub(super) fn bodies_of(key: PairKey) -> [u32; 2] {
    [(key >> 32) as u32, key as u32]
}
