/* Rays, and what follows from a distance or a contact: clearance and penetration. */

#include "check.h"
#include <math.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))

static punctual_point at(double x, double y, double z) {
  punctual_point point = {x, y, z};
  return point;
}

static void one_ray(const punctual_tree *cube, punctual_workspace *workspace) {
  punctual_ray_cast cast = {.size = sizeof cast};
  punctual_ray_hit hits[8];
  size_t count;
  punctual_ray_query query = punctual_ray_query_new(cube, punctual_ray_new(at(0.1, 0.2, 5), at(0, 0, -2)));
  CHECK(query.mode == PUNCTUAL_RAY_MODE_NEAREST);
  CHECK(punctual_budget_work(1).poll_interval == PUNCTUAL_MAX_STEP_WORK);
  OK(punctual_ray_query_run(&query, workspace, punctual_budget_unlimited(), NULL, &cast));
  CHECK(cast.stop == PUNCTUAL_STOP_REASON_FINISHED && cast.hit.t == 2 && cast.free_until == 2);
  punctual_remaining left = {.size = sizeof left};
  OK(punctual_ray_query_remaining(&query, workspace, &left));
  CHECK(left.work.p90 == 0);
  CHECK(cast.hit.side == PUNCTUAL_SIDE_FRONT && cast.hit.triangle != PUNCTUAL_NO_TRIANGLE);

  CHECK(cast.starts_inside == PUNCTUAL_INSIDE_UNDECIDED);

  /* All of a segment that goes through, with room for one at a time. */
  query.ray = punctual_ray_segment(at(0.1, 0.2, 5), at(0.1, 0.2, -5));
  query.mode = PUNCTUAL_RAY_MODE_ALL;
  OK(punctual_workspace_reserve_ray_hits(workspace, 1));
  OK(punctual_ray_query_run(&query, workspace, punctual_budget_unlimited(), NULL, &cast));
  CHECK(cast.stop == PUNCTUAL_STOP_REASON_PAIRS_FULL && cast.found == 1);
  OK(punctual_workspace_ray_hits(workspace, hits, COUNT(hits), &count));
  CHECK(count == 1 && hits[0].t > 0.39 && hits[0].t < 0.41 && hits[0].side == PUNCTUAL_SIDE_FRONT);
  OK(punctual_workspace_drain_ray_hits(workspace));
  OK(punctual_ray_query_resume(&query, workspace, punctual_budget_work(1000000), NULL, &cast));
  OK(punctual_workspace_ray_hits(workspace, hits, COUNT(hits), &count));
  CHECK(cast.found == 2 && count == 1 && hits[0].t > 0.59 && hits[0].t < 0.61 && hits[0].side == PUNCTUAL_SIDE_BACK);

  query.ray.target = query.ray.origin;
  FAILS(punctual_ray_query_run(&query, workspace, punctual_budget_unlimited(), NULL, &cast), BAD_ARGUMENT,
        "punctual_ray_query_run: query->ray: the ray's direction is zero, or both ends of the segment are one point");
}

static void many_rays(const punctual_tree *cube, punctual_workspace *workspace) {
  punctual_ray beams[20];
  punctual_ray_hit hits[20];
  punctual_ray_batch_outcome outcome = {.size = sizeof outcome};
  for (int i = 0; i < 20; i++)
    beams[i] = punctual_ray_new(at(0.15 * i, 0.1, 5), at(0, 0, -1));
  punctual_ray_batch batch = punctual_ray_batch_new(cube, beams, COUNT(beams));
  int calls = 1;
  OK(punctual_ray_batch_run(&batch, workspace, punctual_budget_work(1500), NULL, hits, &outcome));
  for (; outcome.stop != PUNCTUAL_STOP_REASON_FINISHED; calls++) {
    CHECK(outcome.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT && outcome.done < COUNT(beams));
    punctual_remaining left = {.size = sizeof left};
    OK(punctual_ray_batch_remaining(&batch, workspace, &left));
    CHECK(left.work.p90 > 0);
    OK(punctual_ray_batch_resume(&batch, workspace, punctual_budget_work(1500), NULL, hits, &outcome));
  }
  CHECK(calls > 1 && outcome.done == COUNT(beams));
  for (int i = 0; i < 20; i++) { /* the half edge is 1 */
    CHECK((hits[i].triangle == PUNCTUAL_NO_TRIANGLE) == (0.15 * i > 1));
    CHECK(hits[i].triangle == PUNCTUAL_NO_TRIANGLE ? hits[i].t > 1e300 : hits[i].t == 4);
  }
  beams[7].origin.y = HUGE_VAL;
  FAILS(punctual_ray_batch_run(&batch, workspace, punctual_budget_unlimited(), NULL, hits, &outcome), BAD_ARGUMENT,
        "punctual_ray_batch_run: batch->rays[7]: y of the ray's origin is not finite");
}

static void points_in_a_solid(const punctual_mesh *mesh, punctual_workspace *workspace) {
  punctual_build_options options = punctual_build_options_default();
  punctual_tree *solid;
  punctual_point points[20];
  punctual_point_bounds bounds[20];
  punctual_points_outcome outcome = {.size = sizeof outcome};
  options.solid = PUNCTUAL_SOLID_KEEP;
  OK(punctual_tree_new(mesh, &options, &solid));
  for (int i = 0; i < 20; i++)
    points[i] = at(0.125 * i, 0.1, 0);
  OK(punctual_points_run(solid, points, COUNT(points), 1, workspace, punctual_budget_work(1500), NULL, bounds, &outcome));
  while (outcome.stop != PUNCTUAL_STOP_REASON_FINISHED) {
    punctual_remaining left = {.size = sizeof left};
    OK(punctual_points_remaining(solid, points, COUNT(points), 1, workspace, &left));
    CHECK(left.work.p90 > 0);
    OK(punctual_points_resume(solid, points, COUNT(points), 1, workspace, punctual_budget_work(1500), NULL, bounds,
                              &outcome));
  }
  CHECK(outcome.done == COUNT(points));
  for (int i = 0; i < 20; i++) { /* the half edge is 1 */
    CHECK((bounds[i].inside == PUNCTUAL_INSIDE_YES) == (i <= 8) && bounds[i].is_on_surface == (i == 8));
    CHECK(i < 8 ? bounds[i].high < 0 : bounds[i].low <= 0.125 * i - 1 && bounds[i].high >= 0.125 * i - 1);
  }
  points[3].z = HUGE_VAL;
  FAILS(punctual_points_run(solid, points, COUNT(points), 0, workspace, punctual_budget_unlimited(), NULL, bounds, &outcome),
        BAD_ARGUMENT, "punctual_points_run: point 3 is not finite along axis 2");
  punctual_tree_free(solid);
}

static void clearance_and_penetration(const punctual_tree *cube, punctual_workspace *workspace) {
  punctual_pose pose = punctual_pose_identity();
  pose.m[3] = 1.9, pose.m[7] = 0.1;
  punctual_penetration_workspace *buffers;
  OK(punctual_penetration_workspace_new(&buffers));
  punctual_penetration_query deep = punctual_penetration_query_new(cube, cube, pose);
  punctual_penetration depth = {.size = sizeof depth};
  OK(punctual_penetration_query_run(&deep, buffers, punctual_budget_work(1), NULL, &depth));
  CHECK(depth.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT && depth.low <= depth.high);
  OK(punctual_penetration_query_resume(&deep, buffers, punctual_budget_work(3000000), NULL, &depth));
  CHECK(depth.has_push && depth.low > 0.09 && depth.high < 0.15 && depth.direction.x > 0.9);
  deep.push_only = 1;
  OK(punctual_penetration_query_run(&deep, buffers, punctual_budget_work(3000000), NULL, &depth));
  CHECK(depth.has_push && depth.low == 0 && depth.high > 0.1 && depth.high < 0.15 && depth.direction.x > 0.9);
  CHECK(depth.b_in_a.m[3] > 2 && depth.elapsed == -1 && depth.stop == PUNCTUAL_STOP_REASON_FINISHED);
  punctual_penetration_workspace_free(buffers);

  punctual_manifold_query touch = punctual_manifold_query_new(cube, cube, pose);
  punctual_manifolds manifolds = {.size = sizeof manifolds};
  punctual_manifold_point points[8];
  size_t count;
  OK(punctual_manifold_query_run(&touch, workspace, NULL, punctual_budget_work(1), NULL, &manifolds));
  CHECK(manifolds.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT && manifolds.low == 0);
  punctual_remaining left = {.size = sizeof left};
  OK(punctual_manifold_query_remaining(&touch, workspace, NULL, &left));
  CHECK(left.work.p90 > 0);
  OK(punctual_manifold_query_resume(&touch, workspace, NULL, punctual_budget_unlimited(), NULL, &manifolds));
  CHECK(manifolds.meets && manifolds.stop == PUNCTUAL_STOP_REASON_FINISHED);
  OK(punctual_workspace_manifold_points(workspace, points, sizeof points[0], COUNT(points), &count));
  CHECK(count >= 3 && count <= 4 && points[0].distance < -0.099 && points[0].distance > -0.101);

  punctual_memory *memory;
  double clearance;
  pose.m[3] = 5;
  OK(punctual_memory_new(&memory));
  OK(punctual_memory_clearance(memory, cube, cube, pose, &clearance));
  CHECK(clearance == 0);
  punctual_distance_query query = punctual_distance_query_new(cube, cube, pose);
  punctual_distance distance = {.size = sizeof distance};
  OK(punctual_distance_query_run(&query, workspace, memory, punctual_budget_unlimited(), NULL, &distance));
  pose.m[3] = 4; /* the gap was 3, and is 2 */
  OK(punctual_memory_clearance(memory, cube, cube, pose, &clearance));
  CHECK(clearance > 1.99 && clearance <= 2);
  FAILS(punctual_memory_clearance(memory, cube, NULL, pose, &clearance), NULL, "punctual_memory_clearance: b is null");
  punctual_memory_free(memory);
}

void rays(void) {
  punctual_mesh *mesh;
  punctual_tree *cube;
  punctual_workspace *workspace;
  OK(punctual_shape_cuboid(1, 1, 1, 4, &mesh));
  OK(punctual_tree_new(mesh, NULL, &cube));
  OK(punctual_workspace_new(&workspace));
  one_ray(cube, workspace);
  many_rays(cube, workspace);
  points_in_a_solid(mesh, workspace);
  clearance_and_penetration(cube, workspace);
  punctual_workspace_free(workspace);
  punctual_tree_free(cube);
  punctual_mesh_free(mesh);
}
