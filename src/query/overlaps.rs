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

pub(super) mod run;

use super::ray::state::RayHit;
use crate::contact::manifold::{Before, Manifold, ManifoldPoint, Octagon, Shape, Skin, choose};
use crate::sets::{find, unite};
use crate::tree::Tree;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual_geom::length;
use punctual_geom::triangle::ray::Side;

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
    /// Sum of the middles of the segments, by length.
    moment: DVec3,
    /// A point of the curves.
    point: DVec3,
    area: DVec3,
    /// Sum of the magnitudes of all parts of the area vector.
    whole_area: f64,
    normal: DVec3,
    /// The number of its pairs, and the first of them.
    cuts: u32,
    first: u32,
    /// The farthest vertices of A and of B in the region, and the farthest points of the curves.
    farthest: [Octagon<DVec3>; 3],
    /// The deepest vertex of A, and of B: the least height along the normal, the largest.
    deepest: [Option<(f64, DVec3)>; 2],
    /// True if the surfaces touch without an area.
    is_touching: bool,
}

/// Maximum number of pairs of a group that decide its normal if it has no area.
const TOUCHING: usize = 16;

/// They are searched among this many pairs.
const AMONG: usize = 1024;

/// Maximum number of probes of a group in each of two stages.
const PROBES: usize = 4;

/// Maximum number of points found in a group: one a probe, and those of its curve.
const FOUND: usize = 16;

/// A group of no more pairs than this has no probe in its middle if it has vertices.
const FEW: u32 = 16;

/// A group of no more pairs than this is small.
const SMALL: u32 = 6;

/// Maximum number of rays of a probe.
const RAYS: usize = 6;

/// A length that is this much less counts as equal.
const NEARLY: f64 = 1.0 - 1e-6;

/// Where a ray leaves a surface that is around its origin.
fn exit(hit: Option<RayHit>) -> Option<f64> {
    hit.filter(|hit| hit.side != Side::Front).map(|hit| hit.t)
}

/// A direction along which few meshes have edges or faces: a unit vector.
const ACROSS: DVec3 = DVec3::new(
    0.267_261_241_912_424_4,
    0.534_522_483_824_848_8,
    0.801_783_725_737_273_2,
);

/// True if the exact test of inside holds. Of other surfaces the nearest hit tells, as far as they
/// have an inner side.
fn is_closed(tree: &Tree) -> bool {
    tree.solid().is_some_and(|solid| solid.is_closed())
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
    Measure(usize),
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
    slots: Marks,
    triangles: [Marks; 2],
    vertices: [Marks; 2],
    /// Vertices that are reduced.
    taken: [Marks; 2],
    classes: Vec<Class>,
    region: Vec<Flooded>,
    groups: Vec<Group>,
    probing: Probing,
    /// The manifolds of the groups that are done.
    done: Vec<Manifold>,
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
            slots: Marks::default(),
            triangles: Default::default(),
            vertices: Default::default(),
            taken: Default::default(),
            classes: Vec::new(),
            region: Vec::new(),
            groups: Vec::new(),
            probing: Probing::default(),
            done: Vec::new(),
            is_casting: false,
        }
    }
}

fn hash([a, b]: [u32; 2]) -> u64 {
    let x = (u64::from(a) << 32 | u64::from(b)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^ x >> 29
}

impl Overlaps {
    pub fn clear(&mut self) {
        self.cuts.clear();
        self.groups.clear();
        self.done.clear();
        self.probing.stage = Stage::None;
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
        self.slots.begin((2 * count).next_power_of_two(), count);
        self.classes.clear();
        self.region.clear();
        self.groups.clear();
        self.probing.found.reserve(FOUND);
        for (side, tree) in trees.into_iter().enumerate() {
            self.triangles[side].begin(tree.mesh().len(), count + 1);
            let vertices = tree.mesh().vertex_count();
            self.vertices[side].begin(vertices, 12 * count);
            self.taken[side].begin(vertices, 1);
        }
    }

    /// The place in the table of a pair, and the pair there.
    fn slot(&self, pair: [u32; 2]) -> (u32, Option<u32>) {
        let mask = (2 * self.cuts.len()).next_power_of_two() - 1;
        let mut slot = hash(pair) as usize & mask;
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

    /// Adds a pair to its group, which it makes if it is the first.
    fn gather(&mut self, at: usize) {
        let root = find(&mut self.parents, at as u32) as usize;
        let group = if root == at {
            self.groups.push(Group::EMPTY);
            self.groups.len() - 1
        } else {
            self.cuts[root].group as usize
        };
        self.cuts[at].group = group as u32;
        if self.groups[group].cuts == 0 {
            self.groups[group].first = at as u32;
        }
        self.groups[group].count(&self.cuts[at]);
    }

    /// Finds the normal of a group.
    fn find_normal(&mut self, shape: Shape, at: usize) {
        let group = &mut self.groups[at];
        let tree = shape.trees[0];
        let [p, q, _] = tree.corners(self.cuts[group.first as usize].pair[0]);
        group.is_touching = group.whole_area <= ROUNDING * ROUNDING * group.length * group.length
            || group.length <= ROUNDING * length(q - p);
        if group.is_touching {
            let normal = self.normal_of_touch(shape, at as u32);
            self.groups[at].normal = normal;
        } else if group.area.length() > ROUNDING * group.whole_area {
            group.normal = -group.area.normalize_or_zero();
        }
        let group = &mut self.groups[at];
        group.farthest = [Octagon::new(group.axis(), DVec3::ZERO); 3];
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
        let first = self.groups[group as usize].first as usize;
        let members = self.cuts[first..].iter().take(AMONG);
        let members = members.filter(|cut| cut.group == group);
        pairs.extend(members.take(TOUCHING).map(corners));
        let overlap = |way: DVec3, [a, b]: &[[DVec3; 3]; 2]| {
            let most = b
                .iter()
                .map(|p| p.dot(way))
                .fold(f64::NEG_INFINITY, f64::max);
            let least = a.iter().map(|p| p.dot(way)).fold(f64::INFINITY, f64::min);
            most - least
        };
        let mean: DVec3 = pairs.iter().map(|[a, b]| normal(b) - normal(a)).sum();
        let ways = pairs.iter().flat_map(|[a, b]| [normal(b), -normal(a)]);
        let ways = ways.chain([mean.normalize_or_zero()]);
        let overlap = |way| {
            pairs
                .iter()
                .map(|pair| overlap(way, pair))
                .fold(0.0, f64::max)
        };
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
                    if self.taken[side].get(vertex).is_none()
                        && self.is_inside(side, vertex).is_some()
                    {
                        self.taken[side].set(vertex, 0);
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
                if self.taken[side].get(vertex).is_none() {
                    self.taken[side].set(vertex, 0);
                    self.groups[group].insert(side, place(side, vertex));
                }
            }
        }
    }

    /// The overlaps whose depth is known.
    pub fn manifolds(&self) -> &[Manifold] {
        &self.done
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
        moment: DVec3::ZERO,
        point: DVec3::ZERO,
        area: DVec3::ZERO,
        whole_area: 0.0,
        normal: DVec3::ZERO,
        cuts: 0,
        first: 0,
        farthest: [Octagon::NONE; 3],
        deepest: [None; 2],
        is_touching: false,
    };

    fn count(&mut self, cut: &Cut) {
        let [start, end] = cut.segment;
        if self.cuts == 0 {
            self.point = start;
        }
        self.cuts += 1;
        if !cut.is_flat {
            let step = length(end - start);
            self.length += step;
            self.moment += step * (0.5 * start + 0.5 * end);
        }
    }

    /// Middle of the curves.
    fn middle(&self) -> DVec3 {
        if self.length > 0.0 {
            self.moment / self.length
        } else {
            self.point
        }
    }

    fn add_area(&mut self, cut: &Cut) {
        let [start, end] = cut.segment;
        if cut.is_flat {
            return;
        }
        let middle = self.middle();
        let part = 0.5 * (start - middle).cross(end - middle);
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

    /// Points of the curves, moved inward.
    fn inner(&self) -> impl Iterator<Item = Probe> {
        let curve = self.farthest[2].values();
        curve.map(|place| Probe::Inner(place.lerp(self.middle(), INWARD)))
    }

    /// The first probes: where the overlap is probably deepest.
    fn deep_probes(&self) -> ArrayVec<Probe, PROBES> {
        let vertex = |side: usize| {
            let deepest = self.deepest[side]?;
            Some(Probe::Vertex(side, deepest.1))
        };
        let mut probes: ArrayVec<Probe, PROBES> = [0, 1].into_iter().filter_map(vertex).collect();
        if probes.is_empty() || self.cuts > FEW {
            probes.push(Probe::Inner(self.middle()));
        }
        probes
    }

    /// The other probes: those that span most. Around a small region with a vertex, none: points of
    /// its curve, where the depth is 0, are `found` without rays.
    fn wide_probes(
        &self,
        found: &mut Vec<ManifoldPoint>,
        before: Before,
    ) -> ArrayVec<Probe, PROBES> {
        if self.cuts <= SMALL && !found.is_empty() {
            let curve = self.farthest[2].values();
            found.extend(curve.map(|&place| ManifoldPoint::new([place; 2], self.normal, 0.0)));
            return ArrayVec::new();
        }
        let vertices = |side: usize| {
            let places = self.farthest[side].values();
            places.map(move |&place| Probe::Vertex(side, place))
        };
        let all: ArrayVec<Probe, 24> = vertices(0).chain(vertices(1)).chain(self.inner()).collect();
        let middle = self.middle();
        let mut candidates: ArrayVec<ManifoldPoint, 24> = ArrayVec::new();
        for (id, probe) in (0..).zip(&all) {
            let (Probe::Vertex(_, place) | Probe::Inner(place)) = *probe;
            // A's deepest vertices are the lowest, B's the highest.
            let height = (place - middle).dot(self.normal);
            let distance = match probe {
                Probe::Vertex(0, _) => height,
                Probe::Vertex(..) => -height,
                Probe::Inner(_) => 0.0,
            };
            let mut candidate = ManifoldPoint::new([place; 2], self.normal, distance);
            candidate.id = id;
            candidates.push(candidate);
        }
        let chosen = choose(self.normal, &candidates, 1.0, before.stay(&candidates));
        let probes = chosen.iter().map(|candidate| all[candidate.id as usize]);
        probes.collect()
    }

    /// The manifold of the points found.
    fn manifold(&self, probing: &mut Probing, before: Before, is_whole: bool) -> Manifold {
        let found = &mut probing.found;
        // Of equal depths, those that span most come first.
        found.reverse();
        let mut normal = self.normal;
        if probing.through as usize > found.len() && !probing.is_unknown {
            normal = DVec3::ZERO;
        }
        if found.is_empty() || normal == DVec3::ZERO {
            found.clear();
            let curve = self.farthest[2].values();
            found.extend(curve.map(|&place| ManifoldPoint::new([place; 2], normal, 0.0)));
        }
        let mut manifold = Manifold::of(self.axis(), found, 1.0, before);
        manifold.normal = normal;
        manifold.is_overlap = true;
        manifold.is_whole = is_whole && !probing.is_unknown;
        manifold.area = self.area.length();
        manifold.centroid = self.middle();
        manifold
    }
}

/// The probes of one group.
#[derive(Clone, Debug, Default)]
struct Probing {
    stage: Stage,
    probes: ArrayVec<Probe, PROBES>,
    hits: [Option<RayHit>; RAYS],
    found: Vec<ManifoldPoint>,
    /// Probes between whose ends one of the surfaces ends.
    through: u32,
    /// True if a probe is inside both surfaces, but rays did not show where they end, as where
    /// parts of one surface are inside others.
    is_unknown: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
enum Stage {
    #[default]
    None,
    Deep,
    Wide,
}

impl Probing {
    /// The ray of a probe with this number: the index of the tree, the origin, and whether it goes
    /// along the normal. `None` if the probe is done.
    ///
    /// From a vertex one ray leaves the other surface. From an inner point, one leaves A backwards
    /// and one B forwards. If both do and no point was found before, two more show that both
    /// surfaces are around all the way, which is not so where one goes through the other. If they
    /// do not, the point is not inside, perhaps on a surface: then from the middle between the hits
    /// all four are cast.
    fn ray(&self, probe: Probe, normal: DVec3, ray: usize) -> Option<(usize, DVec3, bool)> {
        match (probe, ray) {
            (Probe::Vertex(side, place), 0) => Some((1 - side, place, side == 0)),
            (Probe::Vertex(..), _) => None,
            (Probe::Inner(place), 0 | 1) => Some((ray, place, ray == 1)),
            (Probe::Inner(place), 2..) if self.is_between() => {
                let goes_on = ray < 4 && self.found.is_empty();
                goes_on.then_some((ray % 2, place, ray == 2))
            }
            (Probe::Inner(place), 2..RAYS) => {
                let middle = place + self.shift() * normal;
                Some((ray % 2, middle, ray == 3 || ray == 4))
            }
            (Probe::Inner(_), _) => None,
        }
    }

    /// True if the first two rays of an inner point leave the surfaces, and none lies on one.
    fn is_between(&self) -> bool {
        match [exit(self.hits[0]), exit(self.hits[1])] {
            [Some(back), Some(forth)] => back.min(forth) > (1.0 - NEARLY) * back.max(forth),
            _ => false,
        }
    }

    /// Where the middle between the first two hits is, along the normal.
    fn shift(&self) -> f64 {
        let [back, forth] = [0, 1].map(|ray| exit(self.hits[ray]).unwrap_or(0.0));
        0.5 * (forth - back)
    }

    /// Takes the hits of a probe. Returns the place of an inner point without a depth.
    fn take(&mut self, probe: Probe, normal: DVec3) -> Option<DVec3> {
        let exits = self.hits.map(exit);
        let mut is_through = false;
        let measured = match probe {
            Probe::Vertex(side, place) => {
                let depth = exits[0]?;
                let [back, forth] = if side == 0 {
                    [0.0, depth]
                } else {
                    [depth, 0.0]
                };
                Some((place, back, forth))
            }
            Probe::Inner(_) => {
                let is_between = self.is_between();
                let first = if is_between { 0 } else { 2 };
                let ends = if is_between && !self.found.is_empty() {
                    [exits[0], exits[1], Some(f64::INFINITY), Some(f64::INFINITY)]
                } else {
                    [0, 1, 2, 3].map(|ray| exits[first + ray])
                };
                match ends {
                    [Some(back), Some(forth), Some(of_a), Some(of_b)]
                        if of_a >= forth * NEARLY && of_b >= back * NEARLY =>
                    {
                        Some((self.place(probe, normal), back, forth))
                    }
                    ends => {
                        is_through = ends.iter().all(Option::is_some);
                        None
                    }
                }
            }
        };
        match measured {
            Some((place, back, forth)) => {
                let points = [place - back * normal, place + forth * normal];
                let point = ManifoldPoint::new(points, normal, -(back + forth));
                self.found.push(point);
            }
            None if is_through => self.through += 1,
            None => return Some(self.place(probe, normal)),
        }
        None
    }

    /// Where the depth of a probe is measured.
    fn place(&self, probe: Probe, normal: DVec3) -> DVec3 {
        match probe {
            Probe::Inner(place) if !self.is_between() => place + self.shift() * normal,
            Probe::Inner(place) | Probe::Vertex(_, place) => place,
        }
    }
}

/// What takes the contacts of a query for manifolds, in place of the list.
#[derive(Clone, Debug, Default)]
pub(super) struct Reduction {
    pub is_on: bool,
    pub skin: Skin,
    /// True when all pairs are listed.
    pub is_listed: bool,
    /// True until the first call of the query.
    pub is_new: bool,
}

impl Reduction {
    pub fn clear(&mut self) {
        if self.is_on {
            self.skin.clear();
            (self.is_on, self.is_listed) = (false, false);
        }
    }
}
