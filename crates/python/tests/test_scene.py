"""Many bodies, one budget a frame."""

import numpy as np
import punctual
import pytest
from conftest import random_poses


def placed(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def test_frames(ball, ring):
    scene = punctual.Scene(mode="all")
    ring_id, ball_id = scene.insert(ring, fixed=True), scene.insert(ball, placed(1.0))
    report = scene.step()
    assert report.frame == 1 and report.bodies.tolist() == [[ring_id, ball_id]]
    assert report.verdict.tolist() == [1] and report.age.tolist() == [0] and report.probability.tolist() == [1.0]
    pair = punctual.collide(ring, ball, placed(1.0), mode="all")
    assert report.found.tolist() == [pair.found] and tuple(report.witness[0]) in {tuple(p) for p in pair.pairs.tolist()}
    assert scene.certificate(ring_id, ball_id) == (pair.found, 0.0)
    scene.set_pose(ball_id, placed(0.0))
    assert scene.step(work=0).verdict.tolist() == [-1]
    assert scene.step(10.0).verdict.tolist() == [0] and scene.step(10.0).elapsed > 0
    scene.set_poses([ball_id], [placed(50.0)])
    assert len(scene.step().verdict) == 0
    scene.remove(ball_id)
    assert len(scene) == 1


def test_a_scene_says_what_single_queries_say(ball):
    poses = random_poses(30, 5.0)
    scene = punctual.Scene()
    names = [scene.insert(ball) for _ in poses]
    scene.set_poses(names, poses)
    report = scene.step()
    said = {tuple(pair) for pair in report.bodies[report.verdict == 1].tolist()}
    inverse = np.linalg.inv(poses)
    meet = {
        (names[i], names[j]) for i in range(30) for j in range(i) if punctual.collide(ball, ball, inverse[i] @ poses[j])
    }
    assert said == {tuple(sorted(pair)) for pair in meet} and len(meet) > 10


def test_filters_and_importance(ball):
    scene = punctual.Scene()
    scene.insert(ball, groups=1, mask=2)
    scene.insert(ball, groups=1, mask=2)
    scene.insert(ball, groups=2, mask=1, importance=2.0)
    assert len(scene.step().verdict) == 2
    with pytest.raises(ValueError, match="importance is not a number"):
        scene.insert(ball, importance=float("nan"))


def test_faults(ball, ring):
    scene = punctual.Scene()
    name = scene.insert(ball)
    with pytest.raises(ValueError, match="1 bodies, but 2 poses"):
        scene.set_poses([name], np.tile(np.eye(4), (2, 1, 1)))
    with pytest.raises(ValueError, match="pose 0: matrix is off a rotation"):
        scene.set_poses([name], np.diag([2.0, 1, 1, 1])[None])
    for call in (lambda: scene.remove(7), lambda: scene.set_pose(7, np.eye(4)), lambda: scene.set_tree(7, ring)):
        with pytest.raises(KeyError, match="body 7 .* is not in the scene"):
            call()
    scene.set_tree(name, ring)
    scene.remove(name)
    with pytest.raises(KeyError):
        scene.set_poses([name], [np.eye(4)])
