//! Mass properties of closed solids: integrals over the tetrahedra between a point and the
//! triangles.

use super::SolidError;
use crate::tree::Tree;
use alloc::vec::Vec;
use glam::{DMat3, DVec3};

/// Volume, centre of mass and inertia of a solid of density 1: [`Tree::mass_properties`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct MassProperties {
    /// Volume, in the mesh's unit of length cubed.
    pub volume: f64,
    /// Centre of mass, in the coordinates of the mesh.
    pub center: DVec3,
    /// Inertia tensor about the centre of mass, for the axes of the mesh: `∫ |x|² I − x xᵀ` over
    /// the solid. Times mass over volume it is that of a solid of this mass.
    pub inertia: DMat3,
}

/// Integrals over a closed component, about one of its points.
#[derive(Clone, Copy)]
struct Integrals {
    apex: DVec3,
    volume: f64,
    first: DVec3,
    second: DMat3,
    /// Sum of the sizes of the terms of the volume.
    size: f64,
}

fn outer(u: DVec3, v: DVec3) -> DMat3 {
    DMat3::from_cols(u * v.x, u * v.y, u * v.z)
}

impl Integrals {
    fn add(&mut self, corners: [DVec3; 3]) {
        let [p, q, r] = corners.map(|corner| corner - self.apex);
        let (u, v, sum) = (q - p, r - p, p + q + r);
        let six_volumes = p.dot(u.cross(v));
        self.volume += six_volumes / 6.0;
        self.first += sum * (six_volumes / 24.0);
        let squares = outer(sum, sum) + outer(p, p) + outer(q, q) + outer(r, r);
        self.second += squares * (six_volumes / 120.0);
        self.size += p.length() * u.length() * v.length();
    }

    /// The second moments about `center`.
    fn about(&self, center: DVec3) -> DMat3 {
        let shift = self.apex - center;
        let mixed = outer(self.first, shift);
        self.second + mixed + mixed.transpose() + outer(shift, shift) * self.volume
    }
}

impl Tree {
    /// Volume, centre of mass and inertia tensor of a closed solid of density 1: integrals over the
    /// polyhedron, exact but for the rounding of f64 sums, about a vertex of each component.
    /// Cavities count as such; components that overlap count twice. Takes time linear in the
    /// triangles.
    ///
    /// ```
    /// use punctual::tree::Solid;
    /// use punctual::{BuildOptions, Tree, shapes};
    ///
    /// let options = BuildOptions::default().solid(Solid::Keep);
    /// let cube = Tree::with_options(shapes::cuboid([1.0; 3], 1), &options);
    /// let found = cube.mass_properties()?;
    /// assert!((found.volume - 8.0).abs() < 1e-12 && found.center.length() < 1e-15);
    /// assert!((found.inertia.x_axis.x - 8.0 * (4.0 + 4.0) / 12.0).abs() < 1e-12);
    /// # Ok::<(), punctual::tree::SolidError>(())
    /// ```
    ///
    /// # Errors
    /// If the build did not ask for a [solid](crate::BuildOptions::solid), a component is
    /// inside out, an edge is open, the tree has a [radius](Self::with_radius), or the volume is 0
    /// within rounding or not finite.
    pub fn mass_properties(&self) -> Result<MassProperties, SolidError> {
        let solid = self.solid.as_ref().ok_or(SolidError::NotSolid)?;
        if self.radius > 0.0 {
            return Err(SolidError::Thickened {
                radius: self.radius,
            });
        }
        solid.check()?;
        let (rim, open) = solid.rim();
        if let Some(edge) = open.first() {
            let (edges, edge) = (open.len(), edge.map(|end| rim[end as usize]));
            return Err(SolidError::Open { edges, edge });
        }
        let begin = |first: u32| Integrals {
            apex: self.mesh.triangle(first as usize)[0],
            volume: 0.0,
            first: DVec3::ZERO,
            second: DMat3::ZERO,
            size: 0.0,
        };
        let components = solid.components().iter();
        let mut parts: Vec<Integrals> = components.map(|one| begin(one.first_triangle)).collect();
        for (triangle, corners) in (0..).zip(&self.corners) {
            let part = &mut parts[solid.component_of(triangle) as usize];
            part.add(corners.map(|vertex| self.mesh.vertex(vertex as usize)));
        }
        let origin = parts.first().map_or(DVec3::ZERO, |part| part.apex);
        let (mut volume, mut first, mut size) = (0.0, DVec3::ZERO, 0.0);
        for part in &parts {
            volume += part.volume;
            first += part.first + (part.apex - origin) * part.volume;
            size += part.size;
        }
        let center = origin + first / volume;
        let second: DMat3 = parts.iter().map(|part| part.about(center)).sum();
        let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
        let rounding = (8.0 + self.corners.len() as f64) * f64::EPSILON * size;
        if !(volume > rounding && trace.is_finite()) {
            return Err(SolidError::NoVolume { volume });
        }
        let inertia = DMat3::from_diagonal(DVec3::splat(trace)) - second;
        Ok(MassProperties {
            volume,
            center,
            inertia,
        })
    }
}
