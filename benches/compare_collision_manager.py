#!/usr/bin/env python3
"""`CollisionManager` against trimesh's: processor time of a pose set and the question whether anything meets.

    benches/compare_collision_manager.py [POSES]

Two objects: a ball of 5,120 triangles and a torus of 2,048, two tori, two boxes; poses at random. Tells microseconds a
pose, the least of five runs in turn, and fails if an answer differs or ours is not twice as fast. Needs
`pip install trimesh python-fcl` beside punctual3d.
"""

import sys
import time

import numpy as np
import punctual3d
import trimesh

MANAGERS = (trimesh.collision.CollisionManager, punctual3d.CollisionManager)


def poses(random, spread, count):
    poses = np.tile(np.eye(4), (count, 1, 1))
    for pose in poses:
        pose[:] = trimesh.transformations.random_rotation_matrix(random.random(3))
        pose[:3, 3] = random.normal(size=3) * spread
    return poses


def run(manager, poses):
    began, hits = time.process_time(), []
    for pose in poses:
        manager.set_transform("b", pose)
        hits.append(manager.in_collision_internal())
    return 1e6 * (time.process_time() - began) / len(poses), hits


def main():
    count, random = int(sys.argv[1]) if len(sys.argv) > 1 else 1000, np.random.default_rng(0)
    ball, torus, box = trimesh.creation.icosphere(4), trimesh.creation.torus(1, 0.3), trimesh.creation.box()
    slow = False
    for name, a, b, spread in [("ball, torus", ball, torus, 1.0), ("tori", torus, torus, 1.0), ("boxes", box, box, 0.8)]:
        placed, managers = poses(random, spread, count), [manager() for manager in MANAGERS]
        for manager in managers:
            manager.add_object("a", a)
            manager.add_object("b", b)
        runs = [[run(manager, placed) for manager in managers] for _ in range(5)]
        assert all(theirs[1] == ours[1] for theirs, ours in runs)
        theirs, ours = (min(pair[which][0] for pair in runs) for which in (0, 1))
        slow |= theirs < 2 * ours
        print(f"{name}: trimesh {theirs:.1f} us, punctual {ours:.1f} us a pose, {sum(runs[0][0][1])} of {count} meet")
    sys.exit(slow)


main()
