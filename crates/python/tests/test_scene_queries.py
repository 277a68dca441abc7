"""Questions about a scene between frames: many rays, shapes on their way, overlaps, the closest body; names and groups."""

import numpy as np
import punctual3d
import pytest
from conftest import random_poses


@pytest.fixture(scope="module")
def crowd(ball, ring):
    """A scene of balls, of group 1, and rings, of group 2, and what is in it: names, trees and poses."""
    scene, poses = punctual3d.Scene(), random_poses(24, 8.0, seed=9)
    bodies = [(tree, T, groups) for T, (tree, groups) in zip(poses, [(ball, 1), (ring, 2)] * 12)]
    named = {scene.insert(tree, T, groups=groups): (tree, T) for tree, T, groups in bodies}
    scene.step()
    return scene, named


def test_many_rays_hit_what_single_rays_hit(crowd):
    scene, _ = crowd
    random = np.random.default_rng(11)
    origins = random.normal(scale=8.0, size=(200, 3))
    directions = random.normal(scale=4.0, size=(200, 3)) - origins
    hits = scene.cast_rays(origins, directions)
    assert hits.stop == "finished" and hits.done.all() and len(hits) == 200 and hits.elapsed is None
    for row in range(200):
        alone = scene.cast(origins[row], directions[row])
        if len(alone):
            assert (hits.t[row], hits.bodies[row]) == (alone.t[0], alone.bodies[0])
            assert (hits.triangles[row], hits.sides[row]) == (alone.triangles[0], alone.sides[0])
        else:
            assert (hits.t[row], hits.bodies[row], hits.triangles[row]) == (np.inf, 2**64 - 1, -1)
        assert hits.free_until[row] == alone.free_until
    cut = scene.cast_rays(origins, directions, work=hits.work // 2)
    assert cut.stop == "work-limit" and cut.work <= hits.work // 2
    done = int(cut.done.sum())
    assert 0 < done < 200 and cut.done[:done].all() and (cut.t[:done] == hits.t[:done]).all()
    assert np.isnan(cut.t[done + 1 :]).all() and (cut.free_until <= hits.free_until).all()
    assert scene.cast_rays(origins, directions, budget=10.0).elapsed > 0
    threaded = punctual3d.Scene(threads=2)
    threaded.insert(punctual3d.shapes.icosphere(3))
    assert threaded.cast_rays(origins, -origins, mode="any").triangles.min() >= 0
    assert len(scene.cast_rays(np.empty((0, 3)), [0, 0, 1.0])) == 0


def test_a_shape_meets_first_what_it_meets_alone(crowd):
    scene, named = crowd
    tool = punctual3d.shapes.cuboid([0.3, 0.5, 0.4], 2)
    random, met = np.random.default_rng(12), 0
    for pose in random_poses(20, 9.0, seed=13):
        velocity = random.normal(scale=6.0, size=3)
        cast = scene.cast_shape(tool, pose, velocity=velocity)
        times = []
        for body, (tree, T) in named.items():
            there = np.linalg.inv(T)
            alone = punctual3d.motion(tree, tool, there @ pose, velocity=there[:3, :3] @ velocity)
            times.append((np.inf if alone.touching_at is None else alone.touching_at, body))
        first, body = min(times)
        assert cast.stop == "finished" and cast.free_until <= min(first + 1e-9, 1.0)
        if first == np.inf:
            assert (cast.touching_at, cast.body, cast.free_until) == (None, None, 1.0)
        else:
            assert cast.touching_at == pytest.approx(first, abs=1e-5) and cast.body == body
            if first > 0:
                assert np.linalg.norm(cast.normal) == pytest.approx(1) and cast.normal @ velocity < 0
                assert np.linalg.norm(cast.points[0] - cast.points[1]) < 1e-3
                met += 1
        stopped = scene.cast_shape(tool, pose, velocity=velocity, work=5_000)
        assert stopped.free_until <= min(first, 1.0) and stopped.work <= 5_000
        screw = scene.cast_shape(tool, pose, to=random_poses(1, 9.0, seed=14)[0])
        assert screw.free_until <= (screw.touching_at or 1.0)
    assert met > 4


def test_overlaps_and_the_closest_body_are_those_of_single_queries(crowd):
    scene, named = crowd
    tool = punctual3d.shapes.icosphere(2)
    seen = 0
    for pose in random_poses(30, 9.0, seed=15):
        there = {body: np.linalg.inv(T) @ pose for body, (_, T) in named.items()}
        expected = [body for body, (tree, _) in named.items() if punctual3d.collide(tree, tool, there[body])]
        found = scene.overlap(tool, pose)
        assert found.bodies.tolist() == sorted(expected) and found.whole and (found.verdicts == 1).all()
        assert found.witnesses.shape == (len(expected), 2) and len(found.undecided) == 0
        assert len(scene.overlap(tool, pose, mode="any")) == min(len(expected), 1)
        seen += len(expected)
        nearest = min((punctual3d.distance(tree, tool, there[body]).high, body) for body, (tree, _) in named.items())
        closest = scene.closest(tool, pose)
        assert closest.low <= nearest[0] + 1e-12 and closest.high == pytest.approx(nearest[0], abs=1e-4)
        if nearest[0] > 0:
            assert closest.body == nearest[1]
            assert np.linalg.norm(closest.points[0] - closest.points[1]) == pytest.approx(closest.high)
        far = scene.closest(tool, pose, within=nearest[0] / 2 if nearest[0] else 0.0, work=10**7)
        assert (far.body is None) == (nearest[0] > 0) and far.low <= nearest[0]
    assert seen > 5
    some = scene.overlap([0, 0, 0], margin=8.0, work=5_000)
    assert some.stop == "work-limit" and len(some) + len(some.undecided) > 0


def test_points_are_balls_with_a_margin():
    scene = punctual3d.Scene()
    box = scene.insert(punctual3d.shapes.cuboid([1, 1, 1], 2))
    assert scene.closest([4, 0, 0]).high == pytest.approx(3.0)
    assert scene.closest((4, 0, 0), margin=1.0).high == pytest.approx(2.0)
    assert scene.overlap(np.array([2.5, 0, 0]), margin=1.6).bodies.tolist() == [box]
    fall = scene.cast_shape([0.2, 0.1, 5.0], velocity=[0, 0, -10.0], margin=1.0)
    assert fall.touching_at == pytest.approx(0.3, abs=1e-5) and fall.normal.tolist() == pytest.approx([0, 0, 1])
    assert len(scene.overlap([0, 0, 0], body=box)) == 0, "a body does not see itself"


@pytest.mark.parametrize(
    "call, text",
    [
        (lambda scene: scene.cast_rays([[0, 0, 0]], [[0, 0, 0]]), "ray 0: "),
        (lambda scene: scene.cast_rays([[0, 0, 0]], [[0, 0, 1]], mode="all"), "mode: "),
        (lambda scene: scene.cast_shape([0, 0, 0], np.eye(4), velocity=[1, 0, 0]), "T: not together with a point"),
        (lambda scene: scene.cast_shape([0, 0, 0], turn=[1, 0, 0]), "not together with a point"),
        (lambda scene: scene.cast_shape([0, 0, 0]), "no motion"),
        (lambda scene: scene.closest([0, 0, 0], within=-1.0), "within"),
        (lambda scene: scene.overlap([0, 0, 0], margin=np.nan), "the shape: its margin"),
        (lambda scene: scene.overlap([np.nan, 0, 0]), "finite|NaN|nan"),
    ],
)
def test_bad_numbers_are_refused(call, text):
    scene = punctual3d.Scene()
    with pytest.raises(ValueError, match=text):
        call(scene)


def test_named_groups_ignore_each_other_and_names_are_in_messages(ball):
    scene = punctual3d.Scene()
    bodies = [scene.insert(ball) for _ in range(3)]
    for body, group in zip(bodies, ["arm", "arm", "cable"]):
        scene.set_group(body, group)
    assert len(scene.step().bodies) == 3
    scene.ignore_groups("arm", "cable")
    assert scene.step().bodies.tolist() == [bodies[:2]]
    scene.ignore_groups("arm", "cable", False)
    scene.set_group(bodies[0], None)
    assert len(scene.step().bodies) == 3
    scene.set_name(bodies[1], "lamp")
    assert [scene.name(body) for body in bodies] == ["", "lamp", ""]
    with pytest.raises(ValueError, match=r"lamp \(body 1 "):
        scene.set_margin(bodies[1], -1.0)
    scene.step()
    unnamed = scene.view().html
    scene.set_name(bodies[1], "torch")
    assert scene.view().html != unnamed
    with pytest.raises(KeyError, match="not in the scene"):
        scene.set_name(99, "nobody")
    with pytest.raises(KeyError, match="not in the scene"):
        scene.closest([0, 0, 0], body=99)
