//! Shapes: a tree with what the filters need to know of it.

use std::fmt;
use std::sync::Arc;

use punctual::engine::{find, inside, unite};
use punctual::glam::{DMat3, DVec3};
use punctual::tree::ShapeError;
use punctual::{BuildOptions, Mesh, Tree, tree};

use crate::RobotError;
use crate::error::refuse;
use crate::model::LARGEST;
use crate::transform::{Transform, orthonormal, relative};

/// Relative slack of stored radii and half extents, for the rounding of their computation.
const SLACK: f64 = 1e-12;

/// A collision shape in its own frame, in metres. Cheap to clone: clones share the tree.
///
/// - **Meshes are surfaces or solids** as asked: a body wholly inside a solid meets it. A mesh with
///   open edges is a surface in any case.
/// - **Boxes, spheres, capsules and cylinders are solids.**
/// - **Boxes** are exact: 12 triangles.
/// - **Spheres and capsules** are a point or a segment with a radius, exact up to 4e-14 times the
///   size of the pair; what is closer to touching than that counts as touching.
/// - **Cylinders** are prisms around the true cylinder ([`Tree::cylinder`]), so free is proven for
///   the true cylinder too. No point of the prism is farther from the cylinder than
///   [`Shape::band`], 3.02e-4 times the radius: a contact may be that much early, and the upper
///   bound of a clearance allows for it.
#[derive(Clone, Debug)]
pub struct Shape(Arc<Inner>);

#[derive(Debug)]
pub(crate) struct Inner {
    pub tree: Arc<Tree>,
    /// True if the shape has an inside, and bodies there meet it: the inside of a closed surface,
    /// or all within the radius.
    pub is_solid: bool,
    /// No point of the shape is farther than this from the shape it stands for.
    pub band: f64,
    /// Middle of the box, and the radius of a sphere about it that holds the shape.
    pub centre: DVec3,
    pub radius: f64,
    /// A box that holds the shape: its frame and half extents.
    pub frame: Transform,
    pub half: DVec3,
    /// One vertex of each connected part of the surface; all points of a cloud.
    pub samples: Samples,
}

impl Shape {
    /// A mesh, as a surface.
    pub fn mesh(mesh: Mesh) -> Self {
        Self::tree(Arc::new(Tree::new(mesh)))
    }

    /// A mesh, as a solid if it is closed ([`Shape::is_solid`]). Its triangles may face either way.
    pub fn solid(mesh: Mesh) -> Self {
        let options = BuildOptions::default().solid(tree::Solid::Flip);
        Self::tree(Arc::new(Tree::with_options(mesh, &options)))
    }

    /// The mesh of a tree: a solid if the tree was built as one ([`BuildOptions::solid`]) and is
    /// closed, else a surface.
    pub fn tree(tree: Arc<Tree>) -> Self {
        let is_solid = tree.solid().is_some_and(tree::Solidity::is_closed);
        Self::new(tree, is_solid, 0.0)
    }

    /// A solid box around the origin with these lengths along x, y and z.
    ///
    /// # Errors
    /// If a length is out of range ([`Tree::cuboid`]) or beyond 1e30.
    pub fn cuboid(size: [f64; 3]) -> Result<Self, RobotError> {
        Self::made("box", Tree::cuboid(size), 0.0)
    }

    /// A solid sphere around the origin.
    ///
    /// # Errors
    /// If the radius is out of range ([`Tree::ball`]) or beyond 1e30.
    pub fn sphere(radius: f64) -> Result<Self, RobotError> {
        Self::made("sphere", Tree::ball(radius), 0.0)
    }

    /// A solid cylinder along z, its middle in the origin: a prism around it.
    ///
    /// # Errors
    /// If radius or length is out of range ([`Tree::cylinder`]) or beyond 1e30.
    pub fn cylinder(radius: f64, length: f64) -> Result<Self, RobotError> {
        let tree = Tree::cylinder(radius, length);
        Self::made("cylinder", tree, tree::ROUND_BAND * radius)
    }

    /// A solid capsule: all points no farther than the radius from a segment of this length along
    /// z, whose middle is the origin.
    ///
    /// # Errors
    /// If radius or length is out of range ([`Tree::capsule`]) or beyond 1e30.
    pub fn capsule(radius: f64, length: f64) -> Result<Self, RobotError> {
        Self::made("capsule", Tree::capsule(radius, length), 0.0)
    }

    fn made(what: &str, tree: Result<Tree, ShapeError>, band: f64) -> Result<Self, RobotError> {
        let fault = |error: &dyn fmt::Display| RobotError::Model(format!("{what}: {error}"));
        let tree = tree.map_err(|error| fault(&error))?;
        // A surface: parts inside are found by their samples before any query.
        let surface = Tree::new(tree.mesh().clone()).with_radius(tree.radius());
        let shape = Self::new(surface.map_err(|error| fault(&error))?, true, band);
        if shape.0.radius > LARGEST {
            return refuse(format!("{what}: larger than {LARGEST:e}"));
        }
        Ok(shape)
    }

    /// True if a body inside meets it.
    pub fn is_solid(&self) -> bool {
        self.0.is_solid
    }

    /// No point of the shape is farther from the true one than this, in metres: 0 except for
    /// cylinders.
    pub fn band(&self) -> f64 {
        self.0.band
    }

    /// The tree of the surface: of a sphere, that of its middle, with the
    /// [radius](Tree::with_radius).
    pub fn surface(&self) -> &Tree {
        &self.0.tree
    }

    pub(crate) fn inner(&self) -> &Inner {
        &self.0
    }

    fn new(tree: impl Into<Arc<Tree>>, is_solid: bool, band: f64) -> Self {
        let tree = tree.into();
        let mesh = tree.mesh();
        // The axes of the mesh, or of the tree's root, whichever box has the least surface.
        let of_root = tree.root().map(|root| root.rotation().as_dmat3());
        let of_root = of_root.map_or(DMat3::IDENTITY, orthonormal);
        let axes = [DMat3::IDENTITY, of_root, of_root.transpose()];
        let (r, centre, half, radius) = if mesh.is_cloud() {
            bound((0..mesh.len()).map(|i| mesh.vertex(i)), axes)
        } else {
            bound((0..mesh.len()).flat_map(|i| mesh.triangle(i)), axes)
        };
        let rounding = SLACK * (centre.abs().max_element() + half.max_element());
        let thickness = tree.radius() + rounding;
        Self(Arc::new(Inner {
            is_solid,
            band,
            centre,
            radius: radius + thickness,
            frame: Transform::from_mat3_translation(r, centre),
            half: half + DVec3::splat(thickness),
            samples: Samples::new(samples(&tree)),
            tree,
        }))
    }
}

/// The box of points, along whichever axes has the least surface, and the radius of a sphere about
/// its middle. All is 0 without points.
fn bound(
    points: impl Iterator<Item = DVec3> + Clone,
    axes: [DMat3; 3],
) -> (DMat3, DVec3, DVec3, f64) {
    let fit = |r: DMat3| {
        let (back, start) = (r.transpose(), (DVec3::INFINITY, DVec3::NEG_INFINITY));
        let (min, max) = points.clone().fold(start, |(min, max), p| {
            let p = back * p;
            (min.min(p), max.max(p))
        });
        let e = max - min;
        (e.x * e.y + e.y * e.z + e.z * e.x, r, min, max)
    };
    let least = axes.map(fit).into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, r, min, max)) = least.filter(|_| points.clone().next().is_some()) else {
        return (DMat3::IDENTITY, DVec3::ZERO, DVec3::ZERO, 0.0);
    };
    let centre = r * ((min + max) / 2.0);
    let radius = points.map(|p| p.distance(centre)).fold(0.0, f64::max);
    (r, centre, (max - min) / 2.0, radius)
}

impl Inner {
    /// True if a point in the shape's frame is inside.
    #[inline]
    fn holds(&self, p: DVec3) -> bool {
        if self.tree.solid().is_some() || self.tree.radius() == 0.0 {
            return inside(&self.tree, p).is_inside();
        }
        // A sphere or a capsule: points within the radius of the middle are inside.
        p.length_squared() <= self.tree.radius() * self.tree.radius()
    }

    /// True if a sample of another shape is inside, which is at a place in the shape's frame.
    fn holds_one_of(&self, other: &Self, place: &Transform, tests: &mut u64) -> bool {
        let samples = &other.samples;
        let in_box = relative(&self.frame, place);
        let rounding = 10.0 * SLACK * (place.translation.length() + self.centre.length());
        let (mut spheres, mut points) = (0, 0);
        let found = samples.any(
            [samples.spheres.len(), 0],
            &mut |(centre, radius)| {
                spheres += 1;
                let p = in_box.transform_point3(*centre);
                let (beyond, reach) = ((p.abs() - self.half).max(DVec3::ZERO), radius + rounding);
                beyond.length_squared() <= reach * reach
            },
            &mut |p| {
                points += 1;
                self.holds(place.transform_point3(p))
            },
        );
        *tests += spheres / 4 + points;
        found
    }
}

/// True if a part of one shape lies inside the other one, which is a solid; `b_in_a` brings `b`
/// into the frame of `a`. For parts whose surfaces cross, both answers are possible. Counts the
/// tests.
#[inline]
pub(crate) fn holds_part(a: &Inner, b: &Inner, b_in_a: &Transform, tests: &mut u64) -> bool {
    if a.is_solid && a.holds_one_of(b, b_in_a, tests) {
        return true;
    }
    b.is_solid && b.holds_one_of(a, &relative(b_in_a, &Transform::IDENTITY), tests)
}

/// Points in their order, by eights, with a sphere around each eight, and around each eight of
/// these spheres, and so on.
#[derive(Debug)]
pub(crate) struct Samples {
    points: Vec<DVec3>,
    spheres: Vec<Vec<(DVec3, f64)>>,
}

impl Samples {
    const WIDTH: usize = 8;

    fn new(points: Vec<DVec3>) -> Self {
        let around = |spheres: &[(DVec3, f64)]| {
            let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let (min, max) = spheres.iter().fold(start, |(min, max), (centre, _)| {
                (min.min(*centre), max.max(*centre))
            });
            let middle = (min + max) / 2.0;
            let radii = spheres.iter().map(|(c, r)| c.distance(middle) + r);
            let radius = radii.fold(0.0, f64::max);
            (middle, radius + SLACK * (radius + middle.length()))
        };
        let mut spheres: Vec<Vec<_>> = Vec::new();
        let mut last: Vec<_> = points.iter().map(|&p| (p, 0.0)).collect();
        while last.len() > Self::WIDTH {
            last = last.chunks(Self::WIDTH).map(around).collect();
            spheres.push(last.clone());
        }
        Self { points, spheres }
    }

    pub fn are_few(&self) -> bool {
        self.spheres.is_empty()
    }

    /// True if a test is true of a point below one of the spheres that pass another test.
    fn any(
        &self,
        [level, at]: [usize; 2],
        passes: &mut impl FnMut(&(DVec3, f64)) -> bool,
        holds: &mut impl FnMut(DVec3) -> bool,
    ) -> bool {
        let begin = at * Self::WIDTH;
        let Some(below) = level.checked_sub(1) else {
            let mut points = self.points[begin..].iter().take(Self::WIDTH);
            return points.any(|&p| holds(p));
        };
        let mut spheres = self.spheres[below][begin..].iter().zip(begin..);
        let mut spheres = spheres.by_ref().take(Self::WIDTH);
        spheres.any(|(sphere, i)| passes(sphere) && self.any([below, i], passes, holds))
    }
}

/// One vertex of each connected part; vertices at equal positions count as one. All points of a
/// cloud.
fn samples(tree: &Tree) -> Vec<DVec3> {
    let mesh = tree.mesh();
    if mesh.is_cloud() {
        let points = tree.ids().iter();
        return points.map(|&i| mesh.vertex(i as usize)).collect();
    }
    let mut parents: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    let mut in_use: Vec<u32> = mesh.triangles().iter().flatten().copied().collect();
    in_use.sort_unstable();
    in_use.dedup();
    // 0 and -0 are one position.
    let key = |&i: &u32| (mesh.vertex(i as usize) + 0.0).to_array().map(f64::to_bits);
    let mut by_place = in_use.clone();
    by_place.sort_unstable_by_key(key);
    for pair in by_place.windows(2).filter(|w| key(&w[0]) == key(&w[1])) {
        unite(&mut parents, pair[0], pair[1]);
    }
    for &[a, b, c] in mesh.triangles() {
        unite(&mut parents, a, b);
        unite(&mut parents, a, c);
    }
    in_use.retain(|&i| find(&mut parents, i) == i);
    in_use.iter().map(|&i| mesh.vertex(i as usize)).collect()
}
