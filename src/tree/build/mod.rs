//! From triangles to nodes:
//!
//! 1. [`place`] converts the vertices to unit coordinates; [`align`] may turn the mesh first.
//! 2. [`binary`] and [`bins`] build a binned-SAH binary tree over the triangles.
//! 3. [`collapse`] makes nodes of up to eight children of it.
//! 4. [`assign`] chooses an orientation for each node, by [`moments`] and [`axes`].

pub(crate) mod align;
pub(crate) mod assign;
pub(crate) mod axes;
pub(crate) mod binary;
pub(crate) mod bins;
pub(crate) mod collapse;
pub(crate) mod eight;
pub(crate) mod moments;
pub(crate) mod orientation;
pub(crate) mod place;
