"""Arguments that cannot be used."""

import numpy as np
import punctual
import pytest


def changed(row, column, entry):
    matrix = np.eye(4)
    matrix[row, column] = entry
    return matrix


@pytest.mark.parametrize("ask", [punctual.collide, punctual.distance, punctual.Query, punctual.DistanceQuery])
@pytest.mark.parametrize(
    "given, error, text",
    [
        (np.zeros((4, 4)), ValueError, r"T: row 3 is \[0.0, 0.0, 0.0, 0.0\], expected \[0, 0, 0, 1\]"),
        (np.diag([0.0, 0, 0, 1]), ValueError, "T: matrix is off a rotation by"),
        (np.diag([1.0, 1, -1, 1]), ValueError, "T: matrix is off a rotation by"),
        (np.eye(3), ValueError, r"T: shape \[3, 3\], expected \(4, 4\)"),
        (np.zeros((2, 4, 4)), ValueError, r"T: shape \[2, 4, 4\], expected \(4, 4\)"),
        (changed(0, 1, np.nan), ValueError, r"T: entry 1 of the pose \[R\|t\], row by row, is not finite"),
        (changed(2, 3, np.inf), ValueError, "T: entry 11 of"),
        (changed(1, 3, 1e302), ValueError, r"T: translation along axis 1 exceeds 2\^1000"),
        ("here", TypeError, "T: dtype <U4, expected real numbers"),
        (np.eye(4) * 1j, TypeError, "T: dtype complex128, expected real numbers"),
    ],
)
def test_transforms(ball, ask, given, error, text):
    with pytest.raises(error, match=text):
        ask(ball, ball, given)


def test_transforms_of_any_type(ball, ring, touching):
    for T in (
        touching.astype("f4"),
        touching.astype(int),
        touching.tolist(),
        touching.astype(">f8"),
        np.asfortranarray(touching),
    ):
        assert punctual.collide(ball, ring, T).pairs.tolist() == punctual.collide(ball, ring, touching).pairs.tolist()
    assert punctual.collide(ball, ring, None).verdict == "separated"


@pytest.mark.parametrize(
    "options, error, text",
    [
        ({"mode": "some"}, ValueError, 'mode: "some" is none of any, all'),
        ({"mode": 3}, TypeError, "'str'"),
        ({"budget": -1e-9}, ValueError, "budget is .*, expected seconds, not negative"),
        ({"budget": float("nan")}, ValueError, "budget is NaN"),
        ({"budget": "soon"}, TypeError, "real number"),
        ({"budget": 1.0, "work": 1}, ValueError, "only one of them"),
        ({"work": -1}, OverflowError, "negative"),
        ({"work": 1.5}, TypeError, "integer"),
        ({"prior": 1.5}, ValueError, "prior is 1.5, expected a share"),
        ({"memory": 1}, TypeError, "'Memory'"),
        ({"limit": 1}, TypeError, "limit"),
    ],
)
def test_options_of_queries(ball, options, error, text):
    with pytest.raises(error, match=text):
        punctual.collide(ball, ball, **options)


@pytest.mark.parametrize(
    "options, text",
    [
        ({"absolute_tolerance": -1.0}, "absolute_tolerance is -1, expected a number that is not negative"),
        ({"relative_tolerance": float("nan")}, "relative_tolerance is NaN"),
        ({"margins": [0.0, -0.1]}, r"margins\[1\] is -0.1"),
        ({"margins": [float("inf"), 0.0]}, r"margins\[0\] is inf, expected a finite number"),
        ({"absolute_tolerance": float("inf")}, "absolute_tolerance is inf"),
        ({"relative_tolerance": float("inf")}, "relative_tolerance is inf"),
        ({"margins": [0.1]}, "expected a sequence of length 2"),
    ],
)
def test_options_of_distances(ball, options, text):
    with pytest.raises(ValueError, match=text):
        punctual.distance(ball, ball, **options)
    with pytest.raises(ValueError, match="length is -1"):
        punctual.closer_than(ball, ball, -1.0)


def test_trees_are_trees(ball):
    with pytest.raises(TypeError, match="Tree"):
        punctual.collide(ball, ball.vertices)
    with pytest.raises(AttributeError, match="vertices"):
        punctual.Tree.from_trimesh(3)
