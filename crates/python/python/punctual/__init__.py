"""Mesh collision detection that answers by the deadline, and says how sure it is.

>>> import punctual
>>> ball, ring = punctual.shapes.icosphere(3), punctual.shapes.torus(2.0, 0.5, 48)
>>> bool(punctual.collide(ball, ring))
False
>>> round(punctual.distance(ball, ring).high, 2)
0.5
"""

from . import shapes
from ._punctual import (
    Answer,
    Certificate,
    Collision,
    CollisionBatch,
    Contacts,
    Distance,
    DistanceBatch,
    DistanceEstimate,
    DistanceQuery,
    Estimate,
    Memory,
    Passage,
    Prediction,
    PushOut,
    Quantiles,
    Query,
    RayHits,
    Report,
    ResumeError,
    Scene,
    Tree,
    UndecidedError,
    View,
    __version__,
    closer_than,
    collide,
    collide_batch,
    contacts,
    distance,
    distance_batch,
    motion,
    push_out,
    rays,
)
from .collision_manager import CollisionManager

__all__ = [
    "Answer",
    "Certificate",
    "Collision",
    "CollisionBatch",
    "CollisionManager",
    "Contacts",
    "Distance",
    "DistanceBatch",
    "DistanceEstimate",
    "DistanceQuery",
    "Estimate",
    "Memory",
    "Passage",
    "Prediction",
    "PushOut",
    "Quantiles",
    "Query",
    "RayHits",
    "Report",
    "ResumeError",
    "Scene",
    "Tree",
    "UndecidedError",
    "View",
    "__version__",
    "closer_than",
    "collide",
    "collide_batch",
    "contacts",
    "distance",
    "distance_batch",
    "motion",
    "push_out",
    "rays",
    "shapes",
]
