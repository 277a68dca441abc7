"""What all answers have in common: they are pickled, copied and compared by what they say.

The compiled classes get these methods here, since each of them can have only one block of methods of its own.
"""

from __future__ import annotations

from typing import Any

from . import _punctual3d

_NAMES = [
    "Ahead",
    "BodyContacts",
    "BodyHits",
    "Certificate",
    "ClosestBody",
    "Collision",
    "CollisionBatch",
    "ContactPoints",
    "Contacts",
    "Distance",
    "DistanceBatch",
    "DistanceEstimate",
    "Estimate",
    "GroupDistances",
    "Manifolds",
    "Overlaps",
    "PairDistances",
    "PairPassages",
    "Passage",
    "Prediction",
    "Penetration",
    "Quantiles",
    "Remaining",
    "RayHits",
    "Report",
    "RobotClearances",
    "RobotCollisions",
    "RobotEdges",
    "RobotMeetings",
    "RobotNearPairs",
    "SceneHits",
    "ShapeCast",
    "View",
]


def _reduce(self: Any) -> tuple[Any, tuple[str, str, bytes]]:
    return _punctual3d._restore, (type(self).__name__, _punctual3d.__version__, _punctual3d._state(self))


def _eq(self: Any, other: object) -> Any:
    if type(other) is not type(self):
        return NotImplemented
    return _punctual3d._state(self) == _punctual3d._state(other)


def _hash(self: Any) -> int:
    return hash(_punctual3d._state(self))


def _copy(self: Any, memo: object = None) -> Any:
    # Answers do not change.
    return self


setattr(_punctual3d.Memory, "__reduce__", _reduce)
for _name in _NAMES:
    _record = getattr(_punctual3d, _name)
    _record.__reduce__, _record.__eq__, _record.__hash__ = _reduce, _eq, _hash
    _record.__copy__ = _record.__deepcopy__ = _copy
