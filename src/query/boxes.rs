//! The box tests: eight boxes at a time, on the six face axes.
//!
//! A box with centre `c` and half extents `h` lies, seen from the orientation of a node of the other side ([`View`]), within
//! `M c + t ± (|M| h + m)`; `m` covers every rounding and is proven in `docs/numerics.md`. So no overlap is ever lost, and
//! a box kept in vain only costs time. The nine edge axes would cost more than they save. All is in A's units.

use super::views::{View, Views};
use crate::math::lanes::{F8, Lanes, V8, cross, dot, per_axis};
use crate::tree::{Node, WIDTH, xyz};
use crate::triangle::batch::{LEAST_EDGE_SLOP, Rows, UNDERFLOW};
use wide::f32x4;

/// Eight boxes by centre and half extents, along the axes of their node.
#[derive(Clone, Copy)]
struct Boxes<L: Lanes> {
    center: V8<L>,
    half: V8<L>,
}

impl<L: Lanes> Boxes<L> {
    /// The children of `node`, whose unit has the length `scale`.
    #[inline(always)]
    fn children(lanes: L, node: &Node, scale: f32) -> Self {
        let scale = F8::splat(lanes, scale);
        Self {
            center: per_axis!(k => F8::load(lanes, &node.center[k]) * scale),
            half: per_axis!(k => F8::load(lanes, &node.half[k]) * scale),
        }
    }

    #[inline(always)]
    fn slabs(&self) -> Slabs<L> {
        Slabs {
            low: per_axis!(k => self.center[k] - self.half[k]),
            high: per_axis!(k => self.center[k] + self.half[k]),
        }
    }

    /// The boxes around these along the axes of the other side.
    #[inline(always)]
    fn seen(&self, lanes: L, view: &View) -> Slabs<L> {
        let m = per_axis!(k => per_axis!(j => F8::splat(lanes, view.columns[j].as_array()[k])));
        let margin = F8::splat(lanes, view.margin.as_array()[0]);
        let boxes = Self {
            center: per_axis!(k => dot(m[k], self.center) + F8::splat(lanes, view.origin.as_array()[k])),
            half: per_axis!(k => dot(per_axis!(j => m[k][j].abs()), self.half) + margin),
        };
        boxes.slabs()
    }
}

/// Eight boxes by their ends on three axes.
#[derive(Clone, Copy)]
struct Slabs<L: Lanes> {
    low: V8<L>,
    high: V8<L>,
}

impl<L: Lanes> Slabs<L> {
    /// The lanes that are apart from the given box.
    #[inline(always)]
    fn apart(&self, lanes: L, low: [f32; 3], high: [f32; 3]) -> u32 {
        self.gap(lanes, low, high).mask()
    }

    /// The same for lane `i` of the stored boxes.
    #[inline(always)]
    fn gap_at(&self, lanes: L, other: &Stored, i: usize) -> F8<L> {
        self.gap(lanes, per_axis!(k => other.low[k][i]), per_axis!(k => other.high[k][i]))
    }

    /// How deep each lane overlaps the given box, the least over the axes; negative where they are apart.
    #[inline(always)]
    fn gap(&self, lanes: L, low: [f32; 3], high: [f32; 3]) -> F8<L> {
        let [x, y, z] = per_axis!(k => {
            let below = self.high[k] - F8::splat(lanes, low[k]);
            below.min(F8::splat(lanes, high[k]) - self.low[k])
        });
        x.min(y).min(z)
    }

    #[inline(always)]
    fn store(&self) -> Stored {
        Stored { low: per_axis!(k => self.low[k].store()), high: per_axis!(k => self.high[k].store()) }
    }
}

/// Eight boxes, to be read one at a time.
struct Stored {
    low: [[f32; 8]; 3],
    high: [[f32; 8]; 3],
}

/// The ends, on three axes, of a box given by centre and half extents.
#[inline(always)]
fn ends(center: f32x4, half: f32x4) -> ([f32; 3], [f32; 3]) {
    (xyz(center - half), xyz(center + half))
}

/// Whether the boxes of two nodes may meet. A child first passes the test along its parent's axes; this one is along its own.
#[inline(always)]
pub(super) fn own(a: &Node, b: &Node, views: &Views, scale: f32) -> bool {
    let scale = f32x4::splat(scale);
    let a = (a.own_center, a.own_half);
    let b = (b.own_center * scale, b.own_half * scale);
    !apart(b, a, &views.of_b) && !apart(a, b, &views.of_a)
}

/// Whether a box, seen from another, is apart from it; both by centre and half extents.
#[inline(always)]
fn apart(seen: (f32x4, f32x4), other: (f32x4, f32x4), view: &View) -> bool {
    let distance = view.point(seen.0) - other.0;
    let reach = view.half(seen.1) + other.1;
    reach.simd_lt(distance.abs()).any()
}

/// How deep the boxes of each pair of children overlap, written by the tests for those that may meet.
pub(super) type Depths = [[f32; WIDTH]; WIDTH];

/// The given children of `a` against those of `b`: bit `8 i + j` is set where child `i` of `a` may meet child `j` of `b`.
#[inline(always)]
pub(super) fn both<L: Lanes>(
    lanes: L,
    [a, b]: [&Node; 2],
    [alive_a, alive_b]: [u32; 2],
    views: &Views,
    scale: f32,
    depths: &mut Depths,
) -> u64 {
    let (of_a, of_b) = (&views.of_a, &views.of_b);
    let b_rows = Boxes::children(lanes, b, scale);
    let b_in_a = b_rows.seen(lanes, of_b);
    let (low, high) = ends(a.own_center, a.own_half);
    let alive_b = alive_b & !b_in_a.apart(lanes, low, high);
    if alive_b == 0 {
        return 0;
    }
    let a_rows = Boxes::children(lanes, a, 1.0);
    let a_in_b = a_rows.seen(lanes, of_a);
    let scale = f32x4::splat(scale);
    let (low, high) = ends(b.own_center * scale, b.own_half * scale);
    let mut alive_a = alive_a & !a_in_b.apart(lanes, low, high);
    let (a_rows, a_in_b) = (a_rows.slabs().store(), a_in_b.store());
    let b_rows = b_rows.slabs();
    let mut pairs = 0;
    while alive_a != 0 {
        let i = alive_a.trailing_zeros() as usize;
        alive_a &= alive_a - 1;
        let gap = b_in_a.gap_at(lanes, &a_rows, i).min(b_rows.gap_at(lanes, &a_in_b, i));
        depths[i] = gap.store();
        pairs |= u64::from(!gap.mask() & alive_b) << (WIDTH * i);
    }
    pairs
}

/// The children of `opened` against the box of `other`: bit `i` is set where child `i` may meet it. The views are of each
/// from the other.
#[inline(always)]
pub(super) fn children<L: Lanes>(
    lanes: L,
    [opened, other]: [&Node; 2],
    [of_opened, of_other]: [&View; 2],
    scale: [f32; 2],
    depths: &mut [f32; WIDTH],
) -> u32 {
    let children = Boxes::children(lanes, opened, scale[0]);
    let scale = f32x4::splat(scale[1]);
    let (center, half) = (other.own_center * scale, other.own_half * scale);
    let (low, high) = ends(of_other.point(center), of_other.half(half));
    let gap = children.slabs().gap(lanes, low, high);
    let (low, high) = ends(center, half);
    let gap = gap.min(children.seen(lanes, of_opened).gap(lanes, low, high));
    *depths = gap.store();
    !gap.mask() & opened.valid()
}

/// The children of `node` against the given eight triangles of the other side, on the three axes of the boxes and on the
/// triangles' normals: bit `8 i + j` is set where triangle `i` may meet child `j`.
#[inline(always)]
pub(super) fn triangles<L: Lanes>(
    lanes: L,
    node: &Node,
    scale: f32,
    [t0, t1, t2, t3, t4, t5, t6, t7]: [&Rows; 8],
    mut alive: u32,
    view: &View,
    skew: f32,
) -> u64 {
    let [[x, y, z, ex], [ey, ez, fx, fy], [fz, ..]] =
        per_axis!(i => F8::transpose(lanes, [&t0[i], &t1[i], &t2[i], &t3[i], &t4[i], &t5[i], &t6[i], &t7[i]]));
    let axes = per_axis!(k => per_axis!(j => F8::splat(lanes, view.columns[j].as_array()[k])));
    let p = per_axis!(k => dot(axes[k], [x, y, z]) + F8::splat(lanes, view.origin.as_array()[k]));
    let e = per_axis!(k => dot(axes[k], [ex, ey, ez]));
    let f = per_axis!(k => dot(axes[k], [fx, fy, fz]));
    let (zero, margin) = (F8::splat(lanes, 0.0), F8::splat(lanes, view.margin.as_array()[0]));
    let normal = cross(e, f);
    let least = F8::splat(lanes, LEAST_EDGE_SLOP);
    let blur = (longest(e) + least) * (longest(f) + least) * F8::splat(lanes, skew);
    let size = per_axis!(k => normal[k].abs());
    let slack = margin * (size[0] + size[1] + size[2] + blur * F8::splat(lanes, 4.0)) + F8::splat(lanes, UNDERFLOW);
    let rows = Planes {
        boxes: Stored {
            low: per_axis!(k => (p[k] + zero.min(e[k]).min(f[k]) - margin).store()),
            high: per_axis!(k => (p[k] + zero.max(e[k]).max(f[k]) + margin).store()),
        },
        corner: per_axis!(k => p[k].store()),
        normal: per_axis!(k => normal[k].store()),
        reach: per_axis!(k => (size[k] + blur).store()),
        blur: blur.store(),
        slack: slack.store(),
    };

    let boxes = Boxes::children(lanes, node, scale);
    let slabs = boxes.slabs();
    let mut pairs = 0;
    while alive != 0 {
        let i = alive.trailing_zeros() as usize;
        alive &= alive - 1;
        let apart = slabs.gap_at(lanes, &rows.boxes, i).mask() | rows.part(lanes, &boxes, i);
        pairs |= u64::from(!apart & node.valid()) << (WIDTH * i);
    }
    pairs
}

#[inline(always)]
fn longest<L: Lanes>(v: V8<L>) -> F8<L> {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

/// Eight triangles, to be read one at a time.
struct Planes {
    boxes: Stored,
    corner: [[f32; 8]; 3],
    normal: [[f32; 8]; 3],
    /// `|n_k|`, and more by the error of the normal.
    reach: [[f32; 8]; 3],
    blur: [f32; 8],
    slack: [f32; 8],
}

impl Planes {
    /// The boxes that the plane of triangle `i` misses: `|n . (c - p)| > |n| . h`, with all errors of `n` (relative to the
    /// edges) and of `p` on the right-hand side.
    #[inline(always)]
    fn part<L: Lanes>(&self, lanes: L, boxes: &Boxes<L>, i: usize) -> u32 {
        let from_corner = per_axis!(k => boxes.center[k] - F8::splat(lanes, self.corner[k][i]));
        let distance = dot(per_axis!(k => F8::splat(lanes, self.normal[k][i])), from_corner).abs();
        let reach = dot(per_axis!(k => F8::splat(lanes, self.reach[k][i])), boxes.half)
            + (from_corner[0].abs() + from_corner[1].abs() + from_corner[2].abs()) * F8::splat(lanes, self.blur[i])
            + F8::splat(lanes, self.slack[i]);
        reach.less(distance).mask()
    }
}
