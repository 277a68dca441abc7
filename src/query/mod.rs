//! The questions, a folder for each: its type and options, how a run of it begins and is answered,
//! its visits of node pairs, and its state in the [`Workspace`](crate::Workspace).
//!
//! [`engine`](crate::engine) has what they share: the loop, the frontier, deadlines, memory.
//!
//! | question | folder | begin with |
//! |---|---|---|
//! | which triangles intersect, any or all | [`intersection`] | [`meeting`](intersection::meeting), the visits; [`trace`](intersection::trace), curves of hits |
//! | where a surface intersects itself | [`self_intersection`] |  |
//! | how far surfaces are apart | [`distance`] | [`nearest`](distance::nearest), the visits; [`interval`](distance::interval), the bounds |
//! | all pairs within a margin, asked as one of these two | [`contacts`] | |
//! | which points of a cloud are near a surface | [`near_points`] | |
//! | what a solver needs: contacts, reduced, then the overlaps | [`manifolds`] | [`manifold`](manifolds::manifold), [`overlaps`](manifolds::overlaps) |
//! | when surfaces meet on the way | [`motion`] | |
//! | what rays hit | [`rays`] | |
//! | where points lie; whether a solid is inside another | [`points`] | [`contained`](points::contained) |

pub(crate) mod contacts;
pub(crate) mod distance;
pub(crate) mod intersection;
pub(crate) mod manifolds;
pub(crate) mod motion;
pub(crate) mod near_points;
pub(crate) mod points;
pub(crate) mod rays;
pub(crate) mod self_intersection;
pub(crate) mod state;
