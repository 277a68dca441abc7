//! Any twelve numbers: an error or a pose, never a panic; and at a pose, small shapes of any scale can be queried.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::glam::{DMat3, DQuat, DVec3, Vec3};
use punctual::{Mesh, Pose, Tree, shapes};
use punctual_fuzz::{Numbers, assert_query, moved};

/// Two shapes of size 1, far smaller, far larger, and far from the origin.
static TREES: LazyLock<Vec<Tree>> = LazyLock::new(|| {
    let shapes = [
        shapes::icosphere(1),
        shapes::cuboid(Vec3::new(1.0, 0.5, 0.25), 2),
    ];
    let placed = |mesh: &Mesh, scale: f64, offset: DVec3| {
        let vertices = (0..mesh.vertex_count()).map(|vertex| mesh.vertex(vertex) * scale + offset);
        let mesh = Mesh::from_f64(vertices, mesh.triangles().iter().copied()).expect("in range");
        Tree::new(mesh)
    };
    let places = [
        (1.0, DVec3::ZERO),
        (5e-324, DVec3::ZERO),
        (1e-30, DVec3::ZERO),
        (1e300, DVec3::ZERO),
        (1.0, DVec3::ONE * 1e8),
    ];
    shapes
        .iter()
        .flat_map(|shape| places.map(|(scale, offset)| placed(shape, scale, offset)))
        .collect()
});

/// Twelve numbers, or those of a rotation with entries moved by some units in the last place.
fn rows(bytes: &mut Unstructured) -> Result<[f64; 12]> {
    let mut rows = [0.0; 12];
    if bytes.ratio(1, 4)? {
        for entry in &mut rows {
            *entry = Numbers::arbitrary(bytes)?.read(bytes)?;
        }
        return Ok(rows);
    }
    let turns = *bytes.choose(&[Numbers::Whole, Numbers::Fraction])?;
    let [x, y, z] = turns.point(bytes)?;
    let rotation = DMat3::from_quat(DQuat::from_xyzw(x, y, z, turns.read(bytes)?).normalize());
    let shift = Numbers::arbitrary(bytes)?.point(bytes)?;
    for axis in 0..3 {
        let row = rotation.row(axis);
        for column in 0..3 {
            rows[4 * axis + column] = moved(row[column], bytes.int_in_range(-2..=2)?);
        }
        rows[4 * axis + 3] = shift[axis];
    }
    Ok(rows)
}

fn ask(bytes: &mut Unstructured) -> Result<()> {
    let Ok(pose) = Pose::from_row_major(rows(bytes)?) else {
        return Ok(());
    };
    let [a, b] = [bytes.choose(&TREES)?, bytes.choose(&TREES)?];
    assert_query(a, b, pose, bytes)
}

fuzz_target!(|bytes: &[u8]| {
    let _ = ask(&mut Unstructured::new(bytes));
});
