"""Answers are pickled, copied, compared and told in a line."""

import copy
import multiprocessing
import pickle
import tempfile
from pathlib import Path

import numpy as np
import punctual3d
import pytest
from conftest import random_poses


def at(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def records():
    """One of each class, and some of each kind."""
    ball, ring = punctual3d.shapes.icosphere(3), punctual3d.shapes.torus(2.0, 0.5, 48)
    query = punctual3d.Query(ball, ring, at(1.0), mode="all")
    distance = punctual3d.DistanceQuery(ball, ring, absolute_tolerance=0.0)
    motion = punctual3d.MotionQuery(ball, ring, velocity=[2.0, 0.0, 0.0])
    nothing = punctual3d.Tree([], [])
    yield from [query.run(work=2000), query.estimate(), query.predict(), query.certificate()]
    yield from [distance.run(work=2000), distance.estimate(), distance.predict(), distance.certificate()]
    yield from [motion.run(), motion.run(work=50), motion.run(work=50).remaining, motion.certificate()]
    yield from [punctual3d.collide(ball, ring), punctual3d.collide(ball, ring, at(1.0), budget=10.0)]
    yield from [punctual3d.distance(nothing, ball), punctual3d.closer_than(ball, ring, 0.6)]
    yield from [punctual3d.contacts(ball, ring, at(1.0), margin=0.02), punctual3d.contacts(ball, ring)]
    yield from [punctual3d.manifolds(ball, ring, at(1.0), skin=0.02), punctual3d.manifolds(ball, ring)]
    yield from [punctual3d.penetration(ball, ring, at(1.0), work=work) for work in (100_000, 1)]
    origins = np.random.default_rng(2).normal(size=(50, 3)) * 2
    for mode in ("nearest", "all"):
        yield punctual3d.rays(ball, origins, [0.0, 0.0, 1.0], mode=mode)
    yield punctual3d.rays(ball, origins, [0.0, 0.0, 1.0], work=2000)
    poses = random_poses(40, 3.5)
    yield punctual3d.collide_batch(ball, ring, poses, mode="all", work=2000)
    yield punctual3d.distance_batch(ball, ring, poses, work=100)
    yield punctual3d.collide_batch(ball, ring, [])
    yield query.run(work=2000).view()
    scene = punctual3d.Scene()
    scene.track_contacts()
    scene.find_contacts()
    x, y = scene.insert(ball), scene.insert(ball, at(1.9))
    scene.measure(x, y, 1e-3)
    scene.measure_groups([x], [y], 1e-3)
    z = scene.insert(ring, at(9.0))
    scene.set_motion(z, at(9.0), velocity=[-9.0, 0.0, 0.0])
    report = scene.step()
    yield from [report, report.contacts, report.distances, report.group_distances, report.passages]
    yield from [scene.contact_points(x, y), scene.cast([9.0, 0.1, 0.2], [-1.0, 0.0, 0.0], mode="all")]
    yield from [scene.cast_shape([9.0, 9.0, 9.0], velocity=[-9.0, -9.0, -9.0]), scene.cast_rays(origins, [0, 0, 1.0])]
    yield from [scene.overlap(ball, at(0.5)), scene.closest([5.0, 5.0, 5.0]), scene.closest([5.0, 5.0, 5.0], work=0)]
    yield scene.step(work=0)
    robot = slide()
    Q = [[0.0], [4.5], [3.75]]
    yield from [robot.collide(Q), robot.collide(Q, work=0), robot.clearance(Q), robot.edges(Q, Q[::-1])]
    yield from [robot.collide_all(Q), robot.near_pairs(Q, 0.6)]
    plan = punctual3d.Trajectory()
    plan.push(4.0, [[0.0], [1.0]])
    yield punctual3d.Horizon(0.1, 1.0).step(robot, plan)


def slide():
    """A robot that carries a cube along x towards a wall."""
    cube = '<link name="cube"><collision><geometry><box size="2 2 2"/></geometry></collision></link>'
    joint = '<joint name="x" type="prismatic"><parent link="rail"/><child link="cube"/></joint>'
    with tempfile.TemporaryDirectory() as folder:
        urdf = Path(folder) / "slide.urdf"
        urdf.write_text(f'<robot name="slide"><link name="rail"/>{cube}{joint}</robot>')
        robot = punctual3d.Robot.from_urdf(urdf)
    robot.add("wall", at(6.0), box=[2.0, 6.0, 6.0])
    return robot


RECORDS = list(records())


def told(record):
    """All attributes."""
    names = [name for name in dir(type(record)) if not name.startswith("_") and name not in ("view", "save")]
    return {name: getattr(record, name) for name in names}


def same(x, y):
    if isinstance(x, np.ndarray):
        return x.dtype == y.dtype and np.array_equal(x, y, equal_nan=x.dtype.kind == "f")
    if type(x).__module__ == "punctual3d":
        return same(told(x), told(y))
    if isinstance(x, dict):
        return x.keys() == y.keys() and all(same(x[key], y[key]) for key in x)
    return type(x) is type(y) and x == y


def test_all_classes_are_here():
    left = {"Answer", "Tree", "Memory", "Query", "DistanceQuery", "MotionQuery", "Scene", "CollisionManager", "Robot"}
    left |= {"ContactData", "DistanceData", "Horizon", "PointWindow", "Trajectory"}
    classes = {name for name in punctual3d.__all__ if isinstance(getattr(punctual3d, name), type)}
    classes = {name for name in classes if not issubclass(getattr(punctual3d, name), (Exception, Warning))}
    assert {type(record).__name__ for record in RECORDS} == classes - left


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
@pytest.mark.parametrize("protocol", [0, pickle.HIGHEST_PROTOCOL])
def test_a_pickle_says_the_same(record, protocol):
    again = pickle.loads(pickle.dumps(record, protocol))
    assert type(again) is type(record) and same(told(record), told(again))
    assert again == record and not again != record and hash(again) == hash(record)
    assert repr(again) == repr(record)
    assert record != 1 and record != RECORDS[0 if record is not RECORDS[0] else 1]
    assert copy.copy(record) is copy.deepcopy(record) is record


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
def test_a_line_tells_what_it_says(record):
    text = repr(record)
    assert "\n" not in text and " object at 0x" not in text and type(record).__name__ in text
    assert any(digit in text for digit in "0123456789") or "inf" in text


def test_lines():
    ball, ring = punctual3d.shapes.icosphere(3), punctual3d.shapes.torus(2.0, 0.5, 48)
    batch = punctual3d.collide_batch(ball, ring, [at(0.0), at(1.0), at(1.2)])
    assert repr(batch) == "<punctual3d.CollisionBatch: 3 poses, 2 meet, 1 apart, 0 undecided>"
    scene = punctual3d.Scene()
    scene.insert(ball), scene.insert(ball, at(1.0))
    assert repr(scene) == "<punctual3d.Scene of 2 bodies>"
    assert repr(scene.step()) == "<punctual3d.Report: frame 1, 1 pairs, 1 meet, 0 apart, 0 undecided, whole>"
    assert repr(punctual3d.Query(ball, ring)) == "<punctual3d.Query of 1280 and 2304 triangles>"
    assert repr(punctual3d.Memory()) == "<punctual3d.Memory: never decided, 0 frames undecided>"


def test_answers_that_differ_are_not_equal():
    ball, ring = punctual3d.shapes.icosphere(3), punctual3d.shapes.torus(2.0, 0.5, 48)
    one, other = (punctual3d.collide(ball, ring, at(1.0), mode="all", work=work) for work in (2000, 3000))
    assert one == punctual3d.collide(ball, ring, at(1.0), mode="all", work=2000) and one != other
    batch = punctual3d.collide_batch(ball, ring, [at(1.0)])
    changed = pickle.loads(pickle.dumps(batch))
    changed.found[0] += 1
    assert changed != batch and len({batch, pickle.loads(pickle.dumps(batch)), changed}) == 2


def test_a_pickled_answer_keeps_its_truth_and_leaves_the_trees():
    ball = punctual3d.shapes.icosphere(5)
    hit = punctual3d.collide(ball, ball)
    data = pickle.dumps(hit)
    assert len(data) < 500 and pickle.loads(data)
    with pytest.raises(punctual3d.UndecidedError):
        bool(pickle.loads(pickle.dumps(punctual3d.collide(ball, ball, work=0))))
    assert pickle.loads(pickle.dumps(punctual3d.closer_than(ball, ball, 0.1)))
    with pytest.raises(ValueError, match="the answer was pickled, which leaves the trees behind"):
        pickle.loads(data).view()
    with pytest.raises(ValueError, match="Collision was pickled by punctual3d 0.0.1, this is "):
        punctual3d._punctual3d._restore("Collision", "0.0.1", b"")
    with pytest.raises(ValueError, match="Collision: the pickle is damaged"):
        punctual3d._punctual3d._restore("Collision", punctual3d.__version__, b"1")


def test_trees_are_compared_by_what_they_hold(ball, ring):
    other = punctual3d.Tree(ball.vertices, ball.faces)
    assert ball == other == copy.deepcopy(ball) == pickle.loads(pickle.dumps(ball)) and ball != ring and ball != 1
    before = hash(other)
    other.refit(ball.vertices * 2)
    assert other != ball and hash(other) == before and {ball: 1}[copy.copy(ball)] == 1


def test_a_memory_is_pickled_with_what_it_learned(ball, ring):
    memory = punctual3d.Memory()
    first = punctual3d.collide(ball, ring, at(1.0), memory=memory)
    punctual3d.distance(ball, ring, memory=memory)
    for other in (pickle.loads(pickle.dumps(memory)), copy.copy(memory), copy.deepcopy(memory)):
        assert other.last_verdict is True and other.change_rate == memory.change_rate
        assert punctual3d.collide(ball, ring, at(1.0), memory=other).work < first.work
    assert copy.copy(memory).clearance(ball, ring) == memory.clearance(ball, ring) > 0


def answer(tree, kind, pose):
    ring = punctual3d.shapes.torus(2.0, 0.5, 48)
    return getattr(punctual3d, kind)(tree, ring, pose)


def test_workers_return_answers(ball, ring):
    kinds = ["collide", "distance", "contacts", "collide_batch"]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        said = pool.starmap(answer, [(ball, kind, at(1.0)) for kind in kinds])
    assert said == [answer(ball, kind, at(1.0)) for kind in kinds]


def test_workers_of_dask_return_answers(ball):
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        tree = client.scatter(ball, broadcast=True)
        assert client.submit(answer, tree, "collide", at(1.0)).result() == answer(ball, "collide", at(1.0))
