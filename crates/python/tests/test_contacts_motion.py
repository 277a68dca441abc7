"""Contacts and motions: the same as other questions say, and as geometry says."""

import numpy as np
import punctual3d
import pytest


def moved(x, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = [x, y, z]
    return pose


def test_contacts_without_a_margin_are_the_pairs_that_meet(ball, ring, touching):
    found = punctual3d.contacts(ball, ring, touching)
    pairs = punctual3d.collide(ball, ring, touching, mode="all").pairs
    assert found.stop == "finished" and found.low == np.inf and len(found) == len(pairs) > 50
    assert np.array_equal(np.unique(found.triangles, axis=0), np.unique(pairs, axis=0))
    assert (found.distances == 0).all() and np.isfinite(found.segments).all()
    assert np.allclose(found.points, found.segments.mean(axis=1, keepdims=True))
    assert np.allclose(np.linalg.norm(found.normals, axis=1), 1)
    of_a, of_b = found.face_normals.swapaxes(0, 1)
    parting = (of_b - of_a) / np.linalg.norm(of_b - of_a, axis=1, keepdims=True)
    assert np.allclose(parting, found.normals)


def test_contacts_within_a_margin(ball, ring):
    pose = moved(0.45)
    near = punctual3d.distance(ball, ring, pose)
    found = punctual3d.contacts(ball, ring, pose, margin=near.high + 0.02)
    assert near.low > 0 and len(found) > 4 and found.points.shape == (len(found), 2, 3)
    assert (np.diff(found.distances) >= 0).all() and found.distances[0] == pytest.approx(near.high, abs=1e-6)
    assert found.distances[-1] <= near.high + 0.02 and np.isnan(found.segments).all()
    between = found.points[:, 0] - found.points[:, 1]
    assert np.allclose(between, found.normals * found.distances[:, None], atol=1e-12)
    empty = punctual3d.contacts(ball, ring, pose)
    assert len(empty) == 0 and empty.triangles.shape == (0, 2) and empty.points.shape == (0, 2, 3)


def test_stopped_contacts_are_a_part_and_say_what_is_missing(ball, ring, touching):
    whole = punctual3d.contacts(ball, ring, touching, margin=0.05)
    every = {tuple(pair): distance for pair, distance in zip(whole.triangles.tolist(), whole.distances)}
    for options in ({"work": 20_000}, {"limit": 7}, {"budget": 0.0}):
        part = punctual3d.contacts(ball, ring, touching, margin=0.05, **options)
        known = {tuple(pair) for pair in part.triangles.tolist()}
        assert part.stop in ("work-limit", "pairs-full", "deadline") and known < set(every)
        assert all(every[pair] >= part.low for pair in set(every) - known)
    assert len(punctual3d.contacts(ball, ring, touching, limit=7)) == 7


def test_more_contacts_than_a_workspace_holds(ball):
    found = punctual3d.contacts(ball, ball, margin=0.2)
    assert found.stop == "finished" and len(found) > 10_000
    assert len(np.unique(found.triangles, axis=0)) == len(found) and (np.diff(found.distances) >= 0).all()


def test_manifolds_of_a_crate_in_a_floor():
    floor = punctual3d.shapes.cuboid([5.0, 5.0, 1.0], 1)
    crate = punctual3d.shapes.cuboid([1.0, 1.0, 1.0], 3)
    memory = punctual3d.Memory()
    first = None
    for height, distance in ((2.005, 0.005), (1.999, -0.001), (1.75, -0.25)):
        found = punctual3d.manifolds(floor, crate, moved(0.5, 0.25, height), skin=0.01, memory=memory)
        assert found.stop == "finished" and found.low == np.inf and found.count == 1 and len(found) == 4
        assert np.allclose(found.normals, [0, 0, -1]) and np.allclose(found.distances, distance)
        between = found.points[:, 0] - found.points[:, 1]
        assert np.allclose(between, found.normals * found.distances[:, None])
        assert (found.is_overlap == (distance < 0)).all() and np.allclose(found.areas, 4)
        first = set(found.ids) if first is None else first
        assert set(found.ids) == first and len(set(found.manifolds)) == 1
    assert len(punctual3d.overlap(floor, crate, moved(0.5, 0.25, 2.005))) == 0
    sunk = punctual3d.overlap(floor, crate, moved(0.5, 0.25, 1.75))
    assert len(sunk) == 4 and sunk.is_overlap.all() and "1 of 4 points" in repr(sunk)
    stopped = punctual3d.manifolds(floor, crate, moved(0.5, 0.25, 1.75), work=1)
    assert stopped.stop == "work-limit" and stopped.low == 0
    for skin in (-1.0, np.nan):
        with pytest.raises(ValueError, match="skin"):
            punctual3d.manifolds(floor, crate, skin=skin)


def test_a_straight_motion_ends_at_the_wall():
    ball = punctual3d.shapes.icosphere(4)
    wall = punctual3d.shapes.cuboid([0.5, 10.0, 10.0], 1)
    passage = punctual3d.motion(ball, wall, moved(6.5), velocity=[-10.0, 0.0, 0.0])
    # 5 lie between the ball of radius 1 and the face of the wall.
    assert passage.free_until <= passage.touching_at and passage.free_until == pytest.approx(0.5, abs=1e-3)
    assert passage.stop == "finished" and len(passage.triangles) == 2
    pose = moved(6.5 - 10.0 * passage.touching_at)
    assert bool(punctual3d.collide(ball, wall, pose))
    free = punctual3d.motion(ball, wall, moved(6.5), velocity=np.array([-4.0, 0.0, 0.0]))
    assert (free.free_until, free.touching_at, free.triangles) == (1.0, None, None)
    bullet = punctual3d.motion(ball, wall, moved(6.5), to=moved(-6.5e3))
    assert bullet.touching_at == pytest.approx(5 / 6506.5, rel=1e-3)


def test_a_turn_about_a_point():
    post = punctual3d.shapes.cuboid([0.1, 0.1, 1.0], 1)
    ball = punctual3d.shapes.icosphere(3)
    # A ball at the end of an arm of length 10 goes a quarter round, and meets the post on its way.
    angle = np.pi / 4
    at = [10 * np.cos(angle), 10 * np.sin(angle), 0.0]
    start = moved(10.0 - at[0], -at[1])
    turn = [0.0, 0.0, np.pi / 2]
    centre = [-at[0], -at[1], 0.0]
    passage = punctual3d.motion(post, ball, start, turn=turn, point=centre)
    assert 0.3 < passage.free_until < 0.5 and passage.touching_at - passage.free_until < 1e-3
    still = punctual3d.motion(post, ball, moved(0.5), velocity=[1.0, 0.0, 0.0])
    assert (still.free_until, still.touching_at) == (0.0, 0.0)


def test_memory_and_budgets_of_motions(ball, ring):
    memory = punctual3d.Memory()
    whole = punctual3d.motion(ball, ring, velocity=[2.0, 0.1, 0.0], memory=memory)
    warm = punctual3d.motion(ball, ring, velocity=[2.0, 0.1, 0.0], memory=memory)
    assert abs(warm.free_until - whole.free_until) < 1e-5 and warm.work < whole.work
    stopped = punctual3d.motion(ball, ring, velocity=[2.0, 0.1, 0.0], work=100)
    assert stopped.stop == "work-limit" and stopped.free_until <= whole.touching_at


def test_a_motion_is_predicted_resumed_and_asked_for_what_is_left(ball, ring):
    query = punctual3d.MotionQuery(ball, ring, velocity=[2.0, 0.1, 0.0], turn=[0.0, 0.3, 0.0])
    for error in (query.certificate, query.resume):
        with pytest.raises(punctual3d.ResumeError):
            error()
    whole = punctual3d.motion(ball, ring, velocity=[2.0, 0.1, 0.0], turn=[0.0, 0.3, 0.0], work=10**9)
    predicted = query.predict()
    assert 0 < predicted.p10 <= predicted.p50 <= predicted.p90 and predicted.p10 / 20 < whole.work < 20 * predicted.p90
    passage = query.run(work=300)
    stops = 0
    while passage.stop == "work-limit":
        stops += 1
        for left in (passage.remaining.work, passage.remaining.time):
            assert 0 < left.p10 <= left.p50 <= left.p90
        assert query.certificate().open_pairs > 0 and passage.free_until <= whole.touching_at
        assert query.certificate().boxes.shape[1:] == (2, 3)
        free = passage.free_until
        passage = query.resume(work=600)
        assert passage.free_until >= free
    assert stops > 2 and query.certificate().open_pairs == 0 and passage.remaining is None
    assert (passage.free_until, passage.touching_at) == (whole.free_until, whole.touching_at)
    assert passage.work == whole.work and "<html" in passage.view().html
    with pytest.raises(punctual3d.ResumeError):
        query.resume()
    memory = punctual3d.Memory()
    query.run(memory=memory)
    assert query.predict(memory=memory).p50 != predicted.p50
    with pytest.raises(ValueError, match="one of to, velocity and turn"):
        punctual3d.MotionQuery(ball, ring)


@pytest.mark.parametrize(
    "options, text",
    [
        ({}, "one of to, velocity and turn"),
        ({"to": np.eye(4), "velocity": [1, 0, 0]}, "not together"),
        ({"velocity": [1, 0, 0], "point": [0, 0, 0]}, "only together with turn"),
        ({"velocity": [1, 0, np.nan]}, "not finite"),
        ({"velocity": [1, 0, 0], "tolerance": -1.0}, "tolerance is -1"),
        ({"velocity": [1, 0, 0], "time_tolerance": np.inf}, "time_tolerance is inf"),
        ({"velocity": [1, 0, 0], "margins": [0.0, np.nan]}, r"margins\[1\] is NaN"),
        ({"to": np.zeros((4, 4))}, "T: "),
    ],
)
def test_errors_of_motions(ball, ring, options, text):
    with pytest.raises(ValueError, match=text):
        punctual3d.motion(ball, ring, **options)


def test_errors_of_contacts(ball, ring):
    for options, text in [({"margin": -1.0}, "margin is -1"), ({"margin": np.nan}, "margin is NaN"), ({"limit": 0}, "limit")]:
        with pytest.raises(ValueError, match=text):
            punctual3d.contacts(ball, ring, **options)
