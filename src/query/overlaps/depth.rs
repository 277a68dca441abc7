//! The normal of a piece of contact, and its depths.
//!
//! A depth is measured along the normal, from where a line leaves A backwards to where it leaves B
//! forwards. From a vertex inside the other surface one ray shows it, from a point of the curves,
//! moved inward, two. Of a piece without such vertices two more rays show that both surfaces are
//! around all the way, until one point is found. Where one surface goes through the other at most of
//! the points, there is no normal.

use super::{Cut, Octagon, Overlaps, Phase, REGION_LIMIT};
use crate::contact::manifold::{Before, Manifold, ManifoldPoint, Shape, choose};
use crate::model::cost::WORK_PER_CURVE_PAIR;
use crate::query::deadline::Deadline;
use crate::query::outcome::StopReason;
use crate::query::workspace::Workspace;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::mem;
use glam::DVec3;
use punctual_geom::length;
use punctual_geom::triangle::ray::Side;

/// Maximum number of pairs of a group that decide its normal if it has no area.
const TOUCHING: usize = 16;

/// They are searched among this many pairs.
const AMONG: usize = 1024;

/// Maximum number of probes of a group in each of two stages.
const PROBES: usize = 4;

/// Maximum number of points found in a group: one a probe, and those of its curve.
const FOUND: usize = 16;

/// A group of at most this many pairs gets a probe in its middle only if it has no vertices.
const FEW: u32 = 16;

/// A group of no more pairs than this is small.
const SMALL: u32 = 6;

/// Relative size of an area vector, or of the step between the ends of a curve, that counts as
/// rounding.
const ROUNDING: f64 = 1e-9;

/// Of two vertices one above the other, the deeper counts as farther, by this part of their
/// difference in height.
const LEAN: f64 = 0.1;

/// A distance of at least this part of a depth counts as reaching it.
const NEARLY: f64 = 1.0 - 1e-6;

/// Points of a curve are moved by this part of the way to its middle before their depth is
/// measured.
const INWARD: f64 = 0.1;

/// A piece of contact.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// The number of its pairs, and the first of them.
    cuts: u32,
    pub first: u32,
    /// A point of the curves.
    origin: DVec3,
    length: f64,
    /// Sum of the middles of the segments relative to the origin, weighted by their lengths.
    moment: DVec3,
    area: DVec3,
    /// Sum of the magnitudes of all parts of the area vector.
    whole_area: f64,
    normal: DVec3,
    /// The farthest vertices of A and of B in the region, and the farthest points of the curves.
    farthest: [Octagon<DVec3>; 3],
    /// The deepest vertex of A, and of B: the least height along the normal, the largest.
    deepest: [Option<(f64, DVec3)>; 2],
    /// True if the surfaces touch without an area.
    is_touching: bool,
}

/// Where a depth is measured: at a vertex of the surface `on`, or at a point inside both.
#[derive(Clone, Copy, Debug)]
struct Probe {
    place: DVec3,
    on: Option<usize>,
}

/// The probes of one group.
#[derive(Clone, Debug, Default)]
pub(super) struct Probing {
    probes: ArrayVec<Probe, PROBES>,
    /// The next of them, and its next ray.
    next: usize,
    ray: usize,
    /// Distances along the normal to where A ends backwards and B forwards, and, where that is
    /// asked, B backwards and A forwards.
    exits: [Option<f64>; 4],
    found: Vec<ManifoldPoint>,
    /// Number of probes along which one of the surfaces goes through the other.
    through: usize,
    stage: Stage,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
enum Stage {
    #[default]
    None,
    Deep,
    Wide,
}

impl Probing {
    /// Makes room for all points of a group.
    pub fn reserve(&mut self) {
        let room = FOUND.saturating_sub(self.found.len());
        self.found.reserve(room);
    }

    pub fn clear(&mut self) {
        self.stage = Stage::None;
    }

    fn enter(&mut self, stage: Stage, probes: ArrayVec<Probe, PROBES>) {
        (self.stage, self.probes) = (stage, probes);
        (self.next, self.ray) = (0, 0);
    }
}

impl Group {
    pub fn new(first: u32, cut: &Cut) -> Self {
        Self {
            cuts: 0,
            first,
            origin: cut.segment[0],
            length: 0.0,
            moment: DVec3::ZERO,
            area: DVec3::ZERO,
            whole_area: 0.0,
            normal: DVec3::ZERO,
            farthest: [Octagon::new(DVec3::Z, DVec3::ZERO); 3],
            deepest: [None; 2],
            is_touching: false,
        }
    }

    pub fn add(&mut self, cut: &Cut) {
        let [start, end] = cut.segment.map(|point| point - self.origin);
        self.cuts += 1;
        if !cut.is_flat {
            let (step, area) = (length(end - start), 0.5 * start.cross(end));
            self.length += step;
            self.moment += 0.5 * step * (start + end);
            self.area += area;
            self.whole_area += length(area);
        }
    }

    /// Middle of the curves.
    fn middle(&self) -> DVec3 {
        if self.length > 0.0 {
            self.origin + self.moment / self.length
        } else {
            self.origin
        }
    }

    /// Finds the normal; `cuts` begins with the first pair.
    pub fn find_normal(&mut self, shape: Shape, cuts: &[Cut]) {
        let [p, q, _] = shape.trees[0].corners(cuts[0].pair[0]);
        self.is_touching = self.whole_area <= ROUNDING * ROUNDING * self.length * self.length
            || self.length <= ROUNDING * length(q - p);
        if self.is_touching {
            self.normal = normal_of_touch(shape, cuts);
        } else if self.area.length() > ROUNDING * self.whole_area {
            self.normal = -self.area.normalize_or_zero();
        }
        self.farthest = [Octagon::new(self.axis(), DVec3::ZERO); 3];
    }

    /// The normal, or any direction if there is none.
    fn axis(&self) -> DVec3 {
        if self.normal == DVec3::ZERO {
            DVec3::Z
        } else {
            self.normal
        }
    }

    pub fn insert_segment(&mut self, segment: [DVec3; 2]) {
        for point in segment {
            self.farthest[2].insert(point, 0.0, point);
        }
    }

    pub fn insert(&mut self, side: usize, place: DVec3) {
        let height = place.dot(self.normal);
        // A's deepest vertex is the lowest, B's the highest.
        let height = if side == 0 { -height } else { height };
        self.farthest[side].insert(place, LEAN * height, place);
        if self.deepest[side].is_none_or(|(before, _)| height > before) {
            self.deepest[side] = Some((height, place));
        }
    }

    /// Points of the curves, which have no depth.
    fn curve(&self, normal: DVec3) -> impl Iterator<Item = ManifoldPoint> {
        let points = self.farthest[2].values();
        points.map(move |&place| ManifoldPoint::new([place; 2], normal, 0.0))
    }

    /// The first probes: where the overlap is probably deepest.
    fn deep_probes(&self) -> ArrayVec<Probe, PROBES> {
        if self.normal == DVec3::ZERO || self.is_touching {
            return ArrayVec::new();
        }
        let vertex = |side: usize| {
            let (_, place) = self.deepest[side]?;
            let on = Some(side);
            Some(Probe { place, on })
        };
        let mut probes: ArrayVec<Probe, PROBES> = [0, 1].into_iter().filter_map(vertex).collect();
        if probes.is_empty() || self.cuts > FEW {
            let place = self.middle();
            probes.push(Probe { place, on: None });
        }
        probes
    }

    /// The other probes: those that keep the bodies apart.
    fn wide_probes(&self, before: Before) -> ArrayVec<Probe, PROBES> {
        let middle = self.middle();
        let mut all: ArrayVec<Probe, 24> = ArrayVec::new();
        let mut candidates: ArrayVec<ManifoldPoint, 24> = ArrayVec::new();
        for (on, side) in [(Some(0), 1.0), (Some(1), -1.0), (None, 0.0)] {
            let places = self.farthest[on.unwrap_or(2)].values();
            for &place in places {
                let inner = place.lerp(middle, INWARD);
                let place = if on.is_none() { inner } else { place };
                // A's deepest vertices are the lowest, B's the highest.
                let distance = side * (place - middle).dot(self.normal);
                candidates.push(ManifoldPoint::new([place; 2], self.normal, distance));
                all.push(Probe { place, on });
            }
        }
        let chosen = choose(self.normal, &candidates, 1.0, before.stay(&candidates));
        chosen.into_iter().map(|i| all[i]).collect()
    }

    /// The manifold of the points found.
    fn manifold(&self, probing: &mut Probing, before: Before, is_whole: bool) -> Manifold {
        let found = &mut probing.found;
        // Of equal depths, those that span most come first.
        found.reverse();
        let is_through = probing.through > found.len();
        let normal = if is_through { DVec3::ZERO } else { self.normal };
        let is_known = !found.is_empty() || normal == DVec3::ZERO || self.is_touching;
        if found.is_empty() || normal == DVec3::ZERO {
            found.clear();
            found.extend(self.curve(normal));
        }
        let mut manifold = Manifold::of(self.axis(), found, 1.0, before);
        manifold.normal = normal;
        manifold.is_overlap = true;
        manifold.is_whole = is_whole && is_known;
        manifold.area = self.area.length();
        manifold.centroid = self.middle();
        manifold
    }
}

/// The direction that separates pairs that touch without an area: of the normals of the faces of
/// the first group the one along which all its pairs overlap the least.
fn normal_of_touch(shape: Shape, cuts: &[Cut]) -> DVec3 {
    let normal = |[p, q, r]: &[DVec3; 3]| (*q - *p).cross(*r - *p).normalize_or_zero();
    let members = cuts.iter().take(AMONG);
    let members = members.filter(|cut| cut.group == cuts[0].group);
    let pairs: ArrayVec<[[DVec3; 3]; 2], TOUCHING> = members
        .take(TOUCHING)
        .map(|cut| [0, 1].map(|side| shape.corners(side, cut.pair[side])))
        .collect();
    let overlap = |way: DVec3| {
        let of = |[a, b]: &[[DVec3; 3]; 2]| {
            let most = b.map(|p| p.dot(way)).into_iter().reduce(f64::max);
            let least = a.map(|p| p.dot(way)).into_iter().reduce(f64::min);
            most.unwrap_or(0.0) - least.unwrap_or(0.0)
        };
        pairs.iter().map(of).fold(0.0, f64::max)
    };
    let mean: DVec3 = pairs.iter().map(|[a, b]| normal(b) - normal(a)).sum();
    let ways = pairs.iter().flat_map(|[a, b]| [normal(b), -normal(a)]);
    let ways = ways.chain([mean.normalize_or_zero()]);
    let best = ways
        .filter(|way| *way != DVec3::ZERO)
        .map(|way| (overlap(way), way))
        .reduce(|best, other| if other.0 < best.0 { other } else { best });
    best.map_or(DVec3::ZERO, |(_, way)| way)
}

impl Overlaps {
    /// Casts the next ray for the depths of a group, or takes what the rays have found. Returns true
    /// if the group is done.
    pub(super) fn probe(
        &mut self,
        shape: Shape,
        before: Before,
        at: usize,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<bool, StopReason> {
        debug_assert!(self.phase == Phase::Probe);
        let group = &self.groups[at];
        let normal = group.normal;
        if self.probing.stage == Stage::None {
            self.probing.found.clear();
            self.probing.found.reserve(FOUND);
            self.probing.through = 0;
            self.probing.enter(Stage::Deep, group.deep_probes());
        }
        let Some(&probe) = self.probing.probes.get(self.probing.next) else {
            workspace.run.stats.work += WORK_PER_CURVE_PAIR;
            let is_deep = self.probing.stage == Stage::Deep && self.probing.next > 0;
            let is_small = is_deep && !self.probing.found.is_empty() && group.cuts <= SMALL;
            if is_deep && !is_small {
                self.probing.enter(Stage::Wide, group.wide_probes(before));
                return Ok(false);
            }
            if is_small {
                // Around a small region points of the curve are found without rays.
                self.probing.found.extend(group.curve(normal));
            }
            let is_whole = self.region.len() < REGION_LIMIT;
            let manifold = group.manifold(&mut self.probing, before, is_whole);
            self.done.push(manifold);
            self.probing.stage = Stage::None;
            return Ok(true);
        };
        let is_all_around = probe.on.is_none() && self.probing.found.is_empty();
        let ray = self.probing.ray;
        if ray < if is_all_around { 4 } else { 2 } {
            let (side, way) = [(0, -normal), (1, normal), (1, -normal), (0, normal)][ray];
            self.probing.exits[ray] = if probe.on == Some(side) {
                Some(0.0)
            } else {
                let line = [probe.place, way];
                let hit = self.cast(shape, before.to_b, side, line, workspace, deadline)?;
                // Beyond the depth it does not matter what follows.
                hit.filter(|hit| ray > 1 || hit.side != Side::Front)
                    .map(|hit| hit.t)
            };
            self.probing.ray += 1;
            return Ok(false);
        }
        let [ends @ .., b_back, a_forth] = mem::take(&mut self.probing.exits);
        if let [Some(back), Some(forth)] = ends {
            let reaches = |end: Option<f64>, depth| end.is_some_and(|end| end >= NEARLY * depth);
            if !is_all_around || reaches(b_back, back) && reaches(a_forth, forth) {
                let points = [probe.place - back * normal, probe.place + forth * normal];
                let point = ManifoldPoint::new(points, normal, -(back + forth));
                self.probing.found.push(point);
            } else {
                self.probing.through += 1;
            }
        }
        (self.probing.next, self.probing.ray) = (self.probing.next + 1, 0);
        Ok(false)
    }
}
