"""The interface of trimesh.collision.CollisionManager, answered by punctual3d.

A convex mesh is a solid and another one a surface, as there. Contacts of surfaces have no depth, and surfaces that meet
have the distance 0. The types of its methods are in the stub beside this file.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ._punctual3d import Tree, collide, contacts, distance, penetration

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._punctual3d import _HasMesh

_EXTERNAL = "__external"
_NOTHING = Tree([], [])


class ContactData:
    """Where two objects meet: two triangles of surfaces, or the deepest place of two solids."""

    names: set[str]
    """The names of the two objects."""
    point: NDArray[np.float64]
    """(3,): the middle of the segment in which the triangles meet; of solids, the middle between a vertex of each that lies
    deepest in the other."""
    normal: NDArray[np.float64]
    """(3,), a unit vector: moved along it, the first object parts from the second; of surfaces, if both have their normals
    outside. The first is the one of the manager that was asked, or the one that was added first."""

    def __init__(
        self, names: tuple[str, str], point: Any, normal: Any, triangles: Any, depth: float | None = None
    ) -> None:
        self.names = set(names)
        self.point, self.normal = point, normal
        self._indices = dict(zip(names, triangles))
        self._depth = depth

    @property
    def depth(self) -> float:
        """The least way that parts two solids, which is along the normal. Of surfaces it is not known: raises
        AttributeError."""
        if self._depth is None:
            raise AttributeError("depth: surfaces have none; see punctual3d.manifolds and punctual3d.penetration")
        return self._depth

    def index(self, name: str) -> int:
        """The triangle of the object of this name."""
        return self._indices[name]


class DistanceData:
    """Where two objects are closest; of two solids that meet, where they are deepest."""

    names: set[str]
    """The names of the two objects."""
    distance: float
    """How far apart they are; of surfaces that meet 0, of two solids minus the least way that parts them."""

    def __init__(self, names: tuple[str, str], distance: float, points: Any, triangles: Any) -> None:
        self.names = set(names)
        self.distance = distance
        self._indices = dict(zip(names, triangles))
        self._points = dict(zip(names, points))

    def index(self, name: str) -> int:
        """The closest triangle of the object of this name."""
        return self._indices[name]

    def point(self, name: str) -> NDArray[np.float64]:
        """Its closest point, (3,)."""
        return self._points[name]


class _Placed:
    """A tree where it is."""

    def __init__(self, mesh: Tree | _HasMesh, transform: ArrayLike | None) -> None:
        if not isinstance(mesh, Tree):
            mesh = Tree.from_trimesh(mesh, solid="flip" if getattr(mesh, "is_convex", False) else "no")
        self.tree = mesh
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

    @property
    def is_solid(self) -> bool:
        """Whether its tree is a closed solid."""
        return self.tree.open_edges == 0

    def vertices(self) -> NDArray[np.float64]:
        """Where the vertices are."""
        return self.tree.vertices @ self.transform[:3, :3].T + self.transform[:3, 3]


class _Depth:
    """How deep a solid is in another: the least way that parts them, where, and along which normal of the first."""

    def __init__(self, a: _Placed, b: _Placed) -> None:
        found = penetration(a.tree, b.tree, a.inverse @ b.transform, solid=True, relative_tolerance=1e-6)
        assert found.direction is not None
        self.depth, normal = found.high, -a.transform[:3, :3] @ found.direction
        corners = [one.vertices() for one in (a, b)]
        # The way found is never shorter than the least, which is along the normal of a face if one is that near: exactly so,
        # if the solids are convex.
        for one, sign, where in [(a, -1.0, corners[0]), (b, 1.0, corners[1])]:
            faces = where[one.tree.faces]
            normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
            normals *= sign / np.linalg.norm(normals, axis=1).clip(min=1e-300)[:, None]
            for candidate in np.unique(normals[normals @ normal > 1 - 1e-5], axis=0):
                width = (corners[1] @ candidate).max() - (corners[0] @ candidate).min()
                if width <= self.depth:
                    self.depth, normal = float(width), candidate
        self.normal = normal
        # A deepest vertex of the first, and of those of the second the one nearest to it.
        of_a = corners[0][np.argmin(corners[0] @ normal)]
        heights = corners[1] @ normal
        deepest = corners[1][heights >= heights.max() - 1e-9 * self.depth]
        of_b = deepest[np.argmin(np.linalg.norm(deepest - of_a, axis=1))]
        self.points = np.array([of_a, of_b])
        self.triangles = [
            int(np.argmin(np.linalg.norm(where[one.tree.faces] - point, axis=2).min(axis=1)))
            for one, where, point in zip((a, b), corners, self.points)
        ]


class CollisionManager:
    """Objects by name: which of them meet, or how far apart they are.

    A mesh is a trimesh.Trimesh or a punctual3d.Tree; a tree spares the build where a mesh is asked about again and
    again.

    A mesh that trimesh takes for convex is a solid: an object inside collides with it, and two of them have a depth. Others
    are surfaces, without an inside. A tree is what it was built as.
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


def _collide(
    candidates: _Candidates, return_all: bool, return_data: bool
) -> tuple[bool, set[tuple[str, str]], list[ContactData]]:
    """Whether a pair meets; if all are wanted, the names of those that do, and ContactData of their triangles."""
    found: set[tuple[str, str]] = set()
    data: list[ContactData] = []
    for _, names, a, b in candidates.pairs(np.argwhere(candidates.gaps == 0)):
        pose = a.inverse @ b.transform
        if not collide(a.tree, b.tree, pose):
            continue
        if not return_all:
            return True, found, data
        found.add(names)
        if return_data and a.is_solid and b.is_solid:
            deep = _Depth(a, b)
            data.append(ContactData(names, deep.points.mean(axis=0), deep.normal, deep.triangles, deep.depth))
        elif return_data:
            where = contacts(a.tree, b.tree, pose)
            points = where.points[:, 0] @ a.transform[:3, :3].T + a.transform[:3, 3]
            rows = zip(points, where.normals @ a.transform[:3, :3].T, where.triangles.tolist())
            data += [ContactData(names, *row) for row in rows]
    return bool(found), found, data


def _distance(candidates: _Candidates) -> tuple[float, tuple[str, str] | None, DistanceData | None]:
    """The least distance, infinite without a pair; the names of the closest pair, and where it is closest."""
    least, closest, data = np.inf, None, None
    order = np.stack(np.unravel_index(np.argsort(candidates.gaps, axis=None), candidates.gaps.shape), axis=1)
    for gap, names, a, b in candidates.pairs(order):
        # Of pairs that meet, another may be deeper.
        if gap >= least and gap > 0:
            break
        found = distance(a.tree, b.tree, a.inverse @ b.transform)
        if found.high == 0 and a.is_solid and b.is_solid:
            deep = _Depth(a, b)
            high, points, triangles = -deep.depth, deep.points, deep.triangles
        elif found.points is None or found.triangles is None:
            continue
        else:
            high, triangles = found.high, list(found.triangles)
            points = found.points @ a.transform[:3, :3].T + a.transform[:3, 3]
        if high < least:
            least, closest, data = high, names, DistanceData(names, high, points, triangles)
    return least, closest, data
