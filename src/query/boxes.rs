//! The box tests: eight boxes at a time, on the six face axes.
//!
//! A box of B with centre `c` and half extents `h` (B's frame) lies, seen from A's frame, within `M c + t ± (|M| h + m)`;
//! `m` covers every rounding and is proven in `docs/numerics.md`. So no overlap is ever lost, and a box kept in vain only
//! costs time. The nine edge axes would cost more than they save.

use super::frames::{Frames, Relation};
use crate::math::lanes::{F8, Lanes, V8, dot, per_axis};
use crate::tree::{Node, WIDTH};

/// Eight boxes by their ends on three axes.
#[derive(Clone, Copy)]
struct Slabs<L: Lanes> {
    low: V8<L>,
    high: V8<L>,
}

impl<L: Lanes> Slabs<L> {
    #[inline(always)]
    fn around(center: V8<L>, half: V8<L>) -> Self {
        let [cx, cy, cz] = center;
        let [hx, hy, hz] = half;
        Self { low: [cx - hx, cy - hy, cz - hz], high: [cx + hx, cy + hy, cz + hz] }
    }

    /// The children of `node` in its own frame.
    #[inline(always)]
    fn children(lanes: L, node: &Node) -> Self {
        Self::around(load(lanes, &node.center), load(lanes, &node.half))
    }

    /// Lanes that are apart from the given box on some axis.
    #[inline(always)]
    fn apart(&self, lanes: L, low: [f32; 3], high: [f32; 3]) -> F8<L> {
        let [x, y, z] = per_axis!(k => {
            let below = self.high[k].less(F8::splat(lanes, low[k]));
            below.or(F8::splat(lanes, high[k]).less(self.low[k]))
        });
        x.or(y).or(z)
    }

    /// Lanes whose box is apart, on some axis, from lane `i` of the stored boxes.
    #[inline(always)]
    fn apart_from(&self, lanes: L, other: &Stored, i: usize) -> F8<L> {
        self.apart(lanes, per_axis!(k => other.low[k][i]), per_axis!(k => other.high[k][i]))
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

#[inline(always)]
fn load<L: Lanes>(lanes: L, columns: &[[f32; WIDTH]; 3]) -> V8<L> {
    per_axis!(k => F8::load(lanes, &columns[k]))
}

#[inline(always)]
fn row_dot<L: Lanes>(lanes: L, row: &[f32; 3], v: V8<L>) -> F8<L> {
    dot(per_axis!(k => F8::splat(lanes, row[k])), v)
}

#[inline(always)]
fn row_abs_dot<L: Lanes>(lanes: L, row: &[f32; 3], v: V8<L>) -> F8<L> {
    dot(per_axis!(k => F8::splat(lanes, row[k].abs())), v)
}

/// The children of B's `node`, seen from A's frame.
#[inline(always)]
fn in_a<L: Lanes>(lanes: L, node: &Node, frames: &Frames, margin: f32) -> Slabs<L> {
    let (center, half) = (load(lanes, &node.center), load(lanes, &node.half));
    let center = per_axis!(k => row_dot(lanes, &frames.to_a[k], center) + F8::splat(lanes, frames.offset[k]));
    let half = per_axis!(k => row_abs_dot(lanes, &frames.to_a[k], half) + F8::splat(lanes, margin));
    Slabs::around(center, half)
}

/// The children of A's `node`, seen from B's frame.
#[inline(always)]
fn in_b<L: Lanes>(lanes: L, node: &Node, frames: &Frames, margin: f32) -> Slabs<L> {
    let (center, half) = (load(lanes, &node.center), load(lanes, &node.half));
    let center = per_axis!(k => center[k] - F8::splat(lanes, frames.offset[k]));
    let center = per_axis!(k => row_dot(lanes, &frames.to_b[k], center));
    let half = per_axis!(k => row_abs_dot(lanes, &frames.to_b[k], half) + F8::splat(lanes, margin));
    Slabs::around(center, half)
}

/// A single box in its own frame.
#[inline(always)]
fn own_slabs(node: &Node) -> ([f32; 3], [f32; 3]) {
    let (c, h) = (node.own_center, node.own_half);
    ([c[0] - h[0], c[1] - h[1], c[2] - h[2]], [c[0] + h[0], c[1] + h[1], c[2] + h[2]])
}

#[inline(always)]
fn row_of(m: &[f32; 3], v: &[f32; 3]) -> f32 {
    m[0] * v[0] + m[1] * v[1] + m[2] * v[2]
}

#[inline(always)]
fn abs_row_of(m: &[f32; 3], v: &[f32; 3]) -> f32 {
    m[0].abs() * v[0] + m[1].abs() * v[1] + m[2].abs() * v[2]
}

/// The box of a node of B seen from A's frame: centre and half extents, margin included.
#[inline(always)]
pub(super) fn box_in_a(center: &[f32; 3], half: &[f32; 3], frames: &Frames, margin: f32) -> ([f32; 3], [f32; 3]) {
    let center = per_axis!(k => row_of(&frames.to_a[k], center) + frames.offset[k]);
    (center, per_axis!(k => abs_row_of(&frames.to_a[k], half) + margin))
}

/// The box of a node of A seen from B's frame: centre and half extents, margin included.
#[inline(always)]
pub(super) fn box_in_b(center: &[f32; 3], half: &[f32; 3], frames: &Frames, margin: f32) -> ([f32; 3], [f32; 3]) {
    let center = per_axis!(k => center[k] - frames.offset[k]);
    let center = per_axis!(k => row_of(&frames.to_b[k], &center));
    (center, per_axis!(k => abs_row_of(&frames.to_b[k], half) + margin))
}

#[inline(always)]
fn ends((c, h): ([f32; 3], [f32; 3])) -> ([f32; 3], [f32; 3]) {
    ([c[0] - h[0], c[1] - h[1], c[2] - h[2]], [c[0] + h[0], c[1] + h[1], c[2] + h[2]])
}

/// The children of `a` against those of `b`: bit `8 i + j` is set where child `i` of `a` may meet child `j` of `b`.
#[inline(always)]
pub(super) fn both<L: Lanes>(lanes: L, a: &Node, b: &Node, frames: &Frames, relation: &Relation) -> u64 {
    let b_in_a = in_a(lanes, b, frames, relation.margin[0]);
    let (low, high) = own_slabs(a);
    let alive_b = !b_in_a.apart(lanes, low, high).mask() & b.valid();
    if alive_b == 0 {
        return 0;
    }
    let a_in_b = in_b(lanes, a, frames, relation.margin[1]);
    let (low, high) = own_slabs(b);
    let mut alive_a = !a_in_b.apart(lanes, low, high).mask() & a.valid();
    let a_rows = Slabs::children(lanes, a).store();
    let a_in_b = a_in_b.store();
    let b_rows = Slabs::children(lanes, b);
    let mut pairs = 0;
    while alive_a != 0 {
        let i = alive_a.trailing_zeros() as usize;
        alive_a &= alive_a - 1;
        let apart = b_in_a.apart_from(lanes, &a_rows, i).or(b_rows.apart_from(lanes, &a_in_b, i));
        pairs |= u64::from(!apart.mask() & alive_b) << (WIDTH * i);
    }
    pairs
}

/// The children of `a` against the box of `b`: bit `i` is set where child `i` may meet it.
#[inline(always)]
pub(super) fn children_of_a<L: Lanes>(lanes: L, a: &Node, b: &Node, frames: &Frames, relation: &Relation) -> u32 {
    let (low, high) = ends(box_in_a(&b.own_center, &b.own_half, frames, relation.margin[0]));
    let apart = Slabs::children(lanes, a).apart(lanes, low, high);
    let (low, high) = own_slabs(b);
    let apart = apart.or(in_b(lanes, a, frames, relation.margin[1]).apart(lanes, low, high));
    !apart.mask() & a.valid()
}

/// The children of `b` against the box of `a`: bit `j` is set where child `j` may meet it.
#[inline(always)]
pub(super) fn children_of_b<L: Lanes>(lanes: L, a: &Node, b: &Node, frames: &Frames, relation: &Relation) -> u32 {
    let (low, high) = ends(box_in_b(&a.own_center, &a.own_half, frames, relation.margin[1]));
    let apart = Slabs::children(lanes, b).apart(lanes, low, high);
    let (low, high) = own_slabs(a);
    let apart = apart.or(in_a(lanes, b, frames, relation.margin[0]).apart(lanes, low, high));
    !apart.mask() & b.valid()
}

/// A triangle in the frame of a node: first corner and two edges.
pub(super) type InFrame = [[f32; 3]; 3];

/// Brings a triangle of B into the frame of a node of A.
#[inline(always)]
pub(super) fn triangle_in_a(triangle: &[[f32; 4]; 3], frames: &Frames) -> InFrame {
    let [[x, y, z, ex], [ey, ez, fx, fy], [fz, ..]] = *triangle;
    let by = &frames.to_a;
    [
        per_axis!(k => row_of(&by[k], &[x, y, z]) + frames.offset[k]),
        per_axis!(k => row_of(&by[k], &[ex, ey, ez])),
        per_axis!(k => row_of(&by[k], &[fx, fy, fz])),
    ]
}

/// Brings a triangle of A into the frame of a node of B.
#[inline(always)]
pub(super) fn triangle_in_b(triangle: &[[f32; 4]; 3], frames: &Frames) -> InFrame {
    let [[x, y, z, ex], [ey, ez, fx, fy], [fz, ..]] = *triangle;
    let by = &frames.to_b;
    let [ox, oy, oz] = frames.offset;
    [
        per_axis!(k => row_of(&by[k], &[x - ox, y - oy, z - oz])),
        per_axis!(k => row_of(&by[k], &[ex, ey, ez])),
        per_axis!(k => row_of(&by[k], &[fx, fy, fz])),
    ]
}

/// The children of `node` against a triangle in its frame, on the three axes of the boxes and on the triangle's normal.
#[inline(always)]
pub(super) fn children_of_node<L: Lanes>(lanes: L, node: &Node, triangle: &InFrame, margin: f32, skew: f32) -> u32 {
    let [p, e, f] = triangle;
    let low = per_axis!(k => p[k] + 0f32.min(e[k]).min(f[k]) - margin);
    let high = per_axis!(k => p[k] + 0f32.max(e[k]).max(f[k]) + margin);
    let children = Slabs::children(lanes, node);
    let apart = children.apart(lanes, low, high);

    // |n . (c - p)| > |n| . h, with all errors of n (relative to the edges) and of p on the right-hand side.
    let (center, half) = (load(lanes, &node.center), load(lanes, &node.half));
    let normal = cross_of(e, f);
    let blur = skew * longest(e) * longest(f);
    let from_first = per_axis!(k => center[k] - F8::splat(lanes, p[k]));
    let distance = row_dot(lanes, &normal, from_first).abs();
    let normal = [normal[0].abs(), normal[1].abs(), normal[2].abs()];
    let slack = margin * (normal[0] + normal[1] + normal[2] + 4.0 * blur) + 1e-36;
    let reach = row_dot(lanes, &[normal[0] + blur, normal[1] + blur, normal[2] + blur], half)
        + (from_first[0].abs() + from_first[1].abs() + from_first[2].abs()) * F8::splat(lanes, blur)
        + F8::splat(lanes, slack);
    !apart.or(reach.less(distance)).mask() & node.valid()
}

#[inline(always)]
fn longest(v: &[f32; 3]) -> f32 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

#[inline(always)]
fn cross_of(a: &[f32; 3], b: &[f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
