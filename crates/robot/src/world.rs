//! The shapes of the robot and of its surroundings, and the pairs of them that are asked.

use std::sync::Arc;

use crate::model::{Model, PlacedShape, sorted};

/// A shape of the robot, or an obstacle.
///
/// The shapes of a model have the numbers from 0 on, by links in the order of the description.
/// Obstacles have the following numbers, which are never used again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShapeId(pub(crate) u32);

impl ShapeId {
    /// The number.
    pub fn number(self) -> u32 {
        self.0
    }
}

/// Two shapes, by index. If one stands still in the world, it is `a`; otherwise `a < b`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub a: u32,
    pub b: u32,
    pub a_is_still: bool,
    /// Number of joints above both bodies: they move neither relative to the other.
    pub common: u32,
}

/// What all threads share.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub model: Arc<Model>,
    /// Those of the robot, then the obstacles.
    pub shapes: Vec<PlacedShape>,
    /// Ids of the shapes, ascending.
    pub ids: Vec<ShapeId>,
    pub pairs: Vec<Pair>,
    /// Changes with every change of a shape.
    pub version: u64,
}

impl World {
    pub fn new(model: Arc<Model>) -> Self {
        let shapes = model.shapes.clone();
        let mut world = Self {
            ids: (0..shapes.len() as u32).map(ShapeId).collect(),
            model,
            shapes,
            pairs: Vec::new(),
            version: 1,
        };
        world.pair();
        world
    }

    /// Index of an obstacle.
    pub fn obstacle(&self, id: ShapeId) -> Option<usize> {
        let at = self.ids.binary_search(&id).ok()?;
        (at >= self.model.shapes.len()).then_some(at)
    }

    /// Lists the pairs anew.
    pub fn pair(&mut self) {
        self.pairs.clear();
        for b in 0..self.shapes.len() {
            for a in 0..b {
                if !self.asks([a, b]) {
                    continue;
                }
                let [x, y] = [a, b].map(|i| self.shapes[i].body);
                let [a, b] = if y == 0 { [b, a] } else { [a, b] };
                let chains = [x, y].map(|body| &self.model.bodies[body as usize].chain);
                let common = chains[0].iter().zip(chains[1]).take_while(|(x, y)| x == y);
                self.pairs.push(Pair {
                    a: a as u32,
                    b: b as u32,
                    a_is_still: x == 0 || y == 0,
                    common: common.count() as u32,
                });
            }
        }
    }

    fn asks(&self, pair: [usize; 2]) -> bool {
        let [x, y] = pair.map(|i| &self.shapes[i]);
        let may_touch =
            |x: &PlacedShape, y: &PlacedShape| y.link.is_some_and(|link| x.touches.contains(&link));
        let is_allowed = match [x.link, y.link] {
            [Some(x), Some(y)] => self.model.allowed.contains(&sorted([x, y])),
            _ => may_touch(x, y) || may_touch(y, x),
        };
        x.body != y.body && !is_allowed
    }

    /// The shapes of a pair, the lower id first.
    pub fn ids_of(&self, pair: u32) -> [ShapeId; 2] {
        let Pair { a, b, .. } = self.pairs[pair as usize];
        sorted([a, b].map(|i| self.ids[i as usize]))
    }
}
