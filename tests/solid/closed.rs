//! Components, open edges, volumes, and what is inside out.

use crate::meshes::{union, unwelded, with_triangles};
use punctual::glam::{DVec3, Vec3};
use punctual::tree::{Solid, SolidError, Solidity, TreeFileError};
use punctual::{BuildOptions, Mesh, Tree, shapes};
use std::f64::consts::PI;

fn build(mesh: &Mesh, solid: Solid) -> Tree {
    Tree::with_options(mesh.clone(), &BuildOptions::default().solid(solid))
}

fn solid(tree: &Tree) -> &Solidity {
    tree.solid().expect("a solid")
}

#[test]
fn closed_shapes_have_no_open_edges_and_their_volume() {
    for (mesh, volume, error) in [
        (shapes::icosphere(4), 4.0 / 3.0 * PI, 0.01),
        (shapes::cuboid(Vec3::new(0.5, 1.0, 1.5), 7), 6.0, 1e-12),
        (shapes::torus(2.0, 0.5, 96), PI * PI, 0.01),
    ] {
        for mesh in [unwelded(&mesh), mesh] {
            let tree = build(&mesh, Solid::Keep);
            let solid = solid(&tree);
            assert!(solid.is_closed() && solid.open_edges() == 0);
            let [one] = solid.components() else {
                panic!("{} components", solid.components().len());
            };
            assert!(one.is_closed() && !one.inside_out);
            assert_eq!((one.triangles, one.first_triangle), (mesh.len(), 0));
            assert!((one.volume / volume - 1.0).abs() < error, "{}", one.volume);
            assert_eq!(one.volume, solid.volume());
        }
    }
}

#[test]
fn a_tree_that_was_not_asked_for_a_solid_is_none() {
    let tree = Tree::new(shapes::icosphere(2));
    assert!(tree.solid().is_none() && tree.stats().bytes_solid == 0);
    assert_eq!(tree.checked_solid().err(), Some(SolidError::NotSolid));
}

/// Counts the open edges by brute force, by position.
fn open_edges(mesh: &Mesh) -> usize {
    let mut edges = Vec::new();
    for i in 0..mesh.len() {
        let corners = mesh.triangle(i);
        for k in 0..3 {
            let [from, to] = [corners[k], corners[(k + 1) % 3]].map(|p| (p + 0.0).to_array());
            if from != to {
                edges.push((from, to));
            }
        }
    }
    let surplus = |(from, to): &([f64; 3], [f64; 3])| {
        let count = |edge| edges.iter().filter(|other| **other == edge).count();
        (count((*from, *to)), count((*to, *from)))
    };
    // Each of the n edges of a direction that has m opposite ones: n - m are open.
    let shares = edges.iter().map(|edge| match surplus(edge) {
        (here, there) if here > there => (here - there) as f64 / here as f64,
        _ => 0.0,
    });
    shares.sum::<f64>().round() as usize
}

#[test]
fn open_edges_are_those_of_brute_force() {
    let ball = shapes::icosphere(2);
    let all = ball.triangles().to_vec();
    let mut turned = all.clone();
    turned[5].swap(0, 1);
    let mut thrice = all.clone();
    thrice.extend([all[7], all[7], all[9]]);
    let mut degenerate = all.clone();
    degenerate.extend([[3, 3, 9], [5, 6, 5], [8, 8, 8]]);
    for triangles in [
        all[1..].to_vec(),
        all[20..].to_vec(),
        turned,
        thrice,
        degenerate,
        vec![],
        vec![[0, 1, 2]],
    ] {
        let mesh = with_triangles(&ball, triangles);
        for mesh in [unwelded(&mesh), mesh, shapes::height_field(5, 3)] {
            let tree = build(&mesh, Solid::Keep);
            let solid = solid(&tree);
            assert_eq!(solid.open_edges(), open_edges(&mesh));
            let sum: usize = solid.components().iter().map(|one| one.open_edges).sum();
            assert_eq!(solid.open_edges(), sum);
            let triangles: usize = solid.components().iter().map(|one| one.triangles).sum();
            assert_eq!(triangles, mesh.len());
        }
    }
}

#[test]
fn seams_of_equal_positions_are_closed_negative_zeros_included() {
    // Two pyramids, base to base, the bases left out; one has its zeros negative.
    let half = |z: f64, zero: f64| {
        [
            [1.0, zero, zero],
            [zero, 1.0, zero],
            [-1.0, zero, zero],
            [zero, -1.0, zero],
            [zero, zero, z],
        ]
    };
    let vertices = half(1.0, 0.0).into_iter().chain(half(-1.0, -0.0));
    let up = (0..4).map(|i| [i, (i + 1) % 4, 4]);
    let down = (0..4).map(|i| [5 + (i + 1) % 4, 5 + i, 9]);
    let mesh = Mesh::from_f64(vertices, up.chain(down)).unwrap();
    let tree = build(&mesh, Solid::Keep);
    assert!(solid(&tree).is_closed());
    assert_eq!(solid(&tree).components().len(), 1);
    assert!((solid(&tree).volume() - 4.0 / 3.0).abs() < 1e-12);
}

/// A ball in a cavity of a cube, beside a gear: three components, one of them negative.
fn nested() -> Mesh {
    let (cube, ball, gear) = (
        shapes::cuboid(Vec3::ONE, 4),
        shapes::icosphere(2),
        shapes::gear(11, 2),
    );
    union(&[
        (&cube, 1.0, DVec3::ZERO),
        (&ball, -0.9, DVec3::ZERO),
        (&ball, 0.5, DVec3::splat(0.01)),
        (&gear, 1.0, DVec3::X * 9.0),
    ])
}

#[test]
fn a_cavity_is_not_inside_out() {
    let tree = build(&nested(), Solid::Flip);
    assert!(*tree.mesh() == nested(), "nothing is reversed");
    let components = solid(&tree).components();
    assert_eq!(components.len(), 4);
    let signs: Vec<bool> = components.iter().map(|one| one.volume < 0.0).collect();
    assert_eq!(signs, [false, true, false, false]);
    assert!(
        components
            .iter()
            .all(|one| one.is_closed() && !one.inside_out)
    );
    assert!(tree.checked_solid().is_ok());
}

#[test]
fn inside_out_solids_are_refused_or_flipped_cavities_with_them() {
    let good = nested();
    let reversed = with_triangles(&good, good.triangles().iter().map(|&[a, b, c]| [a, c, b]));
    let kept = build(&reversed, Solid::Keep);
    // The ball inside the reversed cavity has -1 on one side too.
    assert!(solid(&kept).components().iter().all(|one| one.inside_out));
    let volume = solid(&kept).components()[0].volume;
    let error = kept.checked_solid().err();
    assert_eq!(
        error,
        Some(SolidError::InsideOut {
            component: 0,
            triangle: 0,
            volume
        })
    );
    assert!(error.unwrap().to_string().contains("triangle 0"));
    let flipped = build(&reversed, Solid::Flip);
    assert!(flipped.mesh().triangles() == good.triangles());
    let same = build(&good, Solid::Keep);
    assert_eq!(solid(&flipped).components(), solid(&same).components());
    assert_eq!(flipped.validate(), Ok(()));
    assert!(flipped.checked_solid().is_ok());
}

#[test]
fn one_reversed_part_is_named_and_flipped_alone() {
    let (ball, knot) = (shapes::icosphere(3), shapes::torus_knot(2, 3, 0.2, 60));
    let mesh = union(&[
        (&ball, 1.0, DVec3::ZERO),
        (&knot, -1.0, DVec3::X * 7.0),
        (&ball, 2.0, DVec3::Y * 1.5),
    ]);
    let error = build(&mesh, Solid::Keep).checked_solid().err();
    let Some(SolidError::InsideOut {
        component: 1,
        triangle,
        volume,
    }) = error
    else {
        panic!("{error:?}");
    };
    assert!(triangle as usize == ball.len() && volume < 0.0);
    let flipped = build(&mesh, Solid::Flip);
    assert!(flipped.mesh().triangles()[..ball.len()] == mesh.triangles()[..ball.len()]);
    assert!(flipped.checked_solid().is_ok());
}

#[test]
fn a_refit_computes_closedness_anew() {
    let mesh = unwelded(&shapes::icosphere(2));
    let mut tree = build(&mesh, Solid::Flip);
    let moved: Vec<[f64; 3]> = (0..mesh.vertex_count())
        .map(|i| (mesh.vertex(i) * 2.0).into())
        .collect();
    let before = solid(&tree).volume();
    tree.refit_f64(&moved).unwrap();
    assert!(solid(&tree).is_closed());
    assert!((solid(&tree).volume() / before - 8.0).abs() < 1e-9);
    // Mirrored, it is inside out, and a refit reverses nothing.
    let mirrored: Vec<[f64; 3]> = moved.iter().map(|[x, y, z]| [-x, *y, *z]).collect();
    tree.refit_f64(&mirrored).unwrap();
    assert!(solid(&tree).components()[0].inside_out);
    // A corner that leaves the others opens the edges to it.
    let mut torn = moved.clone();
    torn[0][0] += 0.125;
    tree.refit_f64(&torn).unwrap();
    assert_eq!(solid(&tree).open_edges(), 4);
    let anew = build(tree.mesh(), Solid::Keep);
    assert_eq!(solid(&tree).components(), solid(&anew).components());
}

#[test]
fn a_file_keeps_the_solid_and_version_1_has_none() {
    for mesh in [
        nested(),
        shapes::height_field(9, 1),
        unwelded(&shapes::gear(7, 1)),
    ] {
        for kind in [Solid::Keep, Solid::Flip] {
            let tree = build(&mesh, kind);
            let loaded = Tree::from_bytes(&tree.to_bytes()).unwrap();
            assert_eq!(loaded.solid(), tree.solid());
            assert!(loaded.to_bytes() == tree.to_bytes() && loaded.stats() == tree.stats());
        }
    }
    let mut bytes = Tree::new(shapes::icosphere(2)).to_bytes();
    bytes[8] = 1;
    seal(&mut bytes);
    assert!(Tree::from_bytes(&bytes).unwrap().solid().is_none());
    let mut bytes = build(&shapes::icosphere(2), Solid::Keep).to_bytes();
    bytes[8] = 1;
    seal(&mut bytes);
    let error = Tree::from_bytes(&bytes).err();
    assert_eq!(error, Some(TreeFileError::CoordinateSize(4 + 1024)));
}

/// Puts the right checksum at the end.
fn seal(bytes: &mut [u8]) {
    if let Some((content, checksum)) = bytes.split_last_chunk_mut::<4>() {
        *checksum = crc32fast::hash(content).to_le_bytes();
    }
}

#[test]
fn memory_is_told() {
    let tree = build(&nested(), Solid::Keep);
    let triangles = tree.mesh().len();
    let bytes = tree.stats().bytes_solid;
    // Convex components have their corners besides.
    let corners = size_of::<DVec3>() * tree.mesh().vertex_count();
    assert!(
        (4 * triangles..4 * triangles + corners + 700).contains(&bytes),
        "{bytes}"
    );
    let bytes = |mesh: &Mesh| build(mesh, Solid::Keep).stats().bytes_solid;
    let hollow = bytes(&shapes::torus(1.0, 0.3, 16));
    assert!((1..200).contains(&hollow), "{hollow}");
    let ball = shapes::icosphere(3);
    let corners = size_of::<DVec3>() * ball.vertex_count();
    assert!((corners..corners + 200).contains(&bytes(&ball)));
}

#[test]
fn far_tiny_and_huge_solids_have_their_volumes() {
    let ball = shapes::icosphere(2);
    let volume = solid(&build(&ball, Solid::Keep)).volume();
    for scale in [1e-90, 1e-30, 1.0, 1e30, 1e90] {
        let mesh = union(&[(&ball, scale, DVec3::ZERO)]);
        let found = solid(&build(&mesh, Solid::Keep)).volume() / scale / scale / scale;
        assert!((found / volume - 1.0).abs() < 1e-12, "{scale}: {found}");
    }
    let far = union(&[(&ball, -1.0, DVec3::splat(1e6))]);
    let tree = build(&far, Solid::Keep);
    assert!((solid(&tree).volume() / volume + 1.0).abs() < 1e-9);
    assert!(solid(&tree).components()[0].inside_out);
    for scale in [1e-300, 1e300] {
        let tree = build(&union(&[(&ball, -scale, DVec3::ZERO)]), Solid::Flip);
        assert!(solid(&tree).is_closed() && tree.checked_solid().is_ok());
    }
}
