"""A planner and a controller. The planner bends the path of an arm around posts by the gradients of near pairs, and
proves it; the controller follows it no faster than is proven, among balls that fly: python optimise_and_follow.py
"""

from pathlib import Path

import numpy as np
import punctual3d
from scipy.interpolate import CubicSpline

URDF = Path(__file__).resolve().parents[2] / "crates/robot/examples/arm7.urdf"
SAFE = 0.05  # metres
SECONDS = 2.0
CYCLE = 0.001


def at(*xyz):
    T = np.eye(4)
    T[:3, 3] = xyz
    return T


def cost(robot, Q):
    """How far pairs are within SAFE, summed, and the slope of that for each configuration."""
    near = robot.near_pairs(Q, SAFE, tolerance=1e-4)
    lack = np.maximum(SAFE - near.low, 0)
    rows = np.repeat(np.arange(len(Q)), np.diff(near.offsets))
    slope = np.zeros_like(Q)
    np.add.at(slope, rows, -2 * lack[:, None] * near.gradients)
    return (lack**2).sum(), slope


def optimise(robot, Q, rounds=100):
    """Moves all configurations but the ends down the slope, together with their neighbours. Shapes that meet have no
    slope, so it depends on the others where it goes."""
    inner = len(Q) - 2
    smooth = np.linalg.inv(2 * np.eye(inner) - np.eye(inner, k=1) - np.eye(inner, k=-1))
    for _ in range(rounds):
        found, slope = cost(robot, Q)
        if found == 0:
            return Q
        step = smooth @ slope[1:-1]
        Q[1:-1] -= 0.02 * step / max(np.abs(step).max(), 1e-9)
    return Q


def search(robot, start, goal, knots=21):
    """Bends of the straight line, drawn at random, until one is proven free when it is optimised."""
    random = np.random.default_rng(1)
    share = np.linspace(0, 1, knots)[:, None]
    for _ in range(100):
        bend = random.normal(0, 0.7, len(start)) * 4 * share * (1 - share)
        motion, fastest = plan(optimise(robot, start + share * (goal - start) + bend))
        if robot.trajectory(motion).verdict[0] == 0:
            return motion, fastest
    raise RuntimeError("no way was found")


def plan(Q):
    """A cubic spline through configurations, at rest at both ends."""
    times = np.linspace(0, SECONDS, len(Q))
    spline = CubicSpline(times, Q, bc_type="clamped")
    motion = punctual3d.Trajectory()
    for piece, seconds in enumerate(np.diff(times)):
        motion.push(seconds, spline.c[::-1, piece])
    return motion, np.abs(spline(np.linspace(0, SECONDS, 200), 1)).max(axis=0)


def follow(robot, motion, fastest, budget):
    """Drives the motion to its end. Yields what each cycle knows."""
    horizon = punctual3d.Horizon(CYCLE, punctual3d.braking_time(fastest, np.full(len(fastest), 10.0)))
    balls = [robot.add(f"ball {i}", at(9, 9, 9), sphere=0.05) for i in range(8)]
    for cycle in range(20_000):
        for i, ball in enumerate(balls):
            # Each flies past again and again; this one is seen here now, to 2 mm, and may be slowed down a little.
            x = 2 - (2 * CYCLE * cycle + 0.7 * i) % 5
            seen = at(x, 0.55 - 0.1 * i, 0.9 + 0.1 * i)
            robot.move_along(ball, seen, linear=[-2, 0, 0], reach=0.002, reach_speed=0.1)
        ahead = horizon.step(robot, motion if cycle == 0 else None, **budget)
        yield ahead
        if ahead.time > SECONDS - 1e-4:
            return


def main(budget={"budget": 200e-6}):
    robot = punctual3d.Robot.from_urdf(URDF)
    robot.add("post", at(0.45, 0.0, 0.35), cylinder=(0.05, 0.7))
    scan = np.random.default_rng(1).uniform([0.3, -0.8, 0], [0.9, 0.8, 0.1], (20_000, 3))
    robot.add("rubble", mesh=punctual3d.Tree.from_points(scan, radius=0.002))
    start, goal = np.array([-0.8, 1.0, 0.0, 0.6, 0, 0.4, 0]), np.array([0.8, 1.0, 0.0, 0.6, 0, 0.4, 0])
    before = robot.trajectory(plan(np.linspace(start, goal, 21))[0], first=True)
    motion, fastest = search(robot, start, goal)
    after = robot.trajectory(motion)
    print(f"straight: {before}, from {before.touching_at[0]:.3f} s; bent: {after}")
    cycles = list(follow(robot, motion, fastest, budget))
    slow = sum(ahead.speed < 0.9 for ahead in cycles)
    print(f"{len(cycles)} cycles, {slow} of them slower than .9, {cycles[-1].time:.3f} s of the plan")
    return before, after, motion, cycles


if __name__ == "__main__":
    main()
