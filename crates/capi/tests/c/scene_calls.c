/* What else scenes tell: margins, contacts, distances, motions and rays. */

#include "check.h"
#include <math.h>

static punctual_pose at(double x) {
  punctual_pose pose = punctual_pose_identity();
  pose.m[3] = x;
  return pose;
}

static void contacts_and_distances(punctual_scene *scene, const punctual_body_id ids[2]) {
  punctual_body_contact contacts[2];
  punctual_pair_distance distances[2];
  size_t count;
  /* Half edges of 1 and a gap of 0.5: the margins close it. */
  OK(punctual_scene_track_contacts(scene));
  OK(punctual_scene_set_margin(scene, ids[0], 0.25));
  OK(punctual_scene_set_margin(scene, ids[1], 0.3));
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, NULL));
  OK(punctual_scene_contacts(scene, contacts, sizeof *contacts, 2, &count));
  CHECK(count == 1 && contacts[0].phase == PUNCTUAL_CONTACT_PHASE_BEGAN && contacts[0].age == 0);
  CHECK(contacts[0].a.index == ids[0].index && contacts[0].b.index == ids[1].index);
  OK(punctual_scene_set_margin(scene, ids[1], 0));
  OK(punctual_scene_measure(scene, ids[0], ids[1], 1e-6));
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, NULL));
  OK(punctual_scene_contacts(scene, contacts, sizeof *contacts, 2, &count));
  CHECK(count == 1 && contacts[0].phase == PUNCTUAL_CONTACT_PHASE_ENDED && contacts[0].age == 1);
  OK(punctual_scene_distances(scene, distances, sizeof *distances, 2, &count));
  CHECK(count == 1 && distances[0].age == 0 && distances[0].has_triangles && distances[0].b.index == ids[1].index);
  CHECK(distances[0].low <= 0.25 + 1e-9 && distances[0].high >= 0.25 - 1e-9);
  CHECK(distances[0].high - distances[0].low < 1.1e-6);
  OK(punctual_scene_stop_measuring(scene, ids[0], ids[1]));
  FAILS(punctual_scene_measure(scene, ids[0], ids[0], 0), BAD_ARGUMENT,
        "punctual_scene_measure: body 0 (generation 0) has no distance from itself");
}

static void motions_and_rays(punctual_scene *scene, const punctual_body_id ids[2]) {
  punctual_pair_passage passages[2];
  punctual_body_hit hits[8];
  punctual_scene_ray_cast cast = {.size = sizeof cast};
  size_t count;
  /* A gap of 4 is closed in a way of 8. */
  punctual_point velocity = {-8, 0, 0};
  OK(punctual_scene_set_margin(scene, ids[0], 0));
  OK(punctual_scene_set_motion(scene, ids[1], punctual_motion_straight(at(6), velocity)));
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, NULL));
  OK(punctual_scene_passages(scene, passages, sizeof *passages, 2, &count));
  CHECK(count == 1 && passages[0].touches && passages[0].free_until > 0.49 && passages[0].free_until <= 0.5);
  CHECK(passages[0].touching_at >= 0.5 && passages[0].touching_at < 0.51);

  punctual_point origin = {-5, 0.1, 0.2}, direction = {2, 0, 0};
  punctual_scene_ray ray = punctual_scene_ray_new(punctual_ray_new(origin, direction));
  CHECK(ray.mode == PUNCTUAL_RAY_MODE_NEAREST && ray.groups == UINT32_MAX && ray.mask == UINT32_MAX);
  OK(punctual_scene_cast(scene, &ray, punctual_budget_unlimited(), NULL, &cast));
  CHECK(cast.stop == PUNCTUAL_STOP_REASON_FINISHED && cast.hit.body.index == ids[0].index && cast.elapsed == -1);
  CHECK(cast.hit.on_body.t == 2 && cast.free_until == 2 && cast.hit.on_body.side == PUNCTUAL_SIDE_FRONT);
  ray.mode = PUNCTUAL_RAY_MODE_ALL;
  OK(punctual_scene_cast(scene, &ray, punctual_budget_unlimited(), NULL, &cast));
  OK(punctual_scene_ray_hits(scene, hits, 8, &count));
  CHECK(cast.found == 4 && count == 4);
  for (size_t i = 0; i < count; i++) /* into both bodies and out of them, one after the other */
    CHECK(hits[i].on_body.t == (hits[i].body.index == ids[0].index ? 2 : 5) + (double)(i % 2));
  CHECK(hits[0].body.index == hits[1].body.index && hits[0].body.index != hits[2].body.index);
  ray.mask = 0;
  OK(punctual_scene_cast(scene, &ray, punctual_budget_unlimited(), NULL, &cast));
  CHECK(cast.found == 0 && cast.hit.on_body.triangle == PUNCTUAL_NO_TRIANGLE);
}

static void groups_and_compounds(punctual_scene *scene, const punctual_tree *cube, const punctual_body_id ids[2]) {
  punctual_body parts[2] = {punctual_body_new(cube, at(0)), punctual_body_new(cube, at(1.5))};
  punctual_body_id names[2];
  punctual_group_distance distances[1];
  punctual_point velocity = {0, 8, 0};
  uint64_t compound, same, groups;
  size_t count;
  bool is_part;
  OK(punctual_scene_set_pose(scene, ids[1], at(2.5)));
  OK(punctual_scene_insert_compound(scene, at(20), parts, 2, &compound));
  OK(punctual_scene_parts(scene, compound, names, 2, &count));
  CHECK(count == 2);
  OK(punctual_scene_compound_of(scene, names[1], &same, &is_part));
  CHECK(is_part && same == compound);
  OK(punctual_scene_compound_of(scene, ids[0], &same, &is_part));
  CHECK(!is_part);
  OK(punctual_scene_measure_groups(scene, ids, 2, names, 2, 1e-6, &groups));
  OK(punctual_scene_set_compound_pose(scene, compound, at(7)));
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, NULL));
  OK(punctual_scene_group_distances(scene, distances, sizeof *distances, 1, &count));
  CHECK(count == 1 && distances[0].id == groups && distances[0].open == 0 && distances[0].has_bodies);
  CHECK(distances[0].low <= 2.5 + 1e-9 && distances[0].high >= 2.5 - 1e-9 && distances[0].high < 2.51);
  CHECK(distances[0].bodies[0].index == ids[1].index && distances[0].bodies[1].index == names[0].index);
  OK(punctual_scene_stop_measuring_groups(scene, groups));
  OK(punctual_scene_set_compound_motion(scene, compound, punctual_motion_straight(at(7), velocity)));
  OK(punctual_scene_remove_compound(scene, compound));
  FAILS(punctual_scene_remove_compound(scene, compound), BAD_ARGUMENT,
        "punctual_scene_remove_compound: compound 0 is not in the scene");
}

static void shapes_and_named_groups(punctual_scene *scene, const punctual_tree *cube, const punctual_body_id ids[2]) {
  punctual_shape_cast cast = {.size = sizeof cast};
  punctual_closest_body closest = {.size = sizeof closest};
  punctual_overlap overlap = {.size = sizeof overlap};
  punctual_body_overlap met[4];
  punctual_body_id undecided[4];
  punctual_scene_ray_cast casts[2] = {{.size = sizeof casts[0]}, {.size = sizeof casts[1]}};
  punctual_point velocity = {8, 0, 0}, none = {0, 0, 0}, origin = {-5, 0.1, 0.2};
  uint64_t left, right;
  size_t done;
  /* Cubes of half edge 1 at 0 and 2.5; a ball of radius 1 from -6, a cube at 1. */
  OK(punctual_scene_set_pose(scene, ids[1], at(2.5)));
  punctual_scene_shape ball = punctual_scene_shape_new(NULL, punctual_motion_straight(at(-6), velocity));
  CHECK(ball.groups == UINT32_MAX && ball.mask == UINT32_MAX && ball.has_body == 0 && ball.margin == 0);
  ball.margin = 1;
  OK(punctual_scene_cast_shape(scene, &ball, punctual_budget_unlimited(), NULL, &cast));
  CHECK(cast.stop == PUNCTUAL_STOP_REASON_FINISHED && cast.hit.is_there && cast.hit.body.index == ids[0].index);
  CHECK(cast.free_until <= 0.5 && cast.touching_at >= 0.5 && cast.touching_at < 0.5001 && cast.elapsed == -1);
  CHECK(cast.hit.has_points && cast.hit.has_normal && cast.hit.normal.x < -0.999);
  OK(punctual_scene_closest(scene, &ball, INFINITY, punctual_budget_unlimited(), NULL, &closest));
  CHECK(closest.low <= 4 && closest.high >= 4 && closest.high < 4.001 && closest.hit.body.index == ids[0].index);
  ball.has_body = 1;
  ball.body = ids[0];
  OK(punctual_scene_closest(scene, &ball, 100, punctual_budget_unlimited(), NULL, &closest));
  CHECK(closest.high >= 6.5 && closest.hit.body.index == ids[1].index);
  punctual_scene_shape solid = punctual_scene_shape_new(cube, punctual_motion_straight(at(1), none));
  OK(punctual_scene_overlap(scene, &solid, PUNCTUAL_MODE_ALL, punctual_budget_unlimited(), NULL, met, sizeof *met, 4,
                            undecided, 4, &overlap));
  CHECK(overlap.met == 2 && overlap.undecided == 0 && overlap.is_whole == 1);
  CHECK(met[0].body.index == ids[0].index && met[0].verdict == PUNCTUAL_VERDICT_INTERSECTING);
  punctual_scene_ray rays[2];
  for (int i = 0; i < 2; i++)
    rays[i] = punctual_scene_ray_new(punctual_ray_new(origin, velocity));
  rays[1].has_body = 1;
  rays[1].body = ids[0];
  OK(punctual_scene_cast_rays(scene, rays, 2, punctual_budget_unlimited(), NULL, casts, sizeof *casts, &done));
  CHECK(done == 2 && casts[0].hit.body.index == ids[0].index && casts[1].hit.body.index == ids[1].index);
  OK(punctual_scene_group(scene, "left", &left));
  OK(punctual_scene_group(scene, "right", &right));
  OK(punctual_scene_set_group(scene, ids[0], left));
  OK(punctual_scene_set_group(scene, ids[1], right));
  OK(punctual_scene_ignore_groups(scene, left, right, true));
  OK(punctual_scene_cast_rays(scene, rays, 2, punctual_budget_unlimited(), NULL, casts, sizeof *casts, &done));
  CHECK(casts[1].hit.on_body.triangle == PUNCTUAL_NO_TRIANGLE);
  OK(punctual_scene_set_group(scene, ids[1], PUNCTUAL_NO_GROUP));
  FAILS(punctual_scene_set_group(scene, ids[0], 7), BAD_ARGUMENT, "punctual_scene_set_group: group 7 is not of the scene");
  ball.margin = -1;
  FAILS(punctual_scene_closest(scene, &ball, 100, punctual_budget_unlimited(), NULL, &closest), BAD_ARGUMENT,
        "punctual_scene_closest: the shape: its margin is not from 0 to 2^1000");
}

static void within_margins(punctual_scene *scene, const punctual_body_id ids[2]) {
  punctual_pair_report pair;
  bool listed;
  OK(punctual_scene_set_margin(scene, ids[0], 0.1));
  OK(punctual_scene_set_pose(scene, ids[1], at(2.05)));
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, NULL));
  OK(punctual_scene_pair(scene, ids[0], ids[1], &pair, sizeof pair, &listed));
  CHECK(listed && pair.verdict == PUNCTUAL_VERDICT_WITHIN && pair.probability == 1);
  CHECK(pair.witness_distance >= 2.05 - 2 && pair.witness_distance < 0.051);
  OK(punctual_scene_set_margin(scene, ids[0], 0));
}

static void contact_points(punctual_scene *scene, const punctual_body_id ids[2]) {
  punctual_contact_point points[16];
  punctual_contact_points found = {.size = sizeof found};
  OK(punctual_scene_set_question_importance(scene, PUNCTUAL_PAIR_QUESTION_CONTACTS, 1));
  OK(punctual_scene_find_contacts_of(scene, ids[0], ids[1]));
  OK(punctual_scene_stop_finding_contacts_of(scene, ids[0], ids[1]));
  OK(punctual_scene_find_contacts_between(scene, 1, 2));
  OK(punctual_scene_stop_finding_contacts_between(scene, 1, 2));
  OK(punctual_scene_ignore(scene, ids[0], ids[1], true));
  OK(punctual_scene_ignore(scene, ids[0], ids[1], false));
  OK(punctual_scene_find_contacts(scene));
  OK(punctual_scene_set_pose(scene, ids[1], at(1.9)));
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, NULL));
  OK(punctual_scene_contact_points(scene, ids[0], ids[1], points, sizeof *points, 16, &found));
  CHECK(found.count > 0 && found.count <= 16 && found.drift == 0 && points[0].distance < 0);
}

/* A cube inside another is told; apart from it, its distance is proven as far as asked. */
static void contained_and_apart(void) {
  punctual_build_options options = punctual_build_options_default();
  punctual_mesh *meshes[2];
  punctual_tree *cubes[2];
  punctual_scene *scene;
  punctual_body_id ids[2];
  punctual_contact_points found = {.size = sizeof found};
  punctual_mass_properties mass;
  double most;
  options.solid = PUNCTUAL_SOLID_KEEP;
  OK(punctual_scene_new(PUNCTUAL_MODE_ANY, PUNCTUAL_REACH_HERE, &scene));
  OK(punctual_scene_find_contacts(scene));
  OK(punctual_scene_set_look_ahead(scene, 1));
  for (int i = 0; i < 2; i++) {
    const float half = i == 0 ? 1 : 0.25f;
    OK(punctual_shape_cuboid(half, half, half, 1, &meshes[i]));
    OK(punctual_tree_new(meshes[i], &options, &cubes[i]));
    punctual_body body = punctual_body_new(cubes[i], at(0));
    OK(punctual_scene_insert(scene, &body, &ids[i]));
  }
  OK(punctual_tree_mass_properties(cubes[0], &mass));
  CHECK(mass.volume > 7.999 && mass.volume < 8.001 && mass.center.x < 1e-9 && mass.inertia[1] < 1e-9);
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, NULL));
  OK(punctual_scene_contact_points(scene, ids[0], ids[1], NULL, sizeof(punctual_contact_point), 0, &found));
  CHECK(found.within == 2 && found.count == 0 && found.low == 0 && found.drift == 0);
  OK(punctual_scene_set_pose(scene, ids[1], at(1.75)));
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, NULL));
  OK(punctual_scene_contact_points(scene, ids[0], ids[1], NULL, sizeof(punctual_contact_point), 0, &found));
  CHECK(found.within == 0 && found.count == 0 && found.low >= 0.4 && found.low <= 0.5 && found.drift == 0);
  OK(punctual_scene_may_move(scene, ids[1], 9, 0.125, &most));
  CHECK(most >= 0.3 && most <= 0.3125);
  FAILS(punctual_scene_set_look_ahead(scene, -1), BAD_ARGUMENT,
        "punctual_scene_set_look_ahead: look-ahead: -1 is not a length from 0 to 2^1000");
  punctual_scene_free(scene);
  for (int i = 0; i < 2; i++) {
    punctual_tree_free(cubes[i]);
    punctual_mesh_free(meshes[i]);
  }
}

/* What a scene is asked, and how many pairs it keeps, can be changed; what it learns goes to another. */
static void settings(punctual_scene *scene, const punctual_tree *cube, const punctual_body_id ids[2]) {
  punctual_report report = {.size = sizeof report};
  punctual_pair_report pair;
  bool known;
  OK(punctual_scene_set_mode(scene, PUNCTUAL_MODE_ALL));
  OK(punctual_scene_set_reach(scene, PUNCTUAL_REACH_SWEPT));
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, &report));
  OK(punctual_scene_partners_known(scene, ids[0], &known));
  CHECK(known && report.pair_count == 1 && report.broad_phase_work > 0 && !report.is_full);
  OK(punctual_scene_pair(scene, ids[0], ids[1], &pair, sizeof pair, &known));
  CHECK(known && pair.found > 1);
  /* No room for a third body's pairs. */
  punctual_body third = punctual_body_new(cube, at(1));
  punctual_body_id id;
  OK(punctual_scene_set_max_pairs(scene, 0));
  OK(punctual_scene_insert(scene, &third, &id));
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, &report));
  CHECK(report.is_full && report.pair_count == 1);
  OK(punctual_scene_partners_known(scene, id, &known));
  CHECK(!known);
  FAILS(punctual_scene_set_mode(scene, 2), BAD_ARGUMENT, "punctual_scene_set_mode: mode has no value 2");
  FAILS(punctual_scene_set_reach(scene, 2), BAD_ARGUMENT, "punctual_scene_set_reach: reach has no value 2");

  punctual_calibration learned = punctual_calibration_default(), kept = {.size = sizeof kept};
  double corrected;
  for (int moment = 0; moment < 200; moment++)
    OK(punctual_calibration_learn(&learned, 0.65, moment % 7 != 0));
  OK(punctual_calibration_apply(&learned, 0.65, &corrected));
  CHECK(fabs(corrected - 6.0 / 7) < 0.02);
  OK(punctual_scene_set_calibration(scene, &learned));
  OK(punctual_scene_calibration(scene, &kept));
  CHECK(kept.offset == learned.offset && kept.slope == learned.slope && kept.evidence[2] == learned.evidence[2]);
  kept.slope = 9;
  FAILS(punctual_scene_set_calibration(scene, &kept), BAD_ARGUMENT,
        "punctual_scene_set_calibration: calibration has numbers that cannot be learned");
}

void scene_answers(void) {
  punctual_mesh *mesh;
  punctual_tree *cube;
  punctual_scene *scene;
  punctual_body_id ids[2];
  OK(punctual_shape_cuboid(1, 1, 1, 4, &mesh));
  OK(punctual_tree_new(mesh, NULL, &cube));
  OK(punctual_scene_new(PUNCTUAL_MODE_ANY, PUNCTUAL_REACH_HERE, &scene));
  for (int i = 0; i < 2; i++) {
    punctual_body body = punctual_body_new(cube, at(2.5 * i));
    CHECK(body.margin == 0);
    OK(punctual_scene_insert(scene, &body, &ids[i]));
  }
  contacts_and_distances(scene, ids);
  motions_and_rays(scene, ids);
  groups_and_compounds(scene, cube, ids);
  shapes_and_named_groups(scene, cube, ids);
  contact_points(scene, ids);
  settings(scene, cube, ids);
  within_margins(scene, ids);
  contained_and_apart();
  punctual_scene_free(scene);
  punctual_tree_free(cube);
  punctual_mesh_free(mesh);
}
