"""The same answers as the Rust program `punctual`, and as the truth that is stored with the test cases."""

import csv
import io
import subprocess

import numpy as np
import punctual3d
import pytest
from conftest import FIXTURES, random_poses

# A file without triangles is none of a mesh.
CASES = sorted(
    path.name
    for path in FIXTURES.iterdir()
    if "expect=truth" in (path / "case.txt").read_text() and "\nf " in (path / "a.obj").read_text()
)


def read_poses(case):
    rows = np.loadtxt(FIXTURES / case / "poses.txt", ndmin=2).reshape(-1, 3, 4)
    return np.concatenate([rows, np.tile([[[0.0, 0, 0, 1]]], (len(rows), 1, 1))], axis=1)


def read_csv(text):
    return list(csv.DictReader(line for line in io.StringIO(text) if not line.startswith("#")))


def load(case):
    return [punctual3d.Tree.load(FIXTURES / case / f"{mesh}.obj") for mesh in "ab"]


@pytest.mark.parametrize("case", CASES)
def test_the_truth(case):
    batch = punctual3d.collide_batch(*load(case), read_poses(case), mode="all")
    truth = read_csv((FIXTURES / case / "truth.csv").read_text())
    assert batch.verdict.tolist() == [int(row["hit"]) for row in truth]
    assert batch.found.tolist() == [int(row["pairs"]) for row in truth]


@pytest.mark.parametrize("case", [case for case in CASES if (FIXTURES / case / "truth_distance.csv").exists()])
def test_the_true_distance(case):
    batch = punctual3d.distance_batch(*load(case), read_poses(case))
    truth = [float(row["distance"]) for row in read_csv((FIXTURES / case / "truth_distance.csv").read_text())]
    assert (batch.low <= np.nextafter(truth, np.inf)).all() and np.allclose(batch.high, truth, rtol=0, atol=1e-5)


def write_obj(path, tree):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in tree.vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in tree.faces.tolist()]
    path.write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """Files of two meshes and of poses near contact, and the same as arrays."""
    folder = tmp_path_factory.mktemp("pair")
    a, b = punctual3d.shapes.torus_knot(2, 3, 0.2, 48), punctual3d.shapes.icosphere(3)
    poses = random_poses(60, 4.0)
    write_obj(folder / "a.obj", a)
    write_obj(folder / "b.obj", b)
    np.savetxt(folder / "poses.txt", poses[:, :3].reshape(-1, 12), fmt="%.17g")
    return [folder / "a.obj", folder / "b.obj", folder / "poses.txt"], (a, b, poses)


def run(program, command, files, *options):
    said = subprocess.run([program, command, *map(str, files), *options], check=True, capture_output=True, text=True)
    return read_csv(said.stdout)


@pytest.mark.parametrize("budget", [None, 2000])
def test_the_same_collisions_as_the_program(program, pair, budget):
    files, arguments = pair
    options = [] if budget is None else ["--budget-work", str(budget)]
    rows = run(program, "pair", files, "--mode", "all", *options)
    batch = punctual3d.collide_batch(*arguments, mode="all", work=budget)
    names = {1: "intersecting", 0: "separated", -1: "undecided"}
    assert [row["verdict"] for row in rows] == [names[verdict] for verdict in batch.verdict.tolist()]
    assert [int(row["pairs"]) for row in rows] == batch.found.tolist()


@pytest.mark.parametrize("budget", [None, 2000])
def test_the_same_distances_as_the_program(program, pair, budget):
    files, arguments = pair
    options = [] if budget is None else ["--budget-work", str(budget)]
    rows = run(program, "distance", files, *options)
    batch = punctual3d.distance_batch(*arguments, work=budget)
    assert [float(row["low"]) for row in rows] == batch.low.tolist()
    assert [float(row["high"]) for row in rows] == batch.high.tolist()
    assert [int(row["work"]) for row in rows] == batch.work.tolist()
