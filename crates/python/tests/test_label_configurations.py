"""The example on Dask: two workers say what one process says."""

import importlib.util
from pathlib import Path

import numpy as np
import punctual3d
import pytest

ROOT = Path(__file__).resolve().parents[3]
EXAMPLE = ROOT / "examples/python/label_configurations.py"


def test_two_workers_and_one_process():
    distributed = pytest.importorskip("distributed")
    spec = importlib.util.spec_from_file_location("label_configurations", EXAMPLE)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    robot = punctual3d.Robot.from_urdf(ROOT / "crates/robot/examples/arm7.urdf")
    robot.add("torus", mesh=punctual3d.shapes.torus(0.6, 0.2, 64))
    alone = [example.label(robot, seed, count) for seed, count in enumerate([500, 500, 200])]
    Q, labels = (np.concatenate(part) for part in zip(*alone))
    assert set(labels.tolist()) == {False, True}
    # Workers of their own processes, which import the example as this one does.
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        client.upload_file(str(EXAMPLE))
        said = example.label_all(client, robot, 1200, 500)
    assert np.array_equal(said[0], Q) and np.array_equal(said[1], labels)
