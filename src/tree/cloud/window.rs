//! The newest points of a sensor as a tree that is kept up, in slices of a budget.
//!
//! The points are kept along a Hilbert curve, so a frame is merged with them in one pass, in which
//! expired points are left out. Nodes are laid out evenly over the curve, as long as the number of
//! points stays, for all frames alike; only their boxes are computed anew. All of it goes into a
//! second tree, so the first one serves queries until both change places.

use super::{Blocks, CELLS, Fit, Sort};
use crate::engine::deadline::Deadline;
use crate::engine::deadline::system::ClockedBudget;
use crate::engine::options::OptionError;
use crate::mesh::{Mesh, MeshError, Survey, Vertices, survey};
use crate::tree::build::binary;
use crate::tree::build::collapse::Plan;
use crate::tree::build::orientation::Orientation;
use crate::tree::fit::profile::Profiles;
use crate::tree::unit::Unit;
use crate::tree::wide::WIDTH;
use crate::tree::{Effort, Tree, next_identity, power_of_two};
use alloc::sync::Arc;
use alloc::vec::Vec;
use punctual_geom::lanes::Instructions;
use punctual_geom::tolerance::COORDINATE_LIMIT;

/// Points that a step moves or merges, and of which it finds the places.
const STEP: usize = 128;
const PLACES: usize = 32;

/// Nodes that a step computes the boxes of; each has at most 64 points.
const NODES: usize = 2;

/// Work of a step: less than a microsecond in the mean.
const WORK_PER_STEP: u64 = 2_000;

/// The newest points of a sensor, as the tree of a point cloud.
///
/// [`insert`](Self::insert) takes a frame, [`advance`](Self::advance) brings it into the tree
/// within a budget, and the oldest points expire. Until a frame is in the tree as a whole, the tree
/// is that of the frames before. The order of the points in the tree depends on all points
/// inserted, but not on the budgets.
///
/// A window has two trees, and takes 65 bytes a point. Once it is full it allocates nothing, if
/// nobody else still holds the tree before the one that [`tree`](Self::tree) gives.
///
/// ```
/// use punctual::tree::PointWindow;
/// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
/// let mut window = PointWindow::new(1000, 10.0)?;
/// let tool = Tree::new(shapes::icosphere(3));
/// for frame in 0..20 {
///     let points: Vec<[f32; 3]> = (0..100).map(|i| [frame as f32, i as f32 * 0.1, 3.0]).collect();
///     window.insert(&points)?;
///     // Within a cycle of a controller: `Budget::time(..)`.
///     assert!(window.advance(Budget::unlimited()));
/// }
/// // The frames 10 to 19 are left.
/// let query = Query::distance(window.tree(), &tool, Pose::IDENTITY);
/// let nearest = query.run(&mut Workspace::new(), Budget::unlimited()).value.nearest.unwrap();
/// assert_eq!(window.number(nearest.triangles[0]) / 100, 10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PointWindow {
    capacity: usize,
    /// Cells of the curve in a unit of length.
    scale: f64,
    tree: Arc<Tree>,
    /// Of the tree's points.
    along: Along,
    /// Number of points inserted so far.
    inserted: u64,
    /// Points that are not in the tree and not in `frame`.
    waiting: Vec<[f32; 3]>,
    /// The points that are brought into the tree.
    frame: Vec<[f32; 3]>,
    sort: Sort,
    stage: Stage,
    /// The next tree, of which the points are in `points` while they are merged.
    spare: Arc<Tree>,
    points: Vec<[f32; 3]>,
    merged: Along,
    survey: Survey,
}

/// Points along the curve: their places, and their numbers in the order of insertion.
#[derive(Clone, Debug, Default)]
struct Along {
    places: Vec<u32>,
    /// For each point, the number of points inserted before it, modulo 2^32.
    numbers: Vec<u32>,
    /// Number of points inserted in all.
    inserted: u64,
}

/// The next step, and its progress.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Idle,
    /// Finds the places of the frame's points from this one on.
    Place(usize),
    Sort,
    /// Merges the tree's points from the first index on with those of the frame from the second on.
    Merge(usize, usize),
    /// Computes the boxes of all nodes before this one.
    Fit(usize),
}

impl PointWindow {
    /// An empty window for the newest `capacity` points. `reach` is about the length of the region
    /// that they span, such as twice the range of the sensor, in their unit of length. It may be
    /// anywhere and may move; queries take longer if it is several times as large or small as
    /// given.
    ///
    /// # Errors
    /// If `capacity` is more than 2^30, or `reach` is not positive and at most 2^1000.
    pub fn new(capacity: usize, reach: f64) -> Result<Self, OptionError> {
        let mut fault = None;
        OptionError::note(&mut fault, "capacity", capacity as f64, power_of_two(30));
        let reach_or_fault = if reach == 0.0 { f64::NAN } else { reach };
        OptionError::note(&mut fault, "reach", reach_or_fault, COORDINATE_LIMIT);
        if let Some(fault) = fault {
            return Err(fault);
        }
        let empty = Arc::new(Tree::of_cloud(Mesh::no_points(), Effort::Fast));
        Ok(Self {
            capacity,
            scale: f64::from(CELLS) / reach,
            spare: empty.clone(),
            tree: empty,
            along: Along::default(),
            inserted: 0,
            waiting: Vec::new(),
            frame: Vec::new(),
            sort: Sort::default(),
            stage: Stage::Idle,
            points: Vec::new(),
            merged: Along::default(),
            survey: survey::<_, f32>(&[], |point| point),
        })
    }

    /// The tree of the newest points of all frames that are done. Point `i` of its mesh has nothing
    /// to do with the order of insertion: see [`number`](Self::number).
    pub fn tree(&self) -> &Arc<Tree> {
        &self.tree
    }

    /// How many points were inserted before a point of [`tree`](Self::tree), of which a query gave
    /// this id. So frames of equal size are told from each other by a division.
    ///
    /// # Panics
    /// If the tree has no such point.
    pub fn number(&self, id: u32) -> u64 {
        let Along {
            numbers, inserted, ..
        } = &self.along;
        inserted - u64::from((*inserted as u32).wrapping_sub(numbers[id as usize]))
    }

    /// Takes the points of one frame of the sensor, in the coordinates of the tree. They are in the
    /// tree when [`advance`](Self::advance) is done. `O(points)`.
    ///
    /// # Errors
    /// As [`Mesh::from_points`], with the index in `points`. Then none is taken.
    pub fn insert<V: Copy + Into<[f32; 3]>>(&mut self, points: &[V]) -> Result<(), MeshError> {
        Mesh::check_points(points)?;
        self.inserted += points.len() as u64;
        let newest = &points[points.len().saturating_sub(self.capacity)..];
        self.waiting
            .extend(newest.iter().map(|&point| point.into()));
        // The oldest would expire. Dropping them only sometimes takes linear time in all.
        if self.waiting.len() > self.capacity.saturating_mul(2) {
            self.waiting.drain(..self.waiting.len() - self.capacity);
        }
        Ok(())
    }

    /// Brings the inserted points into the tree; true if all of them are. Otherwise the tree is as
    /// before, and the next call goes on. A million points take some 10 ms, whatever the number of
    /// new ones.
    ///
    /// A step takes 2,000 units of work, or about a microsecond; the first of a call is done with
    /// any budget above 0. Until the window is full, one step of a frame makes room, and takes
    /// longer.
    pub fn advance<'c>(&mut self, budget: impl Into<ClockedBudget<'c>>) -> bool {
        let mut deadline = Deadline::of(budget.into());
        loop {
            if let Stage::Idle = self.stage {
                if self.waiting.is_empty() {
                    return true;
                }
                self.begin();
            }
            if deadline.pay(WORK_PER_STEP).is_err() {
                return false;
            }
            self.stage = match self.stage {
                Stage::Idle => Stage::Idle,
                Stage::Place(from) => self.place(from),
                Stage::Sort if self.sort.advance(STEP) => Stage::Merge(0, 0),
                Stage::Sort => Stage::Sort,
                Stage::Merge(from, at) => self.merge(from, at),
                Stage::Fit(end) => self.fit(end),
            };
        }
    }

    /// Begins with the points that wait.
    fn begin(&mut self) {
        core::mem::swap(&mut self.frame, &mut self.waiting);
        self.waiting.clear();
        self.frame
            .drain(..self.frame.len().saturating_sub(self.capacity));
        if Arc::get_mut(&mut self.spare).is_none() {
            self.spare = Arc::new(Tree::of_cloud(Mesh::no_points(), Effort::Fast));
        }
        self.points = Arc::make_mut(&mut self.spare).mesh.take_points();
        self.points.clear();
        self.survey = survey(&self.points, |point| point);
        self.merged.places.clear();
        self.merged.numbers.clear();
        self.merged.inserted = self.inserted;
        self.sort.clear();
        self.stage = Stage::Place(0);
    }

    /// Number of points of the next tree.
    fn count(&self) -> usize {
        self.capacity
            .min(self.along.places.len() + self.frame.len())
    }

    fn place(&mut self, from: usize) -> Stage {
        let end = self.frame.len().min(from + PLACES);
        // Cells repeat beyond the reach, so no point is out of it.
        let cell = |x: f32| libm::floor(f64::from(x) * self.scale) as i64 as u32 % CELLS;
        self.sort
            .push(&self.frame[from..end], |point| point.map(cell));
        if end < self.frame.len() {
            Stage::Place(end)
        } else {
            Stage::Sort
        }
    }

    fn merge(&mut self, mut from: usize, mut at: usize) -> Stage {
        let (count, begin) = (self.count(), self.points.len());
        let Self {
            along,
            merged,
            points,
            frame,
            ..
        } = self;
        let Vertices::F32(old) = self.tree.mesh.vertices() else {
            return Stage::Idle;
        };
        if merged.inserted - along.inserted >= count as u64 {
            from = old.len();
        }
        let newest = merged.inserted as u32;
        let is_expired = |number: u32| newest.wrapping_sub(number) > count as u32;
        let mut last = STEP;
        while last > 0 && (from < old.len() || at < frame.len()) {
            let new = self.sort.keyed.get(at);
            let until = new.map_or(u32::MAX, |&(place, _)| place);
            let end = old.len().min(from + last);
            let known = along.places[from..end]
                .iter()
                .zip(&along.numbers[from..end]);
            let is_kept = |&(&place, &number): &(&u32, &u32)| place <= until && !is_expired(number);
            let run = known.take_while(is_kept).count();
            points.extend_from_slice(&old[from..from + run]);
            merged
                .places
                .extend_from_slice(&along.places[from..from + run]);
            merged
                .numbers
                .extend_from_slice(&along.numbers[from..from + run]);
            (from, last) = (from + run, last - run);
            if from < end && is_expired(along.numbers[from]) {
                (from, last) = (from + 1, last - 1);
            } else if let Some(&(place, id)) = new.filter(|_| last > 0) {
                points.push(frame[id as usize]);
                merged.places.push(place);
                merged
                    .numbers
                    .push(newest.wrapping_sub((frame.len() - id as usize) as u32));
                (at, last) = (at + 1, last - 1);
            }
        }
        self.survey.add(&survey(&points[begin..], |point| point));
        if from < old.len() || at < frame.len() {
            return Stage::Merge(from, at);
        }
        self.begin_boxes()
    }

    /// Hands the points to the next tree, and makes room for its nodes if their number changes.
    fn begin_boxes(&mut self) -> Stage {
        let tree = Arc::make_mut(&mut self.spare);
        tree.mesh
            .set_points(core::mem::take(&mut self.points), &self.survey);
        tree.unit = Unit::of(&tree.mesh);
        let count = tree.mesh.len();
        if tree.ids.len() != count {
            tree.ids = (0..count as u32).collect();
            tree.blocks = Blocks::new(count, (count.div_ceil(WIDTH) as u32).saturating_sub(1));
            let binary = binary::even(tree.blocks.count());
            tree.nodes = Plan::of(&binary, &Orientation::IDENTITY).nodes;
            tree.blocks.put_below(&mut tree.nodes);
            tree.profiles = Profiles::room(&mut tree.nodes);
        }
        Stage::Fit(tree.nodes.len())
    }

    fn fit(&mut self, end: usize) -> Stage {
        let first = end.saturating_sub(NODES);
        let tree = Arc::make_mut(&mut self.spare);
        let Vertices::F32(points) = tree.mesh.vertices() else {
            return Stage::Idle;
        };
        let block = |block: usize| &points[block * WIDTH..points.len().min((block + 1) * WIDTH)];
        Instructions::detect().run(Fit {
            nodes: &mut tree.nodes,
            profiles: &mut tree.profiles,
            numbers: first..end,
            extent: |at| tree.unit.extent(block(at).iter().copied()),
        });
        if first > 0 {
            return Stage::Fit(first);
        }
        tree.profiles.end(&mut tree.nodes);
        tree.built_cost = tree.profiles.cost;
        tree.identity = next_identity();
        tree.lineage = tree.identity;
        debug_assert_eq!(tree.validate(), Ok(()));
        core::mem::swap(&mut self.tree, &mut self.spare);
        core::mem::swap(&mut self.along, &mut self.merged);
        Stage::Idle
    }
}
