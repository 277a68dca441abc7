//! Shapes and batches of rays in scenes, and named groups, beside the answers of the Rust interface.

use std::mem::MaybeUninit;
use std::ptr::null_mut;
use std::sync::Arc;

use crate::call::*;
use ::punctual_scene::{Body, BodyId, Scene, SceneShape, ShapeHit};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Mode, Motion, Pose, Tree, shapes};
use punctual_capi::{punctual_status as Status, *};

/// A scene of three cubes in a row, of C and of Rust.
struct Both {
    scene: Box<punctual_scene>,
    native: Scene,
    ids: Vec<(punctual_body_id, BodyId)>,
    cube: Box<punctual_tree>,
    tree: Arc<Tree>,
}

fn at(x: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::X * x).unwrap()
}

impl Both {
    fn new() -> Self {
        let mesh = owned(|mesh| punctual_shape_cuboid(1.0, 1.0, 1.0, 2, mesh));
        let cube = tree_of(&mesh);
        let mut scene = owned(|scene| punctual_scene_new(0, 0, scene));
        let tree = Arc::new(Tree::new(shapes::cuboid([1.0; 3], 2)));
        let (mut native, mut ids) = (Scene::new(), Vec::new());
        for x in [0.0, 2.5, 5.0] {
            let body = punctual_body_new(Some(&cube), raw(&at(x)));
            // SAFETY: a struct of this call.
            let id = made(|id| unsafe {
                punctual_scene_insert(Some(&mut scene), asked(Some(&body)), id)
            });
            let own = Body::moving(Arc::clone(&tree), at(x));
            ids.push((id, native.insert(own).unwrap()));
        }
        Self {
            scene,
            native,
            ids,
            cube,
            tree,
        }
    }
}

fn motion(x: f64, way: f64) -> punctual_motion {
    let velocity = punctual_point {
        x: way,
        y: 0.0,
        z: 0.0,
    };
    punctual_motion_straight(raw(&at(x)), velocity)
}

fn assert_hit(hit: &punctual_shape_hit, expected: Option<ShapeHit>) {
    assert_eq!(hit.is_there, expected.is_some());
    assert_eq!(*hit, expected.into());
}

#[test]
fn shapes_are_answered_as_in_rust() {
    let mut both = Both::new();
    let tree = Arc::clone(&both.tree);
    for (x, way, margin, asks_for, work) in [
        (-6.0, 9.0, 0.0, None, u64::MAX >> 1),
        (-6.0, 9.0, 0.5, Some(0), u64::MAX >> 1),
        (1.2, -1.0, 0.0, None, u64::MAX >> 1),
        (-6.0, 9.0, 0.0, None, 3_000),
    ] {
        let mut shape = punctual_scene_shape_new(Some(&both.cube), motion(x, way));
        let ours = SceneShape::moving(&tree, Motion::straight(at(x), DVec3::X * way).unwrap());
        let mut ours = ours.margin(margin);
        shape.margin = margin;
        if let Some(body) = asks_for {
            (shape.has_body, shape.body) = (1, both.ids[body].0);
            ours = ours.of_body(both.ids[body].1);
        }
        let (budget, clock) = (punctual_budget_work(work), ManualClock::new());
        let own = Budget::work(work).clock(&clock);
        // SAFETY: no clock of the caller's, and room for as many as said.
        unsafe {
            let cast = made(|cast| {
                let scene = Some(&mut *both.scene);
                punctual_scene_cast_shape(scene, asked(&shape), budget, None, slot(cast))
            });
            let expected = both.native.cast_shape(&ours, own).unwrap();
            assert_eq!(cast.free_until, expected.free_until);
            assert_eq!(cast.touching_at, expected.touching_at.unwrap_or(0.0));
            assert_eq!((cast.work, cast.elapsed), (expected.work, -1));
            assert_hit(&cast.hit, expected.hit);
            let closest = made(|closest| {
                let scene = Some(&mut *both.scene);
                punctual_scene_closest(scene, asked(&shape), 9.0, budget, None, slot(closest))
            });
            let expected = both.native.closest(&ours, 9.0, own).unwrap();
            assert_eq!((closest.low, closest.high), (expected.low, expected.high));
            assert_eq!((closest.work, closest.elapsed), (expected.work, -1));
            assert_hit(&closest.hit, expected.hit);
            let mut met = [MaybeUninit::<punctual_body_overlap>::uninit(); 4];
            let mut undecided = [punctual_body_id::default(); 4];
            let overlap = made(|overlap| {
                punctual_scene_overlap(
                    Some(&mut *both.scene),
                    asked(&shape),
                    1,
                    budget,
                    None,
                    met.as_mut_ptr().cast(),
                    size_of::<punctual_body_overlap>(),
                    4,
                    undecided.as_mut_ptr(),
                    4,
                    slot(overlap),
                )
            });
            let expected = both.native.overlap(&ours, Mode::All, own).unwrap();
            assert_eq!(overlap.met as usize, expected.met.len());
            assert_eq!(overlap.undecided as usize, expected.undecided.len());
            assert_eq!(overlap.is_whole == 1, expected.is_whole);
            for (ours, theirs) in met.iter().zip(expected.met) {
                assert_eq!(ours.assume_init(), theirs.into());
            }
            for (&ours, &theirs) in undecided.iter().zip(expected.undecided) {
                assert_eq!(ours, theirs.into());
            }
        }
    }
}

#[test]
fn a_batch_of_rays_is_answered_ray_by_ray_and_groups_hide_bodies() {
    let mut both = Both::new();
    let ray = |y: f64| {
        let point = |x, y, z| punctual_point { x, y, z };
        punctual_scene_ray_new(punctual_ray_new(point(-5.0, y, 0.1), point(1.0, 0.0, 0.0)))
    };
    let mut rays = [ray(0.2), ray(9.0), ray(0.3)];
    (rays[2].has_body, rays[2].body) = (1, both.ids[0].0);
    let cast = |scene: &mut punctual_scene, rays: &[punctual_scene_ray], work| {
        let mut casts = [MaybeUninit::<punctual_scene_ray_cast>::uninit(); 3];
        let (budget, size) = (punctual_budget_work(work), size_of_val(&casts[0]));
        // SAFETY: no clock of the caller's, and room for as many as said.
        let done = made(|done| unsafe {
            let place = casts.as_mut_ptr().cast();
            punctual_scene_cast_rays(
                Some(scene),
                rays.as_ptr(),
                3,
                budget,
                None,
                place,
                size,
                done,
            )
        });
        // SAFETY: all three are written.
        (done, casts.map(|cast| unsafe { cast.assume_init() }))
    };
    let (done, casts) = cast(&mut both.scene, &rays, 1 << 40);
    assert_eq!(
        (done, casts[1].found, casts[1].free_until),
        (3, 0, f64::INFINITY)
    );
    assert_eq!(
        [casts[0].hit.body, casts[2].hit.body],
        [both.ids[0].0, both.ids[1].0]
    );
    let (done, casts) = cast(&mut both.scene, &rays, casts[0].work + 1);
    assert!(done < 3 && casts[2].free_until == 0.0);

    let scene = &mut *both.scene;
    // SAFETY: texts that end with a zero byte.
    let [left, right, same] = [c"left", c"right", c"left"].map(|name| {
        made(|group| unsafe { punctual_scene_group(Some(&mut *scene), name.as_ptr(), group) })
    });
    assert!(left == same && left != right);
    for (body, group) in [(0, left), (1, right)] {
        let status = punctual_scene_set_group(Some(scene), both.ids[body].0, group);
        assert_eq!(status, Status::Ok);
    }
    works(punctual_scene_ignore_groups(Some(scene), left, right, true));
    let (_, casts) = cast(scene, &rays, 1 << 40);
    assert_eq!(casts[2].hit.body, both.ids[2].0);
    let status = punctual_scene_set_group(Some(scene), both.ids[1].0, PUNCTUAL_NO_GROUP);
    assert_eq!(status, Status::Ok);
    let (_, casts) = cast(scene, &rays, 1 << 40);
    assert_eq!(casts[2].hit.body, both.ids[1].0);
}

#[test]
fn bad_shapes_and_groups_are_refused_by_name() {
    let Both {
        mut scene,
        cube,
        ids,
        ..
    } = Both::new();
    let (shape, unlimited) = (
        punctual_scene_shape_new(Some(&cube), motion(0.0, 1.0)),
        punctual_budget_unlimited(),
    );
    let odd = punctual_scene_shape {
        margin: -1.0,
        ..shape
    };
    let gone = punctual_scene_shape {
        has_body: 1,
        body: NOBODY,
        ..shape
    };
    let (mut cast, mut closest) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    // SAFETY: nothing but null, and places of this call.
    unsafe {
        let (shape, odd, gone) = (asked(&shape), asked(&odd), asked(&gone));
        let mut place = || slot(Some(&mut cast));
        refuses! {
            punctual_scene_cast_shape(None, shape, unlimited, None, place()) => null "scene";
        }
        let own = Some(&mut *scene);
        refuses! {
            punctual_scene_cast_shape(own, asked(None), unlimited, None, place()) => null "shape";
        }
        let own = Some(&mut *scene);
        refuses! {
            punctual_scene_cast_shape(own, shape, unlimited, None, null_mut()) => null "cast";
        }
        let own = Some(&mut *scene);
        refuses! {
            punctual_scene_cast_shape(own, odd, unlimited, None, place())
                => BadArgument "punctual_scene_cast_shape: the shape: its margin is not from 0 to 2^1000";
        }
        let own = Some(&mut *scene);
        let status = punctual_scene_cast_shape(own, gone, unlimited, None, place());
        assert_eq!(status, Status::NoSuchBody);
        let own = Some(&mut *scene);
        let place = slot(Some(&mut closest));
        let status = punctual_scene_closest(own, shape, f64::NAN, unlimited, None, place);
        assert_eq!(status, Status::BadArgument);
        refuses! {
            punctual_scene_closest(None, shape, 1.0, unlimited, None, place) => null "scene";
        }
        let (size, mut overlap) = (size_of::<punctual_body_overlap>(), MaybeUninit::uninit());
        let place = slot(Some(&mut overlap));
        let (none, nobody) = (null_mut(), null_mut());
        refuses! {
            punctual_scene_overlap(Some(&mut *scene), shape, 2, unlimited, None, none, size, 0, nobody, 0, place)
                => BadArgument "punctual_scene_overlap: mode has no value 2";
            punctual_scene_overlap(Some(&mut *scene), shape, 1, unlimited, None, none, size, 1, nobody, 0, place)
                => null "met";
        }
        let (mut done, size) = (MaybeUninit::uninit(), size_of::<punctual_scene_ray_cast>());
        let (rays, casts) = (std::ptr::null(), null_mut());
        let own = Some(&mut *scene);
        refuses! {
            punctual_scene_cast_rays(own, rays, 1, unlimited, None, casts, size, Some(&mut done))
                => null "rays";
        }
        let own = Some(&mut *scene);
        refuses! {
            punctual_scene_cast_rays(own, rays, 0, unlimited, None, casts, size, None)
                => null "done";
        }
        let (own, mut group) = (Some(&mut *scene), MaybeUninit::uninit());
        refuses! {
            punctual_scene_group(own, std::ptr::null(), Some(&mut group)) => null "name";
        }
    }
    let own = Some(&mut *scene);
    assert_eq!(
        punctual_scene_set_group(own, ids[0].0, 5),
        Status::BadArgument
    );
    let own = Some(&mut *scene);
    refuses! { punctual_scene_set_group(own, NOBODY, PUNCTUAL_NO_GROUP) => NoSuchBody; }
    let own = Some(&mut *scene);
    assert_eq!(
        punctual_scene_ignore_groups(own, 0, 0, true),
        Status::BadArgument
    );
    refuses! {
        punctual_scene_set_group(None, NOBODY, 0) => null "scene";
        punctual_scene_ignore_groups(None, 0, 0, true) => null "scene";
    }
}
