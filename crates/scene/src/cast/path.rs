//! The times at which a moving shape may meet a box, and how far it may be from one.

use crate::broad::bounds::{arc_error, thickened};
use arrayvec::ArrayVec;
use core::f64::consts::PI;
use glam::DVec3;
use punctual::Tree;
use punctual_geom::{Aabb, Motion, length};

/// Maximum number of pieces; and of pieces of half a turn.
const PIECES: usize = 16;
const PIECES_PER_HALF: f64 = 8.0;

/// Bound of the rounding of a time, and of a distance relative to it.
const ROUNDING: f64 = 1e-12;

/// The boxes of a shape on its way. In each piece, every point is near the straight line between its
/// positions at both ends.
pub(super) struct Path {
    /// The box at the begin and at the end of each piece, widened by the deviation from the lines.
    pieces: ArrayVec<[Aabb; 2], PIECES>,
}

impl Path {
    pub fn new(tree: &Tree, motion: &Motion, margin: f64) -> Self {
        let angle = motion.turn().length();
        let is_still = angle == 0.0 && motion.velocity() == DVec3::ZERO;
        let pieces = libm::ceil(angle / PI * PIECES_PER_HALF).clamp(1.0, PIECES as f64);
        let margin = margin
            + if is_still {
                0.0
            } else {
                arc_error(tree, motion, angle / pieces)
            };
        let at = |piece: f64| thickened(tree.aabb_at(&motion.pose(piece / pieces)), margin);
        let pieces = (0..pieces as u32).map(|piece| [at(piece.into()), at(f64::from(piece) + 1.0)]);
        Self {
            pieces: pieces.collect(),
        }
    }

    /// The box at the begin.
    pub fn start(&self) -> &Aabb {
        &self.pieces[0][0]
    }

    /// A time before which the shape does not meet a box; `None` if it never does.
    pub fn enter(&self, bounds: &Aabb) -> Option<f64> {
        let count = self.pieces.len() as f64;
        let mut pieces = self.pieces.iter().zip(0u32..);
        pieces.find_map(|(ends, piece)| Some((f64::from(piece) + enter(ends, bounds)?) / count))
    }

    /// A lower bound of the distance from a box at the begin.
    pub fn apart(&self, bounds: &Aabb) -> f64 {
        let start = self.start();
        let gap = (start.min - bounds.max).max(bounds.min - start.max);
        length(gap.max(DVec3::ZERO)) * (1.0 - ROUNDING)
    }
}

/// The share of a piece before which a box that changes evenly does not meet another.
fn enter([from, to]: &[Aabb; 2], bounds: &Aabb) -> Option<f64> {
    if from.is_empty() || bounds.is_empty() {
        return None;
    }
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    let gaps = [
        (from.min - bounds.max, to.min - bounds.max),
        (bounds.min - from.max, bounds.min - to.max),
    ];
    for (from, to) in gaps {
        for axis in 0..3 {
            match (from[axis], to[axis]) {
                (from, to) if from > 0.0 && to > 0.0 => return None,
                (from, to) if from > 0.0 => enter = enter.max(from / (from - to)),
                (from, to) if to > 0.0 => leave = leave.min(from / (from - to)),
                _ => {}
            }
        }
    }
    (enter <= leave + ROUNDING).then(|| (enter - ROUNDING).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use glam::DMat3;
    use punctual::shapes;
    use punctual_geom::Pose;
    use punctual_geom::random::Random;

    /// Far out, fast and slow, straight and with up to eight turns: no corner is in a box before the
    /// time said.
    #[test]
    fn a_shape_is_in_no_box_before_the_time_said() {
        let mut random = Random::new(12);
        let mut vector =
            |size: f64| DVec3::from_array([(); 3].map(|()| random.between(-size, size)));
        let (tree, mut entered, mut late) = (Tree::new(shapes::gear(7, 2)), 0, 0);
        for case in 0..400 {
            let far = [1.0, 10.0, 1e5][case % 3];
            let start = Pose::new(DMat3::from_rotation_x(vector(3.0).x), vector(far)).unwrap();
            let turn = [DVec3::ZERO, vector(1.0), vector(15.0)][case % 4 % 3];
            let point = start.translation() + vector(2.0);
            let motion = Motion::turning(start, vector(6.0), turn, point).unwrap();
            let path = Path::new(&tree, &motion, 0.0);
            let poses: Vec<_> = (0..=128)
                .map(|i| motion.pose(f64::from(i) / 128.0))
                .collect();
            for _ in 0..20 {
                let middle = poses[(64.0 + vector(64.0).x) as usize].translation() + vector(4.0);
                let bounds = Aabb {
                    min: middle - 0.3,
                    max: middle + 0.3,
                };
                let is_in = |pose: &Pose| {
                    let corners = (0..tree.mesh().vertex_count()).map(|i| tree.mesh().vertex(i));
                    corners
                        .into_iter()
                        .any(|corner| bounds.contains(pose.transform_point(corner)))
                };
                let said = path.enter(&bounds);
                if let Some(first) = poses.iter().position(is_in) {
                    let first = first as f64 / 128.0;
                    assert!(said.is_some_and(|said| said <= first), "{said:?} {first}");
                    entered += 1;
                    late += usize::from(said > Some(0.0));
                }
            }
        }
        assert!(entered > 500 && late > 200, "{entered} {late}");
    }
}
