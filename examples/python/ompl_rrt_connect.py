#!/usr/bin/env python3
"""Plans a robot's motion by OMPL's RRT-Connect; what it returns is proven free, not sampled.

    pip install ompl
    python examples/python/ompl_rrt_connect.py robot.urdf --srdf robot.srdf --env FOLDER_OF_MESHES
"""

import argparse
from pathlib import Path

import numpy as np
import punctual3d
from ompl import base, geometric


def plan(robot, start, goal, seconds=10.0):
    """Configurations from start to goal, (N, J), or None."""
    size = len(start)
    numbers = lambda state: np.array([state[i] for i in range(size)])
    space = base.RealVectorStateSpace(size)
    bounds = base.RealVectorBounds(size)
    for i, (low, high) in enumerate(np.clip(robot.joint_limits, -np.pi, np.pi)):
        bounds.setLow(i, low)
        bounds.setHigh(i, high)
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()

    class Motions(base.MotionValidator):
        def checkMotion(self, a, b, last=None):
            return robot.is_edge_valid(numbers(a), numbers(b))

    setup.setStateValidityChecker(lambda state: robot.is_valid(numbers(state)))
    motions = Motions(information)
    information.setMotionValidator(motions)
    ends = [space.allocState() for _ in range(2)]
    for end, values in zip(ends, (start, goal)):
        for i, value in enumerate(values):
            end[i] = float(value)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(geometric.RRTConnect(information))
    if not setup.solve(seconds):
        return None
    path = setup.getSolutionPath()
    return np.array([numbers(path.getState(i)) for i in range(path.getStateCount())])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("urdf")
    parser.add_argument("--srdf")
    parser.add_argument("--env", type=Path, help="a folder of meshes in world coordinates")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    robot = punctual3d.Robot.from_urdf(options.urdf, srdf=options.srdf)
    for file in sorted(options.env.iterdir()) if options.env else []:
        robot.add(file.stem, mesh=punctual3d.Tree.load(file))
    low, high = np.clip(robot.joint_limits, -np.pi, np.pi).T
    samples = np.random.default_rng(options.seed).uniform(low, high, (1000, len(low)))
    free = samples[robot.collide(samples).verdict == 0]
    path = plan(robot, free[0], free[1])
    if path is None:
        raise SystemExit("no path found")
    print(f"{len(path)} configurations, proven free:", (robot.edges(path[:-1], path[1:]).verdict == 0).all())
    print(path.round(3))


if __name__ == "__main__":
    main()
