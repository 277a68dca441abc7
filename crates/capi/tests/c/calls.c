/* Every function of punctual.h is called from C: arguments and results pass the border as the header says they do. */

#include "check.h"

static const float square[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
static const uint32_t faces[] = {0, 1, 2, 1, 3, 2};

static punctual_pose at(double x, double y, double z) {
  punctual_pose pose = punctual_pose_identity();
  pose.m[3] = x, pose.m[7] = y, pose.m[11] = z;
  return pose;
}

static uint64_t tick(void *context) { return *(uint64_t *)context += 1000; }

static void meshes(void) {
  punctual_mesh *mesh = NULL;
  punctual_mesh_facts facts = {.size = sizeof facts};
  punctual_point vertex;
  const uint32_t *indices;
  OK(punctual_mesh_new_f32(square, 4, faces, 2, &mesh));
  OK(punctual_mesh_describe(mesh, &facts));
  CHECK(facts.triangles == 2 && facts.vertices == 4 && facts.is_f32 && facts.bytes == 4 * 12 + 2 * 12);
  CHECK(facts.bounds.min.x == 0 && facts.bounds.max.y == 1 && facts.bounds.max.z == 0);
  OK(punctual_mesh_vertex(mesh, 3, &vertex));
  CHECK(vertex.x == 1 && vertex.y == 1 && vertex.z == 0);
  FAILS(punctual_mesh_vertex(mesh, 4, &vertex), BAD_ARGUMENT, "punctual_mesh_vertex: index is 4, but there are 4");
  OK(punctual_mesh_indices(mesh, &indices));
  CHECK(memcmp(indices, faces, sizeof faces) == 0);
  punctual_mesh_free(mesh);

  double wide[] = {0, 0, 0, 1.0 / 3, 0, 0, 0, 1, 0};
  OK(punctual_mesh_new_f64(wide, 3, faces, 1, &mesh));
  OK(punctual_mesh_describe(mesh, &facts));
  CHECK(!facts.is_f32);
  punctual_mesh_free(mesh);

  punctual_mesh *untouched = NULL;
  FAILS(punctual_mesh_new_f32(square, 3, faces, 2, &untouched), BAD_MESH,
        "punctual_mesh_new_f32: corner 1 of triangle 1 is vertex 3, but there are 3 vertices");
  FAILS(punctual_mesh_new_f32(NULL, 3, faces, 2, &untouched), NULL, "punctual_mesh_new_f32: vertices is null");
  FAILS(punctual_mesh_new_f32(square, SIZE_MAX, faces, 2, &untouched), BAD_ARGUMENT,
        "punctual_mesh_new_f32: vertices is longer than memory or not aligned");
  CHECK(untouched == NULL);
}

static void files(const char *folder) {
  static const char triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", broken[] = "v 0 0 0\nv 1 0\n";
  punctual_mesh *mesh = NULL, *untouched = NULL;
  punctual_mesh_facts facts = {.size = sizeof facts};
  OK(punctual_mesh_read_bytes((const uint8_t *)triangle, sizeof triangle - 1, PUNCTUAL_FORMAT_OBJ, &mesh));
  OK(punctual_mesh_describe(mesh, &facts));
  CHECK(facts.triangles == 1 && facts.bounds.max.y == 1);
  punctual_mesh_free(mesh);
  FAILS(punctual_mesh_read_bytes((const uint8_t *)triangle, 1, 9, &untouched), BAD_ARGUMENT,
        "punctual_mesh_read_bytes: format has no value 9");
  CHECK(punctual_mesh_read_bytes((const uint8_t *)broken, sizeof broken - 1, PUNCTUAL_FORMAT_OBJ, &untouched) ==
        PUNCTUAL_STATUS_BAD_FILE);
  CHECK(strncmp(punctual_last_error(), "punctual_mesh_read_bytes: line 2: ", 34) == 0);

  char path[512];
  snprintf(path, sizeof path, "%s/parallel_plates/a.obj", folder);
  OK(punctual_mesh_read(path, &mesh));
  OK(punctual_mesh_describe(mesh, &facts));
  CHECK(facts.triangles > 0);
  punctual_mesh_free(mesh);
  CHECK(punctual_mesh_read("no such file.obj", &untouched) == PUNCTUAL_STATUS_BAD_FILE);
  CHECK(strncmp(punctual_last_error(), "punctual_mesh_read: no such file.obj: ", 38) == 0);
  FAILS(punctual_mesh_read("\xff.obj", &untouched), BAD_ARGUMENT, "punctual_mesh_read: path is not UTF-8");
  FAILS(punctual_mesh_read(NULL, &untouched), NULL, "punctual_mesh_read: path is null");
  CHECK(untouched == NULL);
}

static void shapes(void) {
  struct {
    size_t triangles;
    punctual_mesh *mesh;
  } all[6] = {{80, 0}, {48, 0}, {64, 0}, {400, 0}, {256, 0}, {32, 0}};
  OK(punctual_shape_icosphere(1, &all[0].mesh));
  OK(punctual_shape_cuboid(1, 2, 3, 2, &all[1].mesh));
  OK(punctual_shape_torus(1, 0.3f, 8, &all[2].mesh));
  OK(punctual_shape_torus_knot(2, 3, 0.1f, 40, &all[3].mesh));
  OK(punctual_shape_gear(8, 1, &all[4].mesh));
  OK(punctual_shape_height_field(4, 7, &all[5].mesh));
  for (int i = 0; i < 6; i++) {
    punctual_mesh_facts facts = {.size = sizeof facts};
    OK(punctual_mesh_describe(all[i].mesh, &facts));
    CHECK(facts.triangles == all[i].triangles);
    punctual_mesh_free(all[i].mesh);
  }
}

static void tree_shapes(void) {
  const double points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const float narrow[6] = {0, 0, 0, 1, 0, 0};
  const punctual_depth_camera camera = {3, 2, {2, 2}, {1, 0.5}, 0.001};
  const float depths[6] = {1000, 0, 2000, 0, 500, -1};
  size_t triangles[11] = {1, 1, 12, 512, 256, 4, 4, 2, 4, 4, 3};
  punctual_tree *all[11];
  OK(punctual_tree_ball(0.5, &all[0]));
  OK(punctual_tree_capsule(0.5, 1, &all[1]));
  OK(punctual_tree_box(1, 2, 3, 0.25, &all[2]));
  OK(punctual_tree_cylinder(0.5, 1, &all[3]));
  OK(punctual_tree_cone(0.5, 1, &all[4]));
  OK(punctual_tree_hull(points, 4, &all[5]));
  OK(punctual_tree_height_field(points, 6, 3, 1, 1, &all[6]));
  OK(punctual_tree_from_points_f32(narrow, 2, 0, &all[7]));
  OK(punctual_tree_from_points_f64(points, 4, 0.1, &all[8]));
  OK(punctual_tree_with_radius(all[8], 0.2, &all[9]));
  OK(punctual_tree_from_depth(camera, depths, 6, 0.01, &all[10]));
  for (int i = 0; i < 11; i++) {
    punctual_tree_facts facts = {.size = sizeof facts};
    OK(punctual_tree_describe(all[i], &facts));
    CHECK(facts.triangles == triangles[i]);
    OK(punctual_tree_validate(all[i]));
    punctual_tree_free(all[i]);
  }
  FAILS(punctual_tree_ball(-1, &all[0]), BAD_ARGUMENT,
        "punctual_tree_ball: radius is -1.0, must be 1e-150 to 1e150");
}

/** The corners of a cube of edge 2 beside a ball of radius 1 around one of them. */
static void near_points(void) {
  punctual_workspace *workspace;
  const double corners[24] = {0, 0, 0, 2, 0, 0, 0, 2, 0, 2, 2, 0, 0, 0, 2, 2, 0, 2, 0, 2, 2, 2, 2, 2};
  uint32_t points[8];
  size_t count;
  punctual_tree *cloud, *ball;
  punctual_near_points near = {.size = sizeof near};
  punctual_remaining left = {.size = sizeof left};
  punctual_certificate open = {.size = sizeof open};
  punctual_aabb boxes[8];
  OK(punctual_tree_from_points_f64(corners, 8, 0, &cloud));
  OK(punctual_tree_ball(1, &ball));
  punctual_near_points_query query = punctual_near_points_query_new(cloud, ball, punctual_pose_identity());
  query.distance = 1.1;
  OK(punctual_workspace_with_capacity(64, 1, &workspace));
  OK(punctual_workspace_reserve_near_points(workspace, 8));
  OK(punctual_near_points_query_run(&query, workspace, punctual_budget_unlimited(), NULL, &near));
  OK(punctual_workspace_near_points(workspace, points, 8, &count));
  CHECK(near.found == 4 && count == 4 && near.stop == PUNCTUAL_STOP_REASON_FINISHED);
  for (size_t i = 0; i < count; i++)
    CHECK(points[i] == 0 || points[i] == 1 || points[i] == 2 || points[i] == 4);
  OK(punctual_workspace_drain_near_points(workspace));
  query.point_limit = 1;
  OK(punctual_near_points_query_run(&query, workspace, punctual_budget_unlimited(), NULL, &near));
  CHECK(near.stop == PUNCTUAL_STOP_REASON_PAIRS_FULL);
  OK(punctual_near_points_query_remaining(&query, workspace, &left));
  OK(punctual_near_points_query_certificate(&query, workspace, &open));
  OK(punctual_near_points_query_open_boxes(&query, workspace, boxes, 8, &count));
  CHECK(open.open_pairs > 0 && count > 0);
  while (near.stop != PUNCTUAL_STOP_REASON_FINISHED) {
    OK(punctual_workspace_drain_near_points(workspace));
    OK(punctual_near_points_query_resume(&query, workspace, punctual_budget_unlimited(), NULL, &near));
  }
  CHECK(near.found == 4);
  query.a = ball;
  FAILS(punctual_near_points_query_run(&query, workspace, punctual_budget_unlimited(), NULL, &near), BAD_ARGUMENT,
        "punctual_near_points_query_run: the tree is not that of a point cloud, see punctual_tree_from_points_f32");
  punctual_workspace_free(workspace);
  punctual_tree_free(cloud);
  punctual_tree_free(ball);
}

static void poses(void) {
  punctual_pose turn, pose;
  punctual_point up = {1, 2, 3};
  OK(punctual_pose_from_quaternion(0, 0, 1, 1, up, &turn)); /* a quarter turn about z */
  CHECK(turn.m[1] < -0.999999 && turn.m[4] > 0.999999 && turn.m[3] == 1 && turn.m[7] == 2 && turn.m[11] == 3);
  OK(punctual_pose_inverse(turn, &pose));
  OK(punctual_pose_compose(turn, pose, &pose));
  for (int i = 0; i < 12; i++)
    CHECK(pose.m[i] > punctual_pose_identity().m[i] - 1e-15 && pose.m[i] < punctual_pose_identity().m[i] + 1e-15);
  pose.m[0] = 2;
  FAILS(punctual_pose_inverse(pose, &turn), BAD_POSE,
        "punctual_pose_inverse: matrix is off a rotation by 3e0, allowed is 1e-3");
}

static void triangles(void) {
  punctual_triangle a = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, b = a;
  bool intersect;
  for (int i = 0; i < 3; i++)
    b.corners[i][0] += 1;
  OK(punctual_triangles_intersect(a, b, &intersect));
  CHECK(intersect);
  for (int i = 0; i < 3; i++)
    b.corners[i][2] = 5e-324;
  OK(punctual_triangles_intersect(a, b, &intersect));
  CHECK(!intersect);
  /* A floor, and a wall that stands on its edge. */
  punctual_triangle wall = {{{0.5, 0, -1}, {0.5, 0, 1}, {0.5, 2, 0}}};
  punctual_segment segment;
  OK(punctual_triangle_segment(a, wall, &segment, &intersect));
  CHECK(intersect && segment.from.x == 0.5 && segment.to.x == 0.5 && segment.from.y + segment.to.y == 0.5);
  wall.corners[2][1] = wall.corners[0][1] = wall.corners[1][1] = -1;
  OK(punctual_triangle_segment(a, wall, &segment, &intersect));
  CHECK(!intersect && segment.to.x == 0.5);
}

static punctual_tree *knot(void) {
  punctual_mesh *mesh;
  punctual_tree *tree;
  punctual_build_options options = punctual_build_options_default();
  options.effort = PUNCTUAL_EFFORT_FAST;
  options.threads = 2;
  OK(punctual_shape_torus_knot(2, 3, 0.2f, 96, &mesh));
  OK(punctual_tree_new(mesh, &options, &tree));
  punctual_mesh_free(mesh);
  return tree;
}

static void trees(void) {
  punctual_tree *tree = knot();
  punctual_mesh *mesh;
  punctual_mesh_facts mesh_facts = {.size = sizeof mesh_facts};
  punctual_tree_facts facts = {.size = sizeof facts};
  punctual_tree_level levels[32];
  size_t count;
  OK(punctual_tree_validate(tree));
  OK(punctual_tree_describe(tree, &facts));
  OK(punctual_tree_mesh(tree, &mesh));
  OK(punctual_mesh_describe(mesh, &mesh_facts));
  CHECK(facts.triangles == mesh_facts.triangles && facts.bytes > mesh_facts.bytes && facts.degradation == 1);
  OK(punctual_tree_levels(tree, levels, sizeof *levels, 32, &count));
  CHECK(count == facts.depth && levels[0].nodes == 1 && levels[0].alpha[0] > 0 && levels[0].alpha[0] < 1);
  CHECK(levels[0].levels > levels[1].levels);
  float alphas[512];
  OK(punctual_tree_node_alphas(tree, alphas, 512, &count));
  CHECK(count == facts.nodes && alphas[0] > 0 && alphas[0] < 1);
  OK(punctual_tree_levels(tree, NULL, 0, 0, &count));
  CHECK(count == facts.depth);

  float *narrow = malloc(3 * mesh_facts.vertices * sizeof *narrow);
  double *wide = malloc(3 * mesh_facts.vertices * sizeof *wide);
  for (size_t i = 0; i < mesh_facts.vertices; i++) {
    punctual_point p;
    OK(punctual_mesh_vertex(mesh, i, &p));
    wide[3 * i] = p.x, wide[3 * i + 1] = p.y, wide[3 * i + 2] = p.z * (1 + p.x / 4);
    for (size_t k = 3 * i; k < 3 * i + 3; k++)
      narrow[k] = (float)wide[k];
  }
  OK(punctual_tree_refit_f32(tree, narrow, mesh_facts.vertices));
  OK(punctual_tree_refit_f64(tree, wide, mesh_facts.vertices));
  FAILS(punctual_tree_refit_f64(tree, wide, 3), BAD_MESH,
        "punctual_tree_refit_f64: 3 new vertices for a mesh with 1152");
  OK(punctual_tree_describe(tree, &facts));
  CHECK(facts.degradation != 1);
  free(narrow);
  free(wide);
  punctual_mesh_free(mesh);
  punctual_tree_free(tree);
}

static void bytes(void) {
  punctual_tree *tree = knot(), *loaded = NULL;
  size_t count, again;
  OK(punctual_tree_to_bytes(tree, NULL, 0, &count));
  uint8_t *bytes = malloc(count);
  OK(punctual_tree_to_bytes(tree, bytes, count, &again));
  CHECK(again == count);
  OK(punctual_tree_from_bytes(bytes, count, &loaded));

  /* Built or loaded: the same answer and the same work. */
  punctual_workspace *workspace;
  punctual_outcome built = {.size = sizeof built}, read = {.size = sizeof read};
  punctual_query query = punctual_query_new(tree, tree, at(0.4, 0.3, 0.2));
  query.mode = PUNCTUAL_MODE_ALL;
  OK(punctual_workspace_new(&workspace));
  OK(punctual_query_run(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &built));
  query.a = query.b = loaded;
  OK(punctual_query_run(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &read));
  CHECK(read.found == built.found && built.found > 1 && read.stats.work == built.stats.work);
  punctual_tree_free(loaded);

  punctual_tree *untouched = NULL;
  bytes[count / 2] ^= 1;
  CHECK(punctual_tree_from_bytes(bytes, count, &untouched) == PUNCTUAL_STATUS_BAD_FILE && untouched == NULL);
  CHECK(strstr(punctual_last_error(), "punctual_tree_from_bytes: the tree is damaged") == punctual_last_error());
  FAILS(punctual_tree_from_bytes(bytes, 20, &untouched), BAD_FILE,
        "punctual_tree_from_bytes: the tree should have 52 bytes, but has 20");
  punctual_workspace_free(workspace);
  punctual_tree_free(tree);
  free(bytes);
}

static void queries(void) {
  punctual_tree *tree = knot();
  punctual_workspace *workspace, *small;
  punctual_memory *memory;
  punctual_memory_facts remembered = {.size = sizeof remembered};
  punctual_outcome whole = {.size = sizeof whole}, outcome = {.size = sizeof outcome};
  punctual_certificate certificate = {.size = sizeof certificate};
  const punctual_triangle_pair *pairs;
  size_t count;
  OK(punctual_workspace_new(&workspace));
  OK(punctual_workspace_with_capacity(16, 8, &small));
  OK(punctual_workspace_use_portable_kernels(small));
  OK(punctual_memory_new(&memory));

  punctual_query query = punctual_query_new(tree, tree, at(0.4, 0.3, 0.2));
  query.mode = PUNCTUAL_MODE_ALL;
  OK(punctual_query_run(&query, workspace, memory, punctual_budget_work(UINT64_MAX), NULL, &whole));
  CHECK(whole.verdict == PUNCTUAL_VERDICT_INTERSECTING && whole.stop == PUNCTUAL_STOP_REASON_FINISHED);
  OK(punctual_workspace_pairs(workspace, &pairs, &count));
  CHECK(count == whole.found && count > 8 && pairs[0].a == whole.witness.a && pairs[0].b == whole.witness.b);
  OK(punctual_memory_describe(memory, &remembered));
  CHECK(remembered.last_verdict == 1 && remembered.last_bv_tests == (int64_t)whole.stats.bv_tests);

  /* The same with little work at a time, in a workspace that is soon full. */
  uint64_t drained = 0;
  OK(punctual_query_run(&query, small, NULL, punctual_budget_work(0), NULL, &outcome));
  CHECK(outcome.verdict == PUNCTUAL_VERDICT_UNDECIDED && outcome.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT);
  while (outcome.stop != PUNCTUAL_STOP_REASON_FINISHED) {
    punctual_aabb boxes[4];
    OK(punctual_query_certificate(&query, small, &certificate));
    CHECK(certificate.upper_bound >= whole.found && certificate.largest_extent >= 0);
    OK(punctual_query_open_boxes(&query, small, boxes, 4, &count));
    CHECK(count <= certificate.open_pairs);
    CHECK(count == 0 || boxes[0].max.x - boxes[0].min.x <= certificate.largest_extent);
    OK(punctual_workspace_pairs(small, &pairs, &count));
    drained += count;
    OK(punctual_workspace_drain_pairs(small));
    OK(punctual_query_resume(&query, small, NULL, punctual_budget_work(20000), NULL, &outcome));
  }
  OK(punctual_workspace_pairs(small, &pairs, &count));
  CHECK(drained + count == whole.found && outcome.found == whole.found);
  CHECK(punctual_query_resume(&query, small, NULL, punctual_budget_unlimited(), NULL, &outcome) ==
        PUNCTUAL_STATUS_NOT_RESUMABLE);

  /* What is expected, before and after. */
  punctual_prediction prediction;
  punctual_estimate estimate = {.size = sizeof estimate};
  punctual_cost_model costs = {.size = sizeof costs, .bv_test = 1, .triangle_test = 10, .box_update = 20, .setup = 100};
  OK(punctual_workspace_set_cost_model(workspace, &costs));
  costs.setup = 0;
  OK(punctual_workspace_cost_model(workspace, &costs));
  CHECK(costs.bv_test == 1 && costs.setup == 100);
  OK(punctual_query_predict(&query, NULL, &prediction));
  CHECK(prediction.work.p10 <= prediction.work.p50 && prediction.work.p50 <= prediction.work.p90);
  OK(punctual_query_estimate(&query, workspace, memory, &estimate));
  CHECK(estimate.probability == 1 && estimate.recall == 1 && estimate.remaining.time.p90 == 0);
  punctual_remaining left = {.size = sizeof left};
  OK(punctual_query_remaining(&query, workspace, memory, &left));
  CHECK(left.work.p90 == 0 && left.time.p90 == 0 && left.probability == 1);

  /* A clock that moves by a microsecond at every look. */
  uint64_t now = 0;
  punctual_clock clock = {tick, &now};
  OK(punctual_query_run(&query, workspace, memory, punctual_budget_time(2500), &clock, &outcome));
  CHECK(outcome.stop == PUNCTUAL_STOP_REASON_DEADLINE && outcome.stats.elapsed == (int64_t)now - 1000);

  query.b_in_a.m[5] = 0;
  CHECK(punctual_query_run(&query, workspace, memory, punctual_budget_unlimited(), NULL, &outcome) ==
        PUNCTUAL_STATUS_BAD_POSE);
  punctual_memory_free(memory);
  punctual_workspace_free(small);
  punctual_workspace_free(workspace);
  punctual_tree_free(tree);
}

static void own_pairs(void) {
  punctual_mesh *mesh;
  punctual_tree *tree;
  punctual_workspace *workspace;
  punctual_outcome outcome = {.size = sizeof outcome};
  punctual_certificate certificate = {.size = sizeof certificate};
  punctual_remaining left = {.size = sizeof left};
  punctual_aabb boxes[4];
  size_t count;
  OK(punctual_shape_torus_knot(2, 3, 0.7f, 96, &mesh));
  OK(punctual_tree_new(mesh, NULL, &tree));
  punctual_mesh_free(mesh);
  OK(punctual_workspace_new(&workspace));
  punctual_self_query query = punctual_self_query_new(tree);
  OK(punctual_self_query_run(&query, workspace, punctual_budget_work(9000), NULL, &outcome));
  CHECK(outcome.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT);
  OK(punctual_self_query_certificate(&query, workspace, &certificate));
  OK(punctual_self_query_open_boxes(&query, workspace, boxes, 4, &count));
  OK(punctual_self_query_remaining(&query, workspace, &left));
  CHECK(count > 0 && certificate.open_pairs > 0 && left.work.p50 > 0);
  OK(punctual_self_query_resume(&query, workspace, punctual_budget_unlimited(), NULL, &outcome));
  CHECK(outcome.stop == PUNCTUAL_STOP_REASON_FINISHED && outcome.verdict == PUNCTUAL_VERDICT_INTERSECTING);
  CHECK(outcome.found <= certificate.upper_bound && outcome.witness.a < outcome.witness.b);
  punctual_workspace_free(workspace);
  punctual_tree_free(tree);
}

static void motions(void) {
  punctual_mesh *mesh;
  punctual_tree *cube;
  punctual_workspace *workspace;
  punctual_memory *memory;
  punctual_passage passage = {.size = sizeof passage}, last = {.size = sizeof last};
  punctual_certificate open = {.size = sizeof open};
  punctual_aabb boxes[4];
  punctual_motion screw;
  punctual_pose end;
  size_t count;
  OK(punctual_shape_cuboid(1, 1, 1, 4, &mesh));
  OK(punctual_tree_new(mesh, NULL, &cube));
  OK(punctual_workspace_new(&workspace));
  OK(punctual_memory_new(&memory));

  /* Two cubes of edge 2, their middles 4 apart, meet after half of the way. */
  punctual_motion straight = punctual_motion_straight(at(4, 0, 0), (punctual_point){-4, 0, 0});
  punctual_motion_query query = punctual_motion_query_new(cube, cube, straight);
  CHECK(query.tolerance == -1 && query.time_tolerance == 0 && !query.a_moves);
  OK(punctual_motion_query_run(&query, workspace, memory, punctual_budget_unlimited(), NULL, &passage));
  CHECK(passage.stop == PUNCTUAL_STOP_REASON_FINISHED && passage.touches && passage.triangles.a < 192);
  CHECK(passage.free_until <= 0.5 && passage.touching_at >= 0.5 && passage.touching_at - passage.free_until < 1e-6);
  OK(punctual_motion_pose(&straight, 0.5, &end));
  CHECK(end.m[3] == 2 && end.m[0] == 1);

  punctual_quantiles work;
  OK(punctual_motion_query_predict(&query, memory, &work));
  CHECK(0 < work.p10 && work.p10 <= work.p50 && work.p50 <= work.p90);
  OK(punctual_motion_query_run(&query, workspace, NULL, punctual_budget_work(0), NULL, &last));
  CHECK(last.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT && last.free_until == 0 && !last.touches);
  while (last.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT) {
    double before = last.free_until;
    OK(punctual_motion_query_resume(&query, workspace, NULL, punctual_budget_work(500), NULL, &last));
    CHECK(last.free_until >= before && last.free_until <= 0.5);
    punctual_remaining left = {.size = sizeof left};
    OK(punctual_motion_query_remaining(&query, workspace, NULL, &left));
    CHECK((left.work.p90 > 0) == (last.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT));
    OK(punctual_motion_query_certificate(&query, workspace, &open));
    OK(punctual_motion_query_open_boxes(&query, workspace, boxes, 4, &count));
    CHECK(count <= open.open_pairs && (open.open_pairs > 0 || last.stop == PUNCTUAL_STOP_REASON_FINISHED));
  }
  CHECK(last.free_until == passage.free_until && last.touching_at == passage.touching_at);
  CHECK(punctual_motion_query_resume(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &last) ==
        PUNCTUAL_STATUS_NOT_RESUMABLE);

  /* Both move in the same way. */
  query.a_moves = 1;
  query.of_a = punctual_motion_straight(at(0, 0, 0), (punctual_point){-4, 0, 0});
  OK(punctual_motion_query_run(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &passage));
  CHECK(passage.free_until == 1 && !passage.touches);

  OK(punctual_motion_screw(at(4, 0, 0), at(4, 0, 3), &screw));
  CHECK(screw.velocity.z == 3 && screw.turn.x == 0);
  query.of_b.velocity.x = 1e300;
  CHECK(punctual_motion_query_run(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &passage) ==
        PUNCTUAL_STATUS_BAD_ARGUMENT);

  punctual_memory_free(memory);
  punctual_workspace_free(workspace);
  punctual_tree_free(cube);
  punctual_mesh_free(mesh);
}

static void distances(void) {
  punctual_mesh *mesh;
  punctual_tree *cube;
  punctual_workspace *workspace;
  punctual_memory *memory;
  punctual_distance distance = {.size = sizeof distance};
  punctual_certificate open = {.size = sizeof open};
  punctual_aabb boxes[4];
  size_t count;
  OK(punctual_shape_cuboid(1, 1, 1, 4, &mesh));
  OK(punctual_tree_new(mesh, NULL, &cube));
  OK(punctual_workspace_new(&workspace));
  OK(punctual_memory_new(&memory));

  /* Two cubes of edge 2, their middles 3 apart. */
  punctual_distance_query query = punctual_distance_query_new(cube, cube, at(3, 0, 0));
  CHECK(query.absolute_tolerance == -1 && query.relative_tolerance == 0 && query.closer_than > 1e300);
  query.absolute_tolerance = 0;
  OK(punctual_distance_query_run(&query, workspace, memory, punctual_budget_unlimited(), NULL, &distance));
  CHECK(distance.stop == PUNCTUAL_STOP_REASON_FINISHED && distance.closer == PUNCTUAL_CLOSER_UNDECIDED);
  CHECK(distance.low <= 1 && distance.high >= 1 && distance.high - distance.low < 1e-14 && distance.has_nearest);
  CHECK(distance.points[0].x == 1 && distance.points[1].x == 2 && distance.points[0].y == distance.points[1].y);
  CHECK(distance.nearest.a < 192 && distance.nearest.b < 192 && distance.stats.elapsed == -1);

  /* Little work at a time: bounds that only close in. */
  punctual_distance before = distance, last = {.size = sizeof last};
  punctual_quantiles work;
  punctual_distance_estimate estimate = {.size = sizeof estimate};
  OK(punctual_distance_query_predict(&query, memory, &work));
  CHECK(0 < work.p10 && work.p10 <= work.p50 && work.p50 <= work.p90);
  OK(punctual_distance_query_run(&query, workspace, NULL, punctual_budget_work(0), NULL, &last));
  CHECK(last.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT && last.low == 0 && !last.has_nearest && last.points[1].x == 0);
  CHECK(last.stats.work <= PUNCTUAL_MAX_DISTANCE_STEP_WORK);
  while (last.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT) {
    OK(punctual_distance_query_resume(&query, workspace, NULL, punctual_budget_work(500), NULL, &distance));
    CHECK(distance.low >= last.low && distance.high <= last.high && distance.low <= 1 && distance.high >= 1);
    OK(punctual_distance_query_estimate(&query, workspace, NULL, &estimate));
    CHECK(distance.low <= estimate.distance.p10 && estimate.distance.p90 <= distance.high);
    CHECK((estimate.remaining.p90 > 0) == (distance.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT));
    punctual_remaining left = {.size = sizeof left};
    OK(punctual_distance_query_remaining(&query, workspace, NULL, &left));
    CHECK((left.work.p90 > 0) == (distance.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT));
    OK(punctual_distance_query_certificate(&query, workspace, &open));
    OK(punctual_distance_query_open_boxes(&query, workspace, boxes, 4, &count));
    CHECK(count <= open.open_pairs && (count == 0 || boxes[0].max.x - boxes[0].min.x <= open.largest_extent));
    last = distance;
  }
  CHECK(last.low == before.low && last.high == before.high && open.open_pairs == 0);
  CHECK(punctual_distance_query_resume(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &distance) ==
        PUNCTUAL_STATUS_NOT_RESUMABLE);

  query.margins[0] = 0.25, query.margins[1] = 0.5;
  query.closer_than = 0.2;
  OK(punctual_distance_query_run(&query, workspace, memory, punctual_budget_unlimited(), NULL, &distance));
  CHECK(distance.closer == PUNCTUAL_CLOSER_NO && distance.low > 0.2);
  query.closer_than = 0.3;
  OK(punctual_distance_query_run(&query, workspace, memory, punctual_budget_unlimited(), NULL, &distance));
  CHECK(distance.closer == PUNCTUAL_CLOSER_YES && distance.high <= 0.3);

  uint64_t now = 0;
  punctual_clock clock = {tick, &now};
  OK(punctual_distance_query_run(&query, workspace, NULL, punctual_budget_time(1), &clock, &distance));
  CHECK(distance.stop == PUNCTUAL_STOP_REASON_DEADLINE && distance.stats.elapsed == (int64_t)now - 1000);

  query.margins[1] = -1;
  FAILS(punctual_distance_query_run(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &distance), BAD_ARGUMENT,
        "punctual_distance_query_run: query->margins[1] is -1, which is negative or no number");
  punctual_memory_free(memory);
  punctual_workspace_free(workspace);
  punctual_tree_free(cube);
  punctual_mesh_free(mesh);
}

static void contacts(void) {
  punctual_mesh *mesh;
  punctual_tree *cube;
  punctual_workspace *workspace;
  punctual_contacts said = {.size = sizeof said};
  punctual_contact found[64];
  punctual_certificate open = {.size = sizeof open};
  punctual_aabb boxes[4];
  size_t count;
  OK(punctual_shape_cuboid(1, 1, 1, 4, &mesh));
  OK(punctual_tree_new(mesh, NULL, &cube));
  OK(punctual_workspace_new(&workspace));
  OK(punctual_workspace_reserve_contacts(workspace, 10000));

  /* Two cubes of edge 2, a hundredth apart. */
  punctual_contact_query query = punctual_contact_query_new(cube, cube, at(2.01, 0.3, 0.2));
  CHECK(query.margin == 0 && query.contact_limit == SIZE_MAX);
  OK(punctual_contact_query_run(&query, workspace, punctual_budget_unlimited(), NULL, &said));
  CHECK(said.found == 0 && said.stop == PUNCTUAL_STOP_REASON_FINISHED && said.low > 1e300);
  query.margin = 0.02;
  OK(punctual_contact_query_run(&query, workspace, punctual_budget_unlimited(), NULL, &said));
  OK(punctual_workspace_contacts(workspace, found, sizeof *found, 64, &count));
  CHECK(count == said.found && count > 20);
  CHECK(found[0].distance > 0.0099 && found[0].distance < 0.0101 && !found[0].has_segment);
  CHECK(found[0].normal.x < -0.999 && found[0].points[0].x == 1 && found[0].triangles.a < 192);
  size_t all = count;
  punctual_face_normals normals;
  OK(punctual_contact_face_normals(&query, found[0].triangles, &normals));
  CHECK(normals.a.x * normals.a.x + normals.a.y * normals.a.y + normals.a.z * normals.a.z > 0.999);

  /* Little work at a time, and a list that is full. */
  query.contact_limit = 8;
  size_t sum = 0;
  OK(punctual_contact_query_run(&query, workspace, punctual_budget_work(0), NULL, &said));
  CHECK(said.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT && said.low == 0);
  punctual_remaining left = {.size = sizeof left};
  OK(punctual_contact_query_remaining(&query, workspace, &left));
  CHECK(left.work.p90 > 0);
  while (said.stop != PUNCTUAL_STOP_REASON_FINISHED) {
    OK(punctual_contact_query_certificate(&query, workspace, &open));
    OK(punctual_contact_query_open_boxes(&query, workspace, boxes, 4, &count));
    CHECK(count <= open.open_pairs && (said.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT ||
                                       said.stop == PUNCTUAL_STOP_REASON_PAIRS_FULL));
    CHECK(open.upper_bound >= all);
    OK(punctual_workspace_contacts(workspace, NULL, 0, 0, &count));
    sum += count;
    OK(punctual_workspace_drain_contacts(workspace));
    OK(punctual_contact_query_resume(&query, workspace, punctual_budget_work(3000), NULL, &said));
  }
  OK(punctual_workspace_contacts(workspace, NULL, 0, 0, &count));
  CHECK(sum + count == all);
  query.margin = -1;
  FAILS(punctual_contact_query_run(&query, workspace, punctual_budget_unlimited(), NULL, &said), BAD_ARGUMENT,
        "punctual_contact_query_run: query->margin is -1, which is negative or no number");
  punctual_workspace_free(workspace);
  punctual_tree_free(cube);
  punctual_mesh_free(mesh);
}

static void scenes(void) {
  punctual_tree *tree = knot(), *shared;
  punctual_mesh *mesh;
  punctual_scene *scene;
  punctual_body_id ids[3], listed[3];
  punctual_report report = {.size = sizeof report}, again = {.size = sizeof again};
  punctual_pair_report pair;
  punctual_pair_certificate certificate = {.size = sizeof certificate};
  bool is_listed;
  size_t count;
  OK(punctual_scene_new(PUNCTUAL_MODE_ALL, PUNCTUAL_REACH_SWEPT, &scene));
  OK(punctual_scene_use_threads(scene, 2));
  OK(punctual_scene_reserve(scene, 3, 3));
  for (int i = 0; i < 3; i++) {
    punctual_body body = punctual_body_new(tree, at(0.7 * i, 0, 0));
    body.kind = i == 0 ? PUNCTUAL_BODY_KIND_FIXED : PUNCTUAL_BODY_KIND_MOVING;
    OK(punctual_scene_insert(scene, &body, &ids[i]));
  }
  OK(punctual_scene_bodies(scene, listed, 3, &count));
  CHECK(count == 3 && memcmp(ids, listed, sizeof ids) == 0);
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, &report));
  CHECK(report.frame == 1 && report.pair_count == 3 && report.decided == 3 && report.elapsed == -1);
  OK(punctual_scene_report(scene, &again));
  CHECK(again.pair_count == 3 && again.work == report.work && again.broad_phase_work == report.broad_phase_work);
  punctual_pair_report pairs[3];
  OK(punctual_scene_pairs(scene, pairs, sizeof *pairs, 3, &count));
  CHECK(count == 3);
  OK(punctual_scene_pair(scene, ids[1], ids[0], &pair, sizeof pair, &is_listed));
  CHECK(is_listed && pair.verdict == PUNCTUAL_VERDICT_INTERSECTING && pair.complete && pair.found > 1);
  CHECK(pairs[0].found == pair.found && pairs[0].witness.b == pair.witness.b);
  OK(punctual_scene_certificate(scene, ids[0], ids[1], &certificate));
  CHECK(certificate.upper_bound == pair.found && certificate.largest_extent == 0);

  OK(punctual_scene_set_pose(scene, ids[1], at(0, 9, 0)));
  OK(punctual_scene_set_filter(scene, ids[2], 1, 0));
  OK(punctual_scene_set_importance(scene, ids[2], 2));
  uint64_t now = 0;
  punctual_clock clock = {tick, &now};
  OK(punctual_scene_detect(scene, punctual_budget_time(1), &clock, NULL));
  OK(punctual_scene_detect(scene, punctual_budget_time(1), &clock, &report));
  CHECK(report.pair_count == 0 && report.elapsed > 0);
  punctual_body body = {.size = sizeof body};
  OK(punctual_scene_body(scene, ids[2], &body));
  CHECK(body.tree == NULL && body.mask == 0 && body.groups == 1 && body.importance == 2 && body.pose.m[3] == 0.7 * 2);

  /* A body that is deformed gets a tree of its own; the handle keeps the old one. */
  punctual_mesh_facts facts = {.size = sizeof facts};
  OK(punctual_tree_mesh(tree, &mesh));
  OK(punctual_mesh_describe(mesh, &facts));
  float *flat = calloc(3 * facts.vertices, sizeof *flat);
  double *wide = calloc(3 * facts.vertices, sizeof *wide);
  OK(punctual_scene_refit_f32(scene, ids[1], flat, facts.vertices));
  OK(punctual_scene_refit_f64(scene, ids[1], wide, facts.vertices));
  OK(punctual_scene_tree(scene, ids[1], &shared));
  punctual_mesh_free(mesh);
  OK(punctual_tree_mesh(shared, &mesh));
  OK(punctual_mesh_describe(mesh, &facts));
  CHECK(facts.bounds.max.x == 0);
  OK(punctual_scene_set_tree(scene, ids[1], tree));
  punctual_mesh_free(mesh);
  free(flat);
  free(wide);

  OK(punctual_scene_remove(scene, ids[1]));
  FAILS(punctual_scene_remove(scene, ids[1]), NO_SUCH_BODY,
        "punctual_scene_remove: body 1 (generation 0) is not in the scene");
  /* The scene keeps what it shares. */
  punctual_tree_free(tree);
  punctual_tree_free(shared);
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, &report));
  punctual_scene_free(scene);
}

int main(int count, char **arguments) {
  CHECK(count == 2); /* the folder of the meshes */
  CHECK(strcmp(punctual_version(), PUNCTUAL_VERSION) == 0);
  CHECK(strcmp(punctual_last_error(), "") == 0);
  meshes();
  files(arguments[1]);
  shapes();
  tree_shapes();
  poses();
  triangles();
  trees();
  bytes();
  queries();
  distances();
  own_pairs();
  motions();
  contacts();
  near_points();
  rays();
  robots();
  scenes();
  scene_answers();
  versions();
  punctual_mesh_free(NULL);
  punctual_tree_free(NULL);
  punctual_workspace_free(NULL);
  punctual_memory_free(NULL);
  punctual_scene_free(NULL);
  puts("every function of punctual.h answers as it should");
  return 0;
}
