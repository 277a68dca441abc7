//! Gaps of boxes: lower bounds of distances, eight at a time.
//!
//! Two boxes with gaps `x, y, z` along the axes of one of them are at least `sqrt(x^2 + y^2 + z^2)`
//! apart, where negative gaps count as 0. The axes of the other give a second bound. The third is
//! their gap along the direction between the closest triangles found so far. All is in A's units,
//! with the views and margins of the overlap test. The proof is in `docs/numerics.md`, "Distances
//! of boxes".

use crate::engine::boxes::close_boxes;
use crate::engine::boxes::relative_pose::{RelativePose, View, Views};
use crate::engine::boxes::{Boxes, Extents, Facing, Slabs, splat};
use crate::engine::expand::{Keys, Measure};
use crate::model::cost::{WORK_PER_EXPANSION, WORK_PER_LEAVES};
use crate::tree::{Node, WIDTH, xyz};
use glam::DVec3;
use punctual_geom::lanes::{Column, F8, Lanes, V8, add, cross, dot, per_axis, scaled};
use punctual_geom::larger;
use punctual_geom::triangle::batch::{Placement, Rows, Transposed, UNDERFLOW, rotate};
use wide::f32x4;

/// Selects boxes closer than `cut`. Keys are squared lower bounds of distances, or minus the
/// overlap depth.
///
/// With `DIRECTED` false no direction is known, and nothing is compared along one.
pub(crate) struct Gaps<'r, const DIRECTED: bool = true> {
    /// Pairs at this squared distance or beyond are of no interest.
    pub cut: f32,
    /// Least gap, margin included, of a pair in doubt: it may be of interest only by its margin.
    pub doubt: f32,
    /// Factor for the square of a gap. It covers the rounding and axes that are not exactly
    /// orthonormal.
    pub shrink: f32,
    /// Factor of half extents: 1 for bounds, less for guesses.
    pub swell: f32,
    /// The key of the current pair; its children's keys are not less. Negative infinity if its
    /// boxes overlap.
    pub least: f32,
    pub direction: Direction,
    placement: &'r Placement,
    /// The direction in the orientations of the current nodes.
    in_a: f32x4,
    in_b: f32x4,
    margin: f32,
    in_doubt: bool,
}

/// Squared length of the gaps of boxes from their depths along three axes, and the least depth.
#[inline(always)]
fn measure<L: Lanes>(lanes: L, [x, y, z]: V8<L>) -> [F8<L>; 2] {
    let zero = F8::splat(lanes, 0.0);
    let (u, v, w) = (x.min(zero), y.min(zero), z.min(zero));
    [u * u + v * v + w * w, x.min(y).min(z)]
}

/// Squared length of the gaps of a single pair of boxes, and the largest gap. `seen` is mapped to
/// the axes of `other`.
#[inline(always)]
fn measure_one(seen: (f32x4, f32x4), other: (f32x4, f32x4), view: &View) -> [f32; 2] {
    let gaps = (view.point(seen.0) - other.0).abs() - (view.half(seen.1) + other.1);
    let [[x, y, z], [u, v, w]] = [gaps, gaps.fast_max(f32x4::ZERO)].map(xyz);
    [u * u + v * v + w * w, larger(larger(x, y), z)]
}

/// From this number of triangle pairs of two leaves on, comparing the leaves along their normals
/// takes less time than the tests that it saves, about a third.
const MANY: u32 = 8;

/// Eight triangles: their first corners, and two edges from there.
type Triangles<L> = [V8<L>; 3];

/// Lower and upper ends of triangles along directions, which need not be unit vectors.
#[inline(always)]
fn ends<L: Lanes>(lanes: L, [first, x, y]: Triangles<L>, direction: V8<L>) -> [F8<L>; 2] {
    let zero = F8::splat(lanes, 0.0);
    let (at, x, y) = (dot(direction, first), dot(direction, x), dot(direction, y));
    [at + zero.min(x).min(y), at + zero.max(x).max(y)]
}

/// Normals of triangles, no longer than 1.
#[inline(always)]
fn normals<L: Lanes>(lanes: L, [_, x, y]: Triangles<L>) -> V8<L> {
    let normal = cross(x, y);
    let length = dot(normal, normal).max(F8::splat(lanes, UNDERFLOW)).sqrt();
    scaled(normal, F8::splat(lanes, SHORTER as f32) / length)
}

/// Triangles of B in A's unit coordinates.
#[inline(always)]
fn placed<L: Lanes>(lanes: L, [first, x, y]: Triangles<L>, placement: &Placement) -> Triangles<L> {
    let at = per_axis!(k => F8::splat(lanes, placement.translation[k] as f32));
    let rotation = &placement.rotation;
    let first = rotate(lanes, rotation, first);
    [
        add(first, at),
        rotate(lanes, rotation, x),
        rotate(lanes, rotation, y),
    ]
}

#[inline(always)]
fn dot_one(a: f32x4, b: f32x4) -> f32 {
    let [x, y, z] = xyz(a * b);
    x + y + z
}

/// A direction from A to B.
#[derive(Clone, Copy)]
pub(crate) struct Direction {
    /// In A's unit coordinates, with length at most 1; 0 if none is known.
    unit: f32x4,
}

/// Factor of unit vectors, so that rounding makes none longer than 1.
const SHORTER: f64 = 1.0 - 1e-5;

impl Direction {
    pub fn new(unit: DVec3) -> Self {
        let [x, y, z] = (unit * SHORTER).as_vec3().to_array();
        let unit = f32x4::new([x, y, z, 0.0]);
        Self { unit }
    }
}

impl<'r, const DIRECTED: bool> Gaps<'r, DIRECTED> {
    pub fn new(cut: f32, doubt: f32, relative: &'r RelativePose, direction: Direction) -> Self {
        let (swell, least, zero) = (1.0, f32::NEG_INFINITY, f32x4::ZERO);
        Self {
            cut,
            doubt,
            shrink: relative.shrink,
            swell,
            least,
            direction,
            placement: &relative.triangles,
            in_a: zero,
            in_b: zero,
            margin: 0.0,
            in_doubt: false,
        }
    }

    /// Ends of boxes along the direction, whose sum is a depth. A's are the upper ends, from its
    /// own axes. B's are the negated lower ends, from the centres as seen from A and the half
    /// extents along its own axes.
    #[inline(always)]
    fn along<L: Lanes>(&self, lanes: L, is_a: bool, boxes: &Boxes<L>, seen: &Boxes<L>) -> F8<L> {
        if !DIRECTED {
            return F8::splat(lanes, 0.0);
        }
        let in_a = splat(lanes, self.in_a);
        if is_a {
            dot(in_a, boxes.center) + dot(splat(lanes, self.in_a.abs()), boxes.half)
        } else {
            let half = dot(splat(lanes, self.in_b.abs()), boxes.half);
            half - dot(in_a, seen.center) + F8::splat(lanes, self.margin)
        }
    }

    /// [`Gaps::along`] for the own box of a node.
    #[inline(always)]
    fn along_one(&self, is_a: bool, (center, half): (f32x4, f32x4), view: &View) -> f32 {
        if !DIRECTED {
            0.0
        } else if is_a {
            dot_one(self.in_a, center) + dot_one(self.in_a.abs(), half)
        } else {
            dot_one(self.in_b.abs(), half) - dot_one(self.in_a, view.point(center)) + self.margin
        }
    }

    /// Raises the key of the current pair to a proven gap. True if the key reaches the cut.
    #[cold]
    fn reaches_cut(&mut self, gap: f64) -> bool {
        if gap > 0.0 {
            self.least = larger(
                self.least,
                (gap * gap * (1.0 - f64::from(f32::EPSILON))) as f32,
            );
        }
        self.least >= self.cut
    }
}

impl<const DIRECTED: bool> Measure for Gaps<'_, DIRECTED> {
    const IS_LARGE: bool = true;
    const WORK: [u64; 2] = [WORK_PER_EXPANSION, 2];
    const REFINED: Option<(u32, u64)> = if DIRECTED {
        Some((MANY, WORK_PER_LEAVES))
    } else {
        None
    };

    type Along<L: Lanes> = V8<L>;

    #[inline(always)]
    fn own(
        &mut self,
        [node_a, node_b]: [&Node; 2],
        views: &Views,
        relative: &RelativePose,
    ) -> bool {
        if self.swell < 1.0 {
            return true;
        }
        if DIRECTED {
            (self.in_a, self.in_b) = views.direction(node_a, self.direction.unit);
        }
        self.margin = 2.0 * views.of_b.margin.as_array()[0];
        let scale = f32x4::splat(relative.scale);
        let a = (node_a.own_center, node_a.own_half);
        let b = (node_b.own_center * scale, node_b.own_half * scale);
        let ([square, gap], [other_square, other_gap]) = (
            measure_one(b, a, &views.of_b),
            measure_one(a, b, &views.of_a),
        );
        let along = -(self.along_one(true, a, &views.of_a) + self.along_one(false, b, &views.of_b));
        let ahead = larger(along, 0.0);
        let key = larger(larger(square, other_square), ahead * ahead) * self.shrink;
        let gap = larger(larger(gap, other_gap), along);
        if gap > 0.0 {
            self.least = larger(self.least, key);
        }
        // The gap along the direction contains the margin twice.
        self.in_doubt = if DIRECTED {
            larger(gap, along + 0.5 * self.margin) > self.doubt
        } else {
            gap > self.doubt
        };
        self.least < self.cut
    }

    #[inline(always)]
    fn is_in_doubt(&self) -> bool {
        self.in_doubt
    }

    #[inline(always)]
    fn is_parted(&mut self, [a, b]: [&Node; 2], views: &Views, relative: &RelativePose) -> bool {
        self.reaches_cut(close_boxes::gap(a, b, views, relative))
            || DIRECTED
                && self.reaches_cut(close_boxes::gap_along(a, b, relative, self.direction.unit))
    }

    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: &Facing, k: usize) -> Extents<L> {
        let boxes = facing.children(lanes, k).swollen(lanes, self.swell);
        let seen = boxes.seen(lanes, facing.views[k]);
        Extents {
            own: boxes.slabs(),
            seen: seen.slabs(),
            ahead: self.along(lanes, facing.is_of_a(k), &boxes, &seen),
        }
    }

    #[inline(always)]
    fn own_box<L: Lanes>(&self, lanes: L, facing: &Facing, k: usize) -> Extents<L> {
        let ((center, half), view) = (facing.own(k), facing.views[k]);
        let half = half * f32x4::splat(self.swell);
        Extents {
            own: Slabs::of_box(lanes, center, half),
            seen: Slabs::of_box(lanes, view.point(center), view.half(half)),
            ahead: F8::splat(
                lanes,
                self.along_one(facing.is_of_a(k), (center, half), view),
            ),
        }
    }

    #[inline(always)]
    fn compare<L: Lanes>(&self, _lanes: L, other: &Slabs<L>, opened: &Slabs<L>) -> V8<L> {
        other.depths(opened)
    }

    /// From the depths along the axes of both sides and along the direction.
    #[inline(always)]
    fn key<L: Lanes>(&self, lanes: L, in_x: V8<L>, in_y: V8<L>, along: F8<L>) -> F8<L> {
        let zero = F8::splat(lanes, 0.0);
        let ([square, depth], [other_square, other_depth]) =
            (measure(lanes, in_x), measure(lanes, in_y));
        let (mut square, mut depth) = (square.max(other_square), depth.min(other_depth));
        if DIRECTED {
            let ahead = along.min(zero);
            (square, depth) = (square.max(ahead * ahead), depth.min(along));
        }
        let depth = depth.max(zero);
        (square * F8::splat(lanes, self.shrink) - depth).max(F8::splat(lanes, self.least))
    }

    #[inline(always)]
    fn hits<L: Lanes>(&self, lanes: L, keys: F8<L>) -> u32 {
        keys.less(F8::splat(lanes, self.cut)).mask()
    }

    /// Compares the triangles' own ends along the direction and along their normals.
    #[inline(always)]
    fn refine<L: Lanes>(
        &self,
        lanes: L,
        mut hits: u64,
        [a, b]: [[&Rows; WIDTH]; 2],
        keys: &Keys,
    ) -> u64 {
        let (a, b) = (Transposed::new(lanes, a), Transposed::new(lanes, b));
        let (a, b) = ([a.first, a.edge1, a.edge2], [b.first, b.edge1, b.edge2]);
        let b = placed(lanes, b, self.placement);
        let unit = splat(lanes, self.direction.unit);
        let ([_, a_along], [b_along, _]) = (ends(lanes, a, unit), ends(lanes, b, unit));
        let (normals_a, normals_b) = (normals(lanes, a), normals(lanes, b));
        let (own_a, [b_low, b_high]) = (ends(lanes, a, normals_a), ends(lanes, b, normals_b));
        // Takes the triangles of A one by one, each in all lanes.
        let (a_along, a_low, a_high) = (a_along.store(), own_a[0].store(), own_a[1].store());
        let normals_a = per_axis!(k => normals_a[k].store());
        let a = per_axis!(corner => per_axis!(k => a[corner][k].store()));
        for i in 0..WIDTH {
            if (hits >> (WIDTH * i)) & 0xff == 0 {
                continue;
            }
            let normal = per_axis!(k => F8::splat(lanes, normals_a[k][i]));
            let [low, high] = ends(lanes, b, normal);
            let of_a = (low - F8::splat(lanes, a_high[i])).max(F8::splat(lanes, a_low[i]) - high);
            let one = per_axis!(corner => per_axis!(k => F8::splat(lanes, a[corner][k][i])));
            let [low, high] = ends(lanes, one, normals_b);
            let of_b = (low - b_high).max(b_low - high);
            let gap = (b_along - F8::splat(lanes, a_along[i])).max(of_a).max(of_b);
            let ahead = (gap - F8::splat(lanes, self.margin)).max(F8::splat(lanes, 0.0));
            let near = F8::load(lanes, &keys[i]).max(ahead * ahead * F8::splat(lanes, self.shrink));
            hits &= !(u64::from(!self.hits(lanes, near) & 0xff) << (WIDTH * i));
        }
        hits
    }
}
