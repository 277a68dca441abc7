"""Meshes in, trees out: every kind of array, files, bytes, pickles."""

import copy
import pickle
import threading

import numpy as np
import punctual3d
import pytest
from conftest import FIXTURES

CORNERS = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.1]]


@pytest.mark.parametrize("vertices", ["f2", "f4", "f8", ">f8", "i4", "u1"])
@pytest.mark.parametrize("faces", ["i8", "u8", "i4", "u4", "u1", ">i8"])
def test_any_type_of_numbers(vertices, faces):
    given = np.array(CORNERS).astype(vertices)
    tree = punctual3d.Tree(given, np.array([[0, 1, 2]], dtype=faces))
    assert (tree.vertices == given).all() and tree.faces.tolist() == [[0, 1, 2]]
    assert len(tree) == 1 and tree.faces.dtype == np.uint32


def test_any_layout_of_arrays():
    vertices, faces = np.array(CORNERS), np.array([[0, 1, 2], [2, 1, 0]])
    padded = np.zeros((6, 5))
    padded[::2, 1:4] = vertices
    for v, f in [
        (CORNERS, [[0, 1, 2], [2, 1, 0]]),
        (padded[::2, 1:4], np.asfortranarray(faces)),
        (np.ascontiguousarray(vertices[::-1])[::-1], faces[:, ::-1][:, ::-1]),
        (vertices.T.copy().T, tuple(map(tuple, faces))),
    ]:
        tree = punctual3d.Tree(v, f)
        assert tree.vertices.tolist() == CORNERS and tree.faces.tolist() == faces.tolist()


@pytest.mark.parametrize("vertices, faces", [([], []), (CORNERS, []), (CORNERS, np.zeros((0, 3), int))])
def test_no_triangles(vertices, faces):
    tree = punctual3d.Tree(vertices, faces)
    assert len(tree) == 0 and tree.bounds is None and tree.vertices.shape == (len(vertices), 3)
    assert not punctual3d.collide(tree, tree)
    nothing = punctual3d.distance(tree, tree)
    assert nothing.low == np.inf and nothing.points is None and nothing.triangles is None


@pytest.mark.parametrize(
    "vertices, faces, error, text",
    [
        (CORNERS, [[0, 1, 2], [0, 3, 1]], ValueError, "corner 1 of triangle 1 is vertex 3, but there are 3 vertices"),
        (CORNERS, [[0, 1, -1]], ValueError, "corner 2 of triangle 0 is vertex -1, but there are 3 vertices"),
        (CORNERS, [[0, 1, 2**40]], ValueError, f"corner 2 of triangle 0 is vertex {2**40}, but"),
        (CORNERS, [[0, 1, 2, 0]], ValueError, r"faces: shape \[1, 4\], expected \(N, 3\)"),
        (CORNERS, [0, 1, 2], ValueError, r"faces: shape \[3\], expected \(N, 3\)"),
        (CORNERS, [[0.0, 1.0, 2.0]], TypeError, "faces: dtype float64, expected integers"),
        ([[0, 0], [1, 1]], [[0, 1, 0]], ValueError, r"vertices: shape \[2, 2\], expected \(N, 3\)"),
        ([[0, 0, 0], [1, np.nan, 0]], [[0, 1, 0]], ValueError, "vertex 1 is not finite along axis 1"),
        ([[0, 0, 0], [1, 0, np.inf]], [[0, 1, 0]], ValueError, "vertex 1 is not finite along axis 2"),
        ([[0, 0, 0], [1, 0, 1e302]], [[0, 1, 0]], ValueError, r"vertex 1 exceeds 2\^1000 along axis 2"),
        (np.array(CORNERS) * 1j, [[0, 1, 2]], TypeError, "vertices: dtype complex128, expected real numbers"),
        ("mesh", [[0, 1, 2]], TypeError, "vertices: dtype <U4, expected real numbers"),
    ],
)
def test_faults_name_the_place(vertices, faces, error, text):
    with pytest.raises(error, match=text):
        punctual3d.Tree(vertices, faces)


def test_effort_changes_the_tree_and_no_answer(ball, ring, touching):
    for effort in ("fast", "normal"):
        tree = punctual3d.Tree(ring.vertices, ring.faces, effort=effort)
        assert punctual3d.collide(ball, tree, touching, mode="all").found == 166
    with pytest.raises(ValueError, match='effort: "most" is none of fast, normal'):
        punctual3d.Tree(CORNERS, [[0, 1, 2]], effort="most")


def test_extremes_are_kept_on_request(ball, ring, touching):
    kept = [punctual3d.Tree(tree.vertices, tree.faces, extremes=True) for tree in (ball, ring)]
    assert all(more.nbytes > tree.nbytes + 9000 for more, tree in zip(kept, (ball, ring)))
    assert punctual3d.Tree.from_bytes(kept[0].to_bytes()).nbytes == kept[0].nbytes
    assert punctual3d.collide(*kept, touching, mode="all").found == 166


def test_files(tmp_path):
    case = FIXTURES / "single_vs_mesh"
    tree = punctual3d.Tree.load(case / "b.obj")
    assert len(tree) > 100 and len(punctual3d.Tree.load(str(case / "b.obj"))) == len(tree)
    with pytest.raises(OSError, match="missing.obj: No such file"):
        punctual3d.Tree.load(tmp_path / "missing.obj")
    broken = tmp_path / "broken.obj"
    broken.write_text("v 0 0 0\nv 1 0 x\n")
    with pytest.raises(OSError, match="broken.obj:2: "):
        punctual3d.Tree.load(broken)
    odd = tmp_path / "odd.obj"
    odd.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\n")
    with pytest.warns(UserWarning, match="odd.obj:5: face of fewer than 3 corners passed over"):
        assert len(punctual3d.Tree.load(odd)) == 1


def test_bytes_and_pickles(ball, ring, touching):
    whole = punctual3d.collide(ball, ring, touching, mode="all")
    for other in (punctual3d.Tree.from_bytes(ring.to_bytes()), pickle.loads(pickle.dumps(ring)), copy.deepcopy(ring)):
        assert other.to_bytes() == ring.to_bytes()
        again = punctual3d.collide(ball, other, touching, mode="all")
        assert again.pairs.tolist() == whole.pairs.tolist() and again.work == whole.work
    with pytest.raises(ValueError, match="do not begin with PUNCTREE"):
        punctual3d.Tree.from_bytes(b"no tree")
    damaged = bytearray(ring.to_bytes())
    damaged[1000] ^= 1
    with pytest.raises(ValueError, match="checksum"):
        punctual3d.Tree.from_bytes(bytes(damaged))


def test_refit(ball, ring):
    tree = punctual3d.Tree(ball.vertices, ball.faces)
    scene = punctual3d.Scene()
    scene.insert(tree)
    scene.insert(ring)
    assert scene.step().verdict.tolist() == [0]
    tree.refit(ball.vertices * 1.6)
    assert punctual3d.collide(tree, ring) and not punctual3d.collide(ball, ring)
    assert scene.step().verdict.tolist() == [0]
    with pytest.raises(ValueError, match="1 new vertices for a mesh with 642"):
        tree.refit([[0, 0, 0]])


def test_scaled_and_mirrored_trees(ball, tmp_path):
    mirrored = ball.scaled((1, 2, -0.5))
    assert np.array_equal(mirrored.vertices, ball.vertices * [1, 2, -0.5])
    assert np.array_equal(mirrored.faces, ball.faces[:, [0, 2, 1]])
    assert punctual3d.Tree(mirrored.vertices, mirrored.faces, solid="keep").volume > 0
    with pytest.raises(ValueError, match="factor 0 along axis 1"):
        ball.scaled((1, 0, 1))
    file = tmp_path / "one.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 2\nf 1 2 3\n")
    assert punctual3d.Tree.load(file, scale=(1, 1, -1)).vertices[2].tolist() == [0, 1, -2]
    with pytest.raises(ValueError, match="scale NaN, must be finite and not 0"):
        punctual3d.Tree.load(file, scale=(1, 1, float("nan")))


def test_self_intersections_and_degradation(ball):
    assert ball.self_intersections().shape == (0, 2) and ball.degradation == 1.0
    crossed = punctual3d.Tree([*CORNERS, [0.1, 0.1, -1], [0.1, 0.1, 1], [5, 5, 0]], [[0, 1, 2], [3, 4, 5]])
    assert crossed.self_intersections().tolist() == [[0, 1]]
    tree = punctual3d.Tree(ball.vertices, ball.faces)
    tree.refit(ball.vertices[::-1])
    assert tree.degradation > 1.5


def test_facts(ball):
    assert repr(ball) == "<punctual3d.Tree of 1280 triangles>"
    assert ball.depth >= 3 and ball.nbytes > 1280 * 12
    assert np.allclose(ball.bounds, [[-1] * 3, [1] * 3], atol=0.05)


def test_closest_points_of_surfaces_and_solids():
    random = np.random.default_rng(6)
    ball = punctual3d.shapes.icosphere(3)
    open_faces = ball.faces[ball.vertices[ball.faces].mean(axis=1)[:, 2] < 0.5]
    points = np.vstack([random.normal(size=(300, 3)), ball.vertices[:20], 1e6 * random.normal(size=(20, 3))])
    for tree in (ball, punctual3d.Tree(ball.vertices, open_faces), punctual3d.Tree(ball.vertices, ball.faces, solid="keep")):
        places, distances, triangles = tree.closest_points(points)
        assert np.allclose(np.linalg.norm(points - places, axis=1), distances, rtol=1e-13, atol=0)
        # On the triangle that is named, and none is closer.
        a, b, c = (tree.vertices[tree.faces[triangles]][:, i] for i in range(3))
        normals = np.cross(b - a, c - a)
        assert np.abs(((places - a) * normals).sum(axis=1)).max() < 1e-13
        for x, y, z in ((a, b, c), (b, c, a), (c, a, b)):
            assert (np.einsum("ij,ij->i", np.cross(y - x, places - x), normals) > -1e-12).all()
        corners = tree.vertices[np.unique(tree.faces)]
        assert (np.linalg.norm(points[:, None] - corners[None], axis=2).min(axis=1) >= distances * (1 - 1e-12)).all()
        again = tree.closest_points(points, threads=3)
        assert all(np.array_equal(x, y) for x, y in zip((places, distances, triangles), again))
        if tree.open_edges is not None:
            assert np.allclose(np.abs(tree.signed_distance(points)), distances, rtol=1e-12, atol=1e-15)
    places, distances, triangles = punctual3d.Tree([], []).closest_points([1, 2, 3])
    assert np.isnan(places).all() and distances.tolist() == [np.inf] and triangles.tolist() == [-1]
    for empty in ([], np.zeros((0, 3))):
        assert [len(x) for x in ball.closest_points(empty)] == [0, 0, 0]
    with pytest.raises(ValueError, match="point 1: .*not finite|point 1: "):
        ball.closest_points([[0, 0, 0], [0, np.nan, 0]])


def test_a_refit_while_another_thread_asks_names_the_tree():
    tree, errors, began = punctual3d.shapes.icosphere(6), [], threading.Event()
    poses = np.tile(np.eye(4), (12, 1, 1))
    asking = threading.Thread(
        target=lambda: punctual3d.collide_batch(tree, tree, poses, mode="all", progress=lambda *_: began.set())
    )
    asking.start()
    began.wait()
    try:
        tree.refit(tree.vertices)
    except RuntimeError as error:
        errors.append(str(error))
    asking.join()
    (error,) = errors
    assert f"Tree of {len(tree)} triangles> at 0x" in error and "asked about by another thread" in error
    tree.refit(tree.vertices)
