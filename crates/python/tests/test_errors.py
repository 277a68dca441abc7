"""Arguments that cannot be used."""

import numpy as np
import punctual3d
import pytest


def changed(row, column, entry):
    matrix = np.eye(4)
    matrix[row, column] = entry
    return matrix


@pytest.mark.parametrize("ask", [punctual3d.collide, punctual3d.distance, punctual3d.Query, punctual3d.DistanceQuery])
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
        assert punctual3d.collide(ball, ring, T).pairs.tolist() == punctual3d.collide(ball, ring, touching).pairs.tolist()
    assert punctual3d.collide(ball, ring, None).verdict == "separated"


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
        punctual3d.collide(ball, ball, **options)


@pytest.mark.parametrize(
    "options, text",
    [
        ({"absolute_tolerance": -1.0}, "absolute_tolerance is -1, expected a number that is not negative"),
        ({"relative_tolerance": float("nan")}, "relative_tolerance is NaN"),
        ({"margins": [0.0, -0.1]}, r"margins\[1\] is -0.1"),
        ({"margins": [float("inf"), 0.0]}, r"margins\[0\] is inf, expected a finite number"),
        ({"absolute_tolerance": float("inf")}, "absolute_tolerance is inf"),
        ({"relative_tolerance": float("inf")}, "relative_tolerance is inf"),
        ({"margins": [0.1]}, r"margins: shape \[1\], expected \(2,\)"),
    ],
)
def test_options_of_distances(ball, options, text):
    with pytest.raises(ValueError, match=text):
        punctual3d.distance(ball, ball, **options)
    with pytest.raises(ValueError, match="length is -1"):
        punctual3d.closer_than(ball, ball, -1.0)


def test_vectors_name_their_argument(ball):
    scene = punctual3d.Scene()
    body = scene.insert(ball)
    for call, text in [
        (lambda: punctual3d.motion(ball, ball, velocity=[1.0, 2.0]), r"velocity: shape \[2\], expected \(3,\)"),
        (lambda: punctual3d.motion(ball, ball, turn=np.zeros((1, 3))), r"turn: shape \[1, 3\], expected \(3,\)"),
        (lambda: punctual3d.motion(ball, ball, turn=[0, 0, 1], point=3.0), r"point: shape \[\], expected \(3,\)"),
        (lambda: scene.set_motion(body, np.eye(4), velocity=[]), r"velocity: shape \[0\], expected \(3,\)"),
        (lambda: scene.cast([0, 0], [1, 0, 0]), r"origin: shape \[2\], expected \(3,\)"),
        (lambda: scene.cast([0, 0, 0], end=np.zeros(4)), r"end: shape \[4\], expected \(3,\)"),
        (lambda: punctual3d.shapes.cuboid([1, 1], 2), r"half_extents: shape \[2\], expected \(3,\)"),
        (lambda: punctual3d.rays(ball, np.zeros((5, 0)), [1, 0, 0]), r"origins: shape \[5, 0\], expected \(N, 3\)"),
        (lambda: punctual3d.collide_batch(ball, ball, np.zeros((3, 0, 4))), r"poses: shape \[3, 0, 4\], expected"),
        (lambda: punctual3d.collide_batch(ball, ball, np.eye(3)), r"poses: shape \[3, 3\], expected \(N, 4, 4\) or"),
    ]:
        with pytest.raises(ValueError, match=text):
            call()
    with pytest.raises(TypeError, match="velocity: dtype complex128, expected real numbers"):
        punctual3d.motion(ball, ball, velocity=np.array([1j, 0, 0]))
    with pytest.raises(ValueError, match="velocity|not finite"):
        punctual3d.motion(ball, ball, velocity=[np.nan, 0, 0])


def test_vectors_of_any_type(ball, ring):
    said = punctual3d.motion(ball, ring, velocity=[2.0, 0.0, 0.0])
    read_only = np.array([2.0, 0.0, 0.0, 7.0])[:3]
    read_only.flags.writeable = False
    for velocity in ((2, 0, 0), read_only, np.array([2, 0, 0], ">i2"), np.array([[2.0, 0], [0, 0], [0, 0]])[:, 0]):
        assert punctual3d.motion(ball, ring, velocity=velocity) == said
    assert punctual3d.distance(ball, ring, margins=np.float32([0.5, 0.25])) == punctual3d.distance(
        ball, ring, margins=[0.5, 0.25]
    )


def test_trees_are_trees_or_meshes(ball):
    with pytest.raises(TypeError, match="ndarray is neither a punctual3d.Tree nor a mesh with vertices"):
        punctual3d.collide(ball, ball.vertices)
    with pytest.raises(TypeError, match="NoneType is neither"):
        punctual3d.rays(None, [[0, 0, 0]], [[1, 0, 0]])
    with pytest.raises(AttributeError, match="vertices"):
        punctual3d.Tree.from_trimesh(3)
