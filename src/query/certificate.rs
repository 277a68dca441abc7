//! What an unfinished query can still say: how many intersections it may have missed, and where.

use super::queue::Pair;
use super::views::rounding;
use super::workspace::Workspace;
use crate::math::tolerance::FRAME_ROUNDING;
use crate::math::{Aabb, Pose};
use crate::tree::{Tree, xyz};
use glam::{DMat3, DVec3, Vec3};

/// Bounds on what the last run of a query left open. Looks at the workspace when asked, in time linear in the open pairs.
#[derive(Clone, Copy, Debug)]
pub struct Certificate<'w> {
    a: &'w Tree,
    b: &'w Tree,
    b_in_a: &'w Pose,
    workspace: &'w Workspace,
}

impl<'w> Certificate<'w> {
    pub(super) fn new(a: &'w Tree, b: &'w Tree, b_in_a: &'w Pose, workspace: &'w Workspace) -> Self {
        Self { a, b, b_in_a, workspace }
    }

    /// Number of open pairs, of nodes or triangles. 0 means that nothing was missed.
    #[must_use]
    pub fn open_pairs(&self) -> usize {
        self.open().count()
    }

    /// No more triangle pairs than this intersect: those found, and for each open pair the product of its triangles.
    #[must_use]
    pub fn upper_bound(&self) -> u64 {
        let count = |tree: &Tree, node: u32, alive: u8| {
            let node = &tree.nodes()[node as usize];
            if node.is_cluster {
                u64::from((u32::from(alive) & node.valid()).count_ones())
            } else {
                node.triangles.into()
            }
        };
        let open = self.open().map(|open| match open {
            Open::Nodes(Pair { nodes: [a, b], alive }) => count(self.a, a, alive[0]) * count(self.b, b, alive[1]),
            Open::Triangles(_) => 1,
        });
        let all = self.a.mesh().len() as u64 * self.b.mesh().len() as u64;
        (self.workspace.run.found + open.sum::<u64>()).min(all)
    }

    /// Boxes in A's frame, one for each open pair: every missed intersection has all its points in one of them.
    pub fn boxes(&self) -> impl Iterator<Item = Aabb> + 'w {
        let Self { a, b, b_in_a, .. } = *self;
        // That of B's vertices as they are placed, and twice as much for the boxes computed here (`docs/numerics.md`).
        let margin = 3.0 * rounding(a.unit(), b.unit(), b_in_a) + 8.0 * f64::EPSILON * a.unit().length();
        let margin = DVec3::splat(margin);
        self.open().map(move |open| {
            let [a, b] = match open {
                Open::Nodes(Pair { nodes, .. }) => {
                    [node_bounds(a, nodes[0], &Pose::IDENTITY), node_bounds(b, nodes[1], b_in_a)]
                }
                Open::Triangles(pair) => {
                    [triangle_bounds(a, pair[0], &Pose::IDENTITY), triangle_bounds(b, pair[1], b_in_a)]
                }
            };
            Aabb { min: a.min.max(b.min) - margin, max: a.max.min(b.max) + margin }
        })
    }

    /// The longest edge of these boxes, in the length unit of the meshes; 0 if nothing is open.
    #[must_use]
    pub fn largest_extent(&self) -> f64 {
        self.boxes().map(|open| (open.max - open.min).max_element()).fold(0.0, f64::max)
    }

    fn open(&self) -> impl Iterator<Item = Open> + 'w {
        let workspace = self.workspace;
        let triangles = workspace.waiting.as_slice().iter().chain(&workspace.doubtful).copied().map(Open::Triangles);
        workspace.front.iter().map(Open::Nodes).chain(triangles)
    }
}

/// As a structure of `open_pairs`, `upper_bound`, `largest_extent` and the list `boxes`.
#[cfg(feature = "serde")]
impl serde::Serialize for Certificate<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut fields = serializer.serialize_struct("Certificate", 4)?;
        fields.serialize_field("open_pairs", &self.open_pairs())?;
        fields.serialize_field("upper_bound", &self.upper_bound())?;
        fields.serialize_field("largest_extent", &self.largest_extent())?;
        fields.serialize_field("boxes", &self.boxes().collect::<alloc::vec::Vec<_>>())?;
        fields.end()
    }
}

/// A pair that was not finished.
enum Open {
    Nodes(Pair),
    /// In tree order.
    Triangles([u32; 2]),
}

/// The box, in A's frame, of a triangle whose mesh lies at `pose`.
fn triangle_bounds(tree: &Tree, triangle: u32, pose: &Pose) -> Aabb {
    let id = tree.ids()[triangle as usize];
    Aabb::from_points(tree.mesh().triangle(id as usize).map(|v| pose.transform_point(v)))
}

/// The same for a node.
fn node_bounds(tree: &Tree, node: u32, pose: &Pose) -> Aabb {
    let node = &tree.nodes()[node as usize];
    let (unit, rotation) = (tree.unit(), node.rotation().as_dmat3());
    let center = unit.origin + rotation * Vec3::from(xyz(node.own_center)).as_dvec3() * unit.length();
    let center = pose.transform_point(center);
    let half = node.extent().as_dvec3() + DVec3::splat(f64::from(FRAME_ROUNDING));
    let half = abs(&(*pose.rotation() * rotation)) * half * unit.length();
    Aabb { min: center - half, max: center + half }
}

fn abs(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}
