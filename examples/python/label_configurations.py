#!/usr/bin/env python3
"""Labels random configurations of a robot on the workers of Dask: which of them collide?

    pip install dask distributed
    python examples/python/label_configurations.py robot.urdf --srdf robot.srdf --env FOLDER_OF_MESHES

The robot with its obstacles goes once to each worker. Labels are exact, so they are the same on any number of workers.
"""

import argparse
from pathlib import Path

import numpy as np
import punctual3d
from distributed import Client, LocalCluster


def configurations(robot, seed, count):
    """Drawn evenly within the limits of the joints, (count, J); joints without limits turn once."""
    low, high = np.clip(robot.joint_limits, -np.pi, np.pi).T
    return np.random.default_rng(seed).uniform(low, high, (count, len(low)))


def label(robot, seed, count):
    """A chunk: the configurations, and whether they collide."""
    Q = configurations(robot, seed, count)
    return Q, robot.collide(Q).verdict == 1


def label_all(client, robot, count, chunk):
    """All chunks, in order. Each worker gets the robot once."""
    there = client.scatter(robot, broadcast=True)
    counts = [min(chunk, count - start) for start in range(0, count, chunk)]
    chunks = [client.submit(label, there, seed, count) for seed, count in enumerate(counts)]
    return [np.concatenate(part) for part in zip(*client.gather(chunks))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("urdf", help="the robot; its files must be found by each worker")
    parser.add_argument("--srdf", help="pairs of links that may touch")
    parser.add_argument("--env", type=Path, help="folder of meshes in world coordinates")
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--chunk", type=int, default=10_000, help="configurations of a task")
    parser.add_argument("--out", help="file for configurations and labels, .npz")
    args = parser.parse_args()

    robot = punctual3d.Robot.from_urdf(args.urdf, srdf=args.srdf)
    for file in sorted(args.env.iterdir()) if args.env else []:
        robot.add(file.stem, mesh=punctual3d.Tree.load(file))
    cluster = LocalCluster(n_workers=args.workers, threads_per_worker=1, dashboard_address=None)
    with cluster, Client(cluster) as client:
        Q, labels = label_all(client, robot, args.count, args.chunk)
    print(f"{len(Q)} configurations, of which {labels.sum()} collide")
    if args.out:
        np.savez_compressed(args.out, configurations=Q, labels=labels)


if __name__ == "__main__":
    main()
