//! Trees of points and of shapes: the trees of Rust, byte by byte, and what is refused.

use std::ptr::{null, null_mut};

use super::call::*;
use punctual::Tree;
use punctual_capi::{punctual_status as Status, *};

fn bytes(tree: &punctual_tree) -> Vec<u8> {
    let count = made(|out| unsafe { punctual_tree_to_bytes(Some(tree), null_mut(), 0, out) });
    let mut all = vec![0; count];
    made(|out| unsafe { punctual_tree_to_bytes(Some(tree), all.as_mut_ptr(), count, out) });
    all
}

const POINTS: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.1],
    [0.0, 2.0, 0.0],
    [0.0, 0.0, 3.0],
    [0.25, 0.25, 0.25],
    [1.0, 1.0, 1.0],
];

#[test]
fn shapes_are_those_of_rust() {
    let flat = POINTS.as_flattened();
    let narrow: Vec<f32> = flat.iter().map(|&x| x as f32).collect();
    // SAFETY: arrays as long as said.
    let points = |radius| {
        owned(|out| unsafe { punctual_tree_from_points_f64(flat.as_ptr(), 6, radius, out) })
    };
    let cloud = Tree::from_points_f64(POINTS).unwrap();
    let same = Tree::from_points(POINTS.map(|p| p.map(|x| x as f32))).unwrap();
    let pairs = [
        (owned(|out| punctual_tree_ball(0.5, out)), Tree::ball(0.5)),
        (
            owned(|out| punctual_tree_capsule(0.5, 2.0, out)),
            Tree::capsule(0.5, 2.0),
        ),
        (
            owned(|out| punctual_tree_box(1.0, 2.0, 3.0, 0.0, out)),
            Tree::rounded_cuboid([1.0, 2.0, 3.0], 0.0),
        ),
        (
            owned(|out| punctual_tree_box(1.0, 2.0, 3.0, 0.25, out)),
            Tree::rounded_cuboid([1.0, 2.0, 3.0], 0.25),
        ),
        (
            owned(|out| punctual_tree_cylinder(0.5, 2.0, out)),
            Tree::cylinder(0.5, 2.0),
        ),
        (
            owned(|out| punctual_tree_cone(0.5, 2.0, out)),
            Tree::cone(0.5, 2.0),
        ),
        (
            owned(|out| unsafe { punctual_tree_hull(flat.as_ptr(), 6, out) }),
            Tree::hull(POINTS),
        ),
        (
            owned(|out| unsafe { punctual_tree_height_field(flat.as_ptr(), 18, 6, 0.5, 2.0, out) }),
            Tree::height_field(flat.iter().copied(), 6, [0.5, 2.0]),
        ),
        (points(0.0), Ok(cloud.clone())),
        (points(0.25), Ok(cloud.clone().with_radius(0.25).unwrap())),
        (
            owned(|out| unsafe { punctual_tree_from_points_f32(narrow.as_ptr(), 6, 0.0, out) }),
            Ok(same),
        ),
        (
            owned(|out| punctual_tree_with_radius(Some(&points(0.25)), 0.5, out)),
            Ok(cloud.with_radius(0.5).unwrap()),
        ),
    ];
    for (number, (ours, theirs)) in pairs.iter().enumerate() {
        assert_eq!(bytes(ours), theirs.as_ref().unwrap().to_bytes(), "{number}");
    }
    // A box whose edges are not rounded is the plain one.
    assert_eq!(
        bytes(&pairs[2].0),
        Tree::cuboid([1.0, 2.0, 3.0]).unwrap().to_bytes()
    );
}

#[test]
fn bad_shapes_are_refused() {
    let out = || std::mem::MaybeUninit::uninit();
    let [mut a, mut b, mut c, mut d, mut e, mut f, mut g, mut h] = [(); 8].map(|()| out());
    let bad = [0.0, 0.0, 0.0, 0.0, f64::NAN, 0.0];
    let ball = owned(|out| punctual_tree_ball(0.5, out));
    // SAFETY: null or as long as said.
    refuses! {
        punctual_tree_ball(0.0, Some(&mut a))
            => BadArgument "punctual_tree_ball: radius is 0.0, must be 1e-150 to 1e150";
        punctual_tree_ball(1.0, None) => null "the place for the new handle";
        punctual_tree_capsule(1.0, f64::NAN, Some(&mut b))
            => BadArgument "punctual_tree_capsule: length is NaN, must be 0.0 to 1e150";
        punctual_tree_cylinder(1.0, -1.0, Some(&mut c))
            => BadArgument "punctual_tree_cylinder: length is -1.0, must be 1e-150 to 1e150";
        punctual_tree_cone(f64::INFINITY, 1.0, Some(&mut d))
            => BadArgument "punctual_tree_cone: radius is inf, must be 1e-150 to 1e150";
        punctual_tree_box(1.0, 1.0, 0.5, 0.3, Some(&mut e))
            => BadArgument "punctual_tree_box: radius is 0.3, must be 0.0 to 0.25";
        punctual_tree_hull(bad.as_ptr(), 2, Some(&mut f))
            => BadMesh "punctual_tree_hull: vertex 1 is not finite along axis 1";
        punctual_tree_hull(POINTS.as_flattened().as_ptr(), 3, Some(&mut g))
            => BadMesh "punctual_tree_hull: the 3 points of the hull lie in one plane";
        punctual_tree_height_field(bad.as_ptr(), 3, 2, 1.0, 1.0, Some(&mut h))
            => BadArgument "punctual_tree_height_field: 3 heights in 2 columns, must be two whole rows and columns or more";
    }
    let [mut a, mut b, mut c, mut d] = [(); 4].map(|()| out());
    let status = punctual_tree_with_radius(Some(&ball), 1e302, Some(&mut d));
    assert!(status == Status::BadArgument && last_error().contains(": radius is 1000"));
    refuses! {
        punctual_tree_from_points_f64(bad.as_ptr(), 2, 0.0, Some(&mut a))
            => BadMesh "punctual_tree_from_points_f64: vertex 1 is not finite along axis 1";
        punctual_tree_from_points_f64(null(), 2, 0.0, Some(&mut b)) => null "points";
        punctual_tree_from_points_f32(null(), 0, -1.0, Some(&mut c))
            => BadArgument "punctual_tree_from_points_f32: radius is -1, which is negative or no number";
        punctual_tree_with_radius(None, 1.0, None) => null "tree";
    }
}
