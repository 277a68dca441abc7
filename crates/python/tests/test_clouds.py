"""Point clouds and radii: arrays and files in, the answers of balls out."""

import pickle

import numpy as np
import punctual3d
import pytest

PLACE = np.eye(4)
PLACE[:3, 3] = [0.3, -0.2, 0.1]


def points(count=500, seed=1):
    return np.random.default_rng(seed).uniform(-2, 2, (count, 3))


@pytest.mark.parametrize("dtype", ["f2", "f4", "f8", ">f8", "i4"])
def test_any_type_of_points(dtype):
    given = points().astype(dtype)
    for layout in (given, np.asfortranarray(given), given[::-1][::-1], given.tolist()):
        cloud = punctual3d.Tree.from_points(layout)
        assert cloud.is_cloud and len(cloud) == 500 and cloud.radius == 0
        assert (cloud.vertices == given).all() and cloud.faces.shape == (0, 3)
        assert (cloud.bounds == [given.min(axis=0), given.max(axis=0)]).all()
    assert repr(cloud) == "<punctual3d.Tree of 500 points>"


@pytest.mark.parametrize("radius", [0, 0.01, 0.3])
def test_a_point_is_a_triangle_without_extent(ball, ring, poses, radius):
    cloud = punctual3d.Tree.from_points(points(), radius)
    same = punctual3d.Tree(points(), np.arange(500)[:, None].repeat(3, axis=1))
    for T in poses[:20]:
        T = T.copy()
        T[:3, 3] *= 2
        for tree in (ball, ring):
            found, plain = punctual3d.distance(cloud, tree, T), punctual3d.distance(same, tree, T)
            assert found.low <= max(plain.high - radius, 0) and max(plain.low - radius, 0) <= found.high
            assert found.high - found.low < 1e-4
            assert bool(punctual3d.collide(cloud, tree, T)) == (found.high == 0)
        if found.low > 0:
            assert found.triangles[0] == plain.triangles[0]


def test_two_balls_are_as_far_apart_as_their_radii_say():
    pea = punctual3d.Tree.from_points([[0, 0, 0]])
    for a, b, x in [(0.5, 0.25, 3.0), (1.0, 1.0, 2.5), (0.0, 2.0, 2.0), (1.5, 1.0, 2.0)]:
        T = np.eye(4)
        T[0, 3] = x
        balls = pea.with_radius(a), pea.with_radius(9).with_radius(b)
        found = punctual3d.distance(*balls, T)
        assert found.low <= max(x - a - b, 0) <= found.high <= found.low + 1e-5
        assert bool(punctual3d.collide(*balls, T)) == (x <= a + b)
    assert pea.radius == 0 and balls[1].radius == 1.0 and repr(balls[0]) == "<punctual3d.Tree of 1 points, radius 1.5>"


def test_a_radius_thickens_a_mesh(ball, ring):
    before, after = punctual3d.distance(ball, ring), punctual3d.distance(ball.with_radius(0.1), ring)
    assert abs(before.high - after.high - 0.1) < 1e-5 and ball.with_radius(0.1) != ball
    assert ball.with_radius(0) == ball


def test_bytes_pickles_scales_and_refits_keep_radii():
    cloud = punctual3d.Tree.from_points(points(), 0.25)
    for same in (punctual3d.Tree.from_bytes(cloud.to_bytes()), pickle.loads(pickle.dumps(cloud))):
        assert same == cloud and same.is_cloud and same.radius == 0.25
    assert cloud.scaled((2, 2, 2)).radius == 0.5
    cloud.refit(points(seed=2))
    assert cloud.radius == 0.25 and (cloud.vertices == points(seed=2)).all()
    with pytest.raises(ValueError):
        cloud.refit(points(499))


def test_clouds_are_bodies_of_scenes(ball):
    for radius, hits in ((0.0, False), (0.2, True)):
        scene = punctual3d.Scene()
        scene.insert(punctual3d.Tree.from_points([[0, 0, 1.1], [4, 4, 4]], radius))
        scene.insert(ball)
        assert (scene.step().verdict > 0).any() == hits


@pytest.mark.parametrize("ending", [".npy", ".xyz", ".pcd", ".csv", ".xyz.gz"])
def test_files_of_points(tmp_path, ending):
    file, given = tmp_path / f"scan{ending}", points().astype("f4")
    if ending == ".npy":
        np.save(file, given)
    elif ending == ".pcd":
        head = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        head += "WIDTH 500\nHEIGHT 1\nPOINTS 500\nDATA binary\n"
        file.write_bytes(head.encode() + given.tobytes())
    else:
        np.savetxt(file, given, delimiter="," if ending == ".csv" else " ")
    cloud = punctual3d.Tree.load(file)
    assert cloud.is_cloud and (cloud.vertices == given).all()
    assert cloud == punctual3d.Tree.from_points(given, effort="normal")
    assert punctual3d.Tree.load(file, effort="fast") == punctual3d.Tree.from_points(given)
    assert (punctual3d.Tree.load(file, scale=(1, 1, -2)).vertices == given * np.float32([1, 1, -2])).all()


def test_no_points():
    nothing = punctual3d.Tree.from_points([], 1)
    assert len(nothing) == 0 and nothing.is_cloud and nothing.bounds is None
    assert punctual3d.distance(nothing, nothing).low == np.inf and not punctual3d.collide(nothing, nothing)


@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_faults_name_the_row(dtype):
    given = points().astype(dtype)
    given[7, 1] = np.nan
    with pytest.raises(ValueError, match="point 7 is not finite along axis 1"):
        punctual3d.Tree.from_points(given)
    for wrong in (given[:, :2], given[0], given[None]):
        with pytest.raises(ValueError, match=r"points: shape .*, expected \(N, 3\)"):
            punctual3d.Tree.from_points(wrong)
    cloud = punctual3d.Tree.from_points(points())
    for radius in (-0.1, np.nan, np.inf, 1e302):
        with pytest.raises(ValueError, match="radius"):
            punctual3d.Tree.from_points(points(), radius)
        with pytest.raises(ValueError, match="radius"):
            cloud.with_radius(radius)
    with pytest.raises(TypeError, match="points: dtype"):
        punctual3d.Tree.from_points(np.zeros((2, 3)) * 1j)
    with pytest.raises(ValueError, match="solid"):
        cloud.contains([[0, 0, 0]])


@pytest.mark.parametrize("distance, radius", [(0.05, 0), (0.3, 0), (0.2, 0.1), (0, 0.2), (np.inf, 0)])
def test_points_within_a_distance_are_told_once(ring, distance, radius):
    cloud = punctual3d.Tree.from_points(points(3000), radius)
    # The frame of the cloud is that of the ring moved back.
    near = np.abs(ring.closest_points(points(3000) - PLACE[:3, 3])[1])
    found = cloud.points_within(ring, PLACE, distance=distance)
    reach = distance + radius
    assert found.dtype == np.int64 and (np.diff(found) > 0).all()
    sure = np.abs(near - reach) > 1e-9
    assert (np.isin(np.arange(3000), found) == (near <= reach))[sure].all() and len(found) > 10
    assert cloud.points_within(cloud, distance=0.0).tolist() == list(range(3000))


def test_points_within_that_are_refused(ball, ring):
    with pytest.raises(ValueError, match="cloud"):
        ball.points_within(ring)
    for distance in (-1, np.nan):
        with pytest.raises(ValueError, match="distance"):
            punctual3d.Tree.from_points(points()).points_within(ring, distance=distance)


def test_either_effort_finds_the_same_points(ring):
    fast, normal = (punctual3d.Tree.from_points(points(2000), effort=effort) for effort in ("fast", "normal"))
    found = [cloud.points_within(ring, PLACE, distance=0.1) for cloud in (fast, normal)]
    assert len(found[0]) > 10 and (found[0] == found[1]).all()
    with pytest.raises(ValueError, match="effort: .best. is none of fast, normal"):
        punctual3d.Tree.from_points(points(), effort="best")


def test_depth_images_become_the_points_of_their_pixels():
    depths = np.full((24, 32), 2000.0, np.float32)
    depths[3, 5], depths[4, 6], depths[0, 0], depths[1, 1] = 0.0, np.nan, np.inf, -1.0
    fx, fy, cx, cy = 30.0, 28.0, 15.5, 11.5
    cloud = punctual3d.Tree.from_depth(depths, (fx, fy, cx, cy), scale=0.001, radius=0.01)
    rows, columns = np.nonzero((depths > 0) & np.isfinite(depths))
    expected = np.stack([2.0 * (columns - cx) / fx, 2.0 * (rows - cy) / fy, np.full(len(rows), 2.0)], axis=1)
    assert cloud.is_cloud and cloud.radius == 0.01 and len(expected) == depths.size - 4
    same = punctual3d.Tree.from_points(expected.astype(np.float32), 0.01)
    assert cloud.to_bytes() == same.to_bytes()
    for wrong, name in (((0, 28, 15, 11), "focal"), ((30, 28, np.nan, 11), "center"), ((30, 28, 15), "intrinsics")):
        with pytest.raises(ValueError, match=name):
            punctual3d.Tree.from_depth(depths, wrong)
    with pytest.raises(ValueError, match="scale"):
        punctual3d.Tree.from_depth(depths, (fx, fy, cx, cy), scale=0.0)


def test_a_window_keeps_the_newest_points(ring):
    window, frames = punctual3d.PointWindow(250, 4.0), [points(100, seed) for seed in range(5)]
    inserted = np.concatenate(frames).astype(np.float32)
    for number, frame in enumerate(frames):
        before = window.tree
        window.insert(frame)
        assert not window.advance(work=3000) and len(window.tree.vertices) == len(before.vertices)
        assert window.advance(1.0) and window.advance()
        numbers, count = window.numbers, 100 * (number + 1)
        assert sorted(numbers) == list(range(max(0, count - 250), count))
        assert (window.tree.vertices == inserted[numbers]).all()
        near = window.tree.points_within(ring, distance=0.3)
        fresh = punctual3d.Tree.from_points(inserted[max(0, count - 250) : count]).points_within(ring, distance=0.3)
        assert sorted(numbers[near]) == (fresh + max(0, count - 250)).tolist()
    with pytest.raises(ValueError, match="1"):
        window.insert([[0, 0, 0], [0, np.nan, 0]])
    with pytest.raises(ValueError, match="reach"):
        punctual3d.PointWindow(250, 0.0)
