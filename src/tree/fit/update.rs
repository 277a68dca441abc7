//! Computes boxes and profiles of all nodes bottom-up in one pass: the end of a build and the whole
//! of a refit.

use super::profile::{Levels, Profiles};
use super::{Extent, span};
use crate::tree::build::collapse::Part;
use crate::tree::build::eight::{Eight, present};
use crate::tree::fork::{Pieces, split};
use crate::tree::unit::Triangle;
use crate::tree::wide::Node;
use alloc::vec::Vec;
use core::ops::Range;
use punctual_geom::lanes::{F8, Instructions, Kernel, Lanes, per_axis};
use wide::f32x4;

/// Computes everything in `nodes` and `profiles` that depends on the positions of the triangles.
/// Structure and orientations stay. Threads may process the `parts` in parallel. `O(n)` on average.
/// It allocates nothing if there are no parts.
pub(crate) fn update(
    nodes: &mut [Node],
    triangles: &[Triangle],
    profiles: &mut Profiles,
    parts: &[Part],
    pieces: Pieces,
) {
    let instructions = Instructions::detect();
    // The levels are stored in the reverse order of the nodes.
    let ranges: Vec<_> = parts
        .iter()
        .rev()
        .map(|part| Profiles::range(&nodes[part.nodes.clone()]))
        .collect();
    let levels = split(&mut profiles.levels, ranges.iter().cloned());
    let levels = ranges.iter().zip(levels).map(|(range, levels)| Levels {
        first: range.start,
        levels,
    });
    let of_parts = parts
        .iter()
        .zip(split(nodes, parts.iter().map(|part| part.nodes.clone())));
    pieces.each(
        of_parts.rev().zip(levels).collect(),
        |((part, nodes), levels)| {
            let (first, numbers) = (part.nodes.start, part.nodes.clone());
            instructions.run(Update {
                nodes,
                first,
                numbers,
                triangles,
                levels,
            });
        },
    );
    let mut end = nodes.len();
    let mut above = |numbers| {
        let levels = Levels {
            first: 0,
            levels: &mut profiles.levels,
        };
        instructions.run(Update {
            nodes,
            first: 0,
            numbers,
            triangles,
            levels,
        });
    };
    for part in parts.iter().rev() {
        above(part.nodes.end..end);
        end = part.nodes.start;
    }
    above(0..end);
    profiles.end(nodes);
}

impl Profiles {
    /// Completes the root, and the SAH cost.
    pub fn end(&mut self, nodes: &mut [Node]) {
        let Some(root) = nodes.first_mut() else {
            return;
        };
        let area = root.size;
        set_own(root, &Extent::kept_in(root));
        let whole = root.size * root.size;
        self.cost = if whole > 0.0 { area / whole } else { 0.0 };
    }
}

struct Update<'t> {
    /// The nodes from number `first` on.
    nodes: &'t mut [Node],
    first: usize,
    /// Numbers of the nodes to update.
    numbers: Range<usize>,
    triangles: &'t [Triangle],
    levels: Levels<'t>,
}

impl Kernel for Update<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        for number in self.numbers.clone().rev() {
            if !self.nodes[number - self.first].is_leaf {
                self.inner(lanes, number);
            } else if number == 0 {
                // All other leaves are updated with their parents.
                let triangles = Eight::of_few(lanes, self.triangles);
                let (own, area) = leaf(lanes, &mut self.nodes[0], &triangles, &mut self.levels);
                keep(&mut self.nodes[0], &own, area);
            }
        }
    }
}

impl Update<'_> {
    /// Updates an inner node, whose inner children are done, and the leaves among its children.
    #[inline(always)]
    fn inner<L: Lanes>(&mut self, lanes: L, number: usize) {
        let Some((node, later)) = self.nodes[number - self.first..].split_first_mut() else {
            return;
        };
        let (first, mut own, mut area) = (number + 1, Extent::EMPTY, 0.0);
        // Backwards, like the whole pass, so that memory is read in one direction.
        for lane in (0..usize::from(node.children)).rev() {
            let number = node.first_child as usize + lane;
            let child = &mut later[number - first];
            let same = child.orientation == node.orientation;
            let extent = if child.is_leaf {
                let eight = Eight::of_few(lanes, &self.triangles[child.triangle_range()]);
                let (extent, below) = leaf(lanes, child, &eight, &mut self.levels);
                area += below;
                if same {
                    extent
                } else {
                    span(lanes, &eight, node).extent()
                }
            } else {
                let ends = Extent::kept_in(child);
                area += child.size;
                set_own(child, &ends);
                if same {
                    ends
                } else {
                    Extent::of_subtree(
                        lanes,
                        &later[number - first],
                        node,
                        later,
                        first,
                        self.triangles,
                    )
                }
            };
            let (center, half) = (extent.center(), extent.half());
            for k in 0..3 {
                node.center[k][lane / 4].as_mut_array()[lane % 4] = center[k];
                node.half[k][lane / 4].as_mut_array()[lane % 4] = half[k];
            }
            own = own.union(extent);
        }
        let children = &later[node.first_child as usize - first..][..usize::from(node.children)];
        area += self
            .levels
            .measure(lanes, node, own.half().to_array(), children);
        keep(node, &own, area);
    }
}

/// Stores intermediate values in an inner node until its parent is done. Its center and half extent
/// hold the ends of its box, because a parent with the same axes needs them to the bit. Its size
/// holds the sum of the surface areas of the boxes below it.
#[inline(always)]
pub(crate) fn keep(node: &mut Node, own: &Extent, area: f32) {
    own.keep_in(node);
    node.size = area;
}

/// Fits a leaf to its triangles. Returns the leaf's box, and the sum of the surface areas of
/// the triangles' boxes.
#[inline(always)]
pub(crate) fn leaf<L: Lanes>(
    lanes: L,
    node: &mut Node,
    triangles: &Eight<L>,
    levels: &mut Levels,
) -> (Extent, f32) {
    let span = span(lanes, triangles, node);
    let part = present(lanes, node.children.into()) * F8::splat(lanes, 0.5);
    let center = per_axis!(k => (span.min[k] + span.max[k]) * part);
    let half = per_axis!(k => (span.max[k] - span.min[k]) * part);
    node.center = per_axis!(k => center[k].halves());
    node.half = per_axis!(k => half[k].halves());
    let own = span.extent();
    set_own(node, &own);
    let area = levels.measure_leaf(node, &half);
    (own, area)
}

#[inline(always)]
pub(crate) fn set_own(node: &mut Node, own: &Extent) {
    let half = own.half();
    node.own_center = f32x4::new(own.center().extend(0.0).to_array());
    node.own_half = f32x4::new(half.extend(0.0).to_array());
    let (x, y, z) = (half.x, half.y, half.z);
    let (middle, longest) = (x.min(y).max(x.max(y).min(z)), x.max(y).max(z));
    node.slimness = if longest > 0.0 { middle / longest } else { 1.0 };
    let area = 8.0 * (x * y + y * z + z * x);
    // Not the square root of `libm`: its instruction stalls AVX code for a hundred cycles.
    [node.size, ..] = f32x4::splat(area).sqrt().to_array();
}
