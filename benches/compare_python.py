#!/usr/bin/env python3
"""Many poses of a mesh against itself: the Python packages punctual3d, python-fcl and coal, in one run.

    benches/compare_python.py MESH.obj [POSES]

Poses are drawn at random in two ways: turned anyhow and moved apart by 0.2 to 1.1 of the diagonal of the mesh; and moved
in from afar until the surfaces touch, and on by -0.002 to 0.05 of the extent. Each package is asked whether the surfaces
meet, with one thread, and a batch with two as well; the answers are compared. Needs `pip install trimesh python-fcl coal`
beside punctual3d.
"""

import sys
import time

import coal
import fcl
import numpy as np
import punctual3d
import trimesh


def anyhow(mesh, count):
    random = np.random.default_rng(1)
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3] = [trimesh.transformations.random_rotation_matrix(random.random(3))[:3, :3] for _ in range(count)]
    away = random.normal(size=(count, 3))
    away *= (mesh.scale * random.uniform(0.2, 1.1, count) / np.linalg.norm(away, axis=1))[:, None]
    # About the middle of the mesh.
    middle = mesh.bounds.mean(axis=0)
    poses[:, :3, 3] = middle - poses[:, :3, :3] @ middle + away
    return poses


def at_contact(mesh, count):
    random, tree = np.random.default_rng(2), punctual3d.Tree.from_trimesh(mesh)
    middle, extent = mesh.bounds.mean(axis=0), mesh.extents.max()
    poses = []
    while len(poses) < count:
        pose, way = np.eye(4), random.normal(size=3)
        way *= 2.4 * extent / np.linalg.norm(way)
        pose[:3, :3] = trimesh.transformations.random_rotation_matrix(random.random(3))[:3, :3]
        pose[:3, 3] = middle + random.normal(0, 0.15 * extent, 3) - pose[:3, :3] @ middle - way
        touching_at = punctual3d.motion(tree, tree, pose, velocity=way).touching_at
        if touching_at is not None:
            pose[:3, 3] += way * (touching_at + random.choice([-0.002, 0.001, 0.005, 0.02, 0.05]) / 2.4)
            poses.append(pose)
    return np.array(poses)


def timed(name, build, ask, mesh, poses):
    """Builds once, asks `ask(built, poses)` for a list of yes and no: the least of three times, in us a pose."""
    start = time.perf_counter()
    built = build(mesh)
    seconds = time.perf_counter() - start
    least = np.inf
    for _ in range(3):
        start = time.perf_counter()
        answers = ask(built, poses)
        least = min(least, time.perf_counter() - start)
    print(
        f"{name:12s} build {1e3 * seconds:6.0f} ms, {1e6 * least / len(poses):8.2f} us a pose, {np.sum(answers)} meet",
        flush=True,
    )
    return np.array(answers, dtype=bool), least


def build_fcl(mesh):
    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.faces))
    model.addSubModel(mesh.vertices, mesh.faces)
    model.endModel()
    return model


def ask_fcl(model, poses):
    a, b = fcl.CollisionObject(model), fcl.CollisionObject(model)
    said = []
    for pose in poses:
        b.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        said.append(fcl.collide(a, b, fcl.CollisionRequest(), fcl.CollisionResult()) > 0)
    return said


def build_coal(mesh):
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.faces), len(mesh.vertices))
    model.addVertices(np.asarray(mesh.vertices, dtype=np.float64))
    model.addTriangles(np.asarray(mesh.faces, dtype=np.uint32))
    model.endModel()
    return model


def ask_coal(model, poses):
    here, request, result, said = coal.Transform3s.Identity(), coal.CollisionRequest(), coal.CollisionResult(), []
    # Without this it looks for the distance where surfaces are closer than a millimetre.
    request.break_distance = 0.0
    for pose in poses:
        there = coal.Transform3s(pose[:3, :3], pose[:3, 3])
        result.clear()
        said.append(coal.collide(model, here, model, there, request, result) > 0)
    return said


def main():
    mesh = trimesh.load(sys.argv[1], process=False)
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 10_000
    for draw in (anyhow, at_contact):
        print(f"{len(mesh.faces)} triangles against themselves at {count} poses, {draw.__name__}", flush=True)
        compare(mesh, draw(mesh, count))


def compare(mesh, poses):
    def batch(threads):
        return lambda tree, poses: punctual3d.collide_batch(tree, tree, poses, threads=threads).verdict == 1

    def one_by_one(tree, poses):
        return [bool(punctual3d.collide(tree, tree, pose)) for pose in poses]

    ours, least = timed("batch", punctual3d.Tree.from_trimesh, batch(1), mesh, poses)
    others = {
        "two threads": (punctual3d.Tree.from_trimesh, batch(2)),
        "one by one": (punctual3d.Tree.from_trimesh, one_by_one),
        "python-fcl": (build_fcl, ask_fcl),
        "coal": (build_coal, ask_coal),
    }
    for name, (build, ask) in others.items():
        answers, seconds = timed(name, build, ask, mesh, poses)
        print(f"{'':12s} {seconds / least:.1f} times the batch, {np.sum(answers != ours)} other answers", flush=True)


if __name__ == "__main__":
    main()
