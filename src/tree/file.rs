//! A tree as bytes: shipped with a program, it need not be built there.
//!
//! The bytes contain what the build decided: the mesh, the order of the triangles, the structure of
//! the nodes, and the orientations that differ from the parent's. Boxes and profiles follow from
//! these. Loading computes them by the pass that also ends a build ([`super::update`]). So the
//! loaded tree equals the saved one to the bit, and a file cannot state a box that is too small.
//!
//! Everything that the file states is checked. Bytes with wrong content and a correct checksum are
//! either refused, or they are another valid tree of the mesh that they contain, with true answers.
//!
//! All numbers little-endian:
//!
//! | bytes | content |
//! |---:|---|
//! | 8 | `PUNCTREE` |
//! | 4 | version: 2 for a solid, else 1 |
//! | 4 | bytes of a coordinate, 4 or 8; + 512 if extremes are kept; + 1024 for a solid; + 256 is ignored |
//! | 4 x 8 | numbers of vertices, triangles, nodes, and orientations |
//! | 4 | SAH cost after the build, `f32` |
//! | 12 or 24 a vertex | coordinates |
//! | 12 a triangle | vertex indices |
//! | 4 a triangle | its index in the mesh, in tree order |
//! | 1 a node | number of children; + 16 if they are triangles; + 32 if it has an orientation |
//! | 36 an orientation | columns of the rotation, `f32`, in the order of the nodes |
//! | 4 | CRC-32 (ISO-HDLC, as in zip and png) of all bytes before |
//!
//! A node without an orientation has that of its parent. Nodes are in the order of the tree: the
//! root, its children, then the nodes below each child in turn. So the numbers of children
//! determine all indices, and no index can lead in a circle.

use super::binary::most_depth;
use super::fork::Pieces;
use super::orientation::{MESH_ORIENTATION, Orientation};
use super::place::Placed;
use super::profile::Profiles;
use super::update::update;
use super::validate::{TreeFault, dense, each_once};
use super::wide::{Node, WIDTH};
use super::{BuildOptions, Solid, Tree, Unit};
use crate::mesh::{Mesh, MeshError, TRIANGLE_BYTES};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::fmt;
use glam::{Mat3, Mat3A};

const MAGIC: [u8; 8] = *b"PUNCTREE";
const VERSION: u32 = 2;

/// Flags added to the size of a coordinate. `IGNORED` has no meaning. `HAS_EXTREMES` is set if the
/// tree keeps extremes, `IS_SOLID` if it is one of a solid; loading recomputes what they stand for.
const IGNORED: u32 = 1 << 8;
const HAS_EXTREMES: u32 = 1 << 9;
const IS_SOLID: u32 = 1 << 10;
const HEADER: usize = 52;
const CHECKSUM: usize = 4;
const ORIENTATION: usize = 36;

/// Flags added to the number of children: the children are triangles; the orientation differs from
/// the parent's.
const IS_CLUSTER: u8 = 16;
const OWN_ORIENTATION: u8 = 32;

/// Reasons why bytes cannot be loaded as a tree.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TreeFileError {
    /// The bytes do not begin with `PUNCTREE`.
    NotATree,
    /// The bytes have another format version. The tree has to be rebuilt from its mesh.
    Version {
        /// Format version of the bytes.
        found: u32,
        /// The newest supported version.
        supported: u32,
    },
    /// The number of bytes differs from the header's.
    Length {
        /// Expected number of bytes; the length of the header, if there are fewer than that.
        expected: u128,
        /// Actual number of bytes.
        found: usize,
    },
    /// The bytes were changed after they were written.
    Checksum {
        /// The last four bytes.
        stored: u32,
        /// The checksum of the bytes before them.
        computed: u32,
    },
    /// The size of a coordinate is neither 4 nor 8 bytes.
    CoordinateSize(u32),
    /// The SAH cost is negative or not finite.
    Cost(f32),
    /// The number of orientations differs from the number of nodes that need one.
    Orientations {
        /// Number of orientations in the header.
        stored: usize,
        /// Number of nodes that need one.
        needed: usize,
    },
    /// The mesh is invalid.
    Mesh(MeshError),
    /// The mesh is valid, but the rest is not a tree of it.
    Tree(TreeFault),
}

impl fmt::Display for TreeFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotATree => {
                f.write_str("these bytes are not a tree: they do not begin with PUNCTREE")
            }
            Self::Version { found, supported } => {
                write!(
                    f,
                    "the tree has format version {found}, this library reads {supported}: build it again"
                )
            }
            Self::Length { expected, found } => {
                write!(f, "the tree should have {expected} bytes, but has {found}")
            }
            Self::Checksum { stored, computed } => {
                write!(
                    f,
                    "the tree is damaged: its bytes have the checksum {computed:08x}, not {stored:08x}"
                )
            }
            Self::CoordinateSize(bytes) => {
                write!(f, "header: a coordinate of {bytes} bytes, not 4 or 8")
            }
            Self::Cost(cost) => write!(f, "header: the SAH cost {cost} is negative or not finite"),
            Self::Orientations { stored, needed } => {
                write!(f, "{stored} orientations for {needed} nodes that need one")
            }
            Self::Mesh(error) => write!(f, "the mesh of the tree: {error}"),
            Self::Tree(fault) => write!(f, "the tree: {fault}"),
        }
    }
}

impl core::error::Error for TreeFileError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Mesh(error) => Some(error),
            Self::Tree(fault) => Some(fault),
            _ => None,
        }
    }
}

impl From<MeshError> for TreeFileError {
    fn from(error: MeshError) -> Self {
        Self::Mesh(error)
    }
}

impl From<TreeFault> for TreeFileError {
    fn from(fault: TreeFault) -> Self {
        Self::Tree(fault)
    }
}

/// The contents of the header.
struct Header {
    is_f64: bool,
    has_extremes: bool,
    is_solid: bool,
    vertices: u64,
    triangles: u64,
    nodes: u64,
    orientations: u64,
    cost: f32,
}

impl Header {
    fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&MAGIC);
        // Older readers know all but solids.
        let version = if self.is_solid { VERSION } else { 1 };
        bytes.extend_from_slice(&version.to_le_bytes());
        let extremes = if self.has_extremes { HAS_EXTREMES } else { 0 };
        let flags = extremes | if self.is_solid { IS_SOLID } else { 0 };
        bytes.extend_from_slice(&(flags | if self.is_f64 { 8u32 } else { 4 }).to_le_bytes());
        for count in [self.vertices, self.triangles, self.nodes, self.orientations] {
            bytes.extend_from_slice(&count.to_le_bytes());
        }
        bytes.extend_from_slice(&self.cost.to_le_bytes());
    }

    fn read(bytes: &[u8]) -> Result<Self, TreeFileError> {
        if !bytes.starts_with(&MAGIC[..bytes.len().min(MAGIC.len())]) {
            return Err(TreeFileError::NotATree);
        }
        let Some(header) = bytes.first_chunk::<HEADER>() else {
            return Err(TreeFileError::Length {
                expected: HEADER as u128,
                found: bytes.len(),
            });
        };
        let mut words = header[MAGIC.len()..]
            .as_chunks::<4>()
            .0
            .iter()
            .map(|&word| u32::from_le_bytes(word));
        let mut word = || words.next().unwrap_or_default();
        let version = word();
        if !(1..=VERSION).contains(&version) {
            return Err(TreeFileError::Version {
                found: version,
                supported: VERSION,
            });
        }
        let kind = word();
        let known = IGNORED | HAS_EXTREMES | if version > 1 { IS_SOLID } else { 0 };
        let (size, kind) = (kind & !known, kind & known);
        let mut count = || u64::from(word()) | u64::from(word()) << 32;
        let [vertices, triangles, nodes, orientations] = [count(), count(), count(), count()];
        let cost = f32::from_bits(word());
        match size {
            4 | 8 => Ok(Self {
                is_f64: size == 8,
                has_extremes: kind & HAS_EXTREMES != 0,
                is_solid: kind & IS_SOLID != 0,
                vertices,
                triangles,
                nodes,
                orientations,
                cost,
            }),
            _ => Err(TreeFileError::CoordinateSize(size)),
        }
    }

    /// Bytes of each part after the header.
    fn parts(&self) -> [u128; 5] {
        let vertex = if self.is_f64 { 24 } else { 12 };
        let [vertices, triangles, nodes, orientations] =
            [self.vertices, self.triangles, self.nodes, self.orientations].map(u128::from);
        [
            vertex * vertices,
            TRIANGLE_BYTES as u128 * triangles,
            4 * triangles,
            nodes,
            ORIENTATION as u128 * orientations,
        ]
    }

    /// Number of bytes in total.
    fn length(&self) -> u128 {
        self.parts().iter().sum::<u128>() + (HEADER + CHECKSUM) as u128
    }
}

impl Tree {
    /// The tree as bytes for [`from_bytes`](Self::from_bytes) on any machine. A closed f32 mesh
    /// takes about 30 bytes per triangle. `O(n)`.
    ///
    /// ```
    /// use punctual::{Tree, shapes};
    /// let tree = Tree::new(shapes::icosphere(3));
    /// let loaded = Tree::from_bytes(&tree.to_bytes())?;
    /// assert_eq!(loaded.mesh(), tree.mesh());
    /// assert_eq!(loaded.stats(), tree.stats());
    /// # Ok::<(), punctual::tree::TreeFileError>(())
    /// ```
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let shapes = shapes(&self.nodes);
        let header = self.header();
        let mut bytes = Vec::with_capacity(header.length() as usize);
        header.write(&mut bytes);
        self.mesh.write(&mut bytes);
        self.ids
            .iter()
            .for_each(|id| bytes.extend_from_slice(&id.to_le_bytes()));
        bytes.extend_from_slice(&shapes);
        let own = self
            .nodes
            .iter()
            .zip(&shapes)
            .filter(|(_, shape)| *shape & OWN_ORIENTATION != 0);
        for entry in own.flat_map(|(node, _)| node.rotation().to_cols_array()) {
            bytes.extend_from_slice(&entry.to_le_bytes());
        }
        let checksum = crc32fast::hash(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// Number of bytes that [`to_bytes`](Self::to_bytes) gives. `O(n)` in the number of nodes;
    /// allocates nothing.
    pub fn bytes_len(&self) -> usize {
        self.header().length() as usize
    }

    fn header(&self) -> Header {
        Header {
            is_f64: !self.mesh.is_f32(),
            has_extremes: self.has_extremes(),
            is_solid: self.solid.is_some(),
            vertices: self.mesh.vertex_count() as u64,
            triangles: self.mesh.len() as u64,
            nodes: self.nodes.len() as u64,
            orientations: with_own_orientation(&self.nodes).count() as u64,
            cost: self.built_cost,
        }
    }

    /// Loads the tree on which [`to_bytes`](Self::to_bytes) was called. Queries of the loaded tree
    /// do exactly what those of the saved tree do, to the bit.
    ///
    /// Does not panic on any input. A tree that it returns gives true answers about the mesh that
    /// it contains.
    ///
    /// Takes at most 44 bytes of memory for each of `bytes`, because it accepts no more nodes than
    /// a build makes of as many triangles. Trees of ordinary meshes take 4 to 10. The time is that
    /// of a refit and of a pass over the bytes, less than a build: `O(n)` on average, `O(n depth)`
    /// at worst, and the depth is at most 71.
    ///
    /// # Errors
    /// The error states the fault, and the triangle, vertex or node that has it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TreeFileError> {
        let header = Header::read(bytes)?;
        let parts = header.parts();
        let expected = header.length();
        if expected != bytes.len() as u128 {
            return Err(TreeFileError::Length {
                expected,
                found: bytes.len(),
            });
        }
        let (content, checksum) = bytes
            .split_last_chunk::<CHECKSUM>()
            .unwrap_or((bytes, &[0; CHECKSUM]));
        let (stored, computed) = (u32::from_le_bytes(*checksum), crc32fast::hash(content));
        if stored != computed {
            return Err(TreeFileError::Checksum { stored, computed });
        }
        let mut rest = &content[HEADER..];
        let [vertices, triangles, order, shapes, orientations] = parts.map(|length| {
            let (part, after) = rest.split_at(length as usize);
            rest = after;
            part
        });
        let mesh = Mesh::read(vertices, header.is_f64, triangles)?;
        let ids: Box<[u32]> = order
            .as_chunks()
            .0
            .iter()
            .map(|&id| u32::from_le_bytes(id))
            .collect();
        each_once(&ids, mesh.len())?;
        let mut nodes = nodes(shapes, mesh.len(), orientations)?;
        if !(header.cost >= 0.0 && header.cost.is_finite()) {
            return Err(TreeFileError::Cost(header.cost));
        }
        let unit = Unit::of(&mesh);
        let placed = Placed::of(&mesh, unit, &ids, Pieces::ONE);
        let mut profiles = Profiles::room(&mut nodes);
        update(
            &mut nodes,
            &placed.triangles,
            &mut profiles,
            &[],
            Pieces::ONE,
        );
        let tree = Self::of_nodes(
            mesh,
            unit,
            nodes,
            profiles,
            placed,
            ids,
            &BuildOptions {
                extremes: header.has_extremes,
                solid: if header.is_solid {
                    Solid::Keep
                } else {
                    Solid::No
                },
                ..BuildOptions::default()
            },
        );
        Ok(Self {
            built_cost: header.cost,
            ..tree
        })
    }
}

/// One byte per node: the number of its children, their kind, and a flag if its orientation differs
/// from its parent's.
fn shapes(nodes: &[Node]) -> Vec<u8> {
    let shape = |node: &Node| node.children | if node.is_leaf { IS_CLUSTER } else { 0 };
    let mut shapes: Vec<u8> = nodes.iter().map(shape).collect();
    with_own_orientation(nodes).for_each(|index| shapes[index] |= OWN_ORIENTATION);
    shapes
}

/// The nodes whose orientation differs from their parent's, parent by parent.
fn with_own_orientation(nodes: &[Node]) -> impl Iterator<Item = usize> {
    let root = nodes
        .first()
        .filter(|root| root.orientation != Orientation::IDENTITY.id)
        .map(|_| 0);
    let parents = nodes.iter().filter(|node| !node.is_leaf);
    let below = move |parent: &Node| {
        let orientation = parent.orientation;
        parent
            .child_range()
            .filter(move |&child| nodes[child].orientation != orientation)
    };
    root.into_iter().chain(parents.flat_map(below))
}

/// The nodes of a tree of this many triangles, still without boxes and profiles.
fn nodes(
    shapes: &[u8],
    triangles: usize,
    orientations: &[u8],
) -> Result<Box<[Node]>, TreeFileError> {
    check_counts(shapes, triangles)?;
    let needed = shapes
        .iter()
        .filter(|&shape| shape & OWN_ORIENTATION != 0)
        .count();
    let orientations = orientations.as_chunks::<ORIENTATION>().0;
    if orientations.len() != needed {
        return Err(TreeFileError::Orientations {
            stored: orientations.len(),
            needed,
        });
    }
    let mut nodes: Box<[Node]> = shapes.iter().map(|&shape| node(shape)).collect();
    let mut orientations = orientations.iter();
    let mut orientation = |index: usize, parent: Orientation| {
        if shapes[index] & OWN_ORIENTATION == 0 {
            Ok(parent)
        } else {
            own_orientation(index, orientations.next())
        }
    };
    // Nodes to be opened, the next on top.
    let mut waiting = Vec::new();
    if let Some(root) = nodes.first_mut() {
        root.set_orientation(&orientation(0, Orientation::IDENTITY)?);
        waiting.push(0);
    }
    let (mut next_node, mut next_triangle) = (nodes.len().min(1), 0);
    while let Some(index) = waiting.pop() {
        let node = &mut nodes[index];
        node.first_triangle = next_triangle;
        if node.is_leaf {
            (node.first_child, node.triangles) = (next_triangle, node.children.into());
            next_triangle += node.triangles;
            continue;
        }
        node.first_child = next_node as u32;
        let (parent, depth, children) = (node.orientation(), node.depth + 1, node.child_range());
        if u32::from(depth) > most_depth(triangles) {
            return Err(TreeFault::Depth(children.start).into());
        }
        for child in children.clone() {
            nodes[child].depth = depth;
            nodes[child].set_orientation(&orientation(child, parent)?);
        }
        next_node = children.end;
        waiting.extend(children.rev());
    }
    if next_node != nodes.len() {
        // The first node that is not a child of any node.
        return Err(TreeFault::Children(next_node).into());
    }
    for index in (0..nodes.len()).rev() {
        if !nodes[index].is_leaf {
            nodes[index].triangles = nodes[nodes[index].child_range()]
                .iter()
                .map(|child| child.triangles)
                .sum();
        }
    }
    dense(&nodes)?;
    Ok(nodes)
}

/// Checks the number of children of every node. Checks that their sums match the numbers of nodes
/// and triangles, so that no missing node is opened. Checks that there are few enough nodes for
/// this many triangles ([`dense`]), before memory is allocated for the nodes.
fn check_counts(shapes: &[u8], triangles: usize) -> Result<(), TreeFault> {
    let (mut nodes_below, mut triangles_below, mut inner) = (0, 0, 0);
    for (index, shape) in shapes.iter().enumerate() {
        let children = usize::from(shape & !(IS_CLUSTER | OWN_ORIENTATION));
        let is_leaf = shape & IS_CLUSTER != 0;
        if children > WIDTH || children < if is_leaf { 1 } else { 2 } {
            return Err(TreeFault::Children(index));
        }
        *(if is_leaf {
            &mut triangles_below
        } else {
            &mut nodes_below
        }) += children;
        inner += usize::from(!is_leaf);
    }
    if nodes_below + usize::from(!shapes.is_empty()) != shapes.len() || triangles_below != triangles
    {
        return Err(TreeFault::Children(0));
    }
    // The levels of all profiles are numbered in 32 bits.
    let levels = most_levels(shapes.len() - inner, inner, triangles);
    if 7 * shapes.len() > 8 * triangles || levels > u32::MAX as usize {
        return Err(TreeFault::Sparse(0));
    }
    Ok(())
}

/// Upper bound of the number of levels in the profiles of all nodes.
///
/// A leaf has one level. An inner node has one more than its highest child. Divide the inner
/// nodes into paths: each node is followed by its highest child, until that is a leaf. A path of
/// `L` inner nodes has `(L + 1) + L + .. + 2 = L (L + 3) / 2` levels, and `L` is at most the depth
/// of the tree.
fn most_levels(leaves: usize, inner: usize, triangles: usize) -> usize {
    leaves + inner * (most_depth(triangles) as usize + 3) / 2
}

fn node(shape: u8) -> Node {
    Node {
        children: shape & !(IS_CLUSTER | OWN_ORIENTATION),
        is_leaf: shape & IS_CLUSTER != 0,
        ..Node::default()
    }
}

fn own_orientation(
    index: usize,
    bytes: Option<&[u8; ORIENTATION]>,
) -> Result<Orientation, TreeFault> {
    let mut columns = [0.0; 9];
    for (entry, bytes) in columns
        .iter_mut()
        .zip(bytes.map_or(&[][..], |bytes| bytes.as_chunks().0))
    {
        *entry = f32::from_le_bytes(*bytes);
    }
    let rotation = Mat3A::from(Mat3::from_cols_array(&columns));
    let orientation = Orientation {
        rotation,
        id: MESH_ORIENTATION + 1 + index as u32,
    };
    if orientation.is_orthonormal() {
        Ok(orientation)
    } else {
        Err(TreeFault::Orientation(index))
    }
}
