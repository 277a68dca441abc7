//! Groups of bodies, and which groups may meet.

/// Determines which bodies may meet: `x` and `y` if `x.groups & y.mask` and `y.groups & x.mask`
/// both have a bit set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct Filter {
    /// The groups that the body belongs to.
    pub groups: u32,
    /// The groups that the body may meet.
    pub mask: u32,
}

impl Filter {
    /// Member of the groups `groups`, meets those of `mask`.
    pub const fn new(groups: u32, mask: u32) -> Self {
        Self { groups, mask }
    }

    /// True if bodies with these filters may meet.
    pub const fn meets(self, other: Self) -> bool {
        self.groups & other.mask != 0 && other.groups & self.mask != 0
    }
}

impl Default for Filter {
    /// Member of all groups, meets all groups.
    fn default() -> Self {
        Self::new(u32::MAX, u32::MAX)
    }
}
