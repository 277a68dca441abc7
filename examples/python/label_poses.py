#!/usr/bin/env python3
"""Labels many poses on the workers of Dask: does a part collide at each of them, and how sure is that?

    pip install dask distributed
    python examples/python/label_poses.py --poses 20000 --workers 2 --out labels.npz

The trees go once to each worker. A pose has a budget of work, not of time, so that its label is the same to the bit on
any number of workers and on any machine; where the budget ends before the answer is known, the label is -1 and the
probability an estimate.
"""

import argparse

import numpy as np
import punctual3d
from distributed import Client, LocalCluster


def random_poses(seed, count, reach):
    """Rotations drawn evenly, translations within a cube, (count, 4, 4): the same for the same seed."""
    random = np.random.default_rng(seed)
    quaternions = random.normal(size=(4, count))
    w, x, y, z = quaternions / np.linalg.norm(quaternions, axis=0)
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=1)
    poses[:, 1, :3] = np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=1)
    poses[:, 2, :3] = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)
    poses[:, :3, 3] = random.uniform(-reach, reach, size=(count, 3))
    return poses


def label(a, b, seed, count, reach, work):
    """The labels of a chunk: 1 collides, 0 does not, -1 not known; and the probability of a collision."""
    batch = punctual3d.collide_batch(a, b, random_poses(seed, count, reach), work=work)
    return batch.verdict, batch.probability


def label_all(client, a, b, poses, chunk, reach, work):
    """The labels of all poses, in order. Each worker gets both trees once."""
    trees = client.scatter([a, b], broadcast=True)
    counts = [min(chunk, poses - start) for start in range(0, poses, chunk)]
    chunks = [client.submit(label, *trees, seed, count, reach, work) for seed, count in enumerate(counts)]
    labels, probabilities = zip(*client.gather(chunks))
    return np.concatenate(labels), np.concatenate(probabilities)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--a", help="mesh file; a torus knot without it")
    parser.add_argument("--b", help="mesh file; a ball without it")
    parser.add_argument("--poses", type=int, default=20_000)
    parser.add_argument("--reach", type=float, default=3.0, help="translations along each axis, at most")
    parser.add_argument("--work", type=int, default=3_000, help="budget of a pose, in units of work")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--chunk", type=int, default=1_000, help="poses of a task")
    parser.add_argument("--out", help="file for the labels, .npz")
    args = parser.parse_args()

    a = punctual3d.Tree.load(args.a) if args.a else punctual3d.shapes.torus_knot(2, 3, 0.2, 128)
    b = punctual3d.Tree.load(args.b) if args.b else punctual3d.shapes.icosphere(4)
    cluster = LocalCluster(n_workers=args.workers, threads_per_worker=1, dashboard_address=None)
    with cluster, Client(cluster) as client:
        labels, probabilities = label_all(client, a, b, args.poses, args.chunk, args.reach, args.work)
    hits, open_ = np.sum(labels == 1), np.sum(labels == -1)
    print(f"{args.poses} poses: {hits} collide, {np.sum(labels == 0)} do not, {open_} not known")
    if args.out:
        np.savez_compressed(args.out, labels=labels, probabilities=probabilities)


if __name__ == "__main__":
    main()
