"""Every call, with arrays, lists and scalars of NumPy: test_types.py has it checked, and runs it."""

from __future__ import annotations

import pathlib
import pickle
from typing import TYPE_CHECKING, Literal, Union

import numpy as np
import punctual3d as p
from numpy.typing import NDArray

if TYPE_CHECKING:
    from typing_extensions import assert_type
else:

    def assert_type(value, _):
        return value


class Mesh:
    """As trimesh.Trimesh: something with vertices and faces."""

    def __init__(self, tree: p.Tree) -> None:
        self.vertices = tree.vertices
        self.faces = tree.faces


third, two, yes = np.float32(1 / 3), np.int64(2), np.bool_(True)
point, flat, pose = np.array([0.0, 0.0, 1.0]), [0.0, 0.0, 1.0], np.eye(4)
rows: list[list[float]] = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]

# Trees.
ball, ring = p.shapes.icosphere(two), p.shapes.torus(2, np.float64(0.5), 24)
p.shapes.cuboid(point + 1, 2), p.shapes.cuboid([1, 2, 3], two), p.shapes.torus_knot(2, 3, third, np.uint8(64))
mesh = Mesh(ball)
tree = p.Tree(ball.vertices.astype(np.float32), ball.faces.tolist(), effort="fast", extremes=True)
p.Tree.from_trimesh(mesh, effort="fast"), p.Tree.from_bytes(tree.to_bytes())
tree.refit(tree.vertices.tolist())
assert_type(tree.faces, NDArray[np.uint32])
assert_type(tree.bounds, Union[NDArray[np.float64], None])
assert tree == tree and len({tree: 1}) == 1 and tree.nbytes + tree.depth + len(tree) > 0

# Do they meet?
memory = p.Memory()
hit = p.collide(ball, ring, pose, mode="all", budget=np.float64(1.0), memory=memory, prior=third)
assert_type(hit.verdict, Literal["intersecting", "contained", "separated", "undecided"])
assert_type(hit.witness, Union[tuple[int, int], None])
p.collide(mesh, ring, rows, work=np.uint32(10_000)), p.collide(ball, mesh, work=two)
query = p.Query(ball, mesh, rows, mode="all", prior=third)
part = query.run(work=two)
if part.stop == "work-limit":
    query.resume(budget=1), query.estimate(memory=memory).remaining.time.p50
query.certificate().boxes, query.predict().bv_tests.p90, memory.clearance(ball, ring, rows)
batch = p.collide_batch(ball, mesh, np.stack([pose, pose]), work=two, threads=two)
p.collide_batch(mesh, ring, rows), p.collide_batch(ball, ring, [rows, rows])
assert_type(batch.verdict, NDArray[np.int8])

# How far apart?
far = p.distance(ball, mesh, rows, absolute_tolerance=third, margins=point[:2], budget=1, leave_contact_open=yes)
p.distance(mesh, ring, relative_tolerance=1, margins=[third, third])
assert_type(far.points, Union[NDArray[np.float64], None])
p.closer_than(ball, mesh, third, rows, margins=(0.1, 0.2), work=two)
distance = p.DistanceQuery(mesh, ring, pose, closer_than=third, margins=point[:2], absolute_tolerance=1)
distance.run(budget=third), distance.predict(), distance.estimate().distance.p10, distance.certificate()
apart = p.distance_batch(ball, mesh, [rows], closer_than=two, margins=[0, 0], threads=two)
assert_type(apart.points, NDArray[np.float64])

# Where, when, which way?
near = p.contacts(mesh, ring, rows, margin=third, limit=two, budget=1)
assert_type(near.face_normals, NDArray[np.float64])
way = p.motion(ball, mesh, velocity=point, turn=flat, point=np.zeros(3), margins=[0, 0], tolerance=third)
p.motion(mesh, ring, rows, to=pose, time_tolerance=third, memory=memory), p.motion(ball, ring, velocity=[two, two, two])
assert_type(way.touching_at, Union[float, None])
moving = p.MotionQuery(ball, mesh, velocity=point.astype(np.float32), turn=(0, 0, 1), margins=point[:2])
moving.run(work=two), moving.predict(), moving.run(work=two).remaining, moving.certificate()
push = p.penetration(ball, mesh, pose, push_only=True, work=10_000)
assert_type(push.T, Union[NDArray[np.float64], None])
depth = p.penetration(ball, mesh, pose, solid=False, relative_tolerance=third, work=two)
assert_type(depth.direction, Union[NDArray[np.float64], None])
hits = p.rays(mesh, np.zeros((3, 3)), point, t_min=third, t_max=two, mode="all")
p.rays(ball, flat, [flat, flat]), p.rays(ball, [flat, flat], ends=np.ones((2, 3), np.float32), budget=third)
assert_type(hits.triangles, NDArray[np.int64])

# Many bodies.
scene = p.Scene(mode="any", threads=two)
body = scene.insert(mesh, rows, fixed=yes, groups=two, mask=np.uint32(3), importance=third, margin=third)
other = scene.insert(ball, pose, groups=3)
scene.set_pose(np.uint64(body), pose), scene.set_tree(body, mesh), scene.set_margin(other, third)
scene.set_poses(np.array([body, other], dtype=np.uint64), [rows, rows]), scene.set_poses([other], pose)
scene.set_motion(other, rows, velocity=point, turn=flat, point=(0, 0, 0)), scene.set_motion(other, pose, to=rows)
whole = scene.insert_compound([(mesh, rows), (ball, pose)], pose, margin=third)
scene.set_compound_pose(whole, rows), scene.set_compound_motion(whole, pose, velocity=point, turn=flat, point=point)
assert scene.compound_of(scene.parts(whole)[0]) == whole
scene.measure(body, other, third), scene.track_contacts(), scene.find_contacts(), scene.find_contacts(body, other)
scene.find_contacts(groups=1, mask=np.uint32(2)), scene.stop_finding_contacts(groups=1, mask=2)
group = scene.measure_groups([body], np.array([other]), third)
scene.set_question_importance("distance", third), scene.set_look_ahead(third)
assert_type(scene.may_move(body, third, sink=two), float)
report = scene.step(1, work=None)
assert_type(report.bodies, NDArray[np.uint64])
assert_type(report.contacts, p.BodyContacts)
scene.contact_points(body, other).normals, scene.certificate(body, other)
scene.cast(point * 9, [0, 0, -1], t_max=two, groups=two, work=1000)
scene.cast(flat, end=point * 2, mode="any", budget=third)
assert_type(scene.cast_rays([flat, flat], point, mode="any", body=body, work=two).t, NDArray[np.float64])
fall = scene.cast_shape(mesh, rows, velocity=flat, margin=third, body=other)
assert_type(fall.touching_at, Union[float, None])
assert_type(scene.overlap(point, margin=two, mode="any").undecided, NDArray[np.uint64])
assert_type(scene.closest(ball, pose, within=third).body, Union[int, None])
scene.set_name(body, "lamp"), scene.set_group(body, "arm"), scene.set_group(body, None), scene.ignore_groups("a", "b", yes)
assert_type(scene.name(body), str)
scene.stop_measuring(body, other), scene.stop_measuring_groups(group), scene.stop_finding_contacts(body, other)
scene.remove_compound(whole), scene.remove(np.uint64(body))

# Answers.
assert pickle.loads(pickle.dumps(hit)) == hit and hash(hit) == hash(hit)
assert_type(hit.view().html, str)


def save(path: pathlib.Path) -> None:
    hit.view(path).save(str(path))


# In place of trimesh's.
manager = p.CollisionManager()
manager.add_object("ball", ball, rows), manager.add_object("mesh", mesh), manager.set_transform("mesh", pose)
assert_type(manager.in_collision_internal(), bool)
met, names = manager.in_collision_internal(return_names=True)
assert_type(names, set[tuple[str, str]])
met, names, data = manager.in_collision_internal(return_names=True, return_data=True)
for contact in data:
    assert_type(contact.point, NDArray[np.float64])
    contact.index("ball") + contact.normal[0]
_, only_data = manager.in_collision_single(mesh, rows, return_data=True)
assert_type(only_data, list[p.ContactData])
least, name, place = manager.min_distance_single(ring, return_name=True, return_data=True)
assert_type(name, Union[str, None])
if place is not None:
    place.point("ball") + place.distance
manager.min_distance_internal("ball", return_names=True), manager.min_distance_other(p.CollisionManager())
manager.in_collision_other(p.CollisionManager(), return_names=True)[1], manager.remove_object("ball")
