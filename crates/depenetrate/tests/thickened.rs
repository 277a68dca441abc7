//! How deep thickened bodies penetrate each other, against closed forms.

use punctual::geom::random::Random;
use punctual::glam::{DMat3, DVec3};
use punctual::tree::Solid;
use punctual::{Budget, BuildOptions, Mesh, Pose, Query, Tree, Workspace, shapes};
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};

fn ball(radius: f64) -> Tree {
    let point = Mesh::from_f64(vec![[0.0; 3]], vec![[0; 3]]).unwrap();
    Tree::new(point).with_radius(radius).unwrap()
}

fn cube(half: f64, radius: f64) -> Tree {
    let options = BuildOptions::default().solid(Solid::Keep);
    let tree = Tree::with_options(shapes::cuboid([half as f32; 3], 1), &options);
    tree.with_radius(radius).unwrap()
}

fn at(place: DVec3) -> Pose {
    Pose::new(DMat3::IDENTITY, place).unwrap()
}

#[test]
fn the_depth_of_thickened_bodies_is_within_its_bounds() {
    let (mut random, mut workspace) = (Random::new(1), PenetrationWorkspace::new());
    let [mut deep, mut tight] = [0; 2];
    for i in 0..300 {
        let place = [(); 3].map(|()| random.between(-1.6, 1.6));
        let place = DVec3::from_array(place);
        // The depth where the closed form is known: two balls, a ball beside or in a box, two
        // rounded boxes whose cores overlap.
        let (a, b, truth) = match i % 3 {
            0 => (ball(0.7), ball(0.4), 1.1 - place.length()),
            1 => {
                let beyond = place.abs() - 0.5;
                let outside = beyond.max(DVec3::ZERO).length();
                let truth = 0.45 - outside - beyond.max_element().min(0.0);
                (cube(0.5, 0.125), ball(0.325), truth)
            }
            _ => {
                let beyond = place.abs() - 1.0;
                let outside = beyond.max(DVec3::ZERO).length();
                let truth = 0.375 - outside - beyond.max_element().min(0.0);
                (cube(0.5, 0.25), cube(0.5, 0.125), truth)
            }
        };
        let is_inside = i % 3 == 1 && (place.abs() - 0.5).max_element() < 0.0;
        if is_inside {
            // The core is no solid's part here: surfaces only.
            continue;
        }
        let query = PenetrationQuery::new(&a, &b, at(place)).solid(true);
        let mut answer = query.run(&mut workspace, Budget::work(3_000));
        let mut calls = 0;
        while !answer.stop.is_final() && calls < 400 {
            assert!(answer.value.low <= truth.max(0.0) + 1e-9, "{i} {truth}");
            assert!(answer.value.high >= truth.max(0.0) - 1e-9, "{i} {truth}");
            answer = query.resume(&mut workspace, Budget::work(3_000)).unwrap();
            calls += 1;
        }
        let found = answer.value;
        assert!(
            found.low <= truth.max(0.0) + 1e-9 && truth <= found.high + 1e-9,
            "{i} {found:?}"
        );
        if truth > 1e-6 {
            deep += 1;
            tight += usize::from(found.high <= 1.01 * found.low + 1e-9);
            let apart = Query::intersection(&a, &b, found.b_in_a);
            let verdict = apart.run(&mut Workspace::new(), Budget::unlimited()).value;
            assert!(!verdict.meets(), "{i} {found:?}");
        } else if truth < -1e-6 {
            assert_eq!((found.low, found.high), (0.0, 0.0));
        }
    }
    assert!(deep > 30 && 2 * tight > deep, "{deep} {tight}");
}

#[test]
fn a_capsule_in_a_thick_box_is_no_deeper_than_both_radii_say() {
    let (mut random, mut workspace) = (Random::new(2), PenetrationWorkspace::new());
    let mut inside = 0;
    for i in 0..200 {
        let [radius, of_box, length] =
            [(0.05, 0.5), (0.0, 0.4), (0.1, 1.5)].map(|(least, most)| random.between(least, most));
        let half = [(); 3].map(|()| random.between(0.1, 1.0));
        let block = Tree::cuboid(half.map(|x| 2.0 * x)).unwrap();
        let block = block.with_radius(of_box).unwrap();
        let capsule = Tree::capsule(radius, length).unwrap();
        // Its core meets that of the box at the translations of a box that is longer along z.
        let reach = DVec3::from_array(half) + DVec3::Z * (length / 2.0);
        let place = reach * DVec3::from_array([(); 3].map(|()| random.between(-1.2, 1.2)));
        let beyond = place.abs() - reach;
        let apart = beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0);
        let truth = (radius + of_box - apart).max(0.0);
        inside += usize::from(apart < 0.0);
        let (trees, pose) = match i % 2 {
            0 => ([&block, &capsule], at(place)),
            _ => ([&capsule, &block], at(-place)),
        };
        let query = PenetrationQuery::new(trees[0], trees[1], pose).solid(true);
        let found = query.run(&mut workspace, Budget::work(1_000_000)).value;
        assert!(found.low <= truth + 1e-9, "{i} {truth} {found:?}");
        assert!(truth <= found.high + 1e-9, "{i} {truth} {found:?}");
    }
    assert!(inside > 60);
}
