//! The sets of rays, of numbers that are `f32`.

use punctual::glam::DVec3;
use punctual::{Mesh, Ray};

/// Each set with its name.
pub fn all(mesh: &Mesh, count: usize) -> [(&'static str, Vec<Ray>); 2] {
    [
        ("coherent", coherent(mesh, count)),
        ("random", random(mesh, count)),
    ]
}

fn ray(origin: DVec3, direction: DVec3) -> Ray {
    let rounded = |v: DVec3| v.as_vec3().as_dvec3();
    Ray::new(rounded(origin), rounded(direction)).expect("a direction")
}

/// A camera's, row by row: it stands half the diagonal of the box outside, and sees the sphere around it.
fn coherent(mesh: &Mesh, count: usize) -> Vec<Ray> {
    let bounds = mesh.aabb();
    let (middle, radius) = (
        (bounds.min + bounds.max) * 0.5,
        (bounds.max - bounds.min).length() * 0.5,
    );
    let ahead = DVec3::new(-0.6, -0.48, -0.64);
    let right = ahead.cross(DVec3::Z).normalize();
    let up = right.cross(ahead);
    let eye = middle - ahead * radius * 2.0;
    let side = (count as f64).sqrt().ceil() as usize;
    let at = |i: usize| ((i as f64 + 0.5) / side as f64 * 2.0 - 1.0) / 3.0_f64.sqrt();
    (0..count)
        .map(|i| ray(eye, ahead + right * at(i % side) - up * at(i / side)))
        .collect()
}

/// They begin in the box of the mesh, a fifth larger, and go anywhere.
fn random(mesh: &Mesh, count: usize) -> Vec<Ray> {
    let bounds = mesh.aabb();
    let (middle, half) = (
        (bounds.min + bounds.max) * 0.5,
        (bounds.max - bounds.min) * 0.6,
    );
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut number = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut vector = || DVec3::new(number(), number(), number());
    let mut rays = Vec::with_capacity(count);
    while rays.len() < count {
        let (place, direction) = (vector(), vector());
        let square = direction.length_squared();
        if (1e-4..=1.0).contains(&square) {
            rays.push(ray(middle + place * half, direction / square.sqrt()));
        }
    }
    rays
}
