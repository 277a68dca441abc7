//! What the steps of a frame ask of a body, beside its pose and tree.

use super::filter::Filter;

/// What is new about a body, as far as pairs are concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) enum Change {
    /// Nothing: only its swept box, of the frame before, is to be replaced by a smaller one.
    Settle,
    /// At most its box.
    #[default]
    None,
    /// Its fat AABB, or which bodies it may meet.
    Place,
    /// The slot has another body than before.
    Body,
}

/// What is asked of a body for each of its pairs: few bytes, so that those of a large scene stay in
/// the caches.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(super) struct Facts {
    /// The frame in which pose or tree were last new.
    pub changed: u64,
    /// The change that the broad phase has not seen yet.
    pub pending: Option<Change>,
    pub importance: f32,
    /// Fourth root of the number of triangles.
    pub size: f32,
    /// How far it went, at most, in the frame in which it was last moved.
    pub step: f32,
    pub filter: Filter,
    /// Whether one of its distances is asked for.
    pub is_measured: bool,
    /// Whether more may be asked of its pairs than whether they meet: it has a margin or a motion,
    /// or is measured.
    pub is_special: bool,
    /// Whether it is a part of a compound.
    pub is_part: bool,
}

const _: () = assert!(size_of::<Facts>() == 32);

impl Facts {
    /// Whether its box may be of another pose or tree than it has.
    pub fn is_changed(&self) -> bool {
        self.pending > Some(Change::Settle)
    }

    /// Whether more may be asked of two bodies than whether they meet.
    pub fn are_special([x, y]: [&Self; 2]) -> bool {
        x.is_special | y.is_special
    }

    /// Whether its slot had another body when its box was made.
    pub fn is_another(&self) -> bool {
        self.pending == Some(Change::Body)
    }
}
