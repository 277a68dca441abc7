//! Where the shapes are for a configuration, and the filters before exact queries.
//!
//! Each filter proves that two shapes are apart at the poses as computed. Its own rounding, and the
//! difference between poses computed in two ways, are below [`SLACK`] times the size of what is
//! placed: a transform is a product of at most some hundred, each off by a few 2^-53 relative to
//! that size.

use punctual::glam::{DMat3, DVec3};

use crate::model::{Motion, PlacedShape};
use crate::near::Near;
use crate::shape::Inner;
use crate::transform::Transform;
use crate::world::{Pair, World};

const SLACK: f64 = 1e-11;

#[derive(Debug, Default)]
pub(crate) struct Placement {
    version: u64,
    bodies: Vec<Transform>,
    /// Shapes, each with the placement that it is of: those that move are placed when they are
    /// asked for. Those that stand still are placed for ever.
    shapes: Vec<(Transform, u64)>,
    /// Bounding spheres in the world: centre and radius.
    spheres: Vec<[f64; 4]>,
    /// Bounding spheres of the shapes that move, in their bodies: body, centre and radius.
    balls: Vec<(u32, DVec3, f64)>,
    /// Boxes of the shapes that stand still: rotation back, centre, half extents.
    still: Vec<Option<(DMat3, DVec3, DVec3)>>,
    near: Near,
    still_size: f64,
    /// Absolute slack of the filters, in metres.
    pub slack: f64,
    /// For each shape the row of its sums in `sums`, and the placement that they are of.
    rows: Vec<(u32, u64)>,
    sums: Vec<f64>,
    placed: u64,
}

impl Placement {
    /// Takes over the shapes of the world if they have changed.
    pub fn sync(&mut self, world: &World) {
        if self.version == world.version {
            return;
        }
        self.version = world.version;
        let count = world.shapes.len();
        self.bodies.clear();
        self.bodies
            .resize(world.model.bodies.len(), Transform::IDENTITY);
        self.shapes.clear();
        let place = |shape: &PlacedShape| match shape.body {
            0 => (shape.in_body, u64::MAX),
            _ => (shape.in_body, 0),
        };
        self.shapes.extend(world.shapes.iter().map(place));
        self.spheres.resize(count, [0.0; 4]);
        self.balls.clear();
        self.still.clear();
        self.rows.clear();
        self.still_size = 0.0;
        let mut sums = 0;
        for (i, shape) in world.shapes.iter().enumerate() {
            let inner = shape.shape.inner();
            let chain = world.model.bodies[shape.body as usize].chain.len();
            self.rows.push((sums, 0));
            sums += chain as u32 + 1;
            self.still.push((shape.body == 0).then(|| {
                let Transform { r, t } = shape.in_body.then(&inner.frame);
                (r.transpose(), t, inner.half)
            }));
            let centre = shape.in_body.point(inner.centre);
            if shape.body == 0 {
                let size = self.place_sphere(i, centre, inner.radius);
                self.still_size = self.still_size.max(size);
            } else {
                self.balls.push((shape.body, centre, inner.radius));
            }
        }
        self.sums.resize(sums as usize, 0.0);
        self.near.sync(world, &self.still);
    }

    /// Places all shapes.
    pub fn put(&mut self, world: &World, configuration: &[f64]) {
        world.model.place_bodies(configuration, &mut self.bodies);
        let far = |body: &Transform| body.t.abs().max_element();
        let mut size = self.bodies.iter().map(far).fold(self.still_size, f64::max);
        for (column, &i) in world.moving.iter().enumerate() {
            let (body, centre, radius) = self.balls[column];
            let centre = self.bodies[body as usize].point(centre);
            size = size.max(self.place_sphere(i as usize, centre, radius));
            self.near.put(column, self.spheres[i as usize]);
        }
        self.slack = SLACK * size;
        self.near.test(size);
        self.placed += 1;
    }

    #[inline]
    fn place_sphere(&mut self, i: usize, c: DVec3, radius: f64) -> f64 {
        self.spheres[i] = [c.x, c.y, c.z, radius];
        c.abs().max_element() + radius
    }

    /// A shape in the world.
    #[inline]
    pub fn shape(&mut self, world: &World, i: u32) -> Transform {
        let (place, placed) = &mut self.shapes[i as usize];
        if *placed < self.placed {
            let shape = &world.shapes[i as usize];
            *place = self.bodies[shape.body as usize].then(&shape.in_body);
            *placed = self.placed;
        }
        *place
    }

    /// False proves that the shapes are apart: by a sphere around each, or the box of a shape that
    /// stands still.
    #[inline]
    pub fn is_near(&self, slot: u32) -> bool {
        self.near.is(slot)
    }

    /// A lower bound of the squared distance, and the sum of the radii that it must exceed.
    #[inline]
    fn spheres(&self, pair: &Pair) -> (f64, f64) {
        let [ax, ay, az, ar] = self.spheres[pair.a as usize];
        let [bx, by, bz, br] = self.spheres[pair.b as usize];
        if let Some((back, centre, half)) = &self.still[pair.a as usize] {
            let p = *back * (DVec3::new(bx, by, bz) - *centre);
            let beyond = (p.abs() - *half).max(DVec3::ZERO);
            return (beyond.length_squared(), br);
        }
        let [x, y, z] = [ax - bx, ay - by, az - bz];
        (x * x + y * y + z * z, ar + br)
    }

    /// A lower bound of the distance, by spheres: may be negative.
    pub fn sphere_gap(&self, pair: &Pair) -> f64 {
        let (squared, radii) = self.spheres(pair);
        squared.sqrt() - radii - self.slack
    }

    /// A lower bound of the distance, by boxes: may be negative. `b_in_a` is the pose of the pair.
    pub fn box_gap(&self, [a, b]: [&Inner; 2], b_in_a: &Transform) -> f64 {
        let relative = a.frame.to(&b_in_a.then(&b.frame));
        box_gap(a.half, b.half, &relative) - self.slack
    }

    #[inline]
    pub fn b_in_a(&mut self, world: &World, pair: &Pair) -> Transform {
        let a = self.shape(world, pair.a);
        a.to(&self.shape(world, pair.b))
    }

    /// By so much at most the distance of a pair changes until the joint of each body has moved by
    /// `moves` (rad or m, signed), all at once and steadily.
    ///
    /// Joints above both bodies move neither relative to the other. So this is the way of `a`'s
    /// points and that of `b`'s, each relative to the last common body.
    pub fn reach(&mut self, world: &World, pair: &Pair, moves: &[f64]) -> f64 {
        let of_a = self.reach_of(world, pair.a, pair.common, moves);
        let of_b = self.reach_of(world, pair.b, pair.common, moves);
        (of_a + of_b) * (1.0 + 1e-9)
    }

    /// An upper bound of the way of a shape's points, if joints of its chain from `from` on move.
    ///
    /// The lesser of two bounds, where `r` is the largest distance of a point from a joint's axis
    /// now (1 for a sliding joint), and `m` what the joint moves:
    ///
    /// - The sum of `|m| r`. Moving one joint after the other, those near the root first, each
    ///   finds what it moves at the same distances from its axis as now, for what lies between has
    ///   turned rigidly. So distances now suffice, however far the joints move.
    /// - The way at the speed of now, and half of the largest acceleration. The speed is linear in
    ///   the point, so largest at a corner of the box. The acceleration is the sum over all pairs
    ///   of joints, also of each with itself, of `m m'` times the axis of the one nearer to the root
    ///   (none if it slides) times the lever of the other: at most its `r` and the sum above of the
    ///   joints after it, for these may have moved the point away from its axis.
    fn reach_of(&mut self, world: &World, shape: u32, from: u32, moves: &[f64]) -> f64 {
        let (row, placed) = self.rows[shape as usize];
        let row = row as usize;
        if placed != self.placed {
            self.rows[shape as usize].1 = self.placed;
            let place = self.shape(world, shape);
            let shape = &world.shapes[shape as usize];
            let inner = shape.shape.inner();
            let chain = &world.model.bodies[shape.body as usize].chain;
            let centre = place.point(inner.centre);
            let r = place.r * inner.frame.r;
            let half = [0, 1, 2].map(|i| r.col(i) * inner.half[i]);
            let (mut sum, mut levers, mut bend, mut rounding) = (0.0, 0.0, 0.0, 0.0);
            let (mut turn, mut speed) = (DVec3::ZERO, DVec3::ZERO);
            self.sums[row + chain.len()] = 0.0;
            for (k, &body) in chain.iter().enumerate().rev() {
                let way = moves[body as usize];
                if way != 0.0 {
                    let Transform { r, t } = self.bodies[body as usize];
                    let size = way.abs();
                    rounding += size * self.slack;
                    match world.model.bodies[body as usize].motion {
                        Motion::Turn(axis) => {
                            let axis = r * axis;
                            let across = |v: DVec3| v - axis * v.dot(axis);
                            let c = across(centre - t);
                            let by_box = farthest(c, half.map(across));
                            let radius = by_box.min(c.length() + inner.radius) + self.slack;
                            let lever = size * (radius + sum);
                            bend += size * (lever + 2.0 * levers);
                            levers += lever;
                            sum += size * radius;
                            turn += axis * way;
                            speed += axis.cross(centre - t) * way;
                        }
                        Motion::Slide(axis) => {
                            levers += size;
                            sum += size;
                            speed += r * axis * way;
                        }
                    }
                }
                let fastest = farthest(speed, half.map(|h| turn.cross(h)));
                self.sums[row + k] = sum.min(fastest + 0.5 * bend + rounding);
            }
        }
        self.sums[row + from as usize]
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
    let Transform { r, t } = *place;
    let abs = DMat3::from_cols(r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs());
    let of_a = t.abs() - a - abs * b;
    let of_b = (r.transpose() * t).abs() - b - abs.transpose() * a;
    let faces = of_a.max_element().max(of_b.max_element());
    if faces > 0.0 {
        return faces;
    }
    // Products of edges; their lengths matter only where a gap is found.
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
