//! How a tree is built.

/// How a tree is built. Nodes have at most eight children whatever the options: the kernels are made for that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct BuildOptions {
    /// What the build may cost.
    pub effort: Effort,
    /// Whether nodes choose the orientation in which their boxes are smallest; if not, all boxes have the mesh's axes.
    pub orientations: bool,
    /// Most threads to build in, 1 by default. More than one only with the feature `parallel`, and only large meshes; the
    /// tree is the same, to the bit.
    pub threads: usize,
}

/// How much time a build may take to make queries faster; the figures are in `docs/performance.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Effort {
    /// One orientation for the whole mesh, 8 bins an axis.
    Fast,
    /// An orientation for each node, 16 bins an axis, 8 for few triangles.
    Normal,
    /// An orientation for each node, chosen from more candidates; 64 bins an axis, 16 for few triangles.
    Best,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { effort: Effort::Normal, orientations: true, threads: 1 }
    }
}

impl BuildOptions {
    /// For meshes that change or are asked about only a few times.
    #[must_use]
    pub fn fast_build() -> Self {
        Self { effort: Effort::Fast, ..Self::default() }
    }

    /// For meshes that are built once and asked about often.
    #[must_use]
    pub fn best() -> Self {
        Self { effort: Effort::Best, ..Self::default() }
    }

    /// The same with at most this many threads.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }
}
