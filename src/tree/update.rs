//! Boxes, profiles and alphas of all nodes, bottom-up in one pass: the end of a build and the whole of a refit.

use super::eight::{Eight, present};
use super::fit::{Extent, span};
use super::profile::Profiles;
use super::unit::Triangle;
use super::wide::Node;
use crate::math::lanes::{F8, Instructions, Kernel, Lanes};
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
    fn run<L: Lanes>(self, lanes: L) {
        let Self { nodes, triangles, profiles } = self;
        let mut area = 0.0;
        for index in (0..nodes.len()).rev() {
            let Some((node, later)) = nodes[index..].split_first_mut() else { continue };
            let (first, mut own) = (index + 1, Extent::EMPTY);
            if node.is_cluster {
                // All but a root are done with their parent.
                if index == 0 {
                    fit_cluster(lanes, node, &Eight::of_few(lanes, triangles));
                    area += profiles.measure(lanes, 0, node, &[]);
                }
                continue;
            }
            for lane in 0..usize::from(node.children) {
                let number = node.first_child as usize + lane;
                let child = &mut later[number - first];
                let extent = if child.is_cluster {
                    let eight = Eight::of_few(lanes, &triangles[child.triangle_range()]);
                    let extent = fit_cluster(lanes, child, &eight);
                    area += profiles.measure(lanes, number, child, &[]);
                    if child.orientation == node.orientation { extent } else { span(lanes, &eight, node).extent() }
                } else {
                    Extent::of_subtree(lanes, &later[number - first], node, later, first, triangles)
                };
                let (center, half) = (extent.center(), extent.half());
                for k in 0..3 {
                    node.center[k][lane] = center[k];
                    node.half[k][lane] = half[k];
                }
                own = own.union(extent);
            }
            set_own(node, &own);
            area += profiles.measure(
                lanes,
                index,
                node,
                &later[node.first_child as usize - first..][..usize::from(node.children)],
            );
        }
        let root = nodes.first().map_or(0.0, |root| f64::from(root.size) * f64::from(root.size));
        profiles.cost = if root > 0.0 { (area / root) as f32 } else { 0.0 };
    }
}

#[inline(always)]
fn fit_cluster<L: Lanes>(lanes: L, node: &mut Node, triangles: &Eight<L>) -> Extent {
    let span = span(lanes, triangles, node);
    let half = present(lanes, node.children.into()) * F8::splat(lanes, 0.5);
    for k in 0..3 {
        node.center[k] = ((span.min[k] + span.max[k]) * half).store();
        node.half[k] = ((span.max[k] - span.min[k]) * half).store();
    }
    let own = span.extent();
    set_own(node, &own);
    own
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
