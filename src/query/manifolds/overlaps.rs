//! Overlaps of two surfaces that meet: from the pairs of triangles that intersect to manifolds.
//!
//! All of it is about A and B *drawn in* ([`inset`]), so that no two faces coincide.
//!
//! 1. *Link*: pairs that share a triangle, and whose other triangles are neighbors, belong to one
//!    contact curve.
//! 2. *Classify*: the vertices of uncut triangles beside the curves are joined into classes.
//! 3. *Test*: of each class one vertex: inside the other surface or not.
//! 4. *Seed* and *flood*: the flood starts at vertices inside and spreads over uncut triangles.
//!    Curves that bound one region belong together.
//! 5. *Gather*: the area vector of a region is half the sum of `(s - c) x (e - c)` over the
//!    segments from `s` to `e` of its curves. It does not depend on `c`, because curves are closed.
//! 6. *Reduce* the vertices of each region to the deepest and to the farthest along eight
//!    directions.
//! 7. *Probe* depths along the normal, by rays from these vertices and from points of the curves
//!    ([`depth`]).
//!
//! Each step takes bounded work, and everything between steps is in [`Overlaps`].

mod depth;
mod inset;

use super::manifold::{Manifold, Octagon, Shape, Skin};
use crate::engine::deadline::Deadline;
use crate::engine::memory::identity::Before;
use crate::engine::outcome::Operand;
use crate::engine::outcome::Stats;
use crate::engine::outcome::StopReason;
use crate::engine::workspace::Workspace;
use crate::model::cost::{
    MAX_DISTANCE_STEP_WORK, WORK_PER_AREA, WORK_PER_CLOSEST_POINTS, WORK_PER_CONTACT,
    WORK_PER_CURVE_PAIR, WORK_PER_EXACT_TEST, WORK_PER_LOOKUP, WORK_PER_RAY, WORK_PER_RAY_TEST,
    WORK_PER_REGION_TRIANGLE, WORK_PER_SEGMENT, WORK_PER_WAY,
};
use crate::query::contacts::contact::{Contact, directed, face_normal};
use crate::query::contacts::list::ContactList;
use crate::query::points::contained::may_hold;
use crate::query::rays::cast_alone;
use crate::query::rays::state::RayHit;
use crate::sets::{find, unite};
use crate::tree::Tree;
use crate::tree::solid::inside::inside;
use alloc::vec::Vec;
use core::mem;
use depth::{Group, Probing, Spot};
use glam::DVec3;
use inset::Inset;
pub(crate) use inset::reach;
use punctual_geom::triangle::distance::{Closest, closest};
use punctual_geom::triangle::ray::Side;
use punctual_geom::{Pose, Ray, triangle_segment, triangles_intersect};

/// Maximum number of triangles in the regions of the overlaps of one query; those beyond are not
/// examined ([`Manifold::is_whole`]).
pub const REGION_LIMIT: usize = 1 << 16;

/// Number of items of a phase in one step.
const STEP: usize = 4;

const _: () = assert!(
    MAX_DISTANCE_STEP_WORK >= STEP as u64 * (WORK_PER_CURVE_PAIR + 1)
        && MAX_DISTANCE_STEP_WORK >= STEP as u64 * WORK_PER_REGION_TRIANGLE
        && MAX_DISTANCE_STEP_WORK >= 2 * (WORK_PER_RAY + 2 * WORK_PER_RAY_TEST)
        // A step with a pair of triangles (`Reduction::take_near`, `Reduction::take_area`).
        && MAX_DISTANCE_STEP_WORK >= WORK_PER_EXACT_TEST + WORK_PER_CLOSEST_POINTS + WORK_PER_CONTACT
        && MAX_DISTANCE_STEP_WORK >= WORK_PER_EXACT_TEST + WORK_PER_SEGMENT + WORK_PER_CONTACT
        && MAX_DISTANCE_STEP_WORK >= WORK_PER_WAY
        && MAX_DISTANCE_STEP_WORK >= WORK_PER_AREA
);

/// Triangles of B farther from A than this many times the reach of drawing in are not drawn in.
const CLEAR: f64 = 64.0;

/// A direction along which few meshes have edges or faces: a unit vector.
const ACROSS: DVec3 = DVec3::new(
    0.267_261_241_912_424_4,
    0.534_522_483_824_848_8,
    0.801_783_725_737_273_2,
);

/// A triangle of A and one of B drawn in that intersect.
#[derive(Clone, Copy, Debug)]
struct Cut {
    /// In tree order.
    pair: [u32; 2],
    /// Directed along the cross product of the normals of A's triangle and of B's.
    segment: [DVec3; 2],
    normals: [DVec3; 2],
    /// True for the first pair with this triangle, for A and for B.
    is_first: [bool; 2],
    /// The group, once the groups are known.
    group: u32,
}

/// A set of numbers with values, emptied in constant time.
#[derive(Clone, Debug, Default)]
struct Marks {
    values: Vec<u32>,
    /// Values below are of earlier queries.
    base: u32,
    end: u32,
}

impl Marks {
    /// Empties the set, for numbers below `len` and values below `most`.
    fn begin(&mut self, len: usize, most: usize) {
        let most = most.min(u32::MAX as usize / 2) as u32;
        self.base = self.end.max(1);
        if u32::MAX - most <= self.base {
            self.values.fill(0);
            self.base = 1;
        }
        self.end = self.base + most;
        if self.values.len() < len {
            self.values.resize(len, 0);
        }
    }

    fn get(&self, at: u32) -> Option<u32> {
        self.values[at as usize].checked_sub(self.base)
    }

    fn set(&mut self, at: u32, value: u32) {
        self.values[at as usize] = self.base + value;
    }
}

/// The value of cut triangles. The value of a flooded triangle is one more than the index of the
/// pair that the flood came from.
const CUT: u32 = 0;

/// The value of vertices that only flooded triangles have. The value of another vertex is one more
/// than the index of its member.
const FLOODED: u32 = 0;

/// A vertex of a cut triangle or of its neighbors. Either all vertices of its class are inside the
/// other surface, or none is. The root of the class stores which.
#[derive(Clone, Copy, Debug)]
struct Member {
    side: u8,
    vertex: u32,
    is_inside: bool,
    is_reduced: bool,
    /// A pair whose curve bounds the region of the class.
    claim: Option<u32>,
}

/// An uncut triangle inside the other surface, and the pair that the flood came from.
#[derive(Clone, Copy, Debug)]
struct Flooded {
    side: u8,
    triangle: u32,
    cut: u32,
}

/// True if the exact test for inside applies. For other surfaces the side of the nearest hit
/// decides, as far as they have an inner side.
fn is_closed(tree: &Tree) -> bool {
    tree.solid().is_some_and(|solid| solid.is_closed())
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
enum Phase {
    Link,
    Classify,
    Test,
    Seed,
    Flood,
    Gather,
    Reduce,
    Probe,
    #[default]
    Done,
}

/// The overlaps of a query.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overlaps {
    inset: Inset,
    cuts: Vec<Cut>,
    /// The first pair found of triangles of A and of B itself that intersect.
    met: Option<[u32; 2]>,
    phase: Phase,
    /// The next item of the phase.
    at: usize,
    /// Union-find over the pairs.
    parents: Vec<u32>,
    /// Hash table of the pairs.
    slots: Marks,
    triangles: [Marks; 2],
    vertices: [Marks; 2],
    members: Vec<Member>,
    /// Union-find over the members.
    classes: Vec<u32>,
    region: Vec<Flooded>,
    groups: Vec<Group>,
    probing: Probing,
    /// The manifolds of the groups that are done.
    done: Vec<Manifold>,
    /// A ray is under way in the workspace.
    is_casting: bool,
}

fn reserve<T>(buffer: &mut Vec<T>, most: usize) {
    buffer.reserve(most.saturating_sub(buffer.len()));
}

impl Overlaps {
    pub fn clear(&mut self) {
        self.cuts.clear();
        self.parents.clear();
        self.groups.clear();
        self.done.clear();
        self.probing.clear();
        (self.phase, self.at) = (Phase::Link, 0);
        (self.met, self.is_casting) = (None, false);
    }

    /// True if the surfaces are known to intersect.
    pub fn meets(&self) -> bool {
        self.met.is_some()
    }

    /// True if pairs of triangles that intersect are in no manifold yet.
    pub fn is_open(&self) -> bool {
        !self.cuts.is_empty() && !self.is_done()
    }

    pub fn is_done(&self) -> bool {
        self.phase == Phase::Done
    }

    /// The overlaps whose depth is known.
    pub fn manifolds(&self) -> &[Manifold] {
        &self.done
    }

    pub fn reserve(&mut self, cuts: usize) {
        reserve(&mut self.cuts, cuts);
        reserve(&mut self.parents, cuts);
    }

    /// Reserves room for this many pairs, of meshes of this size at most.
    pub fn reserve_for(&mut self, cuts: usize, [triangles, vertices]: [usize; 2]) {
        self.reserve(cuts);
        self.inset.reserve(vertices);
        reserve(&mut self.slots.values, (2 * cuts).next_power_of_two());
        reserve(&mut self.members, 12 * cuts);
        reserve(&mut self.classes, 12 * cuts);
        reserve(&mut self.region, (2 * triangles).min(REGION_LIMIT));
        reserve(&mut self.groups, cuts);
        reserve(&mut self.done, cuts);
        self.probing.reserve();
        for side in 0..2 {
            reserve(&mut self.triangles[side].values, triangles);
            reserve(&mut self.vertices[side].values, vertices);
        }
    }

    /// Takes two triangles (tree order) that intersect in this segment.
    fn take(&mut self, pair: [u32; 2], corners: [&[DVec3; 3]; 2], segment: [DVec3; 2]) {
        let normals = corners.map(face_normal);
        self.parents.push(self.cuts.len() as u32);
        self.cuts.push(Cut {
            pair,
            segment: directed(segment, normals).0,
            normals: normals.map(Option::unwrap_or_default),
            is_first: [false; 2],
            group: 0,
        });
    }

    /// Of bodies that touch without a curve, the one inside the other, a closed solid.
    pub fn inner(&self, shape: Shape, to_b: &Pose) -> Option<Operand> {
        let ([a, b], [of_a, of_b]) = (shape.trees, self.met.filter(|_| self.cuts.is_empty())?);
        let [[on_a, ..], [on_b, ..]] = [a.vertices_of(of_a), b.vertices_of(of_b)];
        if may_hold(a, b) && inside(a, self.inset.place(shape, 1, on_b)).is_inside() {
            Some(Operand::B)
        } else if may_hold(b, a) && self.inset.holds(shape, to_b, shape.place(0, on_a)) {
            Some(Operand::A)
        } else {
            None
        }
    }

    /// Prepares for the first step, after the last pair.
    fn begin(&mut self, trees: [&Tree; 2]) {
        let count = self.cuts.len();
        self.slots.begin((2 * count).next_power_of_two(), count);
        self.members.clear();
        self.classes.clear();
        self.region.clear();
        self.groups.clear();
        for (side, tree) in trees.into_iter().enumerate() {
            self.triangles[side].begin(tree.mesh().len(), count + 1);
            // A pair has six vertices, and six neighbors.
            self.vertices[side].begin(tree.mesh().vertex_count(), 12 * count + 1);
        }
    }

    /// The slot of a pair in the hash table, and the index of the pair found there, if any.
    fn slot(&self, pair @ [a, b]: [u32; 2]) -> (u32, Option<u32>) {
        let mask = (2 * self.cuts.len()).next_power_of_two() - 1;
        let hash = (u64::from(a) << 32 | u64::from(b)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut slot = (hash ^ hash >> 29) as usize & mask;
        loop {
            match self.slots.get(slot as u32) {
                Some(there) if self.cuts[there as usize].pair != pair => slot = (slot + 1) & mask,
                known => return (slot as u32, known),
            }
        }
    }

    fn link(&mut self, trees: [&Tree; 2], at: usize) {
        let pair = self.cuts[at].pair;
        for (side, triangle) in pair.into_iter().enumerate() {
            let marks = &mut self.triangles[side];
            self.cuts[at].is_first[side] = marks.get(triangle).is_none();
            marks.set(triangle, CUT);
        }
        let (slot, known) = self.slot(pair);
        if let Some(known) = known {
            return unite(&mut self.parents, known, at as u32);
        }
        self.slots.set(slot, at as u32);
        for side in 0..2 {
            for next in neighbors(trees[side], pair[side]) {
                let mut other = pair;
                other[side] = next;
                if let (_, Some(known)) = self.slot(other) {
                    unite(&mut self.parents, known, at as u32);
                }
            }
        }
    }

    fn is_cut(&self, side: usize, triangle: u32) -> bool {
        self.triangles[side].get(triangle) == Some(CUT)
    }

    /// The member for a vertex, a class of its own if it is new.
    fn member(&mut self, side: usize, vertex: u32) -> u32 {
        if let Some(known) = self.vertices[side].get(vertex) {
            return known - 1;
        }
        let member = self.members.len() as u32;
        self.members.push(Member {
            side: side as u8,
            vertex,
            is_inside: false,
            is_reduced: false,
            claim: None,
        });
        self.classes.push(member);
        self.vertices[side].set(vertex, member + 1);
        member
    }

    fn classify(&mut self, trees: [&Tree; 2], at: usize) {
        let Cut { pair, is_first, .. } = self.cuts[at];
        for side in (0..2).filter(|&side| is_first[side]) {
            for vertex in trees[side].vertices_of(pair[side]) {
                self.member(side, vertex);
            }
            for next in neighbors(trees[side], pair[side]) {
                if !self.is_cut(side, next) {
                    let vertices = trees[side].vertices_of(next);
                    let [p, q, r] = vertices.map(|vertex| self.member(side, vertex));
                    unite(&mut self.classes, p, q);
                    unite(&mut self.classes, p, r);
                }
            }
        }
    }

    /// Tests the class of which a member is the root.
    fn test(
        &mut self,
        shape: Shape,
        to_b: &Pose,
        at: usize,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<(), StopReason> {
        if self.classes[at] != at as u32 {
            workspace.run.stats.work += WORK_PER_LOOKUP;
            return Ok(());
        }
        let Member { side, vertex, .. } = self.members[at];
        let side = usize::from(side);
        let place = self.inset.place(shape, side, vertex);
        let other = shape.trees[1 - side];
        self.members[at].is_inside = if is_closed(other) {
            workspace.run.stats.work += WORK_PER_RAY + 2 * WORK_PER_RAY_TEST;
            deadline.allow_for_long_step();
            if side == 0 {
                self.inset.holds(shape, to_b, place)
            } else {
                inside(other, place).is_inside()
            }
        } else {
            let hit = self.cast(shape, to_b, 1 - side, [place, ACROSS], workspace, deadline)?;
            hit.is_some_and(|hit| hit.side == Side::Back)
        };
        Ok(())
    }

    /// The root of the class of a vertex, if it is inside.
    fn inside_root(&mut self, side: usize, vertex: u32) -> Option<usize> {
        let member = self.vertices[side].get(vertex)?.checked_sub(1)?;
        let root = find(&mut self.classes, member) as usize;
        self.members[root].is_inside.then_some(root)
    }

    /// Starts the flood beside a pair.
    fn seed(&mut self, trees: [&Tree; 2], at: usize) {
        let pair = self.cuts[at].pair;
        for side in 0..2 {
            for vertex in trees[side].vertices_of(pair[side]) {
                if let Some(root) = self.inside_root(side, vertex) {
                    let claim = *self.members[root].claim.get_or_insert(at as u32);
                    unite(&mut self.parents, claim, at as u32);
                }
            }
            for next in neighbors(trees[side], pair[side]) {
                let [vertex, ..] = trees[side].vertices_of(next);
                if !self.is_cut(side, next) && self.inside_root(side, vertex).is_some() {
                    self.flood_into(side, next, at as u32);
                }
            }
        }
    }

    /// Adds a triangle to the region of a pair.
    fn flood_into(&mut self, side: usize, triangle: u32, cut: u32) {
        match self.triangles[side].get(triangle) {
            Some(CUT) => {}
            Some(other) => unite(&mut self.parents, other - 1, cut),
            None if self.region.len() < REGION_LIMIT => {
                self.triangles[side].set(triangle, cut + 1);
                let side = side as u8;
                self.region.push(Flooded {
                    side,
                    triangle,
                    cut,
                });
            }
            None => {}
        }
    }

    fn flood(&mut self, trees: [&Tree; 2], at: usize) {
        let flooded = self.region[at];
        let side = usize::from(flooded.side);
        for next in neighbors(trees[side], flooded.triangle) {
            self.flood_into(side, next, flooded.cut);
        }
    }

    /// Adds a pair to its group. The first pair of a group creates it.
    fn gather(&mut self, at: usize) {
        let root = find(&mut self.parents, at as u32) as usize;
        if root == at {
            self.cuts[at].group = self.groups.len() as u32;
            self.groups.push(Group::new(at as u32, &self.cuts[at]));
        }
        let group = self.cuts[root].group;
        self.cuts[at].group = group;
        self.groups[group as usize].add(&self.cuts[at], self.inset.step);
    }

    /// Takes the points of a cut, or of a flooded triangle, into the extremes of its group.
    fn reduce(&mut self, shape: Shape, at: usize) {
        if let Some(&Cut {
            pair,
            segment,
            group,
            ..
        }) = self.cuts.get(at)
        {
            let group = group as usize;
            if self.groups[group].first as usize == at {
                self.groups[group].find_normal(self.inset.step);
            }
            self.groups[group].insert_segment(segment, at as u32);
            for (side, triangle) in pair.into_iter().enumerate() {
                for vertex in shape.trees[side].vertices_of(triangle) {
                    if self.inside_root(side, vertex).is_some() {
                        self.reduce_vertex(shape, side, vertex, group);
                    }
                }
            }
        } else {
            let flooded = self.region[at - self.cuts.len()];
            let side = usize::from(flooded.side);
            let group = self.cuts[flooded.cut as usize].group as usize;
            for vertex in shape.trees[side].vertices_of(flooded.triangle) {
                self.reduce_vertex(shape, side, vertex, group);
            }
        }
    }

    /// Takes a vertex of a triangle into the extremes of its group.
    fn reduce_vertex(&mut self, shape: Shape, side: usize, vertex: u32, group: usize) {
        let is_reduced = match self.vertices[side].get(vertex) {
            None => {
                self.vertices[side].set(vertex, FLOODED);
                false
            }
            Some(FLOODED) => true,
            Some(member) => mem::replace(&mut self.members[member as usize - 1].is_reduced, true),
        };
        if !is_reduced {
            let place = shape.place(side, vertex);
            self.groups[group].insert(side, Spot { place, of: vertex });
        }
    }

    /// The phase: its number of items, the work of each (0 where an item counts its own), the
    /// number of items in a step, and the next phase.
    fn items(&self) -> (usize, u64, usize, Phase) {
        let (cuts, region) = (self.cuts.len(), self.region.len());
        match self.phase {
            Phase::Link => (cuts, WORK_PER_CURVE_PAIR + 1, STEP, Phase::Classify),
            Phase::Classify => (cuts, WORK_PER_CURVE_PAIR, STEP, Phase::Test),
            Phase::Test => (self.members.len(), 0, 1, Phase::Seed),
            Phase::Seed => (cuts, WORK_PER_CURVE_PAIR, STEP, Phase::Flood),
            Phase::Flood => (region, WORK_PER_REGION_TRIANGLE, STEP, Phase::Gather),
            Phase::Gather => (cuts, WORK_PER_CURVE_PAIR, STEP, Phase::Reduce),
            Phase::Reduce => (cuts + region, WORK_PER_REGION_TRIANGLE, STEP, Phase::Probe),
            Phase::Probe => (self.groups.len(), 0, 1, Phase::Done),
            Phase::Done => (0, 0, 1, Phase::Done),
        }
    }

    /// One step of bounded work.
    fn step(
        &mut self,
        shape: Shape,
        before: Before,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<(), StopReason> {
        let trees = shape.trees;
        if self.phase == Phase::Link && self.at == 0 {
            if self.cuts.is_empty() {
                self.phase = Phase::Done;
                return Ok(());
            }
            self.begin(trees);
        }
        let (count, work, step, next) = self.items();
        let end = (self.at + step).min(count);
        workspace.run.stats.work += (end - self.at) as u64 * work;
        for at in self.at..end {
            match self.phase {
                Phase::Link => self.link(trees, at),
                Phase::Classify => self.classify(trees, at),
                Phase::Test => self.test(shape, before.to_b, at, workspace, deadline)?,
                Phase::Seed => self.seed(trees, at),
                Phase::Flood => self.flood(trees, at),
                Phase::Gather => self.gather(at),
                Phase::Reduce => self.reduce(shape, at),
                Phase::Probe => {
                    if !self.probe(shape, before, at, workspace, deadline)? {
                        return Ok(());
                    }
                }
                Phase::Done => {}
            }
        }
        self.at = end;
        // Counted again, because the flood adds items.
        if end == self.items().0 {
            (self.phase, self.at) = (next, 0);
        }
        Ok(())
    }

    /// Casts a ray, in A's frame, among the triangles of one side, or continues with it.
    fn cast(
        &mut self,
        shape: Shape,
        to_b: &Pose,
        side: usize,
        [mut place, mut way]: [DVec3; 2],
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<Option<RayHit>, StopReason> {
        if side == 1 {
            place = to_b.transform_point(place);
            way = *to_b.rotation() * way;
        }
        let Ok(ray) = Ray::new(place, way) else {
            return Ok(None);
        };
        let found = cast_alone(
            shape.trees[side],
            &ray,
            self.is_casting,
            workspace,
            deadline,
        );
        self.is_casting = found.is_err();
        found
    }
}

fn neighbors(tree: &Tree, triangle: u32) -> impl Iterator<Item = u32> + '_ {
    (0..3).filter_map(move |edge| tree.across(triangle, edge))
}

/// Continues with the overlaps until they are done or the deadline comes.
pub(crate) fn advance(
    shape: Shape,
    before: Before,
    workspace: &mut Workspace,
    deadline: &mut Deadline,
) -> StopReason {
    let mut state = mem::take(&mut workspace.state.manifolds.overlaps);
    let stop = loop {
        if state.is_done() {
            break StopReason::Finished;
        }
        let step = deadline.step(workspace, |workspace, deadline| {
            state.step(shape, before, workspace, deadline)
        });
        if let Err(reason) = step {
            break reason;
        }
    };
    workspace.state.manifolds.overlaps = state;
    stop
}

/// Receives the contacts of a query for manifolds, in place of the list.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reduction {
    pub is_on: bool,
    pub skin: Skin,
    /// The last pair that was tested for an intersection.
    compared: Option<[u32; 2]>,
    /// True when all pairs are listed.
    pub is_listed: bool,
    /// The nearest of the pairs so far (tree order), and its distance.
    pub nearest: Option<([u32; 2], f64)>,
    /// True until the first call of the query.
    pub is_new: bool,
}

impl Reduction {
    pub fn clear(&mut self) {
        if self.is_on {
            self.skin.clear();
            (self.is_on, self.is_listed) = (false, false);
            (self.nearest, self.compared) = (None, None);
        }
    }

    /// Prepares for a query with a skin of this width. `size` is that of the smaller mesh.
    pub fn begin(&mut self, width: f64, size: f64, shape: Shape, overlaps: &mut Overlaps) {
        (self.is_on, self.is_new) = (true, true);
        overlaps.clear();
        overlaps.inset.begin(shape);
        self.skin.begin(width, overlaps.inset.reach(), size);
    }

    /// How far reduced points may be off the surfaces.
    pub fn reach(&self) -> f64 {
        if self.is_on { self.skin.reach } else { 0.0 }
    }

    /// Does the next step with two triangles (tree order) that may intersect, or be as close as B
    /// is drawn in. Returns true if it was the last one.
    ///
    /// 1. Until the surfaces are known to meet: do these triangles meet, and if not, how far apart
    ///    are they? Those clearly apart are of the skin.
    /// 2. How far are the corners of B's triangle drawn in?
    /// 3. With B drawn in: a pair of a curve, or one of the skin.
    pub fn take_near(
        &mut self,
        shape: Shape,
        pair: [u32; 2],
        [a, b]: [&[DVec3; 3]; 2],
        overlaps: &mut Overlaps,
        contacts: &mut ContactList,
        stats: &mut Stats,
    ) -> bool {
        let is_compared = overlaps.met.is_some() || self.compared == Some(pair);
        if is_compared && overlaps.inset.learn(shape, pair[1]) {
            stats.work += WORK_PER_WAY;
            return false;
        }
        stats.exact_tests += 1;
        stats.work += WORK_PER_EXACT_TEST;
        if !is_compared {
            self.compared = Some(pair);
            if triangles_intersect(a, b) {
                overlaps.met = Some(pair);
                self.note(pair, 0.0);
                return false;
            }
            let found = Self::closest(pair, [a, b], stats);
            if found.low <= self.skin.width {
                self.note(pair, found.high);
                if found.low > CLEAR * self.skin.reach {
                    self.keep(shape, pair, [a, b], &found, stats);
                    return true;
                }
                return false;
            }
            return true;
        }
        let [inner, ways] = overlaps.inset.corners(shape, pair[1]);
        if let Some(segment) = triangle_segment(a, &inner) {
            stats.work += WORK_PER_SEGMENT + WORK_PER_CONTACT;
            stats.found += 1;
            contacts.hold();
            overlaps.take(pair, [a, &inner], segment);
            self.skin.take_crossing([a, b]);
            return true;
        }
        let mut found = Self::closest(pair, [a, &inner], stats);
        // The place on B itself, and how far A is before it.
        let nearest = [0, 1, 2].map(|i| (inner[i] - found.points[1]).length_squared());
        let corner = (0..3).fold(0, |i, j| if nearest[j] < nearest[i] { j } else { i });
        found.points[1] -= ways[corner];
        found.high += ways[corner].dot(found.direction);
        if found.high <= self.skin.width {
            self.keep(shape, pair, [a, b], &found, stats);
        }
        true
    }

    /// The closest points of two triangles that are apart, with the normal of their contact.
    fn closest(pair: [u32; 2], [a, b]: [&[DVec3; 3]; 2], stats: &mut Stats) -> Closest {
        stats.work += WORK_PER_CLOSEST_POINTS;
        let mut found = closest(a, b).of_apart(a, b);
        found.direction = Contact::apart(pair, [a, b], &found).normal;
        found
    }

    /// Adds a pair to the skin.
    fn keep(
        &mut self,
        shape: Shape,
        pair: [u32; 2],
        corners: [&[DVec3; 3]; 2],
        found: &Closest,
        stats: &mut Stats,
    ) {
        stats.work += WORK_PER_CONTACT;
        stats.found += 1;
        self.skin.take(shape, pair, corners, found);
    }

    /// Adds the common area of two triangles whose contact adds nothing else.
    pub fn take_area(&mut self, corners: [&[DVec3; 3]; 2], stats: &mut Stats) {
        stats.work += WORK_PER_AREA;
        self.skin.add_area(corners);
    }

    /// Records a pair of triangles (tree order) that are this far apart.
    pub fn note(&mut self, pair: [u32; 2], distance: f64) {
        if self.nearest.is_none_or(|(_, least)| distance < least) {
            self.nearest = Some((pair, distance));
        }
    }
}
