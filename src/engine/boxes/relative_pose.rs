//! Relative pose of B in A for a query, and the map between the orientations of two nodes.

use crate::tree::{Node, Tree, Unit, power_of_two};
use glam::{DMat3, DVec3};
use punctual_geom::Pose;
use punctual_geom::lanes::per_axis;
use punctual_geom::largest;
use punctual_geom::rotation_deviation;
use punctual_geom::tolerance::ROUNDING;
use punctual_geom::triangle::batch::{EDGE_ERROR, LEAST_EDGE_ERROR, Placement};
use wide::f32x4;

/// The operations of a vector with an entry for each axis and a fourth of 0.
pub(crate) trait Entries {
    /// Entry `k` in all lanes. By reference, because an argument passed by value goes through
    /// integer registers.
    fn spread(&self, k: usize) -> Self;
    /// Entries 1, 2, 0; and entries 2, 0, 1.
    fn yzx(self) -> Self;
    fn zxy(self) -> Self;
}

impl Entries for f32x4 {
    #[inline(always)]
    fn spread(&self, k: usize) -> Self {
        Self::splat(self.as_array()[k])
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
}

/// Three columns of a matrix; the fourth lane is 0.
type Columns = [f32x4; 3];

/// The relative pose of B in A, in the unit coordinates of both, with bounds on all rounding. Boxes
/// of both are compared in A's units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RelativePose {
    /// Row by row, each number in all lanes.
    rotation: [[f32x4; 3]; 3],
    /// The vector from the middle of A's box to that of B's, each number in all lanes.
    translation: [f32x4; 3],
    /// Margins of a test of two boxes, in the orientation of A's node and in that of B's.
    pub margin: [f32x4; 2],
    /// Length of A's unit, in the length unit of the meshes.
    pub unit: f64,
    /// Length of B's unit in A's units: a power of two.
    pub scale: f32,
    /// Error bound of a direction, of either side, relative to its length.
    pub rotation_error: f32,
    /// Factor for the square of a gap: `Gaps::shrink` of the distance.
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

impl RelativePose {
    pub fn new(a: &Tree, b: &Tree, b_in_a: &Pose) -> Self {
        Self::within(a, b, b_in_a, 0.0)
    }

    /// [`RelativePose::new`] for surfaces whose vertices are off by up to `reach`, in the length
    /// unit of the meshes.
    pub fn within(a: &Tree, b: &Tree, b_in_a: &Pose, reach: f64) -> Self {
        let (ua, ub) = (a.unit(), b.unit());
        let [of_a, of_b] = Unit::exponents([ua, ub]);
        let exponent = of_b - of_a;
        let per_unit = power_of_two(-of_a);
        let scale = power_of_two(exponent.clamp(-1000, 1000));
        let translation = (b_in_a.transform_point(ub.origin) - ua.origin) * per_unit;
        let position_error = (rounding(ua, ub, b_in_a) + reach) * per_unit
            + (1.0 + scale) * power_of_two(-43)
            + 1e-20;
        let deviation = rotation_deviation(b_in_a.rotation());
        let (u, distance) = (f64::from(ROUNDING), translation.length());
        let margin_a = u * (32.0 + 192.0 * scale + 32.0 * distance) + position_error;
        let margin_b =
            u * (192.0 + 32.0 * scale + 32.0 * distance) + position_error + 8.0 * deviation * scale;
        // Also false for NaN.
        let is_in_range =
            margin_a < 1e6 && margin_b < 1e6 * scale && exponent.abs() <= LARGEST_SCALE;
        if !is_in_range {
            return Self {
                unit: power_of_two(of_a),
                ..Self::BLIND
            };
        }
        let (margin_a, margin_b) = (margin_a as f32, margin_b as f32);
        let rows = b_in_a.rotation().transpose();
        let linear = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| (row * scale).to_array());
        Self {
            rotation: rows.to_cols_array_2d().map(|row| row.map(rounded)),
            translation: translation.to_array().map(rounded),
            margin: [f32x4::splat(margin_a), f32x4::splat(margin_b)],
            unit: power_of_two(of_a),
            scale: scale as f32,
            rotation_error: 224.0 * ROUNDING + 16.0 * deviation as f32,
            shrink: 1.0 - 64.0 * ROUNDING - 4.0 * deviation as f32,
            least_gap: f32x4::splat(margin_a.min(margin_b) * LEAST_GAP),
            triangles: Placement {
                linear,
                translation: translation.to_array(),
                rotation: linear.map(|row| row.map(|x| x as f32)),
                position_error: position_error as f32,
                edge_error: (8.0 * EDGE_ERROR * scale as f32).max(LEAST_EDGE_ERROR),
            },
        }
    }

    /// `least_gap` minus the margin, which is negative.
    pub fn least_gap_and_margin(&self) -> f32 {
        let [a, b] = self.margin.map(|margin| margin.as_array()[0]);
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

    /// Maps a direction in A's unit coordinates to B's, for products with points of B; and the
    /// offset of B's origin along the direction, in A's units.
    pub fn of_b(&self, direction: f32x4) -> (f32x4, f32) {
        let Self {
            rotation,
            translation,
            ..
        } = self;
        let along = per_axis!(k => direction.spread(k));
        let [x, y, z] = per_axis!(k => (translation[k] * along[k]).as_array()[0]);
        let of_b = transposed(per_axis!(j => combined(along, &per_axis!(k => rotation[k][j]))));
        (of_b[0] * f32x4::splat(self.scale), x + y + z)
    }

    /// The axes of a node of B in A, row by row.
    #[inline(always)]
    fn rows(&self, of_b: &[f32x4; 3]) -> [f32x4; 3] {
        per_axis!(i => combined(self.rotation[i], of_b))
    }

    /// For poses and units out of the range of `f32`: every box overlaps and every triangle pair is
    /// in doubt.
    pub const BLIND: Self = Self {
        rotation: [[f32x4::ZERO; 3]; 3],
        translation: [f32x4::ZERO; 3],
        margin: [f32x4::splat(1e6); 2],
        unit: 1.0,
        scale: 1.0,
        rotation_error: 1.0,
        shrink: 0.0,
        least_gap: f32x4::splat(1e6),
        triangles: Placement {
            linear: [[0.0; 3]; 3],
            translation: [0.0; 3],
            rotation: [[0.0; 3]; 3],
            position_error: 1e6,
            edge_error: 1e6,
        },
    };
}

/// Bound on the rounding of a placed vertex of B (`v' = R v + t` in `f64`) and of values computed
/// from it relative to A, in the length unit of the meshes. If a pose cancels, small coordinates
/// have the rounding of large ones.
pub(crate) fn rounding(a: &Unit, b: &Unit, b_in_a: &Pose) -> f64 {
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
pub(crate) struct View {
    pub columns: Columns,
    pub origin: f32x4,
    pub margin: f32x4,
}

impl View {
    /// Maps a point to the other side.
    #[inline(always)]
    pub fn point(&self, x: f32x4) -> f32x4 {
        self.vector(x) + self.origin
    }

    /// Maps a vector to the other side.
    #[inline(always)]
    pub fn vector(&self, x: f32x4) -> f32x4 {
        times(&self.columns, x)
    }

    /// The half extents of a box on the other side, widened by the margin.
    #[inline(always)]
    pub fn half(&self, h: f32x4) -> f32x4 {
        self.size(h) + self.margin
    }

    /// The half extents of a box on the other side, without the margin.
    #[inline(always)]
    pub fn size(&self, h: f32x4) -> f32x4 {
        times(&per_axis!(k => self.columns[k].abs()), h)
    }

    /// Gap between a box, mapped to the other side, and a box there, along each axis. Both by
    /// centre and half extents, without the margin.
    #[inline(always)]
    pub fn gaps(&self, seen: (f32x4, f32x4), other: (f32x4, f32x4)) -> f32x4 {
        (self.point(seen.0) - other.0).abs() - (self.size(seen.1) + other.1)
    }
}

#[inline(always)]
fn times(columns: &Columns, x: f32x4) -> f32x4 {
    combined(per_axis!(k => x.spread(k)), columns)
}

#[inline(always)]
fn combined([x, y, z]: [f32x4; 3], vectors: &[f32x4; 3]) -> f32x4 {
    x * vectors[0] + y * vectors[1] + z * vectors[2]
}

#[inline(always)]
fn transposed([x, y, z]: Columns) -> Columns {
    let [x, y, z, _] = f32x4::transpose([x, y, z, f32x4::ZERO]);
    [x, y, z]
}

#[inline(always)]
pub(crate) fn cross(a: f32x4, b: f32x4) -> f32x4 {
    a.yzx() * b.zxy() - a.zxy() * b.yzx()
}

/// The map between the orientations of a node of A and one of B, in both directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Views {
    /// The view of A from B.
    pub of_a: View,
    /// The view of B from A.
    pub of_b: View,
}

impl Views {
    #[inline(always)]
    pub fn between(a: &Node, b: &Node, relative: &RelativePose) -> Self {
        let in_a = relative.rows(&b.rows);
        let rows = per_axis!(i => combined(per_axis!(k => a.rows[k].spread(i)), &in_a));
        let origin = combined(relative.translation, &a.rows);
        Self {
            of_b: View {
                columns: transposed(rows),
                origin,
                margin: relative.margin[0],
            },
            of_a: View {
                columns: rows,
                origin: -times(&rows, origin),
                margin: relative.margin[1],
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
    pub fn triangles(&self, of_a: bool, other: &Node, relative: &RelativePose) -> View {
        if of_a {
            return View {
                columns: relative.rows(&other.rows),
                ..self.of_a
            };
        }
        let scale = f32x4::splat(relative.scale);
        View {
            columns: per_axis!(j => combined(per_axis!(i => relative.rotation[i][j]), &other.rows) * scale),
            ..self.of_b
        }
    }
}
