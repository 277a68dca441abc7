"""Generated trees, for first steps and tests."""

from ._punctual3d import cuboid, icosphere, torus, torus_knot

__all__ = ["cuboid", "icosphere", "torus", "torus_knot"]
