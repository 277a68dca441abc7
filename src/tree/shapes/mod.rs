//! Trees of shapes with a formula: those with a radius, boxes, prisms, hulls, height fields.

pub(crate) mod hull;

use crate::mesh::{Mesh, MeshError};
use crate::tree::{BuildOptions, Solid, Tree};
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};
use core::fmt;
use core::ops::RangeInclusive;
use glam::DVec3;
use hull::hull;

/// Sides of the prism around a cylinder and of the pyramid around a cone.
const SIDES: u32 = 128;

/// No point of the tree of a cylinder or a cone is farther than this times the radius from the true
/// shape, which is inside: `1 / cos(pi / 128) - 1`, rounded up.
pub const ROUND_BAND: f64 = 3.0128e-4;

/// More than the rounding of corners around a circle, relative to its radius.
const SLACK: f64 = 1e-12;

/// Lengths of shapes. Their squares and products are normal numbers.
const LENGTHS: RangeInclusive<f64> = 1e-150..=1e150;

/// Reasons why a shape is refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ShapeError {
    /// A length is out of range or NaN.
    Length {
        /// The argument, with the index if it has several lengths.
        argument: &'static str,
        /// The given value.
        value: f64,
        /// The least value allowed.
        least: f64,
        /// The largest value allowed.
        most: f64,
    },
    /// A height field needs two columns and two rows or more, and all rows whole.
    Columns {
        /// Number of columns.
        columns: usize,
        /// Number of heights.
        heights: usize,
    },
    /// The points of a hull lie in one plane, or there are none.
    Flat {
        /// Number of points.
        points: usize,
    },
    /// A point or a height is not finite or too large, or there are too many.
    Mesh(MeshError),
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length {
                argument,
                value,
                least,
                most,
            } => write!(f, "{argument} is {value:?}, must be {least:?} to {most:?}"),
            Self::Columns { columns, heights } => write!(
                f,
                "{heights} heights in {columns} columns, must be two whole rows and columns or more"
            ),
            Self::Flat { points } => {
                write!(f, "the {points} points of the hull lie in one plane")
            }
            Self::Mesh(fault) => fault.fmt(f),
        }
    }
}

impl core::error::Error for ShapeError {}

impl From<MeshError> for ShapeError {
    fn from(fault: MeshError) -> Self {
        Self::Mesh(fault)
    }
}

/// Shapes. All but the height field are solids. Lengths are 1e-150 to 1e150 in the unit of the
/// coordinates, and 0 where a function says so; other lengths are [`ShapeError::Length`].
impl Tree {
    /// A ball around the origin: a point with a [radius](Self::with_radius).
    ///
    /// ```
    /// use punctual::{Budget, Pose, Query, Tree, Workspace, glam::DMat3};
    /// let (ball, block) = (Tree::ball(0.5)?, Tree::cuboid([2.0, 2.0, 1.0])?);
    /// let pose = Pose::new(DMat3::IDENTITY, [0.3, 0.2, 1.75])?;
    /// let query = Query::distance(&block, &ball, pose);
    /// let found = query.run(&mut Workspace::new(), Budget::unlimited()).value;
    /// assert!((found.high - 0.75).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ShapeError::Length`].
    pub fn ball(radius: f64) -> Result<Self, ShapeError> {
        check([("radius", radius)], LENGTHS)?;
        thickened(&[[0.0; 3]], &[[0; 3]], radius)
    }

    /// All points no farther than `radius` from a segment of this length along z, whose middle is
    /// the origin. The length may be 0.
    ///
    /// # Errors
    /// [`ShapeError::Length`].
    pub fn capsule(radius: f64, length: f64) -> Result<Self, ShapeError> {
        check([("radius", radius)], LENGTHS)?;
        check([("length", length)], 0.0..=*LENGTHS.end())?;
        let half = length / 2.0;
        let ends = [[0.0, 0.0, -half], [0.0, 0.0, half]];
        thickened(&ends, &[[0, 1, 1]], radius)
    }

    /// A box around the origin with these lengths along x, y and z: 12 triangles. Exact.
    ///
    /// # Errors
    /// [`ShapeError::Length`].
    pub fn cuboid(size: impl Into<[f64; 3]>) -> Result<Self, ShapeError> {
        let size = size.into();
        check(SIZE.into_iter().zip(size), LENGTHS)?;
        block(DVec3::from_array(size) / 2.0, 0.0)
    }

    /// A box around the origin with rounded edges: all points no farther than `radius` from a
    /// smaller box. `size` is the outer one, and at least the diameter along each axis. The radius
    /// may be 0. Exact but for one rounding of the smaller box.
    ///
    /// # Errors
    /// [`ShapeError::Length`].
    pub fn rounded_cuboid(size: impl Into<[f64; 3]>, radius: f64) -> Result<Self, ShapeError> {
        let size = size.into();
        check(SIZE.into_iter().zip(size), LENGTHS)?;
        let half = DVec3::from_array(size) / 2.0;
        check([("radius", radius)], 0.0..=half.min_element())?;
        block(half - radius, radius)
    }

    /// A cylinder along z, its middle in the origin: a prism of 128 sides around it, within
    /// [`ROUND_BAND`] times the radius. What is free of the prism is free of the cylinder.
    ///
    /// # Errors
    /// [`ShapeError::Length`].
    pub fn cylinder(radius: f64, length: f64) -> Result<Self, ShapeError> {
        turned(radius, length, false)
    }

    /// A cone along z: its base has this radius and lies at `-length / 2`, its tip at `length / 2`.
    /// A pyramid of 128 sides around it, within [`ROUND_BAND`] times the radius.
    ///
    /// # Errors
    /// [`ShapeError::Length`].
    pub fn cone(radius: f64, length: f64) -> Result<Self, ShapeError> {
        turned(radius, length, true)
    }

    /// The convex hull of points, exact: its vertices are points that were given, in that order,
    /// and none is outside by the exact sign. Usually `O(n log n)`, `O(n^2)` at worst.
    ///
    /// ```
    /// use punctual::{Tree, shapes};
    /// let torus = shapes::torus(1.0, 0.3, 32);
    /// let hull = Tree::hull((0..torus.vertex_count()).map(|i| torus.vertex(i)))?;
    /// let volume = hull.mass_properties()?.volume;
    /// assert!(volume > Tree::cylinder(1.0, 0.6)?.mass_properties()?.volume);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ShapeError::Mesh`] names the first point at fault as a vertex; [`ShapeError::Flat`].
    pub fn hull(points: impl IntoIterator<Item: Into<[f64; 3]>>) -> Result<Self, ShapeError> {
        let cloud = Mesh::from_points_f64(points)?;
        let points: Vec<DVec3> = (0..cloud.len()).map(|i| cloud.vertex(i)).collect();
        let mut triangles = hull(&points).ok_or(ShapeError::Flat {
            points: points.len(),
        })?;
        let mut used: Vec<u32> = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        for vertex in triangles.as_flattened_mut() {
            *vertex = used.partition_point(|other| other < vertex) as u32;
        }
        let vertices: Vec<_> = used.iter().map(|&i| points[i as usize].into()).collect();
        thickened(&vertices, &triangles, 0.0)
    }

    /// The surface over a grid, which faces +z. Height `i` is that of vertex `i`, at
    /// `x = spacing[0] * (i % columns)`, `y = spacing[1] * (i / columns)`; each cell is cut from
    /// its least corner to its largest.
    ///
    /// # Errors
    /// [`ShapeError::Columns`]; [`ShapeError::Length`] for the spacing; [`ShapeError::Mesh`] names
    /// the first height at fault as a vertex.
    pub fn height_field(
        heights: impl IntoIterator<Item: Into<f64>>,
        columns: usize,
        spacing: [f64; 2],
    ) -> Result<Self, ShapeError> {
        check(
            ["spacing[0]", "spacing[1]"].into_iter().zip(spacing),
            LENGTHS,
        )?;
        let heights: Vec<f64> = heights.into_iter().map(Into::into).collect();
        let is_whole = columns >= 2 && heights.len().is_multiple_of(columns);
        if !is_whole || heights.len() / columns < 2 {
            let heights = heights.len();
            return Err(ShapeError::Columns { columns, heights });
        }
        // Also refuses more vertices than an index can name.
        Mesh::from_points_f64(heights.iter().map(|&height| [0.0, 0.0, height]))?;
        let vertex = |(i, &height): (usize, &f64)| {
            let [x, y] = [(i % columns, spacing[0]), (i / columns, spacing[1])]
                .map(|(count, step)| count as f64 * step);
            [x, y, height]
        };
        let cell = |i: usize| {
            let [a, b] = [i as u32, (i + columns) as u32];
            [[a, a + 1, b + 1], [a, b + 1, b]]
        };
        let cells = (0..heights.len() - columns).filter(|i| i % columns + 1 < columns);
        let vertices = heights.iter().enumerate().map(vertex);
        Ok(Self::new(Mesh::from_f64(vertices, cells.flat_map(cell))?))
    }
}

const SIZE: [&str; 3] = ["size[0]", "size[1]", "size[2]"];

fn check(
    lengths: impl IntoIterator<Item = (&'static str, f64)>,
    allowed: RangeInclusive<f64>,
) -> Result<(), ShapeError> {
    let fault = lengths
        .into_iter()
        .find(|(_, value)| !allowed.contains(value));
    fault.map_or(Ok(()), |(argument, value)| {
        Err(ShapeError::Length {
            argument,
            value,
            least: *allowed.start(),
            most: *allowed.end(),
        })
    })
}

/// The solid of a closed mesh, a segment or a point, with a radius in range.
fn thickened(
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    radius: f64,
) -> Result<Tree, ShapeError> {
    let mesh = Mesh::from_f64(vertices.iter().copied(), triangles.iter().copied())?;
    let mut tree = Tree::with_options(mesh, &BuildOptions::default().solid(Solid::Keep));
    tree.radius = radius;
    Ok(tree)
}

fn block(half: DVec3, radius: f64) -> Result<Tree, ShapeError> {
    const QUADS: [[u32; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let corner = |i: u32| {
        let side = |axis: u32| if i >> axis & 1 > 0 { 1.0 } else { -1.0 };
        (half * DVec3::new(side(0), side(1), side(2))).to_array()
    };
    let corners: [_; 8] = core::array::from_fn(|i| corner(i as u32));
    let halves = QUADS.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    thickened(&corners, halves.as_flattened(), radius)
}

/// A prism around a cylinder, or a pyramid around a cone.
fn turned(radius: f64, length: f64, is_cone: bool) -> Result<Tree, ShapeError> {
    check([("radius", radius), ("length", length)], LENGTHS)?;
    let (outer, half) = (radius / libm::cos(PI / f64::from(SIDES)), length / 2.0);
    let outer = outer * (1.0 + SLACK);
    let (low, high) = (0, SIDES + 1);
    // For each end its middle, then its corners; the upper end of a cone has none.
    let ring = |z: f64| {
        let corner = move |i: u32| {
            let (sin, cos) = libm::sincos(TAU * f64::from(i) / f64::from(SIDES));
            [outer * cos, outer * sin, z]
        };
        core::iter::once([0.0, 0.0, z]).chain((0..SIDES).map(corner))
    };
    let count = if is_cone { SIDES + 2 } else { 2 * SIDES + 2 };
    let vertices: Vec<_> = ring(-half).chain(ring(half)).take(count as usize).collect();
    let side = |i: u32| {
        let [a, b] = [i, (i + 1) % SIDES].map(|i| low + 1 + i);
        let [c, d] = [a, b].map(|corner| if is_cone { high } else { high + corner });
        let all = [[low, b, a], [a, b, c], [b, d, c], [high, c, d]];
        all.into_iter().take(if is_cone { 2 } else { 4 })
    };
    let triangles: Vec<_> = (0..SIDES).flat_map(side).collect();
    thickened(&vertices, &triangles, 0.0)
}
