//! Gaps of boxes: lower bounds of distances, eight at a time.
//!
//! Two boxes with gaps `x, y, z` along the axes of one of them are at least `sqrt(x^2 + y^2 + z^2)`
//! apart, where negative gaps count as 0. The axes of the other give a second bound. The third is
//! their gap along the direction between the closest triangles found so far. All is in A's units,
//! with the views and margins of the overlap test. The proof is in `docs/numerics.md`, "Distances
//! of boxes".

use super::boxes::{BoxTest, Boxes, Facing, Keys, Triangles, ends, splat};
use super::close_boxes;
use super::views::{Relation, View, Views};
use crate::tree::{Node, WIDTH, xyz};
use glam::DVec3;
use punctual_geom::lanes::{Column, F8, Kernel, Lanes, V8, dot, per_axis};
use punctual_geom::larger;
use punctual_geom::triangle::batch::Rows;
use wide::f32x4;

/// Selects boxes closer than `cut`. Keys are squared lower bounds of distances, or minus the
/// overlap depth.
pub(super) struct Gaps {
    /// Pairs at this squared distance or beyond are of no interest.
    pub cut: f32,
    /// Gap, with its margin: above it, a pair of interest may be so only because of its margin.
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
    /// The direction in the orientations of the current nodes.
    in_a: f32x4,
    in_b: f32x4,
    margin: f32,
    in_doubt: bool,
}

/// Squared length of the gaps along three axes, and the largest gap.
#[inline(always)]
fn measure<L: Lanes>(lanes: L, [x, y, z]: V8<L>) -> [F8<L>; 2] {
    let zero = F8::splat(lanes, 0.0);
    let (u, v, w) = (x.max(zero), y.max(zero), z.max(zero));
    [u * u + v * v + w * w, x.max(y).max(z)]
}

/// [`measure`] for a single pair of boxes; `seen` is mapped to the axes of `other`.
#[inline(always)]
fn measure_one(seen: (f32x4, f32x4), other: (f32x4, f32x4), view: &View) -> [f32; 2] {
    let gaps = (view.point(seen.0) - other.0).abs() - (view.half(seen.1) + other.1);
    let [[x, y, z], [u, v, w]] = [gaps, gaps.fast_max(f32x4::ZERO)].map(xyz);
    [u * u + v * v + w * w, larger(larger(x, y), z)]
}

/// Lower ends of triangles along a direction, which need not be a unit vector.
#[inline(always)]
fn start<L: Lanes>(lanes: L, [a, b, c, d, e, f, g, h]: [&Rows; WIDTH], direction: f32x4) -> F8<L> {
    let [[x, y, z, ex], [ey, ez, fx, fy], [fz, ..]] = per_axis!(i => F8::columns(lanes, [&a[i], &b[i], &c[i], &d[i], &e[i], &f[i], &g[i], &h[i]]));
    let direction = splat(lanes, direction);
    let edges = dot(direction, [ex, ey, ez]).min(dot(direction, [fx, fy, fz]));
    dot(direction, [x, y, z]) + edges.min(F8::splat(lanes, 0.0))
}

#[inline(always)]
fn dot_one(a: f32x4, b: f32x4) -> f32 {
    let [x, y, z] = xyz(a * b);
    x + y + z
}

/// A direction from A to B.
#[derive(Clone, Copy)]
pub(super) struct Direction {
    /// In A's unit coordinates, with length at most 1; 0 if none is known.
    unit: f32x4,
    /// In B's unit coordinates, for points of B; and the offset of B's position, added to their
    /// projections.
    of_b: f32x4,
    offset: f32,
}

impl Direction {
    pub fn new(unit: DVec3, relation: &Relation) -> Self {
        let [x, y, z] = (unit * (1.0 - 1e-5)).as_vec3().to_array();
        let unit = f32x4::new([x, y, z, 0.0]);
        let (of_b, offset) = relation.of_b(unit);
        Self { unit, of_b, offset }
    }
}

impl Gaps {
    pub fn new(cut: f32, doubt: f32, shrink: f32, direction: Direction) -> Self {
        let (swell, least, zero) = (1.0, f32::NEG_INFINITY, f32x4::ZERO);
        Self {
            cut,
            doubt,
            shrink,
            swell,
            least,
            direction,
            in_a: zero,
            in_b: zero,
            margin: 0.0,
            in_doubt: false,
        }
    }

    /// Negated upper ends of boxes of A along the direction, from their own axes.
    #[inline(always)]
    fn ends_of_a<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>) -> F8<L> {
        -(dot(splat(lanes, self.in_a), boxes.center)
            + dot(splat(lanes, self.in_a.abs()), boxes.half))
    }

    /// Lower ends of boxes of B along the direction: centres as seen from A, half extents along
    /// their own axes.
    #[inline(always)]
    fn starts_of_b<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>, seen: &Boxes<L>) -> F8<L> {
        let half = dot(splat(lanes, self.in_b.abs()), boxes.half);
        dot(splat(lanes, self.in_a), seen.center) - half - F8::splat(lanes, self.margin)
    }

    #[inline(always)]
    fn along<L: Lanes>(&self, lanes: L, is_a: bool, boxes: &Boxes<L>, seen: &Boxes<L>) -> F8<L> {
        if is_a {
            self.ends_of_a(lanes, boxes)
        } else {
            self.starts_of_b(lanes, boxes, seen)
        }
    }

    /// [`Gaps::along`] for the own box of a node.
    #[inline(always)]
    fn along_one(&self, is_a: bool, center: f32x4, half: f32x4, view: &View) -> f32 {
        if is_a {
            -(dot_one(self.in_a, center) + dot_one(self.in_a.abs(), half))
        } else {
            dot_one(self.in_a, view.point(center)) - dot_one(self.in_b.abs(), half) - self.margin
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

    /// The keys of boxes from their gaps along the axes of both sides and along the direction.
    #[inline(always)]
    fn keys<L: Lanes>(&self, lanes: L, in_x: V8<L>, in_y: V8<L>, along: F8<L>) -> F8<L> {
        let zero = F8::splat(lanes, 0.0);
        let ([square, gap], [other_square, other_gap]) =
            (measure(lanes, in_x), measure(lanes, in_y));
        let ahead = along.max(zero);
        let (square, gap) = (
            square.max(other_square).max(ahead * ahead),
            gap.max(other_gap).max(along),
        );
        (square * F8::splat(lanes, self.shrink) + gap.min(zero)).max(F8::splat(lanes, self.least))
    }

    /// Mask of the lanes with keys below the cut.
    #[inline(always)]
    fn near<L: Lanes>(&self, lanes: L, keys: F8<L>) -> u32 {
        keys.less(F8::splat(lanes, self.cut)).mask()
    }

    #[inline(always)]
    fn boxes<L: Lanes>(&self, lanes: L, node: &Node, scale: f32) -> Boxes<L> {
        Boxes::children(lanes, node, scale).swollen(lanes, self.swell)
    }
}

impl BoxTest for Gaps {
    const IS_OVERLAP: bool = false;

    #[inline(always)]
    fn own<L: Lanes>(&mut self, _lanes: L, a: &Node, b: &Node, views: &Views, scale: f32) -> bool {
        if self.swell < 1.0 {
            return true;
        }
        let (in_a, in_b) = views.direction(a, self.direction.unit);
        (self.in_a, self.in_b, self.margin) = (in_a, in_b, 2.0 * views.of_b.margin.as_array()[0]);
        let scale = f32x4::splat(scale);
        let a = (a.own_center, a.own_half);
        let b = (b.own_center * scale, b.own_half * scale);
        let ([square, gap], [other_square, other_gap]) = (
            measure_one(b, a, &views.of_b),
            measure_one(a, b, &views.of_a),
        );
        let along = self.along_one(true, a.0, a.1, &views.of_a)
            + self.along_one(false, b.0, b.1, &views.of_b);
        let ahead = larger(along, 0.0);
        let key = larger(larger(square, other_square), ahead * ahead) * self.shrink;
        let gap = larger(larger(gap, other_gap), along);
        if gap > 0.0 {
            self.least = larger(self.least, key);
        }
        // The gap along the direction contains the margin twice.
        self.in_doubt = larger(gap, along + 0.5 * self.margin) > self.doubt;
        self.least < self.cut
    }

    #[inline(always)]
    fn is_in_doubt(&self) -> bool {
        self.in_doubt
    }

    #[inline(always)]
    fn is_parted(&mut self, a: &Node, b: &Node, views: &Views, relation: &Relation) -> bool {
        self.reaches_cut(close_boxes::gap(a, b, views, relation))
            || self.reaches_cut(close_boxes::gap_along(a, b, relation, self.direction.unit))
    }

    #[inline(always)]
    fn both<L: Lanes>(&self, lanes: L, facing: Facing, alive: [u32; 2], keys: &mut Keys) -> u64 {
        lanes.run(Both {
            gaps: self,
            facing,
            alive,
            keys,
        })
    }

    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, facing: Facing, keys: &mut Keys) -> u32 {
        let Facing {
            nodes: [opened, _],
            views: [of_opened, of_other],
            scales,
            is_a,
        } = facing;
        let children = self.boxes(lanes, opened, scales[0]);
        let (center, half) = facing.other();
        let half = half * f32x4::splat(self.swell);
        let (low, high) = ends(of_other.point(center), of_other.half(half));
        let in_opened = children.slabs().gaps(lanes, low, high);
        let (low, high) = ends(center, half);
        let seen = children.seen(lanes, of_opened);
        let in_other = seen.slabs().gaps(lanes, low, high);
        let along = self.along(lanes, is_a, &children, &seen);
        let along = along + F8::splat(lanes, self.along_one(!is_a, center, half, of_other));
        let near = self.keys(lanes, in_opened, in_other, along);
        keys[0] = near.store();
        self.near(lanes, near) & opened.valid()
    }

    /// Tests the boxes of the triangles, and, if any pair is left, their own ends along the
    /// direction.
    #[inline(always)]
    fn clusters<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: [u32; 2],
        rows: impl FnOnce() -> [[&'t Rows; WIDTH]; 2],
        keys: &mut Keys,
    ) -> u64 {
        let mut hits = self.both(lanes, facing, alive, keys);
        if hits == 0 || self.swell < 1.0 {
            return hits;
        }
        let [of_a, of_b] = rows();
        let Direction {
            unit,
            of_b: in_b,
            offset,
        } = self.direction;
        let a = start(lanes, of_a, f32x4::ZERO - unit).store();
        let b = start(lanes, of_b, in_b) + F8::splat(lanes, offset - self.margin);
        for i in 0..WIDTH {
            if (hits >> (WIDTH * i)) & 0xff == 0 {
                continue;
            }
            let ahead = (b + F8::splat(lanes, a[i])).max(F8::splat(lanes, 0.0));
            let near = F8::load(lanes, &keys[i]).max(ahead * ahead * F8::splat(lanes, self.shrink));
            hits &= !(u64::from(!self.near(lanes, near) & 0xff) << (WIDTH * i));
        }
        hits
    }

    /// Tests the boxes of the triangles.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &self,
        lanes: L,
        facing: Facing,
        alive: u32,
        _triangles: impl FnOnce() -> Triangles<'t>,
        keys: &mut Keys,
    ) -> u64 {
        self.both(lanes, facing, [alive, facing.nodes[1].valid()], keys)
    }
}

/// The active children of two nodes. Compiled once, because it is large and called from several
/// places.
struct Both<'k> {
    gaps: &'k Gaps,
    facing: Facing<'k>,
    alive: [u32; 2],
    keys: &'k mut Keys,
}

impl Kernel for Both<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> u64 {
        let Self {
            gaps,
            facing,
            alive: [alive_x, alive_y],
            keys,
        } = self;
        let Facing {
            nodes: [x, y],
            views: [of_x, of_y],
            scales,
            is_a,
        } = facing;
        let y_rows = gaps.boxes(lanes, y, scales[1]);
        let seen = y_rows.seen(lanes, of_y);
        let (y_along, y_in_x) = (gaps.along(lanes, !is_a, &y_rows, &seen), seen.slabs());
        let scale = f32x4::splat(scales[0]);
        let (center, half) = (x.own_center * scale, x.own_half * scale);
        let (low, high) = ends(center, half);
        let apart = y_in_x.gaps(lanes, low, high);
        let along = y_along + F8::splat(lanes, gaps.along_one(is_a, center, half, of_x));
        let alive_y = alive_y & gaps.near(lanes, gaps.keys(lanes, apart, apart, along));
        if alive_y == 0 {
            return 0;
        }
        let x_rows = gaps.boxes(lanes, x, scales[0]);
        let seen = x_rows.seen(lanes, of_x);
        let (x_along, x_in_y) = (gaps.along(lanes, is_a, &x_rows, &seen), seen.slabs());
        let (center, half) = facing.other();
        let (low, high) = ends(center, half);
        let apart = x_in_y.gaps(lanes, low, high);
        let along = x_along + F8::splat(lanes, gaps.along_one(!is_a, center, half, of_y));
        let mut alive_x = alive_x & gaps.near(lanes, gaps.keys(lanes, apart, apart, along));
        let (x_rows, x_in_y, x_along) = (x_rows.slabs().store(), x_in_y.store(), x_along.store());
        let y_rows = y_rows.slabs();
        let mut pairs = 0;
        while alive_x != 0 {
            let i = alive_x.trailing_zeros() as usize;
            alive_x &= alive_x - 1;
            let in_x = y_in_x.gaps_at(lanes, &x_rows, i);
            let in_y = y_rows.gaps_at(lanes, &x_in_y, i);
            let near = gaps.keys(lanes, in_x, in_y, y_along + F8::splat(lanes, x_along[i]));
            keys[i] = near.store();
            pairs |= u64::from(gaps.near(lanes, near) & alive_y) << (WIDTH * i);
        }
        pairs
    }
}
