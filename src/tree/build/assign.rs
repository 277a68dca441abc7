//! Chooses an orientation for each node: computes moments bottom-up, then chooses top-down. `O(n)`.

use super::axes::{Candidates, Leaf};
use super::collapse::{Inner, Part, Plan};
use super::moments::{Moments, Surfaces};
use super::orientation::{MESH_ORIENTATION, Orientation};
use crate::tree::fork::{Pieces, split};
use crate::tree::unit::Triangle;
use crate::tree::wide::Node;
use alloc::vec::Vec;
use core::ops::Range;
use core::slice;
use punctual_geom::lanes::{F8, Instructions, Kernel, Lanes, per_axis};

/// Gives each node of `plan` its best orientation.
pub(crate) fn choose_orientations(
    plan: &mut Plan,
    triangles: &[Triangle],
    parts: &[Part],
    pieces: Pieces,
) {
    let instructions = Instructions::detect();
    let above = above(parts, plan.inner.len());
    let mut families = alloc::vec![Moments::default(); plan.inner.len()];

    let gather = |numbers: &[Range<usize>], families: &mut [Moments], first: usize| {
        instructions.run(Gather {
            plan,
            triangles,
            numbers,
            families,
            first,
        });
    };
    let of_parts = split(&mut families, parts.iter().map(|part| part.inner.clone()));
    pieces.each(parts.iter().zip(of_parts).collect(), |(part, families)| {
        gather(slice::from_ref(&part.inner), families, part.inner.start);
    });
    gather(&above, &mut families, 0);

    let Plan { nodes, inner } = plan;
    let choose = |numbers: &[Range<usize>], nodes: &mut [Node], first: usize| {
        instructions.run(Choose {
            inner,
            families: &families,
            triangles,
            numbers,
            nodes,
            first,
        });
    };
    choose(&above, nodes, 0);
    let of_parts = split(nodes, parts.iter().map(|part| part.nodes.clone()));
    pieces.each(parts.iter().zip(of_parts).collect(), |(part, nodes)| {
        choose(slice::from_ref(&part.inner), nodes, part.nodes.start);
    });
}

/// Numbers of the inner nodes outside all parts.
fn above(parts: &[Part], count: usize) -> Vec<Range<usize>> {
    let starts = parts.iter().map(|part| part.inner.start).chain([count]);
    let ends = [0]
        .into_iter()
        .chain(parts.iter().map(|part| part.inner.end));
    ends.zip(starts).map(|(end, start)| end..start).collect()
}

/// Bottom-up pass: computes for each inner node its family, the moments of its children.
struct Gather<'p> {
    plan: &'p Plan,
    triangles: &'p [Triangle],
    /// Numbers of the inner nodes to process.
    numbers: &'p [Range<usize>],
    /// Families of the inner nodes from number `first` on.
    families: &'p mut [Moments],
    first: usize,
}

impl Kernel for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self {
            plan: Plan { nodes, inner },
            triangles,
            numbers,
            families,
            first,
        } = self;
        for numbers in numbers.iter().rev() {
            for number in numbers.clone().rev() {
                let mut family = Moments::default();
                let mut next = number + 1;
                for (lane, child) in nodes[nodes[inner[number].node as usize].child_range()]
                    .iter()
                    .enumerate()
                {
                    if child.is_leaf {
                        let range = child.triangle_range();
                        let start = range.start;
                        family.set(
                            lanes,
                            lane,
                            &Surfaces::of_triangles(lanes, &triangles[range], start),
                        );
                    } else {
                        family.set(lanes, lane, &Surfaces::load(lanes, &families[next - first]));
                        next += inner[next].count as usize;
                    }
                }
                families[number - first] = family;
            }
        }
    }
}

/// Top-down pass: chooses the orientations of the children of the given inner nodes. Their own
/// orientations must be chosen before. If the nodes include node 0, the root, its orientation is
/// chosen first.
struct Choose<'p> {
    inner: &'p [Inner],
    families: &'p [Moments],
    triangles: &'p [Triangle],
    /// Numbers of the inner nodes to process.
    numbers: &'p [Range<usize>],
    /// The nodes from number `first` on.
    nodes: &'p mut [Node],
    first: usize,
}

impl Kernel for Choose<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        if self.first == 0 {
            self.root(lanes);
        }
        for numbers in self.numbers {
            for number in numbers.clone() {
                let parent = &self.nodes[self.inner[number].node as usize - self.first];
                let (parent, range) = (parent.orientation(), parent.child_range());
                let family = Surfaces::load(lanes, &self.families[number]);
                self.siblings(lanes, &family, parent, range, number + 1);
            }
        }
    }
}

impl Choose<'_> {
    #[inline(always)]
    fn root<L: Lanes>(&mut self, lanes: L) {
        let whole = match self.families.first() {
            Some(family) => Surfaces::load(lanes, family),
            None if self.triangles.is_empty() => return,
            None => Surfaces::of_triangles(lanes, self.triangles, 0),
        };
        let mut alone = Moments::default();
        alone.set(lanes, 0, &whole);
        self.siblings(
            lanes,
            &Surfaces::load(lanes, &alone),
            Orientation::IDENTITY,
            0..1,
            0,
        );
    }

    /// Chooses the orientations of the nodes in `range`. `family` is their moments, and `parent`
    /// the orientation that they have if they get no other. `next` is the number of the first inner
    /// node among them.
    #[inline(always)]
    fn siblings<L: Lanes>(
        &mut self,
        lanes: L,
        family: &Surfaces<L>,
        parent: Orientation,
        range: Range<usize>,
        mut next: usize,
    ) {
        let candidates = Candidates::of(lanes, family, self.triangles);
        let columns = parent.rotation.to_cols_array_2d();
        let own = per_axis!(i => per_axis!(j => F8::splat(lanes, columns[i][j])));
        for (lane, index) in range.enumerate() {
            let node = &mut self.nodes[index - self.first];
            let costs = if node.is_leaf {
                candidates.costs(
                    lanes,
                    lane,
                    &own,
                    &Leaf::of(lanes, &self.triangles[node.triangle_range()]),
                )
            } else {
                let family = Surfaces::load(lanes, &self.families[next]);
                next += self.inner[next].count as usize;
                candidates.costs(lanes, lane, &own, &family)
            };
            let id = MESH_ORIENTATION + 1 + index as u32;
            let best = candidates.best(lane, &costs);
            node.set_orientation(&best.map_or(parent, |axes| Orientation::of(&axes, id)));
        }
    }
}
