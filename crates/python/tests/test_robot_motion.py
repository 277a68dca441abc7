"""Near pairs with gradients, obstacles that move, trajectories and controllers, on the arm of the crate's own tests."""

import importlib.util
import pickle

import numpy as np
import punctual3d
import pytest
from test_robot import TESTS, cell, configurations, place, robot  # noqa: F401

EXAMPLE = TESTS.parents[2] / "examples/python/optimise_and_follow.py"


def test_near_pairs_are_those_of_clearances(robot):
    Q, within = configurations(100), 0.15
    near = robot.near_pairs(Q, within, tolerance=1e-9)
    assert len(near) == 100 and near.offsets[0] == 0 and near.offsets[-1] == len(near.pairs) == len(near.gradients)
    assert (near.low <= near.high).all() and (near.beyond >= within).all() and near.gradients.shape[1] == 4
    clear = robot.clearance(Q, tolerance=1e-9)
    for i, (a, b) in enumerate(zip(near.offsets, near.offsets[1:])):
        least = near.low[a:b].min() if a < b else np.inf
        assert least <= clear.high[i] and clear.low[i] <= least or clear.low[i] > within - 1e-6
    apart = near.low > 1e-6
    gap = near.points[apart, 1] - near.points[apart, 0]
    assert np.allclose(np.linalg.norm(gap, axis=1)[:, None] * near.normals[apart], gap)
    assert apart.sum() > 100 and near == robot.near_pairs(Q, within, tolerance=1e-9, threads=2)
    assert pickle.loads(pickle.dumps(near)) == near and "100 configurations" in repr(near)


def test_gradients_are_finite_differences(robot):
    checked = 0
    for q in configurations(60):
        near = robot.near_pairs(q, 0.2, tolerance=1e-10)
        for joint in range(4):
            step = 1e-5 * np.eye(4)[joint]
            ends = [robot.near_pairs(q + s, 0.3, tolerance=1e-10) for s in (-step, step)]
            ends = [dict(zip(map(tuple, end.pairs), (end.low + end.high) / 2)) for end in ends]
            for pair, low, gradient, normal in zip(map(tuple, near.pairs), near.low, near.gradients, near.normals):
                if low < 1e-3 or any(pair not in end for end in ends):
                    continue
                slope = (ends[1][pair] - ends[0][pair]) / 2e-5
                # Closest points jump from edge to edge, so the slope is that of one side there.
                checked += 1
                assert abs(slope - gradient[joint]) < 2e-3 or abs(slope) <= abs(gradient[joint]) + 0.5
    assert checked > 300


def test_a_stopped_list_says_what_may_be_missing(robot):
    Q = configurations(40)
    whole = robot.near_pairs(Q, 0.1, tolerance=1e-9)
    known = {(i, *pair): low for i in range(40) for pair, low in rows(whole, i)}
    for work in (0, 300, 3_000):
        part = robot.near_pairs(Q, 0.1, tolerance=1e-9, work=work)
        for i in range(40):
            listed = {pair for pair, _ in rows(part, i)}
            missing = [low for (row, *pair), low in known.items() if row == i and tuple(pair) not in listed]
            assert all(part.beyond[i] <= low + 1e-8 for low in missing)
    own = {robot.shape_name(n) for n in robot.near_pairs(Q, 0.1, scope="robot").pairs.flat}
    assert own >= {"fore", "left", "load"} and not own & {"board", "ball", "post", "ring"}


def rows(near, i):
    a, b = near.offsets[i : i + 2]
    return zip(map(tuple, near.pairs[a:b]), near.low[a:b])


def test_obstacles_move_along_edges(robot):
    Q0, Q1 = configurations(40), configurations(40, 2)
    Q1 = Q0 + 0.3 * (Q1 - Q0)
    still = robot.edges(Q0, Q1, first=True)
    ball = number(robot, "ball")
    robot.move_along(ball, place(-0.7, 0.3, 0.9), linear=np.array([1.5, 0, 0]), reach=0.02, reach_speed=0.1)
    moving = robot.edges(Q0, Q1, first=True, start=0.1, duration=0.8)
    truth = pickle.loads(pickle.dumps(robot))
    assert moving != still and truth.edges(Q0, Q1, first=True, start=0.1, duration=0.8) == moving
    seen = set()
    for time in np.linspace(0, 0.8, 41):
        truth.move(ball, place(-0.7 + 1.5 * (0.1 + time), 0.3, 0.9))
        truth.set_margin(0.02 + 0.1 * (0.1 + time), name="ball")
        met = truth.collide(Q0 + time / 0.8 * (Q1 - Q0)).verdict == 1
        assert not (met & ((moving.free_until > time) | (moving.verdict == 0))).any()
        seen |= set(met.tolist())
    assert seen == {False, True} and set(moving.verdict) == {0, 1}
    robot.move(ball, place(-0.7, 0.3, 0.9))
    assert (robot.edges(Q0, Q1, first=True).verdict == still.verdict).all()


def number(robot, name):
    (found,) = [n for n in range(len(robot.link_names) + 6) if has(robot, n) and robot.shape_name(n) == name]
    return found


def has(robot, number):
    try:
        return bool(robot.shape_name(number))
    except ValueError:
        return False


def test_obstacles_go_from_pose_to_pose(robot):
    q = np.array([[0, 0, 0, 0]] * 2)
    pea = robot.add("pea", place(2, 0, 0.6), sphere=0.05)
    robot.move_along(pea, [place(2, 0, 0.6), place(0, 0, 0.6)], times=[1, 3])
    path = robot.path(q, first=True, duration=4)
    # The upper link is .05 thick.
    assert path.verdict[0] == 1 and abs(path.free_until[0] - 2.9) < 1e-4 and abs(path.touching_at[0] - 2.9) < 1e-4
    assert robot.path(q, duration=2.8).verdict[0] == 0 and robot.path(q, duration=2.8, start=0.2).verdict[0] == 1


def motion(robot, seed=0):
    """A cubic through three configurations."""
    Q = configurations(1, seed) + 0.3 * np.cumsum(configurations(3, seed + 50), axis=0)
    motion = punctual3d.Trajectory()
    motion.push(0.5, [Q[0], Q[1] - Q[0], Q[2] - Q[1]])
    motion.push(0.25, [motion.at(0.5), Q[2] - Q[0]])
    return motion


def test_trajectories(robot):
    seen = set()
    for seed in range(20):
        m = motion(robot, seed)
        assert m.seconds == 0.75 and np.allclose(m.at([0, 0.5]), [m.at(0), m.at(0.5)])
        found = robot.trajectory(m, first=True)
        times = np.linspace(0, 0.75, 151)
        met = robot.collide(m.at(times)).verdict == 1
        assert not met[times < found.free_until[0]].any() and (found.verdict[0] == 1 or not met.any())
        seen.add(int(found.verdict[0]))
        cut = robot.trajectory(m, first=True, work=1)
        while cut.free_until[0] < found.free_until[0]:
            cut = robot.resume(work=5_000)
        assert cut.free_until[0] == found.free_until[0]
    assert seen == {0, 1}
    m.clear()
    assert m.seconds == 0 and m.at(1).tolist() == [] and "0 joints" in repr(m)
    with pytest.raises(ValueError, match="piece"):
        robot.trajectory(m)


def test_a_controller_never_meets_what_it_knows(robot):
    """While the ball does as it was told, and the robot does not rest."""
    home, way = configurations(1, 5)[0], np.array([0.6, 0.1, -0.2, 0])
    plan = punctual3d.Trajectory()
    plan.push(2.0, [home, way])
    ball = robot.add("thrown", place(2, 0, 1), sphere=0.1)
    horizon = punctual3d.Horizon(0.01, punctual3d.braking_time(way, [4.0] * 4))
    truth, speed, ahead = pickle.loads(pickle.dumps(robot)), 0.0, None
    assert robot.is_valid(home)
    for cycle in range(200):
        robot.move_along(ball, place(2 - 0.02 * cycle, 0, 1), linear=[-2, 0, 0])
        ahead = horizon.step(robot, plan if cycle == 0 else None, work=0 if cycle % 8 == 7 else 50_000)
        assert abs(ahead.speed - speed) <= 0.01 / punctual3d.braking_time(way, [4.0] * 4) + 1e-12
        assert 0 <= ahead.speed <= 1 and ahead.time <= ahead.stops_at <= max(ahead.free_until, 2.0)
        speed = ahead.speed
        truth.move(ball, place(2 - 0.02 * (cycle + 1), 0, 1))
        assert speed == 0 or ahead.is_proven and truth.collide(plan.at(ahead.time)).verdict[0] == 0
    assert ahead.time > 0.1 and pickle.loads(pickle.dumps(ahead)) == ahead and "of the speed" in repr(ahead)


@pytest.mark.parametrize(
    "arguments, says",
    [
        ({"poses": [np.eye(4)] * 2}, "times: expected those of 2 poses"),
        ({"poses": [np.eye(4)] * 2, "times": [1]}, "times: 1 of 2 poses"),
        ({"poses": [np.eye(4)] * 2, "times": [1, 1]}, "pose 0: 1 s follows 1 s"),
        ({"poses": np.eye(4), "times": [1], "linear": [0, 0, 0]}, "times: not with linear"),
        ({"poses": np.eye(4), "linear": [0, np.nan, 0]}, "velocity"),
        ({"poses": np.eye(4), "linear": [0, 0]}, "linear: shape"),
        ({"poses": 2 * np.eye(4)}, "poses|pose 0"),
        ({"poses": np.eye(4), "reach": -1}, "reach"),
        ({"poses": np.eye(4), "reach_speed": np.inf}, "reach"),
    ],
)
def test_tracks_that_are_refused(robot, arguments, says):
    pea = robot.add("pea", place(2, 0, 0.6), sphere=0.05)
    with pytest.raises(ValueError, match=says):
        robot.move_along(pea, **arguments)
    assert robot.path([[0] * 4] * 2).verdict[0] == 0


def test_faults(robot):
    load = number(robot, "load")
    with pytest.raises(ValueError, match="load: is attached"):
        robot.move_along(load, np.eye(4))
    with pytest.raises(ValueError, match="obstacle 999"):
        robot.move_along(999, np.eye(4))
    with pytest.raises(ValueError, match="within is NaN"):
        robot.near_pairs([0] * 4, np.nan)
    m = punctual3d.Trajectory()
    for seconds, rows, says in [
        (0, [[0] * 4], "piece 0"),
        (1, [], "piece 0"),
        (1, [[0, np.inf]], "piece 0: power 0: joint 1"),
        (1, "text", "coefficients"),
    ]:
        with pytest.raises(ValueError, match=says):
            m.push(seconds, rows)
    m.push(1, [[0] * 3])
    with pytest.raises(ValueError, match="piece 1"):
        m.push(1, [[0] * 4])
    for refused in (lambda: robot.trajectory(m), lambda: punctual3d.Horizon(0.01, 1).step(robot, m)):
        with pytest.raises(ValueError, match="3"):
            refused()
    with pytest.raises(ValueError, match="plan|piece"):
        punctual3d.Horizon(0.01, 1).step(robot)
    for wrong in ((0, 1), (0.01, -1), (np.nan, 1)):
        with pytest.raises(ValueError, match="horizon: cycle"):
            punctual3d.Horizon(*wrong)
    with pytest.raises(ValueError, match="duration"):
        robot.edges([0] * 4, [0] * 4, duration=-1)
    with pytest.raises(ValueError, match="start"):
        robot.path([[0] * 4] * 2, start=np.nan)


def test_clouds_are_obstacles(robot):
    scan = punctual3d.Tree.from_points(np.random.default_rng(1).uniform([0.3, -1, 0.2], [1, 1, 1.8], (20_000, 3)), 0.01)
    number = robot.add("scan", mesh=scan)
    Q = configurations(200)
    near = robot.clearance(Q, scope=number)
    labels = robot.collide(Q)
    assert ((near.high == 0) <= (labels.verdict == 1)).all() and 10 < (near.high == 0).sum() < 190
    other = pickle.loads(pickle.dumps(robot))
    assert other.clearance(Q, scope=number) == near
    robot.remove(number)
    assert (robot.collide(Q).verdict <= labels.verdict).all()


def test_the_example_finds_a_way_and_follows_it(capsys):
    spec = importlib.util.spec_from_file_location("optimise_and_follow", EXAMPLE)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    before, after, motion, cycles = example.main({"work": 20_000})
    assert before.verdict[0] == 1 and after.verdict[0] == 0 and motion.seconds == after.free_until[0] == 2
    assert len(cycles) < 20_000 and cycles[-1].time > 1.999 and any(ahead.speed > 0.9 for ahead in cycles)
    assert "bent: <punctual3d.RobotEdges: 1 free" in capsys.readouterr().out
