//! A tree as bytes: shipped with a program, it need not be built there.
//!
//! The bytes contain what the build decided: the mesh, the order of the triangles, the structure of
//! the nodes, and the orientations that differ from the parent's. Boxes and profiles follow from
//! these. Loading computes them by the pass that also ends a build ([`super::fit::update`]). So the
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
//! | 4 | version: 3 for a cloud or with a radius, 2 for a solid, else 1 |
//! | 4 | bytes of a coordinate, 4 or 8; + 512 if extremes are kept; + 1024 for a solid; + 2048 for a cloud; + 4096 with a radius; + 256 is ignored |
//! | 4 x 8 | numbers of vertices, triangles, nodes, and orientations |
//! | 4 | SAH cost after the build, `f32` |
//! | 12 or 24 a vertex | coordinates |
//! | 12 a triangle | vertex indices |
//! | 4 a triangle | its index in the mesh, in tree order |
//! | 1 a node | number of children; + 16 if they are triangles; + 32 if it has an orientation |
//! | 36 an orientation | columns of the rotation, `f32`, in the order of the nodes |
//! | 8 | radius, `f64`, if there is one |
//! | 4 | CRC-32 (ISO-HDLC, as in zip and png) of all bytes before |
//!
//! A node without an orientation has that of its parent. Nodes are in the order of the tree: the
//! root, its children, then the nodes below each child in turn. So the numbers of children
//! determine all indices, and no index can lead in a circle.
//!
//! A cloud has no triangles: in place of their number stands that of the block that is not full, or
//! of the last one, and the order is that of its points. The children of its lowest nodes are
//! blocks, counted as triangles are.

use super::build::binary::most_depth;
use super::build::orientation::{MESH_ORIENTATION, Orientation};
use super::build::place::Placed;
use super::fit::profile::Profiles;
use super::fit::update::update;
use super::fork::Pieces;
use super::validate::{TreeFault, dense, each_once};
use super::wide::{Node, WIDTH};
use super::{BuildOptions, Solid, Tree, Unit};
use crate::mesh::{Mesh, MeshError, TRIANGLE_BYTES};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::{fmt, slice};
use glam::{Mat3, Mat3A};
use punctual_geom::tolerance::COORDINATE_LIMIT;

const MAGIC: [u8; 8] = *b"PUNCTREE";
const VERSION: u32 = 3;

/// Flags added to the size of a coordinate, 4 or 8, whose own bit is `IS_F64`. `IGNORED` has no
/// meaning. `HAS_EXTREMES` is set if the tree keeps extremes, `IS_SOLID` if it is one of a solid;
/// loading recomputes what they stand for. `HAS_RADIUS` is set if the radius is not 0.
const IS_F64: u32 = 8;
const IGNORED: u32 = 1 << 8;
const HAS_EXTREMES: u32 = 1 << 9;
const IS_SOLID: u32 = 1 << 10;
const IS_CLOUD: u32 = 1 << 11;
const HAS_RADIUS: u32 = 1 << 12;
const HEADER: usize = 52;
const CHECKSUM: usize = 4;
const ORIENTATION: usize = 36;
const RADIUS: usize = 8;

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
    /// The radius is 0, negative, more than 2^1000 or NaN.
    Radius(f64),
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
            Self::Radius(radius) => write!(f, "the radius {radius} is not above 0, up to 2^1000"),
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

impl From<TreeFault> for TreeFileError {
    fn from(fault: TreeFault) -> Self {
        Self::Tree(fault)
    }
}

/// The contents of the header.
struct Header {
    /// Bytes of a coordinate, and flags.
    kind: u32,
    /// Numbers of vertices, triangles, nodes and orientations.
    counts: [u64; 4],
    cost: f32,
}

impl Header {
    fn has(&self, flag: u32) -> bool {
        self.kind & flag != 0
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        // Older readers know neither clouds nor radii, the oldest no solids.
        let version = match (self.has(IS_CLOUD | HAS_RADIUS), self.has(IS_SOLID)) {
            (true, _) => VERSION,
            (false, true) => 2,
            (false, false) => 1,
        };
        bytes.extend(MAGIC);
        bytes.extend([version, self.kind].into_iter().flat_map(u32::to_le_bytes));
        bytes.extend(self.counts.into_iter().flat_map(u64::to_le_bytes));
        bytes.extend(self.cost.to_le_bytes());
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
        let words = header[MAGIC.len()..].as_chunks().0;
        let mut words = words.iter().map(|&word| u32::from_le_bytes(word));
        let mut word = || words.next().unwrap_or_default();
        let (version, kind) = (word(), word());
        if !(1..=VERSION).contains(&version) {
            return Err(TreeFileError::Version {
                found: version,
                supported: VERSION,
            });
        }
        let since = |first: u32, flag: u32| if version >= first { flag } else { 0 };
        let known = IGNORED | HAS_EXTREMES | since(2, IS_SOLID) | since(3, IS_CLOUD | HAS_RADIUS);
        if ![4, 8].contains(&(kind & !known)) {
            return Err(TreeFileError::CoordinateSize(kind & !known));
        }
        Ok(Self {
            kind,
            counts: [(); 4].map(|()| u64::from(word()) | u64::from(word()) << 32),
            cost: f32::from_bits(word()),
        })
    }

    /// Bytes of each part after the header.
    fn parts(&self) -> [u128; 6] {
        let vertex = if self.has(IS_F64) { 24 } else { 12 };
        let [vertices, triangles, nodes, orientations] = self.counts.map(u128::from);
        let (triangles, ids) = if self.has(IS_CLOUD) {
            (0, vertices)
        } else {
            (triangles, triangles)
        };
        [
            vertex * vertices,
            TRIANGLE_BYTES as u128 * triangles,
            4 * ids,
            nodes,
            ORIENTATION as u128 * orientations,
            if self.has(HAS_RADIUS) {
                RADIUS as u128
            } else {
                0
            },
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
        let (header, shapes) = (self.header(), shapes(&self.nodes));
        let mut bytes = Vec::with_capacity(header.length() as usize);
        header.write(&mut bytes);
        self.mesh.write(&mut bytes);
        bytes.extend(self.ids.iter().flat_map(|id| id.to_le_bytes()));
        bytes.extend_from_slice(&shapes);
        for (node, shape) in self.nodes.iter().zip(&shapes) {
            if shape & OWN_ORIENTATION != 0 {
                let entries = node.rotation().to_cols_array();
                bytes.extend(entries.into_iter().flat_map(f32::to_le_bytes));
            }
        }
        if header.has(HAS_RADIUS) {
            bytes.extend(self.radius.to_le_bytes());
        }
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes
    }

    /// Number of bytes that [`to_bytes`](Self::to_bytes) gives. `O(n)` in the number of nodes;
    /// allocates nothing.
    pub fn bytes_len(&self) -> usize {
        self.header().length() as usize
    }

    fn header(&self) -> Header {
        let flag = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
        let counts = [
            self.mesh.vertex_count(),
            if self.is_cloud() {
                self.blocks.partial as usize
            } else {
                self.mesh.len()
            },
            self.nodes.len(),
            with_own_orientation(&self.nodes).count(),
        ];
        Header {
            kind: if self.mesh.is_f32() { 4 } else { IS_F64 }
                | flag(self.has_extremes(), HAS_EXTREMES)
                | flag(self.solid.is_some(), IS_SOLID)
                | flag(self.is_cloud(), IS_CLOUD)
                | flag(self.radius > 0.0, HAS_RADIUS),
            counts: counts.map(|count| count as u64),
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
        let [vertices, triangles, order, shapes, orientations, radius] = parts.map(|length| {
            let (part, after) = rest.split_at(length as usize);
            rest = after;
            part
        });
        let is_cloud = header.has(IS_CLOUD);
        let triangles = (!is_cloud).then_some(triangles);
        let mesh =
            Mesh::read(vertices, header.has(IS_F64), triangles).map_err(TreeFileError::Mesh)?;
        let ids = order.as_chunks().0.iter();
        let ids: Box<[u32]> = ids.map(|&id| u32::from_le_bytes(id)).collect();
        each_once(&ids, mesh.len())?;
        let leaves = if is_cloud {
            mesh.len().div_ceil(WIDTH)
        } else {
            mesh.len()
        };
        let mut nodes = nodes(shapes, leaves, orientations)?;
        if !(header.cost >= 0.0 && header.cost.is_finite()) {
            return Err(TreeFileError::Cost(header.cost));
        }
        let radius = radius.first_chunk::<RADIUS>();
        let radius = radius.map(|bytes| f64::from_le_bytes(*bytes));
        if let Some(radius) = radius.filter(|r| !(0.0 < *r && *r <= COORDINATE_LIMIT)) {
            return Err(TreeFileError::Radius(radius));
        }
        let tree = if is_cloud {
            Self::of_file(mesh, nodes, header.counts[1], ids)?
        } else {
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
            let mut options = BuildOptions::default().extremes(header.has(HAS_EXTREMES));
            if header.has(IS_SOLID) {
                options.solid = Solid::Keep;
            }
            Self::of_nodes(mesh, unit, nodes, profiles, placed, ids, &options)
        };
        Ok(Self {
            built_cost: header.cost,
            radius: radius.unwrap_or(0.0),
            ..tree
        })
    }
}

/// One byte per node: the number of its children, their kind, and a flag if its orientation differs
/// from its parent's.
fn shapes(nodes: &[Node]) -> Vec<u8> {
    // The children of a lowest node of a cloud are blocks.
    let is_lowest = |node: &Node| node.is_leaf || node.first_child as usize >= nodes.len();
    let shape = |node: &Node| node.children | if is_lowest(node) { IS_CLUSTER } else { 0 };
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
        parent.child_range().filter(move |&child| {
            let child = nodes.get(child);
            child.is_some_and(|child| child.orientation != orientation)
        })
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
    let own = shapes.iter().filter(|&shape| shape & OWN_ORIENTATION != 0);
    let needed = own.count();
    let orientations = orientations.as_chunks::<ORIENTATION>().0;
    if orientations.len() != needed {
        return Err(TreeFileError::Orientations {
            stored: orientations.len(),
            needed,
        });
    }
    let mut reader = Reader {
        shapes,
        orientations: orientations.iter(),
        nodes: shapes.iter().map(|&shape| node(shape)).collect(),
        next_node: shapes.len().min(1),
        next_triangle: 0,
        most_depth: most_depth(triangles),
    };
    if !shapes.is_empty() {
        reader.orient(0, Orientation::IDENTITY)?;
        reader.open(0)?;
    }
    if reader.next_node != shapes.len() {
        // The first node that is not a child of any node.
        return Err(TreeFault::Children(reader.next_node).into());
    }
    dense(&reader.nodes)?;
    Ok(reader.nodes)
}

/// Nodes while they are read.
struct Reader<'b> {
    shapes: &'b [u8],
    /// Those not read yet.
    orientations: slice::Iter<'b, [u8; ORIENTATION]>,
    nodes: Box<[Node]>,
    next_node: usize,
    next_triangle: u32,
    most_depth: u32,
}

impl Reader<'_> {
    fn orient(&mut self, index: usize, parent: Orientation) -> Result<(), TreeFault> {
        let orientation = if self.shapes[index] & OWN_ORIENTATION == 0 {
            parent
        } else {
            own_orientation(index, self.orientations.next())?
        };
        self.nodes[index].set_orientation(&orientation);
        Ok(())
    }

    /// Numbers the nodes and triangles below a node.
    fn open(&mut self, index: usize) -> Result<(), TreeFault> {
        let node = &mut self.nodes[index];
        node.first_triangle = self.next_triangle;
        if node.is_leaf {
            (node.first_child, node.triangles) = (self.next_triangle, node.children.into());
            self.next_triangle += node.triangles;
            return Ok(());
        }
        node.first_child = self.next_node as u32;
        let (parent, depth, children) = (node.orientation(), node.depth + 1, node.child_range());
        if u32::from(depth) > self.most_depth {
            return Err(TreeFault::Depth(children.start));
        }
        self.next_node = children.end;
        for child in children.clone() {
            self.nodes[child].depth = depth;
            self.orient(child, parent)?;
        }
        for child in children {
            self.open(child)?;
        }
        let node = &mut self.nodes[index];
        node.triangles = self.next_triangle - node.first_triangle;
        Ok(())
    }
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
/// A leaf has one level, and one for its triangles. An inner node has one more than its highest
/// child. Divide the inner nodes into paths: each node is followed by its highest child, until that
/// is a leaf. A path of `L` inner nodes has `(L + 2) + (L + 1) + .. + 3 = L (L + 5) / 2` levels,
/// and `L` is at most the depth of the tree.
fn most_levels(leaves: usize, inner: usize, triangles: usize) -> usize {
    2 * leaves + inner * (most_depth(triangles) as usize + 5) / 2
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
    let entries = bytes.map_or(&[][..], |bytes| bytes.as_chunks().0);
    let entry = |i: usize| {
        entries
            .get(i)
            .map_or(0.0, |bytes| f32::from_le_bytes(*bytes))
    };
    let columns = core::array::from_fn(entry);
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
