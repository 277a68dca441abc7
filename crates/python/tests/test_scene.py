"""Many bodies, one budget a frame."""

import numpy as np
import punctual3d
import pytest
from conftest import random_poses


def placed(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def test_frames(ball, ring):
    scene = punctual3d.Scene(mode="all")
    ring_id, ball_id = scene.insert(ring, fixed=True), scene.insert(ball, placed(1.0))
    report = scene.step()
    assert report.frame == 1 and report.bodies.tolist() == [[ring_id, ball_id]]
    assert report.verdict.tolist() == [1] and report.age.tolist() == [0] and report.probability.tolist() == [1.0]
    pair = punctual3d.collide(ring, ball, placed(1.0), mode="all")
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
    scene = punctual3d.Scene()
    names = [scene.insert(ball) for _ in poses]
    scene.set_poses(names, poses)
    report = scene.step()
    said = {tuple(pair) for pair in report.bodies[report.verdict == 1].tolist()}
    inverse = np.linalg.inv(poses)
    meet = {
        (names[i], names[j]) for i in range(30) for j in range(i) if punctual3d.collide(ball, ball, inverse[i] @ poses[j])
    }
    assert said == {tuple(sorted(pair)) for pair in meet} and len(meet) > 10


def test_any_number_of_threads_says_the_same(ball):
    poses = random_poses(40, 5.0)
    reports = []
    for threads in (1, 2, 3):
        scene = punctual3d.Scene(mode="all", threads=threads)
        scene.set_poses([scene.insert(ball) for _ in poses], poses)
        reports.append([scene.step(work=200_000) for _ in range(3)])
    for one, other in zip(reports[0] * 2, reports[1] + reports[2]):
        assert one.work == other.work and (one.verdict >= 0).any()
        for column in ("bodies", "verdict", "witness", "found", "probability", "age"):
            assert np.array_equal(getattr(one, column), getattr(other, column))
    with pytest.raises(ValueError, match="threads is 0, expected at least 1"):
        punctual3d.Scene(threads=0)


def test_filters_and_importance(ball):
    scene = punctual3d.Scene()
    scene.insert(ball, groups=1, mask=2)
    scene.insert(ball, groups=1, mask=2)
    scene.insert(ball, groups=2, mask=1, importance=2.0)
    assert len(scene.step().verdict) == 2
    with pytest.raises(ValueError, match="importance is not a number"):
        scene.insert(ball, importance=float("nan"))


def test_faults(ball, ring):
    scene = punctual3d.Scene()
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


def test_contacts_begin_and_end(ball):
    scene = punctual3d.Scene()
    still, other = scene.insert(ball, fixed=True), scene.insert(ball, placed(1.9))
    assert len(scene.step().contacts) == 0
    scene.track_contacts()
    told = []
    for x, work in [(1.9, None), (1.8, None), (1.85, 0), (2.5, None), (2.5, None)]:
        scene.set_pose(other, placed(x))
        report = scene.step(work=work)
        told += [(report.frame, *told) for told in zip(report.contacts.phases, report.contacts.ages.tolist())]
        assert report.contacts.bodies.tolist() == [[still, other]] * len(report.contacts)
    assert told == [(2, "began", 0), (3, "persists", 1), (4, "undecided", 2), (5, "ended", 3)]


def test_margins(ball):
    pair = punctual3d.distance(ball, ball, placed(2.5), absolute_tolerance=1e-9)
    scene = punctual3d.Scene()
    still, _ = scene.insert(ball, margin=0.25), scene.insert(ball, placed(2.5))
    assert (scene.step().verdict == 1).sum() == 0
    scene.set_margin(still, pair.low - 1e-6)
    assert (scene.step().verdict == 1).sum() == 0
    scene.set_margin(still, pair.high + 1e-6)
    assert scene.step().verdict.tolist() == [2]


def test_distances_are_those_of_single_queries(ball, ring):
    poses = random_poses(12, 6.0, seed=3)
    trees, margins = [ball, ring] * 6, [0.0, 0.1, 0.2] * 4
    scene = punctual3d.Scene()
    names = [scene.insert(tree, T, margin=margin) for tree, T, margin in zip(trees, poses, margins)]
    asked = [(i, j) for i in range(12) for j in range(i + 1, 12) if (i + j) % 3]
    for i, j in asked:
        scene.measure(names[j], names[i], 1e-4)
    found = scene.step().distances
    assert found.bodies.tolist() == [[names[i], names[j]] for i, j in asked] and len(found) == len(asked)
    apart = 0
    for row, (i, j) in enumerate(asked):
        T, of_both = np.linalg.inv(poses[i]) @ poses[j], (margins[i], margins[j])
        single = punctual3d.distance(trees[i], trees[j], T, absolute_tolerance=1e-4, margins=of_both)
        assert found.high[row] - found.low[row] < 1.001e-4 and found.ages[row] == 0
        assert found.low[row] <= single.high + 1e-9 and single.low <= found.high[row] + 1e-9
        if found.high[row] > 0:
            at = [trees[k].vertices[trees[k].faces[t]] for k, t in zip((i, j), found.triangles[row])]
            at = punctual3d.distance(*(punctual3d.Tree(corners, [[0, 1, 2]]) for corners in at), T, margins=of_both)
            assert at.high == pytest.approx(found.high[row], rel=1e-5, abs=1e-5)
            apart += 1
    assert 10 < apart < len(asked)
    # In a frame that measures nothing the bounds stay, and are a frame older; of a new pair nothing is known.
    scene.set_poses(names, random_poses(12, 6.0, seed=4))
    new = scene.insert(ball)
    scene.measure(names[0], new, 0.0)
    later = scene.step(work=0).distances
    known = later.bodies[:, 1] != new
    assert np.array_equal(later.low[known], found.low) and (later.ages[known] == 1).all()
    row = [column[~known].tolist() for column in (later.low, later.high, later.triangles)]
    assert row == [[0.0], [np.inf], [[-1, -1]]]
    for body in scene.step().distances.bodies.tolist():
        scene.stop_measuring(*body)
    assert len(scene.step().distances) == 0


def test_within_margins_is_another_word(ball):
    scene = punctual3d.Scene()
    a, b = scene.insert(ball, margin=0.1), scene.insert(ball, placed(2.05))
    report = scene.step()
    assert (report.verdict.tolist(), report.probability.tolist(), report.found.tolist()) == ([2], [1.0], [1])
    at = [ball.vertices[ball.faces[triangle]] for triangle in report.witness[0]]
    alone = punctual3d.distance(*(punctual3d.Tree(corners, [[0, 1, 2]]) for corners in at), placed(2.05))
    assert report.witness_distance[0] == pytest.approx(alone.high, rel=1e-9) and 0.0 < alone.high <= 0.1
    scene.set_pose(b, placed(1.5))
    report = scene.step()
    assert report.verdict[0] > 0 and (report.verdict[0] == 1) == (report.witness_distance[0] == 0.0)
    scene.set_margin(a, 0.0)
    report = scene.step()
    assert (report.verdict.tolist(), report.witness_distance.tolist()) == ([1], [0.0])
    scene.set_pose(b, placed(2.05))
    report = scene.step()
    assert (report.verdict.tolist(), report.witness_distance.tolist()) in (([0], [np.inf]), ([], []))


def test_the_distance_within_a_group(ball):
    scene = punctual3d.Scene()
    links = [scene.insert(ball, placed(x)) for x in (0.0, 3.0, 7.0)]
    scene.measure_groups(links, links, 1e-3)
    found = scene.step().group_distances
    assert found.bodies == [(links[0], links[1])] and 0.99 < found.low[0] <= found.high[0] < 1.01
    with pytest.raises(ValueError, match="no distance from itself"):
        scene.measure_groups(links[:1], links[:1], 1e-3)
    with pytest.raises(KeyError, match="measure 7 is not asked for"):
        scene.stop_measuring_groups(7)


def test_a_refused_call_leaves_the_last_report(ball):
    scene = punctual3d.Scene()
    a, b = scene.insert(ball), scene.insert(ball, placed(1.0))
    scene.step()
    far = placed(2.0**995)
    for call in (
        lambda: scene.remove(99),
        lambda: scene.set_pose(99, np.eye(4)),
        lambda: scene.set_poses([a, 99], [placed(5.0), placed(6.0)]),
        lambda: scene.set_poses([a, b], [placed(5.0), far]),
        lambda: scene.insert(ball, far),
        lambda: scene.set_margin(a, -1.0),
    ):
        with pytest.raises((KeyError, ValueError)):
            call()
    scene.view()
    assert scene.step().verdict.tolist() == [1]


def test_passages_are_those_of_single_queries(ball, ring):
    starts, ends = random_poses(20, 4.0, seed=5), random_poses(20, 4.0, seed=6)
    random = np.random.default_rng(7)
    here = random_poses(1, 2.0, seed=8)[0]
    scene, there = punctual3d.Scene(), np.linalg.inv(here)
    still = scene.insert(ring, here, fixed=True)
    single = {}
    for i, (start, end) in enumerate(zip(starts, ends)):
        body = scene.insert(ball, placed(100.0), groups=2, mask=1)
        velocity, turn, point = random.normal(scale=3.0, size=(3, 3))
        turned, local = there[:3, :3], {}
        if i % 2:
            scene.set_motion(body, start, to=end)
            local = {"to": there @ end}
        elif i % 4:
            scene.set_motion(body, start, velocity=velocity)
            local = {"velocity": turned @ velocity}
        else:
            scene.set_motion(body, start, velocity=velocity, turn=turn, point=point)
            local = {"velocity": turned @ velocity, "turn": turned @ turn, "point": turned @ point + there[:3, 3]}
        single[body] = punctual3d.motion(ring, ball, there @ start, **local)
    passages = scene.step().passages
    assert (passages.bodies[:, 0] == still).all() and passages.triangles.dtype == np.int64
    rows = {body: row for row, (_, body) in enumerate(passages.bodies.tolist())}
    met = 0
    for body, alone in single.items():
        free, touching = 1.0, np.nan
        if body in rows:
            free, touching = passages.free_until[rows[body]], passages.touching_at[rows[body]]
            assert (passages.triangles[rows[body]] >= 0).all() == (not np.isnan(touching))
        assert np.isnan(touching) == (alone.touching_at is None)
        if alone.touching_at is None:
            assert (free, alone.free_until) == (1.0, 1.0)
        else:
            assert free <= alone.touching_at + 1e-9 and alone.free_until <= touching + 1e-9
            met += 1
    assert 3 < met < 20 and len(passages) == len(rows)
    scene.set_pose(body, starts[-1])
    assert len(scene.step().passages) == len(passages) - (body in rows)
    # A frame without work says nothing.
    cut = punctual3d.Scene()
    cut.insert(ring)
    cut.set_motion(cut.insert(ball), placed(1.0), velocity=[1.0, 0.0, 0.0])
    passages = cut.step(work=0).passages
    assert (passages.free_until.tolist(), passages.triangles.tolist()) == ([0.0], [[-1, -1]])
    assert np.isnan(passages.touching_at).all()


@pytest.fixture(scope="module")
def crowd(ball, ring):
    """A scene of balls, of group 1, and rings, of group 2, and what is in it: names, trees and poses."""
    scene, poses = punctual3d.Scene(), random_poses(24, 8.0, seed=9)
    bodies = [(tree, T, groups) for T, (tree, groups) in zip(poses, [(ball, 1), (ring, 2)] * 12)]
    named = {scene.insert(tree, T, groups=groups): (tree, T) for tree, T, groups in bodies}
    scene.step()
    return scene, named


def one_by_one(named, origin, direction, limits):
    """All hits of a ray, of one body after the other: (t, body, triangle, side), ascending."""
    found = []
    for body, (tree, T) in named.items():
        there = np.linalg.inv(T)
        local = there[:3, :3] @ origin + there[:3, 3], there[:3, :3] @ direction
        hits = punctual3d.rays(tree, *([vector] for vector in local), mode="all", **limits)
        found += zip(hits.t.tolist(), [body] * len(hits), hits.triangles.tolist(), hits.sides.tolist())
    return sorted(found)


def test_casts_hit_what_single_rays_hit(crowd):
    scene, named = crowd
    random, hit = np.random.default_rng(10), 0
    for _ in range(60):
        origin = random.normal(scale=8.0, size=3)
        direction, limits = random.normal(scale=4.0, size=3) - origin, {"t_min": 0.1, "t_max": 3.0}
        expected = one_by_one(named, origin, direction, limits)
        cast = scene.cast(origin, direction, mode="all", **limits)
        assert (cast.stop, cast.found, len(cast), cast.free_until) == ("finished", len(expected), len(expected), np.inf)
        assert np.allclose(cast.t, [row[0] for row in expected], atol=1e-9) and (np.diff(cast.t) >= 0).all()
        rest = zip(cast.bodies.tolist(), cast.triangles.tolist(), cast.sides.tolist())
        assert sorted(rest) == sorted(row[1:] for row in expected)
        near, some = scene.cast(origin, direction, **limits), scene.cast(origin, direction, mode="any", **limits)
        assert len(near) == len(some) == min(len(expected), 1)
        if expected:
            assert (near.t[0], near.bodies[0], near.triangles[0]) == (cast.t[0], cast.bodies[0], cast.triangles[0])
            assert near.free_until == near.t[0] and some.t[0] in cast.t
            assert scene.cast(origin, direction, work=2_000, **limits).free_until <= near.t[0]
            hit += 1
        else:
            assert near.free_until == np.inf and near.t.shape == (0,)
        segment = scene.cast(origin, end=origin + direction, mode="all", t_min=0.1)
        short = cast.t[abs(cast.t - 1.0) > 1e-9]
        assert len(segment) >= (short < 1.0).sum() and (segment.t <= 1.0).all()
    assert 20 < hit < 60


def test_casts_ask_only_whom_they_may(crowd):
    scene, named = crowd
    names = list(named)
    line = {"origin": [-20.0, 0.1, 0.2], "end": [20.0, 0.3, 0.1], "mode": "all"}
    whole = scene.cast(**line)
    every = whole.bodies.tolist()
    balls, rings = (scene.cast(mask=mask, **line).bodies.tolist() for mask in (1, 2))
    assert set(balls) <= set(names[::2]) and set(rings) <= set(names[1::2])
    assert sorted(every) == sorted(balls + rings) and balls and rings
    stopped = scene.cast(**line, work=0)
    assert (stopped.stop, stopped.work, len(stopped)) == ("work-limit", 0, 0) and stopped.free_until <= whole.t[0]
    assert scene.cast(**line, budget=10.0).elapsed > 0


@pytest.mark.parametrize(
    "call, text",
    [
        (lambda scene, body: scene.set_margin(body, -1.0), "-1 is not a length"),
        (lambda scene, body: scene.measure(body, body, 1.0), "no distance from itself"),
        (lambda scene, body: scene.measure(body, body, np.nan), "NaN is not a length"),
        (lambda scene, body: scene.set_motion(body, np.eye(4)), "one of to, velocity and turn"),
        (lambda scene, body: scene.set_motion(body, np.eye(4), velocity=[1, np.inf, 0]), "not finite"),
        (lambda scene, body: scene.cast([0, 0, 0]), "direction and end: one of them"),
        (lambda scene, body: scene.cast([0, 0, 0], [0, 0, 1], end=[0, 0, 1]), "direction and end: one of them"),
        (lambda scene, body: scene.cast([0, 0, 0], [0, 0, 0]), "direction"),
        (lambda scene, body: scene.cast([0, 0, 0], [0, 0, 1], t_max=np.nan), "t_max is NaN"),
        (lambda scene, body: scene.cast([0, 0, 0], [0, 0, 1], mode="first"), "mode: "),
        (lambda scene, body: scene.cast([0, 0, 0], [0, 0, 1], work=1, budget=1.0), "only one of them"),
    ],
)
def test_what_a_scene_refuses(ball, call, text):
    scene = punctual3d.Scene()
    with pytest.raises(ValueError, match=text):
        call(scene, scene.insert(ball))


def test_bodies_that_are_not_in_the_scene(ball):
    scene = punctual3d.Scene()
    name = scene.insert(ball)
    for call in (
        lambda: scene.set_margin(7, 0.0),
        lambda: scene.measure(name, 7, 0.0),
        lambda: scene.stop_measuring(7, name),
        lambda: scene.set_motion(7, np.eye(4), velocity=[1.0, 0.0, 0.0]),
    ):
        with pytest.raises(KeyError, match="body 7 .* is not in the scene"):
            call()


def test_compounds_move_as_one(ball, ring):
    scene = punctual3d.Scene()
    post = scene.insert(ball, fixed=True)
    compound = scene.insert_compound([(ball, placed(0.0)), (ring, placed(0.5)), (ball, placed(1.0))], placed(20.0))
    parts = scene.parts(compound)
    assert len(parts) == 3 and len(scene) == 4 and len(scene.step().verdict) == 0, "parts never meet"
    assert scene.compound_of(parts[1]) == compound and scene.compound_of(post) is None
    scene.set_compound_pose(compound, placed(-1.2))
    report = scene.step()
    assert [post, parts[2]] in report.bodies[report.verdict == 1].tolist()
    scene.set_compound_motion(compound, placed(30.0), velocity=[-30.0, 0.0, 0.0])
    passages = scene.step().passages
    assert len(passages) > 0 and (passages.touching_at > 0.5).any()
    with pytest.raises(ValueError, match="rotation"):
        scene.insert_compound([(ball, placed(0.0)), (ball, np.diag([2.0, 2.0, 2.0, 1.0]))])
    scene.remove_compound(compound)
    assert len(scene) == 1
    with pytest.raises(KeyError, match="compound 0 is not in the scene"):
        scene.set_compound_pose(compound, placed(0.0))


def test_groups_are_as_far_apart_as_their_closest_bodies(ball):
    poses = random_poses(14, 8.0)
    scene = punctual3d.Scene()
    names = [scene.insert(ball) for _ in poses]
    x, y = names[:4], names[4:]
    measure = scene.measure_groups(x, y, 1e-3)
    inverse = np.linalg.inv(poses)
    pairs = [(i, j) for i in range(4) for j in range(4, 14)]
    truth = min(punctual3d.distance(ball, ball, inverse[i] @ poses[j]).high for i, j in pairs)
    scene.set_poses(names, poses)
    for work in (100, 2_000, 20_000, None):
        found = scene.step(work=work).group_distances
        assert found.ids.tolist() == [measure] and len(found) == 1
        assert found.low[0] <= truth + 1e-6 and found.high[0] >= truth - 1e-6
    assert found.open.tolist() == [0] and found.high[0] - found.low[0] < 1.1e-3
    assert (found.bodies[0][0] in x) != (found.bodies[0][1] in x) and found.triangles[0, 0] >= 0
    scene.stop_measuring_groups(measure)
    assert len(scene.step().group_distances) == 0


def test_a_sensor_and_an_ignored_pair(ball):
    scene = punctual3d.Scene()
    scene.find_contacts()
    a, b = scene.insert(ball, fixed=True, sensor=True), scene.insert(ball, placed(1.0))
    assert scene.step().verdict[0] == 1 and len(scene.contact_points(a, b)) == 0
    scene.ignore(b, a)
    assert len(scene.step().verdict) == 0
    scene.ignore(b, a, False)
    assert scene.step().verdict[0] == 1


def test_contacts_between_groups(ball):
    scene = punctual3d.Scene()
    at = {1: 0.0, 2: 1.0, 4: -1.0}
    a, b, c = (scene.insert(ball, placed(x), groups=group) for group, x in at.items())
    scene.find_contacts(groups=2, mask=1)
    scene.step()
    assert len(scene.contact_points(a, b)) > 0 and len(scene.contact_points(a, c)) == 0
    scene.stop_finding_contacts(groups=2, mask=1)
    scene.set_pose(a, placed(0.01))
    scene.step()
    assert scene.contact_points(a, b).age == 1


def test_a_distance_and_a_motion_of_one_pair(ball):
    scene = punctual3d.Scene()
    a, b = scene.insert(ball, fixed=True), scene.insert(ball)
    scene.measure(a, b, 1e-3)
    scene.set_motion(b, placed(5.0), velocity=[-4.0, 0.0, 0.0])
    report = scene.step()
    assert report.verdict[0] == 0 and report.distances.low[0] > 2.9
    assert 0.7 < report.passages.free_until[0] <= report.passages.touching_at[0] < 0.8


def test_contact_points(ball):
    scene = punctual3d.Scene()
    a, b = scene.insert(ball, fixed=True, margin=0.01), scene.insert(ball, placed(1.0))
    scene.find_contacts(a, b)
    scene.set_question_importance("contacts", 1.0)
    meets = punctual3d.distance(ball, ball, placed(1.0)).high == 0
    scene.step()
    found = scene.contact_points(a, b)
    assert meets and len(found) > 0 and found.age == 0 == found.drift and found.distances[0] < 0
    assert found.points_a.shape == found.points_b.shape == found.normals.shape == (len(found), 3)
    assert np.allclose(np.linalg.norm(found.normals, axis=1), 1) and found.manifolds.shape == found.ids.shape == (len(found),)
    scene.set_pose(b, placed(50.0))
    scene.step()
    assert len(scene.contact_points(a, b)) == 0 and scene.contact_points(a, b).low > 40
    scene.stop_finding_contacts(a, b)
    scene.find_contacts()
    scene.stop_finding_contacts()
    with pytest.raises(ValueError, match="both bodies are needed"):
        scene.find_contacts(a)
    with pytest.raises(ValueError, match="colour"):
        scene.set_question_importance("colour", 1.0)


def test_a_contained_body_and_what_lies_ahead():
    box = punctual3d.shapes.cuboid([4, 4, 4], 2)
    room = punctual3d.Tree(box.vertices, box.faces, solid="keep")
    ball = punctual3d.shapes.icosphere(2)
    ball = punctual3d.Tree(ball.vertices, ball.faces, solid="keep")
    scene = punctual3d.Scene()
    scene.find_contacts()
    a, b = scene.insert(room, fixed=True), scene.insert(ball, margin=0.01)
    scene.step()
    found = scene.contact_points(a, b)
    assert found.within == b and found.low == 0 and len(found) == 0
    assert scene.may_move(b, 1.0, sink=0.1) == 0
    scene.set_pose(b, [[1, 0, 0, 5.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    scene.step()
    assert scene.contact_points(a, b).within is None and scene.contact_points(a, b).low > 0.4
    assert scene.may_move(b, 0.2) == 0.2 and 0.5 <= scene.may_move(b, 9.0, sink=0.1) <= 0.61
    with pytest.raises(KeyError, match="is not in the scene"):
        scene.may_move(b + 7, 1.0)
    scene.set_look_ahead(1.0)
    with pytest.raises(ValueError, match="look-ahead: -1 is not a length"):
        scene.set_look_ahead(-1.0)
