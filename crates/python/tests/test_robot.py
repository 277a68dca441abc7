"""Robots: configurations, clearance and edges, on the arm of the crate's own tests."""

import pickle
import shutil
from pathlib import Path

import numpy as np
import punctual3d
import pytest

TESTS = Path(__file__).resolve().parents[2] / "robot/tests"
CELLS = sorted((TESTS.parents[3] / "shared/robots").glob("*/robot.urdf"))


def place(*xyz):
    T = np.eye(4)
    T[:3, 3] = xyz
    return T


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "arm").mkdir()
    for name in ("wedge.obj", "arm/wedge.obj"):
        shutil.copy(TESTS / "wedge.obj", tmp_path / name)
    urdf = shutil.copy(TESTS / "arm.urdf", tmp_path)
    return cell(punctual3d.Robot.from_urdf(urdf, srdf=TESTS / "arm.srdf"))


@pytest.mark.parametrize("solids", [False, True])
def test_meshes_as_solids(solids, tmp_path):
    (tmp_path / "arm").mkdir()
    for name in ("wedge.obj", "arm/wedge.obj"):
        shutil.copy(TESTS / "wedge.obj", tmp_path / name)
    urdf = shutil.copy(TESTS / "arm.urdf", tmp_path)
    robot = punctual3d.Robot.from_urdf(urdf, srdf=TESTS / "arm.srdf", solids=solids)
    robot.add("pea", place(0, 0, 1.2), sphere=0.001)  # in the forearm, whose mesh is closed
    assert robot.is_valid([0, 0, 0, 0]) != solids
    assert pickle.loads(pickle.dumps(robot)).is_valid((0, 0, 0, 0)) != solids


def cell(robot):
    robot.add("board", place(0.9, 0, 0.4), box=(0.6, 0.6, 0.05))
    robot.add("ball", place(-0.7, 0.3, 0.9), sphere=0.2)
    robot.add("post", place(0, -0.7, 0.5), cylinder=(0.08, 1.0))
    robot.add("ring", place(0.2, 0.8, 1.0), mesh=punctual3d.shapes.torus(0.3, 0.08, 24))
    robot.add("load", place(0, 0, 0.12), box=(0.02, 0.02, 0.2), link="palm", may_touch=["left"])
    return robot


def configurations(count, seed=1):
    low, high = [-3, -2, -2.5, 0], [3, 2, 2.5, 0.1]
    return np.random.default_rng(seed).uniform(low, high, (count, 4))


def test_names_and_places(robot):
    assert robot.joint_names == ["pan", "lift", "elbow", "grip"]
    assert robot.joint_limits.tolist()[:2] == [[-np.inf, np.inf], [-2.0, 2.0]]
    poses = robot.link_poses(configurations(5))
    assert poses.shape == (5, len(robot.link_names), 4, 4)
    assert np.allclose(poses[:, :, :3, :3] @ poses[:, :, :3, :3].swapaxes(-1, -2), np.eye(3))
    assert np.array_equal(robot.link_poses([0, 0, 0, 0])[0, robot.link_names.index("palm"), :3, 3], [0, 0, 1.5])


def test_one_is_as_many(robot):
    Q = configurations(300)
    labels = robot.collide(Q)
    assert labels.verdict.dtype == np.int8 and 30 < labels.verdict.sum() < 270
    assert [robot.is_valid(q) for q in Q] == (labels.verdict == 0).tolist()
    named = labels.pairs[labels.verdict == 1]
    assert all(robot.shape_name(a) and robot.shape_name(b) for a, b in named)
    assert (labels.pairs[labels.verdict == 0] == -1).all()
    near = robot.clearance(Q, tolerance=1e-9)
    assert ((near.low > 0) == (labels.verdict == 0)).all() and (near.low <= near.high).all()
    gap = np.linalg.norm(near.points[:, 1] - near.points[:, 0], axis=1)
    solid = [{"base", "post"}.isdisjoint(map(robot.shape_name, pair)) for pair in near.pairs]
    free = (labels.verdict == 0) & solid
    assert np.allclose(gap[free], near.high[free], atol=1e-8)


def test_threads_and_budgets(robot):
    Q = configurations(500)
    for work in (None, 2_000):
        a, b = (pickle.loads(pickle.dumps(robot)).collide(Q, work=work, threads=threads) for threads in (1, 2))
        assert a == b and (work is None) == (a.verdict != -1).all()
    assert (robot.collide(Q, work=0).verdict == -1).all()


def test_edges(robot):
    Q0, Q1 = configurations(60), configurations(60, 2)
    Q1 = Q0 + 0.3 * (Q1 - Q0)
    edges, first = robot.edges(Q0, Q1), robot.edges(Q0, Q1, first=True, threads=2)
    assert (edges.verdict == first.verdict).all() and {0, 1} == set(edges.verdict)
    assert [robot.is_edge_valid(a, b) for a, b in zip(Q0, Q1)] == (edges.verdict == 0).tolist()
    for t in np.linspace(0, 1, 101):
        met = robot.collide(Q0 + t * (Q1 - Q0)).verdict == 1
        assert not (met & (first.free_until > t)).any() and not (met & (edges.verdict == 0)).any()
    assert np.isnan(first.touching_at).tolist() == (first.verdict == 0).tolist()


def test_a_path_is_free_if_its_lines_are(robot):
    seen = set()
    for seed in range(12):
        Q = configurations(1, seed) + 0.2 * np.cumsum(configurations(4, seed + 100), axis=0)
        lines, path = robot.edges(Q[:-1], Q[1:], first=True), robot.path(Q, first=True)
        blocked = np.flatnonzero(lines.verdict)
        assert len(path) == 1 and path.verdict[0] == (len(blocked) > 0) == robot.path(Q).verdict[0]
        if len(blocked):
            line = blocked[0]
            assert path.free_until[0] <= line + lines.touching_at[line]
            assert line + lines.free_until[line] <= path.touching_at[0]
        else:
            assert path.free_until[0] == 3
        seen.add(int(path.verdict[0]))
        step = robot.path(Q, first=True, work=1)
        while step.verdict[0] == -1:
            assert step.free_until[0] <= path.free_until[0]
            step = robot.resume(work=3_000)
        assert step.verdict[0] == path.verdict[0]
    assert seen == {0, 1}


def test_a_horizon_leaves_room_to_stop(robot):
    Q, V = configurations(80), configurations(80, 3)
    counts = {0: 0, 1: 0, -1: 0}
    for q, v in zip(Q, V):
        ahead = robot.horizon(q, v, 0.5, **[{}, {"work": 4_000}, {"budget": 1.0}][sum(counts.values()) % 3])
        (free,) = ahead.free_until
        counts[int(ahead.verdict[0])] += 1
        assert 0 <= free <= 0.5 and (free == 0.5) == (ahead.verdict[0] == 0)
        times = free * np.arange(50)[:, None] / 50
        assert free == 0 or not (robot.collide(q + times * v).verdict == 1).any()
        braking = punctual3d.braking_time(v, [3.0] * 4)
        share = punctual3d.safe_speed(free, 0.01, braking)
        assert 0 <= share <= 1 and share * 0.01 + share**2 * braking / 2 <= free
    assert counts[0] > 10 and counts[1] > 10
    cut = robot.horizon([0] * 4, [0.1] * 4, 0.5, work=0)
    assert cut.verdict[0] == -1 and robot.resume().free_until[0] == robot.horizon([0] * 4, [0.1] * 4, 0.5).free_until[0]
    with pytest.raises(ValueError, match="no stopped"):
        robot.resume()


def test_the_page_names_the_robot(robot, tmp_path):
    page = robot.view(configurations(3), tmp_path / "page.html")
    assert "How far a robot is from contact: arm" in page.html
    assert page.html == (tmp_path / "page.html").read_text()
    with pytest.raises(ValueError, match="joint lift"):
        robot.view([0, np.nan, 0, 0])


def test_obstacles_move_and_go(robot):
    q = [0, 0, 0, 0]
    assert robot.is_valid(q)
    ball = robot.add("near", place(0.1, 0, 0.6), sphere=0.1)
    assert not robot.is_valid(q) and robot.shape_name(ball) == "near"
    assert not pickle.loads(pickle.dumps(robot)).is_valid(q)
    robot.move(ball, place(0.5, 0, 0.6))
    other = pickle.loads(pickle.dumps(robot))
    assert robot.is_valid(q) and other.is_valid(q) and other.shape_name(ball) == "near"
    robot.remove(ball)
    with pytest.raises(ValueError, match="obstacle"):
        robot.remove(ball)


def test_a_robot_without_joints_has_configurations_without_values(tmp_path):
    urdf = tmp_path / "post.urdf"
    urdf.write_text('<robot name="post"><link name="a"><collision><geometry><sphere radius="1"/></geometry></collision></link></robot>')
    robot = punctual3d.Robot.from_urdf(urdf)
    assert robot.collide(np.zeros((3, 0))).verdict.tolist() == [0, 0, 0] and robot.is_valid([])


def test_faults(robot, tmp_path):
    with pytest.raises(ValueError, match="expected \\(N, 4\\)"):
        robot.collide([[0, 0, 0]])
    with pytest.raises(ValueError, match="joint lift"):
        robot.collide([[0, np.nan, 0, 0]])
    with pytest.raises(ValueError, match="fewer than two"):
        robot.path([0, 0, 0, 0])
    with pytest.raises(ValueError, match="expected \\(N, 4\\)"):
        robot.path([[0, 0, 0], [1, 1, 1]])
    with pytest.raises(ValueError, match="3 joint values"):
        robot.horizon([0, 0, 0, 0], [1, 1, 1], 0.1)
    with pytest.raises(ValueError, match="seconds"):
        robot.horizon([0, 0, 0, 0], [1, 1, 1, 1], np.inf)
    with pytest.raises(ValueError, match="2 velocities, 3"):
        punctual3d.braking_time([1, 2], [1, 2, 3])
    with pytest.raises(ValueError, match="no link nose"):
        robot.add("x", sphere=1.0, link="nose")
    with pytest.raises(ValueError, match="one of mesh, box"):
        robot.add("x")
    with pytest.raises(FileNotFoundError, match="none.urdf"):
        punctual3d.Robot.from_urdf(tmp_path / "none.urdf")


@pytest.mark.parametrize("urdf", CELLS, ids=lambda urdf: urdf.parent.name)
def test_no_label_is_wrong(urdf):
    folder = urdf.parent
    robot = punctual3d.Robot.from_urdf(urdf, srdf=folder / "robot.srdf")
    for file in sorted((folder / "env").iterdir()):
        robot.add(file.stem, mesh=punctual3d.Tree.load(file))
    Q = np.loadtxt(folder / "configs.csv", delimiter=",", skiprows=1)
    meets = np.loadtxt(folder / "labels.csv", delimiter=",", skiprows=1)[:, 1]
    assert np.array_equal(robot.collide(Q, threads=2).verdict, meets)


def test_an_obstacle_in_the_world_may_touch_links_too(robot):
    q = [0, 0, 0, 0]
    inside = place(0, 0, 0.6)
    assert not robot.collide([q]).verdict.any()
    cube = robot.add("cube", inside, box=(0.2, 0.2, 0.2))
    assert robot.shape_name(cube) == "cube" and not robot.is_valid(q)
    robot.remove(cube)
    robot.add("cube", inside, box=(0.2, 0.2, 0.2), may_touch=["upper"])
    assert robot.is_valid(q) and pickle.loads(pickle.dumps(robot)).is_valid(q)
    for link in (None, "palm"):
        with pytest.raises(ValueError, match="obstacle it: may_touch: there is no link nose"):
            robot.add("it", inside, sphere=0.1, link=link, may_touch=["upper", "nose"])
    assert robot.is_valid(q)


def test_what_files_say_in_vain_is_told(tmp_path):
    (tmp_path / "bowl.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n")
    urdf = tmp_path / "bowl.urdf"
    shape = '<collision><geometry><mesh filename="bowl.obj"/></geometry></collision>'
    capsule = '<collision_checking><capsule name="bowl"/></collision_checking>'
    urdf.write_text(f'<robot name="bowl"><link name="bowl">{shape}\n{capsule}</link></robot>')
    (tmp_path / "bowl.srdf").write_text('<robot><disable_collisions link1="bowl" link2="none"/></robot>')
    with pytest.warns(UserWarning) as told:
        robot = punctual3d.Robot.from_urdf(urdf, srdf=tmp_path / "bowl.srdf", solids=True)
    assert [str(warning.message) for warning in told] == robot.notices
    for notice, words in zip(robot.notices, ["collision_checking", "open edges", "there is no link none"], strict=True):
        assert words in notice and "bowl." in notice
    with pytest.warns(UserWarning, match="obstacle pot: a surface, for it has 3 open edges"):
        robot.add("pot", mesh=punctual3d.Tree.load(tmp_path / "bowl.obj", solid="keep"))


def test_missing_files_are_told_from_bad_ones(tmp_path):
    for load in (punctual3d.Robot.from_urdf, punctual3d.Tree.load):
        with pytest.raises(FileNotFoundError, match=r"none\.(urdf|obj)"):
            load(tmp_path / ("none.urdf" if load == punctual3d.Robot.from_urdf else "none.obj"))
    urdf = tmp_path / "a.urdf"
    for mesh in ("none.obj", "package://none/none.obj"):
        shape = f'<collision><geometry><mesh filename="{mesh}"/></geometry></collision>'
        urdf.write_text(f'<robot name="a"><link name="b">{shape}</link></robot>')
        with pytest.raises(FileNotFoundError, match="a.urdf:1: link b: "):
            punctual3d.Robot.from_urdf(urdf)
    with pytest.raises(FileNotFoundError, match="none.srdf"):
        punctual3d.Robot.from_urdf(TESTS.parent / "examples/arm7.urdf", srdf="none.srdf")
    urdf.write_text("<robot")
    with pytest.raises(ValueError):
        punctual3d.Robot.from_urdf(urdf)
    (tmp_path / "bad.obj").write_text("v 0 0")
    with pytest.raises(OSError, match="bad.obj:1") as bad:
        punctual3d.Tree.load(tmp_path / "bad.obj")
    assert not isinstance(bad.value, FileNotFoundError)


def test_all_pairs_that_meet(robot):
    Q = np.vstack([configurations(200), [0.0, 1.2, 0.9, 0.0]])
    told = []
    one, every = robot.collide(Q), robot.collide_all(Q, progress=lambda *at: told.append(at))
    assert (one.verdict == every.verdict).all() and every.complete.all() and told[-1] == (len(Q), len(Q))
    assert every.offsets[0] == 0 and every.offsets[-1] == len(every.pairs) > (one.verdict == 1).sum()
    for i, q in enumerate(Q):
        pairs = {tuple(pair) for pair in every.pairs[every.offsets[i] : every.offsets[i + 1]].tolist()}
        assert bool(pairs) == (one.verdict[i] == 1) and (not pairs or tuple(one.pairs[i]) in pairs)
        # Exactly those whose clearance is nothing.
        for a, b in pairs:
            assert robot.clearance(q, scope=a).low == 0 and robot.clearance(q, scope=b).low == 0
    cut = robot.collide_all(Q, work=0)
    assert not cut.complete.any() and (cut.verdict == -1).all() and len(cut.pairs) == 0


def test_the_scope_of_a_clearance(robot):
    Q = configurations(50)
    low = {scope: robot.clearance(Q, scope=scope, tolerance=0).low for scope in (None, "robot", "obstacles")}
    assert np.array_equal(low[None], np.minimum(low["robot"], low["obstacles"]))
    assert (low["robot"] != low["obstacles"]).any()
    ball = robot.add("far", place(50, 0, 0), sphere=1.0)
    assert (robot.clearance(Q, scope=ball).low > 40).all()
    for scope in ("world", 999):
        with pytest.raises(ValueError, match=f"scope: '?\"?{scope}"):
            robot.clearance(Q, scope=scope)


def test_margins_are_those_of_distances(robot):
    Q = configurations(300)
    before = robot.clearance(Q, tolerance=1e-9)
    for margin in (0.005, 0.02, 0.0):
        robot.set_margin(0.3)
        robot.set_margin(margin)
        verdict, left = robot.collide(Q).verdict, robot.clearance(Q, tolerance=1e-9)
        # Solids that hold each other have no other distance than 0.
        apart = before.low > 0
        assert np.allclose(left.high[apart], before.high[apart] - margin, atol=1e-8)
        # `high` allows for the prism that stands for a cylinder, labels do not.
        sure = np.abs(before.low - margin) > 1e-8
        assert (verdict[sure] == (before.low <= margin)[sure]).all() and sure.sum() > 200
        assert (verdict == 1).sum() > 30 and (verdict == 0).sum() > 10
    assert robot.clearance(Q, tolerance=1e-9) == before


def test_margins_add_up_but_for_two_names(robot):
    q = [0, 0, 0, 0]
    peas = {name: robot.add(name, place(0.4, 0, z), sphere=0.01) for name, z in (("pea", 0.6), ("bean", 1.2))}
    far = {name: robot.clearance(q, scope=number, tolerance=1e-9).low[0] for name, number in peas.items()}

    def margins():
        left = {name: robot.clearance(q, scope=number, tolerance=1e-9).low[0] for name, number in peas.items()}
        return [round(far[name] - left[name], 6) for name in peas]

    pea = robot.clearance(q, scope=peas["pea"])
    (link,) = {robot.shape_name(n) for n in pea.pairs[0]} - {"pea"}
    robot.set_margin(0.01)
    assert margins() == [0.01, 0.01]
    robot.set_margin(0.02, name="pea")
    assert margins() == [0.03, 0.01]
    robot.set_margin(0.04, name=link, padding=True)
    assert margins()[0] == 0.07
    robot.set_margin(0.005, name=link, other="pea")
    assert margins()[0] == 0.005
    # Either order names the same pair, and the last margin counts.
    for margin, names in ((0.4, ("pea", link)), (0, (link, "pea")), (0.5, ("pea", link)), (0.45, (link, "pea"))):
        robot.set_margin(margin, name=names[0], other=names[1])
        copy = pickle.loads(pickle.dumps(robot))
        assert copy.clearance(q, scope=peas["pea"]) == robot.clearance(q, scope=peas["pea"])
        assert (robot.clearance(q, scope=peas["pea"]).low[0] < 0) == (margin > far["pea"])


def test_edges_keep_margins(robot):
    Q0, Q1 = configurations(60), configurations(60, 2)
    Q1 = Q0 + 0.3 * (Q1 - Q0)
    before = robot.edges(Q0, Q1).verdict
    robot.set_margin(0.03)
    edges = robot.edges(Q0, Q1)
    assert ((before == 1) <= (edges.verdict == 1)).all() and (edges.verdict != before).any()
    for t in np.linspace(0, 1, 51):
        near = robot.clearance(Q0 + t * (Q1 - Q0)).low
        assert (near[edges.verdict == 0] > -1e-6).all()


def test_margins_are_pickled(robot):
    Q = configurations(100)
    robot.set_margin(0.02)
    robot.set_margin(0.05, name="palm", padding=True)
    gone = robot.add("gone", place(9, 0, 0), sphere=0.1)
    robot.set_margin(0.1, name="gone")
    robot.set_margin(0.3, name="gone", other="palm")
    robot.remove(gone)
    other = pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(robot))))
    assert other.clearance(Q) == robot.clearance(Q) and other.collide(Q) == robot.collide(Q)
    with pytest.raises(ValueError, match="name: there is no link or obstacle gone"):
        other.set_margin(0.1, name="gone")
    # Margins wait for their names.
    for r in (robot, other):
        r.add("gone", place(0.2, 0, 1.55), sphere=0.05)
    assert other.clearance(Q).low.tolist() == robot.clearance(Q).low.tolist()
    other.set_margin(0, name="gone")
    other.set_margin(0, name="gone", other="palm")
    assert other.clearance(Q).low.tolist() != robot.clearance(Q).low.tolist()


@pytest.mark.parametrize(
    "margin, names, says",
    [
        (-0.1, {}, "margin: -0.1 m"),
        (np.nan, {}, "margin: NaN"),
        (np.inf, {"name": "palm"}, "margin: inf"),
        (2e30, {"name": "palm", "other": "board"}, "margin: "),
        (0.1, {"name": "nose"}, "name: there is no link or obstacle nose"),
        (0.1, {"name": "palm", "other": "nose"}, "other: there is no link or obstacle nose"),
        (0.1, {"other": "palm"}, "other: expected name too"),
        (0.1, {"padding": True}, "padding: expected name too"),
        (0.1, {"name": "palm", "other": "board", "padding": True}, "padding: not of two names"),
    ],
)
def test_margins_that_are_refused(robot, margin, names, says):
    Q = configurations(20)
    before = robot.clearance(Q)
    with pytest.raises(ValueError, match=says):
        robot.set_margin(margin, **names)
    assert robot.clearance(Q) == before == pickle.loads(pickle.dumps(robot)).clearance(Q)


def test_a_margin_ends_what_was_stopped(robot):
    robot.horizon([0] * 4, [0.1] * 4, 0.5, work=0)
    robot.set_margin(0.01)
    with pytest.raises(ValueError):
        robot.resume()


def test_names_are_allowed_to_touch_and_pickles_know_it(robot):
    q = [0, 0, 0, 0]
    number = robot.add("wall", place(0.1, 0, 0.6), sphere=0.1)
    met = {tuple(map(robot.shape_name, pair)) for pair in robot.collide_all(q).pairs}
    assert met and not robot.is_valid(q)
    for a, b in met:
        robot.allow(b, a)
    assert robot.is_valid(q) and pickle.loads(pickle.dumps(robot)).is_valid(q)
    robot.allow(*min(met), may_touch=False)
    assert not robot.is_valid(q) and not pickle.loads(pickle.dumps(robot)).is_valid(q)
    robot.allow(*min(met))
    with pytest.raises(ValueError, match="name: there is no link or obstacle nose"):
        robot.allow("nose", "palm")
    with pytest.raises(ValueError, match="other: there is no link or obstacle nose"):
        robot.allow("palm", "nose")
    # What was told of a name counts for obstacles that come later.
    robot.remove(number)
    for r in (robot, pickle.loads(pickle.dumps(robot))):
        r.add("wall", place(0.1, 0, 0.6), sphere=0.1)
        assert r.is_valid(q)
