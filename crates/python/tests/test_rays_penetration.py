"""Rays, penetration and clearance: as geometry says, and as other questions say."""

import threading
import time

import numpy as np
import punctual3d
import pytest


def beams(count=400):
    """Origins outside of a cube with the half edge 1, directions of many lengths towards it or past it."""
    random = np.random.default_rng(5)
    origins = random.normal(size=(count, 3))
    origins *= 4 / np.linalg.norm(origins, axis=1)[:, None]
    return origins, (random.uniform(-1.8, 1.8, size=(count, 3)) - origins) * random.uniform(0.2, 3, size=(count, 1))


def slabs(origins, directions):
    """Where rays enter the cube; infinite if they pass it."""
    with np.errstate(divide="ignore"):
        ends = np.stack([(-1 - origins) / directions, (1 - origins) / directions])
    enter, leave = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
    return np.where(enter <= leave, enter, np.inf)


@pytest.fixture(scope="module")
def cube():
    return punctual3d.shapes.cuboid([1.0, 1.0, 1.0], 6)


def test_rays_hit_a_cube_where_they_enter_it(cube):
    origins, directions = beams()
    hits, expected = punctual3d.rays(cube, origins, directions), slabs(origins, directions)
    hit = np.isfinite(expected)
    assert 50 < hit.sum() < 350 and (hits.done, hits.stop, len(hits)) == (400, "finished", 400)
    assert np.array_equal(hits.triangles >= 0, hit) and (hits.triangles[~hit] == -1).all()
    assert np.allclose(hits.t[hit], expected[hit], atol=1e-11) and np.isposinf(hits.t[~hit]).all()
    assert (hits.sides[hit] == 1).all() and (hits.sides[~hit] == 0).all()
    assert (hits.triangles.dtype, hits.t.dtype, hits.sides.dtype) == (np.int64, np.float64, np.int8)
    some = punctual3d.rays(cube, origins, directions, mode="any")
    assert np.array_equal(some.triangles >= 0, hit) and (some.t >= hits.t).all()


def test_segments_and_limits(cube):
    origins, directions = beams()
    hits = punctual3d.rays(cube, origins, directions)
    short = punctual3d.rays(cube, origins, ends=origins + 0.5 * directions)
    clear = ~np.isfinite(hits.t) | (abs(hits.t - 0.5) > 1e-9)
    assert np.array_equal((short.triangles >= 0)[clear], (hits.t <= 0.5)[clear]) and (short.triangles >= 0).any()
    limited = punctual3d.rays(cube, origins, directions, t_max=0.5)
    assert np.array_equal(limited.triangles, np.where(hits.t <= 0.5, hits.triangles, -1))
    inside = punctual3d.rays(cube, np.zeros((2, 3)), [[2, 0, 0], [0, 0, 0.5]], t_min=0.1)
    assert inside.t.tolist() == [0.5, 2.0] and inside.sides.tolist() == [-1, -1]


def test_stopped_rays_say_which_are_done(cube):
    origins, directions = beams()
    whole, part = punctual3d.rays(cube, origins, directions), punctual3d.rays(cube, origins, directions, work=30_000)
    assert part.stop == "work-limit" and 0 < part.done < 400 and np.isnan(part.t[part.done :]).all()
    assert np.array_equal(part.t[: part.done], whole.t[: part.done]) and (part.triangles[part.done :] == -1).all()
    late = punctual3d.rays(cube, origins, directions, budget=0.0)
    assert late.stop == "deadline" and late.elapsed >= 0 and whole.elapsed is None
    assert len(punctual3d.rays(cube, np.empty((0, 3)), [])) == 0 and "0 hits" in repr(punctual3d.rays(cube, [], []))


def test_all_hits_of_rays(cube):
    origins, directions = beams()
    nearest, every = (punctual3d.rays(cube, origins, directions, mode=mode) for mode in ("nearest", "all"))
    assert nearest.rays.tolist() == list(range(400)) and (every.done, every.stop) == (400, "finished")
    # A ray that enters a cube leaves it: in front of it and behind, through one triangle or along an edge.
    rays, first = np.unique(every.rays, return_index=True)
    assert np.array_equal(rays, np.flatnonzero(nearest.triangles >= 0)) and every.rays.dtype == np.int64
    assert np.array_equal(every.triangles[first], nearest.triangles[rays])
    assert np.array_equal(every.t[first], nearest.t[rays]) and len(every) >= 2 * len(rays)
    same = every.rays[1:] == every.rays[:-1]
    assert (np.diff(every.t)[same] >= 0).all() and {tuple(every.sides[first]), tuple(every.sides[first + 1])} == {
        (1,) * len(rays),
        (-1,) * len(rays),
    }
    part = punctual3d.rays(cube, origins, directions, mode="all", work=30_000)
    assert part.stop == "work-limit" and 0 < part.done < 400 and part.work >= 30_000
    assert np.array_equal(part.t, every.t[every.rays < part.done]) and (part.rays < part.done).all()
    late = punctual3d.rays(cube, origins, directions, mode="all", budget=0.0)
    assert (late.stop, late.done, len(late)) == ("deadline", 0, 0) and late.elapsed >= 0 and every.elapsed is None
    # More hits of one ray than a workspace has room for at first.
    sheets = np.arange(5000.0)
    corners = np.stack([np.tile([x, y, 0.0], (5000, 1)) for x, y in [(0, 0), (1, 0), (0, 1)]], axis=1)
    corners[:, :, 2] = sheets[:, None]
    book = punctual3d.Tree(corners.reshape(-1, 3), np.arange(15_000).reshape(-1, 3))
    through = punctual3d.rays(book, [[0.2, 0.3, -1]], [[0, 0, 1]], mode="all")
    assert np.array_equal(through.triangles, np.arange(5000)) and np.array_equal(through.t, sheets + 1)


def test_one_origin_or_direction_stands_for_all(cube):
    origins, directions = beams()
    for mode in ("nearest", "all"):
        many = punctual3d.rays(cube, np.tile(origins[0], (400, 1)), directions, mode=mode)
        assert many == punctual3d.rays(cube, origins[0], directions, mode=mode)
        assert many == punctual3d.rays(cube, origins[:1], directions, mode=mode)
        many = punctual3d.rays(cube, origins, np.tile(directions[0], (400, 1)), mode=mode)
        assert many == punctual3d.rays(cube, origins, directions[0], mode=mode)
        many = punctual3d.rays(cube, origins, ends=np.zeros((400, 3)), mode=mode)
        assert many == punctual3d.rays(cube, origins, ends=[0, 0, 0], mode=mode) and len(many) >= 400
    one = punctual3d.rays(cube, [3, 0.1, 0.2], [-1, 0, 0])
    assert len(one) == 1 and one.t.tolist() == [2.0]
    assert len(punctual3d.rays(cube, np.empty((0, 3)), [1, 0, 0])) == len(punctual3d.rays(cube, [1, 0, 0], [])) == 0


def test_rays_leave_the_lock_to_others(cube):
    origins, directions = (np.tile(array, (1000, 1)) for array in beams())
    done = threading.Event()
    batch = threading.Thread(target=lambda: (punctual3d.rays(cube, origins, directions), done.set()))
    batch.start()
    turns = 0
    while not done.is_set():
        turns += 1
        time.sleep(0.001)
    batch.join()
    assert turns > 10


@pytest.mark.parametrize(
    "arguments, options, text",
    [
        (([[0, 0, 0]],), {}, "directions and ends: one of them"),
        (([[0, 0, 0]], [[1, 0, 0]]), {"ends": [[1, 0, 0]]}, "directions and ends: one of them"),
        (([[0, 0, 0]] * 3, [[1, 0, 0]] * 2), {}, "directions: 2 rows, but origins has 3"),
        (([[0, 0, 0]] * 3,), {"ends": [[1, 0, 0]] * 2}, "ends: 2 rows, but origins has 3"),
        (([[0, 0]], [[1, 0, 0]]), {}, r"origins: shape .*expected \(N, 3\)"),
        (([[0, 0, 0]], [1, 0]), {}, r"directions: shape .*expected \(N, 3\)"),
        (([[0, 0, 0]] * 2, [[1, 0, 0], [0, np.nan, 0]]), {}, "ray 1: y of the ray's direction"),
        (([[0, 0, 0]] * 2, [[1, 0, 0], [0, 0, 0]]), {}, "ray 1: the ray's direction is zero"),
        (([[0, 0, 0]], [[1, 0, 0]]), {"mode": "most"}, 'mode: "most" is none of nearest, any, all'),
        (([[0, 0, 0]], [[1, 0, 0]]), {"t_max": np.nan}, "t_max is NaN"),
        (([[0, 0, 0]], [[1, 0, 0]]), {"budget": 1.0, "work": 1}, "budget and work"),
    ],
)
def test_errors_of_rays(cube, arguments, options, text):
    with pytest.raises(ValueError, match=text):
        punctual3d.rays(cube, *arguments, **options)


def test_a_push_parts_the_surfaces(ball, ring, touching):
    push = punctual3d.penetration(ball, ring, touching, push_only=True)
    assert push.stop == "finished" and push.low == 0 < push.high
    assert punctual3d.collide(ball, ring, push.T).verdict == "separated"
    assert np.linalg.norm(push.direction) == pytest.approx(1) and np.array_equal(push.T[:3, :3], touching[:3, :3])
    assert np.array_equal(push.T[:3, 3], touching[:3, 3] + push.direction * push.high)
    assert push.T[3].tolist() == [0, 0, 0, 1]
    none = punctual3d.penetration(ball, ring, touching, push_only=True, work=10)
    assert (none.direction, none.high, none.T, none.stop) == (None, np.inf, None, "work-limit")
    apart = punctual3d.penetration(ball, ring, push_only=True)
    assert (apart.low, apart.high, apart.direction, apart.T) == (0, 0, None, None)


def test_a_penetration_is_bounded_from_both_sides():
    vertices = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    cube = punctual3d.Tree(vertices, faces, solid="flip")
    small = punctual3d.Tree(np.array(vertices) * 0.1, faces, solid="flip")
    pose = np.eye(4)
    pose[:3, 3] = [1.75, 0.5, 0.25]
    for solid in (False, True):
        depth = punctual3d.penetration(cube, cube, pose, solid=solid, work=10_000_000)
        assert 0.24 < depth.low <= 0.25 <= depth.high < 0.253 and depth.stop == "finished"
        assert np.linalg.norm(depth.direction) == pytest.approx(1) and depth.direction[0] > 0.99
    for limit, deeper in ((0.2, True), (0.3, False), (0.25 - 1e-9, True), (0.25 + 1e-9, False)):
        found = punctual3d.penetration(cube, cube, pose, solid=True, deeper_than=limit)
        assert (found.deeper, found.stop) == (deeper, "finished")
    assert depth.deeper is None
    rough = punctual3d.penetration(cube, cube, pose, absolute_tolerance=10.0, relative_tolerance=0.0)
    assert rough.low <= 0.25 <= rough.high and rough.stop == "finished"
    for name in ("deeper_than", "absolute_tolerance", "relative_tolerance"):
        with pytest.raises(ValueError, match=name):
            punctual3d.penetration(cube, cube, pose, **{name: -1.0})
    less = punctual3d.penetration(cube, cube, pose, work=10)
    assert less.low <= 0.25 <= less.high and less.stop == "work-limit"
    inside = punctual3d.penetration(cube, small, solid=True, work=3_000_000)
    assert 0 < inside.low <= 1.1 <= inside.high
    apart = punctual3d.penetration(cube, small)
    assert (apart.low, apart.high, apart.direction) == (0, 0, None)
    with pytest.raises(ValueError, match="T: "):
        punctual3d.penetration(cube, cube, np.zeros((4, 4)))


def test_what_a_memory_knows_of_the_distance(ball, ring):
    memory, pose = punctual3d.Memory(), np.eye(4)
    assert memory.clearance(ball, ring) == 0
    apart = punctual3d.distance(ball, ring, memory=memory)
    assert 0.9 * apart.low < memory.clearance(ball, ring) <= apart.high
    pose[0, 3] = 0.2
    assert apart.low - 0.21 < memory.clearance(ball, ring, pose) <= punctual3d.distance(ball, ring, pose).high
    pose[0, 3] = 2.0
    assert memory.clearance(ball, ring, pose) == 0
    with pytest.raises(ValueError, match="T: "):
        memory.clearance(ball, ring, np.zeros((4, 4)))
