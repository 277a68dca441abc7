/* A 1 kHz loop: two arms of three links, 200 microseconds a cycle to find out whether they come too close.
 *
 * The meshes stand for the links with a safety margin, so "intersecting" means "too close": back off. "Undecided" means that
 * nobody knows, and is never treated as "separated": slow down. Only "separated", which is proven, lets the arms speed up. Links
 * that are solids can also be "contained", one in the other: back off too.
 *
 * First the loop runs with budgets of work, which give the same figures in every run and every language (the lines that
 * begin with "=": examples/c/answers.rs prints them too), then by the clock. There every verdict is compared with that of a
 * query without a budget. Usage: controller [cycles] */

#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <punctual.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LINKS = 3, PAIRS = LINKS * LINKS, WORK = 20000, MOST_CYCLES = 100000 };
static const uint64_t PERIOD = 1000000, LIMIT = 200000; /* nanoseconds */

struct arm {
  punctual_pose base;
  double pace; /* joint cycles per second at full speed */
  punctual_pose links[LINKS];
};

struct robot {
  punctual_tree *trees[LINKS];
  punctual_workspace *workspace, *unhurried;
  punctual_memory *memories[PAIRS];
};

struct journey {
  int separated, undecided, touching; /* cycles */
  int backs_off;
  double phase, speed, direction;
};

static void must(punctual_status status) {
  if (status != PUNCTUAL_STATUS_OK) {
    fprintf(stderr, "%s\n", punctual_last_error());
    exit(1);
  }
}

static uint64_t now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (uint64_t)time.tv_sec * 1000000000u + (uint64_t)time.tv_nsec;
}

/* From -1 to 1 and back, once as x grows by 1. */
static double swing(double x) { return 4 * fabs(x - floor(x + 0.5)) - 1; }

static punctual_pose moved(punctual_pose pose, double along_x) {
  punctual_pose step = punctual_pose_identity();
  step.m[3] = along_x;
  must(punctual_pose_compose(pose, step, &pose));
  return pose;
}

/* Joints turn about z, y, z; t is the tangent of half the angle. */
static void place(struct arm *arm, double phase) {
  punctual_pose frame = arm->base, turn;
  for (int i = 0; i < LINKS; i++) {
    double t = 0.6 * swing(arm->pace * phase + 0.17 * i);
    must(punctual_pose_from_quaternion(0, i == 1 ? t : 0, i == 1 ? 0 : t, 1, (punctual_point){0, 0, 0}, &turn));
    must(punctual_pose_compose(frame, turn, &frame));
    arm->links[i] = moved(frame, 0.5);
    frame = moved(frame, 1);
  }
}

/* Whether the links are known to be too close: their surfaces meet, or one is in the other. A verdict that this program does not
 * know counts as that. */
static int is_contact(punctual_verdict verdict) {
  return verdict != PUNCTUAL_VERDICT_SEPARATED && verdict != PUNCTUAL_VERDICT_UNDECIDED;
}

/* One check of all pairs of links within a budget that they share. */
static punctual_verdict check(struct robot *robot, const struct arm arms[2], int by_the_clock,
                              punctual_verdict each[PAIRS], punctual_pose poses[PAIRS]) {
  punctual_verdict all = PUNCTUAL_VERDICT_SEPARATED;
  uint64_t began = now(), left = by_the_clock ? LIMIT : WORK;
  for (int pair = 0; pair < PAIRS; pair++) {
    int i = pair / LINKS, j = pair % LINKS;
    punctual_outcome outcome = {.size = sizeof outcome};
    must(punctual_pose_inverse(arms[0].links[i], &poses[pair]));
    must(punctual_pose_compose(poses[pair], arms[1].links[j], &poses[pair]));
    punctual_query query = punctual_query_new(robot->trees[i], robot->trees[j], poses[pair]);
    uint64_t share = left / (uint64_t)(PAIRS - pair);
    punctual_budget budget = by_the_clock ? punctual_budget_time(share) : punctual_budget_work(share);
    must(punctual_query_run(&query, robot->workspace, robot->memories[pair], budget, NULL, &outcome));
    uint64_t spent = by_the_clock ? now() - began : WORK - left + outcome.stats.work;
    left = (by_the_clock ? LIMIT : WORK) > spent ? (by_the_clock ? LIMIT : WORK) - spent : 0;
    each[pair] = outcome.verdict;
    if (is_contact(outcome.verdict) ||
        (outcome.verdict == PUNCTUAL_VERDICT_UNDECIDED && all == PUNCTUAL_VERDICT_SEPARATED))
      all = outcome.verdict;
  }
  return all;
}

/* What the verdict means for the motion. */
static void act(struct journey *journey, punctual_verdict verdict) {
  int contact = is_contact(verdict);
  journey->separated += verdict == PUNCTUAL_VERDICT_SEPARATED;
  journey->undecided += verdict == PUNCTUAL_VERDICT_UNDECIDED;
  journey->touching += contact;
  if (verdict == PUNCTUAL_VERDICT_SEPARATED) {
    journey->speed = fmin(1, 1.05 * journey->speed + 0.01);
  } else if (verdict == PUNCTUAL_VERDICT_UNDECIDED) {
    journey->speed = 0.5 * journey->speed + 0.01;
  } else {
    /* Back where it came from, until it is clear. */
    journey->direction *= journey->backs_off ? 1 : -1;
    journey->speed = 0.3;
  }
  journey->backs_off = contact;
  journey->phase += journey->direction * journey->speed * 0.001;
}

static void place_both(struct arm arms[2], double phase) {
  place(&arms[0], phase);
  place(&arms[1], phase);
}

/* Decided verdicts that a query without a budget contradicts. */
static int mistakes(struct robot *robot, const punctual_verdict each[PAIRS], const punctual_pose poses[PAIRS]) {
  int wrong = 0;
  for (int pair = 0; pair < PAIRS; pair++) {
    punctual_query query = punctual_query_new(robot->trees[pair / LINKS], robot->trees[pair % LINKS], poses[pair]);
    punctual_outcome truth = {.size = sizeof truth};
    must(punctual_query_run(&query, robot->unhurried, NULL, punctual_budget_unlimited(), NULL, &truth));
    wrong += each[pair] != PUNCTUAL_VERDICT_UNDECIDED && each[pair] != truth.verdict;
  }
  return wrong;
}

static int ascending(const void *x, const void *y) {
  uint64_t a = *(const uint64_t *)x, b = *(const uint64_t *)y;
  return (a > b) - (a < b);
}

static punctual_tree *tree_of(punctual_mesh *mesh) {
  punctual_tree *tree;
  must(punctual_tree_new(mesh, NULL, &tree));
  punctual_mesh_free(mesh);
  return tree;
}

static void forget(struct robot *robot) {
  for (int pair = 0; pair < PAIRS; pair++) {
    punctual_memory_free(robot->memories[pair]);
    must(punctual_memory_new(&robot->memories[pair]));
  }
}

int main(int count, char **arguments) {
  int cycles = count > 1 ? atoi(arguments[1]) : 2000;
  if (cycles < 1 || cycles > MOST_CYCLES)
    return fprintf(stderr, "usage: controller [cycles, 1 to %d]\n", MOST_CYCLES), 2;
  if (strcmp(punctual_version(), PUNCTUAL_VERSION) != 0)
    return fprintf(stderr, "library %s, header %s\n", punctual_version(), PUNCTUAL_VERSION), 1;

  /* Everything is allocated here, and nothing in the loop. */
  struct robot robot = {0};
  punctual_mesh *mesh;
  must(punctual_shape_cuboid(0.5f, 0.1f, 0.1f, 16, &mesh));
  robot.trees[0] = tree_of(mesh);
  must(punctual_shape_torus_knot(2, 3, 0.1f, 256, &mesh));
  robot.trees[1] = tree_of(mesh);
  must(punctual_shape_torus(0.4f, 0.1f, 96, &mesh));
  robot.trees[2] = tree_of(mesh);
  must(punctual_workspace_new(&robot.workspace));
  must(punctual_workspace_new(&robot.unhurried));
  forget(&robot);
  struct arm arms[2] = {{.base = punctual_pose_identity(), .pace = 1.3}, {.pace = 0.9}};
  must(punctual_pose_from_quaternion(0, 0, 1, 0, (punctual_point){3.4, 0.3, 0.1}, &arms[1].base)); /* half a turn */

  punctual_verdict each[PAIRS];
  punctual_pose poses[PAIRS];
  struct journey plan = {.speed = 0.1, .direction = 1};
  for (int cycle = 0; cycle < 2000; cycle++) {
    place_both(arms, plan.phase);
    act(&plan, check(&robot, arms, 0, each, poses));
  }
  printf("= controller: %d separated, %d undecided, %d intersecting, phase %.12f\n", plan.separated, plan.undecided,
         plan.touching, plan.phase);

  forget(&robot);
  struct journey drive = {.speed = 0.1, .direction = 1};
  uint64_t *took = calloc((size_t)cycles, sizeof *took);
  uint64_t next = now();
  int wrong = 0;
  for (int cycle = 0; cycle < cycles; cycle++) {
    place_both(arms, drive.phase);
    uint64_t began = now();
    punctual_verdict verdict = check(&robot, arms, 1, each, poses);
    took[cycle] = now() - began;
    act(&drive, verdict);
    wrong += mistakes(&robot, each, poses); /* not part of a real loop */
    next += PERIOD;
    struct timespec until = {.tv_sec = (time_t)(next / 1000000000u), .tv_nsec = (long)(next % 1000000000u)};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
  }
  qsort(took, (size_t)cycles, sizeof *took, ascending);
  printf("%d cycles: %d separated, %d undecided, %d intersecting\n", cycles, drive.separated, drive.undecided,
         drive.touching);
  printf("check took, microseconds: median %.1f, 99 %% below %.1f, most %.1f\n", (double)took[cycles / 2] / 1e3,
         (double)took[cycles * 99 / 100] / 1e3, (double)took[cycles - 1] / 1e3);
  printf("verdicts that were wrong: %d\n", wrong);

  free(took);
  for (int pair = 0; pair < PAIRS; pair++)
    punctual_memory_free(robot.memories[pair]);
  punctual_workspace_free(robot.unhurried);
  punctual_workspace_free(robot.workspace);
  for (int i = 0; i < LINKS; i++)
    punctual_tree_free(robot.trees[i]);
  return wrong != 0;
}
