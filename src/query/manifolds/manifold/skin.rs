//! Reduces pairs of triangles that are apart, as a query lists them: one pass, no list.
//!
//! Points with normals within 47 degrees share a cone. Of a cone only the nearest point is kept,
//! and the farthest along eight directions across its axis. The query finds one point of each pair.
//! If the normal of a pair is that of one of its faces, the other triangle is also cut to the prism
//! over that face ([`clip`]), and the corners of the common area are points too.
//!
//! The closest points of two triangles need not be closest points of the surfaces near them: two
//! triangles of a flat floor are both close to a corner above, one of them aslant. A pair is
//! dropped if its distance falls on the way into a neighbor ([`falls_beside`]). The pair with that
//! neighbor is closer, so it is listed too, and the way ends at a pair that stays. Where surfaces
//! are oriented, pairs on the inner side of one are dropped too.

use super::{Manifold, ManifoldPoint, Octagon};
use crate::engine::memory::identity::Before;
use crate::tree::Tree;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual_geom::triangle::distance::{Closest, Places};
use punctual_geom::{Pose, larger};

/// Cosine of the widest angle, 47 degrees, between the axis of a cone and its normals, and its
/// sine. The angle is more than 45 degrees, so that a contact of two edges that lie on each other
/// joins the cone of the faces beside them.
const CONE: f64 = 0.682;
const ACROSS_CONE: f64 = 0.732;

/// Squared cosines of 52 and of 42 degrees, for a direction within 5 degrees of a normal. If the
/// direction is closer to an axis than 52 degrees, the normal may be in the cone; closer than 42,
/// it is.
const MAY_JOIN: f64 = 0.379;
const JOINS: f64 = 0.5525;

/// Squared cosine of 84 degrees. If a direction is closer than that to the inner side of a face,
/// each normal within 5 degrees of the direction is on that side.
const BEHIND: f64 = 0.01;

/// Room for cones. Each axis is more than 47 degrees from those before, and of 24 points on a
/// sphere two are no farther apart than 43.7 degrees.
const CONES: usize = 24;

/// Squared cosine of the largest angle, about .8 degrees, between a normal and that of a face for
/// which the two count as equal.
const FACE: f64 = 0.9998;

/// Squared cosine of the largest angle, 6 degrees, between a contact normal and two faces that face
/// each other.
const FACING: f64 = 0.989;

/// Squared cosine of the largest angle, 45 degrees, between two faces that have an area in common.
const OPPOSITE: f64 = 0.5;

/// Squared cosine of 13 degrees. Two faces closer than that to a direction within 5 degrees of the
/// contact normal may have a common area that counts.
const STEEP: f64 = 0.95;

/// Cosine of the largest angle, 7 degrees, between a normal and the one that it is replaced by:
/// that of an overlap, or of the nearest point.
pub(crate) const SAME: f64 = 0.992_5;

/// Triangles count as no nearer than the nearest point of a manifold if their lower bound, which
/// `f32` has rounded, is at least this fraction of its distance.
const NEAR: f64 = 0.999;

/// Sine of the angle up to which a neighbor counts as lying in the same plane.
const FLAT: f64 = 1e-4;

/// Barycentric coordinate up to which a point counts as lying on the edge.
const ON_EDGE: f64 = 1e-8;

/// Maximum number of triangles around a corner that are examined.
const FAN: usize = 32;

/// Two trees at a pose.
#[derive(Clone, Copy)]
pub(crate) struct Shape<'t> {
    pub trees: [&'t Tree; 2],
    pub b_in_a: &'t Pose,
}

impl Shape<'_> {
    /// A vertex of one side, in A's frame.
    pub fn place(&self, side: usize, vertex: u32) -> DVec3 {
        let place = self.trees[side].mesh().vertices().get(vertex as usize);
        if side == 0 {
            place
        } else {
            self.b_in_a.transform_point(place)
        }
    }

    /// The corners of a triangle (tree order) of one side, in A's frame.
    pub fn corners(&self, side: usize, triangle: u32) -> [DVec3; 3] {
        let corners = self.trees[side].corners(triangle);
        if side == 0 {
            corners
        } else {
            corners.map(|p| self.b_in_a.transform_point(p))
        }
    }
}

/// Points of contacts within the skin, reduced.
#[derive(Clone, Debug, Default)]
pub(crate) struct Skin {
    /// Points farther apart than this are no contacts. At least `reach`.
    pub width: f64,
    /// Surfaces that are sunk by less than this may count as touching.
    pub reach: f64,
    /// A point counts as farther out by this much for each unit of length that it is nearer: the
    /// size of the smaller mesh over the width of the skin. So the extremes are the points that
    /// meet first when a body turns.
    lean: f64,
    cones: Vec<Cone>,
}

/// The points whose normals are within 47 degrees of an axis.
#[derive(Clone, Debug)]
struct Cone {
    axis: DVec3,
    /// Infinitely far as long as there is no point.
    nearest: ManifoldPoint,
    /// The distance of the nearest point, plus `reach` if it is on no face: where edges lie on each
    /// other, the direction across both depends only on how B is drawn in.
    rank: f64,
    farthest: Octagon<ManifoldPoint>,
    /// Sum of the areas that faces have in common, and of their middles weighted by them.
    area: f64,
    moment: DVec3,
}

/// The cross product of two edges: the direction of the outer side.
fn face([p, q, r]: &[DVec3; 3]) -> DVec3 {
    (*q - *p).cross(*r - *p)
}

/// True if the angle between two vectors of any length is acute, and its squared cosine is more
/// than `least`.
fn is_along(u: DVec3, v: DVec3, least: f64) -> bool {
    let along = u.dot(v);
    along > 0.0 && along * along > least * u.length_squared() * v.length_squared()
}

impl Skin {
    /// `size` is that of the smaller mesh.
    pub fn begin(&mut self, width: f64, reach: f64, size: f64) {
        (self.width, self.reach) = (larger(width, reach), reach);
        self.lean = if width > 0.0 {
            larger(size / width, 1e-6)
        } else {
            1.0
        };
        self.cones.clear();
        self.reserve();
    }

    /// Makes room for all cones.
    pub fn reserve(&mut self) {
        self.cones.reserve(CONES - self.cones.len());
    }

    pub fn clear(&mut self) {
        self.cones.clear();
    }

    /// Takes two triangles (tree order) with these corners that are apart, or sunk by less than
    /// `reach`: then the distance of `found` is negative.
    pub fn take(
        &mut self,
        shape: Shape,
        pair: [u32; 2],
        corners: [&[DVec3; 3]; 2],
        found: &Closest,
    ) {
        let between = || (found.points[0] - found.points[1]).normalize_or_zero();
        let normal = if found.direction == DVec3::ZERO {
            between()
        } else {
            found.direction
        };
        let point = ManifoldPoint::new(found.points, normal, found.high);
        if normal == DVec3::ZERO {
            return;
        }
        let faces = corners.map(face);
        if is_along(faces[0], normal, FLAT * FLAT) || is_along(-faces[1], normal, FLAT * FLAT) {
            return;
        }
        // Cosines of the angle between the normal and each face, and their squares.
        let along = [-faces[0].dot(normal), faces[1].dot(normal)];
        let share = |side: usize| along[side] * along[side] / faces[side].length_squared();
        let face = usize::from(share(1) >= share(0));
        let is_least = |side: usize| {
            let way = if side == 0 { -normal } else { normal };
            let point = point.points[side];
            let feature = Feature::at(point, corners[side]);
            let falls = |place| is_along(place - point, way, FLAT * FLAT);
            !goes_on(shape, side, pair[side], feature, falls)
                && out(shape, side, pair[side], feature).dot(way) > -FLAT
        };
        if share(face) > FACE && (share(1 - face) > FACING || is_least(1 - face)) {
            // From B to A.
            let of_face = faces[face].normalize() * along[face].signum();
            let normal = if face == 0 { -of_face } else { of_face };
            self.insert(ManifoldPoint { normal, ..point }, point.distance);
            self.insert_area(corners, face, normal, Some(point.distance));
            return;
        }
        if self.gains(&point) && is_least(0) && is_least(1) {
            self.insert(point, point.distance + self.reach);
            self.insert_edges(corners, point);
        }
        self.add_area(corners);
    }

    /// True if two triangles that are at least `low` apart need no closer look. The normal of their
    /// contact is within 5 degrees of `normal`, which has any length. Either it is on the inner
    /// side of a face, and the contact no nearer than `nearest`, up to a thousandth. Or the
    /// triangles are within the points of a known cone and no nearer than its nearest, up to a
    /// thousandth, and have a normal in that cone or face each other across it.
    #[inline]
    pub fn covers(&self, corners: [&[DVec3; 3]; 2], low: f64, normal: DVec3, nearest: f64) -> bool {
        let is_within = |cone: &Cone| {
            // If a normal leans by 47 degrees, its two points are `shift` apart across the axis.
            let (bonus, shift) = (-self.lean * low, ACROSS_CONE * low);
            self.lean > ACROSS_CONE
                && low >= NEAR * cone.nearest.distance
                && !cone.farthest.may_gain(corners, bonus, shift)
        };
        let adds_nothing = |cone: &Cone| !is_along(cone.axis, normal, MAY_JOIN) || is_within(cone);
        let adds_nothing = self.cones.iter().all(adds_nothing);
        let mut cones = self.cones.iter();
        if adds_nothing && cones.any(|cone| is_along(cone.axis, normal, JOINS)) {
            return true;
        }
        let [a, b] = corners.map(face);
        let faces = |cone: &Cone| is_along(cone.nearest.normal, b, FACING) && is_within(cone);
        let is_behind = is_along(a, normal, BEHIND) || is_along(-b, normal, BEHIND);
        is_behind && low >= NEAR * nearest
            || adds_nothing && is_along(-a, b, FACING) && self.cones.iter().any(faces)
    }

    /// Takes two triangles that cross. If they face each other, inserts the parts that are apart.
    pub fn take_crossing(&mut self, corners: [&[DVec3; 3]; 2]) {
        let [a, b] = corners.map(face);
        if self.width == self.reach {
            return;
        }
        if is_along(-a, b, FACING) {
            let (face, normal) = larger_face([a, b]);
            self.insert_area(corners, face, normal, Some(0.0));
        } else {
            self.add_area(corners);
        }
    }

    /// True if two triangles face each other, so that they may have an area in common.
    pub fn has_area(corners: [&[DVec3; 3]; 2]) -> bool {
        let [a, b] = corners.map(face);
        is_along(-a, b, OPPOSITE)
    }

    /// Adds the area that two triangles have in common, if they face each other.
    pub fn add_area(&mut self, corners: [&[DVec3; 3]; 2]) {
        if Self::has_area(corners) {
            let (face, normal) = larger_face(corners.map(face));
            self.insert_area(corners, face, normal, None);
        }
    }

    /// Adds the area that both triangles have in common, seen along the normal of one of them. If
    /// they are at least `least` apart, its corners are points.
    fn insert_area(
        &mut self,
        corners: [&[DVec3; 3]; 2],
        face: usize,
        normal: DVec3,
        least: Option<f64>,
    ) {
        let away = if face == 0 { -normal } else { normal };
        let heights = [-self.reach, self.width];
        let polygon = clip(corners[1 - face], corners[face], away, heights);
        let Some(&first) = polygon.first() else {
            return;
        };
        let cone = self.cone_for(normal);
        let Cone {
            area,
            moment,
            farthest,
            ..
        } = &mut self.cones[cone];
        // Seen from the face the polygon turns to the right.
        let facing = if face == 0 { normal } else { -normal };
        for pair in polygon.windows(2) {
            let part = 0.5 * (pair[0] - first).cross(pair[1] - first);
            if is_along(part, facing, OPPOSITE) {
                let part = part.dot(facing);
                *area += part;
                *moment += part / 3.0 * (first + pair[0] + pair[1]);
            }
        }
        let gains = |least: f64| farthest.may_gain(corners, -self.lean * least, 0.0);
        if !least.is_some_and(gains) {
            return;
        }
        for point in polygon {
            let height = away.dot(point - corners[face][0]);
            let foot = point - away * height;
            let points = if face == 0 {
                [foot, point]
            } else {
                [point, foot]
            };
            self.insert(ManifoldPoint::new(points, normal, height), height);
        }
    }

    /// Inserts the ends of the common part of parallel edges that are nearest at a point.
    fn insert_edges(&mut self, corners: [&[DVec3; 3]; 2], point: ManifoldPoint) {
        let [on_a, on_b] = [0, 1].map(|side| edges_at(point.points[side], corners[side]));
        for (i, j) in (0..9)
            .map(|k| (k / 3, k % 3))
            .filter(|&(i, j)| on_a[i] && on_b[j])
        {
            let [p, q, r, s] = [
                corners[0][i],
                corners[0][(i + 1) % 3],
                corners[1][j],
                corners[1][(j + 1) % 3],
            ];
            let (u, v) = (q - p, s - r);
            let square = u.length_squared();
            let [from, to] = [r, s].map(|end| u.dot(end - p) / square);
            let ends = [from.min(to).max(0.0), from.max(to).min(1.0)];
            // A corner given twice is no edge.
            let is_parallel = square > 0.0
                && u.cross(v).length_squared() <= FLAT * FLAT * square * v.length_squared();
            if is_parallel && ends[0] < ends[1] {
                for end in ends {
                    let on_a = p + u * end;
                    let points = [on_a, on_a - point.distance * point.normal];
                    self.insert(ManifoldPoint { points, ..point }, f64::INFINITY);
                }
            }
        }
    }

    /// The index of the cone for a normal, if there is one.
    #[inline]
    fn cone(&self, normal: DVec3) -> Option<usize> {
        self.cones
            .iter()
            .position(|cone| cone.axis.dot(normal) >= CONE)
    }

    /// True if the point would be kept.
    fn gains(&self, point: &ManifoldPoint) -> bool {
        self.cone(point.normal).is_none_or(|cone| {
            let cone = &self.cones[cone];
            point.distance < cone.nearest.distance
                || cone.farthest.may_gain(
                    [&[point.points[0]; 3]; 2],
                    -self.lean * point.distance,
                    0.0,
                )
        })
    }

    /// The index of the cone for a normal, of a new one if there is none.
    fn cone_for(&mut self, axis: DVec3) -> usize {
        self.cone(axis).unwrap_or_else(|| {
            let nearest = ManifoldPoint::new([DVec3::ZERO; 2], axis, f64::INFINITY);
            self.cones.push(Cone {
                axis,
                nearest,
                rank: f64::INFINITY,
                farthest: Octagon::new(axis, nearest),
                area: 0.0,
                moment: DVec3::ZERO,
            });
            self.cones.len() - 1
        })
    }

    /// Takes a point. `rank`: see [`Cone::rank`].
    fn insert(&mut self, point: ManifoldPoint, rank: f64) {
        let at = self.cone_for(point.normal);
        let cone = &mut self.cones[at];
        if rank < cone.rank {
            (cone.nearest, cone.rank) = (point, rank);
        }
        let bonus = -self.lean * point.distance;
        cone.farthest.insert(point.points[0], bonus, point);
    }

    /// Adds the manifolds of all points so far to those of overlaps. A normal nearly equal to that
    /// of an overlap, or else to that of the nearest point, is replaced by it: two faces that face
    /// each other are not quite parallel, so the normal of a point is by chance one or the other.
    /// If exactly one overlap has this normal, the points join its manifold: they are where the
    /// same face is not sunk.
    pub fn append_to(&self, all: &mut Vec<Manifold>, before: Before) {
        let overlaps = all.len();
        let is_known = |cone: &&Cone| cone.nearest.distance < f64::INFINITY;
        for cone in self.cones.iter().filter(is_known) {
            let turned = |mut point: ManifoldPoint| {
                let normals = all[..overlaps].iter().map(|overlap| overlap.normal);
                let is_same = |normal: &DVec3| normal.dot(point.normal) > SAME;
                if let Some(normal) = normals.chain([cone.nearest.normal]).find(is_same) {
                    let [on_a, on_b] = point.points;
                    point.normal = normal;
                    point.distance = (on_a - on_b).dot(normal);
                    point.points[1] = on_a - point.distance * normal;
                }
                point
            };
            let mut points: ArrayVec<ManifoldPoint, 13> =
                cone.farthest.values().copied().map(turned).collect();
            points.push(turned(cone.nearest));
            let normal = turned(cone.nearest).normal;
            let mut same = (0..overlaps).filter(|&i| all[i].normal.dot(normal) > SAME);
            let foot = same.next().filter(|_| same.next().is_none());
            let mut manifold = Manifold::of(normal, &points, 1.0 / self.lean, before);
            let area = cone.area;
            if area > 0.0 {
                (manifold.area, manifold.centroid) = (area, cone.moment / area);
            }
            let Some(foot) = foot else {
                all.push(manifold);
                continue;
            };
            let sunk = &all[foot];
            points.extend(sunk.points.iter().copied());
            let whole = sunk.area + area;
            let share = if whole > 0.0 { area / whole } else { 0.0 };
            all[foot] = Manifold {
                area: whole,
                centroid: sunk.centroid.lerp(manifold.centroid, share),
                is_overlap: sunk.is_overlap,
                is_whole: sunk.is_whole,
                ..Manifold::of(normal, &points, 1.0 / self.lean, before)
            };
        }
    }
}

/// Of two faces the larger one, and the normal of a contact along it.
fn larger_face([a, b]: [DVec3; 2]) -> (usize, DVec3) {
    if b.length_squared() >= a.length_squared() {
        (1, b.normalize_or_zero())
    } else {
        (0, -a.normalize_or_zero())
    }
}

/// The edges, each from its corner to the next, on which a point of a triangle lies.
fn edges_at(point: DVec3, corners: &[DVec3; 3]) -> [bool; 3] {
    let normal = face(corners);
    let square = normal.length_squared();
    [0, 1, 2].map(|i| {
        let edge = corners[(i + 1) % 3] - corners[i];
        normal.dot(edge.cross(point - corners[i])).abs() <= ON_EDGE * square
    })
}

/// The corners of the part of a triangle over a face: in the prism along `away`, which is a unit
/// normal of the face, and between two heights above it.
fn clip(
    triangle: &[DVec3; 3],
    face: &[DVec3; 3],
    away: DVec3,
    [least, most]: [f64; 2],
) -> ArrayVec<DVec3, 8> {
    let mut polygon: ArrayVec<DVec3, 8> = triangle.iter().copied().collect();
    let turn = (face[1] - face[0]).cross(face[2] - face[0]);
    for i in 0..3 {
        let out = (face[(i + 1) % 3] - face[i]).cross(turn);
        cut(&mut polygon, |p| out.dot(p - face[i]));
    }
    cut(&mut polygon, |p| least - away.dot(p - face[0]));
    cut(&mut polygon, |p| away.dot(p - face[0]) - most);
    polygon
}

/// Keeps the part of a convex polygon where `side` is not positive.
fn cut(polygon: &mut ArrayVec<DVec3, 8>, side: impl Fn(DVec3) -> f64) {
    let sides: ArrayVec<f64, 8> = polygon.iter().map(|&p| side(p)).collect();
    if sides.iter().all(|&side| side <= 0.0) {
        return;
    }
    let given = core::mem::take(polygon);
    for (i, (&p, &x)) in given.iter().zip(&sides).enumerate() {
        let next = (i + 1) % given.len();
        let (q, y) = (given[next], sides[next]);
        // A convex polygon has room; rounding may make it less than convex.
        if x <= 0.0 {
            let _ = polygon.try_push(p);
        }
        if x < 0.0 && y > 0.0 || x > 0.0 && y < 0.0 {
            let _ = polygon.try_push(p + (q - p) * (x / (x - y)));
        }
    }
}

/// A part of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Feature {
    Face,
    /// From this corner to the next.
    Edge(usize),
    Corner(usize),
}

impl Feature {
    /// The feature on which a point of a triangle lies.
    fn at(point: DVec3, corners: &[DVec3; 3]) -> Self {
        // The edge from corner i is opposite to corner i + 2.
        let is_on = edges_at(point, corners);
        let corner = (0..3).find(|&i| is_on[i] && is_on[(i + 2) % 3]);
        let edge = || (0..3).find(|&i| is_on[i]);
        corner.map_or_else(|| edge().map_or(Self::Face, Self::Edge), Self::Corner)
    }

    /// The feature on which the closest point of a lane lies, and that point; of a face no point.
    fn of(places: &Places, lane: usize, corners: &[DVec3; 3]) -> (Self, Option<DVec3>) {
        let [from, to] = match places.edge[lane] {
            0.0 => [0, 1],
            1.0 => [0, 2],
            2.0 => [1, 2],
            _ => return (Self::Face, None),
        };
        let feature = match places.along[lane] {
            0.0 => Self::Corner(from),
            1.0 => Self::Corner(to),
            _ => Self::Edge(if from + 1 == to { from } else { to }),
        };
        let point = corners[from].lerp(corners[to], f64::from(places.along[lane]));
        (feature, Some(point))
    }
}

/// The foot of the perpendicular from a point to a face, if it is in the face.
fn foot(point: DVec3, corners: &[DVec3; 3]) -> Option<DVec3> {
    let normal = face(corners);
    let foot = point - normal * (normal.dot(point - corners[0]) / normal.length_squared());
    let is_inside = |i: usize| {
        let edge = corners[(i + 1) % 3] - corners[i];
        edge.cross(foot - corners[i]).dot(normal) > 0.0
    };
    (0..3).all(is_inside).then_some(foot)
}

/// True if a neighbor of one of two triangles is certainly closer to the other one. The triangles
/// are at least `low` apart, nearest at about these places, and the normal of their contact is
/// within 5 degrees of `normal`, which has any length. On a straight way from such a place into the
/// neighbor, the distance falls below `low`. False if the triangles may have an area in common.
pub(crate) fn falls_beside(
    shape: Shape,
    pair: [u32; 2],
    corners: [&[DVec3; 3]; 2],
    (places, lane): (&[Places; 2], usize),
    low: f64,
    normal: DVec3,
) -> bool {
    let is_steep = corners.map(|corners| {
        let face = face(corners);
        !is_along(face, normal, STEEP) && !is_along(-face, normal, STEEP)
    });
    if is_steep == [false; 2] {
        return false;
    }
    let [(on_a, a), (on_b, b)] = [0, 1].map(|k| Feature::of(&places[k], lane, corners[k]));
    let ends = match (a, b) {
        (Some(a), Some(b)) => Some([a, b]),
        (Some(a), None) => foot(a, corners[1]).map(|b| [a, b]),
        (None, Some(b)) => foot(b, corners[0]).map(|a| [a, b]),
        (None, None) => None,
    };
    let falls = |ends: [DVec3; 2], side: usize| {
        let between = ends[side] - ends[1 - side];
        let rounding = 16.0 * f64::EPSILON * ends[0].abs().max(ends[1].abs()).max_element();
        goes_on(shape, side, pair[side], [on_a, on_b][side], |place| {
            let step = place - ends[side];
            let fall = -step.dot(between) / step.length_squared();
            fall > 0.0 && (between + step * fall.min(1.0)).length() + rounding < low
        })
    };
    ends.is_some_and(|ends| (0..2).any(|side| is_steep[side] && falls(ends, side)))
}

/// True if a neighbor that shares this feature of a triangle (tree order) has a vertex opposite to
/// the feature whose place satisfies `is_it`.
fn goes_on(
    shape: Shape,
    side: usize,
    triangle: u32,
    feature: Feature,
    is_it: impl Fn(DVec3) -> bool,
) -> bool {
    let tree = shape.trees[side];
    let vertices = tree.vertices_of(triangle);
    let is_it = |vertex: u32| is_it(shape.place(side, vertex));
    match feature {
        Feature::Face => false,
        Feature::Edge(edge) => tree.across(triangle, edge).is_some_and(|next| {
            is_it(tree.vertex_across(triangle, vertices[(edge + 2) % 3], next))
        }),
        Feature::Corner(corner) => {
            let center = vertices[corner];
            around(tree, triangle, center, |next| {
                let vertices = tree.vertices_of(next);
                vertices.iter().any(|&v| v != center && is_it(v))
            })
        }
    }
}

/// A vector to the outer side of the surface at a feature of a triangle. Take a direction along
/// which the surface nowhere rises from the feature. It leads out if its component along this
/// vector is positive, and into the body if that is negative.
fn out(shape: Shape, side: usize, triangle: u32, feature: Feature) -> DVec3 {
    let tree = shape.trees[side];
    let normal = |triangle| face(&shape.corners(side, triangle)).normalize_or_zero();
    match feature {
        Feature::Face => normal(triangle),
        Feature::Edge(edge) => {
            let next = tree.across(triangle, edge);
            normal(triangle) + next.map_or(DVec3::ZERO, normal)
        }
        Feature::Corner(corner) => {
            let center = tree.vertices_of(triangle)[corner];
            let mut sum = DVec3::ZERO;
            let mut add = |triangle| {
                if let Some(at) = tree.vertices_of(triangle).iter().position(|&v| v == center) {
                    let corners = shape.corners(side, triangle);
                    let [p, q] = [1, 2].map(|k| corners[(at + k) % 3] - corners[at]);
                    sum += p.normalize_or_zero().cross(q.normalize_or_zero());
                }
                false
            };
            add(triangle);
            around(tree, triangle, center, add);
            sum
        }
    }
}

/// True if `is_it` holds for a triangle (tree order) around `vertex`, in order. The triangle
/// `first` is left out.
pub(crate) fn around(
    tree: &Tree,
    first: u32,
    vertex: u32,
    mut is_it: impl FnMut(u32) -> bool,
) -> bool {
    let start = tree.vertices_of(first);
    let Some(corner) = start.iter().position(|&v| v == vertex) else {
        return false;
    };
    for edge in [corner, (corner + 2) % 3] {
        let (mut at, mut edge) = (first, edge);
        for _ in 0..FAN {
            let Some(next) = tree.across(at, edge) else {
                break;
            };
            if next == first {
                return false;
            }
            if is_it(next) {
                return true;
            }
            let vertices = tree.vertices_of(next);
            let Some(corner) = vertices.iter().position(|&v| v == vertex) else {
                break;
            };
            let ways = [corner, (corner + 2) % 3];
            edge = if tree.across(next, ways[0]) == Some(at) {
                ways[1]
            } else {
                ways[0]
            };
            at = next;
        }
    }
    false
}
