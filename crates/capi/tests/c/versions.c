/* A program and a library of different versions. `.ci/c` compiles this one three times: with the header as it is, with one in which
 * the last field of each struct that may grow is missing, and with one in which there is a field more (LONGER).
 *
 * Only fields that all of them have are used. The answers are the same, and no byte is written that the caller did not offer. */

#include "check.h"

enum { GUARD = 0xa5, GUARDS = 256 };

/** A struct or an array with bytes behind it that nobody may touch. */
#define GUARDED(type, name)                                                                                            \
  struct {                                                                                                             \
    type it;                                                                                                           \
    unsigned char guard[GUARDS];                                                                                       \
  } name;                                                                                                              \
  memset(&name, GUARD, sizeof name)
#define UNTOUCHED(name)                                                                                                \
  for (int i = 0; i < GUARDS; i++)                                                                                     \
  CHECK(name.guard[i] == GUARD)
#define SIZED(name) (name.it.size = sizeof name.it)

#ifdef LONGER
/* What the library does not know it sets to 0. */
#define NOT_KNOWN(name) CHECK(name.added_later[0] == 0 && name.added_later[1] == 0)
#else
#define NOT_KNOWN(name) (void)0
#endif

static punctual_pose at(double x) {
  punctual_pose pose = punctual_pose_identity();
  pose.m[3] = x;
  return pose;
}

static void queries(const punctual_tree *ball, punctual_workspace *workspace) {
  GUARDED(punctual_query, query);
  GUARDED(punctual_outcome, outcome);
  GUARDED(punctual_certificate, open);
  punctual_query_init(&query.it, sizeof query.it, ball, ball, at(1.5));
  UNTOUCHED(query);
  NOT_KNOWN(query.it);
  CHECK(query.it.size == sizeof query.it && query.it.mode == PUNCTUAL_MODE_ANY && query.it.pair_limit == SIZE_MAX);
  query.it.mode = PUNCTUAL_MODE_ALL;
  SIZED(outcome);
  OK(punctual_query_run(&query.it, workspace, NULL, punctual_budget_work(3000), NULL, &outcome.it));
  CHECK(outcome.it.size == sizeof outcome.it && outcome.it.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT);
  SIZED(open);
  OK(punctual_query_certificate(&query.it, workspace, &open.it));
  CHECK(open.it.open_pairs > 0 && open.it.upper_bound > 0);
  OK(punctual_query_resume(&query.it, workspace, NULL, punctual_budget_unlimited(), NULL, &outcome.it));
  CHECK(outcome.it.verdict == PUNCTUAL_VERDICT_INTERSECTING && outcome.it.found > 1);
  UNTOUCHED(outcome);
  UNTOUCHED(open);
  NOT_KNOWN(outcome.it);
  NOT_KNOWN(open.it);

  GUARDED(punctual_contact_query, near);
  GUARDED(punctual_contacts, found);
  size_t count;
  punctual_contact_query_init(&near.it, sizeof near.it, ball, ball, at(1.5));
  SIZED(found);
  OK(punctual_contact_query_run(&near.it, workspace, punctual_budget_unlimited(), NULL, &found.it));
  punctual_contact two[2];
  memset(two, GUARD, sizeof two);
  OK(punctual_workspace_contacts(workspace, two, sizeof *two, 1, &count));
  CHECK(count == found.it.found && two[0].distance == 0 && ((unsigned char *)&two[1])[0] == GUARD);
  OK(punctual_workspace_contacts(workspace, two, sizeof *two, 2, &count));
  CHECK(two[1].distance == 0 && two[1].triangles.a < 80);
  NOT_KNOWN(two[0]);
  NOT_KNOWN(two[1]);
  UNTOUCHED(near);
  UNTOUCHED(found);
}

static void scenes(const punctual_tree *ball) {
  punctual_scene *scene;
  punctual_body_id ids[3];
  GUARDED(punctual_report, report);
  GUARDED(punctual_body, body);
  bool listed;
  size_t count;
  OK(punctual_scene_new(PUNCTUAL_MODE_ANY, PUNCTUAL_REACH_HERE, &scene));
  punctual_body bodies[2] = {punctual_body_new(ball, at(0)), punctual_body_new(ball, at(1.5))};
  uint64_t compound;
  OK(punctual_scene_insert_compound(scene, at(0), bodies, 2, &compound));
  punctual_body other = punctual_body_new(ball, at(-1.5));
  OK(punctual_scene_insert(scene, &other, &ids[2]));
  OK(punctual_scene_parts(scene, compound, ids, 2, &count));
  SIZED(report);
  OK(punctual_scene_detect(scene, punctual_budget_unlimited(), NULL, &report.it));
  CHECK(report.it.frame == 1 && report.it.intersecting == 1);
  punctual_pair_report pairs[2];
  memset(pairs, GUARD, sizeof pairs);
  OK(punctual_scene_pairs(scene, pairs, sizeof *pairs, 1, &count));
  CHECK(count == 1 && pairs[0].verdict == PUNCTUAL_VERDICT_INTERSECTING && pairs[0].complete);
  CHECK(((unsigned char *)&pairs[1])[0] == GUARD);
  OK(punctual_scene_pair(scene, ids[2], ids[0], &pairs[1], sizeof pairs[1], &listed));
  CHECK(listed && pairs[1].a.index == pairs[0].a.index && pairs[1].witness.b == pairs[0].witness.b);
  NOT_KNOWN(pairs[0]);
  SIZED(body);
  OK(punctual_scene_body(scene, ids[2], &body.it));
  CHECK(body.it.pose.m[3] == -1.5 && body.it.mask == UINT32_MAX);
  UNTOUCHED(report);
  UNTOUCHED(body);
  NOT_KNOWN(report.it);
  NOT_KNOWN(body.it);
#ifdef LONGER
  bodies[1].added_later[1] = 1;
  FAILS(punctual_scene_insert_compound(scene, at(0), bodies, 2, &compound), BAD_ARGUMENT,
        "punctual_scene_insert_compound: parts has a field set that this library, " PUNCTUAL_VERSION ", does not have");
#endif
  punctual_scene_free(scene);
}

/** Sizes that no struct has, and fields that the library does not have. */
static void refusals(const punctual_tree *ball, punctual_workspace *workspace) {
  punctual_query query = punctual_query_new(ball, ball, at(1.5));
  punctual_outcome outcome = {.size = 0};
  punctual_contact contact;
  size_t count;
  FAILS(punctual_query_run(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &outcome), BAD_ARGUMENT,
        "punctual_query_run: the size of outcome is given as 0: it has to be its sizeof");
  outcome.size = sizeof outcome;
#ifdef LONGER
  query.added_later[1] = 1;
  FAILS(punctual_query_run(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &outcome), BAD_ARGUMENT,
        "punctual_query_run: query has a field set that this library, " PUNCTUAL_VERSION ", does not have");
#endif
  query.size = 17;
  FAILS(punctual_query_run(&query, workspace, NULL, punctual_budget_unlimited(), NULL, &outcome), BAD_ARGUMENT,
        "punctual_query_run: the size of query is given as 17: it has to be its sizeof");
  FAILS(punctual_workspace_contacts(workspace, &contact, 8, 1, &count), BAD_ARGUMENT,
        "punctual_workspace_contacts: the size of contacts is given as 8: it has to be its sizeof");
}

void versions(void) {
  punctual_mesh *mesh;
  punctual_tree *ball;
  punctual_workspace *workspace;
  punctual_build_options options = punctual_build_options_default();
  CHECK(options.size == sizeof options && options.effort == PUNCTUAL_EFFORT_NORMAL && options.frames);
  OK(punctual_shape_icosphere(1, &mesh));
  OK(punctual_tree_new(mesh, &options, &ball));
  OK(punctual_workspace_new(&workspace));
  queries(ball, workspace);
  scenes(ball);
  refusals(ball, workspace);
  punctual_workspace_free(workspace);
  punctual_tree_free(ball);
  punctual_mesh_free(mesh);
}

#ifdef ALONE
int main(void) {
  versions();
  return 0;
}
#endif
