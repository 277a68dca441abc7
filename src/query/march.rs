//! Marching: from a triangle pair that meets to the next one along the curve, without a test.
//!
//! Where an edge of one triangle crosses the other one, the neighbor behind that edge meets it too.
//! So each hit of the triangle tests has ends from which the curve is followed ([`Curve`]), pair by
//! pair, until it comes to one that is known or to the border of a surface, or it is not certain
//! how it goes on. What is found so is reported at once, and not tested when the traversal comes to
//! it ([`known`](super::known)); but the traversal goes everywhere all the same, and so the answer
//! does not depend on where the marches led. A step costs more than the test that it saves, and the
//! sooner it leads to a pair the more it is worth, so a run marches only in its first part
//! ([`Marching`](super::strategy::Marching)).
//!
//! Here is what waits to be followed; the steps are in [`follow`](super::follow).

use super::known::{Added, Known};
use crate::math::Pose;
use crate::tree::Tree;
use crate::triangle::curve::Curve;
use arrayvec::ArrayVec;

/// Hits whose ends wait; those beyond are not followed.
const HITS: usize = 64;

/// The state of marching in a workspace.
#[derive(Clone, Debug)]
pub(super) struct March {
    pub known: Known,
    /// Pairs that were found along curves, and those among them to which the traversal has come
    /// since.
    pub followed: u64,
    pub passed: u64,
    /// Work of following curves.
    pub work: u64,
    /// Pairs (tree order) that were found by tests, and which edges certainly cross the other
    /// triangle: a bit each for 01, 12 and 20 of A, then those of B.
    pub hits: ArrayVec<([u32; 2], u32), HITS>,
    pub ends: [End; 2],
    /// How the vertices of both sides are placed in A: three columns, and where the origin goes.
    pub places: [[[f64; 4]; 4]; 2],
}

/// An end of a curve that is being followed.
#[derive(Clone, Debug)]
pub(super) struct End {
    pub follows: bool,
    pub curve: Curve,
    /// The triangles of the pair at which it is.
    pub at: [Place; 2],
}

/// A triangle to which an end of a curve has come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// In the order of the tree.
    pub triangle: u32,
    /// The numbers of its vertices, in the order of the curve's corners.
    pub vertices: [u32; 3],
}

impl Place {
    /// Goes to the neighbor behind the edge opposite to a corner and returns the vertex that it has
    /// in that corner's place.
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

impl March {
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

    /// Follows nothing that it would have gone on with.
    pub fn stop(&mut self) {
        self.hits.clear();
        self.ends.iter_mut().for_each(|end| end.follows = false);
    }

    /// Whether there is something to follow.
    #[inline(always)]
    pub fn is_due(&self) -> bool {
        self.ends[0].follows | self.ends[1].follows | !self.hits.is_empty()
    }

    /// Whether a pair was found already.
    #[inline(always)]
    pub fn knows(&self, trees: [&Tree; 2], pair: [u32; 2]) -> bool {
        !self.known.is_empty() && self.known.has(first(trees, pair), pair)
    }

    /// Takes out of these pairs of two clusters the known ones, to which the traversal has come
    /// now.
    #[inline(always)]
    pub fn pass(&mut self, hits: u64, first: [u32; 2]) -> u64 {
        let known = hits & self.known.of(first);
        self.passed += u64::from(known.count_ones());
        hits & !known
    }

    /// Takes note of a pair that was found by a test: false if it is known.
    pub fn note(&mut self, trees: [&Tree; 2], pair: [u32; 2], crossings: u32) -> bool {
        let added = self.known.add(first(trees, pair), pair);
        if added == Added::New && crossings != 0 {
            let _ = self.hits.try_push((pair, crossings));
        }
        self.passed += u64::from(added == Added::Known);
        if added == Added::NoRoom {
            // It might be found again.
            self.stop();
        }
        added != Added::Known
    }
}

/// The first triangles of the clusters of a pair.
#[inline(always)]
pub(super) fn first([a, b]: [&Tree; 2], pair: [u32; 2]) -> [u32; 2] {
    [a.first_of_cluster(pair[0]), b.first_of_cluster(pair[1])]
}

/// A pose as three columns and a translation.
pub(super) fn place(pose: &Pose) -> [[f64; 4]; 4] {
    let (r, t) = (pose.rotation(), pose.translation());
    [r.x_axis, r.y_axis, r.z_axis, t].map(|v| [v.x, v.y, v.z, 0.0])
}
