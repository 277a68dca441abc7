"""OMPL's RRT-Connect on proven motions: ompl_rrt_connect.py ROBOT.urdf ROBOT.srdf FOLDER_OF_MESHES"""

import sys
from pathlib import Path

import numpy as np
import punctual3d
from ompl import base, geometric

robot = punctual3d.Robot.from_urdf(sys.argv[1], srdf=sys.argv[2])
for file in sorted(Path(sys.argv[3]).iterdir()):
    robot.add(file.stem, mesh=punctual3d.Tree.load(file))
low, high = np.clip(robot.joint_limits, -np.pi, np.pi).T
samples = np.random.default_rng(1).uniform(low, high, (1000, len(low)))
free = samples[robot.collide(samples).verdict == 0]

space = base.RealVectorStateSpace(0)
for limits in zip(low, high):
    space.addDimension(*limits)
ends = [space.allocState(), space.allocState()]
for i in range(len(low)):
    ends[0][i], ends[1][i] = free[:2, i].tolist()
values = lambda state: [state[i] for i in range(len(low))]


class Motions(base.MotionValidator):
    def checkMotion(self, a, b, last=None):
        return robot.is_edge_valid(values(a), values(b))


setup = geometric.SimpleSetup(space)
motions = Motions(setup.getSpaceInformation())
setup.setStateValidityChecker(lambda state: robot.is_valid(values(state)))
setup.getSpaceInformation().setMotionValidator(motions)
setup.setStartAndGoalStates(*ends)
setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
if setup.solve(10.0):
    print(np.array([values(state) for state in setup.getSolutionPath().getStates()]))
