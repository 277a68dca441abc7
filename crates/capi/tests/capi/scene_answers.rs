//! What else scenes tell: contacts, distances, passages and hits of rays are those of Rust, and what is refused.

use std::mem::MaybeUninit;
use std::ptr::null_mut;
use std::sync::Arc;

use super::call::*;
use ::punctual_scene::{Body, BodyId, Scene, SceneRay};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::rays::RayMode;
use punctual::{Budget, Motion, Pose, Ray, Tree, shapes};
use punctual_capi::{punctual_status as Status, *};

/// What a call writes to an array, and its count: the same with too little room.
pub fn all<T: Copy>(
    call: impl Fn(*mut T, usize, Option<&mut MaybeUninit<usize>>) -> Status,
) -> Vec<T> {
    let count = made(|count| call(null_mut(), 0, count));
    let mut items = Vec::with_capacity(count);
    assert_eq!(made(|again| call(items.as_mut_ptr(), count, again)), count);
    // SAFETY: as many were written.
    unsafe { items.set_len(count) };
    items
}

pub fn at(x: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, [x, 0.0, 0.0]).unwrap()
}

fn same_pair(ours: [punctual_body_id; 2], theirs: [BodyId; 2]) {
    assert_eq!(ours, theirs.map(punctual_body_id::from));
}

/// Balls in C and in Rust, at 0, 4 and 9.
pub struct Both {
    pub scene: Box<punctual_scene>,
    pub native: Scene,
    pub ids: Vec<(punctual_body_id, BodyId)>,
}

impl Both {
    pub fn new() -> Self {
        let tree = tree_of(&owned(|mesh| punctual_shape_icosphere(3, mesh)));
        let ball = Arc::new(Tree::new(shapes::icosphere(3)));
        let mut scene = owned(|scene| punctual_scene_new(0, 0, scene));
        let mut native = Scene::new();
        let mut ids = Vec::new();
        for x in [0.0, 4.0, 9.0] {
            let body = punctual_body {
                margin: 0.01,
                ..punctual_body_new(Some(&tree), raw(&at(x)))
            };
            let id = made(|id| unsafe {
                punctual_scene_insert(Some(&mut scene), asked(Some(&body)), id)
            });
            assert_eq!(
                made(|body| unsafe { punctual_scene_body(Some(&scene), id, slot(body)) }).margin,
                0.01
            );
            ids.push((
                id,
                native
                    .insert(Body::moving(Arc::clone(&ball), at(x)).margin(0.01))
                    .unwrap(),
            ));
        }
        assert_eq!(punctual_scene_track_contacts(Some(&mut scene)), Status::Ok);
        native.track_contacts();
        Self { scene, native, ids }
    }

    pub fn go(&mut self, body: usize, x: f64) {
        works(punctual_scene_set_pose(
            Some(&mut self.scene),
            self.ids[body].0,
            raw(&at(x)),
        ));
        self.native.set_pose(self.ids[body].1, at(x)).unwrap();
    }

    /// A frame of so much work; how many contacts, distances and passages were the same.
    pub fn detect(&mut self, work: u64) -> [usize; 3] {
        made(|report| detect(Some(&mut self.scene), punctual_budget_work(work), report));
        let Self { scene, native, .. } = self;
        let scene = Some(&**scene);
        native.detect(Budget::work(work));
        let expected = native.report();
        // SAFETY: here and below, there is room for as many as said.
        let contacts = all(|array, room, count| unsafe {
            punctual_scene_contacts(
                scene,
                array,
                size_of::<punctual_body_contact>(),
                room,
                count,
            )
        });
        assert_eq!(contacts.len(), expected.contacts.len());
        for (ours, theirs) in contacts.iter().zip(&expected.contacts) {
            same_pair([ours.a, ours.b], [theirs.a, theirs.b]);
            assert_eq!(
                (format!("{:?}", ours.phase), ours.age),
                (format!("{:?}", theirs.phase), theirs.age)
            );
        }
        // SAFETY: as above.
        let distances = all(|array, room, count| unsafe {
            punctual_scene_distances(
                scene,
                array,
                size_of::<punctual_pair_distance>(),
                room,
                count,
            )
        });
        assert_eq!(distances.len(), native.distances().count());
        for (ours, theirs) in distances.iter().zip(native.distances()) {
            same_pair([ours.a, ours.b], [theirs.a, theirs.b]);
            assert_eq!(
                (ours.low, ours.high, ours.age),
                (theirs.low, theirs.high, theirs.age)
            );
            assert_eq!(
                ours.has_triangles
                    .then_some([ours.triangles.a, ours.triangles.b]),
                theirs.triangles
            );
        }
        // SAFETY: as above.
        let passages = all(|array, room, count| unsafe {
            punctual_scene_passages(
                scene,
                array,
                size_of::<punctual_pair_passage>(),
                room,
                count,
            )
        });
        assert_eq!(passages.len(), native.passages().count());
        for (ours, theirs) in passages.iter().zip(native.passages()) {
            same_pair([ours.a, ours.b], [theirs.a, theirs.b]);
            assert_eq!(
                (ours.free_until, ours.touches.then_some(ours.touching_at)),
                (theirs.free_until, theirs.touching_at)
            );
            assert_eq!(
                ours.touches.then_some([ours.triangles.a, ours.triangles.b]),
                theirs.triangles
            );
        }
        [contacts.len(), distances.len(), passages.len()]
    }

    /// Casts a ray along x; how many triangles it hits.
    fn cast(&mut self, mode: RayMode, mask: u32, work: u64) -> u64 {
        let direction = punctual_point { x: 1.0, ..NO_POINT };
        let origin = punctual_point {
            x: -5.0,
            y: 0.1,
            z: 0.2,
        };
        let mut ray = punctual_scene_ray_new(punctual_ray_new(origin, direction));
        assert_eq!((ray.mode, ray.groups, ray.mask), (0, u32::MAX, u32::MAX));
        (ray.mode, ray.mask) = (mode as u32, mask);
        let theirs = SceneRay::new(Ray::new([-5.0, 0.1, 0.2], DVec3::X).unwrap()).mode(mode);
        let theirs = theirs.filter(::punctual_scene::Filter::new(u32::MAX, mask));
        let budget = punctual_budget_work(work);
        // SAFETY: no clock of the caller's.
        let cast = made(|cast| unsafe {
            punctual_scene_cast(
                Some(&mut self.scene),
                asked(Some(&ray)),
                budget,
                None,
                slot(cast),
            )
        });
        let expected = self
            .native
            .cast(&theirs, Budget::work(work).clock(&ManualClock::new()))
            .unwrap();
        assert_eq!(
            (cast.found, cast.free_until),
            (expected.found, expected.free_until)
        );
        assert_eq!((cast.work, cast.elapsed), (expected.work, -1));
        assert_eq!(format!("{:?}", cast.stop), format!("{:?}", expected.stop));
        assert_eq!(cast.hit, expected.hit.into());
        let scene = Some(&*self.scene);
        // SAFETY: there is room for as many as said.
        let hits =
            all(|array, room, count| unsafe { punctual_scene_ray_hits(scene, array, room, count) });
        assert!(
            hits.iter()
                .copied()
                .eq(self.native.ray_hits().iter().map(|&hit| Some(hit).into()))
        );
        assert_eq!(
            hits.len() as u64,
            if mode == RayMode::All { cast.found } else { 0 }
        );
        cast.found
    }
}

#[test]
fn scenes_tell_contacts_distances_and_passages_as_in_rust() {
    let mut both = Both::new();
    let (first, second, third) = (both.ids[0], both.ids[1], both.ids[2]);
    assert_eq!(both.detect(u64::MAX), [0, 0, 0]);
    both.go(1, 2.1);
    works(punctual_scene_set_margin(
        Some(&mut both.scene),
        first.0,
        0.2,
    ));
    both.native.set_margin(first.1, 0.2).unwrap();
    assert_eq!(both.detect(u64::MAX), [1, 0, 0], "they begin to touch");
    both.go(1, 2.05);
    both.detect(1);
    assert_eq!(both.detect(u64::MAX), [1, 0, 0]);
    both.go(1, 5.0);
    assert_eq!(both.detect(u64::MAX), [1, 0, 0], "they part");

    works(punctual_scene_measure(
        Some(&mut both.scene),
        first.0,
        third.0,
        1e-3,
    ));
    both.native.measure(first.1, third.1, 1e-3).unwrap();
    assert_eq!(both.detect(1), [0, 1, 0], "nothing is known yet");
    assert_eq!(both.detect(u64::MAX), [0, 1, 0]);
    works(punctual_scene_stop_measuring(
        Some(&mut both.scene),
        third.0,
        first.0,
    ));
    both.native.stop_measuring(third.1, first.1).unwrap();
    assert_eq!(both.detect(u64::MAX), [0, 0, 0]);

    let way = punctual_motion_straight(raw(&at(4.5)), punctual_point { x: 3.5, ..NO_POINT });
    works(punctual_scene_set_motion(
        Some(&mut both.scene),
        second.0,
        way,
    ));
    both.native
        .set_motion(
            second.1,
            Motion::straight(at(4.5), [3.5, 0.0, 0.0]).unwrap(),
        )
        .unwrap();
    assert_eq!(both.detect(u64::MAX)[2], 1, "they meet on the way");
}

#[test]
fn rays_hit_bodies_as_in_rust() {
    let mut both = Both::new();
    both.detect(u64::MAX);
    assert!(both.cast(RayMode::Nearest, u32::MAX, u64::MAX) >= 1);
    assert_eq!(both.cast(RayMode::Any, u32::MAX, u64::MAX), 1);
    assert_eq!(both.cast(RayMode::All, u32::MAX, u64::MAX), 6);
    // The filter lets none pass.
    assert_eq!(both.cast(RayMode::Nearest, 0, u64::MAX), 0);
    both.cast(RayMode::All, u32::MAX, 1000);
    assert_eq!(both.cast(RayMode::Nearest, u32::MAX, 1), 0);
}

#[test]
fn unknown_bodies_and_motions_are_refused() {
    let Both { mut scene, ids, .. } = Both::new();
    let (id, unlimited) = (ids[0].0, punctual_budget_unlimited());
    let ray = punctual_scene_ray_new(punctual_ray_new(
        NO_POINT,
        punctual_point { x: 1.0, ..NO_POINT },
    ));
    let motion = punctual_motion_straight(raw(&at(0.0)), NO_POINT);
    refuses! {
        punctual_scene_set_margin(None, id, 0.0) => null "scene";
        punctual_scene_track_contacts(None) => null "scene";
        punctual_scene_measure(None, id, id, 0.0) => null "scene";
        punctual_scene_stop_measuring(None, id, id) => null "scene";
        punctual_scene_set_motion(None, id, motion) => null "scene";
    }
    let mut cast = MaybeUninit::uninit();
    refuses! {
        punctual_scene_contacts(None, null_mut(), size_of::<punctual_body_contact>(), 0, None)
            => null "scene";
        punctual_scene_distances(None, null_mut(), size_of::<punctual_pair_distance>(), 0, None)
            => null "scene";
        punctual_scene_passages(None, null_mut(), size_of::<punctual_pair_passage>(), 0, None)
            => null "scene";
        punctual_scene_ray_hits(None, null_mut(), 0, None) => null "scene";
        punctual_scene_contacts(Some(&scene), null_mut(), size_of::<punctual_body_contact>(), 0, None)
            => null "count";
        punctual_scene_distances(Some(&scene), null_mut(), size_of::<punctual_pair_distance>(), 0, None)
            => null "count";
        punctual_scene_passages(Some(&scene), null_mut(), size_of::<punctual_pair_passage>(), 0, None)
            => null "count";
        punctual_scene_ray_hits(Some(&scene), null_mut(), 0, None) => null "count";
        punctual_scene_cast(None, asked(Some(&ray)), unlimited, None, slot(Some(&mut cast)))
            => null "scene";
        punctual_scene_cast(Some(&mut scene), asked(None), unlimited, None, slot(Some(&mut cast)))
            => null "ray";
        punctual_scene_cast(Some(&mut scene), asked(Some(&ray)), unlimited, None, slot(None))
            => null "cast";
    }
    let odd = punctual_scene_ray { mode: 3, ..ray };
    refuses! {
        punctual_scene_cast(Some(&mut scene), asked(Some(&odd)), unlimited, None, slot(Some(&mut cast)))
            => BadArgument "punctual_scene_cast: ray->mode has no value 3";
    }
    let scene = &mut *scene;
    refuses! { punctual_scene_set_margin(Some(scene), NOBODY, 0.0) => NoSuchBody; }
    refuses! { punctual_scene_measure(Some(scene), id, NOBODY, 0.0) => NoSuchBody; }
    refuses! { punctual_scene_stop_measuring(Some(scene), id, NOBODY) => NoSuchBody; }
    refuses! { punctual_scene_set_motion(Some(scene), NOBODY, motion) => NoSuchBody; }
    let text = "body 0 (generation 0): -1 is not a length from 0 to 2^1000";
    refuses! {
        punctual_scene_set_margin(Some(scene), id, -1.0)
            => BadArgument &format!("punctual_scene_set_margin: {text}");
        punctual_scene_measure(Some(scene), id, ids[1].0, -1.0)
            => BadArgument &format!("punctual_scene_measure: {text}");
        punctual_scene_measure(Some(scene), id, id, 0.0)
            => BadArgument "punctual_scene_measure: body 0 (generation 0) has no distance from itself";
    }
    let far = punctual_point {
        x: f64::NAN,
        ..NO_POINT
    };
    let status = punctual_scene_set_motion(
        Some(scene),
        id,
        punctual_motion {
            velocity: far,
            ..motion
        },
    );
    assert_eq!(status, Status::BadArgument, "{}", last_error());
}

#[test]
fn bodies_within_their_margins_say_how_far_apart_the_witness_is() {
    let mut both = Both::new();
    both.go(1, 2.0);
    for (x, verdict) in [
        (2.005, punctual_verdict::Within),
        (1.5, punctual_verdict::Within),
        (2.5, punctual_verdict::Separated),
    ] {
        both.go(1, x);
        both.detect(u64::MAX);
        let (scene, ids) = (&both.scene, &both.ids);
        let mut listed = MaybeUninit::uninit();
        let mut pair = MaybeUninit::uninit();
        let size = size_of::<punctual_pair_report>();
        // SAFETY: of the size that is said, and `listed` is written by the call.
        let (status, listed) = unsafe {
            let status = punctual_scene_pair(
                Some(scene),
                ids[0].0,
                ids[1].0,
                row(Some(&mut pair)),
                size,
                Some(&mut listed),
            );
            (status, listed.assume_init())
        };
        assert_eq!(status, Status::Ok);
        let native = both.native.report();
        let Some(expected) = native.pair(ids[0].1, ids[1].1) else {
            assert!(!listed && verdict == punctual_verdict::Separated);
            continue;
        };
        // SAFETY: written, as it is listed.
        let pair = unsafe { pair.assume_init() };
        // SAFETY: of the size that it says.
        let report = made(|report| unsafe { punctual_scene_report(Some(scene), slot(report)) });
        assert_eq!(
            (report.within, report.intersecting),
            (native.within, native.intersecting)
        );
        let distance = expected.verdict.witness_distance().unwrap_or(f64::INFINITY);
        assert_eq!(
            (pair.witness_distance, [pair.witness.a, pair.witness.b]),
            (distance, expected.verdict.witness().unwrap_or_default())
        );
        let is_within = pair.verdict == punctual_verdict::Within;
        assert_eq!(is_within, distance > 0.0 && distance <= 0.02, "{pair:?}");
        assert!(
            is_within
                || x != 2.005
                    && (pair.verdict == punctual_verdict::Intersecting) == (distance == 0.0)
        );
    }
}

#[test]
fn an_id_of_another_scene_is_refused() {
    let [mut one, other] = [Both::new(), Both::new()];
    let (ours, theirs) = (one.ids[0].0, other.ids[0].0);
    assert_eq!(ours, theirs);
    refuses! { punctual_scene_set_margin(Some(&mut one.scene), theirs, 0.5) => NoSuchBody; }
    assert!(last_error().ends_with("body 0 (generation 0) is not in the scene"));
    works(punctual_scene_set_margin(Some(&mut one.scene), ours, 0.5));
    let stored = punctual_body_id { scene: 0, ..theirs };
    works(punctual_scene_set_margin(Some(&mut one.scene), stored, 0.5));
}
