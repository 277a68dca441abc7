"""The interface of trimesh.collision.CollisionManager, answered by punctual3d.

Differences: contacts have no point, normal or depth, only the triangles; and the distance of objects that meet is 0.
"""

import numpy as np

from ._punctual3d import Tree, collide, distance

_EXTERNAL = "__external"
_NOTHING = Tree([], [])


class ContactData:
    """Two triangles that meet, one of each of two objects."""

    def __init__(self, names, triangles):
        self.names = set(names)
        self._indices = dict(zip(names, triangles))

    def index(self, name):
        """The triangle of the object of this name."""
        return self._indices[name]


class DistanceData:
    """Where two objects are closest."""

    def __init__(self, names, result, frame):
        self.names = set(names)
        self.distance = result.high
        self._indices = dict(zip(names, result.triangles))
        self._points = dict(zip(names, result.points @ frame[:3, :3].T + frame[:3, 3]))

    def index(self, name):
        """The closest triangle of the object of this name."""
        return self._indices[name]

    def point(self, name):
        """Its closest point, (3,)."""
        return self._points[name]


class _Placed:
    """A tree where it is."""

    def __init__(self, mesh, transform):
        self.tree = mesh if isinstance(mesh, Tree) else Tree.from_trimesh(mesh)
        self.place(transform)

    def place(self, transform):
        transform = np.eye(4) if transform is None else np.array(transform, dtype=np.float64)
        if transform.shape != (4, 4):
            raise ValueError("transform must be (4,4)!")
        # Raises if it is not rigid: of two that are not, the relative one could be.
        collide(_NOTHING, _NOTHING, transform)
        self.transform = transform
        self.inverse = np.linalg.inv(transform)
        # The box of the box, a little larger than rounding.
        low, high = self.tree.bounds if len(self.tree) else np.zeros((2, 3))
        center = transform[:3, :3] @ ((low + high) / 2) + transform[:3, 3]
        half = np.abs(transform[:3, :3]) @ ((high - low) / 2)
        half += 1e-12 * (np.abs(center) + half)
        self.bounds = np.array([center - half, center + half])


class CollisionManager:
    """Objects by name: which of them meet, or how far apart they are.

    A mesh is a trimesh.Trimesh or a punctual3d.Tree; a tree spares the build where a mesh is asked about again and again.
    """

    def __init__(self):
        self._objects = {}

    def add_object(self, name, mesh, transform=None):
        """Adds an object, or replaces that of the same name; transform: (4, 4), rigid."""
        self._objects[name] = _Placed(mesh, transform)

    def remove_object(self, name):
        """Removes an object. Raises ValueError if there is none of this name."""
        self._get(name)
        del self._objects[name]

    def set_transform(self, name, transform):
        """Moves an object. Raises ValueError if there is none of this name."""
        self._get(name).place(transform)

    def in_collision_single(self, mesh, transform=None, return_names=False, return_data=False):
        """Whether an object meets any of those here; then the set of their names, and a list of ContactData."""
        other = {_EXTERNAL: _Placed(mesh, transform)}
        hit, names, data = _collide(_between(self._objects, other), return_names or return_data, return_data)
        return _pack(hit, (return_names, {name for name, _ in names}), (return_data, data))

    def in_collision_internal(self, return_names=False, return_data=False):
        """Whether any two objects meet; then the set of their names, each pair sorted, and a list of ContactData."""
        hit, names, data = _collide(_within(self._objects), return_names or return_data, return_data)
        return _pack(hit, (return_names, {tuple(sorted(pair)) for pair in names}), (return_data, data))

    def in_collision_other(self, other_manager, return_names=False, return_data=False):
        """Whether any object meets one of another manager; then the set of their names, and a list of ContactData."""
        candidates = _between(self._objects, other_manager._objects)
        hit, names, data = _collide(candidates, return_names or return_data, return_data)
        return _pack(hit, (return_names, names), (return_data, data))

    def min_distance_single(self, mesh, transform=None, return_name=False, return_data=False):
        """The distance of an object to the closest of those here; then its name, and DistanceData."""
        least, names, data = _distance(_between(self._objects, {_EXTERNAL: _Placed(mesh, transform)}))
        return _pack(least, (return_name, names and names[0]), (return_data, data))

    def min_distance_internal(self, name=None, return_names=False, return_data=False):
        """The least distance of two objects, or of the named one to the others; then their names, and DistanceData."""
        if name is None:
            candidates = _within(self._objects)
        else:
            others = {other: item for other, item in self._objects.items() if other != name}
            candidates = _between({name: self._get(name)}, others)
        least, names, data = _distance(candidates)
        return _pack(least, (return_names, names and tuple(sorted(names))), (return_data, data))

    def min_distance_other(self, other_manager, return_names=False, return_data=False):
        """The least distance to an object of another manager; then the pair of names, and DistanceData."""
        least, names, data = _distance(_between(self._objects, other_manager._objects))
        return _pack(least, (return_names, names), (return_data, data))

    def _get(self, name):
        if name not in self._objects:
            raise ValueError(f"{name} not in collision manager!")
        return self._objects[name]


def _pack(answer, *parts):
    asked = tuple(part for wanted, part in parts if wanted)
    return (answer, *asked) if asked else answer


def _between(left, right):
    """Two lists of named objects, and the distances of their boxes, (N, M)."""
    left, right = list(left.items()), list(right.items())
    a, b = (np.array([item.bounds for _, item in side]).reshape(-1, 2, 3) for side in (left, right))
    gaps = np.maximum(a[:, None, 0] - b[None, :, 1], b[None, :, 0] - a[:, None, 1]).clip(min=0)
    return left, right, np.linalg.norm(gaps, axis=-1)


def _within(objects):
    """The same of one set of objects, with each pair once: the others are infinitely far apart."""
    left, right, gaps = _between(objects, objects)
    gaps[np.tri(len(left), dtype=bool)] = np.inf
    return left, right, gaps


def _collide(candidates, return_all, return_data):
    """Whether a pair meets; if all are wanted, the names of those that do, and ContactData of their triangles."""
    left, right, gaps = candidates
    names, data = set(), []
    for i, j in np.argwhere(gaps == 0):
        (name_a, a), (name_b, b) = left[i], right[j]
        found = collide(a.tree, b.tree, a.inverse @ b.transform, mode="all" if return_data else "any")
        if found:
            if not return_all:
                return True, names, data
            names.add((name_a, name_b))
            if return_data:
                data += [ContactData((name_a, name_b), triangles) for triangles in found.pairs.tolist()]
    return bool(names), names, data


def _distance(candidates):
    """The least distance, infinite without a pair; the names of the closest pair, and where it is closest."""
    left, right, gaps = candidates
    least, names, data = np.inf, None, None
    for place in np.argsort(gaps, axis=None):
        i, j = np.unravel_index(place, gaps.shape)
        if gaps[i, j] >= least:
            break
        (name_a, a), (name_b, b) = left[i], right[j]
        found = distance(a.tree, b.tree, a.inverse @ b.transform)
        if found.high < least:
            least, names = found.high, (name_a, name_b)
            data = DistanceData(names, found, a.transform)
    return least, names, data
