//! Places the shapes for a configuration, and filters the pairs before exact queries.
//!
//! Each filter proves that two shapes are apart at the poses as computed. Its own rounding, and the
//! difference between poses computed in two ways, are below [`SLACK`] times the size of what is
//! placed: a pose is a product of at most some hundred transforms, and each of them is off by a few
//! 2^-53 of that size.

use punctual::glam::{DMat3, DVec3};

use crate::model::{Motion, PlacedShape};
use crate::near::Near;
use crate::shape::Inner;
use crate::trajectory::Move;
use crate::transform::{Transform, relative};
use crate::world::{Pair, World};

const SLACK: f64 = 1e-11;

#[derive(Debug, Default)]
pub(crate) struct Placement {
    version: u64,
    /// Number of configurations placed.
    placed: u64,
    bodies: Vec<Transform>,
    shapes: Vec<Placed>,
    near: Near,
    /// The time for which obstacles that move by themselves are placed.
    time: f64,
    /// Sizes of what stands still, and of all.
    still_size: f64,
    size: f64,
    /// Absolute slack of the filters, in metres.
    pub slack: f64,
    /// For each shape, bounds of how far its points move, and of their acceleration, by the first
    /// joint of its chain that moves.
    ways: Vec<[f64; 2]>,
}

/// A shape in the world. One that moves is placed when it is asked for; one that stands still is
/// placed for ever.
#[derive(Clone, Copy, Debug)]
struct Placed {
    place: Transform,
    /// The configurations for which `place` and the bounds of its motion were computed, by number.
    placed: u64,
    measured: u64,
    /// Index of its first bound in [`Placement::ways`].
    ways: usize,
    /// Bounding sphere, in the body and in the world.
    centre: DVec3,
    /// How far an obstacle that moves by itself may be from there.
    reach: f64,
    /// The sum of its own margins.
    margins: f64,
    sphere: [f64; 4],
    /// If it stands still, its box: rotation back, centre, half extents.
    still: Option<StillBox>,
}

impl Placed {
    /// `ways` is the index of its first bound in [`Placement::ways`].
    fn new(shape: &PlacedShape, ways: usize) -> Self {
        let inner = shape.shape.inner();
        let (place, is_still) = (shape.in_body, shape.body == 0);
        let centre = place.transform_point3(inner.centre);
        let frame = place * inner.frame;
        let back = frame.matrix3.transpose();
        Self {
            place,
            placed: if is_still { u64::MAX } else { 0 },
            measured: 0,
            ways,
            centre,
            reach: 0.0,
            margins: shape.margins.iter().sum(),
            sphere: [centre.x, centre.y, centre.z, inner.radius],
            still: is_still.then_some((back, frame.translation, inner.half)),
        }
    }

    /// Bounds its coordinates.
    fn size(&self) -> f64 {
        self.centre.abs().max_element() + self.sphere[3]
    }
}

/// Rotation into the frame of a box, its centre and half extents.
pub(crate) type StillBox = (DMat3, DVec3, DVec3);

impl Placement {
    /// Takes over the shapes of the world if they have changed.
    pub fn sync(&mut self, world: &World) {
        if self.version == world.version {
            return;
        }
        match world.changed {
            Some((before, at)) if before == self.version => self.update(world, at),
            _ => self.renew(world),
        }
        self.version = world.version;
    }

    fn renew(&mut self, world: &World) {
        self.shapes.clear();
        self.ways.clear();
        for shape in &world.shapes {
            self.shapes.push(Placed::new(shape, self.ways.len()));
            let chain = world.chain(shape.body);
            self.ways
                .resize(self.ways.len() + chain.len() + 1, [0.0; 2]);
        }
        self.placed = 0;
        self.bodies.clear();
        self.bodies.resize(
            world.model.bodies.len() + world.tracks.len(),
            Transform::IDENTITY,
        );
        self.measure_still();
        let still = |shape: u32| self.shapes[shape as usize].still;
        self.near.sync(world, still);
    }

    /// Takes over a shape that was moved, or added behind the others: the only change since the
    /// last call.
    fn update(&mut self, world: &World, at: usize) {
        let shape = &world.shapes[at];
        match self.shapes.get_mut(at) {
            Some(placed) => {
                *placed = Placed::new(shape, placed.ways);
                self.measure_still();
            }
            // A shape that moves is the second one of pairs with all the others.
            None if shape.body != 0 => return self.renew(world),
            None => {
                let placed = Placed::new(shape, self.ways.len());
                self.still_size = self.still_size.max(placed.size());
                self.shapes.push(placed);
                self.ways.push([0.0; 2]);
            }
        }
        let still = |shape: u32| self.shapes[shape as usize].still;
        self.near.update(world, at as u32, still);
    }

    fn measure_still(&mut self) {
        let still = self.shapes.iter().filter(|shape| shape.still.is_some());
        self.still_size = still.map(Placed::size).fold(0.0, f64::max);
    }

    /// Places all shapes, obstacles that move by themselves where they are at this time.
    pub fn put(&mut self, world: &World, configuration: &[f64], time: f64) {
        self.time = time;
        world.model.place_bodies(configuration, &mut self.bodies);
        let others = &mut self.bodies[world.model.bodies.len()..];
        for (body, track) in others.iter_mut().zip(&world.tracks) {
            *body = track.at(time);
        }
        let far = |body: &Transform| body.translation.abs().max_element();
        let mut size = self
            .bodies
            .iter()
            .map(far)
            .fold(self.still_size.max(world.widest), f64::max);
        for (column, &i) in world.moving.iter().enumerate() {
            let body = &self.bodies[world.shapes[i as usize].body as usize];
            let shape = &mut self.shapes[i as usize];
            if let Some(track) = world.track(world.shapes[i as usize].body) {
                shape.reach = track.reach_at(time);
            }
            let (c, r) = (body.transform_point3(shape.centre), shape.sphere[3]);
            shape.sphere = [c.x, c.y, c.z, r];
            let radius = r + shape.margins + shape.reach;
            size = size.max(c.abs().max_element() + radius);
            self.near.put(column, [c.x, c.y, c.z, radius]);
        }
        self.slack = SLACK * size;
        self.size = size;
        self.placed += 1;
    }

    #[inline]
    pub fn shape(&mut self, world: &World, i: u32) -> Transform {
        let shape = &mut self.shapes[i as usize];
        if shape.placed < self.placed {
            let PlacedShape { body, in_body, .. } = &world.shapes[i as usize];
            shape.place = self.bodies[*body as usize] * *in_body;
            shape.placed = self.placed;
        }
        shape.place
    }

    /// Lists the pairs that are not proven apart by a sphere around each shape, or the box of one
    /// that stands still, as [`Near::list`].
    pub fn list(&mut self, ranks: &[u32], found: &mut [u64]) {
        self.near.list(self.size, ranks, found);
    }

    /// A lower bound of the distance above the margin, by spheres, or the box of a shape that
    /// stands still.
    pub fn sphere_gap(&self, pair: &Pair) -> f64 {
        let [a, b] = [pair.a, pair.b].map(|i| &self.shapes[i as usize]);
        let ([ax, ay, az, ar], [bx, by, bz, br]) = (a.sphere, b.sphere);
        let (between, radii) = match &a.still {
            Some((back, centre, half)) => {
                let p = *back * (DVec3::new(bx, by, bz) - *centre);
                ((p.abs() - *half).max(DVec3::ZERO), br)
            }
            None => (DVec3::new(ax - bx, ay - by, az - bz), ar + br),
        };
        between.length() - radii - self.slack - self.margin(pair)
    }

    /// A lower bound of the distance above the margin, by boxes. `b_in_a` is the pose of the pair.
    pub fn box_gap(&self, pair: &Pair, [a, b]: [&Inner; 2], b_in_a: &Transform) -> f64 {
        let relative = relative(&a.frame, &(*b_in_a * b.frame));
        box_gap(a.half, b.half, &relative) - self.slack - self.margin(pair)
    }

    /// The margin of a pair, plus how far its obstacles may be off their tracks.
    #[inline]
    pub fn margin(&self, pair: &Pair) -> f64 {
        let reach = |i: u32| self.shapes[i as usize].reach;
        if pair.is_timed {
            pair.margin + (reach(pair.a) + reach(pair.b))
        } else {
            pair.margin
        }
    }

    #[inline]
    pub fn b_in_a(&mut self, world: &World, pair: &Pair) -> Transform {
        let a = self.shape(world, pair.a);
        relative(&a, &self.shape(world, pair.b))
    }

    /// Adds to `row`, for each joint, how fast a point of a shape moves along a direction per
    /// unit of the joint's speed.
    pub fn add_gradient(
        &self,
        world: &World,
        shape: usize,
        point: DVec3,
        along: DVec3,
        row: &mut [f64],
    ) {
        for &body in world.chain(world.shapes[shape].body) {
            let (at, of) = (
                &self.bodies[body as usize],
                &world.model.bodies[body as usize],
            );
            let way = match of.motion {
                Motion::Turn(axis) => (at.matrix3 * axis).cross(point - at.translation),
                Motion::Slide(axis) => at.matrix3 * axis,
            };
            if let Some((joint, factor)) = of.value.joint() {
                row[joint] += factor * along.dot(way);
            }
        }
    }

    /// An upper bound of the change in the distance of a pair while the joint of each body moves by
    /// `moves` (rad or m), all at once, and obstacles move by themselves for `half` seconds.
    ///
    /// Joints above both bodies move neither relative to the other. So this is the sum of how far
    /// the points of `a` and those of `b` move, each relative to the last common body.
    pub fn reach(&mut self, world: &World, pair: &Pair, moves: &[Move], half: f64) -> f64 {
        let of_a = self.reach_of(world, pair.a, pair.common, moves);
        let of_b = self.reach_of(world, pair.b, pair.common, moves);
        let way = |shape: u32| {
            let PlacedShape { body, shape, .. } = &world.shapes[shape as usize];
            let radius = shape.inner().centre.length() + shape.inner().radius;
            let track = world.track(*body);
            track.map_or(0.0, |track| track.way(self.time, half, radius))
        };
        let ways = if pair.is_timed {
            way(pair.a) + way(pair.b)
        } else {
            0.0
        };
        (of_a + of_b) * (1.0 + 1e-9) + ways
    }

    /// The most by which the second shape of a pair is off a straight line from the beginning of
    /// the interval of [`Placement::reach`] to its end, seen from the first, apart from its turn
    /// about its middle. Infinite if the first one moves.
    ///
    /// Between two points that it leaves and reaches at the same times, a path with an acceleration
    /// of at most `k` is off the line by at most `k / 8` times the square of the duration, which is
    /// 2 here.
    pub fn bend(&self, pair: &Pair) -> f64 {
        let [a, b] = [pair.a, pair.b].map(|i| self.shapes[i as usize].ways + pair.common as usize);
        if pair.is_timed || self.ways[a][0] > 0.0 {
            return f64::INFINITY;
        }
        0.5 * self.ways[b][1] * (1.0 + 1e-9)
    }

    /// An upper bound of how far the points of a shape move, if joints of its chain from `from` on
    /// move.
    ///
    /// The lesser of two bounds, where `r` is the largest distance of a point from a joint's axis
    /// now (1 for a sliding joint), and `m` what the joint moves at most:
    ///
    /// - The sum of `|m| r`. The joints may be moved one after the other, those near the root
    ///   first. Each joint then finds its points at the same distances from its axis as now,
    ///   because all that lies between has turned rigidly. So present distances suffice, however
    ///   far the joints move.
    /// - The distance covered at the present speed of the joints, plus half of the largest
    ///   acceleration. That is what the joints' own accelerations give, and what their turns do.
    ///   The speed is linear in the point, so largest at a corner of the box. The acceleration is
    ///   the sum over all pairs of joints, also of each with itself, of `m m'` times the axis of
    ///   the one nearer to the root (none if it slides) times the lever of the other. That lever is
    ///   at most its `r` and the sum above of the joints after it, for these may have moved the
    ///   point away from its axis.
    fn reach_of(&mut self, world: &World, shape: u32, from: u32, moves: &[Move]) -> f64 {
        let Placed { measured, ways, .. } = self.shapes[shape as usize];
        if measured != self.placed {
            self.shapes[shape as usize].measured = self.placed;
            let place = self.shape(world, shape);
            let shape = &world.shapes[shape as usize];
            let inner = shape.shape.inner();
            let chain = world.chain(shape.body);
            let centre = place.transform_point3(inner.centre);
            let r = place.matrix3 * inner.frame.matrix3;
            let half = [0, 1, 2].map(|i| r.col(i) * inner.half[i]);
            let (mut sum, mut levers, mut bend, mut rounding) = (0.0, 0.0, 0.0, 0.0);
            let (mut turn, mut speed) = (DVec3::ZERO, DVec3::ZERO);
            self.ways[ways + chain.len()] = [0.0; 2];
            for (k, &body) in chain.iter().enumerate().rev() {
                let Move {
                    way,
                    size,
                    bend: own,
                } = moves[body as usize];
                if size != 0.0 {
                    let at = self.bodies[body as usize];
                    let (r, t) = (at.matrix3, at.translation);
                    rounding += size * self.slack;
                    match world.model.bodies[body as usize].motion {
                        Motion::Turn(axis) => {
                            let axis = r * axis;
                            let across = |v: DVec3| v - axis * v.dot(axis);
                            let c = across(centre - t);
                            let by_box = farthest(c, half.map(across));
                            let radius = by_box.min(c.length() + inner.radius) + self.slack;
                            let lever = size * (radius + sum);
                            bend += size * (lever + 2.0 * levers) + own * (radius + sum);
                            levers += lever;
                            sum += size * radius;
                            turn += axis * way;
                            speed += axis.cross(centre - t) * way;
                        }
                        Motion::Slide(axis) => {
                            levers += size;
                            bend += own;
                            sum += size;
                            speed += r * axis * way;
                        }
                    }
                }
                let fastest = farthest(speed, half.map(|h| turn.cross(h)));
                self.ways[ways + k] = [sum.min(fastest + 0.5 * bend + rounding), bend];
            }
        }
        self.ways[ways + from as usize][0]
    }
}

/// The length of the longest vector `c + u + v + w`, where `u`, `v` and `w` may be reversed.
fn farthest(c: DVec3, [u, v, w]: [DVec3; 3]) -> f64 {
    // The farthest of two opposite corners, for each of the four diagonals.
    let diagonals = [u + v + w, u + v - w, u - v + w, u - v - w];
    let corner = |s: &DVec3| s.length_squared() + 2.0 * c.dot(*s).abs();
    let corner = diagonals.iter().map(corner).fold(0.0, f64::max);
    (c.length_squared() + corner).sqrt()
}

/// The largest gap of two boxes along 15 axes: a lower bound of their distance, up to rounding.
/// Negative if none separates them. `place` brings the second box into the frame of the first.
fn box_gap(a: DVec3, b: DVec3, place: &Transform) -> f64 {
    let (r, t) = (place.matrix3, place.translation);
    let abs = DMat3::from_cols(r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs());
    let of_a = t.abs() - a - abs * b;
    let of_b = (r.transpose() * t).abs() - b - abs.transpose() * a;
    let faces = of_a.max_element().max(of_b.max_element());
    if faces > 0.0 {
        return faces;
    }
    // Cross products of edges. They are normalized only where they show a gap.
    let mut best = faces;
    for j in 0..3 {
        let (axis, along) = (r.col(j), abs.col(j));
        let (u, v) = ((j + 1) % 3, (j + 2) % 3);
        let reach_b = abs.col(v) * b[u] + abs.col(u) * b[v];
        let gaps = DVec3::new(
            (t.z * axis.y - t.y * axis.z).abs() - a.y * along.z - a.z * along.y - reach_b.x,
            (t.x * axis.z - t.z * axis.x).abs() - a.z * along.x - a.x * along.z - reach_b.y,
            (t.y * axis.x - t.x * axis.y).abs() - a.x * along.y - a.y * along.x - reach_b.z,
        );
        for i in 0..3 {
            let squared = 1.0 - axis[i] * axis[i];
            // Edges that are nearly parallel separate no better than faces do.
            if gaps[i] > 0.0 && squared > 1e-4 {
                best = best.max(gaps[i] / squared.sqrt());
            }
        }
    }
    best
}
