//! Relative pose of B in A for a query, and the map between the orientations of two nodes.

use crate::tree::{Node, Tree, Unit, power_of_two};
use core::ops::{Add, Mul, Neg, Sub};
use glam::{DMat3, DVec3};
use punctual_geom::Pose;
use punctual_geom::lanes::{Column, F8, Lanes, dot, per_axis};
use punctual_geom::largest;
use punctual_geom::rotation_deviation;
use punctual_geom::tolerance::ROUNDING;
use punctual_geom::triangle::batch::{EDGE_ERROR, LEAST_EDGE_ERROR, Placement};
use wide::f32x4;

/// An entry for each axis and a fourth of 0, or two such vectors in halves.
pub(super) trait Entries:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// Entry `k` in all lanes. By reference, because an argument passed by value goes through
    /// integer registers.
    fn spread(&self, k: usize) -> Self;
    fn abs(self) -> Self;
    /// Entries 1, 2, 0; and entries 2, 0, 1.
    fn yzx(self) -> Self;
    fn zxy(self) -> Self;
    fn transposed(columns: [Self; 3]) -> [Self; 3];
}

impl Entries for f32x4 {
    #[inline(always)]
    fn spread(&self, k: usize) -> Self {
        Self::splat(self.as_array()[k])
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn yzx(self) -> Self {
        let [x, y, z, w] = self.to_array();
        Self::new([y, z, x, w])
    }

    #[inline(always)]
    fn zxy(self) -> Self {
        let [x, y, z, w] = self.to_array();
        Self::new([z, x, y, w])
    }

    #[inline(always)]
    fn transposed([x, y, z]: [Self; 3]) -> [Self; 3] {
        let [x, y, z, _] = Self::transpose([x, y, z, Self::ZERO]);
        [x, y, z]
    }
}

impl<L: Lanes> Entries for F8<L> {
    #[inline(always)]
    fn spread(&self, k: usize) -> Self {
        F8::spread(*self, k)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Column::abs(self)
    }

    #[inline(always)]
    fn yzx(self) -> Self {
        self.turned()
    }

    #[inline(always)]
    fn zxy(self) -> Self {
        self.turned().turned()
    }

    #[inline(always)]
    fn transposed(columns: [Self; 3]) -> [Self; 3] {
        Self::transposed_axes(columns)
    }
}

/// Three columns of a matrix; the fourth lane is 0.
type Columns<V> = [V; 3];

/// The relative pose of B in A, with each number in all lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Row by row.
    rotation: [[f32x4; 3]; 3],
    translation: [f32x4; 3],
    /// Margins of a test of two boxes, in the orientation of A's node and in that of B's.
    pub margin: [f32x4; 2],
}

impl Place {
    /// For a pose out of the range of `f32`.
    const BLIND: Self = Self {
        rotation: [[f32x4::ZERO; 3]; 3],
        translation: [f32x4::ZERO; 3],
        margin: [f32x4::splat(1e6); 2],
    };

    /// From the vector from the middle of A's box to that of B's, in A's units, and its error bound
    /// `position_error`. `deviation` is that of B's matrix from a rotation.
    fn new(
        scale: f64,
        pose: &Pose,
        translation: DVec3,
        distance: f64,
        position_error: f64,
        deviation: f64,
    ) -> Option<Self> {
        let u = f64::from(ROUNDING);
        let margin_a = u * (32.0 + 192.0 * scale + 32.0 * distance) + position_error;
        let margin_b =
            u * (192.0 + 32.0 * scale + 32.0 * distance) + position_error + 8.0 * deviation * scale;
        (margin_a < 1e6 && margin_b < 1e6 * scale).then(|| Self {
            rotation: pose
                .rotation()
                .transpose()
                .to_cols_array_2d()
                .map(|row| row.map(rounded)),
            translation: translation.to_array().map(rounded),
            margin: [f32x4::splat(margin_a as f32), f32x4::splat(margin_b as f32)],
        })
    }

    /// The larger margins of two places, in the orientation of A's node and in that of B's.
    fn margins(&self, other: &Self) -> [f32; 2] {
        let [in_a, in_b] = [0, 1].map(|k| self.margin[k].fast_max(other.margin[k]).as_array()[0]);
        [in_a, in_b]
    }

    /// Combines this place and another.
    pub fn and(&self, other: &Self) -> Places {
        let both = |x: f32x4, y: f32x4| {
            let (x, y) = (x.as_array()[0], y.as_array()[0]);
            [x, x, x, x, y, y, y, y]
        };
        Places {
            rotation: per_axis!(j => per_axis!(i => both(self.rotation[i][j], other.rotation[i][j]))),
            translation: per_axis!(k => both(self.translation[k], other.translation[k])),
            margin: self.margins(other),
        }
    }

    /// The axes of a node of B in A, row by row.
    #[inline(always)]
    fn rows(&self, of_b: &[f32x4; 3]) -> [f32x4; 3] {
        per_axis!(i => combined(self.rotation[i], of_b))
    }
}

/// The poses of B in A at two times: each number four times for the first and four times for the
/// second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    /// Column by column.
    rotation: [[[f32; 8]; 3]; 3],
    translation: [[f32; 8]; 3],
    /// The larger of the margins at both times.
    pub margin: [f32; 2],
}

/// The relative pose of B in A, in the unit coordinates of both, with bounds on all rounding. Boxes
/// of both are compared in A's units.
#[derive(Clone, Copy, Debug)]
pub(super) struct RelativePose {
    pub place: Place,
    /// Length of A's unit, in the length unit of the meshes.
    pub unit: f64,
    /// Length of B's unit in A's units: a power of two.
    pub scale: f32,
    /// Error bound of a direction, of either side, relative to its length.
    pub rotation_error: f32,
    /// Deviation of B's matrix from a rotation.
    deviation: f64,
    /// Factor for the square of a gap: [`super::gaps::Gaps::shrink`].
    pub shrink: f32,
    /// Boxes in doubt have at least this gap in `f32`. A smaller gap is often only rounding of 0.
    pub least_gap: f32x4,
    pub triangles: Placement,
}

/// If the ratio of the units of two meshes is a larger power of two than this, every box counts as
/// overlapping: products of three lengths must stay within the range of `f32`.
const LARGEST_SCALE: i32 = 30;

/// The least gap of boxes in doubt, relative to their margin.
const LEAST_GAP: f32 = 1.0 / 64.0;

/// The vector from the middle of A's box to that of B's, in A's units, and its error bound.
/// `per_unit` is the inverse of A's unit.
fn offset([a, b]: [&Unit; 2], b_in_a: &Pose, scale: f64, per_unit: f64) -> (DVec3, f64) {
    let translation = (b_in_a.transform_point(b.origin) - a.origin) * per_unit;
    (
        translation,
        rounding(a, b, b_in_a) * per_unit + (1.0 + scale) * power_of_two(-43) + 1e-20,
    )
}

impl RelativePose {
    pub fn new(a: &Tree, b: &Tree, b_in_a: &Pose) -> Self {
        let (ua, ub) = (a.unit(), b.unit());
        let [of_a, of_b] = Unit::exponents([ua, ub]);
        let exponent = of_b - of_a;
        let per_unit = power_of_two(-of_a);
        let scale = power_of_two(exponent.clamp(-1000, 1000));
        let (translation, position_error) = offset([ua, ub], b_in_a, scale, per_unit);
        let deviation = rotation_deviation(b_in_a.rotation());

        let distance = translation.length();
        let place = Place::new(
            scale,
            b_in_a,
            translation,
            distance,
            position_error,
            deviation,
        )
        .filter(|_| exponent.abs() <= LARGEST_SCALE);
        let Some(place) = place else {
            return Self {
                unit: power_of_two(of_a),
                ..Self::BLIND
            };
        };
        let [margin_a, margin_b] = place.margin.map(|margin| margin.as_array()[0]);
        let rows = b_in_a.rotation().transpose();
        let linear = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| (row * scale).to_array());
        Self {
            place,
            unit: power_of_two(of_a),
            scale: scale as f32,
            rotation_error: 224.0 * ROUNDING + 16.0 * deviation as f32,
            deviation,
            shrink: 1.0 - 64.0 * ROUNDING - 4.0 * deviation as f32,
            least_gap: f32x4::splat(margin_a.min(margin_b) * LEAST_GAP),
            triangles: Placement {
                linear,
                translation: translation.to_array(),
                rotation: linear.map(|row| row.map(|x| x as f32)),
                position_error: position_error as f32,
                edge_slop: (8.0 * EDGE_ERROR * scale as f32).max(LEAST_EDGE_ERROR),
            },
        }
    }

    /// The pose of B at another time of the same motion.
    pub fn place_at(&self, [a, b]: [&Tree; 2], b_in_a: &Pose) -> Place {
        let scale = f64::from(self.scale);
        let (translation, position_error) =
            offset([a.unit(), b.unit()], b_in_a, scale, 1.0 / self.unit);
        // Upper bound of its length, without a root.
        let distance = translation.abs().element_sum();
        Place::new(
            scale,
            b_in_a,
            translation,
            distance,
            position_error,
            self.deviation,
        )
        .unwrap_or(Place::BLIND)
    }

    /// `least_gap` minus the margin, which is negative.
    pub fn least_gap_and_margin(&self) -> f32 {
        let [a, b] = self.place.margin.map(|margin| margin.as_array()[0]);
        self.least_gap.as_array()[0] - a.min(b)
    }

    /// The vector from the middle of A's box to that of B's, in A's units.
    pub fn middle(&self) -> DVec3 {
        self.triangles.translation.into()
    }

    /// The linear part of B's pose.
    pub fn linear(&self) -> DMat3 {
        DMat3::from_cols_array_2d(&self.triangles.linear).transpose()
    }

    /// A direction in A's unit coordinates, mapped for points in B's, and the offset of B's
    /// position along it.
    pub fn of_b(&self, direction: f32x4) -> (f32x4, f32) {
        let Place {
            rotation,
            translation,
            ..
        } = &self.place;
        let along = per_axis!(k => direction.spread(k));
        let [x, y, z] = per_axis!(k => (translation[k] * along[k]).as_array()[0]);
        let of_b = transposed(per_axis!(j => combined(along, &per_axis!(k => rotation[k][j]))));
        (of_b[0] * f32x4::splat(self.scale), x + y + z)
    }

    /// For what is out of the range of `f32`: every box overlaps and every triangle pair is in
    /// doubt.
    pub const BLIND: Self = Self {
        place: Place::BLIND,
        unit: 1.0,
        scale: 1.0,
        rotation_error: 1.0,
        deviation: 1.0,
        shrink: 0.0,
        least_gap: f32x4::splat(1e6),
        triangles: Placement {
            linear: [[0.0; 3]; 3],
            translation: [0.0; 3],
            rotation: [[0.0; 3]; 3],
            position_error: 1e6,
            edge_slop: 1e6,
        },
    };
}

/// Bound on the rounding of a placed vertex of B (`v' = R v + t` in `f64`) and of values computed
/// from it relative to A, in the length unit of the meshes. If a pose cancels, small coordinates
/// have the rounding of large ones.
pub(super) fn rounding(a: &Unit, b: &Unit, b_in_a: &Pose) -> f64 {
    let reach = |v: DVec3| largest(v.abs());
    let magnitude =
        reach(a.origin) + 6.0 * reach(b.origin) + reach(b_in_a.translation()) + 8.0 * b.length();
    magnitude * f64::EPSILON * 8.0
}

fn rounded(x: f64) -> f32x4 {
    f32x4::splat(x as f32)
}

/// The map of one side into the orientation of a node of the other. A box with centre `c` and half
/// extents `h`, in A's units, lies within `columns c + origin ± (|columns| h + margin)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<V = f32x4> {
    pub columns: Columns<V>,
    pub origin: V,
    pub margin: V,
}

impl<L: Lanes> View<F8<L>> {
    /// The view of B from A at two poses at once, one in each half: few more operations than for
    /// one.
    #[inline(always)]
    pub fn at_both(lanes: L, a: &Node, b: &Node, places: &Places) -> Self {
        let rows = per_axis!(i => F8::twice(lanes, a.rows[i]));
        // Factors from memory: spreading entries of registers takes as long as a product.
        let turned =
            per_axis!(j => dot(rows, per_axis!(i => F8::load(lanes, &places.rotation[j][i]))));
        Self {
            columns: per_axis!(k => dot(turned, per_axis!(j => F8::splat(lanes, b.rows[j].as_array()[k])))),
            origin: dot(
                rows,
                per_axis!(i => F8::load(lanes, &places.translation[i])),
            ),
            margin: F8::splat(lanes, places.margin[0]),
        }
    }

    /// The view of A from B.
    #[inline(always)]
    pub fn inverse(&self, lanes: L, margin: f32) -> Self {
        let columns = transposed(self.columns);
        Self {
            columns,
            origin: -times(&columns, self.origin),
            margin: F8::splat(lanes, margin),
        }
    }

    /// The view at the first of two poses.
    #[inline(always)]
    fn first(&self) -> View {
        let columns = per_axis!(k => self.columns[k].halves()[0]);
        View {
            columns,
            origin: self.origin.halves()[0],
            margin: self.margin.halves()[0],
        }
    }

    #[inline(always)]
    fn store(&self) -> View<[f32; 8]> {
        let columns = per_axis!(k => self.columns[k].store());
        View {
            columns,
            origin: self.origin.store(),
            margin: self.margin.store(),
        }
    }
}

impl View<[f32; 8]> {
    const NONE: Self = Self {
        columns: [[0.0; 8]; 3],
        origin: [0.0; 8],
        margin: [0.0; 8],
    };

    #[inline(always)]
    pub fn load<L: Lanes>(&self, lanes: L) -> View<F8<L>> {
        let columns = per_axis!(k => F8::load(lanes, &self.columns[k]));
        View {
            columns,
            origin: F8::load(lanes, &self.origin),
            margin: F8::load(lanes, &self.margin),
        }
    }

    /// The view at the second of two poses.
    fn second(&self) -> View {
        let half = |[.., x, y, z, w]: [f32; 8]| f32x4::new([x, y, z, w]);
        View {
            columns: self.columns.map(half),
            origin: half(self.origin),
            margin: half(self.margin),
        }
    }
}

impl<V: Entries> View<V> {
    /// Maps a point to the other side.
    #[inline(always)]
    pub fn point(&self, x: V) -> V {
        self.vector(x) + self.origin
    }

    /// Maps a vector to the other side.
    #[inline(always)]
    pub fn vector(&self, x: V) -> V {
        times(&self.columns, x)
    }

    /// The half extents of a box on the other side, widened by the margin.
    #[inline(always)]
    pub fn half(&self, h: V) -> V {
        self.size(h) + self.margin
    }

    /// The half extents of a box on the other side, without the margin.
    #[inline(always)]
    pub fn size(&self, h: V) -> V {
        times(&per_axis!(k => self.columns[k].abs()), h)
    }
}

impl View {
    /// Gap between a box, mapped to the other side, and a box there, along each axis. Both by
    /// centre and half extents, without the margin.
    #[inline(always)]
    pub fn gaps(&self, seen: (f32x4, f32x4), other: (f32x4, f32x4)) -> f32x4 {
        (self.point(seen.0) - other.0).abs() - (self.size(seen.1) + other.1)
    }
}

#[inline(always)]
fn times<V: Entries>(columns: &Columns<V>, x: V) -> V {
    combined(per_axis!(k => x.spread(k)), columns)
}

#[inline(always)]
fn combined<V: Entries>([x, y, z]: [V; 3], vectors: &[V; 3]) -> V {
    x * vectors[0] + y * vectors[1] + z * vectors[2]
}

#[inline(always)]
fn transposed<V: Entries>(columns: Columns<V>) -> Columns<V> {
    V::transposed(columns)
}

#[inline(always)]
pub(super) fn cross(a: f32x4, b: f32x4) -> f32x4 {
    a.yzx() * b.zxy() - a.zxy() * b.yzx()
}

/// The map between the orientations of a node of A and one of B, in both directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Views<V = f32x4> {
    /// The view of A from B.
    pub of_a: View<V>,
    /// The view of B from A.
    pub of_b: View<V>,
}

impl<L: Lanes> Views<F8<L>> {
    /// The views at the first of two poses.
    #[inline(always)]
    pub fn first(&self) -> Views {
        Views {
            of_a: self.of_a.first(),
            of_b: self.of_b.first(),
        }
    }

    #[inline(always)]
    pub fn store(&self) -> Views<[f32; 8]> {
        Views {
            of_a: self.of_a.store(),
            of_b: self.of_b.store(),
        }
    }
}

impl Views<[f32; 8]> {
    /// Placeholder before any views are computed.
    pub const NONE: Self = Self {
        of_a: View::NONE,
        of_b: View::NONE,
    };

    /// The views at the second of two poses.
    pub fn second(&self) -> Views {
        Views {
            of_a: self.of_a.second(),
            of_b: self.of_b.second(),
        }
    }
}

impl Views {
    #[inline(always)]
    pub fn between(a: &Node, b: &Node, relative: &RelativePose) -> Self {
        let (place, in_a) = (&relative.place, relative.place.rows(&b.rows));
        let rows = per_axis!(i => combined(per_axis!(k => a.rows[k].spread(i)), &in_a));
        let origin = combined(place.translation, &a.rows);
        Self {
            of_b: View {
                columns: transposed(rows),
                origin,
                margin: place.margin[0],
            },
            of_a: View {
                columns: rows,
                origin: -times(&rows, origin),
                margin: place.margin[1],
            },
        }
    }

    /// A direction in A's unit coordinates, mapped to the orientation of `a` and to that of the
    /// other node.
    #[inline(always)]
    pub fn direction(&self, a: &Node, direction: f32x4) -> (f32x4, f32x4) {
        let in_a = times(&a.rows, direction);
        (in_a, times(&self.of_a.columns, in_a))
    }

    /// The view of triangles of A's mesh, or of B's, in the units of that mesh, from the
    /// orientation of a node of the other.
    #[inline(always)]
    pub fn triangles(&self, of_a: bool, other: &Node, place: &Place, scale: f32) -> View {
        if of_a {
            return View {
                columns: place.rows(&other.rows),
                ..self.of_a
            };
        }
        let scale = f32x4::splat(scale);
        View {
            columns: per_axis!(j => combined(per_axis!(i => place.rotation[i][j]), &other.rows) * scale),
            ..self.of_b
        }
    }
}
