//! An orientation for each node: moments bottom-up, then the choice top-down. `O(n)`.

use super::Effort;
use super::axes::Moments;
use super::collapse::Plan;
use super::columns::Columns;
use super::fork::Pieces;
use super::orientation::{MESH_ORIENTATION, Orientation};
use super::unit::Triangle;
use super::wide::Node;
use alloc::vec::Vec;
use core::ops::Range;
use core::slice;

/// Gives each node of `plan` the best orientation for it, out of more candidates with more effort.
pub(super) fn choose_orientations(
    plan: &Plan,
    nodes: &mut [Node],
    triangles: &[Triangle],
    effort: Effort,
    pieces: Pieces,
) {
    let Some((root, below)) = nodes.split_first_mut() else { return };
    let mut families = Vec::new();
    families.resize(plan.0[0].families as usize, Moments::EMPTY);
    Gather { plan, triangles }.siblings(0..1, &mut families, pieces);
    let whole = families.first().copied().unwrap_or_else(|| Moments::of_triangles(triangles, 0));
    let choose = Choose { plan, families: &families, triangles, effort };
    choose.set_orientations(&Moments::of_all(&[whole]), Orientation::IDENTITY, 0, slice::from_mut(root));
    choose.siblings(0..1, slice::from_mut(root), below, pieces);
}

/// Bottom-up: the moments of the children of each inner node, its family.
struct Gather<'p> {
    plan: &'p Plan,
    triangles: &'p [Triangle],
}

impl Gather<'_> {
    /// Fills the families of the subtrees of some siblings.
    fn siblings(&self, siblings: Range<usize>, families: &mut [Moments], pieces: Pieces) {
        if siblings.len() > 1 {
            let halves @ [left, _] = &self.plan.halves(&siblings);
            let (of_left, of_right) = families.split_at_mut(self.plan.sum(left, |stub| stub.families));
            let [left, right] = halves.clone();
            pieces.join(
                halves.each_ref().map(|half| self.plan.sum(half, |stub| stub.triangles)),
                |pieces| self.siblings(left, of_left, pieces),
                |pieces| self.siblings(right, of_right, pieces),
            );
        } else if let Some((own, below)) = families.split_first_mut() {
            let stub = &self.plan.0[siblings.start];
            self.siblings(stub.child_range(), below, pieces);
            for (lane, child) in self.plan.0[stub.child_range()].iter().enumerate() {
                if child.is_cluster {
                    let triangles = child.child_range();
                    own.set(lane, &Moments::of_triangles(&self.triangles[triangles.clone()], triangles.start));
                } else {
                    own.set(lane, &below[(child.family - stub.family - 1) as usize]);
                }
            }
        }
    }
}

/// Top-down: the orientation of each node.
struct Choose<'p> {
    plan: &'p Plan,
    families: &'p [Moments],
    triangles: &'p [Triangle],
    effort: Effort,
}

impl Choose<'_> {
    /// Chooses the orientations of all nodes below some siblings, which have theirs.
    fn siblings(&self, numbers: Range<usize>, siblings: &[Node], below: &mut [Node], pieces: Pieces) {
        if let [node] = siblings {
            let stub = &self.plan.0[numbers.start];
            if !stub.is_cluster {
                let (children, rest) = below.split_at_mut(stub.child_range().len());
                let family = &self.families[stub.family as usize];
                self.set_orientations(family, node.orientation(), stub.child_range().start, children);
                self.siblings(stub.child_range(), children, rest, pieces);
            }
            return;
        }
        let halves @ [left, _] = &self.plan.halves(&numbers);
        let (of_left, of_right) = siblings.split_at(left.len());
        let (below_left, below_right) = below.split_at_mut(self.plan.sum(left, |stub| stub.below));
        let [left, right] = halves.clone();
        pieces.join(
            halves.each_ref().map(|half| self.plan.sum(half, |stub| stub.triangles)),
            |pieces| self.siblings(left, of_left, below_left, pieces),
            |pieces| self.siblings(right, of_right, below_right, pieces),
        );
    }

    /// Chooses the orientations of siblings with numbers from `first` on, whose moments are `family`.
    fn set_orientations(&self, family: &Moments, parent: Orientation, first: usize, siblings: &mut [Node]) {
        let candidates = family.candidates();
        for (lane, node) in siblings.iter_mut().enumerate() {
            let stub = &self.plan.0[first + lane];
            let candidates = candidates.of_lane(lane, self.triangles, self.effort);
            let id = MESH_ORIENTATION + 1 + (first + lane) as u32;
            let orientation = if stub.is_cluster {
                let columns = Columns::of(&self.triangles[stub.child_range()]);
                parent.or_better(&candidates, id, |axes| columns.cost(axes))
            } else {
                parent.or_better(&candidates, id, |axes| self.families[stub.family as usize].cost(axes))
            };
            node.set_orientation(&orientation);
        }
    }
}
