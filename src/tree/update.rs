//! Boxes and profiles of all nodes, bottom-up in one pass: the end of a build and the whole of a refit.

use super::eight::{Eight, present};
use super::fit::{Extent, span};
use super::profile::Profiles;
use super::unit::Triangle;
use super::wide::Node;
use crate::math::lanes::{F8, Instructions, Kernel, Lanes, per_axis};
use wide::f32x4;

/// Computes everything in `nodes` and `profiles` that depends on where the triangles are; places and orientations stay.
/// `O(n)` in the mean, and allocates nothing.
pub(super) fn update(nodes: &mut [Node], triangles: &[Triangle], profiles: &mut Profiles) {
    Instructions::detect().run(Update { nodes, triangles, profiles });
}

struct Update<'t> {
    nodes: &'t mut [Node],
    triangles: &'t [Triangle],
    profiles: &'t mut Profiles,
}

impl Kernel for Update<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let mut area = 0.0;
        for index in (0..self.nodes.len()).rev() {
            if !self.nodes[index].is_cluster {
                area += self.inner(lanes, index);
            } else if index == 0 {
                // All other clusters are done with their parents.
                let triangles = Eight::of_few(lanes, self.triangles);
                area += cluster(lanes, &mut self.nodes[0], &triangles, self.profiles).1;
            }
        }
        let Some(root) = self.nodes.first_mut() else { return };
        if !root.is_cluster {
            set_own(root, &Extent::kept_in(root));
        }
        let whole = f64::from(root.size) * f64::from(root.size);
        self.profiles.cost = if whole > 0.0 { (area / whole) as f32 } else { 0.0 };
    }
}

impl Update<'_> {
    /// An inner node, whose inner children are done, and the clusters among its children. Returns the summed surface area
    /// of the boxes below them.
    ///
    /// Until its parent is done an inner node keeps the ends of its box in the place of its centre and half extent: a parent
    /// with the same axes needs them to the bit.
    #[inline(always)]
    fn inner<L: Lanes>(&mut self, lanes: L, index: usize) -> f64 {
        let Some((node, later)) = self.nodes[index..].split_first_mut() else { return 0.0 };
        let (first, mut own, mut area) = (index + 1, Extent::EMPTY, 0.0);
        for lane in 0..usize::from(node.children) {
            let number = node.first_child as usize + lane;
            let child = &mut later[number - first];
            let same = child.orientation == node.orientation;
            let extent = if child.is_cluster {
                let eight = Eight::of_few(lanes, &self.triangles[child.triangle_range()]);
                let (extent, below) = cluster(lanes, child, &eight, self.profiles);
                area += below;
                if same { extent } else { span(lanes, &eight, node).extent() }
            } else {
                let ends = Extent::kept_in(child);
                set_own(child, &ends);
                if same {
                    ends
                } else {
                    Extent::of_subtree(lanes, &later[number - first], node, later, first, self.triangles)
                }
            };
            let (center, half) = (extent.center(), extent.half());
            for k in 0..3 {
                node.center[k][lane] = center[k];
                node.half[k][lane] = half[k];
            }
            own = own.union(extent);
        }
        own.keep_in(node);
        let children = &later[node.first_child as usize - first..][..usize::from(node.children)];
        area + self.profiles.measure(lanes, node, own.center().to_array(), own.half().to_array(), children)
    }
}

/// Fits a cluster to its triangles. Returns its own box and the summed surface area of theirs.
#[inline(always)]
fn cluster<L: Lanes>(lanes: L, node: &mut Node, triangles: &Eight<L>, profiles: &mut Profiles) -> (Extent, f64) {
    let span = span(lanes, triangles, node);
    let part = present(lanes, node.children.into()) * F8::splat(lanes, 0.5);
    let center = per_axis!(k => (span.min[k] + span.max[k]) * part);
    let half = per_axis!(k => (span.max[k] - span.min[k]) * part);
    node.center = per_axis!(k => center[k].store());
    node.half = per_axis!(k => half[k].store());
    let own = span.extent();
    set_own(node, &own);
    let area = profiles.measure_cluster(lanes, node, &center, &half);
    (own, area)
}

#[inline(always)]
fn set_own(node: &mut Node, own: &Extent) {
    let half = own.half();
    node.own_center = f32x4::new(own.center().extend(0.0).to_array());
    node.own_half = f32x4::new(half.extend(0.0).to_array());
    let (x, y, z) = (half.x, half.y, half.z);
    let (middle, longest) = (x.min(y).max(x.max(y).min(z)), x.max(y).max(z));
    node.slimness = if longest > 0.0 { middle / longest } else { 1.0 };
    let area = 8.0 * (x * y + y * z + z * x);
    // Not that of `libm`: its instruction makes AVX code wait for a hundred cycles.
    [node.size, ..] = f32x4::splat(area).sqrt().to_array();
}
