// A 1 kHz loop: an arm with seven joints sweeps towards a post. In each cycle it asks, within 200 microseconds, for how long it would
// stay free, and goes no faster than it can stop in that time. What is not proven counts as not free: a busy machine makes the arm
// slower, never unsafe.
//
// Usage: robot [ROBOT.urdf [cycles]], from the root of the repository.

#include <punctual.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

int main(int count, char **arguments) {
  using clock = std::chrono::steady_clock;
  const double cycle = 0.001, ahead = 0.2;
  const punctual_budget budget = punctual_budget_time(200000);
  punctual::Robot robot = punctual::Robot::from_urdf(count > 1 ? arguments[1] : "crates/robot/examples/arm7.urdf").value();
  const int cycles = count > 2 ? std::atoi(arguments[2]) : 3000;
  punctual::Tree post = punctual::Tree::build(punctual::Mesh::cuboid(0.05F, 0.05F, 0.5F, 1).value()).value();
  punctual_pose place = punctual_pose_identity();
  place.m[3] = 0.35, place.m[7] = 0.45, place.m[11] = 0.5;
  const std::uint32_t obstacle = robot.add("post", post, place).value();

  const std::size_t joints = robot.joints().value();
  std::vector<double> q(joints), velocity(joints), brakes(joints, 10.0);
  const double bent[] = {-0.5, 1.2, 0.3, 0.4, 0.0, 0.2, 0.0};
  std::copy_n(bent, std::min<std::size_t>(joints, 7), q.begin());
  velocity[0] = 1.0;
  const double braking = punctual::Robot::braking_time(velocity.data(), brakes.data(), joints).value();
  double speed = 0, free_for = 0;
  int late = 0;
  clock::time_point next = clock::now();
  for (int i = 0; i < cycles; i++) {
    const clock::time_point start = clock::now();
    const punctual_robot_motion known = robot.horizon(q.data(), velocity.data(), joints, ahead, budget).value();
    late += clock::now() - start > std::chrono::microseconds(250);
    // What was proven before remains true, so the arm can always brake as it planned.
    free_for = std::max(known.free_until, free_for);
    const double change = cycle / braking, allowed = punctual::Robot::safe_speed(free_for, cycle, braking);
    speed = std::min(speed + change, std::max(allowed, speed - change));
    for (std::size_t joint = 0; joint < joints; joint++)
      q[joint] += speed * velocity[joint] * cycle;
    free_for = std::max(free_for - speed * cycle, 0.0);
    if (i % 500 == 0)
      std::printf("%4d ms: %.2f of the speed, free for %.3f s\n", i, speed, free_for);
    std::this_thread::sleep_until(next += std::chrono::milliseconds(1));
  }
  const punctual_robot_clearance rest =
      robot.measure(q.data(), joints, 1e-6, punctual_budget_unlimited()).value();
  const punctual_robot_collision there = robot.collide(q.data(), joints, punctual_budget_unlimited()).value();
  std::printf("at %.3f rad, %.2f mm from shape %u of %u; %d cycles took more than 250 us\n", q[0], rest.low * 1e3,
              static_cast<unsigned>(rest.shapes[1]), static_cast<unsigned>(obstacle), late);
  return there.verdict == PUNCTUAL_ROBOT_VERDICT_FREE ? 0 : 1;
}
