//! The paper's artificial trees: binary, `n = 2^depth` leaves, every child alpha times its parent along each axis, the two
//! children of a node in opposite corners of it.
//!
//! Nodes are made when they are asked for, so a tree takes no memory.

use super::traversal::{BinaryNode, Visits};
pub use punctual::internals::Random;
use std::array;

/// Which two opposite corners of a node its children take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corners {
    /// The lowest and the highest along every axis: all nodes lie on one diagonal.
    Fixed,
    /// Drawn anew for each node, by this seed: along every axis by itself, and so independent between axes.
    Random(u64),
}

/// A tree whose root has extent 1 along every axis. Lengths are in this unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArtificialTree {
    /// Diminishing factor along each axis, `0..=1`.
    pub alpha: [f64; 3],
    /// `log2` of the number of leaves.
    pub depth: u32,
    /// Where children lie.
    pub corners: Corners,
}

/// A node of an artificial tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArtificialNode {
    center: [f64; 3],
    extent: [f64; 3],
    alpha: [f64; 3],
    /// Levels below.
    height: u32,
    corners: Corners,
}

impl ArtificialTree {
    /// The root, with its centre at the given point.
    pub fn root_at(&self, center: [f64; 3]) -> ArtificialNode {
        ArtificialNode {
            center,
            extent: [1.0; 3],
            alpha: self.alpha,
            height: self.depth,
            corners: self.corners,
        }
    }

    /// What Algorithm 1 visits in this tree and another whose root is at `offset` from the root of this one.
    pub fn visits(&self, other: &Self, offset: [f64; 3]) -> Visits {
        Visits::count(self.root_at([0.0; 3]), other.root_at(offset))
    }
}

impl ArtificialNode {
    /// Centre of the box.
    pub fn center(&self) -> [f64; 3] {
        self.center
    }

    /// Full extent of the box.
    pub fn extent(&self) -> [f64; 3] {
        self.extent
    }
}

impl BinaryNode for ArtificialNode {
    fn overlaps(&self, other: &Self) -> bool {
        // A slack of 1e-12 of the extents: boxes that touch by construction must not part by rounding.
        let reach = |k: usize| (self.extent[k] + other.extent[k]) * (0.5 + 1e-12);
        (0..3).all(|k| (self.center[k] - other.center[k]).abs() <= reach(k))
    }

    fn children(&self) -> Option<[Self; 2]> {
        let height = self.height.checked_sub(1)?;
        let (signs, seeds) = match self.corners {
            Corners::Fixed => (0, [self.corners; 2]),
            Corners::Random(seed) => {
                let mut random = Random::new(seed);
                (
                    random.bits(),
                    [
                        Corners::Random(random.bits()),
                        Corners::Random(random.bits()),
                    ],
                )
            }
        };
        let extent = array::from_fn(|k| self.extent[k] * self.alpha[k]);
        let child = |second: bool| {
            let center = array::from_fn(|k| {
                let away = (self.extent[k] - extent[k]) * 0.5;
                let high = (signs >> (63 - k)) & 1 == u64::from(!second);
                self.center[k] + if high { away } else { -away }
            });
            Self {
                center,
                extent,
                alpha: self.alpha,
                height,
                corners: seeds[usize::from(second)],
            }
        };
        Some([child(false), child(true)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper;

    fn tree(alpha: [f64; 3], depth: u32, corners: Corners) -> ArtificialTree {
        ArtificialTree {
            alpha,
            depth,
            corners,
        }
    }

    fn level(tree: &ArtificialTree, level: u32) -> Vec<ArtificialNode> {
        let mut nodes = vec![tree.root_at([0.0; 3])];
        for _ in 0..level {
            nodes = nodes
                .iter()
                .flat_map(|node| node.children().unwrap())
                .collect();
        }
        nodes
    }

    #[test]
    fn children_touch_opposite_corners_of_their_parent() {
        for corners in [Corners::Fixed, Corners::Random(3)] {
            let tree = tree([0.5, 0.75, 0.25], 6, corners);
            for parent in level(&tree, 3) {
                let [first, second] = parent.children().unwrap();
                for k in 0..3 {
                    assert_eq!(first.extent[k], parent.extent[k] * tree.alpha[k]);
                    let border = |child: &ArtificialNode, side: f64| {
                        child.center[k] + side * child.extent[k]
                            - parent.center[k]
                            - side * parent.extent[k]
                    };
                    let side = if first.center[k] < parent.center[k] {
                        -0.5
                    } else {
                        0.5
                    };
                    assert!(
                        border(&first, side).abs() < 1e-15 && border(&second, -side).abs() < 1e-15
                    );
                }
            }
            assert!(level(&tree, 6).iter().all(|leaf| leaf.children().is_none()));
        }
    }

    #[test]
    fn random_corners_are_as_often_low_as_high_on_each_axis_by_itself() {
        let nodes = level(&tree([0.5; 3], 13, Corners::Random(9)), 12);
        let firsts = nodes.iter().map(|node| (node, node.children().unwrap()[0]));
        let signs: Vec<[bool; 3]> = firsts
            .map(|(p, c)| array::from_fn(|k| c.center[k] > p.center[k]))
            .collect();
        let share = |of: &dyn Fn(&[bool; 3]) -> bool| {
            signs.iter().filter(|s| of(s)).count() as f64 / 4096.0
        };
        for (j, k) in [(0, 0), (1, 1), (2, 2)] {
            assert!((share(&|s| s[j] || s[k]) - 0.5).abs() < 0.03);
        }
        for (j, k) in [(0, 1), (0, 2), (1, 2)] {
            assert!((share(&|s| s[j] && s[k]) - 0.25).abs() < 0.03);
        }
    }

    #[test]
    fn no_shrinking_visits_all_pairs() {
        let flat = tree([1.0; 3], 5, Corners::Fixed);
        assert_eq!(
            flat.visits(&flat, [0.5; 3]).overlapping,
            [1, 4, 16, 64, 256, 1024]
        );
        assert_eq!(flat.visits(&flat, [1.01, 0.0, 0.0]).bv_tests, 1);
        // Points in the corners of a cube: only the two pairs of equal corners meet.
        let points = tree([0.0; 3], 1, Corners::Fixed);
        assert_eq!(points.visits(&points, [0.0; 3]).overlapping, [1, 2]);
    }

    #[test]
    fn equation_11_is_the_mean_over_uniform_placements() {
        let (alpha, depth) = ([0.7, 0.8, 0.9], 7);
        let mut random = Random::new(1);
        let placements = 4000;
        let total: u64 = (0..placements)
            .map(|_| {
                let [a, b] = [(); 2].map(|()| tree(alpha, depth, Corners::Random(random.bits())));
                a.visits(&b, [(); 3].map(|()| random.between(-1.0, 1.0)))
                    .total()
            })
            .sum();
        let mean = total as f64 / f64::from(placements);
        let expected = paper::eq11(alpha, depth);
        assert!(
            (mean / expected - 1.0).abs() < 0.05,
            "{mean} is not {expected}"
        );
    }
}
