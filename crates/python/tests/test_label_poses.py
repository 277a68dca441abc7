"""The example on Dask: two workers say what one process says."""

import importlib.util
from pathlib import Path

import numpy as np
import punctual3d
import pytest

EXAMPLE = Path(__file__).resolve().parents[3] / "examples/python/label_poses.py"


def test_two_workers_and_one_process():
    distributed = pytest.importorskip("distributed")
    spec = importlib.util.spec_from_file_location("label_poses", EXAMPLE)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    a, b = punctual3d.shapes.torus_knot(2, 3, 0.2, 128), punctual3d.shapes.icosphere(4)
    chunks, options = [500, 500, 200], (3.0, 3000)
    alone = [example.label(a, b, seed, count, *options) for seed, count in enumerate(chunks)]
    labels, probabilities = (np.concatenate(part) for part in zip(*alone))
    assert set(labels.tolist()) == {-1, 0, 1}
    # Workers of their own processes, which import the example as this one does.
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        client.upload_file(str(EXAMPLE))
        said = example.label_all(client, a, b, 1200, 500, *options)
    assert np.array_equal(said[0], labels) and np.array_equal(said[1], probabilities)
