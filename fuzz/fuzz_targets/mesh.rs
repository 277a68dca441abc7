//! Any vertices, NaN too, and any indices: an error or a mesh, never a panic; and what is a mesh can be queried.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::{Mesh, MeshError, Pose, Tree};
use punctual_fuzz::{Numbers, assert_query};

fn mesh(bytes: &mut Unstructured) -> Result<std::result::Result<Mesh, MeshError>> {
    let numbers = Numbers::arbitrary(bytes)?;
    let vertices = (0..bytes.int_in_range(0..=12)?)
        .map(|_| numbers.point(bytes))
        .collect::<Result<Vec<_>>>()?;
    let last = u32::try_from(vertices.len())
        .expect("few")
        .saturating_sub(1);
    // Now and then one beyond the last.
    let mut index = || Ok(bytes.int_in_range(0..=last)? + u32::from(bytes.ratio(1, 500)?));
    let mut triangles = Vec::new();
    for _ in 0..20 {
        triangles.push([index()?, index()?, index()?]);
    }
    triangles.truncate(bytes.int_in_range(0..=20)?);
    if bytes.arbitrary()? {
        return Ok(Mesh::from_f64(vertices, triangles));
    }
    Ok(Mesh::new(
        vertices.iter().map(|vertex| vertex.map(|x| x as f32)),
        triangles,
    ))
}

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Unstructured::new(bytes);
    let Ok(Ok(mesh)) = mesh(&mut bytes) else {
        return;
    };
    let tree = Tree::new(mesh);
    tree.validate().expect("a valid tree");
    let _ = assert_query(&tree, &tree, Pose::IDENTITY, &mut bytes);
});
