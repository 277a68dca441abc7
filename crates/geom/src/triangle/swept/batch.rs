//! Eight pairs at a time in `f32`.

use super::Glide;
use crate::lanes::{Column, F8, Lanes, V8, add, cross, dot, per_axis, scaled, sub};
use crate::tolerance::ROUNDING;
use crate::triangle::batch::{Placement, Rows, Transposed, UNDERFLOW};
use crate::triangle::distance::Pair;

/// Lower bounds of the times at which `a[i]` and `b[i]` meet, and a bit mask of the lanes that may
/// meet before `cut`. Times are in substeps, from -1/2 to 1/2. If `spread`, all lanes hold one
/// pair, and each lane covers an eighth of the substep.
#[inline(always)]
pub fn windows<L: Lanes>(
    lanes: L,
    a: [&Rows; 8],
    b: [&Rows; 8],
    placement: &Placement,
    glide: &Glide,
    cut: f32,
    spread: bool,
) -> ([f32; 8], u32) {
    let first = Transposed::new(lanes, a).first;
    let mut pair = Gliding::new(lanes, Pair::new(lanes, a, b, placement), first, glide);
    if spread {
        pair.spread(lanes);
    }
    let (enter, active) = Ends::new(lanes, &pair).window(lanes, &pair, cut);
    (enter.store(), active)
}

/// Eight pairs; the triangles of B move.
struct Gliding<L: Lanes> {
    of: Pair<L>,
    /// `ways`: displacement of each corner of B during half of the lane's time. `bend`: deviation
    /// of a corner from its straight line at either end of that time.
    ways: [V8<L>; 3],
    bend: V8<L>,
    /// A quarter of the acceleration, in A's units per squared substep.
    acceleration: V8<L>,
    /// Middle and length of the lane's time, in substeps.
    middle: F8<L>,
    length: F8<L>,
}

impl<L: Lanes> Gliding<L> {
    #[inline(always)]
    fn new(lanes: L, mut of: Pair<L>, first: V8<L>, glide: &Glide) -> Self {
        let half = F8::splat(lanes, 0.5);
        let mut way = per_axis!(k => F8::splat(lanes, 0.5 * glide.shift[k]));
        let mut error = F8::splat(lanes, glide.arc_error);
        let zero = F8::splat(lanes, 0.0);
        let (mut ways, mut acceleration) = ([way; 3], [zero; 3]);
        if glide.spin > 0.0 {
            let at = per_axis!(k => of.q[k] + first[k]);
            let turn = per_axis!(k => F8::splat(lanes, glide.turn[k]) * half);
            let turned = cross(turn, at);
            acceleration = add(
                per_axis!(k => F8::splat(lanes, 0.25 * glide.pull[k])),
                cross(turn, turned),
            );
            if glide.turn_error > 0.0 {
                let change = per_axis!(k => F8::splat(lanes, 0.25 * glide.change[k]));
                acceleration = add(acceleration, cross(change, at));
            }
            let size = per_axis!(k => of.f[0][k].abs().max(of.f[1][k].abs()));
            way = add(way, turned);
            ways = [
                way,
                add(way, cross(turn, of.f[0])),
                add(way, cross(turn, of.f[1])),
            ];
            error = error
                + sum(turn) * sum(size) * F8::splat(lanes, 0.5 * glide.spin)
                + sum(size) * F8::splat(lanes, 0.25 * glide.turn_error)
                + sum(turn) * sum(at) * F8::splat(lanes, 64.0 * ROUNDING);
        }
        of.error = per_axis!(k => {
            of.error[k] + error + F8::splat(lanes, (glide.shift[k].abs() + glide.pull[k].abs()) * (4.0 * ROUNDING))
        });
        let bend = per_axis!(k => acceleration[k] * F8::splat(lanes, 0.505));
        Self {
            of,
            ways,
            bend,
            acceleration,
            middle: zero,
            length: F8::splat(lanes, 1.0),
        }
    }

    /// Assigns an eighth of the substep to each lane.
    #[inline(always)]
    fn spread(&mut self, lanes: L) {
        let middle = F8::load(
            lanes,
            &[
                -0.4375, -0.3125, -0.1875, -0.0625, 0.0625, 0.1875, 0.3125, 0.4375,
            ],
        );
        let (twice, eighth) = (middle + middle, F8::splat(lanes, 0.125));
        let change = per_axis!(k => self.acceleration[k] * middle);
        let way = per_axis!(k => (self.ways[0][k] + change[k]) * twice);
        let rounding = per_axis!(k => {
            let edges = self.of.f[0][k].abs().max(self.of.f[1][k].abs());
            (self.of.q[k].abs() + edges + self.ways[0][k].abs() + change[k].abs()) * F8::splat(lanes, 8.0 * ROUNDING)
        });
        self.of.error = add(self.of.error, rounding);
        self.of.q = add(self.of.q, way);
        let turned = [
            sub(self.ways[1], self.ways[0]),
            sub(self.ways[2], self.ways[0]),
        ];
        for (edge, turned) in self.of.f.iter_mut().zip(turned) {
            *edge = add(*edge, scaled(turned, twice));
        }
        let quarter = F8::splat(lanes, 0.25);
        self.ways = per_axis!(j => per_axis!(k => self.ways[j][k] * eighth + change[k] * quarter));
        self.bend = per_axis!(k => self.bend[k] * (eighth * eighth));
        (self.middle, self.length) = (middle, eighth);
    }

    /// Start of each window, rounded down, and a bit mask of the windows that are not empty and
    /// start before `cut`.
    #[inline(always)]
    fn active(&self, lanes: L, [enter, leave]: [F8<L>; 2], cut: f32) -> (F8<L>, u32) {
        let position_error = F8::splat(lanes, 8.0 * ROUNDING);
        let from = self.middle + enter * self.length - position_error;
        // Comparisons with NaN are false, so a lane with NaN stays active.
        let gone = (leave + position_error)
            .less(enter - position_error)
            .or(F8::splat(lanes, cut).less(from));
        (from, !gone.mask() & 0xff)
    }
}

/// Eight pairs at the start and at the end of their time.
struct Ends<L: Lanes> {
    /// Edges of A: the two from its first corner, then the third.
    p: [V8<L>; 3],
    /// First corner of B (`q`) and the edges from there (`f`), at the start and at the end.
    q: [V8<L>; 2],
    f: [[V8<L>; 2]; 2],
    /// Edges of B halfway through the time interval.
    middle: [V8<L>; 3],
    bend: V8<L>,
    /// The error bound of a gap is the dot product of `error` with the magnitudes of the
    /// direction's components.
    error: V8<L>,
    /// Bounds the distance between the projections of an edge's two ends on a rounded cross
    /// product. On the exact product of this edge and another one, both ends would project to one
    /// point. For two edges of A, two of B, and one of each.
    position_error: [F8<L>; 3],
}

/// Length of the longest of three vectors.
#[inline(always)]
fn longest<L: Lanes>([x, y, z]: [V8<L>; 3]) -> F8<L> {
    dot(x, x).max(dot(y, y)).max(dot(z, z)).sqrt()
}

/// Least and greatest projection of a triangle, relative to that of its first corner. `x` and `y`
/// are the projections of its two edges from that corner.
#[inline(always)]
fn extent<L: Lanes>(lanes: L, x: F8<L>, y: F8<L>) -> [F8<L>; 2] {
    let zero = F8::splat(lanes, 0.0);
    [zero.min(x).min(y), zero.max(x).max(y)]
}

impl<L: Lanes> Ends<L> {
    #[inline(always)]
    fn new(lanes: L, pair: &Gliding<L>) -> Self {
        let Gliding {
            of:
                Pair {
                    p,
                    q,
                    f: edges,
                    error,
                },
            ways,
            bend,
            ..
        } = pair;
        let turned = [sub(ways[1], ways[0]), sub(ways[2], ways[0])];
        let e = [sub(edges[0], turned[0]), sub(edges[1], turned[1])];
        let f = [add(edges[0], turned[0]), add(edges[1], turned[1])];
        let reach = per_axis!(k => {
            let of_p = p[0][k].abs().max(p[1][k].abs());
            let of_f = e[0][k].abs().max(e[1][k].abs()).max(f[0][k].abs()).max(f[1][k].abs());
            of_p + of_f + q[k].abs() + ways[0][k].abs()
        });
        let error = per_axis!(k => error[k] + reach[k] * F8::splat(lanes, 6.0 * ROUNDING));
        let p = [p[0], p[1], sub(p[1], p[0])];
        let middle = [edges[0], edges[1], sub(edges[1], edges[0])];
        let (x, y) = (
            longest(p),
            longest(middle) + longest([turned[0], turned[1], sub(turned[1], turned[0])]),
        );
        let position_error = |x: F8<L>, y: F8<L>| {
            x * y * (x + y) * F8::splat(lanes, 4.0 * ROUNDING) + F8::splat(lanes, UNDERFLOW)
        };
        Self {
            position_error: [
                position_error(x, x),
                position_error(y, y),
                position_error(x, y),
            ],
            p,
            q: [sub(*q, ways[0]), add(*q, ways[0])],
            f: [e, f],
            middle,
            bend: *bend,
            error,
        }
    }

    /// Start of the window in which each pair may meet, and the bit mask of [`Gliding::active`].
    #[inline(always)]
    fn window(&self, lanes: L, pair: &Gliding<L>, cut: f32) -> (F8<L>, u32) {
        let all = [F8::splat(lanes, -0.5), F8::splat(lanes, 0.5)];
        let mut window = self.on_normal_of_b(lanes, self.on_normal_of_a(lanes, all));
        let mut i = 0;
        while i < 3 {
            if pair.active(lanes, window, cut).1 == 0 {
                return (F8::splat(lanes, f32::INFINITY), 0);
            }
            let mut j = 0;
            while j < 3 {
                window = self.on_edges(lanes, i, j, window);
                j += 1;
            }
            i += 1;
        }
        pair.active(lanes, window, cut)
    }

    #[inline(always)]
    fn on_normal_of_a(&self, lanes: L, window: [F8<L>; 2]) -> [F8<L>; 2] {
        let (n, zero) = (cross(self.p[0], self.p[1]), F8::splat(lanes, 0.0));
        self.on(lanes, n, [zero; 2], self.position_error[0], window)
    }

    #[inline(always)]
    fn on_normal_of_b(&self, lanes: L, window: [F8<L>; 2]) -> [F8<L>; 2] {
        let ([p, q, _], n) = (self.p, cross(self.middle[0], self.middle[1]));
        let of_a = extent(lanes, dot(p, n), dot(q, n));
        self.on(lanes, n, of_a, self.position_error[1], window)
    }

    /// Narrows a window by the direction that is the cross product of edge `i` of A and edge `j` of
    /// B. Along it, both ends of A's edge have one projection.
    #[inline(always)]
    fn on_edges(&self, lanes: L, i: usize, j: usize, window: [F8<L>; 2]) -> [F8<L>; 2] {
        let n = cross(self.p[i % 3], self.middle[j % 3]);
        let x = dot(self.p[usize::from(i == 0)], n);
        let zero = F8::splat(lanes, 0.0);
        let of_a = [zero.min(x), zero.max(x)];
        self.on(lanes, n, of_a, self.position_error[2], window)
    }

    /// Gaps along a direction at the start (`end` is 0) or at the end (1): of B above A, and of B
    /// below A.
    #[inline(always)]
    fn gaps(
        &self,
        lanes: L,
        end: usize,
        n: V8<L>,
        of_a: [F8<L>; 2],
        [up, down]: [F8<L>; 2],
    ) -> [F8<L>; 2] {
        let (b, [x, y]) = (dot(self.q[end], n), self.f[end]);
        let of_b = extent(lanes, dot(x, n), dot(y, n));
        [b + (of_b[0] - of_a[1]) + up, (of_a[0] - of_b[1]) - b - down]
    }

    /// Narrows a window by a direction of any length. `of_a` is the extent of A; its error is at
    /// most `position_error`.
    #[inline(always)]
    fn on(
        &self,
        lanes: L,
        n: V8<L>,
        of_a: [F8<L>; 2],
        position_error: F8<L>,
        [enter, leave]: [F8<L>; 2],
    ) -> [F8<L>; 2] {
        let (zero, half) = (F8::splat(lanes, 0.0), F8::splat(lanes, 0.5));
        let error = dot(per_axis!(k => n[k].abs()), self.error) + position_error;
        let bend = dot(self.bend, n);
        let (up, down) = (bend.min(zero) - error, bend.max(zero) + error);
        // In between, each gap is at least the linear interpolation of those at both ends.
        let [above, below] = self.gaps(lanes, 0, n, of_a, [up, down]);
        let [above_then, below_then] = self.gaps(lanes, 1, n, of_a, [up, down]);
        let first = below.less(above);
        let (begin, then) = (above.max(below), first.select(above_then, below_then));
        let last = below_then.less(above_then);
        let (end, before) = (above_then.max(below_then), last.select(above, below));
        let (apart, parting) = (zero.less(begin), zero.less(end));
        let from = apart.select(begin / (begin - then), zero) - half;
        let until = half - parting.select(end / (end - before), zero);
        let never = apart.and(zero.less(then));
        [
            never.select(F8::splat(lanes, f32::INFINITY), enter.max(from)),
            leave.min(until),
        ]
    }
}

#[inline(always)]
fn sum<L: Lanes>([x, y, z]: V8<L>) -> F8<L> {
    x.abs() + y.abs() + z.abs()
}
