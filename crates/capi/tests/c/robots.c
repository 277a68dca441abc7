/* Robots: each call once, on an arm with seven joints beside a post. */

#include "check.h"
#include <math.h>

enum { JOINTS = 7 };
static const double bent[JOINTS] = {-0.5, 1.2, 0.3, 0.4, 0, 0.2, 0}, beyond[JOINTS] = {1.5, 1.2, 0.3, 0.4, 0, 0.2, 0};

static void near_pairs(punctual_robot *robot, uint32_t post) {
  punctual_robot_near near = {.size = sizeof near};
  punctual_robot_near_pair pairs[64];
  double gradients[64 * JOINTS], before = 0, after = 0;
  punctual_budget all = punctual_budget_unlimited();
  punctual_point down = {0, -1, 0}, still = {0};
  punctual_robot_motion motion = {.size = sizeof motion};
  punctual_pose place = punctual_pose_identity();
  for (int margin = 0; margin < 2; margin++) {
    OK(punctual_robot_near_pairs(robot, bent, JOINTS, 0.5, 1e-9, all, NULL, pairs, sizeof pairs[0], gradients, 64, &near));
    CHECK(near.count > 0 && near.count < 64 && near.beyond >= 0.5 && near.stop == PUNCTUAL_STOP_REASON_FINISHED);
    before = after;
    for (size_t i = 0; i < near.count; i++)
      if (pairs[i].shapes[1] == post)
        after = pairs[i].low;
    OK(punctual_robot_set_margin(robot, margin == 0 ? 0.01 : 0, "post 1", NULL, 0));
  }
  CHECK(fabs(before - after - 0.01) < 1e-6);
  FAILS(punctual_robot_set_margin(robot, 0.1, NULL, "post 1", 0), NULL, "punctual_robot_set_margin: name is null");

  /* The post comes down on the robot. */
  place.m[3] = 0.35;
  place.m[7] = 1.45;
  place.m[11] = 0.5;
  OK(punctual_robot_move_along(robot, post, place, down, still, 0.01, 0));
  OK(punctual_robot_edge(robot, bent, bent, JOINTS, 1, all, NULL, &motion));
  CHECK(motion.verdict == PUNCTUAL_ROBOT_VERDICT_FREE);
  place.m[7] = 0.45;
  OK(punctual_robot_move(robot, post, place));
}

static void questions(punctual_robot *robot, uint32_t post) {
  punctual_robot_collision collision = {.size = sizeof collision};
  punctual_robot_clearance clearance = {.size = sizeof clearance};
  punctual_robot_motion motion = {.size = sizeof motion};
  punctual_budget all = punctual_budget_unlimited();
  const double turn[JOINTS] = {1}, brakes[JOINTS] = {10, 10, 10, 10, 10, 10, 10};
  double braking;
  OK(punctual_robot_collide(robot, bent, JOINTS, all, NULL, &collision));
  CHECK(collision.verdict == PUNCTUAL_ROBOT_VERDICT_FREE && collision.stop == PUNCTUAL_STOP_REASON_FINISHED);
  CHECK(collision.shapes[0] == PUNCTUAL_NO_SHAPE && collision.work > 0);
  OK(punctual_robot_measure(robot, bent, JOINTS, 1e-9, all, NULL, &clearance));
  CHECK(clearance.low > 0.01 && clearance.high - clearance.low < 1e-3 && clearance.shapes[1] != PUNCTUAL_NO_SHAPE);

  OK(punctual_robot_edge(robot, bent, beyond, JOINTS, 1, all, NULL, &motion));
  CHECK(motion.verdict == PUNCTUAL_ROBOT_VERDICT_CONTACT && motion.shapes[1] == post);
  double touching = motion.touching_at;
  CHECK(motion.free_until > 0.3 && motion.free_until <= touching && touching < 0.9);
  int calls = 1;
  OK(punctual_robot_edge(robot, bent, beyond, JOINTS, 1, punctual_budget_work(2000), NULL, &motion));
  for (; motion.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT; calls++) {
    CHECK(motion.free_until <= touching);
    OK(punctual_robot_edge_resume(robot, punctual_budget_work(2000), NULL, &motion));
  }
  CHECK(calls > 3 && fabs(motion.touching_at - touching) < 1e-4);

  /* 2 rad in 2 s. */
  OK(punctual_robot_horizon(robot, bent, turn, JOINTS, 0.2, all, NULL, &motion));
  CHECK(motion.verdict == PUNCTUAL_ROBOT_VERDICT_FREE && motion.free_until == 0.2 && motion.touching_at > 1e300);
  OK(punctual_robot_horizon(robot, bent, turn, JOINTS, 2, all, NULL, &motion));
  CHECK(motion.verdict == PUNCTUAL_ROBOT_VERDICT_CONTACT && fabs(motion.touching_at - 2 * touching) < 1e-3);
  OK(punctual_robot_horizon(robot, bent, turn, JOINTS, 2, punctual_budget_work(0), NULL, &motion));
  CHECK(motion.verdict == PUNCTUAL_ROBOT_VERDICT_UNDECIDED && motion.free_until == 0);
  OK(punctual_robot_braking_time(turn, brakes, JOINTS, &braking));
  CHECK(braking == 0.1 && punctual_robot_safe_speed(0.2, 0.001, braking) == 1);
  CHECK(punctual_robot_safe_speed(0.001, 0.001, braking) < 0.2 && punctual_robot_safe_speed(0, 0.001, braking) == 0);
}

/* The turn into the post as a polynomial, tested, and followed no faster than is proven; then two that may touch. */
static void follow(punctual_robot *robot) {
  punctual_trajectory *plan;
  punctual_horizon *horizon;
  punctual_robot_motion motion = {.size = sizeof motion};
  punctual_ahead ahead = {.size = sizeof ahead};
  punctual_budget all = punctual_budget_unlimited();
  double rows[2 * JOINTS] = {0}, values[JOINTS], seconds;
  size_t count;
  memcpy(rows, bent, sizeof bent);
  rows[JOINTS] = 1;
  OK(punctual_trajectory_new(&plan));
  OK(punctual_trajectory_push(plan, 1, rows, 2, JOINTS));
  rows[0] = 0.5;
  OK(punctual_trajectory_push(plan, 1, rows, 2, JOINTS));
  FAILS(punctual_trajectory_push(plan, 1, rows, 7, 2), BAD_ARGUMENT,
        "punctual_trajectory_push: piece 2: 7 rows, the first of 2 numbers");
  OK(punctual_trajectory_seconds(plan, &seconds));
  OK(punctual_trajectory_at(plan, 1.5, values, JOINTS, &count));
  CHECK(seconds == 2 && count == JOINTS && values[0] == 1 && values[1] == 1.2);
  OK(punctual_robot_follow(robot, plan, 1, all, NULL, &motion));
  CHECK(motion.verdict == PUNCTUAL_ROBOT_VERDICT_CONTACT && motion.free_until > 0.6);
  double touching = motion.touching_at;
  OK(punctual_robot_follow(robot, plan, 1, punctual_budget_work(2000), NULL, &motion));
  CHECK(motion.stop == PUNCTUAL_STOP_REASON_WORK_LIMIT && motion.free_until < touching);
  OK(punctual_robot_edge_resume(robot, all, NULL, &motion));
  CHECK(fabs(motion.touching_at - touching) < 1e-4);

  /* It stands still before the post. */
  OK(punctual_horizon_new(0.01, 0.1, &horizon));
  FAILS(punctual_horizon_step(horizon, robot, NULL, all, NULL, &ahead), BAD_ARGUMENT,
        "punctual_horizon_step: a trajectory of no piece, or beyond all times");
  for (int cycle = 0; cycle < 400; cycle++) {
    OK(punctual_horizon_step(horizon, robot, cycle == 0 ? plan : NULL, punctual_budget_work(20000), NULL, &ahead));
    CHECK(ahead.is_new == (cycle == 0) && ahead.stops_at <= ahead.free_until && ahead.free_until <= touching);
  }
  CHECK(ahead.is_proven && ahead.speed < 0.1 && ahead.time > 0.5 * touching && ahead.since == 0);
  OK(punctual_robot_allow(robot, "post 1", "wrist", 1));
  FAILS(punctual_robot_allow(robot, "post 1", "nose", 1), BAD_ARGUMENT,
        "punctual_robot_allow: allow: there is no link or obstacle nose");
  OK(punctual_robot_allow(robot, "wrist", "post 1", 0));
  OK(punctual_trajectory_clear(plan));
  OK(punctual_trajectory_seconds(plan, &seconds));
  CHECK(seconds == 0);
  punctual_horizon_free(horizon);
  punctual_trajectory_free(plan);
}

/* Names, limits, places; all pairs; a path there and back. */
static void parts(punctual_robot *robot, uint32_t post) {
  char name[16];
  size_t length, count;
  double lower, upper, knots[3 * JOINTS];
  uint32_t shapes[2 * 32];
  punctual_pose poses[16];
  punctual_robot_collision collision = {.size = sizeof collision};
  punctual_robot_motion motion = {.size = sizeof motion};
  punctual_budget all = punctual_budget_unlimited();
  OK(punctual_robot_joint_name(robot, 0, name, sizeof name, &length));
  CHECK(length == strlen(name) && length > 0);
  FAILS(punctual_robot_joint_name(robot, 7, name, sizeof name, &length), BAD_ARGUMENT,
        "punctual_robot_joint_name: joint is 7, but there are 7");
  OK(punctual_robot_joint_limits(robot, 0, &lower, &upper));
  CHECK(lower < upper);
  OK(punctual_robot_link_name(robot, 7, name, sizeof name, &length));
  CHECK(strcmp(name, "flange") == 0);
  OK(punctual_robot_link_poses(robot, bent, JOINTS, poses, 16, &count));
  CHECK(count == 8 && poses[0].m[0] == 1 && poses[7].m[11] > 0);
  for (int i = 0; i < 3; i++)
    memcpy(knots + i * JOINTS, i == 1 ? beyond : bent, sizeof bent);
  OK(punctual_robot_path(robot, knots, 3, JOINTS, 1, all, NULL, &motion));
  CHECK(motion.verdict == PUNCTUAL_ROBOT_VERDICT_CONTACT && motion.shapes[1] == post && motion.touching_at < 1);
  knots[0] += motion.touching_at * (beyond[0] - bent[0]);
  OK(punctual_robot_collide_all(robot, knots, JOINTS, all, NULL, shapes, 32, &count, &collision));
  CHECK(collision.verdict == PUNCTUAL_ROBOT_VERDICT_CONTACT && count >= 1 && shapes[1] == post);
}

void robots(void) {
  punctual_robot *robot;
  punctual_mesh *cube;
  punctual_tree *tree;
  punctual_robot_collision collision = {.size = sizeof collision};
  punctual_pose place = punctual_pose_identity();
  size_t joints, length;
  uint32_t post, load;
  char name[6];
  const char *nose[] = {"nose"};
  FAILS(punctual_robot_from_urdf("none.urdf", NULL, NULL, 0, &robot), BAD_FILE,
        "punctual_robot_from_urdf: none.urdf: No such file or directory (os error 2)");
  OK(punctual_robot_from_urdf("crates/robot/examples/arm7.urdf", NULL, NULL, 1, &robot));
  OK(punctual_robot_joints(robot, &joints));
  CHECK(joints == JOINTS);
  OK(punctual_shape_cuboid(0.05f, 0.05f, 0.5f, 1, &cube));
  OK(punctual_tree_new(cube, NULL, &tree));
  place.m[3] = 0.35;
  place.m[7] = 0.45;
  place.m[11] = 0.5;
  OK(punctual_robot_add(robot, "post 1", tree, place, NULL, NULL, 0, &post));
  OK(punctual_robot_shape_name(robot, post, name, sizeof name, &length));
  CHECK(length == 6 && strcmp(name, "post ") == 0);
  FAILS(punctual_robot_add(robot, "it", tree, place, "nose", NULL, 0, &load), BAD_ARGUMENT,
        "punctual_robot_add: obstacle it: there is no link nose");
  FAILS(punctual_robot_add(robot, "it", tree, place, NULL, nose, 1, &load), BAD_ARGUMENT,
        "punctual_robot_add: obstacle it: may_touch: there is no link nose");
  OK(punctual_robot_notices(robot, NULL, 0, &length));
  CHECK(length == 0);
  questions(robot, post);
  near_pairs(robot, post);
  follow(robot);
  parts(robot, post);
  FAILS(punctual_robot_collide(robot, bent, 3, punctual_budget_unlimited(), NULL, &collision), BAD_ARGUMENT,
        "punctual_robot_collide: 3 joint values, the robot has 7");

  /* In the way, gone, and in the hand. */
  place.m[7] = -0.19;
  OK(punctual_robot_move(robot, post, place));
  OK(punctual_robot_collide(robot, bent, JOINTS, punctual_budget_unlimited(), NULL, &collision));
  CHECK(collision.verdict == PUNCTUAL_ROBOT_VERDICT_CONTACT && collision.shapes[1] == post);
  OK(punctual_robot_remove(robot, post));
  FAILS(punctual_robot_remove(robot, post), BAD_ARGUMENT, "punctual_robot_remove: no such obstacle");
  OK(punctual_robot_add(robot, "load", tree, punctual_pose_identity(), "flange", NULL, 0, &load));
  OK(punctual_robot_collide(robot, bent, JOINTS, punctual_budget_unlimited(), NULL, &collision));
  CHECK(load == post + 1 && collision.verdict == PUNCTUAL_ROBOT_VERDICT_CONTACT && collision.shapes[1] == load);
  punctual_robot_free(robot);
  punctual_tree_free(tree);
  punctual_mesh_free(cube);
}
