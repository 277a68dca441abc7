"""Answers of single queries: proven, stopped, resumed, remembered."""

import numpy as np
import punctual3d
import pytest


def test_verdicts_and_their_truth(ball, ring, touching):
    apart, meet = punctual3d.collide(ball, ring), punctual3d.collide(ball, ring, touching)
    assert (apart.verdict, bool(apart), apart.witness, apart.probability) == ("separated", False, None, 0.0)
    assert (meet.verdict, bool(meet), meet.stop, meet.found) == ("intersecting", True, "first-hit", 1)
    assert meet.pairs.tolist() == [list(meet.witness)]
    assert apart.pairs.shape == (0, 2) and apart.pairs.dtype == np.uint32


def test_undecided_has_no_truth_value(ball, ring, touching):
    stopped = punctual3d.collide(ball, ring, touching, work=0)
    assert stopped.verdict == "undecided" and stopped.stop == "work-limit"
    assert 0 < stopped.probability < 1 and stopped.remaining.work.p50 > 0
    with pytest.raises(punctual3d.UndecidedError, match="not known whether the surfaces meet: .*work-limit"):
        bool(stopped)


def test_budget_of_time(ball, ring, touching):
    stopped = punctual3d.collide(ball, ring, touching, mode="all", budget=0.0)
    assert stopped.stop == "deadline" and stopped.elapsed is not None and stopped.recall < 1
    whole = punctual3d.collide(ball, ring, touching, mode="all", budget=60.0)
    assert whole.stop == "finished" and whole.recall == 1.0
    endless = punctual3d.collide(ball, ring, touching, mode="all", budget=float("inf"))
    assert endless.elapsed is None and endless.found == whole.found


def test_pairs_are_those_of_all_triangles(touching):
    a, b = punctual3d.shapes.icosphere(1), punctual3d.shapes.torus(1.0, 0.4, 12)
    found = punctual3d.collide(a, b, touching, mode="all")
    single = [punctual3d.Tree(b.vertices[face] + [1.0, 0.0, 0.0], [[0, 1, 2]]) for face in b.faces]
    each = {(i, j) for j, tree in enumerate(single) for i, _ in punctual3d.collide(a, tree, mode="all").pairs.tolist()}
    assert {tuple(pair) for pair in found.pairs.tolist()} == each and len(each) > 20


def test_more_pairs_than_a_workspace_holds():
    # All 300 x 300 triangles share the middle.
    turn = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    rim = np.stack([np.cos(turn), np.sin(turn), np.cos(3 * turn)], axis=1)
    vertices = np.concatenate([[[0.0, 0.0, 0.0]], rim])
    fan = punctual3d.Tree(vertices, [[0, i + 1, (i + 1) % 300 + 1] for i in range(300)])
    found = punctual3d.collide(fan, fan, mode="all")
    assert found.stop == "finished" and found.found == 90_000
    assert len(np.unique(found.pairs, axis=0)) == 90_000
    stopped = punctual3d.collide(fan, fan, mode="all", work=found.work - 1000)
    assert stopped.stop == "work-limit" and 65_536 < len(stopped.pairs) < 90_000
    timed = punctual3d.collide(fan, fan, mode="all", budget=60.0)
    assert timed.found == 90_000


def test_a_resumed_query_ends_as_one_that_was_not_stopped(ball, ring, touching):
    query = punctual3d.Query(ball, ring, touching, mode="all")
    for error in (query.certificate, query.estimate, query.resume):
        with pytest.raises(punctual3d.ResumeError):
            error()
    predicted = query.predict().work
    assert 0 < predicted.p10 <= predicted.p50 <= predicted.p90
    result = query.run(work=300)
    assert result.stop == "work-limit"
    open_before = query.certificate()
    assert open_before.open_pairs > 0 and open_before.upper_bound > 0 and open_before.largest_extent > 0
    assert open_before.boxes.shape[1:] == (2, 3) and (open_before.boxes[:, 0] <= open_before.boxes[:, 1]).all()
    assert query.estimate().probability == result.probability
    while result.stop == "work-limit":
        result = query.resume(work=300)
    whole = punctual3d.collide(ball, ring, touching, mode="all", work=10**9)
    assert result.pairs.tolist() == whole.pairs.tolist() and result.work == whole.work
    assert query.certificate().upper_bound == whole.found and query.certificate().open_pairs == 0
    with pytest.raises(punctual3d.ResumeError, match="no run to go on with"):
        query.resume()


def test_unseen_intersections_lie_in_the_boxes(ball, ring, touching):
    query = punctual3d.Query(ball, ring, touching, mode="all")
    query.run(work=2000)
    found = {tuple(pair) for pair in query.run(work=2000).pairs.tolist()}
    certificate = query.certificate()
    assert certificate.upper_bound > len(found)
    boxes = certificate.boxes
    corners = ball.vertices[ball.faces]
    missed = [
        pair for pair in punctual3d.collide(ball, ring, touching, mode="all").pairs.tolist() if tuple(pair) not in found
    ]
    assert missed and len(missed) + len(found) <= certificate.upper_bound
    for triangle, _ in missed:
        low, high = corners[triangle].min(axis=0), corners[triangle].max(axis=0)
        assert ((boxes[:, 0] <= high) & (low <= boxes[:, 1])).all(axis=1).any()


def test_distance_and_its_bounds(ball, ring, touching):
    apart = punctual3d.distance(ball, ring)
    assert apart.low <= apart.high and apart.stop == "finished" and apart.high - apart.low < 1e-5
    a, b = apart.points
    assert np.linalg.norm(a - b) == pytest.approx(apart.high, rel=1e-12)
    assert len(apart.triangles) == 2 and apart.closer is None
    early = punctual3d.distance(ball, ring, work=600)
    assert early.stop == "work-limit" and early.low <= apart.high and apart.low <= early.high
    meet = punctual3d.distance(ball, ring, touching)
    assert meet.low == meet.high == 0.0 and np.array_equal(*meet.points)
    thick = punctual3d.distance(ball, ring, margins=[0.1, 0.2])
    assert thick.high == pytest.approx(apart.high - 0.3, abs=1e-5)
    rough = punctual3d.distance(ball, ring, relative_tolerance=0.5)
    assert rough.work < apart.work and rough.low <= apart.high <= rough.high
    with pytest.raises(TypeError, match="compare its bounds"):
        bool(apart)


def test_closer_than(ball, ring):
    length = punctual3d.distance(ball, ring).high
    assert punctual3d.closer_than(ball, ring, 1.1 * length)
    assert not punctual3d.closer_than(ball, ring, 0.9 * length)
    undecided = punctual3d.closer_than(ball, ring, 0.9 * length, work=0)
    assert undecided.closer is None
    with pytest.raises(punctual3d.UndecidedError, match="closer than 0.44"):
        bool(undecided)


def test_closer_points_lie_in_the_boxes(ball, ring):
    query = punctual3d.DistanceQuery(ball, ring, absolute_tolerance=0.0)
    result = query.run(work=3000)
    assert result.stop == "work-limit" and np.isfinite(result.high)
    certificate = query.certificate()
    near = punctual3d.contacts(ball, ring, margin=result.high * (1 - 1e-12))
    assert 0 < len(near) <= certificate.upper_bound
    for middle in near.points.mean(axis=1):
        assert ((certificate.boxes[:, 0] <= middle) & (middle <= certificate.boxes[:, 1])).all(axis=1).any()


def test_a_distance_query_is_resumed(ball, ring):
    query = punctual3d.DistanceQuery(ball, ring, absolute_tolerance=0.0)
    assert query.predict().p50 > 0
    result = query.run(work=600)
    low, high = result.low, result.high
    between = query.estimate().distance
    assert low <= between.p10 <= between.p90 <= high
    assert query.certificate().open_pairs > 0
    while result.stop == "work-limit":
        result = query.resume(work=600)
        assert low <= result.low and result.high <= high
        low, high = result.low, result.high
    whole = punctual3d.distance(ball, ring, absolute_tolerance=0.0)
    assert (low, high) == (whole.low, whole.high)
    with pytest.raises(punctual3d.ResumeError):
        query.resume()


def test_contact_can_be_left_open(ball, ring, touching):
    apart = punctual3d.distance(ball, ring, absolute_tolerance=100.0, leave_contact_open=True)
    assert apart.low == 0 and apart.high <= 100 and apart.work < punctual3d.distance(ball, ring).work
    query = punctual3d.DistanceQuery(ball, ring, touching, absolute_tolerance=1e-9, leave_contact_open=True)
    assert query.run().high <= 1e-9
    poses = np.stack([touching, np.eye(4)])
    batch = punctual3d.distance_batch(ball, ring, poses, absolute_tolerance=100.0, leave_contact_open=True)
    assert (batch.low == 0).all() and (batch.high <= 100).all()


def test_memory(ball, ring, touching):
    memory = punctual3d.Memory()
    assert memory.last_verdict is None
    first = punctual3d.collide(ball, ring, touching, memory=memory)
    again = punctual3d.collide(ball, ring, touching, memory=memory)
    assert memory.last_verdict is True and memory.frames_undecided == 0 and 0 <= memory.change_rate <= 1
    assert again.work < first.work and again
    lone = punctual3d.distance(ball, ring)
    punctual3d.distance(ball, ring, memory=memory)
    assert punctual3d.distance(ball, ring, memory=memory).high == lone.high


def test_much_is_found_early_and_priors(touching):
    a, b = punctual3d.shapes.icosphere(5), punctual3d.shapes.torus(2, 0.5, 128)
    turned = touching.copy()
    turned[:3, :3] = [[np.cos(0.3), 0, np.sin(0.3)], [0, 1, 0], [-np.sin(0.3), 0, np.cos(0.3)]]
    # Aligned: where edges of both meshes cross each other, curves cannot be followed.
    for pose, least in ((touching, 0.45), (turned, 0.8)):
        whole = punctual3d.collide(a, b, pose, mode="all")
        fifth = punctual3d.collide(a, b, pose, mode="all", work=whole.work // 5)
        assert fifth.stop == "work-limit" and fifth.found > least * whole.found
    likely, unlikely = (punctual3d.collide(a, b, touching, work=0, prior=prior).probability for prior in (0.9, 0.01))
    assert unlikely < likely
