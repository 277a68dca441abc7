//! Seeded random numbers, triangle soups and poses.

use oorandom::Rand64;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::{Mesh, Pose};

/// The same numbers everywhere.
pub struct Random(Rand64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Rand64::new(seed.into()))
    }

    pub fn bits(&mut self) -> u64 {
        self.0.rand_u64()
    }

    /// A whole number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        self.0.rand_range(0..end as u64) as usize
    }

    /// Uniform from 0 to below 1.
    pub fn unit(&mut self) -> f64 {
        self.0.rand_float()
    }

    /// Uniform in `[-1, 1)`, a multiple of 2^-52.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Uniform in the cube of half extent 1.
    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }

    /// A direction and a turn, neither quite uniform: enough for tests.
    pub fn rotation(&mut self) -> DMat3 {
        let [x, y, z, w] = [self.signed(), self.signed(), self.signed(), self.signed()];
        DMat3::from_quat(DQuat::from_xyzw(x, y, z, w + 1e-3).normalize())
    }
}

/// A test for each family of soups: it calls the function that is named.
#[allow(
    unused_macros,
    reason = "each test file is a crate of its own and uses a part"
)]
macro_rules! soups {
    ($assert:ident) => {
        soups! { $assert
            uniform_soups: Uniform,
            soups_of_f64_vertices: Double,
            slivers: Sliver,
            degenerate_triangles: Degenerate,
            duplicate_triangles: Duplicate,
            exact_touches_on_a_grid: Grid,
            very_unequal_triangles: Unequal,
            sizes_over_270_decades: Nested,
            soups_far_from_the_origin: FarOffset,
            tiny_coordinates: Tiny,
            large_coordinates: Large,
            denormal_coordinates: Denormal,
            enormous_coordinates: Enormous,
        }
    };
    ($assert:ident $($name:ident: $family:ident,)*) => {
        $(#[test] fn $name() { $assert(Family::$family); })*

        #[test]
        fn every_family_has_a_test() {
            let tested = [$(Family::$family),*];
            assert!(Family::ALL.iter().all(|family| tested.contains(family)));
        }
    };
}
#[allow(
    unused_imports,
    reason = "each test file is a crate of its own and uses a part"
)]
pub(crate) use soups;

/// What makes a soup nasty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Small triangles, f32 vertices.
    Uniform,
    /// The same with vertices that need f64.
    Double,
    /// A length of 1 and a width of 1e-9.
    Sliver,
    /// Points, segments, repeated corners.
    Degenerate,
    /// Each triangle several times, turned and flipped.
    Duplicate,
    /// Small whole coordinates: most contacts are exact touches.
    Grid,
    /// Sizes from 1e-4 to 10 in one mesh.
    Unequal,
    /// Sizes from 1 to 2^-900, all around the origin: the deepest trees.
    Nested,
    /// Around a point 1e8 from the origin.
    FarOffset,
    /// Coordinates of 1e-30.
    Tiny,
    /// Coordinates of 1e15.
    Large,
    /// Coordinates of a few least denormals.
    Denormal,
    /// Coordinates near the largest that a mesh takes.
    Enormous,
}

impl Family {
    pub const ALL: [Self; 13] = [
        Self::Uniform,
        Self::Double,
        Self::Sliver,
        Self::Degenerate,
        Self::Duplicate,
        Self::Grid,
        Self::Unequal,
        Self::Nested,
        Self::FarOffset,
        Self::Tiny,
        Self::Large,
        Self::Denormal,
        Self::Enormous,
    ];

    /// Half the extent of a soup of this family.
    pub const fn scale(self) -> f64 {
        match self {
            Self::Grid => 2.0,
            Self::Tiny => 1e-30,
            Self::Large => 1e15,
            Self::Denormal => 1e-321,
            Self::Enormous => 1e300,
            _ => 1.0,
        }
    }

    /// The middle of a soup of this family.
    pub const fn center(self) -> DVec3 {
        match self {
            Self::FarOffset => DVec3::new(1e8, -3e8, 2e8),
            _ => DVec3::ZERO,
        }
    }

    fn corners(self, random: &mut Random) -> [DVec3; 3] {
        let center = random.vector();
        let around =
            |size: f64, random: &mut Random| [(); 3].map(|()| center + size * random.vector());
        match self {
            Self::Sliver => {
                let [start, end, _] = around(0.5, random);
                [start, end, end + 1e-9 * random.vector()]
            }
            Self::Degenerate => {
                let [first, second, third] = around(0.4, random);
                match random.below(5) {
                    0 => [first; 3],
                    1 => [first, second, first],
                    2 => [first, first, second],
                    3 => [first, second, 0.5 * (first + second)],
                    _ => [first, second, third],
                }
            }
            Self::Grid => [(); 3].map(|()| (2.0 * random.vector()).round() / 2.0),
            Self::Unequal => {
                let size = [1e-4, 1e-2, 1.0, 10.0][random.below(4)];
                around(size, random)
            }
            Self::Nested => {
                let size = f64::exp2(-450.0 * (1.0 + random.signed()));
                around(0.5, random).map(|corner| size * corner)
            }
            _ => around(0.3, random),
        }
    }
}

/// `triangles` triangles of a family, none of them sharing a vertex.
pub fn soup(family: Family, triangles: usize, random: &mut Random) -> Mesh {
    let place = |corner: DVec3| family.center() + family.scale() * corner;
    let mut corners: Vec<[DVec3; 3]> = Vec::with_capacity(triangles);
    for index in 0..triangles {
        if family == Family::Duplicate && index % 3 != 0 {
            let [first, second, third] = corners[random.below(index)];
            corners.push([second, first, third]);
        } else {
            corners.push(family.corners(random).map(place));
        }
    }
    let indices = (0u32..)
        .take(triangles)
        .map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    if family == Family::Uniform {
        let vertices = corners.iter().flatten().map(|corner| corner.as_vec3());
        return Mesh::new(vertices, indices).unwrap();
    }
    Mesh::from_f64(corners.into_iter().flatten(), indices).unwrap()
}

/// How far a pose is from a rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drift {
    /// Rounding only.
    None,
    /// Each axis longer or shorter, up to a deviation of 9e-4.
    Scale,
    /// Axes not quite perpendicular, up to a deviation of 9e-4.
    Shear,
}

/// A rotation about `center`, then a shift by up to `reach` on each axis.
pub fn pose_about(center: DVec3, reach: f64, drift: Drift, random: &mut Random) -> Pose {
    let stretch = match drift {
        Drift::None => DMat3::IDENTITY,
        Drift::Scale => DMat3::from_diagonal(DVec3::ONE + 4.4e-4 * random.vector()),
        Drift::Shear => {
            let mut shear = DMat3::IDENTITY;
            shear.y_axis.x = 8.9e-4 * random.signed();
            shear
        }
    };
    let rotation = random.rotation() * stretch;
    let translation = center - rotation * center + reach * random.vector();
    Pose::new(rotation, translation).unwrap()
}

/// The poses each pair of soups is tried in: unmoved, shifted along an axis, then turned and drifted ones.
pub fn poses(family: Family, count: usize, random: &mut Random) -> Vec<Pose> {
    let reach = 0.7 * family.scale();
    let shift = DVec3::new(family.scale() / 2.0, 0.0, 0.0);
    let mut poses = vec![Pose::IDENTITY, Pose::new(DMat3::IDENTITY, shift).unwrap()];
    for drift in [Drift::None, Drift::Scale, Drift::Shear]
        .into_iter()
        .cycle()
        .take(count)
    {
        poses.push(pose_about(family.center(), reach, drift, random));
    }
    poses
}
