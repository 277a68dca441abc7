//! Data of a body that the steps of a frame need, besides its pose and tree.

use super::filter::Filter;

/// The news of a body, as far as pairs are concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) enum Change {
    /// The body did not change. The box at its pose replaces its swept box of the previous frame.
    Settle,
    /// At most its box is new.
    #[default]
    None,
    /// Its fat AABB has changed, or the set of bodies that it may meet.
    Place,
    /// The slot has another body than before.
    Body,
}

/// Data of a body that is read for each of its pairs: few bytes, so that a large scene stays in the
/// caches.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(super) struct Facts {
    /// The frame of the last change of pose or tree.
    pub changed: u64,
    /// The change that the broad phase has not processed yet.
    pub pending: Option<Change>,
    pub importance: f32,
    /// Fourth root of the number of triangles.
    pub size: f32,
    /// Upper bound of its displacement in the frame in which it was last moved.
    pub step: f32,
    pub filter: Filter,
    /// True if one of its distances is measured.
    pub is_measured: bool,
    /// True if its pairs may have other questions than whether they meet: it has a margin or a
    /// motion, or is measured.
    pub is_special: bool,
    /// True if it is a part of a compound, or in a group.
    pub is_member: bool,
}

const _: () = assert!(size_of::<Facts>() == 32);

impl Facts {
    /// True if its box may belong to an earlier pose or tree.
    pub fn is_changed(&self) -> bool {
        self.pending > Some(Change::Settle)
    }

    /// True if two bodies may have other questions than whether they meet.
    pub fn are_special([x, y]: [&Self; 2]) -> bool {
        x.is_special | y.is_special
    }

    /// True if its slot had another body when its box was computed.
    pub fn is_another(&self) -> bool {
        self.pending == Some(Change::Body)
    }
}
