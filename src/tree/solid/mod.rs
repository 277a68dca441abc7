//! Closedness: the components of a surface, their open edges, volumes and orientation.
//!
//! Edges are compared by the positions of their ends. Two triangles that use an edge in opposite
//! directions are joined across it. An edge is balanced if it is used as often in one direction as
//! in the other. A component is closed if all its edges are balanced; then a point that is not on
//! it has a whole winding number.
//!
//! The neighbors ([`adjacency`]) are edges of equal vertex indices, two by two. Pairs of
//! opposite directions are balanced. What is left (seams, soups, open edges) is sorted by position.
//! An indexed closed mesh leaves nothing. `O(n log n)` at worst.

pub(crate) mod adjacency;
pub(crate) mod convex;
pub(crate) mod extremes;
pub(crate) mod inside;
pub(crate) mod local_ray;
pub(crate) mod mass;

use crate::mesh::Mesh;
use crate::sets::{find, unite};
use crate::tree::Tree;
use alloc::boxed::Box;
use alloc::vec::Vec;
use convex::{Convex, convex};
use core::cmp::Ordering;
use core::fmt;
use glam::DVec3;
use punctual_geom::largest;
use punctual_geom::named;

/// What the mesh of a tree bounds. Asked for mesh by mesh, because rooms, terrain and shells bound
/// nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Solid {
    /// A surface without an inside.
    #[default]
    No,
    /// A solid, oriented as the triangles are. [`Tree::checked_solid`] refuses components that are
    /// inside out.
    Keep,
    /// A solid. The triangles of components that are inside out are reversed: their second and
    /// third corners change places. A refit reverses nothing.
    Flip,
}

named!(Solid { No => "no", Keep => "keep", Flip => "flip" });

/// The closedness of a solid: [`Tree::solid`].
#[derive(Clone, Debug, PartialEq)]
pub struct Solidity {
    components: Box<[Component]>,
    /// Component of each triangle, in tree order. Empty if there is only one component.
    component_of: Box<[u32]>,
    /// Vertices of open edges, one of each position.
    rim: Box<[u32]>,
    /// The edges that are used once more in this direction than in the other: indices of the rim.
    open: Box<[[u32; 2]]>,
    /// The convex components, by index; `None` for others.
    convex: Box<[Option<Convex>]>,
}

/// A connected component: triangles joined across edges.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Component {
    /// Number of triangles.
    pub triangles: usize,
    /// Its triangle with the least id.
    pub first_triangle: u32,
    /// Number of directed edges without an opposite one; 0 if the component is closed.
    pub open_edges: usize,
    /// Signed volume, in the mesh's unit of length cubed: negative if the triangles face inwards.
    /// Of an open component, the volume after a cone closes it, whose apex is the mean of the ends
    /// of its open edges. Off by at most 1e-12 of the volume of the mesh's box; infinite or 0 where
    /// `f64` does not suffice.
    pub volume: f64,
    /// True if the component and all closed ones together have a negative winding number on one
    /// side of it. A cavity is not inside out: its volume is negative, but the solid around it adds
    /// one.
    pub inside_out: bool,
}

impl Component {
    /// True if every edge is used as often in one direction as in the other.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0
    }
}

/// Reasons why [`Tree::checked_solid`] and [`Tree::mass_properties`] refuse a tree.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SolidError {
    /// The build did not ask for a solid ([`super::BuildOptions::solid`]).
    NotSolid,
    /// A component is inside out.
    InsideOut {
        /// Index of the component.
        component: usize,
        /// Its triangle with the least id.
        triangle: u32,
        /// Its signed volume.
        volume: f64,
    },
    /// The solid is not closed, so it has no mass.
    Open {
        /// Number of directed edges without an opposite one.
        edges: usize,
        /// The vertices of one of them.
        edge: [u32; 2],
    },
    /// The tree has a radius, and integrals over a thickened solid are not known.
    Thickened {
        /// The radius.
        radius: f64,
    },
    /// The volume is 0, within rounding, or too large or small for `f64`.
    NoVolume {
        /// The computed volume.
        volume: f64,
    },
}

impl fmt::Display for SolidError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSolid => {
                f.write_str("the tree was not built as a solid, see `BuildOptions::solid`")
            }
            Self::InsideOut {
                component,
                triangle,
                volume,
            } => write!(
                f,
                "component {component}, of triangle {triangle}, is inside out: its volume is {volume}"
            ),
            Self::Open {
                edges,
                edge: [from, to],
            } => write!(
                f,
                "the solid has {edges} open edges, one from vertex {from} to vertex {to}"
            ),
            Self::Thickened { radius } => write!(
                f,
                "the mass of a solid thickened by a radius, here {radius}, is not computed"
            ),
            Self::NoVolume { volume } => {
                write!(f, "the solid has no volume within rounding: {volume}")
            }
        }
    }
}

impl core::error::Error for SolidError {}

impl Solidity {
    /// The components, in the order of their first triangles.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// True if all components are closed. An empty mesh is.
    pub fn is_closed(&self) -> bool {
        self.open.is_empty()
    }

    /// Number of directed edges without an opposite one.
    pub fn open_edges(&self) -> usize {
        self.open.len()
    }

    /// Sum of the signed volumes of the components.
    pub fn volume(&self) -> f64 {
        self.components.iter().map(|one| one.volume).sum()
    }

    /// Refuses the first component that is inside out.
    pub(crate) fn check(&self) -> Result<(), SolidError> {
        let fault = (0..).zip(&self.components).find(|(_, one)| one.inside_out);
        fault.map_or(Ok(()), |(component, one)| {
            Err(SolidError::InsideOut {
                component,
                triangle: one.first_triangle,
                volume: one.volume,
            })
        })
    }

    /// The vertices of open edges, one of each position, and the edges as indices of these.
    pub(crate) fn rim(&self) -> (&[u32], &[[u32; 2]]) {
        (&self.rim, &self.open)
    }

    /// Component of a triangle (tree order).
    pub(crate) fn component_of(&self, triangle: u32) -> u32 {
        of(&self.component_of, triangle as usize) as u32
    }

    /// The convex components, by index; `None` for others.
    pub fn convex(&self) -> &[Option<Convex>] {
        &self.convex
    }

    pub(crate) fn bytes(&self) -> usize {
        let convex = self.convex.iter().flatten();
        size_of_val(&*self.components)
            + size_of_val(&*self.component_of)
            + size_of_val(&*self.open)
            + size_of_val(&*self.convex)
            + convex.map(|one| size_of_val(&*one.corners)).sum::<usize>()
    }

    /// The closedness of a tree. `O(n log n)`; `O(n)` if few edges differ in vertex indices.
    pub(crate) fn of(tree: &Tree) -> Self {
        let mut sets: Vec<u32> = (0..tree.corners.len() as u32).collect();
        let loose = loose_edges(tree, &mut sets);
        let boundary = balance(tree, loose, &mut sets);
        let (component_of, mut components) = components(&mut sets, &tree.ids);
        for &(_, edge) in &boundary {
            components[of(&component_of, edge as usize / 3)].open_edges += 1;
        }
        let (rim, open) = welded(&tree.mesh, &boundary);
        let sizes = volumes(tree, &component_of, &mut components, &boundary);
        let mut solid = Self {
            components: components.into(),
            component_of: component_of.into(),
            rim,
            open,
            convex: Box::default(),
        };
        solid.find_inside_out(tree, &sizes);
        solid.convex = convex(tree, &solid);
        solid
    }

    /// Sets which components are inside out. `sizes`: bounds of the errors of their volumes.
    /// Without a negative volume there is none.
    fn find_inside_out(&mut self, tree: &Tree, sizes: &[[f64; 2]]) {
        if sizes.iter().all(|&[volume, error]| volume >= -error) {
            return;
        }
        let found: Vec<bool> = (0u32..)
            .zip(sizes)
            .map(|(index, &[volume, error])| {
                let within = if volume > error { 1 } else { -1 };
                volume.abs() > error && {
                    let first = self.components[index as usize].first_triangle;
                    let corner = tree.mesh.triangle(first as usize)[0];
                    let counts = |triangle| {
                        let other = self.component_of(triangle);
                        other != index && self.components[other as usize].is_closed()
                    };
                    let around = inside::crossings(tree, corner, counts).winding;
                    around.min(around + within) < 0
                }
            })
            .collect();
        for (component, inside_out) in self.components.iter_mut().zip(found) {
            component.inside_out = inside_out;
        }
    }
}

impl Tree {
    /// The closedness of the solid; `None` if the build did not ask for a solid
    /// ([`super::BuildOptions::solid`]). A refit computes it anew, from the new positions.
    ///
    /// ```
    /// use punctual::tree::Solid;
    /// use punctual::{BuildOptions, Tree, shapes};
    /// let options = BuildOptions::default().solid(Solid::Keep);
    /// let ball = Tree::with_options(shapes::icosphere(3), &options);
    /// let solid = ball.solid().expect("asked for");
    /// assert!(solid.is_closed() && solid.components()[0].volume > 4.0);
    /// ```
    pub fn solid(&self) -> Option<&Solidity> {
        self.solid.as_ref()
    }

    /// Returns the tree if it is a solid that is nowhere inside out. It may have open edges.
    ///
    /// # Errors
    /// The first component that is inside out, or that the build did not ask for a solid.
    pub fn checked_solid(self) -> Result<Self, SolidError> {
        self.solid.as_ref().ok_or(SolidError::NotSolid)?.check()?;
        Ok(self)
    }

    /// Computes the closedness that `solid` asks for, and reverses components that are inside out
    /// if it asks for that.
    pub(crate) fn make_solid(&mut self, solid: Solid) {
        if solid == Solid::No {
            return;
        }
        let found = Solidity::of(self);
        let flips = solid == Solid::Flip && found.components.iter().any(|one| one.inside_out);
        if flips {
            let reversed: Vec<bool> = (0..self.ids.len() as u32)
                .map(|at| found.components[found.component_of(at) as usize].inside_out)
                .collect();
            self.reverse(&reversed);
        }
        self.solid = Some(if flips { Solidity::of(self) } else { found });
    }

    /// Reverses the triangles (tree order) that are marked. Boxes do not change.
    fn reverse(&mut self, marked: &[bool]) {
        let chosen = || (0..marked.len()).filter(|&at| marked[at]);
        chosen().for_each(|at| self.corners[at].swap(1, 2));
        self.mesh.reverse(chosen().map(|at| self.ids[at] as usize));
        self.unit
            .place(&self.mesh, &self.corners, &mut self.triangles);
        self.neighbors = adjacency::neighbors(&self.corners, &self.nodes);
    }
}

/// The component of a triangle, if that of each is known or there is only one.
fn of(component_of: &[u32], triangle: usize) -> usize {
    component_of.get(triangle).map_or(0, |&of| of as usize)
}

/// The components of disjoint sets of triangles (tree order), in the order of their least ids, and
/// the component of each triangle; of none if there is only one.
fn components(sets: &mut [u32], ids: &[u32]) -> (Vec<u32>, Vec<Component>) {
    const NONE: u32 = u32::MAX;
    let mut at_id = alloc::vec![0u32; ids.len()];
    (0..).zip(ids).for_each(|(at, &id)| at_id[id as usize] = at);
    let mut component_of = alloc::vec![NONE; ids.len()];
    let mut components: Vec<Component> = Vec::new();
    for (first_triangle, at) in (0..).zip(at_id) {
        let root = find(sets, at) as usize;
        if component_of[root] == NONE {
            component_of[root] = components.len() as u32;
            components.push(Component {
                triangles: 0,
                first_triangle,
                open_edges: 0,
                volume: 0.0,
                inside_out: false,
            });
        }
        component_of[at as usize] = component_of[root];
        components[component_of[root] as usize].triangles += 1;
    }
    if components.len() == 1 {
        component_of = Vec::new();
    }
    (component_of, components)
}

/// An edge that no neighbor balances.
#[derive(Clone, Copy)]
struct Loose {
    /// Hash of its ends, the same in both directions.
    key: u64,
    /// 3 triangle (tree order) + the index of the corner where it begins.
    edge: u32,
}

/// Joins neighbors, and returns the edges that are not balanced by a neighbor.
fn loose_edges(tree: &Tree, sets: &mut [u32]) -> Vec<Loose> {
    let corners = &tree.corners;
    let mut loose = Vec::new();
    for (triangle, ends) in (0u32..).zip(corners) {
        for k in 0..3 {
            let [from, to] = [ends[k], ends[(k + 1) % 3]];
            match tree.across(triangle, k) {
                None => loose.push(3 * triangle + k as u32),
                // Both edges were handled with that triangle.
                Some(next) if next < triangle => {}
                Some(next) => {
                    let [p, q, r] = corners[next as usize];
                    let edges = [[p, q], [q, r], [r, p]];
                    if edges.contains(&[to, from]) {
                        unite(sets, triangle, next);
                    } else {
                        let there = edges.iter().position(|edge| *edge == [from, to]);
                        loose.push(3 * triangle + k as u32);
                        loose.extend(there.map(|there| 3 * next + there as u32));
                    }
                }
            }
        }
    }
    let key = |edge: u32| {
        let [from, to] = ends(tree, edge).map(|vertex| position(&tree.mesh, vertex));
        let key = hash(from).wrapping_add(hash(to));
        (from != to).then_some(Loose { key, edge })
    };
    loose.into_iter().filter_map(key).collect()
}

/// The vertices of an edge.
pub(crate) fn ends(tree: &Tree, edge: u32) -> [u32; 2] {
    let (corners, k) = (tree.corners[edge as usize / 3], edge as usize % 3);
    [corners[k], corners[(k + 1) % 3]]
}

/// The coordinates of a vertex as bits: equal if the positions are equal.
pub(crate) fn position(mesh: &Mesh, vertex: u32) -> [u64; 3] {
    // Adding zero makes a positive zero of a negative one.
    (mesh.vertex(vertex as usize) + DVec3::ZERO)
        .to_array()
        .map(f64::to_bits)
}

/// Mixes well, because sums of hashes are compared: with a simpler hash, sums of different points
/// of a grid would often agree.
fn hash([x, y, z]: [u64; 3]) -> u64 {
    let turned = x ^ y.rotate_left(21) ^ z.rotate_left(42);
    let mixed = turned
        .wrapping_add(x ^ z >> 7)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ y;
    let mixed = (mixed ^ mixed >> 32).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ mixed >> 29).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ mixed >> 32
}

/// Sorts edges by their keys: first into lists of a few, then each list.
fn sorted(loose: Vec<Loose>) -> Vec<Loose> {
    let shift = 64 - (loose.len() / 8).max(2).ilog2();
    let list = |edge: &Loose| (edge.key >> shift) as usize;
    let mut ends = alloc::vec![0usize; (1 << (64 - shift)) + 1];
    loose.iter().for_each(|edge| ends[list(edge) + 1] += 1);
    for i in 1..ends.len() {
        ends[i] += ends[i - 1];
    }
    let mut sorted = alloc::vec![Loose { key: 0, edge: 0 }; loose.len()];
    let mut next = ends.clone();
    for edge in loose {
        let at = &mut next[list(&edge)];
        sorted[*at] = edge;
        *at += 1;
    }
    for i in 1..ends.len() {
        sorted[ends[i - 1]..ends[i]].sort_unstable_by_key(|edge| edge.key);
    }
    sorted
}

/// Joins triangles that share a loose edge. Returns the edges that are used more often in one
/// direction than in the other, with the number of a loose edge of each. An edge occurs once for
/// each use by which the directions differ.
fn balance(tree: &Tree, loose: Vec<Loose>, sets: &mut [u32]) -> Vec<([u32; 2], u32)> {
    let positions = |edge: u32| ends(tree, edge).map(|vertex| position(&tree.mesh, vertex));
    let unordered = |edge: u32| {
        let [from, to] = positions(edge);
        [from.min(to), from.max(to)]
    };
    let mut open = Vec::new();
    let mut settle = |group: &[Loose]| {
        let (mut surplus, mut chosen) = (0i64, [u32::MAX; 2]);
        for &Loose { edge, .. } in group {
            unite(sets, group[0].edge / 3, edge / 3);
            let is_forward = is_forward(positions(edge));
            surplus += i64::from(is_forward) * 2 - 1;
            let chosen = &mut chosen[usize::from(is_forward)];
            *chosen = edge.min(*chosen);
        }
        let edge = chosen[usize::from(surplus > 0)];
        open.extend((0..surplus.abs()).map(|_| (ends(tree, edge), edge)));
    };
    let mut loose = sorted(loose);
    for group in loose.chunk_by_mut(|one, other| one.key == other.key) {
        let first = unordered(group[0].edge);
        if group[1..]
            .iter()
            .all(|other| unordered(other.edge) == first)
        {
            settle(group);
        } else {
            // Different edges with one hash.
            group.sort_unstable_by_key(|one| unordered(one.edge));
            group
                .chunk_by(|one, other| unordered(one.edge) == unordered(other.edge))
                .for_each(&mut settle);
        }
    }
    // By triangle: edges that follow each other are often close.
    open.sort_unstable_by_key(|&(_, edge)| edge);
    open
}

/// The vertices of edges, one of each position, and the edges as indices of these.
fn welded(mesh: &Mesh, edges: &[([u32; 2], u32)]) -> (Box<[u32]>, Box<[[u32; 2]]>) {
    let of = |vertex: u32| position(mesh, vertex);
    let mut rim: Vec<([u64; 3], u32)> = edges
        .iter()
        .flat_map(|(ends, _)| ends.map(|vertex| (of(vertex), vertex)))
        .collect();
    rim.sort_unstable();
    rim.dedup_by_key(|(at, _)| *at);
    let index = |vertex: u32| {
        let at = of(vertex);
        rim.partition_point(|(other, _)| *other < at) as u32
    };
    let open = edges.iter().map(|(ends, _)| ends.map(index)).collect();
    let rim: Box<[u32]> = rim.into_iter().map(|(_, vertex)| vertex).collect();
    (rim, open)
}

fn is_forward([from, to]: [[u64; 3]; 2]) -> bool {
    from.cmp(&to) == Ordering::Less
}

/// Computes the volumes of components. Returns each in units with a bound of its error.
fn volumes(
    tree: &Tree,
    component_of: &[u32],
    components: &mut [Component],
    boundary: &[([u32; 2], u32)],
) -> Vec<[f64; 2]> {
    let (mesh, unit) = (&tree.mesh, &tree.unit);
    let point = |vertex: u32| unit.point(mesh.vertex(vertex as usize));
    let mut apexes: Vec<DVec3> = components
        .iter()
        .map(|one| match one.open_edges {
            0 => unit.point(mesh.triangle(one.first_triangle as usize)[0]),
            _ => DVec3::ZERO,
        })
        .collect();
    for &([from, to], edge) in boundary {
        let component = of(component_of, edge as usize / 3);
        let share = 0.5 / components[component].open_edges as f64;
        apexes[component] += share * (point(from) + point(to));
    }
    let mut sums = alloc::vec![[0.0, 0.0]; components.len()];
    for (triangle, corners) in tree.corners.iter().enumerate() {
        let component = of(component_of, triangle);
        let [a, b, c] = corners.map(|vertex| point(vertex) - apexes[component]);
        let sum = &mut sums[component];
        sum[0] += a.dot(b.cross(c));
        sum[1] += largest(a.abs()) * largest(b.abs()) * largest(c.abs());
    }
    let cube = unit.length() * unit.length() * unit.length();
    for (component, sum) in components.iter_mut().zip(&mut sums) {
        let count = component.triangles as f64;
        *sum = [sum[0] / 6.0, (32.0 + count) * f64::EPSILON * sum[1]];
        component.volume = sum[0] * cube;
    }
    sums
}
