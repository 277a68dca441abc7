//! Options of a build.

use super::solid::Solid;

/// Options of a build. Nodes have at most eight children in any case, because the kernels are made
/// for eight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct BuildOptions {
    /// Trades time of the build for speed of queries.
    pub effort: Effort,
    /// True if each node chooses the orientation in which its boxes are smallest. Otherwise all
    /// boxes have the mesh's axes.
    pub orientations: bool,
    /// True if the tree keeps the few corners that may be the farthest along any direction. They
    /// take 10 KB and some bytes per triangle. The build takes 33 % to 100 % longer; for round
    /// meshes it takes up to four times as long. False by default.
    ///
    /// In a `punctual_scene::Scene`, these corners let a plane separate two bodies without a
    /// search, if the bodies are close or almost touch and are convex there. A refit discards the
    /// corners. A round mesh of more than about 100,000 triangles keeps none.
    pub extremes: bool,
    /// What the mesh bounds. For solids the tree keeps its components, its open edges and its
    /// volumes ([`crate::Tree::solid`]): 4 bytes per triangle if there are several components, and
    /// 12 to 16 bytes per open edge. [`Solid::No`] by default.
    pub solid: Solid,
    /// Maximum number of threads that build at once, the caller's included; 1 by default. More than
    /// one are used only with the feature `parallel`, and only for large meshes. The tree is the
    /// same to the bit for any number of threads.
    pub threads: usize,
}

/// Trade-off between the time of the build and the speed of queries. `docs/performance.md` has the
/// figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Effort {
    /// One orientation for the whole mesh, 8 bins per axis. Points are sorted along a Hilbert curve.
    Fast,
    /// An orientation for each node; 16 bins per axis, 8 for few triangles. Points are halved, down
    /// to blocks of eight.
    Normal,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            effort: Effort::Normal,
            orientations: true,
            extremes: false,
            solid: Solid::No,
            threads: 1,
        }
    }
}

impl BuildOptions {
    /// Options of the fastest build: for meshes that change, or for few queries.
    #[must_use]
    pub fn fast_build() -> Self {
        Self {
            effort: Effort::Fast,
            ..Self::default()
        }
    }

    /// Sets the option `extremes`.
    #[must_use]
    pub fn extremes(self, extremes: bool) -> Self {
        Self { extremes, ..self }
    }

    /// Sets what the mesh bounds.
    #[must_use]
    pub fn solid(self, solid: Solid) -> Self {
        Self { solid, ..self }
    }

    /// Sets the maximum number of threads.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }
}
