// A 1 kHz loop: an arm with seven joints sweeps towards a post. Each cycle asks, within 200 microseconds, how fast the arm may go so
// that it can still stop where its plan is proven free. What is not proven counts as not free: a busy machine makes the arm slower,
// never unsafe.
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
  const double cycle = 0.001;
  const punctual_budget budget = punctual_budget_time(200000);
  punctual::Robot robot = punctual::Robot::from_urdf(count > 1 ? arguments[1] : "crates/robot/examples/arm7.urdf").value();
  const int cycles = count > 2 ? std::atoi(arguments[2]) : 3000;
  punctual::Tree post = punctual::Tree::build(punctual::Mesh::cuboid(0.05F, 0.05F, 0.5F, 1).value()).value();
  punctual_pose place = punctual_pose_identity();
  place.m[3] = 0.35, place.m[7] = 0.45, place.m[11] = 0.5;
  const std::uint32_t obstacle = robot.add("post", post, place).value();

  const std::size_t joints = robot.joints().value();
  // The plan, at full speed: one line for three seconds. Row 0 is where it begins, row 1 the velocity.
  std::vector<double> rows(2 * joints), q(joints), brakes(joints, 10.0);
  const double bent[] = {-0.5, 1.2, 0.3, 0.4, 0.0, 0.2, 0.0};
  std::copy_n(bent, std::min<std::size_t>(joints, 7), rows.begin());
  rows[joints] = 1.0;
  punctual::Trajectory plan = punctual::Trajectory::make().value();
  if (plan.push(3.0, rows.data(), 2, joints) != PUNCTUAL_STATUS_OK)
    return 1;
  const double braking = punctual::Robot::braking_time(rows.data() + joints, brakes.data(), joints).value();
  punctual::Horizon horizon = punctual::Horizon::make(cycle, braking).value();
  int late = 0;
  clock::time_point next = clock::now();
  for (int i = 0; i < cycles; i++) {
    const clock::time_point start = clock::now();
    const punctual_ahead ahead = horizon.step(robot, i == 0 ? &plan : nullptr, budget).value();
    late += clock::now() - start > std::chrono::microseconds(250);
    (void)plan.at(ahead.time, q.data(), joints).value(); // where to bring the joints
    if (i % 500 == 0)
      std::printf("%4d ms: %.2f of the speed, free until %.3f s of the plan\n", i, ahead.speed, ahead.free_until);
    std::this_thread::sleep_until(next += std::chrono::milliseconds(1));
  }
  const punctual_robot_clearance rest =
      robot.measure(q.data(), joints, 1e-6, punctual_budget_unlimited()).value();
  const punctual_robot_collision there = robot.collide(q.data(), joints, punctual_budget_unlimited()).value();
  std::printf("at %.3f rad, %.2f mm from shape %u of %u; %d cycles took more than 250 us\n", q[0], rest.low * 1e3,
              static_cast<unsigned>(rest.shapes[1]), static_cast<unsigned>(obstacle), late);
  return there.verdict == PUNCTUAL_ROBOT_VERDICT_FREE ? 0 : 1;
}
