//! Tests whether the triangles that met last, or their neighbors, still meet: the cheapest test,
//! for eight pairs at once.

use crate::body::{Bodies, Placed, thickness, triangle_ids};
use crate::id::PairKey;
use arrayvec::ArrayVec;
use core::mem;
use glam::DVec3;
use punctual::Tree;
use punctual::engine::flushing_matters;
use punctual_geom::lanes::Instructions;
use punctual_geom::triangle::batch::Verdicts;
use punctual_geom::triangle::distance::closest_or_meeting;
use punctual_geom::triangle::filter64::{Columns, Filter64};
use punctual_geom::triangles_intersect;
use punctual_geom::{Pose, bits};

/// Pairs tested at once.
const LANES: usize = 8;

/// A pair that met, and the triangles (ids) that met last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waiting {
    /// Its index in the list of known pairs.
    pub place: usize,
    pub ids: [u32; 2],
}

/// The corners of two triangles (tree order), in A's frame.
#[inline]
fn corners([a, b]: [&Tree; 2], [x, y]: [u32; 2], b_in_a: &Pose) -> [[DVec3; 3]; 2] {
    let [p, q, r] = b.corners(y);
    [
        a.corners(x),
        [
            b_in_a.transform_point(p),
            b_in_a.transform_point(q),
            b_in_a.transform_point(r),
        ],
    ]
}

/// Pairs that wait for their test.
pub(crate) struct Retest<'b> {
    bodies: &'b Bodies,
    pub waiting: ArrayVec<Waiting, LANES>,
    columns: [Columns; 2],
    instructions: Instructions,
}

impl<'b> Retest<'b> {
    pub fn new(bodies: &'b Bodies) -> Self {
        Self {
            bodies,
            waiting: ArrayVec::new(),
            columns: [Columns::ZERO, Columns::ZERO],
            instructions: Instructions::detect(),
        }
    }

    /// Puts the witness of a pair (tree order) into the next lane. False if it cannot be tested
    /// separately.
    #[inline]
    pub fn add(&mut self, key: PairKey, place: usize, witness: [u32; 2]) -> bool {
        let Some([a, b]) = self.bodies.pair(key) else {
            return false;
        };
        let (b_in_a, trees) = (a.relative(b), [&*a.body.tree, &*b.body.tree]);
        let ids = triangle_ids([a, b], witness)
            .filter(|_| !flushing_matters(trees[0], trees[1], &b_in_a));
        let Some(ids) = ids else { return false };
        let lane = self.waiting.len();
        for (columns, corners) in self
            .columns
            .iter_mut()
            .zip(&corners(trees, witness, &b_in_a))
        {
            columns.set(lane, corners);
        }
        self.waiting.push(Waiting { place, ids });
        true
    }

    /// Tests the pairs that wait. Returns each, and whether its triangles still meet.
    pub fn test(&mut self) -> impl Iterator<Item = (Waiting, bool)> + use<> {
        let hits = meeting(self.instructions, &self.columns, self.waiting.len());
        let tested = mem::take(&mut self.waiting).into_iter().enumerate();
        tested.map(move |(lane, pair)| (pair, hits >> lane & 1 != 0))
    }
}

/// The ids of two triangles (tree order) of bodies with margins, and an upper bound of their
/// distance, if they are within the margins.
pub(crate) fn within(pair: [&Placed; 2], witness: [u32; 2]) -> Option<([u32; 2], f64)> {
    let trees = pair.map(|placed| &*placed.body.tree);
    let b_in_a = &pair[0].relative(pair[1]);
    let ids =
        triangle_ids(pair, witness).filter(|_| !flushing_matters(trees[0], trees[1], b_in_a))?;
    let [a, b] = corners(trees, witness, b_in_a);
    // For triangles that meet, `high` is no distance.
    let distance = match triangles_intersect(&a, &b) {
        true => 0.0,
        false => closest_or_meeting(&a, &b).high,
    };
    (distance <= thickness(pair)).then_some((ids, distance))
}

/// Tests the neighbors of the latest witness, because surfaces usually still meet nearby, unless
/// they move far in a frame: one of its triangles with the neighbor of the other
/// across an edge. Returns two that meet, in tree order.
pub(crate) fn beside(pair: [&Placed; 2], latest: [u32; 2]) -> Option<[u32; 2]> {
    let trees = pair.map(|placed| &*placed.body.tree);
    let b_in_a = &pair[0].relative(pair[1]);
    triangle_ids(pair, latest).filter(|_| !flushing_matters(trees[0], trees[1], b_in_a))?;
    let mut columns = [Columns::ZERO, Columns::ZERO];
    for (columns, corners) in columns.iter_mut().zip(&corners(trees, latest, b_in_a)) {
        columns.fill(corners);
    }
    let mut next = ArrayVec::<_, LANES>::new();
    for (side, tree) in trees.into_iter().enumerate() {
        let (triangle, corners) = (latest[side], tree.vertices_of(latest[side]));
        for edge in 0..3 {
            let Some(across) = tree.across(triangle, edge) else {
                continue;
            };
            let apex = (edge + 2) % 3;
            let vertex = tree.vertex_across(triangle, corners[apex], across);
            let vertex = tree.mesh().vertex(vertex as usize);
            let vertex = if side == 0 {
                vertex
            } else {
                b_in_a.transform_point(vertex)
            };
            columns[side].set_corner(next.len(), apex, vertex);
            let mut pair = latest;
            pair[side] = across;
            next.push(pair);
        }
    }
    let hits = meeting(Instructions::detect(), &columns, next.len());
    next.get(hits.trailing_zeros() as usize).copied()
}

/// Mask of the first `count` pairs of triangles that meet.
fn meeting(instructions: Instructions, [a, b]: &[Columns; 2], count: usize) -> u32 {
    let Verdicts { hit, doubt } = instructions.run(Filter64 { a, b, count });
    let wanted = (1 << count) - 1;
    let in_doubt =
        bits(doubt & wanted).filter(|&lane| triangles_intersect(&a.get(lane), &b.get(lane)));
    in_doubt.fold(hit & wanted, |hits, lane| hits | 1 << lane)
}
