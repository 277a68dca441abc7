//! Names of bodies and of pairs of bodies.

use core::cmp;
use core::fmt;
use core::hash::{Hash, Hasher};
use core::sync::atomic::{AtomicU32, Ordering};

/// Tells the scenes of a process apart, so that none takes the ids of another one for its own. It
/// is no part of what an id says: ids compare, hash, print and are stored without it, so that what
/// scenes report that were told the same is the same.
#[derive(Clone, Copy, Default)]
pub(super) struct SceneNumber(u32);

impl SceneNumber {
    /// Of a new scene.
    pub fn new() -> Self {
        static LAST: AtomicU32 = AtomicU32::new(0);
        // 0 is that of no scene, also after 2^32 of them.
        Self(LAST.fetch_add(1, Ordering::Relaxed).wrapping_add(1).max(1))
    }

    /// Whether an id of this number may be of the scene of the other one; so may an id that was
    /// made of bits or read.
    #[inline]
    pub fn may_be(self, other: Self) -> bool {
        self.0 == other.0 || self.0 == 0 || other.0 == 0
    }
}

impl fmt::Debug for SceneNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("_")
    }
}

impl PartialEq for SceneNumber {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for SceneNumber {}

impl PartialOrd for SceneNumber {
    fn partial_cmp(&self, other: &Self) -> Option<cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for SceneNumber {
    fn cmp(&self, _: &Self) -> cmp::Ordering {
        cmp::Ordering::Equal
    }
}

impl Hash for SceneNumber {
    fn hash<H: Hasher>(&self, _: &mut H) {}
}

/// Names a body of one scene for as long as it is in it. The id of a removed body is never valid
/// again, and no other scene takes it for one of its own.
///
/// Ids compare by index and generation: those of two scenes to which the same was done are equal,
/// and a [report](crate::Report::pair) of one may be asked with those of the other.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyId {
    pub(super) index: u32,
    pub(super) generation: u32,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(super) scene: SceneNumber,
}

impl BodyId {
    /// A small number that no other body now in the scene has; those of removed bodies are given
    /// out again.
    pub fn index(self) -> usize {
        self.index as usize
    }

    /// What the id says as a number, for files and other languages: the index in the low half.
    pub fn to_bits(self) -> u64 {
        u64::from(self.generation) << 32 | u64::from(self.index)
    }

    /// The inverse of [`to_bits`](Self::to_bits). Any number will do; a scene knows which of them
    /// are ids of its bodies. Which scene the id was of is not in the number: every scene takes it
    /// for its own, as it does an id that was read.
    pub fn from_bits(bits: u64) -> Self {
        Self {
            index: bits as u32,
            generation: (bits >> 32) as u32,
            scene: SceneNumber::default(),
        }
    }

    /// The number of its scene in this process, from 1; 0 if the id was made of bits or read. For
    /// other languages: it is no part of what the id says.
    pub fn scene(self) -> u32 {
        self.scene.0
    }

    /// The same id, of the scene of this number.
    #[must_use]
    pub fn of_scene(self, scene: u32) -> Self {
        Self {
            scene: SceneNumber(scene),
            ..self
        }
    }

    /// Whether both name one body.
    pub(super) fn is(self, other: Self) -> bool {
        self == other && self.scene.may_be(other.scene)
    }
}

impl fmt::Debug for BodyId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            index, generation, ..
        } = self;
        f.debug_struct("BodyId")
            .field("index", index)
            .field("generation", generation)
            .finish()
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
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(from = "u64", into = "u64"))]
        pub struct $id {
            number: u64,
            scene: SceneNumber,
        }

        impl $id {
            pub(super) fn new(number: u64, scene: SceneNumber) -> Self {
                Self { number, scene }
            }

            /// What the id says as a number, for files and other languages.
            pub fn to_bits(self) -> u64 {
                self.number
            }

            /// The inverse of [`to_bits`](Self::to_bits). Any number will do; a scene knows which
            /// of them are its ids. Which scene the id was of is not in the number: every scene
            /// takes it for its own, as it does an id that was read.
            pub fn from_bits(bits: u64) -> Self {
                Self::new(bits, SceneNumber::default())
            }

            /// Whether both name the same.
            pub(super) fn is(self, other: Self) -> bool {
                self == other && self.scene.may_be(other.scene)
            }
        }

        impl From<u64> for $id {
            fn from(bits: u64) -> Self {
                Self::from_bits(bits)
            }
        }

        impl From<$id> for u64 {
            fn from(id: $id) -> Self {
                id.number
            }
        }

        impl fmt::Debug for $id {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.debug_tuple(stringify!($id)).field(&self.number).finish()
            }
        }

        impl fmt::Display for $id {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!($name, " {}"), self.number)
            }
        }
    };
}

numbered!(
    /// Names a compound of one scene ([`crate::Scene::insert_compound`]); that of a removed one is
    /// never valid again, and no other scene takes it for one of its own. Ids compare by their
    /// numbers.
    CompoundId,
    "compound"
);

numbered!(
    /// Names two groups of bodies whose distance is asked for ([`crate::Scene::measure_groups`]),
    /// until that ends; no other scene takes it for one of its own. Ids compare by their numbers.
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
