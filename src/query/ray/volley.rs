//! Eight rays of a batch made ready at once, a ray a lane: the same bits as one by one ([`Beam::follow`], [`Beam::enter`]), in
//! a third of the instructions.

use super::beam::{Beam, CUBE_MARGIN, LARGEST_SLOP, LEAST_COMPONENT, MARGIN, NEAR};
use crate::math::Ray;
use crate::math::lanes::{Column, D8, F8, Lanes, V8, per_axis, per_lane, scaled};
use crate::query::expand::transposed;
use crate::tree::{Node, Tree, Unit, WIDTH, lane, power_of_two};
use crate::triangle::ray::EXPONENTS;
use crate::triangle::ray::batch::{LARGEST_PARAMETER, Shaft};

/// A ray, and what it does at the root of the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ready {
    pub beam: Beam,
    /// Where it enters the boxes of the root's children, and which of them.
    pub enter: [f32; WIDTH],
    pub entered: u32,
}

impl Ready {
    pub const NONE: Self = Self {
        beam: Beam::BLIND,
        enter: [0.0; WIDTH],
        entered: 0,
    };

    #[inline(always)]
    pub fn meet_root<L: Lanes>(&mut self, lanes: L, root: &Node) {
        (self.enter, self.entered) = self.beam.enter(lanes, root, 0.0);
    }
}

/// log2 of the length of a unit, up to which no power of two here leaves the range of `f64`.
const LARGEST_UNIT: i32 = 600;

/// A direction with a component that is smaller than this, relative to the largest, may cross the planes of the cube at what is
/// no number.
const LEAST_RATIO: f64 = 1e-150;

/// Makes the first of some rays ready, of which there is at least one.
#[inline(always)]
pub(super) fn make_ready<L: Lanes>(
    lanes: L,
    tree: &Tree,
    rays: &[Ray],
    ready: &mut [Ready; WIDTH],
) {
    let last = rays.len() - 1;
    let rays = per_lane!(i => &rays[last.min(i)]);
    let (unit, root) = (tree.unit(), &tree.nodes()[0]);
    let volley = Volley::new(lanes, unit, rays);
    volley.store(ready);
    let (enter, entered) = volley.enter(root);
    let mut i = 0;
    while i < WIDTH {
        (ready[i].enter, ready[i].entered) = (enter[i], entered[i].into());
        if volley.is_plain >> i & 1 == 0 {
            ready[i].beam.follow(unit, rays[i]);
            ready[i].meet_root(lanes, root);
        }
        i += 1;
    }
}

/// Beams in lanes: the fields of [`Beam`].
struct Volley<L: Lanes> {
    lanes: L,
    origin: V8<L>,
    direction: V8<L>,
    slop: F8<L>,
    margin: F8<L>,
    from: F8<L>,
    to: F8<L>,
    entry: D8<L>,
    unit: D8<L>,
    slack: D8<L>,
    /// Those that these formulas do for, a bit each.
    is_plain: u32,
}

impl<L: Lanes> Volley<L> {
    #[inline(always)]
    fn new(lanes: L, unit: &Unit, rays: [&Ray; WIDTH]) -> Self {
        let splat = |x: f64| D8::splat(lanes, x);
        let (origins, directions, limits) = columns(rays);
        let [first, end] = [D8::load(lanes, &limits[0]), D8::load(lanes, &limits[1])];
        let scale = splat(power_of_two(-unit.exponent));
        let origin = per_axis!(k => (D8::load(lanes, &origins[k]) - splat(unit.origin[k])) * scale);
        let direction = per_axis!(k => D8::load(lanes, &directions[k]));

        let sizes = per_axis!(k => direction[k].abs());
        let size = sizes[0].max(sizes[1]).max(sizes[2]);
        let least = sizes[0].min(sizes[1]).min(sizes[2]);
        let power = size.and(splat(f64::INFINITY));
        let inverse_power = splat(1.0) / power;
        let direction = scaled(direction, inverse_power);
        let (of_unit, per_unit) = (
            inverse_power * splat(power_of_two(unit.exponent)),
            power * scale,
        );

        let reach = origin[0].abs().max(origin[1].abs()).max(origin[2].abs());
        let slop = splat(8.0 * f64::EPSILON) * reach;
        let is_plain = splat(power_of_two(-EXPONENTS - 1))
            .less(power)
            .and(power.less(splat(power_of_two(EXPONENTS + 1))))
            .and(slop.less(splat(LARGEST_SLOP)))
            .and((size * splat(LEAST_RATIO)).less(least))
            .mask();
        let is_plain = if unit.exponent.abs() <= LARGEST_UNIT {
            is_plain
        } else {
            0
        };

        let (mut entry, mut leave) = (splat(0.0), end * per_unit);
        let is_far = splat(NEAR).less(reach);
        if is_far.mask() != 0 {
            let side = splat(1.0 + CUBE_MARGIN) + splat(2.0) * slop;
            let spans = per_axis!(k => {
                let inverse = splat(1.0) / direction[k];
                let (one, other) = ((-side - origin[k]) * inverse, (side - origin[k]) * inverse);
                [one.min(other), one.max(other)]
            });
            let begin = spans[0][0].max(entry);
            entry = spans[2][0].max(spans[1][0].max(begin)).and(is_far);
            let is_near = reach.less(splat(NEAR.next_up()));
            let clipped = spans[2][1].min(spans[1][1].min(spans[0][1].min(leave)));
            leave = clipped.and(is_far).or(leave.and(is_near));
        }
        let slack = splat(1e-6) + splat(4e-11) * (entry + reach + splat(4.0));
        let left = (leave - entry + slack).narrow();
        let from = (first * per_unit - entry - slack).narrow();
        let narrow = |x: f32| F8::splat(lanes, x);
        let to = narrow(0.0)
            .less(left)
            .select(left.min(narrow(LARGEST_PARAMETER)), narrow(-1.0));
        let slop = slop.narrow();
        Self {
            lanes,
            origin: per_axis!(k => (origin[k] + direction[k] * entry).narrow()),
            direction: per_axis!(k => direction[k].narrow()),
            slop,
            margin: narrow(MARGIN) + slop,
            from: from.max(narrow(0.0)).min(narrow(LARGEST_PARAMETER)),
            to,
            entry,
            unit: of_unit,
            slack,
            is_plain,
        }
    }

    /// Where each enters the boxes of the root's children, and which of them before its end, a bit for each.
    #[inline(always)]
    fn enter(&self, root: &Node) -> ([[f32; WIDTH]; WIDTH], [u8; WIDTH]) {
        let splat = |x: f32| F8::splat(self.lanes, x);
        let seen = |v: &V8<L>, axis: [f32; 3]| {
            v[0] * splat(axis[0]) + v[1] * splat(axis[1]) + v[2] * splat(axis[2])
        };
        let origin = per_axis!(k => seen(&self.origin, root.axis(k)));
        let inverse = per_axis!(k => {
            let direction = seen(&self.direction, root.axis(k));
            (splat(1.0) / direction.abs().max(splat(LEAST_COMPONENT))).or(direction.and(splat(-0.0)))
        });
        let mut missed = [u8::MAX; WIDTH];
        let enter = per_lane!(i => {
            let spans = per_axis!(k => {
                let middle = (splat(lane(&root.center[k], i)) - origin[k]) * inverse[k];
                let half = (splat(lane(&root.half[k], i)) + self.margin) * inverse[k].abs();
                [middle - half, middle + half]
            });
            let enter = spans[0][0].max(spans[1][0]).max(spans[2][0]).max(self.from);
            let leave = spans[0][1].min(spans[1][1]).min(spans[2][1]).min(self.to);
            missed[i] = leave.less(enter).mask() as u8;
            enter
        });
        let low = F8::rows([enter[0], enter[1], enter[2], enter[3]]);
        let high = F8::rows([enter[4], enter[5], enter[6], enter[7]]);
        let enter = per_lane!(i => {
            let ([a, b, c, d], [e, f, g, h]) = (low[i], high[i]);
            [a, b, c, d, e, f, g, h]
        });
        let valid = u64::from(root.valid() as u8) * 0x0101_0101_0101_0101;
        (
            enter,
            (transposed(!u64::from_le_bytes(missed)) & valid).to_le_bytes(),
        )
    }

    #[inline(always)]
    fn store(&self, ready: &mut [Ready; WIDTH]) {
        let ([x, y, z], [u, v, w]) = (self.origin, self.direction);
        let (origins, directions) = (
            F8::rows([x, y, z, self.slop]),
            F8::rows([u, v, w, self.margin]),
        );
        let (from, to) = (self.from.store(), self.to.store());
        let (entry, unit, slack) = (self.entry.store(), self.unit.store(), self.slack.store());
        let mut i = 0;
        while i < WIDTH {
            let ([x, y, z, slop], [u, v, w, margin]) = (origins[i], directions[i]);
            let shaft = Shaft {
                origin: [x, y, z],
                direction: [u, v, w],
                slop,
            };
            ready[i].beam = Beam {
                shaft,
                from: from[i],
                to: to[i],
                margin,
                entry: entry[i],
                unit: unit[i],
                slack: slack[i],
            };
            i += 1;
        }
    }
}

type Columns = ([[f64; WIDTH]; 3], [[f64; WIDTH]; 3], [[f64; WIDTH]; 2]);

/// Origins and directions of rays, component by component, and from where to where they go.
#[inline(always)]
fn columns(rays: [&Ray; WIDTH]) -> Columns {
    let (mut origins, mut directions, mut limits) =
        ([[0.0; WIDTH]; 3], [[0.0; WIDTH]; 3], [[0.0; WIDTH]; 2]);
    let mut i = 0;
    while i < WIDTH {
        let ray = rays[i];
        let (origin, direction, [first, last]) = (ray.origin(), ray.direction(), ray.limits());
        let last = if ray.is_segment() && last > 1.0 {
            1.0
        } else {
            last
        };
        let mut k = 0;
        while k < 3 {
            (origins[k][i], directions[k][i]) = (origin[k], direction[k]);
            k += 1;
        }
        (limits[0][i], limits[1][i]) = (first, last);
        i += 1;
    }
    (origins, directions, limits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::{Instructions, Kernel};
    use crate::math::random::Random;
    use crate::mesh::shapes;
    use glam::DVec3;

    struct Volleys<'r>(&'r Tree, &'r [Ray], &'r mut [Ready; WIDTH]);

    impl Kernel for Volleys<'_> {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) {
            make_ready(lanes, self.0, self.1, self.2);
        }
    }

    struct OneByOne<'r>(&'r Tree, &'r Ray, &'r mut Ready);

    impl Kernel for OneByOne<'_> {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) {
            self.2.beam.follow(self.0.unit(), self.1);
            self.2.meet_root(lanes, &self.0.nodes()[0]);
        }
    }

    fn bits(ready: &Ready) -> ([u64; 3], [u32; 10], Option<[u32; WIDTH]>, u32) {
        let Beam {
            shaft,
            from,
            to,
            entry,
            unit,
            slack,
            margin,
        } = ready.beam;
        let ([x, y, z], [u, v, w]) = (shaft.origin, shaft.direction);
        // Of one that misses the cube nothing else is read.
        let enter = (to >= 0.0).then(|| ready.enter.map(f32::to_bits));
        let numbers = [x, y, z, u, v, w, shaft.slop, from, to, margin].map(f32::to_bits);
        (
            [entry, unit, slack].map(f64::to_bits),
            numbers,
            enter,
            if to >= 0.0 { ready.entered } else { 0 },
        )
    }

    /// Near and far, long and short, along axes and planes, segments and limits.
    #[test]
    fn eight_rays_at_once_are_those_one_by_one() {
        let mut random = Random::new(5);
        let mut number = move || random.fraction() * 2.0 - 1.0;
        let tree = Tree::new(shapes::torus_knot(2, 3, 0.2, 30));
        let mut rays = alloc::vec::Vec::new();
        for far in [0.5, 3.0, 1e3, 1e12, 1e200] {
            for length in [1.0, 1e-9, 1e40, 1e-80, 1e200] {
                for i in 0..11 {
                    let mut vector = || DVec3::new(number(), number(), number());
                    let (origin, mut direction) = (vector() * far, vector() * length);
                    if i % 3 == 0 {
                        direction[i % 2] = 0.0;
                    }
                    if i % 5 == 0 {
                        direction = (DVec3::splat(0.1) - origin) * length;
                    }
                    rays.extend(
                        Ray::new(origin, direction)
                            .map(|ray| ray.within(0.0, [0.7, f64::INFINITY][i % 2])),
                    );
                    rays.extend(
                        Ray::segment(origin, direction).map(|ray| ray.within(number(), 2.0)),
                    );
                }
            }
        }
        for instructions in [Instructions::detect(), Instructions::PORTABLE] {
            for eight in rays.chunks(WIDTH) {
                let mut ready = [Ready::NONE; WIDTH];
                instructions.run(Volleys(&tree, eight, &mut ready));
                for (ray, ready) in eight.iter().zip(&ready) {
                    let mut one = Ready::NONE;
                    instructions.run(OneByOne(&tree, ray, &mut one));
                    assert_eq!(bits(ready), bits(&one), "{ray:?}");
                }
            }
        }
    }
}
