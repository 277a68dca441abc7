//! Any bytes, and files of small trees with any changes, most with the right checksum: an error, or a tree that is valid and
//! answers as its own mesh does.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{BuildOptions, Mesh, Pose, Tree, shapes};
use punctual_fuzz::assert_query;

static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let cube = shapes::cuboid(Vec3::new(1.0, 0.5, 0.25), 2);
    let vertices = (0..cube.vertex_count()).map(|i| cube.vertex(i) * 0.1);
    let wide = Mesh::from_f64(vertices, cube.triangles().iter().copied()).expect("finite");
    let lone = Mesh::new(
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[0, 1, 2]],
    )
    .expect("sound");
    let none = Mesh::new([[0.0f32; 3]; 0], []).expect("sound");
    let meshes = [
        shapes::icosphere(1),
        shapes::icosphere(0),
        cube,
        wide,
        lone,
        none,
    ];
    let presets = [
        BuildOptions::default(),
        BuildOptions::fast_build(),
    ];
    let pairs = meshes
        .iter()
        .flat_map(|mesh| presets.iter().map(move |options| (mesh, options)));
    pairs
        .map(|(mesh, options)| Tree::with_options(mesh.clone(), options).to_bytes())
        .collect()
});

static OTHER: LazyLock<Tree> = LazyLock::new(|| Tree::new(shapes::icosphere(1)));

/// A place in the file, as likely in the header or among the nodes, the frames and the checksum as anywhere else.
fn place(file: &[u8], bytes: &mut Unstructured) -> Result<usize> {
    let last = file.len().saturating_sub(1);
    match bytes.int_in_range(0..=2)? {
        0 => bytes.int_in_range(0..=last.min(60)),
        1 => bytes.int_in_range(last.saturating_sub(600)..=last),
        _ => bytes.int_in_range(0..=last),
    }
}

fn file(bytes: &mut Unstructured) -> Result<Vec<u8>> {
    let mut file = bytes.choose(&FILES)?.clone();
    for _ in 0..bytes.int_in_range(0..=4)? {
        if file.is_empty() {
            break;
        }
        let at = place(&file, bytes)?;
        let end = (at + bytes.int_in_range(1..=8)?).min(file.len());
        match bytes.int_in_range(0..=6)? {
            0 => file[at] ^= 1 << bytes.int_in_range(0..=7)?,
            1 => file[at] = bytes.arbitrary()?,
            2 => file[at..end].copy_from_slice(bytes.bytes(end - at)?),
            3 => {
                let to = bytes.int_in_range(0..=file.len() - (end - at))?;
                file.copy_within(at..end, to);
            }
            4 => drop(file.drain(at..end)),
            5 => file.insert(at, bytes.arbitrary()?),
            _ => file.truncate(at),
        }
    }
    Ok(file)
}

fn ask(mut file: Vec<u8>, bytes: &mut Unstructured) -> Result<()> {
    if bytes.ratio(9, 10)?
        && let Some((content, checksum)) = file.split_last_chunk_mut::<4>()
    {
        *checksum = crc32fast::hash(content).to_le_bytes();
    }
    let Ok(tree) = Tree::from_bytes(&file) else {
        return Ok(());
    };
    tree.validate().expect("a valid tree");
    assert!(
        tree.to_bytes() == file || tree.to_bytes().len() == file.len(),
        "another file of another length"
    );
    let shift = DVec3::new(f64::from(bytes.arbitrary::<i8>()?) / 64.0, 0.1, 0.0);
    let pose = Pose::new(
        DMat3::from_rotation_y(f64::from(bytes.arbitrary::<i8>()?)),
        shift,
    )
    .expect("a rotation");
    assert_query(&tree, &OTHER, pose, bytes)
}

fuzz_target!(|bytes: &[u8]| {
    let _ = Tree::from_bytes(bytes);
    let mut bytes = Unstructured::new(bytes);
    if let Ok(file) = file(&mut bytes) {
        let _ = ask(file, &mut bytes);
    }
});
