//! Bounds on what a stopped query may have missed: how much, and where.

use super::boxes::relative_pose::rounding;
use super::frontier::Pair;
use super::options::MotionOptions;
use super::triangles::ids;
use super::workspace::Workspace;
use crate::query::motion::ahead::Ahead;
use crate::tree::{Tree, node, xyz};
use glam::{DMat3, DVec3, Vec3};
use punctual_geom::tolerance::FRAME_ROUNDING;
use punctual_geom::{Aabb, Pose};

/// Bounds on what the last run of a query left open: triangle pairs that intersect for an
/// intersection query, pairs closer than the upper bound by more than the tolerance for a distance
/// query, and pairs that may meet first for a motion. Each method reads the workspace when it is
/// called, in time linear in the open pairs.
#[derive(Clone, Copy, Debug)]
pub struct Certificate<'w> {
    pub(crate) a: &'w Tree,
    pub(crate) b: &'w Tree,
    pub(crate) place: Place<'w>,
    pub(crate) workspace: &'w Workspace,
}

/// Pose or motion of B.
#[derive(Clone, Copy, Debug)]
pub enum Place<'w> {
    /// The pose, and the largest distance of the points of a missed pair.
    Still(&'w Pose, f64),
    Moving(&'w MotionOptions),
}

impl<'w> Certificate<'w> {
    /// Number of open pairs, of nodes or triangles. 0 means that nothing was missed. A query
    /// divides a turning motion into substeps; each one not reached counts as one pair, unless the
    /// meshes are too far apart in it.
    #[must_use]
    pub fn open_pairs(&self) -> usize {
        self.open().count()
    }

    /// Upper bound of the number of triangle pairs that intersect (or are closer): those found,
    /// plus for each open pair the product of its numbers of triangles. It never grows while a
    /// query continues.
    #[must_use]
    pub fn upper_bound(&self) -> u64 {
        let count = |tree: &Tree, node: u32, active: u8| u64::from(tree.count_below(node, active));
        let open = self.open().map(|open| match open {
            Open::Nodes(Pair {
                nodes: [a, b],
                active,
            }) => count(self.a, a, active[0]) * count(self.b, b, active[1]),
            Open::Triangles(_) => 1,
            Open::Substep(_) => self.a.mesh().len() as u64 * self.b.mesh().len() as u64,
        });
        let all = self.a.mesh().len() as u64 * self.b.mesh().len() as u64;
        let workspace = self.workspace;
        let trace = &workspace.state.intersection.trace;
        // Pairs found along curves that the boxes have not reached are also counted in the product
        // of an open pair.
        let waits = workspace
            .triangle_pairs()
            .filter(|pair| trace.knows([self.a, self.b], *pair));
        let ahead = trace.followed.saturating_sub(trace.passed);
        let ahead = ahead.saturating_sub(waits.count() as u64);
        let found = workspace.run.stats.found.saturating_sub(ahead);
        open.fold(found, u64::saturating_add).min(all)
    }

    /// Boxes in A's frame, at most one for each open pair: every missed intersection has all its
    /// points in one of them. An open pair of nodes whose boxes are separated has no box.
    ///
    /// For a distance query: if two points of the surfaces are closer than the upper bound by more
    /// than the tolerance, their middle is in one of the boxes. The boxes extend as far as that
    /// bound beyond the surfaces; without an upper bound there are no finite boxes.
    ///
    /// For a motion: if the surfaces meet before the contact that was found, if any, they meet in
    /// one of the boxes. The boxes hold all points of A that B touches there, or approaches within
    /// the margins.
    pub fn boxes(&self) -> impl Iterator<Item = Aabb> + 'w {
        let certificate = *self;
        self.open().filter_map(move |open| match certificate.place {
            Place::Still(b_in_a, reach) => certificate.box_of(open, b_in_a, reach),
            Place::Moving(options) => certificate.box_ahead(open, &certificate.ahead(options)),
        })
    }

    /// A box around the points of an open pair that may be within `reach` of one another; `None` if
    /// there are none.
    fn box_of(&self, open: Open, b_in_a: &Pose, reach: f64) -> Option<Aabb> {
        let Self { a, b, .. } = *self;
        // Covers the rounding of B's placed vertices, and twice as much for the boxes computed here
        // (`docs/numerics.md`).
        let rounding =
            3.0 * rounding(a.unit(), b.unit(), b_in_a) + 8.0 * f64::EPSILON * a.unit().length();
        let margin = rounding + 0.5 * reach;
        match open {
            Open::Nodes(Pair { nodes, .. }) => Block::new(a, nodes[0], &Pose::IDENTITY)
                .overlap(&Block::new(b, nodes[1], b_in_a), margin),
            Open::Triangles(pair) => {
                let (of_a, of_b) = (
                    triangle_bounds(a, pair[0], &Pose::IDENTITY),
                    triangle_bounds(b, pair[1], b_in_a),
                );
                Some(widened(&of_a.intersection(&of_b), margin)).filter(|common| !common.is_empty())
            }
            Open::Substep(_) => None,
        }
    }

    /// A box around the points where an open pair may meet during the motion.
    fn box_ahead(&self, open: Open, ahead: &Ahead) -> Option<Aabb> {
        let Self { a, b, .. } = *self;
        let node = |tree: &Tree, node: u32, pose: &Pose| {
            let block = Block::new(tree, node, pose);
            block.bounds(DVec3::ZERO, block.half)
        };
        let (of_a, of_b) = match open {
            Open::Nodes(Pair { nodes, .. }) => (
                node(a, nodes[0], &Pose::IDENTITY),
                ahead.swept(None, |pose| node(b, nodes[1], pose)),
            ),
            Open::Triangles(pair) => {
                let of_b = ahead.swept(None, |pose| triangle_bounds(b, pair[1], pose));
                (triangle_bounds(a, pair[0], &Pose::IDENTITY), of_b)
            }
            Open::Substep(i) => (
                node(a, 0, &Pose::IDENTITY),
                ahead.swept(Some(i), |pose| node(b, 0, pose)),
            ),
        };
        let common = widened(&of_a, 8.0 * f64::EPSILON * a.unit().length()).intersection(&of_b);
        (!common.is_empty()).then_some(common)
    }

    /// The longest edge of these boxes, in the length unit of the meshes; 0 if nothing is open.
    #[must_use]
    pub fn largest_extent(&self) -> f64 {
        self.boxes()
            .map(|open| (open.max - open.min).max_element())
            .fold(0.0, f64::max)
    }

    fn open(&self) -> impl Iterator<Item = Open> + 'w {
        let workspace = self.workspace;
        // A waiting triangle pair that was found along a curve is no longer open.
        let trees = [self.a, self.b];
        let waiting = workspace.triangle_pairs();
        let waiting =
            waiting.filter(move |pair| !workspace.state.intersection.trace.knows(trees, *pair));
        let followed = workspace.state.motion.followed.iter();
        let triangles = waiting
            .chain(workspace.state.distance.pairs())
            .chain(followed.map(|followed| followed.pair))
            .map(move |pair| Open::Triangles(ids(trees, pair)));
        let later = match self.place {
            Place::Still(..) => None,
            Place::Moving(options) => Some(self.ahead(options).later([self.a, self.b])),
        };
        let later = later.into_iter().flatten().map(Open::Substep);
        let nodes = workspace
            .frontier
            .iter()
            .map(|pair| Open::Nodes(workspace.state.distance.nodes(pair)));
        nodes.chain(triangles).chain(later).take(self.most())
    }

    /// The part of a motion that is left.
    fn ahead(&self, options: &'w MotionOptions) -> Ahead<'w> {
        Ahead::new([self.a, self.b], options, &self.workspace.state.motion)
    }

    /// Maximum number of open pairs that count: none for a finished motion, whatever the buffers
    /// still hold.
    fn most(&self) -> usize {
        let is_finished = matches!(self.place, Place::Moving(_)) && !self.workspace.run.stopped;
        if is_finished { 0 } else { usize::MAX }
    }
}

/// Serialized as a structure of `open_pairs`, `upper_bound`, `largest_extent` and the list `boxes`.
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

enum Open {
    Nodes(Pair),
    /// Ids of the input meshes.
    Triangles([u32; 2]),
    /// Both whole meshes, in a substep of a motion that the query has not reached.
    Substep(u32),
}

/// The box in A's frame of a triangle (an id of the input mesh) whose mesh is at `pose`.
fn triangle_bounds(tree: &Tree, triangle: u32, pose: &Pose) -> Aabb {
    Aabb::from_points(
        tree.mesh()
            .triangle(triangle as usize)
            .map(|v| pose.transform_point(v)),
    )
}

/// The box of a node, oriented in A's frame: `center + axes * x` for all `x` within `half`.
struct Block {
    center: DVec3,
    axes: DMat3,
    half: DVec3,
}

impl Block {
    /// The box of a node whose mesh is at `pose`.
    fn new(tree: &Tree, node: u32, pose: &Pose) -> Self {
        let leaf;
        let node = node!(tree, node, leaf);
        let (unit, rotation) = (tree.unit(), node.rotation().as_dmat3());
        let center =
            unit.origin + rotation * Vec3::from(xyz(node.own_center)).as_dvec3() * unit.length();
        let half =
            (node.extent().as_dvec3() + DVec3::splat(f64::from(FRAME_ROUNDING))) * unit.length();
        Self {
            center: pose.transform_point(center),
            axes: *pose.rotation() * rotation,
            half,
        }
    }

    /// A box around the intersection of two blocks, from the axes of A and of both blocks; `None`
    /// if it is empty.
    fn overlap(&self, other: &Self, margin: f64) -> Option<Aabb> {
        let [a, b] = [self, other].map(|block| block.bounds(DVec3::ZERO, block.half));
        let [c, d] = [self.part(other, margin)?, other.part(self, margin)?];
        let common = widened(
            &a.intersection(&b).intersection(&c).intersection(&d),
            margin,
        );
        (!common.is_empty()).then_some(common)
    }

    /// A box around the part of this block that the other one may reach.
    fn part(&self, other: &Self, margin: f64) -> Option<Aabb> {
        let inverse = self.axes.inverse();
        let center = inverse * (other.center - self.center);
        let reach = (inverse * other.axes).abs() * other.half + DVec3::splat(2.0 * margin);
        let (min, max) = (
            (center - reach).max(-self.half),
            (center + reach).min(self.half),
        );
        min.cmple(max)
            .all()
            .then(|| self.bounds((min + max) * 0.5, (max - min) * 0.5))
    }

    /// A box in A's frame around a part of this block, given in its own axes.
    fn bounds(&self, center: DVec3, half: DVec3) -> Aabb {
        let (center, half) = (self.center + self.axes * center, self.axes.abs() * half);
        Aabb {
            min: center - half,
            max: center + half,
        }
    }
}

fn widened(bounds: &Aabb, margin: f64) -> Aabb {
    Aabb {
        min: bounds.min - margin,
        max: bounds.max + margin,
    }
}
