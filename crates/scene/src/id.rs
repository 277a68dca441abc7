//! Ids of bodies and of pairs of bodies.

use core::cmp;
use core::fmt;
use core::hash::{Hash, Hasher};
use core::sync::atomic::{AtomicU32, Ordering};

/// Distinguishes the scenes of a process, so that no scene accepts an id of another one. Ids
/// compare, hash, print and are serialized without it, so that scenes with the same history report
/// equal ids.
#[derive(Clone, Copy, Default)]
pub(super) struct SceneNumber(u32);

impl SceneNumber {
    pub fn new() -> Self {
        static LAST: AtomicU32 = AtomicU32::new(0);
        // 0 means no scene, also after 2^32 scenes.
        Self(LAST.fetch_add(1, Ordering::Relaxed).wrapping_add(1).max(1))
    }

    /// True if an id with this number may belong to the scene with the other number. 0, of an id
    /// made from bits or deserialized, matches every scene.
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

/// Identifies a body of one scene while it is in the scene. The id of a removed body is never valid
/// again, and no other scene accepts it.
///
/// Ids compare by index and generation. So the ids of two scenes with the same history are equal,
/// and a [report](crate::Report::pair) of one accepts those of the other.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyId {
    pub(super) index: u32,
    pub(super) generation: u32,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(super) scene: SceneNumber,
}

impl BodyId {
    /// A small number, unique among the bodies now in the scene. Numbers of removed bodies are
    /// reused.
    pub fn index(self) -> usize {
        self.index as usize
    }

    /// The id as a number, for files and other languages: the index is in the low half.
    pub fn to_bits(self) -> u64 {
        u64::from(self.generation) << 32 | u64::from(self.index)
    }

    /// The inverse of [`to_bits`](Self::to_bits). Accepts any number; a scene knows which numbers
    /// are ids of its bodies. The number does not include the scene: every scene accepts the id as
    /// its own, like a deserialized one.
    pub fn from_bits(bits: u64) -> Self {
        Self {
            index: bits as u32,
            generation: (bits >> 32) as u32,
            scene: SceneNumber::default(),
        }
    }

    /// The number of its scene in this process, from 1; 0 if the id was made from bits or
    /// deserialized. For other languages: it is not part of the id's value.
    pub fn scene(self) -> u32 {
        self.scene.0
    }

    /// The same id, for the scene with this number.
    #[must_use]
    pub fn of_scene(self, scene: u32) -> Self {
        Self {
            scene: SceneNumber(scene),
            ..self
        }
    }

    /// True if both identify the same body.
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

/// An id that is a counter and never reused.
macro_rules! numbered {
    ($(#[$docs:meta])* $id:ident, $name:literal) => {
        $(#[$docs])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(transparent))]
        pub struct $id {
            number: u64,
            #[cfg_attr(feature = "serde", serde(skip))]
            scene: SceneNumber,
        }

        impl $id {
            pub(super) fn new(number: u64, scene: SceneNumber) -> Self {
                Self { number, scene }
            }

            /// The id as a number, for files and other languages.
            pub fn to_bits(self) -> u64 {
                self.number
            }

            /// The inverse of [`to_bits`](Self::to_bits). Accepts any number; a scene knows which
            /// numbers are its ids. The number does not include the scene: every scene accepts the
            /// id as its own, like a deserialized one.
            pub fn from_bits(bits: u64) -> Self {
                Self::new(bits, SceneNumber::default())
            }

            /// True if both identify the same thing.
            pub(super) fn is(self, other: Self) -> bool {
                self == other && self.scene.may_be(other.scene)
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
    /// Identifies a compound of one scene ([`crate::Scene::insert_compound`]). The id of a removed
    /// compound is never valid again, and no other scene accepts it. Ids compare by their numbers.
    CompoundId,
    "compound"
);

numbered!(
    /// Identifies a group of bodies by its name ([`crate::Scene::group`]). No other scene accepts
    /// it. Ids compare by their numbers.
    GroupId,
    "group"
);

numbered!(
    /// Identifies two groups of bodies whose distance is measured
    /// ([`crate::Scene::measure_groups`]), until that ends. No other scene accepts it. Ids compare
    /// by their numbers.
    MeasureId,
    "measure"
);

/// Two bodies by index, the lower one in the upper half, so that pairs are ordered by it.
pub(super) type PairKey = u64;

pub(super) fn pair_key(a: u32, b: u32) -> PairKey {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

/// The bodies of a pair, the lower index first.
pub(super) fn bodies_of(key: PairKey) -> [u32; 2] {
    [(key >> 32) as u32, key as u32]
}
