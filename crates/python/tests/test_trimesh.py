"""Beside trimesh and FCL: the drop-in for the CollisionManager, and plain answers where both are right."""

import copy
import pickle
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import punctual3d
import pytest
from conftest import random_poses
from punctual3d import CollisionManager

trimesh = pytest.importorskip("trimesh")


def at(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


@pytest.fixture
def cube():
    return trimesh.creation.box()


def test_one_to_many(cube):
    manager = CollisionManager()
    manager.add_object("here", cube)
    manager.add_object("right", cube, at(5))
    assert manager.in_collision_single(cube) is True
    hit, names, data = manager.in_collision_single(cube, at(5), return_names=True, return_data=True)
    assert hit is True and names == {"right"} and data
    (contact,) = data
    assert contact.names == {"right", "__external"} and 0 <= contact.index("right") < 12
    # Two cubes in one place: the shortest ways out have the length 1.
    assert contact.depth == pytest.approx(1.0, abs=1e-9) and sorted(abs(contact.normal)) == pytest.approx([0, 0, 1])
    axis = np.argmax(abs(contact.normal))
    assert contact.point[axis] == pytest.approx([5.0, 0.0, 0.0][axis])
    assert manager.in_collision_single(cube, at(-5), return_names=True, return_data=True) == (False, set(), [])
    assert manager.in_collision_single(punctual3d.Tree.from_trimesh(cube), at(4.5), return_names=True) == (
        True,
        {"right"},
    )


def test_inside_one_manager(cube):
    manager = CollisionManager()
    manager.add_object("here", cube)
    manager.add_object("right", cube, at(5))
    assert manager.in_collision_internal() is False
    manager.add_object("also right", cube, at(5))
    hit, names, data = manager.in_collision_internal(return_names=True, return_data=True)
    assert hit is True and names == {("also right", "right")} and len(data) == 1
    manager.set_transform("also right", at(-5))
    assert manager.in_collision_internal() is False
    manager.add_object("also right", cube, at(0.5))
    assert manager.in_collision_internal(return_names=True) == (True, {("also right", "here")})
    manager.remove_object("also right")
    assert manager.in_collision_internal() is False
    for call in (
        manager.remove_object,
        lambda name: manager.set_transform(name, at(1)),
        lambda name: manager.min_distance_internal(name=name),
    ):
        with pytest.raises(ValueError, match="also right not in collision manager!"):
            call("also right")
    with pytest.raises(ValueError, match=r"T: shape \[3, 3\], expected \(4, 4\)"):
        manager.add_object("flat", cube, np.eye(3))
    for transform in (np.diag([2.0, 2, 2, 1]), np.zeros((4, 4)), np.full((4, 4), np.nan)):
        with pytest.raises(ValueError, match="T: "):
            manager.set_transform("here", transform)
    assert manager.in_collision_single(cube, return_names=True) == (True, {"here"})


def test_two_managers(cube):
    left, right = CollisionManager(), CollisionManager()
    left.add_object("a", cube)
    left.add_object("b", cube, at(5))
    right.add_object("a", cube, at(-5))
    assert left.in_collision_other(right) is False
    right.add_object("c", cube, at(5))
    hit, names, data = left.in_collision_other(right, return_names=True, return_data=True)
    assert hit is True and names == {("b", "c")} and all(contact.names == {"b", "c"} for contact in data)


def test_distances(cube):
    manager = CollisionManager()
    assert manager.min_distance_internal() == np.inf
    manager.add_object("right", cube, at(5))
    assert manager.min_distance_single(cube) == pytest.approx(4.0)
    distance, data = manager.min_distance_single(cube, at(5.75), return_data=True)
    assert distance == pytest.approx(-0.25) and data.distance == distance
    assert data.point("right")[0] == pytest.approx(5.5) and data.point("__external")[0] == pytest.approx(5.25)
    manager.add_object("left", cube, at(-5))
    distance, name, data = manager.min_distance_single(cube, at(2), return_name=True, return_data=True)
    assert distance == pytest.approx(2.0) and name == "right" and data.distance == distance
    points = [data.point(one) for one in ("right", "__external")]
    assert points[0][0] == pytest.approx(4.5) and points[1][0] == pytest.approx(2.5)
    assert manager.min_distance_single(cube, at(-2), return_name=True) == (pytest.approx(2.0), "left")
    assert manager.min_distance_internal(return_names=True) == (pytest.approx(9.0), ("left", "right"))
    manager.add_object("near", cube, at(3))
    assert manager.min_distance_internal(return_names=True) == (pytest.approx(1.0), ("near", "right"))
    assert manager.min_distance_internal(name="left", return_names=True) == (pytest.approx(7.0), ("left", "near"))
    other = CollisionManager()
    other.add_object("turned", cube, trimesh.transformations.rotation_matrix(np.pi / 4, [0, 0, 1]) @ at(0))
    distance, names, data = manager.min_distance_other(other, return_names=True, return_data=True)
    assert names == ("near", "turned") and distance == pytest.approx(2.5 - np.sqrt(0.5))
    assert np.linalg.norm(data.point("near") - data.point("turned")) == pytest.approx(distance)


def test_a_scene_of_trimesh(cube, monkeypatch):
    monkeypatch.setattr(trimesh.collision, "CollisionManager", CollisionManager)
    scene = trimesh.Scene()
    for name, x in [("a", 0), ("b", 0.9), ("c", 3)]:
        scene.add_geometry(cube, node_name=name, transform=at(x))
    manager, nodes = trimesh.collision.scene_to_collision(scene)
    assert set(nodes) == {"a", "b", "c"}
    assert manager.in_collision_internal(return_names=True) == (True, {("a", "b")})


def test_objects_come_and_go_under_any_names(cube):
    manager = CollisionManager()
    for name in ("a", ("b", 1), 3):
        manager.add_object(name, cube, at(9))
    manager.remove_object("a")
    manager.add_object("c", cube, at(9.5))
    # Each pair in the order in which its objects were added, whatever became free in between.
    manager.remove_object(3)
    _, data = manager.in_collision_internal(return_data=True)
    (contact,) = data
    assert contact.names == {("b", 1), "c"} and contact.normal[0] < -0.9 and contact.depth == pytest.approx(0.5)
    with pytest.raises(KeyError):
        contact.index("a")
    with pytest.raises(TypeError, match="unhashable"):
        manager.add_object([], cube)
    # A pose that is refused leaves all as it was.
    with pytest.raises(ValueError, match="T: "):
        manager.add_object("c", cube, np.diag([2.0, 2, 2, 1]))
    assert manager.in_collision_internal() is True
    assert manager.in_collision_other(manager, return_names=True)[1] >= {("c", "c")}
    with pytest.raises(TypeError, match="not supported"):
        manager.min_distance_internal(return_names=True)
    assert manager.min_distance_internal() == pytest.approx(-0.5)


def test_a_manager_is_shared_by_threads():
    ball = punctual3d.shapes.icosphere(4)
    manager = CollisionManager()
    for i in range(6):
        manager.add_object(f"{i}", ball, at(1.5 * i))
    expected = {(f"{i}", f"{i + 1}") for i in range(5)}

    def ask(i):
        manager.set_transform("5", at(1.5 * 5 + 0.01 * (i % 3)))
        single = manager.in_collision_single(ball, at(0.1), return_names=True)[1]
        return manager.in_collision_internal(return_names=True)[1], single

    with ThreadPoolExecutor(4) as pool:
        for pairs, single in pool.map(ask, range(40)):
            assert pairs == expected and single == {"0", "1"}


def test_pickles_and_copies_hold_the_objects(cube):
    manager, tree = CollisionManager(), punctual3d.Tree.from_trimesh(cube)
    turned = trimesh.transformations.rotation_matrix(0.3, [1, 2, 3], [0.6, 0.2, 0.3])
    for name, mesh, pose in [("solid", cube, np.eye(4)), (("b", 1), cube, turned), ("surface", tree, at(0.7)), (3, tree, at(9))]:
        manager.add_object(name, mesh, pose)
    manager.remove_object("solid")
    manager.add_object("solid", cube, at(0.1))
    hit, data = manager.in_collision_internal(return_data=True)
    least = manager.min_distance_single(cube, at(11), return_data=True)[1]
    for again in (pickle.loads(pickle.dumps(manager)), copy.copy(manager), copy.deepcopy(manager)):
        assert type(again) is CollisionManager and again.in_collision_internal() is hit is True
        same = again.in_collision_internal(return_data=True)[1]
        assert sorted(contact.point.tolist() for contact in same) == sorted(contact.point.tolist() for contact in data)
        again.remove_object(3)
        assert again.min_distance_single(tree, at(9)) > 7 and manager.min_distance_single(tree, at(9)) == 0
    for contact, one in zip(pickle.loads(pickle.dumps(data)), data):
        assert contact.point.tolist() == one.point.tolist() and contact.names == one.names and contact.normal.tolist() == one.normal.tolist()
        assert all(contact.index(name) == one.index(name) for name in one.names)
        assert getattr(contact, "depth", None) == getattr(one, "depth", None)
    copied = copy.deepcopy(least)
    assert copied.names == least.names == {3, "__external"} and copied.distance == least.distance
    assert copied.point(3).tolist() == least.point(3).tolist() and copied.index(3) == least.index(3)


def test_a_class_that_extends_it_has_arguments_of_its_own(cube):
    class Named(CollisionManager):
        def __init__(self, title, size=1):
            super().__init__()
            self.title, self.size = title, size

    manager = Named("cell", size=2)
    manager.add_object("cube", cube)
    assert (manager.title, manager.size) == ("cell", 2) and manager.in_collision_single(cube) is True
    for arguments, options in [((1,), {}), ((), {"size": 2})]:
        with pytest.raises(TypeError, match="no arguments"):
            CollisionManager(*arguments, **options)


def test_a_manager_without_objects(cube):
    empty, other = CollisionManager(), CollisionManager()
    other.add_object("cube", cube)
    for a, b in [(empty, other), (other, empty), (empty, CollisionManager())]:
        assert a.in_collision_other(b, return_names=True, return_data=True) == (False, set(), [])
        assert a.min_distance_other(b, return_names=True, return_data=True) == (np.inf, None, None)
    assert empty.in_collision_internal(return_names=True, return_data=True) == (False, set(), [])
    assert empty.in_collision_single(cube, return_names=True) == (False, set())
    assert empty.min_distance_single(cube, return_name=True, return_data=True) == (np.inf, None, None)
    # One alone has no partner, and one that is removed none either.
    assert other.in_collision_internal() is False and other.min_distance_internal(return_names=True) == (np.inf, None)
    other.remove_object("cube")
    assert other.in_collision_single(cube) is False and other.min_distance_single(cube) == np.inf
    # A mesh without triangles meets nothing.
    other.add_object("nothing", punctual3d.Tree([], []))
    assert other.in_collision_single(cube) is False and other.min_distance_single(cube) == np.inf


def test_one_meeting_of_very_many_is_found_without_the_others(cube):
    manager, tree = CollisionManager(), punctual3d.Tree.from_trimesh(cube, solid="flip")
    for i in range(3000):
        manager.add_object(i, tree)
    began = time.process_time()
    assert manager.in_collision_internal() is True
    assert time.process_time() - began < 2
    # Until none meets: the one that is asked is not always the first.
    for i in range(3000):
        manager.set_transform(i, at(2 * i))
    assert manager.in_collision_internal() is False
    manager.set_transform(1234, at(2 * 2345 + 0.5))
    assert manager.in_collision_internal() is True
    assert manager.in_collision_internal(return_names=True) == (True, {(1234, 2345)})


@pytest.mark.parametrize("seed", range(4))
def test_random_scenes_are_those_of_fcl(seed):
    pytest.importorskip("fcl")
    random = np.random.default_rng(seed)
    meshes = [trimesh.creation.box([1, 2, 0.5]), trimesh.creation.icosphere(1), trimesh.creation.cylinder(0.6, 2.0)]
    # Half of the scenes have surfaces, too.
    meshes += [trimesh.creation.torus(1.0, 0.3)] * (seed % 2)
    ours, objects, meets = [CollisionManager(), CollisionManager()], [{}, {}], 0
    for step, pose in enumerate(random_poses(40, 2.5 + seed, seed=seed)):
        side, name, mesh = step % 4 // 3, f"{random.integers(12)}", meshes[random.integers(len(meshes))]
        if name in objects[side] and random.random() < 0.3:
            ours[side].remove_object(name)
            del objects[side][name]
        else:
            ours[side].add_object(name, mesh, pose)
            objects[side][name] = mesh, pose
        # One of trimesh that replaces or moves objects still meets them where they were.
        theirs = [trimesh.collision.CollisionManager(), trimesh.collision.CollisionManager()]
        for manager, placed in zip(theirs, objects):
            for one in placed:
                manager.add_object(one, *placed[one])
        asked = random_poses(1, 2.5 + seed, seed=1000 * seed + step)[0]
        said = [
            [
                one.in_collision_internal(return_names=True),
                one.in_collision_internal(),
                one.in_collision_single(mesh, asked, return_names=True),
                one.in_collision_other(other, return_names=True),
            ]
            for one, other in (ours, theirs)
        ]
        assert said[0] == said[1]
        meets += said[0][1]
        # FCL tells the depth of the first that meets, and distances but roughly.
        for (theirs_is, their_names), (least, names, data) in [
            (theirs[0].min_distance_single(mesh, asked, return_name=True), ours[0].min_distance_single(mesh, asked, True, True)),
            (theirs[0].min_distance_other(theirs[1], True), ours[0].min_distance_other(ours[1], True, True))
            if objects[0] and objects[1]
            else ((np.inf, None), ours[0].min_distance_other(ours[1], True, True)),
            (theirs[0].min_distance_internal(None, True), ours[0].min_distance_internal(None, True, True))
            if len(objects[0]) > 1
            else ((np.inf, None), ours[0].min_distance_internal(None, True, True)),
        ]:
            if theirs_is <= 0 or least <= 0:
                assert max(theirs_is, least) <= 1e-4
            elif least < np.inf:
                assert least == pytest.approx(theirs_is, abs=1e-4)
                assert data.names == ({names, "__external"} if isinstance(names, str) else set(names))
                places = [data.point(one) for one in (data.names if len(data.names) == 2 else [])]
                assert not places or np.linalg.norm(places[0] - places[1]) == pytest.approx(least, abs=1e-9)
            else:
                assert names is None and data is None and their_names is None
    assert 0 < meets


# What follows is what trimesh 5.2 tests of its own manager (tests/test_collision.py) and the tests above do not say.


def test_many_spheres_of_a_scene(monkeypatch):
    monkeypatch.setattr(trimesh.collision, "CollisionManager", CollisionManager)
    random = np.random.default_rng(8).random((1000, 4))
    spheres = [trimesh.creation.icosphere(1, row[0]).apply_translation(100 * row[1:]) for row in random]
    manager, nodes = trimesh.collision.scene_to_collision(trimesh.Scene(spheres))
    hit, names = manager.in_collision_internal(return_names=True)
    # Surfaces of balls, which lie up to 8 % below those of spheres.
    apart = np.linalg.norm(random[:, None, 1:] - random[None, :, 1:], axis=-1) * 100
    sums = random[:, None, 0] + random[None, :, 0]
    surely, perhaps = apart < 0.92 * sums, apart <= sums
    above = np.triu_indices(1000, 1)
    assert len(nodes) == 1000 and hit is (len(names) > 0)
    assert 0 < surely[above].sum() <= len(names) <= perhaps[above].sum()


def test_all_names_are_told():
    anvil = trimesh.creation.box(extents=[200, 200, 200])
    outline = [[0, 3.0], [3, 3], [3, 75], [127, 75], [127, 580], [0, 580]]
    probe = punctual3d.Tree.from_trimesh(trimesh.creation.revolve(np.array(outline), sections=32))
    manager, names = CollisionManager(), [f"probe_{i}" for i in range(700)]
    for i, name in enumerate(names):
        pose = np.eye(4)
        pose[:3, 3] = [(i / 700 - 0.5) * 30, 0, -50]
        manager.add_object(name, probe, pose)
    assert manager.in_collision_single(anvil, return_names=True) == (True, set(names))


def test_moved_objects_have_other_distances(cube):
    manager = CollisionManager()
    for name, x in [("cube1", 5), ("cube2", -5), ("cube3", 2)]:
        manager.add_object(name, cube, at(x))
    assert manager.min_distance_internal(return_names=True) == (pytest.approx(2.0), ("cube1", "cube3"))
    manager.set_transform("cube3", at(-2))
    assert manager.min_distance_internal(return_names=True) == (pytest.approx(2.0), ("cube2", "cube3"))
    assert manager.min_distance_internal(name="cube1", return_names=True) == (pytest.approx(6.0), ("cube1", "cube3"))
    left, right = CollisionManager(), CollisionManager()
    left.add_object("cube0", cube)
    left.add_object("cube1", cube, at(5))
    for name, x, expected in [("cube4", -5, 4.0), ("cube5", -2, 1.0)]:
        right.add_object(name, cube, at(x))
        distance, names, data = left.min_distance_other(right, return_names=True, return_data=True)
        assert distance == pytest.approx(expected) and names == ("cube0", name)
        assert np.linalg.norm(data.point("cube0") - data.point(name)) == pytest.approx(distance)


def test_the_same_as_with_fcl():
    pytest.importorskip("fcl")
    meshes = [trimesh.creation.icosphere(3), trimesh.creation.torus(2.0, 0.5)]
    ours, theirs = CollisionManager(), trimesh.collision.CollisionManager()
    poses = random_poses(40, 6.0, seed=3)
    for i, pose in enumerate(poses):
        for manager in (ours, theirs):
            manager.add_object(f"{i}", meshes[i % 2], pose)
    (hit, names), (their_hit, their_names) = (m.in_collision_internal(return_names=True) for m in (ours, theirs))
    assert hit is their_hit is True and names == {tuple(map(str, pair)) for pair in their_names} and len(names) > 20
    for pose in random_poses(20, 12.0, seed=4):
        said = [m.in_collision_single(meshes[0], pose, return_names=True) for m in (ours, theirs)]
        assert said[0] == said[1]
        distances = [m.min_distance_single(meshes[0], pose) for m in (ours, theirs)]
        assert max(distances[0], 0.0) == pytest.approx(max(distances[1], 0.0), abs=1e-5)


def test_contacts_of_surfaces_have_a_point_and_a_normal(cube):
    manager, tree = CollisionManager(), punctual3d.Tree.from_trimesh(cube)
    turned = trimesh.transformations.rotation_matrix(0.3, [1, 2, 3], [0.1, 0.2, 0.3])
    manager.add_object("cube", cube, at(2) @ turned)
    hit, data = manager.in_collision_single(tree, at(2.9), return_data=True)
    assert hit and len(data) > 3
    for contact in data:
        for name, pose in [("cube", at(2) @ turned), ("__external", at(2.9))]:
            corners = cube.vertices[cube.faces[contact.index(name)]] @ pose[:3, :3].T + pose[:3, 3]
            closest = trimesh.triangles.closest_point(corners[None], contact.point[None])
            assert np.allclose(closest, contact.point, atol=1e-12)
        assert np.linalg.norm(contact.normal) == pytest.approx(1)
        with pytest.raises(AttributeError, match="depth: surfaces have none"):
            contact.depth
    # Moved along them, the one of the manager parts from the other.
    assert np.mean([contact.normal[0] for contact in data]) < 0


def test_the_depth_of_solids_is_the_way_that_parts_them():
    meshes = [trimesh.creation.box([1, 2, 3]), trimesh.creation.icosphere(2), trimesh.creation.cylinder(0.7, 2.0)]
    deep = 0
    for i, (pose, other) in enumerate(zip(random_poses(24, 1.6, seed=21), random_poses(24, 0.2, seed=22))):
        a, b = meshes[i % 3], meshes[(i // 3) % 3]
        manager = CollisionManager()
        manager.add_object("a", a, other)
        hit, data = manager.in_collision_single(b, pose, return_data=True)
        if not hit:
            assert manager.min_distance_single(b, pose) >= 0
            continue
        (contact,) = data
        assert manager.min_distance_single(b, pose) == pytest.approx(-contact.depth)
        # Both are convex: along the normal they overlap by about the depth, and a little more parts them.
        along = [(mesh.vertices @ T[:3, :3].T + T[:3, 3]) @ contact.normal for mesh, T in [(a, other), (b, pose)]]
        assert along[1].max() - along[0].min() == pytest.approx(contact.depth, abs=5e-3)
        for way, meets in [(1.0001, False), (0.99, True)]:
            moved = other.copy()
            moved[:3, 3] += way * contact.depth * contact.normal
            manager.set_transform("a", moved)
            assert manager.in_collision_single(b, pose) is meets
        deep += 1
    assert deep > 10


def test_what_lies_inside_a_convex_mesh_meets_it(cube):
    manager = CollisionManager()
    manager.add_object("shell", cube.copy().apply_scale(5.0), at(1))
    assert manager.in_collision_single(cube, at(1), return_names=True) == (True, {"shell"})
    assert manager.min_distance_single(cube, at(1)) == pytest.approx(-3.0)
    manager.add_object("cube", cube, at(1.5))
    assert manager.in_collision_internal(return_names=True) == (True, {("cube", "shell")})
    # Trees are what they were built as.
    small, surface = CollisionManager(), punctual3d.shapes.cuboid([2, 2, 2], 3)
    small.add_object("tree", punctual3d.Tree.from_trimesh(cube, solid="keep"), at(1))
    assert small.in_collision_single(surface, at(1)) is False and small.min_distance_single(surface, at(1)) > 1
    solid = punctual3d.Tree(surface.vertices, surface.faces, solid="flip")
    assert small.in_collision_single(solid, at(1)) is True and small.min_distance_single(solid, at(1)) < -2
    # Beside, through, far; in the hole of what is not convex.
    assert manager.in_collision_single(cube, at(4.5)) is False and manager.in_collision_single(cube, at(3.2)) is True
    assert manager.min_distance_single(cube, at(9)) == pytest.approx(5.0)
    ring = CollisionManager()
    ring.add_object("ring", trimesh.creation.torus(5.0, 1.0))
    assert ring.in_collision_single(cube) is False and ring.min_distance_single(cube) > 3
    # trimesh takes what is not convex for a surface, too.
    dented = trimesh.creation.icosphere(2).apply_scale(5.0)
    dented.vertices[0] *= 0.5
    ring.remove_object("ring")
    ring.add_object("dented", dented)
    assert not dented.is_convex and ring.in_collision_single(cube) is False


def test_contained_convex_meshes_of_fcl(cube):
    pytest.importorskip("fcl")
    for manager in (CollisionManager(), trimesh.collision.CollisionManager()):
        manager.add_object("shell", cube.copy().apply_scale(5.0))
        assert manager.in_collision_single(cube) is True


def test_meshes_in_place_of_trees(cube):
    tree, pose = punctual3d.Tree.from_trimesh(cube), at(0.9)
    for a, b in [(cube, tree), (tree, cube), (cube, cube)]:
        assert punctual3d.collide(a, b, pose, mode="all") == punctual3d.collide(tree, tree, pose, mode="all")
        assert punctual3d.distance(a, b, at(3)) == punctual3d.distance(tree, tree, at(3))
        assert punctual3d.closer_than(a, b, 0.5, at(3)) == punctual3d.closer_than(tree, tree, 0.5, at(3))
        assert punctual3d.contacts(a, b, pose) == punctual3d.contacts(tree, tree, pose)
        moving = {"T": at(3), "velocity": [-3.0, 0, 0]}
        assert punctual3d.motion(a, b, **moving) == punctual3d.motion(tree, tree, **moving)
        assert punctual3d.penetration(a, b, pose, work=10_000) == punctual3d.penetration(tree, tree, pose, work=10_000)
        assert punctual3d.collide_batch(a, b, pose) == punctual3d.collide_batch(tree, tree, pose)
        assert punctual3d.distance_batch(a, b, at(3)) == punctual3d.distance_batch(tree, tree, at(3))
        for kind in (punctual3d.Query, punctual3d.DistanceQuery):
            assert kind(a, b, pose).run() == kind(tree, tree, pose).run()
        assert punctual3d.MotionQuery(a, b, **moving).run() == punctual3d.MotionQuery(tree, tree, **moving).run()
    origins = [[3, 0.1, 0.2], [0, 0, 0]]
    assert punctual3d.rays(cube, origins, [-1, 0, 0]) == punctual3d.rays(tree, origins, [-1, 0, 0])
    scene = punctual3d.Scene()
    scene.insert(cube), scene.set_tree(scene.insert(cube, pose), cube), scene.insert_compound([(cube, at(9))])
    assert scene.step().verdict.tolist() == [1]
    assert punctual3d.collide(cube, cube).view().html
    with pytest.raises(TypeError, match="PointCloud is neither a punctual3d.Tree nor a mesh"):
        punctual3d.collide(trimesh.PointCloud(cube.vertices), tree)


def test_trees_of_trimesh(cube):
    tree = punctual3d.Tree.from_trimesh(cube)
    assert (tree.faces == cube.faces).all() and (tree.vertices == cube.vertices).all()
    assert np.allclose(tree.bounds, cube.bounds)
