//! Closedness: the components of a surface, their open edges, volumes and orientation.
//!
//! Edges are compared by the positions of their ends. Two triangles that use an edge in opposite
//! directions are joined across it. An edge is balanced if it is used as often in one direction as
//! in the other. A component is closed if all its edges are balanced; then a point that is not on
//! it has a whole winding number.
//!
//! The neighbors ([`super::adjacency`]) are edges of equal vertex indices, two by two. Pairs of
//! opposite directions are balanced. What is left (seams, soups, open edges) is sorted by position.
//! An indexed closed mesh leaves nothing. `O(n log n)` at worst.

use super::{Tree, inside};
use crate::mesh::Mesh;
use crate::names::named;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::cmp::Ordering;
use core::fmt;
use glam::DVec3;

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
    /// third corners change places.
    Flip,
}

named!(Solid { No => "no", Keep => "keep", Flip => "flip" });

/// The closedness of a solid: [`Tree::solid`].
#[derive(Clone, Debug, PartialEq)]
pub struct Solidity {
    components: Box<[Component]>,
    /// Component of each triangle, in tree order. Empty if there is only one component.
    component_of: Box<[u32]>,
    /// The edges that are used once more in this direction than in the other: vertex indices.
    open: Box<[[u32; 2]]>,
}

/// Triangles that hang together across edges.
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
    /// True if the winding number would be negative on one side of it. A cavity is not inside out:
    /// its volume is negative, but the solid around it adds one.
    pub inside_out: bool,
}

impl Component {
    /// True if every edge is used as often in one direction as in the other.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0
    }
}

/// Reasons why [`Tree::checked_solid`] refuses a tree.
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
}

impl fmt::Display for SolidError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSolid => f.write_str("the tree was not built as a solid"),
            Self::InsideOut {
                component,
                triangle,
                volume,
            } => write!(
                f,
                "component {component}, of triangle {triangle}, is inside out: its volume is {volume}"
            ),
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

    /// Edges without an opposite one, as vertex indices: the boundary of the surface.
    pub(crate) fn boundary(&self) -> &[[u32; 2]] {
        &self.open
    }

    /// Component of a triangle (tree order).
    pub(crate) fn component_of(&self, triangle: u32) -> u32 {
        let of = self.component_of.get(triangle as usize);
        of.copied().unwrap_or(0)
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.components) + size_of_val(&*self.component_of) + size_of_val(&*self.open)
    }

    /// The closedness of a tree. `O(n log n)`; `O(n)` if few edges differ in vertex indices.
    pub(super) fn of(tree: &Tree) -> Self {
        let mut sets = Sets::new(tree.corners.len());
        let mut loose = loose_edges(tree, &mut sets);
        let boundary = balance(tree, &mut loose, &mut sets);
        let (component_of, mut components) = sets.components(&tree.ids);
        let count = components.len();
        for &(_, edge) in &boundary {
            components[component_of[edge as usize / 3] as usize].open_edges += 1;
        }
        let open: Box<[[u32; 2]]> = boundary.iter().map(|&(ends, _)| ends).collect();
        let sizes = volumes(tree, &component_of, &mut components, &boundary);
        let mut solid = Self {
            components: components.into(),
            component_of: if count > 1 {
                component_of.into()
            } else {
                Box::default()
            },
            open,
        };
        solid.find_inside_out(tree, &sizes);
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
                    let around =
                        inside::crossings(tree, corner, |t| self.component_of(t) != index).winding;
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
    /// use punctual::{BuildOptions, Solid, Tree, shapes};
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
        let solid = self.solid.as_ref().ok_or(SolidError::NotSolid)?;
        let fault = (0..).zip(&solid.components).find(|(_, one)| one.inside_out);
        match fault {
            None => Ok(self),
            Some((component, one)) => Err(SolidError::InsideOut {
                component,
                triangle: one.first_triangle,
                volume: one.volume,
            }),
        }
    }

    /// Computes the closedness that `solid` asks for, and reverses what is inside out if it says
    /// so.
    pub(super) fn make_solid(&mut self, solid: Solid) {
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
        self.neighbors = super::adjacency::neighbors(&self.corners, &self.nodes);
    }
}

/// Disjoint sets of triangles (tree order).
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn root(&mut self, mut at: u32) -> u32 {
        let parents = &mut self.0;
        while parents[at as usize] != at {
            parents[at as usize] = parents[parents[at as usize] as usize];
            at = parents[at as usize];
        }
        at
    }

    fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.root(one), self.root(other));
        self.0[one.max(other) as usize] = one.min(other);
    }

    /// Component of each triangle, and the components, in the order of their least ids.
    fn components(mut self, ids: &[u32]) -> (Vec<u32>, Vec<Component>) {
        let mut roots = Vec::new();
        for at in 0..ids.len() as u32 {
            let root = self.root(at);
            self.0[at as usize] = root;
            if root == at {
                roots.push((u32::MAX, at, 0));
            }
        }
        // The roots are in ascending order, so a root's slot is found by its rank.
        let mut rank = alloc::vec![0; ids.len()];
        (0..)
            .zip(&roots)
            .for_each(|(i, &(_, root, _))| rank[root as usize] = i);
        for (&root, &id) in self.0.iter().zip(ids) {
            let (least, _, count) = &mut roots[rank[root as usize]];
            *least = id.min(*least);
            *count += 1;
        }
        roots.sort_unstable();
        (0..)
            .zip(&roots)
            .for_each(|(i, &(_, root, _))| rank[root as usize] = i);
        let of = self.0.iter().map(|&root| rank[root as usize] as u32);
        let components = roots
            .iter()
            .map(|&(first_triangle, _, triangles)| Component {
                triangles,
                first_triangle,
                open_edges: 0,
                volume: 0.0,
                inside_out: false,
            });
        (of.collect(), components.collect())
    }
}

/// An edge that no neighbor balances.
struct Loose {
    /// Hash of its ends, the same in both directions.
    key: u64,
    /// 3 triangle (tree order) + the index of the corner where it begins.
    edge: u32,
}

/// Joins neighbors, and returns the edges that are not balanced by a neighbor.
fn loose_edges(tree: &Tree, sets: &mut Sets) -> Vec<Loose> {
    let mut loose = Vec::new();
    for (triangle, corners) in (0u32..).zip(&tree.corners) {
        for k in 0..3 {
            let [from, to] = [corners[k], corners[(k + 1) % 3]];
            let opposite = tree.across(triangle, k).filter(|&next| {
                let [p, q, r] = tree.corners[next as usize];
                [[p, q], [q, r], [r, p]].contains(&[to, from])
            });
            if let Some(next) = opposite {
                if next > triangle {
                    sets.join(triangle, next);
                }
                continue;
            }
            let [from, to] = [from, to].map(|vertex| position(&tree.mesh, vertex));
            if from != to {
                loose.push(Loose {
                    key: hash(from).wrapping_add(hash(to)),
                    edge: 3 * triangle + k as u32,
                });
            }
        }
    }
    loose
}

/// The coordinates of a vertex as bits: equal if the positions are equal.
fn position(mesh: &Mesh, vertex: u32) -> [u64; 3] {
    // Adding zero makes a positive zero of a negative one.
    (mesh.vertex(vertex as usize) + DVec3::ZERO)
        .to_array()
        .map(f64::to_bits)
}

fn hash(position: [u64; 3]) -> u64 {
    position.into_iter().fold(0, |hash, bits| {
        let mixed = (hash ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ mixed >> 32
    })
}

/// Joins triangles that share a loose edge. Returns the edges that are used more often in one
/// direction than in the other, as often as that, with the number of a loose edge of each.
fn balance(tree: &Tree, loose: &mut [Loose], sets: &mut Sets) -> Vec<([u32; 2], u32)> {
    let ends = |edge: u32| {
        let (corners, k) = (tree.corners[edge as usize / 3], edge as usize % 3);
        [corners[k], corners[(k + 1) % 3]]
    };
    let positions = |edge: &Loose| ends(edge.edge).map(|vertex| position(&tree.mesh, vertex));
    let sorted = |edge: &Loose| {
        let [from, to] = positions(edge);
        [from.min(to), from.max(to)]
    };
    loose.sort_unstable_by(|one, other| {
        one.key.cmp(&other.key).then_with(|| {
            sorted(one)
                .cmp(&sorted(other))
                .then(one.edge.cmp(&other.edge))
        })
    });
    let mut open = Vec::new();
    for group in loose.chunk_by(|one, other| one.key == other.key && sorted(one) == sorted(other)) {
        let mut surplus = 0i64;
        for edge in group {
            sets.join(group[0].edge / 3, edge.edge / 3);
            surplus += i64::from(is_forward(positions(edge))) * 2 - 1;
        }
        let one = group
            .iter()
            .find(|edge| is_forward(positions(edge)) == (surplus > 0));
        if let Some(one) = one {
            open.extend((0..surplus.abs()).map(|_| (ends(one.edge), one.edge)));
        }
    }
    // By triangle: edges that follow each other are often close.
    open.sort_unstable_by_key(|&(_, edge)| edge);
    open
}

fn is_forward([from, to]: [[u64; 3]; 2]) -> bool {
    from.cmp(&to) == Ordering::Less
}

/// Computes the volumes of components. Returns each in units with a bound of its error.
fn volumes(
    tree: &Tree,
    of: &[u32],
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
        let component = of[edge as usize / 3] as usize;
        let share = 0.5 / components[component].open_edges as f64;
        apexes[component] += share * (point(from) + point(to));
    }
    let mut sums = alloc::vec![[0.0, 0.0]; components.len()];
    for (corners, &component) in tree.corners.iter().zip(of) {
        let [a, b, c] = corners.map(|vertex| point(vertex) - apexes[component as usize]);
        let normal = b.cross(c);
        let sum = &mut sums[component as usize];
        sum[0] += a.dot(normal);
        sum[1] += a.length() * normal.length();
    }
    let cube = unit.length() * unit.length() * unit.length();
    for (component, sum) in components.iter_mut().zip(&mut sums) {
        let count = component.triangles as f64;
        *sum = [sum[0] / 6.0, (16.0 + count) * f64::EPSILON * sum[1]];
        component.volume = sum[0] * cube;
    }
    sums
}
