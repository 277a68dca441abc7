//! The shapes of the robot and of its surroundings, and the pairs of them that are checked.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::RobotError;
use crate::margin::Margins;
use crate::model::{Model, PlacedShape, sorted};
use crate::track::Track;
use crate::transform::Transform;

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
    /// Its place in a table with a row for each shape and a column for each shape that moves.
    pub slot: u32,
    /// Number of joints above both bodies: they move neither relative to the other.
    pub common: u32,
    /// Shapes that are no farther apart than this count as in contact.
    pub margin: f64,
    /// True if one of them is an obstacle that moves by itself.
    pub is_timed: bool,
}

/// Shapes that a filter takes at a time.
pub(crate) const LANES: usize = 8;

/// A version that no world has had.
fn next_version() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}

/// The world, shared by all threads.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub model: Arc<Model>,
    /// The shapes of the robot, then the obstacles, by ascending ids.
    pub shapes: Vec<PlacedShape>,
    pub pairs: Vec<Pair>,
    /// The ways of obstacles that move by themselves: their bodies follow those of the model.
    pub tracks: Vec<Track>,
    /// The shapes that move, by index.
    pub moving: Vec<u32>,
    pub margins: Margins,
    /// Pairs of names, each in ascending order, and whether the caller lets them touch.
    pub set_pairs: Vec<([String; 2], bool)>,
    /// The largest margin of a pair.
    pub widest: f64,
    /// Another one after every change of a shape, a pair or a margin. No two worlds have the same
    /// one, unless one is a clone of the other.
    pub version: u64,
    /// If the last change was of one shape, or added one behind the others: the version before it,
    /// and the shape.
    pub changed: Option<(u64, usize)>,
}

impl World {
    pub fn new(model: Arc<Model>) -> Self {
        let mut world = Self {
            shapes: model.shapes.clone(),
            model,
            pairs: Vec::new(),
            tracks: Vec::new(),
            moving: Vec::new(),
            margins: Margins::default(),
            set_pairs: Vec::new(),
            widest: 0.0,
            version: next_version(),
            changed: None,
        };
        world.pair();
        world
    }

    pub fn index(&self, id: ShapeId) -> Option<usize> {
        let found = self.shapes.binary_search_by_key(&id, |shape| shape.id);
        found.ok()
    }

    /// True if there is a link, a shape or an obstacle of this name.
    pub fn knows(&self, name: &str) -> bool {
        let mut shapes = self.shapes.iter();
        self.model.link_number(name).is_ok() || shapes.any(|shape| &*shape.name == name)
    }

    pub fn obstacle(&self, id: ShapeId) -> Result<usize, RobotError> {
        let found = self.index(id);
        let obstacle = found.filter(|&at| at >= self.model.shapes.len());
        obstacle.ok_or(RobotError::NoObstacle)
    }

    /// Lists the pairs anew.
    pub fn pair(&mut self) {
        self.pairs.clear();
        let moves = |&i: &u32| self.shapes[i as usize].body != 0;
        self.moving = (0..self.shapes.len() as u32).filter(moves).collect();
        (0..self.shapes.len()).for_each(|b| self.pair_with_earlier(b));
    }

    /// Adds a shape, and its pairs behind those there are.
    pub fn push(&mut self, mut shape: PlacedShape) {
        shape.margins = self.margins.of(&self.model, &shape);
        let (new, stride) = (self.shapes.len(), self.stride());
        if shape.body != 0 {
            self.moving.push(new as u32);
        }
        self.shapes.push(shape);
        self.change(Some(new));
        if self.stride() == stride {
            self.pair_with_earlier(new);
        } else {
            // All slots have changed.
            self.pair();
        }
    }

    /// Notes a change, of one shape or of any number.
    pub fn change(&mut self, shape: Option<usize>) {
        self.changed = shape.map(|shape| (self.version, shape));
        self.version = next_version();
    }

    /// Removes an obstacle and its pairs. Returns the new number of each old pair, `u32::MAX` for a
    /// removed one; `None` if the pairs were listed anew.
    pub fn remove(&mut self, at: usize) -> Option<Vec<u32>> {
        self.change(None);
        let body = self.shapes.remove(at).body;
        if body != 0 {
            self.pair();
            return None;
        }
        let (at, stride) = (at as u32, self.stride() as u32);
        let earlier = |i: &mut u32| *i -= u32::from(*i > at);
        self.moving.iter_mut().for_each(earlier);
        let (mut numbers, mut next) = (Vec::with_capacity(self.pairs.len()), 0);
        self.pairs.retain_mut(|pair| {
            let is_kept = pair.a != at && pair.b != at;
            numbers.push(if is_kept { next } else { u32::MAX });
            next += u32::from(is_kept);
            pair.slot -= stride * u32::from(pair.a > at);
            [&mut pair.a, &mut pair.b].into_iter().for_each(earlier);
            is_kept
        });
        Some(numbers)
    }

    /// Lists the pairs of a shape with those before it.
    fn pair_with_earlier(&mut self, b: usize) {
        let stride = self.stride() as u32;
        // Two shapes that stand still are not checked.
        let is_still = self.shapes[b].body == 0;
        let partners = if is_still { self.column(b as u32) } else { b };
        for i in 0..partners {
            let a = if is_still { self.moving[i] as usize } else { i };
            if !self.asks([a, b]) {
                continue;
            }
            let [x, y] = [a, b].map(|i| self.shapes[i].body);
            let [a, b] = if y == 0 { [b, a] } else { [a, b] };
            let chains = [x, y].map(|body| self.chain(body));
            let margin = self.margin([a, b]);
            let common = chains[0].iter().zip(chains[1]).take_while(|(x, y)| x == y);
            self.pairs.push(Pair {
                a: a as u32,
                b: b as u32,
                slot: a as u32 * stride + self.column(b as u32) as u32,
                common: common.count() as u32,
                margin,
                is_timed: [x, y].iter().any(|&body| self.track(body).is_some()),
            });
            self.widest = self.widest.max(margin);
        }
    }

    fn margin(&self, pair: [usize; 2]) -> f64 {
        let shapes = pair.map(|i| &self.shapes[i]);
        self.margins.of_pair(&self.model, shapes)
    }

    /// Takes over margins that were set.
    pub fn measure_margins(&mut self) {
        for shape in &mut self.shapes {
            shape.margins = self.margins.of(&self.model, shape);
        }
        self.widest = 0.0;
        for number in 0..self.pairs.len() {
            let Pair { a, b, .. } = self.pairs[number];
            let margin = self.margin([a as usize, b as usize]);
            self.pairs[number].margin = margin;
            self.widest = self.widest.max(margin);
        }
        self.change(None);
    }

    /// The moving joints from the root to a body.
    pub fn chain(&self, body: u32) -> &[u32] {
        let body = self.model.bodies.get(body as usize);
        body.map_or(&[], |body| &body.chain)
    }

    /// The track of a body, if it moves by itself.
    #[inline]
    pub fn track(&self, body: u32) -> Option<&Track> {
        self.tracks
            .get((body as usize).checked_sub(self.model.bodies.len())?)
    }

    /// The most by which margins and reaches can take a distance below 0.
    pub fn reach(&self) -> f64 {
        let reaches = self.tracks.iter().map(|track| track.reach_at(0.0));
        self.widest + reaches.fold(0.0, f64::max)
    }

    /// True for an obstacle that moves with a link.
    pub fn is_attached(&self, at: usize) -> bool {
        !self.chain(self.shapes[at].body).is_empty()
    }

    /// Sets or takes the track of an obstacle in the world. True if the pairs are listed anew.
    pub fn set_track(&mut self, at: usize, track: Option<Track>) -> bool {
        let (body, own) = (self.shapes[at].body, self.model.bodies.len());
        let old = (body as usize).checked_sub(own);
        match (old, track) {
            (None, None) => return false,
            (Some(old), Some(track)) => {
                self.tracks[old] = track;
                return false;
            }
            (None, Some(track)) => {
                self.shapes[at].body = (own + self.tracks.len()) as u32;
                self.shapes[at].in_body = Transform::IDENTITY;
                self.tracks.push(track);
            }
            (Some(old), None) => {
                self.tracks.remove(old);
                let later = self.shapes.iter_mut().filter(|shape| shape.body > body);
                later.for_each(|shape| shape.body -= 1);
                self.shapes[at].body = 0;
            }
        }
        self.pair();
        self.change(None);
        true
    }

    /// Number of the shapes that move, filled up to whole lanes.
    pub fn stride(&self) -> usize {
        self.moving.len().next_multiple_of(LANES)
    }

    /// Number of a shape among those that move.
    pub fn column(&self, shape: u32) -> usize {
        self.moving.partition_point(|&i| i < shape)
    }

    fn asks(&self, pair: [usize; 2]) -> bool {
        let [x, y] = pair.map(|i| &self.shapes[i]);
        let may_touch =
            |x: &PlacedShape, y: &PlacedShape| y.link.is_some_and(|link| x.touches.contains(&link));
        let is_of_pair = |(names, _): &&([String; 2], bool)| {
            let is = |shape, i: usize| self.model.is_named(shape, &names[i]);
            is(x, 0) && is(y, 1) || is(x, 1) && is(y, 0)
        };
        let set = self.set_pairs.iter().rev().find(is_of_pair);
        let is_allowed = match [x.link, y.link] {
            _ if set.is_some() => set.is_some_and(|set| set.1),
            [Some(x), Some(y)] if self.model.allowed.contains(&sorted([x, y])) => true,
            [Some(_), Some(_)] => {
                let follows = |x: u32, y: u32| self.model.bodies[x as usize].parent == y;
                let is_next = follows(x.body, y.body) || follows(y.body, x.body);
                self.model.description().allows_neighbours && is_next
            }
            _ => may_touch(x, y) || may_touch(y, x),
        };
        // The distance of an obstacle from shapes that stand still does not depend on the robot.
        let is_moved = |shape: &PlacedShape| !self.chain(shape.body).is_empty();
        x.body != y.body && (is_moved(x) || is_moved(y)) && !is_allowed
    }

    /// The shapes of a pair, the lower id first.
    pub fn ids_of(&self, pair: u32) -> [ShapeId; 2] {
        let Pair { a, b, .. } = self.pairs[pair as usize];
        sorted([a, b].map(|i| self.shapes[i as usize].id))
    }
}
