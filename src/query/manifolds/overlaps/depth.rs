//! The normal of a piece of contact, and its depths.
//!
//! A depth is measured along the normal, from where a line leaves A backwards to where it leaves B
//! forwards. At a vertex inside the other surface this takes one ray; at a point of the curves,
//! moved inward, two. A piece without such vertices takes two more rays, until one point is found:
//! they show that the place is inside both surfaces. Where one surface goes through the other at
//! most of the points, there is no normal.

use super::{Cut, Inset, Octagon, Overlaps, Phase, REGION_LIMIT};
use crate::engine::deadline::Deadline;
use crate::engine::memory::identity::Before;
use crate::engine::outcome::StopReason;
use crate::engine::workspace::Workspace;
use crate::model::cost::WORK_PER_CURVE_PAIR;
use crate::query::manifolds::manifold::{Manifold, ManifoldPoint, SAME, Shape, choose};
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::mem;
use glam::DVec3;
use punctual_geom::triangle::ray::Side;
use punctual_geom::{larger, length};

/// Maximum number of probes of a group in each of two stages.
const PROBES: usize = 4;

/// Maximum number of points found in a group: one a probe, and those of its curve.
const FOUND: usize = 16;

/// A group of at most this many pairs gets a probe in its middle only if it has no vertices.
const FEW: u32 = 16;

/// A group of no more pairs than this is small.
const SMALL: u32 = 6;

/// Relative size of an area vector that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Of two vertices one above the other, the deeper counts as farther, by this part of their
/// difference in height.
const LEAN: f64 = 0.1;

/// A distance of at least this part of a depth counts as reaching it.
const NEARLY: f64 = 1.0 - 1e-6;

/// Points of a curve are moved toward its middle before their depth is measured: by at least
/// `BESIDE` of the way, past a steep face along which the curve runs, and by at most `INWARD` of
/// it.
const INWARD: f64 = 0.1;
const BESIDE: f64 = 1e-9;

/// Points of a curve are moved inward by at least this many lengths by which B is drawn in.
const LEAST_INWARD: f64 = 4.0;

/// Least squared sine of the angle between faces for which an area is corrected by the inset.
const LEAST_SQUARE: f64 = 0.1;

/// Cosine of the angle up to which faces count as having one direction. The normal becomes that of
/// these faces if at least `FLAT_SHARE` of the curves runs on them.
const ONE_DIRECTION: f64 = 1.0 - 1e-6;
const FLAT_SHARE: f64 = 0.4;

/// A vertex, or the index of a pair whose curve has the point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spot {
    pub place: DVec3,
    pub of: u32,
}

/// The face directions along which the most of the curves runs, each with a length of curve (Misra
/// and Gries). A length is too low by at most a quarter of the sum of all.
#[derive(Clone, Copy, Debug, Default)]
struct Directions([(DVec3, f64); 3]);

impl Directions {
    fn add(&mut self, way: DVec3, length: f64) {
        let Self(known) = self;
        let is_same = |(other, _): &&mut (DVec3, f64)| other.dot(way) > ONE_DIRECTION;
        if let Some((_, sum)) = known.iter_mut().find(is_same) {
            return *sum += length;
        }
        let least = known.iter().map(|(_, sum)| *sum).fold(length, f64::min);
        known.iter_mut().for_each(|(_, sum)| *sum -= least);
        if length > least
            && let Some(free) = known.iter_mut().find(|(_, sum)| *sum <= 0.0)
        {
            *free = (way, length - least);
        }
    }

    /// The direction within 7 degrees of a unit vector that has the most length, if that is at
    /// least `least`.
    fn near(&self, way: DVec3, least: f64) -> Option<DVec3> {
        let Self(known) = self;
        let near = known
            .iter()
            .filter(|(other, sum)| other.dot(way) > SAME && *sum >= least);
        near.max_by(|(_, x), (_, y)| x.total_cmp(y))
            .map(|(other, _)| *other)
    }
}

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
    directions: Directions,
    /// Sum of the magnitudes of all parts of the area vector.
    whole_area: f64,
    normal: DVec3,
    /// The farthest vertices of A and of B in the region, and the farthest points of the curves.
    farthest: [Octagon<Spot>; 3],
    /// The deepest vertex of A and of B, with its height along the normal, which is negated for A:
    /// A's deepest vertex is the lowest, B's the highest.
    deepest: [Option<(f64, Spot)>; 2],
    /// True if the curves are too short to have an area.
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
    /// Distances along the normal to the end of A backwards and of B forwards; if asked for, also
    /// to the end of B backwards and of A forwards.
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
            directions: Directions::default(),
            whole_area: 0.0,
            normal: DVec3::ZERO,
            farthest: [Octagon::new(DVec3::Z, Spot::default()); 3],
            deepest: [None; 2],
            is_touching: false,
        }
    }

    /// Adds a pair. B is drawn in by `inset`.
    pub fn add(&mut self, cut: &Cut, inset: f64) {
        let [start, end] = cut.segment.map(|point| point - self.origin);
        let (way, [of_a, of_b]) = (end - start, cut.normals);
        let (step, area) = (length(way), 0.5 * start.cross(end));
        self.cuts += 1;
        self.length += step;
        self.moment += 0.5 * step * (start + end);
        self.whole_area += length(area);
        self.area += area;
        // The segment moves on A's face to where B's own face is.
        let along = of_a.dot(of_b);
        let square = 1.0 - along * along;
        if square > LEAST_SQUARE {
            let out = (of_b - along * of_a) * (inset / square);
            self.area += out.cross(way);
        }
        for direction in [-of_a, of_b] {
            self.directions.add(direction, step);
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

    /// Finds the normal. B is drawn in by `inset`.
    pub fn find_normal(&mut self, inset: f64) {
        self.is_touching = self.length <= inset;
        let way = if self.is_touching {
            self.directions.0.iter().map(|(way, _)| *way).sum()
        } else if length(self.area) > ROUNDING * self.whole_area {
            -self.area
        } else {
            DVec3::ZERO
        };
        let way = way.normalize_or_zero();
        let flat = self.directions.near(way, FLAT_SHARE * self.length);
        self.normal = flat.unwrap_or(way);
        self.farthest = [Octagon::new(self.axis(), Spot::default()); 3];
    }

    /// The normal, or any direction if there is none.
    fn axis(&self) -> DVec3 {
        if self.normal == DVec3::ZERO {
            DVec3::Z
        } else {
            self.normal
        }
    }

    /// Takes the ends of the segment of a pair.
    pub fn insert_segment(&mut self, segment: [DVec3; 2], cut: u32) {
        for place in segment {
            self.farthest[2].insert(place, 0.0, Spot { place, of: cut });
        }
    }

    /// Takes a vertex.
    pub fn insert(&mut self, side: usize, spot: Spot) {
        let height = spot.place.dot(self.normal);
        // A's deepest vertex is the lowest, B's the highest.
        let height = if side == 0 { -height } else { height };
        self.farthest[side].insert(spot.place, LEAN * height, spot);
        if self.deepest[side].is_none_or(|(before, _)| height > before) {
            self.deepest[side] = Some((height, spot));
        }
    }

    /// Points of the curves, which have no depth.
    fn curve(&self, normal: DVec3) -> impl Iterator<Item = ManifoldPoint> {
        let points = self.farthest[2].values();
        points.map(move |spot| ManifoldPoint::new([spot.place; 2], normal, 0.0))
    }

    /// The part of the way to the middle by which a point of the curves is moved, if the overlap is
    /// this deep.
    fn inward(&self, spot: &Spot, drawn: &Drawn, depth: f64) -> f64 {
        let tilt = drawn.cuts[spot.of as usize].normals.map(|face| {
            let along = face.dot(self.normal).abs();
            along / libm::sqrt(larger(1.0 - along * along, 0.0))
        });
        let past = 2.0 * depth * tilt[0].min(tilt[1]) + LEAST_INWARD * drawn.inset.step;
        let part = BESIDE + past / length(spot.place - self.middle());
        // NaN becomes the most.
        part.min(INWARD)
    }

    /// The first probes: where the overlap is probably deepest.
    fn deep_probes(&self, drawn: &Drawn) -> ArrayVec<Probe, PROBES> {
        if self.normal == DVec3::ZERO || self.is_touching {
            return ArrayVec::new();
        }
        let vertex = |side: usize| {
            let (_, spot) = self.deepest[side]?;
            let (place, on) = (drawn.place(side, &spot), Some(side));
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
    fn wide_probes(&self, drawn: &Drawn, before: Before, depth: f64) -> ArrayVec<Probe, PROBES> {
        let middle = self.middle();
        let mut all: ArrayVec<Probe, 24> = ArrayVec::new();
        let mut candidates: ArrayVec<ManifoldPoint, 24> = ArrayVec::new();
        for (on, side) in [(Some(0), 1.0), (Some(1), -1.0), (None, 0.0)] {
            let places = self.farthest[on.unwrap_or(2)].values();
            for spot in places {
                let place = match on {
                    Some(side) => drawn.place(side, spot),
                    None => spot.place.lerp(middle, self.inward(spot, drawn, depth)),
                };
                // A's deepest vertices are the lowest, B's the highest.
                let distance = side * (place - middle).dot(self.normal);
                candidates.push(ManifoldPoint::new([place; 2], self.normal, distance));
                all.push(Probe { place, on });
            }
        }
        let chosen = choose(self.normal, &candidates, 1.0, before.stay(&candidates));
        chosen.into_iter().map(|i| all[i]).collect()
    }

    /// The manifold of the points found. Up to `least` deep it is no overlap.
    fn manifold(
        &self,
        probing: &mut Probing,
        before: Before,
        is_whole: bool,
        least: f64,
    ) -> Manifold {
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
        manifold.is_overlap = normal == DVec3::ZERO || !is_known || manifold.distance < -least;
        manifold.is_whole = is_whole && is_known;
        manifold.area = if normal == DVec3::ZERO {
            length(self.area)
        } else {
            larger(-self.area.dot(normal), 0.0)
        };
        manifold.centroid = self.middle();
        manifold
    }
}

/// The surfaces and cuts from which probes are made.
struct Drawn<'d, 't> {
    shape: Shape<'t>,
    inset: &'d Inset,
    cuts: &'d [Cut],
}

impl Drawn<'_, '_> {
    /// The place of a vertex; of B, drawn in.
    fn place(&self, side: usize, spot: &Spot) -> DVec3 {
        self.inset.place(self.shape, side, spot.of)
    }
}

impl Overlaps {
    /// Casts the next ray for the depths of a group, or collects the hits of its rays. Returns true
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
        let (normal, step) = (group.normal, self.inset.step);
        let drawn = Drawn {
            shape,
            inset: &self.inset,
            cuts: &self.cuts,
        };
        if self.probing.stage == Stage::None {
            self.probing.found.clear();
            self.probing.found.reserve(FOUND);
            self.probing.through = 0;
            self.probing.enter(Stage::Deep, group.deep_probes(&drawn));
        }
        let Some(&probe) = self.probing.probes.get(self.probing.next) else {
            workspace.run.stats.work += WORK_PER_CURVE_PAIR;
            let is_deep = self.probing.stage == Stage::Deep && self.probing.next > 0;
            let depths = self.probing.found.iter().map(|point| -point.distance);
            let depth = depths.reduce(f64::max).unwrap_or(f64::INFINITY);
            let is_small = is_deep && !self.probing.found.is_empty() && group.cuts <= SMALL && {
                let mut spots = group.farthest[2].values();
                spots.all(|spot| group.inward(spot, &drawn, depth) >= INWARD)
            };
            if is_deep && !is_small {
                let probes = group.wide_probes(&drawn, before, depth);
                self.probing.enter(Stage::Wide, probes);
                return Ok(false);
            }
            if is_small {
                // Around a small region points of the curve are found without rays.
                self.probing.found.extend(group.curve(normal));
            }
            let is_whole = self.region.len() < REGION_LIMIT;
            let least = drawn.inset.reach();
            let mut manifold = group.manifold(&mut self.probing, before, is_whole, least);
            manifold.is_overlap &= self.met.is_some();
            self.done.push(manifold);
            self.probing.stage = Stage::None;
            return Ok(true);
        };
        let is_all_around = probe.on.is_none() && self.probing.found.is_empty();
        let ray = self.probing.ray;
        if ray < if is_all_around { 4 } else { 2 } {
            let (side, way) = [(0, -normal), (1, normal), (1, -normal), (0, normal)][ray];
            self.probing.exits[ray] = if probe.on == Some(side) {
                // The vertex of B itself is farther by a step.
                Some(if side == 1 { step } else { 0.0 })
            } else {
                // Curves lie on faces: so a face that holds the place counts as ahead.
                let line = [probe.place - way * step, way];
                let hit = self.cast(shape, before.to_b, side, line, workspace, deadline)?;
                // Beyond the depth it does not matter what follows.
                hit.filter(|hit| ray > 1 || hit.side != Side::Front)
                    .map(|hit| larger(hit.t - step, 0.0))
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
