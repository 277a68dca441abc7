//! Overlaps of two surfaces that meet: from the pairs of triangles that intersect to manifolds.
//!
//! 1. *Link*: pairs that share a triangle, and whose other triangles are neighbors, belong to one
//!    contact curve.
//! 2. *Classify*: the vertices of uncut triangles beside the curves are joined into classes; of
//!    each class one vertex is tested: inside the other surface or not.
//! 3. *Flood*: from vertices inside over uncut triangles. Curves that bound one region belong
//!    together.
//! 4. *Measure*: the area vector of a region is half the sum of `(s - c) x (e - c)` over the
//!    segments from `s` to `e` of its curves. It does not depend on `c`, because curves are closed.
//! 5. *Reduce* the vertices of each region to the deepest and to the farthest along eight
//!    directions.
//! 6. *Probe* depths along the normal, by rays from these vertices and from points of the curves.
//!
//! Each step takes bounded work, and everything between steps is in [`Overlaps`].

use super::deadline::Deadline;
use super::outcome::StopReason;
use super::ray::{RayHit, cast_alone};
use super::workspace::Workspace;
use crate::contact::manifold::{Manifold, ManifoldPoint, Octagon, Shape};
use crate::math::{Pose, Ray, length};
use crate::model::cost::{WORK_PER_CURVE_PAIR, WORK_PER_LOOKUP, WORK_PER_REGION_TRIANGLE};
use crate::tree::Tree;
use crate::triangle::ray::Side;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::mem;
use glam::DVec3;

/// Maximum number of triangles in the regions of the overlaps of one query; those beyond are not
/// looked at ([`Manifold::is_whole`]).
pub const REGION_LIMIT: usize = 1 << 16;

/// Work of a step on each pair, about what it takes.
const STEP: usize = 4;

/// Two triangles that intersect.
#[derive(Clone, Copy, Debug)]
struct Cut {
    /// In tree order.
    pair: [u32; 2],
    /// Directed along the cross product of the normals of A's triangle and of B's.
    segment: [DVec3; 2],
    /// True if the triangles lie in one plane, so that the segment has no direction.
    is_flat: bool,
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

/// The value of cut triangles; flooded ones have one more than the pair that the flood came from.
const CUT: u32 = 0;

/// Vertices of one mesh that are all inside the other, or all not.
#[derive(Clone, Copy, Debug)]
struct Class {
    parent: u32,
    side: u8,
    vertex: u32,
    is_inside: bool,
    /// A pair whose curve bounds the region of the class.
    claim: u32,
}

const NOBODY: u32 = u32::MAX;

/// An uncut triangle inside the other surface.
#[derive(Clone, Copy, Debug)]
struct Flooded {
    side: u8,
    triangle: u32,
    cut: u32,
}

/// A piece of contact.
#[derive(Clone, Debug)]
struct Group {
    length: f64,
    /// Middle of the curves.
    middle: DVec3,
    sum: DVec3,
    area: DVec3,
    /// Sum of the magnitudes of all parts of the area vector.
    whole_area: f64,
    normal: DVec3,
    cuts: u32,
    /// The farthest vertices of A and of B in the region, and the farthest points of the curves.
    farthest: [Octagon<DVec3>; 3],
    /// The deepest vertex of A, and of B: the least height along the normal, the largest.
    deepest: [Option<(f64, DVec3)>; 2],
    is_whole: bool,
    /// True if the surfaces touch without an area.
    is_touching: bool,
    found: ArrayVec<ManifoldPoint, PROBES>,
    /// Probes between whose ends both surfaces are left at once.
    through: u32,
}

/// Maximum number of pairs of a group that decide its normal if it has no area.
const TOUCHING: usize = 16;

/// Maximum number of probes of a group.
const PROBES: usize = 28;

/// Maximum number of rays of a probe.
const RAYS: usize = 6;

/// A length that is this much less counts as equal.
const NEARLY: f64 = 1.0 - 1e-6;

/// Where a ray leaves a surface that is around its origin.
fn exit(hit: Option<RayHit>) -> Option<f64> {
    hit.filter(|hit| hit.side != Side::Front).map(|hit| hit.t)
}

/// Where the middle between the first two hits is, along the normal.
fn middle(hits: &[Option<RayHit>; RAYS]) -> f64 {
    let [back, forth] = [0, 1].map(|ray| exit(hits[ray]).unwrap_or(0.0));
    0.5 * (forth - back)
}

/// Where a depth is measured.
#[derive(Clone, Copy, Debug)]
enum Probe {
    /// From a vertex of A or of B to the other surface.
    Vertex(usize, DVec3),
    /// From a point inside both to both surfaces.
    Inner(DVec3),
}

/// What comes next, with the index of the next item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Link(usize),
    Classify(usize),
    Test(usize),
    Seed(usize),
    Flood(usize),
    Measure,
    Reduce(usize),
    /// The group, its probe, and the ray of the probe.
    Probe(usize, usize, usize),
    Done,
}

/// The overlaps of a query.
#[derive(Clone, Debug)]
pub(super) struct Overlaps {
    cuts: Vec<Cut>,
    meets: bool,
    phase: Phase,
    /// Union-find over the pairs.
    parents: Vec<u32>,
    /// Hash table of the pairs.
    slots: Vec<u32>,
    triangles: [Marks; 2],
    vertices: [Marks; 2],
    classes: Vec<Class>,
    region: Vec<Flooded>,
    groups: Vec<Group>,
    probes: ArrayVec<Probe, PROBES>,
    hits: [Option<RayHit>; RAYS],
    /// A ray is under way in the workspace.
    is_casting: bool,
}

impl Default for Overlaps {
    fn default() -> Self {
        Self {
            cuts: Vec::new(),
            meets: false,
            phase: Phase::Done,
            parents: Vec::new(),
            slots: Vec::new(),
            triangles: Default::default(),
            vertices: Default::default(),
            classes: Vec::new(),
            region: Vec::new(),
            groups: Vec::new(),
            probes: ArrayVec::new(),
            hits: [None; RAYS],
            is_casting: false,
        }
    }
}

fn find(parents: &mut [u32], mut i: u32) -> u32 {
    while parents[i as usize] != i {
        let above = parents[parents[i as usize] as usize];
        parents[i as usize] = above;
        i = above;
    }
    i
}

fn unite(parents: &mut [u32], i: u32, j: u32) {
    let (i, j) = (find(parents, i), find(parents, j));
    parents[i.max(j) as usize] = i.min(j);
}

fn hash([a, b]: [u32; 2]) -> u64 {
    let x = (u64::from(a) << 32 | u64::from(b)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^ x >> 29
}

impl Overlaps {
    pub fn clear(&mut self) {
        self.cuts.clear();
        self.groups.clear();
        (self.phase, self.meets, self.is_casting) = (Phase::Link(0), false, false);
    }

    /// True if a pair intersects.
    pub fn meets(&self) -> bool {
        self.meets
    }

    pub fn is_done(&self) -> bool {
        self.phase == Phase::Done
    }

    pub fn reserve(&mut self, cuts: usize) {
        self.cuts.reserve(cuts.saturating_sub(self.cuts.len()));
    }

    /// Takes two triangles (tree order) that intersect in this segment.
    pub fn take(&mut self, pair: [u32; 2], [a, b]: [&[DVec3; 3]; 2], segment: [DVec3; 2]) {
        let normal = |[p, q, r]: &[DVec3; 3]| (*q - *p).cross(*r - *p).normalize_or_zero();
        let across = normal(a).cross(normal(b));
        self.meets = true;
        self.cuts.push(Cut {
            pair,
            segment,
            is_flat: across.length_squared() < FLAT * FLAT,
            is_first: [false; 2],
            group: 0,
        });
    }

    /// Takes two triangles (tree order) that all but intersect, at this point.
    pub fn take_touching(&mut self, pair: [u32; 2], place: DVec3) {
        self.cuts.push(Cut {
            pair,
            segment: [place; 2],
            is_flat: true,
            is_first: [false; 2],
            group: 0,
        });
    }

    /// Prepares for the first step, after the last pair.
    fn begin(&mut self, trees: [&Tree; 2]) {
        let count = self.cuts.len();
        self.parents.clear();
        self.parents.extend(0..count as u32);
        self.slots.clear();
        self.slots.resize((2 * count).next_power_of_two(), NOBODY);
        self.classes.clear();
        self.region.clear();
        self.groups.clear();
        for (side, tree) in trees.into_iter().enumerate() {
            self.triangles[side].begin(tree.mesh().len(), count + 1);
            self.vertices[side].begin(tree.mesh().vertex_count(), 12 * count);
        }
    }

    /// The place in the table of a pair, and the pair there.
    fn slot(&self, pair: [u32; 2]) -> (usize, Option<u32>) {
        let mask = self.slots.len() - 1;
        let mut slot = hash(pair) as usize & mask;
        loop {
            let there = self.slots[slot];
            if there == NOBODY {
                return (slot, None);
            }
            if self.cuts[there as usize].pair == pair {
                return (slot, Some(there));
            }
            slot = (slot + 1) & mask;
        }
    }

    fn link(&mut self, trees: [&Tree; 2], at: usize) {
        let pair = self.cuts[at].pair;
        for side in 0..2 {
            let marks = &mut self.triangles[side];
            self.cuts[at].is_first[side] = marks.get(pair[side]).is_none();
            marks.set(pair[side], CUT);
        }
        let (slot, known) = self.slot(pair);
        if let Some(known) = known {
            return unite(&mut self.parents, known, at as u32);
        }
        self.slots[slot] = at as u32;
        for side in 0..2 {
            for edge in 0..3 {
                let Some(next) = trees[side].across(pair[side], edge) else {
                    continue;
                };
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

    /// The class of a vertex, which becomes one of its own if it has none.
    fn class(&mut self, side: usize, vertex: u32) -> u32 {
        if let Some(class) = self.vertices[side].get(vertex) {
            return class;
        }
        let class = self.classes.len() as u32;
        self.classes.push(Class {
            parent: class,
            side: side as u8,
            vertex,
            is_inside: false,
            claim: NOBODY,
        });
        self.vertices[side].set(vertex, class);
        class
    }

    fn class_root(&mut self, mut class: u32) -> u32 {
        while self.classes[class as usize].parent != class {
            let above = self.classes[self.classes[class as usize].parent as usize].parent;
            self.classes[class as usize].parent = above;
            class = above;
        }
        class
    }

    fn classify(&mut self, trees: [&Tree; 2], at: usize) {
        let Cut { pair, is_first, .. } = self.cuts[at];
        for side in 0..2 {
            if !is_first[side] {
                continue;
            }
            for vertex in trees[side].vertices_of(pair[side]) {
                self.class(side, vertex);
            }
            for next in (0..3).filter_map(|edge| trees[side].across(pair[side], edge)) {
                if self.is_cut(side, next) {
                    continue;
                }
                let [p, q, r] = trees[side].vertices_of(next);
                for other in [q, r] {
                    let (p, other) = (self.class(side, p), self.class(side, other));
                    let (p, other) = (self.class_root(p), self.class_root(other));
                    self.classes[p.max(other) as usize].parent = p.min(other);
                }
            }
        }
    }

    fn is_inside(&mut self, side: usize, vertex: u32) -> Option<u32> {
        let class = self.vertices[side].get(vertex)?;
        let root = self.class_root(class);
        self.classes[root as usize].is_inside.then_some(root)
    }

    /// Starts the flood beside a pair.
    fn seed(&mut self, trees: [&Tree; 2], at: usize) {
        let pair = self.cuts[at].pair;
        for side in 0..2 {
            for vertex in trees[side].vertices_of(pair[side]) {
                let Some(class) = self.is_inside(side, vertex) else {
                    continue;
                };
                let claim = &mut self.classes[class as usize].claim;
                if *claim == NOBODY {
                    *claim = at as u32;
                }
                unite(&mut self.parents, *claim, at as u32);
            }
            for next in (0..3).filter_map(|edge| trees[side].across(pair[side], edge)) {
                let [vertex, ..] = trees[side].vertices_of(next);
                if !self.is_cut(side, next) && self.is_inside(side, vertex).is_some() {
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
        let Flooded {
            side,
            triangle,
            cut,
        } = self.region[at];
        let tree = trees[usize::from(side)];
        for next in (0..3).filter_map(|edge| tree.across(triangle, edge)) {
            self.flood_into(side.into(), next, cut);
        }
    }

    /// Makes the groups, with their area vectors and normals.
    fn measure(&mut self, shape: Shape) {
        for at in 0..self.cuts.len() {
            let root = find(&mut self.parents, at as u32) as usize;
            let group = if root == at {
                self.groups.push(Group::EMPTY);
                self.groups.len() - 1
            } else {
                self.cuts[root].group as usize
            };
            self.cuts[at].group = group as u32;
            self.groups[group].count(&self.cuts[at]);
        }
        for group in &mut self.groups {
            group.middle = if group.length > 0.0 {
                group.middle / group.length
            } else {
                group.sum
            };
        }
        for cut in &self.cuts {
            self.groups[cut.group as usize].add_area(cut);
        }
        let is_whole = self.region.len() < REGION_LIMIT;
        for at in 0..self.groups.len() {
            let group = &mut self.groups[at];
            group.is_whole = is_whole;
            group.is_touching =
                group.whole_area <= ROUNDING * ROUNDING * group.length * group.length;
            if group.is_touching {
                let normal = self.normal_of_touch(shape, at as u32);
                self.groups[at].normal = normal;
            } else if group.area.length() > ROUNDING * group.whole_area {
                group.normal = -group.area.normalize_or_zero();
            }
            let group = &mut self.groups[at];
            group.farthest = [Octagon::new(group.axis()); 3];
        }
    }

    /// The direction that separates a group that touches without an area: of the normals of its
    /// faces the one along which all its pairs overlap the least.
    fn normal_of_touch(&self, shape: Shape, group: u32) -> DVec3 {
        let corners = |cut: &Cut| {
            let [a, b] = [0, 1].map(|side| shape.trees[side].corners(cut.pair[side]));
            [a, b.map(|corner| shape.b_in_a.transform_point(corner))]
        };
        let normal = |[p, q, r]: &[DVec3; 3]| (*q - *p).cross(*r - *p).normalize_or_zero();
        let mut pairs: ArrayVec<_, TOUCHING> = ArrayVec::new();
        let members = self.cuts.iter().filter(|cut| cut.group == group);
        pairs.extend(members.take(TOUCHING).map(corners));
        let overlap = |way: DVec3, [a, b]: &[[DVec3; 3]; 2]| {
            let most = b.iter().map(|p| p.dot(way)).fold(f64::NEG_INFINITY, f64::max);
            let least = a.iter().map(|p| p.dot(way)).fold(f64::INFINITY, f64::min);
            most - least
        };
        let mean: DVec3 = pairs.iter().map(|[a, b]| normal(b) - normal(a)).sum();
        let ways = pairs.iter().flat_map(|[a, b]| [normal(b), -normal(a)]);
        let ways = ways.chain([mean.normalize_or_zero()]);
        let overlap = |way| pairs.iter().map(|pair| overlap(way, pair)).fold(0.0, f64::max);
        ways.filter(|way| *way != DVec3::ZERO)
            .map(|way| (overlap(way), way))
            .fold((f64::INFINITY, DVec3::ZERO), |best, other| {
                if other.0 < best.0 { other } else { best }
            })
            .1
    }

    /// Takes the points of a cut, or of a flooded triangle, into the extremes of its group.
    fn reduce(&mut self, shape: Shape, at: usize) {
        let place = |side: usize, vertex: u32| {
            let place = shape.trees[side].mesh().vertices().get(vertex as usize);
            if side == 0 {
                place
            } else {
                shape.b_in_a.transform_point(place)
            }
        };
        if let Some(cut) = self.cuts.get(at).copied() {
            for point in cut.segment {
                self.groups[cut.group as usize].farthest[2].insert(point, point);
            }
            for side in 0..2 {
                for vertex in shape.trees[side].vertices_of(cut.pair[side]) {
                    if self.is_inside(side, vertex).is_some() {
                        self.groups[cut.group as usize].insert(side, place(side, vertex));
                    }
                }
            }
        } else {
            let Flooded {
                side,
                triangle,
                cut,
            } = self.region[at - self.cuts.len()];
            let side = usize::from(side);
            let group = self.cuts[cut as usize].group as usize;
            for vertex in shape.trees[side].vertices_of(triangle) {
                self.groups[group].insert(side, place(side, vertex));
            }
        }
    }

    /// The overlaps that are done.
    pub fn manifolds(&self) -> impl Iterator<Item = Manifold> {
        let done = self.is_done();
        self.groups
            .iter()
            .filter(move |_| done)
            .map(Group::manifold)
    }
}

/// Sine of the angle between two triangles up to which they lie in one plane.
const FLAT: f64 = 1e-9;

/// Relative size of an area vector, or of the step between the ends of a curve, that counts as
/// rounding.
const ROUNDING: f64 = 1e-9;

/// Of vertices one above the other the deeper counts as farther, by this part of the difference.
const LEAN: f64 = 0.1;

/// Points of a curve are moved this far to its middle before their depth is measured.
const INWARD: f64 = 0.1;

impl Group {
    const EMPTY: Self = Self {
        length: 0.0,
        middle: DVec3::ZERO,
        sum: DVec3::ZERO,
        area: DVec3::ZERO,
        whole_area: 0.0,
        normal: DVec3::ZERO,
        cuts: 0,
        farthest: [Octagon {
            axes: [DVec3::ZERO; 4],
            reach: [f64::NEG_INFINITY; 8],
            values: [None; 8],
        }; 3],
        deepest: [None; 2],
        is_whole: true,
        is_touching: false,
        found: ArrayVec::new_const(),
        through: 0,
    };

    fn count(&mut self, cut: &Cut) {
        let [start, end] = cut.segment;
        self.cuts += 1;
        if cut.is_flat {
            // Stands in for the middle where there is nothing else.
            if self.length == 0.0 {
                self.sum = start;
            }
            return;
        }
        let step = length(end - start);
        if self.length == 0.0 {
            self.sum = if step > 0.0 { DVec3::ZERO } else { start };
        }
        self.length += step;
        self.middle += step * (0.5 * start + 0.5 * end);
    }

    fn add_area(&mut self, cut: &Cut) {
        let [start, end] = cut.segment;
        if cut.is_flat {
            return;
        }
        let part = 0.5 * (start - self.middle).cross(end - self.middle);
        self.area += part;
        self.whole_area += part.length();
    }

    /// The normal, or any direction if there is none.
    fn axis(&self) -> DVec3 {
        if self.normal == DVec3::ZERO {
            DVec3::Z
        } else {
            self.normal
        }
    }

    fn insert(&mut self, side: usize, place: DVec3) {
        let height = place.dot(self.normal);
        // A's deepest vertex is the lowest, B's the highest.
        let height = if side == 0 { -height } else { height };
        self.farthest[side].insert_with(place, LEAN * height, place);
        if self.deepest[side].is_none_or(|(before, _)| height > before) {
            self.deepest[side] = Some((height, place));
        }
    }

    fn probes(&self) -> ArrayVec<Probe, PROBES> {
        let mut probes: ArrayVec<Probe, PROBES> = ArrayVec::new();
        if self.normal == DVec3::ZERO || self.is_touching {
            return probes;
        }
        let mut vertices: ArrayVec<(usize, DVec3), 18> = ArrayVec::new();
        for side in 0..2 {
            let deepest = self.deepest[side].map(|(_, place)| place);
            for place in self.farthest[side].values().copied().chain(deepest) {
                if !vertices.contains(&(side, place)) {
                    vertices.push((side, place));
                }
            }
        }
        probes.extend(
            vertices
                .into_iter()
                .map(|(side, place)| Probe::Vertex(side, place)),
        );
        probes.push(Probe::Inner(self.middle));
        for place in self.farthest[2].values() {
            let inner = place.lerp(self.middle, INWARD);
            let is_known = probes
                .iter()
                .any(|probe| matches!(probe, Probe::Inner(known) if *known == inner));
            if !is_known {
                let _ = probes.try_push(Probe::Inner(inner));
            }
        }
        probes
    }

    /// Takes the hits of the rays of a probe. For a vertex there is one, of the other surface. For
    /// an inner point, which may lie on a surface, the first two lead to a place between the
    /// surfaces: of A backwards and of B forwards. From there the depth is measured: of A backwards
    /// and of B forwards; then of A forwards and of B backwards: between two ends of one region,
    /// both surfaces are around.
    fn probed(&mut self, probe: Probe, hits: [Option<RayHit>; RAYS]) {
        let (points, depth) = match probe {
            Probe::Vertex(side, place) => {
                let Some(depth) = exit(hits[0]) else { return };
                let along = depth * self.normal;
                let points = if side == 0 {
                    [place, place + along]
                } else {
                    [place - along, place]
                };
                (points, depth)
            }
            Probe::Inner(place) => {
                let [Some(back), Some(forth), Some(of_a), Some(of_b)] =
                    [2, 3, 4, 5].map(|ray| exit(hits[ray]))
                else {
                    self.through += 1;
                    return;
                };
                if of_a < forth * NEARLY || of_b < back * NEARLY {
                    self.through += 1;
                    return;
                }
                let place = place + middle(&hits) * self.normal;
                (
                    [place - back * self.normal, place + forth * self.normal],
                    back + forth,
                )
            }
        };
        self.found
            .push(ManifoldPoint::new(points, self.normal, -depth));
    }

    fn manifold(&self) -> Manifold {
        let (mut normal, mut found) = (self.normal, self.found.clone());
        if self.through as usize > found.len() {
            normal = DVec3::ZERO;
        }
        if found.is_empty() || normal == DVec3::ZERO {
            found.clear();
            let curve = self.farthest[2].values();
            found.extend(curve.map(|&place| ManifoldPoint::new([place; 2], normal, 0.0)));
        }
        let mut manifold = Manifold::of(self.axis(), &found);
        manifold.normal = normal;
        manifold.is_overlap = true;
        manifold.is_whole = self.is_whole;
        manifold.area = self.area.length();
        if self.length > 0.0 {
            manifold.centroid = self.middle;
        }
        manifold
    }
}

/// Continues with the overlaps until they are done or the deadline stops.
pub(super) fn advance(
    shape: Shape,
    to_b: &Pose,
    workspace: &mut Workspace,
    deadline: &mut Deadline,
) -> StopReason {
    let mut state = mem::take(&mut workspace.overlaps);
    let stop = loop {
        if state.phase == Phase::Done {
            break StopReason::Finished;
        }
        if !state.is_casting {
            deadline.begin(workspace.run.stats.work);
            let stop = deadline.stop(workspace.run.stats.work);
            if let Some(reason) = stop {
                break reason;
            }
        }
        let result = state.step(shape, to_b, workspace, deadline);
        deadline.end(workspace.run.stats.work);
        if let Err(reason) = result {
            break reason;
        }
    };
    workspace.overlaps = state;
    stop
}

impl Overlaps {
    /// One step of bounded work.
    fn step(
        &mut self,
        shape: Shape,
        to_b: &Pose,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<(), StopReason> {
        let (trees, count) = (shape.trees, self.cuts.len());
        let work = &mut workspace.run.stats.work;
        let until = |at: usize, end: usize| (at + STEP).min(end);
        match self.phase {
            Phase::Link(0) if self.cuts.is_empty() => self.phase = Phase::Done,
            Phase::Link(at) => {
                if at == 0 {
                    self.begin(trees);
                    *work += count as u64;
                }
                let end = until(at, count);
                (at..end).for_each(|at| self.link(trees, at));
                *work += (end - at) as u64 * WORK_PER_CURVE_PAIR;
                self.phase = if end == count {
                    Phase::Classify(0)
                } else {
                    Phase::Link(end)
                };
            }
            Phase::Classify(at) => {
                let end = until(at, count);
                (at..end).for_each(|at| self.classify(trees, at));
                *work += (end - at) as u64 * WORK_PER_CURVE_PAIR;
                self.phase = if end == count {
                    Phase::Test(0)
                } else {
                    Phase::Classify(end)
                };
            }
            Phase::Test(at) => {
                let Some(class) = self.classes.get(at).copied() else {
                    self.phase = Phase::Seed(0);
                    return Ok(());
                };
                if class.parent == at as u32 {
                    let side = usize::from(class.side);
                    let place = trees[side].mesh().vertices().get(class.vertex as usize);
                    let place = if side == 0 {
                        to_b.transform_point(place)
                    } else {
                        shape.b_in_a.transform_point(place)
                    };
                    let way = DVec3::new(0.267_261_241_912_424_4, 0.534_522_483_824_848_8, 0.801_783_725_737_273_2);
                    let hit = self.cast(trees[1 - side], place, way, workspace, deadline)?;
                    self.classes[at].is_inside = hit.is_some_and(|hit| hit.side == Side::Back);
                } else {
                    *work += WORK_PER_LOOKUP;
                }
                self.phase = Phase::Test(at + 1);
            }
            Phase::Seed(at) => {
                let end = until(at, count);
                (at..end).for_each(|at| self.seed(trees, at));
                *work += (end - at) as u64 * WORK_PER_CURVE_PAIR;
                self.phase = if end == count {
                    Phase::Flood(0)
                } else {
                    Phase::Seed(end)
                };
            }
            Phase::Flood(at) => {
                let end = until(at, self.region.len());
                (at..end).for_each(|at| self.flood(trees, at));
                *work += (end - at) as u64 * WORK_PER_REGION_TRIANGLE;
                self.phase = if end == self.region.len() {
                    Phase::Measure
                } else {
                    Phase::Flood(end)
                };
            }
            Phase::Measure => {
                self.measure(shape);
                *work += count as u64 * WORK_PER_CURVE_PAIR;
                self.phase = Phase::Reduce(0);
            }
            Phase::Reduce(at) => {
                let all = count + self.region.len();
                let end = until(at, all);
                (at..end).for_each(|at| self.reduce(shape, at));
                *work += (end - at) as u64 * WORK_PER_REGION_TRIANGLE;
                self.phase = if end == all {
                    Phase::Probe(0, 0, 0)
                } else {
                    Phase::Reduce(end)
                };
            }
            Phase::Probe(group, probe, ray) => {
                if group == self.groups.len() {
                    self.phase = Phase::Done;
                    return Ok(());
                }
                if (probe, ray) == (0, 0) && !self.is_casting {
                    self.probes = self.groups[group].probes();
                }
                let Some(&at) = self.probes.get(probe) else {
                    self.phase = Phase::Probe(group + 1, 0, 0);
                    return Ok(());
                };
                let normal = self.groups[group].normal;
                let (tree, place, way, rays) = match at {
                    Probe::Vertex(0, place) => (1, place, normal, 1),
                    Probe::Vertex(_, place) => (0, place, -normal, 1),
                    Probe::Inner(place) => {
                        let is_back = [true, false, true, false, false, true][ray];
                        let way = if is_back { -normal } else { normal };
                        let shift = if ray < 2 { 0.0 } else { middle(&self.hits) };
                        (ray % 2, place + shift * normal, way, RAYS)
                    }
                };
                let (place, way) = if tree == 0 {
                    (place, way)
                } else {
                    (to_b.transform_point(place), *to_b.rotation() * way)
                };
                self.hits[ray] = self.cast(trees[tree], place, way, workspace, deadline)?;
                self.phase = if ray + 1 < rays {
                    Phase::Probe(group, probe, ray + 1)
                } else {
                    let hits = mem::take(&mut self.hits);
                    self.groups[group].probed(at, hits);
                    Phase::Probe(group, probe + 1, 0)
                };
            }
            Phase::Done => {}
        }
        Ok(())
    }

    /// Casts a ray, or continues with it.
    fn cast(
        &mut self,
        tree: &Tree,
        place: DVec3,
        way: DVec3,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<Option<RayHit>, StopReason> {
        let Ok(ray) = Ray::new(place, way) else {
            return Ok(None);
        };
        let found = cast_alone(tree, &ray, self.is_casting, workspace, deadline);
        self.is_casting = found.is_err();
        found
    }
}
