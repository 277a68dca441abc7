"""What the tests share: generated pairs of meshes at poses near contact, and the cases of the repository."""

import os
from pathlib import Path

import numpy as np
import punctual3d
import pytest

FIXTURES = Path(__file__).resolve().parents[3] / "tests" / "fixtures" / "meshes"


def random_poses(count, reach, seed=1):
    """Rotations drawn evenly, translations within a ball of this radius, (count, 4, 4)."""
    random = np.random.default_rng(seed)
    poses = np.tile(np.eye(4), (count, 1, 1))
    q, r = np.linalg.qr(random.normal(size=(count, 3, 3)))
    q *= np.sign(np.diagonal(r, axis1=1, axis2=2))[:, None, :]
    q[:, :, 0] *= np.linalg.det(q)[:, None]
    poses[:, :3, :3] = q
    direction = random.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    poses[:, :3, 3] = direction * (reach * random.random(count) ** (1 / 3))[:, None]
    return poses


@pytest.fixture(scope="session")
def ball():
    return punctual3d.shapes.icosphere(3)


@pytest.fixture(scope="session")
def ring():
    return punctual3d.shapes.torus(2.0, 0.5, 48)


@pytest.fixture(scope="session")
def poses():
    return random_poses(120, 3.5)


@pytest.fixture
def touching():
    """A pose at which ball and ring meet."""
    pose = np.eye(4)
    pose[0, 3] = 1.0
    return pose


@pytest.fixture(scope="session")
def program():
    """The program `punctual`, if the environment names it."""
    path = os.environ.get("PUNCTUAL_PROGRAM")
    if not path:
        pytest.skip("PUNCTUAL_PROGRAM does not name the program")
    return path
