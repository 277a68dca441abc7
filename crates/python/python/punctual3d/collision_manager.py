"""The interface of trimesh.collision.CollisionManager, answered by punctual3d.

Differences: a mesh is a surface, whether it is convex or not (`CollisionManager`); contacts have no depth; and the
distance of objects that meet is 0. The types of its methods are in the stub beside this file.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ._punctual3d import Contacts, Distance, Tree, collide, contacts, distance, rays

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._punctual3d import _HasMesh

_EXTERNAL = "__external"
_NOTHING = Tree([], [])
# Of rays that tell whether a point is inside: along no axis, to pass edges by.
_DIRECTIONS = np.array([[0.29, 0.51, 0.81], [-0.29, -0.51, -0.81]])


class ContainedWarning(UserWarning):
    """An object lies inside another without touching it. Their surfaces do not meet, so the answer is that they do not
    collide; trimesh's manager says that they do if the outer one is convex."""


class ContactData:
    """Two triangles that meet, one of each of two objects."""

    names: set[str]
    """The names of the two objects."""
    point: NDArray[np.float64]
    """(3,): the middle of the segment in which the triangles meet."""
    normal: NDArray[np.float64]
    """(3,), a unit vector: moved along it, the first object parts from the second, if both have their normals outside.
    The first is the one of the manager that was asked, or the one that was added first."""

    def __init__(self, names: tuple[str, str], found: Contacts, row: int, frame: NDArray[np.float64]) -> None:
        self.names = set(names)
        self.point = frame[:3, :3] @ found.points[row, 0] + frame[:3, 3]
        self.normal = frame[:3, :3] @ found.normals[row]
        self._indices = dict(zip(names, found.triangles[row].tolist()))

    @property
    def depth(self) -> float:
        """Not known: raises AttributeError. A surface has no depth; `penetration` tells how far two objects are to be
        moved apart."""
        raise AttributeError("depth: punctual3d knows surfaces, which have none; see punctual3d.penetration")

    def index(self, name: str) -> int:
        """The triangle of the object of this name."""
        return self._indices[name]


class DistanceData:
    """Where two objects are closest."""

    names: set[str]
    """The names of the two objects."""
    distance: float
    """How far apart they are; 0 if they meet."""

    def __init__(self, names: tuple[str, str], result: Distance, frame: NDArray[np.float64]) -> None:
        self.names = set(names)
        self.distance = result.high
        assert result.triangles is not None and result.points is not None
        self._indices = dict(zip(names, result.triangles))
        self._points = dict(zip(names, result.points @ frame[:3, :3].T + frame[:3, 3]))

    def index(self, name: str) -> int:
        """The closest triangle of the object of this name."""
        return self._indices[name]

    def point(self, name: str) -> NDArray[np.float64]:
        """Its closest point, (3,)."""
        return self._points[name]


class _Placed:
    """A tree where it is."""

    def __init__(self, mesh: Tree | _HasMesh, transform: ArrayLike | None) -> None:
        self.mesh = mesh
        self.tree = mesh if isinstance(mesh, Tree) else Tree.from_trimesh(mesh)
        self.place(transform)

    def place(self, given: ArrayLike | None) -> None:
        transform = np.eye(4) if given is None else np.array(given, dtype=np.float64)
        if transform.shape != (4, 4):
            raise ValueError(f"transform must be (4,4)! Its shape is {transform.shape}")
        # Raises if it is not rigid: of two that are not, the relative one could be.
        collide(_NOTHING, _NOTHING, transform)
        self.transform = transform
        self.inverse = np.linalg.inv(transform)
        # The box of the box, a little larger than rounding.
        low, high = np.zeros((2, 3)) if self.tree.bounds is None else self.tree.bounds
        center = transform[:3, :3] @ ((low + high) / 2) + transform[:3, 3]
        half = np.abs(transform[:3, :3]) @ ((high - low) / 2)
        half += 1e-12 * (np.abs(center) + half)
        self.bounds = np.array([center - half, center + half])

    @cached_property
    def corner(self) -> NDArray[np.float64]:
        """A corner of a triangle, in the frame of the mesh."""
        return self.tree.vertices[self.tree.faces[0, 0]]

    def contains(self, inner: _Placed) -> bool:
        """Whether a corner of another mesh, if its box is inside of the box of this one, is inside of this one: rays
        leave it more often than they enter it."""
        fits = (self.bounds[0] <= inner.bounds[0]).all() and (inner.bounds[1] <= self.bounds[1]).all()
        if not fits or len(inner.tree) == 0:
            return False
        there = self.inverse @ inner.transform
        hits = rays(self.tree, there[:3, :3] @ inner.corner + there[:3, 3], _DIRECTIONS, mode="all")
        return all((hits.rays == ray).sum() % 2 == 1 for ray in range(len(_DIRECTIONS)))


class CollisionManager:
    """Objects by name: which of them meet, or how far apart they are.

    A mesh is a trimesh.Trimesh or a punctual3d.Tree; a tree spares the build where a mesh is asked about again and
    again.

    A mesh is a surface, without an inside. An object that lies inside another and does not touch it does not collide
    with it and has a distance from it. trimesh's manager takes convex meshes for solids, and says that they collide.
    Where a pair is found apart, and a corner of one is inside of the other, ContainedWarning names both; not of an
    outer mesh that trimesh does not take for convex or that has holes, nor where the answer is found before the pair is
    asked about.
    """

    def __init__(self) -> None:
        self._objects: dict[str, _Placed] = {}

    def add_object(self, name: str, mesh: Tree | _HasMesh, transform: ArrayLike | None = None) -> None:
        """Adds an object, or replaces that of the same name; transform: (4, 4), rigid."""
        self._objects[name] = _Placed(mesh, transform)

    def remove_object(self, name: str) -> None:
        """Removes an object. Raises ValueError if there is none of this name."""
        self._get(name)
        del self._objects[name]

    def set_transform(self, name: str, transform: ArrayLike) -> None:
        """Moves an object. Raises ValueError if there is none of this name."""
        self._get(name).place(transform)

    def in_collision_single(
        self,
        mesh: Tree | _HasMesh,
        transform: ArrayLike | None = None,
        return_names: bool = False,
        return_data: bool = False,
    ) -> Any:
        """Whether an object meets any of those here; then the set of their names, and a list of ContactData."""
        other = {_EXTERNAL: _Placed(mesh, transform)}
        hit, names, data = _collide(_Candidates(self._objects, other), return_names or return_data, return_data)
        return _pack(hit, (return_names, {name for name, _ in names}), (return_data, data))

    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """Whether any two objects meet; then the set of their names, each pair sorted, and a list of ContactData."""
        hit, names, data = _collide(_within(self._objects), return_names or return_data, return_data)
        return _pack(hit, (return_names, {tuple(sorted(pair)) for pair in names}), (return_data, data))

    def in_collision_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """Whether any object meets one of another manager; then the set of their names, and a list of ContactData."""
        candidates = _Candidates(self._objects, other_manager._objects)
        hit, names, data = _collide(candidates, return_names or return_data, return_data)
        return _pack(hit, (return_names, names), (return_data, data))

    def min_distance_single(
        self,
        mesh: Tree | _HasMesh,
        transform: ArrayLike | None = None,
        return_name: bool = False,
        return_data: bool = False,
    ) -> Any:
        """The distance of an object to the closest of those here; then its name, and DistanceData."""
        least, names, data = _distance(_Candidates(self._objects, {_EXTERNAL: _Placed(mesh, transform)}))
        return _pack(least, (return_name, names and names[0]), (return_data, data))

    def min_distance_internal(
        self, name: str | None = None, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """The least distance of two objects, or of the named one to the others; then their names, and DistanceData."""
        if name is None:
            candidates = _within(self._objects)
        else:
            others = {other: item for other, item in self._objects.items() if other != name}
            candidates = _Candidates({name: self._get(name)}, others)
        least, names, data = _distance(candidates)
        return _pack(least, (return_names, names and tuple(sorted(names))), (return_data, data))

    def min_distance_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """The least distance to an object of another manager; then the pair of names, and DistanceData."""
        least, names, data = _distance(_Candidates(self._objects, other_manager._objects))
        return _pack(least, (return_names, names), (return_data, data))

    def _get(self, name: str) -> _Placed:
        if name not in self._objects:
            raise ValueError(f"{name} not in collision manager!")
        return self._objects[name]


def _pack(answer: Any, *parts: tuple[bool, Any]) -> Any:
    asked = tuple(part for wanted, part in parts if wanted)
    return (answer, *asked) if asked else answer


class _Candidates:
    """Two lists of named objects, and how far apart their boxes are, (N, M)."""

    def __init__(self, left: Mapping[str, _Placed], right: Mapping[str, _Placed]) -> None:
        self.left, self.right = list(left.items()), list(right.items())
        a, b = (np.array([item.bounds for _, item in side]).reshape(-1, 2, 3) for side in (self.left, self.right))
        gaps = np.maximum(a[:, None, 0] - b[None, :, 1], b[None, :, 0] - a[:, None, 1]).clip(min=0)
        self.gaps: NDArray[np.float64] = np.linalg.norm(gaps, axis=-1)

    def pairs(self, places: Iterable[Any]) -> Iterable[tuple[float, tuple[str, str], _Placed, _Placed]]:
        """The gaps, names and objects at these places."""
        for i, j in places:
            (name_a, a), (name_b, b) = self.left[i], self.right[j]
            yield self.gaps[i, j], (name_a, name_b), a, b


def _within(objects: Mapping[str, _Placed]) -> _Candidates:
    """The pairs of one set of objects, each once: the others are infinitely far apart."""
    candidates = _Candidates(objects, objects)
    candidates.gaps[np.tri(len(objects), dtype=bool)] = np.inf
    return candidates


def _warn_of_contained(names: tuple[str, str], a: _Placed, b: _Placed) -> None:
    for outer, inner, (outer_name, inner_name) in [(a, b, names), (b, a, names[::-1])]:
        # What is known not to be convex is a surface for trimesh, too.
        if getattr(outer.mesh, "is_convex", True) and outer.contains(inner):
            text = f"{inner_name!r} lies inside {outer_name!r} without touching it: their surfaces do not meet"
            # The caller of the manager's method, which called what called this.
            warnings.warn(text, ContainedWarning, stacklevel=4)


def _collide(
    candidates: _Candidates, return_all: bool, return_data: bool
) -> tuple[bool, set[tuple[str, str]], list[ContactData]]:
    """Whether a pair meets; if all are wanted, the names of those that do, and ContactData of their triangles."""
    found: set[tuple[str, str]] = set()
    data: list[ContactData] = []
    for _, names, a, b in candidates.pairs(np.argwhere(candidates.gaps == 0)):
        pose = a.inverse @ b.transform
        if not collide(a.tree, b.tree, pose):
            _warn_of_contained(names, a, b)
            continue
        if not return_all:
            return True, found, data
        found.add(names)
        if return_data:
            where = contacts(a.tree, b.tree, pose)
            data += [ContactData(names, where, row, a.transform) for row in range(len(where))]
    return bool(found), found, data


def _distance(candidates: _Candidates) -> tuple[float, tuple[str, str] | None, DistanceData | None]:
    """The least distance, infinite without a pair; the names of the closest pair, and where it is closest."""
    least, closest, data = np.inf, None, None
    order = np.stack(np.unravel_index(np.argsort(candidates.gaps, axis=None), candidates.gaps.shape), axis=1)
    for gap, names, a, b in candidates.pairs(order):
        if gap >= least:
            break
        found = distance(a.tree, b.tree, a.inverse @ b.transform)
        if found.high > 0:
            _warn_of_contained(names, a, b)
        if found.high < least:
            least, closest, data = found.high, names, DistanceData(names, found, a.transform)
    return least, closest, data
