//! How a tree is built.

/// How a tree is built. Nodes have at most eight children whatever the options: the kernels are made for that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct BuildOptions {
    /// How much time the build may take.
    pub effort: Effort,
    /// Whether nodes choose the orientation in which their boxes are smallest; if not, all boxes have the mesh's axes.
    pub orientations: bool,
    /// Whether to keep the few corners that may be the farthest along any direction, 10 KB and some bytes a triangle; a build
    /// takes a third to the whole of its time longer, and of round meshes up to four times as long. In a [`crate::Scene`], two
    /// bodies that are close, or all but touch, are then told apart by a plane between them, without a search, if they are
    /// convex there. A refit ends that, and of round meshes of more than about 100,000 triangles none are kept. False by default.
    pub extremes: bool,
    /// Most threads that build at once, the caller's included; 1 by default. More than one are used only with the feature
    /// `parallel`, and only for large meshes. The tree is the same to the bit, however many there are.
    pub threads: usize,
}

/// How much time a build takes, to make queries faster; figures in `docs/performance.md`.
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
        Self {
            effort: Effort::Normal,
            orientations: true,
            extremes: false,
            threads: 1,
        }
    }
}

impl BuildOptions {
    /// The fastest build: for meshes that change, or that only a few queries will use.
    #[must_use]
    pub fn fast_build() -> Self {
        Self {
            effort: Effort::Fast,
            ..Self::default()
        }
    }

    /// The fastest queries: for trees that are built once and used often.
    #[must_use]
    pub fn best() -> Self {
        Self {
            effort: Effort::Best,
            ..Self::default()
        }
    }

    /// Sets whether extremes are kept.
    #[must_use]
    pub fn extremes(self, extremes: bool) -> Self {
        Self { extremes, ..self }
    }

    /// Sets the number of threads.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }
}
