//! The filter of [`batch`](super::batch) in `f64`, four pairs at a time, for a few triangles whose
//! corners are known in `f64`. What it leaves in doubt is coplanar or touches.

use super::batch::{Bounds, Range, Verdicts, certain, largest};
use super::exact::{LARGEST_EXTENT, PADDING};
use crate::lanes::{Column, D4, Kernel, Lanes, per_axis, sub};
use glam::DVec3;

/// Corners of eight triangles, indexed by corner, axis, triangle.
#[derive(Clone, Debug)]
pub struct Columns([[[f64; 8]; 3]; 3]);

impl Columns {
    pub const ZERO: Self = Self([[[0.0; 8]; 3]; 3]);

    pub fn set(&mut self, lane: usize, corners: &[DVec3; 3]) {
        for (number, &corner) in corners.iter().enumerate() {
            self.set_corner(lane, number, corner);
        }
    }

    /// Sets all eight triangles to this one.
    pub fn fill(&mut self, corners: &[DVec3; 3]) {
        for (columns, corner) in self.0.iter_mut().zip(corners) {
            for (column, x) in columns.iter_mut().zip(corner.to_array()) {
                *column = [x; 8];
            }
        }
    }

    #[inline]
    pub fn set_corner(&mut self, lane: usize, number: usize, corner: DVec3) {
        for (column, x) in self.0[number].iter_mut().zip(corner.to_array()) {
            column[lane] = x;
        }
    }

    /// Corners of triangle `at` and the next three, indexed by corner and axis.
    #[inline(always)]
    fn four<L: Lanes>(&self, lanes: L, at: usize) -> [[D4<L>; 3]; 3] {
        per_axis!(i => per_axis!(k => D4::load(lanes, &self.0[i][k].as_chunks().0[at / 4])))
    }

    pub fn get(&self, lane: usize) -> [DVec3; 3] {
        self.0
            .each_ref()
            .map(|[x, y, z]| DVec3::new(x[lane], y[lane], z[lane]))
    }
}

/// Up to eight pairs of triangles.
pub struct Filter64<'c> {
    pub a: &'c Columns,
    pub b: &'c Columns,
    /// Number of pairs. They occupy the columns from 0 on.
    pub count: usize,
}

impl Kernel for Filter64<'_> {
    type Output = Verdicts;

    /// Tests four pairs at a time, as many as a register holds.
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Verdicts {
        let Self { a, b, count } = self;
        let mut verdicts = Verdicts { hit: 0, doubt: 0 };
        for at in (0..count.min(8)).step_by(4) {
            let Verdicts { hit, doubt } = four(a.four(lanes, at), b.four(lanes, at));
            verdicts.hit |= hit << at;
            verdicts.doubt |= doubt << at;
        }
        verdicts
    }
}

#[inline(always)]
fn four<L: Lanes>(a: [[D4<L>; 3]; 3], b: [[D4<L>; 3]; 3]) -> Verdicts {
    let lanes = a[0][0].lanes();
    let [x, y, z] = per_axis!(k => {
        let (of_a, of_b) = (Range::of([a[0][k], a[1][k], a[2][k]]), Range::of([b[0][k], b[1][k], b[2][k]]));
        of_a.high.less(of_b.low).or(of_b.high.less(of_a.low))
    });
    let apart = x.or(y).or(z).mask();
    let [x, y, z] = per_axis!(i => {
        let [x, y, z] = per_axis!(j => differ(a[i], b[j]));
        x.and(y).and(z)
    });
    let share = !x.and(y).and(z).mask() & 0xf;
    if apart | share == 0xf {
        return Verdicts {
            hit: share,
            doubt: 0,
        };
    }

    let (p, f, q) = (
        [sub(a[1], a[0]), sub(a[2], a[0])],
        [sub(b[1], b[0]), sub(b[2], b[0])],
        sub(b[0], a[0]),
    );
    let sizes = [
        largest(p[0]).max(largest(p[1])),
        largest(f[0]).max(largest(f[1])),
        largest(q),
    ];
    let fits = Range::of(sizes)
        .high
        .less(D4::splat(lanes, LARGEST_EXTENT))
        .mask();
    let padding = D4::splat(lanes, PADDING);
    let bounds = Bounds::new(
        per_axis!(i => sizes[i] + padding),
        ROUNDING,
        D4::splat(lanes, 0.0),
    );
    let Verdicts { hit, doubt } = certain(p, f, q, &bounds, None);
    let hit = hit & fits | share;
    Verdicts {
        hit,
        doubt: (doubt | !fits) & !(apart | hit) & 0xf,
    }
}

/// Relative rounding of one `f64` operation: 2^-53.
const ROUNDING: f32 = (f64::EPSILON / 2.0) as f32;

#[inline(always)]
fn differ<N: Column>(a: [N; 3], b: [N; 3]) -> N {
    let [x, y, z] = per_axis!(k => a[k].less(b[k]).or(b[k].less(a[k])));
    x.or(y).or(z)
}
