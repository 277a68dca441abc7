//! The depth of two convex components, by an expanding polytope.
//!
//! Two convex bodies meet at the translations in `D = {a - b: a in A, b in B}`. Their depth is the
//! distance of 0 from the outside of `D`. The search keeps a polytope whose corners are in `D`: at
//! first a tetrahedron, which need not hold 0. Each step asks for the support of `D` along the
//! normal of the face that 0 is least inside of, and adds its corner. A support is the length of a
//! push that separates; the distance of 0 from the nearest face is a lower bound. Proofs in
//! `docs/numerics.md`, "Convex bodies".

use super::PenetrationQuery;
use super::machine::{Machine, STEP, Step, Task};
use super::sets::unit;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual::Tree;
use punctual::engine::Convex;

/// Capacities. The search ends if the polytope gets more corners, or if the faces that a new corner
/// sees have more edges around them.
const CORNERS: usize = 184;
const FACES: usize = 2 * CORNERS - 4;
const EDGES: usize = 32;

/// Number of corners of a body that are compared with a direction in one step.
const CORNERS_PER_STEP: usize = 256;

/// Work to compare a corner of a body with a direction, to look at a face, and to make one.
const WORK_PER_CORNER: u64 = 3;
const WORK_PER_FACE: u64 = 4;
const WORK_PER_NEW_FACE: u64 = 50;

/// Maximum number of new faces of a step: those of a rim, beside the first four.
const MOST_NEW_FACES: u64 = EDGES as u64 + 4;

/// Maximum work of a step.
const WORK_PER_STEP: u64 = 64
    + CORNERS_PER_STEP as u64 * WORK_PER_CORNER
    + FACES as u64 * WORK_PER_FACE
    + MOST_NEW_FACES * WORK_PER_NEW_FACE;
const _: () = assert!(WORK_PER_STEP <= STEP);

/// Maximum number of pairs of components whose depths are searched.
const PAIRS: usize = 256;

/// A triangle of the polytope.
#[derive(Clone, Copy, Debug)]
struct Face {
    corners: [u16; 3],
    /// Unit vector that points out of the polytope.
    normal: DVec3,
    /// Least of the corners' heights along the normal.
    height: f64,
}

/// The support of `D` along a direction, as far as the corners of the bodies are compared with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    /// Index of the pair of components.
    pair: usize,
    direction: DVec3,
    /// Number of corners that are compared: those of A, then those of B.
    next: usize,
    /// The farthest corners so far, of A along the direction, of B against it: indices and heights.
    best: [(usize, f64); 2],
}

/// The polytope in `D`. Lengths are in units of the size of the meshes.
#[derive(Debug)]
pub(super) struct Polytope {
    corners: Vec<DVec3>,
    faces: Vec<Face>,
    /// A point in the first tetrahedron.
    inner: DVec3,
}

impl Support {
    pub fn first(pair: usize, direction: DVec3) -> Self {
        let none = (0, f64::NEG_INFINITY);
        Self {
            pair,
            direction,
            next: 0,
            best: [none; 2],
        }
    }
}

impl Polytope {
    pub fn new() -> Self {
        Self {
            corners: Vec::with_capacity(CORNERS),
            faces: Vec::with_capacity(FACES + EDGES),
            inner: DVec3::ZERO,
        }
    }

    pub fn clear(&mut self) {
        self.corners.clear();
        self.faces.clear();
    }

    /// A face that is farther out than the inner point by `margin`.
    fn face(&self, corners: [u16; 3], margin: f64) -> Option<Face> {
        let [p, q, r] = corners.map(|i| self.corners[usize::from(i)]);
        let normal = (q - p).cross(r - p).try_normalize()?;
        let height = normal.dot(p).min(normal.dot(q)).min(normal.dot(r));
        (height - normal.dot(self.inner) > margin).then_some(Face {
            corners,
            normal,
            height,
        })
    }

    /// Adds one of the first four corners. Returns the next direction, along which `D` reaches
    /// beyond the corners; `center` is an inner point of `D`. `None` if the four span no volume.
    fn begin(&mut self, corner: DVec3, center: DVec3, margin: f64) -> Option<DVec3> {
        self.corners.push(corner);
        let toward = center - self.corners[0];
        match self.corners[..] {
            [p, q] => {
                let edge = (q - p).try_normalize()?;
                let aside = toward - edge * edge.dot(toward);
                let is_clear = aside.length() > 1e-6 * toward.length();
                Some(if is_clear {
                    unit(aside)
                } else {
                    edge.any_orthonormal_vector()
                })
            }
            [p, q, r] => {
                let normal = (q - p).cross(r - p).try_normalize()?;
                Some(normal * if normal.dot(toward) < 0.0 { -1.0 } else { 1.0 })
            }
            [p, q, r, s] => {
                self.inner = 0.25 * (p + q + r + s);
                for [i, j, k] in [[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
                    let face = self.face([i, j, k], margin);
                    let face = face.or_else(|| self.face([i, k, j], margin))?;
                    self.faces.push(face);
                }
                self.nearest().map(|face| face.normal)
            }
            _ => Some(unit(toward)),
        }
    }

    /// Adds a corner of `D`: the faces that it sees, or nearly, are replaced. `None` if a new face
    /// has no area, or there is no room.
    fn expand(&mut self, corner: DVec3, margin: f64) -> Option<()> {
        let new = self.corners.len();
        if new == CORNERS {
            return None;
        }
        self.corners.push(corner);
        let mut edges = ArrayVec::<[u16; 2], EDGES>::new();
        let mut i = 0;
        while let Some(face) = self.faces.get(i) {
            if face.normal.dot(corner) < face.height - margin {
                i += 1;
                continue;
            }
            let [p, q, r] = face.corners;
            for [from, to] in [[p, q], [q, r], [r, p]] {
                match edges.iter().position(|edge| *edge == [to, from]) {
                    Some(at) => {
                        edges.swap_remove(at);
                    }
                    None => edges.try_push([from, to]).ok()?,
                }
            }
            self.faces.swap_remove(i);
        }
        for &[from, to] in &edges {
            let face = self.face([from, to, new as u16], 2.0 * margin)?;
            self.faces.push(face);
        }
        Some(())
    }

    /// The face that 0 is least inside of.
    fn nearest(&self) -> Option<&Face> {
        self.faces
            .iter()
            .min_by(|f, g| f.height.total_cmp(&g.height))
    }
}

/// The components of a body, if all of them are convex.
fn components(tree: &Tree) -> &[Option<Convex>] {
    let components = tree.solid().map_or(&[][..], |solid| solid.convex());
    if components.iter().all(Option::is_some) {
        components
    } else {
        &[]
    }
}

impl<'t> PenetrationQuery<'t> {
    /// Number of pairs of components, if all are convex; 0 if there are too many.
    pub(super) fn convex_pairs(&self) -> usize {
        let count = components(self.a).len() * components(self.b).len();
        if count <= PAIRS { count } else { 0 }
    }

    fn convex_pair(&self, pair: usize) -> Option<[&'t Convex; 2]> {
        let (a, b) = (components(self.a), components(self.b));
        let [i, j] = [pair / b.len().max(1), pair % b.len().max(1)];
        Some([a.get(i)?.as_ref()?, b.get(j)?.as_ref()?])
    }
}

/// The farthest of some corners along a direction, and its height.
fn farthest(corners: &[DVec3], direction: DVec3) -> (usize, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, corner) in corners.iter().enumerate() {
        let height = corner.dot(direction);
        if height > best.1 {
            best = (i, height);
        }
    }
    best
}

impl Machine<'_, '_, '_> {
    /// Begins with the pair of components of this index, if there is one.
    pub(super) fn convex_task(&mut self, pair: usize) -> Task {
        self.sets.polytope.clear();
        match self.asked.convex_pair(pair) {
            Some([a, b]) if pair < self.asked.convex_pairs() => {
                let center = a.center - self.asked.asked.b_in_a.transform_point(b.center);
                let away = unit(-center);
                let first = if away == DVec3::ZERO { DVec3::Z } else { away };
                Task::Convex(Support::first(pair, first))
            }
            _ => Task::List,
        }
    }

    /// Compares some corners with a direction, and adds the farthest to the polytope.
    pub(super) fn convex(&mut self, mut support: Support) -> Step {
        let Some(pair @ [a, b]) = self.asked.convex_pair(support.pair) else {
            return Ok(());
        };
        let pose = self.asked.asked.b_in_a;
        let count = a.corners.len() + b.corners.len();
        let last = count.min(support.next + CORNERS_PER_STEP);
        let mut work = (last - support.next) as u64 * WORK_PER_CORNER + 64;
        let faces = self.sets.polytope.faces.len() as u64;
        self.deadline
            .check(work + faces * WORK_PER_FACE + MOST_NEW_FACES * WORK_PER_NEW_FACE)?;
        let toward = -(pose.rotation().transpose() * support.direction);
        for (k, direction) in [support.direction, toward].into_iter().enumerate() {
            let before = k * a.corners.len();
            let [from, to] =
                [support.next, last].map(|at| at.saturating_sub(before).min(pair[k].corners.len()));
            let (at, height) = farthest(&pair[k].corners[from..to], direction);
            if height > support.best[k].1 {
                support.best[k] = (from + at, height);
            }
        }
        support.next = last;
        if last < count {
            self.spend(work);
            self.state.task = Task::Convex(support);
            return Ok(());
        }
        let [(i, _), (j, _)] = support.best;
        let corner = a.corners[i] - pose.transform_point(b.corners[j]);
        let next = self.enclose(pair, support, corner);
        let more = (self.sets.polytope.faces.len() as u64).saturating_sub(faces);
        work += faces * WORK_PER_FACE + (more + 4) * WORK_PER_NEW_FACE;
        self.spend(work);
        self.state.task = match next {
            _ if self.state.high == 0.0 => Task::Over,
            Some(direction) => Task::Convex(Support::first(support.pair, direction)),
            None => self.convex_task(support.pair + 1),
        };
        Ok(())
    }

    /// Adds the corner of `D` that is farthest along the direction. Returns the next direction, if
    /// the search is not over.
    fn enclose(&mut self, [a, b]: [&Convex; 2], support: Support, corner: DVec3) -> Option<DVec3> {
        let (size, rounding) = (self.size(), self.state.rounding);
        let reach = support.direction.dot(corner);
        let length = reach + 2.0 * rounding;
        let is_whole = self.asked.convex_pairs() == 1;
        if is_whole {
            self.separate(support.direction, length);
        }
        if length < 0.0 {
            return None;
        }
        let (corner, margin) = (corner / size, rounding / size);
        let polytope = &mut self.sets.polytope;
        let Some(nearest) = polytope.nearest() else {
            let center = a.center - self.asked.asked.b_in_a.transform_point(b.center);
            return polytope.begin(corner, center / size, 2.0 * margin);
        };
        let height = nearest.height * size;
        let share = if is_whole {
            0.0
        } else {
            self.asked.asked.tolerance
        };
        if reach - height <= (share * height).max(2.0 * rounding) {
            let known = self.state.deepest.map_or(0.0, |(_, known)| known);
            if length > known && !is_whole {
                self.state.deepest = Some((support.direction, length));
            }
            return None;
        }
        polytope.expand(corner, margin)?;
        let Face { normal, height, .. } = *polytope.nearest()?;
        let state = &mut *self.state;
        let thickness = |body: &Convex| body.radius / body.inradius;
        let thinner = thickness(a).min(thickness(b) / state.least_scale);
        let loss = (4.0 + 2.0 * thinner) * rounding + a.slack * a.radius + b.slack * b.radius;
        let [longest_of_a, longest_of_b] = state.longest;
        state.raise_low((height * size - loss).min(longest_of_a).min(longest_of_b));
        Some(normal)
    }

    /// A push of this length separates the bodies by a plane. So they are apart if it is negative.
    fn separate(&mut self, direction: DVec3, length: f64) {
        let translation = self.asked.asked.b_in_a.translation() + direction * length;
        if length < 0.0 {
            (self.state.high, self.state.direction) = (0.0, DVec3::ZERO);
        } else if self.asked.pushed(direction * length).translation() == translation {
            self.state.separates(direction, length);
        }
    }
}
