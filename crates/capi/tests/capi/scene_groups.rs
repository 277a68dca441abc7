//! Compounds, groups and places of contact of scenes are those of Rust, and what is refused.

use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use std::sync::Arc;

use super::call::*;
use super::scene_answers::{Both, all, at};
use ::punctual_scene::{Body, Filter, PairQuestion};
use punctual::tree::Solid;
use punctual::{BuildOptions, Motion, Tree, shapes};
use punctual_capi::{punctual_status as Status, *};

#[test]
fn compounds_and_groups_are_those_of_rust() {
    let Both {
        mut scene,
        mut native,
        ids,
    } = Both::new();
    let tree = tree_of(&owned(|mesh| punctual_shape_icosphere(3, mesh)));
    let ball = Arc::new(Tree::new(shapes::icosphere(3)));
    let parts = [0.0, 1.0].map(|x| punctual_body_new(Some(&tree), raw(&at(x))));
    // SAFETY: two parts.
    let compound = made(|id| unsafe {
        punctual_scene_insert_compound(Some(&mut scene), raw(&at(20.0)), parts.as_ptr(), 2, id)
    });
    let theirs = native
        .insert_compound(
            at(20.0),
            [0.0, 1.0].map(|x| Body::moving(Arc::clone(&ball), at(x))),
        )
        .unwrap();
    assert_eq!(compound, theirs.to_bits());
    let shared = Some(&*scene);
    // SAFETY: there is room for as many as said.
    let names = all(|array, room, count| unsafe {
        punctual_scene_parts(shared, compound, array, room, count)
    });
    assert!(
        names
            .iter()
            .copied()
            .eq(native.parts(theirs).unwrap().map(Into::into))
    );
    let mut is_part = MaybeUninit::uninit();
    assert_eq!(
        made(|id| punctual_scene_compound_of(shared, names[1], id, Some(&mut is_part))),
        compound
    );

    let x = [ids[0].0, ids[2].0];
    // SAFETY: two bodies each.
    let groups = made(|id| unsafe {
        punctual_scene_measure_groups(Some(&mut scene), x.as_ptr(), 2, names.as_ptr(), 2, 1e-3, id)
    });
    let parts: Vec<_> = native.parts(theirs).unwrap().collect();
    let expected = native
        .measure_groups(&[ids[0].1, ids[2].1], &parts, 1e-3)
        .unwrap();
    assert_eq!(groups, expected.to_bits());
    let mut both = Both { scene, native, ids };
    for (frame, work) in [1, 20_000, u64::MAX, u64::MAX].into_iter().enumerate() {
        let pose = at(14.0 - frame as f64);
        works(punctual_scene_set_compound_pose(
            Some(&mut both.scene),
            compound,
            raw(&pose),
        ));
        both.native.set_compound_pose(theirs, pose).unwrap();
        both.detect(work);
        let scene = Some(&*both.scene);
        // SAFETY: there is room for as many as said.
        let found = all(|array, room, count| unsafe {
            punctual_scene_group_distances(
                scene,
                array,
                size_of::<punctual_group_distance>(),
                room,
                count,
            )
        });
        assert!(
            found
                .iter()
                .copied()
                .eq(both.native.report().group_distances.iter().map(Into::into))
        );
        assert!(work < u64::MAX || found[0].open == 0 && found[0].bodies[0] == x[1]);
    }
    works(punctual_scene_stop_measuring_groups(
        Some(&mut both.scene),
        groups,
    ));
    both.native.stop_measuring_groups(expected).unwrap();
    let way = punctual_motion_straight(
        raw(&at(14.0)),
        punctual_point {
            x: -6.0,
            ..NO_POINT
        },
    );
    works(punctual_scene_set_compound_motion(
        Some(&mut both.scene),
        compound,
        way,
    ));
    both.native
        .set_compound_motion(
            theirs,
            Motion::straight(at(14.0), [-6.0, 0.0, 0.0]).unwrap(),
        )
        .unwrap();
    assert!(both.detect(u64::MAX)[2] > 0);
    works(punctual_scene_remove_compound(
        Some(&mut both.scene),
        compound,
    ));
    refuses! {
        punctual_scene_remove_compound(Some(&mut both.scene), compound)
            => BadArgument "punctual_scene_remove_compound: compound 0 is not in the scene";
    }
}

#[test]
fn contact_points_are_those_of_rust() {
    let mut both = Both::new();
    let [(a, first), (b, second)] = [both.ids[0], both.ids[1]];
    let contacts = punctual_pair_question::Contacts as u32;
    works(punctual_scene_set_question_importance(
        Some(&mut both.scene),
        contacts,
        0.5,
    ));
    both.native
        .set_question_importance(PairQuestion::Contacts, 0.5)
        .unwrap();
    works(punctual_scene_find_contacts_of(Some(&mut both.scene), a, b));
    both.native.find_contacts_of(first, second).unwrap();
    for (x, work) in [(1.95, 2_000), (1.95, u64::MAX), (5.0, u64::MAX)] {
        both.go(1, x);
        both.detect(work);
        let known = both.native.contacts(first, second).unwrap();
        let mut points = Vec::with_capacity(16);
        // SAFETY: there is room for as many as said.
        let found = made(|found| unsafe {
            punctual_scene_contact_points(
                Some(&both.scene),
                a,
                b,
                points.as_mut_ptr(),
                size_of::<punctual_contact_point>(),
                16,
                slot(found),
            )
        });
        // SAFETY: as many were written.
        unsafe { points.set_len(found.count) };
        assert_eq!(
            (found.low, found.drift, found.age, found.within),
            (known.low, known.drift, known.age, 0)
        );
        assert!(
            points
                .iter()
                .copied()
                .eq(known.points.iter().map(punctual_contact_point::from))
        );
        assert!(work < u64::MAX || points.is_empty() == (x > 2.0));
    }
    works(punctual_scene_stop_finding_contacts_of(
        Some(&mut both.scene),
        a,
        b,
    ));
    both.native.stop_finding_contacts_of(first, second).unwrap();
    let filter = Filter::new(1, 4);
    both.go(1, 1.9);
    for finds in [true, false] {
        let scene = Some(&mut *both.scene);
        let status = match finds {
            true => punctual_scene_find_contacts_between(scene, filter.groups, filter.mask),
            false => {
                punctual_scene_stop_finding_contacts_between(scene, filter.groups, filter.mask)
            }
        };
        assert_eq!(status, Status::Ok);
        match finds {
            true => both.native.find_contacts_between(filter),
            false => both.native.stop_finding_contacts_between(filter),
        }
        both.go(1, if finds { 1.9 } else { 1.8 });
        both.detect(u64::MAX);
        let found = made(|found| unsafe {
            punctual_scene_contact_points(Some(&both.scene), a, b, null_mut(), 0, 0, slot(found))
        });
        let known = both.native.contacts(first, second).unwrap();
        assert_eq!((found.count, found.age), (known.points.len(), known.age));
        assert_eq!((found.count > 0, found.age == 0), (true, finds));
    }
    for ignores in [true, false] {
        let status = punctual_scene_ignore(Some(&mut both.scene), a, b, ignores);
        assert_eq!(status, Status::Ok);
    }
    works(punctual_scene_find_contacts(Some(&mut both.scene)));
    refuses! {
        punctual_scene_set_question_importance(Some(&mut both.scene), 4, 0.0)
            => BadArgument "punctual_scene_set_question_importance: question has no value 4";
    }
}

#[test]
fn which_body_is_within_the_other_is_told_whatever_their_order() {
    let room = solid_of(&owned(|mesh| punctual_shape_cuboid(4.0, 4.0, 4.0, 2, mesh)));
    let ball = solid_of(&owned(|mesh| punctual_shape_icosphere(1, mesh)));
    let mass = made(|mass| punctual_tree_mass_properties(Some(&room), mass));
    let native = Tree::with_options(
        shapes::cuboid([4.0; 3], 2),
        &BuildOptions::default().solid(Solid::Keep),
    );
    let native = native.mass_properties().unwrap();
    assert_eq!(mass.volume, native.volume);
    assert_eq!(mass.center, native.center.into());
    assert_eq!(mass.inertia, native.inertia.to_cols_array());
    for (trees, within) in [([&room, &ball], 2), ([&ball, &room], 1)] {
        let mut scene = owned(|scene| punctual_scene_new(0, 0, scene));
        let [a, b] = trees.map(|tree| {
            let body = punctual_body_new(Some(tree), raw(&at(0.0)));
            // SAFETY: the body is one.
            made(|id| unsafe { punctual_scene_insert(Some(&mut scene), asked(Some(&body)), id) })
        });
        assert_eq!(punctual_scene_find_contacts(Some(&mut scene)), Status::Ok);
        let ahead = punctual_scene_set_look_ahead(Some(&mut scene), 1.0);
        assert_eq!(ahead, Status::Ok);
        for (x, expected) in [(0.0, within), (9.0, 0)] {
            let moved = punctual_scene_set_pose(Some(&mut scene), b, raw(&at(x)));
            assert_eq!(moved, Status::Ok);
            made(|report| detect(Some(&mut scene), punctual_budget_unlimited(), report));
            for [x, y] in [[a, b], [b, a]] {
                let (points, shared) = (null_mut::<punctual_contact_point>(), Some(&*scene));
                let size = size_of::<punctual_contact_point>();
                // SAFETY: no point is written.
                let found = made(|found| unsafe {
                    punctual_scene_contact_points(shared, x, y, points, size, 0, slot(found))
                });
                assert_eq!((found.within, found.count), (expected, 0));
                let most =
                    made(|most| punctual_scene_may_move(Some(&mut scene), x, 9.0, 0.5, most));
                // Half of the gap of the boxes and the sink.
                let right = if expected == 0 { 2.2..2.3 } else { 0.0..1e-300 };
                assert!(right.contains(&most), "{most}");
                assert_eq!(found.low > 0.0, expected == 0);
            }
        }
    }
}

#[test]
fn unknown_bodies_and_groups_are_refused() {
    let Both { mut scene, ids, .. } = Both::new();
    let (id, motion) = (ids[0].0, punctual_motion_straight(raw(&at(0.0)), NO_POINT));
    let pose = raw(&at(0.0));
    refuses! {
        punctual_scene_set_compound_pose(None, 0, pose) => null "scene";
        punctual_scene_set_compound_motion(None, 0, motion) => null "scene";
        punctual_scene_remove_compound(None, 0) => null "scene";
        punctual_scene_stop_measuring_groups(None, 0) => null "scene";
        punctual_scene_find_contacts(None) => null "scene";
        punctual_scene_find_contacts_of(None, id, id) => null "scene";
        punctual_scene_find_contacts_between(None, 1, 1) => null "scene";
        punctual_scene_stop_finding_contacts_between(None, 1, 1) => null "scene";
        punctual_scene_ignore(None, id, id, true) => null "scene";
        punctual_scene_stop_finding_contacts_of(None, id, id) => null "scene";
        punctual_scene_set_look_ahead(None, 0.0) => null "scene";
        punctual_scene_may_move(Some(&mut scene), id, 1.0, 0.0, None) => null "most";
    }
    let most = &mut MaybeUninit::uninit();
    refuses! {
        punctual_scene_may_move(None, id, 1.0, 0.0, Some(most)) => null "scene";
        punctual_scene_set_look_ahead(Some(&mut scene), -1.0)
            => BadArgument "punctual_scene_set_look_ahead: look-ahead: -1 is not a length from 0 to 2^1000";
        punctual_scene_set_question_importance(None, 0, 0.0) => null "scene";
        punctual_scene_compound_of(Some(&scene), id, None, None) => null "compound";
    }
    refuses! {
        punctual_scene_insert_compound(Some(&mut scene), pose, null(), 0, None)
            => null "compound";
        punctual_scene_parts(Some(&scene), 0, null_mut(), 0, None) => null "count";
        punctual_scene_measure_groups(Some(&mut scene), null(), 0, null(), 0, 0.0, None)
            => null "id";
        punctual_scene_group_distances(None, null_mut(), size_of::<punctual_group_distance>(), 0, None)
            => null "scene";
        punctual_scene_contact_points(Some(&scene), id, id, null_mut(), size_of::<punctual_contact_point>(), 0, slot(None))
            => null "found";
    }
    let mut out = MaybeUninit::uninit();
    refuses! {
        punctual_scene_insert_compound(Some(&mut scene), pose, null(), 1, Some(&mut out))
            => null "parts";
        punctual_scene_measure_groups(Some(&mut scene), null(), 1, &id, 1, 0.0, Some(&mut out))
            => null "x";
        punctual_scene_measure_groups(Some(&mut scene), &id, 1, &id, 1, 0.0, Some(&mut out))
            => BadArgument "punctual_scene_measure_groups: body 0 (generation 0) has no distance from itself";
    }
    assert_eq!(
        punctual_scene_set_compound_pose(Some(&mut scene), 7, pose),
        Status::BadArgument
    );
    refuses! { punctual_scene_find_contacts_of(Some(&mut scene), id, NOBODY) => NoSuchBody; }
}
