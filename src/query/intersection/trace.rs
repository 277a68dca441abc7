//! Contact-curve tracing: from an intersecting triangle pair to the next one along the curve,
//! without a test.
//!
//! If an edge of one triangle crosses the other triangle, the neighbor across that edge intersects
//! the other triangle too. So each hit of the triangle tests has ends from which the curve is
//! traced ([`Curve`]), pair by pair. Tracing ends at a known pair, at the border of a surface, or
//! where its continuation is uncertain. The pairs found are reported at once, and not tested when
//! the traversal reaches them ([`known`](super::known)). The traversal still goes everywhere, so
//! the answer does not depend on the tracing. A step costs more than the test that it saves, and is
//! worth more the earlier it finds a pair. So a run traces curves only in its first part
//! ([`Tracing`](crate::engine::strategy::Tracing)).
//!
//! This module holds the waiting hits and ends; the steps are in [`follow`](super::follow).

use super::known::{Added, Known};
use crate::tree::Tree;
use arrayvec::ArrayVec;
use punctual_geom::Pose;
use punctual_geom::triangle::curve::Curve;

/// Maximum number of hits whose ends wait; further hits are not traced.
const HITS: usize = 64;

/// The state of curve tracing in a workspace.
#[derive(Clone, Debug)]
pub(crate) struct Trace {
    pub known: Known,
    /// Number of pairs found along curves.
    pub followed: u64,
    /// Number of these pairs that the traversal has reached since.
    pub passed: u64,
    /// Work of tracing.
    pub work: u64,
    /// Pairs (tree order) found by tests. The bits are the edges that certainly cross the other
    /// triangle: 01, 12 and 20 of A, then those of B.
    pub hits: ArrayVec<([u32; 2], u32), HITS>,
    pub ends: [End; 2],
    /// The placement of the vertices of both sides in A's frame: three columns and the translation.
    pub places: [[[f64; 4]; 4]; 2],
}

/// An end of a curve that is being traced.
#[derive(Clone, Debug)]
pub(crate) struct End {
    pub follows: bool,
    pub curve: Curve,
    /// The triangles of the current pair.
    pub at: [Place; 2],
}

/// A triangle that an end of a curve has reached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Index in tree order.
    pub triangle: u32,
    /// Indices of its vertices, in the order of the curve's corners.
    pub vertices: [u32; 3],
}

impl Place {
    /// Moves to the neighbor across the edge opposite to a corner. Returns the neighbor's vertex in
    /// place of that corner.
    #[inline(always)]
    pub fn cross(&mut self, tree: &Tree, corner: usize) -> Option<u32> {
        let apex = self.vertices.get_mut(corner)?;
        let [p, q, _] = tree.vertices_of(self.triangle);
        let edge = if *apex == p {
            1
        } else if *apex == q {
            2
        } else {
            0
        };
        let next = tree.across(self.triangle, edge)?;
        *apex = tree.vertex_across(self.triangle, *apex, next);
        self.triangle = next;
        Some(*apex)
    }
}

impl End {
    const NOWHERE: Self = Self {
        follows: false,
        curve: Curve::NOWHERE,
        at: [Place {
            triangle: 0,
            vertices: [0; 3],
        }; 2],
    };
}

impl Trace {
    pub fn new(capacity: usize) -> Self {
        Self {
            known: Known::new(capacity),
            followed: 0,
            passed: 0,
            work: 0,
            hits: ArrayVec::new(),
            ends: [End::NOWHERE; 2],
            places: [place(&Pose::IDENTITY); 2],
        }
    }

    pub fn clear(&mut self) {
        self.known.clear();
        (self.followed, self.passed, self.work) = (0, 0, 0);
        self.stop();
    }

    /// Drops all hits and ends that wait.
    pub fn stop(&mut self) {
        self.hits.clear();
        self.ends.iter_mut().for_each(|end| end.follows = false);
    }

    /// True if a hit or an end waits for tracing.
    #[inline(always)]
    pub fn is_due(&self) -> bool {
        self.ends[0].follows | self.ends[1].follows | !self.hits.is_empty()
    }

    /// True if a pair was found already.
    #[inline(always)]
    pub fn knows(&self, trees: [&Tree; 2], pair: [u32; 2]) -> bool {
        !self.known.is_empty() && self.known.has(first(trees, pair), pair)
    }

    /// Returns `hits` without the known pairs of two leaves, and counts these as reached by the
    /// traversal.
    #[inline(always)]
    pub fn pass(&mut self, hits: u64, first: [u32; 2]) -> u64 {
        let known = hits & self.known.of(first);
        self.passed += u64::from(known.count_ones());
        hits & !known
    }

    /// Records a pair found by a test; false if it is known.
    pub fn note(&mut self, trees: [&Tree; 2], pair: [u32; 2], crossings: u32) -> bool {
        let added = self.known.add(first(trees, pair), pair);
        if added == Added::New && crossings != 0 {
            let _ = self.hits.try_push((pair, crossings));
        }
        self.passed += u64::from(added == Added::Known);
        if added == Added::NoRoom {
            // The pair could be found again along a curve.
            self.stop();
        }
        added != Added::Known
    }
}

/// The first triangles of the leaves of a pair.
#[inline(always)]
pub(crate) fn first([a, b]: [&Tree; 2], pair: [u32; 2]) -> [u32; 2] {
    [a.first_of_leaf(pair[0]), b.first_of_leaf(pair[1])]
}

/// A pose as three columns and a translation.
pub(crate) fn place(pose: &Pose) -> [[f64; 4]; 4] {
    let (r, t) = (pose.rotation(), pose.translation());
    [r.x_axis, r.y_axis, r.z_axis, t].map(|v| [v.x, v.y, v.z, 0.0])
}
