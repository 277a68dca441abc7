//! Files of clouds: the loaded tree is the saved one to the bit; damaged bytes are refused, or are
//! another valid tree.

use crate::common::random::Random;
use punctual::Tree;
use punctual::tree::TreeFileError;

fn bytes(points: usize) -> Vec<u8> {
    let mut random = Random::new(9);
    let points: Vec<_> = (0..points)
        .map(|_| random.vector().as_vec3().to_array())
        .collect();
    let tree = Tree::from_points(points).unwrap();
    let bytes = tree.to_bytes();
    let loaded = Tree::from_bytes(&bytes).unwrap();
    assert_eq!(loaded.mesh(), tree.mesh());
    assert_eq!((loaded.stats(), loaded.ids()), (tree.stats(), tree.ids()));
    assert_eq!(
        (loaded.to_bytes(), tree.bytes_len()),
        (bytes.clone(), bytes.len())
    );
    assert!(
        loaded.subtrees().zip(tree.subtrees()).all(|(a, b)| {
            (a.half_extents(), a.self_cost()) == (b.half_extents(), b.self_cost())
        })
    );
    bytes
}

#[test]
fn a_loaded_cloud_is_the_saved_one() {
    for points in [0, 1, 8, 9, 64, 65, 1000, 4001] {
        bytes(points);
    }
}

#[test]
fn damaged_files_are_refused_or_valid() {
    let good = bytes(201);
    assert!(matches!(
        Tree::from_bytes(&good[..40]),
        Err(TreeFileError::Length { .. })
    ));
    let (mut refused, mut random) = (0, Random::new(4));
    for at in 0..good.len() - 4 {
        let mut bad = good.clone();
        bad[at] ^= 1 << random.below(8);
        assert!(Tree::from_bytes(&bad).is_err());
        let end = bad.len() - 4;
        let checksum = crc32fast::hash(&bad[..end]);
        bad[end..].copy_from_slice(&checksum.to_le_bytes());
        match Tree::from_bytes(&bad) {
            Ok(tree) => assert_eq!(tree.validate(), Ok(()), "byte {at}"),
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 800, "{refused}");
}
