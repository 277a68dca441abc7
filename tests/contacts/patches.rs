//! Patches: what hangs together by the letter of the definition, what stands for it, and ids that last.

use std::collections::{BTreeMap, BTreeSet};

use punctual::contacts::{Contact, Patch, Patches};
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Budget, Mesh, Pose, Query, Tree, Workspace, shapes};

use crate::common::random::{Drift, Family, Random, pose_about, soup};
use crate::finished::moved;
use crate::truth::{ENOUGH, listed, run};

fn contacts(a: &Tree, b: &Tree, pose: Pose, margin: f64, budget: Budget) -> Vec<Contact> {
    let mut workspace = Workspace::new();
    workspace.reserve_contacts(60_000);
    let _ = run(
        &Query::contacts(a, b, pose).margin(margin),
        &mut workspace,
        budget,
    );
    listed(&workspace)
}

/// Two triangles.
fn floor() -> Tree {
    let corners = [
        [-9.0f32, -9.0, 0.0],
        [9.0, -9.0, 0.0],
        [9.0, 9.0, 0.0],
        [-9.0, 9.0, 0.0],
    ];
    Tree::new(Mesh::new(corners, [[0, 1, 2], [0, 2, 3]]).unwrap())
}

/// Four legs, each a box of edge 1 on the plane z = 0; each cell of their surface is a square.
fn table() -> Tree {
    let leg = shapes::cuboid(Vec3::splat(0.5), 3);
    let places =
        [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [4.0, 4.0]].map(|[x, y]| DVec3::new(x, y, 0.5));
    let vertices = places
        .iter()
        .flat_map(|place| (0..leg.vertex_count()).map(|i| leg.vertex(i) + *place));
    let count = leg.vertex_count() as u32;
    let triangles = (0..4).flat_map(|i| {
        leg.triangles()
            .iter()
            .map(move |t| t.map(|vertex| vertex + i * count))
    });
    Tree::new(Mesh::from_f64(vertices, triangles).unwrap())
}

/// The sets of triangle pairs of the patches, by the definition: neighbors of neighbors.
fn expected(a: &Tree, b: &Tree, contacts: &[Contact]) -> BTreeSet<BTreeSet<[u32; 2]>> {
    let touch = |tree: &Tree, x: u32, y: u32| {
        let [x, y] = [x, y].map(|id| tree.mesh().triangle(id as usize));
        x.iter().any(|corner| y.contains(corner))
    };
    let mut left: Vec<_> = contacts.iter().map(|contact| contact.triangles).collect();
    let mut groups = BTreeSet::new();
    while let Some(first) = left.pop() {
        let (mut group, mut next) = (BTreeSet::from([first]), vec![first]);
        while let Some([i, j]) = next.pop() {
            let (near, far) = left
                .into_iter()
                .partition(|&[k, l]| touch(a, i, k) && touch(b, j, l));
            left = far;
            group.extend(&near);
            next.extend::<Vec<[u32; 2]>>(near);
        }
        groups.insert(group);
    }
    groups
}

/// Everything that is true of all patches.
#[track_caller]
fn assert_true(a: &Tree, b: &Tree, given: &[Contact], patches: &Patches) {
    let pairs = |patch: &Patch| {
        patches
            .contacts_of(patch)
            .iter()
            .map(|contact| contact.triangles)
            .collect()
    };
    let groups: BTreeSet<BTreeSet<[u32; 2]>> = patches.as_slice().iter().map(pairs).collect();
    assert_eq!(groups, expected(a, b, given));
    assert!(
        patches
            .as_slice()
            .is_sorted_by(|x, y| x.distance <= y.distance)
    );
    let ids: BTreeSet<u64> = patches.as_slice().iter().map(|patch| patch.id).collect();
    assert_eq!(ids.len(), patches.as_slice().len(), "an id is there twice");
    for patch in patches.as_slice() {
        let of = patches.contacts_of(patch);
        assert_eq!(
            (patch.contact_count(), patch.distance),
            (of.len(), of[0].distance)
        );
        assert!((patch.normal.length() - 1.0).abs() < 1e-14);
        // In a unit of which no square is too large.
        let unit = patch
            .bounds
            .min
            .abs()
            .max(patch.bounds.max.abs())
            .max_element()
            .max(f64::MIN_POSITIVE);
        let segments = of.iter().filter_map(|contact| contact.segment);
        let length: f64 = segments.map(|[p, q]| (p / unit).distance(q / unit)).sum();
        assert!((patch.length / unit - length).abs() <= 1e-12 * length.max(1.0));
        let slack = 1e-12 * unit;
        let is_within = |point: DVec3| {
            (patch.bounds.min - slack).cmple(point).all()
                && point.cmple(patch.bounds.max + slack).all()
        };
        assert!(
            is_within(patch.centroid)
                && of
                    .iter()
                    .all(|contact| contact.points.into_iter().all(is_within))
        );
        let points: Vec<&Contact> = patches.points_of(patch).collect();
        assert!(
            points[0] == &of[0]
                && points.len() <= 4
                && points.iter().all(|point| of.contains(point))
        );
        let distinct: BTreeSet<_> = points.iter().map(|point| point.triangles).collect();
        assert_eq!(distinct.len(), points.len(), "a point is there twice");
    }
}

#[test]
fn patches_are_what_hangs_together() {
    let mut random = Random::new(41);
    let mut patches = Patches::new();
    let trees = [
        shapes::icosphere(2),
        shapes::torus(1.0, 0.2, 12),
        shapes::gear(7, 1),
        shapes::cuboid(Vec3::ONE, 3),
    ];
    let trees = trees.map(Tree::new);
    let mut counts = Vec::new();
    for (i, a) in trees.iter().enumerate() {
        for b in &trees[i..] {
            let pose = pose_about(DVec3::ZERO, 0.8, Drift::None, &mut random);
            for budget in [ENOUGH, Budget::work(20_000)] {
                let given = contacts(a, b, pose, 0.01, budget);
                patches.update(a, b, &given);
                assert_true(a, b, &given, &patches);
                counts.push(patches.as_slice().len());
            }
        }
    }
    println!("{counts:?}");
    assert!(counts.iter().filter(|count| **count > 1).count() >= 5 && counts.contains(&1));
    for family in [
        Family::Grid,
        Family::Duplicate,
        Family::Degenerate,
        Family::Denormal,
        Family::Enormous,
    ] {
        let [a, b] = [(); 2].map(|()| Tree::new(soup(family, 25, &mut random)));
        let given = contacts(&a, &b, Pose::IDENTITY, 0.1 * family.scale(), ENOUGH);
        patches.update(&a, &b, &given);
        assert_true(&a, &b, &given, &patches);
    }
}

/// Each foot of a table on two large triangles is a patch, with its corners for points.
#[test]
fn a_table_stands_on_four_patches() {
    let (floor, table) = (floor(), table());
    let given = contacts(&floor, &table, moved(0.25, -0.5, 0.01), 0.02, ENOUGH);
    let mut patches = Patches::new();
    patches.update(&floor, &table, &given);
    assert_true(&floor, &table, &given, &patches);
    assert_eq!(patches.as_slice().len(), 4);
    for patch in patches.as_slice() {
        assert!(
            (patch.normal - DVec3::NEG_Z).length() < 1e-9 && (patch.distance - 0.01).abs() < 1e-12,
            "{patch:?}"
        );
        assert_eq!((patch.length, patch.is_closed), (0.0, false));
        let points: Vec<_> = patches.points_of(patch).collect();
        assert_eq!(points.len(), 4);
        let corners = points.iter().map(|point| point.points[1]);
        let (low, high) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        let extent = high - low;
        assert!(extent.x > 0.6 && extent.y > 0.6, "the points span {extent}");
    }
    let mut few = Patches::new().point_limit(0);
    few.update(&floor, &table, &given);
    assert!(
        few.as_slice()
            .iter()
            .all(|patch| few.points_of(patch).len() == 1)
    );
    let mut many = Patches::new().point_limit(100);
    many.update(&floor, &table, &given);
    assert!(
        many.as_slice()
            .iter()
            .all(|patch| many.points_of(patch).len() > 4)
    );
}

/// The curves in which surfaces cross are closed; a part of one is not.
#[test]
fn curves_close_up() {
    let [ball, ring] = [shapes::icosphere(3), shapes::torus(1.0, 0.3, 24)].map(Tree::new);
    let pose = Pose::new(DMat3::from_rotation_x(0.3), DVec3::new(1.1, 0.2, 0.1)).unwrap();
    let given = contacts(&ball, &ring, pose, 0.0, ENOUGH);
    let mut patches = Patches::new();
    patches.update(&ball, &ring, &given);
    assert!(!patches.as_slice().is_empty());
    for patch in patches.as_slice() {
        assert!(patch.is_closed && patch.length > 0.5, "{patch:?}");
    }
    let part = &given[..given.len() / 3];
    patches.update(&ball, &ring, part);
    assert!(patches.as_slice().iter().all(|patch| !patch.is_closed));
}

/// Feet that slide keep their ids, whatever goes on at the others; what left the ground and comes back is another patch.
#[test]
fn ids_last_while_triangles_are_shared() {
    let (floor, table) = (floor(), table());
    let mut patches = Patches::new();
    let at = |x: f64, z: f64, tilt: f64, patches: &mut Patches| -> BTreeMap<[i64; 2], u64> {
        let turn = DMat3::from_rotation_y(tilt);
        let given = contacts(
            &floor,
            &table,
            Pose::new(turn, DVec3::new(x, 0.0, z)).unwrap(),
            0.02,
            ENOUGH,
        );
        patches.update(&floor, &table, &given);
        // By the foot.
        let foot = |patch: &Patch| {
            [(patch.centroid.x - x) / 2.0, patch.centroid.y / 2.0].map(|x| x.round() as i64)
        };
        patches
            .as_slice()
            .iter()
            .map(|patch| (foot(patch), patch.id))
            .collect()
    };
    let first = at(0.0, 0.01, 0.0, &mut patches);
    assert_eq!(first.len(), 4);
    for step in 1..20 {
        assert_eq!(at(0.11 * f64::from(step), 0.01, 0.0, &mut patches), first);
    }
    // Two feet are lifted: the others are the same, and those that come back are not.
    let half = at(2.1, 0.01, -0.05, &mut patches);
    assert_eq!(half.len(), 2);
    assert!(
        half.iter().all(|(foot, id)| first[foot] == *id),
        "{half:?} {first:?}"
    );
    let again = at(2.1, 0.01, 0.0, &mut patches);
    let kept = again
        .iter()
        .filter(|(foot, id)| first[*foot] == **id)
        .count();
    assert_eq!((again.len(), kept), (4, 2));
    patches.forget();
    let others = at(2.1, 0.01, 0.0, &mut patches);
    assert!(others.values().all(|id| {
        !first
            .values()
            .chain(again.values())
            .any(|known| known == id)
    }));
}

/// Parallel strips along y, each a row of `cells` squares of two triangles.
fn strips(count: u32, cells: u32, height: f32, turned: bool) -> Tree {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for strip in 0..count {
        let x = strip as f32;
        for row in 0..=cells {
            let y = (count as f32 + 3.0) * row as f32 / cells as f32 - 2.0;
            vertices.extend([x, x + 0.5].map(|x| {
                if turned {
                    [y, x, height]
                } else {
                    [x, y, height]
                }
            }));
        }
        let first = strip * 2 * (cells + 1);
        triangles.extend(
            (0..cells)
                .map(|row| first + 2 * row)
                .flat_map(|i| [[i, i + 1, i + 2], [i + 2, i + 1, i + 3]]),
        );
    }
    Tree::new(Mesh::new(vertices, triangles).unwrap())
}

/// The ids of patches by the crossing that each is at, of strips that were moved by `(x, y)`.
fn crossings(
    trees: [&Tree; 2],
    [x, y]: [f64; 2],
    patches: &mut Patches,
) -> BTreeMap<[i64; 2], u64> {
    patches.update(
        trees[0],
        trees[1],
        &contacts(trees[0], trees[1], moved(x, y, 0.0), 0.02, ENOUGH),
    );
    let place = |patch: &Patch| {
        [patch.bounds.center().x, patch.bounds.center().y - y].map(|x| x.floor() as i64)
    };
    let ids: BTreeMap<_, _> = patches
        .as_slice()
        .iter()
        .map(|patch| (place(patch), patch.id))
        .collect();
    assert_eq!(ids.len(), patches.as_slice().len(), "two at one crossing");
    ids
}

/// However many patches have a triangle in common, at rest and on the move.
#[test]
fn crossing_strips_keep_all_ids() {
    for (count, cells) in [(5, 1), (9, 3), (40, 2), (70, 1)] {
        let trees = [
            &strips(count, cells, 0.0, false),
            &strips(count, cells, 0.01, true),
        ];
        let mut patches = Patches::new();
        let first = crossings(trees, [0.0, 0.0], &mut patches);
        assert_eq!(first.len() as u32, count * count);
        // Each step the contacts of some crossings are others.
        for step in 0..6 {
            let way = 0.13 * f64::from(step);
            assert_eq!(
                crossings(trees, [way, 0.5 * way], &mut patches),
                first,
                "{count} strips, step {step}"
            );
        }
    }
}

/// Feet of one triangle each on one large triangle, and all of another large triangle: nothing else is in common.
#[test]
fn patches_with_one_triangle_in_common_share_out_the_ids() {
    let spikes = |count: u32, shift: f32| {
        let corner = |i: u32| [(i % 20) as f32 + shift, (i / 20) as f32, 0.01];
        let vertices = (0..count).flat_map(|i| {
            [[0.0; 3], [0.2, 0.0, 0.3], [0.0, 0.2, 0.3]].map(|d: [f32; 3]| {
                let corner = corner(i);
                [0, 1, 2].map(|axis| corner[axis] + d[axis])
            })
        });
        Mesh::new(
            vertices.collect::<Vec<_>>(),
            (0..count)
                .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
                .collect::<Vec<_>>(),
        )
    };
    let floor = Tree::new(
        Mesh::new(
            [
                [-99.0f32, -99.0, 0.0],
                [299.0, -99.0, 0.0],
                [-99.0, 299.0, 0.0],
            ],
            [[0, 1, 2]],
        )
        .unwrap(),
    );
    let feet = Tree::new(spikes(300, 0.0).unwrap());
    let given = contacts(&floor, &feet, Pose::IDENTITY, 0.02, ENOUGH);
    assert_eq!(given.len(), 300);
    let ids = |patches: &Patches| {
        patches
            .as_slice()
            .iter()
            .map(|patch| patch.id)
            .collect::<BTreeSet<_>>()
    };
    let mut patches = Patches::new();
    patches.update(&floor, &feet, &given[..200]);
    let first = ids(&patches);
    // Other feet take the place of all: the floor is all that is in common.
    patches.update(&floor, &feet, &given[200..]);
    let second = ids(&patches);
    assert!(
        second.len() == 100 && second.is_subset(&first),
        "{second:?}"
    );
    patches.update(&floor, &feet, &given);
    assert!(ids(&patches).is_superset(&second) && patches.as_slice().len() == 300);
    // Of feet that stay, each keeps its own.
    let by_foot = |patches: &Patches| -> BTreeMap<u32, u64> {
        let foot = |patch: &Patch| patches.contacts_of(patch)[0].triangles[1];
        patches
            .as_slice()
            .iter()
            .map(|patch| (foot(patch), patch.id))
            .collect()
    };
    let all = by_foot(&patches);
    patches.update(&floor, &feet, given.iter().step_by(2));
    assert!(by_foot(&patches).iter().all(|(foot, id)| all[foot] == *id));
}

/// The curve of a ball in a plate: all points of a large patch, in the time of some sorts.
#[test]
fn any_number_of_points_is_chosen() {
    let (ball, plate) = (Tree::new(shapes::icosphere(6)), floor());
    let given = contacts(&plate, &ball, moved(0.1, 0.2, 0.3), 0.01, ENOUGH);
    let mut patches = Patches::new().point_limit(usize::MAX);
    patches.update(&plate, &ball, &given);
    let patch = &patches.as_slice()[0];
    let points: Vec<_> = patches.points_of(patch).collect();
    let distinct: BTreeSet<_> = points.iter().map(|point| point.triangles).collect();
    assert!(
        points.len() > 100 && distinct.len() == points.len(),
        "{} points",
        points.len()
    );
    for limit in [1, 2, 3, 4, 5, 17, points.len() + 1] {
        let mut few = Patches::new().point_limit(limit);
        few.update(&plate, &ball, &given);
        let chosen: Vec<_> = few.points_of(&few.as_slice()[0]).collect();
        assert_eq!(chosen, points[..limit.min(points.len())]);
    }
}

#[test]
fn contacts_of_other_meshes_do_no_harm() {
    let (floor, table) = (floor(), table());
    let given = contacts(&table, &table, Pose::IDENTITY, 0.0, ENOUGH);
    let mut patches = Patches::new();
    patches.update(&floor, &floor, &given);
    let count: usize = patches.as_slice().iter().map(Patch::contact_count).sum();
    assert_eq!(count, given.len());
    let stranger = patches.as_slice()[0].clone();
    patches.update(&floor, &floor, &[]);
    assert!(patches.as_slice().is_empty() && patches.contacts_of(&stranger).is_empty());
    assert_eq!(patches.points_of(&stranger).len(), 0);
}
