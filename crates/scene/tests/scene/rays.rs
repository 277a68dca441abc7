//! Rays in scenes, against the rays of all bodies one by one.

use std::sync::Arc;

use crate::common::random::Random;
use crate::{Model, ball, detect, moving, put, whole_frame};
use punctual::clock::ManualClock;
use punctual::geom::RayError;
use punctual::glam::{DMat3, DVec3};
use punctual::rays::{RayHit, RayMode};
use punctual::{Budget, Pose, Query, Ray, StopReason, Workspace};
use punctual_scene::{Body, BodyHit, BodyId, Filter, Scene, SceneCast, SceneError, SceneRay};

fn cast(scene: &mut Scene, ray: &SceneRay, budget: Budget) -> SceneCast {
    scene.cast(ray, budget.clock(&ManualClock::new())).unwrap()
}

fn key(hit: &BodyHit) -> (f64, usize, u32) {
    (hit.on_body.t, hit.body.index(), hit.on_body.triangle)
}

/// All hits of a ray, the nearest first.
fn truth(
    model: &Model,
    ray: &Ray,
    filter: Filter,
    workspace: &mut Workspace,
) -> Vec<(f64, usize, u32)> {
    let mut hits = Vec::new();
    for (id, body) in &model.bodies {
        if filter.meets(body.filter) {
            let here = ray.transformed(&body.pose.inverse().unwrap()).unwrap();
            let query = Query::ray(&body.tree, here).mode(RayMode::All);
            let _ = query.run(workspace, Budget::unlimited().clock(&ManualClock::new()));
            let told = |hit: &RayHit| (hit.t, id.index(), hit.triangle);
            hits.extend(workspace.ray_hits().iter().map(told));
        }
    }
    hits.sort_by(|x, y| x.partial_cmp(y).unwrap());
    hits
}

fn any_ray(random: &mut Random) -> Ray {
    let from = if random.below(4) == 0 {
        1e6 * random.vector()
    } else {
        4.0 * random.vector()
    };
    let mut direction = 2.0 * random.vector() - from * f64::from(u8::from(from.length() > 1e3));
    for axis in 0..3 {
        if random.below(4) == 0 {
            direction[axis] = 0.0;
        }
    }
    if direction == DVec3::ZERO {
        direction = DVec3::X;
    }
    let ray = match random.below(3) {
        0 => Ray::segment(from, from + direction).unwrap(),
        _ => Ray::new(from, direction * 10f64.powi(random.below(7) as i32 - 3)).unwrap(),
    };
    if random.below(3) == 0 {
        ray.within(random.signed().abs(), 3.0 * random.signed().abs())
    } else {
        ray
    }
}

/// Some rays against the bodies as they are, complete and cut short.
pub fn check(
    scene: &mut Scene,
    model: &Model,
    random: &mut Random,
    workspace: &mut Workspace,
) -> usize {
    let mut met = 0;
    for _ in 0..2 {
        let ray = any_ray(random);
        let filter = if random.below(2) == 0 {
            Filter::default()
        } else {
            Filter::new(u32::MAX, 3)
        };
        let asked = SceneRay::new(ray).filter(filter);
        let truth = truth(model, &ray, filter, workspace);
        met += usize::from(!truth.is_empty());

        let nearest = cast(scene, &asked, Budget::unlimited());
        assert_eq!(
            (nearest.hit.as_ref().map(key), nearest.stop),
            (truth.first().copied(), StopReason::Finished)
        );
        assert_eq!(
            nearest.free_until,
            truth.first().map_or(f64::INFINITY, |first| first.0)
        );
        let any = cast(scene, &asked.mode(RayMode::Any), Budget::unlimited());
        assert!(
            any.hit
                .map_or(truth.is_empty(), |hit| truth.contains(&key(&hit))),
            "{any:?}"
        );
        let all = cast(scene, &asked.mode(RayMode::All), Budget::unlimited());
        let mut hits: Vec<_> = scene.ray_hits().iter().map(key).collect();
        hits.sort_by(|x, y| x.partial_cmp(y).unwrap());
        assert_eq!((&hits, all.found), (&truth, truth.len() as u64));

        let budget = random.below(1 + nearest.work as usize) as u64;
        for mode in [RayMode::Nearest, RayMode::All] {
            let cut = cast(scene, &asked.mode(mode), Budget::work(budget));
            assert!(cut.work <= budget, "{cut:?}, {budget}");
            assert!(
                cut.hit.is_none_or(|hit| truth.contains(&key(&hit))),
                "{cut:?}"
            );
            let unseen =
                |hit: &&(f64, usize, u32)| !scene.ray_hits().iter().any(|seen| key(seen) == **hit);
            let first = if mode == RayMode::All {
                truth.iter().find(unseen)
            } else {
                truth.first()
            };
            assert!(
                cut.free_until <= first.map_or(f64::INFINITY, |first| first.0),
                "{cut:?}: {first:?}"
            );
            if cut.stop == StopReason::Finished && mode == RayMode::Nearest {
                assert_eq!((cut.hit, cut.work), (nearest.hit, nearest.work));
            }
        }
    }
    met
}

/// Balls of radius 1, one behind the other, 3 apart.
fn row(bodies: usize) -> (Scene, Vec<BodyId>) {
    let ball = ball(3);
    let mut scene = Scene::new();
    let at = |i: usize| Pose::new(DMat3::IDENTITY, DVec3::X * (3 * i) as f64).unwrap();
    let ids = (0..bodies)
        .map(|i| moving(&mut scene, &ball, at(i)))
        .collect();
    (scene, ids)
}

#[test]
fn what_is_in_sight_is_found_without_looking_at_the_rest() {
    let (mut scene, ids) = row(2_000);
    whole_frame(&mut scene);
    let ray = SceneRay::new(Ray::new([-2.0, 0.1, 0.2], [1.0, 0.0, 0.0]).unwrap());
    let first = cast(&mut scene, &ray, Budget::unlimited());
    assert_eq!(first.hit.unwrap().body, ids[0]);
    assert!(first.work < 3_000, "{first:?}");
    // Cut short anywhere, the way that is free is proven, and it only ever grows.
    let mut free = 0.0;
    for budget in (0..=first.work).step_by(50) {
        let cut = cast(&mut scene, &ray, Budget::work(budget));
        assert!(cut.free_until >= free && cut.free_until <= first.free_until);
        free = cut.free_until;
    }
    assert!(free > 0.9, "{free}, {first:?}");
}

/// Budgets that leave the broad phase at every one of its steps: new bodies, bodies far from where they were, trees half built.
#[test]
fn rays_see_bodies_that_the_broad_phase_is_still_at() {
    let ball = ball(0);
    let (mut scene, mut model, mut random) = (Scene::new(), Model::default(), Random::new(51));
    let mut workspace = Workspace::new();
    let place = |random: &mut Random| Pose::new(DMat3::IDENTITY, 12.0 * random.vector()).unwrap();
    let mut unplaced = [false; 2];
    for frame in 0..40 {
        for i in 0..60 {
            let here = place(&mut random);
            if frame < 20 {
                let body = Body::moving(Arc::clone(&ball), here);
                model
                    .bodies
                    .push((scene.insert(body.clone()).unwrap(), body));
            } else {
                let at = (61 * frame + 19 * i) % model.bodies.len();
                let (id, body) = &mut model.bodies[at];
                body.pose = here;
                scene.set_pose(*id, here).unwrap();
            }
        }
        let report = detect(&mut scene, Budget::work(0));
        unplaced[usize::from(frame >= 20)] |= report.unpaired > 0;
        for _ in 0..3 {
            let ray = Ray::new(20.0 * random.vector(), random.vector()).unwrap();
            let hit = cast(&mut scene, &SceneRay::new(ray), Budget::unlimited()).hit;
            let first = truth(&model, &ray, Filter::default(), &mut workspace)
                .first()
                .copied();
            assert_eq!(hit.as_ref().map(key), first, "frame {frame}");
        }
    }
    assert_eq!(unplaced, [true; 2], "the broad phase was cut");
}

#[test]
fn a_ray_sees_the_poses_that_were_set_and_only_bodies_that_are_there() {
    let (mut scene, ids) = row(3);
    let ray = SceneRay::new(Ray::new([-2.0, 0.1, 0.2], [1.0, 0.0, 0.0]).unwrap());
    let seen = |scene: &mut Scene| {
        cast(scene, &ray, Budget::unlimited())
            .hit
            .map(|hit| hit.body)
    };
    assert_eq!(seen(&mut scene), Some(ids[0]), "before the first frame");
    whole_frame(&mut scene);
    put(
        &mut scene,
        ids[0],
        Pose::new(DMat3::IDENTITY, DVec3::Y * 9.0).unwrap(),
    );
    assert_eq!(seen(&mut scene), Some(ids[1]));
    scene.remove(ids[1]).unwrap();
    assert_eq!(seen(&mut scene), Some(ids[2]));
    scene.set_filter(ids[2], Filter::new(0, 0)).unwrap();
    assert_eq!(seen(&mut scene), None);
}

#[test]
fn a_ray_that_a_body_cannot_be_asked_about_is_refused_by_its_name() {
    let far = DVec3::X * 2f64.powi(989);
    let turned = Pose::new(DMat3::from_rotation_z(0.8), far).unwrap();
    let (mut scene, _) = row(1);
    let id = scene.insert(Body::moving(ball(0), turned)).unwrap();
    let ray = SceneRay::new(Ray::segment([1e301, 1e301, 0.0], far).unwrap());
    match scene.cast(&ray, Budget::unlimited().clock(&ManualClock::new())) {
        Err(
            error @ SceneError::NoRay {
                body,
                error: RayError::TooLarge { .. },
            },
        ) => {
            assert!(
                body == id
                    && error
                        .to_string()
                        .starts_with("in the coordinates of body 1"),
                "{error}"
            );
        }
        other => panic!("{other:?}"),
    }
}

/// Bodies at random, and rays through them.
fn crowd(random: &mut Random, bodies: usize, rays: usize) -> (Scene, Vec<SceneRay>) {
    let (mut scene, trees) = (Scene::new(), crate::trees());
    for _ in 0..bodies {
        let tree = Arc::clone(&trees[random.below(trees.len())]);
        let body = Body::moving(tree, crate::pose(12.0, random));
        scene.insert(body).unwrap();
    }
    whole_frame(&mut scene);
    let ray = |random: &mut Random| {
        let mode = [RayMode::Nearest, RayMode::Any][random.below(2)];
        let ray = Ray::new(14.0 * random.vector(), random.vector()).unwrap();
        SceneRay::new(ray).mode(mode)
    };
    (scene, (0..rays).map(|_| ray(random)).collect())
}

/// The parameters of the nearest hits of rays in any mode; infinite without a hit.
fn first_hits(scene: &mut Scene, rays: &[SceneRay]) -> Vec<f64> {
    let nearest = |ray: &SceneRay| cast(scene, &ray.mode(RayMode::Nearest), Budget::unlimited());
    rays.iter()
        .map(nearest)
        .map(|cast| cast.free_until)
        .collect()
}

#[test]
fn a_batch_of_rays_says_what_each_ray_says_until_the_budget_ends() {
    let mut random = Random::new(91);
    let (mut scene, rays) = crowd(&mut random, 300, 400);
    let mut alone = Vec::new();
    for ray in &rays {
        alone.push(cast(&mut scene, ray, Budget::unlimited()));
    }
    let first = first_hits(&mut scene, &rays);
    let clock = ManualClock::new();
    let all = scene
        .cast_rays(&rays, Budget::unlimited().clock(&clock))
        .unwrap();
    assert!(all == alone);
    let work: u64 = all.iter().map(|cast| cast.work).sum();
    for budget in [0, 1, work / 7, work / 2, work - 1] {
        let part = scene
            .cast_rays(&rays, Budget::work(budget).clock(&clock))
            .unwrap();
        let done: u64 = part.iter().map(|cast| cast.work).sum();
        let cut = part
            .iter()
            .position(|cast| cast.stop == StopReason::WorkLimit)
            .unwrap();
        assert!(done <= budget && part[..cut] == alone[..cut]);
        for (part, first) in part.iter().zip(&first).skip(cut) {
            assert!(part.free_until <= *first, "{part:?} {first}");
        }
        for cast in &part[cut + 1..] {
            assert_eq!(
                (cast.stop, cast.work, cast.hit),
                (StopReason::WorkLimit, 0, None)
            );
        }
    }
    let both = [rays[0].mode(RayMode::All), rays[1].mode(RayMode::All)];
    let found = both.map(|ray| cast(&mut scene, &ray, Budget::unlimited()).found);
    let casts = scene
        .cast_rays(&both, Budget::unlimited().clock(&clock))
        .unwrap();
    assert_eq!([casts[0].found, casts[1].found], found);
    assert_eq!(scene.ray_hits().len() as u64, found[0] + found[1]);
    assert!(
        scene
            .cast_rays(&[], Budget::unlimited().clock(&clock))
            .unwrap()
            .is_empty()
    );
}

#[test]
#[cfg(feature = "parallel")]
fn a_batch_of_rays_says_the_same_on_any_number_of_threads() {
    let mut random = Random::new(92);
    let (mut scene, mut rays) = crowd(&mut random, 200, 1_500);
    let whole = scene.cast_rays(&rays, Budget::unlimited()).unwrap();
    let work: u64 = whole.iter().map(|cast| cast.work).sum();
    for budget in [0, work / 50, work / 3, work - 1, work, 2 * work, 1 << 60] {
        scene.use_threads(1).unwrap();
        let one = scene
            .cast_rays(&rays, Budget::work(budget))
            .unwrap()
            .to_vec();
        for threads in [2, 3, 4] {
            scene.use_threads(threads).unwrap();
            let more = scene.cast_rays(&rays, Budget::work(budget)).unwrap();
            assert!(more == one, "{threads} threads, {budget} of {work}");
        }
    }
    // Time only: what is answered is true.
    let first = first_hits(&mut scene, &rays);
    let whole = scene
        .cast_rays(&rays, Budget::unlimited())
        .unwrap()
        .to_vec();
    for micros in (0..400).step_by(10) {
        let soon = std::time::Duration::from_micros(micros);
        let part = scene.cast_rays(&rays, Budget::time(soon)).unwrap();
        for ((part, whole), first) in part.iter().zip(&whole).zip(&first) {
            assert!(part.stop == StopReason::Deadline || part.hit.is_some() == whole.hit.is_some());
            assert!(part.hit.is_none() || whole.hit.is_some());
            assert!(part.free_until <= *first, "{part:?} {first}");
        }
    }
    // An error is the first one.
    let id = scene.bodies().next().unwrap().0;
    scene.remove(id).unwrap();
    rays[700] = rays[700].of_body(id);
    let refused = scene.cast_rays(&rays, Budget::unlimited());
    assert_eq!(refused, Err(SceneError::NoSuchBody { body: id }));
    let cut = scene.cast_rays(&rays, Budget::work(work / 50)).unwrap();
    assert_eq!(cut.len(), rays.len());
}
